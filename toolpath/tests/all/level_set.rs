//! Level sets against closed forms, against a raster, and against what must hold on any surface.

use crate::common::{boundary_edges, go_on, grid, rough, to_boundary, to_edges};
use curvlay_toolpath::geodesic::{Sources, SurfaceDistance};
use curvlay_toolpath::level_set::{Band, LevelField, LevelSetError, LevelSets, Pocket, Ring};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

fn sets(distance: &SurfaceDistance, tolerance: f64, levels: &[f64]) -> LevelSets {
    LevelField::new(distance, tolerance, &go_on).unwrap().level_sets(levels).unwrap()
}

/// Area to the left of a ring in the plane.
fn area(ring: &Ring) -> f64 {
    let p = |k: usize| ring.points[k % ring.points.len()].position.coords.xy();
    (0..ring.points.len()).map(|k| p(k).perp(&p(k + 1)) / 2.0).sum()
}

fn plane(n: usize, seed: u64, jitter: f64, hole: impl Fn(usize, usize) -> bool) -> SurfaceMesh {
    grid(n, seed, jitter, hole, |p| Point3::new(p.x, p.y, 0.0))
}

/// What holds for the level sets of any distance to the whole boundary.
fn is_sound(distance: &SurfaceDistance, levels: &[f64], sets: &LevelSets, tolerance: f64) {
    let mesh = distance.mesh();
    let sides = |t: &[u32; 3]| {
        (0..3)
            .map(|k| (mesh.vertices()[t[k] as usize] - mesh.vertices()[t[(k + 1) % 3] as usize]).norm())
            .fold(0.0, f64::max)
    };
    let longest = mesh.triangles().iter().map(sides).fold(0.0, f64::max);
    for (k, ring) in sets.rings.iter().enumerate() {
        assert!(ring.closed);
        let (below, above) = (&sets.bands[ring.below as usize], &sets.bands[ring.above as usize]);
        assert_eq!((below.slab, above.slab), (ring.level, ring.level + 1));
        assert!(below.above.contains(&(k as u32)) && above.below.contains(&(k as u32)));
        let count = ring.points.len();
        for (k, point) in ring.points.iter().enumerate() {
            // On the surface, where it says.
            assert!((mesh.point(point.triangle, point.barycentric) - point.position).norm() < 1e-10);
            let there = distance.at(point.triangle, point.barycentric).distance;
            assert!((there - levels[ring.level]).abs() <= 2.0 * tolerance, "{there} at level {}", levels[ring.level]);
            let next = &ring.points[(k + 1) % count];
            assert!((next.position - point.position).norm() <= longest, "a jump");
        }
    }
    let count = |of: fn(&Band) -> usize| sets.bands.iter().map(of).sum::<usize>();
    assert_eq!((count(|band| band.below.len()), count(|band| band.above.len())), (sets.rings.len(), sets.rings.len()));
    for band in &sets.bands {
        assert_eq!(band.slab == 0, band.below.is_empty());
        let low = if band.slab == 0 { 0.0 } else { levels[band.slab - 1] };
        let high = levels.get(band.slab).copied().unwrap_or(f64::INFINITY);
        assert!(low < band.height && band.height <= high);
        assert!(band.above.is_empty() || band.height >= high, "a ring above, so it reaches the level");
        let there = distance.at(band.summit.triangle, band.summit.barycentric).distance;
        assert!((there - band.height).abs() <= 2.0 * tolerance);
    }
    let whole = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a)).norm() / 2.0;
    let mesh_area: f64 = mesh.triangles().iter().map(|t| whole(t.map(|v| mesh.vertices()[v as usize]))).sum();
    assert!((sets.bands.iter().map(|band| band.area).sum::<f64>() - mesh_area).abs() < 1e-9 * mesh_area);
    // One graph for each region; cycles only around holes.
    let regions = mesh.regions().count;
    let mut parts: Vec<usize> = (0..sets.bands.len()).collect();
    for ring in &sets.rings {
        let (one, other) = (parts[ring.below as usize], parts[ring.above as usize]);
        parts.iter_mut().filter(|part| **part == one).for_each(|part| *part = other);
    }
    assert_eq!(parts.into_iter().collect::<BTreeSet<_>>().len(), regions);
    let cycles = sets.rings.len() + regions - sets.bands.len();
    assert!(cycles <= mesh.boundary_loops().len() - regions, "{cycles} cycles");
}

