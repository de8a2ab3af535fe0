//! How a part should lie: closed forms, slow twins of resting poses and of support columns, ranking, and bad input.
#![allow(clippy::float_cmp, reason = "counts of cells times whole powers of two are exact")]

use crate::common::{go, random_rows};
use curvlay_layers::Progress;
use curvlay_layers::cells::{Cells, CellsError};
use curvlay_layers::curved::orient::{
    JudgedPose, OrientOptions, Pose, PoseCells, PoseError, PoseKind, judge_poses, poses,
};
use curvlay_layers::curved::{self, GrowthError, Platform, PlatformError, Rules};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use proptest::prelude::*;
use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// The surface of boxes `[low, high]`, each closed by itself.
fn boxes(all: &[[[f64; 3]; 2]]) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for bounds in all {
        let first = vertices.len() as u32;
        vertices.extend(
            (0..8usize).map(|k| Point3::from([0, 1, 2].map(|axis| bounds[usize::from(k >> axis & 1 == 1)][axis]))),
        );
        #[rustfmt::skip]
        let faces = [
            [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
            [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
        ];
        triangles.extend(faces.map(|corners: [u32; 3]| corners.map(|corner| first + corner)));
    }
    (vertices, triangles)
}

/// A ball of radius 10 mm, `rings` rings of facets from pole to pole.
fn ball(rings: u32) -> Mesh {
    let around = 2 * rings;
    let at = |ring: u32, k: u32| {
        let (polar, angle) = (PI * f64::from(ring) / f64::from(rings), 2.0 * PI * f64::from(k) / f64::from(around));
        Point3::from(10.0 * Vector3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()))
    };
    let mut vertices = vec![at(0, 0), at(rings, 0)];
    (1..rings).for_each(|ring| vertices.extend((0..around).map(|k| at(ring, k))));
    let id = |ring: u32, k: u32| match ring {
        0 => 0,
        ring if ring == rings => 1,
        ring => 2 + (ring - 1) * around + k % around,
    };
    let quad = |(ring, k): (u32, u32)| {
        let [a, b, c, d] = [id(ring, k), id(ring + 1, k), id(ring + 1, k + 1), id(ring, k + 1)];
        [[a, b, c], [a, c, d]]
    };
    let all = (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))).flat_map(quad);
    (vertices, all.filter(|[a, b, c]| a != b && b != c && a != c).collect())
}

/// Cells that the part reaches into along one of 25 lines through each column, filled between every other passing of the surface.
fn cells_of(triangles: &[[u32; 3]], cell_mm: f64, laid: &[Point3<f64>]) -> Result<PoseCells, Infallible> {
    let (low, high) = laid.iter().fold((laid[0], laid[0]), |(low, high), at| (low.inf(at), high.sup(at)));
    let dims = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / cell_mm - 1e-6).ceil().max(1.0) as u32);
    assert!(dims[0] <= 64, "one word a row");
    let mut rows = vec![0u64; (dims[1] * dims[2]) as usize];
    for (y, x) in (0..5 * dims[1]).flat_map(|y| (0..5 * dims[0]).map(move |x| (y, x))) {
        // Off the middle by so little that no edge is met.
        let at =
            |index: u32, axis: usize| low[axis] + (f64::from(index) + 0.5 + 1.3e-4 * (axis + 1) as f64) * cell_mm / 5.0;
        let (px, py) = (at(x, 0), at(y, 1));
        let mut passings: Vec<(f64, i32)> = Vec::new();
        for corners in triangles {
            let [a, b, c] = corners.map(|k| laid[k as usize]);
            let side = |u: Point3<f64>, v: Point3<f64>| (v.x - u.x) * (py - u.y) - (v.y - u.y) * (px - u.x);
            let weights = [side(b, c), side(c, a), side(a, b)];
            let is_out = weights.iter().all(|&w| w > 0.0);
            if is_out || weights.iter().all(|&w| w < 0.0) {
                let z = (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) / weights.iter().sum::<f64>();
                passings.push((z, if is_out { -1 } else { 1 }));
            }
        }
        passings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for pair in passings.windows(2) {
            winding += pair[0].1;
            if winding > 0 {
                let [from, to] = [pair[0].0 / cell_mm + 1e-6, pair[1].0 / cell_mm - 1e-6];
                (from.max(0.0) as u32..to.max(0.0).ceil() as u32)
                    .for_each(|z| rows[(y / 5 + dims[1] * z) as usize] |= 1 << (x / 5));
            }
        }
    }
    Ok(PoseCells { dims, rows, cell_mm })
}

