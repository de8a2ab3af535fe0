//! The order of a distance field, of the cells that the nozzle that prints reaches.
//!
//! Steps of the field are taken in their order. A cell is built if a neighbour of an earlier step, or the base, supports it, and if the nozzle finds a
//! direction in which it meets neither the plate nor a cell of an earlier layer; of the free ones it takes the one nearest to the way in which the field
//! rises. A layer is not in its own way: the nozzle is held against the steps before the last [`STEPS_PER_LAYER`] that are in the
//! order, the present one included. So cells of a step are judged in parallel, and the order does not depend on the number of threads.
//!
//! Where fronts meet, the last cell of a crease has neighbours on both sides that are a whole layer lower, and in the way. One step earlier they are of its
//! own layer: a cell that is not reached joins the last step that was built if it is supported and reached then.

use super::super::growth::{Growth, GrowthError, GrowthStatistics, MissedCell, MissedReason, NozzleCell};
use super::super::nozzle::{NozzleRule, Obstacles, check_growth};
use super::super::surface::LayerField;
use super::delayed::{Floors, delay};
use super::directed::{DirectedOptions, directed};
use super::lifted::lifted;
use super::march::distances;
use super::{HALF_LAYERS, ON_BASE, OnBase, STEPS_PER_LAYER, base, beside, in_cells, slope, solved};
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::{carried, joined};
use crate::parallel::in_parallel;
use crate::{Progress, ProgressFn};
use nalgebra::{UnitVector3, Vector3};

/// How far the nozzle may lean from the way in which the field rises, as a cosine: a right angle, which is how far the direction of a nozzle over a bead
/// is searched. Less leaves the last cells open where fronts meet: a nozzle gets there only along the front.
const MIN_COSINE: f64 = 0.0;

/// Cells that a thread looks at at a time: some hundred microseconds.
const AT_A_TIME: usize = 64;

/// Times that what is in the way is delayed, at most: a delay can put other cells into the way, which takes another. Each costs a march and a growth.
const ROUNDS: usize = 6;

/// Rounds in a row that gain nothing before no more are tried.
const MAX_IDLE_ROUNDS: usize = 1;

/// An order by distance.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceOrder {
    /// The order, with the direction of the nozzle for every cell of it ([`Growth::nozzle`]).
    pub growth: Growth,
    /// The field that it is by. What the order misses has a value as well.
    pub field: LayerField,
    /// How often cells in the way were delayed.
    pub rounds: usize,
}

/// Orders the cells by their distance from what the part stands on ([`distance_field`](super::distance_field)), those that the nozzle reaches. Where it does
/// not, what is in its way is delayed and the field solved again, as long as that leaves fewer cells out.
///
/// # Arguments
/// * `cell_mm`: edge of a cell in millimetres.
/// * `base`: the cells that the order begins with, by rising number, of those that stand on the platform or its mould; `None` for all of these.
/// * `nozzle`: the nozzle that prints.
/// * `progress`: called with the stage `distance`, the cells decided in a round and all there are; may cancel.
///
/// # Returns
/// The order; none of its cells is judged by the hull rule, and [`audit_with_nozzle`](super::super::audit_with_nozzle) checks them all, in
/// [`STEPS_PER_LAYER`]. What is not reached is missed ([`MissedReason::OutOfReach`]); [`grow_with_nozzle`](super::super::grow_with_nozzle) goes
/// on from there, and [`distance_layers`](super::distance_layers) with the field.
///
/// # Errors
/// [`GrowthError`]: for unsound rules, an invalid nozzle, a part that does not stand on the platform.
///
/// # Cost
/// Some microseconds a cell and round, on several threads with the feature `rayon`. The same input gives the same order on any number of threads.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{NozzleRule, Platform, Rules, grow_by_distance};
/// use std::ops::ControlFlow::Continue;
/// // A mast of 12 cells of 5 mm with an arm at its top: the arm grows sideways, out of the mast.
/// let mut rows = vec![0b00_0001; 12];
/// rows[11] = 0b11_1111;
/// let cells = Cells::new([6, 1, 12], &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 20.0)?, Rules::default());
/// let growth = grow_by_distance(&cells, 5.0, &platform, &rules, None, &NozzleRule::default(), &|_| Continue(()))?.growth;
/// assert!(growth.missed.is_empty());
/// assert_eq!(growth.order.len(), 17);
/// assert!(growth.nozzle.last().is_some_and(|end| end.direction.x > 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn grow_by_distance(
    cells: &Cells,
    cell_mm: f64,
    platform: &Platform,
    rules: &Rules,
    base: Option<&[u32]>,
    nozzle: &NozzleRule,
    progress: ProgressFn,
) -> Result<DistanceOrder, GrowthError> {
    let job = Job::new(cells, cell_mm, platform, rules, base, nozzle, progress)?;
    let (grown, rounds) = job.delayed(|floors| solved(cells, &job.base, &|cell| floors.of(cell)))?;
    Ok(job.order(grown, rounds))
}

