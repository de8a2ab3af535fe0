//! Joints of workcells that are no angles.

use curvlay_kinematics::workcell::Equipment;

/// How many of the `joints` of a workcell are angles: the last one is not where there is a track.
pub fn turning_joints(equipment: &Equipment, joints: usize) -> usize {
    joints - usize::from(equipment.track().is_some())
}
