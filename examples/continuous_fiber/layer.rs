//! A layer under load: stresses from a solver or a file, tapes along them.

use super::specimens::Specimen;
use super::{Args, Boxed, Pull, arcs, predict};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::input;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::waypoints::fault;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{Guides, LayerOptions, LayeredPart, Platform, Rules, Workpiece, layer_normal};
use curvlay_layers::elastic::{
    Bond, Elastic, ElasticOptions, ElasticPart, Load, Material, Ply, Region, Strip, Support, load_factor, plies,
    solve_composite, solve_elastic, stress_matrix,
};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::head::LayerTapes;
use curvlay_toolpath::fiber::measure::{PrincipalAngle, angle_to_principal};
use curvlay_toolpath::fiber::stress::{LayerStress, Principal, StressOptions, StressSample};
use curvlay_toolpath::fiber::stress_files::{read_stress_csv, read_stress_frd, read_stress_vtk};
use curvlay_toolpath::fiber::tapes::{TapeOptions, TapePlan, lay_tapes};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_voxel::inspect::inspect;
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use std::io::BufReader;
use std::path::Path;
use std::time::{Duration, Instant};

/// Share of the area that counts as worst-stressed.
pub const WORST: f64 = 0.1;
/// How far samples of the solver may be from the layer, in cells.
const REACH_CELLS: f64 = 3.0;
/// Cells of a part whose size is not given: enough for five through a wall of a hollow part of common size.
const CELLS: u64 = 60_000;
/// Load on the arc at its crown, in N, and how long it is along the arc, in mm.
const CROWN_N: f64 = 100.0;
const PRESSED_MM: f64 = 3.0;
/// Edge of the cells of the arc in millimetres: one a layer.
const ARC_CELL_MM: f64 = 0.6;
/// What loads a part without options: so many newtons along x, on so much of its height from the top.
const DEFAULT_N: f64 = 100.0;
const DEFAULT_TOP: f64 = 0.1;

/// A layer with tapes along its stresses.
pub struct LoadedLayer {
    /// What it is of.
    pub name: String,
    /// Where its stresses come from, in words.
    pub source: String,
    /// The layer.
    pub surface: SurfaceMesh,
    /// Stresses at its vertices.
    pub principal: Vec<Principal>,
    /// Triangles around which directions turn.
    pub singular_points: usize,
    /// The tapes.
    pub plan: TapePlan,
    /// How well they follow.
    pub angle: PrincipalAngle,
    /// The work of the solver; none with stresses of a file.
    pub solved: Option<Solved>,
    /// Time for directions and tapes.
    pub plan_time: Duration,
}

/// The work of the solver.
#[derive(Clone, Copy, Debug)]
pub struct Solved {
    /// Cells.
    pub cells: usize,
    /// Iterations.
    pub iterations: u32,
    /// On the clock.
    pub time: Duration,
}

/// A solid as cells, held and loaded.
struct Loaded<'a> {
    solid: &'a Voxelisation,
    /// From the frame of the boxes to that of the cells.
    shift: Vector3<f64>,
    supports: Vec<Support>,
    loads: Vec<Load>,
    /// Young's modulus in MPa; none for the solver's own.
    young_mpa: Option<f64>,
}

