//! The audit: each kind of fault, ties, degenerate hulls, and agreement with a slow twin that tries every plane
//! through three points.

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::{
    AuditError, AuditReport, Fault, FaultCounts, Neighbours, Platform, Rules, RulesError, audit,
};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;

type Vec3 = [i64; 3];

fn check(cells: &Cells, platform: &Platform, rules: &Rules, order: &LayerOrder, missed: &[u32]) -> AuditReport {
    audit(cells, platform, rules, order, missed, &|_| ControlFlow::Continue(())).unwrap()
}

/// The bits of the cells for which `solid` holds, in a grid of at most 64 cells along x.
fn bits([nx, ny, nz]: [u32; 3], solid: impl Fn([u32; 3]) -> bool) -> Vec<u64> {
    assert!(nx <= 64);
    let row = |row: u32| (0..nx).filter(|&x| solid([x, row % ny, row / ny])).map(|x| 1 << x).sum();
    (0..ny * nz).map(row).collect()
}

fn order_of(layers: &[Vec<u32>]) -> LayerOrder {
    let mut order = LayerOrder::new();
    layers.iter().for_each(|layer| order.push(layer.iter().copied()));
    order
}

fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Platform {
    Platform::polygon(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).unwrap()
}

/// Faults of the kind `Inside` as cells and depths.
fn insides(report: &AuditReport) -> Vec<(u32, f64)> {
    let inside = |fault: &Fault| match *fault {
        Fault::Inside { cell, depth, .. } => Some((cell, depth)),
        _ => None,
    };
    report.faults.iter().filter_map(inside).collect()
}

// ---- one fault of each kind ----

/// A block of 6 x 6 x 5 cells in a grid of 7 x 7 x 6, layer by level, on a platform a little wider than the block.
struct Block {
    rows: Vec<u64>,
    layers: Vec<Vec<u32>>,
}

const DIMS: [u32; 3] = [7, 7, 6];

fn id([x, y, z]: [u32; 3]) -> u32 {
    x + DIMS[0] * (y + DIMS[1] * z)
}

impl Block {
    fn new() -> Self {
        let rows = bits(DIMS, |[x, y, z]| x < 6 && y < 6 && z < 5);
        let level = |z: u32| (0..36).map(|k| id([k % 6, k / 6, z])).collect();
        Block { rows, layers: (0..5).map(level).collect() }
    }

    fn remove(&mut self, place: [u32; 3]) {
        self.layers.iter_mut().for_each(|layer| layer.retain(|&cell| cell != id(place)));
    }

    fn report(&self, missed: &[u32]) -> AuditReport {
        let cells = Cells::new(DIMS, &self.rows).unwrap();
        let platform = rectangle([-1.0, -1.0], [7.0, 7.0]);
        check(&cells, &platform, &Rules::default(), &order_of(&self.layers), missed)
    }
}

#[test]
fn levels_of_a_block_pass() {
    let report = Block::new().report(&[]);
    assert!(report.is_ok());
    assert_eq!((report.cells, report.layers, report.in_layers, report.missed), (180, 5, 180, 0));
    assert_eq!((report.counts, report.max_depth), (FaultCounts::default(), 0.0));
}

#[test]
fn a_missed_cell_is_no_fault() {
    let mut block = Block::new();
    block.remove([2, 2, 4]);
    let report = block.report(&[id([2, 2, 4])]);
    assert!(report.is_ok());
    assert_eq!((report.in_layers, report.missed), (179, 1));
}

#[test]
fn a_cell_before_its_support_is_found() {
    let mut block = Block::new();
    block.remove([5, 5, 2]);
    block.layers[1].push(id([5, 5, 2])); // with the level below it, not after it
    let report = block.report(&[]);
    assert_eq!(report.faults, [Fault::Unsupported { cell: id([5, 5, 2]), layer: 2 }]);
    assert!(!report.is_ok());
}

