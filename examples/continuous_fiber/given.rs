//! The files of the user.

use super::args::{Args, Stage};
use super::{layer, wires};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::input;
use curvlay_examples::motion::UR3_CELL;
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::shapes::jug;
use curvlay_examples::waypoints::fault;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_toolpath::fiber::stress::StressSample;

/// The files of the user, all of them read before anything is removed.
pub struct Given {
    pub cell: AnyWorkcell,
    pub part: Option<Part>,
    pub stress: Option<Vec<StressSample>>,
    pub wires: Vec<Vec<Point3<f64>>>,
}

impl Given {
    pub fn read(args: &Args) -> Result<Given, Failure> {
        let text = match &args.workcell {
            Some(path) => input::read(path, input::MAX_SETTINGS_BYTES)?,
            None => UR3_CELL.as_bytes().to_vec(),
        };
        let cell = AnyWorkcell::from_json(&text[..]).map_err(|error| match &args.workcell {
            Some(path) => fault(path, &error),
            None => error.into(),
        })?;
        let part = args.mesh.path().map(|_| args.mesh.load("part", jug)).transpose()?;
        if part.is_some() && args.stage >= Stage::Motion {
            args.check_roller(&cell)?;
        }
        let stress = args.stress.as_deref().map(layer::read_stress).transpose()?;
        let wires = args.wires.as_deref().map_or(Ok(Vec::new()), wires::read)?;
        Ok(Given { cell, part, stress, wires })
    }
}
