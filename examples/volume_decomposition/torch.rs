//! The volumes printed by a torch: an IRB 1200 holds it over a table that tilts and turns.

use super::Args;
use super::volumes::Divided;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{FlatPrint, Printed, TABLE_CELL, print_parts};
use curvlay_examples::nalgebra::Vector3;
use curvlay_kinematics::workcell::{AnyWorkcell, WorkcellModel};
use curvlay_layers::planar::Solid;
use curvlay_toolpath::surface::Pattern;

/// How far the torch goes on above its mouth before its holder, in millimetres.
const NECK_MM: f64 = 40.0;

/// Layers, tool paths, motion and RAPID of the mesh, or of `--shape`.
pub fn print(args: &Args, divided: &[Divided], bars: &Bars) -> Result<Printed, Failure> {
    let plain = typed_name(args.shape);
    let of = divided.iter().find(|of| of.name == plain).or(divided.first());
    let Some(of) = of else { return Err(Failure::new("there is no part")) };
    if of.result.parts.first().is_none_or(|first| first.direction.dot(&Vector3::z()) < 1.0 - 1e-9) {
        return Err(Failure::new("--rapid prints a part as it stands: leave out --base best, or turn it with --up"));
    }
    // Onto the plate.
    let [low, _] = of.solid.bounds();
    let moved = |solid: &Solid| {
        let vertices: Vec<_> = solid.vertices().iter().map(|p| p - Vector3::z() * low.z).collect();
        Solid::new(&vertices, solid.triangles())
    };
    let solids: Vec<Solid> = of.result.parts.iter().map(|part| moved(&part.solid)).collect::<Result<_, _>>()?;
    let parts: Vec<_> = solids.iter().zip(&of.result.parts).map(|(solid, part)| (solid, part.direction)).collect();
    let whole = moved(&of.solid)?;
    let mesh = Mesh { vertices: whole.vertices().to_vec(), triangles: whole.triangles().to_vec() };
    let print = FlatPrint {
        mesh: &mesh,
        parts: &parts,
        layer_mm: args.layer_mm,
        bead_mm: args.bead_mm.unwrap_or(2.0 * args.layer_mm),
        pattern: Pattern::Spirals,
        cell_mm: None,
        filament_mm: args.wire_mm,
        filaments: 1,
        moves: true,
    };
    print_parts(&print, &cell(args)?, bars)
}

/// The cell with the torch in place of its nozzle: a wire that reaches out of the mouth by the stand-off.
fn cell(args: &Args) -> Result<AnyWorkcell, Failure> {
    let mut model = WorkcellModel::from_json(TABLE_CELL.as_bytes())?;
    let shape = &mut model.nozzle;
    shape.tip_flat_mm = args.wire_mm;
    shape.cone_height_mm = args.stand_off_mm;
    // The cone ends where the mouth begins, but for rounding.
    let step_mm = (1.0 - 1e-9) * (args.torch_mm - args.wire_mm).max(0.0) / 2.0;
    shape.cone_half_angle_deg = step_mm.atan2(args.stand_off_mm).to_degrees();
    shape.block_diameter_mm = args.torch_mm;
    shape.block_top_mm = shape.block_top_mm.max(args.stand_off_mm + NECK_MM);
    Ok(AnyWorkcell::new(model)?)
}
