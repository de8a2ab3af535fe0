//! The controller of a workcell, as in the file.

/// Settings of the programs of a workcell: [`RapidOptions::of_workcell`](crate::program::RapidOptions::of_workcell),
/// [`UrScriptOptions::of_workcell`](crate::program::UrScriptOptions::of_workcell) and
/// [`StreamOptions::of_workcell`](crate::print_program::StreamOptions::of_workcell) take them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct ControllerModel {
    /// How long the extruder takes from its signal to what comes of it, in seconds, 0 to 0.5: signals come as much earlier.
    #[cfg_attr(feature = "serde", serde(default))]
    pub extruder_lag_s: f64,
    /// How hard `servoj` follows a stream, 100 to 2000; absent: 2000. For an arm of Universal Robots only.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub servoj_gain: Option<f64>,
    /// How far `servoj` looks ahead, in seconds, 0.03 to 0.2; absent: 0.03. For an arm of Universal Robots only.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub servoj_lookahead_s: Option<f64>,
    /// The language of the programs; absent: URScript for an arm of Universal Robots, else RAPID.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub language: Option<ProgramLanguage>,
    /// The group of digital outputs that has the speed of the filament in RAPID; absent: an analog output has it.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub filament_group: Option<FilamentGroupModel>,
}

/// A group of digital outputs as [`FilamentOutput::Group`](crate::program::FilamentOutput::Group) has it: a whole number of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct FilamentGroupModel {
    /// Speed of the filament for one step, 1e-6 to 1000.
    pub step_mm_s: f64,
    /// Bits of the group, 1 to 23.
    pub bits: u8,
}

/// The language of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum ProgramLanguage {
    /// Universal Robots.
    UrScript,
    /// ABB.
    Rapid,
    /// KUKA.
    Krl,
    /// Fanuc.
    Tp,
}

#[cfg(feature = "serde")]
impl ControllerModel {
    pub(super) fn is_default(&self) -> bool {
        *self == ControllerModel::default()
    }
}
