//! A five-axis machine and the flavour of its controller, from a file.

use crate::axis_program::axes_of;
use crate::input;
use crate::outcome::Failure;
use crate::settings::{flavour_names, named_flavour};
use curvlay_kinematics::machine::{FiveAxis, MachineFileError};
use curvlay_toolpath::gcode::Move;
use curvlay_toolpath::gcode::flavour::{Direction, Flavour};
use std::path::Path;

/// The flavour of a machine whose file names none: it takes axes of any letters and times of moves.
const FLAVOUR: &str = "linuxcnc";

/// A machine, and what its controller reads.
#[derive(Clone, Debug)]
pub struct FiveAxisPrinter {
    /// The machine.
    pub machine: FiveAxis,
    /// Its flavour, with an extruder of a letter that no axis has.
    pub flavour: Flavour,
}

impl FiveAxisPrinter {
    /// Reads the file of a machine (`docs/formats/machines.md`). Its `dialect` is the name of a flavour, or a JSON file beside it.
    ///
    /// # Errors
    /// A line with the file and what is wrong there: a field of the machine, a flavour that is not known or that takes no axes.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let failed = |what: String| Failure::new(format!("{}: {what}", path.display()));
        let text = input::read_text(path, input::MAX_SETTINGS_BYTES)?;
        let machine =
            FiveAxis::from_json(text.as_bytes()).map_err(|error: MachineFileError| failed(error.to_string()))?;
        let name = machine.model().dialect.as_deref().unwrap_or(FLAVOUR);
        let flavour = named_flavour(name, path.parent().unwrap_or(Path::new("")))?;
        let flavour = flavour.ok_or_else(|| {
            let known = flavour_names(Direction::Axes).join(", ");
            failed(format!(
                "dialect: `{name}` is no G-code flavour: {known} take axes; or give a JSON file (name.json)"
            ))
        })?;
        if flavour.direction != Direction::Axes {
            let known = flavour_names(Direction::Axes).join(", ");
            return Err(failed(format!("dialect: the flavour `{}` takes no axes; {known} do", flavour.name)));
        }
        let axes = axes_of(&machine);
        let flavour = flavour.for_machine(&axes);
        flavour.check_machine(&axes).map_err(|error| failed(error.to_string()))?;
        Ok(FiveAxisPrinter { machine, flavour })
    }

    /// What keeps the machine from a part, in words: how many places of its moves, the worst one, and what would help. `None` where it reaches all.
    pub fn out_of_reach(&self, moves: impl Iterator<Item = Move>) -> Option<String> {
        let places = moves.filter_map(|item| match item {
            Move::Travel { tip, direction, .. }
            | Move::Print { tip, direction, .. }
            | Move::Lay { tip, direction, .. } => Some((tip, direction)),
            _ => None,
        });
        let reach = self.machine.reach(places);
        let worst = reach.worst?;
        let at = worst.tip;
        Some(format!(
            "{} of {} places are out of its reach, the farthest at {:.1} {:.1} {:.1}: {}; try another --orient, gentler layers \
             (--max-layer-tilt), another part_origin_mm, or wider ranges",
            reach.unreachable, reach.places, at.x, at.y, at.z, worst.reason
        ))
    }
}
