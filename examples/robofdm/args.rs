//! The arguments, each declared once.

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, MeshArgs, above_zero, from_zero, share};
use curvlay_examples::nalgebra::Vector3;
use curvlay_layers::planar::robofdm::{SeamStrength, TuningOptions};
use std::path::PathBuf;

/// A part printed along several directions without support by a robot, after RoboFDM (2017).
#[derive(Parser, Clone, Debug)]
#[command(version, name = "robofdm")]
pub struct Args {
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
    /// The last stage to run
    #[arg(long, value_name = "NAME", default_value = "motion")]
    pub stage: Stage,
    /// Levels of thickness by which the part is segmented [default: chosen by a criterion]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub parts: Option<u32>,
    /// The segment that is printed first, by its number in segments.png, from 0 [default: the best]
    #[arg(long, value_name = "N")]
    pub root: Option<u32>,
    /// First direction of growth
    #[arg(long, value_name = "NAME", default_value = "up")]
    pub base: Base,
    /// Method that divides the part
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub method: Method,
    /// Height of the pedestal between the plate and the first part, in millimetres: a prism below its first layer that is cut off
    /// afterwards and gives room to a tilted head; 0 for none [default: the lowest that makes room where more than --allow-risky is left
    /// without one, else none]
    #[arg(long = "pedestal", value_name = "MM", value_parser = from_zero, allow_negative_numbers = true)]
    pub pedestal_mm: Option<f64>,
    /// How collisions of the head are avoided
    #[arg(long, value_name = "NAME", default_value = "head")]
    pub avoid: Avoid,
    /// Number of partial results that the beam search keeps
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=1000), allow_negative_numbers = true)]
    pub width: u16,
    /// Maximum overhang of a side without support, from upright, in degrees
    #[arg(long = "angle", value_name = "DEG", default_value_t = 45.0, value_parser = acute, allow_negative_numbers = true)]
    pub angle_deg: f64,
    /// Maximum number of parts
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=1000), allow_negative_numbers = true)]
    pub max_parts: u16,
    /// Minimum share of the volume that is cut off as a part
    #[arg(long = "min-part", value_name = "SHARE", default_value_t = 0.005, value_parser = share, allow_negative_numbers = true)]
    pub min_part_share: f64,
    /// Maximum share of the risky area, the sides that overhang, that may be left; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    pub allow_risky: f64,
    /// Maximum unsupported share of a layer, or of a mean layer of its part if that is larger; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    pub allow_unsupported: f64,
    /// Number of trials for each plane of the sequence
    #[arg(long, value_name = "N", default_value_t = TuningOptions::default().perturbations, value_parser = clap::value_parser!(u32).range(..=1000), allow_negative_numbers = true, help_heading = TUNING)]
    pub perturbations: u32,
    /// Maximum shift of a plane of the sequence, as a share of the diagonal of the part's box
    #[arg(long = "max-offset", value_name = "SHARE", default_value_t = TuningOptions::default().max_offset, value_parser = share, allow_negative_numbers = true, help_heading = TUNING)]
    pub max_offset_share: f64,
    /// Maximum turn of a plane of the sequence, in degrees
    #[arg(long = "max-turn", value_name = "DEG", default_value_t = 5.0, value_parser = acute, allow_negative_numbers = true, help_heading = TUNING)]
    pub max_turn_deg: f64,
    /// Maximum growth of the section of such a plane, as a factor
    #[arg(long, value_name = "FACTOR", default_value_t = TuningOptions::default().max_section, value_parser = from_one, allow_negative_numbers = true, help_heading = TUNING)]
    pub max_section: f64,
    /// Number of parts, the riskiest first, that are considered for each cut
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=1000), allow_negative_numbers = true, help_heading = TUNING)]
    pub candidates: u16,
    /// Number of normals of cuts to try, over the upper half of the sphere
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=10_000), allow_negative_numbers = true, help_heading = TUNING)]
    pub normals: u16,
    /// Distance between trial cuts, in millimetres
    #[arg(long = "spacing", value_name = "MM", default_value_t = TuningOptions::default().spacing, value_parser = above_zero, allow_negative_numbers = true, help_heading = TUNING)]
    pub spacing_mm: f64,
    /// How often that distance is halved once no cut is worthwhile; 0 in the paper
    #[arg(long, value_name = "N", default_value_t = TuningOptions::default().halvings, value_parser = clap::value_parser!(u32).range(..=8), allow_negative_numbers = true, help_heading = TUNING)]
    pub halvings: u32,
    /// Forbids base sections that intersect: constraint I of the paper to the letter
    #[arg(long, help_heading = TUNING)]
    pub keep_sections_apart: bool,
    /// Height of a layer in millimetres
    #[arg(long, value_name = "MM", default_value_t = 0.8, value_parser = above_zero, allow_negative_numbers = true)]
    pub layer_height: f64,
    /// Width of a bead in millimetres [default: one and a half times the height of a layer]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub bead: Option<f64>,
    /// How layers are filled
    #[arg(long, value_name = "NAME", default_value = "spiral")]
    pub pattern: PatternName,
    /// Workcell of the motion, a JSON file (kinematics/docs/workcells.md), or an assumed one around an arm: its name (examples/cells/arms.json) or a URDF [default: a
    /// UR3 that holds the part under a nozzle]
    #[arg(long, value_name = "FILE|ARM")]
    pub workcell: Option<PathBuf>,
    /// Places the nozzle of a workcell that holds the part where the arm reaches most
    #[arg(long)]
    pub place_nozzle: bool,
    /// Edge of the cells that represent the part in collision checks, in millimetres [default: some 20,000 cells]
    #[arg(long = "cell", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub cell_mm: Option<f64>,
    /// Direction of the load on the finished part, x,y,z: the summary has the angle of each seam to it
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub load: Option<Vector3<f64>>,
    /// Number of filaments that the parts use in turn
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000), allow_negative_numbers = true)]
    pub filaments: u32,
    /// Time to change a filament, in seconds
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub change_s: f64,
    /// Density of the material in g/cm3
    #[arg(long = "density", value_name = "G_CM3", default_value_t = SeamStrength::default().density_g_cm3, value_parser = from_zero, allow_negative_numbers = true, help_heading = STRENGTH)]
    pub density_g_cm3: f64,
    /// Force of the nozzle on the part in newtons, from any side, at the farthest place
    #[arg(long = "print-force", value_name = "N", default_value_t = SeamStrength::default().print_force_n, value_parser = from_zero, allow_negative_numbers = true, help_heading = STRENGTH)]
    pub print_force_n: f64,
    /// Strength of the bond between parts in MPa
    #[arg(long = "bond", value_name = "MPA", default_value_t = SeamStrength::default().bond_mpa, value_parser = above_zero, allow_negative_numbers = true, help_heading = STRENGTH)]
    pub bond_mpa: f64,
    /// Strength of the bond to the plate in MPa
    #[arg(long = "plate-bond", value_name = "MPA", default_value_t = SeamStrength::default().platform_bond_mpa, value_parser = above_zero, allow_negative_numbers = true, help_heading = STRENGTH)]
    pub plate_bond_mpa: f64,
    /// Safety factor of the stress in a seam
    #[arg(long, value_name = "FACTOR", default_value_t = SeamStrength::default().safety, value_parser = from_one, allow_negative_numbers = true, help_heading = STRENGTH)]
    pub safety: f64,
    /// Accepts seams of any size, as in the paper
    #[arg(long, conflicts_with_all = ["density_g_cm3", "print_force_n", "bond_mpa", "plate_bond_mpa", "safety"], help_heading = STRENGTH)]
    pub any_seam: bool,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Heading of the strength of seams.
