//! The specimens of the work, and its arc under load.

use super::args::{Args, Stage};
use super::given::Given;
use super::judged::{judge, judge_layer, judge_motion, judge_predictions};
use super::layer::LoadedLayer;
use super::motion::Moved;
use super::planar::Planar;
use super::predict::Predictions;
use super::specimens::Specimen;
use super::tapes::Planned;
use super::{arcs, layer, motion, planar, predict, tapes, wires};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::motion::nozzle_of;
use curvlay_layers::elastic::Material;
use curvlay_toolpath::fiber::conductor::ConductorOptions;
use curvlay_toolpath::fiber::tapes::{Tape, TapeOptions};
use std::path::PathBuf;
use std::time::Duration;

/// What came of it.
pub struct Run {
    pub specimens: Vec<Planned>,
    pub planar: Planar,
    pub predictions: Predictions,
    pub layer: LoadedLayer,
    pub wires: Vec<Tape>,
    pub moved: Option<Moved>,
    pub plan_time: Duration,
    pub findings: Findings,
}

pub fn plan(args: &Args, given: &Given, bars: &Bars) -> Result<Run, Failure> {
    let Given { cell, wires, .. } = given;
    let mut findings = Findings::default();

    let nozzle = nozzle_of(cell.equipment())?;
    let nozzle = (args.stage >= Stage::Paths).then_some(&nozzle);
    let mut specimens = Vec::new();
    let mut plan_time = Duration::ZERO;
    let tape_options = TapeOptions { thickness: args.tape_thickness_mm, ..TapeOptions::default() };
    for specimen in Specimen::all() {
        let planned = tapes::plan(specimen, &args.sandwich(), &tape_options, &args.head(), nozzle, bars)?;
        plan_time += planned.plan_time;
        specimens.push(planned);
    }
    let curved = specimens.iter().find(|planned| planned.specimen.is_curved());
    let planar = curved.map(|planned| planar::plan(&planned.specimen, args.min_length_mm, nozzle, bars)).transpose()?;
    let planar = planar.unwrap_or_else(|| unreachable!("one of them is curved"));
    let [dumbbell, bar, arc] = &specimens[..] else { unreachable!("there are three") };
    let bearing = predict::bearing(&dumbbell.specimen, &dumbbell.schedule)?;
    let matrix_gpa = predict::matrix_gpa(&bar.specimen, &bar.schedule)?;
    let matrix = Material { young_mpa: 1e3 * matrix_gpa, ..Material::default() };
    let tape = predict::tape_law(&matrix, args.tape_thickness_mm, bearing);
    let arcs = arcs::run(arc, &planar, matrix_gpa, &tape, bars)?;
    let tested = [
        (dumbbell.specimen, &dumbbell.schedule[..]),
        (bar.specimen, &bar.schedule[..]),
        (arc.specimen, &arc.schedule[..]),
    ];
    let predictions = predict::predict(&tested, arcs)?;
    let layer = layer::arc(&arc.specimen, &args.tape_options(), args.smoothing_mm(), bars)?;
    plan_time += layer.plan_time;
    let wire_options = ConductorOptions { thickness: args.tape_thickness_mm, ..ConductorOptions::default() };
    let on_layer = |path: &PathBuf| -> Result<Vec<Tape>, Failure> {
        let numbered = wires.iter().enumerate();
        numbered.map(|(number, wire)| wires::on_layer(path, number, wire, &layer.surface, &wire_options)).collect()
    };
    let wires = args.wires.as_ref().map_or(Ok(Vec::new()), on_layer)?;
    let moved = (args.stage == Stage::Motion).then(|| motion::plan(arc, cell, &args.head(), bars)).transpose()?;
    for planned in &specimens {
        judge(planned, &tape_options, &mut findings);
    }
    let amount = format!("{:.1} mm of {} mm", planar.longest_tape_mm, arc.specimen.tape_mm[0]);
    findings.add(Severity::Note, "the longest tape for which a planar layer of the arc has room", amount, "");
    judge_layer(&layer, &mut findings);
    moved.iter().for_each(|moved| judge_motion(moved, &mut findings));
    judge_predictions(&predictions, &mut findings);
    Ok(Run { specimens, planar, predictions, layer, wires, moved, plan_time, findings })
}
