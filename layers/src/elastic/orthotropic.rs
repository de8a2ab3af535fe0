//! Orthotropic materials, and thin plies of one within another.
//!
//! R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., Taylor & Francis 1999, sections 2.3 (stiffness and compliance of orthotropic materials) and 2.8
//! (modulus at an angle to the fibre). A cell that a ply passes through is a laminate of ply and matrix: strains along the plane of the ply are those of both,
//! and so are stresses across it, which gives the stiffness of the cell exactly (G. E. Backus, "Long-wave elastic anisotropy produced by horizontal layering",
//! J. Geophys. Res. 67(11), 1962, for any two materials).
//!
//! Symbols: axis 1 is that of the fibre, 2 lies across it in the plane of the ply, 3 is its normal; `nu12` is the strain along 2 by that along 1 under a stress along 1.
//! Strains and stresses are in the order 11, 22, 33, 12, 23, 31, strains of shear as angles.

use super::material::Material;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// An orthotropic linear-elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Orthotropic {
    /// Young's moduli along 1, 2 and 3 in MPa.
    pub young_mpa: [f64; 3],
    /// Poisson's ratios `nu12`, `nu23` and `nu13`.
    pub poisson: [f64; 3],
    /// Shear moduli in the planes 12, 23 and 31 in MPa.
    pub shear_mpa: [f64; 3],
}

impl Orthotropic {
    /// Isotropic, written so.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::elastic::{Material, Orthotropic};
    /// let material = Orthotropic::isotropic(&Material { young_mpa: 1000.0, poisson: 0.25 });
    /// assert_eq!(material.shear_mpa, [400.0; 3]);
    /// ```
    pub fn isotropic(material: &Material) -> Self {
        let Material { young_mpa, poisson } = *material;
        let shear = young_mpa / (2.0 * (1.0 + poisson));
        Orthotropic { young_mpa: [young_mpa; 3], poisson: [poisson; 3], shear_mpa: [shear; 3] }
    }

    /// A tape of parallel filaments in or on a matrix: along them by the rule of mixtures, in every other way as the matrix. That is so for a tow that is not soaked:
    /// what lies between its filaments bears no more than the matrix does.
    ///
    /// # Arguments
    /// * `fiber_mpa`: modulus of the fibre along itself; `share`: of the tape's volume that is fibre that bears, from 0 to 1.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::elastic::{Material, Orthotropic};
    /// let matrix = Material { young_mpa: 1000.0, poisson: 0.3 };
    /// let tape = Orthotropic::tape(&matrix, 200_000.0, 0.5);
    /// assert_eq!((tape.young_mpa[0], tape.young_mpa[1]), (100_500.0, 1000.0));
    /// ```
    pub fn tape(matrix: &Material, fiber_mpa: f64, share: f64) -> Self {
        let plain = Orthotropic::isotropic(matrix);
        let along = share * fiber_mpa + (1.0 - share) * matrix.young_mpa;
        Orthotropic { young_mpa: [along, matrix.young_mpa, matrix.young_mpa], ..plain }
    }

    /// Strain from stress along the axes of the material.
    fn compliance(&self) -> Matrix6<f64> {
        let Orthotropic { young_mpa: [e1, e2, e3], poisson: [nu12, nu23, nu13], shear_mpa } = *self;
        let mut s = Matrix6::zeros();
        for (k, e) in [e1, e2, e3].into_iter().enumerate() {
            s[(k, k)] = 1.0 / e;
            s[(k + 3, k + 3)] = 1.0 / shear_mpa[k];
        }
        for ([i, j], value) in [([0, 1], -nu12 / e1), ([1, 2], -nu23 / e2), ([0, 2], -nu13 / e1)] {
            s[(i, j)] = value;
            s[(j, i)] = value;
        }
        s
    }

    /// Stress from strain along the axes of the material; `None` for an invalid material: whatever strains it must cost work.
    pub fn law(&self) -> Option<Matrix6<f64>> {
        let all = self.young_mpa.iter().chain(&self.shear_mpa);
        let is_number = all.chain(&self.poisson).all(|value| value.is_finite());
        if !is_number || self.young_mpa.iter().chain(&self.shear_mpa).any(|value| *value <= 0.0) {
            return None;
        }
        self.compliance().cholesky().map(|compliance| compliance.inverse())
    }

