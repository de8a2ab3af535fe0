//! RAPID, read: what [`write_rapid`](super::write_rapid) writes, in any layout, with comments.
//!
//! An instruction that is not known is an error: to pass over a move would be another program.

use super::{NAMED_TURN_RAD_S, NO_AXIS, RapidTool, RapidWorkObject, SPEEDS, ZONES};
use crate::program::tokens::{Token, Tokens};
use crate::program::{ConfData, Goal, Move, ReadError, Speed, Step, Target, Zone, until_error};
use nalgebra::{Isometry3, Point3, Translation3};
use std::io::{self, BufRead};

/// What stands in a main module.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidMain {
    /// Its name.
    pub name: String,
    /// The tool, where it is not `tool0`.
    pub tool: Option<RapidTool>,
    /// The work object, where it is not `wobj0`.
    pub work_object: Option<RapidWorkObject>,
    /// The files it loads, in turn.
    pub modules: Vec<String>,
}

impl RapidMain {
    /// Reads a main module.
    ///
    /// # Errors
    /// [`ReadError`] with line and column.
    pub fn read(reader: impl BufRead) -> Result<Self, ReadError> {
        let mut tokens = Tokens::new(reader, b'!');
        tokens.expect_word("MODULE")?;
        let name = tokens.name("the module's name")?;
        let mut main = RapidMain { name, tool: None, work_object: None, modules: Vec::new() };
        loop {
            let token = tokens.next()?;
            if tokens.is_word(token, "PERS") {
                main.declaration(&mut tokens)?;
            } else if tokens.is_word(token, "PROC") {
                break;
            } else {
                return Err(tokens.unexpected("PERS or PROC", token));
            }
        }
        tokens.expect_word("main")?;
        tokens.marks("()")?;
        loop {
            let token = tokens.next()?;
            if tokens.is_word(token, "ConfJ") || tokens.is_word(token, "ConfL") {
                tokens.marks("\\")?;
                tokens.name("On or Off")?;
                tokens.marks(";")?;
            } else if tokens.is_word(token, "Load") {
                tokens.marks("\\")?;
                tokens.expect_word("Dynamic")?;
                tokens.marks(",")?;
                main.modules.push(file(&mut tokens)?);
            } else if tokens.is_word(token, "UnLoad") {
                file(&mut tokens)?;
            } else if token == Token::Mark(b'%') {
                tokens.string("the name of a procedure")?;
                tokens.marks("%;")?;
            } else if tokens.is_word(token, "ENDPROC") {
                break;
            } else {
                return Err(tokens.unexpected("Load, UnLoad, a call, ConfJ, ConfL or ENDPROC", token));
            }
        }
        end(&mut tokens)?;
        Ok(main)
    }

    fn declaration(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
        let kind = tokens.next()?;
        if tokens.is_word(kind, "tooldata") {
            let name = tokens.name("the tool's name")?;
            tokens.marks(":=[")?;
            let in_hand = truth(tokens)?;
            tokens.marks(",")?;
            let frame = pose(tokens)?;
            tokens.marks(",[")?;
            let mass_kg = tokens.number()?;
            tokens.marks(",")?;
            let centre = Point3::from(tokens.numbers::<3>()?);
            tokens.marks(",")?;
            tokens.numbers::<4>()?;
            for _ in 0..3 {
                tokens.marks(",")?;
                tokens.number()?;
            }
            tokens.marks("]];")?;
            self.tool = Some(RapidTool { name, in_hand, frame, mass_kg, centre });
        } else if tokens.is_word(kind, "wobjdata") {
            let name = tokens.name("the work object's name")?;
            tokens.marks(":=[")?;
            let in_hand = truth(tokens)?;
            tokens.marks(",")?;
            let fixed = truth(tokens)?;
            tokens.marks(",")?;
            let unit = tokens.string("the name of a mechanical unit")?;
            let unit = (!fixed).then_some(unit);
            tokens.marks(",")?;
            let user = pose(tokens)?;
            tokens.marks(",")?;
            let object = pose(tokens)?;
            tokens.marks("];")?;
            self.work_object = Some(RapidWorkObject { name, in_hand, frame: user * object, unit });
        } else {
            return Err(tokens.unexpected("tooldata or wobjdata", kind));
        }
        Ok(())
    }
}

/// `"HOME:"\File:="name.mod";`
fn file(tokens: &mut Tokens<impl BufRead>) -> Result<String, ReadError> {
    tokens.string("the folder")?;
    tokens.marks("\\")?;
    tokens.expect_word("File")?;
    tokens.marks(":=")?;
    let file = tokens.string("the file")?;
    tokens.marks(";")?;
    Ok(file)
}

