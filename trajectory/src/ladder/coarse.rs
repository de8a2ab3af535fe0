//! From a coarse path to a fine one.
//!
//! The coarse path goes through every eighth waypoint, which leaves the joints eight times as far to move, so that an
//! eighth of the samples is fine enough to tell good paths from bad ones. Then come every fourth waypoint with a fourth
//! of the samples, every second, and all. Squared steps add up alike on all these levels: a step of so many waypoints
//! costs the square of their number, and so does one of so many samples. So the path of one level lies near the best one
//! of the next, and a narrow band of samples around it, on the branches that it uses, holds that. Where the result touches
//! the edge of its band, the band is laid around the result and the search goes on. Bands overlap from round to round,
//! so solutions are kept: they cost more than the search between them.

use super::nodes::{Kind, Window, nearest, wrapped};
use super::search::{Path, Stuck};
use super::{Climb, Rung};
use crate::robot::{FreeRange, Posture, Robot};
use std::sync::{Mutex, PoisonError};

/// Every so many waypoints and samples, to begin with: a power of two. With 16 the bench's dome ends in another valley.
const STRIDE: u32 = 8;

/// Samples on either side of the path of the level before, which has samples twice as far apart. With 3 the band is laid
/// anew more often and may end beside the best path; with 6 more samples are solved than rounds are saved.
const HALF: u32 = 4;

/// Fewer samples than this are not thinned out: they would not find their way.
const FEWEST: u32 = 12;

/// The band is moved at most so often; then its path is taken as it is.
const ROUNDS: usize = 12;

/// Free parameters around which the band is laid, and branches, for every waypoint.
struct Guide<const F: usize> {
    free: Vec<[f64; F]>,
    branches: Vec<[u32; 2]>,
}

/// Free parameters of a waypoint that have been asked for with the number of solutions up to theirs, and the solutions.
#[derive(Debug)]
struct Known<const N: usize, const F: usize> {
    asked: Vec<([f64; F], usize)>,
    solutions: Vec<(u32, [f64; N])>,
}

impl<const N: usize, const F: usize> Default for Known<N, F> {
    fn default() -> Self {
        Known { asked: Vec::new(), solutions: Vec::new() }
    }
}

/// A robot that solves every sample once, on the branches of the guide.
struct Kept<'a, const N: usize, const F: usize, R: ?Sized> {
    robot: &'a R,
    branches: &'a [[u32; 2]],
    known: Vec<Mutex<Known<N, F>>>,
}

