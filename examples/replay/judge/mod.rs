//! Judges of what the machine does: each takes ticks, none knows how they were made. `joints` compares with limits, `tip` with the plan,
//! `deposit` weighs what is laid, `contact` keeps the nozzle out of it.

mod bead;
mod contact;
mod deposit;
mod histogram;
mod joints;
mod plan;
mod tip;
mod worst;

pub use bead::Bead;
pub use contact::Contact;
pub use deposit::Deposit;
pub use joints::{Joints, Quantity};
pub use plan::{Placement, Plan};
pub use tip::{Match, Tip};
pub use worst::Worst;
