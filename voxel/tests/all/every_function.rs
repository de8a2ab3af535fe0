//! Every public function takes any input: not finite, far out, none, mismatched. The names are read from the sources, so a new function that
//! is not fed here fails.

use curvlay_voxel::inspect::{inspect, thinner_than, without_area};
use curvlay_voxel::nalgebra::Point3;
use curvlay_voxel::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

/// Public functions, as `file name`: the tests below feed each.
const FED: [&str; 38] = [
    "distance.rs distance",
    "distance.rs nearest",
    "distance.rs new",
    "grid.rs cell_mm",
    "grid.rs centre",
    "grid.rs contains",
    "grid.rs count",
    "grid.rs dims",
    "grid.rs from_cells",
    "grid.rs from_fn",
    "grid.rs from_rows",
    "grid.rs id",
    "grid.rs is_empty",
    "grid.rs iter",
    "grid.rs origin",
    "grid.rs placed",
    "grid.rs position",
    "grid.rs row",
    "grid.rs rows",
    "grid.rs words_per_row",
    "implicit.rs from_implicit",
    "inspect/inspection.rs inspect",
    "inspect/inspection.rs without_area",
    "inspect/report.rs is_sound",
    "inspect/report.rs size_mm",
    "inspect/report.rs volume_mm3",
    "inspect/thin.rs thinner_than",
    "neighbours.rs neighbours",
    "neighbours.rs offsets",
    "orient/doubt.rs doubts",
    "orient/mod.rs orient",
    "polygon.rs triangulate_polygon",
    "polygonise.rs polygonise",
    "polygonise.rs relax",
    "solid.rs beside",
    "text.rs read_text_grid",
    "text.rs write_text_grid",
    "voxelise.rs voxelise",
];

/// Panics that are documented.
const PANICS: [(&str, &str); 3] = [
    ("grid.rs row", "outside the grid there is no row, as with a slice"),
    ("grid.rs id", "cells outside the grid have no numbers"),
    ("polygonise.rs relax", "the fields of the mesh are open: a corner that is not there is a bug of who set it"),
];

/// `file name` of each `pub fn`.
fn public_functions(root: &Path, folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            public_functions(root, &path, found);
            continue;
        }
        let file = path.strip_prefix(root).unwrap().display().to_string().replace('\\', "/");
        for line in std::fs::read_to_string(&path).unwrap().lines().map(str::trim_start) {
            let name = line.strip_prefix("pub fn ").or_else(|| line.strip_prefix("pub const fn "));
            if let Some(name) = name.and_then(|rest| rest.split(['(', '<']).next()) {
                found.insert(format!("{file} {name}"));
            }
        }
    }
}

#[test]
fn every_public_function_is_fed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = BTreeSet::new();
    public_functions(&root, &root, &mut found);
    let fed: BTreeSet<String> = FED.map(String::from).into();
    assert_eq!(fed, found, "feed new functions in this file and name them in FED");
    let text = include_str!("every_function.rs");
    for name in FED.map(|entry| entry.split_once(' ').unwrap().1) {
        assert!(text.contains(&format!("{name}(")), "{name} is named but not called");
    }
    for (entry, _) in PANICS {
        let (file, name) = entry.split_once(' ').unwrap();
        let source = std::fs::read_to_string(root.join(file)).unwrap();
        let before = source.split(&format!("pub fn {name}(")).next().unwrap();
        let docs: Vec<&str> =
            before.lines().rev().map(str::trim).skip(1).take_while(|line| line.starts_with("///")).collect();
        assert!(docs.contains(&"/// # Panics"), "{entry} does not say when it panics");
    }
}

/// Numbers of every kind, small whole ones the most.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-3..=3i32).prop_map(f64::from),
        3 => -5.0..5.0f64,
        2 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
        2 => prop::sample::select(vec![1e300, -1e300, f64::MAX, 1e15, -1e9, 1e-300, f64::MIN_POSITIVE, -0.0]),
    ]
}

fn point() -> impl Strategy<Value = Point3<f64>> {
    // Most points are sound, or no mesh would be.
    prop_oneof![
        9 => [-3..=3i32, -3..=3i32, 0..=3i32].prop_map(|at| Point3::from(at.map(f64::from))),
        1 => [number(), number(), number()].prop_map(Point3::from),
    ]
}

fn mesh() -> impl Strategy<Value = (Vec<Point3<f64>>, Vec<[u32; 3]>)> {
    let any = (prop::collection::vec(point(), 0..7), prop::collection::vec([0..8u32, 0..8u32, 0..8u32], 0..12));
    let tetrahedron =
        prop::collection::vec(point(), 4).prop_map(|points| (points, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]));
    prop_oneof![1 => any, 1 => tetrahedron]
}

fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

const MAX_BYTES: u64 = 1 << 14;

