//! Instructions of RAPID, read one by one.

use super::RapidAcceleration;
use super::data::{Data, truth};
use super::op::Op;
use crate::program::check::MAX_NUMBER;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{ExternalAxes, Goal, HeadInput, HeadSignal, Move, ReadError, Speed, Step, Zone};
use std::io::BufRead;

/// What may stand in a procedure, for errors.
const KNOWN: &str = "MoveL, MoveJ, MoveAbsJ, SetDO, SetAO, another instruction that is known here, or ENDPROC";

/// Options of a move with triggers, from the second trigger on.
const TRIGGER_OPTIONS: [&str; 7] = ["t2", "t3", "t4", "t5", "t6", "t7", "t8"];

/// Instructions with arguments that change nothing in the steps; with a reason to say so, a warning.
const PASSED: [(&str, Option<&str>); 11] = [
    ("ActUnit", None),
    ("DeactUnit", None),
    ("GripLoad", None),
    ("TPWrite", None),
    ("SingArea", Some("SingArea is not followed: how a singularity is passed is the controller's")),
    ("WaitTime", Some("WaitTime is passed over: steps have no pauses")),
    ("WaitRob", Some("WaitRob is passed over: steps have no pauses")),
    ("WaitDO", Some("WaitDO is passed over: steps have no pauses")),
    ("Stop", Some("Stop is passed over: steps have no pauses")),
    ("TPErase", None),
    ("SpeedRefresh", Some("SpeedRefresh is not followed")),
];

