//! RAPID, written.

use super::options::check_options;
use super::trigger::{Triggers, write_filament_value};
use super::{
    ACCELERATION, DEGREES, FILAMENT_STEP, FilamentOutput, MM, NAMED_TURN_RAD_S, NO_MASS, QUATERNION, RapidAcceleration,
    RapidOptions, RapidSwitching, SECONDS, SPEEDS, TOOL0, WOBJ0, ZONES,
};
use crate::program::check::{Checker, Clock};
use crate::program::step::on_path::{Place, Waiting, place};
use crate::program::text::Text;
use crate::program::{
    ExternalAxes, Goal, HeadInput, HeadSignal, Move, Payload, ProgramLimits, Speed, Step, Target, WriteError, Zone,
};
use nalgebra::{Isometry3, Point3};
use std::io::Write;
use std::iter::Peekable;

/// What [`write_rapid`] has written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RapidWritten {
    /// Part modules.
    pub modules: u32,
    /// Moves in them.
    pub moves: u64,
    /// Moves that were to be blended, but stop because a module ends there.
    pub stops_added: u32,
    /// Seconds of the moves by their own speeds ([`program_seconds`](crate::program::program_seconds)).
    pub seconds: f64,
}

/// Decimals of the step of a group output.
const STEP: usize = 9;
/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;

/// Writes a program: `open` is called with the file name of each part module and at last with that of the main, and
/// gives the place to write it to.
///
/// # Returns
/// How many modules and moves there are, and how many moves had to stop for a module to end.
///
/// # Errors
/// [`WriteError`] names the step that cannot be, or the file that cannot be written.
///
/// # Cost
/// Constant memory; about half a microsecond a move, and a line of some 110 bytes.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::program::*;
/// let target = Target { pose: Isometry3::translation(600.0, 0.0, 300.5), conf: ConfData::default() };
/// let speed = Speed { mm_s: 12.5, rad_s: 1.0 };
/// let to = Move { goal: Goal::Line(target), table: None, speed, zone: Zone::Blend(1.0) };
/// let mut files = Vec::new();
/// let written = write_rapid([Step::Move(to); 5], &RapidOptions::default(), |name| {
///     files.push(name.to_owned());
///     Ok(Vec::new()) // a file, outside of an example
/// })?;
/// assert_eq!((written.modules, written.moves), (1, 5));
/// assert_eq!(files, ["curvlay_001.mod", "curvlay.mod"]);
/// # Ok::<(), WriteError>(())
/// ```
pub fn write_rapid<W: Write>(
    steps: impl IntoIterator<Item = Step>,
    options: &RapidOptions,
    mut open: impl FnMut(&str) -> std::io::Result<W>,
) -> Result<RapidWritten, WriteError> {
    check_options(options)?;
    let filament_mm_s = match options.filament_output {
        FilamentOutput::Analog => f64::INFINITY,
        FilamentOutput::Group { step_mm_s, bits } => step_mm_s * f64::from((1u32 << bits) - 1),
    };
    let limits = ProgramLimits { filament_mm_s: options.limits.filament_mm_s.min(filament_mm_s), ..options.limits };
    let mut checker = Checker::new(&limits);
    let mut written = RapidWritten { modules: 0, moves: 0, stops_added: 0, seconds: 0.0 };
    let mut clock = Clock::default();
    let work_tool = |joints: &[f64; 6], table| options.work_tool(joints, table);
    let mut outputs = Outputs::default();
    let end = format!(",{}\\WObj:={};\n", options.tool.name, options.work_object.name);
    let mut module: Option<Module<W>> = None;
    let on_path = options.switching != RapidSwitching::Between;
    // What waits for the line behind it.
    let mut waiting = Waiting::default();
    let mut steps = steps.into_iter().peekable();
    while let Some(mut step) = steps.next() {
        checker.check(&step)?;
        clock.pass(&step, &work_tool);
        let current = match &mut module {
            Some(current) => current,
            None => {
                written.modules += 1;
                module.insert(Module::begin(options, written.modules, &mut open)?)
            }
        };
        let mut at_rest = false;
        match &mut step {
            Step::Move(to) => {
                current.moves += 1;
                written.moves += 1;
                let is_line = on_path && matches!(to.goal, Goal::Line(_));
                if !is_line {
                    current.send_waiting(&mut waiting, options);
                }
                let mut signals = std::mem::take(&mut waiting);
                if is_line {
                    signals.0.append(&mut ends_of_line(&mut steps, &mut checker, &mut outputs)?);
                }
                let last = current.moves >= options.moves_per_module || steps.peek().is_none();
                if last && to.zone != Zone::Stop {
                    to.zone = Zone::Stop;
                    written.stops_added += 1;
                }
                at_rest = to.zone == Zone::Stop;
                current.triggers.set_up(&mut current.text, &signals.0, options);
                write_move(&mut current.text, to, &signals.0, &end);
            }
            signal @ (Step::Extruder(_) | Step::FilamentSpeed(_)) => {
                outputs.note(signal);
                let waits = on_path && place(signal) == Some(Place::Begin);
                if !waits || waiting.has(signal) {
                    current.send_waiting(&mut waiting, options);
                }
                if waits {
                    waiting.0.push(*signal);
                } else {
                    write_switch(&mut current.text, signal, options);
                }
            }
            Step::Signal { signal, on } => {
                current.send_waiting(&mut waiting, options);
                outputs.set(*signal, *on);
                write_signal(&mut current.text, *signal, *on);
            }
            Step::Wait(input) => {
                current.send_waiting(&mut waiting, options);
                write_wait(&mut current.text, *input);
            }
            Step::Servo { .. } => return Err(checker.unsupported("stream of joints", "RAPID")),
        }
        let most = options.moves_per_module;
        // Not over the begin of a stroke: there the nozzle would wait on the part.
        let signal_next = matches!(
            steps.peek(),
            Some(Step::Extruder(_) | Step::FilamentSpeed(_) | Step::Signal { .. } | Step::Wait(_))
        );
        let idle = at_rest && !outputs.is_working() && !signal_next;
        let early = current.moves > most - most / 4 && idle;
        if current.text.0.len() > CHUNK {
            current.send()?;
        }
        if current.moves >= most || early {
            module.take().map_or(Ok(()), Module::end)?;
        }
    }
    if let Some(current) = &mut module {
        current.send_waiting(&mut waiting, options);
    }
    module.take().map_or(Ok(()), Module::end)?;
    checker.finish()?;
    written.seconds = clock.seconds;
    write_main(options, &written, outputs.used, &mut open)?;
    Ok(written)
}