fn options(directions: u32) -> OrientOptions {
    OrientOptions { directions, ..OrientOptions::default() }
}

fn resting(mesh: &Mesh, options: &OrientOptions) -> Vec<Pose> {
    let all = poses(&mesh.0, &mesh.1, options).unwrap();
    all.into_iter().filter(|pose| pose.kind == PoseKind::Resting).collect()
}

fn judged(mesh: &Mesh, options: &OrientOptions, cell_mm: f64) -> Vec<JudgedPose> {
    let found = poses(&mesh.0, &mesh.1, options).unwrap();
    judge_poses(&mesh.0, &found, options, &|laid| cells_of(&mesh.1, cell_mm, laid), &go).unwrap()
}

#[test]
fn a_cube_stands_on_each_of_its_faces() {
    let cube = boxes(&[[[3.0, -4.0, 7.0], [7.0, 0.0, 11.0]]]);
    let all = resting(&cube, &options(0));
    assert_eq!(all.len(), 6);
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for up in [axis, -axis] {
            let pose = all.iter().find(|pose| (pose.up.into_inner() - up).norm() < 1e-9).unwrap();
            assert!((pose.tipping - FRAC_PI_4).abs() < 1e-4, "{pose:?}");
        }
    }
    // All alike, so the order of the poses decides: the given one.
    let judged = judged(&cube, &options(0), 1.0);
    assert_eq!((judged[0].pose.kind, judged[0].number), (PoseKind::Given, 0));
    for pose in judged {
        assert_eq!((pose.cells, pose.layers, pose.missed_cells), (64, 4, 0));
        assert_eq!((pose.height_mm, pose.base_mm2, pose.support_mm3, pose.stands), (4.0, 16.0, 0.0, true));
    }
}

#[test]
fn a_block_is_the_firmer_the_flatter_it_lies() {
    let block = boxes(&[[[0.0; 3], [2.0, 6.0, 4.0]]]);
    let all = resting(&block, &options(0));
    // Half the shorter side of the face over half the height.
    let angles = [(4.0, 2.0), (2.0, 4.0), (2.0, 6.0)].map(|(side, height): (f64, f64)| (side / height).atan());
    for (pair, angle) in all.chunks(2).zip(angles) {
        assert!(pair.iter().all(|pose| (pose.tipping - angle).abs() < 1e-4), "{pair:?}");
    }
    assert_eq!(all.len(), 6);
    // 18.4 degrees for the ends: a limit above leaves them out.
    assert_eq!(resting(&block, &OrientOptions { min_tipping: 0.33, ..options(0) }).len(), 4);
}

#[test]
fn a_ball_stands_nowhere_and_is_the_same_in_all_poses() {
    let ball = ball(48);
    let options = options(12);
    assert!(resting(&ball, &options).is_empty());
    let judged = judged(&ball, &options, 2.0);
    assert_eq!(judged.len(), 13);
    for pose in &judged {
        assert!(!pose.stands && pose.missed_cells == 0 && pose.pose.tipping < 5f64.to_radians(), "{pose:?}");
        assert!((9..=11).contains(&pose.layers) && (18.0..=20.0).contains(&pose.height_mm), "{pose:?}");
    }
}

