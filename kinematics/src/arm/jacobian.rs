//! Velocities: the geometric Jacobian, its derivative along a motion, and how joints follow the turning tool.
//!
//! Rows 0 to 2 are the velocity of a point of the flange in mm/s, rows 3 to 5 the angular velocity in rad/s, both in
//! the base frame; columns are the joints.
//!
//! A tool that prints round beads may turn about its axis (Dai, *Material Deposition in 3D Space*, TU Delft 2020,
//! Eq. 4.3). In every cell that moves the flange rigidly about a line that stands still in the base, so
//! the derivatives of the inverse with respect to the tool angle are those of a screw motion without pitch.

use super::solver::Arm;
use nalgebra::{Matrix6, Point3, UnitVector3, Vector3, Vector6};
use std::ops::AddAssign;

/// First and second derivatives of joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// First.
    pub first: [f64; 6],
    /// Second.
    pub second: [f64; 6],
}

/// The arm is singular where joints must turn this many times faster than the flange, for a flange moving a link's
/// length a radian: derivatives beyond it have no digits left.
const MAX_RATIO: f64 = 1e8;

impl Arm {
    /// Of each joint a point on its axis and the axis' direction (a positive turn by the right hand), in the base. Of a coupled arm
    /// ([`ArmModel::j23_factor`](super::ArmModel::j23_factor)) these are the axes between links: a turn of its joint 2 turns about both axis 2 and axis 3.
    pub fn axes(&self, joints: &[f64; 6]) -> [(Point3<f64>, UnitVector3<f64>); 6] {
        let axes = self.inner_axes(&self.inner(joints));
        let mut signed = axes.map(|(at, along)| (Point3::from(at), UnitVector3::new_unchecked(along)));
        for (axis, sign) in signed.iter_mut().zip(self.signs) {
            axis.1 = UnitVector3::new_unchecked(axis.1.into_inner() * sign);
        }
        signed
    }

    /// The Jacobian of a point that is fixed to the flange, given in the flange frame (the origin, or the tip of a
    /// tool).
    /// ```
    /// use curvlay_kinematics::{Arm, nalgebra::Point3, robots};
    /// // A UR3 stretched along -x: joint 1 moves the flange along -y by its distance from axis 1.
    /// let j = Arm::new(&robots::UR3)?.jacobian(&[0.0; 6], &Point3::origin());
    /// assert!((j[(1, 0)] + 456.9).abs() < 1e-9 && (j[(5, 0)] - 1.0).abs() < 1e-12);
    /// # Ok::<(), curvlay_kinematics::ArmError>(())
    /// ```
    pub fn jacobian(&self, joints: &[f64; 6], flange_point: &Point3<f64>) -> Matrix6<f64> {
        let point = self.forward(joints) * flange_point;
        let mut jacobian = jacobian_of(&plain(&self.axes(joints)), &point.coords);
        couple(&mut jacobian, self.j23_factor);
        jacobian
    }

    /// How the Jacobian of the same point changes when the joints move with `speeds`: its derivative by time.
    pub fn jacobian_rate(&self, joints: &[f64; 6], speeds: &[f64; 6], flange_point: &Point3<f64>) -> Matrix6<f64> {
        let point = self.forward(joints) * flange_point;
        let axes = self.axes(joints);
        let speeds = &self.between_links(speeds);
        let velocity_of_point =
            (jacobian_of(&plain(&axes), &point.coords) * Vector6::from(*speeds)).fixed_rows::<3>(0).into_owned();
        let mut rate = Matrix6::zeros();
        for k in 0..6 {
            let (at, along) = &axes[k];
            // The axis is carried by the joints before it.
            let (mut velocity, mut turning) = (Vector3::zeros(), Vector3::zeros());
            for (joint, (pivot, axis)) in axes.iter().enumerate().take(k) {
                velocity += axis.cross(&(at - pivot)) * speeds[joint];
                turning += axis.into_inner() * speeds[joint];
            }
            let axis_rate = turning.cross(along);
            let linear = axis_rate.cross(&(point - at)) + along.cross(&(velocity_of_point - velocity));
            rate.fixed_view_mut::<3, 1>(0, k).copy_from(&linear);
            rate.fixed_view_mut::<3, 1>(3, k).copy_from(&axis_rate);
        }
        couple(&mut rate, self.j23_factor);
        rate
    }

    /// Yoshikawa's measure `sqrt(det(J J^T))` at the flange, in mm^3: zero at a singularity, and large far from any.
    ///
    /// T. Yoshikawa, "Manipulability of robotic mechanisms", IJRR 4(2), 1985.
    pub fn manipulability(&self, joints: &[f64; 6]) -> f64 {
        self.jacobian(joints, &Point3::origin()).determinant().abs()
    }

