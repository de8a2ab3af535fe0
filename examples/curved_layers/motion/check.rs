//! The motion that was written, read again and checked: limits, deviation, contact, collisions, and what is never printed.
//!
//! Nothing here knows of the planner. The motions are those of `trajectory.csv`, the path is that of the machine file, and
//! [`check_motion`] computes splines and extremes by itself.

use super::Print;
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{PrintingCell, placed};
use curvlay_kinematics::workcell::Workcell;
use curvlay_toolpath::surface::{GougingOptions, Moment};
use curvlay_trajectory::check::{
    CheckOptions, CheckedMotion, FindingKind, MotionKind, MotionReport, PathPoint, PrintReport, PrintScene,
    check_motion,
};
use curvlay_trajectory::print::{LegKind, PrintCell, PrintLimits};
use nalgebra::{Isometry3, Point3, UnitVector3};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Share by which a rate may pass its limit: what rounding of the written joints, 13 digits, makes of the jerk.
const SLACK: f64 = 1e-4;

/// How deep the nozzle counts where that cannot be said, in millimetres: deeper than any part.
const UNKNOWN_MM: f64 = 1e6;

/// How far a joint may be from where the motion before ends, in radians: 5 micrometres at half a metre. At rest the end of a
/// spline follows from the knots beside it, and is met to about 1e-6.
const MAX_GAP: f64 = 1e-5;

/// A motion as it stands in `trajectory.csv`.
pub struct Written<const N: usize> {
    pub kind: LegKind,
    /// From 0.
    pub layer: u32,
    pub path: usize,
    pub times: Vec<f64>,
    pub joints: Vec<[f64; N]>,
    /// The waypoints of the path that it passes, and when.
    pub waypoints: Vec<(usize, f64)>,
}

impl<const N: usize> Written<N> {
    /// The waypoints of its path that it prints.
    fn printed(&self) -> Option<Range<usize>> {
        Some(self.waypoints.first()?.0..self.waypoints.last()?.0 + 1)
    }
}

/// What came of the check.
pub struct Checked<const N: usize> {
    pub report: PrintReport<N>,
    /// How many motions there are.
    pub motions: usize,
    /// The motion of each finding.
    pub of: Vec<(LegKind, u32, usize)>,
    /// Length of all paths, with what was left out of them, and of what no motion goes along.
    pub path_mm: f64,
    pub unprinted_mm: f64,
    pub took: Duration,
}

/// Sorts of findings, as they are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    Limits,
    Deviations,
    Contacts,
    Collisions,
    Joins,
}

impl Sort {
    pub const ALL: [Sort; 5] = [Sort::Limits, Sort::Deviations, Sort::Contacts, Sort::Collisions, Sort::Joins];

    fn of(kind: &FindingKind) -> Self {
        match kind {
            FindingKind::Limit { .. } => Sort::Limits,
            FindingKind::Deviation { .. } | FindingKind::Tilt { .. } | FindingKind::Skipped { .. } => Sort::Deviations,
            FindingKind::Contact { .. } => Sort::Contacts,
            FindingKind::Collision { .. } => Sort::Collisions,
            _ => Sort::Joins,
        }
    }

    /// Whether a motion of which this was found is kept out of the programs. One off its path is no danger.
    pub fn is_unsafe(self) -> bool {
        self != Sort::Deviations
    }

    pub fn name(self) -> &'static str {
        match self {
            Sort::Limits => "beyond a limit",
            Sort::Deviations => "off the path",
            Sort::Contacts => "with the nozzle in what is built",
            Sort::Collisions => "not proven free",
            Sort::Joins => "not joined",
        }
    }
}

impl<const N: usize> Checked<N> {
    /// Motions with findings of a sort.
    pub fn count(&self, sort: Sort) -> usize {
        let findings = self.report.findings.iter().filter(|finding| Sort::of(&finding.kind) == sort);
        let mut motions: Vec<usize> = findings.map(|finding| finding.motion).collect();
        motions.dedup();
        motions.len()
    }

    /// Motions that no program may hold, by their numbers in `trajectory.csv`.
    pub fn unsafe_motions(&self) -> BTreeSet<usize> {
        let findings = self.report.findings.iter().filter(|finding| Sort::of(&finding.kind).is_unsafe());
        findings.map(|finding| finding.motion).collect()
    }
}

