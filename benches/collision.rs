//! The collision scene: a UR3 with an extruder over a part of 20,000 triangles on a desk, at 500 random postures, and at 500
//! working ones, the nozzle a third of a millimetre from the part.
//!
//! * `boolean`: whether anything touches. The baseline asks parry, pair by pair of bodies, for the same pairs: its mesh
//!   has parry's own tree, its hulls parry's polyhedra.
//! * `distance`: the nearest two bodies, with points. Baseline: the same with parry's closest points.
//! * `sweep`: whether a motion of a few degrees is free, as a proof. Baseline: 50 boolean checks along it, no proof.
//! * `sweep_cubic`: the same of a piece of a cubic spline of that length, which bulges. Baseline: straight sweeps of the same
//!   curve cut into 32 pieces, which prove the chords, not the curve.
//! * `layer`: the part grows by a layer of cells. Baseline: a new scene.
//!
//! Answers are compared before they are timed.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::time_questions;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use curvlay_kinematics::scene::{
    Body, Mount, Posture, Scene, SceneModel, Shape, Sweep, cubic_control, estimated_links,
};
use curvlay_kinematics::{Arm, robots};
use parry3d_f64::math::{Pose, Rot3, Vector};
use parry3d_f64::query::{self, ClosestPoints};
use parry3d_f64::shape::{Capsule, ConvexPolyhedron, SharedShape, TriMesh};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

const POSTURES: usize = 500;
/// Around and along the part; twice their product is the number of triangles.
const AROUND: u32 = 200;
const ALONG: u32 = 50;
/// Where the part stands, how far the nozzle reaches beyond the flange, and how near to the part it works, in millimetres.
const STANDS: [f64; 3] = [-280.0, -110.0, 0.5];
const TIP: f64 = 94.0;
const WORKS: f64 = 0.3;

/// A fluted vase, 120 mm high.
fn vase() -> Shape {
    let point = |k: u32| {
        let (turn, up) = (TAU * f64::from(k % AROUND) / f64::from(AROUND), f64::from(k / AROUND) / f64::from(ALONG));
        let radius = 40.0 + 8.0 * (9.0 * turn + 2.0 * up).cos() + 12.0 * (PI * up).sin();
        Point3::new(radius * turn.cos(), radius * turn.sin(), 120.0 * up)
    };
    let corner = |around: u32, along: u32| around % AROUND + AROUND * along;
    let quad = |k: u32| {
        let (i, j) = (k % AROUND, k / AROUND);
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..AROUND * ALONG).flat_map(quad).collect();
    Shape::Mesh { points: (0..AROUND * (ALONG + 1)).map(point).collect(), triangles }
}

fn bodies(part: Shape) -> Vec<Body> {
    let at = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
    let nozzle = Shape::Capsule { from: Point3::new(0.0, 0.0, 4.0), to: Point3::new(0.0, 0.0, TIP - 4.0), radius: 4.0 };
    let extruder = Shape::block(Point3::new(-25.0, -30.0, 0.0), Point3::new(25.0, 30.0, 50.0));
    let desk = Shape::block(Point3::new(-600.0, -600.0, -30.0), Point3::new(600.0, 600.0, 0.0));
    vec![
        at("nozzle", Mount::Link(6), Isometry3::identity(), nozzle),
        at("extruder", Mount::Link(6), Isometry3::identity(), extruder),
        at("desk", Mount::Base, Isometry3::identity(), desk),
        at("part", Mount::Base, Isometry3::from(STANDS), part),
    ]
}

fn scene(part: Shape) -> Scene {
    let arm = Arm::new(&robots::UR3).expect("published numbers");
    let model = SceneModel { links: estimated_links(&robots::UR3), bodies: bodies(part), ..SceneModel::of(arm) };
    Scene::new(model).expect("a sound scene")
}

/// The same bodies and pairs for parry alone.
struct Baseline {
    arm: Arm,
    bodies: Vec<(Mount, Pose, SharedShape)>,
    pairs: Vec<[usize; 2]>,
}

fn pose(iso: &Isometry3<f64>) -> Pose {
    let (t, q) = (iso.translation.vector, iso.rotation);
    Pose::from_parts(Vector::new(t.x, t.y, t.z), Rot3::from_xyzw(q.i, q.j, q.k, q.w))
}

