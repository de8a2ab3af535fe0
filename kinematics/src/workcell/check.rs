//! From the numbers of a file to what they describe, each checked under the name that it has in the file.

use super::controller::{ControllerModel, ProgramLanguage};
use super::model::{
    ArmGeometry, ArmPart, CalibrationModel, FrameModel, LimitsModel, NozzleModel, PlateModel, PositionerGeometry,
    PositionerPart, RollerModel, TrackPart, VERSION,
};
use crate::arm::robots::{self, CatalogueArm, POSITIONERS};
use crate::arm::{Arm, ArmDeviation, ArmError, ArmModel, DhTable, Geometry, OrthoLengths};
use crate::limits::JointLimits;
use crate::positioner::{Positioner, PositionerError, PositionerModel};
use crate::scene::{MAX_COORDINATE, SceneError};
use crate::setup::{SetupError, nozzle_frame};
use crate::track::{Track, TrackError, TrackModel};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};

/// Why numbers make no workcell. `path` is the field, as in the file: `solids[2].shape.block.min_mm[0]`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorkcellError {
    /// A version of the format that this crate does not know.
    #[error("version: {found} is not known, only {VERSION} is")]
    Version {
        /// What the model says.
        found: u32,
    },
    /// No such robot, or no such positioner.
    #[error("{path}: no robot is called `{name}`; {known}")]
    UnknownRobot {
        /// The field.
        path: String,
        /// Its value.
        name: String,
        /// In words: the names that are near, or known, and what to give instead.
        known: String,
    },
    /// A URDF has no arm for this workcell.
    #[error("arm.geometry.urdf: {file}: {what}")]
    Urdf {
        /// The file.
        file: String,
        /// What is wrong with it.
        what: String,
    },
    /// A URDF has not been read in: see `WorkcellModel::with_urdf` (cargo feature `urdf`).
    #[error("arm.geometry.urdf: {file}: the file was not read: call WorkcellModel::with_urdf first")]
    UrdfNotRead {
        /// The file.
        file: String,
    },
    /// A number cannot be what it is.
    #[error("{path} is {value}: it must be {must}")]
    Number {
        /// The field.
        path: String,
        /// Its value.
        value: f64,
        /// What it must be.
        must: String,
    },
    /// An axis or a direction of flow is zero.
    #[error("{path} is zero: it must be a direction")]
    NoDirection {
        /// The field.
        path: String,
    },
    /// A mesh of a link cannot be read or holds nothing.
    #[error("{path}: {file}: {what}")]
    LinkMesh {
        /// The field.
        path: String,
        /// The file.
        file: String,
        /// What is wrong with it.
        what: String,
    },
    /// A link has no mesh, while others have.
    #[error("arm.bodies.meshes: link {link} ({name}) has no mesh; each of the links 0 to 6 needs one")]
    NoLinkMesh {
        /// The link.
        link: usize,
        /// What it is called.
        name: &'static str,
    },
    /// A name is empty, stands for something else, or is there twice.
    #[error("{path}: the name `{name}` {what}")]
    Name {
        /// The field.
        path: String,
        /// Its value.
        name: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// Something is on a table that the workcell does not have, or on a link that the arm does not have.
    #[error("{path}: {what}")]
    Mount {
        /// The field.
        path: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A setting of `servoj`, which the controller of this arm does not have.
    #[error("{path}: only arms of Universal Robots have `servoj`; leave it out")]
    NoServoj {
        /// The field.
        path: &'static str,
    },
    /// A group output, which only programs in RAPID have.
    #[error("controller.filament_group: only programs in RAPID have a group output; leave it out")]
    NoGroup,
    /// The language of another maker's controller.
    #[error(
        "controller.language: arms of Universal Robots take `urscript`, all others `rapid`, `krl` or `tp`; leave it out, or name \
         the one of the arm's controller"
    )]
    Language,
    /// The arm cannot reach what it has to.
    #[error("{path}: stretched out, the arm reaches {reach_mm:.1} mm: {what}")]
    Reach {
        /// The field.
        path: &'static str,
        /// The sum of its lengths.
        reach_mm: f64,
        /// What is wrong with that.
        what: String,
    },
    /// The arm holds the part, and a table is there that should carry it.
    #[error("held: the arm holds the part, but a positioner must carry it; `held` must be `nozzle` with a positioner")]
    HeldPartOnTable,
    /// The arm on a track holds the part.
    #[error("held: the arm on a track holds the part; `held` must be `nozzle` with a track")]
    HeldPartOnTrack,
    /// The carriage of a track is always in contact with a solid.
    #[error("{path}: {what}")]
    Carriage {
        /// The field.
        path: String,
        /// What is wrong with it.
        what: String,
    },
    /// A plate that is a disc and a rectangle.
    #[error("plate.size_mm: the plate has `diameter_mm` as well; leave one of the two out")]
    TwoPlates,
    /// A track and a table, which are not planned together.
    #[error("track: the workcell has a positioner as well, and a motion is planned with one of the two; leave one out")]
    TrackAndTable,
    /// A track.
    #[error("track: {source}")]
    Track {
        /// What is wrong with it.
        #[from]
        source: TrackError,
    },
    /// The arm.
    #[error("{path}: {source}")]
    Arm {
        /// The field.
        path: &'static str,
        /// What is wrong with it.
        source: ArmError,
    },
    /// The table.
    #[error("{path}: {source}")]
    Positioner {
        /// The field.
        path: &'static str,
        /// What is wrong with it.
        source: PositionerError,
    },
    /// A frame.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The bodies make no scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

