//! Ortho-parallel arms with a spherical wrist in closed form: most industrial arms.
//!
//! M. Brandstoetter, A. Angerer, M. Hofbaur, "An analytical solution of the inverse kinematics problem of industrial
//! serial manipulators with an ortho-parallel basis and a spherical wrist", Austrian Robotics Workshop 2014: the seven
//! lengths `a1, a2, b, c1, c2, c3, c4` and their meaning. The solution here departs from it: joints 4 to 6 come
//! from one column of the wrist's rotation and, given joint 4, from the axis of joint 5, so that their sum keeps all
//! digits where axes 4 and 6 are nearly parallel.
//!
//! At zero all links stand upright. Then axis 1 points up, axes 2, 3 and 5 along y, axes 4 and 6 up.

use super::branches::{Branch, Solutions, slot};
use super::error::{ArmError, within_reach};
use super::numbers::{ANGLE_ROUNDING, Frames, HELD, MIN_LINK_MM, MovedAxes, meets};
use super::planar::{Free, REACH, Turn, aim, bend, shoulder};
use crate::trig::{atan2, sin_cos};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The lengths of an ortho-parallel arm, in millimetres, at the posture with all links upright, where all angles are zero:
/// axis 1 points up, axes 2, 3 and 5 along y, axes 4 and 6 up.
///
/// M. Brandstoetter, A. Angerer, M. Hofbaur, "An analytical solution of the inverse kinematics problem of industrial serial
/// manipulators with an ortho-parallel basis and a spherical wrist", Austrian Robotics Workshop 2014.
/// These are the numbers that collections of robots print under the same names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthoLengths {
    /// Axis 2 in front of axis 1.
    pub a1: f64,
    /// Wrist centre in front of axis 3; negative on most arms.
    pub a2: f64,
    /// Wrist centre beside axis 1, along y.
    pub b: f64,
    /// Axis 2 above the floor.
    pub c1: f64,
    /// Axis 3 above axis 2.
    pub c2: f64,
    /// Wrist centre above axis 3.
    pub c3: f64,
    /// Flange above the wrist centre.
    pub c4: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OrthoArm {
    lengths: OrthoLengths,
    /// From axis 3 to the wrist centre: the distance, and the cosine, sine and angle of its lean against the forearm.
    forearm: f64,
    lean: (f64, f64, f64),
}

impl OrthoLengths {
    pub(super) fn check(&self) -> Result<(), ArmError> {
        let OrthoLengths { a1, a2, b, c1, c2, c3, c4 } = *self;
        let named = [("a1", a1), ("a2", a2), ("b", b), ("c1", c1), ("c2", c2), ("c3", c3), ("c4", c4)];
        for (what, value) in named {
            if !value.is_finite() {
                return Err(ArmError::LengthNotFinite { what, value });
            }
            within_reach(what, value)?;
        }
        if c2.abs() < MIN_LINK_MM {
            return Err(ArmError::NoLength { link: "upper arm" });
        }
        if a2.hypot(c3) < MIN_LINK_MM {
            return Err(ArmError::NoLength { link: "forearm" });
        }
        Ok(())
    }
}

impl OrthoArm {
    pub fn new(lengths: &OrthoLengths) -> Self {
        let forearm = lengths.a2.hypot(lengths.c3);
        let lean = (lengths.c3 / forearm, lengths.a2 / forearm, lengths.a2.atan2(lengths.c3));
        OrthoArm { lengths: *lengths, forearm, lean }
    }

    pub fn forward(&self, q: &[f64; 6]) -> (Matrix3<f64>, Vector3<f64>) {
        let OrthoLengths { a1, a2, b, c1, c2, c3, c4 } = self.lengths;
        let (s1, cos1) = sin_cos(q[0]);
        let (s2, cos2) = sin_cos(q[1]);
        let (s23, c23) = sin_cos(q[1] + q[2]);
        let (s4, cos4) = sin_cos(q[3]);
        let (s5, c5) = sin_cos(q[4]);
        let (s6, c6) = sin_cos(q[5]);
        let (along, up) = (a1 + c2 * s2 + a2 * c23 + c3 * s23, c1 + c2 * cos2 - a2 * s23 + c3 * c23);
        let wrist = Vector3::new(along * cos1 - b * s1, along * s1 + b * cos1, up);
        let x3 = Vector3::new(cos1 * c23, s1 * c23, -s23);
        let y3 = Vector3::new(-s1, cos1, 0.0);
        let z3 = Vector3::new(cos1 * s23, s1 * s23, c23);
        let x4 = x3 * cos4 + y3 * s4;
        let y4 = y3 * cos4 - x3 * s4;
        let x5 = x4 * c5 - z3 * s5;
        let z6 = x4 * s5 + z3 * c5;
        (Matrix3::from_columns(&[x5 * c6 + y4 * s6, y4 * c6 - x5 * s6, z6]), wrist + z6 * c4)
    }

