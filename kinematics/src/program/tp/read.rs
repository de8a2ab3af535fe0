//! TP programs, read.

use super::line::Line;
use super::options::{
    AXIS_SPEED, COUNTS, EXTRUDER, FILAMENT, FULL_SCALE, HEAD_INPUTS, HEAD_OUTPUTS, IN_HAND, TpOptions,
};
use super::position::{Position, conf, pose};
use crate::program::check::MAX_NUMBER;
use crate::program::step::until_error;
use crate::program::text::tokens::Tokens;
use crate::program::{ConfData, ExternalAxes, Goal, HeadInput, HeadSignal, Move, ReadError, Speed, Step, Target, Zone};
use std::collections::BTreeMap;
use std::io::{self, BufRead};
use std::marker::PhantomData;

/// Lines of a program, and calls: memory is bounded.
const MAX_LINES: usize = 200_000;

/// Reads a program: the main, then, as steps are asked for, its parts in turn.
///
/// # What is read
/// What [`write_tp`](super::write_tp) writes. All other instructions are errors with line and column, and so is a number that no writer of ours takes. Remarks of the main say what
/// the numbers of signals and speeds stand for. What a file does not say comes back as the default: the radius of corners ([`TpOptions::CNT_MM`]), quarter turns within
/// a turn, and of [`Speed`] what the instruction does not take. Speeds of joints are whole percentages, those of the filament whole counts.
///
/// # Arguments
/// * `main`: the main program.
/// * `open`: opens a part by its file name, such as `PRINT_001.ls`.
///
/// # Errors
/// [`ReadError`] of the main with line and column; those of parts come with the steps.
///
/// # Cost
/// Memory for one part.
pub fn read_tp<R: BufRead, F: FnMut(&str) -> io::Result<R>>(
    main: impl BufRead,
    open: F,
) -> Result<TpProgram<R, F>, ReadError> {
    let mut tokens = Tokens::new(main, 0);
    let name = head(&mut tokens)?;
    let (mut signals, mut parts) = (Signals::default(), Vec::new());
    while let Some(mut line) = Line::next(&mut tokens)? {
        if line.take("!") {
            signals.note(&mut line)?;
        } else if line.take("CALL ") {
            parts.push(format!("{}.ls", line.word("the name of a program")?));
        } else if line.take("DO[")
            || line.take("AO[")
            || line.take("PR[")
            || line.take("UTOOL[")
            || line.take("UFRAME[")
        {
            line.rest();
        } else {
            return Err(line.unexpected("a remark, CALL, DO, AO, PR, UTOOL or UFRAME"));
        }
        line.end()?;
        if parts.len() > MAX_LINES {
            return Err(line.unexpected("no more than 200000 calls"));
        }
    }
    Ok(TpProgram {
        name,
        signals,
        parts: parts.into_iter().enumerate(),
        open,
        part: Vec::new().into_iter(),
        over: false,
        reader: PhantomData,
    })
}

/// The steps of a program, one after the other. Ends after the first error.
#[derive(Debug)]
pub struct TpProgram<R, F> {
    name: String,
    signals: Signals,
    parts: std::iter::Enumerate<std::vec::IntoIter<String>>,
    open: F,
    part: std::vec::IntoIter<Step>,
    over: bool,
    reader: PhantomData<R>,
}

