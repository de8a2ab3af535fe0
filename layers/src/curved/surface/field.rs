//! A field of layers: for each cell of the part when it is built, in layers, as a number that need not be whole.
//!
//! The plate is at 0; layer `k`, counted from 1, is the cells with `k - 1 <= value < k`, so `k - 1/2` is its middle.

use crate::cells::{Cells, LayerOrder};

/// When each cell of a part is built, in layers.
///
/// A cell has no value if it is empty or missed. [`plain_field`](super::plain_field) makes a field of whole layers, [`uniform_field`](super::uniform_field)
/// a smooth one.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerField {
    dims: [u32; 3],
    /// By cell number; not a number where there is no value.
    values: Vec<f64>,
    layer_cells: f64,
    /// Steps of the order to a layer.
    steps: u32,
    /// How many layer heights apart surfaces are at least that have a half layer between them.
    half_layers: Option<f64>,
}

/// Why values are no field.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The number of values does not fit the grid.
    #[error("{values} values for a grid of {cells} cells")]
    Length {
        /// Values that were given.
        values: usize,
        /// Cells of the grid, empty ones included.
        cells: usize,
    },
    /// A value below the plate or without end.
    #[error("cell {cell} has the value {value}: it must be finite and at least 0, or NaN for none")]
    Value {
        /// The cell.
        cell: u32,
        /// Its value.
        value: f64,
    },
    /// A value where there is no cell.
    #[error("cell {cell} has a value and does not belong to the solid")]
    NotSolid {
        /// The cell.
        cell: u32,
    },
    /// A layer of no thickness.
    #[error("a layer of {layer_cells} cells: its thickness must be finite and above 0")]
    Thickness {
        /// The thickness that was given, in cells.
        layer_cells: f64,
    },
    /// No cell has a value.
    #[error("the field is empty: no cell has a value")]
    Empty,
    /// The order names a cell outside the grid.
    #[error("the order names cell {cell} of a grid of {len}")]
    OutsideGrid {
        /// The number.
        cell: u32,
        /// Cells in the grid.
        len: usize,
    },
}

impl LayerField {
    /// Takes `values`, by cell number, as the field of `cells`; not a number means none.
    ///
    /// # Arguments
    /// * `layer_cells`: how thick a layer is, in cells.
    ///
    /// # Errors
    /// [`FieldError`] for values that do not fit the cells, or if there is none.
    pub fn new(cells: &Cells, values: Vec<f64>, layer_cells: f64) -> Result<Self, FieldError> {
        let in_grid = cells.grid_len();
        if values.len() != in_grid {
            return Err(FieldError::Length { values: values.len(), cells: in_grid });
        }
        if !(layer_cells > 0.0 && layer_cells.is_finite()) {
            return Err(FieldError::Thickness { layer_cells });
        }
        let mut any = false;
        for (cell, &value) in (0..).zip(&values) {
            if value.is_nan() {
                continue;
            }
            any = true;
            if !(value >= 0.0 && value.is_finite()) {
                return Err(FieldError::Value { cell, value });
            }
            if !cells.contains(cells.position(cell)) {
                return Err(FieldError::NotSolid { cell });
            }
        }
        if any {
            Ok(LayerField { dims: cells.dims(), values, layer_cells, steps: 1, half_layers: None })
        } else {
            Err(FieldError::Empty)
        }
    }

    /// The field with other values at its cells.
    pub(super) fn with_values(self, values: Vec<f64>) -> Self {
        LayerField { values, ..self }
    }

    /// The field with layers of another thickness, in cells.
    pub(super) fn with_layer_cells(self, layer_cells: f64) -> Self {
        LayerField { layer_cells, ..self }
    }

    /// The same field, whose [order](LayerField::order) has so many steps to a layer, and one at least.
    pub fn in_steps(self, per_layer: u32) -> Self {
        LayerField { steps: per_layer.max(1), ..self }
    }

    /// The same field, whose surfaces have half layers: between two that are more than `thicker_than` layer heights apart there is one more, as far as they
    /// are ([`Workpiece::surfaces`](super::super::Workpiece::surfaces)). None of them for `None`, or for less than 1: what is thinner needs no other.
    pub fn with_half_layers(self, thicker_than: Option<f64>) -> Self {
        LayerField { half_layers: thicker_than.filter(|&heights| heights >= 1.0), ..self }
    }

