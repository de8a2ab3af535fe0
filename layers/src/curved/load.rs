//! Layers that follow the load: a field that governs the growth, and how well layers do.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 6.2.3, names it as future work: beads are strong along
//! themselves and weak across, so layers should hold the direction of the largest stress. The field is found as in G. Fang, T. Zhang, S. Zhong,
//! X. Chen, Z. Zhong, C. C. L. Wang, "Reinforced FDM: multi-axis filament alignment with controlled anisotropic strength", ACM TOG 39(6), 2020,
//! section 4: least squares for its gradient. Its level sets need not be an order that can be built; the growth that it
//! governs sees to that, and it is what limits how near layers come: the level sets of the field itself are within 1.5 to 3.1
//! degrees of the worst stresses on the four parts that we tried; what is built needs a support in an earlier layer and must not lie in the hull of
//! all of them. [`load_angle`] measures what is left (`docs/benchmarks.md`).
//!
//! Symbols: `phi` is the field, `p` the principal direction of the largest stress in a cell, `s` its share in the stress from which on a cell
//! counts as highly stressed, 1 at most, `a` the gradient of the base field, `g` the gradient that is wanted.
//!
//! Departures: the gradient is not free where stresses are low, it is that of a *base* field, the layers of an accepted order. So away from the
//! stresses the field is what the rules of order made of it, and starts on the platform, or on its mould, wherever that is.

use super::SheetField;
use super::surface::{JUMP, LayerField};
use crate::cells::Cells;
use crate::elastic::material::principal_stresses;
use crate::elastic::nodes::{EIGHT, NONE, Points};
use crate::parallel::{fill, map, sum, update};
use crate::{Progress, ProgressFn};
use nalgebra::{Matrix3, Vector3};

/// How much a wanted gradient weighs where the stress is low; where it is high it weighs one more. Less leaves the field adrift there, more
/// keeps the stressed cells from turning it.
const BASE_WEIGHT: f64 = 0.1;

/// Upright is mixed into the base's direction by this much before both are laid across the principal direction: where that one and
/// the base's are the same, layers that hold it are upright or level, and level ones can be built.
const UPRIGHT: f64 = 0.5;

/// Shorter than this nothing is left of a direction across another one.
const NO_DIRECTION: f64 = 1e-6;

/// The share of the residual at which the field is good enough: a few hundredths of a layer are left.
const TOLERANCE: f64 = 1e-4;

/// Iterations after which the field is taken as it is: it is a guide, and is close long before.
const MAX_ITERATIONS: u32 = 400;

/// How much layers follow the load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct FollowOptions {
    /// Share of the cells, the worst stressed, that count fully; the others by their stress. Default 0.1.
    pub stressed_share: f64,
    /// Weight of a gradient along the principal direction, against one of any direction. Default 10.
    pub along: f64,
}

impl Default for FollowOptions {
    fn default() -> Self {
        FollowOptions { stressed_share: 0.1, along: 10.0 }
    }
}

/// Why there is no field that follows the load.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FollowError {
    /// The number of stresses is not that of the cells.
    #[error("{stresses} stresses for {cells} cells")]
    Stresses {
        /// Stresses that were given.
        stresses: usize,
        /// Cells.
        cells: usize,
    },
    /// A stress is not a number, or infinite.
    #[error("the stress of cell {cell} is not finite")]
    NotFinite {
        /// The cell.
        cell: u32,
    },
    /// The field is of another grid.
    #[error("the field has {field} values for a grid of {cells} cells")]
    Field {
        /// Values of the field.
        field: usize,
        /// Cells of the grid, empty ones included.
        cells: usize,
    },
    /// An option is out of range.
    #[error("`{name}` is {value}: it must be finite and above 0{}", if *.name == "stressed_share" { ", 1 at most" } else { "" })]
    Option {
        /// Its name.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// There is no cell, or no stress.
    #[error("no cell is under stress")]
    NoStress,
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// A field whose level sets follow the load.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadField {
    /// By cell number, in layers; not a number where there is no cell.
    pub values: Vec<f64>,
    /// Iterations made.
    pub iterations: u32,
}

impl LoadField {
    /// The field that governs a growth ([`grow`](super::grow)): its sheets are a cell thick where the gradient is 1.
    pub fn sheets(&self) -> SheetField {
        let least = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let sheet = |value: &f64| if value.is_nan() { 0 } else { ((value - least) as u32).saturating_add(1) };
        SheetField::new(self.values.iter().map(sheet).collect())
    }
}

