//! From waypoints as they come to segments that can be travelled: time stamps, and the defects found on the way.
//!
//! Times come from arc length and feed (C. Dai, *Material Deposition in 3D Space*, TU Delft 2020, section 3.5.3), or
//! are given. Nothing here slows the feed down or moves a waypoint. Published tool paths have repeated points, jumps
//! between islands and normals that turn over; each is named, and the path is split where a motion at the feed cannot
//! pass.

use nalgebra::{Point3, UnitVector3, Vector3};
use std::fmt;

/// The fewest waypoints of a segment: one stencil of five for the derivatives (section 4.3.2).
pub const MIN_WAYPOINTS: usize = 5;

/// Where time stamps come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing<'a> {
    /// A feed in mm/s: each segment begins at time 0 and follows its arc length.
    Feed(f64),
    /// One time a waypoint, in seconds.
    Given(&'a [f64]),
}

/// What counts as a defect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PathOptions {
    /// Waypoints nearer than this to the one before are repeated, in millimetres. Default 0.01: at 5 mm/s two
    /// milliseconds, less than a robot controller's cycle.
    pub repeat: f64,
    /// Steps longer than this are jumps, in millimetres. Default 10.
    pub jump: f64,
    /// Normals that turn by more than this in a step are flipped, in radians. Default an eighth of a turn: the
    /// sharpest crests of sound paths turn by half of it.
    pub flip: f64,
}

impl Default for PathOptions {
    fn default() -> Self {
        PathOptions { repeat: 0.01, jump: 10.0, flip: std::f64::consts::FRAC_PI_4 }
    }
}

/// What is wrong with a path, and where. Waypoints are counted from 0 as they were given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Defect {
    /// A coordinate or the time is not finite: the waypoint is left out, and the path is split.
    NotFinite {
        /// The waypoint.
        waypoint: usize,
    },
    /// The normal has no direction: the waypoint is left out, and the path is split.
    NoNormal {
        /// The waypoint.
        waypoint: usize,
    },
    /// The same place as the waypoint before, with a normal that is not flipped: left out.
    Repeated {
        /// The waypoint.
        waypoint: usize,
        /// Its distance from the one before, in millimetres.
        distance: f64,
    },
    /// A long step: the path is split before the waypoint.
    Jump {
        /// The waypoint.
        waypoint: usize,
        /// Its distance from the one before, in millimetres.
        distance: f64,
    },
    /// The normal turns over: the path is split before the waypoint.
    Flip {
        /// The waypoint.
        waypoint: usize,
        /// The angle from the normal before, in radians.
        angle: f64,
    },
    /// A given time is not after the one before: the path is split before the waypoint.
    Time {
        /// The waypoint.
        waypoint: usize,
        /// Its time, in seconds.
        time: f64,
        /// The time before.
        before: f64,
    },
    /// Fewer waypoints than [`MIN_WAYPOINTS`] are left between two splits: they are left out.
    Short {
        /// The first of them.
        waypoint: usize,
        /// How many there are.
        count: usize,
    },
}

impl Defect {
    /// The waypoint at which it was found.
    pub fn waypoint(&self) -> usize {
        match *self {
            Defect::NotFinite { waypoint }
            | Defect::NoNormal { waypoint }
            | Defect::Repeated { waypoint, .. }
            | Defect::Jump { waypoint, .. }
            | Defect::Flip { waypoint, .. }
            | Defect::Time { waypoint, .. }
            | Defect::Short { waypoint, .. } => waypoint,
        }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "waypoint {}: ", self.waypoint())?;
        match *self {
            Defect::NotFinite { .. } => write!(out, "a number that is not finite; left out, path split"),
            Defect::NoNormal { .. } => write!(out, "a normal without direction; left out, path split"),
            Defect::Repeated { distance, .. } => write!(out, "{distance:.4} mm from the one before; left out"),
            Defect::Jump { distance, .. } => write!(out, "a jump of {distance:.2} mm; path split"),
            Defect::Flip { angle, .. } => {
                write!(out, "the normal turns by {:.1} degrees; path split", angle.to_degrees())
            }
            Defect::Time { time, before, .. } => write!(out, "time {time} s is not after {before} s; path split"),
            Defect::Short { count, .. } => {
                write!(out, "a segment of {count} waypoints, at least {MIN_WAYPOINTS} are needed; left out")
            }
        }
    }
}

/// Waypoints that one motion can follow.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSegment {
    /// Which of the given waypoints they are, rising.
    pub waypoints: Vec<usize>,
    /// Places, in millimetres.
    pub positions: Vec<Point3<f64>>,
    /// Directions in which material grows.
    pub normals: Vec<UnitVector3<f64>>,
    /// Times, rising, in seconds.
    pub times: Vec<f64>,
}

