//! The steps that all our arms share: the turn of joint 1, the triangle of upper arm and forearm, and joint 5 with the
//! joint that aims it.
//!
//! Each has two solutions that come together at a singularity. Differences of squares are factorised, so that their
//! roots keep all digits there.

use crate::angle::wrapped;
use crate::trig::{atan2, sin_cos};
use nalgebra::Vector3;

/// A point this far out of reach is reached, in millimetres: rounding, and below what a pose is checked for.
pub(super) const REACH: f64 = 1e-7;

/// Where two solutions meet the square root of a difference is taken, and rounding of the difference would leave 5e-8
/// rad between them: enough to hide a singular wrist. So a difference below this share of the whole, a few units in
/// the last place, is zero. That moves joints by 2e-7 rad at most, and no point by as much as rounding does.
const FOLDED: f64 = 2e-15;

/// What the pose leaves open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free {
    /// Where a free joint is put.
    pub joints: [f64; 6],
    /// The sine of joint 5 up to which the joint that aims it is free.
    pub wrist: f64,
    /// Whether a free joint may leave its place where that is out of reach.
    pub swings: bool,
}

/// Cosine, sine and angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub cos: f64,
    pub sin: f64,
    pub angle: f64,
}

impl Turn {
    pub fn of(angle: f64) -> Turn {
        let (sin, cos) = sin_cos(angle);
        Turn { cos, sin, angle }
    }

    /// Half a turn farther.
    pub fn opposite(self) -> Turn {
        Turn { cos: -self.cos, sin: -self.sin, angle: self.angle + std::f64::consts::PI }
    }

    fn towards(cos: f64, sin: f64) -> Turn {
        let length = (cos * cos + sin * sin).sqrt();
        Turn { cos: cos / length, sin: sin / length, angle: atan2(sin, cos) }
    }
}

/// Joint 1 turns the arm's plane, which passes axis 1 at the distance `across`, through the point. The plane's normal
/// is `(sin, -cos)`; the point's coordinate along `(cos, sin)` comes with each turn, first the one that is not
/// negative.
///
/// On axis 1, with no distance, any turn will do: `free` is taken, and the opposite.
pub(super) fn shoulder(point: &Vector3<f64>, across: f64, free: f64) -> Option<[(Turn, f64); 2]> {
    let (x, y) = (point.x, point.y);
    let distance = (x * x + y * y).sqrt();
    if distance <= REACH && across.abs() <= REACH {
        let turn = Turn::of(free);
        let along = x * turn.cos + y * turn.sin;
        return Some([(turn, along), (turn.opposite(), -along)]);
    }
    let beyond = across.abs();
    // Written so that NaN and infinities fail.
    if !(distance - beyond >= -REACH && distance < f64::MAX) {
        return None;
    }
    let spare = if distance - beyond > FOLDED * beyond { distance - beyond } else { 0.0 };
    let along = (spare * (distance + beyond)).sqrt();
    let turn = |along: f64| (Turn::towards(along * x - across * y, along * y + across * x), along);
    Some([turn(along), turn(-along)])
}

/// The angle between the two links that reach a point at `distance`: cosine and sine, the sine not negative. Links
/// may have any sign.
pub(super) fn bend(distance: f64, first: f64, second: f64) -> Option<(f64, f64)> {
    let (outer, inner) = (first.abs() + second.abs(), (first.abs() - second.abs()).abs());
    if !(distance <= outer + REACH && distance >= inner - REACH) {
        return None;
    }
    let spare = |difference: f64| if difference > FOLDED * outer { difference } else { 0.0 };
    let square = spare(outer - distance) * (outer + distance) * spare(distance - inner) * (distance + inner);
    let product = 2.0 * first * second;
    let cos = (distance * distance - first * first - second * second) / product;
    Some((cos.clamp(-1.0, 1.0), square.sqrt() / product.abs()))
}

/// The direction of the first link, for links with this angle between them that reach `(x, y)`. When they fold back to
/// where they began, any will do: `free`.
pub(super) fn lift(x: f64, y: f64, first: f64, second: f64, (cos, sin): (f64, f64), free: f64) -> Turn {
    let (near, off) = (first + second * cos, second * sin);
    if x * x + y * y <= REACH * REACH {
        return Turn::of(free);
    }
    Turn::towards(x * near + y * off, y * near - x * off)
}

