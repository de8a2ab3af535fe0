//! Ways from path to path: against a dense raster, closed forms, what is blocked and what is refused.
//!
//! The slow twin looks at a raster of points through the thickness of every triangle, and at many places along each leg.

use crate::common::nozzle::tip_1_mm;
use crate::common::{go_on, layers, nozzle, rng, rough};

use curvlay_toolpath::deposit::{DepositionError, DepositionOptions, MoveKind, deposit_along};
use curvlay_toolpath::gouging::{GougingError, Obstacle};
use curvlay_toolpath::nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use curvlay_toolpath::orientation::{Pose, ToolPath};
use curvlay_toolpath::travel::{BlockedTravel, TravelOptions, Travels};
use layers::{Layer, path, with_stack};
use nozzle::{inside, to_profile};
use rand::RngExt;
use std::f64::consts::PI;
use std::ops::ControlFlow;

const H: f64 = 0.8;
/// What searches may be off by, in millimetres: pieces of a fiftieth of a layer.
const PIECE: f64 = 0.02 * H;

fn travels_with(layers: &[Layer], paths: &[ToolPath], options: &TravelOptions) -> Travels {
    with_stack(layers, |stack| stack.travels(paths, &tip_1_mm(), options, &go_on).unwrap())
}

/// True distance from a point to the default nozzle, 0 inside.
fn distance(pose: &Pose, p: Point3<f64>) -> f64 {
    let v = p - pose.tip;
    let z = v.dot(&pose.direction);
    let rho = (v - pose.direction.into_inner() * z).norm();
    if inside(z, rho) { 0.0 } else { to_profile(z, rho) }
}

/// Points on the middle and both sheets of layers, along the normals of the triangles.
fn raster(layers: &[Layer], n: usize) -> Vec<Point3<f64>> {
    let mut points = Vec::new();
    for layer in layers {
        for corners in &layer.triangles {
            let [a, b, c] = corners.map(|v| layer.vertices[v as usize]);
            let normal = (b - a).cross(&(c - a)).normalize() * (0.5 * layer.spacing);
            for i in 0..=n {
                for j in 0..=n - i {
                    let p = a + (b - a) * (i as f64 / n as f64) + (c - a) * (j as f64 / n as f64);
                    points.extend([p, p + normal, p - normal]);
                }
            }
        }
    }
    points
}

/// Poses along a way, with the direction turned by a quaternion.
fn sampled(way: &[Pose], parts: usize) -> Vec<Pose> {
    let leg = |pair: &[Pose]| {
        let [from, to] = [pair[0], pair[1]];
        let turn = UnitQuaternion::rotation_between(&from.direction, &to.direction).unwrap();
        let pose = move |k: usize| {
            let share = k as f64 / parts as f64;
            let direction = UnitQuaternion::identity().slerp(&turn, share) * from.direction;
            Pose { tip: from.tip + (to.tip - from.tip) * share, direction }
        };
        (0..=parts).map(pose).collect::<Vec<_>>()
    };
    way.windows(2).flat_map(leg).collect()
}

/// What must hold for all travels.
fn is_sound(layers: &[Layer], paths: &[ToolPath], travels: &Travels, options: &TravelOptions) {
    is_sound_with(layers, paths, travels, options, |_| options.clearance);
}

/// The same with `room`, what a way keeps from the plate.
fn is_sound_with(
    layers: &[Layer],
    paths: &[ToolPath],
    travels: &Travels,
    options: &TravelOptions,
    room: impl Fn(&[Pose]) -> f64,
) {
    assert_eq!(travels.ways.len(), paths.len());
    assert!(travels.ways[0].is_empty());
    for k in 1..paths.len() {
        let way = &travels.ways[k];
        let (from, to) = (paths[k - 1].waypoints.last().unwrap(), paths[k].waypoints[0]);
        for (end, pose) in [(*from, way[0]), (to, way[way.len() - 1])] {
            assert_eq!(pose.direction, end.axis);
            let lift = (pose.tip - end.position).dot(&end.axis);
            assert!((pose.tip - end.position - end.axis.into_inner() * lift).norm() < 1e-9);
            assert!((options.min_lift - 1e-9..=options.max_lift + 1e-9).contains(&lift), "{lift}");
        }
        if travels.blocked.iter().any(|blocked| blocked.path == k) {
            continue;
        }
        let built = raster(&layers[..=paths[k].layer as usize], 4);
        for pose in sampled(way, 25) {
            let near = built.iter().map(|&p| distance(&pose, p)).fold(f64::INFINITY, f64::min);
            assert!(near >= options.clearance - PIECE, "{near} mm on the way to path {k}");
            let low = above_plate(&pose);
            assert!(!options.plate || low >= room(way) - 1e-6, "{low} mm over the plate");
        }
    }
}

