//! How a part is layered.

use crate::curved::distance::{DirectedOptions, STEPS_PER_LAYER};
use crate::curved::nozzle::NozzleRule;
use crate::curved::strategy::Strategy;
use crate::curved::support::SupportOptions;

/// When cells are judged by the nozzle that prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum NozzleUse {
    /// Never: the hull rule alone.
    Off,
    /// After the order by the hull rule: cells that it misses.
    #[default]
    After,
    /// From the start on: each cell by either rule.
    FromStart,
}

/// By what the order of the cells is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum LayersBy {
    /// By convex hulls, which let a nozzle of any size pass; what they miss is built by the nozzle that prints.
    #[default]
    Hull,
    /// By the [distance](crate::curved::distance_field) from what the part stands on, of the cells that the nozzle that prints reaches.
    Distance,
    /// By a field that follows the distance, but leans no more than the nozzle's cone allows ([`grow_directed`](crate::curved::grow_directed)).
    Directed,
    /// The first of [`LayersBy::TRIED`] that misses no cell and passes its audit; if there is none, the one that misses the fewest.
    Best,
}

impl LayersBy {
    /// The orders that [`LayersBy::Best`] tries, one after the other.
    pub const TRIED: [LayersBy; 3] = [LayersBy::Directed, LayersBy::Distance, LayersBy::Hull];

    /// Steps of the order to a layer.
    pub(super) fn steps(self) -> u32 {
        if matches!(self, LayersBy::Distance | LayersBy::Directed) { STEPS_PER_LAYER } else { 1 }
    }
}

/// How a part is layered. The default makes it complete: by hulls, then by the nozzle that prints, then with support.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct LayerOptions {
    /// Layer height in millimetres, at least a fifth of a cell; `None` for the edge of a cell. Default `None`.
    pub height_mm: Option<f64>,
    /// What finds the order of the cells. Default: hulls.
    pub layers_by: LayersBy,
    /// How an order by hulls is grown. Default `None`, the best one: incremental, unless that misses cells and un-building loses less of the volume
    /// ([`LayerSurfaces::lost_mm3`](super::layer_surfaces::LayerSurfaces::lost_mm3)) by more than [`WORTH`](crate::curved::WORTH) of it; or about as much, and misses less
    /// of it by more than [`WORTH_MISSED`](crate::curved::WORTH_MISSED); or about as much, in fewer [pieces of surface](super::layer_surfaces::LayerSurfaces::pieces).
    pub strategy: Option<Strategy>,
    /// When cells are judged by the nozzle. Default: after the hull rule.
    pub nozzle: NozzleUse,
    /// The nozzle.
    pub rule: NozzleRule,
    /// What a directed field is to be like.
    pub directed: DirectedOptions,
    /// Support for what is missed; `None` for no support. Default: columns as [`SupportOptions`] has them.
    pub support: Option<SupportOptions>,
    /// Makes the layers once more from a [`coherent_field`](crate::curved::surface::coherent_field) of the same order, and takes those if their surfaces end less inside the
    /// part ([`LayerBoundary::at_waits_mm`](super::layer_surfaces::LayerBoundary::at_waits_mm)), in no more pieces, and lose no more of the volume, or no more than three hundredths of it. Default false.
    pub coherent: bool,
}

impl Default for LayerOptions {
    fn default() -> Self {
        LayerOptions {
            height_mm: None,
            layers_by: LayersBy::default(),
            strategy: None,
            nozzle: NozzleUse::default(),
            rule: NozzleRule::default(),
            directed: DirectedOptions::default(),
            support: Some(SupportOptions::default()),
            coherent: false,
        }
    }
}

impl LayerOptions {
    /// The hull rule alone (Dai 2020, section 3.4): no cells that only this nozzle reaches, no support.
    pub fn hull_rule() -> Self {
        LayerOptions { nozzle: NozzleUse::Off, support: None, ..LayerOptions::default() }
    }
}
