//! Options of programs for a workcell: its tool, its frames, its arm.

use super::blended::BlendOptions;
use super::stream::StreamOptions;
use crate::program::{
    FilamentOutput, KrlOptions, ProgramLimits, RapidOptions, RapidSwitching, RapidTool, RapidWorkObject, ServoRate,
    TpOptions, UrScriptOptions,
};
use crate::scene::Mount;
use crate::workcell::{ArmGeometry, Equipment, tool_frame};

/// The group output of the filament's speed.
const GROUP_SIGNAL: &str = "goFilament";

impl RapidOptions {
    /// The nozzle as tool and the part frame as work object of a workcell, on the mechanical unit `STN1` if there is a table, within
    /// the limits of its arm; the arm and the table, for the seconds that the program states; the extruder is
    /// switched on the path, earlier by its lag in the workcell. A track is the first external axis, `eax_a`. The speed of the filament leaves by
    /// the group output `goFilament` where the workcell says so.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let defaults = RapidOptions::default();
        let ((held, nozzle), (carrier, frame)) = (equipment.nozzle_frame(), equipment.part_frame());
        let in_hand = |mount| matches!(mount, Mount::Link(_));
        let name = "nozzle".to_owned();
        let tool = RapidTool { name, in_hand: in_hand(held), frame: tool_frame(&nozzle), ..defaults.tool };
        let unit = equipment.positioner().map(|_| "STN1".to_owned());
        let work_object = RapidWorkObject { name: "part".to_owned(), in_hand: in_hand(carrier), frame, unit };
        let (arm, positioner) = (*equipment.arm(), equipment.positioner().copied());
        let track = equipment.track().copied();
        let switching = RapidSwitching::OnPath { lag_s: equipment.model().controller.extruder_lag_s };
        let limits = ProgramLimits::of_arm(&arm);
        let group = equipment.model().controller.filament_group;
        let (filament_signal, filament_output) = match group {
            Some(group) => {
                (GROUP_SIGNAL.to_owned(), FilamentOutput::Group { step_mm_s: group.step_mm_s, bits: group.bits })
            }
            None => (defaults.filament_signal, defaults.filament_output),
        };
        RapidOptions {
            filament_signal,
            filament_output,
            tool,
            work_object,
            switching,
            limits,
            arm: Some(arm),
            positioner,
            track,
            ..defaults
        }
    }
}

/// The kinematic system that a controller of KUKA has for its first positioner; 1 is the robot.
const FIRST_KINEMATIC: u8 = 2;

impl KrlOptions {
    /// The nozzle as tool and the part frame as work object of a workcell, on kinematic system 2 if there is a table, with its arm and within the limits of that;
    /// signals on the path come earlier by the lag of its extruder.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let ((_, nozzle), (carrier, work)) = (equipment.nozzle_frame(), equipment.part_frame());
        KrlOptions {
            part_in_hand: matches!(carrier, Mount::Link(_)),
            tool: tool_frame(&nozzle),
            work,
            kinematic: equipment.positioner().map(|_| FIRST_KINEMATIC),
            // A pose says nothing of joints where the base travels.
            arm: equipment.track().is_none().then_some(*equipment.arm()),
            lag_s: equipment.model().controller.extruder_lag_s,
            limits: ProgramLimits::of_arm(equipment.arm()),
            ..KrlOptions::default()
        }
    }
}

impl TpOptions {
    /// The nozzle as user tool and the part frame as user frame of a workcell, within the limits of its arm; a track is its first external axis, an extended axis of group 1.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let ((_, nozzle), (carrier, work)) = (equipment.nozzle_frame(), equipment.part_frame());
        TpOptions {
            part_in_hand: matches!(carrier, Mount::Link(_)),
            tool: tool_frame(&nozzle),
            work,
            track: equipment.track().is_some(),
            limits: ProgramLimits::of_arm(equipment.arm()),
            ..TpOptions::default()
        }
    }
}

impl BlendOptions {
    /// What the controller of a workcell is programmed with: the acceleration of its joints, if the workcell limits it, at which moves by joints take the time that was
    /// planned. Signals come earlier by the lag of its extruder.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let options = UrScriptOptions::of_workcell(equipment);
        let limits = equipment.arm().limits().acceleration;
        let least = limits.into_iter().fold(f64::INFINITY, f64::min);
        let acceleration_rad_s2 = if least.is_finite() { least } else { options.acceleration_rad_s2 };
        let acceleration_mm_s2 = options.acceleration_mm_s2;
        let lag_s = equipment.model().controller.extruder_lag_s;
        BlendOptions { acceleration_mm_s2, acceleration_rad_s2, lag_s, ..BlendOptions::default() }
    }
}

impl UrScriptOptions {
    /// The nozzle as tool and the part frame as work object of a workcell, with its arm and within the limits of that; `servoj` as its
    /// controller is set.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let ((_, nozzle), (carrier, work)) = (equipment.nozzle_frame(), equipment.part_frame());
        let (defaults, controller) = (UrScriptOptions::default(), &equipment.model().controller);
        UrScriptOptions {
            part_in_hand: matches!(carrier, Mount::Link(_)),
            work,
            tool: tool_frame(&nozzle),
            arm: Some(*equipment.arm()),
            limits: ProgramLimits::of_arm(equipment.arm()),
            lookahead_s: controller.servoj_lookahead_s.unwrap_or(defaults.lookahead_s),
            gain: controller.servoj_gain.unwrap_or(defaults.gain),
            ..defaults
        }
    }
}

impl StreamOptions {
    /// The rate of the arm of a workcell, 500 Hz for e-Series, whose names end with `e`, and 125 Hz for others, which e-Series take as
    /// well; signals later by the look-ahead time of `servoj`, and earlier by the lag of the extruder.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let rate = match &equipment.model().arm.geometry {
            ArmGeometry::Named(name) if name.ends_with('e') => ServoRate::Hz500,
            _ => ServoRate::Hz125,
        };
        let lookahead_s = UrScriptOptions::of_workcell(equipment).lookahead_s;
        let lag_s = lookahead_s - equipment.model().controller.extruder_lag_s;
        StreamOptions { rate, lag_s, ..StreamOptions::default() }
    }
}
