//! Which cells a triangle touches, decided exactly.
//!
//! A cell is touched when its open interior meets the closed triangle. Corners of triangles are integers in units of
//! `1 / ONE` of a cell (see [`crate::lattice`]), so that every decision below is one of integers.
//!
//! Take one row of cells: the open prism `(y, y + 1) x (z, z + 1)` along x. If the triangle meets it, then by
//! convexity the closure of what lies inside the open prism is what lies inside the closed one, a convex polygon. With
//! `inf` and `sup` its extent along x, cell `x` of the row is touched if and only if `inf < x + 1` and `sup > x`: the
//! cells from `floor(inf)` up to, not including, `ceil(sup)`. The corners of that polygon are
//! 1. corners of the triangle,
//! 2. points where an edge of the triangle crosses one of the planes `y = j` or `z = k`,
//! 3. points where one of the lines `y = j, z = k` crosses the triangle,
//!
//! and since the floor of a least value is the least of the floors, each of them is rounded for itself (rational to
//! integer, exactly) and counted in every row whose closed prism it lies in. Whether the triangle meets the *open*
//! prism is asked of its projection along x by separating axes: a closed polygon misses an open square if and only if
//! one of their edge directions separates them weakly.
//!
//! A triangle within a plane of the grid touches no cell. It still separates the cells on its two sides; [`Walls`]
//! remembers that.

use crate::GridError;
use crate::grid::zeroed;
use crate::lattice::{BITS, ONE};

/// A triangle in lattice units.
pub(crate) type Corners = [[i64; 3]; 3];

/// Rows and layers of a window: triangles are worked off window by window, so that the room taken by one triangle
/// does not grow with it. Any size gives the same cells; 64 keeps the extents in the first-level cache.
const WINDOW: i64 = 64;

/// Bits of a grid, to be set.
#[derive(Debug)]
pub(crate) struct Bits {
    dims: [u32; 3],
    words: usize,
    pub(crate) rows: Vec<u64>,
}

impl Bits {
    /// Takes rows of bits that fit `dims`.
    pub(crate) fn new(dims: [u32; 3], rows: Vec<u64>) -> Self {
        Bits { dims, words: dims[0].div_ceil(64) as usize, rows }
    }

    /// The same bits once more, or an error where the machine does not have the memory.
    pub(crate) fn copy(&self) -> Result<Self, GridError> {
        let mut rows = zeroed(self.rows.len(), self.dims)?;
        rows.copy_from_slice(&self.rows);
        Ok(Bits { rows, ..*self })
    }

    /// The bits of a row.
    pub(crate) fn row(&self, row: usize) -> &[u64] {
        &self.rows[row * self.words..(row + 1) * self.words]
    }

    /// Sets the cells from `first` up to, not including, `end`.
    pub(crate) fn set(&mut self, row: usize, first: u32, end: u32) {
        debug_assert!(first < end && end <= self.dims[0]);
        let row = &mut self.rows[row * self.words..(row + 1) * self.words];
        let (from, to) = (first as usize / 64, (end - 1) as usize / 64);
        let (low, high) = (!0 << (first % 64), !0 >> (63 - (end - 1) % 64));
        if from == to {
            row[from] |= low & high;
        } else {
            row[from] |= low;
            row[from + 1..to].fill(!0);
            row[to] |= high;
        }
    }
}

/// Where triangles lie within planes of the grid.
#[derive(Debug, Default)]
pub(crate) struct Walls {
    /// For each axis that has any: the cells whose low face along that axis is met by such a triangle.
    pub(crate) low_faces: [Option<Bits>; 3],
    /// For each axis, whether there is one in the first or in the last plane of the grid.
    pub(crate) on_border: [[bool; 2]; 3],
}

impl Walls {
    /// The same walls once more.
    pub(crate) fn copy(&self) -> Result<Self, GridError> {
        let mut walls = Walls { on_border: self.on_border, ..Walls::default() };
        for (copy, bits) in walls.low_faces.iter_mut().zip(&self.low_faces) {
            *copy = bits.as_ref().map(Bits::copy).transpose()?;
        }
        Ok(walls)
    }
}

/// Marks the cells that triangles touch.
#[derive(Debug)]
pub(crate) struct Painter {
    extents: Vec<[i32; 2]>,
}

impl Painter {
    pub(crate) fn new() -> Self {
        Painter { extents: Vec::with_capacity((WINDOW * WINDOW) as usize) }
    }

