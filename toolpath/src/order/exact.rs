//! The shortest orders of few curves: the program of Held and Karp over sets of curves.
//!
//! For a set of curves and the way in which the last of them is travelled only the length of the shortest order so far
//! matters. Sets are numbers whose bits are curves, so each comes after all of its parts.

use super::way::{Way, gap};
use nalgebra::Point3;

/// Curves in a layer, and steps of the program, at most: a few milliseconds. Beyond it `local` takes over.
const MAX_CURVES: usize = 10;
const MAX_STEPS: usize = 1 << 22;

/// No way.
const NONE: u16 = u16::MAX;

/// Whether a layer is small enough.
pub(super) fn fits(choice: &[Vec<Way>]) -> bool {
    let ways: usize = choice.iter().map(Vec::len).sum();
    choice.len() <= MAX_CURVES && (ways * ways) << choice.len() <= MAX_STEPS
}

/// For each way in which the last curve may be travelled the shortest order, begun at any of `ends` with what it took to
/// get there: the length to its end, the order, and the number of the end it begins at.
pub(super) fn orders(choice: &[Vec<Way>], ends: &[(f64, Option<Point3<f64>>)]) -> Vec<(f64, Vec<Way>, usize)> {
    let ways: Vec<Way> = choice.iter().flatten().copied().collect();
    let bit = |way: &Way| 1_usize << way.visit.curve;
    let (count, sets) = (ways.len(), 1_usize << choice.len());
    // Length and the way before, for each set and last way.
    let mut table = vec![(f64::INFINITY, NONE); sets * count];
    let mut begun = Vec::with_capacity(count);
    for (w, way) in ways.iter().enumerate() {
        let reach = |end: &(f64, Option<Point3<f64>>)| end.0 + gap(end.1, Some(way.start));
        let from = (0..ends.len()).fold(0, |best, k| if reach(&ends[k]) < reach(&ends[best]) { k } else { best });
        table[bit(way) * count + w].0 = reach(&ends[from]);
        begun.push(from);
    }
    let apart: Vec<f64> =
        ways.iter().flat_map(|from| ways.iter().map(move |to| (to.start - from.end).norm())).collect();
    for set in 1..sets {
        for (last, way) in ways.iter().enumerate() {
            let known = table[set * count + last].0;
            if set & bit(way) == 0 || known.is_infinite() {
                continue;
            }
            for (next, other) in ways.iter().enumerate() {
                if set & bit(other) != 0 {
                    continue;
                }
                let entry = &mut table[(set | bit(other)) * count + next];
                let length = known + apart[last * count + next];
                if length < entry.0 {
                    *entry = (length, last as u16);
                }
            }
        }
    }
    let back = |end: usize| {
        let (mut set, mut at) = (sets - 1, end);
        let mut order = vec![ways[end]];
        while table[set * count + at].1 != NONE {
            let before = table[set * count + at].1 as usize;
            set &= !bit(&ways[at]);
            at = before;
            order.push(ways[at]);
        }
        order.reverse();
        (table[(sets - 1) * count + end].0, order, begun[at])
    };
    (0..count).map(back).collect()
}
