//! How beads share a surface, without curves: their width at each place, and how much length lies there.
//!
//! Rings lie where [`Spacing`] puts them, which follows from the distance to the boundary and from the ridge alone. So the length of
//! beads over a piece of surface is its area by their number across: `m` rings between the boundary and a ridge at `R` are `m / R` a
//! millimetre. What curves add to that (bridges between rings) and what they leave out (short ones) is not counted.

use super::spacing::{BeadsAt, Spacing};
use crate::level_set::LevelField;
use crate::path::{PathError, PathOptions, Pattern};

/// Beads over a surface.
pub(crate) struct ExpectedBeads {
    /// In the middle of each triangle of the field.
    pub of_triangle: Vec<BeadsAt>,
    /// At each vertex of the field how far it is inward of the innermost contour's inner edge, below 0 on contours; empty for a surface that is
    /// filled solid.
    pub inside: Vec<f64>,
}

impl LevelField<'_> {
    /// The beads that [`LevelField::paths`] would lay, or so many contours of them, by place. `O(n log n)` for `n` triangles.
    pub(crate) fn expected_beads(&self, options: &PathOptions, walls: Option<u32>) -> Result<ExpectedBeads, PathError> {
        let PathOptions { bead, min_width, .. } = *options;
        let fitted = options.fitted && (options.pattern != Pattern::Zigzag || walls.is_some());
        let spacing = Spacing::new(self, bead, self.reach(bead)?, fitted, walls.map(|walls| walls as usize));
        let of_triangle = self.triangles.iter().map(|&corners| {
            let values = corners.map(|v| self.values[v as usize]);
            if values.iter().any(|value| !value.is_finite()) {
                return BeadsAt::default(); // without a boundary there are no rings
            }
            spacing.beads_at(values.iter().sum::<f64>() / 3.0, corners, min_width)
        });
        let of_triangle = of_triangle.collect();
        Ok(ExpectedBeads { of_triangle, inside: walls.map_or(Vec::new(), |walls| spacing.inside(walls as usize)) })
    }
}