    /// Sets the cells that the triangle touches, or the walls where it lies within a plane of the grid.
    /// All corners must lie in the closed grid. Returns the number of rows that were looked at. Fails only where walls
    /// do not get memory.
    pub(crate) fn paint(&mut self, corners: &Corners, cells: &mut Bits, walls: &mut Walls) -> Result<usize, GridError> {
        for axis in 0..3 {
            let at = corners[0][axis];
            if at % ONE != 0 || corners[1][axis] != at || corners[2][axis] != at {
                continue;
            }
            let (plane, last) = (at >> BITS, i64::from(cells.dims[axis]));
            if plane == 0 || plane == last {
                walls.on_border[axis][usize::from(plane == last)] = true;
                return Ok(0);
            }
            // Half a cell up it touches just those cells whose low face it meets.
            return self.touch_lifted(corners, axis, ONE / 2, &mut walls.low_faces[axis], cells);
        }
        Ok(self.touch(corners, cells))
    }

    /// Adds the triangle to `ends` if it lies in the first or the last plane of the grid along an axis: there, by axis
    /// and end, stand the cells whose face to the outside it meets. `like` has the size of the grid.
    pub(crate) fn paint_ends(
        &mut self,
        corners: &Corners,
        ends: &mut [[Option<Bits>; 2]; 3],
        like: &Bits,
    ) -> Result<(), GridError> {
        for axis in 0..3 {
            for (end, plane) in [0, i64::from(like.dims[axis]) * ONE].into_iter().enumerate() {
                if corners.iter().all(|corner| corner[axis] == plane) {
                    let inwards = if end == 0 { ONE / 2 } else { -ONE / 2 };
                    self.touch_lifted(corners, axis, inwards, &mut ends[axis][end], like)?;
                }
            }
        }
        Ok(())
    }

    /// Sets in `bits` the cells that the triangle touches when moved along an axis.
    fn touch_lifted(
        &mut self,
        corners: &Corners,
        axis: usize,
        by: i64,
        bits: &mut Option<Bits>,
        like: &Bits,
    ) -> Result<usize, GridError> {
        let bits = match bits {
            Some(bits) => bits,
            none => none.insert(Bits::new(like.dims, zeroed(like.rows.len(), like.dims)?)),
        };
        let lifted = corners.map(|mut corner| {
            corner[axis] += by;
            corner
        });
        Ok(self.touch(&lifted, bits))
    }

    /// Sets the cells that the triangle touches. Returns the number of rows looked at.
    fn touch(&mut self, corners: &Corners, cells: &mut Bits) -> usize {
        let along = |axis: usize| corners.map(|corner| corner[axis]);
        let first = [0, 1, 2].map(|axis| least(along(axis)) >> BITS);
        let end = [0, 1, 2].map(|axis| -(-greatest(along(axis)) >> BITS));
        if (0..3).any(|axis| first[axis] >= end[axis]) {
            return 0;
        }
        let ny = cells.dims[1] as usize;
        if end[1] - first[1] == 1 && end[2] - first[2] == 1 {
            // One row, and the projection is not within the border of its square: the row is met.
            cells.set(first[1] as usize + ny * first[2] as usize, first[0] as u32, end[0] as u32);
            return 1;
        }
        let shadow = Shadow::new(corners);
        for z in (first[2]..end[2]).step_by(WINDOW as usize) {
            for y in (first[1]..end[1]).step_by(WINDOW as usize) {
                let window = Window { first: [y, z], end: [(y + WINDOW).min(end[1]), (z + WINDOW).min(end[2])] };
                if shadow.meets(window.first, [window.end[0] - y, window.end[1] - z]) {
                    self.touch_window(corners, &shadow, &window, cells);
                }
            }
        }
        ((end[1] - first[1]) * (end[2] - first[2])) as usize
    }

    /// Sets the cells that the triangle touches in the rows of a window.
    fn touch_window(&mut self, corners: &Corners, shadow: &Shadow, window: &Window, cells: &mut Bits) {
        let [[y0, z0], [y1, z1]] = [window.first, window.end];
        let width = y1 - y0;
        self.extents.clear();
        self.extents.resize((width * (z1 - z0)) as usize, [i32::MAX, i32::MIN]);
        // A point counts in the rows whose closed prism has it; each of its coordinates comes as floor and ceiling.
        let mut count = |[x, y, z]: [[i64; 2]; 3]| {
            for z in (z[1] - 1).max(z0)..=z[0].min(z1 - 1) {
                for y in (y[1] - 1).max(y0)..=y[0].min(y1 - 1) {
                    let extent = &mut self.extents[(y - y0 + width * (z - z0)) as usize];
                    extent[0] = extent[0].min(x[0] as i32);
                    extent[1] = extent[1].max(x[1] as i32);
                }
            }
        };
        for (at, &corner) in corners.iter().enumerate() {
            count(corner.map(|c| [c >> BITS, -(-c >> BITS)]));
            crossings(corner, corners[(at + 1) % 3], window, &mut count);
        }
        shadow.lines_through(window, &mut count);
        let ny = cells.dims[1] as usize;
        let mut extents = self.extents.iter();
        for z in z0..z1 {
            for y in y0..y1 {
                let [first, end] = extents.next().copied().unwrap_or_default();
                // Where the open prism is missed, the extent is that of a touch from outside.
                if first < end && shadow.meets([y, z], [1, 1]) {
                    cells.set(y as usize + ny * z as usize, first as u32, end as u32);
                }
            }
        }
    }
}

