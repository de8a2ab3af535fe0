//! A beam search over cutting planes, for parts of any genus.
//!
//! C. Wu, C. Dai, G. Fang, Y.-J. Liu and C. C. L. Wang, "General support-effective decomposition for multi-directional 3D printing", IEEE
//! Transactions on Automation Science and Engineering 17(2), 2020: planes of sampled normals and offsets cut a solid one after another; the
//! best few partial results are kept (there `b` = 10), so that a cut which saves little at once may lead to more. It needs no
//! skeleton and no segments, which handles and loops lead astray.
//!
//! What makes a cut feasible is what [`tune`](super::tune) asks for: what is cut off is less risky along the plane's normal and rests on its
//! section, what is left below holds on to the platform or to what carries it (no piece floats), no section is cut, and the head meets
//! nothing that stands ([`TuningOptions::head`]), or else the plane looks up.
//!
//! Departures. A plane cuts one part, not all that lies above it, and what is cut off may be cut again. What a plane would save is
//! rated for all offsets of a normal at once; the most promising ones, different from each other, are tried on the solid.

use super::error::RoboFdmError;
use super::sequence::BuildSequence;
use super::state::{Promises, Split, State, are_near};
use super::tuning::{Decomposition, LEAST_GAIN, TuningOptions};
use crate::Progress;
use crate::planar::{CutPlane, Solid};
use nalgebra::Vector3;
#[cfg(feature = "rayon")]
use rayon::prelude::*;
use std::ops::ControlFlow;

/// How wide the search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamOptions {
    /// Constraints, planes that are tried, and when to end. Options of perturbation are for the sequence, if one is given.
    pub tuning: TuningOptions,
    /// Direction in which the first part is printed, of any length. Default z.
    pub direction: Vector3<f64>,
    /// Partial results that are kept. Default 10, that of Wu et al.
    pub width: usize,
    /// Cuts that are tried on each of them. Default 6.
    pub branches: usize,
}

impl Default for BeamOptions {
    fn default() -> Self {
        BeamOptions { tuning: TuningOptions::default(), direction: Vector3::z(), width: 10, branches: 6 }
    }
}

/// A partial result.
#[derive(Clone)]
struct Member {
    state: State,
    known: Promises,
    risky: f64,
    seam: f64,
}

impl Member {
    fn of(state: State, known: Promises) -> Self {
        Member { risky: state.risky(), seam: state.seam(), state, known }
    }

    /// Less risky first, then fewer parts, then less seam.
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let parts = self.state.nodes.len().cmp(&other.state.nodes.len());
        self.risky.total_cmp(&other.risky).then(parts).then(self.seam.total_cmp(&other.seam))
    }

    /// The same cuts in another order, as far as that shows.
    fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
        self.state.nodes.len() == other.state.nodes.len()
            && near(self.risky, other.risky)
            && near(self.seam, other.seam)
    }

    /// What comes of the most promising cuts.
    fn children(&mut self, least: f64, branches: usize) -> Vec<Member> {
        let planes = self.state.planes(&mut self.known, least);
        let cells: Vec<u32> = self.state.nodes.iter().map(|node| node.cell).collect();
        self.known.retain(|cell, _| cells.contains(cell));
        let mut tried: Vec<(usize, CutPlane)> = Vec::new();
        let mut children: Vec<Member> = Vec::new();
        for (_, node, plane) in planes {
            let spacing = self.state.options.spacing;
            if tried.iter().any(|(other, known)| *other == node && are_near(known, &plane, spacing)) {
                continue;
            }
            if tried.len() >= TRIALS * branches || children.len() >= branches {
                break;
            }
            tried.push((node, plane));
            let mut next = self.state.clone();
            if next.split(node, &plane) == Split::Made {
                let child = Member::of(next, self.known.clone());
                if self.risky - child.risky >= least {
                    children.push(child);
                }
            }
        }
        children
    }
}

/// Cuts that are tried for each that is wanted.
const TRIALS: usize = 3;

