//! A print on a dome in the robot's hand under a fixed nozzle: from strokes on the surface to the steps of a program.
//!
//! B. Brooks (2016), sections 4.13 to 4.15. Poses are those of [`DomeRig`]: of the flange in the robot's base, for RAPID's `tool0`
//! and `wobj0`. [`choose_turns`] keeps axis 6 within its range, so that the return home after each stroke (section 5.2.2) is not
//! needed; every pose is solved by the inverse kinematics, joints next to the ones before.
//!
//! Departs from the thesis: configuration data are computed, not fixed; the speed of a move is such that the nozzle goes evenly over
//! the platform, while the flange, to which RAPID's speed refers, may hardly move ([`run_on_dome`](super::run_on_dome) verifies it from
//! the program); the way to the next stroke is by joints.

use super::rig::DomeRig;
use super::turns::{TurnChoice, TurnError, TurnPath, choose_turns};
use crate::arm::Arm;
use crate::program::{ConfData, Goal, Move, Speed, Step, Target, Zone};
use nalgebra::{Isometry3, Point3, UnitVector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

/// A stroke on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct DomeStroke {
    /// Points in the platform's frame, with normals. Of a closed stroke the first comes again at the end.
    pub points: Vec<(Point3<f64>, UnitVector3<f64>)>,
    /// Whether it returns to its begin, so that it may begin elsewhere.
    pub closed: bool,
    /// Speed of the filament, or of the extruder, while it is printed: what the program writes as its output.
    pub feed: f64,
    /// How far the nozzle is above the surface, in millimetres. 0.2 for the thesis' fill, over its outlines.
    pub above: f64,
}

/// How a print on a dome is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomeOptions {
    /// Speed of the nozzle over the platform, mm/s. Default 20.
    pub print_mm_s: f64,
    /// Speed down to a stroke and up from it, mm/s. Default 10.
    pub plunge_mm_s: f64,
    /// Added to the turn that brings a point into the robot's YZ plane, in radians. 0: section 4.15, where the point is on the side
    /// of -y and the platform tilts away. There an IRB 120 at the thesis' home reaches no point beyond a radius of 78 mm of the
    /// thesis' dome without going through a straight wrist. Default pi: the other side, where it reaches all.
    pub added_turn: f64,
    /// Nearer to the pole, in millimetres, the platform turns evenly. Default 5.
    pub pole_mm: f64,
    /// How far the platform goes down from the nozzle between two strokes, in millimetres. Default 30.
    pub hop_mm: f64,
    /// Added to the height of the nozzle over the surface, in millimetres. Default 0.
    pub nozzle_mm: f64,
    /// How corners within a stroke are rounded, in millimetres of the flange's way. Default 0.3.
    pub corner_mm: f64,
}

impl Default for DomeOptions {
    fn default() -> Self {
        DomeOptions {
            print_mm_s: 20.0,
            plunge_mm_s: 10.0,
            added_turn: PI,
            pole_mm: 5.0,
            hop_mm: 30.0,
            nozzle_mm: 0.0,
            corner_mm: 0.3,
        }
    }
}

/// A stroke as the robot prints it.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedStroke {
    /// Which of the strokes, from 0; a stroke may be printed in parts.
    pub stroke: usize,
    /// Poses of the flange in the base.
    pub poses: Vec<Isometry3<f64>>,
    /// Joints at each of them.
    pub joints: Vec<[f64; 6]>,
    /// Configuration data of those joints. A joint within 1e-4 rad of the border of a quarter turn stays in the quarter turn of the point before.
    pub confs: Vec<ConfData>,
    /// Joints below the begin and the end, with the platform down from the nozzle.
    pub below: [[f64; 6]; 2],
    /// How far the nozzle goes over the platform to each point, in millimetres.
    pub lengths: Vec<f64>,
    /// Speed of the filament.
    pub feed: f64,
}

