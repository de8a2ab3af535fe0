//! Motions between two nodes, divided until tip and direction keep their tolerances.

use super::bound::{direction_error, tip_error};
use super::pose::Pose;
use super::task::Task;
use crate::machine::geometry::Posture;
use crate::machine::inverse::NoPair;
use crate::machine::reach::Unreachable;
use nalgebra::UnitVector3;

/// The way between two nodes.
pub(super) struct Stretch<'a> {
    pub task: &'a Task<'a>,
    pub poses: [Pose; 2],
    pub ends: [Posture; 2],
    /// The branch that leads from one to the other; `None` through a pole.
    pub branch: Option<u8>,
    pub tolerance_mm: f64,
}

/// A motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Where it ends.
    pub share: f64,
    pub pose: Pose,
    pub posture: Posture,
    /// Bounds on its errors.
    pub tip_error: f64,
    pub direction_error: f64,
}

/// Shares of a stretch that are not divided again: millions of them are in no move.
const SHORTEST: f64 = 1e-7;

impl Stretch<'_> {
    /// Appends the motions.
    pub fn divide(&self, pieces: &mut Vec<Piece>) -> Result<(), Unreachable> {
        let mut at = (0.0, self.poses[0], self.ends[0]);
        let mut next = vec![(1.0, self.poses[1], self.ends[1])];
        while let Some(&(share, pose, posture)) = next.last() {
            let (ends, poses) = ([at.2, posture], [at.1, pose]);
            let (tip_error, direction_error) = self.errors(&ends, &poses);
            if self.is_kept(tip_error, direction_error) || share - at.0 < SHORTEST {
                pieces.push(Piece { share, pose, posture, tip_error, direction_error });
                at = (share, pose, posture);
                next.pop();
            } else {
                let middle = 0.5 * (at.0 + share);
                let pose = self.poses[0].towards(&self.poses[1], middle);
                next.push((middle, pose, self.posture(&pose, &ends)?));
            }
        }
        Ok(())
    }

    fn errors(&self, ends: &[Posture; 2], poses: &[Pose; 2]) -> (f64, f64) {
        let machine = self.task.machine;
        let tip = if machine.knows_tip() { 0.0 } else { tip_error(machine, ends, poses) };
        let direction = if self.task.is_polar() {
            poses[1].turn(&Pose { direction: machine.tip_at(&ends[1]).1, ..poses[1] })
        } else {
            direction_error(machine, ends, poses)
        };
        (tip, direction)
    }

    fn is_kept(&self, tip_error: f64, direction_error: f64) -> bool {
        // Through a pole the direction is off by what the pole allows, which no division changes.
        let is_free = self.branch.is_none() || self.task.is_polar();
        tip_error <= self.tolerance_mm && (is_free || direction_error <= self.task.options.direction_tolerance_rad)
    }

    /// The posture at a pose between two others.
    fn posture(&self, pose: &Pose, ends: &[Posture; 2]) -> Result<Posture, Unreachable> {
        let machine = self.task.machine;
        let near = [0, 1].map(|k: usize| 0.5 * (ends[0].rotary[k] + ends[1].rotary[k]));
        let posture = match self.branch {
            None => self.task.at_pole(pose, near[0], near[1]),
            Some(branch) => {
                let pairs = machine.pairs(&pose.tip, &pose.direction, near).map_err(|why| match why {
                    NoPair::Direction(beyond) => Unreachable::Direction { beyond },
                    NoPair::Place(short_mm) => Unreachable::Place { short_mm },
                })?;
                // Where both are one, there is the first only.
                let pair = pairs[usize::from(branch)].or(pairs[0]).ok_or(Unreachable::Gap)?;
                let slack = self.task.options.direction_tolerance_rad;
                let reading = |k: usize| machine.rotary[k].nearest(pair.rotary[k], near[k], slack);
                match (reading(0), reading(1)) {
                    (Some(turn), Some(tilt)) => self.task.posture(&pose.tip, [turn, tilt]),
                    _ => return Err(self.reason(pose)),
                }
            }
        };
        machine.beyond_linear(&posture.linear).map_or(Ok(posture), Err)
    }

    fn reason(&self, pose: &Pose) -> Unreachable {
        let direction = UnitVector3::new_normalize(pose.direction);
        self.task.machine.unreachable(&pose.tip.into(), &direction).unwrap_or(Unreachable::Gap)
    }
}
