//! What a cut through a part would save, for all planes of a direction at once.
//!
//! Eq. 2.2, by a sweep: the plane sinks through the part, and the surface above it is kept in connected pieces (union-find over
//! the vertices). A piece counts if it is less risky along the normal of the plane than along the part's direction, and if the plane
//! cuts no section on it (constraint I). What does not depend on the normal is prepared once, and of a normal only facets that are
//! risky in one of both directions are looked at.

use super::options::TuningOptions;
use super::risk::{RiskModel, area_vector};
use super::sequence::sphere;
use crate::parallel::map_items;
use crate::planar::CutPlane;
use crate::planar::solid::Wall;
use crate::union_find::UnionFind;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// The best planes of each normal through a part, and what each promises to save: nothing that promises less than `least`.
pub(super) fn promising(
    walls: &[Wall],
    judge: &RiskModel,
    foot: Point3<f64>,
    up: &Vector3<f64>,
    options: &TuningOptions,
    least: f64,
) -> Vec<(f64, CutPlane)> {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), up)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let surface = Surface::new(walls, judge);
    // Constraint II: those that look up.
    let tried = if options.head.is_some() { 2 * options.normals } else { options.normals };
    // The section of others would be risky itself.
    let normals: Vec<Vector3<f64>> = sphere(2 * options.normals)
        .take(tried)
        .map(|n| turn * n)
        .filter(|normal| normal.dot(&judge.direction) >= judge.limit)
        .collect();
    let of_normal = |normal: &Vector3<f64>| {
        let saving = surface.saving(normal, judge.limit, options.seam_cost);
        if saving.iter().map(|&(_, saved)| saved.max(0.0)).sum::<f64>() < least {
            return Vec::new();
        }
        let mut pieces = Pieces::new(surface.places.len());
        if let Some(head) = options.head {
            pieces.blocked = surface.places.iter().map(head.in_platform(normal, &foot, up)).collect();
        }
        let mut gains = surface.sweep(normal, &saving, pieces, options);
        gains.retain(|&(gain, _)| gain >= least);
        gains.sort_by(|a, b| b.0.total_cmp(&a.0));
        gains.truncate(PLANES_PER_NORMAL);
        let plane = |(gain, offset)| Some((gain, CutPlane::through(&Point3::from(normal * offset), normal).ok()?));
        gains.into_iter().filter_map(plane).collect()
    };
    let mut planes = map_items(&normals, of_normal).concat();
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    planes
}

/// Planes of one normal that are kept: neighbours promise about the same.
const PLANES_PER_NORMAL: usize = 2;

/// A facet of a part.
struct Facet {
    corners: [u32; 3],
    vector: Vector3<f64>,
    area: f64,
    /// Along the direction of the part.
    is_risky: bool,
    on_earlier: bool,
}

/// The surface of a part with vertices of its own.
struct Surface {
    places: Vec<Point3<f64>>,
    facets: Vec<Facet>,
    /// The neighbours of vertex `v` are those from number `first[v]` to `first[v + 1]`, in the order around it, each with the one before.
    /// One without a neighbour before it begins an order anew; then that one is a vertex that is not there, behind the last one.
    first: Vec<u32>,
    neighbours: Vec<[u32; 2]>,
    /// For each cell beyond, whether it is earlier, and the vertices of the section with it.
    sections: Vec<(bool, Vec<u32>)>,
    /// The vertices of what lies on earlier parts or on the platform.
    supports: Vec<u32>,
}

impl Surface {
    fn new(walls: &[Wall], judge: &RiskModel) -> Self {
        let most = walls.iter().flat_map(|wall| wall.corners).max().map_or(0, |v| v as usize + 1);
        let mut number = vec![u32::MAX; most];
        let mut places = Vec::new();
        let mut facets = Vec::with_capacity(walls.len());
        let mut sections: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut supports = Vec::new();
        for wall in walls {
            let mut corners = [0; 3];
            for k in 0..3 {
                let known = &mut number[wall.corners[k] as usize];
                if *known == u32::MAX {
                    *known = places.len() as u32;
                    places.push(wall.places[k]);
                }
                corners[k] = *known;
            }
            if let Some(beyond) = wall.beyond {
                sections.entry(beyond).or_default().extend(corners);
            }
            if judge.is_supported(wall) {
                supports.extend(corners);
            }
            let vector = area_vector(&wall.places);
            facets.push(Facet {
                corners,
                vector,
                area: vector.norm(),
                is_risky: judge.is_risky(wall),
                on_earlier: wall.beyond.is_some_and(|beyond| judge.earlier.contains(&beyond)),
            });
        }
        let (first, neighbours) = neighbours(places.len(), &facets);
        let section = |(beyond, mut vertices): (u32, Vec<u32>)| {
            vertices.sort_unstable();
            vertices.dedup();
            (judge.earlier.contains(&beyond), vertices)
        };
        let sections = sections.into_iter().map(section).collect();
        supports.sort_unstable();
        supports.dedup();
        Surface { places, facets, first, neighbours, sections, supports }
    }