fn feed_grid(grid: &VoxelGrid, cell: [u32; 3], at: Point3<f64>) {
    let [nx, ny, nz] = grid.dims();
    assert_eq!(grid.rows().len(), grid.words_per_row() * ny as usize * nz as usize);
    assert_eq!((grid.iter().count(), grid.is_empty()), (grid.count(), grid.count() == 0));
    let is_inside = cell[0] < nx && cell[1] < ny && cell[2] < nz;
    assert!(is_inside || !grid.contains(cell));
    if is_inside {
        assert_eq!(grid.position(grid.id(cell)), cell);
        assert_eq!(grid.row(cell[1], cell[2]).len(), grid.words_per_row());
    }
    grid.position(cell[0]);
    grid.centre(cell);
    for by in [Connectivity::Face6, Connectivity::Edge18, Connectivity::Vertex26] {
        assert!(grid.neighbours(cell, by).count() <= by.offsets().len());
    }
    if let Ok(placed) = grid.clone().placed(at.x, at) {
        assert!(placed.cell_mm() > 0.0 && placed.origin() == at);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn grids_take_anything(
        dims in [0..70u32, 0..4u32, 0..4u32], huge in prop::sample::select(vec![0, 1, 1 << 16, u32::MAX]),
        cells in prop::collection::vec([0..70u32, 0..4u32, 0..4u32], 0..9), cell in (any::<u32>(), 0..5u32, 0..5u32).prop_map(|(x, y, z)| [x, y, z]), at in [number(), number(), number()],
    ) {
        let at = Point3::from(at);
        for dims in [dims, [huge, dims[1], dims[2]], [huge; 3], [1, huge, huge]] {
            let words = (dims[0].div_ceil(64) as usize).saturating_mul(dims[1] as usize).saturating_mul(dims[2] as usize);
            let given = [VoxelGrid::from_rows(dims, vec![u64::MAX; words.min(64)]), VoxelGrid::from_rows(dims, vec![1; 3])];
            for grid in given.into_iter().flatten() {
                feed_grid(&grid, cell, at);
            }
            if words < 1 << 12 {
                for grid in [VoxelGrid::from_cells(dims, cells.clone()), VoxelGrid::from_fn(dims, |cell| cell[0] % 2 == 1)].into_iter().flatten() {
                    feed_grid(&grid, cell, at);
                }
            } else if words > 1 << 30 {
                prop_assert!(VoxelGrid::from_cells(dims, []).is_err() && VoxelGrid::from_fn(dims, |_| false).is_err());
            }
        }
    }

    #[test]
    fn meshes_take_anything((vertices, triangles) in mesh(), numbers in [number(), number(), number()], at in point(), count in prop::sample::select(vec![0, 1, 40, u64::MAX])) {
        let [size, x, y] = numbers;
        let resolutions = [Resolution::Cell(size), Resolution::Cell(0.5), Resolution::Count(count), Resolution::At { cell_mm: size, corner: [x, y] }];
        for resolution in resolutions {
            let options = VoxelOptions { resolution, max_bytes: MAX_BYTES };
            if let Ok(solid) = voxelise(&vertices, &triangles, &options, &go) {
                feed_grid(&solid.grid, [0; 3], at);
                let _ = solid.clone().beside([at, Point3::new(x, y, size)], MAX_BYTES);
                let _ = solid.beside([Point3::new(x, y, size), at], u64::MAX);
            }
        }
        if let Ok(oriented) = orient(&vertices, &triangles) {
            prop_assert_eq!(oriented.triangles.len(), triangles.len());
            oriented.report.doubts(size);
        }
        let _ = without_area(&vertices, &triangles);
        let _ = thinner_than(&vertices, &triangles, size);
        if let Ok(report) = inspect(&vertices, &triangles) {
            let _ = (report.volume_mm3(), report.size_mm(), report.is_sound());
        }
        if let Ok(surface) = BoundaryDistance::new(&vertices, &triangles) {
            for at in [at, Point3::new(x, y, size)] {
                prop_assert_eq!(surface.distance(&at).is_nan(), surface.nearest(&at).is_none());
            }
        }
        if let Ok(cut) = triangulate_polygon(&vertices) {
            prop_assert!(cut.iter().flatten().all(|&corner| corner < vertices.len()));
        }
    }

    #[test]
    fn functions_take_anything(
        low in [number(), number(), number()], high in [number(), number(), number()], numbers in [number(), number(), number()], samples in prop::sample::select(vec![0, 1, 2, 65, u32::MAX]),
    ) {
        let [cell_mm, lipschitz, value] = numbers;
        let bounds = [low, high].map(Point3::from);
        let half = |at: &Point3<f64>| if at.x > 0.0 { f64::NAN } else { at.y };
        for kind in 0..3 {
            let f = |at: &Point3<f64>| [at.coords.norm() - 2.0, value, half(at)][kind];
            for cell_mm in [cell_mm, 1.0] {
                for lipschitz in [None, Some(lipschitz)] {
                    let options = ImplicitOptions { cell_mm, samples, lipschitz, max_bytes: 1 << 8 };
                    let _ = VoxelGrid::from_implicit(bounds, &options, f, &go);
                }
                // As fine as it may be it is only slow.
                let is_small = (0..3).all(|k| (high[k] - low[k]) / cell_mm < 50.0);
                if is_small && let Ok(mut surface) = polygonise(|at| f(&at), bounds[0], bounds[1], cell_mm) {
                    surface.relax(|at| f(&at), 2);
                }
            }
        }
        let _ = polygonise(|_| value, bounds[0], bounds[1], 1e-300);
    }

    #[test]
    fn texts_take_anything(text in "[01x \n\t-]{0,60}", any in prop::collection::vec(any::<u8>(), 0..60), platform in prop::collection::vec((any::<u32>(), 0..4u32).prop_map(|(x, y)| [x, y]), 0..4), flat: bool) {
        for text in [text.as_bytes(), &any] {
            let Ok(read) = read_text_grid(text) else { continue };
            let mut written = Vec::new();
            write_text_grid(&read, &mut written).unwrap();
            prop_assert_eq!(read_text_grid(&written[..]).unwrap(), read);
        }
        let grid = VoxelGrid::from_fn([3, 2, 2], |_| true).unwrap();
        let _ = write_text_grid(&TextGrid { grid, platform, flat }, Vec::new());
    }
}
