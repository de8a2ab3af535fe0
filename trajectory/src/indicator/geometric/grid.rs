//! A signed distance on a lattice: positive outside, negative inside, trilinear between.
//!
//! **From cells** (a bit-packed grid) the nodes are the corners of cells, and their distances are exact: from a corner to a
//! cube of the same lattice the nearest point is again a corner, so the distance to the union of cubes is the distance
//! to the nearest corner of one, a distance transform of integers (A. Meijster, J. Roerdink, W. Hesselink, *A general
//! algorithm for computing distance transforms in linear time*, ISMM 2000). **From triangles** see `surface`.
//!
//! **Error.** A distance changes by at most as much as its place. So at `x` between nodes `x_i` with weights `w_i` the
//! interpolated value is wrong by at most `sum w_i |x - x_i|`, whose square is at most `sum_d h^2 t_d (1 - t_d)`: never
//! more than `sqrt(3)/2 h` for a spacing `h`, in the middle of eight nodes ([`DistanceGrid::error_bound`]); a tenth of it
//! where the surface is flat. Outside the lattice, where distances are bounded from below by those at its border (the
//! angle there is never acute), the value is `sqrt(a^2 + d^2)` for a point `a` off the lattice whose nearest point has
//! the distance `d`: continuous, and at most the truth but for the error above.

use super::surface;
use nalgebra::{Point3, Vector3};

/// A signed distance; see the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceGrid {
    origin: Point3<f64>,
    spacing: f64,
    /// Nodes along x, y, z; x runs fastest.
    dims: [usize; 3],
    values: Vec<f32>,
}

/// Why there is no grid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The spacing or the room around is no length.
    #[error("{what} is {value}: it must be {must}")]
    Length {
        /// `cell`, `spacing` or `room`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Nothing is solid.
    #[error("nothing is solid: there is no distance to nothing")]
    Empty,
    /// The words are not those of the grid.
    #[error("{words} words of cells, a grid of {dims:?} has {wanted}")]
    Words {
        /// Cells along x, y, z.
        dims: [u32; 3],
        /// Words given.
        words: usize,
        /// Words needed.
        wanted: u64,
    },
    /// Too many nodes: a coarser spacing or less room is needed.
    #[error("{nodes} nodes: at most {most} fit, take a coarser spacing or less room around")]
    TooLarge {
        /// How many it would be.
        nodes: f64,
        /// How many may be.
        most: usize,
    },
    /// A point is not finite.
    #[error("point {point} is not finite")]
    Point {
        /// Which point.
        point: usize,
    },
    /// A triangle has a corner that there is not.
    #[error("triangle {triangle} has corner {corner}, there are {points} points")]
    Corner {
        /// Which triangle.
        triangle: usize,
        /// Its corner.
        corner: u32,
        /// Number of points.
        points: usize,
    },
    /// The triangles do not close: what is inside is not said.
    #[error("the surface is open at the edge from point {from} to point {to}: inside and outside cannot be told")]
    Open {
        /// Where the edge starts.
        from: u32,
        /// Where it ends.
        to: u32,
    },
}

/// Most nodes: 256 MB of distances, and the squares of all distances fit 32 bits.
pub const MOST_NODES: usize = 1 << 26;

