//! The hull of the platform and of cells.

use super::platform::Platform;
use super::rules::Rules;
use crate::cells::Cells;
use curvlay_hull::{ConvexHull, Depth, HullError};

/// Half the length, in lattice units, of the bars that cells of a flat object stand for: so long that their ends are
/// farther from every centre than the largest depth, so short that they stay where hulls are exact.
const HALF_BAR: i32 = 1 << 14;

/// How cells of a grid stand for points of a hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Centres {
    dims: [u32; 3],
    flat: bool,
}

impl Centres {
    pub(crate) fn new(cells: &Cells, rules: &Rules) -> Self {
        Centres { dims: cells.dims(), flat: rules.flat }
    }

    /// The lattice point at the centre of a cell.
    pub(crate) fn of(self, cell: u32) -> [i32; 3] {
        let [nx, ny, _] = self.dims;
        [cell % nx, cell / nx % ny, cell / nx / ny].map(|c| 2 * c as i32 + 1)
    }

    /// The cell whose centre, or an end of whose bar, is the lattice point `p`.
    pub(crate) fn cell_at(self, [x, y, z]: [i32; 3]) -> Option<u32> {
        let y = if self.flat { y + if y < 0 { HALF_BAR } else { -HALF_BAR } } else { y };
        let index = |place: i32, side: u32| {
            let index = u32::try_from(place - 1).ok().filter(|doubled| doubled % 2 == 0)? / 2;
            (index < side).then_some(index)
        };
        let [nx, ny, _] = self.dims;
        Some(index(x, nx)? + nx * (index(y, ny)? + ny * index(z, self.dims[2])?))
    }

    /// The row of a cell.
    pub(crate) fn row(self, cell: u32) -> u32 {
        cell / self.dims[0]
    }

    /// Inserts the cells into a hull: their centres, or the ends of the bars that they stand for.
    pub(crate) fn insert(self, cells: &[u32], hull: &mut ConvexHull) -> Result<(), HullError> {
        // A cell between its two neighbours in a row is no corner of anything.
        let between = |at: usize| {
            let cell = cells[at];
            let neighbours = at.checked_sub(1).and_then(|before| Some((*cells.get(before)?, *cells.get(at + 1)?)));
            neighbours.is_some_and(|(before, after)| {
                before + 1 == cell && cell + 1 == after && self.row(before) == self.row(after)
            })
        };
        let centres = (0..cells.len()).filter(|&at| !between(at)).map(|at| self.of(cells[at]));
        let points: Vec<_> = if self.flat {
            centres.flat_map(|[x, y, z]| [[x, y - HALF_BAR, z], [x, y + HALF_BAR, z]]).collect()
        } else {
            centres.collect()
        };
        hull.insert(&points).map(|_| ())
    }
}

/// The hull of the platform and its mould.
pub(crate) fn hull_of_platform(platform: &Platform, rules: &Rules, depth: Depth) -> Result<ConvexHull, HullError> {
    let corners: Vec<_> = if rules.flat {
        platform.corners().iter().flat_map(|&[x, _]| [[x, 1 - HALF_BAR], [x, 1 + HALF_BAR]]).collect()
    } else {
        platform.corners().to_vec()
    };
    let mut hull = if platform.reaches_down() {
        ConvexHull::column(&corners, platform.top(), depth)?
    } else {
        let mut plate = ConvexHull::new(depth);
        plate.insert(&corners.iter().map(|&[x, y]| [x, y, platform.top()]).collect::<Vec<_>>())?;
        plate
    };
    hull.insert(&points_of_mould(platform, rules))?;
    Ok(hull)
}

/// What the mould of a platform puts into every hull.
pub(crate) fn points_of_mould(platform: &Platform, rules: &Rules) -> Vec<[i32; 3]> {
    let corners = platform.mould.as_ref().map_or(&[][..], |mould| mould.corners());
    if rules.flat {
        return corners.iter().flat_map(|&[x, y, z]| [[x, y - HALF_BAR, z], [x, y + HALF_BAR, z]]).collect();
    }
    corners.to_vec()
}
