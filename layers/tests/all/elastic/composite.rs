//! Tapes in parts: closed forms of laminates, an assembled twin, and what comes apart.

use super::Solid;
use super::dense_twin::{assert_same, cube, slow};
use crate::common::{go, random_rows};
use curvlay_layers::cells::Cells;
use curvlay_layers::elastic::{
    Bond, Elastic, ElasticError, ElasticOptions, ElasticPart, Load, Material, Orthotropic, Ply, Region, Strip, Support,
    laminate, load_factor, plies, solve_composite, solve_elastic, supported_cells, traction,
};
use curvlay_layers::nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Point3, UnitVector3, Vector3};
use proptest::prelude::*;

const MATRIX: Material = Material { young_mpa: 1200.0, poisson: 0.3 };

/// Carbon in a polymer, of the order of textbook values; every constant differs from every other.
fn ply() -> Orthotropic {
    Orthotropic {
        young_mpa: [90_000.0, 6_000.0, 5_000.0],
        poisson: [0.31, 0.42, 0.27],
        shear_mpa: [3_000.0, 1_800.0, 2_500.0],
    }
}

/// Plies in all cells, all alike.
fn everywhere(cells: &Cells, direction: Vector3<f64>, share: f64) -> Vec<Ply> {
    cells.iter().map(|cell| Ply { cell, direction, normal: Vector3::z(), share }).collect()
}

fn solved(
    solid: &Solid,
    cell_mm: f64,
    tape: &Orthotropic,
    list: &[Ply],
    supports: &[Support],
    loads: &[Load],
) -> Elastic {
    let cells = solid.cells();
    let part = ElasticPart { cells: &cells, cell_mm, material: MATRIX, supports, loads };
    let options = ElasticOptions { tolerance: 1e-10, max_iterations: 3000 };
    solve_composite(&part, tape, list, &options, &go).unwrap()
}

/// A bar of plies at an angle to its axis, held at three points without constraint, pulled along x: the modulus of classical lamination theory.
#[test]
fn a_bar_at_an_angle_to_the_fibre() {
    let solid = Solid::new([12, 4, 3], |_| true);
    let mut moduli = Vec::new();
    for degrees in [0.0, 10.0, 30.0, 45.0, 60.0, 90.0f64] {
        let angle = degrees.to_radians();
        let list = everywhere(&solid.cells(), Vector3::new(angle.cos(), angle.sin(), 0.0), 1.0);
        // Six displacements are held: no more than rigid motion.
        let at = |point: [f64; 3], displacement_mm: [Option<f64>; 3]| Support {
            region: Region { low_mm: point, high_mm: point },
            displacement_mm,
        };
        let (held, free) = (Some(0.0), None);
        let supports = [
            at([0.0, 0.0, 0.0], [held; 3]),
            at([12.0, 0.0, 0.0], [free, held, held]),
            at([0.0, 4.0, 0.0], [free, free, held]),
        ];
        // Pulled at both ends.
        let pull = |x: f64, mpa: f64| Load::Traction { region: Region::plane(0, x), mpa: [mpa, 0.0, 0.0] };
        let elastic = solved(&solid, 1.0, &ply(), &list, &supports, &[pull(12.0, 10.0), pull(0.0, -10.0)]);
        for stress in &elastic.stresses_mpa {
            assert!((stress[0] - 10.0).abs() < 1e-5 && stress[1..].iter().all(|k| k.abs() < 1e-5), "{stress:?}");
        }
        let [near, far] = [0, 12].map(|x| elastic.displacement(solid.node([x, 2, 1])).unwrap()[0]);
        let modulus = 10.0 * 12.0 / (far - near);
        assert!((modulus / ply().modulus_at(angle) - 1.0).abs() < 1e-6, "{degrees}: {modulus}");
        moduli.push(modulus);
    }
    assert!((moduli[0] - 90_000.0).abs() < 1.0 && (moduli[5] - 6_000.0).abs() < 0.1);
}

