//! Stage `field`: the order of the cells, grown or saved, and the surfaces that are made of it.

use crate::failure;
use crate::surfaces::{self, Made, SurfaceOptions};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::clock::StageClock;
use curvlay_layers::ProgressFn;
use curvlay_layers::curved::surface::{LayerField, SavedField, UniformField};
use curvlay_layers::curved::{
    AuditReport, Growth, JudgedByNozzle, LayerOptions, LayerSurfaces, LayeredPart, LayersBy, NoSupport, PartOrder,
    PartSupport, PlannedSurfaces, SupportCells, Workpiece, audit_with_nozzle,
};

/// How far apart surfaces are, in millimetres: as layers, or farther where no more than so many are made of a growth of this length.
fn apart_mm(options: &LayerOptions, surfaces: &SurfaceOptions, cell_mm: f64, growth_mm: f64) -> f64 {
    let layer_mm = options.height_mm.unwrap_or(cell_mm);
    surfaces.max_surfaces.map_or(layer_mm, |most| layer_mm.max(growth_mm / f64::from(most)))
}

/// Surfaces of the part and of its support.
type Surfaces = (LayerSurfaces, Option<PartSupport>);

/// The surfaces of the layers that were picked, with those near them.
fn picked(
    planned: &PlannedSurfaces,
    surfaces: &SurfaceOptions,
    part: &Part,
    progress: ProgressFn,
) -> Result<Surfaces, Failure> {
    let range = match surfaces.layers {
        Some((pick, neighbours)) => planned.with_neighbours(pick.layers(planned.len()).map_err(failure)?, neighbours),
        None => 0..planned.len(),
    };
    planned.make(range, progress).map_err(|error| surfaces::failed(error, part))
}

/// The field of an order, and its surfaces of the layers that were picked.
fn picked_of(
    order: &PartOrder,
    options: &LayerOptions,
    surfaces: &SurfaceOptions,
    workpiece: &Workpiece,
    part: &Part,
    progress: ProgressFn,
) -> Result<(UniformField, Surfaces), Failure> {
    let failed = |error| surfaces::failed(error, part);
    let uniform = workpiece.field_of(order, options, progress).map_err(failed)?;
    let (cells, missed) = (order.united(&workpiece.cells).map_err(failure)?, order.final_growth().missed_cells());
    let (support, height_mm) = (order.support_cells(), options.height_mm.unwrap_or(workpiece.cell_mm));
    let planned = PlannedSurfaces::new(workpiece, &uniform.field, cells.rows(), support, &missed, height_mm, progress)
        .map_err(failed)?;
    let made = picked(&planned, surfaces, part, progress)?;
    Ok((uniform, made))
}

/// An order of the cells.
pub struct Ordered {
    pub growth: Growth,
    /// Cells that the order by the hull rule alone missed.
    pub missed_by_hull: Vec<u32>,
    pub strategy: &'static str,
    /// What found it; none for a saved one.
    pub layers_by: Option<LayersBy>,
    pub audit: AuditReport,
    /// Cells of support outside of the part, those of the part that hold support as well, and what straight columns would take.
    pub support: Vec<u32>,
    pub contact: Vec<u32>,
    pub straight_cells: usize,
    /// Layers of the order that are printed as one.
    pub steps_per_layer: u32,
    pub no_support: Option<NoSupport>,
    /// Its layers, if surfaces are made.
    pub made: Option<Made>,
}

