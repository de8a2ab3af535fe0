//! Programs of five-axis machines: moves of the part are planned as motions of the machine's axes, and written in the flavour of its controller.

use curvlay_kinematics::machine::{
    AxisPlanError, AxisPlanOptions, AxisPlanSummary, AxisStep, FiveAxis, PathMove, plan_axes,
};
use curvlay_toolpath::gcode::flavour::{
    AxisMove, Flavour, FlavourWritten, MachineAxis, ProgramOptions, write_axis_moves,
};
use curvlay_toolpath::gcode::{EndLift, FiberCommand, Move, Tool, WriteError};
use nalgebra::{Point3, UnitVector3};
use std::io::Write;

/// Why a program of axes could not be written.
#[derive(Debug, thiserror::Error)]
pub enum AxisProgramError {
    /// The machine cannot do it.
    #[error(transparent)]
    Plan(#[from] AxisPlanError),
    /// The program cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The axes of a machine, as the writer of programs has them.
pub fn axes_of(machine: &FiveAxis) -> Vec<MachineAxis> {
    let linear = machine.linear_count();
    let axis = |(k, &letter): (usize, &char)| MachineAxis { letter, is_rotary: k >= linear };
    machine.letters().iter().enumerate().map(axis).collect()
}

/// Plans moves of the part for a machine and writes them in a flavour. After a last bead the nozzle leaves the part as [`ProgramOptions::end`] says.
///
/// # Errors
/// [`AxisProgramError`]: what the machine does not reach, or what the flavour cannot say; what was written until then is half a file.
pub fn write_axis_program(
    machine: &FiveAxis,
    moves: impl IntoIterator<Item = Move>,
    flavour: &Flavour,
    plan: AxisPlanOptions,
    options: &ProgramOptions<'_>,
    out: impl Write,
) -> Result<(FlavourWritten, AxisPlanSummary), AxisProgramError> {
    let axes = axes_of(machine);
    // Polar machines have two linear axes.
    if let Ok(axes) = <&[MachineAxis; 4]>::try_from(axes.as_slice()) {
        return write_of(machine, axes, moves, flavour, plan, options, out);
    }
    match <&[MachineAxis; 5]>::try_from(axes.as_slice()) {
        Ok(axes) => write_of(machine, axes, moves, flavour, plan, options, out),
        Err(_) => unreachable!("a machine of {} axes", axes.len()),
    }
}

fn write_of<const N: usize>(
    machine: &FiveAxis,
    axes: &[MachineAxis; N],
    moves: impl IntoIterator<Item = Move>,
    flavour: &Flavour,
    plan: AxisPlanOptions,
    options: &ProgramOptions<'_>,
    out: impl Write,
) -> Result<(FlavourWritten, AxisPlanSummary), AxisProgramError> {
    let leaving = Leaving { moves: moves.into_iter(), end: options.end, bead: None, left: Vec::new() };
    let mut planned = plan_axes(machine, leaving.map(path_move), plan)?;
    // The writer takes moves alone: a fault of the plan ends them, and is found behind it.
    let mut fault = None;
    let mut bridge = Bridge { at: None, is_tape: false };
    let steps = std::iter::from_fn(|| match planned.next()? {
        Ok(step) => Some(bridge.step::<N>(step)),
        Err(error) => {
            fault = Some(error);
            None
        }
    });
    let written = write_axis_moves(axes, steps, flavour, options, out);
    match fault {
        Some(error) => Err(error.into()),
        None => Ok((written?, *planned.summary())),
    }
}

/// A move for the planner: what concerns no axis passes through.
fn path_move(item: Move) -> PathMove<Move> {
    match item {
        Move::Travel { tip, direction, feed_mm_s } => PathMove::Travel { tip, direction, feed_mm_s },
        Move::Print { tip, direction, filament_mm, feed_mm_s } => {
            PathMove::Print { tip, direction, filament_mm, feed_mm_s }
        }
        Move::Lay { tip, direction, feed_mm_s } => PathMove::Print { tip, direction, filament_mm: 0.0, feed_mm_s },
        Move::Home => PathMove::Restart(item),
        _ => PathMove::Pass(item),
    }
}

/// Steps of the planner, as the writer takes them.
struct Bridge {
    /// Where the axes are.
    at: Option<[f64; 5]>,
    /// A roller lays tape in place of filament.
    is_tape: bool,
}

/// Shortest time of a line, seconds.
const MIN_S: f64 = 1e-4;

impl Bridge {
    fn step<const N: usize>(&mut self, step: AxisStep<Move>) -> AxisMove<N> {
        let motion = match step {
            AxisStep::Pass(item) => {
                if let Move::Fiber(FiberCommand::Tool(tool)) = item {
                    self.is_tape = tool != Tool::Nozzle;
                }
                return AxisMove::Still(item);
            }
            AxisStep::Move(motion) => motion,
        };
        let (seconds, filament_mm) = (motion.seconds.max(MIN_S), motion.filament_mm);
        let axes: [f64; N] = std::array::from_fn(|k| motion.axes[k]);
        let rests = self.at == Some(motion.axes);
        self.at = Some(motion.axes);
        let feed_mm_s = filament_mm.abs() / seconds;
        match (motion.printing, self.is_tape) {
            (true, true) => AxisMove::Lay { axes, seconds },
            (true, false) => AxisMove::Print { axes, seconds, filament_mm },
            // A rewind draws filament back and gives it back while the axes rest.
            (false, _) if rests && filament_mm < 0.0 => {
                AxisMove::Still(Move::Retract { filament_mm: -filament_mm, feed_mm_s })
            }
            (false, _) if rests && filament_mm > 0.0 => AxisMove::Still(Move::Prime { filament_mm, feed_mm_s }),
            (false, _) => AxisMove::Travel { axes, seconds },
        }
    }
}

/// Moves of the part, and the way off it behind a last bead.
struct Leaving<I> {
    moves: I,
    end: Option<EndLift>,
    /// Tip and direction at the end of a bead, until something else is done.
    bead: Option<(Point3<f64>, UnitVector3<f64>)>,
    /// What is still to be done, the last first.
    left: Vec<Move>,
}

impl<I: Iterator<Item = Move>> Iterator for Leaving<I> {
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        if let Some(item) = self.moves.next() {
            self.bead = match item {
                Move::Print { tip, direction, .. } => Some((tip, direction)),
                Move::Travel { .. } | Move::Lay { .. } | Move::Retract { .. } | Move::Prime { .. } | Move::Home => None,
                _ => self.bead,
            };
            return Some(item);
        }
        if let (Some(end), Some((tip, direction))) = (self.end, self.bead.take()) {
            let away = tip + direction.into_inner() * end.lift_mm;
            self.left.push(Move::Travel { tip: away, direction, feed_mm_s: end.feed_mm_s });
            if end.filament_mm > 0.0 {
                self.left.push(Move::Retract { filament_mm: end.filament_mm, feed_mm_s: end.filament_feed_mm_s });
            }
        }
        self.left.pop()
    }
}
