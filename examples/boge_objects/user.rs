//! A grid of the user's own: grown in all ways on what the hardware makes of its platform.

use super::growing::{self, Run, STRATEGIES, Tuned, Ways};
use super::hardware::Hardware;
use super::outputs;
use super::rating::Rating;
use curvlay_examples::args::{Failure, Outcome, warn};
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::input;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_voxel::{TextGrid, read_text_grid};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The file of the grid.
    pub file: PathBuf,
    /// What its platform stands on.
    pub hardware: Hardware,
    /// The share of missed cells up to which the run counts as well done.
    pub allow_missed: f64,
    /// Voxel accumulation threshold of GCFA-ISP; none: the best.
    pub threshold: Option<u32>,
    /// For the summary; the work takes milliseconds.
    pub threads: usize,
}

/// What came out.
pub struct Answer {
    pub drawn: TextGrid,
    pub ways: Ways,
    /// GCFA-ISP with a threshold.
    pub tuned: Tuned,
    /// Cells that uniform slicing misses.
    pub sliced: usize,
    /// Which of [`STRATEGIES`] misses least; of those the one with the fewest layers.
    pub best: usize,
    /// Checks that failed, a line each.
    pub failed: Vec<String>,
}

/// Whether a file of this name is one that a run writes.
pub fn is_ours(name: &str) -> bool {
    [outputs::LAYERS_FILE, "report.html"].contains(&name)
}

/// Reads, grows and writes.
pub fn work(request: &Request, bars: &Bars, folder: &OutputFolder) -> Result<Answer, Failure> {
    let start = Instant::now();
    let drawn = read(&request.file)?;
    bars.update("grow", 0, 1);
    let named = |error: Failure| Failure::new(format!("{}: {}", request.file.display(), error.message()));
    let ways = growing::grow_on(&drawn, request.hardware).map_err(named)?;
    let sliced = growing::sliced(&drawn)?.missed.len();
    let tuned = growing::tuned(&drawn, request.hardware, request.threshold)?;
    bars.finish();
    let counts = |run: &Run| (run.growth.missed.len(), run.growth.order.len());
    let best = (0..STRATEGIES.len()).min_by_key(|&way| counts(&ways.ours[way])).unwrap_or(0);
    let mut answer = Answer { drawn, ways, tuned, sliced, best, failed: vec![] };
    answer.failed = failed(&answer, request.allow_missed);
    answer.write(request, folder, start)?;
    Ok(answer)
}

fn read(path: &Path) -> Result<TextGrid, Failure> {
    let named = |error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", path.display()));
    let file = input::open(path, input::MAX_TEXT_BYTES)?;
    let drawn = read_text_grid(BufReader::new(file)).map_err(|error| named(&error))?;
    // By the rules of the thesis the hull is that of the centres of its cells.
    let is_thin = |axis: usize| drawn.platform.iter().all(|cell| cell[axis] == drawn.platform[0][axis]);
    match (is_thin(0), is_thin(1) && !drawn.flat) {
        (true, _) => Err(named(&"the platform must be at least two cells wide")),
        (_, true) => Err(named(&"the platform must be at least two cells deep")),
        _ => Ok(drawn),
    }
}

/// Failed audits, and more missed cells than allowed.
fn failed(answer: &Answer, allow_missed: f64) -> Vec<String> {
    let all = answer.ways.runs().chain([("GCFA-ISP with a threshold", &answer.tuned.run)]);
    let runs = all.filter(|(_, run)| !run.audit.is_ok());
    let mut failed: Vec<String> = runs.map(|(method, run)| format!("audit of {method}: {}", run.audit)).collect();
    if answer.missed_share() > allow_missed {
        failed.push(format!("{}, more than --allow-missed {allow_missed}", answer.finding()));
    }
    failed
}

impl Answer {
    /// The run of ours that misses least.
    pub fn best_run(&self) -> &Run {
        &self.ways.ours[self.best]
    }

    /// The share of the cells that the best run misses.
    pub fn missed_share(&self) -> f64 {
        self.best_run().growth.missed.len() as f64 / self.drawn.grid.count() as f64
    }

    /// What is missed, in words.
    fn finding(&self) -> String {
        let (missed, cells) = (self.best_run().growth.missed.len(), self.drawn.grid.count());
        let share = 100.0 * self.missed_share();
        format!(
            "{}, the best strategy, misses {missed} of {} ({share:.2} %)",
            STRATEGIES[self.best],
            counted(cells, "cell")
        )
    }

    pub fn outcome(&self) -> Outcome {
        Outcome::of(self.failed.clone())
    }

