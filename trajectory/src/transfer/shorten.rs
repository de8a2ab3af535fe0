//! Making a way shorter in time: corners left out, corners cut, corners moved.
//!
//! R. Geraerts, M. Overmars, *Creating high-quality paths for motion planning*, IJRR 26(8), 2007, but measured in seconds:
//! the motion rests at each corner, so a corner less is often worth more than a shorter line.

use super::checks::Checks;
use super::space::FreeSpace;
use super::timing::curve;
use crate::bounds::Bounds;
use crate::random::Random;
use crate::vectors::square;

/// After so many attempts lines that only seem free are proven: at first, and at most. With fewer, lines are proven that are
/// soon gone again; with more, one that is blocked takes more of what was gained after it. So it doubles with each proof that
/// holds, and falls to a quarter with one that does not.
const UNPROVEN: [usize; 2] = [4, 64];

/// A way that becomes shorter: what is proven, and what came of it since.
struct Shortened<const N: usize> {
    /// The first is proven, each of the others takes less time than the one before.
    versions: Vec<Vec<[f64; N]>>,
}

impl<const N: usize> Shortened<N> {
    fn last(&self) -> &[[f64; N]] {
        self.versions.last().map_or(&[], Vec::as_slice)
    }

    /// Back to the last version that is proven to be free; whether that is the last of all.
    fn prove<S: FreeSpace<N> + ?Sized>(&mut self, checks: &mut Checks<N, S>) -> bool {
        let count = self.versions.len();
        while self.versions.len() > 1 && checks.first_blocked(self.last()).is_some() {
            self.versions.pop();
        }
        let kept = self.versions.len();
        self.versions.drain(..kept - 1);
        kept == count
    }

    fn replace(&mut self, first: usize, last: usize, corners: &[[f64; N]]) {
        let mut new = self.last().to_vec();
        new.splice(first + 1..last, corners.iter().copied());
        self.versions.push(new);
    }

    /// From each corner straight to the last one that can be reached.
    fn skip<S: FreeSpace<N> + ?Sized>(&mut self, checks: &Checks<N, S>) {
        let mut at = 0;
        while at + 2 < self.last().len() {
            let path = self.last();
            let reached = (at + 2..path.len()).rev().find(|&last| checks.seems_free(&path[at], &path[last]));
            if let Some(last) = reached {
                self.replace(at, last, &[]);
            }
            at += 1;
        }
    }
}

/// A way between the same ends that takes no longer. Each line of `path` is proven, and each line of the result.
pub(super) fn shorten<const N: usize, S: FreeSpace<N> + ?Sized>(
    path: Vec<[f64; N]>,
    bounds: &Bounds<N>,
    checks: &mut Checks<N, S>,
    attempts: usize,
    random: &mut Random,
) -> Vec<[f64; N]> {
    let mut way = Shortened { versions: vec![path] };
    way.skip(checks);
    way.prove(checks);
    let (mut unproven, mut most_unproven) = (0, UNPROVEN[0]);
    for _ in 0..attempts {
        let path = way.last();
        if path.len() < 3 {
            break;
        }
        // A corner is moved, or cut off between two points of the lines that meet there or farther away.
        let moved = if random.unit() < 0.5 { move_corner(path, random) } else { cut(path, random) };
        if let Some(Change { first, last, corners }) = moved {
            let within = |corner: &[f64; N]| (0..N).all(|j| (bounds.lower[j]..=bounds.upper[j]).contains(&corner[j]));
            let new: Vec<[f64; N]> =
                path[first..=first].iter().chain(&corners).chain(&path[last..=last]).copied().collect();
            if corners.iter().all(within)
                && seconds(&new, bounds) < seconds(&path[first..=last], bounds)
                && corners.iter().all(|corner| checks.posture(corner))
                && new.windows(2).all(|ends| checks.seems_free(&ends[0], &ends[1]))
            {
                way.replace(first, last, &corners);
            }
        }
        unproven += 1;
        if unproven >= most_unproven {
            most_unproven =
                if way.prove(checks) { UNPROVEN[1].min(2 * most_unproven) } else { most_unproven.div_ceil(4) };
            unproven = 0;
        }
    }
    way.skip(checks);
    way.prove(checks);
    way.versions.swap_remove(0)
}

/// Between two corners that stay, new ones.
struct Change<const N: usize> {
    first: usize,
    last: usize,
    corners: Vec<[f64; N]>,
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
