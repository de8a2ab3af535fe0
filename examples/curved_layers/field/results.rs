//! What the stage `field` finds.

use crate::guide::GivenDirections;
use crate::mould::Mould;
use curvlay_examples::clock::StageClock;
use curvlay_layers::curved::{
    AuditReport, Growth, Impossible, LayerQuality, LayersBy, NoSupport, Platform, ProofError,
};
use curvlay_voxel::Voxelisation;
use curvlay_voxel::inspect::{MeshReport, ThinFeatures};
use std::time::Duration;

/// What came of the stage.
pub struct FieldRun {
    pub mesh: MeshReport,
    /// What is thinner than a cell.
    pub thin: ThinFeatures,
    pub solid: Voxelisation,
    pub platform: Platform,
    /// What the part is built on, if that is not the plate.
    pub mould: Option<Mould>,
    /// Volume of the part that lies in that, more than a cell deep: it is not printed, and no part of `part_mm3`.
    pub buried_mm3: f64,
    pub growth: Growth,
    /// By what the order was found; none for a saved one.
    pub layers_by: Option<LayersBy>,
    /// The strategy that it is by.
    pub strategy: &'static str,
    pub audit: AuditReport,
    /// Cells that the order by the hull rule alone missed, by rising number.
    pub missed_by_hull: Vec<u32>,
    /// Directions that were given, and how far they are followed.
    pub given: Option<GivenDirections>,
    /// How many cells have support since beads of another try above them were unsupported.
    pub below_beads: usize,
    /// The cells that are support, by rising number, and what straight columns would take.
    pub support: Vec<u32>,
    /// Volume of the support in cells of the part, beside its material.
    pub contact_mm3: f64,
    pub straight_cells: usize,
    /// Layers of the order that are printed as one.
    pub steps_per_layer: u32,
    /// Why there is no support where cells are missed; a saved field does not say.
    pub no_support: Option<NoSupport>,
    /// Those of the missed ones by the hull rule that no order can build, and whether the proofs hold.
    pub impossible: Vec<Impossible>,
    pub proofs: Result<(), ProofError>,
    pub quality: LayerQuality,
    /// Volume of the part, overlaps of its mesh counted once, and what of it lies in missed cells.
    pub part_mm3: f64,
    /// It is a sum over the cells, since bodies of the mesh pass through each other.
    pub part_is_estimated: bool,
    pub missed_mm3: f64,
    pub times: Times,
}

impl FieldRun {
    /// Share of the part that lies in missed cells.
    pub fn missed_share(&self) -> f64 {
        if self.growth.missed.is_empty() { 0.0 } else { self.missed_mm3 / self.part_mm3 }
    }

    /// Number of cells missed by the hull rule that are not proven to be impossible.
    pub fn undecided(&self) -> usize {
        self.missed_by_hull.len() - self.impossible.len()
    }

    /// Volume of the support, in cubic millimetres.
    pub fn support_mm3(&self) -> f64 {
        self.support.len() as f64 * self.solid.grid.cell_mm().powi(3) + self.contact_mm3
    }

    /// Diameter of the platform as it was used. The disc has corners at both ends of its diameter along x.
    pub fn platform_diameter_mm(&self) -> f64 {
        let xs = self.platform.corners().iter().map(|corner| corner[0]);
        let width = xs.clone().max().unwrap_or(0) - xs.min().unwrap_or(0);
        f64::from(width) / 2.0 * self.solid.grid.cell_mm()
    }
}

/// How long the steps took.
pub struct Times {
    pub inspect: Duration,
    pub voxelise: Duration,
    pub peel: Duration,
    /// Peeling included, and a second strategy if it was tried.
    pub grow: Duration,
    pub audit: Duration,
    /// Of the proofs that missed cells are impossible, and of their check.
    pub prove: Duration,
    pub check_proofs: Duration,
    /// All of these, and the surfaces: those of the order that was not taken as well.
    pub total: Duration,
}

impl Times {
    /// The times of a run whose stages a clock has noted.
    pub fn of(clock: &StageClock, inspect: Duration, voxelise: Duration) -> Self {
        let [peel, grow, audit, prove, check_proofs, surfaces] = [
            &["peel"][..],
            &["grow", "distance", "peel", "unbuild", "nozzle", "support"],
            &["audit"],
            &["impossible"],
            &["check"],
            &["uniform", "audit uniform", "coherent", "contour", "trim", "spacing"],
        ]
        .map(|stages| clock.on_the_clock(stages));
        let total = inspect + voxelise + grow + audit + prove + check_proofs + surfaces;
        Times { inspect, voxelise, peel, grow, audit, prove, check_proofs, total }
    }
}
