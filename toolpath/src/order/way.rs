//! Curves to travel, the ways along one, and how far it is between them.

use nalgebra::Point3;

/// Starts that are tried first on a closed curve, evenly by number of points.
const STARTS: usize = 8;

/// How a curve is travelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The curve, by its place in the layer given.
    pub curve: u32,
    /// The point at which it starts: 0 for an open curve, or its last one if it is reversed.
    pub start: u32,
    /// Whether its points are taken in the opposite order.
    pub reversed: bool,
}

/// A curve to be travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravelCurve<'a> {
    /// Its points in order.
    pub points: &'a [Point3<f64>],
    /// Whether the last point is joined to the first, which is not repeated: then it may start anywhere.
    pub closed: bool,
}

/// Why there is no order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// A curve without points.
    #[error("curve {curve} of layer {layer} has no points")]
    NoPoints {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
    },
    /// A point with an invalid coordinate.
    #[error("point {point} of curve {curve} of layer {layer} is not finite or beyond 1e9 mm")]
    BadPoint {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// The point, from 0.
        point: usize,
    },
    /// More curves or points than can be numbered.
    #[error("layer {layer} has more than 2^24 curves, or one of more than 2^31 points")]
    TooLarge {
        /// The layer, from 0.
        layer: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// What asks whether to go on.
pub(super) type Watch<'a> = &'a dyn Fn() -> Result<(), OrderError>;

/// One way to travel a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    pub(super) start: Point3<f64>,
    pub(super) end: Point3<f64>,
    pub(super) visit: Visit,
}

impl Way {
    pub(super) fn new(curve: &TravelCurve, number: u32, start: usize, reversed: bool) -> Way {
        let last = curve.points.len() - 1;
        let end = if curve.closed { start } else { last - start };
        let visit = Visit { curve: number, start: start as u32, reversed };
        Way { start: curve.points[start], end: curve.points[end], visit }
    }

    /// The way back.
    pub(super) fn back(&self, curve: &TravelCurve) -> Way {
        let Visit { start, reversed, .. } = self.visit;
        let start = if curve.closed { start } else { curve.points.len() as u32 - 1 - start };
        Way { start: self.end, end: self.start, visit: Visit { start, reversed: !reversed, ..self.visit } }
    }
}

/// The ways that are tried for a curve, the given one first.
pub(super) fn ways(curve: &TravelCurve, number: u32) -> Vec<Way> {
    let count = curve.points.len();
    if curve.closed {
        let starts = count.min(STARTS);
        // A few starts all around suffice to order curves; the best one is chosen once the order is known.
        return (0..starts).map(|k| Way::new(curve, number, k * count / starts, false)).collect();
    }
    let given = Way::new(curve, number, 0, false);
    if count > 1 { vec![given, given.back(curve)] } else { vec![given] }
}

/// Length from curve to curve, and to the first one and from the last one where there is somewhere to come from or go to.
pub(super) fn length(order: &[Way], from: Option<Point3<f64>>, to: Option<Point3<f64>>) -> f64 {
    let (Some(first), Some(last)) = (order.first(), order.last()) else {
        return 0.0;
    };
    let inner: f64 = order.windows(2).map(|pair| (pair[1].start - pair[0].end).norm()).sum();
    inner + gap(from, Some(first.start)) + gap(Some(last.end), to)
}

pub(super) fn gap(from: Option<Point3<f64>>, to: Option<Point3<f64>>) -> f64 {
    from.zip(to).map_or(0.0, |(from, to)| (to - from).norm())
}
