//! Machine files: G-code of robot-assisted printing, written and read.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), appendix: RepRap's G-code, and with each move the
//! direction of the nozzle. The format to the last digit stands below.
//!
//! * [`write_gcode`] takes any iterator of [`Move`]s and a [`std::io::Write`]; [`GcodeReader`] is an iterator of moves over a
//!   [`std::io::BufRead`]. Both hold one line, or a few, however long the file is.
//! * [`Dialect::Part`]: `G1 X6.338 Y8.39 Z46.3 E4.324 ;DIR:-0.094 0.127 0.987`, in the frame of the part; or the direction in words
//!   ([`DirectionWords`]).
//! * [`Dialect::Rotary`]: axes of a machine whose table tilts and turns ([`RotaryTable`]), `G1 X.. Y.. Z.. B.. C..`.
//!
//! [`flavour`] writes and reads the G-code of controllers as data: LinuxCNC, RepRapFirmware, Klipper, Marlin, Siemens, Heidenhain and others.
//!
//! Departs from the appendix: the direction stands in a comment by default, since its words `nX nY nZ` are dangerous: Marlin, for one, reads the
//! `X` behind an `n` it does not know. It has unit length and points from the tip into the nozzle (as in its example),
//! it stays until the next one is given and is +z at first; modes are written out (`G21 G90 M82 G94`), so that a file
//! does not depend on what ran before it.
//!
#![doc = include_str!("../../docs/gcode.md")]

mod direction;
mod fiber;
pub mod flavour;
mod lift;
mod lines;
mod marks;
mod numbers;
mod read;
mod read_error;
mod retraction;
mod rotary;
mod tags;
mod template;
mod text;
mod write;
mod write_error;

pub use direction::DirectionWords;
pub use fiber::{FiberCommand, Tool};
pub use lift::EndLift;
pub use marks::marked_moves;
pub use read::{GcodeReader, ReadOptions};
pub use read_error::ReadError;
pub use retraction::Retraction;
pub use rotary::{RotaryAxis, RotaryTable};
pub use tags::{Mark, Tags};
pub use write::{Extrusion, WriteOptions, Written, write_gcode};
pub use write_error::WriteError;

use nalgebra::{Point3, UnitVector3};

/// One thing for the machine to do. Lengths in millimetres, feeds in mm/s, filament in millimetres of its length.
///
/// `tip` is where the move ends; it starts where the last one ended. `direction` points from the tip into the nozzle, away
/// from the part: +z for a nozzle that stands upright. Both are in the frame of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Move {
    /// The nozzle goes somewhere and leaves nothing on its way: `G0`.
    Travel {
        /// Where the tip arrives.
        tip: Point3<f64>,
        /// Direction of the nozzle there.
        direction: UnitVector3<f64>,
        /// Speed of the tip, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// The nozzle lays a bead: `G1` with `E`.
    Print {
        /// Where the tip arrives.
        tip: Point3<f64>,
        /// Direction of the nozzle there.
        direction: UnitVector3<f64>,
        /// Filament for this move alone, 0 to 1e6 mm.
        filament_mm: f64,
        /// Speed of the tip, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// The roller lays tape under pressure: `G1` without `E`.
    Lay {
        /// Where the roller's contact point arrives.
        tip: Point3<f64>,
        /// Direction of the roller there: the normal of the surface, against which it presses.
        direction: UnitVector3<f64>,
        /// Speed of the contact point, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// What a tape head does: `M2730` to `M2735`.
    Fiber(FiberCommand),
    /// Filament is drawn back, the nozzle stands still.
    Retract {
        /// How much of it, 0 to 1e6 mm.
        filament_mm: f64,
        /// Speed of the filament, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// Filament is pushed forward, the nozzle stands still.
    Prime {
        /// How much of it, 0 to 1e6 mm.
        filament_mm: f64,
        /// Speed of the filament, 0.001 to 1e5 mm/s.
        feed_mm_s: f64,
    },
    /// To the machine's home: `G28`. Where that is, the path does not know: the next move is a [`Move::Travel`].
    Home,
    /// Everything waits: `G4`.
    Dwell {
        /// How long, 0 to 1e5 s, in milliseconds in the file.
        seconds: f64,
    },
    /// The nozzle's temperature: `M104`, `M109`.
    Nozzle {
        /// Degrees Celsius, 0 to 2000; 0 is off.
        celsius: f64,
        /// Whether all waits until it is reached.
        wait: bool,
    },
    /// The plate's temperature: `M140`, `M190`.
    Bed {
        /// Degrees Celsius, 0 to 2000; 0 is off.
        celsius: f64,
        /// Whether all waits until it is reached.
        wait: bool,
    },
    /// The fan: `M106`, `M107`.
    Fan {
        /// Share of its full speed, 0 to 1, in 255ths in the file.
        share: f64,
    },
    /// What comes next, in comments for viewers ([`Tags`]). Readers do not give it back.
    Mark(Mark),
}

/// What the words of a move mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // there is one a file, and it stays `Copy`
pub enum Dialect {
    /// Tip and direction in the frame of the part: `X Y Z E F` and the direction, `F` in mm/min.
    Part(DirectionWords),
    /// Axes of a machine whose table tilts and turns: `X Y Z B C E F`, `F` as the inverse of time (`G93`).
    Rotary(RotaryTable),
}

impl Default for Dialect {
    /// The direction in comments.
    fn default() -> Self {
        Dialect::Part(DirectionWords::Comment)
    }
}

/// Digits behind the point: a ten-thousandth of a millimetre.
const POSITION_DECIMALS: usize = 4;
/// A millionth, that is 1e-6 rad.
const DIRECTION_DECIMALS: usize = 6;
/// A hundred-thousandth of a millimetre of filament: some 2e-5 mm^3.
const FILAMENT_DECIMALS: usize = 5;
/// Of mm/min.
const FEED_DECIMALS: usize = 3;
/// Of degrees: 1e-4 mm at 500 mm from the axis.
const ANGLE_DECIMALS: usize = 5;
/// Of the inverse of minutes: a move of 10 s is timed to 2e-6 s.
const INVERSE_DECIMALS: usize = 6;

const COORDINATE: [f64; 2] = [-1e6, 1e6];
const FEED: [f64; 2] = [1e-3, 1e5];
const FILAMENT: [f64; 2] = [0.0, 1e6];
const DWELL: [f64; 2] = [0.0, 1e5];
const CELSIUS: [f64; 2] = [0.0, 2000.0];
const SHARE: [f64; 2] = [0.0, 1.0];
const FULL_FAN: f64 = 255.0;

/// Longest line that is read, or written from a template, in bytes. Our own have less than 200; comments of others have
/// thousands; and nobody's file may fill the memory.
const LONGEST_LINE: usize = 16 * 1024;

fn within(value: f64, [least, most]: [f64; 2]) -> bool {
    // False for NaN.
    value >= least && value <= most
}
