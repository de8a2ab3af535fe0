//! A whole part with tapes in chosen layers: thermoplastic and fibre in one machine file.
//!
//! C. Dai 2020, section 5.3.1: a layer of thermoplastic is the substrate of the tapes, the next one embeds them. Tapes lie on the top of their layer, along
//! the principal stresses there, where beads lie below and above them.

use super::follow_load::FollowedLoad;
use super::layer::{LoadedLayer, PartLayers, PartStress, Reinforced, Solved};
use super::part_motion::{self, PartMotion};
use super::specimens::Specimen;
use super::tapes::raise_plan;
use super::{Args, Given, Stage, arcs, predict, wires};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::nozzle_of;
use curvlay_examples::nalgebra::Point3;
use curvlay_toolpath::fiber::bedding::{Roller, TapeBedding, bedded_surface, tape_bedding};
use curvlay_toolpath::fiber::conductor::ConductorOptions;
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead, with_tapes};
use curvlay_toolpath::fiber::sandwich::{SandwichLayer, SandwichOptions, sandwich, sandwich_on};
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::fill::{FillLayersError, FilledLayers, fill_layers};
use curvlay_toolpath::gcode::{Move, Tool, marked_moves};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::path::PathOptions;
use curvlay_toolpath::plan::{PrintOptions, PrintPlan};
use curvlay_toolpath::support::SupportOptions;
use std::time::{Duration, Instant};

/// Width of a bead by the height of its layer where neither is given: 1 mm on 0.6 mm, as in the dissertation (section 5.3.2).
const BEAD_BY_HEIGHT: f64 = 1.0 / 0.6;

/// A layer with tapes.
pub struct TapedLayer {
    /// Which, from 0.
    pub number: u32,
    /// Its stresses and tapes; the surface is the top of the layer, where beads lie below and above it.
    pub loaded: LoadedLayer,
    /// Share of the layer's area where that is so.
    pub bedded_share: f64,
}

/// A part in layers, some of them with tapes.
pub struct PartRun {
    /// Its name.
    pub name: String,
    /// Its layers.
    pub layers: PartLayers,
    /// Width of a bead in millimetres.
    pub bead_mm: f64,
    /// Which of them carry tapes, and what raises them.
    pub schedule: Vec<SandwichLayer>,
    /// Those that do.
    pub taped: Vec<TapedLayer>,
    /// What is laid on them: tapes by the roller, wires by the roller for conductors.
    pub tapes: Vec<LayerTapes>,
    /// Number of wires, and their length in millimetres.
    pub wires: (usize, f64),
    /// Where stresses come from, in words.
    pub source: String,
    /// The work of the solver.
    pub solved: Option<Solved>,
    /// What the tapes do under the load; none with stresses of a file.
    pub reinforced: Option<Reinforced>,
    /// Directions in which layers would follow the load.
    pub followed: Option<FollowedLoad>,
    /// Thermoplastic; none if it was not asked for.
    pub print: Option<PrintPlan>,
    /// What tapes lie on, and what lies on them; none without thermoplastic.
    pub bedding: Option<TapeBedding>,
    /// Everything, in order.
    pub moves: Vec<Move>,
    /// The robot's; none if it was not asked for.
    pub motion: Option<PartMotion>,
    /// Time for directions and tapes.
    pub plan_time: Duration,
}

impl PartRun {
    /// Height of the layers in millimetres.
    pub fn height_mm(&self) -> f64 {
        self.layers.layered.surfaces.height_mm
    }

    /// Tapes of the roller: how many, and their length in millimetres.
    pub fn of_roller(&self) -> (usize, f64) {
        let plans = || self.taped.iter().map(|layer| &layer.loaded.plan);
        (plans().map(|plan| plan.tapes.len()).sum(), plans().map(|plan| plan.tape_mm()).fold(0.0, |sum, mm| sum + mm))
    }
}

/// The schedule that was asked for.
fn schedule(args: &Args, surfaces: &[LayerSurface]) -> Result<Vec<SandwichLayer>, Failure> {
    let count = surfaces.len() as u32;
    let offset = args.sandwich().offset;
    if args.layers.is_empty() {
        let options = SandwichOptions { base: args.every, every: args.every, cover: 1, offset };
        return sandwich(count, &options).map_err(|error| Failure::of_arguments(format!("--every: {error}")));
    }
    let chosen: Vec<u32> = args.layers.iter().map(|layer| layer - 1).collect();
    let schedule =
        sandwich_on(count, &chosen, offset).map_err(|error| Failure::of_arguments(format!("--layers: {error}")))?;
    match chosen.iter().find(|&&layer| surfaces[layer as usize].triangles.is_empty()) {
        Some(layer) => Err(Failure::of_arguments(format!(
            "--layers: nothing is left of layer {} of this part: choose another one",
            layer + 1
        ))),
        None => Ok(schedule),
    }
}

