//! Steps of a planned print: the stream of its joints at the controller's rate, or targets on the part; and where programs of
//! a long print begin and end.
//!
//! Arms of Universal Robots take the stream ([`print_stream`]): what runs is the planned motion itself, sampled at every tick.
//! ABB controllers take targets ([`print_targets`]) and interpolate by themselves, at the speed that the plan has between two
//! waypoints. B. Brooks (2016, section 4.14) could not load a program of 180,000 lines: [`print_pieces`] says which motions
//! make a program each.
//!
//! Nothing here knows of a planner: a motion is a duration with closures, or a list of knots.

use super::knot::{PrintKnot, TargetOptions};
use super::lag::{Advanced, Delayed};
use super::merge::merged;
use super::{
    ExternalAxes, Goal, Move, ProgramLimits, RapidOptions, RapidSwitching, RapidTool, RapidWorkObject, ServoRate,
    Speed, Step, TimedSignal, UrScriptOptions, Zone,
};
use crate::arm::Arm;
use crate::scene::Mount;
use crate::workcell::{ArmGeometry, Equipment, Workcell, tool_frame};
use std::ops::Range;

/// A motion of a print as a function of time.
#[derive(Clone, Debug)]
pub struct StreamLeg<J, L> {
    /// In seconds. A leg whose duration is not finite, or not above 0, is left out.
    pub duration_s: f64,
    /// Joints of the arm at a time since the leg began.
    pub joints: J,
    /// Millimetres of filament that are laid by a time since the leg began; `None` for a leg that does not print.
    pub filament_mm: Option<L>,
    /// Signals of a tape head along it, in the order of their times: each comes before the first tick at or after its time, or at the end.
    pub signals: Vec<TimedSignal>,
}

/// How a print is streamed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamOptions {
    /// The controller's rate. Default 125 Hz.
    pub rate: ServoRate,
    /// The speed of the filament is written again where it changes by more than this share. Default 0.002: with less every tick
    /// writes one, with more the beads are as much too thick or too thin.
    pub same_speed: f64,
    /// How far the arm is behind the stream, in seconds: signals come as much later, and the last posture is held as long. Arms
    /// of Universal Robots follow `servoj` with a lag of its look-ahead time. Below 0 signals come earlier, for equipment that takes longer
    /// than the arm, by 0.5 s at most; where the stream begins with one, the first posture is held as long. Default 0.
    pub lag_s: f64,
}

/// How much earlier signals of a stream come at most, in seconds: as in RAPID. As many ticks are held in memory.
const MAX_EARLY_S: f64 = 0.5;

impl Default for StreamOptions {
    fn default() -> Self {
        StreamOptions { rate: ServoRate::Hz125, same_speed: 2e-3, lag_s: 0.0 }
    }
}

impl StreamOptions {
    /// The rate of the arm of a workcell, 500 Hz for e-Series, whose names end with `e`, and 125 Hz for others, which e-Series take as
    /// well; signals later by the look-ahead time of `servoj`, and earlier by the lag of the extruder.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let rate = match &equipment.model().arm.geometry {
            ArmGeometry::Named(name) if name.ends_with('e') => ServoRate::Hz500,
            _ => ServoRate::Hz125,
        };
        let lookahead_s = UrScriptOptions::of_workcell(equipment).lookahead_s;
        let lag_s = lookahead_s - equipment.model().controller.extruder_lag_s;
        StreamOptions { rate, lag_s, ..StreamOptions::default() }
    }
}

