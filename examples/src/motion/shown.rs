//! Workcells, tool paths and motions as the [viewer](crate::viewer) takes them.

use crate::viewer::{Model, Nozzle, Robot, Stance, Step};
use curvlay_kinematics::workcell::{Held, NozzleModel, Workcell};
use curvlay_toolpath::surface::{BeadKind, Move, MoveKind, ToolPath};
use curvlay_trajectory::Trajectory;
use nalgebra::{Isometry3, Point3, Vector3};

/// Most moments at which a robot is shown; between them it goes evenly.
const STANCES: usize = 8_000;

/// Width and height of the line that stands for a path without beads, in millimetres.
const LINE_MM: f64 = 0.8;

/// Kinds of beads, and their names in the viewer.
const KINDS: [(BeadKind, &str); 7] = [
    (BeadKind::Wall, "wall"),
    (BeadKind::Solid, "solid"),
    (BeadKind::Support, "support"),
    (BeadKind::Skin, "skin"),
    (BeadKind::Bridge, "bridge"),
    (BeadKind::Infill, "infill"),
    (BeadKind::SparseSupport, "sparse support"),
];

/// The names of the kinds of beads.
pub fn kinds() -> Vec<String> {
    KINDS.map(|(_, name)| name.to_owned()).to_vec()
}

/// The kind of a bead.
pub fn kind(bead: BeadKind) -> u8 {
    KINDS.iter().position(|(kind, _)| *kind == bead).map_or(Step::TRAVEL, |at| at as u8)
}

/// What a machine file says.
pub fn steps(paths: &[ToolPath], moves: &[Move]) -> Vec<Step> {
    let step = |step: &Move| {
        let path = paths.get(step.path)?;
        let waypoint = path.waypoints.get(step.waypoint)?;
        let kind = if step.kind == MoveKind::Print { kind(step.bead.unwrap_or_default()) } else { Step::TRAVEL };
        let (tip, direction, seconds) = (step.tip, *step.direction, step.seconds);
        let (width, height, layer) = (waypoint.width, waypoint.height, path.layer);
        Some(Step { tip, direction, width, height, kind, layer, path: step.path as u32, seconds })
    };
    moves.iter().filter_map(step).collect()
}

/// Takes every so-manieth of `knots` postures, so that there are not more than a viewer needs.
pub fn stride(knots: usize) -> usize {
    knots.div_ceil(STANCES).max(1)
}

/// How a workcell stands; `frame_part` maps the part to the frame of what carries it. None where a table is beyond its limits.
pub fn stance<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    joints: &[f64; N],
    frame_part: &Isometry3<f64>,
    seconds: f64,
) -> Option<Stance> {
    let stance = cell.stance(joints)?;
    let model = cell.equipment().model();
    let held = match model.held {
        Held::Nozzle => stance.nozzle * Point3::new(0.0, 0.0, model.nozzle.block_top_mm),
        Held::Part => stance.part * Point3::origin(),
    };
    let joined = stance.arm.iter().map(|frame| Point3::from(frame.translation.vector)).chain([held]);
    let joined: Vec<Point3<f64>> = joined.collect();
    let bones = joined.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    Some(Stance { seconds, joints: joints.to_vec(), bones, part: stance.part * frame_part })
}

/// The robot of a workcell.
pub fn robot<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W, stances: Vec<Stance>) -> Robot {
    let (name, speeds) = (cell.equipment().name().to_owned(), cell.limits().velocity.to_vec());
    Robot { name, speeds, stances, is_shown: false }
}

/// The nozzle of a workcell.
pub fn nozzle(model: &NozzleModel) -> Nozzle {
    let &NozzleModel { tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm, .. } = model;
    Nozzle { tip: tip_flat_mm, half_angle_deg: cone_half_angle_deg, cone: cone_height_mm, block: block_diameter_mm }
}

/// Motions one after the other, from knot to knot: where the nozzle goes on the part, and how the robot stands. The knots are those of
/// what is executed, not waypoints.
pub fn followed<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W, motions: &[Trajectory<N>]) -> Model {
    let stride = stride(motions.iter().map(|motion| motion.times().len()).sum());
    let (mut steps, mut stances, mut start, mut number) = (Vec::new(), Vec::new(), 0.0, 0);
    for (path, motion) in (0..).zip(motions) {
        let (first, last) = motion.span();
        let mut before = first;
        for (knot, (&time, joints)) in motion.times().iter().zip(motion.joints()).enumerate() {
            if let Some(pose) = cell.nozzle_on_part(joints) {
                let kind = if knot == 0 { Step::TRAVEL } else { 0 };
                let (tip, direction, seconds) = (pose * Point3::origin(), pose * Vector3::z(), time - before);
                steps.push(Step { tip, direction, width: LINE_MM, height: LINE_MM, kind, layer: 0, path, seconds });
                before = time;
            }
            if number % stride == 0 {
                stances.extend(stance(cell, joints, &Isometry3::identity(), start + time - first));
            }
            number += 1;
        }
        start += last - first;
    }
    let mut robot = robot(cell, stances);
    robot.is_shown = true;
    Model {
        name: cell.equipment().name().to_owned(),
        kinds: vec!["path".to_owned()],
        steps,
        nozzle: Some(nozzle(&cell.equipment().model().nozzle)),
        robot: Some(robot),
        ..Model::default()
    }
}