/// Upright the bar stands over a thin stem; upside down it is the foot; on its side all of it is one slab.
#[test]
fn a_tee_lies_on_its_side() {
    let tee = boxes(&[[[0.0, 0.0, 8.0], [12.0, 2.0, 10.0]], [[5.0, 0.0, 0.0], [7.0, 2.0, 8.0]]]);
    let judged = judged(&tee, &options(20), 1.0);
    let place =
        |up: Vector3<f64>| judged.iter().position(|pose| (pose.pose.up.into_inner() - up).norm() < 1e-6).unwrap();
    let (upright, over) = (place(Vector3::z()), place(-Vector3::z()));
    assert!(judged[0].pose.up.y.abs() > 1.0 - 1e-6 && judged[0].layers == 2 && judged[0].stands);
    assert!(over < upright);
    assert!(judged[over].pose.tipping > judged[upright].pose.tipping && judged[upright].pose.kind == PoseKind::Given);
    assert_eq!(judged[over].layers, 10);
    assert_eq!((judged[upright].base_mm2, judged[over].base_mm2), (4.0, 24.0));
}

/// A hook: an arm from a column with a leg that hangs down and ends above the plate. Upside down the leg stands up.
#[test]
fn a_hook_is_turned_over() {
    let hook = boxes(&[
        [[0.0, 0.0, 0.0], [3.0, 3.0, 12.0]],
        [[3.0, 0.0, 9.0], [12.0, 3.0, 12.0]],
        [[9.0, 0.0, 3.0], [12.0, 3.0, 9.0]],
    ]);
    let judged = judged(&hook, &options(0), 1.0);
    let find = |kind: PoseKind| judged.iter().find(|pose| pose.pose.kind == kind).unwrap();
    let (given, best) = (find(PoseKind::Given), &judged[0]);
    assert_eq!(best.missed_cells, 0);
    assert!(given.missed_cells > 10, "{given:?}");
    // The columns below the leg: 3 x 3 x 3 cells, if its lowest cells are missed.
    assert_eq!(given.support_mm3, 27.0);
    assert_eq!(given.missed_mm3, given.missed_cells as f64);
    assert!(given.missed_share() * given.cells as f64 - given.missed_cells as f64 <= 1e-9);
}

/// Faces of the hull of a few points, by looking at all planes through three of them; each with its outward normal, and
/// how firmly the hull of them stands on it.
fn slow_resting(points: &[Point3<f64>], centre: Point3<f64>) -> Vec<(Vector3<f64>, f64)> {
    let mut found: Vec<(Vector3<f64>, f64)> = Vec::new();
    for a in points {
        for b in points {
            for c in points {
                let normal = (b - a).cross(&(c - a));
                if normal.norm() < 1e-9 {
                    continue;
                }
                let normal = normal.normalize();
                let height = |p: &Point3<f64>| (p - a).dot(&normal);
                if points.iter().any(|p| height(p) > 1e-9)
                    || found.iter().any(|(other, _)| (other - normal).norm() < 1e-9)
                {
                    continue;
                }
                let face: Vec<_> = points.iter().filter(|p| height(p) > -1e-9).collect();
                // The foot of the centre must lie on the inner side of each line through two corners with all others on one side.
                let mut nearest = f64::INFINITY;
                for p in &face {
                    for q in &face {
                        let inwards = normal.cross(&(*q - *p));
                        if inwards.norm() > 1e-9 && face.iter().all(|r| (*r - *p).dot(&inwards) >= -1e-9) {
                            nearest = nearest.min((centre - *p).dot(&inwards.normalize()));
                        }
                    }
                }
                found.push((normal, nearest.max(0.0).atan2(-height(&centre))));
            }
        }
    }
    found
}

