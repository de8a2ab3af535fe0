//! From the file to strokes on the surface.

use super::fault::fault;
use super::input::skipped;
use super::{Args, FillKind, ProjectionKind, input};
use curvlay_examples::args::{Failure, warn};
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::{Mesh, MeshFile, read_mesh_file};
use curvlay_kinematics::nalgebra::{Point2, Point3, Vector3};
use curvlay_toolpath::drawing::{
    Centre, Contour, ContourAt, Coverage, Distortion, Drawing, Fill, FillOptions, Filled, Flatten, Gap, MeshSurface,
    Overlaps, Projection, Revolved, Stroke, Surface, SurfacePoint, UnrollKind, UnrollOptions, UnrolledMesh, area_sum,
    centre_of, coverage, distortion, fill, gaps, join, order, place, project, raised, remove_overlaps, start_strokes,
    thin_clusters, union_area,
};
use std::path::Path;

/// Distances over which distortion is sampled, in points of the design.
const DISTORTION_SAMPLES: usize = 5000;

/// Gaps between ends up to this, in millimetres of the file, are findings.
const WIDEST_GAP_MM: f64 = 0.5;

/// Open contours are left out where so many beads are: two lines may cross.
const MAX_BEADS: usize = 2;

/// What carries the design.
pub enum Carrier {
    Revolved(Revolved),
    Mesh(MeshSurface),
    Unrolled(Box<UnrolledMesh>),
}

impl Surface for Carrier {
    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint> {
        match self {
            Carrier::Revolved(surface) => surface.hit(from, direction),
            Carrier::Mesh(surface) => surface.hit(from, direction),
            Carrier::Unrolled(surface) => surface.hit(from, direction),
        }
    }

    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        match self {
            Carrier::Revolved(surface) => surface.over(at),
            Carrier::Mesh(surface) => surface.over(at),
            Carrier::Unrolled(surface) => surface.over(at),
        }
    }

    fn along_meridian(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        match self {
            Carrier::Revolved(surface) => surface.along_meridian(at),
            Carrier::Mesh(surface) => surface.along_meridian(at),
            Carrier::Unrolled(surface) => surface.along_meridian(at),
        }
    }

    fn has_meridians(&self) -> bool {
        matches!(self, Carrier::Revolved(_))
    }

    fn unrolled(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        match self {
            Carrier::Revolved(surface) => surface.unrolled(at),
            Carrier::Mesh(surface) => surface.unrolled(at),
            Carrier::Unrolled(surface) => surface.unrolled(at),
        }
    }

    fn is_unrolled(&self) -> bool {
        !matches!(self, Carrier::Mesh(_))
    }
}

/// A stroke on the surface.
pub struct OnSurface {
    pub points: Vec<SurfacePoint>,
    /// Which of the strokes.
    pub stroke: usize,
    /// Layer of beads, from 0.
    pub layer: u32,
}

/// A planned print.
pub struct Planned {
    pub name: String,
    pub drawing: Drawing,
    /// The entities of the chosen layers, each a piece.
    pub pieces: Vec<Contour>,
    /// The contours in their place and order.
    pub contours: Vec<Contour>,
    pub duplicates: usize,
    pub zero_length: usize,
    /// Ends of contours that nearly meet, in the drawing.
    pub gaps: Vec<Gap>,
    /// Width and height of the design on the chosen layers, before it is scaled.
    pub size_mm: [f64; 2],
    pub scale: f64,
    pub area_sum_mm2: f64,
    pub area_union_mm2: f64,
    pub overlaps: Overlaps,
    pub filled: Filled,
    pub on_printed: usize,
    pub thinned_mm: f64,
    pub carrier: Carrier,
    /// The mesh that carries the design, in the frame of the platform.
    pub mesh: Option<Mesh>,
    pub projection: Projection,
    pub strokes: Vec<OnSurface>,
    /// Strokes of the same design filled with scan lines that are not joined, as in the thesis.
    pub stops_scan_lines: usize,
    pub coverage: Coverage,
    pub distortion: Distortion,
}

impl Planned {
    pub fn closed(&self) -> usize {
        self.contours.iter().filter(|contour| contour.closed).count()
    }

    /// The stroke in the plane.
    pub fn flat(&self, on_surface: &OnSurface) -> &Stroke {
        &self.filled.strokes[on_surface.stroke]
    }
}

