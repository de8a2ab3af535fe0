//! What a program for an arm of Universal Robots drives its extruder by: one option, for every example that writes such programs.

use curvlay_kinematics::program::UrExtruder;
use std::net::Ipv4Addr;

/// The option.
#[derive(clap::Args, Clone, Copy, Debug, Default, PartialEq)]
pub struct UrExtruderArgs {
    /// What programs for arms of Universal Robots drive the extruder by: `outputs` (digital output 0 and analog output 0); `modbus:IP,UNIT,COIL,REGISTER,STEP`, a
    /// Modbus TCP server with a coil that switches it and a holding register with its speed, STEP mm/s a count; `socket:IP:PORT,RPM`, a TCP server that takes the
    /// lines START, STOP and RPM,X, with RPM turns a minute for 1 mm/s of filament
    #[arg(long, value_name = "KIND", default_value = "outputs", value_parser = ur_extruder)]
    pub ur_extruder: Choice,
}

/// A [`UrExtruder`], as it is written on a command line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choice(pub UrExtruder);

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.0 {
            UrExtruder::Outputs => f.write_str("outputs"),
            UrExtruder::Modbus { address, unit, switch, speed, step_mm_s } => {
                write!(f, "modbus:{address},{unit},{switch},{speed},{step_mm_s}")
            }
            UrExtruder::Socket { address, port, rpm_per_mm_s } => write!(f, "socket:{address}:{port},{rpm_per_mm_s}"),
        }
    }
}

/// Reads a choice.
/// ```
/// use curvlay_examples::args::ur_extruder;
/// use curvlay_kinematics::program::UrExtruder;
/// for text in ["outputs", "modbus:192.168.1.9,255,16,128,0.001", "socket:192.168.1.9:4000,2.5"] {
///     assert_eq!(ur_extruder(text)?.to_string(), text);
/// }
/// assert!(ur_extruder("modbus:192.168.1.9").is_err());
/// # Ok::<(), String>(())
/// ```
pub fn ur_extruder(text: &str) -> Result<Choice, String> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let words: Vec<&str> = rest.split(',').collect();
    let chosen = match (kind, &words[..]) {
        ("outputs", [""]) => UrExtruder::Outputs,
        ("modbus", &[address, unit, switch, speed, step]) => UrExtruder::Modbus {
            address: read(address, "IP", "an address such as 192.168.1.9")?,
            unit: read(unit, "UNIT", "a whole number from 0 to 255")?,
            switch: read(switch, "COIL", "a whole number from 0 to 65535")?,
            speed: read(speed, "REGISTER", "a whole number from 0 to 65535")?,
            step_mm_s: within(step, "STEP", [1e-6, 1e3])?,
        },
        ("socket", &[place, rpm]) => {
            let (address, port) = place.split_once(':').ok_or("it must be IP:PORT, such as 192.168.1.9:4000")?;
            let port: u16 = read(port, "PORT", "a whole number from 1 to 65535")?;
            if port == 0 {
                return Err("PORT must be a whole number from 1 to 65535".to_owned());
            }
            let address: Ipv4Addr = read(address, "IP", "an address such as 192.168.1.9")?;
            UrExtruder::Socket { address, port, rpm_per_mm_s: within(rpm, "RPM", [1e-3, 1e6])? }
        }
        _ => return Err("it must be outputs, modbus:IP,UNIT,COIL,REGISTER,STEP or socket:IP:PORT,RPM".to_owned()),
    };
    Ok(Choice(chosen))
}

fn read<T: std::str::FromStr>(word: &str, name: &str, need: &str) -> Result<T, String> {
    word.trim().parse().map_err(|_| format!("{name} is `{word}`; it must be {need}"))
}

fn within(word: &str, name: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = read(word, name, "a number")?;
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{name} is {value}; it must be from {min} to {max}"))
    }
}
