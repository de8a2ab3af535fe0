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
use super::trimmed::TrimmedSheet;
use crate::ProgressFn;
use crate::boxes::{Bounds, Tree};
use crate::parallel::in_parallel_watched;
use nalgebra::Point3;
use std::collections::BTreeMap;

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
    Ok(counted(&AllTriangles::checked(surfaces)?.crossings(|_| true, |_| true, progress)?))
}

/// The edges of a surface; none of one that is not counted.
#[derive(Default)]
pub(super) struct SurfaceEdges {
    count: usize,
    /// Those that pass through a triangle of another surface.
    crossing: Vec<[u32; 2]>,
}

/// How many there are on all surfaces.
pub(super) fn counted(surfaces: &[SurfaceEdges]) -> SurfaceCrossings {
    SurfaceCrossings {
        edges: surfaces.iter().map(|edges| edges.count).sum(),
        crossing: surfaces.iter().map(|edges| edges.crossing.len()).sum(),
    }
}

/// The triangles of all surfaces in one tree.
pub(crate) struct AllTriangles<'a> {
    surfaces: &'a [SurfaceSlices<'a>],
    /// Surface and triangle, by the numbers that the tree has.
    places: Vec<[u32; 2]>,
    /// For each surface whether each vertex lies on its border, and each edge of each triangle.
    borders: Vec<Border>,
    tree: Tree,
}