#[test]
fn a_cell_off_the_platform_is_found() {
    let block = Block::new();
    let cells = Cells::new(DIMS, &block.rows).unwrap();
    // The platform ends under the centres of x = 5, or half a cell short of them.
    let reaching = rectangle([0.0, 0.0], [5.5, 6.0]);
    assert!(check(&cells, &reaching, &Rules::default(), &order_of(&block.layers), &[]).is_ok());
    let short = rectangle([0.0, 0.0], [5.0, 6.0]);
    let report = check(&cells, &short, &Rules::default(), &order_of(&block.layers), &[]);
    let expected = (0..6).map(|y| Fault::Unsupported { cell: id([5, y, 0]), layer: 1 });
    assert_eq!(report.faults, expected.collect::<Vec<_>>());
}

#[test]
fn a_cell_built_too_late_is_found() {
    let mut block = Block::new();
    block.remove([2, 3, 1]);
    block.layers[3].push(id([2, 3, 1])); // level 2 is there already: one cell deep, and that is inside
    let report = block.report(&[]);
    assert_eq!(report.faults, [Fault::Inside { cell: id([2, 3, 1]), layer: 4, depth: 1.0 }]);
    assert_eq!((report.max_depth, report.counts.inside), (1.0, 1));
}

#[test]
fn a_cell_built_twice_is_found() {
    let mut block = Block::new();
    block.layers[4].push(id([0, 3, 4]));
    assert_eq!(block.report(&[]).faults, [Fault::Repeated { cell: id([0, 3, 4]), layer: 5 }]);
    let mut block = Block::new();
    block.layers[4].push(id([0, 3, 1]));
    assert_eq!(block.report(&[]).faults, [Fault::Repeated { cell: id([0, 3, 1]), layer: 5 }]);
}

#[test]
fn an_empty_cell_is_found() {
    let mut block = Block::new();
    block.layers[2].push(id([6, 0, 2]));
    assert_eq!(block.report(&[]).faults, [Fault::NotSolid { cell: id([6, 0, 2]), layer: 3 }]);
}

#[test]
fn a_lost_cell_is_found() {
    let mut block = Block::new();
    block.remove([3, 3, 4]);
    let report = block.report(&[]);
    assert_eq!(report.faults, [Fault::Lost { cell: id([3, 3, 4]) }]);
    assert_eq!((report.in_layers, report.missed), (179, 0));
}

#[test]
fn faults_of_the_missed_list_are_found() {
    let mut block = Block::new();
    assert_eq!(block.report(&[id([1, 1, 1])]).faults, [Fault::BuiltAndMissed { cell: id([1, 1, 1]) }]);
    assert_eq!(block.report(&[id([6, 6, 5])]).faults, [Fault::MissedNotSolid { cell: id([6, 6, 5]) }]);
    block.remove([1, 1, 4]);
    let twice = [id([1, 1, 4]); 2];
    assert_eq!(block.report(&twice).faults, [Fault::MissedTwice { cell: twice[0] }]);
}

#[test]
fn an_empty_layer_is_found() {
    let mut block = Block::new();
    block.layers.insert(3, Vec::new());
    assert_eq!(block.report(&[]).faults, [Fault::EmptyLayer { layer: 4 }]);
}

#[test]
fn long_lists_of_faults_are_cut_and_counted() {
    let mut block = Block::new();
    block.layers.reverse();
    block.layers.pop();
    let report = block.report(&[]);
    let counts = FaultCounts { unsupported: 36, inside: 3 * 16, lost: 36, ..FaultCounts::default() };
    assert_eq!(report.counts, counts);
    let listed = |kind: fn(&Fault) -> bool| report.faults.iter().filter(|fault| kind(fault)).count();
    assert_eq!(listed(|fault| matches!(fault, Fault::Unsupported { .. })), 20);
    assert_eq!(listed(|fault| matches!(fault, Fault::Inside { .. })), 20);
    assert_eq!(listed(|fault| matches!(fault, Fault::Lost { .. })), 20);
}

// ---- ties ----

