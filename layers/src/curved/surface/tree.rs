//! The triangles of many surfaces in a tree, for short lines across them.

use crate::boxes::{self, Bounds, Line, ROOM};
use crate::trim::SurfaceSlices;
use nalgebra::{Point3, Vector3};

/// How far beyond its edge a triangle still counts, as a share of the triangle: a line through an edge that two
/// triangles share meets at least one of them.
const OVERLAP: f64 = 1e-9;

/// The triangles of all surfaces, leaf after leaf of the boxes over them.
pub(super) struct Tree<'a> {
    boxes: boxes::Tree,
    /// The surface of each, and its corners there: of ten million cells there are 25 million triangles, so their places are looked up.
    triangles: Vec<(u32, [u32; 3])>,
    surfaces: &'a [SurfaceSlices<'a>],
}

struct Triangle {
    corner: Point3<f64>,
    sides: [Vector3<f64>; 2],
}

/// What a line met, first on the side before the surface, then on the side after it. Distances are not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hits {
    /// Distances to the surface before and to the one after.
    pub(super) neighbours: [Option<f64>; 2],
    /// Distances to the nearest of all surfaces before, and of all after.
    pub(super) nearest: [Option<f64>; 2],
    /// Whether another surface than the line's own is near, whichever way it faces.
    pub(super) near: bool,
}

impl<'a> Tree<'a> {
    /// All triangles must name points that are there.
    pub(super) fn new(surfaces: &'a [SurfaceSlices<'a>]) -> Self {
        let mut triangles = Vec::with_capacity(surfaces.iter().map(|(_, of_surface)| of_surface.len()).sum());
        for (surface, (_, of_surface)) in (0..).zip(surfaces) {
            triangles.extend(of_surface.iter().map(|&corners| (surface, corners)));
        }
        let bounds: Vec<Bounds> = triangles.iter().map(|t| Bounds::of(&Triangle::of(surfaces, t).corners())).collect();
        let boxes = boxes::Tree::for_lines(&bounds);
        drop(bounds);
        let triangles = boxes.order().iter().map(|&number| triangles[number as usize]).collect();
        Tree { boxes, triangles, surfaces }
    }

    /// Follows a line both ways from `start`, a point of the surface `own`, and looks against it for surfaces before and along
    /// it for surfaces after, where their normals go along the line: no farther than `reach`, nor than the neighbour
    /// there; and for any other surface within `near`. `normal` is the way of the line, one long.
    ///
    /// A triangle is met in its own box alone: of one without height rounding would make a place far away, and whether that is found would depend on what else is in the
    /// tree. So hits depend on nothing but the triangles near the line.
    pub(super) fn cast(&self, start: Point3<f64>, normal: &Vector3<f64>, own: u32, reach: [f64; 2], near: f64) -> Hits {
        let mut hits = Hits::default();
        let line = Line::new(&start, normal);
        self.boxes.along(&start, normal, reach.map(|reach| reach.max(near)), |place, left| {
            let at @ &(surface, _) = &self.triangles[place];
            if surface == own {
                return;
            }
            let triangle = Triangle::of(self.surfaces, at);
            let Some(along) = triangle.place_along(&start, normal).filter(|along| triangle.is_met(&line, *along))
            else {
                return;
            };
            let distance = along.abs();
            hits.near |= distance < near;
            let side = usize::from(surface > own);
            let ahead = if side == 1 { along } else { -along };
            if ahead >= 0.0
                && distance < hits.neighbours[side].unwrap_or(reach[side])
                && triangle.sides[0].cross(&triangle.sides[1]).dot(normal) > 0.0
            {
                hits.nearest[side] = Some(hits.nearest[side].map_or(distance, |nearest| nearest.min(distance)));
                if surface.abs_diff(own) == 1 {
                    hits.neighbours[side] = Some(distance);
                    left[side] = distance.max(near);
                }
            }
        });
        hits
    }
}

impl Triangle {
    fn of(surfaces: &[SurfaceSlices], (surface, corners): &(u32, [u32; 3])) -> Self {
        let points = surfaces[*surface as usize].0;
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        Triangle { corner: a, sides: [b - a, c - a] }
    }

    fn corners(&self) -> [Point3<f64>; 3] {
        [self.corner, self.corner + self.sides[0], self.corner + self.sides[1]]
    }

    /// Whether a place on a line is in its box.
    fn is_met(&self, line: &Line, along: f64) -> bool {
        let bounds = Bounds::of(&self.corners());
        let [enter, leave] = bounds.passage(line, [f64::NEG_INFINITY, f64::INFINITY], ROOM * bounds.size());
        (enter..=leave).contains(&along)
    }

    /// Where on the line the triangle is met (Moller and Trumbore 1997); less than 0 before its start.
    fn place_along(&self, start: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let [e1, e2] = &self.sides;
        let across = direction.cross(e2);
        let det = e1.dot(&across);
        let from = start - self.corner;
        let u = from.dot(&across) / det;
        // Where the line runs along the triangle, this is not a number or without end.
        if !(-OVERLAP..=1.0 + 2.0 * OVERLAP).contains(&u) {
            return None;
        }
        let turned = from.cross(e1);
        let v = direction.dot(&turned) / det;
        (v >= -OVERLAP && u + v <= 1.0 + OVERLAP).then(|| e2.dot(&turned) / det)
    }
}
