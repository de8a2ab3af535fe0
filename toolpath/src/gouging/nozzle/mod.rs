//! The shape of a nozzle, how far a point is from it, and which of its directions a point forbids.
//!
//! A nozzle is a body of revolution about its direction: a flat tip, a cone that widens from it, and a block on top of
//! the cone that has no upper end. In the plane of the axis a point has a height `z` above the tip and a distance `rho`
//! from the axis.
//!
//! # Clearance
//! The cone part is where `z >= 0`, `z <= H` and `(rho - r - z tan a) cos a <= 0`; the block is where `z >= H` and
//! `rho <= R`. The *clearance* of a part is the largest of the left sides, each written so that it is a distance to a
//! line, positive outside; that of the nozzle is the smaller of the two. It is the distance to the nozzle where a
//! face is nearest, and its sign is always right. Where an edge is nearest it is less: by up to 8 % before the edge of
//! the tip of a 45 degree cone, 29 % before the edge of the block, 62 % above the upper end of the cone; so a clearance
//! asked for is kept, and a little more beside edges. It changes by no more than a point moves. Inside it is minus
//! the depth (or a little less than that beside the joint of the two parts).
//!
//! # Directions
//! With a given tip, `z` and `rho` of a point depend on its distance `L` from the tip and its angle `f` from the
//! direction alone: `z = L cos f`, `rho = L sin f`. So a point that must keep a clearance `m` forbids all directions
//! within a *cap* around the direction to it. From the inequalities above, each with `m` on its right:
//! * cone: `cos f > -m / L` and `sin(f - a) < (r cos a + m) / L`, where `L cos f <= H`;
//! * block: `cos f > (H - m) / L` and `sin f < (R + m) / L`.
//!
//! The cap is the widest `f` of either. Narrower angles are forbidden, too, unless `m` is large beside the tip or the step
//! from the cone to the block: then a sliver of free angles may lie inside, which is given away.

mod bounds;

pub(super) use bounds::{Extent, Sway};

use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Lengths beyond this are refused, in millimetres: a nozzle is not ten metres wide.
const MAX_LENGTH_MM: f64 = 1e4;

/// Diameter of the flat tip by default, in millimetres: twice an orifice of 0.4 mm. Beads of this orifice, 0.4 to 0.6 mm wide, stay under
/// the flat; under a narrower flat they bulge out beside it, and a wider one touches more of what stands beside the bead.
const TIP_FLAT_MM: f64 = 0.8;

/// The measures of a nozzle: those that `curvlay-layers` knows it by, too.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct NozzleShape {
    /// Diameter of the flat tip, in millimetres.
    pub tip_flat_mm: f64,
    /// Between the axis and the side of the cone, in radians.
    pub half_angle: f64,
    /// Height of the cone, in millimetres.
    pub cone_height_mm: f64,
    /// Diameter of the block on top of the cone, in millimetres.
    pub block_mm: f64,
}

/// A nozzle: a flat tip, a cone, and a block above it that reaches up without end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    tip_radius: f64,
    half_angle: f64,
    sin: f64,
    cos: f64,
    cone_height: f64,
    block_radius: f64,
}

/// A part of a nozzle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NozzlePart {
    /// The flat end.
    Tip,
    /// The side of the cone.
    Cone,
    /// The block on top of the cone.
    Block,
}

impl std::fmt::Display for NozzlePart {
    /// `tip`, `cone` or `block`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            NozzlePart::Tip => "tip",
            NozzlePart::Cone => "cone",
            NozzlePart::Block => "block",
        })
    }
}

