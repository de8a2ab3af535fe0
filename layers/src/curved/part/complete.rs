//! A part made complete: by the hull rule, then by the nozzle that prints, then with support.
//!
//! The hull rule lets a nozzle of any size pass, and what it builds is built first. What it misses is built where [the nozzle that prints](crate::curved::grow_with_nozzle)
//! reaches it. What is still missed gets [support](crate::curved::add_support), and part and support are grown together; if cells are missed all the same, what the
//! hull rule misses is supported in place of what the nozzle misses. One field goes over
//! both; its surfaces are trimmed to the mesh for the part, and to the skin of the support's cells for the support, so layer `k` of the one
//! and layer `k` of the other are printed together.

use super::distance::by_distance;
use super::workpiece::{BORDER_EDGE, LayerSurfaces, LayeredPart, LayersError, OrderedPart, Workpiece, begin};
use crate::Progress;
use crate::cells::Cells;
use crate::curved::audit::{AuditReport, JudgedByNozzle, audit_with_nozzle};
use crate::curved::distance::{DirectedOptions, STEPS_PER_LAYER};
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::nozzle::{NozzleRule, grow_with_nozzle};
use crate::curved::strategy::Strategy;
use crate::curved::support::{
    CellMesh, NoSupport, SupportError, SupportOptions, Supported, add_support, cell_mesh, missed_bound,
};
use crate::curved::surface::{LayerField, extend, uniform_field_with_nozzle};
use crate::trim::Trimmer;
use nalgebra::Point3;
use std::ops::ControlFlow;

/// When cells are judged by the nozzle that prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum NozzleUse {
    /// Never: the hull rule alone.
    Off,
    /// After the order by the hull rule: cells that it misses.
    #[default]
    After,
    /// From the start on: each cell by either rule.
    FromStart,
}

/// By what the order of the cells is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum LayersBy {
    /// By convex hulls, which let a nozzle of any size pass; what they miss is built by the nozzle that prints.
    #[default]
    Hull,
    /// By the [distance](crate::curved::distance_field) from what the part stands on, as far as the nozzle that prints reaches.
    Distance,
    /// By a field that follows the distance, but leans no more than the nozzle's cone allows ([`grow_directed`](crate::curved::grow_directed)).
    Directed,
    /// The first of [`LayersBy::TRIED`] that misses no cell and passes its audit; if there is none, the one that misses the fewest.
    Best,
}

impl LayersBy {
    /// The orders that [`LayersBy::Best`] tries, one after the other.
    pub const TRIED: [LayersBy; 3] = [LayersBy::Directed, LayersBy::Distance, LayersBy::Hull];

    /// Steps of the order to a layer.
    fn steps(self) -> u32 {
        if matches!(self, LayersBy::Distance | LayersBy::Directed) { STEPS_PER_LAYER } else { 1 }
    }
}

/// How a part is made complete.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct CompleteOptions {
    /// By what the order is found. Default: by hulls.
    pub layers_by: LayersBy,
    /// When cells are judged by the nozzle. Default: after the hull rule.
    pub nozzle: NozzleUse,
    /// The nozzle.
    pub rule: NozzleRule,
    /// What a directed field is to be like.
    pub directed: DirectedOptions,
    /// Support for what is missed; `None` for no support. Default: columns as [`SupportOptions`] has them.
    pub support: Option<SupportOptions>,
}

impl Default for CompleteOptions {
    fn default() -> Self {
        let support = Some(SupportOptions::default());
        let layers_by = LayersBy::default();
        let (nozzle, rule, directed) = (NozzleUse::default(), NozzleRule::default(), DirectedOptions::default());
        CompleteOptions { layers_by, nozzle, rule, directed, support }
    }
}