impl Loaded<'_> {
    fn material(&self) -> Material {
        Material { young_mpa: self.young_mpa.unwrap_or(Material::default().young_mpa), ..Material::default() }
    }

    /// The work of the loads in N mm: what they are times how far they go.
    fn work(&self, elastic: &Elastic) -> f64 {
        let grid = &self.solid.grid;
        let of = |load: &Load| match load {
            Load::Force { region, newtons } => {
                let moved = elastic.mean_displacement(grid.dims(), grid.cell_mm(), region).unwrap_or([0.0; 3]);
                (0..3).map(|k| newtons[k] * moved[k]).sum()
            }
            _ => 0.0,
        };
        self.loads.iter().map(of).sum()
    }

    /// Stresses at the centres of cells, by rising number, in the frame of the boxes.
    fn samples(&self, bars: &Bars) -> Result<(Vec<StressSample>, Solved), Failure> {
        let grid = &self.solid.grid;
        let cells = Cells::new(grid.dims(), grid.rows())?;
        let material = self.material();
        let cell_mm = grid.cell_mm();
        let part = ElasticPart { cells: &cells, cell_mm, material, supports: &self.supports, loads: &self.loads };
        let begin = Instant::now();
        let solved = solve_elastic(&part, &ElasticOptions::default(), &|p| bars.show(p.stage, p.done, p.total))?;
        let time = begin.elapsed();
        let [nx, ny, _] = grid.dims();
        let place = |cell: u32| {
            let at = [cell % nx, cell / nx % ny, cell / nx / ny].map(|k| (f64::from(k) + 0.5) * cell_mm);
            grid.origin() + Vector3::from(at) - self.shift
        };
        let sample =
            |(&cell, stress): (&u32, &[f64; 6])| StressSample { point: place(cell), stress: stress_matrix(stress) };
        let samples = solved.cells.iter().zip(&solved.stresses_mpa).map(sample).collect();
        Ok((samples, Solved { cells: solved.cells.len(), iterations: solved.iterations, time }))
    }

    /// A box of the user in the frame of the grid.
    fn region(&self, Boxed([low, high]): Boxed) -> Region {
        let origin = self.solid.grid.origin() - self.shift;
        let inside = |corner: [f64; 3]| [0, 1, 2].map(|k| corner[k] - origin[k]);
        Region { low_mm: inside(low), high_mm: inside(high) }
    }
}

/// Tapes along the stresses of a layer.
fn follow(
    surface: SurfaceMesh,
    samples: &[StressSample],
    reach: f64,
    options: &TapeOptions,
    smoothing: f64,
    bars: &Bars,
) -> Result<LoadedLayer, Failure> {
    let begin = Instant::now();
    let stress = LayerStress::new(&surface, samples, StressOptions { reach })?;
    let field = DirectionField::from_stress(&stress, smoothing)?;
    let plan = lay_tapes(&field, options, &|p| bars.show(p.stage, p.done, p.total))?;
    let plan_time = begin.elapsed();
    let angle = angle_to_principal(&stress, &plan.tapes, WORST);
    let (principal, singular_points) = (stress.principal().to_vec(), field.singularities().len());
    Ok(LoadedLayer {
        name: String::new(),
        source: String::new(),
        surface,
        principal,
        singular_points,
        plan,
        angle,
        solved: None,
        plan_time,
    })
}

