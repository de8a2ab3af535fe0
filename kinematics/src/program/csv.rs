//! CSV: every step with every bit, for other programs. [`write_csv`] states the format.

use super::check::{Checker, MAX_NUMBER};
use super::text::tokens::Tokens;
use super::{
    ConfData, ExternalAxes, Goal, HeadInput, HeadSignal, Move, ProgramLimits, ReadError, Speed, Step, Target,
    WriteError, Zone, step::until_error,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use std::io::{BufRead, Write};

const HEADER: &str = "kind,x_mm,y_mm,z_mm,qw,qx,qy,qz,cf1,cf4,cf6,cfx,j1,j2,j3,j4,j5,j6,tilt,turn,mm_s,rad_s,zone_mm,\
                      seconds";
/// That of a program whose only external axis is a track, which is in millimetres.
const TRACK_HEADER: &str = "kind,x_mm,y_mm,z_mm,qw,qx,qy,qz,cf1,cf4,cf6,cfx,j1,j2,j3,j4,j5,j6,track_mm,turn,mm_s,rad_s,\
                            zone_mm,seconds";
const COLUMNS: usize = 24;
/// First columns of groups.
const POSE: usize = 1;
const CONF: usize = 8;
const JOINTS: usize = 12;
const TABLE: usize = 18;
const SPEED: usize = 20;
const ZONE: usize = 22;
const SECONDS: usize = 23;

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;

/// How far the length of a quaternion may be from 1.
const UNIT: f64 = 1e-9;

/// Writes a program as CSV.
///
/// # Format
/// A header, then a line a step, 24 cells each: `kind`, pose `x_mm` to `qz` (quaternion with the scalar first), `cf1`,
/// `cf4`, `cf6`, `cfx` ([`ConfData`]), joints `j1` to `j6`, external axes `tilt` and `turn`, `mm_s`, `rad_s`, `zone_mm`
/// (`stop` or a radius), `seconds`. `kind` is `line`, `swing`, `joints`, `servo`, `on`, `off` or `filament`, whose speed
/// is in `mm_s`, or a signal of a tape head such as `tape_cut_on` ([`HeadSignal::urscript`]), or a wait for its input such as `wait_tape_hot` ([`HeadInput::urscript`]); a cell that the kind does not need is empty, as is that of an axis that is not there. Millimetres,
/// radians, seconds; each number has the digits that bring the same double back.
///
/// # Errors
/// [`WriteError`] names the step that cannot be. The format has no cells for external axes other than the first two.
///
/// # Cost
/// Constant memory; about two microseconds a step, for every digit counts.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::*;
/// let to = Move { goal: Goal::Joints([0.1; 6]), table: None, speed: Speed::default(), zone: Zone::Stop };
/// let steps = [Step::Move(to), Step::Extruder(true)];
/// let mut csv = Vec::new();
/// write_csv(steps, &ProgramLimits::default(), &mut csv)?;
/// let again: Vec<Step> = CsvReader::new(csv.as_slice())?.collect::<Result<_, _>>()?;
/// assert_eq!(again, steps);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_csv(
    steps: impl IntoIterator<Item = Step>,
    limits: &ProgramLimits,
    out: impl Write,
) -> Result<(), WriteError> {
    write_rows(false, steps, limits, out)
}

/// The same for an arm on a track: in the place of `tilt` is `track_mm`, its position in millimetres, and `turn` is empty. [`CsvReader`] reads both.
///
/// # Errors
/// As of [`write_csv`]. A move with other external axes than a track has no cells.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::*;
/// let table = Some(ExternalAxes::of_track(1250.5));
/// let to = Move { goal: Goal::Joints([0.1; 6]), table, speed: Speed::default(), zone: Zone::Stop };
/// let mut csv = Vec::new();
/// write_csv_on_track([Step::Move(to)], &ProgramLimits::default(), &mut csv)?;
/// assert!(String::from_utf8_lossy(&csv).contains(",1250.5,,50,1,stop,"));
/// let Step::Move(again) = CsvReader::new(csv.as_slice())?.next().ok_or("no step")?? else { return Err("no move".into()) };
/// assert!(again.table.and_then(|axes| axes.track_mm()).is_some_and(|mm| (mm - 1250.5).abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_csv_on_track(
    steps: impl IntoIterator<Item = Step>,
    limits: &ProgramLimits,
    out: impl Write,
) -> Result<(), WriteError> {
    write_rows(true, steps, limits, out)
}

