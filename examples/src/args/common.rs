//! What all commands take.

use crate::input::Inputs;
use crate::output::{OutputError, OutputFolder};
use clap::Args;
use std::path::{Path, PathBuf};
use std::thread;

/// What all examples take.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Run")]
pub struct Common {
    /// Folder for the results [default: target/out/ and the name of the example]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of threads; the results do not depend on it
    #[arg(long, value_name = "N", default_value_t = cores(), value_parser = threads, allow_negative_numbers = true)]
    pub threads: usize,
    /// No progress bars
    #[arg(long, short)]
    pub quiet: bool,
}

impl Common {
    /// Opens the output folder: the one asked for, or `target/out/NAME`. To be done before the work. `inputs` are the files that the run
    /// reads, and `is_ours` says which names it writes.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written, or when an input has the name of a file that the run writes there.
    pub fn folder<'a>(
        &self,
        name: &str,
        inputs: impl IntoIterator<Item = Option<&'a Path>>,
        is_ours: impl Fn(&str) -> bool,
    ) -> Result<OutputFolder, OutputError> {
        let default = || Path::new("target").join("out").join(name);
        let inputs = Inputs::new(inputs.into_iter().flatten());
        OutputFolder::create(&self.out.clone().unwrap_or_else(default))?.guarding(inputs, is_ours)
    }
}

/// Maximum number of threads: more only cost memory, and a typing error must not start a million.
const MAX_THREADS: usize = 1024;

fn cores() -> usize {
    thread::available_parallelism().map_or(1, |n| n.get().min(MAX_THREADS))
}

fn threads(text: &str) -> Result<usize, String> {
    let n: usize = text.parse().map_err(|_| "not an integer".to_owned())?;
    if (1..=MAX_THREADS).contains(&n) { Ok(n) } else { Err(format!("must be from 1 to {MAX_THREADS}")) }
}
