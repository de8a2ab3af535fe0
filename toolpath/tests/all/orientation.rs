//! Waypoints and directions along curves: closed forms, a slow twin, isometries, and what is refused.

use crate::common::{self, go_on, layers, rng, rough};

use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack, StackError};
use curvlay_toolpath::nalgebra::{DMatrix, DVector, Isometry3, Point3, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{OrientError, OrientOptions, Oriented, Waypoint};
use layers::{Layer, with_stack};
use proptest::prelude::*;
use rand::RngExt;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

const H: f64 = 0.8;

fn oriented(layers: &[Layer], options: &OrientOptions) -> Oriented {
    with_stack(layers, |stack| stack.orient(options, &go_on).unwrap())
}

/// Directions as they are found, at points of the curve.
fn raw() -> OrientOptions {
    OrientOptions { wave: 0.0, max_turn: PI, low_pass_rounds: 0, lift: 0.0, ..OrientOptions::default() }
}

/// A level square of side 10 at the height of layer `k`.
fn level(k: u32) -> Layer {
    Layer::sheet([0.0, 0.0, H * (f64::from(k) + 0.5)], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H)
}

fn degrees(a: &UnitVector3<f64>, b: &Vector3<f64>) -> f64 {
    a.angle(b).to_degrees()
}

#[test]
fn level_layers_point_up_and_the_tip_is_on_top_of_the_bead() {
    let layers = [0, 1, 2]
        .map(|k| level(k).with(&[[1.0, 2.0, H * (f64::from(k) + 0.5)], [9.0, 5.0, H * (f64::from(k) + 0.5)]], 0.9));
    let found = oriented(&layers, &OrientOptions { share: false, ..OrientOptions::default() });
    assert_eq!((found.paths.len(), found.added, found.by_normal), (3, 0, 0));
    assert!(found.before.largest < 1e-7 && found.sharp.is_empty());
    for (k, path) in found.paths.iter().enumerate() {
        assert_eq!((path.layer as usize, path.waypoints.len()), (k, 10)); // 8.54 mm in 9 steps
        let length = 73_f64.sqrt();
        for (n, w) in path.waypoints.iter().enumerate() {
            assert!(degrees(&w.axis, &Vector3::z()) < 1e-6);
            assert!((w.position.z - H * (k as f64 + 1.0)).abs() < 1e-9);
            assert!((w.arc - length * n as f64 / 9.0).abs() < 1e-9 && (w.width - 0.9).abs() < 1e-12);
            assert!((w.height - H).abs() < 1e-12);
        }
    }
}

#[test]
fn slanted_layers_point_along_their_normal() {
    let (sin, cos) = 0.5_f64.sin_cos();
    let slanted = |k: f64| {
        let corner = [-sin * H * k, 0.0, 50.0 + cos * H * k];
        Layer::sheet(corner, [12.0 * cos, 0.0, 12.0 * sin], [0.0, 12.0, 0.0], 5, H)
    };
    let on = |t: f64| [-sin * H + t * cos, 6.0, 50.0 + cos * H + t * sin];
    let layers = [slanted(0.0), slanted(1.0).with(&[on(2.0), on(10.0)], 0.8)];
    for w in &oriented(&layers, &raw()).paths[0].waypoints {
        assert!(degrees(&w.axis, &Vector3::new(-sin, 0.0, cos)) < 1e-6);
    }
}

#[test]
fn beyond_the_edge_of_the_layer_below_directions_lean_out() {
    let above = Layer::sheet([0.0, 0.0, 50.0 + H], [14.0, 0.0, 0.0], [0.0, 10.0, 0.0], 9, H);
    let below = Layer::sheet([0.0, 0.0, 50.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H);
    let at = |x: f64| above.clone().with(&[[x, 2.0, 50.0 + H], [x, 8.0, 50.0 + H]], 0.8);
    for (x, expected, by_normal) in [
        (9.5, Vector3::z(), false),
        (10.4, Vector3::new(0.4, 0.0, H), false),
        (11.2, Vector3::new(1.2, 0.0, H), false),
        (11.5, Vector3::z(), true), // 62 degrees: beside, not below
    ] {
        let found = oriented(&[below.clone(), at(x)], &raw());
        assert_eq!(found.by_normal > 0, by_normal, "{x}");
        found.paths[0].waypoints.iter().for_each(|w| assert!(degrees(&w.axis, &expected) < 1e-6, "{x}: {w:?}"));
    }
}

#[test]
fn over_a_hole_the_layer_below_it_counts_and_over_a_deep_one_the_normal() {
    // Layer 1 has a slit from x = 3 to x = 7; layer 0 lies below it, or four layers deeper.
    let part = |x: f64| Layer::sheet([x, 0.0, 50.0 + H], [3.0, 0.0, 0.0], [0.0, 10.0, 0.0], 3, H);
    let slit = part(0.0).and(&part(7.0));
    let above = Layer::sheet([0.0, 0.0, 50.0 + 2.0 * H], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H);
    let above = above.with(&[[5.0, 1.0, 50.0 + 2.0 * H], [5.0, 9.0, 50.0 + 2.0 * H]], 0.8);
    for (depth, by_normal) in [(0.0, 0), (3.2, 9)] {
        let lowest = Layer::sheet([0.0, 0.0, 50.0 - depth], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H);
        let found = oriented(&[lowest, slit.clone(), above.clone()], &raw());
        assert_eq!(found.by_normal, by_normal);
        found.paths[0].waypoints.iter().for_each(|w| assert!(degrees(&w.axis, &Vector3::z()) < 1e-6));
    }
}

#[test]
fn an_earlier_surface_beside_a_later_one_says_nothing() {
    // A front that waited: an upright sheet of layer 0 a tenth of a millimetre beside the curve.
    let beside = Layer::sheet([4.9, 0.0, 48.0], [0.0, 10.0, 0.0], [0.0, 0.0, 6.0], 5, H);
    let below = Layer::sheet([5.0, 0.0, 50.0], [5.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H).and(&beside);
    let above = Layer::sheet([5.0, 0.0, 50.0 + H], [5.0, 0.0, 0.0], [0.0, 10.0, 0.0], 7, H);
    let found = oriented(&[below, above.with(&[[5.0, 1.0, 50.0 + H], [5.0, 9.0, 50.0 + H]], 0.8)], &raw());
    found.paths[0].waypoints.iter().for_each(|w| assert!(degrees(&w.axis, &Vector3::z()) < 1e-6, "{w:?}"));
}

/// A layer of facets that lean any way, and a line over it.
fn facets(seed: u64) -> [Layer; 2] {
    let mut random = rng(seed);
    let mut below = Layer::sheet([0.0, 0.0, 50.0], [40.0, 0.0, 0.0], [0.0, 10.0, 0.0], 20, H);
    below.vertices.iter_mut().for_each(|vertex| vertex.z += random.random_range(-0.3..0.3));
    let above = Layer::sheet([0.0, 0.0, 50.0 + H], [40.0, 0.0, 0.0], [0.0, 10.0, 0.0], 4, H);
    [below, above.with(&[[1.0, 5.0, 50.0 + H], [20.3, 3.0, 50.0 + H], [39.0, 6.0, 50.0 + H]], 0.8)]
}

/// The directions of the first path, and how far along it they are.
fn directions(layers: &[Layer], options: &OrientOptions) -> (Vec<Vector3<f64>>, Vec<f64>) {
    let waypoints = oriented(layers, options).paths.swap_remove(0).waypoints;
    waypoints.iter().map(|w| (w.axis.into_inner(), w.arc)).unzip()
}

/// The least of `sum |d - raw|^2 + (wave / 2 pi)^4 sum |d''|^2`, with a matrix of all points.
fn slow_steady(raw: &[Vector3<f64>], arcs: &[f64], wave: f64) -> Vec<Vector3<f64>> {
    let n = raw.len();
    let step = |k: usize| arcs[k + 1] - arcs[k];
    let step_before = |k: usize| if k > 0 { step(k - 1) } else { 0.0 };
    let length = |k: usize| (step_before(k) + if k + 1 < n { step(k) } else { 0.0 }) / 2.0;
    let mut all = DMatrix::from_fn(n, n, |i, j| if i == j { length(i) } else { 0.0 });
    for k in 1..n - 1 {
        let mut second: DVector<f64> = DVector::zeros(n);
        for (at, slope) in [(k - 1, step(k - 1)), (k + 1, step(k))] {
            second[at] += 1.0 / slope / length(k);
            second[k] -= 1.0 / slope / length(k);
        }
        all += &second * second.transpose() * (length(k) * (wave / TAU).powi(4));
    }
    let right = DMatrix::from_fn(n, 3, |k, d| raw[k][d] * length(k));
    let found = all.lu().solve(&right).unwrap();
    (0..n).map(|k| Vector3::new(found[(k, 0)], found[(k, 1)], found[(k, 2)]).normalize()).collect()
}

proptest! {
    #[test]
    fn steady_directions_bend_least(seed in 0u64..1_000_000, wave in 1.0..30.0) {
        let layers = facets(seed);
        let (raw_directions, arcs) = directions(&layers, &raw());
        let (steady, _) = directions(&layers, &OrientOptions { wave, max_tilt: PI, ..raw() });
        let twin = slow_steady(&raw_directions, &arcs, wave);
        prop_assert!(steady.iter().zip(&twin).all(|(a, b)| (a - b).norm() < 1e-9));
        // Held near what they were; where that is nowhere far off, nothing changes.
        let farthest = raw_directions.iter().zip(&steady).map(|(a, b)| a.angle(b)).fold(0.0, f64::max);
        let (same, _) = directions(&layers, &OrientOptions { wave, max_tilt: farthest + 1e-9, ..raw() });
        prop_assert_eq!(same, steady.clone());
        let max_tilt = farthest / 2.0;
        let (held, _) = directions(&layers, &OrientOptions { wave, max_tilt, ..raw() });
        prop_assert!(held.iter().zip(&raw_directions).all(|(a, b)| a.angle(b) <= max_tilt + 1e-7));
        let bends = |all: &[Vector3<f64>]| all.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).norm_squared()).sum::<f64>();
        prop_assert!(bends(&steady) <= bends(&held) && bends(&held) <= bends(&raw_directions));
    }
}

#[test]
fn a_wave_of_the_length_asked_for_keeps_half_its_height() {
    // Ridges along y, 10 mm from one to the next, so low that directions follow their slope.
    let wave = |x: f64| 0.01 * (TAU * x / 10.0).cos();
    let mut below = Layer::sheet([0.0, 0.0, 50.0], [80.0, 0.0, 0.0], [0.0, 10.0, 0.0], 400, H);
    below.vertices.iter_mut().for_each(|vertex| vertex.z += wave(vertex.x));
    let above = Layer::sheet([0.0, 0.0, 50.0 + H], [80.0, 0.0, 0.0], [0.0, 10.0, 0.0], 4, H);
    let layers = [below, above.with(&[[0.0, 5.0, 50.0 + H], [80.0, 5.0, 50.0 + H]], 0.8)];
    let height = |wave: f64| {
        let (found, arcs) = directions(&layers, &OrientOptions { wave, step: 0.25, ..raw() });
        let inner = found.iter().zip(&arcs).filter(|(_, arc)| (20.0..60.0).contains(*arc));
        inner.map(|(direction, _)| direction.x).fold(0.0, f64::max)
    };
    let shares = [5.0, 10.0, 20.0].map(|wave| height(wave) / height(0.0));
    let expected = [16.0 / 17.0, 0.5, 1.0 / 17.0];
    assert!(shares.iter().zip(expected).all(|(share, expected)| (share - expected).abs() < 0.02), "{shares:?}");
}

/// A roof with sides of 45 degrees, its ridge along y at height `z`.
fn roof(z: f64, reach: f64) -> Layer {
    let left = Layer::sheet([-reach, 0.0, z - reach], [reach, 0.0, reach], [0.0, 10.0, 0.0], 6, H);
    left.and(&Layer::sheet([0.0, 0.0, z], [reach, 0.0, -reach], [0.0, 10.0, 0.0], 6, H))
}

#[test]
fn across_a_crest_turns_are_shared_out() {
    let up = H * 2_f64.sqrt();
    let across = [[-5.0, 5.0, 45.0 + up], [0.0, 5.0, 50.0 + up], [5.0, 5.0, 45.0 + up]];
    let layers = [roof(50.0, 8.0), roof(50.0 + up, 8.0).with(&across, 0.8)];
    let found = oriented(&layers, &OrientOptions { wave: 0.0, low_pass_rounds: 0, ..OrientOptions::default() });
    assert!((found.before.largest.to_degrees() - 45.0).abs() < 1.0, "{:?}", found.before);
    assert!(found.after.largest <= 10_f64.to_radians() + 1e-8 && found.sharp.is_empty());
    assert_eq!(found.added, 8); // twice 45 degrees, each in five parts
    // On great circles: nothing leans out of the plane across, and the lean only ever grows.
    let leans: Vec<f64> = found.paths[0].waypoints.iter().map(|w| w.axis.x.atan2(w.axis.z)).collect();
    assert!(found.paths[0].waypoints.iter().all(|w| w.axis.y.abs() < 1e-9));
    assert!(leans.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9), "{leans:?}");
    // A low-pass spreads the turn, so fewer points are put between.
    let smooth = oriented(&layers, &OrientOptions { wave: 0.0, ..OrientOptions::default() });
    assert!(smooth.after.largest <= 10_f64.to_radians() + 1e-8);
    assert!(smooth.added < found.added && smooth.after.mean <= found.before.mean + 1e-9, "{smooth:?}");
    // Tips are half a layer above the surface.
    let apex = found.paths[0].waypoints.iter().map(|w| w.position.z).fold(0.0, f64::max);
    assert!((apex - (50.0 + up + H / 2.0)).abs() < 1e-9, "{apex}");
}

