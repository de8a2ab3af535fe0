//! Legs from one waypoint to the next: what is near them, and whether they are free.

use super::{LOOKS, Step, Walker};
use crate::gouging::deepest::Stand;
use crate::gouging::sweep::Way;
use crate::orientation::{angle, part_way};
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// What is near a way is gathered with this much to spare, in millimetres and radians.
const REACH_TO_SPARE: f64 = 1e-9;

/// Legs that share a walk down the tree. With more the walk finds much that is near to none of them.
const STRETCH: usize = 6;

impl Walker<'_> {
    /// Whether nothing near is gouged where legs are looked at.
    pub(super) fn is_free_between(&self, last: &Step, step: &Step) -> bool {
        if self.near.is_empty() && self.is_above_plate(last, step) {
            return true;
        }
        LOOKS.iter().filter_map(|&share| part_way(&last.waypoint, &step.waypoint, share)).all(|waypoint| {
            let stand = Stand { tip: waypoint.position, before: last.before, allowed: self.options.allowed_depth };
            self.scene.is_free_of(&self.near, stand, &waypoint.axis)
        })
    }

    pub(super) fn is_above_plate(&self, last: &Step, step: &Step) -> bool {
        let end = |step: &Step| {
            let stand = Stand { tip: step.waypoint.position, before: step.before, allowed: self.options.allowed_depth };
            (stand, step.waypoint.axis)
        };
        self.scene.above_plate_along([last, step].map(end))
    }

    /// What the nozzle may gouge from one waypoint to another, both included, with what has a key below `before`.
    pub(super) fn gather(&mut self, last: &Step, step: &Step, before: u32) {
        self.near.clear();
        if let Some(way) = self.way(last, step, before) {
            self.scene.near(&way, &mut self.near);
        }
    }

    /// The same of a leg of the stretch that was gathered last, with what is there at its end.
    pub(super) fn gather_of_stretch(&mut self, last: &Step, step: &Step) {
        self.near.clear();
        if let Some(way) = self.way(last, step, step.before) {
            self.scene.near_of(&self.around, &way, &mut self.near);
        }
    }

    /// Gathers what the nozzle may gouge on a stretch of the path that begins with the leg to waypoint `k`, with what is there at its end; the
    /// waypoints that its legs lead to.
    pub(super) fn gather_around(&mut self, k: usize) -> Range<usize> {
        let first = k - 1;
        let mut end = (k + STRETCH).min(self.steps.len());
        // A cap of directions is convex if it is no wider than a right angle.
        while end > k + 1 && (first..end).any(|other| self.turn((first + end) / 2, other) > FRAC_PI_2) {
            end = k + 1;
        }
        let middle = &self.steps[(first + end) / 2];
        let (tip, direction) = (middle.waypoint.position, middle.waypoint.axis);
        let (mut moves, mut turns) = ([0.0; 2], 0.0);
        for step in &self.steps[first..end] {
            let to = step.waypoint.position - tip;
            let along = to.dot(&direction).abs();
            let across = (to.norm_squared() - along * along).max(0.0).sqrt();
            moves = [f64::max(moves[0], along), f64::max(moves[1], across)];
            turns = f64::max(turns, angle(&direction, &step.waypoint.axis));
        }
        let stand = Stand { tip, before: self.steps[end - 1].before, allowed: self.options.allowed_depth };
        let moves = moves.map(|moves| moves + REACH_TO_SPARE);
        self.scene.around(&Way { stand, direction, moves, turns: turns + REACH_TO_SPARE }, &mut self.around);
        k..end
    }

    /// A leg, both ends included.
    fn way(&self, last: &Step, step: &Step, before: u32) -> Option<Way> {
        let middle = part_way(&last.waypoint, &step.waypoint, 0.5)?;
        let stand = Stand { tip: middle.position, before, allowed: self.options.allowed_depth };
        // Half of both, and a little for rounding.
        let moves = 0.5 * (step.waypoint.position - last.waypoint.position);
        let along = moves.dot(&middle.axis).abs();
        let across = (moves.norm_squared() - along * along).max(0.0).sqrt();
        let moves = [along, across].map(|moves| moves + REACH_TO_SPARE);
        let turns = 0.5 * angle(&last.waypoint.axis, &step.waypoint.axis) + REACH_TO_SPARE;
        Some(Way { stand, direction: middle.axis, moves, turns })
    }
}
