//! Guide curves and their geodesic offsets: the second way to lines of even spacing.
//!
//! A guide curve is laid on the layer, and goes on straight from its ends to the border. Triangles that it crosses are cut along it (see
//! `insert`), so that it is a chain of edges, and the exact distance to it (see [`SurfaceDistance`]) has its level lines at whole multiples of the
//! spacing ([`LevelField`]). With several guides each place belongs to the nearest one. Where a guide meets the border at a slant, offsets bend around
//! its end.
//!
//! Triangles are first cut into four until no edge is longer than the spacing: within a triangle a guide is straight, and cuts its corners.

use super::insert::{Chain, insert, quartered};
use super::lines::CentreLine;
use super::near::{Layer, surface_point};
use super::walk::walk;
use crate::geodesic::{DistanceError, Sources, SurfaceDistance};
use crate::level_set::{LevelField, LevelSetError};
use crate::mesh::{MeshError, SurfaceMesh, SurfacePoint};
use crate::{Progress, ProgressFn};
use nalgebra::{Point3, Vector3};

/// Why there are no offsets.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OffsetError {
    /// The spacing is not a length.
    #[error("a spacing of {spacing} mm: it must be a length above zero")]
    Spacing {
        /// What was given.
        spacing: f64,
    },
    /// The spacing is too fine for the size of the layer.
    #[error("a spacing of {spacing} mm takes more than {triangles} triangles: are the units right?")]
    TooFine {
        /// The spacing.
        spacing: f64,
        /// The limit.
        triangles: usize,
    },
    /// No guide curve was given, or one without length.
    #[error("guide curve {guide} has no length; each needs two different points")]
    NoGuide {
        /// Number of the curve; 0 without any curve.
        guide: usize,
    },
    /// A point of a guide curve is not on the layer.
    #[error("point {point} of guide curve {guide} is NaN, infinite or farther than {reach} mm from the layer")]
    GuideOffLayer {
        /// Number of the curve.
        guide: usize,
        /// Number of the point.
        point: usize,
        /// How far it may be.
        reach: f64,
    },
    /// A guide curve crosses itself, or would where it goes on to the border.
    #[error("guide curve {guide} crosses itself near {at:?}, or does so where it goes on straight to the border")]
    CrossesItself {
        /// Number of the curve.
        guide: usize,
        /// About where.
        at: [f64; 3],
    },
    /// A guide cuts a triangle into slivers without area.
    #[error("a guide curve cuts the layer into triangles without area: {0}")]
    Sliver(MeshError),
    /// The distance fails.
    #[error(transparent)]
    Distance(#[from] DistanceError),
    /// The level sets of the distance fail.
    #[error(transparent)]
    Levels(#[from] LevelSetError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Triangles after cutting, at most.
const MAX_TRIANGLES: usize = 1 << 21;

/// Lines run where the distance is a multiple of the spacing within about this share of it.
const TOLERANCE: f64 = 0.01;

/// A guide goes on straight for at most this many diagonals of the layer: a closed layer has no border.
const MAX_DIAGONALS: f64 = 2.0;

/// Guide curves and their offsets at whole multiples of a spacing.
///
/// # Arguments
/// * `guides`: polylines in millimetres, closed if the last point is the first. Two guides may cross, one may not cross itself.
/// * `spacing`: between lines; `reach`: how far the points of guides may be from the layer; both in millimetres.
///
/// # Returns
/// For each guide its line, then all offsets. A guide that crosses no edge of the layer has no line of its own.
///
/// # Errors
/// [`OffsetError`].
///
/// # Cost
/// That of an exact [`SurfaceDistance`].
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::fiber::offsets::offset_lines;
/// use curvlay_toolpath::mesh::SurfaceMesh;
/// use std::ops::ControlFlow;
/// let corners = [[0.0, 0.0], [12.0, 0.0], [12.0, 7.0], [0.0, 7.0]].map(|[x, y]| Point3::new(x, y, 0.0));
/// let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
/// // In the middle, and 3 mm to both sides. The guide goes on to the border.
/// let guide = vec![Point3::new(3.0, 3.5, 0.0), Point3::new(5.0, 3.5, 0.0)];
/// let lines = offset_lines(&mesh, &[guide], 3.0, 1.0, &|_| ControlFlow::Continue(()))?;
/// assert_eq!(lines.len(), 3);
/// assert!(lines.iter().all(|line| (line.length() - 12.0).abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn offset_lines(
    mesh: &SurfaceMesh,
    guides: &[Vec<Point3<f64>>],
    spacing: f64,
    reach: f64,
    progress: ProgressFn,
) -> Result<Vec<CentreLine>, OffsetError> {
    if !(spacing > 0.0 && spacing <= 1e100) {
        return Err(OffsetError::Spacing { spacing });
    }
    check(mesh, guides, reach)?;
    let (mut fine, mut parents) =
        quartered(mesh, spacing, MAX_TRIANGLES).ok_or(OffsetError::TooFine { spacing, triangles: MAX_TRIANGLES })?;
    let mut chains: Vec<Chain> = Vec::new();
    for (guide, points) in guides.iter().enumerate() {
        let tick = Progress { stage: "guides", done: guide as u64, total: guides.len() as u64 };
        if progress(tick).is_break() {
            return Err(OffsetError::Cancelled);
        }
        let crossings = trace(&fine, points);
        let found = insert(&fine, &parents, &crossings, is_closed(points));
        let (cut, cut_parents, chain) =
            found.map_err(|at| OffsetError::CrossesItself { guide, at: at.into() })?.map_err(OffsetError::Sliver)?;
        (fine, parents) = (cut, cut_parents);
        chains.push(chain);
    }
    let edges = source_edges(&fine, &chains);
    if edges.is_empty() {
        return Ok(Vec::new());
    }
    let distance =
        SurfaceDistance::to(&fine, Sources { edges: &edges, vertices: &[] }, progress).map_err(|e| match e {
            DistanceError::Cancelled => OffsetError::Cancelled,
            other => other.into(),
        })?;
    let field = LevelField::new(&distance, TOLERANCE * spacing, progress).map_err(levels_failed)?;
    let farthest = distance.at_vertices().iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
    // The distance may have a summit inside a triangle, so one level more.
    let levels: Vec<f64> = (1..=(farthest / spacing) as usize + 1).map(|k| k as f64 * spacing).collect();
    let on_mesh = |p: &SurfacePoint| surface_point(mesh, parents[p.triangle as usize], p.position);
    let mut lines: Vec<CentreLine> =
        chains.iter().filter_map(|chain| guide_line(mesh, &fine, &parents, chain)).collect();
    let rings = field.level_sets(&levels).map_err(levels_failed)?.rings;
    lines.extend(
        rings.iter().map(|ring| CentreLine { points: ring.points.iter().map(on_mesh).collect(), closed: ring.closed }),
    );
    Ok(lines)
}

fn levels_failed(error: LevelSetError) -> OffsetError {
    match error {
        LevelSetError::Cancelled => OffsetError::Cancelled,
        other => other.into(),
    }
}

fn check(mesh: &SurfaceMesh, guides: &[Vec<Point3<f64>>], reach: f64) -> Result<(), OffsetError> {
    if guides.is_empty() {
        return Err(OffsetError::NoGuide { guide: 0 });
    }
    let layer = Layer::new(mesh);
    for (guide, points) in guides.iter().enumerate() {
        let on_layer = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= 1e100) && layer.nearest(*p, reach).is_some();
        if let Some(point) = points.iter().position(|p| !on_layer(p)) {
            return Err(OffsetError::GuideOffLayer { guide, point, reach });
        }
        if points.windows(2).all(|ends| (ends[1] - ends[0]).norm() <= 0.0) {
            return Err(OffsetError::NoGuide { guide });
        }
    }
    Ok(())
}