    /// The facets whose loss to a part that is printed along a normal changes the risky area, and by how much.
    fn saving(&self, normal: &Vector3<f64>, limit: f64, seam_cost: f64) -> Vec<(u32, f64)> {
        let saved = |facet: &Facet| {
            let along = facet.vector.dot(normal);
            let stays_risky = along < limit * facet.area && !facet.on_earlier;
            let change = f64::from(u8::from(facet.is_risky)) - f64::from(u8::from(stays_risky));
            // What is above a plane is closed by its section, so the area of that is what all facets add up to against the normal.
            change * facet.area + seam_cost * along
        };
        let all = self.facets.iter().map(saved).enumerate();
        all.filter(|&(_, saved)| saved != 0.0).map(|(facet, saved)| (facet as u32, saved)).collect()
    }

    /// For planes from the top down: what each saves, and its offset.
    fn sweep(
        &self,
        normal: &Vector3<f64>,
        saving: &[(u32, f64)],
        mut pieces: Pieces,
        options: &TuningOptions,
    ) -> Vec<(f64, f64)> {
        let events = Events::new(self, normal, saving, options.spacing);
        let Events { heights, by_level, turns, .. } = &events;
        let barring = self.barring(heights, options);
        // Where nothing is left that stands there is no cut.
        let stands_to = self.supports.iter().map(|&v| heights[v as usize]).fold(f64::INFINITY, f64::min);
        let mut gains = Vec::new();
        let mut roots: Vec<u32> = Vec::new();
        // What facets that a plane crosses add to the piece of a root, and at which plane it is barred.
        let mut partly = vec![0.0; heights.len()];
        let mut barred_at = vec![u32::MAX; heights.len()];
        for l in (0..events.count).rev().take_while(|&l| events.offset(l) > stands_to) {
            let offset = events.offset(l);
            // Above plane l is what lies above plane l + 1, and what has l + 1 planes below.
            for &v in by_level.of(l + 1) {
                // Neighbours from before that follow each other are joined by then, for they share an edge: one of them is enough.
                let near = &self.neighbours[self.first[v as usize] as usize..self.first[v as usize + 1] as usize];
                let was_before = |w: u32| turns[w as usize] < turns[v as usize];
                let first = near.iter().filter(|[w, last]| was_before(*w) && !was_before(*last));
                first.for_each(|&[w, _]| pieces.join(w, v));
            }
            roots.extend(by_level.of(l + 1));
            roots.retain(|&v| pieces.sets.is_root(v));
            for &(v, saved) in &events.whole_at[l + 1] {
                let root = pieces.sets.root(v);
                pieces.saved[root as usize] += saved;
            }
            for &(v, saved, h) in &events.crossed_at[l] {
                partly[pieces.sets.root(v) as usize] += saved * (1.0 - share_below(h, offset));
            }
            // Pieces with a section that the plane cuts stay.
            for (vertices, _) in barring.iter().filter(|(_, range)| range[0] < offset && range[1] > offset) {
                for &v in vertices.iter().filter(|&&v| heights[v as usize] > offset) {
                    barred_at[pieces.sets.root(v) as usize] = l as u32;
                }
            }
            let mut gain = 0.0;
            for &root in &roots {
                let at = root as usize;
                let saved = pieces.saved[at] + std::mem::take(&mut partly[at]);
                if saved > 0.0 && barred_at[at] != l as u32 && !pieces.blocked[at] {
                    gain += saved;
                }
            }
            gains.push((gain, offset));
        }
        gains
    }

