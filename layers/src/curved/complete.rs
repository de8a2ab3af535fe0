//! A part made complete: by the hull rule, then by the nozzle that prints, then with support.
//!
//! The hull rule lets a nozzle of any size pass, and what it builds is built first. What it misses is built where [the nozzle that prints](super::grow_with_nozzle)
//! reaches it. What is still missed gets [support](super::add_support), and part and support are grown together; if cells are missed all the same, what the
//! hull rule misses is supported in place of what the nozzle misses. One field goes over
//! both; its surfaces are trimmed to the mesh for the part, and to the skin of the support's cells for the support, so layer `k` of the one
//! and layer `k` of the other are printed together.

use super::audit::{AuditReport, JudgedByNozzle, audit_with_nozzle};
use super::cells::Cells;
use super::growth::{Growth, GrowthError};
use super::nozzle::{NozzleRule, grow_with_nozzle};
use super::strategy::Strategy;
use super::support::{CellMesh, SupportError, SupportOptions, Supported, add_support, cell_mesh};
use super::surface::{extend, uniform_field_with_nozzle};
use super::workpiece::{LayerSurfaces, LayeredPart, LayersError, OrderedPart, Workpiece, begin};
use crate::Progress;
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

/// How a part is made complete.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct CompleteOptions {
    /// When cells are judged by the nozzle. Default: after the hull rule.
    pub nozzle: NozzleUse,
    /// The nozzle.
    pub rule: NozzleRule,
    /// Support for what is missed; `None` for no support. Default: columns as [`SupportOptions`] has them.
    pub support: Option<SupportOptions>,
}

impl Default for CompleteOptions {
    fn default() -> Self {
        let support = Some(SupportOptions::default());
        CompleteOptions { nozzle: NozzleUse::default(), rule: NozzleRule::default(), support }
    }
}

/// A part in layers, with what it took to make it complete.
#[derive(Clone, Debug)]
pub struct CompletePart {
    /// The layers. With support the order, the field and the audit are those of part and support together; the surfaces are the part's.
    pub layered: LayeredPart,
    /// Cells that the order by the hull rule alone missed, by rising number.
    pub missed_by_hull: Vec<u32>,
    /// The support; `None` if there is none.
    pub support: Option<PartSupport>,
}

/// The support of a part.
#[derive(Clone, Debug)]
pub struct PartSupport {
    /// The cells of part and support together, as [`Cells`] takes them: the field is of these.
    pub rows: Vec<u64>,
    /// The cells of the support, by rising number.
    pub cells: Vec<u32>,
    /// Cells that straight columns from the plate below all missed cells would have.
    pub straight_cells: usize,
    /// The skin of its cells.
    pub mesh: CellMesh,
    /// Its surfaces, as many as those of the part, layer by layer; some may be empty.
    pub surfaces: LayerSurfaces,
}

/// An order of part and support, before it is layered.
struct Completed {
    growth: Growth,
    support: Option<Supported>,
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
    /// That of [`Workpiece::layers`] if it misses nothing. Else that of a choice between two orders, of [`grow_with_nozzle`], of [`add_support`], and
    /// of one more set of surfaces, two with support.
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
        self.check_volume()?;
        options.rule.check().map_err(GrowthError::from)?;
        let ordered = self.order(strategy, height_mm, progress)?;
        let missed_by_hull = ordered.growth.missed_cells();
        if missed_by_hull.is_empty() && options.nozzle != NozzleUse::FromStart {
            return Ok(CompletePart {
                layered: self.layered(ordered, height_mm, progress)?,
                missed_by_hull,
                support: None,
            });
        }
        let OrderedPart { strategy: taken, growth, .. } = ordered;
        let mut completed = self.completed(strategy, growth, options, progress)?;
        let mut audit = self.audited(&completed, options, progress)?;
        if completed.support.is_some() && !audit.is_ok() {
            completed.support = None;
            audit = self.audited(&completed, options, progress)?;
        }
        let (layered, support) = self.of_completed(taken, completed, audit, height_mm, options, progress)?;
        Ok(CompletePart { layered, missed_by_hull, support })
    }

    /// The cells of part and support, and their order.
    fn united<'a>(&'a self, completed: &'a Completed) -> Result<(Cells<'a>, &'a Growth), LayersError> {
        match &completed.support {
            Some(Supported { rows, growth, .. }) => {
                Ok((Cells::new(self.cells.dims(), rows).map_err(SupportError::from)?, growth))
            }
            None => Ok((self.cells, &completed.growth)),
        }
    }

    fn audited(
        &self,
        completed: &Completed,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<AuditReport, LayersError> {
        let (cells, growth) = self.united(completed)?;
        let judged = JudgedByNozzle { rule: options.rule, cell_mm: self.cell_mm, cells: &growth.nozzle };
        let missed = growth.missed_cells();
        begin("audit", progress)?;
        Ok(audit_with_nozzle(&cells, self.platform, &self.rules, &judged, &growth.order, &missed, progress)?)
    }

    /// The order of [`Workpiece::complete_layers`], without surfaces.
    fn completed(
        &self,
        strategy: Option<Strategy>,
        growth: Growth,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Completed, LayersError> {
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
        let by_hull_alone = growth.clone();
        let growth = with_nozzle(&self.cells, growth)?;
        let mut support = None;
        if let Some(options) = &options.support {
            // What the nozzle leaves can lie between what it has built, where no column gets: then all that the hull rule misses is supported.
            for below in [&growth, &by_hull_alone] {
                let left = support.as_ref().map_or(growth.missed.len(), |best: &Supported| best.growth.missed.len());
                if left > 0 {
                    begin("support", progress)?;
                    let found = add_support(&self.cells, platform, rules, below, options, &grow, progress)?;
                    support = found.filter(|found| found.growth.missed.len() < left).or(support);
                }
            }
        }
        Ok(Completed { growth, support })
    }

    /// Field and surfaces of a completed order.
    fn of_completed(
        &self,
        strategy: Strategy,
        completed: Completed,
        audit: AuditReport,
        height_mm: f64,
        options: &CompleteOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<(LayeredPart, Option<PartSupport>), LayersError> {
        let Workpiece { platform, rules, cell_mm, origin, .. } = *self;
        let (cells, growth) = self.united(&completed)?;
        let growth = growth.clone();
        let judged = JudgedByNozzle { rule: options.rule, cell_mm, cells: &growth.nozzle };
        let missed = growth.missed_cells();
        begin("uniform", progress)?;
        let uniform = uniform_field_with_nozzle(&cells, platform, &rules, &judged, &growth.order, &missed, progress)?;
        begin("contour", progress)?;
        let extended = extend(&uniform.field, &cells);
        let levels = extended.fitted_levels(self.vertices, self.triangles, cell_mm, origin, height_mm)?;
        let united = Workpiece { cells, ..*self };
        let surfaces = united.surfaces_at(&extended, &levels, &missed, progress)?;
        let mut of_support = None;
        if let Some(Supported { rows, support, straight_cells, .. }) = &completed.support {
            let mesh = cell_mesh(&cells, support, cell_mm, origin);
            let of_mesh = Workpiece { vertices: &mesh.vertices, triangles: &mesh.triangles, ..united };
            let surfaces = of_mesh.surfaces_at(&extended, &levels, &[], progress)?;
            let (rows, cells, straight_cells) = (rows.clone(), support.clone(), *straight_cells);
            of_support = Some(PartSupport { rows, cells, straight_cells, mesh, surfaces });
        }
        Ok((LayeredPart { strategy, growth, audit, uniform, surfaces }, of_support))
    }
}
