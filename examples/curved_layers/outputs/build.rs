//! The build as the viewer of the report takes it: part, layers, what the nozzle does, findings with their places, the robot.

use crate::field::FieldRun;
use crate::job::{Job, Results};
use crate::machine::MachineRun;
use crate::motion::{MotionRun, of_run};
use crate::surfaces::SurfacesRun;
use curvlay_examples::motion::shown;
use curvlay_examples::viewer::{Mark, Marks, Mesh, Model};
use curvlay_kinematics::workcell::Workcell;
use curvlay_layers::trim::{BoundaryKind, TrimmedSheet};
use curvlay_toolpath::layer::LayerSurface;
use nalgebra::Point3;

/// Colours of findings, red, green and blue.
const RED: [u8; 3] = [216, 40, 40];
const MAROON: [u8; 3] = [120, 10, 40];
const ORANGE: [u8; 3] = [240, 140, 20];
const VIOLET: [u8; 3] = [150, 60, 200];
const BLUE: [u8; 3] = [40, 110, 230];
const PINK: [u8; 3] = [232, 0, 150];

/// The build so far.
pub fn model(job: &Job, results: &Results) -> Model {
    let Results { field, surfaces, machine, motion, .. } = results;
    let grid = &field.solid.grid;
    let shift = field.solid.shift;
    let part = Mesh {
        vertices: job.part.mesh.vertices.iter().map(|vertex| vertex + shift).collect(),
        triangles: job.part.mesh.triangles.clone(),
    };
    let mould =
        field.mould.as_ref().map(|mould| Mesh { vertices: mould.vertices.clone(), triangles: mould.triangles.clone() });
    let corner = |c: &[i32; 2]| {
        let [x, y] = [0, 1].map(|axis| grid.origin()[axis] + f64::from(c[axis]) / 2.0 * grid.cell_mm());
        Point3::new(x, y, 0.0)
    };
    let mut model = Model {
        name: job.part.name.clone(),
        part,
        mould: mould.unwrap_or_default(),
        plate: field.platform.corners().iter().map(corner).collect(),
        layers: surfaces.iter().flat_map(|run| run.surfaces()).map(mesh).collect(),
        ends: surfaces.iter().flat_map(ends).collect(),
        kinds: shown::kinds(),
        marks: vec![missed(field)],
        nozzle: Some(shown::nozzle(&job.setup.cell.equipment().model().nozzle)),
        density_g_cm3: job.args.settings.material_density_g_cm3,
        ..Model::default()
    };
    if let Some(machine) = machine {
        model.marks.extend(found(machine));
        model.steps = shown::steps(&machine.resolved.paths, &machine.deposition.moves);
        model.laid = Some([machine.deposition.bead_mm, machine.deposition.extruded_mm3]);
        if let Some(motion) = motion {
            // What the robot does, not what it was asked to do.
            let (steps, robot) =
                of_run!(motion, run => shown::played(&run.cell, &run.frame_part, &run.plan, &machine.resolved.paths));
            (model.steps, model.robot) = (steps, Some(robot));
            let [mm, _] = model.laid_by_steps();
            model.laid = Some([mm, of_run!(motion, run => laid_mm3(run))]);
        }
    }
    model.marks.retain(|marks| !marks.places.is_empty());
    model
}

/// A layer with its support, if there is any.
fn mesh(surface: LayerSurface) -> Mesh {
    Mesh { vertices: surface.vertices.to_vec(), triangles: surface.triangles.to_vec() }
}

/// Where the surfaces end inside the part.
fn ends(run: &SurfacesRun) -> Vec<(u32, [Point3<f64>; 2])> {
    let of_sheet = |(layer, sheet): (u32, &'_ TrimmedSheet)| -> Vec<(u32, [Point3<f64>; 2])> {
        let inside = sheet.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Border);
        inside.map(|edge| (layer, edge.ends.map(|end| sheet.vertices[end as usize]))).collect()
    };
    (0..).zip(run.sheets.iter()).flat_map(of_sheet).collect()
}

/// Cells that are not built.
fn missed(field: &FieldRun) -> Marks {
    let grid = &field.solid.grid;
    let places =
        field.growth.missed.iter().map(|missed| Mark { at: grid.centre(grid.position(missed.cell)), path: None });
    Marks { what: "cells that are not built".to_owned(), colour: PINK, places: places.collect() }
}

/// What the checks of the paths found.
fn found(run: &MachineRun) -> [Marks; 5] {
    let marks = |what: &str, colour, places: Vec<Mark>| Marks { what: what.to_owned(), colour, places };
    let at = |path: usize, at| Mark { at, path: Some(path as u32) };
    let tip = |path: usize, waypoint: usize| run.resolved.paths[path].waypoints[waypoint].position;
    let gouging = run.resolved.left.iter().map(|gouge| at(gouge.path, tip(gouge.path, gouge.waypoint)));
    let left_out = run.resolved.left_out.iter().map(|piece| Mark { at: piece.tip, path: None });
    let unsupported = run.support.unsupported.iter().map(|piece| at(piece.path, piece.tip));
    let blocked = run.travels.blocked.iter().map(|travel| at(travel.path, travel.tip));
    let sharp = run
        .resolved
        .cut_turns
        .iter()
        .chain(&run.resolved.sharp)
        .map(|turn| at(turn.path, tip(turn.path, turn.waypoint)));
    [
        marks("nozzle collides", RED, gouging.collect()),
        marks("travels collide", MAROON, blocked.collect()),
        marks("paths left out", VIOLET, left_out.collect()),
        marks("unsupported beads", ORANGE, unsupported.collect()),
        marks("sharp turns of the nozzle", BLUE, sharp.collect()),
    ]
}

/// The volume of the filament that the motions lay.
fn laid_mm3<const N: usize, const F: usize, W: Workcell<N, F>>(run: &MotionRun<N, F, W>) -> f64 {
    let filament_mm: f64 = run.plan.runs.iter().filter_map(|run| run.filament_mm.last()).sum();
    filament_mm * run.limits.filament_mm2
}
