//! The numbers of a workcell, as they stand in its file.
//!
//! Each field has the name that it has in the file, with its unit: lengths in millimetres, angles and speeds of joints in
//! degrees (as makers print them), accelerations and jerks of joints in rad/s^2 and rad/s^3 (as planners do). Nothing is
//! checked here; [`AnyWorkcell::new`](super::AnyWorkcell::new) does.

use super::controller::ControllerModel;

/// The version of the format that this crate reads and writes.
pub const VERSION: u32 = 1;

/// A workcell: an arm, what it holds, the nozzle, a table, a plate, and whatever else stands there.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct WorkcellModel {
    /// Version of the format: [`VERSION`].
    pub version: u32,
    /// What a report calls the workcell.
    pub name: String,
    /// The arm, which stands in the origin.
    pub arm: ArmPart,
    /// What the arm holds.
    pub held: Held,
    /// The part: its frame on the flange (if the arm holds it), on the table (if there is one), or else in the base. The
    /// plate on which the part grows lies at z = 0 of this frame, and z points away from the plate.
    #[cfg_attr(feature = "serde", serde(default))]
    pub part: FrameModel,
    /// The nozzle: on the flange, or in the base if the arm holds the part.
    pub nozzle: NozzleModel,
    /// The roller of a tape head that takes the place of the nozzle; absent: none is known.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub roller: Option<RollerModel>,
    /// The plate on which the part grows.
    pub plate: PlateModel,
    /// The table that carries the part, where there is one.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub positioner: Option<PositionerPart>,
    /// The track that carries the arm along, where there is one.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub track: Option<TrackPart>,
    /// The posture at which every program begins and ends: the joints of the arm, then tilt and turn of the table, within the
    /// limits and free with the whole part on the plate; a track is at [`TrackPart::home_mm`] then. Absent: one is computed above the part.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub home_deg: Option<Vec<f64>>,
    /// How programs drive the extruder and the arm.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "ControllerModel::is_default"))]
    pub controller: ControllerModel,
    /// What the arm stands on.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub stand: Option<StandModel>,
    /// Floor, walls, posts, holders.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub solids: Vec<SolidModel>,
}

/// What an arm holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Held {
    /// The part, under a nozzle that stands still.
    Part,
    /// The nozzle, over a part that stands still or on a table.
    Nozzle,
}

/// An arm and its limits.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct ArmPart {
    /// Its lengths.
    pub geometry: ArmGeometry,
    /// How the arm that stands there differs from these, by its calibration; absent: not at all.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub calibration: Option<CalibrationModel>,
    /// What its joints may do in this workcell.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: LimitsModel<6>,
    /// How far the mounting face is below the base frame; absent: what is known of a named arm, else 0. Stand and estimated bodies begin
    /// there.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub mount_below_base_mm: Option<f64>,
    /// The bodies of its links; absent: those that are known of an arm of these lengths, see
    /// [`scene::links`](crate::scene::links), or else, of a named arm, [estimated](BodiesModel::Estimated) ones.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub bodies: Option<BodiesModel>,
    /// How much thicker the links are than their bodies, for cables, hoses and clips; see
    /// [`SceneModel::link_allowance`](crate::scene::SceneModel::link_allowance).
    #[cfg_attr(feature = "serde", serde(default = "ArmPart::allowance"))]
    pub allowance_mm: f64,
}

impl ArmPart {
    /// The default of [`allowance_mm`](ArmPart::allowance_mm): a cable of 10 mm along the arm.
    pub const ALLOWANCE_MM: f64 = 10.0;

    #[cfg(feature = "serde")]
    fn allowance() -> f64 {
        Self::ALLOWANCE_MM
    }

