//! A rewind: the nozzle lifts off along its direction, the rotary axes go to other readings of the same pose while the tip stays where it is
//! above the part, and the nozzle comes back.
//!
//! On a polar machine the turn of the table moves the part under the nozzle, so the tip cannot stay: it first goes up along the axis of the table to above all
//! that has been printed, the table turns with the tip at that height, then the head tilts about the tip, which goes down again.

use super::bound::tip_error;
use super::pose::Pose;
use super::speed::{at_rest, at_speed};
use super::task::Task;
use crate::machine::geometry::Posture;
use crate::machine::reach::Unreachable;
use nalgebra::Vector3;

/// A motion with its time.
pub(super) type Timed = (Posture, f64);

/// How far the tip may stray from its place above the part, as a share of the height.
const STRAY: f64 = 0.05;

/// Places of a turn at which the linear axes are looked at.
const PLACES: u32 = 16;

/// Parts of a turn at most.
const PARTS: f64 = 1e-5;

pub(super) struct Rewind<'a> {
    pub task: &'a Task<'a>,
    pub pose: Pose,
    pub from: Posture,
    pub to: Posture,
    /// What has been printed on a polar machine is below this, along the axis of its table.
    pub clear_mm: f64,
}

impl Rewind<'_> {
    /// The motions, with the nozzle back on the part at the end of the last one.
    pub fn motions(&self) -> Result<Vec<Timed>, Unreachable> {
        let (task, machine) = (self.task, self.task.machine);
        let lift = task.options.lift_mm;
        let (_, direction) = machine.tip_at(&self.from);
        let mut above = self.pose.tip + direction * lift;
        let mut motions = vec![];
        let mut at = self.from;
        let line = |at: &mut Posture, tip: &Vector3<f64>, rotary: [f64; 2], motions: &mut Vec<Timed>| {
            let to = self.reached(task.posture(tip, rotary))?;
            let length = (machine.tip_at(&to).0 - machine.tip_at(at).0).norm();
            motions.push((to, at_rest(machine, at, &to).max(length / task.options.lift_feed_mm_s)));
            *at = to;
            Ok::<(), Unreachable>(())
        };
        line(&mut at, &above, self.from.rotary, &mut motions)?;
        if task.is_polar() {
            let up = self.up();
            above += up * (self.clear_mm + lift - up.dot(&above)).max(0.0);
            line(&mut at, &above, self.from.rotary, &mut motions)?;
            // The tip stays at this height, since the linear axis that goes up rests between equal tilts.
            let turned = self.reached(task.posture(&above, [self.to.rotary[0], self.from.rotary[1]]))?;
            motions.push((turned, at_rest(machine, &at, &turned)));
            at = turned;
        }
        self.turn(at, above, &mut motions)?;
        at = motions.last().map_or(at, |&(posture, _)| posture);
        if task.is_polar() {
            let (_, direction) = machine.tip_at(&self.to);
            line(&mut at, &(self.pose.tip + direction * lift), self.to.rotary, &mut motions)?;
        }
        let length = (self.pose.tip - above).norm().max(lift);
        motions.push((self.to, at_rest(machine, &at, &self.to).max(length / task.options.lift_feed_mm_s)));
        Ok(motions)
    }

    /// The axis of the table, away from the part.
    fn up(&self) -> Vector3<f64> {
        up(self.task)
    }

    fn reached(&self, posture: Posture) -> Result<Posture, Unreachable> {
        self.task.machine.beyond_linear(&posture.linear).map_or(Ok(posture), Err)
    }

    /// Turns the rotary axes evenly while the tip stays.
    fn turn(&self, from: Posture, tip: Vector3<f64>, motions: &mut Vec<Timed>) -> Result<(), Unreachable> {
        let (task, machine) = (self.task, self.task.machine);
        let at = |share: f64| {
            let rotary = [0, 1].map(|k: usize| from.rotary[k] + (self.to.rotary[k] - from.rotary[k]) * share);
            self.reached(task.posture(&tip, rotary))
        };
        for k in 1..PLACES {
            at(f64::from(k) / f64::from(PLACES))?;
        }
        let end = at(1.0)?;
        let whole = at_rest(machine, &Posture { linear: end.linear, ..from }, &end);
        let pose = Pose { tip, direction: self.pose.direction };
        let tolerance = task.options.travel_tolerance_mm.min(STRAY * task.options.lift_mm);
        let (mut done, mut last, mut next) = (0.0, from, vec![(1.0, end)]);
        while let Some(&(share, posture)) = next.last() {
            let error = if machine.knows_tip() { 0.0 } else { tip_error(machine, &[last, posture], &[pose; 2]) };
            if error <= tolerance || share - done < PARTS {
                let seconds = (whole * (share - done)).max(at_speed(machine, &last, &posture));
                motions.push((posture, seconds));
                (done, last) = (share, posture);
                next.pop();
            } else {
                let middle = 0.5 * (done + share);
                next.push((middle, at(middle)?));
            }
        }
        Ok(())
    }
}

/// The axis of a polar machine's table, away from the part.
pub(super) fn up(task: &Task<'_>) -> Vector3<f64> {
    let axis = task.machine.rotary[0].axis;
    if axis.dot(&task.machine.nozzle) < 0.0 { -axis } else { axis }
}