/// What carries the design, and the mesh that it is, if it is one.
fn carrier(args: &Args) -> Result<(Carrier, Option<Mesh>), Failure> {
    let radius = 0.5 * args.platform_diameter_mm;
    let profile = match args.surface.as_str() {
        "dome" => args.setup.dome(),
        "sphere" => args.setup.sphere(),
        file => {
            let path = Path::new(file);
            let MeshFile { mesh, findings, .. } = read_mesh_file(path)?;
            findings.iter().for_each(|finding| warn(format!("{file}: {finding}")));
            // Its box in the middle of the axis, its highest point where that of the dome is.
            let first = mesh.vertices.first().copied().unwrap_or_else(Point3::origin);
            let (low, high) = mesh.vertices.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
            let shift =
                Vector3::new(-0.5 * (low.x + high.x), -0.5 * (low.y + high.y), args.setup.pole_height_mm() - high.z);
            let vertices: Vec<Point3<f64>> = mesh.vertices.iter().map(|vertex| vertex + shift).collect();
            let placed = Mesh { vertices, triangles: mesh.triangles };
            let kind = match args.projection {
                ProjectionKind::Rigid => UnrollKind::Rigid,
                ProjectionKind::Conformal => UnrollKind::Conformal,
                _ => {
                    let surface = MeshSurface::new(&placed.vertices, &placed.triangles);
                    return Ok((Carrier::Mesh(surface.map_err(|error| fault(path, error))?), Some(placed)));
                }
            };
            let options = UnrollOptions { kind, reach: radius, ..UnrollOptions::default() };
            let unrolled = UnrolledMesh::new(&placed.vertices, &placed.triangles, options);
            let unrolled = unrolled.map_err(|error| fault(path, error))?;
            return Ok((Carrier::Unrolled(Box::new(unrolled)), Some(placed)));
        }
    };
    if matches!(args.projection, ProjectionKind::Rigid | ProjectionKind::Conformal) {
        return Err(Failure::of_arguments(format!(
            "--projection rigid and conformal are for meshes; for the {} take meridian",
            args.surface
        )));
    }
    let revolved = Revolved::new(profile, radius).map_err(|_| {
        Failure::of_arguments(format!(
            "the {} has no surface out to a diameter of {} mm",
            args.surface, args.platform_diameter_mm
        ))
    })?;
    Ok((Carrier::Revolved(revolved), None))
}

/// How the beads lie.
pub fn fill_options(args: &Args) -> FillOptions {
    FillOptions {
        bead: args.bead_mm,
        contour: if args.on_line { ContourAt::OnLine } else { ContourAt::Inside },
        fill: match args.fill {
            FillKind::None => Fill::None,
            FillKind::Lines => Fill::Lines,
            FillKind::Concentric => Fill::Concentric,
            FillKind::Spiral => Fill::Spiral,
        },
        angle: args.angle_deg.to_radians(),
        zigzag: !args.no_zigzag,
        gap: args.setup.fill_gap(),
        tolerance: FillOptions::default().tolerance.min(0.1 * args.bead_mm),
        ..FillOptions::default()
    }
}

/// Whether a layer is to be printed.
fn wanted(args: &Args, layer: &str) -> bool {
    args.layer.is_empty() || args.layer.iter().any(|name| name == layer)
}

/// Areas are those of curves flattened to this, in millimetres: chords of the tolerance of the print would take 1e-3 from small circles.
const AREA_TOLERANCE_MM: f64 = 1e-4;

/// Whether there is something to draw on each layer that was asked for.
fn check_layers(args: &Args, drawing: &Drawing) -> Result<(), String> {
    if drawing.entities.is_empty() {
        let found = skipped(drawing);
        let found = if found.is_empty() { "it has no entities".to_owned() } else { format!("found: {found}") };
        return Err(format!("there is nothing in it that can be drawn; {found}"));
    }
    let layers = drawing.layers();
    let Some(missing) = args.layer.iter().find(|name| !layers.iter().any(|(layer, _)| layer == *name)) else {
        return Ok(());
    };
    let names: Vec<&str> = layers.iter().map(|(layer, _)| layer.as_str()).collect();
    let mut what = format!("no entity is on layer `{missing}`; layers with entities: {}", names.join(", "));
    if !drawing.skipped.is_empty() {
        what += &format!("; not drawn: {}", skipped(drawing));
    }
    Err(what)
}

