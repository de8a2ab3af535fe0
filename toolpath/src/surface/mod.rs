//! Paths on a curved layer: a triangle mesh with a boundary.
//!
//! * [`SurfaceMesh`]: the mesh, checked at the door.
//! * [`SurfaceDistance`]: the exact geodesic distance to the boundary, or to any edges and vertices.
//! * [`path_statistics`]: what beads along any curves cover, leave bare, cover twice and spill; by a raster that knows
//!   nothing of how the curves were made.
//! * [`LevelField`]: its level sets, how they nest, and the pockets between which they part; and paths along them
//!   that fill the surface with beads ([`LevelField::paths`]).
//! * [`InfillOptions`]: walls, skins and sparse infill in place of solid layers. [`BeadKind`] says what a piece of bead is for.
//! * [`order_curves`]: in which order curves are travelled, and from which end, for short ways in between.
//! * [`LayerStack`]: all layers of a part. It orients the nozzle along their curves ([`LayerStack::orient`]), and tilts
//!   it where it would run into what is built ([`LayerStack::resolve_gouging`]), and finds ways from path to path that keep clear
//!   of it ([`LayerStack::travels`]). [`LayerStack::contacts`] reports how deep a nozzle is in what is built, at any pose and
//!   moment of the print.
//! * [`check_support`]: which beads lie on nothing, judged by the paths as they are laid.
//! * [`lay_tapes`]: tapes of continuous fibre along a [`DirectionField`], which may come from stresses ([`LayerStress`]), or along guide curves
//!   ([`lay_tapes_along`]); [`angle_to_principal`] tells how well they follow the load.
//! * [`deposit`]: how much is extruded along tool paths, and how fast, as a plan of timed moves.
//!
//! All of this in two calls: [`fill_layers`] fills the surfaces of a part and orders their curves, [`FilledLayers::plan`] plans the
//! moves of the whole print.

mod beads;
mod deposition;
mod fiber;
mod fill;
mod geodesic;
mod gouging;
mod infill;
mod kind;
mod level_set;
mod marks;
mod mesh;
mod order;
mod orientation;
mod parallel;
mod paths;
mod planar;
mod pose;
mod print;
mod short;
mod skin;
mod stack;
mod statistics;
mod support;
mod travel;
mod union;
mod vtp;
mod with_support;

pub use deposition::{
    Deposition, DepositionError, DepositionOptions, FeedLimits, Move, MoveKind, PathSchedule, deposit, deposit_along,
};
pub use fiber::{
    BeddingError, CentreLine, ConductorError, ConductorOptions, DirectionError, DirectionField, EmptyPlan, LayUp,
    LayerStress, LayerTapes, LeftOutTape, OffsetError, Principal, PrincipalAngle, Roller, STRESS_CSV_HEADER,
    SandwichError, SandwichLayer, SandwichOptions, Singularity, StiffnessError, StressError, StressFileError,
    StressOptions, StressSample, StripeError, Stripes, Tape, TapeBedding, TapeCover, TapeError, TapeHead,
    TapeHeadError, TapeInSection, TapeLimit, TapeOptions, TapePlace, TapePlan, angle_to_principal, arch_stiffness_n_mm,
    bedded_surface, conductor, lay_tapes, lay_tapes_along, offset_lines, plan_tapes, raise, read_stress_csv,
    read_stress_frd, read_stress_vtk, sandwich, sandwich_on, stripes, tape_bedding, three_point_rigidity_nm2,
    with_tapes, write_stress_csv,
};
pub use fill::{
    FillError, FillEstimate, FillLayersError, FillTotals, FilledLayer, FilledLayers, LayerSurface, LeftOutParts,
    estimate_fill, fill_layer, fill_layers, fill_range, fill_rest,
};
pub use geodesic::{DistanceError, Nearest, Sources, SurfaceDistance};
pub use gouging::{
    Contact, ContactError, Contacts, Gouge, GougingError, GougingOptions, LeftOut, Moment, Nozzle, NozzleError,
    NozzlePart, Obstacle, ResolvedPaths,
};
pub use infill::{Bridges, InfillOptions, InfillPattern, SparseFill};
pub use kind::BeadKind;
pub use level_set::{Band, LevelField, LevelSetError, LevelSets, Pocket, Ring, SurfacePoint};
pub use marks::marked_moves;
pub use mesh::{MeshError, Regions, SurfaceMesh};
pub use order::{OrderError, TravelCurve, TravelOrder, Visit, order_curves};
pub use orientation::{
    DirectionHints, HintError, OrientError, OrientOptions, Oriented, SharpTurn, ToolPath, Turns, Waypoint,
};
pub use paths::{
    BEAD_WIDTHS, LayerPaths, PathError, PathOptions, PathPoint, Pattern, SurfacePath, Unfilled, UnfilledReason,
};
pub use pose::Pose;
pub use print::{PrintError, PrintOptions, PrintPlan};
pub use short::SHORT_CURVE_BEADS;
pub use skin::{SkinError, SkinGap, SkinOptions, skin_gap};
pub use stack::{BuiltLayer, LayerCurve, LayerStack, Mould, MouldError, StackError};
pub use statistics::{
    BeadCurve, CurveStatistics, Gap, PathStatistics, StatisticsError, StatisticsOptions, path_statistics,
};
pub use support::{BeadSupport, SupportError, SupportOptions, UnsupportedPiece, check_support, check_support_on_mould};
pub use travel::{BlockedTravel, TravelOptions, Travels};
pub use vtp::write_paths_vtp;