impl DistanceGrid {
    /// The distance to a set of cells: bit `x % 64` of word `x / 64` of row `y + ny z`.
    ///
    /// # Arguments
    /// * `dims`, `rows`: the set; rows are padded to whole words, bits beyond `dims[0]` do not count.
    /// * `cell`: side of a cell in millimetres; also the spacing of the lattice.
    /// * `corner`: where the grid begins.
    /// * `room`: cells of lattice around the grid, at least 1. Beyond it distances are still bounded from below.
    ///
    /// # Errors
    /// [`GridError`]; nothing is allocated by a number that the words do not bear out.
    ///
    /// # Cost
    /// `O(nodes)`, about 60 ns each; four bytes each are kept, and sixteen while it is made.
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::{indicator::geometric::DistanceGrid, nalgebra::Point3};
    /// // A bar of three cells of 2 mm.
    /// let bar = DistanceGrid::from_cells([3, 1, 1], &[0b111], 2.0, &Point3::origin(), 4)?;
    /// assert_eq!(bar.distance(&Point3::new(8.0, 1.0, 1.0)), 2.0);
    /// assert_eq!(bar.distance(&Point3::new(2.0, 6.0, 2.0)), 4.0);
    /// // Off the lattice, which ends 8 mm above the bar, a bound from below: 98 is the truth.
    /// let far = bar.distance(&Point3::new(3.0, 1.0, 100.0));
    /// assert!(far > 90.0 && far <= 98.0);
    /// # Ok::<(), curvlay_trajectory::indicator::geometric::GridError>(())
    /// ```
    pub fn from_cells(
        dims: [u32; 3],
        rows: &[u64],
        cell: f64,
        corner: &Point3<f64>,
        room: u32,
    ) -> Result<Self, GridError> {
        check_length("cell", cell)?;
        if !corner.iter().all(|x| x.is_finite()) {
            return Err(GridError::Point { point: 0 });
        }
        if room == 0 {
            return Err(GridError::Length { what: "room", value: 0.0, must: "at least 1" });
        }
        let words = u64::from(dims[0].div_ceil(64));
        let wanted = words.saturating_mul(u64::from(dims[1])).saturating_mul(u64::from(dims[2]));
        if rows.len() as u64 != wanted {
            return Err(GridError::Words { dims, words: rows.len(), wanted });
        }
        let nodes = dims.map(|n| f64::from(n) + 2.0 * f64::from(room) + 1.0);
        check_nodes(&nodes)?;
        let size = nodes.map(|n| n as usize);
        // Each cell marks its eight corners, solid or empty. Cells of the room are empty.
        let (solid, empty) = mark(dims, rows, room as usize, &size);
        if !solid.contains(&0) {
            return Err(GridError::Empty);
        }
        let (outside, inside) = (transform(solid, &size), transform(empty, &size));
        let signed = |(&out, &inn): (&i32, &i32)| {
            let square = if out > 0 { f64::from(out) } else { -f64::from(inn) };
            (cell * square.abs().sqrt()).copysign(square) as f32
        };
        let values = outside.iter().zip(&inside).map(signed).collect();
        let origin = corner - Vector3::repeat(cell * f64::from(room));
        Ok(DistanceGrid { origin, spacing: cell, dims: size, values })
    }

    /// The distance to a solid bounded by triangles, sampled every `spacing` millimetres with `room` millimetres around.
    ///
    /// The triangles must close: each edge as often one way as the other. Where the surface winds about a point, in
    /// either direction, the point is inside, so overlapping parts and both orientations do no harm; what lies inside
    /// of overlapping parts has the distance to the nearest triangle.
    ///
    /// # Errors
    /// [`GridError`] names the point, triangle or edge.
    ///
    /// # Cost
    /// `O(nodes log triangles)`, about a microsecond a node.
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::{indicator::geometric::DistanceGrid, nalgebra::Point3};
    /// let points = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]].map(Point3::from);
    /// let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    /// let wedge = DistanceGrid::from_triangles(&points, &faces, 1.0, 3.0)?;
    /// assert!((wedge.distance(&Point3::new(-2.0, 3.0, 3.0)) - 2.0).abs() < 1e-6);
    /// assert!((wedge.distance(&Point3::new(1.0, 2.0, 2.0)) + 1.0).abs() < 1e-6);
    /// # Ok::<(), curvlay_trajectory::indicator::geometric::GridError>(())
    /// ```
    pub fn from_triangles(
        points: &[Point3<f64>],
        triangles: &[[u32; 3]],
        spacing: f64,
        room: f64,
    ) -> Result<Self, GridError> {
        check_length("spacing", spacing)?;
        check_length("room", room)?;
        surface::check(points, triangles)?;
        let used = || triangles.iter().flatten().map(|&corner| points[corner as usize]);
        let low = used().fold(Point3::from([f64::INFINITY; 3]), |a, b| a.inf(&b));
        let high = used().fold(Point3::from([f64::NEG_INFINITY; 3]), |a, b| a.sup(&b));
        if triangles.is_empty() {
            return Err(GridError::Empty);
        }
        let around = (room / spacing).ceil();
        let nodes = [0, 1, 2].map(|d| ((high[d] - low[d]) / spacing).ceil() + 2.0 * around + 1.0);
        check_nodes(&nodes)?;
        let dims = nodes.map(|n| n as usize);
        let origin = low - Vector3::repeat(around * spacing);
        let values = surface::distances(points, triangles, &origin, spacing, &dims);
        Ok(DistanceGrid { origin, spacing, dims, values })
    }