impl<const N: usize, const F: usize, R: Robot<N, F> + ?Sized> Robot<N, F> for Kept<'_, N, F, R> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; F] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        let mut known = self.known[waypoint].lock().unwrap_or_else(PoisonError::into_inner);
        let Known { asked, solutions } = &mut *known;
        let same = |other: &[f64; F]| (0..F).all(|f| other[f].to_bits() == free[f].to_bits());
        let at = asked.iter().position(|(other, _)| same(other)).unwrap_or_else(|| {
            self.robot.solutions(waypoint, free, &mut |branch, joints| {
                if self.branches[waypoint].contains(&branch) {
                    solutions.push((branch, joints));
                }
            });
            asked.push((*free, solutions.len()));
            asked.len() - 1
        });
        let first = at.checked_sub(1).map_or(0, |before| asked[before].1);
        solutions[first..asked[at].1].iter().for_each(|(branch, joints)| each(*branch, *joints));
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// A path near a coarse one; `None` when there is none, or nothing to thin out.
pub(super) fn search<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    climb: &Climb<'_, N, F, R>,
    samples: [u32; F],
    kinds: [Kind; N],
) -> Result<Option<Path<N, F>>, Stuck> {
    let waypoints = climb.times.len();
    let coarse = thinned(samples, STRIDE);
    if waypoints <= 2 * STRIDE as usize || coarse == samples {
        return Ok(None);
    }
    let mut passed = every(STRIDE, waypoints);
    let found = climb.search(&passed, kinds, &|_| Window::whole(coarse), false);
    let Some(mut path) = none_if_stuck(found)? else { return Ok(None) };
    let mut stride = STRIDE;
    while stride > 1 {
        stride /= 2;
        let guide = interpolated(&passed, &path.rungs, &climb.robot.free());
        let level = every(stride, waypoints);
        match follow(climb, &level, thinned(samples, stride), kinds, guide, stride == 1)? {
            Some(finer) => (path, passed) = (finer, level),
            None if stride == 1 => return Ok(None),
            // The next level goes on from the one before.
            None => {}
        }
    }
    Ok(Some(path))
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

/// A path through the waypoints `passed` near a guide.
///
/// `widen`: whether to widen the band as long as there is none in it.
fn follow<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    climb: &Climb<'_, N, F, R>,
    passed: &[usize],
    samples: [u32; F],
    kinds: [Kind; N],
    guide: Guide<F>,
    widen: bool,
) -> Result<Option<Path<N, F>>, Stuck> {
    let range = climb.robot.free();
    let Guide { mut free, branches } = guide;
    let known = free.iter().map(|_| Mutex::default()).collect();
    let kept = Kept { robot: climb.robot, branches: &branches, known };
    let climb = Climb {
        robot: &kept,
        times: climb.times,
        bounds: climb.bounds,
        options: climb.options,
        progress: climb.progress,
    };
    let mut half = [HALF; F];
    let mut best: Option<Path<N, F>> = None;
    for _ in 0..ROUNDS {
        let window = |at: usize| band(&free[passed[at]], samples, half, &range);
        let Some(path) = none_if_stuck(climb.search(passed, kinds, &window, false))? else {
            if !widen || (0..F).all(|f| 2 * half[f] + 1 >= samples[f]) {
                return Ok(best);
            }
            half = half.map(|half| 2 * half);
            continue;
        };
        let touches = |at: usize, rung: &Rung<N, F>| on_edge(&rung.free, &window(at), &range);
        let done = !path.rungs.iter().enumerate().any(|(at, rung)| touches(at, rung));
        let better = best.as_ref().is_none_or(|best| path.cost < best.cost);
        if better {
            passed.iter().zip(&path.rungs).for_each(|(&waypoint, rung)| free[waypoint] = rung.free);
            best = Some(path);
        }
        if done || !better {
            break;
        }
    }
    Ok(best)
}

fn none_if_stuck<const N: usize, const F: usize>(
    found: Result<Path<N, F>, Stuck>,
) -> Result<Option<Path<N, F>>, Stuck> {
    match found {
        Ok(path) => Ok(Some(path)),
        Err(Stuck::Failed(error)) => Err(Stuck::Failed(error)),
        Err(_) => Ok(None),
    }
}

/// Free parameters of all waypoints, on lines between those of the thinned ones.
fn interpolated<const N: usize, const F: usize>(
    thinned: &[usize],
    rungs: &[Rung<N, F>],
    range: &[FreeRange; F],
) -> Guide<F> {
    let mut guide = Guide { free: vec![rungs[0].free], branches: vec![[rungs[0].branch; 2]] };
    for (ends, rungs) in thinned.windows(2).zip(rungs.windows(2)) {
        for waypoint in ends[0] + 1..=ends[1] {
            let share = (waypoint - ends[0]) as f64 / (ends[1] - ends[0]) as f64;
            guide.free.push(std::array::from_fn(|f| {
                let way = rungs[1].free[f] - rungs[0].free[f];
                let way = if range[f] == FreeRange::Turn { wrapped(way) } else { way };
                rungs[0].free[f] + share * way
            }));
            guide.branches.push([rungs[0].branch, rungs[1].branch]);
        }
    }
    guide
}

/// The samples up to `half` from the nearest to `free`.
fn band<const F: usize>(free: &[f64; F], samples: [u32; F], half: [u32; F], range: &[FreeRange; F]) -> Window<F> {
    let mut window = Window::whole(samples);
    for f in 0..F {
        let (count, middle) = (samples[f], nearest(range[f], samples[f], free[f]));
        if 2 * half[f] + 1 >= count {
            continue;
        }
        window.length[f] = 2 * half[f] + 1;
        window.start[f] = match range[f] {
            FreeRange::Turn => (middle + count - half[f]) % count,
            FreeRange::Within(..) => middle.saturating_sub(half[f]).min(count - window.length[f]),
        };
    }
    window
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