/// Orders the cells as [`grow_by_distance`] does, by a field that follows the distance but leans from upright no more than the nozzle's cone leaves of a
/// right angle: so fronts that meet leave a valley that it fits into. Its layers are thicker where directions turn, and the field has
/// [half layers](LayerField::with_half_layers) there.
///
/// What it does not reach is not delayed: floors fall off in all directions, so they would make the field lean as the limit forbids, and close other valleys. It is
/// missed, and support carries it.
///
/// # Arguments
/// * `given`: a direction for each cell of the grid that the field follows in place of the distance, up to the lean that layers may have; of length 0 where there is none. Each other cell has the one nearest to it
///   inside the part, evened out where two meet ([`Workpiece::directions_at`](super::super::Workpiece::directions_at)).
/// * `options`: how far its layers lean.
/// * all others as for [`grow_by_distance`].
///
/// # Errors
/// As for [`grow_by_distance`]; [`GrowthError::LayerTilt`], [`GrowthError::Directions`].
///
/// # Cost
/// That of a round of [`grow_by_distance`], and of a linear system: `n` times the length of the part in cells, some 0.2 s for 60,000 cells, one thread.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{DirectedOptions, NozzleRule, Platform, Rules, grow_directed};
/// use std::ops::ControlFlow::Continue;
/// // A mast of 12 cells of 5 mm with an arm at its top: its layers lean by 39 degrees.
/// let mut rows = vec![0b00_0001; 12];
/// rows[11] = 0b11_1111;
/// let cells = Cells::new([6, 1, 12], &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 20.0)?, Rules::default());
/// let (nozzle, options) = (NozzleRule::default(), DirectedOptions::default());
/// let order = grow_directed(&cells, 5.0, &platform, &rules, None, &nozzle, None, &options, &|_| Continue(()))?;
/// assert!(order.growth.missed.is_empty() && order.field.half_layers().is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[expect(clippy::too_many_arguments, reason = "as grow_by_distance, directions and options")]
pub fn grow_directed(
    cells: &Cells,
    cell_mm: f64,
    platform: &Platform,
    rules: &Rules,
    base: Option<&[u32]>,
    nozzle: &NozzleRule,
    given: Option<&[Vector3<f64>]>,
    options: &DirectedOptions,
    progress: ProgressFn,
) -> Result<DistanceOrder, GrowthError> {
    let tilt = options.tilt_for(nozzle)?;
    let job = Job::new(cells, cell_mm, platform, rules, base, nozzle, progress)?;
    let base = &job.base;
    let len = cells.grid_len();
    let is_unsound = |given: &[Vector3<f64>]| given.len() != len || given.iter().flatten().any(|k| !k.is_finite());
    if given.is_some_and(is_unsound) {
        return Err(GrowthError::Directions { len });
    }
    let directed = directed(cells, base, &distances(cells, base, &|_| 0.0), given, tilt);
    let grown = job.grown(in_cells(cells, lifted(cells, base, &directed)).with_half_layers(Some(HALF_LAYERS)))?;
    Ok(job.order(grown, 0))
}

