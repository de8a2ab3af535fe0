//! The field continued beyond the part, so that its surfaces reach outside.
//!
//! Two rings of cells around the part (those at most two steps away in each axis) get values: the mean of what the
//! cells of the part within reach foretell by their value and slope, near ones more than far ones. A ring belongs to
//! the cell nearest to it, its *owner*, and only cells that agree with the owner take part. Two ring cells, or a ring
//! cell and one of the part, are joined only if the part hangs together between their owners, within the box that the two
//! span and at most two steps along each axis: so what lies across a gap, or touches along an edge only, is not bridged. Missed cells
//! stay without a value: nothing reaches into them.

use super::field::LayerField;
use super::lattice::{JUMP, Lattice, ROOM};
use crate::cells::Cells;
use crate::parallel::in_parallel;

/// Cells that a thread takes at a time: a few hundred microseconds of work. With fewer the threads spend more on sharing
/// out, with more a small part keeps one of them busy.
const AT_A_TIME: usize = 1024;

/// Rings of cells around the part that get a value.
const RINGS: i32 = 2;

/// A field that reaches beyond the part. It is made by [`extend`].
#[derive(Clone, Debug)]
pub struct ExtendedField {
    pub(super) lattice: Lattice,
    pub(super) layer_cells: f64,
    highest: f64,
    jumps: usize,
    ring_cells: usize,
    /// The nodes around the part, rising, those without a value as well.
    ring: Vec<usize>,
    half_layers: Option<f64>,
}

impl ExtendedField {
    /// How thick a layer is, in cells.
    pub fn layer_cells(&self) -> f64 {
        self.layer_cells
    }

    /// The highest value in the part.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Pairs of cells with a common face that is cut, since the front waited on one side: no surface runs across.
    pub fn jumps(&self) -> usize {
        self.jumps
    }

    /// That of the field.
    pub(crate) fn half_layers(&self) -> Option<f64> {
        self.half_layers
    }

    /// Cells outside the part that have got a value.
    pub fn ring_cells(&self) -> usize {
        self.ring_cells
    }

    /// The value at the end of the part along its growth, if its highest cell is full: half a cell above the centre of that.
    pub(super) fn top(&self) -> f64 {
        self.highest() + 0.5 / self.layer_cells()
    }

    /// Cells of the grid along each axis.
    pub(super) fn dims(&self) -> [u32; 3] {
        self.lattice.dims.map(|side| side - 2 * ROOM)
    }

    /// The value at a place of the grid, which may lie up to two cells outside of it.
    pub fn value(&self, place: [i32; 3]) -> Option<f64> {
        self.node(place).map(|node| self.lattice.values[node])
    }

    /// The same, and the slopes there.
    pub(super) fn value_and_slopes(&self, place: [i32; 3]) -> Option<(f64, [f64; 3])> {
        self.node(place).map(|node| (self.lattice.values[node], self.lattice.slopes(node)))
    }

    /// How steep the field is at a cell of the part, in layers a cell; `None` elsewhere.
    pub(super) fn steepness(&self, place: [i32; 3]) -> Option<f64> {
        let node = self.node(place).filter(|node| self.ring.binary_search(node).is_err())?;
        Some(self.lattice.slopes(node).iter().map(|slope| slope * slope).sum::<f64>().sqrt())
    }

    /// The node at a place, if it has a value.
    fn node(&self, place: [i32; 3]) -> Option<usize> {
        let place = [0, 1, 2].map(|k| place[k].checked_add_unsigned(ROOM).and_then(|c| u32::try_from(c).ok()));
        let [Some(x), Some(y), Some(z)] = place else { return None };
        let inside = [x, y, z].iter().zip(self.lattice.dims).all(|(&c, side)| c < side);
        inside.then(|| self.lattice.index([x, y, z])).filter(|&node| !self.lattice.values[node].is_nan())
    }
}

