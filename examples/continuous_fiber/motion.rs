//! Motion along tapes: a robot whose roller looks along them, in the place of the nozzle, and its programs.
//!
//! The tool angle is given by the tape. How the roller is mounted about its axis is chosen so that the most waypoints are in reach and clear on one branch of
//! the arm, unless the workcell says it. The roller and its block are bodies of the scene: the block keeps off what is built, the roller presses on it.
//!
//! Here as well: the tapes of the arc by a UR3 that holds the mould under a standing roller, as in figure 5.1(a).

use super::specimens::joined;
use super::tapes::Planned;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::programs::LIFT_POSTURES;
use curvlay_examples::motion::{OnCell, PrintingCell, bounds_of, from_home, programs};
use curvlay_examples::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::centred_on_plate;
use curvlay_kinematics::print_program::{
    PrintKnot, StreamOptions, StreamSegment, TargetMotion, TargetOptions, print_stream, print_targets,
};
use curvlay_kinematics::program::{
    Goal, HeadInput, HeadSignal, Move, Speed, Step, TimedSignal, UrScriptOptions, Zone, write_urscript,
};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, SixAxisWorkcell, Workcell};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::gcode::Tool;
use curvlay_trajectory::print::{
    Clearance, Fault, PrintLimits, PrintOptions, PrintPath, PrintPlan, PrintRobot, PrintWorkcell, Run, SegmentKind,
    Steered, Waypoint, plan_print,
};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::TAU;
use std::ops::Range;

/// Edge of the cells by which the robot sees mould and arc, in millimetres.
const CELL_MM: f64 = 1.5;
/// The plate of the arc, in millimetres.
const PLATE_MM: f64 = 127.5;
/// How far the roller may turn away from the tape, in radians: a tape of 5 mm on a roller gives so much without a crease.
pub const SLACK: f64 = 0.035;
/// Angles at which the roller is tried about its axis: ten degrees apart, less than the ranges in which an arm follows a tape.
const MOUNTS: u32 = 36;
/// Tapes by which that is decided, spread evenly over all.
const MOUNT_TAPES: usize = 12;
/// How high it must be able to lift off, in millimetres: as planners of ways do where there is room.
const LIFTED_MM: f64 = 20.0;
/// How far the contact line may leave the centre line, in millimetres: a tenth of a tape's width counts as overlap.
const TOLERANCE_MM: f64 = 0.1;
/// Speed with which tape is pushed out, in mm/s: the feed before a tape takes the length from blade to roller.
const FEED_MM_S: f64 = 20.0;
/// Knots nearer in time than this, in seconds, are one.
const SAME_S: f64 = 1e-6;
/// Edge of the cells in which the nearest tape is looked up, in millimetres: tapes are found as far away.
const NEAR_MM: f64 = 10.0;

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
    /// How the roller is mounted about its axis, in radians.
    pub mount: f64,
    /// What it does not lay as planned.
    pub faults: Vec<Fault>,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// A tape on the plate: where its contact line goes, and along which direction.
pub struct Placed {
    /// Its layer in the scene.
    layer: u32,
    /// What lays it.
    tool: Tool,
    waypoints: Vec<Waypoint>,
    tangents: Vec<Vector3<f64>>,
    /// Seconds at each.
    times: Vec<f64>,
    none: Vec<f64>,
    /// Millimetres of tape by each.
    arcs: Vec<f64>,
}

impl Placed {
    /// Tapes of a list, which lie on layer `layer` of the scene; `frame` maps the part to the plate.
    pub fn list(list: &LayerTapes, layer: u32, head: &TapeHead, frame: &Isometry3<f64>) -> Vec<Placed> {
        list.tapes.iter().map(|tape| Placed::new(tape, (layer, list.tool, list.lift), head, frame)).collect()
    }

