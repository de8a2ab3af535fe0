//! Wires on the loaded layer: polylines of a file, laid by a tool of their own (section 5.5).

use curvlay_examples::args::Failure;
use curvlay_examples::input;
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::waypoints::fault;
use curvlay_toolpath::fiber::conductor::{ConductorOptions, conductor};
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::mesh::SurfaceMesh;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Reads polylines: a point `x,y,z` a line, an empty line between two of them.
pub fn read(path: &Path) -> Result<Vec<Vec<Point3<f64>>>, Failure> {
    let file = input::open(path, input::MAX_TEXT_BYTES)?;
    let mut wires = vec![Vec::new()];
    for (number, line) in BufReader::new(file).lines().enumerate() {
        let line = line.map_err(|error| fault(path, &error))?;
        let cells: Vec<&str> = line.split([',', ' ', '\t']).filter(|cell| !cell.trim().is_empty()).collect();
        if cells.is_empty() {
            wires.push(Vec::new());
            continue;
        }
        let point: Option<Vec<f64>> = cells.iter().map(|cell| cell.trim().parse().ok()).collect();
        match point.as_deref() {
            Some(&[x, y, z]) => wires.last_mut().into_iter().for_each(|wire| wire.push(Point3::new(x, y, z))),
            _ => return Err(fault(path, &format!("line {} must be three numbers `x,y,z`", number + 1))),
        }
    }
    wires.retain(|wire| !wire.is_empty());
    if wires.is_empty() { Err(fault(path, &"there is no wire in it")) } else { Ok(wires) }
}

/// A wire of a file on a layer.
///
/// # Arguments
/// * `number`: which of the file, from 0.
pub fn on_layer(
    path: &Path,
    number: usize,
    wire: &[Point3<f64>],
    surface: &SurfaceMesh,
    options: &ConductorOptions,
) -> Result<Tape, Failure> {
    conductor(surface, wire, options).map_err(|error| fault(path, &format!("wire {}: {error}", number + 1)))
}