    /// Sections that no plane may cut, by their vertices, and from where to where they reach.
    fn barring(&self, heights: &[f64], options: &TuningOptions) -> Vec<(&[u32], [f64; 2])> {
        let sections = self.sections.iter().filter(|(is_earlier, _)| *is_earlier || options.keep_sections_apart);
        let with_range = |(_, vertices): &'_ (bool, Vec<u32>)| {
            let of = vertices.iter().map(|&v| heights[v as usize]);
            of.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
        };
        sections.map(|section| (section.1.as_slice(), with_range(section))).collect()
    }
}

/// What a plane meets that sinks along its normal, plane by plane: they lie a spacing apart, the lowest half of one above the lowest vertex.
struct Events {
    low: f64,
    spacing: f64,
    /// How many planes there are.
    count: usize,
    /// Heights of the vertices.
    heights: Vec<f64>,
    /// Vertices by the number of planes below them.
    by_level: Buckets,
    /// When the sweep comes to each vertex, and never to the one that is not there.
    turns: Vec<u32>,
    /// A corner of each facet and what it saves, by the number of planes below all of it.
    whole_at: Vec<Vec<(u32, f64)>>,
    /// The highest corner of each facet, what it saves, and the heights of its corners, by the planes that cross it.
    crossed_at: Vec<Vec<(u32, f64, [f64; 3])>>,
}

impl Events {
    fn new(surface: &Surface, normal: &Vector3<f64>, saving: &[(u32, f64)], spacing: f64) -> Self {
        let heights: Vec<f64> = surface.places.iter().map(|p| p.coords.dot(normal)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let count = ((high - low) / spacing) as usize;
        let level = |h: &f64| {
            let above = (h - low) / spacing - 0.5;
            // Casts round towards zero; a plane through the vertex is not below it.
            let whole = above.max(0.0) as u32;
            (whole + u32::from(f64::from(whole) < above)).min(count as u32)
        };
        let levels: Vec<u32> = heights.iter().map(level).collect();
        let by_level = Buckets::new(count + 1, levels.iter().copied());
        let mut turns = vec![u32::MAX; heights.len() + 1];
        let swept = (0..=count).rev().flat_map(|level| by_level.of(level));
        (0..).zip(swept).for_each(|(turn, &v)| turns[v as usize] = turn);
        let (mut whole_at, mut crossed_at) = (vec![Vec::new(); count + 1], vec![Vec::new(); count + 1]);
        for &(facet, saved) in saving {
            let corners = surface.facets[facet as usize].corners;
            let of = corners.map(|v| levels[v as usize]);
            let (lowest, highest) = (of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2]));
            whole_at[lowest as usize].push((corners[0], saved));
            if lowest < highest {
                let mut h = corners.map(|v| heights[v as usize]);
                let top = corners[(0..3).fold(0, |best, k| if h[k] > h[best] { k } else { best })];
                h.sort_by(f64::total_cmp);
                (lowest..highest).for_each(|l| crossed_at[l as usize].push((top, saved, h)));
            }
        }
        Events { low, spacing, count, heights, by_level, turns, whole_at, crossed_at }
    }

    /// Height of a plane.
    fn offset(&self, plane: usize) -> f64 {
        self.low + (plane as f64 + 0.5) * self.spacing
    }
}

/// The neighbours of each vertex as [`Surface`] has them.
fn neighbours(vertices: usize, facets: &[Facet]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let nobody = vertices as u32;
    let mut first = vec![0; vertices + 1];
    facets.iter().flat_map(|facet| facet.corners).for_each(|v| first[v as usize + 1] += 1);
    (0..vertices).for_each(|v| first[v + 1] += first[v]);
    let mut next = first.clone();
    // A facet leads from one neighbour of its corner to the next one. Each edge is passed in both directions, so each neighbour comes once.
    let mut steps = vec![[nobody; 2]; 3 * facets.len()];
    for Facet { corners, .. } in facets {
        for k in 0..3 {
            let at = &mut next[corners[k] as usize];
            steps[*at as usize] = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
            *at += 1;
        }
    }
    for v in 0..vertices {
        let around = &mut steps[first[v] as usize..first[v + 1] as usize];
        let [mut last, mut wanted] = [nobody; 2];
        for k in 0..around.len() {
            // Where none goes on, another fan of facets begins at the same vertex.
            let next = (k..around.len()).find(|&at| around[at][0] == wanted);
            last = if next.is_some() { last } else { nobody };
            around.swap(k, next.unwrap_or(k));
            let [from, to] = around[k];
            around[k] = [from, last];
            [last, wanted] = [from, to];
        }
    }
    (first, steps)
}

