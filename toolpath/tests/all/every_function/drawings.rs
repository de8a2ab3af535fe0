//! Drawings: curves, files, filling, surfaces that they are laid on.

use super::numbers::{bad, count, each_spoilt, flat, mesh, number, point};
use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector2, Vector3};
use proptest::prelude::*;

fn curve() -> impl Strategy<Value = Curve> {
    let points = || prop::collection::vec(flat(), 0..5);
    prop_oneof![
        2 => (flat(), flat()).prop_map(|(from, to)| Curve::Line { from, to }),
        1 => (flat(), number(), number(), number()).prop_map(|(centre, radius, from, sweep)| Curve::circle(centre, radius, from, sweep)),
        1 => (flat(), flat(), number()).prop_map(|(from, to, bulge)| Curve::bulge(from, to, bulge)),
        1 => points().prop_map(Curve::bezier),
        1 => (flat(), [number(), number()], [number(), number()], number(), number())
            .prop_map(|(centre, u, v, from, sweep)| Curve::Arc { centre, u: Vector2::from(u), v: Vector2::from(v), from, sweep }),
        1 => (count(), prop::collection::vec(number(), 0..8), points(), prop::collection::vec(number(), 0..5))
            .prop_map(|(degree, knots, points, weights)| Curve::Spline { degree, knots, points, weights }),
    ]
}

fn contour() -> impl Strategy<Value = Contour> {
    (prop::collection::vec(flat(), 0..7), any::<bool>(), 0..3usize).prop_map(|(points, closed, entity)| Contour {
        points,
        closed,
        entity,
        fill: None,
    })
}

fn square(side: f64) -> Contour {
    let points = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(Point2::from).to_vec();
    Contour { points, closed: true, entity: 0, fill: None }
}

fn stroke() -> impl Strategy<Value = Stroke> {
    (prop::collection::vec(flat(), 0..5), any::<bool>(), number()).prop_map(|(points, closed, width)| Stroke {
        points,
        closed,
        width,
        kind: StrokeKind::Fill,
        source: 0,
    })
}

const FILL: [fn(&mut FillOptions, f64); 5] = [
    |options, value| options.bead = value,
    |options, value| options.angle = value,
    |options, value| options.gap = value,
    |options, value| options.min_width = value,
    |options, value| options.tolerance = value,
];

fn feed_contours(contours: &[Contour], value: f64, limit: f64) {
    for widest in [1.0, value] {
        let _ = (
            gaps(contours, widest),
            union_area(contours),
            area_sum(contours),
            remove_overlaps(contours, widest, limit),
        );
        let _ = join(contours, widest);
    }
    for centre in [Centre::Box, Centre::At(Point2::new(value, limit))] {
        centre_of(contours, centre);
        for diameter in [None, Some(10.0), Some(value)] {
            let mut placed = contours.to_vec();
            let _ = place(&mut placed, centre, diameter);
            order(&mut placed);
            placed.iter().for_each(|contour| assert!(contour.length().is_nan() || contour.length() >= 0.0));
        }
    }
}

