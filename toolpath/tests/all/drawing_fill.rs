//! Joining, placing, overlaps, fill and coverage of drawings.

// Figures that are exact by construction are compared exactly.
#![allow(clippy::float_cmp)]

use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn piece(points: &[[f64; 2]], closed: bool) -> Contour {
    Contour { points: points.iter().map(|&p| Point2::from(p)).collect(), closed, entity: 0, fill: None }
}

fn square(x: f64, y: f64, side: f64) -> Contour {
    piece(&[[x, y], [x + side, y], [x + side, y + side], [x, y + side]], true)
}

fn disc(x: f64, y: f64, radius: f64) -> Contour {
    let points = (0..400).map(|k| TAU * f64::from(k) / 400.0).map(|t| [x + radius * t.cos(), y + radius * t.sin()]);
    piece(&points.collect::<Vec<_>>(), true)
}

fn region(outer: &Contour, holes: &[Contour]) -> Region {
    let clockwise = |hole: &Contour| hole.points.iter().rev().copied().collect();
    Region { outer: outer.points.clone(), holes: holes.iter().map(clockwise).collect(), contour: 0 }
}

/// A leaf, as Brooks' design has it: two arcs over a chord.
fn leaf(length: f64, half_width: f64) -> Contour {
    let side = |t: f64| (length * t, half_width * (PI * t).sin());
    let up = (0..100).map(|k| side(f64::from(k) / 100.0)).map(|(x, y)| [x, -y]);
    let down = (0..100).map(|k| side(1.0 - f64::from(k) / 100.0)).map(|(x, y)| [x, y]);
    piece(&up.chain(down).collect::<Vec<_>>(), true)
}

// Joining.

/// Joins by comparing all pairs of ends, by the words of the documentation.
fn slow_join(pieces: &[Contour], tolerance: f64) -> Vec<(usize, bool)> {
    let mut left: Vec<Option<Contour>> = pieces.iter().cloned().map(Some).collect();
    let mut out = Vec::new();
    for k in 0..left.len() {
        let Some(mut chain) = left[k].take() else { continue };
        for _ in 0..2 {
            while !chain.closed {
                let (begin, end) = (chain.points[0], *chain.points.last().unwrap());
                let turns = chain.points.len() > 3 || (chain.points.len() == 3 && chain.length() > 2.0 * tolerance);
                if turns && (begin - end).norm() <= tolerance {
                    chain.points.pop();
                    chain.closed = true;
                    continue;
                }
                let mut best: Option<(f64, usize, bool)> = None;
                for (number, other) in left.iter().enumerate() {
                    let Some(other) = other.as_ref().filter(|other| !other.closed) else { continue };
                    for (reversed, at) in [(false, other.points[0]), (true, *other.points.last().unwrap())] {
                        let distance = (at - end).norm();
                        if distance <= tolerance && best.is_none_or(|best| distance < best.0) {
                            best = Some((distance, number, reversed));
                        }
                    }
                }
                let Some((_, number, reversed)) = best else { break };
                let mut more = left[number].take().unwrap().points;
                if reversed {
                    more.reverse();
                }
                *chain.points.last_mut().unwrap() = curvlay_toolpath::nalgebra::center(&end, &more[0]);
                chain.points.extend(&more[1..]);
            }
            if !chain.closed {
                chain.points.reverse();
            }
        }
        out.push((chain.points.len(), chain.closed));
    }
    out
}

