//! Measurements made in code: an arm with known errors, a tracker, and a probe that touches a point.

use super::Args;
use curvlay_examples::args::Failure;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::workcell::{AnyWorkcell, Equipment, Held};
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
    /// The same as the calibrated arm has it: base and flange of a fit are not where those of the arm are, since poses do not distinguish the
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

/// An arm whose joints are not where its maker has them. Joint 1 and joint 6 turn base and target, which are unknown anyway.
fn deviation(random: &mut Pcg64Mcg) -> ArmDeviation {
    let mut deviation = ArmDeviation::none();
    for offset in &mut deviation.offsets[1..5] {
        *offset = random.random_range(-OFFSET..OFFSET);
    }
    for axis in &mut deviation.axes {
        let mut vector = |size: f64| Vector3::from([0; 3].map(|_| random.random_range(-size..size)));
        *axis = Isometry3::new(vector(SHIFT_MM), vector(TURN));
    }
    deviation
}

/// Measurements of an arm with known errors: poses of a target on its flange, and touches of one point.
pub fn measure(args: &Args, cell: &AnyWorkcell) -> Result<(Measurements, Truth), Failure> {
    let mut random = Pcg64Mcg::seed_from_u64(args.seed);
    let equipment = cell.equipment();
    let deviation = deviation(&mut random);
    let built = Arm::calibrated(equipment.arm_model(), &deviation)?;
    let world_base = Isometry3::new(Vector3::new(2600.0, -900.0, 300.0), Vector3::new(0.02, -0.03, 2.4));
    let flange_target = Isometry3::new(Vector3::new(40.0, 10.0, 70.0), Vector3::new(0.3, 0.0, -0.8));
    let poses = poses(args, &built, (&world_base, &flange_target), &mut random);
    let off = Vector3::from([0; 3].map(|_| random.random_range(-TIP_MM..TIP_MM)));
    let touched = Touched::new(equipment, off);
    let touches = touches(&built, &touched, &mut random)?;
    let Touched { tip, mark, is_part_held, .. } = touched;
    let tip = if is_part_held { mark } else { tip };
    Ok((Measurements { poses, touches }, Truth { deviation, tip, is_part_held, world_base, flange_target }))
}

/// Poses of the target, at joints all over the reach of the arm.
fn poses(
    args: &Args,
    built: &Arm,
    (world_base, flange_target): (&Isometry3<f64>, &Isometry3<f64>),
    random: &mut Pcg64Mcg,
) -> Vec<MeasuredPose> {
    let limits = *built.limits();
    let mut poses = Vec::new();
    for _ in 0..args.poses {
        let joint = |k: usize| (limits.lower[k].max(-JOINTS), limits.upper[k].min(JOINTS));
        let joints: [f64; 6] = std::array::from_fn(|k| random.random_range(joint(k).0..=joint(k).1));
        let target = world_base * built.forward(&joints) * flange_target;
        let turn = UnitQuaternion::from_scaled_axis(noise(random, args.noise_mm / args.radian_mm));
        poses.push(MeasuredPose {
            joints,
            position: (target.translation.vector + noise(random, args.noise_mm)).into(),
            rotation: Some(turn * target.rotation),
        });
    }
    poses
}

/// What touches what: the nozzle on the flange a mark beside the plate; or a pin at the middle of the plate in the hand the nozzle.
struct Touched {
    /// What touches, on the flange.
    tip: Point3<f64>,
    /// What is touched, in the base.
    mark: Point3<f64>,
    /// The tool upright over the mark, or the plate under the nozzle.
    upright: UnitQuaternion<f64>,
    is_part_held: bool,
}

impl Touched {
    /// With the nozzle off its place in the workcell.
    fn new(equipment: &Equipment, off: Vector3<f64>) -> Self {
        let (mount, part) = equipment.part_frame();
        let (_, nozzle) = equipment.nozzle_frame();
        let nozzle_at = Point3::from(nozzle.translation.vector) + off;
        if equipment.model().held == Held::Part {
            let upright = nozzle.rotation * part.rotation.inverse();
            let tip = Point3::from(part.translation.vector);
            return Touched { tip, mark: nozzle_at, upright, is_part_held: true };
        }
        let place = if mount == curvlay_kinematics::scene::Mount::Base {
            part.translation.vector
        } else {
            Vector3::new(600.0, 0.0, 200.0)
        };
        Touched { tip: nozzle_at, mark: Point3::from(place), upright: nozzle.rotation.inverse(), is_part_held: false }
    }
}

/// Touches by hand, the tool leaning to all sides, in postures that the arm can take.
fn touches(built: &Arm, touched: &Touched, random: &mut Pcg64Mcg) -> Result<Vec<Touch>, Failure> {
    let Touched { tip, mark, upright, .. } = touched;
    let mut touches = Vec::new();
    for _ in 0..TRIES {
        if touches.len() == TOUCHES {
            break;
        }
        let spin = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.random_range(-PI..PI));
        let side = random.random_range(-PI..PI);
        let lean = UnitQuaternion::from_scaled_axis(
            Vector3::new(side.cos(), side.sin(), 0.0) * random.random_range(0.3..LEAN),
        );
        let rotation = lean * spin * upright;
        let place = mark.coords - rotation * tip.coords + noise(random, TOUCH_MM);
        let found = built.inverse(&Isometry3::from_parts(Translation3::from(place), rotation))?;
        let within = found.iter().map(|(_, joints)| *joints).find(|joints| built.limits().contains(joints));
        touches.extend(within.map(Touch::Joints));
    }
    Ok(touches)
}
