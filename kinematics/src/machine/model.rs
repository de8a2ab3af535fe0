//! The numbers of a five-axis machine, as they stand in its file.
//!
//! Each field has the name that it has in the file, with its unit: millimetres, degrees, seconds. Nothing is checked here;
//! [`FiveAxis::new`](super::FiveAxis::new) does.

/// The version of the format that this crate reads and writes.
pub const VERSION: u32 = 1;

/// A machine with linear axes and two rotary ones. The posture in which lengths are measured, the zero posture, has all linear axes at 0
/// and each rotary axis at its `zero_deg`; the machine frame is fixed to what carries the table axes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct MachineModel {
    /// Version of the format: [`VERSION`].
    pub version: u32,
    /// What a report calls the machine.
    pub name: String,
    /// Where the numbers come from; absent: not known.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub source: Option<String>,
    /// Name of the dialect of its programs, for the writer of programs; absent: the writer's default. Not looked at here.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub dialect: Option<String>,
    /// Whether the controller knows the tool centre point: X Y Z of its programs are then the tip in the part, else they are positions of
    /// the linear axes.
    pub tcp: bool,
    /// Three linear axes, or two where a turning table places the tip in the plane.
    pub linear: Vec<LinearAxisModel>,
    /// Two rotary axes in the order of the chain from the part to the nozzle: the table axis that carries the part, the table axis that
    /// carries this one; the head axis on the frame, the head axis that carries the nozzle.
    pub rotary: Vec<RotaryAxisModel>,
    /// The nozzle.
    pub nozzle: ToolModel,
    /// The origin of the part in the machine frame at the zero posture. The axes of both frames are parallel then.
    #[cfg_attr(feature = "serde", serde(default))]
    pub part_origin_mm: [f64; 3],
}

/// A linear axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct LinearAxisModel {
    /// X, Y, Z, U, V or W; each letter once.
    pub letter: char,
    /// Where the nozzle goes, as the table sees it, when the value grows; of any length.
    pub direction: [f64; 3],
    /// Its ends.
    pub range_mm: [f64; 2],
    /// Its fastest motion.
    pub max_speed_mm_s: f64,
    /// Its greatest acceleration; absent: without a limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_acceleration_mm_s2: Option<f64>,
}

/// What a rotary axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum AxisMount {
    /// The part.
    Table,
    /// The nozzle.
    Head,
}

/// A rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct RotaryAxisModel {
    /// A, B, C, U, V or W; each letter once.
    pub letter: char,
    /// What the axis moves.
    pub mount: AxisMount,
    /// About this direction what the axis carries turns by the right-hand rule when the value grows; of any length. Measured at the zero posture.
    pub axis: [f64; 3],
    /// A point on the axis (its pivot) at the zero posture. A table's stays where it is, a head's moves with the linear axes. Each machine needs it.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub point_mm: Option<[f64; 3]>,
    /// What the axis reads at the zero posture.
    #[cfg_attr(feature = "serde", serde(default))]
    pub zero_deg: f64,
    /// Its ends, as it reads; absent only with `endless`.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub range_deg: Option<[f64; 2]>,
    /// Whether it turns without end.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "std::ops::Not::not"))]
    pub endless: bool,
    /// Its fastest motion.
    pub max_speed_deg_s: f64,
    /// Its greatest acceleration; absent: without a limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub max_acceleration_deg_s2: Option<f64>,
}

/// A nozzle on a five-axis machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct ToolModel {
    /// From the tip into the nozzle at the zero posture, of any length.
    #[cfg_attr(feature = "serde", serde(default = "ToolModel::upright"))]
    pub direction: [f64; 3],
    /// The tip at the zero posture: from `point_mm` of the last head axis, `[0, 0, -L]` for a nozzle of length `L` that hangs down; on a
    /// machine without a head axis from the origin of the machine frame, where it may be absent: 0.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub tip_mm: Option<[f64; 3]>,
}

impl ToolModel {
    /// The default of [`direction`](ToolModel::direction).
    pub const UPRIGHT: [f64; 3] = [0.0, 0.0, 1.0];

    #[cfg(feature = "serde")]
    fn upright() -> [f64; 3] {
        Self::UPRIGHT
    }
}

/// How the axes of a machine are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineKind {
    /// The table tilts and turns under a nozzle of fixed direction.
    TableTable,
    /// The table turns, the head tilts.
    HeadTable,
    /// The head tilts and turns over a part that stands still.
    HeadHead,
    /// Two linear axes, a table whose turn places the tip, and a head that tilts in the plane of the linear axes: of a direction it follows the
    /// part in that plane.
    PolarHead,
}
