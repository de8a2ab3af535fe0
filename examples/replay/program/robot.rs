//! Robot programs: URScript, RAPID, KRL, TP, CSV. The readers of the library give their steps; here these become commands for the model.

use super::super::axes::{Axes, Frame};
use super::super::machine::ToolFrames;
use super::command::{self, Command, Motion, Place, Signal, Target, Zone};
use curvlay_kinematics::program::{
    self, CsvReader, Goal, ReadError, Step, UrScriptReader, read_krl, read_rapid, read_tp,
};
use std::cell::Cell;
use std::io::BufRead;

/// What a program gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// The frames of its targets, from here on.
    Frames(ToolFrames),
    /// Acceleration of the path, in mm/s2, from here on.
    Acceleration(f64),
    /// A command.
    Command(Place, Command),
}

/// Whose rules a move follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rules {
    Ur,
    Abb,
    Kuka,
    Fanuc,
}

/// Programs as commands.
pub struct RobotProgram<'g> {
    give: &'g mut dyn FnMut(Source) -> Result<(), String>,
    has_table: bool,
}

impl<'g> RobotProgram<'g> {
    /// Gives everything to `give`, which may refuse it. `has_table`: whether the workcell has a table that tilts and turns.
    pub fn new(give: &'g mut dyn FnMut(Source) -> Result<(), String>, has_table: bool) -> Self {
        RobotProgram { give, has_table }
    }

    /// A file of URScript.
    ///
    /// # Errors
    /// What the reader says, with line and column, or `give`.
    pub fn urscript(&mut self, reader: impl BufRead, file: u32) -> Result<(), String> {
        let reader = UrScriptReader::new(reader).map_err(|error| error.to_string())?;
        let frames = ToolFrames {
            part_in_hand: reader.part_in_hand(),
            tool: Frame::from(reader.tool()),
            work: Frame::from(reader.work()),
            on_table: false,
        };
        (self.give)(Source::Frames(frames))?;
        for (step, found) in (1..).zip(reader) {
            let found = found.map_err(|error| error.to_string())?;
            self.step(Rules::Ur, Place { file, step }, &found)?;
        }
        Ok(())
    }

    /// Steps as CSV. Its targets refer to frames that the file does not have: `frames` are those of the workcell.
    ///
    /// # Errors
    /// As [`RobotProgram::urscript`].
    pub fn csv(&mut self, reader: impl BufRead, file: u32, frames: ToolFrames) -> Result<(), String> {
        (self.give)(Source::Frames(frames))?;
        let reader = CsvReader::new(reader).map_err(|error| error.to_string())?;
        for (step, found) in (1..).zip(reader) {
            let found = found.map_err(|error| error.to_string())?;
            self.step(Rules::Abb, Place { file, step }, &found)?;
        }
        Ok(())
    }

    /// A RAPID program; `open` gives the modules that it loads, by their names. Its files have numbers from `file` on.
    ///
    /// # Errors
    /// As [`RobotProgram::urscript`].
    pub fn rapid<R: BufRead>(
        &mut self,
        main: impl BufRead,
        open: impl FnMut(&str) -> std::io::Result<R>,
        file: u32,
    ) -> Result<(), String> {
        let opened = Cell::new(0);
        let mut program = read_rapid(main, counting(open, &opened)).map_err(|error| error.to_string())?;
        let main = program.main();
        let identity = nalgebra::Isometry3::identity();
        let work = main.work_object.as_ref();
        let frames = ToolFrames {
            part_in_hand: work.is_some_and(|work| work.in_hand),
            tool: Frame::from(main.tool.as_ref().map_or(&identity, |tool| &tool.frame)),
            work: Frame::from(work.map_or(&identity, |work| &work.frame)),
            on_table: work.is_some_and(|work| work.unit.is_some()),
        };
        (self.give)(Source::Frames(frames))?;
        let (mut at, mut acceleration) = (Steps::new(file, &opened), None);
        while let Some(found) = program.next() {
            let found = found.map_err(|error| error.to_string())?;
            let now = program.acceleration().and_then(|all| all.path_m_s2);
            if now != acceleration {
                acceleration = now;
                now.map_or(Ok(()), |m_s2| (self.give)(Source::Acceleration(m_s2 * 1000.0)))?;
            }
            self.step(Rules::Abb, at.next(), &found)?;
        }
        Ok(())
    }

    /// A KRL program of a main module and its data list; `open` gives the modules that it calls. Its files, the data list aside, have numbers from `file` on.
    ///
    /// # Errors
    /// As [`RobotProgram::urscript`].
    pub fn krl<R: BufRead>(
        &mut self,
        [data, main]: [impl BufRead; 2],
        open: impl FnMut(&str) -> std::io::Result<R>,
        file: u32,
    ) -> Result<(), String> {
        let opened = Cell::new(0);
        let mut program = read_krl(data, main, counting(open, &opened)).map_err(|error| error.to_string())?;
        // What carries the frames is known from the first step on.
        let mut step = program.next();
        let [first, second] = program.frames().map(|frame| Frame::from(&frame));
        let part_in_hand = program.part_in_hand();
        let (tool, work) = if part_in_hand { (second, first) } else { (first, second) };
        let on_table = program.kinematic().is_some();
        (self.give)(Source::Frames(ToolFrames { part_in_hand, tool, work, on_table }))?;
        let mut at = Steps::new(file, &opened);
        while let Some(found) = step {
            let found = found.map_err(|error| error.to_string())?;
            self.step(Rules::Kuka, at.next(), &found)?;
            step = program.next();
        }
        Ok(())
    }

