//! The two cells that can print: what the stage asks of them beyond what the planners of trajectories ask.
//!
//! C. Dai 2020, section 2.5: a UR3 that holds the part under a standing nozzle; an IRB 1200 that holds the nozzle over
//! a table which carries the part, tilts and turns. Of the table the scene has the plate and a post down to the tilt
//! axis: the makers' frame around it depends on the cell.
//!
//! Neither work nor maker says what the arms stand on, so the stands are ours. The IRB 1200 has a pedestal. The UR3
//! hangs its elbow up to 0.14 m below its base and swings it from one side to the other, where a pedestal would be in the
//! way of half of all postures: it sits on a beam that reaches from a pillar behind it, and its elbow passes below.

use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::{OverTable, PartInHand, Placed, six_and_two};
use curvlay_kinematics::program::{ConfData, Target};
use curvlay_kinematics::scene::{Body, Mount, Posture, SceneModel, Shape, links};
use curvlay_kinematics::{Cell, robots};
use curvlay_trajectory::Bounds;
use curvlay_trajectory::print::PrintOptions;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// The third joint of an arm.
const ELBOW: usize = 2;

/// The post under the table: its radius, and how far below the table's top it ends, in millimetres. The tilt axis is
/// 105 mm below the top.
const POST_RADIUS: f64 = 60.0;
const POST_MM: f64 = 105.0;

/// How high the arms stand over the floor, in millimetres: from here on a UR3 does not touch the floor with its links, lower
/// it does.
const STAND_MM: f64 = 600.0;
/// The beam under a UR3, as wide as its foot: how thick it is, and how far behind the arm's axis it leaves the pillar. Of
/// steel it gives by a fiftieth of a millimetre under the arm; thicker than 45 mm the elbow does not pass under it.
const BEAM_MM: [f64; 2] = [40.0, 400.0];
/// The pillar, along the beam and across.
const PILLAR_MM: [f64; 2] = [100.0, 200.0];
/// The floor around it, to either side, and how thick it is.
const FLOOR_MM: [f64; 2] = [1500.0, 50.0];

/// What screws the nozzle to the flange: its radius, and from where to where it reaches above the tip.
const HOLDER_RADIUS: f64 = 25.0;
const HOLDER: [f64; 2] = [60.0, 150.0];

/// Where things are at a posture, in the base.
pub struct Stance {
    /// The frames of the arm, from the base to the flange.
    pub arm: [Isometry3<f64>; 7],
    /// What carries the part: the flange or the table.
    pub carrier: Isometry3<f64>,
    pub part: Isometry3<f64>,
    pub nozzle: Isometry3<f64>,
}

/// A move of a program for controllers that take poses: where the tool is on the part, and the table.
pub struct Placement {
    pub target: Target,
    pub table: Option<[f64; 2]>,
    pub joints: [f64; 6],
}

/// A cell that prints.
pub trait Printer<const N: usize, const F: usize>: Placed<N, F> + Clone + Send {
    /// What a report calls it.
    const NAME: &'static str;

    /// How its postures are searched.
    fn options() -> PrintOptions<N, F>;

    /// The cell without waypoints.
    fn empty() -> Result<Self, Failure>;

    /// Stops and the makers' speeds, with stops so close that postures within can be reached from one another.
    fn limits(&self) -> Bounds<N> {
        self.bounds(true)
    }

    /// Arm, links and whatever stands there besides nozzle, part and plate.
    fn scene(&self) -> SceneModel;

    /// What the nozzle is fixed to, and its frame there.
    fn nozzle_frame(&self) -> (Mount, Isometry3<f64>);

    /// What the part is fixed to, and its frame there.
    fn part_frame(&self) -> (Mount, Isometry3<f64>);

    /// Joints as the scene takes them.
    fn posture_of(joints: &[f64; N]) -> Posture;

    /// Where everything is; `None` with the table beyond its limits.
    fn stance(&self, joints: &[f64; N]) -> Option<Stance>;

    /// The same as a controller takes it.
    fn placement(&self, joints: &[f64; N]) -> Option<Placement>;
}

/// What stands in the base, besides the arm.
fn fixed(name: &str, shape: Shape) -> Body {
    Body { name: name.into(), mount: Mount::Base, mount_body: Isometry3::identity(), shape }
}

fn block(low: [f64; 3], high: [f64; 3]) -> Shape {
    Shape::block(low.into(), high.into())
}

fn floor() -> Body {
    let [wide, thick] = FLOOR_MM;
    fixed("floor", block([-wide, -wide, -STAND_MM - thick], [wide, wide, -STAND_MM]))
}

/// A pedestal as wide as the foot of an arm.
fn pedestal(links: &[Body]) -> Body {
    fixed("pedestal", Shape::cylinder(foot(links), -STAND_MM, 0.0))
}

/// A beam as wide as the foot of an arm, and the pillar from which it reaches.
fn beam(links: &[Body]) -> [Body; 2] {
    let (foot, [thick, behind], [along, across]) = (foot(links), BEAM_MM, PILLAR_MM);
    [
        fixed("beam", block([-behind, -foot, -thick], [foot, foot, 0.0])),
        fixed("pillar", block([-behind - along, -across / 2.0, -STAND_MM], [-behind, across / 2.0, 0.0])),
    ]
}

