//! What a RAPID program has declared, and what the controller knows by itself; warnings of the reader.

use super::op::Op;
use super::{
    FILAMENT_STEP, NAMED_TURN_RAD_S, NO_AXIS, NO_MASS, RapidAcceleration, RapidTool, RapidWorkObject, SPEEDS, TOOL0,
    WOBJ0, ZONES,
};
use crate::program::check::MAX_NUMBER;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{ConfData, ExternalAxes, HeadSignal, Payload, ReadError, Speed, Step, Target, Zone};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::io::BufRead;

/// How far the length of a quaternion in a file may be from 1: of three digits, or two.
const UNIT: f64 = 1e-2;
/// From which on that is worth a warning: of four digits.
const ROUNDED: f64 = 2e-4;
/// Warnings that are kept.
const KEPT: usize = 1000;
/// Declarations of a program.
const DECLARATIONS: usize = 1_000_000;
/// What `vmax` is read as, mm/s: the fastest speed that has a number.
const VMAX_MM_S: f64 = 7000.0;
/// No controller has more, in kg.
const MAX_MASS_KG: f64 = 1e5;

/// Something in a program that was read in a way that the reader of it should know. Lines and columns count from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadWarning {
    /// The file of a loaded module; `None` for the one that was read first.
    pub file: Option<String>,
    /// The line.
    pub line: u64,
    /// The column, in bytes.
    pub column: u64,
    /// What it is.
    pub what: String,
}

impl fmt::Display for ReadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ReadWarning { file, line, column, what } = self;
        match file {
            Some(file) => write!(f, "`{file}`, line {line}, column {column}: {what}"),
            None => write!(f, "line {line}, column {column}: {what}"),
        }
    }
}

/// The pose of a target and the axes beside it.
pub(super) type FullTarget = (Target, Option<ExternalAxes>);
/// Joints and the axes beside them.
pub(super) type FullJoints = ([f64; 6], Option<ExternalAxes>);

/// What a name stands for.
#[derive(Clone, Debug)]
enum Datum {
    Target(FullTarget),
    Joints(FullJoints),
    Speed(Speed),
    Zone(Zone),
    Tool(RapidTool),
    Work(RapidWorkObject),
    /// Declared, but of no use here.
    Other,
}

/// All that is declared, and the names that moves and signals use.
#[derive(Debug, Default)]
pub(super) struct Data {
    /// By name in lower case, with the number of the module.
    names: BTreeMap<String, (u32, Datum)>,
    module: u32,
    pub file: Option<String>,
    pub warnings: Vec<ReadWarning>,
    /// Tool and work object of the moves, in lower case.
    used: [Option<String>; 2],
    /// The first that are declared.
    first: [Option<String>; 2],
    /// Digital output, output of the filament, in lower case.
    signals: [Option<String>; 2],
    pub filament_step: Option<f64>,
    /// What `TriggEquip` and `TriggIO` have set up: by name in lower case, whether it comes at the begin of a move, and what.
    pub triggers: BTreeMap<String, (bool, Step)>,
    /// The rest of an instruction of several steps.
    pub queue: VecDeque<(Op, (u64, u64))>,
    /// The last accelerations that were set.
    pub acceleration: Option<RapidAcceleration>,
}

/// What a target may be.
const TARGET: &str = "a target";

impl Data {
    /// Another module's declarations come now.
    pub fn begin_module(&mut self, file: Option<&str>) {
        self.module += 1;
        self.file = file.map(str::to_owned);
        self.filament_step = None;
    }

    pub fn warn(&mut self, (line, column): (u64, u64), what: impl Into<String>) {
        if self.warnings.len() < KEPT {
            self.warnings.push(ReadWarning { file: self.file.clone(), line, column, what: what.into() });
        }
    }

    /// The tool of the moves, or the first one that is declared.
    pub fn tool(&self) -> Option<RapidTool> {
        match self.names.get(self.used[0].as_ref().or(self.first[0].as_ref())?) {
            Some((_, Datum::Tool(tool))) => Some(tool.clone()),
            _ => None,
        }
    }

    /// The work object of the moves, or the first one that is declared.
    pub fn work_object(&self) -> Option<RapidWorkObject> {
        match self.names.get(self.used[1].as_ref().or(self.first[1].as_ref())?) {
            Some((_, Datum::Work(work))) => Some(work.clone()),
            _ => None,
        }
    }

    /// Whether the moves have used this tool (0) or work object (1).
    pub fn uses(&self, which: usize, name: &[u8]) -> bool {
        self.used[which].as_ref().is_some_and(|used| used.as_bytes().eq_ignore_ascii_case(name))
    }

