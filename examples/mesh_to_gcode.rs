//! From a mesh to a machine file with the crates alone: cells, curved layers, tool paths, moves.
//!
//! ```sh
//! cargo run --release --example mesh_to_gcode -- part.stl part.gcode   # without arguments: a jug made in code
//! ```

use curvlay_examples::args::{Failure, Outcome, run, warn_if_open};
use curvlay_examples::input::Inputs;
use curvlay_examples::{mesh::read_mesh, shapes::jug};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{LayerOptions, Platform, Workpiece};
use curvlay_toolpath::fill::fill_layers;
use curvlay_toolpath::gcode::{WriteOptions, write_gcode};
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::path::PathOptions;
use curvlay_toolpath::plan::PrintOptions;
use curvlay_voxel::{Resolution, VoxelOptions, inspect::inspect, voxelise};
use std::{env, fs::File, ops::ControlFlow::Continue, process::ExitCode};

fn main() -> ExitCode {
    run(mesh_to_gcode)
}

fn mesh_to_gcode() -> Result<Outcome, Failure> {
    let mut args = env::args().skip(1);
    let file = args.next();
    let mesh = file.as_ref().map_or_else(|| Ok(jug()), |file| read_mesh(file.as_ref()))?.oriented()?;
    let out = args.next().unwrap_or_else(|| "mesh_to_gcode.gcode".to_owned());
    let out = Inputs::new(file.as_deref().map(str::as_ref)).spare(out.into())?;

    // The cells of the part. They stand on the plate z = 0, and the mesh is moved there.
    let options = VoxelOptions { resolution: Resolution::Count(10_000), ..VoxelOptions::default() };
    warn_if_open(inspect(&mesh.vertices, &mesh.triangles)?.open_edges.count);
    let solid = voxelise(&mesh.vertices, &mesh.triangles, &options, &|_| Continue(()))?;
    let vertices: Vec<_> = mesh.vertices.iter().map(|vertex| vertex + solid.shift).collect();
    let cells = Cells::new(solid.grid.dims(), solid.grid.rows())?;
    let cell_mm = solid.grid.cell_mm();

    // Layers as high as a cell, on a plate of 127.5 mm or as large as the part.
    let platform = Platform::under(&cells, 63.75 / cell_mm)?;
    let mesh = (&vertices[..], &mesh.triangles[..]);
    let part = Workpiece::new(mesh, cells, cell_mm, solid.grid.origin(), &platform, &|_| Continue(()))?;
    let layered = part.layers(&LayerOptions::hull_rule(), &|_| Continue(()))?;
    let surfaces: Vec<_> = layered.surfaces.iter().map(LayerSurface::from).collect();

    // Beads as wide as a layer is high, and the moves that lay them.
    let options = PathOptions { bead: cell_mm, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &|_| Continue(()))?;
    let plan = filled.plan(&surfaces, &Nozzle::default(), &PrintOptions::default(), &|_| Continue(()))?;
    let written = write_gcode(&plan.deposition.moves, &WriteOptions::default(), File::create(&out)?)?;

    println!(
        "{}: {} layers, {} moves, {:.0} min",
        out.display(),
        surfaces.len(),
        written.moves,
        plan.deposition.total_s / 60.0
    );
    println!("{} cells missed, {} waypoints gouge", layered.growth.missed.len(), plan.resolved.left.len());
    Ok(Outcome::Done)
}