proptest! {
    /// Pieces between places of a small lattice, a little off them, in any direction.
    #[test]
    fn joining_agrees_with_all_pairs(
        ends in proptest::collection::vec(((0..4u8, 0..4u8), (0..4u8, 0..4u8), -2e-3..2e-3f64), 0..25),
    ) {
        let at = |(x, y): (u8, u8), off: f64| [f64::from(x) + off, f64::from(y) - 0.5 * off];
        let mut pieces: Vec<Contour> = Vec::new();
        for (number, (from, to, off)) in ends.into_iter().enumerate() {
            // A corner of its own keeps pieces from lying on each other.
            let corner = [f64::from(from.0) + 0.3, f64::from(to.1) + 0.01 * number as f64];
            pieces.push(piece(&[at(from, off), corner, at(to, -off)], false));
        }
        let joined = join(&pieces, 0.005).unwrap();
        let found: Vec<(usize, bool)> =
            joined.contours.iter().map(|contour| (contour.points.len(), contour.closed)).collect();
        prop_assert_eq!(found, slow_join(&pieces, 0.005));
    }
}

#[test]
fn gaps_close_up_to_the_tolerance() {
    for (gap, closes) in [(0.0, true), (0.003, true), (0.005, true), (0.006, false), (0.05, false)] {
        for turned in 0..4 {
            let mut sides =
                [piece(&[[0.0, 0.0], [9.0, 0.0]], false), piece(&[[9.0, gap], [5.0, 7.0], [0.0, 0.0]], false)];
            for (k, side) in sides.iter_mut().enumerate() {
                if turned >> k & 1 == 1 {
                    side.points.reverse();
                }
            }
            let joined = join(&sides, 0.005).unwrap();
            assert_eq!((joined.contours.len(), joined.contours[0].closed), (1, closes), "{gap} {turned}");
        }
    }
}

#[test]
fn duplicates_and_pieces_of_no_length_are_removed() {
    let mut turned = square(0.0, 0.0, 5.0);
    turned.points.rotate_left(3);
    turned.points.reverse();
    let line = piece(&[[20.0, 0.0], [30.0, 1.0]], false);
    let mut back = line.clone();
    back.points.reverse();
    let pieces =
        [square(0.0, 0.0, 5.0), turned, line, back, piece(&[[7.0, 7.0], [7.0, 7.001]], false), square(0.0, 0.0, 6.0)];
    let joined = join(&pieces, 0.005).unwrap();
    assert_eq!((joined.contours.len(), joined.duplicates, joined.zero_length), (3, 2, 1));
    assert_eq!(join(&[], 0.005).unwrap(), Joined::default());
    assert!(matches!(join(&[], -1.0), Err(JoinError::Tolerance { .. })));
    assert!(matches!(join(&[], f64::NAN), Err(JoinError::Tolerance { .. })));
    let nan = piece(&[[0.0, 0.0], [f64::NAN, 1.0]], false);
    assert_eq!(join(&[square(0.0, 0.0, 1.0), nan], 0.1), Err(JoinError::Point { contour: 1, point: 1 }));
}

// Placing.

#[test]
fn designs_are_placed_about_any_centre() {
    let mut contours = [square(100.0, 50.0, 10.0)];
    assert_eq!(place(&mut contours, Centre::At(Point2::new(100.0, 50.0)), Some(20.0 * 2f64.sqrt())).unwrap(), 1.0);
    assert_eq!(contours[0].points[2], Point2::new(10.0, 10.0));
    assert_eq!(place(&mut contours, Centre::Box, None).unwrap(), 1.0);
    assert_eq!(contours[0].points[2], Point2::new(5.0, 5.0));
    let mut dot = [piece(&[[3.0, 3.0], [3.0, 3.0]], false)];
    assert_eq!(place(&mut dot, Centre::Box, Some(1.0)), Err(ArrangeError::NoExtent));
    assert_eq!(place(&mut [], Centre::Box, None), Err(ArrangeError::Empty));
    assert!(matches!(place(&mut contours, Centre::Box, Some(0.0)), Err(ArrangeError::Option { .. })));
    assert!(matches!(
        place(&mut contours, Centre::At(Point2::new(f64::NAN, 0.0)), Some(1.0)),
        Err(ArrangeError::Option { .. })
    ));
}

