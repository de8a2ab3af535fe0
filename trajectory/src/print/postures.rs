//! Postures along one path: which waypoints are in reach, and for each of them a posture.
//!
//! C. Dai 2020, section 4.3.1. A path begins near where the one before ends, on the same branch if it can be followed
//! there: so most transfers are short and straight. And it takes postures with clearance, where a waypoint has some, so that
//! the smooth motion may sway and the nozzle can lift off.

use super::options::{PrintError, PrintPath};
use super::plan::{Fault, FaultKind};
use super::run_plan::Task;
use super::workcell::{Clearance, OnPath, PrintRobot, PrintWorkcell, Waypoint};
use crate::robot::{FreeRange, Posture, Robot};
use crate::{Bounds, Ladder, LadderError, LadderOptions, plan_ladder};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::time::{Duration, Instant};

/// Waypoints nearer in time than this, in seconds, are one: a controller's cycle is longer.
const MIN_STEP_S: f64 = 1e-3;

/// A robot without the postures at which something touches (section 3.5.3).
struct Guarded<'a, R, C> {
    on_path: OnPath<'a, R>,
    workcell: &'a C,
    /// How much clearance each waypoint needs.
    clearances: &'a [Clearance],
    /// The only branch, where not all are wanted.
    branch: Option<u32>,
}

impl<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>> Robot<N, F> for Guarded<'_, R, C> {
    fn waypoints(&self) -> usize {
        self.on_path.waypoints.len()
    }

    fn free(&self) -> [FreeRange; F] {
        self.on_path.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        self.on_path.solutions(waypoint, free, &mut |branch, joints| {
            let is_wanted = self.branch.is_none_or(|wanted| wanted == branch);
            if is_wanted && self.workcell.keeps(&joints, self.clearances[waypoint]) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.on_path.posture(waypoint, free, branch)
    }
}

/// A path before it is planned: its waypoints that are in reach.
#[derive(Clone)]
pub(super) struct Prepared {
    pub path: usize,
    pub layer: u32,
    pub sections: Vec<Section>,
    /// Waypoint of the path by waypoint of the motion: those too near in time are left out.
    pub kept: Vec<usize>,
    pub faults: Vec<Fault>,
    pub took: Duration,
}

/// Waypoints in reach, one after the other.
#[derive(Clone)]
pub(super) struct Section {
    pub first: usize,
    pub waypoints: Vec<Waypoint>,
    pub times: Vec<f64>,
    /// The most clearance there is at each waypoint, at any posture.
    best: Vec<Clearance>,
}

/// Where the arm is before a path, and on which branch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before<const N: usize> {
    joints: [f64; N],
    branch: u32,
}

/// A path with a posture for each waypoint.
#[derive(Clone)]
pub(super) struct Chosen<const N: usize, const F: usize> {
    pub prepared: Prepared,
    /// One a section.
    pub ladders: Vec<Ladder<N, F>>,
}

/// Sees which waypoints of a path can be reached.
pub(super) fn prepare<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    number: usize,
    path: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Prepared, PrintError> {
    let start = Instant::now();
    let (mut waypoints, mut kept, mut times) = (vec![path.waypoints[0]], vec![0], vec![path.times[0]]);
    for (place, (waypoint, &now)) in path.waypoints.iter().zip(path.times).enumerate().skip(1) {
        if now - times[times.len() - 1] >= MIN_STEP_S {
            waypoints.push(*waypoint);
            kept.push(place);
            times.push(now);
        }
    }
    let (options, inner) = (task.options, task.inside());
    let needed = Clearance::ALL.map(|clearance| vec![clearance; waypoints.len()]);
    let on_path = || OnPath { robot: task.robot, waypoints: &waypoints };
    let best = |waypoint: usize| {
        if (task.stopped)() {
            return Err(PrintError::Cancelled);
        }
        let with = |samples: &[u32; F]| {
            let has = |clearances: &&Vec<Clearance>| {
                let guarded = Guarded { on_path: on_path(), workcell, clearances, branch: None };
                first_posture(&guarded, &inner, waypoint, samples).is_some()
            };
            needed.iter().find(has).map(|clearances| clearances[waypoint])
        };
        Ok(with(&options.samples).or_else(|| with(&options.dense_samples)))
    };
    let best: Vec<Option<Clearance>> = (0..waypoints.len()).map(best).collect::<Result<_, _>>()?;
    let mut faults = Vec::new();
    for waypoint in (0..best.len()).filter(|&waypoint| best[waypoint].is_none()) {
        let found = first_posture(&on_path(), &inner, waypoint, &options.dense_samples);
        let kind = if found.is_some() { FaultKind::Blocked } else { FaultKind::Unreachable };
        let what = found.and_then(|joints| workcell.obstacle(&joints)).unwrap_or_default();
        faults.push(Fault { layer: path.layer, path: number, kind, waypoint: kept[waypoint], what });
    }
    let mut sections = Vec::new();
    let mut first = 0;
    for same in best.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let range = first..first + same.len();
        first = range.end;
        let best: Option<Vec<Clearance>> = same.iter().copied().collect();
        if let Some(best) = best {
            let (waypoints, times) = (waypoints[range.clone()].to_vec(), times[range.clone()].to_vec());
            sections.push(Section { first: range.start, waypoints, times, best });
        }
    }
    Ok(Prepared { path: number, layer: path.layer, sections, kept, faults, took: start.elapsed() })
}

/// How a ladder along a section is looked for.
#[derive(Clone, Copy)]
struct Search<const N: usize, const F: usize> {
    /// How much clearance waypoints keep that have so much.
    enough: Clearance,
    /// The only branch, where not all are wanted.
    branch: Option<u32>,
    /// Samples of the free parameters, and how often they are doubled.
    samples: ([u32; F], u32),
    /// Whether it may break off.
    breaks: bool,
    /// Where the arm is before.
    from: Option<[f64; N]>,
}

