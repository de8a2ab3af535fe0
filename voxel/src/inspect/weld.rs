//! A mesh with its corners joined, and what is wrong with single triangles.

use super::error::{InspectError, MAX_COORDINATE};
use super::predicates::clear_view;
use super::report::{Finding, Place};
use nalgebra::Point3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Most triangles and most vertices: numbers of edge ends must fit 32 bits.
const MAX_COUNT: usize = 1 << 30;

/// A triangle is a needle if its height is at most this share of its largest coordinate: the distance by which its corners move, in
/// three directions, when they are rounded to single precision, in which STL files are written. Corners that once
/// lay on a line end up so; the flattest triangle with a purpose in a scan of 50,000 has one and a half times that.
const FLATNESS: f64 = 1.733 * f32::EPSILON as f64 / 2.0;

/// Refuses what no later step could live with.
pub(crate) fn check(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), InspectError> {
    if triangles.is_empty() {
        return Err(InspectError::NoTriangles);
    }
    if triangles.len() > MAX_COUNT || vertices.len() > MAX_COUNT {
        return Err(InspectError::TooMany { triangles: triangles.len(), vertices: vertices.len() });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            let Some(point) = vertices.get(vertex as usize) else {
                return Err(InspectError::NoSuchVertex { triangle, vertex, vertices: vertices.len() });
            };
            // Not a number fails the comparison, too.
            if !point.iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(InspectError::Coordinate { triangle, vertex, position: [point.x, point.y, point.z] });
            }
        }
    }
    Ok(())
}

/// A mesh in which corners at the same place are one.
pub(super) struct Welded {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) kinds: Vec<Kind>,
}

/// What a triangle is by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// It has an area.
    Sound,
    /// Three corners on a line: no area, yet it may join the triangles at its edges.
    Sliver,
    /// The same but for rounding, see [`FLATNESS`].
    Needle,
    /// Two corners at one place: nothing is left of it.
    Collapsed,
    /// An earlier triangle has the same corners and runs the same way round.
    Repeat,
}

impl Welded {
    /// Joins the corners at equal positions (0 and -0 are equal).
    pub(super) fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let mut points = Vec::new();
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(vertices.len().min(3 * triangles.len()));
        let mut joined = vec![u32::MAX; vertices.len()];
        let mut join = |vertex: u32| {
            let joined = &mut joined[vertex as usize];
            if *joined == u32::MAX {
                let point = vertices[vertex as usize].map(|x| x + 0.0);
                *joined = match known.entry([point.x, point.y, point.z].map(f64::to_bits)) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => {
                        points.push(point);
                        *new.insert(points.len() as u32 - 1)
                    }
                };
            }
            *joined
        };
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&mut join)).collect();
        let kinds = triangles
            .iter()
            .map(|&[a, b, c]| {
                let corners = [a, b, c].map(|corner| &points[corner as usize]);
                if a == b || b == c || c == a {
                    Kind::Collapsed
                } else if clear_view(corners).is_none() {
                    Kind::Sliver
                } else if is_needle(corners) {
                    Kind::Needle
                } else {
                    Kind::Sound
                }
            })
            .collect();
        Welded { points, triangles, kinds }
    }

    /// The corners of a triangle.
    pub(super) fn corners(&self, triangle: u32) -> [&Point3<f64>; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        [&self.points[a as usize], &self.points[b as usize], &self.points[c as usize]]
    }

    /// The place of a triangle, or of two.
    pub(super) fn place(&self, triangle: u32, other: Option<u32>) -> Place {
        let [a, b, c] = self.corners(triangle);
        let at = a + ((b - a) + (c - a)) / 3.0;
        Place { triangle, other, at }
    }

    pub(super) fn zero_area(&self) -> Finding {
        let mut found = Finding::default();
        for (triangle, kind) in (0..).zip(&self.kinds) {
            if matches!(kind, Kind::Sliver | Kind::Needle | Kind::Collapsed) {
                found.add(|| self.place(triangle, None));
            }
        }
        found
    }

    /// Finds triangles on the same three corners. Those that run the same way round as an earlier one become
    /// [`Kind::Repeat`] and are the first finding; pairs back to back are the second.
    pub(super) fn mark_repeats(&mut self) -> [Finding; 2] {
        // Corners by rising number; whether the triangle runs through them in that order; the triangle.
        let mut keys: Vec<([u32; 3], bool, u32)> = Vec::with_capacity(self.triangles.len());
        for (number, (&[a, b, c], &kind)) in (0..).zip(self.triangles.iter().zip(&self.kinds)) {
            if kind != Kind::Collapsed {
                let mut sorted = [a, b, c];
                sorted.sort_unstable();
                let least_first = if a == sorted[0] {
                    [b, c]
                } else if b == sorted[0] {
                    [c, a]
                } else {
                    [a, b]
                };
                keys.push((sorted, least_first[0] < least_first[1], number));
            }
        }
        keys.sort_unstable();
        let (mut repeats, mut opposed) = (Vec::new(), Vec::new());
        for run in keys.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
            for same_way in run.chunk_by(|a, b| a.1 == b.1) {
                let first = same_way[0].2;
                repeats.extend(same_way[1..].iter().map(|&(_, _, repeat)| [repeat, first]));
                if same_way.len() < run.len() && first != run[0].2 && self.kinds[first as usize] == Kind::Sound {
                    opposed.push([run[0].2, first]);
                }
            }
        }
        for &[repeat, _] in &repeats {
            self.kinds[repeat as usize] = Kind::Repeat;
        }
        [repeats, opposed].map(|mut pairs| {
            pairs.sort_unstable();
            let mut found = Finding::default();
            for [triangle, other] in pairs {
                found.add(|| self.place(triangle, Some(other)));
            }
            found
        })
    }
}

/// Whether [`FLATNESS`] says so; also for corners that lie on a line.
pub(super) fn is_needle(corners: [&Point3<f64>; 3]) -> bool {
    let largest = corners.iter().map(|corner| corner.coords.amax()).fold(0.0, f64::max);
    // Measured in that unit, nothing overflows.
    let [a, b, c] = corners.map(|corner| corner.coords / largest);
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    largest == 0.0 || (b - a).cross(&(c - a)).norm() <= FLATNESS * longest
}