pub(super) fn wrong(path: impl Into<String>, value: f64, must: impl Into<String>) -> WorkcellError {
    WorkcellError::Number { path: path.into(), value, must: must.into() }
}

/// A number that a length or a coordinate can be.
pub(super) fn finite(path: impl Into<String>, value: f64) -> Result<f64, WorkcellError> {
    // NaN fails the comparison.
    if value.abs() <= MAX_COORDINATE { Ok(value) } else { Err(wrong(path, value, "a number from -1e6 to 1e6")) }
}

pub(super) fn positive(path: impl Into<String>, value: f64) -> Result<f64, WorkcellError> {
    if value > 0.0 && value <= MAX_COORDINATE { Ok(value) } else { Err(wrong(path, value, "above 0 and at most 1e6")) }
}

pub(super) fn each<const K: usize>(path: &str, values: &[f64; K]) -> Result<[f64; K], WorkcellError> {
    for (k, &value) in values.iter().enumerate() {
        finite(format!("{path}[{k}]"), value)?;
    }
    Ok(*values)
}

fn radians(path: &str, degrees: f64) -> Result<f64, WorkcellError> {
    finite(path, degrees).map(f64::to_radians)
}

fn direction(path: &str, value: &[f64; 3]) -> Result<UnitVector3<f64>, WorkcellError> {
    let found = UnitVector3::try_new(Vector3::from(each(path, value)?), f64::MIN_POSITIVE);
    found.ok_or_else(|| WorkcellError::NoDirection { path: path.into() })
}

/// No arm reaches less than this, in millimetres: its lengths are in metres.
const MIN_REACH_MM: f64 = 10.0;

/// The sum of an arm's lengths, more than the flange can be away from the base.
fn reach_mm(arm: &ArmModel) -> f64 {
    let sum = |lengths: &[f64]| lengths.iter().map(|length| length.abs()).sum::<f64>();
    match arm.geometry {
        Geometry::Ur(DhTable { d, a, .. }) => sum(&d) + sum(&a),
        Geometry::Ortho(OrthoLengths { a1, a2, b, c1, c2, c3, c4 }) => sum(&[a1, a2, b, c1, c2, c3, c4]),
    }
}

