//! Growth with prevention against slow twins, which make every hull afresh and look at every cell, and against orders that
//! are known.

use crate::common::{Part, are_neighbours, centre, go, hull_of, parts, rules};
use curvlay_hull::Location;
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::{
    Growth, GrowthError, GrowthOptions, Neighbours, Platform, Prevention, Rules, SheetField, Strategy, audit, grow,
    grow_as_printed, peel,
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use proptest::strategy::Strategy as _;
use std::collections::{BTreeMap, BTreeSet};

/// A part, its rules and a governing field, with the questions that the algorithms ask.
struct Slow<'a> {
    part: &'a Part,
    rules: Rules,
    field: &'a SheetField,
    built: Vec<u32>,
    /// Cells that came to lie inside.
    lost: BTreeSet<u32>,
    layers: Vec<Vec<u32>>,
}

impl<'a> Slow<'a> {
    fn new(part: &'a Part, rules: Rules, field: &'a SheetField) -> Self {
        let first = part.standing();
        let mut slow = Slow { part, rules, field, built: Vec::new(), lost: BTreeSet::new(), layers: Vec::new() };
        slow.build(first);
        slow
    }

    /// The cells that are not built and lie inside the hull of what is and of `more`.
    fn inside_with(&self, more: &[u32]) -> BTreeSet<u32> {
        let cells = self.part.cells();
        let hull = hull_of(self.part, &self.rules, self.built.iter().chain(more).copied());
        cells.iter().filter(|c| !self.built.contains(c) && hull.is_deep(centre(cells.position(*c)))).collect()
    }

    fn waiting(&self) -> Vec<u32> {
        self.part.cells().iter().filter(|cell| !self.built.contains(cell) && !self.lost.contains(cell)).collect()
    }

    fn build(&mut self, mut layer: Vec<u32>) {
        layer.sort_unstable();
        self.built.extend(&layer);
        self.layers.push(layer);
        self.lost = self.inside_with(&[]);
    }

    fn near(&self, a: u32, b: u32) -> bool {
        are_neighbours(&self.part.cells(), a, b, self.rules.neighbours)
    }

    /// The cells by their distance from the one with the least number, through neighbours in `through`; those that this
    /// does not reach in the same way. Lengths are in 2^-32 of a cell, rounded down.
    fn flooded(&self, cells: &[u32], through: &[u32]) -> Vec<u32> {
        let place = |cell: u32| self.part.cells().position(cell).map(f64::from);
        let length = |a: u32, b: u32| {
            let (a, b) = (place(a), place(b));
            let squared: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
            (squared.sqrt() * (1u64 << 32) as f64) as u64
        };
        let mut distance: BTreeMap<u32, u64> = BTreeMap::new();
        let mut ordered = Vec::new();
        let mut rest = cells.to_vec();
        while let Some(&first) = rest.iter().min() {
            let mut found = BTreeMap::from([(first, 0)]);
            let mut changed = true;
            while changed {
                changed = false;
                for (&from, far) in &found.clone() {
                    for &to in through.iter().filter(|&&to| self.near(from, to) && !distance.contains_key(&to)) {
                        let there = far + length(from, to);
                        if found.get(&to).is_none_or(|&known| there < known) {
                            found.insert(to, there);
                            changed = true;
                        }
                    }
                }
            }
            let mut reached: Vec<u32> = rest.iter().copied().filter(|cell| found.contains_key(cell)).collect();
            reached.sort_unstable_by_key(|cell| (found[cell], *cell));
            rest.retain(|cell| !found.contains_key(cell));
            ordered.extend(reached);
            distance.extend(found);
        }
        ordered
    }

    /// Algorithm 2, lines 7 to 12.
    fn one_by_one(&self, next: &[u32], before: &BTreeSet<u32>) -> Vec<u32> {
        let mut kept = Vec::new();
        for cell in self.flooded(next, next) {
            kept.push(cell);
            if self.inside_with(&kept) != *before {
                kept.pop();
            }
        }
        kept
    }

    /// The procedure of Algorithm 3.
    fn refined(&self, part: &mut [u32], before: &BTreeSet<u32>, kept: &mut Vec<u32>) {
        if self.inside_with(&[&kept[..], part].concat()) == *before {
            kept.extend_from_slice(part);
        } else if part.len() > 1 {
            let middle = self.split(part);
            let (near, far) = part.split_at_mut(middle);
            self.refined(near, before, kept);
            self.refined(far, before, kept);
        }
    }

