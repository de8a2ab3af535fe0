//! The quality of layers against a flood fill that looks at all pairs.

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::{LayerQuality, Neighbours, SMALL_PATCH, layer_quality};
use proptest::prelude::*;

/// The patches of one layer: cells are merged as long as any two of different patches touch.
fn slow_patches(cells: &Cells, layer: &[u32], neighbours: Neighbours) -> Vec<usize> {
    let touch = |a: u32, b: u32| {
        let (a, b) = (cells.position(a), cells.position(b));
        let steps = [0, 1, 2].map(|k| a[k].abs_diff(b[k]));
        let norm: u32 = steps.iter().sum();
        norm <= 2 && (neighbours == Neighbours::OneNorm || steps.iter().all(|&step| step <= 1))
    };
    let mut label: Vec<usize> = (0..layer.len()).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for i in 0..layer.len() {
            for j in 0..layer.len() {
                if label[j] < label[i] && touch(layer[i], layer[j]) {
                    label[i] = label[j];
                    changed = true;
                }
            }
        }
    }
    let sizes = (0..layer.len()).map(|k| label.iter().filter(|&&l| l == k).count());
    sizes.filter(|&size| size > 0).collect()
}

#[test]
fn patches_at_the_limit_are_not_small() {
    let cells = Cells::new([60, 1, 3], &[(1 << 60) - 1; 3]).unwrap();
    let mut order = LayerOrder::new();
    order.push((0..20).chain(30..49)); // 20 cells and 19
    order.push([]);
    order.push([60, 121]); // joined over an edge
    let quality = layer_quality(&cells, &order, Neighbours::FaceOrEdge);
    assert_eq!((quality.layers, quality.patches), (3, 3));
    assert_eq!((quality.patches_per_layer, quality.small_patch_share), (1.0, 21.0 / 41.0));
    assert_eq!(quality.small_patch_cells, 21);
}

#[test]
fn nothing_repeated_cells_and_foreign_numbers_are_harmless() {
    let cells = Cells::new([4, 1, 1], &[0b1111]).unwrap();
    let none = layer_quality(&cells, &LayerOrder::new(), Neighbours::FaceOrEdge);
    assert_eq!(none, LayerQuality::default());
    let mut order = LayerOrder::new();
    order.push([0, 0, 7, u32::MAX]);
    order.push([1, 0]);
    let quality = layer_quality(&cells, &order, Neighbours::FaceOrEdge);
    assert_eq!((quality.patches, quality.small_patch_cells), (2, 2));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn agrees_with_the_slow_flood_fill(
        layer_of in proptest::collection::vec(0usize..3, 7 * 5 * 4),
        one_norm in any::<bool>(),
    ) {
        let neighbours = if one_norm { Neighbours::OneNorm } else { Neighbours::FaceOrEdge };
        let rows = [0b111_1111; 20];
        let cells = Cells::new([7, 5, 4], &rows).unwrap();
        let mut order = LayerOrder::new();
        let mut slow = LayerQuality { layers: 2, ..LayerQuality::default() };
        let mut in_all = 0;
        for number in 1..3 {
            let layer: Vec<u32> = (0..140).filter(|&cell| layer_of[cell as usize] == number).collect();
            for size in slow_patches(&cells, &layer, neighbours) {
                slow.patches += 1;
                slow.small_patch_cells += if size < SMALL_PATCH { size } else { 0 };
                in_all += size;
            }
            order.push(layer);
        }
        slow.patches_per_layer = slow.patches as f64 / 2.0;
        slow.small_patch_share = slow.small_patch_cells as f64 / f64::from(in_all.max(1) as u32);
        prop_assert_eq!(layer_quality(&cells, &order, neighbours), slow);
    }
}