/// A planned print.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DomePrint {
    /// Joints with the pole under the nozzle, in the posture of the print.
    pub home: [f64; 6],
    /// The strokes that can be printed.
    pub strokes: Vec<PrintedStroke>,
    /// Those that cannot.
    pub faults: Vec<DomeFault>,
    /// How often a stroke was stopped because axis 6 would leave its range.
    pub splits: usize,
    /// Points that are inserted because the nozzle would not go evenly from one point to the next.
    pub inserted: usize,
    /// Points that are left out because the nozzle would be there within a millisecond of the point before.
    pub merged: usize,
    /// The least and the largest angle of axis 6, in radians.
    pub axis6: [f64; 2],
    /// How far axis 6 turns between strokes in all, in radians.
    pub travel: f64,
}

/// Why a stroke cannot be printed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DomeFault {
    /// Axis 6 would leave its range.
    #[error("stroke {stroke}: axis 6 would have to turn over {span_deg:.0} degrees, more than its range")]
    Turns {
        /// The stroke, from 0.
        stroke: usize,
        /// In degrees.
        span_deg: f64,
    },
    /// A point is out of reach.
    #[error("stroke {stroke}: the robot cannot bring point {point} at ({x:.1}, {y:.1}, {z:.1}) to the nozzle")]
    Reach {
        /// The stroke, from 0.
        stroke: usize,
        /// The point, from 0, or the way to it.
        point: usize,
        /// The point.
        x: f64,
        /// The point.
        y: f64,
        /// The point.
        z: f64,
    },
}

impl DomeFault {
    /// The stroke.
    pub fn stroke(&self) -> usize {
        match self {
            DomeFault::Turns { stroke, .. } | DomeFault::Reach { stroke, .. } => *stroke,
        }
    }
}

/// Plans a print: turns, poses and joints of every stroke, with the arm in one of the postures in which it holds the pole of the
/// platform under the nozzle. A stroke that turns farther than axis 6 can is printed in parts. The first of the postures in which all is within reach is taken, else the one with the fewest faults.
///
/// # Returns
/// What can be printed, and what cannot with the reason: numbers that are not finite are out of reach.
///
/// # Cost
/// About two microseconds a point, for each posture that does not reach all.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
/// use curvlay_kinematics::program::{DomeOptions, DomeRig, DomeStroke, print_on_dome};
/// use curvlay_kinematics::{Arm, robots};
/// let arm = Arm::new(&robots::IRB120)?;
/// // A ring around the pole of a dome of radius 150, three times.
/// let at = |k: u32| {
///     let a = f64::from(k).to_radians();
///     let normal = UnitVector3::new_normalize(Vector3::new(0.4 * a.cos(), 0.4 * a.sin(), 0.9));
///     (Point3::from(normal.into_inner() * 150.0), normal)
/// };
/// let ring = DomeStroke { points: (0..=360).map(at).collect(), closed: true, feed: 1.0, above: 0.0 };
/// let print = print_on_dome(&DomeRig::BROOKS, &arm, &[ring.clone(), ring.clone(), ring], &DomeOptions::default());
/// assert!(print.faults.is_empty() && print.strokes.len() == 3);
/// assert!((print.axis6[1] - print.axis6[0]).to_degrees() < 370.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn print_on_dome(rig: &DomeRig, arm: &Arm, strokes: &[DomeStroke], options: &DomeOptions) -> DomePrint {
    let pole = rig.target(0.0, rig.top, 0.0, 0.0);
    let homes = arm.inverse(&pole).unwrap_or_default();
    let mut homes: Vec<[f64; 6]> =
        homes.iter().map(|(_, joints)| *joints).filter(|joints| arm.limits().contains(joints)).collect();
    // Least turned first.
    let turned = |joints: &[f64; 6]| joints.iter().map(|joint| joint.abs()).sum::<f64>();
    homes.sort_by(|a, b| turned(a).total_cmp(&turned(b)));
    let mut best: Option<DomePrint> = None;
    for home in homes {
        let print = from_home(rig, arm, &home, strokes, options);
        if best.as_ref().is_none_or(|best| print.faults.len() < best.faults.len()) {
            best = Some(print);
        }
        if best.as_ref().is_some_and(|best| best.faults.is_empty()) {
            break;
        }
    }
    best.unwrap_or_else(|| {
        let fault = |(stroke, of): (usize, &DomeStroke)| {
            let at = of.points.first().map_or_else(Point3::origin, |(at, _)| *at);
            DomeFault::Reach { stroke, point: 0, x: at.x, y: at.y, z: at.z }
        };
        DomePrint { faults: strokes.iter().enumerate().map(fault).collect(), ..DomePrint::default() }
    })
}

