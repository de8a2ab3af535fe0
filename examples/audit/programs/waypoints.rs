//! Waypoints, `px py pz nx ny nz` a line, as beads of a given size: consecutive ones are joined unless they are far apart.

use super::builder::{Builder, Laid, Said};
use super::program::{Given, Program};
use curvlay_examples::waypoints::Line;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Steps longer than this many median steps are ways between islands.
const FAR: f64 = 5.0;

/// The beads between waypoints.
///
/// # Errors
/// The line, or the size that is not known.
pub fn beads(lines: &[Line], given: &Given, max_step_mm: Option<f64>) -> Result<Program, String> {
    let mut places = Vec::with_capacity(lines.len());
    for line in lines {
        let [x, y, z, nx, ny, nz] = line.values;
        let axis =
            UnitVector3::try_new(Vector3::new(nx, ny, nz), 1e-6).filter(|axis| axis.iter().all(|x| x.is_finite()));
        if ![x, y, z].iter().all(|at| at.abs() <= 1e7) {
            return Err(format!("line {}: a coordinate is not within 1e7", line.number));
        }
        let axis = axis.ok_or_else(|| format!("line {}: the direction of the nozzle has no length", line.number))?;
        places.push((Point3::new(x, y, z) * given.scale, axis));
    }
    let mut steps: Vec<f64> =
        places.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let far = max_step_mm.unwrap_or(FAR * median);
    let mut builder = Builder::new(*given, 1.75);
    let said = Said { layer: Some(0), ..Said::default() };
    for pair in places.windows(2) {
        let length = (pair[1].0 - pair[0].0).norm();
        if length > far {
            builder.end();
        } else if length > 0.0 {
            builder
                .lay(&Laid { tips: [pair[0].0, pair[1].0], axes: [pair[0].1, pair[1].1], filament_mm: None }, &said)?;
        }
    }
    let meant = format!("waypoints with directions, as beads of one layer; steps above {far:.3} mm lay nothing");
    Ok(Program { is_alone: true, ..builder.finish(meant, true, false) })
}
