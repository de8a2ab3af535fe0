//! What a flavour says: every behaviour is a field.

/// A G-code flavour: what a controller reads, as plain data. With the feature `serde` it is a JSON object with these fields, all of them required.
///
/// Texts of lines are lists, a line each. In `heat_up`, `cool_down`, `begin`, `end` and in [`Commands`] names in braces are filled in; a line with a
/// name that has no value is left out, `{{` and `}}` are braces.
///
/// | name | in | value |
/// |---|---|---|
/// | `{name}` | `begin`, `end` | name of the program |
/// | `{nozzle}`, `{bed}`, `{fan}`, `{fan_share}` | `heat_up`, `cool_down` | degrees Celsius, fan of 255, fan from 0 to 1 |
/// | `{moves}`, `{filament_mm}`, `{seconds}` | `cool_down`, `end` | sums of the program |
/// | `{celsius}`, `{byte}`, `{share}`, `{seconds}`, `{milliseconds}`, `{tool}`, `{mm}`, `{newtons}` | the [command](Commands) that has it | its value |
/// | `{flow}` | [`FilamentWords::Flow`] | filament in mm/s times `scale` |
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Flavour {
    /// Name of the flavour, for messages and the first comment.
    pub name: String,
    /// Comments.
    pub comment: Comment,
    /// Ends of lines, their numbers and their length.
    pub lines: LineRules,
    /// Digits and signs.
    pub numbers: Numbers,
    /// Words of travels and beads.
    pub motion: Motion,
    /// Words of the machine's axes that are not just their letter; may be empty.
    pub axes: Vec<AxisWord>,
    /// How the direction of the nozzle is written.
    pub direction: Direction,
    /// Feed words and feed modes.
    pub feed: Feed,
    /// How the filament is written.
    pub filament: FilamentWords,
    /// Control of the tool centre point (TCP, RTCP).
    pub tcp: Tcp,
    /// Heat, fan, dwell, home, tools.
    pub commands: Commands,
    /// First lines of a program, before all others.
    pub begin: Vec<String>,
    /// Lines before the modes: heat up and home. [`ProgramOptions::start`](super::ProgramOptions::start) replaces them.
    pub heat_up: Vec<String>,
    /// Units, absolute positions and other modes, so that a program does not depend on what ran before it. No names in braces.
    pub modes: Vec<String>,
    /// Lines after the moves: heaters off. [`ProgramOptions::finish`](super::ProgramOptions::finish) replaces them.
    pub cool_down: Vec<String>,
    /// Last lines of a program.
    pub end: Vec<String>,
}

/// How a comment begins and ends.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Comment {
    /// What it begins with: `;` or `(`.
    pub open: String,
    /// What it ends with: `)`, or nothing for comments up to the end of the line.
    pub close: String,
}

/// Ends of lines, their numbers and their length.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct LineRules {
    /// Whether lines end with CR LF, else with LF.
    pub crlf: bool,
    /// Greatest length of a line without its end, in bytes, 32 to 16384. A line of words that is longer is an error; comments are cut.
    pub max_length: usize,
    /// Numbers of lines, if they have any.
    pub numbers: Option<LineNumbers>,
}

/// Numbers of lines.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct LineNumbers {
    /// What stands before the number: `N`, or nothing.
    pub prefix: String,
    /// Number of the first line.
    pub first: u64,
    /// How much a number is more than the one before, at least 1.
    pub step: u64,
    /// Whether lines with a comment alone have a number, too.
    pub comments: bool,
    /// Whether lines end with RepRap's checksum, `*` and all bytes before it joined by exclusive or.
    pub checksum: bool,
}

/// Digits behind the point (0 to 8 each), and signs. Zeros at the end of a number are not written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Numbers {
    /// Whether coordinates have a `+`, as Heidenhain wants it.
    pub plus: bool,
    /// Whether whole numbers have a point: `X10.`.
    pub point: bool,
    /// Digits of linear axes, millimetres.
    pub position: usize,
    /// Digits of rotary axes, degrees.
    pub angle: usize,
    /// Digits of the components of a direction.
    pub direction: usize,
    /// Digits of the filament: position, length or flow.
    pub filament: usize,
    /// Digits of a feed per minute.
    pub feed: usize,
    /// Digits of a feed that says the time of a move.
    pub time: usize,
}

/// Words of travels and beads.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Motion {
    /// What the line of a travel begins with: `G0`, `L`.
    pub travel: String,
    /// What the line of a bead begins with: `G1`, `LN`.
    pub print: String,
    /// Whether a travel has a feed. Without one the controller goes as fast as it can.
    pub travel_feed: bool,
    /// What the line of a travel ends with: `FMAX`; may be empty.
    pub travel_end: String,
    /// What the line of a bead ends with; may be empty.
    pub print_end: String,
}

/// The word of an axis of the machine.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct AxisWord {
    /// Letter of the axis in the machine's description.
    pub axis: char,
    /// What stands before the number: `B`, `C1=`.
    pub word: String,
    /// Factor of the number, of millimetres or degrees: -1 turns the sign. Not 0, at most 1e6.
    pub scale: f64,
}