    fn new(tape: &Tape, (layer, tool, lift): (u32, Tool, f64), head: &TapeHead, frame: &Isometry3<f64>) -> Self {
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
            tool,
            tangents: (0..points.len()).map(tangent).collect(),
            times: arcs.iter().map(|arc| arc / head.lay_feed).collect(),
            none: vec![0.0; points.len()],
            waypoints,
            arcs,
        }
    }

    /// Where its contact line goes, over the plate.
    pub fn line(&self) -> impl Iterator<Item = Point3<f64>> {
        self.waypoints.iter().map(|waypoint| waypoint.position)
    }

    fn path(&self) -> PrintPath<'_> {
        PrintPath { layer: self.layer, waypoints: &self.waypoints, times: &self.times, filament_mm: &self.none }
    }
}

/// Directions along tapes, by place.
struct Directions<'a> {
    tapes: &'a [Placed],
    /// Tape and point at which a segment begins, by the cells that it passes through.
    cells: HashMap<[i64; 3], Vec<(usize, usize)>>,
}

impl<'a> Directions<'a> {
    fn new(tapes: &'a [Placed]) -> Self {
        let mut cells: HashMap<[i64; 3], Vec<(usize, usize)>> = HashMap::new();
        for (number, tape) in tapes.iter().enumerate() {
            for (k, ends) in tape.waypoints.windows(2).enumerate() {
                let [from, to] = [0, 1].map(|end| ends[end].position);
                let steps = ((to - from).norm() / (0.5 * NEAR_MM)).ceil().max(1.0) as u32;
                for step in 0..=steps {
                    let here =
                        cells.entry(cell_of(from + (to - from) * (f64::from(step) / f64::from(steps)))).or_default();
                    if here.last() != Some(&(number, k)) {
                        here.push((number, k));
                    }
                }
            }
        }
        Directions { tapes, cells }
    }

    /// The direction of the nearest tape, evenly from point to point.
    fn at(&self, at: &Point3<f64>) -> Vector3<f64> {
        let [x, y, z] = cell_of(*at);
        let around = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |l| [x + i, y + j, z + l])));
        let near = self.nearest(at, around.filter_map(|cell| self.cells.get(&cell)).flatten().copied());
        let all =
            || (0..self.tapes.len()).flat_map(|tape| (1..self.tapes[tape].waypoints.len()).map(move |k| (tape, k - 1)));
        near.or_else(|| self.nearest(at, all())).unwrap_or_else(Vector3::x)
    }

    fn nearest(&self, at: &Point3<f64>, segments: impl Iterator<Item = (usize, usize)>) -> Option<Vector3<f64>> {
        let found = segments.map(|(number, k)| {
            let tape = &self.tapes[number];
            let (from, way) = (tape.waypoints[k].position, tape.waypoints[k + 1].position - tape.waypoints[k].position);
            let share = ((at - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            let distance = (from + way * share - at).norm_squared();
            (distance, (number, k), tape.tangents[k] * (1.0 - share) + tape.tangents[k + 1] * share)
        });
        found.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|found| found.2)
    }

    /// The tool angle at which the x axis of the tool frame looks along the tape.
    fn heading(&self, waypoint: &Waypoint) -> f64 {
        let plain = curvlay_kinematics::Waypoint { position: waypoint.position, axis: waypoint.axis }.frame(0.0);
        let along = self.at(&waypoint.position);
        along.dot(&(plain * Vector3::y())).atan2(along.dot(&(plain * Vector3::x())))
    }
}

fn cell_of(at: Point3<f64>) -> [i64; 3] {
    [at.x, at.y, at.z].map(|x| (x / NEAR_MM).floor() as i64)
}

