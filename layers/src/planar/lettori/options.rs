//! What a decomposition may be asked for, and why it is refused.

use nalgebra::Vector3;

/// Which way the whole part is printed first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BaseChoice {
    /// As it stands: the lowest points of z are the base.
    #[default]
    Up,
    /// Along this direction, of any length.
    Along(Vector3<f64>),
    /// Of the part's largest flat sides and the axes the one with the least volume of overhang; then the one with the largest base.
    LeastOverhang,
}

/// How a part is sliced and divided. The defaults are the paper's values for wire and arc (3 mm, 45 degrees); those of the torch
/// are usual ones, which the paper does not give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeOptions {
    /// Height of a layer, and the greatest one if they vary (default 3 mm; at most 1000 mm).
    pub layer_mm: f64,
    /// Least height of a layer. Below `layer_mm` a layer is halved while its section changes by more than `area_change` from its
    /// bottom to its top; default 3 mm: all layers are of one height.
    pub min_layer_mm: f64,
    /// The change of the section, as a share of its area, from which on a layer is halved (default 0.1).
    pub area_change: f64,
    /// The overhang angle in radians: the slope of a side, over the level, below which it needs support (default 45 degrees; at
    /// least 0.001, and below a right angle). A layer carries what reaches at most `height / tan(angle)` beyond it.
    pub angle: f64,
    /// Diameter of the torch (default 25 mm).
    pub torch_diameter_mm: f64,
    /// Distance of the torch from what it lays (default 15 mm). With half of the diameter it gives the tilt of the walls: the torch
    /// beside a wall must not meet what stands below.
    pub standoff_mm: f64,
    /// Holes and features narrower than this are machined later: sections are closed over them, and without them (default 0:
    /// nothing is left out; at most 10,000 mm).
    pub min_feature_mm: f64,
    /// How far a section may pass the supported area before that counts, for rounding and the chords of arcs (default 0.05 mm).
    pub tolerance_mm: f64,
    /// The most parts; then the rest is reported as it is (default 64).
    pub max_parts: usize,
    /// The direction of the first part.
    pub base: BaseChoice,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        VolumeOptions {
            layer_mm: 3.0,
            min_layer_mm: 3.0,
            area_change: 0.1,
            angle: std::f64::consts::FRAC_PI_4,
            torch_diameter_mm: 25.0,
            standoff_mm: 15.0,
            min_feature_mm: 0.0,
            tolerance_mm: 0.05,
            max_parts: 64,
            base: BaseChoice::Up,
        }
    }
}

/// Why a part is not decomposed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// An option is not a finite number above zero, or out of its range.
    #[error("the option {option} is {value}; it must be {range}")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The torch is wider than the part, so that no side of the part can be reached past another one.
    #[error("the torch is {torch_mm} mm wide, the part only {part_mm} mm")]
    Torch {
        /// Diameter of the torch.
        torch_mm: f64,
        /// Longest side of the part.
        part_mm: f64,
    },
    /// There would be more layers than anybody prints.
    #[error("{layers} layers; the most are {most}: is the part in millimetres?")]
    Layers {
        /// How many there would be.
        layers: f64,
        /// The most.
        most: usize,
    },
    /// The caller stopped.
    #[error("stopped by the caller")]
    Stopped,
}

/// The most layers along one direction.
pub(super) const MAX_LAYERS: usize = 20_000;

/// Highest layer: no process lays a metre at once. With the least angle a layer then reaches out a kilometre at most, far within
/// what sections are offset by.
const MAX_LAYER_MM: f64 = 1e3;

/// Least overhang angle, in radians: lower sides are level.
const MIN_ANGLE: f64 = 1e-3;

/// Widest feature that is left out, and farthest torch: wider than any part.
const MAX_FEATURE_MM: f64 = 1e4;

impl VolumeOptions {
    /// Checks all options against a part of a size.
    pub(super) fn check(&self, part_mm: f64) -> Result<(), VolumeError> {
        let above_zero = [
            ("layer_mm", self.layer_mm),
            ("min_layer_mm", self.min_layer_mm),
            ("area_change", self.area_change),
            ("torch_diameter_mm", self.torch_diameter_mm),
            ("standoff_mm", self.standoff_mm),
            ("tolerance_mm", self.tolerance_mm),
        ];
        for (option, value) in above_zero {
            if !(value.is_finite() && value > 0.0) {
                return Err(VolumeError::Option { option, value, range: "above 0 and finite" });
            }
        }
        let refused = |option, value, range| Err(VolumeError::Option { option, value, range });
        for (option, value, most, range) in [
            ("layer_mm", self.layer_mm, MAX_LAYER_MM, "at most 1000 mm"),
            ("tolerance_mm", self.tolerance_mm, MAX_LAYER_MM, "at most 1000 mm"),
            ("standoff_mm", self.standoff_mm, MAX_FEATURE_MM, "at most 10000 mm"),
        ] {
            if value > most {
                return refused(option, value, range);
            }
        }
        if !(self.angle >= MIN_ANGLE && self.angle < std::f64::consts::FRAC_PI_2) {
            return refused("angle", self.angle, "at least 0.001, and below a right angle");
        }
        if !(0.0..=MAX_FEATURE_MM).contains(&self.min_feature_mm) {
            return refused("min_feature_mm", self.min_feature_mm, "from 0 to 10000 mm");
        }
        if self.min_layer_mm > self.layer_mm {
            return refused("min_layer_mm", self.min_layer_mm, "at most layer_mm");
        }
        if self.max_parts == 0 {
            return refused("max_parts", 0.0, "at least 1");
        }
        if let BaseChoice::Along(direction) = self.base {
            let length = direction.norm();
            if !(length.is_finite() && length > 0.0) {
                return refused("base", length, "a direction with a length");
            }
        }
        if self.torch_diameter_mm > part_mm {
            return Err(VolumeError::Torch { torch_mm: self.torch_diameter_mm, part_mm });
        }
        let layers = part_mm / self.min_layer_mm;
        if layers > MAX_LAYERS as f64 {
            return Err(VolumeError::Layers { layers, most: MAX_LAYERS });
        }
        Ok(())
    }
}