/// The arc in the test of the dissertation: its ends on a table, its crown pressed down. The layer is the last that carries tape.
pub fn arc(specimen: &Specimen, options: &TapeOptions, smoothing: f64, bars: &Bars) -> Result<LoadedLayer, Failure> {
    let mesh = specimen.solid();
    let voxels = VoxelOptions { resolution: Resolution::Cell(ARC_CELL_MM), ..VoxelOptions::default() };
    let solid = voxelise(&mesh.vertices, &mesh.triangles, &voxels, &|p| bars.show(p.stage, p.done, p.total))?;
    let bounds = mesh.bounds().unwrap_or([Point3::origin(); 2]);
    let [low, high] = bounds;
    let mut loaded =
        Loaded { solid: &solid, shift: solid.shift, supports: Vec::new(), loads: Vec::new(), young_mpa: None };
    // The ends stand on their lowest edges; one of them slides.
    let edge = |x0: f64, x1: f64| {
        let (y, z) = (f64::INFINITY, low.z + 1.5 * ARC_CELL_MM);
        loaded.region(Boxed([[x0, -y, f64::NEG_INFINITY], [x1, y, z]]))
    };
    let (left, right) = (edge(f64::NEG_INFINITY, 0.0), edge(0.0, f64::INFINITY));
    let slides = Support { region: right, displacement_mm: [None, Some(0.0), Some(0.0)] };
    let half = PRESSED_MM / 2.0;
    let crown =
        loaded.region(Boxed([[-half, f64::NEG_INFINITY, high.z - ARC_CELL_MM], [half, f64::INFINITY, f64::INFINITY]]));
    loaded.supports = vec![Support::fixed(left), slides];
    loaded.loads = vec![Load::Force { region: crown, newtons: [0.0, 0.0, -CROWN_N] }];
    let (samples, solved) = loaded.samples(bars)?;
    let height = f64::from(specimen.layers - 1) * specimen.layer_mm;
    let surface = specimen.surface(height);
    let surface = SurfaceMesh::new(surface.vertices, surface.triangles)?;
    let layer = follow(surface, &samples, REACH_CELLS * ARC_CELL_MM, options, smoothing, bars)?;
    Ok(LoadedLayer {
        name: "the arc, its last layer with tape".to_owned(),
        source: format!("pressed down at its crown with {CROWN_N} N, its ends on a table"),
        solved: Some(solved),
        ..layer
    })
}

/// Does something with a part on the plate.
fn in_workpiece<T>(
    part: &Part,
    solid: &Voxelisation,
    volume_mm3: f64,
    work: impl FnOnce(&Workpiece) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let (mesh, grid) = (&part.mesh, &solid.grid);
    let vertices: Vec<_> = mesh.vertices.iter().map(|vertex| vertex + solid.shift).collect();
    let cells = Cells::new(grid.dims(), grid.rows())?;
    let [low, high] = mesh.bounds().unwrap_or([Point3::origin(); 2]);
    let radius = 0.5 * (high - low).xy().norm() / grid.cell_mm();
    work(&Workpiece {
        vertices: &vertices,
        triangles: &mesh.triangles,
        cells,
        cell_mm: grid.cell_mm(),
        origin: grid.origin(),
        platform: &Platform::under(&cells, radius)?,
        rules: Rules::default(),
        volume_mm3,
        guides: Guides::default(),
    })
}

/// The layers of the user's part, in the frame of the plate.
pub struct PartLayers {
    /// Its cells.
    pub solid: Voxelisation,
    /// Their order, and the surfaces.
    pub layered: LayeredPart,
    /// Volume of the part in cubic millimetres.
    pub volume_mm3: f64,
}

impl PartLayers {
    /// Grows the layers of a part, each as high as `--layer-height` says, or as a cell.
    pub fn new(args: &Args, part: &Part, bars: &Bars) -> Result<Self, Failure> {
        let progress = |p: curvlay_voxel::Progress| bars.show(p.stage, p.done, p.total);
        let resolution = args.cell_mm.map_or(Resolution::Count(CELLS), Resolution::Cell);
        let voxels = VoxelOptions { resolution, ..VoxelOptions::default() };
        let mesh = &part.mesh;
        let solid = voxelise(&mesh.vertices, &mesh.triangles, &voxels, &progress)?;
        let volume_mm3 = inspect(&mesh.vertices, &mesh.triangles)?.volume_mm3();
        let options = LayerOptions { height_mm: args.layer_height_mm, ..LayerOptions::hull_rule() };
        let layered = in_workpiece(part, &solid, volume_mm3, |workpiece| {
            Ok(workpiece.layers(&options, &|p| bars.show(p.stage, p.done, p.total))?)
        })?;
        Ok(PartLayers { solid, layered, volume_mm3 })
    }

    /// Does something with the part as it is layered.
    pub fn in_workpiece<T>(
        &self,
        part: &Part,
        work: impl FnOnce(&Workpiece) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        in_workpiece(part, &self.solid, self.volume_mm3, work)
    }