/// Width and height of contours.
fn size(contours: &[Contour]) -> [f64; 2] {
    let points = contours.iter().flat_map(|contour| &contour.points);
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let [low, high] =
        points.fold(start, |[low, high], p| [[low[0].min(p.x), low[1].min(p.y)], [high[0].max(p.x), high[1].max(p.y)]]);
    [0, 1].map(|axis| (high[axis] - low[axis]).max(0.0))
}

/// Most points of beads that are planned: some hundred megabytes with the postures of the robot. The design of the thesis has 94,419.
const MAX_BEAD_POINTS: f64 = 2e6;

/// A design that is so many times as wide as the platform lies beside it by any projection.
const MAX_PLATFORMS: f64 = 100.0;

/// Refuses a design that is far too large, or whose beads would have more points than memory should hold, by their lengths, before any
/// is laid.
fn check_points(args: &Args, contours: &[Contour], size_mm: [f64; 2], scale: f64) -> Result<(), String> {
    let [width, height] = size_mm.map(|mm| mm * scale);
    if width.max(height) > MAX_PLATFORMS * args.platform_diameter_mm {
        return Err(format!(
            "the design is {width:.1} by {height:.1} mm, the platform {} mm across; --diameter makes the design smaller, --unit sets the \
             unit of the file",
            args.platform_diameter_mm
        ));
    }
    let outlines: f64 = contours.iter().map(Contour::length).sum();
    let area = area_sum(contours).map_err(|error| error.to_string())?;
    let fills = if args.fill == FillKind::None { 0.0 } else { area / args.bead_mm };
    let points = (outlines + fills) / args.step_mm * f64::from(args.layers);
    if points <= MAX_BEAD_POINTS {
        return Ok(());
    }
    Err(format!(
        "the design is {width:.1} by {height:.1} mm: its beads would have some {points:.0} points, more than {MAX_BEAD_POINTS}; \
         a smaller --diameter, a wider --bead or a larger --step take fewer"
    ))
}

/// Why a design has no beads at all.
fn no_bead(args: &Args, drawing: &Drawing, size_mm: [f64; 2], scale: f64) -> String {
    let [width, height] = size_mm.map(|mm| mm * scale);
    let unit = match drawing.unit_mm {
        None => "; the file does not state its unit, so millimetres were taken: set --unit",
        Some(_) => "",
    };
    format!("no bead of {} mm fits into it: the design is {width:.2} by {height:.2} mm{unit}", args.bead_mm)
}

/// A design that is joined, and placed about the pole at its size.
struct Placed {
    /// The lines as they are in the file, in the same place: for the picture of the input.
    pieces: Vec<Contour>,
    contours: Vec<Contour>,
    duplicates: usize,
    zero_length: usize,
    gaps: Vec<Gap>,
    /// Of the design in its file.
    size_mm: [f64; 2],
    scale: f64,
}

/// Joins the lines of a design and places it.
fn placed(args: &Args, pieces: &[Contour]) -> Result<Placed, String> {
    let joined = join(pieces, args.join_mm).map_err(|error| error.to_string())?;
    let mut contours = joined.contours;
    let mut gaps = gaps(&contours, WIDEST_GAP_MM).map_err(|error| error.to_string())?;
    // Ends that meet where three lines do are no gap.
    gaps.retain(|gap| gap.width > args.join_mm);
    let size_mm = size(&contours);
    let centre = args.centre_mm.map_or(Centre::Box, |at| Centre::At(Point2::from(at)));
    let middle = centre_of(&contours, centre).ok_or("all its lines have no length")?;
    let scale = place(&mut contours, centre, args.diameter_mm).map_err(|error| error.to_string())?;
    let moved = |contour: &Contour| Contour {
        points: contour.points.iter().map(|at| Point2::from((at - middle) * scale)).collect(),
        ..*contour
    };
    let pieces = pieces.iter().map(moved).collect();
    order(&mut contours);
    let (duplicates, zero_length) = (joined.duplicates, joined.zero_length);
    Ok(Placed { pieces, contours, duplicates, zero_length, gaps, size_mm, scale })
}

