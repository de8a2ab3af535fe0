//! The settings of a print: on the command line, and as a profile in a JSON file. Both have the same names and the same rules.
//!
//! What is set nowhere has the default of the crates' options, but for the layer height and the width of a bead, which nobody but the
//! user of a printer knows: [`LAYER_HEIGHT_MM`] and [`BEAD_MM`].

use crate::args::{Failure, above_zero, celsius, from_zero, share};
use crate::input;
use clap::{Args, ValueEnum};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::gcode::{Dialect, DirectionWords, Extrusion, Move, Tags, WriteError, WriteOptions, write_gcode};
use curvlay_toolpath::gouging::{GougingOptions, Nozzle};
use curvlay_toolpath::path::{InfillOptions, InfillPattern};
use curvlay_toolpath::travel::TravelOptions;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::io;
use std::path::{Path, PathBuf};

/// Layer height where neither it nor the cells are given, in millimetres.
pub const LAYER_HEIGHT_MM: f64 = 0.3;
/// Width of a bead where neither it nor the cells are given, in millimetres.
pub const BEAD_MM: f64 = 0.5;
/// The nozzle where neither it nor the workcell is given: tip flat (mm), half angle (degrees), height of the cone, block (mm). Its tip
/// is that of an orifice of 0.4 mm.
pub const NOZZLE: [f64; 4] = [0.8, 45.0, 8.0, 20.0];
/// Diameter of the platform where it is not given, in millimetres: that of the dissertation.
pub const PLATFORM_DIAMETER_MM: f64 = 127.5;

