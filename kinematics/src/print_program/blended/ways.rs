//! Moves by joints: how near they are to the plan, and how wide corners may be rounded.

use super::lines::{BLEND_SHARE, MIN_BLEND_MM};
use super::options::BlendOptions;
use crate::print_program::PrintKnot;
use crate::program::Zone;

/// The joint that turns most, in rad.
pub(super) fn turn<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn between<const N: usize>(a: &[f64; N], b: &[f64; N], share: f64) -> [f64; N] {
    std::array::from_fn(|joint| a[joint] + (b[joint] - a[joint]) * share)
}

/// How far the joints have turned by each sample, in rad.
pub(super) fn turns<const N: usize>(knots: &[PrintKnot<N>]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = knots.windows(2).map(|pair| turn(&pair[0].joints, &pair[1].joints));
    std::iter::once(0.0)
        .chain(steps.map(|step| {
            sum += step;
            sum
        }))
        .collect()
}

/// Whether the straight move by joints from one sample to another goes by all between.
pub(super) fn fits<const N: usize>(
    knots: &[PrintKnot<N>],
    turns: &[f64],
    [from, to]: [usize; 2],
    options: &BlendOptions,
) -> bool {
    let all = turns[to] - turns[from];
    (from + 1..to).all(|k| {
        let share = if all > 0.0 { (turns[k] - turns[from]) / all } else { 0.0 };
        let at = between(&knots[from].joints, &knots[to].joints, share);
        turn(&at, &knots[k].joints) <= 0.5 * options.travel_rad
    })
}

/// The widest radius by which the corner between two moves by joints may be rounded.
///
/// # Arguments
/// * `ways_mm`: of the TCP from the corner to both neighbours: a controller begins a blend so far from the corner.
pub(super) fn corner<const N: usize>(corners: [&[f64; N]; 3], ways_mm: [f64; 2], options: &BlendOptions) -> Zone {
    let [before, here, behind] = corners;
    let mut radius = BLEND_SHARE * ways_mm[0].min(ways_mm[1]);
    while radius >= MIN_BLEND_MM {
        let (begin, end) = (between(here, before, radius / ways_mm[0]), between(here, behind, radius / ways_mm[1]));
        let middle = between(&between(&begin, here, 0.5), &between(here, &end, 0.5), 0.5);
        if turn(&middle, here) <= 0.5 * options.travel_rad {
            return Zone::Blend(radius);
        }
        radius *= 0.5;
    }
    Zone::Stop
}
