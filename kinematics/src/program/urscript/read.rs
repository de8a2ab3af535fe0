//! URScript, read. [`UrScriptReader`] states what it knows.

use super::signals::{self, Units};
use super::{FRAMES, MM_PER_M};
use crate::program::check::MAX_NUMBER;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{
    ConfData, Goal, HeadInput, Move, Payload, ReadError, Speed, Step, Target, Zone, step::until_error,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::io::BufRead;

/// The steps of a program, one after the other, in constant memory. Ends after the first error.
///
/// # What is read
/// What [`write_urscript`](super::write_urscript) writes, in any layout, with comments, and with a sign before any
/// number: a function without arguments; `work=p[..]` or, with the part in the hand, `nozzle=p[..]`; `set_tcp`;
/// `set_payload`; then `movel`, `movep`, `movej`, `servoj`, `stopj`, `set_standard_digital_out`,
/// `set_standard_analog_out` and `filament_full_scale=`, outputs of a tape head by name (`tape_cut=6`), and
/// waits for its inputs (`while (not get_standard_digital_in(tape_hot)): sync() end`); of an extruder at Modbus or a socket
/// ([`UrExtruder`](super::UrExtruder)) the calls that set it up, `modbus_set_output_signal`, `modbus_set_output_register` and `socket_send_line`. All else is an error with line and column, and so is a number
/// that no writer of ours takes (beyond 1e6 mm, rad, mm/s or s).
///
/// What the file does not say comes back as the default: configuration data, and of [`Speed`] what the instruction
/// does not take. With the part in the hand, speeds are those of the TCP, as they stand in the file.
#[derive(Debug)]
pub struct UrScriptReader<R> {
    tokens: Tokens<R>,
    head: Head,
    units: Units,
    over: bool,
}

/// What stands before the first step.
#[derive(Debug)]
struct Head {
    name: String,
    part_in_hand: bool,
    /// What targets go through.
    frame: Isometry3<f64>,
    tcp: Isometry3<f64>,
    payload: Option<Payload>,
}

impl<R: BufRead> UrScriptReader<R> {
    /// Reads the head of a program.
    ///
    /// # Errors
    /// [`ReadError`] with line and column.
    pub fn new(reader: R) -> Result<Self, ReadError> {
        let mut tokens = Tokens::new(reader, b'#');
        tokens.expect_word("def")?;
        let name = tokens.name("the program's name")?;
        tokens.marks("():")?;
        let token = tokens.next()?;
        let frame = FRAMES.iter().position(|frame| tokens.is_word(token, frame));
        let part_in_hand = frame.ok_or_else(|| tokens.unexpected("work or nozzle", token))? == 1;
        tokens.marks("=")?;
        let frame = pose(&mut tokens)?;
        tokens.expect_word("set_tcp")?;
        tokens.marks("(")?;
        let tcp = pose(&mut tokens)?;
        tokens.marks(")")?;
        let mut head = Head { name, part_in_hand, frame, tcp, payload: None };
        let token = tokens.peek()?;
        if tokens.is_word(token, "set_payload") {
            tokens.next()?;
            tokens.marks("(")?;
            let mass_kg = tokens.within("a mass in kg", 0.0, MAX_NUMBER)?;
            tokens.marks(",")?;
            let centre = tokens.numbers::<3>("a coordinate")?.map(|metres| metres * MM_PER_M);
            tokens.marks(")")?;
            head.payload = Some(Payload { mass_kg, centre: centre.into() });
        }
        Ok(UrScriptReader { tokens, head, units: Units::default(), over: false })
    }

    /// The program's name.
    pub fn name(&self) -> &str {
        &self.head.name
    }

    /// Whether the robot holds the part.
    pub fn part_in_hand(&self) -> bool {
        self.head.part_in_hand
    }

    /// The work object: `base_work`, or `flange_work` in the hand.
    pub fn work(&self) -> &Isometry3<f64> {
        if self.head.part_in_hand { &self.head.tcp } else { &self.head.frame }
    }

    /// The tool: `flange_tool`, or `base_tool` if the part is in the hand.
    pub fn tool(&self) -> &Isometry3<f64> {
        if self.head.part_in_hand { &self.head.frame } else { &self.head.tcp }
    }

    /// What the flange carries, if the program says so.
    pub fn payload(&self) -> Option<&Payload> {
        self.head.payload.as_ref()
    }
}

/// `servoj([..],t=0.008,lookahead_time=0.03,gain=2000)`, from the bracket on. Look-ahead and gain belong to the controller.
fn servo(tokens: &mut Tokens<impl BufRead>) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    let joints = tokens.numbers("a joint")?;
    argument(tokens, "t")?;
    let seconds = tokens.positive("a time", 1.0)?;
    argument(tokens, "lookahead_time")?;
    tokens.number()?;
    argument(tokens, "gain")?;
    tokens.number()?;
    tokens.marks(")")?;
    Ok(Step::Servo { joints, seconds })
}

/// The end of the file behind `end`. A file that starts itself calls its function before.
fn end(tokens: &mut Tokens<impl BufRead>, name: &str) -> Result<(), ReadError> {
    let mut token = tokens.next()?;
    if tokens.is_word(token, name) {
        tokens.marks("()")?;
        token = tokens.next()?;
    }
    match token {
        Token::End => Ok(()),
        more => Err(tokens.unexpected("the end of the file", more)),
    }
}

