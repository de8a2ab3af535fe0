//! Robot motion with little jerk along a curved layer: a UR3 that holds the part, and eight axes over a table.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 4: Table 4.2, the study of noise
//! (Fig. 4.14), and Table 4.1 on the UR3.
//! ```sh
//! cargo run --release --example jerk_motion -- --count 4681
//! cargo run --release --example jerk_motion -- layer.txt --feed 5 --up y
//! ```
//! Without `--waypoints` the path is a spiral over a patch made in code. `--help` lists the options.
//!
//! Each method has its keys in `summary.json`, such as `ur3_global_j` (Eq. 4.10), `ur3_global_spline_jerk` (the integral of
//! the squared jerk, which is what the global filter lowers) and `ur3_global_max_velocity`. Algorithm 6 does not hold bounds
//! between waypoints. Where it passes one on speed or acceleration, its J is no measure for a filter that keeps them:
//! `ur3_global_freed_...` is the global filter within bounds raised, joint by joint, to what Algorithm 6 reaches. A method
//! that has no motion on the path has no keys; `ur3_notes` says why.
//!
//! Collision indicators are measured (`svm_...`, `geometric_...`) and steer both filters past a post (`steered_...`).

mod args;
mod collisions;
mod outputs;
pub mod path;
mod planning;
mod plot;
mod results;
mod shortened;
mod studied;

pub use args::{Args, Cells};
use collisions::{Amount, Study};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::shown::followed;
use curvlay_examples::motion::{OnCell, STEP_S, Studied, centred, dissertation_cells, near_samples};
use curvlay_examples::output::OutputFolder;
use curvlay_kinematics::nalgebra::{Point3, UnitVector3};
use curvlay_kinematics::workcell::{SixAxisWorkcell, Workcell};
use curvlay_trajectory::{LadderSearch, PathOptions, PathSegment, TimedPath, Timing, timed_path};
use outputs::smoothest;
use path::Path6;
use planning::{Finer, METHODS, Plan, plan};
pub use results::{Results, Run};
use std::process::ExitCode;
use std::time::Instant;

/// Degrees by which directions are disturbed in the study of noise, and its seed.
const NOISE_DEG: [u32; 3] = [5, 10, 15];
const SEED: u64 = 414;
/// Of the methods, those before the global filter with more freedom and the grid.
const NOISY_METHODS: usize = 3;

/// Samples of tilt and turn of the table on the grid, a degree apart.
const TABLE_GRID: [u32; 2] = [121, 360];

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("jerk_motion", [args.waypoints(), args.part.as_deref()], outputs::is_ours)?;
        let (results, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&results).print()?;
        Ok(outcome)
    })
}

/// Plans by every method and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Results, Outcome), Failure> {
    let start = Instant::now();
    let given = match args.waypoints() {
        Some(file) => path::upright(&path::read(file)?, args.up),
        None => path::spiral(args.count as usize, args.crest_mm),
    };
    let timed = stamped(&given, args.feed_mm_s)?;
    if timed.segments.is_empty() {
        let defect = timed.defects.first().map_or_else(String::new, |defect| format!(" ({defect})"));
        return Err(Failure::new(format!("no piece of the path can be travelled{defect}")));
    }
    let (six, eight) = dissertation_cells().map_err(Failure::new)?;
    let cell = args.robots;
    let grid = ([360], LadderSearch::Exact);
    let ur3 = (cell != Cells::Cell8)
        .then(|| run("ur3", &given, &timed, args, bars, &six, grid, Finer::Doubled(7)))
        .transpose()?;
    // All of 43,560 samples would take hours.
    let grid = (TABLE_GRID, LadderSearch::CoarseToFine);
    let finer = Finer::NearEnough(near_samples(&eight, middle_step(&timed)));
    let cell8 =
        (cell != Cells::Ur3).then(|| run("cell8", &given, &timed, args, bars, &eight, grid, finer)).transpose()?;
    let study = ur3.as_ref().filter(|_| args.sample_count > 0);
    let study = study.map(|run| study_collisions(run, &six, &timed, args, bars)).transpose()?;
    bars.finish();
    let results = Results { path: timed, given: given.0.len(), ur3, cell8, study };
    let mut findings = results.findings(args);
    outputs::write(args, (&results, &findings), folder, start.elapsed())?;
    findings.say();
    Ok((results, findings.outcome()))
}

