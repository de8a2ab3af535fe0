//! Quantities of a step that differ along the path.
//!
//! What limits a step at one place of a path has no influence on places some segments away: the effect of a row on the solution
//! decays from segment to segment. With one length of step for the whole path, the place with the shortest one holds up all
//! others, and a long path takes many more steps than each of its parts. So lengths of steps and centring parameters
//! are fields over the unknowns that change slowly.

/// Unknowns on both sides that share their length of step and their centring. A row spans three. Lengths that change over fewer
/// move slacks too differently; over many more, one place holds up others again. Other values have not been tried.
pub(super) const RADIUS: usize = 16;

/// Replaces each value by the least one within two radii, averaged over one: nowhere more than a value within a radius,
/// and without jumps.
pub(super) fn smooth_minimum(values: &mut [f64], radius: usize) {
    let n = values.len();
    if n <= radius {
        let least = values.iter().fold(f64::INFINITY, |least, value| least.min(*value));
        values.fill(least);
        return;
    }
    let least = sliding_minimum(values, 2 * radius);
    let mut sums = Vec::with_capacity(n + 1);
    let mut sum = 0.0;
    sums.push(sum);
    sums.extend(least.iter().map(|least| {
        sum += least;
        sum
    }));
    for (k, value) in values.iter_mut().enumerate() {
        let (from, to) = (k.saturating_sub(radius), (k + radius + 1).min(n));
        // Rounding of sums must not exceed the minimum.
        *value = smaller(*value, ((sums[to] - sums[from]) / (to - from) as f64).max(0.0));
    }
}

/// The smaller of two numbers.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The least value within a radius of each, by minima from both ends of blocks as long as a window: a window is the end of one and the
/// beginning of the next. (M. van Herk, "A fast algorithm for local minimum and maximum filters on rectangular and octagonal
/// kernels", Pattern Recognition Letters 13(7), 1992.)
fn sliding_minimum(values: &[f64], radius: usize) -> Vec<f64> {
    let (n, width) = (values.len(), 2 * radius + 1);
    // With a radius more on both sides, window `k` is from `k` to `k + 2 radius`.
    let mut begun = vec![f64::INFINITY; n + 2 * radius];
    begun[radius..radius + n].copy_from_slice(values);
    let mut ended = begun.clone();
    for (from, to) in begun.chunks_mut(width).zip(ended.chunks_mut(width)) {
        let mut least = f64::INFINITY;
        for value in from {
            least = smaller(*value, least);
            *value = least;
        }
        least = f64::INFINITY;
        for value in to.iter_mut().rev() {
            least = smaller(*value, least);
            *value = least;
        }
    }
    ended.iter().zip(&begun[2 * radius..]).map(|(ended, begun)| smaller(*ended, *begun)).collect()
}

/// The sums of the values of several fields within a radius of each place.
pub(super) fn window_sums<const M: usize>(values: [&[f64]; M], radius: usize) -> Vec<[f64; M]> {
    let n = values.iter().map(|values| values.len()).min().unwrap_or(0);
    let mut sums = Vec::with_capacity(n + 1);
    let mut sum = [0.0; M];
    sums.push(sum);
    sums.extend((0..n).map(|k| {
        (0..M).for_each(|of| sum[of] += values[of][k]);
        sum
    }));
    let between = |k: usize| {
        let (from, to) = (&sums[k.saturating_sub(radius)], &sums[(k + radius + 1).min(n)]);
        std::array::from_fn(|of| (to[of] - from[of]).max(0.0))
    };
    (0..n).map(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn windows_have_the_least_value_and_the_sum_of_their_own() {
        let mut rng = Pcg64::seed_from_u64(3);
        for (n, radius) in [(1usize, 0usize), (1, 5), (7, 2), (33, 16), (34, 16), (200, 16), (100, 1)] {
            let values: Vec<f64> = (0..n).map(|_| rng.random_range(0.0..1.0)).collect();
            let (least, sums) = (sliding_minimum(&values, radius), window_sums([&values], radius));
            for k in 0..n {
                let window = &values[k.saturating_sub(radius)..(k + radius + 1).min(n)];
                let smallest = window.iter().fold(f64::INFINITY, |least, value| least.min(*value));
                assert_eq!(least[k].to_bits(), smallest.to_bits(), "{n} {radius} {k}");
                assert!((sums[k][0] - window.iter().sum::<f64>()).abs() < 1e-12, "{n} {radius} {k}");
            }
            let mut smooth = values.clone();
            smooth_minimum(&mut smooth, radius);
            assert!(smooth.iter().zip(&least).all(|(smooth, least)| *smooth <= least + 1e-12), "{n} {radius}");
        }
    }
}