/// The print that begins at a home posture. A stroke that turns too far is divided into parts that do not; what cannot be printed is a fault.
fn from_home(rig: &DomeRig, arm: &Arm, home: &[f64; 6], strokes: &[DomeStroke], options: &DomeOptions) -> DomePrint {
    // The last piece comes first.
    let mut waiting: Vec<Piece> = strokes.iter().enumerate().rev().map(|of| Piece::of(rig, of, options)).collect();
    let mut printer = Printer::at_home(rig, arm, home, options);
    printer.print.inserted = waiting.iter().map(|piece| piece.points.len() - piece.stroke.points.len()).sum();
    let [low, high] = printer.range;
    while let Some(piece) = waiting.pop() {
        let path = TurnPath { turns: &piece.turns, closed: piece.closed };
        match choose_turns(&[path], printer.range, printer.turn) {
            Ok(choices) => printer.lay(&piece, &choices[0]),
            Err(_) if piece.whole && piece.turns.iter().all(|turn| turn.is_finite()) => {
                let parts = piece.parts(high - low - TAU);
                printer.print.splits += parts.len() - 1;
                waiting.extend(parts.into_iter().rev());
            }
            Err(TurnError { span, .. }) => {
                printer.print.faults.push(DomeFault::Turns { stroke: piece.number, span_deg: span.to_degrees() });
            }
        }
    }
    printer.print
}

/// A print as it grows, and where the arm is behind its last stroke.
struct Printer<'a> {
    rig: &'a DomeRig,
    arm: &'a Arm,
    options: &'a DomeOptions,
    print: DomePrint,
    /// What joint 6 is beyond the turn: with the arm in the YZ plane a constant.
    constant: f64,
    /// The turns that joint 6 allows, in radians.
    range: [f64; 2],
    /// The joints behind the last stroke, and their turn.
    previous: [f64; 6],
    turn: f64,
}

impl<'a> Printer<'a> {
    /// At home nothing is turned.
    fn at_home(rig: &'a DomeRig, arm: &'a Arm, home: &[f64; 6], options: &'a DomeOptions) -> Self {
        let constant = home[5];
        let range = [arm.limits().lower[5] - constant, arm.limits().upper[5] - constant];
        let print = DomePrint { axis6: [home[5]; 2], home: *home, ..DomePrint::default() };
        Printer { rig, arm, options, print, constant, range, previous: *home, turn: 0.0 }
    }

    /// Prints a piece in the order and with the whole turns of a choice, or notes the point that is out of reach.
    fn lay(&mut self, piece: &Piece, choice: &TurnChoice) {
        let Printer { rig, arm, options, .. } = *self;
        let (points, turns) = (choice.ordered(&piece.points), choice.turned(&piece.turns));
        let above = piece.stroke.above + options.nozzle_mm;
        // Where the tip is.
        let tips: Vec<Point3<f64>> = points.iter().map(|place| place.at + place.normal.into_inner() * above).collect();
        let posed = tips.iter().zip(&points).zip(&turns);
        let poses: Vec<Isometry3<f64>> =
            posed.map(|((tip, place), turn)| rig.target_on(tip, &place.normal, *turn)).collect();
        match follow(arm, &self.previous, &poses, options.hop_mm, self.constant, &turns) {
            Ok(followed) => {
                self.turn = turns.last().copied().unwrap_or(self.turn);
                self.print.travel += choice.travel.abs();
                self.keep(piece, &tips, &poses, followed);
            }
            Err(point) => {
                let point = points.get(point).map_or(point, |place| place.point);
                let at = piece.stroke.points.get(point).map_or_else(Point3::origin, |(at, _)| *at);
                self.print.faults.push(DomeFault::Reach { stroke: piece.number, point, x: at.x, y: at.y, z: at.z });
            }
        }
    }

