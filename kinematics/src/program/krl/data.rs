//! The data list of a main module, written and read.

use super::motion::{pose, write_pose};
use super::options::{
    AXIS_SPEED, BASE, DEGREES, EXTRUDER, FILAMENT, FULL_SCALE, KrlOptions, TOOL, input_name, output_name,
};
use crate::program::check::MAX_NUMBER;
use crate::program::text::Text;
use crate::program::text::tokens::{Token, Tokens};
use crate::program::{HeadInput, HeadSignal, ReadError};
use nalgebra::Isometry3;
use std::collections::BTreeMap;
use std::io::BufRead;

pub(super) fn write_data(text: &mut Text, options: &KrlOptions) {
    let name = options.name.as_str();
    text.word("&ACCESS RVP\n&REL 1\nDEFDAT ").word(name).word(" PUBLIC\n");
    text.word("; $TOOL and $BASE\n");
    // With the part in the hand, the part is the tool of the controller.
    let [tool, base] =
        if options.part_in_hand { [&options.work, &options.tool] } else { [&options.tool, &options.work] };
    for (end, frame) in [(TOOL, tool), (BASE, base)] {
        text.word("DECL GLOBAL FRAME ").word(name).word(end).word("={");
        write_pose(text, frame);
        text.word("}\n");
    }
    text.word("; numbers of outputs: extruder ($OUT), filament ($ANOUT), tape head ($OUT)\n");
    let mut number = |end: &str, number: u16| {
        text.word("DECL GLOBAL INT ").word(name).word(end).word("=").fixed(f64::from(number), 0).word("\n");
    };
    number(EXTRUDER, options.output);
    number(FILAMENT, u16::from(options.filament_output));
    HeadSignal::ALL.iter().for_each(|signal| number(output_name(*signal), options.head_outputs[signal.number()]));
    HeadInput::ALL.iter().for_each(|input| number(input_name(*input), options.head_inputs[input.number()]));
    text.word("; for information: mm/s of filament at an analog output of 1, degrees/s of an axis at $VEL_AXIS 100\n");
    for (end, value) in [(FULL_SCALE, options.filament_full_scale_mm_s), (AXIS_SPEED, options.axis_rad_s.to_degrees())]
    {
        text.word("DECL GLOBAL REAL ").word(name).word(end).word("=").fixed(value, DEGREES).word("\n");
    }
    text.word("ENDDAT\n");
}

/// What a data list declares, by name in upper case.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub name: String,
    frames: BTreeMap<String, Isometry3<f64>>,
    numbers: BTreeMap<String, f64>,
}

/// Declarations of a data list: none of ours has more than 20.
const MOST: usize = 10_000;

impl Data {
    pub fn read(reader: impl BufRead) -> Result<Self, ReadError> {
        let mut tokens = Tokens::new(reader, b';');
        let mut data = Data::default();
        skip_header(&mut tokens)?;
        tokens.expect_word("DEFDAT")?;
        data.name = tokens.name("the module's name")?;
        let token = tokens.peek()?;
        if tokens.is_word(token, "PUBLIC") {
            tokens.next()?;
        }
        loop {
            let token = tokens.next()?;
            if tokens.is_word(token, "ENDDAT") {
                return Ok(data);
            }
            if !tokens.is_word(token, "DECL") {
                return Err(tokens.unexpected("DECL or ENDDAT", token));
            }
            data.declare(&mut tokens)?;
        }
    }

    /// `GLOBAL FRAME name={..}` and its like.
    fn declare(&mut self, tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
        let token = tokens.peek()?;
        if tokens.is_word(token, "GLOBAL") {
            tokens.next()?;
        }
        let kind = tokens.next()?;
        let is_frame = tokens.is_word(kind, "FRAME");
        if !is_frame && !tokens.is_word(kind, "INT") && !tokens.is_word(kind, "REAL") {
            return Err(tokens.unexpected("FRAME, INT or REAL", kind));
        }
        let name = tokens.name("a name")?.to_ascii_uppercase();
        let place = tokens.place();
        let is_full = self.frames.len() + self.numbers.len() >= MOST;
        if is_full || self.frames.contains_key(&name) || self.numbers.contains_key(&name) {
            return Err(tokens.unexpected_at(place, "a name that is not declared yet", &name));
        }
        tokens.marks("=")?;
        if is_frame {
            let frame = read_frame(tokens)?;
            self.frames.insert(name, frame);
        } else {
            let value = tokens.within("a number of the data list", -MAX_NUMBER, MAX_NUMBER)?;
            self.numbers.insert(name, value);
        }
        Ok(())
    }

    /// The frame of our own name with this end.
    pub fn frame(&self, end: &str) -> Isometry3<f64> {
        let name = self.name.to_ascii_uppercase() + end;
        self.frames.get(&name).copied().unwrap_or_else(Isometry3::identity)
    }

    /// The number of our own name with this end.
    pub fn number(&self, end: &str) -> Option<f64> {
        self.numbers.get(&(self.name.to_ascii_uppercase() + end)).copied()
    }

    /// Whether a name is our own with this end.
    pub fn is(&self, name: &str, end: &str) -> bool {
        let at = name.len().saturating_sub(end.len());
        name.is_char_boundary(at) && name[at..].eq_ignore_ascii_case(end) && name[..at].eq_ignore_ascii_case(&self.name)
    }
}

/// `&ACCESS RVP` and the like at the head of a file.
pub(super) fn skip_header(tokens: &mut Tokens<impl BufRead>) -> Result<(), ReadError> {
    while tokens.peek()? == Token::Mark(b'&') {
        tokens.skip_line();
    }
    Ok(())
}

/// `{X 0,Y 0,Z 0,A 0,B 0,C 0}`
fn read_frame(tokens: &mut Tokens<impl BufRead>) -> Result<Isometry3<f64>, ReadError> {
    tokens.marks("{")?;
    let mut values = [0.0; 6];
    for (k, (name, value)) in ["X", "Y", "Z", "A", "B", "C"].into_iter().zip(&mut values).enumerate() {
        if k > 0 {
            tokens.marks(",")?;
        }
        tokens.expect_word(name)?;
        let number = tokens.within("a coordinate or an angle", -MAX_NUMBER, MAX_NUMBER)?;
        *value = if k < 3 { number } else { number.to_radians() };
    }
    tokens.marks("}")?;
    Ok(pose(values))
}
