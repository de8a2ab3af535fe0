//! The workcell of the user, and its head as the search for parts takes it.

use super::Args;
use curvlay_examples::args::Failure;
use curvlay_examples::input;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{UR3_CELL, nozzle_of, plate_mm};
use curvlay_kinematics::workcell::{AnyWorkcell, WorkcellModel};
use curvlay_layers::planar::robofdm::Head;

/// The head of the workcell and its plate, as the search for parts takes them.
pub fn head(args: &Args, mesh: &Mesh) -> Result<Head, Failure> {
    let cell = AnyWorkcell::new(model(args)?)?;
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

/// The workcell as its file has it.
pub fn model(args: &Args) -> Result<WorkcellModel, Failure> {
    let text = match &args.workcell {
        Some(file) => input::read_text(file, input::MAX_SETTINGS_BYTES)?,
        None => UR3_CELL.to_owned(),
    };
    Ok(WorkcellModel::from_json(text.as_bytes())?)
}