/// Why there is no such nozzle.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NozzleError {
    /// A measure that is not a positive number.
    #[error("the {measure} of the nozzle is {value}: it must be above 0 and at most 10000 mm")]
    Measure {
        /// Its name.
        measure: &'static str,
        /// What was given.
        value: f64,
    },
    /// The cone does not open, or opens flat or downward.
    #[error("a cone with a half angle of {half_angle} rad: it must be above 0 and below a right angle")]
    HalfAngle {
        /// The half angle, in radians.
        half_angle: f64,
    },
    /// The tip is a plate, not a tip.
    #[error("a nozzle wider than it is high: its tip flat of {tip_flat} mm exceeds its cone's height of {height} mm")]
    WiderThanHigh {
        /// Diameter of the tip flat.
        tip_flat: f64,
        /// Height of the cone.
        height: f64,
    },
    /// The cone is wider than the block on top of it.
    #[error("a block of {block} mm on a cone that is {cone} mm wide there: the block must be at least as wide")]
    Block {
        /// Diameter of the block.
        block: f64,
        /// Diameter of the upper end of the cone.
        cone: f64,
    },
}

impl Default for NozzleShape {
    /// A tip flat of 0.8 mm, twice an orifice of 0.4 mm; a cone of 45 degrees that is 8 mm high; a block of 20 mm.
    fn default() -> Self {
        NozzleShape {
            tip_flat_mm: TIP_FLAT_MM,
            half_angle: std::f64::consts::FRAC_PI_4,
            cone_height_mm: 8.0,
            block_mm: 20.0,
        }
    }
}

impl Default for Nozzle {
    /// A nozzle of the default [`NozzleShape`].
    fn default() -> Self {
        Nozzle::of(NozzleShape::default())
    }
}

