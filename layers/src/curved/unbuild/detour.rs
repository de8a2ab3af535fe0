//! When a piece was stuck: the cells that must not carry it the next time.
//!
//! A cell `v` shadows a cell `w` all by itself when `w` lies inside the hull of the platform and `v`: when `v` lies in the
//! cone behind `w` that the platform, seen from `w`, casts. A piece that hangs on such cells is lost, so it has to be
//! reached on another way, if there is one.

use super::super::growth::GrowthError;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::accessibility::dot;
use crate::curved::buildable::body::{Centres, hull_of_platform};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use curvlay_hull::{Depth, Plane};

/// Number of cells that represent a piece. They decide for which cells a way around is looked for, not
/// what is built; more cost time for each cell of the part, and change little.
const SAMPLES: usize = 15;

/// A piece, and what must not carry it.
pub(super) struct Detour {
    pub(super) piece: Vec<u32>,
    pub(super) banned: CellSet,
    /// A cell is banned when it shadows more than one in so many of the samples.
    strictness: usize,
}

impl Detour {
    /// The loosest detour; a piece that is stuck in spite of it needs a [stricter](Detour::strictness) one.
    pub(super) const FIRST: usize = 2;
    /// From here on a cell is banned for any sample that it shadows.
    pub(super) const LAST: usize = 16;

    pub(super) fn new(
        piece: Vec<u32>,
        strictness: usize,
        cells: &Cells,
        platform: &Platform,
        rules: &Rules,
    ) -> Result<Self, GrowthError> {
        let centres = Centres::new(cells, rules);
        let samples = SAMPLES.min(piece.len());
        let cones = (0..samples)
            .map(|k| shadow(centres.of(piece[k * piece.len() / samples]), platform, rules))
            .collect::<Result<Vec<_>, _>>()?;
        let mut banned = CellSet::none(cells);
        for cell in cells.iter() {
            let p = centres.of(cell);
            let shadows = |cone: &&Vec<Plane>| cone.iter().all(|plane| dot(plane.normal, p) >= plane.offset);
            // More than one sample in `strictness`. A chain over this cell would shadow that much of the piece before it is built.
            if strictness * cones.iter().filter(shadows).count() > samples {
                banned.insert(cell);
            }
        }
        // The piece may stand on itself.
        banned.remove_all(piece.iter().copied());
        Ok(Detour { piece, banned, strictness })
    }

    /// How strict a detour for `piece` has to be if this one did not help it; none if this is about another piece.
    pub(super) fn stricter(&self, piece: &[u32]) -> Option<usize> {
        let same = self.piece.iter().any(|cell| piece.binary_search(cell).is_ok());
        same.then_some(2 * self.strictness)
    }
}

/// The planes of the cone behind `w`: what lies on or above all of them shadows `w`. The apex is raised by `eps`, since less
/// deep than that is not inside.
fn shadow(w: [i32; 3], platform: &Platform, rules: &Rules) -> Result<Vec<Plane>, GrowthError> {
    let mut hull = hull_of_platform(platform, rules, Depth::SURFACE)?;
    let raised = Plane::at([0, 0, 1], w, rules.depth()?).margin() as i32;
    let apex = [w[0], w[1], w[2] + raised];
    hull.insert(&[apex])?;
    Ok(hull.planes().filter(|plane| dot(plane.normal, apex) == plane.offset).collect())
}
