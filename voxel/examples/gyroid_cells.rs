//! A sphere filled with a gyroid lattice becomes a mesh, the mesh is inspected, and its cells come closer to its volume the finer they are.
//!
//! Walls that are thinner than a cell come out a cell thick, so the volume of cells falls towards that of the mesh.
//!
//! ```sh
//! cargo run -p curvlay-voxel --example gyroid_cells
//! ```

use curvlay_voxel::inspect::inspect;
use curvlay_voxel::nalgebra::Point3;
use curvlay_voxel::{Resolution, VoxelOptions, polygonise, voxelise};
use std::error::Error;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Radius of the sphere, and period and half thickness (in the function's own unit) of the lattice; mm.
const RADIUS: f64 = 20.0;
const PERIOD: f64 = 16.0;
const HALF: f64 = 0.5;

/// Below zero within the walls of the gyroid (A. Schoen, NASA TN D-5541, 1970, by its first Fourier terms) and within the sphere.
fn distance(p: Point3<f64>) -> f64 {
    let [x, y, z] = [p.x, p.y, p.z].map(|value| value * TAU / PERIOD);
    let gyroid = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
    // The gradient is at most sqrt(3) TAU / PERIOD: about a distance in mm.
    let wall = (gyroid.abs() - HALF) * PERIOD / (TAU * 3f64.sqrt());
    wall.max(p.coords.norm() - RADIUS)
}

fn main() -> Result<(), Box<dyn Error>> {
    let corner = Point3::new(1.0, 1.0, 1.0) * (RADIUS + 1.0);
    let surface = polygonise(distance, -corner, corner, 0.7)?;
    let report = inspect(&surface.vertices, &surface.triangles)?;
    println!("{} triangles, watertight: {}, {} piece(s)", report.triangles, report.watertight, report.components);
    println!("volume of the mesh {:.0} mm3", report.volume_mm3());

    println!("{:>8} {:>9} {:>11} {:>9}", "cell mm", "cells", "volume mm3", "above %");
    for cell_mm in [2.0f64, 1.0, 0.5, 0.25] {
        let options = VoxelOptions { resolution: Resolution::Cell(cell_mm), ..VoxelOptions::default() };
        let solid = voxelise(&surface.vertices, &surface.triangles, &options, &|_| ControlFlow::Continue(()))?;
        let volume = solid.grid.count() as f64 * cell_mm.powi(3);
        let above = 100.0 * (volume / report.volume_mm3() - 1.0);
        println!("{cell_mm:8} {:9} {volume:11.0} {above:9.1}", solid.grid.count());
    }
    Ok(())
}