    /// As the planner of tool paths takes them.
    pub fn surfaces(&self) -> Vec<LayerSurface<'_>> {
        self.layered.surfaces.iter().map(LayerSurface::from).collect()
    }

    /// Stresses in the part, in the frame of the plate.
    pub fn stress(
        &self,
        args: &Args,
        part: &Part,
        given: Option<&[StressSample]>,
        bars: &Bars,
    ) -> Result<PartStress, Failure> {
        let shift = self.solid.shift;
        let moved = |sample: &StressSample| StressSample { point: sample.point + shift, ..*sample };
        if let (Some(path), Some(samples)) = (&args.stress, given) {
            let samples = samples.iter().map(moved).collect();
            let source = format!("stresses of {}", path.display());
            return Ok(PartStress { samples, reach_mm: args.reach_mm, source, solved: None });
        }
        let (loaded, source) = user_load(args, part, &self.solid);
        let (samples, solved) = loaded.samples(bars)?;
        let samples = samples.iter().map(moved).collect();
        Ok(PartStress { samples, reach_mm: REACH_CELLS * self.solid.grid.cell_mm(), source, solved: Some(solved) })
    }
}

/// What tapes do to the part under its load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reinforced {
    /// How much stiffer it is: the work of the loads without tapes over that with them, less 1.
    pub gain: f64,
    /// What bonds bear in MPa.
    pub bond_mpa: f64,
    /// Share of the fibre that bears.
    pub bearing: f64,
    /// The multiple of the load at which bonds come apart, without and with tapes.
    pub apart: [f64; 2],
    /// Share of the tapes' volume that lies in no cell.
    pub lost_share: f64,
}

impl PartLayers {
    /// Solves the part with its tapes and without.
    ///
    /// # Arguments
    /// * `tapes`: in the frame of the plate; `bearing`: share of their fibre that bears; `bond_mpa`: what bonds bear in peel and in shear.
    pub fn reinforced(
        &self,
        (args, part): (&Args, &Part),
        tapes: &[LayerTapes],
        (bearing, bond_mpa): (f64, f64),
        bars: &Bars,
    ) -> Result<Reinforced, Failure> {
        let (loaded, _) = user_load(args, part, &self.solid);
        let grid = &self.solid.grid;
        let cells = Cells::new(grid.dims(), grid.rows())?;
        let strips: Vec<Strip> = tapes.iter().flat_map(|list| &list.tapes).map(arcs::strip).collect();
        let found = plies(&cells, grid.cell_mm(), &grid.origin(), &strips)?;
        let (material, cell_mm) = (loaded.material(), grid.cell_mm());
        let tape = predict::tape_law(&material, args.tape_thickness_mm, bearing);
        let model = ElasticPart { cells: &cells, cell_mm, material, supports: &loaded.supports, loads: &loaded.loads };
        let bond = Bond { peel_mpa: bond_mpa, shear_mpa: bond_mpa };
        let field = &self.layered.uniform.field;
        let solve = |list: &[Ply]| -> Result<(f64, f64), Failure> {
            let progress = |p: curvlay_layers::Progress| bars.show(p.stage, p.done, p.total);
            let elastic = solve_composite(&model, &tape, list, &ElasticOptions::default(), &progress)?;
            let bonds = elastic.cells.iter().zip(&elastic.stresses_mpa).filter_map(|(&cell, stress)| {
                let ply = list.binary_search_by_key(&cell, |ply| ply.cell).ok().map(|k| list[k].normal);
                Some((bond.index(stress, &ply.or_else(|| layer_normal(&cells, field, cell))?), cell_mm * cell_mm))
            });
            Ok((loaded.work(&elastic), load_factor(&bonds.collect::<Vec<_>>(), arcs::APART)))
        };
        let ((plain, apart), (taped, with_tapes)) = (solve(&[])?, solve(&found.list)?);
        let lost_share = if found.tape_mm3 > 0.0 { found.lost_mm3 / found.tape_mm3 } else { 0.0 };
        Ok(Reinforced { gain: plain / taped - 1.0, bond_mpa, bearing, apart: [apart, with_tapes], lost_share })
    }
}

