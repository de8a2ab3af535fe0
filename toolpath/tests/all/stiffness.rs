//! Stiffness from a lay-up against closed forms, and against sums over thin slices.

use curvlay_toolpath::fiber::stiffness::{
    LayUp, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2,
};
use proptest::prelude::*;

fn bar(tapes: &[(f64, f64)]) -> LayUp {
    let tapes = tapes.iter().map(|&(at_mm, fiber_mm2)| TapeInSection { at_mm, fiber_mm2 }).collect();
    LayUp { width_mm: 10.0, height_mm: 5.0, matrix_gpa: 3.0, fiber_gpa: 230.0, tapes }
}

#[test]
fn closed_forms() {
    // A plain bar.
    let plain = bar(&[]);
    assert_eq!((plain.fiber_fraction(), plain.modulus_gpa(), plain.neutral_mm()), (Ok(0.0), Ok(3.0), Ok(2.5)));
    assert!((plain.rigidity_nm2().unwrap() - 3e9 * 0.010 * 0.005f64.powi(3) / 12.0).abs() < 1e-12);
    // Two tapes far out: Steiner.
    let sandwich = bar(&[(0.0, 0.25), (5.0, 0.25)]);
    let steiner = 3e9 * 0.010 * 0.005f64.powi(3) / 12.0 + 227e9 * 2.0 * 0.25e-6 * 0.0025f64.powi(2);
    assert!((sandwich.rigidity_nm2().unwrap() / steiner - 1.0).abs() < 1e-12);
    // One tape at the bottom: the neutral axis moves down by the first moments.
    let below = bar(&[(0.0, 0.5)]);
    let neutral = 3.0 * 50.0 * 2.5 / (3.0 * 49.5 + 230.0 * 0.5);
    assert!((below.neutral_mm().unwrap() - neutral).abs() < 1e-12);
    // P = 48 EI d / L^3.
    assert!(
        (three_point_rigidity_nm2(7.27, 200.0, 1.5).unwrap() - 7.27 * 0.2f64.powi(3) / (48.0 * 0.0015)).abs() < 1e-12
    );
    // A half ring whose ends slide: the integral of (1 - sin a)^2 up to a quarter turn is 3 pi / 4 - 2.
    let half = std::f64::consts::FRAC_PI_2 * (1.0 - 1e-9);
    let ring = arch_stiffness_n_mm(100.0, half, &[(half, 1.0)]).unwrap();
    let closed = 2.0 * 1e6 / (1e6 * (0.75 * std::f64::consts::PI - 2.0));
    assert!((ring / closed - 1.0).abs() < 1e-6, "{ring} {closed}");
    // Pieces of equal rigidity are one; a rigidity twice as high is a stiffness twice as high.
    let one = arch_stiffness_n_mm(60.0, 0.65, &[(0.65, 0.3)]).unwrap();
    let pieces = arch_stiffness_n_mm(60.0, 0.65, &[(0.1, 0.3), (0.4, 0.3), (0.65, 0.3)]).unwrap();
    let twice = arch_stiffness_n_mm(60.0, 0.65, &[(0.65, 0.6)]).unwrap();
    assert!((one / pieces - 1.0).abs() < 1e-12 && (twice / one - 2.0).abs() < 1e-12);
}

