//! The controller's side of the link in RAPID: two modules, one for each of two tasks.
//!
//! Brooks (2016), section 3.2.1.3: an interrupt routine for each kind of data sets the speed, or moves and then acknowledges; a
//! quaternion of zeros sends the robot home. His messages came from ABB's PC SDK. Here a task in the background (*Multitasking*) reads
//! a socket (*PC Interface*) and fills a queue of persistent data; the task of the motion empties it. So the queue is filled while the
//! robot moves, which corners need. Interrupts pause the robot and let it go on, in the middle of a move.

use super::LinkFrame;
use super::frame::{FIELD, FIELDS, FIELDS_AT, KIND_AT};
use crate::program::WriteError;
use crate::program::check::check_option;
use crate::program::text::Text;
use crate::program::text::names::{Language, check_distinct, check_form, check_name};
use std::io::Write;

/// How the controller's side is written.
///
/// # On the controller
/// The module `NAME_link` belongs to a task of its own of the type `SEMISTATIC` or `STATIC`, the module `NAME_move` to the task of the
/// motion, as its main. Options: *PC Interface* and *Multitasking*. When a program starts again, the message at which it stopped is done
/// again: targets are absolute, only a `PULSEREV` would come twice.
///
/// # Signals
/// `START` and `STOP` are a digital output, `RPM` an analog one in turns a minute, `FORWARDS` and `REVERSE` a digital output that is 1
/// for backwards. `PULSEREV` turns backwards at `full_rpm`, then everything is as it was. They are given at rest, where strokes
/// begin and end. A pause stops the motor.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRapidOptions {
    /// Name of the modules, at most 20 characters. Default `curvlay`.
    pub name: String,
    /// Address of the controller's network port. Default `192.168.125.1`, the service port.
    pub address: String,
    /// TCP port, from 1025. Default 5000.
    pub port: u16,
    /// Places of the queue, 1 to 100: [`LinkOptions::queue`](super::LinkOptions::queue). Default 5.
    pub queue: u32,
    /// After so many seconds without a frame the connection is closed and another one taken. Default 30.
    pub silence_s: f64,
    /// The home position, in radians. Default 0: all joints in the middle.
    pub home: [f64; 6],
    /// Name of the tool, which the controller knows. Default `tool0`.
    pub tool: String,
    /// Name of the work object, which the controller knows. Default `wobj0`.
    pub work_object: String,
    /// The digital output of the extruder. Default `doExtruder`.
    pub signal: String,
    /// The digital output of its direction. Default `doExtruderReverse`.
    pub reverse_signal: String,
    /// The analog output of its speed. Default `aoExtruderRpm`.
    pub rpm_signal: String,
    /// Full speed, in turns a minute. Default 11, the thesis' motor.
    pub full_rpm: f64,
}

impl Default for LinkRapidOptions {
    fn default() -> Self {
        LinkRapidOptions {
            name: "curvlay".to_owned(),
            address: "192.168.125.1".to_owned(),
            port: 5000,
            queue: 5,
            silence_s: 30.0,
            home: [0.0; 6],
            tool: "tool0".to_owned(),
            work_object: "wobj0".to_owned(),
            signal: "doExtruder".to_owned(),
            reverse_signal: "doExtruderReverse".to_owned(),
            rpm_signal: "aoExtruderRpm".to_owned(),
            full_rpm: 11.0,
        }
    }
}

/// Persistent data that both tasks share, by their suffixes.
const SHARED: [&str; 8] = ["job", "taken", "done", "fault", "hold", "kind", "value", "word"];

/// Writes the two modules.
///
/// # Arguments
/// * `file`: opens a file of this name, `NAME_link.mod` or `NAME_move.mod`.
///
/// # Errors
/// [`WriteError::Name`] and [`WriteError::Option`](WriteError) before anything is opened, [`WriteError::Io`](WriteError) from the files.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::link::{LinkRapidOptions, write_link_rapid};
/// let mut names = Vec::new();
/// write_link_rapid(&LinkRapidOptions::default(), |name| {
///     names.push(name.to_owned());
///     Ok(std::io::sink())
/// })?;
/// assert_eq!(names, ["curvlay_link.mod", "curvlay_move.mod"]);
/// # Ok::<(), curvlay_kinematics::program::WriteError>(())
/// ```
pub fn write_link_rapid<W: Write>(
    options: &LinkRapidOptions,
    mut file: impl FnMut(&str) -> std::io::Result<W>,
) -> Result<(), WriteError> {
    check(options)?;
    for (part, template) in [("link", LINK), ("move", MOVE)] {
        let name = format!("{}_{part}.mod", options.name);
        let written = file(&name).and_then(|mut out| {
            out.write_all(filled(template, options).as_bytes())?;
            out.flush()
        });
        written.map_err(|source| WriteError::Io { file: name, source })?;
    }
    Ok(())
}

