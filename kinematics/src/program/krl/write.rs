//! KRL, written.

use super::data::write_data;
use super::motion::{write_axes, write_external, write_pose};
use super::options::{
    BASE, EXTRUDER, FILAMENT, KrlLines, KrlOptions, MAX_TURN_DEG_S, MIN_TURN_DEG_S, MM, SHARE, SPEED, TOOL,
    check_options, input_name, output_name,
};
use super::posture::{joints_of, krl_status_turn};
use crate::program::check::Checker;
use crate::program::step::on_path::{Place, Waiting, place};
use crate::program::text::Text;
use crate::program::{Goal, HeadInput, HeadSignal, Move, ProgramLimits, Speed, Step, Target, WriteError, Zone};
use nalgebra::Isometry3;
use std::io::Write;
use std::iter::Peekable;

/// What [`write_krl`] has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KrlWritten {
    /// Part modules.
    pub modules: u32,
    /// Moves in them.
    pub moves: u64,
    /// Moves that were to be blended, but stop: moves by joints, the last one of a module or of a spline block.
    pub stops_added: u64,
    /// Moves that are faster or slower than their step, since the controller takes no such speed: moves by joints from 1 to 100 percent of
    /// [`KrlOptions::axis_rad_s`], turning from 0.1 to 400 degrees a second.
    pub speeds_clamped: u64,
}

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;
/// Decimals of an acceleration.
const ACCELERATION: usize = 3;

/// Writes a program: `open` is called with the file name of each part module and at last with those of the main, `NAME.dat` and `NAME.src`, and gives the
/// place to write it to.
///
/// # Returns
/// How many modules and moves there are, and how many moves had to stop.
///
/// # Errors
/// [`WriteError`] names the step that cannot be, or the file that cannot be written. A stream of joints has no words in KRL.
///
/// # Cost
/// Constant memory; about half a microsecond a move, and a line of some 90 bytes.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::program::*;
/// let target = Target { pose: Isometry3::translation(600.0, 0.0, 300.5), conf: ConfData::default() };
/// let speed = Speed { mm_s: 12.5, rad_s: 1.0 };
/// let to = Move { goal: Goal::Line(target), table: None, speed, zone: Zone::Blend(1.0) };
/// let mut files = Vec::new();
/// let written = write_krl([Step::Move(to); 5], &KrlOptions::default(), |name| {
///     files.push(name.to_owned());
///     Ok(Vec::new()) // a file, outside of an example
/// })?;
/// assert_eq!((written.modules, written.moves, written.stops_added), (1, 5, 1));
/// assert_eq!(files, ["CURVLAY_001.src", "CURVLAY.dat", "CURVLAY.src"]);
/// # Ok::<(), WriteError>(())
/// ```
pub fn write_krl<W: Write>(
    steps: impl IntoIterator<Item = Step>,
    options: &KrlOptions,
    mut open: impl FnMut(&str) -> std::io::Result<W>,
) -> Result<KrlWritten, WriteError> {
    check_options(options)?;
    let filament_mm_s = options.limits.filament_mm_s.min(options.filament_full_scale_mm_s);
    let limits = ProgramLimits { filament_mm_s, ..options.limits };
    let mut checker = Checker::new(&limits);
    let mut program = Program { options, written: KrlWritten::default(), outputs: Outputs::default() };
    let mut module: Option<Module<W>> = None;
    let mut steps = steps.into_iter().peekable();
    while let Some(step) = steps.next() {
        checker.check(&step)?;
        if let Step::Servo { .. } = step {
            return Err(checker.unsupported("stream of joints", "KRL"));
        }
        let mut current = match module.take() {
            Some(current) => current,
            None => program.begin(&mut open)?,
        };
        if let Step::Move(to) = &step {
            program.written.speeds_clamped += u64::from(is_clamped(to, options));
        }
        let ends = match step {
            Step::Move(Move { goal: Goal::Line(_), .. }) => ends_of_line(&mut steps, &mut checker)?,
            _ => Vec::new(),
        };
        let is_last = steps.peek().is_none();
        let is_over = program.pass(&mut current, step, &ends, is_last);
        // Not over the begin of a stroke: there the nozzle would wait on the part.
        let is_free = matches!(steps.peek(), Some(Step::Move(_)) | None) && !program.outputs.is_working();
        if is_over || (is_free && current.is_nearly_full(options)) {
            current.end(&mut program)?;
        } else {
            current.keep_small()?;
            module = Some(current);
        }
    }
    if let Some(current) = module {
        current.end(&mut program)?;
    }
    checker.finish()?;
    program.write_main(&mut open)?;
    Ok(program.written)
}

