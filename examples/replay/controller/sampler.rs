//! From pieces with their laws to ticks of a clock.
//!
//! An S-curve is a trapezoid whose way is averaged over the ramp: that bounds the jerk by the acceleration over the ramp, keeps the path, and takes
//! the ramp longer from stop to stop. Speed in a corner may be above that of the trapezoid by what the average takes from beside it.

use super::super::axes::Axes;
use super::super::machine::{Machine, ToolFrames};
use super::super::program::command::{Place, Signal};
use super::follower::Loop;
use super::law::Law;
use super::model::ControllerModel;
use super::piece::Piece;
use super::tick::Tick;
use std::collections::VecDeque;

/// Receives ticks.
pub type Sink<'s> = dyn FnMut(&Tick) + 's;

/// Walks along pieces.
#[derive(Debug)]
pub struct Sampler<'a> {
    machine: &'a Machine,
    /// The frames of the program, for lines.
    pub frames: Option<ToolFrames>,
    tick_s: f64,
    ticks: u64,
    /// Seconds up to the end of all that was given.
    pub now: f64,
    /// Way of all pieces so far, and those that are not passed, each with where it begins.
    total: f64,
    pieces: VecDeque<(f64, Piece)>,
    /// The last ways, over which an S-curve averages.
    ramp: VecDeque<f64>,
    ramp_ticks: usize,
    axes: Axes,
    place: Place,
    extruder: Extruder,
    /// Filament of moves that are passed, and what ticks have had of it.
    passed_mm: f64,
    given_mm: f64,
    is_lost: bool,
    streams: bool,
}

/// The extruder by its signals.
#[derive(Clone, Copy, Debug, Default)]
struct Extruder {
    /// `None`: no signal has switched it; it runs where it has a speed.
    on: Option<bool>,
    mm_s: f64,
}

impl Extruder {
    fn runs(&self) -> bool {
        self.on.unwrap_or(self.mm_s > 0.0)
    }
}

impl<'a> Sampler<'a> {
    /// At rest, somewhere.
    pub fn new(machine: &'a Machine, model: &ControllerModel) -> Self {
        Sampler {
            machine,
            frames: None,
            tick_s: model.tick_s(),
            ticks: 0,
            now: 0.0,
            total: 0.0,
            pieces: VecDeque::new(),
            ramp: VecDeque::new(),
            ramp_ticks: model.ramp_ticks(),
            axes: [0.0; 8],
            place: Place::default(),
            extruder: Extruder::default(),
            passed_mm: 0.0,
            given_mm: 0.0,
            is_lost: true,
            streams: false,
        }
    }

    /// Whether the extruder runs by its signals.
    pub fn extrudes(&self) -> bool {
        self.extruder.runs()
    }

    /// The machine is somewhere else, by a way that is not known.
    pub fn jump(&mut self, axes: Axes, place: Place) {
        (self.axes, self.place, self.is_lost) = (axes, place, true);
    }

    /// Filament of a move that is over before it begins: it comes with the next tick.
    pub fn give(&mut self, filament_mm: f64) {
        self.passed_mm += filament_mm;
    }

    /// A signal at rest, or within a stream.
    pub fn signal(&mut self, signal: Signal) {
        match signal {
            Signal::Extruder(on) => self.extruder.on = Some(on),
            Signal::Filament(mm_s) => self.extruder.mm_s = mm_s,
        }
    }

    /// A piece and its law.
    pub fn push(&mut self, law: &Law, piece: Piece, sink: &mut Sink) {
        let begin = self.total;
        self.total += piece.way;
        self.pieces.push_back((begin, piece));
        let end = self.now + law.seconds();
        while let Some(time) = self.next_by(end) {
            let way = begin + law.at(time - self.now);
            self.emit(way, time, sink);
        }
        self.now = end;
    }

    /// The time of the next tick, if it is not later than `end`.
    fn next_by(&self, end: f64) -> Option<f64> {
        let time = self.ticks as f64 * self.tick_s;
        (time <= end + 1e-9 * self.tick_s).then_some(time)
    }