#[test]
fn corners_stay_and_steps_between_are_even() {
    let bent = [[1.0, 1.0, 0.4], [4.3, 1.0, 0.4], [4.3, 8.7, 0.4]];
    let found = oriented(&[level(0).with(&bent, 0.8)], &OrientOptions::default());
    let arcs: Vec<f64> = found.paths[0].waypoints.iter().map(|w| w.arc).collect();
    let expected = (0..=3).map(|k| 1.1 * f64::from(k)).chain((1..=8).map(|k| 3.3 + 7.7 / 8.0 * f64::from(k)));
    assert!(arcs.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9) && arcs.len() == 12, "{arcs:?}");
    // A gentle bend is no corner.
    let gentle = [[1.0, 1.0, 0.4], [4.3, 1.0, 0.4], [7.9, 2.5, 0.4]];
    let found = oriented(&[level(0).with(&gentle, 0.8)], &OrientOptions::default());
    let steps: Vec<f64> = found.paths[0].waypoints.windows(2).map(|w| w[1].arc - w[0].arc).collect();
    assert!(steps.iter().all(|step| (step - 7.2 / 7.0).abs() < 1e-9), "{steps:?}");
    // A corner rounded by points a tenth of a millimetre apart is one corner.
    let round = |k: u32| {
        let (sin, cos) = (f64::from(k) * PI / 16.0).sin_cos();
        [5.0 + 0.2 * sin, 3.0 + 0.2 * (1.0 - cos), 0.4]
    };
    let rounded: Vec<[f64; 3]> =
        [[1.0, 3.0, 0.4]].into_iter().chain((0..=8).map(round)).chain([[5.2, 7.2, 0.4]]).collect();
    let found = oriented(&[level(0).with(&rounded, 0.8)], &OrientOptions::default());
    let middle = Point3::new(5.0 + 0.2 * 0.5_f64.sqrt(), 3.2 - 0.2 * 0.5_f64.sqrt(), H);
    let near = found.paths[0].waypoints.iter().filter(|w| (w.position - middle).norm() < 0.08).count();
    assert_eq!(near, 1);
}

