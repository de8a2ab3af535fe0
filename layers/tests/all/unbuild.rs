//! Un-building against an exhaustive search, and the properties that every order has to have.

use crate::common::{Part, are_neighbours, centre, go, hull_of, parts, random_rows, rules};
use curvlay_layers::Progress;
use curvlay_layers::curved::{
    Growth, GrowthError, GrowthOptions, MissedReason, Platform, Prevention, Rules, RulesError, UnbuildOptions, audit,
    grow, layer_quality, unbuild,
};
use proptest::prelude::*;
use std::collections::HashSet;
use std::ops::ControlFlow;

impl Part {
    /// Levels from the top down, cells as `#`, one level a line, one cell deep in y.
    fn drawn(levels: &[&str], platform: [f64; 2]) -> Self {
        let rows: Vec<u64> = levels
            .iter()
            .rev()
            .map(|level| level.bytes().zip(0..).map(|(byte, x)| u64::from(byte == b'#') << x).sum())
            .collect();
        let [low, high] = platform;
        let platform = Platform::polygon(&[[low, -3.0], [high, -3.0], [high, 4.0], [low, 4.0]]).unwrap();
        Part { dims: [levels[0].len() as u32, 1, levels.len() as u32], rows, platform }
    }

    fn unbuild(&self, rules: &Rules) -> Growth {
        unbuild(&self.cells(), &self.platform, rules, &UnbuildOptions::default(), &go).unwrap()
    }

    fn audit(&self, rules: &Rules, growth: &Growth) {
        let missed = growth.missed_cells();
        let report = audit(&self.cells(), &self.platform, rules, &growth.order, &missed, &go).unwrap();
        assert!(report.is_ok(), "{report}");
    }
}

/// The greatest number of cells that any order builds: all sets that can be reached are looked at.
fn most_cells(part: &Part, rules: &Rules) -> usize {
    let cells = part.cells();
    let all: Vec<u32> = cells.iter().collect();
    let stand = part.standing();
    let first = (0..all.len()).filter(|&at| stand.contains(&all[at])).fold(0u32, |set, at| set | 1 << at);
    let mut open = vec![first];
    let mut seen = HashSet::from([first]);
    let mut most = 0;
    while let Some(built) = open.pop() {
        most = most.max(built.count_ones() as usize);
        let has = |at: usize| built >> at & 1 == 1;
        let hull = hull_of(part, rules, (0..all.len()).filter(|&at| has(at)).map(|at| all[at]));
        let next = (0..all.len())
            .filter(|&at| !has(at) && !hull.is_deep(centre(cells.position(all[at]))))
            .filter(|&at| (0..all.len()).any(|b| has(b) && are_neighbours(&cells, all[at], all[b], rules.neighbours)))
            .fold(0u32, |set, at| set | 1 << at);
        let mut layer = next; // all parts of the set, each a layer
        while layer != 0 {
            if seen.insert(built | layer) {
                open.push(built | layer);
            }
            layer = (layer - 1) & next;
        }
    }
    most
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_order_passes_the_audit(part in parts([1u32..8, 1..6, 1..8], 2..8), rules in rules()) {
        let growth = part.unbuild(&rules);
        part.audit(&rules, &growth);
        prop_assert_eq!(growth.order.cells().len() + growth.missed.len(), part.cells().count());
        prop_assert!(growth.order.iter().all(|layer| layer.is_sorted() && !layer.is_empty()));
        prop_assert!(growth.missed.is_sorted_by_key(|missed| missed.cell));
    }

    #[test]
    fn no_order_builds_more_than_the_search_finds(part in parts([3u32..6, 1..3, 2..5], 3..7), rules in rules()) {
        prop_assume!(part.cells().count() <= 14);
        prop_assert!(part.unbuild(&rules).order.cells().len() <= most_cells(&part, &rules));
    }
}

/// It is no exhaustive search, so this is what it owes: it may fail on one part in a hundred that can be built whole.
#[test]
fn next_to_nothing_is_missed_of_parts_that_can_be_built_whole() {
    let platform = Platform::polygon(&[[-1.0, -1.0], [6.0, -1.0], [6.0, 6.0], [-1.0, 6.0]]).unwrap();
    let (mut whole, mut with_misses) = (0, 0);
    for seed in 0..750 {
        let eps = [0.0, 0.5, 1.0][seed as usize % 3];
        let part = Part { dims: [5, 1, 4], rows: random_rows(seed, 4, 5, 5), platform: platform.clone() };
        let rules = Rules { inside_depth_cells: eps, ..Rules::default() };
        if part.rows[0] != 0 && most_cells(&part, &rules) == part.cells().count() {
            whole += 1;
            with_misses += usize::from(!part.unbuild(&rules).missed.is_empty());
        }
    }
    assert!(whole > 100, "{whole}");
    assert!(100 * with_misses <= whole, "{with_misses} of {whole}");
}

