//! Motions in joint space: a cubic for every joint, of which the straight motion is a special case.
//!
//! A motion is given by its Bezier control points `c0..c3`, one polygon for all joints; `t` runs from 0 to 1. It is stored
//! as `c0 + b1 t + b2 t^2 + b3 t^3`. About the middle `m` of an interval of half-width `h`, with `v` from -1 to 1,
//! a joint is at `q(m) + A v + B v^2 + C v^3`, where
//!
//! `A = h (b1 + 2 b2 m + 3 b3 m^2)`, `B = h^2 (b2 + 3 b3 m)`, `C = h^3 b3`.
//!
//! The interval's own control points, less `q(m)`, are `-A + B - C`, `-A/3 - B/3 + C`, `A/3 - B/3 - C` and `A + B + C`:
//! those that de Casteljau's algorithm gives, without its chain of averages and without anything to store per interval. The
//! curve lies in their hull (G. Farin, *Curves and Surfaces for CAGD*, 5th ed. 2002, sections 4.3 and 5.1), so no joint is
//! farther from where it is at the middle than
//!
//! `max(|A + C| + |B|, |A/3 - C| + |B|/3)`.
//!
//! Of a straight motion `B` and `C` are 0, and that is what the joint turns in half the interval.

use super::query::Posture;
use super::rounding::SHARE;
use crate::arm::Arm;

/// How far links turn against each other: of the arm and of the table, in radians. Of an arm that is not coupled that is how far joints turn.
pub(super) type Turns = ([f64; 6], [f64; 2]);

/// A motion of all joints.
pub(super) struct Motion {
    arm: Cubic<6>,
    /// The angles between links, where they are not the joints.
    links: Option<Cubic<6>>,
    table: Cubic<2>,
}

impl Motion {
    /// All joints evenly from one posture to another.
    pub fn straight(arm: &Arm, from: &Posture, to: &Posture) -> Self {
        let links =
            arm.is_coupled().then(|| Cubic::straight(&arm.between_links(&from.joints), &arm.between_links(&to.joints)));
        Motion { arm: Cubic::straight(&from.joints, &to.joints), links, table: Cubic::straight(&from.table, &to.table) }
    }

    pub fn bezier(arm: &Arm, control: &[Posture; 4]) -> Self {
        let links = arm.is_coupled().then(|| Cubic::bezier(&control.map(|c| arm.between_links(&c.joints))));
        Motion {
            arm: Cubic::bezier(&control.map(|c| c.joints)),
            links,
            table: Cubic::bezier(&control.map(|c| c.table)),
        }
    }

    fn links(&self) -> &Cubic<6> {
        self.links.as_ref().unwrap_or(&self.arm)
    }

    pub fn at(&self, t: f64) -> Posture {
        Posture { joints: self.arm.at(t), table: self.table.at(t) }
    }

    /// How far each link turns against the one before along the control polygon: at least as far as along the motion.
    pub fn lengths(&self) -> Turns {
        (self.links().length, self.table.length)
    }

    /// How far each of these angles ever is from what it is at the middle of an interval of this half-width, at most.
    pub fn turns(&self, middle: f64, half: f64) -> Turns {
        (self.links().turns(middle, half), self.table.turns(middle, half))
    }
}

/// A cubic for each of some joints.
struct Cubic<const N: usize> {
    /// Where it starts: `c0`.
    start: [f64; N],
    /// `b1`, `b2`, `b3` of each joint.
    powers: [[f64; 3]; N],
    /// The length of each joint's control polygon.
    length: [f64; N],
}

impl<const N: usize> Cubic<N> {
    fn straight(from: &[f64; N], to: &[f64; N]) -> Self {
        let way: [f64; N] = std::array::from_fn(|k| to[k] - from[k]);
        Cubic { start: *from, powers: way.map(|way| [way, 0.0, 0.0]), length: way.map(f64::abs) }
    }

    fn bezier(control: &[[f64; N]; 4]) -> Self {
        let edges = |k: usize| [0, 1, 2].map(|i| control[i + 1][k] - control[i][k]);
        let power = |k: usize| {
            let [a, b, c] = edges(k);
            [3.0 * a, 3.0 * (b - a), (c - b) - (b - a)]
        };
        let length = |k: usize| edges(k).iter().map(|edge| edge.abs()).sum();
        Cubic { start: control[0], powers: std::array::from_fn(power), length: std::array::from_fn(length) }
    }

    fn at(&self, t: f64) -> [f64; N] {
        std::array::from_fn(|k| {
            let [b1, b2, b3] = self.powers[k];
            self.start[k] + (b1 + (b2 + b3 * t) * t) * t
        })
    }

