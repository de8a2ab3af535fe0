//! The rig and the process of a print on a dome, as data: what the thesis has as constants, from a JSON file (`--setup`).

use super::fault::fault;
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::input::read_text;
use curvlay_examples::json::JsonFault;
use curvlay_kinematics::nalgebra::Point3;
use curvlay_kinematics::program::{DomeOptions, DomeRig};
use curvlay_kinematics::{ArmModel, robots};
use curvlay_toolpath::drawing::{FillOptions, Profile};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Largest file that is read.
const MAX_BYTES: u64 = 1 << 20;
/// The version of the format.
const VERSION: u32 = 1;
/// Arms whose programs are RAPID, and whose bodies are known.
const ARMS: [(&str, &ArmModel); 2] = [("IRB120", &robots::IRB120), ("IRB1200", &robots::IRB1200)];
/// Lengths and speeds beyond are a slip.
const MOST: f64 = 1e5;
/// Most coefficients of a polynomial.
const MAX_COEFFICIENTS: usize = 24;

/// The rig and the process. What a file does not say is as in the thesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Setup {
    /// Of the format.
    version: u32,
    /// What the setup is called.
    name: Option<String>,
    /// The arm that holds the platform.
    arm: String,
    /// Where the flange is with the pole under the nozzle, in the base.
    home_mm: [f64; 3],
    /// Heights of the nozzle's tip and of the flange, in the frame of the platform, when the pole is under the nozzle.
    contact_height_mm: f64,
    flange_height_mm: f64,
    /// The dome that `--surface dome` means: its height over its radius, the coefficient of the lowest power first.
    dome_polynomial: Vec<f64>,
    /// The sphere that `--surface sphere` means.
    sphere_radius_mm: f64,
    /// Speeds of the nozzle over the platform, and down to a stroke and up from it.
    print_mm_s: f64,
    plunge_mm_s: f64,
    /// How far the platform goes down between two strokes.
    hop_mm: f64,
    /// How corners are rounded, in millimetres of the flange's way.
    corner_mm: f64,
    /// Nearer to the pole the platform turns evenly.
    pole_mm: f64,
    /// Turns of the extruder a minute for a bead of this width; in proportion for others.
    extruder_rpm: f64,
    extruder_bead_mm: f64,
    /// Height of fill over outlines that are printed before.
    fill_lift_mm: f64,
    /// Distance of scan lines from the bead of the outline, as a share of a bead, in addition to half a bead.
    fill_gap: f64,
}

impl Default for Setup {
    /// The thesis' rig and process: sections 3.3, 4.13, 4.15 and 6.4.2, and Eq. 3-1.
    fn default() -> Self {
        let (rig, options) = (DomeRig::BROOKS, DomeOptions::default());
        let Profile::Polynomial(dome_polynomial) = Profile::brooks() else { unreachable!("a polynomial") };
        Setup {
            version: VERSION,
            name: None,
            arm: "IRB120".to_owned(),
            home_mm: rig.home.coords.into(),
            contact_height_mm: rig.top,
            flange_height_mm: rig.effector,
            dome_polynomial,
            sphere_radius_mm: 200.0,
            print_mm_s: options.print_mm_s,
            plunge_mm_s: options.plunge_mm_s,
            hop_mm: options.hop_mm,
            corner_mm: options.corner_mm,
            pole_mm: options.pole_mm,
            extruder_rpm: 4.0,
            extruder_bead_mm: 3.2,
            fill_lift_mm: 0.2,
            fill_gap: FillOptions::default().gap,
        }
    }
}

impl Setup {
    /// The setup of the thesis, or that of a file.
    pub fn read(file: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = file else { return Ok(Setup::default()) };
        let text = read_text(path, MAX_BYTES)?;
        Setup::from_json(&text).map_err(|what| fault(path, what))
    }

