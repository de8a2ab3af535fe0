//! Legs from one waypoint to the next: what is near them, whether they are free, and step 6 of the module above.

use super::{Step, Walker};
use crate::gouging::deepest::Stand;
use crate::gouging::sweep::Way;
use crate::orientation::{angle, part_way};

/// Where legs are looked at in step 6, the middle first.
const LOOKS: [f64; 7] = [0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875];

/// What is near a way is gathered with this much to spare, in millimetres and radians.
const REACH_TO_SPARE: f64 = 1e-9;

impl Walker<'_> {
    /// Step 6; whether there was anything to do.
    pub(super) fn divide(&mut self) -> bool {
        let old = std::mem::take(&mut self.steps);
        let mut any = false;
        for mut step in old {
            if let Some(last) = self.steps.last().filter(|last| !(last.stuck || step.stuck)).copied() {
                let ends = [&last, &step].map(|step| step.waypoint.axis);
                // What was found free stays free while neither end turns.
                if step.looked != Some(ends) {
                    self.points.clear();
                    self.gather(&last, &step, last.before);
                    let is_free = self.near.is_empty() && self.is_above_plate(&last, &step);
                    let put = !is_free && LOOKS.iter().any(|share| self.put_between(&last, &step, *share));
                    step.looked = (!put).then_some(ends);
                    any |= put;
                }
            }
            self.steps.push(step);
        }
        any
    }

    /// Puts a waypoint that is free a share of the way from one to another, if the nozzle gouges there; whether it did.
    fn put_between(&mut self, last: &Step, step: &Step, share: f64) -> bool {
        let Some(waypoint) = part_way(&last.waypoint, &step.waypoint, share) else { return false };
        let k = self.steps.len();
        let wanted = waypoint.axis;
        self.steps.push(Step::new(waypoint, last.before, None));
        let is_free = self.scene.is_free_of(&self.near, self.stand(k), &wanted);
        let tilted = if is_free { None } else { self.least_tilt(k, wanted, self.options.max_tilt) };
        match tilted {
            Some(direction) => self.steps[k].waypoint.axis = direction,
            None => drop(self.steps.pop()),
        }
        tilted.is_some()
    }

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

    fn is_above_plate(&self, last: &Step, step: &Step) -> bool {
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