#[test]
fn a_closed_curve_ends_where_it_starts() {
    let corners = [[1.0, 1.0], [9.0, 1.0], [9.0, 7.0], [1.0, 7.0]].map(|[x, y]| Point3::new(x, y, 0.4));
    let mut layer = level(0);
    layer.curves.push((corners.to_vec(), 0.8, true));
    let found = oriented(&[layer], &OrientOptions::default());
    let waypoints = &found.paths[0].waypoints;
    assert!(found.paths[0].closed && waypoints.len() == 29);
    assert!((waypoints[0].position - waypoints[28].position).norm() < 1e-12 && (waypoints[28].arc - 28.0).abs() < 1e-9);
    for corner in corners {
        assert!(waypoints.iter().any(|w| (w.position - corner - Vector3::new(0.0, 0.0, 0.4)).norm() < 1e-9));
    }
}

/// The closest point of a triangle: over its plane, its edges, its corners.
fn slow_closest([a, b, c]: [Point3<f64>; 3], p: Point3<f64>) -> Point3<f64> {
    let n = (b - a).cross(&(c - a));
    let foot = p - n * (n.dot(&(p - a)) / n.norm_squared());
    let inside = [[a, b], [b, c], [c, a]].iter().all(|[from, to]| (to - from).cross(&(foot - from)).dot(&n) >= 0.0);
    let on_edge = |[from, to]: [Point3<f64>; 2]| {
        let t = ((p - from).dot(&(to - from)) / (to - from).norm_squared()).clamp(0.0, 1.0);
        from + (to - from) * t
    };
    let mut candidates = vec![a, b, c, on_edge([a, b]), on_edge([b, c]), on_edge([c, a])];
    candidates.extend(inside.then_some(foot));
    candidates.into_iter().min_by(|q, r| (q - p).norm().total_cmp(&(r - p).norm())).unwrap()
}

