//! The surfaces of a part's layers.

use super::best::pieces;
use crate::curved::surface::Spacing;
use crate::trim::{Clipped, SurfaceSlices, TrimmedSheet, slices};
use nalgebra::Point3;
use std::ops::Range;

/// A layer counts as evenly thick where a bead is this many times as thick as the layer height, from and to: what
/// extrusion can make up for.
const EVEN_THICKNESS: [f64; 2] = [0.5, 1.5];

/// The surfaces of a part's layers, first to last.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerSurfaces {
    /// Distance of the surfaces along the growth, in millimetres: the layer height asked for, stretched so that layers fit
    /// ([`ExtendedField::fitted_levels`](crate::curved::surface::ExtendedField::fitted_levels)).
    pub height_mm: f64,
    /// The surfaces, trimmed to the mesh; some may be empty, and those that were not made are.
    pub sheets: Vec<TrimmedSheet>,
    /// Which of them were made: all, unless a range [of the planned ones](crate::curved::PlannedSurfaces::make) was asked for. Figures are of these alone.
    pub made: Range<usize>,
    /// For each of them whether it is a half layer ([`LayerField::with_half_layers`](crate::curved::surface::LayerField::with_half_layers)).
    pub is_half: Vec<bool>,
    /// Height of each of them along the growth, in millimetres.
    pub heights_mm: Vec<f64>,
    /// Where they passed through each other: later ones are clipped to earlier ones, and what is left of that.
    pub clipped: Clipped,
    /// How far apart they lie.
    pub spacing: Spacing,
    /// For each surface, for each triangle: how thick a bead is there, in millimetres. The [thickness of the
    /// layer](Spacing::thickness_mm) as the mean over the triangles around its corners, by area: beads cannot jump where layers
    /// bend. At least a fiftieth of the layer height.
    pub thickness_mm: Vec<Vec<f64>>,
    /// Where they end.
    pub boundary: LayerBoundary,
    /// Volume of the part that lies in missed cells.
    pub missed_mm3: f64,
}

/// Points, triangles and thickness of a surface, and whether it is a half layer.
type SurfaceParts<'a> = (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool);

/// Where the surfaces of a part end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerBoundary {
    /// Greatest distance to the mesh of what ends on it, in millimetres.
    pub error_mm: f64,
    /// Length of the boundary beside missed cells.
    pub at_missed_mm: f64,
    /// Length inside the part, where one side of it had to wait for the other.
    pub at_waits_mm: f64,
    /// Length across holes of the mesh.
    pub at_holes_mm: f64,
}

impl LayerSurfaces {
    /// The surfaces as plain slices.
    pub fn slices(&self) -> Vec<SurfaceSlices<'_>> {
        slices(&self.sheets)
    }

    /// Whether all of them were made.
    pub fn is_whole(&self) -> bool {
        self.made == (0..self.sheets.len())
    }

    /// Points, triangles and thickness of each surface, first to last, and whether it is a half layer: all that planning its tool paths takes.
    pub fn iter(&self) -> impl Iterator<Item = SurfaceParts<'_>> {
        let each = self.sheets.iter().zip(&self.thickness_mm).zip(&self.is_half);
        each.map(|((sheet, thickness), &is_half)| (&sheet.vertices[..], &sheet.triangles[..], &thickness[..], is_half))
    }

    /// Connected pieces of all surfaces together: so many curves it takes at least to fill them. Triangles are connected where
    /// they share a corner.
    pub fn pieces(&self) -> usize {
        self.sheets.iter().map(pieces).sum()
    }

    /// Share of the area of all surfaces where a bead is 0.5 to 1.5 times as thick as the layer height, which extrusion can make up for; 0 without any area.
    ///
    /// # Example
    /// ```
    /// # use curvlay_layers::curved::{LayerBoundary, LayerSurfaces};
    /// # use curvlay_layers::curved::surface::Spacing;
    /// # use curvlay_layers::trim::{Clipped, TrimmedSheet};
    /// # use curvlay_layers::nalgebra::Point3;
    /// // Layers of 0.4 mm; a triangle of 3 mm2 is 0.5 mm thick, one of 1 mm2 is 0.1 mm thick.
    /// let vertices = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [2.0, 1.0, 0.0]].map(Point3::from).to_vec();
    /// let sheet = TrimmedSheet { vertices, triangles: vec![[0, 1, 2], [1, 3, 2]], ..TrimmedSheet::default() };
    /// let mut surfaces = LayerSurfaces {
    ///     height_mm: 0.4,
    ///     sheets: vec![sheet],
    ///     made: 0..1,
    ///     is_half: vec![false],
    ///     heights_mm: vec![0.2],
    ///     thickness_mm: vec![vec![0.5, 0.1]],
    /// #   clipped: Clipped::default(), spacing: Spacing::default(), boundary: LayerBoundary::default(), missed_mm3: 0.0,
    ///     // and what else there is
    /// };
    /// assert_eq!(surfaces.thickness_share(), 0.75);
    /// surfaces.thickness_mm = vec![vec![0.7, 0.5]];
    /// assert_eq!(surfaces.thickness_share(), 0.25);
    /// ```
    pub fn thickness_share(&self) -> f64 {
        let even = EVEN_THICKNESS.map(|times| times * self.height_mm);
        let (mut area_mm2, mut even_mm2) = (0.0, 0.0);
        for (vertices, triangles, thickness, _) in self.iter() {
            for (corners, thickness) in triangles.iter().zip(thickness) {
                let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
                let area = (b - a).cross(&(c - a)).norm() / 2.0;
                area_mm2 += area;
                even_mm2 += if (even[0]..=even[1]).contains(thickness) { area } else { 0.0 };
            }
        }
        if area_mm2 > 0.0 { even_mm2 / area_mm2 } else { 0.0 }
    }

    /// Volume that the layers leave bare or cover twice, missed cells included, of a part of this volume.
    pub fn lost_mm3(&self, volume_mm3: f64) -> f64 {
        self.missed_mm3 + (volume_mm3 - self.missed_mm3 - self.spacing.volume_mm3).abs()
    }
}