/// Finds a field whose gradient is across the principal direction where stresses are high, and that of `base` elsewhere.
///
/// Minimises over all cells the sum of `(w + s²) |grad phi - g|² + k s² (grad phi . p)²`, with `w` = 0.1 and `k` the option `along`. `g` is `a` where `s` is 0, and
/// where it is 1 the unit vector along `a`, with a little of the upright, less their part along `p`.
///
/// # Arguments
/// * `stresses_mpa`: for each cell, by rising number, xx, yy, zz, xy, yz, zx: [`Elastic::stresses_mpa`](crate::elastic::Elastic::stresses_mpa), or any other in one unit.
/// * `base`: the field of an accepted order of these cells; cells without a value take that of their neighbours.
/// * `progress`: called with the stage `follow` and the iterations; may cancel.
///
/// # Errors
/// [`FollowError`].
///
/// # Cost
/// Up to 400 iterations of some tenths of a microsecond a cell. The same input gives the same field on any number of threads.
///
/// # Example
/// ```
/// use curvlay_layers::curved::surface::{LayerField, plain_field};
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{FollowOptions, load_angle, load_field};
/// use std::ops::ControlFlow::Continue;
/// // A wall of 6 x 1 x 6 cells, built level, under a stress that rises by 45 degrees.
/// let rows = [0b111111; 6];
/// let cells = Cells::new([6, 1, 6], &rows)?;
/// let mut order = LayerOrder::new();
/// (0..6).for_each(|z| order.push(6 * z..6 * z + 6));
/// let level = plain_field(&cells, &order)?;
/// let stresses = [[1.0, 0.0, 1.0, 0.0, 0.0, 1.0]; 36];
/// let field = load_field(&cells, &stresses, &level, &FollowOptions::default(), &|_| Continue(()))?;
/// let least = field.values.iter().copied().fold(0.0, f64::min);
/// let followed = LayerField::new(&cells, field.values.iter().map(|value| value - least).collect(), 1.0)?;
/// let degrees = |field: &LayerField| load_angle(&cells, &stresses, field, 0.1).map(|angle| angle.mean.to_degrees());
/// assert!((degrees(&level)? - 45.0).abs() < 1e-6 && degrees(&followed)? < 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_field(
    cells: &Cells,
    stresses_mpa: &[[f64; 6]],
    base: &LayerField,
    options: &FollowOptions,
    progress: ProgressFn,
) -> Result<LoadField, FollowError> {
    let FollowOptions { stressed_share, along } = *options;
    if !(along > 0.0 && along.is_finite()) {
        return Err(FollowError::Option { name: "along", value: along });
    }
    let stresses = Stresses::new(cells, stresses_mpa, base, stressed_share)?;
    let points = Points::new(cells.dims(), cells.iter().collect());
    let nodes = Points::corners(&points);
    let wanted = |cell: usize| {
        let id = points.ids[cell];
        let a = gradient(cells, base, id).unwrap_or_else(Vector3::zeros);
        let (p, s) = (stresses.directions[cell], stresses.shares[cell]);
        let across = |v: Vector3<f64>| v - p * p.dot(&v);
        let turned = across(a + Vector3::z() * UPRIGHT).try_normalize(NO_DIRECTION).unwrap_or_else(Vector3::zeros);
        let weight = BASE_WEIGHT + s * s;
        Term {
            matrix: Matrix3::identity() * weight + p * p.transpose() * (along * s * s),
            force: (a * (1.0 - s) + turned * s) * weight,
        }
    };
    let terms = map(points.len(), wanted);
    let corners = nodes.of_cells(&points);
    let start = start(&corners, &points, nodes.len(), base);
    let (at_nodes, iterations) = Poisson::new(&points, &nodes, &corners, &terms).solve(start, progress)?;
    let mut values = vec![f64::NAN; cells.grid_len()];
    for (cell, corners) in corners.iter().enumerate() {
        values[points.ids[cell] as usize] = corners.iter().map(|&node| at_nodes[node as usize]).sum::<f64>() / 8.0;
    }
    Ok(LoadField { values, iterations })
}

/// Angles between layers and principal directions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoadAngle {
    /// Mean of the angle between the tangent plane of the layers and the principal direction of the largest stress, in radians.
    pub mean: f64,
    /// Cells it is the mean of.
    pub cells: usize,
}

