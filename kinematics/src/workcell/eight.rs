//! Workcells of eight axes.

use super::check::{Table, WorkcellError};
use super::equipment::Equipment;
use super::model::Held;
use super::tool::Tool;
use super::{ControllerPose, Following, FreeRange, Workcell, WorkcellFrames};
use crate::angle::short_way;
use crate::arm::Branch;
use crate::limits::JointLimits;
use crate::scene;
use crate::setup::{Setup, TableSetup, Waypoint, nozzle_frame};
use nalgebra::{Isometry3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::PI;

/// An arm with the nozzle in its hand over a table that carries the part. Free are the tilt and the turn of the table; the
/// table's joints are the last two of eight.
///
/// A tool angle is a third parameter that a round nozzle leaves free. It is fixed here:
/// * With the nozzle on axis 6 it turns joint 6 and nothing else. That joint stays in the middle between its stops (at zero
///   where it turns without end).
/// * Otherwise the nozzle keeps its heading in the base: its frame is the shortest turn that takes z of the base to the
///   direction of growth, turned by the `tool_angle` of the positioner about the nozzle. So the arm does not turn with the
///   table. Only a direction of growth straight down in the base has no such frame: no posture with a derivative there.
#[derive(Clone, Debug, PartialEq)]
pub struct EightAxisWorkcell {
    equipment: Equipment,
    setup: TableSetup,
    limits: JointLimits<8>,
    free: [FreeRange; 2],
    tool: Tool,
}

/// The direction of growth points this nearly straight down, as `1 + cos` of its angle to the vertical, where the heading
/// of the nozzle has no derivative.
const DOWN: f64 = 1e-9;

impl EightAxisWorkcell {
    pub(super) fn new(equipment: Equipment, table: &Table) -> Result<Self, WorkcellError> {
        let ((_, part), (_, nozzle)) = (equipment.part_frame(), equipment.nozzle_frame());
        let arm = *equipment.arm();
        let setup = TableSetup::nozzle_in_hand(arm, nozzle, table.positioner, part)?;
        let (six, two) = (arm.limits(), table.positioner.limits());
        let limits = JointLimits {
            lower: eight(&six.lower, two.lower),
            upper: eight(&six.upper, two.upper),
            velocity: eight(&six.velocity, two.velocity),
            acceleration: eight(&six.acceleration, two.acceleration),
            jerk: eight(&six.jerk, two.jerk),
        };
        let [min, max] = table.print_tilt;
        let turns_round = two.lower[1] <= -PI && two.upper[1] >= PI;
        let turn = if turns_round { FreeRange::Turn } else { FreeRange::Within(two.lower[1], two.upper[1]) };
        let tool = Tool::of(&arm, &nozzle, table.tool_angle);
        Ok(EightAxisWorkcell { equipment, setup, limits, free: [FreeRange::Within(min, max), turn], tool })
    }

    /// Its kinematics.
    pub fn setup(&self) -> &TableSetup {
        &self.setup
    }

    /// The table and the setup with it, tilted and turned as said. The turn may have come round.
    fn turned(&self, tilt: f64, turn: f64) -> Option<([f64; 2], Setup)> {
        let turn = match self.free[1] {
            FreeRange::Turn => short_way(turn),
            FreeRange::Within(..) => turn,
        };
        let table = [tilt, turn];
        Some((table, self.setup.at(&table)?))
    }

    /// Where the flange must be for a waypoint; joint 6 then comes to rest, if the nozzle is on its axis.
    fn flange(&self, setup: &Setup, waypoint: &Waypoint, turn: f64) -> Isometry3<f64> {
        match self.tool {
            Tool::OnAxis { .. } => setup.flange(waypoint, turn),
            Tool::Heading(angle) => {
                let base_part = setup.part_frame().1;
                let tip = base_part * waypoint.position;
                let growth = UnitVector3::new_unchecked(base_part.rotation * waypoint.axis.into_inner());
                let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle + turn);
                nozzle_frame(&tip, &-growth) * heading * setup.nozzle_frame().1.inverse()
            }
        }
    }

    /// How fast the nozzle, if it moved with the table, would turn about itself against its heading: by tilt and turn.
    fn spin(&self, table: &[f64; 2], setup: &Setup, waypoint: &Waypoint) -> Option<[f64; 2]> {
        let a = setup.part_frame().1.rotation * waypoint.axis.into_inner();
        let risen = 1.0 + a.z;
        if risen < DOWN {
            return None;
        }
        // The shortest turn from z to `a` has no part of its speed along z + a.
        let between = a + Vector3::z();
        Some(self.setup.positioner().axes(table).map(|(_, axis)| axis.dot(&between) / risen))
    }
}

