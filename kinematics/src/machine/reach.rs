//! Why a machine does not reach a place, and what would help.

use super::geometry::FiveAxis;
use super::inverse::{NoPair, Pair};
use crate::angle::nearest_image;
use nalgebra::{Point3, UnitVector3, Vector3};

/// What keeps a machine from a place of the part.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unreachable {
    /// A coordinate is not finite.
    #[error("the place is not finite")]
    NotFinite,
    /// No readings of the rotary axes bring the nozzle to this direction, whatever their ranges.
    #[error(
        "the direction is {:.2} degrees beyond what the two rotary axes reach: tilt the layers less, or use a machine whose axes are at right \
         angles", beyond.to_degrees()
    )]
    Direction {
        /// The angle to the nearest direction that is reached.
        beyond: f64,
    },
    /// The nozzle does not pass the turning axis near enough to reach a tip of the part so near to it.
    #[error(
        "the tip is {short_mm:.3} mm nearer to the turning axis than the nozzle passes it: align the nozzle with the axis, or move the part away from it"
    )]
    Place {
        /// By how much the nozzle passes too far away, mm.
        short_mm: f64,
    },
    /// A rotary axis would have to turn beyond its range.
    #[error(
        "{letter} would be at {:.2} degrees, {:.2} beyond its range of {:.2} to {:.2}: tilt the layers or the part less, turn the part, or widen `range_deg`",
        value.to_degrees(), beyond.to_degrees(), range[0].to_degrees(), range[1].to_degrees()
    )]
    Rotary {
        /// Its letter.
        letter: char,
        /// Where it would be, radians.
        value: f64,
        /// How far beyond the nearest end, radians.
        beyond: f64,
        /// Its ends.
        range: [f64; 2],
    },
    /// A linear axis would have to move beyond its range.
    #[error(
        "{letter} would be at {value_mm:.2} mm, {beyond_mm:.2} beyond its range of {:.2} to {:.2}: move the part (`part_origin_mm`), or widen `range_mm`",
        range_mm[0], range_mm[1]
    )]
    Linear {
        /// Its letter.
        letter: char,
        /// Where it would be.
        value_mm: f64,
        /// How far beyond the nearest end.
        beyond_mm: f64,
        /// Its ends.
        range_mm: [f64; 2],
    },
    /// Both ends of a motion are reached, but nothing between them leads from one to the other.
    #[error(
        "no values of the axes lead on from here within their ranges: tilt the layers less, or widen the ranges of the rotary axes"
    )]
    Gap,
}

/// How much of a part a machine reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Places that were asked for.
    pub places: u64,
    /// Those out of reach.
    pub unreachable: u64,
    /// The one that is farthest out of reach: by angle, and of those by length.
    pub worst: Option<FarthestPlace>,
}

/// The place of a part that is farthest out of reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarthestPlace {
    /// Its number, from 0.
    pub index: u64,
    /// Where it is.
    pub tip: Point3<f64>,
    /// Why it is not reached.
    pub reason: Unreachable,
}

fn beyond(value: f64, [min, max]: [f64; 2]) -> f64 {
    (min - value).max(value - max).max(0.0)
}

