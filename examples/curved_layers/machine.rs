//! Stage `gcode`: waypoints along the paths, a nozzle that gouges nothing, and what it lays down how fast.

use crate::paths::{Layer, PathsRun};
use crate::surfaces::SurfacesRun;
use crate::{Args, Stage, failure};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_kinematics::workcell::NozzleModel;
use curvlay_layers::curved::trim::TrimmedSheet;
use curvlay_toolpath::gcode;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::surface::{
    BuiltLayer, Deposition, DepositionOptions, Freed, GougingOptions, LayerCurve, LayerStack, MoveKind, Nozzle,
    OrientOptions, ToolPath, TravelOptions, Travels, Turns, deposit_along,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Layers thinner than this share of their height are taken for as thick: beads of no height are none.
const LEAST_HEIGHT: f64 = 0.02;

/// How deep the nozzle may be in a layer at waypoints, as a share of its height: a little less than the quarter that it may
/// be anywhere, since a machine leaves the straight way between two waypoints.
const PLANNED_DEPTH: f64 = 0.2;

/// How far it keeps over the plate there, in millimetres, for the same reason.
const PLANNED_CLEARANCE_MM: f64 = 0.1;

/// Share of the waypoints that may gouge, listed, before a run counts as failed; and of the paths that may be left out.
pub const GOUGING_SHARE: f64 = 1e-3;

/// How far the volume of the beads may be off that of what they cover.
pub const VOLUME_SHARE: f64 = 0.02;

/// The shape of a nozzle, and how it was given.
#[derive(Clone, Debug)]
pub struct Shape {
    pub nozzle: Nozzle,
    /// Tip flat, half angle in degrees, height of the cone, block.
    pub numbers: [f64; 4],
    pub text: String,
}

impl Shape {
    /// That of a workcell.
    pub fn of(model: &NozzleModel) -> Result<Self, Failure> {
        let NozzleModel { tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm, .. } = *model;
        let numbers = [tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm];
        shape(&numbers.map(|number| number.to_string()).join(",")).map_err(|why| failure(format!("nozzle: {why}")))
    }
}

/// A nozzle as four numbers, for clap.
pub fn shape(text: &str) -> Result<Shape, String> {
    let numbers: Result<Vec<f64>, std::num::ParseFloatError> =
        text.split(',').map(|number| number.trim().parse()).collect();
    let Ok(Ok(numbers)) = numbers.map(<[f64; 4]>::try_from) else {
        return Err(
            "must be four numbers: tip flat (mm), half angle (degrees), height of the cone, block (mm)".to_owned()
        );
    };
    let [tip, angle, height, block] = numbers;
    let nozzle = Nozzle::new(tip, angle.to_radians(), height, block).map_err(|error| error.to_string())?;
    Ok(Shape { nozzle, numbers, text: text.to_owned() })
}

/// What came of the stage.
pub struct MachineRun {
    /// Turns between neighbours when every nozzle points away from the closest point below.
    pub raw: Turns,
    /// The paths with the directions that they are printed with.
    pub freed: Freed,
    /// How the nozzle gets from path to path.
    pub travels: Travels,
    pub deposition: Deposition,
    /// Area that beads cover by the thickness of the layer there.
    pub covered_mm3: f64,
    /// The longest path, with the directions before and after.
    pub example: Option<[ToolPath; 2]>,
    pub times: Times,
}

/// How long the steps took, on the clock.
#[derive(Clone, Copy, Default)]
pub struct Times {
    /// Waypoints and their directions, gouging included.
    pub orientation: Duration,
    pub gouging: Duration,
    pub travels: Duration,
    pub deposition: Duration,
}

impl MachineRun {
    pub fn waypoints(&self) -> usize {
        self.freed.paths.iter().map(|path| path.waypoints.len()).sum()
    }

    /// Length of the paths, and of the pieces that are left out because the nozzle would run into what is built.
    pub fn lengths_mm(&self) -> [f64; 2] {
        let left_out = self.freed.left_out.iter().map(|piece| piece.arcs[1] - piece.arcs[0]);
        [self.deposition.bead_mm, left_out.fold(0.0, |sum, length| sum + length)] // a sum of nothing is -0.0
    }

    /// Whether what is left of gouging, travels and the volume are within bounds.
    pub fn failed_checks(&self) -> Vec<String> {
        let mut failed = Vec::new();
        let (left, waypoints) = (self.freed.left.len(), self.waypoints());
        if left as f64 > GOUGING_SHARE * waypoints as f64 {
            failed.push(format!("{left} of {waypoints} waypoints gouge"));
        }
        let [laid, left_out] = self.lengths_mm();
        if left_out > GOUGING_SHARE * (laid + left_out) {
            failed.push(format!("{left_out:.1} mm of {:.1} mm of paths are left out", laid + left_out));
        }
        if !self.travels.blocked.is_empty() {
            failed.push(format!("{} travels are blocked", self.travels.blocked.len()));
        }
        let (laid, covered) = (self.deposition.extruded_mm3, self.covered_mm3);
        if (laid - covered).abs() > VOLUME_SHARE * covered {
            failed.push(format!("{laid:.1} mm3 are laid on {covered:.1} mm3"));
        }
        failed
    }

    /// Takes over how long a robot takes: for a path, to a waypoint from the one before, so many seconds.
    pub fn retime(&mut self, steps: impl IntoIterator<Item = (usize, usize, f64)>) {
        let mut seconds: Vec<Vec<Option<f64>>> =
            self.freed.paths.iter().map(|path| vec![None; path.waypoints.len()]).collect();
        for (path, waypoint, step) in steps {
            seconds[path][waypoint] = Some(step);
        }
        let Deposition { moves, print_s, total_s, .. } = &mut self.deposition;
        for step in moves.iter_mut().filter(|step| step.kind == MoveKind::Print) {
            let Some(seconds) = seconds[step.path][step.waypoint].filter(|_| step.seconds > 0.0) else { continue };
            *print_s += seconds - step.seconds;
            *total_s += seconds - step.seconds;
            step.feed *= step.seconds / seconds;
            step.seconds = seconds;
        }
    }

    /// The moves of the machine file.
    pub fn moves(&self) -> impl Iterator<Item = gcode::Move> {
        self.deposition.moves.iter().map(|plan| {
            let (tip, direction, feed_mm_s) = (plan.tip, plan.direction, plan.feed);
            match plan.kind {
                MoveKind::Retract => gcode::Move::Retract { filament_mm: -plan.filament, feed_mm_s },
                MoveKind::Prime => gcode::Move::Prime { filament_mm: plan.filament, feed_mm_s },
                MoveKind::Print => gcode::Move::Print { tip, direction, filament_mm: plan.filament, feed_mm_s },
                _ => gcode::Move::Travel { tip, direction, feed_mm_s },
            }
        })
    }
}

/// The points and widths of the curves of a layer.
type Curves = Vec<(Vec<Point3<f64>>, Vec<f64>, bool)>;

fn curves(layer: &Layer) -> Curves {
    let of = |path: &curvlay_toolpath::surface::SurfacePath| {
        let (points, widths) = path.points.iter().map(|point| (point.at.position, point.width)).unzip();
        (points, widths, path.closed)
    };
    layer.paths.paths.iter().map(of).collect()
}

/// Does some work with the layers as they are built: surfaces with their thickness, and the curves on them.
pub fn with_layers<T>(
    surfaces: &SurfacesRun,
    paths: &PathsRun,
    work: impl FnOnce(&LayerStack) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let thickness = even_thicknesses(surfaces);
    let curves: Vec<Curves> = paths.layers.iter().map(|layer| layer.as_ref().map(curves).unwrap_or_default()).collect();
    let borrowed: Vec<Vec<LayerCurve>> = curves
        .iter()
        .map(|curves| {
            curves.iter().map(|(points, widths, closed)| LayerCurve { points, widths, closed: *closed }).collect()
        })
        .collect();
    let layers: Vec<BuiltLayer> = (surfaces.sheets.iter().zip(&thickness).zip(&borrowed))
        .map(|((sheet, spacing), curves)| BuiltLayer {
            vertices: &sheet.vertices,
            triangles: &sheet.triangles,
            spacing,
            curves,
        })
        .collect();
    work(&LayerStack::new(&layers).map_err(failure)?)
}

/// Orients, frees and deposits.
pub fn run(
    args: &Args,
    nozzle: &Nozzle,
    surfaces: &SurfacesRun,
    paths: &PathsRun,
    bars: &Bars,
) -> Result<MachineRun, Failure> {
    let start = Instant::now();
    with_layers(surfaces, paths, |stack| on_layers(args, nozzle, surfaces, paths, stack, start, bars))
}

#[allow(clippy::too_many_arguments)]
fn on_layers(
    args: &Args,
    nozzle: &Nozzle,
    surfaces: &SurfacesRun,
    paths: &PathsRun,
    stack: &LayerStack,
    start: Instant,
    bars: &Bars,
) -> Result<MachineRun, Failure> {
    let progress = |p: curvlay_toolpath::Progress| {
        bars.update(p.stage, p.done, p.total);
        ControlFlow::Continue(())
    };
    let oriented = stack.orient(&OrientOptions::default(), &progress).map_err(failure)?;
    let raw = oriented.before;
    let before_gouging = Instant::now();
    let defaults = GougingOptions::default();
    // A robot's motion gouges nowhere: what it cannot print so is left out.
    let most_depth = if args.stage >= Stage::Motion { defaults.allowed_depth } else { defaults.most_depth };
    let options =
        GougingOptions { allowed_depth: PLANNED_DEPTH, plate_clearance: PLANNED_CLEARANCE_MM, most_depth, ..defaults };
    let freed = stack.free(oriented.paths, nozzle, &options, &progress);
    let freed = freed.map_err(failure)?;
    let mut times = Times { gouging: before_gouging.elapsed(), orientation: start.elapsed(), ..Times::default() };

    let start = Instant::now();
    let travels = stack.travels(&freed.paths, nozzle, &TravelOptions::default(), &progress);
    let travels = travels.map_err(failure)?;
    times.travels = start.elapsed();

    let start = Instant::now();
    let options = DepositionOptions { filament_diameter: args.filament, ..DepositionOptions::default() };
    let deposition = deposit_along(&freed.paths, &travels.ways, &options).map_err(failure)?;
    times.deposition = start.elapsed();

    // What the closest points say, unfiltered, for the picture of one path.
    let unfiltered = OrientOptions { wave: 0.0, max_turn: PI, low_pass_rounds: 0, ..OrientOptions::default() };
    let unfiltered = stack.orient(&unfiltered, &progress).map_err(failure)?;
    let longest = freed.paths.iter().max_by_key(|path| path.waypoints.len());
    let example = longest.and_then(|path| {
        // Paths may have been cut.
        let of_curve = |other: &&ToolPath| (other.layer, other.curve) == (path.layer, path.curve);
        Some([unfiltered.paths.iter().find(of_curve)?.clone(), path.clone()])
    });

    let covered = |(layer, (sheet, thickness)): (&Option<Layer>, (&_, &Vec<f64>))| {
        layer.as_ref().map_or(0.0, |layer| layer.statistics.covered_fraction * volume(sheet, thickness))
    };
    let thickness = even_thicknesses(surfaces);
    let covered_mm3 = paths.layers.iter().zip(surfaces.sheets.iter().zip(&thickness)).map(covered).sum();
    Ok(MachineRun { raw, freed, travels, deposition, covered_mm3, example, times })
}

/// The thickness of each triangle of each layer, as beads have it.
fn even_thicknesses(surfaces: &SurfacesRun) -> Vec<Vec<f64>> {
    let least = LEAST_HEIGHT * surfaces.height_mm;
    let sheets = surfaces.sheets.iter().zip(&surfaces.spacing.thickness_mm);
    sheets.map(|(sheet, thickness)| even_thickness(sheet, thickness, least)).collect()
}

/// The thickness of each triangle as the mean over those around its corners, by area. Where layers bend, rays from
/// neighbouring triangles end up to twice as far away; beads cannot jump like that.
fn even_thickness(sheet: &TrimmedSheet, thickness: &[f64], least: f64) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; sheet.vertices.len()];
    for (corners, thickness) in sheet.triangles.iter().zip(thickness) {
        let area = area(sheet, corners);
        for &corner in corners {
            let [volume, around] = &mut sums[corner as usize];
            *volume += area * thickness;
            *around += area;
        }
    }
    let even = |(corners, &thickness): (&[u32; 3], &f64)| {
        let mean = |corner: u32| {
            let [volume, around] = sums[corner as usize];
            if around > 0.0 { volume / around } else { thickness }
        };
        (corners.iter().map(|&corner| mean(corner)).sum::<f64>() / 3.0).max(least)
    };
    sheet.triangles.iter().zip(thickness).map(even).collect()
}

/// Area by thickness.
fn volume(sheet: &TrimmedSheet, thickness: &[f64]) -> f64 {
    sheet.triangles.iter().zip(thickness).map(|(corners, thickness)| area(sheet, corners) * thickness).sum()
}

fn area(sheet: &TrimmedSheet, corners: &[u32; 3]) -> f64 {
    let [a, b, c]: [Point3<f64>; 3] = corners.map(|corner| sheet.vertices[corner as usize]);
    (b - a).cross(&(c - a)).norm() / 2.0
}
