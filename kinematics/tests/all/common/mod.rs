//! What several test files share: robots by name, reference rows, joints and poses to compare.

#[cfg(feature = "serde")]
pub mod cells;
pub mod files;
pub mod programs;
pub mod solids;

use curvlay_kinematics::nalgebra::{Isometry3, Matrix4};
use curvlay_kinematics::{
    ANGLE_TOLERANCE, Arm, ArmModel, Geometry, OrthoLengths, POSITION_TOLERANCE, pose_from_matrix, robots,
};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;

pub const ROBOTS: [(&str, &ArmModel); 6] = [
    ("UR3", &robots::UR3),
    ("UR3e", &robots::UR3E),
    ("UR5", &robots::UR5),
    ("UR5e", &robots::UR5E),
    ("IRB120-3_0.6", &robots::IRB120),
    ("IRB1200-7_0.7", &robots::IRB1200),
];

pub fn arm(model: &ArmModel) -> Arm {
    Arm::new(model).unwrap()
}

/// A file of reference rows in the folder `shared` beside the workspace.
pub fn reference(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/kinematics").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A row by the names of its columns.
pub struct Row<'a>(BTreeMap<&'a str, &'a str>);

impl Row<'_> {
    pub fn text(&self, column: &str) -> &str {
        self.0[column]
    }

    pub fn number(&self, column: &str) -> f64 {
        self.0[column].parse().unwrap()
    }

    pub fn joints(&self) -> [f64; 6] {
        ["q1", "q2", "q3", "q4", "q5", "q6"].map(|name| self.number(name))
    }

    /// The pose by its matrix, in millimetres.
    pub fn pose(&self) -> Isometry3<f64> {
        let mut matrix = Matrix4::identity();
        for (i, p) in ["px", "py", "pz"].into_iter().enumerate() {
            for k in 0..3 {
                matrix[(i, k)] = self.number(&format!("r{}{}", i + 1, k + 1));
            }
            matrix[(i, 3)] = 1000.0 * self.number(p);
        }
        pose_from_matrix(&matrix).unwrap()
    }
}

pub fn rows(text: &str) -> impl Iterator<Item = Row<'_>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines.map(move |line| Row(header.iter().copied().zip(line.split(',')).collect()))
}

/// Largest difference of joints as directions.
pub fn apart(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b - TAU * ((a - b) / TAU).round()).abs()).fold(0.0, f64::max)
}

/// Largest difference of joints as numbers.
pub fn differ(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Distance in mm and angle in rad between two poses.
pub fn miss(a: &Isometry3<f64>, b: &Isometry3<f64>) -> (f64, f64) {
    let turn = (a.rotation.inverse() * b.rotation).into_inner();
    ((a.translation.vector - b.translation.vector).norm(), 2.0 * turn.imag().norm().atan2(turn.w.abs()))
}

pub fn assert_meets(arm: &Arm, joints: &[f64; 6], pose: &Isometry3<f64>, what: &str) {
    let (mm, rad) = miss(&arm.forward(joints), pose);
    assert!(mm <= POSITION_TOLERANCE && rad <= ANGLE_TOLERANCE, "{what}: {mm:e} mm, {rad:e} rad at {joints:?}");
}

pub fn in_one_turn(joints: &[f64; 6]) -> bool {
    joints.iter().all(|angle| -PI < *angle && *angle <= PI)
}

/// Postures on each singularity and on several at once: q5 for the wrist, q3 for the elbow, and joints 2 and 3 such
/// that the wrist centre is on axis 1 for the shoulder of an ABB arm.
pub fn singular_postures(model: &ArmModel) -> Vec<(&'static str, [f64; 6])> {
    let base = [0.4, -0.9, 1.1, 0.5, 0.8, -0.6];
    let with = |changes: &[(usize, f64)]| {
        let mut joints = base;
        changes.iter().for_each(|&(k, value)| joints[k] = value);
        joints
    };
    match model.geometry {
        Geometry::Ortho(lengths) => {
            let OrthoLengths { a2, c2, c3, .. } = lengths;
            let stretched = FRAC_PI_2.mul_add(-1.0, -a2.atan2(c3));
            // c2 sin q2 + a2 cos(q2 + q3') + c3 sin(q2 + q3') = 0, q3' from upright.
            let over = |q3: f64| {
                let upright = q3 + FRAC_PI_2;
                let (s, c) = upright.sin_cos();
                (-(a2 * c + c3 * s)).atan2(c2 - a2 * s + c3 * c)
            };
            vec![
                ("wrist", with(&[(4, 0.0)])),
                ("wrist, far side", with(&[(4, PI)])),
                ("elbow", with(&[(2, stretched)])),
                ("shoulder", with(&[(1, over(1.1))])),
                ("wrist and elbow", with(&[(2, stretched), (4, 0.0)])),
                ("wrist and shoulder", with(&[(1, over(1.1)), (4, 0.0)])),
                ("all", with(&[(2, stretched), (1, over(stretched)), (4, 0.0)])),
            ]
        }
        Geometry::Ur(table) => {
            // Joint 4 such that axes 5 and 6 cross over axis 1, as near as they can.
            let over = |q2: f64, q3: f64| {
                let along = table.a[1] * q2.cos() + table.a[2] * (q2 + q3).cos();
                (-along / table.d[4]).asin() - q2 - q3
            };
            let high = [(1, -1.5), (2, 0.05)];
            vec![
                ("wrist", with(&[(4, 0.0)])),
                ("wrist, far side", with(&[(4, PI)])),
                ("elbow", with(&[(2, 0.0)])),
                ("folded", with(&[(2, PI)])),
                ("shoulder", with(&[high[0], high[1], (3, over(-1.5, 0.05))])),
                ("wrist and elbow", with(&[(2, 0.0), (4, 0.0)])),
                ("wrist, nearly stretched", with(&[(2, 1e-4), (4, 0.0)])),
                ("wrist and shoulder", with(&[high[0], high[1], (3, over(-1.5, 0.05)), (4, 0.0)])),
                ("all", with(&[(1, -1.5), (2, 0.0), (3, over(-1.5, 0.0)), (4, 0.0)])),
            ]
        }
        _ => unreachable!(),
    }
}
