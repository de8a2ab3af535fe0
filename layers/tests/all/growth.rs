//! Growth against a slow twin, and the properties that every growth has to have.

use crate::common::{Part, are_neighbours, centre, go, hull_of, parts, rules};
use curvlay_hull::{ConvexHull2, Depth};
use curvlay_layers::Progress;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    Candidates, Growth, GrowthError, GrowthOptions, MissedReason, PeelError, Platform, Prevention, Rules, RulesError,
    SheetField, audit, grow, peel,
};
use proptest::prelude::*;
use std::ops::ControlFlow;

impl Part {
    fn grow(&self, rules: &Rules, prevention: Prevention) -> Growth {
        let options = GrowthOptions { prevention, ..GrowthOptions::default() };
        grow(&self.cells(), &self.platform, rules, &options, None, &go).unwrap()
    }
}

/// Algorithm 1 with everything made afresh for each layer.
fn slow_greedy(part: &Part, rules: &Rules) -> Vec<Vec<u32>> {
    let cells = part.cells();
    let mut layers = vec![part.standing()];
    loop {
        let built = layers.concat();
        let hull = hull_of(part, rules, built.iter().copied());
        let next: Vec<u32> = cells
            .iter()
            .filter(|cell| !built.contains(cell))
            .filter(|&cell| built.iter().any(|&b| are_neighbours(&cells, cell, b, rules.neighbours)))
            .filter(|&cell| !hull.is_deep(centre(cells.position(cell))))
            .collect();
        if next.is_empty() {
            return layers;
        }
        layers.push(next);
    }
}

