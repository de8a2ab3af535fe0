//! Moves of a machine's axes in the flavour of its controller.

use super::axis_move::{AxisMove, MachineAxis};
use super::check::reserved_letter;
use super::data::{AxisWord, Direction, FilamentWords, Flavour};
use super::error::FlavourError;
use super::feed::{Class, Part, length};
use super::options::{FlavourWritten, ProgramOptions};
use super::program::{Block, Program, Speed, TIME};
use super::words::push;
use crate::gcode::rotary::DEGREES;
use crate::gcode::text::{Text, steps};
use crate::gcode::write::number;
use crate::gcode::{COORDINATE, FILAMENT, Move, WriteError};
use nalgebra::{Point3, Vector3};
use std::io::Write;

/// Writes a program of moves of a machine's axes in a flavour.
///
/// # Arguments
/// * `machine`: its axes, in the order of the values of each move. Their words are those of [`Flavour::axes`], else their letters.
/// * `moves`: the first that goes anywhere, and the first after [`Move::Home`], is an [`AxisMove::Travel`].
///
/// Whether X, Y and Z are joint positions or the tip's is the machine's affair; the flavour switches TCP on and off. How long a move takes is said by a feed per
/// minute where that controller's meaning of it ([`FeedOf`](super::FeedOf)) can say it to 0.1 %, else, or if the flavour prefers it, by the time; where the flavour has no word for a
/// time, [`FlavourWritten::untimed`] counts the moves.
///
/// # Errors
/// [`WriteError`] names the move, the axis, or the field of the flavour that cannot be.
///
/// # Cost
/// Constant memory, `O(1)` a move. Goes out in pieces of about 32 KiB.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::flavour::{AxisMove, Flavour, MachineAxis, ProgramOptions, write_axis_moves};
/// let machine = ["X", "Y", "Z"].map(|letter| MachineAxis::linear(letter.chars().next().unwrap_or('X')));
/// let machine = [machine[0], machine[1], machine[2], MachineAxis::rotary('B'), MachineAxis::rotary('C')];
/// let moves = [
///     AxisMove::Travel { axes: [1.0, 2.0, 3.0, 0.0, 0.0], seconds: 1.0 },
///     AxisMove::Print { axes: [1.5, 2.0, 3.0, 0.1, -0.2], seconds: 0.5, filament_mm: 0.02 },
/// ];
/// let flavour = Flavour::built_in("linuxcnc").ok_or("not built in")?;
/// let mut file = Vec::new();
/// write_axis_moves(&machine, moves, &flavour, &ProgramOptions::default(), &mut file)?;
/// let file = String::from_utf8(file)?;
/// assert!(file.contains("G0 X1 Y2 Z3 B0 C0\nG93\nG1 X1.5 Y2 Z3 B5.72958 C-11.45916 A0.02 F120\n"), "{file}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_axis_moves<const N: usize>(
    machine: &[MachineAxis; N],
    moves: impl IntoIterator<Item = AxisMove<N>>,
    flavour: &Flavour,
    options: &ProgramOptions<'_>,
    out: impl Write,
) -> Result<FlavourWritten, WriteError> {
    let program = Program::new(flavour, options, out)?;
    let axes = axes_of(machine, flavour)?;
    let words: Vec<&str> = axes.iter().map(|axis| axis.word.as_str()).collect();
    let title = format!("curvlay, flavour {}: axes {}; mm, degrees", flavour.name, words.join(" "));
    let mut writer = AxisWriter { program, axes, at: None };
    writer.program.begin(&title)?;
    for (index, item) in (0..).zip(moves) {
        writer.program.result.written.moves = index + 1;
        writer.write(index, &item)?;
    }
    writer.program.finish()
}

/// An axis as it is written.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub letter: char,
    pub word: String,
    pub scale: f64,
    pub is_rotary: bool,
    pub decimals: usize,
}

impl Axis {
    fn new(MachineAxis { letter, is_rotary }: MachineAxis, flavour: &Flavour) -> Self {
        let given = flavour.axes.iter().find(|word| word.axis == letter);
        let decimals = if is_rotary { flavour.numbers.angle } else { flavour.numbers.position };
        let AxisWord { word, scale, .. } =
            given.cloned().unwrap_or_else(|| AxisWord { axis: letter, word: letter.to_string(), scale: 1.0 });
        Axis { letter, word, scale, is_rotary, decimals }
    }

    /// A number of the file, from millimetres or radians.
    fn number(&self, value: f64) -> f64 {
        self.scale * if self.is_rotary { value.to_degrees() } else { value }
    }

