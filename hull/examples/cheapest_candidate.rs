//! What if? Of all cells that could be built next, the one that shadows the fewest of those that wait: by checkpoint, insertion,
//! rows and rollback, as greedy planners of curved layers ask it thousands of times.
//!
//! ```sh
//! cargo run -p curvlay-hull --example cheapest_candidate
//! ```

use curvlay_hull::{ConvexHull, Depth, HullError, RowIntervals, RowLattice};

/// Cells a side of the lattice.
const SIDE: u32 = 40;

/// Lattice points that lie deep in the hull.
fn deep_points(rows: &mut RowIntervals, hull: &ConvexHull) -> usize {
    rows.update(hull);
    let pairs = (0..SIDE).flat_map(|z| (0..SIDE).map(move |y| (y, z)));
    pairs.filter_map(|(y, z)| rows.interval(y, z)).map(Iterator::count).sum()
}

fn main() -> Result<(), HullError> {
    let mut hull = ConvexHull::new(Depth::new(1.0)?);
    // A slab of 40 by 40 at the bottom stands already.
    let side = SIDE as i32 - 1;
    hull.insert(&[
        [0, 0, 0],
        [side, 0, 0],
        [0, side, 0],
        [side, side, 0],
        [0, 0, 2],
        [side, 0, 2],
        [0, side, 2],
        [side, side, 2],
    ])?;
    let mut rows = RowIntervals::new(RowLattice { origin: [0, 0], step: 1, count: [SIDE, SIDE] })?;
    let before = deep_points(&mut rows, &hull);
    println!("deep now: {before} points; volume {:?} sixths", hull.volume_times_6());

    println!("{:>14} {:>14}", "candidate", "deep points +");
    let mut best = None;
    for candidate in [[0, 0, 3], [20, 0, 3], [20, 20, 3], [20, 20, 9], [0, 0, 30]] {
        let state = hull.checkpoint();
        hull.insert(&[candidate])?;
        let more = deep_points(&mut rows, &hull) - before;
        hull.rollback(state);
        println!("{:>14} {more:14}", format!("{candidate:?}"));
        best = best.min(Some((more, candidate))).or(Some((more, candidate)));
    }
    // Rolled back exactly: the hull is the slab again.
    assert_eq!(deep_points(&mut rows, &hull), before);
    if let Some((more, candidate)) = best {
        println!("cheapest: {candidate:?}, {more} points more");
    }
    Ok(())
}
