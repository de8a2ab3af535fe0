//! What the checker reports.

use super::data::MotionKind;
use super::options::CheckOptions;
use crate::spline::Quantity;
use std::collections::BTreeSet;
use std::fmt;

/// The largest value of something, and where it occurs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrintPeak {
    /// The value, with its sign.
    pub value: f64,
    /// The motion, counted from 0.
    pub motion: usize,
    /// Seconds, as in [`super::CheckedMotion::times`].
    pub time: f64,
}

/// The largest rates of a joint, everywhere on the splines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointPeaks {
    /// In rad/s.
    pub velocity: PrintPeak,
    /// In rad/s^2.
    pub acceleration: PrintPeak,
    /// In rad/s^3; the time is that at which the piece begins.
    pub jerk: PrintPeak,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum FindingKind {
    /// A joint is beyond a limit; counted are pieces and joints.
    Limit {
        /// The joint, counted from 0.
        joint: usize,
        /// Of what: each is a finding of its own.
        what: Quantity,
        /// The value, with its sign.
        value: f64,
        /// The limit, with the sign of the side that is left.
        limit: f64,
    },
    /// The acceleration is not zero where the motion begins or ends at rest; counted are joints and ends.
    Jump {
        /// The joint, counted from 0.
        joint: usize,
        /// In rad/s^2.
        acceleration: f64,
    },
    /// The motion does not begin where the one before ends; counted are joints.
    Gap {
        /// The joint, counted from 0.
        joint: usize,
        /// How far apart, in radians.
        apart: f64,
    },
    /// The motion begins before the one before ends.
    Overlap {
        /// By how much.
        seconds: f64,
    },
    /// The tip is too far from the path; counted are samples.
    Deviation {
        /// In millimetres.
        distance_mm: f64,
    },
    /// The nozzle is tilted too far from the axis of the path; counted are samples.
    Tilt {
        /// In radians.
        angle: f64,
    },
    /// A path point is passed too far away, or never; counted are points.
    Skipped {
        /// The point, counted from 0.
        point: usize,
        /// How far the tip is from it when it passes, in millimetres; infinite if the nozzle has no pose on the path.
        #[cfg_attr(feature = "serde", serde(with = "crate::serial::limit"))]
        distance_mm: f64,
    },
    /// The nozzle is too deep in something; counted are samples.
    Contact {
        /// In millimetres.
        depth_mm: f64,
        /// What it touches.
        what: String,
    },
    /// A piece is not proven free; counted are pieces, the first is named.
    Collision {
        /// The piece, from knot `piece` to the next.
        piece: usize,
        /// What may be touched.
        what: String,
    },
    /// The joints have no pose of the nozzle; counted are samples, the first is named.
    OutOfReach,
}

/// Classes of findings, by what they mean for the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FindingClass {
    /// A joint is beyond a limit.
    Limits,
    /// The nozzle is off its path: the part suffers, and nothing is in danger.
    Deviations,
    /// The nozzle is in what is built.
    Contacts,
    /// The motion is not proven free.
    Collisions,
    /// The motion does not follow from the one before, or has no pose.
    Joins,
}

impl FindingClass {
    /// All of them.
    pub const ALL: [FindingClass; 5] = [
        FindingClass::Limits,
        FindingClass::Deviations,
        FindingClass::Contacts,
        FindingClass::Collisions,
        FindingClass::Joins,
    ];

    /// Whether a motion with such a finding should not be executed.
    pub fn is_unsafe(self) -> bool {
        self != FindingClass::Deviations
    }

    /// What is said of such a motion, in words.
    pub fn name(self) -> &'static str {
        match self {
            FindingClass::Limits => "beyond a limit",
            FindingClass::Deviations => "off the path",
            FindingClass::Contacts => "with the nozzle in what is built",
            FindingClass::Collisions => "not proven free",
            FindingClass::Joins => "not joined",
        }
    }
}

impl FindingKind {
    /// Its class.
    pub fn class(&self) -> FindingClass {
        match self {
            FindingKind::Limit { .. } => FindingClass::Limits,
            FindingKind::Deviation { .. } | FindingKind::Tilt { .. } | FindingKind::Skipped { .. } => {
                FindingClass::Deviations
            }
            FindingKind::Contact { .. } => FindingClass::Contacts,
            FindingKind::Collision { .. } => FindingClass::Collisions,
            FindingKind::Jump { .. }
            | FindingKind::Gap { .. }
            | FindingKind::Overlap { .. }
            | FindingKind::OutOfReach => FindingClass::Joins,
        }
    }
}