fn write_rows(
    is_track: bool,
    steps: impl IntoIterator<Item = Step>,
    limits: &ProgramLimits,
    mut out: impl Write,
) -> Result<(), WriteError> {
    let failed = |source| WriteError::Io { file: "the CSV".to_owned(), source };
    let mut checker = Checker::new(limits);
    let mut text = Vec::from(if is_track { TRACK_HEADER } else { HEADER });
    text.push(b'\n');
    for step in steps {
        checker.check(&step)?;
        if let Step::Move(Move { table: Some(external), .. }) = &step
            && external.axes()[2..].iter().any(Option::is_some)
        {
            return Err(checker.unsupported("external axis but the first two", "the CSV"));
        }
        let step = if is_track {
            in_mm(step).ok_or_else(|| checker.unsupported("axis beside a track", "the CSV"))?
        } else {
            step
        };
        write_step(&mut text, &step).map_err(failed)?;
        if text.len() > CHUNK {
            out.write_all(&text).map_err(failed)?;
            text.clear();
        }
    }
    checker.finish()?;
    out.write_all(&text).and_then(|()| out.flush()).map_err(failed)
}

/// The step with the position of a track as a plain number of millimetres; `None` where there is another axis.
fn in_mm(step: Step) -> Option<Step> {
    let Step::Move(to @ Move { table: Some(external), .. }) = step else { return Some(step) };
    // Rounded to a picometre: the way over radians loses the last bit.
    let mm = (external.track_mm()? * 1e9).round() / 1e9;
    Some(Step::Move(Move { table: ExternalAxes::new([Some(mm), None, None, None, None, None]), ..to }))
}

fn write_step(text: &mut Vec<u8>, step: &Step) -> std::io::Result<()> {
    match step {
        Step::Move(to) => write_move(text, to)?,
        Step::Servo { joints, seconds } => {
            text.extend_from_slice(b"servo");
            empty(text, JOINTS - POSE);
            numbers(text, joints)?;
            empty(text, SECONDS - TABLE);
            numbers(text, &[*seconds])?;
        }
        Step::Extruder(on) => {
            text.extend_from_slice(if *on { b"on" } else { b"off" });
            empty(text, COLUMNS - 1);
        }
        Step::Signal { signal, on } => {
            write!(text, "{}_{}", signal.urscript(), if *on { "on" } else { "off" })?;
            empty(text, COLUMNS - 1);
        }
        Step::Wait(input) => {
            write!(text, "wait_{}", input.urscript())?;
            empty(text, COLUMNS - 1);
        }
        Step::FilamentSpeed(mm_s) => {
            text.extend_from_slice(b"filament");
            empty(text, SPEED - POSE);
            numbers(text, &[*mm_s])?;
            empty(text, COLUMNS - SPEED - 1);
        }
    }
    text.push(b'\n');
    Ok(())
}

/// All cells of a move. Those of the pose are empty for a goal of joints, those of the joints for a pose.
fn write_move(text: &mut Vec<u8>, to: &Move) -> std::io::Result<()> {
    let (word, target, joints) = match &to.goal {
        Goal::Line(target) => ("line", Some(target), None),
        Goal::JointMove(target) => ("swing", Some(target), None),
        Goal::Joints(joints) => ("joints", None, Some(joints)),
    };
    text.extend_from_slice(word.as_bytes());
    match target {
        Some(Target { pose, conf }) => {
            let (at, q) = (pose.translation.vector, pose.rotation);
            numbers(text, &[at.x, at.y, at.z, q.w, q.i, q.j, q.k])?;
            write!(text, ",{},{},{},{}", conf.cf1, conf.cf4, conf.cf6, conf.cfx)?;
        }
        None => empty(text, JOINTS - POSE),
    }
    match joints {
        Some(joints) => numbers(text, joints)?,
        None => empty(text, TABLE - JOINTS),
    }
    let axes = to.table.map_or([None; 6], |external| external.axes());
    for axis in &axes[..SPEED - TABLE] {
        match axis {
            Some(value) => numbers(text, &[*value])?,
            None => empty(text, 1),
        }
    }
    numbers(text, &[to.speed.mm_s, to.speed.rad_s])?;
    match to.zone {
        Zone::Stop => text.extend_from_slice(b",stop"),
        Zone::Blend(radius) => numbers(text, &[radius])?,
    }
    // The seconds, which only streamed joints have.
    empty(text, COLUMNS - SECONDS);
    Ok(())
}