    /// How the joints change while the flange turns about a line that stands still in the base: their first and second
    /// derivatives by the angle (right hand along `direction`), on the branch of `joints`. `None` at a singularity, and where an argument is not finite or so large that a derivative
    /// is not.
    ///
    /// For the tool angle the line is the nozzle's axis: see [`Setup::tool_rates`](crate::Setup::tool_rates).
    pub fn rates_about(&self, joints: &[f64; 6], point: &Point3<f64>, direction: &UnitVector3<f64>) -> Option<Rates> {
        let flange = Point3::from(self.forward(joints).translation.vector);
        let velocity = direction.cross(&(flange - point));
        let acceleration = direction.cross(&velocity);
        let unit = 1.0 / self.longest_link();
        let stacked = |linear, angular| stacked(unit, linear, angular);
        let inverse = self.inverse_jacobian(joints, unit)?;
        let first: [f64; 6] = (inverse * stacked(velocity, direction.into_inner())).into();
        let bent = scaled(unit, self.jacobian_rate(joints, &first, &Point3::origin())) * Vector6::from(first);
        let second = inverse * (stacked(acceleration, Vector3::zeros()) - bent);
        let second: [f64; 6] = second.into();
        first.iter().chain(&second).all(|rate| rate.is_finite()).then_some(Rates { first, second })
    }

    /// How fast the joints turn while the flange moves straight with this velocity (in mm, in the base) and does not turn. `None` as of [`Arm::rates_about`].
    /// ```
    /// use curvlay_kinematics::{Arm, nalgebra::Vector3, robots};
    /// let (arm, joints) = (Arm::new(&robots::UR3)?, [0.3, -1.0, 1.2, -0.4, 0.9, 0.1]);
    /// let rates = arm.rates_along(&joints, &Vector3::new(10.0, 0.0, -5.0)).ok_or("singular")?;
    /// let moved = arm.forward(&std::array::from_fn(|k| joints[k] + 1e-6 * rates[k]));
    /// let way = (moved.translation.vector - arm.forward(&joints).translation.vector) * 1e6;
    /// assert!((way - Vector3::new(10.0, 0.0, -5.0)).norm() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rates_along(&self, joints: &[f64; 6], velocity: &Vector3<f64>) -> Option<[f64; 6]> {
        let unit = 1.0 / self.longest_link();
        let rates = self.inverse_jacobian(joints, unit)? * stacked(unit, *velocity, Vector3::zeros());
        rates.iter().all(|rate| rate.is_finite()).then(|| rates.into())
    }

    /// The inverse of the Jacobian of the flange with lengths in units of the longest link, so that lengths and angles weigh alike.
    fn inverse_jacobian(&self, joints: &[f64; 6], unit: f64) -> Option<Matrix6<f64>> {
        let inverse = scaled(unit, self.jacobian(joints, &Point3::origin())).try_inverse()?;
        let is_sound = inverse.iter().all(|entry| entry.abs() <= MAX_RATIO);
        is_sound.then_some(inverse)
    }
}

fn scaled(unit: f64, mut matrix: Matrix6<f64>) -> Matrix6<f64> {
    matrix.fixed_rows_mut::<3>(0).scale_mut(unit);
    matrix
}

fn stacked(unit: f64, linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    let linear = linear * unit;
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn plain(axes: &[(Point3<f64>, UnitVector3<f64>); 6]) -> [(Vector3<f64>, Vector3<f64>); 6] {
    axes.map(|(at, along)| (at.coords, along.into_inner()))
}

/// From columns of angles between links to columns of joints of which joint 2 turns axis 3 along.
pub(super) fn couple(columns: &mut Matrix6<f64>, factor: f64) {
    if factor.abs() > 0.0 {
        let along = columns.column(2) * factor;
        columns.column_mut(1).add_assign(&along);
    }
}

/// The Jacobian of a point for axes given by a point and a direction.
pub(super) fn jacobian_of(axes: &[(Vector3<f64>, Vector3<f64>); 6], point: &Vector3<f64>) -> Matrix6<f64> {
    let mut jacobian = Matrix6::zeros();
    for (k, (at, along)) in axes.iter().enumerate() {
        jacobian.fixed_view_mut::<3, 1>(0, k).copy_from(&along.cross(&(point - at)));
        jacobian.fixed_view_mut::<3, 1>(3, k).copy_from(along);
    }
    jacobian
}
