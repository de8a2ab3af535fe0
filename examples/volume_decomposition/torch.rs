//! The volumes printed by a torch, in the layers that were audited: an IRB 1200 holds it over a table that tilts and turns, or the arm of
//! `--workcell` holds the torch or the part.

use super::Args;
use super::volumes::Divided;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{FlatPrint, Printed, TABLE_CELL, print_parts, workcell_of, workcell_or};
use curvlay_examples::nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::workcell::{AnyWorkcell, WorkcellModel};
use curvlay_layers::planar::VolumePart;
use curvlay_toolpath::path::Pattern;
use std::f64::consts::PI;

/// How far the torch goes on above its mouth before its holder, in millimetres.
const NECK_MM: f64 = 40.0;

/// Tool paths, motion and programs of the mesh, or of `--shape`.
pub fn print(args: &Args, divided: &[Divided], model: WorkcellModel, bars: &Bars) -> Result<Printed, Failure> {
    let plain = typed_name(args.shape);
    let of = divided.iter().find(|of| of.name == plain).or(divided.first());
    let Some(of) = of else { return Err(Failure::new("there is no part")) };
    let Some(first) = of.result.parts.first() else { return Err(Failure::new("there is no part")) };
    let onto_plate = onto_plate(first);
    let layers: Vec<_> = of.result.parts.iter().map(|part| part.flat_layers().moved(&onto_plate)).collect();
    let vertices = of.solid.vertices().iter().map(|p| onto_plate * p).collect();
    let mesh = Mesh { vertices, triangles: of.solid.triangles().to_vec() };
    let print = FlatPrint {
        mesh: &mesh,
        layers: &layers,
        bead_mm: args.bead_mm.unwrap_or(2.0 * args.layer_mm),
        pattern: Pattern::Spirals,
        cell_mm: None,
        filament_mm: args.wire_mm,
        filaments: 1,
        moves: true,
    };
    print_parts(&print, &cell(args, model)?, bars)
}

/// The motion that puts the base plane of the first part on the plate, its direction upwards.
fn onto_plate(first: &VolumePart) -> Isometry3<f64> {
    let over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let turn = UnitQuaternion::rotation_between(&first.direction, &Vector3::z()).unwrap_or(over);
    Isometry3::from_parts(Translation3::new(0.0, 0.0, -first.base_mm), turn)
}

/// The workcell as it is given.
pub fn model(args: &Args) -> Result<WorkcellModel, Failure> {
    workcell_or(args.workcell.as_deref(), TABLE_CELL)
}

/// The cell with the torch in place of its nozzle: a wire that reaches out of the mouth by the stand-off.
fn cell(args: &Args, mut model: WorkcellModel) -> Result<AnyWorkcell, Failure> {
    let shape = &mut model.nozzle;
    shape.tip_flat_mm = args.wire_mm;
    shape.cone_height_mm = args.stand_off_mm;
    // The cone ends where the mouth begins, but for rounding.
    let step_mm = (1.0 - 1e-9) * (args.torch_mm - args.wire_mm).max(0.0) / 2.0;
    shape.cone_half_angle_deg = step_mm.atan2(args.stand_off_mm).to_degrees();
    shape.block_diameter_mm = args.torch_mm;
    shape.block_top_mm = shape.block_top_mm.max(args.stand_off_mm + NECK_MM);
    workcell_of(model, args.workcell.as_deref())
}
