//! Legs from one waypoint to the next: what is near them, and whether they are free.

use super::{LOOKS, Step, Walker};
use crate::gouging::deepest::Stand;
use crate::gouging::sweep::Way;
use crate::orientation::{angle, part_way};

/// What is near a way is gathered with this much to spare, in millimetres and radians.
const REACH_TO_SPARE: f64 = 1e-9;

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
