//! Arms of the UR type in closed form: axes 2, 3 and 4 parallel, axes 1 and 2, 4 and 5, 5 and 6 crossing at right
//! angles.
//!
//! Derived from the table `T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)` with `alpha = 90, 0, 0, 90, -90, 0` degrees.
//! The normal of the arm's plane is `n = (sin q1, -cos q1, 0)`; the point where axes 5 and 6 cross lies at `d2 + d3 +
//! d4` along it, which gives joint 1. In the flange frame `n` is `(s5 c6, -s5 s6, c5)`, which gives joints 5 and 6 to
//! all digits even where `s5` is small; axis 5 then gives `q2 + q3 + q4`, and upper arm and forearm make a triangle.
//!
//! At a singular wrist joint 6 is free and carries the end of the forearm about the point where axes 5 and 6 cross, at
//! the distance `d5`. Not every joint 6 leaves it in reach: where the given one does not, the nearest that does is
//! taken, so that no pose within reach is lost.

use super::branches::{Branch, Solutions, slot};
use super::dh::DhTable;
use super::numbers::{ANGLE_ROUNDING, ANGLE_TOLERANCE, Frames, HELD, MovedAxes, POSITION_TOLERANCE};
use super::planar::{Free, aim, bend, lift, shoulder, swing};
use crate::trig::{atan2, sin_cos};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UrArm {
    table: DhTable,
    /// The sum of the offsets along the parallel axes.
    across: f64,
}

/// The plane in which upper arm and forearm move: its level direction, its normal, and axis 5 in it.
struct Plane {
    along: Vector3<f64>,
    normal: Vector3<f64>,
    axis5: Vector3<f64>,
}

impl UrArm {
    pub fn new(table: &DhTable) -> Self {
        UrArm { table: *table, across: table.d[1] + table.d[2] + table.d[3] }
    }

    pub fn forward(&self, q: &[f64; 6]) -> (Matrix3<f64>, Vector3<f64>) {
        let (d, a) = (&self.table.d, &self.table.a);
        let (s2, c2) = sin_cos(q[1]);
        let (s23, c23) = sin_cos(q[1] + q[2]);
        let (rotation, plane) = self.rotation(q[0], q[1] + q[2] + q[3], q[4], q[5]);
        let along = a[1] * c2 + a[2] * c23;
        let wrist = Vector3::new(along * plane.along.x, along * plane.along.y, d[0] + a[1] * s2 + a[2] * s23);
        let position = wrist + plane.normal * self.across + plane.axis5 * d[4] + rotation.column(2) * d[5];
        (rotation, position)
    }

    /// Drops solutions that do not meet the pose. As all forward kinematics, but what solutions share is computed
    /// once: joint 1 and the plane for each side of the shoulder, the wrist for each flip; the elbow's twins then
    /// differ in a triangle only.
    pub fn verify(&self, r: &Matrix3<f64>, p: &Vector3<f64>, found: &mut Solutions) {
        let (d, a) = (&self.table.d, &self.table.a);
        for (back, flip) in [(false, false), (false, true), (true, false), (true, true)] {
            let twins = [slot(back, false, flip), slot(back, true, flip)];
            let Some(shared) = twins.iter().find_map(|&slot| found.at(slot)).copied() else { continue };
            let sum = shared[1] + shared[2] + shared[3];
            let (rotation, plane) = self.rotation(shared[0], sum, shared[4], shared[5]);
            let turned_right = (rotation - r).norm_squared() <= 2.0 * (HELD * ANGLE_TOLERANCE).powi(2);
            // What upper arm and forearm have left to reach.
            let rest = p - rotation.column(2) * d[5] - plane.axis5 * d[4] - plane.normal * self.across;
            for slot in twins {
                let Some(q) = found.at(slot) else { continue };
                let (s2, c2) = sin_cos(q[1]);
                let (s23, c23) = sin_cos(q[1] + q[2]);
                let (along, up) = (a[1] * c2 + a[2] * c23, d[0] + a[1] * s2 + a[2] * s23);
                let off = rest - Vector3::new(along * plane.along.x, along * plane.along.y, up);
                let same_sum = (q[1] + q[2] + q[3] - sum).abs() <= ANGLE_ROUNDING;
                if !(turned_right && same_sum && off.norm_squared() <= (HELD * POSITION_TOLERANCE).powi(2)) {
                    found.remove(Branch::ALL[slot]);
                }
            }
        }
    }

