//! Options of `curved_layers`: what `--help` says of them is what docs/formats/summary.md says.

use crate::common;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Keys of `summary.json` that are options other than settings, each with its option. What a run derives from the same option stands beside
/// the results.
const KEYS: [(&str, &str); 49] = [
    ("mesh", "mesh"),
    ("unit", "unit"),
    ("scale", "scale"),
    ("up", "up"),
    ("on", "on"),
    ("base", "base"),
    ("directions", "directions"),
    ("max_overhang_deg", "max-overhang"),
    ("orient", "orient"),
    ("eps_cells", "eps"),
    ("beyond_eps", "beyond-eps"),
    ("strategy", "strategy"),
    ("prevention", "prevention"),
    ("coherent", "coherent"),
    ("layers_by", "layers-by"),
    ("nozzle_growth", "nozzle-growth"),
    ("nozzle_max_tilt_deg", "max-tilt"),
    ("max_layer_tilt_deg", "max-layer-tilt"),
    ("nozzle_margin_cells", "nozzle-margin"),
    ("support", "support"),
    ("support_width_cells", "support-width"),
    ("support_contact_cells", "support-contact"),
    ("support_gap_cells", "support-gap"),
    ("support_density", "support-density"),
    ("pattern", "pattern"),
    ("least_gap", "min-gap"),
    ("join_distance_beads", "join-distance"),
    ("least_length_beads", "min-length"),
    ("least_width_beads", "min-width"),
    ("support_distance", "support-distance"),
    ("allow_missed", "allow-missed"),
    ("allow_volume", "allow-volume"),
    ("allow_gouging", "allow-gouging"),
    ("allow_left_out", "allow-left-out"),
    ("allow_unsupported", "allow-unsupported"),
    ("allow_unsupported_beads", "allow-unsupported-beads"),
    ("allow_unprinted", "allow-unprinted"),
    ("limit_acceleration_rad_s2", "acceleration"),
    ("limit_jerk_rad_s3", "jerk"),
    ("limit_flow_mm3_s", "max-flow"),
    ("limit_flow_ramp_mm3_s2", "max-flow-ramp"),
    ("path_tolerance_mm", "tolerance"),
    ("margin_mm", "margin"),
    ("link_allowance_mm", "link-allowance"),
    ("profile", "profile"),
    ("workcell", "workcell"),
    ("stage", "stage"),
    ("threads", "threads"),
    ("max_memory_gb", "max-memory"),
];

/// Options without a key: what they do is seen in the results, or in the files.
const WITHOUT_KEY: &str = "help version allow-large allow-guesses voxels cell resume layers merge compare statistics out quiet also machine \
    orient-directions orient-voxels refine min-tipping standing-first cell8 program no-links program-steps ur-extruder";

/// An option as `--help` shows it.
#[derive(Debug, Default)]
struct Shown {
    long: String,
    help: String,
    choices: Vec<String>,
    default: Option<String>,
}

/// All options of a command, read from what it prints for `--help`: an option and its value, help indented below it, then its choices and
/// its default.
fn shown(example: &str) -> Vec<Shown> {
    let output = common::example(example).arg("--help").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let mut options: Vec<Shown> = Vec::new();
    for line in text.lines() {
        let words = line.trim();
        let option = words.strip_prefix("--").or_else(|| words.split_once(", --").map(|(_, long)| long));
        if let (true, Some(option)) = (line.starts_with("  ") && !line.starts_with("         "), option) {
            let long = option.split([' ', '[']).next().unwrap().to_owned();
            options.push(Shown { long, ..Shown::default() });
            continue;
        }
        let Some(option) = options.last_mut().filter(|_| line.starts_with("          ")) else { continue };
        if let Some(default) = words.strip_prefix("[default: ").and_then(|rest| rest.strip_suffix(']')) {
            option.default = Some(default.to_owned());
        } else if let Some((choice, _)) = words.strip_prefix("- ").and_then(|rest| rest.split_once(':')) {
            option.choices.push(choice.to_owned());
        } else if option.help.is_empty() {
            option.help = words.to_owned();
        }
    }
    options
}

/// The row of a key.
fn row(key: &str, option: &Shown) -> String {
    let Shown { long, help, choices, default } = option;
    let choices: Vec<String> = choices.iter().map(|choice| format!("`{choice}`")).collect();
    let choices = if choices.is_empty() { String::new() } else { format!(": {}", choices.join(", ")) };
    // The number of processors is another one elsewhere.
    let default = default.as_ref().filter(|_| long != "threads");
    let default = default.map_or(String::new(), |default| format!(" (default: {default})"));
    let help = help.replace("[default: ", "(default: ").replace(']', ")");
    format!("| `{key}` | `--{long}` | {help}{choices}{default} |")
}

#[test]
fn the_page_on_the_summary_has_every_option() {
    let page = common::formats(Some("summary.md"));
    let options = shown("curved_layers");
    let mut table = String::new();
    for (key, long) in KEYS {
        let option = options.iter().find(|option| option.long == long);
        writeln!(table, "{}", row(key, option.unwrap_or_else(|| panic!("--{long} is no option")))).unwrap();
    }
    for row in table.lines() {
        assert!(
            page.lines().any(|line| line == row),
            "docs/formats/summary.md does not have this row:\n{row}\nAll rows:\n{table}"
        );
    }
    // No row is left over, and each option is in one of the lists.
    let rows = page.lines().filter(|line| line.contains("` | `--")).count();
    assert_eq!(rows, KEYS.len(), "docs/formats/summary.md has rows for options that are no keys");
    let settings = common::formats(Some("profiles.md"));
    let with_key: BTreeSet<&str> = KEYS.iter().map(|(_, long)| *long).collect();
    for Shown { long, .. } in &options {
        let ways = [
            with_key.contains(long.as_str()),
            WITHOUT_KEY.split(' ').any(|without| without == long),
            // The workcell is a setting, too: it stands with the options since the summary has its file.
            settings.contains(&format!("| `--{long}` |")) && long != "workcell",
        ];
        assert_eq!(ways.iter().filter(|way| **way).count(), 1, "--{long}: {ways:?}");
    }
}

#[test]
fn a_run_has_the_defaults_of_the_options() {
    let folder = std::env::temp_dir().join(format!("curvlay-options-{}", std::process::id()));
    let mut command = common::example("curved_layers");
    let output = command.args(["--quiet", "--voxels", "1500", "--out"]).arg(&folder).output().unwrap();
    let text = std::fs::read_to_string(folder.join("summary.json"));
    let text = text.unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    std::fs::remove_dir_all(&folder).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let mut compared = 0;
    for option in shown("curved_layers") {
        let Some((key, _)) = KEYS.iter().find(|(_, long)| *long == option.long) else { continue };
        let (Some(default), Some(value)) = (&option.default, summary.get(key)) else { continue };
        compared += 1;
        match value.as_f64() {
            // The option is a percentage, the key a share.
            Some(share) if *key == "support_density" => assert_eq!((100.0 * share).to_string(), *default),
            Some(number) => assert_eq!(number.to_string(), *default, "{key}"),
            None => assert_eq!(value.as_str(), Some(default.as_str()), "{key}"),
        }
    }
    assert!(compared >= 25, "only {compared} defaults were compared");
}
