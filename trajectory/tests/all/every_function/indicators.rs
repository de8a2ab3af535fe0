//! Indicators: samples, machines that learn from them, distances of shapes.

use super::numbers::{bad, count, each_spoilt, number};
use curvlay_trajectory::indicator::geometric::*;
use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
use curvlay_trajectory::indicator::*;
use curvlay_trajectory::nalgebra::{IsometryMatrix3, Point3, Unit, Vector3};
use proptest::prelude::*;

const SVM: [fn(&mut SvmOptions, f64); 4] = [
    |options, value| options.gamma = value,
    |options, value| options.cost = value,
    |options, value| options.tolerance = value,
    |options, value| options.bias_shift = value,
];
const SAMPLING: [fn(&mut SamplingOptions, f64); 5] = [
    |options, value| options.coarse_share = value,
    |options, value| options.coarse = value,
    |options, value| options.fine = value,
    |options, value| options.projected = value,
    |options, value| options.contact_tolerance = value,
];

fn feed_indicator<const N: usize>(indicator: &impl CollisionIndicator<N>, at: &[f64; N], samples: &[Sample<N>]) {
    let value = indicator.value(at);
    assert!(indicator.predicts(at) || value <= 0.0);
    indicator.gradient(at);
    let rates = Rates::of(indicator, samples);
    for share in [rates.tnr(), rates.hit_rate(), rates.missed_rate(), rates.trust()].into_iter().flatten() {
        assert!((0.0..=1.0).contains(&share));
    }
}

/// Samples as they are, and without those that are not finite.
fn both_kinds(joints: &[[f64; 2]], wall: f64) -> [Vec<Sample<2>>; 2] {
    let all: Vec<_> = joints.iter().map(|&joints| Sample { joints, collides: joints[0] > wall }).collect();
    let finite = all.iter().copied().filter(|sample| sample.joints.iter().all(|angle| angle.is_finite())).collect();
    [all, finite]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn machines_take_anything(
        joints in prop::collection::vec([number(), number()], 0..14), wall in -1.0..1.0f64, at in [number(), number()], value in bad(), count in count(), shift in number(),
    ) {
        let space = ContactFn {
            collides: |q: &[f64; 2]| q[0] > wall,
            gap: |q: &[f64; 2]| q[1] * shift,
            sample: |random: &mut dyn FnMut() -> f64| Some([3.0 * random(), 0.0]),
        };
        let features = TurnsAndGap { space, height: value, near_mm: shift };
        for samples in both_kinds(&joints, wall) {
            let sound = SvmOptions { max_steps: 5000, ..SvmOptions::default() };
            let more = [SvmOptions { max_steps: 0, ..sound }, SvmOptions { cache_bytes: count, ..sound }];
            for options in each_spoilt(&sound, &SVM, value).into_iter().chain(more) {
                let Ok(svm) = Svm::train(&samples, &options) else { continue };
                prop_assert_eq!((svm.training().samples, svm.expansion().count()), (samples.len(), svm.kernels()));
                let _ = svm.bias();
                feed_indicator(&svm, &at, &samples);
                feed_indicator(&svm.shifted(shift), &at, &samples);
            }
            let of_features = features_of::<2, 5>(&features, &samples);
            if let Ok(svm) = Svm::train(&of_features, &sound) {
                let on_features = OnFeatures::new(svm, features);
                prop_assert!(on_features.inner().kernels() <= samples.len());
                feed_indicator::<2>(&on_features, &at, &samples);
            }
        }
    }

    #[test]
    fn sampling_takes_anything(
        slope in number(), wall in number(), spread in number(), value in bad(), count in count(), seed: u64, at in [number(), number()], out in 0..3usize,
    ) {
        let space = ContactFn {
            collides: |q: &[f64; 2]| q[0] > wall,
            gap: |q: &[f64; 2]| q[1] * slope - 0.1 * q[0],
            sample: |random: &mut dyn FnMut() -> f64| (out > 0).then(|| [spread * random(), 0.0]),
        };
        for tolerance in [1e-3, value] {
            project(&space, &at, tolerance);
        }
        let sound = SamplingOptions { initial: 10, max_samples: 40, seed, ..SamplingOptions::default() };
        let more = [
            SamplingOptions { initial: count, ..sound }, SamplingOptions { neighbours: count, ..sound },
            SamplingOptions { max_samples: count.min(40), ..sound },
        ];
        for options in each_spoilt(&sound, &SAMPLING, value).into_iter().chain(more) {
            if let Ok(set) = training_set(&space, &options) {
                prop_assert!(set.samples.len() == set.on_contact.len() && set.samples.len() <= options.max_samples);
            }
        }
        for (count, within) in [(count, 0.1), (5, value), (5, spread)] {
            let _ = verification_samples(&space, count, within, seed);
            let _ = random_samples(&space, &at, &[within, value], count, seed);
            let _ = random_samples(&space, &[-1.0; 2], &[1.0; 2], count, seed);
        }
        let sound = HardOptions { initial: 12, rounds: 1, added: 2, pool: 6, within: 0.1, seed };
        let train = |samples: &[Sample<2>]| Svm::train(samples, &SvmOptions { max_steps: 500, ..SvmOptions::default() });
        let hard = [
            sound, HardOptions { initial: count, ..sound }, HardOptions { rounds: count.min(3), ..sound }, HardOptions { added: count, pool: count, ..sound },
            HardOptions { pool: count, ..sound }, HardOptions { within: value, ..sound },
        ];
        for options in hard {
            let _ = hard_samples(&space, &options, &train);
        }
    }
}

