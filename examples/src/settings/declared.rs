//! The settings of a print, each declared once: the option of the command line is the setting of the profile.

use super::rules::{MAX_COUNT, distance, filament, length, material_density, nozzle, percent, rate, turn};
use crate::args::{above_zero, celsius, from_zero, share};
use clap::{ArgAction, Args, Command, FromArgMatches, ValueEnum};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_toolpath::path::InfillOptions;
use curvlay_toolpath::travel::TravelOptions;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Layer height where neither it nor the cells are given, in millimetres.
pub const LAYER_HEIGHT_MM: f64 = 0.3;
/// Width of a bead where neither it nor the cells are given, in millimetres.
pub const BEAD_MM: f64 = 0.5;
/// Diameter of the platform where it is not given, in millimetres: that of the dissertation.
pub const PLATFORM_DIAMETER_MM: f64 = 127.5;

/// What a printer is set to: an option each, under the name that the setting has in a profile and in `summary.json`. This is the one place
/// that says name, unit, range, topic, help and default; where the default is the library's, it is taken from there. What depends on other
/// options, or on nothing but the user, is optional.
#[derive(Args, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What the profile is called.
    #[arg(skip)]
    pub name: Option<String>,
    /// Layer height in millimetres [default: 0.3, or the edge of a cell if --voxels, --cell or --resume set the cells]
    #[arg(long = "layer-height", value_name = "MM", value_parser = length, allow_negative_numbers = true, help_heading = LAYERS)]
    pub layer_height_mm: Option<f64>,
    /// Width of a bead in millimetres [default: 0.5, or the layer height if --voxels, --cell or --resume set the cells]
    #[arg(long = "bead", value_name = "MM", value_parser = length, allow_negative_numbers = true, help_heading = LAYERS)]
    pub bead_mm: Option<f64>,
    /// Share of the inside that is filled, in percent: 100 is solid; less gives walls, solid top and bottom layers, and sparse infill
    #[arg(long = "density", default_value_t = 100.0, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true, help_heading = LAYERS)]
    pub density_percent: f64,
    /// Contours along the boundary of each layer, if the part is not solid
    #[arg(long, default_value_t = InfillOptions::default().walls, value_name = "N", value_parser = clap::value_parser!(u32).range(..=MAX_COUNT), help_heading = LAYERS)]
    pub walls: u32,
    /// Solid layers at the bottom and at the top, if the part is not solid
    #[arg(long = "skin", default_value_t = InfillOptions::default().skin, value_name = "LAYERS", value_parser = clap::value_parser!(u32).range(..=MAX_COUNT), help_heading = LAYERS)]
    pub skin_layers: u32,
    /// Pattern of the sparse infill
    #[arg(long = "infill", value_enum, default_value_t = Sparse::Rows, value_name = "PATTERN", help_heading = LAYERS)]
    pub infill_pattern: Sparse,
    /// Angle between the rows of infill of successive layers, in degrees; 90 alternates two directions [default: 111.2, a half turn by
    /// the golden ratio]
    #[arg(long = "infill-turn", hide_default_value = true, default_value_t = InfillOptions::default().turn.to_degrees(), value_name = "DEG", value_parser = turn, allow_negative_numbers = true, help_heading = LAYERS)]
    pub infill_turn_deg: f64,
    /// The file of the workcell; in a profile beside the profile's own place.
    #[arg(skip)]
    pub workcell: Option<PathBuf>,
    /// Shape of the nozzle: diameter of the flat tip (mm), half angle of the cone (degrees), height of the cone (mm), diameter of the
    /// block above it (mm) [default: that of --workcell, else 0.8,45,8,20]
    #[arg(long, value_name = "TIP,ANGLE,HEIGHT,BLOCK", value_parser = nozzle, help_heading = MACHINE)]
    pub nozzle: Option<[f64; 4]>,
    /// Diameter of the platform in millimetres; a larger one is used if the part does not fit
    #[arg(long = "platform-diameter", default_value_t = PLATFORM_DIAMETER_MM, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = MACHINE)]
    pub platform_diameter_mm: f64,
    /// Minimum distance to printed material during travels, in millimetres
    #[arg(long = "clearance", default_value_t = TravelOptions::default().clearance, value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = MACHINE)]
    pub clearance_mm: f64,
    /// Minimum distance that the nozzle backs off along its direction for a travel, in millimetres
    #[arg(long = "min-lift", default_value_t = TravelOptions::default().min_lift, value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = MACHINE)]
    pub min_lift_mm: f64,
    /// Name of the material
    #[arg(long, value_name = "NAME", help_heading = MATERIAL)]
    pub material: Option<String>,
    /// Diameter of the filament in millimetres; for pellets a nominal one
    #[arg(long = "filament", default_value_t = DepositionOptions::default().filament_diameter, value_name = "MM", value_parser = filament, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub filament_diameter_mm: f64,
    /// Density of the material in g/cm3, to compute the mass
    #[arg(long = "material-density", value_name = "G_CM3", value_parser = material_density, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub material_density_g_cm3: Option<f64>,
    /// Price per kilogram in any currency, to compute the cost; needs --material-density
    #[arg(long, value_name = "PRICE", value_parser = from_zero, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub price_per_kg: Option<f64>,
    /// Temperature of the nozzle in degrees Celsius, for the machine file
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub nozzle_celsius: Option<f64>,
    /// Temperature of the plate in degrees Celsius, for the machine file
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub bed_celsius: Option<f64>,
    /// Fan speed from 0 to 1, for the machine file
    #[arg(long = "fan", value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub fan_share: Option<f64>,
    /// Target flow of material in mm3/s, within the limits of the print speed
    #[arg(long = "flow", default_value_t = DepositionOptions::default().flow_mm3_s, value_name = "MM3_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub flow_mm3_s: f64,
    /// Minimum print speed, in mm/s
    #[arg(long = "min-feed", default_value_t = DepositionOptions::default().min_feed, value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub min_feed_mm_s: f64,
    /// Maximum print speed, in mm/s
    #[arg(long = "max-feed", default_value_t = DepositionOptions::default().max_feed, value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_feed_mm_s: f64,
    /// Maximum turning speed of the nozzle, in degrees per second
    #[arg(long = "max-turn-rate", default_value_t = DepositionOptions::default().max_turn_rate.to_degrees(), value_name = "DEG_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_turn_rate_deg_s: f64,
    /// Maximum turn of the nozzle per millimetre of path, in degrees; where no collision-free directions turn as gently, the path is cut
    /// and the nozzle turns away from the part
    #[arg(long = "max-turn", default_value_t = GougingOptions::default().max_turn_per_mm.to_degrees(), value_name = "DEG_MM", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_turn_deg_mm: f64,
    /// Travel speed, in mm/s
    #[arg(long = "travel-feed", default_value_t = DepositionOptions::default().travel_feed, value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub travel_feed_mm_s: f64,
    /// Filament retracted before a travel and primed after it, in millimetres
    #[arg(long = "retraction", default_value_t = DepositionOptions::default().retraction, value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub retraction_mm: f64,
    /// Retraction speed of the filament, in mm/s
    #[arg(long = "retract-feed", default_value_t = DepositionOptions::default().retract_feed, value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub retract_feed_mm_s: f64,
    /// Priming speed of the filament, in mm/s
    #[arg(long = "prime-feed", default_value_t = DepositionOptions::default().prime_feed, value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub prime_feed_mm_s: f64,
    /// How the machine file gives the direction of the nozzle
    #[arg(long, value_enum, default_value_t = Words::Comment, help_heading = FILES)]
    pub dialect: Words,
    /// G-code flavour of the machine file: klipper, marlin, siemens, heidenhain, or a JSON file of one (toolpath/docs/flavours.md) [default: tip and direction as
    /// --dialect gives them]
    #[arg(long, value_name = "NAME|FILE", help_heading = FILES)]
    pub flavour: Option<String>,
    /// How the machine file counts filament
    #[arg(long, value_enum, default_value_t = Count::Absolute, help_heading = FILES)]
    pub extrusion: Count,
    /// Comments that mark layers and kinds of beads for viewers of the machine file
    #[arg(long, value_enum, default_value_t = TagStyle::Prusa, help_heading = FILES)]
    pub tags: TagStyle,
    /// Numbers and checksums on the lines of the machine file
    #[arg(long, default_value_t = false, action = ArgAction::Set, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false", help_heading = FILES)]
    pub line_numbers: bool,
    /// What the machine file begins with, a line each, with `{nozzle}`, `{bed}` and `{fan}`.
    #[arg(skip)]
    pub start_gcode: Option<Vec<String>>,
    /// What it ends with.
    #[arg(skip)]
    pub end_gcode: Option<Vec<String>>,
}