#[test]
fn offsets_of_a_rectangle() {
    for jitter in [0.0, 0.6] {
        let mesh = grid(12, 4, jitter, |_, _| false, |p| Point3::new(2.0 * p.x, p.y, 0.0));
        let distance = to_boundary(&mesh);
        // Whole numbers run through vertices of the grid that is not jittered.
        let levels = [0.5, 1.0, 2.0, 3.7, 5.0];
        let sets = sets(&distance, 1e-3, &levels);
        is_sound(&distance, &levels, &sets, 1e-3);
        assert_eq!((sets.rings.len(), sets.bands.len()), (5, 6));
        for ring in &sets.rings {
            let c = levels[ring.level];
            let (length, inside) = (2.0 * (24.0 + 12.0) - 8.0 * c, (24.0 - 2.0 * c) * (12.0 - 2.0 * c));
            assert!((ring.length() - length).abs() < 0.05, "{} instead of {length}", ring.length());
            assert!((area(ring) - inside).abs() < 0.1, "{} instead of {inside}", area(ring));
        }
    }
}

#[test]
fn rings_around_holes_run_the_other_way_and_nest_in_a_cycle() {
    let mesh = plane(15, 3, 0.6, |i, j| (6..9).contains(&i) && (6..9).contains(&j));
    let distance = to_boundary(&mesh);
    let levels = [1.0, 2.0];
    let sets = sets(&distance, 1e-3, &levels);
    is_sound(&distance, &levels, &sets, 1e-3);
    let areas: Vec<f64> = sets.rings.iter().map(area).collect();
    assert_eq!(areas.iter().map(|a| *a > 0.0).collect::<Vec<_>>(), [true, false, true, false]);
    assert!((areas[0] - 169.0).abs() < 0.1, "{areas:?}");
    // Around the hole: a square with four quarters of a disc.
    assert!((areas[1] + 9.0 + 12.0 + std::f64::consts::PI).abs() < 0.1, "{areas:?}");
    // Outside, around the hole, and between the two: not a tree, since the rings meet on the far side.
    assert_eq!(sets.bands.len(), 5);
    assert_eq!(sets.bands.iter().filter(|band| band.below.len() == 2).count(), 1);
}

#[test]
fn level_zero_is_the_boundary() {
    let mesh = plane(6, 1, 0.5, |i, j| i == 3 && j == 2);
    let distance = to_boundary(&mesh);
    let sets = sets(&distance, 1e-3, &[0.0]);
    let lengths: Vec<f64> = sets.rings.iter().map(Ring::length).collect();
    assert_eq!(lengths.len(), 2);
    assert!((lengths[0] - 24.0).abs() < 1e-9 && (lengths[1] - 4.0).abs() < 1e-9, "{lengths:?}");
}

#[test]
fn chains_that_end_at_the_boundary() {
    // Distance to the left side of a square: straight lines across it.
    let mesh = plane(6, 5, 0.5, |_, _| false);
    let x = |v: u32| mesh.vertices()[v as usize].x;
    let left: Vec<[u32; 2]> = boundary_edges(&mesh).into_iter().filter(|e| e.iter().all(|&v| x(v) < 1e-9)).collect();
    let distance = SurfaceDistance::to(&mesh, Sources { edges: &left, vertices: &[] }, &go_on).unwrap();
    let sets = sets(&distance, 1e-3, &[1.5, 4.25]);
    assert_eq!((sets.rings.len(), sets.bands.len()), (2, 3));
    for (ring, at) in sets.rings.iter().zip([1.5, 4.25]) {
        assert!(!ring.closed);
        assert!((ring.length() - 6.0).abs() < 1e-9);
        assert!(ring.points.iter().all(|p| (p.position.x - at).abs() < 1e-9));
        assert!(ring.points[0].position.y > ring.points[1].position.y, "greater distances on the left");
    }
}

#[test]
fn the_medial_axis_runs_through_a_single_row_of_triangles() {
    // All vertices are on the boundary, where the distance is 0.
    let mesh = grid(1, 1, 0.0, |_, _| false, |p| Point3::new(20.0 * p.x, 2.0 * p.y, 0.0));
    let distance = to_boundary(&mesh);
    assert_eq!(distance.at_vertices(), [0.0; 4]);
    let levels = [0.25, 0.5, 0.9];
    let sets = sets(&distance, 1e-3, &levels);
    is_sound(&distance, &levels, &sets, 1e-3);
    assert_eq!(sets.rings.len(), 3);
    for ring in &sets.rings {
        assert!((ring.length() - (44.0 - 8.0 * levels[ring.level])).abs() < 0.02, "{}", ring.length());
    }
}