fn point() -> impl Strategy<Value = Point3<f64>> {
    [number(), number(), number()].prop_map(Point3::from)
}

fn feed_grid(grid: &DistanceGrid, points: &[Point3<f64>]) {
    assert!(grid.spacing() > 0.0 && grid.error_bound() > 0.0);
    for point in points {
        let _ = (grid.distance(point), grid.gradient(point));
    }
}

fn indicators(model: GeometricModel, count: usize) -> Option<GeometricIndicator<2, impl Bodies<2>>> {
    let bodies = BodiesFn {
        carriers: [[false, false], [true, false], [true, true]].into_iter().cycle().take(count).collect(),
        place: |q: &[f64; 2], frames: &mut [IsometryMatrix3<f64>]| {
            let turned = [
                IsometryMatrix3::identity(),
                IsometryMatrix3::rotation(Vector3::z() * q[0]),
                IsometryMatrix3::translation(q[1], 0.0, 0.0),
            ];
            frames.iter_mut().zip(turned).for_each(|(frame, turned)| *frame = turned);
        },
        twists: |_: &[f64; 2], _: &[IsometryMatrix3<f64>]| {
            [Twist::turning(&Point3::origin(), &Vector3::z()), Twist::sliding(&Vector3::x())]
        },
    };
    GeometricIndicator::new(bodies, model).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn grids_take_anything(
        dims in [0..5u32, 0..3u32, 0..3u32], words in prop::collection::vec(any::<u64>(), 0..9), size in number(), corner in point(), margin in prop::sample::select(vec![0, 1, 4, 40, u32::MAX]),
        around in number(), points in prop::collection::vec(point(), 0..6), triangles in prop::collection::vec([0..6u32, 0..6u32, 0..6u32], 0..9), huge in prop::sample::select(vec![0, 1 << 16, u32::MAX]),
    ) {
        let wanted = (dims[0].div_ceil(64) * dims[1] * dims[2]) as usize;
        let fitting: Vec<u64> = words.iter().copied().cycle().take(wanted).collect();
        for (dims, rows) in [(dims, &fitting), (dims, &words), ([huge; 3], &words), ([huge, 1, 1], &words), ([1, huge, 0], &vec![])] {
            for (cell, margin) in [(size, 2), (1.0, margin), (0.5, 5)] {
                if let Ok(grid) = DistanceGrid::from_cells(dims, rows, cell, &corner, margin) {
                    feed_grid(&grid, &points);
                }
            }
        }
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        for triangles in [&triangles[..], &faces] {
            for (spacing, margin) in [(size, 1.0), (0.5, around), (1.0, 2.0)] {
                // As fine as it may be it is only slow.
                let is_small = spacing.is_nan() || spacing > 0.01;
                if is_small && let Ok(grid) = DistanceGrid::from_triangles(&points, triangles, spacing, margin) {
                    feed_grid(&grid, &points);
                }
            }
        }
    }

    #[test]
    fn shapes_take_anything(
        ends in [point(), point(), point()], radii in [number(), number()], axis in [number(), number(), number()], value in bad(), count in 0..18usize, bodies in [0..3usize, 0..3usize], wrong in count(),
        at in [number(), number()], corner in point(),
    ) {
        let [from, to, center] = ends;
        let cube = DistanceGrid::from_cells([2, 2, 2], &[3; 4], 1.0, &Point3::origin(), 2).unwrap();
        let [a, b] = bodies;
        let normal = Unit::new_unchecked(Vector3::from(axis));
        let sound = GeometricModel {
            grids: vec![(0, cube.clone())],
            balls: Ball::along(2, &Point3::origin(), &Point3::new(5.0, 0.0, 0.0), [0.5, 1.0], 3),
            capsules: vec![Capsule { body: 1, from: Point3::new(9.0, 0.0, 0.0), to: Point3::new(12.0, 0.0, 0.0), radius: 1.0 }],
            cylinders: vec![Cylinder { body: 2, from: Point3::new(0.0, 9.0, 0.0), to: Point3::new(0.0, 12.0, 0.0), radius: 1.0 }],
            planes: vec![Plane { body: 0, point: Point3::new(0.0, 0.0, -20.0), normal: Vector3::z_axis() }],
            ignored: vec![],
            margin: 1.0,
        };
        let far = DistanceGrid::from_cells([1, 1, 1], &[1], 1.0, &corner, 2);
        let models = [
            sound.clone(),
            GeometricModel { grids: far.clone().map(|grid| vec![(a, grid)]).unwrap_or_default(), ..sound.clone() },
            GeometricModel { balls: Ball::along(a, &from, &to, radii, count), ..sound.clone() },
            GeometricModel { capsules: vec![Capsule { body: b, from, to, radius: radii[0] }], ..sound.clone() },
            GeometricModel { cylinders: vec![Cylinder { body: a, from, to, radius: radii[1] }], ..sound.clone() },
            GeometricModel { planes: vec![Plane { body: b, point: center, normal }], ..sound.clone() },
            GeometricModel { ignored: vec![[a, b], [wrong, 0]], ..sound.clone() },
            GeometricModel { margin: value, ..sound.clone() },
            GeometricModel { balls: vec![Ball { body: wrong, center, radius: 1.0 }], ..sound },
        ];
        for model in models {
            for count in [3, count] {
                let Some(mut indicator) = indicators(model.clone(), count) else { continue };
                for at in [at, [0.0; 2], [value, 0.0], [0.3, value]] {
                    indicator.nearest(&at);
                    feed_indicator(&indicator, &at, &[]);
                }
                if let Ok(grid) = &far {
                    let is_there = indicator.replace_grid(0, grid.clone()).is_some();
                    prop_assert!(is_there || model.grids.is_empty());
                    indicator.replace_grid(wrong.max(9), grid.clone());
                    feed_indicator(&indicator, &at, &[]);
                }
            }
        }
        let twist = Twist::turning(&from, &Vector3::from(axis));
        let _ = twist.velocity(&to);
    }
}
