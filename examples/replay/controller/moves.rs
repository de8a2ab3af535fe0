//! Segments of moves: where they end, and how long they take at their own speeds.

use super::super::axes::{Axes, MAX_AXES, NozzlePose};
use super::super::machine::{FiveAxis, Machine, Reached};
use super::super::program::command::{Goal, Motion, Place, Speed, Target};
use super::run::{Controller, NO_MOVE};
use super::segment::{self, Path, Segment};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Lines that are shorter than this only turn, in millimetres.
const ONLY_TURNS_MM: f64 = 1e-6;
/// Chords along the way of the tip on a move by joints.
const CHORDS: u32 = 8;
/// A direction farther away than this is out of reach, in radians, and a radian counts as this many millimetres.
const MISSED_RAD: f64 = 1e-5;
const LEVER_MM: f64 = 100.0;
/// Joints may be this far beyond a quarter turn: rounding of targets, in radians.
const QUARTER_SLACK: f64 = 0.02;

impl Controller<'_> {
    /// Where the axes are when a program says this.
    pub(super) fn positions(&self, program: &Axes) -> Axes {
        match self.machine {
            Machine::FiveAxis(printer) if printer.knows_tip => printer.under_tip(program),
            _ => *program,
        }
    }

    /// Tip and readings of rotary axes for a pose of the nozzle, from axes nearby, and the axes there.
    pub(super) fn under_vector(&mut self, place: Place, pose: &NozzlePose, near: &Axes) -> (Axes, Axes) {
        let Machine::FiveAxis(printer) = self.machine else { return (*near, *near) };
        let linear = printer.linear;
        let ([first, second], off) = printer.readings(&pose.axis, &[near[linear], near[linear + 1]]);
        if off > MISSED_RAD {
            self.obstacles.miss(place, off * LEVER_MM);
        }
        let program = [pose.tip.x, pose.tip.y, pose.tip.z, first, second, 0.0, 0.0, 0.0];
        (program, printer.under_tip(&program))
    }

    /// The segment of a move; `None` where nothing moves.
    pub(super) fn segment(&mut self, place: Place, motion: &Motion, begin: &Axes) -> Option<Segment> {
        let segment = match &motion.goal {
            Goal::Axes(axes) => match self.machine {
                Machine::FiveAxis(printer) if printer.knows_tip => self.tip_line(printer, begin, axes, &motion.speed),
                _ => self.by_axes(begin, axes, &motion.speed),
            },
            Goal::Nozzle(pose) => {
                let (program, _) = self.under_vector(place, pose, begin);
                let Machine::FiveAxis(printer) = self.machine else { return None };
                self.tip_line(printer, begin, &program, &motion.speed)
            }
            Goal::Pose(target) => {
                let axes = self.posture(place, target, begin, false);
                self.by_axes(begin, &axes, &motion.speed)
            }
            Goal::Line(target) => self.line(place, target, begin, &motion.speed)?,
        };
        let seconds = segment.seconds;
        (seconds > NO_MOVE && seconds.is_finite()).then_some(Segment {
            filament_mm: motion.filament_mm,
            extrudes: motion.extrudes,
            zone: motion.zone,
            place,
            ..segment
        })
    }

    fn by_axes(&self, from: &Axes, to: &Axes, speed: &Speed) -> Segment {
        let way: Axes = std::array::from_fn(|k| (to[k] - from[k]).abs());
        let linear = way[..self.machine.linear()].iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_robot = matches!(self.machine, Machine::Robot(_));
        let (length, angle) = if is_robot { self.swept(from, to) } else { (linear, 0.0) };
        let fastest =
            || (0..MAX_AXES).filter(|k| way[*k] > 0.0).map(|k| way[k] / self.limits.speed[k]).fold(0.0, f64::max);
        let seconds = match speed {
            Speed::Seconds(seconds) => *seconds,
            Speed::Tool { mm_s, rad_s } => (length / mm_s).max(angle / rad_s).max(fastest()),
            Speed::Joints(rad_s) => way.iter().copied().fold(0.0, f64::max) / rad_s,
            Speed::Linear(mm_s) if linear > 0.0 => linear / mm_s,
            Speed::Linear(deg_s) => way.iter().copied().fold(0.0, f64::max) / deg_s.to_radians(),
            Speed::Rapid => fastest(),
        };
        let moves = way.iter().any(|x| *x > 0.0);
        let segment = segment::by_axes(from, to, length);
        if moves && seconds > 0.0 { segment.within(seconds) } else { Segment { seconds: 0.0, ..segment } }
    }

    fn tip_line(&self, printer: &FiveAxis, begin: &Axes, to: &Axes, speed: &Speed) -> Segment {
        let segment = segment::tip_line(printer, begin, to);
        let fastest = || {
            (0..MAX_AXES)
                .filter(|k| segment.max_rates[*k] > 0.0)
                .map(|k| segment.max_rates[k] / self.limits.speed[k])
                .fold(0.0, f64::max)
        };
        let Path::Tip { from, to } = &segment.path else { return segment };
        let turned = (3..5).map(|k| (to[k] - from[k]).abs()).fold(0.0, f64::max);
        let seconds = match speed {
            Speed::Seconds(seconds) => *seconds,
            Speed::Linear(mm_s) if segment.length_mm > ONLY_TURNS_MM => segment.length_mm / mm_s,
            Speed::Linear(deg_s) => turned / deg_s.to_radians(),
            _ => fastest(),
        };
        let moves = segment.length_mm > 0.0 || turned > 0.0;
        if moves && seconds > 0.0 { segment.within(seconds) } else { Segment { seconds: 0.0, ..segment } }
    }

    /// The way of the tip over the part, and the turn of the tool, on a move by joints.
    fn swept(&self, from: &Axes, to: &Axes) -> (f64, f64) {
        let pose = |chord: u32| {
            let axes = Path::axes_at(from, to, f64::from(chord) / f64::from(CHORDS));
            self.machine.nozzle_on_part(&axes)
        };
        let (mut length, mut angle, mut before) = (0.0, 0.0, pose(0));
        for chord in 1..=CHORDS {
            let next = pose(chord);
            length += (next.tip - before.tip).norm();
            angle += before.axis.cross(&next.axis).norm().atan2(before.axis.dot(&next.axis));
            before = next;
        }
        (length, angle)
    }

    fn line(&mut self, place: Place, target: &Target, begin: &Axes, speed: &Speed) -> Option<Segment> {
        let (Machine::Robot(robot), Some(frames)) = (self.machine, self.sampler.frames) else { return None };
        let table = target.table.unwrap_or([begin[6], begin[7]]);
        let (segment, off_mm) = segment::line(robot, &frames, begin, &target.pose, table);
        self.note(place, off_mm, target, &segment.ends[1]);
        let Path::Line { turn, .. } = &segment.path else { return None };
        let seconds = match speed {
            Speed::Tool { mm_s, rad_s } => (segment.length_mm / mm_s).max(turn.norm() / rad_s),
            // URScript: a line that only turns takes the m/s of its speed as rad/s.
            Speed::Linear(mm_s) if segment.length_mm > ONLY_TURNS_MM => segment.length_mm / mm_s,
            Speed::Linear(mm_s) => turn.norm() / (mm_s * 1e-3),
            Speed::Joints(rad_s) => segment.max_rates.iter().copied().fold(0.0, f64::max) / rad_s,
            Speed::Seconds(seconds) => *seconds,
            Speed::Rapid => segment.length_mm / self.model.tip_mm_s,
        };
        // A line on which only the table moves goes as fast as the table does.
        let fastest =
            |k: usize| if segment.max_rates[k] > 0.0 { segment.max_rates[k] / self.limits.speed[k] } else { 0.0 };
        let seconds = if seconds > NO_MOVE { seconds } else { fastest(6).max(fastest(7)) };
        if seconds > NO_MOVE { Some(segment.within(seconds)) } else { None }
    }

    /// Joints for a target, near to where the arm is unless its quarter turns say otherwise.
    pub(super) fn posture(&mut self, place: Place, target: &Target, near: &Axes, is_first: bool) -> Axes {
        let (Machine::Robot(robot), Some(frames)) = (self.machine, self.sampler.frames) else { return *near };
        let mut seed = *near;
        if let Some([tilt, turn]) = target.table {
            (seed[6], seed[7]) = (tilt, turn);
        }
        let direct = robot.solve(&frames, &target.pose, &seed);
        let fits = |axes: &Axes| target.quarters.is_none_or(|quarters| in_quarters(axes, &quarters));
        let best = if direct.is_reached() && !is_first && fits(&direct.axes) {
            direct
        } else {
            let all = seeds(&seed).into_iter().map(|seed| robot.solve(&frames, &target.pose, &seed));
            let unwound = all.map(|found| Reached { axes: unwound(&found.axes, target.quarters, &seed), ..found });
            let cost = |found: &Reached| {
                let turn: f64 = (0..6).map(|k| (found.axes[k] - seed[k]).abs()).sum();
                (!found.is_reached(), !fits(&found.axes), turn)
            };
            let order = |a: &Reached, b: &Reached| {
                let (a, b) = (cost(a), cost(b));
                (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
            };
            unwound.min_by(order).unwrap_or(direct)
        };
        self.note(place, best.off_mm, target, &best.axes);
        best.axes
    }

    /// Counts a target that is missed, or reached in other quarter turns.
    fn note(&mut self, place: Place, off_mm: f64, target: &Target, axes: &Axes) {
        let reached = Reached { axes: *axes, off_mm };
        let turned = &mut self.obstacles.turned;
        if !reached.is_reached() {
            self.obstacles.miss(place, off_mm);
        } else if target.quarters.is_some_and(|quarters| !in_quarters(axes, &quarters)) {
            *turned = (turned.0 + 1, turned.1.or(Some(place)));
        }
    }
}

