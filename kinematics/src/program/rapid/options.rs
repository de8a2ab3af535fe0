//! Options of RAPID, checked: names, frames, loads, and who holds what.

use super::{FILAMENT_STEP, FilamentOutput, RapidAcceleration, RapidOptions, RapidSwitching, TOOL0, TRIGGERS, WOBJ0};
use crate::program::check::{check_frame, check_option, check_payload};
use crate::program::text::names::{Language, check_distinct, check_form, check_name};
use crate::program::{HeadInput, HeadSignal, WriteError};
use nalgebra::Isometry3;

/// Longest name of a program: with `_`, seven digits and `_run` it is as long as a word may be.
const MAX_NAME: usize = 20;
/// Longest name in RAPID.
const MAX_WORD: usize = 32;

/// Whether a program can be written so.
pub(super) fn check_options(options: &RapidOptions) -> Result<(), WriteError> {
    check_names(options)?;
    check_frame("tool.frame", &options.tool.frame)?;
    check_frame("work_object.frame", &options.work_object.frame)?;
    if let Some(load) = &options.tool.load {
        check_payload(["tool.load.mass_kg", "tool.load.centre"], load)?;
    }
    if let Some(load) = &options.part_load {
        check_payload(["part_load.mass_kg", "part_load.centre"], load)?;
    }
    check_hands(options)?;
    if let FilamentOutput::Group { step_mm_s, bits } = options.filament_output {
        let fits = (1e-6..=1e3).contains(&step_mm_s);
        check_option("filament_output.step_mm_s", step_mm_s, fits, "it must be from 1e-6 to 1000 mm/s")?;
        let fits = (1..=23).contains(&bits);
        check_option("filament_output.bits", f64::from(bits), fits, "it must be from 1 to 23")?;
    }
    if let RapidSwitching::OnPath { lag_s } = options.switching {
        let fits = (0.0..=MAX_LAG_S).contains(&lag_s);
        check_option("switching.lag_s", lag_s, fits, "it must be from 0 to 0.5 s")?;
    }
    if let Some(acceleration) = &options.acceleration {
        check_acceleration(acceleration)?;
    }
    let most = options.moves_per_module;
    check_option("moves_per_module", f64::from(most), most >= 1, "it must be 1 or more")
}

/// Greatest `Event Preset Time` of a controller.
const MAX_LAG_S: f64 = 0.5;
/// Least of `PathAccLim` and `WorldAccLim`, m/s2: below it a controller raises an error.
const MIN_ACCELERATION_M_S2: f64 = 0.1;
/// Greatest: ten times what arms reach, so that it is no limit.
const MAX_ACCELERATION_M_S2: f64 = 100.0;

fn check_acceleration(acceleration: &RapidAcceleration) -> Result<(), WriteError> {
    let RapidAcceleration { percent, ramp_percent, path_m_s2, world_m_s2 } = *acceleration;
    // Less is written, but not obeyed: a controller takes 20 and 10 instead.
    check_option("acceleration.percent", percent, (20.0..=100.0).contains(&percent), "it must be from 20 to 100")?;
    let fits = (10.0..=100.0).contains(&ramp_percent);
    check_option("acceleration.ramp_percent", ramp_percent, fits, "it must be from 10 to 100")?;
    for (what, limit) in [("acceleration.path_m_s2", path_m_s2), ("acceleration.world_m_s2", world_m_s2)] {
        if let Some(limit) = limit {
            let fits = (MIN_ACCELERATION_M_S2..=MAX_ACCELERATION_M_S2).contains(&limit);
            check_option(what, limit, fits, "it must be from 0.1 to 100 m/s2")?;
        }
    }
    Ok(())
}

