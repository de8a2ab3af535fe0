//! How much of two segments a blend takes.

use super::super::axes::Axes;
use super::super::machine::Machine;
use super::super::program::command::Zone;
use super::segment::{Path, Segment};

/// Seconds of both segments that a blend takes; 0 for a stop. The second value says whether the zone was cut, since it is wider than half a segment.
pub fn reach(before: &Segment, after: &Segment, machine: &Machine, corner_mm: f64) -> (f64, bool) {
    let half = 0.5 * before.seconds.min(after.seconds);
    match before.zone {
        Zone::Stop => (0.0, false),
        Zone::Radius(radius) => {
            let time = |segment: &Segment| {
                let speed = segment.length_mm / segment.seconds;
                if speed > 0.0 { radius / speed } else { f64::INFINITY }
            };
            let wanted = time(before).min(time(after));
            // A move that only turns has no radius: half of it.
            let is_cut = wanted > half * (1.0 + 1e-9) && wanted.is_finite();
            (wanted.min(half), is_cut)
        }
        Zone::Tolerance => {
            // A parabola cuts its corner by a quarter of the change of speed times its reach.
            let change = change_of_speed(before, after, machine);
            (if change > 0.0 { (4.0 * corner_mm / change).min(half) } else { half }, false)
        }
    }
}

/// By how much the speed of the tip changes, in mm/s: that of the parabola between two moves, in the first order.
fn change_of_speed(before: &Segment, after: &Segment, machine: &Machine) -> f64 {
    if let (Path::Tip { .. }, Some(first), Some(second)) = (&before.path, before.tip(), after.tip()) {
        return (second - first).norm();
    }
    let change: Axes = std::array::from_fn(|k| after.rates[0][k] - before.rates[1][k]);
    match machine {
        Machine::FiveAxis(printer) => {
            let at = before.ends[1];
            let moved: Axes = std::array::from_fn(|k| at[k] + INSTANT_S * change[k]);
            (printer.nozzle_on_part(&moved).tip - printer.nozzle_on_part(&at).tip).norm() / INSTANT_S
        }
        Machine::Robot(_) => change.iter().map(|x| x.abs()).sum::<f64>() * ARM_MM,
    }
}

/// Time for differences, in seconds: axes go less than a thousandth of a radian, and digits are left.
const INSTANT_S: f64 = 1e-5;
/// Reach of an arm, for corners of moves by joints under a tolerance.
const ARM_MM: f64 = 1000.0;