/// Rooms joined by necks: `(from, to, half width)` along x, on a grid of 40 by 40 squares around its middle.
fn rooms(rooms: &'static [(usize, usize, usize)], seed: u64) -> SurfaceMesh {
    let outside = |i: usize, j: usize| {
        let half = rooms.iter().find(|(from, to, _)| (*from..*to).contains(&i)).map_or(0, |room| room.2);
        !(20 - half..20 + half).contains(&j)
    };
    plane(40, seed, 0.6, outside)
}

#[test]
fn pockets_are_rooms_and_saddles_are_necks() {
    // Rooms 10, 14 and 8 wide behind necks 4 and 2 wide.
    let mesh = rooms(&[(0, 10, 5), (10, 13, 2), (13, 27, 7), (27, 31, 1), (31, 39, 4)], 6);
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, 1e-3, &go_on).unwrap();
    let pockets = field.pockets(0.1);
    let heights: Vec<f64> = pockets.iter().map(|pocket| pocket.height).collect();
    assert_eq!(heights.len(), 3);
    // A summit lies where a circle fits: near a neck it bulges into it a little.
    for (height, room) in heights.iter().zip([7.0, 5.0, 4.0]) {
        assert!(room - 1e-3 < *height && *height < room * 1.04, "{heights:?}");
    }
    assert!(pockets[0].joins.is_none());
    for (pocket, neck) in pockets[1..].iter().zip([2.0, 1.0]) {
        let (_, saddle, into) = pocket.joins.unwrap();
        assert!((saddle - neck).abs() < 2e-3 && into == 0, "{saddle}");
    }
    // Levels below and above the necks.
    let levels = [0.5, 1.5, 3.0, 4.5, 6.0];
    let sets = field.level_sets(&levels).unwrap();
    is_sound(&distance, &levels, &sets, 1e-3);
    let count = |level: usize| sets.rings.iter().filter(|ring| ring.level == level).count();
    assert_eq!([0, 1, 2, 3, 4].map(count), [1, 2, 3, 2, 1]);
}

#[test]
fn a_level_ridge_is_no_chain_of_pockets() {
    // A corridor 4 wide around a hole: its ridge is level but for the corners, where it rises.
    for (seed, jitter) in [(1, 0.0), (2, 0.6), (3, 0.6), (4, 0.6)] {
        let mesh = plane(20, seed, jitter, |i, j| (4..16).contains(&i) && (4..16).contains(&j));
        let distance = to_boundary(&mesh);
        let pockets = LevelField::new(&distance, 1e-3, &go_on).unwrap().pockets(0.05);
        let corner = 4.0 * 2f64.sqrt() / (1.0 + 2f64.sqrt());
        assert_eq!(pockets.len(), 4, "seed {seed}");
        for pocket in &pockets {
            assert!((pocket.height - corner).abs() < 2e-3, "{} instead of {corner}", pocket.height);
        }
        for pocket in &pockets[1..] {
            assert!((pocket.joins.unwrap().1 - 2.0).abs() < 2e-3);
        }
        // A long straight corridor has one.
        let straight = grid(20, seed, jitter, |_, _| false, |p| Point3::new(3.0 * p.x, 0.2 * p.y, 0.0));
        let distance = to_boundary(&straight);
        assert_eq!(LevelField::new(&distance, 1e-3, &go_on).unwrap().pockets(0.01).len(), 1);
    }
}

