//! Rotations as makers' pendants show them.

use super::entry::Maker;
use nalgebra::UnitQuaternion;

/// A rotation as a pendant shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownRotation {
    /// What each number is called there.
    pub names: &'static [&'static str],
    /// The numbers.
    pub values: Vec<f64>,
    /// Their unit; empty for a quaternion.
    pub unit: &'static str,
}

impl Maker {
    /// A rotation as the pendant of this maker shows it: the user manuals of the makers.
    ///
    /// * ABB: a quaternion, the scalar `q1` first.
    /// * Universal Robots: a rotation vector in radians.
    /// * KUKA: `A`, `B`, `C` about z, then the new y, then the new x, in degrees.
    /// * Fanuc: `W`, `P`, `R` about the fixed x, then y, then z; Yaskawa: the same as `Rx`, `Ry`, `Rz`.
    /// * Staubli: `Rx`, `Ry`, `Rz` about x, then the new y, then the new z.
    ///
    /// ```
    /// use curvlay_kinematics::nalgebra::UnitQuaternion;
    /// use curvlay_kinematics::robots::Maker;
    /// let turned = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
    /// let shown = Maker::Kuka.shown(&turned);
    /// assert_eq!(shown.names, ["A", "B", "C"]);
    /// assert!((shown.values[0] - 0.3f64.to_degrees()).abs() < 1e-9);
    /// ```
    pub fn shown(self, rotation: &UnitQuaternion<f64>) -> ShownRotation {
        let (roll, pitch, yaw) = rotation.euler_angles();
        let degrees =
            |names, values: [f64; 3]| ShownRotation { names, values: values.map(half_turn_up).to_vec(), unit: "deg" };
        match self {
            Maker::Abb => {
                // Both signs are one rotation; the first part that is not 0 is above it.
                let parts = [rotation.w, rotation.i, rotation.j, rotation.k];
                let first = parts.iter().find(|part| part.abs() > ROUNDING);
                let sign = first.map_or(1.0, |part| part.signum());
                let values = parts.map(|part| sign * part).to_vec();
                ShownRotation { names: &["q1", "q2", "q3", "q4"], values, unit: "" }
            }
            Maker::UniversalRobots => {
                let vector: [f64; 3] = rotation.scaled_axis().into();
                ShownRotation { names: &["Rx", "Ry", "Rz"], values: vector.to_vec(), unit: "rad" }
            }
            Maker::Kuka => degrees(&["A", "B", "C"], [yaw, pitch, roll]),
            Maker::Fanuc => degrees(&["W", "P", "R"], [roll, pitch, yaw]),
            Maker::Yaskawa => degrees(&["Rx", "Ry", "Rz"], [roll, pitch, yaw]),
            Maker::Staubli => degrees(&["Rx", "Ry", "Rz"], about_new_axes(rotation)),
        }
    }
}

/// Less than this is rounding, in radians.
const ROUNDING: f64 = 1e-12;

/// In degrees; half a turn is 180 and never -180.
fn half_turn_up(angle: f64) -> f64 {
    let degrees = angle.to_degrees();
    if degrees < -180.0 + 1e-9 { degrees + 360.0 } else { degrees }
}

/// Angles about x, then the new y, then the new z. Where y turns by a quarter x and z are one, and all of it is given to z.
fn about_new_axes(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = rotation.to_rotation_matrix();
    let sin_y = m[(0, 2)].clamp(-1.0, 1.0);
    if m[(1, 2)].hypot(m[(2, 2)]) < 1e-9 {
        return [0.0, sin_y.asin(), m[(1, 0)].atan2(m[(1, 1)])];
    }
    [(-m[(1, 2)]).atan2(m[(2, 2)]), sin_y.asin(), (-m[(0, 1)]).atan2(m[(0, 0)])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn about(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(axis * degrees.to_radians())
    }

    proptest! {
        #[test]
        fn numbers_multiplied_out_are_the_rotation(turn in prop::array::uniform3(-3.0..3.0f64)) {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
            let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
            for maker in [Maker::Abb, Maker::Fanuc, Maker::Kuka, Maker::Staubli, Maker::UniversalRobots, Maker::Yaskawa] {
                let ShownRotation { names, values: v, unit } = maker.shown(&rotation);
                prop_assert_eq!(names.len(), v.len());
                prop_assert_eq!(unit.is_empty(), maker == Maker::Abb);
                let again = match maker {
                    Maker::Abb => UnitQuaternion::new_normalize(nalgebra::Quaternion::new(v[0], v[1], v[2], v[3])),
                    Maker::UniversalRobots => UnitQuaternion::from_scaled_axis(Vector3::new(v[0], v[1], v[2])),
                    Maker::Kuka => about(z, v[0]) * about(y, v[1]) * about(x, v[2]),
                    Maker::Fanuc | Maker::Yaskawa => about(z, v[2]) * about(y, v[1]) * about(x, v[0]),
                    Maker::Staubli => about(x, v[0]) * about(y, v[1]) * about(z, v[2]),
                };
                prop_assert!(again.angle_to(&rotation) < 1e-6, "{:?} {:?}", maker, v);
            }
        }
    }

    /// A flange that points down: what the makers' pendants show at their upright postures.
    #[test]
    fn known_rotations_are_shown_as_their_makers_do() {
        let down = about(Vector3::y(), 180.0);
        let near = |maker: Maker, expected: &[f64]| {
            let shown = maker.shown(&down).values;
            shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9 || (a + b).abs() < 1e-9)
        };
        assert!(near(Maker::Abb, &[0.0, 0.0, 1.0, 0.0]));
        // Of the two signs of a rotation, the one whose first number is above 0.
        let both = |numbers: [f64; 4]| {
            let [w, i, j, k] = numbers;
            [1.0, -1.0].map(|sign| UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, i, j, k) * sign))
        };
        for numbers in [[0.5, -0.5, 0.5, -0.5], [0.0, 0.6, -0.8, 0.0]] {
            assert!(both(numbers).iter().all(|rotation| Maker::Abb.shown(rotation).values == numbers));
        }
        assert!(near(Maker::Kuka, &[180.0, 0.0, 180.0]));
        assert!(near(Maker::UniversalRobots, &[0.0, std::f64::consts::PI, 0.0]));
        let quarter = Maker::Staubli.shown(&about(Vector3::y(), 90.0)).values;
        assert!((quarter[1].abs() - 90.0).abs() < 1e-5, "{quarter:?}");
    }
}