/// How far the rim of the tip and the lower edge of the block are over the plate.
fn above_plate(pose: &Pose) -> f64 {
    let sin = pose.direction.xy().norm();
    pose.tip.z - (0.5 * sin).max(10.0 * sin - 8.0 * pose.direction.z)
}

/// A hilly layer over the plate and two walls on it, lines at random places of it that lean at random.
#[test]
fn ways_keep_the_clearance_that_was_asked_for() {
    let options = TravelOptions::default();
    let (mut lifted, mut blocked, mut all) = (0, 0, 0);
    for seed in 0..5 {
        let mut rng = rng(seed);
        let mesh = rough(5, seed, 1.5, |_, _| false);
        let vertices: Vec<_> = mesh.vertices().iter().map(|p| Point3::new(6.0 * p.x, 6.0 * p.y, 3.0 + p.z)).collect();
        let ground = Layer::new(&vertices, mesh.triangles(), H);
        let height = rng.random_range(4.0..25.0);
        let wall = |x: f64| Layer::sheet([x, 4.0, 4.0], [0.0, 20.0, 0.0], [0.0, 0.0, height], 3, H);
        let layers = [ground, wall(10.0).and(&wall(20.0))];
        let mut line = |layer: u32, z: f64| {
            let x = [2.0, 5.0, 15.0, 25.0, 28.0][rng.random_range(0..5)];
            let tip = Point3::new(x, rng.random_range(2.0..28.0), z);
            let (lean, around) = (rng.random_range(0.0..0.7_f64), rng.random_range(0.0..2.0 * PI));
            let direction = Vector3::new(lean.sin() * around.cos(), lean.sin() * around.sin(), lean.cos());
            path(layer, &[(tip, direction), (tip + Vector3::y(), direction)])
        };
        let paths: Vec<ToolPath> = (0..12).map(|k| line(u32::from(k >= 4), if k >= 4 { 6.0 } else { 4.8 })).collect();
        let travels = travels_with(&layers, &paths, &options);
        is_sound(&layers, &paths, &travels, &options);
        lifted += travels.lifted;
        blocked += travels.blocked.len();
        all += paths.len() - 1;
        // The result is the same on any number of threads.
        for threads in [1, 4] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| travels_with(&layers, &paths, &options)), travels);
        }
    }
    // Over walls there are ways, but they lead higher than the lowest.
    assert!(lifted > all / 4 && blocked < all / 10, "{lifted} lifted and {blocked} blocked of {all}");
}

#[test]
fn over_level_ground_the_lowest_way_is_taken() {
    let ground = Layer::sheet([0.0, 0.0, 0.4], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 4, H);
    let line = |x: f64| path(0, &[5.0, 9.0].map(|y| (Point3::new(x, y, H), Vector3::z())));
    let joined = path(0, &[9.0, 12.0].map(|y| (Point3::new(30.0, y, H), Vector3::z())));
    let paths = [line(5.0), line(30.0), joined];
    let options = TravelOptions::default();
    let travels = travels_with(std::slice::from_ref(&ground), &paths, &options);
    let above = |x: f64, y: f64| Pose { tip: Point3::new(x, y, H + 2.0), direction: Vector3::z_axis() };
    assert_eq!(travels.ways, [vec![], vec![above(5.0, 9.0), above(30.0, 5.0)], vec![]]);
    assert_eq!((travels.lifted, travels.max_lift, travels.blocked.len()), (0, 2.0, 0));
    // And so it is deposited: down, print, up, across, down, print, print on.
    let plan = deposit_along(&paths, &travels.ways, &DepositionOptions::default()).unwrap();
    let kinds: Vec<MoveKind> = plan.moves.iter().map(|m| m.kind).collect();
    use MoveKind::{Prime, Print, Retract, Travel};
    assert_eq!(kinds, [Travel, Travel, Print, Retract, Travel, Travel, Travel, Prime, Print, Print]);
    assert!((plan.moves[4].tip.z - H - 2.0).abs() < 1e-12 && plan.moves[6].tip == paths[1].waypoints[0].position);
}

