//! Why surfaces are not filled.

use crate::infill::FillError;
use crate::layer::StackError;
use crate::order::OrderError;

/// Why the layers of a part are not filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FillLayersError {
    /// A surface cannot be filled.
    #[error("layer {layer}: {error}")]
    Layer {
        /// The layer, from 0.
        layer: usize,
        /// Why.
        error: FillError,
    },
    /// The beads are so narrow that their points would not fit into memory.
    #[error(
        "a bead of {bead} mm takes some {points:.1e} points on {area_mm2:.0} mm2 of surfaces, above the limit of {most}: take a bead of \
         {min_bead_mm:.3} mm or more, or raise PathOptions::max_points"
    )]
    TooManyPoints {
        /// The width that was asked for, in millimetres.
        bead: f64,
        /// Area of all surfaces.
        area_mm2: f64,
        /// Points that they would take, about.
        points: f64,
        /// The limit.
        most: usize,
        /// A width that keeps to the limit.
        min_bead_mm: f64,
    },
    /// No bead fits onto any of the surfaces.
    #[error(
        "a bead of {bead} mm fits nowhere: the surfaces are {widest_mm:.3} mm wide at most; take a bead of {fits_mm:.3} mm or less"
    )]
    NothingFits {
        /// The width that was asked for, in millimetres.
        bead: f64,
        /// Width of the widest place.
        widest_mm: f64,
        /// A width that surely has room there: half of that, since a ring has to be longer than a bead is wide.
        fits_mm: f64,
    },
    /// What is above and below each layer cannot be looked at, to find where skins are.
    #[error(transparent)]
    Stack(#[from] StackError),
    /// There are no such layers.
    #[error("layers {} to {} of {layers}", .range[0], .range[1])]
    Range {
        /// The first layer asked for, from 0, and the one after the last.
        range: [usize; 2],
        /// How many there are.
        layers: usize,
    },
    /// Surfaces of an estimate stand for no layers, or for any number.
    #[error("each surface stands for {layers_each} layers: it must be above 0 and finite")]
    LayersEach {
        /// What was given.
        layers_each: f64,
    },
    /// The curves cannot be ordered.
    #[error(transparent)]
    Order(OrderError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<OrderError> for FillLayersError {
    fn from(error: OrderError) -> Self {
        if error == OrderError::Cancelled { FillLayersError::Cancelled } else { FillLayersError::Order(error) }
    }
}

impl FillLayersError {
    pub(super) fn of(layer: usize, error: FillError) -> Self {
        if error == FillError::Cancelled { FillLayersError::Cancelled } else { FillLayersError::Layer { layer, error } }
    }
}