impl Ordered {
    /// The order that an earlier run has saved.
    pub fn saved(
        saved: SavedField,
        workpiece: &Workpiece,
        (options, surfaces): (&LayerOptions, Option<&SurfaceOptions>),
        (part, clock): (&Part, &StageClock),
        progress: ProgressFn,
    ) -> Result<Self, Failure> {
        let Workpiece { platform, rules, cell_mm, .. } = *workpiece;
        let growth = saved.growth()?;
        let (support, contact) = (saved.aids.support.clone(), saved.aids.contact.clone());
        let steps = saved.field.steps_per_layer();
        let judged = JudgedByNozzle { rule: saved.aids.rule, cell_mm, steps, cells: &growth.nozzle };
        let missed = growth.missed_cells();
        clock.note("audit", 0);
        let order = saved.field.order();
        let audit = audit_with_nozzle(&saved.cells()?, platform, &rules, &judged, &order, &missed, progress)
            .map_err(failure)?;
        let cells = SupportCells { cells: &support, contact: &contact };
        let layers = surfaces.map(|surfaces| {
            let failed = |error| surfaces::failed(error, part);
            let growth_mm = saved.field.highest() * saved.field.layer_cells() * cell_mm;
            let asked_mm = apart_mm(options, surfaces, cell_mm, growth_mm);
            let planned =
                PlannedSurfaces::new(workpiece, &saved.field, &saved.rows, cells, &missed, asked_mm, progress)
                    .map_err(failed)?;
            Ok::<_, Failure>((picked(&planned, surfaces, part, progress)?, asked_mm))
        });
        let made = layers.transpose()?.map(|((layers, support), asked_mm)| {
            let SavedField { field, aids, .. } = saved;
            Made { layers, support, field, aids, method: "saved".to_owned(), waits: 0, asked_mm }
        });
        let (missed_by_hull, strategy) = (missed, "saved");
        let (layers_by, straight_cells, no_support) = (None, 0, None);
        Ok(Ordered {
            growth,
            missed_by_hull,
            strategy,
            layers_by,
            audit,
            support,
            contact,
            straight_cells,
            steps_per_layer: steps,
            no_support,
            made,
        })
    }

    /// The order that is found now, with its layers if there are to be surfaces. There are none of one that fails its audit.
    pub fn grown(
        workpiece: &Workpiece,
        options: &LayerOptions,
        surfaces: Option<&SurfaceOptions>,
        part: &Part,
        progress: ProgressFn,
    ) -> Result<Self, Failure> {
        let failed = |error| surfaces::failed(error, part);
        let order = workpiece.order(options, progress).map_err(failed)?;
        let strategy = match order.layers_by {
            LayersBy::Distance => "distance",
            LayersBy::Directed => "directed",
            _ => order.strategy.name(),
        };
        let SupportCells { cells: support, contact } = order.support_cells();
        let mut ordered = Ordered {
            growth: order.final_growth().clone(),
            missed_by_hull: order.missed_by_hull.clone(),
            strategy,
            layers_by: Some(order.layers_by),
            audit: order.audit.clone(),
            support: support.to_vec(),
            contact: contact.to_vec(),
            straight_cells: order.supported.as_ref().map_or(0, |supported| supported.straight_cells),
            steps_per_layer: order.field.as_ref().map_or(1, LayerField::steps_per_layer),
            no_support: order.no_support,
            made: None,
        };
        if let Some(surfaces) = surfaces.filter(|_| order.audit.is_ok()) {
            let cells = match &order.field {
                Some(field) => field.highest() * field.layer_cells(),
                None => order.final_growth().order.len() as f64,
            };
            let cell_mm = workpiece.cell_mm;
            let asked_mm = apart_mm(options, surfaces, cell_mm, cells * cell_mm);
            let made = LayerOptions { height_mm: Some(asked_mm), ..*options };
            // Which field is more coherent shows only in all surfaces.
            let (uniform, layers) = if surfaces.layers.is_some() && !options.coherent {
                picked_of(&order, &made, surfaces, workpiece, part, progress)?
            } else {
                let LayeredPart { uniform, surfaces, support, .. } =
                    workpiece.layers_of(order, &made, progress).map_err(failed)?;
                (uniform, (surfaces, support))
            };
            ordered.made = Some(Made::of(uniform, layers, &ordered.growth, options.rule, asked_mm));
        }
        Ok(ordered)
    }
}
