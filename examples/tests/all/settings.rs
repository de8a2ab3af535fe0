//! Settings: what their declaration says is what docs/formats/profiles.md says.

use curvlay_examples::settings::{Profile, Settings};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// The rows of the table of settings, by topic.
fn table() -> String {
    let command = Settings::command();
    let mut table = String::new();
    for option in command.get_arguments() {
        let help = option.get_help().unwrap().to_string().replace("[default: ", "(default: ").replace(']', ")");
        let choices: Vec<String> =
            option.get_possible_values().iter().map(|value| format!("`{}`", value.get_name())).collect();
        let choices = if choices.is_empty() { choices.concat() } else { format!(": {}", choices.join(", ")) };
        let default = match option.get_default_values() {
            [default] if !option.is_hide_default_value_set() => format!(" (default: {})", default.to_string_lossy()),
            _ => String::new(),
        };
        let (id, long) = (option.get_id(), option.get_long().unwrap());
        let topic = option.get_help_heading().unwrap();
        writeln!(table, "| `{id}` | `--{long}` | {topic} | {help}{choices}{default} |").unwrap();
    }
    table
}

#[test]
fn the_page_on_formats_has_every_setting() {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats/profiles.md")).unwrap();
    let table = table();
    for row in table.lines() {
        assert!(page.contains(row), "docs/formats/profiles.md does not have this row:\n{row}\nAll rows:\n{table}");
    }
    for name in Settings::default().fields().keys() {
        assert!(page.contains(&format!("| `{name}` |")), "docs/formats/profiles.md has no row for {name}");
    }
}

#[test]
fn a_profile_is_judged_by_the_rules_of_the_options() {
    for (text, words) in [
        (r#"{"walls": 10001}"#, "`walls` is 10001: 10001 is not in "),
        (r#"{"fan_share": 1.5}"#, "`fan_share` is 1.5: must be from 0 to 1"),
        (r#"{"filament_diameter_mm": 100}"#, "must be from 0.1 to 50 mm"),
        (r#"{"nozzle": [0, 30, 8, 30]}"#, "`nozzle`: "),
        (r#"{"dialect": "latin"}"#, "line 1, column "),
        (r#"{"walls": 1.5}"#, "line 1, column "),
    ] {
        let error = Profile::from_json(text).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
    let all = serde_json::to_string(&Settings::default().fields()).unwrap();
    assert_eq!(Profile::from_json(&all).unwrap().settings(), Settings::default());
}
