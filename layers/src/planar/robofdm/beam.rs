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
//! Departures. Where the search does not reach its goal, the fine decomposition of the best start, RoboFDM's own way, is tried as well, and the
//! better result taken. A plane cuts one part, not all that lies above it, and what is cut off may be cut again. What a plane would save is
//! rated for all offsets of a normal at once; the most promising ones, different from each other, are tried on the solid.

use super::error::RoboFdmError;
use super::options::{TuningOptions, min_gain};
use super::sequence::BuildSequence;
use super::split::Trial;
use super::state::{Node, Promises, State, are_near};
use super::tuning::{Decomposition, finely_decomposed, polished};
use crate::parallel::map_items;
use crate::planar::{CutPlane, Solid};
use crate::{Progress, ProgressFn};
use nalgebra::Vector3;
use std::ops::ControlFlow;
use std::sync::Arc;

/// How wide the search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamOptions {
    /// Constraints, planes that are tried, and when to end. Options of perturbation are for the sequence, if one is given.
    pub tuning: TuningOptions,
    /// Direction in which the first part is printed, of any length. Default z.
    pub direction: Vector3<f64>,
    /// Partial results that are kept. Default 10, that of Wu et al. With each halving of [`TuningOptions::spacing`] it is halved, too.
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
}

impl Member {
    /// What ranks it: less risky first, then fewer parts, then less seam.
    fn rank(&self) -> Rank {
        Rank { risky: self.state.risky(), parts: self.state.nodes.len(), seam: self.state.seam() }
    }

    /// The most promising cuts, different from each other.
    fn cuts(&mut self, least: f64, most: usize) -> Vec<(f64, usize, CutPlane)> {
        let planes = self.state.planes(&mut self.known, least);
        let cells: Vec<u32> = self.state.nodes.iter().map(|node| node.cell).collect();
        self.known.retain(|cell, _| cells.contains(cell));
        let spacing = self.state.options.spacing;
        let mut cuts: Vec<(f64, usize, CutPlane)> = Vec::new();
        for (promise, node, plane) in planes {
            if cuts.len() == most {
                break;
            }
            if !cuts.iter().any(|(_, other, known)| *other == node && are_near(known, &plane, spacing)) {
                cuts.push((promise, node, plane));
            }
        }
        cuts
    }
}

/// What a partial result is judged by.
#[derive(Clone, Copy)]
struct Rank {
    risky: f64,
    parts: usize,
    seam: f64,
}

impl Rank {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let parts = self.parts.cmp(&other.parts);
        self.risky.total_cmp(&other.risky).then(parts).then(self.seam.total_cmp(&other.seam))
    }

    /// The same cuts in another order, as far as that shows.
    fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
        self.parts == other.parts && near(self.risky, other.risky) && near(self.seam, other.seam)
    }
}

/// A cut of a partial result that was not tried yet, and what would be left then if it keeps its promise.
struct Candidate {
    left: f64,
    member: usize,
    node: usize,
    plane: CutPlane,
}

impl Candidate {
    /// Tries the cut; `None` if it is worth nothing, or cannot be made.
    fn tried(&self, beam: &[Member], least: f64) -> Option<(Rank, Trial)> {
        let state = &beam[self.member].state;
        let trial = state.tried(self.node, &self.plane)?;
        let Node { risky, seam, .. } = state.nodes[self.node];
        let rank = Rank {
            risky: state.risky() - risky + trial.risky(),
            parts: state.nodes.len() + trial.parts.len() - 1,
            seam: state.seam() - seam + trial.seam(),
        };
        let counts = risky - trial.risky() >= least
            && state.trial_passes(self.node, &trial)
            && trial.is_sound()
            && state.holds_when_cut(self.node, &self.plane);
        counts.then_some((rank, trial))
    }
}

/// Cuts that are noted for each that is wanted of a partial result.
const TRIALS: usize = 3;

/// Cuts that are tried at once. Constant, so that the result does not depend on threads.
const AT_ONCE: usize = 8;

