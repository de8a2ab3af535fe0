//! The filament on its way into a file: as an axis, as a flow, as a switch, or not at all.

use super::data::{FilamentWords, Flavour};
use super::feed::{Class, Part};
use super::words::{NUMBER, push};
use crate::gcode::text::{Text, steps};
use crate::gcode::within;

/// What stands in the file by now.
#[derive(Debug, Default)]
pub(super) struct Extruder {
    /// What has been asked for since the last zero, in units of the file.
    asked: f64,
    /// What has been written since, in steps of the last digit. What the digits of one line leave out the next one makes good.
    written: i64,
    /// The flow that holds, in steps of its last digit.
    flow: i64,
    /// Whether the switch is on.
    on: bool,
}

/// Position or flow of the extruder, in units of the file: beyond what readers take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beyond(pub f64);

/// A line that changes a signal.
pub(super) type Change = Option<String>;

impl Extruder {
    /// Whether material leaves, or is about to.
    pub fn runs(&self) -> bool {
        self.flow != 0 || self.on
    }

    /// The line before a bead that sets the position back to 0, if it has grown far enough.
    pub fn zero<'a>(&mut self, flavour: &'a Flavour) -> Option<&'a str> {
        let FilamentWords::Axis { scale, relative: false, zero, reset_mm: Some(reset_mm), .. } = &flavour.filament
        else {
            return None;
        };
        let position = self.written as f64 * unit(flavour);
        if position.abs() <= reset_mm * scale.abs() {
            return None;
        }
        self.asked -= position;
        self.written = 0;
        Some(zero)
    }

    /// The word of an axis that moves by so much filament, and its way in units of the file; nothing for other flavours.
    pub fn word(&mut self, flavour: &Flavour, by_mm: f64, text: &mut Text) -> Result<Option<Part>, Beyond> {
        let FilamentWords::Axis { word, close, scale, relative, .. } = &flavour.filament else { return Ok(None) };
        let by = by_mm * scale;
        let asked = self.asked + by;
        if !within(asked, NUMBER) {
            return Err(Beyond(asked));
        }
        let to = steps(asked, flavour.numbers.filament);
        // A rounding may not turn a bead into a retraction, or the other way round.
        let to = if by < 0.0 { to.min(self.written) } else { to.max(self.written) };
        let moved = to - self.written;
        push(text, word, if *relative { moved } else { to }, flavour.numbers.filament, flavour);
        text.word(close);
        let moved_by = moved as f64 * unit(flavour);
        // What is counted move by move never grows.
        (self.asked, self.written) = if *relative { (asked - moved_by, 0) } else { (asked, to) };
        Ok(Some(Part { class: Class::of_extruder(word), by: moved_by, is_extruder: true }))
    }

    /// The line before a move that lasts so long, if the signal is another one than before.
    pub fn change(&mut self, flavour: &Flavour, filament_mm: f64, seconds: f64) -> Result<Change, Beyond> {
        match &flavour.filament {
            FilamentWords::Flow { change, scale, .. } => {
                let flow = if filament_mm > 0.0 { scale * filament_mm / seconds } else { 0.0 };
                self.set_flow(flavour, change, flow)
            }
            FilamentWords::Switch { on, off } => {
                let wanted = filament_mm > 0.0;
                let line = if wanted { on } else { off };
                Ok((std::mem::replace(&mut self.on, wanted) != wanted).then(|| line.clone()))
            }
            _ => Ok(None),
        }
    }

    /// The line that sets the flow while all stands still, mm/s of filament; or switches off.
    pub fn at_once(&mut self, flavour: &Flavour, mm_s: f64) -> Result<Change, Beyond> {
        match &flavour.filament {
            FilamentWords::Flow { at_once, scale, .. } => self.set_flow(flavour, at_once, scale * mm_s),
            _ => self.change(flavour, 0.0, 1.0),
        }
    }

    fn set_flow(&mut self, flavour: &Flavour, line: &str, flow: f64) -> Result<Change, Beyond> {
        let decimals = flavour.numbers.filament;
        if !within(flow, NUMBER) {
            return Err(Beyond(flow));
        }
        let flow = steps(flow, decimals);
        if flow == self.flow {
            return Ok(None);
        }
        self.flow = flow;
        let mut text = Text::default();
        text.steps(flow, decimals);
        Ok(Some(line.replace("{flow}", &String::from_utf8_lossy(&text.0))))
    }
}

/// The last digit of the filament.
fn unit(flavour: &Flavour) -> f64 {
    10f64.powi(-(flavour.numbers.filament as i32))
}
