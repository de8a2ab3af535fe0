//! Mutants as switches: all changes of some files at once, in one build.
//!
//! `curvlay-mutants CRATE FILE...` rewrites files of the crate in place: each expression that has mutants becomes `(if switched(K) { mutant } else { itself })`,
//! and each function that has them returns a value at its start. `src/mutant_switch.rs`, which it adds, says which one is on (`MUTANT=K`), and notes those that a test reaches
//! (`MUTANTS_REACHED=FILE`). The list goes to `mutants.json` in the crate; `without.json` there has the numbers of those that stay out, since they do not compile or are not asked for. `run.py` does all of it.
//!
//! Changed are operators, negations and guards, as by `cargo mutants`, and what functions return; not constants, `const fn`, macros, and tests.

mod weave;

use serde_json::json;
use std::path::{Path, PathBuf};
use weave::{Mutant, woven};

const SWITCH: &str = include_str!("switch.rs");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().ok_or("usage: curvlay-mutants CRATE FILE...")?);
    let without: Vec<u64> = match std::fs::read_to_string(folder.join("without.json")) {
        Ok(text) => serde_json::from_str(&text)?,
        Err(_) => Vec::new(),
    };
    let (mut next, mut mutants): (u64, Vec<Mutant>) = (0, Vec::new());
    for file in args {
        let path = folder.join(&file);
        let text = std::fs::read_to_string(&path)?;
        std::fs::write(&path, woven(&text, &file, &without, &mut next, &mut mutants)?)?;
    }
    add_switch(&folder)?;
    let list: Vec<_> = mutants
        .iter()
        .map(|m| json!({"id": m.id, "file": m.file, "line": m.line, "column": m.column, "in": m.function, "what": m.what}))
        .collect();
    std::fs::write(folder.join("mutants.json"), serde_json::to_string_pretty(&list)?)?;
    println!("{} mutants", mutants.len());
    Ok(())
}

fn add_switch(folder: &Path) -> std::io::Result<()> {
    std::fs::write(folder.join("src/mutant_switch.rs"), SWITCH)?;
    let root = folder.join("src/lib.rs");
    let text = std::fs::read_to_string(&root)?;
    std::fs::write(root, format!("{text}\nmod mutant_switch;\n"))
}
