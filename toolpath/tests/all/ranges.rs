//! Layers filled in ranges and put together: what one run gives, and ranges that are none.

use crate::common::grid;
use curvlay_toolpath::fill::{FillLayersError, fill_layers, fill_range, fill_rest};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{InfillOptions, PathOptions};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// A grid of quads bent upwards, `z` above the plate.
fn sheet(wide: f64, z: f64, bend: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let side = 9u32;
    let at = |k: u32| wide * f64::from(k) / f64::from(side - 1);
    let point = |k: u32| Point3::new(at(k % side), at(k / side), z + bend * (at(k % side) / wide - 0.5).powi(2));
    let quad = |k: u32| {
        let a = k % (side - 1) + side * (k / (side - 1));
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    ((0..side * side).map(point).collect(), (0..(side - 1) * (side - 1)).flat_map(quad).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Narrow layers above wide ones, some without a surface: the narrow ones keep short curves of the ones below. Solid and sparse, skins by
    /// what is above and below, in other pieces.
    #[test]
    fn ranges_put_together_are_one_run(
        sizes in prop::collection::vec((1.5..9.0f64, 0.0..2.0f64, 0..5u32), 2..7),
        cuts in prop::collection::vec(0..8usize, 0..3),
        left in 0..8usize,
        (density, walls, skin) in prop_oneof![Just((1.0, 3, 4)), (prop::sample::select(vec![0.0, 0.3]), 0..3u32, 0..3u32)],
    ) {
        let sheets: Vec<_> = (0..).zip(&sizes).map(|(k, &(wide, bend, there))| match there {
            0 => (Vec::new(), Vec::new()),
            _ => sheet(wide, 0.4 + 0.8 * f64::from(k), bend),
        }).collect();
        let thickness: Vec<Vec<f64>> = sheets.iter().map(|(_, triangles)| vec![0.8; triangles.len()]).collect();
        let surfaces: Vec<_> = sheets.iter().zip(&thickness).map(|((vertices, triangles), thickness)| LayerSurface {
            vertices, triangles, thickness, is_half: false,
        }).collect();
        let infill = InfillOptions { density, walls, skin, ..InfillOptions::default() };
        let (options, go) = (PathOptions { infill, ..PathOptions::default() }, |_| ControlFlow::Continue(()));
        let whole = fill_layers(&surfaces, &options, &go);
        prop_assume!(!matches!(whole, Err(FillLayersError::Layer { .. })));
        let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(surfaces.len())).chain([0, surfaces.len()]).collect();
        cuts.sort_unstable();
        let mut filled = Vec::new();
        for ends in cuts.windows(2) {
            filled.extend(fill_range(&surfaces, ends[0]..ends[1], &options, &go).unwrap());
        }
        prop_assert_eq!(filled.len(), surfaces.len());
        prop_assert_eq!(&fill_rest(&surfaces, filled.clone(), &options, &go), &whole);
        // What is not there is filled.
        filled.truncate(left);
        prop_assert_eq!(&fill_rest(&surfaces, filled, &options, &go), &whole);
    }
}

#[test]
fn ranges_that_are_none_are_refused() {
    let (vertices, triangles) = sheet(6.0, 0.4, 0.0);
    let thickness = vec![0.8; triangles.len()];
    let surfaces =
        [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &thickness, is_half: false }; 2];
    let (options, go) = (PathOptions::default(), |_| ControlFlow::Continue(()));
    #[allow(clippy::reversed_empty_ranges)]
    for (range, ends) in [(1..3, [1, 3]), (3..3, [3, 3]), (2..1, [2, 1])] {
        let error = fill_range(&surfaces, range, &options, &go).unwrap_err();
        assert_eq!(error, FillLayersError::Range { range: ends, layers: 2 });
    }
    assert_eq!(fill_range(&surfaces, 1..1, &options, &go), Ok(Vec::new()));
    let error = fill_rest(&surfaces, vec![None; 3], &options, &go).unwrap_err();
    assert_eq!(error, FillLayersError::Range { range: [0, 3], layers: 2 });
    let stop = |_| ControlFlow::Break(());
    assert_eq!(fill_range(&surfaces, 0..1, &options, &stop), Err(FillLayersError::Cancelled));
    let bad = [[0, 1, 999]];
    let broken = [surfaces[0], LayerSurface { triangles: &bad, ..surfaces[0] }];
    let error = fill_range(&broken, 1..2, &options, &go).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { layer: 1, .. }), "{error}");
}

/// Plates with a stub on which something lies in the end: its short curves are left out of a layer by itself, and come back. Then a sparse layer is
/// judged again by what is solid of it, wherever it was filled.
#[test]
fn short_curves_come_back_into_sparse_layers() {
    let plate = |(k, stub): (usize, usize)| {
        let there = move |i: usize, j: usize| i < 12 && j < 12 || j == 6 && i < 12 + stub;
        grid(24, 3, 0.0, move |i, j| !there(i, j), |p| Point3::new(p.x, p.y, 0.4 + 0.8 * k as f64))
    };
    let meshes: Vec<SurfaceMesh> = [3, 3, 3, 9].into_iter().enumerate().map(plate).collect();
    let thickness: Vec<Vec<f64>> = meshes.iter().map(|mesh| vec![0.8; mesh.triangles().len()]).collect();
    let each = meshes.iter().zip(&thickness);
    let surfaces: Vec<LayerSurface> =
        each.map(|(mesh, thickness)| (mesh.vertices(), mesh.triangles(), &thickness[..]).into()).collect();
    let infill = InfillOptions { density: 0.25, walls: 2, skin: 1, ..InfillOptions::default() };
    let options = PathOptions { infill, join_distance: 0.0, ..PathOptions::default() };
    let go = |_| ControlFlow::Continue(());
    let whole = fill_layers(&surfaces, &options, &go).unwrap();
    let mut filled = fill_range(&surfaces, 0..2, &options, &go).unwrap();
    filled.extend(fill_range(&surfaces, 2..4, &options, &go).unwrap());
    // What came back is in the figures.
    let layers =
        filled.iter().zip(&whole.layers).map(|(before, after)| [before, after].map(|layer| layer.as_ref().unwrap()));
    let back = layers.filter(|[before, after]| {
        let is_back = before.paths.short.len() > after.paths.short.len();
        is_back
            && after.sparse.area_mm2 > 10.0
            && after.statistics.covered_fraction > before.statistics.covered_fraction
    });
    assert_eq!(back.count(), 2);
    assert_eq!(fill_rest(&surfaces, filled, &options, &go).unwrap(), whole);
}
