//! From parts to layers, tool paths, joint motion and programs.

use super::decompose::Divided;
use super::{Args, PatternName, Stage};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::motion::{
    OnCell, PlacedPaths, PrintingCell, UR3_CELL, bounds_of, nozzle_of, programs, table_options, waypoints,
};
use curvlay_examples::nalgebra::{Isometry3, Unit, UnitVector3};
use curvlay_kinematics::program::{RapidOptions, write_rapid, write_urscript};
use curvlay_kinematics::workcell::{
    AnyWorkcell, GrowingOptions, GrowingScene, Held, PartCells, Workcell, WorkcellModel,
};
use curvlay_kinematics::{PlateOptions, ReachOptions, fullest_box, place_on_plate, reachable_points};
use curvlay_layers::planar::robofdm::Head;
use curvlay_layers::planar::{FlatLayers, Solid, cells_by_flat_layer, flat_layers};
use curvlay_toolpath::surface::{
    self, Contacts, FilledLayers, GougingOptions, LayerSurface, PathOptions, Pattern, PrintPlan, fill_layers,
};
use curvlay_trajectory::print::{self, Fault, FaultKind, PrintLimits, PrintOptions, plan_print};
use curvlay_voxel::{Resolution, VoxelOptions, voxelise};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::io::{self, Write};
use std::ops::Range;
use std::rc::Rc;
use std::sync::Mutex;

/// The least diameter of a plate that the workcell leaves open, and how much wider than the part it is, in millimetres.
const PLATE_MM: f64 = 60.0;
const RIM_MM: f64 = 10.0;

/// Cells of a grid whose edge is not given.
const CELLS: u64 = 20_000;

/// How far the nozzle may leave its path, as a share of layer height or bead: what gouging allows as well.
const TOLERANCE: f64 = 0.25;

/// How deep it may be in a layer on its way, as a share of its height.
const DEPTH: f64 = 0.25;

/// A box with a part's edge in which an arm's frames are counted lies above the floor and in front of the arm, in millimetres.
const FRONT_MM: f64 = 150.0;

/// Layers and tool paths, and the motion if it was asked for.
pub struct Printed {
    /// Of each part.
    pub layers: Vec<FlatLayers>,
    pub filled: FilledLayers,
    pub plan: PrintPlan,
    pub moved: Option<Moved>,
}

/// What the motion comes to.
#[derive(Default)]
pub struct Moved {
    pub cell: String,
    pub nozzle_mm: [f64; 3],
    pub runs: usize,
    /// Transfers between runs, those of them from part to part, and runs without a way to the next.
    pub transfers: usize,
    pub between_parts: usize,
    pub missing: usize,
    pub changes: usize,
    pub robot_s: f64,
    pub faults: Vec<Fault>,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl Moved {
    pub fn count(&self, kind: FaultKind) -> usize {
        self.faults.iter().filter(|fault| fault.kind == kind).count()
    }
}

impl Printed {
    /// The part of a layer.
    pub fn part_of(&self, layer: usize) -> usize {
        part_of(&self.layers, layer)
    }

    pub fn layer_count(&self) -> usize {
        self.layers.iter().map(|part| part.layers.len()).sum()
    }

    /// What is wrong.
    pub fn find(&self, findings: &mut Findings) {
        let left_out = &self.plan.resolved.left_out;
        if !left_out.is_empty() {
            let mm: f64 = left_out.iter().map(|piece| piece.arcs[1] - piece.arcs[0]).sum();
            let amount = format!("{} pieces, {mm:.1} mm of {:.0} mm", left_out.len(), self.path_mm());
            findings.add(Severity::Told, "the nozzle would be in what is built; left out", amount, "left_out.csv");
        }
        let blocked = self.plan.travels.blocked.len();
        if blocked > 0 {
            findings.add(Severity::Told, "travels are blocked", blocked.to_string(), "");
        }
        let Some(moved) = &self.moved else { return };
        let kinds = [FaultKind::Unreachable, FaultKind::Blocked, FaultKind::Break, FaultKind::Astray];
        for kind in kinds.into_iter().chain([FaultKind::NoTransfer]) {
            let count = moved.count(kind);
            if count > 0 {
                let what = format!("the robot does not print all: {}", kind.name());
                findings.add(Severity::Failed, what, count.to_string(), "faults.csv");
            }
        }
    }

