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
    let all =
        || (0..=sides[2]).flat_map(move |z| (0..=sides[1]).flat_map(move |y| (0..=sides[0]).map(move |x| [x, y, z])));
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
/// clamped at one end, with a force across at the other, bends by P L³ / 3 E I + P L / k G A. Within 1 % with 2 cells across and within 0.5 % with
/// 4. Poisson's ratio is 0, since a clamp that keeps the end from getting thinner is stiffer than that of the beam.
#[test]
fn a_cantilever_bends_as_timoshenko_says() {
    let young_mpa = 3500.0;
    let (length, depth, force) = (40.0, 4.0, 10.0);
    let (area, inertia) = (depth * depth, depth * depth * depth * depth / 12.0);
    let (coefficient, shear_modulus) = (10.0 / 12.0, young_mpa / 2.0);
    let known = force * length * length * length / (3.0 * young_mpa * inertia)
        + force * length / (coefficient * shear_modulus * area);
    let mut off = Vec::new();
    for (across, tolerance) in [(2, 0.01), (4, 0.005)] {
        let solid = Solid::new([10 * across, across, across], |_| true);
        let clamp = Support::fixed(Region::plane(0, 0.0));
        let push = Load::Force { region: Region::plane(0, length), newtons: [0.0, 0.0, -force] };
        let material = Material { young_mpa, poisson: 0.0 };
        let elastic = solid.solve(depth / f64::from(across), material, &[clamp], &[push]).unwrap();
        let end = elastic.displacement(solid.node([10 * across, across / 2, across / 2])).unwrap()[2];
        assert!((-end / known - 1.0).abs() < tolerance, "{across} cells across: {end} mm, known {known}");
        assert!(elastic.iterations < 40, "{} iterations", elastic.iterations);
        off.push((-end / known - 1.0).abs());
    }
    assert!(off[1] < off[0], "{off:?}");
}

/// G. Kirsch, "Die Theorie der Elasticität und die Bedürfnisse der Festigkeitslehre", Zeitschrift des VDI 42, 1898: a round hole in a wide plate
/// that is pulled by S. Across the hole the stress along the pull is S/2 (2 + a²/r² + 3 a⁴/r⁴): three times S at its edge. From a cell and a
/// half off the edge on within 10 % with a hole of 8 cells across its radius, and within 8 % with one of 16: its border is a staircase.
#[test]
fn a_hole_raises_the_stress_as_kirsch_says() {
    let kirsch = |share: f64| (2.0 + share.powi(2) + 3.0 * share.powi(4)) / 2.0;
    let worst = |radius: u32| {
        // A quarter of a plate of 14 radii.
        let side = 7 * radius;
        let from_middle = |[x, y, _]: [u32; 3]| (f64::from(x) + 0.5).hypot(f64::from(y) + 0.5);
        let solid = Solid::new([side, side, 1], |cell| from_middle(cell) > f64::from(radius));
        let held = |axis: usize| {
            let mut displacement_mm = [None; 3];
            displacement_mm[axis] = Some(0.0);
            Support { region: Region::plane(axis, 0.0), displacement_mm }
        };
        let pull = Load::Traction { region: Region::plane(0, f64::from(side)), mpa: [1.0, 0.0, 0.0] };
        let material = Material { young_mpa: 1000.0, poisson: 0.3 };
        let elastic = solid.solve(1.0, material, &[held(0), held(1), held(2)], &[pull]).unwrap();
        let off = |y: u32| {
            let stress = elastic.stress(solid.cells().id([0, y, 0])).unwrap()[0];
            (stress / kirsch(f64::from(radius) / (f64::from(y) + 0.5)) - 1.0).abs()
        };
        (radius + 1..3 * radius).map(off).fold(0.0, f64::max)
    };
    let off = [8, 16].map(worst);
    assert!(off[0] < 0.10 && off[1] < 0.08, "{off:?}");
}
