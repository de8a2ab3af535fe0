//! Where things should stand: a fixed nozzle, by what the arm reaches; nozzle, plate or table, by what waypoints are worth there; a
//! part on its carrier, by what a print asks.

mod fixture;
mod nozzle;
mod part;
mod plate;
mod posture;
mod sample;

pub use fixture::{BestFixturePlace, FixtureRegion, best_fixture_place};
pub use nozzle::{Placement, PlacementError, ReachOptions, fullest_box, reachable_points};
pub use part::{Assessment, BestPlace, PartPlace, PlaceError, best_place, place_grid};
pub use plate::{PlateError, PlateOptions, centred_on_plate, place_on_plate};
pub use posture::BestPosture;
pub use sample::{Representatives, representative_waypoints};