    /// Millimetres or radians, from a number of the file.
    pub fn value(&self, number: f64) -> f64 {
        let value = number / self.scale;
        if self.is_rotary { value.to_radians() } else { value }
    }
}

/// The axes of a machine with their words, where the flavour takes them.
pub(super) fn axes_of<const N: usize>(
    machine: &[MachineAxis; N],
    flavour: &Flavour,
) -> Result<[Axis; N], FlavourError> {
    flavour.check_machine(machine)?;
    Ok(machine.map(|axis| Axis::new(axis, flavour)))
}

impl Flavour {
    /// Whether a machine of these axes goes with the flavour: letters and words of its axes, which [`write_axis_moves`] checks before its first line.
    ///
    /// # Errors
    /// [`FlavourError`]: the flavour cannot be, takes no axes, names an axis that the machine lacks, or a word would be read as something else.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gcode::flavour::{Flavour, MachineAxis};
    /// let flavour = Flavour::built_in("linuxcnc").ok_or("not built in")?;
    /// assert!(flavour.check_machine(&[MachineAxis::linear('X'), MachineAxis::rotary('B')]).is_ok());
    /// let error = flavour.check_machine(&[MachineAxis::linear('X'), MachineAxis::rotary('M')]).unwrap_err();
    /// assert!(error.to_string().contains("controllers read M as something else than an axis"), "{error}");
    /// # Ok::<(), &str>(())
    /// ```
    pub fn check_machine(&self, machine: &[MachineAxis]) -> Result<(), FlavourError> {
        self.check()?;
        let wrong =
            |field: &str, problem: String| FlavourError { flavour: self.name.clone(), field: field.into(), problem };
        if self.direction != Direction::Axes {
            let problem = "the flavour takes tip and direction; moves of axes need `axes`".into();
            return Err(wrong("direction.by", problem));
        }
        if machine.is_empty() {
            return Err(wrong("axes", "the machine has no axis".into()));
        }
        if let Some(word) = self.axes.iter().find(|word| !machine.iter().any(|axis| axis.letter == word.axis)) {
            let letters: String = machine.iter().map(|axis| axis.letter).collect();
            return Err(wrong("axes", format!("the machine has no axis {}: it has {letters}", word.axis)));
        }
        let axes: Vec<Axis> = machine.iter().map(|axis| Axis::new(*axis, self)).collect();
        check_axes(&axes, self).map_err(|(field, problem)| wrong(field, problem))
    }
}

/// No two words of a line are the same.
fn check_axes(axes: &[Axis], flavour: &Flavour) -> Result<(), (&'static str, String)> {
    let same = |a: &str, b: &str| a.trim_end_matches(['=', '(']).eq_ignore_ascii_case(b.trim_end_matches(['=', '(']));
    for (k, axis) in axes.iter().enumerate() {
        if !axis.letter.is_ascii_uppercase() {
            return Err(("axes", format!("the letter `{}` of the machine is not A to Z", axis.letter)));
        }
        if let Some(letter) = reserved_letter(&axis.word) {
            let problem = format!(
                "controllers read {letter} as something else than an axis: give axis {} another letter, or a word in `axes`",
                axis.letter
            );
            return Err(("axes", problem));
        }
        if axes[..k].iter().any(|other| same(&other.word, &axis.word)) {
            return Err(("axes", format!("two axes of the machine have the word {}", axis.word)));
        }
        if same(&axis.word, &flavour.feed.word) {
            return Err(("feed.word", format!("{} is an axis of the machine, too", axis.word)));
        }
    }
    let FilamentWords::Axis { word, .. } = &flavour.filament else { return Ok(()) };
    let name = word.split('=').next().unwrap_or(word);
    match axes.iter().find(|axis| same(&axis.word, name)) {
        Some(axis) => {
            let letter = &axis.word;
            Err((
                "filament.word",
                format!("{letter} is an axis of the machine, too: name another one for the extruder, such as U"),
            ))
        }
        None => Ok(()),
    }
}

struct AxisWriter<'a, W, const N: usize> {
    program: Program<'a, W>,
    axes: [Axis; N],
    /// What stands in the file, in its units, where it is known.
    at: Option<[f64; N]>,
}

