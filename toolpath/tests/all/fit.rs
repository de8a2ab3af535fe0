//! Beads that fit nowhere, and beads so narrow that their points would not fit into memory: reported, and in no time.

use crate::common::go_on;
use curvlay_toolpath::Progress;
use curvlay_toolpath::fill::{FillEstimate, FillLayersError, estimate_fill, fill_layer, fill_layers};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{PathOptions, Unfilled, UnfilledReason};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Level rectangles, one above the other.
fn walls(wide: f64, long: f64) -> Vec<[Point3<f64>; 4]> {
    let level = |z: f64| [[0.0, 0.0], [wide, 0.0], [wide, long], [0.0, long]].map(|[x, y]| Point3::new(x, y, z));
    (0..3).map(|k| level(0.4 + 0.8 * f64::from(k))).collect()
}

fn surfaces(walls: &[[Point3<f64>; 4]]) -> Vec<LayerSurface<'_>> {
    let surface =
        |vertices| LayerSurface { vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
    walls.iter().map(|wall| surface(&wall[..])).collect()
}

#[test]
fn a_bead_wider_than_the_part_is_refused_with_one_that_fits() {
    for (wide, bead, fitted) in [(30.0, 100.0, true), (0.3, 0.8, true), (0.3, 0.8, false), (30.0, 1e6, false)] {
        let walls = walls(wide, 30.0);
        let options = PathOptions { bead, fitted, ..PathOptions::default() };
        let error = fill_layers(&surfaces(&walls), &options, &go_on).unwrap_err();
        let FillLayersError::NothingFits { bead: reported, widest_mm, fits_mm } = error else { panic!("{error}") };
        assert!(reported >= bead && (widest_mm - wide).abs() < 1e-6 * wide, "{error}");
        assert!(error.to_string().contains("fits nowhere"), "{error}");
        // What it says fits does.
        let options = PathOptions { bead: fits_mm, ..options };
        assert!(fill_layers(&surfaces(&walls), &options, &go_on).unwrap().totals().curves > 0);
    }
}

#[test]
fn what_no_bead_fits_into_is_all_unfillable() {
    let walls = walls(0.3, 30.0);
    let filled = fill_layer(&surfaces(&walls)[0], &PathOptions::default(), &go_on).unwrap();
    assert!(filled.paths.paths.is_empty() && filled.statistics.covered_fraction <= 0.0);
    assert!(filled.statistics.unfillable_fraction >= 1.0);
    assert!((filled.reach_mm - 0.15).abs() < 1e-9);
    let [Unfilled { area, reason: UnfilledReason::Narrow, .. }] = filled.paths.unfilled[..] else { panic!() };
    assert!((area - 9.0).abs() < 1e-9);
}

#[test]
fn a_bead_that_takes_too_many_points_is_refused_before_any_work() {
    let walls = walls(30.0, 30.0);
    let calls = AtomicUsize::new(0);
    let count = |_: Progress| {
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let options = PathOptions { bead: 0.001, ..PathOptions::default() };
    let error = fill_layers(&surfaces(&walls), &options, &count).unwrap_err();
    let FillLayersError::TooManyPoints { area_mm2, points, most, min_bead_mm, .. } = error else { panic!("{error}") };
    assert_eq!((calls.load(Ordering::Relaxed), most), (0, 1 << 25));
    assert!((area_mm2 - 2700.0).abs() < 1e-9 && points > most as f64);
    assert!((estimate_fill(&surfaces(&walls), min_bead_mm).points / most as f64 - 1.0).abs() < 1e-9);
    // The limit is an option.
    let options = PathOptions { bead: 2.0, max_points: 100, ..PathOptions::default() };
    assert!(matches!(fill_layers(&surfaces(&walls), &options, &go_on), Err(FillLayersError::TooManyPoints { .. })));
    assert!(fill_layers(&surfaces(&walls), &PathOptions { max_points: 2000, ..options }, &go_on).is_ok());
}

#[test]
fn the_estimate_is_about_what_comes() {
    let walls = walls(30.0, 20.0);
    for bead in [0.5, 1.0, 2.0] {
        let estimate = estimate_fill(&surfaces(&walls), bead);
        let filled = fill_layers(&surfaces(&walls), &PathOptions { bead, ..PathOptions::default() }, &go_on).unwrap();
        assert!((filled.totals().path_mm / estimate.path_mm - 1.0).abs() < 0.15);
        let points: usize = filled.layers.iter().flatten().flat_map(|l| &l.paths.paths).map(|p| p.points.len()).sum();
        assert!((points as f64) < estimate.points, "{points} points, {} foretold", estimate.points);
    }
}

#[test]
fn bad_beads_and_no_surfaces_are_as_before() {
    for bead in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = PathOptions { bead, ..PathOptions::default() };
        let walls = walls(8.0, 8.0);
        let error = fill_layers(&surfaces(&walls), &options, &go_on).unwrap_err();
        assert!(matches!(error, FillLayersError::Layer { layer: 0, .. }), "{error}");
        assert!(fill_layers(&[], &options, &go_on).unwrap().layers.is_empty());
    }
    assert_eq!(estimate_fill(&[], 1.0), FillEstimate::default());
}