/// Continues `field` by two rings of cells around `cells`, but not into missed cells.
///
/// # Arguments
/// * `cells`: the cells that the field belongs to, missed ones included.
///
/// # Returns
/// The extended field; cells of the field itself keep their values.
///
/// # Panics
/// If `cells` are of a grid of other dimensions than the field.
///
/// # Cost
/// `O(n)` for `n` cells of the grid, some 30 bytes each, and some tenths of a microsecond for each ring cell. With the
/// feature `rayon` cells are shared out among threads; the result is the same.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::surface::{LayerField, extend};
/// let cells = Cells::new([1, 1, 2], &[1, 1])?;
/// let field = extend(&LayerField::new(&cells, vec![0.5, 1.5], 1.0)?, &cells);
/// assert_eq!(field.value([0, 0, 3]), Some(3.5));
/// assert_eq!(field.value([-2, 2, 0]), Some(0.5));
/// assert_eq!(field.value([0, 0, 4]), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn extend(field: &LayerField, cells: &Cells) -> ExtendedField {
    assert_eq!(field.dims(), cells.dims(), "the field belongs to another grid");
    let mut lattice = Lattice::of(field);
    let strides = lattice.strides();
    let solid: Vec<u32> = (0..).zip(field.values()).filter(|(_, v)| !v.is_nan()).map(|(cell, _)| cell).collect();
    let node_of = |cell: u32| lattice.index(cells.position(cell).map(|c| c + ROOM));
    let jumps = lattice.jumps();

    // Ring cells: near a cell with a value, and not of the solid.
    let mut is_ring = vec![false; lattice.values.len()];
    for &cell in &solid {
        let node = node_of(cell);
        let inner = (0..3).all(|axis| [true, false].iter().all(|&way| lattice.is_joined(node, axis, way)));
        if !inner {
            for offset in BLOCK {
                is_ring[node.wrapping_add_signed(step_of(offset, strides))] = true;
            }
        }
    }
    for cell in cells.iter() {
        is_ring[node_of(cell)] = false;
    }
    let ring: Vec<usize> = (0..is_ring.len()).filter(|&node| is_ring[node]).collect();
    let forecast = Forecast::new(&lattice);
    let continued = in_parallel(ring.len(), AT_A_TIME, |k| forecast.at(ring[k]));

    // The owner of each node: itself, or that of the ring cell.
    let mut owner: Vec<u32> = vec![u32::MAX; lattice.values.len()];
    for &cell in &solid {
        let node = node_of(cell);
        owner[node] = node as u32;
    }
    let inner = lattice.joined.clone();
    let mut ring_cells = 0;
    for (&node, found) in ring.iter().zip(&continued) {
        if let Some((value, of)) = found {
            lattice.values[node] = *value;
            owner[node] = *of as u32;
            ring_cells += 1;
        }
    }
    let links = Links { dims: lattice.dims, strides, joined: &inner };
    for &node in &ring {
        for (axis, stride) in strides.iter().enumerate() {
            for low in [node, node - stride] {
                let [a, b] = [owner[low], owner[low + stride]];
                if a != u32::MAX
                    && b != u32::MAX
                    && lattice.joined[low] >> axis & 1 == 0
                    && (lattice.values[low] - lattice.values[low + stride]).abs() < JUMP
                    && links.hang_together(a as usize, b as usize)
                {
                    lattice.joined[low] |= 1 << axis;
                }
            }
        }
    }
    let (layer_cells, highest, half_layers) = (field.layer_cells(), field.highest(), field.half_layers());
    ExtendedField { lattice, layer_cells, highest, jumps, ring_cells, ring, half_layers }
}

/// All steps of at most two cells along each axis.
const BLOCK: [[i32; 3]; 125] = {
    let mut block = [[0; 3]; 125];
    let mut k = 0;
    while k < 125 {
        block[k as usize] = [k % 5 - RINGS, k / 5 % 5 - RINGS, k / 25 - RINGS];
        k += 1;
    }
    block
};