/// The depth at which cell `probe` is inside after `first`, if it is, on a small platform that reaches down.
fn depth_after(dims: [u32; 3], first: &[[u32; 3]], probe: [u32; 3], platform: &Platform, rules: &Rules) -> Option<f64> {
    let rows = bits(dims, |place| place == probe || first.contains(&place));
    let cells = Cells::new(dims, &rows).unwrap();
    let ids = first.iter().map(|&place| cells.id(place)).collect();
    let order = order_of(&[ids, vec![cells.id(probe)]]);
    let report = check(&cells, platform, rules, &order, &[]);
    let found = insides(&report).into_iter().filter(|&(cell, _)| cell == cells.id(probe)).collect::<Vec<_>>();
    found.first().map(|&(_, depth)| depth)
}

/// The tie at `depth` is inside, and a thousandth of a cell more is asked in vain.
fn assert_depth(depth: f64, dims: [u32; 3], first: &[[u32; 3]], probe: [u32; 3], platform: &Platform, flat: bool) {
    let with = |eps: f64| {
        let rules = Rules { inside_depth_cells: eps, flat, ..Rules::default() };
        depth_after(dims, first, probe, platform, &rules)
    };
    assert_eq!(with(depth), Some(depth));
    assert_eq!(with(depth + 1.0 / 1024.0), None);
    if depth > 0.0 {
        assert_eq!(with(depth - 1.0 / 1024.0), Some(depth));
    }
}

#[test]
fn ties_on_a_3_4_5_plane_are_exact() {
    // The ridge from [0, y, 9] to [12, y, 0] in cells has the normal [3, 0, 4].
    let dims = [14, 9, 10];
    let first = [[0, 0, 9], [0, 8, 9], [12, 0, 0], [12, 8, 0]];
    let platform = rectangle([0.0, 0.0], [1.0, 9.0]);
    // Cells below the plane by (3 dx + 4 dz) / 5 cells: 36 - 3x - 4z = 0, 5, 10, 1.
    for (probe, depth) in [([4, 4, 6], 0.0), ([1, 4, 7], 1.0), ([5, 4, 4], 1.0), ([6, 4, 2], 2.0)] {
        assert_depth(depth, dims, &first, probe, &platform, false);
    }
    for eps in [0.0, 0.5, 1.0, 2.0] {
        let rules = Rules { inside_depth_cells: eps, ..Rules::default() };
        let depth = depth_after(dims, &first, [5, 4, 5], &platform, &rules); // 0.2 cells deep
        assert_eq!(depth.is_some(), eps < 0.2, "{eps}");
        assert_eq!(depth_after(dims, &first, [4, 4, 7], &platform, &rules), None); // 0.8 cells above
    }
}

#[test]
fn ties_on_a_3_4_5_edge_of_a_flat_object_are_exact() {
    let dims = [14, 1, 10];
    let platform = Platform::segment(0.0, 1.0).unwrap();
    for (probe, depth) in [([4, 0, 6], 0.0), ([1, 0, 7], 1.0), ([5, 0, 4], 1.0), ([6, 0, 2], 2.0)] {
        assert_depth(depth, dims, &[[0, 0, 9], [12, 0, 0]], probe, &platform, true);
    }
}

#[test]
fn ties_on_a_1_2_2_plane_are_exact() {
    // The plane x + 2y + 2z = 24 in cells; its normal has length 3.
    let dims = [25, 13, 13];
    let first = [[24, 0, 0], [0, 12, 0], [0, 0, 12]];
    let platform = rectangle([0.0, 0.0], [1.0, 1.0]);
    for (probe, depth) in [([4, 5, 5], 0.0), ([5, 4, 4], 1.0), ([7, 3, 4], 1.0), ([4, 4, 3], 2.0)] {
        assert_depth(depth, dims, &first, probe, &platform, false);
    }
}