/// Numbers by a key, those of a key in their own order.
struct Buckets {
    first: Vec<u32>,
    numbers: Vec<u32>,
}

impl Buckets {
    fn new(keys: usize, key_of: impl Iterator<Item = u32> + Clone) -> Self {
        let mut first = vec![0; keys + 1];
        key_of.clone().for_each(|key| first[key as usize + 1] += 1);
        (0..keys).for_each(|key| first[key + 1] += first[key]);
        let mut next = first.clone();
        let mut numbers = vec![0; first[keys] as usize];
        for (number, key) in (0..).zip(key_of) {
            numbers[next[key as usize] as usize] = number;
            next[key as usize] += 1;
        }
        Buckets { first, numbers }
    }

    fn of(&self, key: usize) -> &[u32] {
        &self.numbers[self.first[key] as usize..self.first[key + 1] as usize]
    }
}

/// Connected vertices, and what cutting them off saves.
struct Pieces {
    sets: UnionFind,
    saved: Vec<f64>,
    /// Whether the head does not reach some vertex.
    blocked: Vec<bool>,
}

impl Pieces {
    /// Vertices that are all alone.
    fn new(vertices: usize) -> Self {
        Pieces { sets: UnionFind::new(vertices), saved: vec![0.0; vertices], blocked: vec![false; vertices] }
    }

