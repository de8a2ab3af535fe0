//! Workcells of six axes.

use super::check::WorkcellError;
use super::equipment::Equipment;
use super::model::{Held, RollerModel};
use super::{ControllerPose, Following, FreeRange, Workcell, WorkcellFrames};
use crate::arm::Branch;
use crate::limits::JointLimits;
use crate::scene;
use crate::setup::{Setup, Waypoint};
use nalgebra::Isometry3;

/// An arm that holds the part under a nozzle, or the nozzle over a part. Free is the tool angle.
///
/// If the arm holds the nozzle and the nozzle lies on axis 6, the tool angle turns joint 6 and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct SixAxisWorkcell {
    equipment: Equipment,
    setup: Setup,
}

impl SixAxisWorkcell {
    pub(super) fn new(equipment: Equipment) -> Result<Self, WorkcellError> {
        let ((_, part), (_, nozzle)) = (equipment.part_frame(), equipment.nozzle_frame());
        let arm = *equipment.arm();
        let setup = match equipment.model().held {
            Held::Part => Setup::part_in_hand(arm, part, nozzle)?,
            Held::Nozzle => Setup::nozzle_in_hand(arm, nozzle, part)?,
        };
        Ok(SixAxisWorkcell { equipment, setup })
    }

    /// The same workcell with the roller of a tape head in the place of the nozzle: reach and frames are the same, the bodies of the scene and what they touch
    /// are those of the roller.
    ///
    /// # Arguments
    /// * `heading`: from the x axis of the nozzle frame to the direction of the tape, about the axis of the nozzle, in radians.
    ///
    /// # Errors
    /// [`WorkcellError`] names the field of `roller`.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::workcell::{AnyWorkcell, HOT_END, NOZZLE, RollerModel, Workcell};
    /// # #[cfg(feature = "serde")] {
    /// let file = include_str!("../../../examples/cells/ur3.json");
    /// let AnyWorkcell::Six(workcell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has a table".into()) };
    /// let roller = RollerModel { diameter_mm: 30.0, ..RollerModel::default() };
    /// let with_roller = workcell.with_roller(roller, 0.0)?;
    /// assert_eq!(with_roller.equipment().roller().map(|(roller, _)| roller.diameter_mm), Some(30.0));
    /// assert!(workcell.with_roller(RollerModel { width_mm: 0.0, ..roller }, 0.0).is_err());
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_roller(&self, roller: RollerModel, heading: f64) -> Result<Self, WorkcellError> {
        Ok(SixAxisWorkcell { equipment: self.equipment.with_roller(roller, heading)?, setup: self.setup })
    }

    /// Its kinematics.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }
}

impl Workcell<6, 1> for SixAxisWorkcell {
    fn equipment(&self) -> &Equipment {
        &self.equipment
    }

    fn limits(&self) -> &JointLimits<6> {
        self.setup.arm().limits()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.setup.flange(waypoint, free[0]);
        for (branch, joints) in self.setup.arm().inverse(&flange).unwrap_or_default().iter() {
            each(branch.slot() as u32, *joints);
        }
    }

    fn following(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Following<6, 1>> {
        let flange = self.setup.flange(waypoint, free[0]);
        let joints = *self.setup.arm().inverse(&flange).ok()?.get(*Branch::ALL.get(branch as usize)?)?;
        Some((joints, [self.setup.tool_rates(&joints)?.first]))
    }

    fn nozzle_on_part(&self, joints: &[f64; 6]) -> Option<Isometry3<f64>> {
        Some(self.setup.nozzle_on_part(joints))
    }

    fn continuing(&self, waypoint: &Waypoint, free: &[f64; 1], turn: f64, previous: &[f64; 6]) -> Option<[f64; 6]> {
        self.setup.arm().continuing(&self.setup.flange(waypoint, free[0] + turn), previous)
    }

    fn frames(&self, joints: &[f64; 6]) -> Option<WorkcellFrames> {
        Some(super::frames_of(&self.setup, joints, self.equipment.model().held))
    }

    fn controller_pose(&self, joints: &[f64; 6]) -> Option<ControllerPose> {
        Some(super::controller_pose(&self.setup, joints, None))
    }

    fn scene_posture(&self, joints: &[f64; 6]) -> scene::Posture {
        (*joints).into()
    }

    fn manipulability(&self, joints: &[f64; 6]) -> f64 {
        self.setup.arm().manipulability(joints)
    }
}
