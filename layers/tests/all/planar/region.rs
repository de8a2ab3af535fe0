//! Regions: closed forms of offsets, and booleans against points.

use curvlay_layers::nalgebra::Point2;
use curvlay_layers::planar::{Region, RegionError, SectionPolygon};
use proptest::prelude::*;
use std::f64::consts::PI;

pub fn polygon(points: &[[f64; 2]]) -> SectionPolygon {
    SectionPolygon { outer: points.iter().map(|&[x, y]| Point2::new(x, y)).collect(), holes: Vec::new() }
}

pub fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> SectionPolygon {
    polygon(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
}

#[test]
fn an_offset_rounds_corners_outwards_and_keeps_them_inwards() {
    let square = Region::new(&[rectangle([0.0, 0.0], [8.0, 8.0])]).unwrap();
    let grown = square.offset(2.0).unwrap();
    assert!((grown.area() - (64.0 + 64.0 + 4.0 * PI)).abs() < 0.03, "{}", grown.area());
    assert!((square.offset(-2.0).unwrap().area() - 16.0).abs() < 1e-9);
    assert!(square.offset(-4.5).unwrap().is_empty());
    let [low, high] = grown.bounds().unwrap();
    assert!((low - Point2::new(-2.0, -2.0)).amax() < 1e-9 && (high - Point2::new(10.0, 10.0)).amax() < 1e-9);
    // A hole shrinks as the region grows, and goes.
    let mut frame = rectangle([0.0, 0.0], [10.0, 10.0]);
    frame.holes.push(vec![[4.0, 4.0], [4.0, 6.0], [6.0, 6.0], [6.0, 4.0]].into_iter().map(Point2::from).collect());
    let frame = Region::new(&[frame]).unwrap();
    assert!((frame.area() - 96.0).abs() < 1e-9);
    let half = frame.offset(0.5).unwrap();
    assert!((half.area() - (100.0 + 20.0 + PI / 4.0 - 1.0)).abs() < 0.01, "{}", half.area());
    assert!(frame.offset(1.5).unwrap().polygons()[0].holes.is_empty());
    assert!(Region::default().offset(3.0).unwrap().is_empty() && Region::default().inner_point().is_none());
}

#[test]
fn a_point_inside_is_inside() {
    let ell =
        Region::new(&[polygon(&[[0.0, 0.0], [9.0, 0.0], [9.0, 1.0], [1.0, 1.0], [1.0, 9.0], [0.0, 9.0]])]).unwrap();
    let p = ell.inner_point().unwrap();
    assert!(ell.contains(&p) && !ell.contains(&Point2::new(5.0, 5.0)));
    let two = Region::new(&[rectangle([0.0, 0.0], [1.0, 1.0]), rectangle([3.0, 0.0], [4.0, 1.0])]).unwrap();
    assert_eq!((two.pieces().len(), two.clone().without_specks(1.5).is_empty()), (2, true));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn booleans_are_those_of_points(boxes in prop::collection::vec((0..9_i32, 0..9_i32, 1..5_i32, 1..5_i32), 2..7), split in 1..4_usize) {
        let make = |&(x, y, w, h): &(i32, i32, i32, i32)| rectangle([x, y].map(f64::from), [x + w, y + h].map(f64::from));
        let all: Vec<SectionPolygon> = boxes.iter().map(make).collect();
        let split = split.min(all.len() - 1);
        let (a, b) = (Region::new(&all[..split]).unwrap(), Region::new(&all[split..]).unwrap());
        let (union, both, less) = (a.union(&b), a.intersection(&b), a.difference(&b));
        let mut counts = [0; 3];
        for x in 0..14 {
            for y in 0..14 {
                let p = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let inside = |list: &[(i32, i32, i32, i32)]| list.iter().any(|&(bx, by, w, h)| x >= bx && x < bx + w && y >= by && y < by + h);
                let (in_a, in_b) = (inside(&boxes[..split]), inside(&boxes[split..]));
                prop_assert_eq!([union.contains(&p), both.contains(&p), less.contains(&p)], [in_a || in_b, in_a && in_b, in_a && !in_b]);
                for (count, is) in counts.iter_mut().zip([in_a || in_b, in_a && in_b, in_a && !in_b]) {
                    *count += i32::from(is);
                }
            }
        }
        for (region, count) in [union, both, less].iter().zip(counts) {
            prop_assert!((region.area() - f64::from(count)).abs() < 1e-9);
        }
    }
}

/// What no region can be of is refused: until 0.1.0 it panicked in the library of polygons.
#[test]
fn what_is_out_of_range_is_refused() {
    let square = Region::new(&[rectangle([0.0, 0.0], [8.0, 8.0])]).unwrap();
    for by in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1.1e9] {
        assert!(matches!(square.offset(by), Err(RegionError::Offset { .. })), "{by}");
        assert!(matches!(Region::default().offset(by), Err(RegionError::Offset { .. })), "{by}");
    }
    for normal in [[0.0, 0.0], [1.0, 1.0], [f64::NAN, 0.0], [f64::INFINITY, 0.0], [1e308, 1e308]] {
        assert!(matches!(square.half(normal, 1.0), Err(RegionError::Normal { .. })), "{normal:?}");
    }
    assert!(matches!(square.half([1.0, 0.0], f64::NAN), Err(RegionError::Offset { .. })));
    // A line far away takes all or nothing.
    for (offset, area) in [(1e308, 64.0), (f64::INFINITY, 64.0), (-1e308, 0.0), (f64::NEG_INFINITY, 0.0)] {
        assert!((square.half([0.6, 0.8], offset).unwrap().area() - area).abs() < 1e-6, "{offset}");
    }
    for x in [f64::NAN, f64::INFINITY, -1e308, 1.1e9] {
        assert!(
            matches!(Region::new(&[rectangle([0.0, 0.0], [8.0, x])]), Err(RegionError::Point { polygon: 0 })),
            "{x}"
        );
    }
}

proptest! {
    /// Whatever numbers come, there is a region or an error.
    #[test]
    fn no_numbers_panic(
        corners in proptest::collection::vec((extreme(), extreme()), 0..6),
        (by, x, y, offset) in (extreme(), extreme(), extreme(), extreme()),
    ) {
        let outer = corners.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        let Ok(region) = Region::new(&[SectionPolygon { outer, holes: Vec::new() }]) else { return Ok(()) };
        let _ = region.offset(by).map(|grown| grown.simplified(offset).area());
        let _ = region.half([x, y], offset);
        let length = x.hypot(y);
        let _ = region.half([x / length, y / length], offset).map(|half| half.union(&region).difference(&half));
        let _ = (region.centroid(), region.inner_point(), region.bounds(), region.without_specks(by));
    }
}

/// Numbers of any size.
fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        -10.0..10.0f64,
        proptest::num::f64::ANY,
        proptest::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            1e-300,
            1e-12,
            1e6,
            -1e9,
            1e9,
            1e154,
            1e308,
            f64::NAN,
            f64::INFINITY
        ]),
    ]
}