/// Checks the motions that were written, layer by layer, with the part as it is built by then.
pub fn check<const N: usize, const F: usize, W: Workcell<N, F>>(
    print: &Print,
    (cell, frame_part): (&W, &Isometry3<f64>),
    limits: &PrintLimits<N>,
    motions: &[Written<N>],
    bars: &Bars,
) -> Result<Checked<N>, Failure> {
    let start = Instant::now();
    let GougingOptions { allowed_depth, max_turn: max_angle, .. } = GougingOptions::default();
    let options = CheckOptions {
        slack: SLACK,
        max_gap: MAX_GAP,
        max_deviation_mm: limits.tolerance_mm,
        max_angle,
        ..CheckOptions::default()
    };
    let report = print.in_workcell((cell, frame_part), allowed_depth, bars, |mut cell| {
        let scene = Executed { print, motions, cell: &cell };
        let path: Vec<Vec<PathPoint>> = motions.iter().map(|motion| scene.path(motion)).collect();
        let mut reports: Vec<MotionReport<N>> = Vec::with_capacity(motions.len());
        for of_layer in motions.chunk_by(|a, b| a.layer == b.layer) {
            bars.update("check motions", reports.len() as u64, motions.len() as u64);
            cell.begin(of_layer[0].layer).map_err(failure)?;
            cell.build(of_layer[0].layer).map_err(failure)?;
            let (scene, first) = (Executed { print, motions, cell: &cell }, reports.len());
            let one = |number: usize| {
                let motion = CheckedMotion { apart: scene.is_apart(number), ..scene.motion(number, &path[number]) };
                check_motion(number, &motion, &limits.bounds, &scene, &options)
            };
            let found: Result<Vec<_>, _> = (first..first + of_layer.len()).into_par_iter().map(one).collect();
            reports.extend(found.map_err(failure)?);
        }
        Ok(PrintReport::of(&reports, &options))
    })?;
    let of = report.findings.iter().map(|finding| &motions[finding.motion]);
    let of = of.map(|motion| (motion.kind, motion.layer, motion.path)).collect();
    let [path_mm, unprinted_mm] = lengths(print, motions);
    Ok(Checked { report, motions: motions.len(), of, path_mm, unprinted_mm, took: start.elapsed() })
}

/// What the checker asks of cell and part.
struct Executed<'a, const N: usize, const F: usize, W> {
    print: &'a Print<'a>,
    motions: &'a [Written<N>],
    cell: &'a PrintingCell<'a, N, F, W>,
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Executed<'_, N, F, W> {
    /// What a motion is to follow, over what carries the part.
    fn path(&self, motion: &Written<N>) -> Vec<PathPoint> {
        let (LegKind::Print, Some(waypoints)) = (motion.kind, motion.printed()) else { return Vec::new() };
        let mut passed = motion.waypoints.iter().copied().peekable();
        let point = |waypoint: usize| {
            let placed =
                placed(&self.print.machine.resolved.paths[motion.path].waypoints[waypoint], self.cell.frame_part());
            let passed_s = passed.next_if(|(passed, _)| *passed == waypoint).map(|(_, time)| time);
            PathPoint { tip: placed.position, axis: placed.axis, passed_s }
        };
        waypoints.map(point).collect()
    }

    fn motion<'a>(&'a self, number: usize, path: &'a [PathPoint]) -> CheckedMotion<'a, N> {
        let Written { kind, times, joints, .. } = &self.motions[number];
        let kind = if *kind == LegKind::Print { MotionKind::Print } else { MotionKind::Travel };
        CheckedMotion { kind, times, joints, path, printing: None, apart: false }
    }

    /// Whether a motion is not led to: behind a transfer that was not found, and the first.
    fn is_apart(&self, number: usize) -> bool {
        let before = number.checked_sub(1).map(|before| self.motions[before].kind);
        self.motions[number].kind == LegKind::Print && before.is_none_or(|before| before == LegKind::Print)
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> PrintScene<N> for Executed<'_, N, F, W> {
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.cell.nozzle(joints)
    }

    /// By the rule of the machine file. Transfers keep the margin from the part, which is looked at in sweeps.
    fn contact(
        &self,
        moment: &curvlay_trajectory::check::Moment,
        tip: &Point3<f64>,
        axis: &UnitVector3<f64>,
    ) -> Option<curvlay_trajectory::check::Contact> {
        let motion = &self.motions[moment.motion];
        let then = match motion.kind {
            LegKind::Print => Moment::At { path: motion.path, waypoint: motion.printed()?.start + moment.point },
            // What it has laid last was shaped by the nozzle itself.
            LegKind::Lift => {
                let printed = self.motions[..moment.motion].last().and_then(Written::printed);
                Moment::At { path: motion.path, waypoint: printed?.end - 1 }
            }
            LegKind::Approach => Moment::After { path: motion.path },
            LegKind::Transfer => return None,
        };
        let (depth_mm, what) = match self.cell.deepest(then, tip, axis) {
            Ok(found) => found.map(|found| (found.depth, format!("{} with its {}", found.obstacle, found.part)))?,
            Err(error) => (UNKNOWN_MM, error.to_string()),
        };
        Some(curvlay_trajectory::check::Contact { depth_mm, what })
    }

    fn sweep(&self, motion: usize, _: usize, control: &[[f64; N]; 4]) -> Option<String> {
        match self.motions[motion].kind {
            LegKind::Transfer => self.cell.touches_moving(control),
            LegKind::Print | LegKind::Lift | LegKind::Approach => self.cell.touches(control),
        }
    }
}

/// Length of all paths, and of what no motion goes along.
fn lengths<const N: usize>(print: &Print, motions: &[Written<N>]) -> [f64; 2] {
    let paths = &print.machine.resolved.paths;
    let length = |path: usize, waypoints: Range<usize>| {
        let tips = paths[path].waypoints[waypoints].windows(2);
        tips.map(|pair| (pair[1].tip - pair[0].tip).norm()).sum::<f64>()
    };
    let [_, left_out] = print.machine.lengths_mm();
    let all = (0..paths.len()).map(|path| length(path, 0..paths[path].waypoints.len())).sum::<f64>() + left_out;
    let printed = motions.iter().filter(|motion| motion.kind == LegKind::Print);
    let of = |motion: &Written<N>| motion.printed().map_or(0.0, |waypoints| length(motion.path, waypoints));
    [all, (all - printed.map(of).sum::<f64>()).max(0.0)]
}
