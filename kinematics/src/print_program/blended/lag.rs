//! Signals that come earlier, as the extruder is behind them.

use super::lines::Sample;
use super::options::BlendOptions;

/// How much earlier signals come at most, in seconds, as in a stream.
const MAX_EARLY_S: f64 = 0.5;

/// The speed of the filament, in mm/s, where signals have asked for all of it and the tool still moves: nearly 0. A signal that stops the filament would have
/// to come at rest.
pub(super) const MIN_FED_MM_S: f64 = 1e-3;

/// The lag along a segment: at most half of its time.
pub(super) fn of(samples: &[Sample], options: &BlendOptions) -> f64 {
    let seconds = samples[samples.len() - 1].time_s - samples[0].time_s;
    // 0 first: `max` drops a lag of NaN.
    options.lag_s.max(0.0).min(0.5 * seconds).min(MAX_EARLY_S)
}

/// The filament of a segment by a time; behind its ends what it has there.
fn laid(samples: &[Sample], time_s: f64) -> f64 {
    let behind = samples.partition_point(|sample| sample.time_s <= time_s);
    match (behind.checked_sub(1).map(|k| &samples[k]), samples.get(behind)) {
        (Some(a), Some(b)) => {
            let share = (time_s - a.time_s) / (b.time_s - a.time_s);
            a.filament_mm + (b.filament_mm - a.filament_mm) * share
        }
        (Some(end), None) | (None, Some(end)) => end.filament_mm,
        (None, None) => 0.0,
    }
}

/// Makes the filament of each sample due so much earlier.
pub(super) fn advance(samples: &mut [Sample], lag_s: f64) {
    if lag_s > 0.0 {
        let due: Vec<f64> = samples.iter().map(|sample| laid(samples, sample.time_s + lag_s)).collect();
        samples.iter_mut().zip(due).for_each(|(sample, due_mm)| sample.due_mm = due_mm);
    }
}

/// What comes before the end of a travel for the segment behind it.
pub(super) struct Early {
    /// The sample of the travel at which the extruder is switched on: the last one that is early enough, else the first one.
    pub at: usize,
    /// Filament that is asked for by the end of the travel, in mm.
    pub filament_mm: f64,
    /// The lag of the segment.
    pub lag_s: f64,
}

/// `None` without a lag.
pub(super) fn early(travel: &[Sample], prints: &[Sample], options: &BlendOptions) -> Option<Early> {
    let lag_s = if prints.len() > 1 { of(prints, options) } else { 0.0 };
    (lag_s > 0.0).then(|| {
        let end_s = travel[travel.len() - 1].time_s;
        let at = travel.iter().rposition(|sample| sample.time_s <= end_s - lag_s).unwrap_or(0);
        let filament_mm = (laid(prints, prints[0].time_s + lag_s) - prints[0].filament_mm).max(0.0);
        Early { at, filament_mm, lag_s }
    })
}