/// Fills the layers with beads.
fn filled(surfaces: &[LayerSurface], bead_mm: f64, bars: &Bars) -> Result<FilledLayers, Failure> {
    let options = PathOptions { bead: bead_mm, coverage: false, ..PathOptions::default() };
    fill_layers(surfaces, &options, &|p| bars.show(p.stage, p.done, p.total)).map_err(|error| match error {
        FillLayersError::NothingFits { bead, widest_mm, fits_mm } => Failure::of_arguments(format!(
            "a bead of {bead:.3} mm fits nowhere: layers are {widest_mm:.3} mm wide at most; take a --bead of {fits_mm:.3} mm or less"
        )),
        error => error.into(),
    })
}

/// The layers on which tapes are laid.
struct Bed<'a> {
    surfaces: &'a [LayerSurface<'a>],
    schedule: &'a [SandwichLayer],
    height_mm: f64,
    /// Beads of all layers, if there are any.
    print: Option<&'a PrintPlan>,
}

impl Bed<'_> {
    /// Plans tapes on each layer that carries them, where beads bear them.
    fn taped(&self, args: &Args, part: &Part, stress: &PartStress, bars: &Bars) -> Result<Vec<TapedLayer>, Failure> {
        let carrying = |(number, _): &(usize, &LayerSurface)| self.schedule[*number].carries_tape;
        let mut taped = Vec::new();
        for (number, surface) in self.surfaces.iter().enumerate().filter(carrying) {
            let top = surface.top();
            let (vertices, triangles) = match self.print {
                Some(print) => {
                    bedded_surface(&top, surface.triangles, number as u32, &print.resolved.paths, self.height_mm)
                }
                None => (top.clone(), surface.triangles.to_vec()),
            };
            if triangles.is_empty() {
                continue;
            }
            let share = area(&vertices, &triangles) / area(&top, surface.triangles);
            let name = format!("layer {} of {} of {}", number + 1, self.surfaces.len(), part.name);
            let mesh =
                SurfaceMesh::new(vertices, triangles).map_err(|error| Failure::new(format!("{name}: {error}")))?;
            let loaded = stress.follow(args, mesh, name, bars)?;
            taped.push(TapedLayer { number: number as u32, loaded, bedded_share: share });
        }
        Ok(taped)
    }

    /// Tapes and wires as the head lays them, without empty lists.
    fn lists(&self, taped: &[TapedLayer], wires: &[Vec<Tape>]) -> Vec<LayerTapes> {
        let of_layer = |(layer, wires): (&TapedLayer, &Vec<Tape>)| {
            let lift = self.schedule[layer.number as usize].raised;
            let list = |tool, tapes| LayerTapes { layer: layer.number, tool, lift, tapes };
            [list(Tool::Roller, layer.loaded.plan.tapes.clone()), list(Tool::Conductor, wires.clone())]
        };
        taped.iter().zip(wires).flat_map(of_layer).filter(|list| !list.tapes.is_empty()).collect()
    }
}

/// Plans everything.
pub fn plan(args: &Args, part: &Part, given: &Given, bars: &Bars) -> Result<PartRun, Failure> {
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let layers = PartLayers::new(args, part, bars)?;
    let surfaces = layers.surfaces();
    let schedule = schedule(args, &surfaces)?;
    let stress = layers.stress(args, part, given.stress.as_deref(), bars)?;
    let height_mm = layers.layered.surfaces.height_mm;
    let bead_mm = args.bead_mm.unwrap_or(BEAD_BY_HEIGHT * height_mm);
    let nozzle = nozzle_of(given.cell.equipment())?;
    let has_beads = args.stage >= Stage::Paths;
    let filled = has_beads.then(|| filled(&surfaces, bead_mm, bars)).transpose()?;
    let options = PrintOptions::for_robot();
    let print = filled.as_ref().map(|filled| filled.plan(&surfaces, &nozzle, &options, &progress)).transpose()?;

    let begin = Instant::now();
    let bed = Bed { surfaces: &surfaces, schedule: &schedule, height_mm, print: print.as_ref() };
    let taped = bed.taped(args, part, &stress, bars)?;
    let plan_time = begin.elapsed();
    let wires = laid_wires(args, given, &layers, &taped)?;
    let tapes = bed.lists(&taped, &wires);
    let wires = wires.iter().flatten().fold((0, 0.0), |(count, mm), wire| (count + 1, mm + wire.length()));

    let print = print.map(|print| raise_plan(print, &schedule, &options)).transpose()?;
    let head = args.head();
    let moves = moves(print.as_ref(), &tapes, &head)?;
    let bedding = match &print {
        Some(print) => Some(bedding(print, &tapes, height_mm, given, &progress)?),
        None => None,
    };
    let (reinforced, followed) = of_load((args, part), &layers, &stress, &tapes, bars)?;
    let motion = match (&print, &filled) {
        (Some(print), Some(filled)) if args.stage >= Stage::Motion => {
            let (layers, surfaces, tapes, head, nozzle) = (&layers, &surfaces[..], &tapes[..], &head, &nozzle);
            let work = part_motion::Work { layers, surfaces, filled, print, tapes, head, nozzle, bead_mm, bars };
            Some(work.plan(&given.cell)?)
        }
        _ => None,
    };
    drop(surfaces);
    Ok(PartRun {
        name: part.name.clone(),
        layers,
        bead_mm,
        schedule,
        taped,
        tapes,
        wires,
        source: stress.source,
        solved: stress.solved,
        reinforced,
        followed,
        print,
        bedding,
        moves,
        motion,
        plan_time,
    })
}