/// Four-point strains of a beam: a cantilever with tapes near its faces bends as the theory of layered beams says.
#[test]
fn a_laminated_beam_bends_as_layered_beam_theory_says() {
    let solid = Solid::new([60, 2, 6], |_| true);
    let cells = solid.cells();
    // Tapes fill a fifth of the outermost cells.
    let is_outer = |cell: &u32| [0, 5].contains(&cells.position(*cell)[2]);
    let list: Vec<Ply> = everywhere(&cells, Vector3::x(), 0.2).into_iter().filter(|ply| is_outer(&ply.cell)).collect();
    let tape = Orthotropic::tape(&MATRIX, 100_000.0, 0.5);
    let force = 3.0;
    let supports = [Support::fixed(Region::plane(0, 0.0))];
    let load = Load::Force { region: Region::plane(0, 60.0), newtons: [0.0, 0.0, -force] };
    let elastic = solved(&solid, 1.0, &tape, &list, &supports, &[load]);
    let sag = -elastic.displacement(solid.node([60, 1, 3])).unwrap()[2];
    // EI layer by layer; plane sections stay plane.
    let outer = 0.2 * tape.young_mpa[0] + 0.8 * MATRIX.young_mpa;
    let layer = |z: f64, e: f64| e * 2.0 * (1.0 / 12.0 + z * z);
    let rigidity = 2.0 * (layer(2.5, outer) + layer(1.5, MATRIX.young_mpa) + layer(0.5, MATRIX.young_mpa));
    // The core shears: the faces carry the moment, so all of its height carries the force.
    let shear = MATRIX.young_mpa / 2.6;
    let known = force * 60f64.powi(3) / (3.0 * rigidity) + force * 60.0 / (shear * 2.0 * 5.0);
    assert!((sag / known - 1.0).abs() < 0.03, "{sag} {known}");
    // Without tapes it is far softer.
    let plain = solved(&solid, 1.0, &tape, &[], &supports, &[load]);
    assert!(-plain.displacement(solid.node([60, 1, 3])).unwrap()[2] > 4.0 * sag);
}

/// The shear between tape and thermoplastic in a bent beam: `V S / (I b)` weighted by moduli, at the inner face of the tapes.
#[test]
fn the_bond_of_a_bent_beam_bears_shear_as_jourawski_says() {
    let solid = Solid::new([60, 2, 6], |_| true);
    let cells = solid.cells();
    let list = everywhere(&cells, Vector3::x(), 0.2)
        .into_iter()
        .filter(|ply| [0, 5].contains(&cells.position(ply.cell)[2]))
        .collect::<Vec<_>>();
    let tape = Orthotropic::tape(&MATRIX, 100_000.0, 0.5);
    let supports = [Support::fixed(Region::plane(0, 0.0))];
    let load = Load::Force { region: Region::plane(0, 60.0), newtons: [0.0, 0.0, -3.0] };
    let elastic = solved(&solid, 1.0, &tape, &list, &supports, &[load]);
    let outer = 0.2 * tape.young_mpa[0] + 0.8 * MATRIX.young_mpa;
    let layer = |z: f64, e: f64| e * 2.0 * (1.0 / 12.0 + z * z);
    let rigidity = 2.0 * (layer(2.5, outer) + layer(1.5, MATRIX.young_mpa) + layer(0.5, MATRIX.young_mpa));
    // In the middle of the core, where all of the upper half is above.
    let static_moment = 2.0 * (outer * 2.5 + MATRIX.young_mpa * (1.5 + 0.5));
    let known = 3.0 * static_moment / (rigidity * 2.0);
    let cell = cells.id([30, 0, 2]);
    let [_, shear] = traction(&elastic.stress(cell).unwrap(), &Vector3::z());
    assert!((shear / known - 1.0).abs() < 0.05, "{shear} {known}");
}

/// The four-index tensor of a law in other axes, from the definition.
fn tensor(law: &Matrix6<f64>, axes: [Vector3<f64>; 3]) -> impl Fn(usize, usize, usize, usize) -> f64 {
    const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let law = *law;
    move |i, j, k, l| {
        let mut sum = 0.0;
        for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            for (c, d) in (0..3).flat_map(|c| (0..3).map(move |d| (c, d))) {
                sum += axes[a][i] * axes[b][j] * axes[c][k] * axes[d][l] * law[(PLACE[a][b], PLACE[c][d])];
            }
        }
        sum
    }
}

