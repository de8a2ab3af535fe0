//! How a URScript program drives the extruder: what stands at its head and for each signal.
//!
//! *Script Manual* (Universal Robots, e-Series SW 5.x), modules interfaces: `modbus_add_signal(IP, slave_number, signal_address, signal_type,
//! signal_name)` with the types 1 (coil) and 3 (holding register), `modbus_set_signal_update_frequency`, `modbus_set_output_signal`,
//! `modbus_set_output_register`, `socket_open`, `socket_send_line`, `socket_close`.

use super::{DECIMALS, FULL_SCALE, UrScriptOptions};
use crate::program::check::{MAX_NUMBER, check_option};
use crate::program::text::Text;
use crate::program::{ExtruderCommand, WriteError};
use std::net::Ipv4Addr;

/// What a URScript program drives the extruder by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum UrExtruder {
    /// A standard digital output and a standard analog one ([`UrScriptOptions`]).
    #[default]
    Outputs,
    /// Signals of a Modbus TCP server, such as a motor controller or a PLC. The program adds them when it starts, under the names `extruder` and `filament`,
    /// and has them sent as often as the controller can, 125 times a second.
    Modbus {
        /// Address of the server.
        address: Ipv4Addr,
        /// Its unit (slave) number, 255 for most that have none.
        unit: u8,
        /// Coil that switches the extruder.
        switch: u16,
        /// Holding register of the filament's speed.
        speed: u16,
        /// The speed for one count of the register, in mm/s, from 1e-6 to 1000: the register holds speed over step, rounded, up to 65535. It stands in the
        /// program as `filament_step`.
        step_mm_s: f64,
    },
    /// A TCP server that takes lines of the extruder's serial protocol ([`ExtruderCommand`]): `START`, `STOP` and `RPM,X`. The program opens the connection
    /// when it starts and closes it at its end.
    Socket {
        /// Address of the server.
        address: Ipv4Addr,
        /// Its port, 1 to 65535.
        port: u16,
        /// Turns a minute for a speed of the filament of 1 mm/s, from 1e-3 to 1e6. It stands in the program as `rpm_per_mm_s`.
        rpm_per_mm_s: f64,
    },
}

/// Names of the Modbus signals, and of the socket.
pub(super) const SWITCH: &str = "extruder";
pub(super) const SPEED: &str = "filament";
/// Variables.
pub(super) const STEP: &str = "filament_step";
pub(super) const RPM: &str = "rpm_per_mm_s";

/// Types of Modbus signals.
const COIL: f64 = 1.0;
const REGISTER: f64 = 3.0;
/// Updates a second, the most that the controller takes.
const UPDATES: f64 = 125.0;
/// Greatest number of a register.
pub(super) const MAX_COUNT: f64 = 65535.0;
/// Greatest speed that [`ExtruderCommand`] writes, in turns a minute.
const MAX_RPM: f64 = 1e4;

impl UrExtruder {
    /// The fastest filament that the signal holds, in mm/s.
    pub(super) fn max_mm_s(&self, options: &UrScriptOptions) -> f64 {
        match *self {
            UrExtruder::Outputs => options.filament_full_scale_mm_s,
            UrExtruder::Modbus { step_mm_s, .. } => step_mm_s * MAX_COUNT,
            UrExtruder::Socket { rpm_per_mm_s, .. } => (MAX_RPM / rpm_per_mm_s).min(MAX_NUMBER),
        }
    }

    pub(super) fn check(&self) -> Result<(), WriteError> {
        match *self {
            UrExtruder::Outputs => Ok(()),
            UrExtruder::Modbus { step_mm_s, .. } => {
                let fits = (1e-6..=1e3).contains(&step_mm_s);
                check_option("extruder.step_mm_s", step_mm_s, fits, "it must be from 1e-6 to 1000 mm/s")
            }
            UrExtruder::Socket { port, rpm_per_mm_s, .. } => {
                check_option("extruder.port", f64::from(port), port > 0, "it must be from 1 to 65535")?;
                let fits = (1e-3..=1e6).contains(&rpm_per_mm_s);
                check_option("extruder.rpm_per_mm_s", rpm_per_mm_s, fits, "it must be from 0.001 to 1e6")
            }
        }
    }

    /// What stands at the head of a program.
    pub(super) fn write_head(&self, text: &mut Text) {
        match *self {
            UrExtruder::Outputs => {}
            UrExtruder::Modbus { address, unit, switch, speed, step_mm_s } => {
                let signals = [(SWITCH, switch, COIL), (SPEED, speed, REGISTER)];
                for (name, number, kind) in signals {
                    text.word("  modbus_add_signal(\"")
                        .word(&address.to_string())
                        .word("\",")
                        .fixed(f64::from(unit), 0);
                    text.word(",").fixed(f64::from(number), 0).word(",").fixed(kind, 0);
                    text.word(",\"").word(name).word("\")\n");
                }
                for (name, ..) in signals {
                    text.word("  modbus_set_signal_update_frequency(\"").word(name).word("\",").fixed(UPDATES, 0);
                    text.word(")\n");
                }
                text.word("  ").word(STEP).word("=").fixed(step_mm_s, DECIMALS).word("\n");
            }
            UrExtruder::Socket { address, port, rpm_per_mm_s } => {
                text.word("  socket_open(\"").word(&address.to_string()).word("\",").fixed(f64::from(port), 0);
                text.word(",\"").word(SWITCH).word("\")\n  ").word(RPM).word("=");
                text.fixed(rpm_per_mm_s, DECIMALS).word("\n");
            }
        }
    }

    /// The extruder goes on or off.
    pub(super) fn write_switch(&self, text: &mut Text, on: bool, options: &UrScriptOptions) {
        let truth = if on { ",True)\n" } else { ",False)\n" };
        match self {
            UrExtruder::Outputs => {
                text.word("  set_standard_digital_out(").fixed(f64::from(options.output), 0).word(truth);
            }
            UrExtruder::Modbus { .. } => {
                text.word("  modbus_set_output_signal(\"").word(SWITCH).word("\"").word(truth);
            }
            UrExtruder::Socket { .. } => {
                write_line(text, if on { ExtruderCommand::Start } else { ExtruderCommand::Stop });
            }
        }
    }

    /// The filament takes a speed.
    pub(super) fn write_speed(&self, text: &mut Text, mm_s: f64, options: &UrScriptOptions) {
        match *self {
            UrExtruder::Outputs => {
                text.word("  set_standard_analog_out(").fixed(f64::from(options.filament_output), 0).word(",");
                text.fixed(mm_s, DECIMALS).word("/").word(FULL_SCALE).word(")\n");
            }
            UrExtruder::Modbus { step_mm_s, .. } => {
                text.word("  modbus_set_output_register(\"").word(SPEED).word("\",");
                text.fixed((mm_s / step_mm_s).round(), 0).word(",False)\n");
            }
            UrExtruder::Socket { rpm_per_mm_s, .. } => write_line(text, ExtruderCommand::Rpm(mm_s * rpm_per_mm_s)),
        }
    }

    /// What stands at the end of a program.
    pub(super) fn write_end(&self, text: &mut Text) {
        if matches!(self, UrExtruder::Socket { .. }) {
            text.word("  socket_close(\"").word(SWITCH).word("\")\n");
        }
    }
}

fn write_line(text: &mut Text, command: ExtruderCommand) {
    text.word("  socket_send_line(\"").word(&command.to_string()).word("\",\"").word(SWITCH).word("\")\n");
}
