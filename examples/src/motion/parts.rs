//! Parts with directions of their own, printed one after another in flat layers: layers, tool paths, joint motion, programs.

use super::target_programs::{TargetFormat, TargetLanguage, target_files};
use super::{
    OnCell, PlacedPaths, PrintingCell, bounds_of, from_home, nozzle_of, programs, shown, table_options, track_options,
    waypoints,
};
use crate::bars::Bars;
use crate::count::counted;
use crate::findings::{Findings, Severity};
use crate::mesh::Mesh;
use crate::outcome::Failure;
use crate::output::is_numbered;
use crate::viewer::{self, Robot, Step};
use curvlay_kinematics::program::write_urscript;
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, Workcell};
use curvlay_kinematics::{PlateOptions, place_on_plate};
use curvlay_layers::planar::{FlatLayers, cells_by_flat_layer};
use curvlay_toolpath::fill::{FilledLayers, fill_layers};
use curvlay_toolpath::gouging::{Contacts, GougingOptions};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::path::{PathOptions, Pattern};
use curvlay_toolpath::plan::{self, PrintPlan};
use curvlay_trajectory::print::{self, Fault, FaultKind, PrintLimits, PrintOptions, plan_print};
use curvlay_voxel::{Resolution, VoxelOptions, voxelise};
use nalgebra::{Unit, UnitVector3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The least diameter of a plate that the workcell leaves open, and how much wider than the part it is, in millimetres.
const PLATE_MM: f64 = 60.0;
const RIM_MM: f64 = 10.0;

/// Cells of a grid whose edge is not given.
const CELLS: u64 = 20_000;

/// How far the nozzle may leave its path, as a share of layer height or bead: what gouging allows as well.
const TOLERANCE: f64 = 0.25;

/// How deep it may be in a layer on its way, as a share of its height.
const DEPTH: f64 = 0.25;

/// Whether a file of this name is a program as [`print_parts`] makes them: `print_001`, with `_filament_1` where filaments are changed and
/// the number of a module behind it.
/// ```
/// use curvlay_examples::motion::is_program;
/// let ours = ["print_001.script", "print_012_filament_2.script", "print_001.mod", "print_001_002.mod", "print_001_filament_1_003.mod", "print_001.src", "print_001.dat", "print_001_002.ls"];
/// assert!(ours.into_iter().all(is_program));
/// let others = ["print_my_life.script", "print_cell_setup.mod", "print_1.mod", "print_001_filament_.mod", "print_001_2.mod", "print_001_002.script"];
/// assert!(!others.into_iter().any(is_program));
/// ```
pub fn is_program(name: &str) -> bool {
    let Some((stem, ending)) =
        name.rsplit_once('.').filter(|(_, ending)| matches!(*ending, "script" | "mod" | "src" | "dat" | "ls"))
    else {
        return false;
    };
    let is_piece = |stem: &str| {
        let (run, filament) = stem.split_once("_filament").unwrap_or((stem, "_1"));
        is_numbered(run, "print_", 3, "") && is_numbered(filament, "_", 1, "")
    };
    let is_module =
        || stem.rsplit_once('_').is_some_and(|(piece, part)| is_piece(piece) && is_numbered(part, "", 3, ""));
    is_piece(stem) || (ending != "script" && is_module())
}

/// What is printed, and how.
#[derive(Clone, Copy, Debug)]
pub struct FlatPrint<'a> {
    /// All parts in one, standing on the plane z = 0.
    pub mesh: &'a Mesh,
    /// The layers of the parts, in their order.
    pub layers: &'a [FlatLayers],
    /// Width of a bead, in mm.
    pub bead_mm: f64,
    /// How layers are filled.
    pub pattern: Pattern,
    /// Edge of the cells by which the robot sees the part, in mm; none: some 20,000 cells.
    pub cell_mm: Option<f64>,
    /// Diameter of the filament or wire, in mm.
    pub filament_mm: f64,
    /// Filaments that the parts take in turn; each change begins a program.
    pub filaments: u32,
    /// Whether the motion is planned, and programs written.
    pub moves: bool,
}

/// Layers and tool paths, and the motion if it was asked for.
pub struct Printed {
    /// The layers of each part.
    pub layers: Vec<FlatLayers>,
    /// The beads.
    pub filled: FilledLayers,
    /// The tool paths.
    pub plan: PrintPlan,
    /// The motion.
    pub moved: Option<Moved>,
}

