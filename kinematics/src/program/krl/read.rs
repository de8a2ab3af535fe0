//! KRL, read.

use super::data::{Data, skip_header};
use super::motion::pose;
use super::options::{AXIS_SPEED, BASE, EXTRUDER, FILAMENT, FULL_SCALE, TOOL, input_name, output_name};
use crate::program::check::MAX_NUMBER;
use crate::program::step::until_error;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{ConfData, ExternalAxes, Goal, HeadInput, HeadSignal, Move, ReadError, Speed, Step, Target, Zone};
use nalgebra::Isometry3;
use std::collections::VecDeque;
use std::io::{self, BufRead};

/// Calls of parts in a main.
const MAX_PARTS: usize = 100_000;

/// Reads a program: the main module, then, as steps are asked for, its parts in turn.
///
/// # What is read
/// What [`write_krl`](super::write_krl) writes, in any layout and case, with comments. All else is an error with line and column, and so is a number that no
/// writer of ours takes. What a file does not say comes back as the default: configuration data, the radius of corners in a spline block (that of `$APO.CDIS`), and of
/// [`Speed`] what the instruction does not take. Speeds of joints are whole percentages.
///
/// # Arguments
/// * `dat`, `src`: the pair of the main module.
/// * `open`: opens a part by its file name, such as `PRINT_001.src`.
///
/// # Errors
/// [`ReadError`] of the main with line and column; those of parts come with the steps.
pub fn read_krl<R: BufRead, F: FnMut(&str) -> io::Result<R>>(
    dat: impl BufRead,
    src: impl BufRead,
    open: F,
) -> Result<KrlProgram<R, F>, ReadError> {
    let data = Data::read(dat)?;
    let mut tokens = Tokens::new(src, b';');
    skip_header(&mut tokens)?;
    tokens.expect_word("DEF")?;
    let name = tokens.name("the module's name")?;
    if !name.eq_ignore_ascii_case(&data.name) {
        return Err(tokens.unexpected_at(tokens.place(), "the name of the data list", &name));
    }
    tokens.marks("()")?;
    let mut parts = Vec::new();
    loop {
        let token = tokens.next()?;
        let Token::Word(from, to) = token else { return Err(tokens.unexpected("a call or END", token)) };
        let word = String::from_utf8_lossy(tokens.word_at(from, to)).into_owned();
        let number = word.rsplit_once('_').filter(|(begin, _)| begin.eq_ignore_ascii_case(&name));
        if word.eq_ignore_ascii_case("END") {
            break;
        }
        match number {
            Some((_, number)) if parts.len() < MAX_PARTS && number.bytes().all(|byte| byte.is_ascii_digit()) => {
                parts.push(format!("{word}.src"));
            }
            Some((_, off)) if off.eq_ignore_ascii_case("OFF") => {}
            _ => return Err(tokens.unexpected("a call of a part, of OFF, or END", token)),
        }
        tokens.marks("()")?;
    }
    Ok(KrlProgram {
        data,
        parts: parts.into_iter().enumerate(),
        open,
        part: None,
        kinematic: None,
        in_hand: false,
        over: false,
    })
}

/// The steps of a program, one after the other. Ends after the first error.
#[derive(Debug)]
pub struct KrlProgram<R, F> {
    data: Data,
    parts: std::iter::Enumerate<std::vec::IntoIter<String>>,
    open: F,
    part: Option<(usize, String, Part<R>)>,
    kinematic: Option<u8>,
    in_hand: bool,
    over: bool,
}

impl<R, F> KrlProgram<R, F> {
    /// The program's name.
    pub fn name(&self) -> &str {
        &self.data.name
    }

    /// Whether the robot holds the part: once the first step has been read.
    pub fn part_in_hand(&self) -> bool {
        self.in_hand
    }

    /// The kinematic system that carries the work object: once the first step has been read.
    pub fn kinematic(&self) -> Option<u8> {
        self.kinematic
    }

