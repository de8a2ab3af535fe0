//! The slow twin of plans: every motion at a thousand places, by the forward kinematics.

use curvlay_kinematics::machine::{
    AxisMove, AxisPlanOptions, AxisPlanSummary, AxisStep, FiveAxis, MachineKind, PathMove, plan_axes,
};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// Motions for each move, and what the plan says of itself.
pub struct Planned {
    pub of_moves: Vec<Vec<AxisMove>>,
    pub summary: AxisPlanSummary,
}

pub fn travel<T>(tip: [f64; 3], direction: [f64; 3]) -> PathMove<T> {
    PathMove::Travel { tip: tip.into(), direction: UnitVector3::new_normalize(direction.into()), feed_mm_s: 60.0 }
}

pub fn print<T>(tip: [f64; 3], direction: [f64; 3]) -> PathMove<T> {
    let direction = UnitVector3::new_normalize(direction.into());
    PathMove::Print { tip: tip.into(), direction, filament_mm: 0.25, feed_mm_s: 20.0 }
}

/// Plans with a mark before each move, by which motions belong to moves.
pub fn planned(machine: &FiveAxis, moves: &[PathMove<usize>], options: AxisPlanOptions) -> Result<Planned, String> {
    let marked = moves.iter().enumerate().flat_map(|(k, step)| [PathMove::Pass(k), *step]);
    let mut plan = plan_axes(machine, marked, options).map_err(|error| error.to_string())?;
    let mut of_moves: Vec<Vec<AxisMove>> = vec![];
    for step in &mut plan {
        match step.map_err(|error| error.to_string())? {
            AxisStep::Pass(k) => {
                assert_eq!(k, of_moves.len());
                of_moves.push(vec![]);
            }
            AxisStep::Move(motion) => of_moves.last_mut().unwrap().push(motion),
        }
    }
    Ok(Planned { of_moves, summary: *plan.summary() })
}

pub fn target(step: &PathMove<usize>) -> (Point3<f64>, UnitVector3<f64>) {
    match *step {
        PathMove::Travel { tip, direction, .. } | PathMove::Print { tip, direction, .. } => (tip, direction),
        _ => panic!("no move of the tip"),
    }
}

fn between(a: &[f64; 5], b: &[f64; 5], share: f64) -> [f64; 5] {
    [0, 1, 2, 3, 4].map(|k: usize| a[k] + (b[k] - a[k]) * share)
}

