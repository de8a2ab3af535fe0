//! How a ladder is built and searched.

use super::error::LadderError;
use crate::Bounds;

/// How far apart two nodes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Norm {
    /// The weighted sum of squared differences, Eq. 4.5.
    Squared,
    /// The weighted sum of absolute differences, Eq. 3.4.
    Absolute,
}

/// How the shortest path is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum LadderSearch {
    /// All samples at all waypoints. The result is a shortest path.
    Exact,
    /// A coarse path through every eighth waypoint at an eighth of the samples, then every fourth, every second and all,
    /// each with the samples near the path before, and more of them where it is stuck, until the result stays clear of
    /// what was left out. Usually the shortest path or close to it, and 0.05 rad from stops that are more than a turn
    /// apart. Where it finds none, it falls back to `Exact` with up to 1,024 samples a waypoint. With more, as several
    /// free parameters soon have, that would take minutes: it says [`LadderError::NotFound`], and `Exact` with a few samples,
    /// just near enough to one another for the speeds, is what to try next.
    CoarseToFine,
}

/// How a ladder is built and searched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, bound(deserialize = ""))
)]
pub struct LadderOptions<const N: usize, const F: usize> {
    /// Samples of each free parameter to begin with; one for a range of a single value. Default 4, as in section 4.3.1; 360 is the dense graph of Table
    /// 4.2.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub samples: [u32; F],
    /// How often the samples may be doubled while there is no path. Default 7, to 512 samples.
    pub doublings: u32,
    /// How often, once there is a path, twice as many samples are looked at about it. It only becomes shorter, and breaks
    /// off where it did. Default 0, at most 10.
    pub refinements: u32,
    /// Weight of each joint, the diagonal of `W`. Default 1.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub weights: [f64; N],
    /// How far each joint may go from a waypoint to the next, whatever its speed, in radians. Default infinite. Where
    /// waypoints are seconds apart, speeds allow to turn the arm over between two of them: both are met, but what is
    /// between them is not the path.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub step: [f64; N],
    /// Default [`Norm::Squared`].
    pub norm: Norm,
    /// Default [`LadderSearch::Exact`].
    pub search: LadderSearch,
    /// Whether a path may break off and start anew where speeds do not allow to go on, after all doublings (section
    /// 3.5.3): as seldom as it must, and there where that makes it shortest. Else that is an error. Default false.
    pub breaks: bool,
    /// Where the joints are before the path: the way to the first waypoint then costs what a step does, but no speed
    /// bounds it. Of many paths that are nearly as short it takes the one that is near by, without whole turns on the way.
    /// Default none: a path may begin anywhere.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::optional_array"))]
    pub from: Option<[f64; N]>,
}

impl<const N: usize, const F: usize> Default for LadderOptions<N, F> {
    fn default() -> Self {
        LadderOptions {
            samples: [4; F],
            doublings: 7,
            refinements: 0,
            weights: [1.0; N],
            step: [f64::INFINITY; N],
            norm: Norm::Squared,
            search: LadderSearch::Exact,
            breaks: false,
            from: None,
        }
    }
}

/// Samples of all free parameters together are at most this many a waypoint.
pub const MAX_SAMPLES: u64 = 1 << 20;

/// Refined more often, samples would no longer differ.
pub(super) const MAX_REFINEMENTS: u32 = 10;

pub(super) fn count(samples: &[u32]) -> u64 {
    samples.iter().fold(1, |product: u64, &n| product.saturating_mul(u64::from(n)))
}

pub(super) fn check<const N: usize, const F: usize>(
    waypoints: usize,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, F>,
) -> Result<(), LadderError> {
    if times.len() != waypoints || waypoints == 0 {
        return Err(LadderError::Count { times: times.len(), waypoints });
    }
    for (waypoint, &time) in times.iter().enumerate() {
        if !time.is_finite() || (waypoint > 0 && time <= times[waypoint - 1]) {
            return Err(LadderError::Time { waypoint, time });
        }
    }
    bounds.check()?;
    if let Some(&weight) = options.weights.iter().find(|weight| !(**weight >= 0.0 && weight.is_finite())) {
        return Err(LadderError::Option { what: "a weight must be finite and not below 0; it", value: weight });
    }
    if let Some(&step) = options.step.iter().find(|step| step.is_nan() || **step <= 0.0) {
        return Err(LadderError::Option { what: "a step must be above 0; it", value: step });
    }
    if let Some(&value) = options.from.iter().flatten().find(|value| !value.is_finite()) {
        return Err(LadderError::Option { what: "joints before the path must be finite; one", value });
    }
    if options.refinements > MAX_REFINEMENTS {
        let what = "refinements must be at most 10; their number";
        return Err(LadderError::Option { what, value: f64::from(options.refinements) });
    }
    let samples = count(&options.samples);
    if samples == 0 || samples > MAX_SAMPLES || options.samples.iter().any(|&n| n > u32::MAX / 4) {
        let what = "the number of samples must be from 1 to 2^20; it";
        return Err(LadderError::Option { what, value: samples as f64 });
    }
    Ok(())
}
