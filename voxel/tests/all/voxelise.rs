//! What becomes of whole meshes: sound ones, damaged ones, and none.

use crate::common::{Mesh, bumpy_ball, cuboid, go_on, shared};
use curvlay_voxel::nalgebra::{Point3, Rotation3, Vector3};
use curvlay_voxel::{GridError, Resolution, TooFine, VoxelError, VoxelGrid, VoxelOptions, Voxelisation, voxelise};
use proptest::prelude::*;
use std::ops::ControlFlow;

fn cells(mesh: &Mesh, cell_mm: f64) -> Voxelisation {
    mesh.with(Resolution::Cell(cell_mm)).expect("a sound mesh")
}

/// Whether the point of the unmoved mesh lies in a cell, or within a millionth of a cell of one.
fn covered(solid: &Voxelisation, at: Point3<f64>) -> bool {
    let at = (at + solid.shift - solid.grid.origin()) / solid.grid.cell_mm();
    let near = |c: f64| [(c - 1e-6).floor().max(0.0) as u32, (c + 1e-6).floor().max(0.0) as u32];
    let [x, y, z] = [near(at.x), near(at.y), near(at.z)];
    (0..8).any(|k| solid.grid.contains([x[k & 1], y[k >> 1 & 1], z[k >> 2]]))
}

#[test]
fn a_cube_on_planes_of_the_grid_gives_its_cells_and_no_more() {
    for (side, cell, n) in [(10.0, 1.0, 10u32), (20.0, 0.8, 25), (0.3, 0.1, 3), (47.9, 0.1, 479), (1.0, 1.0, 1)] {
        for place in [[0.0; 3], [0.1, -7.3, 1e4]] {
            let solid = cells(&cuboid([0.0; 3], [side; 3]).moved(place), cell);
            assert_eq!(solid.grid.dims(), [n; 3]);
            assert_eq!(solid.grid.count(), (n * n * n) as usize);
            assert_eq!((solid.grid.origin().x, solid.grid.origin().z), (place[0], 0.0));
            assert_eq!(solid.shift, Vector3::new(0.0, 0.0, -place[2]));
        }
    }
}

