//! One target for all entries, since a build costs minutes: `CURVLAY_FUZZ` names the entry, so inputs are plain files of its format.
//! `docs/testing.md` says how to run it.
#![no_main]

mod geometry;
mod memory;
mod programs;
mod readers;
mod replay;
mod seeds;

use std::sync::OnceLock;

#[global_allocator]
static ALLOCATOR: memory::Limited = memory::Limited;

/// What takes an input.
type Entry = (&'static str, fn(&[u8]));

fn entry() -> fn(&[u8]) {
    static ENTRY: OnceLock<fn(&[u8])> = OnceLock::new();
    *ENTRY.get_or_init(|| {
        let all = [readers::ENTRIES, programs::ENTRIES, geometry::ENTRIES].concat();
        let name = std::env::var("CURVLAY_FUZZ").unwrap_or_default();
        if name == "seeds" {
            let code = seeds::write().map_err(|error| eprintln!("{error}")).is_err();
            std::process::exit(code.into());
        }
        let known = all.iter().find(|(known, _)| *known == name);
        known.map(|(_, entry)| *entry).unwrap_or_else(|| {
            let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
            eprintln!("CURVLAY_FUZZ must be one of: {}", names.join(" "));
            std::process::exit(2);
        })
    })
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| entry()(data));
