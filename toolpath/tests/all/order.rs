//! Orders of curves: against all there are, closed forms, and what is refused.

use crate::common::{go_on, rng};
use curvlay_toolpath::Progress;
use curvlay_toolpath::mesh::SurfacePoint;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::order::{OrderError, TravelCurve, TravelOrder, Visit, order_curves};
use curvlay_toolpath::path::{BeadKind, PathPoint, SurfacePath};
use proptest::prelude::*;
use rand::RngExt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

type Curve = (Vec<Point3<f64>>, bool);

fn order<'a>(layers: &'a [Vec<Curve>]) -> Result<TravelOrder, OrderError> {
    let curve = |(points, closed): &'a Curve| TravelCurve { points, closed: *closed };
    order_curves(&layers.iter().map(|curves| curves.iter().map(curve).collect()).collect::<Vec<_>>(), &go_on)
}

/// Where a visit begins and ends.
fn ends((points, closed): &Curve, visit: &Visit) -> [Point3<f64>; 2] {
    let start = points[visit.start as usize];
    let end = if *closed { start } else { points[points.len() - 1 - visit.start as usize] };
    [start, end]
}

/// Length of the ways in between; checks that every curve is there once.
fn walked(layers: &[Vec<Curve>], order: &[Vec<Visit>]) -> f64 {
    assert_eq!(layers.len(), order.len());
    let mut at: Option<Point3<f64>> = None;
    let mut sum = 0.0;
    for (curves, visits) in layers.iter().zip(order) {
        let mut numbers: Vec<u32> = visits.iter().map(|visit| visit.curve).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..curves.len() as u32).collect::<Vec<_>>());
        for visit in visits {
            let curve = &curves[visit.curve as usize];
            if !curve.1 {
                let last = if visit.reversed { curve.0.len() as u32 - 1 } else { 0 };
                assert_eq!(visit.start, last);
            }
            let [start, end] = ends(curve, visit);
            sum += at.map_or(0.0, |at| (start - at).norm());
            at = Some(end);
        }
    }
    sum
}

/// The least there is: every order of every layer, every way, one after the other.
fn least(layers: &[Vec<Curve>], at: Option<Point3<f64>>) -> f64 {
    fn layer(layers: &[Vec<Curve>], left: &[usize], at: Option<Point3<f64>>) -> f64 {
        if left.is_empty() {
            return least(&layers[1..], at);
        }
        let mut best = f64::INFINITY;
        for (place, &number) in left.iter().enumerate() {
            let rest: Vec<usize> = left.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, &n)| n).collect();
            let (points, closed) = &layers[0][number];
            let starts = if *closed { (0..points.len()).collect() } else { vec![0, points.len() - 1] };
            for start in starts {
                let visit = Visit { curve: number as u32, start: start as u32, reversed: false };
                let [start, end] = ends(&layers[0][number], &visit);
                let way = at.map_or(0.0, |at| (start - at).norm());
                best = best.min(way + layer(layers, &rest, Some(end)));
            }
        }
        best
    }
    match layers.first() {
        None => 0.0,
        Some(curves) => layer(layers, &(0..curves.len()).collect::<Vec<_>>(), at),
    }
}

fn point() -> impl Strategy<Value = Point3<f64>> {
    prop::array::uniform3(-20.0_f64..20.0).prop_map(Point3::from)
}

fn curve() -> impl Strategy<Value = Curve> {
    (prop::collection::vec(point(), 1..5), prop::bool::weighted(0.3))
}

proptest! {
    #[test]
    fn few_open_curves_are_ordered_as_well_as_can_be(
        layers in prop::collection::vec(prop::collection::vec(prop::collection::vec(point(), 1..4), 0..4), 0..4)
    ) {
        let layers: Vec<Vec<Curve>> =
            layers.into_iter().map(|curves| curves.into_iter().map(|points| (points, false)).collect()).collect();
        let found = order(&layers).unwrap();
        prop_assert!((walked(&layers, &found.layers) - found.travel_mm).abs() < 1e-9);
        prop_assert!((found.travel_mm - least(&layers, None)).abs() < 1e-9);
    }

    #[test]
    fn no_order_is_worse_than_the_one_given(layers in prop::collection::vec(prop::collection::vec(curve(), 0..16), 0..4)) {
        let found = order(&layers).unwrap();
        prop_assert!((walked(&layers, &found.layers) - found.travel_mm).abs() < 1e-9);
        let one = |curves: &Vec<Curve>| {
            (0..curves.len() as u32).map(|curve| Visit { curve, start: 0, reversed: false }).collect()
        };
        let given = layers.iter().map(one).collect::<Vec<_>>();
        prop_assert!((walked(&layers, &given) - found.given_mm).abs() < 1e-9);
        prop_assert!(found.travel_mm <= found.given_mm);
        prop_assert_eq!(order(&layers).unwrap(), found);
    }

    #[test]
    fn closed_curves_start_where_it_is_short(curves in prop::collection::vec(curve(), 1..4)) {
        // Few points each, all of which are tried: the least there is.
        let layers = [curves];
        let found = order(&layers).unwrap();
        prop_assert!((found.travel_mm - least(&layers, None)).abs() < 1e-9);
    }
}

