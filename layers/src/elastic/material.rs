//! An isotropic material, and how a cube of it resists.

use nalgebra::{Matrix3, Matrix6, SMatrix, SymmetricEigen, Vector3};

/// Stiffness of a cube: rows and columns are its 8 corners times x, y and z. Corner `k` lies at `x = k & 1`, `y = k >> 1 & 1`, `z = k >> 2`.
pub(super) type Stiffness = SMatrix<f64, 24, 24>;

/// Strains of a cube from the displacements of its corners.
type Strain = SMatrix<f64, 6, 24>;

/// An isotropic linear-elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Material {
    /// Young's modulus in MPa (N/mm²). Default 3,500: PLA as it is sold. Dai 2020, section 5.4.1, measured 1,250 on printed specimens.
    pub young_mpa: f64,
    /// Poisson's ratio, above -1 and below 0.5. Default 0.35.
    pub poisson: f64,
}

impl Default for Material {
    fn default() -> Self {
        Material { young_mpa: 3500.0, poisson: 0.35 }
    }
}

impl Material {
    pub(super) fn is_sound(&self) -> bool {
        self.young_mpa > 0.0 && self.young_mpa.is_finite() && self.poisson > -1.0 && self.poisson < 0.5
    }

    /// Stress from strain; the strains are xx, yy, zz, xy, yz, zx, the last three as angles.
    pub(super) fn law_of(&self) -> Matrix6<f64> {
        let Material { young_mpa: e, poisson: nu } = *self;
        let shear = e / (2.0 * (1.0 + nu));
        let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let mut law = Matrix6::zeros();
        law.fixed_view_mut::<3, 3>(0, 0).fill(lambda);
        for k in 0..3 {
            law[(k, k)] += 2.0 * shear;
            law[(k + 3, k + 3)] = shear;
        }
        law
    }
}

/// The stiffness of a cube with an edge of `edge` mm, in N/mm.
///
/// E. L. Wilson, R. L. Taylor, W. P. Doherty, J. Ghaboussi, "Incompatible displacement models", in *Numerical and Computer Methods in
/// Structural Mechanics*, 1973: a brick of 8 nodes with three inner modes `1 - xi²` a component, taken out by static
/// condensation. Without them a brick is too stiff in bending; on cubes they pass the patch test.
pub(super) fn stiffness(law: &Matrix6<f64>, edge: f64) -> Stiffness {
    let point = 1.0 / 3f64.sqrt(); // two Gauss points an axis integrate all of it exactly
    let mut outer = Stiffness::zeros();
    let mut mixed = SMatrix::<f64, 24, 9>::zeros();
    let mut inner = SMatrix::<f64, 9, 9>::zeros();
    let volume = (edge / 2.0).powi(3);
    for k in 0..8 {
        let at = corner(k).map(|sign| sign * point);
        let (b, g) = (strain(at, edge), inner_strain(at, edge));
        outer += b.transpose() * law * b * volume;
        mixed += b.transpose() * law * g * volume;
        inner += g.transpose() * law * g * volume;
    }
    let condensed = inner.cholesky().map(|inner| mixed * inner.solve(&mixed.transpose()));
    let stiffness = outer - condensed.unwrap_or_else(Stiffness::zeros);
    (stiffness + stiffness.transpose()) / 2.0
}

/// The stress at the centre of a cube in MPa, from the displacements of its corners: xx, yy, zz, xy, yz, zx. The inner modes strain nothing
/// there.
pub(super) fn stress_at_centre(law: &Matrix6<f64>, edge: f64) -> Strain {
    law * strain(Vector3::zeros(), edge)
}

/// The signs of a corner: -1 or 1 along each axis.
fn corner(k: usize) -> Vector3<f64> {
    Vector3::new(k & 1, k >> 1 & 1, k >> 2).map(|bit| 2.0 * bit as f64 - 1.0)
}

/// Strains at a place in the cube, which reaches from -1 to 1.
fn strain(at: Vector3<f64>, edge: f64) -> Strain {
    let mut b = Strain::zeros();
    for k in 0..8 {
        let sign = corner(k);
        let factor = |axis: usize| (1.0 + sign[axis] * at[axis]) / 2.0;
        let slope = |axis: usize| sign[axis] / edge * factor((axis + 1) % 3) * factor((axis + 2) % 3);
        set_strain(&mut b.fixed_columns_mut::<3>(3 * k), Vector3::new(slope(0), slope(1), slope(2)));
    }
    b
}

/// Strains of the inner modes `1 - xi²`, `1 - eta²` and `1 - zeta²`.
fn inner_strain(at: Vector3<f64>, edge: f64) -> SMatrix<f64, 6, 9> {
    let mut g = SMatrix::<f64, 6, 9>::zeros();
    for axis in 0..3 {
        let mut slope = Vector3::zeros();
        slope[axis] = -4.0 * at[axis] / edge;
        set_strain(&mut g.fixed_columns_mut::<3>(3 * axis), slope);
    }
    g
}