/// Orders the cells as [`grow_by_distance`] does, by how high they lie over a surface: layers are parallel to it. Cells that stand on the platform have their height as well; any other has
/// a lower one beside a face of it: where it has none, its value is raised. What is not reached is missed.
///
/// # Arguments
/// * `heights`: of each cell of the grid, in cells ([`Workpiece::heights_over`](super::super::Workpiece::heights_over)).
/// * all others as for [`grow_by_distance`].
///
/// # Errors
/// As for [`grow_by_distance`]; [`GrowthError::Heights`].
///
/// # Cost
/// That of a round of [`grow_by_distance`].
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{NozzleRule, Platform, Rules, grow_by_heights};
/// use std::ops::ControlFlow::Continue;
/// // A wall of 5 by 4 cells of 5 mm, and a slope that rises by half a cell from cell to cell: 12 steps of half a cell.
/// let cells = Cells::new([5, 1, 4], &[0b1_1111; 4])?;
/// let heights: Vec<f64> = (0..20).map(|cell| f64::from(cell / 5) - 0.5 * f64::from(cell % 5)).collect();
/// let (platform, rules) = (Platform::under(&cells, 40.0)?, Rules::default());
/// let order = grow_by_heights(&cells, 5.0, &platform, &rules, None, &NozzleRule::default(), &heights, &|_| Continue(()))?;
/// assert!(order.growth.missed.is_empty());
/// assert_eq!([4, 0, 15].map(|cell| order.field.value(cell)), [0.5, 2.5, 5.5].map(Some));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[expect(clippy::too_many_arguments, reason = "as grow_by_distance, and the heights")]
pub fn grow_by_heights(
    cells: &Cells,
    cell_mm: f64,
    platform: &Platform,
    rules: &Rules,
    base: Option<&[u32]>,
    nozzle: &NozzleRule,
    heights: &[f64],
    progress: ProgressFn,
) -> Result<DistanceOrder, GrowthError> {
    let mut job = Job::new(cells, cell_mm, platform, rules, base, nozzle, progress)?;
    let len = cells.grid_len();
    if heights.len() != len || cells.iter().any(|cell| !heights[cell as usize].is_finite()) {
        return Err(GrowthError::Heights { len });
    }
    let lowest = cells.iter().map(|cell| heights[cell as usize]).fold(f64::INFINITY, f64::min);
    let values: Vec<f64> = heights.iter().map(|height| height - lowest + ON_BASE).collect();
    job.base.iter_mut().for_each(|(cell, value)| *value = values[*cell as usize]);
    let values = lifted(cells, &job.base, &values);
    if values.iter().any(|value| value.is_infinite()) {
        return Err(GrowthError::Heights { len });
    }
    let grown = job.grown(in_cells(cells, values))?;
    Ok(job.order(grown, 0))
}

struct Job<'a> {
    cells: &'a Cells<'a>,
    cell_mm: f64,
    platform: &'a Platform,
    rules: &'a Rules,
    nozzle: &'a NozzleRule,
    /// The cells that the order begins with, by rising number.
    base: Vec<OnBase>,
    progress: ProgressFn<'a>,
}

/// What came of a field.
#[derive(Clone)]
struct Grown {
    order: LayerOrder,
    printed: Vec<NozzleCell>,
    field: LayerField,
    /// Cells in no layer.
    left: usize,
    /// Those of them that something supported, by rising number.
    unreached: Vec<u32>,
    /// All that is built.
    obstacles: Obstacles,
}

impl<'a> Job<'a> {
    fn new(
        cells: &'a Cells<'a>,
        cell_mm: f64,
        platform: &'a Platform,
        rules: &'a Rules,
        given: Option<&[u32]>,
        nozzle: &'a NozzleRule,
        progress: ProgressFn<'a>,
    ) -> Result<Self, GrowthError> {
        check_growth(cells, cell_mm, platform, rules, nozzle)?;
        let mut standing = carried(cells, platform, rules);
        standing.retain(|cell| given.is_none_or(|given| given.binary_search(cell).is_ok()));
        match base(standing, cells, platform) {
            base if base.is_empty() => Err(GrowthError::NothingOnPlatform),
            base => Ok(Job { cells, cell_mm, platform, rules, nozzle, base, progress }),
        }
    }

    /// What is built of a field with these floors; what is in the way of cells that it does not reach gets floors, as long as that leaves fewer cells out. With
    /// the rounds that this took.
    fn delayed(&self, field: impl Fn(&Floors) -> LayerField) -> Result<(Grown, usize), GrowthError> {
        let &Job { cells, cell_mm, rules, nozzle, .. } = self;
        let mut best = self.grown(field(&Floors::none(cells)))?;
        let (mut rounds, mut last, mut floors) = (0, best.clone(), Floors::none(cells));
        for round in 1..=ROUNDS {
            if last.unreached.is_empty() || round > rounds + MAX_IDLE_ROUNDS + 1 {
                break;
            }
            let shape = (nozzle, cell_mm);
            delay(&mut floors, cells, &last.field, &last.unreached, &last.obstacles, shape, rules.neighbours);
            last = self.grown(field(&floors))?;
            if last.left < best.left {
                (best, rounds) = (last.clone(), round);
            }
        }
        Ok((best, rounds))
    }

    /// The order of what is built.
    fn order(&self, grown: Grown, rounds: usize) -> DistanceOrder {
        let Grown { order, mut printed, field, .. } = grown;
        printed.sort_unstable_by_key(|printed| printed.cell);
        let growth =
            Growth { missed: self.missed(&order), order, statistics: GrowthStatistics::default(), nozzle: printed };
        DistanceOrder { growth, field, rounds }
    }

