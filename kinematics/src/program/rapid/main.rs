//! A whole RAPID module in memory: declarations and procedures.

use super::data::Data;
use super::op::Op;
use super::{RapidTool, RapidWorkObject, instruction};
use crate::program::ReadError;
use crate::program::text::tokens::{Token, Tokens};
use std::io::BufRead;

/// What stands in a main module.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidMain {
    /// Its name.
    pub name: String,
    /// The tool, where it is not `tool0`: that of the moves, or the first one declared.
    pub tool: Option<RapidTool>,
    /// The work object, where it is not `wobj0`: that of the moves, or the first one declared.
    pub work_object: Option<RapidWorkObject>,
    /// The files it loads, in the order of its lines.
    pub modules: Vec<String>,
}

impl RapidMain {
    /// Reads a module as [`read_rapid`](super::read_rapid) does, but for the steps.
    ///
    /// # Errors
    /// [`ReadError`] with line and column.
    pub fn read(reader: impl BufRead) -> Result<Self, ReadError> {
        Ok(Module::read(reader)?.main())
    }
}

/// An instruction with its place.
pub(super) type Placed = (Op, (u64, u64));

/// A procedure.
#[derive(Debug)]
pub(super) struct Procedure {
    pub name: String,
    pub body: Vec<Placed>,
}

/// A module.
#[derive(Debug)]
pub(super) struct Module {
    name: String,
    pub data: Data,
    pub procedures: Vec<Procedure>,
    /// Where the file ends, for errors about the whole.
    pub end: (u64, u64),
}

impl Module {
    pub fn read(reader: impl BufRead) -> Result<Self, ReadError> {
        let mut tokens = Tokens::new(reader, b'!');
        let mut data = Data::default();
        data.begin_module(None);
        let name = head(&mut tokens)?;
        let mut module = Module { name, data, procedures: Vec::new(), end: (1, 1) };
        while let Some(name) = next_procedure(&mut tokens, &mut module.data)? {
            if module.procedures.iter().any(|procedure| procedure.name.eq_ignore_ascii_case(&name)) {
                return Err(tokens.unexpected_at(tokens.place(), "a procedure of another name", &name));
            }
            let mut body = Vec::new();
            loop {
                match instruction::next(&mut tokens, &mut module.data)? {
                    (Op::End, _) => break,
                    (Op::Nothing, _) => {}
                    placed => body.push(placed),
                }
            }
            module.procedures.push(Procedure { name, body });
        }
        module.end = tokens.place();
        end(&mut tokens)?;
        Ok(module)
    }

    pub fn main(&self) -> RapidMain {
        let loads = self.procedures.iter().flat_map(|procedure| &procedure.body);
        let modules = loads.filter_map(|(op, _)| if let Op::Load(file) = op { Some(file.clone()) } else { None });
        RapidMain {
            name: self.name.clone(),
            tool: self.data.tool(),
            work_object: self.data.work_object(),
            modules: modules.collect(),
        }
    }
}

/// The head of a module, to its first declaration: a header between `%%%`, `MODULE`, the name and attributes.
pub(super) fn head(tokens: &mut Tokens<impl BufRead>) -> Result<String, ReadError> {
    if tokens.peek()? == Token::Mark(b'%') {
        tokens.marks("%%%")?;
        tokens.skip_header()?;
    }
    tokens.expect_word("MODULE")?;
    let name = tokens.name("the module's name")?;
    if tokens.peek()? == Token::Mark(b'(') {
        loop {
            tokens.next()?;
            tokens.name("an attribute of the module")?;
            if tokens.peek()? != Token::Mark(b',') {
                break;
            }
        }
        tokens.marks(")")?;
    }
    Ok(name)
}

/// Declarations up to the next procedure, and its name; `None` before `ENDMODULE`.
pub(super) fn next_procedure(tokens: &mut Tokens<impl BufRead>, data: &mut Data) -> Result<Option<String>, ReadError> {
    loop {
        let token = tokens.peek()?;
        if tokens.is_word(token, "ENDMODULE") {
            return Ok(None);
        }
        tokens.next()?;
        if tokens.is_word(token, "LOCAL") || tokens.is_word(token, "TASK") {
            continue;
        }
        if ["CONST", "PERS", "VAR"].iter().any(|word| tokens.is_word(token, word)) {
            data.declare(tokens)?;
        } else if tokens.is_word(token, "PROC") {
            let name = tokens.name("the procedure's name")?;
            tokens.marks("()")?;
            return Ok(Some(name));
        } else {
            return Err(tokens.unexpected("a declaration (CONST, PERS, VAR), PROC or ENDMODULE", token));
        }
    }
}

/// `ENDMODULE`, then the end of the file.
pub(super) fn end(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    tokens.expect_word("ENDMODULE")?;
    match tokens.next()? {
        Token::End => Ok(()),
        more => Err(tokens.unexpected("the end of the file", more)),
    }
}
