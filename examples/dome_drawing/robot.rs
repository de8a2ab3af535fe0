//! The robot: an arm, in the thesis an IRB 120, that holds the platform under a nozzle. Its program, and the checks of it.

use super::saved::Plan;
use super::stream::Command;
use super::{Args, stream};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_kinematics::program::link::{
    LinkMessage, LinkOptions, LinkProgress, LinkRapidOptions, LinkTranslator, MAX_NUMBER, write_link_rapid,
};
use curvlay_kinematics::program::{
    DomeOptions, DomePrint, DomeRig, DomeRun, Goal, Move, PrintedStroke, ProgramLimits, RapidOptions, RapidWritten,
    Step, print_on_dome, read_rapid, run_on_dome, write_rapid,
};
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, links};
use curvlay_kinematics::{Arm, nozzle_frame};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::io::{self, Write};
use std::rc::Rc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The name of the program.
pub const NAME: &str = "drawing";

/// The body of the nozzle begins so far above its tip, in millimetres: the tip touches the platform.
const SKIN_MM: f64 = 0.5;

/// Ways up to a stroke are straight moves; so many pieces of them are proven as moves by joints, which are apart from them by micrometres.
const PLUNGE_PIECES: u32 = 6;

/// The shortest pieces of a way that are looked at, in millimetres. Near the platform longer than [`SKIN_MM`] would prove nothing.
const WAY_RESOLUTION_MM: f64 = 0.1;

/// The nozzle goes over the platform at the speed that was planned within this, as a share.
pub const EVEN: f64 = 0.02;

/// Waypoints at most so far apart, in millimetres, are looked at in the scene.
const CHECK_EVERY_MM: f64 = 5.0;

/// Every target comes back from the program within this, in millimetres.
const ROUND_TRIP_MM: f64 = 1e-3;

/// Joints of a move that is read back are those that were planned within this, in radians: programs have four digits of a degree or more.
const SAME_JOINT: f64 = 1e-5;

/// Joints at the end of a stroke to which straight moves lead, each to the nearest ones, are those that were planned within this, in radians:
/// poses have four digits of a millimetre. Another posture or another turn of an axis is a thousand times as far.
const SAME_END: f64 = 1e-3;

/// A program in memory.
pub struct Program {
    pub print: DomePrint,
    pub files: BTreeMap<String, Vec<u8>>,
    pub written: RapidWritten,
}

/// A program that is checked.
pub struct Printed {
    pub program: Program,
    pub seconds: Duration,
    /// Bodies that touch, and how often.
    pub touching: BTreeMap<String, usize>,
    pub checked: usize,
    pub blocked_travels: usize,
    /// Largest distance of a target read back.
    pub round_trip_mm: f64,
    pub targets_read: usize,
    /// Moves between strokes, as read back, that are neither away from one nor to the next: returns home.
    pub returns_home: usize,
    /// What the program does, as read back.
    pub run: DomeRun,
    /// Strokes of the program at the end of which the joints are not those that were planned.
    pub off_course: usize,
}

impl Printed {
    pub fn axis6_span_deg(&self) -> f64 {
        (self.program.print.axis6[1] - self.program.print.axis6[0]).to_degrees()
    }

    /// Turns of the extruder in all.
    pub fn extruder_turns(&self) -> f64 {
        self.run.fed / 60.0
    }

    /// Volume of the beads that the program lays: as wide as the extruder turns fast, and as high as a layer.
    pub fn material_mm3(&self, args: &Args) -> f64 {
        self.run.fed_mm / args.setup.rpm_per_mm() * args.layer_height_mm
    }

    /// Whether the nozzle goes evenly over the platform.
    pub fn is_even(&self, wanted: f64) -> bool {
        self.run.speed_mm_s.iter().all(|speed| (speed / wanted - 1.0).abs() <= EVEN)
    }

    pub fn read_back(&self) -> bool {
        self.round_trip_mm <= ROUND_TRIP_MM && self.targets_read == self.program.print.points()
    }
}

