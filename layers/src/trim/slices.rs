//! Surfaces as plain slices.

use nalgebra::Point3;

/// A surface as plain slices: its points in millimetres, and its triangles.
pub type SurfaceSlices<'a> = (&'a [Point3<f64>], &'a [[u32; 3]]);
