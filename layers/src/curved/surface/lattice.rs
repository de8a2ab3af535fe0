//! The lattice of cell centres with room around it: values at its nodes, and which neighbours are joined.

use super::field::LayerField;

/// Nodes added on each side: two rings of extension, and one more so that every edge has cubes all around.
pub(super) const ROOM: u32 = 3;

/// A face is cut if the whole layers of its cells are this far apart, and their values by [`APART`]. A layer of the order lies
/// between them then, so the front waited on one side, and surfaces drawn between the two would be squeezed. Where a front
/// moves a cell a layer, neighbours are in the same layer or in the next, whichever way it faces. In the rings around the
/// part values themselves are compared.
pub(crate) const JUMP: f64 = 2.0;

/// Cells with a whole layer between them may have values no farther apart than those of a front that is a little slow. From
/// here on, in layers, they count as torn: less makes more cuts and gaps beside them, more makes layers thinner there.
const APART: f64 = 1.4;

/// Cells with a value below this stand on the plate.
const FIRST_LAYER: f64 = 1.0;

/// Values at the nodes of a lattice, and the edges along which they may be interpolated.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// Nodes along each axis.
    pub(super) dims: [u32; 3],
    /// NaN where undefined.
    pub(super) values: Vec<f64>,
    /// Bit `a`: the node and the next one along axis `a` are joined.
    pub(super) joined: Vec<u8>,
}

impl Lattice {
    /// The lattice of the centres of the cells, in the middle of its room; neighbours are joined if both have a value
    /// and no cut between them ([`is_cut`]).
    pub(super) fn of(field: &LayerField) -> Self {
        Self::cut_where(field, is_cut)
    }

    /// The same with cuts of one's own.
    pub(super) fn cut_where(field: &LayerField, is_cut: impl Fn(f64, f64) -> bool) -> Self {
        let dims = field.dims().map(|d| d + 2 * ROOM);
        let len = dims.iter().map(|&d| d as usize).product();
        let mut lattice = Lattice { dims, values: vec![f64::NAN; len], joined: vec![0; len] };
        let [nx, ny, _] = field.dims().map(|d| d as usize);
        for (row, values) in field.values().chunks_exact(nx).enumerate() {
            let start = lattice.index([0, (row % ny) as u32, (row / ny) as u32].map(|c| c + ROOM));
            lattice.values[start..start + nx].copy_from_slice(values);
        }
        let strides = lattice.strides();
        for node in 0..len {
            let value = lattice.values[node];
            if !value.is_nan() {
                for (axis, stride) in strides.iter().enumerate() {
                    let next = lattice.values[node + stride];
                    if !next.is_nan() && !is_cut(next, value) {
                        lattice.joined[node] |= 1 << axis;
                    }
                }
            }
        }
        lattice
    }

    /// The node of a cell of the grid that it was made of.
    pub(super) fn node(&self, position: [u32; 3]) -> usize {
        self.index(position.map(|c| c + ROOM))
    }