impl Baseline {
    fn new(scene: &Scene) -> Self {
        let plain = |p: &Point3<f64>| Vector::new(p.x, p.y, p.z);
        let shape = |shape: &Shape| match shape {
            Shape::Capsule { from, to, radius } => SharedShape::new(Capsule::new(plain(from), plain(to), *radius)),
            Shape::Hull { points, .. } => {
                let points: Vec<Vector> = points.iter().map(plain).collect();
                SharedShape::new(ConvexPolyhedron::from_convex_hull(&points).expect("a hull"))
            }
            Shape::Mesh { points, triangles } => {
                SharedShape::new(TriMesh::new(points.iter().map(plain).collect(), triangles.clone()).expect("a mesh"))
            }
            Shape::Cells { .. } | Shape::Union(_) => unreachable!("parry is asked about triangles here"),
        };
        let all: Vec<Body> = estimated_links(&robots::UR3).into_iter().chain(bodies(vase())).collect();
        let index = |name: &str| all.iter().position(|body| body.name == name).expect("a body");
        Baseline {
            arm: Arm::new(&robots::UR3).expect("published numbers"),
            pairs: scene.pairs().map(|pair| pair.map(index)).collect(),
            bodies: all.iter().map(|body| (body.mount, pose(&body.mount_body), shape(&body.shape))).collect(),
        }
    }

    fn poses(&self, posture: &Posture) -> Vec<Pose> {
        let frames = self.arm.frames(&posture.joints).map(|frame| pose(&frame));
        let place = |mount: &Mount| if let Mount::Link(link) = mount { frames[*link] } else { frames[0] };
        self.bodies.iter().map(|(mount, body, _)| place(mount) * *body).collect()
    }

    fn touching(&self, posture: &Posture) -> bool {
        let poses = self.poses(posture);
        self.pairs.iter().any(|&[a, b]| {
            let (first, second) = (&*self.bodies[a].2, &*self.bodies[b].2);
            query::intersection_test(&poses[a], first, &poses[b], second).expect("known shapes").intersecting
        })
    }

    fn distance(&self, posture: &Posture) -> f64 {
        let poses = self.poses(posture);
        let mut least = f64::INFINITY;
        for &[a, b] in &self.pairs {
            let (first, second) = (&*self.bodies[a].2, &*self.bodies[b].2);
            match query::closest_points(&poses[a], first, &poses[b], second, least).expect("known shapes") {
                ClosestPoints::Intersecting => return 0.0,
                ClosestPoints::WithinMargin(p, q) => least = least.min((q - p).length()),
                ClosestPoints::Disjoint => {}
            }
        }
        least
    }
}

/// Postures with the flange over the desk, as a printing arm has them.
fn postures() -> Vec<Posture> {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let arm = Arm::new(&robots::UR3).expect("published numbers");
    let mut found = vec![];
    while found.len() < POSTURES {
        let joints = [0; 6].map(|_| random.random_range(-PI..PI));
        let flange = arm.forward(&joints);
        let down = (flange.rotation * Vector3::z()).z < -0.5;
        if down && flange.translation.vector.z > 120.0 {
            found.push(joints.into());
        }
    }
    found
}

/// Postures with the nozzle's tip over a triangle of the part, along its normal, on any branch and at any turn.
fn working(part: &Shape) -> Vec<Posture> {
    let Shape::Mesh { points, triangles } = part else { return vec![] };
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let arm = Arm::new(&robots::UR3).expect("published numbers");
    let mut found: Vec<Posture> = vec![];
    while found.len() < POSTURES {
        let [a, b, c] = triangles[random.random_range(0..triangles.len())].map(|k| points[k as usize].coords);
        let normal = (b - a).cross(&(c - a)).normalize();
        let tip = (a + b + c) / 3.0 + Vector3::from(STANDS) + (TIP + WORKS) * normal;
        let side = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let flange = Isometry3::from_parts(tip.into(), UnitQuaternion::face_towards(&-normal, &side));
        let branches: Vec<_> = arm.inverse(&flange).expect("a pose").iter().map(|(_, joints)| *joints).collect();
        if !branches.is_empty() {
            found.push(branches[random.random_range(0..branches.len())].into());
        }
    }
    found
}

/// The two sides that are compared: the scene, and parry's own queries over the same bodies.
struct Sides {
    scene: Scene,
    baseline: Baseline,
}

