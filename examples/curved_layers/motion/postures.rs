//! Postures along one path: which waypoints are in reach, and for each of them a posture.
//!
//! C. Dai 2020, section 4.3.1. A path begins near where the one before ends, on the same branch if it can be followed
//! there: so most transfers are short and straight. And it takes postures with clearance, where a waypoint has some, so that
//! the smooth motion may sway and the nozzle can lift off.

use super::flow::Flow;
use super::robots::Printer;
use super::workcell::{CLEARANCES_MM, Workcell};
use super::{Fault, FaultKind, placed};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::inside;
use curvlay_toolpath::surface::ToolPath;
use curvlay_trajectory::{Bounds, FreeRange, Ladder, LadderOptions, Posture, Robot, plan_ladder};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Waypoints nearer in time than this, in seconds, are one: a controller's cycle is longer.
const LEAST_STEP_S: f64 = 1e-3;

/// A robot without the postures at which something touches (section 3.5.3).
struct Guarded<'a, const N: usize, const F: usize, R> {
    robot: &'a R,
    cell: &'a Workcell<'a, N, F, R>,
    /// How much clearance each waypoint needs: numbers of [`CLEARANCES_MM`].
    clearances: &'a [usize],
    /// The only branch, where not all are wanted.
    branch: Option<u32>,
}

impl<const N: usize, const F: usize, R: Printer<N, F>> Robot<N, F> for Guarded<'_, N, F, R> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; F] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        self.robot.solutions(waypoint, free, &mut |branch, joints| {
            let is_wanted = self.branch.is_none_or(|wanted| wanted == branch);
            if is_wanted && self.cell.may_print(&joints, self.clearances[waypoint]) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// A path before it is planned: its waypoints, as far as they are in reach.
pub struct Prepared<R> {
    pub path: usize,
    pub layer: u32,
    pub sections: Vec<Section<R>>,
    /// Waypoint of the path by waypoint of the motion: those too near in time are left out.
    pub kept: Vec<usize>,
    pub faults: Vec<Fault>,
    pub took: Duration,
}

/// Waypoints in reach, one after the other.
pub struct Section<R> {
    pub first: usize,
    pub part: R,
    pub times: Vec<f64>,
    /// The most clearance there is at each waypoint, at any posture.
    best: Vec<usize>,
}

/// Where the arm is before a path, and on which branch.
#[derive(Clone, Copy, Debug)]
pub struct Before<const N: usize> {
    joints: [f64; N],
    branch: u32,
}

/// A path with a posture for each waypoint.
pub struct Chosen<const N: usize, const F: usize, R> {
    pub prepared: Prepared<R>,
    /// One a section.
    pub ladders: Vec<Ladder<N, F>>,
}

/// Sees which waypoints of a path can be reached, given when each is passed at the planned feed.
pub fn prepare<const N: usize, const F: usize, R: Printer<N, F>>(
    number: usize,
    path: &ToolPath,
    flow: &Flow,
    shift: &Vector3<f64>,
    cell: &Workcell<N, F, R>,
) -> Result<Prepared<R>, Failure> {
    let start = Instant::now();
    let (mut waypoints, mut kept, mut times) = (vec![placed(&path.waypoints[0], shift)], vec![0], vec![0.0]);
    for (place, (waypoint, &now)) in path.waypoints.iter().zip(flow.times()).enumerate().skip(1) {
        if now - times[times.len() - 1] >= LEAST_STEP_S {
            waypoints.push(placed(waypoint, shift));
            kept.push(place);
            times.push(now);
        }
    }
    let all = R::empty()?.with(waypoints);
    let inner = inside(&cell.limits().bounds);
    let needed: [Vec<usize>; CLEARANCES_MM.len()] = std::array::from_fn(|number| vec![number; all.waypoints()]);
    let best = |waypoint: usize| {
        let has = |samples: &[u32; F], clearances: &Vec<usize>| {
            let guarded = Guarded { robot: &all, cell, clearances, branch: None };
            first_posture(&guarded, &inner, waypoint, samples).is_some()
        };
        let found = needed.iter().position(|clearances| has(&R::SAMPLES, clearances));
        found.or_else(|| needed.iter().position(|clearances| has(&R::DENSE, clearances)))
    };
    let best: Vec<Option<usize>> = (0..all.waypoints()).map(best).collect();
    let mut faults = Vec::new();
    for waypoint in (0..best.len()).filter(|&waypoint| best[waypoint].is_none()) {
        let found = first_posture(&all, &inner, waypoint, &R::DENSE);
        let kind = if found.is_some() { FaultKind::Blocked } else { FaultKind::Unreachable };
        let what = found.and_then(|joints| cell.in_the_way(&joints)).unwrap_or_default();
        faults.push(Fault { layer: path.layer, path: number, kind, waypoint: kept[waypoint], what });
    }
    let mut sections = Vec::new();
    let mut first = 0;
    for same in best.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let range = first..first + same.len();
        first = range.end;
        let best: Option<Vec<usize>> = same.iter().copied().collect();
        if let Some(best) = best {
            sections.push(Section {
                first: range.start,
                part: all.part(range.clone()),
                times: times[range].to_vec(),
                best,
            });
        }
    }
    Ok(Prepared { path: number, layer: path.layer, sections, kept, faults, took: start.elapsed() })
}