fn check_names(options: &RapidOptions) -> Result<(), WriteError> {
    let (tool, work) = (&options.tool, &options.work_object);
    check_name(Language::Rapid, "name", &options.name, MAX_NAME)?;
    let mut names = vec![("name", options.name.as_str())];
    for (what, name, installed) in [("tool.name", &tool.name, TOOL0), ("work_object.name", &work.name, WOBJ0)] {
        if name != installed {
            check_name(Language::Rapid, what, name, MAX_WORD)?;
        }
        names.push((what, name));
    }
    for (what, name) in [("signal", &options.signal), ("filament_signal", &options.filament_signal)] {
        check_name(Language::Rapid, what, name, MAX_WORD)?;
        names.push((what, name));
    }
    if let Some(unit) = &work.unit {
        check_name(Language::Rapid, "work_object.unit", unit, MAX_WORD)?;
        names.push(("work_object.unit", unit));
    }
    names.extend(HeadSignal::ALL.map(|signal| ("signal of a tape head", signal.rapid())));
    names.extend(HeadInput::ALL.map(|input| ("input of a tape head", input.rapid())));
    check_distinct(&names)?;
    for &(what, name) in &names[1..names.len() - HeadSignal::ALL.len() - HeadInput::ALL.len()] {
        let ours = name.len() > options.name.len()
            && name.as_bytes()[..options.name.len()].eq_ignore_ascii_case(options.name.as_bytes())
            && name.as_bytes()[options.name.len()] == b'_';
        if ours || TRIGGERS.iter().chain([&FILAMENT_STEP]).any(|taken| name.eq_ignore_ascii_case(taken)) {
            let need = "modules and procedures of the program have such names; take another".to_owned();
            return Err(WriteError::Name { what, name: name.to_owned(), need });
        }
    }
    // A folder such as `HOME:` or `HOME:/parts`.
    let folder: String = options.folder.chars().filter(|c| !matches!(c, ':' | '/' | '-' | '.')).collect();
    check_form("folder", &folder, MAX_WORD).map_err(|_| WriteError::Name {
        what: "folder",
        name: options.folder.clone(),
        need: "it must be like `HOME:` or `HOME:/parts`".to_owned(),
    })
}

/// Who holds what, and what would be lost.
fn check_hands(options: &RapidOptions) -> Result<(), WriteError> {
    let (tool, work) = (&options.tool, &options.work_object);
    let is_moved = |frame: &Isometry3<f64>| *frame != Isometry3::identity();
    let conflicts = [
        ("tool.in_hand", tool.name == TOOL0 && !tool.in_hand, "`tool0` is the flange; give a tool that stands a name"),
        (
            "tool.frame",
            tool.name == TOOL0 && is_moved(&tool.frame),
            "`tool0` is the flange, so the frame would be lost; give the tool another name",
        ),
        (
            "tool.load",
            tool.name == TOOL0 && tool.load.is_some(),
            "`tool0` is not declared, so the load would be lost; give the tool another name",
        ),
        (
            "work_object.in_hand",
            work.name == WOBJ0 && work.in_hand,
            "`wobj0` is the world; give a work object in the hand a name",
        ),
        (
            "work_object.frame",
            work.name == WOBJ0 && is_moved(&work.frame),
            "`wobj0` is the world, so the frame would be lost; give the work object another name",
        ),
        (
            "work_object.unit",
            work.name == WOBJ0 && work.unit.is_some(),
            "`wobj0` is the world, so the unit would be lost; give the work object another name",
        ),
        (
            "work_object.in_hand",
            tool.in_hand && work.in_hand,
            "tool and work object are both in the hand; only one can be",
        ),
        (
            "work_object.in_hand",
            !tool.in_hand && !work.in_hand,
            "neither tool nor work object is in the hand; the robot must hold one",
        ),
        ("work_object.unit", work.in_hand && work.unit.is_some(), "a work object in the hand is on no mechanical unit"),
        (
            "part_load",
            !work.in_hand && options.part_load.is_some(),
            "the work object is not in the hand, so the load would be lost; leave it out",
        ),
    ];
    match conflicts.into_iter().find(|(_, is_so, _)| *is_so) {
        Some((what, _, need)) => Err(WriteError::Conflict { what, need }),
        None => Ok(()),
    }
}
