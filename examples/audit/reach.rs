//! Directions in which a nozzle reaches a cell that lies within the hull of what is built before.
//!
//! The hull rule is for nozzles of any size. A nozzle of a given shape reaches more: it is tried in the directions of
//! [`NozzleRule::directions`]. What is found is judged by the audit of the library afterwards, which shares no code with this.

use curvlay_layers::curved::NozzleRule;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Cells that are near each other, with a ball around them.
#[derive(Clone, Debug, Default)]
struct Block {
    centres: Vec<Point3<f64>>,
}

/// What is built, in blocks of cells.
pub struct Reach {
    rule: NozzleRule,
    directions: Vec<UnitVector3<f64>>,
    cell_mm: f64,
    blocks_along: [u32; 3],
    blocks: Vec<Block>,
}

/// Edge of a block in cells.
const BLOCK: u32 = 8;
/// Rounding, in millimetres: on the safe side of the one of the audit that judges what is found.
const TOUCHES: f64 = 1e-9;

impl Reach {
    /// Nothing is built.
    pub fn new(rule: NozzleRule, cell_mm: f64, dims: [u32; 3]) -> Self {
        let blocks_along = dims.map(|side| side.div_ceil(BLOCK));
        let count = blocks_along.iter().map(|&side| side as usize).product();
        Reach { rule, directions: rule.directions(), cell_mm, blocks_along, blocks: vec![Block::default(); count] }
    }

    fn centre(&self, cell: [u32; 3]) -> Point3<f64> {
        Point3::from(cell.map(|at| (f64::from(at) + 0.5) * self.cell_mm))
    }

    /// A cell is built.
    pub fn add(&mut self, cell: [u32; 3]) {
        let [x, y, z] = cell.map(|at| at / BLOCK);
        let at = x + self.blocks_along[0] * (y + self.blocks_along[1] * z);
        let centre = self.centre(cell);
        self.blocks[at as usize].centres.push(centre);
    }

    /// A direction in which the nozzle prints a cell and touches nothing, the most upright one that is tried.
    pub fn direction(&self, cell: [u32; 3]) -> Option<UnitVector3<f64>> {
        let centre = self.centre(cell);
        let mut near: Vec<(f64, Point3<f64>, &Block)> = Vec::new();
        for (at, block) in self.blocks.iter().enumerate().filter(|(_, block)| !block.centres.is_empty()) {
            let [nx, ny, _] = self.blocks_along.map(|side| side as usize);
            let middle =
                [at % nx, at / nx % ny, at / nx / ny].map(|k| (k as f64 + 0.5) * f64::from(BLOCK) * self.cell_mm);
            near.push(((Point3::from(middle) - centre).norm_squared(), Point3::from(middle), block));
        }
        // What is near is in the way of most directions.
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.directions.iter().copied().find(|direction| self.is_free(centre, direction, &near))
    }

    fn is_free(&self, centre: Point3<f64>, direction: &Vector3<f64>, near: &[(f64, Point3<f64>, &Block)]) -> bool {
        let tip = centre + direction * (0.5 * self.cell_mm);
        if self.lowest(&tip, direction) < -TOUCHES {
            return false;
        }
        let margin = self.rule.margin * self.cell_mm;
        let radius = 0.5 * 3f64.sqrt() * f64::from(BLOCK) * self.cell_mm + margin;
        let place = |point: &Point3<f64>| {
            let way = point - tip;
            let along = way.dot(direction);
            [along, (way.norm_squared() - along * along).max(0.0).sqrt()]
        };
        near.iter().all(|(_, middle, block)| {
            let [along, across] = place(middle);
            if along + radius < 0.0 || across - radius > 0.5 * self.rule.block_mm {
                return true;
            }
            block.centres.iter().all(|centre| self.clearance(place(centre)) >= margin - TOUCHES)
        })
    }

    /// The lowest point of tip and block.
    fn lowest(&self, tip: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        let lean = (1.0 - direction.z * direction.z).max(0.0).sqrt();
        let of_tip = tip.z - 0.5 * self.rule.tip_flat_mm * lean;
        let of_block = tip.z + direction.z * self.rule.cone_height_mm - 0.5 * self.rule.block_mm * lean;
        of_tip.min(of_block)
    }

    /// How far a place is from the nozzle, no more; 0 inside. The nozzle is the union of convex bodies: a cone with a flat, and a block.
    fn clearance(&self, [along, across]: [f64; 2]) -> f64 {
        let NozzleRule { half_angle, cone_height_mm: height, .. } = self.rule;
        let [tip, block] = [0.5 * self.rule.tip_flat_mm, 0.5 * self.rule.block_mm];
        let to_block = (height - along).max(0.0).hypot((across - block).max(0.0));
        // The cone as three half planes: its distance is that to the nearest point of its outline.
        let (sin, cos) = half_angle.sin_cos();
        let out = (across - tip) * cos - along * sin;
        let up = ((across - tip) * sin + along * cos).clamp(0.0, height / cos);
        let to_side = (across - tip - up * sin).hypot(along - up * cos);
        let to_flat = if across <= tip { (-along).max(0.0) } else { to_side };
        let is_inside = (0.0..=height).contains(&along) && out <= 0.0;
        let to_cone = if is_inside { 0.0 } else { to_flat.min(to_side) };
        let to_cone = if along < 0.0 && across <= tip { -along } else { to_cone };
        to_block.min(to_cone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_drawing() {
        // Tip radius 0.5, cone to (8, 8.5), block radius 10.
        let reach = Reach::new(NozzleRule { tip_flat_mm: 1.0, ..NozzleRule::default() }, 1.0, [1; 3]);
        let known = [
            ([-2.0, 0.0], 2.0),
            ([-4.0, 3.5], 5.0),
            ([1.0, 2.5], 0.5f64.sqrt()),
            ([7.0, 9.5], 1.0),
            ([100.0, 12.0], 2.0),
            ([5.0, 14.0], 5.0),
            ([4.0, 1.0], 0.0),
            ([100.0, 9.0], 0.0),
        ];
        for (place, distance) in known {
            assert!((reach.clearance(place) - distance).abs() < 1e-12, "{place:?}: {}", reach.clearance(place));
        }
    }

    #[test]
    fn a_pit_is_reached_if_it_is_wide_enough() {
        let open = Reach::new(NozzleRule::default(), 1.0, [9, 9, 9]);
        assert_eq!(open.direction([4, 4, 0]).map(|direction| direction.z), Some(1.0));
        let mut pit = Reach::new(NozzleRule::default(), 1.0, [9, 9, 30]);
        (0..9)
            .flat_map(|x| (0..9).map(move |y| [x, y]))
            .filter(|at| *at != [4, 4])
            .for_each(|[x, y]| (0..20).for_each(|z| pit.add([x, y, z])));
        assert_eq!(pit.direction([4, 4, 0]), None);
        assert!(pit.direction([4, 4, 20]).is_some());
    }
}
