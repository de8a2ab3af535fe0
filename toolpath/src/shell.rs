//! How near the beads of a part are to its shell: the staircase.
//!
//! Takes the mesh of the part and tool paths; gives a [`ShellGap`] ([`shell_gap`]).
//!
//! The shell of a part is its mesh; what is printed are beads, bodies with round rims. Points of the mesh are looked at, spread evenly over its area. Of one that
//! no bead reaches the distance to the nearest is taken; of one inside a bead, how far the beads go on from there along the normal of the
//! mesh, out of the part. It is a check of what is laid, and knows neither surfaces of layers nor fields.
//!
//! On an upright wall of beads of the height `h` whose rims touch the shell, points between two beads are `(sqrt(2) - 1) h / 2` away, a fifth of a
//! layer, and half of all points less than a twentieth. What leans has steps.

use crate::ProgressFn;
use crate::beads::{BeadGrid, Section, middles, nearest_share};
use crate::orientation::{ToolPath, Waypoint};
use crate::parallel;
use nalgebra::{Point3, Vector3};

/// Coordinates and sizes beyond this, in millimetres, are refused.
const MAX_COORDINATE_MM: f64 = 1e7;

/// More points than this are refused.
const MAX_POINTS: usize = 100_000_000;

/// Beads are followed outward in steps of this share of the smallest rim, then to a hundredth of that.
const OUTWARD: f64 = 0.25;

/// So many steps at most, so that a bead of hardly any width does not take any number of them.
const MAX_STEPS: f64 = 1e4;

/// Triangles of a task for a thread.
const CHUNK: usize = 512;

/// How the shell is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct ShellOptions {
    /// Points of the shell, about: 200,000. Each triangle has one at least.
    pub points: usize,
    /// A point farther than this from all beads, in millimetres, is bare: 1.
    pub bare_mm: f64,
}

impl Default for ShellOptions {
    fn default() -> Self {
        ShellOptions { points: 200_000, bare_mm: 1.0 }
    }
}

/// How far the shell is from the beads. Shares are of its area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShellGap {
    /// Points that were looked at.
    pub points: usize,
    /// Mean of the distance, in or out, in millimetres, at most the limit.
    pub mean_mm: f64,
    /// Half of the shell is nearer than this.
    pub p50_mm: f64,
    /// 95 % of the shell are nearer than this.
    pub p95_mm: f64,
    /// Share of the shell that is bare, or where beads go on outside of the part by as much.
    pub bare_share: f64,
}

/// Why the shell cannot be looked at.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShellError {
    /// An option is out of its range.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// A triangle without a vertex, or with one that is not finite or beyond 1e7 mm.
    #[error("triangle {triangle} has a vertex that is not there, not finite or beyond 1e7 mm")]
    BadTriangle {
        /// The triangle, from 0.
        triangle: usize,
    },
    /// A waypoint that is not finite, beyond 1e7 mm, or has no bead.
    #[error("waypoint {waypoint} of path {path} is not finite, beyond 1e7 mm, or has no bead")]
    BadWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Measures how far the shell of a part is from its beads; those of support do not count.