/// The radius of an arm's foot.
fn foot(links: &[Body]) -> f64 {
    links.first().map_or(0.0, |body| match &body.shape {
        Shape::Hull { points, .. } => points.iter().map(|point| point.x.hypot(point.y)).fold(0.0, f64::max),
        Shape::Capsule { radius, .. } => *radius,
        Shape::Mesh { .. } | Shape::Cells { .. } => 0.0,
    })
}

/// The frames of a cell.
fn stance_of(cell: &Cell, joints: &[f64; 6], part_in_hand: bool) -> Stance {
    let arm = cell.arm().frames(joints);
    let held = arm[6] * cell.held();
    if part_in_hand {
        return Stance { arm, carrier: arm[6], part: held, nozzle: cell.other() };
    }
    Stance { arm, carrier: cell.other(), part: cell.other(), nozzle: held }
}

/// The frame of a nozzle as a controller has it: z out of the tool, with the flow.
pub fn out_of(nozzle: &Isometry3<f64>) -> Isometry3<f64> {
    let flip = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    nozzle * Isometry3::from_parts(Translation3::identity(), flip)
}

fn placement_of(cell: &Cell, joints: &[f64; 6], table: Option<[f64; 2]>) -> Placement {
    let pose = out_of(&cell.nozzle_on_part(joints));
    Placement { target: Target { pose, conf: ConfData::of(cell.arm(), joints) }, table, joints: *joints }
}

impl Printer<6, 1> for PartInHand {
    const NAME: &'static str = "UR3 that holds the part under a standing nozzle";

    fn options() -> PrintOptions<6, 1> {
        PrintOptions::default()
    }

    fn empty() -> Result<Self, Failure> {
        PartInHand::new(Vec::new()).map_err(failure)
    }

    fn scene(&self) -> SceneModel {
        let links = links(&robots::UR3);
        let [beam, pillar] = beam(&links);
        SceneModel { bodies: vec![floor(), beam, pillar], links, ..SceneModel::of(*self.cell().arm()) }
    }

    fn nozzle_frame(&self) -> (Mount, Isometry3<f64>) {
        (Mount::Base, self.cell().other())
    }

    fn part_frame(&self) -> (Mount, Isometry3<f64>) {
        (Mount::Link(6), self.cell().held())
    }

    /// A UR turns its elbow two turns, says its manual; but beyond half a turn to either side the shoulder is in the way, says
    /// Universal_Robots_ROS2_Description (`config/ur3/joint_limits.yaml`): no way leads from there to here.
    fn limits(&self) -> Bounds<6> {
        let mut bounds = self.bounds(true);
        (bounds.lower[ELBOW], bounds.upper[ELBOW]) = (-PI, PI);
        bounds
    }

    fn posture_of(joints: &[f64; 6]) -> Posture {
        (*joints).into()
    }

    fn stance(&self, joints: &[f64; 6]) -> Option<Stance> {
        Some(stance_of(self.cell(), joints, true))
    }

    fn placement(&self, joints: &[f64; 6]) -> Option<Placement> {
        Some(placement_of(self.cell(), joints, None))
    }
}

impl Printer<8, 2> for OverTable {
    const NAME: &'static str = "IRB 1200 over a table that tilts and turns";

    fn options() -> PrintOptions<8, 2> {
        let (samples, dense_samples, near_samples) = ([5, 4], [25, 72], [7, 18]);
        PrintOptions { samples, dense_samples, near_samples, doublings: 1, ..PrintOptions::default() }
    }

    fn empty() -> Result<Self, Failure> {
        OverTable::new(Vec::new()).map_err(failure)
    }

    fn scene(&self) -> SceneModel {
        let cell = self.cell();
        let (link, flange_nozzle) = self.nozzle_frame();
        let body = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
        let post = Shape::cylinder(POST_RADIUS, -POST_MM, -super::workcell::PLATE_MM);
        let [low, high] = HOLDER;
        let links = links(&robots::IRB1200);
        let bodies = vec![
            floor(),
            pedestal(&links),
            body("post", Mount::Table, Isometry3::identity(), post),
            body("holder", link, flange_nozzle, Shape::cylinder(HOLDER_RADIUS, low, high)),
        ];
        let positioner = Some(*cell.positioner());
        SceneModel { links, bodies, positioner, ..SceneModel::of(*cell.arm()) }
    }

    fn nozzle_frame(&self) -> (Mount, Isometry3<f64>) {
        // What the arm holds is the same wherever the table is; at zero it is within its limits.
        let held = self.cell().at(&[0.0; 2]).map_or_else(Isometry3::identity, |cell| cell.held());
        (Mount::Link(6), held)
    }

    fn part_frame(&self) -> (Mount, Isometry3<f64>) {
        (Mount::Table, Isometry3::identity())
    }

    fn posture_of(joints: &[f64; 8]) -> Posture {
        let (joints, table) = six_and_two(joints);
        Posture { joints, table }
    }

    fn stance(&self, joints: &[f64; 8]) -> Option<Stance> {
        let (arm, table) = six_and_two(joints);
        Some(stance_of(&self.cell().at(&table)?, &arm, false))
    }

    fn placement(&self, joints: &[f64; 8]) -> Option<Placement> {
        let (arm, table) = six_and_two(joints);
        Some(placement_of(&self.cell().at(&table)?, &arm, Some(table)))
    }
}
