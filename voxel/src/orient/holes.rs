//! What closes a mesh that is open: how large its mouths are, and how much volume depends on how they are closed.

use crate::boundary::{Cap, caps, open_edges};
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;

/// A mouth counts from this share of the surface that its cap would have without cancelling: seams, where triangles meet without
/// sharing corners, have rims that run there and back.
const SEAM: f64 = 1e-6;

/// The holes of a mesh, in its own unit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Holes {
    pub(super) count: usize,
    pub(super) area: f64,
    /// Half a ball over each mouth: what a cap may add or take away.
    pub(super) volume: f64,
}

impl Holes {
    /// Of oriented triangles; `welded` has for each vertex the first at its place. Triangles of sheets are left out.
    pub(super) fn of(
        places: &[Point3<f64>],
        welded: &[u32],
        triangles: impl Iterator<Item = [u32; 3]> + Clone,
    ) -> Self {
        let mut holes = Holes::default();
        for cap in caps(places, &open_edges(welded, triangles)) {
            let area = mouth(places, &cap);
            if area > SEAM * cap.area {
                holes.count += 1;
                holes.area += area;
                // Of a round mouth that is half a ball: two thirds of its area times its radius.
                holes.volume += 2.0 / 3.0 * area * cap.radius;
            }
        }
        holes
    }
}

/// Surfaces without volume that close nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Sheets {
    pub(super) count: usize,
    pub(super) area: f64,
    is_sheet: Vec<bool>,
}

impl Sheets {
    /// Which of the open bodies without volume are sheets: a patch that closes a seam of another surface is not one.
    /// `areas` are twice those of the triangles.
    pub(super) fn of(
        open: &[Vec<u32>],
        places: &[Point3<f64>],
        welded: &[u32],
        triangles: &[[u32; 3]],
        areas: &[f64],
    ) -> Self {
        let mut sheets = Sheets { is_sheet: vec![false; triangles.len()], ..Sheets::default() };
        if open.is_empty() {
            return sheets;
        }
        let corners: HashSet<u32> = caps(places, &open_edges(welded, triangles.iter().copied()))
            .iter()
            .filter(|cap| mouth(places, cap) > SEAM * cap.area)
            .flat_map(|cap| cap.edges.iter().flatten().copied())
            .collect();
        for body in open {
            let ends = |&triangle: &u32| triangles[triangle as usize].map(|corner| welded[corner as usize]);
            if body.iter().flat_map(ends).any(|corner| corners.contains(&corner)) {
                sheets.count += 1;
                sheets.area += body.iter().map(|&triangle| areas[triangle as usize] / 2.0).sum::<f64>();
                body.iter().for_each(|&triangle| sheets.is_sheet[triangle as usize] = true);
            }
        }
        sheets
    }

    /// The triangles that are in no sheet.
    pub(super) fn others<'a>(&'a self, triangles: &'a [[u32; 3]]) -> impl Iterator<Item = [u32; 3]> + Clone + 'a {
        triangles.iter().zip(&self.is_sheet).filter(|&(_, &is_sheet)| !is_sheet).map(|(&triangle, _)| triangle)
    }
}

/// The area of a mouth, what its rim runs through there and back not counted.
fn mouth(places: &[Point3<f64>], cap: &Cap) -> f64 {
    let side = |vertex: u32| places[vertex as usize] - cap.apex;
    cap.edges.iter().map(|&[a, b]| side(a).cross(&side(b)) / 2.0).sum::<Vector3<f64>>().norm()
}
