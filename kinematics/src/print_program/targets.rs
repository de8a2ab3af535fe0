//! A print as targets on the part.

use super::dropped::{PrintSteps, count};
use super::knot::{PrintKnot, TargetOptions};
use super::merge::merged;
use super::travel_speed::travel_speed;
use crate::program::{ExternalAxes, Goal, Move, Speed, Step, TimedSignal, Zone};
use crate::workcell::{ControllerPose, Workcell};
use std::cell::Cell;
use std::rc::Rc;

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
/// Travels, to each motion and on from it, are as fast as [`TargetOptions::travel_mm_s`] and [`TargetOptions::travel_rad_s`] let them be; the first one, from where
/// the program was started, goes at 50 mm/s and 0.2 rad/s.
/// A motion without knots gives no steps but those of its way on. A posture with a table beyond its limits
/// ([`Workcell::controller_pose`]) is left out with the moves that begin or end there, which are counted ([`PrintSteps::dropped`]).
///
/// For an arm without a table these steps are a URScript of `movel` or `movep` as well
/// ([`UrScriptOptions::of_workcell`](crate::program::UrScriptOptions::of_workcell)); with [`TargetOptions::merge_mm`] straight
/// paths take few lines. Waypoints are merged only where they are near the line both of the tip on the part and of the part
/// against the tip, so it does not matter which of them the controller interpolates.
///
/// # Cost
/// Two forward kinematics a waypoint, and up to some hundred interpolations where waypoints are merged; memory for one
/// motion.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::Step;
/// use curvlay_kinematics::print_program::{PrintKnot, TargetMotion, TargetOptions, print_targets};
/// use curvlay_kinematics::workcell::AnyWorkcell;
/// # #[cfg(feature = "serde")] {
/// let file = include_str!("../../../examples/cells/ur3.json");
/// let AnyWorkcell::Six(workcell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has a table".into()) };
/// let at = |time_s: f64| PrintKnot { time_s, joints: [0.1 * time_s, -1.0, -1.5, 0.3, 0.2, 0.0], filament_mm: 2.0 * time_s };
/// let motion = TargetMotion { knots: vec![at(0.0), at(0.5), at(1.0)], onward: vec![[0.0; 6]], head: None };
/// let steps: Vec<Step> = print_targets(&workcell, [motion], TargetOptions::default()).collect();
/// assert_eq!(steps.len(), 8);
/// assert_eq!((steps[1], steps[6]), (Step::Extruder(true), Step::Extruder(false)));
/// assert_eq!(steps[2], Step::FilamentSpeed(2.0));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn print_targets<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    motions: impl IntoIterator<Item = TargetMotion<N>>,
    options: TargetOptions,
) -> PrintSteps<impl Iterator<Item = Step>> {
    PrintSteps::new(|dropped| {
        let mut targets = Targets { workcell, options, at: None, dropped };
        motions.into_iter().flat_map(move |motion| targets.steps(motion))
    })
}

