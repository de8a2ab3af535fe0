//! Tapes and thermoplastic of a specimen, in one machine file.

use super::specimens::Specimen;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::Point3;
use curvlay_toolpath::deposit::deposit_along;
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead, with_tapes};
use curvlay_toolpath::fiber::sandwich::{SandwichLayer, SandwichOptions, raise, sandwich};
use curvlay_toolpath::fiber::tapes::{TapeOptions, TapePlan, lay_tapes};
use curvlay_toolpath::fill::{FilledLayer, fill_layers};
use curvlay_toolpath::gcode::{Move, Tool, marked_moves};
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack, LayerSurface};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::path::{PathOptions, SurfacePath};
use curvlay_toolpath::plan::{PrintOptions, PrintPlan};
use std::time::{Duration, Instant};

/// Width of a bead: the nozzle of the dissertation has 1 mm.
pub const BEAD_MM: f64 = 1.0;

/// A specimen with its tapes and the moves of its print.
pub struct Planned {
    /// Which.
    pub specimen: Specimen,
    /// Its layers.
    pub schedule: Vec<SandwichLayer>,
    /// By layer.
    pub tapes: Vec<LayerTapes>,
    /// The plan of each of them.
    pub plans: Vec<TapePlan>,
    /// Tapes all over a layer along the same direction.
    pub filled: TapePlan,
    /// Thermoplastic; none if it was not asked for.
    pub print: Option<PrintPlan>,
    /// Everything, in order.
    pub moves: Vec<Move>,
    /// Time for its tapes.
    pub plan_time: Duration,
}

impl Planned {
    /// Length of all tapes in millimetres.
    pub fn tape_mm(&self) -> f64 {
        self.plans.iter().map(TapePlan::tape_mm).sum()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.plans.iter().map(|plan| plan.tapes.len()).sum()
    }

    /// Least share that is covered, greatest that is covered twice, least radius.
    pub fn cover(&self) -> [f64; 3] {
        let fold = |start: f64, pick: fn(f64, f64) -> f64, of: fn(&TapePlan) -> f64| {
            self.plans.iter().map(of).fold(start, pick)
        };
        [
            fold(1.0, f64::min, |plan| plan.cover.covered_fraction),
            fold(0.0, f64::max, |plan| plan.cover.overlap_fraction),
            fold(f64::INFINITY, f64::min, |plan| plan.min_radius_mm),
        ]
    }
}

/// Lays tapes along the specimen, on a part of one of its layers.
fn straight(specimen: &Specimen, mesh: Mesh, options: &TapeOptions, bars: &Bars) -> Result<TapePlan, Failure> {
    let surface = SurfaceMesh::new(mesh.vertices, mesh.triangles)?;
    let field = DirectionField::from_fn(&surface, |p| specimen.along(p))?;
    Ok(lay_tapes(&field, options, &|p| bars.show(p.stage, p.done, p.total))?)
}

/// Plans a specimen.
pub fn plan(
    specimen: Specimen,
    sandwich_options: &SandwichOptions,
    options: &TapeOptions,
    head: &TapeHead,
    nozzle: Option<&Nozzle>,
    bars: &Bars,
) -> Result<Planned, Failure> {
    let begin = Instant::now();
    let schedule = sandwich(specimen.layers, sandwich_options)?;
    let [_, width] = specimen.tape_mm;
    // What the dissertation lays: one tape of its width on each layer.
    let own = TapeOptions { width, spacing: width, min_length: head.blade, ..*options };
    let (mut tapes, mut plans) = (Vec::new(), Vec::new());
    for (number, layer) in schedule.iter().enumerate().filter(|(_, layer)| layer.carries_tape) {
        let height = (number as f64 + 1.0) * specimen.layer_mm;
        let plan = straight(&specimen, specimen.strip(height), &own, bars)?;
        tapes.push(LayerTapes {
            layer: number as u32,
            tool: Tool::Roller,
            lift: layer.raised,
            tapes: plan.tapes.clone(),
        });
        plans.push(plan);
    }
    let filled = straight(&specimen, specimen.surface(specimen.layer_mm), options, bars)?;
    let plan_time = begin.elapsed();
    let print = nozzle.map(|nozzle| thermoplastic(&specimen, &schedule, nozzle, bars)).transpose()?;
    let moves = match &print {
        Some(print) => {
            let moves = marked_moves(&print.deposition.moves, &print.resolved.paths);
            with_tapes(moves, &tapes, head)?.collect()
        }
        None => tapes.iter().map(|layer| head.moves(layer)).collect::<Result<Vec<_>, _>>()?.concat(),
    };
    Ok(Planned { specimen, schedule, tapes, plans, filled, print, moves, plan_time })
}

