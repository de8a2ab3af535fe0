//! Which arguments go together: an option that would be ignored is refused, with a hint.

use crate::args::{Extra, Lying, Stage, command};
use clap::{Arg, ArgMatches};
use curvlay_examples::args::{Strategy, is_typed, typed_name};
use curvlay_examples::settings::{FILES, LAYERS, MACHINE, MATERIAL, SPEEDS};

/// The stage from which on a run uses the options of a topic; it would not look at them before. Options of other topics are always used.
const TOPICS: [(&str, Stage); 7] = [
    (LAYERS, Stage::Paths),
    (MACHINE, Stage::Gcode),
    (MATERIAL, Stage::Gcode),
    (SPEEDS, Stage::Gcode),
    (FILES, Stage::Gcode),
    ("What may be wrong", Stage::Gcode),
    ("Motion of a robot", Stage::Motion),
];

/// Options that are used from another stage on than the rest of their topic.
const EXCEPTIONS: [(&str, Stage); 11] = [
    ("layer_height_mm", Stage::Field),
    ("platform_diameter_mm", Stage::Field),
    ("also", Stage::Field),
    ("allow_missed", Stage::Field),
    ("coherent", Stage::Surfaces),
    ("compare", Stage::Surfaces),
    ("statistics", Stage::Paths),
    ("merge", Stage::Paths),
    ("support_density_percent", Stage::Paths),
    ("workcell", Stage::Gcode),
    ("allow_unprinted", Stage::Motion),
];

/// The first stage that uses an option.
fn stage_of(option: &Arg) -> Stage {
    let of =
        |name: &str, list: &[(&str, Stage)]| list.iter().find(|(other, _)| *other == name).map(|&(_, stage)| stage);
    let by_topic = || of(option.get_help_heading()?, &TOPICS);
    of(option.get_id().as_str(), &EXCEPTIONS).or_else(by_topic).unwrap_or(Stage::Field)
}

/// Says which option would be ignored.
pub fn check(matches: &ArgMatches) -> Result<(), String> {
    let command = command();
    let is_known = |id: &str| command.get_arguments().any(|option| option.get_id() == id);
    let is_topic = |topic: &str| command.get_arguments().any(|option| option.get_help_heading() == Some(topic));
    debug_assert!(EXCEPTIONS.iter().all(|(id, _)| is_known(id)) && TOPICS.iter().all(|(topic, _)| is_topic(topic)));
    let typed: Vec<&Arg> =
        command.get_arguments().filter(|option| is_typed(matches, option.get_id().as_str())).collect();
    let is_given = |id: &str| is_typed(matches, id);
    let first_of =
        |ids: &[&str]| typed.iter().find(|option| ids.contains(&option.get_id().as_str())).copied().map(name_of);
    let asked = matches.get_one::<Stage>("stage").copied().unwrap_or(Stage::Gcode);
    let is_range = is_given("layers");
    if is_range && is_given("stage") && asked != Stage::Paths {
        return Err(format!("--layers ends after the paths: --stage {} does not go with it", typed_name(asked)));
    }
    let stage = if is_range { Stage::Paths } else { asked };
    match stage {
        Stage::Preview => of_preview(matches, &typed)?,
        _ => of_stage(stage, matches, &typed)?,
    }
    if !is_given("density_percent")
        && !is_given("profile")
        && let Some(name) = first_of(&["walls", "skin_layers", "infill_pattern", "infill_turn_deg"])
    {
        return Err(format!("--{name} does nothing in a part that is solid: see --density"));
    }
    let strategy = matches.get_one("strategy").copied();
    if is_given("prevention") && !matches!(strategy, Some(Strategy::Governed | Strategy::Printed)) {
        return Err("--prevention needs --strategy governed or printed".to_owned());
    }
    let is_best = matches.get_one::<Lying>("orient") == Some(&Lying::Best);
    let with_it = [
        ("mould", "--on: the part lies on it"),
        ("base", "--base: the part lies across it"),
        ("directions", "--directions: the part lies in them"),
    ];
    if let Some((_, with)) = with_it.into_iter().find(|(id, _)| is_best && is_given(id)) {
        return Err(format!("--orient best does not go with {with} as the files have both"));
    }
    let posing = ["orient_directions", "orient_voxels", "refine", "min_tipping_deg", "standing_first"];
    match first_of(&posing).filter(|_| !is_best) {
        Some(name) => Err(format!("--{name} needs --orient best")),
        None => Ok(()),
    }
}

/// How an option is typed, without its dashes.
fn name_of(option: &Arg) -> String {
    option.get_long().unwrap_or_default().to_owned()
}

/// Says which option asks for what a later stage makes.
fn of_stage(stage: Stage, matches: &ArgMatches, typed: &[&Arg]) -> Result<(), String> {
    if let Some(option) = typed.iter().find(|option| stage_of(option) > stage) {
        let (name, needed) = (name_of(option), typed_name(stage_of(option)));
        return Err(format!("--{name} does nothing with --stage {}: it needs --stage {needed}", typed_name(stage)));
    }
    let mut extras = matches.get_many::<Extra>("also").into_iter().flatten();
    match extras.find(|extra| extra.stage() > stage) {
        Some(extra) => {
            let [name, needed, stage] = [typed_name(*extra), typed_name(extra.stage()), typed_name(stage)];
            Err(format!("--also {name} does nothing with --stage {stage}: it needs --stage {needed}"))
        }
        None => Ok(()),
    }
}

/// Options that ask for what a preview does not make. It accepts all others: it is of the run that they describe.
const NOT_OF_PREVIEW: [&str; 3] = ["merge", "compare", "statistics"];

/// Says which option asks for what a preview does not make.
fn of_preview(matches: &ArgMatches, typed: &[&Arg]) -> Result<(), String> {
    let what = "does nothing with --stage preview, which makes no paths and no files of layers";
    if let Some(option) = typed.iter().find(|option| NOT_OF_PREVIEW.contains(&option.get_id().as_str())) {
        return Err(format!("--{} {what}", name_of(option)));
    }
    let mut extras = matches.get_many::<Extra>("also").into_iter().flatten();
    match extras.find(|extra| **extra != Extra::Gltf) {
        Some(extra) => Err(format!("--also {} {what} but build.glb (--also gltf)", typed_name(*extra))),
        None => Ok(()),
    }
}
