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
    let sums = window_sums(&least, radius);
    for (k, value) in values.iter_mut().enumerate() {
        let count = (k + radius).min(n - 1) - k.saturating_sub(radius) + 1;
        // Rounding of sums must not exceed the minimum.
        *value = (sums[k] / count as f64).min(*value);
    }
}

/// The least value within a radius of each.
fn sliding_minimum(values: &[f64], radius: usize) -> Vec<f64> {
    let n = values.len();
    let mut queue = std::collections::VecDeque::new();
    let mut least = Vec::with_capacity(n);
    let mut next = 0;
    for k in 0..n {
        while next < n && next <= k + radius {
            while queue.back().is_some_and(|&last: &usize| values[last] >= values[next]) {
                queue.pop_back();
            }
            queue.push_back(next);
            next += 1;
        }
        while queue.front().is_some_and(|&first| first + radius < k) {
            queue.pop_front();
        }
        least.push(values[queue[0]]);
    }
    least
}

/// The sum of the values within a radius of each.
pub(super) fn window_sums(values: &[f64], radius: usize) -> Vec<f64> {
    let n = values.len();
    let mut sums = Vec::with_capacity(n + 1);
    sums.push(0.0);
    for (k, value) in values.iter().enumerate() {
        sums.push(sums[k] + value);
    }
    (0..n).map(|k| (sums[(k + radius + 1).min(n)] - sums[k.saturating_sub(radius)]).max(0.0)).collect()
}
