//! What the tests of growth and of un-building share: small solids on platforms, drawn or at random.

use curvlay_hull::{ConvexHull, Depth};
use curvlay_layers::Progress;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{Neighbours, NozzleRule, Platform, Rules};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// The nozzle that the figures of these tests were found with: its tip flat is 1 mm wide, whatever the default is.
pub fn tip_1_mm() -> NozzleRule {
    NozzleRule { tip_flat_mm: 1.0, ..NozzleRule::default() }
}

/// The triangles of a box: corner `k` lies high along the axes of the bits of `k`.
pub const BOX: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

/// Never cancels.
pub fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A solid in a small grid, and a platform under it.
#[derive(Clone, Debug)]
pub struct Part {
    pub dims: [u32; 3],
    pub rows: Vec<u64>,
    pub platform: Platform,
}

impl Part {
    pub fn cells(&self) -> Cells<'_> {
        Cells::new(self.dims, &self.rows).unwrap()
    }

    /// The cells that stand on the platform.
    pub fn standing(&self) -> Vec<u32> {
        let cells = self.cells();
        let carried = |[x, y, _]: [i32; 3]| self.platform.carries([x, y], false);
        cells.iter().filter(|&cell| cells.position(cell)[2] == 0 && carried(centre(cells.position(cell)))).collect()
    }
}

/// The centre of a cell, in half cells.
pub fn centre([x, y, z]: [u32; 3]) -> [i32; 3] {
    [x, y, z].map(|c| 2 * c as i32 + 1)
}

/// The hull of the platform and the given cells, made afresh.
pub fn hull_of(part: &Part, rules: &Rules, built: impl IntoIterator<Item = u32>) -> ConvexHull {
    let depth = if rules.boundary_is_inside {
        Depth::new(2.0 * rules.inside_depth_cells)
    } else {
        Depth::beyond(2.0 * rules.inside_depth_cells)
    }
    .unwrap();
    let mut hull = ConvexHull::column(part.platform.corners(), part.platform.top(), depth).unwrap();
    let points: Vec<_> = built.into_iter().map(|cell| centre(part.cells().position(cell))).collect();
    hull.insert(&points).unwrap();
    hull
}

pub fn are_neighbours(cells: &Cells, a: u32, b: u32, rule: Neighbours) -> bool {
    let (a, b) = (cells.position(a), cells.position(b));
    let apart = [0, 1, 2].map(|k| a[k].abs_diff(b[k]));
    let norm: u32 = apart.iter().sum();
    (1..=2).contains(&norm) && (rule == Neighbours::OneNorm || apart.iter().all(|&d| d <= 1))
}

/// Which cells of a grid are there: bits from a simple generator, `solid` in 8.
pub fn random_rows(seed: u64, count: u32, nx: u32, solid: u64) -> Vec<u64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    (0..count).map(|_| (0..nx).fold(0, |row, x| row | u64::from(next() & 7 < solid) << x)).collect()
}

/// Random solids with holes, overhangs and loose pieces, on platforms that cover them, or not.
pub fn parts(dims: impl Strategy<Value = [u32; 3]>, solid: std::ops::Range<u64>) -> impl Strategy<Value = Part> {
    (dims, any::<u64>(), solid, any::<bool>()).prop_filter_map("stands", |(dims, seed, solid, small)| {
        let [nx, ny, nz] = dims;
        let size = if small { 2.0 } else { 12.0 };
        let platform = Platform::polygon(&[[-1.0, -1.0], [size, -1.0], [size, size], [-1.0, size]]).unwrap();
        let part = Part { dims, rows: random_rows(seed, ny * nz, nx, solid), platform };
        (!part.standing().is_empty()).then_some(part)
    })
}

pub fn rules() -> impl Strategy<Value = Rules> {
    let eps = prop::sample::select(vec![0.0, 0.3, 0.5, 1.0, 1.25, 2.0]);
    let neighbours = prop::sample::select(vec![Neighbours::FaceOrEdge, Neighbours::OneNorm]);
    (eps, any::<bool>(), neighbours).prop_map(|(eps, boundary_is_inside, neighbours)| Rules {
        inside_depth_cells: eps,
        boundary_is_inside,
        neighbours,
        flat: false,
    })
}
