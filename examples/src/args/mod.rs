//! Arguments that the examples share, and their exit status.
//!
//! Each group is flattened into the arguments of an example:
//! ```
//! use clap::Parser;
//! use curvlay_examples::args::{Common, MeshArgs};
//! #[derive(Parser)]
//! struct Args {
//!     #[command(flatten)]
//!     mesh: MeshArgs,
//!     #[command(flatten)]
//!     common: Common,
//! }
//! let args = Args::try_parse_from(["curved_layers", "--unit", "m", "--threads", "2"])?;
//! assert_eq!((args.common.threads, args.mesh.mesh), (2, None));
//! assert!(Args::try_parse_from(["curved_layers", "--scale", "0"]).is_err());
//! # Ok::<(), clap::Error>(())
//! ```

mod allow;
mod cells;
mod common;
mod part;
mod rules;
mod typed;
mod ur_extruder;

pub use crate::outcome::{Failure, Outcome};
pub use crate::run::{one_line, run, run_command, run_with_args};
pub use crate::terminal::{note, printable, warn, warn_if_open};
pub use allow::AllowArgs;
pub use cells::{GrowArgs, Prevention, Strategy, VoxelArgs};
pub use common::Common;
pub use part::{MeshArgs, Part};
pub use rules::{above_zero, celsius, from_zero, limit, share};
pub use typed::{is_typed, typed_name};
pub use ur_extruder::{Choice, UrExtruderArgs, ur_extruder};
