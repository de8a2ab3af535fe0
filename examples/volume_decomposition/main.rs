//! A part divided into volumes that a robot prints one after the other, each in flat layers along its own direction and without
//! support.
//!
//! J. Lettori, R. Raffaelli, M. Borsato, M. Pellicciari and M. Peruzzini, "An approach for volume decomposition in robot-based
//! additive manufacturing", CAD'22, 2022.
//! ```sh
//! cargo run --release --example volume_decomposition
//! cargo run --release --example volume_decomposition -- part.stl --layer 2 --torch 20
//! ```
//! Without `--mesh` four shapes made in code are divided: the paper's curved part, an L, a T and a mushroom. `--help` lists the options.

mod drawing;
mod outputs;
mod torch;
mod volumes;

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, Failure, MeshArgs, Outcome, above_zero, from_zero, run_with_args, share};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::Findings;
use curvlay_examples::motion::Printed;
use curvlay_examples::output::OutputFolder;
use curvlay_layers::planar::{BaseChoice, VolumeOptions};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use volumes::Divided;

/// Volumes that are printed along several directions without support, after Lettori et al. (2022).
#[derive(Parser, Clone, Debug)]
#[command(version, name = "volume_decomposition")]
pub struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    /// Without --mesh: the shape that the plain keys of the summary are about
    #[arg(long, value_name = "NAME", default_value = "curved")]
    shape: Shape,
    /// Height of a layer in millimetres
    #[arg(long = "layer", value_name = "MM", default_value_t = 3.0, value_parser = above_zero, allow_negative_numbers = true)]
    layer_mm: f64,
    /// Least height of a layer in millimetres, where the section changes [default: all layers are --layer high]
    #[arg(long = "least-layer", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    least_layer_mm: Option<f64>,
    /// Slope of a side over the level, in degrees, below which it needs support
    #[arg(long = "angle", value_name = "DEG", default_value_t = 45.0, value_parser = acute, allow_negative_numbers = true)]
    angle_deg: f64,
    /// Diameter of the torch in millimetres
    #[arg(long = "torch", value_name = "MM", default_value_t = 25.0, value_parser = above_zero, allow_negative_numbers = true)]
    torch_mm: f64,
    /// Distance of the torch from what it lays in millimetres
    #[arg(long = "stand-off", value_name = "MM", default_value_t = 15.0, value_parser = above_zero, allow_negative_numbers = true)]
    stand_off_mm: f64,
    /// Holes and features narrower than this are machined later, in millimetres
    #[arg(long = "feature", value_name = "MM", default_value_t = 0.0, value_parser = feature, allow_negative_numbers = true)]
    feature_mm: f64,
    /// Which way the part is printed first
    #[arg(long, value_name = "NAME", default_value = "up")]
    base: Base,
    /// Share of the layer area that the torch may not reach for what is printed before, or for the plate: with more the exit status is 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    allow_blocked: f64,
    /// Plans tool paths and motion of the torch in the audited layers, and writes RAPID, or URScript for an arm that takes it: of the mesh, or
    /// of --shape
    #[arg(long)]
    rapid: bool,
    /// Workcell of the motion, a JSON file; its nozzle becomes the torch [default: an IRB 1200 over a table that tilts and turns]
    #[arg(long, value_name = "FILE", requires = "rapid")]
    workcell: Option<PathBuf>,
    /// Width of a bead of the torch in millimetres [default: twice the height of a layer]
    #[arg(long = "bead", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    bead_mm: Option<f64>,
    /// Diameter of the wire in millimetres
    #[arg(long = "wire", value_name = "MM", default_value_t = 1.2, value_parser = above_zero, allow_negative_numbers = true)]
    wire_mm: f64,
    /// The most parts
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..=1000), allow_negative_numbers = true)]
    max_parts: u16,
    #[command(flatten)]
    common: Common,
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

fn acute(text: &str) -> Result<f64, String> {
    let degrees = above_zero(text)?;
    if (0.1..90.0).contains(&degrees) { Ok(degrees) } else { Err("must be at least 0.1 and below 90".to_owned()) }
}

fn feature(text: &str) -> Result<f64, String> {
    let mm = from_zero(text)?;
    if mm <= 1e4 { Ok(mm) } else { Err("must be at most 10000".to_owned()) }
}

impl Args {
    fn options(&self) -> VolumeOptions {
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

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder(
            "volume_decomposition",
            [args.mesh.path(), args.workcell.as_deref()],
            outputs::is_ours,
        )?;
        let ((divided, _), outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&divided).print()?;
        Ok(outcome)
    })
}

/// What a run makes: the volumes, and their print with --rapid.
type Made = (Vec<Divided>, Option<Printed>);

/// Divides the part, or all shapes, audits the result and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Made, Outcome), Failure> {
    let start = Instant::now();
    // Read before the work: a workcell that is not there is no news for the end of it.
    let model = args.rapid.then(|| torch::model(args)).transpose()?;
    let divided = volumes::divide(args, bars)?;
    bars.finish();
    let printed = model.map(|model| torch::print(args, &divided, model, bars)).transpose()?;
    bars.finish();
    let mut findings = Findings::default();
    let of_meshes = divided.iter().flat_map(|divided| divided.of_mesh.iter());
    of_meshes.for_each(|finding| findings.push(finding.clone()));
    divided.iter().for_each(|divided| divided.find(args, &mut findings));
    if let Some(printed) = &printed {
        printed.find(&mut findings);
    }
    outputs::write(args, (&divided, printed.as_ref()), &findings, folder, start)?;
    findings.say();
    Ok(((divided, printed), findings.outcome()))
}
