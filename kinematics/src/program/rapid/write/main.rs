//! The main module: declarations, and a procedure that loads the part modules in turn.

use super::module::part_name;
use super::outputs::Used;
use super::statements::{write_load, write_pose, write_signal, write_switch};
use super::written::RapidWritten;
use crate::program::rapid::{NO_MASS, RapidOptions, SECONDS, TOOL0, WOBJ0};
use crate::program::text::Text;
use crate::program::{HeadSignal, Payload, Step, WriteError};
use nalgebra::Point3;
use std::io::Write;

/// Text that is collected before it goes out: a program of many modules has a long main module.
const CHUNK: usize = 32 * 1024;

/// Writes the main module of a program whose part modules are `written` and that uses these outputs.
pub fn write_main<W: Write>(
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
    write_begin(&mut text, options, used);
    for number in 1..=written.modules {
        write_part(&mut text, options, number);
        if text.0.len() > CHUNK {
            out.write_all(&text.0).map_err(failed)?;
            text.0.clear();
        }
    }
    write_end(&mut text, options, used);
    if used.any() {
        write_off(&mut text, options, used);
    }
    text.word("ENDMODULE\n");
    out.write_all(&text.0).and_then(|()| out.flush()).map_err(failed)
}

/// The begin of `main`: outputs off, how the controller monitors configurations, what moves the part, and its mass.
fn write_begin(text: &mut Text, options: &RapidOptions, used: Used) {
    text.word("  PROC main()\n");
    call_off(text, options, used);
    text.word("    ConfJ\\On;\n    ConfL\\").word(if options.monitor_lines { "On" } else { "Off" }).word(";\n");
    if let Some(unit) = &options.work_object.unit {
        text.word("    ActUnit ").word(unit).word(";\n");
    }
    if options.part_load.is_some() {
        text.word("    GripLoad ").word(&options.name).word("_load;\n");
    }
}

/// Loads a part module, runs it and unloads it: the controller holds one at a time. Its procedure is called by name (`%"..."%`), since it is
/// not there when the main module is loaded.
fn write_part(text: &mut Text, options: &RapidOptions, number: u32) {
    let name = part_name(options, number);
    let place = format!("\"{}\"\\File:=\"{name}.mod\";\n", options.folder);
    text.word("    Load\\Dynamic,").word(&place);
    text.word("    %\"").word(&name).word("_run\"%;\n");
    text.word("    UnLoad ").word(&place);
}

/// The end of `main`: outputs off, also where an error is raised.
fn write_end(text: &mut Text, options: &RapidOptions, used: Used) {
    call_off(text, options, used);
    if used.any() {
        text.word("  ERROR\n");
        call_off(text, options, used);
        text.word("    RAISE;\n");
    }
    text.word("  ENDPROC\n");
}

/// Calls the procedure that switches the outputs off, if there is one.
fn call_off(text: &mut Text, options: &RapidOptions, used: Used) {
    if used.any() {
        text.word("    ").word(&options.name).word("_off;\n");
    }
}

/// The procedure that switches off the outputs that the program uses, those of a tape head in reverse order.
fn write_off(text: &mut Text, options: &RapidOptions, used: Used) {
    text.word("  PROC ").word(&options.name).word("_off()\n");
    if used.filament {
        write_switch(text, &Step::FilamentSpeed(0.0), options);
    }
    if used.switch {
        write_switch(text, &Step::Extruder(false), options);
    }
    for signal in HeadSignal::ALL.into_iter().filter(|signal| used.head[signal.number()]).rev() {
        write_signal(text, signal, false);
    }
    text.word("  ENDPROC\n");
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