    /// Drops solutions that do not meet the pose. A flipped wrist differs from its twin by half turns of joints 4 and
    /// 6 and the sign of joint 5, which change the flange by rounding alone; so that is checked, and the twin's pose.
    pub fn verify(&self, r: &Matrix3<f64>, p: &Vector3<f64>, found: &mut Solutions) {
        for slot in [0, 2, 4, 6] {
            let (twin, flipped) = (found.at(slot).copied(), found.at(slot + 1).copied());
            let kept = twin.is_some_and(|q| meets(&self.forward(&q), r, p, HELD));
            let is_twin = |q: [f64; 6], f: [f64; 6]| {
                let apart = [f[0] - q[0], f[1] - q[1], f[2] - q[2], f[3] - q[3] - PI, f[4] + q[4], f[5] - q[5] - PI];
                apart.iter().all(|angle| angle.abs() <= ANGLE_ROUNDING)
            };
            let both = kept && twin.zip(flipped).is_some_and(|(q, f)| is_twin(q, f));
            if !kept {
                found.remove(Branch::ALL[slot]);
            }
            if !both && !flipped.is_some_and(|f| meets(&self.forward(&f), r, p, HELD)) {
                found.remove(Branch::ALL[slot + 1]);
            }
        }
    }

    pub fn longest_link(&self) -> f64 {
        self.lengths.c2.abs().max(self.forearm)
    }