impl Sides {
    fn touches(&self, posture: &Posture) -> bool {
        self.scene.touching(posture).expect("angles").is_some()
    }

    fn distance(&self, posture: &Posture) -> f64 {
        self.scene.nearest(posture).expect("angles").map_or(f64::INFINITY, |nearest| nearest.distance)
    }

    fn sweep(&self, posture: &Posture) -> bool {
        self.scene.sweep(posture, &step(posture), 0.5).expect("angles") == Sweep::Free
    }

    /// A short straight motion at 51 postures.
    fn sampled(&self, posture: &Posture) -> bool {
        let at = |k: usize| Posture { joints: posture.joints.map(|angle| angle + 0.001 * k as f64), ..*posture };
        (0..=50).all(|k| !self.touches(&at(k)))
    }

    fn sweep_cubic(&self, posture: &Posture) -> bool {
        self.scene.sweep_cubic(&cubic(posture), 0.5).expect("angles") == Sweep::Free
    }

    /// A cubic motion by 32 straight ones.
    fn chords(&self, posture: &Posture) -> bool {
        let control = cubic(posture);
        let knots: Vec<Posture> = (0..=32).map(|k| on_curve(&control, f64::from(k) / 32.0)).collect();
        knots.windows(2).all(|ends| self.scene.sweep(&ends[0], &ends[1], 0.5).expect("angles") == Sweep::Free)
    }

    /// A cubic motion at 201 postures.
    fn sampled_cubic(&self, posture: &Posture) -> bool {
        let control = cubic(posture);
        (0..=200).all(|k| !self.touches(&on_curve(&control, f64::from(k) / 200.0)))
    }

    /// The free ones of some postures, timed after the answers for all of them were compared.
    fn compared(&self, name: &str, all: Vec<Posture>) -> Vec<Posture> {
        let Sides { scene, baseline } = self;
        let mut differing = 0;
        for posture in &all {
            let (ours, theirs) = (self.distance(posture), baseline.distance(posture));
            let touches = self.touches(posture);
            assert_eq!(touches, ours <= 0.0);
            differing += usize::from((ours - theirs).abs() > 1e-5 || touches != baseline.touching(posture));
        }
        let free: Vec<Posture> = all.iter().filter(|posture| !self.touches(posture)).copied().collect();
        let pairs = scene.pairs().count();
        eprintln!(
            "{name}: {pairs} pairs; {} of {POSTURES} postures are free; answers differ at {differing}",
            free.len()
        );
        for (share, some) in [("all", &all), ("free", &free)] {
            time_each(&format!("boolean_{name}_{share}/scene"), some, |p| self.touches(p));
            time_each(&format!("boolean_{name}_{share}/baseline_parry"), some, |p| baseline.touching(p));
        }
        time_each(&format!("distance_{name}_free/scene"), &free, |p| self.distance(p));
        time_each(&format!("distance_{name}_free/baseline_parry"), &free, |p| baseline.distance(p));
        free
    }
}

/// Times a question about each of some postures.
fn time_each<T>(name: &str, postures: &[Posture], question: impl Fn(&Posture) -> T) {
    time_questions(name, postures.len(), || postures.iter().for_each(|p| _ = black_box(question(p))));
}

/// The end of a short motion.
fn step(posture: &Posture) -> Posture {
    Posture { joints: posture.joints.map(|angle| angle + 0.05), ..*posture }
}

/// A cubic motion to the same end: as fast as the straight one on average, faster at the start and slower at the end.
fn cubic(posture: &Posture) -> [Posture; 4] {
    let rate = |by: f64| [by, by, -by, by, -by, by].into();
    cubic_control(posture, &rate(0.15), &step(posture), &rate(0.02), 1.0)
}

/// A posture of a cubic motion.
fn on_curve([a, b, c, d]: &[Posture; 4], t: f64) -> Posture {
    let u = 1.0 - t;
    let weights = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
    let at = |k| [a, b, c, d].iter().zip(weights).map(|(point, weight)| point.joints[k] * weight).sum();
    Posture { joints: std::array::from_fn(at), ..*a }
}

