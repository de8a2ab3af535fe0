//! A damaged mesh (every third triangle looks inwards, one is missing): what is wrong with it, mended windings, and a level of its cells.
//!
//! ```sh
//! cargo run -p curvlay-voxel --example damaged_mesh
//! ```

use curvlay_voxel::inspect::{MeshReport, inspect};
use curvlay_voxel::nalgebra::Point3;
use curvlay_voxel::{Resolution, VoxelOptions, orient, polygonise, voxelise};
use std::error::Error;
use std::ops::ControlFlow;

/// A torus in the plane z = 10, mm.
fn torus(p: Point3<f64>) -> f64 {
    (p.x.hypot(p.y) - 14.0).hypot(p.z - 10.0) - 5.0
}

fn print_report(name: &str, report: &MeshReport) {
    println!(
        "{name:8} edges whose sides disagree {:4}, open edges {}, holes {}, sound: {}",
        report.inconsistent_edges.count,
        report.open_edges.count,
        report.holes,
        report.is_sound()
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let corner = Point3::new(20.0, 20.0, 16.0);
    let surface = polygonise(torus, Point3::new(-20.0, -20.0, 4.0), corner, 1.3)?;
    let mut damaged = surface.triangles.clone();
    damaged.iter_mut().step_by(3).for_each(|triangle| triangle.swap(0, 1));
    damaged.pop();

    print_report("damaged", &inspect(&surface.vertices, &damaged)?);
    let mended = orient(&surface.vertices, &damaged)?;
    print_report("mended", &inspect(&surface.vertices, &mended.triangles)?);
    println!("{} triangles flipped", mended.report.turned_triangles);

    // Cells need no mended mesh, and do not leak through the hole.
    let options = VoxelOptions { resolution: Resolution::Cell(2.0), ..VoxelOptions::default() };
    let cells =
        |triangles: &[[u32; 3]]| voxelise(&surface.vertices, triangles, &options, &|_| ControlFlow::Continue(()));
    let (whole, holed) = (cells(&surface.triangles)?, cells(&damaged)?);
    println!("cells of the whole mesh {}, of the damaged one {}", whole.grid.count(), holed.grid.count());

    // The middle level.
    let [nx, ny, nz] = holed.grid.dims();
    for y in 0..ny {
        let mark = |x| if holed.grid.contains([x, y, nz / 2]) { '#' } else { '.' };
        println!("{}", (0..nx).map(mark).collect::<String>());
    }
    Ok(())
}
