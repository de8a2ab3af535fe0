//! Lines of a module: moves, signals, and the data inside of them.

use crate::program::rapid::trigger::{Triggers, write_filament_value};
use crate::program::rapid::{
    ACCELERATION, DEGREES, FilamentOutput, MM, NAMED_TURN_RAD_S, QUATERNION, RapidAcceleration, RapidOptions, SPEEDS,
    ZONES,
};
use crate::program::text::Text;
use crate::program::{ExternalAxes, Goal, HeadInput, HeadSignal, Move, Payload, Speed, Step, Target, Zone};
use nalgebra::Isometry3;

pub fn write_acceleration(text: &mut Text, acceleration: &RapidAcceleration) {
    let RapidAcceleration { percent, ramp_percent, path_m_s2, world_m_s2 } = *acceleration;
    text.word("    AccSet ").fixed(percent, ACCELERATION).word(",").fixed(ramp_percent, ACCELERATION).word(";\n");
    if let Some(limit) = path_m_s2 {
        text.word("    PathAccLim TRUE\\AccMax:=").fixed(limit, ACCELERATION);
        text.word(",TRUE\\DecelMax:=").fixed(limit, ACCELERATION).word(";\n");
    }
    if let Some(limit) = world_m_s2 {
        text.word("    WorldAccLim\\On:=").fixed(limit, ACCELERATION).word(";\n");
    }
}

pub fn write_signal(text: &mut Text, signal: HeadSignal, on: bool) {
    text.word("    SetDO ").word(signal.rapid()).word(if on { ",1;\n" } else { ",0;\n" });
}

pub fn write_wait(text: &mut Text, input: HeadInput) {
    text.word("    WaitDI ").word(input.rapid()).word(",1;\n");
}

/// A signal of the extruder or the filament between two moves.
pub fn write_switch(text: &mut Text, signal: &Step, options: &RapidOptions) {
    match signal {
        Step::Extruder(on) => {
            text.word("    SetDO ").word(&options.signal).word(if *on { ",1;\n" } else { ",0;\n" });
        }
        Step::FilamentSpeed(mm_s) => {
            let set = if options.filament_output == FilamentOutput::Analog { "    SetAO " } else { "    SetGO " };
            text.word(set).word(&options.filament_signal).word(",");
            write_filament_value(text, *mm_s, options);
            text.word(";\n");
        }
        Step::Move(_) | Step::Servo { .. } | Step::Signal { .. } | Step::Wait(_) => {}
    }
}

/// A move, with the signals on its path; only lines have any.
pub fn write_move(text: &mut Text, to: &Move, signals: &[Step], end: &str) {
    match &to.goal {
        Goal::Line(target) => {
            let word = if signals.is_empty() { "    MoveL " } else { "    TriggL " };
            write_target(text.word(word), target, to.table);
        }
        Goal::JointMove(target) => write_target(text.word("    MoveJ "), target, to.table),
        Goal::Joints(joints) => {
            text.word("    MoveAbsJ [").list(&joints.map(f64::to_degrees), DEGREES);
            write_table(text, to.table);
        }
    }
    text.word(",");
    write_speed(text, to.speed);
    Triggers::write(text, signals);
    text.word(",");
    write_zone(text, to.zone);
    text.word(end);
}

fn write_target(text: &mut Text, target: &Target, table: Option<ExternalAxes>) {
    write_pose(text, &target.pose);
    let conf = target.conf;
    let conf = [conf.cf1, conf.cf4, conf.cf6, conf.cfx].map(f64::from);
    text.word(",").list(&conf, 0);
    write_table(text, table);
}

/// `[[x,y,z],[q1,q2,q3,q4]`, without the bracket at the end. Of the two quaternions of a rotation the one whose scalar is
/// not below 0; where it is 0, the one whose first other entry is above.
pub fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
    let (at, q) = (pose.translation.vector, pose.rotation);
    let entries = [q.w, q.i, q.j, q.k];
    // Half a unit of the last digit is written as 0.
    let first = entries.iter().find(|entry| entry.abs() > 0.5e-8);
    let sign = if first.is_some_and(|entry| *entry < 0.0) { -1.0 } else { 1.0 };
    text.word("[").list(&[at.x, at.y, at.z], MM).word(",").list(&entries.map(|entry| sign * entry), QUATERNION);
}

/// The external axes and the end of the target.
fn write_table(text: &mut Text, table: Option<ExternalAxes>) {
    let axes = table.map_or([None; 6], |external| external.axes());
    for (k, axis) in axes.iter().enumerate() {
        text.word(if k == 0 { ",[" } else { "," });
        match axis {
            Some(angle) => text.fixed(angle.to_degrees(), DEGREES),
            None => text.word("9E9"),
        };
    }
    text.word("]]");
}

fn write_speed(text: &mut Text, speed: Speed) {
    // Named speeds are whole; bits are compared, for a name must mean the same.
    let named = SPEEDS.iter().find(|&&named| f64::from(named).to_bits() == speed.mm_s.to_bits());
    match named {
        Some(&named) if speed.rad_s.to_bits() == NAMED_TURN_RAD_S.to_bits() => {
            text.word("v").fixed(f64::from(named), 0);
        }
        _ => {
            text.word("[").fixed(speed.mm_s, MM).word(",").fixed(speed.rad_s.to_degrees(), DEGREES);
            text.word(",5000,1000]");
        }
    }
}

fn write_zone(text: &mut Text, zone: Zone) {
    let Zone::Blend(radius) = zone else {
        text.word("fine");
        return;
    };
    match ZONES.iter().find(|(_, [named, ..])| named.to_bits() == radius.to_bits()) {
        Some((name, _)) => _ = text.word(name),
        // In the proportions of the named ones.
        None => {
            text.word("[FALSE");
            for share in [1.0, 1.5, 1.5, 0.15, 1.5, 0.15] {
                text.word(",").fixed(share * radius, MM);
            }
            text.word("]");
        }
    }
}

/// `[mass,[centre],[1,0,0,0],0,0,0]`
pub fn write_load(text: &mut Text, load: &Payload) {
    // As many digits as the mass of `tool0` needs, and a tenth of a gram.
    text.word("[").fixed(load.mass_kg, MM).word(",").list(load.centre.coords.as_slice(), MM).word(",[1,0,0,0],0,0,0]");
}