/// The centre of the tetrahedra between a point and the faces of the hull of `points`, fans of their corners.
fn hull_mesh(points: &[Point3<f64>]) -> Option<(Mesh, Point3<f64>)> {
    let middle = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / points.len() as f64;
    let (mut triangles, mut volume, mut moment) = (Vec::new(), 0.0, Vector3::zeros());
    for (normal, _) in slow_resting(points, Point3::from(middle)) {
        let top = points.iter().map(|p| p.coords.dot(&normal)).fold(f64::NEG_INFINITY, f64::max);
        let mut face: Vec<u32> =
            (0..points.len() as u32).filter(|&k| points[k as usize].coords.dot(&normal) > top - 1e-9).collect();
        let about = face.iter().fold(Vector3::zeros(), |sum, &k| sum + points[k as usize].coords) / face.len() as f64;
        let first = points[face[0] as usize].coords - about;
        let angle = |k: u32| {
            let at = points[k as usize].coords - about;
            normal.dot(&first.cross(&at)).atan2(first.dot(&at))
        };
        face.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
        // Corners alone: a fan over points inside the face would not be closed.
        let turns = |face: &[u32], k: usize| {
            let at = |k: usize| points[face[k % face.len()] as usize];
            normal.dot(&(at(k) - at(k + face.len() - 1)).cross(&(at(k + 1) - at(k)))) > 1e-9
        };
        while let Some(k) = (0..face.len()).find(|&k| !turns(&face, k)) {
            face.remove(k);
        }
        for k in 1..face.len() - 1 {
            triangles.push([face[0], face[k], face[k + 1]]);
        }
    }
    for corners in &triangles {
        let [a, b, c] = corners.map(|k| points[k as usize].coords - middle);
        let six = a.cross(&b).dot(&c);
        volume += six;
        moment += six * (a + b + c) / 4.0;
    }
    (volume > 1.0).then(|| ((points.to_vec(), triangles), Point3::from(middle + moment / volume)))
}

fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
    let point = [0..7i32, 0..7, 0..7].prop_map(|at| Point3::from(at.map(f64::from)));
    prop::collection::vec(point, 4..9)
}

fn rotation() -> impl Strategy<Value = Rotation3<f64>> {
    [-3.0..3.0f64, -1.5..1.5, -3.0..3.0].prop_map(|[roll, pitch, yaw]| Rotation3::from_euler_angles(roll, pitch, yaw))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Points of a small lattice: planes through three miss the others by far more than the contact.
    #[test]
    fn resting_poses_are_those_of_the_slow_twin(points in points(), turn in rotation()) {
        let Some((mesh, centre)) = hull_mesh(&points) else { return Ok(()) };
        let options = OrientOptions { min_tipping: 0.02, min_apart: 0.0, ..options(0) };
        let slow = slow_resting(&points, centre);
        let turned = (mesh.0.iter().map(|p| turn * p + Vector3::new(5.0, -3.0, 2.0)).collect(), mesh.1.clone());
        for (mesh, turn) in [(&mesh, Rotation3::identity()), (&turned, turn)] {
            let found = resting(mesh, &options);
            prop_assert!(found.is_sorted_by(|a, b| a.tipping >= b.tipping));
            for (normal, tipping) in slow.iter().filter(|(_, tipping)| *tipping > 0.025) {
                let same = |pose: &&Pose| (pose.up.into_inner() + turn * normal).norm() < 2e-3;
                let pose = found.iter().find(same);
                prop_assert!(pose.is_some_and(|pose| (pose.tipping - tipping).abs() < 2e-3), "{normal:?} {tipping} {found:?}");
            }
            let clear = slow.iter().filter(|(_, tipping)| *tipping > 0.025).count();
            let vague = slow.iter().filter(|(_, tipping)| (0.015..=0.025).contains(tipping)).count();
            prop_assert!((clear..=clear + vague).contains(&found.len()), "{} of {clear} and {vague}", found.len());
        }
    }

    /// Any cells: the columns below what is missed, cell by cell.
    #[test]
    fn support_is_that_of_the_slow_twin(seed in any::<u64>(), solid in 2..7u64, wide in any::<bool>()) {
        let dims: [u32; 3] = [if wide { 70 } else { 7 }, 5, 9];
        let words = dims[0].div_ceil(64);
        let mut rows = random_rows(seed, words * dims[1] * dims[2], 64, solid);
        rows.iter_mut().enumerate().for_each(|(at, word)| if at as u32 % words == words - 1 { *word &= (1 << (dims[0] % 64)) - 1 });
        let made = PoseCells { dims, rows: rows.clone(), cell_mm: 0.5 };
        let options = OrientOptions { strategy: Some(curved::Strategy::Greedy), platform_diameter_mm: 2.0, ..options(0) };
        let pose = Pose { up: Vector3::z_axis(), kind: PoseKind::Given, tipping: 0.0 };
        let judged = judge_poses(&[Point3::origin()], &[pose], &options, &|_| Ok::<_, Infallible>(made.clone()), &go);
        let cells = Cells::new(dims, &rows).unwrap();
        let platform = Platform::under(&cells, 2.0).unwrap();
        let growth = curved::Strategy::Greedy.grow(&cells, &platform, &Rules::default(), &go);
        let (Ok(judged), Ok(growth)) = (judged, growth) else { return Ok(()) };
        let mut columns = std::collections::BTreeSet::new();
        for cell in growth.missed_cells() {
            let [x, y, z] = cells.position(cell);
            columns.extend((0..z).rev().take_while(|&z| !cells.contains([x, y, z])).map(|z| [x, y, z]));
        }
        prop_assert_eq!(judged[0].support_mm3, columns.len() as f64 * 0.125);
        prop_assert_eq!(judged[0].missed_cells, growth.missed.len());
        prop_assert_eq!(judged[0].layers, growth.order.len());
        let on_plate = cells.iter().filter(|&cell| cells.position(cell)[2] == 0).count();
        prop_assert_eq!(judged[0].base_mm2, on_plate as f64 * 0.25);
        let top = cells.iter().map(|cell| cells.position(cell)[2] + 1).max().unwrap();
        prop_assert_eq!(judged[0].height_mm, f64::from(top) * 0.5);
    }

    #[test]
    fn a_laid_part_is_the_same_part(turn in rotation(), points in points()) {
        let pose = Pose { up: Unit::new_normalize(turn * Vector3::z()), kind: PoseKind::Sampled, tipping: 0.0 };
        prop_assert!((pose.rotation() * pose.up.into_inner() - Vector3::z()).norm() < 1e-12);
        let laid = pose.lay(&points);
        prop_assert_eq!(laid.iter().map(|p| p.z).fold(f64::INFINITY, f64::min), 0.0);
        for (a, b) in laid.iter().zip(&points) {
            prop_assert!(((a - laid[0]).norm() - (b - points[0]).norm()).abs() < 1e-12);
            prop_assert!(((a - laid[0]).z - (b - points[0]).dot(&pose.up)).abs() < 1e-12);
        }
    }
}

