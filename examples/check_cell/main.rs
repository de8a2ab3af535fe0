//! What a pendant should show: tool position and joint angles of a workcell at three postures, before anything moves.
//!
//! ```sh
//! cargo run --release --example check_cell -- examples/cells/ur10.json   # or an arm: ur10e, "KR 6 R900-2"; or arm.urdf
//! cargo run --release --example check_cell -- ur10e --write my_cell.json # the assumed workcell as a file to put your numbers in
//! ```
//! Jog the arm to the joint angles, with the tool frame that is printed, and compare: a wrong length, sign or frame shows by centimetres. The numbers are
//! in the maker's frames and the maker's notation: docs/guide/05-robot.md.

mod postures;
mod shown;

use clap::Parser;
use curvlay_examples::args::{self, Failure, Outcome};
use curvlay_examples::input::{self, Inputs};
use curvlay_examples::motion::{workcell_model, workcell_of};
use curvlay_kinematics::ArmDeviation;
use curvlay_kinematics::workcell::{AnyWorkcell, CalibrationModel};
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Prints tool position and joint angles of a workcell at three postures, to compare with the pendant")]
struct Args {
    /// A workcell file (kinematics/docs/workcells.md), the name of an arm (examples/cells/arms.json), or a URDF
    #[arg(value_name = "FILE|ARM")]
    workcell: PathBuf,
    /// calibration.yaml of Universal Robots' ROS driver (ur_calibration): the arm as built; --write puts it into the file
    #[arg(long, value_name = "FILE")]
    ur_calibration: Option<PathBuf>,
    /// Writes the workcell, so that an assumed one can be changed
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

fn main() -> ExitCode {
    args::run(check_cell)
}

fn check_cell() -> Result<Outcome, Failure> {
    let args = Args::parse();
    let mut model = workcell_model(&args.workcell)?;
    let mut cell = workcell_of(model.clone(), Some(&args.workcell))?;
    if let Some(path) = &args.ur_calibration {
        let text = input::read_text(path, input::MAX_SETTINGS_BYTES)?;
        let deviation = ArmDeviation::from_ur_calibration(&text, cell.equipment().arm_model());
        let deviation = deviation.map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        model.arm.calibration = Some(CalibrationModel::from(&deviation));
        cell = workcell_of(model.clone(), Some(&args.workcell))?;
    }
    let found = match &cell {
        AnyWorkcell::Six(cell) => postures::of(cell),
        AnyWorkcell::Seven(cell) => postures::of(cell),
        AnyWorkcell::Eight(cell) => postures::of(cell),
    };
    shown::print(&cell, &found);
    if let Some(path) = &args.write {
        let given = [Some(args.workcell.as_path()), args.ur_calibration.as_deref()];
        let file = Inputs::new(given.into_iter().flatten()).create(path)?;
        model.write_json(BufWriter::new(file))?;
        println!("\nwrote {}", path.display());
    }
    Ok(Outcome::of(found.into_iter().filter_map(|posture| posture.problem).collect()))
}
