//! A RAPID program as it runs: `main`, the procedures that it calls, the modules that it loads.

use super::RapidAcceleration;
use super::data::{Data, ReadWarning};
use super::main::{Module, Procedure, RapidMain};
use super::op::Op;
use super::part::RapidPart;
use crate::program::step::until_error;
use crate::program::{ReadError, Step};
use std::io::{self, BufRead};

/// Calls within calls.
const DEEPEST: usize = 64;
/// Calls of a program: one that calls itself over and over comes to an end.
const CALLS: u64 = 1_000_000;

/// The steps of a whole program, in the order in which they run. Made by [`read_rapid`].
pub struct RapidProgram<R, F> {
    main: RapidMain,
    procedures: Vec<Procedure>,
    open: F,
    /// Procedures under way: which, and the next instruction.
    stack: Vec<(usize, usize)>,
    calls: u64,
    /// Modules loaded so far.
    loads: usize,
    part: Part<R>,
    over: bool,
}

/// The module that is loaded; what is declared is with it.
enum Part<R> {
    None(Box<Data>),
    Loaded(Box<RapidPart<R>>),
    Running(Box<RapidPart<R>>),
}

impl<R: BufRead> Part<R> {
    /// Takes the declarations out.
    fn take(&mut self) -> Data {
        match std::mem::replace(self, Part::None(Box::default())) {
            Part::None(data) => *data,
            Part::Loaded(part) | Part::Running(part) => part.into_data(),
        }
    }
}

/// Reads a program: the main module, and the modules it loads as `open` gives them by their file names.
///
/// # What is read
/// * One module with everything, or a main module that loads modules with one procedure each (`Load\Dynamic`,
///   `UnLoad`, one at a time). A header between `%%%` and attributes of modules are passed over. Layout, comments and case
///   are free.
/// * Declarations `CONST`, `PERS` and `VAR` (with `LOCAL` or `TASK`) of `robtarget`, `jointtarget`, `speeddata`,
///   `zonedata`, `tooldata` and `wobjdata`. Others may stand there, and cannot be used.
/// * Procedures without arguments: `main` runs, or the only one; calls by name, and late (`%"name"%`). An `ERROR` handler
///   is passed over.
/// * `MoveL`, `MoveJ`, `MoveAbsJ` with values in place, declared names, `Offs` or `RelTool` (three offsets);
///   speeds `v5` to `v7000` and `vmax`; `fine` and `z0` to `z200`; `\Conc`, `\ID`, `\NoEOffs`, `\V`, `\Z`, `\Inpos`,
///   `\WObj`, `\TLoad`; one to six external axes ([`ExternalAxes`](crate::program::ExternalAxes)). One tool and one work
///   object for all targets, since steps do not say which is theirs.
/// * `SetDO` (`1`, `0`, `high`, `low`), `Set`, `Reset`: the extruder, one signal, and a tape head by
///   [its names](crate::program::HeadSignal::rapid). `SetAO`, `SetGO` (with a constant
///   `filament_step`): the speed of the filament in mm/s, one signal.
/// * `TriggL`, `TriggJ` with triggers that a `TriggEquip` or `TriggIO` above has set up for these signals: steps before the move for those at
///   its `\Start`, behind it for the others. A lag is passed over; a distance other than 0, and a `\Time`, with a warning.
/// * `ActUnit`, `DeactUnit`, `GripLoad`, `TPWrite`, `TPErase`, `ConfJ`, `ConfL` change no step. `ConfJ\Off`,
///   `ConfL\Off`, `SingArea`, `SpeedRefresh`, `WaitTime`, `WaitRob`, `WaitDI` (but for the [inputs of a tape head](crate::program::HeadInput::rapid)), `WaitDO` and `Stop`
///   are passed over with a warning. `AccSet`, `PathAccLim` and `WorldAccLim` change no step: they are
///   [`RapidProgram::acceleration`].
/// * A sign may stand before any number. A quaternion of few digits (its length within 0.01 of 1) is normalised, with a
///   warning where it is off by more than four digits explain.
///
/// All else is an error with line and column: conditions, loops, assignments, functions, `MoveC`, moves with `\T`. So is a
/// number that no writer of ours takes (beyond 1e6). To pass over a move would be another program.
///
/// # Errors
/// [`ReadError`] with line and column. A module that cannot be opened, or read, comes as an item of the iterator, with
/// its index, and ends it.
///
/// # Cost
/// The main module is in memory, loaded ones are not, but for their declarations.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::{Goal, Move, Step, Zone, read_rapid};
/// let text = r#"
/// MODULE pendant
///   CONST robtarget above := [[600, 0, +350], [0, 0, 1, 0], [0, 0, 0, 0], [9E+09, 9E+09, 9E+09, 9E+09, 9E+09, 9E+09]];
///   PROC main()
///     SingArea\Wrist;
///     path;
///   ENDPROC
///   PROC path()
///     MoveJ above, V100, fine, tool0;
///     Set doExtruder;
///     MoveL Offs(above, 50, 0, 0), V100\V:=12.5, FINE, tool0;
///     Reset doExtruder;
///   ENDPROC
/// ENDMODULE
/// "#;
/// let mut program = read_rapid(text.as_bytes(), |_| Ok::<&[u8], _>(b""))?;
/// let steps: Vec<Step> = program.by_ref().collect::<Result<_, _>>()?;
/// assert_eq!(steps.len(), 4);
/// let Step::Move(Move { goal: Goal::Line(target), speed, zone: Zone::Stop, .. }) = steps[2] else { return Err("no line".into()) };
/// assert_eq!((target.pose.translation.x, speed.mm_s), (650.0, 12.5));
/// assert!(program.warnings()[0].to_string().contains("SingArea is not followed"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_rapid<R: BufRead, F: FnMut(&str) -> io::Result<R>>(
    main: impl BufRead,
    open: F,
) -> Result<RapidProgram<R, F>, ReadError> {
    let module = Module::read(main)?;
    let main = module.main();
    let Module { data, procedures, end, .. } = module;
    let is_main = |procedure: &Procedure| procedure.name.eq_ignore_ascii_case("main");
    let start = match (procedures.iter().position(is_main), procedures.len()) {
        (Some(at), _) => at,
        (None, 1) => 0,
        (None, _) => {
            let (line, column) = end;
            let found = "the end of the module".to_owned();
            return Err(ReadError::Unexpected { line, column, expected: "PROC main()", found });
        }
    };
    let (stack, part) = (vec![(start, 0)], Part::None(Box::new(data)));
    Ok(RapidProgram { main, procedures, open, stack, calls: 0, loads: 0, part, over: false })
}

