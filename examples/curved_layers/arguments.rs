//! Which arguments go together: an option that would be ignored is refused, with a hint.

use crate::{Args, Extra, Lying, Stage};
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory};
use curvlay_examples::args::{Strategy, typed_name};

/// The options that a run uses from a stage on; it would not look at them before.
const NEEDS: [(Stage, &str); 4] = [
    (Stage::Surfaces, "coherent compare"),
    (
        Stage::Paths,
        "statistics bead_mm merge density_percent support_density walls skin_layers infill_pattern infill_turn_deg pattern least_gap join_distance least_length least_width",
    ),
    (
        Stage::Gcode,
        "nozzle clearance_mm min_lift_mm material filament_diameter_mm material_density_g_cm3 price_per_kg nozzle_celsius bed_celsius fan_share \
         flow_mm3_s min_feed_mm_s max_feed_mm_s max_turn_rate_deg_s max_turn_deg_mm travel_feed_mm_s retraction_mm retract_feed_mm_s prime_feed_mm_s \
         dialect extrusion tags line_numbers rotary workcell support_distance allow_volume allow_gouging allow_left_out allow_unsupported \
         allow_unsupported_beads",
    ),
    (
        Stage::Motion,
        "cell8 program acceleration jerk max_flow max_flow_ramp tolerance margin link_allowance no_links program_steps \
         allow_unprinted",
    ),
];

/// How an option is typed, without its dashes.
fn long_name(id: &str) -> String {
    let command = Args::command();
    let long = command.get_arguments().find(|arg| arg.get_id() == id).and_then(|arg| arg.get_long());
    long.unwrap_or(id).to_owned()
}

/// Says which option would be ignored.
pub fn check_arguments(matches: &ArgMatches) -> Result<(), String> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let asked = matches.get_one::<Stage>("stage").copied().unwrap_or(Stage::Gcode);
    let is_range = is_given("layers");
    if is_range && is_given("stage") && asked != Stage::Paths {
        return Err(format!("--layers ends after the paths: --stage {} does not go with it", typed_name(asked)));
    }
    let stage = if is_range { Stage::Paths } else { asked };
    for (needed, ids) in NEEDS.into_iter().filter(|(needed, _)| *needed > stage) {
        if let Some(id) = ids.split(' ').find(|id| is_given(id)) {
            let (name, needed) = (long_name(id), typed_name(needed));
            return Err(format!("--{name} does nothing with --stage {}: it needs --stage {needed}", typed_name(stage)));
        }
    }
    let extras = matches.get_many::<Extra>("also").into_iter().flatten();
    if let Some(extra) = extras.copied().find(|extra| extra.stage() > stage) {
        let [name, needed, stage] = [typed_name(extra), typed_name(extra.stage()), typed_name(stage)];
        return Err(format!("--also {name} does nothing with --stage {stage}: it needs --stage {needed}"));
    }
    let sparse = ["walls", "skin_layers", "infill_pattern", "infill_turn_deg"].into_iter().find(|id| is_given(id));
    if let Some(id) = sparse.filter(|_| !is_given("density_percent") && !is_given("profile")) {
        return Err(format!("--{} does nothing in a part that is solid: see --density", long_name(id)));
    }
    let strategy = matches.get_one("strategy").copied();
    if is_given("prevention") && !matches!(strategy, Some(Strategy::Governed | Strategy::Printed)) {
        return Err("--prevention needs --strategy governed or printed".to_owned());
    }
    let with_it = [
        ("mould", "--on: the part lies on it"),
        ("base", "--base: the part lies across it"),
        ("directions", "--directions: the part lies in them"),
    ];
    if let Some((_, with)) = with_it.into_iter().find(|(id, _)| is_given(id))
        && matches.get_one::<Lying>("orient") == Some(&Lying::Best)
    {
        return Err(format!("--orient best does not go with {with} as the files have both"));
    }
    if matches.get_one::<Lying>("orient") != Some(&Lying::Best) {
        let posing = ["orient_directions", "orient_voxels", "refine", "least_tipping", "standing_first"];
        if let Some(id) = posing.into_iter().find(|id| is_given(id)) {
            return Err(format!("--{} needs --orient best", id.replace('_', "-")));
        }
    }
    Ok(())
}