/// The signals that go off behind a line: they come at its end. One of each output at most, since two at one place of a path have no order.
fn ends_of_line(
    steps: &mut Peekable<impl Iterator<Item = Step>>,
    checker: &mut Checker<'_>,
) -> Result<Vec<Step>, WriteError> {
    let mut ends = Waiting::default();
    while let Some(off) = steps.next_if(|next| place(next) == Some(Place::End) && !ends.has(next)) {
        checker.check(&off)?;
        ends.0.push(off);
    }
    Ok(ends.0)
}

/// The outputs of a program: which it uses, and what they are now.
#[derive(Debug, Default)]
struct Outputs {
    on: Option<bool>,
    fed: Option<bool>,
    head: [Option<bool>; HeadSignal::ALL.len()],
}

impl Outputs {
    fn note(&mut self, signal: &Step) {
        match signal {
            Step::Extruder(on) => self.on = Some(*on),
            Step::FilamentSpeed(mm_s) => self.fed = Some(*mm_s > 0.0),
            Step::Signal { signal, on } => self.head[signal.number()] = Some(*on),
            Step::Move(_) | Step::Servo { .. } | Step::Wait(_) => {}
        }
    }

    /// Whether something is laid or pressed now: there the robot must not wait for the next module.
    fn is_working(&self) -> bool {
        self.on.or(self.fed).unwrap_or(false) || self.head[HeadSignal::Press.number()] == Some(true)
    }
}

/// The program as far as modules do not matter.
struct Program<'a> {
    options: &'a KrlOptions,
    written: KrlWritten,
    outputs: Outputs,
}

