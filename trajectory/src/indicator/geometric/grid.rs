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
//!
//! **Near and far.** Up to 16 cells around the solid the lattice is as fine as asked. Where more margin is asked for, a
//! second lattice four times as coarse covers the margin: its nodes are as exact, and between them a distance of
//! many cells is nearly straight (beside a ball of radius `r` wrong by `(4 h)^2 / 4 r`; the bound above is for grooves).
//! Over the last four cells of the near lattice its values go over into those of the far one.

use super::grid_error::GridError;
use super::lattice::Lattice;
use super::surface;
use super::transform::{mark, transform};
use nalgebra::{Point3, Vector3};

/// A signed distance; see the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceGrid {
    near: Lattice,
    /// Where more margin is asked for than the near lattice has.
    far: Option<Lattice>,
    /// The solid lies between.
    corners: [Point3<f64>; 2],
}

/// Cells around the solid with the wanted spacing.
const NEAR_MARGIN: u32 = 16;
/// Cells from one node of the far lattice to the next. 8 would need an eighth of the memory, and be wrong by a cell at the
/// edge of the near lattice beside a thin part.
const FAR_STEP: u32 = 4;
/// Cells over which near goes over into far.
const BLEND: f64 = 4.0;

/// Most nodes: 256 MB of distances, and the squares of all distances fit 32 bits.
pub const MAX_NODES: usize = 1 << 26;