/// Table 4.1 on the smoothest motion of the UR3.
fn study_collisions(
    run: &Run<6>,
    cell: &SixAxisWorkcell,
    timed: &TimedPath,
    args: &Args,
    bars: &Bars,
) -> Result<Study, Failure> {
    bars.update("collisions", 0, 1);
    let all = waypoints(timed);
    let placed = centred(&all);
    let origin = all[0].0 - placed[0].position;
    let robot = OnCell::new(cell.clone(), placed);
    let trajectories = smoothest(&run.planned).map_or(&[][..], |planned| &planned.trajectories);
    let part = args.part.as_deref().map(|file| (file, args.up));
    let amount = Amount {
        training: args.training_count as usize,
        verification: args.sample_count as usize,
        post_mm: args.post(),
    };
    let times: Vec<&[f64]> = timed.segments.iter().map(|piece| &piece.times[..]).collect();
    collisions::study(&robot, &times, &origin, part, trajectories, amount)
}

/// The median of the seconds from waypoint to waypoint.
fn middle_step(timed: &TimedPath) -> f64 {
    let of = |piece: &PathSegment| piece.times.windows(2).map(|ends| ends[1] - ends[0]).collect::<Vec<_>>();
    let mut steps: Vec<f64> = timed.segments.iter().flat_map(of).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(STEP_S)
}

/// The waypoints of all pieces.
fn waypoints(timed: &TimedPath) -> Vec<(Point3<f64>, UnitVector3<f64>)> {
    let of =
        |piece: &PathSegment| piece.positions.iter().copied().zip(piece.normals.iter().copied()).collect::<Vec<_>>();
    timed.segments.iter().flat_map(of).collect()
}

fn stamped((positions, normals): &Path6, feed: Option<f64>) -> Result<TimedPath, Failure> {
    let times: Vec<f64> = (0..positions.len()).map(|k| STEP_S * k as f64).collect();
    let timing = feed.map_or(Timing::Given(&times), Timing::Feed);
    Ok(timed_path(positions, normals, timing, &PathOptions::default())?)
}

/// All methods on one robot, and the study of noise.
#[allow(clippy::too_many_arguments)] // all that differs between the two cells
fn run<const N: usize, const F: usize, W: Workcell<N, F>>(
    robot: &'static str,
    given: &Path6,
    timed: &TimedPath,
    args: &Args,
    bars: &Bars,
    cell: &W,
    grid: ([u32; F], LadderSearch),
    finer: Finer<F>,
) -> Result<Run<N>, Failure>
where
    OnCell<W>: Studied<N, F>,
{
    // One placing for the whole path, so that its pieces stay where they are to one another.
    let robots = |timed: &TimedPath| -> (Vec<OnCell<W>>, Vec<Vec<f64>>) {
        let whole = OnCell::new(cell.clone(), centred(&waypoints(timed)));
        let mut first = 0;
        let parts = timed.segments.iter().map(|piece| {
            first += piece.waypoints.len();
            whole.part(first - piece.waypoints.len()..first)
        });
        (parts.collect(), timed.segments.iter().map(|piece| piece.times.clone()).collect())
    };
    let (parts, times) = robots(timed);
    let (planned, notes) = plan(&parts, &times, &Plan { methods: &METHODS, grid, finer, makers_speeds: false }, bars)?;
    let mut noisy = Vec::new();
    for degrees in NOISE_DEG.into_iter().filter(|_| args.noise_count as usize >= curvlay_trajectory::MIN_WAYPOINTS) {
        let count = given.0.len().min(args.noise_count as usize);
        let start: Path6 = (given.0[..count].to_vec(), given.1[..count].to_vec());
        let disturbed = path::noisy(&start, f64::from(degrees).to_radians(), SEED + u64::from(degrees));
        // Normals may turn over by twice the noise; the study is about what that does.
        let options = PathOptions { flip: std::f64::consts::PI, ..PathOptions::default() };
        let times: Vec<f64> = (0..count).map(|k| STEP_S * k as f64).collect();
        let timing = args.feed_mm_s.map_or(Timing::Given(&times), Timing::Feed);
        let timed = timed_path(&disturbed.0, &disturbed.1, timing, &options)?;
        let (parts, times) = robots(&timed);
        let methods = &METHODS[..NOISY_METHODS];
        let (planned, _) = plan(&parts, &times, &Plan { methods, grid, finer, makers_speeds: true }, bars)?;
        noisy.push((degrees, planned));
    }
    let shown = smoothest(&planned).map(|planned| followed(cell, &planned.trajectories));
    Ok(Run { robot, planned, notes, noisy, shown })
}