#[test]
fn a_margin_that_is_no_integer_is_rounded_up() {
    // Half a cell straight below a slope of 1 in 2048: short of half a cell deep by six parts in a hundred million.
    let dims = [2049, 1, 4];
    let mut rows = vec![0u64; 33 * 4];
    rows[33 * 3] = 1; // [0, 0, 3]
    rows[33 * 2 + 32] = 1; // [2048, 0, 2]
    rows[33 * 2 + 16] = 1; // the probe, [1024, 0, 2]
    let cells = Cells::new(dims, &rows).unwrap();
    let platform = Platform::segment(0.0, 2049.0).unwrap();
    let [left, right, probe] = [[0, 0, 3], [2048, 0, 2], [1024, 0, 2]].map(|place| cells.id(place));
    let order = order_of(&[vec![left, right], vec![probe]]);
    let with = |eps: f64| {
        insides(&check(
            &cells,
            &platform,
            &Rules { inside_depth_cells: eps, flat: true, ..Rules::default() },
            &order,
            &[],
        ))
    };
    assert_eq!(with(0.5), []);
    let [(cell, depth)] = with(511.0 / 1024.0)[..] else { panic!("inside by a thousandth of a cell") };
    assert_eq!(cell, probe);
    assert!((0.4999999..0.5).contains(&depth), "{depth}");
}

#[test]
fn the_largest_coordinates_do_not_overflow() {
    let reach = f64::from(Platform::REACH) / 2.0;
    let platform = rectangle([-reach, -reach], [reach, reach]);
    for dims in [[Cells::MAX_SIDE, 3, 2], [3, Cells::MAX_SIDE, 2], [2, 3, Cells::MAX_SIDE]] {
        let words = dims[0].div_ceil(64) as usize;
        let mut rows = vec![0u64; words * dims[1] as usize * dims[2] as usize];
        let places = [[0, 0, 0], dims.map(|side| side - 1), [1, 0, 0], [0, 2, 0], dims.map(|side| side / 2)];
        for [x, y, z] in places {
            rows[words * (y + dims[1] * z) as usize + x as usize / 64] |= 1 << (x % 64);
        }
        let cells = Cells::new(dims, &rows).unwrap();
        let layers: Vec<_> = places.iter().map(|&place| vec![cells.id(place)]).collect();
        for (eps, platform) in [(16.0, platform.clone()), (0.0, platform.clone().elevated(-Platform::REACH).unwrap())] {
            let rules = Rules { inside_depth_cells: eps, ..Rules::default() };
            let report = check(&cells, &platform, &rules, &order_of(&layers), &[]);
            assert_same(&report.faults, &slow_audit(&cells, &platform, &rules, &layers, &[]));
            assert!(report.counts.inside > 0 || dims[2] == 2, "cells in a tall cone are inside");
        }
    }
}

#[test]
fn eps_0_counts_the_surface_and_the_plate_itself() {
    let surface = Rules { inside_depth_cells: 0.0, ..Rules::default() };
    let dims = [5, 5, 3];
    let platform = rectangle([0.0, 0.0], [5.0, 5.0]);
    let corners = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]];
    assert_eq!(depth_after(dims, &corners, [2, 2, 0], &platform, &surface), Some(0.0));
    assert_eq!(depth_after(dims, &corners, [2, 0, 0], &platform, &surface), Some(0.0));
    assert_eq!(depth_after(dims, &corners, [2, 2, 1], &platform, &surface), None);
    // A plate at the height of the first centres: its points are inside a hull without volume.
    let through = platform.elevated(1).unwrap();
    assert_eq!(depth_after(dims, &[], [2, 2, 0], &through, &surface), Some(0.0));
    assert_eq!(depth_after(dims, &[], [2, 2, 1], &through, &surface), None);
    let barely = Rules { inside_depth_cells: 1.0 / 1024.0, ..surface };
    assert_eq!(depth_after(dims, &[], [2, 2, 0], &through, &barely), None);
}

// ---- platforms ----