/// How much farther a node is stored that lies at this offset.
fn step_of(offset: [i32; 3], strides: [usize; 3]) -> isize {
    (0..3).map(|k| offset[k] as isize * strides[k] as isize).sum()
}

/// What the part foretells for the cells around it.
struct Forecast<'a> {
    values: &'a [f64],
    /// Slopes of the part's own cells, worked out once.
    slopes: Vec<[f32; 3]>,
    reach: [Reach; BLOCK.len()],
}

/// A step to a node that may foretell something.
#[derive(Clone, Copy)]
struct Reach {
    step: isize,
    /// The way back.
    back: [f64; 3],
    squared: i32,
    weight: f64,
}

impl<'a> Forecast<'a> {
    fn new(lattice: &'a Lattice) -> Self {
        let strides = lattice.strides();
        let reach = BLOCK.map(|offset| {
            let squared = offset.iter().map(|o| o * o).sum::<i32>();
            Reach {
                step: step_of(offset, strides),
                back: offset.map(|o| -f64::from(o)),
                squared,
                weight: f64::from(squared).powi(-2),
            }
        });
        let slopes = in_parallel(lattice.values.len(), AT_A_TIME, |node| {
            if lattice.values[node].is_nan() { [0.0; 3] } else { lattice.slopes(node).map(|slope| slope as f32) }
        });
        Forecast { values: &lattice.values, slopes, reach }
    }

    /// The value of a ring cell, and the node that owns it.
    ///
    /// A step across the border of the lattice ends in the room at the other side, which is empty as yet.
    fn at(&self, node: usize) -> Option<(f64, usize)> {
        let mut foretold = [(0.0, 0.0); BLOCK.len()];
        let mut count = 0;
        let mut nearest: Option<(i32, f64, usize)> = None;
        for reach in &self.reach {
            let from = node.wrapping_add_signed(reach.step);
            let Some(value) = self.values.get(from).filter(|value| !value.is_nan()) else { continue };
            let ahead: f64 = (0..3).map(|k| f64::from(self.slopes[from][k]) * reach.back[k]).sum();
            let value = value + ahead;
            foretold[count] = (value, reach.weight);
            count += 1;
            if nearest.is_none_or(|(squared, ..)| reach.squared < squared) {
                nearest = Some((reach.squared, value, from));
            }
        }
        let (_, own, owner) = nearest?;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (value, weight) in foretold[..count].iter().filter(|(value, _)| (value - own).abs() < JUMP) {
            sum += weight * value;
            weights += weight;
        }
        Some((sum / weights, owner))
    }
}

/// Who hangs together with whom in the part itself.
struct Links<'a> {
    dims: [u32; 3],
    strides: [usize; 3],
    joined: &'a [u8],
}

impl Links<'_> {
    /// Whether two nodes of the part are at most two steps apart along each axis, with joined faces all the way from
    /// one to the other and no step back.
    fn hang_together(&self, a: usize, b: usize) -> bool {
        let [nx, ny, _] = self.dims.map(|d| d as usize);
        let place = |node: usize| [node % nx, node / nx % ny, node / nx / ny].map(|c| c as i32);
        let [from, to] = [place(a), place(b)];
        let left = [0, 1, 2].map(|k| to[k] - from[k]);
        left.iter().all(|steps| steps.abs() <= RINGS) && self.walk(a, left)
    }

    fn walk(&self, node: usize, left: [i32; 3]) -> bool {
        left == [0; 3]
            || (0..3).filter(|&axis| left[axis] != 0).any(|axis| {
                let way = left[axis].signum();
                let next = node.wrapping_add_signed(way as isize * self.strides[axis] as isize);
                let mut left = left;
                left[axis] -= way;
                self.joined[node.min(next)] >> axis & 1 == 1 && self.walk(next, left)
            })
    }
}