impl<W: Write, const N: usize> AxisWriter<'_, W, N> {
    fn write(&mut self, index: u64, item: &AxisMove<N>) -> Result<(), WriteError> {
        // What a tool may do does not depend on where it is.
        let (tip, direction, feed_mm_s) = (Point3::origin(), Vector3::z_axis(), 1.0);
        match *item {
            AxisMove::Travel { axes, seconds } => {
                self.program.follow(index, &Move::Travel { tip, direction, feed_mm_s })?;
                self.go(index, &axes, seconds, None, true)
            }
            AxisMove::Print { axes, seconds, filament_mm } => {
                self.program.follow(index, &Move::Print { tip, direction, filament_mm, feed_mm_s })?;
                number(index, "filament_mm", filament_mm, FILAMENT)?;
                self.at.ok_or(WriteError::Unplaced { index })?;
                self.go(index, &axes, seconds, Some(filament_mm), false)?;
                self.program.result.written.filament_mm += filament_mm;
                Ok(())
            }
            AxisMove::Lay { axes, seconds } => {
                self.program.follow(index, &Move::Lay { tip, direction, feed_mm_s })?;
                self.at.ok_or(WriteError::Unplaced { index })?;
                self.go(index, &axes, seconds, None, false)
            }
            AxisMove::Still(item) => {
                self.program.follow(index, &item)?;
                if item == Move::Home && !self.program.flavour.commands.home.is_empty() {
                    self.at = None;
                }
                self.program.still(index, &item)
            }
        }
    }

    fn go(
        &mut self,
        index: u64,
        axes: &[f64; N],
        seconds: f64,
        filament_mm: Option<f64>,
        is_travel: bool,
    ) -> Result<(), WriteError> {
        if self.at.is_some() {
            number(index, "seconds", seconds, TIME)?;
        }
        let (flavour, filament) = (self.program.flavour, filament_mm.unwrap_or(0.0));
        let (counts, to) = self.rounded(index, axes)?;
        let moves = self.at.is_none_or(|at| at.iter().zip(&to).any(|(a, b)| (a - b).abs() > 0.0));
        if matches!(flavour.filament, FilamentWords::Flow { .. }) && filament > 0.0 && !moves {
            // A flow in step with motion needs motion: where all axes stand, it is a stroke.
            self.program.change(0.0, 1.0)?;
            return self.program.stroke(filament, filament / seconds);
        }
        self.program.change(filament, seconds)?;
        if filament_mm.is_some() {
            self.program.zero()?;
        }
        let mut words = Text::default();
        for (axis, count) in self.axes.iter().zip(counts) {
            push(&mut words, &axis.word, count, axis.decimals, flavour);
        }
        let extruder = match filament_mm {
            Some(by) => self.program.extruded(by, &mut words)?,
            None => None,
        };
        let speed = self.speed(&to, extruder, seconds, is_travel);
        self.program.go(Block { is_travel, words: &words.0, comment: "", speed })?;
        if self.at.is_some() {
            self.program.result.written.seconds += seconds;
        }
        self.at = Some(to);
        Ok(())
    }

    /// The numbers of the file: as counts of their last digit, and in its units.
    fn rounded(&self, index: u64, axes: &[f64; N]) -> Result<([i64; N], [f64; N]), WriteError> {
        let (mut counts, mut to) = ([0; N], [0.0; N]);
        for (k, axis) in self.axes.iter().enumerate() {
            let range = if axis.is_rotary { DEGREES } else { COORDINATE };
            let value = axis.number(axes[k]);
            // In the units of the machine and of the file.
            for value in [value / axis.scale, value] {
                if !crate::gcode::within(value, range) {
                    let [least, most] = range;
                    return Err(WriteError::AxisNumber { index, axis: axis.letter, value, least, most });
                }
            }
            counts[k] = steps(value, axis.decimals);
            to[k] = counts[k] as f64 * 10f64.powi(-(axis.decimals as i32));
        }
        Ok((counts, to))
    }

    /// The speed of a move as the controller measures its way.
    fn speed(&mut self, to: &[f64; N], extruder: Option<Part>, seconds: f64, is_travel: bool) -> Speed {
        let flavour = self.program.flavour;
        if is_travel && !flavour.motion.travel_feed {
            return Speed::Rapid;
        }
        let Some(at) = self.at else {
            let (feed, decimals) = (60.0 * self.program.options.first_feed_mm_s, flavour.numbers.feed);
            self.program.result.capped += u64::from(feed > flavour.feed.max);
            return Speed::PerMinute(steps(feed.min(flavour.feed.max), decimals).max(1));
        };
        let parts = self.axes.iter().enumerate().map(|(k, axis)| Part {
            class: Class::of_axis(axis.letter, axis.is_rotary),
            by: to[k] - at[k],
            is_extruder: false,
        });
        let way = length(flavour.feed.of, parts.chain(extruder));
        self.program.speed_of(way, seconds)
    }
}
