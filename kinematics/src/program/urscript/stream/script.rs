//! The robot's side of the stream in URScript.

use super::VERSION;
use super::frame::{HEAD, NUMBERS, OF_TICK, SUM_ERROR};
use super::options::{MAX_RING, MIN_RING, UrStreamOptions};
use crate::program::WriteError;
use crate::program::check::check_option;
use crate::program::text::Text;
use crate::program::text::names::{Language, check_name};
use crate::program::urscript::extruder::{RPM, SPEED, STEP, SWITCH};
use crate::program::urscript::write::{check_options, write_full_scale, write_pose};
use crate::program::urscript::{DECIMALS, FULL_SCALE, MM_PER_M, UrExtruder, UrScriptOptions};
use std::io::Write;

/// Writes the program that the robot runs.
///
/// # Errors
/// [`WriteError::Name`] and [`WriteError::Option`](WriteError) before anything is written, [`WriteError::Io`](WriteError) from the writer.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::ur_stream::{UrStreamOptions, write_ur_stream};
/// let mut script = Vec::new();
/// write_ur_stream(&UrStreamOptions::default(), &mut script)?;
/// let script = String::from_utf8_lossy(&script);
/// assert!(script.starts_with("def curvlay():\n") && script.ends_with("\nend\n"));
/// assert!(script.contains("socket_open(\"127.0.0.1\",30050,\"stream\")"));
/// # Ok::<(), curvlay_kinematics::program::WriteError>(())
/// ```
pub fn write_ur_stream(options: &UrStreamOptions, mut out: impl Write) -> Result<(), WriteError> {
    check(options)?;
    let text = filled(options);
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|source| WriteError::Io { file: options.script.name.clone(), source })
}

fn check(options: &UrStreamOptions) -> Result<(), WriteError> {
    check_options(&options.script)?;
    check_name(Language::UrScript, "name", &options.script.name, 64)?;
    if options.script.name.starts_with(PREFIX) {
        let need = "variables of the stream have such names; take another".to_owned();
        return Err(WriteError::Name { what: "name", name: options.script.name.clone(), need });
    }
    let ring = f64::from(options.ring);
    check_option("port", f64::from(options.port), options.port > 0, "it must be from 1 to 65535")?;
    check_option("ring", ring, (MIN_RING..=MAX_RING).contains(&options.ring), "it must be from 12 to 960")?;
    let ranges = [
        ("max_step_rad", options.max_step_rad, [1e-4, 0.1], "it must be from 0.0001 to 0.1 rad"),
        ("max_gap_rad", options.max_gap_rad, [1e-4, 0.1], "it must be from 0.0001 to 0.1 rad"),
        ("max_move_rad", options.max_move_rad, [1e-4, std::f64::consts::TAU], "it must be from 0.0001 to 2 pi rad"),
        ("stop_s", options.stop_s, [0.05, 2.0], "it must be from 0.05 to 2 s"),
        ("silence_s", options.silence_s, [0.1, 60.0], "it must be from 0.1 to 60 s"),
    ];
    for (what, value, [min, max], need) in ranges {
        check_option(what, value, (min..=max).contains(&value), need)?;
    }
    Ok(())
}

/// What variables and functions of the program begin with.
const PREFIX: &str = "stream_";
/// Seconds between two replies.
const TELL_S: f64 = 0.04;
/// Seconds for which the robot waits for a sender at its end.
const WAIT_S: f64 = 5.0;

