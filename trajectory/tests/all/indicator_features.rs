//! Indicators of features, and samples that a machine had wrong: slopes against differences, rounds against a slow twin,
//! and what both are worth on an arm.

use crate::common::{Fixed, cell};
use curvlay_trajectory::indicator::svm::{Svm, SvmError, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, ContactFn, ContactSpace, Features, HardError, HardOptions, IndicatorFn, OnFeatures, Rates,
    Sample, SamplesError, SamplingOptions, TurnsAndGap, features_of, hard_samples, training_set, verification_samples,
};
use std::f64::consts::TAU;

/// Two links of 100 mm; the surface is the line y = 80.
fn arm() -> impl ContactSpace<2> + Copy {
    ContactFn {
        collides: |q: &[f64; 2]| q[1] < 0.0,
        gap: |q: &[f64; 2]| 100.0 * (q[0].sin() + (q[0] + q[1]).sin()) - 80.0,
        sample: |random: &mut dyn FnMut() -> f64| {
            // The outer link's direction is drawn, the inner one reaches the rest of the height.
            let outer = TAU * random();
            let inner = (0.8 - outer.sin()).clamp(-1.0, 1.0).asin();
            Some([inner, outer - inner])
        },
    }
}

#[test]
fn slopes_of_features_are_those_of_differences() {
    let features = TurnsAndGap { space: arm(), height: 3.0, near_mm: 20.0 };
    let mut fixed = Fixed(7);
    for _ in 0..200 {
        let joints = [TAU * fixed.unit(), TAU * fixed.unit()];
        let (at, slopes): ([f64; 5], [[f64; 5]; 2]) = features.slopes(&joints);
        assert_eq!(at.map(f64::to_bits), features.features(&joints).map(f64::to_bits));
        for (j, slope) in slopes.iter().enumerate() {
            let moved = |step: f64| -> [f64; 5] {
                let mut moved = joints;
                moved[j] += step;
                features.features(&moved)
            };
            for (d, (ahead, back)) in moved(1e-5).iter().zip(moved(-1e-5)).enumerate() {
                assert!((slope[d] - (ahead - back) / 2e-5).abs() < 1e-4, "{joints:?} {j} {d}");
            }
        }
    }
}

