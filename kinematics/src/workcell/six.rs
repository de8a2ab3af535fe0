//! Cells of six axes.

use super::check::WorkcellError;
use super::equipment::Equipment;
use super::model::Held;
use super::{ControllerPose, Following, FreeRange, Stance, Workcell};
use crate::arm::Branch;
use crate::cell::{Cell, Waypoint};
use crate::limits::JointLimits;
use crate::scene;
use nalgebra::Isometry3;

/// An arm that holds the part under a nozzle, or the nozzle over a part. Free is the tool angle.
///
/// If the arm holds the nozzle and the nozzle lies on axis 6, the tool angle turns joint 6 and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct SixAxisCell {
    equipment: Equipment,
    cell: Cell,
}

impl SixAxisCell {
    pub(super) fn new(equipment: Equipment) -> Result<Self, WorkcellError> {
        let ((_, part), (_, nozzle)) = (equipment.part_frame(), equipment.nozzle_frame());
        let arm = *equipment.arm();
        let cell = match equipment.model().held {
            Held::Part => Cell::part_in_hand(arm, part, nozzle)?,
            Held::Nozzle => Cell::nozzle_in_hand(arm, nozzle, part)?,
        };
        Ok(SixAxisCell { equipment, cell })
    }

    /// Its kinematics.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }
}

impl Workcell<6, 1> for SixAxisCell {
    fn equipment(&self) -> &Equipment {
        &self.equipment
    }

    fn limits(&self) -> &JointLimits<6> {
        self.cell.arm().limits()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.cell.flange(waypoint, free[0]);
        for (branch, joints) in self.cell.arm().inverse(&flange).unwrap_or_default().iter() {
            each(branch.slot() as u32, *joints);
        }
    }

    fn following(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Following<6, 1>> {
        let flange = self.cell.flange(waypoint, free[0]);
        let joints = *self.cell.arm().inverse(&flange).ok()?.get(*Branch::ALL.get(branch as usize)?)?;
        Some((joints, [self.cell.tool_rates(&joints)?.first]))
    }

    fn nozzle_on_part(&self, joints: &[f64; 6]) -> Option<Isometry3<f64>> {
        Some(self.cell.nozzle_on_part(joints))
    }

    fn continuing(&self, waypoint: &Waypoint, free: &[f64; 1], turn: f64, previous: &[f64; 6]) -> Option<[f64; 6]> {
        self.cell.arm().continuing(&self.cell.flange(waypoint, free[0] + turn), previous)
    }

    fn stance(&self, joints: &[f64; 6]) -> Option<Stance> {
        Some(super::stance(&self.cell, joints, self.equipment.model().held))
    }

    fn controller_pose(&self, joints: &[f64; 6]) -> Option<ControllerPose> {
        Some(super::controller_pose(&self.cell, joints, None))
    }

    fn scene_posture(&self, joints: &[f64; 6]) -> scene::Posture {
        (*joints).into()
    }

    fn manipulability(&self, joints: &[f64; 6]) -> f64 {
        self.cell.arm().manipulability(joints)
    }
}
