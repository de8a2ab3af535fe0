//! Which files are layers, and in which order: by the last number in their names, as a number.

use super::super::args::Args;
use curvlay_examples::args::{Failure, printable};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Endings of files that are read as layers.
const MESHES: [&str; 3] = ["obj", "stl", "ply"];
/// Names of another form are passed over if they are so many times rarer than the commonest form: a part that lies beside its layers.
const RARE: usize = 10;

/// What a name says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// The layer.
    pub number: Option<u32>,
    /// Whether it is support.
    pub is_support: bool,
    /// What is before and behind the number.
    form: [String; 2],
}

/// Files of layers.
pub struct Files {
    /// Each with what its name says.
    pub files: Vec<(PathBuf, Named)>,
    /// Meshes that were passed over.
    pub passed_over: Vec<String>,
}

/// What the name of a file, a group or an object says. Support is called so, or has an S behind its number, as S3-Slicer writes it.
pub fn named(name: &str) -> Named {
    let is_digit = |c: char| c.is_ascii_digit();
    let end = name.rfind(is_digit).map_or(0, |at| at + 1);
    let first =
        name[..end].rfind(|c| !is_digit(c)).map_or(0, |at| at + name[at..].chars().next().map_or(1, char::len_utf8));
    let form = if end == 0 { [name, ""] } else { [&name[..first], &name[end..]] };
    let is_support = name.to_ascii_lowercase().contains("support") || (end > 0 && form[1].eq_ignore_ascii_case("s"));
    Named { number: name[first.min(end)..end].parse().ok(), is_support, form: form.map(str::to_owned) }
}

/// Whether a file is a mesh, by its ending.
pub fn is_mesh(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
    MESHES.contains(&ending.as_str())
}

/// Whether a folder has files that could be layers.
pub fn has_layers(folder: &Path) -> bool {
    in_folder(folder).is_ok_and(|files| files.iter().any(|path| of_file(path).number.is_some()))
}

fn of_file(path: &Path) -> Named {
    named(&path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()))
}

/// Meshes of a folder, by name.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error| Failure::new(format!("{}: cannot be read: {error}", folder.display()));
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if is_mesh(&path) && path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// The files of the input.
///
/// # Errors
/// A folder that cannot be read or whose names have no numbers; a folder beside other files; a layer in two files.
pub fn of(args: &Args) -> Result<Files, Failure> {
    let input = &args.input;
    if !input.is_dir() {
        let all = std::iter::once(input).chain(&args.more).map(|path| (path.clone(), of_file(path))).collect();
        return once(Files { files: all, passed_over: Vec::new() });
    }
    if !args.more.is_empty() {
        return Err(Failure::of_arguments(format!(
            "{}: a folder, and further files beside it: give one folder, or files",
            input.display()
        )));
    }
    let all: Vec<(PathBuf, Named)> = in_folder(input)?.into_iter().map(|path| (path.clone(), of_file(&path))).collect();
    let mut forms: BTreeMap<[String; 2], usize> = BTreeMap::new();
    for (_, named) in all.iter().filter(|(_, named)| named.number.is_some()) {
        *forms.entry(named.form.clone()).or_default() += 1;
    }
    let commonest = forms.values().copied().max().unwrap_or(0);
    let is_layer = |named: &Named| {
        named.number.is_some() && (named.is_support || RARE * forms.get(&named.form).copied().unwrap_or(0) >= commonest)
    };
    let (files, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, named)| is_layer(named));
    let name = |path: &Path| printable(&path.file_name().unwrap_or_default().to_string_lossy());
    once(Files { files, passed_over: others.iter().map(|(path, _)| name(path)).collect() })
}

/// The files, unless two of them differ by their ending only.
fn once(files: Files) -> Result<Files, Failure> {
    let mut known: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    for (path, _) in &files.files {
        if let Some(other) = known.insert(path.with_extension(""), path) {
            let (one, two) = (other.display(), path.display());
            return Err(Failure::new(format!("{one} and {two}: the same layer twice? leave one of them out")));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_number_of_a_name_is_the_layer() {
        let known = [
            ("layer_2", Some(2), false),
            ("layer_010", Some(10), false),
            ("12S", Some(12), true),
            ("bunny2_layer7_top", Some(7), false),
            ("support_3", Some(3), true),
            ("Schicht-ä9", Some(9), false),
            ("part", None, false),
            ("", None, false),
            ("99999999999999", None, false),
        ];
        for (name, number, is_support) in known {
            let found = named(name);
            assert_eq!((found.number, found.is_support), (number, is_support), "{name}");
        }
    }
}
