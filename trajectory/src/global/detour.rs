//! Another way where bounds are missed: a search over samples of the tool angle, local in the path and global in the
//! angle.
//!
//! A path of least jerk may run into a place where its tool angle turns the wrong way round: descent then presses the
//! spline against the bounds and never leaves the valley. Here the waypoints around such places are gone through once
//! more, over all values of the angle, for the best chain between the ends of the window, which stay as they are
//! ([`super::chain`]). What it finds is a rough start for further rounds, no result.

use super::chain::{Node, Price, best_chain};
use super::point::Point;
use crate::{Bounds, FreeRange, Robot, Timeline};
use std::f64::consts::TAU;
use std::ops::Range;

/// Waypoints on either side of what is missed that may go another way: about seven seconds at 0.18 s a step, in which
/// the tool turns once at 1 rad/s. With fewer a turn does not fit in; time grows with them.
const WINDOW_WAYPOINTS: usize = 40;

/// Values of the angle, 2 degrees apart. Coarser ones bend the chain by more than bounds allow, finer ones take the cube
/// of the time.
const ANGLE_SAMPLES: usize = 180;

/// Waypoints that are gone through at most; paths with more to mend are beyond mending.
const MAX_WINDOW: usize = 400;

/// The free parameters of all waypoints with other ways around the `missed` ones; `None` where no parameter is an
/// angle, or too much is missed, or no way is found.
pub(super) fn detour<const N: usize, const F: usize>(
    robot: &dyn Robot<N, F>,
    branches: &[u32],
    line: &Timeline,
    bounds: &Bounds<N>,
    point: &Point<N, F>,
    missed: &[usize],
) -> Option<Vec<[f64; F]>> {
    let angle = robot.free().iter().position(|range| *range == FreeRange::Turn)?;
    let windows = windows(missed, point.free.len());
    if windows.is_empty() || windows.iter().map(Range::len).sum::<usize>() > MAX_WINDOW {
        return None;
    }
    let mut free = point.free.clone();
    let price = Price::new(bounds);
    let times = &line.times()[line.waypoints().start + 1..];
    for window in windows {
        let all: Vec<Vec<Node<N, F>>> = window
            .clone()
            .map(|waypoint| {
                let fixed = waypoint < window.start + 2 || waypoint + 2 >= window.end;
                nodes(robot, waypoint, branches[waypoint], &point.free[waypoint], (!fixed).then_some(angle), bounds)
            })
            .collect();
        // Where the chain of the present values is one of them, what costs more is no way.
        let present: Option<Vec<[f64; N]>> =
            all.iter().map(|nodes| Some(nodes.iter().find(|node| node.present)?.joints)).collect();
        let times = &times[window.clone()];
        let most = present.map_or(f64::INFINITY, |joints| price.chain(&joints, times));
        let chain = best_chain(&all, times, angle, &price, most)?;
        for (waypoint, value) in window.zip(chain) {
            free[waypoint] = value;
        }
    }
    Some(free)
}

/// The missed waypoints and those around them, joined where they overlap.
fn windows(missed: &[usize], count: usize) -> Vec<Range<usize>> {
    let mut windows: Vec<Range<usize>> = Vec::new();
    for &waypoint in missed {
        let (start, end) = (waypoint.saturating_sub(WINDOW_WAYPOINTS), (waypoint + WINDOW_WAYPOINTS + 1).min(count));
        match windows.last_mut() {
            Some(last) if start <= last.end => last.end = last.end.max(end),
            _ => windows.push(start..end),
        }
    }
    windows.retain(|window| window.len() > 5);
    windows
}

/// The samples of a waypoint on its branch; without an angle only the present one.
fn nodes<const N: usize, const F: usize>(
    robot: &dyn Robot<N, F>,
    waypoint: usize,
    branch: u32,
    present: &[f64; F],
    angle: Option<usize>,
    bounds: &Bounds<N>,
) -> Vec<Node<N, F>> {
    let mut found = Vec::new();
    for sample in 0..angle.map_or(1, |_| ANGLE_SAMPLES) {
        let mut free = *present;
        if let Some(angle) = angle {
            free[angle] += TAU * sample as f64 / ANGLE_SAMPLES as f64;
        }
        robot.solutions(waypoint, &free, &mut |of, joints| {
            if of == branch && (0..N).all(|joint| bounds.has_image(joint, joints[joint])) {
                found.push(Node { free, joints, present: sample == 0 });
            }
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotFn;

    #[test]
    fn samples_are_on_the_branch_and_within_the_stops() {
        let robot = RobotFn {
            waypoints: 1,
            free: [FreeRange::Turn],
            solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| {
                each(0, [-free[0]]);
                each(1, [free[0]]);
            },
            posture: |_: usize, _: &[f64; 1], _: u32| None,
        };
        let bounds = Bounds { lower: [-0.2], upper: [1.0], ..Bounds::NONE };
        let step = TAU / ANGLE_SAMPLES as f64;
        let found = nodes(&robot, 0, 1, &[0.3], Some(0), &bounds);
        // Every angle of the circle from -0.2 to 1, the present one first.
        assert_eq!(found.len(), 1 + (0.5 / step) as usize + (0.7 / step) as usize);
        for (at, node) in found.iter().enumerate() {
            let image = crate::angle::wrapped(node.joints[0]);
            assert!((-0.2..=1.0).contains(&image), "{image}");
            assert_eq!((node.present, node.joints[0].to_bits()), (at == 0, node.free[0].to_bits()));
            assert!((((node.free[0] - 0.3) / step).round() * step + 0.3 - node.free[0]).abs() < 1e-12);
        }
        let alone = nodes(&robot, 0, 0, &[0.1], None, &bounds);
        assert!(alone.len() == 1 && alone[0].present && (alone[0].joints[0] + 0.1).abs() < 1e-12);
        assert!(nodes(&robot, 0, 0, &[0.3], None, &bounds).is_empty());
    }
}
