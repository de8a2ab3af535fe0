//! Manifold dual contouring: the surfaces of a field at given values.
//!
//! Dai 2020, section 3.4.5 (dual contouring of the growing field, Equation 3.2); G. M. Nielson, "Dual marching
//! cubes", IEEE Visualization 2004 (a vertex for each piece of the surface in a cube).
//! Symbols: `g_i` is [`ExtendedField::levels`], the paper's `w` the cell, its `d` the layer height.
//!
//! Nodes are the centres of cells. A joined edge of the lattice whose ends lie on both sides of the level is *crossed*
//! and becomes a quadrangle around it, with a corner in each of the four cubes at the edge. A cube has a vertex for
//! each *piece* of the surface in it ([`cube`]). It is the mean of the piece's crossings; where the part of
//! the cube that the piece belongs to ends on one side, at a cut or beyond the last ring, it is moved to the middle of
//! the cube along the slope, so that a surface covers its cells up to their faces.
//!
//! The result is a 2-manifold with boundary whatever the field: around each vertex the quadrangles form one fan, since
//! chains and rings of crossed edges do. Two quadrangles have an edge in common for each line across a face between two
//! cubes; where two lines join the same two vertices, each gets a vertex of its own on the face.
//!
//! Departs from the paper: no error functions are minimised, since the field is smooth and has no edges to catch; the
//! level's distance, not the cell's, gives the spacing.

mod cube;

use super::extend::{ExtendedField, JUMP};
use cube::{LOW_CORNER, Pieces, after, partner};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Nearest that a vertex comes to a face of its cube, in cells. Vertices of different cubes are twice as far apart
/// then, which keeps triangles from having no height; a larger margin would move surfaces that lie in the planes of
/// the nodes.
const MARGIN: f64 = 0.005;

/// A node counts as having reached a level if it lacks no more than this, in layers: rounding alone does not decide
/// on which side of it the nodes of a plane lie.
const REACHED: f64 = 1e-6;

/// Least layer height, in cells. Below it a cell holds more than five surfaces, and the field knows nothing of what is
/// between the centres of cells.
const LEAST_HEIGHT: f64 = 0.2;

/// A triangle mesh that is a surface of a field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The value of the field, in layers.
    pub value: f64,
    /// Its points, in millimetres.
    pub points: Vec<Point3<f64>>,
    /// Its triangles, by the numbers of their corners, counter-clockwise seen from where the growth goes.
    pub triangles: Vec<[u32; 3]>,
}

/// Why there are no surfaces.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContourError {
    /// Cells without size, or a place without coordinates.
    #[error("cells of {cell_mm} mm at {origin:?}: the size must be finite and above 0, the place finite")]
    Placement {
        /// The edge of a cell.
        cell_mm: f64,
        /// The low corner of the grid.
        origin: [f64; 3],
    },
    /// The layers are too thin for the cells.
    #[error(
        "a layer height of {height_mm} mm is below a fifth of a cell of {cell_mm} mm: take smaller cells or thicker layers"
    )]
    TooThin {
        /// The layer height.
        height_mm: f64,
        /// The edge of a cell.
        cell_mm: f64,
    },
    /// The layers are thicker than the part.
    #[error("a layer height of {height_mm} mm is more than the part has, {part_mm} mm along its growth")]
    TooThick {
        /// The layer height.
        height_mm: f64,
        /// How far the part grows.
        part_mm: f64,
    },
}