fn is_closed(points: &[Point3<f64>]) -> bool {
    points.len() > 3 && points.first() == points.last()
}

/// The edges that a guide crosses, as half-edges from the near side, and where: straight over the layer from point to point, each step towards
/// the next point from wherever the last one ended, and on from both ends to the border.
fn trace(mesh: &SurfaceMesh, points: &[Point3<f64>]) -> Vec<(u32, Point3<f64>)> {
    let layer = Layer::new(mesh);
    let far = mesh.diagonal();
    let near = |p: Point3<f64>| layer.nearest(p, f64::INFINITY);
    let Some(start) = points.first().and_then(|p| near(*p)) else { return Vec::new() };
    let (mut at, mut crossings, mut first, mut last) = (start, Vec::new(), None, None::<Vector3<f64>>);
    let mut go_to = |target: &Point3<f64>, crossings: &mut Vec<(u32, Point3<f64>)>| {
        let Some(target) = near(*target) else { return };
        let way = target.position - at.position;
        let found = walk(mesh, &at, way, way.norm(), |h, p| crossings.push((h, p)));
        if let Some(found) = found.filter(|_| way.norm() > 0.0) {
            first = first.or(Some(way));
            (at, last) = (found.at, Some(found.direction));
        }
    };
    // How many edges are crossed on the way to each point.
    let mut counts = Vec::with_capacity(points.len());
    for target in &points[1..] {
        go_to(target, &mut crossings);
        counts.push(crossings.len());
    }
    if is_closed(points) {
        // On along the beginning, until an edge is crossed again. That need not be the first one: a start on an edge lies on either side of it, and one on
        // a corner is passed on either side.
        let once = crossings.len();
        let round = points[1..].iter().zip(counts).find_map(|(target, count)| {
            go_to(target, &mut crossings);
            let (begun, on) = (&crossings[..count], &crossings[once..]);
            (0..count).find_map(|k| Some(k..once + on.iter().position(|crossing| crossing.0 == begun[k].0)?))
        });
        return crossings[round.unwrap_or(0..once)].to_vec();
    }
    if let Some(direction) = last {
        walk(mesh, &at, direction, MAX_DIAGONALS * far, |h, p| crossings.push((h, p)));
    }
    let mut before = Vec::new();
    if let Some(direction) = first {
        walk(mesh, &start, -direction, MAX_DIAGONALS * far, |h, p| before.push((h, p)));
    }
    // Backwards the half-edge is the one on the other side, if there is one.
    let turned = before.into_iter().rev().map(|(h, p)| (mesh.twin(h).unwrap_or(h), p));
    turned.chain(crossings).collect()
}