    /// The values at the cells of the grid that it was made of.
    pub(super) fn values_at_cells(&self) -> Vec<f64> {
        let [nx, ny, nz] = self.dims.map(|side| side - 2 * ROOM);
        let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| [0, y, z]));
        let starts = rows.map(|row| self.index(row.map(|c| c + ROOM)));
        starts.flat_map(|start| self.values[start..start + nx as usize].iter().copied()).collect()
    }

    pub(super) fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        x as usize + self.dims[0] as usize * (y as usize + self.dims[1] as usize * z as usize)
    }

    pub(super) fn position(&self, node: usize) -> [u32; 3] {
        let [nx, ny, _] = self.dims.map(|d| d as usize);
        [node % nx, node / nx % ny, node / nx / ny].map(|c| c as u32)
    }

    /// How far apart neighbours along each axis are stored.
    pub(super) fn strides(&self) -> [usize; 3] {
        let [nx, ny, _] = self.dims.map(|d| d as usize);
        [1, nx, nx * ny]
    }

    /// Whether the node is joined to the next one along the axis, or to the one before it.
    pub(super) fn is_joined(&self, node: usize, axis: usize, forwards: bool) -> bool {
        let stride = self.strides()[axis];
        let low = if forwards { Some(node) } else { node.checked_sub(stride) };
        low.is_some_and(|low| self.joined[low] >> axis & 1 == 1)
    }

    /// The values half way along an edge that is cut, as its lower and its upper end foretell them: each side goes on to
    /// the face between. `None` if the two are joined, or one has no value.
    pub(super) fn half_way(&self, low: usize, axis: usize) -> Option<[f64; 2]> {
        let high = low + self.strides()[axis];
        let end = |node: usize, way: f64| self.values[node] + way * self.slope(node, axis) / 2.0;
        self.has_cut(low, axis).then(|| [end(low, 1.0), end(high, -1.0)])
    }

    /// Slope at a node along an axis, as [`Lattice::slopes`] has it.
    pub(super) fn slope(&self, node: usize, axis: usize) -> f64 {
        self.joined_slope(node, axis).unwrap_or_else(|| self.slopes(node)[axis])
    }

    /// Slope at a node along each axis: over both joined neighbours, or the one that there is. Along an axis that is cut
    /// on both sides it is what is missing to a layer a cell, towards what comes later; without neighbours it is zero.
    pub(super) fn slopes(&self, node: usize) -> [f64; 3] {
        let known = [0, 1, 2].map(|axis| self.joined_slope(node, axis));
        if let [Some(x), Some(y), Some(z)] = known {
            return [x, y, z];
        }
        let ways = [0, 1, 2].map(|axis| if known[axis].is_some() { 0.0 } else { self.later(node, axis) });
        let cut: f64 = ways.iter().map(|way| way * way).sum();
        let missing = 1.0 - known.iter().flatten().map(|slope| slope * slope).sum::<f64>();
        let share = if cut > 0.0 { (missing.max(0.0) / cut).sqrt() } else { 0.0 };
        [0, 1, 2].map(|axis| known[axis].unwrap_or(ways[axis] * share))
    }

    fn joined_slope(&self, node: usize, axis: usize) -> Option<f64> {
        let stride = self.strides()[axis];
        let value = self.values[node];
        let after = self.is_joined(node, axis, true).then(|| self.values[node + stride] - value);
        let before = self.is_joined(node, axis, false).then(|| value - self.values[node - stride]);
        match (before, after) {
            (Some(before), Some(after)) => Some((before + after) / 2.0),
            (one, other) => one.or(other),
        }
    }

    /// Which way along an axis the neighbours come later: 1 or -1. If both do, or none, what is around it tells; 0 if
    /// that does not either. A cell of the first layer without neighbours above and below stands on the plate, so its layer
    /// grows upwards.
    fn later(&self, node: usize, axis: usize) -> f64 {
        let strides = self.strides();
        let value = |node: Option<usize>| node.and_then(|node| self.values.get(node)).copied().unwrap_or(f64::NAN);
        let way = |step: f64| {
            if step > 0.0 {
                1.0
            } else if step < 0.0 {
                -1.0
            } else {
                0.0
            }
        };
        let [before, here, after] =
            [node.checked_sub(strides[axis]), Some(node), Some(node + strides[axis])].map(value);
        let cut = before.is_finite() || after.is_finite();
        match way(here - before) + way(after - here) {
            0.0 if cut => {
                let around = strides.iter().flat_map(|stride| [node.checked_sub(*stride), Some(node + stride)]);
                let slopes = around.flatten().filter(|&next| next < self.values.len());
                way(slopes.filter_map(|next| self.joined_slope(next, axis)).sum())
            }
            0.0 if axis == 2 && self.values[node] < FIRST_LAYER => 1.0,
            sum => sum.clamp(-1.0, 1.0),
        }
    }

    /// Mean slope, in any direction, over all nodes at which there is one.
    pub(super) fn mean_slope(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for slope in self.steepness() {
            sum += slope;
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// How uneven layers will be: standard deviation over mean of their thickness, which is one over the slope. Where the
    /// slope is steep there is more of a surface, so each node counts by its slope.
    pub(super) fn unevenness(&self) -> f64 {
        let (mut weight, mut mean, mut square) = (0.0, 0.0, 0.0);
        for slope in self.steepness() {
            weight += slope;
            mean += 1.0; // slope * (1 / slope)
            square += 1.0 / slope;
        }
        if weight > 0.0 { (square * weight / (mean * mean) - 1.0f64).max(0.0).sqrt() } else { 0.0 }
    }

    /// The slopes, in any direction, of the nodes that have one.
    fn steepness(&self) -> impl Iterator<Item = f64> {
        let steepness = |node: usize| self.slopes(node).map(|slope| slope.powi(2)).iter().sum::<f64>().sqrt();
        (0..self.values.len()).filter(|&node| !self.values[node].is_nan()).map(steepness).filter(|&slope| slope > 0.0)
    }

    /// Pairs of neighbours with values that are not joined.
    pub(super) fn jumps(&self) -> usize {
        (0..self.values.len()).map(|node| (0..3).filter(|&axis| self.has_cut(node, axis)).count()).sum()
    }

    /// Whether a node and the next one along an axis have values, but are not joined.
    fn has_cut(&self, low: usize, axis: usize) -> bool {
        let high = self.values.get(low + self.strides()[axis]);
        self.joined[low] >> axis & 1 == 0 && high.is_some_and(|high| !(high - self.values[low]).is_nan())
    }
}

/// Whether there is a cut between neighbours of these values. Of what is not a number: no.
fn is_cut(a: f64, b: f64) -> bool {
    (a.floor() - b.floor()).abs() >= JUMP && (a - b).abs() >= APART
}
