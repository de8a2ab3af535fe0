//! Orders by the hull rule, and how they are made complete: by the nozzle that prints, then with support.
//!
//! The hull rule lets a nozzle of any size pass, and what it builds is built first. What it misses is built where [the nozzle that prints](crate::curved::grow_with_nozzle)
//! reaches it. What is still missed gets [support](crate::curved::add_support), and part and support are grown together; if cells are missed all the same, what the
//! hull rule misses is supported in place of what the nozzle misses. One field goes over
//! both; its surfaces are trimmed to the mesh for the part, and to the skin of the support's cells for the support, so layer `k` of the one
//! and layer `k` of the other are printed together.

use super::best::Deposited;
use super::error::{LayersError, begin};
use super::layer_surfaces::LayerSurfaces;
use super::options::{LayerOptions, LayersBy, NozzleUse};
use super::order::PartOrder;
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::audit::{AuditReport, audit};
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::nozzle::grow_with_nozzle;
use crate::curved::strategy::Strategy;
use crate::curved::support::{NoSupport, Supported, add_support, missed_bound};
use crate::curved::surface::{UniformField, uniform_field};

/// An order by the hull rule.
struct HullOrder {
    strategy: Strategy,
    growth: Growth,
    audit: AuditReport,
    /// Its field and surfaces, where they were made to choose by.
    layers: Option<(UniformField, LayerSurfaces)>,
}