/// The normal of a layer at its point closest to `p`: those of vertices, mixed by area.
fn slow_normal(layer: &Layer, p: Point3<f64>) -> Vector3<f64> {
    let corners = |t: &[u32; 3]| t.map(|v| layer.vertices[v as usize]);
    let area = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a));
    let at_vertex = |v: u32| {
        let around = layer.triangles.iter().filter(|t| t.contains(&v));
        around.map(|t| area(corners(t))).sum::<Vector3<f64>>().normalize()
    };
    let distance = |t: &&[u32; 3]| (slow_closest(corners(t), p) - p).norm();
    let t = layer.triangles.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
    let ([a, b, c], q) = (corners(t), slow_closest(corners(t), p));
    let weights = [[q, b, c], [a, q, c], [a, b, q]].map(|part| area(part).norm());
    t.iter().zip(weights).map(|(&v, weight)| at_vertex(v) * weight).sum::<Vector3<f64>>().normalize()
}

/// Two rough layers above each other, and a curve of random points on the upper one.
fn rough_layers(seed: u64) -> [Layer; 2] {
    let mut rng = rng(seed);
    let lift = |layer: &mut Layer, z: f64| layer.vertices.iter_mut().for_each(|p| p.z += z);
    let [mut low, mut high] = [seed, seed + 1000].map(|seed| {
        let mesh = rough(8, seed, 1.5, |i, j| (i, j) == (3, 4));
        Layer::new(mesh.vertices(), mesh.triangles(), H)
    });
    lift(&mut low, 50.0);
    lift(&mut high, 51.0);
    let points = (0..30)
        .map(|_| {
            let t = high.triangles[rng.random_range(0..high.triangles.len())].map(|v| high.vertices[v as usize]);
            let w = common::random_barycentric(&mut rng);
            Point3::from(t[0].coords * w[0] + t[1].coords * w[1] + t[2].coords * w[2])
        })
        .collect();
    high.curves.push((points, 0.8, false));
    [low, high]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn directions_agree_with_a_look_at_all_triangles(seed in 0_u64..500) {
        let layers = rough_layers(seed);
        let found = oriented(&layers, &OrientOptions { step: 0.5, ..raw() });
        let mut by_normal = 0;
        for w in &found.paths[0].waypoints {
            let normal = slow_normal(&layers[1], w.position);
            // Steps to the tip from triangles that face the same way within 60 degrees.
            let corners = |t: &[u32; 3]| t.map(|v| layers[0].vertices[v as usize]);
            let facing = layers[0].triangles.iter().map(corners).filter(|[a, b, c]| {
                (b - a).cross(&(c - a)).angle(&normal).to_degrees() < 60.0
            });
            let steps: Vec<Vector3<f64>> =
                facing.map(|t| w.position - slow_closest(t, w.position)).filter(|step| step.norm() < 3.0 * H).collect();
            let lean = |step: &Vector3<f64>| step.angle(&normal).to_degrees();
            let verge = |step: &Vector3<f64>| (lean(step) - 60.0).abs() < 1e-5 || (lean(step) - 30.0).abs() < 1e-5;
            if steps.iter().any(|step| step.norm() < 1e-5 || verge(step)) {
                continue;
            }
            let within = |angle: f64| {
                let below = steps.iter().filter(|step| lean(step) < angle);
                below.min_by(|a, b| a.norm().total_cmp(&b.norm())).copied()
            };
            let closest = within(30.0).or_else(|| within(60.0));
            by_normal += usize::from(closest.is_none());
            let direction = closest.unwrap_or(normal);
            prop_assert!(degrees(&w.axis, &direction) < 1e-4, "{w:?} {direction:?}");
        }
        prop_assert!(by_normal <= found.by_normal);
    }

    #[test]
    fn turns_are_within_the_limit_or_listed(seed in 0_u64..500, limit in 4.0_f64..30.0) {
        let options = OrientOptions { max_turn: limit.to_radians(), ..OrientOptions::default() };
        let found = oriented(&rough_layers(seed), &options);
        let mut sharp = 0;
        for (path, waypoints) in found.paths.iter().map(|path| &path.waypoints).enumerate() {
            for (k, pair) in waypoints.windows(2).enumerate() {
                let turn = pair[0].axis.angle(&pair[1].axis);
                if turn > options.max_turn + 1e-7 {
                    prop_assert!(found.sharp.iter().any(|s| (s.path, s.waypoint) == (path, k)));
                    sharp += 1;
                }
                prop_assert!(pair[1].arc > pair[0].arc && pair[1].arc - pair[0].arc < 1.5);
                prop_assert!((pair[0].axis.norm() - 1.0).abs() < 1e-12);
            }
        }
        prop_assert_eq!(sharp, found.sharp.len());
        prop_assert!(found.after.mean <= found.before.mean + 1e-9);
    }

    #[test]
    fn a_rigid_motion_moves_the_waypoints(seed in 0_u64..500, turn in prop::array::uniform3(-3.0_f64..3.0)) {
        // Far above the plate.
        let by = Isometry3::new(Vector3::new(3.0, -5.0, 400.0), Vector3::from(turn));
        let layers = rough_layers(seed);
        let there = oriented(&layers.each_ref().map(|layer| layer.moved(&by)), &OrientOptions::default());
        let here = oriented(&layers, &OrientOptions::default());
        prop_assert_eq!(here.paths[0].waypoints.len(), there.paths[0].waypoints.len());
        for (a, b) in here.paths[0].waypoints.iter().zip(&there.paths[0].waypoints) {
            prop_assert!((by * a.position - b.position).norm() < 1e-6, "{a:?} {b:?}");
            prop_assert!(degrees(&b.axis, &(by * a.axis.into_inner())) < 1e-4);
        }
    }
}

