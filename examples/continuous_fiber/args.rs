//! The arguments, each declared once, and as the parts of a run take them.

use super::motion;
use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, Failure, MeshArgs, above_zero, from_zero, share};
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_toolpath::fiber::head::TapeHead;
use curvlay_toolpath::fiber::sandwich::SandwichOptions;
use curvlay_toolpath::fiber::tapes::TapeOptions;
use std::path::{Path, PathBuf};

/// Tapes of continuous fibre between layers: specimens of Dai (2020), chapter 5, and a layer of a part under load.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "continuous_fiber")]
pub struct Args {
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
    /// The last stage to run
    #[arg(long, value_name = "NAME", default_value = "motion")]
    pub stage: Stage,
    /// Layers of the part that carry tapes, from 1, such as 4,8,12; not the last layer, which nothing would cover
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true, conflicts_with = "every", help_heading = LOAD)]
    pub layers: Vec<u32>,
    /// Tapes on every n-th layer instead: n, 2n, 3n, ...
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true, help_heading = LOAD)]
    pub every: u32,
    /// Height of the layers in millimetres [default: the edge of a cell]
    #[arg(long = "layer-height", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub layer_height_mm: Option<f64>,
    /// Width of a bead in millimetres [default: 1 for each 0.6 of layer height]
    #[arg(long = "bead", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub bead_mm: Option<f64>,
    /// Maximum unsupported share, and maximum uncovered share, of the tapes' area; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share, allow_negative_numbers = true, help_heading = LOAD)]
    pub allow_bare: f64,
    /// Edge of the cells of the part and of the solver in millimetres [default: some 60,000 cells]
    #[arg(long = "cell", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub cell_mm: Option<f64>,
    /// Stresses instead of the solver's: CSV (x, y, z in mm of the file of the part, six components), VTK (.vtk) or results of CalculiX (.frd)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["supports", "loads", "young_gpa", "bearing", "bond_mpa"], help_heading = LOAD)]
    pub stress: Option<PathBuf>,
    /// Maximum distance of a sample of that file from the layer, in millimetres
    #[arg(long = "reach", value_name = "MM", default_value_t = 10.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub reach_mm: f64,
    /// Box that is fixed, by its lower and its upper corner in mm of the file of the part; inf for no end. May be given more than once
    #[arg(long = "support", value_name = "X,Y,Z,X,Y,Z", value_parser = boxed, allow_hyphen_values = true, help_heading = LOAD)]
    pub supports: Vec<Boxed>,
    /// Box whose outer faces are loaded, and the force in newtons. May be given more than once. Without --support and --load the base is
    /// fixed and the top is pushed along x
    #[arg(long = "load", value_name = "X,Y,Z,X,Y,Z:FX,FY,FZ", value_parser = pull, allow_hyphen_values = true, help_heading = LOAD)]
    pub loads: Vec<Pull>,
    /// Young's modulus of the part in GPa [default: 3.5, PLA]; it scales displacements, not stresses
    #[arg(long = "young", value_name = "GPA", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub young_gpa: Option<f64>,
    /// Share of the tapes' fibre that bears load [default: as in the tensile test of the dissertation, with tow that is ironed on dry]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = LOAD)]
    pub bearing: Option<f64>,
    /// Strength of the bond between layers, and between tape and thermoplastic, in MPa, in peel and in shear [default: the one with which
    /// the planar arc of the dissertation fails where it did]
    #[arg(long = "bond", value_name = "MPA", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    pub bond_mpa: Option<f64>,
    /// Writes growth.csv, directions of growth across the largest stresses for `curved_layers --directions`, and reports how much closer
    /// layers follow them
    #[arg(long, conflicts_with = "stress", help_heading = LOAD)]
    pub follow_load: bool,
    /// File of wires on the loaded layer: a point x,y,z a line in mm of the file of the part, an empty line between two wires
    #[arg(long = "wire", value_name = "FILE", help_heading = LOAD)]
    pub wires: Option<PathBuf>,
    /// Width of the tapes on the loaded layer in millimetres
    #[arg(long = "tape-width", value_name = "MM", default_value_t = 5.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub tape_width_mm: f64,
    /// Distance of their centre lines in millimetres [default: their width]
    #[arg(long = "tape-spacing", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub tape_spacing_mm: Option<f64>,
    /// Thickness of all tapes in millimetres
    #[arg(long = "tape-thickness", value_name = "MM", default_value_t = 0.08, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub tape_thickness_mm: f64,
    /// Minimum steering radius in millimetres
    #[arg(long = "min-radius", value_name = "MM", default_value_t = 50.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub min_radius_mm: f64,
    /// Minimum length of a tape, and length of tape from the blade to the roller, in millimetres
    #[arg(long = "min-length", value_name = "MM", default_value_t = 20.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub min_length_mm: f64,
    /// Maximum share of its width by which a tape overlaps others
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share, allow_negative_numbers = true, help_heading = TAPES)]
    pub max_overlap: f64,
    /// Length over which directions are smoothed, in millimetres [default: twice the width of the tapes]
    #[arg(long = "smoothing", value_name = "MM", value_parser = from_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub smoothing_mm: Option<f64>,
    /// Raises the layers above each layer of tape by its thickness; the dissertation does not
    #[arg(long, help_heading = TAPES)]
    pub compensate: bool,
    /// Force of the roller in newtons
    #[arg(long = "press", value_name = "N", default_value_t = 20.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    pub press_n: f64,
    /// Temperature of the roller in degrees Celsius
    #[arg(long = "heat", value_name = "CELSIUS", default_value_t = 210.0, value_parser = curvlay_examples::args::celsius, allow_negative_numbers = true, help_heading = TAPES)]
    pub celsius: f64,
    /// Workcell that prints the part, or lays the tapes of the arc, a JSON file with six axes, the name of an arm
    /// (examples/cells/arms.json) or a URDF [default: a UR3 that holds the mould under a roller]
    #[arg(long, value_name = "FILE|ARM")]
    pub workcell: Option<PathBuf>,
    #[command(flatten)]
    pub(super) common: Common,
}