    /// Builds what the nozzle reaches in the order of a field. Its values of cells that came a step early are changed to that step.
    fn grown(&self, field: LayerField) -> Result<Grown, GrowthError> {
        let &Job { cells, cell_mm, platform, rules, nozzle, ref base, progress } = self;
        let mut built = CellSet::none(cells);
        platform.mould().iter().flat_map(Cells::iter).for_each(|cell| _ = built.insert(cell));
        let obstacles = Obstacles::new(nozzle, cell_mm, f64::from(platform.top()) / 2.0, built.clone());
        let (directions, min_up) = (nozzle.directions(), nozzle.max_tilt.cos());
        let (order, last, printed) = (LayerOrder::new(), Vec::new(), Vec::new());
        let mut growing =
            Growing { cells, rules, field: &field, base, directions, min_up, built, obstacles, order, last, printed };
        let (mut values, mut unreached) = (field.values().to_vec(), Vec::new());
        let (total, mut done) = (cells.count() as u64, 0);
        for step in field.order().iter() {
            if progress(Progress { stage: "distance", done, total }).is_break() {
                return Err(GrowthError::Cancelled);
            }
            done += step.len() as u64;
            let (reached, mut late) = growing.judge(step);
            for (cell, value) in growing.join_last_step(&mut late) {
                values[cell as usize] = value;
            }
            unreached.extend(late);
            growing.build(reached);
        }
        growing.build_last_step();
        let Growing { order, printed, mut obstacles, .. } = growing;
        order.cells().iter().for_each(|&cell| obstacles.insert(cell));
        unreached.sort_unstable();
        let left = cells.count() - order.cells().len();
        let field = in_cells(cells, values).with_half_layers(field.half_layers());
        Ok(Grown { order, printed, field, left, unreached, obstacles })
    }

    /// The cells in no layer, with the reasons.
    fn missed(&self, order: &LayerOrder) -> Vec<MissedCell> {
        let solid = CellSet::of(self.cells);
        let feet: Vec<u32> = self.base.iter().map(|base| base.0).collect();
        let joined = joined(&solid, &feet, self.rules.neighbours);
        let mut missed = solid;
        missed.remove_all(order.cells().iter().copied());
        let reason = |cell: u32| match joined.contains(cell) {
            true => MissedReason::OutOfReach,
            false => MissedReason::NeverAdjacent,
        };
        missed.iter().map(|cell| MissedCell { cell, reason: reason(cell) }).collect()
    }
}

/// What is built of a part.
struct Growing<'a> {
    cells: &'a Cells<'a>,
    rules: &'a Rules,
    field: &'a LayerField,
    /// The cells that the order begins with, by rising number.
    base: &'a [OnBase],
    directions: Vec<UnitVector3<f64>>,
    /// Cosine of the tilt limit.
    min_up: f64,
    /// All that is built, the last step included.
    built: CellSet,
    /// What is in the way of the nozzle in the next step: the steps of `order`.
    obstacles: Obstacles,
    /// The steps but the last.
    order: LayerOrder,
    /// The last step, which later cells may join.
    last: Vec<NozzleCell>,
    /// The cells of `order` with their directions.
    printed: Vec<NozzleCell>,
}

// A step and the one before are a layer, which is not in its own way: so `last` is no obstacle of the next step.
const _: () = assert!(STEPS_PER_LAYER == 2);

