//! How much of two segments a blend takes.

use super::super::axes::Axes;
use super::super::machine::Machine;
use super::super::program::command::Zone;
use super::segment::Segment;
use nalgebra::Vector3;

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
            let change = change_of_speed(&before.rates[1], &after.rates[0], &before.ends[1], machine);
            (if change > 0.0 { (4.0 * corner_mm / change).min(half) } else { half }, false)
        }
    }
}

/// By how much the speed of the tip changes, in mm/s, at most: rotary axes move it by its lever arm.
fn change_of_speed(before: &Axes, after: &Axes, at: &Axes, machine: &Machine) -> f64 {
    let change: Axes = std::array::from_fn(|k| after[k] - before[k]);
    match machine {
        Machine::Rotary(rotary) => {
            let place = Vector3::new(at[0], at[1], at[2]);
            let lever = |centre: &Vector3<f64>| (place - centre).norm();
            let turned = change[3].abs() * lever(&rotary.tilt.centre) + change[4].abs() * lever(&rotary.turn.centre);
            Vector3::new(change[0], change[1], change[2]).norm() + turned
        }
        Machine::Robot(_) => change.iter().map(|x| x.abs()).sum::<f64>() * ARM_MM,
    }
}

/// Reach of an arm, for corners of moves by joints under a tolerance.
const ARM_MM: f64 = 1000.0;
