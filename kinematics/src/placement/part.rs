//! Where a part should stand on its carrier, for a whole print.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1, puts the nozzle in the middle of what
//! the arm reaches, and the part in the middle of its carrier. Departs from it: the print is known here, so its place is
//! chosen by its own waypoints. A place is a shift in the plane of the plate and a turn about the plate's normal.
//!
//! Places are compared by the number of waypoints without a posture, then by the number of those with little clearance, then
//! by the smallest quality of any, then by their distance from the middle. Each of the first three only gets worse with each
//! further waypoint. So the search drops a place once it is no better than the best so far, with the rest of its
//! waypoints unseen, and the waypoints that were bad at other places come first.

use crate::pose::MAX_COORDINATE;
use crate::progress::{Progress, ProgressFn};
use crate::setup::Waypoint;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use std::cmp::Ordering;
use std::f64::consts::TAU;

/// Where a part stands on its carrier: waypoints of the part are turned about z of the part frame, then shifted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartPlace {
    /// Shift along x and y of the part frame, in millimetres.
    pub offset: [f64; 2],
    /// Turn about z of the part frame, in radians.
    pub turn: f64,
}

impl PartPlace {
    /// The same as a pose: it maps the part's own coordinates to the part frame of the workcell.
    pub fn pose(&self) -> Isometry3<f64> {
        let [x, y] = self.offset;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn);
        Isometry3::from_parts(Translation3::new(x, y, 0.0), turn)
    }

    /// A waypoint of the part, as the workcell has it with the part at this place.
    /// ```
    /// use curvlay_kinematics::nalgebra::{Point3, Vector3};
    /// use curvlay_kinematics::{PartPlace, Waypoint};
    /// let place = PartPlace { offset: [10.0, 0.0], turn: std::f64::consts::FRAC_PI_2 };
    /// let waypoint = Waypoint { position: Point3::new(1.0, 2.0, 3.0), axis: Vector3::x_axis() };
    /// let placed = place.waypoint(&waypoint);
    /// assert!((placed.position - Point3::new(8.0, 1.0, 3.0)).norm() < 1e-12);
    /// assert!((placed.axis.into_inner() - Vector3::y()).norm() < 1e-12);
    /// ```
    pub fn waypoint(&self, waypoint: &Waypoint) -> Waypoint {
        let (sin, cos) = self.turn.sin_cos();
        let turned = |v: &Vector3<f64>| Vector3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
        let [x, y] = self.offset;
        Waypoint {
            position: Point3::from(turned(&waypoint.position.coords) + Vector3::new(x, y, 0.0)),
            axis: UnitVector3::new_unchecked(turned(&waypoint.axis)),
        }
    }

    /// From the middle outwards; at the same distance by the size of the turn.
    fn outwards(&self, other: &Self) -> Ordering {
        let far = |place: &Self| place.offset[0].hypot(place.offset[1]);
        far(self).total_cmp(&far(other)).then(self.turn.abs().total_cmp(&other.turn.abs()))
    }
}

/// What a waypoint is worth at a place, at the best posture that it has there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment {
    /// How far apart things stay that must not touch, in millimetres; what is large may be cut off.
    pub clearance: f64,
    /// The greater, the better: the manipulability of the posture, its distance from stops, or the clearance itself.
    pub quality: f64,
}

/// Why no place is chosen.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceError {
    /// There is no place to choose from.
    #[error("the list of places is empty")]
    NoPlace,
    /// A shift or a turn is infinite, not a number, or beyond 1e6.
    #[error("place {index} has a shift or a turn that is not a number within 1e6 (mm, rad)")]
    Place {
        /// Its index in the input.
        index: usize,
    },
    /// A waypoint is infinite, not a number, or farther out than 1e6 mm.
    #[error("waypoint {index} is invalid: its numbers must be finite and within 1e6 mm")]
    Waypoint {
        /// Its index in the input.
        index: usize,
    },
    /// An option is not a number, or out of its range.
    #[error("`{what}` is {value}: it must be {must}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// An assessment that is not a number.
    #[error("the assessment of waypoint {waypoint} at place {place} is not a number")]
    Assessment {
        /// Index of the place in the input.
        place: usize,
        /// Index of the waypoint in the input.
        waypoint: usize,
    },
    /// The progress callback cancelled the search.
    #[error("cancelled")]
    Cancelled,
}

