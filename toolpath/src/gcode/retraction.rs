//! Retractions put into a stream of moves that has none.

use super::Move;
use nalgebra::{Point3, distance};
use std::collections::VecDeque;

/// Filament drawn back for travels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retraction {
    /// How much of it, 0 to 1e6 mm. Default 1.
    pub filament_mm: f64,
    /// How fast, 0.001 to 1e5 mm/s. Default 30.
    pub feed_mm_s: f64,
    /// Shorter ways between two beads go without; of their first 64 moves. Default 2 mm.
    pub min_travel_mm: f64,
}

impl Default for Retraction {
    fn default() -> Self {
        Retraction { filament_mm: 1.0, feed_mm_s: 30.0, min_travel_mm: 2.0 }
    }
}

/// Moves that are held back until it is known how long the way between two beads is.
const HELD: usize = 64;

/// The moves, each with the number of the one it belongs to, and the retractions among them. What lies between two
/// beads is held back; where the caller has strokes of their own in it, it is left alone.
pub(super) struct Retracting<I> {
    moves: I,
    /// Number of the next move.
    index: u64,
    retraction: Option<Retraction>,
    held: VecDeque<(u64, Move)>,
    ready: VecDeque<(u64, Move)>,
    /// Whether the last thing done was a bead, so that what comes is held.
    holding: bool,
    /// Whether a retraction of ours is not yet taken back.
    owed: bool,
    at: Option<Point3<f64>>,
    /// Length of the way that is held.
    way: f64,
    /// Whether a stroke of the caller's is among what is held.
    stroke: bool,
}

impl<I: Iterator<Item = Move>> Retracting<I> {
    pub fn new(moves: I, retraction: Option<Retraction>) -> Self {
        let (held, ready) = (VecDeque::new(), VecDeque::new());
        let (holding, owed, stroke) = (false, false, false);
        Retracting { moves, index: 0, retraction, held, ready, holding, owed, at: None, way: 0.0, stroke }
    }

    /// Lets go of what is held.
    fn release(&mut self, retraction: Retraction) {
        if let Some(&(index, _)) = self.held.front()
            && !self.stroke
            && self.way >= retraction.min_travel_mm
        {
            let Retraction { filament_mm, feed_mm_s, .. } = retraction;
            self.ready.push_back((index, Move::Retract { filament_mm, feed_mm_s }));
            self.owed = true;
        }
        self.ready.append(&mut self.held);
        (self.way, self.stroke, self.holding) = (0.0, false, false);
    }
}

impl<I: Iterator<Item = Move>> Iterator for Retracting<I> {
    type Item = (u64, Move);

    fn next(&mut self) -> Option<(u64, Move)> {
        loop {
            if let Some(ready) = self.ready.pop_front() {
                return Some(ready);
            }
            let next = self.moves.next().map(|item| (self.index, item));
            self.index += u64::from(next.is_some());
            let Some(retraction) = self.retraction else {
                return next;
            };
            let Some((index, item)) = next else {
                if self.held.is_empty() {
                    return None;
                }
                self.release(retraction);
                continue;
            };
            match item {
                Move::Print { tip, .. } => {
                    self.release(retraction);
                    if std::mem::take(&mut self.owed) {
                        let Retraction { filament_mm, feed_mm_s, .. } = retraction;
                        self.ready.push_back((index, Move::Prime { filament_mm, feed_mm_s }));
                    }
                    self.ready.push_back((index, item));
                    (self.at, self.holding) = (Some(tip), true);
                    continue;
                }
                Move::Travel { tip, .. } | Move::Lay { tip, .. } => {
                    self.way += self.at.map_or(0.0, |at| distance(&at, &tip));
                    self.at = Some(tip);
                }
                Move::Retract { .. } | Move::Prime { .. } => self.stroke = true,
                Move::Home => (self.at, self.way) = (None, f64::INFINITY),
                _ => {}
            }
            if !self.holding {
                return Some((index, item));
            }
            self.held.push_back((index, item));
            if self.held.len() == HELD {
                self.release(retraction);
            }
        }
    }
}
