//! Table 4.1: indicators that are learned, and the geometric one, against the exact scene.

use super::amount::Amount;
use super::surface::Surface;
use curvlay_examples::args::Failure;
use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, HardOptions, OnFeatures, Rates, Sample, SamplingOptions, TurnsAndGap, features_of,
    hard_samples, random_samples, training_set, verification_samples,
};
use std::time::Instant;

/// How far from the contact space near samples are, in radians.
const NEAR: f64 = 0.05;
/// Seeds: of the postures that indicators are measured with, near and on contact, and of random samples.
const VERIFIED: [u64; 2] = [11, 12];
const RANDOM: u64 = 3;
/// Postures whose evaluation is timed, and how often.
const TIMED: usize = 2000;
const RUNS: usize = 15;

/// What the dissertation adds to the bias of its machines.
pub const PAPER_SHIFT: f64 = 1.0;

/// Rounds of samples that the machine over features had wrong, and how many random postures a round takes for each.
const HARD_ROUNDS: usize = 10;
const POOL: usize = 6;
/// Its last feature: three kernels (1.2 wide each) from contact to far away, most of it within a millimetre, which is
/// about a layer. With 2 to 6, and with 2 mm, rates change by a few hundredths.
const GAP_HEIGHT: f64 = 3.0;
const GAP_NEAR_MM: f64 = 1.0;

/// One indicator in Table 4.1; no rate where there was nothing to count.
pub struct Row {
    pub name: &'static str,
    /// Eq. 4.16, near the contact space and on it.
    pub tnr: [Option<f64>; 2],
    /// Share of collisions that are not predicted.
    pub missed: [Option<f64>; 2],
    /// What was added to the bias after learning.
    pub bias_shift: f64,
    /// 0 for one that does not learn.
    pub kernels: usize,
    pub samples: usize,
    /// Postures that were checked exactly to find the samples.
    pub checked: usize,
    /// Value and gradient.
    pub evaluation_us: f64,
}

/// Postures that indicators are measured with.
pub struct Known {
    near: Vec<Sample<6>>,
    on: Vec<Sample<6>>,
}

impl Known {
    pub fn new(space: &Surface<'_>, count: usize) -> Result<Self, Failure> {
        let [near, on] = VERIFIED;
        Ok(Known {
            near: verification_samples(space, count, NEAR, near)?,
            on: verification_samples(space, count, 0.0, on)?,
        })
    }

    /// How many there are near and on contact, and how many of them collide.
    pub fn counts(&self) -> [[usize; 2]; 2] {
        [&self.near, &self.on].map(|all| [all.len(), all.iter().filter(|sample| sample.collides).count()])
    }

    pub fn row(&self, name: &'static str, indicator: &dyn CollisionIndicator<6>) -> Row {
        let rates = [&self.near, &self.on].map(|samples| Rates::of(indicator, samples));
        let timed = &self.near[..self.near.len().min(TIMED)];
        let seconds = |_| {
            let start = Instant::now();
            let sum: f64 = timed.iter().map(|sample| indicator.gradient(&sample.joints).0).sum();
            std::hint::black_box(sum);
            start.elapsed().as_secs_f64()
        };
        let least = (0..RUNS).map(seconds).fold(f64::INFINITY, f64::min);
        Row {
            name,
            tnr: rates.map(|rates| rates.tnr()),
            missed: rates.map(|rates| rates.missed_rate()),
            bias_shift: 0.0,
            kernels: 0,
            samples: 0,
            checked: 0,
            evaluation_us: 1e6 * least / timed.len().max(1) as f64,
        }
    }
}

/// Features of a posture: joints as points on circles, and the gap.
pub type Turns<'a> = TurnsAndGap<&'a Surface<'a>>;
/// The machine over features.
pub type OnGap<'a> = OnFeatures<Svm<13>, Turns<'a>, 13>;

/// How many kernels, samples and exact checks there are.
type Count = (usize, usize, usize);

/// What was learned, with the shift of the dissertation: that by Algorithm 7, and that over features.
#[derive(Default)]
pub struct Machines<'a> {
    pub paper: Option<Svm<6>>,
    pub gap: Option<OnGap<'a>>,
}

/// Trains the machines, each measured as it is and shifted; what was not trained is a note.
pub fn learn<'a>(
    space: &'a Surface<'a>,
    known: &Known,
    amount: Amount,
    (rows, notes): (&mut Vec<Row>, &mut Vec<String>),
) -> Result<Machines<'a>, Failure> {
    let options = SamplingOptions {
        initial: SamplingOptions::default().initial.min(amount.training / 3),
        max_samples: amount.training,
        ..SamplingOptions::default()
    };
    let ours = training_set(space, &options)?.samples;
    let corner = |pick: fn(f64, f64) -> f64| -> [f64; 6] {
        std::array::from_fn(|j| ours.iter().map(|sample| sample.joints[j]).reduce(pick).unwrap_or(0.0))
    };
    let random = random_samples(space, &corner(f64::min), &corner(f64::max), ours.len(), RANDOM)?;
    let mut machines = Machines::default();
    for (names, samples) in [(["svm", "svm_shifted"], &ours), (["svm_random", "svm_random_shifted"], &random)] {
        match Svm::train(samples, &SvmOptions::default()) {
            Ok(svm) => {
                let shifted = svm.clone().shifted(PAPER_SHIFT);
                let count = (svm.kernels(), samples.len(), samples.len());
                rows.extend(measured(names, [&svm, &shifted], count, known));
                if names[0] == "svm" {
                    machines.paper = Some(shifted);
                }
            }
            Err(error) => notes.push(format!("{} was not trained: {error}", names[0])),
        }
    }
    match over_features(space, amount.training) {
        Ok((svm, count)) => {
            let shifted = OnFeatures::new(svm.inner().clone().shifted(PAPER_SHIFT), features(space));
            rows.extend(measured(["svm_gap", "svm_gap_shifted"], [&svm, &shifted], count, known));
            machines.gap = Some(shifted);
        }
        Err(error) => notes.push(format!("svm_gap was not trained: {}", error.message())),
    }
    Ok(machines)
}

/// A machine as it is and shifted.
fn measured(
    names: [&'static str; 2],
    indicators: [&dyn CollisionIndicator<6>; 2],
    (kernels, samples, checked): Count,
    known: &Known,
) -> [Row; 2] {
    std::array::from_fn(|k| Row {
        bias_shift: [0.0, PAPER_SHIFT][k],
        kernels,
        samples,
        checked,
        ..known.row(names[k], indicators[k])
    })
}

fn features<'a>(space: &'a Surface<'a>) -> Turns<'a> {
    TurnsAndGap { space, height: GAP_HEIGHT, near_mm: GAP_NEAR_MM }
}

/// The machine over features, from a sixth of the samples on contact, a sixth near it, and hard ones; with the numbers of
/// kernels, samples and exact checks.
fn over_features<'a>(space: &'a Surface<'a>, training: usize) -> Result<(OnGap<'a>, Count), Failure> {
    let features = features(space);
    let initial = training / 6;
    let added = ((training - 2 * initial) / HARD_ROUNDS).max(1);
    let options =
        HardOptions { initial, rounds: HARD_ROUNDS, added, pool: POOL * added, within: NEAR, ..HardOptions::default() };
    let train = |samples: &[Sample<6>]| {
        let svm = Svm::train(&features_of(&features, samples), &SvmOptions::default())?;
        Ok(OnFeatures::new(svm, features))
    };
    let learned = hard_samples(space, &options, &train)?;
    let count = (learned.indicator.inner().kernels(), learned.samples.len(), learned.checked);
    Ok((learned.indicator, count))
}