#[test]
fn blocks_that_share_a_plane_of_the_grid_keep_the_gap_beside_them() {
    // An arch: the opening is enclosed by faces on planes of the grid, and reaches the border only under the plate.
    let arch = cuboid([0.0; 3], [2.0, 4.0, 5.0]).and(&cuboid([6.0, 0.0, 0.0], [8.0, 4.0, 5.0]));
    let arch = arch.and(&cuboid([0.0, 0.0, 5.0], [8.0, 4.0, 8.0]));
    let expected = VoxelGrid::from_fn([8, 4, 8], |[x, _, z]| z >= 5 || !(2..6).contains(&x)).unwrap();
    assert_eq!(cells(&arch, 1.0).grid, expected);
    // A cavity with faces on planes of the grid stays empty, also off them.
    let shell = cuboid([0.0; 3], [9.0; 3]).and(&cuboid([2.0; 3], [6.0; 3]).turned());
    let hollow =
        |from: u32, to: u32| VoxelGrid::from_fn([9; 3], |cell| !cell.iter().all(|c| (from..to).contains(c))).unwrap();
    assert_eq!(cells(&shell, 1.0).grid, hollow(2, 6));
    let shell = cuboid([0.0; 3], [9.0; 3]).and(&cuboid([2.5; 3], [6.5; 3]).turned());
    assert_eq!(cells(&shell, 1.0).grid, hollow(3, 6));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Samples of the surface and of the inside lie in cells; each cell is near the solid.
    #[test]
    fn nothing_of_the_solid_lies_outside_the_cells(
        turn in [-3.0..3.0, -3.0..3.0, -3.0..3.0], n in 6u32..24, cell in 0.7f64..4.0, seed in any::<u32>()
    ) {
        let mut mesh = bumpy_ball(n, 10.0, 0.2);
        let turn = Rotation3::from_scaled_axis(Vector3::from(turn));
        mesh.vertices.iter_mut().for_each(|at| *at = turn * *at);
        let solid = cells(&mesh, cell);
        prop_assert_eq!(solid.report.open_edges, 0);
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for [a, b, c] in mesh.corners() {
            for _ in 0..8 {
                let (u, v, depth) = (random(), random(), random());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let at = a + (b - a) * u + (c - a) * v;
                prop_assert!(covered(&solid, at), "{at} on the surface");
                // Star-shaped about the origin: all between is inside.
                let at = Point3::from(at.coords * depth);
                prop_assert!(covered(&solid, at), "{at} inside");
            }
        }
        let farthest = 10.0 * 1.2 + cell * 3f64.sqrt();
        for id in solid.grid.iter() {
            let at = solid.grid.centre(solid.grid.position(id)) - solid.shift;
            prop_assert!(at.coords.norm() < farthest);
        }
    }

    /// Turned, the mesh gives the same cells and says so.
    #[test]
    fn a_mesh_turned_inwards_gives_the_same_cells(n in 4u32..20, cell in 0.5f64..30.0) {
        let ball = bumpy_ball(n, 10.0, 0.1);
        let (sound, turned) = (cells(&ball, cell), cells(&ball.turned(), cell));
        prop_assert_eq!(&sound.grid, &turned.grid);
        prop_assert!(!sound.report.inside_out && turned.report.inside_out);
        prop_assert_eq!(turned.report.turned_triangles, turned.report.triangles);
        prop_assert_eq!((turned.report.turned_cells, sound.report.turned_triangles), (0, 0));
    }

    /// The number of cells comes near what was asked for, and the part stands on the plate.
    #[test]
    fn a_wanted_number_of_cells_is_reached(n in 8u32..30, wanted in 100u64..30_000, height in -9.0f64..9.0) {
        let ball = bumpy_ball(n, 10.0, 0.15).moved([0.0, 3.0, height]);
        let solid = ball.with(Resolution::Count(wanted)).unwrap();
        let off = (solid.grid.count() as u64).abs_diff(wanted);
        prop_assert!(off <= (wanted / 100).max(1), "{} for {wanted}", solid.grid.count());
        prop_assert_eq!(solid.grid.count() as u64, solid.report.surface_cells + solid.report.interior_cells);
        let low = ball.vertices.iter().map(|at| at.z + solid.shift.z).fold(f64::INFINITY, f64::min);
        prop_assert!(low.abs() < 1e-9 && solid.grid.origin().z == 0.0);
        prop_assert!(ball.vertices.iter().all(|&at| covered(&solid, at)));
    }
}

#[test]
fn counts_from_one_to_many_are_reached_where_they_can_be() {
    let cube = cuboid([0.0; 3], [20.0; 3]);
    for n in [1u64, 8, 1000, 1331, 8000] {
        assert_eq!(cube.with(Resolution::Count(n)).unwrap().grid.count() as u64, n);
    }
    // Between 10 x 10 x 10 and 11 x 11 x 11 lie 11 x 10 x 10 and 11 x 11 x 10, with the grid moved.
    assert_eq!(cube.with(Resolution::Count(1100)).unwrap().grid.count(), 1100);
    assert_eq!(cube.with(Resolution::Count(1210)).unwrap().grid.count(), 1210);
    assert_eq!(cube.with(Resolution::Count(1150)).unwrap().grid.count(), 1100);
    let ball = bumpy_ball(40, 10.0, 0.1);
    let million = ball.with(Resolution::Count(1_000_000)).unwrap();
    assert!(million.grid.count().abs_diff(1_000_000) <= 1000 && million.report.trials < 10);
}