    /// The tool (0) or work object (1) of a move: one for the whole program, since steps do not say which is theirs.
    pub fn use_frame<R: BufRead>(&mut self, tokens: &Tokens<R>, which: usize, name: &str) -> Result<(), ReadError> {
        let name = name.to_ascii_lowercase();
        match &self.used[which] {
            Some(used) if *used == name => return Ok(()),
            Some(_) => {
                let expected = ["the same tool as before", "the same work object as before"][which];
                return Err(tokens.unexpected_at(tokens.place(), expected, &name));
            }
            None => {}
        }
        let (installed, expected) =
            [(TOOL0, "a tool that is declared"), (WOBJ0, "a work object that is declared")][which];
        let is_declared = match self.names.get(&name) {
            Some((_, Datum::Tool(_))) => which == 0,
            Some((_, Datum::Work(_))) => which == 1,
            // Of another module, which is not here.
            None => true,
            _ => false,
        };
        if name != installed && !is_declared {
            return Err(tokens.unexpected_at(tokens.place(), expected, &name));
        }
        self.used[which] = Some(name);
        Ok(())
    }

    /// The signal of the extruder (0) or of the filament's speed (1): one of each, for all others would be taken for them.
    pub fn use_signal(&mut self, tokens: &mut Tokens<impl BufRead>, which: usize) -> Result<(), ReadError> {
        let name = tokens.name("the signal")?.to_ascii_lowercase();
        self.use_named(tokens, which, name)
    }