/// The template with `@words@` replaced.
fn filled(options: &UrStreamOptions) -> String {
    let script = &options.script;
    let number = |value: f64| {
        let mut text = Text::default();
        text.fixed(value, DECIMALS);
        String::from_utf8_lossy(&text.0).into_owned()
    };
    // With a point, so that no division is one of whole numbers.
    let with_point = |value: f64| {
        let text = number(value);
        if text.contains('.') { text } else { text + ".0" }
    };
    let ring = options.ring;
    let zeros = vec!["0.0"; ring as usize].join(",");
    let lists: String = (1..=OF_TICK).map(|k| format!("  global stream_{k}=[{zeros}]\n")).collect();
    let brake = options.rate.seconds() / options.stop_s;
    let low = ring / 3;
    let [speed_0, speed, on, off] = extruder(script);
    let remark = script.remark.as_ref().map_or_else(String::new, |remark| format!("  # {remark}\n"));
    let mut end = Text::default();
    script.extruder.write_end(&mut end);
    let pairs: [(&str, String); 31] = [
        ("@HEAD@", head(script)),
        ("@RING@", lists),
        ("@SPEED_0@", speed_0),
        ("@SPEED@", speed),
        ("@ON@", on),
        ("@OFF@", off),
        ("@END@", String::from_utf8_lossy(&end.0).into_owned()),
        ("@NAME@", script.name.clone()),
        ("@ADDRESS@", options.address.to_string()),
        ("@PORT@", options.port.to_string()),
        ("@VERSION@", VERSION.to_string()),
        ("@NUMBERS@", NUMBERS.to_string()),
        ("@HEAD_NUMBERS@", HEAD.to_string()),
        ("@OF_TICK@", OF_TICK.to_string()),
        ("@SUM_ERROR@", number(SUM_ERROR)),
        ("@PLACES@", ring.to_string()),
        ("@LOW@", with_point(f64::from(low))),
        ("@FILL@", (2 * low).to_string()),
        ("@BRAKE@", number(brake)),
        ("@LEAST@", number(0.5 * brake)),
        ("@SILENCE@", number(options.silence_s)),
        ("@TELL@", number(TELL_S)),
        ("@WAITS@", number((WAIT_S / TELL_S).round())),
        ("@MAX_STEP@", number(options.max_step_rad)),
        ("@MAX_GAP@", number(options.max_gap_rad)),
        ("@MAX_MOVE@", number(options.max_move_rad)),
        ("@STOP@", number(script.acceleration_rad_s2)),
        ("@PERIOD@", number(options.rate.seconds())),
        ("@LOOKAHEAD@", number(script.lookahead_s)),
        ("@GAIN@", number(script.gain)),
        // At last: it may contain one of these words.
        ("@REMARK@", remark),
    ];
    let mut out = TEMPLATE.to_owned();
    for (word, value) in &pairs {
        out = out.replace(word, value);
    }
    if script.starts { format!("{out}{}()\n", script.name) } else { out }
}

/// TCP, payload, and what the extruder needs. The frame of the targets has no use here.
fn head(script: &UrScriptOptions) -> String {
    let mut text = Text::default();
    let tcp = if script.part_in_hand { &script.work } else { &script.tool };
    text.word("  set_tcp(");
    write_pose(&mut text, tcp);
    text.word(")\n");
    if let Some(payload) = &script.payload {
        let centre = payload.centre.coords / MM_PER_M;
        text.word("  set_payload(").fixed(payload.mass_kg, DECIMALS).word(",");
        text.list(centre.as_slice(), DECIMALS).word(")\n");
    }
    script.extruder.write_head(&mut text);
    if script.extruder == UrExtruder::Outputs {
        write_full_scale(&mut text, script.filament_full_scale_mm_s);
    }
    let mut head = String::from_utf8_lossy(&text.0).into_owned();
    // Functions and threads read these.
    for name in [FULL_SCALE, STEP, RPM] {
        head = head.replace(&format!("  {name}="), &format!("  global {name}="));
    }
    head
}

/// Lines of the extruder: speed 0, the variable `speed`, on, off.
fn extruder(script: &UrScriptOptions) -> [String; 4] {
    let digital = |on: &str| format!("        set_standard_digital_out({},{on})\n", script.output);
    let coil = |on: &str| format!("        modbus_set_output_signal(\"{SWITCH}\",{on})\n");
    let line = |word: &str| format!("        socket_send_line(\"{word}\",\"{SWITCH}\")\n");
    match script.extruder {
        UrExtruder::Outputs => {
            let analog = |value: &str| format!("set_standard_analog_out({},{value})\n", script.filament_output);
            [
                format!("        {}", analog("0.0")),
                format!("      {}", analog(&format!("speed/{FULL_SCALE}"))),
                digital("True"),
                digital("False"),
            ]
        }
        UrExtruder::Modbus { .. } => {
            let register = |value: &str| format!("modbus_set_output_register(\"{SPEED}\",{value},False)\n");
            [
                format!("        {}", register("0")),
                format!("      {}", register(&format!("floor(speed/{STEP}+0.5)"))),
                coil("True"),
                coil("False"),
            ]
        }
        UrExtruder::Socket { .. } => [
            String::new(),
            format!("      socket_send_line(str_cat(\"RPM,\",to_str(speed*{RPM})),\"{SWITCH}\")\n"),
            line("START"),
            line("STOP"),
        ],
    }
}

/// The program. Threads change variables of each other without locks: each has one writer, and is changed last, when what it stands for is there.
const TEMPLATE: &str = include_str!("stream.script.txt");
