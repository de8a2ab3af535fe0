//! Robots for the tests, and what else they share.

pub mod cell;
pub mod natural;
pub mod planar;
pub mod tilt;
pub mod ur3;

pub use natural::Natural;

use curvlay_trajectory::nalgebra::{Matrix3, Vector3};
use curvlay_trajectory::{FreeRange, Posture, Progress, Robot};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// Shows nothing and never stops.
pub fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Three joints in a plane: the tip is given, the direction of the last link is free. Two branches, by the elbow.
pub struct Planar {
    pub links: [f64; 3],
    pub tips: Vec<[f64; 2]>,
}

pub fn wrapped(angle: f64) -> f64 {
    let near = angle - TAU * (angle / TAU).round();
    if near <= -PI { near + TAU } else { near }
}

impl Planar {
    /// Along a circle.
    pub fn circle(waypoints: usize, centre: [f64; 2], radius: f64) -> Self {
        let tip = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / waypoints as f64).sin_cos();
            [centre[0] + radius * cos, centre[1] + radius * sin]
        };
        Planar { links: [1.0, 0.8, 0.4], tips: (0..waypoints).map(tip).collect() }
    }

    pub fn tip(&self, q: &[f64; 3]) -> [f64; 2] {
        let (a, b, c) = (q[0], q[0] + q[1], q[0] + q[1] + q[2]);
        let [l1, l2, l3] = self.links;
        [l1 * a.cos() + l2 * b.cos() + l3 * c.cos(), l1 * a.sin() + l2 * b.sin() + l3 * c.sin()]
    }

    fn solution(&self, waypoint: usize, free: f64, branch: u32) -> Option<[f64; 3]> {
        let ([l1, l2, l3], [x, y]) = (self.links, self.tips[waypoint]);
        let (x, y) = (x - l3 * free.cos(), y - l3 * free.sin());
        let cos = (x * x + y * y - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
        let sin = (1.0 - cos * cos).max(0.0).sqrt() * if branch == 0 { 1.0 } else { -1.0 };
        let q2 = sin.atan2(cos);
        let q1 = y.atan2(x) - (l2 * sin).atan2(l1 + l2 * cos);
        (cos.abs() < 1.0).then(|| [wrapped(q1), q2, wrapped(free - q1 - q2)])
    }
}

impl Robot<3, 1> for Planar {
    fn waypoints(&self) -> usize {
        self.tips.len()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 3])) {
        for branch in 0..2 {
            if let Some(joints) = self.solution(waypoint, free[0], branch) {
                each(branch, joints);
            }
        }
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<3, 1>> {
        let joints = self.solution(waypoint, free[0], branch)?;
        let (a, b, c) = (joints[0], joints[0] + joints[1], joints[0] + joints[1] + joints[2]);
        let [l1, l2, l3] = self.links;
        let column = |terms: &[(f64, f64)]| {
            let (x, y) = terms.iter().fold((0.0, 0.0), |(x, y), (l, q)| (x - l * q.sin(), y + l * q.cos()));
            Vector3::new(x, y, 1.0)
        };
        let jacobian = Matrix3::from_columns(&[
            column(&[(l1, a), (l2, b), (l3, c)]),
            column(&[(l2, b), (l3, c)]),
            column(&[(l3, c)]),
        ]);
        let rates = jacobian.try_inverse()? * Vector3::z();
        Some(Posture { joints, rates: [rates.into()] })
    }
}

/// Numbers in `[0, 1)` for fixed data: D. Knuth's linear congruence (MMIX), the upper 53 bits.
pub struct Fixed(pub u64);

impl Fixed {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
