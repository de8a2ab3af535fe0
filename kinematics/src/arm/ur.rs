//! Arms of the UR type in closed form: axes 2, 3 and 4 parallel, axes 1 and 2, 4 and 5, 5 and 6 crossing at right angles.
//!
//! Derived from the table `T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)` with `alpha = 90, 0, 0, 90, -90, 0` degrees. The
//! normal of the arm's plane is `n = (sin q1, -cos q1, 0)`; the point where axes 5 and 6 cross lies at `d2 + d3 + d4` along
//! it, which gives joint 1. In the flange frame `n` is `(s5 c6, -s5 s6, c5)`, which gives joints 5 and 6 to all digits
//! even where `s5` is small; axis 5 then gives `q2 + q3 + q4`, and upper arm and forearm make a triangle.

use super::branches::{Branch, Solutions, slot};
use super::dh::DhTable;
use super::planar::{Turn, bend, lift, shoulder};
use super::{Frames, WRIST};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UrArm {
    table: DhTable,
    /// The sum of the offsets along the parallel axes.
    across: f64,
}

impl UrArm {
    pub fn new(table: &DhTable) -> Self {
        UrArm { table: *table, across: table.d[1] + table.d[2] + table.d[3] }
    }

    pub fn forward(&self, q: &[f64; 6]) -> (Matrix3<f64>, Vector3<f64>) {
        let (d, a) = (&self.table.d, &self.table.a);
        let (s1, c1) = q[0].sin_cos();
        let (s2, c2) = q[1].sin_cos();
        let (s23, c23) = (q[1] + q[2]).sin_cos();
        let (s234, c234) = (q[1] + q[2] + q[3]).sin_cos();
        let (s5, c5) = q[4].sin_cos();
        let (s6, c6) = q[5].sin_cos();
        let x1 = Vector3::new(c1, s1, 0.0);
        let n = Vector3::new(s1, -c1, 0.0);
        let in_plane = |along: f64, up: f64| Vector3::new(along * x1.x, along * x1.y, up);
        let z4 = in_plane(s234, -c234);
        let x4 = in_plane(c234, s234);
        let x5 = x4 * c5 + n * s5;
        let z6 = n * c5 - x4 * s5;
        let elbow = in_plane(a[1] * c2 + a[2] * c23, d[0] + a[1] * s2 + a[2] * s23);
        let position = elbow + n * self.across + z4 * d[4] + z6 * d[5];
        (Matrix3::from_columns(&[x5 * c6 - z4 * s6, -x5 * s6 - z4 * c6, z6]), position)
    }

    pub fn longest_link(&self) -> f64 {
        self.table.a[1].abs().max(self.table.a[2].abs())
    }

    pub fn frames(&self, q: &[f64; 6]) -> Frames {
        self.table.frames(q)
    }

    /// Axis of each joint: a point on it, and its direction.
    pub fn axes(&self, q: &[f64; 6]) -> [(Vector3<f64>, Vector3<f64>); 6] {
        let frames = self.frames(q);
        [0, 1, 2, 3, 4, 5].map(|k| (frames[k].1, frames[k].0.column(2).into_owned()))
    }

    pub fn branch(&self, q: &[f64; 6]) -> Branch {
        let (d, a) = (&self.table.d, &self.table.a);
        let along = a[1] * q[1].cos() + a[2] * (q[1] + q[2]).cos() + d[4] * (q[1] + q[2] + q[3]).sin();
        Branch::of(along * a[1].signum() < 0.0, a[2] * q[2].sin() > 0.0, q[4].sin() < 0.0)
    }

    pub fn solve(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &[f64; 6], found: &mut Solutions) -> bool {
        let (d, a) = (&self.table.d, &self.table.a);
        let (x6, y6, z6) = (r.column(0), r.column(1), r.column(2));
        let crossing = p - z6 * d[5];
        let Some(shoulders) = shoulder(&crossing, self.across, free[0]) else { return false };
        let mut folded = shoulders[0].1.abs() <= FOLD * self.across.abs();
        let up = crossing.z - d[0];
        for (turned, along) in shoulders {
            let back = (along < 0.0) != (a[1] < 0.0);
            let q1 = turned;
            let v = [x6, y6, z6].map(|axis| q1.sin * axis.x - q1.cos * axis.y);
            let s5 = (v[0] * v[0] + v[1] * v[1]).sqrt();
            let (q5, q6) = if s5 > WRIST {
                let q6 = Turn { cos: v[0] / s5, sin: -v[1] / s5, angle: (-v[1]).atan2(v[0]) };
                (s5.atan2(v[2]), q6)
            } else {
                (if v[2] > 0.0 { 0.0 } else { PI }, Turn::of(free[5]))
            };
            let z4 = -(x6 * q6.sin + y6 * q6.cos);
            let (s234, c234) = (z4.x * q1.cos + z4.y * q1.sin, -z4.z);
            let q234 = s234.atan2(c234);
            for (flip, sense, half_turn) in [(false, 1.0, 0.0), (true, -1.0, PI)] {
                let (x, y) = (along - sense * d[4] * s234, up + sense * d[4] * c234);
                let Some((cos, sin)) = bend((x * x + y * y).sqrt(), a[1], a[2]) else { continue };
                let q3 = sin.atan2(cos);
                folded |= sin <= FOLD;
                for down in [false, true] {
                    let sign = if down { a[2].signum() } else { -a[2].signum() };
                    let q2 = lift(x, y, a[1], a[2], (cos, sign * sin), free[1]);
                    let q4 = q234 + half_turn - q2.angle - sign * q3;
                    let joints = [q1.angle, q2.angle, sign * q3, q4, sense * q5, q6.angle + half_turn];
                    found.put(slot(back, down, flip), joints);
                }
            }
        }
        folded
    }
}

/// Below this sine two branches may have come together; above it they are surely apart.
const FOLD: f64 = 1e-5;