/// Which signals a program uses.
#[derive(Clone, Copy, Debug, Default)]
struct Used {
    switch: bool,
    filament: bool,
    head: [bool; HeadSignal::ALL.len()],
}

/// The outputs of a program along its steps: which it uses, and what they are now.
#[derive(Debug, Default)]
struct Outputs {
    used: Used,
    /// The digital output of the extruder, if there is one.
    on: Option<bool>,
    /// Whether the filament has a speed.
    fed: bool,
    head: [bool; HeadSignal::ALL.len()],
}

impl Outputs {
    /// Notes a signal of the extruder or the filament.
    fn note(&mut self, signal: &Step) {
        match signal {
            Step::Extruder(to) => (self.used.switch, self.on) = (true, Some(*to)),
            Step::FilamentSpeed(mm_s) => (self.used.filament, self.fed) = (true, *mm_s > 0.0),
            Step::Move(_) | Step::Servo { .. } | Step::Signal { .. } | Step::Wait(_) => {}
        }
    }

    /// Notes a signal of a tape head.
    fn set(&mut self, signal: HeadSignal, on: bool) {
        self.used.head[signal.number()] = true;
        self.head[signal.number()] = on;
    }

    /// Whether something is laid or pressed now: there the robot must not wait for the next module. What lays is the digital output, or the
    /// speed of the filament in a program without one.
    fn is_working(&self) -> bool {
        self.on.unwrap_or(self.fed) || self.head[HeadSignal::Press.number()]
    }
}

