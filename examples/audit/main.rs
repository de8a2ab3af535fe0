//! Scores what any program makes, so that publications can quote it: orders of cells, G-code, waypoints, layer meshes. What the nozzle cannot reach, what lies on nothing or in
//! the air, what it gouges, what is missing or laid twice.
//!
//! ```sh
//! cargo run --release --example audit -- theirs.csv --mesh part.stl
//! ```
//! `docs/formats/audit.md` describes inputs, checks and results, `--help` lists the options.

mod args;
mod beads;
mod cells;
mod drawn_cells;
mod figures;
mod judged;
mod orders;
mod outputs;
mod part;
mod programs;
mod reach;
mod sheets;
mod slip;
mod source;

pub use args::Args;
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::Findings;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::table::Table;
use figures::Audited;
use nalgebra::{Point3, Vector3};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let inputs = args.more.iter().map(|path| Some(path.as_path()));
        let inputs = inputs.chain([Some(args.input.as_path()), args.part.mesh.as_deref()]);
        let folder = args.common.folder("audit", inputs, outputs::is_ours)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(args.common.threads).build()?;
        let (tables, outcome) = pool.install(|| work(&args, &Bars::new(args.common.quiet), &folder))?;
        Table::print_all(&tables)?;
        Ok(outcome)
    })
}

/// Audits an input and writes the files.
///
/// # Errors
/// A line with what cannot be used.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Vec<Table>, Outcome), Failure> {
    let start = Instant::now();
    let mut findings = Findings::default();
    let source = source::of(args)?;
    let args = &source.args;
    let part = part_of(args, &mut findings)?;
    let audited = audited(&source, part, bars)?;
    bars.finish();
    folder.clear(outputs::is_ours)?;
    judged::find(args, &audited, &mut findings);
    findings.say();
    let outcome = findings.outcome();
    let run = outputs::Run { args, audited: &audited, findings: &findings };
    Ok((outputs::write(&run, folder, start.elapsed())?, outcome))
}

/// The part to compare with, standing on z = 0.
fn part_of(args: &Args, findings: &mut Findings) -> Result<Option<Mesh>, Failure> {
    let Some(path) = &args.part.mesh else { return Ok(None) };
    let part = args.part.mesh_args().load_file(path)?;
    part.find_named(findings);
    let mut mesh = part.mesh;
    let low = mesh.bounds().map_or(0.0, |[low, _]| low.z);
    let [x, y, z] = args.part.shift_mm;
    move_by(&mut mesh, Vector3::new(x, y, z - low));
    Ok(Some(mesh))
}

fn move_by(mesh: &mut Mesh, by: Vector3<f64>) {
    mesh.vertices.iter_mut().for_each(|vertex| *vertex += by);
}

/// Puts the part over the middle of what was laid, if that is asked for.
fn centred(args: &Args, part: Option<Mesh>, [low, high]: [Point3<f64>; 2]) -> Option<Mesh> {
    let mut mesh = part?;
    if let (true, Some([a, b])) = (args.part.centre, mesh.bounds()) {
        let off = nalgebra::center(&low, &high) - nalgebra::center(&a, &b);
        move_by(&mut mesh, Vector3::new(off.x, off.y, 0.0));
    }
    Some(mesh)
}

fn audited(source: &source::Source, part: Option<Mesh>, bars: &Bars) -> Result<Audited, Failure> {
    let args = &source.args;
    match source.kind {
        source::Kind::Cells => {
            let options = orders::OrderOptions {
                cell_mm: args.cell_mm,
                first_layer: args.first_layer,
                field_step: args.field_step,
                max_cells: args.max_cells,
            };
            let mut order = orders::read(&args.input, &options)?;
            order.cell_mm *= args.input_scale;
            order.origin *= args.input_scale;
            let part = centred(args, part, [order.origin, cells::far(&order)]);
            cells::audit(&order, args, part.as_ref(), bars)
        }
        source::Kind::Layers => {
            let layers = sheets::read(args)?;
            let part = centred(args, part, sheets::part_bounds(&layers));
            sheets::audit(layers, args, part.as_ref(), bars)
        }
        kind => {
            let read = if kind == source::Kind::Waypoints { programs::read_waypoints } else { programs::read_gcode };
            let program = read(&args.input, args)?;
            let part = centred(args, part, beads::part_bounds(&program.paths));
            beads::audit(&program, args, part.as_ref(), bars)
        }
    }
}