#[test]
fn an_arch_is_closed_from_its_ends() {
    let part = Part::drawn(&["#######", "##...##", "##...##", "##...##"], [-2.0, 9.0]);
    let rules = Rules::default();
    let growth = part.unbuild(&rules);
    part.audit(&rules, &growth);
    assert!(growth.missed.is_empty());
    assert_eq!(growth.order.len(), 5); // three levels of the legs, the bar but for its middle, the middle
}

/// What hangs from a beam lies inside the hull of beam and platform: no order builds it, and the reason says so.
#[test]
fn what_hangs_inside_is_given_up() {
    let part = Part::drawn(
        &["########", "########", "##...##.", "##...##.", "##......", "##......", "##......", "##......"],
        [-20.0, 28.0],
    );
    let rules = Rules { inside_depth_cells: 0.5, ..Rules::default() };
    let growth = part.unbuild(&rules);
    part.audit(&rules, &growth);
    let missed: Vec<[u32; 3]> = growth.missed.iter().map(|m| part.cells().position(m.cell)).collect();
    assert_eq!(missed, [[5, 0, 4], [6, 0, 4]]); // those below touch the beam, less than half a cell deep
    assert!(growth.missed.iter().all(|m| matches!(m.reason, MissedReason::Shadowed { layer } if layer >= 6)));
    assert_eq!(growth.statistics.sacrifices, 1);
}

#[test]
fn a_loose_piece_is_distinguished() {
    let part = Part::drawn(&[".#", "..", "#."], [-1.0, 3.0]);
    let growth = part.unbuild(&Rules::default());
    assert_eq!(growth.missed.iter().map(|m| m.reason).collect::<Vec<_>>(), [MissedReason::NeverAdjacent]);
}

/// Found by a random search: the first removal gets stuck, a later one finds the way around.
#[test]
fn looking_back_finds_the_other_way() {
    let part = Part::drawn(&["#.#####", "##.###.", "##.#..#", "#.....#", "#.#..#."], [0.0, 7.0]);
    let rules = Rules { inside_depth_cells: 0.5, ..Rules::default() };
    let run = |look_back| {
        let options = UnbuildOptions { look_back };
        let growth = unbuild(&part.cells(), &part.platform, &rules, &options, &go).unwrap();
        part.audit(&rules, &growth);
        (growth.missed.len(), growth.statistics.trials)
    };
    assert_eq!(run(0), (1, 1));
    let (missed, trials) = run(6);
    assert_eq!(missed, 0);
    assert!((2..=7).contains(&trials), "{trials}");
}

/// A block with a ragged top: the crumbs wait until they can be laid down together.
#[test]
fn few_cells_are_left_in_small_patches() {
    let [nx, ny, nz] = [24u32, 24, 16];
    let ball = |[x, y, z]: [u32; 3]| {
        let from_centre = [x, y, z].map(|c| f64::from(c) + 0.5 - 12.0);
        let squared: f64 = from_centre.iter().map(|c| c * c).sum();
        (64.0..144.0).contains(&squared)
    };
    let row = |y: u32, z: u32| (0..nx).fold(0, |row, x| row | u64::from(ball([x, y, z + 4])) << x);
    let rows: Vec<u64> = (0..nz).flat_map(|z| (0..ny).map(move |y| row(y, z))).collect();
    let platform = Platform::disc([12.0, 12.0], 60.0).unwrap();
    let part = Part { dims: [nx, ny, nz], rows, platform };
    let rules = Rules::default();
    let growth = part.unbuild(&rules);
    part.audit(&rules, &growth);
    assert!(growth.missed.is_empty());
    let quality = layer_quality(&part.cells(), &growth.order, rules.neighbours);
    assert!(quality.small_patch_share < 0.02, "{quality:?}");
    let options = GrowthOptions { prevention: Prevention::None, ..GrowthOptions::default() };
    let greedy = grow(&part.cells(), &part.platform, &rules, &options, None, &go).unwrap();
    assert!(10 * growth.order.len() <= 13 * greedy.order.len(), "{} {}", growth.order.len(), greedy.order.len());
}

#[test]
fn what_cannot_be_used_is_refused() {
    let part = Part::drawn(&["##"], [-1.0, 3.0]);
    let options = UnbuildOptions::default();
    let with = |part: &Part, rules: &Rules| unbuild(&part.cells(), &part.platform, rules, &options, &go);
    let unsound = Rules { inside_depth_cells: -1.0, ..Rules::default() };
    assert_eq!(with(&part, &unsound), Err(GrowthError::Rules(RulesError::InsideDepth { cells: -1.0 })));
    let rules = Rules::default();
    assert_eq!(with(&Part { rows: vec![0], ..part.clone() }, &rules), Err(GrowthError::NoCell));
    let hanging = Part::drawn(&["##", ".."], [-1.0, 3.0]);
    assert_eq!(with(&hanging, &rules), Err(GrowthError::NothingOnPlatform));
    for stage in ["unbuild", "grow"] {
        let stop = |p: Progress| if p.stage == stage { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let tower = Part::drawn(&["##", "##", "##"], [-1.0, 3.0]);
        let stopped = unbuild(&tower.cells(), &tower.platform, &rules, &options, &stop);
        assert_eq!(stopped, Err(GrowthError::Cancelled), "{stage}");
    }
}