/// All stages up to strokes on the surface.
pub fn plan(args: &Args, bars: &Bars) -> Result<Planned, Failure> {
    bars.update("read", 0, 5);
    let (name, drawing) = input::read(args)?;
    let (carrier, mesh) = carrier(args)?;
    let here = |error: &dyn std::fmt::Display| Failure::new(format!("{name}: {error}"));
    check_layers(args, &drawing).map_err(|what| here(&what))?;
    let pieces = drawing.contours(|layer| wanted(args, layer), Flatten::default()).map_err(|error| here(&error))?;

    bars.update("join", 1, 5);
    let Placed { pieces, contours, duplicates, zero_length, gaps, size_mm, scale } =
        placed(args, &pieces).map_err(|what| here(&what))?;
    check_points(args, &contours, size_mm, scale).map_err(|what| here(&what))?;

    bars.update("fill", 2, 5);
    let min_length = if args.min_area_mm2 > 0.0 { args.bead_mm } else { 0.0 };
    let overlaps = remove_overlaps(&contours, args.min_area_mm2, min_length).map_err(|error| here(&error))?;
    let mut filled = fill(&overlaps.regions, &overlaps.open, &fill_options(args)).map_err(|error| here(&error))?;
    if filled.strokes.is_empty() {
        return Err(here(&no_bead(args, &drawing, size_mm, scale)));
    }
    let thinned_mm = thin_clusters(&mut filled.strokes, MAX_BEADS).removed_mm;
    let on_printed = start_strokes(&mut filled.strokes);

    bars.update("project", 3, 5);
    let projection = projection(args);
    let strokes = projected(args, &carrier, projection, &filled.strokes, &contours).map_err(|what| here(&what))?;
    Ok(Planned {
        name,
        drawing,
        pieces,
        duplicates,
        zero_length,
        gaps,
        size_mm,
        scale,
        area_sum_mm2: 0.0,
        area_union_mm2: 0.0,
        overlaps,
        filled,
        on_printed,
        thinned_mm,
        carrier,
        mesh,
        projection,
        strokes,
        contours,
        stops_scan_lines: 0,
        coverage: Coverage::default(),
        distortion: Distortion::default(),
    })
}

/// How the design comes onto the surface.
fn projection(args: &Args) -> Projection {
    match args.projection {
        ProjectionKind::Vertical => Projection::Vertical,
        ProjectionKind::Point => Projection::FromPoint { height: -args.setup.pole_height_mm() },
        ProjectionKind::Meridian => Projection::Meridian,
        ProjectionKind::Rigid | ProjectionKind::Conformal => Projection::Unrolled,
    }
}

/// The strokes on the surface, and those of the layers above it, raised along its normals.
fn projected(
    args: &Args,
    carrier: &Carrier,
    projection: Projection,
    flat: &[Stroke],
    contours: &[Contour],
) -> Result<Vec<OnSurface>, String> {
    let mut strokes = Vec::new();
    for (number, stroke) in flat.iter().enumerate() {
        let points = project(carrier, projection, number, &stroke.points, stroke.closed, args.step_mm);
        let points = points.map_err(|error| {
            let width = 2.0 * contours.iter().flat_map(|c| &c.points).map(|at| at.coords.norm()).fold(0.0, f64::max);
            format!("{error}; the design is {width:.1} mm wide about its centre, --diameter makes it smaller")
        })?;
        strokes.push(OnSurface { points, stroke: number, layer: 0 });
    }
    let first = strokes.len();
    for layer in 1..args.layers {
        for k in 0..first {
            let points = raised(&strokes[k].points, f64::from(layer) * args.layer_height_mm);
            strokes.push(OnSurface { points, stroke: strokes[k].stroke, layer });
        }
    }
    Ok(strokes)
}

/// Figures that the program does not need.
pub fn measure(args: &Args, planned: &mut Planned, bars: &Bars) -> Result<(), Failure> {
    bars.update("measure", 4, 5);
    let fine = planned.drawing.contours(|layer| wanted(args, layer), Flatten::Tolerance(AREA_TOLERANCE_MM))?;
    let fine = join(&fine, args.join_mm)?.contours;
    let square = planned.scale * planned.scale;
    planned.area_sum_mm2 = square * area_sum(&fine)?;
    planned.area_union_mm2 = square * union_area(&fine)?;
    planned.coverage = coverage(&planned.overlaps.regions, &planned.filled.strokes)?;
    let scan = FillOptions { fill: Fill::Lines, zigzag: false, ..fill_options(args) };
    planned.stops_scan_lines = fill(&planned.overlaps.regions, &planned.overlaps.open, &scan)?.stops();
    let points: Vec<Point2<f64>> = planned.contours.iter().flat_map(|contour| &contour.points).copied().collect();
    let every = points.len().div_ceil(DISTORTION_SAMPLES).max(1);
    let sampled: Vec<Point2<f64>> = points.into_iter().step_by(every).collect();
    planned.distortion = distortion(&planned.carrier, planned.projection, &sampled);
    Ok(())
}
