//! Collision indicators on the path's own working surface: Table 4.1 of the dissertation, and what collides at the end.
//!
//! The UR3 holds the part, the head stands still above it: a nozzle and a heater. In the way are the part as built so
//! far and the links of the arm. A motion is planned around them: the ladder passes over postures that collide, the global
//! filter keeps clear of what the geometric indicator predicts, and each step of the result is swept. Postures on contact
//! have the nozzle's tip on a waypoint at any turn, on any branch (on that of the motion none collides, and there is
//! nothing to learn); near ones are up to [`NEAR`] away in the joints.

use super::path::upright;
use curvlay_examples::args::{Failure, warn};
use curvlay_examples::mesh::{MeshFile, Up, read_mesh_file};
use curvlay_examples::motion::{PartInHand, Studied};
use curvlay_kinematics::robots;
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, Sweep, estimated_links};
use curvlay_trajectory::indicator::geometric::{
    BodiesFn, Capsule, Cylinder, DistanceGrid, GeometricIndicator, GeometricModel, Twist,
};
use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, ContactFn, ContactSpace, Rates, Sample, SamplingOptions, random_samples, training_set,
    verification_samples,
};
use curvlay_trajectory::print::Waypoint;
use curvlay_trajectory::{
    Avoid, FreeRange, GlobalOptions, LadderOptions, MIN_WAYPOINTS, Posture, Progress, Robot, RunIn, Timeline,
    Trajectory, plan_ladder, smooth_clear_of,
};
use nalgebra::{Isometry3, IsometryMatrix3, Point3, Vector3};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// The head in the frame of the nozzle, whose z axis points away from the part: name, ends along z, radius.
const HEAD: [(&str, f64, f64, f64); 2] = [("nozzle", 1.5, 40.0, 1.5), ("heater", 50.0, 120.0, 18.0)];
/// Height of a layer: the slab begins so far below the waypoints and is as thick.
const LAYER_MM: f64 = 0.8;
/// Edge of the cells of the slab, and how far aside of a waypoint it reaches.
const CELL_MM: f64 = 0.5;
const ASIDE_MM: f64 = 1.2;
/// Cells around the slab in the grid of distances: the thickest link, the upper arm, has a radius of 47 mm.
const ROOM: u32 = 120;
/// Nodes along the longest side of a part from a file, in the grid of distances.
const NODES: f64 = 150.0;
/// How far from the contact space near samples are, in radians.
const NEAR: f64 = 0.05;
/// What a sweep may take away from the room; the slab begins farther from the nozzle than that.
const RESOLUTION_MM: f64 = 0.05;
/// How far the filter stays away from what the indicator predicts, and the price of coming nearer by a millimetre.
const CLEAR_MM: f64 = 0.1;
const PRICE: f64 = 1e3;
/// The working surface is blended from at most so many planes at waypoints, each over this distance.
const PLANES: usize = 600;
const BLEND_MM: f64 = 4.0;
/// Postures whose evaluation is timed, and how often.
const TIMED: usize = 2000;
const RUNS: usize = 15;

/// What the dissertation adds to the bias of its machines.
pub const PAPER_SHIFT: f64 = 1.0;

/// One indicator in Table 4.1; a rate is none where there was nothing to count.
pub struct Row {
    pub name: &'static str,
    /// Eq. 4.16, near the contact space and on it.
    pub tnr: [Option<f64>; 2],
    /// Share of collisions that are not predicted.
    pub missed: [Option<f64>; 2],
    /// What was added to the bias after learning.
    pub bias_shift: f64,
    /// 0 for one that does not learn.
    pub kernels: usize,
    pub samples: usize,
    /// Value and gradient.
    pub evaluation_us: f64,
}

