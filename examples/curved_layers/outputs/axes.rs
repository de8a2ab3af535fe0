//! The program of a five-axis machine: `toolpath-axes.gcode`, its figures and its findings.

use crate::args::{Args, failure};
use crate::machine::MachineRun;
use curvlay_examples::args::Failure;
use curvlay_examples::axis_program::{AxisProgramError, write_axis_program};
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::machine::{AxisPlanOptions, AxisPlanSummary};
use curvlay_toolpath::gcode::flavour::{FlavourWritten, ProgramOptions};
use std::io;

pub const FILE: &str = "toolpath-axes.gcode";

/// Share of its tilt that a polar machine may leave out without a warning.
const NOTABLE_TILT: f64 = 0.01;

/// Slowdown of a motion beyond which it is reported.
const NOTABLE_SLOWDOWN: f64 = 2.0;

/// What has been written.
pub struct AxisProgram {
    machine: String,
    flavour: String,
    written: FlavourWritten,
    plan: AxisPlanSummary,
}

/// Refuses a part that the machine does not reach, before anything of the stage is written.
pub fn check(args: &Args, run: &MachineRun) -> Result<(), Failure> {
    let Some((path, printer)) = args.machine.as_ref().zip(args.printer.as_ref()) else { return Ok(()) };
    match printer.out_of_reach(run.moves()) {
        Some(why) => Err(failure(format!("{}: {why}", path.display()))),
        None => Ok(()),
    }
}

/// Writes the program.
pub fn write(
    run: &MachineRun,
    FiveAxisPrinter { machine, flavour }: &FiveAxisPrinter,
    options: &ProgramOptions,
    folder: &OutputFolder,
) -> Result<AxisProgram, Failure> {
    let mut done: Option<Result<_, AxisProgramError>> = None;
    let filled = folder.write_with(FILE, |out| {
        let result = write_axis_program(machine, run.moves(), flavour, AxisPlanOptions::default(), options, out);
        let is_whole = result.is_ok();
        done = Some(result);
        // The error itself is reported below.
        if is_whole { Ok(()) } else { Err(io::ErrorKind::InvalidData.into()) }
    });
    match done {
        Some(Ok((written, plan))) => {
            filled?;
            Ok(AxisProgram { machine: machine.model().name.clone(), flavour: flavour.name.clone(), written, plan })
        }
        Some(Err(error)) => Err(failure(format!("{FILE}: {error}"))),
        None => filled.map_err(Failure::from).and_then(|()| Err(failure(format!("{FILE}: nothing was written")))),
    }
}

/// What a user of the machine should know of its program.
pub fn find(AxisProgram { plan, written, .. }: &AxisProgram, findings: &mut Findings) {
    if plan.bead_rewinds > 0 {
        let what = "beads are cut where an axis turns back: the nozzle lifts off and comes back to the same place";
        let finding = findings.explain(Severity::Note, what, counted(plan.bead_rewinds, "time"), FILE);
        finding.cause("the range of an axis ends there, or the nozzle passes the pole of the machine");
    }
    if plan.unfollowed_tilt > NOTABLE_TILT {
        let what = "the machine cannot follow the tilt of the nozzle out of the plane of its linear axes";
        let amount = format!("{} of the tilt is left out", percent(plan.unfollowed_tilt));
        findings
            .explain(Severity::Warning, what, amount, FILE)
            .cause("it has two linear axes: one direction follows from the place");
    }
    if plan.worst_slowdown > NOTABLE_SLOWDOWN {
        let what = "an axis of the machine is slower than the feed";
        let amount = format!("{}, up to {:.1} times slower", counted(plan.slowed, "motion"), plan.worst_slowdown);
        findings.add(Severity::Note, what, amount, FILE);
    }
    if written.capped > 0 {
        let what = "moves are slower than planned: their feed is above what the controller takes";
        let finding = findings.explain(Severity::Warning, what, counted(written.capped, "move"), FILE);
        finding.cause("`feed.max` of the flavour is lower; bead and motion keep in step");
        finding.try_to("a lower --max-feed or --travel-feed, or a greater `feed.max` if the controller takes it");
    }
    if written.untimed > 0 {
        let what = "the flavour cannot say how long turns at a standing tip take";
        findings.add(Severity::Note, what, counted(written.untimed, "motion"), FILE);
    }
}

pub fn row(AxisProgram { machine, flavour, written, plan }: &AxisProgram, table: &mut Table) {
    table.row([
        "program of the machine".to_owned(),
        format!(
            "{machine}, {flavour}: {}, {:.1} min; {} within beads",
            counted(written.written.lines, "line"),
            plan.seconds / 60.0,
            counted(plan.bead_rewinds, "rewind")
        ),
    ]);
}

pub fn summary(
    AxisProgram { machine, flavour, written, plan }: &AxisProgram,
    summary: &mut Summary,
) -> Result<(), Failure> {
    summary
        .set("five_axis_machine", machine.clone())?
        .set("five_axis_flavour", flavour.clone())?
        .set("five_axis_lines", written.written.lines)?
        .set("five_axis_bytes", written.written.bytes)?
        .set("five_axis_time_s", plan.seconds)?
        .set("five_axis_capped_moves", written.capped)?
        .set("five_axis_filament_mm", plan.filament_mm)?
        .set("five_axis_bead_rewinds", plan.bead_rewinds)?
        .set("five_axis_travel_rewinds", plan.travel_rewinds)?
        .set("five_axis_pole_passes", plan.pole_passes)?
        .set("five_axis_slowed", plan.slowed)?
        .set("five_axis_worst_slowdown", plan.worst_slowdown)?
        .set("five_axis_tip_error_mm", plan.max_tip_error_mm)?
        .set("five_axis_unfollowed_tilt_share", plan.unfollowed_tilt)?;
    Ok(())
}