/// The next instruction.
pub(super) fn next(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<(Op, (u64, u64)), ReadError> {
    if let Some(op) = data.queue.pop_front() {
        return Ok(op);
    }
    let token = tokens.next()?;
    let place = tokens.place();
    let step = |step: Step| Ok((Op::Step(step), place));
    if tokens.is_word(token, "MoveL") || tokens.is_word(token, "MoveJ") {
        let is_line = tokens.is_word(token, "MoveL");
        concurrent(tokens, data)?;
        let (target, external) = data.target_or_name(tokens)?;
        let goal = if is_line { Goal::Line(target) } else { Goal::JointMove(target) };
        return step(rest(tokens, data, goal, external, None)?);
    }
    if tokens.is_word(token, "SetDO") {
        return step(digital(tokens, data)?);
    }
    if tokens.is_word(token, "SetAO") {
        data.use_signal(tokens, 1)?;
        tokens.marks(",")?;
        let mm_s = tokens.within("a speed of the filament", 0.0, MAX_NUMBER)?;
        tokens.marks(";")?;
        return step(Step::FilamentSpeed(mm_s));
    }
    if tokens.is_word(token, "MoveAbsJ") {
        concurrent(tokens, data)?;
        let (joints, external) = data.joints_or_name(tokens)?;
        return step(rest(tokens, data, Goal::Joints(joints), external, None)?);
    }
    if tokens.is_word(token, "ENDPROC") {
        return Ok((Op::End, place));
    }
    other(tokens, data, token, place).map(|op| (op, place))
}

/// The instructions that are rare.
fn other(tokens: &mut Tokens<impl BufRead>, data: &mut Data, token: Token, place: (u64, u64)) -> Result<Op, ReadError> {
    if token == Token::Mark(b'%') {
        let name = tokens.string("the name of a procedure")?;
        tokens.marks("%;")?;
        return Ok(Op::Call(name));
    }
    let Token::Word(from, to) = token else { return Err(tokens.unexpected(KNOWN, token)) };
    let word = String::from_utf8_lossy(tokens.word_at(from, to)).into_owned();
    match word.to_ascii_lowercase().as_str() {
        on @ ("set" | "reset") => {
            let signal = data.use_digital(tokens)?;
            tokens.marks(";")?;
            Ok(Op::Step(switched(signal, on == "set")))
        }
        "setgo" => {
            data.use_signal(tokens, 1)?;
            tokens.marks(",")?;
            let mm_s = group_speed(tokens, data, place, &word)?;
            tokens.marks(";")?;
            Ok(Op::Step(Step::FilamentSpeed(mm_s)))
        }
        "waitdi" => wait_digital(tokens, data, place, &word),
        "triggequip" | "triggio" => {
            let (name, trigger) = trigger(tokens, data, place, &word)?;
            data.triggers.insert(name, trigger);
            Ok(Op::Nothing)
        }
        kind @ ("triggl" | "triggj") => triggered_move(tokens, data, kind == "triggl", place),
        "confl" | "confj" => configuration_control(tokens, data, place, &word),
        "accset" | "pathacclim" | "worldacclim" => {
            acceleration(tokens, data, place, &word)?;
            Ok(Op::Nothing)
        }
        "load" => {
            tokens.marks("\\")?;
            tokens.expect_word("Dynamic")?;
            tokens.marks(",")?;
            Ok(Op::Load(file(tokens)?))
        }
        "unload" => {
            file(tokens)?;
            Ok(Op::UnLoad)
        }
        "error" | "backward" | "undo" => handlers(tokens),
        _ => passed_or_called(tokens, data, place, word),
    }
}

/// `WaitDI doTapeReady,1;`. Only the inputs of a tape head become steps: what others are for is unknown.
fn wait_digital(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    place: (u64, u64),
    word: &str,
) -> Result<Op, ReadError> {
    let name = tokens.name("the signal")?;
    let Some(input) = HeadInput::ALL.into_iter().find(|input| input.rapid().eq_ignore_ascii_case(&name)) else {
        skip(tokens)?;
        data.warn(place, "WaitDI is passed over: steps wait for the inputs of a tape head alone");
        return Ok(Op::Nothing);
    };
    tokens.marks(",")?;
    if !digital_value(tokens)? {
        return Err(tokens.unexpected_at(place, "a wait for 1", word));
    }
    tokens.marks(";")?;
    Ok(Op::Step(Step::Wait(input)))
}

/// A move with triggers: the signals of its begin, the move, the signals of its end, in this order.
fn triggered_move(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    is_line: bool,
    place: (u64, u64),
) -> Result<Op, ReadError> {
    concurrent(tokens, data)?;
    let (target, external) = data.target_or_name(tokens)?;
    let goal = if is_line { Goal::Line(target) } else { Goal::JointMove(target) };
    let mut triggers = Vec::new();
    let to = rest(tokens, data, goal, external, Some(&mut triggers))?;
    let at = |begin: bool| triggers.iter().filter(move |trigger| trigger.0 == begin).map(|trigger| trigger.1);
    data.queue.extend(at(true).chain([to]).chain(at(false)).map(|step| (Op::Step(step), place)));
    Ok(Op::Nothing)
}

/// `ConfL\Off;`. Steps have configuration data, so that what switches their use off is worth a warning.
fn configuration_control(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    place: (u64, u64),
    word: &str,
) -> Result<Op, ReadError> {
    tokens.marks("\\")?;
    let to = tokens.name("On or Off")?;
    if to.eq_ignore_ascii_case("Off") {
        data.warn(place, format!("{word}\\Off: the controller may take other configurations than the targets have"));
    } else if !to.eq_ignore_ascii_case("On") {
        return Err(tokens.unexpected_at(tokens.place(), "On or Off", &to));
    }
    tokens.marks(";")?;
    Ok(Op::Nothing)
}

/// Handlers at the end of a procedure: no step comes out of them while all goes well.
fn handlers(tokens: &mut Tokens<impl BufRead>) -> Result<Op, ReadError> {
    loop {
        let token = tokens.next()?;
        if tokens.is_word(token, "ENDPROC") {
            return Ok(Op::End);
        }
        if token == Token::End {
            return Err(tokens.unexpected("ENDPROC", token));
        }
    }
}

/// An instruction that changes no step, else a call of a procedure without arguments.
fn passed_or_called(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    place: (u64, u64),
    word: String,
) -> Result<Op, ReadError> {
    if let Some((_, reason)) = PASSED.iter().find(|(known, _)| known.eq_ignore_ascii_case(&word)) {
        skip(tokens)?;
        if let Some(reason) = reason {
            data.warn(place, *reason);
        }
        return Ok(Op::Nothing);
    }
    if tokens.peek()? == Token::Mark(b';') {
        tokens.next()?;
        return Ok(Op::Call(word));
    }
    Err(tokens.unexpected_at(place, KNOWN, &word))
}

/// `AccSet 50,50;`, `PathAccLim TRUE\AccMax:=2,TRUE\DecelMax:=2;`, `WorldAccLim\On:=2;` or `\Off`. What is not set is as on a
/// controller: all of the arm's acceleration.
fn acceleration(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    place: (u64, u64),
    word: &str,
) -> Result<(), ReadError> {
    let none = RapidAcceleration { percent: 100.0, ramp_percent: 100.0, path_m_s2: None, world_m_s2: None };
    let mut set = data.acceleration.unwrap_or(none);
    let limit = |tokens: &mut Tokens<_>| tokens.positive("an acceleration in m/s2", 1.0);
    match word.to_ascii_lowercase().as_str() {
        "accset" => {
            set.percent = tokens.within("a share in percent", 0.0, MAX_NUMBER)?;
            tokens.marks(",")?;
            set.ramp_percent = tokens.within("a share in percent", 0.0, MAX_NUMBER)?;
            if let Some(name) = option(tokens)? {
                if name != "finepointramp" {
                    return unknown_option(tokens, "FinePointRamp", &name);
                }
                tokens.marks(":=")?;
                tokens.within("a share in percent", 0.0, MAX_NUMBER)?;
                data.warn(place, "FinePointRamp is passed over");
            }
        }
        "pathacclim" => {
            let mut limits = [None; 2];
            for (k, expected) in ["accmax", "decelmax"].into_iter().enumerate() {
                if k > 0 {
                    tokens.marks(",")?;
                }
                let is_on = truth(tokens)?;
                if let Some(name) = option(tokens)? {
                    if name != expected {
                        return unknown_option(tokens, ["AccMax", "DecelMax"][k], &name);
                    }
                    tokens.marks(":=")?;
                    limits[k] = Some(limit(tokens)?).filter(|_| is_on);
                }
            }
            // One number holds both; the smaller is kept.
            let [speeding, braking] = limits;
            if speeding != braking {
                data.warn(place, "PathAccLim has two limits: the smaller is read for both");
            }
            set.path_m_s2 = limits.into_iter().flatten().reduce(f64::min);
        }
        _ => match option(tokens)?.as_deref() {
            Some("on") => {
                tokens.marks(":=")?;
                set.world_m_s2 = Some(limit(tokens)?);
            }
            Some("off") => set.world_m_s2 = None,
            other => return unknown_option(tokens, "On or Off", other.unwrap_or(";")),
        },
    }
    tokens.marks(";")?;
    data.acceleration = Some(set);
    Ok(())
}

/// The value of a group output as a speed of the filament.
fn group_speed(
    tokens: &mut Tokens<impl BufRead>,
    data: &Data,
    place: (u64, u64),
    word: &str,
) -> Result<f64, ReadError> {
    let steps = tokens.within("a group signal", 0.0, f64::from(1u32 << 23))?;
    let mm_s = match data.filament_step {
        Some(step) => steps * step,
        // Off is off, whatever a step is.
        None if steps <= 0.0 => 0.0,
        None => {
            let expected = "a constant filament_step (mm/s) in the module before SetGO";
            return Err(tokens.unexpected_at(place, expected, word));
        }
    };
    if mm_s > MAX_NUMBER { Err(tokens.wrong("a speed of the filament", mm_s)) } else { Ok(mm_s) }
}

/// `TriggEquip name,0\Start,0.05\DOp:=doName,1;` or `TriggIO name,0\Start\DOp:=doName,1;`: the name in lower case, whether it comes at the
/// begin of a move, and what.
fn trigger(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    place: (u64, u64),
    word: &str,
) -> Result<(String, (bool, Step)), ReadError> {
    let name = tokens.name("the name of a trigger")?.to_ascii_lowercase();
    tokens.marks(",")?;
    let mut is_there = tokens.within("a distance", 0.0, MAX_NUMBER)? <= 0.0;
    let mut begin = false;
    let mut output = option(tokens)?;
    while let Some(found @ ("start" | "time")) = output.as_deref() {
        begin |= found == "start";
        is_there &= found == "start";
        output = option(tokens)?;
    }
    if word.eq_ignore_ascii_case("TriggEquip") {
        tokens.marks(",")?;
        tokens.within("a lag in seconds", -MAX_NUMBER, MAX_NUMBER)?;
        output = option(tokens)?;
    }
    if !is_there {
        data.warn(place, "a signal at a distance or a time is read as one where the move begins or ends");
    }
    let output = output.unwrap_or_default();
    if !["dop", "aop", "gop"].contains(&output.as_str()) {
        return unknown_option(tokens, "DOp, AOp or GOp", &output);
    }
    tokens.marks(":=")?;
    let step = if output == "dop" {
        let signal = data.use_digital(tokens)?;
        tokens.marks(",")?;
        switched(signal, digital_value(tokens)?)
    } else {
        data.use_signal(tokens, 1)?;
        tokens.marks(",")?;
        Step::FilamentSpeed(match output.as_str() {
            "aop" => tokens.within("a speed of the filament", 0.0, MAX_NUMBER)?,
            _ => group_speed(tokens, data, place, word)?,
        })
    };
    tokens.marks(";")?;
    Ok((name, (begin, step)))
}

/// The next trigger of a move.
fn use_trigger(tokens: &mut Tokens<impl BufRead>, data: &Data) -> Result<(bool, Step), ReadError> {
    let name = tokens.name("a trigger")?;
    let found = data.triggers.get(&name.to_ascii_lowercase()).copied();
    found.ok_or_else(|| tokens.unexpected_at(tokens.place(), "a trigger that TriggEquip or TriggIO has set up", &name))
}

/// To the end of an instruction.
fn skip(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    loop {
        match tokens.next()? {
            Token::Mark(b';') => return Ok(()),
            Token::End => return Err(tokens.unexpected(";", Token::End)),
            _ => {}
        }
    }
}

/// `"HOME:"\File:="name.mod";` or `"HOME:/name.mod";`: the name of the file.
fn file(tokens: &mut Tokens<impl BufRead>) -> Result<String, ReadError> {
    let path = tokens.string("the folder or the file")?;
    let name = if tokens.peek()? == Token::Mark(b'\\') {
        tokens.marks("\\")?;
        tokens.expect_word("File")?;
        tokens.marks(":=")?;
        tokens.string("the file")?
    } else {
        path.rsplit(['/', '\\', ':']).next().unwrap_or(&path).to_owned()
    };
    tokens.marks(";")?;
    Ok(name)
}

/// `\Conc,` before a target.
fn concurrent(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<(), ReadError> {
    if tokens.peek()? == Token::Mark(b'\\') {
        tokens.marks("\\")?;
        tokens.expect_word("Conc")?;
        data.warn(tokens.place(), "\\Conc is not followed: signals behind the move come when it is done");
        tokens.marks(",")?;
    }
    Ok(())
}

/// The name behind the next backslash, in lower case, if there is one.
fn option(tokens: &mut Tokens<impl BufRead>) -> Result<Option<String>, ReadError> {
    if tokens.peek()? != Token::Mark(b'\\') {
        return Ok(None);
    }
    tokens.marks("\\")?;
    Ok(Some(tokens.name("an option")?.to_ascii_lowercase()))
}

fn unknown_option<R: BufRead, T>(tokens: &Tokens<R>, expected: &'static str, name: &str) -> Result<T, ReadError> {
    Err(tokens.unexpected_at(tokens.place(), expected, name))
}

/// `:=` and a name or a number that does not matter here.
fn ignored_value(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    tokens.marks(":=")?;
    match tokens.next()? {
        Token::Word(..) | Token::Number(_) => Ok(()),
        other => Err(tokens.unexpected("a name or a number", other)),
    }
}

/// `doName,1;`, or `high` and `low`.
fn digital(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<Step, ReadError> {
    if let Some(name) = option(tokens)? {
        if name != "sync" {
            return unknown_option(tokens, "Sync", &name);
        }
        tokens.marks(",")?;
    }
    let signal = data.use_digital(tokens)?;
    tokens.marks(",")?;
    let on = digital_value(tokens)?;
    tokens.marks(";")?;
    Ok(switched(signal, on))
}

/// `1`, `0`, `high` or `low`.
fn digital_value(tokens: &mut Tokens<impl BufRead>) -> Result<bool, ReadError> {
    let token = tokens.peek()?;
    if tokens.is_word(token, "high") || tokens.is_word(token, "low") {
        tokens.next()?;
        return Ok(tokens.is_word(token, "high"));
    }
    let value = tokens.whole()?;
    if !(0..=1).contains(&value) {
        return Err(tokens.wrong("a digital signal", f64::from(value)));
    }
    Ok(value == 1)
}

fn switched(signal: Option<HeadSignal>, on: bool) -> Step {
    signal.map_or(Step::Extruder(on), |signal| Step::Signal { signal, on })
}

/// Options of the target, speed, triggers where there are to be any, zone, tool and work object.
fn rest(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    goal: Goal,
    table: Option<ExternalAxes>,
    triggers: Option<&mut Vec<(bool, Step)>>,
) -> Result<Step, ReadError> {
    while let Some(name) = option(tokens)? {
        match name.as_str() {
            "id" => ignored_value(tokens)?,
            "noeoffs" => {}
            _ => return unknown_option(tokens, "ID or NoEOffs", &name),
        }
    }
    tokens.marks(",")?;
    let speed = speed(tokens, data)?;
    tokens.marks(",")?;
    if let Some(triggers) = triggers {
        use_triggers(tokens, data, triggers)?;
        tokens.marks(",")?;
    }
    let zone = zone(tokens, data)?;
    tokens.marks(",")?;
    frames(tokens, data, matches!(goal, Goal::Joints(_)))?;
    tokens.marks(";")?;
    Ok(Step::Move(Move { goal, table, speed, zone }))
}

/// The speed, and the one that an option puts in its place.
fn speed(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<Speed, ReadError> {
    let mut speed: Speed = data.speed_or_name(tokens)?;
    while let Some(name) = option(tokens)? {
        if name != "v" {
            return unknown_option(tokens, "V (a time, \\T, is not known here)", &name);
        }
        tokens.marks(":=")?;
        speed.mm_s = tokens.positive("a speed", 1.0)?;
    }
    Ok(speed)
}

/// The first trigger of a line, and those that options add.
fn use_triggers(
    tokens: &mut Tokens<impl BufRead>,
    data: &mut Data,
    triggers: &mut Vec<(bool, Step)>,
) -> Result<(), ReadError> {
    triggers.push(use_trigger(tokens, data)?);
    while let Some(name) = option(tokens)? {
        if !TRIGGER_OPTIONS.contains(&name.as_str()) {
            return unknown_option(tokens, "T2 to T8", &name);
        }
        tokens.marks(":=")?;
        triggers.push(use_trigger(tokens, data)?);
    }
    Ok(())
}

/// The zone, and the radius that an option puts in its place.
fn zone(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<Zone, ReadError> {
    let mut zone = data.zone_or_name(tokens)?;
    while let Some(name) = option(tokens)? {
        match name.as_str() {
            "inpos" => ignored_value(tokens)?,
            "z" => {
                tokens.marks(":=")?;
                zone = Zone::Blend(tokens.positive("the radius of a zone", 1.0)?);
            }
            _ => return unknown_option(tokens, "Z or Inpos", &name),
        }
    }
    Ok(zone)
}

/// Tool and work object. A line without a work object is in `wobj0`; to a move to joints they do not matter.
fn frames(tokens: &mut Tokens<impl BufRead>, data: &mut Data, by_joints: bool) -> Result<(), ReadError> {
    frame(tokens, data, 0, by_joints)?;
    let mut has_object = false;
    while let Some(name) = option(tokens)? {
        tokens.marks(":=")?;
        match name.as_str() {
            "wobj" => {
                frame(tokens, data, 1, by_joints)?;
                has_object = true;
            }
            "tload" => _ = tokens.name("the load")?,
            _ => return unknown_option(tokens, "WObj or TLoad", &name),
        }
    }
    if !has_object && !by_joints && !data.uses(1, super::WOBJ0.as_bytes()) {
        data.use_frame(tokens, 1, super::WOBJ0)?;
    }
    Ok(())
}

/// The name of a tool (0) or a work object (1); for a move to joints it does not matter.
fn frame(tokens: &mut Tokens<impl BufRead>, data: &mut Data, which: usize, any: bool) -> Result<(), ReadError> {
    match tokens.next()? {
        Token::Word(..) if any => Ok(()),
        Token::Word(from, to) if data.uses(which, tokens.word_at(from, to)) => Ok(()),
        Token::Word(from, to) => {
            let name = String::from_utf8_lossy(tokens.word_at(from, to)).into_owned();
            data.use_frame(tokens, which, &name)
        }
        other => Err(tokens.unexpected(["the tool", "the work object"][which], other)),
    }
}
