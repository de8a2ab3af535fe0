//! Curves in the sense in which they are travelled.

use super::Visit;
use crate::path::SurfacePath;

impl SurfacePath {
    /// The same curve as it is travelled in an order: from another start if it is closed, or backward.
    ///
    /// # Panics
    /// If `visit` starts a closed curve at a point that is not there.
    pub fn travelled(&self, visit: &Visit) -> SurfacePath {
        let mut path = self.clone();
        path.turn(visit);
        path
    }

    /// Makes it [travelled](Self::travelled) in place.
    pub(crate) fn turn(&mut self, visit: &Visit) {
        let start = visit.start as usize;
        match (self.closed, visit.reversed) {
            (true, false) => self.points.rotate_left(start),
            (true, true) => {
                self.points.rotate_left(start + 1);
                self.points.reverse();
            }
            (false, true) => self.points.reverse(),
            (false, false) => {}
        }
    }
}