/// The cell with its roller in the place of the nozzle, mounted as the workcell says, or else so that the most waypoints can be reached on one branch along
/// each tape, with the clearance that postures keep; the first of the best. And how that is, in radians.
pub fn mounted(
    cell: &SixAxisWorkcell,
    tapes: &[Placed],
    part: &PartCells,
    plate_mm: f64,
) -> Result<(SixAxisWorkcell, f64), Failure> {
    let roller = cell.equipment().model().roller.unwrap_or_default();
    if let Some(degrees) = roller.mount_deg {
        return Ok((cell.with_roller(roller, degrees.to_radians())?, degrees.to_radians()));
    }
    let step = tapes.len().div_ceil(MOUNT_TAPES).max(1);
    let directions = Directions::new(tapes);
    let tried: Vec<(&Placed, Vec<f64>)> = tapes
        .iter()
        .step_by(step)
        .map(|tape| (tape, tape.waypoints.iter().map(|waypoint| directions.heading(waypoint)).collect()))
        .collect();
    let mut best: Option<(usize, f64, SixAxisWorkcell)> = None;
    for mount in (0..MOUNTS).map(|k| TAU * f64::from(k) / f64::from(MOUNTS)) {
        let with_roller = cell.with_roller(roller, mount)?;
        let mut built =
            PrintingCell::pressing(GrowingScene::new(&with_roller, part, plate_mm, &GrowingOptions::default())?);
        built.begin_and_build(u32::MAX).map_err(Failure::new)?;
        let robot = OnCell::new(with_roller.clone(), Vec::new());
        let count = tried.iter().map(|(tape, headings)| unbroken(&robot, tape, headings, mount, &built)).sum();
        if best.as_ref().is_none_or(|best| count > best.0) {
            best = Some((count, mount, with_roller));
        }
    }
    best.map(|(_, mount, cell)| (cell, mount)).ok_or_else(|| Failure::new("the roller has no way to be mounted"))
}

/// Waypoints of the longest part of a tape that one branch of the arm follows, able to lift off at each of them.
fn unbroken(
    robot: &OnCell<SixAxisWorkcell>,
    tape: &Placed,
    headings: &[f64],
    mount: f64,
    cell: &PrintingCell<'_, 6, 1, SixAxisWorkcell>,
) -> usize {
    let limits = robot.workcell().limits();
    let is_inside = |joints: &[f64; 6]| (0..6).all(|j| (limits.lower[j]..=limits.upper[j]).contains(&joints[j]));
    let mut longest = 0;
    let mut by_branch: BTreeMap<u32, usize> = BTreeMap::new();
    for (waypoint, heading) in tape.waypoints.iter().zip(headings) {
        let mut goes_on = BTreeMap::new();
        let angle = heading - mount;
        let above = Waypoint { position: waypoint.position + waypoint.axis.into_inner() * LIFTED_MM, ..*waypoint };
        PrintRobot::solutions(robot, waypoint, &[angle], &mut |branch, joints: [f64; 6]| {
            if !(is_inside(&joints) && cell.keeps(&joints, Clearance::Wide)) {
                return;
            }
            // The roller must be able to lift off.
            let lifted = PrintRobot::continued(robot, &above, &[angle], 0.0, &joints);
            if lifted.is_some_and(|lifted| is_inside(&lifted) && cell.in_the_way(&lifted).is_none()) {
                goes_on.insert(branch, by_branch.get(&branch).copied().unwrap_or(0) + 1);
            }
        });
        longest = goes_on.values().copied().fold(longest, usize::max);
        by_branch = goes_on;
    }
    longest
}

/// Motions along tapes, from home and back to it.
pub struct TapeMotion {
    /// The workcell with its roller.
    pub cell: SixAxisWorkcell,
    /// The tapes, in the order in which they are laid.
    pub placed: Vec<Placed>,
    /// Their motions.
    pub plan: PrintPlan<6, 1>,
    /// How far the roller is turned away from the tapes at most, of the motion as it is, in radians.
    pub max_turn: f64,
}

