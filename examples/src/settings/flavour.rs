//! The G-code flavour of the machine file: by its name, or from a file.

use super::declared::Settings;
use crate::input;
use crate::json::JsonFault;
use crate::outcome::Failure;
use curvlay_toolpath::gcode::flavour::{Direction, Flavour};
use std::path::Path;

impl Settings {
    /// The flavour that is asked for, if one is: built in, or from a JSON file.
    ///
    /// # Errors
    /// A line with the name or the file, and what is wrong: a name that is not known, a file that cannot be read, a field that cannot be; a flavour that takes
    /// moves of axes, since what is planned here are tips and directions.
    pub fn load_flavour(&self) -> Result<Option<Flavour>, Failure> {
        let Some(text) = &self.flavour else { return Ok(None) };
        let flavour = named_flavour(text, Path::new(""))?.ok_or_else(|| {
            let names = Flavour::names().join(", ");
            let why = format!("`{text}` is no G-code flavour: there are {names}; or give a JSON file (name.json)");
            Failure::of_arguments(why)
        })?;
        if flavour.direction == Direction::Axes {
            let names = Flavour::names().iter().filter(|name| takes_directions(name)).copied();
            let names = names.collect::<Vec<_>>().join(", ");
            let why = format!(
                "the flavour `{}` takes moves of a machine's axes, and tips and directions are what is planned: {names} take those; --machine FILE describes a machine",
                flavour.name
            );
            return Err(Failure::of_arguments(why));
        }
        Ok(Some(flavour))
    }
}

/// A flavour by its name, or from a JSON file that is given from a folder; `None` where the text is neither.
///
/// # Errors
/// A line with the file, and what is wrong in it.
pub fn named_flavour(text: &str, folder: &Path) -> Result<Option<Flavour>, Failure> {
    match Flavour::built_in(text) {
        Some(flavour) => Ok(Some(flavour)),
        None if is_file(text) => from_file(&folder.join(text)).map(Some),
        None => Ok(None),
    }
}

/// The built-in flavours that say the direction of the nozzle in one way.
pub fn flavour_names(direction: Direction) -> Vec<&'static str> {
    let says = |name: &str| Flavour::built_in(name).is_some_and(|flavour| flavour.direction == direction);
    Flavour::names().iter().copied().filter(|name| says(name)).collect()
}

/// Whether the text is a file and no name.
pub(super) fn is_file(text: &str) -> bool {
    text.contains(['/', '\\']) || Path::new(text).extension().is_some()
}

fn takes_directions(name: &str) -> bool {
    Flavour::built_in(name).is_some_and(|flavour| flavour.direction != Direction::Axes)
}

fn from_file(path: &Path) -> Result<Flavour, Failure> {
    let text = input::read_text(path, input::MAX_SETTINGS_BYTES)?;
    let failed = |problem: String| Failure::new(format!("{}: {problem}", path.display()));
    let flavour: Flavour = serde_json::from_str(&text).map_err(|error| failed(JsonFault::from(&error).to_string()))?;
    flavour.check().map_err(|error| failed(error.to_string()))?;
    Ok(flavour)
}