/// What came of the study.
pub struct Study {
    pub rows: Vec<Row>,
    /// Verification samples near and on contact, and how many of them collide.
    pub verified: [[usize; 2]; 2],
    /// Steps from knot to knot of the motion around obstacles, and those that are not proven free.
    pub motions: usize,
    pub collisions: Vec<String>,
    /// Steps of the smoothest motion, which knows of no obstacle, that are not proven free.
    pub unaware: usize,
    /// What could not be done.
    pub notes: Vec<String>,
}

/// What is in the way in the hand.
struct Obstacle {
    shape: Shape,
    /// Where the shape begins, in the frame of the part.
    corner: Point3<f64>,
    grid: DistanceGrid,
}

/// How much to do.
#[derive(Clone, Copy, Debug)]
pub struct Amount {
    pub training: usize,
    pub verification: usize,
}

/// Plans around what is in the way, learns the indicators and measures them.
///
/// `times`: of the waypoints, piece by piece. `unaware`: the motion by the other methods.
pub fn study(
    robot: &PartInHand,
    times: &[&[f64]],
    origin: &Vector3<f64>,
    part: Option<(&Path, Up)>,
    unaware: &[Trajectory<6>],
    amount: Amount,
) -> Result<Study, Failure> {
    let obstacle = part.map_or_else(|| slab(robot), |(file, up)| from_file(file, up, origin))?;
    let scene = scene(robot, &obstacle)?;
    let geometric = geometric(robot, &obstacle)?;
    let mut study =
        Study { rows: vec![], verified: [[0; 2]; 2], motions: 0, collisions: vec![], unaware: 0, notes: vec![] };
    verify(&scene, unaware, &mut study);
    (study.unaware, study.motions) = (std::mem::take(&mut study.collisions).len(), 0);
    let mut around = vec![];
    let mut first = 0;
    for times in times {
        let piece = robot.part(first..first + times.len());
        first += times.len();
        match clear_motion(&piece, times, &scene, &geometric) {
            Ok(found) => around.extend(found),
            Err(error) => study.notes.push(format!("no motion around what is in the way: {}", error.message())),
        }
    }
    verify(&scene, &around, &mut study);
    let known = if around.is_empty() { unaware } else { &around };
    let joints: Vec<[f64; 6]> = known.iter().flat_map(Trajectory::at_waypoints).copied().collect();
    if joints.is_empty() {
        return Ok(study);
    }
    let middle: [f64; 6] =
        std::array::from_fn(|j| joints.iter().map(|joints| joints[j]).sum::<f64>() / joints.len() as f64);
    let space = contact(robot, &scene, middle);
    let near = verification_samples(&space, amount.verification, NEAR, 11)?;
    let on = verification_samples(&space, amount.verification, 0.0, 12)?;
    study.verified = [&near, &on].map(|all| [all.len(), all.iter().filter(|sample| sample.collides).count()]);
    let options = SamplingOptions {
        initial: SamplingOptions::default().initial.min(amount.training / 3),
        max_samples: amount.training,
        ..SamplingOptions::default()
    };
    let ours = training_set(&space, &options)?.samples;
    let corner = |pick: fn(f64, f64) -> f64| -> [f64; 6] {
        std::array::from_fn(|j| ours.iter().map(|sample| sample.joints[j]).reduce(pick).unwrap_or(0.0))
    };
    let random = random_samples(&space, &corner(f64::min), &corner(f64::max), ours.len(), 3)?;
    let learned = [(["svm", "svm_shifted"], &ours), (["svm_random", "svm_random_shifted"], &random)];
    for (names, samples) in learned {
        match Svm::train(samples, &SvmOptions::default()) {
            Ok(svm) => {
                for (name, bias_shift) in names.into_iter().zip([0.0, PAPER_SHIFT]) {
                    let row = row(name, &svm.clone().shifted(bias_shift), [&near, &on]);
                    study.rows.push(Row { kernels: svm.kernels(), samples: samples.len(), bias_shift, ..row });
                }
            }
            Err(error) => study.notes.push(format!("{} was not trained: {error}", names[0])),
        }
    }
    study.rows.push(row("geometric", &geometric, [&near, &on]));
    Ok(study)
}

