//! What is in the nozzle's way comes later.
//!
//! A cell `c` with the value `v` is reached in the direction `w` if all cells within the nozzle, its tip on `c`, come after it. So those that are in the
//! way get a floor of their values,
//!
//! `v + (w . y - k r) / sqrt(1 + k^2)`,
//!
//! where `y` is the way from the tip to the cell, and `r` its distance from the axis less the radius of the tip. With `k` no more than the cotangent of the
//! cone's half angle, and than the cone's height over the block's radius, the floor is above `v` all over the nozzle. Cells around the axis are built
//! from the outside in: a narrow pit becomes a bowl that the nozzle fits into.
//!
//! From there floors fall by one a cell in all directions inside the part. So they differ by no more than one from neighbour to neighbour, a field held
//! above them ([`distances`](super::march::distances)) does not tear, and what is far from the pit keeps its time.

use super::super::nozzle::{NozzleRule, Obstacles};
use super::super::surface::LayerField;
use crate::cells::Cells;
use crate::curved::buildable::rules::Neighbours;
use crate::parallel::in_parallel;
use nalgebra::{Point3, UnitVector3};
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::ControlFlow::{Break, Continue};

/// Cells of a pit that vote for its direction: each vote costs a look at all directions.
const VOTES: usize = 4;

/// One of so many directions is voted on: they are then about 25 degrees apart, half of what the cone of a usual nozzle opens.
const EVERY: usize = 8;

/// What is in the way comes no more than this after the cell, in layers: more than the two steps of a layer, so that it is not in the way any more.
/// Without a bound a pit at the foot of a tall part would delay all of it.
const MAX_RISE: f64 = 1.5;

/// The tip is so far above the centre of its cell, in cells.
const TIP_ABOVE_CENTRE: f64 = 0.5;

/// A cell that is to be reached, and how.
#[derive(Clone, Copy, Debug)]
struct Reach {
    tip: Point3<f64>,
    direction: UnitVector3<f64>,
    value: f64,
    /// Radius of the tip with its margin, in cells.
    radius: f64,
    /// `k`.
    narrowing: f64,
}

impl Reach {
    /// The floor at the centre of a cell.
    fn floor(&self, place: [u32; 3]) -> f64 {
        let from_tip = centre(place) - self.tip;
        let along = from_tip.dot(&self.direction);
        let across = (from_tip.norm_squared() - along * along).max(0.0).sqrt() - self.radius;
        let rise = (along - self.narrowing * across.max(0.0)) / self.narrowing.hypot(1.0);
        self.value + rise.min(MAX_RISE)
    }
}

fn centre(place: [u32; 3]) -> Point3<f64> {
    Point3::from(place.map(|k| f64::from(k) + 0.5))
}

/// Raises the floors of what keeps the nozzle from cells that it did not reach.
///
/// Cells that hang together get one direction: that in which the fewest cells are in the way of all of them.
pub(super) fn delay(
    floors: &mut Floors,
    cells: &Cells,
    field: &LayerField,
    unreached: &[u32],
    obstacles: &Obstacles,
    (nozzle, cell_mm): (&NozzleRule, f64),
    neighbours: Neighbours,
) {
    let all = nozzle.directions();
    let directions: Vec<UnitVector3<f64>> = all.into_iter().step_by(EVERY).collect();
    let [tip, height, block] =
        [nozzle.tip_flat_mm / 2.0, nozzle.cone_height_mm, nozzle.block_mm / 2.0].map(|length| length / cell_mm);
    let narrowing = (1.0 / nozzle.half_angle.tan()).min(height / (block + nozzle.margin));
    let pits = pits(cells, unreached, neighbours);
    let ways_in = in_parallel(pits.len(), 1, |k| way_in(&pits[k], &directions, obstacles));
    for (pit, way_in) in pits.iter().zip(ways_in) {
        let Some(direction) = way_in else { continue };
        let raised = in_parallel(pit.len(), 1, |k| {
            let tip_at = centre(cells.position(pit[k])) + direction.into_inner() * TIP_ABOVE_CENTRE;
            let (value, radius) = (field.value(pit[k]).unwrap_or(0.0), tip + nozzle.margin);
            let reach = Reach { tip: tip_at, direction, value, radius, narrowing };
            let mut raised = Vec::new();
            obstacles.each_hit(pit[k], &direction, |other| {
                let floor = reach.floor(cells.position(other));
                if field.value(other).is_some_and(|value| value < floor) {
                    raised.push((other, floor));
                }
                Continue(())
            });
            raised
        });
        raised.into_iter().flatten().for_each(|(cell, floor)| floors.raise(cell, floor));
    }
    floors.spread(cells, field);
}