/// The signals that go off behind a line: they come at its end, as its triggers, so they leave the steps together with it. One of each
/// output at most, since two at one place of a path have no order.
fn ends_of_line(
    steps: &mut Peekable<impl Iterator<Item = Step>>,
    checker: &mut Checker<'_>,
    outputs: &mut Outputs,
) -> Result<Vec<Step>, WriteError> {
    let mut ends = Waiting::default();
    while let Some(off) = steps.next_if(|next| place(next) == Some(Place::End) && !ends.has(next)) {
        checker.check(&off)?;
        outputs.note(&off);
        ends.0.push(off);
    }
    Ok(ends.0)
}

fn part_name(options: &RapidOptions, number: u32) -> String {
    format!("{}_{number:03}", options.name)
}

/// A part module that is being written.
struct Module<W> {
    file: String,
    out: W,
    text: Text,
    moves: u32,
    triggers: Triggers,
}

impl<W: Write> Module<W> {
    fn begin(
        options: &RapidOptions,
        number: u32,
        open: &mut impl FnMut(&str) -> std::io::Result<W>,
    ) -> Result<Self, WriteError> {
        let name = part_name(options, number);
        let file = format!("{name}.mod");
        let out = open(&file).map_err(|source| WriteError::Io { file: file.clone(), source })?;
        let mut text = Text::default();
        text.word("MODULE ").word(&name).word("\n");
        if let FilamentOutput::Group { step_mm_s, .. } = options.filament_output {
            text.word("  LOCAL CONST num ").word(FILAMENT_STEP).word(":=").fixed(step_mm_s, STEP).word(";\n");
        }
        if options.switching != RapidSwitching::Between {
            Triggers::declare(&mut text);
        }
        text.word("  PROC ").word(&name).word("_run()\n");
        if let Some(acceleration) = &options.acceleration {
            write_acceleration(&mut text, acceleration);
        }
        Ok(Module { file, out, text, moves: 0, triggers: Triggers::default() })
    }

    /// Writes what has no line behind it.
    fn send_waiting(&mut self, waiting: &mut Waiting, options: &RapidOptions) {
        for signal in waiting.0.drain(..) {
            write_switch(&mut self.text, &signal, options);
        }
    }

    fn send(&mut self) -> Result<(), WriteError> {
        let sent = self.out.write_all(&self.text.0);
        self.text.0.clear();
        sent.map_err(|source| WriteError::Io { file: self.file.clone(), source })
    }

    fn end(mut self) -> Result<(), WriteError> {
        self.text.word("  ENDPROC\nENDMODULE\n");
        self.send()?;
        self.out.flush().map_err(|source| WriteError::Io { file: self.file, source })
    }
}

