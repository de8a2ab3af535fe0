//! Where surfaces pass through each other.
//!
//! An edge of one surface and a triangle of another *cross* if the ends of the edge lie on both sides of the triangle, and its line
//! inside of the three sides. Both are decided exactly on the given coordinates; the later of the two surfaces counts as
//! lifted by an infinitely small step (`predicates`), so that there is no touching. Where the edge or the surface of the triangle
//! ends, within [`MIN_ALTITUDE_MM`], they meet and do not cross: coordinates of cuts are rounded, so half of what clipping lets end at
//! another surface would cross it by rounding alone. Which pairs are looked at is decided by a tree of boxes over all triangles.

use super::SurfaceSlices;
use super::crossing::{pierce, through};
use super::edges::Edges;
use super::error::{Input, MAX_ITEMS, TrimError, check};
use super::exact::height;
use super::predicates::{Moves, passing, side};
use super::triangle::MIN_ALTITUDE_MM;
use crate::ProgressFn;
use crate::boxes::{Bounds, Tree};
use crate::parallel::in_parallel_watched;
use nalgebra::Point3;

/// How often surfaces pass through each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceCrossings {
    /// Edges of all surfaces, each counted once.
    pub edges: usize,
    /// Those that pass through a triangle of another surface, farther than [`MIN_ALTITUDE_MM`] from the ends of both.
    pub crossing: usize,
}

/// Counts the edges that pass through a triangle of another surface.
///
/// # Arguments
/// * `surfaces`: points in millimetres and triangles of each. What a surface does to itself does not count.
/// * `progress`: called with the stage `crossings` after each surface; may cancel.
///
/// # Errors
/// [`TrimError::BadCorner`], [`TrimError::BadCoordinate`], [`TrimError::TooMany`], [`TrimError::Cancelled`].
///
/// # Cost
/// `O(n log n)` for `n` triangles of surfaces that lie side by side, about two microseconds each. With the feature `rayon` surfaces are
/// shared out among threads; the result is the same.
///
/// # Example
/// ```
/// use curvlay_layers::trim::count_crossings;
/// use curvlay_layers::nalgebra::Point3;
/// use std::ops::ControlFlow;
/// let level = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]].map(Point3::from);
/// let leaning = [[1.0, 1.0, 0.5], [6.0, 1.0, 3.0], [1.0, 6.0, 3.0]].map(Point3::from);
/// let surfaces = [(&level[..], &[[0, 1, 2]][..]), (&leaning[..], &[[0, 1, 2]][..])];
/// let found = count_crossings(&surfaces, &|_| ControlFlow::Continue(()))?;
/// assert_eq!((found.edges, found.crossing), (6, 2)); // two edges go up from its lowest corner
/// # Ok::<(), curvlay_layers::trim::TrimError>(())
/// ```
pub fn count_crossings(surfaces: &[SurfaceSlices], progress: ProgressFn) -> Result<SurfaceCrossings, TrimError> {
    surfaces.iter().try_for_each(|(points, triangles)| check(Input::Sheet, points, triangles))?;
    let all = AllTriangles::new(surfaces)?;
    let of_surface = |surface: usize, _: ProgressFn| {
        let (points, triangles) = surfaces[surface];
        let edges = Edges::new(triangles);
        // By edges, not by triangles, so that each counts once.
        let crosses = |ends: &&[u32; 2]| all.is_crossed(surface as u32, ends.map(|end| &points[end as usize]));
        SurfaceCrossings { edges: edges.ends.len(), crossing: edges.ends.iter().filter(crosses).count() }
    };
    let found = in_parallel_watched(surfaces.len(), "crossings", progress, of_surface).ok_or(TrimError::Cancelled)?;
    let sum = |of: fn(&SurfaceCrossings) -> usize| found.iter().map(of).sum();
    Ok(SurfaceCrossings { edges: sum(|found| found.edges), crossing: sum(|found| found.crossing) })
}

/// The triangles of all surfaces in one tree.
pub(super) struct AllTriangles<'a> {
    surfaces: &'a [SurfaceSlices<'a>],
    /// Surface and triangle, by the numbers that the tree has.
    places: Vec<[u32; 2]>,
    /// For each surface whether each vertex lies on its border, and each edge of each triangle.
    borders: Vec<Border>,
    tree: Tree,
}

