//! Growing fields: in which order the cells of a solid can be built.
//!
//! Dai 2020, sections 3.4.2 to 3.4.4 (Algorithms 1, 2, 3 and 5); Boge 2019, chapter 4.
//! Symbols: `V` the cells built, `C_c` the hull in `front::Front`, `L_next` the *candidates*, `S_c` the cells *lost* so
//! far, `S_p` and `S_t` the cells *endangered* by all candidates or by some, `f_tau` the *threshold* of the
//! governing field `F`.
//!
//! Departures from the printed algorithms
//! * The front is cumulative: a candidate held back stays one, and is taken when it does no more harm.
//! * It is held back *because of* one cell that it would shadow, and that stays so until that cell is built or
//!   lost, since the hull only grows. Until then it is not tried again.
//! * Shadowed is what newly comes to lie inside, candidates aside. Cells lost before do not count again, and a
//!   candidate that comes to lie inside the hull of the others is built in the same layer.
//! * Cells are given up (the last lines of Algorithms 2 and 3) only when nothing waits for a higher threshold, and then for the
//!   sake of that group of candidates that costs the fewest, not for all of them.
//!
//! [`grow_as_printed`] has none of these departures.

mod clock;
mod covered;
mod error;
mod front;
mod grow;
mod grower;
mod options;
mod order;
mod outcome;
mod peel;
mod prevention;
mod printed;

pub(crate) use clock::grow_by_clock;
pub(crate) use covered::{Covered, covered};
pub use error::GrowthError;
pub use grow::grow;
pub use options::{Candidates, GrowthOptions, Prevention, Visit};
pub use outcome::{Growth, GrowthStatistics, MissedCell, MissedReason, NozzleCell};
pub use peel::{PeelError, SheetField, peel};
pub use printed::grow_as_printed;
