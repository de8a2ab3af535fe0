//! A workcell as data: an arm, what it holds, the nozzle, a table, a plate, and whatever else stands there.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.5: a UR3 that holds the part under a
//! fixed nozzle, and an arm with the nozzle over a table that tilts and turns. Here these are two files, and a workcell of your
//! own is a third one: see [`WorkcellModel`], and [below](#workcells) for the JSON file (cargo feature `serde`).
//!
//! [`AnyWorkcell::new`] checks the numbers of a model. What comes out answers all that planners of motions ask of a robot:
//! [`Workcell`]. There are three kinds, which differ in the number of their joints `N` and of the parameters `F` that a
//! waypoint leaves free:
//! * [`SixAxisWorkcell`]: `N = 6`, `F = 1`, the tool angle;
//! * [`SevenAxisWorkcell`]: `N = 7` (the track comes last, in units of [`Track`](crate::Track)), `F = 1`, the place of the track;
//! * [`EightAxisWorkcell`]: `N = 8` (the table's tilt and turn come last), `F = 2`, tilt and turn.
//!
//! [`GrowingScene`] is such a workcell with the layers that are built so far: what touches while printing, and while moving.
//!
//! Symbols: `theta` of section 4.3.1 is `free` here, `q` is `joints`. Branches are the slots of [`Branch`](crate::Branch).
//!
//! ```
//! use curvlay_kinematics::nalgebra::{Point3, Vector3};
//! use curvlay_kinematics::scene::{Mount, Scene};
//! use curvlay_kinematics::workcell::{
//!     AnyWorkcell, ArmGeometry, ArmPart, ControllerModel, FrameModel, Held, NozzleModel, PlateModel, VERSION, Workcell,
//!     WorkcellModel,
//! };
//! use curvlay_kinematics::Waypoint;
//! // A UR5 that holds the part under a nozzle that hangs down.
//! let model = WorkcellModel {
//!     version: VERSION,
//!     name: "UR5 under a nozzle".into(),
//!     arm: ArmPart::new(ArmGeometry::Named("UR5".into())),
//!     held: Held::Part,
//!     part: FrameModel { position_mm: [0.0, 0.0, 45.0], ..FrameModel::default() },
//!     nozzle: NozzleModel {
//!         tip_mm: [450.0, 100.0, 300.0],
//!         flow: [0.0, 0.0, -1.0],
//!         tip_flat_mm: 1.0,
//!         cone_half_angle_deg: 45.0,
//!         cone_height_mm: 8.0,
//!         block_diameter_mm: 20.0,
//!         block_top_mm: 60.0,
//!     },
//!     roller: None,
//!     plate: PlateModel { thickness_mm: 4.0, diameter_mm: None, size_mm: None },
//!     positioner: None,
//!     track: None,
//!     home_deg: None,
//!     controller: ControllerModel::default(),
//!     stand: None,
//!     solids: vec![],
//! };
//! let AnyWorkcell::Six(workcell) = AnyWorkcell::new(model)? else { return Err("it has a table".into()) };
//! assert_eq!(workcell.equipment().part_frame().0, Mount::Link(6));
//! let scene = Scene::new(workcell.equipment().scene(100.0))?;
//! let waypoint = Waypoint { position: Point3::new(0.0, 0.0, 30.0), axis: Vector3::z_axis() };
//! let mut free = 0;
//! workcell.solutions(&waypoint, &[0.5], &mut |_branch, joints| {
//!     free += usize::from(matches!(scene.touching(&workcell.scene_posture(&joints)), Ok(None)));
//! });
//! assert!(free > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
#![doc = include_str!("../../docs/workcells.md")]

mod around;
mod check;
mod controller;
mod eight;
mod equipment;
mod file;
mod growing;
mod lengths;
mod links;
mod model;
mod seven;
mod six;
mod solids;
mod tool;
#[cfg(feature = "urdf")]
mod urdf;

pub use check::WorkcellError;
pub use controller::{ControllerModel, FilamentGroupModel, ProgramLanguage};
pub use eight::EightAxisWorkcell;
pub use equipment::{Equipment, HOT_END, NOZZLE, PART, PLATE, PlateContact};
pub use file::WorkcellFileError;
pub use growing::{ClearanceLevel, GrowingError, GrowingOptions, GrowingScene, PartCells, nozzle_pairs};
pub use links::{LinkBodies, LinkMesh, LinkMeshReader};
pub use model::{
    ArmGeometry, ArmPart, BodiesModel, CalibrationModel, FrameModel, Held, LimitsModel, LinkMeshModel, MountModel,
    NozzleModel, PlateModel, PositionerGeometry, PositionerPart, RollerModel, ShapeModel, SolidModel, StandModel,
    TrackPart, UrdfModel, VERSION, WorkcellModel,
};
pub use seven::SevenAxisWorkcell;
pub use six::SixAxisWorkcell;
#[cfg(feature = "urdf")]
pub use urdf::TextReader;

