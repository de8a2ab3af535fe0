//! Moves of the axes of a machine, as plain data.

use crate::gcode::Move;

/// An axis of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineAxis {
    /// Its letter, A to Z.
    pub letter: char,
    /// Whether it turns: its values are radians, else millimetres.
    pub is_rotary: bool,
}

impl MachineAxis {
    /// An axis that slides.
    pub const fn linear(letter: char) -> Self {
        MachineAxis { letter, is_rotary: false }
    }

    /// An axis that turns.
    pub const fn rotary(letter: char) -> Self {
        MachineAxis { letter, is_rotary: true }
    }
}

/// One thing for a machine of `N` axes to do. All axes of a move begin and end together, each at an even speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisMove<const N: usize> {
    /// The axes go somewhere, and nothing is left behind.
    Travel {
        /// Where each axis arrives, in the order of the machine's letters, mm and radians.
        axes: [f64; N],
        /// How long it takes, 1e-4 to 1e5 s. The first move of a program, and the one after [`Move::Home`], begins at an unknown place: its time is not used.
        seconds: f64,
    },
    /// The axes go somewhere while filament leaves the nozzle.
    Print {
        /// Where each axis arrives, in the order of the machine's letters, mm and radians.
        axes: [f64; N],
        /// How long it takes, 1e-4 to 1e5 s.
        seconds: f64,
        /// Filament for this move alone, 0 to 1e6 mm.
        filament_mm: f64,
    },
    /// The axes go somewhere while the roller lays tape.
    Lay {
        /// Where each axis arrives, in the order of the machine's letters, mm and radians.
        axes: [f64; N],
        /// How long it takes, 1e-4 to 1e5 s.
        seconds: f64,
    },
    /// All axes stand still: a retraction, heat, fan, dwell, home, mark, or tape head. Not [`Move::Travel`], [`Move::Print`] or [`Move::Lay`].
    Still(Move),
}
