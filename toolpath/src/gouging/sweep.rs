//! What a nozzle may come near on a way.
//!
//! Most of the time goes into the tree, so poses on one short way share one walk: it gathers the triangles that some pose may come near, and
//! each pose looks at these alone. What it finds is the same. A tip goes along the layer, so the flat below it hardly nears what it moves
//! over: each face of the nozzle is bounded by itself, by how far the tip goes along the axis and across it, and there is
//! mostly nothing left to look at.

use super::deepest::{Scene, Seeker, Stand};
use super::nozzle::Sway;
use crate::layer::{Node, Triangle};
use nalgebra::UnitVector3;

/// Poses of a nozzle on a way: none of them is farther from one of them than this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub stand: Stand,
    pub direction: UnitVector3<f64>,
    /// How far the tip goes along the direction and across it, in millimetres.
    pub moves: [f64; 2],
    /// How far the direction turns, in radians.
    pub turns: f64,
}

/// A seeker whose nozzle moves: what no pose on the way comes near does not matter.
struct Sweeper<'a> {
    at: Seeker<'a>,
    along: f64,
    across: f64,
    turns: f64,
}

impl Sweeper<'_> {
    /// How far the nozzle is from where it is, seen from points no farther from its tip than `reach`: a turn moves them by no more than
    /// their distance from the tip, wherever that is on the way, times the turn.
    fn sway(&self, reach: f64) -> Sway {
        let &Sweeper { along, across, turns, .. } = self;
        Sway { along, across, turned: turns * (reach + along + across) }
    }

    /// Whether no pose on the way comes near a box.
    fn clears_box(&self, node: &Node) -> bool {
        let radius = node.half.norm() + self.at.stand.offset(node.height);
        let sway = self.sway((node.middle - self.at.stand.tip).norm() + radius);
        // Most of what is built lies below the tip; most of the rest is so far away that a ball around it is clear.
        let top = self.at.top(node);
        if -top >= sway.along + sway.turned {
            return true;
        }
        let (z, rho, _) = self.at.place(node.middle);
        let is_far = self.at.nozzle.clearance(z, rho) >= radius + sway.along + sway.across + sway.turned;
        is_far || self.at.least_in(node, top, &sway) >= 0.0
    }

    /// Nor the sheets of a triangle.
    fn clears(&self, triangle: &Triangle) -> bool {
        let offset = self.at.stand.offset(triangle.height);
        let squares = triangle.corners.map(|corner| (corner - self.at.stand.tip).norm_squared());
        let reach = squares.into_iter().fold(0.0, f64::max).sqrt() + offset;
        self.at.least(&triangle.corners, &self.sway(reach)) - offset >= 0.0
    }
}

impl Scene<'_> {
    fn sweeper(&self, way: &Way) -> Sweeper<'_> {
        let Way { stand, direction, moves: [along, across], turns } = *way;
        Sweeper { at: self.seeker(stand, &direction, 0.0, true), along, across, turns }
    }

    /// The triangles that a nozzle may gouge on a way: for [`Scene::is_free_of`].
    pub fn near(&self, way: &Way, near: &mut Vec<u32>) {
        near.clear();
        let sweeper = self.sweeper(way);
        let clears = |node: &Node| sweeper.clears_box(node);
        self.stack.tree.each(self.keys, way.stand.before, clears, |number, triangle| {
            if !sweeper.clears(triangle) {
                near.push(number);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gouging::Nozzle;
    use crate::layer::{BuiltLayer, LayerStack};
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    const SIDE: u32 = 12;
    const HEIGHT: f64 = 0.4;

    /// Layers of small squares over hills, some of which stand beside the nozzle.
    fn hills(layers: u32, high: f64) -> Vec<Vec<Point3<f64>>> {
        let place = |k: u32, n: u32| {
            let [x, y] = [n % (SIDE + 1), n / (SIDE + 1)].map(|i| 0.5 * f64::from(i));
            Point3::new(x, y, 5.0 + HEIGHT * f64::from(k) + high * (1.3 * x).sin() * (1.1 * y).cos())
        };
        (0..layers).map(|k| (0..(SIDE + 1) * (SIDE + 1)).map(|n| place(k, n)).collect()).collect()
    }

    fn squares() -> Vec<[u32; 3]> {
        let corner = |i: u32, j: u32| i + (SIDE + 1) * j;
        let halves = |i: u32, j: u32| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..SIDE).flat_map(|j| (0..SIDE).flat_map(move |i| halves(i, j))).collect()
    }

    fn leaning([x, y]: [f64; 2]) -> UnitVector3<f64> {
        UnitVector3::new_normalize(Vector3::new(x, y, 1.0))
    }

    proptest! {
        /// Slow twin: each pose on its own, from the root of the tree. Nothing that a pose runs into is left out of what is near a way.
        #[test]
        fn what_is_near_a_way_has_all_that_its_poses_run_into(
            (high, layers) in (0.0_f64..1.5, 1_u32..4),
            start in prop::array::uniform3(0.0_f64..1.0),
            step in prop::array::uniform3(-0.5_f64..0.5),
            leans in prop::array::uniform8(prop::array::uniform2(-0.5_f64..0.5)),
            before in 0_u32..5,
        ) {
            let (surfaces, triangles) = (hills(layers, high), squares());
            let spacing = vec![HEIGHT; triangles.len()];
            let built: Vec<BuiltLayer> = surfaces
                .iter()
                .map(|vertices| BuiltLayer { vertices, triangles: &triangles, spacing: &spacing, curves: &[] })
                .collect();
            let stack = LayerStack::new(&built).unwrap();
            let nozzle = Nozzle::default();
            let scene = Scene::new(&stack, &stack.keys, &nozzle, None);
            let tip = |k: usize| {
                let [x, y, z] = [0, 1, 2].map(|c| start[c] * [6.0, 6.0, 2.5][c] + step[c] * k as f64 * [1.0, 1.0, 0.2][c]);
                Point3::new(x, y, 4.8 + z)
            };
            let stand = |k: usize| Stand { tip: tip(k), before, allowed: 0.2 };
            let direction = |k: usize| leaning(leans[k]);
            // As far as any is from the pose in the middle.
            let way = |from: usize, to: usize| {
                let middle = (from + to) / 2;
                let axis = direction(middle);
                let far = |of: &dyn Fn(usize) -> f64| (from..=to).map(of).fold(0.0, f64::max) + 1e-9;
                let along = far(&|k| (tip(k) - tip(middle)).dot(&axis).abs());
                let across = far(&|k| {
                    let to = tip(k) - tip(middle);
                    (to - axis.into_inner() * to.dot(&axis)).norm()
                });
                let turns = far(&|k| direction(k).angle(&axis));
                Way { stand: stand(middle), direction: axis, moves: [along, across], turns }
            };
            let (mut near, mut work) = (Vec::new(), Vec::new());
            for (from, to) in [(0, 1), (2, 4), (5, 7), (0, 7)] {
                scene.near(&way(from, to), &mut near);
                for pose in from..=to {
                    let is_free = scene.is_free(stand(pose), &direction(pose), &mut work);
                    prop_assert_eq!(scene.is_free_of(&near, stand(pose), &direction(pose)), is_free, "{} of {}", pose, from);
                }
            }
        }
    }
}
