//! The cells of each surface: every cell with a value is in the one list that its height says.

use curvlay_layers::curved::Cells;
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
        surfaces in 0usize..8,
        (layer_cells, height_mm, cell_mm) in (0.5..2.0f64, 0.3..3.0f64, 0.3..3.0f64),
    ) {
        let values: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(f64::NAN)).chain([0.5]).collect();
        let layers = field(&values, layer_cells).cells_by_surface(surfaces, height_mm, cell_mm).unwrap();
        prop_assert_eq!(layers.len(), surfaces.max(1));
        prop_assert!(layers.iter().all(|cells| cells.is_sorted()));
        for (cell, value) in values.iter().enumerate() {
            let found: Vec<usize> = (0..layers.len()).filter(|&layer| layers[layer].contains(&(cell as u32))).collect();
            if value.is_nan() {
                prop_assert!(found.is_empty());
                continue;
            }
            prop_assert_eq!(found.len(), 1);
            // The surface runs through the middle of what it stands for.
            let (above, last) = (value * layer_cells * cell_mm - found[0] as f64 * height_mm, layers.len() - 1);
            prop_assert!(above >= -1e-9 && (above <= height_mm + 1e-9 || found[0] == last));
        }
    }
}

#[test]
fn lengths_that_are_none() {
    let field = field(&[0.5], 1.0);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(field.cells_by_surface(1, wrong, 1.0), Err(FieldError::Thickness { .. })));
        assert!(matches!(field.cells_by_surface(1, 1.0, wrong), Err(FieldError::Thickness { .. })));
    }
    assert_eq!(field.cells_by_surface(0, 1.0, 1.0).unwrap(), [[0]]);
}
