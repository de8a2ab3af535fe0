//! A ring of three layers as a program for an arm of Universal Robots: strokes with lift and approach, extruder on and off where they belong.
//!
//! ```sh
//! cargo run -p curvlay-kinematics --example ring_program -- ring.script
//! ```

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::program::{
    ConfData, Goal, StrokeOptions, Target, UrScriptOptions, lifted, strokes, write_urscript,
};
use curvlay_kinematics::{Arm, nozzle_frame, robots};
use std::error::Error;
use std::f64::consts::TAU;

const CENTRE: Point3<f64> = Point3::new(380.0, 60.0, 20.0);
const RADIUS: f64 = 40.0;
const LAYER: f64 = 0.6;

fn main() -> Result<(), Box<dyn Error>> {
    let arm = Arm::new(&robots::UR5)?;
    let flange_tool = Isometry3::translation(0.0, 0.0, 120.0);
    let point = |layer: u32, step: u32| {
        let (sin, cos) = (TAU * f64::from(step) / 60.0).sin_cos();
        CENTRE + Vector3::new(RADIUS * cos, RADIUS * sin, LAYER * f64::from(layer + 1))
    };
    let rings: Vec<Vec<Goal>> = (0..3)
        .map(|layer| {
            let pose = |step| nozzle_frame(&point(layer, step), &-Vector3::z_axis());
            (0..=60).map(|step| Goal::Line(Target { pose: pose(step), conf: ConfData::default() })).collect()
        })
        .collect();
    // All of it is in reach before a line is written.
    for goal in rings.iter().flatten() {
        let Goal::Line(target) = goal else { continue };
        let found = arm.inverse(&(target.pose * flange_tool.inverse()))?;
        assert!(!found.is_empty(), "out of reach: {}", target.pose);
    }

    let above = |goal: &Goal| match goal {
        Goal::Line(target) => Goal::Line(lifted(target, 15.0)),
        other => *other,
    };
    let steps = strokes(rings.iter().map(Vec::as_slice), StrokeOptions::default(), above);
    let options = UrScriptOptions { name: "ring".into(), tool: flange_tool, ..UrScriptOptions::default() };
    let mut script = Vec::new();
    write_urscript(steps, &options, &mut script)?;
    let script = String::from_utf8(script)?;
    let lines = |word: &str| script.lines().filter(|line| line.trim_start().starts_with(word)).count();
    println!("{} lines, {} movel, {} movep", script.lines().count(), lines("movel"), lines("movep"));
    println!("extruder switched {} times", lines("set_standard_digital_out(0,"));
    if let Some(file) = std::env::args().nth(1) {
        std::fs::write(&file, script)?;
        println!("{file} written");
    }
    Ok(())
}
