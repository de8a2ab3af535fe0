//! Short curves: which are left out, and which stay since something lies on them.

use crate::common::{go_on, grid, plate_with_holes, to_boundary};
use curvlay_toolpath::fill::fill_layers;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{LayerPaths, PathOptions};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A plate of 8 by 8 mm at a height, with a stub 1 mm wide and some long.
fn plate(height: f64, stub: usize) -> SurfaceMesh {
    let there = move |i: usize, j: usize| i < 8 && j < 8 || j == 4 && i < 8 + stub;
    grid(20, 3, 0.0, move |i, j| !there(i, j), |p| Point3::new(p.x, p.y, height))
}

fn layers(meshes: &[SurfaceMesh], options: &PathOptions) -> Vec<LayerPaths> {
    let thickness: Vec<Vec<f64>> = meshes.iter().map(|mesh| vec![0.8; mesh.triangles().len()]).collect();
    let surfaces: Vec<LayerSurface> = meshes
        .iter()
        .zip(&thickness)
        .map(|(mesh, thickness)| (mesh.vertices(), mesh.triangles(), &thickness[..]).into())
        .collect();
    let filled = fill_layers(&surfaces, options, &go_on).unwrap();
    filled.layers.into_iter().map(|layer| layer.unwrap().paths).collect()
}

#[test]
fn what_nothing_lies_on_is_left_out() {
    // No joints: the bead of the stub would be one with the plate's.
    let options = PathOptions { join_distance: 0.0, ..PathOptions::default() };
    let below = || plate(0.4, 3);
    // Nothing above, nothing over the stub, and a bar that lies on it.
    let alone = layers(&[below()], &options);
    assert_eq!((alone[0].paths.len(), alone[0].short.len()), (1, 1));
    let aside = layers(&[below(), plate(1.2, 0)], &options);
    assert_eq!((aside[0].paths.len(), aside[0].short.len()), (1, 1));
    let over = layers(&[below(), plate(1.2, 9)], &options);
    assert_eq!((over[0].paths.len(), over[0].short.len()), (2, 0));
    // What lies on a short curve that is left out itself is no reason.
    let tower = layers(&[below(), plate(1.2, 3)], &options);
    assert!(tower.iter().all(|layer| (layer.paths.len(), layer.short.len()) == (1, 1)));
    // One that is short is carried all the same if it carries: from the top down.
    let tower = layers(&[below(), plate(1.2, 3), plate(2.0, 9)], &options);
    assert!(tower.iter().all(|layer| (layer.paths.len(), layer.short.len()) == (2, 0)));
    // Too far above to lie on it.
    let far = layers(&[below(), plate(3.0, 9)], &options);
    assert_eq!((far[0].paths.len(), far[0].short.len()), (1, 1));
    let all = layers(&[below()], &PathOptions { min_length: 0.0, ..options });
    assert_eq!((all[0].paths.len(), all[0].short.len()), (2, 0));
}

#[test]
fn figures_are_of_the_curves_that_stay() {
    let options = PathOptions { join_distance: 0.0, ..PathOptions::default() };
    let meshes = [plate(0.4, 3), plate(1.2, 9)];
    let thickness = meshes.each_ref().map(|mesh| vec![0.8; mesh.triangles().len()]);
    let surfaces: [LayerSurface; 2] =
        [0, 1].map(|k| (meshes[k].vertices(), meshes[k].triangles(), &thickness[k][..]).into());
    let [some, all] = [1, 2].map(|count| fill_layers(&surfaces[..count], &options, &go_on).unwrap());
    assert_eq!((some.totals().short_left, all.totals().short_left), (1, 0));
    assert!((1.0..4.0).contains(&some.totals().short_left_mm));
    let figures = |filled: &curvlay_toolpath::fill::FilledLayers| filled.layers[0].as_ref().unwrap().statistics.clone();
    let (some, all) = (figures(&some), figures(&all));
    assert_eq!((some.curves, all.curves), (1, 2));
    assert!(all.path_mm > some.path_mm + 1.0 && all.covered_fraction > some.covered_fraction + 0.01);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The longest curve of each part stays, and of the others those that are long enough.
    #[test]
    fn the_longest_of_each_part_stays(seed in 0u64..1000, least in 0.0..20.0, holes in prop::collection::vec(prop::bool::weighted(0.3), 144)) {
        let mesh = plate_with_holes(12, seed, holes);
        let distance = to_boundary(&mesh);
        let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
        let options = PathOptions { min_length: 0.0, min_gap: 0.0, ..PathOptions::default() };
        let all = field.paths(&options, &go_on).unwrap();
        let some = field.paths(&PathOptions { min_length: least, ..options }, &go_on).unwrap();
        prop_assert_eq!(all.paths.len(), some.paths.len() + some.short.len());
        let parts = mesh.regions();
        let mut longest: BTreeMap<u32, f64> = BTreeMap::new();
        let part = |path: &curvlay_toolpath::path::SurfacePath| parts.of_triangle[path.points[0].at.triangle as usize];
        for path in &all.paths {
            let longest = longest.entry(part(path)).or_default();
            *longest = longest.max(path.length());
        }
        prop_assert!(some.paths.iter().all(|path| path.length() >= least * 0.8 || path.length() >= longest[&part(path)]));
        prop_assert!(some.short.iter().all(|path| path.length() < least * 0.8));
        let kept: std::collections::BTreeSet<u32> = some.paths.iter().map(part).collect();
        prop_assert_eq!(kept.len(), longest.len());
    }
}
