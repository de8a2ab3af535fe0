//! Cells that are proven to be impossible against all orders of small parts, and proofs that do not hold.

use crate::common;
use crate::common::{Part, are_neighbours, centre, go, hull_of, parts, rules};
use curvlay_layers::Progress;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    GrowthError, Impossible, Platform, ProofError, Rules, audit, check_impossible, grow, prove_impossible,
};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Cells of the largest part of which all orders are tried.
const MAX_CELLS: usize = 9;

/// The cells that some order builds: every set of cells that can be built is reached, layer by layer.
fn possible(part: &Part, rules: &Rules) -> BTreeSet<u32> {
    let cells = part.cells();
    let all: Vec<u32> = cells.iter().collect();
    let standing = part.standing();
    let mut built = BTreeSet::new();
    let (mut seen, mut waiting) = (BTreeSet::from([0u32]), vec![0u32]);
    while let Some(set) = waiting.pop() {
        let is_built = |k: usize| set >> k & 1 == 1;
        let there: Vec<u32> = (0..all.len()).filter(|&k| is_built(k)).map(|k| all[k]).collect();
        let hull = hull_of(part, rules, there.iter().copied());
        let can_be_built = |&k: &usize| {
            let cell = all[k];
            let near = |&b: &u32| are_neighbours(&cells, cell, b, rules.neighbours);
            !is_built(k)
                && (standing.contains(&cell) || there.iter().any(near))
                && !hull.is_deep(centre(cells.position(cell)))
        };
        let open: Vec<usize> = (0..all.len()).filter(can_be_built).collect();
        built.extend(open.iter().map(|&k| all[k]));
        for layer in 1u32..1 << open.len() {
            let chosen = (0..open.len()).filter(|&at| layer >> at & 1 == 1);
            let next = chosen.fold(set, |next, at| next | 1 << open[at]);
            if seen.insert(next) {
                waiting.push(next);
            }
        }
    }
    built
}

fn proofs(part: &Part, rules: &Rules) -> Vec<Impossible> {
    let cells = part.cells();
    let asked: Vec<u32> = cells.iter().collect();
    let proofs = prove_impossible(&cells, &part.platform, rules, &asked, &go).unwrap();
    check_impossible(&cells, &part.platform, rules, &proofs).unwrap();
    proofs
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    /// No order builds a cell that is proven to be impossible, and every proof holds.
    #[test]
    fn no_order_builds_what_is_impossible(
        part in parts((2u32..5, 1u32..3, 2u32..5).prop_map(|(x, y, z)| [x, y, z]), 3..7),
        rules in rules(),
    ) {
        prop_assume!(part.cells().count() <= MAX_CELLS);
        let possible = possible(&part, &rules);
        for proof in proofs(&part, &rules) {
            prop_assert!(!possible.contains(&proof.cell), "cell {:?}", part.cells().position(proof.cell));
        }
    }

    /// What the best growth builds is never proven to be impossible, in larger parts.
    #[test]
    fn what_is_built_is_possible(
        part in parts((4u32..12, 1u32..8, 4u32..10).prop_map(|(x, y, z)| [x, y, z]), 4..8),
        rules in rules(),
    ) {
        let cells = part.cells();
        let growth = grow(&cells, &part.platform, &rules, &Default::default(), None, &go).unwrap();
        let built: BTreeSet<u32> = growth.order.cells().iter().copied().collect();
        let missed = growth.missed_cells();
        prop_assert!(audit(&cells, &part.platform, &rules, &growth.order, &missed, &go).unwrap().is_ok());
        for proof in proofs(&part, &rules) {
            prop_assert!(!built.contains(&proof.cell), "cell {:?}", cells.position(proof.cell));
        }
    }
}

/// Fewer proofs would be sound, too: over these parts most cells that no order builds are proven.
#[test]
fn most_impossible_cells_of_small_parts_are_proven() {
    let (mut impossible, mut proven) = (0, 0);
    for seed in 0..240u64 {
        let rows = common::random_rows(seed, 8, 4, 4);
        let platform = Platform::polygon(&[[-1.0, -1.0], [12.0, -1.0], [12.0, 12.0], [-1.0, 12.0]]).unwrap();
        let part = Part { dims: [4, 2, 4], rows, platform };
        if part.standing().is_empty() || part.cells().count() > 11 {
            continue;
        }
        let rules = Rules { inside_depth_cells: 0.0, ..Rules::default() };
        impossible += part.cells().count() - possible(&part, &rules).len();
        proven += proofs(&part, &rules).len();
    }
    assert!(impossible > 20, "{impossible} cells");
    assert!(proven * 10 >= impossible * 9, "{proven} of {impossible} proven");
}

/// A mast with an arm, from the end of which a block hangs down.
fn gallows() -> Part {
    let mut rows = vec![0b1; 9];
    rows[8] = 0b111_1111;
    (5..8).for_each(|z| rows[z] |= 0b100_0000);
    let platform = Platform::under(&Cells::new([7, 1, 9], &rows).unwrap(), 20.0).unwrap();
    Part { dims: [7, 1, 9], rows, platform }
}

#[test]
fn forced_cells_are_those_on_every_chain() {
    let part = gallows();
    let cells = part.cells();
    let rules = Rules::default();
    let proofs = proofs(&part, &rules);
    let first = &proofs[0];
    assert_eq!(cells.position(first.cell), [6, 0, 6]);
    // One of the arm, one of the mast. Chains may cut the corner between them, since an edge is enough.
    assert!(first.forced.contains(&cells.id([3, 0, 8])) && first.forced.contains(&cells.id([0, 0, 3])));
}

#[test]
fn proofs_that_do_not_hold_are_found_out() {
    let part = gallows();
    let cells = part.cells();
    let rules = Rules::default();
    let check = |proof: &Impossible| check_impossible(&cells, &part.platform, &rules, std::slice::from_ref(proof));
    let hanging = cells.id([6, 0, 6]);
    let arm = cells.id([4, 0, 8]);
    let proof = Impossible { cell: hanging, forced: vec![arm], wall: Vec::new() };
    assert_eq!(check(&proof), Err(ProofError::Open { proof: 0 }));
    let proof = Impossible { cell: arm, forced: vec![hanging], wall: Vec::new() };
    assert_eq!(check(&proof), Err(ProofError::NotForced { proof: 0, forced: hanging }));
    let wall = cells.id([0, 0, 1]);
    let proof = Impossible { cell: hanging, forced: Vec::new(), wall: vec![wall] };
    assert_eq!(check(&proof), Err(ProofError::Harmless { proof: 0, wall }));
    let proof = Impossible { cell: cells.id([3, 0, 3]), forced: Vec::new(), wall: Vec::new() };
    assert_eq!(check(&proof), Err(ProofError::NoCell { proof: 0, cell: cells.id([3, 0, 3]) }));
    let proof = Impossible { cell: u32::MAX, forced: Vec::new(), wall: Vec::new() };
    assert_eq!(check(&proof), Err(ProofError::NoCell { proof: 0, cell: u32::MAX }));
}

#[test]
fn searches_can_be_cancelled_and_take_any_number() {
    let part = gallows();
    let cells = part.cells();
    let stop = |_: Progress| ControlFlow::Break(());
    let asked: Vec<u32> = cells.iter().collect();
    let cancelled = prove_impossible(&cells, &part.platform, &Rules::default(), &asked, &stop);
    assert_eq!(cancelled, Err(GrowthError::Cancelled));
    let none = prove_impossible(&cells, &part.platform, &Rules::default(), &[u32::MAX, 7 * 9], &go);
    assert_eq!(none, Ok(Vec::new()));
}