#[test]
fn the_largest_comes_first_and_open_ones_last() {
    let open = piece(&[[0.0, -1.0], [1.0, -3.0]], false);
    let mut contours = vec![open, square(-5.0, -5.0, 1.0), square(5.0, 5.0, 1.0), square(-9.0, 3.0, 4.0)];
    order(&mut contours);
    let kinds: Vec<(usize, bool)> =
        contours.iter().map(|contour| (contour.points[0].x as i64 as usize, contour.closed)).collect();
    assert_eq!(kinds.len(), 4);
    assert_eq!(contours[0].points[0].x, -9.0);
    assert_eq!((contours[1].points[0].x, contours[2].points[0].x, contours[3].closed), (5.0, -5.0, false));
}

// Overlaps.

#[test]
fn later_contours_give_way_and_open_ones_are_clipped() {
    let contours = [
        square(0.0, 0.0, 10.0),
        square(8.0, 2.0, 4.0),
        square(2.0, 2.0, 2.0),
        piece(&[[-5.0, 5.0], [20.0, 5.0]], false),
        disc(50.0, 0.0, 3.0),
    ];
    let overlaps = remove_overlaps(&contours, 0.0, 0.0).unwrap();
    let areas: Vec<(usize, f64)> = overlaps.regions.iter().map(|region| (region.contour, region.area())).collect();
    assert_eq!(areas.iter().map(|(contour, _)| *contour).collect::<Vec<_>>(), [0, 1, 4]);
    assert!((areas[0].1 - 100.0).abs() < 1e-6 && (areas[1].1 - 8.0).abs() < 1e-6);
    let lengths: Vec<f64> = overlaps.open.iter().map(Contour::length).collect();
    assert_eq!(lengths.len(), 2);
    assert!((lengths.iter().sum::<f64>() - 13.0).abs() < 1e-6, "{lengths:?}");
    let few = remove_overlaps(&contours, 10.0, 6.0).unwrap();
    assert_eq!((few.regions.len(), few.open.len(), few.dropped), (2, 1, 2));
    assert!((few.dropped_mm2 - 8.0).abs() < 1e-6);
}

#[test]
fn what_goes_around_another_has_a_hole() {
    let overlaps = remove_overlaps(&[disc(0.0, 0.0, 5.0), disc(0.0, 0.0, 9.0)], 0.0, 0.0).unwrap();
    assert_eq!(overlaps.regions[1].holes.len(), 1);
    let inner = signed_area(&disc(0.0, 0.0, 5.0).points);
    assert!((overlaps.regions[1].area() - signed_area(&disc(0.0, 0.0, 9.0).points) + inner).abs() < 1e-5);
}

proptest! {
    /// Each place is in as many regions as it should be: one if any contour contains it. The twin counts crossings of a ray.
    #[test]
    fn regions_cover_each_place_once(
        places in proptest::collection::vec((-9.0..9.0f64, -9.0..9.0f64, 1.0..6.0f64, 0.0..6.0f64), 1..9),
        asked in proptest::collection::vec((-15.0..15.0f64, -15.0..15.0f64), 60),
    ) {
        let contours: Vec<Contour> = places.iter().map(|&(x, y, size, turn)| {
            let corner = |k: i32| turn + TAU * f64::from(k) / 5.0;
            piece(&(0..5).map(|k| [x + size * corner(2 * k).cos(), y + size * corner(2 * k).sin()]).collect::<Vec<_>>(), true)
        }).collect();
        // Pentagrams wind twice around their middle: not zero.
        let winds = |points: &[Point2<f64>], at: Point2<f64>| {
            let ends = points.iter().zip(points.iter().cycle().skip(1));
            ends.map(|(a, b)| {
                let left = (b - a).perp(&(at - a)) > 0.0;
                if a.y <= at.y && at.y < b.y && left { 1 } else if b.y <= at.y && at.y < a.y && !left { -1 } else { 0 }
            }).sum::<i32>()
        };
        let overlaps = remove_overlaps(&contours, 0.0, 0.0).unwrap();
        for (x, y) in asked {
            let at = Point2::new(x, y);
            let first = contours.iter().position(|contour| winds(&contour.points, at) != 0);
            let holding: Vec<usize> = overlaps.regions.iter()
                .filter(|region| region.rings().map(|ring| winds(ring, at)).sum::<i32>() != 0)
                .map(|region| region.contour).collect();
            prop_assert_eq!(holding, first.into_iter().collect::<Vec<_>>());
        }
        let sum: f64 = overlaps.regions.iter().map(Region::area).sum();
        prop_assert!((sum - union_area(&contours).unwrap()).abs() < 1e-6);
    }
}

