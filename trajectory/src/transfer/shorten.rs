//! Making a way shorter in time: corners left out, corners cut, corners moved.
//!
//! R. Geraerts, M. Overmars, *Creating high-quality paths for motion planning*, IJRR 26(8), 2007, but measured in seconds:
//! the motion rests at each corner, so a corner less is often worth more than a shorter line.

use super::curve;
use super::space::FreeSpace;
use super::tree::square;
use crate::bounds::Bounds;
use crate::random::Random;

pub(super) fn shorten<const N: usize>(
    path: &mut Vec<[f64; N]>,
    bounds: &Bounds<N>,
    space: &(impl FreeSpace<N> + ?Sized),
    attempts: usize,
    random: &mut Random,
) {
    if path.len() < 3 {
        return;
    }
    skip(path, space);
    for _ in 0..attempts {
        if path.len() < 3 {
            return;
        }
        // A corner is moved, or cut off between two points of the lines that meet there or farther away.
        let moved = if random.unit() < 0.5 { move_corner(path, random) } else { cut(path, random) };
        let Some(Change { first, last, corners }) = moved else { continue };
        let within = |corner: &[f64; N]| (0..N).all(|j| (bounds.lower[j]..=bounds.upper[j]).contains(&corner[j]));
        if !corners.iter().all(within) {
            continue;
        }
        let mut new = vec![path[first]];
        new.extend(&corners);
        new.push(path[last]);
        if seconds(&new, bounds) >= seconds(&path[first..=last], bounds) {
            continue;
        }
        if corners.iter().all(|corner| space.posture_free(corner))
            && new.windows(2).all(|ends| space.free(&ends[0], &ends[1]))
        {
            path.splice(first + 1..last, corners);
        }
    }
    skip(path, space);
}

/// Between two corners that stay, new ones.
struct Change<const N: usize> {
    first: usize,
    last: usize,
    corners: Vec<[f64; N]>,
}

/// From each corner straight to the last one that can be reached.
fn skip<const N: usize>(path: &mut Vec<[f64; N]>, space: &(impl FreeSpace<N> + ?Sized)) {
    let mut at = 0;
    while at + 2 < path.len() {
        let reached = (at + 2..path.len()).rev().find(|&last| space.free(&path[at], &path[last]));
        if let Some(last) = reached {
            path.drain(at + 1..last);
        }
        at += 1;
    }
}

fn move_corner<const N: usize>(path: &[[f64; N]], random: &mut Random) -> Option<Change<N>> {
    let at = 1 + random.below(path.len() - 2);
    let (before, corner, after) = (path[at - 1], path[at], path[at + 1]);
    // Towards the line between its neighbours, and a little aside.
    let (share, along) = (random.unit(), random.unit());
    let far = 0.3 * square(&before, &after).sqrt() * random.unit();
    let aside: [f64; N] = random.in_ball(far);
    let to = |j: usize| {
        let line = before[j] + (after[j] - before[j]) * along;
        corner[j] + share * (line - corner[j]) + aside[j]
    };
    Some(Change { first: at - 1, last: at + 1, corners: vec![std::array::from_fn(to)] })
}

fn cut<const N: usize>(path: &[[f64; N]], random: &mut Random) -> Option<Change<N>> {
    let (a, b) = (random.below(path.len() - 1), random.below(path.len() - 1));
    let (first, second) = (a.min(b), a.max(b));
    if first == second {
        return None;
    }
    let point = |line: usize, share: f64| -> [f64; N] {
        std::array::from_fn(|j| path[line][j] + (path[line + 1][j] - path[line][j]) * share)
    };
    let corners = vec![point(first, random.unit()), point(second, random.unit())];
    Some(Change { first, last: second + 1, corners })
}

pub(super) fn seconds<const N: usize>(path: &[[f64; N]], bounds: &Bounds<N>) -> f64 {
    path.windows(2).map(|ends| curve(&ends[0], &ends[1], bounds).map_or(f64::INFINITY, |c| c.duration())).sum()
}
