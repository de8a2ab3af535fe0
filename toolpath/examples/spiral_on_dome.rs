//! One continuous curve that fills a dome: geodesic distance from its rim, and connected Fermat spirals over it. Written as an SVG, seen
//! from above.
//!
//! ```sh
//! cargo run -p curvlay-toolpath --example spiral_on_dome -- dome.svg
//! ```

use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{PathOptions, SurfacePath};
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::ops::ControlFlow;

/// Radius of the sphere and the angle of its cap from the top, mm and rad.
const RADIUS: f64 = 30.0;
const CAP: f64 = 1.0;
const RINGS: u32 = 24;
const SIDES: u32 = 72;

/// A spherical cap, its top a vertex, seen from outside counter-clockwise.
fn dome() -> Result<SurfaceMesh, Box<dyn Error>> {
    let mut vertices = vec![Point3::new(0.0, 0.0, RADIUS)];
    for ring in 1..=RINGS {
        let (sin, cos) = (CAP * f64::from(ring) / f64::from(RINGS)).sin_cos();
        let turns = (0..SIDES).map(|side| (TAU * f64::from(side) / f64::from(SIDES)).sin_cos());
        vertices.extend(turns.map(|(y, x)| Point3::new(x * sin, y * sin, cos) * RADIUS));
    }
    let vertex = |ring: u32, side: u32| 1 + (ring - 1) * SIDES + side % SIDES;
    let mut triangles: Vec<_> = (0..SIDES).map(|side| [0, vertex(1, side), vertex(1, side + 1)]).collect();
    for (ring, side) in (1..RINGS).flat_map(|ring| (0..SIDES).map(move |side| (ring, side))) {
        let [a, b] = [vertex(ring, side), vertex(ring, side + 1)];
        let [c, d] = [vertex(ring + 1, side), vertex(ring + 1, side + 1)];
        triangles.extend([[a, c, d], [a, d, b]]);
    }
    Ok(SurfaceMesh::new(vertices, triangles)?)
}

fn svg(paths: &[SurfacePath]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-30 -30 60 60\">\n");
    for path in paths {
        let points: Vec<_> =
            path.points.iter().map(|p| format!("{:.2},{:.2}", p.at.position.x, -p.at.position.y)).collect();
        let shape = if path.closed { "polygon" } else { "polyline" };
        writeln!(
            text,
            "<{shape} fill=\"none\" stroke=\"#046\" stroke-width=\"0.4\" points=\"{}\"/>",
            points.join(" ")
        )?;
    }
    text.push_str("</svg>\n");
    Ok(text)
}

fn main() -> Result<(), Box<dyn Error>> {
    let bead = 0.8;
    let go_on = |_| ControlFlow::Continue(());
    let dome = dome()?;
    let distance = SurfaceDistance::to_boundary(&dome, &go_on)?;
    let field = LevelField::new(&distance, 0.01, &go_on)?;
    let filled = field.paths(&PathOptions { bead, ..PathOptions::default() }, &go_on)?;

    let area = TAU * RADIUS * RADIUS * (1.0 - CAP.cos());
    let length: f64 = filled.paths.iter().map(SurfacePath::length).sum();
    println!("{} curve(s) in {} region(s), {length:.0} mm of beads of {bead} mm", filled.paths.len(), filled.regions);
    println!("length x bead {:.0} mm2, area of the cap {area:.0} mm2", length * bead);
    if let Some(file) = std::env::args().nth(1) {
        std::fs::write(&file, svg(&filled.paths)?)?;
        println!("{file} written");
    }
    Ok(())
}
