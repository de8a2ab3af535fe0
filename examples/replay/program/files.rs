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
    /// Steps as CSV.
    Csv,
    /// G-code with the axes of a machine.
    Gcode,
}

/// A program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Files {
    /// Its format.
    pub kind: Kind,
    /// Its files, in the order in which they run; of RAPID the main module alone.
    pub paths: Vec<PathBuf>,
}

/// The format of a file, by its name.
fn kind(path: &Path) -> Option<Kind> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match extension.as_str() {
        "script" | "urscript" => Kind::UrScript,
        "mod" | "modx" | "prg" => Kind::Rapid,
        "csv" => Kind::Csv,
        "gcode" | "g" | "gco" | "nc" | "ngc" | "tap" => Kind::Gcode,
        _ => return None,
    })
}

/// The program in some files, or in a folder of `curved_layers`.
///
/// # Errors
/// A [`Failure`] that names the path and says what would do.
pub fn find(paths: &[PathBuf]) -> Result<Files, Failure> {
    if let [folder] = paths
        && folder.is_dir()
    {
        return in_folder(folder);
    }
    let mut kinds = Vec::new();
    for path in paths {
        let known = kind(path).ok_or_else(|| {
            fault(
                path,
                &"is no program by its name (known: .script, .mod, .csv, .gcode, .ngc, .nc, or a folder of them)",
            )
        })?;
        kinds.push(known);
    }
    let Some(&first) = kinds.first() else { return Err(Failure::of_arguments("there is no program to replay")) };
    if let Some(other) = kinds.iter().position(|kind| *kind != first) {
        return Err(fault(&paths[other], &"is of another format than the first file: replay one format at a time"));
    }
    if first == Kind::Rapid && paths.len() > 1 {
        return Err(fault(
            &paths[1],
            &"RAPID is replayed from its main module, which loads the others: name that alone",
        ));
    }
    Ok(Files { kind: first, paths: paths.to_vec() })
}

/// The robot program in a folder, or else its G-code.
fn in_folder(folder: &Path) -> Result<Files, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| fault(folder, &error))?;
    let mut all = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| fault(folder, &error))?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if let Some(kind) = kind(&path).filter(|_| path.is_file()) {
            all.push((name, kind, path));
        }
    }
    all.sort();
    let of = |wanted: Kind, fits: &dyn Fn(&str) -> bool| -> Vec<PathBuf> {
        let found = all.iter().filter(|(name, kind, _)| *kind == wanted && fits(name));
        found.map(|(_, _, path)| path.clone()).collect()
    };
    let choices = [
        (Kind::UrScript, of(Kind::UrScript, &|_| true)),
        (Kind::Rapid, of(Kind::Rapid, &|name| name == "print.mod")),
        (Kind::Csv, of(Kind::Csv, &|name| name.starts_with("print_"))),
    ];
    let robots: Vec<_> = choices.into_iter().filter(|(_, paths)| !paths.is_empty()).collect();
    if robots.len() > 1 {
        return Err(fault(folder, &"has robot programs in several formats: name the files of one"));
    }
    if let Some((kind, paths)) = robots.into_iter().next() {
        return Ok(Files { kind, paths });
    }
    let gcode = of(Kind::Gcode, &|name| name != "toolpath.gcode");
    match gcode.len() {
        0 => Err(fault(folder, &"has no program (print_001.script, print.mod, print_001.csv or toolpath-bc.gcode)")),
        1 => Ok(Files { kind: Kind::Gcode, paths: gcode }),
        _ => Err(fault(folder, &"has several files of G-code: name one")),
    }
}
