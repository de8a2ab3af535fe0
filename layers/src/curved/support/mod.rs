//! Support for what no order reaches, as cells that are grown with the part.
//!
//! Dai 2020, Fig. 3.17c, adds support below regions that stay missed. Here support is cells outside of the part, so the part and its support
//! are one solid, grown and audited by the rules of every other order: each cell is supported and nothing is shadowed. A column below the lowest
//! hanging cell of a missed region lets it be built from below, before what would shadow it.
//!
//! In each round every region of missed cells that hang together gets one column, below the lowest of its cells that has nothing under it, of several the one in their middle: the
//! [shortest way down](column) to the plate, to the part, or to support that is there, so that columns become trees. Then part and support are grown
//! anew. Rounds end when nothing is missed or no column can be added. Support that is missed itself is left out in the end.
//!
//! Cells can be given that hold support in any case: those below beads that were found to lie on nothing ([`Guides::support`](super::Guides::support)).
//!
//! # Contact
//! A cell at the skin is of the part, and has room beside its material. Where a column ends at one support goes on in it up to the mesh: else up to a cell
//! would be between the two, several layers. What stands over the plate by less than a cell has support in its own cells alone.
//!
//! # Gaps
//! So that support comes off, its columns touch the part with few cells ([`SupportOptions::contact`]), or end a few levels short of it
//! ([`SupportOptions::gap`]). The cells of a gap are grown and audited like all others, and stay empty when it comes to surfaces. That is the rule by which
//! a gap counts as support: a cell is carried by what lies no more than so many empty levels below it.

mod column;
mod mesh;

pub use mesh::{CellMesh, cell_mesh};

use super::growth::{Growth, GrowthError};
use crate::cells::{CellSet, Cells, CellsError};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::{Neighbours, Rules};
use crate::curved::buildable::runs::Runs;
use crate::{Progress, ProgressFn};
use column::{DOWN, Ground, moved};
use std::collections::BTreeMap;

/// What support looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct SupportOptions {
    /// Width of a column, in cells. Default 3: with less it is not stiff enough to print on, with more it costs material. Columns are
    /// as wide only where they do not touch the part: there they are as wide as `contact`. A column is narrower, down to that, where it would
    /// take more than half of the cells of straight columns below its region: low ones are stiff enough.
    pub width: u32,
    /// Width of a column where it touches the part, in cells: 1, so that it breaks off. No more than `width`.
    pub contact: u32,
    /// Levels that stay empty between a column and the part above it, and below it where it stands on the part: 0. Material bridges one
    /// of the height of a bead, not more. A column of no more levels than its gaps is printed whole.
    pub gap: u32,
    /// Rounds at most. Default 8. Each grows all cells anew; the parts that we know take one or two.
    pub rounds: u32,
}

impl Default for SupportOptions {
    fn default() -> Self {
        SupportOptions { width: 3, contact: 1, gap: 0, rounds: 8 }
    }
}

/// Why there is no support.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SupportError {
    /// Columns of no width, or wider than any part.
    #[error("support that is {width} cells wide: its width must lie between 1 and {}", SupportOptions::MAX_WIDTH)]
    Width {
        /// The width, in cells.
        width: u32,
    },
    /// Columns that touch the part nowhere, or are wider there than elsewhere.
    #[error(
        "support that touches the part with {contact} cells: it must be 1 or more, and at most the width of {width}"
    )]
    Contact {
        /// The width where it touches, in cells.
        contact: u32,
        /// The width elsewhere.
        width: u32,
    },
    /// A gap higher than any column is wide.
    #[error("a gap of {gap} cells between support and part: it must be at most {}", SupportOptions::MAX_WIDTH)]
    Gap {
        /// The gap, in cells.
        gap: u32,
    },
    /// The part cannot be grown with its support.
    #[error(transparent)]
    Growth(#[from] GrowthError),
    /// The cells cannot be united with their support.
    #[error(transparent)]
    Cells(#[from] CellsError),
}

/// Why there is no support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum NoSupport {
    /// No cell is missed.
    #[error("no cell is missed: there is nothing to support")]
    NotNeeded,
    /// It is forbidden everywhere: no options for it, or no rounds.
    #[error("support is forbidden: allow it, let the nozzle build the cells, or turn the part")]
    Forbidden,
    /// No column finds a place.
    #[error(
        "support finds no place: the missed cells lie on the part, or there is no plate below them; turn the part, or take a wider plate"
    )]
    NoPlace,
    /// Columns were placed, and as many cells are missed with them.
    #[error("support does not help: as many cells are missed with it; let the nozzle build them, or turn the part")]
    NoHelp,
    /// Part and support together do not pass the audit.
    #[error("support was left out, since part and support together do not pass the audit; turn the part")]
    Unsound,
}

