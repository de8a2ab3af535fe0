//! Waypoints that are freed one by one: step 1 of the module above.

use super::{Step, Walker};
use crate::gouging::deepest::Stand;
use crate::orientation::Waypoint;
use nalgebra::UnitVector3;
use std::f64::consts::FRAC_PI_2;

/// Where none frees, the direction that is least deep is looked for up to this depth, to [`DEEPER_STEP`], in layer heights.
const DEEPEST: f64 = 3.0;
const DEEPER_STEP: f64 = 0.05;

/// Tips are raised by as many of these, in layer heights, as are needed.
const LIFT_STEP: f64 = 0.025;

impl Walker<'_> {
    /// Step 1, unless it leaves `most` waypoints or more: then it ends, and says no. The way to a waypoint and both its ends share one look, and a way that is
    /// free is not looked at again in step 6.
    pub(super) fn tilt(&mut self, most: usize) -> bool {
        let mut left = self.steps.iter().filter(|step| step.is_left()).count();
        for k in 0..self.steps.len() {
            if left >= most {
                return false;
            }
            if self.steps[k].gouged {
                continue;
            }
            // From a waypoint that was tilted the way turns far.
            let shares =
                k > 0 && !self.steps[k - 1].gouged && self.turn(k - 1, k) <= self.options.max_turn.min(FRAC_PI_2);
            let direction = self.steps[k].waypoint.axis;
            // What is near the way is gathered once for its end and for what lies between.
            let is_free = if shares {
                let [last, step] = [k - 1, k].map(|k| self.steps[k]);
                self.gather(&last, &step, step.before);
                let is_free = self.scene.is_free_of(&self.near, self.stand(k), &direction);
                if is_free && self.is_free_between(&last, &step) {
                    self.steps[k].looked = Some([last.waypoint.axis, direction]);
                }
                is_free
            } else {
                self.is_free(k, &direction)
            };
            if !is_free {
                self.tilt_at(k);
                left += usize::from(self.steps[k].is_left());
            }
        }
        left < most
    }

    /// Tilts a waypoint that gouges.
    pub(super) fn tilt_at(&mut self, k: usize) {
        self.points.clear();
        let direction = self.steps[k].waypoint.axis;
        let tilted = self.least_tilt_or_known(self.stand(k), direction);
        let step = &mut self.steps[k];
        (step.gouged, step.stuck) = (true, tilted.is_none());
        step.waypoint.axis = tilted.unwrap_or(direction);
    }

    /// Gives a waypoint that no tilt frees the direction that is least deep.
    pub(super) fn sink(&mut self, k: usize) {
        let direction = self.steps[k].waypoint.axis;
        let (mut closed, mut open) = (self.options.allowed_depth, DEEPEST);
        let mut allowed = open;
        // Free as deep as `open`, not free as deep as `closed`.
        while open - closed > DEEPER_STEP {
            let stand = Stand { allowed, ..self.stand(k) };
            match self.least_tilt_or_known(stand, direction) {
                Some(direction) => {
                    self.steps[k].waypoint.axis = direction;
                    open = allowed;
                }
                // Not even as deep as that: it stays as it is.
                None if allowed >= DEEPEST => break,
                None => closed = allowed,
            }
            // Most are hardly deeper than allowed.
            allowed =
                closed + (open - closed).min(2.0 * (closed - self.options.allowed_depth) + 2.0 * DEEPER_STEP) / 2.0;
        }
    }

    /// Raises the tip of a waypoint that no tilt frees, as little as frees it (to [`LIFT_STEP`]); whether the limit does.
    pub(super) fn raise(&mut self, k: usize) -> bool {
        self.points.clear();
        let stuck = self.steps[k];
        let (mut low, mut high) = (0.0, self.options.max_lift);
        let Some(mut raised) = (high > 0.0).then(|| self.raised(&stuck, high)).flatten() else { return false };
        // Free at `high`, not at `low`. A tip that is higher is not always as free, so this finds a height that frees, and at most a step
        // below one that does not.
        while high - low > LIFT_STEP {
            let lift = (low + high) / 2.0;
            match self.raised(&stuck, lift) {
                Some(waypoint) => (high, raised) = (lift, waypoint),
                None => low = lift,
            }
        }
        self.steps[k] = Step { waypoint: raised, stuck: false, ..stuck };
        true
    }

    /// A waypoint that is stuck with its tip raised by a share of the layer's height, across the layer, in its own direction or in one
    /// that is free up there.
    fn raised(&mut self, &Step { waypoint, wanted, before, .. }: &Step, share: f64) -> Option<Waypoint> {
        let lift = wanted.into_inner() * (share * waypoint.height);
        let stand = Stand { tip: waypoint.position + lift, before, allowed: self.options.allowed_depth };
        let is_free = self.scene.is_free(stand, &waypoint.axis, &mut self.stack);
        let direction = if is_free { waypoint.axis } else { self.least_tilt_or_known(stand, wanted)? };
        Some(Waypoint { position: stand.tip, axis: direction, lift, ..waypoint })
    }

    /// Frees a waypoint that was put between.
    pub(super) fn free(&mut self, k: usize) {
        let direction = self.steps[k].waypoint.axis;
        if self.is_free(k, &direction) {
            return;
        }
        self.tilt_at(k);
    }

    /// The free direction nearest to the one wanted; where all are too far from that, the one nearest to the direction known for the place.
    pub(super) fn least_tilt_or_known(&mut self, stand: Stand, wanted: UnitVector3<f64>) -> Option<UnitVector3<f64>> {
        let mut from =
            |wanted| self.scene.least_tilt(stand, wanted, self.options.max_tilt, &mut self.points, &mut self.stack);
        from(wanted).or_else(|| from(self.hints.at(stand.tip)?))
    }
}
