//! Which of the candidates to build so that nothing is shadowed.
//!
//! Dai 2020, section 3.4.3 (Algorithms 2 and 3); Boge 2019, section 4.4.5 (her Algorithm 2).
//!
//! All candidates together are tried first. What they would shadow, the *endangered* cells, is all that a part of
//! them can shadow, since its hull is smaller. Each endangered cell keeps a plane with the front below and itself above (or
//! less than `eps` below), so a set of candidates that stays below all of these planes does no harm, without a look
//! at the hull. Only where a plane is crossed is the hull asked for another one.

use super::GrowthError;
use super::front::{Front, Protected};
use super::order::{by_distance, groups};
use crate::curved::buildable::accessibility::{Endangered, dot};
use curvlay_hull::Plane;
use nalgebra::{Matrix3, Vector3};

/// What came of the candidates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Selection {
    /// All of them were built.
    pub(super) whole: bool,
    /// Sets that were tried.
    pub(super) trials: u64,
}

impl Selection {
    /// Builds all candidates, whatever they shadow (Algorithm 1).
    pub(super) fn take_all(front: &mut Front, candidates: &[u32]) -> Result<Self, GrowthError> {
        front.build_all(candidates)?;
        Ok(Selection { whole: true, trials: 1 })
    }
}

/// Tries the candidates all at once, then by halves (Algorithm 3).
pub(super) fn adaptive(front: &mut Front, candidates: &[u32], protected: Protected) -> Result<Selection, GrowthError> {
    Trial::run(front, candidates, protected, |trial, candidates| {
        let mut stack: Vec<&mut [u32]> = Vec::from([candidates]);
        while let Some(part) = stack.pop() {
            if let Err(blocker) = trial.accept(part)? {
                match part {
                    [single] => trial.front.block(*single, blocker),
                    _ => {
                        let middle = split(trial.front, part);
                        let (near, far) = part.split_at_mut(middle);
                        stack.extend([far, near]);
                    }
                }
            }
        }
        Ok(())
    })
}

/// Tries the candidates one by one, in the order of their distance from the first one (Algorithm 2).
pub(super) fn incremental(
    front: &mut Front,
    candidates: &[u32],
    offsets: &[[i32; 3]],
    protected: Protected,
) -> Result<Selection, GrowthError> {
    Trial::run(front, candidates, protected, |trial, candidates| {
        for cell in by_distance(candidates, &trial.front.proposed, offsets) {
            if let Err(blocker) = trial.accept(&[cell])? {
                trial.front.block(cell, blocker);
            }
        }
        Ok(())
    })
}

/// Sets of candidates on trial for one layer.
struct Trial<'a> {
    front: &'a mut Front,
    endangered: Vec<Guarded>,
    accepted: Vec<u32>,
    added: Vec<[i32; 3]>,
    trials: u64,
}

/// An endangered cell and the plane that shows it to be accessible.
struct Guarded {
    cell: u32,
    centre: [i32; 3],
    normal: [i64; 3],
    /// Anything new must stay below this height along the normal.
    limit: i64,
}

impl Guarded {
    fn new(cell: u32, centre: [i32; 3], proof: &Plane) -> Self {
        Guarded { cell, centre, normal: proof.normal, limit: dot(proof.normal, centre) + proof.margin() }
    }
}

fn guard(front: &Front, shadowed: &[Endangered]) -> Vec<Guarded> {
    shadowed.iter().map(|e| Guarded::new(e.cell, front.centre(e.cell), &e.proof)).collect()
}

impl Trial<'_> {
    /// Builds all candidates if that shadows nothing, else those that `select` accepts.
    fn run(
        front: &mut Front,
        candidates: &[u32],
        protected: Protected,
        select: impl FnOnce(&mut Trial, &mut [u32]) -> Result<(), GrowthError>,
    ) -> Result<Selection, GrowthError> {
        front.propose(candidates);
        let selection = Self::run_proposed(front, candidates, protected, select);
        front.withdraw(candidates);
        selection
    }

    fn run_proposed(
        front: &mut Front,
        candidates: &[u32],
        protected: Protected,
        select: impl FnOnce(&mut Trial, &mut [u32]) -> Result<(), GrowthError>,
    ) -> Result<Selection, GrowthError> {
        let start = front.hull.checkpoint();
        front.insert(candidates)?;
        let added = front.hull.added_since(&start).to_vec();
        let in_danger = front.take_in_danger(&added, protected);
        // Hulls of parts lie in the hull of all: what all do not shadow no part does.
        if in_danger.shadowed.is_empty() {
            front.hull.commit(start);
            front.settle(candidates, &added, &in_danger);
            return Ok(Selection { whole: true, trials: 1 });
        }
        front.hull.rollback(start);
        let guarded = guard(front, &in_danger.shadowed);
        // What lies in the hull already does no harm; only the others are tried.
        let is_tried = |&&cell: &&u32| protected == Protected::All || front.extends_hull(cell);
        let (mut tried, accepted): (Vec<u32>, Vec<u32>) = candidates.iter().partition(is_tried);
        let mut trial = Trial { front, endangered: guarded, accepted, added: Vec::new(), trials: 1 };
        select(&mut trial, &mut tried)?;
        let Trial { mut accepted, added, trials, .. } = trial;
        if accepted.is_empty() {
            // The hull is as it was, and so are the proofs.
            front.put_back(&in_danger);
        } else {
            accepted.sort_unstable();
            front.settle(&accepted, &added, &in_danger);
        }
        Ok(Selection { whole: false, trials })
    }

    /// Accepts `part` unless it shadows a cell; then says which.
    fn accept(&mut self, part: &[u32]) -> Result<Result<(), u32>, GrowthError> {
        self.trials += 1;
        let centres: Vec<_> = part.iter().map(|&cell| self.front.centre(cell)).collect();
        let crossed: Vec<usize> = (0..self.endangered.len())
            .filter(|&at| {
                let guarded = &self.endangered[at];
                centres.iter().any(|&p| dot(guarded.normal, p) >= guarded.limit)
            })
            .collect();
        if let (Some(&at), [_, _, ..]) = (crossed.first(), part) {
            // What one candidate shadows, any set with it shadows too: the one that crosses the plane the farthest is
            // looked at alone, before all of them go into the hull.
            let Guarded { cell, centre, normal, .. } = self.endangered[at];
            let farthest = (0..part.len()).max_by_key(|&k| dot(normal, centres[k])).unwrap_or(0);
            let start = self.front.hull.checkpoint();
            self.front.insert(&part[farthest..=farthest])?;
            let shadowed = self.front.hull.witness(centre, &mut self.front.hint).is_none();
            self.front.hull.rollback(start);
            if shadowed {
                self.endangered.swap(0, at);
                return Ok(Err(cell));
            }
        }
        let start = self.front.hull.checkpoint();
        self.front.insert(part)?;
        let mut renewed = Vec::with_capacity(crossed.len());
        for at in crossed {
            let Guarded { cell, centre, .. } = self.endangered[at];
            match self.front.hull.witness(centre, &mut self.front.hint) {
                Some(proof) => renewed.push((at, Guarded::new(cell, centre, &proof))),
                None => {
                    self.front.hull.rollback(start);
                    self.endangered.swap(0, at); // what stops one part often stops the next
                    return Ok(Err(cell));
                }
            }
        }
        self.added.extend(self.front.hull.added_since(&start));
        self.front.hull.commit(start);
        // Only now: had the part been refused, the hull and with it the old planes would hold on.
        for (at, guarded) in renewed {
            self.endangered[at] = guarded;
        }
        self.accepted.extend(part);
        Ok(Ok(()))
    }
}

