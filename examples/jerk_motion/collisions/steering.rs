//! Motions that an indicator steers, by Algorithm 6 with its rows (Eq. 4.12) and by the global filter; judged by the exact
//! scene, and repaired where they collide (Eq. 4.13).

use super::audited::{Audit, Start, audited, go_on, is_free, through};
use super::repairing::{Repaired, repaired};
use curvlay_examples::args::Failure;
use curvlay_examples::motion::{PartInHand, Studied};
use curvlay_kinematics::scene::Scene;
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::{
    Avoid, ClearOf, FilterOptions, FreeRange, GlobalOptions, LadderNode, LadderOptions, MIN_WAYPOINTS, Posture, Robot,
    RunIn, Timeline, Trajectory, filter_clear_of, filter_locally, jerk_measure, plan_ladder, smooth_clear_of,
    smooth_globally,
};
use std::ops::Range;
use std::time::{Duration, Instant};

/// What steers.
#[derive(Clone, Copy)]
pub struct Steering<'a> {
    /// The word of the summary.
    pub name: &'static str,
    /// None: nothing.
    pub indicator: Option<&'a dyn CollisionIndicator<6>>,
    /// How far the filters stay below zero, in its own unit, and the price of a unit more in the global one.
    pub clear: f64,
    pub price: f64,
}

/// Which filter is steered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Algorithm 6.
    Local,
    /// All waypoints at once.
    Global,
}

impl Filter {
    /// The word of the summary.
    pub fn name(self) -> &'static str {
        match self {
            Filter::Local => "local",
            Filter::Global => "global",
        }
    }
}

/// A motion that was steered.
pub struct Steered {
    pub indicator: &'static str,
    pub filter: Filter,
    pub trajectories: Vec<Trajectory<6>>,
    /// The waypoint in the middle of the longest of them: its posture, and its derivative by the turn of the tool.
    pub middle: Option<([f64; 6], [f64; 6])>,
    /// Eq. 4.10 at the waypoints.
    pub j: f64,
    /// Greatest of any joint, everywhere on the spline.
    pub max_jerk: f64,
    /// Waypoints at which the indicator itself predicts a collision.
    pub predicted: usize,
    pub audit: Audit,
    /// None where no waypoint and no motion between two collides.
    pub repaired: Option<Repaired>,
    /// Of the filter alone.
    pub time: Duration,
    pub repair_time: Duration,
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
            if is_free(self.scene, &joints) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// Where the motions along a piece of the path begin: a ladder around what is in the way, in runs where it breaks off.
pub fn starts(robot: &PartInHand, times: &[f64], scene: &Scene) -> Result<Vec<Start>, Failure> {
    let options = LadderOptions { samples: [8], doublings: 3, breaks: true, ..LadderOptions::default() };
    let ladder = plan_ladder(&Clear { robot, scene }, times, &robot.bounds(false), &options, &go_on)?;
    let start = |run: Range<usize>| Start {
        robot: robot.part(run.clone()),
        times: times[run.clone()].to_vec(),
        nodes: ladder.nodes[run].to_vec(),
    };
    Ok(ladder.runs().filter(|run| run.len() >= MIN_WAYPOINTS).map(start).collect())
}

/// Filters the starts, asks the scene about what came of it, and repairs it where it collides.
pub fn steer(starts: &[Start], steering: &Steering<'_>, filter: Filter, scene: &Scene) -> Result<Steered, Failure> {
    let begin = Instant::now();
    let filtered = |start: &Start| match filter {
        Filter::Local => locally(start, steering),
        Filter::Global => globally(start, steering),
    };
    let motions = starts.iter().map(filtered).collect::<Result<Vec<_>, _>>()?;
    let time = begin.elapsed();
    let longest = starts.iter().zip(&motions).max_by_key(|(start, _)| start.times.len());
    let middle = longest.and_then(|(start, (nodes, _))| {
        let (waypoint, node) = (nodes.len() / 2, &nodes[nodes.len() / 2]);
        Some((node.joints, start.robot.posture(waypoint, &node.free, node.branch)?.rates[0]))
    });
    let trajectories: Vec<_> = motions.into_iter().map(|(_, trajectory)| trajectory).collect();
    let predicts = |joints: &&[f64; 6]| steering.indicator.is_some_and(|indicator| indicator.predicts(joints));
    let j = starts.iter().zip(&trajectories).map(|(start, found)| jerk_measure(&start.times, found.at_waypoints()));
    let extremes = trajectories.iter().flat_map(Trajectory::extremes);
    let audit = audited(scene, starts, &trajectories);
    let begin = Instant::now();
    let repaired = repaired(scene, starts, &trajectories)?;
    Ok(Steered {
        indicator: steering.name,
        filter,
        j: j.sum(),
        max_jerk: extremes.map(|joint| joint.jerk.value.abs()).fold(0.0, f64::max),
        predicted: trajectories.iter().flat_map(Trajectory::at_waypoints).filter(predicts).count(),
        audit,
        repaired,
        middle,
        trajectories,
        time,
        repair_time: begin.elapsed(),
    })
}

/// A motion: its waypoints and its spline.
type Motion = (Vec<LadderNode<6, 1>>, Trajectory<6>);

/// Algorithm 6, with the rows of Eq. 4.12 where there is an indicator.
fn locally(start: &Start, steering: &Steering<'_>) -> Result<Motion, Failure> {
    let Start { robot, times, nodes } = start;
    let (bounds, options) = (robot.bounds(false), FilterOptions::default());
    let filtered = match steering.indicator {
        Some(indicator) => {
            let clear = ClearOf { indicator, clear: steering.clear };
            filter_clear_of(robot, times, nodes, &bounds, &clear, &options, &go_on)?
        }
        None => filter_locally(robot, times, nodes, &bounds, &options, &go_on)?,
    };
    let joints: Vec<[f64; 6]> = filtered.nodes.iter().map(|node| node.joints).collect();
    Ok((filtered.nodes, through(times, &joints)?))
}

fn globally(start: &Start, steering: &Steering<'_>) -> Result<Motion, Failure> {
    let Start { robot, times, nodes } = start;
    let (bounds, options) = (robot.bounds(false), GlobalOptions::default());
    let line = Timeline::new(times, RunIn::default())?;
    let found = match steering.indicator {
        Some(indicator) => {
            let avoid = Avoid { indicator, clear: steering.clear, price: steering.price };
            smooth_clear_of(robot, &line, nodes, &bounds, &options, &avoid, &go_on)?
        }
        None => smooth_globally(robot, &line, nodes, &bounds, &options, &go_on)?,
    };
    Ok((found.nodes, found.trajectory))
}
