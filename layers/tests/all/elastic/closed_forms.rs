//! Displacements and stresses that are known.

use super::Solid;
use curvlay_layers::elastic::{Load, Material, Region, Support};

/// A linear displacement given at the border is linear inside, with one stress everywhere: to rounding.
#[test]
fn patch_test() {
    let solid = Solid::new([5, 4, 6], |_| true);
    let cell_mm = 0.7;
    let slope = [[1.0, 2.0, -0.5], [0.3, -1.5, 0.8], [-0.2, 0.6, 0.9]].map(|row| row.map(|k| k * 1e-3));
    let at = |node: [u32; 3]| slope.map(|row| (0..3).map(|k| row[k] * f64::from(node[k]) * cell_mm).sum::<f64>());
    let sides = solid.dims;
    let all = || (0..=sides[2]).flat_map(move |z| (0..=sides[1]).flat_map(move |y| (0..=sides[0]).map(move |x| [x, y, z])));
    let is_border = |node: &[u32; 3]| (0..3).any(|k| node[k] == 0 || node[k] == sides[k]);
    let support = |node: [u32; 3]| {
        let point = node.map(|k| f64::from(k) * cell_mm);
        Support { region: Region { low_mm: point, high_mm: point }, displacement_mm: at(node).map(Some) }
    };
    let supports: Vec<Support> = all().filter(is_border).map(support).collect();
    let material = Material { young_mpa: 2000.0, poisson: 0.3 };
    let elastic = solid.solve(cell_mm, material, &supports, &[]).unwrap();
    for node in all() {
        let found = elastic.displacement(solid.node(node)).unwrap();
        (0..3).for_each(|k| assert!((found[k] - at(node)[k]).abs() < 1e-11, "{node:?}: {found:?}"));
    }
    // Hooke's law.
    let strain = |i: usize, j: usize| (slope[i][j] + slope[j][i]) / 2.0;
    let (shear, trace) = (2000.0 / 2.6, strain(0, 0) + strain(1, 1) + strain(2, 2));
    let lambda = 2000.0 * 0.3 / (1.3 * 0.4);
    let pairs = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];
    let known = pairs.map(|[i, j]| 2.0 * shear * strain(i, j) + if i == j { lambda * trace } else { 0.0 });
    for stress in &elastic.stresses_mpa {
        (0..6).for_each(|k| assert!((stress[k] - known[k]).abs() < 1e-7, "{stress:?} {known:?}"));
    }
}

/// A part of any shape under a traction that one stress balances: here hydrostatic pressure on all outer faces of a solid with holes cannot
/// be given as one load, so a bar with a free side: pulled along x it gets thinner by Poisson's ratio.
#[test]
fn a_bar_that_is_pulled_gets_thinner() {
    let solid = Solid::new([7, 3, 2], |_| true);
    let material = Material { young_mpa: 1000.0, poisson: 0.25 };
    let held = |axis: usize| {
        let mut displacement_mm = [None; 3];
        displacement_mm[axis] = Some(0.0);
        Support { region: Region::plane(axis, 0.0), displacement_mm }
    };
    let pull = Load::Traction { region: Region::plane(0, 3.5), mpa: [8.0, 0.0, 0.0] };
    let elastic = solid.solve(0.5, material, &[held(0), held(1), held(2)], &[pull]).unwrap();
    let end = elastic.displacement(solid.node([7, 3, 2])).unwrap();
    let known = [0.008 * 3.5, -0.008 * 0.25 * 1.5, -0.008 * 0.25 * 1.0];
    (0..3).for_each(|k| assert!((end[k] - known[k]).abs() < 1e-9, "{end:?}"));
    assert!(elastic.stresses_mpa.iter().all(|stress| (stress[0] - 8.0).abs() < 1e-6 && stress[1].abs() < 1e-6));
}