#[test]
fn threads_change_nothing() {
    let layers = rough_layers(7);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| oriented(&layers, &OrientOptions::default()))
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn a_turn_to_the_opposite_side_is_listed() {
    // Two sheets back to back, far apart from all else: half of the curve has the normal up, the other half down.
    let up = Layer::sheet([0.0, 0.0, 50.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0], 2, H);
    let down = Layer::sheet([5.0, 0.0, 50.0], [0.0, 5.0, 0.0], [5.0, 0.0, 0.0], 2, H);
    let both = up.and(&down).with(&[[1.0, 2.5, 50.0], [9.0, 2.5, 50.0]], 0.8);
    let layers = [Layer::sheet([0.0, 0.0, 0.4], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1, H), both];
    let found = oriented(&layers, &OrientOptions { low_pass_rounds: 0, ..OrientOptions::default() });
    assert_eq!(found.sharp.len(), 1);
    assert!((found.sharp[0].angle - PI).abs() < 1e-9);
}

#[test]
fn layers_that_cannot_be_used_are_named() {
    let square = level(0);
    let line = [Point3::new(1.0, 1.0, 0.4), Point3::new(2.0, 1.0, 0.4)];
    let widths = [0.8; 2];
    let spacing = vec![H; square.triangles.len()];
    let sound = BuiltLayer { vertices: &square.vertices, triangles: &square.triangles, spacing: &spacing, curves: &[] };
    let straight = LayerCurve { points: &line, widths: &widths, kinds: &[], closed: false };
    let error = |layer: BuiltLayer| LayerStack::new(&[layer]).unwrap_err();
    let of_curve = |curve: LayerCurve| error(BuiltLayer { curves: &[curve], ..sound });
    let (layer, curve) = (0, 0);
    let infinite = [Point3::new(0.0, f64::INFINITY, 0.0); 64];
    assert_eq!(error(BuiltLayer { vertices: &infinite, ..sound }), StackError::BadVertex { layer, vertex: 0 });
    let no_vertex = StackError::NoSuchVertex { layer, triangle: 0, vertex: 7, vertices: 2 };
    assert_eq!(error(BuiltLayer { vertices: &line, triangles: &[[0, 1, 7]], ..sound }), no_vertex);
    let count = StackError::SpacingCount { layer, spacing: 1, triangles: 98 };
    assert_eq!(error(BuiltLayer { spacing: &[0.8], ..sound }), count);
    let thin = StackError::BadSpacing { layer, triangle: 0, spacing: 0.0 };
    assert_eq!(error(BuiltLayer { spacing: &[0.0; 98], ..sound }), thin);
    let flat = BuiltLayer { triangles: &[[0, 0, 1]], spacing: &[0.8], curves: &[straight], ..sound };
    assert_eq!(error(flat), StackError::NoSurface { layer });
    let few = |points| StackError::FewPoints { layer, curve, points };
    assert_eq!(of_curve(LayerCurve { points: &line[..1], ..straight }), few(1));
    assert_eq!(of_curve(LayerCurve { closed: true, ..straight }), few(2));
    let width_count = StackError::WidthCount { layer, curve, widths: 1, points: 2 };
    assert_eq!(of_curve(LayerCurve { widths: &widths[..1], ..straight }), width_count);
    let nan = [line[0], Point3::new(f64::NAN, 0.0, 0.0)];
    assert_eq!(of_curve(LayerCurve { points: &nan, ..straight }), StackError::BadPoint { layer, curve, point: 1 });
    let width = StackError::BadWidth { layer, curve, point: 1, width: -1.0 };
    assert_eq!(of_curve(LayerCurve { widths: &[0.8, -1.0], ..straight }), width);
    assert_eq!(of_curve(LayerCurve { points: &[line[0]; 2], ..straight }), StackError::NoLength { layer, curve });
    // A layer without curves may be empty.
    let empty = BuiltLayer { vertices: &[], triangles: &[], spacing: &[], curves: &[] };
    let layers = [empty; 2];
    let nothing = LayerStack::new(&layers).unwrap().orient(&OrientOptions::default(), &go_on).unwrap();
    assert_eq!((nothing.paths.len(), nothing.after.steps), (0, 0));
}