/// The steps of a print as a stream: by joints to the first posture, then all legs at every tick of the controller, the extruder
/// on along those that print.
///
/// Ticks count from the begin of the first leg, through all legs. The last posture follows as one step more, since the end lies
/// between two ticks.
///
/// # Arguments
/// * `ends`: the first and the last posture.
/// * `legs`: one after the other, each beginning where the one before ends.
///
/// # Cost
/// Constant memory; each tick asks for the joints once and for the filament twice.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::{Step, StreamLeg, StreamOptions, print_stream};
/// // Joint 1 turns by 0.1 rad in 20 ms while 1 mm of filament is laid.
/// let leg = StreamLeg { duration_s: 0.02, joints: |t: f64| [5.0 * t, 0.0, 0.0, 0.0, 0.0, 0.0], filament_mm: Some(|t: f64| 50.0 * t), signals: Vec::new() };
/// let steps: Vec<Step> = print_stream([[0.0; 6], [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]], [leg], StreamOptions::default()).collect();
/// assert!(matches!(steps[..], [
///     Step::Move(_), Step::Extruder(true), Step::FilamentSpeed(_), Step::Servo { .. }, Step::Servo { .. },
///     Step::FilamentSpeed(0.0), Step::Extruder(false), Step::Servo { .. },
/// ]));
/// ```
pub fn print_stream<J: Fn(f64) -> [f64; 6], L: Fn(f64) -> f64>(
    ends: [[f64; 6]; 2],
    legs: impl IntoIterator<Item = StreamLeg<J, L>>,
    options: StreamOptions,
) -> impl Iterator<Item = Step> {
    let StreamOptions { rate, same_speed, lag_s } = options;
    let period = rate.seconds();
    let first = by_joints(ends[0], None);
    let mut begin = 0.0;
    let legs = legs.into_iter().filter(|leg| leg.duration_s > 0.0 && leg.duration_s.is_finite());
    let along = legs.flat_map(move |leg| {
        let (from, to) = (begin, begin + leg.duration_s);
        begin = to;
        let of_leg = move |tick: &u64| *tick as f64 * period <= to;
        let first = ((from / period).floor() as u64).saturating_add(1);
        let prints = leg.filament_mm.is_some();
        let signal = move |on| prints.then_some(Step::Extruder(on));
        let mut speed = 0.0;
        // The leg has no tick at or after the times of the others.
        let last = (to / period).floor() as u64;
        let last = if of_leg(&(last + 1)) { last + 1 } else { last };
        let until = if last < first { f64::NEG_INFINITY } else { last as f64 * period - from };
        let switched = |TimedSignal { signal, on, .. }| Step::Signal { signal, on };
        let split = leg.signals.partition_point(|signal| signal.time_s <= until);
        let behind: Vec<Step> = leg.signals[split..].iter().copied().map(switched).collect();
        let mut due = leg.signals.into_iter().take(split).peekable();
        let servo = (first..).take_while(of_leg).flat_map(move |tick| {
            let now = tick as f64 * period - from;
            let laid = |filament_mm: &L| (filament_mm(now) - filament_mm(now - period)).max(0.0) / period;
            let needed = leg.filament_mm.as_ref().map_or(0.0, laid);
            // Steady speeds are written once.
            let changes = prints && (needed - speed).abs() > same_speed * speed;
            speed = if changes { needed } else { speed };
            let servo = Step::Servo { joints: (leg.joints)(now), seconds: period };
            let signals: Vec<Step> =
                std::iter::from_fn(|| due.next_if(|signal| signal.time_s <= now)).map(switched).collect();
            signals.into_iter().chain(changes.then_some(Step::FilamentSpeed(speed))).chain([servo])
        });
        let end = prints.then_some(Step::FilamentSpeed(0.0));
        signal(true).into_iter().chain(servo).chain(behind).chain(end).chain(signal(false))
    });
    // The end lies between two ticks.
    let steps = [first].into_iter().chain(along).chain([Step::Servo { joints: ends[1], seconds: period }]);
    // A lag that is not a number is none; each of the two casts takes what is below 0 as 0.
    let ticks = (lag_s.clamp(-MAX_EARLY_S, f64::INFINITY) / period).round();
    Delayed::new(Advanced::new(steps, -ticks as usize), ticks as u64)
}

fn by_joints(joints: [f64; 6], table: Option<[f64; 2]>) -> Step {
    let table = table.map(ExternalAxes::from);
    Step::Move(Move { goal: Goal::Joints(joints), table, speed: Speed::default(), zone: Zone::Stop })
}

/// A motion that prints, and the postures on the way from its end to the next motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetMotion<const N: usize> {
    /// The motion.
    pub knots: Vec<PrintKnot<N>>,
    /// The way on, without extrusion: each is a move by joints that stops.
    pub onward: Vec<[f64; N]>,
    /// Signals of a tape head along the motion, in the order of their times, for one that lays tape: the extruder stays off. `None` for a
    /// motion that extrudes.
    pub head: Option<Vec<TimedSignal>>,
}

