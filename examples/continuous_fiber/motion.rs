//! The tapes of the arc by a UR3 that holds the mould under a standing roller, as in figure 5.1(a): its motion and its program.
//!
//! The roller looks along the tape: its tool angle is given. Where the roller is mounted about its axis is chosen so that the most waypoints are in
//! reach and clear on one branch of the arm. The body of the workcell's nozzle stands for that of the roller.

use super::specimens::joined;
use super::tapes::Planned;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{OnCell, PrintingCell, bounds_of, from_home, programs};
use curvlay_examples::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::centred_on_plate;
use curvlay_kinematics::program::{
    HeadSignal, StreamLeg, StreamOptions, TimedSignal, UrScriptOptions, print_stream, write_urscript,
};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, SixAxisCell, Workcell};
use curvlay_toolpath::surface::{Tape, TapeHead};
use curvlay_trajectory::print::{
    Clearance, Fault, LegKind, PrintCell, PrintLimits, PrintOptions, PrintPath, PrintPlan, PrintRobot, Run, Steered,
    Waypoint, plan_print,
};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::ops::Range;

/// Edge of the cells by which the robot sees mould and part, in millimetres.
const CELL_MM: f64 = 1.5;
/// The plate, in millimetres.
const PLATE_MM: f64 = 127.5;
/// How far the roller may turn away from the tape, in radians: a tape of 5 mm on a roller gives so much without a crease.
pub const SLACK: f64 = 0.035;
/// Places of the roller about its axis that are tried.
const MOUNTS: u32 = 120;
/// How far the contact line may leave the centre line, in millimetres: a tenth of a tape's width is told as overlap.
const TOLERANCE_MM: f64 = 0.1;
/// Speed with which tape is pushed out, in mm/s: the feed before a tape takes the length from blade to roller.
const FEED_MM_S: f64 = 20.0;

/// What the motion comes to.
#[derive(Default)]
pub struct Moved {
    /// Name of the workcell.
    pub cell: String,
    /// Motions along tapes.
    pub runs: usize,
    /// Tapes.
    pub tapes: usize,
    /// Seconds that the robot moves.
    pub robot_s: f64,
    /// How far the contact line is from the centre line at most, in mm.
    pub max_deviation_mm: f64,
    /// How far the roller is turned away from a tape at most, in radians.
    pub max_turn: f64,
    /// Where the roller is mounted about its axis, in radians.
    pub mount: f64,
    /// What it does not lay as planned.
    pub faults: Vec<Fault>,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// A tape on the plate: where its contact line goes, and along which direction.
struct Placed {
    layer: u32,
    waypoints: Vec<Waypoint>,
    tangents: Vec<Vector3<f64>>,
    /// Seconds at each.
    times: Vec<f64>,
    none: Vec<f64>,
    /// Millimetres of tape by each.
    arcs: Vec<f64>,
}

impl Placed {
    fn new(tape: &Tape, layer: u32, lift: f64, head: &TapeHead, frame: &Isometry3<f64>) -> Self {
        let points = &tape.points;
        let contact = |k: usize| {
            let waypoint = Waypoint {
                position: points[k] + tape.normals[k].into_inner() * (lift + tape.thickness),
                axis: tape.normals[k],
            };
            waypoint.moved(frame)
        };
        let waypoints: Vec<Waypoint> = (0..points.len()).map(contact).collect();
        let last = points.len() - 1;
        let tangent = |k: usize| frame * (points[(k + 1).min(last)] - points[k.saturating_sub(1)]).normalize();
        let mut arcs = vec![0.0];
        for pair in points.windows(2) {
            arcs.push(arcs[arcs.len() - 1] + (pair[1] - pair[0]).norm());
        }
        Placed {
            layer,
            tangents: (0..points.len()).map(tangent).collect(),
            times: arcs.iter().map(|arc| arc / head.lay_feed).collect(),
            none: vec![0.0; points.len()],
            waypoints,
            arcs,
        }
    }

