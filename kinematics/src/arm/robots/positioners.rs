//! Tables that tilt and turn, by their published numbers.

use super::numbers::limits;
use crate::positioner::PositionerModel;
use std::f64::consts::TAU;

/// ABB IRBP A-250, a table that tilts about x and then turns about z.
///
/// Source: tesseract_ros_workcell, `irbpa250_d1000_macro`. Its limits and speeds are the cell builder's; they were not
/// checked against ABB's specification.
pub const IRBP_A250: PositionerModel = PositionerModel {
    tilt_origin: [733.0, 0.0, 1020.0],
    tilt_axis: [1.0, 0.0, 0.0],
    turn_origin: [0.0, 0.0, 1020.0],
    turn_axis: [0.0, 0.0, 1.0],
    table_origin: [0.0, 0.0, 1124.87],
    limits: limits([-TAU; 2], [TAU; 2], [85.0, 85.0]),
};

/// The positioners by name, as files of workcells call them.
pub const POSITIONERS: [(&str, &PositionerModel); 1] = [("IRBP_A250", &IRBP_A250)];
