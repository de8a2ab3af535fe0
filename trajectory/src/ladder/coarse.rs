//! From a coarse path to a fine one.
//!
//! The coarse path goes through every eighth waypoint, which leaves the joints eight times as far to move, so that an
//! eighth of the samples is fine enough to separate good paths from bad ones. Then come every fourth waypoint with a fourth
//! of the samples, every second, and all. Squared steps add up alike on all these levels: a step of so many waypoints
//! costs the square of their number, and so does one of so many samples. So the path of one level lies near the best one
//! of the next, and a narrow band of samples around it, on the branches that it uses, holds that. Where the result touches
//! the edge of its band, the band is laid around the result and the search goes on. Bands overlap from round to round,
//! so solutions are kept: they cost more than the search between them.
//!
//! What a coarse level steps over may be in the way of a finer one. Where its search is stuck, the bands of the waypoints about
//! there become wider, and it goes back to the first of them. So a few waypoints have many samples, instead of all.
//!
//! Of a joint with a turn or more between its stops the coarse path has one image at each waypoint. Finer ones look at the
//! image next to it alone, so that they keep between the stops at no cost. A path that was found with a few samples at
//! every waypoint is refined in the same way, by bands about it.

use super::nodes::{Kind, Window, nearest};
use super::paths::Plan;
use super::search::{Path, Stuck, Windows};
use crate::angle::nearest_image;
use crate::angle::wrapped;
use crate::bounds::ON_STOP;
use crate::robot::{FreeRange, Posture, Robot};
use crate::{Bounds, LadderOptions};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Every so many waypoints and samples, to begin with: a power of two. With 16 the bench's dome ends in another valley.
const STRIDE: u32 = 8;

/// Samples on either side of the path of the level before, which has samples twice as far apart. With 3 the band is laid
/// anew more often and may end beside the best path; with 6 more samples are solved than rounds are saved.
const HALF: u32 = 4;

/// The same with more than one free parameter, where a band is a box: with 3 it has thrice the samples.
const HALF_OF_MANY: u32 = 2;

/// Fewer samples than this are not thinned out: they would not find their way.
const FEWEST: u32 = 8;

/// Where a search is stuck, bands of so many waypoints before and after become wider.
const ABOUT: usize = 32;

/// A search that is stuck again and again goes back so many waypoints at most.
const MAX_BACK: usize = 256;

/// No band becomes wider than so many samples.
const WIDEST: u32 = 1000;

/// Another round that brings less than this share is the last.
const LITTLE: f64 = 1e-4;

/// The band is moved at most so often; then its path is taken as it is.
const ROUNDS: usize = 12;

/// How near a path comes to the stops of joints with a turn or more between them, in radians: a smooth motion sways.
const STOP_MARGIN: f64 = 0.05;

/// What is looked at around each waypoint.
struct Guide<const N: usize, const F: usize> {
    /// Free parameters around which the band is laid.
    free: Vec<[f64; F]>,
    /// Joints next to which images are.
    joints: Vec<[f64; N]>,
    branches: Vec<[u32; 2]>,
}

/// Free parameters of a waypoint that have been asked for, bit by bit, with the places of their solutions, and the solutions.
#[derive(Debug)]
struct Known<const N: usize, const F: usize> {
    asked: HashMap<[u64; F], Range<usize>>,
    solutions: Vec<(u32, [f64; N])>,
}

impl<const N: usize, const F: usize> Default for Known<N, F> {
    fn default() -> Self {
        Known { asked: HashMap::new(), solutions: Vec::new() }
    }
}

/// A robot that solves every sample once, on the branches of the guide, and gives the image of each joint next to it.
struct Kept<'a, const N: usize, const F: usize> {
    robot: &'a dyn Robot<N, F>,
    guide: &'a Guide<N, F>,
    bounds: &'a Bounds<N>,
    kinds: [Kind; N],
    known: Vec<Mutex<Known<N, F>>>,
}

impl<const N: usize, const F: usize> Kept<'_, N, F> {
    /// The image of a solution next to the guide, if it is within the stops.
    fn image(&self, waypoint: usize, mut joints: [f64; N]) -> Option<[f64; N]> {
        for j in (0..N).filter(|&j| self.kinds[j] == Kind::AsGiven) {
            let (lower, upper) = (self.bounds.lower[j], self.bounds.upper[j]);
            joints[j] = nearest_image(joints[j], self.guide.joints[waypoint][j]);
            if !(lower - ON_STOP..=upper + ON_STOP).contains(&joints[j]) {
                return None;
            }
            joints[j] = joints[j].clamp(lower, upper);
        }
        Some(joints)
    }
}

