//! Where things should stand: the search against all places of a fine grid, and what it refuses.

use curvlay_kinematics::nalgebra::{Point3, Vector3};
use curvlay_kinematics::{Assessment, FixtureRegion, PlaceError, Waypoint, best_fixture_place};
use proptest::prelude::*;
use std::ops::ControlFlow::{Break, Continue};

fn region(min: [f64; 3], max: [f64; 3], coarse_mm: f64, fine_mm: f64) -> FixtureRegion {
    FixtureRegion { min: min.into(), max: max.into(), coarse_mm, fine_mm }
}

fn waypoints(count: usize) -> Vec<Waypoint> {
    (0..count).map(|k| Waypoint { position: Point3::new(10.0 * k as f64, 0.0, 0.0), axis: Vector3::z_axis() }).collect()
}

type Worth = Box<dyn FnMut(usize, &Waypoint) -> Option<Assessment>>;

/// Waypoints are in reach within a ball about the base, with clearance from its middle.
fn ball(place: &Point3<f64>, radius: f64) -> Worth {
    let place = *place;
    Box::new(move |_, waypoint| {
        let far = (place + waypoint.position.coords).coords.norm();
        (far <= radius).then_some(Assessment { clearance: far - 100.0, quality: -(far - 400.0).abs() })
    })
}

/// What a place is worth by all of its waypoints, none dropped: unreachable, tight, smallest quality.
fn worth(place: &Point3<f64>, waypoints: &[Waypoint], radius: f64) -> (usize, usize, f64) {
    let mut assess = ball(place, radius);
    let all: Vec<Option<Assessment>> = waypoints.iter().enumerate().map(|(k, at)| assess(k, at)).collect();
    let tight = all.iter().flatten().filter(|found| found.clearance < 5.0).count();
    let quality = all.iter().flatten().map(|found| found.quality).fold(f64::INFINITY, f64::min);
    (all.iter().filter(|found| found.is_none()).count(), tight, quality)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// No place of the coarse grid is better, and no neighbour of the place by the finest step.
    #[test]
    fn nothing_near_by_or_on_the_grid_is_better(
        count in 1..6usize, radius in 200.0..700.0f64, x in -200.0..200.0f64, wide in 300.0..900.0f64, deep in 0..2usize
    ) {
        let region = region([x, -100.0, 0.0], [x + wide, -100.0 + 200.0 * deep as f64, 300.0], 90.0, 4.0);
        let waypoints = waypoints(count);
        let best = best_fixture_place(&region, &waypoints, 5.0, |place| Some(ball(place, radius)), &|_| Continue(())).unwrap();
        let found = worth(&best.place, &waypoints, radius);
        prop_assert_eq!((best.unreachable.len(), best.tight.len()), (found.0, found.1));
        let better = |place: &Point3<f64>| {
            let other = worth(place, &waypoints, radius);
            (other.0, other.1) < (found.0, found.1) || ((other.0, other.1) == (found.0, found.1) && other.2 > found.2 + 1e-9)
        };
        let parts = |k: usize| ((region.max[k] - region.min[k]) / 90.0).ceil() as usize;
        for z in 0..=parts(2) {
            for y in 0..=parts(1) {
                for x in 0..=parts(0) {
                    let share = |k: usize, at: usize| if parts(k) == 0 { 0.0 } else { (region.max[k] - region.min[k]) * at as f64 / parts(k) as f64 };
                    let place = region.min + Vector3::new(share(0, x), share(1, y), share(2, z));
                    prop_assert!(!better(&place), "{place} {found:?}");
                }
            }
        }
        prop_assert!((0..3).all(|k| (region.min[k]..=region.max[k]).contains(&best.place[k])));
    }
}