/// Over a dome from one side to the other: the nozzle turns on the way.
#[test]
fn a_dome_is_passed_in_an_arc() {
    let n = 12;
    let at = |i: u32, j: u32| i + (n + 1) * j;
    let cells = || (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let share = |k: u32| f64::from(k) / f64::from(n);
    let vertices: Vec<_> = cells()
        .map(|(i, j)| {
            let (a, b) = (PI * (share(i) - 0.5) * 0.98, PI * (share(j) - 0.5) * 0.98);
            Point3::new(20.0 * a.sin() * b.cos(), 20.0 * b.sin(), 1.0 + 20.0 * a.cos() * b.cos())
        })
        .collect();
    let inner = cells().filter(|&(i, j)| i < n && j < n);
    let triangles: Vec<_> = inner
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    let layers = [Layer::new(&vertices, &triangles, H)];
    // On both sides, 60 degrees from the top.
    let side = |sign: f64| {
        let direction = Vector3::new(sign * (PI / 3.0).sin(), 0.0, (PI / 3.0).cos());
        let tip = Point3::new(0.0, 0.0, 1.0) + direction * 20.5;
        path(0, &[(tip - Vector3::y(), direction), (tip, direction)])
    };
    let (paths, options) = ([side(-1.0), side(1.0)], TravelOptions::default());
    let travels = travels_with(&layers, &paths, &options);
    is_sound(&layers, &paths, &travels, &options);
    assert_eq!(travels.blocked, []);
    let length: f64 = travels.ways[1].windows(2).map(|pair| (pair[1].tip - pair[0].tip).norm()).sum();
    // The way around the dome is 43 mm.
    assert!(travels.ways[1].len() > 2 && length < 70.0, "{length}");
}

/// A shaft of 12 by 12 mm, 40 mm deep, with a line at its bottom.
fn shaft() -> [Layer; 2] {
    let wall = |corner: [f64; 3], along: [f64; 3]| Layer::sheet(corner, along, [0.0, 0.0, 40.0], 6, H);
    let walls = wall([0.0, 0.0, 0.0], [24.0, 0.0, 0.0])
        .and(&wall([0.0, 24.0, 0.0], [24.0, 0.0, 0.0]))
        .and(&wall([0.0, 0.0, 0.0], [0.0, 24.0, 0.0]))
        .and(&wall([24.0, 0.0, 0.0], [0.0, 24.0, 0.0]));
    [walls, Layer::sheet([0.0, 0.0, 0.4], [90.0, 0.0, 0.0], [0.0, 24.0, 0.0], 9, H)]
}

#[test]
fn what_no_way_frees_is_listed() {
    let upright = |x: f64| path(1, &[11.5, 12.5].map(|y| (Point3::new(x, y, 0.8), Vector3::z())));
    let paths = [upright(12.0), upright(70.0)];
    let free = TravelOptions::default();
    let travels = travels_with(&shaft(), &paths, &free);
    is_sound(&shaft(), &paths, &travels, &free);
    let highest = travels.ways[1].iter().map(|pose| pose.tip.z).fold(0.0, f64::max);
    assert!(travels.blocked.is_empty() && highest > 41.0 && travels.max_lift > 30.0);
    // Not high enough to leave the shaft: blocked by its wall.
    let low = TravelOptions { max_lift: 20.0, ..free };
    let travels = travels_with(&shaft(), &paths, &low);
    let [BlockedTravel { path: 1, obstacle: Obstacle::Layer(0), tip }] = travels.blocked[..] else {
        panic!("{:?}", travels.blocked);
    };
    // The block, 10 mm wide to each side, 1 mm before the wall.
    assert!(tip.x > 12.0 && tip.x < 13.5, "{tip}");
    let lowest = [12.0, 70.0].map(|x| Point3::new(x, if x > 50.0 { 11.5 } else { 12.5 }, 2.8));
    assert_eq!(travels.ways[1].iter().map(|pose| pose.tip).collect::<Vec<_>>(), lowest);
    // No clearance at all, wherever it goes: the block has 2 mm to each side.
    let wide = TravelOptions { clearance: 2.5, ..free };
    let travels = travels_with(&shaft(), &paths, &wide);
    assert_eq!(travels.blocked.len(), 0, "backing off alone needs no clearance");
}

#[test]
fn the_plate_is_kept_clear() {
    let ground = Layer::sheet([0.0, 0.0, 0.4], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 4, H);
    let leaning = |x: f64, lean: f64| {
        let direction = Vector3::new(lean.sin(), 0.0, lean.cos());
        path(0, &[5.0, 9.0].map(|y| (Point3::new(x, y, 30.0), direction)))
    };
    // Straight would be clear but for the block, which reaches below the plate half way.
    let options = TravelOptions { clearance: 2.0, ..TravelOptions::default() };
    let mut paths = [leaning(20.0, 1.2), leaning(25.0, 1.2)];
    let layers = [ground];
    let travels = travels_with(&layers, &paths, &options);
    is_sound(&layers, &paths, &travels, &options);
    paths.iter_mut().flat_map(|path| &mut path.waypoints).for_each(|w| w.position.z = 4.0);
    let travels = travels_with(&layers, &paths, &options);
    is_sound(&layers, &paths, &travels, &options);
    assert!(travels.blocked.is_empty() && travels.lifted == 1);
    // Upside down there is no way out.
    paths.iter_mut().flat_map(|path| &mut path.waypoints).for_each(|w| w.axis = -Vector3::z_axis());
    let blocked = travels_with(&layers, &paths, &options).blocked;
    assert!(matches!(blocked[..], [BlockedTravel { path: 1, .. }]), "{blocked:?}");
}

#[test]
fn a_nozzle_that_lies_flat_over_the_plate_gets_away_from_it() {
    let layers = [Layer::sheet([15.0, 7.0, 0.4], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], 4, H)];
    let lying = |x: f64, direction: [f64; 3]| {
        path(0, &[5.0, 9.0].map(|y| (Point3::new(x, y, 10.02), Vector3::from(direction))))
    };
    // Its block has 0.02 to 0.1 mm left there; however far it backs off, it gets no millimetre.
    let flat = [[-1.0, 0.0, 0.0], [-0.8, 0.6, 0.0], [0.0, 1.0, 0.01]];
    let options = TravelOptions::default();
    let at_ends =
        |way: &[Pose]| [way[0], way[way.len() - 1]].map(|pose| above_plate(&pose)).into_iter().fold(1.0, f64::min);
    for end in flat.into_iter().chain([[-0.5, 0.0, 0.8], [0.0, 0.0, 1.0]]) {
        for paths in flat.map(|start| [lying(10.0, start), lying(25.0, end)]) {
            let there = travels_with(&layers, &paths, &options);
            is_sound_with(&layers, &paths, &there, &options, at_ends);
            assert_eq!(there.blocked, []);
        }
    }
    // One that leans backs off until it has its millimetre: it has 0.1 mm, and 0.9 at the least lift.
    let leaning = Vector3::new(-0.84_f64.sqrt(), 0.0, 0.4);
    let paths = [10.0, 25.0].map(|x| path(0, &[5.0, 9.0].map(|y| (Point3::new(x, y, 6.065), leaning))));
    let there = travels_with(&layers, &paths, &options);
    is_sound(&layers, &paths, &there, &options);
    assert!(there.blocked.is_empty() && there.max_lift > options.min_lift);
    // Half a millimetre lower it is in the plate, and stays there.
    let mut paths = [lying(10.0, flat[0]), lying(25.0, flat[1])];
    paths[0].waypoints.iter_mut().for_each(|w| w.position.z = 9.5);
    let blocked = travels_with(&layers, &paths, &options).blocked;
    assert!(matches!(blocked[..], [BlockedTravel { path: 1, obstacle: Obstacle::Plate, .. }]), "{blocked:?}");
}