impl<const N: usize, const F: usize> Robot<N, F> for Kept<'_, N, F> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; F] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        let mut known = self.known[waypoint].lock().unwrap_or_else(PoisonError::into_inner);
        let Known { asked, solutions } = &mut *known;
        let found = asked.entry(free.map(f64::to_bits)).or_insert_with(|| {
            let first = solutions.len();
            self.robot.solutions(waypoint, free, &mut |branch, joints| {
                if self.guide.branches[waypoint].contains(&branch) {
                    solutions.extend(self.image(waypoint, joints).map(|joints| (branch, joints)));
                }
            });
            first..solutions.len()
        });
        solutions[found.clone()].iter().for_each(|(branch, joints)| each(*branch, *joints));
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// Whether so many samples can be thinned out.
pub(super) fn thins_out<const F: usize>(samples: [u32; F]) -> bool {
    thinned(samples, STRIDE) != samples
}

/// A path near a coarse one. The coarse one finds its way between the stops; finer ones keep to its images.
pub(super) fn search<const N: usize, const F: usize>(
    plan: &Plan<'_, N, F>,
    samples: [u32; F],
) -> Result<Path<N, F>, Stuck> {
    let waypoints = plan.times.len();
    let bounds = with_margin(plan.bounds);
    let plan = Plan { bounds: &bounds, ..*plan };
    let mut passed = every(STRIDE, waypoints);
    let mut path = coarse(&plan, &passed, samples)?;
    let mut stride = STRIDE;
    while stride > 1 {
        stride /= 2;
        let guide = interpolated(&passed, &path, &plan.robot.free());
        let level = every(stride, waypoints);
        match follow(&plan, &level, thinned(samples, stride), &guide) {
            Ok(finer) => (path, passed) = (finer, level),
            // The next level goes on from the one before.
            Err(Stuck::Apart(..) | Stuck::Unreachable(_)) if stride > 1 => {}
            Err(stuck) => return Err(stuck),
        }
    }
    Ok(path)
}

/// The path with more samples about it: twice as many, those it was found with among them. It breaks off where it did.
pub(super) fn refine<const N: usize, const F: usize>(
    plan: &Plan<'_, N, F>,
    path: &mut Path<N, F>,
    samples: &mut [u32; F],
) -> Result<(), Stuck> {
    let range = plan.robot.free();
    *samples = std::array::from_fn(|f| match range[f] {
        FreeRange::Turn => 2 * samples[f],
        FreeRange::Within(..) => 2 * samples[f] - 1,
    });
    let guide = interpolated(&every(1, plan.times.len()), path, &range);
    path.cost = 0.0;
    for run in path.runs() {
        let from = plan.options.from.filter(|_| run.start == 0);
        let plan = Plan { options: &LadderOptions { from, ..*plan.options }, ..*plan };
        let finer = follow(&plan, &run.clone().collect::<Vec<_>>(), *samples, &guide)?;
        path.cost += finer.cost;
        path.nodes[run].copy_from_slice(&finer.nodes);
    }
    Ok(())
}

/// A path through some waypoints, with as many samples as it takes to reach them all.
fn coarse<const N: usize, const F: usize>(
    plan: &Plan<'_, N, F>,
    passed: &[usize],
    samples: [u32; F],
) -> Result<Path<N, F>, Stuck> {
    let mut stride = STRIDE;
    loop {
        match plan.within_stops(passed, thinned(samples, stride), false) {
            Err(Stuck::Unreachable(_)) if stride > 1 => stride /= 2,
            found => return found,
        }
    }
}

/// Bounds that leave a margin beside the stops of joints that wind up, but to every angle an image.
fn with_margin<const N: usize>(bounds: &Bounds<N>) -> Bounds<N> {
    let mut narrower = *bounds;
    for j in 0..N {
        let margin = STOP_MARGIN.min((bounds.upper[j] - bounds.lower[j] - TAU) / 2.0).max(0.0);
        narrower.lower[j] += margin;
        narrower.upper[j] -= margin;
    }
    narrower
}