fn check(options: &LinkRapidOptions) -> Result<(), WriteError> {
    check_name(Language::Rapid, "name", &options.name, MAX_NAME)?;
    let mut names = vec![("name", options.name.as_str())];
    for (what, name, installed) in [("tool", &options.tool, "tool0"), ("work_object", &options.work_object, "wobj0")] {
        if name != installed {
            check_name(Language::Rapid, what, name, MAX_WORD)?;
        }
        names.push((what, name));
    }
    for (what, name) in
        [("signal", &options.signal), ("reverse_signal", &options.reverse_signal), ("rpm_signal", &options.rpm_signal)]
    {
        check_name(Language::Rapid, what, name, MAX_WORD)?;
        names.push((what, name));
    }
    check_distinct(&names)?;
    let prefix = format!("{}_", options.name.to_ascii_lowercase());
    if let Some((what, name)) = names[1..].iter().find(|(_, name)| name.to_ascii_lowercase().starts_with(&prefix)) {
        let need = "modules, routines and data of the link have such names; take another".to_owned();
        return Err(WriteError::Name { what, name: (*name).to_owned(), need });
    }
    let plain: String = options.address.chars().filter(|c| *c != '.' && *c != '-').collect();
    check_form("address", &format!("a{plain}"), MAX_WORD).map_err(|_| WriteError::Name {
        what: "address",
        name: options.address.clone(),
        need: "it must be an address such as 192.168.125.1".to_owned(),
    })?;
    let port = f64::from(options.port);
    check_option("port", port, port >= 1025.0, "it must be 1025 or more")?;
    check_option("queue", f64::from(options.queue), (1..=100).contains(&options.queue), "it must be from 1 to 100")?;
    let silence = options.silence_s;
    check_option("silence_s", silence, (1.0..=3600.0).contains(&silence), "it must be from 1 to 3600 s")?;
    check_option("full_rpm", options.full_rpm, (0.0..=1e4).contains(&options.full_rpm), "it must be from 0 to 10000")?;
    for joint in options.home {
        check_option("home", joint, joint.abs() <= 100.0, "its joints must be within 100 rad")?;
    }
    Ok(())
}

/// With the longest of our suffixes a name is as long as a word may be.
const MAX_NAME: usize = 20;
const MAX_WORD: usize = 32;

/// The template with `@words@` replaced.
fn filled(template: &str, options: &LinkRapidOptions) -> String {
    let text = |value: f64| {
        let mut text = Text::default();
        text.fixed(value, 6);
        String::from_utf8_lossy(&text.0).into_owned()
    };
    let repeated = |value: &str, count: usize| format!("[{}]", vec![value; count].join(","));
    let places = options.queue as usize;
    let values = repeated(&repeated("0", FIELDS), places);
    let words = repeated("\"\"", places);
    let name = &options.name;
    let initial = |suffix: &str| match suffix {
        "hold" => format!("  PERS bool {name}_hold:=FALSE;\n"),
        "kind" => format!("  PERS string {name}_kind{{{places}}}:={words};\n"),
        "value" => format!("  PERS num {name}_value{{{places},{FIELDS}}}:={values};\n"),
        "word" => format!("  PERS string {name}_word{{{places}}}:={words};\n"),
        number => format!("  PERS num {name}_{number}:=0;\n"),
    };
    let home: Vec<String> = options.home.iter().map(|joint| text(joint.to_degrees())).collect();
    let pairs: [(&str, String); 18] = [
        ("@shared@", SHARED.map(initial).concat()),
        ("@NAME@", name.clone()),
        ("@ADDRESS@", options.address.clone()),
        ("@PORT@", options.port.to_string()),
        ("@QUEUE@", places.to_string()),
        ("@SILENCE@", text(options.silence_s)),
        ("@BYTES@", LinkFrame::BYTES.to_string()),
        ("@NUMBER@", KIND_AT.to_string()),
        ("@KIND_AT@", (KIND_AT + 1).to_string()),
        ("@FIELDS_AT@", (FIELDS_AT + 1).to_string()),
        ("@FIELD@", FIELD.to_string()),
        ("@TWO@", (2 * FIELD).to_string()),
        ("@FIELDS@", FIELDS.to_string()),
        ("@HOME@", home.join(",")),
        ("@FRAME@", format!("{}\\WObj:={}", options.tool, options.work_object)),
        ("@DO@", options.signal.clone()),
        ("@REVERSE@", options.reverse_signal.clone()),
        ("@AO@", options.rpm_signal.clone()),
    ];
    let mut out = template.to_owned();
    for (word, value) in &pairs {
        out = out.replace(word, value);
    }
    out.replace("@FULL@", &text(options.full_rpm))
}

/// The task in the background: socket, frames, queue.
///
/// The order in which `taken`, `done` and `fault` change matters, for the other task reads them at any time: a queue that seems to
/// hold messages that are not there yet would be emptied. A message is in its place before `taken` counts it.
const LINK: &str = include_str!("link.mod.txt");

/// The task of the motion.
const MOVE: &str = include_str!("move.mod.txt");
