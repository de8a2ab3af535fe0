//! Directions that change gradually along a path: steps 2 to 4 of the module above.

use super::{Step, Walker};
use crate::orientation::{TURN_ROUNDING, along, angle, between};
use nalgebra::{Unit, UnitVector3};

/// Rounds of step 4, and how far around a tilted waypoint it goes.
const MEANS: usize = 6;
const AROUND: usize = 8;

/// Turns of a direction by less than this in step 4, in radians, are not worth a check.
const SMALL: f64 = 0.004;

impl Walker<'_> {
    /// Step 2.
    pub(super) fn ramp(&mut self) {
        for k in 1..self.steps.len() {
            self.follow(k - 1, k);
        }
        for k in (1..self.steps.len()).rev() {
            self.follow(k, k - 1);
        }
    }

    /// Turns waypoint `k` toward `leader` until they differ by no more than the limit, if that is free.
    pub(super) fn follow(&mut self, leader: usize, k: usize) {
        let (limit, turn) = (self.limit(leader, k), self.turn(leader, k));
        if turn <= limit + TURN_ROUNDING || self.steps[k].is_fixed() {
            return;
        }
        let [from, to] = [leader, k].map(|k| self.steps[k].waypoint.axis);
        let Some(nearer) = along(&from, &to, limit / turn) else {
            return;
        };
        // What is free but turns too far is no gain: the waypoint stays as it is.
        let within = |direction: &UnitVector3<f64>| angle(&from, direction) <= limit + TURN_ROUNDING;
        self.points.clear();
        let free = if self.is_free(k, &nearer) { Some(nearer) } else { self.least_tilt(k, nearer, 2.0 * limit) };
        if let Some(direction) = free.filter(within) {
            self.turn_to(k, direction);
        }
    }

    /// Step 3; whether there was anything to do.
    pub(super) fn insert(&mut self) -> bool {
        let limit = self.options.max_turn;
        // More points do not make a turn gentler that the way is too short for.
        let helps = |last: &Step, step: &Step| {
            let way = (step.waypoint.position - last.waypoint.position).norm();
            let turn = angle(&last.waypoint.axis, &step.waypoint.axis);
            turn > limit + TURN_ROUNDING && turn <= self.options.max_turn_per_mm * way + TURN_ROUNDING
        };
        let long: Vec<bool> = self.steps.windows(2).map(|pair| helps(&pair[0], &pair[1])).collect();
        if !long.contains(&true) {
            return false;
        }
        let old = std::mem::take(&mut self.steps);
        for (k, step) in old.into_iter().enumerate() {
            if let Some(last) = self.steps.last().filter(|_| long[k - 1]).copied() {
                for waypoint in between(&last.waypoint, &step.waypoint, limit) {
                    self.steps.push(Step::new(waypoint, last.before, None));
                    self.free(self.steps.len() - 1);
                }
            }
            self.steps.push(step);
        }
        true
    }

    /// Step 4.
    pub(super) fn means(&mut self) {
        let count = self.steps.len();
        let mut around = vec![false; count];
        for k in 0..count {
            if self.steps[k].waypoint.axis != self.steps[k].wanted {
                around[k.saturating_sub(AROUND)..(k + AROUND + 1).min(count)].fill(true);
            }
        }
        for _ in 0..MEANS {
            for k in (1..count.saturating_sub(1)).filter(|&k| around[k]) {
                if self.steps[k].is_fixed() {
                    continue;
                }
                let [last, here, next] = [k - 1, k, k + 1].map(|k| self.steps[k].waypoint.axis);
                let sum = last.into_inner() + here.into_inner() * 2.0 + next.into_inner();
                let Some(mean) = Unit::try_new(sum, 0.0) else {
                    continue;
                };
                // A mean may leave a turn too sharp that was so before, but make none sharper.
                let sound =
                    |other: &UnitVector3<f64>, limit: f64| angle(other, &mean) <= limit.max(angle(other, &here));
                let are_sound = sound(&last, self.limit(k - 1, k)) && sound(&next, self.limit(k, k + 1));
                if angle(&mean, &here) > SMALL && are_sound && self.is_free(k, &mean) {
                    self.steps[k].waypoint.axis = mean;
                }
            }
        }
    }
}
