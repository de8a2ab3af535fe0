//! How well beads cover a surface: figures that judge tool paths without knowing how they were made.
//!
//! Takes a mesh and curves with widths, as plain points; gives [`PathStatistics`].
//!
//! Dai 2020, section 3.6.3, reports the covered share of curved layers; here it comes with what else makes a path good
//! or bad. Nothing is shared with the generators of paths or the geodesic distance but the types of `nalgebra`: not the
//! mesh, not the distance, not the unfolding. A bead is the union of all discs on the surface around points of its
//! curve, half the width in radius. It is laid down on a raster of samples, finer than a tenth of a bead.
//!
//! * `figures`: what is asked and answered; `measure`: from curves to figures.
//! * `sheet`: triangles laid flat, and how one continues in the next. `locate`: nearest points.
//! * `trace`: curves laid on the surface, in pieces of one triangle each. `curve`: lengths and turns. `straight`: fewer pieces.
//! * `walk`: a piece seen from the triangles around it. `raster`: samples, and what covers them.
//! * `gap`: the largest bare disc. `fillable`: what no bead could cover. `spill`: what lies past the boundary. `crossing`: curves that meet.
//!
//! Beads cover only what is connected with them over the surface, so sheets that fold over each other in space stay
//! apart. Distances are straight lines over unfolded triangles: exact on planes and whatever unrolls into them. Where a
//! surface bends both ways they err with the curvature that a bead spans, which is little; a bare region much wider than
//! the triangles may span much, and the radius of its disc is then only an estimate.
//! Covered and overlapping shares converge with the step of the raster; a share of a region with a smooth outline of
//! length `l` is off by less than `l * step` and by far less on average.

mod and;
mod crossing;
mod curve;
mod error;
mod figures;
mod fillable;
mod gap;
mod locate;
mod measure;
mod raster;
mod sheet;
mod spill;
mod straight;
mod trace;
mod walk;

pub use error::StatisticsError;
pub use figures::{BeadCurve, CurveStatistics, Gap, PathStatistics, StatisticsOptions};
pub use measure::path_statistics;
