//! Lays curves on the surface: polylines in space become pieces that lie in one triangle each.
//!
//! Points go to the nearest point of the surface, where they are snapped to a lattice of 2^30 steps an edge, so that
//! all later questions of touching and crossing are about integers. From point to point runs the section of the surface
//! with the plane through both that stands on it. It is followed from triangle to triangle by the signs of vertices, so
//! rounding cannot mislead it. Where it does not arrive (the chord leaves the surface over a notch of the boundary,
//! or cuts below a crest) the chord is halved until its parts lie on the surface or are short: these are *off* it.

use super::locate::{Locator, Near};
use super::sheet::Sheet;
use nalgebra::{Vector2, Vector3};

/// Steps of the lattice along an edge. Differences of products of two coordinates must fit in 63 bits.
pub(super) const STEPS: i64 = 1 << 30;

/// Chords are halved down to this share of the step of the raster when both of their ends lie on the surface. Less
/// would gain no figure a digit; more would count whole steps as off the surface at crests.
const MIN_CHORD: f64 = 1.0 / 256.0;

/// A point found this near, as a share of the width, to the triangle of the point before or one beside it is taken to
/// lie there without asking all triangles. So sheets that touch stay apart.
const NEAR: f64 = 1e-7;

/// Triangles that are no farther than this share of the width apart from a point are equally near.
const EQUAL: f64 = 1e-9;

/// A way through a vertex that is longer than the chord by at most this share is an effect of rounding: the vertex is
/// then nearer to the chord than the 30,000th part of its length.
const DETOUR: f64 = 1e-9;

/// A point of the surface, on the lattice of its triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spot {
    pub triangle: u32,
    /// Barycentric coordinates times [`STEPS`].
    pub weights: [i64; 3],
}

/// A straight segment in one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hop {
    pub triangle: u32,
    pub weights: [[i64; 3]; 2],
}

impl Spot {
    pub(super) fn new(triangle: u32, weights: [f64; 3]) -> Self {
        let largest = (0..3).fold(0, |best, k| if weights[k] > weights[best] { k } else { best });
        let mut steps = weights.map(|w| (w * STEPS as f64).round() as i64);
        steps[largest] = 0;
        steps[largest] = STEPS - steps.iter().sum::<i64>();
        Spot { triangle, weights: steps }
    }

    pub(super) fn position(&self, sheet: &Sheet) -> Vector3<f64> {
        sheet.lift(self.triangle, flat_point(sheet, self.triangle, self.weights))
    }

    /// Its coordinates in another triangle, if it is a point of that too.
    pub(super) fn seen_from(&self, sheet: &Sheet, triangle: u32) -> Option<[i64; 3]> {
        if triangle == self.triangle {
            return Some(self.weights);
        }
        let here = sheet.flats[self.triangle as usize].corners;
        let there = sheet.flats[triangle as usize].corners;
        let mut weights = [0; 3];
        for k in (0..3).filter(|&k| self.weights[k] != 0) {
            weights[there.iter().position(|&v| v == here[k])?] = self.weights[k];
        }
        Some(weights)
    }

    /// The triangles that it belongs to: one, two along an edge, or all around a vertex.
    pub(super) fn triangles(&self, sheet: &Sheet) -> Vec<u32> {
        let t = self.triangle as usize;
        let absent = |k: usize| self.weights[k] == 0;
        match (0..3).filter(|&k| absent(k)).count() {
            0 => vec![self.triangle],
            1 => {
                let opposite = (0..3).find(|&k| absent(k)).unwrap_or(0);
                let across = sheet.across[t][(opposite + 1) % 3].map(|a| a.triangle);
                std::iter::once(self.triangle).chain(across).collect()
            }
            _ => {
                let corner = (0..3).find(|&k| !absent(k)).unwrap_or(0);
                sheet.around(sheet.flats[t].corners[corner]).to_vec()
            }
        }
    }
}

/// A point of the lattice of a triangle in its frame.
pub(super) fn flat_point(sheet: &Sheet, triangle: u32, weights: [i64; 3]) -> Vector2<f64> {
    let at = &sheet.flats[triangle as usize].at;
    (at[0] * weights[0] as f64 + at[1] * weights[1] as f64 + at[2] * weights[2] as f64) / STEPS as f64
}

/// What lays curves down.
pub(super) struct Tracer<'s> {
    pub sheet: &'s Sheet,
    pub locator: Locator<'s>,
    /// Step of the raster, in millimetres.
    pub step: f64,
}

/// Sections longer than this many chords go astray: they run around something.
const MAX_CHORDS: f64 = 3.0;

/// The section of the surface with the plane through a chord that stands on it.
struct Section<'s> {
    sheet: &'s Sheet,
    start: Vector3<f64>,
    chord: Vector3<f64>,
    /// Normal of the plane.
    across: Vector3<f64>,
}

