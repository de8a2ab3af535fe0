//! An axis that turns along with paths kept within its range, without returns between them.
//!
//! B. Brooks (2016), section 5.2.2: going around the pole of a dome turns axis 6 by 360 degrees, and after a second path it is
//! beyond its 400 degrees. The thesis returns to a home position after every path. A whole turn of the axis changes nothing, nor
//! does the direction in which a path is followed: here each path takes the whole turn, the direction and, if it is closed, the
//! begin with which it stays within the range and begins near the end of the one before.

use std::f64::consts::TAU;

/// Angles of the axis along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnPath<'a> {
    /// At each point, without jumps of a whole turn. Of a closed path the first point comes again at the end, perhaps whole turns
    /// away.
    pub turns: &'a [f64],
    /// Whether the path is closed, so that it can begin anywhere.
    pub closed: bool,
}

/// How a path is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnChoice {
    /// The point where it begins: 0, but for closed paths that do not fit otherwise.
    pub start: usize,
    /// Whether it is followed from its end to its begin.
    pub reversed: bool,
    /// Whole turns, in radians, that are added to all its angles.
    pub shift: f64,
    /// How far the axis turns from the path before, in radians.
    pub travel: f64,
}

/// A path that no choice keeps within the range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("path {path}: the axis would turn over {span} rad, more than its range from {lower} to {upper} rad")]
pub struct TurnError {
    /// The path, from 0.
    pub path: usize,
    /// From its least angle to its largest.
    pub span: f64,
    /// The range.
    pub lower: f64,
    /// The range.
    pub upper: f64,
}

/// Begins that are tried on a closed path that does not fit as it is.
const STARTS: usize = 64;

/// Chooses for each path in turn.
///
/// # Arguments
/// * `from`: where the axis is before the first path.
///
/// # Errors
/// [`TurnError`] for the first path that cannot be followed. Angles that are not finite fit nowhere.
///
/// # Cost
/// `O(n)` for `n` points; 64 times that for closed paths that do not fit as they are.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::{TurnPath, choose_turns};
/// use std::f64::consts::TAU;
/// // Three times once around within 400 degrees: there, back, and there again.
/// let around: Vec<f64> = (0..=36).map(|k| f64::from(k) * TAU / 36.0).collect();
/// let path = TurnPath { turns: &around, closed: true };
/// let range = 400f64.to_radians();
/// let choices = choose_turns(&[path; 3], [-range, range], 0.0)?;
/// assert_eq!(choices.iter().map(|choice| choice.reversed).collect::<Vec<_>>(), [false, true, false]);
/// assert!(choices.iter().all(|choice| choice.travel == 0.0));
/// # Ok::<(), curvlay_kinematics::program::TurnError>(())
/// ```
pub fn choose_turns(paths: &[TurnPath], [lower, upper]: [f64; 2], from: f64) -> Result<Vec<TurnChoice>, TurnError> {
    let mut at = from;
    let mut out = Vec::with_capacity(paths.len());
    for (path, TurnPath { turns, closed }) in paths.iter().enumerate() {
        let (Some(&first), Some(&last)) = (turns.first(), turns.last()) else {
            out.push(TurnChoice { start: 0, reversed: false, shift: 0.0, travel: 0.0 });
            continue;
        };
        if let Some(&odd) = turns.iter().find(|turn| !turn.is_finite()) {
            return Err(TurnError { path, span: odd, lower, upper });
        }
        // Points of a closed path but for the one that comes twice.
        let around = if *closed { turns.len() - 1 } else { 0 };
        let others = (1..STARTS).map(|k| around * k / STARTS).filter(|&start| start > 0);
        let mut best: Option<(TurnChoice, f64)> = None;
        for start in std::iter::once(0).chain(others) {
            let begun = |k: usize| begun_at(turns, start, k);
            let (low, high) =
                (0..turns.len()).map(begun).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
            // The range of whole turns is empty where none fits.
            let (fewest, most) = (((lower - low) / TAU).ceil(), ((upper - high) / TAU).floor());
            for reversed in [false, true] {
                let (begin, end) = if start == 0 { (first, last) } else { (begun(0), begun(around)) };
                let (begin, end) = if reversed { (end, begin) } else { (begin, end) };
                if fewest <= most {
                    let turns = ((at - begin) / TAU).round().clamp(fewest, most);
                    let shift = turns * TAU;
                    let travel = begin + shift - at;
                    let choice = TurnChoice { start, reversed, shift, travel };
                    if best.is_none_or(|(best, _)| travel.abs() < best.travel.abs() - 1e-12) {
                        best = Some((choice, end + shift));
                    }
                }
            }
            // Another begin only where this one does not fit.
            if best.is_some() {
                break;
            }
        }
        let Some((choice, end)) = best else {
            let (low, high) = turns.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &t| (a.min(t), b.max(t)));
            return Err(TurnError { path, span: high - low, lower, upper });
        };
        out.push(choice);
        at = end;
    }
    Ok(out)
}

/// The angle at point `k` of a closed path that begins at another point.
fn begun_at(turns: &[f64], start: usize, k: usize) -> f64 {
    if start + k < turns.len() {
        return turns[start + k];
    }
    // Once around: what comes twice counts once.
    let around = turns[turns.len() - 1] - turns[0];
    turns[start + k - (turns.len() - 1)] + around
}

impl TurnChoice {
    /// Where a path of so many points begins.
    fn start_among(&self, points: usize) -> usize {
        if self.start < points { self.start } else { 0 }
    }

    /// Puts what belongs to the points of a path into the order in which it is followed. Of a closed path the first comes again at
    /// the end. A start beyond the path counts as its first point.
    pub fn ordered<T: Copy>(&self, points: &[T]) -> Vec<T> {
        let mut out: Vec<T> = match self.start_among(points.len()) {
            0 => points.to_vec(),
            start => points[start..].iter().chain(&points[1..=start]).copied().collect(),
        };
        if self.reversed {
            out.reverse();
        }
        out
    }

    /// The same for the angles themselves, shifted.
    pub fn turned(&self, turns: &[f64]) -> Vec<f64> {
        let start = self.start_among(turns.len());
        let mut out: Vec<f64> = (0..turns.len()).map(|k| begun_at(turns, start, k) + self.shift).collect();
        if self.reversed {
            out.reverse();
        }
        out
    }
}
