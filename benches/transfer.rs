//! Transfers of a UR5 with an extruder in a cluttered cell: a part of cells with towers, a post, a beam overhead, a shelf.
//!
//! * `transfer`: RRT-Connect by postures, shortened and timed, each line of the way proven free by a sweep of the scene.
//! * `baseline_rrt`: one tree from the start, a twentieth of its random postures being the goal (S. LaValle,
//!   *Rapidly-exploring random trees*, 1998), with the same edges and checks, neither shortened nor timed.
//!
//! The pairs are those between which no straight line is free.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, criterion_group, criterion_main};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, estimated_links};
use curvlay_kinematics::{Arm, robots};
use curvlay_trajectory::Bounds;
use curvlay_trajectory::transfer::{FreeSpace, Planned, TransferOptions, plan_transfer};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const PAIRS: usize = 60;
/// What a sweep may take away from the room, in millimetres.
const RESOLUTION: f64 = 3.0;

/// Three towers of cells on a plate of 240 x 240 mm.
fn part() -> Shape {
    let mut rows = vec![0u64; 2 * 80 * 60];
    for (z, y, x) in (0..60).flat_map(|z| (0..80).flat_map(move |y| (0..80usize).map(move |x| (z, y, x)))) {
        let in_tower = |cx: i32, cy: i32, side: i32, high: usize| {
            (x as i32 - cx).abs() < side && (y as i32 - cy).abs() < side && z < high
        };
        if z < 4 || in_tower(15, 20, 8, 60) || in_tower(60, 20, 10, 45) || in_tower(40, 62, 9, 55) {
            rows[2 * (y + 80 * z) + x / 64] |= 1 << (x % 64);
        }
    }
    Shape::Cells { dims: [80, 80, 60], rows, cell: 3.0 }
}

fn scene() -> Scene {
    let at = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
    let p = Point3::new;
    let rod = |from, to, radius| Shape::Capsule { from, to, radius };
    let base = |name: &str, shape| at(name, Mount::Base, Isometry3::identity(), shape);
    let bodies = vec![
        at("nozzle", Mount::Link(6), Isometry3::identity(), rod(p(0.0, 0.0, 40.0), p(0.0, 0.0, 120.0), 4.0)),
        at("extruder", Mount::Link(6), Isometry3::identity(), Shape::block(p(-30.0, -35.0, 0.0), p(30.0, 35.0, 60.0))),
        base("desk", Shape::block(p(-1100.0, -1100.0, -40.0), p(1100.0, 1100.0, -1.0))),
        at("part", Mount::Base, Isometry3::translation(-600.0, -120.0, 0.0), part()),
        base("post", rod(p(-450.0, 320.0, 0.0), p(-450.0, 320.0, 900.0), 35.0)),
        base("beam", rod(p(-700.0, 420.0, 620.0), p(-300.0, -420.0, 620.0), 30.0)),
        base("shelf", Shape::block(p(100.0, 350.0, 300.0), p(600.0, 600.0, 320.0))),
    ];
    let arm = Arm::new(&robots::UR5).expect("published numbers");
    Scene::new(SceneModel { bodies, links: estimated_links(&robots::UR5), ..SceneModel::of(arm) })
        .expect("a sound scene")
}

/// Checks asked for, of motions and of postures: a cost that no other load on the machine changes.
static CHECKS: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

fn print_checks(whose: &str) {
    let [motions, postures] = [0, 1].map(|k| CHECKS[k].swap(0, Ordering::Relaxed) / PAIRS);
    eprintln!("{whose}: {motions} motions and {postures} postures checked a pair");
}

/// The scene as the planner sees it.
struct Cell(Scene);

impl FreeSpace<6> for Cell {
    fn free(&self, from: &[f64; 6], to: &[f64; 6]) -> bool {
        CHECKS[0].fetch_add(1, Ordering::Relaxed);
        self.0.is_free(&(*from).into(), &(*to).into(), RESOLUTION).expect("angles")
    }

    fn posture_free(&self, joints: &[f64; 6]) -> bool {
        CHECKS[1].fetch_add(1, Ordering::Relaxed);
        self.0.touching(&(*joints).into()).expect("angles").is_none()
    }
}

