//! From parts to layers, tool paths, joint motion and programs.

use super::decompose::Divided;
use super::workcell::model;
use super::{Args, PatternName, Stage};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{FlatPrint, Printed, print_parts, workcell_of};
use curvlay_examples::nalgebra::{Isometry3, Vector3};
use curvlay_kinematics::workcell::{AnyWorkcell, Held};
use curvlay_kinematics::{ReachOptions, fullest_box, reachable_points};
use curvlay_layers::planar::flat_layers;
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

/// The workcell; its nozzle where the arm reaches most, if that was asked for (section 2.3.1 of the dissertation).
fn cell(args: &Args, divided: &Divided) -> Result<AnyWorkcell, Failure> {
    let mut model = model(args)?;
    if args.place_nozzle {
        if model.held != Held::Part {
            return Err(Failure::of_arguments("--place-nozzle: the arm of the workcell does not hold the part"));
        }
        let known = workcell_of(model.clone(), args.workcell.as_deref())?;
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
    workcell_of(model, args.workcell.as_deref())
}