    /// How many layer heights two surfaces are apart at least where a half layer lies between them; `None` if there are no half layers.
    pub fn half_layers(&self) -> Option<f64> {
        self.half_layers
    }

    /// Cells of the grid along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The value of a cell; `None` if it is empty, missed, or not in the grid.
    pub fn value(&self, cell: u32) -> Option<f64> {
        self.values.get(cell as usize).copied().filter(|value| !value.is_nan())
    }

    /// All values by cell number; not a number where there is none.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// How thick a layer is, in cells: one over this is the slope of the field, where the layers are even.
    pub fn layer_cells(&self) -> f64 {
        self.layer_cells
    }

    /// Steps of its [order](LayerField::order) to a layer: 1, but for a [`coherent_field`](super::coherent_field).
    pub fn steps_per_layer(&self) -> u32 {
        self.steps
    }

    /// Number of cells that have a value.
    pub fn count(&self) -> usize {
        self.values.iter().filter(|value| !value.is_nan()).count()
    }

    /// The highest value.
    pub fn highest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// The cells of each surface: those whose height along the growth is nearer to it than to the ones before and after it. What lies above the last
    /// surface goes with it.
    ///
    /// # Arguments
    /// * `heights_mm`: heights of the surfaces along the growth, rising; with none there is one list. Those of
    ///   [`LayerSurfaces`](super::super::LayerSurfaces).
    /// * `cell_mm`: the edge of a cell.
    ///
    /// # Returns
    /// A list a surface, rising by cell number; lists may be empty. Cells without a value are in none.
    ///
    /// # Errors
    /// [`FieldError::Thickness`] for a cell that is not above 0 and finite.
    ///
    /// # Cost
    /// `O(n log m)` for `n` cells of the grid and `m` surfaces.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::LayerField;
    /// let cells = Cells::new([4, 1, 1], &[0b1111])?;
    /// let field = LayerField::new(&cells, vec![0.5, 1.2, f64::NAN, 1.9], 1.0)?;
    /// // Layers of 3 mm on cells of 2 mm, whose heights are 1, 2.4 and 3.8 mm.
    /// assert_eq!(field.cells_by_surface(&[1.5, 4.5], 2.0)?, [vec![0, 1], vec![3]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cells_by_surface(&self, heights_mm: &[f64], cell_mm: f64) -> Result<Vec<Vec<u32>>, FieldError> {
        let layer_mm = self.layer_cells * cell_mm;
        if !(layer_mm > 0.0 && layer_mm.is_finite()) {
            return Err(FieldError::Thickness { layer_cells: cell_mm });
        }
        let between: Vec<f64> = heights_mm.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
        let mut layers = vec![Vec::new(); heights_mm.len().max(1)];
        for (cell, value) in (0..).zip(&self.values).filter(|(_, value)| !value.is_nan()) {
            layers[between.partition_point(|&border| border <= value * layer_mm)].push(cell);
        }
        Ok(layers)
    }

    /// The field cut into whole layers: the order that an audit can check. Layers without cells are left out; cells
    /// within a layer rise.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::LayerField;
    /// let cells = Cells::new([4, 1, 1], &[0b1111])?;
    /// let field = LayerField::new(&cells, vec![0.5, 1.2, f64::NAN, 1.9], 1.0)?;
    /// assert_eq!(field.rounded().iter().collect::<Vec<_>>(), [&[0][..], &[1, 3][..]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rounded(&self) -> LayerOrder {
        self.cut(1)
    }

    /// The order in which the field builds its cells: layer by layer, or in the [steps](LayerField::steps_per_layer) into which its layers
    /// are cut, where cells stand on others of their layer. Steps without cells are left out; cells within a step rise.
    pub fn order(&self) -> LayerOrder {
        self.cut(self.steps)
    }

    fn cut(&self, per_layer: u32) -> LayerOrder {
        let step = |value: f64| (value * f64::from(per_layer)) as u64;
        let mut by_layer: Vec<(u64, u32)> =
            (0..).zip(&self.values).filter(|(_, v)| !v.is_nan()).map(|(cell, v)| (step(*v), cell)).collect();
        by_layer.sort_unstable();
        let mut order = LayerOrder::new();
        for layer in by_layer.chunk_by(|a, b| a.0 == b.0) {
            order.push(layer.iter().map(|&(_, cell)| cell));
        }
        order
    }
}
