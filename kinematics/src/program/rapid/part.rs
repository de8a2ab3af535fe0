//! A RAPID module with one procedure, read step by step.

use super::data::{Data, ReadWarning};
use super::main::{end, head, next_procedure};
use super::op::Op;
use super::{RapidAcceleration, instruction};
use crate::program::text::tokens::Tokens;
use crate::program::{ReadError, Step, step::until_error};
use std::io::BufRead;

/// The steps of a module with one procedure, one after the other, in memory that its declarations need. Ends after the
/// first error. [`read_rapid`](super::read_rapid) states what is read; calls and `Load` are not, in such a module.
#[derive(Debug)]
pub struct RapidPart<R> {
    tokens: Tokens<R>,
    data: Data,
    procedure: String,
    over: bool,
}

impl<R: BufRead> RapidPart<R> {
    /// Reads the module's head, with its declarations.
    ///
    /// # Errors
    /// [`ReadError`] when it is no module with a procedure.
    pub fn new(reader: R) -> Result<Self, ReadError> {
        Self::with(reader, Data::default(), None).map_err(|(error, _)| error)
    }

    /// The same with what is declared elsewhere, which an error gives back.
    pub(super) fn with(reader: R, mut data: Data, file: Option<&str>) -> Result<Self, (ReadError, Box<Data>)> {
        let mut tokens = Tokens::new(reader, b'!');
        data.begin_module(file);
        let read = head(&mut tokens).and_then(|_| next_procedure(&mut tokens, &mut data));
        let procedure =
            read.and_then(|name| name.ok_or_else(|| tokens.unexpected_at(tokens.place(), "PROC", "ENDMODULE")));
        match procedure {
            Ok(procedure) => Ok(RapidPart { tokens, data, procedure, over: false }),
            Err(error) => Err((error, Box::new(data))),
        }
    }

    /// The name of the procedure.
    pub fn procedure(&self) -> &str {
        &self.procedure
    }

    /// What was worth a warning so far; the first thousand.
    pub fn warnings(&self) -> &[ReadWarning] {
        &self.data.warnings
    }

    /// The accelerations that the instructions so far have set, if any has.
    pub fn acceleration(&self) -> Option<RapidAcceleration> {
        self.data.acceleration
    }

    pub(super) fn file(&self) -> &str {
        self.data.file.as_deref().unwrap_or_default()
    }

    pub(super) fn into_data(self) -> Data {
        self.data
    }

    /// The next step; `None` at the end of the module.
    fn step(&mut self) -> Result<Option<Step>, ReadError> {
        loop {
            match instruction::next(&mut self.tokens, &mut self.data)? {
                (Op::Step(step), _) => return Ok(Some(step)),
                (Op::Nothing, _) => {}
                (Op::End, _) => {
                    end(&mut self.tokens)?;
                    return Ok(None);
                }
                (Op::Call(name) | Op::Load(name), place) => {
                    let expected = "a module of one procedure without calls and loads";
                    return Err(self.tokens.unexpected_at(place, expected, &name));
                }
                (Op::UnLoad, place) => {
                    let expected = "a module of one procedure without calls and loads";
                    return Err(self.tokens.unexpected_at(place, expected, "UnLoad"));
                }
            }
        }
    }
}

impl<R: BufRead> Iterator for RapidPart<R> {
    type Item = Result<Step, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut over = self.over;
        let next = until_error(&mut over, || self.step());
        self.over = over;
        next
    }
}