/// A path in segments, and what was found. Waypoints with a defect, and segments of fewer than [`MIN_WAYPOINTS`], are in
/// no segment: check [`TimedPath::left_out`], or take the segments by [`TimedPath::require_complete`].
#[derive(Clone, Debug, PartialEq)]
#[must_use = "waypoints may be left out: see `left_out` and `require_complete`"]
pub struct TimedPath {
    /// The segments, in order, each of at least [`MIN_WAYPOINTS`].
    pub segments: Vec<PathSegment>,
    /// The defects, in the order of the waypoints.
    pub defects: Vec<Defect>,
}

/// Waypoints of a path are in no segment although they are not repeated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{left_out} waypoints are in no segment, first {}; repair them, or print without them", defects[0])]
pub struct IncompletePath {
    /// How many they are.
    pub left_out: usize,
    /// The defects that left them out, in the order of the waypoints; at least one.
    pub defects: Vec<Defect>,
}

impl Defect {
    /// How many waypoints it leaves out.
    pub fn left_out(&self) -> usize {
        match *self {
            Defect::NotFinite { .. } | Defect::NoNormal { .. } | Defect::Repeated { .. } => 1,
            Defect::Short { count, .. } => count,
            Defect::Jump { .. } | Defect::Flip { .. } | Defect::Time { .. } => 0,
        }
    }
}

impl TimedPath {
    /// How many of the given waypoints are in no segment; repeated ones count.
    pub fn left_out(&self) -> usize {
        self.defects.iter().map(Defect::left_out).sum()
    }

