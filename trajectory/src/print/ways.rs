//! The ways to all runs of a layer, and other postures for paths to which, or from which, no way leads.
//!
//! A path is planned near where the one before ends, not for the way to it: its first posture may be shut in between links of the arm
//! and the part. Then the path behind the gap gets the postures of another branch, or the one before it, if that
//! leaves fewer gaps and no more faults; a few paths in a row do, where the next one goes on where it began.

use super::options::{PrintError, PrintPath};
use super::plan::{Run, Travel};
use super::postures::{Chosen, others};
use super::run::{Planned, smoothed};
use super::run_plan::Task;
use super::travel::{Search, travel};
use super::workcell::{PrintRobot, PrintWorkcell};
use crate::parallel;
use std::time::{Duration, Instant};

/// Paths that get other postures at most, to close one gap.
const MAX_CHAIN: usize = 4;

/// The paths that get other postures: those behind a gap or those before it.
#[derive(Clone, Copy)]
enum Side {
    Behind,
    Before,
}

/// What other postures of a path did to the gap at one of its ends.
enum Step {
    Closed,
    /// It is at the other end now: the place of the way that is missing.
    Moved(usize),
    Stuck,
}

/// What came of a travel: the motion, or why there is none.
pub(super) type Found<const N: usize> = (Result<Travel<N>, String>, Duration);

/// A layer whose paths have motions.
pub(super) struct Ways<'a, const N: usize, const F: usize, R, C> {
    /// All of the print.
    pub paths: &'a [PrintPath<'a>],
    /// Those of the layer.
    pub chosen: &'a [Chosen<N, F>],
    /// The workcell before the layer, and with it.
    pub workcells: [&'a C; 2],
    /// The last run of the layers before.
    pub before: Option<&'a Run<N, F>>,
    /// Travels of the layers before: a seed.
    pub first: usize,
    pub task: &'a Task<'a, N, F, R>,
}

impl<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>> Ways<'_, N, F, R, C> {
    /// The ways from run to run, the first of them from the layer before.
    pub fn find(&self, planned: &mut Vec<Planned<N, F>>) -> Result<Vec<Found<N>>, PrintError> {
        let count = self.runs(planned).len().saturating_sub(1);
        let mut found = self.between(planned, &(0..count).collect::<Vec<_>>(), Search::Short)?;
        for gap in 0..count {
            if found[gap].0.is_err() {
                self.close(gap, planned, &mut found)?;
            }
        }
        let gaps: Vec<usize> = (0..count).filter(|&gap| found[gap].0.is_err()).collect();
        replace(&mut found, &gaps, self.between(planned, &gaps, Search::Long)?);
        Ok(found)
    }

    /// All runs between which there are travels.
    fn runs<'b>(&'b self, planned: &'b [Planned<N, F>]) -> Vec<&'b Run<N, F>> {
        self.before.into_iter().chain(planned.iter().flat_map(|path| &path.runs)).collect()
    }

    /// Some of the ways, by their place among those of the layer.
    fn between(&self, planned: &[Planned<N, F>], which: &[usize], search: Search) -> Result<Vec<Found<N>>, PrintError> {
        let runs = self.runs(planned);
        parallel::map(which, |&way| {
            // The way to the layer is gone before any of it is there.
            let [before, with] = self.workcells;
            let workcell = if way == 0 && self.before.is_some() { before } else { with };
            let start = Instant::now();
            let found = travel(self.first + way, [runs[way], runs[way + 1]], self.task, workcell, search);
            if (self.task.stopped)() { Err(PrintError::Cancelled) } else { Ok((found, start.elapsed())) }
        })
    }

    /// Closes a gap: gives the path behind it other postures, or else the path before it. Where that only moves the gap to the other end
    /// of the path, the next one gets other postures as well.
    fn close(&self, gap: usize, planned: &mut Vec<Planned<N, F>>, found: &mut Vec<Found<N>>) -> Result<(), PrintError> {
        for side in [Side::Behind, Side::Before] {
            let (mut paths, mut ways, mut left) = (planned.clone(), found.clone(), Some(gap));
            for _ in 0..MAX_CHAIN {
                let Some(gap) = left else { break };
                match self.step(gap, side, &mut paths, &mut ways)? {
                    Step::Closed => {
                        (*planned, *found) = (paths, ways);
                        return Ok(());
                    }
                    Step::Moved(next) => left = Some(next),
                    Step::Stuck => left = None,
                }
            }
        }
        Ok(())
    }

    /// Gives one path beside a gap other postures: the first with which there are fewer gaps, else the first with which the gap has
    /// moved to its other end.
    fn step(
        &self,
        gap: usize,
        side: Side,
        planned: &mut [Planned<N, F>],
        found: &mut [Found<N>],
    ) -> Result<Step, PrintError> {
        // Paths of the layer by run, from the first to which a way leads.
        let of_run = planned.iter().enumerate().flat_map(|(place, path)| path.runs.iter().map(move |_| place));
        let paths: Vec<Option<usize>> = self.before.iter().map(|_| None).chain(of_run.map(Some)).collect();
        let run = match side {
            Side::Behind => gap + 1,
            Side::Before => gap,
        };
        let Some(place) = paths[run] else { return Ok(Step::Stuck) };
        let ends: Vec<usize> = (0..found.len()).filter(|&way| paths[way..way + 2].contains(&Some(place))).collect();
        let gaps = ends.iter().filter(|&&way| found[way].0.is_err()).count();
        let before = paths.iter().position(|path| *path == Some(place)).and_then(|run| run.checked_sub(1));
        let from = before.and_then(|run| self.runs(planned)[run].trajectory.joints().last().copied());
        let Chosen { prepared, .. } = &self.chosen[place];
        let mut moved = None;
        for ladders in others(prepared, from, self.task, self.workcells[0]) {
            let chosen = Chosen { prepared: prepared.clone(), ladders };
            let mut path = smoothed(&chosen, &self.paths[prepared.path], self.task, self.workcells[0])?;
            let old = &planned[place];
            if path.runs.len() != old.runs.len() || path.faults.len() > old.faults.len() {
                continue;
            }
            path.took += old.took;
            let old = std::mem::replace(&mut planned[place], path);
            let ways = self.between(planned, &ends, Search::Short)?;
            let left: Vec<usize> =
                ends.iter().zip(&ways).filter(|(_, way)| way.0.is_err()).map(|(&end, _)| end).collect();
            if left.len() < gaps {
                replace(found, &ends, ways);
                return Ok(Step::Closed);
            }
            let path = std::mem::replace(&mut planned[place], old);
            if moved.is_none() && left.len() == gaps && !left.contains(&gap) {
                moved = left.first().map(|&next| (next, path, ways));
            }
        }
        let Some((next, path, ways)) = moved else { return Ok(Step::Stuck) };
        planned[place] = path;
        replace(found, &ends, ways);
        Ok(Step::Moved(next))
    }
}

/// Puts new ways in their places.
fn replace<const N: usize>(found: &mut [Found<N>], places: &[usize], ways: Vec<Found<N>>) {
    for (&place, (way, took)) in places.iter().zip(ways) {
        found[place] = (way, found[place].1 + took);
    }
}