/// A cube with every component of the tensor: `C_ijkl a_j b_l` for gradients `a` and `b`.
fn cube_of(c: impl Fn(usize, usize, usize, usize) -> f64, h: f64) -> DMatrix<f64> {
    let table: Vec<f64> = (0..81).map(|n| c(n / 27, n / 9 % 3, n / 3 % 3, n % 3)).collect();
    let component = |a: &Vector3<f64>, b: &Vector3<f64>, i: usize, p: usize| -> f64 {
        let pairs = (0..3).flat_map(|j| (0..3).map(move |q| (j, q)));
        pairs.map(|(j, q)| table[27 * i + 9 * j + 3 * p + q] * a[j] * b[q]).sum()
    };
    cube(|a, b| Matrix3::from_fn(|i, p| component(a, b, i, p)), h)
}

const H: f64 = 1.5;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    /// Cells with tapes in any direction, on solids of any shape: as an assembled matrix and a dense solution have it.
    #[test]
    fn agrees_with_the_assembled_twin(
        (nx, ny, nz) in (1u32..5, 1u32..4, 1u32..4),
        seed: u64,
        turns in prop::collection::vec((-3.1..3.1f64, -1.0..1.0f64, 0.0..1.0f64), 48),
    ) {
        let mut solid = Solid { dims: [nx, ny, nz], rows: random_rows(seed, ny * nz, nx, 6) };
        prop_assume!(solid.rows[..ny as usize].iter().any(|&row| row != 0));
        let plate = [Support::fixed(Region::plane(2, 0.0))];
        solid.rows = supported_cells(&solid.cells(), H, &plate).unwrap();
        let cells = solid.cells();
        let axes = |(turn, lean, _): (f64, f64, f64)| {
            let normal = Vector3::new(lean, 0.3 * lean, 1.0).normalize();
            let flat = Vector3::new(turn.cos(), turn.sin(), 0.0);
            let along = (flat - normal * flat.dot(&normal)).normalize();
            [along, normal.cross(&along), normal]
        };
        // Every second cell has a ply.
        let with: Vec<(u32, (f64, f64, f64))> = cells.iter().zip(turns.iter().cycle().copied()).step_by(2).collect();
        let share = |turn: (f64, f64, f64)| 0.05 + 0.95 * turn.2;
        let list: Vec<Ply> = with
            .iter()
            .map(|&(cell, turn)| Ply { cell, direction: axes(turn)[0] * 3.0, normal: axes(turn)[2] * 0.5, share: share(turn) })
            .collect();
        let force = [0.3, -0.2, 0.5];
        let part = ElasticPart {
            cells: &cells, cell_mm: H, material: MATRIX, supports: &plate, loads: &[Load::Body { newtons_mm3: force }],
        };
        let options = ElasticOptions { tolerance: 1e-11, max_iterations: 3000 };
        let elastic = solve_composite(&part, &ply(), &list, &options, &go).unwrap();

        let plain = Orthotropic::isotropic(&MATRIX).law().unwrap();
        let unturned = cube_of(tensor(&plain, [Vector3::x(), Vector3::y(), Vector3::z()]), H);
        let of_cell = |cell: u32| match with.iter().find(|(other, _)| *other == cell) {
            Some(&(_, turn)) => cube_of(tensor(&laminate(&ply().law().unwrap(), &plain, share(turn)), axes(turn)), H),
            None => unturned.clone(),
        };
        assert_same(&elastic, &slow(&solid, &cells, H, of_cell, Vector3::from(force)));
    }

    /// The laminate of two laws is what a stack of many thin sheets of both does: here two sheets, solved for strains and stresses one by one.
    #[test]
    fn a_laminate_is_a_stack(share in 0.01..0.99f64, strain in prop::array::uniform6(-1.0..1.0f64)) {
        let a = ply().law().unwrap();
        let b = Orthotropic { young_mpa: [2000.0, 3000.0, 1000.0], shear_mpa: [700.0, 500.0, 900.0], poisson: [0.2, 0.3, 0.1] };
        let b = b.law().unwrap();
        // Unknown: strains across of both sheets. Stresses across are equal, and the strains have the given mean.
        let (along, across) = ([0, 1, 3], [2, 4, 5]);
        let mut m: DMatrix<f64> = DMatrix::zeros(6, 6);
        let mut r: DVector<f64> = DVector::zeros(6);
        for i in 0..3 {
            for j in 0..3 {
                m[(i, j)] = a[(across[i], across[j])];
                m[(i, j + 3)] = -b[(across[i], across[j])];
                r[i] += (b[(across[i], along[j])] - a[(across[i], along[j])]) * strain[along[j]];
            }
            m[(i + 3, i)] = share;
            m[(i + 3, i + 3)] = 1.0 - share;
            r[i + 3] = strain[across[i]];
        }
        let x = m.lu().solve(&r).unwrap();
        let sheet = |k: usize| {
            let mut all = DVector::from_row_slice(&strain);
            (0..3).for_each(|i| all[across[i]] = x[3 * k + i]);
            all
        };
        let (sa, sb) = (DMatrix::from_column_slice(6, 6, a.as_slice()) * sheet(0), DMatrix::from_column_slice(6, 6, b.as_slice()) * sheet(1));
        let mean = sa * share + sb * (1.0 - share);
        let law = laminate(&a, &b, share);
        let found = DMatrix::from_column_slice(6, 6, law.as_slice()) * DVector::from_row_slice(&strain);
        prop_assert!((&mean - &found).amax() <= 1e-9 * mean.amax().max(1.0), "{mean} {found}");
    }

    /// Volume stays, and its centre too, as long as there are cells all around.
    #[test]
    fn strips_keep_volume_and_centre(
        from in prop::array::uniform3(4.0..6.0f64), way in prop::array::uniform3(-2.0..2.0f64), width in 0.1..2.0f64,
    ) {
        let way = Vector3::from(way);
        prop_assume!(way.norm() > 0.1 && way.cross(&Vector3::z()).norm() > 0.1);
        let normal = UnitVector3::new_normalize(way.cross(&way.cross(&Vector3::z())));
        let solid = Solid::new([10; 3], |_| true);
        let points = [Point3::from(from), Point3::from(from) + way];
        let strip = Strip { points: &points, normals: &[normal; 2], width_mm: width, thickness_mm: 0.1 };
        let found = plies(&solid.cells(), 1.0, &Point3::origin(), &[strip]).unwrap();
        prop_assert!((found.tape_mm3 - way.norm() * width * 0.1).abs() < 1e-9 && found.lost_mm3 <= 0.0);
        let volume: f64 = found.list.iter().map(|ply| ply.share).sum();
        prop_assert!((volume - found.tape_mm3).abs() < 1e-9);
        let centre = found.list.iter().map(|ply| {
            Vector3::from(solid.cells().position(ply.cell).map(|k| f64::from(k) + 0.5)) * ply.share
        });
        let centre = centre.sum::<Vector3<f64>>() / volume;
        let known = points[0].coords + way * 0.5 + normal.into_inner() * 0.05;
        prop_assert!((centre - known).norm() < 1e-9, "{centre} {known}");
        prop_assert!(found.list.iter().all(|ply| ply.direction.normalize().cross(&way.normalize()).norm() < 1e-9));
    }
}

