//! URScript, written.

use super::{DECIMALS, FRAMES, FULL_SCALE, MM_PER_M, Straight, UrExtruder, UrScriptOptions};
use crate::program::check::{Checker, MIN_NUMBER, check_frame, check_option, check_payload};
use crate::program::text::Text;
use crate::program::text::names::{Language, check_name, check_remark};
use crate::program::{Goal, HeadInput, HeadSignal, Move, ProgramLimits, Step, WriteError, Zone};
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::TAU;
use std::io::Write;

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;
const FORMAT: &str = "URScript";

/// The share of the way to a neighbour that a blend may take: two of them do not meet, not even when rounded.
const BLEND_SHARE: f64 = 0.49;

/// What the speed of the TCP may differ by from that of the tip on a part in the hand: a part that only turns about its
/// origin has a TCP that stands still.
pub(crate) const SPEED_FACTORS: [f64; 2] = [0.01, 100.0];

/// Faster than this, in rad/s, no joint of these arms turns.
const FASTEST: f64 = TAU;

/// What [`write_urscript`] has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UrScriptWritten {
    /// Moves, those that were added included.
    pub moves: u64,
    /// Steps of streams.
    pub servos: u64,
    /// Blends with a smaller radius than the step's.
    pub blends_reduced: u64,
    /// Moves that stop though they were to be blended.
    pub stops_added: u64,
    /// `movej` to the begin of a stream that no step has.
    pub approaches_added: u64,
}

/// Writes a program.
///
/// # Returns
/// What was written, and where that is not what the steps say: see [`UrScriptOptions`].
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
/// // The steps end with the extruder on: it is switched off.
/// assert!(script.ends_with("set_standard_digital_out(0,False)\nend\n"));
/// # Ok::<(), WriteError>(())
/// ```
pub fn write_urscript(
    steps: impl IntoIterator<Item = Step>,
    options: &UrScriptOptions,
    mut out: impl Write,
) -> Result<UrScriptWritten, WriteError> {
    check_options(options)?;
    let failed = |source| WriteError::Io { file: options.name.clone(), source };
    let filament_mm_s = options.limits.filament_mm_s.min(options.extruder.max_mm_s(options));
    let mut limits = ProgramLimits { filament_mm_s, ..options.limits };
    if let Some(arm) = &options.arm {
        tighten(&mut limits, &ProgramLimits::of_arm(arm));
    }
    let mut checker = Checker::new(&limits);
    let mut program = Program::begin(options);
    for step in steps {
        checker.check(&step)?;
        match &step {
            Step::Move(to) => {
                if to.table.is_some() {
                    return Err(
                        checker.unsupported("external axis, for a table or a track; RAPID, KRL and TP have", FORMAT)
                    );
                }
                program.drive(to);
            }
            Step::Servo { joints, seconds } => program.servo(joints, *seconds),
            Step::Extruder(on) => program.switch(*on),
            Step::FilamentSpeed(mm_s) => program.feed(*mm_s),
            Step::Signal { signal, on } => program.signal(*signal, *on),
            Step::Wait(input) => program.wait(*input),
        }
        program.keep_small();
        if program.text.0.len() > CHUNK {
            out.write_all(&program.text.0).map_err(failed)?;
            program.text.0.clear();
        }
    }
    checker.finish()?;
    program.finish();
    out.write_all(&program.text.0).and_then(|()| out.flush()).map_err(failed)?;
    Ok(program.written)
}

/// Joints within both limits.
pub(super) fn tighten(limits: &mut ProgramLimits, other: &ProgramLimits) {
    let (joints, other) = (&mut limits.joints, &other.joints);
    for joint in 0..6 {
        joints.lower[joint] = joints.lower[joint].max(other.lower[joint]);
        joints.upper[joint] = joints.upper[joint].min(other.upper[joint]);
        joints.velocity[joint] = joints.velocity[joint].min(other.velocity[joint]);
    }
}

/// Where the tip and the TCP are behind a motion.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The TCP in the base.
    tcp: Vector3<f64>,
    /// The tip in the work object.
    tip: Vector3<f64>,
}

/// A blended move that waits for the one behind it.
#[derive(Debug)]
struct Pending {
    to: Move,
    radius: f64,
    from: Option<Place>,
    at: Option<Place>,
    /// Signals that follow it.
    behind: Text,
}

