//! Executes commands.

use super::super::axes::{Axes, Limits, MAX_AXES};
use super::super::machine::{Machine, Reached, ToolFrames};
use super::super::program::command::{Command, Goal, Motion, Place, Signal, Speed, Target, Zone};
use super::corner;
use super::follower::Loop;
use super::model::ControllerModel;
use super::piece::{Piece, Shape, pace};
use super::sampler::{Sampler, Sink};
use super::segment::{self, Path, Segment};
use super::window::{Pace, Window};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::rc::Rc;

/// What a controller could not do, or did otherwise than the program says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstacles {
    /// Targets out of reach, the farthest miss in millimetres, and where.
    pub missed: (u64, f64, Place),
    /// Blend zones that were cut, and the first.
    pub cut: (u64, Option<Place>),
    /// Targets whose quarter turns the arm is not in, and the first.
    pub turned: (u64, Option<Place>),
    /// Moves and waits of more than a day, which are left out, and the first.
    pub endless: (u64, Option<Place>),
    /// Moves and steps of streams.
    pub moves: u64,
}

/// A controller at work.
pub struct Controller<'a> {
    model: ControllerModel,
    /// Greatest acceleration of the tip by the model.
    tip_mm_s2: f64,
    machine: &'a Machine,
    /// Limits of the machine, and what the controller asks for.
    limits: Limits,
    window: Window<Piece>,
    sampler: Sampler<'a>,
    /// The last move, and how much of it a blend has taken.
    last: Option<(Rc<Segment>, f64)>,
    /// Signals behind it.
    signals: Vec<Signal>,
    /// Where the last move ends; `None`: not known.
    at: Option<Axes>,
    stream: Option<(Loop, Axes)>,
    /// Seconds at the programmed speeds.
    pub programmed_s: f64,
    /// What it could not do.
    pub obstacles: Obstacles,
}

/// Moves that are shorter than this take no time: seconds at the programmed speed.
const NO_MOVE: f64 = 1e-9;
/// Longest move or wait, in seconds: more is a slip of the pen, and would be looked at tick by tick.
const MAX_SECONDS: f64 = 86_400.0;
/// Lines that are shorter than this only turn, in millimetres.
const ONLY_TURNS_MM: f64 = 1e-6;
/// Chords along the way of the tip on a move by joints.
const CHORDS: u32 = 8;
/// A stream that ends is waited for at most this many lags.
const MAX_LAGS: f64 = 40.0;
/// Joints may be this far beyond a quarter turn: rounding of targets, in radians.
const QUARTER_SLACK: f64 = 0.02;

impl<'a> Controller<'a> {
    /// At rest, somewhere.
    pub fn new(model: &ControllerModel, machine: &'a Machine) -> Self {
        let mut limits = *machine.limits();
        for k in 0..MAX_AXES {
            limits.acceleration[k] = limits.acceleration[k].min(model.joint_rad_s2);
        }
        Controller {
            model: *model,
            tip_mm_s2: model.tip_mm_s2,
            machine,
            limits,
            // Each move is a part of a segment and a blend.
            window: Window::new(2 * model.look_ahead),
            sampler: Sampler::new(machine, model),
            last: None,
            signals: Vec::new(),
            at: None,
            stream: None,
            programmed_s: 0.0,
            obstacles: Obstacles::default(),
        }
    }

    /// The frames that targets refer to from here on: a program begins, once the one before has come to rest.
    pub fn set_frames(&mut self, frames: ToolFrames, sink: &mut Sink) {
        self.halt(Place::default(), sink);
        self.sampler.frames = Some(frames);
    }

    /// The acceleration of the path that the program asks for, in mm/s2, unless the model has less.
    pub fn set_acceleration(&mut self, mm_s2: f64) {
        self.model.tip_mm_s2 = self.tip_mm_s2.min(mm_s2);
    }

    /// Seconds so far.
    pub fn seconds(&self) -> f64 {
        self.sampler.now
    }