/// Refuses an arm that is too short to bring part and nozzle together at all.
///
/// # Arguments
/// * `tool_mm`: from the flange to the far end of what it holds.
/// * `away`: the field of the rest, and how far that is from the base, if it stands still.
pub(super) fn reach(arm: &ArmModel, tool_mm: f64, away: Option<(&'static str, f64)>) -> Result<(), WorkcellError> {
    let reach_mm = reach_mm(arm);
    if reach_mm < MIN_REACH_MM {
        let what = "lengths are in millimetres; were metres meant?".to_owned();
        return Err(WorkcellError::Reach { path: "arm.geometry", reach_mm, what });
    }
    match away {
        Some((path, away_mm)) if away_mm > reach_mm + tool_mm => {
            let what =
                format!("with the {tool_mm:.1} mm of what it holds it does not come to a place {away_mm:.1} mm away");
            Err(WorkcellError::Reach { path, reach_mm, what })
        }
        _ => Ok(()),
    }
}

pub(super) fn version(found: u32) -> Result<(), WorkcellError> {
    if found == VERSION { Ok(()) } else { Err(WorkcellError::Version { found }) }
}

pub(super) fn frame(path: &str, model: &FrameModel) -> Result<Isometry3<f64>, WorkcellError> {
    let position = each(&format!("{path}.position_mm"), &model.position_mm)?;
    let [roll, pitch, yaw] = each(&format!("{path}.rpy_deg"), &model.rpy_deg)?.map(f64::to_radians);
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(Isometry3::from_parts(Translation3::from(position), rotation))
}

/// The limits of a robot, with what a workcell says of them.
fn limits<const N: usize>(
    path: &str,
    known: JointLimits<N>,
    model: &LimitsModel<N>,
) -> Result<JointLimits<N>, WorkcellError> {
    let mut limits = known;
    let LimitsModel { min_deg, max_deg, max_speed_deg_s, max_acceleration_rad_s2, max_jerk_rad_s3 } = model;
    let stops = [("min_deg", min_deg, &mut limits.lower, -1.0), ("max_deg", max_deg, &mut limits.upper, 1.0)];
    for (name, given, stops, side) in stops {
        let Some(given) = given else { continue };
        for joint in 0..N {
            let path = || format!("{path}.{name}[{joint}]");
            let angle = given[joint].map(|angle| finite(path(), angle).map(f64::to_radians));
            stops[joint] = angle.transpose()?.unwrap_or(side * f64::INFINITY);
        }
    }
    let bounds = [
        ("max_speed_deg_s", max_speed_deg_s, &mut limits.velocity, 1f64.to_radians()),
        ("max_acceleration_rad_s2", max_acceleration_rad_s2, &mut limits.acceleration, 1.0),
        ("max_jerk_rad_s3", max_jerk_rad_s3, &mut limits.jerk, 1.0),
    ];
    for (name, given, bounds, unit) in bounds {
        let Some(given) = given else { continue };
        for joint in 0..N {
            bounds[joint] = match given[joint] {
                None => f64::INFINITY,
                Some(value) if value > 0.0 && value < f64::INFINITY => value * unit,
                Some(value) => {
                    let must = "above 0 and finite, or null for no limit";
                    return Err(wrong(format!("{path}.{name}[{joint}]"), value, must));
                }
            };
        }
    }
    for joint in 0..N {
        let (lower, upper) = (limits.lower[joint], limits.upper[joint]);
        if lower > upper {
            let must = format!("at most the greatest angle, {}", upper.to_degrees());
            return Err(wrong(format!("{path}.min_deg[{joint}]"), lower.to_degrees(), must));
        }
    }
    Ok(limits)
}

/// The numbers of one of the tables that have names.
fn named_table(path: &str, name: &str) -> Result<PositionerModel, WorkcellError> {
    let found = POSITIONERS.iter().find(|(known, _)| *known == name);
    found.map(|(_, model)| **model).ok_or_else(|| WorkcellError::UnknownRobot {
        path: path.into(),
        name: name.into(),
        known: format!("known are {}", POSITIONERS.map(|(known, _)| known).join(", ")),
    })
}

/// What an arm without a name is given by, for errors: the lengths of an IRB 2600-12/1.85.
const BY_LENGTHS: &str = r#"{"ortho_parallel": {"a1_mm": 150, "a2_mm": -115, "b_mm": 0, "c1_mm": 445, "c2_mm": 900, "c3_mm": 795, "c4_mm": 85, "offsets_deg": [0, 0, -90, 0, 0, 0], "signs": [1, 1, 1, 1, 1, 1]}}"#;

/// One of the arms that have names.
pub(super) fn named_arm(path: &str, name: &str) -> Result<&'static CatalogueArm, WorkcellError> {
    robots::find(name).ok_or_else(|| {
        let near = robots::near(name);
        let near = if near.is_empty() { String::new() } else { format!("near are {}; ", near.join(", ")) };
        let known = format!(
            "{near}examples/cells/arms.json has all names; any other arm is given by its lengths instead of a name, like {BY_LENGTHS}"
        );
        WorkcellError::UnknownRobot { path: path.into(), name: name.into(), known }
    })
}

/// How far the mounting face of the arm is below its base frame.
pub(super) fn mount_below_base(part: &ArmPart) -> Result<f64, WorkcellError> {
    match (part.mount_below_base_mm, &part.geometry) {
        (Some(below), _) => finite("arm.mount_below_base_mm", below),
        (None, ArmGeometry::Named(name)) => Ok(named_arm("arm.geometry.named", name)?.mount_below_base_mm),
        (None, _) => Ok(0.0),
    }
}