/// How far the layers of a field are from holding the principal directions: over the `share` of the cells that are worst stressed.
/// Cells where the field has no gradient, at waits on all sides, do not count.
///
/// # Errors
/// [`FollowError`].
///
/// # Cost
/// A sort of all cells.
///
/// # Example
/// As in [`load_field`].
pub fn load_angle(
    cells: &Cells,
    stresses_mpa: &[[f64; 6]],
    field: &LayerField,
    share: f64,
) -> Result<LoadAngle, FollowError> {
    let stresses = Stresses::new(cells, stresses_mpa, field, share)?;
    let worst = cells.iter().enumerate().filter(|&(cell, _)| stresses.shares[cell] >= 1.0);
    let angle = |(cell, id): (usize, u32)| {
        let normal = gradient(cells, field, id)?.try_normalize(NO_DIRECTION)?;
        Some(normal.dot(&stresses.directions[cell]).abs().min(1.0).asin())
    };
    let angles: Vec<f64> = worst.filter_map(angle).collect();
    if angles.is_empty() {
        return Err(FollowError::NoStress);
    }
    Ok(LoadAngle { mean: angles.iter().sum::<f64>() / angles.len() as f64, cells: angles.len() })
}

/// Principal directions, and how much each counts.
struct Stresses {
    directions: Vec<Vector3<f64>>,
    /// 1 for the worst stressed, less for the others.
    shares: Vec<f64>,
}

impl Stresses {
    fn new(cells: &Cells, stresses: &[[f64; 6]], field: &LayerField, share: f64) -> Result<Self, FollowError> {
        let (count, in_grid) = (cells.count(), cells.grid_len());
        if stresses.len() != count {
            return Err(FollowError::Stresses { stresses: stresses.len(), cells: count });
        }
        if field.values().len() != in_grid {
            return Err(FollowError::Field { field: field.values().len(), cells: in_grid });
        }
        if !(share > 0.0 && share <= 1.0) {
            return Err(FollowError::Option { name: "stressed_share", value: share });
        }
        let is_finite = |stress: &[f64; 6]| stress.iter().all(|k| k.is_finite());
        if let Some((cell, _)) = cells.iter().zip(stresses).find(|(_, stress)| !is_finite(stress)) {
            return Err(FollowError::NotFinite { cell });
        }
        let principal = map(count, |cell| principal_stresses(&stresses[cell])[0]);
        let size = |cell: usize| principal[cell].stress_mpa.abs();
        let mut sizes: Vec<f64> = (0..count).map(size).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let worst = ((count as f64 * share).ceil() as usize).min(count);
        match sizes.get(count - worst).copied().or(sizes.last().copied()) {
            Some(high) if high > 0.0 => Ok(Stresses {
                directions: principal.iter().map(|principal| principal.direction).collect(),
                shares: (0..count).map(|cell| (size(cell) / high).min(1.0)).collect(),
            }),
            _ => Err(FollowError::NoStress),
        }
    }
}

/// Which way layers grow at a cell, of length 1: the gradient of the field; `None` where it has none, at waits on all sides, and for a cell that is not there.
///
/// # Example
/// ```
/// use curvlay_layers::curved::surface::plain_field;
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::layer_normal;
/// let rows = [0b11; 4];
/// let cells = Cells::new([2, 2, 2], &rows)?;
/// let mut order = LayerOrder::new();
/// (0..2).for_each(|z| order.push(4 * z..4 * z + 4));
/// let level = plain_field(&cells, &order)?;
/// assert!(layer_normal(&cells, &level, 0).is_some_and(|normal| (normal.z - 1.0).abs() < 1e-12));
/// assert_eq!(layer_normal(&cells, &level, 8), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn layer_normal(cells: &Cells, field: &LayerField, cell: u32) -> Option<Vector3<f64>> {
    let is_there = cell < cells.dims().iter().product() && cells.contains(cells.position(cell));
    if is_there { gradient(cells, field, cell)?.try_normalize(NO_DIRECTION) } else { None }
}

/// The gradient of a field in layers a cell, along each axis where a neighbour has a value and no wait lies between.
fn gradient(cells: &Cells, field: &LayerField, cell: u32) -> Option<Vector3<f64>> {
    let value = field.value(cell)?;
    let place = cells.position(cell);
    let mut any = false;
    let along = [0, 1, 2].map(|axis| {
        let difference = |step: i32| {
            let mut next = place;
            next[axis] = next[axis].wrapping_add_signed(step);
            let next = cells.contains(next).then(|| field.value(cells.id(next)))??;
            let difference = (next - value) * f64::from(step);
            (difference.abs() < JUMP).then_some(difference)
        };
        let known: Vec<f64> = [-1, 1].into_iter().filter_map(difference).collect();
        any |= !known.is_empty();
        known.iter().sum::<f64>() / known.len().max(1) as f64
    });
    any.then(|| Vector3::from(along))
}

/// What a cell asks of the gradient: `grad . matrix grad - 2 force . grad` is to be small.
struct Term {
    matrix: Matrix3<f64>,
    force: Vector3<f64>,
}

