//! Workcells of the examples.

use curvlay_kinematics::workcell::{AnyWorkcell, EightAxisWorkcell, SixAxisWorkcell};

fn six(file: &str) -> SixAxisWorkcell {
    match AnyWorkcell::from_json(file.as_bytes()).unwrap() {
        AnyWorkcell::Six(cell) => cell,
        _ => panic!("not six axes"),
    }
}

/// A UR3 that holds the part.
pub fn ur3() -> SixAxisWorkcell {
    six(include_str!("../../../../examples/cells/ur3.json"))
}

/// A UR10 that holds the nozzle.
pub fn ur10() -> SixAxisWorkcell {
    six(include_str!("../../../../examples/cells/ur10.json"))
}

/// An IRB 1200 over a table that tilts and turns.
pub fn over_table() -> EightAxisWorkcell {
    match AnyWorkcell::from_json(include_bytes!("../../../../examples/cells/irb1200-table.json").as_slice()).unwrap() {
        AnyWorkcell::Eight(cell) => cell,
        _ => panic!("not eight axes"),
    }
}
