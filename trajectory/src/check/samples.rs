//! Deviation and contact, at samples as dense as the nozzle moves; sweeps, piece by piece.

use super::curve::Curve;
use super::follow::{Follower, angle};
use super::report::{Findings, raise_some};
use super::{CheckOptions, CheckedMotion, FindingKind, Moment, MotionKind, PrintPeak, PrintScene};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Samples are put between two others at most so often, counted from a piece of one part: a piece is cut into a million parts where a nozzle
/// jumps, and into no more where joints go far as well.
const MAX_HALVINGS: u32 = 20;

/// No joint moves farther between two samples, in radians, however little the nozzle does: a nozzle that goes there and
/// back between two samples is not seen. Small values cost samples on travels.
const MAX_JOINT_STEP: f64 = 0.2;

/// The least number of parts of a piece.
const MIN_PARTS: usize = 2;

/// Most parts that a piece begins with, before halving.
const MAX_PARTS: f64 = 1e6;

pub(super) struct Followed {
    pub deviation: Option<PrintPeak>,
    pub tilt: Option<PrintPeak>,
    pub depth: Option<PrintPeak>,
    pub samples: usize,
}

#[derive(Clone, Copy)]
struct Sample {
    time: f64,
    nozzle: Option<(Point3<f64>, UnitVector3<f64>)>,
}

/// The walk along one motion.
struct Walk<'a, const N: usize, S: ?Sized> {
    motion: usize,
    curve: &'a Curve<'a, N>,
    scene: &'a S,
    options: &'a CheckOptions,
    findings: &'a mut Findings,
    /// While the path is to be followed.
    printing: Option<[f64; 2]>,
    follower: Follower<'a>,
    followed: Followed,
    last_printed: f64,
}

pub(super) fn check<const N: usize>(
    motion: usize,
    checked: &CheckedMotion<N>,
    curve: &Curve<N>,
    scene: &(impl PrintScene<N> + ?Sized),
    options: &CheckOptions,
    findings: &mut Findings,
) -> Followed {
    let [begin, end] = checked.span();
    let printing = (checked.kind == MotionKind::Print).then(|| checked.printing.unwrap_or([begin, end]));
    let mut walk = Walk {
        motion,
        curve,
        scene,
        options,
        findings,
        printing,
        follower: Follower::new(checked.path),
        followed: Followed { deviation: None, tilt: None, depth: None, samples: 0 },
        last_printed: end,
    };
    let mut before = walk.sample(0, begin);
    walk.take(&before);
    for piece in 0..curve.pieces() {
        let control = curve.control(piece);
        let (from, to) = (curve.times[piece], curve.times[piece + 1]);
        if let Some(what) = scene.sweep(motion, piece, &control) {
            walk.findings.add(0.0, motion, from, FindingKind::Collision { piece, what });
        }
        let mut cuts = [from, to, to, to];
        for (cut, time) in cuts[1..3].iter_mut().zip(printing.unwrap_or([to; 2])) {
            *cut = time.clamp(from, to);
        }
        let parts = parts(&control);
        for ends in cuts.windows(2).filter(|ends| ends[0] < ends[1]) {
            for part in 1..=parts {
                let share = part as f64 / parts as f64;
                let time = if part == parts { ends[1] } else { ends[0] + (ends[1] - ends[0]) * share };
                let next = walk.sample(piece, time);
                walk.between(piece, before, next, parts.ilog2());
                before = next;
            }
        }
    }
    let (mut missed, last_printed) = (vec![], walk.last_printed);
    if printing.is_some() {
        walk.follower.finish(|point, distance_mm| missed.push((point, distance_mm)));
    }
    missed.into_iter().for_each(|(point, distance_mm)| walk.pass(last_printed, point, distance_mm));
    walk.followed
}