/// Chooses a posture for each waypoint of a path, beginning near where the arm is before; on the same branch, if the path
/// can be followed on it. `before` becomes where the arm is then.
pub fn choose<const N: usize, const F: usize, R: Printer<N, F>>(
    mut prepared: Prepared<R>,
    before: &mut Option<Before<N>>,
    cell: &Workcell<N, F, R>,
) -> Result<Chosen<N, F, R>, Failure> {
    let start = Instant::now();
    let mut ladders = Vec::new();
    for Section { part, times, best, .. } in &prepared.sections {
        // Where a joint is too slow for the feed, the motion goes slower.
        let inner = Bounds { velocity: [f64::INFINITY; N], ..inside(&cell.limits().bounds) };
        let plan = |enough: usize, branch, (samples, doublings), breaks| {
            let clearances: Vec<usize> = best.iter().map(|&best| best.max(enough)).collect();
            let from = before.map(|before| before.joints);
            let step = R::STEP;
            let options = LadderOptions { samples, doublings, step, breaks, from, ..LadderOptions::default() };
            let guarded = Guarded { robot: part, cell, clearances: &clearances, branch };
            plan_ladder(&guarded, times, &inner, &options, &|_| ControlFlow::Continue(()))
        };
        let same = before.map(|before| before.branch);
        // Less clearance than the best of a waypoint is taken only where there is no path otherwise.
        let (few, many) = ((R::SAMPLES, 0), (R::NEAR, R::DOUBLINGS));
        let tries = [(0, same, few), (0, None, few), (1, same, few), (1, same, many)];
        let found = tries.iter().find_map(|&(enough, branch, samples)| plan(enough, branch, samples, false).ok());
        // Broken off it is as well with fewer samples, and on one branch: all of them together take minutes on a long path.
        let broken_off = |branch| plan(1, branch, (R::NEAR, 0), true);
        let ladder = found.map_or_else(|| broken_off(same).or_else(|_| broken_off(None)), Ok).map_err(failure)?;
        *before = ladder.rungs.last().map(|rung| Before { joints: rung.joints, branch: rung.branch });
        ladders.push(ladder);
    }
    prepared.took += start.elapsed();
    Ok(Chosen { prepared, ladders })
}

/// A posture within the stops at the first sample of the free parameters that has one.
fn first_posture<const N: usize, const F: usize>(
    robot: &impl Robot<N, F>,
    bounds: &Bounds<N>,
    waypoint: usize,
    samples: &[u32; F],
) -> Option<[f64; N]> {
    let ranges = robot.free();
    (0..samples.iter().product()).find_map(|sample: u32| {
        let mut rest = sample;
        let free = std::array::from_fn(|f| {
            let k = rest % samples[f];
            rest /= samples[f];
            match ranges[f] {
                FreeRange::Turn => TAU * f64::from(k) / f64::from(samples[f]),
                FreeRange::Within(least, most) => {
                    least + (most - least) * f64::from(k) / f64::from(samples[f].max(2) - 1)
                }
            }
        });
        let mut found = None;
        robot.solutions(waypoint, &free, &mut |_, joints| {
            let fits = (0..N).all(|j| bounds.lower[j] <= joints[j] && joints[j] <= bounds.upper[j]);
            found = found.or(fits.then_some(joints));
        });
        found
    })
}
