//! Stripes of even spacing along a field of directions.
//!
//! Knöppel, Crane, Pinkall, Schröder, "Stripe patterns on surfaces", ACM TOG 34(4), 2015. Over each edge the phase should grow by the length of the
//! edge across the stripes; where that does not close around a triangle, stripes end. Instead of phases the paper looks for complex numbers
//! `psi`, one a vertex, of least `sum w |e^(i omega_ij) psi_i - psi_j|^2` and unit norm: the smallest eigenvector, by inverse power iteration
//! (sections 3 and 4, algorithm 5). A line field has no sign, so a phase has none either: seen from a neighbour whose direction points the other way it is
//! the conjugate one, and the matrix has blocks of two by two numbers.
//!
//! | paper | here |
//! |---|---|
//! | `nu` | `1 / spacing`, in turns a millimetre |
//! | `X` | across the stripes, in the tangent plane |
//! | `omega_ij` | `Edge::growth`, in radians, as seen from the tail |
//! | `s_ij = sgn <X_i, X_j>` | `Edge::flips` |
//! | `sigma_ij` (eq. 9), `n` | `EdgeValue`, and its increment around a triangle |
//!
//! Departures. The smallest eigenvector may be large in one part of the layer and close to nothing in another, where its phase is poor. So in each round
//! of the power iteration all numbers are made unit, not their norm: a step of the flow to phases of least energy. Borders along the direction pull the
//! phase to a half, so that a tape's edge, not its middle, lies at a border: a half is a half with either sign. Cotangent weights below zero are raised.

use super::direction::DirectionField;
use super::frame::{edge_weights, rotation};
use super::lines::{CentreLine, EdgeValue, level_lines};
use super::near::vertex_areas;
use crate::mesh::SurfaceMesh;
use crate::sparse::{Entries, Factors};
use crate::{Progress, ProgressFn};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::TAU;

/// Why there are no stripes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StripeError {
    /// The spacing is not a length.
    #[error("a spacing of {spacing} mm: it must be a length above zero")]
    Spacing {
        /// What was given.
        spacing: f64,
    },
    /// More lines than can be laid: the spacing is a slip of the unit.
    #[error(
        "a spacing of {spacing} mm makes about {crossings} points, above the limit of {most}: are the units right?"
    )]
    TooFine {
        /// The spacing.
        spacing: f64,
        /// Crossings of lines and edges, about.
        crossings: f64,
        /// The limit.
        most: f64,
    },
    /// Rounding makes the equations singular: sizes of triangles differ too much.
    #[error("the equations of the stripes cannot be solved: sizes of triangles differ too much")]
    Unsolvable,
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Lines of even spacing along a field of directions.
#[derive(Clone, Debug)]
pub struct Stripes {
    /// The lines, in the order of their first points on the mesh: open ones, then closed ones.
    pub lines: Vec<CentreLine>,
    /// Triangles in which lines end, because they spread or because directions turn there.
    pub singular_triangles: Vec<u32>,
    /// Rounds of the power iteration.
    pub rounds: u32,
    /// By how much the energy of the phases changed in the last round, as a share of it.
    pub residual: f64,
}

/// Crossings of lines and edges that fit into memory and into 32 bits.
const MAX_CROSSINGS: f64 = 1e8;

/// Rounds of the power iteration: the paper takes 20.
const ROUNDS: u32 = 20;

/// How far phases keep together in a round, in square roots of the area of the layer: all over it.
const REACH: f64 = 10.0;

/// Each vertex holds its phase by this much, however small its triangles are, beside edges that hold each other by about one: a splinter that hangs on
/// nothing would else make the equations singular. A vertex of a layer of a million is held by a hundred times as much.
const MIN_HOLD: f64 = 1e-9;

/// How strongly borders along the direction pull, beside the stripe next to them.
const BORDER_PULL: f64 = 1.0;

/// The pull of a border falls with this power of the cosine between border and direction: to a third at six degrees. Borders that lines cross must
/// not pull: their phase runs.
const PARALLEL: i32 = 200;

struct Edge {
    from: usize,
    to: usize,
    weight: f64,
    growth: f64,
    flips: bool,
}

