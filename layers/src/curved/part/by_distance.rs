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

/// Finds orders of one kind, of the cells of a part with any support.
struct Grower<'a> {
    part: &'a Workpiece<'a>,
    layers_by: LayersBy,
    options: &'a LayerOptions,
    /// Cells of the part that touch what it stands on, and those that hold support: there orders begin.
    touching: Vec<u32>,
    held: &'a [u32],
    progress: ProgressFn<'a>,
}

impl Grower<'_> {
    /// The order that the nozzle reaches along the field.
    fn along_field(&self, cells: &Cells) -> Result<DistanceOrder, GrowthError> {
        let Workpiece { platform, rules, cell_mm, guides, .. } = self.part;
        let LayerOptions { rule, directed, .. } = self.options;
        // Support stands wherever it stands.
        let is_part = |&cell: &u32| self.part.cells.contains(cells.position(cell));
        let begins = |cell: &u32| [&self.touching[..], self.held].iter().any(|list| list.binary_search(cell).is_ok());
        let is_base = |cell: &u32| !is_part(cell) || begins(cell);
        let base: Vec<u32> = carried(cells, platform, rules).into_iter().filter(is_base).collect();
        let (base, progress) = (Some(&base[..]), self.progress);
        match (self.layers_by, guides.heights) {
            (LayersBy::Directed, _) => {
                grow_directed(cells, *cell_mm, platform, rules, base, rule, guides.directions, directed, progress)
            }
            (_, Some(heights)) => grow_by_heights(cells, *cell_mm, platform, rules, base, rule, heights, progress),
            (_, None) => grow_by_distance(cells, *cell_mm, platform, rules, base, rule, progress),
        }
    }

    /// That order, and after it what the nozzle reaches besides.
    fn grow(&self, cells: &Cells) -> Result<(Growth, LayerField), GrowthError> {
        let DistanceOrder { growth, field, .. } = self.along_field(cells)?;
        if growth.missed.is_empty() || self.options.nozzle == NozzleUse::Off {
            return Ok((growth, field));
        }
        let Workpiece { platform, rules, cell_mm, .. } = self.part;
        Ok((grow_with_nozzle(cells, *cell_mm, platform, rules, &self.options.rule, growth, self.progress)?, field))
    }

    /// Support for what an order misses, and for cells that were given; the field changes with it. `Err` says why there is none.
    fn support(&self, growth: &Growth) -> Result<Result<(Supported, LayerField), NoSupport>, LayersError> {
        let Workpiece { cells, platform, rules, .. } = self.part;
        let Some(options) = &self.options.support else { return Ok(Err(NoSupport::Forbidden)) };
        begin("support", self.progress)?;
        let options = SupportOptions { rounds: options.rounds.min(SUPPORT_ROUNDS), ..*options };
        let grow = |cells: &Cells| Ok(self.grow(cells)?.0);
        let found = add_support(cells, platform, rules, growth, self.held, &options, &grow, self.progress)?;
        let mut found = match found {
            Ok(found) => found,
            Err(why) => return Ok(Err(why)),
        };
        let field = regrown(&mut found, cells, &|cells: &Cells| self.grow(cells))?;
        let is_better = found.growth.missed.len() < missed_bound(growth.missed.len(), self.held);
        Ok(if is_better { Ok((found, field)) } else { Err(NoSupport::NoHelp) })
    }
}

impl Workpiece<'_> {
    /// The order by distance, or the directed one, and its audit.
    pub(crate) fn order_by_distance(
        &self,
        layers_by: LayersBy,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<PartOrder, LayersError> {
        let touching = self.touching(self.height_mm(options), progress)?;
        let held = if options.support.is_some() { self.guides.support } else { &[] };
        let grower = Grower { part: self, layers_by, options, touching, held, progress };
        begin("distance", progress)?;
        let (growth, mut distances) = grower.grow(&self.cells)?;
        let (mut supported, mut no_support) = (None, None);
        if !growth.missed.is_empty() || !held.is_empty() {
            match grower.support(&growth)? {
                Ok((found, field)) => (supported, distances) = (Some(found), field),
                // Without support nothing is wrong where nothing is missed.
                Err(why) => {
                    no_support = Some(why).filter(|&why| why != NoSupport::Forbidden || !growth.missed.is_empty())
                }
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
