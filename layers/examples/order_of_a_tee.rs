//! A solid T on a plate: in which order can a printer that turns the part build its cells without support? Ours beside plane slicing.
//!
//! The order is drawn through the middle of the T, a letter a layer.
//!
//! ```sh
//! cargo run -p curvlay-layers --example order_of_a_tee
//! ```

use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{GrowthOptions, Platform, Rules, UnbuildOptions, audit, grow, unbuild};
use curvlay_layers::planar::slice_uniformly;
use std::error::Error;
use std::ops::ControlFlow;

const DIMS: [u32; 3] = [25, 7, 18];

/// Rows of bits, x along a word: a stem of 5 cells under a bar of 25.
fn tee() -> Vec<u64> {
    let bar = (1 << DIMS[0]) - 1;
    let stem = 0b11111 << 10;
    (0..DIMS[2]).flat_map(|z| (0..DIMS[1]).map(move |_| if z < 12 { stem } else { bar })).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let rows = tee();
    let cells = Cells::new(DIMS, &rows)?;
    let platform = Platform::under(&cells, 30.0)?;
    let rules = Rules::default();
    let silent = |_| ControlFlow::Continue(());

    let planar = slice_uniformly(&cells);
    let greedy = grow(&cells, &platform, &rules, &GrowthOptions::default(), None, &silent)?;
    let unbuilt = unbuild(&cells, &platform, &rules, &UnbuildOptions::default(), &silent)?;
    println!("{} cells", cells.count());
    println!("{:10} {:6} {:6} {:>8}", "", "layers", "missed", "audit");
    println!("{:10} {:6} {:6} {:>8}", "planes", planar.order.len(), cells.count() - planar.order.cells().len(), "-");
    for (name, growth) in [("grown", &greedy), ("unbuilt", &unbuilt)] {
        let report = audit(&cells, &platform, &rules, &growth.order, &growth.missed_cells(), &silent)?;
        let audit = if report.is_ok() { "passes" } else { "fails" };
        println!("{name:10} {:6} {:6} {audit:>8}", growth.order.len(), growth.missed.len());
    }

    let field = unbuilt.order.field((DIMS[0] * DIMS[1] * DIMS[2]) as usize);
    for z in (0..DIMS[2]).rev() {
        let letter = |x| match field[cells.id([x, DIMS[1] / 2, z]) as usize] {
            0 => ' ',
            layer => char::from(b'a' + ((layer - 1) % 26) as u8),
        };
        println!("{}", (0..DIMS[0]).map(letter).collect::<String>());
    }
    Ok(())
}