/// The direction in which the fewest cells are in the way of those of a pit that vote; `None` if the plate is in the way of each.
fn way_in(pit: &[u32], directions: &[UnitVector3<f64>], obstacles: &Obstacles) -> Option<UnitVector3<f64>> {
    let voters: Vec<u32> = pit.iter().copied().step_by(pit.len().div_ceil(VOTES)).collect();
    let mut best = None;
    let mut fewest = usize::MAX;
    for direction in directions {
        if !voters.iter().all(|&cell| obstacles.clears_plate_in(cell, direction)) {
            continue;
        }
        // More than the fewest so far need not be counted.
        let mut hits = 0;
        for &cell in &voters {
            obstacles.each_hit(cell, direction, |_| {
                hits += 1;
                if hits < fewest { Continue(()) } else { Break(()) }
            });
        }
        if hits < fewest {
            (best, fewest) = (Some(*direction), hits);
        }
    }
    best
}

/// Cells that hang together, each list rising, in the order of their first cells.
fn pits(cells: &Cells, unreached: &[u32], neighbours: Neighbours) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<u32> = unreached.iter().copied().collect();
    let mut pits = Vec::new();
    while let Some(first) = left.pop_first() {
        let mut pit = vec![first];
        let mut next = 0;
        while next < pit.len() {
            let place = cells.position(pit[next]);
            for offset in neighbours.offsets() {
                let [x, y, z] = [0, 1, 2].map(|axis| place[axis].wrapping_add_signed(offset[axis]));
                let beside = [x, y, z];
                if cells.contains(beside) && left.remove(&cells.id(beside)) {
                    pit.push(cells.id(beside));
                }
            }
            next += 1;
        }
        pit.sort_unstable();
        pits.push(pit);
    }
    pits
}

/// Floors of the values, by cell number; 0 where there is none.
pub(super) struct Floors {
    values: Vec<f64>,
    /// Cells that were raised and not spread yet, the highest first. Floors are positive, so their bits are in their order.
    raised: BinaryHeap<(u64, u32)>,
}

impl Floors {
    pub(super) fn none(cells: &Cells) -> Self {
        let len: usize = cells.grid_len();
        Floors { values: vec![0.0; len], raised: BinaryHeap::new() }
    }

    pub(super) fn of(&self, cell: u32) -> f64 {
        self.values[cell as usize]
    }

    fn raise(&mut self, cell: u32, floor: f64) {
        if floor > self.of(cell) {
            self.values[cell as usize] = floor;
            self.raised.push((floor.to_bits(), cell));
        }
    }

    /// Lets floors fall by the distance from where they were raised, to where the field is above them anyway.
    fn spread(&mut self, cells: &Cells, field: &LayerField) {
        while let Some((bits, cell)) = self.raised.pop() {
            let floor = f64::from_bits(bits);
            if floor < self.of(cell) {
                continue;
            }
            let place = cells.position(cell);
            for offset in Neighbours::FaceOrEdge.offsets() {
                let beside = [0, 1, 2].map(|axis| place[axis].wrapping_add_signed(offset[axis]));
                let fallen = floor - f64::from(offset.iter().map(|k| k * k).sum::<i32>()).sqrt();
                if fallen > 0.0 && cells.contains(beside) {
                    let id = cells.id(beside);
                    if field.value(id).is_none_or(|value| fallen > value) {
                        self.raise(id, fallen);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// All over the nozzle the floor is above the value of its cell.
    #[test]
    fn the_floor_covers_the_nozzle() {
        let direction = UnitVector3::new_normalize(Vector3::new(1.0, 2.0, 3.0));
        let nozzle = NozzleRule { tip_flat_mm: 1.0, ..NozzleRule::default() };
        let [tip, height, block] = [0.5, 8.0, 10.0];
        let narrowing = (1.0 / nozzle.half_angle.tan()).min(height / (block + nozzle.margin));
        let reach =
            Reach { tip: Point3::new(20.5, 20.5, 20.5), direction, value: 7.0, radius: tip + nozzle.margin, narrowing };
        for cell in 0..64_000u32 {
            let place = [cell % 40, cell / 40 % 40, cell / 1600];
            let from_tip = centre(place) - reach.tip;
            let along = from_tip.dot(&direction);
            let across = (from_tip.norm_squared() - along * along).max(0.0).sqrt();
            let is_in_cone = along > 0.0 && along < height && across < tip + along * nozzle.half_angle.tan();
            if is_in_cone || along > height && across < block {
                assert!(reach.floor(place) > 7.0, "{place:?}");
            }
        }
    }

    /// Floors fall by a cell from neighbour to neighbour, until the field is above them.
    #[test]
    fn floors_fall_by_one_a_cell() {
        let cells = Cells::new([40, 1, 1], &[(1 << 40) - 1]).unwrap();
        let field = LayerField::new(&cells, (0..40).map(|x| f64::from(x) + 0.5).collect(), 1.0).unwrap();
        let mut floors = Floors::none(&cells);
        floors.raise(10, 30.0);
        floors.raise(20, 15.0); // the field is above that
        floors.spread(&cells, &field);
        for x in 0..40u32 {
            let fallen = 30.0 - (f64::from(x) - 10.0).abs();
            let is_above_field = fallen > f64::from(x) + 0.5;
            let expected = if is_above_field { fallen } else { [0.0, 15.0][usize::from(x == 20)] };
            assert!((floors.of(x) - expected).abs() < 1e-9, "{x}: {}", floors.of(x));
        }
    }
}