fn feed_fill(regions: &[Region], open: &[Contour], value: f64, most: usize) {
    let sound = FillOptions { bead: 1.0, ..FillOptions::default() };
    let more = [Fill::None, Fill::Lines, Fill::Concentric, Fill::Spiral].map(|fill| FillOptions {
        fill,
        contour: ContourAt::OnLine,
        ..sound
    });
    for options in each_spoilt(&sound, &FILL, value).into_iter().chain(more) {
        let Ok(mut filled) = fill(regions, open, &options) else { continue };
        let _ = (
            filled.stops(),
            filled.strokes.iter().map(Stroke::length).sum::<f64>(),
            coverage(regions, &filled.strokes),
        );
        thin_clusters(&mut filled.strokes, most);
        start_strokes(&mut filled.strokes);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn curves_and_contours_take_anything(
        curves in prop::collection::vec(curve(), 0..4), contours in prop::collection::vec(contour(), 0..4), strokes in prop::collection::vec(stroke(), 0..4), value in bad(), limit in number(), most in count(), name in "[a-z\n ]{0,6}", holes in prop::collection::vec(prop::collection::vec(flat(), 0..5), 0..2),
    ) {
        let mut drawing = Drawing::default();
        for curve in &curves {
            let _ = curve.ends();
        }
        drawing.add(&name, curves);
        drawing.set_unit(limit);
        let _ = (drawing.layers(), drawing.skipped_count());
        for flatten in [Flatten::default(), Flatten::Tolerance(limit), Flatten::Step(value), Flatten::Tolerance(value), Flatten::Step(1.0)] {
            if let Ok(found) = drawing.contours(|_| true, flatten) && found.iter().map(|contour| contour.points.len()).sum::<usize>() < 300 {
                feed_contours(&found, value, limit);
            }
        }
        feed_contours(&contours, value, limit);
        feed_contours(&[square(6.0), square(3.0)], value, limit);
        let outer = contours.first().map(|contour| contour.points.clone()).unwrap_or_default();
        signed_area(&outer);
        let odd = Region { outer, holes, contour: most };
        prop_assert!(odd.rings().count() == odd.holes.len() + 1);
        odd.area();
        let sound = remove_overlaps(&[square(6.0)], 0.0, 0.0).unwrap().regions;
        feed_fill(std::slice::from_ref(&odd), &contours, value, most);
        feed_fill(&sound, &contours, value, most);
        let mut loose = strokes.clone();
        let _ = coverage(&[odd], &strokes);
        thin_clusters(&mut loose, most);
        start_strokes(&mut loose);
    }

    #[test]
    fn files_take_anything(curves in prop::collection::vec(curve(), 0..4), text in "[a-zA-Z0-9 .\n<>/=\"-]{0,90}", any in prop::collection::vec(any::<u8>(), 0..90), layer in "[a-z\n\u{e9}]{0,6}", cut in 0..600usize, value in bad(), points in prop::collection::vec(point(), 0..4), unit in number()) {
        let mut drawing = Drawing { unit_mm: Some(unit), ..Drawing::default() };
        drawing.add(&layer, curves);
        let mut texts = vec![text.into_bytes(), any, format!("<svg xmlns='http://www.w3.org/2000/svg'><path d='M 0 0 L {value} 3 Z'/></svg>").into_bytes()];
        for written in [written(|out| save_drawing(out, &drawing)), written(|out| write_dxf(out, &drawing))] {
            texts.push(written[..cut.min(written.len())].to_vec());
            texts.push(written);
        }
        for text in &texts {
            let _ = (load_drawing(&text[..]), read_dxf(&text[..]));
            #[cfg(feature = "svg")]
            for scale in [SvgScale::Css, SvgScale::Dpi(value), SvgScale::UnitMm(unit)] {
                let _ = read_svg(text, SvgOptions { scale });
            }
        }
        let path = SpacePath { layer, points, closed: true };
        let _ = write_paths_dxf(&mut std::io::sink(), &[path]);
    }

    #[test]
    fn surfaces_take_anything(solid in mesh(), line in prop::collection::vec(flat(), 0..5), coefficients in prop::collection::vec(number(), 0..4), value in bad(), reach in number(), from in point(), at in flat()) {
        let profiles = [Profile::brooks(), Profile::Polynomial(coefficients), Profile::Sphere { radius: reach, top: value }, Profile::Sphere { radius: 20.0, top: 20.0 }];
        // Rays go by the thousandth of the reach; points along strokes by the step.
        for (profile, radius) in profiles.into_iter().flat_map(|profile| [(profile.clone(), 10.0), (profile, reach)]) {
            let _ = (profile.height(reach), profile.slope(value));
            let Ok(surface) = Revolved::new(profile, radius) else { continue };
            prop_assert!(surface.max_radius() > 0.0 && surface.profile().height(0.0).is_none_or(|height| height.is_finite() || height.is_nan() || height.is_infinite()));
            feed_surface(&surface, &line, value, from, at);
        }
        let bowl = |x: f64, y: f64| (x.hypot(y) < 30.0).then(|| 0.01 * (x * x + y * y) + if value.is_nan() { value } else { 0.0 });
        for reach in [10.0, reach, value] {
            feed_surface(&HeightField::new(bowl, reach), &line, value, from, at);
        }
        if let Ok(surface) = MeshSurface::new(&solid.0, &solid.1) {
            feed_surface(&surface, &line, value, from, at);
        }
        let tent = [[0.0, 0.0, 5.0], [8.0, 0.0, 0.0], [-4.0, 7.0, 0.0], [-4.0, -7.0, 0.0]].map(Point3::from);
        let plain = UnrollOptions { reach: 20.0, ..UnrollOptions::default() };
        let spoilt = [plain, UnrollOptions { reach: value, ..plain }, UnrollOptions { tolerance: value, kind: UnrollKind::Rigid, ..plain }, UnrollOptions { max_rounds: 3, kind: UnrollKind::Rigid, ..plain }];
        for options in spoilt {
            for (vertices, triangles) in [(&solid.0[..], &solid.1[..]), (&tent, &[[0, 1, 2], [0, 2, 3], [0, 3, 1]])] {
                let Ok(surface) = UnrolledMesh::new(vertices, triangles, options) else { continue };
                let _ = (surface.distortion(), surface.rounds());
                feed_surface(&surface, &line, value, from, at);
            }
        }
    }
}

fn feed_surface(surface: &impl Surface, line: &[Point2<f64>], value: f64, from: Point3<f64>, at: Point2<f64>) {
    let kinds = [
        Projection::Vertical,
        Projection::FromPoint { height: value },
        Projection::FromPoint { height: 50.0 },
        Projection::Meridian,
        Projection::Unrolled,
    ];
    for (projection, step) in kinds.into_iter().flat_map(|projection| [(projection, 1.0), (projection, value)]) {
        let _ = (projection.of(surface, &at), distortion(surface, projection, line));
        if let Ok(points) = project(surface, projection, 0, line, true, step) {
            raised(&points, value);
        }
    }
    for direction in [Vector3::z(), Vector3::new(value, 0.0, 1.0), Vector3::zeros()] {
        let _ = surface.hit(&from, &direction);
    }
}

fn written(write: impl FnOnce(&mut Vec<u8>) -> std::io::Result<()>) -> Vec<u8> {
    let mut out = Vec::new();
    // Writers refuse curves that are none.
    let _ = write(&mut out);
    out
}