pub const STRENGTH: &str = "Strength of seams";

/// Heading of `--help`; defaults are the paper's, but for `--halvings` and constraint I.
pub const TUNING: &str = "Tuning of planes";

/// How far a run goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// The parts.
    Parts,
    /// Layers and tool paths as well.
    Paths,
    /// All of it, to robot programs.
    Motion,
}

/// The first direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Base {
    /// As it stands in the file.
    Up,
    /// The direction of the root with the least risky area.
    Best,
}

/// How the parts are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// `robofdm`, and where it leaves more than `--allow-risky` the beam search as well; of both what leaves less.
    Auto,
    /// Segments by skeleton and thickness, their sequence, planes that are tuned.
    Robofdm,
    /// A beam search over cutting planes, after Wu et al. (2020), from these segments and from the solid in one piece.
    Beam,
}

/// What keeps the head out of what stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Avoid {
    /// Base planes look up: constraint II of the dissertation.
    Planes,
    /// The head of the workcell, as cone and block, meets nothing that stands.
    Head,
}

/// How layers are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PatternName {
    /// One curve for each region, from its outline inward.
    Spiral,
    /// Closed curves, one inside the other.
    Contours,
    /// Rows, to and fro.
    Zigzag,
}

pub fn acute(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|deg| if deg < 90.0 { Ok(deg) } else { Err("must be below 90".to_owned()) })
}

pub fn from_one(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|factor| if factor >= 1.0 { Ok(factor) } else { Err("must be 1 or more".to_owned()) })
}

pub fn direction(text: &str) -> Result<Vector3<f64>, String> {
    let numbers: Vec<f64> = text.split(',').map(|number| number.trim().parse().unwrap_or(f64::NAN)).collect();
    match numbers[..] {
        [x, y, z] if Vector3::new(x, y, z).norm() > 0.0 && Vector3::new(x, y, z).norm().is_finite() => {
            Ok(Vector3::new(x, y, z))
        }
        _ => Err("must be three numbers, not all 0".to_owned()),
    }
}

impl Args {
    /// What seams must hold.
    pub fn strength(&self) -> Option<SeamStrength> {
        let strength = SeamStrength {
            density_g_cm3: self.density_g_cm3,
            print_force_n: self.print_force_n,
            bond_mpa: self.bond_mpa,
            platform_bond_mpa: self.plate_bond_mpa,
            safety: self.safety,
        };
        (!self.any_seam).then_some(strength)
    }

    pub(super) fn bead_mm(&self) -> f64 {
        self.bead.unwrap_or(1.5 * self.layer_height)
    }
}