/// Where to begin: the base at each node, the mean of the cells around it that have a value.
fn start(corners: &[[u32; 8]], cells: &Points, nodes: usize, base: &LayerField) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); nodes];
    for (cell, corners) in corners.iter().enumerate() {
        if let Some(value) = base.value(cells.ids[cell]) {
            for &node in corners {
                let sum = &mut sums[node as usize];
                *sum = (sum.0 + value, sum.1 + 1.0);
            }
        }
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { 0.0 }).collect()
}

/// The equations for the field at the nodes, trilinear in each cell.
struct Poisson<'a> {
    corners: &'a [[u32; 8]],
    terms: &'a [Term],
    /// The cells around each node, which is corner `7 - k` of cell `k`.
    around: Vec<[u32; 8]>,
    /// Integrals over a cell of the products of the slopes of shape functions `i` and `j` along two axes.
    products: [[Matrix3<f64>; 8]; 8],
    /// Integrals over a cell of the slopes of each shape function.
    slopes: [Vector3<f64>; 8],
}

impl<'a> Poisson<'a> {
    fn new(cells: &Points, nodes: &Points, corners: &'a [[u32; 8]], terms: &'a [Term]) -> Self {
        let around = map(nodes.len(), |node| {
            let place = nodes.place(node);
            EIGHT.map(|k| cells.step(place, [0, 1, 2].map(|axis| (k >> axis & 1) as i32 - 1)))
        });
        let point = 0.5 / 3f64.sqrt();
        let slope = |corner: usize, at: [f64; 3]| {
            let sign = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 });
            let factor = |axis: usize| 0.5 + sign[axis] * at[axis];
            Vector3::from([0, 1, 2].map(|axis| sign[axis] * factor((axis + 1) % 3) * factor((axis + 2) % 3)))
        };
        let mut products = [[Matrix3::zeros(); 8]; 8];
        for k in EIGHT {
            let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { point } else { -point });
            for (i, j) in EIGHT.into_iter().flat_map(|i| EIGHT.map(|j| (i, j))) {
                products[i][j] += slope(i, at) * slope(j, at).transpose() / 8.0;
            }
        }
        Poisson { corners, terms, around, products, slopes: EIGHT.map(|corner| slope(corner, [0.0; 3])) }
    }

    /// The sum of `of(corner, cell)` over the cells around a node, in each of which it is a corner.
    fn over_cells(&self, node: usize, of: impl Fn(usize, usize) -> f64) -> f64 {
        let cells = self.around[node].iter().enumerate().filter(|&(_, &cell)| cell != NONE);
        cells.map(|(k, &cell)| of(7 - k, cell as usize)).sum()
    }

    fn at(&self, node: usize, x: &[f64]) -> f64 {
        self.over_cells(node, |corner, cell| {
            let matrix = &self.terms[cell].matrix;
            let nodes = &self.corners[cell];
            EIGHT.iter().map(|&j| matrix.dot(&self.products[corner][j]) * x[nodes[j] as usize]).sum()
        })
    }

    /// By conjugate gradients with the inverse of the diagonal.
    fn solve(&self, start: Vec<f64>, progress: ProgressFn) -> Result<(Vec<f64>, u32), FollowError> {
        let len = start.len();
        let product = |a: &[f64], b: &[f64]| sum(len, |node| a[node] * b[node]);
        let diagonal = |corner: usize, cell: usize| self.terms[cell].matrix.dot(&self.products[corner][corner]);
        let diagonal = map(len, |node| self.over_cells(node, diagonal));
        let b = map(len, |node| self.over_cells(node, |corner, cell| self.slopes[corner].dot(&self.terms[cell].force)));
        let norm = product(&b, &b).sqrt();
        let mut x = start;
        let mut r = map(len, |node| b[node] - self.at(node, &x));
        let mut p = vec![0.0; len];
        let mut moved = vec![0.0; len];
        let mut before: Option<f64> = None;
        let mut iterations = 0;
        while iterations < MAX_ITERATIONS && product(&r, &r).sqrt() > TOLERANCE * norm {
            let (done, total) = (u64::from(iterations), u64::from(MAX_ITERATIONS));
            if progress(Progress { stage: "follow", done, total }).is_break() {
                return Err(FollowError::Cancelled);
            }
            let now = sum(len, |node| r[node] * r[node] / diagonal[node]);
            let share = before.map_or(0.0, |before| now / before);
            update(&mut p, |node, p| *p = r[node] / diagonal[node] + share * *p);
            fill(&mut moved, |node| self.at(node, &p));
            let length = now / product(&p, &moved);
            update(&mut x, |node, x| *x += length * p[node]);
            update(&mut r, |node, r| *r -= length * moved[node]);
            before = Some(now);
            iterations += 1;
        }
        Ok((x, iterations))
    }
}
