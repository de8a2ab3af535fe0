//! Directions along a path made smooth: a low-pass where they jump, and more points across crests.
//!
//! Dai 2020, section 3.5.2. The paper filters samples that differ from a neighbour by more than a threshold, and divides
//! steps over crests with quaternion interpolation. Turning one direction into another by a unit quaternion of the least
//! angle moves it along their great circle at even speed, so that is what [`along`] does.

use super::tool_path::Waypoint;
use nalgebra::{Unit, UnitVector3};

/// Directions nearer than this to opposite ones, in radians, have no great circle to speak of.
const OPPOSITE: f64 = 1e-6;

/// Turns that are too sharp by no more than this, in radians, are not: rounding.
pub(crate) const TURN_ROUNDING: f64 = 1e-9;

/// The angle between two directions; exact for small ones, too.
pub(crate) fn angle(a: &UnitVector3<f64>, b: &UnitVector3<f64>) -> f64 {
    2.0 * (a.into_inner() - b.into_inner()).norm().atan2((a.into_inner() + b.into_inner()).norm())
}

/// From one direction a share of the way to another along their great circle; `None` for opposite ones.
pub(crate) fn along(a: &UnitVector3<f64>, b: &UnitVector3<f64>, share: f64) -> Option<UnitVector3<f64>> {
    let whole = angle(a, b);
    if whole > std::f64::consts::PI - OPPOSITE {
        return None;
    }
    let across = b.into_inner() - a.into_inner() * a.dot(b);
    let Some(across) = across.try_normalize(f64::MIN_POSITIVE) else {
        return Some(*a);
    };
    let (sin, cos) = (share * whole).sin_cos();
    Some(Unit::new_normalize(a.into_inner() * cos + across * sin))
}

/// Filters, round by round, all directions that differ from a neighbour by more than `limit`: each becomes the mean of
/// its neighbours and twice itself.
pub(super) fn low_pass(directions: &mut [UnitVector3<f64>], limit: f64, rounds: usize) {
    for _ in 0..rounds {
        let sharp: Vec<bool> = directions.windows(2).map(|pair| angle(&pair[0], &pair[1]) > limit).collect();
        if !sharp.contains(&true) {
            return;
        }
        let old = directions.to_vec();
        for (k, direction) in directions.iter_mut().enumerate() {
            let (before, behind) = (k.checked_sub(1), Some(k + 1).filter(|&next| next < old.len()));
            if before.is_some_and(|k| sharp[k]) || (behind.is_some() && sharp[k]) {
                let neighbours = [before, behind].into_iter().flatten().map(|k| old[k].into_inner());
                let sum = neighbours.fold(old[k].into_inner() * 2.0, |sum, other| sum + other);
                *direction = Unit::try_new(sum, 0.0).unwrap_or(*direction);
            }
        }
    }
}

/// The waypoints to be put between two that differ by more than `limit`, evenly; none if they do not or are opposite.
pub(crate) fn between(from: &Waypoint, to: &Waypoint, limit: f64) -> Vec<Waypoint> {
    let parts = (angle(&from.axis, &to.axis) / limit - TURN_ROUNDING).ceil().max(1.0) as usize;
    (1..parts).filter_map(|k| part_way(from, to, k as f64 / parts as f64)).collect()
}

/// The waypoint a share of the way from one to another; none if they are opposite.
pub(crate) fn part_way(from: &Waypoint, to: &Waypoint, share: f64) -> Option<Waypoint> {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    along(&from.axis, &to.axis, share).map(|direction| Waypoint {
        position: from.position + (to.position - from.position) * share,
        axis: direction,
        width: mix(from.width, to.width),
        height: mix(from.height, to.height),
        arc: mix(from.arc, to.arc),
        added: true,
        lift: from.lift.lerp(&to.lift, share),
        kind: to.kind,
    })
}