/// The moves of the machine file: beads with the tapes on their layers, or the tapes alone where there are no beads.
fn moves(print: Option<&PrintPlan>, tapes: &[LayerTapes], head: &TapeHead) -> Result<Vec<Move>, Failure> {
    Ok(match print {
        Some(print) => with_tapes(marked_moves(&print.deposition.moves, &print.resolved.paths), tapes, head)?.collect(),
        None => tapes.iter().map(|list| head.moves(list)).collect::<Result<Vec<_>, _>>()?.concat(),
    })
}

/// What tapes lie on, under the roller of the workcell.
fn bedding(
    print: &PrintPlan,
    tapes: &[LayerTapes],
    height_mm: f64,
    given: &Given,
    progress: curvlay_toolpath::ProgressFn<'_>,
) -> Result<TapeBedding, Failure> {
    let roller = given.cell.equipment().model().roller.unwrap_or_default();
    let roller = Roller { diameter: roller.diameter_mm, width: roller.width_mm };
    Ok(tape_bedding(&print.resolved.paths, tapes, height_mm, &roller, &SupportOptions::default(), progress)?)
}

/// What tapes make of the part under its load, and layers that follow the load where the user asks for them.
fn of_load(
    (args, part): (&Args, &Part),
    layers: &PartLayers,
    stress: &PartStress,
    tapes: &[LayerTapes],
    bars: &Bars,
) -> Result<(Option<Reinforced>, Option<FollowedLoad>), Failure> {
    let reinforced = match stress.solved {
        Some(_) => Some(layers.reinforced((args, part), tapes, of_dissertation(args, bars)?, bars)?),
        None => None,
    };
    let followed = match stress.of_cells().filter(|_| args.follow_load) {
        Some(stresses) => Some(FollowedLoad::new(args, part, layers, &stresses, bars)?),
        None => None,
    };
    Ok((reinforced, followed))
}

/// The share of the fibre that bears, and what bonds bear in MPa: as the user says, or as the tests of the dissertation give it.
fn of_dissertation(args: &Args, bars: &Bars) -> Result<(f64, f64), Failure> {
    let [dumbbell, _, arc] = Specimen::all();
    let bearing = match args.bearing {
        Some(bearing) => bearing,
        None => predict::bearing(&dumbbell, &sandwich(dumbbell.layers, &SandwichOptions::default())?)?,
    };
    let bond = args.bond_mpa.map_or_else(|| arcs::bond_mpa(&arc, predict::MEASURED_N[0], bars), Ok)?;
    Ok((bearing, bond))
}

fn area(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let twice = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a)).norm()
    };
    triangles.iter().map(twice).sum::<f64>() / 2.0
}

/// The wires of the user on the layers with tapes: each on the one that its points are nearest to.
fn laid_wires(
    args: &Args,
    given: &Given,
    layers: &PartLayers,
    taped: &[TapedLayer],
) -> Result<Vec<Vec<curvlay_toolpath::fiber::tapes::Tape>>, Failure> {
    let mut of_layers = vec![Vec::new(); taped.len()];
    let Some(path) = &args.wires else { return Ok(of_layers) };
    let options = ConductorOptions { thickness: args.tape_thickness_mm, ..ConductorOptions::default() };
    for (number, wire) in given.wires.iter().enumerate() {
        let wire: Vec<Point3<f64>> = wire.iter().map(|point| point + layers.solid.shift).collect();
        let apart = |layer: &TapedLayer| -> f64 {
            let vertices = layer.loaded.surface.vertices();
            let nearest =
                |p: &Point3<f64>| vertices.iter().map(|v| (v - p).norm_squared()).fold(f64::INFINITY, f64::min);
            wire.iter().map(nearest).sum()
        };
        let nearest = (0..taped.len()).min_by(|&a, &b| apart(&taped[a]).total_cmp(&apart(&taped[b])));
        let Some(nearest) = nearest else {
            return Err(Failure::of_arguments("--wire: no layer of the part carries tapes: see --layers and --every"));
        };
        of_layers[nearest].push(wires::on_layer(path, number, &wire, &taped[nearest].loaded.surface, &options)?);
    }
    Ok(of_layers)
}