    /// An arm with what is known of it.
    ///
    /// ```
    /// use curvlay_kinematics::workcell::{ArmGeometry, ArmPart};
    /// let arm = ArmPart::new(ArmGeometry::Named("UR3".into()));
    /// assert_eq!((arm.bodies, arm.allowance_mm), (None, 10.0));
    /// ```
    pub fn new(geometry: ArmGeometry) -> Self {
        ArmPart {
            geometry,
            calibration: None,
            limits: LimitsModel::default(),
            mount_below_base_mm: None,
            bodies: None,
            allowance_mm: Self::ALLOWANCE_MM,
        }
    }
}

/// How an arm as built differs from its numbers: [`ArmDeviation`](crate::ArmDeviation).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct CalibrationModel {
    /// By how much the joints are more than the arm says: see [`ArmDeviation::offsets`](crate::ArmDeviation::offsets).
    #[cfg_attr(feature = "serde", serde(default))]
    pub offsets_deg: [f64; 6],
    /// Where axes 2 to 6 are, seen from where they should be: see [`ArmDeviation::axes`](crate::ArmDeviation::axes).
    #[cfg_attr(feature = "serde", serde(default))]
    pub axes: [FrameModel; 5],
}

impl From<&crate::arm::ArmDeviation> for CalibrationModel {
    fn from(deviation: &crate::arm::ArmDeviation) -> Self {
        CalibrationModel {
            offsets_deg: deviation.offsets.map(f64::to_degrees),
            axes: deviation.axes.map(|axis| FrameModel::from(&axis)),
        }
    }
}

/// Bodies of links.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum BodiesModel {
    /// Tubes from the lengths of the arm ([`scene::estimated_links`](crate::scene::estimated_links)): thinner than any real link, so motions that
    /// are free with them may touch. They keep an elbow out of a table.
    Estimated,
    /// Those of one of [`robots::CATALOGUE`](crate::robots::CATALOGUE), by its name: for an arm whose lengths were calibrated. No
    /// length may differ by more than 5 mm.
    Named(String),
    /// Meshes, one or more for each link.
    Meshes(Vec<LinkMeshModel>),
}

/// A mesh of a link. Each of its connected pieces becomes its convex hull.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct LinkMeshModel {
    /// The link: 0 the base, 1 to 6 the link behind that joint.
    pub link: usize,
    /// Name of an STL file, from the folder of the workcell file on.
    pub file: String,
    /// Millimetres in a unit of the file; 1000 for one in metres.
    #[cfg_attr(feature = "serde", serde(default = "LinkMeshModel::unit"))]
    pub unit_mm: f64,
    /// The frame of the mesh in the frame of the link, see [`Arm::frames`](crate::Arm::frames).
    #[cfg_attr(feature = "serde", serde(default))]
    pub frame: FrameModel,
}

#[cfg(feature = "serde")]
impl LinkMeshModel {
    fn unit() -> f64 {
        1.0
    }
}

/// The lengths of an arm.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum ArmGeometry {
    /// One of [`robots::CATALOGUE`](crate::robots::CATALOGUE), by one of its names.
    Named(String),
    /// What a URDF says: see `WorkcellModel::with_urdf` (cargo feature `urdf`).
    Urdf(UrdfModel),
    /// An arm of the UR type: see [`DhTable::ur`](crate::DhTable::ur).
    Ur {
        /// Offsets along the joint axes.
        d_mm: [f64; 6],
        /// Length of the upper arm, `a2` of the table; UR prints it negative.
        upper_arm_mm: f64,
        /// Length of the forearm, `a3` of the table; UR prints it negative.
        forearm_mm: f64,
        /// See [`ArmModel`](crate::ArmModel); those of the table if left out.
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "is_zero"))]
        offsets_deg: [f64; 6],
        /// 1, or -1 where a joint turns the other way.
        #[cfg_attr(feature = "serde", serde(default = "right_handed", skip_serializing_if = "is_right_handed"))]
        signs: [f64; 6],
        /// Coupling of joints 2 and 3, see [`ArmModel::j23_factor`](crate::ArmModel::j23_factor).
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "is_uncoupled"))]
        j23_factor: f64,
    },
    /// An ortho-parallel arm with a spherical wrist: see [`OrthoLengths`](crate::OrthoLengths).
    OrthoParallel {
        /// Axis 2 in front of axis 1.
        a1_mm: f64,
        /// Wrist centre in front of axis 3; negative on most arms.
        a2_mm: f64,
        /// Wrist centre beside axis 1.
        b_mm: f64,
        /// Axis 2 above the floor.
        c1_mm: f64,
        /// Axis 3 above axis 2.
        c2_mm: f64,
        /// Wrist centre above axis 3.
        c3_mm: f64,
        /// Flange above the wrist centre.
        c4_mm: f64,
        /// See [`ArmModel`](crate::ArmModel).
        offsets_deg: [f64; 6],
        /// 1, or -1 where a joint turns the other way.
        signs: [f64; 6],
        /// Coupling of joints 2 and 3, see [`ArmModel::j23_factor`](crate::ArmModel::j23_factor).
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "is_uncoupled"))]
        j23_factor: f64,
    },
}

