//! Workcells of seven axes.

use super::check::WorkcellError;
use super::equipment::Equipment;
use super::model::Held;
use super::tool::Tool;
use super::{ControllerPose, Following, FreeRange, Workcell, WorkcellFrames};
use crate::arm::Branch;
use crate::limits::JointLimits;
use crate::scene;
use crate::setup::{Setup, Waypoint};
use crate::track::Track;
use nalgebra::{Isometry3, Translation3};

/// An arm with the nozzle in its hand on a track, over a part that stands still. Free is where the track is: its joint is the last of seven, in the units of
/// [`Track`], and so is the free parameter.
///
/// A tool angle is a second parameter that a round nozzle leaves free. It is fixed here: with the nozzle on axis 6 it turns joint 6 and nothing else, and that joint stays in the
/// middle between its stops (at zero where it turns without end). Otherwise it is the `tool_angle` of the track, as [`Waypoint::frame`] has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SevenAxisWorkcell {
    equipment: Equipment,
    /// With the base in the origin.
    setup: Setup,
    track: Track,
    limits: JointLimits<7>,
    tool: Tool,
}

impl SevenAxisWorkcell {
    pub(super) fn new(equipment: Equipment, track: Track, tool_angle: f64) -> Result<Self, WorkcellError> {
        let ((_, part), (_, nozzle)) = (equipment.part_frame(), equipment.nozzle_frame());
        let arm = *equipment.arm();
        let setup = Setup::nozzle_in_hand(arm, nozzle, part)?;
        let (six, one) = (arm.limits(), track.limits());
        let limits = JointLimits {
            lower: seven(&six.lower, one.lower[0]),
            upper: seven(&six.upper, one.upper[0]),
            velocity: seven(&six.velocity, one.velocity[0]),
            acceleration: seven(&six.acceleration, one.acceleration[0]),
            jerk: seven(&six.jerk, one.jerk[0]),
        };
        Ok(SevenAxisWorkcell { equipment, setup, track, limits, tool: Tool::of(&arm, &nozzle, tool_angle) })
    }

    /// Its kinematics with the base of the arm in the origin.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The track.
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// The setup as it is seen from the base of the arm; `None` with the track beyond its limits.
    fn at(&self, place: f64) -> Option<Setup> {
        let is_within = self.track.limits().contains(&[place]);
        is_within.then(|| self.setup.with_base_at(&self.track.shift(place)))
    }

    /// Where the flange must be for a waypoint, in the base; joint 6 then comes to rest, if the nozzle is on its axis.
    fn flange(&self, setup: &Setup, waypoint: &Waypoint, turn: f64) -> Isometry3<f64> {
        match self.tool {
            Tool::OnAxis { .. } => setup.flange(waypoint, turn),
            Tool::Heading(angle) => setup.flange(waypoint, angle + turn),
        }
    }
}

/// Joints of the arm, then that of the track.
fn seven(&[a, b, c, d, e, f]: &[f64; 6], track: f64) -> [f64; 7] {
    [a, b, c, d, e, f, track]
}

/// The reverse of [`seven`].
fn six_and_one(&[a, b, c, d, e, f, track]: &[f64; 7]) -> ([f64; 6], f64) {
    ([a, b, c, d, e, f], track)
}

impl Workcell<7, 1> for SevenAxisWorkcell {
    fn equipment(&self) -> &Equipment {
        &self.equipment
    }

    fn limits(&self) -> &JointLimits<7> {
        &self.limits
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Within(self.limits.lower[6], self.limits.upper[6])]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 7])) {
        let Some(setup) = self.at(free[0]) else { return };
        for (branch, joints) in setup.arm().inverse(&self.flange(&setup, waypoint, 0.0)).unwrap_or_default().iter() {
            each(branch.slot() as u32, seven(&self.tool.resting(joints), free[0]));
        }
    }

    fn following(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Following<7, 1>> {
        let setup = self.at(free[0])?;
        let found = setup.arm().inverse(&self.flange(&setup, waypoint, 0.0)).ok()?;
        let joints = self.tool.resting(found.get(*Branch::ALL.get(branch as usize)?)?);
        // Seen from the base the waypoint goes back.
        let rates = setup.arm().rates_along(&joints, &-self.track.rate())?;
        let rates = match self.tool {
            Tool::OnAxis { .. } => {
                let [a, b, c, d, e, _] = rates;
                [a, b, c, d, e, 0.0]
            }
            Tool::Heading(_) => rates,
        };
        Some((seven(&joints, free[0]), [seven(&rates, 1.0)]))
    }

    fn nozzle_on_part(&self, joints: &[f64; 7]) -> Option<Isometry3<f64>> {
        // Also where the track passes its ends, which is another fault.
        let (arm, place) = six_and_one(joints);
        Some(self.setup.with_base_at(&self.track.shift(place)).nozzle_on_part(&arm))
    }

    fn continuing(&self, waypoint: &Waypoint, _: &[f64; 1], turn: f64, previous: &[f64; 7]) -> Option<[f64; 7]> {
        let (joints, place) = six_and_one(previous);
        let setup = self.at(place)?;
        let flange = |turn| self.flange(&setup, waypoint, turn);
        Some(seven(&self.tool.continuing(setup.arm(), flange, turn, &joints)?, place))
    }

    fn frames(&self, joints: &[f64; 7]) -> Option<WorkcellFrames> {
        let (arm, place) = six_and_one(joints);
        let frames = super::frames_of(&self.at(place)?, &arm, Held::Nozzle);
        let base = Translation3::from(self.track.shift(place));
        Some(WorkcellFrames {
            arm: frames.arm.map(|frame| base * frame),
            carrier: base * frames.carrier,
            part: base * frames.part,
            nozzle: base * frames.nozzle,
        })
    }

    fn controller_pose(&self, joints: &[f64; 7]) -> Option<ControllerPose> {
        let (arm, place) = six_and_one(joints);
        let pose = super::controller_pose(&self.at(place)?, &arm, None);
        Some(ControllerPose { track_mm: Some(self.track.mm(place)), ..pose })
    }

    fn scene_posture(&self, joints: &[f64; 7]) -> scene::Posture {
        let (joints, place) = six_and_one(joints);
        scene::Posture { joints, table: [place, 0.0] }
    }

    fn manipulability(&self, joints: &[f64; 7]) -> f64 {
        self.equipment.arm().manipulability(&six_and_one(joints).0)
    }
}
