//! Layers filled in ranges and put together: what one run gives, and ranges that are none.

use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::surface::{FillLayersError, LayerSurface, PathOptions, fill_layers, fill_range, fill_rest};
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
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Narrow layers above wide ones, some without a surface: the narrow ones keep short curves of the ones below.
    #[test]
    fn ranges_put_together_are_one_run(
        sizes in prop::collection::vec((1.5..9.0f64, 0.0..2.0f64, 0..5u32), 2..7),
        cuts in prop::collection::vec(0..8usize, 0..3),
        left in 0..8usize,
    ) {
        let sheets: Vec<_> = (0..).zip(&sizes).map(|(k, &(wide, bend, there))| match there {
            0 => (Vec::new(), Vec::new()),
            _ => sheet(wide, 0.4 + 0.8 * f64::from(k), bend),
        }).collect();
        let thickness: Vec<Vec<f64>> = sheets.iter().map(|(_, triangles)| vec![0.8; triangles.len()]).collect();
        let surfaces: Vec<_> = sheets.iter().zip(&thickness).map(|((vertices, triangles), thickness)| LayerSurface {
            vertices, triangles, thickness,
        }).collect();
        let (options, go) = (PathOptions::default(), |_| ControlFlow::Continue(()));
        let whole = fill_layers(&surfaces, &options, &go);
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
    let surfaces = [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &thickness }; 2];
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
