//! Waypoints of the motions of a print, and how they become targets.

/// A waypoint of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintKnot<const N: usize> {
    /// When, in seconds; rising along a motion.
    pub time_s: f64,
    /// Joints there.
    pub joints: [f64; N],
    /// Millimetres of filament that are laid by then.
    pub filament_mm: f64,
}

/// How a print is written as targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetOptions {
    /// Radius within which corners between waypoints are rounded, in millimetres. Default 0.3, the least that RAPID has a name
    /// for.
    pub corner_mm: f64,
    /// The tool may turn so many times as fast as the plan has it, so that turning never holds a move up. Default 2.
    pub turn_factor: f64,
    /// Turning is written as this at least, in rad/s. Default 0.5.
    pub min_turn_rad_s: f64,
    /// The tip's speed is written as this at least, in mm/s. Default 0.01: what is slower goes by micrometres.
    pub min_speed_mm_s: f64,
    /// Waypoints from which the straight line between two others leads by no more than this, in millimetres, are no targets
    /// of their own. Default 0.05, an eighth of a bead: a straight path of 100 mm is a few lines, and no move is shorter than a cycle of the controller for the spacing of waypoints alone. With 0 each is one.
    pub merge_mm: f64,
    /// And where the tool, or the table, is turned from its interpolation by no more than this, in radians. Default 1e-3.
    pub merge_rad: f64,
    /// And where the speed of the tip and the filament for a millimetre are those of the line within this share. Default
    /// 0.05.
    pub merge_share: f64,
    /// Maximum speed of the tip over the part in travels, in mm/s. Default 250, the limit of ISO 10218-1 for a reduced speed.
    pub travel_mm_s: f64,
    /// Maximum speed of a joint in travels, in rad/s. Default 1.
    pub travel_rad_s: f64,
    /// The speed of the filament is written again where it changes by more than this share, as in a stream. Default 0.002.
    pub same_speed: f64,
}

impl Default for TargetOptions {
    fn default() -> Self {
        TargetOptions {
            corner_mm: 0.3,
            turn_factor: 2.0,
            min_turn_rad_s: 0.5,
            min_speed_mm_s: 0.01,
            merge_mm: 0.05,
            merge_rad: 1e-3,
            merge_share: 0.05,
            travel_mm_s: 250.0,
            travel_rad_s: 1.0,
            same_speed: 2e-3,
        }
    }
}