    fn path(&self) -> PrintPath<'_> {
        PrintPath { layer: self.layer, waypoints: &self.waypoints, times: &self.times, filament_mm: &self.none }
    }
}

/// The direction of the nearest tape, evenly from point to point.
fn tangent_at(tapes: &[Placed], at: &Point3<f64>) -> Vector3<f64> {
    let mut best = (f64::INFINITY, Vector3::x());
    for tape in tapes {
        for (ends, tangents) in tape.waypoints.windows(2).zip(tape.tangents.windows(2)) {
            let (from, way) = (ends[0].position, ends[1].position - ends[0].position);
            let share = ((at - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            let distance = (from + way * share - at).norm_squared();
            if distance < best.0 {
                best = (distance, tangents[0] * (1.0 - share) + tangents[1] * share);
            }
        }
    }
    best.1
}

/// The tool angle at which the x axis of the tool frame looks along the tape.
fn heading(tapes: &[Placed], waypoint: &Waypoint) -> f64 {
    let plain = curvlay_kinematics::Waypoint { position: waypoint.position, axis: waypoint.axis }.frame(0.0);
    let along = tangent_at(tapes, &waypoint.position);
    along.dot(&(plain * Vector3::y())).atan2(along.dot(&(plain * Vector3::x())))
}

/// Where the roller is mounted: so that the most waypoints can be reached on one branch along each tape, with the clearance that
/// postures keep. The first of the best.
///
/// # Arguments
/// * `cell`: the workcell with mould and part.
fn mounted(robot: &OnCell<SixAxisCell>, tapes: &[Placed], cell: &impl PrintCell<6>) -> f64 {
    let limits = robot.workcell().limits();
    // Waypoints of the longest part of a tape that one branch follows.
    let unbroken = |tape: &Placed, headings: &[f64], mount: f64| {
        let mut longest = 0;
        let mut by_branch: BTreeMap<u32, usize> = BTreeMap::new();
        for (waypoint, heading) in tape.waypoints.iter().zip(headings) {
            let mut goes_on = BTreeMap::new();
            PrintRobot::solutions(robot, waypoint, &[heading + mount], &mut |branch, joints: [f64; 6]| {
                let is_inside = (0..6).all(|j| (limits.lower[j]..=limits.upper[j]).contains(&joints[j]));
                if is_inside && cell.keeps(&joints, Clearance::Wide) {
                    goes_on.insert(branch, by_branch.get(&branch).copied().unwrap_or(0) + 1);
                }
            });
            longest = goes_on.values().copied().fold(longest, usize::max);
            by_branch = goes_on;
        }
        longest
    };
    let heading_of = |tape: &Placed| tape.waypoints.iter().map(|waypoint| heading(tapes, waypoint)).collect();
    let headings: Vec<Vec<f64>> = tapes.iter().map(heading_of).collect();
    let count = |mount: f64| -> usize {
        tapes.iter().zip(&headings).map(|(tape, headings)| unbroken(tape, headings, mount)).sum()
    };
    let mounts = (0..MOUNTS).map(|k| TAU * f64::from(k) / f64::from(MOUNTS));
    mounts
        .map(|mount| (count(mount), mount))
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
        .map_or(0.0, |best| best.1)
}

/// Cells of mould and part, and the layers in which they come: the mould first.
fn cells_of(planned: &Planned, bars: &Bars) -> Result<(Voxelisation, Vec<Vec<u32>>), Failure> {
    let specimen = &planned.specimen;
    let mut mesh = specimen.solid();
    if let Some(mould) = specimen.mould_solid() {
        mesh = joined(mesh, mould);
    }
    let voxels = VoxelOptions { resolution: Resolution::Cell(CELL_MM), ..VoxelOptions::default() };
    let solid = voxelise(&mesh.vertices, &mesh.triangles, &voxels, &|p| bars.show(p.stage, p.done, p.total))?;
    let grid = &solid.grid;
    let [nx, ny, nz] = grid.dims();
    let mut layers = vec![Vec::new(); specimen.layers as usize + 1];
    let words = (nx as usize).div_ceil(64);
    for cell in 0..nx * ny * nz {
        let at = [cell % nx, cell / nx % ny, cell / nx / ny];
        let row = at[1] as usize + ny as usize * at[2] as usize;
        if grid.rows()[row * words + at[0] as usize / 64] >> (at[0] % 64) & 1 == 0 {
            continue;
        }
        let place = grid.origin() + Vector3::from(at.map(|k| (f64::from(k) + 0.5) * CELL_MM)) - solid.shift;
        let height = specimen.height(place) / specimen.layer_mm;
        let layer = if height < 0.0 { 0 } else { (height as usize + 1).min(specimen.layers as usize) };
        layers[layer].push(cell);
    }
    Ok((solid, layers))
}

/// Plans the motion along all tapes of a specimen.
pub fn plan(planned: &Planned, cell: &AnyWorkcell, head: &TapeHead, bars: &Bars) -> Result<Moved, Failure> {
    let AnyWorkcell::Six(cell) = cell else {
        return Err(Failure::of_arguments("the tapes are laid by an arm without a table: give a workcell of six axes"));
    };
    if !programs::takes_stream(cell.equipment()).map_err(Failure::new)? {
        return Err(Failure::of_arguments(
            "programs of tapes are URScript: give a workcell with an arm of Universal Robots",
        ));
    }
    let all = || planned.tapes.iter().flat_map(|layer| layer.tapes.iter().map(move |tape| (layer, tape)));
    let frame = centred_on_plate(all().flat_map(|(_, tape)| &tape.points));
    // The mould is layer 0 of the scene.
    let placed: Vec<Placed> =
        all().map(|(layer, tape)| Placed::new(tape, layer.layer + 1, layer.lift, head, &frame)).collect();
    let robot = OnCell::new(cell.clone(), Vec::new());
    let (solid, layers) = cells_of(planned, bars)?;
    let grid = &solid.grid;
    let part = PartCells {
        dims: grid.dims(),
        rows: grid.rows(),
        cell_mm: CELL_MM,
        origin: grid.origin() - solid.shift,
        frame_part: frame,
        layers: &layers,
    };
    let scene = GrowingScene::new(cell, &part, PLATE_MM, &GrowingOptions::default())?;
    let limits = PrintLimits { tolerance_mm: TOLERANCE_MM, ..PrintLimits::of(bounds_of(cell.limits())) };
    let paths: Vec<PrintPath> = placed.iter().map(Placed::path).collect();
    let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
    let (scene, options) = (PrintingCell::pressing(scene), PrintOptions::default());
    let mut built = scene.clone();
    PrintCell::begin(&mut built, u32::MAX).map_err(Failure::new)?;
    let mount = mounted(&robot, &placed, &built);
    let steered =
        Steered { robot: &robot, heading: |waypoint: &Waypoint| heading(&placed, waypoint) + mount, slack: SLACK };
    let plan = plan_print(&steered, scene.clone(), &paths, &limits, &options, &progress)?;
    let plan = from_home(&plan, &BTreeSet::new(), &steered, scene, (&limits, &options), &progress)?;

    let mut moved = Moved {
        cell: cell.equipment().name().to_owned(),
        runs: plan.runs.len(),
        tapes: placed.len(),
        robot_s: plan.robot_s(),
        max_deviation_mm: plan.max_deviation_mm,
        max_turn: turned(&robot, &plan, &placed, mount),
        mount,
        faults: plan.faults.clone(),
        files: BTreeMap::new(),
    };
    for (number, piece) in programs::pieces(&plan).into_iter().enumerate() {
        let name = format!("{}_tapes_{:03}", planned.specimen.name, number + 1);
        let options = UrScriptOptions { name: name.clone(), ..UrScriptOptions::of_workcell(cell.equipment()) };
        let mut file = Vec::new();
        let steps = stream(&plan, piece, &placed, head, StreamOptions::of_workcell(cell.equipment()));
        write_urscript(steps, &options, &mut file)?;
        moved.files.insert(format!("{name}.script"), file);
    }
    Ok(moved)
}

/// How far the tool is turned away from the tapes at most, of the motion as it is.
fn turned(robot: &OnCell<SixAxisCell>, plan: &PrintPlan<6, 1>, placed: &[Placed], mount: f64) -> f64 {
    let mut most: f64 = 0.0;
    for joints in plan.runs.iter().flat_map(|run| run.trajectory.joints()) {
        let Some(tool) = PrintRobot::nozzle(robot, joints) else { continue };
        let along = tangent_at(placed, &Point3::from(tool.translation.vector));
        let (x, y) = (tool * Vector3::x(), tool * Vector3::y());
        let turn = along.dot(&y).atan2(along.dot(&x)) + mount;
        most = most.max((turn - TAU * (turn / TAU).round()).abs());
    }
    most
}

/// When the blade passes, in seconds since the run began; none where the run ends before.
fn cut_at(run: &Run<6, 1>, tape: &Placed, blade: f64) -> Option<f64> {
    let at = tape.arcs[tape.arcs.len() - 1] - blade;
    let times = run.trajectory.times();
    let known: Vec<(f64, f64)> = run
        .passes
        .iter()
        .filter_map(|&(knot, waypoint)| Some((times[knot] - times[0], tape.arcs[waypoint?])))
        .collect();
    let pair = known.windows(2).find(|pair| pair[1].1 >= at)?;
    let ((t0, a0), (t1, a1)) = (pair[0], pair[1]);
    Some(t0 + (t1 - t0) * ((at - a0) / (a1 - a0)).clamp(0.0, 1.0))
}

/// The motion at every tick, with the signals of the head, as late as `options` say that the arm is behind its stream.
fn stream<'a>(
    plan: &'a PrintPlan<6, 1>,
    runs: Range<usize>,
    placed: &'a [Placed],
    head: &'a TapeHead,
    options: StreamOptions,
) -> impl Iterator<Item = curvlay_kinematics::program::Step> + 'a {
    let at = |time_s: f64, signal: HeadSignal, on: bool| TimedSignal { time_s, signal, on };
    let feed_s = head.blade / FEED_MM_S;
    let start = plan.legs(runs.clone()).next().map_or([0.0; 6], |leg| leg.at(0.0));
    let stop = plan.legs(runs.clone()).last().map_or(start, |leg| leg.at(leg.duration()));
    type Joints<'a> = Box<dyn Fn(f64) -> [f64; 6] + 'a>;
    let feeding = move |joints: [f64; 6]| StreamLeg {
        duration_s: feed_s,
        joints: Box::new(move |_| joints) as Joints,
        filament_mm: None::<fn(f64) -> f64>,
        signals: vec![at(0.0, HeadSignal::Feed, true), at(feed_s, HeadSignal::Feed, false)],
    };
    let legs = plan.legs(runs).enumerate().flat_map(move |(number, leg)| {
        let duration = leg.duration();
        let mut signals = Vec::new();
        // The roller turns and heats on the way from home.
        if number == 0 {
            signals.extend([at(0.0, HeadSignal::Roller, true), at(0.0, HeadSignal::Heat, true)]);
        }
        if leg.kind == LegKind::Print {
            signals.push(at(0.0, HeadSignal::Press, true));
            if let Some(cut) = cut_at(leg.run, &placed[leg.run.path], head.blade) {
                signals.extend([at(cut, HeadSignal::Cut, true), at(duration, HeadSignal::Cut, false)]);
            }
            signals.push(at(duration, HeadSignal::Press, false));
        }
        let before = (leg.kind == LegKind::Approach).then(|| feeding(leg.at(0.0)));
        let motion = StreamLeg {
            duration_s: duration,
            joints: Box::new(move |time| leg.at(time)) as Joints,
            filament_mm: None,
            signals,
        };
        before.into_iter().chain([motion])
    });
    print_stream([start, stop], legs, options)
}
