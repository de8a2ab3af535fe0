//! Which values a setting may have, for clap.

use crate::args::{above_zero, from_zero};
use curvlay_toolpath::gouging::{Nozzle, NozzleShape};

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
    Nozzle::new(nozzle_shape(shape)).map(|_| shape).map_err(|error| error.to_string())
}

/// The measures of a nozzle as `--nozzle` has them: tip flat (mm), half angle (degrees), height of the cone, block (mm).
pub fn nozzle_shape([tip_flat_mm, half_angle_deg, cone_height_mm, block_mm]: [f64; 4]) -> NozzleShape {
    NozzleShape { tip_flat_mm, half_angle: half_angle_deg.to_radians(), cone_height_mm, block_mm }
}

/// The nozzle where neither it nor the workcell is given, as `--nozzle` has it: the library's default.
pub fn default_nozzle() -> [f64; 4] {
    let NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm } = NozzleShape::default();
    [tip_flat_mm, half_angle.to_degrees(), cone_height_mm, block_mm]
}

/// Most walls, and layers of a skin.
pub(super) const MAX_COUNT: i64 = 10_000;

/// Longest length of a setting, in millimetres, and fastest speed, flow and turning, in their units a second: ten times what the largest
/// machines do. Beyond, a zero too many was typed, and figures of a run would overflow.
const MAX_LENGTH_MM: f64 = 1e4;
const MAX_RATE: f64 = 1e5;

/// Diameters of filament, in millimetres: of what is sold 1.75 and 2.85; pellets are counted as a filament of any.
const FILAMENT_MM: [f64; 2] = [0.1, 50.0];

fn at_most(value: f64, max: f64, unit: &str) -> Result<f64, String> {
    if value <= max { Ok(value) } else { Err(format!("must be at most {max} {unit}").trim_end().to_owned()) }
}

pub(super) fn length(text: &str) -> Result<f64, String> {
    at_most(above_zero(text)?, MAX_LENGTH_MM, "mm")
}

pub(super) fn distance(text: &str) -> Result<f64, String> {
    at_most(from_zero(text)?, MAX_LENGTH_MM, "mm")
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    at_most(above_zero(text)?, MAX_RATE, "")
}

pub(super) fn filament(text: &str) -> Result<f64, String> {
    let [min, max] = FILAMENT_MM;
    let value = above_zero(text)?;
    if (min..=max).contains(&value) { Ok(value) } else { Err(format!("must be from {min} to {max} mm")) }
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    let value = from_zero(text)?;
    if value <= 100.0 { Ok(value) } else { Err("must be from 0 to 100".to_owned()) }
}

pub(super) fn turn(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.abs() <= 360.0 { Ok(value) } else { Err("must be from -360 to 360".to_owned()) }
}

/// Densities of what is printed, in g/cm3: foams have 0.1, tungsten 19.3. Beyond, the unit is another.
const DENSITIES: [f64; 2] = [0.01, 25.0];

pub(super) fn material_density(text: &str) -> Result<f64, String> {
    let [min, max] = DENSITIES;
    let value = above_zero(text)?;
    if (min..=max).contains(&value) { Ok(value) } else { Err(format!("must be from {min} to {max} g/cm3")) }
}

#[cfg(test)]
mod tests {
    use super::{default_nozzle, nozzle_shape};
    use crate::settings::Settings;
    use clap::{Args, Command};
    use curvlay_toolpath::gouging::NozzleShape;

    /// The library alone says what nozzle there is by default; the help repeats it.
    #[test]
    fn the_default_nozzle_is_that_of_the_library() {
        let numbers = default_nozzle();
        assert_eq!(nozzle_shape(numbers), NozzleShape::default());
        let command = Settings::augment_args(Command::new("settings"));
        let help =
            command.get_arguments().find(|option| option.get_id() == "nozzle").and_then(|option| option.get_help());
        let named = format!("else {}]", numbers.map(|number| number.to_string()).join(","));
        assert!(help.unwrap().to_string().ends_with(&named), "{named}");
    }
}
