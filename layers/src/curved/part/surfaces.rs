//! The surfaces of a part's layers, trimmed to its mesh and measured.
//!
//! Dai 2020, sections 3.4.5 and 3.6.3.

use super::error::{LayersError, begin};
use super::layer_surfaces::{LayerBoundary, LayerSurfaces};
use super::support::{PartSupport, SupportCells};
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::support::{SupportError, cell_mesh};
use crate::curved::surface::{
    BorderSmoothing, ExtendedField, FittedLevels, LayerField, Surface, extend, measure_spacing_within,
};
use crate::parallel::in_parallel_watched;
use crate::trim::{BoundaryKind, TrimmedSheet, Trimmer, slices};
use nalgebra::Point3;
use std::collections::HashSet;

/// Edges of the surfaces on the mesh shorter than this share of the layer height are put together. A bead is about as wide as
/// a layer is high, and its curves are drawn to a fiftieth of that.
const BORDER_EDGE: f64 = 0.1;

/// Thickness of a layer at least, as a share of the layer height: a bead of no height cannot be laid.
const MIN_THICKNESS: f64 = 0.02;

impl Workpiece<'_> {
    /// The surfaces of a field, trimmed to the mesh and measured.
    ///
    /// # Arguments
    /// * `field`: of these cells; [`uniform_field`](crate::curved::surface::uniform_field) or a saved one.
    /// * `missed`: cells without a value.
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: called with the stages `contour`, `trim`, `clip` (`crossings`) and `spacing`; may cancel.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// One to three seconds for 100,000 cells.
    pub fn surfaces(
        &self,
        field: &LayerField,
        missed: &[u32],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<LayerSurfaces, LayersError> {
        begin("contour", progress)?;
        let extended = extend(field, &self.cells);
        let levels = extended.fitted_levels(self.vertices, self.triangles, self.cell_mm, self.origin, height_mm)?;
        begin("trim", progress)?;
        let trimmer = Trimmer::new(self.vertices, self.triangles)?;
        self.surfaces_at(&extended, &levels, trimmer.thinned(BORDER_EDGE * height_mm), missed, progress)
    }

    /// The surfaces of a field over part and support: those of the part, and those of its support if it has any.
    ///
    /// # Arguments
    /// * `field`: e.g. a saved one.
    /// * `rows`: the cells of part and support, as [`Cells`] takes them.
    /// * `support`: those that are support; none for a part without. Cells of `rows` that are neither part nor support get no surfaces.
    /// * `missed`: cells of the part without a value.
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: as in [`Workpiece::surfaces`].
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`Workpiece::surfaces`], twice with support.
    pub fn surfaces_and_support(
        &self,
        field: &LayerField,
        rows: &[u64],
        support: SupportCells,
        missed: &[u32],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<(LayerSurfaces, Option<PartSupport>), LayersError> {
        let Workpiece { cell_mm, origin, .. } = *self;
        let cells = Cells::new(self.cells.dims(), rows).map_err(SupportError::from)?;
        begin("contour", progress)?;
        let extended = extend(field, &cells);
        let levels = extended.fitted_levels(self.vertices, self.triangles, cell_mm, origin, height_mm)?;
        let united = Workpiece { cells, ..*self };
        begin("trim", progress)?;
        let min_edge_mm = BORDER_EDGE * height_mm;
        let trimmer = Trimmer::new(self.vertices, self.triangles)?.thinned(min_edge_mm);
        let surfaces = united.surfaces_at(&extended, &levels, trimmer, missed, progress)?;
        let SupportCells { cells: of_support, contact } = support;
        if of_support.is_empty() && contact.is_empty() {
            return Ok((surfaces, None));
        }
        let mesh = cell_mesh(&cells, &[of_support, contact].concat(), cell_mm, origin);
        let skin = (&mesh.vertices[..], &mesh.triangles[..]);
        let trimmer = match contact {
            [] => Trimmer::new(skin.0, skin.1)?,
            _ => Trimmer::new_outside(skin, (self.vertices, self.triangles))?,
        };
        let made = united.surfaces_at(&extended, &levels, trimmer.thinned(min_edge_mm), &[], progress)?;
        // What is neither part nor support stays empty.
        let is_of_part = |cell: u32| self.cells.contains(self.cells.position(cell));
        let gap = cells.iter().filter(|&cell| !is_of_part(cell) && of_support.binary_search(&cell).is_err()).collect();
        let (rows, cells, contact) = (rows.to_vec(), of_support.to_vec(), contact.to_vec());
        Ok((surfaces, Some(PartSupport { rows, cells, gap, contact, straight_cells: 0, mesh, surfaces: made })))
    }

    /// The surfaces of a field at some levels, trimmed and measured.
    pub(crate) fn surfaces_at(
        &self,
        extended: &ExtendedField,
        FittedLevels { levels, height_mm }: &FittedLevels,
        trimmer: Trimmer,
        missed: &[u32],
        progress: ProgressFn,
    ) -> Result<LayerSurfaces, LayersError> {
        let height_mm = *height_mm;
        begin("contour", progress)?;
        let mut untrimmed = extended.contour_with_half_layers(levels, self.cell_mm, self.origin, progress)?;
        untrimmed.iter_mut().for_each(|(_, surface)| surface.smooth_border(self.cell_mm, BorderSmoothing::default()));
        begin("trim", progress)?;
        let (is_half, untrimmed): (Vec<bool>, Vec<Surface>) = untrimmed.into_iter().unzip();
        let trimmed = |k: usize, watch: ProgressFn| trimmer.trim(&untrimmed[k].points, &untrimmed[k].triangles, watch);
        let trimmed = in_parallel_watched(untrimmed.len(), "trim", progress, trimmed).ok_or(LayersError::Cancelled)?;
        let layer_mm = extended.layer_cells() * self.cell_mm;
        let heights_mm = untrimmed.iter().map(|surface| surface.value * layer_mm).collect();
        drop(untrimmed);
        let mut sheets = trimmed.into_iter().collect::<Result<Vec<TrimmedSheet>, _>>()?;
        begin("clip", progress)?;
        let clipped = trimmer.clip(&mut sheets, height_mm, progress)?;
        let missed_mm3 = self.volume_in(missed, &trimmer, progress)?;
        begin("spacing", progress)?;
        let spacing = measure_spacing_within(&slices(&sheets), &trimmer, height_mm, progress)?;
        let min = MIN_THICKNESS * height_mm;
        let thickness =
            |(sheet, raw): (&TrimmedSheet, &Vec<f64>)| uniform_thickness(&sheet.vertices, &sheet.triangles, raw, min);
        let thickness_mm = sheets.iter().zip(&spacing.thickness_mm).map(thickness).collect();
        let boundary = self.boundary(&sheets, missed);
        Ok(LayerSurfaces {
            height_mm,
            sheets,
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
