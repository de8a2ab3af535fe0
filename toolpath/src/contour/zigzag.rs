//! Rows to and fro: a zigzag, for comparison.
//!
//! Each connected part of the surface is cut along a plane through its centre (`cut`). Rows are the level sets of the exact
//! geodesic distance to the cut, half a bead from it and at every bead from there, on both sides; so neighbours are
//! a bead apart everywhere, as parallel lines are in the plane. Rows end where the boundary is half a bead away.
//!
//! The ends of rows lie along the first level set of the distance to the boundary, the *rim* (`rows` joins them). Two ends that follow each other
//! on a rim and belong to neighbouring rows are joined by the rim between them. A curve takes one row after the other,
//! always to the next higher one, as long as there is such a join: this is the boustrophedon decomposition (Choset and
//! Pignon, "Coverage path planning: the boustrophedon cellular decomposition", Field and Service Robotics, 1998) without
//! making the cells first. Where a hole parts a row the curve goes on to one side of it, and the other side is left to
//! the next curve: one curve a cell. Where ends of curves follow each other on a rim, in neighbouring rows or in parts of the
//! same, these curves become one at last.
//!
//! A region too small for any row gets a bead along its rim.
//!
//! Rows know nothing of the boundary: beside the outermost ones, and at every other end, up to a bead stays bare.
//!
//! Rows meet no other rows, and each piece of a rim joins two ends next to it, so curves do not cross.

use super::cut::{Cut, across};
use super::rows::{Rim, Row, RowCurve, end, joined};
use crate::geodesic::{Sources, SurfaceDistance};
use crate::level_set::{LevelField, Ring};
use crate::mesh::{SurfaceMesh, SurfacePoint, on_mesh_triangle};
use crate::path::PathError;
use std::ops::ControlFlow;

/// How far rows may be off, in beads.
const TOLERANCE: f64 = 0.0125;
/// Rows end this much before the rim, in beads: more than either may be off.
const BEFORE: f64 = 0.04;
/// An end this near to a rim lies on it, in beads.
const NEAR: f64 = 0.25;
/// From place to place along a row that is asked how far the boundary is, in beads. What sticks out in between is less.
const STEP: f64 = 0.1;
/// Shorter rows are blots, in beads.
const SHORTEST: f64 = 1.0;
/// Rims longer than this join nothing, in beads: they run beside the rows, and would cover them twice.
const LONGEST: f64 = 6.0;
/// Halvings to find an end.
const HALVINGS: usize = 40;

/// All curves of a zigzag.
pub(super) fn curves(field: &LevelField, rims: &[Rim], bead: f64) -> Result<Vec<RowCurve>, PathError> {
    let rows = rows(field, rims, bead)?;
    let mut curves = joined(field.distance().mesh(), &rows, rims, LONGEST * bead);
    // Where no row fits the rim itself is the curve.
    let bare = |rim: &&Rim| curves.iter().all(|curve: &RowCurve| curve.2 != rim.region);
    let without: Vec<&Rim> = rims.iter().filter(bare).collect();
    curves.extend(without.into_iter().map(|rim| (rim.on.points().to_vec(), true, rim.region)));
    Ok(curves)
}

/// The rows, cut off before the rims.
fn rows(field: &LevelField, rims: &[Rim], bead: f64) -> Result<Vec<Row>, PathError> {
    let mesh = field.distance().mesh();
    // Parts without a rim have no room for rows.
    let mut has_rim = vec![false; mesh.triangles().len()];
    rims.iter().flat_map(|rim| rim.on.points()).for_each(|point| has_rim[point.triangle as usize] = true);
    let cut = Cut::new(mesh, |triangle| has_rim[triangle as usize], across);
    if cut.line.is_empty() {
        return Ok(Vec::new());
    }
    let go_on = |_| ControlFlow::Continue(());
    let halves = SurfaceMesh::new(cut.vertices.clone(), cut.triangles.clone())?;
    let sources = Sources { edges: &cut.line, ..Sources::default() };
    // Neither a missing source nor a stop is possible.
    let Ok(distance) = SurfaceDistance::to(&halves, sources, &go_on) else {
        return Ok(Vec::new());
    };
    let from_cut = LevelField::new(&distance, TOLERANCE * bead, &go_on)?;
    let reach = from_cut.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    // Half a bead from the cut on either side, so that the two rows beside it are a bead apart as well.
    let levels: Vec<f64> = (0..).map(|k| (f64::from(k) + 0.5) * bead).take_while(|&level| level < reach).collect();
    let mut rows = Vec::new();
    for ring in from_cut.level_sets(&levels)?.rings {
        let number = |above: bool| if above { ring.level as i64 } else { -1 - ring.level as i64 };
        let Some(first) = ring.points.first() else {
            continue;
        };
        let number = number(cut.above[first.triangle as usize]);
        let on_mesh = Clipper { field, cut: &cut, limit: (0.5 + BEFORE) * bead, step: STEP * bead };
        for (points, closed) in on_mesh.clip(&ring) {
            let length: f64 = points.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).sum();
            if length >= SHORTEST * bead {
                let ends = if closed {
                    [None; 2]
                } else {
                    [points[0], points[points.len() - 1]].map(|p| end(rims, &p, NEAR * bead))
                };
                rows.push(Row { number, points, closed, ends });
            }
        }
    }
    Ok(rows)
}