    /// A digital output: one of a tape head by its name, or the extruder.
    pub fn use_digital(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<Option<HeadSignal>, ReadError> {
        let name = tokens.name("the signal")?.to_ascii_lowercase();
        match HeadSignal::ALL.into_iter().find(|signal| signal.rapid().eq_ignore_ascii_case(&name)) {
            Some(signal) => Ok(Some(signal)),
            None => self.use_named(tokens, 0, name).map(|()| None),
        }
    }

    fn use_named(&mut self, tokens: &Tokens<impl BufRead>, which: usize, name: String) -> Result<(), ReadError> {
        match &self.signals[which] {
            None => self.signals[which] = Some(name),
            Some(used) if *used == name => {}
            Some(_) => {
                let expected = ["the digital output of before", "the output of the filament of before"][which];
                return Err(tokens.unexpected_at(tokens.place(), expected, &name));
            }
        }
        Ok(())
    }

    /// A declaration, from the word behind `CONST`, `PERS` or `VAR` on.
    pub fn declare(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
        let kind = tokens.name("a type of data")?.to_ascii_lowercase();
        let name = tokens.name("a name")?;
        let (place, key) = (tokens.place(), name.to_ascii_lowercase());
        if self.names.get(&key).is_some_and(|(module, _)| *module == self.module) {
            return Err(tokens.unexpected_at(place, "a name that is not declared yet", &name));
        }
        if self.names.len() >= DECLARATIONS {
            return Err(tokens.unexpected_at(place, "no more than a million declarations", &name));
        }
        let datum = if tokens.peek()? == Token::Mark(b':') {
            tokens.marks(":=")?;
            self.value(tokens, &kind, &name)?
        } else {
            None
        };
        let datum = match datum {
            Some(datum) => {
                tokens.marks(";")?;
                datum
            }
            // An array, a type that no move needs, or nothing yet: what uses it is an error there.
            None => {
                while tokens.next()? != Token::Mark(b';') {
                    if tokens.peek()? == Token::End {
                        return Err(tokens.unexpected(";", Token::End));
                    }
                }
                Datum::Other
            }
        };
        for (first, is_one) in
            self.first.iter_mut().zip([matches!(datum, Datum::Tool(_)), matches!(datum, Datum::Work(_))])
        {
            if is_one && first.is_none() {
                *first = Some(key.clone());
            }
        }
        self.names.insert(key, (self.module, datum));
        Ok(())
    }

    fn value(&mut self, tokens: &mut Tokens<impl BufRead>, kind: &str, name: &str) -> Result<Option<Datum>, ReadError> {
        Ok(Some(match kind {
            "robtarget" => Datum::Target(self.target(tokens)?),
            "jointtarget" => Datum::Joints(self.joints(tokens)?),
            "speeddata" => Datum::Speed(self.speed(tokens)?),
            "zonedata" => Datum::Zone(self.zone(tokens)?),
            "tooldata" => Datum::Tool(self.tool_value(tokens, name)?),
            "wobjdata" => Datum::Work(self.work_value(tokens, name)?),
            "num" if name.eq_ignore_ascii_case(FILAMENT_STEP) => {
                self.filament_step = Some(tokens.positive("a speed of the filament", 1.0)?);
                Datum::Other
            }
            _ => return Ok(None),
        }))
    }

    fn tool_value(&mut self, tokens: &mut Tokens<impl BufRead>, name: &str) -> Result<RapidTool, ReadError> {
        tokens.marks("[")?;
        let in_hand = truth(tokens)?;
        tokens.marks(",")?;
        let frame = self.pose(tokens)?;
        tokens.marks(",[")?;
        // A tool that was made at the pendant has -1 until it is set.
        let mass_kg = tokens.within("a mass in kg", -1.0, MAX_MASS_KG)?;
        tokens.marks(",")?;
        let centre = Point3::from(tokens.numbers::<3>("a coordinate")?);
        tokens.marks(",")?;
        tokens.numbers::<4>("an entry of a quaternion")?;
        for _ in 0..3 {
            tokens.marks(",")?;
            tokens.number()?;
        }
        tokens.marks("]]")?;
        let load = (mass_kg > NO_MASS).then_some(Payload { mass_kg, centre });
        Ok(RapidTool { name: name.to_owned(), in_hand, frame, load })
    }

    fn work_value(&mut self, tokens: &mut Tokens<impl BufRead>, name: &str) -> Result<RapidWorkObject, ReadError> {
        tokens.marks("[")?;
        let in_hand = truth(tokens)?;
        tokens.marks(",")?;
        let fixed = truth(tokens)?;
        tokens.marks(",")?;
        let unit = tokens.string("the name of a mechanical unit")?;
        let unit = (!fixed).then_some(unit);
        tokens.marks(",")?;
        let user = self.pose(tokens)?;
        tokens.marks(",")?;
        let object = self.pose(tokens)?;
        tokens.marks("]")?;
        Ok(RapidWorkObject { name: name.to_owned(), in_hand, frame: user * object, unit })
    }

    /// `[[x,y,z],[q1,q2,q3,q4]]`
    fn pose(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
        let pose = self.open_pose(tokens)?;
        tokens.marks("]")?;
        Ok(pose)
    }

    fn open_pose(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
        tokens.marks("[")?;
        let place = tokens.numbers::<3>("a coordinate")?;
        tokens.marks(",")?;
        let [w, x, y, z] = tokens.numbers::<4>("an entry of a quaternion")?;
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        let off = (length - 1.0).abs();
        if off > UNIT {
            return Err(tokens.wrong("the length of a rotation's quaternion", length));
        }
        if off > ROUNDED {
            self.warn(
                tokens.place(),
                format!("the quaternion has the length {length:.4}; it is read with the length 1"),
            );
        }
        Ok(Isometry3::from_parts(Translation3::from(place), UnitQuaternion::new_normalize(quaternion)))
    }

    /// `[[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[e1,...]]`
    fn target(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<FullTarget, ReadError> {
        let pose = self.open_pose(tokens)?;
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
        Ok((Target { pose, conf: ConfData { cf1, cf4, cf6, cfx } }, external(tokens)?))
    }

    /// `[[a1,...],[e1,...]]` in degrees.
    fn joints(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<FullJoints, ReadError> {
        tokens.marks("[")?;
        let joints = tokens.numbers::<6>("an angle in degrees")?.map(f64::to_radians);
        Ok((joints, external(tokens)?))
    }

    /// A value, or the name of one.
    fn named(&self, tokens: &mut Tokens<impl BufRead>) -> Result<Option<(String, Option<&Datum>)>, ReadError> {
        let Token::Word(from, to) = tokens.peek()? else { return Ok(None) };
        let name = String::from_utf8_lossy(tokens.word_at(from, to)).to_ascii_lowercase();
        tokens.next()?;
        let datum = self.names.get(&name).map(|(_, datum)| datum);
        Ok(Some((name, datum)))
    }

    /// The target of a `MoveL` or `MoveJ`: a value, a name, or `Offs` or `RelTool` of one.
    pub fn target_or_name(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<FullTarget, ReadError> {
        let (name, place) = match self.named(tokens)? {
            None => return self.target(tokens),
            Some((_, Some(Datum::Target(target)))) => return Ok(*target),
            Some((name, _)) => (name, tokens.place()),
        };
        if name != "offs" && name != "reltool" {
            return Err(tokens.unexpected_at(place, "a robtarget, or the name of one that is declared above", &name));
        }
        tokens.marks("(")?;
        let (mut target, external) = match self.named(tokens)? {
            None => self.target(tokens)?,
            Some((_, Some(Datum::Target(target)))) => *target,
            Some((name, _)) => return Err(tokens.unexpected_at(tokens.place(), TARGET, &name)),
        };
        let mut by = [0.0; 3];
        for value in &mut by {
            tokens.marks(",")?;
            *value = tokens.within("an offset", -MAX_NUMBER, MAX_NUMBER)?;
        }
        tokens.marks(")")?;
        let by = Translation3::from(by);
        target.pose = if name == "offs" { by * target.pose } else { target.pose * by };
        Ok((target, external))
    }

    /// The joints of a `MoveAbsJ`.
    pub fn joints_or_name(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<FullJoints, ReadError> {
        match self.named(tokens)? {
            None => self.joints(tokens),
            Some((_, Some(Datum::Joints(joints)))) => Ok(*joints),
            Some((name, _)) => {
                let expected = "a jointtarget, or the name of one that is declared above";
                Err(tokens.unexpected_at(tokens.place(), expected, &name))
            }
        }
    }

    fn speed(&self, tokens: &mut Tokens<impl BufRead>) -> Result<Speed, ReadError> {
        tokens.marks("[")?;
        let mm_s = tokens.positive("a speed", 1.0)?;
        tokens.marks(",")?;
        let rad_s = tokens.positive("a speed of turning", 1f64.to_radians())?;
        for _ in 0..2 {
            tokens.marks(",")?;
            tokens.number()?;
        }
        tokens.marks("]")?;
        Ok(Speed { mm_s, rad_s })
    }

    pub fn speed_or_name(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<Speed, ReadError> {
        let (name, declared) = match self.named(tokens)? {
            None => return self.speed(tokens),
            Some((name, datum)) => (name, datum.cloned()),
        };
        let place = tokens.place();
        match declared {
            Some(Datum::Speed(speed)) => return Ok(speed),
            Some(_) => return Err(tokens.unexpected_at(place, "speeddata or the name of one", &name)),
            None => {}
        }
        let turning = |mm_s: f64| Speed { mm_s, rad_s: NAMED_TURN_RAD_S };
        if name == "vmax" {
            self.warn(place, "vmax is the fastest speed of the robot; it is read as 7000 mm/s");
            return Ok(turning(VMAX_MM_S));
        }
        let named = name.strip_prefix('v').and_then(|digits| digits.parse::<u32>().ok()).filter(|n| SPEEDS.contains(n));
        let named = named.ok_or_else(|| tokens.unexpected_at(place, "speeddata or the name of one", &name))?;
        Ok(turning(f64::from(named)))
    }

    fn zone(&self, tokens: &mut Tokens<impl BufRead>) -> Result<Zone, ReadError> {
        tokens.marks("[")?;
        let stops = truth(tokens)?;
        tokens.marks(",")?;
        let radius = if stops { tokens.number()? } else { tokens.positive("the radius of a zone", 1.0)? };
        for _ in 0..5 {
            tokens.marks(",")?;
            tokens.number()?;
        }
        tokens.marks("]")?;
        Ok(if stops { Zone::Stop } else { Zone::Blend(radius) })
    }

    pub fn zone_or_name(&self, tokens: &mut Tokens<impl BufRead>) -> Result<Zone, ReadError> {
        let Some((name, declared)) = self.named(tokens)? else { return self.zone(tokens) };
        let named = ZONES.iter().find(|(zone, _)| *zone == name).map(|(_, [radius, ..])| Zone::Blend(*radius));
        match (declared, named) {
            (Some(Datum::Zone(zone)), _) => Ok(*zone),
            (None, _) if name == "fine" => Ok(Zone::Stop),
            (None, Some(zone)) => Ok(zone),
            _ => Err(tokens.unexpected_at(tokens.place(), "a zone", &name)),
        }
    }
}

pub(super) fn truth(tokens: &mut Tokens<impl BufRead>) -> Result<bool, ReadError> {
    let token = tokens.next()?;
    let is = tokens.is_word(token, "TRUE");
    if is || tokens.is_word(token, "FALSE") { Ok(is) } else { Err(tokens.unexpected("TRUE or FALSE", token)) }
}

/// The external axes and the end of the target.
fn external(tokens: &mut Tokens<impl BufRead>) -> Result<Option<ExternalAxes>, ReadError> {
    tokens.marks(",[")?;
    let mut axes = [None; 6];
    for (k, axis) in axes.iter_mut().enumerate() {
        if k > 0 {
            tokens.marks(",")?;
        }
        let value = tokens.number()?;
        // The controller's own files have 9E+09.
        if value > 0.9 * NO_AXIS && value < 1.1 * NO_AXIS {
            continue;
        }
        if value.abs() > MAX_NUMBER {
            return Err(tokens.wrong("the value of an external axis", value));
        }
        *axis = Some(value.to_radians());
    }
    tokens.marks("]]")?;
    Ok(ExternalAxes::new(axes))
}
