//! A move as a path with its time at the programmed speed.

use super::super::axes::{Axes, Frame, MAX_AXES};
use super::super::machine::{FiveAxis, Robot, ToolFrames};
use super::super::program::command::{Place, Zone};
use nalgebra::Vector3;

/// The way of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// All axes evenly.
    Axes {
        /// Where it begins.
        from: Axes,
        /// Where it ends.
        to: Axes,
    },
    /// The tool straight in the work object, turning evenly, and the table evenly.
    Line {
        /// Pose at its begin.
        from: Frame,
        /// Place at its end.
        to: Vector3<f64>,
        /// The turn from begin to end, in the frame of the tool.
        turn: Vector3<f64>,
        /// The table at begin and end.
        table: [[f64; 2]; 2],
    },
    /// The tip straight on the part and the rotary axes evenly: a printer whose controller knows the tip.
    Tip {
        /// Tip and readings of the rotary axes at its begin.
        from: Axes,
        /// The same at its end.
        to: Axes,
    },
}

/// A move that the controller has taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its way.
    pub path: Path,
    /// Its time at the programmed speed.
    pub seconds: f64,
    /// Axes at its begin and its end.
    pub ends: [Axes; 2],
    /// Speeds of the axes at its begin and its end, at the programmed speed.
    pub rates: [Axes; 2],
    /// Greatest speeds on the way.
    pub max_rates: Axes,
    /// Greatest changes of speed on the way, in a second, at the programmed speed: the axes bend under a tip that goes straight.
    pub bends: Axes,
    /// Length of the way of the tip, in millimetres.
    pub length_mm: f64,
    /// Filament on the way.
    pub filament_mm: f64,
    /// Whether material comes out on the way.
    pub extrudes: bool,
    /// How it ends.
    pub zone: Zone,
    /// Which command it is.
    pub place: Place,
}

impl Path {
    /// The axes of a way by axes.
    pub fn axes_at(from: &Axes, to: &Axes, share: f64) -> Axes {
        std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
    }
}

/// The pose on a line, after `share` of the way.
pub fn line_at(from: &Frame, to: &Vector3<f64>, turn: &Vector3<f64>, share: f64) -> Frame {
    Frame { turn: from.turn * turned(turn, share), at: from.at + (to - from.at) * share }
}

/// A share of a turn.
pub fn turned(turn: &Vector3<f64>, share: f64) -> nalgebra::Matrix3<f64> {
    let angle = turn.norm();
    if angle * share.abs() < 1e-15 {
        return nalgebra::Matrix3::identity();
    }
    Frame::rotation(&(turn / angle), angle * share).turn
}

/// The table after `share` of the way.
pub fn table_at(table: &[[f64; 2]; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| table[0][k] + share * (table[1][k] - table[0][k]))
}

/// Where along a line joints are computed ahead: at least every so many millimetres and radians, in at most so many parts.
const PART_MM: f64 = 5.0;
const PART_RAD: f64 = 0.1;
const MAX_PARTS: f64 = 64.0;

/// The line of a robot from where it is, and by how many millimetres its end is missed; its time is not known yet.
pub fn line(robot: &Robot, frames: &ToolFrames, begin: &Axes, target: &Frame, table: [f64; 2]) -> (Segment, f64) {
    let from = robot.target_at(frames, begin);
    let turn = from.turn_to(target);
    let tables = [[begin[6], begin[7]], table];
    let length = (target.at - from.at).norm();
    let swing = (0..2).map(|k| (tables[1][k] - tables[0][k]).abs()).fold(turn.norm(), f64::max);
    let parts = (length / PART_MM).max(swing / PART_RAD).ceil().clamp(1.0, MAX_PARTS);
    let mut axes = *begin;
    let (mut rates, mut max_rates, mut missed) = ([[0.0; MAX_AXES]; 2], [0.0; MAX_AXES], 0.0f64);
    for part in 1..=parts as u32 {
        let share = f64::from(part) / parts;
        let before = axes;
        [axes[6], axes[7]] = table_at(&tables, share);
        let reached = robot.solve(frames, &line_at(&from, &target.at, &turn, share), &axes);
        missed = missed.max(reached.off_mm);
        axes = reached.axes;
        let rate: Axes = std::array::from_fn(|k| (axes[k] - before[k]) * parts);
        if part == 1 {
            rates[0] = rate;
        }
        rates[1] = rate;
        (0..MAX_AXES).for_each(|k| max_rates[k] = f64::max(max_rates[k], rate[k].abs()));
    }
    let path = Path::Line { from, to: target.at, turn, table: tables };
    let segment = Segment {
        path,
        seconds: 1.0,
        ends: [*begin, axes],
        rates,
        max_rates,
        bends: [0.0; MAX_AXES],
        length_mm: length,
        filament_mm: 0.0,
        extrudes: false,
        zone: Zone::Stop,
        place: Place::default(),
    };
    (segment, missed)
}

