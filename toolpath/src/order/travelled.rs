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
        let start = visit.start as usize;
        match (self.closed, visit.reversed) {
            (true, false) => path.points.rotate_left(start),
            (true, true) => {
                path.points.rotate_left(start + 1);
                path.points.reverse();
            }
            (false, true) => path.points.reverse(),
            (false, false) => {}
        }
        path
    }
}