    /// `$TOOL` and `$BASE` of the data list.
    pub fn frames(&self) -> [Isometry3<f64>; 2] {
        [TOOL, BASE].map(|end| self.data.frame(end))
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> KrlProgram<R, F> {
    fn step(&mut self) -> Result<Option<Step>, ReadError> {
        loop {
            let Some((index, file, part)) = &mut self.part else {
                let Some((index, file)) = self.parts.next() else { return Ok(None) };
                let reader =
                    (self.open)(&file).map_err(|source| ReadError::Part { index, file: file.clone(), source })?;
                self.part = Some((index, file, Part::new(reader)));
                continue;
            };
            let step = part.step(&self.data).map_err(|source| ReadError::InPart {
                index: *index,
                file: file.clone(),
                source: Box::new(source),
            })?;
            (self.in_hand, self.kinematic) = (part.in_hand, part.kinematic);
            match step {
                Some(step) => return Ok(Some(step)),
                None => self.part = None,
            }
        }
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> Iterator for KrlProgram<R, F> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut over = self.over;
        let step = until_error(&mut over, || self.step());
        self.over = over;
        step
    }
}

/// A part module that is being read.
#[derive(Debug)]
struct Part<R> {
    tokens: Tokens<R>,
    has_begun: bool,
    in_hand: bool,
    kinematic: Option<u8>,
    speed: Speed,
    corner_mm: f64,
    percent: f64,
    in_spline: bool,
    /// Signals of triggers at the end of the line that comes.
    ends: Vec<Step>,
    queue: VecDeque<Step>,
}

impl<R: BufRead> Part<R> {
    fn new(reader: R) -> Self {
        Part {
            tokens: Tokens::new(reader, b';'),
            has_begun: false,
            in_hand: false,
            kinematic: None,
            speed: Speed::default(),
            corner_mm: 0.0,
            percent: 100.0,
            in_spline: false,
            ends: Vec::new(),
            queue: VecDeque::new(),
        }
    }

    fn step(&mut self, data: &Data) -> Result<Option<Step>, ReadError> {
        if !std::mem::replace(&mut self.has_begun, true) {
            skip_header(&mut self.tokens)?;
            self.tokens.expect_word("DEF")?;
            self.tokens.name("the module's name")?;
            self.tokens.marks("()")?;
        }
        loop {
            if let Some(step) = self.queue.pop_front() {
                return Ok(Some(step));
            }
            let token = self.tokens.next()?;
            let is = |word: &str| self.tokens.is_word(token, word);
            if token == Token::Mark(b'$') {
                let step = self.variable(data)?;
                self.queue.extend(step);
            } else if is("LIN") || (is("SPL") && self.in_spline) {
                self.line()?;
            } else if is("PTP") && !self.in_spline {
                self.joints(data)?;
            } else if is("TRIGGER") {
                self.trigger(data)?;
            } else if is("SPLINE") && !self.in_spline {
                self.in_spline = true;
            } else if is("ENDSPLINE") && self.in_spline {
                self.in_spline = false;
            } else if is("WAIT") {
                return self.wait(data).map(Some);
            } else if is("END") && self.ends.is_empty() && !self.in_spline {
                return Ok(None);
            } else {
                return Err(self
                    .tokens
                    .unexpected("LIN, PTP, SPL in a spline block, TRIGGER, a variable or END", token));
            }
        }
    }

    /// An assignment, from behind `$` on; a step if it is one of an output.
    fn variable(&mut self, data: &Data) -> Result<Option<Step>, ReadError> {
        let tokens = &mut self.tokens;
        let name = tokens.name("a system variable")?.to_ascii_uppercase();
        let place = tokens.place();
        match name.as_str() {
            "OUT" => return output(tokens, data).map(Some),
            "ANOUT" => return analog(tokens, data).map(Some),
            "VEL" => self.speed = speed(tokens, self.speed)?,
            "APO" => {
                tokens.marks(".")?;
                tokens.expect_word("CDIS")?;
                tokens.marks("=")?;
                self.corner_mm = tokens.positive("a radius", 1.0)?;
            }
            "ACC" => {
                tokens.marks(".")?;
                tokens.expect_word("CP")?;
                tokens.marks("=")?;
                tokens.positive("an acceleration", 1.0)?;
            }
            "VEL_AXIS" | "ACC_AXIS" => {
                tokens.marks("[")?;
                tokens.within("an axis", 1.0, 6.0)?;
                tokens.marks("]=")?;
                let percent = tokens.within("a percentage", 1.0, 100.0)?;
                self.percent = if name == "VEL_AXIS" { percent } else { self.percent };
            }
            "ADVANCE" => {
                tokens.marks("=")?;
                tokens.within("an advance run", 0.0, 5.0)?;
            }
            "BWDSTART" => {
                tokens.marks("=")?;
                truth(tokens)?;
            }
            "IPO_MODE" | "ORI_TYPE" => {
                tokens.marks("=#")?;
                let token = tokens.next()?;
                self.in_hand = tokens.is_word(token, "TCP") || (self.in_hand && name == "ORI_TYPE");
            }
            "TOOL" | "BASE" => {
                tokens.marks("=")?;
                self.kinematic = frame(tokens, data)?.or(self.kinematic);
            }
            _ => return Err(tokens.unexpected_at(place, "a variable that our programs set", &name)),
        }
        Ok(None)
    }

    /// `{X ..} C_DIS`, from behind `LIN`, or the segment of a block.
    fn line(&mut self) -> Result<(), ReadError> {
        let Place { target, joints: None, table } = place(&mut self.tokens, self.in_hand)? else {
            return Err(self.tokens.unexpected("a pose", Token::Mark(b'}')));
        };
        let mut speed_here = self.speed;
        let mut is_blended = false;
        if self.in_spline {
            self.tokens.expect_word("WITH")?;
            loop {
                self.tokens.marks("$")?;
                self.tokens.expect_word("VEL")?;
                speed_here = speed(&mut self.tokens, speed_here)?;
                if self.tokens.peek()? != Token::Mark(b',') {
                    break;
                }
                self.tokens.next()?;
            }
            let token = self.tokens.peek()?;
            is_blended = !self.tokens.is_word(token, "ENDSPLINE");
        } else {
            let token = self.tokens.peek()?;
            if self.tokens.is_word(token, "C_DIS") {
                self.tokens.next()?;
                is_blended = true;
            }
        }
        let zone = if is_blended && self.corner_mm > 0.0 { Zone::Blend(self.corner_mm) } else { Zone::Stop };
        self.queue.push_back(Step::Move(Move { goal: Goal::Line(target), table, speed: speed_here, zone }));
        self.queue.extend(self.ends.drain(..));
        Ok(())
    }

    /// `{A1 ..}` or `{X ..}`, from behind `PTP`.
    fn joints(&mut self, data: &Data) -> Result<(), ReadError> {
        if !self.ends.is_empty() {
            return Err(self.tokens.unexpected("a line behind a trigger at its end", Token::Mark(b'{')));
        }
        let Place { target, joints, table } = place(&mut self.tokens, self.in_hand)?;
        let goal = joints.map_or(Goal::JointMove(target), Goal::Joints);
        let full = data.number(AXIS_SPEED).unwrap_or(100.0).to_radians();
        let speed = Speed { rad_s: self.percent / 100.0 * full, ..Speed::default() };
        self.queue.push_back(Step::Move(Move { goal, table, speed, zone: Zone::Stop }));
        Ok(())
    }

    /// `WHEN DISTANCE=0 DELAY=0 DO $OUT[..]=TRUE`, from behind `TRIGGER`.
    fn trigger(&mut self, data: &Data) -> Result<(), ReadError> {
        let tokens = &mut self.tokens;
        tokens.expect_word("WHEN")?;
        let token = tokens.next()?;
        let is_path = tokens.is_word(token, "PATH");
        if !is_path && !tokens.is_word(token, "DISTANCE") {
            return Err(tokens.unexpected("DISTANCE or PATH", token));
        }
        tokens.marks("=")?;
        let mut is_begin = tokens.within("a place of a trigger", 0.0, if is_path { 0.0 } else { 1.0 })? < 0.5;
        let token = tokens.peek()?;
        if is_path {
            is_begin = tokens.is_word(token, "ONSTART");
            if is_begin {
                tokens.next()?;
            }
        }
        tokens.expect_word("DELAY")?;
        tokens.marks("=")?;
        tokens.within("a delay", -MAX_NUMBER, MAX_NUMBER)?;
        tokens.expect_word("DO")?;
        tokens.marks("$")?;
        let token = tokens.next()?;
        let signal = if tokens.is_word(token, "OUT") {
            output(tokens, data)?
        } else if tokens.is_word(token, "ANOUT") {
            analog(tokens, data)?
        } else {
            return Err(tokens.unexpected("OUT or ANOUT", token));
        };
        if is_begin {
            self.queue.push_back(signal);
        } else if self.ends.len() < HeadSignal::ALL.len() {
            self.ends.push(signal);
        } else {
            return Err(tokens.unexpected_at(tokens.place(), "a line behind its triggers", "TRIGGER"));
        }
        Ok(())
    }

    /// `FOR $IN[..]`
    fn wait(&mut self, data: &Data) -> Result<Step, ReadError> {
        let tokens = &mut self.tokens;
        tokens.expect_word("FOR")?;
        tokens.marks("$")?;
        tokens.expect_word("IN")?;
        tokens.marks("[")?;
        let name = tokens.name("the name of an input")?;
        let place = tokens.place();
        tokens.marks("]")?;
        let input = HeadInput::ALL.into_iter().find(|input| data.is(&name, input_name(*input)));
        input.map(Step::Wait).ok_or_else(|| tokens.unexpected_at(place, "an input of the program", &name))
    }
}

/// What stands between braces.
struct Place {
    target: Target,
    joints: Option<[f64; 6]>,
    table: Option<ExternalAxes>,
}

/// `{X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 10,E1 0}` or `{A1 0,..,A6 0,E1 0}`
fn place(tokens: &mut Tokens<impl BufRead>, in_hand: bool) -> Result<Place, ReadError> {
    const POSE: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
    const AXES: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];
    const EXTERNAL: [&str; 6] = ["E1", "E2", "E3", "E4", "E5", "E6"];
    let mut found: [[Option<f64>; 6]; 3] = [[None; 6]; 3];
    tokens.marks("{")?;
    loop {
        let token = tokens.next()?;
        let named = [POSE, AXES, EXTERNAL].iter().enumerate().find_map(|(kind, names)| {
            let at = names.iter().position(|name| tokens.is_word(token, name))?;
            Some((kind, at))
        });
        let is_posture = tokens.is_word(token, "S") || tokens.is_word(token, "T");
        if named.map_or(!is_posture, |(kind, at)| found[kind][at].is_some()) {
            return Err(tokens.unexpected("X, A1, E1 or another component, each once", token));
        }
        let value = tokens.within("a coordinate, an angle or a number of a posture", -MAX_NUMBER, MAX_NUMBER)?;
        if let Some((kind, at)) = named {
            found[kind][at] = Some(value);
        }
        match tokens.next()? {
            Token::Mark(b',') => {}
            Token::Mark(b'}') => break,
            other => return Err(tokens.unexpected(", or }", other)),
        }
    }
    let all = |values: [Option<f64>; 6]| -> Option<[f64; 6]> {
        values.iter().all(Option::is_some).then(|| values.map(Option::unwrap_or_default))
    };
    let table = ExternalAxes::new(found[2].map(|axis| axis.map(f64::to_radians)));
    let identity = Target { pose: Isometry3::identity(), conf: ConfData::default() };
    match (all(found[0]), all(found[1])) {
        (Some([x, y, z, a, b, c]), None) => {
            let [a, b, c] = [a, b, c].map(f64::to_radians);
            let written = pose([x, y, z, a, b, c]);
            let pose = if in_hand { written.inverse() } else { written };
            Ok(Place { target: Target { pose, ..identity }, joints: None, table })
        }
        (None, Some(axes)) => Ok(Place { target: identity, joints: Some(axes.map(f64::to_radians)), table }),
        _ => Err(tokens.unexpected("X, Y, Z, A, B, C or A1 to A6", Token::Mark(b'}'))),
    }
}

/// `.CP=0.02` and its like, from behind `$VEL`.
fn speed(tokens: &mut Tokens<impl BufRead>, speed: Speed) -> Result<Speed, ReadError> {
    tokens.marks(".")?;
    let token = tokens.next()?;
    let is_path = tokens.is_word(token, "CP");
    if !is_path && !tokens.is_word(token, "ORI1") && !tokens.is_word(token, "ORI2") {
        return Err(tokens.unexpected("CP, ORI1 or ORI2", token));
    }
    tokens.marks("=")?;
    Ok(match is_path {
        true => Speed { mm_s: tokens.positive("a speed", 1000.0)?, ..speed },
        false => Speed { rad_s: tokens.positive("a speed of turning", 1.0)?.to_radians(), ..speed },
    })
}

/// `[NAME_EXTR]=TRUE`, from behind `$OUT`.
fn output(tokens: &mut Tokens<impl BufRead>, data: &Data) -> Result<Step, ReadError> {
    tokens.marks("[")?;
    let name = tokens.name("the name of an output")?;
    let place = tokens.place();
    tokens.marks("]=")?;
    let on = truth(tokens)?;
    if data.is(&name, EXTRUDER) {
        return Ok(Step::Extruder(on));
    }
    let signal = HeadSignal::ALL.into_iter().find(|signal| data.is(&name, output_name(*signal)));
    let signal = signal.ok_or_else(|| tokens.unexpected_at(place, "an output of the program", &name))?;
    Ok(Step::Signal { signal, on })
}

/// `[NAME_FILA]=0.5`, from behind `$ANOUT`.
fn analog(tokens: &mut Tokens<impl BufRead>, data: &Data) -> Result<Step, ReadError> {
    tokens.marks("[")?;
    let name = tokens.name("the name of an output")?;
    let place = tokens.place();
    tokens.marks("]=")?;
    let share = tokens.within("a share of the analog output, 0 to 1", 0.0, 1.0)?;
    match data.number(FULL_SCALE) {
        Some(full) if data.is(&name, FILAMENT) => Ok(Step::FilamentSpeed(share * full)),
        _ => Err(tokens.unexpected_at(place, "the output of the filament, whose full scale the data list has", &name)),
    }
}

fn truth(tokens: &mut Tokens<impl BufRead>) -> Result<bool, ReadError> {
    let token = tokens.next()?;
    let on = tokens.is_word(token, "TRUE");
    if on || tokens.is_word(token, "FALSE") { Ok(on) } else { Err(tokens.unexpected("TRUE or FALSE", token)) }
}

/// The name of a frame, or `EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,NAME_BASE)`: the number of the kinematic system.
fn frame(tokens: &mut Tokens<impl BufRead>, data: &Data) -> Result<Option<u8>, ReadError> {
    let name = tokens.name("a frame")?;
    if data.is(&name, TOOL) || data.is(&name, BASE) {
        return Ok(None);
    }
    if !name.eq_ignore_ascii_case("EK") {
        return Err(tokens.unexpected_at(tokens.place(), "a frame of the data list, or EK", &name));
    }
    tokens.marks("(")?;
    let mut number = 0.0;
    for field in ["ROOT", "MECH_TYPE"] {
        tokens.expect_word("MACHINE_DEF")?;
        tokens.marks("[")?;
        number = tokens.within("a kinematic system", 2.0, 16.0)?;
        tokens.marks("].")?;
        tokens.expect_word(field)?;
        tokens.marks(",")?;
    }
    tokens.name("a frame")?;
    tokens.marks(")")?;
    Ok(Some(number as u8))
}
