//! What joints may do.

/// Bounds of `N` joints, radians and seconds; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const N: usize> {
    /// Least angles.
    pub lower: [f64; N],
    /// Greatest angles.
    pub upper: [f64; N],
    /// Greatest speeds, rad/s.
    pub velocity: [f64; N],
    /// Greatest accelerations, rad/s^2.
    pub acceleration: [f64; N],
    /// Greatest jerks, rad/s^3.
    pub jerk: [f64; N],
}

impl<const N: usize> Bounds<N> {
    /// No bounds at all.
    pub const NONE: Self = Bounds {
        lower: [f64::NEG_INFINITY; N],
        upper: [f64::INFINITY; N],
        velocity: [f64::INFINITY; N],
        acceleration: [f64::INFINITY; N],
        jerk: [f64::INFINITY; N],
    };

    /// Whether joint `j` turns without a stop, so that angles a whole turn apart are one posture.
    pub fn is_endless(&self, joint: usize) -> bool {
        self.upper[joint] - self.lower[joint] == f64::INFINITY
    }
}