/// The next step; `None` at the end of the program.
fn step(
    tokens: &mut Tokens<impl BufRead>,
    name: &str,
    part_in_hand: bool,
    units: &mut Units,
) -> Result<Option<Step>, ReadError> {
    loop {
        let token = tokens.next()?;
        if tokens.is_word(token, "movel") || tokens.is_word(token, "movep") {
            tokens.marks("(")?;
            let goal = Goal::Line(target(tokens, part_in_hand)?);
            let [mm_s, radius] = speed_and_blend(tokens, MM_PER_M)?;
            let speed = Speed { mm_s, ..Speed::default() };
            return Ok(Some(step_of(goal, speed, radius)));
        } else if tokens.is_word(token, "movej") {
            tokens.marks("(")?;
            let goal = match tokens.peek()? {
                Token::Mark(b'[') => Goal::Joints(tokens.numbers("a joint")?),
                _ => Goal::JointMove(target(tokens, part_in_hand)?),
            };
            let [rad_s, radius] = speed_and_blend(tokens, 1.0)?;
            return Ok(Some(step_of(goal, Speed { rad_s, ..Speed::default() }, radius)));
        } else if tokens.is_word(token, "servoj") {
            return servo(tokens).map(Some);
        } else if let Some(found) = signals::read(tokens, token, units)? {
            if found.is_some() {
                return Ok(found);
            }
        } else if input_of(tokens, token).is_some() {
            tokens.marks("=")?;
            tokens.whole()?;
        } else if tokens.is_word(token, "while") {
            return wait(tokens).map(Some);
        } else if tokens.is_word(token, "stopj") {
            tokens.marks("(")?;
            tokens.number()?;
            tokens.marks(")")?;
        } else if tokens.is_word(token, "end") {
            return end(tokens, name).map(|()| None);
        } else {
            return Err(tokens.unexpected("movel, movep, movej, servoj, stopj, a signal, a wait or end", token));
        }
    }
}

/// The input of a tape head whose name stands there.
fn input_of<R: BufRead>(tokens: &Tokens<R>, token: Token) -> Option<HeadInput> {
    HeadInput::ALL.into_iter().find(|input| tokens.is_word(token, input.urscript()))
}

/// `(not get_standard_digital_in(tape_hot)): sync() end`
fn wait(tokens: &mut Tokens<impl BufRead>) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    tokens.expect_word("not")?;
    tokens.expect_word("get_standard_digital_in")?;
    tokens.marks("(")?;
    let token = tokens.next()?;
    let input = input_of(tokens, token).ok_or_else(|| tokens.unexpected("tool_ready, tape_hot or tape_fed", token))?;
    tokens.marks(")):")?;
    tokens.expect_word("sync")?;
    tokens.marks("()")?;
    tokens.expect_word("end")?;
    Ok(Step::Wait(input))
}

fn step_of(goal: Goal, speed: Speed, radius: f64) -> Step {
    let zone = if radius > 0.0 { Zone::Blend(radius) } else { Zone::Stop };
    Step::Move(Move { goal, table: None, speed, zone })
}

/// `,name=`
fn argument(tokens: &mut Tokens<impl BufRead>, name: &'static str) -> Result<(), ReadError> {
    tokens.marks(",")?;
    tokens.expect_word(name)?;
    tokens.marks("=")
}

/// `,a=..,v=..,r=..)`: speed, in so many units of ours, and radius in millimetres.
fn speed_and_blend(tokens: &mut Tokens<impl BufRead>, unit: f64) -> Result<[f64; 2], ReadError> {
    argument(tokens, "a")?;
    tokens.positive("an acceleration", 1.0)?;
    argument(tokens, "v")?;
    let speed = tokens.positive("a speed", unit)?;
    argument(tokens, "r")?;
    let radius = tokens.within("a radius", 0.0, MAX_NUMBER / MM_PER_M)? * MM_PER_M;
    tokens.marks(")")?;
    Ok([speed, radius])
}

/// `pose_trans(work,p[..])`, or with `nozzle` and the inverse pose.
fn target(tokens: &mut Tokens<impl BufRead>, part_in_hand: bool) -> Result<Target, ReadError> {
    tokens.expect_word("pose_trans")?;
    tokens.marks("(")?;
    tokens.expect_word(FRAMES[usize::from(part_in_hand)])?;
    tokens.marks(",")?;
    let written = pose(tokens)?;
    tokens.marks(")")?;
    Ok(Target { pose: if part_in_hand { written.inverse() } else { written }, conf: ConfData::default() })
}

/// `p[x,y,z,rx,ry,rz]`
fn pose(tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
    tokens.expect_word("p")?;
    tokens.marks("[")?;
    let mut values = [0.0; 6];
    for (k, value) in values.iter_mut().enumerate() {
        if k > 0 {
            tokens.marks(",")?;
        }
        *value = if k < 3 {
            tokens.within("a coordinate in metres", -MAX_NUMBER / MM_PER_M, MAX_NUMBER / MM_PER_M)? * MM_PER_M
        } else {
            tokens.within("a rotation in radians", -MAX_NUMBER, MAX_NUMBER)?
        };
    }
    tokens.marks("]")?;
    let [x, y, z, rx, ry, rz] = values;
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz));
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), turn))
}

impl<R: BufRead> Iterator for UrScriptReader<R> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let Head { name, part_in_hand, .. } = &self.head;
        until_error(&mut self.over, || step(&mut self.tokens, name, *part_in_hand, &mut self.units))
    }
}
