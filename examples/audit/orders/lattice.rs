//! The lattice on which the centres of cells lie.

use super::order::OrderFault;

/// A lattice of equal steps along the three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The step: the edge of a cell.
    pub cell_mm: f64,
    /// Centre of the lowest cell, as the file has it.
    pub low: [f64; 3],
    /// Cells along each axis.
    pub sides: [u64; 3],
    /// Whether places are indices, else millimetres.
    is_index: bool,
}

/// How far a centre may be off its place, as a share of the step: files have three digits or more.
const OFF: f64 = 0.05;
/// Coordinates that differ by less than this share of the size of the part are one: rounding of files.
const SAME: f64 = 1e-7;

impl Lattice {
    /// Of centres in millimetres, each with its line. Without a step the least difference of coordinates along any axis is one.
    pub fn of_centres(
        places: impl Iterator<Item = (usize, [f64; 3])> + Clone,
        cell_mm: Option<f64>,
    ) -> Result<Self, OrderFault> {
        let [low, high] = bounds(places.clone());
        let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let cell_mm = match cell_mm {
            Some(cell_mm) => cell_mm,
            None => {
                let step =
                    (0..3).map(|axis| least_step(places.clone(), axis, SAME * size)).fold(f64::INFINITY, f64::min);
                if step.is_infinite() {
                    return Err(OrderFault::at(0, "one cell does not say how large cells are: give --cell"));
                }
                step
            }
        };
        // The step is exact to a digit of the file; over the whole part such errors would add up.
        let cell_mm = if size > 0.0 { size / (size / cell_mm).round().max(1.0) } else { cell_mm };
        Ok(Lattice { cell_mm, low, sides: sides(low, high, cell_mm), is_index: false })
    }

    /// Of indices: steps of 1, shown as cells of `cell_mm`; the lattice begins at index 0 or below.
    pub fn of_indices(
        places: impl Iterator<Item = (usize, [f64; 3])> + Clone,
        cell_mm: f64,
    ) -> Result<Self, OrderFault> {
        let is_whole = |at: &f64| (at - at.round()).abs() <= 0.0;
        if let Some((line, place)) = places.clone().find(|(_, place)| !place.iter().all(is_whole)) {
            let [i, j, k] = place;
            return Err(OrderFault::at(
                line,
                format!("{i},{j},{k} are no places in a grid: whole numbers belong there"),
            ));
        }
        let [low, high] = bounds(places);
        Ok(Lattice { cell_mm, low, sides: sides(low, high, 1.0), is_index: true })
    }

    /// Low corner of the lowest cell, in millimetres. Index 0 begins at 0.
    pub fn corner(&self) -> [f64; 3] {
        self.low.map(|at| if self.is_index { at * self.cell_mm } else { at - 0.5 * self.cell_mm })
    }

    /// The cell of a place.
    pub fn cell(&self, line: usize, place: [f64; 3]) -> Result<[u32; 3], OrderFault> {
        let mut cell = [0; 3];
        for axis in 0..3 {
            let step = if self.is_index { 1.0 } else { self.cell_mm };
            let steps = (place[axis] - self.low[axis]) / step;
            if (steps - steps.round()).abs() > OFF {
                let name = ["x", "y", "z"][axis];
                return Err(OrderFault::at(
                    line,
                    format!(
                        "{name} = {} is no centre of a cell of {:.4} mm, by {:.2} of its edge: give --cell, or export centres of equal cells",
                        place[axis],
                        self.cell_mm,
                        (steps - steps.round()).abs()
                    ),
                ));
            }
            cell[axis] = steps.round().max(0.0) as u32;
        }
        Ok(cell)
    }
}

fn bounds(places: impl Iterator<Item = (usize, [f64; 3])>) -> [[f64; 3]; 2] {
    let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    places.fold(start, |[low, high], (_, place)| {
        let each = |pick: fn(f64, f64) -> f64, a: [f64; 3]| [0, 1, 2].map(|axis| pick(a[axis], place[axis]));
        [each(f64::min, low), each(f64::max, high)]
    })
}

fn sides(low: [f64; 3], high: [f64; 3], cell: f64) -> [u64; 3] {
    [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / cell).round() as u64 + 1)
}

fn least_step(places: impl Iterator<Item = (usize, [f64; 3])>, axis: usize, same: f64) -> f64 {
    let mut all: Vec<f64> = places.map(|(_, place)| place[axis]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() <= same);
    all.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}
