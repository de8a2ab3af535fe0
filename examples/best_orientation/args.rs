//! What the user asks for, and what came of it.

use clap::Parser;
use curvlay_examples::args::{Common, MeshArgs, Part, above_zero, from_zero};
use curvlay_examples::findings::Findings;
use curvlay_examples::orienting::{OrientArgs, Search};
use std::time::Duration;

/// How a part should lie on the plate: poses are tried with few cells, the best again with more, and ranked by missed cells, whether the
/// part stands by itself, support, layers, height and base.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "best_orientation")]
pub struct Args {
    #[command(flatten)]
    pub mesh: MeshArgs,
    #[command(flatten)]
    pub orient: OrientArgs,
    /// Depth inside the hull from which a cell counts as shadowed, in cells, at most 16
    #[arg(long = "eps", value_name = "CELLS", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub eps_cells: f64,
    /// Only cells deeper than --eps count as shadowed, not those at exactly that depth
    #[arg(long)]
    pub beyond_eps: bool,
    /// Diameter of the platform in millimetres; a larger one is used if the part does not fit
    #[arg(long = "platform-diameter", value_name = "MM", default_value_t = 127.5, value_parser = above_zero, allow_negative_numbers = true)]
    pub platform_diameter_mm: f64,
    #[command(flatten)]
    pub common: Common,
}

/// What came of it: the part, its poses, how long the search took, and what is wrong.
pub struct Run {
    pub part: Part,
    pub search: Search,
    pub search_time: Duration,
    pub findings: Findings,
}