/// Bytes that a writer fills while it is elsewhere.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Plans the motion and writes the program into memory.
pub fn program(args: &Args, plan: &Plan, bars: &Bars) -> Result<Program, Failure> {
    bars.update("robot", 4, 5);
    let arm = Arm::new(args.setup.arm())?;
    let strokes = plan.dome_strokes();
    let options = args.setup.options(args.nozzle_height_mm);
    let print = print_on_dome(&args.setup.rig(), &arm, &strokes, &options);
    if print.strokes.is_empty() {
        let first = print.faults.first().map_or_else(|| "there is no stroke".to_owned(), ToString::to_string);
        return Err(Failure::new(format!("nothing can be printed: {first}")));
    }
    let rapid = RapidOptions {
        name: NAME.to_owned(),
        filament_signal: "aoExtruderRpm".to_owned(),
        moves_per_module: args.moves_per_module,
        // Joints run along the borders of quarter turns; the check follows them through the program.
        monitor_lines: false,
        limits: ProgramLimits::of_arm(&arm),
        arm: Some(arm),
        ..RapidOptions::default()
    };
    let mut files: Vec<(String, Shared)> = Vec::new();
    let written = write_rapid(print.steps(&options), &rapid, |name| {
        let file = Shared::default();
        files.push((name.to_owned(), file.clone()));
        Ok(file)
    })?;
    let link = LinkRapidOptions {
        name: NAME.to_owned(),
        queue: args.queue,
        home: home(&arm, &print, &options),
        ..LinkRapidOptions::default()
    };
    write_link_rapid(&link, |name| {
        let file = Shared::default();
        files.push((name.to_owned(), file.clone()));
        Ok(file)
    })?;
    let files = files.into_iter().map(|(name, file)| (name, file.0.take())).collect();
    Ok(Program { print, files, written })
}

/// The home position of a stream: the pole below the nozzle, at the distance that it has between strokes.
fn home(arm: &Arm, print: &DomePrint, options: &DomeOptions) -> [f64; 6] {
    let mut pose = arm.forward(&print.home);
    pose.translation.z -= options.hop_mm;
    arm.continuing(&pose, &print.home).unwrap_or(print.home)
}

/// Streams the program: all its steps, then home.
pub fn stream(
    args: &Args,
    address: &str,
    printed: &Printed,
    commands: &Receiver<Command>,
    bars: &Bars,
) -> Result<LinkProgress, Failure> {
    let options = args.setup.options(args.nozzle_height_mm);
    let messages = || LinkTranslator::new(printed.program.print.steps(&options), args.pulse_reverse_ms);
    let total = messages().count() as u64 + 1;
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    // Another number for each job, unless two begin within a second.
    let job = (seconds % u64::from(MAX_NUMBER)) as u32 + 1;
    let link = LinkOptions {
        job,
        queue: args.queue,
        retry: Duration::from_secs_f64(args.stream_retry_s),
        max_tries: args.stream_tries,
        max_pause: LinkOptions::default().max_pause.max(Duration::from_secs_f64(args.stream_retry_s)),
    };
    let messages = messages().chain([Ok(LinkMessage::Home)]);
    let report = |progress: &LinkProgress| bars.update("stream", u64::from(progress.done), total);
    stream::stream(address, messages, link, commands, &stream::SystemClock::start(), report)
        .map_err(|error| Failure::new(format!("--stream: {error}")))
}

/// Where the platform is in the hand.
fn flange_platform(rig: &DomeRig) -> Isometry3<f64> {
    Isometry3::translation(0.0, 0.0, -rig.effector)
}

/// The tip of the nozzle on the platform, and which way is up there.
pub fn on_platform(rig: &DomeRig, base_flange: &Isometry3<f64>) -> (Point3<f64>, UnitVector3<f64>) {
    let platform = base_flange * flange_platform(rig);
    (
        platform.inverse_transform_point(&rig.contact()),
        platform.rotation.inverse_transform_unit_vector(&Vector3::z_axis()),
    )
}