fn row(name: &'static str, indicator: &dyn CollisionIndicator<6>, known: [&Vec<Sample<6>>; 2]) -> Row {
    let rates = known.map(|samples| Rates::of(indicator, samples));
    let timed = &known[0][..known[0].len().min(TIMED)];
    let seconds = |_| {
        let start = Instant::now();
        let sum: f64 = timed.iter().map(|sample| indicator.gradient(&sample.joints).0).sum();
        std::hint::black_box(sum);
        start.elapsed().as_secs_f64()
    };
    let least = (0..RUNS).map(seconds).fold(f64::INFINITY, f64::min);
    Row {
        name,
        tnr: rates.map(|rates| rates.tnr()),
        missed: rates.map(|rates| rates.missed_rate()),
        bias_shift: 0.0,
        kernels: 0,
        samples: 0,
        evaluation_us: 1e6 * least / timed.len().max(1) as f64,
    }
}

/// The robot without the postures that collide.
struct Clear<'a> {
    robot: &'a PartInHand,
    scene: &'a Scene,
}

impl Robot<6, 1> for Clear<'_> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; 1] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        self.robot.solutions(waypoint, free, &mut |branch, joints| {
            if matches!(self.scene.touching(&joints.into()), Ok(None)) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// A motion around what is in the way, in runs where the ladder breaks off.
fn clear_motion(
    robot: &PartInHand,
    times: &[f64],
    scene: &Scene,
    indicator: &dyn CollisionIndicator<6>,
) -> Result<Vec<Trajectory<6>>, Failure> {
    let bounds = robot.bounds(false);
    let options = LadderOptions { samples: [8], doublings: 3, breaks: true, ..LadderOptions::default() };
    let go_on = |_: Progress| ControlFlow::Continue(());
    let ladder = plan_ladder(&Clear { robot, scene }, times, &bounds, &options, &go_on)?;
    let avoid = Avoid { indicator, clear: CLEAR_MM, price: PRICE };
    let mut motions = vec![];
    for run in ladder.runs().filter(|run| run.len() >= MIN_WAYPOINTS) {
        let line = Timeline::new(&times[run.clone()], RunIn::default())?;
        let (part, start) = (robot.part(run.clone()), &ladder.nodes[run]);
        let found = smooth_clear_of(&part, &line, start, &bounds, &GlobalOptions::default(), &avoid, &go_on)?;
        motions.push(found.trajectory);
    }
    Ok(motions)
}

/// Every motion from knot to knot against the scene.
fn verify(scene: &Scene, trajectories: &[Trajectory<6>], study: &mut Study) {
    for (run, trajectory) in trajectories.iter().enumerate() {
        for (knot, pair) in trajectory.joints().windows(2).enumerate() {
            study.motions += 1;
            match scene.sweep(&pair[0].into(), &pair[1].into(), RESOLUTION_MM) {
                Ok(Sweep::Free) => {}
                Ok(Sweep::Near { bodies: [a, b], .. }) => {
                    study.collisions.push(format!("run {run}, knot {knot}: {a} and {b}"));
                }
                Err(error) => study.collisions.push(format!("run {run}, knot {knot}: {error}")),
            }
        }
    }
}

