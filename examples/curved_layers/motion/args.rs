//! Options of the stage: which workcell, and what its controller is given.

use clap::ValueEnum;
use curvlay_examples::args::{Failure, UrExtruderArgs, above_zero, from_zero, limit};
use curvlay_examples::motion::{TABLE_CELL, UR3_CELL, programs, workcell_model, workcell_of};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, ProgramLanguage, WorkcellModel};
use std::path::PathBuf;

/// A nozzle with a longer cone than that of the workcell has a block of this height at least, in millimetres.
const MIN_BLOCK_MM: f64 = 1.0;

/// Which cell, and what its controller is given.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Motion of a robot")]
pub struct MotionArgs {
    /// Plans the motion of an IRB 1200 over a table that tilts and turns, instead of a UR3 that holds the part
    #[arg(long, conflicts_with = "workcell")]
    pub cell8: bool,
    /// Plans the motion in the workcell of a JSON file (kinematics/docs/workcells.md; four are in examples/cells), or in an assumed one around
    /// an arm: its name (examples/cells/arms.json, such as ur10e) or a URDF
    #[arg(long, value_name = "FILE|ARM")]
    pub workcell: Option<PathBuf>,
    /// Format of the robot programs of stage motion [default: that of `controller.language` in the workcell's file, else that of the arm's maker:
    /// urscript, rapid, krl or tp; csv for other makers and for an arm of Universal Robots with a table or on a track]
    #[arg(long, value_name = "FORMAT")]
    pub program: Option<ProgramFormat>,
    /// Maximum acceleration of the joints, in rad/s2; inf for no limit [default: that of the workcell; 10 in those that come along, which
    /// MoveIt assumes where makers publish none]
    #[arg(long = "acceleration", value_name = "RAD_S2", value_parser = limit, allow_negative_numbers = true)]
    pub acceleration_rad_s2: Option<f64>,
    /// Maximum jerk of the joints, in rad/s3; inf for no limit [default: that of the workcell; 100 in those that come along, as MoveIt
    /// assumes]
    #[arg(long = "jerk", value_name = "RAD_S3", value_parser = limit, allow_negative_numbers = true)]
    pub jerk_rad_s3: Option<f64>,
    /// Maximum flow of the extruder, in mm3/s; where the plan asks for more, the nozzle slows down
    #[arg(long = "max-flow", value_name = "MM3_S", default_value_t = f64::INFINITY, value_parser = limit, allow_negative_numbers = true)]
    pub max_flow_mm3_s: f64,
    /// Maximum change of that flow, in mm3/s2
    #[arg(long = "max-flow-ramp", value_name = "MM3_S2", default_value_t = f64::INFINITY, value_parser = limit, allow_negative_numbers = true)]
    pub max_flow_ramp_mm3_s2: f64,
    /// Maximum distance of the nozzle from its path between waypoints, in millimetres [default: a quarter of the layer height or of the
    /// bead, whichever is less]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Minimum distance between arm, part and everything in the workcell, in millimetres; the nozzle touches the part where it prints
    #[arg(long, value_name = "MM", default_value_t = GrowingOptions::MARGIN_MM, value_parser = from_zero, allow_negative_numbers = true)]
    pub margin: f64,
    /// Additional thickness of the links of the arm, in millimetres, for cables and hoses [default: that of the workcell; 10 if it has
    /// none]
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_negative_numbers = true)]
    pub link_allowance: Option<f64>,
    /// Plans without the bodies of the arm: then no motion is proven free of collisions. Without this option, an arm whose bodies are
    /// unknown is refused
    #[arg(long)]
    pub no_links: bool,
    /// Maximum number of steps in a program file; a longer motion has a file of its own [default: 100000; lines of urscript-movep 10000, moves of
    /// rapid and krl 5000, of tp 2000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub program_steps: Option<u32>,
    #[command(flatten)]
    pub extruder: UrExtruderArgs,
}

/// What a program is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgramFormat {
    /// For arms of Universal Robots without a table or a track: joints 125 times a second
    Urscript,
    /// For the same: lines with blends, some hundred a minute, which stay within 0.1 mm of the path; the controller makes the joints itself
    UrscriptMovep,
    /// For ABB arms: targets on the part, with the axes of a table or a track
    Rapid,
    /// For KUKA arms (KSS 8): the same targets
    Krl,
    /// For Fanuc arms, as ASCII: the same targets
    Tp,
    /// The same steps with every digit, for other programs
    Csv,
    /// None
    None,
}

