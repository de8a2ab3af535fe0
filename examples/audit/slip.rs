//! Sizes that are no print's: a slip of the unit.

use curvlay_examples::mesh::Mesh;
use nalgebra::Point3;

/// Beads and cells are within these, in millimetres: from micro-extrusion to concrete.
const SIZES_MM: [f64; 2] = [0.02, 100.0];
/// Parts are within these, in millimetres.
const PARTS_MM: [f64; 2] = [0.5, 20_000.0];
/// What is laid and the part that is given differ by no more than this factor.
const FACTOR: f64 = 20.0;

/// What is wrong with sizes, in words: how large beads or cells are, the box of all of them, and that of the part.
pub fn sizes(what: &str, size: f64, [low, high]: [Point3<f64>; 2], part: Option<&Mesh>) -> Option<String> {
    let longest = |low: Point3<f64>, high: Point3<f64>| (high - low).max();
    let is_within = |size: f64, [min, max]: [f64; 2]| (min..=max).contains(&size);
    let extent = longest(low, high);
    if !is_within(size, SIZES_MM) {
        return Some(format!("{what} are {} high and all of them {} long", shown(size), shown(extent)));
    }
    if !is_within(extent, PARTS_MM) {
        return Some(format!("all {what} together are {} long", shown(extent)));
    }
    let of_part = part.and_then(Mesh::bounds).map(|[low, high]| longest(low, high)).filter(|size| *size > 0.0);
    let of_part = of_part.filter(|size| !is_within(extent / size, [1.0 / FACTOR, FACTOR]))?;
    Some(format!("all {what} together are {} long, and the part of --mesh {}", shown(extent), shown(of_part)))
}

fn shown(mm: f64) -> String {
    match mm {
        0.1..1000.0 => format!("{mm:.1} mm"),
        1000.0..1e6 => format!("{:.1} m", mm / 1e3),
        1e6.. => format!("{:.1} km", mm / 1e6),
        _ => format!("{:.3} um", mm * 1e3),
    }
}
