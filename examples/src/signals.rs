//! What is left when a run is stopped from outside: one line, no file that was begun, and the exit status of the shell's convention.
//!
//! Files under a temporary name are listed here while they are written (`begin`, `end`). On SIGINT (Ctrl-C) and SIGTERM a thread
//! removes them and ends the process with 128 and the number of the signal: 130 and 143. Elsewhere than on Unix the system ends
//! the process, and such files stay.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files that were begun and are not finished. The list belongs to the process, as signals do.
static BEGUN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn begun() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a file and lists it in one step, so that no signal comes between the two.
pub(crate) fn begin<T>(path: &Path, make: impl FnOnce() -> T) -> T {
    let mut files = begun();
    files.insert(path.to_owned());
    make()
}

/// Renames or removes a listed file and takes it off the list.
pub(crate) fn end<T>(path: &Path, finish: impl FnOnce() -> T) -> T {
    let mut files = begun();
    files.remove(path);
    finish()
}

/// Makes and removes a file in one step, so that no signal comes between the two.
pub(crate) fn briefly<T>(make_and_remove: impl FnOnce() -> T) -> T {
    let _held = begun();
    make_and_remove()
}

/// Whether the first signal is left to the program, and whether one has come.
static LEFT: AtomicBool = AtomicBool::new(false);
static CAME: AtomicBool = AtomicBool::new(false);

/// Leaves the first signal to the program from now on: it asks [`came`] and comes to an end by itself. The second signal ends the process.
pub fn leave() {
    LEFT.store(true, Ordering::SeqCst);
}

/// Whether a signal has come that was left to the program.
pub fn came() -> bool {
    CAME.load(Ordering::SeqCst)
}

/// Handles signals from now on; the second call does nothing. Where no handler can be set, the system's stays.
#[cfg(unix)]
pub fn handle() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use std::sync::Once;
    use std::{fs, process, thread};

    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
        thread::spawn(move || {
            let mut signals = signals.forever();
            let Some(mut signal) = signals.next() else { return };
            if LEFT.load(Ordering::SeqCst) {
                CAME.store(true, Ordering::SeqCst);
                let Some(second) = signals.next() else { return };
                signal = second;
            }
            // Held to the end: nothing new is begun.
            let files = begun();
            for file in files.iter() {
                let _ = fs::remove_file(file);
            }
            let name = if signal == SIGINT { "SIGINT" } else { "SIGTERM" };
            crate::terminal::say(&format!("stopped by {name}; files that were not finished are removed"));
            process::exit(128 + signal);
        });
    });
}

/// Handles signals from now on: not on this system.
#[cfg(not(unix))]
pub fn handle() {}