/// Makes the steps of motions, one after the other.
struct Targets<'a, const N: usize, const F: usize, W: Workcell<N, F>> {
    workcell: &'a W,
    options: TargetOptions,
    /// The posture in which the last step ends; `None` before the first step.
    at: Option<[f64; N]>,
    dropped: Rc<Cell<u64>>,
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Targets<'_, N, F, W> {
    fn steps(&mut self, TargetMotion { knots, onward, head }: TargetMotion<N>) -> Vec<Step> {
        let mut steps = match head {
            Some(signals) => self.along_tape(&knots, signals),
            None if self.options.merge_mm > 0.0 => self.along_bead(&merged(self.workcell, &knots, &self.options)),
            None => self.along_bead(&knots),
        };
        steps.extend(onward.iter().filter_map(|joints| self.by_joints(joints)));
        steps
    }

    /// A travel from where the last step ends.
    fn by_joints(&mut self, joints: &[f64; N]) -> Option<Step> {
        let Some(place) = self.workcell.controller_pose(joints) else {
            count(&self.dropped);
            return None;
        };
        let speed = travel_speed(self.workcell, self.at.replace(*joints), joints, &self.options);
        let goal = Goal::Joints(place.joints);
        Some(Step::Move(Move { goal, table: external(&place), speed, zone: Zone::Stop }))
    }

    /// A line, and the speed of the filament along it.
    fn line(&mut self, [a, b]: [&PrintKnot<N>; 2], zone: Zone) -> Option<(f64, Move)> {
        let [from, to] = [a, b].map(|knot| self.workcell.controller_pose(&knot.joints));
        let (Some(from), Some(to)) = (from, to) else {
            count(&self.dropped);
            return None;
        };
        self.at = Some(b.joints);
        let TargetOptions { turn_factor, min_turn_rad_s, min_speed_mm_s, .. } = self.options;
        let step = b.time_s - a.time_s;
        let mm_s = (to.target.pose.translation.vector - from.target.pose.translation.vector).norm() / step;
        let turn = from.target.pose.rotation.angle_to(&to.target.pose.rotation) / step;
        let speed = Speed { mm_s: mm_s.max(min_speed_mm_s), rad_s: (turn_factor * turn).max(min_turn_rad_s) };
        let filament_mm_s = (b.filament_mm - a.filament_mm).max(0.0) / step;
        Some((filament_mm_s, Move { goal: Goal::Line(to.target), table: external(&to), speed, zone }))
    }

    /// The zone at the end of a line.
    fn zone(&self, stops: bool) -> Zone {
        if stops { Zone::Stop } else { Zone::Blend(self.options.corner_mm) }
    }

    /// The steps of a motion that extrudes.
    fn along_bead(&mut self, knots: &[PrintKnot<N>]) -> Vec<Step> {
        let Some(first) = knots.first() else { return Vec::new() };
        let mut steps = Vec::with_capacity(2 * knots.len() + 3);
        steps.extend(self.by_joints(&first.joints));
        steps.push(Step::Extruder(true));
        let mut fed: Option<f64> = None;
        for (k, pair) in knots.windows(2).enumerate() {
            let zone = self.zone(k + 2 == knots.len());
            let Some((mm_s, to)) = self.line([&pair[0], &pair[1]], zone) else { continue };
            // An output keeps its value.
            if fed.is_none_or(|fed| (mm_s - fed).abs() > self.options.same_speed * fed) {
                steps.push(Step::FilamentSpeed(mm_s));
                fed = Some(mm_s);
            }
            steps.push(Step::Move(to));
        }
        steps.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
        steps
    }

    /// The steps of a motion of a tape head.
    fn along_tape(&mut self, knots: &[PrintKnot<N>], signals: Vec<TimedSignal>) -> Vec<Step> {
        let Some(first) = knots.first() else { return Vec::new() };
        let mut due = signals.into_iter().peekable();
        let mut by = |until_s: f64, steps: &mut Vec<Step>| {
            while let Some(TimedSignal { signal, on, .. }) = due.next_if(|signal| signal.time_s <= until_s) {
                steps.push(Step::Signal { signal, on });
            }
            due.peek().map(|next| next.time_s)
        };
        let mut steps: Vec<Step> = self.by_joints(&first.joints).into_iter().collect();
        let mut next_s = by(0.0, &mut steps);
        for (k, pair) in knots.windows(2).enumerate() {
            let at_s = pair[1].time_s - first.time_s;
            let zone = self.zone(k + 2 == knots.len() || next_s.is_some_and(|next_s| next_s <= at_s));
            steps.extend(self.line([&pair[0], &pair[1]], zone).map(|(_, to)| Step::Move(to)));
            next_s = by(at_s, &mut steps);
        }
        by(f64::INFINITY, &mut steps);
        steps
    }
}

/// The external axes of a posture: tilt and turn of a table, or a track.
pub(super) fn external(place: &ControllerPose) -> Option<ExternalAxes> {
    place.table.map(ExternalAxes::from).or(place.track_mm.map(ExternalAxes::of_track))
}