    /// Whether the extruder runs by its signals.
    pub fn extrudes(&self) -> bool {
        self.sampler.extrudes()
    }

    /// Takes a command.
    pub fn command(&mut self, place: Place, command: &Command, sink: &mut Sink) {
        match command {
            Command::Servo { axes, seconds } => self.servo(place, axes, *seconds, sink),
            Command::Signal(signal) if self.stream.is_some() => self.sampler.signal(*signal),
            Command::Signal(signal) => self.signals.push(*signal),
            Command::Move(motion) => {
                self.end_stream(place, sink);
                self.obstacles.moves += 1;
                self.motion(place, motion, sink);
            }
            Command::Rest(seconds) => {
                self.halt(place, sink);
                if *seconds > MAX_SECONDS {
                    self.endless(place);
                    return;
                }
                self.sampler.rest(*seconds, place, sink);
                self.programmed_s += seconds;
            }
            Command::Lost => {
                self.halt(place, sink);
                self.at = None;
            }
        }
    }

    /// Comes to rest.
    pub fn halt(&mut self, place: Place, sink: &mut Sink) {
        self.end_stream(place, sink);
        if let Some((segment, begun)) = self.last.take() {
            let way = segment.seconds - begun;
            self.straight(&segment, begun, way, sink);
        }
        let sampler = &mut self.sampler;
        self.window.stop(&mut |law, piece| sampler.push(&law, piece, sink));
        sampler.settle(sink);
        self.signals.drain(..).for_each(|signal| sampler.signal(signal));
    }

    fn motion(&mut self, place: Place, motion: &Motion, sink: &mut Sink) {
        let Some(begin) = self.at else {
            self.begin(place, motion, sink);
            return;
        };
        let Some(segment) = self.segment(place, motion, &begin) else {
            // Nothing moves: what stops there stops the move before.
            if motion.zone == Zone::Stop {
                self.halt(place, sink);
            }
            return;
        };
        self.at = Some(segment.ends[1]);
        if segment.seconds > MAX_SECONDS {
            self.endless(place);
            self.halt(place, sink);
            self.sampler.jump(segment.ends[1], place);
            return;
        }
        self.programmed_s += segment.seconds;
        let segment = Rc::new(segment);
        let Some((before, begun)) = self.last.take() else {
            // At rest.
            self.signals.drain(..).for_each(|signal| self.sampler.signal(signal));
            self.last = Some((segment, 0.0));
            return;
        };
        let (reach, is_cut) = corner::reach(&before, &segment, self.machine, self.model.corner_mm);
        if is_cut {
            self.obstacles.cut = (self.obstacles.cut.0 + 1, self.obstacles.cut.1.or(Some(before.place)));
        }
        if reach <= NO_MOVE {
            self.last = Some((before, begun));
            self.halt(place, sink);
            self.last = Some((segment, 0.0));
            return;
        }
        self.straight(&before, begun, before.seconds - begun - reach, sink);
        self.blend(before, segment.clone(), reach, sink);
        self.last = Some((segment, reach));
    }

    fn straight(&mut self, segment: &Rc<Segment>, from: f64, way: f64, sink: &mut Sink) {
        if way > NO_MOVE * segment.seconds {
            let shape = Shape::Straight { segment: segment.clone(), from };
            self.piece(Piece { shape, way, signals: Vec::new() }, sink);
        }
    }

    fn blend(&mut self, before: Rc<Segment>, after: Rc<Segment>, reach: f64, sink: &mut Sink) {
        let at = 2.0 * reach * self.model.signal_share;
        let signals = self.signals.drain(..).map(|signal| (at, signal)).collect();
        self.piece(Piece { shape: Shape::Blend { before, after, reach }, way: 2.0 * reach, signals }, sink);
    }