fn bench(c: &mut Criterion) {
    let scene = scene(vase());
    let baseline = Baseline::new(&scene);
    let sides = Sides { scene, baseline };
    sides.compared("working", working(&vase()));
    let free = sides.compared("random", postures());
    let Sides { baseline, .. } = &sides;

    let mut group = c.benchmark_group("collision");
    group.sample_size(20).throughput(Throughput::Elements(free.len() as u64));
    let mut counted = |name: &str, says: &dyn Fn(&Posture) -> bool| {
        group.bench_function(name, |b| b.iter(|| free.iter().filter(|p| says(p)).count()));
    };
    counted("boolean", &|p| sides.touches(p));
    counted("boolean_baseline_parry", &|p| baseline.touching(p));

    // What is proven free has no sample that touches.
    assert!(free.iter().all(|p| !sides.sweep(p) || sides.sampled(p)));
    eprintln!("{} of {} short motions are free", free.iter().filter(|p| sides.sweep(p)).count(), free.len());
    time_each("sweep/scene", &free, |p| sides.sweep(p));
    time_each("sweep/baseline_50_samples", &free, |p| sides.sampled(p));

    assert!(free.iter().all(|p| !sides.sweep_cubic(p) || sides.sampled_cubic(p)));
    let count = |says: &dyn Fn(&Posture) -> bool| free.iter().filter(|p| says(p)).count();
    let [by_scene, by_chords] = [count(&|p| sides.sweep_cubic(p)), count(&|p| sides.chords(p))];
    eprintln!("cubics of {}: {by_scene} free, by their chords {by_chords}", free.len());
    time_each("sweep_cubic/scene", &free, |p| sides.sweep_cubic(p));
    time_each("sweep_cubic/baseline_32_chords", &free, |p| sides.chords(p));
    counted("sweep", &|p| sides.sweep(p));
    counted("sweep_baseline_50_samples", &|p| sides.sampled(p));
    counted("sweep_cubic", &|p| sides.sweep_cubic(p));
    counted("sweep_cubic_baseline_32_chords", &|p| sides.chords(p));
    group.bench_function("distance", |b| b.iter(|| free.iter().map(|p| sides.distance(p)).sum::<f64>()));
    group.bench_function("distance_baseline_parry", |b| {
        b.iter(|| free.iter().map(|p| baseline.distance(p)).sum::<f64>())
    });
    group.finish();
}

/// A disc of cells in a grid of 200 x 200 x 200: 31,000 cells a layer.
fn layer(z: usize) -> Vec<u64> {
    let mut rows = vec![0u64; 4 * 200 * 200];
    for (y, x) in (0..200).flat_map(|y| (0..200usize).map(move |x| (y, x))) {
        if (x as f64 - 99.5).hypot(y as f64 - 99.5) < 99.0 {
            rows[4 * (y + 200 * z) + x / 64] |= 1 << (x % 64);
        }
    }
    rows
}

fn growing(c: &mut Criterion) {
    let cells = |rows: Vec<u64>| Shape::Cells { dims: [200; 3], rows, cell: 0.6 };
    let mut built = vec![0u64; 4 * 200 * 200];
    let mut before = scene(cells(built.clone()));
    for z in 0..100 {
        let next = layer(z);
        built.iter_mut().zip(&next).for_each(|(all, new)| *all |= new);
        before.add_cells("part", &next).expect("rows of the grid");
    }
    let next = layer(100);
    built.iter_mut().zip(&next).for_each(|(all, new)| *all |= new);
    let mut after = before.clone();
    after.add_cells("part", &next).expect("rows of the grid");
    let anew = scene(cells(built.clone()));
    for posture in postures() {
        assert_eq!(after.touching(&posture), anew.touching(&posture));
    }
    let all = postures();
    let touches = |posture: &Posture| anew.touching(posture).expect("angles").is_some();
    let free: Vec<Posture> = all.iter().filter(|posture| !touches(posture)).copied().collect();
    time_questions("boolean_free_3M_cells/scene", free.len(), || free.iter().for_each(|p| _ = black_box(touches(p))));
    let mut group = c.benchmark_group("layer");
    group.sample_size(10);
    group.bench_function("add_cells", |b| {
        b.iter_batched_ref(
            || before.clone(),
            |scene| scene.add_cells("part", black_box(&next)),
            criterion::BatchSize::LargeInput,
        )
    });
    group.bench_function("baseline_new_scene", |b| b.iter(|| scene(cells(black_box(&built).clone()))));
    group.finish();
}

criterion_group!(benches, bench, growing);
criterion_main!(benches);