    /// Base; shoulder, where joint 2 turns; upper arm, at joint 2; forearm, at joint 3; wrist centre twice; flange. Those of a
    /// calibrated arm with axes 2 to 6 moved.
    pub fn frames(&self, q: &[f64; 6], moved: Option<&MovedAxes>) -> Frames {
        let OrthoLengths { a1, a2, b, c1, c2, c3, c4 } = self.lengths;
        let mut frames = [(Matrix3::identity(), Vector3::zeros()); 7];
        let steps = [
            (false, Vector3::new(0.0, 0.0, c1)),
            (true, Vector3::new(a1, b, 0.0)),
            (true, Vector3::new(0.0, 0.0, c2)),
            (false, Vector3::new(a2, 0.0, c3)),
            (true, Vector3::zeros()),
            (false, Vector3::new(0.0, 0.0, c4)),
        ];
        for (k, (about_y, offset)) in steps.into_iter().enumerate() {
            let (mut r, mut p) = (frames[k].0, frames[k].1 + frames[k].0 * offset);
            if let Some((turn, shift)) = moved.zip(k.checked_sub(1)).map(|(axes, axis)| axes[axis]) {
                (r, p) = (r * turn, p + r * shift);
            }
            let (sin, cos) = sin_cos(q[k]);
            let (x, y, z) = (r.column(0), r.column(1), r.column(2));
            let turned = if about_y {
                Matrix3::from_columns(&[x * cos - z * sin, y.into_owned(), z * cos + x * sin])
            } else {
                Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, z.into_owned()])
            };
            frames[k + 1] = (turned, p);
        }
        frames
    }

    /// Axis of each joint: a point on it, and its direction.
    pub fn axes(&self, q: &[f64; 6], moved: Option<&MovedAxes>) -> [(Vector3<f64>, Vector3<f64>); 6] {
        let frames = self.frames(q, moved);
        let columns = [2, 1, 1, 2, 1, 2];
        [0, 1, 2, 3, 4, 5].map(|k| (frames[k + 1].1, frames[k + 1].0.column(columns[k]).into_owned()))
    }

    pub fn branch(&self, q: &[f64; 6]) -> Branch {
        let OrthoLengths { a1, a2, c2, c3, .. } = self.lengths;
        let (s23, c23) = sin_cos(q[1] + q[2]);
        let along = a1 + c2 * q[1].sin() + a2 * c23 + c3 * s23;
        Branch::of(along < 0.0, (q[2] + self.lean.2).sin() * c2.signum() < 0.0, q[4].sin() < 0.0)
    }

    pub fn solve(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free, found: &mut Solutions) -> bool {
        let OrthoLengths { c1, c2, c4, .. } = self.lengths;
        let (x6, y6, z6) = (r.column(0), r.column(1), r.column(2));
        let wrist = p - z6 * c4;
        let Some((lanes, folded)) = self.lanes(r, &wrist, free) else { return false };
        let up = wrist.z - c1;
        let Lanes { cos, sin, along, x1, y1, .. } = &lanes;
        // Angles of links are counted from upright: up takes the place of x, forward that of y.
        let near = each(|k| c2 + self.forearm * cos[k]);
        let off = each(|k| self.forearm * sin[k]);
        let mut cos2 = each(|k| up * near[k] + along[k] * off[k]);
        let mut sin2 = each(|k| along[k] * near[k] - up * off[k]);
        let mut q2 = each(|k| atan2(sin2[k], cos2[k]));
        let between = each(|k| atan2(sin[k], cos[k]));
        for k in 0..4 {
            if along[k] * along[k] + up * up <= REACH * REACH {
                let turn = Turn::of(free.joints[1]);
                (cos2[k], sin2[k], q2[k]) = (turn.cos, turn.sin, turn.angle);
            }
        }
        let length = each(|k| 1.0 / (cos2[k] * cos2[k] + sin2[k] * sin2[k]).sqrt());
        let (cos2, sin2) = (each(|k| cos2[k] * length[k]), each(|k| sin2[k] * length[k]));
        let (s, c) = (each(|k| sin2[k] * cos[k] + cos2[k] * sin[k]), each(|k| cos2[k] * cos[k] - sin2[k] * sin[k]));
        let s23 = each(|k| s[k] * self.lean.0 - c[k] * self.lean.1);
        let c23 = each(|k| c[k] * self.lean.0 + s[k] * self.lean.1);
        // The flange's axis in the frame of the forearm.
        let x = each(|k| x1[2][k] * c23[k] - z6.z * s23[k]);
        let y = y1[2];
        let z = each(|k| x1[2][k] * s23[k] + z6.z * c23[k]);
        let sine = each(|k| (x[k] * x[k] + y[k] * y[k]).sqrt());
        let (mut cos4, mut sin4) = (each(|k| x[k] / sine[k]), each(|k| y[k] / sine[k]));
        let mut q4 = each(|k| atan2(y[k], x[k]));
        let mut q5 = each(|k| atan2(sine[k], z[k]));
        for k in 0..4 {
            if lanes.reached[k] && sine[k] <= free.wrist {
                let (turn, bent, _) = aim(x[k], y[k], z[k], free.joints[3], free.wrist);
                (cos4[k], sin4[k], q4[k], q5[k]) = (turn.cos, turn.sin, turn.angle, bent);
            }
        }
        // Axis 5 in the flange.
        let across = each(|k| y1[0][k] * cos4[k] - (x1[0][k] * c23[k] - x6.z * s23[k]) * sin4[k]);
        let ahead = each(|k| y1[1][k] * cos4[k] - (x1[1][k] * c23[k] - y6.z * s23[k]) * sin4[k]);
        let q6 = each(|k| atan2(across[k], ahead[k]));
        for k in 0..4 {
            if lanes.reached[k] {
                let q3 = between[k] - self.lean.2;
                let slot = slot(k >= 2, k % 2 == 1, false);
                found.put(slot, [lanes.q1[k], q2[k], q3, q4[k], q5[k], q6[k]]);
                found.put(slot + 1, [lanes.q1[k], q2[k], q3, q4[k] + PI, -q5[k], q6[k] + PI]);
            }
        }
        folded
    }

    /// The turns of joint 1 and the triangles of upper arm and forearm that bring the wrist centre to its place, and
    /// whether two of these may have come together.
    fn lanes(&self, r: &Matrix3<f64>, wrist: &Vector3<f64>, free: &Free) -> Option<(Lanes, bool)> {
        let OrthoLengths { a1, b, c1, c2, .. } = self.lengths;
        // The arm's plane has the wrist at b along y, which is minus its normal.
        let shoulders = shoulder(wrist, -b, free.joints[0])?;
        let mut folded = shoulders[0].1.abs() <= FOLD * b.abs();
        let mut lanes = Lanes::default();
        let (up, sense) = (wrist.z - c1, c2.signum());
        for (side, (q1, reach)) in shoulders.into_iter().enumerate() {
            let along = reach - a1;
            let Some((cos, sin)) = bend((along * along + up * up).sqrt(), c2, self.forearm) else { continue };
            folded |= sin <= FOLD;
            for (lane, sign) in [(2 * side, sense), (2 * side + 1, -sense)] {
                lanes.reached[lane] = true;
                (lanes.q1[lane], lanes.along[lane]) = (q1.angle, along);
                (lanes.cos[lane], lanes.sin[lane]) = (cos, sign * sin);
                for k in 0..3 {
                    let axis = r.column(k);
                    lanes.x1[k][lane] = axis.x * q1.cos + axis.y * q1.sin;
                    lanes.y1[k][lane] = axis.y * q1.cos - axis.x * q1.sin;
                }
            }
        }
        Some((lanes, folded))
    }
}

/// Below this sine two branches may have come together; above it they are surely apart.
const FOLD: f64 = 1e-5;

/// The four postures of upper arm and forearm: shoulder front and back, of each elbow up and down. Number by number side
/// by side, so that the processor computes several at once; those that do not reach have any numbers.
#[derive(Default)]
struct Lanes {
    reached: [bool; 4],
    q1: [f64; 4],
    /// Of the angle between upper arm and forearm.
    cos: [f64; 4],
    sin: [f64; 4],
    /// From axis 2 to the wrist centre, forward.
    along: [f64; 4],
    /// Axes of the flange along the arm's plane and across it.
    x1: [[f64; 4]; 3],
    y1: [[f64; 4]; 3],
}

/// A number for each of the four.
#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> [f64; 4] {
    [of(0), of(1), of(2), of(3)]
}
