//! From parts to layers, tool paths, joint motion and programs.

use super::decompose::Divided;
use super::{Args, PatternName, Stage};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::input;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{FlatPrint, Printed, UR3_CELL, nozzle_of, plate_mm, print_parts};
use curvlay_examples::nalgebra::{Isometry3, Vector3};
use curvlay_kinematics::workcell::{AnyWorkcell, Held, WorkcellModel};
use curvlay_kinematics::{ReachOptions, fullest_box, reachable_points};
use curvlay_layers::planar::flat_layers;
use curvlay_layers::planar::robofdm::Head;
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::path::Pattern;

/// A box with a part's edge in which an arm's frames are counted lies above the floor and in front of the arm, in millimetres.
const FRONT_MM: f64 = 150.0;

/// Everything behind the parts.
pub fn print(args: &Args, divided: &Divided, bars: &Bars) -> Result<Printed, Failure> {
    let up = Isometry3::from(Vector3::z() * divided.raised_mm());
    let mut layers = Vec::new();
    if let Some(pedestal) = &divided.pedestal {
        layers.push(pedestal.layers(args.layer_height)?.moved(&up));
    }
    for part in &divided.parts.parts {
        layers.push(flat_layers(&part.solid, &part.direction, args.layer_height)?.moved(&up));
    }
    let mesh = divided.standing();
    let print = FlatPrint {
        mesh: &mesh,
        layers: &layers,
        bead_mm: args.bead_mm(),
        pattern: match args.pattern {
            PatternName::Spiral => Pattern::Spirals,
            PatternName::Contours => Pattern::Rings,
            PatternName::Zigzag => Pattern::Zigzag,
        },
        cell_mm: args.cell_mm,
        filament_mm: DepositionOptions::default().filament_diameter,
        filaments: args.filaments,
        moves: args.stage == Stage::Motion,
    };
    print_parts(&print, &cell(args, divided)?, bars)
}

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

/// The workcell; its nozzle where the arm reaches most, if that was asked for (section 2.3.1 of the dissertation).
fn cell(args: &Args, divided: &Divided) -> Result<AnyWorkcell, Failure> {
    let mut model = model(args)?;
    if args.place_nozzle {
        if model.held != Held::Part {
            return Err(Failure::of_arguments("--place-nozzle: the arm of the workcell does not hold the part"));
        }
        let known = AnyWorkcell::new(model.clone())?;
        let (_, part_frame) = known.equipment().part_frame();
        let keep = |_: &[f64; 6], frame: &Isometry3<f64>| {
            let at = frame.translation.vector;
            at.z >= 0.0 && at.x >= FRONT_MM
        };
        let points = reachable_points(known.equipment().arm(), &part_frame, &ReachOptions::default(), keep)?;
        let [low, high] = divided.solid.bounds();
        let edges = high - low;
        // The nozzle stands still, and the part passes it by its own size, whichever way it is turned.
        let best = fullest_box(&points, [edges.max(); 3], &|_| std::ops::ControlFlow::Continue(()))?;
        model.nozzle.tip_mm = best.centre.coords.into();
    }
    Ok(AnyWorkcell::new(model)?)
}
