//! The shortest path with given samples, within the stops.

use super::buckets::Measure;
use super::nodes::{Kind, Window};
use super::options::LadderOptions;
use super::search::{Path, Search, Stuck, Windows};
use crate::angle::wrapped;
use crate::robot::Robot;
use crate::{Bounds, ProgressFn};
use std::f64::consts::TAU;

/// What stays while samples are doubled.
pub(super) struct Plan<'a, const N: usize, const F: usize> {
    pub(super) robot: &'a dyn Robot<N, F>,
    pub(super) times: &'a [f64],
    pub(super) bounds: &'a Bounds<N>,
    pub(super) options: &'a LadderOptions<N, F>,
    pub(super) progress: ProgressFn<'a>,
}

impl<const N: usize, const F: usize> Plan<'_, N, F> {
    /// The shortest path through these waypoints over all samples, within the stops.
    pub(super) fn within_stops(
        &self,
        waypoints: &[usize],
        samples: [u32; F],
        breaks: bool,
    ) -> Result<Path<N, F>, Stuck> {
        let mut imaged = [false; N];
        loop {
            let kinds = Kind::of(self.bounds, &imaged);
            let mut path = self.search(waypoints, kinds, &mut Window::whole(samples), breaks)?;
            match self.lift(&mut path, &kinds) {
                Ok(()) => return Ok(path),
                Err(joint) => imaged[joint] = true,
            }
        }
    }

    pub(super) fn search(
        &self,
        waypoints: &[usize],
        kinds: [Kind; N],
        windows: &mut dyn Windows<F>,
        breaks: bool,
    ) -> Result<Path<N, F>, Stuck> {
        let Plan { robot, times, progress, .. } = *self;
        let velocity = self.bounds.velocity;
        let LadderOptions { norm, weights, step, .. } = *self.options;
        let measure = Measure { norm, weights, period: kinds.map(Kind::period) };
        let angle = |from: &[f64; N], j: usize| if kinds[j] == Kind::Circular { wrapped(from[j]) } else { from[j] };
        let from = self.options.from.map(|from| std::array::from_fn(|j| angle(&from, j)));
        Search { robot, waypoints, times, velocity, step, kinds, measure, breaks, from, progress }.run(windows)
    }

    /// Takes the whole turns out of circular joints and turns each run into its stops, the first one next to where the
    /// joints are before; else names a joint that does not fit.
    pub(super) fn lift(&self, path: &mut Path<N, F>, kinds: &[Kind; N]) -> Result<(), usize> {
        for run in path.runs() {
            let from = self.options.from.filter(|_| run.start == 0);
            let nodes = &mut path.nodes[run];
            for joint in (0..N).filter(|&joint| kinds[joint] == Kind::Circular) {
                // Whole turns by which each angle follows the one before by the short way.
                let mut unwound = nodes[0].joints[joint];
                let (mut least, mut most) = (unwound, unwound);
                let mut turns = Vec::with_capacity(nodes.len());
                for node in nodes.iter() {
                    let turn = ((unwound - node.joints[joint]) / TAU).round();
                    unwound = node.joints[joint] + TAU * turn;
                    (least, most) = (least.min(unwound), most.max(unwound));
                    turns.push(turn);
                }
                let (lower, upper) = (self.bounds.lower[joint], self.bounds.upper[joint]);
                // Turns that bring the run next to where it comes from, else its middle next to the middle between the
                // stops.
                let wanted = match from {
                    Some(from) => ((from[joint] - nodes[0].joints[joint]) / TAU).round(),
                    None if lower.is_finite() && upper.is_finite() => {
                        ((lower + upper - least - most) / 2.0 / TAU).round()
                    }
                    None => 0.0,
                };
                // A lone stop never excludes every image.
                let by = match (lower.is_finite(), upper.is_finite()) {
                    (true, false) => wanted.max(((lower - least) / TAU).ceil()),
                    (false, true) => wanted.min(((upper - most) / TAU).floor()),
                    _ => wanted,
                };
                if !self.bounds.is_endless(joint) && (least + TAU * by < lower || most + TAU * by > upper) {
                    return Err(joint);
                }
                for (node, turn) in nodes.iter_mut().zip(&turns) {
                    node.joints[joint] += TAU * (turn + by);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::node::LadderNode;
    use super::*;
    use crate::{FreeRange, RobotFn};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;
    use std::ops::ControlFlow;

    /// The angles of one joint, each by the short way from the one before, and all of them up to ten whole turns away.
    fn all_images(angles: &[f64]) -> Vec<Vec<f64>> {
        let mut unwound = vec![angles[0]];
        for pair in angles.windows(2) {
            unwound.push(unwound[unwound.len() - 1] + wrapped(pair[1] - pair[0]));
        }
        (-10..=10).map(|turns| unwound.iter().map(|angle| angle + TAU * f64::from(turns)).collect()).collect()
    }

    /// The image nearest to where the joint comes from, else to the middle between its stops, else to the angles as they are.
    fn nearest(angles: &[f64], [lower, upper]: [f64; 2], from: Option<f64>) -> Option<Vec<f64>> {
        let ends = |image: &[f64]| {
            image.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &a| [low.min(a), high.max(a)])
        };
        let fits = |image: &[f64]| ends(image)[0] >= lower && ends(image)[1] <= upper;
        let off = |image: &[f64]| match from {
            Some(from) => (image[0] - from).abs(),
            None if lower.is_finite() && upper.is_finite() => (ends(image)[0] + ends(image)[1] - lower - upper).abs(),
            None => (image[0] - angles[0]).abs(),
        };
        let least = |images: Vec<Vec<f64>>| images.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        match lower.is_finite() && upper.is_finite() {
            // Between two stops the nearest image fits, or the search looks at all images of the joint.
            true => least(all_images(angles)).filter(|image| fits(image)),
            false => least(all_images(angles).into_iter().filter(|image| fits(image)).collect()),
        }
    }

    #[test]
    fn runs_are_lifted_to_the_nearest_image_of_all() {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut fitted = [0; 2];
        for _ in 0..2_000 {
            let breaks: Vec<usize> = [4, 9].into_iter().filter(|_| rng.random_bool(0.5)).collect();
            let mut angle = rng.random_range(-3.0..3.0);
            let mut given = Vec::new();
            for _ in 0..12 {
                angle += rng.random_range(-0.8..1.2);
                given.push([wrapped(angle), rng.random_range(-9.0..9.0)]);
            }
            let middle: f64 = rng.random_range(-9.0..9.0);
            let lower = if rng.random_bool(0.3) { f64::NEG_INFINITY } else { middle - rng.random_range(3.2..9.0) };
            let upper = if rng.random_bool(0.3) { f64::INFINITY } else { middle + rng.random_range(3.2..9.0) };
            let bounds = Bounds { lower: [lower, f64::NEG_INFINITY], upper: [upper, f64::INFINITY], ..Bounds::NONE };
            let from = rng.random_bool(0.5).then(|| [rng.random_range(-12.0..12.0), 0.0]);

            let robot = RobotFn {
                waypoints: 12,
                free: [FreeRange::Turn],
                solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 2])| {},
                posture: |_: usize, _: &[f64; 1], _: u32| None,
            };
            let options = LadderOptions { from, ..LadderOptions::default() };
            let progress = |_: crate::Progress| ControlFlow::Continue(());
            let plan =
                Plan { robot: &robot, times: &[0.0; 12], bounds: &bounds, options: &options, progress: &progress };
            let nodes = given.iter().map(|&joints| LadderNode { joints, free: [0.0], branch: 0 }).collect();
            let mut path = Path { nodes, breaks, cost: 0.0 };
            let lifted = plan.lift(&mut path, &[Kind::Circular, Kind::AsGiven]);

            let expected: Vec<Option<Vec<f64>>> = path
                .runs()
                .into_iter()
                .map(|run| {
                    let from = from.filter(|_| run.start == 0).map(|from| from[0]);
                    let angles: Vec<f64> = given[run].iter().map(|joints| joints[0]).collect();
                    nearest(&angles, [lower, upper], from)
                })
                .collect();
            assert_eq!(lifted, if expected.iter().all(Option::is_some) { Ok(()) } else { Err(0) });
            fitted[usize::from(lifted.is_ok())] += 1;
            // Runs before one that does not fit are lifted, the others stay.
            for (run, expected) in path.runs().into_iter().zip(expected) {
                let Some(expected) = expected else { break };
                for (at, expected) in run.zip(expected) {
                    assert!((path.nodes[at].joints[0] - expected).abs() < 1e-9, "{:?} {expected}", path.nodes[at]);
                    assert_eq!(path.nodes[at].joints[1].to_bits(), given[at][1].to_bits());
                }
            }
        }
        assert!(fitted.iter().all(|&count| count > 200), "{fitted:?}");
    }
}