#[test]
fn opposite_directions_turn_upright_first() {
    let layers = [Layer::sheet([0.0, 0.0, 0.4], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 4, H)];
    let side =
        |x: f64, sign: f64| path(0, &[5.0, 9.0].map(|y| (Point3::new(x, y, 30.0), Vector3::new(sign, 0.0, 0.0))));
    let (paths, options) = ([side(10.0, -1.0), side(30.0, 1.0)], TravelOptions::default());
    let travels = travels_with(&layers, &paths, &options);
    is_sound(&layers, &paths, &travels, &options);
    assert!(travels.blocked.is_empty() && travels.ways[1].len() > 2);
}

#[test]
fn moved_layers_have_moved_ways() {
    let by = Isometry3::new(Vector3::new(3.0, -7.0, 0.0), Vector3::z() * 0.7);
    let options = TravelOptions { max_lift: 60.0, ..TravelOptions::default() };
    let upright = |x: f64| path(1, &[11.5, 12.5].map(|y| (Point3::new(x, y, 0.8), Vector3::z())));
    let paths = [upright(12.0), upright(70.0)];
    let mut moved = paths.clone();
    moved.iter_mut().flat_map(|path| &mut path.waypoints).for_each(|w| w.position = by * w.position);
    let ways = travels_with(&shaft(), &paths, &options).ways;
    let other = travels_with(&shaft().map(|layer| layer.moved(&by)), &moved, &options).ways;
    for (a, b) in ways.iter().flatten().zip(other.iter().flatten()) {
        assert!((by * a.tip - b.tip).norm() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn options_and_paths_that_cannot_be_used_are_named() {
    let layers = [Layer::sheet([0.0, 0.0, 0.4], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], 1, H)];
    let good = path(0, &[1.0, 2.0].map(|x| (Point3::new(x, 5.0, H), Vector3::z())));
    let default = TravelOptions::default();
    let tried = |paths: &[ToolPath], options: &TravelOptions| {
        with_stack(&layers, |stack| stack.travels(paths, &tip_1_mm(), options, &go_on))
    };
    for (name, options) in [
        ("clearance", TravelOptions { clearance: 0.0, ..default }),
        ("clearance", TravelOptions { clearance: f64::NAN, ..default }),
        ("min_lift", TravelOptions { min_lift: -1.0, ..default }),
        ("max_lift", TravelOptions { max_lift: f64::INFINITY, ..default }),
        ("max_lift", TravelOptions { max_lift: 1.0, ..default }),
    ] {
        let error = tried(std::slice::from_ref(&good), &options).unwrap_err();
        assert!(matches!(error, GougingError::Option { option, .. } if option == name), "{error}");
    }
    let wrong = path(3, &[1.0, 2.0].map(|x| (Point3::new(x, 5.0, H), Vector3::z())));
    assert_eq!(tried(&[wrong], &default), Err(GougingError::Layer { path: 0, layer: 3, layers: 1 }));
    let mut bad = good.clone();
    bad.waypoints[1].position.x = f64::NAN;
    assert_eq!(tried(&[good.clone(), bad], &default), Err(GougingError::BadWaypoint { path: 1, waypoint: 1 }));
    let stop = |_| ControlFlow::Break(());
    let cancelled =
        with_stack(&layers, |stack| stack.travels(std::slice::from_ref(&good), &tip_1_mm(), &default, &stop));
    assert_eq!(cancelled, Err(GougingError::Cancelled));
    assert!(tried(&[], &default).unwrap().ways.is_empty());

    let options = DepositionOptions::default();
    let error = DepositionError::WayCount { ways: 0, paths: 1 };
    assert_eq!(deposit_along(std::slice::from_ref(&good), &[], &options), Err(error));
    let pose = Pose { tip: Point3::new(0.0, f64::NAN, 0.0), direction: Vector3::z_axis() };
    let error = DepositionError::BadPose { path: 0, pose: 0 };
    assert_eq!(deposit_along(&[good], &[vec![pose]], &options), Err(error));
}
