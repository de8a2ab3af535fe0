//! Small robots, sound or spoilt in one place.

use super::numbers::{bad, number};
use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_trajectory::print::{PrintRobot, Waypoint};
use curvlay_trajectory::{FreeRange, LadderNode, Posture, Progress, Robot};
use proptest::prelude::*;
use std::ops::ControlFlow;

pub fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Two joints share a sine: what the free parameter takes from one it gives to the other.
#[derive(Clone, Debug)]
pub struct Shared {
    pub waypoints: usize,
    pub range: FreeRange,
    /// Added to a joint and to a rate at a waypoint.
    pub at: usize,
    pub joint: f64,
    pub rate: f64,
    /// Whether that waypoint is out of reach.
    pub missing: bool,
}

impl Shared {
    pub fn sound(waypoints: usize) -> Self {
        Shared { waypoints, range: FreeRange::Turn, at: 0, joint: 0.0, rate: 0.0, missing: false }
    }

    /// One node a waypoint.
    pub fn nodes(&self, free: f64) -> Vec<LadderNode<2, 1>> {
        (0..self.waypoints).map(|k| LadderNode { joints: self.joints(k, free), free: [free], branch: 0 }).collect()
    }

    fn joints(&self, waypoint: usize, free: f64) -> [f64; 2] {
        let more = if waypoint == self.at { self.joint } else { 0.0 };
        [(0.3 * waypoint as f64).sin() + free + more, -free]
    }
}

impl Robot<2, 1> for Shared {
    fn waypoints(&self) -> usize {
        self.waypoints
    }

    fn free(&self) -> [FreeRange; 1] {
        [self.range]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])) {
        if !(self.missing && waypoint == self.at) {
            each(0, self.joints(waypoint, free[0]));
        }
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<2, 1>> {
        let more = if waypoint == self.at { self.rate } else { 0.0 };
        let is_there = branch == 0 && !(self.missing && waypoint == self.at);
        is_there.then(|| Posture { joints: self.joints(waypoint, free[0]), rates: [[1.0 + more, -1.0]] })
    }
}

fn range() -> impl Strategy<Value = FreeRange> {
    let within = [
        [0.0, 0.0],
        [1.0, -1.0],
        [f64::NAN, 1.0],
        [0.0, f64::NAN],
        [f64::NEG_INFINITY, f64::INFINITY],
        [-1e308, 1e308],
        [0.0, 1e12],
        [-0.5, 0.5],
        [1e15, 1e15 + 1.0],
    ];
    let within = prop::sample::select(within.to_vec()).prop_map(|[low, high]| FreeRange::Within(low, high));
    prop_oneof![2 => Just(FreeRange::Turn), 1 => within]
}

/// Sound, or spoilt in one way.
pub fn shared() -> impl Strategy<Value = Shared> {
    (0..14usize, range(), 0..14usize, prop_oneof![bad(), number()], 0..6usize).prop_map(
        |(waypoints, range, at, bad, kind)| {
            let mut robot = Shared { at, ..Shared::sound(waypoints) };
            match kind {
                0 => robot.joint = bad,
                1 => robot.rate = bad,
                2 => robot.missing = true,
                3 => robot.range = range,
                _ => {}
            }
            robot
        },
    )
}

/// Three slides of 10 mm a unit, and a turn about the nozzle that is free.
#[derive(Clone, Copy, Debug)]
pub struct Gantry {
    /// Added to what the first joint is, and to where the nozzle is.
    pub joint: f64,
    pub tip: f64,
    pub range: FreeRange,
    pub is_out_of_reach: bool,
}

impl Gantry {
    pub const SOUND: Self = Gantry { joint: 0.0, tip: 0.0, range: FreeRange::Turn, is_out_of_reach: false };

    fn joints(&self, Waypoint { position, .. }: &Waypoint, free: f64) -> [f64; 4] {
        [0.1 * position.x + self.joint, 0.1 * position.y, 0.1 * position.z, free]
    }
}

impl PrintRobot<4, 1> for Gantry {
    fn free(&self) -> [FreeRange; 1] {
        [self.range]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 4])) {
        if !self.is_out_of_reach {
            each(0, self.joints(waypoint, free[0]));
        }
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 1], _: u32) -> Option<Posture<4, 1>> {
        let joints = self.joints(waypoint, free[0]);
        (!self.is_out_of_reach).then_some(Posture { joints, rates: [[0.0, 0.0, 0.0, 1.0]] })
    }

    fn nozzle(&self, q: &[f64; 4]) -> Option<Isometry3<f64>> {
        let tip = Vector3::new(10.0 * q[0] + self.tip, 10.0 * q[1], 10.0 * q[2]);
        Some(Isometry3::new(tip, Vector3::z() * q[3]))
    }

    fn continued(&self, waypoint: &Waypoint, _: &[f64; 1], turn: f64, near: &[f64; 4]) -> Option<[f64; 4]> {
        (!self.is_out_of_reach).then(|| self.joints(waypoint, near[3] + turn))
    }
}

/// Sound, or spoilt in one way.
pub fn gantry() -> impl Strategy<Value = Gantry> {
    (range(), bad(), 0..8usize).prop_map(|(range, bad, kind)| match kind {
        0 => Gantry { joint: bad, ..Gantry::SOUND },
        1 => Gantry { tip: bad, ..Gantry::SOUND },
        2 => Gantry { range, ..Gantry::SOUND },
        3 => Gantry { is_out_of_reach: true, ..Gantry::SOUND },
        _ => Gantry::SOUND,
    })
}

pub fn waypoint() -> impl Strategy<Value = Waypoint> {
    (prop::array::uniform3(number()), bad(), 0..12usize).prop_map(|(at, bad, kind)| {
        let axis = match kind {
            0 => UnitVector3::new_unchecked(Vector3::new(bad, 0.0, 1.0)),
            1 => UnitVector3::new_unchecked(Vector3::zeros()),
            2 => -Vector3::z_axis(),
            _ => Vector3::z_axis(),
        };
        Waypoint { position: Point3::from(at), axis }
    })
}

/// A sound line of them at a height, a millimetre apart, with one spoilt now and then.
pub fn line(z: f64) -> impl Strategy<Value = Vec<Waypoint>> {
    (0..12usize, 0..30usize, waypoint()).prop_map(move |(count, at, spoilt)| {
        let sound = |k: usize| Waypoint { position: Point3::new(k as f64, 0.0, z), axis: Vector3::z_axis() };
        (0..count).map(|k| if k == at { spoilt } else { sound(k) }).collect()
    })
}