/// The steps of a print as targets on the part: by joints to each motion, along it in straight lines from waypoint to waypoint
/// at the speed of the plan, the table along, and on by joints.
///
/// The extruder is on along each motion, and the filament has the speed that lays what the plan lays between two waypoints.
/// Along a motion of a tape head the extruder stays off; each signal comes at the first knot at or after its time, where the arm stops, so that a cut
/// is where it was planned. Such motions are not merged.
/// A motion without knots gives no steps but those of its way on. A posture with a table beyond its limits
/// ([`Workcell::controller_pose`]) is left out with the moves that begin or end there.
///
/// For an arm without a table these steps are a URScript of `movel` or `movep` as well
/// ([`UrScriptOptions::of_workcell`](super::UrScriptOptions::of_workcell)); with [`TargetOptions::merge_mm`] straight
/// paths take few lines. Waypoints are merged only where they are near the line both of the tip on the part and of the part
/// against the tip, so it does not matter which of them the controller interpolates.
///
/// # Cost
/// Two forward kinematics a waypoint, and up to some hundred interpolations where waypoints are merged; memory for one
/// motion.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::{PrintKnot, Step, TargetMotion, TargetOptions, print_targets};
/// use curvlay_kinematics::workcell::AnyWorkcell;
/// # #[cfg(feature = "serde")] {
/// let file = include_str!("../../../examples/cells/ur3.json");
/// let AnyWorkcell::Six(cell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has a table".into()) };
/// let at = |time_s: f64| PrintKnot { time_s, joints: [0.1 * time_s, -1.0, -1.5, 0.3, 0.2, 0.0], filament_mm: 2.0 * time_s };
/// let motion = TargetMotion { knots: vec![at(0.0), at(0.5), at(1.0)], onward: vec![[0.0; 6]], head: None };
/// let steps: Vec<Step> = print_targets(&cell, [motion], TargetOptions::default()).collect();
/// assert_eq!(steps.len(), 8);
/// assert_eq!((steps[1], steps[6]), (Step::Extruder(true), Step::Extruder(false)));
/// assert_eq!(steps[2], Step::FilamentSpeed(2.0));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn print_targets<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    motions: impl IntoIterator<Item = TargetMotion<N>>,
    options: TargetOptions,
) -> impl Iterator<Item = Step> {
    let TargetOptions { corner_mm, turn_factor, min_turn_rad_s, min_speed_mm_s, .. } = options;
    let joints_move = move |joints: &[f64; N]| {
        let place = cell.controller_pose(joints)?;
        Some(by_joints(place.joints, place.table))
    };
    let line = move |[a, b]: [&PrintKnot<N>; 2], zone: Zone| {
        let (from, to) = (cell.controller_pose(&a.joints)?, cell.controller_pose(&b.joints)?);
        let step = b.time_s - a.time_s;
        let mm_s = (to.target.pose.translation.vector - from.target.pose.translation.vector).norm() / step;
        let turn = from.target.pose.rotation.angle_to(&to.target.pose.rotation) / step;
        let speed = Speed { mm_s: mm_s.max(min_speed_mm_s), rad_s: (turn_factor * turn).max(min_turn_rad_s) };
        let filament_mm_s = (b.filament_mm - a.filament_mm).max(0.0) / step;
        let to = Move { goal: Goal::Line(to.target), table: to.table.map(ExternalAxes::from), speed, zone };
        Some((filament_mm_s, to))
    };
    motions.into_iter().flat_map(move |TargetMotion { knots, onward, head }| {
        if let Some(signals) = head {
            let mut steps = along_tape(&knots, signals, &joints_move, &line, corner_mm);
            steps.extend(onward.iter().filter_map(joints_move));
            return steps;
        }
        let knots = if options.merge_mm > 0.0 { merged(cell, &knots, &options) } else { knots };
        let last = knots.len().saturating_sub(2);
        let zone = |k: usize| if k == last { Zone::Stop } else { Zone::Blend(corner_mm) };
        let along = knots.windows(2).enumerate().filter_map(|(k, pair)| line([&pair[0], &pair[1]], zone(k)));
        let mut steps = Vec::with_capacity(2 * knots.len() + onward.len() + 3);
        if let Some(first) = knots.first() {
            steps.extend(joints_move(&first.joints));
            steps.push(Step::Extruder(true));
            let mut fed: Option<f64> = None;
            for (mm_s, to) in along {
                // An output keeps its value.
                if fed.is_none_or(|fed| (mm_s - fed).abs() > options.same_speed * fed) {
                    steps.push(Step::FilamentSpeed(mm_s));
                    fed = Some(mm_s);
                }
                steps.push(Step::Move(to));
            }
            steps.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
        }
        steps.extend(onward.iter().filter_map(joints_move));
        steps
    })
}

