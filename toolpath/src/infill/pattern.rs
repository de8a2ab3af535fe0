//! Rows and gyroid curves on the sparse part of a layer.
//!
//! Rows are level sets of the exact geodesic distance from a cut through the middle of each connected part of the inside, half a distance
//! between rows from it and at every one from there, on both sides: as those of a zigzag, but farther apart. The cut stands upright on the
//! surface, and its direction turns from layer to layer.
//!
//! A gyroid, `sin x cos y + sin y cos z + sin z cos x = 0` (Schoen, "Infinite periodic minimal surfaces without self-intersections",
//! NASA TN D-5541, 1970, near enough), is the same in space for all layers: its curves on one layer stand on those of the layer before.
//!
//! Both end at the rim of the sparse part, and ends that follow each other on a rim are joined along it. What that takes is taken into
//! account: the distance between rows, and the period of a gyroid, are corrected once so that the length of all is what the density
//! asks for.

use super::error::FillError;
use super::on_mesh::OnMesh;
use super::split::{Class, Sheet};
use crate::contour::{Cut, Loop, Rim, Row, end, joined};
use crate::geodesic::{Sources, SurfaceDistance};
use crate::level_set::{LevelField, Ring};
use crate::mesh::{SurfaceMesh, SurfacePoint, previous};
use crate::path::{InfillOptions, InfillPattern, PathError};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_4, TAU};
use std::ops::ControlFlow;

/// How far rows may be off, in beads.
const TOLERANCE: f64 = 0.05;
/// Points of a row nearer together than this, in beads, are thinned out.
const THIN: f64 = 0.25;
/// An end this near to a rim lies on it, in beads.
const NEAR: f64 = 0.1;
/// Longer pieces of a rim join nothing, in distances between rows.
const LONGEST_JOIN: f64 = 2.0;
/// How often the distance between rows is corrected.
const ROUNDS: usize = 10;
/// It is right if the length of all is off by less than this share.
const CLOSE: f64 = 0.01;
/// By how much it may be corrected: parts with few rows have no distance that gives the length wanted.
const CORRECTION: [f64; 2] = [0.5, 2.0];
/// Length of the curves on a plane by its area, for a gyroid with a period of 1: `PI / 4` times the area of a gyroid by volume, 3.097, for
/// planes of all directions; 2.463 for those across an axis.
const GYROID_LENGTH: f64 = 2.44;
/// Triangles are divided until they are no longer than this share of the period of a gyroid.
const GYROID_STEP: f64 = 1.0 / 16.0;
/// The longest that a mean normal may be missing: below this share of the area surfaces look to all sides, and rows turn about z.
const MIN_FACING: f64 = 0.2;

/// What is wanted.
pub(super) struct Wanted<'a> {
    pub bead: f64,
    pub infill: &'a InfillOptions,
    /// Number of whole layers before it.
    pub number: usize,
    /// Area that has to be filled, in square millimetres.
    pub area: f64,
}

/// A curve, and whether it is closed.
pub(super) type Curve = (Vec<SurfacePoint>, bool);

/// The curves on the sparse part of a sheet, by points of the mesh of the layer.
pub(super) fn curves(mesh: &SurfaceMesh, sheet: &Sheet, wanted: &Wanted) -> Result<Vec<Curve>, FillError> {
    let Some((sparse, parents)) = sheet.part(|class| class == Class::Sparse)? else { return Ok(Vec::new()) };
    let on_mesh = OnMesh { mesh, parents: &parents };
    let loops = rims(&sparse, on_mesh);
    let rims: Vec<Rim> = loops.iter().map(|on| Rim { on, region: 0 }).collect();
    let spacing = wanted.bead / wanted.infill.density;
    match wanted.infill.pattern {
        InfillPattern::Rows => {
            // What is inward of the walls, skins included: rows go on straight behind a skin.
            let (mut inside, mut kept) = (Vec::new(), Vec::new());
            for (t, class) in sheet.classes.iter().enumerate().filter(|(_, class)| **class != Class::Wall) {
                inside.push(t);
                kept.push(*class == Class::Sparse);
            }
            let Some((core, parents)) = sheet.part(|class| class != Class::Wall)? else { return Ok(Vec::new()) };
            rows_of(&core, &kept, OnMesh { mesh, parents: &parents }, &rims, spacing, wanted)
        }
        InfillPattern::Gyroid => {
            let at = |period: f64| gyroid(&sparse, on_mesh, &rims, period, wanted.bead);
            corrected(mesh, &rims, GYROID_LENGTH * spacing, spacing, wanted, at)
        }
    }
}