/// The arm, and the numbers that it was made from, with the limits of the workcell.
pub(super) fn arm(part: &ArmPart) -> Result<(Arm, ArmModel), WorkcellError> {
    let free = |geometry, offsets, signs, j23_factor| ArmModel {
        geometry,
        offsets,
        signs,
        j23_factor,
        limits: JointLimits::NONE,
    };
    let path = "arm.geometry";
    let model = match &part.geometry {
        ArmGeometry::Named(name) => named_arm("arm.geometry.named", name)?.model,
        ArmGeometry::Urdf(urdf) => return Err(WorkcellError::UrdfNotRead { file: urdf.file().into() }),
        ArmGeometry::Ur { d_mm, upper_arm_mm, forearm_mm, offsets_deg, signs, j23_factor } => {
            let path = "arm.geometry.ur";
            let table = DhTable::ur(
                each(&format!("{path}.d_mm"), d_mm)?,
                finite(format!("{path}.upper_arm_mm"), *upper_arm_mm)?,
                finite(format!("{path}.forearm_mm"), *forearm_mm)?,
            );
            let offsets = each(&format!("{path}.offsets_deg"), offsets_deg)?.map(f64::to_radians);
            let j23_factor = finite(format!("{path}.j23_factor"), *j23_factor)?;
            free(Geometry::Ur(table), offsets, each(&format!("{path}.signs"), signs)?, j23_factor)
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
            let path = "arm.geometry.ortho_parallel";
            let length = |name: &str, value: f64| finite(format!("{path}.{name}"), value);
            let lengths = OrthoLengths {
                a1: length("a1_mm", *a1_mm)?,
                a2: length("a2_mm", *a2_mm)?,
                b: length("b_mm", *b_mm)?,
                c1: length("c1_mm", *c1_mm)?,
                c2: length("c2_mm", *c2_mm)?,
                c3: length("c3_mm", *c3_mm)?,
                c4: length("c4_mm", *c4_mm)?,
            };
            let offsets = each(&format!("{path}.offsets_deg"), offsets_deg)?.map(f64::to_radians);
            let j23_factor = finite(format!("{path}.j23_factor"), *j23_factor)?;
            free(Geometry::Ortho(lengths), offsets, each(&format!("{path}.signs"), signs)?, j23_factor)
        }
    };
    let limits = limits("arm.limits", model.limits, &part.limits)?;
    let model = ArmModel { limits, ..model };
    let nominal = Arm::new(&model).map_err(|source| WorkcellError::Arm { path, source })?;
    let arm = match &part.calibration {
        None => nominal,
        Some(calibration) => {
            let source = |source| WorkcellError::Arm { path: "arm.calibration", source };
            Arm::calibrated(&model, &deviation(calibration)?).map_err(source)?
        }
    };
    Ok((arm, model))
}

/// How the arm as built differs.
pub(super) fn deviation(calibration: &CalibrationModel) -> Result<ArmDeviation, WorkcellError> {
    let path = "arm.calibration";
    let offsets = each(&format!("{path}.offsets_deg"), &calibration.offsets_deg)?.map(f64::to_radians);
    let mut axes = [Isometry3::identity(); 5];
    for (k, axis) in axes.iter_mut().enumerate() {
        *axis = frame(&format!("{path}.axes[{k}]"), &calibration.axes[k])?;
    }
    Ok(ArmDeviation { offsets, axes })
}

/// A table in a workcell.
pub(super) struct Table {
    pub positioner: Positioner,
    pub print_tilt: [f64; 2],
    pub tool_angle: f64,
}

