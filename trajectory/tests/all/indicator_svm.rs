//! The learned indicator: the dual against a slow solver and its optimality conditions, gradients, rates.

use crate::common::{Fixed, planar};
use curvlay_trajectory::indicator::svm::{Svm, SvmError, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, ContactFn, ContactSpace, Rates, Sample, SamplesError, SamplingOptions, project, random_samples,
    training_set, verification_samples,
};
use proptest::prelude::*;

/// Sixty points of a square; those in a disc collide, one in ten is labelled wrong.
fn fixed_data() -> Vec<Sample<2>> {
    let mut fixed = Fixed(2020);
    (0..60)
        .map(|_| {
            let joints = [4.0 * fixed.unit() - 2.0, 4.0 * fixed.unit() - 2.0];
            let wrong = fixed.unit() < 0.1;
            Sample { joints, collides: (joints[0] * joints[0] + joints[1] * joints[1] < 1.8) != wrong }
        })
        .collect()
}

fn kernel<const N: usize>(a: &[f64; N], b: &[f64; N], gamma: f64) -> f64 {
    (-gamma * a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()).exp()
}

fn sign<const N: usize>(sample: &Sample<N>) -> f64 {
    if sample.collides { 1.0 } else { -1.0 }
}

/// The dual by accelerated projected gradients (Y. Nesterov), restarted when the objective rises; the projection onto
/// box and plane by bisection of its multiplier. Slow, and shares nothing with the crate.
fn slow_objective<const N: usize>(samples: &[Sample<N>], gamma: f64, cost: f64, steps: usize) -> f64 {
    let n = samples.len();
    let y: Vec<f64> = samples.iter().map(sign).collect();
    let q = |i: usize, j: usize| y[i] * y[j] * kernel(&samples[i].joints, &samples[j].joints, gamma);
    let rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| q(i, j)).collect()).collect();
    let times =
        |a: &[f64]| -> Vec<f64> { rows.iter().map(|row| row.iter().zip(a).map(|(q, a)| q * a).sum()).collect() };
    let objective = |a: &[f64]| times(a).iter().zip(a).map(|(qa, a)| a * (0.5 * qa - 1.0)).sum::<f64>();
    let steepest = rows.iter().map(|row| row.iter().map(|q| q.abs()).sum::<f64>()).fold(0.0, f64::max);
    let onto = |a: &[f64]| -> Vec<f64> {
        let at = |m: f64| -> Vec<f64> { a.iter().zip(&y).map(|(a, y)| (a - m * y).clamp(0.0, cost)).collect() };
        let (mut low, mut high) = (-1e3 * (1.0 + cost), 1e3 * (1.0 + cost));
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let sum: f64 = at(middle).iter().zip(&y).map(|(a, y)| a * y).sum();
            if sum > 0.0 { low = middle } else { high = middle }
        }
        at(0.5 * (low + high))
    };
    let (mut a, mut ahead, mut momentum) = (vec![0.0; n], vec![0.0; n], 1.0f64);
    let mut value = objective(&a);
    for _ in 0..steps {
        let slope = times(&ahead);
        let moved: Vec<f64> = ahead.iter().zip(&slope).map(|(a, s)| a - (s - 1.0) / steepest).collect();
        let next = onto(&moved);
        let next_value = objective(&next);
        if next_value > value {
            (ahead, momentum) = (a.clone(), 1.0);
            continue;
        }
        let grown = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt());
        ahead = next.iter().zip(&a).map(|(next, a)| next + (momentum - 1.0) / grown * (next - a)).collect();
        (a, momentum, value) = (next, grown, next_value);
    }
    value
}

/// Made by `slow_objective(&fixed_data(), 0.7, 10.0, 400_000)`.
const REFERENCE: f64 = -160.319_857_457_810_5;

fn tight(cost: f64) -> SvmOptions {
    SvmOptions { cost, tolerance: 1e-10, ..SvmOptions::default() }
}

#[test]
fn dual_objective_is_the_stored_reference() {
    let svm = Svm::train(&fixed_data(), &tight(10.0)).unwrap();
    assert!(svm.training().converged);
    approx::assert_relative_eq!(svm.training().objective, REFERENCE, max_relative = 1e-9);
    // A hundredth of the steps shows where the reference came from.
    let slow = slow_objective(&fixed_data(), 0.7, 10.0, 20_000);
    approx::assert_relative_eq!(slow, REFERENCE, max_relative = 1e-6);
}