/// The part of the program that is written already.
struct Program<'a> {
    options: &'a UrScriptOptions,
    text: Text,
    written: UrScriptWritten,
    pending: Option<Pending>,
    place: Option<Place>,
    /// Where a move to joints, or a stream, has brought the arm.
    joints: Option<[f64; 6]>,
    streaming: bool,
    scaled: bool,
    extruding: bool,
    feeding: bool,
    /// Signals of the head: on or off once they were used.
    head: [Option<bool>; HeadSignal::ALL.len()],
    /// Inputs of the head that the program has named.
    inputs: [bool; HeadInput::ALL.len()],
}

impl<'a> Program<'a> {
    fn begin(options: &'a UrScriptOptions) -> Self {
        let mut text = Text::default();
        let (frame, tcp) = frames(options);
        text.word("def ").word(&options.name).word("():\n  ");
        if let Some(remark) = &options.remark {
            text.word("# ").word(remark).word("\n  ");
        }
        text.word(frame_name(options)).word("=");
        write_pose(&mut text, frame);
        text.word("\n  set_tcp(");
        write_pose(&mut text, tcp);
        text.word(")\n");
        if let Some(payload) = &options.payload {
            let centre = payload.centre.coords / MM_PER_M;
            text.word("  set_payload(").fixed(payload.mass_kg, DECIMALS).word(",");
            text.list(centre.as_slice(), DECIMALS).word(")\n");
        }
        options.extruder.write_head(&mut text);
        Program {
            options,
            text,
            written: UrScriptWritten::default(),
            pending: None,
            place: None,
            joints: None,
            streaming: false,
            scaled: false,
            extruding: false,
            feeding: false,
            head: [None; HeadSignal::ALL.len()],
            inputs: [false; HeadInput::ALL.len()],
        }
    }

    /// Where signals go: behind the last move.
    fn signals(&mut self) -> &mut Text {
        match &mut self.pending {
            Some(pending) => &mut pending.behind,
            None => &mut self.text,
        }
    }

    fn drive(&mut self, to: &Move) {
        self.stop_stream();
        let at = self.place_of(&to.goal);
        self.settle(at);
        let from = std::mem::replace(&mut self.place, at);
        self.joints = if let Goal::Joints(joints) = to.goal { Some(joints) } else { None };
        match to.zone {
            Zone::Stop => self.write_move(to, 0.0, from, at),
            Zone::Blend(radius) => {
                self.pending = Some(Pending { to: *to, radius, from, at, behind: Text::default() });
            }
        }
    }

    fn servo(&mut self, joints: &[f64; 6], seconds: f64) {
        self.settle(None);
        if !self.streaming {
            let most = |joint: usize| self.options.limits.joints.velocity[joint].min(FASTEST) * seconds * (1.0 + 1e-9);
            let is_there = |at: [f64; 6]| (0..6).all(|joint| (at[joint] - joints[joint]).abs() <= most(joint));
            if !self.joints.is_some_and(is_there) {
                self.written.approaches_added += 1;
                let speed = crate::program::Speed { rad_s: self.options.approach_rad_s, ..Default::default() };
                let to = Move { goal: Goal::Joints(*joints), table: None, speed, zone: Zone::Stop };
                self.write_move(&to, 0.0, None, None);
            }
        }
        self.streaming = true;
        self.joints = Some(*joints);
        self.place = self.place_of(&Goal::Joints(*joints));
        self.written.servos += 1;
        let options = self.options;
        self.text.word("  servoj(").list(joints, DECIMALS).word(",t=").fixed(seconds, DECIMALS);
        self.text.word(",lookahead_time=").fixed(options.lookahead_s, DECIMALS);
        self.text.word(",gain=").fixed(options.gain, 3).word(")\n");
    }

    fn switch(&mut self, on: bool) {
        self.extruding = on;
        let options = self.options;
        options.extruder.write_switch(self.signals(), on, options);
    }

    fn signal(&mut self, signal: HeadSignal, on: bool) {
        let is_first = self.head[signal.number()].replace(on).is_none();
        let output = f64::from(self.options.head_outputs[signal.number()]);
        let text = self.signals();
        if is_first {
            text.word("  ").word(signal.urscript()).word("=").fixed(output, 0).word("\n");
        }
        text.word("  set_standard_digital_out(").word(signal.urscript());
        text.word(if on { ",True)\n" } else { ",False)\n" });
    }