impl DistanceGrid {
    /// The distance to a set of cells: bit `x % 64` of word `x / 64` of row `y + ny z`.
    ///
    /// # Arguments
    /// * `dims`, `rows`: the set; rows are padded to whole words, bits beyond `dims[0]` do not count.
    /// * `cell`: side of a cell in millimetres; also the spacing of the lattice.
    /// * `corner`: where the grid begins.
    /// * `margin`: cells of lattice around the grid, at least 1: as many as the thickest ball or capsule is wide from its
    ///   axis, and a few more. Beyond it distances are only bounded from below.
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
        margin: u32,
    ) -> Result<Self, GridError> {
        check_length("cell", cell)?;
        if !corner.iter().all(|x| x.is_finite()) {
            return Err(GridError::Point { point: 0 });
        }
        if margin == 0 {
            return Err(GridError::Length { what: "margin", value: 0.0, must: "at least 1" });
        }
        let words = u64::from(dims[0].div_ceil(64));
        let wanted = words.saturating_mul(u64::from(dims[1])).saturating_mul(u64::from(dims[2]));
        if rows.len() as u64 != wanted {
            return Err(GridError::Words { dims, words: rows.len(), wanted });
        }
        let around = margin.min(NEAR_MARGIN);
        let beyond = (margin - around).div_ceil(FAR_STEP);
        let nodes = dims.map(|n| f64::from(n) + 2.0 * f64::from(around) + 1.0);
        check_nodes(&nodes)?;
        let size = nodes.map(|n| n as usize);
        let far_nodes = nodes.map(|n| ((n - 1.0) / f64::from(FAR_STEP)).ceil() + 2.0 * f64::from(beyond) + 1.0);
        if beyond > 0 {
            check_nodes(&far_nodes)?;
            // On the way along the axes there are values at far places of one and near places of another.
            check_nodes(&[far_nodes[0], nodes[1], nodes[2]])?;
            check_nodes(&[far_nodes[0], far_nodes[1], nodes[2]])?;
        }
        // Each cell marks its eight corners, solid or empty. Cells of the margin are empty.
        let (solid, empty) = mark(dims, rows, around as usize, &size);
        if !solid.contains(&0) {
            return Err(GridError::Empty);
        }
        let own = size.map(|n| (0..n as i32).collect::<Vec<i32>>());
        let own = own.each_ref().map(Vec::as_slice);
        let (outside, inside) = (transform(&solid, &size, own), transform(&empty, &size, own));
        let signed = |(&out, &inn): (&i32, &i32)| {
            let square = if out > 0 { f64::from(out) } else { -f64::from(inn) };
            (cell * square.abs().sqrt()).copysign(square) as f32
        };
        let values: Vec<f32> = outside.iter().zip(&inside).map(signed).collect();
        let origin = corner - Vector3::repeat(cell * f64::from(around));
        let far = (beyond > 0).then(|| {
            let (first, step) = (-((beyond * FAR_STEP) as i32), FAR_STEP as i32);
            let size_far = far_nodes.map(|n| n as usize);
            let places = size_far.map(|n| (0..n as i32).map(|k| first + k * step).collect::<Vec<i32>>());
            let squares = transform(&solid, &size, places.each_ref().map(Vec::as_slice));
            let values: Vec<f32> = squares.iter().map(|&square| (cell * f64::from(square).sqrt()) as f32).collect();
            let origin = origin + Vector3::repeat(cell * f64::from(first));
            Lattice::new(origin, cell * f64::from(FAR_STEP), size_far, &values)
        });
        let high = [0, 1, 2].map(|d| corner[d] + cell * f64::from(dims[d]));
        Ok(DistanceGrid { near: Lattice::new(origin, cell, size, &values), far, corners: [*corner, high.into()] })
    }

    /// The distance to a solid bounded by triangles, sampled every `spacing` millimetres with `margin` millimetres around.
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
        margin: f64,
    ) -> Result<Self, GridError> {
        check_length("spacing", spacing)?;
        check_length("margin", margin)?;
        surface::check(points, triangles)?;
        let used = || triangles.iter().flatten().map(|&corner| points[corner as usize]);
        let low = used().fold(Point3::from([f64::INFINITY; 3]), |a, b| a.inf(&b));
        let high = used().fold(Point3::from([f64::NEG_INFINITY; 3]), |a, b| a.sup(&b));
        if triangles.is_empty() {
            return Err(GridError::Empty);
        }
        let steps = (margin / spacing).ceil();
        let around = steps.min(f64::from(NEAR_MARGIN));
        let beyond = ((steps - around) / f64::from(FAR_STEP)).ceil();
        let nodes = [0, 1, 2].map(|d| ((high[d] - low[d]) / spacing).ceil() + 2.0 * around + 1.0);
        check_nodes(&nodes)?;
        let far_nodes = nodes.map(|n| ((n - 1.0) / f64::from(FAR_STEP)).ceil() + 2.0 * beyond + 1.0);
        check_nodes(&far_nodes)?;
        let lattice = |from: f64, spacing: f64, nodes: [f64; 3]| {
            let (dims, origin) = (nodes.map(|n| n as usize), low - Vector3::repeat(from));
            let values = surface::distances(points, triangles, &origin, spacing, &dims);
            Lattice::new(origin, spacing, dims, &values)
        };
        let near = lattice(around * spacing, spacing, nodes);
        let far_step = f64::from(FAR_STEP) * spacing;
        let far = (beyond > 0.0).then(|| lattice(around * spacing + beyond * far_step, far_step, far_nodes));
        Ok(DistanceGrid { near, far, corners: [low, high] })
    }

    /// Side of a cell of the near lattice, in millimetres.
    pub fn spacing(&self) -> f64 {
        self.near.spacing
    }

    /// How wrong a distance within the lattice can be at most, in millimetres: `sqrt(3)/2` of the spacing, where there
    /// is a far lattice of its spacing.
    pub fn error_bound(&self) -> f64 {
        // Rounding of distances to 32 bits, and of points from triangles to a millionth of the spacing, adds little.
        (0.75f64.sqrt() + 4e-6) * self.far.as_ref().map_or(self.near.spacing, |far| far.spacing)
    }

    /// Whether all points within `radius` of a segment are as far from the solid as `best`, judged
    /// by the box of the solid, without a look at the lattice: by the middle of the segment, else by the plane through
    /// the point of the box that is nearest to one of the segment.
    #[inline]
    pub(super) fn is_beyond(&self, middle: &Point3<f64>, half: &Vector3<f64>, radius: f64, best: f64) -> bool {
        let [low, high] = &self.corners;
        let square = half.norm_squared();
        let wanted = (best + radius).max(0.0);
        let off = (low - middle).sup(&(middle - high)).sup(&Vector3::zeros());
        let reach = wanted + square.sqrt();
        if off.norm_squared() > reach * reach {
            return true;
        }
        let share = if square > 0.0 { half.dot(&(nalgebra::center(low, high) - middle)) / square } else { 0.0 };
        let at = middle + half * share.clamp(-1.0, 1.0);
        let nearest = at.sup(low).inf(high);
        let out = at - nearest;
        // The box lies behind this plane, and the segment as far before it as its nearer end.
        let ahead = out.dot(&(middle - nearest)) - out.dot(half).abs();
        ahead > 0.0 && ahead * ahead >= wanted * wanted * out.norm_squared()
    }

    /// What the far lattice counts at a place of the near one, with the axis along which that changes and how.
    #[inline]
    fn share_of_far(&self, place: &[f64; 3]) -> (f64, usize, f64) {
        let (mut steps, mut axis, mut change) = (f64::INFINITY, 0, 0.0);
        for d in 0..3 {
            let [from_low, from_high] = self.near.inside(place, d);
            let (inside, slope) = if from_low < from_high { (from_low, -1.0) } else { (from_high, 1.0) };
            if inside < steps {
                (steps, axis, change) = (inside, d, slope);
            }
        }
        let share = 1.0 - steps / BLEND;
        if share >= 1.0 { (1.0, axis, 0.0) } else { (share.max(0.0), axis, change / (BLEND * self.near.spacing)) }
    }

    /// The distance of a point, in millimetres. Of a point that is not finite, not a number.
    #[inline]
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let place = self.near.place(point);
        let Some(far) = &self.far else { return self.near.distance(&place) };
        let (share, ..) = self.share_of_far(&place);
        if share <= 0.0 {
            return self.near.distance(&place);
        }
        let coarse = far.distance(&far.place(point));
        if share >= 1.0 { coarse } else { coarse * share + self.near.distance(&place) * (1.0 - share) }
    }

    /// The distance of a point and its derivative by the point.
    pub fn gradient(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        let place = self.near.place(point);
        let Some(far) = &self.far else { return self.near.gradient(&place) };
        let (share, axis, change) = self.share_of_far(&place);
        if share <= 0.0 {
            return self.near.gradient(&place);
        }
        let (coarse, coarse_slope) = far.gradient(&far.place(point));
        if share >= 1.0 {
            return (coarse, coarse_slope);
        }
        let (fine, fine_slope) = self.near.gradient(&place);
        let mut slope = coarse_slope * share + fine_slope * (1.0 - share);
        slope[axis] += change * (coarse - fine);
        (coarse * share + fine * (1.0 - share), slope)
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
    if all <= MAX_NODES as f64 && nodes.iter().all(|&n| n <= MAX_SIDE_NODES) {
        return Ok(());
    }
    Err(GridError::TooLarge { nodes: all, max: MAX_NODES })
}

/// Most nodes along one side.
const MAX_SIDE_NODES: f64 = 8192.0;