/// Of each free parameter's samples every so many, but not too few.
fn thinned<const F: usize>(samples: [u32; F], stride: u32) -> [u32; F] {
    samples.map(|n| n.div_ceil(stride).max(FEWEST).min(n))
}

/// Every so many waypoints, and the last.
fn every(stride: u32, waypoints: usize) -> Vec<usize> {
    let mut passed: Vec<usize> = (0..waypoints).step_by(stride as usize).collect();
    if passed.last() != Some(&(waypoints - 1)) {
        passed.push(waypoints - 1);
    }
    passed
}

/// The samples near a guide: of each waypoint a band, which is wider about waypoints where a search was stuck.
struct Bands<const F: usize> {
    /// The free parameters in the middle of each band.
    free: Vec<[f64; F]>,
    samples: [u32; F],
    range: [FreeRange; F],
    half: Vec<u32>,
    /// Whether bands may become wider.
    widens: bool,
}

impl<const F: usize> Bands<F> {
    /// The samples of a waypoint up to `half` from the nearest to its middle.
    fn band(&self, at: usize, half: u32) -> Window<F> {
        let mut window = Window::whole(self.samples);
        for f in 0..F {
            let (count, range) = (self.samples[f], self.range[f]);
            if 2 * half + 1 >= count {
                continue;
            }
            let middle = nearest(range, count, self.free[at][f]);
            window.length[f] = 2 * half + 1;
            window.start[f] = match range {
                FreeRange::Turn => (middle + count - half) % count,
                FreeRange::Within(..) => middle.saturating_sub(half).min(count - window.length[f]),
            };
        }
        window
    }
}

impl<const F: usize> Windows<F> for Bands<F> {
    fn at(&self, at: usize) -> Window<F> {
        self.band(at, self.half[at])
    }

    fn back(&self) -> usize {
        if self.widens { MAX_BACK } else { 0 }
    }

    fn widen(&mut self, at: usize, earliest: usize) -> Option<usize> {
        let about = earliest.max(at.saturating_sub(ABOUT))..(at + ABOUT).min(self.free.len());
        let mut first = None;
        for k in about.filter(|_| self.widens) {
            let (now, wider) = (self.at(k).len(), self.band(k, 2 * self.half[k]).len());
            if wider > now && wider <= WIDEST {
                self.half[k] *= 2;
                first = first.or(Some(k));
            }
        }
        first.filter(|&first| first <= at)
    }
}

/// A path through the waypoints `passed` near a guide.
fn follow<const N: usize, const F: usize>(
    plan: &Plan<'_, N, F>,
    passed: &[usize],
    samples: [u32; F],
    guide: &Guide<N, F>,
) -> Result<Path<N, F>, Stuck> {
    let kinds = Kind::of(plan.bounds, &[true; N]).map(|kind| match kind {
        Kind::Images { .. } => Kind::AsGiven,
        kind => kind,
    });
    let known = guide.free.iter().map(|_| Mutex::default()).collect();
    let kept = Kept { robot: plan.robot, guide, bounds: plan.bounds, kinds, known };
    let plan =
        Plan { robot: &kept, times: plan.times, bounds: plan.bounds, options: plan.options, progress: plan.progress };
    let range = plan.robot.free();
    let half = if F == 1 { HALF } else { HALF_OF_MANY };
    let bands = |free: Vec<[f64; F]>, widens| Bands { half: vec![half; free.len()], free, samples, range, widens };
    let mut around = bands(passed.iter().map(|&waypoint| guide.free[waypoint]).collect(), true);
    let mut best = plan.search(passed, kinds, &mut around, false)?;
    for _ in 1..ROUNDS {
        if !best.nodes.iter().enumerate().any(|(at, node)| on_edge(&node.free, &around.at(at), &range)) {
            break;
        }
        // The best path so far lies in the middle of its bands, so none has to be wider.
        around = bands(best.nodes.iter().map(|node| node.free).collect(), false);
        let path = plan.search(passed, kinds, &mut around, false)?;
        let falls = path.cost < best.cost * (1.0 - LITTLE);
        if path.cost < best.cost {
            best = path;
        }
        if !falls {
            break;
        }
    }
    // Endless joints have begun anew each turn; there is no stop that they could meet.
    let lifted = plan.lift(&mut best, &kinds);
    debug_assert!(lifted.is_ok());
    Ok(best)
}