pub const LOAD: &str = "Layer and load";

pub const TAPES: &str = "Tapes";

/// How far a run goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// Tapes, and what stiffness they give.
    Tapes,
    /// The layers of thermoplastic as well.
    Paths,
    /// The motion of the robot as well: of the whole part, or along the tapes of the arc.
    Motion,
}

/// A box: its lower and its upper corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boxed(pub [[f64; 3]; 2]);

/// A force on a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    pub(super) region: Boxed,
    pub(super) newtons: [f64; 3],
}

pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let all: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    all?.try_into().ok()
}

pub fn boxed(text: &str) -> Result<Boxed, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers(text).ok_or("must be six numbers")?;
    let ordered = [(x0, x1), (y0, y1), (z0, z1)].iter().all(|(low, high)| low <= high);
    if ordered {
        Ok(Boxed([[x0, y0, z0], [x1, y1, z1]]))
    } else {
        Err("the second corner must be the upper one".to_owned())
    }
}

pub fn pull(text: &str) -> Result<Pull, String> {
    let (region, force) = text.split_once(':').ok_or("must be six numbers, a colon and three numbers")?;
    let newtons: [f64; 3] = numbers(force).ok_or("the force must be three numbers")?;
    if newtons.iter().all(|n| n.is_finite()) && newtons.iter().any(|n| *n != 0.0) {
        return Ok(Pull { region: boxed(region)?, newtons });
    }
    Err("the force must be finite and not zero".to_owned())
}

impl Args {
    /// Tapes of the loaded layer.
    pub fn tape_options(&self) -> TapeOptions {
        TapeOptions {
            width: self.tape_width_mm,
            thickness: self.tape_thickness_mm,
            spacing: self.tape_spacing_mm.unwrap_or(self.tape_width_mm),
            min_radius: self.min_radius_mm,
            min_length: self.min_length_mm,
            max_overlap: self.max_overlap,
            ..TapeOptions::default()
        }
    }

    pub(super) fn smoothing_mm(&self) -> f64 {
        self.smoothing_mm.unwrap_or(2.0 * self.tape_width_mm)
    }

    pub(super) fn head(&self) -> TapeHead {
        TapeHead { blade: self.min_length_mm, force_n: self.press_n, celsius: self.celsius, ..TapeHead::default() }
    }

    pub(super) fn sandwich(&self) -> SandwichOptions {
        let offset = if self.compensate { self.tape_thickness_mm } else { 0.0 };
        SandwichOptions { offset, ..SandwichOptions::default() }
    }

    /// Whether the arm and the roller of a workcell can lay these tapes.
    pub fn check_roller(&self, cell: &AnyWorkcell) -> Result<(), Failure> {
        motion::six_axes(cell)?;
        let (tape, roller) = (self.tape_width_mm, cell.equipment().model().roller.unwrap_or_default().width_mm);
        if tape > roller {
            let message = format!(
                "--tape-width: tapes of {tape} mm under a roller of {roller} mm: take {roller} or less, or give a wider `roller.width_mm` in the workcell"
            );
            return Err(Failure::of_arguments(message));
        }
        Ok(())
    }

    /// The files that it reads.
    pub fn files(&self) -> [Option<&Path>; 4] {
        [self.mesh.path(), self.stress.as_deref(), self.wires.as_deref(), self.workcell.as_deref()]
    }

    /// Options of a layer of a part without a part.
    pub fn check(&self) -> Result<(), Failure> {
        let of_part = [
            ("--layers", !self.layers.is_empty()),
            ("--layer-height", self.layer_height_mm.is_some()),
            ("--bead", self.bead_mm.is_some()),
            ("--bearing", self.bearing.is_some()),
            ("--bond", self.bond_mpa.is_some()),
            ("--cell", self.cell_mm.is_some()),
            ("--stress", self.stress.is_some()),
            ("--support", !self.supports.is_empty()),
            ("--load", !self.loads.is_empty()),
            ("--young", self.young_gpa.is_some()),
            ("--follow-load", self.follow_load),
        ];
        match of_part.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) if self.mesh.path().is_none() => {
                Err(Failure::of_arguments(format!("{option} is for a part: give one with --mesh")))
            }
            _ => Ok(()),
        }
    }
}
