//! Why a layer is not filled.

use crate::geodesic::DistanceError;
use crate::level_set::LevelSetError;
use crate::mesh::MeshError;
use crate::path::PathError;
use crate::statistics::StatisticsError;

/// Why a surface is not filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FillError {
    /// The surface is no oriented manifold with boundary.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// It has no distance to its boundary.
    #[error(transparent)]
    Distance(DistanceError),
    /// It has no level sets.
    #[error(transparent)]
    Levels(LevelSetError),
    /// It has no paths.
    #[error(transparent)]
    Paths(PathError),
    /// The paths cannot be judged.
    #[error(transparent)]
    Statistics(StatisticsError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<DistanceError> for FillError {
    fn from(error: DistanceError) -> Self {
        if error == DistanceError::Cancelled { FillError::Cancelled } else { FillError::Distance(error) }
    }
}

impl From<LevelSetError> for FillError {
    fn from(error: LevelSetError) -> Self {
        if error == LevelSetError::Cancelled { FillError::Cancelled } else { FillError::Levels(error) }
    }
}

impl From<PathError> for FillError {
    fn from(error: PathError) -> Self {
        if error == PathError::Cancelled { FillError::Cancelled } else { FillError::Paths(error) }
    }
}

impl From<StatisticsError> for FillError {
    fn from(error: StatisticsError) -> Self {
        if error == StatisticsError::Cancelled { FillError::Cancelled } else { FillError::Statistics(error) }
    }
}