/// Short lines in a grid, shuffled: the shortest way is along rows, to and fro.
#[test]
fn many_curves_come_near_the_least() {
    let mut rng = rng(5);
    for side in [5, 12, 20] {
        let mut curves: Vec<Curve> = Vec::new();
        for k in 0..side * side {
            let (x, y) = (f64::from(k % side), f64::from(k / side));
            let line = [Point3::new(x, y, 0.0), Point3::new(x + 0.5, y, 0.0)];
            let place = rng.random_range(0..=curves.len());
            curves.insert(place, (line.to_vec(), false));
        }
        let found = order(&[curves]).unwrap();
        // Half a millimetre from line to line of a row, one to the next row.
        let least = 0.5 * f64::from(side * (side - 1)) + f64::from(side - 1);
        assert!(found.travel_mm >= least - 1e-9 && found.travel_mm < 1.25 * least, "{} {least}", found.travel_mm);
        assert!(found.given_mm > 4.0 * least);
    }
}

#[test]
fn a_layer_begins_where_the_one_before_ends() {
    // Each line ends where the next layer's ends: every other one is turned round, and no way is left.
    let line = |z: f64| (vec![Point3::new(0.0, 0.0, z), Point3::new(30.0, 0.0, z)], false);
    let layers: Vec<Vec<Curve>> = (0..6).map(|k| vec![line(f64::from(k))]).collect();
    let found = order(&layers).unwrap();
    assert!((found.travel_mm - 5.0).abs() < 1e-12);
    assert!((found.given_mm - 5.0 * 901.0_f64.sqrt()).abs() < 1e-9);
    // Layers without curves are passed over.
    let mut gaps = layers.clone();
    gaps.insert(2, Vec::new());
    gaps.push(Vec::new());
    assert!((order(&gaps).unwrap().travel_mm - 5.0).abs() < 1e-12);
    let none = TravelOrder { layers: vec![Vec::new()], travel_mm: 0.0, given_mm: 0.0 };
    assert_eq!(order(&[Vec::new()]), Ok(none));
}

#[test]
fn paths_follow_their_visits() {
    let at = |k: usize| PathPoint {
        at: SurfacePoint { triangle: 0, barycentric: [1.0, 0.0, 0.0], position: Point3::new(k as f64, 0.0, 0.0) },
        width: 0.8,
        kind: BeadKind::Wall,
    };
    let path = |closed: bool| SurfacePath { points: (0..4).map(at).collect(), closed, region: 3 };
    let order = |closed: bool, start: u32, reversed: bool| {
        let travelled = path(closed).travelled(&Visit { curve: 0, start, reversed });
        assert_eq!((travelled.closed, travelled.region), (closed, 3));
        travelled.points.iter().map(|point| point.at.position.x as u32).collect::<Vec<_>>()
    };
    assert_eq!(order(false, 0, false), [0, 1, 2, 3]);
    assert_eq!(order(false, 3, true), [3, 2, 1, 0]);
    assert_eq!(order(true, 2, false), [2, 3, 0, 1]);
    assert_eq!(order(true, 2, true), [2, 1, 0, 3]);
    assert_eq!(order(true, 3, true), [3, 2, 1, 0]);
}

#[test]
fn what_cannot_be_used_is_named() {
    let good = (vec![Point3::origin()], false);
    assert_eq!(
        order(&[vec![good.clone()], vec![good.clone(), (Vec::new(), true)]]),
        Err(OrderError::NoPoints { layer: 1, curve: 1 })
    );
    for bad in [f64::NAN, f64::INFINITY, 1e10] {
        let curve = (vec![Point3::origin(), Point3::new(0.0, bad, 0.0)], false);
        let error = OrderError::BadPoint { layer: 0, curve: 1, point: 1 };
        assert_eq!(order(&[vec![good.clone(), curve]]), Err(error));
    }
}

#[test]
fn the_search_can_be_cancelled() {
    // Few curves, and many: a layer of lines here and there.
    let mut rng = rng(3);
    let mut lines = |count: usize| -> Vec<Curve> {
        let mut at = || Point3::new(rng.random_range(0.0..50.0), rng.random_range(0.0..50.0), 0.0);
        (0..count).map(|_| (vec![at(), at()], false)).collect()
    };
    let layers = [lines(5), lines(60), lines(4)];
    let curves: Vec<Vec<TravelCurve>> = layers
        .iter()
        .map(|lines| lines.iter().map(|(points, closed)| TravelCurve { points, closed: *closed }).collect())
        .collect();
    let calls = AtomicUsize::new(0);
    let count = |p: Progress| {
        assert!(p.stage == "order" && p.total == 3 && p.done <= 3);
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    order_curves(&curves, &count).unwrap();
    let all = calls.into_inner();
    assert!(all > 6, "{all}");
    for asked in 0..all {
        let calls = AtomicUsize::new(0);
        let stop = |_| match calls.fetch_add(1, Ordering::Relaxed) == asked {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        assert_eq!(order_curves(&curves, &stop).unwrap_err(), OrderError::Cancelled, "{asked} of {all}");
    }
}
