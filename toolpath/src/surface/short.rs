//! Curves that are too short to be worth a start: how many there are.
//!
//! Each curve costs a transfer and a start. Of one that is only a few beads long little is left but the start.

use super::fill::FilledLayers;

/// Curves shorter than this many widths of a bead count as short.
pub const SHORT_CURVE_BEADS: f64 = 5.0;

impl FilledLayers {
    /// Counts the curves that are shorter than a length in millimetres. `O(n)` for `n` points.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::surface::{LayerSurface, PathOptions, SHORT_CURVE_BEADS, fill_layers};
    /// use std::ops::ControlFlow;
    /// // A layer of two parts: 8 x 8 mm, and a strip of 0.9 x 3 mm, which takes one short bead.
    /// let part = |x: f64, [wide, long]: [f64; 2]| [[x, 0.0], [x + wide, 0.0], [x + wide, long], [x, long]];
    /// let vertices = [part(0.0, [8.0, 8.0]), part(10.0, [0.9, 3.0])].concat();
    /// let vertices: Vec<_> = vertices.into_iter().map(|[x, y]| Point3::new(x, y, 0.4)).collect();
    /// let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    /// let surfaces = [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &[0.8; 4] }];
    /// let options = PathOptions::default();
    /// let filled = fill_layers(&surfaces, &options, &|_| ControlFlow::Continue(()))?;
    /// assert_eq!(filled.totals().curves, 2);
    /// assert_eq!(filled.curves_shorter_than(SHORT_CURVE_BEADS * options.bead), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn curves_shorter_than(&self, length_mm: f64) -> usize {
        let curves = self.layers.iter().flatten().flat_map(|layer| &layer.paths.paths);
        curves.filter(|curve| curve.length() < length_mm).count()
    }
}