/// Cells a layer below the waypoints.
fn slab(robot: &PartInHand) -> Result<Obstacle, Failure> {
    let waypoints = robot.path();
    let around = Vector3::repeat(2.0 * LAYER_MM + ASIDE_MM);
    let low = waypoints.iter().fold(Point3::from([f64::INFINITY; 3]), |low, at| low.inf(&at.position)) - around;
    let high = waypoints.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, at| high.sup(&at.position)) + around;
    let dims = [0, 1, 2].map(|d| ((high[d] - low[d]) / CELL_MM).ceil() as usize);
    let words = dims[0].div_ceil(64);
    let mut rows = vec![0u64; words * dims[1] * dims[2]];
    let deep = 2.0 * LAYER_MM;
    for waypoint in waypoints {
        let range = |d: usize| {
            let place = |by: f64| ((waypoint.position[d] + by - low[d]) / CELL_MM).max(0.0) as usize;
            place(-deep - ASIDE_MM)..dims[d].min(place(ASIDE_MM) + 1)
        };
        for (z, y, x) in range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| (z, y, x)))) {
            let center = low + Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * CELL_MM;
            let from = center - waypoint.position;
            let below = -from.dot(&waypoint.axis);
            let aside = (from.norm_squared() - below * below).max(0.0).sqrt();
            if (LAYER_MM..deep).contains(&below) && aside < ASIDE_MM {
                rows[words * (y + dims[1] * z) + x / 64] |= 1 << (x % 64);
            }
        }
    }
    let dims = dims.map(|n| n as u32);
    let grid = DistanceGrid::from_cells(dims, &rows, CELL_MM, &low, ROOM)?;
    Ok(Obstacle { shape: Shape::Cells { dims, rows, cell: CELL_MM }, corner: low, grid })
}

/// A closed part from a file, where the waypoints have it.
fn from_file(file: &Path, up: Up, origin: &Vector3<f64>) -> Result<Obstacle, Failure> {
    let MeshFile { mesh, findings, .. } = read_mesh_file(file)?;
    findings.iter().for_each(|finding| warn(format!("{}: {finding}", file.display())));
    let (vertices, _) = upright(&(mesh.vertices, vec![]), up);
    let points: Vec<Point3<f64>> = vertices.iter().map(|point| point - origin).collect();
    let low = points.iter().fold(Point3::from([f64::INFINITY; 3]), |low, at| low.inf(at));
    let high = points.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, at| high.sup(at));
    let spacing = ((high - low).amax() / NODES).max(CELL_MM);
    let grid = DistanceGrid::from_triangles(&points, &mesh.triangles, spacing, f64::from(ROOM) * CELL_MM)
        .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
    Ok(Obstacle { shape: Shape::Mesh { points, triangles: mesh.triangles }, corner: Point3::origin(), grid })
}

fn scene(robot: &PartInHand, obstacle: &Obstacle) -> Result<Scene, Failure> {
    let cell = robot.workcell().cell();
    let z = |z: f64| Point3::new(0.0, 0.0, z);
    let head = HEAD.map(|(name, from, to, radius)| Body {
        name: name.into(),
        mount: Mount::Base,
        mount_body: cell.nozzle_frame().1,
        shape: Shape::Capsule { from: z(from), to: z(to), radius },
    });
    let part = Body {
        name: "part".into(),
        mount: Mount::Link(6),
        mount_body: cell.part_frame().1
            * Isometry3::translation(obstacle.corner.x, obstacle.corner.y, obstacle.corner.z),
        shape: obstacle.shape.clone(),
    };
    let bodies = head.into_iter().chain([part]).collect();
    Ok(Scene::new(SceneModel { bodies, links: estimated_links(&robots::UR3), ..SceneModel::of(*cell.arm()) })?)
}

