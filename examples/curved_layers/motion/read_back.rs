//! The files of the programs, read again.

use super::args::ProgramFormat;
use super::planned::MotionRun;
use crate::args::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::programs::{pieces, program_name};
use curvlay_examples::motion::read_back::ReadBack;
use curvlay_kinematics::program::{CsvReader, ReadError, UrScriptReader, read_krl, read_rapid, read_tp};
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
            ProgramFormat::Urscript | ProgramFormat::UrscriptMovep => numbered("script"),
            ProgramFormat::Csv => numbered("csv"),
            ProgramFormat::Rapid => format!("{}.mod", program_name(pieces.len(), number)),
            ProgramFormat::Krl => format!("{}.src", program_name(pieces.len(), number)),
            ProgramFormat::Tp => format!("{}.ls", program_name(pieces.len(), number)),
            ProgramFormat::None => break,
        };
        let refused = |error: ReadError| failure(format!("{name}, as it was written: {error}"));
        let file = open(&name).map_err(|error| failure(format!("{name}: {error}")))?;
        let (print, runs) = ((&run.cell, &run.plan, home), piece.clone());
        match format {
            ProgramFormat::Urscript => found.add(print, runs, UrScriptReader::new(file).map_err(refused)?),
            ProgramFormat::UrscriptMovep => found.add_blended(print, runs, UrScriptReader::new(file).map_err(refused)?),
            ProgramFormat::Krl => {
                let data = name.replace(".src", ".dat");
                let data = open(&data).map_err(|error| failure(format!("{data}: {error}")))?;
                found.add(print, runs, read_krl(data, file, open).map_err(refused)?)
            }
            ProgramFormat::Tp => found.add(print, runs, read_tp(file, open).map_err(refused)?),
            ProgramFormat::Csv => found.add(print, runs, CsvReader::new(file).map_err(refused)?),
            ProgramFormat::Rapid | ProgramFormat::None => {
                found.add(print, runs, read_rapid(file, open).map_err(refused)?)
            }
        }
        .map_err(refused)?;
    }
    Ok(found)
}
