//! What has been written, for what refers to it.

use super::axes::AxisProgram;
use super::programs::Programs;
use curvlay_toolpath::gcode::Written;

/// What stands in the machine file and in the programs.
#[derive(Default)]
pub struct Files {
    pub gcode: Option<Written>,
    pub axes: Option<AxisProgram>,
    pub programs: Option<Programs>,
}

impl Files {
    /// Whether programs were written and read again.
    pub fn has_read_programs(&self) -> bool {
        self.programs.as_ref().is_some_and(|programs| programs.read.is_some())
    }
}
