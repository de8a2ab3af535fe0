//! A print on a dome in the robot's hand under a fixed nozzle: from strokes on the surface to the steps of a program.
//!
//! B. Brooks (2016), sections 4.13 to 4.15. Poses are those of [`DomeRig`]: of the flange in the robot's base, for RAPID's `tool0`
//! and `wobj0`. [`choose_turns`] keeps axis 6 within its range, so that the return home after each stroke (section 5.2.2) is not
//! needed; every pose is solved by the inverse kinematics, joints next to the ones before.
//!
//! Departs from the thesis: configuration data are computed, not fixed; the speed of a move is such that the nozzle goes evenly over
//! the dome, while the flange, to which RAPID's speed refers, may hardly move; the way to the next stroke is by joints.

use super::{ConfData, DomeRig, Goal, Move, Speed, Step, Target, TurnError, TurnPath, Zone, choose_turns};
use crate::arm::Arm;
use nalgebra::{Isometry3, Point3, UnitVector3};
use std::f64::consts::{PI, TAU};
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
    /// Speed of the nozzle over the surface, mm/s. Default 20.
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
    /// What turning may take of axis 6 more than the shortest, as a share. Default 2.
    pub turn_factor: f64,
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
            turn_factor: 2.0,
        }
    }
}

/// A stroke as the robot prints it.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedStroke {
    /// Poses of the flange in the base.
    pub poses: Vec<Isometry3<f64>>,
    /// Joints at each of them.
    pub joints: Vec<[f64; 6]>,
    /// Configuration data of those joints.
    pub confs: Vec<ConfData>,
    /// Joints below the begin and the end, with the platform down from the nozzle.
    pub below: [[f64; 6]; 2],
    /// How far the nozzle goes over the surface to each point, in millimetres.
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
    /// How often a stroke was stopped because axis 6 cannot turn as far as it needs.
    pub splits: usize,
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
        /// The point, from 0, as the stroke is followed.
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

fn from_home(rig: &DomeRig, arm: &Arm, home: &[f64; 6], strokes: &[DomeStroke], options: &DomeOptions) -> DomePrint {
    // With the arm in the YZ plane, joint 6 is the turn and a constant: at home nothing is turned.
    let constant = home[5];
    let range = [arm.limits().lower[5] - constant, arm.limits().upper[5] - constant];
    let mut print = DomePrint { axis6: [home[5]; 2], home: *home, ..DomePrint::default() };
    let (mut previous, mut turn) = (*home, 0.0);
    // The last piece comes first.
    let mut waiting: Vec<Piece> = strokes.iter().enumerate().rev().map(|of| Piece::of(of, options)).collect();
    while let Some(Piece { number, stroke, points, turns, closed, whole }) = waiting.pop() {
        let path = TurnPath { turns: &turns, closed };
        let choice = match choose_turns(&[path], range, turn) {
            Ok(choices) => choices[0],
            Err(_) if whole && turns.iter().all(|turn| turn.is_finite()) => {
                let pieces = within_span(&turns, range[1] - range[0] - TAU);
                print.splits += pieces.len() - 1;
                waiting.extend(pieces.into_iter().rev().map(|part| {
                    let (points, turns) = (points[part.clone()].to_vec(), turns[part].to_vec());
                    Piece { number, stroke, points, turns, closed: false, whole: false }
                }));
                continue;
            }
            Err(TurnError { span, .. }) => {
                print.faults.push(DomeFault::Turns { stroke: number, span_deg: span.to_degrees() });
                continue;
            }
        };
        let (points, turns) = (choice.ordered(&points), choice.turned(&turns));
        let above = stroke.above + options.nozzle_mm;
        let poses: Vec<Isometry3<f64>> = points
            .iter()
            .zip(&turns)
            .map(|((at, normal), turn)| rig.target_on(&(at + normal.into_inner() * above), normal, *turn))
            .collect();
        match follow(arm, &previous, &poses, options.hop_mm, constant, &turns) {
            Ok((joints, below)) => {
                let mut along = 0.0;
                let steps = points.iter().enumerate().map(|(k, (at, _))| {
                    along += if k > 0 { (at - points[k - 1].0).norm() } else { 0.0 };
                    along
                });
                let lengths = steps.collect();
                for joints in joints.iter().chain(&below) {
                    print.axis6 = [print.axis6[0].min(joints[5]), print.axis6[1].max(joints[5])];
                }
                print.travel += choice.travel.abs();
                previous = below[1];
                turn = turns.last().copied().unwrap_or(turn);
                let confs = joints.iter().map(|joints| ConfData::of(arm, joints)).collect();
                print.strokes.push(PrintedStroke { poses, joints, confs, below, lengths, feed: stroke.feed });
            }
            Err(point) => {
                let at = points.get(point).map_or_else(Point3::origin, |(at, _)| *at);
                print.faults.push(DomeFault::Reach { stroke: number, point, x: at.x, y: at.y, z: at.z });
            }
        }
    }
    print
}

/// A stroke, or a part of one that turns too far.
struct Piece<'a> {
    number: usize,
    stroke: &'a DomeStroke,
    points: Vec<(Point3<f64>, UnitVector3<f64>)>,
    turns: Vec<f64>,
    closed: bool,
    whole: bool,
}

impl<'a> Piece<'a> {
    fn of((number, stroke): (usize, &'a DomeStroke), options: &DomeOptions) -> Self {
        let places: Vec<Point3<f64>> = stroke.points.iter().map(|(at, _)| *at).collect();
        let mut turns = DomeRig::turns(&places, options.pole_mm);
        turns.iter_mut().for_each(|turn| *turn += options.added_turn);
        Piece { number, stroke, points: stroke.points.clone(), turns, closed: stroke.closed, whole: true }
    }
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
            let speed = Speed {
                mm_s: (way / seconds).max(MIN_SPEED_MM_S),
                rad_s: (options.turn_factor * turn / seconds).max(MIN_TURN_RAD_S),
            };
            let zone = if k == last { Zone::Stop } else { Zone::Blend(options.corner_mm) };
            to(target(k), speed, zone)
        });
        let off = [Step::FilamentSpeed(0.0), Step::Extruder(false)];
        let down = to(Goal::Joints(self.below[1]), Speed { mm_s: options.plunge_mm_s, ..Speed::default() }, Zone::Stop);
        before.into_iter().chain(along).chain(off).chain([down])
    }
}

/// A move takes this at least: the time of a controller's tick.
const MIN_SECONDS: f64 = 1e-3;
/// Slowest speeds that are written; where the flange hardly moves, turning sets the time.
const MIN_SPEED_MM_S: f64 = 0.01;
const MIN_TURN_RAD_S: f64 = 0.01;
