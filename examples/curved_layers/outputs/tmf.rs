//! `build.3mf`: the part and what the nozzle does, in one package.

use crate::args::{Extra, failure};
use crate::field::FieldRun;
use crate::job::Job;
use crate::machine::MachineRun;
use curvlay_examples::args::Failure;
use curvlay_examples::build3mf::{BuildOptions, segments, write_build};
use curvlay_examples::mesh::Mesh;
use std::io::{self, BufWriter};

/// With travels.
pub const FILE: &str = "build.3mf";
/// Without.
pub const BEADS_FILE: &str = "beads.build.3mf";

/// Writes the packages that are asked for.
pub fn products(job: &Job, field: &FieldRun, run: &MachineRun) -> Result<(), Failure> {
    for (name, extra, travels) in [(FILE, Extra::Tmf, true), (BEADS_FILE, Extra::TmfBeads, false)] {
        if job.args.writes(extra) {
            write(job, field, run, name, travels)?;
        } else {
            // One of an earlier stage or run goes away.
            job.folder.write_list(name, false, |_| Ok(()))?;
        }
    }
    Ok(())
}

fn write(job: &Job, field: &FieldRun, run: &MachineRun, name: &str, travels: bool) -> Result<(), Failure> {
    let Mesh { vertices, triangles } = &job.part.mesh;
    let vertices = vertices.iter().map(|vertex| vertex + field.solid.shift).collect();
    let mesh = Mesh { vertices, triangles: triangles.clone() };
    let path = job.folder.path().join(name);
    let failed = |error: io::Error| failure(format!("{}: cannot be written: {error}", path.display()));
    let (unfinished, file) = job.folder.begin(name).map_err(failed)?;
    let segments = segments(&run.deposition.moves, &run.resolved.paths).map_err(failure)?;
    let options = BuildOptions { name: &job.part.name, travels };
    write_build(&mesh, segments, &options, BufWriter::new(file))
        .map_err(|error| failure(format!("{}: {error}", path.display())))?;
    unfinished.finish()?;
    Ok(())
}
