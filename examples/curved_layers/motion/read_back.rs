//! The files of the programs, read again.

use super::args::ProgramFormat;
use super::planned::MotionRun;
use crate::args::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::programs::pieces;
use curvlay_examples::motion::read_back::ReadBack;
use curvlay_kinematics::program::{CsvReader, ReadError, UrScriptReader, read_rapid};
use curvlay_kinematics::workcell::Workcell;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// Reads all programs of a print from their folder; none without a home posture.
///
/// # Errors
/// A file that cannot be read, or that the reader of its language refuses, with its line.
pub fn read_back<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    format: ProgramFormat,
    folder: &Path,
) -> Result<ReadBack, Failure> {
    let mut found = ReadBack::default();
    let Some(home) = &run.home else { return Ok(found) };
    let pieces = pieces(&run.plan);
    let open = |name: &str| -> io::Result<BufReader<File>> { Ok(BufReader::new(File::open(folder.join(name))?)) };
    for (number, piece) in pieces.iter().enumerate() {
        let numbered = |ending: &str| format!("print_{:03}.{ending}", number + 1);
        let name = match format {
            ProgramFormat::Urscript => numbered("script"),
            ProgramFormat::Csv => numbered("csv"),
            ProgramFormat::Rapid if pieces.len() == 1 => "print.mod".to_owned(),
            ProgramFormat::Rapid => format!("print{}.mod", number + 1),
            ProgramFormat::None => break,
        };
        let refused = |error: ReadError| failure(format!("{name}, as it was written: {error}"));
        let file = open(&name).map_err(|error| failure(format!("{name}: {error}")))?;
        let (print, runs) = ((&run.cell, &run.plan, home), piece.clone());
        match format {
            ProgramFormat::Urscript => found.add(print, runs, UrScriptReader::new(file).map_err(refused)?),
            ProgramFormat::Csv => found.add(print, runs, CsvReader::new(file).map_err(refused)?),
            ProgramFormat::Rapid | ProgramFormat::None => {
                found.add(print, runs, read_rapid(file, open).map_err(refused)?)
            }
        }
        .map_err(refused)?;
    }
    Ok(found)
}
