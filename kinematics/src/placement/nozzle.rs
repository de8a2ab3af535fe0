//! Where a fixed nozzle should stand, by what the arm reaches.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1: sample the joints, drop the
//! frames that face down, and put the nozzle at the middle of the box with the most frames. Symbols: the
//! box `B` is `envelope` here.
//!
//! Departs from the dissertation: the samples are the points of a Halton sequence (J. H. Halton, "On the efficiency
//! of certain quasi-random sequences of points", Numerische Mathematik 2, 1960) instead of random ones, so they are
//! even and always the same. And the search is exact: over all boxes of this size, wherever they are, none contains
//! more frames.
//!
//! A best box can be moved until its lower faces touch points. So its corner is one of `n^3`, an index along each
//! axis. For a range of indices along x, the points between the range's first and last box make a problem in the
//! plane with at least as many points, which a sweep along y over a segment tree along z solves. Best first: ranges
//! are halved in the order of these bounds, and the first range of one index that comes up is the optimum.

use crate::arm::Arm;
use crate::pose::{MAX_COORDINATE, is_frame};
use crate::progress::{Progress, ProgressFn};
use nalgebra::{Isometry3, Point3, Vector3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Which frames count as reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachOptions {
    /// How many postures are sampled, at most ten million. 20,000 place the box to a few millimetres on arms of half a metre.
    pub samples: usize,
    /// A frame counts if its z axis rises at least this steeply: the sine of its angle over the horizon. 0 drops those
    /// that face down; -1 keeps all.
    pub min_rise: f64,
}

impl Default for ReachOptions {
    /// 20,000 samples, frames that do not face down.
    fn default() -> Self {
        ReachOptions { samples: 20_000, min_rise: 0.0 }
    }
}

/// Why a nozzle cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementError {
    /// The frame on the flange is not finite, farther out than 1e6 mm, or its quaternion has another length than 1.
    #[error(
        "the frame on the flange is invalid: its entries must be finite and within 1e6 mm, its quaternion of length 1"
    )]
    Frame,
    /// The smallest rise is not a number.
    #[error("`min_rise` is not a number")]
    MinRise,
    /// More samples than fit in memory.
    #[error("`samples` is {samples}: at most {max} are allowed")]
    Samples {
        /// How many were asked for.
        samples: usize,
        /// How many may be.
        max: usize,
    },
    /// A point is not finite, or farther out than 1e6 mm.
    #[error("point {index} is invalid: its coordinates must be finite and within 1e6 mm")]
    Point {
        /// Its place in the input.
        index: usize,
    },
    /// There are no points, so no box is better than another.
    #[error("there are no frames: none of the samples meets the options")]
    NoPoints,
    /// More points than can be numbered.
    #[error("{count} points are more than 2^31")]
    TooMany {
        /// How many.
        count: usize,
    },
    /// An edge of the box is negative, not finite or longer than 1e6 mm.
    #[error("edge {axis} of the box is {length} mm: it must be from 0 to 1e6")]
    Envelope {
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
        /// The edge.
        length: f64,
    },
    /// The progress callback cancelled the search.
    #[error("cancelled")]
    Cancelled,
}

/// The box with the most frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Its middle: where the tip of the nozzle should be, in the base.
    pub centre: Point3<f64>,
    /// How many frames are in it.
    pub frames: usize,
}

/// Where the arm brings the frame `flange_frame` (the part on the flange, or the nozzle): its origins in the base.
///
/// The postures are the first points of a Halton sequence over the limits; of a joint that turns farther than once,
/// over one turn. `keep` sees the joints and the frame in the base and says whether the frame counts: what lies below
/// the floor, behind a wall or within the arm itself is for it to drop. (Evenly spread joints crowd about axis 1, so
/// without such a rule the nozzle ends up there.)
///
/// # Errors
/// [`PlacementError::Frame`], [`PlacementError::MinRise`] and [`PlacementError::Samples`].
///
/// # Cost
/// A fifth of a microsecond a sample, and the points.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::{Arm, ReachOptions, reachable_points, robots};
/// let options = ReachOptions { samples: 1000, ..ReachOptions::default() };
/// let points = reachable_points(&Arm::new(&robots::UR3)?, &Isometry3::identity(), &options, |_, _| true)?;
/// assert!((400..600).contains(&points.len())); // half of them face down
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn reachable_points(
    arm: &Arm,
    flange_frame: &Isometry3<f64>,
    options: &ReachOptions,
    keep: impl Fn(&[f64; 6], &Isometry3<f64>) -> bool,
) -> Result<Vec<Point3<f64>>, PlacementError> {
    if !is_frame(flange_frame) {
        return Err(PlacementError::Frame);
    }
    if options.min_rise.is_nan() {
        return Err(PlacementError::MinRise);
    }
    if options.samples > MAX_SAMPLES {
        return Err(PlacementError::Samples { samples: options.samples, max: MAX_SAMPLES });
    }
    let limits = arm.limits();
    let ranges: [(f64, f64); 6] = std::array::from_fn(|k| {
        let (lower, upper) = (limits.lower[k], limits.upper[k]);
        if upper - lower <= 2.0 * PI { (lower, upper) } else { (-PI, PI) }
    });
    let mut points = Vec::new();
    for sample in 1..=options.samples {
        let joints = std::array::from_fn(|k| {
            let (lower, upper) = ranges[k];
            lower + (upper - lower) * halton(sample, BASES[k])
        });
        let frame = arm.forward(&joints) * flange_frame;
        if (frame.rotation * Vector3::z()).z >= options.min_rise && keep(&joints, &frame) {
            points.push(Point3::from(frame.translation.vector));
        }
    }
    Ok(points)
}