/// What a search found is made again from the size and the corner of its grid alone, to the last bit.
#[test]
fn a_grid_that_was_found_is_made_again() {
    let mut moved = 0;
    for place in [[0.0; 3], [0.1, -7.3, 4.0], [1e6, -1e5 / 3.0, 0.0]] {
        let cube = cuboid([0.0; 3], [20.0, 19.0, 20.0]).moved(place);
        for count in [1000, 1100, 1210, 5000] {
            let found = cube.with(Resolution::Count(count)).unwrap();
            let (cell_mm, origin) = (found.grid.cell_mm(), found.grid.origin());
            let again = cube.with(Resolution::At { cell_mm, corner: [origin.x, origin.y] }).unwrap();
            assert_eq!((&again.grid, again.shift), (&found.grid, found.shift), "{place:?} {count}");
            moved += usize::from(cube.with(Resolution::Cell(cell_mm)).unwrap().grid != found.grid);
        }
    }
    assert!(moved > 0, "no search moved the grid");
    let cube = cuboid([0.0; 3], [5.0; 3]);
    for corner in [[0.1, 0.0], [0.0, -1.1], [f64::NAN, 0.0], [-1e300, 0.0]] {
        let refused = cube.with(Resolution::At { cell_mm: 1.0, corner });
        assert!(matches!(refused, Err(VoxelError::Corner { part: [0.0, 0.0], .. })), "{corner:?}");
    }
    for cell_mm in [0.0, -1.0, f64::NAN] {
        let refused = cube.with(Resolution::At { cell_mm, corner: [0.0; 2] });
        assert!(matches!(refused, Err(VoxelError::Grid(GridError::CellSize { .. }))), "{cell_mm}");
    }
}

/// A box without its lid: a flood fill from outside would leave the bare walls.
#[test]
fn a_hole_is_reported_and_the_inside_kept() {
    let mut mesh = cuboid([0.0; 3], [20.0, 20.0, 40.0]);
    mesh.triangles.truncate(10);
    for cell in [0.9, 1.0] {
        let whole = cells(&cuboid([0.0; 3], [20.0, 20.0, 40.0]), cell).grid.count() as f64;
        let solid = cells(&mesh, cell);
        // A face of a cell for each in the mouth, more where it bulges, fewer as the cells of the rim are surface.
        let mouth = (20.0f64 / cell).ceil().powi(2);
        assert_eq!(solid.report.open_edges, 4);
        assert!((0.6 * mouth..1.5 * mouth).contains(&(solid.report.leak_faces as f64)), "{:?}", solid.report);
        let count = solid.grid.count() as f64;
        assert!((0.85 * whole..=whole).contains(&count), "{count} of {whole} cells");
        assert!(solid.grid.contains([10, 10, 20]));
    }
    // One triangle of many, smaller than a cell: no leak.
    let mut ball = bumpy_ball(40, 10.0, 0.1);
    let whole = cells(&ball, 2.0);
    ball.triangles.remove(1500);
    let solid = cells(&ball, 2.0);
    assert_eq!((solid.report.leak_faces, solid.report.open_edges), (0, 3));
    assert_eq!(solid.grid, whole.grid);
}

/// Triangles that meet without sharing corners are closed for all that matters.
#[test]
fn a_seam_with_corners_on_one_side_only_does_not_leak() {
    let mut mesh = cuboid([0.0; 3], [8.0; 3]);
    // The lid in four triangles around its middle line, the walls unaware of it.
    mesh.triangles.truncate(10);
    mesh.vertices.extend([Point3::new(4.0, 0.0, 8.0), Point3::new(4.0, 8.0, 8.0)]);
    mesh.triangles.extend([[4, 8, 9], [4, 9, 6], [8, 5, 7], [8, 7, 9]]);
    let solid = cells(&mesh, 0.7);
    assert!(solid.report.open_edges > 0);
    assert_eq!(solid.report.leak_faces, 0);
    assert_eq!(solid.grid, cells(&cuboid([0.0; 3], [8.0; 3]), 0.7).grid);
}

