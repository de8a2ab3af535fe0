//! An assembled stiffness and a dense solution, on small solids of any shape.

use super::Solid;
use crate::common::{go, random_rows};
use curvlay_layers::cells::Cells;
use curvlay_layers::elastic::{
    Elastic, ElasticOptions, ElasticPart, Load, Material, Region, Support, solve_elastic, supported_cells,
};
use curvlay_layers::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use proptest::prelude::*;

/// Gradients of the 8 shape functions and of the 3 inner ones at a place of a cube of edge `h` that reaches from -1 to 1.
fn gradients(at: [f64; 3], h: f64) -> Vec<Vector3<f64>> {
    let mut all = Vec::new();
    for corner in 0..8 {
        let s = [0, 1, 2].map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 });
        let f = [0, 1, 2].map(|k| 1.0 + s[k] * at[k]);
        all.push(Vector3::new(s[0] * f[1] * f[2], f[0] * s[1] * f[2], f[0] * f[1] * s[2]) / 8.0 * (2.0 / h));
    }
    all.extend((0..3).map(|k| Vector3::ith(k, -2.0 * at[k] * 2.0 / h)));
    all
}

/// The stiffness of a cube from the definition: for each pair of shape functions the integral of `block(a, b)`, of their gradients, and the inner ones taken out.
pub fn cube(block: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Matrix3<f64>, h: f64) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(33, 33);
    let point = (1.0f64 / 3.0).sqrt();
    for k in 0..8 {
        let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { point } else { -point });
        let slopes = gradients(at, h);
        for (m, a) in slopes.iter().enumerate() {
            for (n, b) in slopes.iter().enumerate() {
                let mut sum = all.view_mut((3 * m, 3 * n), (3, 3));
                sum += block(a, b) * (h / 2.0).powi(3);
            }
        }
    }
    let inner = all.view((24, 24), (9, 9)).clone_owned().try_inverse().unwrap();
    let mixed = all.view((0, 24), (24, 9)).clone_owned();
    all.view((0, 0), (24, 24)).clone_owned() - &mixed * inner * mixed.transpose()
}

/// Displacements of all nodes of the grid that are corners of cells, by dense elimination, under a force on each cubic millimetre. `cube` gives the stiffness of a cell.
pub fn slow(
    solid: &Solid,
    cells: &Cells,
    h: f64,
    cube: impl Fn(u32) -> DMatrix<f64>,
    force: Vector3<f64>,
) -> Vec<(u32, Vector3<f64>)> {
    let corners = |cell: u32| {
        let [x, y, z] = cells.position(cell);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k| solid.node([x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]))
    };
    let mut nodes: Vec<u32> = cells.iter().flat_map(corners).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let place = |node: u32| nodes.binary_search(&node).unwrap();
    let mut k = DMatrix::zeros(3 * nodes.len(), 3 * nodes.len());
    let mut f = DVector::zeros(3 * nodes.len());
    for cell in cells.iter() {
        let (at, cube) = (corners(cell).map(place), cube(cell));
        for (i, j) in (0..24).flat_map(|i| (0..24).map(move |j| (i, j))) {
            k[(3 * at[i / 3] + i % 3, 3 * at[j / 3] + j % 3)] += cube[(i, j)];
        }
        // Each cell hangs with an eighth of its load on each corner.
        for node in at {
            (0..3).for_each(|axis| f[3 * node + axis] += force[axis] * h.powi(3) / 8.0);
        }
    }
    // The nodes at z = 0 are fixed.
    let level = (solid.dims[0] + 1) * (solid.dims[1] + 1);
    for row in (0..nodes.len()).filter(|&at| nodes[at] < level).flat_map(|at| [3 * at, 3 * at + 1, 3 * at + 2]) {
        k.row_mut(row).fill(0.0);
        k.column_mut(row).fill(0.0);
        (k[(row, row)], f[row]) = (1.0, 0.0);
    }
    let u = k.lu().solve(&f).unwrap();
    nodes.iter().enumerate().map(|(at, &node)| (node, Vector3::new(u[3 * at], u[3 * at + 1], u[3 * at + 2]))).collect()
}

/// Displacements are those of the twin.
pub fn assert_same(elastic: &Elastic, known: &[(u32, Vector3<f64>)]) {
    let largest = known.iter().map(|(_, u)| u.amax()).fold(0.0, f64::max);
    assert_eq!(elastic.nodes.len(), known.len());
    for ((node, u), (at, found)) in known.iter().zip(elastic.nodes.iter().zip(&elastic.displacements_mm)) {
        assert_eq!(node, at);
        assert!((u - Vector3::from(*found)).amax() <= 1e-7 * largest, "{node}: {u:?} {found:?}");
    }
}

const H: f64 = 1.5;

fn fast(cells: &Cells, material: Material, force: [f64; 3]) -> Elastic {
    let part = ElasticPart {
        cells,
        cell_mm: H,
        material,
        supports: &[Support::fixed(Region::plane(2, 0.0))],
        loads: &[Load::Body { newtons_mm3: force }],
    };
    solve_elastic(&part, &ElasticOptions { tolerance: 1e-11, max_iterations: 2000 }, &go).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn agrees_with_the_assembled_twin(
        (nx, ny, nz) in (1u32..6, 1u32..5, 1u32..5),
        seed: u64,
        solid in 4u64..8,
        poisson in -0.3..0.45,
        force in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
    ) {
        let mut solid = Solid { dims: [nx, ny, nz], rows: random_rows(seed, ny * nz, nx, solid) };
        prop_assume!(solid.rows[..ny as usize].iter().any(|&row| row != 0));
        solid.rows = supported_cells(&solid.cells(), H, &[Support::fixed(Region::plane(2, 0.0))]).unwrap();
        let cells = solid.cells();
        let material = Material { young_mpa: 700.0, poisson };
        let elastic = fast(&cells, material, force);
        let Material { young_mpa: e, poisson: nu } = material;
        let (mu, lambda) = (e / 2.0 / (1.0 + nu), e * nu / (1.0 + nu) / (1.0 - 2.0 * nu));
        let block = |a: &Vector3<f64>, b: &Vector3<f64>| {
            lambda * a * b.transpose() + mu * (b * a.transpose() + Matrix3::identity() * a.dot(b))
        };
        let cube = cube(block, H);
        assert_same(&elastic, &slow(&solid, &cells, H, |_| cube.clone(), Vector3::from(force)));
    }
}

/// A part with several levels, some of it thin.
#[test]
fn any_number_of_threads_finds_the_same() {
    let is_solid = |[x, y, z]: [u32; 3]| z < 4 || (x / 3 + y / 3) % 2 == 0 && z < 9;
    let solid = Solid::new([17, 13, 9], is_solid);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fast(&solid.cells(), Material::default(), [0.1, 0.2, -0.3]))
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert!(one.iterations < 60, "{}", one.iterations);
}