/// Cuts a solid by a beam search.
///
/// # Arguments
/// * `sequence`: a plan of RoboFDM's second phase in the same direction; the solid cut along it is then one of the first partial results,
///   beside the solid in one piece.
///
/// # Returns
/// The parts, the first of which stands on the platform. `risky_after_phases_mm2` has the risky area of the best first partial result
/// twice, and that of the result.
///
/// # Errors
/// [`RoboFdmError::Option`] for an option out of range, [`RoboFdmError::Part`] for a part that does not bound a solid,
/// [`RoboFdmError::Cancelled`] if `progress` says so.
///
/// # Cost
/// That of `width` fine decompositions, at most. With the feature `rayon` partial results are shared out among threads; the result is
/// the same.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::Solid;
/// use curvlay_layers::planar::robofdm::{BeamOptions, TuningOptions, beam_search};
/// use std::ops::ControlFlow;
/// // A beam, 4 mm thick, on its edge: nothing to cut.
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 40.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 4.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let solid = Solid::new(&points, &faces)?;
/// let parts = beam_search(&solid, None, &BeamOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((parts.parts.len(), parts.risky_mm2()), (1, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn beam_search(
    solid: &Solid,
    sequence: Option<&BuildSequence>,
    options: &BeamOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Decomposition, RoboFdmError> {
    options.tuning.check()?;
    let counts = [("width", options.width), ("branches", options.branches)];
    if let Some((name, value)) = counts.into_iter().find(|(_, value)| !(1..=10_000).contains(value)) {
        return Err(RoboFdmError::Option { name, value: value as f64 });
    }
    let length = options.direction.norm();
    if !(length > 0.0 && length.is_finite()) {
        return Err(RoboFdmError::Option { name: "direction", value: length });
    }
    let tell =
        |stage, done: usize, total: usize| match progress(Progress { stage, done: done as u64, total: total as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RoboFdmError::Cancelled),
        };
    let up = options.direction / length;
    let whole = State::whole(solid, up, &options.tuning);
    let before = whole.risky();
    let mut beam = vec![Member::of(whole.clone(), Promises::new())];
    if let Some(sequence) = sequence {
        let mut state = whole;
        state.follow(sequence, &|done, total| tell("planes", done, total))?;
        state.merge();
        beam.push(Member::of(state, Promises::new()));
    }
    beam.sort_by(Member::order);
    let mut best = beam[0].clone();
    let first = best.risky;
    let (least, goal) = (LEAST_GAIN * before, options.tuning.goal * before);
    let mut halvings = 0;
    while best.risky > goal {
        tell("beam", best.state.nodes.len(), options.tuning.max_parts)?;
        beam.retain(|member| member.state.nodes.len() < options.tuning.max_parts);
        let grow = |member: &mut Member| member.children(least, options.branches);
        #[cfg(feature = "rayon")]
        let grown: Vec<Vec<Member>> = beam.par_iter_mut().map(grow).collect();
        #[cfg(not(feature = "rayon"))]
        let grown: Vec<Vec<Member>> = beam.iter_mut().map(grow).collect();
        let mut children: Vec<Member> = grown.into_iter().flatten().collect();
        if children.is_empty() {
            if halvings == options.tuning.halvings || beam.is_empty() {
                break;
            }
            // What is left takes finer planes, and a seam that pays less.
            halvings += 1;
            for member in &mut beam {
                member.state.options.spacing /= 2.0;
                member.state.options.seam_cost /= 2.0;
                member.known.clear();
            }
            continue;
        }
        children.sort_by(Member::order);
        children.dedup_by(|later, earlier| later.is_like(earlier));
        children.truncate(options.width);
        beam = children;
        if beam[0].order(&best).is_lt() {
            best = beam[0].clone();
        }
    }
    let mut state = best.state;
    state.merge();
    let after = state.risky();
    Ok(Decomposition {
        parts: state.printed()?,
        risky_before_mm2: before,
        risky_after_phases_mm2: [first, first, after],
    })
}