    /// Adds a stroke that the arm follows, without the points that come too soon after the one before.
    fn keep(&mut self, piece: &Piece, tips: &[Point3<f64>], poses: &[Isometry3<f64>], (joints, below): Followed) {
        let kept = spaced(tips, self.options.print_mm_s * MIN_SECONDS);
        self.print.merged += tips.len() - kept.len();
        let poses = kept.iter().map(|&k| poses[k]).collect();
        let joints: Vec<[f64; 6]> = kept.iter().map(|&k| joints[k]).collect();
        let mut along = 0.0;
        let steps = (0..kept.len()).map(|k| {
            along += if k > 0 { (tips[kept[k]] - tips[kept[k - 1]]).norm() } else { 0.0 };
            along
        });
        let lengths = steps.collect();
        for joints in joints.iter().chain(&below) {
            self.print.axis6 = [self.print.axis6[0].min(joints[5]), self.print.axis6[1].max(joints[5])];
        }
        self.previous = below[1];
        let confs = quarters(self.arm, &joints);
        let (stroke, feed) = (piece.number, piece.stroke.feed);
        self.print.strokes.push(PrintedStroke { stroke, poses, joints, confs, below, lengths, feed });
    }
}

/// A stroke, or a part of one that turns too far.
struct Piece<'a> {
    number: usize,
    stroke: &'a DomeStroke,
    points: Vec<Place>,
    turns: Vec<f64>,
    closed: bool,
    whole: bool,
}

impl<'a> Piece<'a> {
    /// Parts of it whose turns stay within a span; none is divided once more.
    fn parts(&self, span: f64) -> Vec<Self> {
        let part = |part: Range<usize>| {
            let (points, turns) = (self.points[part.clone()].to_vec(), self.turns[part].to_vec());
            Piece { points, turns, closed: false, whole: false, ..*self }
        };
        within_span(&self.turns, span).into_iter().map(part).collect()
    }

    fn of(rig: &DomeRig, (number, stroke): (usize, &'a DomeStroke), options: &DomeOptions) -> Self {
        let places: Vec<Point3<f64>> = stroke.points.iter().map(|(at, _)| *at).collect();
        let given = DomeRig::turns(&places, options.pole_mm);
        let (mut points, mut turns): (Vec<Place>, Vec<f64>) = (Vec::new(), Vec::new());
        for (point, &(at, normal)) in stroke.points.iter().enumerate() {
            let turn = given[point] + options.added_turn;
            if let Some((from, last)) = points.last().copied().zip(turns.last().copied()) {
                let above = stroke.above + options.nozzle_mm;
                let ends = [(from.at, from.normal, last), (at, normal, turn)];
                let poses = ends.map(|(at, normal, turn)| rig.target_on(&(at + *normal * above), &normal, turn));
                let parts = parts(rig, &poses, options.print_mm_s * MIN_SECONDS);
                for k in (1..MAX_PARTS).take_while(|k| f64::from(*k) < parts) {
                    let share = f64::from(k) / parts;
                    let normal = UnitVector3::new_normalize(from.normal.lerp(&normal, share));
                    points.push(Place { at: from.at + (at - from.at) * share, normal, point });
                    turns.push(last + (turn - last) * share);
                }
            }
            points.push(Place { at, normal, point });
            turns.push(turn);
        }
        Piece { number, stroke, points, turns, closed: stroke.closed, whole: true }
    }
}

/// A point of a stroke, or one between it and the point before.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Point3<f64>,
    normal: UnitVector3<f64>,
    /// Which of the points of the stroke, from 0.
    point: usize,
}

/// The speed of the nozzle over the platform differs by at most so much within a move, as a share. Between targets the flange goes straight
/// where it should go along an arc, so the nozzle is slower at one end than at the other: by 2.4 % on a line of 1 mm through the pole, and by
/// half of it on half of the way. More would be seen by the check of 2 %; less makes longer programs.
const UNEVEN: f64 = 0.01;
/// A move is divided into so many at most.
const MAX_PARTS: u32 = 32;

