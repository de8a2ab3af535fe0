//! Stresses on a layer, from samples around it.
//!
//! Stresses at the vertices of a layer are interpolated from the nearest samples by moving least squares of first degree (Lancaster and Salkauskas,
//! Math. Comp. 37(155), 1981): exact for stresses that are linear in space. A fibre lies in the layer, so what counts is the part of the stress in the
//! tangent plane: a symmetric matrix of two by two, whose principal direction of the largest magnitude is that of the fibre.

use super::near::vertex_normals;
pub use super::sample::StressSample;
use super::samples::SampleGrid;
use crate::mesh::SurfaceMesh;
use nalgebra::{Matrix3, Matrix4, Point3, Vector3, Vector4};

/// How stresses come onto a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct StressOptions {
    /// How far the nearest sample may be from a vertex of the layer, in millimetres: 10.
    pub reach: f64,
}

impl Default for StressOptions {
    fn default() -> Self {
        StressOptions { reach: 10.0 }
    }
}

/// Why there are no stresses on a layer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StressError {
    /// There is no sample.
    #[error("there is no stress sample")]
    NoSamples,
    /// A coordinate or a component is NaN, infinite or absurd.
    #[error("stress sample {sample} has a number that is not finite or beyond 1e100")]
    BadSample {
        /// Number of the sample.
        sample: usize,
    },
    /// A tensor is not symmetric.
    #[error("the stress tensor of sample {sample} is not symmetric")]
    NotSymmetric {
        /// Number of the sample.
        sample: usize,
    },
    /// No sample is near.
    #[error(
        "vertex {vertex} of the layer is farther than {reach} mm from all stress samples: are units and positions those of the layer?"
    )]
    FarFromLayer {
        /// The vertex.
        vertex: usize,
        /// How far a sample may be.
        reach: f64,
    },
    /// The reach is not a length.
    #[error("a reach of {reach} mm: it must be a length above zero")]
    Reach {
        /// What was given.
        reach: f64,
    },
}

/// Principal stresses in the tangent plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// Unit direction of the principal stress of the largest magnitude; its sign means nothing.
    pub direction: Vector3<f64>,
    /// That stress.
    pub largest: f64,
    /// The other one.
    pub other: f64,
}

impl Principal {
    /// By how much the largest magnitude exceeds the other one. Where it is zero there is no direction.
    pub fn distinctness(&self) -> f64 {
        self.largest.abs() - self.other.abs()
    }
}

/// Stresses at the vertices of a layer.
#[derive(Clone, Debug)]
pub struct LayerStress<'m> {
    mesh: &'m SurfaceMesh,
    tensors: Vec<Matrix3<f64>>,
    principal: Vec<Principal>,
}

/// A tensor may differ from its transpose by this share of its largest entry: what files of seven digits round.
pub(super) const SYMMETRY: f64 = 1e-5;

/// Numbers beyond this are refused: their squares must stay finite.
const MAX_NUMBER: f64 = 1e100;

