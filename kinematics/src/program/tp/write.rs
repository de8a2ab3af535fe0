//! TP programs, written.

use super::options::{
    AXIS_SPEED, COUNTS, EXTRUDER, FILAMENT, FULL_SCALE, HEAD_INPUTS, HEAD_OUTPUTS, IN_HAND, MM, TpOptions,
    check_options,
};
use super::position::{External, Position, write_position};
use crate::program::check::Checker;
use crate::program::text::Text;
use crate::program::text::angles::angles;
use crate::program::{Goal, HeadSignal, Move, ProgramLimits, Step, Target, WriteError, Zone};
use nalgebra::Isometry3;
use std::io::Write;

/// What [`write_tp`] has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TpWritten {
    /// Part programs.
    pub programs: u32,
    /// Moves in them.
    pub moves: u64,
    /// Moves that were to be blended, but stop, as a program ends there.
    pub stops_added: u64,
    /// Moves that are faster or slower than their step, since the controller takes no such speed: moves by joints from 1 to 100 percent of
    /// [`TpOptions::axis_rad_s`], lines from the least speed of [`TpOptions::speed_decimals`].
    pub speeds_clamped: u64,
}

/// Writes a program: `open` is called with the file name of each part and at last with that of the main, `NAME.ls`, and gives the place to write it to.
///
/// # Returns
/// How many programs and moves there are, and how many moves had to stop.
///
/// # Errors
/// [`WriteError`] names the step that cannot be, or the file that cannot be written. A stream of joints has no words in TP, nor have external axes with gaps
/// between them, which are those of motion group 2.
///
/// # Cost
/// Memory for one part, about 300 bytes a move; a microsecond a move.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::program::*;
/// let target = Target { pose: Isometry3::translation(600.0, 0.0, 300.5), conf: ConfData::default() };
/// let speed = Speed { mm_s: 12.5, rad_s: 1.0 };
/// let to = Move { goal: Goal::Line(target), table: None, speed, zone: Zone::Blend(1.0) };
/// let mut files = Vec::new();
/// let written = write_tp([Step::Move(to); 5], &TpOptions::default(), |name| {
///     files.push(name.to_owned());
///     Ok(Vec::new()) // a file, outside of an example
/// })?;
/// assert_eq!((written.programs, written.moves, written.stops_added), (1, 5, 1));
/// assert_eq!(files, ["CURVLAY_001.ls", "CURVLAY.ls"]);
/// # Ok::<(), WriteError>(())
/// ```
pub fn write_tp<W: Write>(
    steps: impl IntoIterator<Item = Step>,
    options: &TpOptions,
    mut open: impl FnMut(&str) -> std::io::Result<W>,
) -> Result<TpWritten, WriteError> {
    check_options(options)?;
    let filament_mm_s = options.limits.filament_mm_s.min(options.filament_full_scale_mm_s);
    let limits = ProgramLimits { filament_mm_s, ..options.limits };
    let mut checker = Checker::new(&limits);
    let mut written = TpWritten::default();
    let mut outputs = Outputs::default();
    let mut part: Option<Part> = None;
    let mut steps = steps.into_iter().peekable();
    while let Some(step) = steps.next() {
        checker.check(&step)?;
        let current = part.get_or_insert_with(|| Part::begin(options));
        let most = options.moves_per_program;
        let mut at_rest = false;
        match step {
            Step::Move(mut to) => {
                written.moves += 1;
                written.speeds_clamped += u64::from(is_clamped(&to, options));
                let is_last = current.moves + 1 >= most || steps.peek().is_none();
                if is_last && to.zone != Zone::Stop {
                    to.zone = Zone::Stop;
                    written.stops_added += 1;
                }
                at_rest = to.zone == Zone::Stop;
                current.drive(&to, options).ok_or_else(|| checker.unsupported(other_axes(options), "TP"))?;
            }
            Step::Servo { .. } => return Err(checker.unsupported("stream of joints", "TP")),
            signal => {
                outputs.note(&signal);
                current.line(&instruction(&signal, options));
            }
        }
        // Not over the begin of a stroke: there the nozzle would wait on the part.
        let is_free = at_rest && !outputs.is_working() && matches!(steps.peek(), Some(Step::Move(_)) | None);
        if current.moves >= most || (is_free && current.moves > most - most / 4) {
            written.programs += 1;
            part.take().map_or(Ok(()), |part| part.end(options, written.programs, &mut open))?;
        }
    }
    if let Some(part) = part {
        written.programs += 1;
        part.end(options, written.programs, &mut open)?;
    }
    checker.finish()?;
    write_main(options, &written, &outputs, &mut open)?;
    Ok(written)
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

    /// Whether something is laid or pressed now.
    fn is_working(&self) -> bool {
        self.on.or(self.fed).unwrap_or(false) || self.head[HeadSignal::Press.number()] == Some(true)
    }

    /// What is to be switched off.
    fn off(&self) -> Vec<Step> {
        let fed = self.fed.map(|_| Step::FilamentSpeed(0.0));
        let on = self.on.map(|_| Step::Extruder(false));
        let used = HeadSignal::ALL.into_iter().rev().filter(|signal| self.head[signal.number()].is_some());
        fed.into_iter().chain(on).chain(used.map(|signal| Step::Signal { signal, on: false })).collect()
    }
}