impl ExtendedField {
    /// The values at which the surfaces of a part lie (Dai 2020, Equation 3.2): the middles of slabs of the given
    /// height, the first of which stands on the plate. The last one is the last whose middle can lie in the part.
    ///
    /// # Errors
    /// [`ContourError`] for a height below a fifth of a cell, or above that of the part along its growth.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::{Cells, surface::{LayerField, extend}};
    /// let cells = Cells::new([1, 1, 4], &[1; 4])?;
    /// let field = extend(&LayerField::new(&cells, vec![0.5, 1.5, 2.5, 3.5], 1.0)?, &cells);
    /// assert_eq!(field.levels(0.8, 1.0)?, [0.625, 1.875, 3.125]); // in layers of a cell, here 0.8 mm
    /// assert!(field.levels(0.8, 0.1).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn levels(&self, cell_mm: f64, height_mm: f64) -> Result<Vec<f64>, ContourError> {
        check_cell(cell_mm, Point3::origin())?;
        if height_mm.is_nan() || height_mm < LEAST_HEIGHT * cell_mm {
            return Err(ContourError::TooThin { height_mm, cell_mm });
        }
        // From the centre of the highest cell half a cell is left to its skin.
        let top = self.highest() + 0.5 / self.layer_cells();
        let part_mm = top * self.layer_cells() * cell_mm;
        if height_mm > part_mm * (1.0 + 1e-9) {
            return Err(ContourError::TooThick { height_mm, part_mm });
        }
        let step = height_mm / (self.layer_cells() * cell_mm);
        let count = (top / step + 0.5).floor() as usize;
        Ok((0..count).map(|i| (i as f64 + 0.5) * step).filter(|&level| level < top).collect())
    }
}

fn check_cell(cell_mm: f64, origin: Point3<f64>) -> Result<(), ContourError> {
    let sound = cell_mm > 0.0 && cell_mm.is_finite() && origin.iter().all(|c| c.is_finite());
    if sound { Ok(()) } else { Err(ContourError::Placement { cell_mm, origin: origin.into() }) }
}

/// The surfaces of `field` at `levels`.
///
/// # Arguments
/// * `levels`: values in layers, as [`ExtendedField::levels`] gives them; in any order.
/// * `cell_mm`, `origin`: the edge of a cell and the low corner of the grid, in millimetres.
///
/// # Returns
/// A surface for each level, in the order of the levels; some may be empty. Each is a 2-manifold with boundary, its
/// normals point along the growth, and no height of a triangle is less than a thousandth of a cell.
///
/// # Errors
/// [`ContourError::Placement`].
///
/// # Cost
/// `O(n)` for `n` cells, and less than a microsecond for each triangle. With the feature `rayon` the levels are
/// shared out among threads; the result is the same.
///
/// # Example
/// ```
/// use curvlay_layers::curved::{Cells, surface::{LayerField, contour, extend}};
/// let cells = Cells::new([1, 1, 2], &[1, 1])?;
/// let field = extend(&LayerField::new(&cells, vec![0.5, 1.5], 1.0)?, &cells);
/// let surfaces = contour(&field, &[1.0], 2.0, [0.0, 0.0, 0.0].into())?;
/// assert!(surfaces[0].points.iter().all(|p| (p.z - 2.0).abs() < 1e-12));
/// assert_eq!(surfaces[0].triangles.len(), 2 * 5 * 5); // the cell, and two rings around it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contour(
    field: &ExtendedField,
    levels: &[f64],
    cell_mm: f64,
    origin: Point3<f64>,
) -> Result<Vec<Surface>, ContourError> {
    check_cell(cell_mm, origin)?;
    let crossings = crossings(field, levels);
    let low = origin - Vector3::repeat((f64::from(super::lattice::ROOM) - 0.5) * cell_mm);
    let one = |(level, edges): (&f64, &Vec<u32>)| Contour::new(field, *level).run(edges, cell_mm, low);
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        Ok(levels.par_iter().zip(&crossings).map(one).collect())
    }
    #[cfg(not(feature = "rayon"))]
    Ok(levels.iter().zip(&crossings).map(one).collect())
}

