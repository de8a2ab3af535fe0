//! Conducting paths on a layer: fibre that is part of a circuit.
//!
//! Dai 2020, section 5.5: carbon fibre conducts, so tapes laid between layers are wires (an LED in a hook). A wire goes where the circuit wants
//! it, not along stresses: it is given as a polyline and brought onto the layer.

use super::near::Layer;
use super::tape::Tape;
use crate::mesh::{SurfaceMesh, SurfacePoint};
use nalgebra::Point3;

/// How wires lie on a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct ConductorOptions {
    /// Width in millimetres: 1, a narrow strand of the tow.
    pub width: f64,
    /// Thickness in millimetres: 0.08, that of the spread tow of the dissertation.
    pub thickness: f64,
    /// Distance of its points in millimetres, at most: 1. Between them it goes straight.
    pub step: f64,
    /// How far the polyline may be from the layer, in millimetres: 1.
    pub reach: f64,
}

impl Default for ConductorOptions {
    fn default() -> Self {
        ConductorOptions { width: 1.0, thickness: 0.08, step: 1.0, reach: 1.0 }
    }
}

/// Why a wire does not lie on a layer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConductorError {
    /// An option that is not a length.
    #[error("`{option}` is {value} mm: it must be above 0 and finite")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
    },
    /// A polyline without two different points.
    #[error("the wire has no length: it needs two different points")]
    NoLength,
    /// A point is not finite, or so far that there would be too many points.
    #[error("point {point} of the wire is not finite, or more than a million steps from the one before")]
    BadPoint {
        /// The point, from 0.
        point: usize,
    },
    /// The wire leaves the layer.
    #[error("the wire is farther than {reach} mm from the layer behind its point {point}, at {at_mm} mm along it")]
    OffLayer {
        /// The point before, from 0.
        point: usize,
        /// Length of the polyline up to there.
        at_mm: f64,
        /// How far it may be.
        reach: f64,
    },
}

/// Steps from one point of a polyline to the next, at most: more is a slip of the unit.
const MAX_STEPS: f64 = 1e6;

/// Brings a polyline onto a layer, as a strand that a head lays like a tape.
///
/// Points an even step apart along each piece go to the nearest points of the layer; corners stay.
///
/// # Returns
/// The strand: its points on the surface, with the normals there.
///
/// # Errors
/// [`ConductorError`].
///
/// # Cost
/// `O(log n)` for each step, on a layer of `n` triangles, and `O(n log n)` once.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::fiber::conductor::{ConductorOptions, conductor};
/// use curvlay_toolpath::mesh::SurfaceMesh;
/// let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]].map(|[x, y]| Point3::new(x, y, 2.0));
/// let layer = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
/// let way = [[5.0, 5.0, 2.4], [35.0, 5.0, 2.4], [35.0, 25.0, 1.8]].map(Point3::from);
/// let wire = conductor(&layer, &way, &ConductorOptions::default())?;
/// assert!(wire.points.iter().all(|point| (point.z - 2.0).abs() < 1e-12) && (wire.length() - 50.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn conductor(
    mesh: &SurfaceMesh,
    polyline: &[Point3<f64>],
    options: &ConductorOptions,
) -> Result<Tape, ConductorError> {
    let ConductorOptions { width, thickness, step, reach } = *options;
    for (option, value) in [("width", width), ("thickness", thickness), ("step", step), ("reach", reach)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(ConductorError::Option { option, value });
        }
    }
    let layer = Layer::new(mesh);
    let mut along = 0.0;
    let mut found: Vec<SurfacePoint> = Vec::new();
    for (point, at) in polyline.iter().enumerate() {
        let from = if point == 0 { at } else { &polyline[point - 1] };
        let length = (at - from).norm();
        if !(length / step <= MAX_STEPS && at.iter().all(|c| c.is_finite())) {
            return Err(ConductorError::BadPoint { point });
        }
        let steps = (length / step).ceil().max(1.0) as usize;
        for k in 1..=steps {
            let share = k as f64 / steps as f64;
            let off = ConductorError::OffLayer { point: point.saturating_sub(1), at_mm: along + share * length, reach };
            let next = layer.nearest(from + (at - from) * share, reach).ok_or(off)?;
            if found.last().is_none_or(|last| last.position != next.position) {
                found.push(next);
            }
        }
        along += length;
    }
    if found.len() < 2 {
        return Err(ConductorError::NoLength);
    }
    let normals = found.iter().map(|at| layer.normal(at)).collect();
    Ok(Tape { points: found.iter().map(|at| at.position).collect(), normals, width, thickness })
}
