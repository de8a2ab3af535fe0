//! Directions that are known for places: which one is found, and what a search that starts from it frees.

use crate::common::nozzle::tip_1_mm;
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_toolpath::layer::{BuiltLayer, DirectionHints, HintError, LayerCurve, LayerStack};
use curvlay_toolpath::nalgebra::{Point3, Unit, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;
use std::ops::ControlFlow;

fn direction() -> impl Strategy<Value = UnitVector3<f64>> {
    (-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64).prop_map(|(x, y, z)| Unit::new_normalize(Vector3::new(x, y, z)))
}

/// On a coarse lattice, so that places coincide and are as near as each other.
fn place() -> impl Strategy<Value = Point3<f64>> {
    (-6..6i32, -6..6i32, -6..6i32).prop_map(|(x, y, z)| Point3::from([x, y, z].map(|c| 0.5 * f64::from(c))))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The nearest one within reach, of several as near the first.
    #[test]
    fn the_nearest_place_within_reach_is_found(
        known in prop::collection::vec((place(), direction()), 0..30),
        asked in prop::collection::vec(place(), 1..10),
        reach in prop::sample::select(vec![0.3, 0.5, 1.0, 1.3, 4.0]),
    ) {
        let hints = DirectionHints::new(&known, reach).unwrap();
        for p in asked {
            let mut best: Option<(f64, UnitVector3<f64>)> = None;
            for (at, direction) in &known {
                let distance = (at - p).norm();
                if distance <= reach && best.is_none_or(|best| distance < best.0) {
                    best = Some((distance, *direction));
                }
            }
            prop_assert_eq!(hints.at(p), best.map(|best| best.1));
        }
    }
}

#[test]
fn hints_that_cannot_be_are_refused() {
    let (z, origin) = (Vector3::z_axis(), Point3::origin());
    for reach_mm in [0.0, -1.0, 1e-7, 1e8, f64::INFINITY] {
        assert_eq!(DirectionHints::new(&[(origin, z)], reach_mm), Err(HintError::Reach { reach_mm }));
    }
    assert!(matches!(DirectionHints::new(&[], f64::NAN), Err(HintError::Reach { .. })));
    for at in [Point3::new(0.0, f64::NAN, 0.0), Point3::new(0.0, 0.0, 1e8)] {
        assert_eq!(DirectionHints::new(&[(origin, z), (at, z)], 1.0), Err(HintError::Place { place: 1 }));
    }
    let long = Unit::new_unchecked(Vector3::new(0.0, 0.0, 2.0));
    assert_eq!(DirectionHints::new(&[(origin, long)], 1.0), Err(HintError::Place { place: 0 }));
    assert_eq!(DirectionHints::default().at(origin), None);
}

/// A layer that faces the plate, as below a ball that is printed from its side: every free direction is more than a right angle away from
/// the one that is wanted.
#[test]
fn what_faces_the_plate_is_freed_from_what_is_known() {
    let vertices = [[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0]].map(|[x, y]| Point3::new(x, y, 5.0));
    let line = [Point3::new(1.0, 5.0, 5.0), Point3::new(9.0, 5.0, 5.0)];
    let curves = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &[], closed: false }];
    let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    let layers = [BuiltLayer { vertices: &vertices, triangles: &triangles, spacing: &spacing, curves: &curves }];
    let go = |_| ControlFlow::Continue(());
    let down = -Vector3::z_axis();
    let at = |x: f64| Waypoint {
        position: Point3::new(x, 5.0, 4.6),
        axis: down,
        width: 0.8,
        height: 0.8,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind: BeadKind::Solid,
    };
    let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: [1.0, 5.0, 9.0].map(at).to_vec() };
    let (nozzle, options) = (tip_1_mm(), GougingOptions::default());
    let known = Unit::new_normalize(Vector3::new(0.0, -1.0, 0.2));
    let stack = LayerStack::new(&layers).unwrap();
    let stuck = stack.resolve_gouging(vec![path.clone()], &nozzle, &options, &go).unwrap();
    assert!(stuck.left.len() + stuck.left_out.len() > 0);
    let hints = DirectionHints::new(&[(Point3::new(5.0, 5.0, 5.0), known)], 6.0).unwrap();
    let hinted = LayerStack::new(&layers).unwrap().with_hints(hints);
    let free = hinted.resolve_gouging(vec![path], &nozzle, &options, &go).unwrap();
    assert_eq!((free.left.len(), free.left_out.len()), (0, 0));
    assert!(free.paths[0].waypoints.iter().all(|waypoint| waypoint.axis.y < -0.5));
}
