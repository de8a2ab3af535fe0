//! Coherent layers of a part made complete.
//!
//! [`Workpiece::coherent_layers`] is for orders of the part alone. Here part and support are one solid, with one coherent field over both.

use super::complete::{CompleteOptions, CompleteOrder, CompletePart};
use super::workpiece::{LayerSurfaces, LayersError, Workpiece, begin};
use crate::Progress;
use crate::curved::surface::coherent_field;
use std::ops::ControlFlow;

/// What coherent layers may lose of the volume. Even ones lose up to one hundredth; beyond three it shows in the material laid.
const MAX_LOST: f64 = 0.03;

impl LayerSurfaces {
    /// Whether surfaces end less inside the part than others, in no more pieces, and lose no more of the volume, or no more than three
    /// hundredths of it.
    pub(crate) fn are_more_coherent_than(&self, others: &LayerSurfaces, volume_mm3: f64) -> bool {
        let [lost, lost_of_others] = [self, others].map(|surfaces| surfaces.lost_mm3(volume_mm3));
        self.boundary.at_waits_mm < others.boundary.at_waits_mm
            && self.pieces() <= others.pieces()
            && lost <= lost_of_others.max(MAX_LOST * volume_mm3)
    }
}

impl Workpiece<'_> {
    /// Field and surfaces of a complete order, as [`Workpiece::layers_of_complete`] makes them, and once more from a [`coherent_field`] of the
    /// same order; takes that one by the rule of [`Workpiece::coherent_layers`].
    ///
    /// Cells that the nozzle builds ([`Growth::nozzle`](crate::curved::Growth::nozzle)) lie within the hull of others, which no coherent field allows:
    /// with such cells the layers are those of [`Workpiece::layers_of_complete`].
    ///
    /// # Arguments
    /// * `height_mm`, `options`: those of the order.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// Twice that of [`Workpiece::layers_of_complete`], and that of [`coherent_field`]. `progress` is called with the stage `coherent` as well.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: `part.coherent_layers_of_complete(part.complete_order(None, 0.75, &options, &progress)?, 0.75, &options,
    /// &progress)?.layered` is `part.layers(None, 0.75, &progress)?`, since the layers of a block end nowhere inside.
    pub fn coherent_layers_of_complete(
        &self,
        order: CompleteOrder,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompletePart, LayersError> {
        let mut made = self.layers_of_complete(order.clone(), height_mm, options, progress)?;
        let growth = order.taken();
        if !growth.nozzle.is_empty() {
            return Ok(made);
        }
        let (cells, missed) = (order.united(&self.cells)?, growth.missed_cells());
        begin("coherent", progress)?;
        let Some(uniform) = coherent_field(&cells, self.platform, &self.rules, &growth.order, &missed, progress)?
        else {
            return Ok(made);
        };
        let support = order.support_cells();
        let (surfaces, support) =
            self.surfaces_and_support(&uniform.field, cells.rows(), support, &missed, height_mm, progress)?;
        if surfaces.are_more_coherent_than(&made.layered.surfaces, self.volume_mm3) {
            let straight_cells = made.support.map_or(0, |support| support.straight_cells);
            made.support = support;
            made.support.iter_mut().for_each(|support| support.straight_cells = straight_cells);
            (made.layered.uniform, made.layered.surfaces) = (uniform, surfaces);
        }
        Ok(made)
    }
}
