//! From a point on a dome in the robot's hand to the robtarget that brings it under a fixed nozzle: [`DomeRig`].

use crate::angle::short_way;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The numbers of Brooks' rig, in millimetres: from a point on a dome in the robot's hand to the robtarget that brings it
/// under a fixed nozzle.
///
/// B. Brooks, *3D printing a transposed design in biopolymer materials using an articulated robot and pellet-based
/// extrusion* (ME thesis, Massey University 2016), section 4.15, Eq. 4-5 to 4-7 and the matrix `R`. Symbols: `proj X` and
/// `pt.Z` are `radius` and `height` here, `theta` is the arc tangent of `slope`, `phi` is `turn`.
///
/// The thesis leaves the sign of the turn in the plane to its figure; here it makes the tangent level. Its plane is the
/// robot's YZ plane, radius along -y: so does the turn in the plane agree with `R = Rx(theta) Rz(phi)`, and every point
/// comes to stand at the contact, with the tangent level (the tests check both). Angles are in radians, 0 where nothing
/// turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomeRig {
    /// Height of the dome's top over the platform's origin, which is where the nozzle touches. 150 in the thesis.
    pub top: f64,
    /// Height of the end effector in the same frame. -40 in the thesis.
    pub effector: f64,
    /// The robot's home, to which all is added. (0, -165, 674) in the thesis.
    pub home: Point3<f64>,
}

impl DomeRig {
    /// The rig of the thesis.
    pub const BROOKS: DomeRig = DomeRig { top: 150.0, effector: -40.0, home: Point3::new(0.0, -165.0, 674.0) };

    /// The end effector in the plane of the dome's profile, `[x, z]`, for the point of the profile at `radius` and
    /// `height` where it has this slope.
    /// ```
    /// use curvlay_kinematics::program::DomeRig;
    /// // At the top nothing turns, and the effector stays where it is.
    /// assert_eq!(DomeRig::BROOKS.in_plane(0.0, 150.0, 0.0), [0.0, -40.0]);
    /// ```
    pub fn in_plane(&self, radius: f64, height: f64, slope: f64) -> [f64; 2] {
        // Moved so that the point is at the top, then turned about the top by -theta.
        let (across, along) = (-radius, self.effector - height);
        let cos = 1.0 / 1f64.hypot(slope);
        let sin = slope * cos;
        [across * cos + along * sin, self.top - across * sin + along * cos]
    }

    /// The end effector in the robot's base, with the platform turned by `turn` about its axis. Numbers that are not
    /// finite give a pose that is not finite.
    pub fn target(&self, radius: f64, height: f64, slope: f64, turn: f64) -> Isometry3<f64> {
        let [x, z] = self.in_plane(radius, height, slope);
        let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), slope.atan());
        let rotation = tilt * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        Isometry3::from_parts(Translation3::new(self.home.x, self.home.y - x, self.home.z + z), rotation)
    }

    /// The same for a point of the platform's frame: the turn brings it into the plane. On the axis nothing turns.
    pub fn target_of(&self, point: &Point3<f64>, slope: f64) -> Isometry3<f64> {
        let radius = point.x.hypot(point.y);
        let turn = if radius > 0.0 { -FRAC_PI_2 - point.y.atan2(point.x) } else { 0.0 };
        self.target(radius, point.z, slope, turn)
    }

    /// The same for a point of any surface, with the platform turned by any `turn`: the normal comes to stand upright at the
    /// contact by the shortest tilt. On a surface of revolution, with the turn of [`turns`](Self::turns), this is
    /// [`target_of`](Self::target_of).
    /// ```
    /// use curvlay_kinematics::{nalgebra::{Point3, Vector3}, program::DomeRig};
    /// let rig = DomeRig::BROOKS;
    /// let pose = rig.target_on(&Point3::new(3.0, 4.0, 150.0), &Vector3::z_axis(), 0.5);
    /// // The point of the platform's frame, as the effector has it.
    /// assert!((pose * Point3::new(3.0, 4.0, 150.0 - rig.effector) - rig.contact()).norm() < 1e-9);
    /// ```
    pub fn target_on(&self, point: &Point3<f64>, normal: &UnitVector3<f64>, turn: f64) -> Isometry3<f64> {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        // Straight down there is no shortest tilt: about x.
        let tilt = UnitQuaternion::rotation_between(&(turned * normal.into_inner()), &Vector3::z());
        let tilt = tilt.unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
        let rotation = tilt * turned;
        let lever = rotation * (point - Point3::new(0.0, 0.0, self.effector));
        Isometry3::from_parts(Translation3::from(self.contact().coords - lever), rotation)
    }

    /// The turn at each point of a path that brings it into the robot's YZ plane, without jumps of a whole turn.
    ///
    /// Nearer to the axis than `pole` millimetres, where small ways would be large turns, it is interpolated along the path:
    /// [`target_on`](Self::target_on) takes any turn.
    /// ```
    /// use curvlay_kinematics::{nalgebra::Point3, program::DomeRig};
    /// // Once around, and a little more.
    /// let points: Vec<_> = (0..=70).map(|k| 0.1 * f64::from(k)).map(|a| Point3::new(9.0 * a.cos(), 9.0 * a.sin(), 0.0)).collect();
    /// let turns = DomeRig::turns(&points, 5.0);
    /// assert!((turns[70] - turns[0] + 7.0).abs() < 1e-9);
    /// ```
    pub fn turns(points: &[Point3<f64>], pole: f64) -> Vec<f64> {
        let mut along = 0.0;
        let mut lengths = Vec::with_capacity(points.len());
        let mut known: Vec<(usize, f64)> = Vec::new();
        for (k, at) in points.iter().enumerate() {
            along += if k > 0 { (at - points[k - 1]).norm() } else { 0.0 };
            lengths.push(along);
            if at.x.hypot(at.y) >= pole.max(f64::MIN_POSITIVE) {
                let turn = -FRAC_PI_2 - at.y.atan2(at.x);
                let before = known.last().map_or(0.0, |(_, turn)| *turn);
                known.push((k, before + short_way(turn - before)));
            }
        }
        let mut turns = vec![0.0; points.len()];
        if let (Some(first), Some(last)) = (known.first(), known.last()) {
            turns[..first.0].fill(first.1);
            turns[last.0..].fill(last.1);
        }
        for pair in known.windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            let way = lengths[to] - lengths[from];
            for k in from..to {
                let share = if way > 0.0 { (lengths[k] - lengths[from]) / way } else { 0.0 };
                turns[k] = a + (b - a) * share;
            }
        }
        turns
    }

    /// Where the nozzle touches, in the robot's base.
    pub fn contact(&self) -> Point3<f64> {
        self.home + Vector3::z() * self.top
    }
}