/// What a printer is set to. All is optional: on the command line, in the profile, and after both are put together.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What the profile is called.
    #[arg(skip)]
    pub name: Option<String>,
    /// Distance of the layers in millimetres [default: 0.3, or the edge of a cell where --voxels, --cell or --resume say what cells
    /// there are]
    #[arg(long = "layer-height", value_name = "MM", value_parser = length, allow_negative_numbers = true, help_heading = LAYERS)]
    pub layer_height_mm: Option<f64>,
    /// Width of a bead in millimetres [default: 0.5, or the distance of the layers where --voxels, --cell or --resume are given]
    #[arg(long = "bead", value_name = "MM", value_parser = length, allow_negative_numbers = true, help_heading = LAYERS)]
    pub bead_mm: Option<f64>,
    /// How much of the inside is filled, in percent; 100: all is solid, below there are walls, skins and sparse infill [default: 100]
    #[arg(long = "density", value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true, help_heading = LAYERS)]
    pub density_percent: Option<f64>,
    /// Contours along the boundary of a layer that is not solid [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=MOST), help_heading = LAYERS)]
    pub walls: Option<u32>,
    /// Layers at the bottom and the top that are solid, of a part that is not [default: 4]
    #[arg(long = "skin", value_name = "LAYERS", value_parser = clap::value_parser!(u32).range(..=MOST), help_heading = LAYERS)]
    pub skin_layers: Option<u32>,
    /// Sparse infill [default: rows]
    #[arg(long = "infill", value_name = "PATTERN", help_heading = LAYERS)]
    pub infill_pattern: Option<Sparse>,
    /// How much rows of infill turn from layer to layer, in degrees; 90 for two directions in turn [default: a half turn by the golden
    /// ratio]
    #[arg(long = "infill-turn", value_name = "DEG", value_parser = turn, allow_negative_numbers = true, help_heading = LAYERS)]
    pub infill_turn_deg: Option<f64>,
    /// The file of the workcell; in a profile beside the profile's own place.
    #[arg(skip)]
    pub workcell: Option<PathBuf>,
    /// Shape of the nozzle: diameter of its tip flat (mm), half angle of its cone (degrees), height of the cone (mm),
    /// diameter of the block above it (mm) [default: that of --workcell, else 0.8,45,8,20]
    #[arg(long, value_name = "TIP,ANGLE,HEIGHT,BLOCK", value_parser = nozzle, help_heading = MACHINE)]
    pub nozzle: Option<[f64; 4]>,
    /// Diameter of the platform in millimetres; one that covers the part is taken if that is larger [default: 127.5]
    #[arg(long = "platform-diameter", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = MACHINE)]
    pub platform_diameter_mm: Option<f64>,
    /// Minimum distance to printed material during travels, in millimetres [default: 1]
    #[arg(long = "clearance", value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = MACHINE)]
    pub clearance_mm: Option<f64>,
    /// How far the nozzle backs off along its direction for a travel at least, in millimetres [default: 2]
    #[arg(long = "min-lift", value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = MACHINE)]
    pub min_lift_mm: Option<f64>,
    /// The material, by name
    #[arg(long, value_name = "NAME", help_heading = MATERIAL)]
    pub material: Option<String>,
    /// Diameter of the filament in millimetres [default: 1.75]
    #[arg(long = "filament", value_name = "MM", value_parser = filament, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub filament_diameter_mm: Option<f64>,
    /// Density of the material in g/cm3, for the mass
    #[arg(long = "material-density", value_name = "G_CM3", value_parser = material_density, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub material_density_g_cm3: Option<f64>,
    /// Price of a kilogram of the material, in any currency, for the cost; needs its density
    #[arg(long, value_name = "PRICE", value_parser = from_zero, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub price_per_kg: Option<f64>,
    /// Temperature of the nozzle, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub nozzle_celsius: Option<f64>,
    /// Temperature of the plate, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub bed_celsius: Option<f64>,
    /// Speed of the fan, for the machine file, as a share from 0 to 1
    #[arg(long = "fan", value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = MATERIAL)]
    pub fan_share: Option<f64>,
    /// Wanted flow of material in mm3/s, kept as long as the tip is neither too slow nor too fast [default: 8]
    #[arg(long = "flow", value_name = "MM3_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub flow_mm3_s: Option<f64>,
    /// The tip is not slower than this while it prints, in mm/s [default: 2]
    #[arg(long = "min-feed", value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub min_feed_mm_s: Option<f64>,
    /// Maximum print speed, in mm/s [default: 40]
    #[arg(long = "max-feed", value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_feed_mm_s: Option<f64>,
    /// The nozzle does not turn faster than this, in degrees a second [default: 180]
    #[arg(long = "max-turn-rate", value_name = "DEG_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_turn_rate_deg_s: Option<f64>,
    /// How far the nozzle may turn for each millimetre of its way, in degrees; where no free directions turn as gently, the path is cut
    /// and the nozzle turns away from the part [default: 10]
    #[arg(long = "max-turn", value_name = "DEG_MM", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub max_turn_deg_mm: Option<f64>,
    /// Speed of travels in mm/s [default: 80]
    #[arg(long = "travel-feed", value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub travel_feed_mm_s: Option<f64>,
    /// Filament drawn back before a travel and pushed forward after it, in millimetres [default: 1]
    #[arg(long = "retraction", value_name = "MM", value_parser = distance, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub retraction_mm: Option<f64>,
    /// Speed of the filament while it is drawn back, in mm/s [default: 30]
    #[arg(long = "retract-feed", value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub retract_feed_mm_s: Option<f64>,
    /// Speed of the filament while it is pushed forward, in mm/s [default: 20]
    #[arg(long = "prime-feed", value_name = "MM_S", value_parser = rate, allow_negative_numbers = true, help_heading = SPEEDS)]
    pub prime_feed_mm_s: Option<f64>,
    /// How the machine file says the direction of the nozzle [default: comment]
    #[arg(long, help_heading = FILES)]
    pub dialect: Option<Words>,
    /// How the machine file counts filament [default: absolute]
    #[arg(long, help_heading = FILES)]
    pub extrusion: Option<Count>,
    /// By which comments viewers know layers and kinds of beads in the machine file [default: prusa]
    #[arg(long, help_heading = FILES)]
    pub tags: Option<TagStyle>,
    /// Numbers the lines of the machine file, with checksums [default: false]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false", help_heading = FILES)]
    pub line_numbers: Option<bool>,
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
    /// Reads a profile. The path of a workcell in it counts from its folder.
    ///
    /// # Errors
    /// A line with the file, and line and column or the setting; for an unknown setting with the nearest known one.
    pub fn load(path: &Path) -> Result<Settings, Failure> {
        let failed = |problem: String| Failure::new(format!("{}: {problem}", path.display()));
        let text = input::read_text(path, input::MAX_SETTINGS_BYTES)?;
        let mut settings = Settings::from_json(&text).map_err(failed)?;
        if let (Some(workcell), Some(folder)) = (&mut settings.workcell, path.parent()) {
            *workcell = folder.join(&workcell);
        }
        Ok(settings)
    }

    /// The settings of a JSON text: one object, the names those of the fields.
    ///
    /// # Errors
    /// What is wrong, and where, in words.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::settings::Settings;
    /// let profile = Settings::from_json(r#"{"layer_height_mm": 0.2, "bead_mm": 0.45}"#)?;
    /// assert_eq!((profile.layer_height_mm, profile.nozzle), (Some(0.2), None));
    /// let error = Settings::from_json(r#"{"layer_hight_mm": 0.2}"#).unwrap_err();
    /// assert_eq!(error, "line 1: `layer_hight_mm` is no setting; did you mean `layer_height_mm`?");
    /// # Ok::<(), String>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Settings, String> {
        let settings: Settings = serde_json::from_str(text).map_err(|error| explained(text, &error))?;
        settings.check()?;
        Ok(settings)
    }

    /// What is not as the command line would take it.
    fn check(&self) -> Result<(), String> {
        type Rule = fn(&str) -> Result<f64, String>;
        let numbers: [(&str, Option<f64>, Rule); 23] = [
            ("layer_height_mm", self.layer_height_mm, length),
            ("bead_mm", self.bead_mm, length),
            ("density_percent", self.density_percent, percent),
            ("infill_turn_deg", self.infill_turn_deg, turn),
            ("platform_diameter_mm", self.platform_diameter_mm, above_zero),
            ("clearance_mm", self.clearance_mm, distance),
            ("min_lift_mm", self.min_lift_mm, distance),
            ("filament_diameter_mm", self.filament_diameter_mm, filament),
            ("material_density_g_cm3", self.material_density_g_cm3, material_density),
            ("price_per_kg", self.price_per_kg, from_zero),
            ("nozzle_celsius", self.nozzle_celsius, celsius),
            ("bed_celsius", self.bed_celsius, celsius),
            ("fan_share", self.fan_share, share),
            ("flow_mm3_s", self.flow_mm3_s, rate),
            ("min_feed_mm_s", self.min_feed_mm_s, rate),
            ("max_feed_mm_s", self.max_feed_mm_s, rate),
            ("max_turn_rate_deg_s", self.max_turn_rate_deg_s, rate),
            ("max_turn_deg_mm", self.max_turn_deg_mm, rate),
            ("travel_feed_mm_s", self.travel_feed_mm_s, rate),
            ("retraction_mm", self.retraction_mm, distance),
            ("retract_feed_mm_s", self.retract_feed_mm_s, rate),
            ("prime_feed_mm_s", self.prime_feed_mm_s, rate),
            ("nozzle[0]", self.nozzle.map(|shape| shape[0]), above_zero),
        ];
        for (name, value, rule) in numbers {
            if let Some(value) = value {
                rule(&value.to_string()).map_err(|why| format!("`{name}` is {value}: {why}"))?;
            }
        }
        for (name, value) in [("walls", self.walls), ("skin_layers", self.skin_layers)] {
            if let Some(value) = value.filter(|value| i64::from(*value) > MOST) {
                return Err(format!("`{name}` is {value}: must be {MOST} at most"));
            }
        }
        if let Some(shape) = self.nozzle {
            nozzle_of(shape).map_err(|why| format!("`nozzle`: {why}"))?;
        }
        for (name, lines) in [("start_gcode", &self.start_gcode), ("end_gcode", &self.end_gcode)] {
            let broken = |line: &String| line.contains(['\n', '\r']);
            if let Some(at) = lines.iter().flatten().position(broken) {
                return Err(format!("`{name}`, line {}: a line break within a line; write one text for each", at + 1));
            }
        }
        Ok(())
    }

    /// These settings, and where they are silent those `below`.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::settings::Settings;
    /// let typed = Settings { bead_mm: Some(0.6), ..Settings::default() };
    /// let profile = Settings { bead_mm: Some(0.45), filament_diameter_mm: Some(2.85), ..Settings::default() };
    /// let both = typed.over(&profile);
    /// assert_eq!((both.bead_mm, both.filament_diameter_mm, both.nozzle), (Some(0.6), Some(2.85), None));
    /// ```
    pub fn over(&self, below: &Settings) -> Settings {
        let mut all = below.fields();
        all.extend(self.fields().into_iter().filter(|(_, value)| !value.is_null()));
        serde_json::from_value(Value::Object(all)).unwrap_or_else(|error| unreachable!("fields of settings: {error}"))
    }

    /// All settings by name, null where they are not set.
    pub fn fields(&self) -> Map<String, Value> {
        match serde_json::to_value(self) {
            Ok(Value::Object(fields)) => fields,
            other => unreachable!("settings are an object: {other:?}"),
        }
    }

    /// The settings as a run takes them: what has a default has its value. Layers and beads follow the cells, so they do not.
    pub fn filled_in(&self) -> Settings {
        let (deposition, travel, infill) = (self.deposition(), self.travel(), self.infill());
        let gouging = GougingOptions::default();
        Settings {
            density_percent: Some(self.density_percent.unwrap_or(100.0)),
            walls: Some(infill.walls),
            skin_layers: Some(infill.skin),
            infill_pattern: Some(self.infill_pattern.unwrap_or(Sparse::Rows)),
            infill_turn_deg: Some(self.infill_turn_deg.unwrap_or(infill.turn.to_degrees())),
            platform_diameter_mm: Some(self.platform_diameter_mm.unwrap_or(PLATFORM_DIAMETER_MM)),
            clearance_mm: Some(travel.clearance),
            min_lift_mm: Some(travel.min_lift),
            filament_diameter_mm: Some(deposition.filament_diameter),
            flow_mm3_s: Some(deposition.flow_mm3_s),
            min_feed_mm_s: Some(deposition.min_feed),
            max_feed_mm_s: Some(deposition.max_feed),
            max_turn_rate_deg_s: Some(self.max_turn_rate_deg_s.unwrap_or(deposition.max_turn_rate.to_degrees())),
            max_turn_deg_mm: Some(self.max_turn_deg_mm.unwrap_or(gouging.max_turn_per_mm.to_degrees())),
            travel_feed_mm_s: Some(deposition.travel_feed),
            retraction_mm: Some(deposition.retraction),
            retract_feed_mm_s: Some(deposition.retract_feed),
            prime_feed_mm_s: Some(deposition.prime_feed),
            dialect: Some(self.dialect.unwrap_or(Words::Comment)),
            extrusion: Some(self.extrusion.unwrap_or(Count::Absolute)),
            tags: Some(self.tags.unwrap_or(TagStyle::Prusa)),
            line_numbers: Some(self.line_numbers.unwrap_or(false)),
            ..self.clone()
        }
    }

    /// What is solid and what is not.
    pub fn infill(&self) -> InfillOptions {
        let default = InfillOptions::default();
        InfillOptions {
            density: self.density_percent.map_or(default.density, |percent| percent / 100.0),
            walls: self.walls.unwrap_or(default.walls),
            skin: self.skin_layers.unwrap_or(default.skin),
            pattern: match self.infill_pattern.unwrap_or(Sparse::Rows) {
                Sparse::Rows => InfillPattern::Rows,
                Sparse::Gyroid => InfillPattern::Gyroid,
            },
            turn: self.infill_turn_deg.map_or(default.turn, f64::to_radians),
            ..default
        }
    }

    /// How material is laid.
    pub fn deposition(&self) -> DepositionOptions {
        let default = DepositionOptions::default();
        DepositionOptions {
            filament_diameter: self.filament_diameter_mm.unwrap_or(default.filament_diameter),
            flow_mm3_s: self.flow_mm3_s.unwrap_or(default.flow_mm3_s),
            min_feed: self.min_feed_mm_s.unwrap_or(default.min_feed),
            max_feed: self.max_feed_mm_s.unwrap_or(default.max_feed),
            max_turn_rate: self.max_turn_rate_deg_s.map_or(default.max_turn_rate, f64::to_radians),
            travel_feed: self.travel_feed_mm_s.unwrap_or(default.travel_feed),
            retraction: self.retraction_mm.unwrap_or(default.retraction),
            retract_feed: self.retract_feed_mm_s.unwrap_or(default.retract_feed),
            prime_feed: self.prime_feed_mm_s.unwrap_or(default.prime_feed),
            ..default
        }
    }

    /// How the nozzle is kept from gouging, where `default` holds for what is not set.
    pub fn gouging(&self, default: GougingOptions) -> GougingOptions {
        let max_turn_per_mm = self.max_turn_deg_mm.map_or(default.max_turn_per_mm, f64::to_radians);
        GougingOptions { max_turn_per_mm, ..default }
    }

    /// How the nozzle travels.
    pub fn travel(&self) -> TravelOptions {
        let default = TravelOptions::default();
        TravelOptions {
            clearance: self.clearance_mm.unwrap_or(default.clearance),
            min_lift: self.min_lift_mm.unwrap_or(default.min_lift),
            ..default
        }
    }

    /// Mass of so much material in grams, and its cost, as far as they are known.
    pub fn mass_and_cost(&self, volume_mm3: f64) -> (Option<f64>, Option<f64>) {
        let grams = self.material_density_g_cm3.map(|density| density * volume_mm3 / 1000.0);
        (grams, grams.zip(self.price_per_kg).map(|(grams, price)| price * grams / 1000.0))
    }

    /// What the machine file begins and ends with, where that is not left to the writer: a text each.
    pub fn templates(&self) -> [Option<String>; 2] {
        let text = |lines: &Vec<String>| lines.iter().map(|line| format!("{line}\n")).collect();
        [&self.start_gcode, &self.end_gcode].map(|lines| lines.as_ref().map(text))
    }

    /// How the machine file is written; with the [templates](Settings::templates).
    pub fn write_options<'a>(&self, [start, end]: &'a [Option<String>; 2]) -> WriteOptions<'a> {
        let default = WriteOptions::default();
        WriteOptions {
            dialect: Dialect::Part(match self.dialect.unwrap_or(Words::Comment) {
                Words::Comment => DirectionWords::Comment,
                Words::Ijk => DirectionWords::Ijk,
                Words::Dissertation => DirectionWords::Dissertation,
            }),
            extrusion: match self.extrusion.unwrap_or(Count::Absolute) {
                Count::Absolute => Extrusion::Absolute,
                Count::Relative => Extrusion::Relative,
            },
            tags: match self.tags.unwrap_or(TagStyle::Prusa) {
                TagStyle::None => Tags::None,
                TagStyle::Prusa => Tags::Prusa,
                TagStyle::Cura => Tags::Cura,
            },
            line_numbers: self.line_numbers.unwrap_or(false),
            nozzle_celsius: self.nozzle_celsius,
            bed_celsius: self.bed_celsius,
            fan: self.fan_share,
            header: start.as_deref().unwrap_or(default.header),
            footer: end.as_deref().unwrap_or(default.footer),
            ..default
        }
    }

    /// What would be wrong with the machine file however the part looks: found before the work begins.
    ///
    /// # Errors
    /// [`WriteError`] of an option or a template.
    pub fn check_templates(&self) -> Result<(), WriteError> {
        let (templates, direction) = (self.templates(), Vector3::z_axis());
        let step = Move::Travel { tip: Point3::origin(), direction, feed_mm_s: 1.0 };
        write_gcode([step], &self.write_options(&templates), io::sink()).map(|_| ())
    }
}