/// For each level the edges that it crosses, `4 * node + axis`, rising.
fn crossings(field: &ExtendedField, levels: &[f64]) -> Vec<Vec<u32>> {
    let lattice = &field.lattice;
    let mut rising: Vec<(f64, usize)> = levels.iter().copied().zip(0..).filter(|(level, _)| !level.is_nan()).collect();
    rising.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut crossings = vec![Vec::new(); levels.len()];
    for (node, &joined) in lattice.joined.iter().enumerate() {
        for (axis, stride) in lattice.strides().into_iter().enumerate() {
            let Some(&high) = lattice.values.get(node + stride) else { continue };
            let is_joined = joined >> axis & 1 == 1;
            let is_cut = (lattice.values[node] - high).abs() >= JUMP; // false for what is not a number
            if !is_joined && !is_cut {
                continue;
            }
            let [a, b] = [lattice.values[node], high].map(|v| v + REACHED);
            let first = rising.partition_point(|&(level, _)| level <= a.min(b));
            for (level, of) in &rising[first..] {
                if *level > a.max(b) {
                    break;
                }
                if is_joined || lattice.is_open(node, axis, *level) {
                    crossings[*of].push(4 * node as u32 + axis as u32);
                }
            }
        }
    }
    crossings
}

/// A surface in the making.
struct Contour<'a> {
    field: &'a ExtendedField,
    level: f64,
    strides: [usize; 3],
    points: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// Vertices on faces between cubes: by the lower cube, the axis across, and the lower edge of the line.
    on_faces: BTreeMap<(usize, usize, usize), u32>,
}

/// A cube that the surface passes.
#[derive(Clone, Copy)]
struct Cube {
    low_node: usize,
    above: u8,
    joined: u16,
    pieces: Pieces,
    /// Number of the vertex of its first piece.
    first: u32,
}

impl<'a> Contour<'a> {
    fn new(field: &'a ExtendedField, level: f64) -> Self {
        let strides = field.lattice.strides();
        Contour { field, level, strides, points: Vec::new(), triangles: Vec::new(), on_faces: BTreeMap::new() }
    }