// Fill.

fn options(fill: Fill, bead: f64) -> FillOptions {
    FillOptions { fill, bead, ..FillOptions::default() }
}

/// Lines end on the shape moved inwards; their number and length follow from its size.
#[test]
fn scan_lines_of_a_rectangle_are_as_computed() {
    let rectangle = region(&piece(&[[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]], true), &[]);
    for (angle, count, length) in [(0.0, 18, 27.0), (PI / 2.0, 28, 17.0)] {
        let scan = FillOptions { angle, zigzag: false, ..options(Fill::Lines, 1.0) };
        let filled = fill(std::slice::from_ref(&rectangle), &[], &scan).unwrap();
        let lines: Vec<&Stroke> = filled.strokes.iter().filter(|stroke| stroke.kind == StrokeKind::Fill).collect();
        assert_eq!((lines.len(), filled.stops()), (count, count + 1));
        for line in &lines {
            assert!((line.length() - length).abs() < 1e-6, "{}", line.length());
            assert!((line.width - 1.0).abs() < 1e-9);
        }
        // Joined, they are one.
        let zigzag = fill(std::slice::from_ref(&rectangle), &[], &FillOptions { zigzag: true, ..scan }).unwrap();
        assert_eq!(zigzag.stops(), 2);
        let covered = coverage(std::slice::from_ref(&rectangle), &zigzag.strokes).unwrap();
        assert!(covered.covered > 0.97 && covered.overlap < 0.04 && covered.outside < 0.01, "{covered:?}");
    }
}

/// Corners, flat edges and a point that only touches the line: Fig. 4-11 d of the thesis.
#[test]
fn tangent_scan_lines_stay_inside() {
    // Two teeth whose tips and the notch between them lie on scan lines.
    let comb = piece(&[[0.0, 0.0], [12.0, 0.0], [12.0, 8.0], [9.0, 12.0], [6.0, 8.0], [3.0, 12.0], [0.0, 8.0]], true);
    let region = region(&comb, &[square(2.0, 2.0, 2.0)]);
    for angle in [0.0, 0.1, PI / 2.0, -1.0, PI] {
        let scan = FillOptions { angle, ..options(Fill::Lines, 0.5) };
        let filled = fill(std::slice::from_ref(&region), &[], &scan).unwrap();
        let covered = coverage(std::slice::from_ref(&region), &filled.strokes).unwrap();
        assert!(covered.outside < 2e-3 && covered.covered > 0.95, "{angle}: {covered:?}");
    }
}

