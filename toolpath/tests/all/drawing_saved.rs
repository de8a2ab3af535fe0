//! Drawings that leave as text and as DXF, and come back.

use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::io::ErrorKind;
use std::path::Path;

fn point() -> impl Strategy<Value = Point2<f64>> {
    (-150.0..150.0f64, -150.0..150.0f64).prop_map(|(x, y)| Point2::new(x, y))
}

fn vector() -> impl Strategy<Value = Vector2<f64>> {
    (1.0..60.0f64, 0.0..TAU).prop_map(|(r, a)| Vector2::new(r * a.cos(), r * a.sin()))
}

fn sweep() -> impl Strategy<Value = f64> {
    prop_oneof![Just(TAU), Just(-TAU), 0.1..6.2f64, -6.2..-0.1f64]
}

fn curve() -> impl Strategy<Value = Curve> {
    prop_oneof![
        (point(), point()).prop_map(|(from, to)| Curve::Line { from, to }),
        (point(), 0.5..80.0f64, -7.0..7.0f64, sweep())
            .prop_map(|(at, r, from, sweep)| Curve::circle(at, r, from, sweep)),
        (point(), vector(), vector(), -7.0..7.0f64, sweep())
            .prop_filter("an ellipse", |(_, u, v, ..)| u.perp(v).abs() > 0.05 * u.norm() * v.norm())
            .prop_map(|(centre, u, v, from, sweep)| Curve::Arc { centre, u, v, from, sweep }),
        (proptest::collection::vec((point(), 0.2..5.0f64), 4..9), any::<bool>(), 0.1..3.0f64).prop_map(
            |(all, rational, step)| {
                let n = all.len();
                let inner = (1..n - 3).map(|k| step * k as f64);
                let last = step * (n - 3) as f64;
                let knots = [0.0; 4].into_iter().chain(inner).chain([last; 4]).collect();
                let weights = if rational { all.iter().map(|(_, w)| *w).collect() } else { vec![] };
                Curve::Spline { degree: 3, knots, points: all.iter().map(|(p, _)| *p).collect(), weights }
            }
        ),
    ]
}

/// A chain of segments and arcs with bulges.
fn chain() -> impl Strategy<Value = Vec<Curve>> {
    proptest::collection::vec((point(), -3.0..3.0f64), 3..8).prop_map(|corners| {
        corners
            .windows(2)
            .map(|pair| Curve::bulge(pair[0].0, pair[1].0, if pair[0].1.abs() < 1.0 { 0.0 } else { pair[0].1 }))
            .collect()
    })
}