impl<'a> AllTriangles<'a> {
    /// Of surfaces that have been checked.
    pub(super) fn new(surfaces: &'a [SurfaceSlices<'a>]) -> Result<Self, TrimError> {
        let count: usize = surfaces.iter().map(|(_, triangles)| triangles.len()).sum();
        if count > MAX_ITEMS {
            return Err(TrimError::TooMany { input: Input::Sheet, most: MAX_ITEMS });
        }
        let mut places = Vec::with_capacity(count);
        let mut boxes = Vec::with_capacity(count);
        let borders = surfaces.iter().map(|(points, triangles)| Border::of(points.len(), triangles)).collect();
        for (surface, (points, triangles)) in (0..).zip(surfaces) {
            for (triangle, corners) in (0..).zip(*triangles) {
                places.push([surface, triangle]);
                boxes.push(Bounds::of(corners.map(|corner| &points[corner as usize])));
            }
        }
        Ok(AllTriangles { surfaces, places, borders, tree: Tree::new(&boxes) })
    }

    pub(super) fn corners(&self, [surface, triangle]: [u32; 2]) -> [&'a Point3<f64>; 3] {
        let (points, triangles) = self.surfaces[surface as usize];
        triangles[triangle as usize].map(|corner| &points[corner as usize])
    }

    /// Hands over surface and triangle of all whose box meets that of the points.
    pub(super) fn near<'p>(&self, points: impl IntoIterator<Item = &'p Point3<f64>>, mut take: impl FnMut([u32; 2])) {
        self.tree.meeting(&Bounds::of(points), |at| take(self.places[at as usize]));
    }

    /// Hands over surface and triangle of those in the leaves that a line comes through within reach ahead.
    pub(super) fn ahead(
        &self,
        from: &Point3<f64>,
        way: &nalgebra::Vector3<f64>,
        reach: f64,
        mut take: impl FnMut([u32; 2]),
    ) {
        let order = self.tree.order();
        self.tree.along(from, way, [0.0, reach], |place, _| take(self.places[order[place] as usize]));
    }

    fn is_crossed(&self, own: u32, edge: [&Point3<f64>; 2]) -> bool {
        let mut found = false;
        self.near(edge, |place| found |= place[0] != own && !found && self.passes(own, edge, place));
        found
    }

    /// Whether an edge passes through a triangle, and neither ends there.
    fn passes(&self, own: u32, edge: [&Point3<f64>; 2], place: [u32; 2]) -> bool {
        let triangle = self.corners(place);
        let [a, b, c] = triangle;
        let area = (b - a).cross(&(c - a)).norm();
        let moves = if own > place[0] { Moves::Point } else { Moves::Triangle };
        crosses(edge, triangle, moves)
            && edge.iter().all(|p| height(triangle, p).abs() > MIN_ALTITUDE_MM * area)
            && !self.is_at_border(&pierce(edge[0], edge[1], triangle).1, place)
    }

    /// Whether a place in a triangle is one of the border of its surface.
    fn is_at_border(&self, at: &Point3<f64>, [surface, triangle]: [u32; 2]) -> bool {
        let corners = self.corners([surface, triangle]);
        let border = &self.borders[surface as usize];
        let numbers = self.surfaces[surface as usize].1[triangle as usize];
        (0..3).any(|k| {
            let (from, side) = (corners[k], corners[(k + 1) % 3] - corners[k]);
            let beside = side.cross(&(at - from)).norm() <= MIN_ALTITUDE_MM * side.norm();
            (beside && border.sides[triangle as usize][k])
                || (border.vertices[numbers[k] as usize] && (at - from).norm() <= MIN_ALTITUDE_MM)
        })
    }
}

/// What of a surface lies on its border.
struct Border {
    vertices: Vec<bool>,
    sides: Vec<[bool; 3]>,
}

impl Border {
    fn of(points: usize, triangles: &[[u32; 3]]) -> Border {
        let edges = Edges::new(triangles);
        let mut runs = vec![0_u32; edges.ends.len()];
        edges.sides.iter().flatten().for_each(|&edge| runs[edge as usize] += 1);
        let mut vertices = vec![false; points];
        for (ends, _) in edges.ends.iter().zip(&runs).filter(|(_, runs)| **runs == 1) {
            ends.iter().for_each(|&end| vertices[end as usize] = true);
        }
        Border { vertices, sides: edges.sides.iter().map(|sides| sides.map(|edge| runs[edge as usize] == 1)).collect() }
    }
}

/// Whether an edge passes through a triangle; one of them moves.
pub(super) fn crosses(edge: [&Point3<f64>; 2], triangle: [&Point3<f64>; 3], moves: Moves) -> bool {
    let ends = edge.map(|p| side(triangle, p, moves));
    ends[0] * ends[1] < 0
        && through([0, 1, 2].map(|k| {
            let of_triangle = [triangle[k], triangle[(k + 1) % 3]];
            match moves {
                Moves::Point => passing(edge, of_triangle),
                Moves::Triangle => passing(of_triangle, edge),
            }
        }))
}
