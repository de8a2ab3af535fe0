//! How gouging is corrected.

use super::error::GougingError;
use crate::orientation::MIN_TURN;
use std::f64::consts::PI;

/// How gouging is corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct GougingOptions {
    /// How deep the nozzle may enter a layer, as a share of its height: a quarter.
    pub allowed_depth: f64,
    /// No direction is tilted farther than this from the one wanted, or from the one that is known for the place
    /// ([`LayerStack::with_hints`](crate::layer::LayerStack::with_hints)): 90 degrees, in radians.
    pub max_tilt: f64,
    /// Directions of neighbours may differ by this: 10 degrees, in radians.
    pub max_turn: f64,
    /// How far the nozzle may turn on each millimetre of its way: 10 degrees, in radians. Where no directions that are free turn as
    /// gently as that, the path is cut, and the nozzle turns away from the part. Infinite for any turn.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub max_turn_per_mm: f64,
    /// Whether beads of the same layer that are laid by then count, too: yes.
    pub own_layer: bool,
    /// Whether a path with waypoints that no tilt frees may be printed from its end to its start, if fewer are left that
    /// way: yes. Other beads of the layer are then there before them.
    pub reverse: bool,
    /// Whether a path may be cut where only beads of its own layer close a waypoint in, and the piece around it laid before
    /// the rest of the layer, if fewer are left that way: yes.
    pub cut: bool,
    /// Where no tilt frees the nozzle, its tip may be raised along the direction wanted, which is about across the layer, by so much, in
    /// heights of the layer that is printed: a half. The bead then lies a little higher there, beside what stands higher. 0 for never, 1 at most.
    pub max_lift: f64,
    /// Where the nozzle would be deeper than this in a layer, in heights of the layer that is printed, however it is tilted, that
    /// piece of the path is left out: 1. A machine would not scratch what is built, but run into it. Infinite for never.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub max_depth: f64,
    /// Whether there is a plate at z = 0, below which nothing may reach: yes.
    pub plate: bool,
    /// How far over it the nozzle keeps, in millimetres: 0. Never more than half the height of the tip, since layers may be thin.
    pub plate_clearance: f64,
}

impl Default for GougingOptions {
    fn default() -> Self {
        let max_turn = 10_f64.to_radians();
        GougingOptions {
            allowed_depth: 0.25,
            max_tilt: PI / 2.0,
            max_turn,
            max_turn_per_mm: max_turn,
            own_layer: true,
            reverse: true,
            cut: true,
            max_lift: 0.5,
            max_depth: 1.0,
            plate: true,
            plate_clearance: 0.0,
        }
    }
}

impl GougingOptions {
    /// Defaults for a print in a workcell, which knows its own plate: `plate` is off.
    pub fn in_workcell() -> Self {
        GougingOptions { plate: false, ..GougingOptions::default() }
    }
}

impl GougingOptions {
    pub(super) fn check(&self) -> Result<(), GougingError> {
        let (turn, clearance) = ((MIN_TURN..=PI).contains(&self.max_turn), self.plate_clearance);
        let sound = [
            ("allowed_depth", self.allowed_depth, (0.0..=0.5).contains(&self.allowed_depth), "0 to 0.5 layer heights"),
            ("max_tilt", self.max_tilt, (0.0..=PI).contains(&self.max_tilt), "0 to 180 degrees, in radians"),
            ("max_depth", self.max_depth, self.max_depth >= self.allowed_depth, "no less than allowed_depth"),
            ("max_lift", self.max_lift, (0.0..=1.0).contains(&self.max_lift), "0 to 1 layer heights"),
            ("max_turn", self.max_turn, turn, "0.1 to 180 degrees, in radians"),
            (
                "max_turn_per_mm",
                self.max_turn_per_mm,
                self.max_turn_per_mm >= MIN_TURN,
                "0.1 degrees or more, in radians",
            ),
            ("plate_clearance", clearance, clearance >= 0.0 && clearance.is_finite(), "0 or more, and finite"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, wanted)) => Err(GougingError::Option { option, value, wanted }),
            None => Ok(()),
        }
    }

    /// How far over the plate the nozzle keeps; none without a plate.
    pub(super) fn over_plate(&self) -> Option<f64> {
        self.plate.then_some(self.plate_clearance)
    }
}
