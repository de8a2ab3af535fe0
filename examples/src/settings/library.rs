//! Settings as the options of the libraries.

use super::declared::{Count, Settings, Sparse, TagStyle, Words};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::gcode::flavour::{Flavour, ProgramOptions, write_flavour};
use curvlay_toolpath::gcode::{Dialect, DirectionWords, Extrusion, Move, Tags, WriteError, WriteOptions, write_gcode};
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_toolpath::path::{InfillOptions, InfillPattern};
use curvlay_toolpath::travel::TravelOptions;
use nalgebra::{Point3, Vector3};
use std::io;

impl Settings {
    /// What is solid and what is not.
    pub fn infill(&self) -> InfillOptions {
        InfillOptions {
            density: self.density_percent / 100.0,
            walls: self.walls,
            skin: self.skin_layers,
            pattern: match self.infill_pattern {
                Sparse::Rows => InfillPattern::Rows,
                Sparse::Gyroid => InfillPattern::Gyroid,
            },
            turn: self.infill_turn_deg.to_radians(),
            ..InfillOptions::default()
        }
    }

    /// How material is laid.
    pub fn deposition(&self) -> DepositionOptions {
        DepositionOptions {
            filament_diameter: self.filament_diameter_mm,
            flow_mm3_s: self.flow_mm3_s,
            min_feed: self.min_feed_mm_s,
            max_feed: self.max_feed_mm_s,
            max_turn_rate: self.max_turn_rate_deg_s.to_radians(),
            travel_feed: self.travel_feed_mm_s,
            retraction: self.retraction_mm,
            retract_feed: self.retract_feed_mm_s,
            prime_feed: self.prime_feed_mm_s,
            ..DepositionOptions::default()
        }
    }

    /// How the nozzle is kept from gouging; `others` has what is no setting.
    pub fn gouging(&self, others: GougingOptions) -> GougingOptions {
        GougingOptions { max_turn_per_mm: self.max_turn_deg_mm.to_radians(), ..others }
    }

    /// How the nozzle travels.
    pub fn travel(&self) -> TravelOptions {
        TravelOptions { clearance: self.clearance_mm, min_lift: self.min_lift_mm, ..TravelOptions::default() }
    }

    /// Mass of so much material in grams, and its cost, where density and price are known.
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
            dialect: Dialect::Part(match self.dialect {
                Words::Comment => DirectionWords::Comment,
                Words::Ijk => DirectionWords::Ijk,
                Words::Dissertation => DirectionWords::Dissertation,
            }),
            extrusion: match self.extrusion {
                Count::Absolute => Extrusion::Absolute,
                Count::Relative => Extrusion::Relative,
            },
            tags: match self.tags {
                TagStyle::None => Tags::None,
                TagStyle::Prusa => Tags::Prusa,
                TagStyle::Cura => Tags::Cura,
            },
            line_numbers: self.line_numbers,
            nozzle_celsius: self.nozzle_celsius,
            bed_celsius: self.bed_celsius,
            fan: self.fan_share,
            header: start.as_deref().unwrap_or(default.header),
            footer: end.as_deref().unwrap_or(default.footer),
            ..default
        }
    }

    /// How the machine file is written in a flavour; with the name of the program and the [templates](Settings::templates).
    pub fn program_options<'a>(&self, name: &'a str, [start, end]: &'a [Option<String>; 2]) -> ProgramOptions<'a> {
        let WriteOptions { tags, nozzle_celsius, bed_celsius, fan, .. } = self.write_options(&[None, None]);
        let (start, finish) = (start.as_deref(), end.as_deref());
        ProgramOptions { name, tags, nozzle_celsius, bed_celsius, fan, start, finish, ..ProgramOptions::default() }
    }

    /// What would be wrong with a machine file in a flavour however the part looks: found before the work begins.
    ///
    /// # Errors
    /// [`WriteError`] of an option, a template or the flavour.
    pub fn check_flavour(&self, flavour: &Flavour) -> Result<(), WriteError> {
        let (templates, direction) = (self.templates(), Vector3::z_axis());
        let step = Move::Travel { tip: Point3::origin(), direction, feed_mm_s: 1.0 };
        write_flavour([step], flavour, &self.program_options("check", &templates), io::sink()).map(|_| ())
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