/// The line of the tip of a printer whose controller knows it, to a tip and readings of the rotary axes; its time is not known yet.
pub fn tip_line(printer: &FiveAxis, begin: &Axes, to: &Axes) -> Segment {
    let from = printer.of_tip(begin);
    let way: Axes = std::array::from_fn(|k| to[k] - from[k]);
    let length = Vector3::new(way[0], way[1], way[2]).norm();
    let swing = way[3].abs().max(way[4].abs());
    // Two at least: a change of speed needs them.
    let parts = (length / PART_MM).max(swing / PART_RAD).ceil().clamp(2.0, MAX_PARTS);
    let (mut axes, mut rates, mut max_rates) = (*begin, [[0.0; MAX_AXES]; 2], [0.0; MAX_AXES]);
    let mut bends = [0.0; MAX_AXES];
    for part in 1..=parts as u32 {
        let before =
            std::mem::replace(&mut axes, printer.under_tip(&Path::axes_at(&from, to, f64::from(part) / parts)));
        let rate: Axes = std::array::from_fn(|k| (axes[k] - before[k]) * parts);
        if part == 1 {
            rates = [rate; 2];
        }
        for k in 0..MAX_AXES {
            bends[k] = f64::max(bends[k], (rate[k] - rates[1][k]).abs() * parts);
            max_rates[k] = f64::max(max_rates[k], rate[k].abs());
        }
        rates[1] = rate;
    }
    // Speeds at the ends are those of the middles of the parts there, and half a part on.
    (0..MAX_AXES).for_each(|k| max_rates[k] += 0.5 * bends[k] / parts);
    Segment {
        path: Path::Tip { from, to: *to },
        ends: [*begin, axes],
        rates,
        max_rates,
        bends,
        ..by_axes(begin, &axes, length)
    }
}

/// A move of all axes; its time is not known yet.
pub fn by_axes(from: &Axes, to: &Axes, length_mm: f64) -> Segment {
    let way: Axes = std::array::from_fn(|k| to[k] - from[k]);
    Segment {
        path: Path::Axes { from: *from, to: *to },
        seconds: 1.0,
        ends: [*from, *to],
        rates: [way; 2],
        max_rates: way.map(f64::abs),
        bends: [0.0; MAX_AXES],
        length_mm,
        filament_mm: 0.0,
        extrudes: false,
        zone: Zone::Stop,
        place: Place::default(),
    }
}

impl Segment {
    /// The same in so many seconds.
    pub fn within(mut self, seconds: f64) -> Self {
        let scale = self.seconds / seconds;
        self.rates.iter_mut().chain([&mut self.max_rates]).flatten().for_each(|rate| *rate *= scale);
        self.bends.iter_mut().for_each(|bend| *bend *= scale * scale);
        self.seconds = seconds;
        self
    }

    /// Speed of the tip on a line, in mm/s; `None` by axes.
    pub fn tip(&self) -> Option<Vector3<f64>> {
        match &self.path {
            Path::Line { from, to, .. } => Some((to - from.at) / self.seconds),
            Path::Tip { from, to } => Some(Vector3::from_fn(|k, _| to[k] - from[k]) / self.seconds),
            Path::Axes { .. } => None,
        }
    }
}
