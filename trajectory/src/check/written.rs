//! The check of a print as it was written to a file, layer by layer, with the part as it is built by then.
//!
//! Nothing here knows of the planner: motions are read again from the file, and the path is that of the tool paths.

use super::report::{FindingClass, MotionReport, PrintReport};
use super::scene::{Contact, Moment, PrintScene};
use super::{CheckError, CheckOptions, CheckedMotion, MotionKind, PathPoint, check_motion};
use crate::print::{Moment as Built, SegmentKind, Waypoint};
use crate::{Bounds, Progress, ProgressFn, parallel};
use nalgebra::{Isometry3, Point3, UnitVector3};
use std::convert::Infallible;
use std::ops::Range;

/// A motion as it stands in a file. All motions have one clock.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WrittenMotion<const N: usize> {
    /// What it is for.
    pub kind: SegmentKind,
    /// The layer that is printed by then; motions of a layer stand together.
    pub layer: u32,
    /// The path that it follows or leads on from, by its place in the list.
    pub path: usize,
    /// Times of the knots, rising, in seconds.
    pub times: Vec<f64>,
    /// Joints at the knots.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::arrays"))]
    pub joints: Vec<[f64; N]>,
    /// The waypoints of the path that it passes, rising, and when, in seconds. Those between the first and the last are printed
    /// as well.
    pub waypoints: Vec<(usize, f64)>,
}

impl<const N: usize> WrittenMotion<N> {
    /// The waypoints of its path that it prints.
    pub fn printed(&self) -> Option<Range<usize>> {
        match (self.kind, self.waypoints.first(), self.waypoints.last()) {
            (SegmentKind::Print, Some(first), Some(last)) => Some(first.0..last.0.saturating_add(1)),
            _ => None,
        }
    }
}

/// The workcell with the part as it grows, for the check of a written print.
///
/// Answers must depend on the arguments and on the layer that was begun alone.
pub trait GrowingPrintScene<const N: usize>: Sync {
    /// A layer is being printed: it and those below are there from now on.
    ///
    /// # Errors
    /// Why it cannot be added, in words.
    fn begin(&mut self, layer: u32) -> Result<(), String>;

    /// The nozzle in the frame of what carries the part, z away from the tip; `None` where the joints have no pose.
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>>;

    /// How deep the nozzle is in what is built at some moment; `None` if it touches nothing that it must not touch.
    fn contact(&self, moment: Built, nozzle: &Waypoint) -> Option<Contact>;

    /// What may be touched on a cubic piece of a motion, given by its Bezier control polygon in joint space; `None` only if the
    /// piece is proven free. The nozzle may touch the part unless it `is_transfer`.
    fn sweep(&self, is_transfer: bool, control: &[[f64; N]; 4]) -> Option<String>;
}

/// Of which motion a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FindingPlace {
    /// What the motion is for.
    pub kind: SegmentKind,
    /// Its layer.
    pub layer: u32,
    /// Its path.
    pub path: usize,
}

/// What was found on a written print.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WrittenReport<const N: usize> {
    /// The findings and the extremes.
    pub print: PrintReport<N>,
    /// Where each of the findings is.
    pub places: Vec<FindingPlace>,
    /// Length of all paths, and of what the motions print of them, in millimetres.
    pub path_mm: f64,
    /// See `path_mm`.
    pub printed_mm: f64,
}

impl<const N: usize> WrittenReport<N> {
    /// How many motions have findings of a class.
    pub fn count(&self, class: FindingClass) -> usize {
        self.print.motions_with(|other| other == class).len()
    }
}

/// Checks the motions that were written to a file, with the part as it is built by then.
///
/// Motions along a path begin where the motion before ends, unless there was no travel to them. While a path is printed, while
/// the nozzle lifts off its end and while it comes down to its start, contact is asked by [`GrowingPrintScene::contact`];
/// transfers keep their distance from everything, which is looked at in sweeps.
///
/// # Arguments
/// * `motions`: in the order of time.
/// * `paths`: waypoints of all paths in the part's own frame, those that are not printed as well.
/// * `frame_part`: maps the part to the frame of what carries it.
/// * `scene`: before anything is built.
/// * `progress`: called before each layer, in units of motions; may stop the work.
///
/// # Errors
/// As of [`check_print`](super::check_print); [`CheckError::NoWaypoint`] for a motion along a path or to a waypoint that there is
/// not, and [`CheckError::Layer`] if the scene refuses a layer.
///
/// # Cost
/// That of [`check_print`](super::check_print), on all threads with the feature `rayon`; the same report on any number of them.
pub fn check_written<const N: usize>(
    motions: &[WrittenMotion<N>],
    paths: &[Vec<Waypoint>],
    frame_part: &Isometry3<f64>,
    bounds: &Bounds<N>,
    scene: &mut impl GrowingPrintScene<N>,
    options: &CheckOptions,
    progress: ProgressFn<'_>,
) -> Result<WrittenReport<N>, CheckError> {
    check_waypoints(motions, paths)?;
    let points: Vec<Vec<PathPoint>> = motions.iter().map(|motion| followed(motion, paths, frame_part)).collect();
    let mut reports: Vec<MotionReport<N>> = Vec::with_capacity(motions.len());
    for of_layer in motions.chunk_by(|a, b| a.layer == b.layer) {
        let (first, layer) = (reports.len(), of_layer[0].layer);
        let step = Progress { stage: "check motions", done: first as u64, total: motions.len() as u64 };
        if progress(step).is_break() {
            return Err(CheckError::Cancelled);
        }
        scene.begin(layer).map_err(|why| CheckError::Layer { layer, why })?;
        let scene = AtLayer { motions, scene: &*scene };
        let numbers: Vec<usize> = (first..first + of_layer.len()).collect();
        let one = |&number: &usize| {
            let motion = checked(motions, number, &points[number]);
            Ok::<_, Infallible>(check_motion(number, &motion, bounds, &scene, options))
        };
        // The error of the first motion that has one, on any number of threads.
        let Ok(found) = parallel::map(&numbers, one);
        for report in found {
            reports.push(report?);
        }
    }
    let print = PrintReport::of(&reports, options);
    let place = |motion: usize| {
        let WrittenMotion { kind, layer, path, .. } = motions[motion];
        FindingPlace { kind, layer, path }
    };
    let places = print.findings.iter().map(|finding| place(finding.motion)).collect();
    let path_mm = paths.iter().map(|path| length_mm(path)).sum();
    let printed = motions.iter().filter_map(|motion| Some(length_mm(&paths[motion.path][motion.printed()?])));
    Ok(WrittenReport { print, places, path_mm, printed_mm: printed.sum() })
}

