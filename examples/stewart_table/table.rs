//! The machine, and the way of its platform along the layer.

use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::stewart::{Stewart, StewartFault, StewartModel};
use curvlay_kinematics::{Waypoint, nozzle_frame};
use std::f64::consts::PI;
use std::time::{Duration, Instant};

/// Height at which the platform's joints were mounted: the middle of their cones.
const HOME_MM: f64 = 370.0;

/// The machine: a base of 325 mm, a platform of 125 mm, legs of 330 to 540 mm and 16 mm thick, joints that lean by 45
/// degrees.
pub fn machine() -> StewartModel {
    let open = StewartModel::hexagon(325.0, PI / 12.0, 125.0, PI / 4.0);
    let limited = StewartModel { shortest: [330.0; 6], longest: [540.0; 6], leg_radius: 8.0, ..open };
    limited.with_cones_at(&Isometry3::translation(0.0, 0.0, HOME_MM), PI / 4.0, PI / 4.0)
}

/// Legs are found again to this.
const RESIDUAL_MM: f64 = 1e-9;

/// A waypoint under the nozzle.
pub struct Pose {
    pub waypoint: Waypoint,
    pub base_platform: Isometry3<f64>,
    pub legs: [f64; 6],
    pub singularity: f64,
    pub fault: Option<StewartFault>,
}

/// A layer on the platform.
pub struct Printed {
    pub poses: Vec<Pose>,
    pub unreachable: usize,
    pub min_leg_mm: f64,
    pub max_leg_mm: f64,
    pub min_singularity: f64,
    /// Largest step of a leg between neighbours.
    pub largest_step_mm: f64,
    /// Largest distance of the nozzle's tip from its waypoint, and of legs from their lengths, with the pose computed
    /// back from the legs.
    pub worst_tip_mm: f64,
    pub worst_leg_mm: f64,
    /// Waypoints whose pose was not the one that its legs lead to from the pose before.
    pub lost: usize,
    pub time: Duration,
}

impl Printed {
    /// The checks that do not hold.
    pub fn failed_checks(&self) -> Vec<String> {
        [
            ("reach", self.unreachable == 0),
            ("legs", self.worst_leg_mm <= RESIDUAL_MM),
            ("nozzle", self.worst_tip_mm <= 1e-6),
            ("continuity", self.lost == 0),
        ]
        .into_iter()
        .filter(|(_, holds)| !holds)
        .map(|(name, _)| name.to_owned())
        .collect()
    }
}

/// Poses the platform for each waypoint, and goes along the layer a second time by the legs alone.
pub fn print(nozzle_mm: f64, waypoints: &[Waypoint], bars: &Bars) -> Result<Printed, Failure> {
    let start = Instant::now();
    let table = Stewart::new(&machine())?;
    let tip = Point3::new(0.0, 0.0, nozzle_mm);
    let base_nozzle = nozzle_frame(&tip, &-Vector3::z_axis());
    let poses: Vec<Pose> = waypoints
        .iter()
        .map(|waypoint| {
            // The shortest turn that brings the direction of growth upright.
            let base_platform = base_nozzle * waypoint.frame(0.0).inverse();
            let (legs, fault) = (table.legs(&base_platform), table.fault(&base_platform));
            let singularity = table.singularity(&base_platform);
            Pose { waypoint: *waypoint, base_platform, legs, singularity, fault }
        })
        .collect();
    let reached = || poses.iter().filter(|pose| pose.fault.is_none());
    let unreachable = poses.len() - reached().count();
    if let (Some(fault), true) = (poses.first().and_then(|pose| pose.fault), unreachable == poses.len()) {
        return Err(Failure::new(format!("no waypoint can be reached; of the first one: {fault}")));
    }
    let lengths = || reached().flat_map(|pose| pose.legs);
    let mut printed = Printed {
        unreachable,
        min_leg_mm: lengths().fold(f64::INFINITY, f64::min),
        max_leg_mm: lengths().fold(0.0, f64::max),
        min_singularity: reached().map(|pose| pose.singularity).fold(f64::INFINITY, f64::min),
        largest_step_mm: 0.0,
        worst_tip_mm: 0.0,
        worst_leg_mm: 0.0,
        lost: 0,
        time: Duration::ZERO,
        poses: Vec::new(),
    };
    let mut before: Option<(&Pose, Isometry3<f64>)> = None;
    for (index, pose) in poses.iter().enumerate() {
        if index.is_multiple_of(1024) {
            bars.update("platform", index as u64, poses.len() as u64);
        }
        if pose.fault.is_some() {
            before = None;
            continue;
        }
        // A run begins where its first pose is.
        let (last, from) = before.unwrap_or((pose, pose.base_platform));
        let step = (0..6).map(|k| (pose.legs[k] - last.legs[k]).abs()).fold(0.0, f64::max);
        printed.largest_step_mm = printed.largest_step_mm.max(step);
        // The control goes on with the last pose before it, as it would on the machine.
        let found = table.follow([last.legs, pose.legs], &from).ok().and_then(|found| found.last().copied());
        let found = found.unwrap_or(from);
        let legs = table.legs(&found);
        let off = (0..6).map(|k| (legs[k] - pose.legs[k]).abs()).fold(0.0, f64::max);
        let tip_off = (found * pose.waypoint.position - tip).norm();
        printed.worst_leg_mm = printed.worst_leg_mm.max(off);
        printed.worst_tip_mm = printed.worst_tip_mm.max(tip_off);
        printed.lost += usize::from(tip_off > 1e-6);
        before = Some((pose, found));
    }
    (printed.poses, printed.time) = (poses, start.elapsed());
    Ok(printed)
}
