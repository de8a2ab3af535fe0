//! Workcells of the examples.

use curvlay_kinematics::workcell::{AnyWorkcell, SixAxisWorkcell};

fn six(file: &str) -> SixAxisWorkcell {
    match AnyWorkcell::from_json(file.as_bytes()).unwrap() {
        AnyWorkcell::Six(cell) => cell,
        _ => panic!("eight axes"),
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
