//! The files of the user.

use super::args::{Args, Stage};
use super::{layer, wires};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::motion::{UR3_CELL, workcell_of, workcell_or};
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::shapes::jug;
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
        let cell = workcell_of(workcell_or(args.workcell.as_deref(), UR3_CELL)?, args.workcell.as_deref())?;
        let part = args.mesh.path().map(|_| args.mesh.load("part", jug)).transpose()?;
        if part.is_some() && args.stage >= Stage::Motion {
            args.check_roller(&cell)?;
        }
        let stress = args.stress.as_deref().map(layer::read_stress).transpose()?;
        let wires = args.wires.as_deref().map_or(Ok(Vec::new()), wires::read)?;
        Ok(Given { cell, part, stress, wires })
    }
}