/// Into how many parts a move has to be divided so that the nozzle goes evenly on each of them; none shorter than `least`. NaN for invalid poses.
fn parts(rig: &DomeRig, [from, to]: &[Isometry3<f64>; 2], least: f64) -> f64 {
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    let way = to.translation.vector - from.translation.vector;
    let contact = rig.contact().coords;
    // Of a point of the platform that is at the nozzle, as the move begins and ends.
    let [begin, end] = [from, to].map(|pose| (way + turn.cross(&(contact - pose.translation.vector))).norm());
    let tip = |pose: &Isometry3<f64>| pose.inverse_transform_point(&rig.contact());
    let length = (tip(to) - tip(from)).norm();
    let off = (begin - length).abs().max((end - length).abs());
    (off / (UNEVEN * length)).ceil().min((length / least).floor()).clamp(1.0, f64::from(MAX_PARTS))
}

/// Parts of a path, each as long as its angles stay within a span; neighbours have a point together.
fn within_span(turns: &[f64], span: f64) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let (mut begin, mut low, mut high) = (0, f64::INFINITY, f64::NEG_INFINITY);
    for (k, &turn) in turns.iter().enumerate() {
        (low, high) = (low.min(turn), high.max(turn));
        if high - low > span && k > begin + 1 {
            parts.push(begin..k);
            begin = k - 1;
            (low, high) = (turn.min(turns[begin]), turn.max(turns[begin]));
        }
    }
    parts.push(begin..turns.len());
    parts
}

/// The points of a path that are at least so far from the one before; the first and the last always.
fn spaced(tips: &[Point3<f64>], least: f64) -> Vec<usize> {
    let mut kept = vec![0];
    for k in 1..tips.len() {
        let far = |from: usize| (tips[k] - tips[from]).norm() >= least;
        if kept.last().is_some_and(|&from| far(from)) {
            kept.push(k);
        } else if k + 1 == tips.len() {
            // The last takes the place of the one before, unless that is the first.
            kept.truncate(kept.len().max(2) - 1);
            kept.push(k);
        }
    }
    kept
}

/// A joint this near the border of a quarter turn, in radians, counts to the quarter turn of the point before. The arm stands in its YZ plane
/// while it prints on a surface of revolution, so joint 1 is at -90 or 90 degrees and joint 4 at 0: rounding would decide, at
/// each point anew. Quaternions of a program have eight digits, which give joints to about 1e-7; beyond 1e-3 a controller that compares
/// configuration data with its joints could see another quarter turn.
const BORDER: f64 = 1e-4;

/// Configuration data along a path.
fn quarters(arm: &Arm, joints: &[[f64; 6]]) -> Vec<ConfData> {
    let mut before: Option<ConfData> = None;
    let follow = |joints: &[f64; 6]| {
        let mut conf = ConfData::of(arm, joints);
        if let Some(before) = before {
            let steady = |now: &mut i32, last: i32, joint: usize| {
                let begin = f64::from(last) * FRAC_PI_2;
                if (begin - BORDER..=begin + FRAC_PI_2 + BORDER).contains(&joints[joint]) {
                    *now = last;
                }
            };
            steady(&mut conf.cf1, before.cf1, 0);
            steady(&mut conf.cf4, before.cf4, 3);
            steady(&mut conf.cf6, before.cf6, 5);
        }
        before = Some(conf);
        conf
    };
    joints.iter().map(follow).collect()
}

/// Joints 1 to 5 may change by so much from one point of a path to the next, in radians; more is another posture, through which no
/// straight move leads.
const SAME_POSTURE: f64 = 0.3;

/// Joints along a path, and below its begin and end.
type Followed = (Vec<[f64; 6]>, [[f64; 6]; 2]);