    /// Length of all tool paths.
    pub fn path_mm(&self) -> f64 {
        let lengths = self.plan.resolved.paths.iter().filter_map(|path| path.waypoints.last());
        lengths.map(|last| last.arc).sum()
    }
}

fn part_of(parts: &[FlatLayers], layer: usize) -> usize {
    let mut first = 0;
    let within = |part: &FlatLayers| {
        first += part.layers.len();
        layer < first
    };
    parts.iter().position(within).unwrap_or(0)
}

/// Everything behind the parts.
pub fn print(args: &Args, divided: &Divided, bars: &Bars) -> Result<Printed, Failure> {
    let cell = cell(args, divided)?;
    let parts = divided.parts.parts.iter();
    let layers: Vec<FlatLayers> =
        parts.map(|part| flat_layers(&part.solid, &part.direction, args.layer_height)).collect::<Result<_, _>>()?;
    let all = || layers.iter().flat_map(|part| part.layers.iter().map(|layer| (layer, part.direction)));
    let surfaces: Vec<LayerSurface> =
        all().map(|(layer, _)| (&layer.vertices[..], &layer.triangles[..], &layer.thickness[..]).into()).collect();
    let directions: Vec<UnitVector3<f64>> = all().map(|(_, direction)| Unit::new_normalize(direction)).collect();
    let pattern = match args.pattern {
        PatternName::Spiral => Pattern::Spirals,
        PatternName::Contours => Pattern::Rings,
        PatternName::Zigzag => Pattern::Zigzag,
    };
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let options = PathOptions { bead: args.bead_mm(), pattern, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &progress)?;
    let stack = filled.stack(&surfaces)?;
    let nozzle = nozzle_of(cell.equipment())?;
    let plan = stack.plan_along(&directions, &nozzle, &surface::PrintOptions::for_robot(), &progress)?;
    let moved = if args.stage == Stage::Motion {
        let options = GougingOptions { allowed_depth: DEPTH, plate: false, ..GougingOptions::default() };
        let contacts = stack.contacts(&plan.resolved.paths, &nozzle, &options, &progress)?;
        let work = Work { args, divided, layers: &layers, plan: &plan, contacts: &contacts, bars };
        Some(match &cell {
            AnyWorkcell::Six(cell) => work.motion(cell, &PrintOptions::default())?,
            AnyWorkcell::Eight(cell) => work.motion(cell, &table_options())?,
        })
    } else {
        None
    };
    drop(stack);
    Ok(Printed { layers, filled, plan, moved })
}

/// Diameter of a plate for a part.
fn plate_mm(solid: &Solid) -> f64 {
    let [low, high] = solid.bounds();
    let edges = high - low;
    PLATE_MM.max(edges.x.hypot(edges.y) + RIM_MM)
}

/// The head of the workcell and its plate, as the search for parts takes them.
pub fn head(args: &Args, solid: &Solid) -> Result<Head, Failure> {
    let cell = AnyWorkcell::new(model(args)?)?;
    let nozzle = nozzle_of(cell.equipment())?;
    Ok(Head {
        tip_radius: nozzle.tip_radius(),
        cone_half_angle: cell.equipment().model().nozzle.cone_half_angle_deg.to_radians(),
        cone_height: nozzle.cone_height(),
        block_radius: nozzle.block_radius(),
        platform_radius: cell.equipment().plate_diameter_mm(plate_mm(solid)) / 2.0,
        layer: args.layer_height,
        ..Head::default()
    })
}

fn model(args: &Args) -> Result<WorkcellModel, Failure> {
    let text = match &args.workcell {
        Some(file) => fs::read_to_string(file).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?,
        None => UR3_CELL.to_owned(),
    };
    Ok(WorkcellModel::from_json(text.as_bytes())?)
}

/// The workcell; its nozzle where the arm reaches most, if that was asked for (section 2.3.1 of the dissertation).
fn cell(args: &Args, divided: &Divided) -> Result<AnyWorkcell, Failure> {
    let mut model = model(args)?;
    if args.place_nozzle {
        if model.held != Held::Part {
            return Err(Failure::of_arguments("--place-nozzle: the arm of the workcell does not hold the part"));
        }
        let known = AnyWorkcell::new(model.clone())?;
        let (_, part_frame) = known.equipment().part_frame();
        let keep = |_: &[f64; 6], frame: &Isometry3<f64>| {
            let at = frame.translation.vector;
            at.z >= 0.0 && at.x >= FRONT_MM
        };
        let points = reachable_points(known.equipment().arm(), &part_frame, &ReachOptions::default(), keep)?;
        let [low, high] = divided.solid.bounds();
        let edges = high - low;
        // The nozzle stands still, and the part passes it by its own size, whichever way it is turned.
        let best = fullest_box(&points, [edges.max(); 3], &|_| std::ops::ControlFlow::Continue(()))?;
        model.nozzle.tip_mm = best.centre.coords.into();
    }
    Ok(AnyWorkcell::new(model)?)
}

struct Work<'a> {
    args: &'a Args,
    divided: &'a Divided,
    layers: &'a [FlatLayers],
    plan: &'a PrintPlan,
    contacts: &'a Contacts<'a>,
    bars: &'a Bars,
}

