//! A machine with the options of a plan, and the neighbourhood of its poles: where one rotary axis may stand as it likes.

use super::options::AxisPlanOptions;
use super::pose::Pose;
use crate::machine::geometry::{FiveAxis, Posture};
use nalgebra::Vector3;
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub machine: &'a FiveAxis,
    pub options: AxisPlanOptions,
    /// Size of the neighbourhood: an angle, or mm on a polar machine.
    pub size: f64,
    /// Whether the nozzle can stand along the first axis, and against it.
    has_pole: [bool; 2],
}

impl<'a> Task<'a> {
    pub fn new(machine: &'a FiveAxis, options: AxisPlanOptions) -> Self {
        let size = if machine.linear.len() == 3 { options.pole_rad } else { 0.5 * options.tip_tolerance_mm };
        let (wrist, second) = (&machine.wrist, &machine.rotary[1]);
        let is_there = |off: f64, tilt: f64| {
            let reading = second.reading(tilt);
            off.abs() <= size && second.images(reading, reading).is_some()
        };
        let has_pole = [
            is_there(wrist.axes - wrist.nozzle, wrist.upright),
            is_there(wrist.axes + wrist.nozzle - PI, wrist.upright + PI),
        ];
        Task { machine, options, size, has_pole }
    }

    pub fn is_polar(&self) -> bool {
        self.machine.linear.len() == 2
    }

    /// How far a pose is from where the first rotary axis turns without end for a small motion: an angle, or mm.
    pub fn singular(&self, pose: &Pose) -> f64 {
        let [near, far] = self.pole_distances(pose);
        near.min(far)
    }

    fn pole_distances(&self, pose: &Pose) -> [f64; 2] {
        if self.is_polar() {
            return [self.machine.plane(&pose.tip).radius, f64::INFINITY];
        }
        let angle = crate::machine::rotate::arc(&self.machine.rotary[0].axis, &pose.direction);
        [angle, PI - angle]
    }

    /// How far a pose is from a pole that the machine can take; infinite where there is none.
    pub fn distance(&self, pose: &Pose) -> f64 {
        if self.is_polar() {
            let plane = self.machine.plane(&pose.tip);
            return if plane.offset.abs() > self.size { f64::INFINITY } else { plane.radius };
        }
        let [near, far] = self.pole_distances(pose);
        let there = |k: usize, distance: f64| if self.has_pole[k] { distance } else { f64::INFINITY };
        there(0, near).min(there(1, far))
    }

    /// Well within the neighbourhood; its border is outside.
    pub fn is_inside(&self, pose: &Pose) -> bool {
        self.distance(pose) < self.size * (1.0 - 1e-6)
    }

    /// By how much the distance of two poses from a pole may differ.
    pub fn step(&self, from: &Pose, to: &Pose) -> f64 {
        if self.is_polar() { from.length(to) } else { from.turn(to) }
    }

    /// The posture at a pose within the neighbourhood, with the first rotary axis where it should be.
    pub fn at_pole(&self, pose: &Pose, turn: f64, near: f64) -> Posture {
        let tilt = self.machine.tilt_for(&pose.direction, turn, near);
        let [min, max] = self.machine.rotary[1].range;
        let rotary = [turn, tilt.clamp(min, max)];
        Posture { linear: self.machine.place(&pose.tip, &rotary), rotary }
    }

    pub fn posture(&self, tip: &Vector3<f64>, rotary: [f64; 2]) -> Posture {
        Posture { linear: self.machine.place(tip, &rotary), rotary }
    }
}