/// A nozzle as four numbers, for clap: tip flat, half angle in degrees, height of the cone, block.
///
/// # Errors
/// What is wrong with it.
pub fn nozzle(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let Some(shape) = numbers.ok().and_then(|numbers| <[f64; 4]>::try_from(numbers).ok()) else {
        return Err(
            "must be four numbers: tip flat (mm), half angle (degrees), height of the cone, block (mm)".to_owned()
        );
    };
    nozzle_of(shape)
}

fn nozzle_of(shape: [f64; 4]) -> Result<[f64; 4], String> {
    let [tip, angle, height, block] = shape;
    Nozzle::new(tip, angle.to_radians(), height, block).map(|_| shape).map_err(|error| error.to_string())
}

/// Most walls, and layers of a skin.
const MOST: i64 = 10_000;

/// Longest length of a setting, in millimetres, and fastest speed, flow and turning, in their units a second: ten times what the largest
/// machines do. Beyond, a zero too many was typed, and figures of a run would overflow.
const MAX_LENGTH_MM: f64 = 1e4;
const MAX_RATE: f64 = 1e5;

/// Diameters of filament, in millimetres: of what is sold 1.75 and 2.85; pellets are counted as a filament of any.
const FILAMENTS_MM: [f64; 2] = [0.1, 50.0];