fn entity(layer: &str) -> impl Strategy<Value = Entity> + use<> {
    let curves = prop_oneof![curve().prop_map(|curve| vec![curve]), chain(), proptest::collection::vec(curve(), 0..3)];
    let layer = layer.to_owned();
    (curves, any::<bool>(), any::<u64>()).prop_map(move |(curves, closed, line)| Entity {
        kind: "SPLINE".to_owned(),
        layer: layer.clone(),
        line,
        curves,
        closed,
        fill: line.is_multiple_of(3).then(|| PathFill {
            path: line as u32,
            rule: if line.is_multiple_of(2) { FillRule::EvenOdd } else { FillRule::NonZero },
        }),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// What is saved is loaded, to the last bit, whatever the texts are.
    #[test]
    fn saved_drawings_are_loaded_as_they_were(
        mut entities in proptest::collection::vec(entity("A"), 0..6),
        texts in proptest::collection::vec(("(?s).{0,12}", "(?s).{0,12}"), 6),
        skipped in proptest::collection::vec(("(?s).{1,9}", 0..9usize), 0..3),
        notes in proptest::collection::vec("(?s).{0,9}", 0..3),
        unit_mm in proptest::option::of(1e-9..1e9f64),
    ) {
        for (entity, (kind, layer)) in entities.iter_mut().zip(texts) {
            (entity.kind, entity.layer) = (kind, layer);
        }
        let skipped = skipped.into_iter().map(|(what, count)| {
            let places = (0..count % 3).map(|k| format!("line {k}\n{what}")).collect();
            Skipped { what, count, places }
        });
        let drawing = Drawing { entities, skipped: skipped.collect(), notes, unit_mm };
        let mut file = Vec::new();
        save_drawing(&mut file, &drawing).unwrap();
        prop_assert_eq!(load_drawing(file.as_slice()).unwrap(), drawing);
        // Cut anywhere it is an error, but for the end of its last line.
        let cut = file.len().saturating_sub(2) / 2;
        prop_assert!(load_drawing(&file[..cut]).is_err());
    }

    /// What is written as DXF is read as the same lines, in the same place.
    #[test]
    fn drawings_in_dxf_are_read_as_they_were(entities in proptest::collection::vec(entity("A"), 1..4)) {
        let drawing = Drawing { entities, ..Drawing::default() };
        let mut file = Vec::new();
        write_dxf(&mut file, &drawing).unwrap();
        let read = read_dxf(file.as_slice()).unwrap();
        prop_assert!(read.skipped.is_empty() && read.unit_mm == Some(1.0));
        let points = |drawing: &Drawing| -> (Vec<Contour>, f64) {
            let contours = drawing.contours(|_| true, Flatten::Tolerance(1e-3)).unwrap_or_default();
            let length = contours.iter().map(Contour::length).sum();
            (contours, length)
        };
        // Several curves of an entity that do not meet are joined by its segments when flattened; they become several entities.
        let apart = |entity: &Entity| -> bool {
            entity.curves.windows(2).any(|pair| (pair[0].ends()[1] - pair[1].ends()[0]).norm() > 1e-9)
        };
        prop_assume!(!drawing.entities.iter().any(apart));
        let ((before, length), (after, read_length)) = (points(&drawing), points(&read));
        prop_assert!((length - read_length).abs() < 1e-3 * length.max(1.0), "{} {}", length, read_length);
        let distance = |at: &Point2<f64>, contours: &[Contour]| {
            let edges = contours.iter().flat_map(|c| c.points.iter().zip(c.points.iter().skip(1).chain(c.points.first())));
            edges.map(|(a, b)| {
                let (edge, to) = (b - a, at - a);
                let share = if edge.norm() > 0.0 { (to.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
                (to - edge * share).norm()
            }).fold(f64::INFINITY, f64::min)
        };
        for (one, other) in [(&before, &after), (&after, &before)] {
            for at in one.iter().flat_map(|contour| contour.points.iter().step_by(7)) {
                prop_assert!(distance(at, other) < 2.1e-3, "{:?} {}", at, distance(at, other));
            }
        }
    }
}

/// The kinds that files have, one by one: what is exact stays exact.
#[test]
fn each_curve_becomes_its_own_kind_of_entity() {
    let kinds = |curves: Vec<Curve>, closed: bool| -> Vec<String> {
        let mut drawing = Drawing::default();
        drawing.add("a/b", curves);
        drawing.entities[0].closed = closed;
        let mut file = Vec::new();
        write_dxf(&mut file, &drawing).unwrap();
        let read = read_dxf(file.as_slice()).unwrap();
        assert!(read.entities.iter().all(|entity| entity.layer == "a_b"));
        read.entities.into_iter().map(|entity| entity.kind).collect()
    };
    let p = |x: f64, y: f64| Point2::new(x, y);
    let line = |a: Point2<f64>, b: Point2<f64>| Curve::Line { from: a, to: b };
    let (o, e, n) = (p(0.0, 0.0), p(4.0, 0.0), p(0.0, 3.0));
    let ellipse =
        |u: [f64; 2], v: [f64; 2], sweep: f64| Curve::Arc { centre: o, u: u.into(), v: v.into(), from: 0.3, sweep };
    assert_eq!(kinds(vec![line(o, e)], false), ["LINE"]);
    assert_eq!(kinds(vec![Curve::circle(o, 2.0, 0.0, TAU)], false), ["CIRCLE"]);
    assert_eq!(kinds(vec![Curve::circle(o, 2.0, 0.0, -1.0)], false), ["ARC"]);
    assert_eq!(kinds(vec![ellipse([2.0, 0.0], [0.5, 1.0], 2.0)], false), ["ELLIPSE"]);
    assert_eq!(
        kinds(vec![ellipse([2.0, 1.0], [4.0, 2.0], 6.0)], false),
        ["LWPOLYLINE"],
        "flat: a segment there and back"
    );
    assert_eq!(kinds(vec![line(o, e), line(e, n), line(n, o)], false), ["LWPOLYLINE"]);
    assert_eq!(kinds(vec![line(o, e), Curve::bulge(e, n, 0.5)], true), ["LWPOLYLINE"]);
    let bezier = Curve::bezier(vec![e, p(5.0, 5.0), n]);
    assert_eq!(kinds(vec![line(o, e), bezier.clone()], true), ["LINE", "SPLINE", "LINE"]);
    assert_eq!(kinds(vec![bezier], false), ["SPLINE"]);
    assert!(kinds(vec![], true).is_empty());
    // Areas of closed polylines come back.
    let mut drawing = Drawing::default();
    drawing.add("", [line(o, e), Curve::bulge(e, n, 1.0), line(n, o)]);
    let mut file = Vec::new();
    write_dxf(&mut file, &drawing).unwrap();
    let contours = read_dxf(file.as_slice()).unwrap().contours(|layer| layer == "0", Flatten::Tolerance(1e-5)).unwrap();
    let wanted = 6.0 + 0.5 * std::f64::consts::PI * 2.5 * 2.5;
    assert!(contours[0].closed && (signed_area(&contours[0].points) - wanted).abs() < 1e-3);
}

#[test]
fn what_cannot_be_written_is_refused() {
    let mut drawing = Drawing::default();
    drawing.add("A", [Curve::circle(Point2::origin(), 1.0, 0.0, 1.0)]);
    drawing.add("A", [Curve::circle(Point2::new(f64::NAN, 0.0), 1.0, 0.0, 1.0)]);
    let mut file = Vec::new();
    let error = write_dxf(&mut file, &drawing).unwrap_err();
    assert!(
        error.kind() == ErrorKind::InvalidInput && error.to_string().contains("entity 2 (curve)") && file.is_empty()
    );
    let error = save_drawing(&mut file, &drawing).unwrap_err();
    assert!(error.kind() == ErrorKind::InvalidInput && error.to_string().contains("entity 2"));
    let drawing = Drawing { unit_mm: Some(f64::INFINITY), ..Drawing::default() };
    assert!(save_drawing(&mut file, &drawing).unwrap_err().to_string().contains("unit"));
}

#[test]
fn damaged_saves_are_refused_with_their_line() {
    assert!(matches!(load_drawing(&b""[..]), Err(LoadError::Head)));
    assert!(matches!(load_drawing(&b"curvlay-drawing 3\nend\n"[..]), Err(LoadError::Head)));
    assert!(matches!(load_drawing(&b"\xff\n"[..]), Err(LoadError::Head)));
    assert!(matches!(load_drawing(&b"curvlay-drawing 1\nentity 1 open\n"[..]), Err(LoadError::Truncated { line: 2 })));
    for (text, reported) in [
        ("line 1 2 3 4", "line 2: it belongs to an entity"),
        ("entity 1 open\nline 1 2 3", "line 3: it must have four numbers"),
        ("entity 1 open\nline 1 2 3 x", "line 3: a number is not one"),
        ("entity 1 open\narc 1 2 3 4 5 6 7 NaN", "line 3: a number is not one, or not finite"),
        ("entity 1 open\narc 1", "eight numbers"),
        ("entity 1 ajar", "`open` or `closed`"),
        ("entity -1 open", "`open` or `closed`"),
        ("entity 1 open\nspline x", "line 3: it must have a degree"),
        ("entity 1 open\nknots 1 2", "line 3: it belongs to a spline"),
        ("entity 1 open\nspline 3\npoints 1 2 3", "line 4: points have two numbers each"),
        ("entity 1 open\nkind a\\b", "line 3: a backslash"),
        ("kind A", "line 2: it belongs to an entity"),
        ("at line 3", "line 2: it belongs to what is skipped"),
        ("path 1 evenodd", "line 2: it belongs to an entity"),
        ("entity 1 open\npath 1 odd", "line 3: it must have a number, and `nonzero`"),
        ("entity 1 open\npath -1 evenodd", "line 3: it must have a number"),
        ("skipped TEXT", "it must have a number and a kind"),
        ("unit_mm", "it must have one number"),
        ("circle 1 2 3", "line 2: its first word is unknown"),
    ] {
        let error = load_drawing(format!("curvlay-drawing 1\n{text}\nend\n").as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reported), "{text}: {error}");
    }
    let windows = load_drawing(&b"curvlay-drawing 1\r\nentity 1 open\r\nlayer A B\r\nend\r\n"[..]).unwrap();
    assert_eq!(windows.entities[0].layer, "A B");
    // A spline that cannot be is an error when it is flattened.
    let odd = load_drawing(&b"curvlay-drawing 1\nentity 7 open\nspline 3\nend\n"[..]).unwrap();
    let error = odd.contours(|_| true, Flatten::default()).unwrap_err();
    assert!(matches!(error, FlattenError::Curve { line: 7, fault: CurveFault::Degree { .. }, .. }), "{error}");
}

/// The three designs, written as DXF and as text: the same contours and areas.
#[test]
#[ignore = "needs ../shared/dxf; .ci/run runs it where that folder exists"]
fn the_designs_come_back() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/dxf");
    for name in ["rosette-leaves", "petals-mixed", "lattice-wreath"] {
        let drawing = read_dxf(std::fs::read(folder.join(format!("{name}.dxf"))).unwrap().as_slice()).unwrap();
        let mut file = Vec::new();
        write_dxf(&mut file, &drawing).unwrap();
        let read = read_dxf(file.as_slice()).unwrap();
        assert_eq!(read.layers(), drawing.layers());
        let closed = |drawing: &Drawing| {
            let joined = join(&drawing.contours(|_| true, Flatten::default()).unwrap(), 0.005).unwrap().contours;
            let areas: f64 = joined.iter().filter(|c| c.closed).map(|c| signed_area(&c.points).abs()).sum();
            (joined.iter().filter(|c| c.closed).count(), joined.len(), areas)
        };
        let ((a, b, before), (c, d, after)) = (closed(&drawing), closed(&read));
        assert!((a, b) == (c, d) && (before - after).abs() < 1e-6 * before, "{name} {before} {after}");
        let mut file = Vec::new();
        save_drawing(&mut file, &drawing).unwrap();
        assert_eq!(load_drawing(file.as_slice()).unwrap(), drawing);
    }
}

/// By rules of the format: pairs of lines, a POLYLINE with the flag of three dimensions, its VERTEX records, SEQEND; handles once each.
#[test]
fn paths_in_space_are_polylines_of_three_dimensions() {
    let at = |x: f64, y: f64, z: f64| curvlay_toolpath::nalgebra::Point3::new(x, y, z);
    let ring = SpacePath {
        layer: "fill/1".to_owned(),
        points: vec![at(1.5, 0.0, 149.0), at(0.0, 2.0, 148.25), at(-3.0, 1e-9, 147.0)],
        closed: true,
    };
    let open =
        SpacePath { layer: "open".to_owned(), points: vec![at(0.0, 0.0, 1.0), at(0.1, 0.2, 0.3)], closed: false };
    let mut file = Vec::new();
    write_paths_dxf(&mut file, &[ring.clone(), open.clone()]).unwrap();
    let text = String::from_utf8(file.clone()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let pairs: Vec<(i32, &str)> = lines.chunks(2).map(|pair| (pair[0].parse().unwrap(), pair[1])).collect();
    let kinds: Vec<&str> = pairs.iter().filter(|(code, _)| *code == 0).map(|(_, kind)| *kind).collect();
    let begin = kinds.iter().position(|kind| *kind == "POLYLINE").unwrap();
    let expected =
        ["POLYLINE", "VERTEX", "VERTEX", "VERTEX", "SEQEND", "POLYLINE", "VERTEX", "VERTEX", "SEQEND", "ENDSEC", "EOF"];
    assert_eq!(kinds[begin..], expected);
    let all = |code: i32| pairs.iter().filter(move |(at, _)| *at == code).map(|(_, text)| *text);
    let flags: Vec<&str> = all(70).skip_while(|flag| *flag != "9").collect();
    assert_eq!(flags, ["9", "32", "32", "32", "8", "32", "32"]);
    let heights: Vec<f64> = all(30).map(|z| z.parse().unwrap()).collect();
    assert_eq!(heights, [0.0, 149.0, 148.25, 147.0, 0.0, 1.0, 0.3]);
    let handles: std::collections::BTreeSet<&str> = all(5).collect();
    assert_eq!(handles.len(), all(5).count());
    // Seen from above; names of layers lose what the format does not take.
    let drawing = read_dxf(file.as_slice()).unwrap();
    let found: Vec<(&str, usize, bool)> =
        drawing.entities.iter().map(|entity| (entity.layer.as_str(), entity.curves.len(), entity.closed)).collect();
    assert_eq!((found[0].0, found[1].0, drawing.unit_mm), ("fill_1", "open", Some(1.0)));
    assert_eq!(drawing.entities[1].curves, [Curve::Line { from: Point2::new(0.0, 0.0), to: Point2::new(0.1, 0.2) }]);
    for bad in [
        SpacePath { points: vec![at(0.0, 0.0, 0.0)], ..open.clone() },
        SpacePath { points: vec![at(0.0, 0.0, 0.0), at(0.0, f64::NAN, 0.0)], ..open.clone() },
    ] {
        let mut file = Vec::new();
        let error = write_paths_dxf(&mut file, &[ring.clone(), bad]).unwrap_err();
        assert_eq!((error.kind(), file.len()), (ErrorKind::InvalidInput, 0));
        assert!(error.to_string().starts_with("path 1 cannot be written"));
    }
}