impl Program<'_> {
    fn begin<W: Write>(&mut self, open: &mut impl FnMut(&str) -> std::io::Result<W>) -> Result<Module<W>, WriteError> {
        self.written.modules += 1;
        let options = self.options;
        let name = part_name(options, self.written.modules);
        let file = format!("{name}.src");
        let out = open(&file).map_err(|source| WriteError::Io { file: file.clone(), source })?;
        let mut text = Text::default();
        text.word("&ACCESS RVP\n&REL 1\nDEF ").word(&name).word("( )\n");
        text.word("$BWDSTART=FALSE\n$ADVANCE=").fixed(f64::from(options.advance), 0);
        text.word("\n$IPO_MODE=").word(if options.part_in_hand { "#TCP" } else { "#BASE" });
        text.word("\n$ORI_TYPE=#VAR\n$TOOL=").word(&options.name).word(TOOL).word("\n$BASE=");
        match options.kinematic {
            Some(number) => {
                let number = f64::from(number);
                text.word("EK(MACHINE_DEF[").fixed(number, 0).word("].ROOT,MACHINE_DEF[").fixed(number, 0);
                text.word("].MECH_TYPE,").word(&options.name).word(BASE).word(")\n");
            }
            None => _ = text.word(&options.name).word(BASE).word("\n"),
        }
        text.word("$ACC.CP=").fixed(options.acceleration_m_s2, ACCELERATION).word("\n");
        write_axes_percent(&mut text, "$ACC_AXIS", options.acceleration_percent);
        Ok(Module {
            file,
            out,
            text,
            moves: 0,
            set: Set::default(),
            waiting: Waiting::default(),
            in_spline: false,
            at_rest: true,
        })
    }

    /// Writes a step, with the signals at its end; true where the module must end behind it.
    fn pass<W: Write>(&mut self, module: &mut Module<W>, step: Step, ends: &[Step], is_last: bool) -> bool {
        let options = self.options;
        match step {
            Step::Move(mut to) => {
                module.moves += 1;
                self.written.moves += 1;
                let is_full = module.moves >= options.moves_per_module;
                let is_line = matches!(to.goal, Goal::Line(_));
                if to.zone != Zone::Stop && (is_full || is_last || !is_line) {
                    self.written.stops_added += 1;
                    to.zone = Zone::Stop;
                }
                if !is_line {
                    module.leave_line(self);
                }
                module.write_move(&to, ends, options);
                ends.iter().for_each(|end| self.outputs.note(end));
                return is_full;
            }
            Step::Extruder(_) | Step::FilamentSpeed(_) => {
                self.outputs.note(&step);
                let waits = place(&step) == Some(Place::Begin);
                if !waits || module.waiting.has(&step) {
                    module.leave_line(self);
                }
                if waits {
                    module.waiting.0.push(step);
                } else {
                    write_assignment(&mut module.text, &step, options);
                }
            }
            Step::Signal { .. } | Step::Wait(_) | Step::Servo { .. } => {
                self.outputs.note(&step);
                module.leave_line(self);
                write_assignment(&mut module.text, &step, options);
            }
        }
        false
    }

    fn write_main<W: Write>(&self, open: &mut impl FnMut(&str) -> std::io::Result<W>) -> Result<(), WriteError> {
        let (options, name) = (self.options, self.options.name.as_str());
        let mut data = Text::default();
        write_data(&mut data, options);
        let mut text = Text::default();
        text.word("&ACCESS RVP\n&REL 1\nDEF ").word(name).word("( )\n");
        if let Some(remark) = &options.remark {
            text.word("; ").word(remark).word("\n");
        }
        text.word("; ").fixed(self.written.moves as f64, 0).word(" moves\n");
        let off = format!("{name}_OFF( )\n");
        text.word(&off);
        for number in 1..=self.written.modules {
            text.word(&part_name(options, number)).word("( )\n");
        }
        text.word(&off).word("END\nDEF ").word(&off);
        if self.outputs.fed.is_some() {
            write_assignment(&mut text, &Step::FilamentSpeed(0.0), options);
        }
        if self.outputs.on.is_some() {
            write_assignment(&mut text, &Step::Extruder(false), options);
        }
        for signal in HeadSignal::ALL.into_iter().rev().filter(|signal| self.outputs.head[signal.number()].is_some()) {
            write_assignment(&mut text, &Step::Signal { signal, on: false }, options);
        }
        text.word("END\n");
        for (ending, text) in [("dat", data), ("src", text)] {
            let file = format!("{name}.{ending}");
            let failed = |source| WriteError::Io { file: file.clone(), source };
            let mut out = open(&file).map_err(failed)?;
            out.write_all(&text.0).and_then(|()| out.flush()).map_err(failed)?;
        }
        Ok(())
    }
}

fn part_name(options: &KrlOptions, number: u32) -> String {
    format!("{}_{number:03}", options.name)
}

/// What a module has set.
#[derive(Debug, Default)]
struct Set {
    speed: Option<Speed>,
    corner_mm: Option<f64>,
    percent: Option<u8>,
}

/// A part module that is being written.
struct Module<W> {
    file: String,
    out: W,
    text: Text,
    moves: u32,
    set: Set,
    /// Signals that wait for the line behind them.
    waiting: Waiting,
    in_spline: bool,
    /// Whether the last move stops.
    at_rest: bool,
}

impl<W: Write> Module<W> {
    /// What is no line comes: a block ends, and signals that wait are assignments.
    fn leave_line(&mut self, program: &mut Program<'_>) {
        if std::mem::take(&mut self.in_spline) {
            self.text.word("ENDSPLINE\n");
            program.written.stops_added += u64::from(!self.at_rest);
            self.at_rest = true;
        }
        for signal in self.waiting.0.drain(..) {
            write_assignment(&mut self.text, &signal, program.options);
        }
    }