/// Headings of `--help`.
pub const LAYERS: &str = "Layers and beads";
/// See [`LAYERS`].
pub const MACHINE: &str = "Machine";
/// See [`LAYERS`].
pub const MATERIAL: &str = "Material";
/// See [`LAYERS`].
pub const SPEEDS: &str = "Speeds";
/// See [`LAYERS`].
pub const FILES: &str = "Files";

/// How the machine file says the direction of the nozzle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Words {
    /// In a comment, `;DIR:0 0 1`: no firmware can mistake it.
    Comment,
    /// As `I J K`.
    Ijk,
    /// As `nX nY nZ`: only for machines that know these words, others may drive to them.
    Dissertation,
}

/// By which comments viewers know layers and kinds of beads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TagStyle {
    /// None.
    None,
    /// Those of PrusaSlicer and its relatives: `;LAYER_CHANGE`, `;TYPE:External perimeter`, `;WIDTH:`, `;HEIGHT:`.
    Prusa,
    /// Those of CuraEngine: `;LAYER:0`, `;TYPE:WALL-OUTER`.
    Cura,
}

/// How the inside is filled where it is not solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sparse {
    /// Rows to and fro.
    Rows,
    /// Where layers meet a gyroid.
    Gyroid,
}

/// How filament is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Count {
    /// From the beginning, `M82`.
    Absolute,
    /// Each move for itself, `M83`.
    Relative,
}

impl Settings {
    /// A command that has these options and no others.
    pub fn command() -> Command {
        Settings::augment_args(Command::new("settings"))
    }
}

/// As without any word on the command line.
impl Default for Settings {
    fn default() -> Self {
        let matches = Settings::command().get_matches_from(["settings"]);
        Settings::from_arg_matches(&matches)
            .unwrap_or_else(|error| unreachable!("every setting has a default: {error}"))
    }
}