/// A part that is being put together: lines and positions.
#[derive(Debug, Default)]
struct Part {
    lines: Text,
    count: u32,
    positions: Text,
    moves: u32,
    /// Whether a table moves along.
    has_table: bool,
}

impl Part {
    fn begin(options: &TpOptions) -> Self {
        let mut part = Part::default();
        part.line(&format!("UFRAME_NUM={}", options.frame_number));
        part.line(&format!("UTOOL_NUM={}", options.tool_number));
        part
    }

    /// An instruction; a move stands right behind the number.
    fn line(&mut self, instruction: &str) {
        self.count += 1;
        let is_move = instruction.starts_with("J P") || instruction.starts_with("L P");
        let between = if is_move { ":" } else { ":  " };
        self.lines.word(&format!("{:4}", self.count)).word(between).word(instruction).word(" ;\n");
    }

    /// A move; `None` for external axes with gaps.
    fn drive(&mut self, to: &Move, options: &TpOptions) -> Option<()> {
        self.moves += 1;
        let external = External::of(to.table, options.track)?;
        let has_table = !external.table.is_empty();
        self.has_table |= has_table;
        let written = |target: &Target| Target { pose: written_pose(options, &target.pose), ..*target };
        let position = match &to.goal {
            Goal::Line(target) | Goal::JointMove(target) => Position::Pose(written(target)),
            Goal::Joints(joints) => Position::Joints(*joints),
        };
        let frames = [options.frame_number, options.tool_number];
        write_position(&mut self.positions, self.moves, &position, &external, frames);
        let mut text = Text::default();
        let number = f64::from(self.moves);
        match to.goal {
            Goal::Line(_) => {
                // A speed of 0 is none: the least that can be written.
                let decimals = usize::from(options.speed_decimals);
                let mm_s = to.speed.mm_s.max(min_mm_s(options));
                text.word("L P[").fixed(number, 0).word("] ").fixed(mm_s, decimals).word("mm/sec ");
            }
            Goal::JointMove(_) | Goal::Joints(_) => {
                let percent = (100.0 * to.speed.rad_s / options.axis_rad_s).round().clamp(1.0, 100.0);
                text.word("J P[").fixed(number, 0).word("] ").fixed(percent, 0).word("% ");
            }
        }
        match to.zone {
            Zone::Stop => text.word("FINE"),
            Zone::Blend(_) => text.word("CNT").fixed(f64::from(options.continuous), 0),
        };
        if matches!(to.goal, Goal::Line(_)) {
            text.word(if options.part_in_hand { " RTCP" } else { "" });
            text.word(if has_table { " COORD" } else { "" });
        }
        self.line(&String::from_utf8_lossy(&text.0));
        Some(())
    }

    fn end<W: Write>(
        self,
        options: &TpOptions,
        number: u32,
        open: &mut impl FnMut(&str) -> std::io::Result<W>,
    ) -> Result<(), WriteError> {
        let name = part_name(options, number);
        write_file(&name, &self, open)
    }
}

/// The least speed of a line that can be written, in mm/s.
fn min_mm_s(options: &TpOptions) -> f64 {
    10f64.powi(-i32::from(options.speed_decimals))
}

/// Whether a move gets another speed than its step has, but for rounding.
fn is_clamped(to: &Move, options: &TpOptions) -> bool {
    match to.goal {
        Goal::Line(_) => to.speed.mm_s < min_mm_s(options),
        Goal::JointMove(_) | Goal::Joints(_) => !PERCENT.contains(&(100.0 * to.speed.rad_s / options.axis_rad_s)),
    }
}

/// Percentages that round to 1 to 100.
const PERCENT: std::ops::Range<f64> = 0.5..100.5;

fn part_name(options: &TpOptions, number: u32) -> String {
    format!("{}_{number:03}", options.name)
}

/// What external axes have no words, for errors.
fn other_axes(options: &TpOptions) -> &'static str {
    if options.track { "external axes other than a track" } else { "external axes with gaps" }
}

/// The pose of the tool in the work object, or of the part in the tool.
fn written_pose(options: &TpOptions, pose: &Isometry3<f64>) -> Isometry3<f64> {
    if options.part_in_hand { pose.inverse() } else { *pose }
}