impl SupportOptions {
    /// Greatest width of a column and greatest gap, in cells.
    pub const MAX_WIDTH: u32 = 64;

    fn check(&self) -> Result<(), SupportError> {
        let SupportOptions { width, contact, gap, .. } = *self;
        if !(1..=SupportOptions::MAX_WIDTH).contains(&width) {
            return Err(SupportError::Width { width });
        }
        if !(1..=width).contains(&contact) {
            return Err(SupportError::Contact { contact, width });
        }
        if gap > SupportOptions::MAX_WIDTH { Err(SupportError::Gap { gap }) } else { Ok(()) }
    }
}

/// A part with its support.
#[derive(Clone, Debug, PartialEq)]
pub struct Supported {
    /// The cells of part and support together, gaps included, as [`Cells`] takes them.
    pub rows: Vec<u64>,
    /// The order of both. What it misses belongs to the part.
    pub growth: Growth,
    /// The cells of the support, by rising number; they are all in the order.
    pub support: Vec<u32>,
    /// The cells between support and part that stay empty, by rising number; they are in the order as well.
    pub gap: Vec<u32>,
    /// Cells of the part at which columns end, by rising number: beside the part's material they hold support. None with a gap.
    pub contact: Vec<u32>,
    /// Cells that straight columns from the plate would have, below all cells that were missed: to compare with.
    pub straight_cells: usize,
    /// Rounds that it took.
    pub rounds: u32,
}

/// Adds support below what an order misses, until nothing is missed or no more support can be added.
///
/// # Arguments
/// * `growth`: of `cells`; what it misses is to be supported.
/// * `given`: cells that hold support in any case, those of the part beside its material.
/// * `grow`: grows the part with its support, e.g. by the strategy of the first growth.
/// * `progress`: called with the stage `support`, the rounds done and those allowed; may cancel.
///
/// # Returns
/// The part with its support, of the round that missed the fewest cells. If no round missed fewer than `growth`, why.
///
/// # Errors
/// [`SupportError`].
///
/// # Cost
/// That of `grow` for each round. The columns cost a few microseconds a cell.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Rules, Strategy, SupportOptions, add_support};
/// use std::ops::ControlFlow::Continue;
/// // A mast of 9 cells with an arm at its top, from the end of which 3 cells hang down: two of them lie inside the hull.
/// let (dims, mut rows) = ([7, 1, 9], vec![0b000_0001; 9]);
/// rows[8] = 0b111_1111;
/// (5..8).for_each(|z| rows[z] |= 0b100_0000);
/// let cells = Cells::new(dims, &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 20.0)?, Rules::default());
/// let grow = |cells: &Cells| Strategy::Incremental.grow(cells, &platform, &rules, &|_| Continue(()));
/// let growth = grow(&cells)?;
/// assert_eq!(growth.missed.len(), 2);
/// let options = SupportOptions { width: 1, ..SupportOptions::default() };
/// let supported = add_support(&cells, &platform, &rules, &growth, &[], &options, &grow, &|_| Continue(()))?.expect("support");
/// assert!(supported.growth.missed.is_empty());
/// assert_eq!(supported.support, [6, 13, 20, 27, 34]); // five cells below the hanging end
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[expect(clippy::too_many_arguments, reason = "a part, its order and what is given of its support")]
pub fn add_support(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    growth: &Growth,
    given: &[u32],
    options: &SupportOptions,
    grow: &dyn Fn(&Cells) -> Result<Growth, GrowthError>,
    progress: ProgressFn,
) -> Result<Result<Supported, NoSupport>, SupportError> {
    options.check()?;
    if growth.missed.is_empty() && given.is_empty() {
        return Ok(Err(NoSupport::NotNeeded));
    }
    let size = cells.dims().iter().fold(1, |size, &side| size * u64::from(side));
    let is_own = |cell: u32| u64::from(cell) < size && cells.contains(cells.position(cell));
    let mut missed = growth.missed_cells();
    let is_in_grid = |cell: u32| u64::from(cell) < size;
    let wrong = missed.iter().find(|&&cell| !is_own(cell)).or_else(|| given.iter().find(|&&cell| !is_in_grid(cell)));
    if let Some(&cell) = wrong {
        return Err(GrowthError::OtherCells { cell }.into());
    }
    let outside = given.iter().filter(|&&cell| !is_own(cell)).count();
    let straight_cells = straight_columns(cells, &missed) + outside;
    let none = || CellSet::none(cells);
    let mut columns = Columns { support: none(), gap: none(), contact: none() };
    // A round must miss fewer cells than the order without support, or the round is not worth its support.
    let mut fewest = missed_bound(missed.len(), given);
    let mut best: Option<Supported> = None;
    let mut why_not = NoSupport::Forbidden;
    // Columns of earlier rounds stay: each round adds to them below what is still missed.
    for round in 1..=options.rounds {
        let (done, total) = (u64::from(round - 1), u64::from(options.rounds));
        if progress(Progress { stage: "support", done, total }).is_break() {
            return Err(GrowthError::Cancelled.into());
        }
        let is_new = round == 1 && columns.add_given(cells, given, options);
        if !columns.add_below(cells, platform, rules, &missed, options) && !is_new {
            if round == 1 {
                why_not = NoSupport::NoPlace;
            }
            break;
        }
        why_not = NoSupport::NoHelp;
        let of_round = grown(cells, &columns.support, grow)?;
        missed = of_round.missed_cells();
        // Support that is missed itself needs no support: it is left out in the end.
        missed.retain(|&cell| cells.contains(cells.position(cell)));
        if missed.len() < fewest {
            fewest = missed.len();
            best = Some(of_part(cells, of_round, &columns, straight_cells, round));
        }
        if missed.is_empty() {
            break;
        }
    }
    Ok(best.ok_or(why_not))
}