    /// A loop that passes when the input is on; the arm stands.
    fn wait(&mut self, input: HeadInput) {
        self.settle(None);
        self.stop_stream();
        let is_named = std::mem::replace(&mut self.inputs[input.number()], true);
        if !is_named {
            let number = f64::from(self.options.head_inputs[input.number()]);
            self.text.word("  ").word(input.urscript()).word("=").fixed(number, 0).word("\n");
        }
        self.text.word("  while (not get_standard_digital_in(").word(input.urscript()).word(")):\n    sync()\n  end\n");
    }

    fn feed(&mut self, mm_s: f64) {
        self.feeding = mm_s > 0.0;
        let is_first = !std::mem::replace(&mut self.scaled, true);
        let options = self.options;
        let text = self.signals();
        if is_first && options.extruder == UrExtruder::Outputs {
            write_full_scale(text, options.filament_full_scale_mm_s);
        }
        options.extruder.write_speed(text, mm_s, options);
    }

    /// Writes the move that waits; `next` is where the next one goes.
    fn settle(&mut self, next: Option<Place>) {
        let Some(Pending { to, radius, from, at, behind }) = self.pending.take() else { return };
        let way = |ends: (Option<Place>, Option<Place>)| match ends {
            (Some(a), Some(b)) => (a.tcp - b.tcp).norm(),
            _ => 0.0,
        };
        let room = BLEND_SHARE * way((from, at)).min(way((at, next)));
        let reduced = if room >= radius {
            radius
        } else if room >= MIN_NUMBER {
            self.written.blends_reduced += 1;
            room
        } else {
            self.written.stops_added += 1;
            0.0
        };
        self.write_move(&to, reduced, from, at);
        self.text.0.extend_from_slice(&behind.0);
    }

    /// Signals without end behind a blended move do not fill the memory.
    fn keep_small(&mut self) {
        if self.pending.as_ref().is_some_and(|pending| pending.behind.0.len() > CHUNK) {
            self.settle(None);
        }
    }

    /// After a stream the arm is still on its way.
    fn stop_stream(&mut self) {
        if std::mem::take(&mut self.streaming) {
            self.text.word("  stopj(").fixed(self.options.acceleration_rad_s2, DECIMALS).word(")\n");
            // Where it stops is not known to the last digit.
            (self.joints, self.place) = (None, None);
        }
    }

    fn finish(&mut self) {
        self.settle(None);
        if self.feeding {
            self.feed(0.0);
        }
        if self.extruding {
            self.switch(false);
        }
        for signal in HeadSignal::ALL.into_iter().rev() {
            if self.head[signal.number()] == Some(true) {
                self.signal(signal, false);
            }
        }
        self.stop_stream();
        self.options.extruder.write_end(&mut self.text);
        self.text.word("end\n");
        if self.options.starts {
            self.text.word(&self.options.name).word("()\n");
        }
    }

    fn place_of(&self, goal: &Goal) -> Option<Place> {
        let options = self.options;
        let (base_tcp, work_tool) = match goal {
            Goal::Line(target) | Goal::JointMove(target) => {
                (frames(options).0 * written_pose(options, &target.pose), target.pose)
            }
            Goal::Joints(joints) => {
                let base_tcp = options.arm?.forward(joints) * frames(options).1;
                let tcp_in_frame = frames(options).0.inverse() * base_tcp;
                (base_tcp, written_pose(options, &tcp_in_frame))
            }
        };
        Some(Place { tcp: base_tcp.translation.vector, tip: work_tool.translation.vector })
    }

    fn write_move(&mut self, to: &Move, radius: f64, from: Option<Place>, at: Option<Place>) {
        self.written.moves += 1;
        let (options, text) = (self.options, &mut self.text);
        let factor = match (from, at) {
            (Some(from), Some(at)) if options.part_in_hand => {
                let factor = (at.tcp - from.tcp).norm() / (at.tip - from.tip).norm();
                if factor.is_nan() { 1.0 } else { factor.clamp(SPEED_FACTORS[0], SPEED_FACTORS[1]) }
            }
            _ => 1.0,
        };
        let mm_s = (to.speed.mm_s * factor).clamp(MIN_NUMBER, options.limits.speed_mm_s.max(MIN_NUMBER));
        let tool = [options.acceleration_mm_s2 / MM_PER_M, mm_s / MM_PER_M];
        let joints = [options.acceleration_rad_s2, to.speed.rad_s];
        let (word, target, [a, v]) = match &to.goal {
            Goal::Line(target) if options.straight == Straight::MoveL => ("  movel(", Some(target), tool),
            Goal::Line(target) => ("  movep(", Some(target), tool),
            Goal::JointMove(target) => ("  movej(", Some(target), joints),
            Goal::Joints(goal) => {
                text.word("  movej(").list(goal, DECIMALS);
                ("", None, joints)
            }
        };
        if let Some(target) = target {
            text.word(word).word("pose_trans(").word(frame_name(options)).word(",");
            write_pose(text, &written_pose(options, &target.pose));
            text.word(")");
        }
        text.word(",a=").fixed(a, DECIMALS).word(",v=").fixed(v, DECIMALS);
        text.word(",r=").fixed(radius / MM_PER_M, DECIMALS).word(")\n");
    }
}

