//! What a cut through a part would save, for all planes of a direction at once.
//!
//! Eq. 2.2, by a sweep: the plane sinks through the part, and the surface above it is kept in connected pieces (union-find over
//! the vertices). A piece counts if it is less risky along the normal of the plane than along the part's direction, and if the plane
//! cuts no section on it (constraint I).

use super::sequence::sphere;
use super::tuning::TuningOptions;
use crate::planar::CutPlane;
use crate::planar::solid::Wall;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// What counts as risky on a part.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    /// The cells that are printed before it.
    pub(super) earlier: Vec<u32>,
    pub(super) direction: Vector3<f64>,
    /// Height of the platform along the direction.
    pub(super) floor: f64,
    /// Minus the sine of the self-support angle.
    pub(super) limit: f64,
}

impl Judge {
    pub(super) fn risky(&self, walls: &[Wall]) -> f64 {
        walls
            .iter()
            .filter(|wall| self.is_risky(wall))
            .map(|wall| area_vector(&wall.places).norm())
            .fold(0.0, |sum, area| sum + area)
    }

    /// Area on earlier parts.
    pub(super) fn seam(&self, walls: &[Wall]) -> f64 {
        let is_seam = |wall: &&Wall| wall.beyond.is_some_and(|beyond| self.earlier.contains(&beyond));
        walls.iter().filter(is_seam).map(|wall| area_vector(&wall.places).norm()).fold(0.0, |sum, area| sum + area)
    }

    /// Eq. 2.1, but for what lies on earlier parts or on the platform.
    pub(super) fn is_risky(&self, wall: &Wall) -> bool {
        let vector = area_vector(&wall.places);
        vector.dot(&self.direction) < self.limit * vector.norm() && !self.is_supported(wall)
    }

    /// Whether a wall lies on an earlier part or on the platform.
    pub(super) fn is_supported(&self, wall: &Wall) -> bool {
        match wall.beyond {
            Some(beyond) => self.earlier.contains(&beyond),
            None => wall.places.iter().all(|p| p.coords.dot(&self.direction) <= self.floor),
        }
    }
}

pub(super) fn area_vector([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)) / 2.0
}

/// The best planes of each normal through a part, and what each promises to save.
pub(super) fn promising(
    walls: &[Wall],
    judge: &Judge,
    foot: Point3<f64>,
    up: &Vector3<f64>,
    options: &TuningOptions,
) -> Vec<(f64, CutPlane)> {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), up)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let surface = Surface::new(walls);
    let mut planes = Vec::new();
    // Constraint II: those that look up.
    let tried = if options.head.is_some() { 2 * options.normals } else { options.normals };
    for normal in sphere(2 * options.normals).take(tried).map(|n| turn * n) {
        // Its section would be risky itself.
        if normal.dot(&judge.direction) >= judge.limit {
            let upward = Judge { direction: normal, floor: f64::NEG_INFINITY, ..judge.clone() };
            let head = |p: &Point3<f64>| options.head.is_some_and(|head| head.is_in_platform(p, &normal, &foot, up));
            let blocked: Vec<bool> = surface.places.iter().map(head).collect();
            let mut gains = surface.sweep(walls, judge, &upward, &blocked, options);
            gains.sort_by(|a, b| b.0.total_cmp(&a.0));
            let made = gains.into_iter().take(PLANES_PER_NORMAL).filter_map(|(gain, offset)| {
                Some((gain, CutPlane::through(&Point3::from(normal * offset), &normal).ok()?))
            });
            planes.extend(made);
        }
    }
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    planes
}

/// Planes of one normal that are kept: neighbours promise about the same.
const PLANES_PER_NORMAL: usize = 2;

/// The surface of a part with vertices of its own.
struct Surface {
    places: Vec<Point3<f64>>,
    corners: Vec<[u32; 3]>,
    /// For each vertex a section on it; none, or one of several.
    sections: Vec<Vec<u32>>,
}

impl Surface {
    fn new(walls: &[Wall]) -> Self {
        let mut ids: Vec<u32> = walls.iter().flat_map(|wall| wall.corners).collect();
        ids.sort_unstable();
        ids.dedup();
        let own = |v: u32| ids.binary_search(&v).unwrap_or(0) as u32;
        let mut surface = Surface {
            places: vec![Point3::origin(); ids.len()],
            corners: Vec::new(),
            sections: vec![Vec::new(); ids.len()],
        };
        for wall in walls {
            let corners = wall.corners.map(own);
            for (&v, &place) in corners.iter().zip(&wall.places) {
                surface.places[v as usize] = place;
                let sections = &mut surface.sections[v as usize];
                sections.extend(wall.beyond.filter(|beyond| !sections.contains(beyond)));
            }
            surface.corners.push(corners);
        }
        surface
    }