/// Plans the motions along tapes.
///
/// # Arguments
/// * `cell`, `mount`: with the roller in its place ([`mounted`]).
/// * `placed`: tapes of which none lies closely over others: the roller looks along the nearest one, also while it lifts off.
/// * `part`: in the layers that the tapes name: a tape lies on its own and all before it.
/// * `home`: where the tapes begin and end; `None` for a posture above the part.
pub fn along_tapes(
    (cell, mount): (&SixAxisWorkcell, f64),
    placed: Vec<Placed>,
    part: &PartCells,
    plate_mm: f64,
    home: Option<&[f64; 6]>,
    bars: &Bars,
) -> Result<TapeMotion, Failure> {
    let robot = OnCell::new(cell.clone(), Vec::new());
    let scene = PrintingCell::pressing(GrowingScene::new(cell, part, plate_mm, &GrowingOptions::default())?);
    let limits = PrintLimits { tolerance_mm: TOLERANCE_MM, ..PrintLimits::of(bounds_of(cell.limits())) };
    let paths: Vec<PrintPath> = placed.iter().map(Placed::path).collect();
    let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
    let options = PrintOptions::default();
    let directions = Directions::new(&placed);
    let steered =
        Steered { robot: &robot, heading: |waypoint: &Waypoint| directions.heading(waypoint) - mount, slack: SLACK };
    let plan = plan_print(&steered, scene.clone(), &paths, &limits, &options, &progress)?;
    // A tape without its end is not cut, and one without its start is not fed: it is laid whole or not at all.
    let plan = plan.without(&unfinished(&plan, &placed));
    let plan = match home {
        None => from_home(&plan, &BTreeSet::new(), &steered, scene, (&limits, &options), &progress)?,
        Some(home) => {
            let mut built = scene.clone();
            for layer in &plan.layers {
                built.begin_and_build(layer.layer).map_err(Failure::new)?;
            }
            if let Some(what) = built.in_the_way(home) {
                return Err(Failure::new(format!(
                    "{what} touch at the home posture with the roller in place: give `home_deg`"
                )));
            }
            plan.with_homes(&steered, scene, home, &BTreeSet::new(), &limits, &options, &progress)?
        }
    };
    let max_turn = turned(&robot, &plan, &directions, mount);
    drop((paths, directions));
    Ok(TapeMotion { cell: cell.clone(), placed, plan, max_turn })
}

/// The motions along tapes that do not go from their first waypoint to their last, by their number among all motions.
fn unfinished(plan: &PrintPlan<6, 1>, placed: &[Placed]) -> BTreeSet<usize> {
    let is_whole = |run: &Run<6, 1>| {
        let mut passed = run.passes.iter().filter_map(|(_, waypoint)| *waypoint);
        let first = passed.next();
        let last = passed.next_back();
        first == Some(0) && last == Some(placed[run.path].waypoints.len() - 1)
    };
    let legs = plan.segments(0..plan.runs.len()).enumerate();
    let of_part = legs.filter(|(_, leg)| leg.kind == SegmentKind::Print && !is_whole(leg.run));
    of_part.map(|(number, _)| number).collect()
}

impl TapeMotion {
    /// The steps of some runs on one layer: tool, heat, and the tapes with the signals of the head, as late as the arm is behind its stream.
    pub fn stream<'a>(&'a self, runs: Range<usize>, head: &'a TapeHead) -> impl Iterator<Item = Step> + 'a {
        let steps = stream(self, runs.clone(), head, StreamOptions::of_workcell(self.cell.equipment()));
        let first = self.plan.segments(runs.clone()).next().map(|leg| by_joints(leg.at(0.0)));
        let tool = self.tool_of(&runs);
        first.into_iter().chain(Self::on(tool, head)).chain(steps).chain(Self::off(tool, head))
    }

    /// The same as targets on the part.
    pub fn targets<'a>(&'a self, runs: Range<usize>, head: &'a TapeHead) -> impl Iterator<Item = Step> + 'a {
        let first = self.plan.segments(runs.clone()).next().map(|leg| by_joints(leg.at(0.0)));
        let tool = self.tool_of(&runs);
        let steps = targets(self, runs, head);
        first.into_iter().chain(Self::on(tool, head)).chain(steps).chain(Self::off(tool, head))
    }

    fn tool_of(&self, runs: &Range<usize>) -> HeadSignal {
        let run = self.plan.runs.get(runs.start);
        match run.map(|run| self.placed[run.path].tool) {
            Some(Tool::Conductor) => HeadSignal::Conductor,
            _ => HeadSignal::Roller,
        }
    }

    /// The roller comes, and gets hot.
    fn on(tool: HeadSignal, head: &TapeHead) -> impl Iterator<Item = Step> + use<> {
        let heat = [Step::Signal { signal: HeadSignal::Heat, on: true }, Step::Wait(HeadInput::Hot)];
        let heat = heat.into_iter().filter({
            let is_hot = head.celsius > 0.0;
            move |_| is_hot
        });
        [Step::Signal { signal: tool, on: true }, Step::Wait(HeadInput::ToolReady)].into_iter().chain(heat)
    }

