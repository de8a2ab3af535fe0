//! Whether a nozzle meets what is built before, cell by cell.
//!
//! The nozzle stands with its tip half a cell above the centre of its cell, along its direction. Each cell built before is a ball around its
//! centre. In the plane through the axis and the centre the nozzle is a flat tip, a slanted side and the lower face and side of the
//! block; the distance to these lines is worked out, for every cell that is not outside the cylinder around the block.

use crate::curved::{NozzleCell, NozzleRule};
use nalgebra::{Point3, Vector3};
use std::collections::{HashMap, VecDeque};

/// Balls that come this near are not met: rounding, in millimetres.
const TOUCHES: f64 = 1e-6;

/// Edge of a block in cells. Blocks are held against the cylinder as balls; larger ones are seldom clear of it.
const BLOCK: u32 = 6;

/// The cells of an order that are judged by a nozzle in place of the hull rule.
#[derive(Clone, Copy, Debug)]
pub struct JudgedByNozzle<'a> {
    /// The nozzle.
    pub rule: NozzleRule,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// Layers of the order that are printed as one: 1, but for orders that are cut more finely than layers are thick
    /// ([`LayerField::steps_per_layer`](crate::curved::surface::LayerField::steps_per_layer)). Cells of the last `steps - 1` of them are not in the
    /// nozzle's way, as those of its own layer are not.
    pub steps: u32,
    /// The cells, with the directions in which it prints them. Each is in a layer.
    pub cells: &'a [NozzleCell],
}

/// What a nozzle meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meets {
    Cell(u32),
    Plate,
    /// It leans farther than it may.
    Limit,
}

/// The cells built so far, as a nozzle meets them.
pub(super) struct Obstructions {
    rule: NozzleRule,
    cell_mm: f64,
    /// Height of the plate in millimetres.
    plate_mm: f64,
    blocks: Vec<Block>,
    /// Where the block at a place is among them.
    block_at: HashMap<[u32; 3], usize>,
    /// Cells of the last layers, first to last, which are not in the way yet.
    waiting: VecDeque<Vec<(u32, [u32; 3])>>,
    steps: u32,
}

/// Cells that lie in a cube of [`BLOCK`] by [`BLOCK`] by [`BLOCK`].
struct Block {
    middle: Point3<f64>,
    cells: Vec<u32>,
    /// Their centres in millimetres, along each axis.
    centres: [Vec<f64>; 3],
}

impl Obstructions {
    /// `top`: height of the plate in half cells.
    pub(super) fn new(judged: &JudgedByNozzle, top: i32) -> Self {
        let plate_mm = f64::from(top) / 2.0 * judged.cell_mm;
        Obstructions {
            rule: judged.rule,
            cell_mm: judged.cell_mm,
            plate_mm,
            blocks: Vec::new(),
            block_at: HashMap::new(),
            waiting: VecDeque::new(),
            steps: judged.steps,
        }
    }

    fn centre(&self, place: [u32; 3]) -> Point3<f64> {
        Point3::from(place.map(|k| (f64::from(k) + 0.5) * self.cell_mm))
    }

    pub(super) fn add(&mut self, cell: u32, place: [u32; 3]) {
        let centre = self.centre(place);
        let at = *self.block_at.entry(place.map(|k| k / BLOCK)).or_insert(self.blocks.len());
        if at == self.blocks.len() {
            let middle = place.map(|k| f64::from(k / BLOCK * BLOCK) + f64::from(BLOCK) / 2.0);
            let centres = [Vec::new(), Vec::new(), Vec::new()];
            self.blocks.push(Block { middle: Point3::from(middle) * self.cell_mm, cells: Vec::new(), centres });
        }
        let block = &mut self.blocks[at];
        block.cells.push(cell);
        (0..3).for_each(|axis| block.centres[axis].push(centre[axis]));
    }

    /// Ends a layer of the order: its cells come into the way, once enough others have followed.
    pub(super) fn end_layer(&mut self, cells: Vec<(u32, [u32; 3])>) {
        self.waiting.push_back(cells);
        if self.waiting.len() as u64 >= u64::from(self.steps) {
            self.waiting.pop_front().into_iter().flatten().for_each(|(cell, place)| self.add(cell, place));
        }
    }

    /// Whether all of the cells of a block keep away from the cylinder around the nozzle's block, widened by the margin.
    fn is_clear_of(&self, block: &Block, tip: &Point3<f64>, direction: &Vector3<f64>) -> bool {
        // As far as centres of cells are from the middle.
        let radius = f64::from(BLOCK - 1) / 2.0 * 3f64.sqrt() * self.cell_mm;
        let margin = self.rule.margin * self.cell_mm;
        let to_middle = block.middle - tip;
        let along = to_middle.dot(direction);
        let across = (to_middle.norm_squared() - along * along).max(0.0).sqrt();
        along + radius < -margin - TOUCHES || across - radius > self.rule.block_mm / 2.0 + margin + TOUCHES
    }

