//! Pieces of the way: what a blend leaves of a segment, and blends.
//!
//! A blend takes as long on both segments. There the part of the first one ends evenly slower and that of the second one begins evenly faster, so
//! axes, or tip and turn of a line, are a parabola in time (linear segments with parabolic blends; R. Paul, *Robot Manipulators*, MIT Press 1981,
//! section 5.2).

use super::super::axes::{Axes, Frame, MAX_AXES};
use super::super::machine::{Machine, ToolFrames};
use super::super::program::command::{Place, Signal};
use super::segment::{Path, Segment, line_at, table_at, turned};
use std::rc::Rc;

/// Which way.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A part of a segment, from so many of its seconds on.
    Straight {
        /// The segment.
        segment: Rc<Segment>,
        /// Where the part begins.
        from: f64,
    },
    /// The corner between two segments.
    Blend {
        /// The one that ends.
        before: Rc<Segment>,
        /// The one that begins.
        after: Rc<Segment>,
        /// Seconds of each.
        reach: f64,
    },
}

/// A piece.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its way.
    pub shape: Shape,
    /// Seconds at the programmed speed.
    pub way: f64,
    /// Signals on it, each with where it comes.
    pub signals: Vec<(f64, Signal)>,
}

impl Piece {
    /// Where axes are after `u` seconds of the way. Joints of a line are those near `near`.
    pub fn axes_at(&self, u: f64, machine: &Machine, frames: Option<&ToolFrames>, near: &Axes) -> Axes {
        match &self.shape {
            Shape::Straight { segment, from } => {
                of_segment(segment, (from + u) / segment.seconds, machine, frames, near)
            }
            Shape::Blend { before, after, reach } => {
                let [first, second] = shares(u / self.way, *reach, before, after);
                match (&before.path, &after.path) {
                    (Path::Line { .. }, Path::Line { .. }) => {
                        let (pose, table) = between_lines(before, first, after, second);
                        solved(machine, frames, &pose, table, near)
                    }
                    _ => {
                        let one = of_segment(before, first, machine, frames, near);
                        let two = of_segment(after, second, machine, frames, near);
                        std::array::from_fn(|k| one[k] + two[k] - after.ends[0][k])
                    }
                }
            }
        }
    }

    /// Filament up to `u` seconds of the way, in millimetres.
    pub fn filament_at(&self, u: f64) -> f64 {
        let rate = |segment: &Segment| segment.filament_mm / segment.seconds;
        match &self.shape {
            Shape::Straight { segment, .. } => rate(segment) * u,
            Shape::Blend { before, after, reach } => {
                let share = (u / self.way).clamp(0.0, 1.0);
                reach * (rate(before) * (1.0 - (1.0 - share).powi(2)) + rate(after) * share.powi(2))
            }
        }
    }

    /// The segment under way after `u` seconds.
    fn segment_at(&self, u: f64) -> &Segment {
        match &self.shape {
            Shape::Straight { segment, .. } => segment,
            Shape::Blend { before, .. } if u < 0.5 * self.way => before,
            Shape::Blend { after, .. } => after,
        }
    }

    /// The command under way.
    pub fn place_at(&self, u: f64) -> Place {
        self.segment_at(u).place
    }

    /// Whether filament goes into the nozzle with the move.
    pub fn has_filament(&self, u: f64) -> bool {
        self.segment_at(u).filament_mm > 0.0
    }

    /// The radius of the blend, in millimetres; 0 for a part of a segment.
    pub fn blend_mm(&self) -> f64 {
        match &self.shape {
            Shape::Straight { .. } => 0.0,
            Shape::Blend { before, after, reach } => {
                let of = |segment: &Segment| segment.length_mm / segment.seconds * reach;
                of(before).max(of(after))
            }
        }
    }

    /// Axes at its end.
    pub fn end(&self) -> Option<Axes> {
        match &self.shape {
            Shape::Straight { segment, from } if from + self.way >= segment.seconds * (1.0 - 1e-12) => {
                Some(segment.ends[1])
            }
            _ => None,
        }
    }
}