/// How the direction of the nozzle is written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "by", rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Direction {
    /// Not at all: the nozzle stands upright, whatever the plan says. [`FlavourWritten::max_tilt`](super::FlavourWritten::max_tilt) says how much was left out.
    Upright,
    /// In a comment behind the words, `;DIR:0 0.6 0.8`. The machine stands upright, simulators see the direction.
    Comment,
    /// As a vector of three words, from the tip into the nozzle.
    Vector {
        /// What stands before each number: `A3=`, `B3=`, `C3=`.
        words: [String; 3],
    },
    /// By rotary axes of the machine: the flavour takes [axis moves](super::AxisMove) alone.
    Axes,
}

/// Feed words and feed modes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Feed {
    /// What stands before a feed per minute: `F`.
    pub word: String,
    /// The line that switches to feeds per minute, `G94`; empty where there is no other mode.
    pub per_minute: String,
    /// What a feed per minute is of.
    pub of: FeedOf,
    /// Greatest number of a feed per minute, above 0.
    pub max: f64,
    /// How a line says how long it takes, if the controller knows such a mode.
    pub time: Option<TimeFeed>,
    /// Whether the time is said for each move of the axes, else only where a feed per minute cannot say it.
    pub prefer_time: bool,
}

/// What a feed per minute is of: how the controller measures the way of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum FeedOf {
    /// As RS274/NGC: of X, Y and Z; where they stand, of the other linear axes (U, V, W); where these stand, too, of the rotary axes in degrees, by the
    /// square root of the sum of squares.
    LinearFirst,
    /// Of X, Y and Z; where they stand, of the one axis that goes farthest in millimetres or degrees, the extruder among them.
    LinearThenLargest,
    /// Of X, Y and Z alone: where they stand, it says nothing.
    LinearOnly,
    /// Of all axes but the extruder, millimetres and degrees alike, by the square root of the sum of squares.
    AllAxes,
}

/// A feed that says how long a line takes. Each line that moves anything has one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct TimeFeed {
    /// The line that switches to it, `G93`; empty where the word says it alone.
    pub on: String,
    /// What stands before the number: `F`, `FT`.
    pub word: String,
    /// Whether the number is seconds, else one over minutes.
    pub seconds: bool,
}

/// How the filament is written.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "by", rename_all = "snake_case", deny_unknown_fields)
)]
pub enum FilamentWords {
    /// Not at all.
    None,
    /// As an axis: `E`, or a further axis of the machine such as `A` or `U`.
    Axis {
        /// What stands before the number: `E`, `U=IC(`.
        word: String,
        /// What stands behind it; may be empty.
        close: String,
        /// Factor of the number, of millimetres of filament. Not 0, at most 1e6.
        scale: f64,
        /// Whether a number is the length of its own line, else a position.
        relative: bool,
        /// The line that says how numbers count: `M82`, `M83`; may be empty.
        mode: String,
        /// The line that calls the present position 0, `G92 E0`; empty for controllers without such a line: positions grow without end there.
        zero: String,
        /// How many millimetres of filament the position may reach before it is set back to 0, from 10 up; needs `zero`.
        reset_mm: Option<f64>,
    },
    /// By a signal that the controller gives out in step with its motion, proportional to the speed of the filament.
    Flow {
        /// The line before a move that changes the flow with its beginning: `M67 E0 Q{flow}`.
        change: String,
        /// The line that changes it while all stands still: `M68 E0 Q{flow}`. Retractions are a dwell at such a flow.
        at_once: String,
        /// Factor of the number, of mm/s of filament. Not 0, at most 1e6.
        scale: f64,
    },
    /// By a signal that is on while material leaves. Retractions are not written.
    Switch {
        /// The line that switches it on.
        on: String,
        /// The line that switches it off.
        off: String,
    },
}

/// Control of the tool centre point: X, Y and Z are those of the tip, and the controller moves the axes under it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Tcp {
    /// Lines that switch it on, after the modes; empty for controllers without.
    pub on: Vec<String>,
    /// Lines that switch it off, after the last move.
    pub off: Vec<String>,
}

/// Commands of a machine that stands still. A command of heat, fan or home without lines becomes a comment; one of tools and tapes is an error.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Commands {
    /// To the machine's home.
    pub home: Vec<String>,
    /// Everything waits: `{seconds}`, `{milliseconds}`.
    pub dwell: Vec<String>,
    /// Temperature of the nozzle: `{celsius}`.
    pub nozzle: Vec<String>,
    /// The same, and wait until it is reached.
    pub nozzle_wait: Vec<String>,
    /// Temperature of the plate: `{celsius}`.
    pub bed: Vec<String>,
    /// The same, and wait until it is reached.
    pub bed_wait: Vec<String>,
    /// The fan: `{share}` from 0 to 1, `{byte}` from 0 to 255.
    pub fan: Vec<String>,
    /// Tool change: `{tool}` is 0 for the nozzle, 1 for the roller, 2 for the roller of conductors.
    pub tool: Vec<String>,
    /// Tape is pushed out: `{mm}`.
    pub tape_feed: Vec<String>,
    /// The roller presses: `{newtons}`.
    pub press: Vec<String>,
    /// Temperature of the roller: `{celsius}`.
    pub roller: Vec<String>,
    /// The same, and wait until it is reached.
    pub roller_wait: Vec<String>,
    /// The tape is cut.
    pub cut: Vec<String>,
}
