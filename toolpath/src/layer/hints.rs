//! Directions in which a nozzle is known to get to some places, from which searches start there.
//!
//! Where a part is grown by the shape of the nozzle, a direction is known for each place that takes one. Beads there are often
//! laid against undersides: the direction away from what is built below points down into the plate, and the free ones lie more than a
//! right angle away from it. So where none is found the search starts again, from the direction that is known.
//!
//! Places stand in a grid of cells as wide as the reach, so one is found among those of 27 cells.

use crate::cells::cell_of;
use nalgebra::{Point3, UnitVector3};

/// Reaches and coordinates beyond this, in millimetres, are refused: numbers of cells stay exact.
const MAX_COORDINATE_MM: f64 = 1e7;

/// And the reach is at least this, in millimetres, for the same reason.
const MIN_REACH: f64 = 1e-6;

/// Directions known at some places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectionHints {
    reach: f64,
    /// By cell of the grid, then in the order given.
    places: Vec<([i64; 3], Place)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    number: usize,
    at: Point3<f64>,
    direction: UnitVector3<f64>,
}

/// Why hints cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HintError {
    /// The reach is out of its range.
    #[error("a reach of {reach_mm} mm: it must lie between 1e-6 and 1e7")]
    Reach {
        /// The reach.
        reach_mm: f64,
    },
    /// A place or a direction is invalid.
    #[error("place {place} is not finite, beyond 1e7 mm, or has no unit direction")]
    Place {
        /// Its number, from 0.
        place: usize,
    },
}

impl DirectionHints {
    /// Keeps directions for the places around some points.
    ///
    /// # Arguments
    /// * `known`: points in millimetres, each with the direction from the tip of the nozzle into it.
    /// * `reach_mm`: how far around a point its direction holds.
    ///
    /// # Errors
    /// [`HintError`].
    ///
    /// # Cost
    /// `O(n log n)` for `n` points.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::layer::DirectionHints;
    /// let known = [(Point3::origin(), Vector3::z_axis()), (Point3::new(2.0, 0.0, 0.0), Vector3::x_axis())];
    /// let hints = DirectionHints::new(&known, 1.5)?;
    /// assert_eq!(hints.at(Point3::new(1.2, 0.0, 0.0)), Some(Vector3::x_axis())); // both are near, this one nearer
    /// assert_eq!(hints.at(Point3::new(0.0, 1.6, 0.0)), None);
    /// # Ok::<(), curvlay_toolpath::layer::HintError>(())
    /// ```
    pub fn new(known: &[(Point3<f64>, UnitVector3<f64>)], reach_mm: f64) -> Result<Self, HintError> {
        if !(MIN_REACH..=MAX_COORDINATE_MM).contains(&reach_mm) {
            return Err(HintError::Reach { reach_mm });
        }
        let is_sound = |(at, direction): &(Point3<f64>, UnitVector3<f64>)| {
            at.iter().all(|c| c.abs() <= MAX_COORDINATE_MM) && (direction.norm_squared() - 1.0).abs() < 1e-6
        };
        if let Some(place) = known.iter().position(|place| !is_sound(place)) {
            return Err(HintError::Place { place });
        }
        let mut hints = DirectionHints { reach: reach_mm, places: Vec::with_capacity(known.len()) };
        for (number, &(at, direction)) in known.iter().enumerate() {
            hints.places.push((cell_of(at, reach_mm), Place { number, at, direction }));
        }
        hints.places.sort_by_key(|&(cell, _)| cell);
        Ok(hints)
    }

    /// The direction of the nearest point within reach, if there is one; of several as near the first given.
    pub fn at(&self, p: Point3<f64>) -> Option<UnitVector3<f64>> {
        if self.places.is_empty() {
            return None;
        }
        let [x, y, z] = cell_of(p, self.reach);
        let mut best: Option<(f64, &Place)> = None;
        for [x, y] in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| [x, y])) {
            // The three cells along z stand beside each other.
            let start = self.places.partition_point(|&(cell, _)| cell < [x, y, z - 1]);
            for (_, place) in self.places[start..].iter().take_while(|&&(cell, _)| cell <= [x, y, z + 1]) {
                let distance = (place.at - p).norm();
                let is_nearer = |(least, other): (f64, &Place)| {
                    distance < least || distance <= least && place.number < other.number
                };
                if distance <= self.reach && best.is_none_or(is_nearer) {
                    best = Some((distance, place));
                }
            }
        }
        best.map(|(_, place)| place.direction)
    }
}
