//! The contact space of the path: postures with the nozzle's tip on its working surface.
//!
//! Postures on contact have the tip on a waypoint at any turn, on any branch: on that of the motion none collides, and
//! there is nothing to learn.

use curvlay_examples::motion::{PartInHand, Studied};
use curvlay_kinematics::scene::Scene;
use curvlay_trajectory::Robot;
use curvlay_trajectory::indicator::ContactSpace;
use curvlay_trajectory::print::Waypoint;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// The working surface is blended from at most so many planes at waypoints, each over this distance.
const PLANES: usize = 600;
const BLEND_MM: f64 = 4.0;
/// A plane that weighs `exp` of minus this, against the nearest, weighs less than rounding.
const FAR: f64 = 40.0;
/// Joints are moved by this for the slope of the tip, in radians.
const STEP: f64 = 1e-5;

/// The contact space.
pub struct Surface<'a> {
    robot: &'a PartInHand,
    scene: &'a Scene,
    planes: Vec<Waypoint>,
    /// Joints are within half a turn of these.
    middle: [f64; 6],
}

impl<'a> Surface<'a> {
    pub fn new(robot: &'a PartInHand, scene: &'a Scene, middle: [f64; 6]) -> Self {
        let planes = robot.path().iter().step_by(robot.waypoints().div_ceil(PLANES).max(1)).copied().collect();
        Surface { robot, scene, planes, middle }
    }

    /// The tip in the frame of the part.
    fn tip(&self, joints: &[f64; 6]) -> Point3<f64> {
        self.robot.workcell().setup().nozzle_on_part(joints).translation.vector.into()
    }

    /// The mean height over the planes, weighed by how near their waypoints are, and its derivative by the place.
    fn height(&self, tip: &Point3<f64>) -> (f64, Vector3<f64>) {
        let nearest = self.planes.iter().map(|at| (tip - at.position).norm_squared()).fold(f64::INFINITY, f64::min);
        let (mut weights, mut sum) = (0.0, 0.0);
        let (mut normals, mut offsets, mut heights) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for at in &self.planes {
            let off = tip - at.position;
            let far = (off.norm_squared() - nearest) / (BLEND_MM * BLEND_MM);
            if far < FAR {
                let (weight, height) = ((-far).exp(), off.dot(&at.axis));
                weights += weight;
                sum += weight * height;
                normals += at.axis.into_inner() * weight;
                offsets += off * weight;
                heights += off * (weight * height);
            }
        }
        let height = sum / weights;
        (height, (normals - (heights - offsets * height) * (2.0 / (BLEND_MM * BLEND_MM))) / weights)
    }
}

impl ContactSpace<6> for Surface<'_> {
    fn collides(&self, joints: &[f64; 6]) -> bool {
        !matches!(self.scene.touching(&(*joints).into()), Ok(None))
    }

    fn gap(&self, joints: &[f64; 6]) -> f64 {
        self.height(&self.tip(joints)).0
    }

    fn gap_gradient(&self, joints: &[f64; 6]) -> (f64, [f64; 6]) {
        let (height, slope) = self.height(&self.tip(joints));
        let of_joint = |j: usize| {
            let [ahead, back] = [STEP, -STEP].map(|step| {
                let mut moved = *joints;
                moved[j] += step;
                self.tip(&moved)
            });
            slope.dot(&(ahead - back)) / (2.0 * STEP)
        };
        (height, std::array::from_fn(of_joint))
    }

    fn sample(&self, random: &mut dyn FnMut() -> f64) -> Option<[f64; 6]> {
        let count = Robot::waypoints(self.robot);
        let waypoint = ((random() * count as f64) as usize).min(count - 1);
        let mut solutions: Vec<[f64; 6]> = Vec::new();
        Robot::solutions(self.robot, waypoint, &[TAU * random()], &mut |_, joints| solutions.push(joints));
        let joints = *solutions.get((random() * solutions.len() as f64) as usize)?;
        Some(std::array::from_fn(|j| joints[j] + TAU * ((self.middle[j] - joints[j]) / TAU).round()))
    }
}