    /// The nozzle comes back.
    fn off(tool: HeadSignal, head: &TapeHead) -> impl Iterator<Item = Step> + use<> {
        let heat = (head.celsius > 0.0).then_some(Step::Signal { signal: HeadSignal::Heat, on: false });
        heat.into_iter().chain([Step::Signal { signal: tool, on: false }, Step::Wait(HeadInput::ToolReady)])
    }
}

fn by_joints(joints: [f64; 6]) -> Step {
    Step::Move(Move { goal: Goal::Joints(joints), table: None, speed: Speed::default(), zone: Zone::Stop })
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
    let cell = six_axes(cell)?;
    if !programs::takes_stream(cell.equipment()).map_err(Failure::new)? {
        return Err(Failure::of_arguments(
            "programs of the arc are URScript: give a workcell with an arm of Universal Robots",
        ));
    }
    let frame = centred_on_plate(planned.tapes.iter().flat_map(|layer| &layer.tapes).flat_map(|tape| &tape.points));
    // The mould is layer 0 of the scene.
    let placed: Vec<Placed> =
        planned.tapes.iter().flat_map(|list| Placed::list(list, list.layer + 1, head, &frame)).collect();
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
    let (with_roller, mount) = mounted(cell, &placed, &part, PLATE_MM)?;
    let motion = along_tapes((&with_roller, mount), placed, &part, PLATE_MM, None, bars)?;
    let plan = &motion.plan;
    let mut moved = Moved {
        cell: cell.equipment().name().to_owned(),
        runs: plan.runs.len(),
        tapes: motion.placed.len(),
        robot_s: plan.robot_s(),
        max_deviation_mm: plan.max_deviation_mm,
        max_turn: motion.max_turn,
        mount,
        faults: plan.faults.clone(),
        files: BTreeMap::new(),
    };
    for (number, piece) in programs::pieces(plan).into_iter().enumerate() {
        let name = format!("{}_tapes_{:03}", planned.specimen.name, number + 1);
        let options = UrScriptOptions { name: name.clone(), ..UrScriptOptions::of_workcell(cell.equipment()) };
        let mut file = Vec::new();
        write_urscript(motion.stream(piece, head), &options, &mut file)?;
        moved.files.insert(format!("{name}.script"), file);
    }
    Ok(moved)
}

/// The arm without a table that lays tapes.
pub fn six_axes(cell: &AnyWorkcell) -> Result<&SixAxisWorkcell, Failure> {
    match cell {
        AnyWorkcell::Six(cell) => Ok(cell),
        AnyWorkcell::Seven(_) | AnyWorkcell::Eight(_) => Err(Failure::of_arguments(
            "--workcell: the tapes are laid by an arm without a table or a track: give a workcell of six axes",
        )),
    }
}