/// Finds curves for a distance (or a period) such that their length, joins included, is what the density asks for.
fn corrected(
    mesh: &SurfaceMesh,
    rims: &[Rim],
    first: f64,
    spacing: f64,
    wanted: &Wanted,
    rows: impl Fn(f64) -> Result<Vec<Row>, FillError>,
) -> Result<Vec<Curve>, FillError> {
    let length = wanted.infill.density * wanted.area / wanted.bead;
    let mut distance = first;
    let mut best: Option<(f64, Vec<Curve>)> = None;
    // The length falls with the distance, in steps: where a row comes or goes.
    let mut between = CORRECTION.map(|by| by * first);
    for _ in 0..ROUNDS {
        let rows = rows(distance)?;
        let curves: Vec<Curve> = joined(mesh, &rows, rims, LONGEST_JOIN * spacing)
            .into_iter()
            .map(|(points, closed, _)| (points, closed))
            .collect();
        let all: f64 = curves.iter().map(|(points, closed)| along(points, *closed)).sum();
        let off = (all / length - 1.0).abs();
        if best.as_ref().is_none_or(|(known, _)| off < *known) {
            best = Some((off, curves));
        }
        between[if all > length { 0 } else { 1 }] = distance;
        if off < CLOSE || between[1] - between[0] < CLOSE * first {
            break;
        }
        let next = distance * all / length;
        distance = if between[0] < next && next < between[1] { next } else { (between[0] + between[1]) / 2.0 };
    }
    Ok(best.map(|(_, curves)| curves).unwrap_or_default())
}

fn along(points: &[SurfacePoint], closed: bool) -> f64 {
    let steps: f64 = points.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).sum();
    match (closed, points.first(), points.last()) {
        (true, Some(first), Some(last)) => steps + (first.position - last.position).norm(),
        _ => steps,
    }
}

/// The boundary of the sparse part.
fn rims(sparse: &SurfaceMesh, on_mesh: OnMesh) -> Vec<Loop> {
    let of_loop = |chain: Vec<u32>| {
        let point = |&v: &u32| {
            let triangle = sparse.fan(v).next()? / 3;
            let corner = sparse.triangles()[triangle as usize].iter().position(|&corner| corner == v)?;
            let mut barycentric = [0.0; 3];
            barycentric[corner] = 1.0;
            let position = sparse.vertices()[v as usize];
            Some(on_mesh.point(&SurfacePoint { triangle, barycentric, position }))
        };
        let points = chain.iter().filter_map(point).collect();
        Loop::new(&Ring { level: 0, points, closed: true, below: 0, above: 0 })
    };
    sparse.boundary_loops().into_iter().filter_map(of_loop).collect()
}

/// Rows by geodesic distance.
fn rows_of(
    core: &SurfaceMesh,
    kept: &[bool],
    on_mesh: OnMesh,
    rims: &[Rim],
    spacing: f64,
    wanted: &Wanted,
) -> Result<Vec<Curve>, FillError> {
    let regions = core.regions();
    let mut has_any = vec![false; regions.count];
    (0..).zip(&regions.of_triangle).for_each(|(t, &region): (usize, _)| has_any[region as usize] |= kept[t]);
    let angle = FRAC_PI_4 + wanted.number as f64 * wanted.infill.turn;
    let cut = Cut::new(
        core,
        |t| has_any[regions.of_triangle[t as usize] as usize],
        |mesh, triangles| across(mesh, triangles, angle),
    );
    if cut.line.is_empty() {
        return Ok(Vec::new());
    }
    let go_on = |_| ControlFlow::Continue(());
    let halves = SurfaceMesh::new(cut.vertices.clone(), cut.triangles.clone())?;
    let distance = SurfaceDistance::to(&halves, Sources { edges: &cut.line, ..Sources::default() }, &go_on)?;
    let field = LevelField::new(&distance, TOLERANCE * wanted.bead, &go_on)?;
    let reach = field.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let least = THIN * wanted.bead;
    let rows = |spacing: f64| {
        let levels: Vec<f64> =
            (0..).map(|k| (f64::from(k) + 0.5) * spacing).take_while(|&level| level < reach).collect();
        let mut rows = Vec::new();
        for ring in field.level_sets(&levels).map_err(PathError::from)?.rings {
            let Some(first) = ring.points.first() else { continue };
            let number = if cut.above[first.triangle as usize] { ring.level as i64 } else { -1 - ring.level as i64 };
            let is_kept = |at: &SurfacePoint| kept[cut.parents[at.triangle as usize] as usize];
            for (points, closed) in pieces(&ring, is_kept) {
                let on_core = |at: &SurfacePoint| SurfacePoint { triangle: cut.parents[at.triangle as usize], ..*at };
                let points = points.iter().map(|at| on_mesh.point(&on_core(at))).collect();
                rows.push(row(number, thinned(points, least), closed, rims, wanted.bead));
            }
        }
        Ok(rows)
    };
    corrected(on_mesh.mesh, rims, spacing, spacing, wanted, rows)
}