#[test]
fn the_given_pose_moves_nothing_sideways() {
    let pose = Pose { up: Vector3::z_axis(), kind: PoseKind::Given, tipping: 0.0 };
    let laid = pose.lay(&[Point3::new(0.1, 0.7, -2.5), Point3::new(0.3, -0.2, 4.0)]);
    assert_eq!(laid, [Point3::new(0.1, 0.7, 0.0), Point3::new(0.3, -0.2, 6.5)]);
    assert!(pose.lay(&[]).is_empty());
}

/// No direction is farther from a sampled one than 1.6 times the radius of a cap of an equal share of the sphere.
#[test]
fn directions_cover_the_sphere_evenly() {
    let cube = boxes(&[[[0.0; 3], [1.0; 3]]]);
    for count in [50, 300] {
        let all = poses(&cube.0, &cube.1, &options(count)).unwrap();
        let sampled: Vec<_> = all.iter().filter(|pose| pose.kind == PoseKind::Sampled).map(|pose| pose.up).collect();
        assert_eq!(sampled.len(), count as usize);
        let share = (1.0 - 2.0 / f64::from(count)).acos();
        let mean = sampled.iter().fold(Vector3::zeros(), |sum, up| sum + up.into_inner()) / f64::from(count);
        assert!(mean.norm() < 0.02, "{mean:?}");
        for seed in random_rows(7, 2000, 64, 4).chunks(2) {
            let [u, v] = [seed[0], seed[1]].map(|bits| (bits >> 11) as f64 / (1u64 << 53) as f64);
            let (z, angle) = (2.0 * u - 1.0, 2.0 * PI * v);
            let at = Vector3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z);
            let nearest = sampled.iter().map(|up| up.angle(&at)).fold(PI, f64::min);
            assert!(nearest < 1.6 * share, "{at:?}: {nearest}, {share}");
        }
    }
}

