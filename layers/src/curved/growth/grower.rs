//! Layer after layer: who is a candidate when, and what is left at the end.

use super::front::{Front, Protected};
use super::peel::SheetField;
use super::prevention::{self, Selection};
use super::{Candidates, Growth, GrowthError, GrowthOptions, GrowthStatistics, Prevention, Visit};
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::supported_by_platform;
use std::collections::BTreeMap;

/// The state between two layers.
pub(super) struct Grower<'a> {
    cells: &'a Cells<'a>,
    platform: &'a Platform,
    rules: &'a Rules,
    options: &'a GrowthOptions,
    offsets: Vec<[i32; 3]>,
    pub(super) front: Front,
    /// Cells that have been candidates or wait to become one.
    reached: CellSet,
    /// Candidates for the next layer.
    candidates: Vec<u32>,
    /// Neighbours of what is built that wait for the threshold to reach their value of the governing field, by it.
    waiting_for: BTreeMap<u32, Vec<u32>>,
    governor: Option<&'a SheetField>,
    threshold: u32,
    statistics: GrowthStatistics,
}

impl<'a> Grower<'a> {
    pub(super) fn new(
        cells: &'a Cells<'a>,
        platform: &'a Platform,
        rules: &'a Rules,
        options: &'a GrowthOptions,
        governor: Option<&'a SheetField>,
    ) -> Result<Self, GrowthError> {
        let first = supported_by_platform(cells, platform, rules)?;
        if first.is_empty() {
            return Err(GrowthError::NothingOnPlatform);
        }
        let mut offsets = rules.neighbours.offsets().to_vec();
        if options.visit == Visit::HighestFirst {
            offsets.sort_by_key(|offset| -offset[2]);
        }
        let mut front = Front::new(cells, platform, rules)?;
        front.build_all(&first)?;
        let mut growth = Grower {
            cells,
            platform,
            rules,
            options,
            offsets,
            front,
            reached: CellSet::none(cells),
            candidates: Vec::new(),
            waiting_for: BTreeMap::new(),
            governor,
            threshold: 0,
            statistics: GrowthStatistics::default(),
        };
        growth.collect_candidates();
        Ok(growth)
    }

    /// Builds one more layer; false if there is nothing left to build.
    pub(super) fn next_layer(&mut self) -> Result<bool, GrowthError> {
        self.raise_threshold();
        let Grower { front, candidates, options, .. } = self;
        if candidates.is_empty() {
            // All that could be built is held back: to go on, something must be lost.
            *candidates = prevention::cheapest_group(front, &self.offsets)?;
            if candidates.is_empty() {
                return Ok(false);
            }
            self.statistics.sacrifices += 1;
            front.build_all(candidates)?;
            candidates.clear();
            self.collect_candidates();
            return Ok(true);
        }
        let layers = front.order.len();
        let selection = match options.prevention {
            Prevention::None => Selection::take_all(front, candidates)?,
            Prevention::Incremental => prevention::incremental(front, candidates, &self.offsets, Protected::Others)?,
            Prevention::Adaptive => prevention::adaptive(front, candidates, Protected::Others)?,
            Prevention::FewerThanAll => prevention::fewer_than(front, candidates, None)?,
            Prevention::FewerThan(threshold) => prevention::fewer_than(front, candidates, Some(threshold as usize))?,
        };
        self.statistics.trials += selection.trials;
        self.statistics.whole_layers += u64::from(selection.whole);
        if options.candidates == Candidates::OfLastLayer {
            // As printed: nothing is remembered of candidates that were not built, and they come again only beside a later layer.
            front.forget_blocking();
            if front.order.len() == layers {
                self.statistics.sacrifices += 1;
                front.build_all(candidates)?;
            }
            candidates.iter().for_each(|&cell| self.reached.remove(cell));
        }
        self.candidates.clear();
        self.collect_candidates();
        Ok(true)
    }

    /// Adds the neighbours of the last layer to the candidates, and candidates that nothing holds back any more.
    fn collect_candidates(&mut self) {
        let Some(last) = self.front.order.len().checked_sub(1) else { return };
        self.candidates.append(&mut self.front.freed);
        for &cell in self.front.order.layer(last) {
            for neighbour in self.front.waiting.around(cell, &self.offsets) {
                // Once is enough: a candidate that is not built is held back, and comes back when what holds it back is built or lost.
                if self.reached.insert(neighbour) {
                    match self.governor.map_or(0, |field| field.value(neighbour)) {
                        value if value <= self.threshold => self.candidates.push(neighbour),
                        value => self.waiting_for.entry(value).or_default().push(neighbour),
                    }
                }
            }
        }
        if self.options.candidates == Candidates::OfAllLayers {
            self.complete_candidates();
        }
    }

    /// Adds what is held back because of a candidate, since the two may be built in one layer, and sorts all.
    fn complete_candidates(&mut self) {
        let mut done = 0;
        // The list grows while it is walked: what one candidate lets go of may hold others back.
        while let Some(&candidate) = self.candidates.get(done) {
            self.front.free_behind(candidate);
            self.candidates.append(&mut self.front.freed);
            done += 1;
        }
        self.candidates.sort_unstable();
        self.candidates.dedup();
    }

    /// Raises the threshold until there is a candidate, or none waits for a higher one.
    fn raise_threshold(&mut self) {
        loop {
            let front = &self.front;
            // Candidates that waited for the threshold may have come to lie inside meanwhile.
            self.candidates.retain(|&cell| front.waiting.contains(cell));
            if !self.candidates.is_empty() {
                return;
            }
            // Where nothing waits for a higher threshold, cells have to be given up: what that makes way for is governed again.
            let Some((value, reached)) = self.waiting_for.pop_first() else { return };
            self.threshold = value;
            self.candidates = reached;
            self.complete_candidates();
        }
    }

    /// The order, and what has no layer with the reasons.
    pub(super) fn finish(self) -> Growth {
        self.front.finish(self.cells, self.platform, self.rules, self.statistics)
    }
}