impl Nozzle {
    /// A nozzle of a shape.
    ///
    /// # Errors
    /// [`NozzleError`].
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gouging::{Nozzle, NozzleError, NozzleShape};
    /// let shape = NozzleShape { tip_flat_mm: 0.8, half_angle: 45_f64.to_radians(), cone_height_mm: 8.0, block_mm: 20.0 };
    /// let nozzle = Nozzle::new(shape)?;
    /// assert_eq!((nozzle, nozzle.shape()), (Nozzle::default(), shape));
    /// // A millimetre beside the axis at the height of the tip: 0.6 mm from the flat, seen across the cone.
    /// assert!((nozzle.clearance(0.0, 1.0) - 0.6 * 0.5_f64.sqrt()).abs() < 1e-12);
    /// let plate = Nozzle::new(NozzleShape { tip_flat_mm: 9.0, ..shape });
    /// assert_eq!(plate, Err(NozzleError::WiderThanHigh { tip_flat: 9.0, height: 8.0 }));
    /// let radii = [nozzle.tip_radius(), nozzle.cone_radius(), nozzle.block_radius()];
    /// assert!(radii[0] == 0.4 && (radii[1] - 8.4).abs() < 1e-12 && radii[2] == 10.0 && nozzle.cone_height() == 8.0);
    /// # Ok::<(), NozzleError>(())
    /// ```
    pub fn new(shape: NozzleShape) -> Result<Self, NozzleError> {
        let NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm } = shape;
        let lengths = [("tip flat", tip_flat_mm), ("cone", cone_height_mm), ("block", block_mm)];
        if let Some((measure, value)) = lengths.into_iter().find(|&(_, v)| !(v > 0.0 && v <= MAX_LENGTH_MM)) {
            return Err(NozzleError::Measure { measure, value });
        }
        if !(half_angle > 0.0 && half_angle < FRAC_PI_2) {
            return Err(NozzleError::HalfAngle { half_angle });
        }
        if tip_flat_mm > cone_height_mm {
            return Err(NozzleError::WiderThanHigh { tip_flat: tip_flat_mm, height: cone_height_mm });
        }
        let cone = tip_flat_mm + 2.0 * cone_height_mm * half_angle.tan();
        if block_mm < cone {
            return Err(NozzleError::Block { block: block_mm, cone });
        }
        Ok(Nozzle::of(shape))
    }

    fn of(shape: NozzleShape) -> Self {
        let (sin, cos) = shape.half_angle.sin_cos();
        let (tip_radius, block_radius) = (shape.tip_flat_mm / 2.0, shape.block_mm / 2.0);
        Nozzle { tip_radius, half_angle: shape.half_angle, sin, cos, cone_height: shape.cone_height_mm, block_radius }
    }

    /// Its shape, to the last digit as it was given.
    pub fn shape(&self) -> NozzleShape {
        NozzleShape {
            tip_flat_mm: 2.0 * self.tip_radius,
            half_angle: self.half_angle,
            cone_height_mm: self.cone_height,
            block_mm: 2.0 * self.block_radius,
        }
    }

    /// Radius of the tip flat, in millimetres.
    pub fn tip_radius(&self) -> f64 {
        self.tip_radius
    }

    /// Height of the cone, in millimetres.
    pub fn cone_height(&self) -> f64 {
        self.cone_height
    }

    /// Radius of the upper end of the cone, in millimetres.
    pub fn cone_radius(&self) -> f64 {
        self.tip_radius + self.cone_height * self.half_angle.tan()
    }

    /// Radius of the block on top of the cone, in millimetres.
    pub fn block_radius(&self) -> f64 {
        self.block_radius
    }

    /// How far a point is from the nozzle, in millimetres; below 0 inside. See the source for what it is before edges.
    ///
    /// # Arguments
    /// * `z`: height above the tip along the direction; `rho`: distance from the axis.
    pub fn clearance(&self, z: f64, rho: f64) -> f64 {
        let cone = (-z).max((rho - self.tip_radius) * self.cos - z * self.sin).max(z - self.cone_height);
        cone.min((self.cone_height - z).max(rho - self.block_radius))
    }

    /// The part that a point is in or near: within the height of the cone, whichever of the tip flat and the side of the
    /// cone is nearer from inside.
    ///
    /// # Arguments
    /// * `z`: height above the tip along the direction; `rho`: distance from the axis.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gouging::{Nozzle, NozzlePart};
    /// let parts = [(0.1, 0.2), (2.0, 2.3), (9.0, 1.0)].map(|(z, rho)| Nozzle::default().part(z, rho));
    /// assert_eq!(parts, [NozzlePart::Tip, NozzlePart::Cone, NozzlePart::Block]);
    /// ```
    pub fn part(&self, z: f64, rho: f64) -> NozzlePart {
        if z > self.cone_height {
            NozzlePart::Block
        } else if -z > (rho - self.tip_radius) * self.cos - z * self.sin {
            NozzlePart::Tip
        } else {
            NozzlePart::Cone
        }
    }

    /// The angle from a point, `distance` from the tip, within which no direction may lie if the point is to keep a
    /// clearance; none if all may.
    pub(super) fn cap(&self, distance: f64, clearance: f64) -> Option<f64> {
        let (cone, block) = (self.cone_cap(distance, clearance), self.block_cap(distance, clearance));
        let widest = cone.max(block);
        (widest > 0.0).then_some(widest.min(PI))
    }

    fn cone_cap(&self, distance: f64, clearance: f64) -> f64 {
        if distance <= clearance.abs() {
            return if clearance > 0.0 { PI } else { 0.0 };
        }
        let flat = (-clearance / distance).acos();
        let across = (self.tip_radius * self.cos + clearance) / distance;
        let side = if across >= 1.0 { PI } else { self.half_angle + across.max(-1.0).asin() };
        let widest = flat.min(side);
        // Narrower angles lead to where the block is.
        let top = if distance > self.cone_height { (self.cone_height / distance).acos() } else { 0.0 };
        if widest >= top { widest } else { 0.0 }
    }

    fn block_cap(&self, distance: f64, clearance: f64) -> f64 {
        let below = (self.cone_height - clearance) / distance;
        if below >= 1.0 {
            return 0.0;
        }
        let across = (self.block_radius + clearance) / distance;
        let side = if across >= 1.0 { FRAC_PI_2 } else { across.max(0.0).asin() };
        // A margin wider than the cone is high brings points below the tip to the block.
        if below < 0.0 && across >= 1.0 { below.max(-1.0).acos() } else { below.max(-1.0).acos().min(side) }
    }

    /// How far the direction may lean from the upright if nothing is to reach below a plate that lies `height` below the
    /// tip; none if it may not even stand upright.
    pub(super) fn plate_lean(&self, height: f64) -> Option<f64> {
        if height < 0.0 {
            return None;
        }
        // The edge of the tip flat, and the lower edge of the block.
        let tip = (height / self.tip_radius).min(1.0).asin();
        let corner = self.block_radius.hypot(self.cone_height);
        let block = (self.cone_height / self.block_radius).atan() + (height / corner).min(1.0).asin();
        Some(tip.min(block).min(FRAC_PI_2))
    }

    /// How far a nozzle reaches below a plate that lies `height` below its tip, if it leans by an angle from the upright,
    /// and with which part. Leaning beyond a right angle its block reaches down without end.
    pub(crate) fn below_plate(&self, height: f64, lean: f64) -> (f64, NozzlePart) {
        if lean > FRAC_PI_2 + 1e-9 {
            return (f64::INFINITY, NozzlePart::Block);
        }
        let (sin, cos) = lean.sin_cos();
        let (tip, block) = (self.tip_radius * sin, self.block_radius * sin - self.cone_height * cos);
        if block > tip { (block - height, NozzlePart::Block) } else { (tip - height, NozzlePart::Tip) }
    }

    /// From the tip to the lowest point of the rim of the tip flat or, for the block, of its lower edge.
    pub(super) fn lowest(&self, direction: &UnitVector3<f64>, part: NozzlePart) -> Vector3<f64> {
        let up = direction.into_inner();
        // Straight up or down the whole rim is as low.
        let down = (up * up.z - Vector3::z()).try_normalize(0.0).unwrap_or_else(Vector3::x);
        match part {
            NozzlePart::Block => up * self.cone_height + down * self.block_radius,
            _ => down * self.tip_radius,
        }
    }
}

