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
                    (Path::Tip { from, to }, Path::Tip { from: corner, to: on }) => {
                        let (one, two) = (Path::axes_at(from, to, first), Path::axes_at(corner, on, second));
                        under_tip(machine, &std::array::from_fn(|k| one[k] + two[k] - corner[k]), near)
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

    /// Whether material comes out with the move.
    pub fn extrudes(&self, u: f64) -> bool {
        self.segment_at(u).extrudes
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

fn under_tip(machine: &Machine, program: &Axes, near: &Axes) -> Axes {
    match machine {
        Machine::FiveAxis(printer) => printer.under_tip(program),
        Machine::Robot(_) => *near,
    }
}

fn of_segment(segment: &Segment, share: f64, machine: &Machine, frames: Option<&ToolFrames>, near: &Axes) -> Axes {
    match &segment.path {
        Path::Axes { from, to } => Path::axes_at(from, to, share),
        Path::Tip { from, to } => under_tip(machine, &Path::axes_at(from, to, share), near),
        Path::Line { from, to, turn, table } => {
            solved(machine, frames, &line_at(from, to, turn, share), table_at(table, share), near)
        }
    }
}

/// The greatest speed and change of speed that limits of axes and tip permit on a piece, as shares of the programmed speed.
pub fn pace(shape: &Shape, speeds: &Axes, accelerations: &Axes, tip: [f64; 2], most: f64) -> [f64; 2] {
    match shape {
        Shape::Straight { segment, .. } => {
            let tip_speed = segment.tip().map_or(0.0, |tip| tip.norm());
            let mut top = most.min(share_of(tip[0], tip_speed));
            for k in 0..MAX_AXES {
                let bent = (CORNER_SHARE * share_of(accelerations[k], segment.bends[k])).sqrt();
                top = top.min(share_of(speeds[k], segment.max_rates[k])).min(bent);
            }
            let mut rate = share_of(tip[1], tip_speed);
            for (k, acceleration) in accelerations.iter().enumerate() {
                let left = acceleration - segment.bends[k] * top * top;
                rate = rate.min(share_of(left, segment.max_rates[k]));
            }
            [top, rate.min(MAX_RATE)]
        }
        Shape::Blend { before, after, reach } => {
            let rates: Axes = std::array::from_fn(|k| before.rates[1][k].abs().max(after.rates[0][k].abs()));
            let (first, second) = (before.tip(), after.tip());
            let tip_speed = [first, second].into_iter().flatten().map(|tip| tip.norm()).fold(0.0, f64::max);
            let turned = first.zip(second).map_or(0.0, |(first, second)| (second - first).norm() / (2.0 * reach));
            // Along the parabola the speed changes evenly: the square of the share bounds that.
            let mut square = share_of(tip[1], turned);
            let (mut top, mut rate) = (most.min(share_of(tip[0], tip_speed)), share_of(tip[1], tip_speed));
            for k in 0..MAX_AXES {
                let change = (after.rates[0][k] - before.rates[1][k]).abs() / (2.0 * reach);
                square = square.min(share_of(accelerations[k], change + before.bends[k].max(after.bends[k])));
                top = top.min(share_of(speeds[k], rates[k]));
                rate = rate.min(share_of(accelerations[k], rates[k]));
            }
            top = top.min((CORNER_SHARE * square).sqrt());
            [top, ((1.0 - CORNER_SHARE) * rate).min(MAX_RATE)]
        }
    }
}

/// Which share of what would be used is permitted; without end where nothing is used.
fn share_of(limit: f64, used: f64) -> f64 {
    if used > 0.0 { limit / used } else { f64::INFINITY }
}

/// In a blend the direction changes, and the speed may as well: the share of an acceleration that is left to the first of both. With all of it the corner is at its
/// fastest, and speed can only change beside it.
const CORNER_SHARE: f64 = 0.7;
/// A change of speed that is as good as a jump, in shares a second.
const MAX_RATE: f64 = 1e9;
