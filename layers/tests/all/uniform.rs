//! Uniform slicing against a walk down every column.

use curvlay_layers::cells::Cells;
use curvlay_layers::planar::{UniformSlicing, slice_uniformly};
use proptest::prelude::*;

/// A cell is built if all cells from z = 0 up to it are solid.
fn slow_slicing(cells: &Cells) -> UniformSlicing {
    let mut slow = UniformSlicing::default();
    let stands = |cell: u32| {
        let [x, y, z] = cells.position(cell);
        (0..=z).all(|below| cells.contains([x, y, below]))
    };
    for level in 0..cells.dims()[2] {
        let on_level: Vec<u32> = cells.iter().filter(|&cell| cells.position(cell)[2] == level).collect();
        let (built, missed): (Vec<u32>, Vec<u32>) = on_level.into_iter().partition(|&cell| stands(cell));
        if !built.is_empty() {
            slow.order.push(built);
        }
        slow.missed.extend(missed);
    }
    slow
}

/// Solids up to 150 cells wide (rows of three words). Many are full enough for tall columns.
fn solids() -> impl Strategy<Value = ([u32; 3], Vec<u64>)> {
    ([1u32..150, 1..4, 1..6], any::<u64>(), 1u64..8).prop_map(|(dims, seed, full)| {
        let [nx, ny, nz] = dims;
        let mut rows = vec![0; (nx.div_ceil(64) * ny * nz) as usize];
        let mut state = seed;
        for row in rows.chunks_mut(nx.div_ceil(64) as usize) {
            for x in 0..nx {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                row[x as usize / 64] |= u64::from(state >> 40 & 7 <= full) << (x % 64);
            }
        }
        (dims, rows)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn agrees_with_the_walk_down_every_column((dims, rows) in solids()) {
        let cells = Cells::new(dims, &rows).unwrap();
        let slicing = slice_uniformly(&cells);
        prop_assert_eq!(&slicing, &slow_slicing(&cells));
        let mut all = [slicing.order.cells(), &slicing.missed].concat();
        all.sort_unstable();
        prop_assert_eq!(all, cells.iter().collect::<Vec<_>>(), "every cell once");
    }
}

#[test]
fn a_block_is_all_layers() {
    let rows = [u64::MAX, 0b1111, u64::MAX, 0b1111, u64::MAX, 0b1111];
    let slicing = slice_uniformly(&Cells::new([68, 1, 3], &rows).unwrap());
    assert_eq!(slicing.order.iter().map(<[u32]>::len).collect::<Vec<_>>(), [68; 3]);
    assert!(slicing.missed.is_empty());
}

#[test]
fn what_stands_on_nothing_is_missed() {
    let nothing = slice_uniformly(&Cells::new([5, 2, 2], &[0; 4]).unwrap());
    assert_eq!(nothing, UniformSlicing::default());
    // Empty at the platform, or a gap half-way: all above it is missed.
    let floating = slice_uniformly(&Cells::new([2, 1, 3], &[0, 0b11, 0b11]).unwrap());
    assert!(floating.order.is_empty());
    assert_eq!(floating.missed, [2, 3, 4, 5]);
    let gap = slice_uniformly(&Cells::new([2, 1, 3], &[0b11, 0b10, 0b11]).unwrap());
    assert_eq!(gap.order.iter().collect::<Vec<_>>(), [&[0, 1][..], &[3], &[5]]);
    assert_eq!(gap.missed, [4]);
}
