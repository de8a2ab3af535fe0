//! Three parts on the machines to copy from: errors of the tip by the machines' own forward kinematics.

use super::files::FILES;
use super::sampled::{check, planned, print, target, travel};
use curvlay_kinematics::machine::{AxisPlanOptions, FiveAxis, MachineKind, PathMove};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

type Part = (&'static str, Vec<PathMove<usize>>);

/// Through the places of a bead, a travel to its first one from above.
fn bead(places: impl Iterator<Item = ([f64; 3], [f64; 3])>, moves: &mut Vec<PathMove<usize>>) {
    for (k, (tip, direction)) in places.enumerate() {
        if k == 0 {
            let up = Vector3::from(direction).normalize() * 8.0;
            moves.push(travel([tip[0] + up.x, tip[1] + up.y, tip[2] + up.z], direction));
            moves.push(travel(tip, direction));
        } else {
            moves.push(print(tip, direction));
        }
    }
    if let Some((tip, direction)) = moves.last().map(target) {
        let up = tip.coords + direction.into_inner() * 8.0;
        moves.push(PathMove::Travel { tip: up.into(), direction, feed_mm_s: 60.0 });
    }
}

/// A spiral over a dome of 25 mm, from its top down to a lean of 55 degrees.
fn dome() -> Part {
    let place = |k: u32| {
        let (turn, lean) = (f64::from(k) * 0.2, 0.96 * f64::from(k) / 300.0);
        let normal = [lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos()];
        (normal.map(|value| 25.0 * value), normal)
    };
    let mut moves = vec![];
    bead((0..=300).map(place), &mut moves);
    ("dome", moves)
}

/// Rings around a vase whose wall leans out by 10 to 60 degrees, each a bead.
fn vase() -> Part {
    let mut moves = vec![];
    for ring in 0..6u32 {
        let lean = (10.0 + 10.0 * f64::from(ring)).to_radians();
        let place = |k: u32| {
            let turn = TAU * f64::from(k) / 60.0 + f64::from(ring);
            let radius = 12.0 + 2.0 * f64::from(ring);
            let tip = [radius * turn.cos(), radius * turn.sin(), 5.0 + f64::from(ring)];
            (tip, [lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos()])
        };
        bead((0..=60).map(place), &mut moves);
    }
    ("vase", moves)
}

/// Lines over a saddle, whose normals pass the pole on either side and through it.
fn saddle() -> Part {
    let mut moves = vec![];
    for row in -4..=4 {
        let place = |k: i32| {
            let (x, y) = (f64::from(k), f64::from(row) * 3.0);
            ([x, y, 20.0 + 0.01 * (x * x - y * y)], [-0.02 * x, 0.02 * y, 1.0])
        };
        let there = row % 2 == 0;
        bead((-15..=15).map(|k| place(if there { k } else { -k })), &mut moves);
    }
    ("saddle", moves)
}

/// Below a micrometre at waypoints, below a tenth of a bead of 0.4 mm between them.
#[test]
fn three_parts_on_the_machines_to_copy_from() {
    for (name, text, kind) in FILES {
        let machine = FiveAxis::from_json(text.as_bytes()).unwrap();
        for (part, moves) in [dome(), vase(), saddle()] {
            let options = AxisPlanOptions::default();
            let plan = planned(&machine, &moves, options).unwrap_or_else(|error| panic!("{part} on {name}: {error}"));
            let found = check(&machine, &moves, &options, &plan);
            assert!(found.tip <= 0.02 + 1e-9, "{part} on {name}: {found:?}");
            let at_waypoints = waypoint_error(&machine, &moves, &plan.of_moves);
            assert!(kind == MachineKind::PolarHead || at_waypoints < 1e-9, "{part} on {name}: {at_waypoints}");
            // The spiral has nine and a half turns, the gantry's C has two.
            let rewinds = if part == "dome" && kind == MachineKind::HeadHead { 4 } else { 0 };
            assert_eq!(plan.summary.bead_rewinds, rewinds, "{part} on {name}: {:?}", plan.summary);
        }
    }
}

fn waypoint_error(
    machine: &FiveAxis,
    moves: &[PathMove<usize>],
    motions: &[Vec<curvlay_kinematics::machine::AxisMove>],
) -> f64 {
    let ends = moves.iter().zip(motions).filter_map(|(step, motions)| Some((target(step).0, motions.last()?)));
    ends.map(|(tip, motion)| (machine.forward(&motion.axes).0 - tip).norm()).fold(0.0, f64::max)
}

/// Published waypoints: a bead ends at a step of more than 5 mm.
fn published(name: &str, is_y_up: bool) -> Vec<PathMove<usize>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/waypoints").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let rows = text.lines().map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f64>>());
    let turn = |v: &[f64]| if is_y_up { Vector3::new(v[0], -v[2], v[1]) } else { Vector3::new(v[0], v[1], v[2]) };
    let rows: Vec<_> = rows.map(|row| (turn(&row[..3]), turn(&row[3..]).normalize())).collect();
    let low = rows.iter().fold(Vector3::repeat(f64::INFINITY), |low, (tip, _)| low.inf(tip));
    let high = rows.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, (tip, _)| high.sup(tip));
    let middle = (low + high) * 0.5;
    let mut moves: Vec<PathMove<usize>> = vec![];
    let mut last: Option<Vector3<f64>> = None;
    for (tip, direction) in rows {
        let tip = Point3::new(tip.x - middle.x, tip.y - middle.y, tip.z - low.z);
        let direction = UnitVector3::new_normalize(direction);
        let is_near = last.is_some_and(|last| (last - tip.coords).norm() < 5.0);
        moves.push(match is_near {
            true => PathMove::Print { tip, direction, filament_mm: 0.05, feed_mm_s: 10.0 },
            false => PathMove::Travel { tip, direction, feed_mm_s: 60.0 },
        });
        last = Some(tip.coords);
    }
    moves
}

/// A part that a machine does not reach is refused for places that the search for its reach has found; any other is planned.
#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn published_parts_on_the_machines_to_copy_from() {
    let parts = [
        ("maxis_model_1_16.txt", false),
        ("maxis_freeform_10.txt", false),
        ("maxis_simple_curve_10.txt", false),
        ("maxis_yoga_26300.txt", true),
        ("syn_dev_smooth_2545.txt", false),
    ];
    let mut refused = vec![];
    for (name, is_y_up) in parts {
        let moves = published(name, is_y_up);
        for (machine_name, text, kind) in FILES {
            let machine = FiveAxis::from_json(text.as_bytes()).unwrap();
            let unreachable = machine.reach(moves.iter().map(target)).unreachable;
            let options = AxisPlanOptions::default();
            let on = format!("{name} on {machine_name}");
            match planned(&machine, &moves, options) {
                Ok(plan) => {
                    assert_eq!(unreachable, 0, "{on}");
                    let at_waypoints = waypoint_error(&machine, &moves, &plan.of_moves);
                    assert!(kind == MachineKind::PolarHead || at_waypoints < 1e-9, "{on}: {at_waypoints}");
                    let found = check(&machine, &moves, &options, &plan);
                    assert!(found.tip <= 0.02 + 1e-9, "{on}: {found:?}");
                }
                Err(error) => {
                    assert!(unreachable > 0, "{on}: {error}");
                    refused.push(on);
                }
            }
        }
    }
    // The yoga pose on all five, and two parts that pass the range of Z by some millimetres.
    assert_eq!(refused.len(), 7, "{refused:?}");
}
