//! The arguments, each declared once.

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, MeshArgs, above_zero, from_zero, share};
use curvlay_layers::planar::{BaseChoice, VolumeOptions};
use std::path::PathBuf;

/// Volumes that are printed along several directions without support, after Lettori et al. (2022).
#[derive(Parser, Clone, Debug)]
#[command(version, name = "volume_decomposition")]
pub struct Args {
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
    /// Without --mesh: shape that the plain keys of the summary describe
    #[arg(long, value_name = "NAME", default_value = "curved")]
    pub shape: Shape,
    /// Height of a layer in millimetres
    #[arg(long = "layer", value_name = "MM", default_value_t = 3.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub layer_mm: f64,
    /// Minimum height of a layer, where the section changes, in millimetres [default: all layers have the height of --layer]
    #[arg(long = "least-layer", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub least_layer_mm: Option<f64>,
    /// Minimum slope of an unsupported side from level, in degrees
    #[arg(long = "angle", value_name = "DEG", default_value_t = 45.0, value_parser = acute, allow_negative_numbers = true)]
    pub angle_deg: f64,
    /// Diameter of the torch in millimetres
    #[arg(long = "torch", value_name = "MM", default_value_t = 25.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub torch_mm: f64,
    /// Distance of the torch from the bead that it deposits, in millimetres
    #[arg(long = "stand-off", value_name = "MM", default_value_t = 15.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub stand_off_mm: f64,
    /// Width of holes and features below which they are machined later, in millimetres
    #[arg(long = "feature", value_name = "MM", default_value_t = 0.0, value_parser = feature, allow_negative_numbers = true)]
    pub feature_mm: f64,
    /// First direction of growth
    #[arg(long, value_name = "NAME", default_value = "up")]
    pub base: Base,
    /// Maximum share of the layer area that the torch cannot reach because of printed material or the plate; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    pub allow_blocked: f64,
    /// Plans tool paths and motion of the torch in the audited layers of the mesh or of --shape, and writes RAPID, or URScript for an arm
    /// that runs it
    #[arg(long)]
    pub rapid: bool,
    /// Workcell of the motion, a JSON file, the name of an arm (examples/cells/arms.json) or a URDF; its
    /// nozzle becomes the torch [default: an IRB 1200 over a table that tilts and turns]
    #[arg(long, value_name = "FILE|ARM", requires = "rapid")]
    pub workcell: Option<PathBuf>,
    /// Width of a bead of the torch in millimetres [default: twice the height of a layer]
    #[arg(long = "bead", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub bead_mm: Option<f64>,
    /// Diameter of the wire in millimetres
    #[arg(long = "wire", value_name = "MM", default_value_t = 1.2, value_parser = above_zero, allow_negative_numbers = true)]
    pub wire_mm: f64,
    /// Maximum number of parts
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..=1000), allow_negative_numbers = true)]
    pub max_parts: u16,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Shapes made in code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shape {
    /// A round bar that bends to the side, after Fig. 2 of the paper.
    Curved,
    /// A flipped L.
    Ell,
    /// A T.
    Tee,
    /// A mushroom.
    Mushroom,
}

/// The first direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Base {
    /// As it stands.
    Up,
    /// The flat side or axis with the least overhang.
    Best,
}

pub fn acute(text: &str) -> Result<f64, String> {
    let degrees = above_zero(text)?;
    if (0.1..90.0).contains(&degrees) { Ok(degrees) } else { Err("must be at least 0.1 and below 90".to_owned()) }
}

pub fn feature(text: &str) -> Result<f64, String> {
    let mm = from_zero(text)?;
    if mm <= 1e4 { Ok(mm) } else { Err("must be at most 10000".to_owned()) }
}

impl Args {
    pub(super) fn options(&self) -> VolumeOptions {
        VolumeOptions {
            layer_mm: self.layer_mm,
            min_layer_mm: self.least_layer_mm.unwrap_or(self.layer_mm),
            angle: self.angle_deg.to_radians(),
            torch_diameter_mm: self.torch_mm,
            standoff_mm: self.stand_off_mm,
            min_feature_mm: self.feature_mm,
            max_parts: usize::from(self.max_parts),
            base: if self.base == Base::Best { BaseChoice::LeastOverhang } else { BaseChoice::Up },
            ..VolumeOptions::default()
        }
    }
}