#[cfg(feature = "serde")]
fn is_zero(values: &[f64; 6]) -> bool {
    values.iter().all(|value| value.abs() <= 0.0)
}

#[cfg(feature = "serde")]
fn right_handed() -> [f64; 6] {
    [1.0; 6]
}

#[cfg(feature = "serde")]
fn is_right_handed(signs: &[f64; 6]) -> bool {
    signs.iter().all(|sign| (sign - 1.0).abs() <= 0.0)
}

#[cfg(feature = "serde")]
fn is_uncoupled(factor: &f64) -> bool {
    factor.abs() <= 0.0
}

/// A URDF, and between which of its links the arm is.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum UrdfModel {
    /// The file, its path from the folder of the workcell file on. The base is the link `base` where it is fixed to the root, else the
    /// root; the flange is `tool0`, else `flange`, else the last link of the chain of six joints.
    File(String),
    /// The same with the links named.
    Links {
        /// The file.
        file: String,
        /// The link that is the base.
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
        base: Option<String>,
        /// The link that is the flange.
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
        flange: Option<String>,
    },
}

impl UrdfModel {
    /// The file.
    pub fn file(&self) -> &str {
        let (UrdfModel::File(file) | UrdfModel::Links { file, .. }) = self;
        file
    }
}

/// Limits of `N` joints. An absent or `null` list leaves what is known of a named robot, or no limit; a `null` in a list is
/// no limit for that joint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        deny_unknown_fields,
        bound(
            serialize = "[Option<f64>; N]: serde::Serialize",
            deserialize = "[Option<f64>; N]: serde::Deserialize<'de>"
        )
    )
)]
pub struct LimitsModel<const N: usize> {
    /// Smallest angles.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub min_deg: Option<[Option<f64>; N]>,
    /// Greatest angles.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_deg: Option<[Option<f64>; N]>,
    /// Greatest speeds.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_speed_deg_s: Option<[Option<f64>; N]>,
    /// Greatest accelerations.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_acceleration_rad_s2: Option<[Option<f64>; N]>,
    /// Greatest jerks.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_jerk_rad_s3: Option<[Option<f64>; N]>,
}

impl<const N: usize> Default for LimitsModel<N> {
    /// What is known of the robot.
    fn default() -> Self {
        LimitsModel {
            min_deg: None,
            max_deg: None,
            max_speed_deg_s: None,
            max_acceleration_rad_s2: None,
            max_jerk_rad_s3: None,
        }
    }
}

/// A pose on what carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct FrameModel {
    /// Its origin.
    #[cfg_attr(feature = "serde", serde(default))]
    pub position_mm: [f64; 3],
    /// Roll, pitch and yaw: turns about the fixed x, then y, then z axis of what carries it, as in URDF.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rpy_deg: [f64; 3],
}