    /// Reads a setup; what is wrong, with its line.
    fn from_json(text: &str) -> Result<Self, String> {
        let setup: Setup = serde_json::from_str(text).map_err(|error| {
            let JsonFault { line, column, what } = JsonFault::from(&error);
            // The parser names a key that is not known, and an end that is missing belongs to none.
            let is_value = error.is_data() && !what.starts_with("unknown field");
            let key = text.lines().nth(line.saturating_sub(1)).and_then(|text| key_before(text, column));
            let key = key.filter(|_| is_value);
            let key = key.map_or_else(String::new, |key| format!("`{key}`: "));
            format!("line {line}: {key}{what}")
        })?;
        setup.check().map_err(|(key, what)| {
            let line = text.lines().position(|line| line.contains(&format!("\"{key}\"")));
            let place = line.map_or_else(String::new, |line| format!("line {}: ", line + 1));
            format!("{place}`{key}` {what}")
        })?;
        Ok(setup)
    }

    /// The key of what is out of range, and what it must be.
    pub(super) fn check(&self) -> Result<(), (&'static str, String)> {
        if self.version != VERSION {
            return Err(("version", format!("is {}: this program reads version {VERSION}", self.version)));
        }
        if self.arm_model().is_none() {
            let known = ARMS.map(|(name, _)| name).join(", ");
            return Err(("arm", format!("is {}: known are {known}", self.arm)));
        }
        for (key, value) in [
            ("sphere_radius_mm", self.sphere_radius_mm),
            ("print_mm_s", self.print_mm_s),
            ("plunge_mm_s", self.plunge_mm_s),
            ("hop_mm", self.hop_mm),
            ("extruder_rpm", self.extruder_rpm),
            ("extruder_bead_mm", self.extruder_bead_mm),
        ] {
            if !(value > 0.0 && value <= MOST) {
                return Err((key, format!("is {value}: it must be above 0, and at most {MOST}")));
            }
        }
        let not_negative =
            [("corner_mm", self.corner_mm), ("pole_mm", self.pole_mm), ("fill_lift_mm", self.fill_lift_mm)];
        for (key, value, most) in
            not_negative.map(|(key, value)| (key, value, MOST)).into_iter().chain([("fill_gap", self.fill_gap, 10.0)])
        {
            if !(value >= 0.0 && value <= most) {
                return Err((key, format!("is {value}: it must be from 0 to {most}")));
            }
        }
        let heights = [("contact_height_mm", self.contact_height_mm), ("flange_height_mm", self.flange_height_mm)];
        for (key, value) in self.home_mm.map(|value| ("home_mm", value)).into_iter().chain(heights) {
            if value.abs() > MOST {
                return Err((key, format!("is {value}: it must be from -{MOST} to {MOST}")));
            }
        }
        let count = self.dome_polynomial.len();
        if !(1..=MAX_COEFFICIENTS).contains(&count) {
            let what = format!("has {}: it must have from 1 to {MAX_COEFFICIENTS}", counted(count, "coefficient"));
            return Err(("dome_polynomial", what));
        }
        Ok(())
    }

