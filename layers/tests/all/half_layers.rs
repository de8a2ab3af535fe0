//! Half layers: where a field rises slowly, one more surface lies between two.

use crate::common::go;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::LayerField;
use curvlay_layers::curved::{Guides, LayerSurfaces, Platform, Rules, Workpiece, cell_mesh};
use nalgebra::Point3;

const DIMS: [u32; 3] = [12, 4, 20];

/// How fast the field of the block rises above a column: a layer a cell on the left, 0.6 on the right.
fn rise(x: u32) -> f64 {
    1.0 - 0.4 * f64::from(x) / 11.0
}

/// The surfaces of a block of cells of 1 mm, whose field rises with `rise`, a layer of 1 mm.
fn surfaces(half_layers: Option<f64>) -> LayerSurfaces {
    let rows = vec![0xfff; (DIMS[1] * DIMS[2]) as usize];
    let cells = Cells::new(DIMS, &rows).unwrap();
    let value = |cell: u32| 0.5 + f64::from(cell / (DIMS[0] * DIMS[1])) * rise(cell % DIMS[0]);
    let field = LayerField::new(&cells, cells.iter().map(value).collect(), 1.0).unwrap();
    let field = field.with_half_layers(half_layers);
    let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin());
    let platform = Platform::under(&cells, 20.0).unwrap();
    let part = Workpiece {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        cells,
        cell_mm: 1.0,
        origin: Point3::origin(),
        platform: &platform,
        rules: Rules::default(),
        volume_mm3: 960.0,
        guides: Guides::default(),
    };
    part.surfaces(&field, &[], 1.0, &go).unwrap()
}

#[test]
fn they_lie_where_layers_are_too_thick() {
    let (plain, halved) = (surfaces(None), surfaces(Some(1.45)));
    assert!(plain.is_half.iter().all(|is_half| !is_half));
    // Layers without the half ones are as before.
    let whole = halved.sheets.iter().zip(&halved.is_half).filter(|(_, is_half)| !**is_half);
    assert!(whole.map(|(sheet, _)| &sheet.vertices).eq(plain.sheets.iter().map(|sheet| &sheet.vertices)));
    assert!(halved.heights_mm.is_sorted_by(|a, b| a < b));
    let halves: Vec<usize> = (0..halved.sheets.len()).filter(|&k| halved.is_half[k]).collect();
    assert!(halves.len() > 4, "{}", halves.len());
    for k in halves {
        // Half way between two whole ones.
        let [before, own, after] = [k - 1, k, k + 1].map(|k| halved.heights_mm[k]);
        assert!(!halved.is_half[k - 1] && !halved.is_half[k + 1] && (own - (before + after) / 2.0).abs() < 1e-9);
        // Layers are 1.45 heights apart from x = 9 on, higher up farther out, where the field slopes sideways as well.
        let left = halved.sheets[k].vertices.iter().map(|point| point.x).fold(f64::INFINITY, f64::min);
        assert!((6.5..11.0).contains(&left), "{left}");
        let right = halved.sheets[k].vertices.iter().map(|point| point.x).fold(0.0, f64::max);
        assert!((right - 12.0).abs() < 1e-9, "{right}");
    }
    // Beads share the space: no layer is thicker than the limit, but for a little beside the end of a half layer, and the volume is that of the block.
    let thickest = |surfaces: &LayerSurfaces| surfaces.thickness_mm.iter().flatten().copied().fold(0.0, f64::max);
    assert!(thickest(&plain) > 1.6 && thickest(&halved) < 1.5, "{} {}", thickest(&plain), thickest(&halved));
    assert!((halved.spacing.volume_mm3 - 960.0).abs() < 10.0, "{}", halved.spacing.volume_mm3);
}

#[test]
fn a_limit_below_a_layer_is_none() {
    for limit in [0.0, 0.99, f64::NAN, -1.0] {
        assert!(surfaces(Some(limit)).is_half.iter().all(|is_half| !is_half));
    }
}