    fn run(mut self, edges: &[u32], cell_mm: f64, low: Point3<f64>) -> Surface {
        let strides = self.strides;
        let around = |edge: u32| {
            let (node, axis) = ((edge / 4) as usize, (edge % 4) as usize);
            let [b, c] = after(axis).map(|axis| strides[axis]);
            [node, node - b, node - c, node - b - c]
        };
        let mut nodes: Vec<usize> = edges.iter().flat_map(|&edge| around(edge)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut cubes = Vec::with_capacity(nodes.len());
        for &node in &nodes {
            let cube = self.cube(node);
            cubes.push(cube);
        }
        for &edge in edges {
            let at = around(edge).map(|node| nodes.partition_point(|&other| other < node));
            self.quadrangle(edge, at.map(|at| &cubes[at]));
        }
        let points = self.points.iter().map(|p| low + p * cell_mm).collect();
        Surface { value: self.level, points, triangles: self.triangles }
    }

    fn is_above(&self, node: usize) -> bool {
        self.field.lattice.values[node] + REACHED >= self.level
    }

    fn corner(&self, low_node: usize, corner: usize) -> usize {
        (0..3).filter(|k| corner >> k & 1 == 1).map(|k| self.strides[k]).sum::<usize>() + low_node
    }

    /// The cube with its pieces; their vertices are added to the points.
    fn cube(&mut self, low_node: usize) -> Cube {
        let lattice = &self.field.lattice;
        let corners: [usize; 8] = std::array::from_fn(|corner| self.corner(low_node, corner));
        let above = (0..8).fold(0, |bits, k| bits | u8::from(self.is_above(corners[k])) << k);
        let joined = (0..12).fold(0u16, |bits, edge| {
            let low = corners[LOW_CORNER[edge]];
            let open = lattice.is_joined(low, edge / 4, true) || lattice.is_open(low, edge / 4, self.level);
            bits | u16::from(open) << edge
        });
        let pieces = Pieces::new(above, joined);
        let cube = Cube { low_node, above, joined, pieces, first: self.points.len() as u32 };
        for piece in 0..pieces.count {
            let vertex = self.vertex(&cube, &corners, piece);
            self.points.push(vertex);
        }
        cube
    }

    /// How far along its edge, from the lower end, the surface crosses.
    fn crossing(&self, low: usize, axis: usize) -> f64 {
        let lattice = &self.field.lattice;
        let [a, b] = [low, low + self.strides[axis]].map(|node| lattice.values[node]);
        if (a - b).abs() < JUMP {
            return ((self.level - a) / (b - a)).clamp(0.0, 1.0);
        }
        // A cut: the surface belongs to the end whose slope leads to it.
        let [from_low, from_high] = lattice.half_steps(low, axis);
        let along = [(self.level - a) / from_low / 2.0, 1.0 - (b - self.level) / from_high / 2.0];
        match along.map(|t| (0.0..=1.0).contains(&t)) {
            [true, _] => along[0].min(0.5),
            [_, true] => along[1].max(0.5),
            _ => 0.5,
        }
    }

    /// Where the vertex of a piece lies, in cells from the first node of the lattice.
    fn vertex(&self, cube: &Cube, corners: &[usize; 8], piece: u8) -> Vector3<f64> {
        let (mut mean, mut count) = (Vector3::zeros(), 0.0);
        let mut crossed = [false; 8];
        for edge in (0..12).filter(|&edge| cube.pieces.of[edge] == piece) {
            let (low, axis) = (LOW_CORNER[edge], edge / 4);
            let high = low | 1 << axis;
            let mut at = Vector3::from([0, 1, 2].map(|k| (low >> k & 1) as f64));
            at[axis] = self.crossing(corners[low], axis);
            mean += at;
            count += 1.0;
            crossed[low] = true;
            crossed[high] = true;
        }
        mean /= count;
        // What the piece belongs to: all corners that joined edges lead to.
        let mut own = crossed;
        loop {
            let before = own;
            for edge in (0..12).filter(|edge| cube.joined >> edge & 1 == 1) {
                let (low, high) = (LOW_CORNER[edge], LOW_CORNER[edge] | 1 << (edge / 4));
                own[low] |= own[high];
                own[high] |= own[low];
            }
            if own == before {
                break;
            }
        }
        if own != [true; 8] {
            mean = self.moved_to_middle(mean, &own, corners);
        }
        let place = self.field.lattice.position(cube.low_node).map(f64::from);
        Vector3::from(place) + mean.map(|c| c.clamp(MARGIN, 1.0 - MARGIN))
    }

    /// Moves the vertex to the middle of the cube along the axes on which only one side is there, and then back to
    /// the level along the slope.
    fn moved_to_middle(&self, at: Vector3<f64>, own: &[bool; 8], corners: &[usize; 8]) -> Vector3<f64> {
        let mut target = at;
        for axis in 0..3 {
            let has = |side: usize| (0..8).any(|k| own[k] && k >> axis & 1 == side);
            if !(has(0) && has(1)) {
                target[axis] = 0.5;
            }
        }
        let of: Vec<usize> = (0..8).filter(|&k| own[k]).map(|k| corners[k]).collect();
        let slope =
            Vector3::from([0, 1, 2].map(|axis| {
                of.iter().map(|&node| self.field.lattice.slope(node, axis)).sum::<f64>() / of.len() as f64
            }));
        if slope.norm_squared() > 0.0 {
            target -= slope * (slope.dot(&(target - at)) / slope.norm_squared());
        }
        target
    }

    /// The quadrangle around a crossed edge; `cubes` without a shift, with one along the next axis, the one after
    /// it, and both.
    fn quadrangle(&mut self, edge: u32, cubes: [&Cube; 4]) {
        let (node, axis) = ((edge / 4) as usize, (edge % 4) as usize);
        // Counter-clockwise seen along the axis; and the face through which the next one is reached.
        let [b, c] = after(axis);
        let mut turns = [(0, b), (1, c), (3, b), (2, c)];
        let upwards = self.is_above(node + self.strides[axis]);
        if !upwards {
            turns = [(0, c), (2, b), (3, c), (1, b)];
        }
        let mut polygon = [0; 8];
        let mut corners = 0;
        for (k, &(at, across)) in turns.iter().enumerate() {
            let cube = cubes[at];
            polygon[corners] = cube.first + u32::from(cube.pieces.of[4 * axis + at]);
            corners += 1;
            if cube.pieces.doubled != 0
                && let Some(vertex) = self.on_face(4 * axis + at, cube, cubes[turns[(k + 1) % 4].0], across)
            {
                polygon[corners] = vertex;
                corners += 1;
            }
        }
        match polygon[..corners] {
            [a, b, c, d] => self.split([a, b, c, d]),
            _ => self.fan(node, axis, &polygon[..corners]),
        }
    }

    /// The vertex on the face between two cubes, if two lines across it join the same two vertices.
    fn on_face(&mut self, edge: usize, cube: &Cube, next: &Cube, across: usize) -> Option<u32> {
        let side = LOW_CORNER[edge] >> across & 1;
        let face = 2 * across + side;
        if cube.pieces.doubled >> face & 1 == 0 || next.pieces.doubled >> (face ^ 1) & 1 == 0 {
            return None;
        }
        let other = partner(face, edge, cube.above, cube.joined);
        let middle = |edge: usize| {
            let (low, axis) = (LOW_CORNER[edge], edge / 4);
            let node = self.corner(cube.low_node, low);
            let mut at = Vector3::from(self.field.lattice.position(node).map(f64::from));
            at[axis] += self.crossing(node, axis).clamp(MARGIN, 1.0 - MARGIN);
            at
        };
        // A line that ends at a cut goes as far as the middle of the face.
        let end = other.map_or_else(
            || {
                let mut centre =
                    Vector3::from(self.field.lattice.position(cube.low_node).map(f64::from)).add_scalar(0.5);
                centre[across] += if side == 1 { 0.5 } else { -0.5 };
                centre
            },
            middle,
        );
        let place = (middle(edge) + end) / 2.0;
        // The line by the lower of its edges, told by its first node: the same from both cubes.
        let key = |edge: usize| self.corner(cube.low_node, LOW_CORNER[edge]) * 4 + edge / 4;
        let key =
            (cube.low_node.max(next.low_node), across, other.map_or(key(edge), |other| key(edge).min(key(other))));
        let new = self.points.len() as u32;
        let vertex = *self.on_faces.entry(key).or_insert(new);
        if vertex == new {
            self.points.push(place);
        }
        Some(vertex)
    }

    /// Cuts a quadrangle along the diagonal that leaves the greater least height.
    fn split(&mut self, [a, b, c, d]: [u32; 4]) {
        let least = |triangles: [[u32; 3]; 2]| {
            triangles
                .map(|t| least_height(t.map(|v| &self.points[v as usize])))
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        };
        let (one, other) = ([[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]);
        self.triangles.extend(if least(one) >= least(other) { one } else { other });
    }

    /// Triangles from the crossing itself to all sides of the polygon.
    fn fan(&mut self, node: usize, axis: usize, polygon: &[u32]) {
        let mut centre = Vector3::from(self.field.lattice.position(node).map(f64::from));
        centre[axis] += self.crossing(node, axis).clamp(MARGIN, 1.0 - MARGIN);
        let middle = self.points.len() as u32;
        self.points.push(centre);
        let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
        self.triangles.extend(sides.map(|(&from, &to)| [middle, from, to]));
    }
}

/// The square of the least height of a triangle.
fn least_height([a, b, c]: [&Vector3<f64>; 3]) -> f64 {
    let sides = [b - a, c - b, a - c];
    let longest = sides.iter().map(Vector3::norm_squared).fold(0.0, f64::max);
    sides[0].cross(&sides[1]).norm_squared() / longest
}
