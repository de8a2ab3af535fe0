//! What a nozzle may come near on several legs, found in one walk down the tree.
//!
//! Neighbouring legs come near the same triangles, most of them near none. So one walk looks at some millimetres of a path at once, and each leg at what that found.
//! Poses are asked exactly, so what comes of them is the same.

use super::Step;
use crate::gouging::deepest::Scene;
use crate::gouging::sweep::{TipPose, Way};
use crate::orientation::angle;

/// How far the poses of a swath are from its first one, in millimetres and radians. A longer swath takes fewer walks, and each finds more that is near some leg only.
const LONG_MM: f64 = 4.0;
const FAR_TURNED: f64 = 0.1;

/// Where more triangles than this are near a swath, each leg walks by itself.
const MANY: usize = 64;

/// The triangles near some legs.
#[derive(Default)]
pub(super) struct Swath {
    way: Option<Way>,
    /// None where there are many.
    near: Option<Vec<u32>>,
}

fn pose(step: &Step) -> TipPose {
    (step.waypoint.position, step.waypoint.axis)
}

impl Swath {
    /// Looks ahead along steps, unless the first leg is looked at already.
    pub fn look(&mut self, scene: &Scene, steps: &[Step], allowed: f64) {
        if steps.iter().take(2).all(|step| self.has(step, step.before)) {
            return;
        }
        let Some(first) = steps.first() else { return };
        let is_near = |step: &&Step| {
            let is_close = (step.waypoint.position - first.waypoint.position).norm() <= LONG_MM;
            is_close && angle(&step.waypoint.axis, &first.waypoint.axis) <= FAR_TURNED
        };
        let count = steps.iter().take_while(is_near).count();
        if count < 3 {
            // A leg by itself.
            self.way = None;
            return;
        }
        let poses: Vec<TipPose> = steps[..count].iter().map(pose).collect();
        let before = steps[..count].iter().map(|step| step.before).max().unwrap_or(0);
        let way = Way::around(&poses, poses[count / 2], before, allowed);
        let mut near = self.near.take().unwrap_or_default();
        self.near = scene.near(&way, MANY, &mut near).then_some(near);
        self.way = Some(way);
    }

    /// The triangles near a leg and others, if they are known.
    pub fn near(&self, ends: [&Step; 2], before: u32) -> Option<&[u32]> {
        let is_within = ends.iter().all(|step| self.has(step, before));
        self.near.as_deref().filter(|_| is_within)
    }

    fn has(&self, step: &Step, before: u32) -> bool {
        self.way.is_some_and(|way| before <= way.stand.before && way.has(&pose(step)))
    }
}
