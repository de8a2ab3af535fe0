//! Beads that fit, judged by the independent statistics.

use crate::common::{go_on, grid, rng, to_boundary};
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3};
use curvlay_toolpath::path::{LayerPaths, PathOptions};
use curvlay_toolpath::statistics::{BeadCurve, PathStatistics, StatisticsOptions, path_statistics};
use proptest::prelude::*;
use rand::RngExt;

fn filled(distance: &SurfaceDistance, bead: f64, fitted: bool) -> LayerPaths {
    let mut options = PathOptions::default();
    (options.bead, options.fitted) = (bead, fitted);
    LevelField::new(distance, 0.005, &go_on).unwrap().paths(&options, &go_on).unwrap()
}

fn statistics(mesh: &SurfaceMesh, filled: &LayerPaths) -> PathStatistics {
    let split = |path: &curvlay_toolpath::path::SurfacePath| -> (Vec<Point3<f64>>, Vec<f64>) {
        path.points.iter().map(|p| (p.at.position, p.width)).unzip()
    };
    let curves: Vec<_> = filled.paths.iter().map(split).collect();
    let curves: Vec<_> = curves.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    path_statistics(mesh.vertices(), mesh.triangles(), &curves, &StatisticsOptions::default(), &go_on).unwrap()
}

fn in_range(filled: &LayerPaths, bead: f64) -> bool {
    let widths = filled.paths.iter().flat_map(|path| &path.points).map(|point| point.width);
    widths.into_iter().all(|w| (0.75 * bead - 1e-9..=1.25 * bead + 1e-9).contains(&w))
}

/// A plate of 30 mm by `width`, in triangles of about a millimetre.
fn strip(width: f64) -> SurfaceMesh {
    let rows = width.ceil();
    grid(30, 11, 0.5, |_, j| j >= rows as usize, |p| Point3::new(p.x, p.y * width / rows, 0.0))
}

#[test]
fn strips_of_any_width_are_full() {
    for width in [1.55, 1.9, 2.2, 2.45, 3.05, 3.5, 3.9, 4.4, 4.95, 5.5, 6.3, 7.0, 7.7, 8.4] {
        let mesh = strip(width);
        let distance = to_boundary(&mesh);
        let got = filled(&distance, 1.0, true);
        assert_eq!((got.paths.len(), got.regions), (1, 1), "{width}");
        assert!(in_range(&got, 1.0), "{width}");
        let found = statistics(&mesh, &got);
        assert_eq!(found.self_crossings, 0, "{width}");
        assert!(found.covered_fraction > 0.96, "{width}: {found:?}");
        assert!(found.overlap_fraction < 0.025 && found.spill_fraction < 0.004, "{width}: {found:?}");
    }
}

#[test]
fn widths_follow_the_way_across() {
    // Two beads across a wedge that is 1.6 to 2.4 mm wide.
    let mesh = grid(30, 3, 0.4, |_, j| j >= 2, |p| Point3::new(p.x, (p.y - 1.0) * (0.8 + 0.4 * p.x / 30.0), 0.0));
    let distance = to_boundary(&mesh);
    let got = filled(&distance, 1.0, true);
    assert_eq!((got.paths.len(), got.regions), (1, 1));
    let inner = got.paths[0].points.iter().filter(|p| (3.0..27.0).contains(&p.at.position.x));
    for point in inner {
        let across = 2.0 * (0.8 + 0.4 * point.at.position.x / 30.0);
        assert!((point.width - across / 2.0).abs() < 0.03, "{point:?}");
    }
    let found = statistics(&mesh, &got);
    assert!(found.covered_fraction > 0.98 && found.overlap_fraction < 0.03, "{found:?}");
}