/// Support is worth it if fewer cells are missed with it than this: fewer than without, or no more where it was asked for.
pub(super) fn missed_bound(missed: usize, given: &[u32]) -> usize {
    missed + usize::from(!given.is_empty())
}

impl Supported {
    /// Takes the support out that its growth misses; whether there was any. Missed cells are then those of the part.
    pub(super) fn remove_missed(&mut self, cells: &Cells) -> bool {
        let Supported { rows, growth, support, gap, contact, .. } = self;
        let before = support.len() + gap.len();
        support.retain(|&cell| is_built(growth, cell));
        gap.retain(|&cell| is_built(growth, cell));
        growth.missed.retain(|missed| cells.contains(cells.position(missed.cell)));
        let mut united = CellSet::of(cells);
        support.iter().chain(&*gap).for_each(|&cell| _ = united.insert(cell));
        *rows = united.rows().flatten().copied().collect();
        let is_less = support.len() + gap.len() < before;
        let is_beside = |cell: u32| {
            let mut beside = Neighbours::FaceOrEdge.offsets().iter().filter_map(|&step| moved(cells, cell, step));
            beside.any(|beside| support.binary_search(&beside).is_ok())
        };
        // Without support beside it the part does not end at this cell any more, unless that one stands on the plate.
        let is_left = |cell: u32| !is_less || cells.position(cell)[2] == 0 || is_beside(cell);
        contact.retain(|&cell| is_built(growth, cell) && is_left(cell));
        is_less
    }
}

fn is_built(growth: &Growth, cell: u32) -> bool {
    growth.missed.binary_search_by_key(&cell, |missed| missed.cell).is_err()
}

/// Part and support, less the support that was missed: without it the order is the same.
fn of_part(cells: &Cells, growth: Growth, columns: &Columns, straight_cells: usize, rounds: u32) -> Supported {
    let (gap, support) = columns.support.iter().partition(|&cell| columns.gap.contains(cell));
    let contact = columns.contact.iter().collect();
    let mut supported = Supported { rows: Vec::new(), growth, support, gap, contact, straight_cells, rounds };
    supported.remove_missed(cells);
    if supported.support.is_empty() {
        // A column that is gap alone would hold nothing: it is printed.
        std::mem::swap(&mut supported.gap, &mut supported.support);
    }
    supported
}

/// Grows the part with its support.
fn grown(
    cells: &Cells,
    support: &CellSet,
    grow: &dyn Fn(&Cells) -> Result<Growth, GrowthError>,
) -> Result<Growth, SupportError> {
    let mut united = CellSet::of(cells);
    support.iter().for_each(|cell| _ = united.insert(cell));
    let rows: Vec<u64> = united.rows().flatten().copied().collect();
    Ok(grow(&Cells::new(cells.dims(), &rows)?)?)
}