/// A block of rows: first and end along y and z.
struct Window {
    first: [i64; 2],
    end: [i64; 2],
}

/// Counts the points where the edge from `a` to `b` crosses the planes of the window, in both directions.
fn crossings(a: [i64; 3], b: [i64; 3], window: &Window, count: &mut impl FnMut([[i64; 2]; 3])) {
    for (axis, other) in [(1, 2), (2, 1)] {
        let (from, to) = if a[axis] < b[axis] { (a, b) } else { (b, a) };
        let run = to[axis] - from[axis];
        if run == 0 {
            continue;
        }
        let first = (-(-from[axis] >> BITS)).max(window.first[axis - 1]);
        let last = (to[axis] >> BITS).min(window.end[axis - 1]);
        for plane in first..=last {
            let part = (plane << BITS) - from[axis];
            let at = |axis: usize| cells_of(from[axis], part, to[axis] - from[axis], run);
            let mut point = [at(0), [plane; 2], [plane; 2]];
            point[other] = at(other);
            count(point);
        }
    }
}

/// Floor and ceiling, in cells, of `start + part * rise / run` (`run > 0`).
fn cells_of(start: i64, part: i64, rise: i64, run: i64) -> [i64; 2] {
    let (floor, exact) = match part.checked_mul(rise) {
        Some(product) => (product.div_euclid(run), product.rem_euclid(run) == 0),
        None => {
            let (product, run) = (i128::from(part) * i128::from(rise), i128::from(run));
            (product.div_euclid(run) as i64, product.rem_euclid(run) == 0)
        }
    };
    let (floor, ceiling) = (start + floor, start + floor + i64::from(!exact));
    [floor >> BITS, -(-ceiling >> BITS)]
}

/// The projection of a triangle along x.
struct Shadow {
    /// Half planes `value + y * slope[0] + z * slope[1] >= 0` over the planes of the grid (`y`, `z` whole cells), whose
    /// intersection it is, or, where it is a segment, both sides of that.
    edges: [Edge; 3],
    /// How many there are: three, two for a segment, none for a point.
    count: usize,
    /// Corner of the triangle, and its normal with a positive x, if the projection has an area.
    plane: Option<([i64; 3], [i128; 3])>,
}

#[derive(Clone, Copy, Default)]
struct Edge {
    value: i128,
    slope: [i128; 2],
}

impl Edge {
    /// The left side of the line from `a` to `b`, or with `turn` = -1 the right one.
    fn new(a: [i64; 3], b: [i64; 3], turn: i64) -> Self {
        let (dy, dz) = (i128::from(turn * (b[1] - a[1])), i128::from(turn * (b[2] - a[2])));
        Edge {
            value: dz * i128::from(a[1]) - dy * i128::from(a[2]),
            slope: [-dz * i128::from(ONE), dy * i128::from(ONE)],
        }
    }

    fn at(&self, [y, z]: [i64; 2]) -> i128 {
        self.value + i128::from(y) * self.slope[0] + i128::from(z) * self.slope[1]
    }
}

impl Shadow {
    fn new(corners: &Corners) -> Self {
        let [a, b, c] = *corners;
        let side = |axis: usize, from: [i64; 3], to: [i64; 3]| i128::from(to[axis] - from[axis]);
        let cross = |u: usize, v: usize| side(u, a, b) * side(v, a, c) - side(v, a, b) * side(u, a, c);
        let normal = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let pairs = [(a, b), (b, c), (c, a)];
        let mut edges = [Edge::default(); 3];
        if normal[0] != 0 {
            let turn = normal[0].signum();
            edges = pairs.map(|(from, to)| Edge::new(from, to, turn as i64));
            return Shadow { edges, count: 3, plane: Some((a, normal.map(|n| n * turn))) };
        }
        let stretched = pairs.iter().find(|(from, to)| from[1] != to[1] || from[2] != to[2]);
        if let Some(&(from, to)) = stretched {
            edges = [Edge::new(from, to, 1), Edge::new(from, to, -1), Edge::default()];
        }
        Shadow { edges, count: if stretched.is_some() { 2 } else { 0 }, plane: None }
    }