    fn write_move(&mut self, to: &Move, ends: &[Step], options: &KrlOptions) {
        match &to.goal {
            Goal::Line(target) => self.write_line(target, to, ends, options),
            Goal::JointMove(target) => {
                self.set_percent(to.speed.rad_s, options);
                self.text.word("PTP {");
                write_pose(&mut self.text, &written_pose(options, target));
                if let Some((status, turn)) = status_turn(options, target) {
                    self.text.word(",S ").fixed(f64::from(status), 0).word(",T ").fixed(f64::from(turn), 0);
                }
                write_external(&mut self.text, to.table);
                self.text.word("}\n");
            }
            Goal::Joints(joints) => {
                self.set_percent(to.speed.rad_s, options);
                self.text.word("PTP {");
                write_axes(&mut self.text, joints);
                write_external(&mut self.text, to.table);
                self.text.word("}\n");
            }
        }
        self.at_rest = to.zone == Zone::Stop;
    }

    fn write_line(&mut self, target: &Target, to: &Move, ends: &[Step], options: &KrlOptions) {
        let is_spline = options.lines == KrlLines::Spline;
        if let Zone::Blend(radius) = to.zone
            && !self.in_spline
            && self.set.corner_mm.replace(radius).is_none_or(|corner| corner.to_bits() != radius.to_bits())
        {
            self.text.word("$APO.CDIS=").fixed(radius, MM).word("\n");
        }
        if is_spline && !std::mem::replace(&mut self.in_spline, true) {
            self.text.word("SPLINE\n");
        }
        if !is_spline && self.set.speed.replace(to.speed).is_none_or(|speed| !is_same(speed, to.speed)) {
            write_speed(&mut self.text, to.speed, "\n");
            self.text.word("\n");
        }
        for signal in std::mem::take(&mut self.waiting).0.iter().chain(ends) {
            write_trigger(&mut self.text, signal, self.at_rest, options);
        }
        self.text.word(if is_spline { "SPL {" } else { "LIN {" });
        write_pose(&mut self.text, &written_pose(options, target));
        write_external(&mut self.text, to.table);
        self.text.word("}");
        if is_spline {
            self.text.word(" WITH ");
            write_speed(&mut self.text, to.speed, ",");
        } else if to.zone != Zone::Stop {
            self.text.word(" C_DIS");
        }
        self.text.word("\n");
        if is_spline && to.zone == Zone::Stop {
            self.text.word("ENDSPLINE\n");
            self.in_spline = false;
        }
    }

    fn set_percent(&mut self, rad_s: f64, options: &KrlOptions) {
        // At most 100, and a controller takes no 0.
        let percent = (100.0 * rad_s / options.axis_rad_s).round().clamp(1.0, 100.0) as u8;
        if self.set.percent.replace(percent) != Some(percent) {
            write_axes_percent(&mut self.text, "$VEL_AXIS", percent);
        }
    }

    /// Whether it may end at rest now: its last quarter has begun.
    fn is_nearly_full(&self, options: &KrlOptions) -> bool {
        let most = options.moves_per_module;
        self.at_rest && self.waiting.0.is_empty() && self.moves > most - most / 4
    }

    fn send(&mut self) -> Result<(), WriteError> {
        let sent = self.out.write_all(&self.text.0);
        self.text.0.clear();
        sent.map_err(|source| WriteError::Io { file: self.file.clone(), source })
    }

    fn keep_small(&mut self) -> Result<(), WriteError> {
        if self.text.0.len() > CHUNK { self.send() } else { Ok(()) }
    }

    fn end(mut self, program: &mut Program<'_>) -> Result<(), WriteError> {
        self.leave_line(program);
        self.text.word("END\n");
        self.send()?;
        self.out.flush().map_err(|source| WriteError::Io { file: self.file, source })
    }
}

/// The pose of the tool in the work object, or of the part in the tool.
fn written_pose(options: &KrlOptions, target: &Target) -> Isometry3<f64> {
    if options.part_in_hand { target.pose.inverse() } else { target.pose }
}

