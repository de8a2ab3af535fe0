//! The steps of the stage, one after the other: each takes what the ones before have made.

use super::in_cells::PartInCells;
use super::options::{FieldOptions, Given};
use super::results::{FieldRun, Times};
use crate::estimate::{self, Memory};
use crate::guide::{GivenDirections, Guide, Guided};
use crate::order::Ordered;
use crate::surfaces::{self, SurfaceOptions, SurfacesRun};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::clock::StageClock;
use curvlay_layers::ProgressFn;
use curvlay_layers::curved::surface::SavedField;
use curvlay_layers::curved::{
    Guides, Impossible, LayerOptions, LayerQuality, LayersBy, Neighbours, NozzleUse, ProofError, Workpiece,
    check_impossible, layer_quality, prove_impossible,
};
use nalgebra::Vector3;

/// Makes the cells and their order, on a mould if there is one, and with options for them the surfaces; of a field that was `saved` if there is one.
pub fn run(
    options: &FieldOptions,
    surfaces: Option<&SurfaceOptions>,
    memory: Memory,
    given: Given,
    bars: &Bars,
) -> Result<(FieldRun, Option<SurfacesRun>), Failure> {
    let later = made(options, surfaces, given.saved.is_some());
    let in_cells = PartInCells::new(options, &given, (memory, later), bars)?;
    let clock = StageClock::default();
    let progress = |p: curvlay_layers::Progress| {
        clock.note(p.stage, p.done);
        bars.show(p.stage, p.done, p.total)
    };
    let Given { part, guide, saved, bare, .. } = given;
    let watch = Watch { part, clock: &clock, progress: &progress };
    let whole = in_cells.workpiece(part, options)?;
    let (workpiece, buried_mm3) = measured(whole, &in_cells, &watch)?;

    let layers = layer_options(options, surfaces);
    clock.note("grow", 0);
    let below = workpiece.cells_below(bare).map_err(|error| surfaces::failed(error, part))?;
    let workpiece = Workpiece { guides: Guides { support: &below, ..Guides::default() }, ..workpiece };
    let guided = guided(guide, &workpiece, in_cells.solid.shift, &layers)?;
    let workpiece = with_guides(workpiece, &guided);

    let mut ordered = ordered(saved, &workpiece, &layers, surfaces, &watch)?;
    let proven = Proven::new(&workpiece, &ordered.missed_by_hull, &watch)?;
    clock.stop();
    let finish = |(made, options)| surfaces::finish(options, made, &workpiece, &ordered.growth, part, &clock);
    let surfaces = ordered.made.take().zip(surfaces).map(finish).transpose()?;
    let times = Times::of(&clock, in_cells.inspect_time, in_cells.voxelise_time);
    let missed_mm3 = surfaces.as_ref().map(|surfaces| surfaces.missed_mm3);
    let figures = Figures::new(&workpiece, &ordered, (buried_mm3, missed_mm3), times, &watch)?;
    let guidance = Guidance { given: guided.given, below_beads: below.len() };
    Ok((field_run(in_cells, guidance, ordered, proven, figures), surfaces))
}

/// What is made of the cells before there are paths: it decides how much memory the run takes.
fn made(options: &FieldOptions, surfaces: Option<&SurfaceOptions>, is_saved: bool) -> estimate::Made {
    let LayerOptions { nozzle, support, strategy, layers_by, .. } = options.layers;
    let is_chosen_by_surfaces = strategy.is_none() && matches!(layers_by, LayersBy::Hull | LayersBy::Best);
    match (surfaces, is_saved, strategy) {
        (None, true, _) => estimate::Made::CompleteOrder,
        (Some(SurfaceOptions { layers: Some((pick, _)), .. }), true, _) => estimate::Made::SomeSurfaces(pick.share()),
        (Some(SurfaceOptions { layers: Some((pick, _)), coherent: false, .. }), false, _) if !is_chosen_by_surfaces => {
            estimate::Made::OrderAndSomeSurfaces(pick.share())
        }
        (None, false, Some(_)) if nozzle == NozzleUse::Off && support.is_none() => estimate::Made::OrderByHulls,
        (None, false, Some(_)) => estimate::Made::CompleteOrder,
        // The best strategy makes surfaces to choose, where cells are missed.
        _ => estimate::Made::Surfaces,
    }
}

/// Whose errors the steps name, and what they report to.
struct Watch<'a> {
    part: &'a Part,
    clock: &'a StageClock,
    progress: ProgressFn<'a>,
}

/// The part with the volume that is printed, and the volume that is not, since it lies in the mould. The volume of the part is that of its
/// mesh if that is exact, else that of its cells.
fn measured<'a>(
    workpiece: Workpiece<'a>,
    in_cells: &PartInCells,
    watch: &Watch,
) -> Result<(Workpiece<'a>, f64), Failure> {
    let &Watch { part, clock, progress } = watch;
    let failed = |error| surfaces::failed(error, part);
    let whole_mm3 = match in_cells.exact_mm3 {
        Some(exact_mm3) => exact_mm3,
        None => {
            clock.note("volume", 0);
            let all: Vec<u32> = workpiece.cells.iter().collect();
            workpiece.volume_of(&all, progress).map_err(failed)?
        }
    };
    let buried_mm3 = workpiece.volume_of(&in_cells.buried, progress).map_err(failed)?;
    Ok((Workpiece { volume_mm3: whole_mm3 - buried_mm3, ..workpiece }, buried_mm3))
}

