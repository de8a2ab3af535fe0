//! Poses, axes and their numbers in KRL.

use super::options::{DEGREES, MM};
use crate::program::ExternalAxes;
use crate::program::text::Text;
use crate::program::text::angles::{angles, rotation};
use nalgebra::{Isometry3, Translation3};

/// The pose of six numbers, mm and radians.
pub(super) fn pose([x, y, z, a, b, c]: [f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), rotation([a, b, c]))
}

/// `X 1,Y 2,Z 3,A 0,B 0,C 0`
pub(super) fn write_pose(text: &mut Text, pose: &Isometry3<f64>) {
    let at = pose.translation.vector;
    for (name, value) in ["X ", ",Y ", ",Z "].iter().zip(at.iter()) {
        text.word(name).fixed(*value, MM);
    }
    for (name, value) in [",A ", ",B ", ",C "].iter().zip(angles(&pose.rotation)) {
        text.word(name).fixed(value.to_degrees(), DEGREES);
    }
}

/// `A1 0,A2 -90,..`
pub(super) fn write_axes(text: &mut Text, joints: &[f64; 6]) {
    for (name, angle) in ["A1 ", ",A2 ", ",A3 ", ",A4 ", ",A5 ", ",A6 "].iter().zip(joints) {
        text.word(name).fixed(angle.to_degrees(), DEGREES);
    }
}

/// `,E1 0,E2 0`
pub(super) fn write_external(text: &mut Text, table: Option<ExternalAxes>) {
    let axes = table.map_or([None; 6], |table| table.axes());
    for (name, axis) in [",E1 ", ",E2 ", ",E3 ", ",E4 ", ",E5 ", ",E6 "].iter().zip(axes) {
        if let Some(angle) = axis {
            text.word(name).fixed(angle.to_degrees(), DEGREES);
        }
    }
}