/// The last place of the grid was beyond the end of this region by rounding.
#[test]
fn the_end_of_the_grid_is_within_the_region() {
    let x = -20.01103411324592;
    let region = region([x, -100.0, 0.0], [x + 394.6625015168784, -100.0, 300.0], 90.0, 4.0);
    let radius = 627.4319972505259;
    let best =
        best_fixture_place(&region, &waypoints(1), 5.0, |place| Some(ball(place, radius)), &|_| Continue(())).unwrap();
    assert!((0..3).all(|k| (region.min[k]..=region.max[k]).contains(&best.place[k])), "{}", best.place);
}

#[test]
fn places_where_nothing_can_stand_are_passed_over() {
    let region = region([0.0; 3], [600.0, 0.0, 0.0], 100.0, 1.0);
    // Only beyond 250 mm may anything stand, and the nearer the better.
    let at = |place: &Point3<f64>| {
        let x = place.x;
        (x >= 250.0).then_some(move |_: usize, _: &Waypoint| Some(Assessment { clearance: 10.0, quality: -x }))
    };
    let best = best_fixture_place(&region, &waypoints(2), 5.0, at, &|_| Continue(())).unwrap();
    assert!((250.0..=251.0).contains(&best.place.x), "{}", best.place);
    assert!(!best.at_end[0] && best.places > 7 && best.assessments > 0);
    let nowhere = |_: &Point3<f64>| None::<Worth>;
    assert_eq!(best_fixture_place(&region, &waypoints(2), 5.0, nowhere, &|_| Continue(())), Err(PlaceError::NoPlace));
    // The end of the region is reported.
    let far = |place: &Point3<f64>| {
        let x = place.x;
        Some(move |_: usize, _: &Waypoint| Some(Assessment { clearance: 10.0, quality: x }))
    };
    let best = best_fixture_place(&region, &waypoints(2), 5.0, far, &|_| Continue(())).unwrap();
    assert_eq!((best.place.x, best.at_end), (600.0, [true, false, false]));
}

#[test]
fn bad_regions_are_refused() {
    let worth = |place: &Point3<f64>| Some(ball(place, 500.0));
    let refused =
        |region: &FixtureRegion| best_fixture_place(region, &waypoints(1), 5.0, worth, &|_| Continue(())).unwrap_err();
    assert!(matches!(refused(&region([0.0; 3], [100.0; 3], 0.0, 1.0)), PlaceError::Option { what: "coarse_mm", .. }));
    assert!(matches!(
        refused(&region([0.0; 3], [100.0; 3], 10.0, f64::NAN)),
        PlaceError::Option { what: "fine_mm", .. }
    ));
    assert!(matches!(refused(&region([0.0; 3], [-1.0; 3], 10.0, 1.0)), PlaceError::Option { what: "region", .. }));
    assert!(matches!(refused(&region([0.0; 3], [f64::NAN; 3], 10.0, 1.0)), PlaceError::Option { what: "region", .. }));
    assert!(matches!(refused(&region([0.0; 3], [1e5; 3], 10.0, 1.0)), PlaceError::Option { what: "coarse_mm", .. }));
    let fine = region([0.0; 3], [100.0; 3], 50.0, 10.0);
    let bad = [Waypoint { position: Point3::new(f64::NAN, 0.0, 0.0), axis: Vector3::z_axis() }];
    assert_eq!(
        best_fixture_place(&fine, &bad, 5.0, worth, &|_| Continue(())).unwrap_err(),
        PlaceError::Waypoint { index: 0 }
    );
    assert!(matches!(
        best_fixture_place(&fine, &waypoints(1), f64::NAN, worth, &|_| Continue(())),
        Err(PlaceError::Option { .. })
    ));
    assert_eq!(best_fixture_place(&fine, &waypoints(1), 5.0, worth, &|_| Break(())), Err(PlaceError::Cancelled));
    let nan = |_: &Point3<f64>| Some(|_: usize, _: &Waypoint| Some(Assessment { clearance: f64::NAN, quality: 0.0 }));
    assert!(matches!(
        best_fixture_place(&fine, &waypoints(1), 5.0, nan, &|_| Continue(())),
        Err(PlaceError::Assessment { .. })
    ));
}