fn truth(tokens: &mut Tokens<impl BufRead>) -> Result<bool, ReadError> {
    let token = tokens.next()?;
    let is = tokens.is_word(token, "TRUE");
    if is || tokens.is_word(token, "FALSE") { Ok(is) } else { Err(tokens.unexpected("TRUE or FALSE", token)) }
}

/// `[[x,y,z],[q1,q2,q3,q4]]`
fn pose(tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
    let pose = open_pose(tokens)?;
    tokens.marks("]")?;
    Ok(pose)
}

fn open_pose(tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
    tokens.marks("[")?;
    let place = tokens.numbers::<3>()?;
    tokens.marks(",")?;
    let quaternion = tokens.numbers::<4>()?;
    Ok(Isometry3::from_parts(Translation3::from(place), tokens.rotation(quaternion)?))
}

/// `ENDMODULE` and nothing more.
fn end(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    tokens.expect_word("ENDMODULE")?;
    match tokens.next()? {
        Token::End => Ok(()),
        more => Err(tokens.unexpected("the end of the file", more)),
    }
}

/// The steps of a part module, one after the other, in constant memory. Ends after the first error.
#[derive(Debug)]
pub struct RapidPart<R> {
    tokens: Tokens<R>,
    over: bool,
}

impl<R: BufRead> RapidPart<R> {
    /// Reads the module's head.
    ///
    /// # Errors
    /// [`ReadError`] when it is no part module.
    pub fn new(reader: R) -> Result<Self, ReadError> {
        let mut tokens = Tokens::new(reader, b'!');
        tokens.expect_word("MODULE")?;
        tokens.name("the module's name")?;
        tokens.expect_word("PROC")?;
        tokens.name("the procedure's name")?;
        tokens.marks("()")?;
        Ok(RapidPart { tokens, over: false })
    }
}

/// The next step; `None` at the end of the module.
fn step(tokens: &mut Tokens<impl BufRead>) -> Result<Option<Step>, ReadError> {
    let token = tokens.next()?;
    let goal: fn(Target) -> Goal = if tokens.is_word(token, "MoveL") {
        Goal::Line
    } else if tokens.is_word(token, "MoveJ") {
        Goal::Swing
    } else if tokens.is_word(token, "MoveAbsJ") {
        tokens.marks("[")?;
        let joints = tokens.numbers::<6>()?.map(f64::to_radians);
        let table = table(tokens)?;
        return rest(tokens, Goal::Joints(joints), table).map(Some);
    } else if tokens.is_word(token, "SetDO") {
        tokens.name("the signal")?;
        tokens.marks(",")?;
        let value = tokens.whole()?;
        if !(0..=1).contains(&value) {
            return Err(tokens.wrong("a digital signal", f64::from(value)));
        }
        tokens.marks(";")?;
        return Ok(Some(Step::Extruder(value == 1)));
    } else if tokens.is_word(token, "SetAO") {
        tokens.name("the signal")?;
        tokens.marks(",")?;
        let mm_s = tokens.up_to("a speed of the filament", f64::INFINITY)?;
        tokens.marks(";")?;
        return Ok(Some(Step::FilamentSpeed(mm_s)));
    } else if tokens.is_word(token, "ENDPROC") {
        end(tokens)?;
        return Ok(None);
    } else {
        return Err(tokens.unexpected("MoveL, MoveJ, MoveAbsJ, SetDO, SetAO or ENDPROC", token));
    };
    let pose = open_pose(tokens)?;
    tokens.marks(",[")?;
    let mut conf = [0; 4];
    for (k, entry) in conf.iter_mut().enumerate() {
        if k > 0 {
            tokens.marks(",")?;
        }
        *entry = tokens.whole()?;
    }
    tokens.marks("]")?;
    let [cf1, cf4, cf6, cfx] = conf;
    let table = table(tokens)?;
    rest(tokens, goal(Target { pose, conf: ConfData { cf1, cf4, cf6, cfx } }), table).map(Some)
}

/// The external axes and the end of the target.
fn table(tokens: &mut Tokens<impl BufRead>) -> Result<Option<[f64; 2]>, ReadError> {
    tokens.marks(",")?;
    let axes = tokens.numbers::<6>()?;
    tokens.marks("]")?;
    // The controller's own files have 9E+09.
    match axes.map(|axis| axis > 0.9 * NO_AXIS) {
        [true, true, true, true, true, true] => Ok(None),
        [false, false, true, true, true, true] => Ok(Some([axes[0].to_radians(), axes[1].to_radians()])),
        _ => Err(tokens.wrong("the last of other external axes than none or the first two", axes[5])),
    }
}

