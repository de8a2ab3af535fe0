//! Collision indicators on the path's own working surface: Table 4.1 of the dissertation, and what they are worth when they
//! steer.
//!
//! The UR3 holds the part, the head stands still above it: a nozzle and a heater. In the way are the part as built so
//! far and the links of the arm. Motions are planned around them: the ladder passes over postures that collide, Algorithm 6
//! and the global filter keep clear of what an indicator predicts, geometric or learned, and each step of the result is
//! swept by the exact scene.

mod amount;
mod audited;
mod learned;
mod repairing;
mod scene;
mod steering;
mod surface;

pub use amount::Amount;
pub use audited::Audit;
pub use learned::{PAPER_SHIFT, Row};
pub use steering::Steered;

use audited::{Start, unproven};
use curvlay_examples::args::Failure;
use curvlay_examples::mesh::Up;
use curvlay_examples::motion::PartInHand;
use curvlay_kinematics::scene::Scene;
use curvlay_trajectory::Trajectory;
use curvlay_trajectory::indicator::CollisionIndicator;
use learned::{Known, Machines, learn};
use nalgebra::Vector3;
use scene::{Obstacle, Post};
use std::path::Path;
use steering::{Filter, Steering, starts, steer};
use surface::Surface;

/// How far filters stay away from what the geometric indicator predicts, and the price of coming nearer by a millimetre.
const CLEAR_MM: f64 = 0.1;
const PRICE: f64 = 1e3;
/// The price of a unit of a learned indicator, the width of its margin, which is some tenths of a radian: with less,
/// collisions that are predicted remain; with more, the same motion comes out.
const LEARNED_PRICE: f64 = 1e4;

/// Waypoints to either side of the middle that pass the post.
const PAST: usize = 60;

/// Filters that know of nothing in the way.
const UNSTEERED: Steering<'static> = Steering { name: "unsteered", indicator: None, clear: 0.0, price: PRICE };

/// What came of the study.
pub struct Study {
    /// Table 4.1, without the post.
    pub rows: Vec<Row>,
    /// Verification samples near and on contact, and how many of them collide.
    pub verified: [[usize; 2]; 2],
    /// Steps from knot to knot of the motion that the geometric indicator steers through the global filter, without the
    /// post, and those that are not proven free.
    pub motions: usize,
    pub collisions: Vec<String>,
    /// Steps of the smoothest motion, which knows of no obstacle, that are not proven free.
    pub unaware: usize,
    /// The table again for the waypoints past the post, and how many they are; none without a post.
    pub past_post: Option<(usize, Vec<Row>)>,
    /// Motions with nothing that steers, with the geometric indicator and with the learned ones, past the post if there is
    /// one.
    pub steered: Vec<Steered>,
    /// What could not be done.
    pub notes: Vec<String>,
}

/// Plans around what is in the way, learns the indicators, measures them, and lets them steer.
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
    let obstacle = part.map_or_else(|| scene::slab(robot), |(file, up)| scene::from_file(file, up, origin))?;
    let (scene, geometric) = (scene::scene(robot, &obstacle, None)?, scene::geometric(robot, &obstacle, None)?);
    let mut study = Study {
        rows: vec![],
        verified: [[0; 2]; 2],
        motions: 0,
        collisions: vec![],
        unaware: unaware.iter().map(|motion| unproven(&scene, 0, motion).1.len()).sum(),
        past_post: None,
        steered: vec![],
        notes: vec![],
    };
    let starts = all_starts(robot, times, &scene, &mut study.notes);
    let around = (!starts.is_empty()).then(|| steer(&starts, &by_distance(&geometric), Filter::Global, &scene));
    let around = around.transpose()?;
    if let Some(Audit { steps, unproven, .. }) = around.as_ref().map(|steered| &steered.audit) {
        (study.motions, study.collisions) = (*steps, unproven.clone());
    }
    let known = around.as_ref().map_or(unaware, |steered| &steered.trajectories);
    let Some(middle) = middle(known) else { return Ok(study) };
    let space = Surface::new(robot, &scene, middle);
    let known = Known::new(&space, amount.verification)?;
    study.verified = known.counts();
    let machines = learn(&space, &known, amount, (&mut study.rows, &mut study.notes))?;
    study.rows.push(known.row("geometric", &geometric));
    match amount.post_mm.zip(starts.iter().max_by_key(|start| start.len())) {
        Some((mm, longest)) => study.past_post(longest, &obstacle, 0.5 * mm, amount)?,
        None => study.steer_all(&starts, &scene, &geometric, &machines),
    }
    Ok(study)
}