impl Workpiece<'_> {
    /// The order by the hull rule, made complete.
    pub(super) fn order_by_hulls(
        &self,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<PartOrder, LayersError> {
        let layers_by = LayersBy::Hull;
        let HullOrder { strategy, growth, audit, layers } = self.best_hull_order(options, progress)?;
        let missed_by_hull = growth.missed_cells();
        let no_support = (!missed_by_hull.is_empty()).then_some(NoSupport::Forbidden);
        let mut order = PartOrder {
            layers_by,
            strategy,
            growth,
            supported: None,
            no_support,
            missed_by_hull,
            audit,
            field: None,
            layers,
        };
        let is_left = options.nozzle != NozzleUse::Off || options.support.is_some();
        let is_whole = order.missed_by_hull.is_empty() && self.guides.support.is_empty();
        if options.nozzle != NozzleUse::FromStart && (is_whole || !is_left) {
            return Ok(order);
        }
        order.layers = None;
        self.complete(&mut order, options, progress)?;
        order.audit = self.audited(&order, options, progress)?;
        if order.supported.is_some() && !order.audit.is_ok() {
            order.supported = None;
            order.no_support = Some(NoSupport::Unsound);
            order.audit = self.audited(&order, options, progress)?;
        }
        Ok(order)
    }

    /// The order by the strategy that was asked for, or the better one of incremental and un-built orders.
    fn best_hull_order(&self, options: &LayerOptions, progress: ProgressFn) -> Result<HullOrder, LayersError> {
        let incremental = self.grown(options.strategy.unwrap_or(Strategy::Incremental), progress)?;
        if options.strategy.is_some() || incremental.growth.missed.is_empty() {
            return Ok(incremental);
        }
        let height_mm = self.height_mm(options);
        let (incremental, laid) = self.judged_by_surfaces(incremental, height_mm, progress)?;
        let unbuilt = self.grown(Strategy::Unbuild, progress)?;
        let (unbuilt, laid_unbuilt) = self.judged_by_surfaces(unbuilt, height_mm, progress)?;
        Ok(if laid_unbuilt.is_better_than(laid, self.volume_mm3) { unbuilt } else { incremental })
    }

    /// An order and its audit.
    fn grown(&self, strategy: Strategy, progress: ProgressFn) -> Result<HullOrder, LayersError> {
        let Workpiece { cells, platform, rules, .. } = self;
        begin("grow", progress)?;
        let growth = strategy.grow(cells, platform, rules, progress)?;
        begin("audit", progress)?;
        let audit = audit(cells, platform, rules, &growth.order, &growth.missed_cells(), progress)?;
        Ok(HullOrder { strategy, growth, audit, layers: None })
    }

    /// The order with its field and surfaces, and what they lay.
    fn judged_by_surfaces(
        &self,
        order: HullOrder,
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<(HullOrder, Deposited), LayersError> {
        let Workpiece { cells, platform, rules, .. } = self;
        let missed = order.growth.missed_cells();
        begin("uniform", progress)?;
        let uniform = uniform_field(cells, platform, rules, &order.growth.order, &missed, progress)?;
        let surfaces = self.surfaces(&uniform.field, &missed, height_mm, progress)?;
        let lost_mm3 = surfaces.lost_mm3(self.volume_mm3);
        let laid = Deposited { lost_mm3, missed_mm3: surfaces.missed_mm3, pieces: surfaces.pieces() };
        Ok((HullOrder { layers: Some((uniform, surfaces)), ..order }, laid))
    }

    /// Goes on with an order by the hull rule: by the nozzle, and with support.
    fn complete(&self, order: &mut PartOrder, options: &LayerOptions, progress: ProgressFn) -> Result<(), LayersError> {
        let (Workpiece { platform, rules, cell_mm, .. }, strategy) = (*self, options.strategy);
        let with_nozzle = |cells: &Cells, growth: Growth| match options.nozzle {
            NozzleUse::Off => Ok(growth),
            NozzleUse::After if growth.missed.is_empty() => Ok(growth),
            NozzleUse::After => grow_with_nozzle(cells, cell_mm, platform, &rules, &options.rule, growth, progress),
            NozzleUse::FromStart => {
                grow_with_nozzle(cells, cell_mm, platform, &rules, &options.rule, Growth::default(), progress)
            }
        };
        let rules = &self.rules;
        let by_hull = |cells: &Cells| -> Result<Growth, GrowthError> {
            let first = strategy.unwrap_or(Strategy::Incremental).grow(cells, platform, rules, progress)?;
            if strategy.is_some() || first.missed.is_empty() {
                return Ok(first);
            }
            let unbuilt = Strategy::Unbuild.grow(cells, platform, rules, progress)?;
            Ok(if unbuilt.missed.len() < first.missed.len() { unbuilt } else { first })
        };
        let grow = |cells: &Cells| -> Result<Growth, GrowthError> {
            let growth = if options.nozzle == NozzleUse::FromStart { Growth::default() } else { by_hull(cells)? };
            with_nozzle(cells, growth)
        };
        begin("nozzle", progress)?;
        let by_hull_alone = order.growth.clone();
        let growth = with_nozzle(&self.cells, by_hull_alone.clone())?;
        let mut support = None;
        let mut why_not = (!growth.missed.is_empty()).then_some(NoSupport::Forbidden);
        if let Some(options) = &options.support {
            // What the nozzle leaves can lie between what it has built, where no column gets: then all that the hull rule misses is supported.
            let given = self.guides.support;
            for below in [&growth, &by_hull_alone] {
                let fewest = match &support {
                    Some(Supported { growth, .. }) => growth.missed.len(),
                    None => missed_bound(growth.missed.len(), given),
                };
                if fewest > 0 {
                    begin("support", progress)?;
                    match add_support(&self.cells, platform, rules, below, given, options, &grow, progress)? {
                        Ok(found) if found.growth.missed.len() < fewest => support = Some(found),
                        Ok(_) => why_not = Some(NoSupport::NoHelp),
                        // That columns were placed counts, below whichever cells.
                        Err(NoSupport::NoPlace) if why_not == Some(NoSupport::NoHelp) => {}
                        Err(why) => why_not = Some(why),
                    }
                }
            }
        }
        order.no_support = why_not.filter(|_| support.is_none());
        (order.growth, order.supported) = (growth, support);
        Ok(())
    }
}