impl<'m> LayerStress<'m> {
    /// Interpolates stresses at the vertices of a layer.
    ///
    /// # Errors
    /// [`StressError`].
    ///
    /// # Cost
    /// `O(n log n)` or so for `n` vertices and samples, as long as samples are spread evenly.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Matrix3, Point3, Vector3};
    /// use curvlay_toolpath::fiber::stress::{LayerStress, StressOptions, StressSample};
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    /// let pull = Matrix3::from_diagonal(&Vector3::new(1.0, -5.0, 9.0));
    /// let samples = corners.map(|point| StressSample { point, stress: pull });
    /// let stress = LayerStress::new(&mesh, &samples, StressOptions::default())?;
    /// // The greatest stress in the layer is along y; that along z is not in the layer.
    /// assert!((stress.principal()[0].direction.y.abs() - 1.0).abs() < 1e-9);
    /// assert!((stress.principal()[0].largest + 5.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(mesh: &'m SurfaceMesh, samples: &[StressSample], options: StressOptions) -> Result<Self, StressError> {
        let reach = options.reach;
        if !(reach > 0.0 && reach <= MAX_NUMBER) {
            return Err(StressError::Reach { reach });
        }
        if samples.is_empty() {
            return Err(StressError::NoSamples);
        }
        for (sample, StressSample { point, stress }) in samples.iter().enumerate() {
            if !point.iter().chain(stress.iter()).all(|number| number.abs() <= MAX_NUMBER) {
                return Err(StressError::BadSample { sample });
            }
            if (stress - stress.transpose()).amax() > SYMMETRY * stress.amax() {
                return Err(StressError::NotSymmetric { sample });
            }
        }
        let grid = SampleGrid::new(samples);
        let normals = vertex_normals(mesh);
        let mut near = Vec::new();
        let (mut tensors, mut principal) = (Vec::with_capacity(normals.len()), Vec::with_capacity(normals.len()));
        for (vertex, (p, normal)) in mesh.vertices().iter().zip(&normals).enumerate() {
            if *normal == Vector3::zeros() {
                tensors.push(Matrix3::zeros());
                principal.push(Principal { direction: Vector3::zeros(), largest: 0.0, other: 0.0 });
                continue;
            }
            grid.nearest(*p, reach, &mut near);
            if near.is_empty() {
                return Err(StressError::FarFromLayer { vertex, reach });
            }
            let tensor = interpolate(samples, &near, *p);
            principal.push(in_plane(&tensor, normal));
            tensors.push(tensor);
        }
        Ok(LayerStress { mesh, tensors, principal })
    }

    /// The layer.
    pub fn mesh(&self) -> &'m SurfaceMesh {
        self.mesh
    }

    /// The stress at each vertex; zero at a vertex that no triangle has.
    pub fn tensors(&self) -> &[Matrix3<f64>] {
        &self.tensors
    }

    /// The principal stresses in the tangent plane at each vertex.
    pub fn principal(&self) -> &[Principal] {
        &self.principal
    }

    /// The principal stresses at a point of a triangle, of the tensor between those of the corners.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn at(&self, triangle: u32, barycentric: [f64; 3]) -> Principal {
        let corners = self.mesh.triangles()[triangle as usize];
        let parts = corners.iter().zip(barycentric).map(|(&v, weight)| self.tensors[v as usize] * weight);
        in_plane(&parts.sum(), &super::near::cross(self.mesh, triangle).normalize())
    }
}

/// Principal stresses in the plane across a unit normal.
pub(super) fn in_plane(tensor: &Matrix3<f64>, normal: &Vector3<f64>) -> Principal {
    let [x, y] = super::frame::axes(normal);
    let (xx, yy) = (x.dot(&(tensor * x)), y.dot(&(tensor * y)));
    let xy = 0.5 * (x.dot(&(tensor * y)) + y.dot(&(tensor * x)));
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half.hypot(xy);
    // The direction of the greater one (by sign); the other one is across.
    let angle = 0.5 * xy.atan2(half);
    let (angle, radius) = if middle >= 0.0 { (angle, radius) } else { (angle + std::f64::consts::FRAC_PI_2, -radius) };
    Principal { direction: x * angle.cos() + y * angle.sin(), largest: middle + radius, other: middle - radius }
}

/// Slopes are held back by this share of the squared distance to the nearest samples: samples in a plane say nothing across it.
const RIDGE: f64 = 1e-9;

/// The value at `p` of the linear function that fits the nearest samples best, nearer ones more.
fn interpolate(samples: &[StressSample], near: &[(f64, u32)], p: Point3<f64>) -> Matrix3<f64> {
    // Weights fall to zero at the farthest, so that none comes or goes with a jump.
    let farthest = near.last().map_or(0.0, |last| last.0).sqrt() * 1.001;
    let closest = near[0].0.sqrt();
    if closest <= 1e-12 * farthest || farthest <= 0.0 || near.len() == 1 {
        return samples[near[0].1 as usize].stress;
    }
    let (mut normal, mut right) = (Matrix4::zeros(), [Vector4::zeros(); 6]);
    let mut total = 0.0;
    for &(square, sample) in near {
        let distance = square.sqrt();
        let weight = ((farthest - distance) / distance).powi(2);
        let offset = (samples[sample as usize].point - p) / farthest;
        let row = Vector4::new(1.0, offset.x, offset.y, offset.z);
        normal += row * row.transpose() * weight;
        total += weight;
        for (right, (i, j)) in right.iter_mut().zip(SIX) {
            *right += row * (samples[sample as usize].stress[(i, j)] * weight);
        }
    }
    (1..4).for_each(|k| normal[(k, k)] += RIDGE * total);
    let Some(factors) = normal.cholesky() else { return samples[near[0].1 as usize].stress };
    let mut tensor = Matrix3::zeros();
    for (right, (i, j)) in right.iter().zip(SIX) {
        let value = factors.solve(right)[0];
        (tensor[(i, j)], tensor[(j, i)]) = (value, value);
    }
    tensor
}

/// The entries of a symmetric tensor in the order of files: xx, yy, zz, xy, yz, zx.
pub(super) const SIX: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
