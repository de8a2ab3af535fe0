//! URScript, read: what [`write_urscript`](super::write_urscript) writes, in any layout, with comments.

use super::{FULL_SCALE, MM_PER_M};
use crate::program::tokens::{Token, Tokens};
use crate::program::{ConfData, Goal, Move, ReadError, Speed, Step, Target, Zone, until_error};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::io::BufRead;

/// The steps of a program, one after the other, in constant memory. Ends after the first error.
///
/// What the file does not say comes back as the default: configuration data, and of [`Speed`] what the instruction
/// does not take.
#[derive(Debug)]
pub struct UrScriptReader<R> {
    tokens: Tokens<R>,
    name: String,
    work: Isometry3<f64>,
    tool: Isometry3<f64>,
    /// Of the filament's speed, mm/s, once the program has set it.
    full_scale: Option<f64>,
    over: bool,
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
        tokens.expect_word("work")?;
        tokens.marks("=")?;
        let work = pose(&mut tokens)?;
        tokens.expect_word("set_tcp")?;
        tokens.marks("(")?;
        let tool = pose(&mut tokens)?;
        tokens.marks(")")?;
        Ok(UrScriptReader { tokens, name, work, tool, full_scale: None, over: false })
    }

    /// The program's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// `base_work`.
    pub fn work(&self) -> &Isometry3<f64> {
        &self.work
    }

    /// `flange_tool`.
    pub fn tool(&self) -> &Isometry3<f64> {
        &self.tool
    }
}

/// The next step; `None` at the end of the program.
fn step(tokens: &mut Tokens<impl BufRead>, full_scale: &mut Option<f64>) -> Result<Option<Step>, ReadError> {
    loop {
        let token = tokens.next()?;
        if tokens.is_word(token, "movel") || tokens.is_word(token, "movep") {
            tokens.marks("(")?;
            let goal = Goal::Line(target(tokens)?);
            let [mm_s, radius] = speed_and_blend(tokens)?;
            let speed = Speed { mm_s: mm_s * MM_PER_M, ..Speed::default() };
            return Ok(Some(step_of(goal, speed, radius)));
        } else if tokens.is_word(token, "movej") {
            tokens.marks("(")?;
            let goal = match tokens.peek()? {
                Token::Mark(b'[') => Goal::Joints(tokens.numbers()?),
                _ => Goal::Swing(target(tokens)?),
            };
            let [rad_s, radius] = speed_and_blend(tokens)?;
            return Ok(Some(step_of(goal, Speed { rad_s, ..Speed::default() }, radius)));
        } else if tokens.is_word(token, "servoj") {
            tokens.marks("(")?;
            let joints = tokens.numbers()?;
            argument(tokens, "t")?;
            let seconds = tokens.positive("a time")?;
            argument(tokens, "lookahead_time")?;
            tokens.number()?;
            argument(tokens, "gain")?;
            tokens.number()?;
            tokens.marks(")")?;
            return Ok(Some(Step::Servo { joints, seconds }));
        } else if tokens.is_word(token, "set_standard_digital_out") {
            tokens.marks("(")?;
            tokens.whole()?;
            tokens.marks(",")?;
            let token = tokens.next()?;
            let on = tokens.is_word(token, "True");
            if !on && !tokens.is_word(token, "False") {
                return Err(tokens.unexpected("True or False", token));
            }
            tokens.marks(")")?;
            return Ok(Some(Step::Extruder(on)));
        } else if tokens.is_word(token, "set_standard_analog_out") {
            let Some(most) = *full_scale else {
                return Err(tokens.unexpected("filament_full_scale before an analog output", token));
            };
            tokens.marks("(")?;
            tokens.whole()?;
            tokens.marks(",")?;
            let mm_s = tokens.up_to("a speed of the filament from 0 to the full scale", most)?;
            tokens.marks("/")?;
            tokens.expect_word(FULL_SCALE)?;
            tokens.marks(")")?;
            return Ok(Some(Step::FilamentSpeed(mm_s)));
        } else if tokens.is_word(token, FULL_SCALE) {
            tokens.marks("=")?;
            *full_scale = Some(tokens.positive("a speed of the filament")?);
        } else if tokens.is_word(token, "stopj") {
            tokens.marks("(")?;
            tokens.number()?;
            tokens.marks(")")?;
        } else if tokens.is_word(token, "end") {
            return match tokens.next()? {
                Token::End => Ok(None),
                more => Err(tokens.unexpected("the end of the file", more)),
            };
        } else {
            return Err(tokens.unexpected("movel, movep, movej, servoj, stopj, a signal or end", token));
        }
    }
}

fn step_of(goal: Goal, speed: Speed, radius: f64) -> Step {
    let zone = if radius > 0.0 { Zone::Blend(radius * MM_PER_M) } else { Zone::Stop };
    Step::Move(Move { goal, table: None, speed, zone })
}

/// `,name=`
fn argument(tokens: &mut Tokens<impl BufRead>, name: &'static str) -> Result<(), ReadError> {
    tokens.marks(",")?;
    tokens.expect_word(name)?;
    tokens.marks("=")
}

/// `,a=..,v=..,r=..)`
fn speed_and_blend(tokens: &mut Tokens<impl BufRead>) -> Result<[f64; 2], ReadError> {
    argument(tokens, "a")?;
    tokens.positive("an acceleration")?;
    argument(tokens, "v")?;
    let speed = tokens.positive("a speed")?;
    argument(tokens, "r")?;
    let radius = tokens.number()?;
    if radius < 0.0 {
        return Err(tokens.wrong("a radius", radius));
    }
    tokens.marks(")")?;
    Ok([speed, radius])
}

/// `pose_trans(work,p[..])`
fn target(tokens: &mut Tokens<impl BufRead>) -> Result<Target, ReadError> {
    tokens.expect_word("pose_trans")?;
    tokens.marks("(")?;
    tokens.expect_word("work")?;
    tokens.marks(",")?;
    let pose = pose(tokens)?;
    tokens.marks(")")?;
    Ok(Target { pose, conf: ConfData::default() })
}

/// `p[x,y,z,rx,ry,rz]`
fn pose(tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
    tokens.expect_word("p")?;
    let [x, y, z, rx, ry, rz] = tokens.numbers::<6>()?;
    let at = Translation3::new(x * MM_PER_M, y * MM_PER_M, z * MM_PER_M);
    Ok(Isometry3::from_parts(at, UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz))))
}

impl<R: BufRead> Iterator for UrScriptReader<R> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        until_error(&mut self.over, || step(&mut self.tokens, &mut self.full_scale))
    }
}