impl<'a> AllTriangles<'a> {
    /// Of all triangles.
    pub(crate) fn checked(surfaces: &'a [SurfaceSlices<'a>]) -> Result<Self, TrimError> {
        surfaces.iter().try_for_each(|(points, triangles)| check(Input::Sheet, points, triangles))?;
        AllTriangles::of(surfaces, |_| true)
    }

    /// Of the triangles of some surfaces, which have been checked.
    fn of(surfaces: &'a [SurfaceSlices<'a>], has: impl Fn(usize) -> bool) -> Result<Self, TrimError> {
        let of_some = || surfaces.iter().enumerate().filter(|&(surface, _)| has(surface));
        let count: usize = of_some().map(|(_, (_, triangles))| triangles.len()).sum();
        if count > MAX_ITEMS {
            return Err(TrimError::TooMany { input: Input::Sheet, most: MAX_ITEMS });
        }
        let mut places = Vec::with_capacity(count);
        let mut boxes = Vec::with_capacity(count);
        let mut borders: Vec<Border> = surfaces.iter().map(|_| Border::default()).collect();
        for (surface, (points, triangles)) in of_some() {
            borders[surface] = Border::of(points.len(), triangles);
            for (triangle, corners) in (0..).zip(*triangles) {
                places.push([surface as u32, triangle]);
                boxes.push(Bounds::of(corners.map(|corner| &points[corner as usize])));
            }
        }
        Ok(AllTriangles { surfaces, places, borders, tree: Tree::new(boxes) })
    }

    pub(super) fn corners(&self, [surface, triangle]: [u32; 2]) -> [&'a Point3<f64>; 3] {
        let (points, triangles) = self.surfaces[surface as usize];
        triangles[triangle as usize].map(|corner| &points[corner as usize])
    }

    /// Triangles of a surface.
    pub(super) fn count(&self, surface: usize) -> u32 {
        self.surfaces[surface].1.len() as u32
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

    /// The edges of each surface that is counted; those of a surface that may not cross another cross none. By edges, not by triangles, so that each
    /// counts once.
    pub(super) fn crossings(
        &self,
        is_counted: impl Fn(usize) -> bool + Send + Sync,
        may_cross: impl Fn(usize) -> bool + Send + Sync,
        progress: ProgressFn,
    ) -> Result<Vec<SurfaceEdges>, TrimError> {
        let of_surface = |surface: usize, _: ProgressFn| {
            if !is_counted(surface) {
                return SurfaceEdges::default();
            }
            if !may_cross(surface) {
                return SurfaceEdges { count: self.borders[surface].edges, crossing: Vec::new() };
            }
            let (points, triangles) = self.surfaces[surface];
            let edges = Edges::new(triangles).ends;
            let crosses =
                |ends: &&[u32; 2]| self.is_crossed(surface as u32, ends.map(|end| &points[end as usize]), |_| true);
            SurfaceEdges { count: edges.len(), crossing: edges.iter().filter(crosses).copied().collect() }
        };
        in_parallel_watched(self.surfaces.len(), "crossings", progress, of_surface).ok_or(TrimError::Cancelled)
    }

    /// The edges of each surface when some surfaces have been replaced. An edge of a surface that stays, and that passed through nothing before,
    /// passes through no other surface that stays: it is compared with the replacements alone.
    pub(super) fn crossings_with(
        &self,
        changed: &BTreeMap<usize, TrimmedSheet>,
        before: &[SurfaceEdges],
        is_counted: impl Fn(usize) -> bool + Send + Sync,
        progress: ProgressFn,
    ) -> Result<Vec<SurfaceEdges>, TrimError> {
        changed.values().try_for_each(|sheet| check(Input::Sheet, &sheet.vertices, &sheet.triangles))?;
        let surface = |(k, old): (usize, &SurfaceSlices<'a>)| changed.get(&k).map_or(*old, TrimmedSheet::slices);
        let surfaces: Vec<SurfaceSlices> = self.surfaces.iter().enumerate().map(surface).collect();
        let new = AllTriangles::of(&surfaces, |surface| changed.contains_key(&surface))?;
        let of_surface = |surface: usize, _: ProgressFn| {
            if !is_counted(surface) {
                return SurfaceEdges::default();
            }
            let (points, triangles) = surfaces[surface];
            let edge = |ends: &[u32; 2]| ends.map(|end| &points[end as usize]);
            let stays = |other: u32| !changed.contains_key(&(other as usize));
            let by_new = |ends: &&[u32; 2]| new.is_crossed(surface as u32, edge(ends), |_| true);
            let by_old = |ends: &&[u32; 2]| self.is_crossed(surface as u32, edge(ends), stays);
            if changed.contains_key(&surface) {
                let edges = Edges::new(triangles).ends;
                let crossing = edges.iter().filter(|ends| by_new(ends) || by_old(ends)).copied().collect();
                return SurfaceEdges { count: edges.len(), crossing };
            }
            let SurfaceEdges { count, crossing } = &before[surface];
            let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
            let is_near = |ends: &[u32; 2]| Bounds::of(edge(ends)).meets(new.tree.bounds());
            let mut near: Vec<[u32; 2]> = triangles.iter().flat_map(sides).filter(is_near).collect();
            near.sort_unstable();
            near.dedup();
            let crossing = near.iter().filter(by_new).chain(crossing.iter().filter(by_old));
            let mut crossing: Vec<[u32; 2]> = crossing.copied().collect();
            crossing.sort_unstable();
            crossing.dedup();
            SurfaceEdges { count: *count, crossing }
        };
        in_parallel_watched(surfaces.len(), "crossings", progress, of_surface).ok_or(TrimError::Cancelled)
    }

    /// Whether an edge passes through a triangle of another surface, of those that count.
    fn is_crossed(&self, own: u32, edge: [&Point3<f64>; 2], counts: impl Fn(u32) -> bool) -> bool {
        let mut found = false;
        self.near(edge, |place| {
            found |= place[0] != own && !found && counts(place[0]) && self.passes(own, edge, place);
        });
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
#[derive(Default)]
struct Border {
    vertices: Vec<bool>,
    sides: Vec<[bool; 3]>,
    /// Edges of the surface, those inside as well.
    edges: usize,
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
        let sides = edges.sides.iter().map(|sides| sides.map(|edge| runs[edge as usize] == 1)).collect();
        Border { vertices, sides, edges: edges.ends.len() }
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

#[cfg(test)]
mod tests {
    use super::super::trimmed::slices;
    use super::*;
    use proptest::prelude::*;
    use std::ops::ControlFlow;

    fn sheet() -> impl Strategy<Value = TrimmedSheet> {
        let point = prop::array::uniform3(-1.0_f64..1.0);
        let corners = [0_u32..6, 0..6, 0..6].prop_filter("three corners", |[a, b, c]| a != b && b != c && c != a);
        (prop::collection::vec(point, 6), prop::collection::vec(corners, 0..5)).prop_map(|(points, triangles)| {
            TrimmedSheet {
                vertices: points.into_iter().map(Point3::from).collect(),
                triangles,
                ..TrimmedSheet::default()
            }
        })
    }

    proptest! {
        #[test]
        fn what_changes_is_counted_as_if_all_were(
            mut sheets in prop::collection::vec(sheet(), 1..6),
            others in prop::collection::btree_map(0_usize..6, prop_oneof![sheet(), Just(TrimmedSheet::default())], 0..4),
        ) {
            let silent = |_| ControlFlow::Continue(());
            let others: BTreeMap<usize, TrimmedSheet> = others.into_iter().filter(|(k, _)| *k < sheets.len()).collect();
            let surfaces = slices(&sheets);
            let all = AllTriangles::checked(&surfaces).unwrap();
            let before = all.crossings(|_| true, |_| true, &silent).unwrap();
            let found = counted(&all.crossings_with(&others, &before, |_| true, &silent).unwrap());
            others.into_iter().for_each(|(k, other)| sheets[k] = other);
            prop_assert_eq!(found, count_crossings(&slices(&sheets), &silent).unwrap());
        }
    }

    /// Three triangles, of which the first passes through both others; nothing is left of one of them, or of all.
    #[test]
    fn a_sheet_of_which_nothing_is_left_crosses_nothing() {
        let silent = |_| ControlFlow::Continue(());
        let triangle = |corners: [[f64; 3]; 3]| TrimmedSheet {
            vertices: corners.map(Point3::from).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..TrimmedSheet::default()
        };
        let level = |z: f64| triangle([[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]]);
        let sheets = [triangle([[0.0, 0.0, -1.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]]), level(0.0), level(1.0)];
        let surfaces = slices(&sheets);
        let all = AllTriangles::checked(&surfaces).unwrap();
        let before = all.crossings(|_| true, |_| true, &silent).unwrap();
        let left_without = |gone: &[usize]| {
            let changed = gone.iter().map(|&sheet| (sheet, TrimmedSheet::default())).collect();
            let found = counted(&all.crossings_with(&changed, &before, |_| true, &silent).unwrap());
            [found.edges, found.crossing]
        };
        // The two upright edges of the first triangle.
        assert_eq!(left_without(&[]), [9, 2]);
        assert_eq!(left_without(&[1]), [6, 2]);
        assert_eq!(left_without(&[2]), [6, 2]);
        assert_eq!(left_without(&[1, 2]), [3, 0]);
        assert_eq!(left_without(&[0]), [6, 0]);
        assert_eq!(left_without(&[0, 1, 2]), [0, 0]);
    }
}
