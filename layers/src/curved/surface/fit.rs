//! Levels that fit a part: its layers end on its skin, not on the last whole layer of cells.
//!
//! Cells enclose a part, so they reach up to a cell beyond its skin. Levels at whole layer heights would leave a thin plate too
//! thick, too thin, or without any. Here the field is looked up on the skin, and its greatest value there is divided
//! into equal layers, as near to the layer height as a whole number of them allows, and at least one.
//!
//! Departs from Dai 2020, Equation 3.2, where the height of a layer is given and what is left over at the end stays.

use super::contour::ContourError;
use super::extend::ExtendedField;
use nalgebra::{Point3, Vector3};

/// The skin is looked up at least this often along each edge, in cells. The field bends within a cell by a few hundredths
/// of a layer.
const STEP: f64 = 0.5;

/// Levels whose layers fill a part up to its skin.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedLevels {
    /// The values, in layers of the field, as [`contour`](super::contour()) takes them.
    pub levels: Vec<f64>,
    /// Height of each layer, in millimetres.
    pub height_mm: f64,
}

impl ExtendedField {
    /// [`ExtendedField::levels`] for layers that fit: the height is changed so that a whole number of layers, at least one, reaches
    /// from the plate to the greatest value of the field on the skin.
    ///
    /// # Arguments
    /// * `vertices`, `triangles`: the mesh, in millimetres. Triangles name vertices that are there. Of places in missed cells or
    ///   farther than two cells from the part nothing is known, so they do not count.
    /// * `cell_mm`, `origin`: the edge of a cell and the low corner of the grid, in millimetres.
    /// * `height_mm`: the layer height wished for. A part of less than one and a half of it becomes one layer; two layers are
    ///   from 3/4 to 5/4 of it thick, and so on.
    ///
    /// # Errors
    /// [`ContourError`], as [`ExtendedField::levels`].
    ///
    /// # Cost
    /// Some tenths of a microsecond for each half cell of the skin.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::{LayerField, extend};
    /// // A plate of 0.7 mm in cells of 1 mm.
    /// let cells = Cells::new([2, 2, 1], &[0b11; 2])?;
    /// let field = extend(&LayerField::new(&cells, vec![0.5; 4], 1.0)?, &cells);
    /// let top = [[0.0, 0.0, 0.7], [2.0, 0.0, 0.7], [0.0, 2.0, 0.7]].map(Into::into);
    /// let fitted = field.fitted_levels(&top, &[[0, 1, 2]], 1.0, [0.0; 3].into(), 1.0)?;
    /// assert!((fitted.height_mm - 0.7).abs() < 1e-12 && fitted.levels.len() == 1);
    /// assert!((fitted.levels[0] - 0.35).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fitted_levels(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        cell_mm: f64,
        origin: Point3<f64>,
        height_mm: f64,
    ) -> Result<FittedLevels, ContourError> {
        let levels = self.levels(cell_mm, height_mm)?;
        let mut top = 0.0_f64;
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= vertices.len()) {
                return Err(ContourError::Corner { triangle, vertex, vertices: vertices.len() });
            }
            let corners = corners.map(|corner| (vertices[corner as usize] - origin) / cell_mm);
            self.highest_on(corners, &mut top);
        }
        // Slopes of a rough field would lead beyond the last cell.
        let top = top.min(self.top());
        if top <= 0.0 {
            return Ok(FittedLevels { levels, height_mm });
        }
        let part_mm = top * self.layer_cells() * cell_mm;
        let count = (part_mm / height_mm).round().max(1.0);
        let step = top / count;
        let levels = (0..count as usize).map(|i| (i as f64 + 0.5) * step).collect();
        Ok(FittedLevels { levels, height_mm: part_mm / count })
    }

    /// Raises `highest` to the greatest value on a triangle, in cells from the low corner of the grid.
    fn highest_on(&self, corners: [Vector3<f64>; 3], highest: &mut f64) {
        let mut waiting = vec![corners];
        while let Some([a, b, c]) = waiting.pop() {
            let sides = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
            let longest = sides.iter().copied().fold(0.0, f64::max);
            if longest > STEP && longest.is_finite() && self.is_near([a, b, c]) {
                let [p, q, r] = match () {
                    () if sides[0] >= longest => [a, b, c],
                    () if sides[1] >= longest => [b, c, a],
                    () => [c, a, b],
                };
                let middle = (p + q) / 2.0;
                waiting.extend([[p, middle, r], [middle, q, r]]);
            } else {
                for at in [a, b, c] {
                    *highest = self.value_at(at).map_or(*highest, |value| highest.max(value));
                }
            }
        }
    }

    /// Whether a triangle can come near the cells: what lies far away needs no looking up.
    fn is_near(&self, corners: [Vector3<f64>; 3]) -> bool {
        let [nx, ny, nz] = self.dims().map(f64::from);
        let low = corners[0].inf(&corners[1]).inf(&corners[2]);
        let high = corners[0].sup(&corners[1]).sup(&corners[2]);
        (0..3).all(|k| high[k] >= 0.0 && low[k] <= [nx, ny, nz][k])
    }

    /// The value at a place, in cells from the low corner of the grid: that of its cell, and on along its slope.
    fn value_at(&self, at: Vector3<f64>) -> Option<f64> {
        let cell = at.map(|c| c.floor() as i32);
        let (value, slopes) = self.value_and_slopes(cell.into())?;
        let from_centre = at - cell.map(|c| f64::from(c) + 0.5);
        Some(value + from_centre.dot(&Vector3::from(slopes)))
    }
}
