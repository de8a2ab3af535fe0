//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-kinematics --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod arm;
mod arm_calibrated;
mod arm_singular;
mod calibration;
mod catalogue;
mod common;
mod dome_print;
mod every_function;
mod extremes;
mod fixture;
mod growing_scene;
mod limits;
mod link;
mod link_bodies;
mod long;
mod machine;
mod part_place;
mod placement;
mod program;
mod program_blended;
mod program_fuzz;
mod program_krl;
mod program_prints;
mod program_rapid;
mod program_servo;
mod program_signals;
mod program_tp;
mod program_urscript;
mod roller;
mod rows;
mod scene;
mod scene_cubic;
mod setup;
mod stewart;
mod track;
mod ur_calibration;
mod ur_stream;
#[cfg(feature = "urdf")]
mod urdf;
mod workcell;
mod workcell_json;