/// The weight of a column that stands: sigma(z) = -w (h - z), at the centres exactly.
#[test]
fn a_column_carries_its_weight() {
    let solid = Solid::new([2, 2, 9], |_| true);
    let material = Material { young_mpa: 1000.0, poisson: 0.0 };
    let weight = Load::Body { newtons_mm3: [0.0, 0.0, -0.01] };
    let elastic = solid.solve(2.0, material, &[Support::fixed(Region::plane(2, 0.0))], &[weight]).unwrap();
    for (cell, stress) in elastic.cells.iter().zip(&elastic.stresses_mpa) {
        let centre = 2.0 * (f64::from(cell / 4) + 0.5);
        assert!((stress[2] + 0.01 * (18.0 - centre)).abs() < 1e-7, "{stress:?} at {centre}");
    }
}

/// S. P. Timoshenko, J. N. Goodier, *Theory of Elasticity*, and Cowper's shear coefficient (J. Appl. Mech. 33(2), 1966) for a rectangle: a beam
/// clamped at one end, with a force across at the other, bends by P L³ / 3 E I + P L / k G A. Within 2 % with 2 cells across, 0.5 % with
/// 4: without the inner modes of the cells it would be 12 % and 4 %.
#[test]
fn a_cantilever_bends_as_timoshenko_says() {
    let (young_mpa, poisson) = (3500.0, 0.3);
    let (length, width, depth, force) = (40.0, 4.0, 4.0, 10.0);
    let shear_modulus = young_mpa / (2.0 * (1.0 + poisson));
    let coefficient = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    let inertia = width * depth * depth * depth / 12.0;
    let known = force * length * length * length / (3.0 * young_mpa * inertia)
        + force * length / (coefficient * shear_modulus * width * depth);
    for (across, tolerance) in [(2, 0.02), (4, 0.005)] {
        let cell_mm = depth / f64::from(across);
        let solid = Solid::new([10 * across, across, across], |_| true);
        let clamp = Support::fixed(Region::plane(0, 0.0));
        let push = Load::Force { region: Region::plane(0, length), newtons: [0.0, 0.0, -force] };
        let material = Material { young_mpa, poisson };
        let elastic = solid.solve(cell_mm, material, &[clamp], &[push]).unwrap();
        let end = elastic.displacement(solid.node([10 * across, across / 2, across / 2])).unwrap()[2];
        assert!((-end / known - 1.0).abs() < tolerance, "{across} cells across: {end} mm, known {known}");
        assert!(elastic.iterations < 40, "{} iterations", elastic.iterations);
    }
}

/// G. Kirsch, "Die Theorie der Elasticität und die Bedürfnisse der Festigkeitslehre", Zeitschrift des VDI 42, 1898: a round hole in a wide plate
/// that is pulled by S. Across the hole the stress along the pull is S/2 (2 + a²/r² + 3 a⁴/r⁴): three times S at its edge. Within 8 % from a
/// cell and a half off the edge on, where it is 2.2 S: the hole is a staircase, and the plate is 12 radii wide.
#[test]
fn a_hole_raises_the_stress_as_kirsch_says() {
    // A quarter of the plate, 48 x 48 cells; the hole has a radius of 8.
    let radius = 8.0;
    let from_middle = |[x, y, _]: [u32; 3]| (f64::from(x) + 0.5).hypot(f64::from(y) + 0.5);
    let solid = Solid::new([48, 48, 1], |cell| from_middle(cell) > radius);
    let held = |axis: usize| {
        let mut displacement_mm = [None; 3];
        displacement_mm[axis] = Some(0.0);
        Support { region: Region::plane(axis, 0.0), displacement_mm }
    };
    let pull = Load::Traction { region: Region::plane(0, 48.0), mpa: [1.0, 0.0, 0.0] };
    let material = Material { young_mpa: 1000.0, poisson: 0.3 };
    let elastic = solid.solve(1.0, material, &[held(0), held(1), held(2)], &[pull]).unwrap();
    let mut largest: f64 = 0.0;
    for y in 9..24 {
        let stress = elastic.stress(solid.cells().id([0, y, 0])).unwrap()[0];
        let share = radius / (f64::from(y) + 0.5);
        let known = (2.0 + share.powi(2) + 3.0 * share.powi(4)) / 2.0;
        assert!((stress / known - 1.0).abs() < 0.08, "at {y}.5: {stress}, known {known}");
        largest = largest.max(stress);
    }
    assert!(largest > 2.0, "{largest}");
}