/// The largest violation of the optimality conditions, from the expansion alone.
fn violation<const N: usize>(svm: &Svm<N>, samples: &[Sample<N>], cost: f64) -> f64 {
    let expansion: Vec<([f64; N], f64)> = svm.expansion().collect();
    let mut left = expansion.iter().peekable();
    let mut worst = expansion.iter().map(|(_, a)| a).sum::<f64>().abs() / cost;
    for sample in samples {
        let value: f64 = expansion.iter().map(|(c, a)| a * kernel(c, &sample.joints, 0.7)).sum::<f64>() + svm.bias();
        let lead = sign(sample) * value - 1.0;
        // Kernels come in the order of the samples.
        let alpha = match left.peek() {
            Some((center, a))
                if center.map(f64::to_bits) == sample.joints.map(f64::to_bits) && a * sign(sample) > 0.0 =>
            {
                left.next();
                a.abs()
            }
            _ => 0.0,
        };
        let wrong = if alpha <= 0.0 {
            -lead
        } else if alpha >= cost {
            lead
        } else {
            lead.abs()
        };
        worst = worst.max(wrong);
    }
    assert_eq!(left.next(), None);
    worst
}

fn random_data() -> impl Strategy<Value = Vec<Sample<3>>> {
    let joints = proptest::array::uniform3(-1.5..1.5f64);
    proptest::collection::vec((joints, any::<bool>()), 2..50)
        .prop_map(|all| all.into_iter().map(|(joints, collides)| Sample { joints, collides }).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn optimality_conditions_hold_and_the_slow_solver_finds_nothing_lower(data in random_data(), cost in 0.1..50.0f64) {
        let options = SvmOptions { cost, tolerance: 1e-8, ..SvmOptions::default() };
        let Ok(svm) = Svm::train(&data, &options) else { return Ok(()) };
        prop_assert!(svm.training().converged);
        prop_assert!(violation(&svm, &data, cost) < 1e-7);
        let slow = slow_objective(&data, 0.7, cost, 2000);
        prop_assert!(svm.training().objective <= slow + 1e-7 * (1.0 + slow.abs()));
        // And the duality gap, with weights made from the expansion, says that no solution is lower.
        let expansion: Vec<_> = svm.expansion().collect();
        let square: f64 =
            expansion.iter().flat_map(|(c, a)| expansion.iter().map(move |(d, b)| a * b * kernel(c, d, 0.7))).sum();
        let slack: f64 = data.iter().map(|s| (1.0 - sign(s) * svm.value(&s.joints)).max(0.0)).sum();
        let primal = 0.5 * square + cost * slack;
        prop_assert!((primal + svm.training().objective).abs() < 1e-5 * (1.0 + primal), "{primal}");
    }

    #[test]
    fn gradient_is_that_of_the_value(data in random_data(), at in proptest::array::uniform3(-2.0..2.0f64)) {
        let Ok(svm) = Svm::train(&data, &SvmOptions::default()) else { return Ok(()) };
        let (value, gradient) = svm.gradient(&at);
        prop_assert!((value - svm.value(&at)).abs() < 1e-10 * (1.0 + value.abs()));
        let plain = svm.expansion().map(|(c, a)| a * kernel(&c, &at, 0.7)).sum::<f64>() + svm.bias();
        let size: f64 = svm.expansion().map(|(_, a)| a.abs()).sum::<f64>() + 1.0;
        prop_assert!((value - plain).abs() < 1e-12 * size);
        for j in 0..3 {
            let moved = |step: f64| { let mut q = at; q[j] += step; svm.value(&q) };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            prop_assert!((slope - gradient[j]).abs() < 1e-8 * size, "{slope} {}", gradient[j]);
        }
    }
}

#[test]
fn a_small_cache_changes_nothing() {
    let data = fixed_data();
    let large = Svm::train(&data, &SvmOptions::default()).unwrap();
    for cache_bytes in [0, 3 * 60 * 8, 20 * 60 * 8] {
        assert_eq!(Svm::train(&data, &SvmOptions { cache_bytes, ..SvmOptions::default() }).unwrap(), large);
    }
}

#[test]
fn few_steps_are_reported() {
    let svm = Svm::train(&fixed_data(), &SvmOptions { max_steps: 5, ..SvmOptions::default() }).unwrap();
    assert!(!svm.training().converged && svm.training().steps == 5 && svm.training().gap > 1e-3);
}

#[test]
fn repeated_and_contradicting_samples_are_learned_from() {
    let one = |collides| Sample { joints: [0.3, -0.2], collides };
    let svm = Svm::train(&[one(true), one(true), one(false)], &tight(5.0)).unwrap();
    assert!(svm.training().converged);
    assert!(svm.predicts(&[0.3, -0.2]));
    let even = Svm::train(&[one(true), one(false)], &tight(5.0)).unwrap();
    assert!(even.training().converged && even.value(&[0.3, -0.2]).abs() < 1e-9);
}

#[test]
fn a_shift_of_the_bias_is_added_to_the_value() {
    let (plain, shift) = (SvmOptions::default(), SvmOptions { bias_shift: 1.0, ..SvmOptions::default() });
    let data = fixed_data();
    let (plain, moved) = (Svm::train(&data, &plain).unwrap(), Svm::train(&data, &shift).unwrap());
    let at = [0.4, 0.9];
    approx::assert_abs_diff_eq!(moved.value(&at), plain.value(&at) + 1.0, epsilon = 1e-12);
    assert!((moved.value(&at) - plain.shifted(1.0).value(&at)).abs() < 1e-15);
}

#[test]
fn training_errors() {
    let at = |angle: f64, collides| Sample { joints: [angle], collides };
    let train = |samples: &[Sample<1>]| Svm::train(samples, &SvmOptions::default()).unwrap_err();
    assert_eq!(train(&[]), SvmError::OneKind { free: 0, colliding: 0 });
    assert_eq!(train(&[at(0.0, true)]), SvmError::OneKind { free: 0, colliding: 1 });
    let SvmError::NotFinite { sample: 1, joint: 0, value } = train(&[at(0.0, true), at(f64::NAN, false)]) else {
        panic!("not reported")
    };
    assert!(value.is_nan());
    let both = [at(0.0, true), at(1.0, false)];
    for (options, error) in [
        (SvmOptions { gamma: 0.0, ..Default::default() }, SvmError::Option { what: "gamma", value: 0.0 }),
        (SvmOptions { cost: -1.0, ..Default::default() }, SvmError::Option { what: "cost", value: -1.0 }),
        (SvmOptions { tolerance: 0.0, ..Default::default() }, SvmError::Option { what: "tolerance", value: 0.0 }),
        (SvmOptions { bias_shift: f64::INFINITY, ..Default::default() }, SvmError::BiasShift(f64::INFINITY)),
    ] {
        assert_eq!(Svm::train(&both, &options).unwrap_err(), error);
    }
}

/// Our samples against as many random ones, near the contact space and on it (section 4.4.3 and Table 4.1).
#[test]
fn planar_arm_is_learned_better_from_our_samples_than_from_random_ones() {
    let space = planar::space();
    let set = training_set(&space, &SamplingOptions { initial: 500, max_samples: 1698, ..Default::default() }).unwrap();
    for (sample, on_contact) in set.samples.iter().zip(&set.on_contact) {
        assert_eq!(sample.collides, planar::collides(&sample.joints));
        assert!(!on_contact || planar::gap(&sample.joints).abs() <= 1e-4);
    }
    let options = SvmOptions::default();
    let ours = Svm::train(&set.samples, &options).unwrap();
    let all = std::f64::consts::PI;
    let random = random_samples(&space, &[-all; 3], &[all; 3], set.samples.len(), 5).unwrap();
    let theirs = Svm::train(&random, &options).unwrap();
    println!(
        "{} samples, stages {:?}, kernels {} and {}",
        set.samples.len(),
        set.stages,
        ours.kernels(),
        theirs.kernels()
    );
    println!("{:?} {:?}", ours.training(), theirs.training());
    for (name, within) in [("near", 0.1), ("on", 0.0)] {
        let known = verification_samples(&space, 20_000, within, 9).unwrap();
        let (a, b) = (Rates::of(&ours, &known), Rates::of(&theirs, &known));
        println!("{name}: tnr {:?} hits {:?}, random {:?} {:?}", a.tnr(), a.hit_rate(), b.tnr(), b.hit_rate());
        assert!(a.tnr().unwrap() > b.tnr().unwrap() && a.hit_rate().unwrap() > b.hit_rate().unwrap());
        assert!(a.tnr().unwrap() > 0.88 && a.hit_rate().unwrap() > 0.93);
    }
}

#[test]
fn sampling_is_deterministic_and_keeps_its_distances() {
    let space = planar::space();
    let options = SamplingOptions { initial: 100, max_samples: 500, ..Default::default() };
    let set = training_set(&space, &options).unwrap();
    assert_eq!(training_set(&space, &options).unwrap(), set);
    assert_ne!(training_set(&space, &SamplingOptions { seed: 2, ..options }).unwrap(), set);
    let apart = |a: &Sample<3>, b: &Sample<3>| {
        a.joints.iter().zip(&b.joints).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    assert_eq!(set.stages[0], 100);
    for i in set.stages[0]..set.samples.len() {
        let nearest = set.samples[..i].iter().map(|s| apart(s, &set.samples[i])).fold(f64::INFINITY, f64::min);
        let threshold = if i < set.stages[1] { 0.4 } else { 0.025 };
        assert!(nearest > threshold - 1e-6, "{i}: {nearest}");
    }
}

/// Projections against a dense search of the contact space.
#[test]
fn projection_is_on_contact_and_nearest() {
    let mut fixed = Fixed(4);
    let space = ContactFn {
        collides: |_: &[f64; 2]| false,
        gap: |q: &[f64; 2]| (q[0] / 2.0).hypot(q[1]) - 1.0,
        sample: |_: &mut dyn FnMut() -> f64| None,
    };
    for _ in 0..200 {
        // Outside the ellipse the nearest point is the only one that the conditions of first order allow.
        let (turn, far) = (std::f64::consts::TAU * fixed.unit(), 1.0 + 2.0 * fixed.unit());
        let q = [2.0 * far * turn.cos(), far * turn.sin()];
        let at = project(&space, &q, 1e-9).unwrap();
        assert!(space.gap(&at).abs() < 1e-9);
        let on = |k: usize| {
            let turn = std::f64::consts::TAU * k as f64 / 100_000.0;
            (2.0 * turn.cos() - q[0]).hypot(turn.sin() - q[1])
        };
        let nearest = (0..100_000).map(on).fold(f64::INFINITY, f64::min);
        assert!((at[0] - q[0]).hypot(at[1] - q[1]) < nearest + 1e-5);
    }
    // In the middle there is no slope to follow.
    assert_eq!(project(&space, &[f64::NAN, 0.0], 1e-9), None);
    let flat = ContactFn { collides: space.collides, gap: |_: &[f64; 2]| 1.0, sample: space.sample };
    assert_eq!(project(&flat, &[0.0, 0.0], 1e-9), None);
}

#[test]
fn sampling_errors() {
    let never = ContactFn {
        collides: |_: &[f64; 2]| false,
        gap: |q: &[f64; 2]| q[0],
        sample: |_: &mut dyn FnMut() -> f64| None,
    };
    let options = SamplingOptions::default();
    let error = training_set(&never, &SamplingOptions { initial: 3, ..options }).unwrap_err();
    assert_eq!(error, SamplesError::OutOfReach { found: 0, wanted: 3, attempts: 600 });
    assert_eq!(
        verification_samples(&never, 2, 0.1, 1).unwrap_err(),
        SamplesError::OutOfReach { found: 0, wanted: 2, attempts: 400 }
    );
    for (options, name) in [
        (SamplingOptions { coarse: 0.0, ..options }, "coarse"),
        (SamplingOptions { fine: f64::NAN, ..options }, "fine"),
        (SamplingOptions { projected: 1.5, ..options }, "projected"),
        (SamplingOptions { coarse_share: -0.5, ..options }, "coarse_share"),
        (SamplingOptions { contact_tolerance: 0.0, ..options }, "contact_tolerance"),
        (SamplingOptions { initial: 0, ..options }, "initial"),
        (SamplingOptions { neighbours: 0, ..options }, "neighbours"),
        (SamplingOptions { max_samples: 0, ..options }, "max_samples"),
    ] {
        let error = training_set(&never, &options).unwrap_err();
        assert!(matches!(error, SamplesError::Option { what, .. } if what == name), "{error}");
    }
    assert!(matches!(verification_samples(&never, 2, -0.1, 1), Err(SamplesError::Option { what: "within", .. })));
    assert!(matches!(
        random_samples(&never, &[0.0, 1.0], &[1.0, 0.0], 2, 1),
        Err(SamplesError::Option { what: "high", .. })
    ));
}

#[test]
fn rates_of_nothing_are_none() {
    let rates = Rates::default();
    assert_eq!((rates.tnr(), rates.hit_rate(), rates.missed_rate(), rates.trust()), (None, None, None, None));
    let rates = Rates { free: 90, false_alarms: 10, hits: 15, missed: 5 };
    assert_eq!((rates.tnr(), rates.hit_rate(), rates.missed_rate()), (Some(0.9), Some(0.75), Some(0.25)));
    assert_eq!(rates.trust(), Some(90.0 / 95.0));
}