/// Lays stripes along a field of directions.
///
/// # Arguments
/// * `spacing`: between lines, in millimetres.
/// * `progress`: called between solves; may cancel.
///
/// # Errors
/// [`StripeError`].
///
/// # Cost
/// A sparse factorisation of some `n^1.5` operations for `n` triangles, and `O(n log n)` for each of twenty solves. One thread; the result is
/// the same on every run.
///
/// # Example
/// A plate of 12 mm by 6 mm: two lines along it, a quarter of the width from its borders.
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::direction::DirectionField;
/// use curvlay_toolpath::fiber::stripes::stripes;
/// use curvlay_toolpath::mesh::SurfaceMesh;
/// use std::ops::ControlFlow;
/// let corners = [[0.0, 0.0], [12.0, 0.0], [12.0, 6.0], [0.0, 6.0]].map(|[x, y]| Point3::new(x, y, 0.0));
/// let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
/// let field = DirectionField::from_fn(&mesh, |_| Vector3::x())?;
/// let found = stripes(&field, 3.0, &|_| ControlFlow::Continue(()))?;
/// assert_eq!(found.lines.len(), 2);
/// let y: Vec<f64> = found.lines.iter().map(|line| line.points[0].position.y).collect();
/// assert!((y[0].min(y[1]) - 1.5).abs() < 1e-6 && (y[0].max(y[1]) - 4.5).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn stripes(field: &DirectionField, spacing: f64, progress: ProgressFn) -> Result<Stripes, StripeError> {
    if !(spacing > 0.0 && spacing <= 1e100) {
        return Err(StripeError::Spacing { spacing });
    }
    let mesh = field.mesh();
    let edges = edges(field, spacing);
    let crossings = edges.iter().map(|edge| edge.growth.abs() / TAU).sum::<f64>();
    if crossings > MAX_CROSSINGS || !crossings.is_finite() {
        return Err(StripeError::TooFine { spacing, crossings, most: MAX_CROSSINGS });
    }
    let solver = Solver { mesh, areas: vertex_areas(mesh), edges: &edges, progress };
    let (psi, residual) = solver.solve(field, spacing)?;

    let phases: Vec<f64> = psi.iter().map(turns).collect();
    let mut edge_of = vec![u32::MAX; mesh.half_edges() as usize];
    let lower = (0..mesh.half_edges()).filter(|&h| mesh.edge(h) == h);
    lower.zip(0..).for_each(|(h, edge)| edge_of[h as usize] = edge);
    let value = |h: u32| {
        let edge = &edges[edge_of[h as usize] as usize];
        let (start, end) = (phases[edge.from], if edge.flips { -phases[edge.to] } else { phases[edge.to] });
        let turns = (start + edge.growth / TAU - end).round() as i64;
        EdgeValue { ends: [start, end], turns, flips: edge.flips }
    };
    let singular_triangles = singular(mesh, &value);
    Ok(Stripes { lines: level_lines(mesh, value), singular_triangles, rounds: ROUNDS, residual })
}

/// The phase of a number, in turns; never zero, which has no sign.
fn turns(z: &Vector2<f64>) -> f64 {
    let phase = z.y.atan2(z.x) / TAU;
    if phase == 0.0 { f64::MIN_POSITIVE } else { phase }
}

/// Triangles around which the phase does not come back to itself.
fn singular(mesh: &SurfaceMesh, value: &impl Fn(u32) -> EdgeValue) -> Vec<u32> {
    let around = |triangle: u32| {
        let (mut sum, mut sign) = (0, 1);
        for h in 3 * triangle..3 * triangle + 3 {
            let edge = mesh.edge(h);
            let along = value(edge);
            let increment = if edge == h || along.flips { along.increment() } else { -along.increment() };
            sum += sign * increment;
            sign = if along.flips { -sign } else { sign };
        }
        sum != 0 || sign < 0
    };
    (0..mesh.triangles().len() as u32).filter(|&triangle| around(triangle)).collect()
}

/// How the phase should grow over each edge.
fn edges(field: &DirectionField, spacing: f64) -> Vec<Edge> {
    let mesh = field.mesh();
    let weights = edge_weights(mesh);
    let edge = |h: u32| {
        let [from, to] = [mesh.tail(h), mesh.head(h)].map(|v| v as usize);
        let along = mesh.vertices()[to] - mesh.vertices()[from];
        let length = along.norm();
        // The edge across the stripes at one end, as long as if it lay in the tangent plane.
        let across = |v: usize| {
            let normal = &field.normals()[v];
            let flat = (along - normal * along.dot(normal)).try_normalize(0.0).unwrap_or_default();
            flat.dot(&normal.cross(&field.directions()[v])) * length
        };
        let flips = !field.agrees(from, to);
        let there = if flips { -across(to) } else { across(to) };
        let growth = TAU * 0.5 * (across(from) + there) / spacing;
        Edge { from, to, weight: weights[h as usize], growth, flips }
    };
    (0..mesh.half_edges()).filter(|&h| mesh.edge(h) == h).map(edge).collect()
}