#[test]
fn parts_that_pass_through_each_other_are_united() {
    let both = cuboid([0.0; 3], [6.0; 3]).and(&cuboid([3.0; 3], [9.0; 3]));
    let expected = VoxelGrid::from_fn([9; 3], |cell| cell.iter().all(|&c| c < 6) || cell.iter().all(|&c| c >= 3));
    assert_eq!(cells(&both, 1.0).grid, expected.unwrap());
    assert_eq!(cells(&both, 1.0).report.turned_cells, 0);
}

#[test]
fn triangles_without_area_are_dropped_and_counted() {
    let mut mesh = cuboid([0.0; 3], [5.0; 3]);
    mesh.vertices.extend([[90.0; 3], [91.0; 3], [93.0; 3]].map(Point3::from));
    mesh.triangles.extend([[8, 9, 10], [8, 8, 8], [0, 0, 1]]);
    let solid = cells(&mesh, 1.0);
    assert_eq!((solid.report.dropped_triangles, solid.report.triangles), (3, 12));
    assert_eq!((solid.grid.count(), solid.report.open_edges), (125, 0));
    let none = Mesh { triangles: vec![[8, 9, 10], [0, 0, 0]], ..mesh };
    assert_eq!(none.with(Resolution::Cell(1.0)), Err(VoxelError::NoArea { dropped: 2 }));
}

#[test]
fn bad_input_is_named() {
    let cube = cuboid([0.0; 3], [5.0; 3]);
    let at = |resolution| cube.with(resolution).unwrap_err();
    assert_eq!(at(Resolution::Count(0)), VoxelError::NoCount);
    for cell_mm in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(at(Resolution::Cell(cell_mm)), VoxelError::Grid(GridError::CellSize { cell_mm }));
    }
    assert!(matches!(at(Resolution::Cell(f64::NAN)), VoxelError::Grid(GridError::CellSize { .. })));
    for cell in [1e-3, 1e-30, f64::MIN_POSITIVE] {
        let VoxelError::TooFine(TooFine { cell_mm, fits_mm, cause }) = at(Resolution::Cell(cell)) else {
            panic!("{cell}");
        };
        // With 1280 cells a side, 20 words a row, the bits take 250 MiB; one more makes 21 words and 263 MiB.
        assert!(cell_mm.to_bits() == cell.to_bits() && (1277.0..=1280.0).contains(&(5.0 / fits_mm)), "{fits_mm}");
        assert!(matches!(cause, GridError::Memory { .. } | GridError::Dims { .. }));
        assert!(cube.with(Resolution::Cell(fits_mm * 4.0)).is_ok());
    }
    for count in [1 << 33, u64::MAX] {
        let VoxelError::TooMany { wanted, fits, .. } = at(Resolution::Count(count)) else { panic!("{count}") };
        assert!(wanted == count && (2_000_000_000..2_200_000_000).contains(&fits), "{fits}");
    }
    let with_bytes = |resolution, max_bytes| {
        let options = VoxelOptions { resolution, max_bytes };
        voxelise(&cube.vertices, &cube.triangles, &options, &go_on).map(|solid| solid.grid.dims())
    };
    let cause = GridError::Memory { dims: [50; 3], bytes: 20_000, limit: 1000 };
    let refused = with_bytes(Resolution::Cell(0.1), 1000);
    assert!(matches!(refused, Err(VoxelError::TooFine(TooFine { cause: found, .. })) if found == cause), "{refused:?}");
    let Err(VoxelError::TooFine(TooFine { fits_mm, .. })) = refused else { unreachable!() };
    assert_eq!(with_bytes(Resolution::Cell(fits_mm), 1000), Ok([11; 3]));
    assert!(with_bytes(Resolution::Cell(fits_mm * 0.99), 1000).is_err());
    let Err(VoxelError::TooMany { fits, .. }) = with_bytes(Resolution::Count(100_000), 1000) else { panic!() };
    assert!(with_bytes(Resolution::Count(fits / 2), 1000).is_ok());

    let broken = |change: fn(&mut Mesh)| {
        let mut mesh = cube.clone();
        change(&mut mesh);
        mesh.with(Resolution::Cell(1.0)).unwrap_err()
    };
    assert_eq!(broken(|mesh| mesh.triangles.clear()), VoxelError::NoTriangle);
    assert_eq!(broken(|mesh| mesh.triangles[7][2] = 8), VoxelError::BadIndex { triangle: 7, index: 8, vertices: 8 });
    assert!(matches!(broken(|mesh| mesh.vertices[3].y = f64::NAN), VoxelError::BadVertex { vertex: 3, .. }));
    assert!(matches!(broken(|mesh| mesh.vertices[7].z = f64::NEG_INFINITY), VoxelError::BadVertex { vertex: 7, .. }));
    assert!(matches!(broken(|mesh| mesh.vertices[0].x = 1e300), VoxelError::BadVertex { vertex: 0, .. }));
    assert!(matches!(
        broken(|mesh| mesh.vertices[0].x = -1e99),
        VoxelError::TooFine(TooFine { cause: GridError::Dims { .. }, .. })
    ));
    let plate = Mesh { triangles: cube.triangles[8..10].to_vec(), ..cube.clone() };
    assert_eq!(plate.with(Resolution::Cell(1.0)), Err(VoxelError::Nothing { cell_mm: 1.0 }));
    assert!(matches!(plate.with(Resolution::Count(100)), Err(VoxelError::Nothing { .. })));
}