/// Where a section leaves a triangle: the edge, by its first corner, and the point on it.
#[derive(Clone, Copy)]
struct Exit {
    edge: usize,
    weights: [i64; 3],
}

impl Section<'_> {
    /// On which side of the plane a vertex lies.
    fn side(&self, v: u32) -> f64 {
        (self.sheet.points[v as usize] - self.start).dot(&self.across)
    }

    /// Where the section leaves a triangle through an edge. Only the signs of vertices decide whether it does, and a vertex has one sign for
    /// all of its triangles: so a section that enters a triangle leaves it again, whatever is rounded.
    fn through(&self, t: u32, edge: usize) -> Option<Exit> {
        let corners = self.sheet.flats[t as usize].corners;
        let (v, w) = (corners[edge], corners[(edge + 1) % 3]);
        let (f, g) = (self.side(v), self.side(w));
        ((f > 0.0) != (g > 0.0)).then(|| {
            let mut weights = [0; 3];
            // From the lower vertex on, so that both triangles agree.
            let share = if v < w { f / (f - g) } else { 1.0 - g / (g - f) };
            let steps = ((share * STEPS as f64).round() as i64).clamp(0, STEPS);
            (weights[edge], weights[(edge + 1) % 3]) = (STEPS - steps, steps);
            Exit { edge, weights }
        })
    }

    fn position(&self, triangle: u32, weights: [i64; 3]) -> Vector3<f64> {
        Spot { triangle, weights }.position(self.sheet)
    }

    /// The first step: of all ways out of the triangles at the start the one that leads on farthest. Edges through the start itself are no
    /// ways out.
    fn first_exit(&self, from: Spot, start: &[u32]) -> Option<(u32, Exit)> {
        let mut first: Option<(f64, u32, Exit)> = None;
        for &triangle in start {
            let Some(here) = from.seen_from(self.sheet, triangle) else { continue };
            for edge in (0..3).filter(|&k| here[(k + 2) % 3] != 0) {
                if let Some(exit) = self.through(triangle, edge) {
                    let gain = (self.position(triangle, exit.weights) - self.start).dot(&self.chord);
                    if gain > first.map_or(0.0, |f| f.0) {
                        first = Some((gain, triangle, exit));
                    }
                }
            }
        }
        first.map(|(_, triangle, exit)| (triangle, exit))
    }

    /// Goes from triangle to triangle until one has the other spot. False if the section ends at the boundary, leads back, or becomes too long.
    fn follow(
        &self,
        (mut triangle, mut entry, mut exit): (u32, [i64; 3], Exit),
        to: Spot,
        hops: &mut Vec<Option<Hop>>,
    ) -> bool {
        let sheet = self.sheet;
        let longest = MAX_CHORDS * self.chord.norm();
        let mut travelled = 0.0;
        // A section enters each triangle at most once.
        for _ in 0..sheet.flats.len() {
            if entry != exit.weights {
                hops.push(Some(Hop { triangle, weights: [entry, exit.weights] }));
                travelled += (self.position(triangle, exit.weights) - self.position(triangle, entry)).norm();
            }
            let Some(across) = sheet.across[triangle as usize][exit.edge] else { return false };
            let out = Spot { triangle, weights: exit.weights };
            let Some(weights) = out.seen_from(sheet, across.triangle) else { return false };
            (triangle, entry) = (across.triangle, weights);
            if let Some(last) = to.seen_from(sheet, triangle) {
                if entry != last {
                    hops.push(Some(Hop { triangle, weights: [entry, last] }));
                }
                return true;
            }
            let mut ways = (0..3).filter(|&k| k != across.edge as usize);
            let Some(next) = ways.find_map(|k| self.through(triangle, k)) else { return false };
            exit = next;
            if travelled > longest {
                return false;
            }
        }
        false
    }
}

/// The segment between two spots that a triangle has both of. False, and nothing added, if none has.
fn in_one_triangle(sheet: &Sheet, start: &[u32], from: Spot, to: Spot, hops: &mut Vec<Option<Hop>>) -> bool {
    for &triangle in start {
        if let (Some(a), Some(b)) = (from.seen_from(sheet, triangle), to.seen_from(sheet, triangle)) {
            if a != b {
                hops.push(Some(Hop { triangle, weights: [a, b] }));
            }
            return true;
        }
    }
    false
}

/// An end of a part of a chord: where in space, and where on the surface if it is there.
#[derive(Clone, Copy)]
struct End {
    point: Vector3<f64>,
    spot: Option<Spot>,
}

