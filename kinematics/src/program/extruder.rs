//! Commands of the extruder's serial protocol: B. Brooks (2016), section 3.3.8.1, Table 3-6. A command is a line of ASCII.

use std::fmt;
use std::str::FromStr;

/// A command to the extruder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExtruderCommand {
    /// `FORWARDS`: the motor turns forwards from now on.
    Forwards,
    /// `REVERSE`: it turns backwards.
    Reverse,
    /// `START`: it turns.
    Start,
    /// `STOP`: it stands.
    Stop,
    /// `RPM,X`: its speed in turns a minute, 0 or more.
    Rpm(f64),
    /// `PULSEREV,X`: it turns backwards at full speed for so many milliseconds and then goes on, which takes the pressure out of the
    /// extruder between two strokes.
    PulseReverse(u32),
}

/// A line that is no command.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{line}` is no command of the extruder")]
pub struct ExtruderCommandError {
    /// The line, or its first 40 characters.
    pub line: String,
}

/// Greatest speed that is read or written, in turns a minute: far above any screw's.
const MAX_RPM: f64 = 1e4;

impl fmt::Display for ExtruderCommand {
    /// The line without its end. A speed out of range is written as the nearest that is, NaN as 0.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ExtruderCommand::Forwards => f.write_str("FORWARDS"),
            ExtruderCommand::Reverse => f.write_str("REVERSE"),
            ExtruderCommand::Start => f.write_str("START"),
            ExtruderCommand::Stop => f.write_str("STOP"),
            ExtruderCommand::Rpm(rpm) if rpm.is_nan() => f.write_str("RPM,0"),
            ExtruderCommand::Rpm(rpm) => write!(f, "RPM,{}", rpm.clamp(0.0, MAX_RPM)),
            ExtruderCommand::PulseReverse(ms) => write!(f, "PULSEREV,{ms}"),
        }
    }
}

impl FromStr for ExtruderCommand {
    type Err = ExtruderCommandError;

    /// Reads a line; white space around it does not matter.
    /// ```
    /// use curvlay_kinematics::program::ExtruderCommand;
    /// assert_eq!("RPM,4.5\r\n".parse(), Ok(ExtruderCommand::Rpm(4.5)));
    /// assert_eq!(ExtruderCommand::PulseReverse(250).to_string(), "PULSEREV,250");
    /// assert!("RPM,fast".parse::<ExtruderCommand>().is_err());
    /// ```
    fn from_str(line: &str) -> Result<Self, Self::Err> {
        let command = match line.trim().split_once(',') {
            None => match line.trim() {
                "FORWARDS" => Some(ExtruderCommand::Forwards),
                "REVERSE" => Some(ExtruderCommand::Reverse),
                "START" => Some(ExtruderCommand::Start),
                "STOP" => Some(ExtruderCommand::Stop),
                _ => None,
            },
            Some(("RPM", x)) => x.parse().ok().filter(|rpm| (0.0..=MAX_RPM).contains(rpm)).map(ExtruderCommand::Rpm),
            Some(("PULSEREV", x)) => x.parse().ok().map(ExtruderCommand::PulseReverse),
            Some(_) => None,
        };
        command.ok_or_else(|| ExtruderCommandError { line: line.trim().chars().take(40).collect() })
    }
}