    fn piece(&mut self, piece: Piece, sink: &mut Sink) {
        let Limits { speed, acceleration, .. } = &self.limits;
        let tip = [self.model.tip_mm_s, self.model.tip_mm_s2];
        let [top, rate] = pace(&piece.shape, speed, acceleration, tip, self.model.speed_share);
        let pace = Pace { way: piece.way, top, rate };
        if pace.way > MAX_SECONDS * top {
            let place = piece.place_at(0.0);
            self.endless(place);
            return;
        }
        let sampler = &mut self.sampler;
        self.window.push(pace, piece, &mut |law, piece| sampler.push(&law, piece, sink));
    }

    fn endless(&mut self, place: Place) {
        let (count, first) = self.obstacles.endless;
        self.obstacles.endless = (count + 1, first.or(Some(place)));
    }

    /// The first move, whose begin is not known: it is where that ends.
    fn begin(&mut self, place: Place, motion: &Motion, sink: &mut Sink) {
        self.signals.drain(..).for_each(|signal| self.sampler.signal(signal));
        let axes = match &motion.goal {
            Goal::Axes(axes) => *axes,
            Goal::Pose(target) | Goal::Line(target) => self.posture(place, target, &[0.0; MAX_AXES], true),
        };
        self.at = Some(axes);
        self.sampler.jump(axes, place);
        self.sampler.rest(0.0, place, sink);
    }

    /// The segment of a move; `None` where nothing moves.
    fn segment(&mut self, place: Place, motion: &Motion, begin: &Axes) -> Option<Segment> {
        let segment = match &motion.goal {
            Goal::Axes(axes) => self.by_axes(begin, axes, &motion.speed),
            Goal::Pose(target) => {
                let axes = self.posture(place, target, begin, false);
                self.by_axes(begin, &axes, &motion.speed)
            }
            Goal::Line(target) => self.line(place, target, begin, &motion.speed)?,
        };
        let seconds = segment.seconds;
        (seconds > NO_MOVE && seconds.is_finite()).then_some(Segment {
            filament_mm: motion.filament_mm,
            zone: motion.zone,
            place,
            ..segment
        })
    }

    fn by_axes(&self, from: &Axes, to: &Axes, speed: &Speed) -> Segment {
        let way: Axes = std::array::from_fn(|k| (to[k] - from[k]).abs());
        let linear = way[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
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
    fn posture(&mut self, place: Place, target: &Target, near: &Axes, is_first: bool) -> Axes {
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
        let Obstacles { missed, turned, .. } = &mut self.obstacles;
        if !reached.is_reached() {
            let worse = off_mm > missed.1;
            *missed = (missed.0 + 1, missed.1.max(off_mm), if worse { place } else { missed.2 });
        } else if target.quarters.is_some_and(|quarters| !in_quarters(axes, &quarters)) {
            *turned = (turned.0 + 1, turned.1.or(Some(place)));
        }
    }

    fn servo(&mut self, place: Place, axes: &Axes, seconds: f64, sink: &mut Sink) {
        self.obstacles.moves += 1;
        self.programmed_s += seconds;
        let Some(at) = self.at else {
            self.at = Some(*axes);
            self.sampler.jump(*axes, place);
            return;
        };
        if self.stream.is_none() {
            self.halt(place, sink);
            self.stream = Some((Loop::new(self.model.follower, self.model.lag_s, at), at));
        }
        if let Some((arm, target)) = &mut self.stream {
            self.sampler.follow(arm, [target, axes], seconds, place, sink);
            *target = *axes;
        }
        self.at = Some(*axes);
    }

    /// The arm comes to where its stream has ended.
    fn end_stream(&mut self, place: Place, sink: &mut Sink) {
        let Some((mut arm, target)) = self.stream.take() else { return };
        let tick = self.model.tick_s();
        for _ in 0..(MAX_LAGS * self.model.lag_s / tick).ceil() as u64 {
            if arm.is_at(&target) {
                break;
            }
            self.sampler.follow(&mut arm, [&target, &target], tick, place, sink);
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