pub(super) fn positioner(part: &PositionerPart) -> Result<Table, WorkcellError> {
    let model = match &part.geometry {
        PositionerGeometry::Named(name) => named_table("positioner.geometry.named", name)?,
        PositionerGeometry::Axes { tilt_origin_mm, tilt_axis, turn_origin_mm, turn_axis, table_origin_mm } => {
            let path = |name: &str| format!("positioner.geometry.axes.{name}");
            direction(&path("tilt_axis"), tilt_axis)?;
            direction(&path("turn_axis"), turn_axis)?;
            PositionerModel {
                tilt_origin: each(&path("tilt_origin_mm"), tilt_origin_mm)?,
                tilt_axis: *tilt_axis,
                turn_origin: each(&path("turn_origin_mm"), turn_origin_mm)?,
                turn_axis: *turn_axis,
                table_origin: each(&path("table_origin_mm"), table_origin_mm)?,
                limits: JointLimits::NONE,
            }
        }
    };
    let limits = limits("positioner.limits", model.limits, &part.limits)?;
    let base_positioner = frame("positioner.frame", &part.frame)?;
    let positioner = Positioner::new(&PositionerModel { limits, ..model }, &base_positioner)
        .map_err(|source| WorkcellError::Positioner { path: "positioner.geometry", source })?;
    let [min, max] = each("positioner.print_tilt_deg", &part.print_tilt_deg)?;
    let print_tilt = [min, max].map(f64::to_radians);
    let within = |tilt: f64| limits.lower[0] <= tilt && tilt <= limits.upper[0];
    let path = |end: usize| format!("positioner.print_tilt_deg[{end}]");
    if min > max {
        return Err(wrong(path(0), min, format!("at most {max}, the greatest tilt")));
    }
    for (end, (degrees, tilt)) in [min, max].into_iter().zip(print_tilt).enumerate() {
        if !within(tilt) {
            return Err(wrong(path(end), degrees, "within the limits of the tilt"));
        }
    }
    let tool_angle = radians("positioner.tool_angle_deg", part.tool_angle_deg)?;
    Ok(Table { positioner, print_tilt, tool_angle })
}

/// The track, in units of the reach of its arm.
pub(super) fn track(part: &TrackPart, arm: &ArmModel) -> Result<Track, WorkcellError> {
    direction("track.direction", &part.direction)?;
    let [least, most] = each("track.range_mm", &part.range_mm)?;
    if least > most {
        return Err(wrong("track.range_mm[0]", least, format!("at most the greatest position, {most}")));
    }
    let limit = |name: &str, value: Option<f64>| match value {
        None => Ok(f64::INFINITY),
        Some(value) if value > 0.0 && value < f64::INFINITY => Ok(value),
        Some(value) => Err(wrong(format!("track.{name}"), value, "above 0 and finite")),
    };
    let home_mm = part.home_mm.unwrap_or(0.5 * (least + most));
    if !(least..=most).contains(&home_mm) {
        return Err(wrong("track.home_mm", home_mm, format!("within the range, {least} to {most}")));
    }
    finite("track.tool_angle_deg", part.tool_angle_deg)?;
    let model = TrackModel {
        direction: part.direction,
        range_mm: part.range_mm,
        zero_mm: finite("track.zero_mm", part.zero_mm)?,
        speed_mm_s: limit("max_speed_mm_s", Some(part.max_speed_mm_s))?,
        acceleration_mm_s2: limit("max_acceleration_mm_s2", part.max_acceleration_mm_s2)?,
        jerk_mm_s3: limit("max_jerk_mm_s3", part.max_jerk_mm_s3)?,
    };
    Ok(Track::new(&model, reach_mm(arm).max(MIN_REACH_MM))?)
}

/// How far a place is from where the base of an arm on a track comes nearest to it.
pub(super) fn beside_track(track: &Track, place: &Vector3<f64>) -> f64 {
    let (low, high) = (track.shift(track.limits().lower[0]), track.shift(track.limits().upper[0]));
    let way = high - low;
    let share = (place - low).dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE);
    (low + way * share.clamp(0.0, 1.0) - place).norm()
}

/// The frame of the nozzle on what carries it. Its shape is checked as well.
pub(super) fn nozzle(model: &NozzleModel) -> Result<Isometry3<f64>, WorkcellError> {
    let tip = Point3::from(each("nozzle.tip_mm", &model.tip_mm)?);
    let flow = direction("nozzle.flow", &model.flow)?;
    let flat = positive("nozzle.tip_flat_mm", model.tip_flat_mm)?;
    let height = positive("nozzle.cone_height_mm", model.cone_height_mm)?;
    let block = positive("nozzle.block_diameter_mm", model.block_diameter_mm)?;
    let top = positive("nozzle.block_top_mm", model.block_top_mm)?;
    let half_angle = model.cone_half_angle_deg;
    if !(half_angle > 0.0 && half_angle < 90.0) {
        return Err(wrong("nozzle.cone_half_angle_deg", half_angle, "above 0 and below 90"));
    }
    if flat > height {
        let must = format!("at most the height of the cone, {height}");
        return Err(wrong("nozzle.tip_flat_mm", flat, must));
    }
    let cone = flat + 2.0 * height * half_angle.to_radians().tan();
    if block < cone {
        let must = format!("at least the diameter of the cone where the block begins, {cone}");
        return Err(wrong("nozzle.block_diameter_mm", block, must));
    }
    if top <= height {
        let must = format!("above the height of the cone, {height}, where the block begins");
        return Err(wrong("nozzle.block_top_mm", top, must));
    }
    Ok(nozzle_frame(&tip, &flow))
}