/// Algorithm 4 with everything made afresh for each sheet.
fn slow_peel(part: &Part, rules: &Rules) -> Vec<u32> {
    let cells = part.cells();
    let mut left: Vec<u32> = cells.iter().collect();
    let mut sheets = vec![0; part.dims.iter().product::<u32>() as usize];
    let mut sheet = 0;
    while !left.is_empty() {
        sheet += 1;
        let hull = hull_of(part, rules, left.iter().copied());
        let (kept, off) = left.iter().partition::<Vec<u32>, _>(|&&cell| hull.is_deep(centre(cells.position(cell))));
        off.iter().for_each(|&cell| sheets[cell as usize] = sheet);
        left = kept;
    }
    sheets.iter_mut().filter(|s| **s > 0).for_each(|s| *s = 1 + sheet - *s);
    sheets
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn greedy_agrees_with_the_slow_twin(part in parts([1u32..8, 1..6, 1..8], 5..9), rules in rules()) {
        let growth = part.grow(&rules, Prevention::None);
        let layers: Vec<Vec<u32>> = growth.order.iter().map(<[u32]>::to_vec).collect();
        prop_assert_eq!(layers, slow_greedy(&part, &rules));
    }

    /// A threshold that nothing reaches keeps all candidates: the greedy scheme.
    #[test]
    fn a_threshold_beyond_all_cells_is_greedy(part in parts([1u32..8, 1..6, 1..8], 5..9), rules in rules()) {
        prop_assert_eq!(part.grow(&rules, Prevention::FewerThan(u32::MAX)).order, part.grow(&rules, Prevention::None).order);
    }

    #[test]
    fn peeling_agrees_with_the_slow_twin(part in parts([1u32..8, 1..6, 1..8], 5..9), rules in rules()) {
        // On the surface only, the slow twin would never end at eps 0.
        prop_assume!(rules.inside_depth_cells > 0.0);
        let field = peel(&part.cells(), &part.platform, &rules, &go).unwrap();
        let values: Vec<u32> = (0..field.len() as u32).map(|cell| field.value(cell)).collect();
        prop_assert_eq!(values, slow_peel(&part, &rules));
    }

    #[test]
    fn every_growth_passes_the_audit_and_knows_what_it_missed(part in parts([1u32..8, 1..6, 1..8], 5..9), rules in rules(), governed: bool, which in 0usize..5, threshold in 0u32..6, last: bool) {
        let cells = part.cells();
        let prevention = [Prevention::None, Prevention::Incremental, Prevention::Adaptive, Prevention::FewerThanAll, Prevention::FewerThan(threshold)][which];
        let candidates = if last { Candidates::OfLastLayer } else { Candidates::OfAllLayers };
        let options = GrowthOptions { prevention, candidates, ..GrowthOptions::default() };
        let field = governed.then(|| peel(&cells, &part.platform, &rules, &go).unwrap());
        let growth = grow(&cells, &part.platform, &rules, &options, field.as_ref(), &go).unwrap();
        let missed = growth.missed_cells();
        let report = audit(&cells, &part.platform, &rules, &growth.order, &missed, &go).unwrap();
        prop_assert!(report.is_ok(), "{:?}", report.faults);
        prop_assert_eq!(growth.order.cells().len() + missed.len(), cells.count());

        let mut joined = part.standing();
        let mut done = 0;
        while done < joined.len() {
            let next: Vec<u32> = cells.iter().filter(|&c| are_neighbours(&cells, c, joined[done], rules.neighbours)).collect();
            joined.extend(next.into_iter().filter(|c| !joined.contains(c)).collect::<Vec<_>>());
            done += 1;
        }
        for missed in &growth.missed {
            let at = centre(cells.position(missed.cell));
            let upto = |layers: u32| hull_of(&part, &rules, growth.order.iter().take(layers as usize).flatten().copied());
            match missed.reason {
                MissedReason::Shadowed { layer } => {
                    prop_assert!(upto(layer).is_deep(at));
                    prop_assert!(layer == 1 || !upto(layer - 1).is_deep(at));
                    if matches!(prevention, Prevention::Incremental | Prevention::Adaptive) {
                        prop_assert!(layer == 1 || growth.statistics.sacrifices > 0);
                    }
                }
                reason => {
                    prop_assert!(!upto(u32::MAX).is_deep(at));
                    prop_assert_eq!(reason == MissedReason::SupportMissed, joined.contains(&missed.cell));
                }
            }
        }
        prop_assert_eq!(&grow(&cells, &part.platform, &rules, &options, field.as_ref(), &go).unwrap(), &growth);
    }

    /// A field of one value governs nothing.
    #[test]
    fn a_constant_field_changes_nothing(part in parts([1u32..8, 1..6, 1..8], 5..9), rules in rules()) {
        let cells = part.cells();
        let mut values = vec![0; part.dims.iter().product::<u32>() as usize];
        cells.iter().for_each(|cell| values[cell as usize] = 1);
        let options = GrowthOptions::default();
        let governed = grow(&cells, &part.platform, &rules, &options, Some(&SheetField::new(values)), &go).unwrap();
        prop_assert_eq!(governed, part.grow(&rules, options.prevention));
    }

    /// Flat objects: the greedy scheme with a hull in the plane, made afresh for each layer.
    #[test]
    fn flat_objects_agree_with_a_hull_in_the_plane(rows in prop::collection::vec(0u64..128, 1..8), reach in 1i32..6, eps in prop::sample::select(vec![0.0, 0.5, 1.0])) {
        let part = Part { dims: [7, 1, rows.len() as u32], rows, platform: Platform::segment(-f64::from(reach), 7.5).unwrap().elevated(-1).unwrap() };
        let cells = part.cells();
        prop_assume!(cells.iter().any(|cell| cell < 7));
        let rules = Rules { inside_depth_cells: eps, flat: true, ..Rules::default() };
        let growth = part.grow(&rules, Prevention::None);
        let at = |cell: u32| { let [x, _, z] = centre(cells.position(cell)); [x, z] };
        let mut layers: Vec<Vec<u32>> = vec![cells.iter().filter(|&cell| cell < 7).collect()];
        loop {
            let built = layers.concat();
            let mut hull = ConvexHull2::new(Depth::new(2.0 * eps).unwrap());
            hull.insert(&[[-2 * reach, -1], [15, -1]]).unwrap();
            hull.insert(&built.iter().map(|&cell| at(cell)).collect::<Vec<_>>()).unwrap();
            let next: Vec<u32> = cells.iter()
                .filter(|cell| !built.contains(cell))
                .filter(|&cell| built.iter().any(|&b| are_neighbours(&cells, cell, b, rules.neighbours)))
                .filter(|&cell| !hull.is_deep(at(cell)))
                .collect();
            if next.is_empty() {
                break;
            }
            layers.push(next);
        }
        prop_assert_eq!(growth.order.iter().map(<[u32]>::to_vec).collect::<Vec<_>>(), layers);
    }
}

/// A hook: greedy growth buries the end that hangs down, prevention saves it.
fn hook() -> Part {
    let side = |row: u64| (0..3).map(move |_| row);
    let rows: Vec<u64> = (0..12)
        .flat_map(|z| match z {
            0..6 => side(0b00_0000_0000_0111),
            6..9 => side(0b11_1000_0000_0111),
            _ => side(0b11_1111_1111_1111),
        })
        .collect();
    let cells = Cells::new([14, 3, 12], &rows).unwrap();
    let platform = Platform::under(&cells, 40.0).unwrap();
    Part { dims: [14, 3, 12], rows, platform }
}

#[test]
fn prevention_saves_what_greedy_growth_buries() {
    let part = hook();
    let rules = Rules { inside_depth_cells: 0.5, ..Rules::default() };
    let greedy = part.grow(&rules, Prevention::None).missed.len();
    let adaptive = part.grow(&rules, Prevention::Adaptive).missed.len();
    let incremental = part.grow(&rules, Prevention::Incremental).missed.len();
    assert!(greedy > 0, "the hook is no longer hard");
    assert!(adaptive < greedy && incremental < greedy, "{greedy} {adaptive} {incremental}");
}

