//! The workcell of the user, and its head as the search for parts takes it.

use super::Args;
use curvlay_examples::args::Failure;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{UR3_CELL, nozzle_of, plate_mm, workcell_of, workcell_or};
use curvlay_kinematics::workcell::WorkcellModel;
use curvlay_layers::planar::robofdm::Head;

/// The head of the workcell and its plate, as the search for parts takes them.
pub fn head(args: &Args, mesh: &Mesh) -> Result<Head, Failure> {
    let cell = workcell_of(model(args)?, args.workcell.as_deref())?;
    let nozzle = nozzle_of(cell.equipment())?;
    Ok(Head {
        tip_radius: nozzle.tip_radius(),
        cone_half_angle: cell.equipment().model().nozzle.cone_half_angle_deg.to_radians(),
        cone_height: nozzle.cone_height(),
        block_radius: nozzle.block_radius(),
        platform_radius: cell.equipment().plate_diameter_mm(plate_mm(mesh)) / 2.0,
        layer: args.layer_height,
        ..Head::default()
    })
}

/// The workcell as it is given.
pub fn model(args: &Args) -> Result<WorkcellModel, Failure> {
    workcell_or(args.workcell.as_deref(), UR3_CELL)
}