    /// What the nozzle meets with its tip at a cell.
    pub(super) fn met(&self, place: [u32; 3], direction: Vector3<f64>) -> Option<Meets> {
        // Checked here, not when directions are read: a wrong one is a fault of its cell.
        let is_within = direction.z >= self.rule.max_tilt.cos() - TOUCHES && (direction.norm() - 1.0).abs() < TOUCHES;
        if !is_within {
            return Some(Meets::Limit);
        }
        let tip = self.centre(place) + direction * (self.cell_mm / 2.0);
        let block = tip + direction * self.rule.cone_height_mm;
        // Across the axis, the steepest way down.
        let down = (direction * direction.z - Vector3::z()).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let lowest = [(tip, self.rule.tip_flat_mm), (block, self.rule.block_mm)]
            .map(|(middle, diameter)| middle.z + down.z * diameter / 2.0);
        if lowest.iter().any(|&z| z < self.plate_mm - TOUCHES) {
            return Some(Meets::Plate);
        }
        let margin = self.rule.margin * self.cell_mm;
        let reach = (self.rule.block_mm / 2.0 + margin).powi(2);
        for block in &self.blocks {
            if self.is_clear_of(block, &tip, &direction) {
                continue;
            }
            let [xs, ys, zs] = &block.centres;
            let place = |k: usize| {
                let [x, y, z] = [xs[k] - tip.x, ys[k] - tip.y, zs[k] - tip.z];
                let along = x * direction.x + y * direction.y + z * direction.z;
                [along, x * x + y * y + z * z - along * along]
            };
            let is_near = |[along, across]: [f64; 2]| (along > -margin) & (across < reach);
            // Without a branch, so that the compiler looks at several centres at once; the slow way is for those near the cylinder.
            if !(0..xs.len()).fold(false, |any, k| any | is_near(place(k))) {
                continue;
            }
            let is_met = |&k: &usize| {
                let [along, across] = place(k);
                is_near([along, across]) && self.distance(along, across.max(0.0).sqrt()) < margin - TOUCHES
            };
            if let Some(k) = (0..xs.len()).find(is_met) {
                return Some(Meets::Cell(block.cells[k]));
            }
        }
        None
    }

    /// Distance of a point from the nozzle, `z` above its tip and `rho` from its axis; inside minus the distance to its surface.
    fn distance(&self, z: f64, rho: f64) -> f64 {
        let NozzleRule { half_angle, cone_height_mm: height, .. } = self.rule;
        let [tip, block] = [self.rule.tip_flat_mm / 2.0, self.rule.block_mm / 2.0];
        let cone = tip + height * half_angle.tan();
        let lines = [
            ([0.0, 0.0], [0.0, tip]),
            ([0.0, tip], [height, cone]),
            ([height, cone], [height, block]),
            ([height, block], [height.max(z) + block, block]),
        ];
        let to_surface = lines.map(|(a, b)| to_line([z, rho], a, b)).into_iter().fold(f64::INFINITY, f64::min);
        let is_inside = if z < height { z > 0.0 && rho < tip + z * half_angle.tan() } else { rho < block };
        if is_inside { -to_surface } else { to_surface }
    }
}

/// Distance of a point from the line between two others.
fn to_line(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [along, from] = [[b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances that follow from the drawing of a nozzle: tip radius 0.5, cone to (8, 8.5), block radius 10.
    #[test]
    fn distances_are_those_of_the_drawing() {
        let rule = NozzleRule { tip_flat_mm: 1.0, ..NozzleRule::default() };
        let judged = JudgedByNozzle { rule, cell_mm: 1.0, steps: 1, cells: &[] };
        let nozzle = Obstructions::new(&judged, 0);
        let known = [
            ([-2.0, 0.0], 2.0),
            ([-4.0, 3.5], 5.0),          // beside the edge of the tip
            ([1.0, 2.5], 0.5f64.sqrt()), // beside the cone
            ([2.0, 0.0], -(2.5 * 0.5f64.sqrt()).min(2.0)),
            ([7.0, 9.5], 1.0),  // below the block
            ([5.0, 14.0], 5.0), // beside its edge
            ([100.0, 12.0], 2.0),
            ([100.0, 9.0], -1.0),
        ];
        for ([z, rho], distance) in known {
            assert!((nozzle.distance(z, rho) - distance).abs() < 1e-12, "{z} {rho}: {}", nozzle.distance(z, rho));
        }
    }
}
