//! For reproducing the figures of jerk of C. Dai's dissertation (section 4.3.2); prints use the spline's own ([`Trajectory`](crate::Trajectory)).
//!
//! Derivatives at waypoints from stencils of five, as the dissertation measures jerk.
//!
//! C. Dai, *Material Deposition in 3D Space* (TU Delft 2020), section 4.3.2: through five waypoints goes one quartic
//! (Eq. 4.7 to 4.9); its derivatives at the middle one are those of the trajectory (Eq. 4.10). The measure J of Eq. 4.2
//! is the sum of squared jerks over the waypoints that have a whole stencil, all but two at either end, with `W = I`.
//!
//! J is blind to a sawtooth of period two: at equal steps its third difference is zero (Eq. 4.11). It is here to
//! compare with; what ought to be small is [`Trajectory::squared_jerk`](crate::Trajectory::squared_jerk).

/// Weights of five angles in the first, second and third derivative at the third of their times.
/// ```
/// let [_, _, third] = curvlay_trajectory::stencil(&[0.0, 1.0, 2.0, 3.0, 4.0]);
/// assert_eq!(third, [-0.5, 1.0, 0.0, -1.0, 0.5]); // Eq. 4.11
/// ```
pub fn stencil(times: &[f64; 5]) -> [[f64; 5]; 3] {
    let mut weights = [[0.0; 5]; 3];
    for j in 0..5 {
        // The Lagrange polynomial of knot j as powers of the time since the middle knot.
        let mut powers = [1.0, 0.0, 0.0, 0.0, 0.0];
        let mut scale = 1.0;
        for k in (0..5).filter(|&k| k != j) {
            let root = times[k] - times[2];
            for n in (0..5).rev() {
                powers[n] = if n > 0 { powers[n - 1] } else { 0.0 } - root * powers[n];
            }
            scale *= times[j] - times[k];
        }
        weights[0][j] = powers[1] / scale;
        weights[1][j] = 2.0 * powers[2] / scale;
        weights[2][j] = 6.0 * powers[3] / scale;
    }
    weights
}

/// The [stencil] of each five waypoints in a row.
pub(crate) fn stencils(times: &[f64]) -> impl Iterator<Item = [[f64; 5]; 3]> + '_ {
    times.windows(5).map(|times| stencil(&[times[0], times[1], times[2], times[3], times[4]]))
}

/// The jerks of Eq. 4.10 in rad/s^3 at waypoints `2..M - 2`; none for fewer than five waypoints.
///
/// # Arguments
/// * `times`, `joints`: one of each a waypoint; times rise. What is beyond the shorter list is not looked at.
///
/// # Cost
/// Linear time and memory.
pub fn waypoint_jerks<const N: usize>(times: &[f64], joints: &[[f64; N]]) -> Vec<[f64; N]> {
    stencils(times)
        .zip(joints.windows(5))
        .map(|([_, _, third], joints)| {
            // Differences from the middle keep the digits of angles far from zero.
            std::array::from_fn(|n| (0..5).map(|k| third[k] * (joints[k][n] - joints[2][n])).sum())
        })
        .collect()
}

/// The measure J of Eq. 4.2 with `W = I`, in rad^2/s^6.
/// ```
/// // A cube has a third derivative of 6 everywhere.
/// let times: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k * k)).collect();
/// let joints: Vec<[f64; 1]> = times.iter().map(|t| [t * t * t]).collect();
/// let j = curvlay_trajectory::jerk_measure(&times, &joints);
/// assert!((j - 5.0 * 36.0).abs() < 1e-6);
/// ```
pub fn jerk_measure<const N: usize>(times: &[f64], joints: &[[f64; N]]) -> f64 {
    waypoint_jerks(times, joints).iter().flatten().map(|jerk| jerk * jerk).sum()
}