impl Growing<'_> {
    /// Those of the cells that something supports: the ones that the nozzle reaches, and the others.
    fn judge(&self, step: &[u32]) -> (Vec<NozzleCell>, Vec<u32>) {
        let supported: Vec<u32> = step.iter().copied().filter(|&cell| self.is_supported(cell)).collect();
        let free = in_parallel(supported.len(), AT_A_TIME, |k| self.free_direction(supported[k]));
        let (mut reached, mut unreached) = (Vec::new(), Vec::new());
        for (cell, direction) in supported.into_iter().zip(free) {
            match direction {
                Some(direction) => reached.push(NozzleCell { cell, direction }),
                None => unreached.push(cell),
            }
        }
        (reached, unreached)
    }

    /// Moves those of the late cells into the last step that something supports and the nozzle reaches then. Returns them with the highest value of
    /// that step.
    fn join_last_step(&mut self, late: &mut Vec<u32>) -> Vec<(u32, f64)> {
        let Some(last) = self.last.first().filter(|_| !late.is_empty() && !self.order.is_empty()) else {
            return Vec::new();
        };
        let steps = f64::from(STEPS_PER_LAYER);
        let step = self.field.value(last.cell).map_or(0.0, |value| (value * steps).floor());
        // As it was when the last step was judged.
        let before = self.order.layer(self.order.len() - 1).to_vec();
        before.iter().for_each(|&cell| self.obstacles.remove(cell));
        self.last.iter().for_each(|last| self.built.remove(last.cell));
        let (early, _) = self.judge(late);
        before.iter().for_each(|&cell| self.obstacles.insert(cell));
        // Both rise.
        late.retain(|&cell| early.binary_search_by_key(&cell, |early| early.cell).is_err());
        let values = early.iter().map(|early| (early.cell, ((step + 1.0) / steps).next_down())).collect();
        self.last.extend(early);
        self.last.iter().for_each(|last| _ = self.built.insert(last.cell));
        values
    }

    /// Builds a step, unless it is empty.
    fn build(&mut self, reached: Vec<NozzleCell>) {
        if !reached.is_empty() {
            self.build_last_step();
            reached.iter().for_each(|reached| _ = self.built.insert(reached.cell));
            self.last = reached;
        }
    }

    /// Puts the last step into the order.
    fn build_last_step(&mut self) {
        let mut last = std::mem::take(&mut self.last);
        if !last.is_empty() {
            last.sort_unstable_by_key(|last| last.cell);
            last.iter().for_each(|last| self.obstacles.insert(last.cell));
            self.order.push(last.iter().map(|last| last.cell));
            self.printed.extend(last);
        }
    }

    fn is_supported(&self, cell: u32) -> bool {
        let offsets = self.rules.neighbours.offsets();
        self.base.binary_search_by_key(&cell, |base| base.0).is_ok()
            || self.built.around(cell, offsets).next().is_some()
    }

    /// The free direction nearest to the way in which the field rises: that itself, or one of the [fixed ones](NozzleRule::directions).
    fn free_direction(&self, cell: u32) -> Option<UnitVector3<f64>> {
        let rise = self.rise(cell);
        if rise.z >= self.min_up && self.obstacles.is_free(cell, &rise) {
            return Some(rise);
        }
        let is_free = |k: usize| self.obstacles.clears_plate(cell, k) && self.obstacles.hit(cell, k).is_none();
        let mut near: Vec<(f64, usize)> = self.directions.iter().map(|d| d.dot(&rise)).zip(0..).collect();
        near.retain(|&(cosine, _)| cosine >= MIN_COSINE);
        near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        near.into_iter().map(|(_, k)| k).find(|&k| is_free(k)).map(|k| self.directions[k])
    }

    /// The way in which the field rises at a cell; upward where it is level.
    fn rise(&self, cell: u32) -> UnitVector3<f64> {
        let own = self.field.value(cell).unwrap_or(0.0);
        let around = beside(self.cells, cell).map(|other| self.field.value(other?));
        UnitVector3::try_new(slope(own, around), 1e-9).unwrap_or_else(Vector3::z_axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A late cell joins the last step if a cell of an earlier one supports it; one that hangs on the last step alone stays late.
    #[test]
    fn late_cells_need_an_earlier_support() {
        // Cell 0 is built first, then 1; of the late ones 3 lies beside 0, and 2 beside 1 alone.
        let cells = Cells::new([3, 2, 1], &[0b111, 0b001]).unwrap();
        let field = super::super::in_cells(&cells, vec![0.5, 1.2, 1.6, 1.6, f64::NAN, f64::NAN]);
        let (nozzle, rules) = (NozzleRule::default(), Rules::default());
        let [mut built, mut first] = [CellSet::none(&cells), CellSet::none(&cells)];
        [0, 1].into_iter().for_each(|cell| _ = built.insert(cell));
        first.insert(0);
        let upright = |cell| NozzleCell { cell, direction: Vector3::z_axis() };
        let mut order = LayerOrder::new();
        order.push([0]);
        let mut growing = Growing {
            cells: &cells,
            rules: &rules,
            field: &field,
            base: &[(0, 0.5)],
            directions: nozzle.directions(),
            min_up: 0.0,
            built,
            obstacles: Obstacles::new(&nozzle, 1.0, -100.0, first),
            order,
            last: vec![upright(1)],
            printed: vec![upright(0)],
        };
        let mut late = vec![2, 3];
        assert_eq!(growing.join_last_step(&mut late), [(3, 1.5_f64.next_down())]);
        assert_eq!(late, [2]);
        assert!(growing.last.iter().map(|last| last.cell).eq([1, 3]));
        assert!([0, 1, 3].iter().all(|&cell| growing.built.contains(cell)) && growing.obstacles.set().contains(0));
    }
}