    /// Whether it meets an open rectangle of cells that overlaps its bounding box.
    fn meets(&self, first: [i64; 2], size: [i64; 2]) -> bool {
        self.edges[..self.count].iter().all(|edge| {
            let reach = |axis: usize| edge.slope[axis].max(0) * i128::from(size[axis]);
            edge.at(first) + reach(0) + reach(1) > 0
        })
    }

    /// Counts the points where the lines `y = j, z = k` of the window cross the triangle.
    fn lines_through(&self, window: &Window, count: &mut impl FnMut([[i64; 2]; 3])) {
        let Some((corner, normal)) = self.plane else { return };
        for z in window.first[1]..=window.end[1] {
            for y in window.first[0]..=window.end[0] {
                if self.edges.iter().all(|edge| edge.at([y, z]) >= 0) {
                    let off = [(y << BITS) - corner[1], (z << BITS) - corner[2]];
                    let rise = -(normal[1] * i128::from(off[0]) + normal[2] * i128::from(off[1]));
                    let floor = rise.div_euclid(normal[0]);
                    let exact = floor * normal[0] == rise;
                    let (floor, ceiling) = (corner[0] + floor as i64, corner[0] + floor as i64 + i64::from(!exact));
                    count([[floor >> BITS, -(-ceiling >> BITS)], [y; 2], [z; 2]]);
                }
            }
        }
    }
}

fn least([a, b, c]: [i64; 3]) -> i64 {
    a.min(b).min(c)
}

fn greatest([a, b, c]: [i64; 3]) -> i64 {
    a.max(b).max(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::set_bits;

    fn painted(dims: [u32; 3], corners: [[i64; 3]; 3]) -> (Vec<[u32; 3]>, Walls) {
        let words = dims[0].div_ceil(64) as usize;
        let mut cells = Bits::new(dims, vec![0; words * (dims[1] * dims[2]) as usize]);
        let mut walls = Walls::default();
        let quarters = corners.map(|corner| corner.map(|c| c * ONE / 4));
        Painter::new().paint(&quarters, &mut cells, &mut walls).unwrap();
        (list(&cells), walls)
    }

    fn list(bits: &Bits) -> Vec<[u32; 3]> {
        let at = |at: usize, bit: u32| {
            let row = (at / bits.words) as u32;
            [(at % bits.words) as u32 * 64 + bit, row % bits.dims[1], row / bits.dims[1]]
        };
        bits.rows.iter().enumerate().flat_map(|(word, &w)| set_bits(w).map(move |bit| at(word, bit))).collect()
    }

    #[test]
    fn a_triangle_in_a_plane_of_the_grid_is_a_wall_and_touches_nothing() {
        let (cells, walls) = painted([2, 2, 2], [[0, 0, 4], [8, 0, 4], [0, 8, 4]]);
        assert_eq!(cells, <[[u32; 3]; 0]>::default());
        assert_eq!(list(walls.low_faces[2].as_ref().unwrap()), [[0, 0, 1], [1, 0, 1], [0, 1, 1]]);
        let (cells, walls) = painted([2, 2, 2], [[8, 0, 0], [8, 8, 0], [8, 0, 8]]);
        assert!(cells.is_empty() && walls.low_faces.iter().all(Option::is_none));
        assert_eq!(walls.on_border, [[false, true], [false; 2], [false; 2]]);
    }

    #[test]
    fn a_diagonal_through_corners_touches_only_the_cells_on_it() {
        let (cells, _) = painted([3, 3, 3], [[0, 0, 0], [12, 12, 12], [12, 12, 12]]);
        assert_eq!(cells, [[0, 0, 0], [1, 1, 1], [2, 2, 2]]);
        // An edge along a grid line, the triangle in the plane y = z: no cell off that plane.
        let (cells, _) = painted([2, 2, 2], [[0, 0, 0], [8, 0, 0], [0, 8, 8]]);
        assert_eq!(cells, [[0, 0, 0], [1, 0, 0], [0, 1, 1]]);
    }

    #[test]
    fn runs_of_bits_are_set_over_word_borders() {
        for (first, end) in [(0, 1), (0, 64), (63, 65), (10, 190), (64, 128), (191, 192)] {
            let mut bits = Bits::new([192, 2, 1], vec![0; 6]);
            bits.set(1, first, end);
            assert_eq!(bits.row(0), [0; 3]);
            let count = bits.rows.iter().map(|w| w.count_ones()).sum::<u32>();
            assert_eq!((list(&bits)[0], count), ([first, 1, 0], end - first));
        }
    }
}
