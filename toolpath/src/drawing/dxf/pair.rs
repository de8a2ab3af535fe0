//! A group code with its value, and records of these.

use super::error::{Fault, Place};

/// A line or a text longer than this is no DXF.
pub(super) const LONGEST_TEXT: usize = 1 << 16;

/// A group code with its value.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub code: i32,
    pub value: String,
    /// Where the value is.
    pub at: Place,
}

impl Pair {
    pub fn number(&self) -> Result<f64, Fault> {
        let number = self.value.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault("is not a finite number"))
    }

    pub fn whole(&self) -> Result<i64, Fault> {
        self.value.parse().map_err(|_| self.fault("is not a whole number"))
    }

    fn fault(&self, what: &str) -> Fault {
        let short: String = self.value.chars().take(40).collect();
        Fault { what: format!("`{short}` {what}"), at: Some(self.at) }
    }
}

/// An entity, or what else begins with code 0.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub kind: String,
    /// Where its kind is.
    pub at: Place,
    pub pairs: Vec<Pair>,
}

impl Record {
    pub fn find(&self, code: i32) -> Option<&Pair> {
        self.pairs.iter().find(|pair| pair.code == code)
    }

    pub fn text(&self, code: i32) -> &str {
        self.find(code).map_or("", |pair| &pair.value)
    }

    pub fn number_or(&self, code: i32, default: f64) -> Result<f64, Fault> {
        self.find(code).map_or(Ok(default), Pair::number)
    }

    pub fn whole_or(&self, code: i32, default: i64) -> Result<i64, Fault> {
        self.find(code).map_or(Ok(default), Pair::whole)
    }

    pub fn number(&self, code: i32) -> Result<f64, Fault> {
        self.find(code).ok_or_else(|| Fault::new(format!("there is no value with group code {code}")))?.number()
    }

    /// All numbers of a code, in order.
    pub fn numbers(&self, code: i32) -> Result<Vec<f64>, Fault> {
        self.pairs.iter().filter(|pair| pair.code == code).map(Pair::number).collect()
    }

    /// Where it is, with its handle, by which CAD programs find it.
    pub fn place(&self, at: Option<Place>) -> String {
        let (at, handle) = (at.unwrap_or(self.at), self.text(5));
        if handle.is_empty() { at.to_string() } else { format!("{at} (handle {handle})") }
    }
}