/// The columns so far.
struct Columns {
    /// All their cells.
    support: CellSet,
    /// Those of them that stay empty.
    gap: CellSet,
    /// Cells of the part at which they end.
    contact: CellSet,
}

impl Columns {
    /// Adds cells that are given; whether any is new. Those that are no farther from the part than the gap stay empty.
    fn add_given(&mut self, cells: &Cells, given: &[u32], options: &SupportOptions) -> bool {
        let is_of_part = |cell: u32| cells.contains(cells.position(cell));
        let gap = options.gap as i32;
        let is_near = |cell: u32| {
            let mut steps = (1..=gap).flat_map(|k| [[0, 0, k], [0, 0, -k]]);
            steps.any(|step| moved(cells, cell, step).is_some_and(is_of_part))
        };
        let mut is_new = false;
        for &cell in given {
            if is_of_part(cell) {
                is_new |= gap == 0 && self.contact.insert(cell);
            } else {
                is_new |= self.support.insert(cell);
                if is_near(cell) {
                    self.gap.insert(cell);
                }
            }
        }
        is_new
    }

    /// Adds a column below the lowest hanging cell of each region of missed cells; whether there is any new cell.
    fn add_below(
        &mut self,
        cells: &Cells,
        platform: &Platform,
        rules: &Rules,
        missed: &[u32],
        options: &SupportOptions,
    ) -> bool {
        let mut built = CellSet::of(cells);
        built.remove_all(missed.iter().copied());
        let mut regions = CellSet::none(cells);
        missed.iter().filter(|&&cell| cells.contains(cells.position(cell))).for_each(|&cell| _ = regions.insert(cell));
        let runs = Runs::new(&regions, rules.neighbours);
        let mut ground = Ground { cells, platform, rules, built: &built, support: self.support.clone() };
        let mut is_new = false;
        for region in 0..runs.count() {
            let of_region: Vec<u32> = runs.cells(|piece| piece == region).collect();
            let hanging = of_region.iter().copied().filter(|&cell| hangs(&ground, cell)).collect();
            let hanging = middle_first(cells, hanging);
            let below = |cell: u32| Some((cell, ground.column_below(cell)?));
            // The first of them that has a way down: one column a region and round, since more may follow from what is then still missed.
            let Some((top, column)) = hanging.into_iter().find_map(below) else { continue };
            let levels = thick_enough(&ground, &column, options, straight_columns(cells, &of_region) / 2);
            is_new |= self.add(&mut ground, (top, &column), levels, options);
        }
        is_new
    }

    /// Adds a column below the cell `top`, as thick as its levels are; whether there is any new cell.
    fn add(
        &mut self,
        ground: &mut Ground,
        (top, column): (u32, &[u32]),
        levels: Vec<Vec<u32>>,
        options: &SupportOptions,
    ) -> bool {
        let mut is_new = false;
        let gap = options.gap as usize;
        let end = column.last().copied().filter(|&end| ground.lands_on_part(end));
        let bottom = end.map_or(0, |_| gap);
        // A column shorter than its gaps is printed whole: a gap alone would hold nothing.
        let printed = if gap + bottom < levels.len() { gap..levels.len() - bottom } else { 0..levels.len() };
        for (level, cells) in levels.into_iter().enumerate() {
            for cell in cells {
                is_new |= ground.support.insert(cell);
                // Where columns overlap, a cell that one of them prints is printed.
                if printed.contains(&level) {
                    self.gap.remove(cell);
                } else if !self.support.contains(cell) {
                    self.gap.insert(cell);
                }
                self.support.insert(cell);
            }
        }
        if gap == 0 {
            let under = end.and_then(|end| ground.carrier_below(end));
            [Some(top), under].into_iter().flatten().for_each(|cell| is_new |= self.contact.insert(cell));
        }
        is_new
    }
}