#[test]
fn rings_on_a_dome_are_circles() {
    // A cap of a sphere of radius 20 seen through a disc: distance from the rim is that along meridians.
    let (rings, sectors, radius) = (40, 120, 20.0);
    let place = |ring: usize, k: usize| {
        let (down, around) = (1.2 * ring as f64 / rings as f64, std::f64::consts::TAU * k as f64 / sectors as f64);
        Point3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos()) * radius
    };
    let mut vertices = vec![place(0, 0)];
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        for k in 0..sectors {
            vertices.push(place(ring, k));
            let at = |ring: usize, k: usize| (1 + (ring - 1) * sectors + k % sectors) as u32;
            match ring {
                1 => triangles.push([0, at(1, k), at(1, k + 1)]),
                _ => triangles.extend([
                    [at(ring - 1, k), at(ring, k), at(ring, k + 1)],
                    [at(ring - 1, k), at(ring, k + 1), at(ring - 1, k + 1)],
                ]),
            }
        }
    }
    let mesh = SurfaceMesh::new(vertices, triangles).unwrap();
    let distance = to_boundary(&mesh);
    let levels = [2.0, 8.0, 16.0, 22.0];
    let sets = sets(&distance, 1e-3, &levels);
    is_sound(&distance, &levels, &sets, 1e-3);
    assert_eq!(sets.rings.len(), 4);
    for ring in &sets.rings {
        // The rim and the meridians are polylines, up to 0.007 and 0.001 off the circles.
        let circle = |at: f64| std::f64::consts::TAU * radius * (1.2 - at / radius).sin();
        let at = levels[ring.level];
        assert!(circle(at + 0.01) < ring.length() && ring.length() < circle(at - 0.01), "{} at {at}", ring.length());
    }
}

#[test]
fn what_cannot_be_done() {
    let mesh = plane(4, 1, 0.5, |_, _| false);
    let distance = to_boundary(&mesh);
    for tolerance in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(LevelField::new(&distance, tolerance, &go_on).unwrap_err(), LevelSetError::Tolerance { tolerance });
    }
    let nan = LevelField::new(&distance, f64::NAN, &go_on).unwrap_err();
    assert!(matches!(nan, LevelSetError::Tolerance { .. }));
    let stopped = LevelField::new(&distance, 1e-2, &|_| ControlFlow::Break(()));
    assert_eq!(stopped.unwrap_err(), LevelSetError::Cancelled);
    let field = LevelField::new(&distance, 1e-2, &go_on).unwrap();
    let error = |levels: &[f64]| field.level_sets(levels).unwrap_err();
    assert_eq!(error(&[1.0, f64::NAN]), LevelSetError::Level { level: 1 });
    assert_eq!(error(&[0.5, 1.0, 1.0]), LevelSetError::Level { level: 2 });
    // No level, and levels out of reach, are no errors.
    assert_eq!(field.level_sets(&[]).unwrap().bands.len(), 1);
    let far = field.level_sets(&[-3.0, 100.0]).unwrap();
    assert_eq!((far.rings.len(), far.bands.len()), (0, 1));
    // Around a corner the ridge is a parabola, which no polyline follows to rounding.
    let bent = plane(4, 1, 0.5, |i, j| i > 1 && j > 1);
    let distance = to_boundary(&bent);
    let fine = LevelField::new(&distance, 1e-13, &go_on).unwrap_err();
    assert!(matches!(fine, LevelSetError::TooFine { .. }), "{fine}");
}