#[test]
fn poses_are_ranked_as_documented_on_any_number_of_threads() {
    let hook = boxes(&[
        [[0.0, 0.0, 0.0], [3.0, 3.0, 12.0]],
        [[3.0, 0.0, 9.0], [12.0, 3.0, 12.0]],
        [[9.0, 0.0, 3.0], [12.0, 3.0, 9.0]],
    ]);
    for standing_first in [false, true] {
        let options = OrientOptions { standing_first, ..options(30) };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| judged(&hook, &options, 1.0))
        };
        let ranked = on(1);
        assert_eq!(ranked, on(4));
        let key = |pose: &JudgedPose| {
            let first = standing_first && !pose.stands;
            let in_tenths = |value: f64| (10.0 * value).round() as i64;
            let (support, height, base) =
                (in_tenths(pose.support_mm3), in_tenths(pose.height_mm), -in_tenths(pose.base_mm2));
            (first, pose.missed_cells, !pose.stands, support, pose.layers, height, base, pose.number)
        };
        assert!(ranked.is_sorted_by_key(key), "{:?}", ranked.iter().map(key).collect::<Vec<_>>());
        let mut numbers: Vec<_> = ranked.iter().map(|pose| pose.number).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..ranked.len()).collect::<Vec<_>>());
    }
}

#[test]
fn resting_poses_near_each_other_are_one() {
    // A ball of few facets stands on each of them.
    let coarse = ball(6);
    let all = resting(&coarse, &OrientOptions { min_apart: 0.0, ..options(0) });
    let apart = resting(&coarse, &OrientOptions { min_apart: 0.6, ..options(0) });
    assert!(apart.len() < all.len() && apart.len() > 6);
    for (k, pose) in apart.iter().enumerate() {
        assert!(apart[..k].iter().all(|other| other.up.angle(&pose.up) >= 0.6));
    }
}

#[test]
fn meshes_that_cannot_lie_are_refused() {
    let refused = |vertices: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let vertices: Vec<_> = vertices.iter().map(|&at| Point3::from(at)).collect();
        poses(&vertices, triangles, &options(3)).unwrap_err()
    };
    assert_eq!(refused(&[], &[]), PoseError::NoTriangle);
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(refused(&flat, &[[0, 1, 2]]), PoseError::NoVolume);
    assert_eq!(refused(&flat, &[[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]]), PoseError::NoVolume);
    assert_eq!(refused(&[[2.0; 3]], &[[0, 0, 0]]), PoseError::NoVolume);
    assert_eq!(refused(&flat, &[[0, 1, 4]]), PoseError::BadIndex { triangle: 0, index: 4, vertices: 4 });
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        let error = refused(&[[0.0; 3], [0.0, bad, 0.0], [1.0; 3]], &[[0, 1, 2]]);
        assert!(matches!(error, PoseError::BadVertex { vertex: 1, .. }), "{error}");
    }
    // Far from the origin, and tiny: fine.
    let cube = boxes(&[[[1e6; 3], [1e6 + 1.0; 3]]]);
    assert_eq!(resting(&cube, &options(0)).len(), 6);
    let cube = boxes(&[[[0.0; 3], [1e-5; 3]]]);
    assert_eq!(resting(&cube, &options(0)).len(), 6);
}

