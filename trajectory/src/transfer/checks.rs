//! Checks of lines: guessed by a few postures first, proven only where it counts.
//!
//! A proof of a motion costs as much as tens of postures, and most lines that a search tries never become part of a way.
//! So trees grow and ways are made shorter by postures alone, and the lines of a way are proven when there is one (R.
//! Bohlin, L. Kavraki, *Path planning using lazy PRM*, ICRA 2000). What was proven is remembered.

use super::space::FreeSpace;
use crate::vectors::square;
use std::collections::HashMap;

/// What a search asks of the caller's space.
pub(super) struct Checks<'a, const N: usize, S: ?Sized> {
    space: &'a S,
    /// The largest distance between postures of a line that is guessed, in radians.
    spacing: f64,
    /// Lines that were asked for, and whether they are free.
    known: HashMap<[[u64; N]; 2], bool>,
}

fn key<const N: usize>(from: &[f64; N], to: &[f64; N]) -> [[u64; N]; 2] {
    [from, to].map(|joints| joints.map(f64::to_bits))
}

impl<'a, const N: usize, S: FreeSpace<N> + ?Sized> Checks<'a, N, S> {
    pub fn new(space: &'a S, spacing: f64) -> Self {
        Checks { space, spacing, known: HashMap::new() }
    }

    pub fn posture(&self, joints: &[f64; N]) -> bool {
        self.space.posture_free(joints)
    }

    /// Whether a line between two free postures seems to be free: none of the postures along it is in the way, and it is
    /// not known to be blocked. The coarsest are asked first, since what is in the way is seldom thin.
    pub fn seems_free(&self, from: &[f64; N], to: &[f64; N]) -> bool {
        if let Some(free) = self.proof_of(from, to) {
            return free;
        }
        let intervals = ((square(from, to).sqrt() / self.spacing).ceil() as usize).next_power_of_two();
        let mut stride = intervals;
        while stride > 1 {
            for at in (stride / 2..intervals).step_by(stride) {
                let share = at as f64 / intervals as f64;
                if !self.posture(&std::array::from_fn(|j| from[j] + (to[j] - from[j]) * share)) {
                    return false;
                }
            }
            stride /= 2;
        }
        true
    }

    /// Whether a line is free, by the caller's word.
    pub fn free(&mut self, from: &[f64; N], to: &[f64; N]) -> bool {
        self.proof_of(from, to).unwrap_or_else(|| {
            let free = self.space.free(from, to);
            self.known.insert(key(from, to), free);
            free
        })
    }

    /// The first line of a way that is not free.
    pub fn first_blocked(&mut self, way: &[[f64; N]]) -> Option<usize> {
        // What is known already is free of cost.
        let known = way.windows(2).position(|line| self.proof_of(&line[0], &line[1]) == Some(false));
        known.or_else(|| way.windows(2).position(|line| !self.free(&line[0], &line[1])))
    }

    fn proof_of(&self, from: &[f64; N], to: &[f64; N]) -> Option<bool> {
        self.known.get(&key(from, to)).copied()
    }
}
