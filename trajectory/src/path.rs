//! From waypoints as they come to pieces that can be travelled: time stamps, and the defects found on the way.
//!
//! Times come from arc length and feed (C. Dai, *Material Deposition in 3D Space*, TU Delft 2020, section 3.5.3), or
//! are given. Nothing here slows the feed down or moves a waypoint. Published tool paths have repeated points, jumps
//! between islands and normals that turn over; each is named, and the path is split where a motion at the feed cannot
//! pass.

use nalgebra::{Point3, UnitVector3, Vector3};
use std::fmt;

/// The fewest waypoints of a piece: one stencil of five for the derivatives (section 4.3.2).
pub const MIN_WAYPOINTS: usize = 5;

/// Where time stamps come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing<'a> {
    /// A feed in mm/s: each piece begins at time 0 and follows its arc length.
    Feed(f64),
    /// One time a waypoint, in seconds.
    Given(&'a [f64]),
}

/// What counts as a defect.
#[derive(Clone, Copy, Debug, PartialEq)]
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
                write!(out, "a piece of {count} waypoints, at least {MIN_WAYPOINTS} are needed; left out")
            }
        }
    }
}

/// Waypoints that one motion can follow.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPiece {
    /// Which of the given waypoints they are, rising.
    pub waypoints: Vec<usize>,
    /// Places, in millimetres.
    pub positions: Vec<Point3<f64>>,
    /// Directions in which material grows.
    pub normals: Vec<UnitVector3<f64>>,
    /// Times, rising, in seconds.
    pub times: Vec<f64>,
}

/// A path in pieces, and what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    /// The pieces, in order, each of at least [`MIN_WAYPOINTS`].
    pub pieces: Vec<PathPiece>,
    /// The defects, in the order of the waypoints.
    pub defects: Vec<Defect>,
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// Places, normals and times are not of one number.
    #[error("{positions} positions, {normals} normals and {times} times: there must be one of each a waypoint")]
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
/// # Errors
/// [`PathError`] for lists that do not fit and options that cannot be. What is wrong with a waypoint is a [`Defect`].
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
/// assert_eq!(path.pieces.len(), 2);
/// assert!((path.pieces[1].times[5] - 1.0).abs() < 1e-12);
/// assert!(matches!(path.defects[..], [Defect::Jump { waypoint: 6, .. }]));
/// # Ok::<(), curvlay_trajectory::PathError>(())
/// ```
pub fn timed_path(
    positions: &[Point3<f64>],
    normals: &[Vector3<f64>],
    timing: Timing<'_>,
    options: &PathOptions,
) -> Result<TimedPath, PathError> {
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
    let mut sorter = Sorter { path: TimedPath { pieces: Vec::new(), defects: Vec::new() }, open: PathPiece::NONE };
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
        let mut stamp = if let Timing::Given(_) = timing { time } else { 0.0 };
        if let (Some(before), Some(normal_before), Some(&time_before)) =
            (sorter.open.positions.last(), sorter.open.normals.last(), sorter.open.times.last())
        {
            let distance = (position - before).norm();
            let angle = normal_before.angle(&normal);
            if let Timing::Feed(feed) = timing {
                stamp = time_before + distance / feed;
            }
            if angle > options.flip {
                sorter.split(Defect::Flip { waypoint, angle });
            } else if distance < options.repeat {
                sorter.path.defects.push(Defect::Repeated { waypoint, distance });
                continue;
            } else if distance > options.jump {
                sorter.split(Defect::Jump { waypoint, distance });
            } else if stamp <= time_before {
                sorter.split(Defect::Time { waypoint, time: stamp, before: time_before });
            }
            if let (Timing::Feed(_), true) = (timing, sorter.open.times.is_empty()) {
                stamp = 0.0;
            }
        }
        sorter.open.waypoints.push(waypoint);
        sorter.open.positions.push(position);
        sorter.open.normals.push(normal);
        sorter.open.times.push(stamp);
    }
    sorter.close();
    Ok(sorter.path)
}

impl PathPiece {
    const NONE: PathPiece =
        PathPiece { waypoints: Vec::new(), positions: Vec::new(), normals: Vec::new(), times: Vec::new() };
}

struct Sorter {
    path: TimedPath,
    /// The piece that is being filled.
    open: PathPiece,
}

impl Sorter {
    fn split(&mut self, defect: Defect) {
        self.close();
        self.path.defects.push(defect);
    }

    fn close(&mut self) {
        let piece = std::mem::replace(&mut self.open, PathPiece::NONE);
        match piece.waypoints.first() {
            Some(_) if piece.waypoints.len() >= MIN_WAYPOINTS => self.path.pieces.push(piece),
            Some(&waypoint) => {
                self.path.defects.push(Defect::Short { waypoint, count: piece.waypoints.len() });
            }
            None => {}
        }
    }
}
