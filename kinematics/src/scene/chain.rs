//! What moves what, and how far at most: bounds that hold at all joints, from the lengths of the links alone.
//!
//! A chain has frames `0..=n`; frame 0 is the base, and frame `k` turns about axis `k`, which stands still in frame `k - 1`.
//! In each frame there is an anchor so chosen that the distance `length[k]` from anchor `k - 1` to anchor `k` never
//! changes (of an arm: the origins, since axis `k` passes through one of them; of a table: points on its axes). So a
//! point of frame `j` at `rho` from anchor `j` is never farther from axis `k < j` than `off[k] + length[k + 1] +
//! ... + length[j] + rho`, where `off[k]` is how far anchor `k` is from its own axis; and from axis `j` it keeps its distance.
//! Turning by `dq` about an axis moves it by at most that distance times `|dq|`.

use crate::arm::Arm;
use crate::positioner::Positioner;
use nalgebra::{Isometry3, Point3, Vector3};

/// A line: a point on it and its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub at: Point3<f64>,
    pub along: Vector3<f64>,
}

impl Line {
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        (point - self.at).cross(&self.along).norm()
    }

    /// Where along the line the foot of a point is.
    pub fn height(&self, point: &Point3<f64>) -> f64 {
        (point - self.at).dot(&self.along)
    }

    pub fn point(&self, height: f64) -> Point3<f64> {
        self.at + self.along * height
    }

    /// How a point moves that turns about the line, a radian.
    pub fn turning(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.along.cross(&(point - self.at))
    }

    fn foot(&self, point: &Point3<f64>) -> Point3<f64> {
        self.point(self.height(point))
    }

    /// In the base, of a line in a frame.
    pub fn placed(&self, frame: &Isometry3<f64>) -> Line {
        Line { at: frame * self.at, along: frame * self.along }
    }

    fn seen_from(&self, frame: &Isometry3<f64>) -> Line {
        let inverse = frame.inverse();
        Line { at: inverse * self.at, along: inverse * self.along }
    }
}

/// Frame `k` of a chain.
#[derive(Clone, Copy, Debug)]
struct Joint {
    /// Its axis, in frame `k - 1` and in frame `k`.
    axis: [Line; 2],
    /// Anchor `k`, in frame `k`.
    anchor: Point3<f64>,
    /// From anchor `k - 1` to anchor `k`; of the first joint 0.
    length: f64,
    /// From the axis to the anchor.
    off: f64,
}

/// An arm or a table.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    joints: Vec<Joint>,
}

impl Chain {
    pub fn of_arm(arm: &Arm) -> Self {
        let frames = arm.frames(&[0.0; 6]);
        let axes = arm.axes(&[0.0; 6]).map(|(at, along)| Line { at, along: along.into_inner() });
        let origins = frames.map(|frame| Point3::from(frame.translation.vector));
        Chain::new(&frames, &axes, &origins)
    }

    pub fn of_table(positioner: &Positioner) -> Self {
        let table = positioner.forward(&[0.0; 2]);
        let axes = positioner.axes(&[0.0; 2]).map(|(at, along)| Line { at, along: along.into_inner() });
        let top = axes[1].foot(&table.translation.vector.into());
        let anchors = [Point3::origin(), axes[0].foot(&top), top];
        Chain::new(&[Isometry3::identity(), table, table], &axes, &anchors)
    }

    /// Frames, axes and anchors in the base, all at one posture.
    fn new(frames: &[Isometry3<f64>], axes: &[Line], anchors: &[Point3<f64>]) -> Self {
        let joint = |k: usize| Joint {
            axis: [axes[k - 1].seen_from(&frames[k - 1]), axes[k - 1].seen_from(&frames[k])],
            anchor: frames[k].inverse() * anchors[k],
            length: if k == 1 { 0.0 } else { (anchors[k] - anchors[k - 1]).norm() },
            off: axes[k - 1].distance(&anchors[k]),
        };
        Chain { joints: (1..frames.len()).map(joint).collect() }
    }

    /// The axis of joint `k`, counted from 0, in frame `k`, where it stands still.
    pub fn axis(&self, k: usize) -> &Line {
        &self.joints[k].axis[0]
    }

