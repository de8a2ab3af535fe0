//! An order in which cells are built, cut into layers.

/// Cells in the order in which they are built, cut into layers. Cells are given by their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerOrder {
    cells: Vec<u32>,
    /// Where each layer ends in `cells`.
    ends: Vec<usize>,
}

impl LayerOrder {
    /// An order without layers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a layer.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::LayerOrder;
    /// let mut order = LayerOrder::new();
    /// order.push([3, 4]);
    /// order.push([9]);
    /// assert_eq!(order.iter().collect::<Vec<_>>(), [&[3, 4][..], &[9][..]]);
    /// ```
    pub fn push(&mut self, layer: impl IntoIterator<Item = u32>) {
        self.cells.extend(layer);
        self.ends.push(self.cells.len());
    }

    /// Number of layers.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no layer.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// All cells in the order in which they are built.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The layers, first to last.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|layer| self.layer(layer))
    }

    /// The cells of one layer, counted from 0.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn layer(&self, layer: usize) -> &[u32] {
        let start = if layer == 0 { 0 } else { self.ends[layer - 1] };
        &self.cells[start..self.ends[layer]]
    }

    /// The growing field `G`: for each of the `len` cells of the grid the number of its layer counted from 1, and
    /// 0 for a cell that is empty or missed.
    ///
    /// # Panics
    /// If a cell of the order is not below `len`.
    pub fn field(&self, len: usize) -> Vec<u32> {
        let mut field = vec![0; len];
        for (layer, cells) in self.iter().enumerate() {
            for &cell in cells {
                field[cell as usize] = layer as u32 + 1;
            }
        }
        field
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_come_back_as_they_were_pushed() {
        let mut order = LayerOrder::new();
        assert!(order.is_empty());
        order.push([5, 1]);
        order.push([]);
        order.push([0]);
        assert_eq!(order.len(), 3);
        assert_eq!((order.layer(0), order.layer(1), order.layer(2)), (&[5, 1][..], &[][..], &[0][..]));
        assert_eq!(order.cells(), [5, 1, 0]);
        assert_eq!(order.field(7), [3, 1, 0, 0, 0, 1, 0]);
    }
}
