//! Why risky area is left: what stands against the most promising plane through each part.

use super::error::RoboFdmError;
use super::head::Head;
use super::options::{Report, TuningOptions, min_gain};
use super::state::{State, are_near};
use crate::planar::CutPlane;

/// What stands against the most promising plane through a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeftReason {
    /// No plane promises to save as much as a cut must.
    NoPlane,
    /// What it takes off is smaller than [`TuningOptions::min_piece`], or is no less risky along its normal, or something would float.
    NoPiece,
    /// There would be more than [`TuningOptions::max_parts`] parts.
    MaxParts,
    /// It saves less than a cut must.
    TooLittle,
    /// The head would be in the platform, or in the pedestal on it.
    Platform,
    /// The head would be in an earlier part, from 0.
    Part(usize),
    /// A seam would be too weak: [`TuningOptions::strength`].
    Weak,
    /// What it takes off bounds no solid: it touches itself along an edge.
    Unsound,
    /// Nothing does; the search ended before.
    Untried,
}

/// A part with risky area, and why it is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// The part, from 0.
    pub part: usize,
    /// Its risky area, in mm2.
    pub risky_mm2: f64,
    /// What the most promising plane would save, in mm2; 0 if there is none.
    pub promise_mm2: f64,
    /// What stands against it.
    pub reason: LeftReason,
}

/// Parts with less than this share of the risky area of the whole are not explained.
const MIN_SHARE: f64 = 1e-3;

/// Planes that are looked at, the most promising first, for one that may be tried at all: what cuts off nothing says nothing.
const PLANES: usize = 60;

/// Why risky area is left, by parts; nothing where the goal is met.
pub(super) fn left(state: &State, before: f64, report: &Report) -> Result<Vec<Left>, RoboFdmError> {
    if state.risky() <= state.options.goal * before {
        return Ok(Vec::new());
    }
    // Planes are rated as if there were no platform: whether it is in the way is what is asked.
    let mut open = state.clone();
    open.options.head = state.options.head.map(|head| Head { platform_radius: 0.0, ..head });
    let least = min_gain(state.options.halvings) * before;
    let mut all = Vec::new();
    for part in 0..state.nodes.len() {
        let risky_mm2 = state.nodes[part].risky;
        if risky_mm2 < (MIN_SHARE * before).max(least) {
            continue;
        }
        report("reasons", part, state.nodes.len())?;
        let mut found = Left { part, risky_mm2, promise_mm2: 0.0, reason: LeftReason::NoPlane };
        let mut seen: Vec<CutPlane> = Vec::new();
        for (promise_mm2, plane) in open.rated(part, least) {
            if seen.len() == PLANES {
                break;
            }
            if seen.iter().any(|known| are_near(known, &plane, state.options.spacing)) {
                continue;
            }
            seen.push(plane);
            let reason = against(state, part, &plane, least);
            if found.reason == LeftReason::NoPlane || reason != LeftReason::NoPiece {
                found = Left { promise_mm2, reason, ..found };
            }
            if reason != LeftReason::NoPiece {
                break;
            }
        }
        all.push(found);
    }
    Ok(all)
}

/// What stands against a cut.
fn against(state: &State, part: usize, plane: &CutPlane, least: f64) -> LeftReason {
    let TuningOptions { max_parts, .. } = state.options;
    if state.nodes.len() >= max_parts {
        return LeftReason::MaxParts;
    }
    let Some(trial) = state.tried(part, plane) else { return LeftReason::NoPiece };
    if state.nodes[part].risky - trial.risky() < least {
        return LeftReason::TooLittle;
    }
    let tried = &trial.parts[1..];
    let meets = |standing: &[crate::planar::solid::Wall]| {
        tried.iter().any(|new| !state.head_passes_of(&new.direction, &new.walls, standing))
    };
    if tried.iter().any(|new| !state.head_passes(&new.direction, &new.walls, std::iter::empty())) {
        return LeftReason::Platform;
    }
    if let Some(earlier) = (0..part).find(|&earlier| meets(&state.nodes[earlier].walls)) {
        return LeftReason::Part(earlier);
    }
    if meets(&trial.parts[0].walls) || !state.trial_passes(part, &trial) {
        return LeftReason::Part(part);
    }
    if !trial.is_sound() {
        return LeftReason::Unsound;
    }
    if state.holds_when_cut(part, plane) { LeftReason::Untried } else { LeftReason::Weak }
}