    fn join(&mut self, a: u32, b: u32) {
        if let Some([a, b]) = self.sets.join_to(a, b) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::{Partition, Solid};

    /// Slow twin: rows of points of the triangle with these heights of its corners.
    #[test]
    fn the_share_below_a_height_is_that_of_its_points() {
        const ROWS: usize = 600;
        for heights in [[0.0, 1.0, 3.0], [1.0, 2.0, 4.0], [-2.0, -2.0, 0.5], [1.0, 5.0, 5.0]] {
            let [a, b, c] = heights;
            for step in -1..=11 {
                let z = a + (c - a) * f64::from(step) / 10.0;
                let shares = (0..ROWS).flat_map(|i| (0..ROWS - i).map(move |k| [i, k]));
                let shares = shares.map(|at| at.map(|n| (n as f64 + 1.0 / 3.0) / ROWS as f64));
                let below = shares.clone().filter(|[s, t]| a + (b - a) * s + (c - a) * t < z).count();
                let slow = below as f64 / shares.count() as f64;
                let share = share_below(heights, z);
                assert!((share - slow).abs() < 5.0 / ROWS as f64, "{heights:?} below {z}: {share} {slow}");
            }
        }
    }

    /// A table of 40 by 8 mm on two legs, and a knob on it: walls of a cell, with the lower half of one leg cut off as an earlier part.
    fn table() -> (Vec<Wall>, RiskModel) {
        let inside = |x: usize, z: usize| {
            let leg = z < 5 && !(2..=7).contains(&x);
            leg || z == 5 || (z < 8 && x == 4) || (z == 3 && x == 2)
        };
        let number = |x: usize, y: usize, z: usize| (x + 11 * (z + 9 * y)) as u32;
        let mut points = Vec::new();
        for y in 0..2 {
            for z in 0..9 {
                points.extend((0..11).map(|x| Point3::new(4.0 * x as f64, 8.0 * y as f64, 4.0 * z as f64)));
            }
        }
        let mut faces = Vec::new();
        let mut quad = |a: u32, b: u32, c: u32, d: u32| faces.extend([[a, b, c], [a, c, d]]);
        let is_in = |x: i32, z: i32| (0..10).contains(&x) && (0..8).contains(&z) && inside(x as usize, z as usize);
        for z in 0..8 {
            for x in (0..10).filter(|&x| inside(x, z)) {
                let [front, back] = [0, 1]
                    .map(|y| [number(x, y, z), number(x + 1, y, z), number(x + 1, y, z + 1), number(x, y, z + 1)]);
                quad(front[0], front[1], front[2], front[3]);
                quad(back[1], back[0], back[3], back[2]);
                let beside = [(0, -1), (1, 0), (0, 1), (-1, 0)];
                for (side, (dx, dz)) in beside.into_iter().enumerate() {
                    if !is_in(x as i32 + dx, z as i32 + dz) {
                        let next = (side + 1) % 4;
                        quad(front[side], back[side], back[next], front[next]);
                    }
                }
            }
        }
        let solid = Solid::new(&points, &faces).unwrap();
        let mut partition = Partition::new(&solid);
        let cut = partition.cut(&[0], &CutPlane::through(&Point3::new(0.0, 0.0, 10.0), &Vector3::z()).unwrap());
        partition.merge(cut.above[0], cut.below[1]);
        let judge = RiskModel {
            earlier: vec![cut.below[0]],
            direction: Vector3::z(),
            floor: f64::NEG_INFINITY,
            limit: -(0.5f64.sqrt()),
        };
        (partition.walls(cut.above[0]), judge)
    }

    /// What a plane saves: piece by piece, each found from scratch.
    fn slow(walls: &[Wall], judge: &RiskModel, normal: &Vector3<f64>, offset: f64, options: &TuningOptions) -> f64 {
        let upward = RiskModel { direction: *normal, floor: f64::NEG_INFINITY, ..judge.clone() };
        let height = |p: &Point3<f64>| p.coords.dot(normal) - offset;
        let is_above = |wall: &Wall, k: usize| height(&wall.places[k]) > 0.0;
        if walls.iter().all(|wall| !judge.is_supported(wall) || (0..3).all(|k| height(&wall.places[k]) >= 0.0)) {
            return 0.0;
        }
        let cuts_section = |beyond: u32| {
            let of = || walls.iter().filter(|wall| wall.beyond == Some(beyond));
            of().any(|wall| (0..3).any(|k| is_above(wall, k))) && of().any(|wall| (0..3).any(|k| !is_above(wall, k)))
        };
        let mut left: Vec<u32> =
            walls.iter().flat_map(|wall| (0..3).filter(|&k| is_above(wall, k)).map(|k| wall.corners[k])).collect();
        left.sort_unstable();
        left.dedup();
        let mut gain = 0.0;
        while let Some(start) = left.pop() {
            let mut piece = vec![start];
            let mut at = 0;
            while at < piece.len() {
                let corners = |wall: &&Wall| wall.corners.contains(&piece[at]);
                let near: Vec<u32> = walls.iter().filter(corners).flat_map(|wall| wall.corners).collect();
                let (new, rest) = left.into_iter().partition(|v| near.contains(v));
                left = rest;
                let new: Vec<u32> = new;
                piece.extend(new);
                at += 1;
            }
            let of_piece = || walls.iter().filter(|wall| wall.corners.iter().any(|v| piece.contains(v)));
            let is_barred = of_piece().any(|wall| {
                let on_piece = (0..3).any(|k| is_above(wall, k) && piece.contains(&wall.corners[k]));
                wall.beyond.is_some_and(|beyond| judge.earlier.contains(&beyond) && on_piece && cuts_section(beyond))
            });
            let saved: f64 = of_piece()
                .map(|wall| {
                    let change = f64::from(u8::from(judge.is_risky(wall))) - f64::from(u8::from(upward.is_risky(wall)));
                    let vector = area_vector(&wall.places);
                    let mut h = wall.places.map(|p| p.coords.dot(normal));
                    h.sort_by(f64::total_cmp);
                    (change * vector.norm() + options.seam_cost * vector.dot(normal)) * (1.0 - share_below(h, offset))
                })
                .sum();
            if !is_barred && saved > 0.0 {
                gain += saved;
            }
        }
        gain
    }

    #[test]
    fn a_sweep_saves_what_is_counted_plane_by_plane() {
        let (walls, judge) = table();
        let surface = Surface::new(&walls, &judge);
        let (mut with_gain, mut compared) = (0, 0);
        for seam_cost in [0.0, 0.1] {
            let options = TuningOptions { spacing: 1.9, seam_cost, ..TuningOptions::default() };
            for normal in sphere(40) {
                let saving = surface.saving(&normal, judge.limit, seam_cost);
                let gains = surface.sweep(&normal, &saving, Pieces::new(surface.places.len()), &options);
                for (gain, offset) in gains {
                    let expected = slow(&walls, &judge, &normal, offset, &options);
                    assert!((gain - expected).abs() < 1e-9, "{normal:?} {offset}: {gain} {expected}");
                    compared += 1;
                    with_gain += usize::from(gain > 0.0);
                }
            }
        }
        assert!(with_gain > 100 && compared - with_gain > 100, "{with_gain} of {compared}");
        // Planes below which nothing stands are not among them.
        let least = promising(&walls, &judge, Point3::origin(), &Vector3::z(), &TuningOptions::default(), 1.0);
        assert!(!least.is_empty() && least.iter().all(|(gain, _)| *gain >= 1.0));
    }
}