impl Tracer<'_> {
    /// The nearest point of the surface within `reach`, preferably beside the one before, to which the curve came in a
    /// triangle. Where triangles lie on each other, folded flat, a curve that came to the edge between them goes on
    /// over it; elsewhere it stays in its triangle.
    pub(super) fn locate(&self, p: Vector3<f64>, reach: f64, before: Option<(Spot, u32)>) -> Option<Spot> {
        let beside = before.and_then(|(spot, came)| {
            let across = self.sheet.across[spot.triangle as usize].iter().flatten().map(|a| a.triangle);
            let near: Vec<Near> =
                std::iter::once(spot.triangle).chain(across).map(|t| self.locator.on_triangle(t, p)).collect();
            let least = near.iter().map(|near| near.distance).fold(f64::INFINITY, f64::min);
            let rank = |near: &Near| match spot.seen_from(self.sheet, near.triangle) {
                Some(_) => u8::from(near.triangle == came),
                None => 2,
            };
            let nearest = near.into_iter().filter(|near| near.distance <= least + EQUAL * reach);
            nearest
                .min_by(|a, b| rank(a).cmp(&rank(b)).then(a.distance.total_cmp(&b.distance)))
                .filter(|near| near.distance <= NEAR * reach)
        });
        beside.or_else(|| self.locator.nearest(p, reach)).map(|near| Spot::new(near.triangle, near.weights))
    }

    /// Segments from one spot to another, in order; `None` where a part is off the surface.
    pub(super) fn chord(&self, ends: [Spot; 2], points: [Vector3<f64>; 2], reach: f64) -> Vec<Option<Hop>> {
        let mut hops = Vec::new();
        let end = |k: usize| End { point: points[k], spot: Some(ends[k]) };
        self.part(end(0), end(1), reach, &mut hops);
        hops
    }

    fn part(&self, a: End, b: End, reach: f64, hops: &mut Vec<Option<Hop>>) {
        let length = (b.point - a.point).norm();
        let mut least = self.step;
        if let (Some(from), Some(to)) = (a.spot, b.spot) {
            if self.connect(from, to, hops) {
                return;
            }
            least *= MIN_CHORD;
        }
        let middle = (a.point + b.point) / 2.0;
        let halved = length > least && middle != a.point && middle != b.point;
        if halved {
            let m = End { point: middle, spot: self.locate(middle, reach, None) };
            self.part(a, m, reach, hops);
            self.part(m, b, reach, hops);
        } else {
            hops.push(None);
        }
    }

    /// Follows the section from one spot to the other. False, and nothing added, if it does not arrive.
    fn connect(&self, from: Spot, to: Spot, hops: &mut Vec<Option<Hop>>) -> bool {
        let sheet = self.sheet;
        let start = from.triangles(sheet);
        if in_one_triangle(sheet, &start, from, to, hops) {
            return true;
        }
        let (p, q) = (from.position(sheet), to.position(sheet));
        if self.around_vertex((from, p), (to, q), hops) {
            return true;
        }
        let (n, m) = (sheet.normal(from.triangle), sheet.normal(to.triangle));
        let chord = q - p;
        // Both normals count alike, so the section is the same from either end; faces that are turned over do not cancel out.
        let across = chord.cross(&if n.dot(&m) < 0.0 { n - m } else { n + m });
        let section = Section { sheet, start: p, chord, across };
        let Some((triangle, exit)) = section.first_exit(from, &start) else { return false };
        let Some(entry) = from.seen_from(sheet, triangle) else { return false };
        let kept = hops.len();
        let arrives = section.follow((triangle, entry, exit), to, hops);
        if !arrives {
            hops.truncate(kept);
        }
        arrives
    }

    /// The way through a vertex of triangles of both spots, if it is no detour: a section along the boundary, or along
    /// edges, may miss both. False, and nothing added, if there is none.
    fn around_vertex(&self, from: (Spot, Vector3<f64>), to: (Spot, Vector3<f64>), hops: &mut Vec<Option<Hop>>) -> bool {
        let sheet = self.sheet;
        let direct = (to.1 - from.1).norm();
        let (here, there) = (from.0.triangles(sheet), to.0.triangles(sheet));
        for &t in &here {
            for corner in 0..3 {
                let v = sheet.flats[t as usize].corners[corner];
                let place = sheet.points[v as usize];
                if (place - from.1).norm() + (to.1 - place).norm() > direct * (1.0 + DETOUR) {
                    continue;
                }
                let Some(&u) = there.iter().find(|&&u| sheet.flats[u as usize].corners.contains(&v)) else { continue };
                let ends = [(t, from.0), (u, to.0)].map(|(triangle, spot)| {
                    let corner = sheet.flats[triangle as usize].corners.map(|w| if w == v { STEPS } else { 0 });
                    spot.seen_from(sheet, triangle).map(|weights| (triangle, weights, corner))
                });
                if let [Some((t, a, v)), Some((u, b, w))] = ends {
                    let hop = |triangle, weights: [[i64; 3]; 2]| Hop { triangle, weights };
                    hops.extend(
                        [hop(t, [a, v]), hop(u, [w, b])].into_iter().filter(|h| h.weights[0] != h.weights[1]).map(Some),
                    );
                    return true;
                }
            }
        }
        false
    }
}
