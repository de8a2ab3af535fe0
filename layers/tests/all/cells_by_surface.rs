//! The cells of each surface: every cell with a value is with the surface that is nearest.

use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{FieldError, LayerField};
use proptest::prelude::*;

fn field(values: &[f64], layer_cells: f64) -> LayerField {
    let rows = vec![1; values.len()];
    LayerField::new(&Cells::new([1, 1, values.len() as u32], &rows).unwrap(), values.to_vec(), layer_cells).unwrap()
}

proptest! {
    #[test]
    fn each_cell_is_where_its_height_is(
        values in prop::collection::vec(prop::option::weighted(0.8, 0.0..9.0f64), 1..60),
        steps in prop::collection::vec(0.3..3.0f64, 0..8),
        (layer_cells, cell_mm) in (0.5..2.0f64, 0.3..3.0f64),
    ) {
        let values: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(f64::NAN)).chain([0.5]).collect();
        let mut top = 0.0;
        let heights_mm: Vec<f64> = steps.iter().map(|step| { top += step; top }).collect();
        let layers = field(&values, layer_cells).cells_by_surface(&heights_mm, cell_mm).unwrap();
        prop_assert_eq!(layers.len(), heights_mm.len().max(1));
        prop_assert!(layers.iter().all(|cells| cells.is_sorted()));
        for (cell, value) in values.iter().enumerate() {
            let found: Vec<usize> = (0..layers.len()).filter(|&layer| layers[layer].contains(&(cell as u32))).collect();
            if value.is_nan() {
                prop_assert!(found.is_empty());
                continue;
            }
            prop_assert_eq!(found.len(), 1);
            // No surface is nearer.
            let far = |height_mm: &f64| (value * layer_cells * cell_mm - height_mm).abs();
            let nearest = heights_mm.iter().map(far).fold(f64::INFINITY, f64::min);
            prop_assert!(heights_mm.is_empty() || far(&heights_mm[found[0]]) <= nearest + 1e-9);
        }
    }
}

#[test]
fn lengths_that_are_none() {
    let field = field(&[0.5], 1.0);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(field.cells_by_surface(&[1.0], wrong), Err(FieldError::Thickness { .. })));
    }
    assert_eq!(field.cells_by_surface(&[], 1.0).unwrap(), [[0]]);
}
