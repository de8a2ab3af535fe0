//! The nozzle against what is laid before, along all beads.

use super::super::args::Args;
use super::runs::{Runs, steps};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::laid::{Nozzle, NozzleInBeads, NozzlePose};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};

/// Places of the nozzle that are looked at are no farther apart, in millimetres: it is some ten of them wide.
const STEP_MM: f64 = 0.5;
/// Where the block ends, above the tip, in millimetres: higher up nothing is laid that it has not passed.
pub const TOP_MM: f64 = 60.0;

/// The nozzle of the options.
///
/// # Errors
/// What cannot be.
pub fn nozzle(args: &Args) -> Result<Nozzle, Failure> {
    let [tip, angle, cone, block] = args.nozzle_sizes();
    Nozzle::new([tip, angle.to_radians(), cone, block, TOP_MM.max(2.0 * cone)])
        .map_err(|what| Failure::of_arguments(format!("--nozzle: {what}")))
}

/// Where the nozzle is deeper in beads, or in the plate if there is one, than allowed.
///
/// # Errors
/// A nozzle that cannot be.
pub fn gouged(paths: &[ToolPath], args: &Args, plate: bool, bars: &Bars) -> Result<Runs, Failure> {
    let allowed = args.bead.contact;
    let mut beads = NozzleInBeads::new(nozzle(args)?, allowed);
    let mut runs = Runs::default();
    for (number, path) in paths.iter().enumerate() {
        bars.update("nozzle", number as u64, paths.len() as u64);
        beads.lay(&pose(&path.waypoints[0], &path.waypoints[0], 0.0), None);
        beads.lay(&pose(&path.waypoints[0], &path.waypoints[0], 0.0), Some(path.waypoints[1].height));
        for pair in path.waypoints.windows(2) {
            let length = pair[1].arc - pair[0].arc;
            let count = steps(length, STEP_MM);
            for k in 1..=count {
                let pose = pose(&pair[0], &pair[1], f64::from(k) / f64::from(count));
                let height = pair[1].height;
                let sunk = if plate { beads.below_plate(&pose) - allowed * height } else { 0.0 };
                let depth = beads.depth(&pose).max(sunk);
                let part = length / f64::from(count);
                runs.step(part, (depth > 1e-9).then_some(depth), pose.tip, path.layer, false);
                beads.lay(&pose, Some(height));
            }
        }
        runs.end();
    }
    Ok(runs)
}

fn pose(a: &Waypoint, b: &Waypoint, share: f64) -> NozzlePose {
    let axis = a.axis.into_inner() * (1.0 - share) + b.axis.into_inner() * share;
    let tip = a.position + (b.position - a.position) * share;
    NozzlePose { tip, axis: axis.try_normalize(1e-9).unwrap_or(b.axis.into_inner()) }
}