/// Whether joints 1, 4 and 6 are in these quarter turns.
fn in_quarters(axes: &Axes, quarters: &[i32; 3]) -> bool {
    [0, 3, 5].iter().zip(quarters).all(|(&k, &quarter)| {
        let begin = f64::from(quarter) * FRAC_PI_2;
        axes[k] >= begin - QUARTER_SLACK && axes[k] <= begin + FRAC_PI_2 + QUARTER_SLACK
    })
}

/// The same posture with whole turns of joints 1, 4 and 6 taken off or added: into their quarter turns, or near to `near`.
fn unwound(axes: &Axes, quarters: Option<[i32; 3]>, near: &Axes) -> Axes {
    let mut turned = *axes;
    for k in 0..6 {
        let goal = match (quarters, k) {
            (Some(quarters), 0) => (f64::from(quarters[0]) + 0.5) * FRAC_PI_2,
            (Some(quarters), 3) => (f64::from(quarters[1]) + 0.5) * FRAC_PI_2,
            (Some(quarters), 5) => (f64::from(quarters[2]) + 0.5) * FRAC_PI_2,
            _ => near[k],
        };
        turned[k] += TAU * ((goal - turned[k]) / TAU).round();
    }
    turned
}

/// Postures from which Newton's method finds those of an arm: both sides of shoulder, elbow and wrist, beside the given one.
fn seeds(near: &Axes) -> Vec<Axes> {
    let mut seeds = vec![*near];
    for shoulder in [0.0, PI] {
        for (lift, elbow) in [(-1.0, 1.5), (1.0, -1.5), (0.5, 0.5), (-2.0, -1.0), (0.7, 1.2), (-0.7, -0.6)] {
            for (roll, wrist) in [(0.0, 1.0), (PI, -1.0), (0.0, -1.0)] {
                let mut seed = *near;
                (seed[0], seed[1], seed[2]) = (near[0] + shoulder, lift, elbow);
                (seed[3], seed[4]) = (near[3] + roll, wrist);
                seeds.push(seed);
            }
        }
    }
    seeds
}
