//! Rotations as three angles: about z, the new y and the new x, which is about the fixed x, y and z in the reverse order. `A`, `B`, `C` of KUKA, `R`, `P`, `W` of Fanuc.

use nalgebra::{UnitQuaternion, Vector3};

/// The three angles in radians: about z, the new y and the new x. At a quarter turn about y the last one is what is left.
pub(crate) fn angles(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = rotation.to_rotation_matrix();
    let m = m.matrix();
    let a = m[(1, 0)].atan2(m[(0, 0)]);
    let (sin, cos) = a.sin_cos();
    let b = (-m[(2, 0)]).atan2(cos * m[(0, 0)] + sin * m[(1, 0)]);
    let c = (sin * m[(0, 2)] - cos * m[(1, 2)]).atan2(cos * m[(1, 1)] - sin * m[(0, 1)]);
    [a, b, c]
}

/// The rotation of three such angles.
pub(crate) fn rotation([a, b, c]: [f64; 3]) -> UnitQuaternion<f64> {
    let about = |axis, angle: f64| UnitQuaternion::from_axis_angle(&axis, angle);
    about(Vector3::z_axis(), a) * about(Vector3::y_axis(), b) * about(Vector3::x_axis(), c)
}

#[cfg(test)]
mod tests {
    use super::{angles, rotation};
    use nalgebra::{Matrix3, UnitQuaternion, Vector3};

    /// The product of the three matrices as manuals print it.
    fn product([a, b, c]: [f64; 3]) -> Matrix3<f64> {
        let (sa, ca, sb, cb, sc, cc) = (a.sin(), a.cos(), b.sin(), b.cos(), c.sin(), c.cos());
        let z = Matrix3::new(ca, -sa, 0.0, sa, ca, 0.0, 0.0, 0.0, 1.0);
        let y = Matrix3::new(cb, 0.0, sb, 0.0, 1.0, 0.0, -sb, 0.0, cb);
        let x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cc, -sc, 0.0, sc, cc);
        z * y * x
    }

    #[test]
    fn angles_are_those_of_z_y_x_also_at_a_quarter_turn() {
        for k in 0..4000u32 {
            let [a, b, c] = [0.37, 0.61, 0.83].map(|rate| (f64::from(k) * rate).sin() * 3.1);
            let near = [1.0, 1e-3, 1e-7, 1e-9, 0.0][k as usize % 5];
            let b = if k % 3 == 0 { std::f64::consts::FRAC_PI_2 + near * b } else { b };
            let q = UnitQuaternion::from_matrix(&product([a, b, c]));
            let again = rotation(angles(&q));
            assert!((again * Vector3::x() - q * Vector3::x()).norm() < 1e-8, "{a} {b} {c}");
            assert!((again * Vector3::y() - q * Vector3::y()).norm() < 1e-8, "{a} {b} {c}");
            assert!((rotation([a, b, c]).to_rotation_matrix().matrix() - product([a, b, c])).amax() < 1e-12);
            assert!(angles(&q)[1].abs() <= std::f64::consts::FRAC_PI_2 + 1e-9);
        }
    }
}
