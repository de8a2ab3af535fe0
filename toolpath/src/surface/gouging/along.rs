//! Freed directions along a path, smooth.
//!
//! 1. Each waypoint that gouges gets its least tilt.
//! 2. Where neighbours then differ by more than the limit, one is turned toward the other, on along the path until the
//!    difference is used up: forward, then backward. So a tilt is ramped up before the place that needs it, and down behind.
//! 3. Where that does not do, points are put between, each freed on its own, and step 2 is repeated around them.
//! 4. Around tilted waypoints directions become the means of their neighbours, round by round.
//!
//! A direction is only ever replaced by one that is free at its waypoint, whatever the step: so all that were freed stay free.

use super::deepest::{Scene, Stand};
use super::{GougingOptions, Obstacle};
use crate::surface::orientation::{ROUNDING, ToolPath, Waypoint, along, angle, between};
use nalgebra::{Unit, UnitVector3, Vector3};

/// Depths, in layer heights, that are tried where none frees: the least of them is taken.
const DEEPER: [f64; 6] = [0.5, 0.75, 1.0, 1.5, 2.0, 3.0];

/// How often points are put between: each time as many as an even turn needs, so more than once only where the new ones
/// have to be tilted as well. Where that does not do either, the turn is listed.
const INSERTIONS: usize = 3;

/// Rounds of step 4, and how far around a tilted waypoint it goes.
const MEANS: usize = 6;
const AROUND: usize = 8;

/// Turns of a direction by less than this in step 4, in radians, are not worth a check.
const SMALL: f64 = 0.004;

/// A path set free.
pub(super) struct FreedPath {
    pub waypoints: Vec<Waypoint>,
    pub gouging_before: usize,
    /// How far each is from its first direction.
    pub tilts: Vec<f64>,
    /// Waypoints that are not free, what they are in, and how deep.
    pub left: Vec<(usize, Obstacle, f64)>,
}

/// A waypoint on its way.
#[derive(Clone, Copy)]
struct Step {
    waypoint: Waypoint,
    wanted: UnitVector3<f64>,
    before: u32,
    /// No tilt frees it.
    stuck: bool,
}

struct Walker<'a> {
    scene: &'a Scene<'a>,
    options: &'a GougingOptions,
    steps: Vec<Step>,
    stack: Vec<(f64, u32)>,
}

/// Sets a path free; `start` is the number of its first waypoint.
pub(super) fn freed(scene: &Scene, path: &ToolPath, start: u32, options: &GougingOptions) -> FreedPath {
    let step = |(waypoint, before): (&Waypoint, u32)| Step {
        waypoint: *waypoint,
        wanted: waypoint.direction,
        before,
        stuck: false,
    };
    let steps = path.waypoints.iter().zip(start + 1..).map(step).collect();
    let mut walker = Walker { scene, options, steps, stack: Vec::new() };
    let gouging_before = (0..walker.steps.len()).filter(|&k| walker.free(k)).count();
    if gouging_before > 0 {
        for _ in 0..INSERTIONS {
            walker.ramp();
            if !walker.insert() {
                break;
            }
        }
        walker.ramp();
        walker.means();
    }
    walker.finish(gouging_before)
}

