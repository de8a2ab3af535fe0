//! An arm with what it holds, and its table, from the numbers of a workcell.

use super::super::axes::{Axes, Frame, Limits, NozzlePose};
use super::chain::{Chain, Links};
use super::inverse::{self, Reached};
use curvlay_kinematics::workcell::{
    ArmGeometry, FrameModel, Held, LimitsModel, NozzleModel, PositionerGeometry, PositionerPart, WorkcellModel,
};
use curvlay_kinematics::{ArmModel, DhTable, Geometry, JointLimits, OrthoLengths, PositionerModel, robots};
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// Why a workcell is no machine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RobotFault {
    /// A name that stands for no arm and no table.
    #[error("{field}: `{name}` is not known (names like it: {known}); give its lengths instead")]
    Name {
        /// The field.
        field: &'static str,
        /// The name.
        name: String,
        /// Names that are.
        known: String,
    },
    /// A number that no machine has.
    #[error("{field} is {value}: it must be finite and within 1e6")]
    Number {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A vector without a direction.
    #[error("{field} must not be zero")]
    Direction {
        /// The field.
        field: &'static str,
    },
    /// A limit that stops the machine.
    #[error("{field} is {value}: it must be above 0, or null for no limit")]
    Limit {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A kind of arm that is not known here.
    #[error("arm.geometry: such arms, and URDF, cannot be replayed yet: give its lengths or its name")]
    Arm,
    /// An arm on a track, which is no axis here.
    #[error("track: an arm on a linear track cannot be replayed yet")]
    Track,
    /// A part in the hand, and a table.
    #[error("held: an arm that holds the part has no positioner")]
    PartOnTable,
}

/// A table that tilts and turns.
#[derive(Clone, Debug)]
struct Table {
    base: Frame,
    tilt: (Vector3<f64>, Vector3<f64>),
    turn: (Vector3<f64>, Vector3<f64>),
    table: Frame,
}

/// A robot as the workcell has it.
#[derive(Clone, Debug)]
pub struct Robot {
    /// What a report calls it.
    pub name: String,
    chain: Chain,
    table: Option<Table>,
    holds_part: bool,
    part: Frame,
    nozzle: Frame,
    /// Its limits: the arm, then tilt and turn.
    pub limits: Limits,
    /// The shape of the nozzle.
    pub nozzle_model: NozzleModel,
    /// Diameter of the plate, where it is known.
    pub plate_mm: Option<f64>,
}

/// The frames that a program names: its targets are poses of the tool in the work object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolFrames {
    /// The robot holds the work object, and the tool stands in the world.
    pub part_in_hand: bool,
    /// On the flange, or in the base.
    pub tool: Frame,
    /// In the base, on the table or on the flange.
    pub work: Frame,
    /// The table carries the work object.
    pub on_table: bool,
}

fn each(field: &'static str, values: &[f64]) -> Result<(), RobotFault> {
    match values.iter().find(|value| value.is_nan() || value.abs() > 1e6) {
        Some(&value) => Err(RobotFault::Number { field, value }),
        None => Ok(()),
    }
}

fn frame_of(field: &'static str, model: &FrameModel) -> Result<Frame, RobotFault> {
    each(field, &model.position_mm)?;
    each(field, &model.rpy_deg)?;
    Ok(Frame::from_rpy(model.rpy_deg.map(f64::to_radians), model.position_mm))
}

fn unit(field: &'static str, vector: [f64; 3]) -> Result<Vector3<f64>, RobotFault> {
    each(field, &vector)?;
    Vector3::from(vector).try_normalize(1e-12).ok_or(RobotFault::Direction { field })
}

