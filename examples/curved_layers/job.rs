//! What is to be done, and what comes of it.

use crate::args::{Args, Stage};
use crate::choice::Choice;
use crate::field::FieldRun;
use crate::guide::Guide;
use crate::machine::MachineRun;
use crate::motion::Motion;
use crate::motion::args::ProgramFormat;
use crate::outputs::Files;
use crate::paths::PathsRun;
use crate::preview::PreviewRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::Findings;
use curvlay_examples::motion::nozzle_of;
use curvlay_examples::orienting::Search;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::settings::default_nozzle;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_toolpath::gouging::Nozzle;
use std::time::Duration;

/// The pose that was found for the part.
pub struct Posed {
    pub search: Search,
    pub time: Duration,
}

/// What prints.
pub struct Setup {
    pub cell: AnyWorkcell,
    pub format: ProgramFormat,
    pub nozzle: Nozzle,
}

impl Setup {
    pub fn of(args: &Args) -> Result<Self, Failure> {
        let nozzle =
            args.settings.nozzle.or(if args.motion.workcell.is_none() { Some(default_nozzle()) } else { None });
        let cell = args.motion.cell(nozzle)?;
        if args.stage == Stage::Motion {
            args.motion.check_links(&cell)?;
        }
        let format = args.motion.format(&cell)?;
        args.motion.check_extruder(format)?;
        Ok(Setup { format, nozzle: nozzle_of(cell.equipment())?, cell })
    }
}

/// What is to be done.
pub struct Job<'a> {
    pub args: &'a Args,
    pub setup: Setup,
    pub part: &'a Part,
    pub mould: Option<&'a Part>,
    pub guide: Option<&'a Guide>,
    /// The pose of the part, where it was searched.
    pub posed: Option<Posed>,
    pub folder: &'a OutputFolder,
    pub bars: &'a Bars,
}

/// What came of the stages, and what is wrong with it.
pub struct Results {
    pub field: FieldRun,
    pub surfaces: Option<SurfacesRun>,
    pub paths: Option<PathsRun>,
    pub machine: Option<MachineRun>,
    pub motion: Option<Motion>,
    /// What a preview estimates; its surfaces are some of the layers.
    pub preview: Option<PreviewRun>,
    pub files: Files,
    pub findings: Findings,
    /// Why this order, where several were tried.
    pub choice: Option<Choice>,
}

impl Results {
    /// Whether a stage has been run.
    pub fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::Preview => self.preview.is_some(),
            Stage::Field => true,
            Stage::Surfaces => self.surfaces.is_some(),
            Stage::Paths => self.paths.is_some(),
            Stage::Gcode => self.machine.is_some(),
            Stage::Motion => self.motion.is_some(),
        }
    }
}