/// Free parameters and joints of all waypoints, on lines between those of the thinned ones.
fn interpolated<const N: usize, const F: usize>(
    thinned: &[usize],
    path: &Path<N, F>,
    range: &[FreeRange; F],
) -> Guide<N, F> {
    let nodes = &path.nodes;
    let mut guide =
        Guide { free: vec![nodes[0].free], joints: vec![nodes[0].joints], branches: vec![[nodes[0].branch; 2]] };
    for at in 1..thinned.len() {
        let (ends, nodes) = ([thinned[at - 1], thinned[at]], [&nodes[at - 1], &nodes[at]]);
        for waypoint in ends[0] + 1..=ends[1] {
            let share = (waypoint - ends[0]) as f64 / (ends[1] - ends[0]) as f64;
            guide.free.push(std::array::from_fn(|f| {
                let way = nodes[1].free[f] - nodes[0].free[f];
                let way = if range[f] == FreeRange::Turn { wrapped(way) } else { way };
                nodes[0].free[f] + share * way
            }));
            let joint = |j: usize| nodes[0].joints[j] + share * (nodes[1].joints[j] - nodes[0].joints[j]);
            guide.joints.push(std::array::from_fn(joint));
            guide.branches.push([nodes[0].branch, nodes[1].branch]);
        }
    }
    guide
}

/// Whether samples beyond the first or last of the window were left out next to this one.
fn on_edge<const F: usize>(free: &[f64; F], window: &Window<F>, range: &[FreeRange; F]) -> bool {
    (0..F).any(|f| {
        let (count, length) = (window.counts[f], window.length[f]);
        let at = nearest(range[f], count, free[f]);
        let within = (at + count - window.start[f]) % count;
        let open = |end: u32| range[f] == FreeRange::Turn || at != end;
        length < count && ((within == 0 && open(0)) || (within + 1 == length && open(count - 1)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotFn;
    use std::f64::consts::PI;
    use std::ops::ControlFlow;

    #[test]
    fn the_margin_beside_stops_leaves_an_image_of_every_angle() {
        let limits = |reach: f64| Bounds { lower: [-reach, f64::NEG_INFINITY], upper: [reach, reach], ..Bounds::NONE };
        for (reach, expected) in [(10.0, 10.0 - STOP_MARGIN), (PI + 0.03, PI), (PI, PI), (1.0, 1.0)] {
            let narrower = with_margin(&limits(reach));
            assert!((narrower.upper[0] - expected).abs() < 1e-12 && (narrower.lower[0] + expected).abs() < 1e-12);
            assert_eq!((narrower.lower[1], narrower.upper[1]), (f64::NEG_INFINITY, reach - STOP_MARGIN));
        }
    }

    #[test]
    fn going_back_is_as_beginning_anew_with_the_wider_bands() {
        // Slits that the guide does not know of, one of them so early that the search goes back to the first waypoint.
        let slits = [(9, 0.2), (60, 0.4), (64, 0.35), (140, 0.1)];
        let robot = RobotFn {
            waypoints: 200,
            free: [FreeRange::Within(0.0, 1.0)],
            solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| {
                if slits.iter().all(|&(at, middle)| at != i || (free[0] - middle).abs() < 0.02) {
                    each(0, [10.0 * free[0]]);
                }
            },
            posture: |_: usize, _: &[f64; 1], _: u32| None,
        };
        let times: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let bounds = Bounds { velocity: [2.0], ..Bounds::NONE };
        let options = LadderOptions::default();
        let progress = |_: crate::Progress| ControlFlow::Continue(());
        let plan = Plan { robot: &robot, times: &times, bounds: &bounds, options: &options, progress: &progress };
        let passed: Vec<usize> = (0..200).collect();
        let mut bands =
            Bands { free: vec![[0.0]; 200], samples: [100], range: robot.free, half: vec![HALF; 200], widens: true };
        let kinds = [Kind::Circular];
        let found = plan.search(&passed, kinds, &mut bands, false).unwrap();
        assert!(bands.half[0] > HALF && bands.half[60] > bands.half[0] && bands.half[190] == HALF, "{:?}", bands.half);
        bands.widens = false;
        let anew = plan.search(&passed, kinds, &mut bands, false).unwrap();
        assert_eq!((found.nodes, found.cost), (anew.nodes, anew.cost));
    }
}
