//! Commands of a flavour, known by their texts.

use super::data::Commands;
use super::fill::{number_in, value_in};
use crate::gcode::fiber::{FiberCommand, TOOLS};
use crate::gcode::{CELSIUS, DWELL, FILAMENT, FULL_FAN, Move, SHARE, within};

/// A command, its value in a text, and the move that it makes.
struct Command<'a> {
    lines: &'a [String],
    /// Name of the value; empty for a command without one.
    name: &'static str,
    /// Range of the value, in the units of the move.
    range: [f64; 2],
    /// What a number of the text is, in the units of the move.
    unit: f64,
    make: fn(f64) -> Option<Move>,
}

/// A number that a command does not take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutOfRange {
    pub name: &'static str,
    pub value: f64,
    pub range: [f64; 2],
}

/// The command that a line is; `None` where it is no command. Of a command of several lines the one with the value counts.
pub(super) fn command(commands: &Commands, text: &str) -> Option<Result<Move, OutOfRange>> {
    for Command { lines, name, range, unit, make } in all(commands) {
        let has_name = |line: &&String| name.is_empty() || line.contains(&format!("{{{name}}}"));
        let Some(value) = lines.iter().find(has_name).and_then(|line| number_in(text, line)) else { continue };
        let item = Some(value * unit).filter(|&value| within(value, range)).and_then(make);
        return Some(item.ok_or(OutOfRange { name, value, range: range.map(|end| end / unit) }));
    }
    let is_cut = commands.cut.first().is_some_and(|line| value_in(text, line).is_some());
    is_cut.then_some(Ok(Move::Fiber(FiberCommand::Cut)))
}

fn all(c: &Commands) -> [Command<'_>; 14] {
    fn of<'a>(
        lines: &'a [String],
        name: &'static str,
        range: [f64; 2],
        unit: f64,
        make: fn(f64) -> Option<Move>,
    ) -> Command<'a> {
        Command { lines, name, range, unit, make }
    }
    let heat = |lines, make| of(lines, "celsius", CELSIUS, 1.0, make);
    [
        of(&c.home, "", [0.0, 0.0], 1.0, |_| Some(Move::Home)),
        of(&c.dwell, "seconds", DWELL, 1.0, |seconds| Some(Move::Dwell { seconds })),
        of(&c.dwell, "milliseconds", DWELL, 1e-3, |seconds| Some(Move::Dwell { seconds })),
        heat(&c.nozzle, |celsius| Some(Move::Nozzle { celsius, wait: false })),
        heat(&c.nozzle_wait, |celsius| Some(Move::Nozzle { celsius, wait: true })),
        heat(&c.bed, |celsius| Some(Move::Bed { celsius, wait: false })),
        heat(&c.bed_wait, |celsius| Some(Move::Bed { celsius, wait: true })),
        of(&c.fan, "share", SHARE, 1.0, |share| Some(Move::Fan { share })),
        of(&c.fan, "byte", SHARE, 1.0 / FULL_FAN, |share| Some(Move::Fan { share: share.min(1.0) })),
        of(&c.tool, "tool", [0.0, 2.0], 1.0, |number| {
            let tool = TOOLS.get(number as usize).filter(|_| number.fract() <= 0.0)?;
            Some(Move::Fiber(FiberCommand::Tool(*tool)))
        }),
        of(&c.tape_feed, "mm", FILAMENT, 1.0, |length_mm| Some(Move::Fiber(FiberCommand::Feed { length_mm }))),
        of(&c.press, "newtons", [0.0, 1e4], 1.0, |newtons| Some(Move::Fiber(FiberCommand::Press { newtons }))),
        heat(&c.roller, |celsius| Some(Move::Fiber(FiberCommand::Heat { celsius, wait: false }))),
        heat(&c.roller_wait, |celsius| Some(Move::Fiber(FiberCommand::Heat { celsius, wait: true }))),
    ]
}
