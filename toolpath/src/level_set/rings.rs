//! Level sets of a field that is linear over triangles.
//!
//! A vertex whose value equals the level counts as below it. So each triangle is crossed by one segment or none,
//! whatever the field does (plateaus included), and segments form closed rings, and chains that end at the boundary.

use super::Ring;
use super::field::LevelField;
use super::levels::Levels;
use crate::mesh::{SurfacePoint, next, previous};

/// A ring and one of the triangles that it crosses.
pub(super) struct Traced {
    pub ring: Ring,
    pub triangle: u32,
}

/// The level sets at a level, with what is higher on their left. Rings come in the order of their first triangle, those that end at the
/// boundary first.
pub(super) fn trace(
    field: &LevelField,
    levels: &(impl Levels + ?Sized),
    slabs: &[usize],
    level: usize,
    falling: &Falling,
    seen: &mut Seen,
) -> Vec<Traced> {
    let over = |v: u32| field.values[v as usize] - levels.at(level, v);
    let above = |v: u32| slabs[v as usize] > level;
    let mut found = Vec::new();
    let [from, to] = [level, level + 1].map(|level| falling.starts[level] as usize);
    for &first in &falling.half_edges[from..to] {
        if seen.has(first / 3, level) {
            continue;
        }
        let mut ring = Ring { level, points: Vec::new(), closed: true, below: 0, above: 0 };
        let mut at = first;
        // A segment enters its triangle where the boundary of the triangle goes down.
        while seen.add(at / 3, level) {
            ring.points.push(crossing(field, at, &over));
            let out = if above(field.tail(previous(at))) { next(at) } else { previous(at) };
            match field.twin(out) {
                Some(twin) => at = twin,
                None => {
                    ring.points.push(crossing(field, out, &over));
                    ring.closed = false;
                }
            }
        }
        found.push(Traced { ring, triangle: first / 3 });
    }
    found
}

/// Half-edges that go down through each level, where rings enter triangles.
///
/// A vertex is above the levels below its slab, so a half-edge falls through those from the slab of its head up to that of its tail. They are
/// listed by one count over all half-edges: a level costs as much as it has crossings.
pub(super) struct Falling {
    /// Level after level: first those at the boundary, where chains begin, then others; each by number.
    half_edges: Vec<u32>,
    /// Where the list of each level begins, and an end.
    starts: Vec<u32>,
}

/// One more than the level at which each triangle was last seen: nothing is cleared between levels.
pub(super) struct Seen(Vec<u32>);

impl Falling {
    /// * `slabs`: how many of the `levels` are below each vertex.
    pub fn new(field: &LevelField, slabs: &[usize], levels: usize) -> Falling {
        let through = |h: u32| slabs[field.head(h) as usize]..slabs[field.tail(h) as usize];
        let mut starts = vec![0; levels + 1];
        (0..field.half_edges()).flat_map(through).for_each(|level| starts[level + 1] += 1);
        (1..starts.len()).for_each(|level| starts[level] += starts[level - 1]);
        let mut filled = starts.clone();
        let mut half_edges = vec![0; starts[levels] as usize];
        for at_boundary in [true, false] {
            for h in (0..field.half_edges()).filter(|&h| field.twin(h).is_none() == at_boundary) {
                for level in through(h) {
                    half_edges[filled[level] as usize] = h;
                    filled[level] += 1;
                }
            }
        }
        Falling { half_edges, starts }
    }
}

impl Seen {
    /// None of so many triangles.
    pub fn new(triangles: usize) -> Seen {
        Seen(vec![0; triangles])
    }

    fn has(&self, triangle: u32, level: usize) -> bool {
        self.0[triangle as usize] as usize == level + 1
    }

    /// Notes that a triangle is seen; whether it was not before.
    fn add(&mut self, triangle: u32, level: usize) -> bool {
        std::mem::replace(&mut self.0[triangle as usize], level as u32 + 1) as usize != level + 1
    }
}

