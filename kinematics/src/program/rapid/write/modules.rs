//! Steps cut into part modules.

use super::main::write_main;
use super::module::Module;
use super::outputs::Outputs;
use super::statements::{write_move, write_signal, write_switch, write_wait};
use super::written::RapidWritten;
use crate::program::check::{Checker, Clock};
use crate::program::rapid::options::check_options;
use crate::program::rapid::{FilamentOutput, RapidOptions, RapidSwitching};
use crate::program::step::on_path::{Place, Waiting, place};
use crate::program::{Goal, Move, ProgramLimits, Step, WriteError, Zone};
use std::io::Write;
use std::iter::Peekable;

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
    let limits = limits(options);
    let mut writer = Writer {
        options,
        steps: steps.into_iter().peekable(),
        open: &mut open,
        checker: Checker::new(&limits),
        clock: Clock::default(),
        outputs: Outputs::default(),
        waiting: Waiting::default(),
        module: None,
        written: RapidWritten { modules: 0, moves: 0, stops_added: 0, seconds: 0.0 },
        end: format!(",{}\\WObj:={};\n", options.tool.name, options.work_object.name),
    };
    while let Some(step) = writer.steps.next() {
        writer.pass(step)?;
    }
    writer.finish()
}

/// What the controller takes; the filament no faster than its output can say.
fn limits(options: &RapidOptions) -> ProgramLimits {
    let filament_mm_s = match options.filament_output {
        FilamentOutput::Analog => f64::INFINITY,
        FilamentOutput::Group { step_mm_s, bits } => step_mm_s * f64::from((1u32 << bits) - 1),
    };
    ProgramLimits { filament_mm_s: options.limits.filament_mm_s.min(filament_mm_s), ..options.limits }
}

/// A program that is being written. Each step is checked, then written into the module that is open.
struct Writer<'a, S: Iterator<Item = Step>, O, W> {
    options: &'a RapidOptions,
    /// The steps that are not written yet: a move must know what follows it.
    steps: Peekable<S>,
    open: &'a mut O,
    checker: Checker<'a>,
    clock: Clock,
    outputs: Outputs,
    /// Signals that wait for the line behind them.
    waiting: Waiting,
    /// The part module that is open. One is opened by the first step that goes into it, so none is empty.
    module: Option<Module<W>>,
    written: RapidWritten,
    /// The end of every move: tool and work object.
    end: String,
}

impl<S, O, W> Writer<'_, S, O, W>
where
    S: Iterator<Item = Step>,
    O: FnMut(&str) -> std::io::Result<W>,
    W: Write,
{
    /// Checks a step and writes it. Ends the module where it is long enough.
    fn pass(&mut self, step: Step) -> Result<(), WriteError> {
        self.checker.check(&step)?;
        let options = self.options;
        self.clock.pass(&step, &|joints: &[f64; 6], table| options.work_tool(joints, table));
        let mut module = match self.module.take() {
            Some(module) => module,
            None => {
                self.written.modules += 1;
                Module::begin(options, self.written.modules, self.open)?
            }
        };
        let at_rest = self.write(&mut module, step)?;
        if module.text.0.len() > CHUNK {
            module.send()?;
        }
        if self.is_long_enough(&module, at_rest) {
            return module.end();
        }
        self.module = Some(module);
        Ok(())
    }

    /// Writes a step. Returns whether the tool is at rest behind it.
    fn write(&mut self, module: &mut Module<W>, step: Step) -> Result<bool, WriteError> {
        match step {
            Step::Move(to) => return self.write_move(module, to),
            Step::Extruder(_) | Step::FilamentSpeed(_) => self.switch(module, step),
            Step::Signal { signal, on } => {
                module.send_waiting(&mut self.waiting, self.options);
                self.outputs.set(signal, on);
                write_signal(&mut module.text, signal, on);
            }
            Step::Wait(input) => {
                module.send_waiting(&mut self.waiting, self.options);
                write_wait(&mut module.text, input);
            }
            Step::Servo { .. } => return Err(self.checker.unsupported("stream of joints", "RAPID")),
        }
        Ok(false)
    }

    /// Writes a move with the signals on its path; only lines have any. The last move of a module stops, for a module must not be unloaded
    /// while its last corner is still to be rounded.
    fn write_move(&mut self, module: &mut Module<W>, mut to: Move) -> Result<bool, WriteError> {
        module.moves += 1;
        self.written.moves += 1;
        let is_line = self.is_on_path() && matches!(to.goal, Goal::Line(_));
        if !is_line {
            module.send_waiting(&mut self.waiting, self.options);
        }
        let mut signals = std::mem::take(&mut self.waiting);
        if is_line {
            signals.0.append(&mut self.ends_of_line()?);
        }
        let last = module.moves >= self.options.moves_per_module || self.steps.peek().is_none();
        if last && to.zone != Zone::Stop {
            to.zone = Zone::Stop;
            self.written.stops_added += 1;
        }
        module.triggers.set_up(&mut module.text, &signals.0, self.options);
        write_move(&mut module.text, &to, &signals.0, &self.end);
        Ok(to.zone == Zone::Stop)
    }

    /// A signal of the extruder or the filament: one that belongs to the begin of a line waits for it, any other stands between the moves. The
    /// order of two signals of one output stays: the first one does not wait then.
    fn switch(&mut self, module: &mut Module<W>, signal: Step) {
        self.outputs.note(&signal);
        let waits = self.is_on_path() && place(&signal) == Some(Place::Begin);
        if !waits || self.waiting.has(&signal) {
            module.send_waiting(&mut self.waiting, self.options);
        }
        if waits {
            self.waiting.0.push(signal);
        } else {
            write_switch(&mut module.text, &signal, self.options);
        }
    }

    /// The signals that go off behind a line: they come at its end, as its triggers, so they leave the steps together with it. One of each
    /// output at most, since two at one place of a path have no order.
    fn ends_of_line(&mut self) -> Result<Vec<Step>, WriteError> {
        let mut ends = Waiting::default();
        while let Some(off) = self.steps.next_if(|next| place(next) == Some(Place::End) && !ends.has(next)) {
            self.checker.check(&off)?;
            self.outputs.note(&off);
            ends.0.push(off);
        }
        Ok(ends.0)
    }

    /// Whether signals of the extruder and the filament are triggers of lines.
    fn is_on_path(&self) -> bool {
        self.options.switching != RapidSwitching::Between
    }

    /// Whether a module ends here: at its most moves, or within the last quarter of them where the tool is at rest and nothing is laid.
    /// Not over the begin of a stroke: there the nozzle would wait on the part.
    fn is_long_enough(&mut self, module: &Module<W>, at_rest: bool) -> bool {
        let most = self.options.moves_per_module;
        let signal_next = matches!(
            self.steps.peek(),
            Some(Step::Extruder(_) | Step::FilamentSpeed(_) | Step::Signal { .. } | Step::Wait(_))
        );
        let idle = at_rest && !self.outputs.is_working() && !signal_next;
        module.moves >= most || (module.moves > most - most / 4 && idle)
    }

    /// Ends the last module and writes the main one.
    fn finish(mut self) -> Result<RapidWritten, WriteError> {
        if let Some(mut module) = self.module.take() {
            module.send_waiting(&mut self.waiting, self.options);
            module.end()?;
        }
        self.checker.finish()?;
        self.written.seconds = self.clock.seconds;
        write_main(self.options, &self.written, self.outputs.used, self.open)?;
        Ok(self.written)
    }
}