#[test]
fn rims_of_three_beads_fit_better_than_even_ones() {
    // Two walls around holes on a hill, where even beads leave a gap or lie twice along the middle.
    let hill = |p: Point2<f64>| Point3::new(p.x, p.y, 0.05 * (p.x - 12.0) * (p.y - 12.0));
    let hole = |i: usize, j: usize| {
        let apart = |x: f64| (i as f64 + 0.5 - x).abs().max((j as f64 + 0.5 - 12.0).abs());
        apart(7.0) < 3.6 || apart(17.0) < 3.6
    };
    let mesh = grid(24, 3, 0.5, hole, hill);
    let distance = to_boundary(&mesh);
    let [mut even_faults, mut fitted_faults] = [0.0; 2];
    for bead in [0.6, 0.7, 0.8, 0.9, 1.0] {
        let [even, fitted] = [false, true].map(|fit| filled(&distance, bead, fit));
        assert_eq!((fitted.paths.len(), fitted.regions), (1, 1));
        assert!(in_range(&fitted, bead));
        let [even, fitted] = [even, fitted].map(|got| statistics(&mesh, &got));
        assert_eq!(fitted.self_crossings, 0);
        assert!(fitted.covered_fraction > 0.93 && fitted.overlap_fraction < 0.04, "{bead} {fitted:?}");
        let faults = |of: &PathStatistics| 1.0 - of.covered_fraction + of.overlap_fraction;
        even_faults += faults(&even);
        fitted_faults += faults(&fitted);
    }
    assert!(fitted_faults < 0.85 * even_faults, "{fitted_faults} {even_faults}");
}

/// Corridors two squares wide between blocks of five by five squares, with heights at random.
fn corridors(hole: &[bool], seed: u64, height: f64) -> SurfaceMesh {
    let in_block = |i: usize, j: usize| i % 5 >= 2 && j % 5 >= 2 && i / 5 < 4 && j / 5 < 4;
    let there = |i: usize, j: usize| !in_block(i, j) || hole[i / 5 + 4 * (j / 5)];
    let mut heights = rng(seed);
    let place = |p: Point2<f64>| Point3::new(p.x, p.y, height * (heights.random::<f64>() - 0.5));
    grid(22, seed, 0.6, |i, j| !there(i, j), place)
}

/// One curve a region that crosses nothing, in corridors drawn by a number.
fn corridors_are_sound(number: u64) {
    let mut draw = rng(number);
    let hole: Vec<bool> = (0..16).map(|_| draw.random::<f64>() < 0.8).collect();
    let seed = draw.random_range(0..1000_u64);
    let height = if number.is_multiple_of(4) { 0.0 } else { draw.random::<f64>() };
    let bead = 0.4 + 0.6 * draw.random::<f64>();
    let mesh = corridors(&hole, seed, height);
    let got = filled(&to_boundary(&mesh), bead, true);
    assert_eq!(got.paths.len(), got.regions, "{number}");
    assert_eq!(statistics(&mesh, &got).self_crossings, 0, "{number}");
}

#[test]
fn bridges_keep_clear_of_rings_that_turn_back() {
    // A bridge crossed itself or the end of the ring that it came from.
    [22, 82, 136].into_iter().for_each(corridors_are_sound);
}

#[test]
fn very_small_rings_beside_none_are_left_out() {
    // They became curves of their own, about a bead long.
    [13, 59, 104, 109, 127].into_iter().for_each(corridors_are_sound);
}

#[test]
fn bridges_keep_clear_of_needles() {
    // Rings as thin as needles: a bridge came to its ring through the other side of it (188), or crossed one that it had
    // nothing to do with (196), between two of its points. Bridges that were chords over crests (46).
    [46, 144, 171, 188, 196].into_iter().for_each(corridors_are_sound);
}

#[test]
fn small_rings_that_no_bridge_leads_to_give_way_to_single_beads() {
    // Rings of 2.1 to 2.5 beads on a ridge, with a ring beside them nowhere along their side: second curves of a region.
    [324, 475].into_iter().for_each(corridors_are_sound);
}

#[test]
fn what_rings_leave_between_three_holes_is_filled() {
    // Three blocks with room for one bead more where they meet.
    let block = |i: usize, j: usize| (j < 6 && !(6..9).contains(&i)) || (j >= 9 && (4..11).contains(&i));
    let mesh = grid(15, 3, 0.3, block, |p| Point3::new(p.x, p.y, 0.0));
    let distance = to_boundary(&mesh);
    for bead in [0.9, 1.0, 1.1, 1.25, 1.4] {
        let got = filled(&distance, bead, true);
        assert!(in_range(&got, bead));
        let found = statistics(&mesh, &got);
        assert_eq!(found.self_crossings, 0, "{bead}");
        assert!(found.covered_fraction > 0.94 && found.overlap_fraction < 0.06, "{bead} {found:?}");
        assert!(found.largest_gap.unwrap().radius_mm < 0.45 * bead, "{bead} {found:?}");
    }
}