#[test]
fn meshes_of_any_size_do_no_harm() {
    for scale in [1e-300, 1e-30, 1e-3, 1e3, 1e90] {
        let ball = bumpy_ball(10, scale, 0.1);
        match ball.with(Resolution::Count(1000)) {
            Ok(solid) => assert!(solid.grid.count().abs_diff(1000) <= 10, "{scale}: {}", solid.grid.count()),
            Err(VoxelError::NoArea { .. }) => assert!(scale < 1e-100),
            Err(other) => panic!("{scale}: {other}"),
        }
    }
    // A needle reaches the greatest side long before the wanted number.
    let needle = cuboid([0.0; 3], [1e-3, 1e-3, 1e3]);
    assert!(matches!(needle.with(Resolution::Count(1_000_000)), Err(VoxelError::TooMany { fits: ..1_000_000, .. })));
    assert_eq!(needle.with(Resolution::Count(16_000)).unwrap().grid.count(), 16_000);
}

#[test]
fn work_can_be_stopped_at_any_call() {
    use std::sync::atomic::{AtomicU32, Ordering};
    let ball = bumpy_ball(60, 10.0, 0.1);
    for resolution in [Resolution::Cell(0.5), Resolution::Count(5000)] {
        let options = VoxelOptions { resolution, ..VoxelOptions::default() };
        for after in [0, 1, 2, 5] {
            let calls = AtomicU32::new(0);
            let stop = |progress: curvlay_voxel::Progress| {
                assert!(progress.done <= progress.total);
                match calls.fetch_add(1, Ordering::Relaxed) {
                    call if call < after => ControlFlow::Continue(()),
                    _ => ControlFlow::Break(()),
                }
            };
            match voxelise(&ball.vertices, &ball.triangles, &options, &stop) {
                Err(VoxelError::Cancelled) => assert_eq!(calls.into_inner(), after + 1),
                other => assert!(other.is_ok() && calls.into_inner() <= after),
            }
        }
    }
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn damaged_models_are_reported() {
    let solid = shared("bad-models/hole.stl").with(Resolution::Count(20_000)).unwrap();
    assert!(solid.report.open_edges > 0);
    assert!(solid.report.interior_cells > solid.report.surface_cells / 2, "{:?}", solid.report);
    let solid = shared("bad-models/inside-out.stl").with(Resolution::Count(20_000)).unwrap();
    assert!(solid.report.inside_out && solid.report.turned_triangles == solid.report.triangles);
    let solid = shared("bad-models/zero-area.stl").with(Resolution::Count(20_000)).unwrap();
    assert_eq!((solid.report.dropped_triangles, solid.report.open_edges), (120, 0));
    let solid = shared("bad-models/self-intersecting.stl").with(Resolution::Count(20_000)).unwrap();
    assert!(!solid.report.inside_out && solid.report.turned_cells == 0);
    let nan = shared("bad-models/nan-coords.stl");
    assert!(matches!(nan.with(Resolution::Count(1000)), Err(VoxelError::BadVertex { .. })));
}

/// Cells whose centre is inside, at 0.8 mm, as counted elsewhere (README of the models): all of them are among ours,
/// and what we have beyond them is the half of a cell that touched cells reach out.
#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where that folder exists"]
fn counts_of_the_models_agree_with_the_published_ones() {
    for (name, centres, area) in [("bunny", 304_196.0, 20_235.8), ("bunny-hollow", 96_957.0, 35_103.1)] {
        let mesh = shared(&format!("models/{name}.stl"));
        let count = cells(&mesh, 0.8).grid.count() as f64;
        let expected = centres + 0.75 * area / (0.8 * 0.8);
        assert!((count / expected - 1.0).abs() < 0.02, "{name}: {count} cells, about {expected} expected");
    }
}

/// Whatever stands beside it, the same cells are at the same places of the mesh, the grid holds both, and the lower of both stands on the plate.
#[test]
fn what_stands_beside_it_moves_no_cell() {
    let mesh = bumpy_ball(9, 4.0, 0.2).moved([1.3, -0.4, 2.2]);
    let (vertices, alone) = (&mesh.vertices, cells(&mesh, 0.7));
    let places = |solid: &Voxelisation| {
        let centre = |cell: u32| solid.grid.centre(solid.grid.position(cell)) - solid.shift;
        solid.grid.iter().map(centre).collect::<Vec<_>>()
    };
    let boxes = [
        [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
        [[-4.3, 0.2, -3.1], [0.5, 9.0, 0.3]],
        [[20.0, -30.0, 5.0], [25.0, -20.0, 17.0]],
        [[1.0, 1.0, -0.05], [2.0, 2.0, 0.0]],
    ];
    for corners in boxes.map(|corners| corners.map(Point3::from)) {
        let both = alone.clone().beside(corners, 1 << 28).unwrap();
        let (before, after) = (places(&alone), places(&both));
        assert!(before.len() == after.len() && before.iter().zip(&after).all(|(a, b)| (a - b).norm() < 1e-9));
        let (low, side) = (both.grid.origin(), both.grid.dims().map(|n| f64::from(n) * both.grid.cell_mm()));
        for corner in corners.into_iter().chain(vertices.iter().copied()).map(|corner| corner + both.shift) {
            let is_held = |axis: usize| (low[axis] - 1e-6..=low[axis] + side[axis] + 1e-6).contains(&corner[axis]);
            assert!((0..3).all(is_held), "{corner}");
        }
        let lowest = vertices.iter().chain(&corners).map(|p| p.z + both.shift.z).fold(f64::INFINITY, f64::min);
        assert!(lowest.abs() < 1e-9 && low.z > -0.7 && low.z < 1e-9, "{lowest} {low}");
    }
    let nowhere = [[0.0; 3], [1.0, f64::NAN, 1.0]].map(Point3::from);
    assert!(matches!(alone.clone().beside(nowhere, u64::MAX), Err(GridError::Origin { .. })));
    let huge = [[0.0; 3], [1e9, 1.0, 1.0]].map(Point3::from);
    assert!(matches!(alone.clone().beside(huge, u64::MAX), Err(GridError::Dims { .. })));
    let large = [[0.0; 3], [700.0, 700.0, 1.0]].map(Point3::from);
    assert!(matches!(alone.beside(large, 1000), Err(GridError::Memory { .. })));
}
