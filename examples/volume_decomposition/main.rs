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

mod args;
mod drawing;
mod outputs;
mod torch;
mod volumes;

pub use args::{Args, Base, Shape};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::Findings;
use curvlay_examples::motion::Printed;
use curvlay_examples::output::OutputFolder;
use std::process::ExitCode;
use std::time::Instant;
use volumes::Divided;

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