/// The scene: the arm, the platform in its hand, and the nozzle.
fn scene(args: &Args, plan: &Plan, arm: Arm) -> Result<Scene, Failure> {
    let rig = args.setup.rig();
    let tip = rig.contact() + Vector3::z() * SKIN_MM;
    let nozzle = nozzle_frame(&tip, &-Vector3::z_axis());
    let circle = |radius: f64, z: f64| {
        (0..12).map(move |k| TAU * f64::from(k) / 12.0).map(move |a| Point3::new(radius * a.cos(), radius * a.sin(), z))
    };
    // A flat tip of 1 mm, a cone of 45 degrees, and a block of 20 mm.
    let cone = Shape::Hull { points: circle(0.5, 0.0).chain(circle(8.5, 8.0)).collect(), radius: 0.0 };
    let body = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
    let bodies = vec![
        body("platform", Mount::Link(6), flange_platform(&rig), plan.shape()),
        body("nozzle", Mount::Base, nozzle, cone),
        body("hot end", Mount::Base, nozzle, Shape::cylinder(10.0, 8.0, 60.0)),
    ];
    Ok(Scene::new(SceneModel { links: links(args.setup.arm()), bodies, ..SceneModel::of(arm) })?)
}

/// Looks at the postures in the scene, at the ways between strokes, and reads the program back.
pub fn check(args: &Args, plan: &Plan, program: Program, seconds: Duration, bars: &Bars) -> Result<Printed, Failure> {
    let arm = Arm::new(args.setup.arm())?;
    let scene = scene(args, plan, arm)?;
    let hop_mm = args.setup.options(args.nozzle_height_mm).hop_mm;
    let mut touching: BTreeMap<String, usize> = BTreeMap::new();
    let (mut checked, mut blocked_travels) = (0, 0);
    let mut before: Option<[f64; 6]> = None;
    let total = program.print.strokes.len() as u64;
    for (number, stroke) in program.print.strokes.iter().enumerate() {
        bars.update("check", number as u64, total);
        let last = stroke.joints.len() - 1;
        let mut next = 0.0;
        for (k, joints) in stroke.joints.iter().enumerate() {
            if stroke.lengths[k] < next && k < last {
                continue;
            }
            next = stroke.lengths[k] + CHECK_EVERY_MM;
            checked += 1;
            if let Some([a, b]) = scene.touching(&(*joints).into())? {
                *touching.entry(format!("{a} and {b}")).or_default() += 1;
            }
        }
        let mut way: Vec<[f64; 6]> = before.into_iter().collect();
        way.extend(plunge(&arm, stroke, hop_mm));
        let up = is_free(&scene, &way)?;
        let down = is_free(&scene, &[stroke.joints[last], stroke.below[1]])?;
        blocked_travels += usize::from(!up) + usize::from(!down);
        before = Some(stroke.below[1]);
    }
    let ReadBack { off_mm: round_trip_mm, targets: targets_read, returns_home, run, off_course } =
        read_back(&program, &args.setup.rig(), &arm)?;
    Ok(Printed {
        program,
        seconds,
        touching,
        checked,
        blocked_travels,
        round_trip_mm,
        targets_read,
        returns_home,
        run,
        off_course,
    })
}

/// Joints from below a stroke straight up to its begin.
fn plunge(arm: &Arm, stroke: &PrintedStroke, hop_mm: f64) -> Vec<[f64; 6]> {
    let mut way = vec![stroke.below[0]];
    for k in 1..PLUNGE_PIECES {
        let mut pose = stroke.poses[0];
        pose.translation.z -= hop_mm * (1.0 - f64::from(k) / f64::from(PLUNGE_PIECES));
        way.extend(arm.continuing(&pose, &way[way.len() - 1]));
    }
    way.push(stroke.joints[0]);
    way
}

