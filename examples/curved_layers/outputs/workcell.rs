//! `workcell.json`: the workcell in which the run has planned, with the limits that held: to replay the run, or to repeat it.

use crate::motion::MotionRun;
use curvlay_examples::args::Failure;
use curvlay_examples::output::OutputFolder;
use curvlay_kinematics::workcell::{BodiesModel, Workcell};
use std::io;
use std::path::{Path, absolute};

/// Its name.
pub use curvlay_examples::motion::WORKCELL_FILE as FILE;

/// Writes it. Meshes of links stay where they are, beside the file that was given.
///
/// # Errors
/// A [`Failure`] from the folder.
pub fn write<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    given: Option<&Path>,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let bounds = &run.limits.bounds;
    let finite = |limit: f64| Some(limit).filter(|limit| limit.is_finite());
    let mut model = run.cell.equipment().model().clone();
    model.arm.limits.max_acceleration_rad_s2 = Some([0, 1, 2, 3, 4, 5].map(|k| finite(bounds.acceleration[k])));
    model.arm.limits.max_jerk_rad_s3 = Some([0, 1, 2, 3, 4, 5].map(|k| finite(bounds.jerk[k])));
    if let Some(table) = &mut model.positioner {
        table.limits.max_acceleration_rad_s2 = Some([6, 7].map(|k| finite(bounds.acceleration[k])));
        table.limits.max_jerk_rad_s3 = Some([6, 7].map(|k| finite(bounds.jerk[k])));
    }
    if let Some(BodiesModel::Meshes(meshes)) = &mut model.arm.bodies {
        let beside = given.and_then(Path::parent).unwrap_or(Path::new(""));
        for mesh in meshes {
            mesh.file = absolute(beside.join(&mesh.file)).map_err(Failure::new)?.display().to_string();
        }
    }
    folder.write_with(FILE, |out| model.write_json(out).map_err(io::Error::other))?;
    Ok(())
}