/// The best of several places.
#[derive(Clone, Debug, PartialEq)]
pub struct BestPlace {
    /// The place.
    pub place: PartPlace,
    /// Its index in the input.
    pub index: usize,
    /// Waypoints that have no posture there, in ascending order.
    pub unreachable: Vec<usize>,
    /// Waypoints with less than the wanted clearance there, in ascending order.
    pub tight: Vec<usize>,
    /// The smallest quality of any waypoint that has a posture; infinite where none has.
    pub min_quality: f64,
    /// How many assessments were made, at all places together.
    pub assessments: u64,
}

/// Chooses a place for a part: the one with the fewest waypoints without a posture; among these the fewest with less than
/// `min_clearance`; then the greatest smallest quality; then the nearest to the middle (smallest shift, then smallest turn,
/// then the first).
///
/// # Arguments
/// * `places`: to choose from, see [`place_grid`]. Whether the part stays on its plate is for the caller to see to.
/// * `waypoints`: of the print, in the part's own coordinates; 100 to 200 that are
///   [representative](crate::representative_waypoints) do.
/// * `min_clearance`: in millimetres; less is tight.
/// * `assess`: what a waypoint is worth at a place, `None` if it has no posture. It gets the place and the waypoint as the workcell
///   has it there. [`BestPosture`](crate::BestPosture) is one that is ready.
/// * `progress`: called before each place; breaks the search off.
///
/// # Errors
/// [`PlaceError`] names the place or the waypoint.
///
/// # Cost
/// At most `places * waypoints` assessments; far fewer where one place is much better than the others. One thread. The result
/// does not depend on the order in which waypoints are looked at, nor on what is dropped: it is that of all assessments.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Point3, Vector3};
/// use curvlay_kinematics::{Assessment, PartPlace, Waypoint, best_place, place_grid};
/// use std::ops::ControlFlow::Continue;
/// let print = [-40.0, 0.0, 40.0].map(|x| Waypoint { position: Point3::new(x, 0.0, 5.0), axis: Vector3::z_axis() });
/// // A robot that reaches 60 mm to the right, and 30 to the left.
/// let assess = |_: &PartPlace, at: &Waypoint| {
///     let clearance = (at.position.x + 30.0).min(60.0 - at.position.x);
///     (clearance > 0.0).then_some(Assessment { clearance, quality: clearance })
/// };
/// let best = best_place(&place_grid(30.0, 6, 1)?, &print, 2.0, assess, &|_| Continue(()))?;
/// assert_eq!(best.place, PartPlace { offset: [15.0, 0.0], turn: 0.0 });
/// assert!(best.unreachable.is_empty() && best.tight.is_empty());
/// # Ok::<(), curvlay_kinematics::PlaceError>(())
/// ```
pub fn best_place(
    places: &[PartPlace],
    waypoints: &[Waypoint],
    min_clearance: f64,
    mut assess: impl FnMut(&PartPlace, &Waypoint) -> Option<Assessment>,
    progress: ProgressFn<'_>,
) -> Result<BestPlace, PlaceError> {
    check(places, waypoints)?;
    if min_clearance.is_nan() {
        return Err(PlaceError::Option { what: "min_clearance", value: min_clearance, must: "a number" });
    }
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| places[a].outwards(&places[b]).then(a.cmp(&b)));
    // The waypoints that were bad most recently come first.
    let mut turns: Vec<usize> = (0..waypoints.len()).collect();
    let mut best: Option<(Score, usize)> = None;
    let mut assessments = 0;
    for (done, &index) in order.iter().enumerate() {
        let step = Progress { stage: "part place", done: done as u64, total: places.len() as u64 };
        if progress(step).is_break() {
            return Err(PlaceError::Cancelled);
        }
        let (place, mut score) = (&places[index], Score::default());
        let mut is_better = true;
        for turn in 0..turns.len() {
            let waypoint = turns[turn];
            let found = assess(place, &place.waypoint(&waypoints[waypoint]));
            assessments += 1;
            if found.is_some_and(|found| found.clearance.is_nan() || found.quality.is_nan()) {
                return Err(PlaceError::Assessment { place: index, waypoint });
            }
            let was = (score.unreachable.len(), score.tight.len(), score.min_quality);
            score.add(waypoint, found, min_clearance);
            let has_fault = (score.unreachable.len(), score.tight.len()) != (was.0, was.1);
            is_better = best.as_ref().is_none_or(|(best, _)| score.compare(best).is_lt());
            if has_fault || (!is_better && score.min_quality < was.2) {
                turns[..=turn].rotate_right(1);
            }
            if !is_better {
                break;
            }
        }
        // Without waypoints, all places are alike.
        if is_better && (best.is_none() || !waypoints.is_empty()) {
            best = Some((score, index));
        }
    }
    let (mut score, index) = best.ok_or(PlaceError::NoPlace)?;
    score.unreachable.sort_unstable();
    score.tight.sort_unstable();
    let Score { unreachable, tight, min_quality } = score;
    Ok(BestPlace { place: places[index], index, unreachable, tight, min_quality, assessments })
}