use crate::limits::JointLimits;
use crate::scene;
use crate::setup::{Setup, Waypoint};
use crate::target::{ConfData, Target};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// The values that a free parameter may take, in radians; of a track in units of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeRange {
    /// An angle: values a whole turn apart are one.
    Turn,
    /// From the first to the second, both included.
    Within(f64, f64),
}

/// Joints at a waypoint, and `rates[f][j]`: the derivative of joint `j` by free parameter `f`.
pub type Following<const N: usize, const F: usize> = ([f64; N], [[f64; N]; F]);

/// What planners of motions ask of a robot that stands over or under a part: `N` joints, and `F` parameters that a waypoint
/// leaves free.
///
/// Nothing here allocates but what is said to; all answers depend on the arguments alone. A waypoint, a parameter or a joint
/// that is not finite has no solution.
pub trait Workcell<const N: usize, const F: usize>: Clone + Send + Sync {
    /// What stands in the workcell: the scene, the frames of part and nozzle.
    fn equipment(&self) -> &Equipment;

    /// Limits of all joints in this workcell; those of the table or the track come last.
    fn limits(&self) -> &JointLimits<N>;

    /// What the free parameters may be.
    fn free(&self) -> [FreeRange; F];

    /// Calls `each` with the branch and the joints of every solution at a waypoint, in ascending order of branches. Joints of
    /// the arm are in `(-pi, pi]`, those of the table in one turn around 0; of their limits, only those of the table are
    /// looked at.
    ///
    /// # Cost
    /// About a microsecond.
    fn solutions(&self, waypoint: &Waypoint, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N]));

    /// The solution on one branch with its derivatives; `None` out of reach and at a singularity.
    fn following(&self, waypoint: &Waypoint, free: &[f64; F], branch: u32) -> Option<Following<N, F>>;

    /// Where the nozzle is on the part, `part_nozzle`, whether the joints are within their limits or not; `None` only where a
    /// table is beyond its own.
    fn nozzle_on_part(&self, joints: &[f64; N]) -> Option<Isometry3<f64>>;

    /// The joints nearest to `previous` that reach a waypoint with the free parameters `free` and the tool turned by `turn`
    /// about the nozzle against what these say; within the limits, whole turns counted. A table stays where `previous` has it,
    /// not where `free` says, and so does a track: a nozzle that lifts off moves the arm only. As [`Arm::continuing`](crate::Arm::continuing).
    fn continuing(&self, waypoint: &Waypoint, free: &[f64; F], turn: f64, previous: &[f64; N]) -> Option<[f64; N]>;

    /// Where everything is at a posture, in the base; `None` where a table is beyond its limits.
    fn frames(&self, joints: &[f64; N]) -> Option<WorkcellFrames>;

    /// The posture as a controller takes it; `None` where a table is beyond its limits.
    fn controller_pose(&self, joints: &[f64; N]) -> Option<ControllerPose>;

    /// The posture as the scene takes it.
    fn scene_posture(&self, joints: &[f64; N]) -> scene::Posture;

    /// How far from a singularity the arm is, in mm^3, as [`Arm::manipulability`](crate::Arm::manipulability).
    fn manipulability(&self, joints: &[f64; N]) -> f64;
}

/// The frames of what moves at a posture, in the base: for pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkcellFrames {
    /// The frames of the arm, from the base to the flange.
    pub arm: [Isometry3<f64>; 7],
    /// What carries the part: flange, table, or the base at the part frame.
    pub carrier: Isometry3<f64>,
    /// The part.
    pub part: Isometry3<f64>,
    /// The nozzle.
    pub nozzle: Isometry3<f64>,
}

/// A posture for controllers that take poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerPose {
    /// Where the tool is on the part, with z out of the tool as controllers have it, and the configuration data.
    pub target: Target,
    /// Tilt and turn of the table, where there is one.
    pub table: Option<[f64; 2]>,
    /// The position of the track in millimetres, where there is one.
    pub track_mm: Option<f64>,
    /// The arm's joints.
    pub joints: [f64; 6],
}

/// The frame of a nozzle as controllers have it: z out of the tool, with the flow.
pub fn tool_frame(nozzle: &Isometry3<f64>) -> Isometry3<f64> {
    let flip = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    nozzle * Isometry3::from_parts(Translation3::identity(), flip)
}

