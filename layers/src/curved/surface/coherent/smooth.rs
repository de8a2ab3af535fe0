//! Smoothing that closes waits: differences of face neighbours shrink to a layer, unless they are cut.

use super::part::{NONE, Part};

/// Face neighbours between which the field may jump: bit `k` of a cell for its neighbour `k`.
pub(super) struct Cuts(Vec<u8>);

impl Cuts {
    /// Those whose times are `apart` or more.
    pub(super) fn of(part: &Part, times: &[f64], apart: f64) -> Self {
        let bits = |place: usize| {
            let is_cut = |next: u32| next != NONE && (times[next as usize] - times[place]).abs() >= apart;
            (0..6).filter(|&k| is_cut(part.faces[place][k])).fold(0, |bits, k| bits | 1 << k)
        };
        Cuts((0..times.len()).map(bits).collect())
    }

    fn is_cut(&self, place: usize, k: usize) -> bool {
        self.0[place] >> k & 1 == 1
    }
}

/// `sweeps` times: each time goes half the way to the mean of what its neighbours allow, which is the time itself within a
/// `layer` of theirs. What stands stays.
pub(super) fn smoothed(part: &Part, cuts: &Cuts, mut times: Vec<f64>, layer: f64, sweeps: usize) -> Vec<f64> {
    let mut next = times.clone();
    for _ in 0..sweeps {
        for (place, faces) in part.faces.iter().enumerate().filter(|&(place, _)| !part.stands[place]) {
            let time = times[place];
            let (mut sum, mut count) = (0.0, 0.0);
            for (k, &face) in faces.iter().enumerate() {
                if face != NONE && !cuts.is_cut(place, k) {
                    let there = times[face as usize];
                    sum += there + (time - there).clamp(-layer, layer);
                    count += 1.0;
                }
            }
            next[place] = if count > 0.0 { (time + sum / count) / 2.0 } else { time };
        }
        std::mem::swap(&mut times, &mut next);
    }
    times
}