/// A part in layers, with what it took to make it complete.
#[derive(Clone, Debug)]
pub struct CompletePart {
    /// By what the order was found: hulls or distance.
    pub layers_by: LayersBy,
    /// The layers. With support the order, the field and the audit are those of part and support together; the surfaces are the part's.
    pub layered: LayeredPart,
    /// Cells that the order by the hull rule alone missed, by rising number; none for an order by distance.
    pub missed_by_hull: Vec<u32>,
    /// The support; `None` if there is none.
    pub support: Option<PartSupport>,
    /// Why there is none, where cells are missed.
    pub no_support: Option<NoSupport>,
}

/// The support of a part.
#[derive(Clone, Debug)]
pub struct PartSupport {
    /// The cells of part and support together, as [`Cells`] takes them: the field is of these.
    pub rows: Vec<u64>,
    /// The cells of the support, by rising number.
    pub cells: Vec<u32>,
    /// The cells between support and part that stay empty, by rising number.
    pub gap: Vec<u32>,
    /// Cells of the part that hold support beside its material, where the two touch, by rising number.
    pub contact: Vec<u32>,
    /// Cells that straight columns from the plate below all missed cells would have; 0 for a saved field, which does not say.
    pub straight_cells: usize,
    /// The skin of its cells, those where it touches the part included. The support ends at it, and at the mesh of the part.
    pub mesh: CellMesh,
    /// Its surfaces, as many as those of the part, layer by layer; some may be empty.
    pub surfaces: LayerSurfaces,
}

/// The order of a part, and of its support if it has any, before it is layered.
#[derive(Clone, Debug)]
pub struct CompleteOrder {
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
}

/// Cells of the support of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportCells<'a> {
    /// Those outside of the part, by rising number.
    pub cells: &'a [u32],
    /// Those of the part that hold support beside its material, by rising number.
    pub contact: &'a [u32],
}

impl CompleteOrder {
    /// The cells of the support; none without.
    pub fn support_cells(&self) -> SupportCells<'_> {
        match &self.supported {
            Some(Supported { support: cells, contact, .. }) => SupportCells { cells, contact },
            None => SupportCells::default(),
        }
    }

    /// The order that counts: that of part and support, or of the part where there is no support.
    pub fn taken(&self) -> &Growth {
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
}

