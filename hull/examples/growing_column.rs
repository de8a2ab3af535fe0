//! A ball is built level by level on a plate; the hull of plate and ball grows with it, and is never built anew.
//!
//! What a nozzle can reach from outside shrinks as the hull grows. A ball is convex, so none of its cells is shadowed, unless a rod
//! beside it, built first, has widened the hull.
//!
//! ```sh
//! cargo run -p curvlay-hull --example growing_column
//! ```

use curvlay_hull::{ConvexHull, Depth, HullError};

const RADIUS: i32 = 20;
/// Half the side of the plate, and its top.
const PLATE: i32 = 60;

/// Lattice points of the ball at a level, its centre at (0, 0, RADIUS).
fn level(z: i32) -> Vec<[i32; 3]> {
    let side = -RADIUS..=RADIUS;
    let inside = |&[x, y]: &[i32; 2]| x * x + y * y + (z - RADIUS).pow(2) <= RADIUS * RADIUS;
    side.clone().flat_map(|y| side.clone().map(move |x| [x, y])).filter(inside).map(|[x, y]| [x, y, z]).collect()
}

/// Builds the ball after `first`; cells that are deeper than one unit in the hull of all earlier levels are shadowed.
fn build(first: &[[i32; 3]]) -> Result<(usize, usize), HullError> {
    let plate = [[-PLATE, -PLATE], [PLATE, -PLATE], [PLATE, PLATE], [-PLATE, PLATE]];
    let mut hull = ConvexHull::column(&plate, 0, Depth::new(1.0)?)?;
    hull.insert(first)?;
    let (mut total, mut shadowed) = (0, 0);
    for z in 1..=2 * RADIUS {
        let cells = level(z);
        total += cells.len();
        shadowed += cells.iter().filter(|&&cell| hull.is_deep(cell)).count();
        hull.insert(&cells)?;
    }
    Ok((total, shadowed))
}

fn main() -> Result<(), HullError> {
    let rod: Vec<[i32; 3]> = (1..=40).map(|z| [45, 0, z]).collect();
    for (name, first) in [("the ball alone", &[][..]), ("beside a rod built first", &rod)] {
        let (total, shadowed) = build(first)?;
        println!("{name:26} {total} cells, {shadowed} shadowed ({:.1} %)", 100.0 * shadowed as f64 / total as f64);
    }
    Ok(())
}