fn row(number: i64, points: Vec<SurfacePoint>, closed: bool, rims: &[Rim], bead: f64) -> Row {
    let place = |at: Option<&SurfacePoint>| at.and_then(|at| end(rims, at, NEAR * bead));
    let ends = if closed { [None; 2] } else { [place(points.first()), place(points.last())] };
    Row { number, points, closed, ends }
}

/// Leaves out points that are near the one before, but for the ends.
fn thinned(points: Vec<SurfacePoint>, least: f64) -> Vec<SurfacePoint> {
    let mut kept: Vec<SurfacePoint> = Vec::with_capacity(points.len());
    let near = |a: &SurfacePoint, b: &SurfacePoint| (a.position - b.position).norm() < least;
    for point in &points {
        if !kept.last().is_some_and(|last| near(last, point)) {
            kept.push(*point);
        }
    }
    if let Some(end) = points.last().filter(|end| kept.last() != Some(end)) {
        if kept.len() > 1 {
            kept.pop();
        }
        kept.push(*end);
    }
    kept
}

/// The runs of a ring's segments that are kept, each in the triangle of its first point; and whether that is all of a closed one.
fn pieces(ring: &Ring, is_kept: impl Fn(&SurfacePoint) -> bool) -> Vec<(Vec<SurfacePoint>, bool)> {
    let count = ring.points.len();
    let segments = if ring.closed { count } else { count.saturating_sub(1) };
    let kept: Vec<bool> = ring.points[..segments].iter().map(is_kept).collect();
    if ring.closed && kept.iter().all(|&kept| kept) {
        return vec![(ring.points.clone(), true)];
    }
    // A closed one is looked at from the end of a run on.
    let first = if ring.closed { kept.iter().position(|&kept| !kept).unwrap_or(0) } else { 0 };
    let mut found = Vec::new();
    let mut run: Vec<SurfacePoint> = Vec::new();
    for step in 0..segments {
        let k = (first + step) % segments;
        if kept[k] {
            if run.is_empty() {
                run.push(ring.points[k]);
            }
            run.push(ring.points[(k + 1) % count]);
        } else if !run.is_empty() {
            found.push((std::mem::take(&mut run), false));
        }
    }
    found.extend((!run.is_empty()).then_some((run, false)));
    // The last point may lie in the triangle beyond; that is as good.
    found
}

/// The direction across the rows of a part, and where its centre lies along it.
fn across(mesh: &SurfaceMesh, triangles: &[u32], angle: f64) -> (Vector3<f64>, f64) {
    let (mut facing, mut centre, mut area) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for &t in triangles {
        let [a, b, c] = mesh.triangles()[t as usize].map(|v| mesh.vertices()[v as usize]);
        let normal = 0.5 * (b - a).cross(&(c - a));
        let size = normal.norm();
        facing += normal;
        centre += (a.coords + b.coords + c.coords) * (size / 3.0);
        area += size;
    }
    let up = facing.try_normalize(MIN_FACING * area).unwrap_or_else(Vector3::z);
    // The axis that is most across, x before y.
    let axis = if up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let one = (axis - up * axis.dot(&up)).normalize();
    let normal = one * angle.cos() + up.cross(&one) * angle.sin();
    (normal, centre.dot(&normal) / area)
}

