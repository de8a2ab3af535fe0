//! Signals on the path: `TriggEquip` and the triggers of a `TriggL`, written.
//!
//! A module declares its triggers as `triggdata` and sets each up before its first use; that of the filament anew for each speed, since `TriggL` takes
//! a copy with it: `triggdata` of a procedure may end before the tool is there. `TriggSpeed`, which multiplies the tip's actual speed, is not
//! used: it knows analog outputs only, and has no filament for a tool that turns on the spot. The repository's `docs/decisions/23-robot-programs.md` lists what is not tried.

use super::{FILAMENT, FilamentOutput, LAG, RapidOptions, RapidSwitching, TRIGGERS};
use crate::program::Step;
use crate::program::step::on_path::{Place, place};
use crate::program::text::Text;

/// The triggers of a module: which are set up.
#[derive(Debug, Default)]
pub(super) struct Triggers {
    ready: [bool; TRIGGERS.len()],
}

impl Triggers {
    /// Declarations of a module.
    pub fn declare(text: &mut Text) {
        for name in TRIGGERS {
            text.word("  LOCAL VAR triggdata ").word(name).word(";\n");
        }
    }

    /// Sets up what the next line needs.
    pub fn set_up(&mut self, text: &mut Text, signals: &[Step], options: &RapidOptions) {
        let RapidSwitching::OnPath { lag_s } = options.switching else { return };
        for signal in signals {
            let Some(number) = number(signal) else { continue };
            let changes = matches!(signal, Step::FilamentSpeed(mm_s) if *mm_s > 0.0);
            if std::mem::replace(&mut self.ready[number], true) && !changes {
                continue;
            }
            let start = if place(signal) == Some(Place::Begin) { "\\Start" } else { "" };
            text.word("    TriggEquip ").word(TRIGGERS[number]).word(",0").word(start).word(",");
            text.fixed(lag_s, LAG);
            match signal {
                Step::FilamentSpeed(mm_s) => {
                    let kind = if options.filament_output == FilamentOutput::Analog { "\\AOp:=" } else { "\\GOp:=" };
                    text.word(kind).word(&options.filament_signal).word(",");
                    write_filament_value(text, *mm_s, options);
                }
                _ => {
                    let value = if *signal == Step::Extruder(true) { ",1" } else { ",0" };
                    text.word("\\DOp:=").word(&options.signal).word(value);
                }
            }
            text.word(";\n");
        }
    }

    /// `,extruder_on\T2:=filament_on`, to stand behind the speed.
    pub fn write(text: &mut Text, signals: &[Step]) {
        const OPTIONS: [&str; 4] = [",", "\\T2:=", "\\T3:=", "\\T4:="];
        for (number, option) in signals.iter().filter_map(number).zip(OPTIONS) {
            text.word(option).word(TRIGGERS[number]);
        }
    }
}

/// Its number in [`TRIGGERS`].
fn number(signal: &Step) -> Option<usize> {
    let off = usize::from(place(signal)? == Place::End);
    Some(if matches!(signal, Step::Extruder(_)) { off } else { 2 + off })
}

pub(super) fn write_filament_value(text: &mut Text, mm_s: f64, options: &RapidOptions) {
    match options.filament_output {
        FilamentOutput::Analog => text.fixed(mm_s, FILAMENT),
        FilamentOutput::Group { step_mm_s, .. } => text.fixed((mm_s / step_mm_s).round(), 0),
    };
}