/// Joints along poses, and below the first and the last of them; or the first that is out of reach.
fn follow(
    arm: &Arm,
    previous: &[f64; 6],
    poses: &[Isometry3<f64>],
    hop: f64,
    constant: f64,
    turns: &[f64],
) -> Result<Followed, usize> {
    let down = |pose: &Isometry3<f64>| {
        let mut pose = *pose;
        pose.translation.z -= hop;
        pose
    };
    let (first, last) = poses.first().zip(poses.last()).ok_or(0usize)?;
    // The turn says which whole turn of axis 6 is meant.
    let next = |pose: &Isometry3<f64>, near: &[f64; 6], turn: f64| {
        let mut near = *near;
        near[5] = turn + constant;
        arm.continuing(pose, &near)
    };
    let same = |a: &[f64; 6], b: &[f64; 6]| (0..5).all(|joint| (a[joint] - b[joint]).abs() <= SAME_POSTURE);
    let branch = arm.branch(previous);
    let begin = next(&down(first), previous, turns[0]).filter(|joints| arm.branch(joints) == branch).ok_or(0usize)?;
    let mut joints: Vec<[f64; 6]> = Vec::with_capacity(poses.len());
    for (k, pose) in poses.iter().enumerate() {
        let near = joints.last().unwrap_or(&begin);
        let found = next(pose, near, turns[k]);
        // The way up from below is longer than a step.
        let found = found.filter(|found| if k == 0 { arm.branch(found) == branch } else { same(found, near) });
        joints.push(found.ok_or(k)?);
    }
    let at = joints.len() - 1;
    let end = next(&down(last), &joints[at], turns[at]).filter(|joints| arm.branch(joints) == branch).ok_or(at)?;
    Ok((joints, [begin, end]))
}

impl DomePrint {
    /// The steps of the print: from below each stroke to its begin, extruder on, along it, extruder off, down; and to the next
    /// one by joints.
    pub fn steps<'a>(&'a self, options: &'a DomeOptions) -> impl Iterator<Item = Step> + 'a {
        self.strokes.iter().flat_map(move |stroke| stroke.steps(options))
    }

    /// Points of the program that are printed.
    pub fn points(&self) -> usize {
        self.strokes.iter().map(|stroke| stroke.poses.len()).sum()
    }
}

impl PrintedStroke {
    fn steps<'a>(&'a self, options: &'a DomeOptions) -> impl Iterator<Item = Step> + 'a {
        let plunge = Speed { mm_s: options.plunge_mm_s, ..Speed::default() };
        let to = |goal: Goal, speed: Speed, zone: Zone| Step::Move(Move { goal, table: None, speed, zone });
        let last = self.poses.len() - 1;
        let target = move |k: usize| Goal::Line(Target { pose: self.poses[k], conf: self.confs[k] });
        let before = [
            to(Goal::Joints(self.below[0]), Speed::default(), Zone::Stop),
            to(target(0), plunge, Zone::Stop),
            Step::Extruder(true),
            Step::FilamentSpeed(self.feed),
        ];
        let along = (1..=last).map(move |k| {
            let seconds = ((self.lengths[k] - self.lengths[k - 1]) / options.print_mm_s).max(MIN_SECONDS);
            let way = (self.poses[k].translation.vector - self.poses[k - 1].translation.vector).norm();
            let turn = self.poses[k].rotation.angle_to(&self.poses[k - 1].rotation);
            // The slower of way and turn sets the time of a move (RAPID's `speeddata`), so each of them takes it all: where the flange stands
            // still, as on a ring around the pole, only turning is left.
            let speed = Speed {
                mm_s: ((way + ROUNDING_MM) / seconds).max(MIN_SPEED_MM_S),
                rad_s: (turn / seconds).max(MIN_TURN_RAD_S),
            };
            let zone = if k == last { Zone::Stop } else { Zone::Blend(options.corner_mm) };
            to(target(k), speed, zone)
        });
        let off = [Step::FilamentSpeed(0.0), Step::Extruder(false)];
        let down = to(Goal::Joints(self.below[1]), Speed { mm_s: options.plunge_mm_s, ..Speed::default() }, Zone::Stop);
        before.into_iter().chain(along).chain(off).chain([down])
    }
}

/// A move takes this at least, a quarter of a controller's tick: points that are nearer are left out, as the nozzle would slow down for them.
const MIN_SECONDS: f64 = 1e-3;
/// What four digits take from or add to the way between two targets, in millimetres. A flange that stands still but for turning has a way of
/// that length in the program; at the speed of a shorter way it would set the time. A move of 0.1 mm that only goes straight is 0.2 % too fast.
const ROUNDING_MM: f64 = 2e-4;
/// Slowest speeds that are written. A nozzle that goes over the platform at 2 mm/s or more needs more of one of them.
const MIN_SPEED_MM_S: f64 = 0.01;
const MIN_TURN_RAD_S: f64 = 0.01;