fn check_waypoints<const N: usize>(motions: &[WrittenMotion<N>], paths: &[Vec<Waypoint>]) -> Result<(), CheckError> {
    for (number, motion) in motions.iter().enumerate() {
        let count = paths.get(motion.path).map(Vec::len);
        let printed = motion.printed().unwrap_or(0..0);
        if count.is_none_or(|count| printed.end > count || printed.start > printed.end) {
            let (path, waypoint) = (motion.path, printed.start.max(printed.end.saturating_sub(1)));
            return Err(CheckError::NoWaypoint { motion: number, path, waypoint });
        }
    }
    Ok(())
}

/// What a motion is to follow, over what carries the part.
fn followed<const N: usize>(
    motion: &WrittenMotion<N>,
    paths: &[Vec<Waypoint>],
    frame_part: &Isometry3<f64>,
) -> Vec<PathPoint> {
    let mut passed = motion.waypoints.iter().copied().peekable();
    let point = |waypoint: usize| {
        let Waypoint { position, axis } = paths[motion.path][waypoint].moved(frame_part);
        let passed_s = passed.next_if(|(passed, _)| *passed == waypoint).map(|(_, time)| time);
        PathPoint { position, axis, passed_s }
    };
    motion.printed().into_iter().flatten().map(point).collect()
}

fn checked<'a, const N: usize>(
    motions: &'a [WrittenMotion<N>],
    number: usize,
    path: &'a [PathPoint],
) -> CheckedMotion<'a, N> {
    let WrittenMotion { kind, times, joints, .. } = &motions[number];
    let is_print = *kind == SegmentKind::Print;
    let before = number.checked_sub(1).map(|before| motions[before].kind);
    // Nothing leads to the first one, and to one behind a transfer that was not found.
    let apart = is_print && before.is_none_or(|before| before == SegmentKind::Print);
    let kind = if is_print { MotionKind::Print } else { MotionKind::Travel };
    CheckedMotion { kind, times, joints, path, printing: None, apart }
}

fn length_mm(waypoints: &[Waypoint]) -> f64 {
    waypoints.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).sum()
}

/// What the checker of motions asks while a layer is printed.
struct AtLayer<'a, S, const N: usize> {
    motions: &'a [WrittenMotion<N>],
    scene: &'a S,
}

impl<S, const N: usize> AtLayer<'_, S, N> {
    /// What stands while the nozzle comes down: all of the path before, or of the path itself what is printed by then.
    fn before_approach(&self, motion: usize, path: usize) -> Built {
        let next = self.motions.get(motion + 1).filter(|next| next.path == path).and_then(WrittenMotion::printed);
        next.map_or(Built::After { path }, |printed| Built::At { path, waypoint: printed.start })
    }
}

impl<const N: usize, S: GrowingPrintScene<N>> PrintScene<N> for AtLayer<'_, S, N> {
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.scene.nozzle(joints)
    }

    fn contact(&self, moment: &Moment, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> Option<Contact> {
        let motion = &self.motions[moment.motion];
        let path = motion.path;
        let built = match motion.kind {
            SegmentKind::Print => Built::At { path, waypoint: motion.printed()?.start + moment.point },
            // What it has laid last was shaped by the nozzle itself.
            SegmentKind::Lift => {
                let printed = self.motions[..moment.motion].last().and_then(WrittenMotion::printed);
                Built::At { path, waypoint: printed?.end - 1 }
            }
            SegmentKind::Approach => self.before_approach(moment.motion, path),
            SegmentKind::Transfer => return None,
        };
        self.scene.contact(built, &Waypoint { position: *tip, axis: *axis })
    }

    fn sweep(&self, motion: usize, _: usize, control: &[[f64; N]; 4]) -> Option<String> {
        self.scene.sweep(self.motions[motion].kind == SegmentKind::Transfer, control)
    }
}