    /// Young's modulus in the plane of 1 and 2 at an angle to the fibre, in MPa: `1 / E = c^4 / E1 + (1 / G12 - 2 nu12 / E1) s^2 c^2 + s^4 / E2`.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::elastic::{Material, Orthotropic};
    /// let tape = Orthotropic::tape(&Material { young_mpa: 1000.0, poisson: 0.3 }, 200_000.0, 0.5);
    /// assert!((tape.modulus_at(0.0) - 100_500.0).abs() < 1e-6 && (tape.modulus_at(1.5707963267948966) - 1000.0).abs() < 1e-6);
    /// // Five degrees cost two thirds of it.
    /// assert!(tape.modulus_at(5f64.to_radians()) < 34_000.0);
    /// ```
    pub fn modulus_at(&self, angle: f64) -> f64 {
        let (s2, c2) = (angle.sin().powi(2), angle.cos().powi(2));
        let Orthotropic { young_mpa: [e1, e2, _], poisson: [nu12, ..], shear_mpa: [g12, ..] } = *self;
        1.0 / (c2 * c2 / e1 + (1.0 / g12 - 2.0 * nu12 / e1) * s2 * c2 + s2 * s2 / e2)
    }
}

/// The place of components `ij` in the order 11, 22, 33, 12, 23, 31.
const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// A law in other axes: the columns of `axes` are those in which it is given.
pub(super) fn rotated(law: &Matrix6<f64>, axes: &Matrix3<f64>) -> Matrix6<f64> {
    // Stress there to stress here: s_ij = a_ik a_jl s_kl. Work is the same, so strains follow its transpose.
    let mut stress = Matrix6::zeros();
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
        for k in 0..3 {
            for l in 0..3 {
                stress[(PLACE[i][j], PLACE[k][l])] += axes[(i, k)] * axes[(j, l)];
            }
        }
    }
    stress * law * stress.transpose()
}

/// The law of a laminate of two materials in the plane of 1 and 2; `share` of its height has the law `a`.
///
/// # Example
/// ```
/// use curvlay_layers::elastic::{Material, Orthotropic, laminate};
/// // Half of it three times as stiff, without cross contraction: 2 along the plane, 1.5 across it.
/// let law = |young_mpa| Orthotropic::isotropic(&Material { young_mpa, poisson: 0.0 }).law().unwrap();
/// let both = laminate(&law(3.0), &law(1.0), 0.5);
/// assert!((both[(0, 0)] - 2.0).abs() < 1e-12 && (both[(2, 2)] - 1.5).abs() < 1e-12);
/// ```
pub fn laminate(a: &Matrix6<f64>, b: &Matrix6<f64>, share: f64) -> Matrix6<f64> {
    const IN: [usize; 3] = [0, 1, 3];
    const OUT: [usize; 3] = [2, 4, 5];
    let block =
        |law: &Matrix6<f64>, rows: [usize; 3], columns: [usize; 3]| Matrix3::from_fn(|i, j| law[(rows[i], columns[j])]);
    // Of each material: stress along the plane at rest across it, the inverse across, and what couples them.
    let parts = |law: &Matrix6<f64>| {
        let inverse = block(law, OUT, OUT).cholesky().map_or_else(Matrix3::zeros, |d| d.inverse());
        let coupling = block(law, IN, OUT) * inverse;
        (block(law, IN, IN) - coupling * block(law, OUT, IN), coupling, inverse)
    };
    let mean = |a: Matrix3<f64>, b: Matrix3<f64>| a * share + b * (1.0 - share);
    let ((a_in, a_mixed, a_out), (b_in, b_mixed, b_out)) = (parts(a), parts(b));
    let (along, mixed) = (mean(a_in, b_in), mean(a_mixed, b_mixed));
    let across = mean(a_out, b_out).cholesky().map_or_else(Matrix3::zeros, |inverse| inverse.inverse());
    let (in_in, in_out) = (along + mixed * across * mixed.transpose(), mixed * across);
    let mut law = Matrix6::zeros();
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        law[(IN[i], IN[j])] = in_in[(i, j)];
        law[(OUT[i], OUT[j])] = across[(i, j)];
        law[(IN[i], OUT[j])] = in_out[(i, j)];
        law[(OUT[j], IN[i])] = in_out[(i, j)];
    }
    (law + law.transpose()) / 2.0
}

/// The axes of a ply: the direction of its fibre projected into the plane, across it, and its normal; `None` where these are not axes.
pub(super) fn axes(direction: &Vector3<f64>, normal: &Vector3<f64>) -> Option<Matrix3<f64>> {
    // NaN would pass the limits of `try_normalize`.
    if !direction.iter().chain(normal).all(|x| x.is_finite()) {
        return None;
    }
    let normal = normal.try_normalize(1e-12)?;
    let along = (direction - normal * direction.dot(&normal)).try_normalize(1e-9)?;
    Some(Matrix3::from_columns(&[along, normal.cross(&along), normal]))
}