///
/// # Arguments
/// * `vertices`, `triangles`: the mesh of the part, where it is printed; counter-clockwise from outside.
/// * `progress`: called with the stage `shell`; may cancel.
///
/// # Returns
/// All 0 for a mesh without area.
///
/// # Errors
/// [`ShellError`].
///
/// # Cost
/// Some microseconds for each point. The result does not depend on the number of threads.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// use curvlay_toolpath::shell::{ShellOptions, shell_gap};
/// use std::ops::ControlFlow::Continue;
/// // A wall of 40 beads on each other, 20 mm long and 0.4 mm wide; its side is 0.2 mm beside their middles.
/// let at = |x, z| Waypoint {
///     position: Point3::new(x, 0.0, z), axis: Vector3::z_axis(), width: 0.4, height: 0.2, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall,
/// };
/// let path = |k: u32| {
///     let z = 0.2 * f64::from(k + 1);
///     ToolPath { layer: k, curve: 0, closed: false, waypoints: vec![at(0.0, z), at(20.0, z)] }
/// };
/// let paths: Vec<ToolPath> = (0..40).map(path).collect();
/// let side = [[20.0, 0.2, 0.0], [0.0, 0.2, 0.0], [0.0, 0.2, 8.0], [20.0, 0.2, 8.0]].map(Point3::from);
/// let gap = shell_gap(&paths, &side, &[[0, 1, 2], [0, 2, 3]], &ShellOptions::default(), &|_| Continue(()))?;
/// // Between two beads 0.041 mm.
/// assert!(gap.p95_mm > 0.033 && gap.p95_mm < 0.042 && gap.bare_share == 0.0);
/// # Ok::<(), curvlay_toolpath::shell::ShellError>(())
/// ```
pub fn shell_gap(
    paths: &[ToolPath],
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    options: &ShellOptions,
    progress: ProgressFn,
) -> Result<ShellGap, ShellError> {
    options.check()?;
    let triangles = corners(vertices, triangles)?;
    let pieces = pieces(paths)?;
    let area: f64 = triangles.iter().map(area).sum();
    if area <= 0.0 {
        return Ok(ShellGap::default());
    }
    let size = pieces.iter().flatten().map(|section| section.core + section.rim).fold(0.0, f64::max);
    let min_rim = pieces.iter().flatten().map(|section| section.rim).fold(f64::INFINITY, f64::min);
    let grid = BeadGrid::new(pieces.iter().map(middles), options.bare_mm + size);
    let beads = Beads { grid, pieces: &pieces, bare_mm: options.bare_mm, min_rim };
    let step = (2.0 * area / options.points as f64).sqrt();
    let chunks: Vec<&[[Point3<f64>; 3]]> = triangles.chunks(CHUNK).collect();
    let of_chunk = |_: usize, chunk: &&[[Point3<f64>; 3]]| {
        let mut found: Vec<(f64, f64)> = Vec::new();
        for triangle in *chunk {
            let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])).normalize();
            each_point(triangle, step, |point, area| found.push((beads.off(point, normal), area)));
        }
        found
    };
    let found = parallel::map(&chunks, "shell", progress, of_chunk).ok_or(ShellError::Cancelled)?;
    Ok(ShellGap::of(found.into_iter().flatten().collect(), options.bare_mm))
}

impl ShellOptions {
    fn check(&self) -> Result<(), ShellError> {
        if !(1..=MAX_POINTS).contains(&self.points) {
            let value = self.points as f64;
            return Err(ShellError::Option { option: "points", value, wanted: "1 to 100 million" });
        }
        let value = self.bare_mm;
        let is_length = value > 0.0 && value <= MAX_COORDINATE_MM;
        if is_length {
            Ok(())
        } else {
            Err(ShellError::Option { option: "bare_mm", value, wanted: "above 0 and at most 1e7" })
        }
    }
}

impl ShellGap {
    /// Of distances, each with the area that it stands for.
    fn of(mut found: Vec<(f64, f64)>, bare_mm: f64) -> ShellGap {
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let area: f64 = found.iter().map(|(_, area)| area).sum();
        let share_below = |share: f64| {
            let mut sum = 0.0;
            let reached = found.iter().find(|(_, area_of)| {
                sum += area_of;
                sum >= share * area
            });
            reached.or(found.last()).map_or(0.0, |(distance, _)| *distance)
        };
        let bare = found.iter().filter(|(distance, _)| *distance >= bare_mm).map(|(_, area)| area);
        let bare = bare.fold(0.0, |sum, area| sum + area); // a sum of nothing is -0.0
        ShellGap {
            points: found.len(),
            mean_mm: found.iter().map(|(distance, area)| distance * area).sum::<f64>() / area,
            p50_mm: share_below(0.5),
            p95_mm: share_below(0.95),
            bare_share: bare / area,
        }
    }
}