#[test]
fn what_has_no_stiffness() {
    let number = |what, value| Err(StiffnessError::Number { what, value });
    assert_eq!(LayUp { width_mm: 0.0, ..bar(&[]) }.modulus_gpa(), number("width_mm", 0.0));
    assert_eq!(LayUp { height_mm: -1.0, ..bar(&[]) }.rigidity_nm2(), number("height_mm", -1.0));
    let infinite = LayUp { matrix_gpa: f64::INFINITY, ..bar(&[]) };
    assert_eq!(infinite.neutral_mm(), number("matrix_gpa", f64::INFINITY));
    assert!(LayUp { fiber_gpa: f64::NAN, ..bar(&[]) }.fiber_fraction().is_err());
    for (at, area) in [(-0.1, 0.1), (5.1, 0.1), (1.0, -0.1), (f64::NAN, 0.1), (1.0, f64::NAN)] {
        let error = bar(&[(1.0, 0.1), (at, area)]).rigidity_nm2().unwrap_err();
        assert!(matches!(error, StiffnessError::Tape { tape: 1, .. }), "{error}");
    }
    assert_eq!(bar(&[(1.0, 50.0)]).modulus_gpa(), Err(StiffnessError::Full { fiber_mm2: 50.0, section_mm2: 50.0 }));
    assert_eq!(three_point_rigidity_nm2(1.0, 1.0, 0.0), number("deflection_mm", 0.0));
    assert!(arch_stiffness_n_mm(60.0, 1.6, &[(1.6, 1.0)]).is_err());
    assert_eq!(arch_stiffness_n_mm(60.0, 0.5, &[(0.5, 0.0)]), number("rigidity_nm2", 0.0));
    for pieces in [&[][..], &[(0.4, 1.0)], &[(0.6, 1.0)], &[(0.4, 1.0), (0.3, 1.0)]] {
        let error = arch_stiffness_n_mm(60.0, 0.5, pieces).unwrap_err();
        assert!(matches!(error, StiffnessError::Piece { .. }), "{error}");
    }
}

/// Thin slices of the section, each with its own mean modulus: axis and rigidity by plain sums.
fn slow_rigidity(bar: &LayUp) -> f64 {
    const SLICES: usize = 5000;
    let thin = bar.height_mm / SLICES as f64;
    let middle = |k: usize| (k as f64 + 0.5) * thin;
    let mut stiff: Vec<f64> = vec![bar.matrix_gpa * bar.width_mm * thin; SLICES];
    for tape in &bar.tapes {
        let at = ((tape.at_mm / thin) as usize).min(SLICES - 1);
        stiff[at] += (bar.fiber_gpa - bar.matrix_gpa) * tape.fiber_mm2;
    }
    let sum: f64 = stiff.iter().sum();
    let axis = stiff.iter().enumerate().map(|(k, s)| s * middle(k)).sum::<f64>() / sum;
    stiff.iter().enumerate().map(|(k, s)| s * (middle(k) - axis).powi(2)).sum::<f64>() * 1e-3
}

/// The crown's sinking by many pieces of the arch.
fn slow_arch(radius: f64, half: f64, pieces: &[(f64, f64)]) -> f64 {
    const CELLS: usize = 20_000;
    let cell = half / CELLS as f64;
    let sinking: f64 = (0..CELLS)
        .map(|k| {
            let angle = (k as f64 + 0.5) * cell;
            let rigidity = pieces.iter().find(|(end, _)| angle <= *end).unwrap().1;
            // Moment of a unit force over its rigidity, times the moment of a unit force, along the arc, on both sides.
            let moment = 0.5 * radius * (half.sin() - angle.sin());
            2.0 * moment * moment / (rigidity * 1e6) * radius * cell
        })
        .sum();
    1.0 / sinking
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn layered_beams_agree_with_slices(
        tapes in prop::collection::vec((0.0..=5.0f64, 0.0..0.4f64), 0..10),
        matrix in 0.5..5.0f64,
    ) {
        let bar = LayUp { matrix_gpa: matrix, ..bar(&tapes) };
        let (ours, slow) = (bar.rigidity_nm2().unwrap(), slow_rigidity(&bar));
        prop_assert!((ours / slow - 1.0).abs() < 2e-3, "{} {}", ours, slow);
        // More fibre is stiffer in tension, and never softer than the thermoplastic in bending.
        let plain = LayUp { tapes: Vec::new(), ..bar.clone() };
        prop_assert!(bar.modulus_gpa().unwrap() >= plain.modulus_gpa().unwrap());
        prop_assert!(ours >= plain.rigidity_nm2().unwrap() * (1.0 - 1e-12));
    }

    #[test]
    fn arches_agree_with_pieces(
        radius in 10.0..200.0f64,
        half in 0.1..1.5f64,
        cut in 0.05..0.95f64,
        rigidities in prop::array::uniform2(0.05..2.0f64),
    ) {
        let pieces = [(cut * half, rigidities[0]), (half, rigidities[1])];
        let (ours, slow) = (arch_stiffness_n_mm(radius, half, &pieces).unwrap(), slow_arch(radius, half, &pieces));
        prop_assert!((ours / slow - 1.0).abs() < 2e-3, "{} {}", ours, slow);
    }
}