/// How far both segments of a blend are after a share of it.
fn shares(share: f64, reach: f64, before: &Segment, after: &Segment) -> [f64; 2] {
    let share = share.clamp(0.0, 1.0);
    [1.0 - reach / before.seconds * (1.0 - share).powi(2), reach / after.seconds * share.powi(2)]
}

/// The pose in a corner of two lines, and the table.
fn between_lines(before: &Segment, first: f64, after: &Segment, second: f64) -> (Frame, [f64; 2]) {
    let (Path::Line { from, to, turn, table }, Path::Line { from: corner, to: on, turn: next, table: then }) =
        (&before.path, &after.path)
    else {
        return (Frame::identity(), [0.0; 2]);
    };
    let pose = line_at(from, to, turn, first);
    let ahead = (on - corner.at) * second;
    let [one, two] = [table_at(table, first), table_at(then, second)];
    (
        Frame { turn: pose.turn * turned(next, second), at: pose.at + ahead },
        [0, 1].map(|k| one[k] + two[k] - then[0][k]),
    )
}

fn solved(machine: &Machine, frames: Option<&ToolFrames>, pose: &Frame, table: [f64; 2], near: &Axes) -> Axes {
    let (Machine::Robot(robot), Some(frames)) = (machine, frames) else { return *near };
    let mut seed = *near;
    [seed[6], seed[7]] = table;
    robot.solve(frames, pose, &seed).axes
}

fn of_segment(segment: &Segment, share: f64, machine: &Machine, frames: Option<&ToolFrames>, near: &Axes) -> Axes {
    match &segment.path {
        Path::Axes { from, to } => Path::axes_at(from, to, share),
        Path::Line { from, to, turn, table } => {
            solved(machine, frames, &line_at(from, to, turn, share), table_at(table, share), near)
        }
    }
}

/// The greatest speed and change of speed that limits of axes and tip permit on a piece, as shares of the programmed speed.
pub fn pace(shape: &Shape, speeds: &Axes, accelerations: &Axes, tip: [f64; 2], most: f64) -> [f64; 2] {
    let (mut top, mut rate) = (most, f64::INFINITY);
    let [tip_speed, tip_acceleration] = tip;
    let mut hold = |rates: &Axes, tip: Option<f64>, share: f64| {
        for k in 0..MAX_AXES {
            if rates[k] > 0.0 {
                top = top.min(speeds[k] / rates[k]);
                rate = rate.min(share * accelerations[k] / rates[k]);
            }
        }
        if let Some(tip) = tip.filter(|speed| *speed > 0.0) {
            top = top.min(tip_speed / tip);
            rate = rate.min(share * tip_acceleration / tip);
        }
    };
    match shape {
        Shape::Straight { segment, .. } => hold(&segment.max_rates, segment.tip().map(|tip| tip.norm()), 1.0),
        Shape::Blend { before, after, reach } => {
            hold(&before.rates[1].map(f64::abs), before.tip().map(|tip| tip.norm()), 1.0 - CORNER_SHARE);
            hold(&after.rates[0].map(f64::abs), after.tip().map(|tip| tip.norm()), 1.0 - CORNER_SHARE);
            // Along the parabola the speed changes evenly: the square of the share bounds that.
            let mut square = f64::INFINITY;
            for (k, acceleration) in accelerations.iter().enumerate() {
                let change = (after.rates[0][k] - before.rates[1][k]).abs();
                if change > 0.0 {
                    square = square.min(CORNER_SHARE * 2.0 * reach * acceleration / change);
                }
            }
            if let (Some(first), Some(second)) = (before.tip(), after.tip()) {
                let change = (second - first).norm();
                if change > 0.0 {
                    square = square.min(CORNER_SHARE * 2.0 * reach * tip_acceleration / change);
                }
            }
            top = top.min(square.sqrt());
        }
    }
    [top, rate.min(MAX_RATE)]
}

/// In a blend the direction changes, and the speed may as well: the share of an acceleration that is left to the first of both. With all of it the corner is at its
/// fastest, and speed can only change beside it.
const CORNER_SHARE: f64 = 0.7;
/// A change of speed that is as good as a jump, in shares a second.
const MAX_RATE: f64 = 1e9;