    /// How wrong a distance within the lattice can be at most, in millimetres: `sqrt(3)/2` of the spacing.
    pub fn error_bound(&self) -> f64 {
        // Rounding of distances to 32 bits, and of points from triangles to a millionth of the spacing, adds little.
        (0.75f64.sqrt() + 4e-6) * self.spacing
    }

    /// Where a point lies: its cell of the lattice, how far into it, and how far the point is off the lattice.
    #[inline]
    fn locate(&self, point: &Point3<f64>) -> ([usize; 3], [f64; 3], Vector3<f64>) {
        let mut off = Vector3::zeros();
        let (mut cell, mut share) = ([0; 3], [0.0; 3]);
        for d in 0..3 {
            let last = (self.dims[d] - 1) as f64;
            let place = (point[d] - self.origin[d]) / self.spacing;
            let held = place.clamp(0.0, last);
            off[d] = (place - held) * self.spacing;
            // Not below zero, so cut off is rounded down.
            cell[d] = (held as usize).min(self.dims[d] - 2);
            share[d] = held - cell[d] as f64;
        }
        (cell, share, off)
    }

    #[inline]
    fn corners(&self, cell: &[usize; 3]) -> [f64; 8] {
        let y = self.dims[0];
        let z = y * self.dims[1];
        let first = cell[0] + y * cell[1] + z * cell[2];
        let (low, up) = (&self.values[first..first + y + 2], &self.values[first + z..first + z + y + 2]);
        let pair = |row: &[f32], at: usize| (f64::from(row[at]), f64::from(row[at + 1]));
        let [(a, b), (c, d), (e, f), (g, h)] = [pair(low, 0), pair(low, y), pair(up, 0), pair(up, y)];
        [a, b, c, d, e, f, g, h]
    }

    /// The distance of a point, in millimetres. Of a point that is not finite, not a number.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let (cell, [x, y, z], off) = self.locate(point);
        let c = self.corners(&cell);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let low = mix(mix(c[0], c[1], x), mix(c[2], c[3], x), y);
        let high = mix(mix(c[4], c[5], x), mix(c[6], c[7], x), y);
        let value = mix(low, high, z);
        let beyond = off.norm_squared();
        if beyond > 0.0 { (beyond + value * value).sqrt() } else { value + 0.0 * beyond }
    }

    /// The distance of a point and its derivative by the point.
    pub fn gradient(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        let (cell, [x, y, z], off) = self.locate(point);
        let c = self.corners(&cell);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let along_x = [mix(c[0], c[1], x), mix(c[2], c[3], x), mix(c[4], c[5], x), mix(c[6], c[7], x)];
        let (low, high) = (mix(along_x[0], along_x[1], y), mix(along_x[2], along_x[3], y));
        let value = mix(low, high, z);
        let slope_x = mix(mix(c[1] - c[0], c[3] - c[2], y), mix(c[5] - c[4], c[7] - c[6], y), z);
        let slope_y = mix(along_x[1] - along_x[0], along_x[3] - along_x[2], z);
        let slope = Vector3::new(slope_x, slope_y, high - low) / self.spacing;
        let beyond = off.norm_squared();
        if beyond > 0.0 {
            let all = (beyond + value * value).sqrt();
            let part = |d: usize| if off[d].abs() > 0.0 { off[d] / all } else { slope[d] * value / all };
            return (all, Vector3::new(part(0), part(1), part(2)));
        }
        (value + 0.0 * beyond, slope)
    }
}

fn check_length(what: &'static str, value: f64) -> Result<(), GridError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(GridError::Length { what, value, must: "finite and above 0" })
}

fn check_nodes(nodes: &[f64; 3]) -> Result<(), GridError> {
    let all: f64 = nodes.iter().product();
    // Squares of three sides fit 32 bits: a long thin grid is refused too.
    if all <= MOST_NODES as f64 && nodes.iter().all(|&n| n <= LONGEST) {
        return Ok(());
    }
    Err(GridError::TooLarge { nodes: all, most: MOST_NODES })
}