    /// How far points of frame `j > 0` can ever be from each of the axes `1..=j`. `farthest` gives the greatest value
    /// on them of a distance in frame `j`.
    pub fn lever_arms(&self, j: usize, farthest: impl Fn(&dyn Fn(&Point3<f64>) -> f64) -> f64) -> Vec<f64> {
        let last = &self.joints[j - 1];
        let mut lever_arms = vec![farthest(&|point| last.axis[1].distance(point)); j];
        let mut beyond = farthest(&|point| (point - last.anchor).norm());
        for k in (0..j - 1).rev() {
            beyond += self.joints[k + 1].length;
            lever_arms[k] = self.joints[k].off + beyond;
        }
        lever_arms
    }

    /// A capsule in frame `i` (its ends and radius) that points of frame `j > i` never leave.
    pub fn reachable_volume(
        &self,
        i: usize,
        j: usize,
        farthest: impl Fn(&dyn Fn(&Point3<f64>) -> f64) -> f64,
    ) -> ([Point3<f64>; 2], f64) {
        let (first, last) = (&self.joints[i], &self.joints[j - 1]);
        if j == i + 1 {
            // About the one axis between them, heights and distances stay.
            let [before, after] = first.axis;
            let high = farthest(&|point| after.height(point));
            let low = -farthest(&|point| -after.height(point));
            let radius = farthest(&|point| after.distance(point));
            return ([before.point(low), before.point(high)], radius);
        }
        // Anchor i + 1 turns about its axis: seen from frame i it stays on a circle about this point.
        let center = first.axis[0].point(first.axis[1].height(&first.anchor));
        let beyond = farthest(&|point| (point - last.anchor).norm());
        let links: f64 = self.joints[i + 1..j].iter().map(|joint| joint.length).sum();
        ([center; 2], first.off + links + beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{ArmModel, robots};
    use crate::limits::JointLimits;
    use crate::scene::rounding::CHAIN_MM;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Random points on random frames at random joints: never farther from an axis than said, never outside the reachable volume.
    fn holds<const N: usize>(chain: &Chain, frames: impl Fn(&[f64; N]) -> Vec<Isometry3<f64>>) {
        let mut random = Pcg64Mcg::seed_from_u64(11);
        for _ in 0..3_000 {
            let joints: [f64; N] = std::array::from_fn(|_| random.random_range(-3.2..3.2));
            let point = Point3::from([0; 3].map(|_| random.random_range(-150.0..150.0)));
            let placed = frames(&joints);
            let farthest = |measure: &dyn Fn(&Point3<f64>) -> f64| measure(&point);
            for j in 1..=N {
                let lever_arms = chain.lever_arms(j, farthest);
                let world = placed[j] * point;
                for k in 1..=j {
                    // Axis k stands still in frame k - 1.
                    let seen = placed[k - 1].inverse() * world;
                    let distance = chain.joints[k - 1].axis[0].distance(&seen);
                    assert!(distance <= lever_arms[k - 1] + CHAIN_MM, "{j} {k}: {distance} {}", lever_arms[k - 1]);
                    let ([low, high], radius) = chain.reachable_volume(k - 1, j, farthest);
                    let along = high - low;
                    let t = (seen - low).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
                    let off = (seen - (low + along * t.clamp(0.0, 1.0))).norm();
                    assert!(off <= radius + CHAIN_MM, "{j} {k}: {off} {radius}");
                }
            }
        }
    }

    #[test]
    fn no_point_leaves_its_bounds() {
        let offset = ArmModel {
            geometry: crate::arm::Geometry::Ortho(crate::arm::OrthoLengths {
                a1: 150.0,
                a2: -110.0,
                b: 40.0,
                c1: 480.0,
                c2: 600.0,
                c3: 640.0,
                c4: 100.0,
            }),
            ..robots::IRB120
        };
        for model in [robots::UR3, robots::UR5E, robots::IRB120, robots::IRB1200, offset] {
            let arm = Arm::new(&model).expect("published numbers");
            holds::<6>(&Chain::of_arm(&arm), |joints| arm.frames(joints).to_vec());
        }
        // Axes that do not meet, and a table far from both.
        let table = crate::PositionerModel {
            tilt_axis: [1.0, 0.2, 0.1],
            table_origin: [80.0, -60.0, 1200.0],
            limits: JointLimits::NONE,
            ..robots::IRBP_A250
        };
        let positioner = Positioner::new(&table, &Isometry3::translation(300.0, 20.0, -900.0)).expect("sound numbers");
        holds::<2>(&Chain::of_table(&positioner), |&[tilt, turn]| {
            vec![Isometry3::identity(), positioner.forward(&[tilt, 0.0]), positioner.forward(&[tilt, turn])]
        });
    }
}