/// How the part is layered. The height and the choice of coherent fields are those of the surfaces, where any are made.
fn layer_options(options: &FieldOptions, surfaces: Option<&SurfaceOptions>) -> LayerOptions {
    LayerOptions {
        height_mm: surfaces.map_or(options.layers.height_mm, |surfaces| surfaces.height_mm),
        coherent: surfaces.is_some_and(|surfaces| surfaces.coherent),
        ..options.layers
    }
}

/// What the user guides the order by, cell by cell; no guides where the order is searched.
fn guided(
    guide: Option<&Guide>,
    workpiece: &Workpiece,
    shift: Vector3<f64>,
    layers: &LayerOptions,
) -> Result<Guided, Failure> {
    guide.map_or_else(|| Ok(Guided::default()), |guide| guide.in_cells(workpiece, shift, layers))
}

/// The same part with these guides beside its support.
fn with_guides<'a>(workpiece: Workpiece<'a>, guided: &'a Guided) -> Workpiece<'a> {
    let (heights, directions) = (guided.heights.as_deref(), guided.directions.as_deref());
    Workpiece { guides: Guides { heights, directions, ..workpiece.guides }, ..workpiece }
}

/// The order that an earlier run has saved, or the one that is found now, with its layers if there are to be surfaces.
fn ordered(
    saved: Option<SavedField>,
    workpiece: &Workpiece,
    layers: &LayerOptions,
    surfaces: Option<&SurfaceOptions>,
    watch: &Watch,
) -> Result<Ordered, Failure> {
    let &Watch { part, clock, progress } = watch;
    match saved {
        Some(saved) => Ordered::saved(saved, workpiece, (layers, surfaces), (part, clock), progress),
        None => Ordered::grown(workpiece, layers, surfaces, part, progress),
    }
}

/// Which missed cells no order can build, with an independent check of each proof.
struct Proven {
    impossible: Vec<Impossible>,
    proofs: Result<(), ProofError>,
}

impl Proven {
    /// Of the cells that the order by the hull rule alone missed: proofs reason by that rule.
    fn new(workpiece: &Workpiece, missed_by_hull: &[u32], watch: &Watch) -> Result<Self, Failure> {
        let Workpiece { cells, platform, rules, .. } = workpiece;
        watch.clock.note("impossible", 0);
        let impossible = prove_impossible(cells, platform, rules, missed_by_hull, watch.progress)?;
        watch.clock.note("check", 0);
        let proofs = check_impossible(cells, platform, rules, &impossible);
        Ok(Proven { impossible, proofs })
    }
}

/// What is measured of the part and its order.
struct Figures {
    part_mm3: f64,
    buried_mm3: f64,
    missed_mm3: f64,
    contact_mm3: f64,
    quality: LayerQuality,
    times: Times,
}

impl Figures {
    /// The volume of missed cells is known already where there are surfaces.
    fn new(
        workpiece: &Workpiece,
        ordered: &Ordered,
        (buried_mm3, missed_mm3): (f64, Option<f64>),
        times: Times,
        watch: &Watch,
    ) -> Result<Self, Failure> {
        let Ordered { growth, contact, .. } = ordered;
        let volume_of = |cells: &[u32]| {
            workpiece.volume_of(cells, watch.progress).map_err(|error| surfaces::failed(error, watch.part))
        };
        let missed_mm3 = missed_mm3.map_or_else(|| volume_of(&growth.missed_cells()), Ok)?;
        // Cells that hold support and the part as well: what the part leaves of them is support.
        let contact_cells_mm3 = contact.len() as f64 * workpiece.cell_mm.powi(3);
        let contact_mm3 = contact_cells_mm3 - volume_of(contact)?;
        let quality = layer_quality(&workpiece.cells, &growth.order, Neighbours::FaceOrEdge);
        Ok(Figures { part_mm3: workpiece.volume_mm3, buried_mm3, missed_mm3, contact_mm3, quality, times })
    }
}

/// What the order was guided by.
struct Guidance {
    given: Option<GivenDirections>,
    below_beads: usize,
}

/// The results of the steps, together.
fn field_run(
    in_cells: PartInCells,
    Guidance { given, below_beads }: Guidance,
    ordered: Ordered,
    Proven { impossible, proofs }: Proven,
    figures: Figures,
) -> FieldRun {
    let PartInCells { mesh, thin, solid, platform, mould, exact_mm3, .. } = in_cells;
    let Figures { part_mm3, buried_mm3, missed_mm3, contact_mm3, quality, times } = figures;
    FieldRun {
        mesh,
        thin,
        solid,
        platform,
        mould,
        buried_mm3,
        growth: ordered.growth,
        layers_by: ordered.layers_by,
        strategy: ordered.strategy,
        audit: ordered.audit,
        missed_by_hull: ordered.missed_by_hull,
        given,
        below_beads,
        support: ordered.support,
        contact_mm3,
        straight_cells: ordered.straight_cells,
        steps_per_layer: ordered.steps_per_layer,
        no_support: ordered.no_support,
        impossible,
        proofs,
        quality,
        part_mm3,
        part_is_estimated: exact_mm3.is_none(),
        missed_mm3,
        times,
    }
}