/// The parts of a set of squares that are connected over sides, by how many squares they have.
fn parts(inside: &BTreeSet<(i32, i32)>) -> Vec<usize> {
    let mut left = inside.clone();
    let mut sizes = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut waiting, mut size) = (vec![first], 0);
        while let Some((i, j)) = waiting.pop() {
            size += 1;
            let beside = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)];
            waiting.extend(beside.into_iter().filter(|at| left.remove(at)));
        }
        sizes.push(size);
    }
    sizes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// In the plane, what lies above a level is found by a raster too.
    #[test]
    fn parts_above_a_level_are_those_of_a_raster(
        seed in any::<u64>(), level in 0.3..1.4f64, cut in prop::collection::vec(any::<bool>(), 16),
    ) {
        // A grid of 12 x 12 squares with blocks of 2 x 2 cut out in places where they do not touch.
        let inside = |k: usize| k % 3 < 2 && (1..11).contains(&k);
        let hole = |i: usize, j: usize| inside(i) && inside(j) && cut[i / 3 + 4 * (j / 3)];
        let mesh = plane(12, seed, 0.6, hole);
        let distance = to_boundary(&mesh);
        let sets = sets(&distance, 1e-3, &[level]);
        is_sound(&distance, &[level], &sets, 1e-3);
        let edges = boundary_edges(&mesh);
        let pixels = 20;
        let mut raster = Vec::new();
        for i in 0..12 * pixels {
            for j in 0..12 * pixels {
                let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(pixels));
                if !hole(x as usize, y as usize) {
                    raster.push(((i, j), to_edges(&mesh, &edges, Point3::new(x, y, 0.0))));
                }
            }
        }
        let pixel_area = 1.0 / f64::from(pixels * pixels);
        let large = |area: f64| area > 20.0 * pixel_area;
        let above = |level: f64| {
            let inside: BTreeSet<_> = raster.iter().filter(|(_, d)| *d > level).map(|(at, _)| *at).collect();
            parts(&inside).into_iter().map(|size| size as f64 * pixel_area).collect::<Vec<_>>()
        };
        let count = |areas: &[f64]| areas.iter().filter(|area| large(**area)).count();
        // Necks about as high as the level, and parts about as large as counts, are beyond the raster: they would come
        // and go with the diagonal of a pixel, by which the distance differs.
        let there = above(level);
        let off = 1.5 / f64::from(pixels);
        prop_assume!(!there.iter().any(|area| large(2.0 * area) && !large(area / 2.0)));
        prop_assume!(count(&above(level - off)) == count(&there) && count(&there) == count(&above(level + off)));
        let ours: Vec<f64> = sets.bands.iter().filter(|band| band.slab == 1).map(|band| band.area).collect();
        prop_assert_eq!(count(&ours), count(&there));
        let total = there.iter().sum::<f64>();
        let rims: f64 = sets.rings.iter().map(Ring::length).sum();
        prop_assert!((ours.iter().sum::<f64>() - total).abs() < 0.5 * rims / f64::from(pixels) + 0.01);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn level_sets_of_rough_surfaces_are_sound(seed in 0u64..1 << 40, height in 0.0..3.0f64, hole in any::<bool>()) {
        let mesh = rough(8, seed, height, |i, j| hole && (2..4).contains(&i) && j == 4);
        let distance = to_boundary(&mesh);
        let levels = [0.2, 0.75, 1.0, 1.6, 2.4, 3.1];
        let field = LevelField::new(&distance, 0.01, &go_on).unwrap();
        let sets = field.level_sets(&levels).unwrap();
        is_sound(&distance, &levels, &sets, 0.01);
        prop_assert_eq!(&sets, &field.level_sets(&levels).unwrap());
        // Pockets and parts above a level count the same.
        let pockets = field.pockets(0.0);
        for (slab, &level) in levels.iter().enumerate() {
            let apart = |p: &&Pocket| p.height > level && p.joins.is_none_or(|(_, saddle, _)| saddle <= level);
            let parts = pockets.iter().filter(apart).count();
            let mut above: Vec<usize> = (0..sets.bands.len()).collect();
            for ring in sets.rings.iter().filter(|ring| ring.level > slab) {
                let (one, other) = (above[ring.below as usize], above[ring.above as usize]);
                above.iter_mut().filter(|part| **part == one).for_each(|part| *part = other);
            }
            let high = (0..sets.bands.len()).filter(|&b| sets.bands[b].slab > slab);
            let bands: BTreeSet<usize> = high.map(|b| above[b]).collect();
            prop_assert_eq!(parts, bands.len(), "level {}", level);
        }
    }
}

/// A crossing of corridors is an island above a level that the corridors do not reach.
#[test]
fn an_island_where_corridors_cross() {
    // Two blocks below a corridor 1 wide, with a gap of 1 between them.
    let mesh = plane(12, 0, 0.6, |i, j| [3, 4, 6, 7].contains(&i) && [9, 10].contains(&j));
    let distance = to_boundary(&mesh);
    let level = 0.532;
    let sets = sets(&distance, 1e-3, &[level]);
    is_sound(&distance, &[level], &sets, 1e-3);
    let mut above: Vec<(f64, f64)> = sets.bands.iter().filter(|b| b.slab == 1).map(|b| (b.area, b.height)).collect();
    above.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(above.len(), 2, "{above:?}");
    // As far from the wall above as from the corners of both blocks: (1 - u)^2 = u^2 + 1/4.
    assert!((above[0].1 - 0.625).abs() < 1e-3, "{above:?}");
}

#[test]
fn an_edge_that_waits_while_a_longer_one_beside_it_is_cut() {
    let mesh = rough(8, 238_551_065_996, 2.598_783_922_774_995, |i, j| (2..4).contains(&i) && j == 4);
    let distance = to_boundary(&mesh);
    let levels = [0.2, 0.75, 1.0, 1.6, 2.4, 3.1];
    is_sound(&distance, &levels, &sets(&distance, 0.01, &levels), 0.01);
}
