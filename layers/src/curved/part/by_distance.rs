//! A part by its distance from the plate or a mould, made complete.
//!
//! [`grow_by_distance`] or [`grow_directed`] orders what the nozzle that prints reaches that way. What is left is built after it by
//! [`grow_with_nozzle`], in layers of its own; what is missed then gets support, and part and support are ordered together in the same way.

use super::error::{LayersError, begin};
use super::options::{LayerOptions, LayersBy, NozzleUse};
use super::order::PartOrder;
use super::workpiece::Workpiece;
use crate::Progress;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::audit::{AuditReport, JudgedByNozzle, audit_with_nozzle};
use crate::curved::buildable::supported::carried;
use crate::curved::distance::{DistanceOrder, distance_layers, grow_by_distance, grow_by_heights, grow_directed};
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::nozzle::grow_with_nozzle;
use crate::curved::strategy::Strategy;
use crate::curved::support::{NoSupport, SupportError, SupportOptions, Supported, add_support, missed_bound};
use crate::curved::surface::{LayerField, UniformError, UniformField, UniformMethod, jumps};

/// Rounds of support at most. Each solves field and reach anew, several times; what two do not carry are pits that no column gets to.
const SUPPORT_ROUNDS: u32 = 2;

impl Workpiece<'_> {
    /// The order by distance, or the directed one, and its audit.
    pub(crate) fn order_by_distance(
        &self,
        layers_by: LayersBy,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<PartOrder, LayersError> {
        let Workpiece { platform, rules, cell_mm, .. } = *self;
        let touching = self.touching(self.height_mm(options), progress)?;
        // Cells of the part that hold support on the plate begin there as well.
        let given = if options.support.is_some() { self.guides.support } else { &[] };
        let ordered = |cells: &Cells| {
            // Support stands wherever it stands.
            let is_part = |&cell: &u32| self.cells.contains(cells.position(cell));
            let is_base =
                |cell: &u32| !is_part(cell) || [&touching, given].iter().any(|list| list.binary_search(cell).is_ok());
            let base: Vec<u32> = carried(cells, platform, &rules).into_iter().filter(is_base).collect();
            match layers_by {
                LayersBy::Directed => {
                    let LayerOptions { rule, directed, .. } = options;
                    let given = self.guides.directions;
                    grow_directed(cells, cell_mm, platform, &rules, Some(&base), rule, given, directed, progress)
                }
                _ => match self.guides.heights {
                    Some(heights) => {
                        grow_by_heights(cells, cell_mm, platform, &rules, Some(&base), &options.rule, heights, progress)
                    }
                    None => grow_by_distance(cells, cell_mm, platform, &rules, Some(&base), &options.rule, progress),
                },
            }
        };
        let grow_in = |cells: &Cells| -> Result<(Growth, LayerField), GrowthError> {
            let DistanceOrder { growth, field, .. } = ordered(cells)?;
            if growth.missed.is_empty() || options.nozzle == NozzleUse::Off {
                return Ok((growth, field));
            }
            Ok((grow_with_nozzle(cells, cell_mm, platform, &rules, &options.rule, growth, progress)?, field))
        };
        let grow = |cells: &Cells| Ok(grow_in(cells)?.0);
        begin("distance", progress)?;
        let (growth, mut distances) = grow_in(&self.cells)?;
        let (mut supported, mut no_support) = (None, None);
        if !growth.missed.is_empty() || !given.is_empty() {
            no_support = Some(NoSupport::Forbidden).filter(|_| !growth.missed.is_empty());
            if let Some(options) = &options.support {
                begin("support", progress)?;
                let options = SupportOptions { rounds: options.rounds.min(SUPPORT_ROUNDS), ..*options };
                match add_support(&self.cells, platform, &rules, &growth, given, &options, &grow, progress)? {
                    Ok(found) => (supported, no_support) = (Some(found), None),
                    Err(why) => no_support = Some(why),
                }
            }
        }
        if let Some(mut found) = supported.take() {
            let field = regrown(&mut found, &self.cells, &grow_in)?;
            if found.growth.missed.len() < missed_bound(growth.missed.len(), given) {
                (supported, distances) = (Some(found), field);
            } else {
                no_support = Some(NoSupport::NoHelp);
            }
        }
        let mut order = PartOrder {
            layers_by,
            strategy: Strategy::Unbuild,
            growth,
            supported,
            no_support,
            missed_by_hull: Vec::new(),
            audit: AuditReport::default(),
            field: None,
            layers: None,
        };
        let united = order.united(&self.cells)?;
        let field = distance_layers(&united, &distances, &order.final_growth().order).map_err(UniformError::from)?;
        order.field = Some(field);
        order.audit = self.audited(&order, options, progress)?;
        Ok(order)
    }
}

/// Grows cells, and gives the field of the order.
type GrowIn<'a> = dyn Fn(&Cells) -> Result<(Growth, LayerField), GrowthError> + 'a;

/// Grows part and support again without support that is missed, which changes the field, until none is. Returns the field of that order.
fn regrown(found: &mut Supported, cells: &Cells, grow_in: &GrowIn) -> Result<LayerField, SupportError> {
    loop {
        let (growth, field) = grow_in(&Cells::new(cells.dims(), &found.rows)?)?;
        found.growth = growth;
        if !found.remove_missed(cells) {
            return Ok(field);
        }
    }
}

/// The field of an order by distance, or of a directed one, with its audit.
pub(super) fn field_by_distance(
    cells: &Cells,
    part: &Workpiece,
    found: &PartOrder,
    field: &LayerField,
    judged: &JudgedByNozzle,
    progress: ProgressFn,
) -> Result<UniformField, UniformError> {
    let Workpiece { platform, rules, .. } = part;
    let auditing = |p: Progress| progress(Progress { stage: "audit uniform", ..p });
    let (order, growth) = (field.order(), found.final_growth());
    let audit = if order == growth.order {
        // What was audited before.
        found.audit.clone()
    } else {
        audit_with_nozzle(cells, platform, rules, judged, &order, &growth.missed_cells(), &auditing)?
    };
    if !audit.is_ok() {
        return Err(UniformError::Order(Box::new(audit)));
    }
    let is_directed = found.layers_by == LayersBy::Directed;
    let method = if is_directed { UniformMethod::Directed } else { UniformMethod::Distance };
    Ok(UniformField { field: field.clone(), method, audit, jumps: jumps(field) })
}