#[test]
fn a_spiral_is_one_closed_curve() {
    for (shape, holes) in [
        (disc(0.0, 0.0, 20.0), vec![]),
        (disc(0.0, 0.0, 20.0), vec![disc(3.0, 0.0, 6.0)]),
        (square(0.0, 0.0, 40.0), vec![square(5.0, 5.0, 8.0), square(25.0, 20.0, 9.0)]),
        (leaf(80.0, 15.0), vec![]),
        // A waist that splits the loops in two.
        (piece(&[[0.0, 0.0], [20.0, 7.0], [40.0, 0.0], [40.0, 20.0], [20.0, 13.0], [0.0, 20.0]], true), vec![]),
    ] {
        let region = region(&shape, &holes);
        let spiral = fill(std::slice::from_ref(&region), &[], &options(Fill::Spiral, 1.5)).unwrap();
        assert_eq!(spiral.stops(), 1, "{:?}", shape.points[1]);
        assert!(spiral.strokes[0].closed);
        let loops = fill(std::slice::from_ref(&region), &[], &options(Fill::Concentric, 1.5)).unwrap();
        assert!(loops.stops() > 4);
        // Bridges are as long as what they replace.
        let length: f64 = loops.strokes.iter().map(Stroke::length).sum();
        let off = (spiral.strokes[0].length() - length).abs() / length;
        assert!(off < 0.02, "{off}");
        let [ours, theirs] =
            [&spiral, &loops].map(|filled| coverage(std::slice::from_ref(&region), &filled.strokes).unwrap());
        assert!(ours.covered > theirs.covered - 0.01 && ours.overlap < theirs.overlap + 0.02, "{ours:?} {theirs:?}");
        assert!(ours.outside < 2e-3, "{ours:?}");
    }
}

/// Beads share the width of a ribbon: it is covered without gaps or overlaps.
#[test]
fn beads_fit_a_ribbon() {
    let ribbon = region(&piece(&[[0.0, 0.0], [200.0, 0.0], [200.0, 4.2], [0.0, 4.2]], true), &[]);
    for (bead, width) in [(3.2, 2.1), (1.5, 2.1), (1.2, 1.05), (0.7, 0.7)] {
        let filled = fill(std::slice::from_ref(&ribbon), &[], &options(Fill::Spiral, bead)).unwrap();
        assert!((filled.strokes[0].width - width).abs() < 0.02, "{bead}: {}", filled.strokes[0].width);
        let covered = coverage(std::slice::from_ref(&ribbon), &filled.strokes).unwrap();
        assert!(covered.covered > 0.97 && covered.overlap < 0.04 && covered.outside < 0.01, "{bead}: {covered:?}");
    }
    let filled = fill(std::slice::from_ref(&ribbon), &[], &options(Fill::Spiral, 5.0)).unwrap();
    assert_eq!((filled.stops(), filled.too_narrow), (0, 1));
    assert!((filled.too_narrow_mm2 - 840.0).abs() < 1e-6);
}

#[test]
fn the_thesis_prints_too_wide() {
    let ribbon = region(&piece(&[[0.0, 0.0], [200.0, 0.0], [200.0, 4.2], [0.0, 4.2]], true), &[]);
    let scan = FillOptions { contour: ContourAt::OnLine, ..options(Fill::None, 6.4) };
    let ribbon = [ribbon];
    let on_line = coverage(&ribbon, &fill(&ribbon, &[], &scan).unwrap().strokes).unwrap();
    assert!(on_line.covered > 0.99 && on_line.outside > 1.45, "{on_line:?}");
}

#[test]
fn options_out_of_range_are_refused() {
    let good = FillOptions::default();
    for (what, options) in [
        ("bead", FillOptions { bead: 0.0, ..good }),
        ("bead", FillOptions { bead: f64::NAN, ..good }),
        ("angle", FillOptions { angle: f64::INFINITY, ..good }),
        ("gap", FillOptions { gap: -1.0, ..good }),
        ("min_width", FillOptions { min_width: 0.0, ..good }),
        ("tolerance", FillOptions { tolerance: 0.0, ..good }),
    ] {
        let Err(FillError::Option { what: named, .. }) = fill(&[], &[], &options) else { panic!("{what}") };
        assert_eq!(named, what);
    }
    let mut far = region(&square(0.0, 0.0, 5.0), &[]);
    assert!(matches!(
        fill(&[far.clone()], &[], &FillOptions { bead: 2e-4, tolerance: 1e-4, ..good }),
        Err(FillError::TooMany { .. })
    ));
    far.outer[0].x = f64::NAN;
    assert_eq!(fill(&[far], &[], &good), Err(FillError::Point { region: 0 }));
    assert_eq!(fill(&[], &[], &good).unwrap(), Filled::default());
}