impl Work<'_> {
    /// Plans the motion of the joints (Eq. 2.3), transfers between runs (RRT-Connect, section 2.5), and writes the programs.
    fn motion<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        cell: &W,
        options: &PrintOptions<N, F>,
    ) -> Result<Moved, Failure> {
        let Work { args, divided, plan, contacts, bars, .. } = *self;
        let takes_stream = programs::takes_stream(cell.equipment()).map_err(Failure::new)?;
        let plate_mm = plate_mm(&divided.solid);
        let place = PlateOptions {
            stop_margin: options.stop_margin,
            rim_mm: args.bead_mm(),
            ..PlateOptions::new(options.samples)
        };
        let all = plan.resolved.paths.iter().flat_map(waypoints);
        let all: Vec<_> = all.map(|at| curvlay_kinematics::Waypoint { position: at.position, axis: at.axis }).collect();
        let progress = |p: curvlay_kinematics::Progress| bars.show(p.stage, p.done, p.total);
        let frame_part = place_on_plate(cell, &all, plate_mm, &place, &progress)?;

        let resolution = args.cell_mm.map_or(Resolution::Count(CELLS), Resolution::Cell);
        let voxels = VoxelOptions { resolution, ..VoxelOptions::default() };
        let show = |p: curvlay_voxel::Progress| bars.show(p.stage, p.done, p.total);
        let solid = voxelise(&divided.mesh.vertices, &divided.mesh.triangles, &voxels, &show)?;
        let grid = &solid.grid;
        // Cells of the part as it stands, not as they are moved onto the plate of the grid.
        let origin = grid.origin() - solid.shift;
        let cells = cells_by_flat_layer(self.layers, grid.dims(), grid.rows(), grid.cell_mm(), &origin);
        let grown = PartCells {
            dims: grid.dims(),
            rows: grid.rows(),
            cell_mm: grid.cell_mm(),
            origin,
            frame_part,
            layers: &cells,
        };
        let scene = GrowingScene::new(cell, &grown, plate_mm, &GrowingOptions::default())?;
        let paths = PlacedPaths::new(&plan.resolved.paths, &plan.deposition, &frame_part);
        let filament_mm2 = PI * surface::DepositionOptions::default().filament_diameter.powi(2) / 4.0;
        let limits = PrintLimits {
            tolerance_mm: TOLERANCE * args.layer_height.min(args.bead_mm()),
            filament_mm2,
            ..PrintLimits::of(bounds_of(cell.limits()))
        };
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let robot = OnCell::new(cell.clone(), Vec::new());
        let motion =
            plan_print(&robot, PrintingCell::new(scene, contacts), &paths.paths(), &limits, options, &progress)?;
        self.moved(cell, motion, takes_stream)
    }

    fn moved<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        cell: &W,
        motion: print::PrintPlan<N, F>,
        takes_stream: bool,
    ) -> Result<Moved, Failure> {
        let part = |run: usize| part_of(self.layers, motion.runs[run].layer as usize);
        let filament = |run: usize| part(run) as u32 % self.args.filaments;
        let mut moved = Moved {
            cell: cell.equipment().name().to_owned(),
            nozzle_mm: cell.equipment().model().nozzle.tip_mm,
            runs: motion.runs.len(),
            robot_s: motion.robot_s(),
            faults: motion.faults.clone(),
            ..Moved::default()
        };
        // A program ends where no way leads on, and where the filament is changed.
        let mut pieces: Vec<Range<usize>> = Vec::new();
        for run in 0..motion.runs.len() {
            let joins = run > 0 && motion.travels[run - 1].is_some();
            if run > 0 {
                moved.transfers += usize::from(joins);
                moved.missing += usize::from(!joins);
                moved.between_parts += usize::from(joins && part(run) != part(run - 1));
                moved.changes += usize::from(filament(run) != filament(run - 1));
            }
            match pieces.last_mut() {
                Some(piece) if joins && filament(run) == filament(run - 1) => piece.end = run + 1,
                _ => pieces.push(run..run + 1),
            }
        }
        for (number, piece) in pieces.into_iter().enumerate() {
            let name = match self.args.filaments {
                1 => format!("print_{:03}", number + 1),
                _ => format!("print_{:03}_filament_{}", number + 1, filament(piece.start) + 1),
            };
            if takes_stream {
                let options = programs::urscript_options(cell, &motion, &name);
                let mut file = Vec::new();
                write_urscript(programs::stream(cell, &motion, piece), &options, &mut file)?;
                moved.files.insert(format!("{name}.script"), file);
            } else {
                let options = RapidOptions { name, ..RapidOptions::of_workcell(cell.equipment()) };
                let mut files: Vec<(String, Shared)> = Vec::new();
                write_rapid(programs::targets(cell, &motion, piece), &options, |name| {
                    let file = Shared::default();
                    files.push((name.to_owned(), file.clone()));
                    Ok(file)
                })?;
                moved.files.extend(files.into_iter().map(|(name, file)| (name, file.take())));
            }
        }
        Ok(moved)
    }
}

/// Bytes that a writer fills while it is elsewhere.
#[derive(Clone, Default)]
struct Shared(Rc<Mutex<Vec<u8>>>);

impl Shared {
    fn take(&self) -> Vec<u8> {
        self.0.lock().map(|mut bytes| std::mem::take(&mut *bytes)).unwrap_or_default()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().map_err(|_| io::Error::other("a writer panicked"))?.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