fn status_turn(options: &KrlOptions, target: &Target) -> Option<(u8, u8)> {
    let arm = options.arm.as_ref().filter(|_| options.kinematic.is_none())?;
    let root_flange = match options.part_in_hand {
        true => options.tool * target.pose.inverse() * options.work.inverse(),
        false => options.work * target.pose * options.tool.inverse(),
    };
    Some(krl_status_turn(arm, &joints_of(arm, &root_flange, target)?))
}

/// Whether a move gets another speed than its step has.
fn is_clamped(to: &Move, options: &KrlOptions) -> bool {
    match to.goal {
        Goal::Line(_) => !(MIN_TURN_DEG_S..=MAX_TURN_DEG_S).contains(&to.speed.rad_s.to_degrees()),
        Goal::JointMove(_) | Goal::Joints(_) => !PERCENT.contains(&(100.0 * to.speed.rad_s / options.axis_rad_s)),
    }
}

/// Percentages that round to 1 to 100.
const PERCENT: std::ops::Range<f64> = 0.5..100.5;

fn is_same(a: Speed, b: Speed) -> bool {
    a.mm_s.to_bits() == b.mm_s.to_bits() && a.rad_s.to_bits() == b.rad_s.to_bits()
}

fn write_speed(text: &mut Text, speed: Speed, between: &str) {
    let turn = speed.rad_s.to_degrees().clamp(MIN_TURN_DEG_S, MAX_TURN_DEG_S);
    text.word("$VEL.CP=").fixed(speed.mm_s / 1000.0, SPEED).word(between).word("$VEL.ORI1=").fixed(turn, MM);
    text.word(between).word("$VEL.ORI2=").fixed(turn, MM);
}

fn write_axes_percent(text: &mut Text, what: &str, percent: u8) {
    for axis in 1..=6u8 {
        text.word(what).word("[").fixed(f64::from(axis), 0).word("]=").fixed(f64::from(percent), 0).word("\n");
    }
}

/// `TRIGGER WHEN DISTANCE=0 DELAY=0 DO ..`; one where a line begins at rest cannot come before the line.
fn write_trigger(text: &mut Text, signal: &Step, begins_at_rest: bool, options: &KrlOptions) {
    let is_begin = place(signal) == Some(Place::Begin);
    let place = match (options.lines, is_begin) {
        (KrlLines::Lin, true) => "DISTANCE=0",
        (KrlLines::Lin, false) => "DISTANCE=1",
        (KrlLines::Spline, true) => "PATH=0 ONSTART",
        (KrlLines::Spline, false) => "PATH=0",
    };
    let lag = if is_begin && begins_at_rest { 0.0 } else { options.lag_s };
    text.word("TRIGGER WHEN ").word(place).word(" DELAY=").fixed(-1000.0 * lag, 0).word(" DO ");
    write_assignment(text, signal, options);
}

/// `$OUT[NAME_EXTR]=TRUE` or the like.
fn write_assignment(text: &mut Text, signal: &Step, options: &KrlOptions) {
    let name = options.name.as_str();
    let truth = |on: &bool| if *on { "]=TRUE\n" } else { "]=FALSE\n" };
    match signal {
        Step::Extruder(on) => _ = text.word("$OUT[").word(name).word(EXTRUDER).word(truth(on)),
        Step::FilamentSpeed(mm_s) => {
            let share = mm_s / options.filament_full_scale_mm_s;
            text.word("$ANOUT[").word(name).word(FILAMENT).word("]=").fixed(share, SHARE).word("\n");
        }
        Step::Signal { signal, on } => _ = text.word("$OUT[").word(name).word(output_name(*signal)).word(truth(on)),
        Step::Wait(input) => write_wait(text, *input, name),
        Step::Move(_) | Step::Servo { .. } => {}
    }
}

fn write_wait(text: &mut Text, input: HeadInput, name: &str) {
    text.word("WAIT FOR $IN[").word(name).word(input_name(input)).word("]\n");
}
