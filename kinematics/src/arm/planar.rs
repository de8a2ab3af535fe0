//! The two steps that all our arms share: the turn of joint 1, and the triangle of upper arm and forearm.
//!
//! Both have two solutions that come together at a singularity. Differences of squares are factorised, so that their
//! roots keep all digits there.

use nalgebra::Vector3;

/// A point this far out of reach is reached, in millimetres: rounding, and below what a pose is checked for.
pub(super) const REACH: f64 = 1e-7;

/// A point this little farther from axis 1 than the arm's plane, as a share of the distance, is where the two sides of the
/// shoulder meet. Rounding would leave 1e-8 rad between them, and that hides a singular wrist; the share leaves
/// joint 1 within 1e-7 rad.
const FOLDED: f64 = 5e-15;

/// Cosine, sine and angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub cos: f64,
    pub sin: f64,
    pub angle: f64,
}

impl Turn {
    pub fn of(angle: f64) -> Turn {
        let (sin, cos) = angle.sin_cos();
        Turn { cos, sin, angle }
    }

    /// Half a turn farther.
    pub fn opposite(self) -> Turn {
        Turn { cos: -self.cos, sin: -self.sin, angle: self.angle + std::f64::consts::PI }
    }

    fn towards(cos: f64, sin: f64) -> Turn {
        let length = (cos * cos + sin * sin).sqrt();
        Turn { cos: cos / length, sin: sin / length, angle: sin.atan2(cos) }
    }
}

/// Joint 1 turns the arm's plane, which passes axis 1 at the distance `across`, through the point. The plane's normal is
/// `(sin, -cos)`; the point's coordinate along `(cos, sin)` comes with each turn, first the one that is not negative.
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

/// The angle between the two links that reach a point at `distance`: cosine and sine, the sine not negative. Links may have
/// any sign.
pub(super) fn bend(distance: f64, first: f64, second: f64) -> Option<(f64, f64)> {
    let (outer, inner) = (first.abs() + second.abs(), (first.abs() - second.abs()).abs());
    if !(distance <= outer + REACH && distance >= inner - REACH) {
        return None;
    }
    let square = (outer - distance).max(0.0) * (outer + distance) * (distance - inner).max(0.0) * (distance + inner);
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
