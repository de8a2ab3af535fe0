//! Which files a program consists of.

use curvlay_examples::args::Failure;
use curvlay_examples::waypoints::fault;
use std::path::{Path, PathBuf};

/// The format of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// URScript: files that run one after the other.
    UrScript,
    /// RAPID: a main module, which loads the others.
    Rapid,
    /// KRL: a main module with its data list, which calls the others.
    Krl,
    /// TP as ASCII: a main program, which calls the others.
    Tp,
    /// Steps as CSV.
    Csv,
    /// G-code with the axes of a machine.
    Gcode,
}

impl Kind {
    /// What a report calls it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::UrScript => "URScript",
            Kind::Rapid => "RAPID",
            Kind::Krl => "KRL",
            Kind::Tp => "TP",
            Kind::Csv => "CSV",
            Kind::Gcode => "G-code",
        }
    }

    /// Whether its main file opens others.
    fn has_parts(self) -> bool {
        matches!(self, Kind::Rapid | Kind::Krl | Kind::Tp)
    }
}

/// Which program of a folder is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// That of the robot, or else that of the printer.
    Any,
    /// G-code with the axes of a machine.
    Axes,
    /// G-code with directions.
    Vectors,
}

/// A program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Files {
    /// Its format.
    pub kind: Kind,
    /// Its files, in the order in which they run; of RAPID, KRL and TP the main ones alone.
    pub paths: Vec<PathBuf>,
    /// Other programs in the folder, which are not replayed.
    pub others: Vec<String>,
}

/// G-code in the part, and with axes, as `curved_layers` names them.
pub const PART: &str = "toolpath.gcode";
pub const AXES: &str = "toolpath-axes.gcode";

/// The format of a file, by its name.
fn kind(path: &Path) -> Option<Kind> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match extension.as_str() {
        "script" | "urscript" => Kind::UrScript,
        "mod" | "modx" | "prg" => Kind::Rapid,
        "src" => Kind::Krl,
        "ls" => Kind::Tp,
        "csv" => Kind::Csv,
        "gcode" | "g" | "gco" | "nc" | "ngc" | "tap" => Kind::Gcode,
        _ => return None,
    })
}

/// The program in some files, or in a folder of `curved_layers`.
///
/// # Errors
/// A [`Failure`] that names the path and says what would do.
pub fn find(paths: &[PathBuf], wanted: Wanted) -> Result<Files, Failure> {
    if let [folder] = paths
        && folder.is_dir()
    {
        return in_folder(folder, wanted);
    }
    let mut kinds = Vec::new();
    for path in paths {
        let known = kind(path).ok_or_else(|| {
            fault(
                path,
                &"is no program by its name (known: .script, .mod, .src, .ls, .csv, .gcode, .ngc, .nc, or a folder of them)",
            )
        })?;
        kinds.push(known);
    }
    let Some(&first) = kinds.first() else { return Err(Failure::of_arguments("there is no program to replay")) };
    if let Some(other) = kinds.iter().position(|kind| *kind != first) {
        return Err(fault(&paths[other], &"is of another format than the first file: replay one format at a time"));
    }
    let is_part = |path: &&PathBuf| {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        stem.rsplit_once('_').is_some_and(|(_, end)| end.len() == 3 && end.bytes().all(|byte| byte.is_ascii_digit()))
    };
    if let Some(part) = paths.iter().skip(1).find(is_part).filter(|_| first.has_parts()) {
        let what = format!("{} is replayed from its main file, which opens the others: name that alone", first.name());
        return Err(fault(part, &what));
    }
    Ok(Files { kind: first, paths: paths.to_vec(), others: Vec::new() })
}

/// A program of a folder, by its name.
type Found = (String, Kind, PathBuf);

/// The number of a main file: 0 for `print.mod`, 2 for `print2.mod`.
fn number_of_main(name: &str) -> Option<u32> {
    let rest = name.split_once('.')?.0.strip_prefix("print")?;
    if rest.is_empty() { Some(0) } else { rest.parse().ok() }
}

/// Whether a file of a folder begins a program, and its place among them.
fn begins((name, kind, _): &Found) -> Option<u32> {
    match kind {
        Kind::UrScript => Some(0),
        Kind::Rapid | Kind::Krl | Kind::Tp => number_of_main(name),
        Kind::Csv => name.starts_with("print_").then_some(0),
        Kind::Gcode => None,
    }
}

/// The robot program in a folder, or else its G-code; G-code where that is wanted.
fn in_folder(folder: &Path, wanted: Wanted) -> Result<Files, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| fault(folder, &error))?;
    let mut all: Vec<Found> = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| fault(folder, &error))?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if let Some(kind) = kind(&path).filter(|_| path.is_file()) {
            all.push((name, kind, path));
        }
    }
    all.sort();
    let mut mains: Vec<(u32, Found)> =
        all.iter().filter_map(|file| begins(file).map(|number| (number, file.clone()))).collect();
    mains.sort_by_key(|(number, _)| *number);
    let gcode: Vec<&Found> = all.iter().filter(|(_, kind, _)| *kind == Kind::Gcode).collect();
    let chosen: Vec<Found> = match wanted {
        Wanted::Any if !mains.is_empty() => mains.iter().map(|(_, file)| file.clone()).collect(),
        _ => vec![one_of_gcode(folder, &gcode, wanted)?.clone()],
    };
    let kind = chosen[0].1;
    if chosen.iter().any(|(_, other, _)| *other != kind) {
        return Err(fault(folder, &"has robot programs in several formats: name the files of one"));
    }
    let is_left = |file: &&Found| !chosen.contains(file) && file.0 != PART;
    let others = mains.iter().map(|(_, file)| file).chain(gcode.iter().copied()).filter(is_left);
    let others = others.map(|(name, _, _)| name.clone()).collect();
    Ok(Files { kind, paths: chosen.into_iter().map(|(_, _, path)| path).collect(), others })
}

/// The file of G-code that is meant.
fn one_of_gcode<'f>(folder: &Path, all: &[&'f Found], wanted: Wanted) -> Result<&'f Found, Failure> {
    let named = |wanted: &str| all.iter().copied().find(|(name, _, _)| name == wanted);
    match wanted {
        Wanted::Vectors => {
            return named(PART).ok_or_else(|| fault(folder, &format!("has no {PART}, which the flavour writes")));
        }
        Wanted::Axes => {
            if let Some(file) = named(AXES) {
                return Ok(file);
            }
        }
        Wanted::Any => {}
    }
    let others: Vec<&Found> = all.iter().copied().filter(|(name, _, _)| name != PART).collect();
    // Without the file of its machine that of the table is left.
    let of_table: Vec<&Found> = others.iter().copied().filter(|(name, _, _)| name != AXES).collect();
    let others = if wanted == Wanted::Any && !of_table.is_empty() { of_table } else { others };
    match others.as_slice() {
        [] => Err(fault(
            folder,
            &"has no program (print_001.script, print.mod, print.src, print.ls, print_001.csv or toolpath-axes.gcode)",
        )),
        [file] => Ok(file),
        _ => Err(fault(folder, &"has several files of G-code: name one")),
    }
}
