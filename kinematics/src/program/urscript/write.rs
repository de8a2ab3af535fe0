//! URScript, written.

use super::{DECIMALS, FULL_SCALE, MM_PER_M, Straight, UrScriptOptions};
use crate::program::check::{Checker, check_frame, check_name, check_option};
use crate::program::text::Text;
use crate::program::{Goal, Move, ProgramLimits, Step, WriteError, Zone};
use nalgebra::Isometry3;
use std::io::Write;

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;
const FORMAT: &str = "URScript";

/// Writes a program.
///
/// # Errors
/// [`WriteError`] names the step that cannot be. A table that moves along has no words in URScript; a speed of the
/// filament above the full scale is a [`WriteError::Number`].
///
/// # Cost
/// Constant memory; about half a microsecond a move.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::*;
/// let to = Move { goal: Goal::Joints([0.5; 6]), table: None, speed: Speed::default(), zone: Zone::Stop };
/// let mut script = Vec::new();
/// let steps = [Step::Move(to), Step::FilamentSpeed(3.25), Step::Extruder(true)];
/// write_urscript(steps, &UrScriptOptions::default(), &mut script)?;
/// let script = String::from_utf8_lossy(&script);
/// assert!(script.contains("movej([0.5,0.5,0.5,0.5,0.5,0.5],a=1.4,v=1,r=0)"));
/// assert!(script.contains("filament_full_scale=20.0"));
/// assert!(script.contains("set_standard_analog_out(0,3.25/filament_full_scale)"));
/// assert!(script.contains("set_standard_digital_out(0,True)"));
/// # Ok::<(), WriteError>(())
/// ```
pub fn write_urscript(
    steps: impl IntoIterator<Item = Step>,
    options: &UrScriptOptions,
    mut out: impl Write,
) -> Result<(), WriteError> {
    check_options(options)?;
    let failed = |source| WriteError::Io { file: options.name.clone(), source };
    let filament_mm_s = options.limits.filament_mm_s.min(options.filament_full_scale_mm_s);
    let limits = ProgramLimits { filament_mm_s, ..options.limits };
    let mut checker = Checker::new(&limits);
    let mut text = Text::default();
    text.word("def ").word(&options.name).word("():\n  work=");
    write_pose(&mut text, &options.work);
    text.word("\n  set_tcp(");
    write_pose(&mut text, &options.tool);
    text.word(")\n");
    let (mut streaming, mut scaled) = (false, false);
    for step in steps {
        checker.check(&step)?;
        match &step {
            Step::Move(to) => {
                if to.table.is_some() {
                    return Err(checker.unsupported("table that moves along", FORMAT));
                }
                stop_stream(&mut text, &mut streaming, options);
                write_move(&mut text, to, options);
            }
            Step::Servo { joints, seconds } => {
                streaming = true;
                text.word("  servoj(").list(joints, DECIMALS).word(",t=").fixed(*seconds, DECIMALS);
                text.word(",lookahead_time=").fixed(options.lookahead_s, DECIMALS);
                text.word(",gain=").fixed(options.gain, 3).word(")\n");
            }
            Step::Extruder(on) => {
                text.word("  set_standard_digital_out(").fixed(f64::from(options.output), 0);
                text.word(if *on { ",True)\n" } else { ",False)\n" });
            }
            Step::FilamentSpeed(mm_s) => {
                if !std::mem::replace(&mut scaled, true) {
                    write_full_scale(&mut text, options.filament_full_scale_mm_s);
                }
                text.word("  set_standard_analog_out(").fixed(f64::from(options.filament_output), 0).word(",");
                text.fixed(*mm_s, DECIMALS).word("/").word(FULL_SCALE).word(")\n");
            }
        }
        if text.0.len() > CHUNK {
            out.write_all(&text.0).map_err(failed)?;
            text.0.clear();
        }
    }
    checker.finish()?;
    stop_stream(&mut text, &mut streaming, options);
    text.word("end\n");
    out.write_all(&text.0).and_then(|()| out.flush()).map_err(failed)
}

fn check_options(options: &UrScriptOptions) -> Result<(), WriteError> {
    check_name("name of the program", &options.name, 64)?;
    check_frame("work", &options.work)?;
    check_frame("tool", &options.tool)?;
    let ranges = [
        ("acceleration_mm_s2", options.acceleration_mm_s2, [1.0, 1e6], "it must be from 1 to 1e6 mm/s^2"),
        ("acceleration_rad_s2", options.acceleration_rad_s2, [1e-3, 1e4], "it must be from 0.001 to 1e4 rad/s^2"),
        ("lookahead_s", options.lookahead_s, [0.03, 0.2], "the controller takes 0.03 to 0.2 s"),
        ("gain", options.gain, [100.0, 2000.0], "the controller takes 100 to 2000"),
        ("output", f64::from(options.output), [0.0, 7.0], "the controller has outputs 0 to 7"),
        (
            "filament_output",
            f64::from(options.filament_output),
            [0.0, 1.0],
            "the controller has analog outputs 0 and 1",
        ),
        (
            "filament_full_scale_mm_s",
            options.filament_full_scale_mm_s,
            [1e-3, 1e6],
            "it must be from 0.001 to 1e6 mm/s",
        ),
    ];
    for (what, value, [least, most], need) in ranges {
        check_option(what, value, least <= value && value <= most, need)?;
    }
    Ok(())
}

/// After a stream the arm is still on its way.
fn stop_stream(text: &mut Text, streaming: &mut bool, options: &UrScriptOptions) {
    if std::mem::take(streaming) {
        text.word("  stopj(").fixed(options.acceleration_rad_s2, DECIMALS).word(")\n");
    }
}

/// With a point, also where the number is whole.
fn write_full_scale(text: &mut Text, mm_s: f64) {
    text.word("  ").word(FULL_SCALE).word("=");
    let from = text.0.len();
    text.fixed(mm_s, DECIMALS);
    let point = if text.0[from..].contains(&b'.') { "" } else { ".0" };
    text.word(point).word("\n");
}

/// `p[x,y,z,rx,ry,rz]`
fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
    let (at, turn) = (pose.translation.vector / MM_PER_M, pose.rotation.scaled_axis());
    text.word("p").list(&[at.x, at.y, at.z, turn.x, turn.y, turn.z], DECIMALS);
}

fn write_move(text: &mut Text, to: &Move, options: &UrScriptOptions) {
    let tool = [options.acceleration_mm_s2 / MM_PER_M, to.speed.mm_s / MM_PER_M];
    let joints = [options.acceleration_rad_s2, to.speed.rad_s];
    let (word, target, [a, v]) = match &to.goal {
        Goal::Line(target) if options.straight == Straight::MoveL => ("  movel(", Some(target), tool),
        Goal::Line(target) => ("  movep(", Some(target), tool),
        Goal::Swing(target) => ("  movej(", Some(target), joints),
        Goal::Joints(goal) => {
            text.word("  movej(").list(goal, DECIMALS);
            ("", None, joints)
        }
    };
    if let Some(target) = target {
        text.word(word).word("pose_trans(work,");
        write_pose(text, &target.pose);
        text.word(")");
    }
    let radius = if let Zone::Blend(radius) = to.zone { radius / MM_PER_M } else { 0.0 };
    text.word(",a=").fixed(a, DECIMALS).word(",v=").fixed(v, DECIMALS).word(",r=").fixed(radius, DECIMALS).word(")\n");
}
