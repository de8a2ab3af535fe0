//! What was typed.

use clap::parser::ValueSource;
use clap::{ArgMatches, ValueEnum};

/// The name of a choice as it is typed.
pub fn typed_name(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Whether an option was typed, rather than left at its default. What is no option was not.
pub fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    matches.ids().any(|known| known == id) && matches.value_source(id) == Some(ValueSource::CommandLine)
}