/// Where a gyroid meets the sparse part.
fn gyroid(sparse: &SurfaceMesh, on_mesh: OnMesh, rims: &[Rim], period: f64, bead: f64) -> Result<Vec<Row>, FillError> {
    let (fine, parents) = divided(sparse, GYROID_STEP * period)?;
    let value = |p: &Point3<f64>| {
        let [x, y, z] = [p.x, p.y, p.z].map(|c| TAU * c / period);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    };
    let values: Vec<f64> = fine.vertices().iter().map(value).collect();
    let row_of = |ring: Ring| {
        let on_sparse = |at: &SurfacePoint| SurfacePoint { triangle: parents[at.triangle as usize], ..*at };
        let points = ring.points.iter().map(|at| on_mesh.point(&on_sparse(at))).collect();
        row(0, thinned(points, THIN * bead), ring.closed, rims, bead)
    };
    Ok(traced(&fine, &values).into_iter().map(row_of).collect())
}

/// A mesh with triangles divided in four until none is longer than that, and the triangle that each is a part of.
fn divided(mesh: &SurfaceMesh, longest: f64) -> Result<(SurfaceMesh, Vec<u32>), FillError> {
    let mut fine = mesh.clone();
    let mut parents: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
    let length = |mesh: &SurfaceMesh, h: u32| {
        (mesh.vertices()[mesh.head(h) as usize] - mesh.vertices()[mesh.tail(h) as usize]).norm()
    };
    while (0..fine.half_edges()).any(|h| length(&fine, h) > longest) {
        let mut points = fine.vertices().to_vec();
        let mut middle = vec![u32::MAX; fine.half_edges() as usize];
        for h in 0..fine.half_edges() {
            let edge = fine.edge(h) as usize;
            if middle[edge] == u32::MAX {
                middle[edge] = points.len() as u32;
                let [from, to] = [fine.tail(h), fine.head(h)].map(|v| fine.vertices()[v as usize]);
                points.push(from + (to - from) * 0.5);
            }
        }
        let mut triangles = Vec::with_capacity(4 * fine.triangles().len());
        for (t, &[a, b, c]) in (0..).zip(fine.triangles()) {
            let [ab, bc, ca] = [0, 1, 2].map(|k| middle[fine.edge(3 * t + k) as usize]);
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        parents = parents.iter().flat_map(|&parent| [parent; 4]).collect();
        fine = SurfaceMesh::new(points, triangles)?;
    }
    Ok((fine, parents))
}

/// The zero set of values that are linear over triangles, as polylines: each segment in the triangle of its first point.
fn traced(mesh: &SurfaceMesh, values: &[f64]) -> Vec<Ring> {
    let above = |v: u32| values[v as usize] > 0.0;
    let falls = |h: &u32| above(mesh.tail(*h)) && !above(mesh.head(*h));
    let crossing = |h: u32| {
        let [high, low] = if above(mesh.tail(h)) { [mesh.tail(h), mesh.head(h)] } else { [mesh.head(h), mesh.tail(h)] };
        let [top, bottom] = [high, low].map(|v| values[v as usize]);
        let [p, q] = [high, low].map(|v| mesh.vertices()[v as usize]);
        SurfacePoint { triangle: h / 3, barycentric: [1.0 / 3.0; 3], position: p + (q - p) * (top / (top - bottom)) }
    };
    let mut seen = vec![false; mesh.triangles().len()];
    let mut rings = Vec::new();
    // Those that begin at the boundary first.
    let starts = mesh.boundary_half_edges().chain(0..mesh.half_edges()).filter(falls);
    for first in starts {
        let mut ring = Ring { level: 0, points: Vec::new(), closed: true, below: 0, above: 0 };
        let mut at = first;
        if seen[first as usize / 3] {
            continue;
        }
        while !seen[at as usize / 3] {
            seen[at as usize / 3] = true;
            ring.points.push(crossing(at));
            let out = if above(mesh.tail(previous(at))) { crate::mesh::next(at) } else { previous(at) };
            match mesh.twin(out) {
                Some(twin) => at = twin,
                None => {
                    ring.points.push(crossing(out));
                    ring.closed = false;
                }
            }
        }
        rings.push(ring);
    }
    rings
}
