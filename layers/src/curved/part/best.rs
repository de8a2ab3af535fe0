//! Which of two orders prints better, by the surfaces that they give.
//!
//! Without a strategy the part is grown incrementally. If that misses cells, all is done once more with un-building. What a
//! result *loses* of the volume is what lies in missed cells, and what the layers leave bare of the rest or cover twice. The
//! result that loses less by more than [`WORTH`] of the volume is taken; of two that lose about as much the one that misses less by
//! more than [`WORTH_MISSED`]; of two that miss about as much the one whose surfaces are in fewer pieces, since each takes a curve
//! of its own; of two with as many the incremental one, whose layers are more uniform.
//! [`Workpiece::order`](crate::curved::Workpiece::order) takes the same decision, so a caller who wants no surfaces yet gets the order that
//! they will be of.

use crate::trim::TrimmedSheet;
use crate::union_find::UnionFind;
use std::collections::HashSet;

/// How much less of the volume an order has to lose, as a share of it, to be taken for that alone. Where surfaces bend, their volume
/// is no more exact than some thousandths; with more than a few hundredths branches stay missed.
pub const WORTH: f64 = 0.01;

/// How much less of the volume an order has to miss, as a share of it, to be taken where both lose about as much: what a print may
/// miss and count as complete. The volume of missed cells is cut from the mesh, so it is more exact than that of surfaces.
pub const WORTH_MISSED: f64 = 0.001;

/// What is laid of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deposited {
    /// Volume that the layers leave bare or cover twice, missed cells included.
    pub(crate) lost_mm3: f64,
    /// Volume of missed cells.
    pub(crate) missed_mm3: f64,
    /// Connected pieces of surface.
    pub(crate) pieces: usize,
}

impl Deposited {
    /// Whether this is better than something else that is laid of a part of this volume.
    pub(crate) fn is_better_than(self, other: Deposited, volume_mm3: f64) -> bool {
        let [lost, missed] = [other.lost_mm3 - self.lost_mm3, other.missed_mm3 - self.missed_mm3];
        if lost.abs() > WORTH * volume_mm3 {
            lost > 0.0
        } else if missed.abs() > WORTH_MISSED * volume_mm3 {
            missed > 0.0
        } else {
            self.pieces < other.pieces
        }
    }
}

/// Connected pieces of a sheet: triangles are connected where they share a corner.
pub(crate) fn pieces(sheet: &TrimmedSheet) -> usize {
    let mut pieces = UnionFind::new(sheet.vertices.len());
    for &[a, b, c] in &sheet.triangles {
        pieces.join(a, b);
        pieces.join(b, c);
    }
    let roots = sheet.triangles.iter().map(|&[a, ..]| pieces.root(a));
    roots.collect::<HashSet<u32>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_laid_decides_then_what_is_missed_and_then_the_pieces() {
        let laid = |lost_mm3, missed_mm3, pieces| Deposited { lost_mm3, missed_mm3, pieces };
        let first = laid(50.0, 8.0, 800);
        let is_better = |other: Deposited| [first.is_better_than(other, 1000.0), other.is_better_than(first, 1000.0)];
        assert_eq!(is_better(laid(61.0, 0.0, 1)), [true, false]); // more than a hundredth more is laid
        assert_eq!(is_better(laid(59.0, 0.0, 900)), [false, true]); // about as much: more is missed
        assert_eq!(is_better(laid(41.0, 9.5, 1)), [true, false]);
        assert_eq!(is_better(laid(41.0, 7.5, 900)), [true, false]); // as much is missed: fewer pieces
        assert_eq!(is_better(first), [false, false]);
    }
}