#[test]
fn a_part_in_the_air_and_other_bad_input_is_refused() {
    let part = hook();
    let cells = part.cells();
    let grow_with = |cells: &Cells, platform: &Platform, rules: Rules, field: Option<&SheetField>| {
        grow(cells, platform, &rules, &GrowthOptions::default(), field, &go).map(|growth| growth.order.len())
    };
    let away = Platform::polygon(&[[100.0, 0.0], [110.0, 0.0], [100.0, 10.0]]).unwrap();
    assert_eq!(grow_with(&cells, &away, Rules::default(), None), Err(GrowthError::NothingOnPlatform));
    let nothing = Cells::new([1, 1, 1], &[0]).unwrap();
    assert_eq!(grow_with(&nothing, &away, Rules::default(), None), Err(GrowthError::NoCell));
    let field = SheetField::new(vec![1; 3]);
    let error = GrowthError::Field { field: 3, cells: 14 * 3 * 12 };
    assert_eq!(grow_with(&cells, &part.platform, Rules::default(), Some(&field)), Err(error));
    let negative = Rules { inside_depth_cells: -1.0, ..Rules::default() };
    assert_eq!(grow_with(&cells, &part.platform, negative, None), Err(RulesError::InsideDepth { cells: -1.0 }.into()));
    let stop = |_: Progress| ControlFlow::Break(());
    let cancelled = grow(&cells, &part.platform, &Rules::default(), &GrowthOptions::default(), None, &stop);
    assert_eq!(cancelled, Err(GrowthError::Cancelled));
    assert_eq!(peel(&cells, &part.platform, &Rules::default(), &stop), Err(PeelError::Cancelled));
}

#[test]
fn peeling_counts_the_cells_that_are_off() {
    let part = hook();
    let cells = part.cells();
    let said = std::sync::Mutex::new(Vec::new());
    let note = |tick: Progress| {
        said.lock().unwrap().push((tick.stage, tick.done, tick.total));
        ControlFlow::Continue(())
    };
    peel(&cells, &part.platform, &Rules::default(), &note).unwrap();
    let (said, all) = (said.into_inner().unwrap(), cells.count() as u64);
    assert!(said.len() > 2 && said.windows(2).all(|pair| pair[0].1 < pair[1].1), "{said:?}");
    assert!(said.iter().all(|&(stage, done, total)| stage == "peel" && done <= total && total == all));
    assert_eq!(said.last().map(|last| last.1), Some(all));
}

/// Memory goes by the cells, not by the values of a governing field; what counts is their order alone.
#[test]
fn values_of_a_governing_field_may_be_any_number() {
    let part = hook();
    let (cells, rules) = (part.cells(), Rules::default());
    let field = peel(&cells, &part.platform, &rules, &go).unwrap();
    let values =
        |of: &dyn Fn(u32) -> u32| SheetField::new((0..field.len() as u32).map(|cell| of(field.value(cell))).collect());
    let run =
        |field: &SheetField| grow(&cells, &part.platform, &rules, &GrowthOptions::default(), Some(field), &go).unwrap();
    let far = u32::MAX - field.highest();
    let same = run(&field);
    assert!(same.order.len() > 12 && run(&values(&|value| value + far)) == same);
    let one_late = values(&|value| if value == field.highest() { u32::MAX } else { value });
    assert_eq!(run(&one_late), same);
}

#[test]
fn peeling_ends_at_any_depth() {
    let part = hook();
    for eps in [0.0, 0.001, 16.0] {
        let field =
            peel(&part.cells(), &part.platform, &Rules { inside_depth_cells: eps, ..Rules::default() }, &go).unwrap();
        assert!(part.cells().iter().all(|cell| field.value(cell) > 0));
    }
}

/// A cell that joined others with the same direction found their reach too high, left over from a what-if: its
/// proof was taken for void from the start.
#[test]
fn a_reach_left_over_from_a_what_if_is_lowered() {
    let side = |row: u64| (0..6).map(move |_| row);
    let rows: Vec<u64> = (0..20).flat_map(|z| side(if z < 14 { 0xF } else { 0xF_FFFF })).collect();
    let cells = Cells::new([20, 6, 20], &rows).unwrap();
    let part = Part { dims: [20, 6, 20], rows: rows.clone(), platform: Platform::under(&cells, 64.0).unwrap() };
    for prevention in [Prevention::None, Prevention::Incremental, Prevention::Adaptive] {
        let growth = part.grow(&Rules::default(), prevention);
        let missed = growth.missed_cells();
        let report = audit(&cells, &part.platform, &Rules::default(), &growth.order, &missed, &go).unwrap();
        assert!(report.is_ok() && (prevention == Prevention::None || missed.is_empty()), "{prevention:?} {report}");
    }
}
