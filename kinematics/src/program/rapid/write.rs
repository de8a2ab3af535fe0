//! RAPID, written.

use super::{DEGREES, FILAMENT, MM, NAMED_TURN_RAD_S, QUATERNION, RapidOptions, SPEEDS, TOOL0, WOBJ0, ZONES};
use crate::program::check::{Checker, check_frame, check_name, check_option, farthest};
use crate::program::text::Text;
use crate::program::{Goal, Move, Speed, Step, Target, WriteError, Zone};
use nalgebra::Isometry3;
use std::io::Write;

/// What [`write_rapid`] has written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RapidWritten {
    /// Part modules.
    pub modules: u32,
    /// Moves in them.
    pub moves: u64,
    /// Moves that were to be blended, but stop because a module ends there.
    pub stops_added: u32,
}

/// Longest name of a module, less `_` and seven digits.
const LONGEST_NAME: usize = 24;
/// Longest name in RAPID.
const LONGEST_WORD: usize = 32;
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
    let mut checker = Checker::new(&options.limits);
    let mut written = RapidWritten { modules: 0, moves: 0, stops_added: 0 };
    let end = format!(",{}\\WObj:={};\n", options.tool.name, options.work_object.name);
    let mut module: Option<Module<W>> = None;
    // By the digital output; by the speed of the filament where there is none.
    let (mut on, mut fed) = (None, false);
    let mut steps = steps.into_iter().peekable();
    while let Some(mut step) = steps.next() {
        checker.check(&step)?;
        let current = match &mut module {
            Some(current) => current,
            None => {
                written.modules += 1;
                module.insert(Module::begin(&part_name(options, written.modules), &mut open)?)
            }
        };
        let mut at_rest = false;
        match &mut step {
            Step::Move(to) => {
                current.moves += 1;
                written.moves += 1;
                let last = current.moves >= options.moves_per_module || steps.peek().is_none();
                if last && to.zone != Zone::Stop {
                    to.zone = Zone::Stop;
                    written.stops_added += 1;
                }
                at_rest = to.zone == Zone::Stop;
                write_move(&mut current.text, to, &end);
            }
            Step::Extruder(to) => {
                on = Some(*to);
                let value = if *to { "1" } else { "0" };
                current.text.word("    SetDO ").word(&options.signal).word(",").word(value).word(";\n");
            }
            Step::FilamentSpeed(mm_s) => {
                fed = *mm_s > 0.0;
                current.text.word("    SetAO ").word(&options.filament_signal).word(",").fixed(*mm_s, FILAMENT);
                current.text.word(";\n");
            }
            Step::Servo { .. } => return Err(checker.unsupported("stream of joints", "RAPID")),
        }
        let most = options.moves_per_module;
        // Not over the begin of a stroke: there the nozzle would wait on the part.
        let signal_next = matches!(steps.peek(), Some(Step::Extruder(_) | Step::FilamentSpeed(_)));
        let idle = at_rest && !on.unwrap_or(fed) && !signal_next;
        let early = current.moves > most - most / 4 && idle;
        if current.text.0.len() > CHUNK {
            current.send()?;
        }
        if current.moves >= most || early {
            module.take().map_or(Ok(()), Module::end)?;
        }
    }
    module.take().map_or(Ok(()), Module::end)?;
    checker.finish()?;
    write_main(options, written.modules, &mut open)?;
    Ok(written)
}

fn check_options(options: &RapidOptions) -> Result<(), WriteError> {
    check_name("name of the program", &options.name, LONGEST_NAME)?;
    check_name("name of the tool", &options.tool.name, LONGEST_WORD)?;
    check_name("name of the work object", &options.work_object.name, LONGEST_WORD)?;
    check_name("name of the signal", &options.signal, LONGEST_WORD)?;
    check_name("name of the filament signal", &options.filament_signal, LONGEST_WORD)?;
    if let Some(unit) = &options.work_object.unit {
        check_name("name of the mechanical unit", unit, LONGEST_WORD)?;
    }
    // A folder such as `HOME:` or `HOME:/parts`.
    let folder: String = options.folder.chars().filter(|c| !matches!(c, ':' | '/' | '-' | '.')).collect();
    check_name("folder", &folder, LONGEST_WORD)?;
    check_frame("tool.frame", &options.tool.frame)?;
    check_frame("work_object.frame", &options.work_object.frame)?;
    let mass = options.tool.mass_kg;
    check_option("tool.mass_kg", mass, mass > 0.0 && mass < 1e5, "it must be above 0")?;
    let far = farthest(&options.tool.centre.coords);
    check_option("tool.centre", far, far <= 1e5, "it must be finite and within 1e5 mm")?;
    let most = options.moves_per_module;
    check_option("moves_per_module", f64::from(most), most >= 1, "it must be 1 or more")
}

fn part_name(options: &RapidOptions, number: u32) -> String {
    format!("{}_{number:03}", options.name)
}

/// A part module that is being written.
struct Module<W> {
    file: String,
    out: W,
    text: Text,
    moves: u32,
}

impl<W: Write> Module<W> {
    fn begin(name: &str, open: &mut impl FnMut(&str) -> std::io::Result<W>) -> Result<Self, WriteError> {
        let file = format!("{name}.mod");
        let out = open(&file).map_err(|source| WriteError::Io { file: file.clone(), source })?;
        let mut text = Text::default();
        text.word("MODULE ").word(name).word("\n  PROC ").word(name).word("()\n");
        Ok(Module { file, out, text, moves: 0 })
    }

