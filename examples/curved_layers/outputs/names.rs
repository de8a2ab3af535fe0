//! Names of the files that a run writes.

use super::{axes, programs, tmf, workcell};
use crate::motion::trajectory;
use crate::ranges;
use curvlay_examples::output::SUMMARY;

/// The files that a run may write, but for programs.
const NAMES: [&str; 33] = [
    SUMMARY,
    "report.html",
    "oriented.obj",
    "field.csv",
    "impossible.csv",
    "field.txt",
    "field.vtk",
    "layers.obj",
    "layers.vtk",
    "paths.obj",
    "paths.vtp",
    ranges::FILE,
    "toolpath.gcode",
    // Of earlier versions.
    "toolpath-bc.gcode",
    axes::FILE,
    "flavour.json",
    "toolpath.apt",
    "toolpath.csv",
    tmf::FILE,
    tmf::BEADS_FILE,
    "build.glb",
    "gouging.csv",
    "left_out.csv",
    "turns.csv",
    "blocked_travels.csv",
    "unsupported.csv",
    "spans.csv",
    trajectory::FILE,
    "layers.csv",
    "motion-faults.csv",
    "motion-check.csv",
    "programs.csv",
    workcell::FILE,
];

/// Whether a file of this name is one that a run may write.
pub fn is_ours(name: &str) -> bool {
    NAMES.contains(&name) || programs::is_ours(name)
}