impl From<&nalgebra::Isometry3<f64>> for FrameModel {
    fn from(frame: &nalgebra::Isometry3<f64>) -> Self {
        let (roll, pitch, yaw) = frame.rotation.euler_angles();
        FrameModel { position_mm: frame.translation.vector.into(), rpy_deg: [roll, pitch, yaw].map(f64::to_degrees) }
    }
}

/// A round nozzle: where it is, and its shape: a flat tip, a cone, a cylindrical block on top of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct NozzleModel {
    /// The tip, on the flange, or in the base if the arm holds the part.
    pub tip_mm: [f64; 3],
    /// The direction in which the material leaves the nozzle, there, of any length.
    pub flow: [f64; 3],
    /// Diameter of the flat tip.
    pub tip_flat_mm: f64,
    /// The angle between the axis and the side of the cone.
    pub cone_half_angle_deg: f64,
    /// Height of the cone.
    pub cone_height_mm: f64,
    /// Diameter of the block (the hot end), which begins where the cone ends.
    pub block_diameter_mm: f64,
    /// Where the block ends, above the tip.
    pub block_top_mm: f64,
}

/// A tape head in the place of the nozzle: a roller that lies across the tape and touches it where the tip of the nozzle would be, and the block that
/// carries it, which begins above the roller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct RollerModel {
    /// Diameter of the roller.
    pub diameter_mm: f64,
    /// Its width, across the tape.
    pub width_mm: f64,
    /// Diameter of the block.
    pub block_diameter_mm: f64,
    /// Where the block ends, above the line of contact.
    pub block_top_mm: f64,
    /// How the head is mounted: from the x axis of the nozzle frame to the direction of the tape, about the axis of the nozzle. Absent: where the most
    /// tapes are in reach.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub mount_deg: Option<f64>,
}

impl Default for RollerModel {
    /// A roller of 20 mm under a block of 25 mm, 8 mm wide: for tapes of 5 mm (C. Dai 2020, section 5.3.2) with some room at both sides. The sizes are ours,
    /// since the dissertation gives none.
    fn default() -> Self {
        RollerModel { diameter_mm: 20.0, width_mm: 8.0, block_diameter_mm: 25.0, block_top_mm: 61.0, mount_deg: None }
    }
}

/// The plate on which the part grows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct PlateModel {
    /// Its thickness, from z = 0 of the part frame downwards.
    pub thickness_mm: f64,
    /// Its diameter; `null` or absent: as wide as the print wants it.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub diameter_mm: Option<f64>,
    /// Its edges along x and y of the part frame, for a plate that is no disc; absent: it is one.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub size_mm: Option<[f64; 2]>,
}

/// A table that tilts and turns, and carries the part.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct PositionerPart {
    /// Its axes.
    pub geometry: PositionerGeometry,
    /// Where it stands in the base of the arm.
    pub frame: FrameModel,
    /// What its joints may do in this workcell.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: LimitsModel<2>,
    /// The tilts at which waypoints are printed, from the first to the second; within the limits.
    pub print_tilt_deg: [f64; 2],
    /// The angle about the nozzle, if the nozzle does not lie on axis 6: see
    /// [`EightAxisWorkcell`](super::EightAxisWorkcell).
    #[cfg_attr(feature = "serde", serde(default))]
    pub tool_angle_deg: f64,
}

/// The axes of a table, see [`PositionerModel`](crate::PositionerModel).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum PositionerGeometry {
    /// One of [`robots::POSITIONERS`](crate::robots::POSITIONERS), by its name there.
    Named(String),
    /// By the numbers.
    Axes {
        /// A point on the tilt axis.
        tilt_origin_mm: [f64; 3],
        /// Direction of the tilt axis, of any length.
        tilt_axis: [f64; 3],
        /// A point on the turn axis.
        turn_origin_mm: [f64; 3],
        /// Direction of the turn axis, of any length.
        turn_axis: [f64; 3],
        /// Origin of the table frame.
        table_origin_mm: [f64; 3],
    },
}