/// Cells with a number each.
fn numbers(text: &mut Vec<u8>, values: &[f64]) -> std::io::Result<()> {
    values.iter().try_for_each(|value| write!(text, ",{value}"))
}

/// Cells without content.
fn empty(text: &mut Vec<u8>, cells: usize) {
    text.extend(std::iter::repeat_n(b',', cells));
}

/// The steps of a CSV, one after the other, in constant memory. Ends after the first error.
#[derive(Debug)]
pub struct CsvReader<R> {
    row: Row<R>,
    over: bool,
}

impl<R: BufRead> CsvReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`ReadError`] when it is another one.
    pub fn new(reader: R) -> Result<Self, ReadError> {
        let mut lines = Tokens::new(reader, 0);
        let any = lines.next_line()?;
        let header = lines.line().trim_ascii_end();
        let is_track = header == TRACK_HEADER.as_bytes();
        if !any || !(is_track || header == HEADER.as_bytes()) {
            return Err(unexpected(&lines, 0, "the header of a program", lines.line()));
        }
        Ok(CsvReader { row: Row { lines, ends: [0; COLUMNS], is_track }, over: false })
    }
}

/// `tape_cut_on` or `wait_tape_hot`: the step of such a kind.
fn signal_of(kind: &[u8]) -> Option<Step> {
    if let Some(name) = kind.strip_prefix(b"wait_") {
        return HeadInput::ALL.into_iter().find(|input| input.urscript().as_bytes() == name).map(Step::Wait);
    }
    let (name, on) = match kind.strip_suffix(b"_on") {
        Some(name) => (name, true),
        None => (kind.strip_suffix(b"_off")?, false),
    };
    let signal = HeadSignal::ALL.into_iter().find(|signal| signal.urscript().as_bytes() == name)?;
    Some(Step::Signal { signal, on })
}

/// A line, cut into its cells.
#[derive(Debug)]
struct Row<R> {
    lines: Tokens<R>,
    /// Ends of the cells.
    ends: [usize; COLUMNS],
    /// Whether the first external axis is a track, in millimetres.
    is_track: bool,
}

impl<R: BufRead> Row<R> {
    /// The step of the next line; `None` at the end of the file.
    fn step(&mut self) -> Result<Option<Step>, ReadError> {
        if !self.lines.next_line()? {
            return Ok(None);
        }
        self.cut()?;
        let kind = self.cell(0);
        let target: fn(Target) -> Goal = match kind {
            b"line" => Goal::Line,
            b"swing" => Goal::JointMove,
            b"joints" => {
                self.blank(POSE..JOINTS)?;
                let goal = Goal::Joints(self.numbers(JOINTS)?);
                return self.rest(goal).map(Some);
            }
            b"servo" => {
                self.blank(POSE..JOINTS)?;
                self.blank(TABLE..SECONDS)?;
                let seconds = self.positive(SECONDS, "a time")?;
                return Ok(Some(Step::Servo { joints: self.numbers(JOINTS)?, seconds }));
            }
            b"on" | b"off" => {
                self.blank(POSE..COLUMNS)?;
                return Ok(Some(Step::Extruder(kind == b"on")));
            }
            _ if signal_of(kind).is_some() => {
                self.blank(POSE..COLUMNS)?;
                return Ok(signal_of(kind));
            }
            b"filament" => {
                self.blank(POSE..SPEED)?;
                self.blank(SPEED + 1..COLUMNS)?;
                let mm_s = self.number(SPEED)?;
                if mm_s < 0.0 {
                    return Err(self.wrong(SPEED, "a speed of the filament", mm_s));
                }
                return Ok(Some(Step::FilamentSpeed(mm_s)));
            }
            other => {
                return Err(unexpected(
                    &self.lines,
                    0,
                    "line, swing, joints, servo, on, off, filament, or a signal or a wait of a tape head",
                    other,
                ));
            }
        };
        let goal = target(self.target()?);
        self.blank(JOINTS..TABLE)?;
        self.rest(goal).map(Some)
    }

