//! Signals of a URScript program, read.

use super::FULL_SCALE;
use super::extruder::{MAX_COUNT, RPM, SPEED, STEP, SWITCH};
use crate::program::check::MAX_NUMBER;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{ExtruderCommand, HeadSignal, ReadError, Step};
use std::io::BufRead;

/// What numbers of the filament's signals stand for, once the program has said so.
#[derive(Debug, Default)]
pub(super) struct Units {
    /// mm/s at the full scale of the analog output.
    pub full_scale: Option<f64>,
    /// mm/s for a count of the register.
    pub step: Option<f64>,
    /// Turns a minute for 1 mm/s.
    pub rpm: Option<f64>,
}

/// An instruction that begins with this word, if it is one of signals: its step, if it is not one that sets up a connection or a number.
pub(super) fn read(
    tokens: &mut Tokens<impl BufRead>,
    token: Token,
    units: &mut Units,
) -> Result<Option<Option<Step>>, ReadError> {
    const CONNECTIONS: [&str; 4] =
        ["modbus_add_signal", "modbus_set_signal_update_frequency", "socket_open", "socket_close"];
    let is = |tokens: &Tokens<_>, word: &str| tokens.is_word(token, word);
    let step = if is(tokens, "set_standard_digital_out") {
        digital_output(tokens)?
    } else if is(tokens, "set_standard_analog_out") {
        let expected = "filament_full_scale before an analog output";
        filament_speed(tokens, units.full_scale.ok_or_else(|| tokens.unexpected(expected, token))?)?
    } else if is(tokens, "modbus_set_output_signal") {
        modbus_switch(tokens)?
    } else if is(tokens, "modbus_set_output_register") {
        let expected = "filament_step before a register";
        modbus_speed(tokens, units.step.ok_or_else(|| tokens.unexpected(expected, token))?)?
    } else if is(tokens, "socket_send_line") {
        command(tokens, units.rpm)?
    } else {
        if is(tokens, FULL_SCALE) {
            units.full_scale = Some(number(tokens, "a speed of the filament")?);
        } else if is(tokens, STEP) {
            units.step = Some(number(tokens, "a speed of the filament")?);
        } else if is(tokens, RPM) {
            units.rpm = Some(number(tokens, "turns a minute")?);
        } else if signal_of(tokens, token).is_some() {
            tokens.marks("=")?;
            tokens.whole()?;
        } else if CONNECTIONS.iter().any(|word| is(tokens, word)) {
            arguments(tokens)?;
        } else {
            return Ok(None);
        }
        return Ok(Some(None));
    };
    Ok(Some(Some(step)))
}

/// `=20.0`
fn number(tokens: &mut Tokens<impl BufRead>, what: &'static str) -> Result<f64, ReadError> {
    tokens.marks("=")?;
    tokens.positive(what, 1.0)
}

/// The signal of a tape head whose name stands there.
fn signal_of<R: BufRead>(tokens: &Tokens<R>, token: Token) -> Option<HeadSignal> {
    HeadSignal::ALL.into_iter().find(|signal| tokens.is_word(token, signal.urscript()))
}

/// `set_standard_digital_out(0,True)`, from the bracket on. An output with a name is one of a tape head, a number the extruder's.
fn digital_output(tokens: &mut Tokens<impl BufRead>) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    let output = tokens.peek()?;
    let signal = signal_of(tokens, output);
    match signal {
        Some(_) => _ = tokens.next()?,
        None => _ = tokens.whole()?,
    }
    tokens.marks(",")?;
    let on = truth(tokens)?;
    tokens.marks(")")?;
    Ok(signal.map_or(Step::Extruder(on), |signal| Step::Signal { signal, on }))
}

/// `set_standard_analog_out(0,4.5/filament_full_scale)`, from the bracket on, for a full scale of `most`.
fn filament_speed(tokens: &mut Tokens<impl BufRead>, most: f64) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    tokens.whole()?;
    tokens.marks(",")?;
    let mm_s = tokens.within("a speed of the filament from 0 to the full scale", 0.0, most)?;
    tokens.marks("/")?;
    tokens.expect_word(FULL_SCALE)?;
    tokens.marks(")")?;
    Ok(Step::FilamentSpeed(mm_s))
}

/// The arguments of a call that sets up a connection: texts and numbers.
fn arguments(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    tokens.marks("(")?;
    loop {
        match tokens.next()? {
            Token::Text(..) | Token::Number(_) => {}
            other => return Err(tokens.unexpected("a text or a number", other)),
        }
        match tokens.next()? {
            Token::Mark(b',') => {}
            Token::Mark(b')') => return Ok(()),
            other => return Err(tokens.unexpected(", or )", other)),
        }
    }
}

/// A name between quotes.
fn quoted(tokens: &mut Tokens<impl BufRead>, name: &'static str) -> Result<(), ReadError> {
    let found = tokens.string(name)?;
    if found == name { Ok(()) } else { Err(tokens.unexpected_at(tokens.place(), name, &found)) }
}

/// `("extruder",True)`
fn modbus_switch(tokens: &mut Tokens<impl BufRead>) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    quoted(tokens, SWITCH)?;
    tokens.marks(",")?;
    let on = truth(tokens)?;
    tokens.marks(")")?;
    Ok(Step::Extruder(on))
}

/// `("filament",3250,False)`, for `step` mm/s a count.
fn modbus_speed(tokens: &mut Tokens<impl BufRead>, step: f64) -> Result<Step, ReadError> {
    tokens.marks("(")?;
    quoted(tokens, SPEED)?;
    tokens.marks(",")?;
    let count = tokens.whole()?;
    if !(0.0..=MAX_COUNT).contains(&f64::from(count)) {
        return Err(tokens.wrong("a number of a register, 0 to 65535", f64::from(count)));
    }
    tokens.marks(",")?;
    truth(tokens)?;
    tokens.marks(")")?;
    feed(tokens, f64::from(count) * step)
}

/// `("RPM,4.5","extruder")`, for so many turns a minute for 1 mm/s.
fn command(tokens: &mut Tokens<impl BufRead>, rpm: Option<f64>) -> Result<Step, ReadError> {
    const KNOWN: &str = "START, STOP or RPM behind rpm_per_mm_s";
    tokens.marks("(")?;
    let line = tokens.string("a command of the extruder")?;
    let place = tokens.place();
    tokens.marks(",")?;
    quoted(tokens, SWITCH)?;
    tokens.marks(")")?;
    match (line.parse(), rpm) {
        (Ok(ExtruderCommand::Start), _) => Ok(Step::Extruder(true)),
        (Ok(ExtruderCommand::Stop), _) => Ok(Step::Extruder(false)),
        (Ok(ExtruderCommand::Rpm(turns)), Some(rpm)) => feed(tokens, turns / rpm),
        _ => Err(tokens.unexpected_at(place, KNOWN, &line)),
    }
}

fn feed(tokens: &Tokens<impl BufRead>, mm_s: f64) -> Result<Step, ReadError> {
    if mm_s <= MAX_NUMBER { Ok(Step::FilamentSpeed(mm_s)) } else { Err(tokens.wrong("a speed of the filament", mm_s)) }
}

/// `True` or `False`
fn truth(tokens: &mut Tokens<impl BufRead>) -> Result<bool, ReadError> {
    let token = tokens.next()?;
    let on = tokens.is_word(token, "True");
    if on || tokens.is_word(token, "False") { Ok(on) } else { Err(tokens.unexpected("True or False", token)) }
}