/// What the motion comes to.
#[derive(Default)]
pub struct Moved {
    /// Name of the workcell.
    pub cell: String,
    /// Tip of its nozzle.
    pub nozzle_mm: [f64; 3],
    /// Motions along paths.
    pub runs: usize,
    /// Transfers between runs.
    pub transfers: usize,
    /// Ways from part to part, by a transfer or by home.
    pub between_parts: usize,
    /// Ways that were not found, from run to run or home.
    pub missing: usize,
    /// Changes of the filament.
    pub changes: usize,
    /// Seconds that the robot moves.
    pub robot_s: f64,
    /// What it does not print as planned.
    pub faults: Vec<Fault>,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What the robot does, and how it stands, for the viewer.
    pub steps: Vec<Step>,
    /// See [`steps`](Moved::steps).
    pub robot: Option<Robot>,
    /// The nozzle of the workcell, for the viewer.
    pub nozzle: Option<viewer::Nozzle>,
}

impl Moved {
    /// How many faults there are of a kind.
    pub fn count(&self, kind: FaultKind) -> usize {
        self.faults.iter().filter(|fault| fault.kind == kind).count()
    }
}

impl Printed {
    /// The part of a layer.
    pub fn part_of(&self, layer: usize) -> usize {
        part_of(&self.layers, layer)
    }

    /// Layers of all parts.
    pub fn layer_count(&self) -> usize {
        self.layers.iter().map(|part| part.layers.len()).sum()
    }

    /// What is wrong.
    pub fn find(&self, findings: &mut Findings) {
        let left_out = &self.plan.resolved.left_out;
        if !left_out.is_empty() {
            let mm = self.left_out_mm();
            let amount = format!("{}, {mm:.1} mm of {:.0} mm", counted(left_out.len(), "piece"), self.path_mm() + mm);
            findings.add(Severity::Warning, "left out: the nozzle would collide with printed material", amount, "");
        }
        let blocked = self.plan.travels.blocked.len();
        if blocked > 0 {
            findings.add(Severity::Warning, "travels are blocked", blocked.to_string(), "");
        }
        let Some(moved) = &self.moved else { return };
        let kinds = [FaultKind::Unreachable, FaultKind::Blocked, FaultKind::Break, FaultKind::PathDeviation];
        for kind in kinds.into_iter().chain([FaultKind::NoTransfer]) {
            let count = moved.count(kind);
            if count > 0 {
                let what = format!("the robot does not print all: {}", kind.name());
                findings.add(Severity::Failed, what, count.to_string(), "");
            }
        }
    }

    /// Length that is left out, since the nozzle would collide with printed material.
    pub fn left_out_mm(&self) -> f64 {
        self.plan.resolved.left_out.iter().map(|piece| piece.arcs[1] - piece.arcs[0]).fold(0.0, |sum, mm| sum + mm)
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

/// Height of the lowest layer of all parts, in mm.
fn least_height_mm(parts: &[FlatLayers]) -> f64 {
    let layers = parts.iter().flat_map(|part| &part.layers);
    layers.map(|layer| layer.high_mm - layer.low_mm).fold(f64::INFINITY, f64::min)
}

/// Everything behind the layers of the parts.
///
/// # Errors
/// Of the first step that fails; what cannot be printed or reached is no error, but listed.
pub fn print_parts(print: &FlatPrint, cell: &AnyWorkcell, bars: &Bars) -> Result<Printed, Failure> {
    let layers = print.layers;
    // A controller whose language is not written is refused before anything is planned.
    let language = if print.moves { TargetLanguage::of(cell.equipment())? } else { None };
    let all = || layers.iter().flat_map(|part| part.layers.iter().map(|layer| (layer, part.direction)));
    let surfaces: Vec<LayerSurface> =
        all().map(|(layer, _)| (&layer.vertices[..], &layer.triangles[..], &layer.thickness[..]).into()).collect();
    let directions: Vec<UnitVector3<f64>> = all().map(|(_, direction)| Unit::new_normalize(direction)).collect();
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let options = PathOptions { bead: print.bead_mm, pattern: print.pattern, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &progress)?;
    let stack = filled.stack(&surfaces)?;
    let nozzle = nozzle_of(cell.equipment())?;
    let mut options = plan::PrintOptions::for_robot();
    options.deposition.filament_diameter = print.filament_mm;
    let plan = stack.plan_along(&directions, &nozzle, &options, &progress)?;
    let moved = if print.moves {
        let options = GougingOptions { allowed_depth: DEPTH, ..GougingOptions::in_workcell() };
        let contacts = stack.contacts(&plan.resolved.paths, &nozzle, &options, &progress)?;
        let work = Work { print, layers, plan: &plan, contacts: &contacts, bars };
        Some(match cell {
            AnyWorkcell::Six(cell) => work.motion(cell, &PrintOptions::default(), language)?,
            AnyWorkcell::Seven(cell) => work.motion(cell, &track_options(), language)?,
            AnyWorkcell::Eight(cell) => work.motion(cell, &table_options(), language)?,
        })
    } else {
        None
    };
    drop(stack);
    Ok(Printed { layers: layers.to_vec(), filled, plan, moved })
}

/// Diameter of a plate for a part, where the workcell leaves it open, in mm.
pub fn plate_mm(mesh: &Mesh) -> f64 {
    let edges = mesh.bounds().map_or(Vector3::zeros(), |[low, high]| high - low);
    PLATE_MM.max(edges.x.hypot(edges.y) + RIM_MM)
}

struct Work<'a> {
    print: &'a FlatPrint<'a>,
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
        language: Option<TargetLanguage>,
    ) -> Result<Moved, Failure> {
        let Work { print, plan, contacts, bars, .. } = *self;
        let plate_mm = plate_mm(print.mesh);
        let place = PlateOptions {
            stop_margin: options.stop_margin,
            rim_mm: print.bead_mm,
            ..PlateOptions::new(options.samples)
        };
        let all = plan.resolved.paths.iter().flat_map(waypoints);
        let all: Vec<_> = all.map(|at| curvlay_kinematics::Waypoint { position: at.position, axis: at.axis }).collect();
        let progress = |p: curvlay_kinematics::Progress| bars.show(p.stage, p.done, p.total);
        let frame_part = place_on_plate(cell, &all, plate_mm, &place, &progress)?;

        let resolution = print.cell_mm.map_or(Resolution::Count(CELLS), Resolution::Cell);
        let voxels = VoxelOptions { resolution, ..VoxelOptions::default() };
        let show = |p: curvlay_voxel::Progress| bars.show(p.stage, p.done, p.total);
        let solid = voxelise(&print.mesh.vertices, &print.mesh.triangles, &voxels, &show)?;
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
        let filament_mm2 = PI * print.filament_mm.powi(2) / 4.0;
        let limits = PrintLimits {
            tolerance_mm: TOLERANCE * least_height_mm(self.layers).min(print.bead_mm),
            filament_mm2,
            ..PrintLimits::of(bounds_of(cell.limits()))
        };
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let robot = OnCell::new(cell.clone(), Vec::new());
        let scene = PrintingCell::new(scene, contacts);
        let motion = plan_print(&robot, scene.clone(), &paths.paths(), &limits, options, &progress)?;
        // A program ends where no way leads on, and where the filament is changed.
        let filament = |run: usize| self.filament(part_of(self.layers, motion.runs[run].layer as usize));
        let cuts = (1..motion.runs.len()).filter(|&run| filament(run) != filament(run - 1)).collect();
        let motion = from_home(&motion, &cuts, &robot, scene, (&limits, options), &progress)?;
        let mut moved = self.moved(cell, &motion, language)?;
        let (steps, robot) = shown::played(cell, &frame_part, &motion, &plan.resolved.paths);
        (moved.steps, moved.robot) = (steps, Some(robot));
        moved.nozzle = Some(shown::nozzle(&cell.equipment().model().nozzle));
        Ok(moved)
    }