/// Speed, zone, tool and work object.
fn rest(tokens: &mut Tokens<impl BufRead>, goal: Goal, table: Option<[f64; 2]>) -> Result<Step, ReadError> {
    tokens.marks(",")?;
    let speed = match tokens.peek()? {
        Token::Word(from, to) => {
            let token = tokens.next()?;
            let digits = tokens.word_at(from, to).strip_prefix(b"v").and_then(|digits| str::from_utf8(digits).ok());
            let named = digits.and_then(|digits| digits.parse::<u32>().ok()).filter(|n| SPEEDS.contains(n));
            let named = named.ok_or_else(|| tokens.unexpected("speeddata or the name of one", token))?;
            Speed { mm_s: f64::from(named), rad_s: NAMED_TURN_RAD_S }
        }
        _ => {
            tokens.marks("[")?;
            let mm_s = tokens.positive("a speed")?;
            tokens.marks(",")?;
            let rad_s = tokens.positive("a speed of turning")?.to_radians();
            for _ in 0..2 {
                tokens.marks(",")?;
                tokens.number()?;
            }
            tokens.marks("]")?;
            Speed { mm_s, rad_s }
        }
    };
    tokens.marks(",")?;
    let zone = zone(tokens)?;
    tokens.marks(",")?;
    tokens.name("the tool")?;
    if tokens.peek()? == Token::Mark(b'\\') {
        tokens.marks("\\")?;
        tokens.expect_word("WObj")?;
        tokens.marks(":=")?;
        tokens.name("the work object")?;
    }
    tokens.marks(";")?;
    Ok(Step::Move(Move { goal, table, speed, zone }))
}

fn zone(tokens: &mut Tokens<impl BufRead>) -> Result<Zone, ReadError> {
    let token = tokens.next()?;
    if tokens.is_word(token, "fine") {
        return Ok(Zone::Stop);
    }
    if token == Token::Mark(b'[') {
        let stops = truth(tokens)?;
        tokens.marks(",")?;
        let radius = if stops { tokens.number()? } else { tokens.positive("the radius of a zone")? };
        for _ in 0..5 {
            tokens.marks(",")?;
            tokens.number()?;
        }
        tokens.marks("]")?;
        return Ok(if stops { Zone::Stop } else { Zone::Blend(radius) });
    }
    let named = ZONES.iter().find(|(name, _)| tokens.is_word(token, name));
    named.map(|(_, [radius, ..])| Zone::Blend(*radius)).ok_or_else(|| tokens.unexpected("a zone", token))
}

impl<R: BufRead> Iterator for RapidPart<R> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        until_error(&mut self.over, || step(&mut self.tokens))
    }
}

/// The steps of a whole program, module by module. Made by [`read_rapid`].
pub struct RapidProgram<R, F> {
    main: RapidMain,
    open: F,
    /// The next module.
    index: usize,
    part: Option<RapidPart<R>>,
}

/// Reads a program: the main module, and the modules it loads as `open` gives them by their file names.
///
/// # Errors
/// [`ReadError`] with line and column. A module that cannot be opened, or read, comes as an item of the iterator, with
/// its index, and ends it.
pub fn read_rapid<R: BufRead, F: FnMut(&str) -> io::Result<R>>(
    main: impl BufRead,
    open: F,
) -> Result<RapidProgram<R, F>, ReadError> {
    Ok(RapidProgram { main: RapidMain::read(main)?, open, index: 0, part: None })
}

impl<R, F> RapidProgram<R, F> {
    /// The main module.
    pub fn main(&self) -> &RapidMain {
        &self.main
    }
}

impl<R: BufRead, F: FnMut(&str) -> io::Result<R>> Iterator for RapidProgram<R, F> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let failed = if let Some(part) = &mut self.part {
                match part.next() {
                    Some(Ok(step)) => return Some(Ok(step)),
                    Some(Err(source)) => {
                        let index = self.index - 1;
                        let file = self.main.modules[index].clone();
                        ReadError::InPart { index, file, source: Box::new(source) }
                    }
                    None => {
                        self.part = None;
                        continue;
                    }
                }
            } else {
                let index = self.index;
                let file = self.main.modules.get(index)?.clone();
                self.index += 1;
                match (self.open)(&file).map(RapidPart::new) {
                    Ok(Ok(part)) => {
                        self.part = Some(part);
                        continue;
                    }
                    Ok(Err(source)) => ReadError::InPart { index, file, source: Box::new(source) },
                    Err(source) => ReadError::Part { index, file, source },
                }
            };
            (self.part, self.index) = (None, self.main.modules.len());
            return Some(Err(failed));
        }
    }
}
