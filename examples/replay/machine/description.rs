//! A five-axis printer as a JSON file.

use super::super::axes::Limits;
use super::rotary::Rotary;
use super::rotary_axis::RotaryAxis;
use nalgebra::Vector3;
use serde::Deserialize;

/// What stands in the file; what is left out is that of the default machine.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default = "File::name")]
    name: String,
    tilt: Axis,
    turn: Axis,
    #[serde(default = "File::nozzle")]
    nozzle: [f64; 3],
    #[serde(default)]
    linear: Linear,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Axis {
    letter: char,
    axis: [f64; 3],
    #[serde(default)]
    centre_mm: [f64; 3],
    min_deg: Option<f64>,
    max_deg: Option<f64>,
    max_speed_deg_s: Option<f64>,
    max_acceleration_deg_s2: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Linear {
    max_speed_mm_s: f64,
    max_acceleration_mm_s2: f64,
}

impl Default for Linear {
    /// 150 mm/s and 1500 mm/s2: a printer with a heavy table. Marlin's example configurations have 300 and 3000 for light ones.
    fn default() -> Self {
        Linear { max_speed_mm_s: 150.0, max_acceleration_mm_s2: 1500.0 }
    }
}

impl File {
    fn name() -> String {
        "five-axis printer".to_owned()
    }

    fn nozzle() -> [f64; 3] {
        [0.0, 0.0, 1.0]
    }
}

/// Acceleration of a rotary axis of which nothing is said, in rad/s2: a table that reaches a turn a second in a third of a second.
const ROTARY_RAD_S2: f64 = 20.0;

impl Default for Rotary {
    /// The machine for which `curved_layers --rotary` writes: B about y, -110 to 110 degrees at 1 rad/s, C about z without limits at 2 rad/s, both
    /// through the origin of the part.
    fn default() -> Self {
        let Linear { max_speed_mm_s: speed, max_acceleration_mm_s2: acceleration } = Linear::default();
        let mut limits = Limits::NONE;
        for k in 0..3 {
            (limits.speed[k], limits.acceleration[k]) = (speed, acceleration);
        }
        (limits.lower[3], limits.upper[3]) = (-110f64.to_radians(), 110f64.to_radians());
        (limits.speed[3], limits.speed[4]) = (1.0, 2.0);
        (limits.acceleration[3], limits.acceleration[4]) = (ROTARY_RAD_S2, ROTARY_RAD_S2);
        let origin = Vector3::zeros();
        Rotary {
            name: "table that tilts (B) and turns (C)".to_owned(),
            tilt: RotaryAxis { letter: 'B', axis: Vector3::y(), centre: origin },
            turn: RotaryAxis { letter: 'C', axis: Vector3::z(), centre: origin },
            nozzle: Vector3::z(),
            limits,
        }
    }
}

fn axis(field: &str, file: &Axis, k: usize, limits: &mut Limits) -> Result<RotaryAxis, String> {
    let letter = file.letter.to_ascii_uppercase();
    if !matches!(letter, 'A' | 'B' | 'C' | 'U' | 'V' | 'W') {
        return Err(format!("{field}.letter is `{letter}`: it must be A, B, C, U, V or W"));
    }
    let direction = Vector3::from(file.axis);
    let direction = direction.try_normalize(1e-12).filter(|axis| axis.iter().all(|x| x.is_finite()));
    let direction = direction.ok_or_else(|| format!("{field}.axis is {:?}: it must not be zero", file.axis))?;
    if !file.centre_mm.iter().all(|x| x.abs() <= 1e6) {
        return Err(format!("{field}.centre_mm is {:?}: numbers within 1e6", file.centre_mm));
    }
    let (low, high) = (file.min_deg.unwrap_or(f64::NEG_INFINITY), file.max_deg.unwrap_or(f64::INFINITY));
    if low.is_nan() || high.is_nan() || low >= high {
        return Err(format!("{field}: min_deg {low} must be below max_deg {high}"));
    }
    (limits.lower[k], limits.upper[k]) = (low.to_radians(), high.to_radians());
    let above_zero = |name: &str, value: Option<f64>, default: f64| match value {
        Some(value) if value > 0.0 && value.is_finite() => Ok(value.to_radians()),
        Some(value) => Err(format!("{field}.{name} is {value}: it must be above 0")),
        None => Ok(default),
    };
    limits.speed[k] = above_zero("max_speed_deg_s", file.max_speed_deg_s, f64::INFINITY)?;
    limits.acceleration[k] = above_zero("max_acceleration_deg_s2", file.max_acceleration_deg_s2, ROTARY_RAD_S2)?;
    Ok(RotaryAxis { letter, axis: direction, centre: file.centre_mm.into() })
}

impl Rotary {
    /// Reads the description of a machine.
    ///
    /// # Errors
    /// One line with the field, or with line and column.
    pub fn from_json(text: &[u8]) -> Result<Self, String> {
        let file: File = serde_json::from_slice(text).map_err(|error| error.to_string())?;
        let mut limits = Limits::NONE;
        let (tilt, turn) = (axis("tilt", &file.tilt, 3, &mut limits)?, axis("turn", &file.turn, 4, &mut limits)?);
        if tilt.letter == turn.letter {
            return Err(format!("tilt.letter and turn.letter are both `{}`: two axes need two letters", tilt.letter));
        }
        if tilt.axis.cross(&turn.axis).norm() < 1e-3 {
            return Err("tilt.axis and turn.axis are parallel: such a table only turns".to_owned());
        }
        let nozzle = Vector3::from(file.nozzle).try_normalize(1e-12).filter(|axis| axis.iter().all(|x| x.is_finite()));
        let nozzle = nozzle.ok_or_else(|| format!("nozzle is {:?}: it must not be zero", file.nozzle))?;
        let Linear { max_speed_mm_s: speed, max_acceleration_mm_s2: acceleration } = file.linear;
        for (name, value) in [("max_speed_mm_s", speed), ("max_acceleration_mm_s2", acceleration)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(format!("linear.{name} is {value}: it must be above 0"));
            }
        }
        for k in 0..3 {
            (limits.speed[k], limits.acceleration[k]) = (speed, acceleration);
        }
        Ok(Rotary { name: file.name, tilt, turn, nozzle, limits })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"tilt": {"letter": "A", "axis": [1, 0, 0], "centre_mm": [0, 0, -30], "min_deg": -30, "max_deg": 120},
        "turn": {"letter": "C", "axis": [0, 0, 2], "max_speed_deg_s": 90}}"#;

    #[test]
    fn a_description_is_read() {
        let machine = Rotary::from_json(GOOD.as_bytes()).unwrap();
        assert_eq!((machine.tilt.letter, machine.tilt.centre.z, machine.turn.axis.z), ('A', -30.0, 1.0));
        assert!((machine.limits.speed[4] - 90f64.to_radians()).abs() < 1e-12 && machine.limits.speed[3].is_infinite());
    }

    #[test]
    fn faults_name_their_field() {
        let fault = |from: &str, to: &str| Rotary::from_json(GOOD.replacen(from, to, 1).as_bytes()).unwrap_err();
        assert!(fault("\"A\"", "\"C\"").contains("tilt.letter and turn.letter are both `C`"));
        assert!(fault("\"A\"", "\"X\"").starts_with("tilt.letter is `X`"));
        assert!(fault("[1, 0, 0]", "[0, 0, 0]").starts_with("tilt.axis"));
        assert!(fault("[1, 0, 0]", "[0, 0, 1]").contains("parallel"));
        assert!(fault("-30, \"max", "130, \"max").contains("min_deg 130 must be below max_deg 120"));
        assert!(fault("90", "0").contains("turn.max_speed_deg_s is 0"));
        assert!(fault("\"tilt\"", "\"tild\"").contains("unknown field `tild`"));
    }
}