/// Strains of a shape function with the given gradient, for displacements along x, y and z.
fn set_strain<S: nalgebra::StorageMut<f64, nalgebra::U6, nalgebra::U3>>(
    b: &mut nalgebra::Matrix<f64, nalgebra::U6, nalgebra::U3, S>,
    slope: Vector3<f64>,
) {
    for axis in 0..3 {
        b[(axis, axis)] = slope[axis];
    }
    for (row, [i, j]) in [(3, [0, 1]), (4, [1, 2]), (5, [2, 0])] {
        b[(row, i)] = slope[j];
        b[(row, j)] = slope[i];
    }
}

/// The stress of a cell as a matrix. `stress` is xx, yy, zz, xy, yz, zx.
///
/// # Example
/// ```
/// use curvlay_layers::elastic::stress_matrix;
/// let stress = stress_matrix(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// assert_eq!((stress[(0, 1)], stress[(1, 2)], stress[(2, 0)]), (4.0, 5.0, 6.0));
/// ```
pub fn stress_matrix(stress: &[f64; 6]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, yz, zx] = *stress;
    Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

/// A principal stress and the direction in which it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// The stress in MPa, above 0 for tension.
    pub stress_mpa: f64,
    /// Its direction, of length 1. Either of two opposite ones: the one whose component of largest size is positive.
    pub direction: Vector3<f64>,
}

/// The principal stresses of `stress` (xx, yy, zz, xy, yz, zx), that of the largest size first.
///
/// # Example
/// ```
/// let [first, second, _] = curvlay_layers::elastic::principal_stresses(&[0.0, 0.0, -5.0, 0.0, 0.0, 0.0]);
/// assert_eq!((first.stress_mpa, second.stress_mpa), (-5.0, 0.0));
/// assert_eq!(first.direction.z, 1.0);
/// ```
pub fn principal_stresses(stress: &[f64; 6]) -> [Principal; 3] {
    let eigen = SymmetricEigen::new(stress_matrix(stress));
    let mut all = [0, 1, 2].map(|k| {
        let direction: Vector3<f64> = eigen.eigenvectors.column(k).into();
        // Ties within rounding go to the first axis, or the sign would hang on the last bit.
        let largest = (0..3).find(|&axis| direction[axis].abs() >= direction.amax() * (1.0 - 1e-9)).unwrap_or(0);
        Principal { stress_mpa: eigen.eigenvalues[k], direction: direction * direction[largest].signum() }
    });
    all.sort_by(|a, b| b.stress_mpa.abs().total_cmp(&a.stress_mpa.abs()));
    all
}

/// The equivalent stress of von Mises in MPa. `stress` is xx, yy, zz, xy, yz, zx.
///
/// # Example
/// ```
/// assert_eq!(curvlay_layers::elastic::von_mises(&[7.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 7.0);
/// ```
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let [xx, yy, zz, xy, yz, zx] = *stress;
    let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    let shear = xy * xy + yz * yz + zx * zx;
    (normal / 2.0 + 3.0 * shear).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_resists_all_but_rigid_motions() {
        let stiffness = stiffness(&Material { young_mpa: 2.0, poisson: 0.3 }.law_of(), 0.5);
        let eigenvalues = SymmetricEigen::new(stiffness).eigenvalues;
        let zero = eigenvalues.iter().filter(|value| value.abs() < 1e-12).count();
        assert_eq!(zero, 6);
        assert!(eigenvalues.iter().all(|&value| value > -1e-12));
    }

    /// Bending about y: `u = x z`, `w = -x²/2 - nu z²/2`, the displacement of a beam with `sigma_xx = E z`. Without its inner modes the cube is
    /// stiffer by half and more.
    #[test]
    fn a_cube_bends_as_a_beam_does() {
        let material = Material { young_mpa: 3.0, poisson: 0.0 };
        let mut bent = SMatrix::<f64, 24, 1>::zeros();
        for k in 0..8 {
            let at = corner(k); // a cube of edge 2 around the origin
            bent[3 * k] = at.x * at.z;
        }
        let energy = (bent.transpose() * stiffness(&material.law_of(), 2.0) * bent)[0] / 2.0;
        let exact = 0.5 * 3.0 * 8.0 / 3.0; // half of E times the integral of z² over the cube
        assert!((energy - exact).abs() < 1e-12, "{energy} {exact}");
    }

    #[test]
    fn principal_stresses_are_those_of_pure_shear() {
        let [first, second, third] = principal_stresses(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        assert!((first.stress_mpa.abs() - 2.0).abs() < 1e-12 && (first.stress_mpa + second.stress_mpa).abs() < 1e-12);
        assert!(third.stress_mpa.abs() < 1e-12 && (third.direction.z - 1.0).abs() < 1e-12);
        assert!((first.direction.x.abs() - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((von_mises(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]) - 12f64.sqrt()).abs() < 1e-12);
    }
}