fn at_most(value: f64, max: f64, unit: &str) -> Result<f64, String> {
    if value <= max { Ok(value) } else { Err(format!("must be at most {max} {unit}").trim_end().to_owned()) }
}

fn length(text: &str) -> Result<f64, String> {
    at_most(above_zero(text)?, MAX_LENGTH_MM, "mm")
}

fn distance(text: &str) -> Result<f64, String> {
    at_most(from_zero(text)?, MAX_LENGTH_MM, "mm")
}

fn rate(text: &str) -> Result<f64, String> {
    at_most(above_zero(text)?, MAX_RATE, "")
}

fn filament(text: &str) -> Result<f64, String> {
    let [least, most] = FILAMENTS_MM;
    let value = above_zero(text)?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("must be from {least} to {most} mm")) }
}

fn percent(text: &str) -> Result<f64, String> {
    let value = from_zero(text)?;
    if value <= 100.0 { Ok(value) } else { Err("must be from 0 to 100".to_owned()) }
}

fn turn(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.abs() <= 360.0 { Ok(value) } else { Err("must be from -360 to 360".to_owned()) }
}

/// Densities of what is printed, in g/cm3: foams have 0.1, tungsten 19.3. Beyond, the unit is another.
const DENSITIES: [f64; 2] = [0.01, 25.0];