    /// Where to cut a set along its longest axis.
    fn split(&self, part: &mut [u32]) -> usize {
        let point = |cell: u32| Vector3::from(centre(self.part.cells().position(cell)).map(f64::from));
        let points: Vec<_> = part.iter().map(|&cell| point(cell)).collect();
        let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let spread: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
        let axes = spread.symmetric_eigen();
        let axis = axes.eigenvectors.column(axes.eigenvalues.imax());
        let is_beyond = |cell: &u32| (point(*cell) - mean).dot(&axis) > 0.0;
        part.sort_by_key(is_beyond);
        let middle = part.iter().filter(|cell| !is_beyond(cell)).count();
        if middle == 0 || middle == part.len() { part.len() / 2 } else { middle }
    }
}

/// Algorithm 5 as printed, with Algorithm 2 or 3.
fn slow_printed<'a>(part: &'a Part, rules: &Rules, prevention: Prevention, field: &'a SheetField) -> Slow<'a> {
    let mut slow = Slow::new(part, *rules, field);
    for threshold in 1..=field.highest() {
        let mut last = slow.built.clone();
        loop {
            let is_next =
                |cell: &u32| slow.field.value(*cell) <= threshold && last.iter().any(|&other| slow.near(*cell, other));
            let mut next: Vec<u32> = slow.waiting().into_iter().filter(is_next).collect();
            if next.is_empty() {
                break;
            }
            let before = slow.lost.clone();
            let mut kept = Vec::new();
            match prevention {
                _ if slow.inside_with(&next) == before => kept = next.clone(),
                Prevention::Incremental => kept = slow.one_by_one(&next, &before),
                Prevention::Adaptive => slow.refined(&mut next.clone(), &before, &mut kept),
                _ => {}
            }
            if kept.is_empty() {
                kept.append(&mut next);
            }
            slow.build(kept);
            last = slow.layers.last().unwrap().clone();
        }
    }
    slow
}

/// Ours with Algorithm 2 inside: candidates of all layers, each held back because of one cell; the cheapest group is
/// given way to when nothing else is left.
fn slow_incremental<'a>(part: &'a Part, rules: &Rules, field: &'a SheetField) -> Slow<'a> {
    let mut slow = Slow::new(part, *rules, field);
    let mut held: BTreeMap<u32, u32> = BTreeMap::new(); // a candidate, and the cell that holds it back
    let mut threshold = 0;
    loop {
        let waiting = slow.waiting();
        held.retain(|candidate, by| waiting.contains(candidate) && waiting.contains(by));
        let reached: Vec<u32> =
            waiting.iter().copied().filter(|&cell| slow.built.iter().any(|&other| slow.near(cell, other))).collect();
        let due = |cell: &&u32| field.value(**cell) <= threshold;
        let mut next: Vec<u32> = reached.iter().filter(due).filter(|cell| !held.contains_key(cell)).copied().collect();
        // What is held back because of a candidate may be built in one layer with it.
        let mut done = 0;
        while let Some(&candidate) = next.get(done) {
            let freed: Vec<u32> = held.iter().filter(|(_, by)| **by == candidate).map(|(&cell, _)| cell).collect();
            freed.iter().for_each(|cell| _ = held.remove(cell));
            next.extend(freed);
            done += 1;
        }
        next.sort_unstable();
        if next.is_empty() {
            let later = reached.iter().map(|&cell| field.value(cell)).filter(|&value| value > threshold).min();
            if let Some(value) = later {
                threshold = value;
                continue;
            }
            let mut rest: Vec<u32> = held.keys().copied().collect();
            let mut cheapest: Option<(usize, Vec<u32>)> = None;
            while let Some(&first) = rest.first() {
                let mut group = vec![first];
                let mut done = 0;
                while let Some(&cell) = group.get(done) {
                    rest.retain(|other| !group.contains(other));
                    group.extend(rest.iter().copied().filter(|&other| slow.near(cell, other)));
                    done += 1;
                }
                rest.retain(|other| !group.contains(other));
                let inside = slow.inside_with(&group);
                let cost = inside.iter().filter(|cell| !slow.lost.contains(cell) && !held.contains_key(cell)).count();
                if cheapest.as_ref().is_none_or(|(least, _)| cost < *least) {
                    cheapest = Some((cost, group));
                }
            }
            match cheapest {
                Some((_, group)) => slow.build(group),
                None => return slow,
            }
            continue;
        }
        let is_aside = |cell: &u32| slow.lost.contains(cell) || next.contains(cell);
        let mut endangered: Vec<u32> = slow.inside_with(&next).into_iter().filter(|cell| !is_aside(cell)).collect();
        if endangered.is_empty() {
            slow.build(next);
            continue;
        }
        let hull = hull_of(part, rules, slow.built.iter().copied());
        let extends = |cell: &u32| hull.locate(centre(part.cells().position(*cell))) == Location::Outside;
        let (tried, mut kept): (Vec<u32>, Vec<u32>) = next.iter().partition(|cell| extends(cell));
        for cell in slow.flooded(&tried, &next) {
            let inside = slow.inside_with(&[&kept[..], &[cell]].concat());
            match endangered.iter().position(|other| inside.contains(other)) {
                Some(at) => {
                    held.insert(cell, endangered[at]);
                    endangered.swap(0, at);
                }
                None => kept.push(cell),
            }
        }
        if !kept.is_empty() {
            slow.build(kept);
        }
    }
}