/// The part as a grid; head and links as capsules, foot and flange as cylinders, against it and each other.
fn geometric(robot: &PartInHand, obstacle: &Obstacle) -> Result<impl CollisionIndicator<6>, Failure> {
    let cell = *robot.workcell().cell();
    let held = nalgebra::convert::<_, IsometryMatrix3<f64>>(cell.part_frame().1);
    // Bodies 0 to 6 are the frames of the arm, body 7 is the part.
    let bodies = BodiesFn {
        carriers: (0..8).map(|body: usize| std::array::from_fn(|joint| joint < body.min(6))).collect(),
        place: move |q: &[f64; 6], frames: &mut [IsometryMatrix3<f64>]| {
            frames[..7].copy_from_slice(&cell.arm().matrices(q));
            frames[7] = frames[6] * held;
        },
        // A joint of such an arm turns about the z axis of the frame before it.
        twists: |_: &[f64; 6], frames: &[IsometryMatrix3<f64>]| {
            let axis = |k: usize| frames[k].rotation * Vector3::z();
            std::array::from_fn(|k| Twist::turning(&frames[k].translation.vector.into(), &axis(k)))
        },
    };
    let base_nozzle = cell.nozzle_frame().1;
    let at = |z: f64| base_nozzle * Point3::new(0.0, 0.0, z);
    let (mut capsules, mut cylinders) = (vec![], vec![]);
    for link in estimated_links(&robots::UR3) {
        let body = if let Mount::Link(link) = link.mount { link } else { 0 };
        match link.shape {
            Shape::Capsule { from, to, radius } => capsules.push(Capsule { body, from, to, radius }),
            Shape::Hull { points, .. } => cylinders.push(drum(body, &points)),
            Shape::Mesh { .. } | Shape::Cells { .. } | Shape::Union(_) => unreachable!("links are capsules and hulls"),
        }
    }
    capsules.extend(HEAD.map(|(_, from, to, radius)| Capsule { body: 0, from: at(from), to: at(to), radius }));
    let model = GeometricModel {
        grids: vec![(7, obstacle.grid.clone())],
        capsules,
        cylinders,
        ignored: (0..6).map(|k| [k, k + 1]).collect(),
        ..GeometricModel::default()
    };
    Ok(GeometricIndicator::new(bodies, model)?)
}

/// The cylinder about z that a prism of twelve sides stands for: midway between the circles within and about it.
fn drum(body: usize, points: &[Point3<f64>]) -> Cylinder {
    let about = points.iter().map(|point| point.x.hypot(point.y)).fold(0.0, f64::max);
    let low = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|point| point.z).fold(f64::NEG_INFINITY, f64::max);
    let end = |z: f64| Point3::new(0.0, 0.0, z);
    Cylinder { body, from: end(low), to: end(high), radius: 0.5 * about * (1.0 + (PI / 12.0).cos()) }
}

/// The tip on a waypoint, turned at will, on any branch, joints within half a turn of the motion's middle.
fn contact<'a>(robot: &'a PartInHand, scene: &'a Scene, middle: [f64; 6]) -> impl ContactSpace<6> + use<'a> {
    let surface: Vec<Waypoint> = robot.path().iter().step_by(robot.waypoints().div_ceil(PLANES)).copied().collect();
    ContactFn {
        collides: |q: &[f64; 6]| !matches!(scene.touching(&(*q).into()), Ok(None)),
        gap: move |q: &[f64; 6]| {
            let tip = Point3::from(robot.workcell().cell().nozzle_on_part(q).translation.vector);
            let nearest = surface.iter().map(|at| (tip - at.position).norm_squared()).fold(f64::INFINITY, f64::min);
            let (mut sum, mut weights) = (0.0, 0.0);
            for at in &surface {
                let off = tip - at.position;
                let far = (off.norm_squared() - nearest) / (BLEND_MM * BLEND_MM);
                // What is farther weighs less than rounding.
                if far < 40.0 {
                    let weight = (-far).exp();
                    sum += weight * off.dot(&at.axis);
                    weights += weight;
                }
            }
            sum / weights
        },
        sample: move |random: &mut dyn FnMut() -> f64| {
            let waypoint = (random() * robot.waypoints() as f64) as usize;
            let mut solutions: Vec<[f64; 6]> = Vec::new();
            let waypoint = waypoint.min(Robot::waypoints(robot) - 1);
            Robot::solutions(robot, waypoint, &[TAU * random()], &mut |_, joints| solutions.push(joints));
            let joints = *solutions.get((random() * solutions.len() as f64) as usize)?;
            Some(std::array::from_fn(|j| joints[j] + TAU * ((middle[j] - joints[j]) / TAU).round()))
        },
    }
}