/// A ladder along a section.
fn ladder<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    Section { waypoints, times, best, .. }: &Section,
    Search { enough, branch, samples: (samples, doublings), breaks, from }: Search<N, F>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Ladder<N, F>, LadderError> {
    // Where a joint is too slow for the feed, the motion goes slower.
    let inner = Bounds { velocity: [f64::INFINITY; N], ..task.inside() };
    let clearances: Vec<Clearance> = best.iter().map(|&best| best.max(enough)).collect();
    let step = task.options.max_step;
    let options = LadderOptions { samples, doublings, step, breaks, from, ..LadderOptions::default() };
    let guarded =
        Guarded { on_path: OnPath { robot: task.robot, waypoints }, workcell, clearances: &clearances, branch };
    plan_ladder(&guarded, times, &inner, &options, &|_| task.flow())
}

/// Chooses a posture for each waypoint of a path, beginning near where the arm is before; on the same branch, if the path
/// can be followed on it. `before` becomes where the arm is then.
pub(super) fn choose<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    mut prepared: Prepared,
    before: &mut Option<Before<N>>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Chosen<N, F>, PrintError> {
    let start = Instant::now();
    let mut ladders = Vec::new();
    for section in &prepared.sections {
        let from = before.map(|before| before.joints);
        let plan = |enough, branch, samples, breaks| {
            ladder(section, Search { enough, branch, samples, breaks, from }, task, workcell)
        };
        let same = before.map(|before| before.branch);
        // Less clearance than the best of a waypoint is taken only where there is no path otherwise.
        let (few, many) = ((task.options.samples, 0), (task.options.near_samples, task.options.doublings));
        let [wide, narrow, least] = Clearance::ALL;
        let tries =
            [(wide, same, few), (wide, None, few), (narrow, same, few), (narrow, same, many), (least, same, many)];
        let found = tries.iter().find_map(|&(enough, branch, samples)| plan(enough, branch, samples, false).ok());
        // A path that breaks off anyway gets fewer samples and one branch: all together take minutes on a long path.
        let broken_off = |branch| plan(narrow, branch, (task.options.near_samples, 0), true);
        let ladder = found.map_or_else(|| broken_off(same).or_else(|_| broken_off(None)), Ok);
        let ladder = ladder.map_err(|error| match error {
            LadderError::Cancelled => PrintError::Cancelled,
            error => PrintError::Ladder { path: prepared.path, error },
        })?;
        *before = ladder.nodes.last().map(|node| Before { joints: node.joints, branch: node.branch });
        ladders.push(ladder);
    }
    prepared.took += start.elapsed();
    Ok(Chosen { prepared, ladders })
}

/// The same path with other postures, on one branch after the other, those with the most clearance first; each unbroken; first all
/// that few samples find. The first postures are near `from`.
pub(super) fn others<'a, const N: usize, const F: usize, R: PrintRobot<N, F>>(
    Prepared { sections, .. }: &'a Prepared,
    from: Option<[f64; N]>,
    task: &'a Task<'_, N, F, R>,
    workcell: &'a impl PrintWorkcell<N>,
) -> impl Iterator<Item = Vec<Ladder<N, F>>> + 'a {
    let mut branches = BTreeSet::new();
    if let Some(first) = sections.first() {
        let on_path = OnPath { robot: task.robot, waypoints: &first.waypoints };
        for free in samples_of(&on_path.free(), &task.options.samples) {
            on_path.solutions(0, &free, &mut |branch, _| {
                branches.insert(branch);
            });
        }
    }
    let (few, many) = ((task.options.samples, 0), (task.options.near_samples, task.options.doublings));
    let each = [few, many].into_iter().flat_map(move |samples| {
        let branches = branches.clone();
        let with = move |enough| branches.clone().into_iter().map(move |branch| (samples, enough, branch));
        Clearance::ALL.into_iter().flat_map(with)
    });
    each.filter_map(move |(samples, enough, branch)| {
        let search = Search { enough, branch: Some(branch), samples, breaks: false, from };
        sections.iter().map(|section| ladder(section, search, task, workcell).ok()).collect()
    })
}

/// A posture within the stops, but for whole turns, at the first sample of the free parameters that has one.
fn first_posture<const N: usize, const F: usize>(
    robot: &impl Robot<N, F>,
    bounds: &Bounds<N>,
    waypoint: usize,
    samples: &[u32; F],
) -> Option<[f64; N]> {
    samples_of(&robot.free(), samples).find_map(|free| {
        let mut found = None;
        robot.solutions(waypoint, &free, &mut |_, joints| {
            let fits = (0..N).all(|joint| bounds.has_image(joint, joints[joint]));
            found = found.or(fits.then_some(joints));
        });
        found
    })
}

/// Free parameters, evenly over their ranges.
pub(super) fn samples_of<const F: usize>(
    ranges: &[FreeRange; F],
    samples: &[u32; F],
) -> impl Iterator<Item = [f64; F]> {
    let samples: [u32; F] = std::array::from_fn(|f| ranges[f].samples(samples[f]));
    (0..samples.iter().product()).map(move |sample: u32| {
        let mut rest = sample;
        std::array::from_fn(|f| {
            let k = rest % samples[f];
            rest /= samples[f];
            match ranges[f] {
                FreeRange::Turn => TAU * f64::from(k) / f64::from(samples[f]),
                FreeRange::Within(least, most) => {
                    least + (most - least) * f64::from(k) / f64::from(samples[f].max(2) - 1)
                }
            }
        })
    })
}