pub(super) fn roller(model: &RollerModel) -> Result<(), WorkcellError> {
    let diameter = positive("roller.diameter_mm", model.diameter_mm)?;
    positive("roller.width_mm", model.width_mm)?;
    positive("roller.block_diameter_mm", model.block_diameter_mm)?;
    let top = positive("roller.block_top_mm", model.block_top_mm)?;
    if top <= diameter {
        return Err(wrong("roller.block_top_mm", top, format!("above the diameter of the roller, {diameter}")));
    }
    model.mount_deg.map_or(Ok(()), |degrees| finite("roller.mount_deg", degrees).map(|_| ()))
}

pub(super) fn plate(model: &PlateModel) -> Result<(), WorkcellError> {
    positive("plate.thickness_mm", model.thickness_mm)?;
    if let Some(size) = model.size_mm {
        if model.diameter_mm.is_some() {
            return Err(WorkcellError::TwoPlates);
        }
        for (k, edge) in size.into_iter().enumerate() {
            positive(format!("plate.size_mm[{k}]"), edge)?;
        }
    }
    model.diameter_mm.map_or(Ok(()), |diameter| positive("plate.diameter_mm", diameter).map(|_| ()))
}

/// A home posture: a number for each joint, within the limits.
pub(super) fn home(
    home_deg: Option<&[f64]>,
    arm: &JointLimits<6>,
    table: Option<&JointLimits<2>>,
) -> Result<(), WorkcellError> {
    let Some(home_deg) = home_deg else { return Ok(()) };
    let of_arm = arm.lower.into_iter().zip(arm.upper);
    let limits: Vec<(f64, f64)> =
        of_arm.chain(table.into_iter().flat_map(|table| table.lower.into_iter().zip(table.upper))).collect();
    if home_deg.len() != limits.len() {
        let must = format!("a list of {} angles, one for each joint", limits.len());
        return Err(wrong("home_deg.length", home_deg.len() as f64, must));
    }
    for (joint, (&degrees, (lower, upper))) in home_deg.iter().zip(limits).enumerate() {
        let path = format!("home_deg[{joint}]");
        if !(lower..=upper).contains(&radians(&path, degrees)?) {
            return Err(wrong(path, degrees, "within the limits of the joint"));
        }
    }
    Ok(())
}

/// Ranges that the controllers take: `EquipLag` of RAPID, `servoj` of URScript.
pub(super) fn controller(model: &ControllerModel, arm: &Arm) -> Result<(), WorkcellError> {
    let ControllerModel { extruder_lag_s, servoj_gain, servoj_lookahead_s, language, filament_group } = *model;
    let within = |path, value: f64, [min, max]: [f64; 2]| match (min..=max).contains(&value) {
        true => Ok(()),
        false => Err(wrong(path, value, format!("from {min} to {max}"))),
    };
    within("controller.extruder_lag_s", extruder_lag_s, [0.0, 0.5])?;
    if let Some(group) = filament_group {
        within("controller.filament_group.step_mm_s", group.step_mm_s, [1e-6, 1e3])?;
        within("controller.filament_group.bits", f64::from(group.bits), [1.0, 23.0])?;
    }
    for (path, value, range) in [
        ("controller.servoj_gain", servoj_gain, [100.0, 2000.0]),
        ("controller.servoj_lookahead_s", servoj_lookahead_s, [0.03, 0.2]),
    ] {
        let Some(value) = value else { continue };
        if !arm.is_ur() {
            return Err(WorkcellError::NoServoj { path });
        }
        within(path, value, range)?;
    }
    match language {
        // Streams and frames of an arm of Universal Robots are those of its own language, and no other arm takes it.
        Some(language) if (language == ProgramLanguage::UrScript) != arm.is_ur() => Err(WorkcellError::Language),
        _ => Ok(()),
    }
}
