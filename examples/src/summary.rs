//! `summary.json`: flat keys in the order in which they were set.

use crate::output::{OutputError, OutputFolder, SUMMARY};
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;
use std::time::Duration;

/// Figures of a run under snake_case keys, units as suffix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    entries: Vec<(String, Value)>,
}

/// Why a figure cannot go into a summary.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SummaryError {
    /// The value is infinite or not a number (or null): JSON has no such figure.
    #[error("summary: `{key}` is not a finite number")]
    NotFinite {
        /// Its key.
        key: String,
    },
    /// The value is a list or a map.
    #[error("summary: `{key}` is not a single value")]
    NotFlat {
        /// Its key.
        key: String,
    },
    /// The key is there already.
    #[error("summary: `{key}` is set twice")]
    Repeated {
        /// The key.
        key: String,
    },
    /// The key is not made of small letters, digits and underlines, a letter first.
    #[error("summary: `{key}` is not a snake_case key")]
    Key {
        /// The key.
        key: String,
    },
}

impl Summary {
    /// A summary without figures.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a figure: a number, a text, or true or false.
    ///
    /// # Errors
    /// [`SummaryError`] names the key.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::summary::Summary;
    /// let mut summary = Summary::new();
    /// summary.set("mesh", "part.stl")?.set("cells", 97_532)?.set("cell_mm", 0.8)?.set("audit_ok", true)?;
    /// assert_eq!(summary.get("cells"), Some(&97_532.into()));
    /// assert!(summary.set("volume_mm3", f64::NAN).is_err());
    /// # Ok::<(), curvlay_examples::summary::SummaryError>(())
    /// ```
    pub fn set(&mut self, key: &str, value: impl Into<Value>) -> Result<&mut Self, SummaryError> {
        let value = value.into();
        let owned = || key.to_owned();
        let snake = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if !key.starts_with(|c: char| c.is_ascii_lowercase()) || !key.chars().all(snake) {
            return Err(SummaryError::Key { key: owned() });
        }
        if self.get(key).is_some() {
            return Err(SummaryError::Repeated { key: owned() });
        }
        match value {
            // What an infinite number becomes on its way into a value.
            Value::Null => Err(SummaryError::NotFinite { key: owned() }),
            Value::Array(_) | Value::Object(_) => Err(SummaryError::NotFlat { key: owned() }),
            value => {
                self.entries.push((owned(), value));
                Ok(self)
            }
        }
    }

    /// Appends the fields of a struct under their names.
    ///
    /// # Errors
    /// As [`Summary::set`], and for what is no struct.
    ///
    /// # Example
    /// ```
    /// #[derive(serde::Serialize)]
    /// struct Limits {
    ///     allow_missed: f64,
    /// }
    /// let mut summary = curvlay_examples::summary::Summary::new();
    /// summary.set_all(&Limits { allow_missed: 0.5 })?;
    /// assert_eq!(summary.get("allow_missed"), Some(&0.5.into()));
    /// # Ok::<(), curvlay_examples::summary::SummaryError>(())
    /// ```
    pub fn set_all(&mut self, values: &impl Serialize) -> Result<&mut Self, SummaryError> {
        let Ok(Value::Object(fields)) = serde_json::to_value(values) else {
            return Err(SummaryError::NotFlat { key: String::new() });
        };
        fields.into_iter().try_fold(self, |summary, (key, value)| summary.set(&key, value))
    }

    /// Appends a time in seconds, to a tenth of a millisecond. The key should end in `_s`.
    ///
    /// # Errors
    /// As [`Summary::set`].
    pub fn set_seconds(&mut self, key: &str, time: Duration) -> Result<&mut Self, SummaryError> {
        self.set(key, (time.as_secs_f64() * 1e4).round() / 1e4)
    }

    /// A figure.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }

    /// All figures in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.entries.iter().map(|(key, value)| (key.as_str(), value))
    }

    /// The JSON text, a figure a line.
    pub fn to_json(&self) -> String {
        let mut text = String::from("{");
        for (i, (key, value)) in self.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            // Writing into a String cannot fail.
            let _ = write!(text, "{comma}\n  \"{key}\": {value}");
        }
        text + "\n}\n"
    }

    /// Writes `summary.json`.
    ///
    /// # Errors
    /// [`OutputError`] from the folder.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), OutputError> {
        folder.write(SUMMARY, self.to_json())
    }
}