#[test]
fn options_and_normals_that_cannot_be_used_are_named() {
    let layers = [level(0).with(&[[1.0, 1.0, 0.4], [9.0, 1.0, 0.4]], 0.8)];
    let error = |options: OrientOptions| with_stack(&layers, |stack| stack.orient(&options, &go_on).unwrap_err());
    let default = OrientOptions::default();
    for (name, options) in [
        ("step", OrientOptions { step: 0.0, ..default }),
        ("step", OrientOptions { step: f64::NAN, ..default }),
        ("wave", OrientOptions { wave: -1.0, ..default }),
        ("wave", OrientOptions { wave: f64::INFINITY, ..default }),
        ("max_tilt", OrientOptions { max_tilt: f64::NAN, ..default }),
        ("max_tilt", OrientOptions { max_tilt: -0.1, ..default }),
        ("corner", OrientOptions { corner: -1.0, ..default }),
        ("max_turn", OrientOptions { max_turn: 1e-9, ..default }),
        ("max_turn", OrientOptions { max_turn: 10.0, ..default }),
        ("lift", OrientOptions { lift: f64::INFINITY, ..default }),
    ] {
        assert!(matches!(error(options), OrientError::Option { option, .. } if option == name), "{name}");
    }
    assert!(matches!(error(OrientOptions { step: 1e-300, ..default }), OrientError::TooFine { .. }));
    let cancelled = with_stack(&layers, |stack| stack.orient(&default, &|_| ControlFlow::Break(())).unwrap_err());
    assert_eq!(cancelled, OrientError::Cancelled);
    // The same triangles from both sides: their normals cancel.
    let mut both = level(0).with(&[[1.0, 1.0, 0.4], [9.0, 1.0, 0.4]], 0.8);
    let flipped: Vec<_> = both.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    both.triangles.extend(flipped);
    let error = with_stack(&[both], |stack| stack.orient(&default, &go_on).unwrap_err());
    assert!(matches!(error, OrientError::NoNormal { layer: 0, curve: 0, arc } if arc.abs() < 1e-12), "{error}");
}

/// A sample is on the polyline, wherever corners are.
#[test]
fn samples_are_on_the_curve() {
    let layers = rough_layers(3);
    let found = oriented(&layers, &raw());
    let line = &layers[1].curves[0].0;
    let off = |w: &Waypoint| {
        line.windows(2).map(|s| common::to_segment(w.position, s[0], s[1])).fold(f64::INFINITY, f64::min)
    };
    assert!(found.paths[0].waypoints.iter().all(|w| off(w) < 1e-9));
    let length: f64 = line.windows(2).map(|s| (s[1] - s[0]).norm()).sum();
    assert!((found.paths[0].waypoints.last().unwrap().arc - length).abs() < 1e-9);
}
