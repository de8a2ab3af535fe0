//! How torn a field is: which neighbours lie layers apart.

use super::field::LayerField;

impl LayerField {
    /// Share of the pairs of face neighbours whose values lie at least so many layers apart, of all pairs that both have one.
    ///
    /// Where a front waits for nothing, neighbours differ by a layer at most. 0 for a field without pairs.
    ///
    /// # Cost
    /// One pass over the grid.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::surface::LayerField;
    /// let cells = Cells::new([5, 1, 1], &[0b11111])?;
    /// let field = LayerField::new(&cells, vec![0.5, 1.5, 3.5, f64::NAN, 9.5], 1.0)?;
    /// assert_eq!((field.torn_share(2.0), field.torn_share(3.0)), (0.5, 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn torn_share(&self, layers: f64) -> f64 {
        let [nx, ny, _] = self.dims().map(|d| d as usize);
        let values = self.values();
        let (mut pairs, mut torn) = (0u64, 0u64);
        for (cell, value) in values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
            let after = [(1, cell % nx + 1 < nx), (nx, cell / nx % ny + 1 < ny), (nx * ny, true)];
            let after =
                after.iter().filter(|(_, is_inside)| *is_inside).filter_map(|(step, _)| values.get(cell + step));
            for next in after.filter(|next| !next.is_nan()) {
                pairs += 1;
                torn += u64::from((next - value).abs() >= layers);
            }
        }
        if pairs > 0 { torn as f64 / pairs as f64 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;

    #[test]
    fn pairs_along_each_axis_count_and_rows_do_not_wrap() {
        // By layer of the grid: 0 9 / 1 9 below 3 9 / 1 9. The pairs 9, 1 and 9, 3 across the ends of rows do not count.
        let values = vec![0.0, 9.0, 1.0, 9.0, 3.0, 9.0, 1.0, 9.0];
        let cells = Cells::new([2, 2, 2], &[0b11; 4]).unwrap();
        let field = LayerField::new(&cells, values, 1.0).unwrap();
        // Along x 9, 8, 6, 8; along y 1, 0, 2, 0; along z 3, 0, 0, 0.
        let expected = [(1.0, 7.0), (2.0, 6.0), (3.0, 5.0), (8.0, 3.0), (9.5, 0.0)];
        for (layers, torn) in expected {
            assert!((field.torn_share(layers) - torn / 12.0).abs() < 1e-12, "{layers}");
        }
    }
}