    /// A TP program of a main and the programs that it calls. Its positions refer to frames that are measured in the controller: `frames` are those of the workcell.
    /// Its files have numbers from `file` on.
    ///
    /// # Errors
    /// As [`RobotProgram::urscript`].
    pub fn tp<R: BufRead>(
        &mut self,
        main: impl BufRead,
        open: impl FnMut(&str) -> std::io::Result<R>,
        file: u32,
        frames: ToolFrames,
    ) -> Result<(), String> {
        let opened = Cell::new(0);
        let program = read_tp(main, counting(open, &opened)).map_err(|error| error.to_string())?;
        if program.part_in_hand() != frames.part_in_hand {
            let [who, other] = if frames.part_in_hand { ["part", "nozzle"] } else { ["nozzle", "part"] };
            return Err(format!(
                "the robot holds the {other} in the program, and the {who} in the workcell: name the right --workcell"
            ));
        }
        (self.give)(Source::Frames(frames))?;
        let mut at = Steps::new(file, &opened);
        for found in program {
            let found = found.map_err(|error: ReadError| error.to_string())?;
            self.step(Rules::Fanuc, at.next(), &found)?;
        }
        Ok(())
    }

    fn step(&mut self, rules: Rules, place: Place, step: &Step) -> Result<(), String> {
        let command = match step {
            Step::Move(found) => {
                if let Some(external) = found.table.filter(|external| !self.has_table || external.table().is_none()) {
                    let count = external.axes().iter().flatten().count();
                    let has = if self.has_table { "tilt and turn of a table" } else { "no table" };
                    return Err(format!(
                        "step {}: the move has {count} external axes, the workcell {has}: name the right --workcell",
                        place.step
                    ));
                }
                Command::Move(motion(rules, found))
            }
            Step::Servo { joints, seconds } => Command::Servo { axes: axes(joints, None), seconds: *seconds },
            Step::Extruder(on) => Command::Signal(Signal::Extruder(*on)),
            Step::FilamentSpeed(mm_s) => Command::Signal(Signal::Filament(*mm_s)),
            // A tape head: how long its inputs take, no program says.
            Step::Signal { .. } | Step::Wait(_) => return Ok(()),
        };
        (self.give)(Source::Command(place, command))
    }
}

/// Counts the files that a reader opens beside the main one.
fn counting<R>(
    mut open: impl FnMut(&str) -> std::io::Result<R>,
    opened: &Cell<u32>,
) -> impl FnMut(&str) -> std::io::Result<R> {
    move |name| {
        opened.set(opened.get() + 1);
        open(name)
    }
}

/// Counts steps in each file of a program.
struct Steps<'c> {
    first: u32,
    opened: &'c Cell<u32>,
    place: Place,
}

impl<'c> Steps<'c> {
    /// Before the first step: the main file has the number `first`, and so many files are `opened` beside it.
    fn new(first: u32, opened: &'c Cell<u32>) -> Self {
        Steps { first, opened, place: Place { file: first, step: 0 } }
    }

    /// The place of the step that was read last.
    fn next(&mut self) -> Place {
        let file = self.first + self.opened.get();
        if self.place.file != file {
            self.place = Place { file, step: 0 };
        }
        self.place.step += 1;
        self.place
    }
}

fn axes(joints: &[f64; 6], table: Option<[f64; 2]>) -> Axes {
    let [tilt, turn] = table.unwrap_or_default();
    let [a, b, c, d, e, f] = *joints;
    [a, b, c, d, e, f, tilt, turn]
}

fn motion(rules: Rules, found: &program::Move) -> Motion {
    let table = found.table.and_then(|table| table.table());
    let target = |target: &program::Target| {
        let program::ConfData { cf1, cf4, cf6, .. } = target.conf;
        let quarters = (rules == Rules::Abb).then_some([cf1, cf4, cf6]);
        Target { pose: Frame::from(&target.pose), table, quarters }
    };
    let program::Speed { mm_s, rad_s } = found.speed;
    let goal = match &found.goal {
        Goal::Joints(joints) => command::Goal::Axes(axes(joints, table)),
        Goal::JointMove(to) => command::Goal::Pose(target(to)),
        Goal::Line(to) => command::Goal::Line(target(to)),
    };
    let is_line = matches!(found.goal, Goal::Line(_));
    let speed = match rules {
        Rules::Abb => command::Speed::Tool { mm_s, rad_s },
        Rules::Kuka if is_line => command::Speed::Tool { mm_s, rad_s },
        Rules::Ur | Rules::Fanuc if is_line => command::Speed::Linear(mm_s),
        Rules::Ur | Rules::Kuka | Rules::Fanuc => command::Speed::Joints(rad_s),
    };
    let zone = match found.zone {
        program::Zone::Stop => Zone::Stop,
        program::Zone::Blend(radius) => Zone::Radius(radius),
    };
    Motion { goal, speed, zone, filament_mm: 0.0, extrudes: false }
}
