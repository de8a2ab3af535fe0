//! Which of two orders prints better, by the surfaces that they give.
//!
//! Without a strategy the part is grown incrementally. If that misses cells, all is done once more with un-building. What a
//! result *loses* of the volume is what lies in missed cells, and what the layers leave bare of the rest or cover twice. The
//! result that loses less by more than [`WORTH`] of the volume is taken; of two that lose as much the one whose surfaces
//! are in fewer pieces, since each takes a curve of its own; of two with as many the incremental one, whose layers are more
//! uniform. [`Workpiece::order`](super::Workpiece::order) takes the same decision, so a caller who wants no surfaces yet gets the order that they will be of.

use super::trim::TrimmedSheet;
use std::collections::HashSet;

/// How much less of the volume an order has to lose, as a share of it, to be taken for that alone: a thousandth, what a print may
/// miss and count as complete. With 0 single cells decide; with more than a few hundredths branches stay missed.
pub const WORTH: f64 = 0.001;

/// Whether layers are better than others of the same volume: each by what they lose of it, and by their pieces of surface.
pub(super) fn is_better((lost, pieces): (f64, usize), (other_lost, other_pieces): (f64, usize), volume: f64) -> bool {
    match other_lost - lost {
        gain if gain.abs() > WORTH * volume => gain > 0.0,
        _ => pieces < other_pieces,
    }
}

/// Connected pieces of a sheet: triangles are connected where they share a corner.
pub(super) fn pieces(sheet: &TrimmedSheet) -> usize {
    let mut leads_to: Vec<u32> = (0..sheet.vertices.len() as u32).collect();
    fn root(leads_to: &mut [u32], mut corner: u32) -> u32 {
        while leads_to[corner as usize] != corner {
            leads_to[corner as usize] = leads_to[leads_to[corner as usize] as usize];
            corner = leads_to[corner as usize];
        }
        corner
    }
    for &[a, b, c] in &sheet.triangles {
        for (from, to) in [(a, b), (b, c)] {
            let [from, to] = [from, to].map(|corner| root(&mut leads_to, corner));
            leads_to[from.max(to) as usize] = from.min(to);
        }
    }
    let roots = sheet.triangles.iter().map(|&[a, ..]| root(&mut leads_to, a));
    roots.collect::<HashSet<u32>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_laid_decides_and_then_the_pieces() {
        let volume = 1000.0;
        assert!(is_better((50.0, 900), (52.0, 800), volume)); // two thousandths more are laid
        assert!(!is_better((52.0, 800), (50.0, 900), volume));
        assert!(is_better((50.9, 800), (50.0, 900), volume)); // less than a thousandth: fewer pieces
        assert!(!is_better((50.0, 900), (50.9, 800), volume));
        assert!(!is_better((50.0, 900), (50.0, 900), volume)); // neither
    }
}