    fn send(&mut self) -> Result<(), WriteError> {
        let sent = self.out.write_all(&self.text.0);
        self.text.0.clear();
        sent.map_err(|source| WriteError::Io { file: self.file.clone(), source })
    }

    fn end(mut self) -> Result<(), WriteError> {
        self.text.word("  ENDPROC\nENDMODULE\n");
        self.send()?;
        self.out.flush().map_err(|source| WriteError::Io { file: self.file, source })
    }
}

fn write_move(text: &mut Text, to: &Move, end: &str) {
    match &to.goal {
        Goal::Line(target) => write_target(text.word("    MoveL "), target, to.table),
        Goal::Swing(target) => write_target(text.word("    MoveJ "), target, to.table),
        Goal::Joints(joints) => {
            text.word("    MoveAbsJ [").list(&joints.map(f64::to_degrees), DEGREES);
            write_table(text, to.table);
        }
    }
    text.word(",");
    write_speed(text, to.speed);
    text.word(",");
    write_zone(text, to.zone);
    text.word(end);
}

fn write_target(text: &mut Text, target: &Target, table: Option<[f64; 2]>) {
    write_pose(text, &target.pose);
    let conf = target.conf;
    let conf = [conf.cf1, conf.cf4, conf.cf6, conf.cfx].map(f64::from);
    text.word(",").list(&conf, 0);
    write_table(text, table);
}

/// `[[x,y,z],[q1,q2,q3,q4]`, without the bracket at the end.
fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
    let (at, q) = (pose.translation.vector, pose.rotation);
    text.word("[").list(&[at.x, at.y, at.z], MM).word(",").list(&[q.w, q.i, q.j, q.k], QUATERNION);
}

/// The external axes and the end of the target.
fn write_table(text: &mut Text, table: Option<[f64; 2]>) {
    match table {
        Some([tilt, turn]) => {
            text.word(",[").fixed(tilt.to_degrees(), DEGREES).word(",").fixed(turn.to_degrees(), DEGREES);
            text.word(",9E9,9E9,9E9,9E9]]");
        }
        None => _ = text.word(",[9E9,9E9,9E9,9E9,9E9,9E9]]"),
    }
}

fn write_speed(text: &mut Text, speed: Speed) {
    // Named speeds are whole; bits are compared, for a name must mean the same.
    let named = SPEEDS.iter().find(|&&named| f64::from(named).to_bits() == speed.mm_s.to_bits());
    match named {
        Some(&named) if speed.rad_s.to_bits() == NAMED_TURN_RAD_S.to_bits() => {
            text.word("v").fixed(f64::from(named), 0);
        }
        _ => {
            text.word("[").fixed(speed.mm_s, MM).word(",").fixed(speed.rad_s.to_degrees(), DEGREES);
            text.word(",5000,1000]");
        }
    }
}

fn write_zone(text: &mut Text, zone: Zone) {
    let Zone::Blend(radius) = zone else {
        text.word("fine");
        return;
    };
    match ZONES.iter().find(|(_, [named, ..])| named.to_bits() == radius.to_bits()) {
        Some((name, _)) => _ = text.word(name),
        // In the proportions of the named ones.
        None => {
            text.word("[FALSE");
            for share in [1.0, 1.5, 1.5, 0.15, 1.5, 0.15] {
                text.word(",").fixed(share * radius, MM);
            }
            text.word("]");
        }
    }
}

fn write_main<W: Write>(
    options: &RapidOptions,
    modules: u32,
    open: &mut impl FnMut(&str) -> std::io::Result<W>,
) -> Result<(), WriteError> {
    let file = format!("{}.mod", options.name);
    let failed = |source| WriteError::Io { file: file.clone(), source };
    let mut out = open(&file).map_err(failed)?;
    let mut text = Text::default();
    let truth = |value: bool| if value { "TRUE" } else { "FALSE" };
    text.word("MODULE ").word(&options.name).word("\n");
    let (tool, work) = (&options.tool, &options.work_object);
    if tool.name != TOOL0 {
        text.word("  PERS tooldata ").word(&tool.name).word(":=[").word(truth(tool.in_hand)).word(",");
        write_pose(&mut text, &tool.frame);
        text.word("],[").fixed(tool.mass_kg, MM).word(",").list(tool.centre.coords.as_slice(), MM);
        text.word(",[1,0,0,0],0,0,0]];\n");
    }
    if work.name != WOBJ0 {
        text.word("  PERS wobjdata ").word(&work.name).word(":=[").word(truth(work.in_hand));
        if let Some(unit) = &work.unit {
            text.word(",FALSE,\"").word(unit).word("\",[[0,0,0],[1,0,0,0]],");
            write_pose(&mut text, &work.frame);
            text.word("]];\n");
        } else {
            text.word(",TRUE,\"\",");
            write_pose(&mut text, &work.frame);
            text.word("],[[0,0,0],[1,0,0,0]]];\n");
        }
    }
    text.word("  PROC main()\n    ConfJ\\On;\n    ConfL\\On;\n");
    for number in 1..=modules {
        let name = part_name(options, number);
        let place = format!("\"{}\"\\File:=\"{name}.mod\";\n", options.folder);
        text.word("    Load\\Dynamic,").word(&place);
        text.word("    %\"").word(&name).word("\"%;\n");
        text.word("    UnLoad ").word(&place);
        if text.0.len() > CHUNK {
            out.write_all(&text.0).map_err(failed)?;
            text.0.clear();
        }
    }
    text.word("  ENDPROC\nENDMODULE\n");
    out.write_all(&text.0).and_then(|()| out.flush()).map_err(failed)
}
