//! How long the axes take.

use crate::machine::geometry::{FiveAxis, Posture};

/// Way, greatest speed and acceleration of each axis.
fn ways<'a>(machine: &'a FiveAxis, from: &'a Posture, to: &'a Posture) -> impl Iterator<Item = [f64; 3]> + 'a {
    let linear = machine.linear.iter().enumerate();
    let linear = linear.map(|(k, axis)| [(to.linear[k] - from.linear[k]).abs(), axis.speed, axis.acceleration]);
    let rotary = machine.rotary.iter().enumerate();
    linear.chain(rotary.map(|(k, axis)| [(to.rotary[k] - from.rotary[k]).abs(), axis.speed, axis.acceleration]))
}

/// At greatest speed.
pub(super) fn at_speed(machine: &FiveAxis, from: &Posture, to: &Posture) -> f64 {
    ways(machine, from, to).map(|[way, speed, _]| way / speed).fold(0.0, f64::max)
}

/// From rest to rest, with greatest speed and acceleration.
pub(super) fn at_rest(machine: &FiveAxis, from: &Posture, to: &Posture) -> f64 {
    let seconds = |[way, speed, acceleration]: [f64; 3]| {
        // Without a limit of acceleration the second term is 0.
        if way * acceleration >= speed * speed {
            way / speed + speed / acceleration
        } else {
            2.0 * (way / acceleration).sqrt()
        }
    };
    ways(machine, from, to).map(seconds).fold(0.0, f64::max)
}

/// The rotary axes alone, at greatest speed.
pub(super) fn turning(machine: &FiveAxis, ways: [f64; 2]) -> f64 {
    (ways[0].abs() / machine.rotary[0].speed).max(ways[1].abs() / machine.rotary[1].speed)
}
