//! The stages, one after the other.

use crate::args::{Stage, failure};
use crate::choice::{Choice, SUPPORT_ROUNDS, Tried};
use crate::complete::LayersBy;
use crate::field::{self, Given};
use crate::job::{Job, Results};
use crate::motion::{self, Print, trajectory};
use crate::outputs::{self, Files};
use crate::ranges::{self, Pick};
use crate::{findings, machine, paths, tried};
use curvlay_examples::args::{Failure, Outcome, note, typed_name};
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::mesh::Mesh;
use curvlay_layers::curved::surface::SavedField;
use curvlay_voxel::inspect::thinner_than;
use nalgebra::Point3;
use std::fs::File;
use std::io::BufReader;
use std::time::Instant;

impl Job<'_> {
    /// Runs the stages.
    pub fn work(&self, saved: Option<SavedField>) -> Result<Outcome, Failure> {
        let Job { args, part, .. } = *self;
        let mut findings = Findings::default();
        part.find(&mut findings);
        self.mould.into_iter().for_each(|mould| mould.find_named(&mut findings));
        findings.say();
        let longest = part.mesh.bounds().map_or(0.0, |[low, high]| (high - low).max());
        if let Some(bead) = args.settings.bead_mm.filter(|bead| *bead > longest) {
            return Err(failure(format!("--bead {bead}: wider than the part is long, {longest:.3} mm")));
        }
        if args.stage == Stage::Preview {
            return self.preview(saved, &findings);
        }
        let mut results = match args.chooses_by_print() {
            true => self.best(&findings)?,
            false => self.begin(args.layers_by(), saved, &[], findings)?,
        };
        if args.stage >= Stage::Surfaces && results.surfaces.is_none() {
            return Err(failure(format!("the audit of the layers failed: {}", results.field.audit)));
        }
        if let Some(pick) = args.layers {
            return self.range(pick, results);
        }
        self.end(Stage::Surfaces.min(args.stage), &mut results)?;
        for stage in [Stage::Paths, Stage::Gcode, Stage::Motion].into_iter().filter(|stage| *stage <= args.stage) {
            self.run(stage, &mut results)?;
            self.end(stage, &mut results)?;
        }
        Ok(results.findings.outcome())
    }

    /// Field and surfaces of an order, with support below unsupported beads.
    pub fn begin(
        &self,
        layers_by: LayersBy,
        saved: Option<SavedField>,
        bare: &[Point3<f64>],
        mut findings: Findings,
    ) -> Result<Results, Failure> {
        let Job { args, part, mould, guide, bars, .. } = *self;
        let makes_surfaces = args.stage >= Stage::Surfaces || args.stage == Stage::Preview;
        let surfaces = makes_surfaces.then(|| args.surface_options());
        let options = args.field_options(layers_by, &self.setup.nozzle);
        let (field, surfaces) =
            field::run(&options, surfaces.as_ref(), args.memory(), Given { part, mould, guide, saved, bare }, bars)?;
        // Where the edge of a cell is the layer height, it is known only now; nothing has been written yet.
        if let Some(surfaces) = surfaces.as_ref().filter(|_| args.stage >= Stage::Paths) {
            args.path_options(surfaces.height_mm)?;
        }
        part.coarse_for(field.solid.grid.cell_mm()).iter().for_each(|why| findings.add(Severity::Warning, why, "", ""));
        let files = Files::default();
        let mut results = Results {
            field,
            surfaces,
            paths: None,
            machine: None,
            motion: None,
            preview: None,
            files,
            findings,
            choice: None,
        };
        findings::of_stage(Stage::Surfaces.min(args.stage), args, &mut results);
        Ok(results)
    }

    /// The order that prints best: one after the other is printed, until one passes all checks.
    fn best(&self, findings: &Findings) -> Result<Results, Failure> {
        let orders = self.args.orders();
        let (mut best, taken) = self.tried(orders[0], findings)?;
        let mut choice = Choice { taken, others: Vec::new() };
        for &layers_by in &orders[1..] {
            if choice.taken.passed {
                break;
            }
            if !self.args.common.quiet {
                self.bars.finish();
                let names = choice.names().join(" and ");
                note(format!("layers of --layers-by {names} do not pass all checks: trying {}", typed_name(layers_by)));
            }
            let (results, mut tried) = self.tried(layers_by, findings)?;
            if tried.is_better_than(&choice.taken) {
                best = results;
                std::mem::swap(&mut choice.taken, &mut tried);
            }
            choice.others.push(tried);
        }
        if !best.has(Stage::Gcode) {
            let start = Instant::now();
            self.print(&mut best)?;
            let time = choice.taken.time + start.elapsed();
            choice.taken = tried::tried(choice.taken.layers_by, &best, self.args, time);
        }
        best.choice = Some(choice).filter(|choice| orders.len() > 1 || choice.taken.below_beads > 0);
        Ok(best)
    }

    /// Tries an order; where too many of its beads are unsupported, again with support below them.
    fn tried(&self, layers_by: LayersBy, findings: &Findings) -> Result<(Results, Tried), Failure> {
        let start = Instant::now();
        let (mut best, mut tried) = self.tried_once(layers_by, &[], findings)?;
        let mut bare = tried::bare_places(&best, self.args);
        let mut below = Vec::new();
        for _ in 0..SUPPORT_ROUNDS {
            if tried.passed || bare.is_empty() || !self.args.supports_beads(layers_by) {
                break;
            }
            if !self.args.common.quiet {
                self.bars.finish();
                note("too many beads are unsupported: adding support below them");
            }
            below.append(&mut bare);
            let (results, again) = self.tried_once(layers_by, &below, findings)?;
            bare = tried::bare_places(&results, self.args);
            if again.is_better_than(&tried) {
                (best, tried) = (results, again);
            }
        }
        tried.time = start.elapsed();
        Ok((best, tried))
    }

    /// Tries an order with support below these places. One that fails before it is printed is not printed: it misses too much, or its audit failed.
    fn tried_once(
        &self,
        layers_by: LayersBy,
        bare: &[Point3<f64>],
        findings: &Findings,
    ) -> Result<(Results, Tried), Failure> {
        let start = Instant::now();
        let mut results = self.begin(layers_by, None, bare, findings.clone())?;
        if !results.findings.has_failed() {
            self.print(&mut results)?;
        }
        let tried = tried::tried(layers_by, &results, self.args, start.elapsed());
        Ok((results, tried))
    }

    /// Runs the stages from the surfaces to the machine file.
    fn print(&self, results: &mut Results) -> Result<(), Failure> {
        self.run(Stage::Paths, results)?;
        self.run(Stage::Gcode, results)
    }

    /// Fills a range of the layers and ends.
    fn range(&self, pick: Pick, mut results: Results) -> Result<Outcome, Failure> {
        let Job { args, bars, .. } = self;
        results.findings.say();
        let Results { field, surfaces: Some(surfaces), .. } = &results else { return Ok(Outcome::Done) };
        let range = pick.layers(surfaces.sheets.len()).map_err(failure)?;
        let options = args.path_options(surfaces.height_mm)?;
        args.memory().holds_paths(options.bead, field.solid.grid.cell_mm(), surfaces)?;
        let fill = args.fill(options, surfaces);
        let layers = paths::range(&fill, surfaces, range.clone(), bars)?;
        bars.finish();
        ranges::write(&surfaces.surfaces(), surfaces.made_of(), &fill, range.clone(), &layers, self.folder)?;
        outputs::write_range(self, &results, range, &layers)?;
        Ok(results.findings.outcome())
    }

    /// Runs a stage that comes after the surfaces, unless it has been run, and finds what is wrong with it.
    fn run(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        if !results.has(stage) {
            self.make(stage, results)?;
            findings::of_stage(stage, self.args, results);
        }
        Ok(())
    }

    /// Makes what a stage makes.
    fn make(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        let Job { args, setup, bars, .. } = self;
        let (memory, nozzle) = (args.memory(), &setup.nozzle);
        let Results { field, surfaces: Some(surfaces), .. } = &*results else { return Ok(()) };
        match (stage, &results.paths, &results.machine) {
            (Stage::Paths, ..) => {
                let options = args.path_options(surfaces.height_mm)?;
                memory.holds_paths(options.bead, field.solid.grid.cell_mm(), surfaces)?;
                let fill = args.fill(options, surfaces);
                let filled = match &args.merge[..] {
                    [] => Vec::new(),
                    files => ranges::read(files, &surfaces.surfaces(), surfaces.made_of(), &fill).map_err(failure)?,
                };
                let thinnest_mm = || {
                    let Mesh { vertices, triangles } = &self.part.mesh;
                    let thin = thinner_than(vertices, triangles, 2.0 * options.bead).ok()?;
                    thin.thinnest.map(|(mm, _)| mm)
                };
                results.paths = Some(paths::run(&fill, surfaces, filled, bars, thinnest_mm)?);
            }
            (Stage::Gcode, Some(paths), _) => {
                memory.holds_waypoints(&args.print_options(), args.stage >= Stage::Motion, paths)?;
                let mut machine = machine::run(nozzle, args, field, surfaces, paths, bars)?;
                if args.has_statistics() {
                    machine.measure_skin(&self.part.mesh, field.solid.shift, bars)?;
                }
                results.machine = Some(machine);
            }
            (Stage::Motion, Some(paths), Some(machine)) => {
                let (filament_mm, travel_mm_s) =
                    (args.settings.deposition().filament_diameter, args.settings.travel_feed_mm_s);
                let args = &args.motion;
                let print = Print { args, nozzle, filament_mm, travel_mm_s, field, surfaces, paths, machine };
                let mut motion = motion::run(&print, &setup.cell, bars)?;
                // What was written is checked, and the machine file then goes as fast as the robot.
                for _ in 0..CHECK_ROUNDS {
                    outputs::trajectory(&motion, self.folder)?;
                    let file = File::open(self.folder.path().join(trajectory::FILE)).map_err(failure)?;
                    if !motion.check(&print, BufReader::new(file), bars)? {
                        break;
                    }
                }
                results.machine.iter_mut().for_each(|machine| machine.deposition.retime(motion.steps()));
                results.motion = Some(motion);
            }
            _ => {}
        }
        Ok(())
    }

    /// Ends a stage: reports its findings and writes its files.
    pub fn end(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        self.bars.finish();
        results.findings.say();
        outputs::write(stage, self, results)
    }
}

/// Maximum rounds of writing and checking motions and removing unsafe ones; if some are still unsafe then, there are no programs.
const CHECK_ROUNDS: usize = 8;
