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
