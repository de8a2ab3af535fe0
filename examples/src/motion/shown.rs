//! Workcells, tool paths and motions as the [viewer](crate::viewer) takes them.

use crate::viewer::{Model, Nozzle, Robot, Stance, Step};
use curvlay_kinematics::workcell::{Held, NozzleModel, Workcell};
use curvlay_toolpath::deposit::{Move, MoveKind};
use curvlay_toolpath::orientation::ToolPath;
use curvlay_toolpath::path::BeadKind;
use curvlay_trajectory::Trajectory;
use curvlay_trajectory::print::{PrintPlan, SegmentKind};
use nalgebra::{Isometry3, Point3, Vector3};
use std::ops::Range;

/// Most moments at which a robot is shown; between them it goes evenly.
const STANCES: usize = 8_000;

/// Width and height of the line that stands for a path without beads, in millimetres.
const LINE_MM: f64 = 0.8;

/// Kinds of beads, and their names in the viewer.
const KINDS: [(BeadKind, &str); 8] = [
    (BeadKind::Wall, "wall"),
    (BeadKind::Solid, "solid"),
    (BeadKind::Support, "support"),
    (BeadKind::Skin, "skin"),
    (BeadKind::Bridge, "bridge"),
    (BeadKind::Infill, "infill"),
    (BeadKind::SparseSupport, "sparse support"),
    (BeadKind::SupportBridge, "support bridge"),
];

/// How many kinds of beads there are: the first number that is free for other kinds.
pub const BEAD_KINDS: u8 = KINDS.len() as u8;

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

/// Takes every n-th of the `knots` postures, so that there are not more than a viewer needs.
pub fn stride(knots: usize) -> usize {
    knots.div_ceil(STANCES).max(1)
}

/// How a workcell stands; `frame_part` maps the part to the frame of what carries it. None where a table is beyond its limits.
fn stance<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    joints: &[f64; N],
    frame_part: &Isometry3<f64>,
    seconds: f64,
) -> Option<Stance> {
    let stance = cell.frames(joints)?;
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

/// The nozzle of a workcell.
pub fn nozzle(model: &NozzleModel) -> Nozzle {
    let &NozzleModel { tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm, .. } = model;
    Nozzle { tip: tip_flat_mm, half_angle_deg: cone_half_angle_deg, cone: cone_height_mm, block: block_diameter_mm }
}

/// Motions that are executed one after the other, from knot to knot: where the nozzle goes on the part, and how the robot stands.
pub struct Played<'a, W> {
    cell: &'a W,
    frame_part: Isometry3<f64>,
    /// Every n-th knot has a stance.
    stride: usize,
    knots: usize,
    seconds: f64,
    steps: Vec<Step>,
    stances: Vec<Stance>,
}

impl<'a, W> Played<'a, W> {
    /// Nothing yet, of so many knots in all; `frame_part` maps the part to the frame of what carries it.
    pub fn new(cell: &'a W, frame_part: Isometry3<f64>, knots: usize) -> Self {
        let (steps, stances) = (Vec::with_capacity(knots), Vec::new());
        Played { cell, frame_part, stride: stride(knots), knots: 0, seconds: 0.0, steps, stances }
    }

    /// Adds a motion along a path of a layer. Its knots are times since it began and joints; `bead` is asked for each of them in turn for the kind
    /// of bead that ends there, its width and height. At the first knot it begins, so nothing is laid there.
    pub fn add<const N: usize, const F: usize>(
        &mut self,
        (layer, path): (u32, u32),
        knots: &[(f64, [f64; N])],
        mut bead: impl FnMut(usize) -> Option<(u8, [f64; 2])>,
    ) where
        W: Workcell<N, F>,
    {
        let frame = self.frame_part.inverse();
        let mut before = 0.0;
        for (knot, (time, joints)) in knots.iter().enumerate() {
            let (kind, [width, height]) = bead(knot).unwrap_or((Step::TRAVEL, [0.0; 2]));
            if let Some(pose) = self.cell.nozzle_on_part(joints) {
                let pose = frame * pose;
                let (tip, direction) = (pose * Point3::origin(), pose * Vector3::z());
                let kind = if knot == 0 { Step::TRAVEL } else { kind };
                self.steps.push(Step { tip, direction, width, height, kind, layer, path, seconds: time - before });
                before = *time;
            }
            if self.knots.is_multiple_of(self.stride) {
                self.stances.extend(stance(self.cell, joints, &self.frame_part, self.seconds + time));
            }
            self.knots += 1;
        }
        self.seconds += knots.last().map_or(0.0, |(time, _)| *time);
    }

    /// The steps, and the robot.
    pub fn finish<const N: usize, const F: usize>(self) -> (Vec<Step>, Robot)
    where
        W: Workcell<N, F>,
    {
        let (name, speeds) = (self.cell.equipment().name().to_owned(), self.cell.limits().velocity.to_vec());
        (self.steps, Robot { name, speeds, stances: self.stances, is_shown: false })
    }
}

/// What a robot does that executes a plan, from knot to knot, and how it stands; `frame_part` maps the part to the frame of what carries it.
pub fn played<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    frame_part: &Isometry3<f64>,
    plan: &PrintPlan<N, F>,
    paths: &[ToolPath],
) -> (Vec<Step>, Robot) {
    let knots = plan.segments(0..plan.runs.len()).map(|leg| leg.knots().len()).sum();
    let mut played = Played::new(cell, *frame_part, knots);
    play(&mut played, plan, 0..plan.runs.len(), paths);
    played.finish()
}

/// Adds some runs of a plan, and the ways to, between and from them.
pub fn play<const N: usize, const F: usize, W: Workcell<N, F>>(
    played: &mut Played<'_, W>,
    plan: &PrintPlan<N, F>,
    runs: Range<usize>,
    paths: &[ToolPath],
) {
    for leg in plan.segments(runs) {
        let waypoints = paths.get(leg.run.path).map_or(&[][..], |path| &path.waypoints);
        let prints = leg.kind == SegmentKind::Print;
        let mut passes = leg.run.passes.iter().filter_map(|&(knot, waypoint)| Some((knot, waypoint?))).peekable();
        let mut last = 0;
        let bead = |knot: usize| {
            while let Some((_, waypoint)) = passes.next_if(|(passed, _)| prints && *passed <= knot) {
                last = waypoint;
            }
            let waypoint = waypoints.get(last)?;
            let kind = if prints { kind(waypoint.kind) } else { Step::TRAVEL };
            Some((kind, [waypoint.width, waypoint.height]))
        };
        played.add((leg.run.layer, leg.run.path as u32), &leg.knots(), bead);
    }
}

/// Trajectories one after the other, for a path without beads.
pub fn followed<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W, motions: &[Trajectory<N>]) -> Model {
    let knots = motions.iter().map(|motion| motion.times().len()).sum();
    let mut played = Played::new(cell, Isometry3::identity(), knots);
    for (path, motion) in (0..).zip(motions) {
        let (first, _) = motion.span();
        let knots: Vec<_> = motion.times().iter().zip(motion.joints()).map(|(time, at)| (time - first, *at)).collect();
        played.add((0, path), &knots, |_| Some((0, [LINE_MM; 2])));
    }
    let (steps, robot) = played.finish();
    Model {
        name: cell.equipment().name().to_owned(),
        kinds: vec!["path".to_owned()],
        steps,
        nozzle: Some(nozzle(&cell.equipment().model().nozzle)),
        robot: Some(Robot { is_shown: true, ..robot }),
        ..Model::default()
    }
}