    #[inline]
    fn turns(&self, m: f64, h: f64) -> [f64; N] {
        self.powers.map(|[b1, b2, b3]| {
            let (a, b, c) = (h * (b1 + (2.0 * b2 + 3.0 * b3 * m) * m), h * h * (b2 + 3.0 * b3 * m), h * h * h * b3);
            let hull = ((a + c).abs() + b.abs()).max((a / 3.0 - c).abs() + b.abs() / 3.0);
            hull + SHARE * h * (b1.abs() + 2.0 * b2.abs() + 3.0 * b3.abs())
        })
    }
}

/// Bezier control points of the cubic with given postures and rates at its ends, as a spline has them at its knots.
///
/// # Arguments
/// * `from`, `to`: where it starts and ends.
/// * `from_rate`, `to_rate`: how fast each joint turns there, in rad/s, in the place of its angle.
/// * `seconds`: how long it takes.
///
/// # Returns
/// `q0`, `q0 + v0 h/3`, `q1 - v1 h/3`, `q1`, for [`Scene::sweep_cubic`](super::Scene::sweep_cubic), which refuses what is
/// not finite.
///
/// # Example
/// ```
/// use curvlay_kinematics::scene::{Posture, cubic_control};
/// // From rest to rest: joint 1 is half way after half the time, and lags behind at first.
/// let (from, to, rest) = ([0.0; 6].into(), [1.2, 0.0, 0.0, 0.0, 0.0, 0.0].into(), Posture::from([0.0; 6]));
/// let control = cubic_control(&from, &rest, &to, &rest, 2.0);
/// assert_eq!(control.map(|c| c.joints[0]), [0.0, 0.0, 1.2, 1.2]);
/// // 0.9 rad/s at the end, for 2 s.
/// let control = cubic_control(&from, &rest, &to, &[0.9, 0.0, 0.0, 0.0, 0.0, 0.0].into(), 2.0);
/// assert!((control[2].joints[0] - 0.6).abs() < 1e-15);
/// ```
pub fn cubic_control(
    from: &Posture,
    from_rate: &Posture,
    to: &Posture,
    to_rate: &Posture,
    seconds: f64,
) -> [Posture; 4] {
    let third = seconds / 3.0;
    let moved = |at: &Posture, rate: &Posture, time: f64| Posture {
        joints: std::array::from_fn(|k| at.joints[k] + rate.joints[k] * time),
        table: std::array::from_fn(|k| at.table[k] + rate.table[k] * time),
    };
    [*from, moved(from, from_rate, third), moved(to, to_rate, -third), *to]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Halves a control polygon at the middle, again and again, down to the interval asked for.
    fn de_casteljau(control: [f64; 4], m: f64, h: f64) -> [f64; 4] {
        let split = |c: [f64; 4], t: f64| {
            let mix = |a: f64, b: f64| a + (b - a) * t;
            let (p, q, r) = (mix(c[0], c[1]), mix(c[1], c[2]), mix(c[2], c[3]));
            let (u, v) = (mix(p, q), mix(q, r));
            let w = mix(u, v);
            ([c[0], p, u, w], [w, v, r, c[3]])
        };
        let (low, high) = (m - h, m + h);
        let (_, late) = split(control, low);
        split(late, (high - low) / (1.0 - low)).0
    }

    proptest! {
        #[test]
        fn turns_are_those_of_the_interval_s_own_control_points(
            control in prop::array::uniform4(-3.0..3.0f64), depth in 0u32..12, place in 0.0..1.0f64,
        ) {
            let h = 0.5f64.powi(depth as i32 + 1);
            let m = ((place * 0.5 / h).floor() * 2.0 + 1.0) * h;
            let cubic = Cubic::<1>::bezier(&control.map(|c| [c]));
            let own = de_casteljau(control, m, h);
            let middle = cubic.at(m)[0];
            let expected = own.iter().map(|c| (c - middle).abs()).fold(0.0, f64::max);
            let turn = cubic.turns(m, h)[0];
            prop_assert!((turn - expected).abs() <= 1e-10, "{turn} {expected}");
            for k in 0..=40 {
                let t = m + h * (f64::from(k) / 20.0 - 1.0);
                prop_assert!((cubic.at(t)[0] - middle).abs() <= turn + 1e-14, "{t}");
            }
            prop_assert!((cubic.at(1.0)[0] - control[3]).abs() <= 1e-14);
            // What ends the halving.
            prop_assert!(turn <= 3.0 * h * cubic.length[0] * (1.0 + 1e-9));
        }

        #[test]
        fn straight_ones_turn_evenly(from in -3.0..3.0f64, to in -3.0..3.0f64, m in 0.0..1.0f64, h in 0.0..0.5f64) {
            let cubic = Cubic::straight(&[from], &[to]);
            let turn = cubic.turns(m, h)[0];
            prop_assert!(turn >= (to - from).abs() * h && turn <= (to - from).abs() * h * (1.0 + 1e-11));
        }
    }
}