/// Where the level crosses an edge, always reckoned from its higher end.
fn crossing(field: &LevelField, half_edge: u32, over: &impl Fn(u32) -> f64) -> SurfacePoint {
    let ends = [field.tail(half_edge), field.head(half_edge)];
    let [high, low] = if over(ends[0]) > over(ends[1]) { ends } else { [ends[1], ends[0]] };
    let [top, bottom] = [high, low].map(|v| (field.points[v as usize], over(v)));
    let position = top.0 + (bottom.0 - top.0) * (top.1 / (top.1 - bottom.1)).clamp(0.0, 1.0);
    field.surface_point(half_edge / 3, position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesic::{Sources, SurfaceDistance};
    use crate::mesh::SurfaceMesh;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use std::ops::ControlFlow;

    /// Slow twin: asks all half-edges at each level, and values, not slabs. For each ring, where it enters triangles, and whether it is closed.
    fn slow(field: &LevelField, level: f64) -> Vec<(Vec<u32>, bool)> {
        let above = |v: u32| field.values[v as usize] > level;
        let falls = |h: &u32| above(field.tail(*h)) && !above(field.head(*h));
        let mut entered = Vec::new();
        let mut found = Vec::new();
        let chains = (0..field.half_edges()).filter(|&h| field.twin(h).is_none());
        for first in chains.chain(0..field.half_edges()).filter(falls) {
            if entered.contains(&(first / 3)) {
                continue;
            }
            let (mut ring, mut at, mut closed) = (Vec::new(), Some(first), true);
            while let Some(h) = at.filter(|h| !entered.contains(&(h / 3))) {
                entered.push(h / 3);
                ring.push(h);
                let out = [next(h), previous(h)]
                    .into_iter()
                    .find(|&side| above(field.head(side)) && !above(field.tail(side)));
                at = field.twin(out.unwrap());
                closed = at.is_some();
            }
            found.push((ring, closed));
        }
        found
    }

    proptest! {
        /// Also at levels that run through vertices and along plateaus.
        #[test]
        fn rings_are_those_of_all_half_edges(
            heights in prop::collection::vec(0_u32..4, 49),
            levels in prop::collection::btree_set(0_u32..9, 0..6),
        ) {
            let place = |k: usize| Point3::new((k % 7) as f64, (k / 7) as f64, 0.0);
            let corner = |i: u32, j: u32| i + 7 * j;
            let halves = |k: u32| {
                let (i, j) = (k % 6, k / 6);
                [[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)], [corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]]
            };
            let mesh = SurfaceMesh::new((0..49).map(place).collect(), (0..36).flat_map(halves).collect()).unwrap();
            let sources = Sources { vertices: &[0], ..Sources::default() };
            let distance = SurfaceDistance::to(&mesh, sources, &|_| ControlFlow::Continue(())).unwrap();
            let mut field = LevelField::unrefined(&distance);
            field.values = heights.iter().map(|&height| f64::from(height)).collect();
            let levels: Vec<f64> = levels.iter().map(|&half| f64::from(half) * 0.5 - 0.5).collect();
            let slabs: Vec<usize> = (0..).zip(&field.values).map(|(v, &value)| levels.below(value, v)).collect();
            let (falling, mut seen) = (Falling::new(&field, &slabs, levels.len()), Seen::new(field.triangles.len()));
            for (level, &at) in levels.iter().enumerate() {
                let traced = trace(&field, levels.as_slice(), &slabs, level, &falling, &mut seen);
                let wanted = slow(&field, at);
                prop_assert_eq!(traced.len(), wanted.len());
                for (traced, (entered, closed)) in traced.iter().zip(&wanted) {
                    prop_assert_eq!((traced.triangle, traced.ring.closed), (entered[0] / 3, *closed));
                    prop_assert_eq!(traced.ring.points.len(), entered.len() + usize::from(!closed));
                    let over = |v: u32| field.values[v as usize] - at;
                    for (point, &h) in traced.ring.points.iter().zip(entered) {
                        prop_assert_eq!(point.position, crossing(&field, h, &over).position);
                    }
                }
            }
        }
    }
}
