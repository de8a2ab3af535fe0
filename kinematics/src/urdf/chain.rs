//! A chain of six turning joints: its forward kinematics by multiplying out, and its axes as lines at zero.

use super::file::{Joint, Kind};
use super::lines::Line;
use super::tree::Path;
use crate::limits::JointLimits;
use nalgebra::{Isometry3, UnitQuaternion};

pub(super) struct Chain<'a> {
    base_root: Isometry3<f64>,
    joints: Vec<&'a Joint>,
}

impl<'a> Chain<'a> {
    pub fn new(path: &Path<'a>) -> Self {
        Chain { base_root: path.root_base.inverse(), joints: path.joints.clone() }
    }

    /// The joints that turn.
    pub fn turning(&self) -> impl Iterator<Item = &'a Joint> {
        self.joints.iter().copied().filter(|joint| matches!(joint.kind, Kind::Turning(..)))
    }

    /// The flange in the base.
    pub fn forward(&self, joints: &[f64; 6]) -> Isometry3<f64> {
        let mut angles = joints.iter();
        let mut pose = self.base_root;
        for joint in &self.joints {
            pose *= joint.origin;
            if matches!(joint.kind, Kind::Turning(..)) {
                pose *= UnitQuaternion::from_axis_angle(&joint.axis, angles.next().copied().unwrap_or(0.0));
            }
        }
        pose
    }

    /// The axes in the base, at zero.
    pub fn axes(&self) -> [Line; 6] {
        let mut lines = [Line::default(); 6];
        let (mut pose, mut k) = (self.base_root, 0);
        for joint in &self.joints {
            pose *= joint.origin;
            if let (Kind::Turning(..), Some(line)) = (&joint.kind, lines.get_mut(k)) {
                *line = Line { at: pose.translation.vector, along: pose.rotation * joint.axis.into_inner() };
                k += 1;
            }
        }
        lines
    }

    pub fn limits(&self) -> JointLimits<6> {
        let mut limits = JointLimits::NONE;
        for (k, joint) in self.turning().enumerate().take(6) {
            if let Kind::Turning(lower, upper) = joint.kind {
                (limits.lower[k], limits.upper[k], limits.velocity[k]) = (lower, upper, joint.velocity);
            }
        }
        limits
    }
}
