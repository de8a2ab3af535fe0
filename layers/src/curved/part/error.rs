//! Why a part has no layers.

use crate::curved::audit::AuditError;
use crate::curved::growth::GrowthError;
use crate::curved::support::SupportError;
use crate::curved::surface::{ContourError, SpacingError, UniformError};
use crate::trim::TrimError;
use crate::{Progress, ProgressFn};
use std::ops::ControlFlow;

/// Why there are no layers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LayersError {
    /// The growth did not start.
    #[error(transparent)]
    Growth(GrowthError),
    /// The audit did not start.
    #[error(transparent)]
    Audit(AuditError),
    /// The field could not be made.
    #[error(transparent)]
    Uniform(UniformError),
    /// No surfaces at this layer height.
    #[error(transparent)]
    Contour(ContourError),
    /// The mesh or a surface cannot be trimmed.
    #[error(transparent)]
    Trim(TrimError),
    /// The spacing could not be measured.
    #[error(transparent)]
    Spacing(SpacingError),
    /// No support could be made.
    #[error(transparent)]
    Support(SupportError),
    /// The volume is no volume.
    #[error("a part of {volume_mm3} mm3: the volume must be finite and above 0")]
    Volume {
        /// What was given.
        volume_mm3: f64,
    },
    /// Surfaces that are not there were asked for.
    #[error("surfaces {}..{} of {surfaces}", range[0], range[1])]
    Range {
        /// The first of them, from 0, and the one after the last.
        range: [usize; 2],
        /// Surfaces that there are.
        surfaces: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// From the errors of the steps; whichever was cancelled, it is [`LayersError::Cancelled`].
macro_rules! from_step {
    ($($error:ident, $variant:ident, $cancelled:pat,)*) => {$(
        impl From<$error> for LayersError {
            fn from(error: $error) -> Self {
                match error {
                    $cancelled => LayersError::Cancelled,
                    error => LayersError::$variant(error),
                }
            }
        }
    )*};
}

from_step! {
    GrowthError, Growth, GrowthError::Cancelled,
    AuditError, Audit, AuditError::Cancelled,
    UniformError, Uniform, UniformError::Growth(GrowthError::Cancelled) | UniformError::Audit(AuditError::Cancelled),
    ContourError, Contour, ContourError::Cancelled,
    TrimError, Trim, TrimError::Cancelled,
    SpacingError, Spacing, SpacingError::Cancelled,
    SupportError, Support, SupportError::Growth(GrowthError::Cancelled),
}

/// Reports the beginning of a stage.
pub(crate) fn begin(stage: &'static str, progress: ProgressFn) -> Result<(), LayersError> {
    match progress(Progress { stage, done: 0, total: 0 }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(LayersError::Cancelled),
    }
}