fn corners(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<[Point3<f64>; 3]>, ShellError> {
    let is_sound = |corner: &Point3<f64>| corner.iter().all(|x| x.abs() <= MAX_COORDINATE_MM);
    let of = |(triangle, corners): (usize, &[u32; 3])| {
        let corner = |k: usize| vertices.get(corners[k] as usize).copied().filter(is_sound);
        match (corner(0), corner(1), corner(2)) {
            (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
            _ => Err(ShellError::BadTriangle { triangle }),
        }
    };
    triangles.iter().enumerate().map(of).collect()
}

/// The pieces of beads between two waypoints, without those of support.
fn pieces(paths: &[ToolPath]) -> Result<Vec<[Section; 2]>, ShellError> {
    let is_sound = |at: &Waypoint| {
        let is_length = |value: f64| value > 0.0 && value <= MAX_COORDINATE_MM;
        let places = at.position.iter().chain(at.axis.iter()).chain(at.lift.iter());
        places.copied().all(|x| x.abs() <= MAX_COORDINATE_MM) && is_length(at.width) && is_length(at.height)
    };
    for (path, of_path) in paths.iter().enumerate() {
        if let Some(waypoint) = of_path.waypoints.iter().position(|at| !is_sound(at)) {
            return Err(ShellError::BadWaypoint { path, waypoint });
        }
    }
    let pairs = paths.iter().flat_map(|path| path.waypoints.windows(2)).filter(|pair| !pair[1].kind.is_support());
    Ok(pairs.map(|pair| [Section::of(&pair[0]), Section::of(&pair[1])]).collect())
}

fn area([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// Hands over points of a triangle, spread evenly about `step` apart, each with the area that it stands for: the middles of the triangles that lines parallel to its
/// sides cut it into.
fn each_point(triangle: &[Point3<f64>; 3], step: f64, mut hand: impl FnMut(Point3<f64>, f64)) {
    let [a, b, c] = triangle;
    let parts = (area(triangle).sqrt() / (step * std::f64::consts::FRAC_1_SQRT_2)).ceil().max(1.0);
    let each = area(triangle) / (parts * parts);
    if each <= 0.0 {
        return;
    }
    let [u, v]: [Vector3<f64>; 2] = [(b - a) / parts, (c - a) / parts];
    let count = parts as u32;
    for i in 0..count {
        for j in 0..count - i {
            let corner = a + u * f64::from(i) + v * f64::from(j);
            hand(corner + (u + v) / 3.0, each);
            if i + j + 1 < count {
                hand(corner + (u + v) * (2.0 / 3.0), each);
            }
        }
    }
}

struct Beads<'a> {
    grid: BeadGrid,
    pieces: &'a [[Section; 2]],
    bare_mm: f64,
    min_rim: f64,
}

impl Beads<'_> {
    /// How far a point of the shell is from the beads, or how far these go on outside of it; at most the limit.
    fn off(&self, at: Point3<f64>, normal: Vector3<f64>) -> f64 {
        let gap = self.gap(at);
        if gap >= 0.0 {
            return gap;
        }
        let step = (OUTWARD * self.min_rim).max(self.bare_mm / MAX_STEPS);
        let (mut inside, mut outside) = (0.0, step);
        while self.gap(at + normal * outside) < 0.0 {
            if outside >= self.bare_mm {
                return self.bare_mm;
            }
            (inside, outside) = (outside, outside + step);
        }
        while outside - inside > 0.01 * step {
            let middle = 0.5 * (inside + outside);
            *(if self.gap(at + normal * middle) < 0.0 { &mut inside } else { &mut outside }) = middle;
        }
        outside
    }

    /// How far a point is from the nearest bead, at most the limit; below 0 inside of one.
    fn gap(&self, at: Point3<f64>) -> f64 {
        let mut nearest = self.bare_mm;
        for number in self.grid.around(at) {
            let piece = &self.pieces[number as usize];
            let section = piece[0].toward(&piece[1], nearest_share(piece, at).clamp(0.0, 1.0));
            let [up, aside] = section.off(at);
            nearest = nearest.min(up.hypot(aside) - section.rim);
        }
        nearest
    }
}