/// Without plies, and with plies of the material itself, all is as without fibre.
#[test]
fn plies_of_the_material_itself_change_nothing() {
    let solid = Solid::new([4, 3, 5], |[x, y, _]| x != 1 || y != 1);
    let supports = [Support::fixed(Region::plane(2, 0.0))];
    let loads = [Load::Body { newtons_mm3: [0.1, 0.2, -0.3] }];
    let cells = solid.cells();
    let part = ElasticPart { cells: &cells, cell_mm: 1.0, material: MATRIX, supports: &supports, loads: &loads };
    let options = ElasticOptions { tolerance: 1e-10, max_iterations: 1000 };
    let plain = solve_elastic(&part, &options, &go).unwrap();
    assert_eq!(solve_composite(&part, &ply(), &[], &options, &go).unwrap(), plain);
    let itself = solve_composite(
        &part,
        &Orthotropic::isotropic(&MATRIX),
        &everywhere(&cells, Vector3::new(1.0, 2.0, 0.0), 0.4),
        &options,
        &go,
    );
    for (a, b) in itself.unwrap().displacements_mm.iter().zip(&plain.displacements_mm) {
        (0..3).for_each(|k| assert!((a[k] - b[k]).abs() < 1e-8));
    }
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let solid = Solid::new([17, 13, 9], |[x, y, z]| z < 4 || (x / 3 + y / 3).is_multiple_of(2) && z < 9);
    let cells = solid.cells();
    let turned = |ply: Ply| Ply {
        direction: Vector3::new((0.1 * f64::from(ply.cell)).cos(), (0.1 * f64::from(ply.cell)).sin(), 0.0),
        ..ply
    };
    let list: Vec<Ply> = everywhere(&cells, Vector3::x(), 0.1).into_iter().step_by(3).map(turned).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            solved(
                &solid,
                1.0,
                &ply(),
                &list,
                &[Support::fixed(Region::plane(2, 0.0))],
                &[Load::Body { newtons_mm3: [0.1, 0.2, -0.3] }],
            )
        })
    };
    let one = run(1);
    assert_eq!(one, run(4));
    assert!(one.iterations < 150, "{}", one.iterations);
}