#[test]
fn features_are_circles_and_a_bent_gap() {
    let features = TurnsAndGap { space: arm(), height: 3.0, near_mm: 20.0 };
    let at: [f64; 5] = features.features(&[0.3, 0.9]);
    let gap = 100.0 * (0.3f64.sin() + 1.2f64.sin()) - 80.0;
    let bent = 3.0 * gap / (gap * gap + 400.0).sqrt();
    for (is, should) in at.iter().zip([0.3f64.cos(), 0.3f64.sin(), 0.9f64.cos(), 0.9f64.sin(), bent]) {
        assert!((is - should).abs() < 1e-12);
    }
    // Whole turns change nothing.
    let turned: [f64; 5] = features.features(&[0.3 - TAU, 0.9 + TAU]);
    assert!(at.iter().zip(turned).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn gradients_of_a_machine_over_features_are_those_of_differences() {
    let space = arm();
    let features = TurnsAndGap { space, height: 3.0, near_mm: 20.0 };
    let samples = verification_samples(&space, 200, 0.3, 5).unwrap();
    let svm: Svm<5> = Svm::train(&features_of(&features, &samples), &SvmOptions::default()).unwrap();
    let indicator = OnFeatures::new(svm.clone(), features);
    for Sample { joints, .. } in &samples[..50] {
        let (value, gradient) = indicator.gradient(joints);
        assert!((value - indicator.value(joints)).abs() < 1e-9);
        assert!((value - svm.value(&features.features(joints))).abs() < 1e-9);
        for j in 0..2 {
            let at = |step: f64| {
                let mut moved = *joints;
                moved[j] += step;
                indicator.value(&moved)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((gradient[j] - slope).abs() < 1e-3 * (1.0 + slope.abs()), "{joints:?} {j}");
        }
    }
}

/// Right of a straight line: a machine that does not learn, so that it is known which samples are the worst.
fn straight(samples: &[Sample<2>]) -> Result<impl CollisionIndicator<2> + use<>, SvmError> {
    let count = samples.len();
    let value = move |q: &[f64; 2]| q[0] - 1e-3 * count as f64;
    Ok(IndicatorFn { value, gradient: move |q: &[f64; 2]| (value(q), [1.0, 0.0]) })
}

/// As the crate says it, in the plainest way: the worst sample of the pool, again and again.
fn slow_rounds(space: &impl ContactSpace<2>, options: &HardOptions) -> Vec<Sample<2>> {
    let mut seed = options.seed;
    let mut draw = |count: usize, within: f64| {
        seed += 1;
        verification_samples(space, count, within, seed - 1).unwrap()
    };
    let mut samples = draw(options.initial, 0.0);
    samples.extend(draw(options.initial, options.within));
    for _ in 0..options.rounds {
        let machine = straight(&samples).unwrap();
        let mut pool = draw(options.pool - options.pool / 2, 0.0);
        pool.extend(draw(options.pool / 2, options.within));
        for _ in 0..options.added {
            let lead = |sample: &Sample<2>| machine.value(&sample.joints) * if sample.collides { 1.0 } else { -1.0 };
            let mut worst = 0;
            for k in 1..pool.len() {
                if lead(&pool[k]) < lead(&pool[worst]) {
                    worst = k;
                }
            }
            samples.push(pool.remove(worst));
        }
    }
    samples
}

#[test]
fn the_worst_samples_of_each_round_are_added() {
    let options = HardOptions { initial: 9, rounds: 3, added: 7, pool: 31, within: 0.2, seed: 40 };
    let found = hard_samples(&arm(), &options, &straight).unwrap();
    assert_eq!(found.samples, slow_rounds(&arm(), &options));
    assert_eq!((found.samples.len(), found.checked, found.wrong.len()), (18 + 21, 18 + 93, 3));
    let machine = straight(&found.samples).unwrap();
    assert_eq!(found.indicator.value(&[0.0, 0.0]).to_bits(), machine.value(&[0.0, 0.0]).to_bits());
    // Without rounds the first samples are all.
    let none = hard_samples(&arm(), &HardOptions { rounds: 0, ..options }, &straight).unwrap();
    assert_eq!((&none.samples[..], none.checked), (&found.samples[..18], 18));
}

#[test]
fn hard_samples_refuse_what_they_cannot_use() {
    let options = HardOptions::default();
    for (options, name) in [
        (HardOptions { initial: 0, ..options }, "initial"),
        (HardOptions { added: 0, ..options }, "added"),
        (HardOptions { pool: 199, ..options }, "pool"),
        (HardOptions { within: f64::NAN, ..options }, "within"),
        (HardOptions { within: 0.0, ..options }, "within"),
    ] {
        let Err(error) = hard_samples(&arm(), &options, &straight) else { panic!("{name}") };
        assert!(matches!(error, HardError::Samples(SamplesError::Option { what, .. }) if what == name), "{error}");
    }
    let free = ContactFn {
        collides: |_: &[f64; 2]| false,
        gap: |q: &[f64; 2]| q[1],
        sample: |random: &mut dyn FnMut() -> f64| Some([random(), 0.0]),
    };
    let train = |samples: &[Sample<2>]| Svm::train(samples, &SvmOptions::default());
    let Err(error) = hard_samples(&free, &options, &train) else { panic!() };
    let one_kind = SvmError::OneKind { free: 1000, colliding: 0 };
    assert_eq!(error, HardError::Training { round: 0, samples: 1000, error: one_kind });
    assert!(error.to_string().starts_with("round 0 with 1000 samples: 1000 free and 0 colliding samples"));
}

/// Near contact, at the dissertation's shift, joints alone miss a large part of the collisions; with the gap and hard samples
/// less than a tenth is missed, from as many samples.
#[test]
fn off_the_surface_the_gap_and_hard_samples_find_collisions() {
    let scene = cell::scene();
    let space = cell::contact(&scene);
    let near = verification_samples(&space, 1500, 0.05, 11).unwrap();
    let sampling = SamplingOptions { initial: 300, max_samples: 900, ..SamplingOptions::default() };
    let paper = training_set(&space, &sampling).unwrap().samples;
    let joints = Svm::train(&paper, &SvmOptions::default()).unwrap().shifted(1.0);
    let features = TurnsAndGap { space: &space, height: 3.0, near_mm: 1.0 };
    let train = |samples: &[Sample<6>]| {
        let svm: Svm<13> = Svm::train(&features_of(&features, samples), &SvmOptions::default())?;
        Ok(OnFeatures::new(svm, features))
    };
    let options = HardOptions { initial: 150, rounds: 6, added: 100, pool: 600, ..HardOptions::default() };
    let hard = hard_samples(&space, &options, &train).unwrap();
    assert_eq!(hard.samples.len(), 900);
    let gap = OnFeatures::new(hard.indicator.inner().clone().shifted(1.0), features);
    let rates = [Rates::of(&joints, &near), Rates::of(&gap, &near)];
    println!("joints {:?} {:?}", rates[0].tnr(), rates[0].missed_rate());
    println!("gap {:?} {:?}", rates[1].tnr(), rates[1].missed_rate());
    assert!(rates[1].missed_rate() < Some(0.1) && rates[1].missed_rate() < rates[0].missed_rate());
}
