//! Every public function of a crate is fed any input by its tests (`tests/all/every_function`): what they feed is listed there in `fed.txt`, a function a
//! line, behind a bar why it may panic. A new function that is not listed fails here, and so does one that is listed and not called.
//!
//! Functions are those that a user can reach, read from the sources. Names that can be reached are what `lib.rs` and its public modules re-export
//! (`pub use`) or define, public modules within private ones among them. A public function counts if its own name is one of them, and one of an `impl` block if the name of the type is, unless the file
//! has a type of that name for itself (`pub(super)`, `pub(crate)`). Left out by this: what stands in private modules and is not re-exported, also where a
//! public function returns it, functions of traits, which the user writes or which are called by what takes the trait, and those behind macros.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The file without comments and unit tests.
fn code_of(file: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(file).unwrap();
    let code = text.split("\n#[cfg(test)]\nmod ").next().unwrap().lines();
    code.filter(|line| !line.trim_start().starts_with("//")).map(String::from).collect()
}

fn word(text: &str) -> &str {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap()
}

/// The word behind one of some beginnings.
fn after<'a>(line: &'a str, beginnings: &[&str]) -> Option<&'a str> {
    beginnings.iter().find_map(|beginning| line.strip_prefix(beginning)).map(word)
}

const DEFINITIONS: [&str; 6] = ["pub fn ", "pub const fn ", "pub struct ", "pub enum ", "pub trait ", "pub type "];

/// Adds the names that a public module and the public ones within it show.
fn exported(file: &Path, folder: &Path, names: &mut BTreeSet<String>) {
    let code = code_of(file);
    names.extend(code.iter().filter_map(|line| after(line, &DEFINITIONS)).map(String::from));
    for used in code.join("\n").split("\npub use ").skip(1) {
        let used = used.split(';').next().unwrap();
        assert!(!used.contains('*'), "{}: `pub use` of all names: write them out", file.display());
        let (from, list) = used.split_once('{').unwrap_or(("", used));
        for name in list.split([',', '{', '}']).map(|name| name.trim().split(" as ").next().unwrap()) {
            names.insert(name.rsplit("::").next().unwrap().to_string());
            let path = format!("{from}{name}");
            let (parent, module) = path.rsplit_once("::").unwrap_or(("", &path));
            let parent = folder.join(parent.replace("::", "/"));
            if parent != folder && public_modules(&parent.join("mod.rs")).iter().any(|public| public == module) {
                of_module(module, &parent, names);
            }
        }
    }
    for module in public_modules(file) {
        of_module(&module, folder, names);
    }
}

/// Adds the names that a module in a folder shows.
fn of_module(module: &str, folder: &Path, names: &mut BTreeSet<String>) {
    let inside = folder.join(module);
    let [alone, with_others] = [folder.join(format!("{module}.rs")), inside.join("mod.rs")];
    exported(if alone.exists() { &alone } else { &with_others }, &inside, names);
}

/// The modules that a file says are public; none where there is no file.
fn public_modules(file: &Path) -> Vec<String> {
    let code = if file.exists() { code_of(file) } else { Vec::new() };
    code.iter().filter_map(|line| after(line, &["pub mod "])).map(String::from).collect()
}

/// The type whose `impl` block begins in a line; empty for a trait's.
fn owner(line: &str) -> Option<&str> {
    let mut rest = line.strip_prefix("impl")?;
    if rest.starts_with('<') {
        let mut depth = 0;
        let end = rest.char_indices().find(|&(at, c)| {
            depth += i32::from(c == '<') - i32::from(c == '>' && !rest[..at].ends_with('-'));
            depth == 0
        });
        rest = &rest[end.map_or(0, |(at, _)| at + 1)..];
    }
    Some(if rest.contains(" for ") { "" } else { word(rest.trim_start()) })
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files(&path, found) } else { found.push(path) }
    }
}

/// Each function that a user can reach, as `file name` or `file Type::name`.
fn reachable(root: &Path) -> BTreeSet<String> {
    let (mut names, mut all, mut found) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
    exported(&root.join("lib.rs"), root, &mut names);
    files(root, &mut all);
    for path in all {
        let code = code_of(&path);
        let hidden: BTreeSet<&str> = code.iter().filter_map(|line| hidden(line)).collect();
        let file = path.strip_prefix(root).unwrap().display().to_string().replace('\\', "/");
        let mut of = "";
        for line in &code {
            of = owner(line).unwrap_or(of);
            let Some(name) = after(line.trim_start(), &["pub fn ", "pub const fn "]) else { continue };
            if line.starts_with("pub") {
                if names.contains(name) {
                    found.insert(format!("{file} {name}"));
                }
            } else if names.contains(of) && !hidden.contains(of) {
                found.insert(format!("{file} {of}::{name}"));
            }
        }
    }
    found
}

/// A type for the file or the crate itself that a line defines.
fn hidden(line: &str) -> Option<&str> {
    let rest = ["pub(super) ", "pub(crate) ", ""].iter().find_map(|seen| line.strip_prefix(seen))?;
    after(rest, &["struct ", "enum "])
}

fn each_is_fed(name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name);
    let (root, tests) = (folder.join("src"), folder.join("tests/all/every_function"));
    let list = std::fs::read_to_string(tests.join("fed.txt")).unwrap();
    let fed: Vec<(&str, Option<&str>)> = list
        .lines()
        .map(|line| line.split_once(" | ").map_or((line, None), |(entry, why)| (entry, Some(why))))
        .collect();
    let names: BTreeSet<String> = fed.iter().map(|(entry, _)| entry.to_string()).collect();
    assert_eq!(
        names,
        reachable(&root),
        "{name}: feed new functions in tests/all/every_function and name them in its fed.txt"
    );
    let mut sources = Vec::new();
    files(&tests, &mut sources);
    sources.retain(|file| file.extension().is_some_and(|extension| extension == "rs"));
    let text: String = sources.iter().map(|file| std::fs::read_to_string(file).unwrap()).collect();
    for (entry, panics) in fed {
        let function = entry.rsplit([' ', ':']).next().unwrap();
        let calls = [format!("{function}("), format!("{function}::<"), format!("::{function})")];
        assert!(calls.iter().any(|call| text.contains(call)), "{name}: {entry} is named but not called");
        if panics.is_some() {
            let source = std::fs::read_to_string(root.join(entry.split(' ').next().unwrap())).unwrap();
            let before = source.split(&format!("pub fn {function}(")).next().unwrap();
            let docs = before.lines().rev().map(str::trim).skip(1).take_while(|line| line.starts_with("///"));
            assert!(docs.into_iter().any(|line| line == "/// # Panics"), "{name}: {entry} does not say when it panics");
        }
    }
}

#[test]
fn functions_of_layers_are_fed() {
    each_is_fed("layers");
}

#[test]
fn functions_of_trajectory_are_fed() {
    each_is_fed("trajectory");
}

#[test]
fn functions_of_toolpath_are_fed() {
    each_is_fed("toolpath");
}

#[test]
fn functions_of_kinematics_are_fed() {
    each_is_fed("kinematics");
}
