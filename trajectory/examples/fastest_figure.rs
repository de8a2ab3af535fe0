//! Two joints along a figure of eight: its fastest timing within limits of speed, acceleration and jerk, beside the same path at an even pace.
//!
//! ```sh
//! cargo run -p curvlay-trajectory --example fastest_figure
//! ```

use curvlay_trajectory::{Bounds, RunIn, TimePathOptions, Timeline, Trajectory, time_path};
use std::error::Error;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

const INTERVALS: usize = 120;

fn main() -> Result<(), Box<dyn Error>> {
    let bounds = Bounds { velocity: [2.0; 2], acceleration: [6.0; 2], jerk: [60.0; 2], ..Bounds::NONE };
    let parameter: Vec<f64> = (0..=INTERVALS).map(|i| i as f64 / INTERVALS as f64).collect();
    let path: Vec<[f64; 2]> = parameter.iter().map(|s| [(TAU * s).sin(), 0.5 * (2.0 * TAU * s).sin()]).collect();

    let pace = vec![f64::INFINITY; INTERVALS];
    let go_on = |_| ControlFlow::Continue(());
    let fast = time_path(&path, &parameter, &pace, None, &bounds, &TimePathOptions::default(), &go_on)?;
    // What is promised is judged on the whole spline, not at samples.
    let broken = fast.trajectory.violations(&bounds, 1e-6);
    println!("fastest: {:.3} s, {} limits passed", fast.duration(), broken.len());

    // The even pace that holds the same limits, run-in and run-out included, by bisection.
    let even = |seconds: f64| -> Result<Trajectory<2>, Box<dyn Error>> {
        let times: Vec<f64> = parameter.iter().map(|s| s * seconds).collect();
        Ok(Trajectory::through(&Timeline::new(&times, RunIn::default())?, &path)?)
    };
    let (mut short, mut long) = (0.1, 60.0);
    while long - short > 1e-3 {
        let middle = 0.5 * (short + long);
        if even(middle)?.violations(&bounds, 1e-6).is_empty() { long = middle } else { short = middle }
    }
    let (start, end) = even(long)?.span();
    println!("even pace: {:.3} s, of which {:.3} s along the path", end - start, long);

    println!("{:>7} {:>9} {:>9} {:>9}", "joint", "speed", "accel.", "jerk");
    for (joint, most) in fast.trajectory.extremes().iter().enumerate() {
        let [speed, acceleration, jerk] = [&most.velocity, &most.acceleration, &most.jerk].map(|peak| peak.value.abs());
        println!("{joint:7} {speed:9.3} {acceleration:9.3} {jerk:9.3}");
    }
    Ok(())
}