/// A frame with its origin at the tip and z against the flow, turned from the one that carries it by the shortest way: so are the targets of programs.
fn nozzle_of(model: &NozzleModel) -> Result<Frame, RobotFault> {
    each("nozzle.tip_mm", &model.tip_mm)?;
    let z = -unit("nozzle.flow", model.flow)?;
    let about = Vector3::z().cross(&z);
    let turn = match about.try_normalize(1e-12) {
        Some(axis) => Frame::rotation(&axis, about.norm().atan2(z.z)).turn,
        // Half a turn about x, or none.
        None => Frame::rotation(&Vector3::x(), if z.z < 0.0 { PI } else { 0.0 }).turn,
    };
    Ok(Frame { turn, at: model.tip_mm.into() })
}

fn arm_of(geometry: &ArmGeometry) -> Result<ArmModel, RobotFault> {
    let free = ArmModel { limits: JointLimits::NONE, ..robots::UR3 };
    match geometry {
        ArmGeometry::Named(name) => {
            let unknown = || RobotFault::Name {
                field: "arm.geometry.named",
                name: name.clone(),
                known: robots::near(name).join(", "),
            };
            robots::find(name).map(|arm| arm.model).ok_or_else(unknown)
        }
        ArmGeometry::Urdf(_) => Err(RobotFault::Arm),
        ArmGeometry::Ur { d_mm, upper_arm_mm, forearm_mm, offsets_deg, signs, j23_factor } => {
            each("arm.geometry.ur.d_mm", d_mm)?;
            each("arm.geometry.ur", &[*upper_arm_mm, *forearm_mm])?;
            let geometry = Geometry::Ur(DhTable::ur(*d_mm, *upper_arm_mm, *forearm_mm));
            each("arm.geometry.ur.offsets_deg", offsets_deg)?;
            each("arm.geometry.ur.signs", signs)?;
            each("arm.geometry.ur.j23_factor", &[*j23_factor])?;
            let offsets = offsets_deg.map(f64::to_radians);
            Ok(ArmModel { geometry, offsets, signs: *signs, j23_factor: *j23_factor, ..free })
        }
        ArmGeometry::OrthoParallel {
            a1_mm,
            a2_mm,
            b_mm,
            c1_mm,
            c2_mm,
            c3_mm,
            c4_mm,
            offsets_deg,
            signs,
            j23_factor,
        } => {
            each("arm.geometry.ortho_parallel.j23_factor", &[*j23_factor])?;
            let (a1, a2, b, c1, c2, c3, c4) = (*a1_mm, *a2_mm, *b_mm, *c1_mm, *c2_mm, *c3_mm, *c4_mm);
            each("arm.geometry.ortho_parallel", &[a1, a2, b, c1, c2, c3, c4])?;
            each("arm.geometry.ortho_parallel.offsets_deg", offsets_deg)?;
            each("arm.geometry.ortho_parallel.signs", signs)?;
            let geometry = Geometry::Ortho(OrthoLengths { a1, a2, b, c1, c2, c3, c4 });
            let offsets = offsets_deg.map(f64::to_radians);
            Ok(ArmModel { geometry, offsets, signs: *signs, j23_factor: *j23_factor, ..free })
        }
    }
}

fn table_of(part: &PositionerPart) -> Result<(Table, JointLimits<2>), RobotFault> {
    let model = match &part.geometry {
        PositionerGeometry::Named(name) => {
            let found = robots::POSITIONERS.iter().find(|(known, _)| known == name);
            *found.map(|(_, model)| *model).ok_or_else(|| RobotFault::Name {
                field: "positioner.geometry.named",
                name: name.clone(),
                known: robots::POSITIONERS.map(|(name, _)| name).join(", "),
            })?
        }
        &PositionerGeometry::Axes { tilt_origin_mm, tilt_axis, turn_origin_mm, turn_axis, table_origin_mm } => {
            PositionerModel {
                tilt_origin: tilt_origin_mm,
                tilt_axis,
                turn_origin: turn_origin_mm,
                turn_axis,
                table_origin: table_origin_mm,
                limits: JointLimits::NONE,
            }
        }
    };
    each("positioner.geometry", &[model.tilt_origin, model.turn_origin, model.table_origin].concat())?;
    let [x, y, z] = model.table_origin;
    let table = Table {
        base: frame_of("positioner.frame", &part.frame)?,
        tilt: (model.tilt_origin.into(), unit("positioner.geometry.tilt_axis", model.tilt_axis)?),
        turn: (model.turn_origin.into(), unit("positioner.geometry.turn_axis", model.turn_axis)?),
        table: Frame::shift(x, y, z),
    };
    Ok((table, model.limits))
}