/// What is wrong with a motion: of each kind the worst, and how many there are.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding {
    /// The motion, counted from 0.
    pub motion: usize,
    /// When, in seconds, as in [`super::CheckedMotion::times`].
    pub time: f64,
    /// How many of this kind the motion has; [`FindingKind`] says what is counted.
    pub count: usize,
    /// The worst of them.
    pub kind: FindingKind,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "motion {} at {:.3} s: ", self.motion, self.time)?;
        match &self.kind {
            FindingKind::Limit { joint, what, value, limit } => {
                write!(f, "{what} of joint {} is {value:.6}, beyond its limit of {limit:.6}", joint + 1)?;
            }
            FindingKind::Jump { joint, acceleration } => {
                write!(f, "the acceleration of joint {} jumps by {acceleration:.6} rad/s^2 at rest", joint + 1)?;
            }
            FindingKind::Gap { joint, apart } => {
                write!(f, "joint {} begins {apart:.6} rad from where the motion before ends", joint + 1)?;
            }
            FindingKind::Overlap { seconds } => write!(f, "begins {seconds:.6} s before the motion before ends")?,
            FindingKind::Deviation { distance_mm } => write!(f, "the tip is {distance_mm:.3} mm from the path")?,
            FindingKind::Tilt { angle } => write!(f, "the nozzle is {angle:.4} rad from the axis of the path")?,
            FindingKind::Skipped { point, distance_mm } => {
                write!(f, "path point {point} is missed by {distance_mm:.3} mm")?;
            }
            FindingKind::Contact { depth_mm, what } => write!(f, "the nozzle is {depth_mm:.3} mm deep in {what}")?,
            FindingKind::Collision { piece, what } => write!(f, "piece {piece} may touch {what}")?,
            FindingKind::OutOfReach => write!(f, "the joints have no pose of the nozzle")?,
        }
        if self.count > 1 { write!(f, " ({} of this kind)", self.count) } else { Ok(()) }
    }
}

/// What was found on one motion by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionReport<const N: usize> {
    /// Its number.
    pub motion: usize,
    /// What it is for.
    pub kind: MotionKind,
    /// As [`super::CheckedMotion::apart`].
    pub apart: bool,
    /// When it begins and ends.
    pub span: [f64; 2],
    /// Joints where it begins and ends.
    pub ends: [[f64; N]; 2],
    /// What is wrong, in the order of time.
    pub findings: Vec<Finding>,
    /// The largest rates of each joint.
    pub joints: [JointPeaks; N],
    /// The largest distance of the tip from the path, in millimetres; `None` if there was none to be followed.
    pub deviation: Option<PrintPeak>,
    /// The largest angle between nozzle and axis of the path.
    pub tilt: Option<PrintPeak>,
    /// The deepest contact, in millimetres; `None` if there was none.
    pub depth: Option<PrintPeak>,
    /// For how long an acceleration is above its limit.
    pub seconds_over_acceleration: f64,
    /// For how long a jerk is above its limit.
    pub seconds_over_jerk: f64,
    /// Pieces of the spline, each asked about by [`super::PrintScene::sweep`].
    pub pieces: usize,
    /// Postures looked at.
    pub samples: usize,
}

/// What was found on a whole print.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrintReport<const N: usize> {
    /// What is wrong, motion by motion; empty for a sound print.
    pub findings: Vec<Finding>,
    /// Motions that do not begin where the one before ends, declared ([`super::CheckedMotion::apart`]) or not.
    pub gaps: Vec<usize>,
    /// The largest rates of each joint.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub joints: [JointPeaks; N],
    /// The largest distance of a tip from its path, in millimetres; `None` if there was no path.
    pub deviation: Option<PrintPeak>,
    /// The largest angle between nozzle and axis of its path.
    pub tilt: Option<PrintPeak>,
    /// The deepest contact, in millimetres; `None` if there was none.
    pub depth: Option<PrintPeak>,
    /// Time of all motions; waits between them are not counted.
    pub seconds: f64,
    /// For how long an acceleration is above its limit.
    pub seconds_over_acceleration: f64,
    /// For how long a jerk is above its limit.
    pub seconds_over_jerk: f64,
    /// Motions.
    pub motions: usize,
    /// Pieces of all splines.
    pub pieces: usize,
    /// Postures looked at.
    pub samples: usize,
}

