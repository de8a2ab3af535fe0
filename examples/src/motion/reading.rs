//! The model of a workcell: a JSON file, the name of an arm, or a URDF.

use super::link_mesh;
use crate::input;
use crate::outcome::Failure;
use curvlay_kinematics::robots;
use curvlay_kinematics::urdf::{LinkNames, UrdfArm};
use curvlay_kinematics::workcell::{AnyWorkcell, ArmPart, BodiesModel, WorkcellModel};
use std::path::Path;

/// The workcell of a run of `curved_layers`, in its output folder.
pub const WORKCELL_FILE: &str = "workcell.json";

/// Where the names of arms are, for messages.
const NAMES: &str = "examples/cells/arms.json has the names of arms, examples/cells/ur10.json is a workcell to copy";

/// Reads a workcell that a user names.
///
/// # Arguments
/// * `given`: a workcell file (its URDF, if it names one, is read from its folder); the name of an arm of [`robots::CATALOGUE`], if there is no such
///   file; or a URDF. An arm alone gets an assumed workcell: [`WorkcellModel::around`].
///
/// # Errors
/// A line with the file and what is wrong with it, or with the names that are near.
pub fn workcell_model(given: &Path) -> Result<WorkcellModel, Failure> {
    if !given.exists() {
        return named(given);
    }
    let failed = |error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", given.display()));
    let text = input::read_text(given, input::MAX_SETTINGS_BYTES)?;
    if text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
        return of_urdf(&text, given).map_err(|error| failed(&error));
    }
    let model = WorkcellModel::from_json(text.as_bytes()).map_err(|error| failed(&error))?;
    let mut beside = |file: &str| {
        let path = folder(given).join(file);
        input::read_text(&path, input::MAX_SETTINGS_BYTES).map_err(|error| error.to_string())
    };
    model.with_urdf(&mut beside).map_err(|error| failed(&error))
}

/// The workcell that a user names, or the one of a file that comes along.
///
/// # Errors
/// As of [`workcell_model`].
pub fn workcell_or(given: Option<&Path>, shipped: &str) -> Result<WorkcellModel, Failure> {
    given.map_or_else(|| Ok(WorkcellModel::from_json(shipped.as_bytes())?), workcell_model)
}

/// The workcell of a model, whose link meshes are beside the file that it is from.
///
/// # Errors
/// A line with the file and the field.
pub fn workcell_of(model: WorkcellModel, given: Option<&Path>) -> Result<AnyWorkcell, Failure> {
    let beside = given.map_or(Path::new(""), folder);
    AnyWorkcell::with_link_meshes(model, &mut |file| link_mesh(beside, file)).map_err(|error| match given {
        Some(file) => Failure::new(format!("{}: {error}", file.display())),
        None => Failure::new(error),
    })
}

fn folder(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// An arm by its name; what looks like a path is a file that is not there.
fn named(given: &Path) -> Result<WorkcellModel, Failure> {
    let name = given.to_string_lossy();
    if let Some(arm) = robots::find(&name) {
        return Ok(WorkcellModel::around(arm));
    }
    let near = robots::near(&name);
    let near = if near.is_empty() { String::new() } else { format!("; near are the arms {}", near.join(", ")) };
    Err(Failure::new(format!("{name}: no such file, and no arm of that name{near}; {NAMES}")))
}

fn of_urdf(text: &str, file: &Path) -> Result<WorkcellModel, String> {
    let arm = UrdfArm::read(text, &LinkNames::default()).map_err(|error| error.to_string())?;
    let part = ArmPart { bodies: Some(BodiesModel::Estimated), ..ArmPart::of_urdf(&arm)? };
    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let name = if arm.name.is_empty() { &stem } else { &arm.name };
    Ok(WorkcellModel::around_part(name, part, &arm.model, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvlay_kinematics::workcell::ArmGeometry;

    #[test]
    fn a_name_that_is_no_file_is_an_arm() {
        let model = workcell_model(Path::new("ur10e")).unwrap();
        assert!(model.is_assumed() && model.arm.geometry == ArmGeometry::Named("UR10e".into()));
        let cell = workcell_of(model, None).unwrap();
        assert_eq!(cell.equipment().catalogue_arm().map(|arm| arm.title), Some("UR10e"));
        let unknown = workcell_model(Path::new("ur10f")).unwrap_err();
        assert!(
            unknown
                .message()
                .starts_with("ur10f: no such file, and no arm of that name; near are the arms UR10, UR10e")
        );
        let file = workcell_model(Path::new("no/such/cell.json")).unwrap_err();
        assert!(file.message().starts_with("no/such/cell.json: no such file, and no arm of that name; examples/cells"));
    }
}