    /// For planes from the top down: what each saves, and its offset.
    ///
    /// Pieces with a vertex that is `blocked` stay.
    fn sweep(
        &self,
        walls: &[Wall],
        judge: &Judge,
        upward: &Judge,
        blocked: &[bool],
        options: &TuningOptions,
    ) -> Vec<(f64, f64)> {
        let spacing = options.spacing;
        let heights: Vec<f64> = self.places.iter().map(|p| p.coords.dot(&upward.direction)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let count = ((high - low) / spacing) as usize;
        let offset = |l: usize| low + (l as f64 + 0.5) * spacing;
        // The highest plane below a height, plus one: 0 if there is none.
        let planes_below = |h: f64| ((((h - low) / spacing - 0.5).ceil()).max(0.0) as usize).min(count);

        let mut vertices_at = vec![Vec::new(); count + 1];
        for (v, &h) in heights.iter().enumerate() {
            vertices_at[planes_below(h)].push(v as u32);
        }
        let mut sections: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for (of_vertex, &h) in self.sections.iter().zip(&heights) {
            for &section in of_vertex {
                let range = sections.entry(section).or_insert([h, h]);
                *range = [range[0].min(h), range[1].max(h)];
            }
        }
        sections.retain(|section, _| options.keep_sections_apart || judge.earlier.contains(section));
        // Facets by the planes that their lowest and highest corners lie above.
        let mut whole_at = vec![Vec::new(); count + 1];
        let mut crossed_at = vec![Vec::new(); count + 1];
        let mut edges_at = vec![Vec::new(); count + 1];
        for (f, corners) in self.corners.iter().enumerate() {
            let mut h = corners.map(|v| heights[v as usize]);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                // Each edge is passed in both directions.
                if a < b {
                    edges_at[planes_below(h[k].min(h[(k + 1) % 3]))].push([a, b]);
                }
            }
            let signs = [judge.is_risky(&walls[f]), upward.is_risky(&walls[f])];
            let vector = area_vector(&walls[f].places);
            let saved = (f64::from(u8::from(signs[0])) - f64::from(u8::from(signs[1]))) * vector.norm();
            // What is above a plane is closed by its section, so the area of that is what all facets add up to against the normal.
            let saved = saved + options.seam_cost * vector.dot(&upward.direction);
            h.sort_by(f64::total_cmp);
            let (lowest, highest) = (planes_below(h[0]), planes_below(h[2]));
            whole_at[lowest].push((corners[0], saved));
            let higher = |a: u32, b: u32| if heights[b as usize] > heights[a as usize] { b } else { a };
            let top = higher(higher(corners[0], corners[1]), corners[2]);
            (lowest..highest).for_each(|l| crossed_at[l].push((top, saved, h)));
        }

        let parent = (0..heights.len() as u32).collect();
        let mut pieces = Pieces { parent, saved: vec![0.0; heights.len()], blocked: blocked.to_vec() };
        let mut gains = Vec::new();
        let mut roots: Vec<u32> = Vec::new();
        for l in (0..count).rev() {
            // Above plane l is what lies above plane l + 1, and what has l + 1 planes below.
            roots.extend(&vertices_at[l + 1]);
            edges_at[l + 1].iter().for_each(|&[a, b]| pieces.join(a, b));
            for &(v, saved) in &whole_at[l + 1] {
                let root = pieces.root(v);
                pieces.saved[root as usize] += saved;
            }
            let mut partly: BTreeMap<u32, f64> = BTreeMap::new();
            for &(v, saved, h) in &crossed_at[l] {
                *partly.entry(pieces.root(v)).or_default() += saved * (1.0 - share_below(h, offset(l)));
            }
            roots.iter_mut().for_each(|v| *v = pieces.root(*v));
            roots.sort_unstable();
            roots.dedup();
            // Pieces with a section that the plane cuts stay.
            let cut: Vec<u32> =
                sections.iter().filter(|(_, r)| r[0] < offset(l) && r[1] > offset(l)).map(|s| *s.0).collect();
            let mut barred = Vec::new();
            if !cut.is_empty() {
                for (v, of_vertex) in self.sections.iter().enumerate() {
                    if heights[v] > offset(l) && of_vertex.iter().any(|section| cut.contains(section)) {
                        barred.push(pieces.root(v as u32));
                    }
                }
                barred.sort_unstable();
                barred.dedup();
            }
            let saved = |root: &u32| pieces.saved[*root as usize] + partly.get(root).copied().unwrap_or(0.0);
            let is_free = |root: &u32| barred.binary_search(root).is_err() && !pieces.blocked[*root as usize];
            let free = roots.iter().filter(|root| is_free(root));
            gains.push((free.map(saved).filter(|saved| *saved > 0.0).sum(), offset(l)));
        }
        gains
    }
}

/// Connected vertices, and what cutting them off saves.
struct Pieces {
    parent: Vec<u32>,
    saved: Vec<f64>,
    /// Whether the head does not reach some vertex.
    blocked: Vec<bool>,
}

impl Pieces {
    fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let above = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = above;
            v = above;
        }
        v
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            self.parent[b as usize] = a;
            self.saved[a as usize] += std::mem::take(&mut self.saved[b as usize]);
            self.blocked[a as usize] |= self.blocked[b as usize];
        }
    }
}

/// The share of a triangle's area below a height, from the sorted heights of its corners.
fn share_below(h: [f64; 3], z: f64) -> f64 {
    if z <= h[0] {
        0.0
    } else if z >= h[2] {
        1.0
    } else if z <= h[1] {
        (z - h[0]).powi(2) / ((h[1] - h[0]) * (h[2] - h[0]))
    } else {
        1.0 - (h[2] - z).powi(2) / ((h[2] - h[1]) * (h[2] - h[0]))
    }
}