/// The edges of all chains in the mesh that was cut last: an edge of an earlier chain may have been cut by a later guide.
fn source_edges(mesh: &SurfaceMesh, chains: &[Chain]) -> Vec<[u32; 2]> {
    let mut edges = Vec::new();
    for chain in chains {
        for ends in chain.ends() {
            let [from, to] = ends.map(|v| mesh.vertices()[v as usize]);
            // From vertex to vertex along the straight line.
            let mut at = ends[0];
            for _ in 0..mesh.vertices().len() {
                if at == ends[1] {
                    break;
                }
                let left = (to - mesh.vertices()[at as usize]).norm();
                let on = |&v: &u32| {
                    let p = mesh.vertices()[v as usize];
                    let off = (p - from).cross(&(to - from)).norm();
                    off <= 1e-9 * (to - from).norm_squared() && (to - p).norm() < left
                };
                let Some(next) = super::direction::around(mesh, at).filter(on).max_by(|&a, &b| {
                    let left = |v: u32| (to - mesh.vertices()[v as usize]).norm();
                    left(a).total_cmp(&left(b))
                }) else {
                    break;
                };
                edges.push([at, next]);
                at = next;
            }
        }
    }
    edges
}

/// The line of a guide itself.
fn guide_line(mesh: &SurfaceMesh, fine: &SurfaceMesh, parents: &[u32], chain: &Chain) -> Option<CentreLine> {
    let point = |&v: &u32| {
        let triangle = fine.fan(v).next().map_or(0, |h| h / 3);
        surface_point(mesh, parents[triangle as usize], fine.vertices()[v as usize])
    };
    (chain.vertices.len() > 1)
        .then(|| CentreLine { points: chain.vertices.iter().map(point).collect(), closed: chain.closed })
}