#[test]
fn options_out_of_range_are_refused() {
    let cube = boxes(&[[[0.0; 3], [1.0; 3]]]);
    type Spoil = fn(&mut OrientOptions);
    let with: [(&str, Spoil); 6] = [
        ("directions", |options| options.directions = OrientOptions::MAX_DIRECTIONS + 1),
        ("min_tipping", |options| options.min_tipping = f64::NAN),
        ("min_tipping", |options| options.min_tipping = -0.1),
        ("contact", |options| options.contact = 0.2),
        ("min_apart", |options| options.min_apart = 4.0),
        ("platform_diameter_mm", |options| options.platform_diameter_mm = f64::INFINITY),
    ];
    let given = poses(&cube.0, &cube.1, &options(0)).unwrap();
    for (name, spoil) in with {
        let mut options = options(0);
        spoil(&mut options);
        let error = poses(&cube.0, &cube.1, &options).unwrap_err();
        assert!(matches!(error, PoseError::Option { option, .. } if option == name), "{error}");
        let error = judge_poses(&cube.0, &given, &options, &|laid| cells_of(&cube.1, 0.2, laid), &go).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn poses_that_cannot_be_judged_are_named() {
    let cube = boxes(&[[[0.0; 3], [4.0; 3]]]);
    let all = poses(&cube.0, &cube.1, &options(4)).unwrap();
    let calls = AtomicUsize::new(0);
    // What is made of pose number 5, and of all others.
    let judge = |options: &OrientOptions, spoil: &(dyn Fn(PoseCells) -> Result<PoseCells, String> + Sync)| {
        let spoiled = all[5].lay(&cube.0);
        let voxelise = |laid: &[Point3<f64>]| {
            calls.fetch_add(1, Ordering::Relaxed);
            let Ok(made) = cells_of(&cube.1, 1.0, laid);
            if laid == spoiled { spoil(made) } else { Ok(made) }
        };
        judge_poses(&cube.0, &all, options, &voxelise, &go).unwrap_err()
    };
    let usual = options(0);
    let error = judge(&usual, &|_| Err("too fine".to_owned()));
    assert_eq!(error, PoseError::Voxelise { pose: 5, error: "too fine".to_owned() });
    assert_eq!(error.to_string(), "pose 5: too fine");
    let error = judge(&usual, &|made| Ok(PoseCells { rows: vec![1], ..made }));
    assert!(matches!(error, PoseError::Cells { pose: 5, error: CellsError::Words { words: 1, .. } }));
    for cell_mm in [2.0, f64::NAN, 0.0] {
        let error = judge(&usual, &|made| Ok(PoseCells { cell_mm, ..made }));
        assert!(matches!(error, PoseError::CellSize { pose: 5, .. }), "{error}");
    }
    let error = judge(&usual, &|made| Ok(PoseCells { rows: vec![0; made.rows.len()], ..made }));
    assert_eq!(error, PoseError::Growth { pose: 5, error: GrowthError::NoCell });
    let error = judge(&OrientOptions { platform_diameter_mm: 1e6, ..usual }, &Ok);
    assert!(matches!(error, PoseError::Platform { pose: 0, error: PlatformError::OutOfReach { .. } }));
    let rules = Rules { inside_depth_cells: -1.0, ..Rules::default() };
    let error = judge(&OrientOptions { rules, ..usual }, &Ok);
    assert!(matches!(error, PoseError::Growth { pose: 0, error: GrowthError::Rules(_) }));
    assert!(calls.load(Ordering::Relaxed) > 0);

    let made = |laid: &[Point3<f64>]| cells_of(&cube.1, 1.0, laid);
    assert_eq!(judge_poses(&cube.0, &[], &usual, &made, &go).unwrap_err(), PoseError::NoPose);
    let bad = judge_poses(&[Point3::new(0.0, f64::NAN, 0.0)], &all, &usual, &made, &go).unwrap_err();
    assert!(matches!(bad, PoseError::BadVertex { vertex: 0, .. }));
}

#[test]
fn judging_stops_when_it_is_reported_to() {
    let cube = boxes(&[[[0.0; 3], [6.0; 3]]]);
    let all = poses(&cube.0, &cube.1, &options(10)).unwrap();
    for after in [0, 3] {
        let stop = |p: Progress| {
            assert_eq!((p.stage, p.total), ("orient", all.len() as u64));
            if p.done >= after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let error = judge_poses(&cube.0, &all, &options(0), &|laid| cells_of(&cube.1, 1.0, laid), &stop).unwrap_err();
        assert_eq!(error, PoseError::Cancelled);
    }
}
