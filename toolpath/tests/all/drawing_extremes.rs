//! Numbers of any size at the doors of drawings: a result or an error, never a panic or an endless run.

use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::Point2;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Numbers of any size, most of them such as designs have.
fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0f64,
        1 => proptest::num::f64::ANY,
        1 => proptest::sample::select(vec![0.0, -0.0, 1e-300, 1e-12, 1e6, -1e6, 1.1e6, 1e154, 1e308, f64::NAN, f64::INFINITY]),
    ]
}

fn contour() -> impl Strategy<Value = Contour> {
    let points = proptest::collection::vec((extreme(), extreme()), 0..6);
    let fill = proptest::option::of((0..3u32, any::<bool>()));
    (points, any::<bool>(), fill).prop_map(|(points, closed, fill)| Contour {
        points: points.into_iter().map(|(x, y)| Point2::new(x, y)).collect(),
        closed,
        entity: 0,
        fill: fill
            .map(|(path, even)| PathFill { path, rule: if even { FillRule::EvenOdd } else { FillRule::NonZero } }),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]
    #[test]
    fn contours_of_any_numbers_are_joined_or_refused(
        mut contours in proptest::collection::vec(contour(), 0..5),
        (tolerance, least, length) in (extreme(), extreme(), extreme()),
        diameter in proptest::option::of(extreme()),
        centre in proptest::option::of((extreme(), extreme())),
    ) {
        let _ = gaps(&contours, tolerance);
        if let Ok(joined) = join(&contours, tolerance) {
            // Points that joining takes are points that all else takes.
            prop_assert!(union_area(&joined.contours).is_ok() && area_sum(&joined.contours).is_ok());
            prop_assert!(gaps(&joined.contours, 0.5).is_ok());
        }
        let _ = (union_area(&contours), area_sum(&contours));
        let overlaps = remove_overlaps(&contours, least, length);
        if let Ok(overlaps) = &overlaps {
            prop_assert!(overlaps.regions.iter().flat_map(Region::rings).flatten().all(|p| p.x.is_finite() && p.y.is_finite()));
        }
        order(&mut contours);
        let centre = centre.map_or(Centre::Box, |(x, y)| Centre::At(Point2::new(x, y)));
        if place(&mut contours, centre, diameter).is_ok() {
            let _ = remove_overlaps(&contours, 0.0, 0.0);
        }
    }

    #[test]
    fn curves_of_any_numbers_are_flattened_or_refused(
        [x, y, a, b, c, d, from, sweep] in proptest::array::uniform8(extreme()),
        unit in extreme(),
        tolerance in prop_oneof![Just(0.01), Just(1e3), extreme()],
    ) {
        let mut drawing = Drawing::default();
        let (u, v) = ([a, b].into(), [c, d].into());
        drawing.add("A", [Curve::Arc { centre: Point2::new(x, y), u, v, from, sweep }]);
        drawing.add("B", [Curve::bulge(Point2::new(x, y), Point2::new(a, b), c), Curve::circle(Point2::new(x, y), d, 0.0, TAU)]);
        drawing.add("C", [Curve::bezier(vec![Point2::new(x, y), Point2::new(a, b), Point2::new(c, d)])]);
        drawing.set_unit(unit);
        // Coarse where it is drawn at all: ten million points are allowed, and take their time.
        let tolerance = if tolerance < 1e-3 { -1.0 } else { tolerance };
        for layer in ["A", "B", "C"] {
            if let Ok(contours) = drawing.contours(|name| name == layer, Flatten::Tolerance(tolerance)) {
                let points = contours.iter().flat_map(|contour| &contour.points);
                prop_assert!(points.clone().all(|p| p.x.abs() <= MAX_COORDINATE_MM && p.y.abs() <= MAX_COORDINATE_MM));
            }
        }
    }

    /// Values of entities in a file, of any kind.
    #[test]
    fn entities_of_any_numbers_are_drawn_or_named(values in proptest::collection::vec(extreme(), 12)) {
        let codes = [10, 20, 11, 21, 40, 41, 42, 50, 51, 210, 220, 230];
        let pairs: String = codes.iter().zip(&values).map(|(code, value)| format!("{code}\n{value:?}\n")).collect();
        let kinds = ["LINE", "CIRCLE", "ARC", "ELLIPSE", "LWPOLYLINE", "SPLINE"];
        let entities: String = kinds.iter().map(|kind| format!("0\n{kind}\n8\nA\n{pairs}")).collect();
        let insert = format!("0\nINSERT\n2\nB\n{pairs}");
        let file = format!(
            "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n{pairs}{entities}0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}{insert}0\nENDSEC\n0\nEOF\n"
        );
        let drawing = read_dxf(file.as_bytes()).unwrap();
        // Those of the block if it is inserted.
        let all = drawing.entities.len() + drawing.skipped_count();
        prop_assert!(all == 2 * kinds.len() || all == kinds.len() + 1, "{}", all);
        // What is drawn is within the limits; a circle of a kilometre at 1 mm has some thousand points.
        let flat = drawing.contours(|_| true, Flatten::Tolerance(1.0));
        prop_assert!(drawing.entities.is_empty() || flat.is_ok(), "{:?}", flat);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    /// Regions and options of any numbers, all the way to the surface.
    #[test]
    fn regions_of_any_numbers_are_filled_or_refused(
        rings in proptest::collection::vec(proptest::collection::vec((extreme(), extreme()), 0..6), 1..3),
        bead in prop_oneof![0.3..4.0f64, extreme().prop_map(|x| if x.abs() < 0.3 { -x } else { x })],
        (angle, gap, min_width, tolerance) in (extreme(), prop_oneof![Just(0.0), extreme()], prop_oneof![Just(0.5), extreme()], prop_oneof![Just(0.01), extreme()]),
        (kind, on_line, step) in (0..4usize, any::<bool>(), prop_oneof![Just(1.0), extreme()]),
    ) {
        let fill_kind = [Fill::None, Fill::Lines, Fill::Concentric, Fill::Spiral][kind];
        let contour = if on_line { ContourAt::OnLine } else { ContourAt::Inside };
        let options = FillOptions { bead, contour, fill: fill_kind, angle, gap, min_width, tolerance, ..FillOptions::default() };
        let mut rings = rings.into_iter().map(|ring| ring.into_iter().map(|(x, y)| Point2::new(x, y)).collect::<Vec<_>>());
        let region = Region { outer: rings.next().unwrap(), holes: rings.collect(), contour: 0 };
        let open = [Contour { points: region.outer.clone(), closed: false, entity: 0, fill: None }];
        let Ok(mut filled) = fill(std::slice::from_ref(&region), &open, &options) else { return Ok(()) };
        thin_clusters(&mut filled.strokes, 2);
        start_strokes(&mut filled.strokes);
        let _ = coverage(&[region], &filled.strokes);
        let dome = Revolved::new(Profile::brooks(), 150.0).unwrap();
        for stroke in filled.strokes.iter().take(3) {
            let _ = project(&dome, Projection::Vertical, 0, &stroke.points, stroke.closed, step);
        }
        distortion(&dome, Projection::Meridian, &filled.strokes.first().map(|stroke| stroke.points.clone()).unwrap_or_default());
    }
}
