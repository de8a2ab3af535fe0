//! Which mutant is on, by the variable `MUTANT`; notes those that are reached in the file `MUTANTS_REACHED`.

use std::fs::OpenOptions;
use std::io::Write;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static ON: LazyLock<Option<u32>> = LazyLock::new(|| std::env::var("MUTANT").ok()?.parse().ok());
static FILE: LazyLock<Option<String>> = LazyLock::new(|| std::env::var("MUTANTS_REACHED").ok());
/// Mutants that have been noted; of more than these each time is.
static NOTED: [AtomicBool; 1 << 14] = [const { AtomicBool::new(false) }; 1 << 14];

pub(crate) fn switched(id: u32) -> bool {
    if let Some(file) = FILE.as_ref()
        && !NOTED.get(id as usize).is_some_and(|noted| noted.load(Relaxed) || noted.swap(true, Relaxed))
        && let Ok(mut file) = OpenOptions::new().append(true).open(file)
    {
        let _ = file.write_all(format!("{id}\n").as_bytes());
    }
    Some(id) == *ON
}