#[test]
fn below_an_overhang_only_a_platform_that_reaches_down_shadows() {
    // A mushroom: a stem in the middle, a cap at the top; the probe hangs below the cap's rim.
    let dims = [21, 21, 6];
    let cap = [[0, 0, 5], [20, 0, 5], [20, 20, 5], [0, 20, 5], [10, 10, 0]];
    let platform = rectangle([9.0, 9.0], [12.0, 12.0]);
    let rules = Rules::default();
    assert_eq!(depth_after(dims, &cap, [2, 10, 1], &platform, &rules), Some(2.0));
    let thin = platform.elevated(0).unwrap();
    assert_eq!(depth_after(dims, &cap, [2, 10, 1], &thin, &rules), None);
    let near_the_cap = depth_after(dims, &cap, [10, 10, 3], &thin, &rules);
    assert_eq!(near_the_cap, Some(2.0));
}

#[test]
fn the_two_neighbour_rules_differ_two_steps_away() {
    let dims = [3, 1, 3];
    let rows = bits(dims, |[x, _, z]| (x == 0 && z == 0) || (x == 2 && z == 2) || (x == 0 && z == 2));
    let cells = Cells::new(dims, &rows).unwrap();
    let order = order_of(&[vec![0], vec![6], vec![8]]);
    let platform = rectangle([0.0, 0.0], [1.0, 1.0]);
    let strict = check(&cells, &platform, &Rules::default(), &order, &[]);
    let unsupported = [(6, 2), (8, 3)].map(|(cell, layer)| Fault::Unsupported { cell, layer });
    assert_eq!(strict.faults, unsupported);
    let rules = Rules { neighbours: Neighbours::OneNorm, ..Rules::default() };
    assert!(check(&cells, &platform, &rules, &order, &[]).is_ok());
}

// ---- errors, progress, nothing at all ----

#[test]
fn unsound_input_is_refused() {
    let rows = [1, 1, 1, 1];
    let cells = Cells::new([1, 2, 2], &rows).unwrap();
    let platform = rectangle([0.0, 0.0], [1.0, 2.0]);
    let run = |rules: Rules, order: &LayerOrder, missed: &[u32]| {
        audit(&cells, &platform, &rules, order, missed, &|_| ControlFlow::Continue(()))
    };
    let none = LayerOrder::new();
    let eps = Rules { inside_depth_cells: -1.0, ..Rules::default() };
    assert_eq!(run(eps, &none, &[]), Err(AuditError::Rules(RulesError::InsideDepth { cells: -1.0 })));
    let flat = Rules { flat: true, ..Rules::default() };
    assert_eq!(run(flat, &none, &[]), Err(AuditError::Rules(RulesError::NotFlat { ny: 2 })));
    let outside = Err(AuditError::OutsideGrid { cell: 4, len: 4 });
    assert_eq!(run(Rules::default(), &order_of(&[vec![0, 4]]), &[]), outside);
    assert_eq!(run(Rules::default(), &none, &[4]), outside);
}

#[test]
fn no_order_loses_all_and_no_solid_is_fine() {
    let platform = rectangle([0.0, 0.0], [1.0, 1.0]);
    let cells = Cells::new([2, 1, 1], &[0b11]).unwrap();
    let report = check(&cells, &platform, &Rules::default(), &LayerOrder::new(), &[]);
    assert_eq!(report.faults, [Fault::Lost { cell: 0 }, Fault::Lost { cell: 1 }]);
    let nothing = Cells::new([2, 1, 1], &[0]).unwrap();
    assert!(check(&nothing, &platform, &Rules::default(), &LayerOrder::new(), &[]).is_ok());
}

