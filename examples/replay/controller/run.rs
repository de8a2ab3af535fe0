//! Executes commands.

use super::super::axes::{Axes, Limits, MAX_AXES};
use super::super::machine::{Machine, ToolFrames};
use super::super::program::command::{Command, Goal, Motion, Place, Signal, Zone};
use super::corner;
use super::follower::Loop;
use super::model::ControllerModel;
use super::obstacles::{ControllerFault, MAX_DAYS, Obstacles};
use super::piece::{Piece, Shape, pace};
use super::sampler::{Sampler, Sink};
use super::segment::Segment;
use super::window::{Pace, Window};
use std::rc::Rc;

/// A controller at work.
pub struct Controller<'a> {
    pub(super) model: ControllerModel,
    /// Greatest acceleration of the tip by the model.
    tip_mm_s2: f64,
    pub(super) machine: &'a Machine,
    /// Limits of the machine, and what the controller asks for.
    pub(super) limits: Limits,
    window: Window<Piece>,
    pub(super) sampler: Sampler<'a>,
    /// The last move, and how much of it a blend has taken.
    last: Option<(Rc<Segment>, f64)>,
    /// Signals behind it.
    signals: Vec<Signal>,
    /// Where the last move ends; `None`: not known.
    at: Option<Axes>,
    stream: Option<(Loop, Axes)>,
    /// Seconds of all waits.
    waited_s: f64,
    /// Seconds at the programmed speeds.
    pub programmed_s: f64,
    /// What it could not do.
    pub obstacles: Obstacles,
}

/// Moves that are shorter than this take no time: seconds at the programmed speed.
pub const NO_MOVE: f64 = 1e-9;
/// Longest move or wait, in seconds: more is a slip of the pen, and would be looked at tick by tick.
const MAX_SECONDS: f64 = 86_400.0;
/// A stream that ends is waited for at most this many lags.
const MAX_LAGS: f64 = 40.0;

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
            waited_s: 0.0,
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
    ///
    /// # Errors
    /// [`ControllerFault`]: waits, or all commands, take longer than any print.
    pub fn command(&mut self, place: Place, command: &Command, sink: &mut Sink) -> Result<(), ControllerFault> {
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
                let waited_s = self.waited_s + seconds;
                if waited_s > MAX_SECONDS {
                    return Err(ControllerFault::Waits { seconds: waited_s });
                }
                self.waited_s = waited_s;
                self.sampler.rest(*seconds, place, sink);
                self.programmed_s += seconds;
            }
            Command::Lost => {
                self.halt(place, sink);
                self.at = None;
            }
        }
        let days = self.seconds() / MAX_SECONDS;
        if days > MAX_DAYS { Err(ControllerFault::Long { days }) } else { Ok(()) }
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
            Goal::Axes(axes) => self.positions(axes),
            Goal::Nozzle(pose) => self.under_vector(place, pose, &[0.0; MAX_AXES]).1,
            Goal::Pose(target) | Goal::Line(target) => self.posture(place, target, &[0.0; MAX_AXES], true),
        };
        self.at = Some(axes);
        self.sampler.jump(axes, place);
        self.sampler.give(motion.filament_mm);
        self.sampler.rest(0.0, place, sink);
    }

    fn servo(&mut self, place: Place, axes: &Axes, seconds: f64, sink: &mut Sink) {
        self.obstacles.moves += 1;
        if seconds > MAX_SECONDS {
            self.endless(place);
            return;
        }
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