/// The axis of the flange, `(x, y, z)` before the joint that aims it and joint 5 have turned: that joint, joint 5 not
/// negative, and whether the aim is free. Along z, any aim will do: `free`, or the opposite, and joint 5 as near as it
/// comes.
pub(super) fn aim(x: f64, y: f64, z: f64, free: f64, singular: f64) -> (Turn, f64, bool) {
    let sine = (x * x + y * y).sqrt();
    if sine > singular {
        return (Turn { cos: x / sine, sin: y / sine, angle: atan2(y, x) }, atan2(sine, z), false);
    }
    let turn = Turn::of(free);
    let along = x * turn.cos + y * turn.sin;
    if along < 0.0 { (turn.opposite(), atan2(-along, z), true) } else { (turn, atan2(along, z), true) }
}

/// How far the elbow is bent in a posture that [`swing`] puts at the end of the links' reach, in radians: enough for
/// its two branches to be apart, and next to nothing in the reach (1e-8 mm at a metre).
const ENDS_APART: f64 = 4.0 * super::branches::SAME;

/// A lever of length `lever` turns freely about `(x, y)`, and upper arm and forearm from the origin carry its end. For
/// the lever at `angle` its end may be out of their reach: the turn, at most half a one, to the nearest angle at which
/// it is not. `None` where no angle will do.
///
/// The end of the lever is at a distance that falls from `distance + lever` to the difference of the two while it
/// turns half a turn, so the nearest angle is that at which the end lies on the border of the reach.
pub(super) fn swing(x: f64, y: f64, lever: f64, angle: f64, first: f64, second: f64) -> Option<f64> {
    let distance = (x * x + y * y).sqrt();
    let product = (first * second).abs();
    // The law of cosines with the elbow almost stretched, and almost folded.
    let bent = product * ENDS_APART * ENDS_APART;
    let outer = ((first.abs() + second.abs()).powi(2) - bent).sqrt();
    let inner = ((first.abs() - second.abs()).powi(2) + bent).sqrt();
    let end = (distance * distance + lever * lever + 2.0 * distance * lever * (angle - atan2(y, x)).cos()).sqrt();
    let border = if end > outer { outer } else { inner };
    let (nearest, farthest) = ((distance - lever.abs()).abs(), distance + lever.abs());
    if !(nearest <= outer + REACH && farthest >= inner - REACH) {
        return None;
    }
    // From the direction of the point to the lever, for which its end is on the border.
    let cos = (border * border - distance * distance - lever * lever) / (2.0 * distance * lever);
    let open = atan2(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), cos);
    let [a, b] = [open, -open].map(|open| wrapped(atan2(y, x) + open - angle));
    let turn = if a.abs() <= b.abs() { a } else { b };
    turn.is_finite().then_some(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// On its axis a shoulder turns as it likes, and the point lies neither before nor behind it.
    #[test]
    fn a_point_on_the_axis_leaves_the_turn_free() {
        let [(turn, along), (opposite, back)] = shoulder(&Vector3::new(0.0, 0.0, 300.0), 0.0, 0.7).unwrap();
        assert!((turn.angle - 0.7).abs() < 1e-15 && along.abs() < 1e-15 && back.abs() < 1e-15);
        assert!((turn.cos + opposite.cos).abs() < 1e-15 && (turn.sin + opposite.sin).abs() < 1e-15);
    }

    /// A lever that swings turns just so far that its end is in reach; where no turn will do it says so.
    #[test]
    fn a_lever_swings_to_the_border_of_the_reach() {
        let end = |x: f64, lever: f64, angle: f64| (x + lever * angle.cos()).hypot(lever * angle.sin());
        // Two links of 3 and 2: reach from 1 to 5.
        let turn = swing(5.5, 0.0, 1.0, 0.4, 3.0, 2.0).unwrap();
        assert!(turn.abs() <= PI && (end(5.5, 1.0, 0.4 + turn) - 5.0).abs() < 1e-3, "{turn}");
        let turn = swing(0.9, 0.0, 0.5, 2.0, 3.0, 2.0).unwrap();
        assert!((end(0.9, 0.5, 2.0 + turn) - 1.0).abs() < 1e-3, "{turn}");
        assert_eq!(swing(6.5, 0.0, 1.0, 0.4, 3.0, 2.0), None, "too far away");
        assert_eq!(swing(0.3, 0.0, 0.2, 0.4, 3.0, 2.0), None, "too near");
    }
}
