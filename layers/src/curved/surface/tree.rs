//! The triangles of many surfaces in a tree, for short lines across them.

use super::spacing::SurfaceSlices;
use crate::curved::boxes::{self, Bounds};
use nalgebra::{Point3, Vector3};

/// How far beyond its edge a triangle still counts, as a share of the triangle: a line through an edge that two
/// triangles share meets at least one of them.
const OVERLAP: f64 = 1e-9;

/// The triangles of all surfaces, leaf after leaf of the boxes over them.
pub(super) struct Tree {
    boxes: boxes::Tree,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy)]
struct Triangle {
    corner: Point3<f64>,
    sides: [Vector3<f64>; 2],
    surface: u32,
}

/// What a line met. Distances are not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hits {
    /// Distance along the line to the next surface.
    pub(super) above: Option<f64>,
    /// Distance against it to the surface before.
    pub(super) below: Option<f64>,
    /// Whether another surface than the line's own is near.
    pub(super) near: bool,
}

impl Tree {
    /// All triangles must name points that are there.
    pub(super) fn new(surfaces: &[SurfaceSlices]) -> Self {
        let mut triangles = Vec::new();
        for (surface, (points, of_surface)) in (0..).zip(surfaces) {
            triangles.extend(of_surface.iter().map(|t| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                Triangle { corner: a, sides: [b - a, c - a], surface }
            }));
        }
        let bounds: Vec<Bounds> = triangles.iter().map(|triangle| Bounds::of(&triangle.corners())).collect();
        let boxes = boxes::Tree::new(&bounds);
        // A line meets what lies near it: so it is stored near it.
        let triangles = boxes.order().iter().map(|&triangle| triangles[triangle as usize]).collect();
        Tree { boxes, triangles }
    }

    /// Follows a line both ways from `start`, a point of the surface `own`, and looks for the surfaces before and after
    /// it within `reach`, below and above, where their normals go along the line; and for any other surface within
    /// `near`. `normal` is the way of the line, one long.
    pub(super) fn cast(&self, start: Point3<f64>, normal: &Vector3<f64>, own: u32, reach: [f64; 2], near: f64) -> Hits {
        let mut hits = Hits::default();
        self.boxes.along(&start, normal, reach.map(|reach| reach.max(near)), |place, left| {
            let triangle = &self.triangles[place];
            if triangle.surface == own {
                return;
            }
            let Some(along) = triangle.place_along(&start, normal) else { return };
            let distance = along.abs();
            hits.near |= distance < near;
            let faces = || triangle.sides[0].cross(&triangle.sides[1]).dot(normal) > 0.0;
            if triangle.surface == own + 1 && along >= 0.0 {
                if distance < hits.above.unwrap_or(reach[1]) && faces() {
                    hits.above = Some(distance);
                    left[1] = distance.max(near);
                }
            } else if triangle.surface + 1 == own
                && along <= 0.0
                && distance < hits.below.unwrap_or(reach[0])
                && faces()
            {
                hits.below = Some(distance);
                left[0] = distance.max(near);
            }
        });
        hits
    }
}

impl Triangle {
    fn corners(&self) -> [Point3<f64>; 3] {
        [self.corner, self.corner + self.sides[0], self.corner + self.sides[1]]
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
