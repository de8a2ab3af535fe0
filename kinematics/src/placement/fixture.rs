//! The best place of a fixture: a nozzle, a plate or a table, within the region that the workcell allows.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1, counts frames in a box, which knows no
//! collisions: the more the arm is in its own way the better. Here a place is worth what the waypoints of a part are worth there, as in
//! [`best_place`](crate::best_place): the fewest waypoints without a free posture, then the fewest with little clearance, then the greatest smallest quality.
//!
//! Coarse to fine: all places of a coarse grid, then from the best one steps to all its neighbours, halved when none of them is
//! better. It is no proof that there is no better place between those of the grid.

use super::part::{Assessment, PlaceError, Score, is_place};
use crate::pose::MAX_COORDINATE;
use crate::progress::{Progress, ProgressFn};
use crate::setup::Waypoint;
use nalgebra::{Point3, Vector3};

/// Where a fixture may be, and how finely places are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixtureRegion {
    /// The corner with the smallest coordinates, in millimetres. Along a coordinate in which both corners are the same nothing moves.
    pub min: Point3<f64>,
    /// The corner with the greatest.
    pub max: Point3<f64>,
    /// Places of the grid are no farther apart than this, in millimetres.
    pub coarse_mm: f64,
    /// The last steps are no longer than this, in millimetres.
    pub fine_mm: f64,
}

/// The best place that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct BestFixturePlace {
    /// The place.
    pub place: Point3<f64>,
    /// Waypoints that have no free posture there, in ascending order.
    pub unreachable: Vec<usize>,
    /// Waypoints with less than the wanted clearance there, in ascending order.
    pub tight: Vec<usize>,
    /// The smallest quality of any waypoint that has a posture; infinite where none has.
    pub min_quality: f64,
    /// Places that were looked at.
    pub places: usize,
    /// How many assessments were made, at all places together.
    pub assessments: u64,
    /// Whether the place lies at an end of the region along a coordinate in which it could move: beyond it there may be a better one.
    pub at_end: [bool; 3],
}

/// More places of the coarse grid than this are a mistake.
const MAX_PLACES: f64 = 1e5;

/// Finds the best place in a region.
///
/// # Arguments
/// * `waypoints`: of a part, as the workcell has them; not all of a print, some dozens that are spread over it.
/// * `min_clearance`: in millimetres; less is tight.
/// * `at`: the workcell with everything at a place, as what says what a waypoint is worth there; `None` where nothing can stand.
/// * `progress`: called before each place; its total grows with the search. It may break the search off.
///
/// # Errors
/// [`PlaceError`] names the option or the waypoint; [`PlaceError::NoPlace`] where nothing can stand anywhere.
///
/// # Cost
/// A few hundred places, each of at most `waypoints` assessments; the search drops a place once it is worse than the best. The result does not depend
/// on what is dropped.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Point3, Vector3};
/// use curvlay_kinematics::{Assessment, FixtureRegion, Waypoint, best_fixture_place};
/// use std::ops::ControlFlow::Continue;
/// // An arm that reaches from 200 to 600 mm, and is best at 390.
/// let region = FixtureRegion { min: Point3::new(0.0, 0.0, 50.0), max: Point3::new(800.0, 0.0, 50.0), coarse_mm: 100.0, fine_mm: 2.0 };
/// let waypoints = [Waypoint { position: Point3::origin(), axis: Vector3::z_axis() }];
/// let at = |place: &Point3<f64>| {
///     let x = place.x;
///     Some(move |_: usize, _: &Waypoint| {
///         (200.0..=600.0).contains(&x).then_some(Assessment { clearance: 10.0, quality: -(x - 390.0).abs() })
///     })
/// };
/// let best = best_fixture_place(&region, &waypoints, 5.0, at, &|_| Continue(()))?;
/// assert!((best.place.x - 390.0).abs() <= 2.0 && best.place.z == 50.0 && best.unreachable.is_empty());
/// assert_eq!(best.at_end, [false; 3]);
/// # Ok::<(), curvlay_kinematics::PlaceError>(())
/// ```
pub fn best_fixture_place<A: FnMut(usize, &Waypoint) -> Option<Assessment>>(
    region: &FixtureRegion,
    waypoints: &[Waypoint],
    min_clearance: f64,
    at: impl FnMut(&Point3<f64>) -> Option<A>,
    progress: ProgressFn<'_>,
) -> Result<BestFixturePlace, PlaceError> {
    let grid = checked(region, waypoints, min_clearance)?;
    let mut search = Search {
        waypoints,
        min_clearance,
        at,
        best: None,
        places: 0,
        assessments: 0,
        turns: (0..waypoints.len()).collect(),
    };
    let total = grid.len() as u64;
    for place in &grid {
        search.step(place, total, progress)?;
    }
    let (_, mut place) = search.best.clone().ok_or(PlaceError::NoPlace)?;
    // Half the distance between places of the grid along each coordinate, halved on.
    let mut step = spacing(region) * 0.5;
    while step.amax() * 2.0 > region.fine_mm {
        let before = place;
        for side in 0..27 {
            let sides =
                Vector3::new(f64::from(side % 3) - 1.0, f64::from(side / 3 % 3) - 1.0, f64::from(side / 9) - 1.0);
            let next = before + step.component_mul(&sides);
            let is_inside = (0..3).all(|k| (region.min[k]..=region.max[k]).contains(&next[k]));
            if next != before && is_inside {
                search.step(&next, total, progress)?;
            }
        }
        if let Some((_, best)) = &search.best {
            place = *best;
        }
        if place == before {
            step *= 0.5;
        }
    }
    let Search { best, places, assessments, .. } = search;
    let (score, place) = best.ok_or(PlaceError::NoPlace)?;
    let Score { mut unreachable, mut tight, min_quality } = score;
    unreachable.sort_unstable();
    tight.sort_unstable();
    let at_end = [0, 1, 2].map(|k| {
        let (min, max) = (region.min[k], region.max[k]);
        max > min && (place[k] - min).min(max - place[k]) < region.fine_mm
    });
    Ok(BestFixturePlace { place, unreachable, tight, min_quality, places, assessments, at_end })
}

