//! Prisms that stand for the bodies of links.

use crate::scene::body::Shape;
use nalgebra::Point3;

/// An axis of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

/// A convex outline, moved along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prism {
    pub(super) axis: Axis,
    pub(super) ends: [f64; 2],
    /// Pairs of coordinates along the next axes: of X these are y and z, of Y z and x, of Z x and y.
    pub(super) outline: &'static [f64],
}

pub(super) const fn prism(axis: Axis, ends: [f64; 2], outline: &'static [f64]) -> Prism {
    Prism { axis, ends, outline }
}

impl Prism {
    pub(super) fn shape(&self) -> Shape {
        let corner = |end: f64, pair: &[f64]| match self.axis {
            Axis::X => Point3::new(end, pair[0], pair[1]),
            Axis::Y => Point3::new(pair[1], end, pair[0]),
            Axis::Z => Point3::new(pair[0], pair[1], end),
        };
        let cap = |end: f64| self.outline.chunks_exact(2).map(move |pair| corner(end, pair));
        Shape::Hull { points: self.ends.into_iter().flat_map(cap).collect(), radius: 0.0 }
    }
}
