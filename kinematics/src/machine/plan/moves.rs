//! What a plan takes and gives: plain data.

use nalgebra::{Point3, UnitVector3};

/// A move of the tip along the part, or something that passes through. Lengths in mm, feeds in mm/s, directions from the tip into the nozzle, in
/// the frame of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMove<T> {
    /// The tip goes somewhere on a straight line and leaves nothing on its way; the nozzle turns along a great circle.
    Travel {
        /// Where the tip arrives.
        tip: Point3<f64>,
        /// Direction of the nozzle there.
        direction: UnitVector3<f64>,
        /// Speed of the tip, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// The same with a bead, or a tape.
    Print {
        /// Where the tip arrives.
        tip: Point3<f64>,
        /// Direction of the nozzle there.
        direction: UnitVector3<f64>,
        /// Filament for this move alone, 0 to 1e6 mm; 0 for a tape.
        filament_mm: f64,
        /// Speed of the tip, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// What concerns no axis: a mark, a temperature, a retraction, a dwell. It comes out in its place.
    Pass(T),
    /// The same, and the axes are elsewhere afterwards (homing): the next move is a travel, and nothing is known of its way.
    Restart(T),
}

/// Values of the axes at the end of a straight motion of all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMove {
    /// In the order of [`FiveAxis::letters`](crate::machine::FiveAxis::letters), mm and radians, as they stand in a program.
    pub axes: [f64; 5],
    /// Time of the motion, 1e-4 s at least, without speeding up and slowing down but for lifted ones.
    pub seconds: f64,
    /// Filament, mm; negative where it is drawn back while the axes rest before a rewind, and positive without `printing` where it is given back.
    pub filament_mm: f64,
    /// Part of a [`PathMove::Print`].
    pub printing: bool,
    /// Part of a rewind: the nozzle is lifted off, or goes up or down.
    pub lifted: bool,
}

/// What comes out of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisStep<T> {
    /// A motion.
    Move(AxisMove),
    /// What was passed through.
    Pass(T),
}