/// Free postures with the nozzle's tip low over the part and around it, pointing down.
fn ends(cell: &Cell) -> Vec<([f64; 6], [f64; 6])> {
    let mut random = Pcg64Mcg::seed_from_u64(17);
    let arm = Arm::new(&robots::UR5).expect("published numbers");
    let mut posture = || loop {
        let x = random.random_range(-640.0..-320.0);
        let tip = Isometry3::translation(x, random.random_range(-160.0..160.0), random.random_range(20.0..240.0));
        let tilt = Vector3::new(PI + random.random_range(-0.4..0.4), random.random_range(-0.4..0.4), 0.0);
        let turn = Isometry3::rotation(Vector3::z() * random.random_range(-PI..PI));
        let base_flange = tip * Isometry3::rotation(tilt) * turn * Isometry3::translation(0.0, 0.0, -120.0);
        let all: Vec<[f64; 6]> = arm.inverse(&base_flange).expect("a pose").iter().map(|(_, joints)| *joints).collect();
        if all.is_empty() {
            continue;
        }
        let joints = all[random.random_range(0..all.len())];
        if cell.posture_free(&joints) {
            break joints;
        }
    };
    let mut pairs = vec![];
    while pairs.len() < PAIRS {
        let (from, to) = (posture(), posture());
        if !cell.free(&from, &to) {
            pairs.push((from, to));
        }
    }
    pairs
}

fn bounds() -> Bounds<6> {
    Bounds { lower: [-2.0 * PI; 6], upper: [2.0 * PI; 6], velocity: [PI; 6], acceleration: [8.0; 6], jerk: [80.0; 6] }
}

fn ours(cell: &Cell, (from, to): &([f64; 6], [f64; 6]), shortcuts: usize) -> Planned<6> {
    let options = TransferOptions { shortcuts, iterations: 5000, ..TransferOptions::default() };
    plan_transfer("", from, to, &bounds(), cell, &options).expect("sound ends and bounds")
}

/// One tree; the number of its postures when the goal was reached.
fn plain_rrt(cell: &Cell, (from, to): &([f64; 6], [f64; 6])) -> Option<usize> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let options = TransferOptions::default();
    let mut nodes = vec![*from];
    for _ in 0..options.iterations {
        let drawn: [f64; 6] = if random.random_range(0.0..1.0) < 0.05 {
            *to
        } else {
            std::array::from_fn(|j| {
                random.random_range(from[j].min(to[j]) - options.reach..from[j].max(to[j]) + options.reach)
            })
        };
        let square = |q: &[f64; 6]| q.iter().zip(&drawn).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let near = *nodes.iter().min_by(|a, b| square(a).total_cmp(&square(b)))?;
        let share = (options.step / square(&near).sqrt()).min(1.0);
        let next: [f64; 6] = std::array::from_fn(|j| near[j] + (drawn[j] - near[j]) * share);
        if cell.free(&near, &next) {
            nodes.push(next);
            let left = next.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            if left < options.step && cell.free(&next, to) {
                return Some(nodes.len());
            }
        }
    }
    None
}

fn times<T>(pairs: &[([f64; 6], [f64; 6])], mut run: impl FnMut(&([f64; 6], [f64; 6])) -> T) -> (Vec<f64>, Vec<T>) {
    let timed = |pair| {
        let start = Instant::now();
        let result = run(pair);
        (start.elapsed().as_secs_f64(), result)
    };
    let (mut times, results): (Vec<f64>, Vec<T>) = pairs.iter().map(timed).unzip();
    times.sort_by(f64::total_cmp);
    (times, results)
}

fn bench(c: &mut Criterion) {
    let cell = Cell(scene());
    let pairs = ends(&cell);
    for shortcuts in [0, TransferOptions::default().shortcuts] {
        let (times, results) = times(&pairs, |pair| ours(&cell, pair, shortcuts));
        print_checks("transfer");
        let found: Vec<_> = results.into_iter().filter_map(Planned::found).collect();
        for transfer in &found {
            assert!(transfer.corners().windows(2).all(|line| cell.free(&line[0], &line[1])));
        }
        let mut seconds: Vec<f64> = found.iter().map(|transfer| transfer.duration()).collect();
        seconds.sort_by(f64::total_cmp);
        eprintln!(
            "transfer, {shortcuts} shortcuts: median {:.1} ms, nine of ten {:.1} ms; {} of {PAIRS} found; robot time {:.2} s",
            1e3 * times[PAIRS / 2],
            1e3 * times[PAIRS * 9 / 10],
            found.len(),
            seconds.get(seconds.len() / 2).copied().unwrap_or(f64::NAN),
        );
    }
    print_checks("proofs and ends");
    let (times, results) = times(&pairs, |pair| plain_rrt(&cell, pair));
    print_checks("baseline");
    let (median, most) = (1e3 * times[PAIRS / 2], 1e3 * times[PAIRS * 9 / 10]);
    let found = results.iter().flatten().count();
    eprintln!("baseline_rrt: median {median:.1} ms, nine of ten {most:.1} ms; {found} of {PAIRS} found");

    let mut group = c.benchmark_group("transfer");
    group.sample_size(10);
    let shortcuts = TransferOptions::default().shortcuts;
    group.bench_function("ten_pairs", |b| {
        b.iter(|| pairs[..10].iter().filter_map(|p| ours(&cell, p, shortcuts).found()).count())
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