impl Workpiece<'_> {
    /// Layers the part as [`Workpiece::layers`] does, and makes it complete: with the nozzle that prints, and with support.
    ///
    /// Support is taken if with it fewer cells are missed and the audit passes; else the part goes without.
    ///
    /// # Arguments
    /// * `strategy`, `height_mm`: as in [`Workpiece::layers`].
    /// * `progress`: called with the stages `nozzle` and `support` as well; may cancel.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`Workpiece::complete_order`], and of one more set of surfaces, two with support.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: `part.complete_layers(None, 0.75, &CompleteOptions::default(), &progress)?.layered`.
    pub fn complete_layers(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompletePart, LayersError> {
        let order = self.complete_order(strategy, height_mm, options, progress)?;
        self.layers_of_complete(order, height_mm, options, progress)
    }

    /// The order that [`Workpiece::complete_layers`] makes layers of, with the same arguments.
    ///
    /// # Errors
    /// [`LayersError`]. Cells that are missed all the same are no error: they are listed in the growth.
    ///
    /// # Cost
    /// That of [`Workpiece::order`] if it misses nothing. Else that of [`grow_with_nozzle`] and of [`add_support`] as well.
    pub fn complete_order(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompleteOrder, LayersError> {
        self.check_volume()?;
        options.rule.check().map_err(GrowthError::from)?;
        if options.layers_by != LayersBy::Best {
            return self.order_by(options.layers_by, strategy, height_mm, options, progress);
        }
        let faults = |order: &CompleteOrder| (!order.audit.is_ok(), order.taken().missed.len());
        let [first, others @ ..] = LayersBy::TRIED;
        let mut best = self.order_by(first, strategy, height_mm, options, progress)?;
        for layers_by in others {
            if faults(&best) == (false, 0) {
                break;
            }
            let order = self.order_by(layers_by, strategy, height_mm, options, progress)?;
            if faults(&order) < faults(&best) {
                best = order;
            }
        }
        Ok(best)
    }

    /// The complete order of one kind.
    fn order_by(
        &self,
        layers_by: LayersBy,
        strategy: Option<Strategy>,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompleteOrder, LayersError> {
        match layers_by {
            LayersBy::Hull => self.order_by_hulls(strategy, height_mm, options, progress),
            layers_by => self.order_by_distance(layers_by, height_mm, options, progress),
        }
    }

    /// The order by the hull rule, made complete.
    fn order_by_hulls(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompleteOrder, LayersError> {
        let layers_by = LayersBy::Hull;
        let OrderedPart { strategy: taken, growth, audit } = self.order(strategy, height_mm, progress)?;
        let missed_by_hull = growth.missed_cells();
        let no_support = (!missed_by_hull.is_empty()).then_some(NoSupport::Forbidden);
        let mut order = CompleteOrder {
            layers_by,
            strategy: taken,
            growth,
            supported: None,
            no_support,
            missed_by_hull,
            audit,
            field: None,
        };
        let is_left = options.nozzle != NozzleUse::Off || options.support.is_some();
        let is_whole = order.missed_by_hull.is_empty() && self.guides.support.is_empty();
        if options.nozzle != NozzleUse::FromStart && (is_whole || !is_left) {
            return Ok(order);
        }
        self.complete(strategy, &mut order, options, progress)?;
        order.audit = self.audited(&order, options, progress)?;
        if order.supported.is_some() && !order.audit.is_ok() {
            order.supported = None;
            order.no_support = Some(NoSupport::Unsound);
            order.audit = self.audited(&order, options, progress)?;
        }
        Ok(order)
    }

    pub(crate) fn audited(
        &self,
        order: &CompleteOrder,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<AuditReport, LayersError> {
        let (cells, growth) = (order.united(&self.cells)?, order.taken());
        let judged = JudgedByNozzle {
            rule: options.rule,
            cell_mm: self.cell_mm,
            steps: order.layers_by.steps(),
            cells: &growth.nozzle,
        };
        let missed = growth.missed_cells();
        begin("audit", progress)?;
        Ok(audit_with_nozzle(&cells, self.platform, &self.rules, &judged, &growth.order, &missed, progress)?)
    }

    /// Goes on with an order by the hull rule: by the nozzle, and with support.
    fn complete(
        &self,
        strategy: Option<Strategy>,
        order: &mut CompleteOrder,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<(), LayersError> {
        let Workpiece { platform, rules, cell_mm, .. } = *self;
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

    /// Field and surfaces of a complete order.
    ///
    /// # Arguments
    /// * `height_mm`, `options`: those of the order.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// Once that of [`Workpiece::surfaces`], twice with support, and of the field.
    pub fn layers_of_complete(
        &self,
        order: CompleteOrder,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<CompletePart, LayersError> {
        let Workpiece { platform, rules, cell_mm, .. } = *self;
        let (cells, growth) = (order.united(&self.cells)?, order.taken());
        let judged =
            JudgedByNozzle { rule: options.rule, cell_mm, steps: order.layers_by.steps(), cells: &growth.nozzle };
        let missed = growth.missed_cells();
        begin("uniform", progress)?;
        let uniform = match &order.field {
            Some(field) => by_distance(&cells, self, &order, field, &judged, progress)?,
            None => uniform_field_with_nozzle(&cells, platform, &rules, &judged, &growth.order, &missed, progress)?,
        };
        let (surfaces, mut support) = self.surfaces_and_support(
            &uniform.field,
            cells.rows(),
            order.support_cells(),
            &missed,
            height_mm,
            progress,
        )?;
        support.iter_mut().zip(&order.supported).for_each(|(made, found)| made.straight_cells = found.straight_cells);
        let growth = growth.clone();
        let CompleteOrder { layers_by, strategy, missed_by_hull, no_support, audit, .. } = order;
        Ok(CompletePart {
            layers_by,
            layered: LayeredPart { strategy, growth, audit, uniform, surfaces },
            missed_by_hull,
            support,
            no_support,
        })
    }

    /// The surfaces of a field over part and support: those of the part, and those of its support if it has any.
    ///
    /// # Arguments
    /// * `field`: e.g. a saved one.
    /// * `rows`: the cells of part and support, as [`Cells`] takes them.
    /// * `support`: those that are support; none for a part without. Cells of `rows` that are neither part nor support get no surfaces.
    /// * `missed`: cells of the part without a value.
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: as in [`Workpiece::surfaces`].
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`Workpiece::surfaces`], twice with support.
    pub fn surfaces_and_support(
        &self,
        field: &LayerField,
        rows: &[u64],
        support: SupportCells,
        missed: &[u32],
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<(LayerSurfaces, Option<PartSupport>), LayersError> {
        let Workpiece { cell_mm, origin, .. } = *self;
        let cells = Cells::new(self.cells.dims(), rows).map_err(SupportError::from)?;
        begin("contour", progress)?;
        let extended = extend(field, &cells);
        let levels = extended.fitted_levels(self.vertices, self.triangles, cell_mm, origin, height_mm)?;
        let united = Workpiece { cells, ..*self };
        begin("trim", progress)?;
        let min_edge_mm = BORDER_EDGE * height_mm;
        let trimmer = Trimmer::new(self.vertices, self.triangles)?.thinned(min_edge_mm);
        let surfaces = united.surfaces_at(&extended, &levels, trimmer, missed, progress)?;
        let SupportCells { cells: of_support, contact } = support;
        if of_support.is_empty() && contact.is_empty() {
            return Ok((surfaces, None));
        }
        let mesh = cell_mesh(&cells, &[of_support, contact].concat(), cell_mm, origin);
        let skin = (&mesh.vertices[..], &mesh.triangles[..]);
        let trimmer = match contact {
            [] => Trimmer::new(skin.0, skin.1)?,
            _ => Trimmer::new_outside(skin, (self.vertices, self.triangles))?,
        };
        let made = united.surfaces_at(&extended, &levels, trimmer.thinned(min_edge_mm), &[], progress)?;
        // What is neither part nor support stays empty.
        let is_of_part = |cell: u32| self.cells.contains(self.cells.position(cell));
        let gap = cells.iter().filter(|&cell| !is_of_part(cell) && of_support.binary_search(&cell).is_err()).collect();
        let (rows, cells, contact) = (rows.to_vec(), of_support.to_vec(), contact.to_vec());
        Ok((surfaces, Some(PartSupport { rows, cells, gap, contact, straight_cells: 0, mesh, surfaces: made })))
    }
}

/// What is printed of one layer: the surface of the part, then that of its support.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrintedSheet {
    /// Points in millimetres.
    pub vertices: Vec<Point3<f64>>,
    /// Triangles, those of the part first.
    pub triangles: Vec<[u32; 3]>,
    /// Thickness of the layer at each triangle, in millimetres.
    pub thickness_mm: Vec<f64>,
    /// How many of the triangles are the part's; those after them are support.
    pub part_triangles: usize,
    /// Whether it is a half layer ([`LayerField::with_half_layers`]).
    pub is_half: bool,
}

impl PartSupport {
    /// The layers of the part and of this support together, first to last: all that planning their tool paths takes.
    pub fn printed_with(&self, part: &LayerSurfaces) -> Vec<PrintedSheet> {
        let both = part.iter().zip(self.surfaces.iter());
        let printed = both.map(|((points, triangles, thickness, is_half), of_support)| {
            let first = points.len() as u32;
            let moved = of_support.1.iter().map(|corners| corners.map(|corner| first + corner));
            PrintedSheet {
                vertices: [points, of_support.0].concat(),
                triangles: triangles.iter().copied().chain(moved).collect(),
                thickness_mm: [thickness, of_support.2].concat(),
                part_triangles: triangles.len(),
                is_half,
            }
        });
        printed.collect()
    }
}
