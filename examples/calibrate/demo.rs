//! Measurements made in code: an arm with known errors, a tracker, and a probe that touches a point.

use super::Args;
use curvlay_examples::args::Failure;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::workcell::{AnyWorkcell, Held};
use curvlay_kinematics::{Arm, ArmDeviation, ArmFit, MeasuredPose, Measurements, Touch};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

/// What was put in.
pub struct Truth {
    pub deviation: ArmDeviation,
    /// What the touches should find: the tip on the flange, or the nozzle of a part in the hand in the base.
    tip: Point3<f64>,
    is_part_held: bool,
    world_base: Isometry3<f64>,
    flange_target: Isometry3<f64>,
}

impl Truth {
    /// The same as the calibrated arm has it: base and flange of a fit are not where those of the arm are, since poses do not tell the
    /// offsets of joints 1 and 6 from them.
    pub fn tip_by(&self, fit: Option<&ArmFit>) -> Point3<f64> {
        match fit {
            Some(fit) if self.is_part_held => fit.world_base.inverse() * self.world_base * self.tip,
            Some(fit) => fit.flange_target * self.flange_target.inverse() * self.tip,
            None => self.tip,
        }
    }
}

/// Errors of an arm as calibrations find them: of the joints' zeros in radians, of places of axes in millimetres, of tilts in radians.
const OFFSET: f64 = 0.006;
const SHIFT_MM: f64 = 0.5;
const TURN: f64 = 0.0015;
/// By how much the tip is not where the workcell says, in millimetres, each way.
const TIP_MM: f64 = 1.5;
/// Error of touching by hand, in millimetres.
const TOUCH_MM: f64 = 0.05;
/// Touches, and how far the tool leans in them at most, in radians.
const TOUCHES: usize = 10;
const LEAN: f64 = 0.6;
/// Joints of poses are within this, in radians, and within the limits.
const JOINTS: f64 = 2.6;
/// Postures that are tried for a touch.
const TRIES: usize = 2000;

/// Normal noise, as the sum of twelve uniform numbers.
fn noise(random: &mut Pcg64Mcg, size: f64) -> Vector3<f64> {
    let mut one = || size * ((0..12).map(|_| random.random_range(0.0..1.0)).sum::<f64>() - 6.0);
    Vector3::new(one(), one(), one())
}

pub fn measure(args: &Args, cell: &AnyWorkcell) -> Result<(Measurements, Truth), Failure> {
    let mut random = Pcg64Mcg::seed_from_u64(args.seed);
    let equipment = cell.equipment();
    let mut deviation = ArmDeviation::none();
    // Joint 1 and joint 6 turn base and target, which nobody knows.
    for offset in &mut deviation.offsets[1..5] {
        *offset = random.random_range(-OFFSET..OFFSET);
    }
    for axis in &mut deviation.axes {
        let mut vector = |size: f64| Vector3::from([0; 3].map(|_| random.random_range(-size..size)));
        *axis = Isometry3::new(vector(SHIFT_MM), vector(TURN));
    }
    let built = Arm::calibrated(equipment.arm_model(), &deviation)?;
    let world_base = Isometry3::new(Vector3::new(2600.0, -900.0, 300.0), Vector3::new(0.02, -0.03, 2.4));
    let flange_target = Isometry3::new(Vector3::new(40.0, 10.0, 70.0), Vector3::new(0.3, 0.0, -0.8));
    let limits = *built.limits();
    let mut measured = Measurements::default();
    for _ in 0..args.poses {
        let joint = |k: usize| {
            let (low, high) = (limits.lower[k].max(-JOINTS), limits.upper[k].min(JOINTS));
            (low, high)
        };
        let joints: [f64; 6] = std::array::from_fn(|k| random.random_range(joint(k).0..=joint(k).1));
        let target = world_base * built.forward(&joints) * flange_target;
        let turn = UnitQuaternion::from_scaled_axis(noise(&mut random, args.noise_mm / args.radian_mm));
        measured.poses.push(MeasuredPose {
            joints,
            position: (target.translation.vector + noise(&mut random, args.noise_mm)).into(),
            rotation: Some(turn * target.rotation),
        });
    }
    let off = Vector3::from([0; 3].map(|_| random.random_range(-TIP_MM..TIP_MM)));
    // The nozzle on the flange touches a mark beside the plate; or a pin at the middle of the plate in the hand touches the nozzle.
    let (mount, part) = equipment.part_frame();
    let (_, nozzle) = equipment.nozzle_frame();
    let is_part_held = equipment.model().held == Held::Part;
    let (tip, mark) = if is_part_held {
        (Point3::from(part.translation.vector), Point3::from(nozzle.translation.vector) + off)
    } else {
        let place = if mount == curvlay_kinematics::scene::Mount::Base {
            part.translation.vector
        } else {
            Vector3::new(600.0, 0.0, 200.0)
        };
        (Point3::from(nozzle.translation.vector) + off, Point3::from(place))
    };
    // The tool upright over the mark, or the plate under the nozzle.
    let upright = if is_part_held { nozzle.rotation * part.rotation.inverse() } else { nozzle.rotation.inverse() };
    for _ in 0..TRIES {
        if measured.touches.len() == TOUCHES {
            break;
        }
        let spin = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.random_range(-PI..PI));
        let side = random.random_range(-PI..PI);
        let lean = UnitQuaternion::from_scaled_axis(
            Vector3::new(side.cos(), side.sin(), 0.0) * random.random_range(0.3..LEAN),
        );
        let rotation = lean * spin * upright;
        let place = mark.coords - rotation * tip.coords + noise(&mut random, TOUCH_MM);
        let found = built.inverse(&Isometry3::from_parts(Translation3::from(place), rotation))?;
        let within = found.iter().map(|(_, joints)| *joints).find(|joints| limits.contains(joints));
        measured.touches.extend(within.map(Touch::Joints));
    }
    Ok((
        measured,
        Truth { deviation, tip: if is_part_held { mark } else { tip }, is_part_held, world_base, flange_target },
    ))
}