/// Into how many parts of equal time a piece is cut: by its control polygon no joint moves farther than allowed in one.
fn parts<const N: usize>(control: &[[f64; N]; 4]) -> usize {
    let steps = control.windows(2).flat_map(|ends| (0..N).map(|j| (ends[1][j] - ends[0][j]).abs()));
    let most = (3.0 * steps.fold(0.0, f64::max) / MAX_JOINT_STEP).ceil().min(MAX_PARTS);
    MIN_PARTS.max(most as usize)
}

impl<const N: usize, S: PrintScene<N> + ?Sized> Walk<'_, N, S> {
    fn sample(&mut self, piece: usize, time: f64) -> Sample {
        self.followed.samples += 1;
        let pose = self.scene.nozzle(&self.curve.at(piece, time));
        let nozzle = pose.and_then(|pose| {
            let tip = Point3::from(pose.translation.vector);
            let axis = UnitVector3::try_new(pose.rotation * Vector3::z(), 0.0)?;
            tip.iter().chain(axis.iter()).all(|x| x.is_finite()).then_some((tip, axis))
        });
        Sample { time, nozzle }
    }

    /// Takes all samples after `from` up to `to`.
    fn between(&mut self, piece: usize, from: Sample, to: Sample, halvings: u32) {
        if halvings < MAX_HALVINGS && self.coarse(&from, &to) {
            let middle = 0.5 * (from.time + to.time);
            if from.time < middle && middle < to.time {
                let middle = self.sample(piece, middle);
                self.between(piece, from, middle, halvings + 1);
                self.between(piece, middle, to, halvings + 1);
                return;
            }
        }
        self.take(&to);
    }

    fn coarse(&self, a: &Sample, b: &Sample) -> bool {
        let (Some((a, a_axis)), Some((b, b_axis))) = (&a.nozzle, &b.nozzle) else { return false };
        (b - a).norm() > self.options.sample_mm || angle(a_axis, b_axis) > self.options.sample_rad
    }

    fn take(&mut self, sample: &Sample) {
        let (motion, time) = (self.motion, sample.time);
        let peak = |value| PrintPeak { value, motion, time };
        let Some((tip, axis)) = &sample.nozzle else {
            self.findings.add(0.0, motion, time, FindingKind::OutOfReach);
            return;
        };
        let printing = self.printing.is_some_and(|[begin, end]| begin <= time && time <= end);
        if printing {
            self.last_printed = time;
            let mut passed = vec![];
            let (distance_mm, angle) =
                self.follower.go(time, tip, axis, self.options, |point, by| passed.push((point, by)));
            passed.into_iter().for_each(|(point, by)| self.pass(time, point, by));
            raise_some(&mut self.followed.deviation, peak(distance_mm));
            raise_some(&mut self.followed.tilt, peak(angle));
            if distance_mm > self.options.max_deviation_mm {
                self.findings.add(distance_mm, motion, time, FindingKind::Deviation { distance_mm });
            }
            if angle > self.options.max_angle {
                self.findings.add(angle, motion, time, FindingKind::Tilt { angle });
            }
        }
        let Follower { segment: point, share, .. } = self.follower;
        let moment = Moment { motion, time, printing, point, share };
        if let Some(contact) = self.scene.contact(&moment, tip, axis) {
            // What is not a number is no proof of anything.
            let depth_mm = if contact.depth_mm.is_nan() { f64::INFINITY } else { contact.depth_mm };
            raise_depth(&mut self.followed.depth, peak(depth_mm));
            if depth_mm > self.options.max_depth_mm {
                self.findings.add(depth_mm, motion, time, FindingKind::Contact { depth_mm, what: contact.what });
            }
        }
    }

    fn pass(&mut self, time: f64, point: usize, distance_mm: f64) {
        if distance_mm > self.options.max_deviation_mm {
            self.findings.add(distance_mm, self.motion, time, FindingKind::Skipped { point, distance_mm });
        }
    }
}

/// The deeper one; negative depths are clearances.
fn raise_depth(depth: &mut Option<PrintPeak>, new: PrintPeak) {
    if depth.is_none_or(|depth| new.value > depth.value) {
        *depth = Some(new);
    }
}
