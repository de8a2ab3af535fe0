//! Phase III: a solid is cut along the planes of a sequence, and its parts are tuned until little of them is risky.
//!
//! Dissertation, section 2.4.3. Each plane is tried at random places near its own (*plane perturbation*); parts whose union is no worse are
//! one (*region merging*); the riskiest parts are cut again, by the best of many planes (*fine decomposition*, Eq. 2.2).
//! Constraint I: no two base sections intersect. Constraint II: all base planes look up; with [`TuningOptions::head`] instead: the head meets nothing that stands. Planes that break one are not used.
//!
//! Departures. A plane cuts only the section that it was made for, and not what it meets elsewhere. A section towards a later part is a
//! surface while its own part is printed, so it is risky if it looks down. A cut is tried on the solid before it is taken, so that pieces
//! that would float are seen.

use super::error::RoboFdmError;
use super::options::{Report, TuningOptions, min_gain};
use super::parts::PrintedPart;
use super::reasons::{Left, left};
use super::sequence::BuildSequence;
use super::state::{Promises, State};
use super::strength::Hold;
use crate::planar::Solid;
use crate::{Progress, ProgressFn};
use std::ops::ControlFlow;

/// A solid in parts, in the order in which they are printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// The parts.
    pub parts: Vec<PrintedPart>,
    /// Risky area of the whole solid, printed in the direction of the first part, in mm2.
    pub risky_before_mm2: f64,
    /// Risky area after the planes of the sequence were perturbed, after parts were merged, and after the fine
    /// decomposition, in mm2.
    pub risky_after_phases_mm2: [f64; 3],
    /// How each part is held by what is below it; empty without [`TuningOptions::strength`].
    pub holds: Vec<Hold>,
    /// Why risky area is left, by parts in their order; empty where the goal is met.
    pub left: Vec<Left>,
}

impl Decomposition {
    /// The parts of a state that is done.
    pub(super) fn of(state: &State, before: f64, after: [f64; 3], report: &Report) -> Result<Self, RoboFdmError> {
        Ok(Decomposition {
            parts: state.printed()?,
            risky_before_mm2: before,
            risky_after_phases_mm2: after,
            holds: state.holds(),
            left: left(state, before, report)?,
        })
    }

    /// Risky area of all parts, in mm2.
    pub fn risky_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.risky_mm2).sum()
    }

    /// Area of all seams, in mm2.
    pub fn seam_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.seam_mm2).sum()
    }
}

/// Cuts a solid along a sequence of planes and tunes the parts.
///
/// # Returns
/// The parts; the first one stands on the platform. Risky area may be left: see [`Decomposition::risky_mm2`].
///
/// # Errors
/// [`RoboFdmError::Option`] for an option out of range, [`RoboFdmError::Part`] for a part that does not bound a solid,
/// [`RoboFdmError::Cancelled`] if `progress` says so.
///
/// # Cost
/// A cut of the mesh for each perturbation and each trial, and for each fine cut `normals` operations for each triangle of the riskiest parts.
/// One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::Solid;
/// use curvlay_layers::planar::robofdm::{SegmentOptions, SequenceOptions, TuningOptions, plan_sequence, segment, tune};
/// use std::ops::ControlFlow;
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let segmentation = segment(&points, &faces, &SegmentOptions::default())?;
/// let sequence = plan_sequence(&points, &faces, &segmentation, &SequenceOptions::default())?;
/// let solid = Solid::new(&points, &faces)?;
/// let parts = tune(&solid, &sequence, &TuningOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((parts.parts.len(), parts.risky_mm2()), (1, 0.0)); // a rod needs no support
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tune(
    solid: &Solid,
    sequence: &BuildSequence,
    options: &TuningOptions,
    progress: ProgressFn,
) -> Result<Decomposition, RoboFdmError> {
    options.check()?;
    let Some(root) = sequence.parts.first() else { return Err(RoboFdmError::Empty) };
    let whole = State::whole(solid, root.direction, options);
    let mut state = whole.clone();
    let before = state.risky();
    let report =
        |stage, done: usize, total: usize| match progress(Progress { stage, done: done as u64, total: total as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RoboFdmError::Cancelled),
        };
    state.follow(sequence, &|done, total| report("planes", done, total))?;
    let mut after = [state.risky(); 3];
    report("merging", 0, 1)?;
    state.merge();
    // Segments of a solid that needs no support may well need some, and where a head is in the way not all can be merged.
    if state.risky() > before || state.nodes.len() > options.max_parts {
        state = whole;
    }
    after[1] = state.risky();
    state = polished(finely_decomposed(&state, before, &report)?, before, &report)?;
    after[2] = state.risky();
    Decomposition::of(&state, before, after, &report)
}

/// From which halving of the distance of planes on each plane is refined, one way after the other until the goal is reached.
const REFINED_FROM: [u32; 3] = [u32::MAX, 1, 0];

/// Fine decomposition of a state, merged again; where it misses the goal also with planes refined, and the best result taken. A refined
/// plane saves more at once, but the best cut now is not always the best one in the end.
pub(super) fn finely_decomposed(state: &State, before: f64, report: &Report) -> Result<State, RoboFdmError> {
    let mut best: Option<State> = None;
    for refined_from in REFINED_FROM {
        let mut next = decomposed(state, before, refined_from, report)?;
        next.merge();
        let risky = next.risky();
        if best.as_ref().is_none_or(|best| risky < best.risky()) {
            best = Some(next);
        }
        if risky <= state.options.goal * before {
            break;
        }
    }
    Ok(best.unwrap_or_else(|| state.clone()))
}

/// Cuts a state on as long as that pays at the finest distance of planes: merging makes parts through which planes were not tried yet, and a beam
/// may end before all of its last state were.
pub(super) fn polished(mut state: State, before: f64, report: &Report) -> Result<State, RoboFdmError> {
    let (mut known, least) = (Promises::new(), min_gain(state.options.halvings) * before);
    while state.risky() > state.options.goal * before && state.nodes.len() < state.options.max_parts {
        report("cuts", state.nodes.len(), state.options.max_parts)?;
        if !state.cut_finely(&mut known, least, true) {
            break;
        }
    }
    Ok(state)
}

/// The best cut of one of the riskiest parts, again and again.
fn decomposed(state: &State, before: f64, refined_from: u32, report: &Report) -> Result<State, RoboFdmError> {
    let (mut state, mut known, mut halvings) = (state.clone(), Promises::new(), 0);
    while state.risky() > state.options.goal * before && state.nodes.len() < state.options.max_parts {
        report("cuts", state.nodes.len(), state.options.max_parts)?;
        if state.cut_finely(&mut known, min_gain(halvings) * before, halvings >= refined_from) {
            continue;
        }
        if halvings == state.options.halvings {
            break;
        }
        // What is left takes finer planes, and a seam that pays less.
        halvings += 1;
        state.options = state.options.finer();
        known.clear();
    }
    Ok(state)
}
