//! External axes of a move, and loads: what RAPID and URScript share beside poses.

use nalgebra::Point3;

/// Values of up to six external axes that move along, by their logical number; at least one axis is there.
///
/// Of a positioner, tilt and turn are the first two: `ExternalAxes::from([tilt, turn])`. Values are in radians. RAPID
/// writes degrees for an axis that turns and millimetres for one that slides, and a target does not say which axis is
/// which: a value that stands for millimetres is here as if it were degrees (divided by 57.29...), and is written back
/// as it was.
/// ```
/// use curvlay_kinematics::program::ExternalAxes;
/// let table = ExternalAxes::from([0.5, -1.0]);
/// assert_eq!(table.table(), Some([0.5, -1.0]));
/// let fourth = ExternalAxes::new([None, None, None, Some(0.25), None, None]).ok_or("no axis")?;
/// assert_eq!((fourth.axes()[3], fourth.table()), (Some(0.25), None));
/// assert_eq!(ExternalAxes::new([None; 6]), None);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalAxes([Option<f64>; 6]);

impl ExternalAxes {
    /// These axes; `None` if there is no axis.
    pub fn new(axes: [Option<f64>; 6]) -> Option<Self> {
        axes.iter().any(Option::is_some).then_some(ExternalAxes(axes))
    }

    /// The value of each axis, `None` where there is none.
    pub fn axes(&self) -> [Option<f64>; 6] {
        self.0
    }

    /// Tilt and turn, if the first two axes and no others are there.
    pub fn table(&self) -> Option<[f64; 2]> {
        match self.0 {
            [Some(tilt), Some(turn), None, None, None, None] => Some([tilt, turn]),
            _ => None,
        }
    }

    /// A linear track at a position in millimetres as the first axis: `eax_a` of RAPID, `E1` of KRL and TP.
    /// ```
    /// use curvlay_kinematics::program::ExternalAxes;
    /// let track = ExternalAxes::of_track(1250.0);
    /// assert!(track.track_mm().is_some_and(|mm| (mm - 1250.0).abs() < 1e-9));
    /// assert_eq!(ExternalAxes::from([0.5, -1.0]).track_mm(), None);
    /// ```
    pub fn of_track(mm: f64) -> Self {
        ExternalAxes([Some(mm.to_radians()), None, None, None, None, None])
    }

    /// The first axis as the position of a track in millimetres; `None` unless it is the only one. Whether it is a track is not stored.
    pub fn track_mm(&self) -> Option<f64> {
        match self.0 {
            [Some(track), None, None, None, None, None] => Some(track.to_degrees()),
            _ => None,
        }
    }
}

impl From<[f64; 2]> for ExternalAxes {
    /// Tilt and turn of a positioner as the first two axes.
    fn from([tilt, turn]: [f64; 2]) -> Self {
        ExternalAxes([Some(tilt), Some(turn), None, None, None, None])
    }
}

/// A mass that the flange carries. Its moments of inertia count as zero: it is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Payload {
    /// The mass, in kg.
    pub mass_kg: f64,
    /// Centre of mass, in mm, in the flange frame; of a RAPID part load in that of the work object.
    pub centre: Point3<f64>,
}