fn from_line(at: &Point3<f64>, from: &Point3<f64>, to: &Point3<f64>) -> f64 {
    let way = to - from;
    let share = if way.norm() > 0.0 { ((at - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (at - (from + way * share)).norm()
}

/// The angle between a direction and the great circle between two, or its ends.
fn from_arc(at: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let ends = at.angle(from).min(at.angle(to));
    let normal = from.cross(to);
    if normal.norm() < 1e-9 {
        return ends;
    }
    let normal = normal.normalize();
    let foot = at - normal * normal.dot(at);
    let is_between = from.cross(&foot).dot(&normal) >= 0.0 && foot.cross(to).dot(&normal) >= 0.0;
    if is_between { normal.dot(at).abs().asin() } else { ends }
}

/// What a thousand samples of each motion say.
#[derive(Default, Debug)]
pub struct Found {
    pub tip: f64,
    pub direction: f64,
    pub filament_mm: f64,
}

/// Checks all that a plan promises; panics where it does not hold.
pub fn check(machine: &FiveAxis, moves: &[PathMove<usize>], options: &AxisPlanOptions, plan: &Planned) -> Found {
    let ranges = machine.ranges();
    let mut found = Found::default();
    let mut at: Option<[f64; 5]> = None;
    for (k, step) in moves.iter().enumerate() {
        let (to, end) = target(step);
        let is_print = matches!(step, PathMove::Print { .. });
        let mut lifted_from: Option<(Point3<f64>, Vector3<f64>)> = None;
        for motion in &plan.of_moves[k] {
            let joints = machine.joints(&motion.axes);
            for (joint, [min, max]) in joints.iter().zip(ranges) {
                assert!(*joint >= min - 1e-6 && *joint <= max + 1e-6, "move {k}: {joint} beyond {min} to {max}");
            }
            let Some(from) = at.replace(motion.axes) else { continue };
            check_speed(machine, &from, motion);
            if motion.lifted {
                let (tip, direction) = machine.forward(&from);
                let start = *lifted_from.get_or_insert((tip, direction.into_inner()));
                check_lifted(machine, options, start, &from, motion);
                continue;
            }
            lifted_from = None;
            let (start, first) = target(&moves[k.max(1) - 1]);
            let tolerance = if is_print { options.tip_tolerance_mm } else { options.travel_tolerance_mm };
            for n in 0..=1000 {
                let axes = between(&from, &motion.axes, f64::from(n) / 1000.0);
                let (tip, direction) = machine.forward(&axes);
                let off = from_line(&tip, &start, &to);
                assert!(off <= tolerance + 1e-9, "move {k}: {off} off the line");
                if motion.printing {
                    found.tip = found.tip.max(off);
                    found.direction = found.direction.max(from_arc(&direction, &first, &end));
                }
            }
            if motion.printing {
                found.filament_mm += motion.filament_mm;
                let turned = (0..5).map(|axis| (motion.axes[axis] - from[axis]).abs()).skip(machine.linear_count());
                assert!(turned.take(2).all(|angle| angle < PI), "move {k} changes its turn while it prints");
            }
            assert_eq!(motion.printing, is_print && motion.filament_mm >= 0.0 && motion.printing);
        }
        if let Some(axes) = at {
            let (tip, _) = machine.forward(&axes);
            let slack = if machine.kind() == MachineKind::PolarHead { options.tip_tolerance_mm } else { 1e-9 };
            assert!((tip - to).norm() <= slack, "move {k} ends at {tip}, not at {to}");
        }
    }
    assert!(found.tip <= plan.summary.max_tip_error_mm + 1e-9);
    assert!(plan.summary.max_tip_error_mm <= options.tip_tolerance_mm + 1e-9, "{:?}", plan.summary);
    assert!((found.filament_mm - plan.summary.filament_mm).abs() < 1e-9);
    found
}

fn check_speed(machine: &FiveAxis, from: &[f64; 5], motion: &AxisMove) {
    let model = machine.model();
    let (a, b) = (machine.joints(from), machine.joints(&motion.axes));
    let speeds = model.linear.iter().map(|axis| axis.max_speed_mm_s);
    let speeds = speeds.chain(model.rotary.iter().map(|axis| axis.max_speed_deg_s.to_radians()));
    for (k, speed) in speeds.enumerate() {
        assert!((b[k] - a[k]).abs() <= speed * motion.seconds * (1.0 + 1e-9) + 1e-9, "axis {k} in {motion:?}");
    }
}

/// A lifted tip is never nearer to the part than where it was lifted from, seen along the nozzle; while rotary axes turn it is up.
fn check_lifted(
    machine: &FiveAxis,
    options: &AxisPlanOptions,
    (tip, direction): (Point3<f64>, Vector3<f64>),
    from: &[f64; 5],
    motion: &AxisMove,
) {
    let n = machine.linear_count();
    let turns = (0..2).any(|k| (motion.axes[n + k] - from[n + k]).abs() > 1e-9);
    let model = machine.model();
    let up = Vector3::from(model.rotary[0].axis).normalize();
    let up = if up.dot(&Vector3::from(model.nozzle.direction)) < 0.0 { -up } else { up };
    for k in 0..=1000 {
        let (there, _) = machine.forward(&between(from, &motion.axes, f64::from(k) / 1000.0));
        let is_polar = machine.kind() == MachineKind::PolarHead;
        let height = if is_polar { up.dot(&(there - tip)) } else { direction.dot(&(there - tip)) };
        assert!(height >= -1e-7, "lifted to {height}");
        let place = tip + direction * options.lift_mm;
        assert!(!turns || is_polar || (there - place).norm() <= 0.05 * options.lift_mm + 1e-6, "strays to {there}");
        assert!(!turns || height >= if is_polar { 0.0 } else { 0.9 * options.lift_mm }, "turns at {height}");
    }
}
