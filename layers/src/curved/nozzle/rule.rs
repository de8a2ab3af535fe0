//! The nozzle as a rule: its shape, how far it may lean, what it must keep away from.

use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Directions that are tried. Over half the sphere they are about 9 degrees apart, a fifth of the half angle of a usual cone.
pub const DIRECTIONS: usize = 256;

/// Lengths beyond this are refused, in millimetres: a nozzle is not ten metres wide.
const MAX_LENGTH: f64 = 1e4;

/// Lengths that differ by less, in cells, are one.
pub(super) const ROUNDING: f64 = 1e-9;

/// Diameter of the flat tip by default, in millimetres: twice an orifice of 0.4 mm. Beads of this orifice, 0.4 to 0.6 mm wide, stay under
/// the flat; under a narrower flat they bulge out beside it, and a wider one touches more of what stands beside the bead.
const TIP_FLAT_MM: f64 = 0.8;

/// The nozzle that is there: which cells it reaches, judged by its shape.
///
/// The shape is a body of revolution: a flat tip, a cone that widens from it, and a block on top that has no upper end. What
/// carries the nozzle beside the block, an arm or hoses, is not modelled.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct NozzleRule {
    /// Diameter of the tip flat in millimetres. Default 0.8, twice an orifice of 0.4 mm.
    pub tip_flat_mm: f64,
    /// Between the axis and the side of the cone, in radians. Default 45 degrees.
    pub half_angle: f64,
    /// Height of the cone in millimetres. Default 8.
    pub cone_height_mm: f64,
    /// Diameter of the block in millimetres. Default 20.
    pub block_mm: f64,
    /// How far the nozzle may lean from the upright, in radians: up to a right angle, beyond which the block would pass through the
    /// plate. Default a right angle.
    pub max_tilt: f64,
    /// Radius of the balls that stand for cells that are built, in cells; at most 1. Default 0.5, a bead as wide as a cell: nothing is
    /// touched. With 0 the nozzle passes beside the centres of cells, half a cell deep in beads.
    pub margin: f64,
}

impl Default for NozzleRule {
    fn default() -> Self {
        NozzleRule {
            tip_flat_mm: TIP_FLAT_MM,
            half_angle: FRAC_PI_4,
            cone_height_mm: 8.0,
            block_mm: 20.0,
            max_tilt: FRAC_PI_2,
            margin: 0.5,
        }
    }
}

/// Why a nozzle cannot be judged by.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NozzleRuleError {
    /// A measure that is not a positive number.
    #[error("the {measure} of the nozzle is {value} mm: it must be above 0 and at most 10000 mm")]
    Measure {
        /// Its name.
        measure: &'static str,
        /// What was given, in millimetres.
        value: f64,
    },
    /// The cone does not open, or opens flat or downward.
    #[error("a cone with a half angle of {half_angle} rad: it must be above 0 and below a right angle")]
    HalfAngle {
        /// The half angle, in radians.
        half_angle: f64,
    },
    /// The cone is wider than the block on top of it.
    #[error("a block of {block_mm} mm on a cone that is {cone_mm} mm wide there: take a wider block or a lower cone")]
    Block {
        /// Diameter of the block.
        block_mm: f64,
        /// Diameter of the upper end of the cone.
        cone_mm: f64,
    },
    /// The nozzle may not lean at all, or too far.
    #[error(
        "a nozzle that may lean by {max_tilt} rad: it must be above 0 and at most a right angle; to print upright alone, do without this rule"
    )]
    Tilt {
        /// The limit, in radians.
        max_tilt: f64,
    },
    /// Balls of less than nothing, or so large that they hold other cells.
    #[error("a margin of {margin} cells: it must lie between 0 and 1")]
    Margin {
        /// The margin, in cells.
        margin: f64,
    },
    /// A cell without a size.
    #[error("cells of {cell_mm} mm: their edge must be above 0 and finite")]
    Cell {
        /// The edge, in millimetres.
        cell_mm: f64,
    },
    /// A flat object, whose cells stand for bars.
    #[error("a flat object is not printed by a nozzle: its cells stand for bars without end")]
    Flat,
}