/// How far the tool is turned away from the tapes at most, of the motion as it is.
fn turned(robot: &OnCell<SixAxisWorkcell>, plan: &PrintPlan<6, 1>, directions: &Directions, mount: f64) -> f64 {
    let mut most: f64 = 0.0;
    for joints in plan.runs.iter().flat_map(|run| run.trajectory.joints()) {
        let Some(tool) = PrintRobot::nozzle(robot, joints) else { continue };
        let along = directions.at(&Point3::from(tool.translation.vector));
        let (x, y) = (tool * Vector3::x(), tool * Vector3::y());
        let turn = along.dot(&y).atan2(along.dot(&x)) - mount;
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

/// Signals of the head along a run.
fn signals_of(run: &Run<6, 1>, tape: &Placed, head: &TapeHead) -> Vec<TimedSignal> {
    let at = |time_s: f64, signal: HeadSignal, on: bool| TimedSignal { time_s, signal, on };
    let duration = run.duration();
    let mut signals = vec![at(0.0, HeadSignal::Press, true)];
    if let Some(cut) = cut_at(run, tape, head.blade) {
        signals.extend([at(cut, HeadSignal::Cut, true), at(duration, HeadSignal::Cut, false)]);
    }
    signals.push(at(duration, HeadSignal::Press, false));
    signals
}

/// The motion at every tick, with the signals of the head, as late as `options` say that the arm is behind its stream.
fn stream<'a>(
    motion: &'a TapeMotion,
    runs: Range<usize>,
    head: &'a TapeHead,
    options: StreamOptions,
) -> impl Iterator<Item = Step> + 'a {
    let (plan, placed) = (&motion.plan, &motion.placed);
    let at = |time_s: f64, signal: HeadSignal, on: bool| TimedSignal { time_s, signal, on };
    let feed_s = head.blade / FEED_MM_S;
    let start = plan.segments(runs.clone()).next().map_or([0.0; 6], |leg| leg.at(0.0));
    let stop = plan.segments(runs.clone()).last().map_or(start, |leg| leg.at(leg.duration()));
    type Joints<'a> = Box<dyn Fn(f64) -> [f64; 6] + 'a>;
    let feeding = move |joints: [f64; 6]| StreamSegment {
        duration_s: feed_s,
        joints: Box::new(move |_| joints) as Joints,
        filament_mm: None::<fn(f64) -> f64>,
        signals: vec![at(0.0, HeadSignal::Feed, true), at(feed_s, HeadSignal::Feed, false)],
    };
    let legs = plan.segments(runs).flat_map(move |leg| {
        let is_laid = leg.kind == SegmentKind::Print;
        let before = (leg.kind == SegmentKind::Approach).then(|| feeding(leg.at(0.0)));
        let motion = StreamSegment {
            duration_s: leg.duration(),
            joints: Box::new(move |time| leg.at(time)) as Joints,
            filament_mm: None,
            signals: if is_laid { signals_of(leg.run, &placed[leg.run.path], head) } else { Vec::new() },
        };
        before.into_iter().chain([motion])
    });
    print_stream([start, stop], legs, options)
}

/// The motions as targets: the ways as postures, tapes from waypoint to waypoint with a stop where they are cut. Tape is fed above the start of each.
fn targets<'a>(motion: &'a TapeMotion, runs: Range<usize>, head: &'a TapeHead) -> impl Iterator<Item = Step> + 'a {
    let plan = &motion.plan;
    let steps = |motions: TargetMotion<6>| print_targets(&motion.cell, [motions], TargetOptions::default());
    let way = move |onward: &[[f64; 6]]| steps(TargetMotion { onward: onward.to_vec(), ..TargetMotion::default() });
    let signal = |on: bool| Step::Signal { signal: HeadSignal::Feed, on };
    let first = runs.start;
    runs.flat_map(move |number| {
        let run = &plan.runs[number];
        let tape = &motion.placed[run.path];
        let (arrival, departure) = plan.homes.get(number).map_or((None, None), |(a, d)| (a.as_ref(), d.as_ref()));
        let before = number.checked_sub(1).filter(|_| number > first).and_then(|before| plan.travels[before].as_ref());
        let to = arrival.map(|arrival| arrival.postures(LIFT_POSTURES));
        let to = to.or(before.map(|travel| travel.postures(LIFT_POSTURES))).unwrap_or_default();
        // The last of them go down to the start.
        let (over, down) = to.split_at(to.len().saturating_sub(LIFT_POSTURES as usize));
        let begin = run.trajectory.times()[0];
        let mut times: Vec<f64> = run.passes.iter().map(|(knot, _)| run.trajectory.times()[*knot]).collect();
        // The arm stops at the very cut.
        times.extend(cut_at(run, tape, head.blade).map(|cut| begin + cut));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|later, earlier| *later - *earlier < SAME_S);
        let knot =
            |time_s: &f64| PrintKnot { time_s: *time_s, joints: run.trajectory.at(*time_s).position, filament_mm: 0.0 };
        let knots: Vec<PrintKnot<6>> = times.iter().map(knot).collect();
        let laid = TargetMotion { knots, onward: Vec::new(), head: Some(signals_of(run, tape, head)) };
        let home = departure.map(|departure| departure.postures(LIFT_POSTURES)).unwrap_or_default();
        let mut all: Vec<Step> = way(over).collect();
        all.extend([signal(true), Step::Wait(HeadInput::Fed), signal(false)]);
        all.extend(way(down).chain(steps(laid)).chain(way(&home)));
        all
    })
}