/// The steps of a motion of a tape head.
fn along_tape<const N: usize>(
    knots: &[PrintKnot<N>],
    signals: Vec<TimedSignal>,
    joints_move: &impl Fn(&[f64; N]) -> Option<Step>,
    line: &impl Fn([&PrintKnot<N>; 2], Zone) -> Option<(f64, Move)>,
    corner_mm: f64,
) -> Vec<Step> {
    let Some(first) = knots.first() else { return Vec::new() };
    let mut due = signals.into_iter().peekable();
    let mut by = |until_s: f64, steps: &mut Vec<Step>| {
        while let Some(TimedSignal { signal, on, .. }) = due.next_if(|signal| signal.time_s <= until_s) {
            steps.push(Step::Signal { signal, on });
        }
        due.peek().map(|next| next.time_s)
    };
    let mut steps: Vec<Step> = joints_move(&first.joints).into_iter().collect();
    let mut next_s = by(0.0, &mut steps);
    for (k, pair) in knots.windows(2).enumerate() {
        let at_s = pair[1].time_s - first.time_s;
        let stops = k + 2 == knots.len() || next_s.is_some_and(|next_s| next_s <= at_s);
        let zone = if stops { Zone::Stop } else { Zone::Blend(corner_mm) };
        steps.extend(line([&pair[0], &pair[1]], zone).map(|(_, to)| Step::Move(to)));
        next_s = by(at_s, &mut steps);
    }
    by(f64::INFINITY, &mut steps);
    steps
}

/// Some motions of a print that make a program.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintPiece {
    /// Which of the motions.
    pub motions: Range<usize>,
    /// Steps; of a stream with fractions, since motions do not end on its ticks.
    pub steps: f64,
    /// Whether it begins where the piece before ends. The robot has to be brought to one that does not; the first does not.
    pub joined: bool,
}

/// Cuts a print into programs: where no way leads on, and before a motion with which a program would have more than
/// `max_steps`. A single motion may have more.
///
/// # Arguments
/// * `motions`: for each its steps, with those of the way on, and whether there is a way on to the next.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::print_pieces;
/// let pieces = print_pieces([(4.0, true), (3.5, true), (3.0, false), (1.0, true)], 8);
/// assert_eq!(pieces.iter().map(|piece| (piece.motions.clone(), piece.joined)).collect::<Vec<_>>(), [
///     (0..2, false), (2..3, true), (3..4, false),
/// ]);
/// ```
pub fn print_pieces(motions: impl IntoIterator<Item = (f64, bool)>, max_steps: u64) -> Vec<PrintPiece> {
    let mut pieces: Vec<PrintPiece> = Vec::new();
    let mut joined = false;
    for (number, (steps, leads_on)) in motions.into_iter().enumerate() {
        match pieces.last_mut() {
            Some(last) if joined && last.steps + steps <= max_steps as f64 => {
                last.motions.end = number + 1;
                last.steps += steps;
            }
            _ => pieces.push(PrintPiece { motions: number..number + 1, steps, joined }),
        }
        joined = leads_on;
    }
    pieces
}

/// What splines may pass the limits by, so that a motion at its limit is not refused: radians, and a share of the speed.
const SLACK: f64 = 2e-6;

impl ProgramLimits {
    /// The limits of an arm, passed by 2e-6 (radians, and of the speed as a share) at most, by which planned motions at their
    /// limits may be off.
    pub fn of_arm(arm: &Arm) -> Self {
        let mut joints = *arm.limits();
        for joint in 0..6 {
            joints.lower[joint] -= SLACK;
            joints.upper[joint] += SLACK;
            joints.velocity[joint] *= 1.0 + SLACK;
        }
        ProgramLimits { joints, ..ProgramLimits::default() }
    }
}

impl RapidOptions {
    /// The nozzle as tool and the part frame as work object of a workcell, on the mechanical unit `STN1` if there is a table, within
    /// the limits of its arm; the arm and the table, for the seconds that the program states; the extruder is
    /// switched on the path, earlier by its lag in the workcell.
    pub fn of_workcell(equipment: &Equipment) -> Self {
        let defaults = RapidOptions::default();
        let ((held, nozzle), (carrier, frame)) = (equipment.nozzle_frame(), equipment.part_frame());
        let in_hand = |mount| matches!(mount, Mount::Link(_));
        let name = "nozzle".to_owned();
        let tool = RapidTool { name, in_hand: in_hand(held), frame: tool_frame(&nozzle), ..defaults.tool };
        let unit = equipment.positioner().map(|_| "STN1".to_owned());
        let work_object = RapidWorkObject { name: "part".to_owned(), in_hand: in_hand(carrier), frame, unit };
        let (arm, positioner) = (*equipment.arm(), equipment.positioner().copied());
        let switching = RapidSwitching::OnPath { lag_s: equipment.model().controller.extruder_lag_s };
        let limits = ProgramLimits::of_arm(&arm);
        RapidOptions { tool, work_object, switching, limits, arm: Some(arm), positioner, ..defaults }
    }
}
