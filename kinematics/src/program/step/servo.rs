//! A timed trajectory as a stream of joints at the controller's own rate: [`resample`].

use super::data::{Step, until_error};
use std::collections::VecDeque;

/// A sample of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedJoints {
    /// When, in seconds.
    pub time_s: f64,
    /// The joints.
    pub joints: [f64; 6],
    /// Whether the extruder is on from here on.
    pub extruder: bool,
}

/// The controller's rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServoRate {
    /// 125 Hz: CB series.
    Hz125,
    /// 500 Hz: e-Series.
    Hz500,
}

impl ServoRate {
    /// Time between two steps.
    pub fn seconds(self) -> f64 {
        match self {
            ServoRate::Hz125 => 0.008,
            ServoRate::Hz500 => 0.002,
        }
    }
}

/// A trajectory that cannot be resampled. Samples are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// A time is not after the one before, not finite, or more than an hour after it.
    #[error("sample {index}: the time {time_s} s must come after {before_s} s, by no more than an hour")]
    Time {
        /// The sample.
        index: u64,
        /// Its time.
        time_s: f64,
        /// The time before it.
        before_s: f64,
    },
    /// A joint is not finite.
    #[error("sample {index}: joint {} is {value}, not a finite number", joint + 1)]
    Joint {
        /// The sample.
        index: u64,
        /// The joint, counted from 0.
        joint: usize,
        /// Its value.
        value: f64,
    },
}

/// Longest time between two samples: a mistyped time must not become a stream without end.
const MAX_GAP_S: f64 = 3600.0;

/// Resamples a trajectory: the joints at `k / rate` after the first sample, from `k = 0` until the last sample is
/// reached. The extruder's changes come before the first step at or after their sample. A single sample is one step.
///
/// Between two samples each joint runs on a cubic whose slopes at the ends are those of the parabola through three
/// neighbours (through the first or last three at the ends; the straight line when there are only two). So the stream
/// passes through every sample, its velocity has no jumps, and what moves uniformly accelerated comes out exactly.
///
/// Reads the samples as it goes; memory is three samples. The first error ends the stream.
/// ```
/// use curvlay_kinematics::program::{ResampleError, ServoRate, Step, TimedJoints, resample};
/// let sample = |time_s: f64| TimedJoints { time_s, joints: [time_s * time_s; 6], extruder: false };
/// let steps: Vec<Step> = resample([0.0, 0.3, 1.0].map(sample), ServoRate::Hz125).collect::<Result<_, _>>()?;
/// assert_eq!(steps.len(), 126);
/// let Step::Servo { joints, .. } = steps[100] else { return Err("no step".into()) };
/// assert!((joints[0] - 0.64).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn resample(
    samples: impl IntoIterator<Item = TimedJoints>,
    rate: ServoRate,
) -> impl Iterator<Item = Result<Step, ResampleError>> {
    let mut resampler = Resampler {
        samples: samples.into_iter(),
        period: rate.seconds(),
        read: 0,
        window: VecDeque::with_capacity(4),
        at: 0,
        first_time: 0.0,
        extruding: false,
        tick: 0,
    };
    let mut over = false;
    std::iter::from_fn(move || until_error(&mut over, || resampler.step()))
}

struct Resampler<I> {
    samples: I,
    period: f64,
    /// Samples read.
    read: u64,
    /// Up to four samples, none at the end; the span at hand begins at number `at` of them.
    window: VecDeque<TimedJoints>,
    at: usize,
    first_time: f64,
    extruding: bool,
    /// Number of the next step.
    tick: u64,
}

impl<I: Iterator<Item = TimedJoints>> Resampler<I> {
    /// Takes one more sample into the window; false when there is none.
    fn read(&mut self) -> Result<bool, ResampleError> {
        let Some(sample) = self.samples.next() else { return Ok(false) };
        let index = self.read;
        if let Some(joint) = sample.joints.iter().position(|angle| !angle.is_finite()) {
            return Err(ResampleError::Joint { index, joint, value: sample.joints[joint] });
        }
        let before_s = self.window.back().map_or(f64::NEG_INFINITY, |last| last.time_s);
        let gap = sample.time_s - before_s;
        let later = sample.time_s.is_finite() && gap > 0.0 && (gap <= MAX_GAP_S || self.window.is_empty());
        if !later {
            return Err(ResampleError::Time { index, time_s: sample.time_s, before_s });
        }
        if index == 0 {
            self.first_time = sample.time_s;
        }
        self.read += 1;
        self.window.push_back(sample);
        Ok(true)
    }

    fn step(&mut self) -> Result<Option<Step>, ResampleError> {
        if self.read == 0 {
            // The first parabola needs three samples.
            while self.window.len() < 3 && self.read()? {}
        }
        if self.window.is_empty() {
            return Ok(None);
        }
        let time = self.first_time + self.tick as f64 * self.period;
        // On to the span in which the time lies; its end may belong to it.
        while self.window.get(self.at + 1).is_some_and(|end| end.time_s <= time) {
            self.at += 1;
            if self.at + 2 >= self.window.len() {
                self.read()?;
            }
            if self.at > 1 {
                self.window.pop_front();
                self.at -= 1;
            }
            // A change is passed on even when the next step lies beyond this span.
            if self.window[self.at].extruder != self.extruding {
                self.extruding = !self.extruding;
                return Ok(Some(Step::Extruder(self.extruding)));
            }
        }
        if self.tick == 0 && self.window[0].extruder && !self.extruding {
            self.extruding = true;
            return Ok(Some(Step::Extruder(true)));
        }
        let begin = self.window[self.at];
        let Some(end) = self.window.get(self.at + 1) else {
            // At or beyond the last sample: it is reached in one step more, and that is all.
            self.window.clear();
            return Ok(Some(Step::Servo { joints: begin.joints, seconds: self.period }));
        };
        let span = end.time_s - begin.time_s;
        let share = (time - begin.time_s) / span;
        let (from, to) = (self.slopes(self.at), self.slopes(self.at + 1));
        let rest = 1.0 - share;
        // Hermite's four cubics.
        let [a, b] = [(1.0 + 2.0 * share) * rest * rest, share * share * (3.0 - 2.0 * share)];
        let [c, d] = [share * rest * rest * span, -share * share * rest * span];
        let joint = |k: usize| a * begin.joints[k] + b * end.joints[k] + c * from[k] + d * to[k];
        self.tick += 1;
        Ok(Some(Step::Servo { joints: std::array::from_fn(joint), seconds: self.period }))
    }

    /// Velocities at a sample of the window: of the parabola through it and its neighbours.
    fn slopes(&self, at: usize) -> [f64; 6] {
        let last = self.window.len() - 1;
        if last == 1 {
            let (a, b) = (self.window[0], self.window[1]);
            return std::array::from_fn(|k| (b.joints[k] - a.joints[k]) / (b.time_s - a.time_s));
        }
        let middle = at.clamp(1, last - 1);
        let (a, b, c) = (self.window[middle - 1], self.window[middle], self.window[middle + 1]);
        let (before, after) = (b.time_s - a.time_s, c.time_s - b.time_s);
        std::array::from_fn(|k| {
            let (first, second) = ((b.joints[k] - a.joints[k]) / before, (c.joints[k] - b.joints[k]) / after);
            let bend = (second - first) / (before + after);
            // The derivative of Newton's form at the sample.
            let t = self.window[at].time_s;
            first + bend * ((t - a.time_s) + (t - b.time_s))
        })
    }
}