/// Puts the limits of `N` axes from `first` on into `limits`: those of the workcell, or those that are known.
fn put<const N: usize>(
    limits: &mut Limits,
    first: usize,
    known: &JointLimits<N>,
    model: &LimitsModel<N>,
) -> Result<(), RobotFault> {
    let rates = [
        ("limits.max_speed_deg_s", model.max_speed_deg_s),
        ("limits.max_acceleration_rad_s2", model.max_acceleration_rad_s2),
        ("limits.max_jerk_rad_s3", model.max_jerk_rad_s3),
    ];
    for (field, values) in rates {
        let wrong = values.iter().flatten().flatten().find(|value| value.is_nan() || **value <= 0.0);
        if let Some(&value) = wrong {
            return Err(RobotFault::Limit { field, value });
        }
    }
    let pick = |all: Option<[Option<f64>; N]>, known: &[f64; N], k: usize, scale: f64, none: f64| match all {
        Some(values) => values[k].map_or(none, |value| value * scale),
        None => known[k],
    };
    let degree = 1f64.to_radians();
    for k in 0..N {
        limits.lower[first + k] = pick(model.min_deg, &known.lower, k, degree, f64::NEG_INFINITY);
        limits.upper[first + k] = pick(model.max_deg, &known.upper, k, degree, f64::INFINITY);
        limits.speed[first + k] = pick(model.max_speed_deg_s, &known.velocity, k, degree, f64::INFINITY);
        limits.acceleration[first + k] =
            pick(model.max_acceleration_rad_s2, &known.acceleration, k, 1.0, f64::INFINITY);
        limits.jerk[first + k] = pick(model.max_jerk_rad_s3, &known.jerk, k, 1.0, f64::INFINITY);
    }
    Ok(())
}

impl Table {
    /// The table in the base.
    fn at(&self, tilt: f64, turn: f64) -> Frame {
        let about = |(point, axis): &(Vector3<f64>, Vector3<f64>), angle: f64| {
            let turned = Frame::rotation(axis, angle);
            Frame { turn: turned.turn, at: point - turned.turn * point }
        };
        self.base.then(&about(&self.tilt, tilt)).then(&about(&self.turn, turn)).then(&self.table)
    }
}

impl Robot {
    /// The robot of a workcell.
    ///
    /// # Errors
    /// [`RobotFault`] names the field.
    pub fn new(model: &WorkcellModel) -> Result<Self, RobotFault> {
        if model.track.is_some() {
            return Err(RobotFault::Track);
        }
        let arm = arm_of(&model.arm.geometry)?;
        let calibration = model.arm.calibration.unwrap_or_default();
        let mut moved = [Frame::identity(); 5];
        for (frame, axis) in moved.iter_mut().zip(&calibration.axes) {
            *frame = frame_of("arm.calibration.axes", axis)?;
        }
        each("arm.calibration.offsets_deg", &calibration.offsets_deg)?;
        let turned = calibration.offsets_deg.map(f64::to_radians);
        let mut limits = Limits::NONE;
        put(&mut limits, 0, &arm.limits, &model.arm.limits)?;
        let table = model.positioner.as_ref().map(table_of).transpose()?;
        if let (Some((_, known)), Some(part)) = (&table, &model.positioner) {
            put(&mut limits, 6, known, &part.limits)?;
        }
        let holds_part = model.held == Held::Part;
        if holds_part && table.is_some() {
            return Err(RobotFault::PartOnTable);
        }
        Ok(Robot {
            name: model.name.clone(),
            chain: Chain::new(&arm, &turned, &moved).ok_or(RobotFault::Arm)?,
            table: table.map(|(table, _)| table),
            holds_part,
            part: frame_of("part", &model.part)?,
            nozzle: nozzle_of(&model.nozzle)?,
            limits,
            nozzle_model: model.nozzle,
            plate_mm: model.plate.diameter_mm,
        })
    }