/// The cells lowest first, and in each level those first that are nearest to the middle of the lowest ones.
fn middle_first(cells: &Cells, mut hanging: Vec<u32>) -> Vec<u32> {
    let place = |cell: u32| cells.position(cell).map(i64::from);
    let Some(lowest) = hanging.iter().map(|&cell| place(cell)[2]).min() else { return hanging };
    let low: Vec<[i64; 3]> = hanging.iter().map(|&cell| place(cell)).filter(|at| at[2] == lowest).collect();
    let (count, sum) = (low.len() as i64, |axis: usize| low.iter().map(|at| at[axis]).sum::<i64>());
    let middle = [sum(0), sum(1)];
    // In wholes: the distances times the number of the lowest cells.
    let aside = |at: [i64; 3]| (0..2).map(|k| i128::from(count * at[k] - middle[k]).pow(2)).sum::<i128>();
    hanging.sort_by_key(|&cell| (place(cell)[2], aside(place(cell)), cell));
    hanging
}

/// Whether nothing is below a cell, neither straight nor over an edge.
fn hangs(ground: &Ground, cell: u32) -> bool {
    let is_below = |&step: &[i32; 3]| {
        ground.step(cell, step).is_some_and(|below| ground.is_of_part(below) || ground.support.contains(below))
    };
    ground.cells.position(cell)[2] > 0 && !DOWN.iter().any(is_below)
}

/// A column as wide as it may be with no more than `most` cells; where even the narrowest has more, that one.
fn thick_enough(ground: &Ground, column: &[u32], options: &SupportOptions, most: usize) -> Vec<Vec<u32>> {
    let mut width = options.width;
    loop {
        let levels = thickened(ground, column, &SupportOptions { width, ..*options });
        // No thicker than half of what straight columns below the region would take.
        if width == options.contact || levels.iter().map(Vec::len).sum::<usize>() <= most {
            return levels;
        }
        width -= 1;
    }
}

/// A column and the cells around it, level by level. Those that touch the part are nearer to its middle.
fn thickened(ground: &Ground, column: &[u32], options: &SupportOptions) -> Vec<Vec<u32>> {
    let ends = |width: u32| -((width - 1) as i32 / 2)..=(width / 2) as i32;
    let [all, touching] = [options.width, options.contact].map(ends);
    let touches = |cell: u32| {
        let is_beside = |&step: &[i32; 3]| ground.step(cell, step).is_some_and(|beside| ground.is_of_part(beside));
        ground.rules.neighbours.offsets().iter().any(is_beside)
    };
    let thick = |&core: &u32| {
        let mut of_level = vec![core];
        let mut done = 0;
        // From neighbour to neighbour, so that nothing stands apart.
        while let Some(&cell) = of_level.get(done) {
            done += 1;
            for step in [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]] {
                let Some(next) = ground.step(cell, step) else { continue };
                let (from, to) = (ground.cells.position(core), ground.cells.position(next));
                let is_within = |ends: &std::ops::RangeInclusive<i32>| {
                    (0..2).all(|k| ends.contains(&(to[k] as i32 - from[k] as i32)))
                };
                let is_free = is_within(&all) && !ground.is_of_part(next) && (is_within(&touching) || !touches(next));
                if is_free && !of_level.contains(&next) {
                    of_level.push(next);
                }
            }
        }
        of_level
    };
    column.iter().map(thick).collect()
}

/// Empty cells below the lowest missed cell of each column of the grid.
fn straight_columns(cells: &Cells, missed: &[u32]) -> usize {
    let level = cells.dims()[0] * cells.dims()[1];
    let mut lowest = BTreeMap::new();
    for &cell in missed {
        let z = lowest.entry(cell % level).or_insert(cell / level);
        *z = (*z).min(cell / level);
    }
    let empty =
        |(&column, &z): (&u32, &u32)| (0..z).filter(|z| !cells.contains(cells.position(column + z * level))).count();
    lowest.iter().map(empty).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_from_the_lowest_level_up_and_from_the_middle_outward() {
        let rows = [0b111_1111, 0b111_1110, 0b111_1111]; // three levels of a row of seven, without one cell of the middle level
        let cells = Cells::new([7, 1, 3], &rows).unwrap();
        let hanging: Vec<u32> = (7..21).filter(|&cell| cell != 7).collect();
        // The lowest six have their middle at 3.5; those above go by it, too.
        let level = |first: u32, places: &[u32]| places.iter().map(|place| first + place).collect::<Vec<_>>();
        let expected = [level(7, &[3, 4, 2, 5, 1, 6]), level(14, &[3, 4, 2, 5, 1, 6, 0])].concat();
        assert_eq!(middle_first(&cells, hanging), expected);
    }
}