impl Nozzle {
    /// A nozzle that holds all points nearer than `by` to this one, if its tip is lowered by as much.
    ///
    /// Each face is moved outward. The side of the cone then meets the plane of the lower tip farther in than the flat is
    /// wider: `r' cos a = r cos a + by (1 - sin a)`. Only beside edges the larger nozzle holds more than it must.
    pub(crate) fn grown(&self, by: f64) -> Nozzle {
        let tip_radius = self.tip_radius + by * (1.0 - self.sin) / self.cos;
        // The lower face of the block goes down with the tip.
        Nozzle { tip_radius, block_radius: self.block_radius + by, ..*self }
    }

    /// How far the lower edge of the block is from the tip: of all points of a nozzle that leans by no more than a right
    /// angle none that is farther comes lowest.
    pub(crate) fn corner(&self) -> f64 {
        self.block_radius.hypot(self.cone_height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A nozzle that grows with a lowered tip holds all that was nearer, and beside the cone no more than that.
        #[test]
        fn a_grown_nozzle_holds_what_was_near(z in -3.0_f64..8.0, rho in 0.0_f64..15.0, by in 0.01_f64..2.0) {
            let nozzle = Nozzle::default();
            let (before, after) = (nozzle.clearance(z, rho), nozzle.grown(by).clearance(z + by, rho));
            prop_assert!(before >= by || after <= 1e-12, "{before} {after}");
            let side = (rho - nozzle.tip_radius) * nozzle.cos - z * nozzle.sin;
            let is_beside_cone = (1.0..5.0).contains(&z) && side.abs() < 0.5 && by < 1.0;
            prop_assert!(!is_beside_cone || (after - (before - by)).abs() <= 1e-12, "{before} {after}");
        }
    }
}
