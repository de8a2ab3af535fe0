//! Figures of the run of `curved_layers` beside a program: its `summary.json`.

use crate::input;
use serde_json::{Map, Value};
use std::path::Path;

/// Figures of the run beside the program.
pub struct Facts(Map<String, Value>);

impl Facts {
    /// Those of `summary.json` in a folder; none where there is no such file, or none of a run.
    pub fn read(folder: &Path) -> Self {
        let path = folder.join("summary.json");
        let text = input::read(&path, input::MAX_SETTINGS_BYTES).unwrap_or_default();
        Facts(serde_json::from_slice(&text).unwrap_or_default())
    }

    /// A number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.0.get(key)?.as_f64().filter(|value| value.is_finite())
    }

    /// A text; none where it is empty or `none`.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key)?.as_str().filter(|text| !text.is_empty() && *text != "none")
    }

    /// Sizes of the nozzle.
    pub fn nozzle(&self) -> Option<[f64; 4]> {
        let numbers: Option<Vec<f64>> = self.text("nozzle")?.split(',').map(|word| word.parse().ok()).collect();
        numbers?.try_into().ok()
    }
}
