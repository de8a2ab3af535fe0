//! Continuous fibre in a machine file: the tool, and what a tape head does.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 5.3.1, figure 5.2: a head puts the tape on the surface, heats it,
//! presses it along the normal while it travels, and cuts it. The dissertation has no words for this; these are ours.
//!
//! | command | words | meaning |
//! |---|---|---|
//! | `M2730` | `P` | tool: 0 nozzle, 1 roller, 2 conductor |
//! | `M2731` | `S` | feed so many mm of tape |
//! | `M2732` | `S` | press with so many newtons; 0 lets go |
//! | `M2733`, `M2734` | `S` | temperature of the roller, degrees Celsius; without and with waiting |
//! | `M2735` | | cut |

use super::{CELSIUS, FILAMENT, Move};

/// What works on the part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// The nozzle, for thermoplastic.
    #[default]
    Nozzle,
    /// The roller, for tapes that reinforce.
    Roller,
    /// The roller for fibre that conducts (section 5.5 of the dissertation).
    Conductor,
}

/// What a tape head does, standing still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FiberCommand {
    /// Another tool takes the place of the one before: its contact point comes where that of the other was.
    Tool(Tool),
    /// Tape is pushed out, so that it lies under the roller.
    Feed {
        /// How much of it, 0 to 1e6 mm.
        length_mm: f64,
    },
    /// The roller presses along its direction, towards the part.
    Press {
        /// The force, 0 to 1e4 N; 0 lets go.
        newtons: f64,
    },
    /// The roller's temperature.
    Heat {
        /// Degrees Celsius, 0 to 2000; 0 is off.
        celsius: f64,
        /// Whether all waits until it is reached.
        wait: bool,
    },
    /// The tape is cut at the blade, which stands before the roller: what is behind it is still laid.
    Cut,
}

/// Of millimetres, newtons and degrees.
pub(super) const FIBER_DECIMALS: usize = 1;

/// Numbers of the commands. No firmware that we know of has them, nor their remainders by 256 (grbl keeps 8 bits) and by 1000.
pub(super) const TOOL: u16 = 2730;
pub(super) const FEED_TAPE: u16 = 2731;
pub(super) const PRESS: u16 = 2732;
pub(super) const HEAT: u16 = 2733;
pub(super) const HEAT_WAIT: u16 = 2734;
pub(super) const CUT: u16 = 2735;

/// Tools by their number.
pub(super) const TOOLS: [Tool; 3] = [Tool::Nozzle, Tool::Roller, Tool::Conductor];
const FORCE: [f64; 2] = [0.0, 1e4];

/// What the word of a command is, and its range.
pub(super) fn range(code: u16) -> (&'static str, [f64; 2]) {
    match code {
        TOOL => ("tool", [0.0, (TOOLS.len() - 1) as f64]),
        FEED_TAPE => ("length_mm", FILAMENT),
        PRESS => ("newtons", FORCE),
        _ => ("celsius", CELSIUS),
    }
}

impl FiberCommand {
    /// Its number and the value of its word.
    pub(super) fn words(self) -> (u16, Option<f64>) {
        match self {
            FiberCommand::Tool(tool) => (TOOL, TOOLS.iter().position(|&known| known == tool).map(|at| at as f64)),
            FiberCommand::Feed { length_mm } => (FEED_TAPE, Some(length_mm)),
            FiberCommand::Press { newtons } => (PRESS, Some(newtons)),
            FiberCommand::Heat { celsius, wait } => (if wait { HEAT_WAIT } else { HEAT }, Some(celsius)),
            FiberCommand::Cut => (CUT, None),
        }
    }

    /// The command of a number and a value within its [`range`]; none for a tool that is not whole.
    pub(super) fn of(code: u16, value: f64) -> Option<FiberCommand> {
        Some(match code {
            TOOL => FiberCommand::Tool(*TOOLS.get(value as usize).filter(|_| value.fract().abs() == 0.0)?),
            FEED_TAPE => FiberCommand::Feed { length_mm: value },
            PRESS => FiberCommand::Press { newtons: value },
            HEAT | HEAT_WAIT => FiberCommand::Heat { celsius: value, wait: code == HEAT_WAIT },
            _ => FiberCommand::Cut,
        })
    }
}

/// Which tool works, and whether it presses: what a file must keep to, written or read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Head {
    tool: Tool,
    presses: bool,
}

impl Head {
    pub fn presses(self) -> bool {
        self.presses
    }

    /// Follows a move, or says why it cannot be.
    pub fn follow(&mut self, item: &Move) -> Result<(), &'static str> {
        let is_nozzle = self.tool == Tool::Nozzle;
        match item {
            Move::Print { .. } | Move::Retract { .. } | Move::Prime { .. } if !is_nozzle => {
                Err("filament needs the nozzle: change the tool first (M2730 P0)")
            }
            Move::Lay { .. } if !self.presses => Err("tape is laid under the roller only: press first (M2732)"),
            Move::Travel { .. } | Move::Home if self.presses => {
                Err("the roller presses: lay tape (G1), or let go first (M2732 S0)")
            }
            Move::Fiber(FiberCommand::Tool(_)) if self.presses => {
                Err("the roller presses: let go before the tool changes (M2732 S0)")
            }
            Move::Fiber(FiberCommand::Tool(tool)) => {
                self.tool = *tool;
                Ok(())
            }
            Move::Fiber(_) if is_nozzle => Err("the nozzle has no tape: change the tool first (M2730)"),
            // As it is written: a force that rounds to 0 counts as no force.
            Move::Fiber(FiberCommand::Press { newtons }) => {
                self.presses = super::text::steps(*newtons, FIBER_DECIMALS) > 0;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
