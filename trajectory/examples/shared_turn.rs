//! A tool over a turntable: their turns add up to a rough bearing. From samples of the free turn (ladder) to a smooth motion of both
//! (global filter), and how much squared jerk each leaves.
//!
//! ```sh
//! cargo run -p curvlay-trajectory --example shared_turn
//! ```

use curvlay_trajectory::{
    Bounds, FreeRange, GlobalOptions, LadderOptions, Posture, RobotFn, RunIn, Timeline, Trajectory, plan_ladder,
    smooth_globally,
};
use std::error::Error;
use std::ops::ControlFlow;

const WAYPOINTS: usize = 120;

/// Bearing of the nozzle along a path that turns back and forth, with corners.
fn bearing(waypoint: usize) -> f64 {
    let s = waypoint as f64 / 20.0;
    0.8 * (s - 2.0 * (s / 2.0).round()).abs() + 0.2 * (3.0 * s).sin()
}

fn main() -> Result<(), Box<dyn Error>> {
    let joints = |waypoint: usize, free: &[f64; 1]| [bearing(waypoint) - free[0], free[0]];
    let robot = RobotFn {
        waypoints: WAYPOINTS,
        free: [FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free)),
        posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free), rates: [[-1.0, 1.0]] }),
    };
    let times: Vec<f64> = (0..WAYPOINTS).map(|i| 0.1 * i as f64).collect();
    let go_on = |_| ControlFlow::Continue(());

    let options = LadderOptions { samples: [90], ..LadderOptions::default() };
    let ladder = plan_ladder(&robot, &times, &Bounds::NONE, &options, &go_on)?;
    let line = Timeline::new(&times, RunIn::default())?;
    let smooth = smooth_globally(&robot, &line, &ladder.nodes, &Bounds::NONE, &GlobalOptions::default(), &go_on)?;

    println!("{:22} {:>14} {:>14} {:>14}", "", "squared jerk", "joint 1 rad/s3", "joint 2 rad/s3");
    let table_still: Vec<[f64; 2]> = (0..WAYPOINTS).map(|i| joints(i, &[0.0])).collect();
    let smoothed: Vec<[f64; 2]> = smooth.nodes.iter().map(|node| node.joints).collect();
    for (name, waypoints) in
        [("table stands", table_still), ("ladder, 90 samples", ladder.joints()), ("smoothed", smoothed)]
    {
        let trajectory = Trajectory::through(&line, &waypoints)?;
        let peak = |joint: usize| (0..trajectory.pieces()).map(|k| trajectory.jerk(k)[joint].abs()).fold(0.0, f64::max);
        println!("{name:22} {:14.1} {:14.1} {:14.1}", trajectory.squared_jerk(), peak(0), peak(1));
    }
    println!("status {:?}, {} breaks in the ladder", smooth.status, ladder.breaks.len());
    Ok(())
}