fn material_density(text: &str) -> Result<f64, String> {
    let [least, most] = DENSITIES;
    let value = above_zero(text)?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("must be from {least} to {most} g/cm3")) }
}

/// What is wrong with a profile: of an unknown setting the nearest known one, of all else what the parser says.
fn explained(text: &str, error: &serde_json::Error) -> String {
    let unknown = || -> Option<String> {
        let (known, given) = (Settings::default().fields(), serde_json::from_str::<Map<String, Value>>(text).ok()?);
        let name = given.keys().find(|name| !known.contains_key(*name))?;
        let nearest = known.keys().map(|other| (edits(name, other), other)).min()?;
        let hint = match nearest {
            (far, other) if far <= name.chars().count().max(3) / 3 => format!("did you mean `{other}`?"),
            _ => format!("there are {}", known.keys().map(String::as_str).collect::<Vec<_>>().join(", ")),
        };
        let line = text.lines().position(|line| line.contains(&format!("\"{name}\"")));
        let place = line.map_or_else(String::new, |line| format!("line {}: ", line + 1));
        Some(format!("{place}`{name}` is no setting; {hint}"))
    };
    unknown().unwrap_or_else(|| error.to_string())
}

/// Letters to put in, take out or change until one word is the other: Wagner and Fischer's table, a row at a time.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in (1..).zip(a.chars()) {
        let mut corner = std::mem::replace(&mut row[0], i);
        for (j, other) in (1..).zip(&b) {
            let replaced = corner + usize::from(letter != *other);
            corner = row[j];
            row[j] = replaced.min(row[j] + 1).min(row[j - 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::edits;

    #[test]
    fn edits_of_words() {
        let cases = [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("flow", "flow", 0), ("ab", "ba", 2)];
        for (a, b, distance) in cases {
            assert_eq!((edits(a, b), edits(b, a)), (distance, distance), "{a} {b}");
        }
    }
}