/// A linear track: the arm with all that stands on its base travels along a line, and the part stands still. See [`TrackModel`](crate::TrackModel).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct TrackPart {
    /// The way of the base as the position grows, of any length.
    pub direction: [f64; 3],
    /// The least and the greatest position, as the controller counts.
    pub range_mm: [f64; 2],
    /// The position at which the base of the arm is the base of the workcell, in which part and solids are given.
    #[cfg_attr(feature = "serde", serde(default))]
    pub zero_mm: f64,
    /// Greatest speed.
    pub max_speed_mm_s: f64,
    /// Greatest acceleration; absent: no limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_acceleration_mm_s2: Option<f64>,
    /// Greatest jerk; absent: no limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_jerk_mm_s3: Option<f64>,
    /// Where the track is at home, with the arm at [`WorkcellModel::home_deg`]; absent: in the middle of its range.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub home_mm: Option<f64>,
    /// The angle about the nozzle, if the nozzle does not lie on axis 6: see [`SevenAxisWorkcell`](super::SevenAxisWorkcell).
    #[cfg_attr(feature = "serde", serde(default))]
    pub tool_angle_deg: f64,
}

/// What an arm stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum StandModel {
    /// A round pedestal under the foot.
    Pedestal {
        /// Its height.
        height_mm: f64,
        /// Its radius; absent: that of the arm's foot.
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
        radius_mm: Option<f64>,
    },
    /// A beam under the foot, which reaches forward (along x) from a pillar behind the arm.
    Beam {
        /// Height of the pillar.
        height_mm: f64,
        /// Thickness of the beam.
        thickness_mm: f64,
        /// From the arm's axis back to the pillar.
        length_mm: f64,
        /// Half the width of the beam, and how far it reaches in front of the arm's axis; absent: the radius of the arm's
        /// foot.
        #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
        half_width_mm: Option<f64>,
        /// The pillar, along the beam and across.
        pillar_mm: [f64; 2],
    },
}

/// A solid body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct SolidModel {
    /// Its name, by which answers call it.
    pub name: String,
    /// What it is fixed to.
    pub mount: MountModel,
    /// Its frame on that.
    #[cfg_attr(feature = "serde", serde(default))]
    pub frame: FrameModel,
    /// What it is.
    pub shape: ShapeModel,
}

/// What a solid is fixed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum MountModel {
    /// The base of the arm, which is the world. On a track that is where the base is at [`TrackPart::zero_mm`]: it stands still.
    Base,
    /// The carriage of a track, which travels with the arm.
    Carriage,
    /// The ground as [`MountModel::Base`], of something that the carriage of a track runs on or next to, such as its rail or the floor: it is not compared with carriage and stand.
    Rail,
    /// The link behind joint 1 to 6.
    Link(usize),
    /// The flange.
    Flange,
    /// What the tilt axis of the positioner moves and the turn axis does not.
    Tilt,
    /// The table.
    Table,
    /// The part frame, wherever that is.
    Part,
    /// The nozzle frame, wherever that is: origin at the tip, z up into the nozzle.
    Nozzle,
}

/// The shape of a solid, in its frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum ShapeModel {
    /// A box along the axes.
    Block {
        /// The corner with the smallest coordinates.
        min_mm: [f64; 3],
        /// The corner with the greatest coordinates.
        max_mm: [f64; 3],
    },
    /// A cylinder about z, as a prism of twelve sides that contains it.
    Cylinder {
        /// Its radius.
        radius_mm: f64,
        /// Its lower end.
        min_z_mm: f64,
        /// Its upper end.
        max_z_mm: f64,
    },
    /// All points within a radius of a line.
    Capsule {
        /// One end of the line.
        from_mm: [f64; 3],
        /// The other.
        to_mm: [f64; 3],
        /// The radius.
        radius_mm: f64,
    },
    /// The convex hull of points.
    Hull {
        /// One or more.
        points_mm: Vec<[f64; 3]>,
    },
}