/// Two seconds, and a quarter of a gigabyte of points.
const MAX_SAMPLES: usize = 10_000_000;

/// The first primes, one a joint.
const BASES: [usize; 6] = [2, 3, 5, 7, 11, 13];

/// The digits of `index` in a base, mirrored behind the point.
fn halton(mut index: usize, base: usize) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f64;
        value += weight * (index % base) as f64;
        index /= base;
    }
    value
}

/// The box with these edges, parallel to the axes, that contains the most points, faces included.
///
/// No box anywhere contains more. Of boxes with as many, that whose lower corner comes first in x is taken; it is
/// moved so that its points lie in its middle.
///
/// # Errors
/// [`PlacementError`]; [`PlacementError::Cancelled`] when `progress` returns `Break`.
///
/// # Cost
/// Half a second for 10,000 points of an arm and a box of a third of its reach; memory `O(n)`.
///
/// # Example
/// ```
/// use curvlay_kinematics::{fullest_box, nalgebra::Point3};
/// use std::ops::ControlFlow::Continue;
/// let points = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [10.0, 1.0, 2.0], [11.0, 0.0, 1.0]].map(Point3::from);
/// let best = fullest_box(&points, [2.0; 3], &|_| Continue(()))?;
/// assert_eq!((best.frames, best.centre), (3, Point3::new(10.0, 0.5, 1.0)));
/// # Ok::<(), curvlay_kinematics::PlacementError>(())
/// ```
pub fn fullest_box(
    points: &[Point3<f64>],
    envelope: [f64; 3],
    progress: ProgressFn<'_>,
) -> Result<Placement, PlacementError> {
    if let Some(index) = points.iter().position(|point| !point.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
        return Err(PlacementError::Point { index });
    }
    if let Some(axis) = envelope.iter().position(|edge| !(0.0..=MAX_COORDINATE).contains(edge)) {
        return Err(PlacementError::Envelope { axis, length: envelope[axis] });
    }
    if points.is_empty() {
        return Err(PlacementError::NoPoints);
    }
    if points.len() > 1 << 31 {
        return Err(PlacementError::TooMany { count: points.len() });
    }
    let mut search = Search::new(points, envelope);
    let corner = search.best_corner(progress)?;
    let inside = points
        .iter()
        .filter(|point| (0..3).all(|axis| corner[axis] <= point[axis] && point[axis] <= corner[axis] + envelope[axis]));
    let (mut low, mut high, mut frames) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0);
    for point in inside {
        frames += 1;
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    Ok(Placement { centre: Point3::from([0, 1, 2].map(|axis| low[axis] + 0.5 * (high[axis] - low[axis]))), frames })
}

/// A point by its ranks: points are numbered by rising x.
struct Ranked {
    x: f64,
    y: f64,
    z: f64,
    /// Boxes with their bottom at these ranks of z contain it.
    bottoms: [u32; 2],
}

struct Search {
    envelope: [f64; 3],
    /// By rising x.
    points: Vec<Ranked>,
    /// Numbers of points by rising y.
    by_y: Vec<u32>,
    /// Coordinates by rising z.
    heights: Vec<f64>,
    tree: Tree,
    /// Those of a range by rising y.
    window: Vec<u32>,
}

