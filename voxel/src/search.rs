//! The grid that gives a wanted number of cells.
//!
//! A solid of volume `V` and area `A` has about `V / h^3 + 3/4 A / h^2` cells of edge `h`: a touched cell reaches
//! half a cell out, and the mean over all directions of `|nx| + |ny| + |nz|` is 3/2. That model, scaled to each
//! count found, brackets the size; then regula falsi in logarithms, safeguarded by halving, closes in. The count
//! jumps where a flat face passes a plane of the grid; the numbers between are looked for by moving the grid along
//! x and y, at the sizes on both sides of the jump.

use crate::solid::{Solid, Trial};
use crate::{TooFine, VoxelError};

/// The search ends when the count is off by less than one in so many: ten times nearer than the 1 % that is meant,
/// reached in three to five trials where the count is smooth.
const NEAR: u64 = 1000;

/// Places of the grid are tried while the count is off by more than one in so many: a jump at a flat face is most
/// often wider than this, and each place costs as much as a size.
const FAIR: u64 = 400;

/// Most sizes to try. Each halves the bracket at least every other time: enough to follow a jump down to a thousandth
/// of the size, past which only the place of the grid helps.
const SIZES: usize = 14;

/// Relative width of the bracket at which the count is taken to jump within it.
const JUMP: f64 = 1e-4;

/// Places of the grid to try at each side of a jump: quarters of a cell in x and y, far ones first.
const PLACES: [[f64; 2]; 15] = [
    [0.5, 0.5],
    [0.5, 0.0],
    [0.0, 0.5],
    [0.25, 0.25],
    [0.75, 0.25],
    [0.25, 0.75],
    [0.75, 0.75],
    [0.25, 0.0],
    [0.0, 0.25],
    [0.75, 0.0],
    [0.0, 0.75],
    [0.5, 0.25],
    [0.25, 0.5],
    [0.5, 0.75],
    [0.75, 0.5],
];

/// A size of cells, and how many it gives.
type Found = (f64, f64);

struct Search<'s, 'a> {
    solid: &'s mut Solid<'a>,
    wanted: u64,
    best: Option<Trial>,
    trials: usize,
    refused: Option<VoxelError>,
}

/// The trial whose number of cells is nearest to `wanted`, the first of equals, and how many were made.
pub(crate) fn nearest(solid: &mut Solid<'_>, wanted: u64) -> Result<(Trial, usize), VoxelError> {
    let mut search = Search { solid, wanted, best: None, trials: 0, refused: None };
    if search.solid.is_on_the_plate() {
        return Err(VoxelError::Nothing { cell_mm: search.model_size(wanted as f64) });
    }
    let [few, many] = search.bracket()?;
    for size in [few, many].into_iter().flatten() {
        for place in PLACES {
            if search.is_within(FAIR) || search.refused.is_some() {
                break;
            }
            search.count(size.0, place)?;
        }
    }
    let Search { solid, best, trials, refused, .. } = search;
    let refused = refused.map(|refused| match refused {
        VoxelError::TooFine(TooFine { fits_mm, cause, .. }) => {
            VoxelError::TooMany { wanted, fits: solid.model(fits_mm) as u64, cause }
        }
        other => other,
    });
    match (best, refused) {
        // Nearer there are only grids that are refused.
        (Some(best), Some(refused)) if best.count() > 0 && best.count() < wanted - wanted / 100 => Err(refused),
        (Some(best), _) => Ok((best, trials)),
        (None, refused) => Err(refused.unwrap_or(VoxelError::NoCount)),
    }
}

impl Search<'_, '_> {
    /// Closes in on the size at the first place of the grid. Returns the nearest sizes found with at most and with at
    /// least the wanted number of cells, each with that number.
    fn bracket(&mut self) -> Result<[Option<Found>; 2], VoxelError> {
        let wanted = self.wanted as f64;
        let (mut few, mut many): (Option<Found>, Option<Found>) = (None, None);
        let mut size = self.model_size(wanted);
        for round in 0..SIZES {
            let count = self.count(size, [0.0; 2])?;
            if self.is_within(NEAR) {
                break;
            }
            match count {
                Some(count) if count <= wanted => few = Some((size, count)),
                // A grid that is refused is one of too many cells.
                count => many = Some((size, count.unwrap_or(f64::INFINITY))),
            }
            size = match (few, many) {
                // Towards a grid that is refused only the model leads; if it leads past that, there is no way.
                (Some((large, low)), Some((small, f64::INFINITY))) => {
                    let size = large * self.ratio(large, wanted / low);
                    if size <= small {
                        break;
                    }
                    size
                }
                (Some((large, low)), Some((small, high))) => {
                    if large / small < 1.0 + JUMP {
                        break;
                    }
                    let straight = (wanted / low).ln() / (high / low).ln();
                    let part = if round % 3 == 2 { 0.5 } else { straight.clamp(0.02, 0.98) };
                    large * (small / large).powf(part)
                }
                // Aim a little past the wanted number, to see its other side.
                (Some((size, count)), None) => size * self.ratio(size, wanted / count.max(0.5) * 1.01).min(0.99999),
                // More cells than any grid has; a look at the largest ones would take long and change nothing.
                (None, Some((_, f64::INFINITY))) if self.wanted >> 32 > 0 => break,
                (None, Some((size, f64::INFINITY))) => size * 4.0,
                (None, Some((size, count))) => size * self.ratio(size, wanted / count * 0.99).max(1.00001),
                (None, None) => break,
            };
        }
        Ok([few, many])
    }

    /// By what the size must be multiplied so that the model grows by `factor`.
    fn ratio(&self, size: f64, factor: f64) -> f64 {
        self.model_size(self.solid.model(size) * factor) / size
    }

    /// Size of the cells that gives so many, by the model: by halving, since it falls with the size.
    fn model_size(&self, count: f64) -> f64 {
        // From ten orders below the part, where all grids are refused, to cells much wider than it.
        let (mut small, mut large) = (self.solid.size() * 1e-10, self.solid.size() * 64.0);
        for _ in 0..100 {
            let middle = (small * large).sqrt();
            *(if self.solid.model(middle) > count { &mut small } else { &mut large }) = middle;
        }
        large
    }

    /// Number of cells for a size and a place; none if the grid is refused.
    fn count(&mut self, size: f64, place: [f64; 2]) -> Result<Option<f64>, VoxelError> {
        let go_on = self.solid.go_on("voxelise");
        let (done, all) = (self.trials as u64, (SIZES + 2 * PLACES.len()) as u64);
        go_on(done, all).ok_or(VoxelError::Cancelled)?;
        // Trials report their number only, and can be cancelled.
        let trial = match self.solid.trial(size, place, &|_, _| go_on(done, all)) {
            Err(refused @ (VoxelError::Grid(_) | VoxelError::TooFine(_))) => {
                self.refused = Some(refused);
                return Ok(None);
            }
            trial => trial?,
        };
        self.trials += 1;
        let count = trial.count();
        let off = |trial: &Trial| trial.count().abs_diff(self.wanted);
        if self.best.as_ref().is_none_or(|best| off(&trial) < off(best)) {
            self.best = Some(trial);
        }
        Ok(Some(count as f64))
    }

    /// Whether the best count is off by no more than one in so many.
    fn is_within(&self, part: u64) -> bool {
        self.best.as_ref().is_some_and(|best| best.count().abs_diff(self.wanted) <= self.wanted / part)
    }
}
