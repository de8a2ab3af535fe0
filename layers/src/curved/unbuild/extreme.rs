//! The cells that can come off next, each with the plane that proves it.
//!
//! A cell in the skin lies less than `eps` below a plane of the hull, and all that remains lies below that plane. With
//! `eps = 0` nothing on a face may count, or two cells of one face could each claim to be the outer one: then only the
//! corners come off, and the plane touches the hull in nothing but the corner.

use super::super::growth::GrowthError;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::body::Centres;
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::shell::ShellFinder;
use curvlay_hull::{ConvexHull, Depth, Hint};
use std::collections::BTreeMap;

/// All of a set lies below `normal . p < normal . c + margin`, where `c` is the cell that the proof is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Proof {
    pub(super) normal: [i64; 3],
    pub(super) margin: i64,
}

/// Finds the extreme cells of what remains.
pub(crate) struct Extremes<'a> {
    skin: ShellFinder<'a>,
    centres: Centres,
    rules: &'a Rules,
    /// Cells on a face of the hull count as inside: `eps` is 0.
    corners_only: bool,
    hint: Hint,
    hull: ConvexHull,
    /// If so, the directions in which each corner is the farthest point.
    corners: BTreeMap<u32, [i64; 3]>,
}

impl<'a> Extremes<'a> {
    pub(crate) fn new(cells: &Cells, platform: &'a Platform, rules: &'a Rules) -> Result<Self, GrowthError> {
        let depth = rules.depth()?;
        let skin = ShellFinder::new(cells, platform, rules, depth)?;
        let hull = skin.hull(&CellSet::none(cells))?;
        let centres = Centres::new(cells, rules);
        let corners_only = depth == Depth::SURFACE;
        Ok(Extremes { skin, centres, rules, corners_only, hint: Hint::default(), hull, corners: BTreeMap::new() })
    }

    /// The extreme cells of `rest`, by rising number.
    pub(crate) fn find(&mut self, rest: &CellSet) -> Result<Vec<u32>, GrowthError> {
        self.hull = self.skin.hull(rest)?;
        if !self.corners_only {
            return Ok(self.skin.cells(&self.hull, rest));
        }
        self.corners = self.corners(rest);
        Ok(self.corners.keys().copied().collect())
    }

    /// The corners of the hull that are cells, with the sum of the normals of the faces that meet there.
    fn corners(&self, rest: &CellSet) -> BTreeMap<u32, [i64; 3]> {
        let mut corners: BTreeMap<u32, [i64; 3]> = BTreeMap::new();
        for face in self.hull.faces() {
            // The ends of the bars that stand for the cells of a flat object are no faces of the object.
            if self.rules.flat && face.normal[1] != 0 {
                continue;
            }
            for cell in face.corners.iter().filter_map(|&corner| self.centres.cell_at(corner)) {
                if rest.contains(cell) {
                    // The sum of the normals of faces at a corner points strictly out of the hull there: the plane across it touches in
                    // the corner alone.
                    let sum = corners.entry(cell).or_insert([0; 3]);
                    (0..3).for_each(|axis| sum[axis] += face.normal[axis]);
                }
            }
        }
        corners
    }

    /// The proof for one of the cells that [`Extremes::find`] found last.
    pub(super) fn proof(&mut self, cell: u32) -> Proof {
        match self.corners.get(&cell) {
            Some(&normal) => Proof { normal, margin: 0 },
            None => {
                // Reduced, so that equal planes are equal numbers: cells with one normal share a plane.
                let plane = self.hull.witness(self.centres.of(cell), &mut self.hint);
                let plane = plane.unwrap_or_else(|| unreachable!("cell {cell} lies in the skin")).reduced();
                Proof { normal: plane.normal, margin: plane.margin() }
            }
        }
    }
}