fn check(places: &[PartPlace], waypoints: &[Waypoint]) -> Result<(), PlaceError> {
    if places.is_empty() {
        return Err(PlaceError::NoPlace);
    }
    let sound = |place: &PartPlace| {
        place.turn.abs() <= MAX_COORDINATE && place.offset.iter().all(|x| x.abs() <= MAX_COORDINATE)
    };
    if let Some(index) = places.iter().position(|place| !sound(place)) {
        return Err(PlaceError::Place { index });
    }
    match waypoints.iter().position(|waypoint| !is_place(waypoint)) {
        Some(index) => Err(PlaceError::Waypoint { index }),
        None => Ok(()),
    }
}

pub(super) fn is_place(waypoint: &Waypoint) -> bool {
    waypoint.position.iter().chain(waypoint.axis.iter()).all(|x| x.abs() <= MAX_COORDINATE)
}

/// What is known of a place. Each part of it only gets worse.
#[derive(Clone, Debug)]
pub(super) struct Score {
    pub unreachable: Vec<usize>,
    pub tight: Vec<usize>,
    pub min_quality: f64,
}

impl Default for Score {
    fn default() -> Self {
        Score { unreachable: vec![], tight: vec![], min_quality: f64::INFINITY }
    }
}

impl Score {
    pub fn add(&mut self, waypoint: usize, found: Option<Assessment>, min_clearance: f64) {
        let Some(Assessment { clearance, quality }) = found else {
            self.unreachable.push(waypoint);
            return;
        };
        if clearance < min_clearance {
            self.tight.push(waypoint);
        }
        self.min_quality = self.min_quality.min(quality);
    }

    /// The smaller, the better.
    pub fn compare(&self, other: &Self) -> Ordering {
        let unreachable = self.unreachable.len().cmp(&other.unreachable.len());
        let tight = self.tight.len().cmp(&other.tight.len());
        unreachable.then(tight).then(other.min_quality.total_cmp(&self.min_quality))
    }
}

/// More places than this are a mistake.
const MAX_PLACES: f64 = 1e6;

/// Places on a square grid in a disc, each with `turns` even turns, from the middle outwards: the first is the middle, not
/// turned.
///
/// # Arguments
/// * `max_offset`: radius of the disc, in millimetres.
/// * `steps`: from the middle to its edge, along x and y; 0 leaves the middle.
/// * `turns`: 1 or more. One is enough where a table turns the part, and it stands near the middle.
///
/// # Errors
/// [`PlaceError::Option`] names the argument; more than a million places are refused.
///
/// # Example
/// ```
/// use curvlay_kinematics::{PartPlace, place_grid};
/// let places = place_grid(20.0, 1, 4)?;
/// assert_eq!((places.len(), places[0]), (5 * 4, PartPlace::default()));
/// # Ok::<(), curvlay_kinematics::PlaceError>(())
/// ```
pub fn place_grid(max_offset: f64, steps: u32, turns: u32) -> Result<Vec<PartPlace>, PlaceError> {
    if !(0.0..=MAX_COORDINATE).contains(&max_offset) {
        let must = "from 0 to 1e6 mm";
        return Err(PlaceError::Option { what: "max_offset", value: max_offset, must });
    }
    if turns == 0 {
        return Err(PlaceError::Option { what: "turns", value: 0.0, must: "at least 1" });
    }
    let along = 2.0 * f64::from(steps) + 1.0;
    if along * along * f64::from(turns) > MAX_PLACES {
        let must = "small enough for a million places in all";
        return Err(PlaceError::Option { what: "steps", value: f64::from(steps), must });
    }
    let edge = i64::from(steps);
    let mut places = Vec::new();
    for (y, x) in (-edge..=edge).flat_map(|y| (-edge..=edge).map(move |x| (y, x))) {
        if x * x + y * y > edge * edge {
            continue;
        }
        let step = |k: i64| if steps == 0 { 0.0 } else { max_offset * k as f64 / f64::from(steps) };
        for k in 0..turns {
            let turn = TAU * f64::from(k) / f64::from(turns);
            let turn = if 2 * k > turns { turn - TAU } else { turn };
            places.push(PartPlace { offset: [step(x), step(y)], turn });
        }
    }
    places.sort_by(PartPlace::outwards);
    Ok(places)
}