    /// The flange's rotation by joint 1, the sum of joints 2 to 4, joint 5 and joint 6, and the arm's plane.
    fn rotation(&self, q1: f64, q234: f64, q5: f64, q6: f64) -> (Matrix3<f64>, Plane) {
        let (s1, c1) = sin_cos(q1);
        let (s234, c234) = sin_cos(q234);
        let (s5, c5) = sin_cos(q5);
        let (s6, c6) = sin_cos(q6);
        let normal = Vector3::new(s1, -c1, 0.0);
        let x4 = Vector3::new(c234 * c1, c234 * s1, s234);
        let z4 = Vector3::new(s234 * c1, s234 * s1, -c234);
        let x5 = x4 * c5 + normal * s5;
        let z6 = normal * c5 - x4 * s5;
        let plane = Plane { along: Vector3::new(c1, s1, 0.0), normal, axis5: z4 };
        (Matrix3::from_columns(&[x5 * c6 - z4 * s6, -x5 * s6 - z4 * c6, z6]), plane)
    }

    pub fn longest_link(&self) -> f64 {
        self.table.a[1].abs().max(self.table.a[2].abs())
    }

    pub fn frames(&self, q: &[f64; 6], moved: Option<&MovedAxes>) -> Frames {
        self.table.frames(q, moved)
    }

    /// Axis of each joint: a point on it, and its direction.
    pub fn axes(&self, q: &[f64; 6], moved: Option<&MovedAxes>) -> [(Vector3<f64>, Vector3<f64>); 6] {
        let frames = self.frames(q, moved);
        [0, 1, 2, 3, 4, 5].map(|k| (frames[k].1, frames[k].0.column(2).into_owned()))
    }

    pub fn branch(&self, q: &[f64; 6]) -> Branch {
        let (d, a) = (&self.table.d, &self.table.a);
        let along = a[1] * q[1].cos() + a[2] * (q[1] + q[2]).cos() + d[4] * (q[1] + q[2] + q[3]).sin();
        Branch::of(along * a[1].signum() < 0.0, a[2] * q[2].sin() > 0.0, q[4].sin() < 0.0)
    }

    pub fn solve(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free, found: &mut Solutions) -> bool {
        let (d, a) = (&self.table.d, &self.table.a);
        let (x6, y6, z6) = (r.column(0), r.column(1), r.column(2));
        let crossing = p - z6 * d[5];
        let Some(shoulders) = shoulder(&crossing, self.across, free.joints[0]) else { return false };
        let mut folded = shoulders[0].1.abs() <= FOLD * self.across.abs();
        let up = crossing.z - d[0];
        for (side, (q1, along)) in shoulders.into_iter().enumerate() {
            // The first is that with the crossing on the side of x; the links of a UR arm point the other way at zero.
            let back = (side == 1) != (a[1] < 0.0);
            let v = [x6, y6, z6].map(|axis| q1.sin * axis.x - q1.cos * axis.y);
            let (q6, q5, free_wrist) = aim(v[0], -v[1], v[2], free.joints[5], free.wrist);
            let z4 = -(x6 * q6.sin + y6 * q6.cos);
            let (s234, c234) = (z4.x * q1.cos + z4.y * q1.sin, -z4.z);
            let q234 = atan2(s234, c234);
            for (flip, sense, half_turn) in [(false, 1.0, 0.0), (true, -1.0, PI)] {
                let (mut q5, mut q6, mut q234) = (sense * q5, q6.angle + half_turn, q234 + half_turn);
                let (mut x, mut y) = (along - sense * d[4] * s234, up + sense * d[4] * c234);
                let mut triangle = bend((x * x + y * y).sqrt(), a[1], a[2]);
                if triangle.is_none() && free_wrist && free.swings {
                    let Some(turn) = swing(along, up, d[4], q234 + FRAC_PI_2, a[1], a[2]) else { continue };
                    // Joint 6 turns against joints 2 to 4, or with them where joint 5 has made half a turn.
                    (q5, q6, q234) = (if v[2] > 0.0 { 0.0 } else { PI }, q6 - turn * v[2].signum(), q234 + turn);
                    let (sin, cos) = sin_cos(q234);
                    (x, y) = (along - d[4] * sin, up + d[4] * cos);
                    triangle = bend((x * x + y * y).sqrt(), a[1], a[2]);
                }
                let Some((cos, sin)) = triangle else { continue };
                let q3 = atan2(sin, cos);
                folded |= sin <= FOLD;
                for down in [false, true] {
                    let sign = if down { a[2].signum() } else { -a[2].signum() };
                    let q2 = lift(x, y, a[1], a[2], (cos, sign * sin), free.joints[1]);
                    let q4 = q234 - q2.angle - sign * q3;
                    found.put(slot(back, down, flip), [q1.angle, q2.angle, sign * q3, q4, q5, q6]);
                }
            }
        }
        folded
    }
}

/// Below this sine two branches may have come together; above it they are surely apart.
const FOLD: f64 = 1e-5;
