//! The surfaces of a part's layers, trimmed to its mesh and measured.
//!
//! Dai 2020, sections 3.4.5 and 3.6.3.

use super::error::{LayersError, begin};
use super::layer_surfaces::{LayerBoundary, LayerSurfaces};
use super::sheets::SheetMaker;
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::curved::surface::measure_spacing_in;
use crate::trim::{BoundaryKind, TrimmedSheet, slices};
use nalgebra::Point3;
use std::collections::HashSet;
use std::ops::Range;

/// Thickness of a layer at least, as a share of the layer height: a bead of no height cannot be laid.
const MIN_THICKNESS: f64 = 0.02;

impl Workpiece<'_> {
    /// The surfaces of a range, trimmed by what `sheets` trims with, and measured.
    pub(super) fn measured(
        &self,
        sheets: &SheetMaker,
        made: Range<usize>,
        missed: &[u32],
        progress: ProgressFn,
    ) -> Result<LayerSurfaces, LayersError> {
        let &SheetMaker { extended, levels, height_mm, trimmer, .. } = sheets;
        let (mut sheets, clipped) = sheets.make(made.clone(), progress)?;
        let missed_mm3 = self.volume_in(missed, trimmer, progress)?;
        begin("spacing", progress)?;
        let spacing = measure_spacing_in(&slices(&sheets), made.clone(), trimmer, height_mm, progress)?;
        let others = sheets.iter_mut().enumerate().filter(|(sheet, _)| !made.contains(sheet));
        others.for_each(|(_, sheet)| *sheet = TrimmedSheet::default());
        let min = MIN_THICKNESS * height_mm;
        let thickness =
            |(sheet, raw): (&TrimmedSheet, &Vec<f64>)| uniform_thickness(&sheet.vertices, &sheet.triangles, raw, min);
        let thickness_mm = sheets.iter().zip(&spacing.thickness_mm).map(thickness).collect();
        let boundary = self.boundary(&sheets, missed);
        let layer_mm = extended.layer_cells() * self.cell_mm;
        let heights_mm = levels.values.iter().map(|level| level * layer_mm).collect();
        let is_half = levels.is_half.clone();
        Ok(LayerSurfaces {
            height_mm,
            sheets,
            made,
            is_half,
            heights_mm,
            clipped,
            spacing,
            thickness_mm,
            boundary,
            missed_mm3,
        })
    }

    /// Adds up where sheets end.
    fn boundary(&self, sheets: &[TrimmedSheet], missed: &[u32]) -> LayerBoundary {
        let missed: HashSet<[i64; 3]> = missed.iter().map(|&cell| self.cells.position(cell).map(i64::from)).collect();
        let next_to_missed = |p: Point3<f64>| {
            let place = (p - self.origin) / self.cell_mm;
            let around = |d: f64| [0, 1, 2].map(|axis| (place[axis] + d).floor() as i64);
            let (low, high) = (around(-1.0), around(1.0));
            !missed.is_empty()
                && (low[0]..=high[0])
                    .any(|x| (low[1]..=high[1]).any(|y| (low[2]..=high[2]).any(|z| missed.contains(&[x, y, z]))))
        };
        let mut boundary = LayerBoundary::default();
        for sheet in sheets {
            boundary.error_mm = boundary.error_mm.max(sheet.error_mm);
            boundary.at_holes_mm += sheet.hole_mm;
            for edge in sheet.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Border) {
                let [a, b] = edge.ends.map(|end| sheet.vertices[end as usize]);
                let length = (b - a).norm();
                if next_to_missed(nalgebra::center(&a, &b)) {
                    boundary.at_missed_mm += length;
                } else {
                    boundary.at_waits_mm += length;
                }
            }
        }
        boundary
    }
}

/// The thickness of each triangle as the mean over those around its corners, by area, and at least `min`.
///
/// Where layers bend, rays from neighbouring triangles end up to twice as far away ([`Spacing::thickness_mm`]); beads cannot
/// jump like that.
fn uniform_thickness(vertices: &[Point3<f64>], triangles: &[[u32; 3]], thickness: &[f64], min: f64) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; vertices.len()];
    for (corners, thickness) in triangles.iter().zip(thickness) {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        for &corner in corners {
            let [volume, around] = &mut sums[corner as usize];
            *volume += area * thickness;
            *around += area;
        }
    }
    let mean = |corner: u32, own: f64| {
        let [volume, around] = sums[corner as usize];
        if around > 0.0 { volume / around } else { own }
    };
    let each = triangles.iter().zip(thickness);
    each.map(|(corners, &own)| (corners.iter().map(|&corner| mean(corner, own)).sum::<f64>() / 3.0).max(min)).collect()
}