#[test]
fn progress_rises_to_the_end_and_can_cancel() {
    let dims = [64, 64, 5];
    let rows = vec![u64::MAX; 64 * 5];
    let cells = Cells::new(dims, &rows).unwrap();
    let platform = Platform::under(&cells, 1.0).unwrap();
    let order = order_of(&(0..5).map(|z| (z * 4096..(z + 1) * 4096).collect()).collect::<Vec<_>>());
    let seen = Mutex::new(Vec::new());
    let run = |stop_at: u64| {
        audit(&cells, &platform, &Rules::default(), &order, &[], &|now| {
            seen.lock().unwrap().push(now.done);
            assert_eq!((now.stage, now.total), ("audit", 5 * 4096));
            if now.done >= stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    };
    assert!(run(u64::MAX).unwrap().is_ok());
    let reports = seen.lock().unwrap().split_off(0);
    assert!(reports.len() > 3 && reports.is_sorted() && reports.last() == Some(&(5 * 4096)));
    assert_eq!(run(4096), Err(AuditError::Cancelled));
    assert!(seen.lock().unwrap().iter().all(|&done| done <= 4096));
}

// ---- the slow twin ----

fn dot(a: Vec3, b: Vec3) -> i64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// The depth of `c` if it is inside the hull of `points` at least `eps` / 1024 cells deep, or deeper if not `closed`: every plane through three of
/// the points (flat: every line through two), every vertical plane through two and both horizontal directions are
/// tried; all facets are among them.
fn slow_depth(points: &[Vec3], c: Vec3, (eps, closed): (i128, bool), flat: bool, reaches_down: bool) -> Option<f64> {
    let minus = |a: Vec3, b: Vec3| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let mut normals = vec![[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0]];
    for (i, &p) in points.iter().enumerate() {
        for (j, &q) in points[..i].iter().enumerate() {
            let [ux, uy, uz] = minus(q, p);
            if flat {
                normals.extend([[uz, 0, -ux], [-uz, 0, ux]]);
                continue;
            }
            normals.extend([[uy, -ux, 0], [-uy, ux, 0]]);
            for &r in &points[..j] {
                let [vx, vy, vz] = minus(r, p);
                let n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
                normals.extend([n, n.map(|k| -k)]);
            }
        }
    }
    let mut depth = f64::INFINITY;
    for n in normals {
        if n == [0; 3] || (reaches_down && n[2] < 0) {
            continue;
        }
        let slack = points.iter().map(|&point| dot(n, point)).max().unwrap() - dot(n, c);
        let norm2: i128 = n.iter().map(|&k| i128::from(k).pow(2)).sum();
        // slack half cells / |n| against eps / 512 half cells
        let [own, least] = [i128::from(slack).pow(2) << 18, eps.pow(2) * norm2];
        if slack < 0 || own < least || (own == least && !closed) {
            return None;
        }
        depth = depth.min(slack as f64 / (norm2 as f64).sqrt() / 2.0);
    }
    Some(depth)
}

/// All faults of an order, found the slow way.
fn slow_audit(cells: &Cells, platform: &Platform, rules: &Rules, layers: &[Vec<u32>], missed: &[u32]) -> Vec<Fault> {
    let centre = |cell: u32| cells.position(cell).map(|k| 2 * i64::from(k) + 1);
    let solid = |cell: u32| cells.iter().any(|other| other == cell);
    let corners = platform.corners().iter().map(|&[x, y]| [x, y, platform.top()].map(i64::from));
    let mut points: Vec<Vec3> = corners.collect();
    let corners = points.len();
    let mut faults = Vec::new();
    let mut built: Vec<u32> = Vec::new();
    for (k, of_layer) in layers.iter().enumerate() {
        let layer = k as u32 + 1;
        if of_layer.is_empty() {
            faults.push(Fault::EmptyLayer { layer });
        }
        let earlier = built.len();
        for &cell in of_layer {
            let [x, y, z] = centre(cell);
            if !solid(cell) {
                faults.push(Fault::NotSolid { cell, layer });
                continue;
            }
            if built.contains(&cell) {
                faults.push(Fault::Repeated { cell, layer });
                continue;
            }
            let touches = |&other: &u32| {
                let other = centre(other);
                let steps = [0, 1, 2].map(|k| (centre(cell)[k] - other[k]).abs() / 2);
                let (norm, reach) = (steps.iter().sum::<i64>(), steps[0].max(steps[1]).max(steps[2]));
                norm <= 2 && (reach <= 1 || rules.neighbours == Neighbours::OneNorm)
            };
            // On the platform: no line through two corners has all corners on one side and the centre on the other.
            let stands = z == 1
                && (0..corners).all(|i| {
                    (0..corners).all(|j| {
                        let n = if rules.flat {
                            [[1, 0, 0], [-1, 0, 0]][i % 2]
                        } else {
                            [points[j][1] - points[i][1], points[i][0] - points[j][0], 0]
                        };
                        points[..corners].iter().any(|&corner| dot(n, corner) >= dot(n, [x, y, 0]))
                    })
                });
            if !stands && !built[..earlier].iter().any(touches) {
                faults.push(Fault::Unsupported { cell, layer });
            }
            let eps = (i128::from(rules.inside_depth_in_1024ths().unwrap()), rules.boundary_is_inside);
            if let Some(depth) = slow_depth(&points, [x, y, z], eps, rules.flat, platform.reaches_down()) {
                faults.push(Fault::Inside { cell, layer, depth });
            }
            built.push(cell);
        }
        points.extend(built[earlier..].iter().map(|&cell| centre(cell)));
    }
    for (at, &cell) in missed.iter().enumerate() {
        if !solid(cell) {
            faults.push(Fault::MissedNotSolid { cell });
        } else if missed[..at].contains(&cell) {
            faults.push(Fault::MissedTwice { cell });
        } else if built.contains(&cell) {
            faults.push(Fault::BuiltAndMissed { cell });
        }
    }
    let lost = cells.iter().filter(|cell| !built.contains(cell) && !missed.contains(cell));
    faults.extend(lost.map(|cell| Fault::Lost { cell }));
    faults
}

fn assert_same(fast: &[Fault], slow: &[Fault]) {
    let strip = |fault: &Fault| match *fault {
        Fault::Inside { cell, layer, .. } => Fault::Inside { cell, layer, depth: 0.0 },
        other => other,
    };
    assert_eq!(fast.iter().map(strip).collect::<Vec<_>>(), slow.iter().map(strip).collect::<Vec<_>>());
    for pair in fast.iter().zip(slow) {
        if let (&Fault::Inside { depth: fast, .. }, &Fault::Inside { depth: slow, .. }) = pair {
            assert!((fast - slow).abs() < 1e-12, "{fast} {slow}");
        }
    }
}

fn some_platform() -> impl Strategy<Value = Platform> {
    let corner = || (-4i32..20, -4i32..20).prop_map(|(x, y)| [f64::from(x) / 2.0, f64::from(y) / 2.0]);
    let polygon = proptest::collection::vec(corner(), 3..6);
    let sound = polygon.prop_filter_map("no area", |corners| Platform::polygon(&corners).ok());
    (sound, proptest::option::of(-3i32..3))
        .prop_map(|(platform, top)| top.map_or(platform.clone(), |top| platform.elevated(top).unwrap()))
}

fn some_rules() -> impl Strategy<Value = Rules> {
    let eps = prop::sample::select(vec![0.0, 0.25, 0.5, 0.7, 1.0, 1.5, 2.0]);
    (eps, any::<[bool; 3]>()).prop_map(|(eps, [boundary_is_inside, one_norm, flat])| Rules {
        inside_depth_cells: eps,
        boundary_is_inside,
        neighbours: if one_norm { Neighbours::OneNorm } else { Neighbours::FaceOrEdge },
        flat,
    })
}

/// Which cells come in which layer: dims, entries (cell, layer or missed or forgotten), empty cells among them.
type Scatter = ([u32; 3], Vec<(u32, u32)>, Vec<u32>);

fn scatter() -> impl Strategy<Value = Scatter> {
    [1u32..10, 1u32..10, 1u32..8].prop_flat_map(|dims| {
        let len = dims.iter().product::<u32>();
        let entries = proptest::collection::vec((0..len, 0u32..8), 0..18);
        (Just(dims), entries, proptest::collection::vec(0..len, 0..2))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Scattered cells, some twice, some forgotten, some empty: every fault and every depth agrees.
    #[test]
    fn agrees_with_the_slow_twin((dims, entries, empty) in scatter(), platform in some_platform(), rules in some_rules()) {
        let [nx, mut ny, nz] = dims;
        if rules.flat {
            ny = 1;
        }
        let dims = [nx, ny, nz];
        let len = nx * ny * nz;
        let entries: Vec<_> = entries.iter().map(|&(cell, layer)| (cell % len, layer)).collect();
        let rows = bits(dims, |[x, y, z]| {
            let cell = x + nx * (y + ny * z);
            entries.iter().any(|entry| entry.0 == cell) && !empty.contains(&cell)
        });
        let cells = Cells::new(dims, &rows).unwrap();
        let in_layer = |layer: u32| entries.iter().filter(move |entry| entry.1 == layer).map(|entry| entry.0).collect();
        let layers: Vec<Vec<u32>> = (0..6).map(in_layer).collect();
        let missed: Vec<u32> = in_layer(6);
        let report = check(&cells, &platform, &rules, &order_of(&layers), &missed);
        assert_same(&report.faults, &slow_audit(&cells, &platform, &rules, &layers, &missed));
        prop_assert_eq!(report.faults.is_empty(), report.counts == FaultCounts::default());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Fuller hulls: 40 cells of a lattice ball or a box, then cells anywhere in the grid.
    #[test]
    fn agrees_on_round_and_boxy_bodies(
        body in proptest::collection::vec((0u32..16, 0u32..16, 0u32..12), 40),
        probes in proptest::collection::vec((0u32..16, 0u32..16, 0u32..12), 40),
        round in any::<bool>(),
        platform in some_platform(),
        mut rules in some_rules(),
    ) {
        rules.flat = false;
        let dims = [16, 16, 12];
        let push_out = |(x, y, z): (u32, u32, u32)| {
            let from = [f64::from(x) - 7.5, f64::from(y) - 7.5, f64::from(z) - 5.5];
            let norm = from.iter().map(|k| k * k).sum::<f64>().sqrt();
            if round { [0, 1, 2].map(|k| (from[k] / norm * 5.5 + [7.5, 7.5, 5.5][k]).round() as u32) } else { [x, y, z] }
        };
        let number = |[x, y, z]: [u32; 3]| x + 16 * (y + 16 * z);
        let mut first: Vec<u32> = body.into_iter().map(|cell| number(push_out(cell))).collect();
        first.sort_unstable();
        first.dedup();
        let mut then: Vec<u32> = probes.into_iter().map(|(x, y, z)| number([x, y, z])).collect();
        then.sort_unstable();
        then.dedup();
        then.retain(|cell| !first.contains(cell));
        let (early, late) = first.split_at(first.len() / 2);
        let layers = vec![early.to_vec(), late.to_vec(), then];
        let all: Vec<u32> = layers.concat();
        let rows = bits(dims, |place| all.contains(&number(place)));
        let cells = Cells::new(dims, &rows).unwrap();
        let report = check(&cells, &platform, &rules, &order_of(&layers), &[]);
        let listed = |wanted: fn(&Fault) -> bool, faults: &[Fault]| -> Vec<Fault> {
            faults.iter().copied().filter(wanted).take(20).collect()
        };
        let slow = slow_audit(&cells, &platform, &rules, &layers, &[]);
        for kind in [|f: &Fault| matches!(f, Fault::Inside { .. }), |f: &Fault| matches!(f, Fault::Unsupported { .. })] {
            assert_same(&listed(kind, &report.faults), &listed(kind, &slow));
        }
        let inside = slow.iter().filter(|fault| matches!(fault, Fault::Inside { .. })).count();
        prop_assert_eq!(report.counts.inside, inside);
        prop_assert_eq!(report.counts.inside + report.counts.unsupported, slow.len());
    }
}