#[test]
fn branches_and_dots_get_beads_of_their_own() {
    // A cross of four arms, less than a bead wide and three long: one bead through two arms, one in each of the others.
    let cross = |i: usize, j: usize| i != 7 && j != 7;
    let mesh = grid(15, 3, 0.0, cross, |p| Point3::new(0.8 * p.x, 0.8 * p.y, 0.0));
    let got = filled(&to_boundary(&mesh), 0.9, true);
    assert_eq!((got.paths.len(), got.regions), (3, 3));
    let found = statistics(&mesh, &got);
    assert!(found.covered_fraction > 0.97 && found.self_crossings == 0, "{found:?}");
    // A square with room for no more than a dot.
    let mesh = grid(1, 3, 0.0, |_, _| false, |p| Point3::new(p.x, p.y, 0.0));
    let got = filled(&to_boundary(&mesh), 1.0, true);
    assert_eq!((got.paths.len(), got.unfilled.len()), (1, 0));
    assert!((got.paths[0].length() - 0.25).abs() < 0.01 && statistics(&mesh, &got).covered_fraction > 0.8);
}

#[test]
fn gaps_are_filled_from_the_least_on() {
    let mesh = corridors(&[true; 16], 5, 0.5);
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
    let apart = PathOptions { bead: 0.6, join_distance: 0.0, min_length: 0.0, ..PathOptions::default() };
    let with = |min_gap: f64| field.paths(&PathOptions { min_gap, ..apart }, &go_on).unwrap();
    let [every, large, none] = [0.0, 1.0, 100.0].map(with);
    assert!(every.paths.len() > large.paths.len() && large.paths.len() >= none.paths.len());
    // The spirals are the same, and so are the single beads that stay.
    assert!(
        [&large, &none]
            .iter()
            .all(|some| some.paths.iter().all(|path| { every.paths.iter().any(|one| one.points == path.points) }))
    );
    let covered = |some: &LayerPaths| statistics(&mesh, some).covered_fraction;
    assert!(covered(&every) >= covered(&large) && covered(&large) >= covered(&none));
    // Without another curve there is no gap: the one bead that fits is laid, whatever it covers.
    let dot = grid(1, 3, 0.0, |_, _| false, |p| Point3::new(p.x, p.y, 0.0));
    let distance = to_boundary(&dot);
    let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
    let options = PathOptions { bead: 1.0, min_gap: 100.0, ..PathOptions::default() };
    assert_eq!(field.paths(&options, &go_on).unwrap().paths.len(), 1);
}

#[test]
fn corridors_are_one_curve_without_crossing() {
    (0..24).for_each(corridors_are_sound);
}

/// A region whose curve is too short is left out: the test below had counted it among those that get one.
#[test]
fn a_region_may_be_too_short_for_a_curve() {
    let hole: Vec<bool> = (0..16).map(|k| ![1, 3, 15].contains(&k)).collect();
    let mesh = corridors(&hole, 230, 0.935_774_802_995_061_1);
    let got = filled(&to_boundary(&mesh), 0.880_016_699_383_378_1, true);
    assert_eq!((got.regions, got.paths.len(), got.short.len()), (2, 1, 1));
    assert!(statistics(&mesh, &got).covered_fraction > 0.85);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn rough_corridors_are_covered(
        hole in prop::collection::vec(prop::bool::weighted(0.8), 16),
        seed in 0_u64..1000,
        height in 0.0..1.0_f64,
        bead in 0.4..1.0_f64,
    ) {
        let mesh = corridors(&hole, seed, height);
        let distance = to_boundary(&mesh);
        let got = filled(&distance, bead, true);
        // Where a region branches, rings may nowhere run side by side: then it gets one more curve (one in a hundred).
        let curves = got.paths.len() + got.short.len();
        prop_assert!((got.regions..=got.regions + 1).contains(&curves), "{} {}", got.regions, curves);
        let longest = got.short.iter().map(|path| path.length()).fold(0.0, f64::max);
        prop_assert!(longest < PathOptions::default().min_length * bead, "{longest} mm is not short");
        prop_assert!(in_range(&got, bead));
        let found = statistics(&mesh, &got);
        prop_assert!(found.covered_fraction > 0.85, "{:?}", found);
        prop_assert_eq!(found.self_crossings, 0);
    }
}