/// The frame that targets go through, and the TCP on the flange.
fn frames(options: &UrScriptOptions) -> (&Isometry3<f64>, &Isometry3<f64>) {
    if options.part_in_hand { (&options.tool, &options.work) } else { (&options.work, &options.tool) }
}

fn frame_name(options: &UrScriptOptions) -> &'static str {
    FRAMES[usize::from(options.part_in_hand)]
}

/// The pose of the TCP in the frame for that of the tool in the work object, and the other way round.
fn written_pose(options: &UrScriptOptions, pose: &Isometry3<f64>) -> Isometry3<f64> {
    if options.part_in_hand { pose.inverse() } else { *pose }
}

pub(super) fn check_options(options: &UrScriptOptions) -> Result<(), WriteError> {
    check_name(Language::UrScript, "name", &options.name, 64)?;
    check_remark("remark", options.remark.as_deref())?;
    options.extruder.check()?;
    check_frame("work", &options.work)?;
    check_frame("tool", &options.tool)?;
    if let Some(payload) = &options.payload {
        check_payload(["payload.mass_kg", "payload.centre"], payload)?;
    }
    let ranges = [
        ("acceleration_mm_s2", options.acceleration_mm_s2, [1.0, 1e6], "it must be from 1 to 1e6 mm/s^2"),
        ("acceleration_rad_s2", options.acceleration_rad_s2, [1e-3, 1e4], "it must be from 0.001 to 1e4 rad/s^2"),
        ("approach_rad_s", options.approach_rad_s, [1e-3, FASTEST], "it must be from 0.001 to 2 pi rad/s"),
        ("lookahead_s", options.lookahead_s, [0.03, 0.2], "the controller takes 0.03 to 0.2 s"),
        ("gain", options.gain, [100.0, 2000.0], "the controller takes 100 to 2000"),
        ("output", f64::from(options.output), [0.0, 7.0], "the controller has outputs 0 to 7"),
        (
            "head_outputs",
            options.head_outputs.into_iter().max().map_or(0.0, f64::from),
            [0.0, 7.0],
            "the controller has outputs 0 to 7",
        ),
        (
            "head_inputs",
            options.head_inputs.into_iter().max().map_or(0.0, f64::from),
            [0.0, 7.0],
            "the controller has inputs 0 to 7",
        ),
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
    for (k, output) in options.head_outputs.iter().enumerate() {
        if options.head_outputs[..k].contains(output) || *output == options.output {
            let need = "two signals have the same output; give each its own";
            return Err(WriteError::Conflict { what: "head_outputs", need });
        }
    }
    for (k, input) in options.head_inputs.iter().enumerate() {
        if options.head_inputs[..k].contains(input) {
            return Err(WriteError::Conflict {
                what: "head_inputs",
                need: "two inputs are the same; give each its own",
            });
        }
    }
    for (what, value, [least, most], need) in ranges {
        check_option(what, value, least <= value && value <= most, need)?;
    }
    Ok(())
}

/// With a point, also where the number is whole.
pub(super) fn write_full_scale(text: &mut Text, mm_s: f64) {
    text.word("  ").word(FULL_SCALE).word("=");
    let from = text.0.len();
    text.fixed(mm_s, DECIMALS);
    let point = if text.0[from..].contains(&b'.') { "" } else { ".0" };
    text.word(point).word("\n");
}

/// `p[x,y,z,rx,ry,rz]`
pub(super) fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
    let (at, turn) = (pose.translation.vector / MM_PER_M, pose.rotation.scaled_axis());
    text.word("p").list(&[at.x, at.y, at.z, turn.x, turn.y, turn.z], DECIMALS);
}