/// The next partial results: cuts in the order of what they promise, until so many are made that are worth it and differ.
fn next_beam(beam: &mut [Member], least: f64, width: usize, branches: usize) -> Vec<Member> {
    rate(beam, least);
    let mut candidates = Vec::new();
    for (member, of) in beam.iter_mut().enumerate() {
        let risky = of.state.risky();
        let candidate = |(promise, node, plane)| Candidate { left: risky - promise, member, node, plane };
        candidates.extend(of.cuts(least, TRIALS * branches).into_iter().map(candidate));
    }
    let beam = &*beam;
    // Stable: of equals that of the better partial result.
    candidates.sort_by(|a, b| a.left.total_cmp(&b.left));
    let mut made: Vec<(Rank, &Candidate)> = Vec::new();
    let mut of_member = vec![0; beam.len()];
    for some in candidates.chunks(AT_ONCE) {
        if made.len() >= width {
            break;
        }
        let tried = map_items(some, |candidate| candidate.tried(beam, least).map(|(rank, _)| rank));
        for (candidate, rank) in some.iter().zip(tried) {
            let Some(rank) = rank else { continue };
            if of_member[candidate.member] < branches && !made.iter().any(|(known, _)| known.is_like(&rank)) {
                of_member[candidate.member] += 1;
                made.push((rank, candidate));
            }
        }
    }
    made.sort_by(|a, b| a.0.order(&b.0));
    made.truncate(width);
    map_items(&made, |(_, candidate)| {
        let mut member = beam[candidate.member].clone();
        member.state.split(candidate.node, &candidate.plane);
        member
    })
}

/// Rates planes through the riskiest parts of all partial results. Many have a part in common: it is rated once.
fn rate(beam: &mut [Member], least: f64) {
    let mut jobs: Vec<Vec<(usize, usize)>> = Vec::new();
    for (at, Member { state, known }) in beam.iter().enumerate() {
        for node in state.riskiest(least).into_iter().filter(|&node| !known.contains_key(&state.nodes[node].cell)) {
            // A part is the same one if what is known of it is in the same place.
            let walls = &state.nodes[node].walls;
            let is_same = |of: &&mut Vec<(usize, usize)>| Arc::ptr_eq(&beam[of[0].0].state.nodes[of[0].1].walls, walls);
            match jobs.iter_mut().find(is_same) {
                Some(of) => of.push((at, node)),
                None => jobs.push(vec![(at, node)]),
            }
        }
    }
    let rated = map_items(&jobs, |of| Arc::new(beam[of[0].0].state.rated(of[0].1, least)));
    for (of, promises) in jobs.into_iter().zip(rated) {
        for (at, node) in of {
            let cell = beam[at].state.nodes[node].cell;
            beam[at].known.insert(cell, Arc::clone(&promises));
        }
    }
}

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
    progress: ProgressFn,
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
    let report =
        |stage, done: usize, total: usize| match progress(Progress { stage, done: done as u64, total: total as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RoboFdmError::Cancelled),
        };
    let up = options.direction / length;
    let whole = State::whole(solid, up, &options.tuning);
    let before = whole.risky();
    let member = |state: State| Member { state, known: Promises::new() };
    let mut beam = vec![member(whole.clone())];
    if let Some(sequence) = sequence {
        let mut state = whole;
        state.follow(sequence, &|done, total| report("planes", done, total))?;
        state.merge();
        if state.nodes.len() <= options.tuning.max_parts {
            beam.push(member(state));
        }
    }
    beam.sort_by(|a, b| a.rank().order(&b.rank()));
    let mut best = beam[0].clone();
    let start = best.state.clone();
    let first = best.rank().risky;
    let goal = options.tuning.goal * before;
    let (mut halvings, mut width) = (0, options.width);
    while best.rank().risky > goal {
        report("beam", best.state.nodes.len(), options.tuning.max_parts)?;
        beam.retain(|member| member.state.nodes.len() < options.tuning.max_parts);
        let next = next_beam(&mut beam, min_gain(halvings) * before, width, options.branches);
        if next.is_empty() {
            if halvings == options.tuning.halvings || beam.is_empty() {
                break;
            }
            // What is left takes finer planes, and a seam that pays less. Partial results differ little by now.
            halvings += 1;
            width = width.div_ceil(2);
            beam.truncate(width);
            for member in &mut beam {
                member.state.options = member.state.options.finer();
                member.known.clear();
            }
            continue;
        }
        beam = next;
        if beam[0].rank().order(&best.rank()).is_lt() {
            best = beam[0].clone();
        }
    }
    let mut state = best.state;
    state.merge();
    if sequence.is_some() && state.risky() > goal {
        let own = finely_decomposed(&start, before, &report)?;
        if own.risky() < state.risky() {
            state = own;
        }
    }
    state = polished(state, before, &report)?;
    let after = state.risky();
    Decomposition::of(&state, before, [first, first, after], &report)
}
