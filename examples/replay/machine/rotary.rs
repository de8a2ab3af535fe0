//! Five-axis printers whose table tilts and turns under a nozzle that keeps its direction.
//!
//! `X Y Z` is where the tip is in the frame that the part has with all axes at zero; a point `p` of the part is there at `T(tilt) U(turn) p`.

use super::super::axes::{Axes, Limits, NozzlePose};
use super::rotary_axis::RotaryAxis;
use nalgebra::{Point3, Vector3};

/// Such a printer: axes 0 to 2 are `X Y Z` in millimetres, 3 the tilt, 4 the turn, in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotary {
    /// What a report calls it.
    pub name: String,
    /// The axis that stands in the machine.
    pub tilt: RotaryAxis,
    /// The axis that it carries, with the part on it.
    pub turn: RotaryAxis,
    /// Direction of the nozzle, from the tip into it, of length 1.
    pub nozzle: Vector3<f64>,
    /// Its limits.
    pub limits: Limits,
}

impl Rotary {
    /// Where the nozzle is on the part.
    pub fn nozzle_on_part(&self, axes: &Axes) -> NozzlePose {
        let moved = self.tilt.at(axes[3]).then(&self.turn.at(axes[4]));
        let back = moved.turn.transpose();
        let tip = back * (Vector3::new(axes[0], axes[1], axes[2]) - moved.at);
        NozzlePose { tip: Point3::from(tip), axis: back * self.nozzle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvlay_toolpath::gcode::RotaryTable;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(64) })]

        #[test]
        fn the_nozzle_is_where_the_writer_has_it(
            at in prop::array::uniform3(-200f64..200.0), angles in prop::array::uniform2(-3.0f64..3.0),
            centres in prop::array::uniform6(-50f64..50.0)
        ) {
            let mut table = RotaryTable::default();
            table.tilt.centre = Point3::new(centres[0], centres[1], centres[2]);
            table.turn.centre = Point3::new(centres[3], centres[4], centres[5]);
            let axis = |axis: &curvlay_toolpath::gcode::RotaryAxis| RotaryAxis {
                letter: axis.letter,
                axis: axis.axis.into_inner(),
                centre: axis.centre.coords,
            };
            let machine = Rotary {
                name: String::new(),
                tilt: axis(&table.tilt),
                turn: axis(&table.turn),
                nozzle: Vector3::z(),
                limits: Limits::NONE,
            };
            let (tip, direction) = table.part_point(&at.into(), angles);
            let pose = machine.nozzle_on_part(&[at[0], at[1], at[2], angles[0], angles[1], 0.0, 0.0, 0.0]);
            prop_assert!((pose.tip - tip).norm() < 1e-10 && (pose.axis - direction.into_inner()).norm() < 1e-12);
        }
    }
}