    /// Comes to rest: an S-curve ends its ramp, and signals come that wait for it.
    pub fn settle(&mut self, sink: &mut Sink) {
        if self.pieces.is_empty() {
            return;
        }
        let end = self.now + self.ramp_ticks as f64 * self.tick_s;
        while let Some(time) = self.next_by(end) {
            self.emit(self.total, time, sink);
        }
        self.now = end;
        self.pass(f64::INFINITY);
        self.ramp.clear();
    }

    /// Passes pieces that end by `way`.
    fn pass(&mut self, way: f64) {
        while let Some((begin, piece)) = self.pieces.front_mut() {
            let due = piece.signals.iter().take_while(|(at, _)| *begin + at <= way).count();
            let signals: Vec<Signal> = piece.signals.drain(..due).map(|(_, signal)| signal).collect();
            let is_passed = *begin + piece.way < way;
            let (filament, end) = (piece.filament_at(piece.way), piece.end());
            signals.into_iter().for_each(|signal| self.signal(signal));
            if !is_passed {
                break;
            }
            self.passed_mm += filament;
            self.axes = end.unwrap_or(self.axes);
            self.pieces.pop_front();
        }
    }

    /// A tick when the unfiltered way is `raw`.
    fn emit(&mut self, raw: f64, time: f64, sink: &mut Sink) {
        let way = self.averaged(raw);
        self.pass(way);
        let (mut filament, mut lays, mut blend_mm) = (self.passed_mm, false, 0.0);
        if let Some((begin, piece)) = self.pieces.front() {
            let u = (way - begin).clamp(0.0, piece.way);
            self.axes = piece.axes_at(u, self.machine, self.frames.as_ref(), &self.axes);
            filament += piece.filament_at(u);
            (self.place, lays, blend_mm) = (piece.place_at(u), piece.extrudes(u), piece.blend_mm());
        }
        let by_moves = filament - self.given_mm;
        self.given_mm = filament;
        self.tick(time, by_moves, lays, blend_mm, sink);
    }

    fn averaged(&mut self, raw: f64) -> f64 {
        if self.ramp_ticks == 0 {
            return raw;
        }
        if self.ramp.is_empty() {
            let begin = self.pieces.front().map_or(raw, |(begin, _)| *begin);
            self.ramp.resize(self.ramp_ticks, begin);
        }
        self.ramp.push_back(raw);
        self.ramp.pop_front();
        self.ramp.iter().sum::<f64>() / self.ramp_ticks as f64
    }

    fn tick(&mut self, seconds: f64, by_moves: f64, lays: bool, blend_mm: f64, sink: &mut Sink) {
        let runs = self.extruder.runs();
        let filament_mm = by_moves + if runs { self.extruder.mm_s * self.tick_s } else { 0.0 };
        let jumped = std::mem::take(&mut self.is_lost);
        let extrudes = runs || lays;
        let (axes, place, streams) = (self.axes, self.place, self.streams);
        sink(&Tick { seconds, axes, filament_mm, extrudes, place, blend_mm, streams, jumped });
        self.ticks += 1;
    }

    /// Rests for so many seconds.
    pub fn rest(&mut self, seconds: f64, place: Place, sink: &mut Sink) {
        self.place = place;
        let end = self.now + seconds;
        while let Some(time) = self.next_by(end) {
            let by_moves = self.passed_mm - self.given_mm;
            self.given_mm = self.passed_mm;
            self.tick(time, by_moves, false, 0.0, sink);
        }
        self.now = end;
    }

    /// One of a stream of targets.
    pub fn follow(&mut self, arm: &mut Loop, target: [&Axes; 2], seconds: f64, place: Place, sink: &mut Sink) {
        (self.place, self.streams) = (place, true);
        let (begin, end) = (self.now, self.now + seconds);
        let at = |time: f64| {
            let share = ((time - begin) / seconds).clamp(0.0, 1.0);
            std::array::from_fn(|k| target[0][k] + share * (target[1][k] - target[0][k]))
        };
        let mut before: Axes = *target[0];
        let mut since = begin;
        while let Some(time) = self.next_by(end) {
            let here = at(time);
            arm.advance([&before, &here], (time - since).max(0.0));
            (before, since) = (here, time);
            self.axes = *arm.at();
            self.tick(time, 0.0, false, 0.0, sink);
        }
        if end > since {
            arm.advance([&before, target[1]], end - since);
        }
        self.now = end;
        (self.axes, self.streams) = (*arm.at(), false);
    }
}
