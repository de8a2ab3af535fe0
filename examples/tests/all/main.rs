//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-examples --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod args;
mod best_orientation;
mod boge;
mod calibrate;
mod clock;
mod common;
mod continuous_fiber;
mod curved_layers;
mod dome_drawing;
mod dome_stream;
mod feature_pairs;
mod input_files;
mod jerk_motion;
mod mesh;
mod mesh_doubts;
mod mesh_formats;
mod mesh_to_gcode;
mod mesh_to_robot;
mod motion;
mod options;
mod output;
mod pages;
mod plain_data;
mod planar_arm;
mod ranges;
mod reach;
mod render;
mod robofdm;
mod settings;
mod shapes;
mod stewart_table;
mod stl_written;
mod viewer;
mod volume_decomposition;