/// The held-back candidates to build regardless of what they shadow: of the groups that hang together the one that
/// shadows the fewest cells; none if nothing is held back.
pub(super) fn cheapest_group(front: &mut Front, offsets: &[[i32; 3]]) -> Result<Vec<u32>, GrowthError> {
    let blocked = front.blocked();
    front.propose(&blocked);
    let start = front.hull.checkpoint();
    front.insert(&blocked)?;
    let added = front.hull.added_since(&start).to_vec();
    let in_danger = front.take_in_danger(&added, Protected::Others);
    front.hull.rollback(start);
    let guarded = guard(front, &in_danger.shadowed);
    let mut cheapest = (usize::MAX, Vec::new());
    // No group can shadow what all of them together do not.
    for group in groups(&blocked, &front.proposed, offsets) {
        let start = front.hull.checkpoint();
        front.insert(&group)?;
        let is_shadowed = |guarded: &&Guarded| front.hull.witness(guarded.centre, &mut front.hint).is_none();
        let cost = guarded.iter().filter(is_shadowed).count();
        front.hull.rollback(start);
        if cost < cheapest.0 {
            cheapest = (cost, group);
        }
    }
    front.put_back(&in_danger);
    front.withdraw(&blocked);
    Ok(cheapest.1)
}

/// Sorts `part` along its longest principal axis and returns where to cut it: between the cells on either side of
/// the mean. Cells are distinguished by their numbers, so the order is the same each time.
fn split(front: &Front, part: &mut [u32]) -> usize {
    let points: Vec<_> = part.iter().map(|&cell| Vector3::from(front.centre(cell).map(f64::from))).collect();
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let axes = spread.symmetric_eigen();
    let axis = axes.eigenvectors.column(axes.eigenvalues.imax());
    let beyond = |cell: u32| (Vector3::from(front.centre(cell).map(f64::from)) - mean).dot(&axis) > 0.0;
    // Stable, so that both halves stay in the order of numbers.
    part.sort_by_key(|&cell| beyond(cell));
    let middle = part.partition_point(|&cell| !beyond(cell));
    if (1..part.len()).contains(&middle) { middle } else { part.len() / 2 }
}

/// Tries the candidates one by one in their order; one is kept if that leaves fewer cells shadowed than all
/// candidates together would (Boge's Algorithm 2; its line 6 is printed the wrong way round: there is something to improve
/// when more cells are shadowed than before); with a threshold fewer than that.
pub(super) fn fewer_than(
    front: &mut Front,
    candidates: &[u32],
    threshold: Option<usize>,
) -> Result<Selection, GrowthError> {
    let mut untested: Vec<u32> = front.waiting.iter().collect();
    untested.retain(|cell| !candidates.contains(cell));
    let start = front.hull.checkpoint();
    front.insert(candidates)?;
    let shadowed_by_all = front.count_deep(&untested);
    front.hull.rollback(start);
    if shadowed_by_all == 0 {
        return Selection::take_all(front, candidates);
    }
    let threshold = threshold.unwrap_or(shadowed_by_all);
    let outer = front.hull.checkpoint();
    let mut untested: Vec<u32> = front.waiting.iter().collect();
    // From here on candidates count among the untested until it is their turn: one that is kept may shadow them.
    let mut kept = Vec::new();
    for &cell in candidates.iter() {
        let start = front.hull.checkpoint();
        front.insert(&[cell])?;
        untested.retain(|&other| other != cell);
        if front.count_deep(&untested) < threshold {
            front.hull.commit(start);
            kept.push(cell);
        } else {
            front.hull.rollback(start);
        }
    }
    front.hull.rollback(outer);
    let trials = candidates.len() as u64 + 1;
    front.build_all(if kept.is_empty() { candidates } else { &kept })?;
    Ok(Selection { whole: false, trials })
}