    /// Finds the cells of the line: exactly as many as there are columns.
    fn cut(&mut self) -> Result<(), ReadError> {
        let line = self.lines.line().trim_ascii_end();
        let mut cells = 0;
        for (at, _) in line.iter().enumerate().filter(|(_, byte)| **byte == b',').chain([(line.len(), &b',')]) {
            if cells == COLUMNS {
                return Err(unexpected(&self.lines, at, "24 cells and no more", b","));
            }
            self.ends[cells] = at;
            cells += 1;
        }
        if cells < COLUMNS {
            return Err(unexpected(&self.lines, line.len(), "24 cells", b"the end of the line"));
        }
        Ok(())
    }

    /// The pose and the configuration data of a line.
    fn target(&self) -> Result<Target, ReadError> {
        let [x, y, z, w, i, j, k] = self.numbers::<7>(POSE)?;
        let quaternion = Quaternion::new(w, i, j, k);
        let length = quaternion.norm();
        if (length - 1.0).abs() > UNIT {
            return Err(self.wrong(POSE + 3, "the length of a rotation's quaternion", length));
        }
        // As it is: to bring its length nearer to 1 would change its bits.
        let pose = Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::new_unchecked(quaternion));
        let mut conf = [0; 4];
        for (k, entry) in conf.iter_mut().enumerate() {
            let text = self.cell(CONF + k);
            let whole = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
            *entry = whole.ok_or_else(|| unexpected(&self.lines, self.start(CONF + k), "a whole number", text))?;
        }
        let [cf1, cf4, cf6, cfx] = conf;
        Ok(Target { pose, conf: ConfData { cf1, cf4, cf6, cfx } })
    }

    /// Table, speed and zone.
    fn rest(&self, goal: Goal) -> Result<Step, ReadError> {
        let mut axes = [None; 6];
        for (k, axis) in axes[..SPEED - TABLE].iter_mut().enumerate() {
            if !self.cell(TABLE + k).is_empty() {
                *axis = Some(self.number(TABLE + k)?);
            }
        }
        let table = if self.is_track {
            self.blank(TABLE + 1..SPEED)?;
            axes[0].map(ExternalAxes::of_track)
        } else {
            ExternalAxes::new(axes)
        };
        let speed =
            Speed { mm_s: self.positive(SPEED, "a speed")?, rad_s: self.positive(SPEED + 1, "a speed of turning")? };
        let zone = match self.cell(ZONE) {
            b"stop" => Zone::Stop,
            _ => Zone::Blend(self.positive(ZONE, "a radius")?),
        };
        self.blank(SECONDS..COLUMNS)?;
        Ok(Step::Move(Move { goal, table, speed, zone }))
    }

    fn start(&self, column: usize) -> usize {
        if column == 0 { 0 } else { self.ends[column - 1] + 1 }
    }

    fn cell(&self, column: usize) -> &[u8] {
        self.lines.line()[self.start(column)..self.ends[column]].trim_ascii()
    }

    fn blank(&self, columns: std::ops::Range<usize>) -> Result<(), ReadError> {
        match columns.into_iter().find(|&column| !self.cell(column).is_empty()) {
            None => Ok(()),
            Some(column) => Err(unexpected(&self.lines, self.start(column), "an empty cell", self.cell(column))),
        }
    }

    /// A number that a writer takes: none is beyond 1e6.
    fn number(&self, column: usize) -> Result<f64, ReadError> {
        let text = self.cell(column);
        let value = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
        let value = value
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| unexpected(&self.lines, self.start(column), "a finite number", text))?;
        if value.abs() <= MAX_NUMBER { Ok(value) } else { Err(self.wrong(column, "a number of a program", value)) }
    }

    fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N], ReadError> {
        let mut values = [0.0; N];
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.number(first + k)?;
        }
        Ok(values)
    }

    fn positive(&self, column: usize, what: &'static str) -> Result<f64, ReadError> {
        let value = self.number(column)?;
        if value > 0.0 { Ok(value) } else { Err(self.wrong(column, what, value)) }
    }

    fn wrong(&self, column: usize, what: &'static str, value: f64) -> ReadError {
        let (line, _) = self.lines.place();
        ReadError::Number { line, column: self.start(column) as u64 + 1, what, value }
    }
}

fn unexpected<R: BufRead>(lines: &Tokens<R>, at: usize, expected: &'static str, found: &[u8]) -> ReadError {
    let (line, _) = lines.place();
    let found = format!("`{}`", String::from_utf8_lossy(&found[..found.len().min(40)]));
    ReadError::Unexpected { line, column: at as u64 + 1, expected, found }
}

impl<R: BufRead> Iterator for CsvReader<R> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        until_error(&mut self.over, || self.row.step())
    }
}