fn write_acceleration(text: &mut Text, acceleration: &RapidAcceleration) {
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

fn write_signal(text: &mut Text, signal: HeadSignal, on: bool) {
    text.word("    SetDO ").word(signal.rapid()).word(if on { ",1;\n" } else { ",0;\n" });
}

fn write_wait(text: &mut Text, input: HeadInput) {
    text.word("    WaitDI ").word(input.rapid()).word(",1;\n");
}

/// A signal of the extruder or the filament between two moves.
fn write_switch(text: &mut Text, signal: &Step, options: &RapidOptions) {
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
fn write_move(text: &mut Text, to: &Move, signals: &[Step], end: &str) {
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
fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
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
fn write_load(text: &mut Text, load: &Payload) {
    // As many digits as the mass of `tool0` needs, and a tenth of a gram.
    text.word("[").fixed(load.mass_kg, MM).word(",").list(load.centre.coords.as_slice(), MM).word(",[1,0,0,0],0,0,0]");
}

fn write_main<W: Write>(
    options: &RapidOptions,
    written: &RapidWritten,
    used: Used,
    open: &mut impl FnMut(&str) -> std::io::Result<W>,
) -> Result<(), WriteError> {
    let file = format!("{}.mod", options.name);
    let failed = |source| WriteError::Io { file: file.clone(), source };
    let mut out = open(&file).map_err(failed)?;
    let mut text = Text::default();
    text.word("MODULE ").word(&options.name).word("\n");
    text.word("  ! ").fixed(written.seconds, SECONDS);
    text.word(" s of motion at the speeds of its moves, without accelerations and loading\n");
    write_data(&mut text, options);
    let switches = used.switch || used.filament || used.head.contains(&true);
    let off = |text: &mut Text| {
        if switches {
            text.word("    ").word(&options.name).word("_off;\n");
        }
    };
    text.word("  PROC main()\n");
    off(&mut text);
    text.word("    ConfJ\\On;\n    ConfL\\").word(if options.monitor_lines { "On" } else { "Off" }).word(";\n");
    if let Some(unit) = &options.work_object.unit {
        text.word("    ActUnit ").word(unit).word(";\n");
    }
    if options.part_load.is_some() {
        text.word("    GripLoad ").word(&options.name).word("_load;\n");
    }
    for number in 1..=written.modules {
        let name = part_name(options, number);
        let place = format!("\"{}\"\\File:=\"{name}.mod\";\n", options.folder);
        text.word("    Load\\Dynamic,").word(&place);
        text.word("    %\"").word(&name).word("_run\"%;\n");
        text.word("    UnLoad ").word(&place);
        if text.0.len() > CHUNK {
            out.write_all(&text.0).map_err(failed)?;
            text.0.clear();
        }
    }
    off(&mut text);
    if switches {
        text.word("  ERROR\n");
        off(&mut text);
        text.word("    RAISE;\n");
    }
    text.word("  ENDPROC\n");
    if switches {
        text.word("  PROC ").word(&options.name).word("_off()\n");
        if used.filament {
            write_switch(&mut text, &Step::FilamentSpeed(0.0), options);
        }
        if used.switch {
            write_switch(&mut text, &Step::Extruder(false), options);
        }
        for signal in HeadSignal::ALL.into_iter().filter(|signal| used.head[signal.number()]).rev() {
            write_signal(&mut text, signal, false);
        }
        text.word("  ENDPROC\n");
    }
    text.word("ENDMODULE\n");
    out.write_all(&text.0).and_then(|()| out.flush()).map_err(failed)
}

/// Declarations of tool, work object and load.
fn write_data(text: &mut Text, options: &RapidOptions) {
    let truth = |value: bool| if value { "TRUE" } else { "FALSE" };
    let (tool, work) = (&options.tool, &options.work_object);
    if tool.name != TOOL0 {
        if tool.load.is_none() {
            text.word("  ! The mass of ")
                .word(&tool.name)
                .word(" is not known: measure it (LoadIdentify) before a print.\n");
        }
        text.word("  PERS tooldata ").word(&tool.name).word(":=[").word(truth(tool.in_hand)).word(",");
        write_pose(text, &tool.frame);
        text.word("],");
        let unknown = Payload { mass_kg: NO_MASS, centre: Point3::new(0.0, 0.0, NO_MASS) };
        write_load(text, &tool.load.unwrap_or(unknown));
        text.word("];\n");
    }
    if work.name != WOBJ0 {
        text.word("  PERS wobjdata ").word(&work.name).word(":=[").word(truth(work.in_hand));
        if let Some(unit) = &work.unit {
            text.word(",FALSE,\"").word(unit).word("\",[[0,0,0],[1,0,0,0]],");
            write_pose(text, &work.frame);
            text.word("]];\n");
        } else {
            text.word(",TRUE,\"\",");
            write_pose(text, &work.frame);
            text.word("],[[0,0,0],[1,0,0,0]]];\n");
        }
    }
    if let Some(load) = &options.part_load {
        text.word("  PERS loaddata ").word(&options.name).word("_load:=");
        write_load(text, load);
        text.word(";\n");
    }
}
