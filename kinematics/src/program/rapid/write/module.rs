//! A part module that is being written.

use super::statements::{write_acceleration, write_switch};
use crate::program::WriteError;
use crate::program::rapid::trigger::Triggers;
use crate::program::rapid::{FILAMENT_STEP, FilamentOutput, RapidOptions, RapidSwitching};
use crate::program::step::on_path::Waiting;
use crate::program::text::Text;
use std::io::Write;

/// Decimals of the step of a group output.
const STEP: usize = 9;

/// The name of a part module, which counts from 1.
pub fn part_name(options: &RapidOptions, number: u32) -> String {
    format!("{}_{number:03}", options.name)
}

/// A part module that is being written.
pub struct Module<W> {
    file: String,
    out: W,
    pub text: Text,
    /// Moves so far.
    pub moves: u32,
    pub triggers: Triggers,
}

impl<W: Write> Module<W> {
    /// Opens its file, and writes what comes before the first move.
    pub fn begin(
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
    pub fn send_waiting(&mut self, waiting: &mut Waiting, options: &RapidOptions) {
        for signal in waiting.0.drain(..) {
            write_switch(&mut self.text, &signal, options);
        }
    }

    /// Sends the text that was collected to the file.
    pub fn send(&mut self) -> Result<(), WriteError> {
        let sent = self.out.write_all(&self.text.0);
        self.text.0.clear();
        sent.map_err(|source| WriteError::Io { file: self.file.clone(), source })
    }

    /// Ends the procedure and the module, and closes the file.
    pub fn end(mut self) -> Result<(), WriteError> {
        self.text.word("  ENDPROC\nENDMODULE\n");
        self.send()?;
        self.out.flush().map_err(|source| WriteError::Io { file: self.file, source })
    }
}