fn controller_pose(setup: &Setup, joints: &[f64; 6], table: Option<[f64; 2]>) -> ControllerPose {
    let pose = tool_frame(&setup.nozzle_on_part(joints));
    ControllerPose {
        target: Target { pose, conf: ConfData::of(setup.arm(), joints) },
        table,
        track_mm: None,
        joints: *joints,
    }
}

fn frames_of(setup: &Setup, joints: &[f64; 6], held: Held) -> WorkcellFrames {
    let arm = setup.arm().frames(joints);
    let ((_, part), (_, nozzle)) = (setup.part_frame(), setup.nozzle_frame());
    match held {
        Held::Part => WorkcellFrames { arm, carrier: arm[6], part: arm[6] * part, nozzle },
        Held::Nozzle => WorkcellFrames { arm, carrier: part, part, nozzle: arm[6] * nozzle },
    }
}

/// A workcell of any kind.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of these in a program")]
pub enum AnyWorkcell {
    /// An arm alone.
    Six(SixAxisWorkcell),
    /// An arm on a track.
    Seven(SevenAxisWorkcell),
    /// An arm and a table.
    Eight(EightAxisWorkcell),
}

impl AnyWorkcell {
    /// Checks the numbers of a workcell.
    ///
    /// # Errors
    /// [`WorkcellError`] names the field, as in the file.
    pub fn new(model: WorkcellModel) -> Result<Self, WorkcellError> {
        let no_reader = |_: &str| Err("link meshes are not read here: use AnyWorkcell::with_link_meshes".to_owned());
        Self::with_link_meshes(model, &mut { no_reader })
    }

    /// Checks the numbers of a workcell whose links may be meshes.
    ///
    /// # Arguments
    /// * `read`: gives the points, in the unit of the file, and the triangles of a mesh by its name in the model, or says why it
    ///   cannot.
    ///
    /// # Errors
    /// [`WorkcellError`] names the field, as in the file.
    ///
    /// # Cost
    /// `O(n log n)` for `n` triangles of link meshes.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::nalgebra::Point3;
    /// use curvlay_kinematics::workcell::{AnyWorkcell, BodiesModel, FrameModel, LinkMeshModel, WorkcellModel};
    /// # #[cfg(feature = "serde")] {
    /// let mut model = WorkcellModel::from_json(include_str!("../../../examples/cells/ur3.json").as_bytes())?;
    /// let mesh = |link| LinkMeshModel { link, file: "link.stl".into(), unit_mm: 1000.0, frame: FrameModel::default() };
    /// model.arm.bodies = Some(BodiesModel::Meshes((0..=6).map(mesh).collect()));
    /// // A tetrahedron of 2 cm, in metres.
    /// let points = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.02]].map(Point3::from).to_vec();
    /// let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    /// let workcell = AnyWorkcell::with_link_meshes(model, &mut |_| Ok((points.clone(), triangles.clone())))?;
    /// assert_eq!(workcell.equipment().scene(100.0).links.len(), 7);
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_link_meshes(model: WorkcellModel, read: LinkMeshReader<'_>) -> Result<Self, WorkcellError> {
        let (equipment, table) = Equipment::new(model, read)?;
        let track = equipment.track().copied();
        Ok(match (table, track) {
            (Some(table), _) => AnyWorkcell::Eight(EightAxisWorkcell::new(equipment, &table)?),
            (None, Some(track)) => {
                let angle = equipment.model().track.as_ref().map_or(0.0, |part| part.tool_angle_deg.to_radians());
                AnyWorkcell::Seven(SevenAxisWorkcell::new(equipment, track, angle)?)
            }
            (None, None) => AnyWorkcell::Six(SixAxisWorkcell::new(equipment)?),
        })
    }

    /// Reads a workcell from a JSON file, as the [module](crate::workcell) describes it, and checks it.
    ///
    /// # Errors
    /// [`WorkcellFileError`] names line and column, or the field.
    #[cfg(feature = "serde")]
    pub fn from_json(input: impl std::io::Read) -> Result<Self, WorkcellFileError> {
        Ok(Self::new(WorkcellModel::from_json(input)?)?)
    }

    /// What stands in the workcell.
    pub fn equipment(&self) -> &Equipment {
        match self {
            AnyWorkcell::Six(workcell) => workcell.equipment(),
            AnyWorkcell::Seven(workcell) => workcell.equipment(),
            AnyWorkcell::Eight(workcell) => workcell.equipment(),
        }
    }
}