#[test]
fn what_is_refused() {
    let solid = Solid::new([2, 2, 2], |[x, ..]| x == 0);
    let cells = solid.cells();
    let supports = [Support::fixed(Region::plane(2, 0.0))];
    let part = ElasticPart {
        cells: &cells,
        cell_mm: 1.0,
        material: MATRIX,
        supports: &supports,
        loads: &[Load::Body { newtons_mm3: [1.0; 3] }],
    };
    let refused = |tape: &Orthotropic, list: &[Ply]| {
        solve_composite(&part, tape, list, &ElasticOptions::default(), &go).unwrap_err()
    };
    let good = Ply { cell: 0, direction: Vector3::x(), normal: Vector3::z(), share: 0.5 };
    for bad in [
        Ply { cell: 1, ..good },
        Ply { cell: 8, ..good },
        Ply { share: 0.0, ..good },
        Ply { share: 1.1, ..good },
        Ply { share: f64::NAN, ..good },
        Ply { direction: Vector3::z(), ..good },
        Ply { normal: Vector3::zeros(), ..good },
        Ply { direction: Vector3::repeat(f64::NAN), ..good },
    ] {
        assert_eq!(refused(&ply(), &[good, bad]), ElasticError::Ply { ply: 1 }, "{bad:?}");
    }
    let soft = Orthotropic { young_mpa: [90_000.0, 0.0, 5_000.0], ..ply() };
    let wide = Orthotropic { poisson: [5.0, 0.3, 0.3], ..ply() };
    for tape in [soft, wide, Orthotropic { shear_mpa: [f64::INFINITY; 3], ..ply() }] {
        assert_eq!(refused(&tape, &[good]), ElasticError::Orthotropic);
        assert!(tape.law().is_none());
    }
    let points = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
    let strip = Strip { points: &points, normals: &[Vector3::z_axis(); 2], width_mm: 1.0, thickness_mm: 0.1 };
    let endless = [Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0)];
    for bad in [
        Strip { points: &points[..1], ..strip },
        Strip { normals: &[], ..strip },
        Strip { width_mm: 0.0, ..strip },
        Strip { thickness_mm: f64::INFINITY, ..strip },
        Strip { points: &endless, ..strip },
    ] {
        assert_eq!(plies(&cells, 1.0, &Point3::origin(), &[strip, bad]), Err(ElasticError::Strip { strip: 1 }));
    }
    assert_eq!(plies(&cells, 0.0, &Point3::origin(), &[]), Err(ElasticError::Cell { cell_mm: 0.0 }));
    // A strip beside the part is lost, and reported.
    let far = [Point3::new(50.0, 0.0, 0.0), Point3::new(51.0, 0.0, 0.0)];
    let found = plies(&cells, 1.0, &Point3::origin(), &[Strip { points: &far, ..strip }]).unwrap();
    assert!(found.list.is_empty() && (found.lost_mm3 - found.tape_mm3).abs() < 1e-12);
}

#[test]
fn bonds() {
    let bond = Bond { peel_mpa: 8.0, shear_mpa: 4.0 };
    let stress = [1.0, 2.0, 3.0, -1.0, 0.5, 2.0];
    for factor in [0.5, 3.0] {
        let more = stress.map(|k| factor * k);
        assert!((bond.index(&more, &Vector3::z()) - factor * bond.index(&stress, &Vector3::z())).abs() < 1e-12);
    }
    assert!(load_factor(&[], 0.1).is_infinite());
    assert!(load_factor(&[(0.0, 3.0)], 0.1).is_infinite());
    assert!((load_factor(&[(2.0, 1.0), (4.0, 1.0)], 0.0) - 0.25).abs() < 1e-12);
}