/// Most nodes along one side.
const LONGEST: f64 = 8192.0;

/// Larger than any square of a distance, and twice it still fits.
const FAR: i32 = 1 << 29;

/// Of each node 0 where it is a corner of a solid cell, and where it is one of an empty cell; else `FAR`.
fn mark(dims: [u32; 3], rows: &[u64], room: usize, size: &[usize; 3]) -> (Vec<i32>, Vec<i32>) {
    let [nx, ny, nz] = dims.map(|n| n as usize);
    let words = nx.div_ceil(64);
    let [sx, sy, sz] = *size;
    let is_solid = |x: usize, y: usize, z: usize| rows[words * (y + ny * z) + x / 64] >> (x % 64) & 1 == 1;
    let mut solid = vec![FAR; sx * sy * sz];
    let mut empty = vec![FAR; sx * sy * sz];
    for (z, y) in (0..sz).flat_map(|z| (0..sy).map(move |y| (z, y))) {
        for x in 0..sx {
            let node = x + sx * (y + sy * z);
            let within = |at: usize, n: usize| (room..=room + n).contains(&at);
            if !(within(x, nx) && within(y, ny) && within(z, nz)) {
                empty[node] = 0;
                continue;
            }
            // The up to eight cells around it; beyond the grid they are empty.
            let mut filled = 0;
            for around in 0..8 {
                let cell = |at: usize, bit: usize, n: usize| (at + bit).checked_sub(room + 1).filter(|&k| k < n);
                let [x, y, z] = [cell(x, around & 1, nx), cell(y, around >> 1 & 1, ny), cell(z, around >> 2, nz)];
                if let (Some(x), Some(y), Some(z)) = (x, y, z) {
                    filled += usize::from(is_solid(x, y, z));
                }
            }
            if filled > 0 {
                solid[node] = 0;
            }
            if filled < 8 {
                empty[node] = 0;
            }
        }
    }
    (solid, empty)
}

/// From marks to squared distances of the nearest mark, in cells.
fn transform(mut field: Vec<i32>, size: &[usize; 3]) -> Vec<i32> {
    let [sx, sy, sz] = *size;
    let longest = sx.max(sy).max(sz);
    let (mut line, mut hulls) = (vec![0; longest], vec![(0i32, 0i32); longest]);
    for (stride, count) in [(1, sx), (sx, sy), (sx * sy, sz)] {
        for first in 0..sx * sy * sz {
            // The first node of each line along this axis.
            if first / stride % count != 0 {
                continue;
            }
            let nodes = (0..count).map(|k| first + k * stride);
            line.iter_mut().zip(nodes.clone()).for_each(|(value, node)| *value = field[node]);
            envelope(&line[..count], &mut hulls, |k, value| field[first + k * stride] = value);
        }
    }
    field
}

/// `min over i of (k - i)^2 + line[i]` for each `k`: the lower envelope of parabolas, which take over from each other at
/// whole numbers.
fn envelope(line: &[i32], hulls: &mut [(i32, i32)], mut put: impl FnMut(usize, i32)) {
    let count = line.len() as i32;
    // The parabola of `i` lies lowest from `start` on.
    let mut last = 0;
    hulls[0] = (0, 0);
    let value = |i: i32, at: i32| (at - i) * (at - i) + line[i as usize];
    for i in 1..count {
        loop {
            let (before, start) = hulls[last];
            if value(before, start) > value(i, start) {
                if last == 0 {
                    hulls[0] = (i, 0);
                    break;
                }
                last -= 1;
                continue;
            }
            // The first whole number at which i is lower.
            let from =
                (i * i - before * before + line[i as usize] - line[before as usize]).div_euclid(2 * (i - before)) + 1;
            if from < count {
                last += 1;
                hulls[last] = (i, from);
            }
            break;
        }
    }
    for k in (0..count).rev() {
        let (i, start) = hulls[last];
        put(k as usize, value(i, k).min(FAR));
        if k == start && last > 0 {
            last -= 1;
        }
    }
}
