//! A model of a controller: from commands to where the axes are at each tick of a clock.
//!
//! `model` has its numbers; `segment` is a move as a path, `moves` makes them, `corner` their blends, `window` plans speeds over the look-ahead, `law` is the speed along a
//! piece, `sampler` walks over time, `follower` is the servo loop of a stream. `run` ties them together, `obstacles` is what it cannot do.
//!
//! Symbols: `u` counts seconds at the programmed speeds, `f = du/dt` is the speed as a share of the programmed one.

mod corner;
mod follower;
mod law;
mod model;
mod moves;
mod obstacles;
mod piece;
mod run;
mod sampler;
mod segment;
mod tick;
mod window;

pub use model::{ControllerModel, Follower, GAIN, LOOKAHEAD_S, Maker, Profile};
pub use obstacles::Obstacles;
pub use run::Controller;
pub use tick::Tick;