impl Search {
    fn new(points: &[Point3<f64>], envelope: [f64; 3]) -> Self {
        let mut heights: Vec<f64> = points.iter().map(|point| point.z).collect();
        heights.sort_unstable_by(f64::total_cmp);
        let mut sorted: Vec<&Point3<f64>> = points.iter().collect();
        sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        let ranked = |point: &&Point3<f64>| {
            let first = heights.partition_point(|&bottom| bottom + envelope[2] < point.z);
            let end = heights.partition_point(|&bottom| bottom <= point.z);
            Ranked { x: point.x, y: point.y, z: point.z, bottoms: [first as u32, end as u32] }
        };
        let points: Vec<Ranked> = sorted.iter().map(ranked).collect();
        let mut by_y: Vec<u32> = (0..points.len() as u32).collect();
        by_y.sort_by(|&a, &b| points[a as usize].y.total_cmp(&points[b as usize].y));
        let tree = Tree::new(heights.len());
        Search { envelope, points, by_y, heights, tree, window: Vec::new() }
    }

    /// The lower corner of the best box.
    fn best_corner(&mut self, progress: ProgressFn<'_>) -> Result<[f64; 3], PlacementError> {
        // Most points first, then the range that begins first.
        let mut open = BinaryHeap::new();
        let whole = (0, self.points.len());
        open.push((self.sweep(whole).0, Reverse(whole)));
        let mut done = 0;
        while let Some((_, Reverse((begin, end)))) = open.pop() {
            if progress(Progress { stage: "place", done, total: 0 }).is_break() {
                return Err(PlacementError::Cancelled);
            }
            done += 1;
            if end - begin == 1 {
                let (_, [y, z]) = self.sweep((begin, end));
                return Ok([self.points[begin].x, y, z]);
            }
            let middle = begin + (end - begin) / 2;
            for half in [(begin, middle), (middle, end)] {
                open.push((self.sweep(half).0, Reverse(half)));
            }
        }
        Err(PlacementError::NoPoints)
    }

    /// The most points in a box whose x begins at one of these points and goes on to the end of the last one's box,
    /// and where its y and z begin. Exact for a single index, a bound for more.
    fn sweep(&mut self, (begin, end): (usize, usize)) -> (u32, [f64; 2]) {
        let last = self.points[end - 1].x + self.envelope[0];
        let after = begin + self.points[begin..].partition_point(|point| point.x <= last);
        self.window.clear();
        let within = (begin as u32)..(after as u32);
        self.window.extend(self.by_y.iter().filter(|number| within.contains(number)));
        let (mut most, mut at) = (0, [self.points[begin].y, self.points[begin].z]);
        let mut added = 0;
        for &first in &self.window {
            let y = self.points[first as usize].y;
            while let Some(&next) = self.window.get(added) {
                let point = &self.points[next as usize];
                if point.y > y + self.envelope[1] {
                    break;
                }
                self.tree.add(point.bottoms, 1);
                added += 1;
            }
            if self.tree.most() > most {
                (most, at) = (self.tree.most(), [y, self.heights[self.tree.place()]]);
            }
            self.tree.add(self.points[first as usize].bottoms, -1);
        }
        (most, at)
    }
}

/// A segment tree: adds to ranges, gives the maximum and its first place.
struct Tree {
    leaves: usize,
    /// Of each node what was added to all of it, and the maximum in it with that.
    nodes: Vec<(i32, i32)>,
}

impl Tree {
    fn new(length: usize) -> Self {
        let leaves = length.next_power_of_two();
        Tree { leaves, nodes: vec![(0, 0); 2 * leaves] }
    }

    fn add(&mut self, [begin, end]: [u32; 2], value: i32) {
        let (mut left, mut right) = (begin as usize + self.leaves, end as usize + self.leaves);
        let (first, last) = (left, right - 1);
        while left < right {
            if left & 1 == 1 {
                self.raise(left, value);
                left += 1;
            }
            if right & 1 == 1 {
                right -= 1;
                self.raise(right, value);
            }
            (left, right) = (left / 2, right / 2);
        }
        for mut node in [first, last] {
            while node > 1 {
                node /= 2;
                let below = self.nodes[2 * node].1.max(self.nodes[2 * node + 1].1);
                self.nodes[node].1 = self.nodes[node].0 + below;
            }
        }
    }

    fn raise(&mut self, node: usize, value: i32) {
        self.nodes[node].0 += value;
        self.nodes[node].1 += value;
    }

    fn most(&self) -> u32 {
        self.nodes[1].1.unsigned_abs()
    }

    fn place(&self) -> usize {
        let mut node = 1;
        while node < self.leaves {
            node = 2 * node + usize::from(self.nodes[2 * node].1 < self.nodes[2 * node + 1].1);
        }
        node - self.leaves
    }
}