/// Stresses in the user's part.
pub struct PartStress {
    samples: Vec<StressSample>,
    reach_mm: f64,
    /// Where they come from, in words.
    pub source: String,
    /// The work of the solver; none with stresses of a file.
    pub solved: Option<Solved>,
}

impl PartStress {
    /// The stresses of the cells by rising number, xx, yy, zz, xy, yz, zx, where they are of the solver.
    pub fn of_cells(&self) -> Option<Vec<[f64; 6]>> {
        let components = |StressSample { stress: s, .. }: &StressSample| {
            [s[(0, 0)], s[(1, 1)], s[(2, 2)], s[(0, 1)], s[(1, 2)], s[(2, 0)]]
        };
        self.solved.map(|_| self.samples.iter().map(components).collect())
    }

    /// Tapes along these stresses on a surface.
    pub fn follow(&self, args: &Args, surface: SurfaceMesh, name: String, bars: &Bars) -> Result<LoadedLayer, Failure> {
        let named = |failure: Failure| match &args.stress {
            Some(path) => fault(path, &format!("{name}: {}", failure.message())),
            None => Failure::new(format!("{name}: {}", failure.message())),
        };
        let layer = follow(surface, &self.samples, self.reach_mm, &args.tape_options(), args.smoothing_mm(), bars);
        let layer = layer.map_err(named)?;
        Ok(LoadedLayer { name, source: self.source.clone(), ..layer })
    }
}

/// What holds and loads the user's part: what was asked for, or its base held and its top pushed.
fn user_load<'a>(args: &Args, part: &Part, solid: &'a Voxelisation) -> (Loaded<'a>, String) {
    let (supports, loads) = (Vec::new(), Vec::new());
    let mut loaded =
        Loaded { solid, shift: solid.shift, supports, loads, young_mpa: args.young_gpa.map(|gpa| gpa * 1e3) };
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let slab = |low: f64, high: f64| Boxed([[everywhere[0], everywhere[0], low], [everywhere[1], everywhere[1], high]]);
    let (supports, loads, source) = if args.supports.is_empty() && args.loads.is_empty() {
        let [low, high] = part.mesh.bounds().unwrap_or([Point3::origin(); 2]);
        let top = high.z - DEFAULT_TOP * (high.z - low.z);
        let base = slab(f64::NEG_INFINITY, low.z + solid.grid.cell_mm() / 2.0);
        let push = Pull { region: slab(top, f64::INFINITY), newtons: [DEFAULT_N, 0.0, 0.0] };
        (vec![base], vec![push], format!("base held, {DEFAULT_N} N along x on the top tenth of its height"))
    } else {
        let source = format!(
            "{} and {} as asked for",
            counted(args.supports.len(), "support"),
            counted(args.loads.len(), "load")
        );
        (args.supports.clone(), args.loads.clone(), source)
    };
    loaded.supports = supports.into_iter().map(|region| Support::fixed(loaded.region(region))).collect();
    let load = |pull: Pull| Load::Force { region: loaded.region(pull.region), newtons: pull.newtons };
    let loads: Vec<Load> = loads.into_iter().map(load).collect();
    loaded.loads = loads;
    (loaded, source)
}

/// Stresses of a file, by its ending: CSV, VTK, or results of CalculiX.
pub fn read_stress(path: &Path) -> Result<Vec<StressSample>, Failure> {
    let file = BufReader::new(input::open(path, input::MAX_DATA_BYTES)?);
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let samples = match ending.as_deref() {
        Some("vtk") => read_stress_vtk(file, None),
        Some("frd") => read_stress_frd(file),
        _ => read_stress_csv(file),
    };
    samples.map_err(|error| fault(path, &error))
}