/// A field for any cells: what `value` says of each.
fn field_of(part: &Part, value: impl Fn(u32) -> u32) -> SheetField {
    let cells = part.cells();
    let in_grid = part.dims.iter().product::<u32>();
    SheetField::new((0..in_grid).map(|c| if cells.contains(cells.position(c)) { value(c) } else { 0 }).collect())
}

/// Any field, or that of peeling.
fn some_field(part: &Part, rules: &Rules, which: u32, seed: u64) -> SheetField {
    match which {
        0 => field_of(part, |_| 1),
        1 => field_of(part, |cell| 1 + ((seed ^ u64::from(cell)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61) as u32),
        _ => peel(&part.cells(), &part.platform, rules, &go).unwrap(),
    }
}

fn layers(order: &LayerOrder) -> Vec<Vec<u32>> {
    order.iter().map(<[u32]>::to_vec).collect()
}

fn missed(slow: &Slow) -> Vec<u32> {
    slow.part.cells().iter().filter(|cell| !slow.built.contains(cell)).collect()
}

/// Two columns under a beam with gaps, from which teeth hang down: what is built above them shadows some of these, and on each side
/// another number of them.
fn combs() -> impl proptest::strategy::Strategy<Value = Part> {
    let teeth = prop::collection::vec(0u32..8, 14);
    (teeth, 1u32..4, 7u32..10, prop::sample::select(vec![1.0, 4.0, 20.0])).prop_map(|(teeth, ny, nz, margin)| {
        let is_column = |x: u32| [3, 4, 9, 10].contains(&x);
        let solid = |x: u32, z: u32| is_column(x) || (teeth[x as usize] > 0 && z + 1 + teeth[x as usize].min(5) >= nz);
        let row = |z: u32| (0..14).filter(|&x| solid(x, z)).map(|x| 1 << x).sum();
        let rows: Vec<u64> = (0..nz).flat_map(|z| (0..ny).map(move |_| z)).map(row).collect();
        let [right, back] = [14.0 + margin, f64::from(ny) + margin];
        let corners = [[-margin, -margin], [right, -margin], [right, back], [-margin, back]];
        Part { dims: [14, ny, nz], rows, platform: Platform::polygon(&corners).unwrap() }
    })
}

/// Random cells, or a comb.
fn some_part() -> impl proptest::strategy::Strategy<Value = Part> {
    prop_oneof![parts([1u32..8, 1..5, 1..8], 4..9), combs()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn growth_as_printed_agrees_with_the_slow_twin(
        part in some_part(), rules in rules(), adaptive: bool, which in 0u32..3, seed: u64
    ) {
        let field = some_field(&part, &Rules { inside_depth_cells: rules.inside_depth_cells.max(0.3), ..rules }, which, seed);
        let prevention = if adaptive { Prevention::Adaptive } else { Prevention::Incremental };
        let growth = grow_as_printed(&part.cells(), &part.platform, &rules, prevention, &field, &go).unwrap();
        let slow = slow_printed(&part, &rules, prevention, &field);
        prop_assert_eq!(layers(&growth.order), &slow.layers[..]);
        prop_assert_eq!(growth.missed_cells(), missed(&slow));
        let report = audit(&part.cells(), &part.platform, &rules, &growth.order, &growth.missed_cells(), &go).unwrap();
        prop_assert!(report.is_ok(), "{}", report);
    }

    #[test]
    fn incremental_growth_agrees_with_the_slow_twin(
        part in some_part(), rules in rules(), which in 0u32..3, seed: u64
    ) {
        let field = some_field(&part, &Rules { inside_depth_cells: rules.inside_depth_cells.max(0.3), ..rules }, which, seed);
        let options = GrowthOptions { prevention: Prevention::Incremental, ..GrowthOptions::default() };
        let growth = grow(&part.cells(), &part.platform, &rules, &options, Some(&field), &go).unwrap();
        let slow = slow_incremental(&part, &rules, &field);
        prop_assert_eq!(layers(&growth.order), &slow.layers[..]);
        prop_assert_eq!(growth.missed_cells(), missed(&slow));
    }
}

/// A sheet without cells lets cells that were held back have another try, before those of the next sheet are candidates.
#[test]
fn a_sheet_without_cells_is_a_step_of_the_threshold() {
    let platform = Platform::polygon(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]]).unwrap();
    let part = Part { dims: [6, 2, 2], rows: vec![49, 14, 59, 35], platform };
    let rules =
        Rules { inside_depth_cells: 0.0, boundary_is_inside: false, neighbours: Neighbours::OneNorm, flat: false };
    let field = some_field(&part, &Rules { inside_depth_cells: 0.3, ..rules }, 1, 11_075_432_241_669_120_658);
    // No cell has the value 4; cell 19, of 3, is held back in its own sheet.
    assert!(field.value(19) == 3 && part.cells().iter().all(|cell| field.value(cell) != 4));
    let growth = grow_as_printed(&part.cells(), &part.platform, &rules, Prevention::Incremental, &field, &go).unwrap();
    assert_eq!(layers(&growth.order)[..5], [&[0, 7][..], &[12], &[9], &[4], &[19]]);
    assert_eq!(layers(&growth.order), &slow_printed(&part, &rules, Prevention::Incremental, &field).layers[..]);
}

