//! What of a layer is solid and what is not.

use super::error::PathError;
use std::f64::consts::PI;

/// The turn between the rows of layers that follow each other which spreads their directions most evenly over any number of layers: a
/// half turn (rows have no sense) by the golden ratio, 111.2 degrees.
const GOLDEN_TURN: f64 = PI * 0.618_033_988_749_894_9;

/// How the inside is filled where it is not solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum InfillPattern {
    /// Rows at an even geodesic distance from each other, to and fro; their direction turns from layer to layer.
    #[default]
    Rows,
    /// Where the layer meets a gyroid, a surface that is the same for all layers and repeats in space.
    Gyroid,
}

/// What is solid and what is not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct InfillOptions {
    /// Share of the inside that is filled, from 0 to 1: 1 by default, and then all layers are filled solid and nothing else here
    /// counts. With 0 there are walls and skins only.
    pub density: f64,
    /// Contours along the boundary of a layer: 3.
    pub walls: u32,
    /// How many layers at the bottom and at the top are filled solid, by the way across the layers to the outside of the part: 4. Over
    /// sparse infill the first one of a top is bridged; more of them close what it leaves.
    pub skin: u32,
    /// The pattern of the inside.
    pub pattern: InfillPattern,
    /// How much rows turn from layer to layer, in radians: a half turn by the golden ratio. `PI / 2` for two directions in turn.
    pub turn: f64,
    /// How far infill reaches into the innermost wall, in beads, so that it holds: 0.15. At most half a bead.
    pub overlap: f64,
}

impl Default for InfillOptions {
    fn default() -> Self {
        let pattern = InfillPattern::Rows;
        InfillOptions { density: 1.0, walls: 3, skin: 4, pattern, turn: GOLDEN_TURN, overlap: 0.15 }
    }
}

/// Walls and skins beyond this number are a slip.
const MAX_LAYERS: u32 = 10_000;

impl InfillOptions {
    /// Whether all layers are filled solid.
    pub fn is_solid(&self) -> bool {
        self.density >= 1.0
    }

    pub(crate) fn check(&self) -> Result<(), PathError> {
        let InfillOptions { density, walls, skin, turn, overlap, .. } = *self;
        let sound = [
            ("density", density, (0.0..=1.0).contains(&density), "from 0 to 1"),
            ("walls", f64::from(walls), walls <= MAX_LAYERS, "10000 at most"),
            ("skin", f64::from(skin), skin <= MAX_LAYERS, "10000 at most"),
            ("turn", turn, turn.is_finite(), "finite"),
            ("overlap", overlap, (0.0..=0.5).contains(&overlap), "from 0 to 0.5 beads"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, wanted)) => Err(PathError::Infill { option, value, wanted }),
            None => Ok(()),
        }
    }
}