    /// How many axes it has.
    pub fn axes(&self) -> usize {
        if self.table.is_some() { 8 } else { 6 }
    }

    /// The frames of the workcell: the nozzle as the tool, with z along the flow as controllers have it, and the part as the work object.
    pub fn frames(&self) -> ToolFrames {
        let tool = self.nozzle.then(&Frame::rotation(&Vector3::x(), PI));
        let (work, on_table) = (self.part, self.table.is_some());
        ToolFrames { part_in_hand: self.holds_part, tool, work, on_table }
    }

    /// Where the nozzle is on the part.
    pub fn nozzle_on_part(&self, axes: &Axes) -> NozzlePose {
        let flange = self.chain.at(axes).flange;
        let (part, nozzle) = if self.holds_part {
            (flange.then(&self.part), self.nozzle)
        } else {
            (self.carrier(axes).then(&self.part), flange.then(&self.nozzle))
        };
        let back = part.turn.transpose();
        let tip = Point3::from(back * (nozzle.at - part.at));
        NozzlePose { tip, axis: back * nozzle.turn.column(2) }
    }

    /// What carries a part that the robot does not hold: the table or the base.
    fn carrier(&self, axes: &Axes) -> Frame {
        self.table.as_ref().map_or_else(Frame::identity, |table| table.at(axes[6], axes[7]))
    }

    /// The pose of the tool in the work object.
    pub fn target_at(&self, frames: &ToolFrames, axes: &Axes) -> Frame {
        let flange = self.chain.at(axes).flange;
        if frames.part_in_hand {
            flange.then(&frames.work).inverse().then(&frames.tool)
        } else {
            self.work(frames, axes).inverse().then(&flange.then(&frames.tool))
        }
    }

    /// The work object in the base, where the robot does not hold it.
    fn work(&self, frames: &ToolFrames, axes: &Axes) -> Frame {
        if frames.on_table { self.carrier(axes).then(&frames.work) } else { frames.work }
    }

    /// Joints at which the tool is at a pose in the work object, from joints nearby; the table stays where `seed` has it.
    pub fn solve(&self, frames: &ToolFrames, target: &Frame, seed: &Axes) -> Reached {
        let flange = if frames.part_in_hand {
            frames.tool.then(&target.inverse()).then(&frames.work.inverse())
        } else {
            self.work(frames, seed).then(target).then(&frames.tool.inverse())
        };
        inverse::solve(&self.chain, &flange, seed)
    }