/// Cuts rows off where the boundary is near.
struct Clipper<'a> {
    field: &'a LevelField<'a>,
    cut: &'a Cut,
    /// Least distance from the boundary.
    limit: f64,
    step: f64,
}

impl Clipper<'_> {
    /// The point of the mesh at a place of a piece of the cut mesh.
    fn on_mesh(&self, piece: u32, position: nalgebra::Point3<f64>) -> SurfacePoint {
        let triangle = self.cut.parents[piece as usize];
        let (position, barycentric) = on_mesh_triangle(self.field.distance().mesh(), triangle, position);
        SurfacePoint { triangle, barycentric, position }
    }

    fn is_inside(&self, p: &SurfacePoint) -> bool {
        let distance = self.field.distance().at(p.triangle, p.barycentric).distance;
        distance.is_finite() && distance >= self.limit
    }

    /// The parts of a ring that are far enough from the boundary, and whether they are all of a closed one.
    fn clip(&self, ring: &Ring) -> Vec<(Vec<SurfacePoint>, bool)> {
        // Places along the ring, and whether they are points of it.
        let mut places: Vec<(SurfacePoint, bool)> = Vec::new();
        let count = ring.points.len();
        for k in 0..count {
            let from = &ring.points[k];
            places.push((self.on_mesh(from.triangle, from.position), true));
            if k + 1 == count && !ring.closed {
                break;
            }
            let way = ring.points[(k + 1) % count].position - from.position;
            let parts = (way.norm() / self.step).ceil().max(1.0) as usize;
            for part in 1..parts {
                let position = from.position + way * (part as f64 / parts as f64);
                places.push((self.on_mesh(from.triangle, position), false));
            }
        }
        let mut inside: Vec<bool> = places.iter().map(|(place, _)| self.is_inside(place)).collect();
        if ring.closed {
            // A closed row begins outside, so that no part of it runs over its start.
            match inside.iter().position(|inside| !inside) {
                None => {
                    let points = places.into_iter().filter(|(_, kept)| *kept).map(|(place, _)| place).collect();
                    return vec![(points, true)];
                }
                Some(first) => {
                    places.rotate_left(first);
                    inside.rotate_left(first);
                    // Around to where it began.
                    places.push(places[0]);
                    inside.push(false);
                }
            }
        }
        let mut found: Vec<(Vec<SurfacePoint>, bool)> = Vec::new();
        let mut open: Option<Vec<SurfacePoint>> = None;
        for k in 0..places.len() {
            let (place, kept) = places[k];
            if inside[k] {
                let points = open.get_or_insert_with(|| {
                    if k > 0 { vec![self.between(&places[k - 1].0, &place)] } else { Vec::new() }
                });
                if kept {
                    points.push(place);
                }
            } else if let Some(mut points) = open.take() {
                points.push(self.between(&place, &places[k - 1].0));
                found.push((points, false));
            }
        }
        found.extend(open.filter(|points| points.len() > 1).map(|points| (points, false)));
        found
    }

    /// The place between one outside and one inside that is just inside.
    fn between(&self, outside: &SurfacePoint, inside: &SurfacePoint) -> SurfacePoint {
        let (mut low, mut high) = (0.0, 1.0);
        let mut best = *inside;
        // Both lie in the triangle of one of them.
        let at = |share: f64| {
            let position = outside.position + (inside.position - outside.position) * share;
            let mesh = self.field.distance().mesh();
            let [one, other] = [outside, inside].map(|p| {
                let (near, barycentric) = on_mesh_triangle(mesh, p.triangle, position);
                ((near - position).norm_squared(), SurfacePoint { triangle: p.triangle, barycentric, position: near })
            });
            if other.0 < one.0 { other.1 } else { one.1 }
        };
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let place = at(middle);
            if self.is_inside(&place) {
                (high, best) = (middle, place);
            } else {
                low = middle;
            }
        }
        best
    }
}