/// A plan whose layers are raised by the tapes below them: paths, travels, and what is laid.
pub fn raise_plan(
    mut plan: PrintPlan,
    schedule: &[SandwichLayer],
    options: &PrintOptions,
) -> Result<PrintPlan, Failure> {
    let PrintPlan { resolved, travels, .. } = &mut plan;
    for (way, path) in travels.ways.iter_mut().zip(&resolved.paths) {
        let raised = schedule[path.layer as usize].raised;
        way.iter_mut().for_each(|pose| pose.tip += pose.direction.into_inner() * raised);
    }
    raise(&mut resolved.paths, schedule)?;
    plan.deposition = deposit_along(&plan.resolved.paths, &plan.travels.ways, &options.deposition)?;
    Ok(plan)
}

/// A curve of a layer: its points, its widths, and whether it is closed.
type Curve = (Vec<Point3<f64>>, Vec<f64>, bool);

/// The layers of thermoplastic. An arc lies on its mould, which stands like a layer below the first.
fn thermoplastic(
    specimen: &Specimen,
    schedule: &[SandwichLayer],
    nozzle: &Nozzle,
    bars: &Bars,
) -> Result<PrintPlan, Failure> {
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let middle = |number: u32| specimen.surface((f64::from(number) + 0.5) * specimen.layer_mm);
    let layers: Vec<Mesh> = (0..specimen.layers).map(middle).collect();
    let thickness = |mesh: &Mesh| vec![specimen.layer_mm; mesh.triangles.len()];
    let heights: Vec<Vec<f64>> = layers.iter().map(thickness).collect();
    let surfaces: Vec<LayerSurface> = layers.iter().zip(&heights).map(surface).collect();
    let options = PathOptions { bead: BEAD_MM, coverage: false, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &progress)?;
    let curves: Vec<Vec<Curve>> = filled.layers.iter().map(|layer| layer.as_ref().map_or(Vec::new(), curves)).collect();
    let lent: Vec<Vec<LayerCurve>> = curves.iter().map(|curves| curves.iter().map(lent_curve).collect()).collect();
    let mould = specimen.mould();
    let below = mould.as_ref().map_or(Vec::new(), thickness);
    let mould = mould.as_ref().map(|Mesh { vertices, triangles }| BuiltLayer {
        vertices,
        triangles,
        spacing: &below,
        curves: &[],
    });
    let above = surfaces.iter().zip(&lent).map(|(surface, curves)| {
        let LayerSurface { vertices, triangles, thickness, .. } = *surface;
        BuiltLayer { vertices, triangles, spacing: thickness, curves }
    });
    let stack: Vec<BuiltLayer> = mould.into_iter().chain(above).collect();
    let options = PrintOptions::for_robot();
    let mut plan = LayerStack::new(&stack)?.plan(nozzle, &options, &progress)?;
    if specimen.is_curved() {
        // The mould is no layer of the part.
        plan.resolved.paths.iter_mut().for_each(|path| path.layer -= 1);
    }
    raise_plan(plan, schedule, &options)
}

fn surface<'a>((mesh, height): (&'a Mesh, &'a Vec<f64>)) -> LayerSurface<'a> {
    (&mesh.vertices[..], &mesh.triangles[..], &height[..]).into()
}

fn lent_curve((points, widths, closed): &Curve) -> LayerCurve<'_> {
    LayerCurve { points, widths, kinds: &[], closed: *closed }
}

fn curves(layer: &FilledLayer) -> Vec<Curve> {
    let curve = |path: &SurfacePath| {
        let points = path.points.iter().map(|point| point.at.position).collect();
        (points, path.points.iter().map(|point| point.width).collect(), path.closed)
    };
    layer.paths.paths.iter().map(curve).collect()
}