impl<R, F> TpProgram<R, F> {
    /// The program's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the robot holds the part.
    pub fn part_in_hand(&self) -> bool {
        self.signals.number(IN_HAND).is_some()
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> Iterator for TpProgram<R, F> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut over = self.over;
        let step = until_error(&mut over, || self.step());
        self.over = over;
        step
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> TpProgram<R, F> {
    fn step(&mut self) -> Result<Option<Step>, ReadError> {
        loop {
            if let Some(step) = self.part.next() {
                return Ok(Some(step));
            }
            let Some((index, file)) = self.parts.next() else { return Ok(None) };
            let reader = (self.open)(&file).map_err(|source| ReadError::Part { index, file: file.clone(), source })?;
            let steps = steps_of_part(reader, &self.signals);
            let steps = steps.map_err(|source| ReadError::InPart { index, file, source: Box::new(source) })?;
            self.part = steps.into_iter();
        }
    }
}

/// What remarks of the main say.
#[derive(Debug, Default)]
struct Signals {
    numbers: BTreeMap<String, f64>,
}

impl Signals {
    /// `NAME 20`; other remarks are for people.
    fn note(&mut self, line: &mut Line) -> Result<(), ReadError> {
        let known = [FULL_SCALE, COUNTS, AXIS_SPEED, FILAMENT, EXTRUDER, IN_HAND];
        let name = line.word("a remark").unwrap_or_default();
        if known.iter().chain(&HEAD_OUTPUTS).chain(&HEAD_INPUTS).any(|known| *known == name) {
            let value = line.number("a number of a signal", 0.0, MAX_NUMBER)?;
            self.numbers.insert(name, value);
        } else {
            line.rest();
        }
        Ok(())
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.numbers.get(name).copied()
    }

    /// Whether a signal of this name has this number.
    fn is(&self, name: &str, number: f64) -> bool {
        self.number(name).is_some_and(|own| (own - number).abs() < 0.5)
    }
}

/// Goes on behind `/MN`; the program's name.
fn head<R: BufRead>(tokens: &mut Tokens<R>) -> Result<String, ReadError> {
    let mut name = None;
    loop {
        let Some(mut line) = Line::raw(tokens)? else {
            return Err(Line::default().unexpected("/MN"));
        };
        if name.is_none() {
            if !line.take("/PROG") {
                return Err(line.unexpected("/PROG"));
            }
            name = Some(line.word("the program's name")?);
        } else if line.take("/MN") {
            return Ok(name.unwrap_or_default());
        }
    }
}

/// An instruction of a part: a step, or a move to a position that is not known yet.
enum Instruction {
    Step(Step),
    Move { number: u32, is_line: bool, speed: Speed, zone: Zone, place: [u64; 2] },
}

fn steps_of_part(reader: impl BufRead, signals: &Signals) -> Result<Vec<Step>, ReadError> {
    let mut tokens = Tokens::new(reader, 0);
    head(&mut tokens)?;
    let mut instructions = Vec::new();
    while let Some(mut line) = Line::next(&mut tokens)? {
        if instructions.len() >= MAX_LINES {
            return Err(line.unexpected("no more than 200000 lines"));
        }
        instructions.extend(instruction(&mut line, signals)?);
        line.end()?;
    }
    let positions = positions(&mut tokens, signals)?;
    let step = |instruction| match instruction {
        Instruction::Step(step) => Ok(step),
        Instruction::Move { number, is_line, speed, zone, place } => {
            let Some((position, table)) = positions.get(&number) else {
                let found = format!("P[{number}]");
                return Err(ReadError::Unexpected {
                    line: place[0],
                    column: place[1],
                    expected: "a position of /POS",
                    found,
                });
            };
            let goal = match (position, is_line) {
                (Position::Pose(target), true) => Goal::Line(*target),
                (Position::Pose(target), false) => Goal::JointMove(*target),
                (Position::Joints(joints), false) => Goal::Joints(*joints),
                (Position::Joints(_), true) => {
                    let found = format!("P[{number}], which is joints");
                    return Err(ReadError::Unexpected { line: place[0], column: place[1], expected: "a pose", found });
                }
            };
            Ok(Step::Move(Move { goal, table: *table, speed, zone }))
        }
    };
    instructions.into_iter().map(step).collect()
}

/// An instruction; `None` for one that only sets frames, and for a remark.
fn instruction(line: &mut Line, signals: &Signals) -> Result<Option<Instruction>, ReadError> {
    let place = line.place();
    let is_line = line.take("L P[");
    if is_line || line.take("J P[") {
        return motion(line, signals, is_line, place).map(Some);
    }
    if line.take("UFRAME_NUM=") || line.take("UTOOL_NUM=") || line.take("!") {
        line.rest();
        return Ok(None);
    }
    let step = if line.take("DO[") {
        let number = line.number("an output", 1.0, MAX_NUMBER)?;
        line.expect("]=")?;
        let on = line.take("ON");
        if !on {
            line.expect("OFF")?;
        }
        let head = HeadSignal::ALL.into_iter().find(|signal| signals.is(HEAD_OUTPUTS[signal.number()], number));
        match head {
            _ if signals.is(EXTRUDER, number) => Step::Extruder(on),
            Some(signal) => Step::Signal { signal, on },
            None => return Err(line.unexpected_at(place, "an output that a remark of the main names")),
        }
    } else if line.take("AO[") {
        let number = line.number("an output", 1.0, MAX_NUMBER)?;
        line.expect("]=")?;
        let count = line.number("counts of the output", 0.0, 65535.0)?;
        match (signals.number(FULL_SCALE), signals.number(COUNTS)) {
            (Some(full), Some(counts)) if signals.is(FILAMENT, number) && counts >= 1.0 && count <= counts => {
                Step::FilamentSpeed(count / counts * full)
            }
            _ => return Err(line.unexpected_at(place, "counts of the output that remarks of the main name")),
        }
    } else if line.take("WAIT DI[") {
        let number = line.number("an input", 1.0, MAX_NUMBER)?;
        line.expect("]=ON")?;
        let input = HeadInput::ALL.into_iter().find(|input| signals.is(HEAD_INPUTS[input.number()], number));
        Step::Wait(input.ok_or_else(|| line.unexpected_at(place, "an input that a remark of the main names"))?)
    } else {
        return Err(line.unexpected("L P, J P, DO, AO, WAIT DI, UFRAME_NUM or UTOOL_NUM"));
    };
    Ok(Some(Instruction::Step(step)))
}

/// `7] 20.5mm/sec CNT50 RTCP COORD`, from behind `L P[` or `J P[`.
fn motion(line: &mut Line, signals: &Signals, is_line: bool, place: [u64; 2]) -> Result<Instruction, ReadError> {
    let number = line.number("the number of a position", 1.0, MAX_NUMBER)? as u32;
    line.expect("]")?;
    let speed = if is_line {
        let mm_s = line.number("a speed in mm/s", 1e-3, MAX_NUMBER)?;
        line.expect("mm/sec")?;
        Speed { mm_s, ..Speed::default() }
    } else {
        let percent = line.number("a percentage", 1.0, 100.0)?;
        line.expect("%")?;
        let full = signals.number(AXIS_SPEED).unwrap_or(100.0).to_radians();
        Speed { rad_s: percent / 100.0 * full, ..Speed::default() }
    };
    let zone = if line.take("FINE") {
        Zone::Stop
    } else {
        line.expect("CNT")?;
        let percent = line.number("CNT, 0 to 100", 0.0, 100.0)?;
        if percent > 0.0 { Zone::Blend(TpOptions::CNT_MM) } else { Zone::Stop }
    };
    while line.take("RTCP") || line.take("COORD") {}
    Ok(Instruction::Move { number, is_line, speed, zone, place })
}

type Positions = BTreeMap<u32, (Position, Option<ExternalAxes>)>;

/// All positions of `/POS`.
fn positions<R: BufRead>(tokens: &mut Tokens<R>, signals: &Signals) -> Result<Positions, ReadError> {
    let in_hand = signals.number(IN_HAND).is_some();
    let mut positions = Positions::new();
    loop {
        let Some(mut line) = Line::raw(tokens)? else { return Err(Line::default().unexpected("/END")) };
        if line.take("/END") {
            return Ok(positions);
        }
        line.expect("P[")?;
        let number = line.number("the number of a position", 1.0, MAX_NUMBER)? as u32;
        line.expect("]{")?;
        if positions.contains_key(&number) || positions.len() >= MAX_LINES {
            return Err(line.unexpected("a position that is not there yet"));
        }
        positions.insert(number, position(tokens, in_hand)?);
    }
}

/// The groups of a position, up to `};`.
fn position<R: BufRead>(tokens: &mut Tokens<R>, in_hand: bool) -> Result<(Position, Option<ExternalAxes>), ReadError> {
    let mut group = 0;
    let mut conf = None;
    let mut place: [Option<f64>; 6] = [None; 6];
    let mut joints: [[Option<f64>; 6]; 2] = [[None; 6]; 2];
    let mut track_mm = None;
    loop {
        let Some(mut line) = Line::raw(tokens)? else { return Err(Line::default().unexpected("};")) };
        if line.take("}") {
            let table = match (track_mm, ExternalAxes::new(joints[1])) {
                (Some(_), Some(_)) => return Err(line.unexpected("E1 or GP2, not both")),
                (track_mm, table) => track_mm.map(ExternalAxes::of_track).or(table),
            };
            return whole(&line, in_hand, conf, place, joints[0]).map(|position| (position, table));
        }
        if line.take("GP1:") || line.take("GP2:") {
            group += 1;
            continue;
        }
        if group == 0 || group > 2 {
            return Err(line.unexpected("GP1: or GP2:"));
        }
        while !line.is_empty() {
            if line.take("UF :") || line.take("UT :") {
                line.number("the number of a frame", 0.0, 255.0)?;
            } else if line.take("CONFIG :") {
                conf = Some(config(&mut line)?);
            } else if group == 1 && line.take("E1") {
                line.expect("=")?;
                let mm = line.number("the position of a track", -MAX_NUMBER, MAX_NUMBER)?;
                line.expect("mm")?;
                if track_mm.replace(mm).is_some() {
                    return Err(line.unexpected("each component once"));
                }
            } else {
                component(&mut line, &mut place, &mut joints[group - 1])?;
            }
            line.take(",");
        }
    }
}

/// `X = 1.5 mm`, `W = 90 deg` or `J1= 90 deg`.
fn component(line: &mut Line, place: &mut [Option<f64>; 6], joints: &mut [Option<f64>; 6]) -> Result<(), ReadError> {
    const POSE: [&str; 6] = ["X", "Y", "Z", "W", "P", "R"];
    const JOINTS: [&str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];
    let mut found = None;
    for (k, slot) in place.iter_mut().enumerate() {
        if found.is_none() && line.take(POSE[k]) {
            found = Some((slot, k < 3));
        }
    }
    for (k, slot) in joints.iter_mut().enumerate() {
        if found.is_none() && line.take(JOINTS[k]) {
            found = Some((slot, false));
        }
    }
    let Some((slot, is_length)) = found else { return Err(line.unexpected("X to R, or J1 to J6")) };
    line.expect("=")?;
    let value = line.number("a coordinate or an angle", -MAX_NUMBER, MAX_NUMBER)?;
    line.expect(if is_length { "mm" } else { "deg" })?;
    let value = if is_length { value } else { value.to_radians() };
    if slot.replace(value).is_some() { Err(line.unexpected("each component once")) } else { Ok(()) }
}

/// `'N U T, 0, 0, 0'`
fn config(line: &mut Line) -> Result<ConfData, ReadError> {
    line.expect("'")?;
    let mut letters = [' '; 3];
    for letter in &mut letters {
        *letter = line.letter();
    }
    let mut turns = [0; 3];
    for turn in &mut turns {
        line.expect(",")?;
        *turn = line.number("whole turns of a joint", -1000.0, 1000.0)? as i32;
    }
    line.expect("'")?;
    conf(letters, [turns[0], turns[2]]).ok_or_else(|| line.unexpected("N or F, U or D, T or B"))
}

/// What a position is, if all of it was there.
fn whole(
    line: &Line,
    in_hand: bool,
    config: Option<ConfData>,
    place: [Option<f64>; 6],
    joints: [Option<f64>; 6],
) -> Result<Position, ReadError> {
    let all = |values: [Option<f64>; 6]| -> Option<[f64; 6]> {
        values.iter().all(Option::is_some).then(|| values.map(Option::unwrap_or_default))
    };
    match (config, all(place), all(joints)) {
        (Some(conf), Some(numbers), None) => {
            let written = pose(numbers);
            let pose = if in_hand { written.inverse() } else { written };
            Ok(Position::Pose(Target { pose, conf }))
        }
        (None, None, Some(joints)) => Ok(Position::Joints(joints)),
        _ => Err(line.unexpected("CONFIG and X to R, or J1 to J6, before the end of a position")),
    }
}