    /// The filament of a part, from 0.
    fn filament(&self, part: usize) -> u32 {
        part as u32 % self.print.filaments
    }

    fn moved<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        cell: &W,
        motion: &print::PrintPlan<N, F>,
        language: Option<TargetLanguage>,
    ) -> Result<Moved, Failure> {
        let part = |run: usize| part_of(self.layers, motion.runs[run].layer as usize);
        let filament = |run: usize| self.filament(part(run));
        let count = |differ: &dyn Fn(usize) -> bool| (1..motion.runs.len()).filter(|&run| differ(run)).count();
        let mut moved = Moved {
            cell: cell.equipment().name().to_owned(),
            nozzle_mm: cell.equipment().model().nozzle.tip_mm,
            runs: motion.runs.len(),
            transfers: motion.travels.iter().flatten().count(),
            between_parts: count(&|run| part(run) != part(run - 1)),
            missing: motion.count(FaultKind::NoTransfer),
            changes: count(&|run| filament(run) != filament(run - 1)),
            robot_s: motion.robot_s(),
            faults: motion.faults.clone(),
            files: BTreeMap::new(),
            ..Moved::default()
        };
        for (number, piece) in programs::pieces(motion).into_iter().enumerate() {
            let name = match self.print.filaments {
                1 => format!("print_{:03}", number + 1),
                _ => format!("print_{:03}_filament_{}", number + 1, filament(piece.start) + 1),
            };
            let Some(language) = language else {
                let options = programs::urscript_options(cell, motion, &name);
                let mut file = Vec::new();
                write_urscript(programs::stream(cell, motion, piece), &options, &mut file)?;
                moved.files.insert(format!("{name}.script"), file);
                continue;
            };
            let format = TargetFormat::new(name, language, motion.max_filament_mm_s());
            let mut steps = programs::targets(cell, motion, piece);
            moved.files.extend(target_files(&mut steps, cell.equipment(), &format)?);
            if steps.dropped() > 0 {
                let moves = counted(steps.dropped() as usize, "move");
                return Err(Failure::new(format!("{moves} have no pose: the table is beyond its limits")));
            }
        }
        Ok(moved)
    }
}
