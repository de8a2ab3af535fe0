//! Marching tetrahedra: a closed mesh around the points where a function is below zero; and its relaxation.
//!
//! Each cube of a lattice is cut into the six tetrahedra that go from its low to its high corner along the axes, one
//! order of the axes each (Kuhn's cut). Cubes side by side cut their common face alike, and a vertex belongs to one
//! edge of the lattice, so the mesh is a manifold whatever the function.
//!
//! Lattice points are numbered `x + nx * (y + ny * z)`; an edge goes up along one to three axes at once, and bit `i`
//! of its direction says that it goes up along axis `i`.

use nalgebra::{Point3, Vector3};

/// The orders of the axes: from the low corner up along the first axis, then the second, then the third. The first
/// three turn right-handed, the others left-handed.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// A vertex keeps this share of its edge away from both ends: triangles of no area cannot arise where the surface
/// runs through a lattice point. The surface moves by as little.
const MARGIN: f64 = 0.02;

/// Halvings of an edge before the surface is taken for flat: to 1/256 of a cell.
const HALVINGS: usize = 8;

/// Most points of the lattice: each takes some 30 bytes.
const MAX_POINTS: usize = 1 << 26;

/// The surface of an implicit function: a closed, oriented manifold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImplicitMesh {
    /// Corners in millimetres.
    pub vertices: Vec<Point3<f64>>,
    /// Three of them each, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a function does not become a mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolygoniseError {
    /// A corner of the box is not finite.
    #[error("an invalid box from {low:?} to {high:?}: the corners must be finite")]
    Bounds {
        /// Low corner.
        low: [f64; 3],
        /// High corner.
        high: [f64; 3],
    },
    /// The edge of a cell is not a positive finite number.
    #[error("cells of {cell_mm} mm: the edge must be positive and finite")]
    CellSize {
        /// The edge that was asked for.
        cell_mm: f64,
    },
    /// The lattice is too large.
    #[error("a lattice of {dims:?} points: at most 2^26 are allowed, so take larger cells")]
    TooFine {
        /// Points along x, y and z; cut off at `u64::MAX`.
        dims: [u64; 3],
    },
}

/// The surface of the solid `value < 0` between `low` and `high`, on a lattice of edge `cell_mm`.
///
/// # Arguments
/// * `value`: below zero inside; what is not a number counts as outside.
/// * `low`, `high`: corners of a box in millimetres. What reaches its border is cut off there.
///
/// # Returns
/// A watertight manifold, faces outwards. Empty without an inside. Where `value` is linear the vertices are exact up to rounding.
///
/// # Errors
/// [`PolygoniseError`] for an invalid box or cell, and for a lattice of more than 2^26 points, before it is allocated.
///
/// # Cost
/// One evaluation a lattice point, and ten a vertex. Deterministic, on one thread.
///
/// # Example
/// ```
/// use curvlay_voxel::{nalgebra::Point3, polygonise};
/// let [low, high] = [-1.5, 1.5].map(|c| Point3::new(c, c, c));
/// let ball = polygonise(|p| p.coords.norm() - 1.0, low, high, 0.25)?;
/// assert!(ball.vertices.iter().all(|v| (v.coords.norm() - 1.0).abs() < 0.02));
/// # Ok::<(), curvlay_voxel::PolygoniseError>(())
/// ```
pub fn polygonise(
    value: impl Fn(Point3<f64>) -> f64,
    low: Point3<f64>,
    high: Point3<f64>,
    cell_mm: f64,
) -> Result<ImplicitMesh, PolygoniseError> {
    if !low.iter().chain(high.iter()).all(|c| c.is_finite()) {
        return Err(PolygoniseError::Bounds { low: low.into(), high: high.into() });
    }
    if !(cell_mm > 0.0 && cell_mm.is_finite()) {
        return Err(PolygoniseError::CellSize { cell_mm });
    }
    let cell = cell_mm;
    let n = [0, 1, 2].map(|axis| (((high[axis] - low[axis]) / cell).ceil().max(0.0) as usize).saturating_add(1));
    let points = n.iter().try_fold(1_usize, |all, &side| all.checked_mul(side));
    if points.is_none_or(|points| points > MAX_POINTS) {
        return Err(PolygoniseError::TooFine { dims: n.map(|side| side as u64) });
    }
    let place = |at: [usize; 3]| low + Vector3::new(at[0] as f64, at[1] as f64, at[2] as f64) * cell;
    let number = |at: [usize; 3]| at[0] + n[0] * (at[1] + n[1] * at[2]);

    // Points on the border of the lattice count as outside, so the surface closes there.
    let border = |at: [usize; 3]| (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == n[axis]);
    let mut inside = Vec::with_capacity(n.iter().product());
    for_each([0; 3], n, |at| inside.push(!border(at) && value(place(at)) < 0.0));

    let mut mesh = ImplicitMesh::default();
    let mut vertex_on = vec![u32::MAX; inside.len() * 7];
    let mut vertex = |within: [usize; 3], beyond: [usize; 3], vertices: &mut Vec<Point3<f64>>| -> u32 {
        let edge = (0..3).filter(|&axis| within[axis] != beyond[axis]).map(|axis| 1 << axis).sum::<usize>();
        let slot = number(within).min(number(beyond)) * 7 + edge - 1;
        if vertex_on[slot] == u32::MAX {
            vertex_on[slot] = vertices.len() as u32;
            vertices.push(crossing(&value, place(within), place(beyond)));
        }
        vertex_on[slot]
    };
    for_each([0; 3], n.map(|side| side.saturating_sub(1)), |[x, y, z]| {
        let corner = |bits: usize| [x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2 & 1)];
        let first = inside[number(corner(0))];
        if (1..8).all(|bits| inside[number(corner(bits))] == first) {
            return;
        }
        for (k, [low_axis, next_axis, _]) in ORDERS.into_iter().enumerate() {
            let mut tetra = [corner(0), corner(1 << low_axis), corner(1 << low_axis | 1 << next_axis), corner(7)];
            if k >= 3 {
                tetra.swap(1, 2);
            }
            let edges = cut(tetra.map(|at| inside[number(at)]));
            let polygon: Vec<u32> =
                edges.iter().map(|&[a, b]| vertex(tetra[a], tetra[b], &mut mesh.vertices)).collect();
            for i in 2..polygon.len() {
                mesh.triangles.push([polygon[0], polygon[i - 1], polygon[i]]);
            }
        }
    });
    Ok(mesh)
}