// Starts and coverage.

#[test]
fn strokes_begin_on_what_is_printed_else_near_the_pole() {
    let stroke = |contour: &Contour| Stroke {
        points: contour.points.clone(),
        closed: contour.closed,
        width: 1.0,
        kind: StrokeKind::Outline,
        source: 0,
    };
    let mut strokes = [
        stroke(&square(10.0, 10.0, 5.0)),
        stroke(&square(15.5, 5.0, 5.0)),
        stroke(&piece(&[[90.0, 0.0], [20.0, 2.0]], false)),
        stroke(&piece(&[[90.0, 90.0], [15.2, 15.2]], false)),
    ];
    assert_eq!(start_strokes(&mut strokes), 2);
    let first = |k: usize| strokes[k].points[0];
    assert_eq!(first(0), Point2::new(10.0, 10.0));
    assert_eq!(first(1), Point2::new(15.5, 10.0));
    assert_eq!(first(2), Point2::new(20.0, 2.0));
    assert_eq!(first(3), Point2::new(15.2, 15.2));
    assert_eq!(start_strokes(&mut []), 0);
}

proptest! {
    /// Against all pairs of cells and segments.
    #[test]
    fn coverage_agrees_with_all_pairs(
        points in proptest::collection::vec((0.0..10.0f64, 0.0..10.0f64), 2..6), closed in any::<bool>(), width in 0.4..2.0f64,
    ) {
        let line: Vec<Point2<f64>> = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        let closed = closed && line.len() > 2;
        let stroke = Stroke { points: line.clone(), closed, width, kind: StrokeKind::Fill, source: 0 };
        let region = region(&square(1.0, 1.0, 7.0), &[square(3.0, 3.0, 2.0)]);
        let found = coverage(&[region], &[stroke]).unwrap();
        let mut ends: Vec<(Point2<f64>, Point2<f64>)> = line.windows(2).map(|pair| (pair[0], pair[1])).collect();
        if closed {
            ends.push((line[line.len() - 1], line[0]));
        }
        let n = 300;
        let [mut all, mut covered] = [0, 0];
        for k in 0..n * n {
            let at = Point2::new(1.0, 1.0) + Vector2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5) * (7.0 / f64::from(n));
            if (3.0..5.0).contains(&at.x) && (3.0..5.0).contains(&at.y) {
                continue;
            }
            all += 1;
            covered += i32::from(ends.iter().any(|(a, b)| {
                let (edge, to) = (b - a, at - a);
                let share = if edge.norm() > 0.0 { (to.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
                (to - edge * share).norm() <= 0.5 * width
            }));
        }
        prop_assert!((found.covered - f64::from(covered) / f64::from(all)).abs() < 0.02);
    }
}

#[test]
fn what_is_covered_twice_is_counted() {
    let line = |y: f64| Stroke {
        points: vec![Point2::new(-5.0, y), Point2::new(25.0, y)],
        closed: false,
        width: 2.0,
        kind: StrokeKind::Fill,
        source: 0,
    };
    let region = region(&piece(&[[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [0.0, 4.0]], true), &[]);
    let found = coverage(std::slice::from_ref(&region), &[line(1.0), line(2.5)]).unwrap();
    assert!((found.covered - 3.5 / 4.0).abs() < 0.03 && (found.overlap - 0.5 / 4.0).abs() < 0.03, "{found:?}");
    // A bend is one bead; coming back over oneself is two.
    let points = [[2.0, 2.0], [10.0, 2.0], [10.0, 3.5]].map(Point2::from);
    let bend = Stroke { points: points.to_vec(), ..line(0.0) };
    assert_eq!(coverage(std::slice::from_ref(&region), std::slice::from_ref(&bend)).unwrap().overlap, 0.0);
    let back = Stroke { points: points.into_iter().chain([Point2::new(2.0, 2.0)]).collect(), ..bend };
    assert!(coverage(std::slice::from_ref(&region), &[back]).unwrap().overlap > 0.05);
    let bad = Stroke { width: 0.0, ..line(0.0) };
    assert_eq!(coverage(&[region], &[bad]), Err(CoverageError::NotFinite));
    assert_eq!(coverage(&[], &[]).unwrap(), Coverage::default());
}

/// Where the stems of a flower meet, only the first ones go through.
#[test]
fn clusters_of_open_strokes_are_thinned() {
    let stem = |k: u32, width: f64| {
        let a = std::f64::consts::TAU * f64::from(k) / 12.0;
        let end = Point2::new(60.0 * a.cos(), 60.0 * a.sin());
        Stroke { points: vec![Point2::origin(), end], closed: false, width, kind: StrokeKind::Open, source: k as usize }
    };
    let stems: Vec<Stroke> = (0..12).map(|k| stem(k, 3.0)).collect();
    let beads = |strokes: &[Stroke], at: Point2<f64>| {
        let along = |stroke: &Stroke| {
            let samples =
                (0..=3000).map(|k| stroke.points[0] + (stroke.points[1] - stroke.points[0]) * (f64::from(k) / 3000.0));
            samples.map(|p| (p - at).norm()).fold(f64::INFINITY, f64::min)
        };
        strokes.iter().filter(|stroke| along(stroke) < 0.45 * stroke.width).count()
    };
    let mut thinned = stems.clone();
    let found = thin_clusters(&mut thinned, 2);
    assert_eq!((thinned.len(), found.strokes), (12, 10));
    assert_eq!((beads(&stems, Point2::origin()), beads(&thinned, Point2::origin())), (12, 2));
    let lengths = |strokes: &[Stroke]| strokes.iter().map(Stroke::length).sum::<f64>();
    assert!((lengths(&stems) - lengths(&thinned) - found.removed_mm).abs() < 1e-9);
    // What is left ends where the stem leaves the beads of two others, and no sooner: within a third of a width.
    for (k, stroke) in thinned.iter().enumerate().skip(2) {
        assert!((stroke.points[1] - stems[k].points[1]).norm() < 1e-12, "the far end stays");
        let at = stroke.points[0];
        let near = (0..12usize).filter(|&other| other != k && other < k).filter(|&other| {
            let axis = (stems[other].points[1] - Point2::origin()).normalize();
            let begin = (thinned[other].points[0] - Point2::origin()).norm();
            let along = at.coords.dot(&axis).clamp(begin, 60.0);
            (at.coords - axis * along).norm() <= 1.5 - 0.3
        });
        assert!(near.count() < 2, "{k}");
    }
    // Two lines may cross; a closed stroke and fill are left alone; a bead that is all within others goes.
    let mut crossing = vec![stem(0, 3.0), stem(3, 3.0)];
    assert_eq!(thin_clusters(&mut crossing, 2), Thinned::default());
    assert_eq!(crossing, [stem(0, 3.0), stem(3, 3.0)]);
    let fill = Stroke { kind: StrokeKind::Fill, ..stem(0, 3.0) };
    let mut same = vec![fill.clone(), fill.clone(), fill, stem(0, 3.0)];
    let found = thin_clusters(&mut same, 2);
    assert!(same.len() == 3 && (found.removed_mm - 60.0).abs() < 1e-9);
    let empty = Stroke { points: vec![], ..stem(0, 3.0) };
    let mut odd = vec![empty.clone(), stem(1, 3.0)];
    assert_eq!((thin_clusters(&mut odd, 0), odd.len()), (Thinned::default(), 2));
    assert_eq!(odd[0], empty);
}