fn is_free(scene: &Scene, way: &[[f64; 6]]) -> Result<bool, Failure> {
    for pair in way.windows(2) {
        if !scene.is_free(&pair[0].into(), &pair[1].into(), WAY_RESOLUTION_MM)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What the program holds, as our own reader reads it.
struct ReadBack {
    /// Largest distance of a target from the plan, and how many there are.
    off_mm: f64,
    targets: usize,
    /// Moves by joints that lead neither below the begin nor below the end of a stroke.
    returns_home: usize,
    run: DomeRun,
    /// Strokes that end at other joints than planned.
    off_course: usize,
}

fn read_back(program: &Program, rig: &DomeRig, arm: &Arm) -> Result<ReadBack, Failure> {
    let open = |path: &str| {
        let name = path.rsplit(['/', ':', '\\']).next().unwrap_or(path);
        let file = program.files.iter().find(|(file, _)| file.eq_ignore_ascii_case(name));
        file.map(|(_, bytes)| bytes.as_slice()).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, name.to_owned()))
    };
    let main = open(&format!("{NAME}.mod"))?;
    let mut planned = program.print.strokes.iter().flat_map(|stroke| &stroke.poses);
    let mut below = program.print.strokes.iter().flat_map(|stroke| stroke.below).peekable();
    let (mut off_mm, mut targets, mut returns_home) = (0.0f64, 0, 0);
    let steps: Vec<Step> = read_rapid(main, open)?.collect::<Result<_, _>>()?;
    for step in &steps {
        match step {
            Step::Move(Move { goal: Goal::Line(target), .. }) => {
                targets += 1;
                // Of the platform's rim, the farthest point that the pose moves.
                let off = planned.next().map_or(f64::INFINITY, |pose| {
                    let turn = target.pose.rotation.angle_to(&pose.rotation);
                    (target.pose.translation.vector - pose.translation.vector).norm() + 250.0 * turn
                });
                off_mm = off_mm.max(off);
            }
            Step::Move(Move { goal: Goal::Joints(joints), .. }) => {
                let is_at = |planned: &[f64; 6]| joints.iter().zip(planned).all(|(a, b)| (a - b).abs() <= SAME_JOINT);
                returns_home += usize::from(below.next_if(is_at).is_none());
            }
            _ => {}
        }
    }
    let run = run_on_dome(rig, arm, steps);
    let ends = run.strokes.iter().zip(&program.print.strokes);
    let is_off = |ours: &[f64; 6], planned: &[f64; 6]| ours.iter().zip(planned).any(|(a, b)| (a - b).abs() > SAME_END);
    let off = ends.filter(|(ours, planned)| planned.joints.last().is_none_or(|end| is_off(&ours.joints, end))).count();
    let off_course = off + run.strokes.len().abs_diff(program.print.strokes.len());
    Ok(ReadBack { off_mm, targets, returns_home, run, off_course })
}

#[cfg(test)]
mod tests {
    use super::{NAME, Program, read_back};
    use curvlay_kinematics::nalgebra::Isometry3;
    use curvlay_kinematics::program::{
        ConfData, DomeOptions, DomePrint, DomeRig, Goal, Move, PrintedStroke, RapidOptions, Speed, Step, Zone,
        write_rapid,
    };
    use curvlay_kinematics::{Arm, robots};

    /// A program of two strokes, with what comes after each.
    fn read(after: &[Step]) -> super::ReadBack {
        let stroke = |x: f64| PrintedStroke {
            stroke: 0,
            poses: vec![Isometry3::translation(x, 0.0, 600.0), Isometry3::translation(x + 1.0, 0.0, 600.0)],
            joints: vec![[0.0; 6]; 2],
            confs: vec![ConfData::default(); 2],
            below: [[0.1 * x; 6], [0.2 * x; 6]],
            lengths: vec![0.0, 1.0],
            feed: 1.0,
        };
        let print = DomePrint { strokes: vec![stroke(1.0), stroke(2.0)], ..DomePrint::default() };
        let options = DomeOptions::default();
        let steps = print.strokes.iter().flat_map(|stroke| {
            let one = DomePrint { strokes: vec![stroke.clone()], ..DomePrint::default() };
            one.steps(&options).chain(after.iter().copied()).collect::<Vec<_>>()
        });
        let rapid = RapidOptions { name: NAME.to_owned(), ..RapidOptions::default() };
        let mut files = Vec::new();
        let written = write_rapid(steps, &rapid, |name| {
            let file = super::Shared::default();
            files.push((name.to_owned(), file.clone()));
            Ok(file)
        })
        .unwrap();
        let files = files.into_iter().map(|(name, file)| (name, file.0.take())).collect();
        let arm = Arm::new(&robots::IRB120).unwrap();
        read_back(&Program { print, files, written }, &DomeRig::BROOKS, &arm).unwrap()
    }

    #[test]
    fn moves_that_belong_to_no_stroke_are_counted() {
        let plain = read(&[]);
        assert_eq!((plain.targets, plain.returns_home), (4, 0));
        assert!(plain.off_mm < 1e-3);
        let home =
            Step::Move(Move { goal: Goal::Joints([0.0; 6]), table: None, speed: Speed::default(), zone: Zone::Stop });
        assert_eq!(read(&[home]).returns_home, 2);
    }
}
