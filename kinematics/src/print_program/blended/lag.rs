//! Signals that come earlier, as the extruder is behind them.

use super::lines::Sample;
use super::options::BlendOptions;
use crate::print_program::PrintKnot;

/// How much earlier signals come at most, in seconds, as in a stream.
const MAX_EARLY_S: f64 = 0.5;

/// The speed of the filament, in mm/s, where signals have asked for all of it and the tool still moves: as good as none. A signal that stops it would have
/// to come at rest.
pub(super) const MIN_FED_MM_S: f64 = 1e-3;

/// The lag along a segment: at most half of its time.
pub(super) fn of<const N: usize>(knots: &[PrintKnot<N>], options: &BlendOptions) -> f64 {
    let seconds = knots[knots.len() - 1].time_s - knots[0].time_s;
    // A lag of NaN counts as 0.
    options.lag_s.min(MAX_EARLY_S).min(0.5 * seconds).max(0.0)
}

/// Filament of a curve of times and filament by a time; at its ends what it has there.
fn laid(curve: impl Fn(usize) -> [f64; 2], count: usize, time_s: f64) -> f64 {
    let (mut low, mut high) = (0, count - 1);
    if time_s >= curve(high)[0] {
        return curve(high)[1];
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if curve(middle)[0] <= time_s { low = middle } else { high = middle }
    }
    let ([a, from], [b, to]) = (curve(low), curve(high));
    from + (to - from) * ((time_s - a) / (b - a)).clamp(0.0, 1.0)
}

/// Makes the filament of each sample due so much earlier.
pub(super) fn advance(samples: &mut [Sample], lag_s: f64) {
    if lag_s > 0.0 {
        let due = |sample: &Sample| {
            laid(|k| [samples[k].time_s, samples[k].filament_mm], samples.len(), sample.time_s + lag_s)
        };
        let due: Vec<f64> = samples.iter().map(due).collect();
        samples.iter_mut().zip(due).for_each(|(sample, due_mm)| sample.due_mm = due_mm);
    }
}

/// The sample of a travel at which the extruder of the segment behind it is switched on, and what is asked for by the end of the travel, in mm; `None` without a lag.
///
/// It is the last one that is early enough, else the first one.
pub(super) fn early<const N: usize>(
    travel: &[PrintKnot<N>],
    prints: &[PrintKnot<N>],
    options: &BlendOptions,
) -> Option<(usize, f64)> {
    let lag_s = if prints.len() > 1 { of(prints, options) } else { 0.0 };
    (lag_s > 0.0).then(|| {
        let end_s = travel[travel.len() - 1].time_s;
        let cut = travel.iter().rposition(|knot| knot.time_s <= end_s - lag_s).unwrap_or(0);
        let by = laid(|k| [prints[k].time_s, prints[k].filament_mm], prints.len(), prints[0].time_s + lag_s);
        (cut, (by - prints[0].filament_mm).max(0.0))
    })
}
