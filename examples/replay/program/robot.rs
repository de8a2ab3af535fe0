//! Robot programs: URScript, RAPID, CSV. The readers of the library give their steps; here these become commands for the model.

use super::super::axes::{Axes, Frame};
use super::super::machine::ToolFrames;
use super::command::{self, Command, Motion, Place, Signal, Target, Zone};
use curvlay_kinematics::program::{self, CsvReader, Goal, Step, UrScriptReader, read_rapid};
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
}

/// Programs as commands.
pub struct RobotProgram<'g> {
    give: &'g mut dyn FnMut(Source) -> Result<(), String>,
}

impl<'g> RobotProgram<'g> {
    /// Gives everything to `give`, which may refuse it.
    pub fn new(give: &'g mut dyn FnMut(Source) -> Result<(), String>) -> Self {
        RobotProgram { give }
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

    /// A RAPID program; `open` gives the modules that it loads, by their names.
    ///
    /// # Errors
    /// As [`RobotProgram::urscript`].
    pub fn rapid<R: BufRead>(
        &mut self,
        main: impl BufRead,
        mut open: impl FnMut(&str) -> std::io::Result<R>,
    ) -> Result<(), String> {
        let loads = Cell::new(0u32);
        let opening = |name: &str| {
            loads.set(loads.get() + 1);
            open(name)
        };
        let mut program = read_rapid(main, opening).map_err(|error| error.to_string())?;
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
        let (mut file, mut step, mut acceleration) = (0, 0, None);
        while let Some(found) = program.next() {
            let found = found.map_err(|error| error.to_string())?;
            let now = program.acceleration().and_then(|all| all.path_m_s2);
            if now != acceleration {
                acceleration = now;
                now.map_or(Ok(()), |m_s2| (self.give)(Source::Acceleration(m_s2 * 1000.0)))?;
            }
            if loads.get() != file {
                (file, step) = (loads.get(), 0);
            }
            step += 1;
            self.step(Rules::Abb, Place { file, step }, &found)?;
        }
        Ok(())
    }

    fn step(&mut self, rules: Rules, place: Place, step: &Step) -> Result<(), String> {
        let command = match step {
            Step::Move(found) => Command::Move(motion(rules, found)),
            Step::Servo { joints, seconds } => Command::Servo { axes: axes(joints, None), seconds: *seconds },
            Step::Extruder(on) => Command::Signal(Signal::Extruder(*on)),
            Step::FilamentSpeed(mm_s) => Command::Signal(Signal::Filament(*mm_s)),
            // A tape head: how long its inputs take, no program says.
            Step::Signal { .. } | Step::Wait(_) => return Ok(()),
        };
        (self.give)(Source::Command(place, command))
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
    let tool = command::Speed::Tool { mm_s, rad_s };
    let (goal, speed) = match (&found.goal, rules) {
        (Goal::Joints(joints), Rules::Ur) => (command::Goal::Axes(axes(joints, table)), command::Speed::Joints(rad_s)),
        (Goal::Joints(joints), Rules::Abb) => (command::Goal::Axes(axes(joints, table)), tool),
        (Goal::JointMove(to), Rules::Ur) => (command::Goal::Pose(target(to)), command::Speed::Joints(rad_s)),
        (Goal::JointMove(to), Rules::Abb) => (command::Goal::Pose(target(to)), tool),
        (Goal::Line(to), Rules::Ur) => (command::Goal::Line(target(to)), command::Speed::Linear(mm_s)),
        (Goal::Line(to), Rules::Abb) => (command::Goal::Line(target(to)), tool),
    };
    let zone = match found.zone {
        program::Zone::Stop => Zone::Stop,
        program::Zone::Blend(radius) => Zone::Radius(radius),
    };
    Motion { goal, speed, zone, filament_mm: 0.0 }
}