impl MotionArgs {
    /// The workcell; with another nozzle, if one was asked for.
    pub fn cell(&self, nozzle: Option<[f64; 4]>) -> Result<AnyWorkcell, Failure> {
        let mut model = match &self.workcell {
            Some(given) => workcell_model(given)?,
            None => WorkcellModel::from_json(if self.cell8 { TABLE_CELL } else { UR3_CELL }.as_bytes())?,
        };
        if let Some([tip, angle, height, block]) = nozzle {
            let shape = &mut model.nozzle;
            (shape.tip_flat_mm, shape.cone_half_angle_deg) = (tip, angle);
            (shape.cone_height_mm, shape.block_diameter_mm) = (height, block);
            shape.block_top_mm = shape.block_top_mm.max(height + MIN_BLOCK_MM);
        }
        if let Some(allowance_mm) = self.link_allowance {
            model.arm.allowance_mm = allowance_mm;
        }
        workcell_of(model, self.workcell.as_deref())
    }

    /// Refuses an arm without bodies, unless that is wanted.
    pub fn check_links(&self, cell: &AnyWorkcell) -> Result<(), Failure> {
        if self.no_links || cell.equipment().link_bodies().is_some() {
            return Ok(());
        }
        let file = self.workcell.as_ref().map_or_else(String::new, |file| format!("{}: ", file.display()));
        Err(Failure::new(format!(
            "{file}arm: the bodies of its links are not known, so no motion can be proven free of collisions; give `arm.bodies` \
             (kinematics/docs/workcells.md; \"estimated\" makes thin tubes from the lengths), or --no-links to plan without"
        )))
    }

    /// The format that is wanted: the one given, if the arm takes it, else that of its controller's language, CSV where none is written.
    ///
    /// # Errors
    /// A format that the arm does not take.
    pub fn format(&self, cell: &AnyWorkcell) -> Result<ProgramFormat, Failure> {
        let equipment = cell.equipment();
        let taken = programs::languages(equipment);
        let Some(format) = self.program else {
            let own = taken.ok().and_then(|_| equipment.language());
            return Ok(own.map_or(ProgramFormat::Csv, ProgramFormat::of_language));
        };
        let Some(language) = format.language() else { return Ok(format) };
        let refused = |why: &str| Err(Failure::of_arguments(format!("--program {}: {why}", format.name())));
        match taken {
            Ok(taken) if taken.contains(&language) => Ok(format),
            Ok(taken) => {
                let names: Vec<_> = taken.iter().map(|language| ProgramFormat::of_language(*language).name()).collect();
                let arm = equipment.catalogue_arm().map_or("the arm of this workcell", |arm| arm.title);
                refused(&format!("{arm} takes {}", names.join(", ")))
            }
            Err(why) => refused(why),
        }
    }

    /// Refuses an extruder that programs of this format do not drive.
    pub fn check_extruder(&self, format: ProgramFormat) -> Result<(), Failure> {
        let is_default = self.extruder == UrExtruderArgs::default();
        if is_default || format.language() == Some(ProgramLanguage::UrScript) {
            return Ok(());
        }
        Err(Failure::of_arguments(format!(
            "--ur-extruder does nothing with --program {}: it is for urscript and urscript-movep",
            format.name()
        )))
    }
}

impl ProgramFormat {
    /// The format of a language; of the two for URScript the stream.
    fn of_language(language: ProgramLanguage) -> Self {
        match language {
            ProgramLanguage::UrScript => Self::Urscript,
            ProgramLanguage::Rapid => Self::Rapid,
            ProgramLanguage::Krl => Self::Krl,
            ProgramLanguage::Tp => Self::Tp,
        }
    }

    /// What it is written in; none for those that no controller reads.
    fn language(self) -> Option<ProgramLanguage> {
        match self {
            Self::Urscript | Self::UrscriptMovep => Some(ProgramLanguage::UrScript),
            Self::Rapid => Some(ProgramLanguage::Rapid),
            Self::Krl => Some(ProgramLanguage::Krl),
            Self::Tp => Some(ProgramLanguage::Tp),
            Self::Csv | Self::None => None,
        }
    }

    /// As the option names it.
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}
