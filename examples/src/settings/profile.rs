//! Profiles: settings in a JSON file. What a setting may be is what its option may be, so a profile is judged as words of the command line.

use super::declared::Settings;
use super::flavour::is_file;
use crate::args::is_typed;
use crate::input;
use crate::json::JsonFault;
use crate::outcome::Failure;
use clap::ArgMatches;
use serde_json::{Map, Value};
use std::error::Error;
use std::path::Path;

/// The settings that a JSON file gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// By name, those that it gives.
    given: Map<String, Value>,
}

impl Profile {
    /// Reads a profile. The path of a workcell in it, and that of a flavour, count from its folder.
    ///
    /// # Errors
    /// A line with the file, and line and column or the setting; for an unknown setting with the nearest known one.
    pub fn load(path: &Path) -> Result<Profile, Failure> {
        let failed = |problem: String| Failure::new(format!("{}: {problem}", path.display()));
        let text = input::read_text(path, input::MAX_SETTINGS_BYTES)?;
        let mut profile = Profile::from_json(&text).map_err(failed)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        // The name of an arm has no folder.
        let is_workcell =
            |given: &str| folder.join(given).exists() || curvlay_kinematics::robots::find(given).is_none();
        for name in ["workcell", "flavour"] {
            let Some(Value::String(given)) = profile.given.get_mut(name) else { continue };
            let is_path = if name == "workcell" { is_workcell(given) } else { is_file(given) };
            if is_path {
                *given = folder.join(&given).display().to_string();
            }
        }
        Ok(profile)
    }

    /// The settings of a JSON text: one object, the names those of the fields.
    ///
    /// # Errors
    /// What is wrong, and where, in words.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::settings::Profile;
    /// let settings = Profile::from_json(r#"{"layer_height_mm": 0.2, "bead_mm": 0.45}"#)?.settings();
    /// assert_eq!((settings.layer_height_mm, settings.nozzle, settings.max_feed_mm_s), (Some(0.2), None, 40.0));
    /// let error = Profile::from_json(r#"{"layer_hight_mm": 0.2}"#).unwrap_err();
    /// assert_eq!(error, "line 1: `layer_hight_mm` is not a setting; did you mean `layer_height_mm`?");
    /// # Ok::<(), String>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Profile, String> {
        // Types and unknown names are found with their place in the text, values by the rules of the options.
        let typed: Result<Settings, _> = serde_json::from_str(text);
        typed.map_err(|error| explained(text, &error))?;
        let given = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let profile = Profile { given };
        profile.check()?;
        Ok(profile)
    }

    /// What the command line would refuse.
    fn check(&self) -> Result<(), String> {
        let command = Settings::command();
        let long_of = |name: &str| command.get_arguments().find(|arg| arg.get_id() == name)?.get_long();
        for (name, value) in self.given.iter().filter(|(_, value)| !value.is_null()) {
            let lines = value.as_array().into_iter().flatten().filter_map(Value::as_str);
            if let Some(at) = lines.into_iter().position(|line| line.contains(['\n', '\r'])) {
                return Err(format!("`{name}`, line {}: a line break within a line; write one text for each", at + 1));
            }
            let Some(long) = long_of(name) else { continue };
            let word = format!("--{long}={}", as_typed(value));
            if let Err(error) = command.clone().try_get_matches_from(["settings", &word]) {
                let why = error.source().map_or_else(|| error.kind().to_string(), ToString::to_string);
                return Err(match value {
                    Value::Array(_) => format!("`{name}`: {why}"),
                    _ => format!("`{name}` is {value}: {why}"),
                });
            }
        }
        Ok(())
    }

    /// The settings without a command line.
    pub fn settings(&self) -> Settings {
        self.put_into(Settings::default(), |_| false)
    }

    /// The settings of a command line, and where nothing was typed those of the profile.
    pub fn below(&self, typed: Settings, matches: &ArgMatches) -> Settings {
        self.put_into(typed, |name| is_typed(matches, name))
    }

    fn put_into(&self, settings: Settings, keeps: impl Fn(&str) -> bool) -> Settings {
        let mut all = settings.fields();
        all.extend(self.given.clone().into_iter().filter(|(name, _)| !keeps(name)));
        serde_json::from_value(Value::Object(all)).unwrap_or_else(|error| unreachable!("fields of settings: {error}"))
    }
}

impl Settings {
    /// All settings by name, null where they are not set.
    pub fn fields(&self) -> Map<String, Value> {
        match serde_json::to_value(self) {
            Ok(Value::Object(fields)) => fields,
            other => unreachable!("settings are an object: {other:?}"),
        }
    }
}

/// A value as it would be typed: texts without quotes, lists with commas.
fn as_typed(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) => values.iter().map(as_typed).collect::<Vec<_>>().join(","),
        value => value.to_string(),
    }
}

/// What is wrong with a profile: of an unknown setting the nearest known one, of all else what the parser says.
fn explained(text: &str, error: &serde_json::Error) -> String {
    let unknown = || -> Option<String> {
        let (known, given) = (Settings::default().fields(), serde_json::from_str::<Map<String, Value>>(text).ok()?);
        let name = given.keys().find(|name| !known.contains_key(*name))?;
        let nearest = known.keys().map(|other| (edits(name, other), other)).min()?;
        let hint = match nearest {
            (far, other) if far <= name.chars().count().max(3) / 3 => format!("did you mean `{other}`?"),
            _ => format!("settings are {}", known.keys().map(String::as_str).collect::<Vec<_>>().join(", ")),
        };
        let line = text.lines().position(|line| line.contains(&format!("\"{name}\"")));
        let place = line.map_or_else(String::new, |line| format!("line {}: ", line + 1));
        Some(format!("{place}`{name}` is not a setting; {hint}"))
    };
    unknown().unwrap_or_else(|| JsonFault::from(error).to_string())
}

/// Letters to put in, take out or change until one word is the other: Wagner and Fischer's table, a row at a time.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in (1..).zip(a.chars()) {
        let mut corner = std::mem::replace(&mut row[0], i);
        for (j, other) in (1..).zip(&b) {
            let replaced = corner + usize::from(letter != *other);
            corner = row[j];
            row[j] = replaced.min(row[j] + 1).min(row[j - 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::edits;

    #[test]
    fn edits_of_words() {
        let cases = [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("flow", "flow", 0), ("ab", "ba", 2)];
        for (a, b, distance) in cases {
            assert_eq!((edits(a, b), edits(b, a)), (distance, distance), "{a} {b}");
        }
    }
}