    /// Bones from joint to joint up to what the robot holds, and the part frame, in the base.
    pub fn drawn(&self, axes: &Axes) -> (Vec<[Point3<f64>; 2]>, Frame) {
        let Links { joints, flange } = self.chain.at(axes);
        let part = if self.holds_part { flange.then(&self.part) } else { self.carrier(axes).then(&self.part) };
        let held = if self.holds_part {
            part.at
        } else {
            let nozzle = flange.then(&self.nozzle);
            nozzle.at + nozzle.turn.column(2) * self.nozzle_model.block_top_mm
        };
        let places = std::iter::once(Vector3::zeros()).chain(joints.map(|joint| joint.at)).chain([flange.at, held]);
        let places: Vec<Point3<f64>> = places.map(Point3::from).collect();
        (places.windows(2).map(|ends| [ends[0], ends[1]]).collect(), part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvlay_kinematics::workcell::{AnyWorkcell, Workcell};
    use proptest::prelude::*;

    const CELLS: [&str; 3] = [
        include_str!("../../cells/ur10.json"),
        include_str!("../../cells/ur3.json"),
        include_str!("../../cells/irb1200-table.json"),
    ];

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(48) })]

        #[test]
        fn the_nozzle_is_where_the_library_has_it(arm in prop::array::uniform6(-1.5f64..1.5), tilt in -1.0f64..1.0, turn in -3.0f64..3.0) {
            for text in CELLS {
                let model = WorkcellModel::from_json(text.as_bytes()).unwrap();
                let robot = Robot::new(&model).unwrap();
                let mut axes: Axes = [0.0; 8];
                axes[..6].copy_from_slice(&arm);
                let expected = match AnyWorkcell::new(model).unwrap() {
                    AnyWorkcell::Six(cell) => cell.nozzle_on_part(&arm),
                    AnyWorkcell::Seven(_) => unreachable!("no cell here has a track"),
                    AnyWorkcell::Eight(cell) => {
                        (axes[6], axes[7]) = (tilt, turn);
                        cell.nozzle_on_part(&axes)
                    }
                };
                let Some(expected) = expected else { continue };
                let pose = robot.nozzle_on_part(&axes);
                prop_assert!((pose.tip.coords - expected.translation.vector).norm() < 1e-9, "{}", robot.name);
                // Targets of the library are poses of this frame.
                let target = curvlay_kinematics::workcell::tool_frame(&expected);
                let own = robot.target_at(&robot.frames(), &axes);
                prop_assert!((own.turn - Frame::from(&target).turn).norm() < 1e-9, "{}", robot.name);
                prop_assert!((pose.axis - expected * Vector3::z()).norm() < 1e-12, "{}", robot.name);
            }
        }

        #[test]
        fn targets_are_reached_again(arm in prop::array::uniform6(-1.2f64..1.2), off in prop::array::uniform6(-0.05f64..0.05)) {
            for text in CELLS {
                let robot = Robot::new(&WorkcellModel::from_json(text.as_bytes()).unwrap()).unwrap();
                let frames = robot.frames();
                let mut axes: Axes = [0.0; 8];
                axes[..6].copy_from_slice(&arm);
                (axes[6], axes[7]) = (0.4, -0.3);
                // Away from stretched elbows and straight wrists.
                (axes[2], axes[4]) = (1.0 + 0.2 * arm[2], 1.0 + 0.2 * arm[4]);
                let mut seed = axes;
                (0..6).for_each(|k| seed[k] += off[k]);
                let target = robot.target_at(&frames, &axes);
                let reached = robot.solve(&frames, &target, &seed);
                prop_assert!(reached.is_reached(), "{} {reached:?}", robot.name);
                let again = robot.target_at(&frames, &reached.axes);
                prop_assert!((again.at - target.at).norm() < 1e-6 && again.turn_to(&target).norm() < 1e-8);
                prop_assert!((reached.axes[6] - axes[6]).abs() <= 0.0);
            }
        }
    }

    #[test]
    fn bad_numbers_name_their_field() {
        let good = WorkcellModel::from_json(CELLS[2].as_bytes()).unwrap();
        let fault = |change: fn(&mut WorkcellModel)| {
            let mut model = good.clone();
            change(&mut model);
            Robot::new(&model).unwrap_err().to_string()
        };
        assert!(
            fault(|m| m.arm.geometry = ArmGeometry::Named("R2".into()))
                .starts_with("arm.geometry.named: `R2` is not known")
        );
        assert!(fault(|m| m.nozzle.flow = [0.0; 3]).contains("nozzle.flow must not be zero"));
        assert!(fault(|m| m.nozzle.tip_mm[1] = f64::NAN).contains("nozzle.tip_mm is NaN"));
        assert!(fault(|m| m.held = Held::Part).starts_with("held:"));
        assert!(
            fault(|m| m.arm.limits.max_acceleration_rad_s2 = Some([Some(0.0); 6]))
                .contains("max_acceleration_rad_s2 is 0")
        );
        assert!(fault(|m| m.part.position_mm[0] = f64::INFINITY).starts_with("part is inf"));
    }
}