impl<R: BufRead, F> RapidProgram<R, F> {
    /// The main module.
    pub fn main(&self) -> &RapidMain {
        &self.main
    }

    /// The accelerations that the instructions so far have set, if any has (`AccSet`, `PathAccLim`, `WorldAccLim`): steps have none. In the
    /// main module they count from the begin, as it is read at once.
    pub fn acceleration(&self) -> Option<RapidAcceleration> {
        match &self.part {
            Part::None(data) => data.acceleration,
            Part::Loaded(part) | Part::Running(part) => part.acceleration(),
        }
    }

    /// What was worth a warning so far, in the main module and the loaded ones; the first thousand.
    pub fn warnings(&self) -> &[ReadWarning] {
        match &self.part {
            Part::None(data) => &data.warnings,
            Part::Loaded(part) | Part::Running(part) => part.warnings(),
        }
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> RapidProgram<R, F> {
    fn step(&mut self) -> Result<Option<Step>, ReadError> {
        loop {
            if let Part::Running(part) = &mut self.part {
                match part.next().transpose() {
                    Ok(Some(step)) => return Ok(Some(step)),
                    Ok(None) => self.part = Part::None(Box::new(self.part.take())),
                    Err(source) => {
                        let (index, file) = (self.loads.saturating_sub(1), part.file().to_owned());
                        return Err(ReadError::InPart { index, file, source: Box::new(source) });
                    }
                }
                continue;
            }
            let Some((procedure, at)) = self.stack.last_mut() else { return Ok(None) };
            let Some((op, place)) = self.procedures[*procedure].body.get(*at).cloned() else {
                self.stack.pop();
                continue;
            };
            *at += 1;
            match op {
                Op::Step(step) => return Ok(Some(step)),
                Op::Call(name) => self.call(&name, place)?,
                Op::Load(file) => self.load(&file)?,
                Op::UnLoad => self.part = Part::None(Box::new(self.part.take())),
                Op::Nothing | Op::End => {}
            }
        }
    }

    fn call(&mut self, name: &str, (line, column): (u64, u64)) -> Result<(), ReadError> {
        let refused = |expected| ReadError::Unexpected { line, column, expected, found: format!("`{name}`") };
        self.calls += 1;
        if self.calls > CALLS || self.stack.len() >= DEEPEST {
            return Err(refused("calls that come to an end (64 within each other, a million in all)"));
        }
        let is_it = |procedure: &Procedure| procedure.name.eq_ignore_ascii_case(name);
        if let Some(at) = self.procedures.iter().position(is_it) {
            self.stack.push((at, 0));
            return Ok(());
        }
        match std::mem::replace(&mut self.part, Part::None(Box::default())) {
            Part::Loaded(part) if part.procedure().eq_ignore_ascii_case(name) => {
                self.part = Part::Running(part);
                Ok(())
            }
            other => {
                self.part = other;
                Err(refused("an instruction that is known here, or a procedure of the program"))
            }
        }
    }

    fn load(&mut self, file: &str) -> Result<(), ReadError> {
        self.loads += 1;
        let data = self.part.take();
        let opened = (self.open)(file);
        match opened.map(|reader| RapidPart::with(reader, data, Some(file))) {
            Ok(Ok(part)) => {
                self.part = Part::Loaded(Box::new(part));
                Ok(())
            }
            Ok(Err((source, data))) => {
                self.part = Part::None(data);
                Err(ReadError::InPart { index: self.loads - 1, file: file.to_owned(), source: Box::new(source) })
            }
            Err(source) => Err(ReadError::Part { index: self.loads - 1, file: file.to_owned(), source }),
        }
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> Iterator for RapidProgram<R, F> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut over = self.over;
        let next = until_error(&mut over, || self.step());
        self.over = over;
        next
    }
}
