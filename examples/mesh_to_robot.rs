//! From a mesh to a robot program with the crates alone: cells, curved layers, tool paths, joint motion in a workcell.
//!
//! ```sh
//! cargo run --release --example mesh_to_robot -- part.stl cell.json folder   # without arguments: a jug under a UR3
//! ```

use curvlay_examples::args::{self, Failure, Outcome};
use curvlay_examples::motion::{
    OnCell, PlacedPaths, PrintingCell, TargetFormat, TargetLanguage, UR3_CELL, bounds_of, from_home, nozzle_of,
    programs, table_options, track_options, workcell_model, workcell_of, write_targets,
};
use curvlay_examples::{input, mesh::read_mesh, shapes::jug};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, Workcell, WorkcellModel};
use curvlay_kinematics::{centred_on_plate, program::write_urscript};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{LayerOptions, Platform, Workpiece};
use curvlay_toolpath::fill::fill_layers;
use curvlay_toolpath::gouging::{Contacts, GougingOptions};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::path::PathOptions;
use curvlay_toolpath::plan::{self, PrintPlan};
use curvlay_trajectory::print::{PrintLimits, PrintOptions, plan_print};
use curvlay_voxel::{Resolution, VoxelOptions, inspect::inspect, voxelise};
use std::{env, io::BufWriter, ops::ControlFlow::Continue, path::Path, process::ExitCode};

/// Diameter of a plate that the workcell leaves open; edge of a cell, height of a layer and width of a bead, in millimetres.
const PLATE_MM: f64 = 127.5;
const CELL_MM: f64 = 4.0;

fn main() -> ExitCode {
    args::run(mesh_to_robot)
}

fn mesh_to_robot() -> Result<Outcome, Failure> {
    let args: Vec<String> = env::args().skip(1).collect();
    let mesh = args.first().map_or_else(|| Ok(jug()), |file| read_mesh(file.as_ref()))?.oriented()?;
    let given = args.get(1).map(Path::new);
    let model = given.map_or_else(|| Ok(WorkcellModel::from_json(UR3_CELL.as_bytes())?), workcell_model)?;
    let cell = workcell_of(model, given)?;
    let inputs = input::Inputs::new(args.iter().take(2).map(Path::new));
    let out = args.get(2).cloned().unwrap_or_else(|| "target/out/mesh_to_robot".to_owned());

    // Cells, layers and tool paths: see mesh_to_gcode.rs. The nozzle is that of the workcell.
    let options = VoxelOptions { resolution: Resolution::Cell(CELL_MM), ..VoxelOptions::default() };
    args::warn_if_open(inspect(&mesh.vertices, &mesh.triangles)?.open_edges.count);
    let solid = voxelise(&mesh.vertices, &mesh.triangles, &options, &|_| Continue(()))?;
    let vertices: Vec<_> = mesh.vertices.iter().map(|vertex| vertex + solid.shift).collect();
    let cells = Cells::new(solid.grid.dims(), solid.grid.rows())?;
    let platform = Platform::under(&cells, PLATE_MM / 2.0 / CELL_MM)?;
    let mesh = (&vertices[..], &mesh.triangles[..]);
    let part = Workpiece::new(mesh, cells, CELL_MM, solid.grid.origin(), &platform, &|_| Continue(()))?;
    let layered = part.layers(&LayerOptions::hull_rule(), &|_| Continue(()))?;
    let surfaces: Vec<_> = layered.surfaces.iter().map(LayerSurface::from).collect();
    let filled = fill_layers(&surfaces, &PathOptions { bead: CELL_MM, ..PathOptions::default() }, &|_| Continue(()))?;
    let (nozzle, stack) = (nozzle_of(cell.equipment())?, filled.stack(&surfaces)?);
    let plan = filled.plan(&surfaces, &nozzle, &plan::PrintOptions::for_robot(), &|_| Continue(()))?;

    // The cells of each layer, in the middle of the plate, and the nozzle in what is built.
    let grown = PartCells {
        dims: cells.dims(),
        rows: cells.rows(),
        cell_mm: CELL_MM,
        origin: part.origin,
        frame_part: centred_on_plate(plan.resolved.tips()),
        layers: &layered.uniform.field.cells_by_surface(&layered.surfaces.heights_mm, CELL_MM)?,
    };
    let contacts = stack.contacts(&plan.resolved.paths, &nozzle, &GougingOptions::in_workcell(), &|_| Continue(()))?;
    println!("{} cells missed, {} pieces left out", layered.growth.missed.len(), plan.resolved.left_out.len());
    match &cell {
        AnyWorkcell::Six(cell) => print(cell, &grown, &plan, &contacts, &PrintOptions::default(), (&out, &inputs)),
        AnyWorkcell::Seven(cell) => print(cell, &grown, &plan, &contacts, &track_options(), (&out, &inputs)),
        AnyWorkcell::Eight(cell) => print(cell, &grown, &plan, &contacts, &table_options(), (&out, &inputs)),
    }
}

/// Plans the motion of the joints, says what cannot be printed, and writes the programs: more than one where no way leads on.
fn print<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    part: &PartCells,
    plan: &PrintPlan,
    contacts: &Contacts,
    options: &PrintOptions<N, F>,
    (out, inputs): (&str, &input::Inputs),
) -> Result<Outcome, Failure> {
    // The plate is at least as wide as the part.
    let plate_mm = PLATE_MM.max(part.cell_mm * f64::from(part.dims[0]).hypot(f64::from(part.dims[1])));
    let scene = GrowingScene::new(cell, part, plate_mm, &GrowingOptions::default())?;
    let paths = PlacedPaths::new(&plan.resolved.paths, &plan.deposition, &part.frame_part);
    let limits = PrintLimits { tolerance_mm: CELL_MM / 4.0, ..PrintLimits::of(bounds_of(cell.limits())) };
    let (robot, scene) = (OnCell::new(cell.clone(), Vec::new()), PrintingCell::new(scene, contacts));
    let motion = plan_print(&robot, scene.clone(), &paths.paths(), &limits, options, &|_| Continue(()))?;
    // Programs begin and end at home. A stream is cut where it is long; the writer of RAPID cuts its modules itself.
    let cuts = programs::cuts(cell, &motion, false, None);
    let motion = from_home(&motion, &cuts, &robot, scene, (&limits, options), &|_| Continue(()))?;
    for (number, runs) in programs::pieces(&motion).into_iter().enumerate() {
        let name = format!("print{}", number + 1);
        let create = |file: &str| inputs.create(&Path::new(out).join(file)).map(BufWriter::new);
        if let Some(language) = TargetLanguage::of(cell.equipment())? {
            let format = TargetFormat::new(name, language, motion.max_filament_mm_s());
            write_targets(programs::targets(cell, &motion, runs), cell.equipment(), &format, create)?;
        } else {
            let (options, file) = (programs::urscript_options(cell, &motion, &name), format!("{name}.script"));
            write_urscript(programs::stream(cell, &motion, runs), &options, create(&file)?)?;
        }
    }
    println!("{} motions, {:.0} min, {} faults", motion.runs.len(), motion.robot_s() / 60.0, motion.faults.len());
    Ok(Outcome::of(motion.faults.iter().map(ToString::to_string).collect()))
}