impl<const N: usize> PrintReport<N> {
    /// Puts the reports of all motions together, in the order of the print, and checks how they join.
    ///
    /// # Cost
    /// Linear in the motions. Does not depend on how the reports were made.
    pub fn of(reports: &[MotionReport<N>], options: &CheckOptions) -> Self {
        let mut all = PrintReport {
            findings: vec![],
            gaps: vec![],
            joints: [JointPeaks::default(); N],
            deviation: None,
            tilt: None,
            depth: None,
            seconds: 0.0,
            seconds_over_acceleration: 0.0,
            seconds_over_jerk: 0.0,
            motions: reports.len(),
            pieces: 0,
            samples: 0,
        };
        let mut before: Option<&MotionReport<N>> = None;
        for report in reports {
            if let Some(before) = before {
                all.join(before, report, options);
            }
            before = Some(report);
            all.findings.extend_from_slice(&report.findings);
            for (peaks, new) in all.joints.iter_mut().zip(&report.joints) {
                raise(&mut peaks.velocity, new.velocity);
                raise(&mut peaks.acceleration, new.acceleration);
                raise(&mut peaks.jerk, new.jerk);
            }
            let maxima =
                [(&mut all.deviation, report.deviation), (&mut all.tilt, report.tilt), (&mut all.depth, report.depth)];
            for (peak, new) in maxima {
                new.into_iter().for_each(|new| raise_some(peak, new));
            }
            all.seconds += report.span[1] - report.span[0];
            all.seconds_over_acceleration += report.seconds_over_acceleration;
            all.seconds_over_jerk += report.seconds_over_jerk;
            all.pieces += report.pieces;
            all.samples += report.samples;
        }
        all
    }

    fn join(&mut self, before: &MotionReport<N>, report: &MotionReport<N>, options: &CheckOptions) {
        let (motion, time) = (report.motion, report.span[0]);
        let (mut worst, mut count) = ((0, 0.0), 0);
        for joint in 0..N {
            let apart = (report.ends[0][joint] - before.ends[1][joint]).abs();
            if apart > options.max_gap {
                count += 1;
                if apart > worst.1 {
                    worst = (joint, apart);
                }
            }
        }
        if count > 0 {
            self.gaps.push(motion);
            if !report.apart {
                let (joint, apart) = worst;
                self.findings.push(Finding { motion, time, count, kind: FindingKind::Gap { joint, apart } });
            }
        }
        let seconds = before.span[1] - time;
        if seconds > options.max_overlap_s {
            self.findings.push(Finding { motion, time, count: 1, kind: FindingKind::Overlap { seconds } });
        }
    }

    /// Whether nothing is wrong.
    pub fn is_ok(&self) -> bool {
        self.findings.is_empty()
    }

    /// The motions with a finding of a class that is asked for.
    pub fn motions_with(&self, class: impl Fn(FindingClass) -> bool) -> BTreeSet<usize> {
        self.findings.iter().filter(|finding| class(finding.kind.class())).map(|finding| finding.motion).collect()
    }

    /// Share of the time with an acceleration above its limit, 0 to 1.
    pub fn share_over_acceleration(&self) -> f64 {
        if self.seconds > 0.0 { self.seconds_over_acceleration / self.seconds } else { 0.0 }
    }

    /// Share of the time with a jerk above its limit, 0 to 1.
    pub fn share_over_jerk(&self) -> f64 {
        if self.seconds > 0.0 { self.seconds_over_jerk / self.seconds } else { 0.0 }
    }
}

/// Of two peaks the one farther from zero; of equal ones the earlier.
pub(super) fn raise(peak: &mut PrintPeak, new: PrintPeak) {
    if new.value.abs() > peak.value.abs() {
        *peak = new;
    }
}

pub(super) fn raise_some(peak: &mut Option<PrintPeak>, new: PrintPeak) {
    raise(peak.get_or_insert(new), new);
}

/// Findings of one motion: the worst of each kind, and how many.
#[derive(Default)]
pub(super) struct Findings {
    worst: Vec<(f64, Finding)>,
}

impl Findings {
    /// `badness` compares findings of one kind; of equal ones the first stays.
    pub fn add(&mut self, badness: f64, motion: usize, time: f64, kind: FindingKind) {
        let found = self.worst.iter_mut().find(|(_, finding)| same(&finding.kind, &kind));
        if let Some((worst, finding)) = found {
            finding.count += 1;
            if badness > *worst {
                *worst = badness;
                (finding.time, finding.kind) = (time, kind);
            }
        } else {
            self.worst.push((badness, Finding { motion, time, count: 1, kind }));
        }
    }

    pub fn in_order(self) -> Vec<Finding> {
        let mut all: Vec<Finding> = self.worst.into_iter().map(|(_, finding)| finding).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all
    }
}

fn same(a: &FindingKind, b: &FindingKind) -> bool {
    match (a, b) {
        (FindingKind::Limit { what: a, .. }, FindingKind::Limit { what: b, .. }) => a == b,
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}