impl NozzleRule {
    /// Checks the measures.
    ///
    /// # Errors
    /// [`NozzleRuleError`].
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::{NozzleRule, NozzleRuleError};
    /// assert_eq!(NozzleRule::default().check(), Ok(()));
    /// let narrow = NozzleRule { block_mm: 10.0, ..NozzleRule::default() };
    /// assert!(matches!(narrow.check(), Err(NozzleRuleError::Block { cone_mm, .. }) if (cone_mm - 17.0).abs() < 1e-9));
    /// ```
    pub fn check(&self) -> Result<(), NozzleRuleError> {
        let NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, max_tilt, margin } = *self;
        let lengths = [("tip flat", tip_flat_mm), ("cone", cone_height_mm), ("block", block_mm)];
        if let Some((measure, value)) = lengths.into_iter().find(|&(_, v)| !(v > 0.0 && v <= MAX_LENGTH)) {
            return Err(NozzleRuleError::Measure { measure, value });
        }
        if !(half_angle > 0.0 && half_angle < FRAC_PI_2) {
            return Err(NozzleRuleError::HalfAngle { half_angle });
        }
        let cone_mm = tip_flat_mm + 2.0 * cone_height_mm * half_angle.tan();
        if block_mm < cone_mm {
            return Err(NozzleRuleError::Block { block_mm, cone_mm });
        }
        if !(max_tilt > 0.0 && max_tilt <= FRAC_PI_2) {
            return Err(NozzleRuleError::Tilt { max_tilt });
        }
        if !(0.0..=1.0).contains(&margin) {
            return Err(NozzleRuleError::Margin { margin });
        }
        Ok(())
    }

    /// The directions from the tip to the block that are tried, the most upright first: points of a Fibonacci spiral on the cap
    /// within the tilt limit, each of which stands for as much of the cap.
    pub fn directions(&self) -> Vec<UnitVector3<f64>> {
        let golden = PI * (3.0 - 5f64.sqrt());
        let cap = 1.0 - self.max_tilt.cos();
        let direction = |k: usize| {
            let up = 1.0 - cap * k as f64 / (DIRECTIONS - 1) as f64;
            let (around, out) = (golden * k as f64, (1.0 - up * up).max(0.0).sqrt());
            UnitVector3::new_normalize(Vector3::new(out * around.cos(), out * around.sin(), up))
        };
        (0..DIRECTIONS).map(direction).collect()
    }
}

/// The shape in cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    tip: f64,
    sin: f64,
    cos: f64,
    height: f64,
    block: f64,
    pub(super) margin: f64,
}

impl Shape {
    pub(super) fn new(rule: &NozzleRule, cell_mm: f64) -> Self {
        let (sin, cos) = rule.half_angle.sin_cos();
        let [tip, height, block] =
            [rule.tip_flat_mm / 2.0, rule.cone_height_mm, rule.block_mm / 2.0].map(|l| l / cell_mm);
        Shape { tip, sin, cos, height, block, margin: rule.margin }
    }

    /// No more than the distance from the nozzle, whose tip is the origin, of a point at `z` along its axis and `rho` from it.
    /// It changes by no more than the point moves.
    pub(super) fn clearance(&self, z: f64, rho: f64) -> f64 {
        let cone = (-z).max((rho - self.tip) * self.cos - z * self.sin).max(z - self.height);
        cone.min((self.height - z).max(rho - self.block))
    }

    /// How far the nozzle reaches below its tip, in the direction `[_, _, up]`.
    pub(super) fn below_tip(&self, up: f64) -> f64 {
        let out = (1.0 - up * up).max(0.0).sqrt();
        (self.tip * out).max(self.block * out - self.height * up)
    }
}
