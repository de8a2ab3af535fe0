//! What the benches share: inputs, and a stopwatch.

pub mod part_in_hand;

use curvlay_voxel::VoxelGrid;
use std::time::Instant;

/// The least time of so many runs, in seconds: on a machine that others share it varies least.
pub fn least_seconds(runs: u32, mut run: impl FnMut()) -> f64 {
    (0..runs).map(|_| seconds(&mut run)).fold(f64::INFINITY, f64::min)
}

/// Prints the least and the median time of one of `count` questions over 51 runs.
pub fn time_questions(name: &str, count: usize, mut run: impl FnMut()) {
    let mut times: Vec<f64> = (0..51).map(|_| seconds(&mut run)).collect();
    times.sort_by(f64::total_cmp);
    let one = 1e6 / count as f64;
    eprintln!("{name}: least {:.3} us, median {:.3} us", one * times[0], one * times[25]);
}

fn seconds(run: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

/// A hollow ball on a stem, with an arm that hangs down beside it, in a cube of `side` cells.
///
/// # Panics
/// If `side` is 0 or the grid too large.
pub fn hollow_ball(side: u32) -> VoxelGrid {
    let solid = |[x, y, z]: [u32; 3]| {
        let at = |c: u32, middle: f64| (f64::from(c) + 0.5) / f64::from(side) - middle;
        let (dx, dy, dz) = (at(x, 0.5), at(y, 0.5), at(z, 0.62));
        let from_middle = (dx * dx + dy * dy + dz * dz).sqrt();
        let stem = dx.hypot(dy) < 0.08 && dz < 0.0;
        let arm = (at(x, 0.9)).hypot(dy) < 0.05 && (-0.3..0.05).contains(&dz);
        let beam = dy.abs() < 0.05 && (0.0..0.05).contains(&dz) && (0.2..0.42).contains(&dx);
        stem || arm || beam || (0.2..0.3).contains(&from_middle)
    };
    VoxelGrid::from_fn([side; 3], solid).expect("a small grid")
}
