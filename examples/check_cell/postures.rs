//! The postures: all joints at zero, home, and the nozzle upright over the middle of the plate.

use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::scene::Scene;
use curvlay_kinematics::workcell::{FreeRange, Held, Workcell, tool_frame};
use std::f64::consts::TAU;

/// How high above the plate the nozzle is looked at, in millimetres: high enough for a first jog by hand.
const ABOVE_MM: f64 = 100.0;

/// Tool angles that are tried.
const ANGLES: u32 = 36;

/// A plate as wide as this where the workcell leaves it open, in millimetres.
const PLATE_MM: f64 = 100.0;

/// What is to be seen at a posture.
pub struct Posture {
    pub title: String,
    /// The joints, radians: those of the arm, then tilt and turn of a table, or a track in its own units. `None` where none is found.
    pub joints: Option<Vec<f64>>,
    /// Flange in the base; the tool in the base (or the part's frame in it, if the arm holds the part).
    pub flange: Isometry3<f64>,
    pub tool: Isometry3<f64>,
    /// The nozzle on the part, z out of it.
    pub on_part: Option<Isometry3<f64>>,
    /// What is worth a word: beyond limits, touching.
    pub remarks: Vec<String>,
    /// Why the check fails.
    pub problem: Option<String>,
}

/// The three postures of a workcell.
pub fn of<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W) -> Vec<Posture> {
    let has_track = cell.equipment().track().is_some();
    let zero_title =
        if has_track { "all joints at 0, the track in the middle of its range" } else { "all joints at 0" };
    let zero = posture(cell, zero_title, Some([0.0; N]));
    let home = match cell.equipment().home::<N>() {
        Some(home) => posture(cell, "home (home_deg)", Some(home)),
        None => {
            let title = "home: none is set (home_deg); programs begin upright above the part, as next";
            Posture { problem: None, ..posture(cell, title, None) }
        }
    };
    let title = format!("nozzle upright, {ABOVE_MM} mm above the middle of the plate");
    let above = posture(cell, &title, above_plate(cell));
    vec![zero, home, above]
}

fn posture<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    title: &str,
    joints: Option<[f64; N]>,
) -> Posture {
    let identity = Isometry3::identity();
    let unknown = |problem: &str| Posture {
        title: title.into(),
        joints: None,
        flange: identity,
        tool: identity,
        on_part: None,
        remarks: vec![],
        problem: Some(format!("{title}: {problem}")),
    };
    let Some(joints) = joints else {
        return unknown("no joints within the limits bring the nozzle there without touching anything");
    };
    let Some(frames) = cell.frames(&joints) else { return unknown("the table is beyond its limits") };
    let mut remarks = Vec::new();
    if !cell.limits().contains(&joints) {
        remarks.push("beyond the limits of the joints: do not go there".to_owned());
    }
    let scene = Scene::new(cell.equipment().scene(cell.equipment().plate_diameter_mm(PLATE_MM)));
    if let Some(Ok(Some([a, b]))) = scene.as_ref().ok().map(|scene| scene.touching(&cell.scene_posture(&joints))) {
        remarks.push(format!("{a} and {b} touch here, as they are modelled: do not go there"));
    }
    let holds_part = cell.equipment().model().held == Held::Part;
    Posture {
        title: title.into(),
        joints: Some(joints.to_vec()),
        flange: frames.arm[6],
        tool: if holds_part { frames.part } else { tool_frame(&frames.nozzle) },
        on_part: cell.nozzle_on_part(&joints).map(|nozzle| tool_frame(&nozzle)),
        remarks,
        problem: None,
    }
}

/// Joints within the limits that bring the nozzle above the plate without touching anything: those nearest to zero.
fn above_plate<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W) -> Option<[f64; N]> {
    let scene = Scene::new(cell.equipment().scene(cell.equipment().plate_diameter_mm(PLATE_MM))).ok()?;
    let waypoint = Waypoint { position: Point3::new(0.0, 0.0, ABOVE_MM), axis: Vector3::z_axis() };
    let mut best: Option<(f64, [f64; N])> = None;
    for step in 0..ANGLES {
        let free = cell.free().map(|range| match range {
            FreeRange::Turn => f64::from(step) * TAU / f64::from(ANGLES),
            FreeRange::Within(min, max) => 0f64.clamp(min, max),
        });
        cell.solutions(&waypoint, &free, &mut |_, joints| {
            let Some(joints) = cell.limits().nearest_image(&joints, &[0.0; N]) else { return };
            let far: f64 = joints.iter().map(|angle| angle * angle).sum();
            let is_free = || matches!(scene.touching(&cell.scene_posture(&joints)), Ok(None));
            if best.is_none_or(|(least, _)| far < least) && is_free() {
                best = Some((far, joints));
            }
        });
    }
    best.map(|(_, joints)| joints)
}
