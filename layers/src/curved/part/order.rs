//! The order of a part and its support.

use super::error::{LayersError, begin};
use super::layer_surfaces::LayerSurfaces;
use super::options::{LayerOptions, LayersBy};
use super::support::SupportCells;
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::audit::{AuditReport, JudgedByNozzle, audit_with_nozzle};
use crate::curved::growth::Growth;
use crate::curved::nozzle::NozzleRule;
use crate::curved::strategy::Strategy;
use crate::curved::support::{NoSupport, SupportError, Supported};
use crate::curved::surface::{LayerField, UniformField};

/// The order of a part, and of its support if it has any, before it is layered.
#[derive(Clone, Debug)]
pub struct PartOrder {
    /// By what the order was found: hulls or distance.
    pub layers_by: LayersBy,
    /// The strategy of the order by the hull rule; of an order by distance un-building, by which what the distance does not reach is ordered.
    pub strategy: Strategy,
    /// The order of the part alone.
    pub growth: Growth,
    /// Part and support together; `None` without support.
    pub supported: Option<Supported>,
    /// Why there is no support, where cells are missed.
    pub no_support: Option<NoSupport>,
    /// Cells that the order by the hull rule alone missed, by rising number; none for an order by distance.
    pub missed_by_hull: Vec<u32>,
    /// The audit of the order of part and support together.
    pub audit: AuditReport,
    /// The field of an order by distance, of part and support together; `None` for one by hulls.
    pub field: Option<LayerField>,
    /// Its field and surfaces, where they were made to choose between two orders by hulls.
    pub(super) layers: Option<(UniformField, LayerSurfaces)>,
}

impl PartOrder {
    /// The cells of the support; none without.
    pub fn support_cells(&self) -> SupportCells<'_> {
        match &self.supported {
            Some(Supported { support: cells, contact, .. }) => SupportCells { cells, contact },
            None => SupportCells::default(),
        }
    }

    /// The order that counts: that of part and support, or of the part where there is no support.
    pub fn final_growth(&self) -> &Growth {
        self.supported.as_ref().map_or(&self.growth, |supported| &supported.growth)
    }

    /// The cells of part and support, of a part with these.
    ///
    /// # Errors
    /// [`SupportError::Cells`] if the order is of another part.
    pub fn united<'a>(&'a self, cells: &Cells<'a>) -> Result<Cells<'a>, SupportError> {
        match &self.supported {
            Some(supported) => Ok(Cells::new(cells.dims(), &supported.rows)?),
            None => Ok(*cells),
        }
    }

    /// Its cells that were judged by the nozzle, for the audit.
    pub(super) fn judged(&self, rule: &NozzleRule, cell_mm: f64) -> JudgedByNozzle<'_> {
        JudgedByNozzle { rule: *rule, cell_mm, steps: self.layers_by.steps(), cells: &self.final_growth().nozzle }
    }
}

impl Workpiece<'_> {
    /// The audit of an order.
    pub(super) fn audited(
        &self,
        order: &PartOrder,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<AuditReport, LayersError> {
        let (cells, growth) = (order.united(&self.cells)?, order.final_growth());
        let judged = order.judged(&options.rule, self.cell_mm);
        begin("audit", progress)?;
        let missed = growth.missed_cells();
        Ok(audit_with_nozzle(&cells, self.platform, &self.rules, &judged, &growth.order, &missed, progress)?)
    }
}