/// Shapes that shadow much: a column with arms that hang down, a ring that leans, a bowl whose rim is bent inwards.
fn shapes() -> [(&'static str, Part); 3] {
    let part = |dims: [u32; 3], solid: &dyn Fn(Vector3<f64>) -> bool| {
        let at = |x: u32, y: u32, z: u32| Vector3::from([x, y, z].map(|c| f64::from(c) + 0.5));
        let row = |y: u32, z: u32| (0..dims[0]).filter(|&x| solid(at(x, y, z))).map(|x| 1 << x).sum();
        let rows = (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (y, z)));
        let rows: Vec<u64> = rows.map(|(y, z)| row(y, z)).collect();
        let platform = Platform::under(&Cells::new(dims, &rows).unwrap(), 24.0).unwrap();
        Part { dims, rows, platform }
    };
    let rod = |p: Vector3<f64>, from: [f64; 3], to: [f64; 3], radius: f64| {
        let (from, along) = (Vector3::from(from), Vector3::from(to) - Vector3::from(from));
        let share = ((p - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (p - from - along * share).norm() < radius
    };
    let arms = part([24, 20, 20], &|p| {
        let ends = [[22.0, 12.3, 6.2], [3.1, 17.2, 9.3], [6.8, 1.9, 4.4]];
        rod(p, [10.3, 9.8, 0.0], [10.3, 9.8, 17.0], 2.7) || ends.iter().any(|&end| rod(p, [10.3, 9.8, 16.1], end, 1.9))
    });
    let ring = part([24, 22, 22], &|p| {
        let axis = Vector3::new(4.0, 2.0, 3.0).normalize();
        let from = p - Vector3::new(12.1, 10.7, 11.2);
        let (along, across) = (from.dot(&axis), (from - axis * from.dot(&axis)).norm());
        (across - 7.6).hypot(along) < 2.4 || rod(p, [14.2, 10.1, 0.0], [14.2, 10.1, 4.0], 3.3)
    });
    let bowl = part([22, 21, 18], &|p| {
        let from = (p - Vector3::new(10.9, 10.4, 9.6)).norm();
        let opening = rod(p, [10.9, 10.4, 9.6], [15.0, 12.0, 24.0], 4.6);
        ((6.6..9.4).contains(&from) && !opening) || rod(p, [9.6, 10.9, 0.0], [9.6, 10.9, 3.0], 3.4)
    });
    [("arms", arms), ("ring", ring), ("bowl", bowl)]
}

/// Layers, missed cells, and the order in a number (64-bit FNV-1a over all layers).
fn figures(growth: &Growth) -> (usize, usize, u64) {
    let add = |stamp: u64, word: u32| {
        word.to_le_bytes().iter().fold(stamp, |s, &b| (s ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
    };
    let stamp = growth.order.iter().fold(0xcbf2_9ce4_8422_2325, |stamp, layer| {
        layer.iter().fold(add(stamp, layer.len() as u32), |stamp, &cell| add(stamp, cell))
    });
    (growth.order.len(), growth.missed.len(), stamp)
}

const STRATEGIES: [(&str, Strategy); 8] = [
    ("greedy", Strategy::Greedy),
    ("incremental", Strategy::Incremental),
    ("adaptive", Strategy::Adaptive),
    ("governed", Strategy::Governed(Prevention::Adaptive)),
    ("governed, incremental", Strategy::Governed(Prevention::Incremental)),
    ("printed", Strategy::Printed(Prevention::Adaptive)),
    ("printed, incremental", Strategy::Printed(Prevention::Incremental)),
    ("unbuild", Strategy::Unbuild),
];

/// The order of each strategy on each shape. It changes when a strategy does: then figures in `docs/benchmarks.md` do as well.
#[rustfmt::skip]
const GOLDEN: [[(usize, usize, u64); 8]; 3] = [
    [
        (20, 228, 0x8f4309f0e2ff096d),
        (29, 113, 0xc4f2d4d2db4a243e),
        (29, 113, 0x92ec92093145e76e),
        (31, 113, 0x608e1a47012a65c4),
        (32, 113, 0xb7b5850617e6e436),
        (85, 122, 0xbb8748bd7e5cac8a),
        (85, 113, 0xac7204410ef23b37),
        (35, 101, 0x0adf5353112f67e4),
    ],
    [
        (20, 48, 0x3a625713b497cd75),
        (22, 0, 0x1778fc7da81d8b65),
        (22, 0, 0x91adff71e477954d),
        (32, 0, 0xb1071253d04298cd),
        (32, 0, 0xb1071253d04298cd),
        (32, 0, 0x9ea6fc93103950a1),
        (32, 0, 0x9ea6fc93103950a1),
        (25, 0, 0x84bccb36acac1dcd),
    ],
    [
        (18, 48, 0xd4b342e22346e79e),
        (18, 0, 0x0920df7435eb68ae),
        (18, 0, 0x5d8d44fc1cfbba5e),
        (26, 0, 0xea8b0c9d0cff50b2),
        (26, 0, 0xea8b0c9d0cff50b2),
        (26, 0, 0xea8b0c9d0cff50b2),
        (26, 0, 0xea8b0c9d0cff50b2),
        (19, 0, 0xc48955512bd7df18),
    ],
];

#[test]
fn each_strategy_keeps_its_order() {
    let mut changed = Vec::new();
    for ((shape, part), golden) in shapes().iter().zip(GOLDEN) {
        for ((name, strategy), golden) in STRATEGIES.iter().zip(golden) {
            let (cells, rules) = (part.cells(), Rules { inside_depth_cells: 0.5, ..Rules::default() });
            let growth = strategy.grow(&cells, &part.platform, &rules, &go).unwrap();
            let report = audit(&cells, &part.platform, &rules, &growth.order, &growth.missed_cells(), &go).unwrap();
            assert!(report.is_ok(), "{shape} {name}: {report}");
            let figures = figures(&growth);
            if figures != golden {
                changed.push(format!("{shape} {name}: ({}, {}, {:#018x}),", figures.0, figures.1, figures.2));
            }
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
    // One strategy in the place of another would be found out.
    let orders = |which: usize| GOLDEN.map(|of_shape| of_shape[which].2);
    let distinct: BTreeSet<[u64; 3]> = (0..STRATEGIES.len()).map(orders).collect();
    assert_eq!(distinct.len(), STRATEGIES.len());
}

#[test]
fn what_cannot_be_grown_as_printed_is_refused() {
    let [(_, part), ..] = shapes();
    let (cells, rules) = (part.cells(), Rules::default());
    let run = |rules: &Rules, prevention, field: &SheetField| {
        grow_as_printed(&cells, &part.platform, rules, prevention, field, &go).map(|growth| growth.order.len())
    };
    let field = field_of(&part, |_| 1);
    assert_eq!(run(&rules, Prevention::FewerThanAll, &field), Err(GrowthError::NotPrinted));
    assert!(matches!(run(&rules, Prevention::None, &SheetField::new(vec![1])), Err(GrowthError::Field { .. })));
    let deep = Rules { inside_depth_cells: 17.0, ..rules };
    assert!(matches!(run(&deep, Prevention::None, &field), Err(GrowthError::Rules(_))));
    // Without prevention and governor it is Algorithm 1, and any values will do.
    let greedy = Strategy::Greedy.grow(&cells, &part.platform, &rules, &go).unwrap();
    let one_norm = Rules { neighbours: Neighbours::OneNorm, ..rules };
    assert_ne!(run(&one_norm, Prevention::None, &field), Ok(0));
    let far = field_of(&part, |_| u32::MAX);
    for field in [&field, &far] {
        let growth = grow_as_printed(&cells, &part.platform, &rules, Prevention::None, field, &go).unwrap();
        assert_eq!(growth.order, greedy.order);
    }
}