/// Steered by distances.
fn by_distance(indicator: &dyn CollisionIndicator<6>) -> Steering<'_> {
    Steering { name: "geometric", indicator: Some(indicator), clear: CLEAR_MM, price: PRICE }
}

/// Where motions around what is in the way begin, on all pieces of the path; a piece without is a note.
fn all_starts(robot: &PartInHand, times: &[&[f64]], scene: &Scene, notes: &mut Vec<String>) -> Vec<Start> {
    let (mut all, mut first) = (vec![], 0);
    for times in times {
        let piece = robot.part(first..first + times.len());
        first += times.len();
        match starts(&piece, times, scene) {
            Ok(found) => all.extend(found),
            Err(error) => notes.push(format!("no motion around what is in the way: {}", error.message())),
        }
    }
    all
}

/// The mean of the joints at the waypoints; none without waypoints.
fn middle(trajectories: &[Trajectory<6>]) -> Option<[f64; 6]> {
    let joints: Vec<[f64; 6]> = trajectories.iter().flat_map(Trajectory::at_waypoints).copied().collect();
    let mean = |j: usize| joints.iter().map(|joints| joints[j]).sum::<f64>() / joints.len() as f64;
    (!joints.is_empty()).then(|| std::array::from_fn(mean))
}

impl Study {
    /// Motions of the waypoints around the middle of a start, past a post that the unsteered one touches; machines learn
    /// anew what is in the way there.
    fn past_post(&mut self, start: &Start, obstacle: &Obstacle, radius: f64, amount: Amount) -> Result<(), Failure> {
        let middle = start.len() / 2;
        let start = start.part(middle.saturating_sub(PAST)..(middle + PAST).min(start.len()));
        let robot = start.robot();
        let without = scene::scene(robot, obstacle, None)?;
        let unsteered = steer(std::slice::from_ref(&start), &UNSTEERED, Filter::Global, &without)?;
        let post = unsteered.middle.and_then(|(joints, rates)| Post::beside_wrist(robot, &joints, &rates, radius));
        let Some(post) = post else {
            self.notes.push("no post: the tool's turn does not move wrist 2 there".to_owned());
            return Ok(());
        };
        let (scene, geometric) =
            (scene::scene(robot, obstacle, Some(&post))?, scene::geometric(robot, obstacle, Some(&post))?);
        let starts = all_starts(robot, &[start.times()], &scene, &mut self.notes);
        let Some(middle) = self::middle(&unsteered.trajectories) else { return Ok(()) };
        let space = Surface::new(robot, &scene, middle);
        let known = Known::new(&space, amount.verification)?;
        let mut rows = vec![];
        let machines = learn(&space, &known, amount, (&mut rows, &mut self.notes))?;
        rows.push(known.row("geometric", &geometric));
        self.past_post = Some((start.len(), rows));
        self.steer_all(&starts, &scene, &geometric, &machines);
        Ok(())
    }

    /// Both filters with nothing that steers, and with every indicator.
    fn steer_all(
        &mut self,
        starts: &[Start],
        scene: &Scene,
        geometric: &dyn CollisionIndicator<6>,
        machines: &Machines<'_>,
    ) {
        self.steer(starts, &UNSTEERED, scene);
        self.steer(starts, &by_distance(geometric), scene);
        let paper = machines.paper.as_ref().map(|svm| svm as &dyn CollisionIndicator<6>);
        let gap = machines.gap.as_ref().map(|svm| svm as &dyn CollisionIndicator<6>);
        for (name, indicator) in [("svm_shifted", paper), ("svm_gap_shifted", gap)] {
            // The shift is the margin.
            let by = Steering { name, indicator, clear: 0.0, price: LEARNED_PRICE };
            if indicator.is_some() {
                self.steer(starts, &by, scene);
            }
        }
    }

    /// Both filters by one indicator; a filter that fails is a note.
    fn steer(&mut self, starts: &[Start], by: &Steering<'_>, scene: &Scene) {
        for filter in [Filter::Local, Filter::Global].into_iter().filter(|_| !starts.is_empty()) {
            match steer(starts, by, filter, scene) {
                Ok(steered) => self.steered.push(steered),
                Err(error) => {
                    self.notes.push(format!("no motion by {} and {}: {}", by.name, filter.name(), error.message()));
                }
            }
        }
    }
}

impl Steered {
    /// The words of the summary.
    pub fn name(&self) -> String {
        format!("steered_{}_{}", self.indicator, self.filter.name())
    }
}