impl FiveAxis {
    /// What keeps the machine from a place, by the solution that needs least beyond the ranges; `None` where [`FiveAxis::inverse`] finds solutions.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::machine::{FiveAxis, Unreachable};
    /// use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
    /// # #[cfg(feature = "serde")] {
    /// let file = include_str!("../../../examples/machines/bc-table-tcp.json");
    /// let machine = FiveAxis::from_json(file.as_bytes())?;
    /// let down = -Vector3::z_axis();
    /// let why = machine.unreachable(&Point3::origin(), &down).ok_or("it reaches that")?;
    /// assert!(matches!(why, Unreachable::Rotary { letter: 'B', .. }), "{why}");
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn unreachable(&self, tip: &Point3<f64>, direction: &UnitVector3<f64>) -> Option<Unreachable> {
        if !tip.iter().chain(direction.iter()).all(|value| value.is_finite()) {
            return Some(Unreachable::NotFinite);
        }
        let near = self.rotary_of(&self.start());
        match self.pairs(&tip.coords, direction, near) {
            Err(NoPair::Direction(beyond)) => Some(Unreachable::Direction { beyond }),
            Err(NoPair::Place(short_mm)) => Some(Unreachable::Place { short_mm }),
            Ok(pairs) => {
                let reasons = pairs.iter().flatten().map(|pair| self.beyond_of(&tip.coords, pair));
                let mut least: Option<Unreachable> = None;
                for reason in reasons {
                    let reason = reason?;
                    if least.is_none_or(|least| rank(&reason) < rank(&least)) {
                        least = Some(reason);
                    }
                }
                least
            }
        }
    }

    /// Which places of a whole part the machine does not reach.
    ///
    /// # Arguments
    /// * `places`: tips and directions, as of [`FiveAxis::inverse`].
    ///
    /// # Cost
    /// Some 200 ns a place, no memory.
    pub fn reach(&self, places: impl IntoIterator<Item = (Point3<f64>, UnitVector3<f64>)>) -> Reach {
        let mut reach = Reach { places: 0, unreachable: 0, worst: None };
        for (tip, direction) in places {
            if let Some(reason) = self.unreachable(&tip, &direction) {
                reach.unreachable += 1;
                let (angle, length) = rank(&reason);
                let is_worse = |worst: &FarthestPlace| {
                    let (most, longest) = rank(&worst.reason);
                    angle > most || (angle >= most && length > longest)
                };
                if reach.worst.as_ref().is_none_or(is_worse) {
                    reach.worst = Some(FarthestPlace { index: reach.places, tip, reason });
                }
            }
            reach.places += 1;
        }
        reach
    }

    /// What keeps the machine from a pair.
    fn beyond_of(&self, tip: &Vector3<f64>, pair: &Pair) -> Option<Unreachable> {
        let mut least: Option<Unreachable> = None;
        for (k, axis) in self.rotary.iter().enumerate() {
            if axis.images(pair.rotary[k], axis.zero).is_some() {
                continue;
            }
            let [min, max] = axis.range;
            // The range holds no image, so the nearest one to its middle is as near as any.
            let value = nearest_image(pair.rotary[k], 0.5 * (min + max));
            let letter = self.letters[self.linear.len() + k];
            let reason = Unreachable::Rotary { letter, value, beyond: beyond(value, axis.range), range: axis.range };
            if least.is_none_or(|least| rank(&reason) > rank(&least)) {
                least = Some(reason);
            }
        }
        least.or_else(|| self.beyond_linear(&self.place(tip, &pair.rotary)))
    }

    /// The linear axis that is farthest beyond its range.
    pub(super) fn beyond_linear(&self, values: &Vector3<f64>) -> Option<Unreachable> {
        if self.has_linear(values) {
            return None;
        }
        let reason = |k: usize| {
            let range_mm = self.linear[k].range;
            let beyond_mm = beyond(values[k], range_mm);
            Unreachable::Linear { letter: self.letters[k], value_mm: values[k], beyond_mm, range_mm }
        };
        let all = (0..self.linear.len()).map(reason);
        all.max_by(|a, b| rank(a).1.total_cmp(&rank(b).1))
    }
}

/// Angles count before lengths.
fn rank(reason: &Unreachable) -> (f64, f64) {
    match *reason {
        Unreachable::NotFinite => (f64::INFINITY, 0.0),
        Unreachable::Direction { beyond } | Unreachable::Rotary { beyond, .. } => (beyond, 0.0),
        Unreachable::Linear { beyond_mm, .. } => (0.0, beyond_mm),
        Unreachable::Place { short_mm } => (0.0, short_mm),
        Unreachable::Gap => (0.0, 0.0),
    }
}