    fn arm_model(&self) -> Option<&'static ArmModel> {
        ARMS.iter().find(|(name, _)| *name == self.arm).map(|(_, model)| *model)
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        match &self.name {
            Some(name) => name,
            None if *self == Setup::default() => "thesis",
            None => "unnamed",
        }
    }

    /// The arm as the file names it.
    pub fn arm_name(&self) -> &str {
        &self.arm
    }

    /// The numbers of the arm.
    pub fn arm(&self) -> &'static ArmModel {
        self.arm_model().unwrap_or(&robots::IRB120)
    }

    /// The rig.
    pub fn rig(&self) -> DomeRig {
        DomeRig { top: self.contact_height_mm, effector: self.flange_height_mm, home: Point3::from(self.home_mm) }
    }

    /// The motion, with a nozzle of this height.
    pub fn options(&self, nozzle_mm: f64) -> DomeOptions {
        DomeOptions {
            print_mm_s: self.print_mm_s,
            plunge_mm_s: self.plunge_mm_s,
            hop_mm: self.hop_mm,
            corner_mm: self.corner_mm,
            pole_mm: self.pole_mm,
            nozzle_mm,
            ..DomeOptions::default()
        }
    }

    /// The dome.
    pub fn dome(&self) -> Profile {
        Profile::Polynomial(self.dome_polynomial.clone())
    }

    /// The sphere, with its pole where that of the dome is.
    pub fn sphere(&self) -> Profile {
        Profile::Sphere { radius: self.sphere_radius_mm, top: self.pole_height_mm() }
    }

    /// Height of the pole in the frame of the platform, of the dome and of all that stands in its place.
    pub fn pole_height_mm(&self) -> f64 {
        self.dome_polynomial[0]
    }

    pub fn print_mm_s(&self) -> f64 {
        self.print_mm_s
    }

    pub fn fill_gap(&self) -> f64 {
        self.fill_gap
    }

    pub fn fill_lift_mm(&self) -> f64 {
        self.fill_lift_mm
    }

    /// Turns of the extruder a minute for a millimetre of a bead's width.
    pub fn rpm_per_mm(&self) -> f64 {
        self.extruder_rpm / self.extruder_bead_mm
    }

    /// The setup as JSON, as a file has it.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// The last key of a setup in a line of a file before this column, in bytes, as the parser counts.
fn key_before(line: &str, column: usize) -> Option<&str> {
    let known = serde_json::to_value(Setup::default()).ok()?;
    line.get(..column.min(line.len()))?.split('"').rfind(|word| known.get(word).is_some())
}

#[cfg(test)]
mod tests {
    use super::Setup;

    #[test]
    fn what_is_wrong_is_named_with_line_and_key() {
        let read = |text: &str| Setup::from_json(text).unwrap_err();
        assert_eq!(read("{\n\"hop_mm\": -1}"), "line 2: `hop_mm` is -1: it must be above 0, and at most 100000");
        assert_eq!(read("{\"fill_gap\": 11}"), "line 1: `fill_gap` is 11: it must be from 0 to 10");
        assert_eq!(read("{\n\n\"arm\": \"UR3\"}"), "line 3: `arm` is UR3: known are IRB120, IRB1200");
        assert_eq!(read("{\"version\": 2}"), "line 1: `version` is 2: this program reads version 1");
        assert_eq!(
            read("{\"home_mm\": [0, 0, 1e6]}"),
            "line 1: `home_mm` is 1000000: it must be from -100000 to 100000"
        );
        let none = "line 1: `dome_polynomial` has 0 coefficients: it must have from 1 to 24";
        assert_eq!(read("{\"dome_polynomial\": []}"), none);
        assert!(read("{\n\"hopp_mm\": 3}").starts_with("line 2: unknown field `hopp_mm`, expected one of `version`"));
        assert!(read("{\n\"home_mm\": [1, 2]}").starts_with("line 2: `home_mm`: invalid length 2"));
        let text = "line 2: `hop_mm`: invalid type: string \"20\", expected f64";
        assert_eq!(read("{\n\"name\": \"üüüü\", \"hop_mm\": \"20\",\"pole_mm\":1}"), text);
        assert!(read("{\n\"hop_mm\": 3").starts_with("line 2: not JSON: EOF"));
        assert!(read("{\"hop_mm\": 3, \"speed\": 3}").starts_with("line 1: unknown field `speed`"));
    }

    #[test]
    fn a_setup_comes_back() {
        let setup = Setup::from_json("{\"hop_mm\": 12.5, \"arm\": \"IRB1200\", \"name\": \"a\"}").unwrap();
        assert_eq!((setup.hop_mm, setup.print_mm_s), (12.5, 20.0));
        assert_eq!(Setup::from_json(&setup.to_json()), Ok(setup));
        assert_eq!(Setup::from_json("{}"), Ok(Setup::default()));
    }
}
