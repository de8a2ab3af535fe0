//! What the search for directions that meet has turned.

use nalgebra::UnitVector3;

/// What the search for directions that meet has turned, so that it costs no more than what it turns.
#[derive(Default)]
pub(super) struct Turned {
    /// Waypoints that were turned, with their directions before, in order; only while step 7 keeps them.
    pub before: Option<Vec<(usize, UnitVector3<f64>)>>,
    /// For each waypoint whether turning it toward the one before, and the one before toward it, is known to change nothing.
    pub settled: Vec<[bool; 2]>,
}

impl Turned {
    pub fn count(&self) -> usize {
        self.before.as_ref().map_or(0, Vec::len)
    }

    /// A waypoint has another direction: what was known of it and its neighbours no longer holds.
    pub fn unsettle(&mut self, k: usize) {
        self.settled.iter_mut().skip(k).take(2).for_each(|settled| *settled = [false; 2]);
    }
}