/// Joints of the arm, then those of the table.
fn eight(arm: &[f64; 6], table: [f64; 2]) -> [f64; 8] {
    let [a, b, c, d, e, f] = *arm;
    [a, b, c, d, e, f, table[0], table[1]]
}

/// The reverse of [`eight`].
fn six_and_two(joints: &[f64; 8]) -> ([f64; 6], [f64; 2]) {
    let [a, b, c, d, e, f, tilt, turn] = *joints;
    ([a, b, c, d, e, f], [tilt, turn])
}

impl Workcell<8, 2> for EightAxisWorkcell {
    fn equipment(&self) -> &Equipment {
        &self.equipment
    }

    fn limits(&self) -> &JointLimits<8> {
        &self.limits
    }

    fn free(&self) -> [FreeRange; 2] {
        self.free
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 8])) {
        let Some((table, setup)) = self.turned(free[0], free[1]) else { return };
        for (branch, joints) in setup.arm().inverse(&self.flange(&setup, waypoint, 0.0)).unwrap_or_default().iter() {
            each(branch.slot() as u32, eight(&self.tool.resting(joints), table));
        }
    }

    fn following(&self, waypoint: &Waypoint, free: &[f64; 2], branch: u32) -> Option<Following<8, 2>> {
        let (table, setup) = self.turned(free[0], free[1])?;
        let found = setup.arm().inverse(&self.flange(&setup, waypoint, 0.0)).ok()?;
        let joints = self.tool.resting(found.get(*Branch::ALL.get(branch as usize)?)?);
        let [tool, tilt, turn] = self.setup.rates(&table, &joints)?.map(|rates| rates.first);
        let [tilt, turn] = match self.tool {
            Tool::OnAxis { .. } => [tilt, turn].map(|[a, b, c, d, e, _]| [a, b, c, d, e, 0.0]),
            Tool::Heading(_) => {
                let [by_tilt, by_turn] = self.spin(&table, &setup, waypoint)?;
                let less = |rates: [f64; 6], spin: f64| std::array::from_fn(|j| rates[j] - spin * tool[j]);
                [less(tilt, by_tilt), less(turn, by_turn)]
            }
        };
        Some((eight(&joints, table), [eight(&tilt, [1.0, 0.0]), eight(&turn, [0.0, 1.0])]))
    }

    fn nozzle_on_part(&self, joints: &[f64; 8]) -> Option<Isometry3<f64>> {
        // Also where a turn passes its stops, which is another fault.
        let (arm, [tilt, turn]) = six_and_two(joints);
        let (_, setup) = self.turned(tilt, turn)?;
        Some(setup.nozzle_on_part(&arm))
    }

    fn continuing(&self, waypoint: &Waypoint, _: &[f64; 2], turn: f64, previous: &[f64; 8]) -> Option<[f64; 8]> {
        // The table stays as it is, whole turns included.
        let (joints, table) = six_and_two(previous);
        let setup = self.setup.at(&table)?;
        let flange = |turn| self.flange(&setup, waypoint, turn);
        Some(eight(&self.tool.continuing(setup.arm(), flange, turn, &joints)?, table))
    }

    fn frames(&self, joints: &[f64; 8]) -> Option<WorkcellFrames> {
        let (arm, table) = six_and_two(joints);
        Some(super::frames_of(&self.setup.at(&table)?, &arm, Held::Nozzle))
    }

    fn controller_pose(&self, joints: &[f64; 8]) -> Option<ControllerPose> {
        let (arm, table) = six_and_two(joints);
        Some(super::controller_pose(&self.setup.at(&table)?, &arm, Some(table)))
    }

    fn scene_posture(&self, joints: &[f64; 8]) -> scene::Posture {
        let (joints, table) = six_and_two(joints);
        scene::Posture { joints, table }
    }

    fn manipulability(&self, joints: &[f64; 8]) -> f64 {
        self.equipment.arm().manipulability(&six_and_two(joints).0)
    }
}