/// Calls `visit` for all lattice points from `low` to below `high`, x fastest.
fn for_each(low: [usize; 3], high: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    for z in low[2]..high[2] {
        for y in low[1]..high[1] {
            for x in low[0]..high[0] {
                visit([x, y, z]);
            }
        }
    }
}

/// Where the surface runs through the edge from `within` to `beyond`.
fn crossing(value: &impl Fn(Point3<f64>) -> f64, within: Point3<f64>, beyond: Point3<f64>) -> Point3<f64> {
    let at = |t: f64| within + (beyond - within) * t;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if value(at(middle)) < 0.0 { low = middle } else { high = middle }
    }
    let (below, above) = (value(at(low)), value(at(high)));
    let t = if below < 0.0 && above > 0.0 { low + (high - low) * below / (below - above) } else { high };
    at(t.clamp(MARGIN, 1.0 - MARGIN))
}

/// The edges (inner corner first) that the surface crosses in a right-handed tetrahedron of which these corners are
/// inside; in the order that turns the polygon outwards.
fn cut(inside: [bool; 4]) -> Vec<[usize; 2]> {
    /// Even orders of the corners, a single one or a pair in front.
    const SINGLE: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]];
    const PAIR: [[usize; 4]; 6] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];
    for [a, b, c, d] in SINGLE {
        match [a, b, c, d].map(|corner| inside[corner]) {
            [true, false, false, false] => return vec![[a, b], [a, c], [a, d]],
            [false, true, true, true] => return vec![[b, a], [d, a], [c, a]],
            _ => {}
        }
    }
    for [a, b, c, d] in PAIR {
        if [a, b, c, d].map(|corner| inside[corner]) == [true, true, false, false] {
            return vec![[a, c], [a, d], [b, d], [b, c]];
        }
    }
    Vec::new()
}

impl ImplicitMesh {
    /// Evens out the triangles of a mesh of the surface `value = 0`: in each round every vertex goes to the mean of its
    /// neighbours, all at once, and from there back to the surface. Meant for surfaces that are smooth on the scale of a
    /// triangle; the triangles themselves stay as they are.
    ///
    /// # Panics
    /// If a triangle has a corner that is no vertex of the mesh.
    pub fn relax(&mut self, value: impl Fn(Point3<f64>) -> f64, rounds: usize) {
        let mut edge = 0.0_f64;
        for &[a, b, _] in &self.triangles {
            edge = edge.max((self.vertices[a as usize] - self.vertices[b as usize]).norm());
        }
        for _ in 0..rounds {
            let mut sums = vec![(Vector3::zeros(), 0.0); self.vertices.len()];
            for &[a, b, c] in &self.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let (sum, count) = &mut sums[from as usize];
                    *sum += self.vertices[to as usize].coords;
                    *count += 1.0;
                }
            }
            for (vertex, (sum, count)) in self.vertices.iter_mut().zip(sums) {
                if count > 0.0 {
                    *vertex = onto_surface(&value, Point3::from(sum / count), edge);
                }
            }
        }
    }
}

/// Newton steps along the gradient, none longer than `reach`.
fn onto_surface(value: &impl Fn(Point3<f64>) -> f64, mut p: Point3<f64>, reach: f64) -> Point3<f64> {
    const STEPS: usize = 2;
    // The step of the differences: far above rounding, far below a triangle.
    let h = 1e-4 * reach;
    for _ in 0..STEPS {
        let slope = |axis: Vector3<f64>| (value(p + axis * h) - value(p - axis * h)) / (2.0 * h);
        let gradient = Vector3::new(slope(Vector3::x()), slope(Vector3::y()), slope(Vector3::z()));
        let steepness = gradient.norm_squared();
        if steepness > 0.0 {
            let step = gradient * (value(p) / steepness);
            p -= step * (reach / step.norm().max(reach));
        }
    }
    p
}