impl Walker<'_> {
    fn stand(&self, k: usize) -> Stand {
        let Step { waypoint, before, .. } = self.steps[k];
        Stand { tip: waypoint.tip, before, allowed: self.options.allowed_depth }
    }

    fn is_free(&mut self, k: usize, direction: &UnitVector3<f64>) -> bool {
        self.scene.is_free(self.stand(k), direction, &mut self.stack)
    }

    fn least_tilt(&mut self, k: usize, wanted: UnitVector3<f64>, limit: f64) -> Option<UnitVector3<f64>> {
        self.scene.least_tilt(self.stand(k), wanted, limit, &mut self.stack)
    }

    /// Step 1 for a waypoint; whether it gouged.
    fn free(&mut self, k: usize) -> bool {
        let direction = self.steps[k].waypoint.direction;
        if self.is_free(k, &direction) {
            return false;
        }
        if let Some(direction) = self.least_tilt(k, direction, self.options.max_tilt) {
            self.steps[k].waypoint.direction = direction;
            return true;
        }
        self.steps[k].stuck = true;
        let deeper = |allowed: &&f64| **allowed > self.options.allowed_depth;
        for &allowed in DEEPER.iter().filter(deeper) {
            let stand = Stand { allowed, ..self.stand(k) };
            let found = self.scene.least_tilt(stand, direction, self.options.max_tilt, &mut self.stack);
            if let Some(direction) = found {
                self.steps[k].waypoint.direction = direction;
                break;
            }
        }
        true
    }

    fn turn(&self, k: usize, other: usize) -> f64 {
        angle(&self.steps[k].waypoint.direction, &self.steps[other].waypoint.direction)
    }

    /// Step 2.
    fn ramp(&mut self) {
        for k in 1..self.steps.len() {
            self.follow(k - 1, k);
        }
        for k in (1..self.steps.len()).rev() {
            self.follow(k, k - 1);
        }
    }

    /// Turns waypoint `k` toward `leader` until they differ by no more than the limit, if that is free.
    fn follow(&mut self, leader: usize, k: usize) {
        let (limit, turn) = (self.options.max_turn, self.turn(leader, k));
        if turn <= limit + ROUNDING || self.steps[k].stuck {
            return;
        }
        let [from, to] = [leader, k].map(|k| self.steps[k].waypoint.direction);
        let Some(nearer) = along(&from, &to, limit / turn) else {
            return;
        };
        let within = |direction: &UnitVector3<f64>| angle(&from, direction) <= limit + ROUNDING;
        let free = if self.is_free(k, &nearer) { Some(nearer) } else { self.least_tilt(k, nearer, 2.0 * limit) };
        if let Some(direction) = free.filter(within) {
            self.steps[k].waypoint.direction = direction;
        }
    }

    /// Step 3; whether there was anything to do.
    fn insert(&mut self) -> bool {
        let limit = self.options.max_turn;
        if (1..self.steps.len()).all(|k| self.turn(k - 1, k) <= limit + ROUNDING) {
            return false;
        }
        let old = std::mem::take(&mut self.steps);
        for step in old {
            if let Some(last) = self.steps.last().copied() {
                for waypoint in between(&last.waypoint, &step.waypoint, limit) {
                    self.steps.push(Step { waypoint, wanted: waypoint.direction, before: last.before, stuck: false });
                    self.free(self.steps.len() - 1);
                }
            }
            self.steps.push(step);
        }
        true
    }

    /// Step 4.
    fn means(&mut self) {
        let count = self.steps.len();
        let mut around = vec![false; count];
        for k in 0..count {
            if self.steps[k].waypoint.direction != self.steps[k].wanted {
                around[k.saturating_sub(AROUND)..(k + AROUND + 1).min(count)].fill(true);
            }
        }
        let limit = self.options.max_turn;
        for _ in 0..MEANS {
            for k in (1..count.saturating_sub(1)).filter(|&k| around[k]) {
                if self.steps[k].stuck {
                    continue;
                }
                let [last, here, next] = [k - 1, k, k + 1].map(|k| self.steps[k].waypoint.direction);
                let sum = last.into_inner() + here.into_inner() * 2.0 + next.into_inner();
                let Some(mean) = Unit::try_new(sum, 0.0) else {
                    continue;
                };
                let sound = |other: &UnitVector3<f64>| angle(other, &mean) <= limit.max(angle(other, &here));
                if angle(&mean, &here) > SMALL && sound(&last) && sound(&next) && self.is_free(k, &mean) {
                    self.steps[k].waypoint.direction = mean;
                }
            }
        }
    }

    fn finish(mut self, gouging_before: usize) -> FreedPath {
        let mut left = Vec::new();
        for k in 0..self.steps.len() {
            if !self.steps[k].stuck {
                continue;
            }
            let (stand, direction) = (self.stand(k), self.steps[k].waypoint.direction);
            if let Some(worst) = self.scene.worst(stand, &direction, &mut self.stack) {
                left.push((k, Obstacle::Layer(worst.layer), worst.depth(stand.allowed)));
            } else if !self.scene.above_plate(stand, &direction) {
                let below = self.scene.nozzle.below_plate(stand.tip.z, direction.angle(&Vector3::z_axis()));
                left.push((k, Obstacle::Plate, below));
            }
        }
        let tilts = self.steps.iter().map(|step| angle(&step.wanted, &step.waypoint.direction)).collect();
        let waypoints = self.steps.into_iter().map(|step| step.waypoint).collect();
        FreedPath { waypoints, gouging_before, tilts, left }
    }
}