    /// A line for each method.
    pub fn table(&self) -> Table {
        let mut table = Table::new(["method", "missed", "share", "layers", "verdict", "audit"]);
        let cells = self.drawn.grid.count();
        let share = |missed: usize| format!("{:.2} %", 100.0 * missed as f64 / cells as f64);
        let tuned = format!("GCFA-ISP, threshold {}", self.tuned.threshold);
        let runs = self.ways.runs().map(|(method, run)| (method.to_owned(), run)).chain([(tuned, &self.tuned.run)]);
        for (method, run) in runs {
            let (missed, layers) = (run.growth.missed.len(), run.growth.order.len());
            let audit = if run.audit.is_ok() { "passed" } else { "FAILED" };
            let rating = Rating::of(run, &self.drawn).to_string();
            table.row([method, missed.to_string(), share(missed), layers.to_string(), rating, audit.into()]);
        }
        table.row(["uniform slicing".to_owned(), self.sliced.to_string(), share(self.sliced)]);
        table
    }

    fn write(&self, request: &Request, folder: &OutputFolder, start: Instant) -> Result<(), Failure> {
        let size = self.drawn.grid.dims().map(|n| n as usize).iter().product();
        let fields = [self.best_run(), &self.ways.theirs[0], &self.ways.theirs[1], &self.tuned.run];
        let fields = fields.map(|run| run.growth.order.field(size));
        folder.write_with(outputs::LAYERS_FILE, |out| {
            writeln!(out, "x,y,z,layer,gcfa,gcfa_isp,gcfa_isp_tuned")?;
            for cell in self.drawn.grid.iter() {
                let [x, y, z] = self.drawn.grid.position(cell);
                // 0 is a missed cell.
                let [best, gcfa, isp, tuned] = fields.each_ref().map(|field| field[cell as usize]);
                writeln!(out, "{x},{y},{z},{best},{gcfa},{isp},{tuned}")?;
            }
            Ok(())
        })?;
        folder.write("report.html", self.report(request)?.to_html())?;
        let mut summary = Summary::new();
        summary
            .set("version", env!("CARGO_PKG_VERSION"))?
            .set("threads", request.threads)?
            .set("grid", request.file.display().to_string())?
            .set("hardware", request.hardware.key())?
            .set("platform_width_cells", request.hardware.width(&self.drawn))?
            .set("cells", self.drawn.grid.count())?
            .set("best", STRATEGIES[self.best])?
            .set("missed_cells", self.best_run().growth.missed.len())?
            .set("missed_share", self.missed_share())?
            .set("allow_missed", request.allow_missed)?
            .set("layers", self.best_run().growth.order.len())?
            .set("uniform_missed", self.sliced)?
            .set("isp_threshold", self.tuned.threshold)?
            .set("isp_tuned_missed", self.tuned.run.growth.missed.len())?
            .set("isp_tuned_layers", self.tuned.run.growth.order.len())?
            .set("audit_ok", self.ways.runs().all(|(_, run)| run.audit.is_ok()))?
            .set("failed", self.failed.join("; "))?
            .set_seconds("total_s", start.elapsed())?;
        for (method, run) in self.ways.runs() {
            summary
                .set(&growing::figure("way", method, "missed"), run.growth.missed.len())?
                .set(&growing::figure("way", method, "layers"), run.growth.order.len())?
                .set(&growing::figure("way", method, "rating"), Rating::of(run, &self.drawn).to_string())?;
        }
        // It comes last: where it is, all is there.
        summary.write(folder)?;
        if self.failed.is_empty() && !self.best_run().growth.missed.is_empty() {
            warn(self.finding());
        }
        Ok(())
    }

    fn report(&self, request: &Request) -> Result<Report, Failure> {
        let mut report = Report::new(&format!("{}, {}", request.file.display(), request.hardware.name()));
        if !self.best_run().growth.missed.is_empty() {
            report.notice(&self.finding());
        }
        self.failed.iter().for_each(|line| _ = report.notice(line));
        report.paragraph(&format!(
            "The platform that counts into the hull is {} cells wide. Two methods by the rules of H. Boge (Robotic additive \
             manufacturing, MSc thesis, NTNU 2019), un-building by her rules, and our strategies by our default rules.",
            request.hardware.width(&self.drawn)
        ));
        report.table("Missed cells and layers", &self.table()).paragraph(outputs::BOUNDS);
        let drawn: Result<Vec<(String, Vec<u8>)>, Failure> = (self.ways.runs())
            .map(|(method, run)| Ok((method.to_owned(), outputs::picture(&self.drawn, run)?)))
            .collect();
        let drawn = drawn?;
        report.pictures(&drawn.iter().map(|(method, png)| (method.as_str(), png.as_slice())).collect::<Vec<_>>());
        Ok(report)
    }
}
