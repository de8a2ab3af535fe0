//! Trimming against closed forms, slow twins, and the models.

mod closed_forms;
mod crossings;
mod degenerate;
mod errors;
mod helpers;
mod holed;
mod models;
mod regressions;
mod slow_twin;