/// Places of the grid along a coordinate, less one.
fn parts(region: &FixtureRegion) -> [f64; 3] {
    [0, 1, 2].map(|k| ((region.max[k] - region.min[k]) / region.coarse_mm).ceil())
}

fn spacing(region: &FixtureRegion) -> Vector3<f64> {
    let parts = parts(region);
    Vector3::from([0, 1, 2].map(|k| if parts[k] > 0.0 { (region.max[k] - region.min[k]) / parts[k] } else { 0.0 }))
}

/// The coarse grid, the middle of the region first, since a good place drops the others sooner.
fn checked(region: &FixtureRegion, waypoints: &[Waypoint], min_clearance: f64) -> Result<Vec<Point3<f64>>, PlaceError> {
    for (what, value) in [("coarse_mm", region.coarse_mm), ("fine_mm", region.fine_mm)] {
        if !(value > 0.0 && value <= MAX_COORDINATE) {
            return Err(PlaceError::Option { what, value, must: "above 0 and at most 1e6" });
        }
    }
    if min_clearance.is_nan() {
        return Err(PlaceError::Option { what: "min_clearance", value: min_clearance, must: "a number" });
    }
    for k in 0..3 {
        let (min, max) = (region.min[k], region.max[k]);
        if !(min.abs() <= MAX_COORDINATE && max.abs() <= MAX_COORDINATE && min <= max) {
            let value = if max.abs() <= MAX_COORDINATE { min } else { max };
            return Err(PlaceError::Option {
                what: "region",
                value,
                must: "from -1e6 to 1e6, and `min` at most `max`",
            });
        }
    }
    if let Some(index) = waypoints.iter().position(|waypoint| !is_place(waypoint)) {
        return Err(PlaceError::Waypoint { index });
    }
    let parts = parts(region);
    let count: f64 = parts.iter().map(|parts| parts + 1.0).product();
    if count > MAX_PLACES {
        return Err(PlaceError::Option {
            what: "coarse_mm",
            value: region.coarse_mm,
            must: "large enough for 100,000 places",
        });
    }
    let step = spacing(region);
    let [nx, ny, nz] = parts.map(|parts| parts as usize);
    let mut places = Vec::with_capacity(count as usize);
    for (z, y, x) in (0..=nz).flat_map(|z| (0..=ny).flat_map(move |y| (0..=nx).map(move |x| (z, y, x)))) {
        let place = region.min + step.component_mul(&Vector3::new(x as f64, y as f64, z as f64));
        // Rounding may put the last one beyond the end.
        places.push(place.inf(&region.max));
    }
    let middle = nalgebra::center(&region.min, &region.max);
    places.sort_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()));
    Ok(places)
}

struct Search<'a, F> {
    waypoints: &'a [Waypoint],
    min_clearance: f64,
    at: F,
    best: Option<(Score, Point3<f64>)>,
    places: usize,
    assessments: u64,
    /// Waypoints, those first that were bad most recently.
    turns: Vec<usize>,
}

impl<A: FnMut(usize, &Waypoint) -> Option<Assessment>, F: FnMut(&Point3<f64>) -> Option<A>> Search<'_, F> {
    /// Looks at a place, and keeps it if it is better than the best.
    fn step(&mut self, place: &Point3<f64>, total: u64, progress: ProgressFn<'_>) -> Result<(), PlaceError> {
        let done = self.places as u64;
        if progress(Progress { stage: "stand", done, total: total.max(done) }).is_break() {
            return Err(PlaceError::Cancelled);
        }
        self.places += 1;
        let Some(mut assess) = (self.at)(place) else { return Ok(()) };
        let mut score = Score::default();
        for turn in 0..self.turns.len() {
            let waypoint = self.turns[turn];
            let found = assess(waypoint, &self.waypoints[waypoint]);
            self.assessments += 1;
            if found.is_some_and(|found| found.clearance.is_nan() || found.quality.is_nan()) {
                return Err(PlaceError::Assessment { place: self.places - 1, waypoint });
            }
            score.add(waypoint, found, self.min_clearance);
            if found.is_none_or(|found| found.clearance < self.min_clearance) {
                self.turns[..=turn].rotate_right(1);
            }
            if self.best.as_ref().is_some_and(|(best, _)| score.compare(best).is_ge()) {
                return Ok(());
            }
        }
        // Without waypoints, all places are alike.
        if self.best.is_none() || !self.waypoints.is_empty() {
            self.best = Some((score, *place));
        }
        Ok(())
    }
}