/// The file of a program: its attributes, then what was put together. The dates are fixed, so that a program is the same whenever it is made.
fn write_file<W: Write>(
    name: &str,
    part: &Part,
    open: &mut impl FnMut(&str) -> std::io::Result<W>,
) -> Result<(), WriteError> {
    let group = if part.has_table { "1,1,*,*,*" } else { "1,*,*,*,*" };
    let head = format!(
        "/PROG  {name}\n/ATTR\nOWNER\t\t= MNEDITOR;\nCOMMENT\t\t= \"curvlay\";\nPROG_SIZE\t= 0;\n\
         CREATE\t\t= DATE 26-01-01  TIME 00:00:00;\nMODIFIED\t= DATE 26-01-01  TIME 00:00:00;\nFILE_NAME\t= ;\nVERSION\t\t= 0;\n\
         LINE_COUNT\t= {};\nMEMORY_SIZE\t= 0;\nPROTECT\t\t= READ_WRITE;\nTCD:  STACK_SIZE\t= 0,\n      TASK_PRIORITY\t= 50,\n      \
         TIME_SLICE\t= 0,\n      BUSY_LAMP_OFF\t= 0,\n      ABORT_REQUEST\t= 0,\n      PAUSE_REQUEST\t= 0;\n\
         DEFAULT_GROUP\t= {group};\nCONTROL_CODE\t= 00000000 00000000;\n/MN\n",
        part.count
    );
    let file = format!("{name}.ls");
    let failed = |source| WriteError::Io { file: file.clone(), source };
    let mut out = open(&file).map_err(failed)?;
    out.write_all(head.as_bytes())
        .and_then(|()| out.write_all(&part.lines.0))
        .and_then(|()| out.write_all(b"/POS\n"))
        .and_then(|()| out.write_all(&part.positions.0))
        .and_then(|()| out.write_all(b"/END\n"))
        .and_then(|()| out.flush())
        .map_err(failed)
}

/// The instruction of a signal or a wait.
fn instruction(step: &Step, options: &TpOptions) -> String {
    let truth = |on: bool| if on { "ON" } else { "OFF" };
    match step {
        Step::Extruder(on) => format!("DO[{}]={}", options.output, truth(*on)),
        Step::FilamentSpeed(mm_s) => {
            let counts = mm_s / options.filament_full_scale_mm_s * f64::from(options.filament_counts);
            format!("AO[{}]={}", options.filament_output, counts.round())
        }
        Step::Signal { signal, on } => format!("DO[{}]={}", options.head_outputs[signal.number()], truth(*on)),
        Step::Wait(input) => format!("WAIT DI[{}]=ON", options.head_inputs[input.number()]),
        Step::Move(_) | Step::Servo { .. } => String::new(),
    }
}

fn write_main<W: Write>(
    options: &TpOptions,
    written: &TpWritten,
    outputs: &Outputs,
    open: &mut impl FnMut(&str) -> std::io::Result<W>,
) -> Result<(), WriteError> {
    let mut main = Part::default();
    let number = |value: f64| {
        let mut text = Text::default();
        text.fixed(value, MM);
        String::from_utf8_lossy(&text.0).into_owned()
    };
    for (name, value) in [
        (FULL_SCALE, options.filament_full_scale_mm_s),
        (COUNTS, f64::from(options.filament_counts)),
        (AXIS_SPEED, options.axis_rad_s.to_degrees()),
        (FILAMENT, f64::from(options.filament_output)),
        (EXTRUDER, f64::from(options.output)),
    ] {
        main.line(&format!("!{name} {}", number(value)));
    }
    let heads = HEAD_OUTPUTS.iter().zip(options.head_outputs).chain(HEAD_INPUTS.iter().zip(options.head_inputs));
    heads.for_each(|(name, number)| main.line(&format!("!{name} {number}")));
    if options.part_in_hand {
        main.line(&format!("!{IN_HAND} 1"));
    }
    set_frames(&mut main, options);
    outputs.off().iter().for_each(|step| main.line(&instruction(step, options)));
    (1..=written.programs).for_each(|number| main.line(&format!("CALL {}", part_name(options, number))));
    outputs.off().iter().for_each(|step| main.line(&instruction(step, options)));
    write_file(&options.name, &main, open)
}

/// Puts the frames together in a position register.
fn set_frames(main: &mut Part, options: &TpOptions) {
    let Some(register) = options.frame_register else { return };
    let [tool, frame] =
        if options.part_in_hand { [&options.work, &options.tool] } else { [&options.tool, &options.work] };
    main.line(&format!("PR[{register}]=LPOS"));
    for (name, number, pose) in [("UTOOL", options.tool_number, tool), ("UFRAME", options.frame_number, frame)] {
        let at = pose.translation.vector;
        let [r, p, w] = angles(&pose.rotation).map(f64::to_degrees);
        for (k, value) in [at.x, at.y, at.z, w, p, r].into_iter().enumerate() {
            let mut text = Text::default();
            text.fixed(value, if k < 3 { MM } else { super::options::DEGREES });
            let value = String::from_utf8_lossy(&text.0);
            // A number below 0 stands between brackets.
            let value = if value.starts_with('-') { format!("({value})") } else { value.into_owned() };
            main.line(&format!("PR[{register},{}]={value}", k + 1));
        }
        main.line(&format!("{name}[{number}]=PR[{register}]"));
    }
}