    /// The segments, if they hold every waypoint that is not a repetition of the one before. Splits are allowed.
    ///
    /// # Errors
    /// [`IncompletePath`] for waypoints with invalid numbers and for segments of fewer than [`MIN_WAYPOINTS`].
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::nalgebra::{Point3, Vector3};
    /// use curvlay_trajectory::{PathOptions, Timing, timed_path};
    /// let mut positions: Vec<_> = (0..12).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
    /// positions[9..].iter_mut().for_each(|p| p.y += 40.0); // a jump: the last three are too few
    /// let path = timed_path(&positions, &[Vector3::z(); 12], Timing::Feed(5.0), &PathOptions::default())?;
    /// assert_eq!((path.segments.len(), path.left_out()), (1, 3));
    /// assert!(path.require_complete().is_err());
    /// # Ok::<(), curvlay_trajectory::PathError>(())
    /// ```
    pub fn require_complete(self) -> Result<Vec<PathSegment>, IncompletePath> {
        let leaves_out = |defect: &Defect| defect.left_out() > 0 && !matches!(defect, Defect::Repeated { .. });
        let defects: Vec<Defect> = self.defects.into_iter().filter(leaves_out).collect();
        if defects.is_empty() {
            return Ok(self.segments);
        }
        Err(IncompletePath { left_out: defects.iter().map(Defect::left_out).sum(), defects })
    }
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// Places, normals and times are not of one number.
    #[error("{positions} positions, {normals} normals and {times} times: pass one of each per waypoint")]
    Count {
        /// Number of places.
        positions: usize,
        /// Number of normals.
        normals: usize,
        /// Number of times.
        times: usize,
    },
    /// A feed or an option is not above zero.
    #[error("`{what}` is {value}: it must be above 0")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Stamps waypoints with times and splits the path where it must be.
///
/// # Arguments
/// * `positions`, `normals`: one of each a waypoint, in millimetres and of any length, in the order of travel.
///
/// # Returns
/// The segments and the defects. Waypoints that are in no segment are not an error: [`TimedPath::left_out`] counts them,
/// [`TimedPath::require_complete`] makes them one.
///
/// # Errors
/// [`PathError`] for lists that do not fit and invalid options. What is wrong with a waypoint is a [`Defect`].
///
/// # Cost
/// Linear time and memory.
///
/// # Example
/// ```
/// use curvlay_trajectory::nalgebra::{Point3, Vector3};
/// use curvlay_trajectory::{Defect, PathOptions, Timing, timed_path};
/// let mut positions: Vec<_> = (0..12).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
/// positions[6..].iter_mut().for_each(|p| p.y += 40.0);
/// let path = timed_path(&positions, &[Vector3::z(); 12], Timing::Feed(5.0), &PathOptions::default())?;
/// assert_eq!(path.segments.len(), 2);
/// assert!((path.segments[1].times[5] - 1.0).abs() < 1e-12);
/// assert!(matches!(path.defects[..], [Defect::Jump { waypoint: 6, .. }]));
/// # Ok::<(), curvlay_trajectory::PathError>(())
/// ```
pub fn timed_path(
    positions: &[Point3<f64>],
    normals: &[Vector3<f64>],
    timing: Timing<'_>,
    options: &PathOptions,
) -> Result<TimedPath, PathError> {
    check(positions, normals, timing, options)?;
    let mut sorter = Sorter { path: TimedPath { segments: Vec::new(), defects: Vec::new() }, open: PathSegment::NONE };
    for (waypoint, (&position, normal)) in positions.iter().zip(normals).enumerate() {
        let time = if let Timing::Given(times) = timing { times[waypoint] } else { 0.0 };
        if !(position.iter().chain(normal.iter()).all(|x| x.is_finite()) && time.is_finite()) {
            sorter.split(Defect::NotFinite { waypoint });
            continue;
        }
        // Scaled first, so that no square overflows.
        let direction = normal.unscale(normal.amax().max(f64::MIN_POSITIVE));
        let Some(normal) = UnitVector3::try_new(direction, f64::MIN_POSITIVE) else {
            sorter.split(Defect::NoNormal { waypoint });
            continue;
        };
        if let Some(stamp) = sorter.stamp(waypoint, &position, &normal, timing, options) {
            sorter.open.waypoints.push(waypoint);
            sorter.open.positions.push(position);
            sorter.open.normals.push(normal);
            sorter.open.times.push(stamp);
        }
    }
    sorter.close();
    Ok(sorter.path)
}

/// Whether the lists fit each other and the options are sound.
fn check(
    positions: &[Point3<f64>],
    normals: &[Vector3<f64>],
    timing: Timing<'_>,
    options: &PathOptions,
) -> Result<(), PathError> {
    let given = match timing {
        Timing::Given(times) => times.len(),
        Timing::Feed(_) => positions.len(),
    };
    if normals.len() != positions.len() || given != positions.len() {
        return Err(PathError::Count { positions: positions.len(), normals: normals.len(), times: given });
    }
    let feed = if let Timing::Feed(feed) = timing { feed } else { 1.0 };
    for (what, value) in [("feed", feed), ("repeat", options.repeat), ("jump", options.jump), ("flip", options.flip)] {
        if value.is_nan() || value <= 0.0 || (what == "feed" && value.is_infinite()) {
            return Err(PathError::Option { what, value });
        }
    }
    Ok(())
}

impl PathSegment {
    const NONE: PathSegment =
        PathSegment { waypoints: Vec::new(), positions: Vec::new(), normals: Vec::new(), times: Vec::new() };
}

struct Sorter {
    path: TimedPath,
    /// The segment that is being filled.
    open: PathSegment,
}

impl Sorter {
    /// The time of a waypoint, in a new segment if it does not go with the one before; `None` for one that is left out, since it is where
    /// that is.
    fn stamp(
        &mut self,
        waypoint: usize,
        position: &Point3<f64>,
        normal: &UnitVector3<f64>,
        timing: Timing<'_>,
        options: &PathOptions,
    ) -> Option<f64> {
        let mut stamp = if let Timing::Given(times) = timing { times[waypoint] } else { 0.0 };
        let open = &self.open;
        let (Some(before), Some(normal_before), Some(&time_before)) =
            (open.positions.last(), open.normals.last(), open.times.last())
        else {
            return Some(stamp);
        };
        let distance = (position - before).norm();
        let angle = normal_before.angle(normal);
        if let Timing::Feed(feed) = timing {
            stamp = time_before + distance / feed;
        }
        if angle > options.flip {
            self.split(Defect::Flip { waypoint, angle });
        } else if distance < options.repeat {
            self.path.defects.push(Defect::Repeated { waypoint, distance });
            return None;
        } else if distance > options.jump {
            self.split(Defect::Jump { waypoint, distance });
        } else if stamp <= time_before {
            self.split(Defect::Time { waypoint, time: stamp, before: time_before });
        }
        // A segment that begins here begins at zero, unless times are given.
        let begins = matches!(timing, Timing::Feed(_)) && self.open.times.is_empty();
        Some(if begins { 0.0 } else { stamp })
    }

    fn split(&mut self, defect: Defect) {
        self.close();
        self.path.defects.push(defect);
    }

    fn close(&mut self) {
        let segment = std::mem::replace(&mut self.open, PathSegment::NONE);
        match segment.waypoints.first() {
            Some(_) if segment.waypoints.len() >= MIN_WAYPOINTS => self.path.segments.push(segment),
            Some(&waypoint) => {
                self.path.defects.push(Defect::Short { waypoint, count: segment.waypoints.len() });
            }
            None => {}
        }
    }
}