/// A number as a neighbour sees it.
fn seen(edge: &Edge) -> Matrix2<f64> {
    Matrix2::new(1.0, 0.0, 0.0, if edge.flips { -1.0 } else { 1.0 })
}

struct Solver<'a> {
    mesh: &'a SurfaceMesh,
    areas: Vec<f64>,
    edges: &'a [Edge],
    progress: ProgressFn<'a>,
}

impl Solver<'_> {
    /// The matrix of the energy, with `more` a vertex on its diagonal.
    fn factors(&self, more: impl Fn(usize) -> f64) -> Result<Factors, StripeError> {
        let mut entries = Entries::default();
        for v in 0..self.areas.len() {
            let alone = self.mesh.fan(v as u32).next().is_none();
            entries.add_block(v, v, Matrix2::identity() * if alone { 1.0 } else { more(v) });
        }
        for edge in self.edges {
            entries.add_block(edge.from, edge.from, Matrix2::identity() * edge.weight);
            entries.add_block(edge.to, edge.to, Matrix2::identity() * edge.weight);
            entries.add_block(edge.to, edge.from, seen(edge) * rotation(edge.growth) * -edge.weight);
        }
        Factors::new(2 * self.areas.len(), &entries).ok_or(StripeError::Unsolvable)
    }

    fn energy(&self, psi: &[Vector2<f64>]) -> f64 {
        let of = |edge: &Edge| {
            edge.weight * (seen(edge) * rotation(edge.growth) * psi[edge.from] - psi[edge.to]).norm_squared()
        };
        self.edges.iter().map(of).sum()
    }

    /// The numbers, all of them unit, and how much the energy changed in the last round, as a share of it.
    fn solve(&self, field: &DirectionField, spacing: f64) -> Result<(Vec<Vector2<f64>>, f64), StripeError> {
        let tick = |done: u32| {
            let step = Progress { stage: "stripes", done: done.into(), total: ROUNDS.into() };
            if (self.progress)(step).is_break() { Err(StripeError::Cancelled) } else { Ok(()) }
        };
        tick(0)?;
        let pull: Vec<f64> = border_lengths(field).iter().map(|length| BORDER_PULL * length / spacing).collect();
        let hold = (TAU / REACH).powi(2) / self.areas.iter().sum::<f64>();
        let holds: Vec<f64> = self.areas.iter().map(|area| (hold * area).max(MIN_HOLD)).collect();
        let factors = self.factors(|v| holds[v] + pull[v])?;
        // A start without any pattern, the same every time.
        let mut psi: Vec<Vector2<f64>> = (0..self.areas.len()).map(|v| start(v as u64)).collect();
        let (mut energy, mut residual) = (f64::INFINITY, 0.0);
        for done in 0..ROUNDS {
            tick(done)?;
            for (v, z) in psi.iter_mut().enumerate() {
                *z *= holds[v];
                z.x -= pull[v];
            }
            factors.solve_pairs(&mut psi);
            psi.iter_mut().for_each(|z| *z = z.try_normalize(0.0).unwrap_or_else(Vector2::x));
            let before = std::mem::replace(&mut energy, self.energy(&psi));
            residual = if energy > 0.0 { (before - energy).abs() / energy } else { 0.0 };
        }
        Ok((psi, residual))
    }
}

/// Length of the border at each vertex that runs along the direction of the field.
fn border_lengths(field: &DirectionField) -> Vec<f64> {
    let mesh = field.mesh();
    let mut lengths = vec![0.0; mesh.vertices().len()];
    for h in mesh.boundary_half_edges() {
        let [from, to] = [mesh.tail(h), mesh.head(h)].map(|v| v as usize);
        let along: Vector3<f64> = mesh.vertices()[to] - mesh.vertices()[from];
        let length = along.norm();
        for v in [from, to] {
            let cosine = along.dot(&field.directions()[v]) / length;
            lengths[v] += 0.5 * length * cosine.powi(PARALLEL);
        }
    }
    lengths
}

/// A unit number without any pattern (SplitMix64, Steele, Lea, Flood 2014).
fn start(number: u64) -> Vector2<f64> {
    let mut z = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let (sin, cos) = (TAU * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64).sin_cos();
    Vector2::new(cos, sin)
}
