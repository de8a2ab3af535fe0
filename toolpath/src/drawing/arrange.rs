//! Where a design lies on the platform, how large it is, and in which order its contours are printed: Brooks, sections 4.8, 5.2.2.
//!
//! Departs from the thesis: a design is scaled about any centre, not only about the origin.

use super::MAX_COORDINATE_MM;
use super::join::Contour;
use super::polygon::signed_area;
use nalgebra::Point2;
use std::f64::consts::TAU;

/// The centre of a design.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Centre {
    /// The middle of its bounding box, as in the thesis.
    #[default]
    Box,
    /// A point of the drawing.
    At(Point2<f64>),
}

/// Why a design could not be placed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrangeError {
    /// There is no point.
    #[error("there is no contour to place")]
    Empty,
    /// The diameter is not above zero or too large, or the centre not finite.
    #[error(
        "the diameter is {diameter} mm and the centre ({x}, {y}); they must be finite, the diameter above 0 and at most 2e6 mm"
    )]
    Option {
        /// The diameter.
        diameter: f64,
        /// The centre.
        x: f64,
        /// The centre.
        y: f64,
    },
    /// All points lie at the centre, so no scale gives the diameter.
    #[error("all points lie at the centre of the design")]
    NoExtent,
}

/// The centre of a design; `None` if it has no points.
/// ```
/// use curvlay_toolpath::{drawing::{Centre, Contour, centre_of}, nalgebra::Point2};
/// let points = vec![Point2::new(1.0, 1.0), Point2::new(5.0, 2.0)];
/// assert_eq!(centre_of(&[Contour { points, closed: false, entity: 0, fill: None }], Centre::Box), Some(Point2::new(3.0, 1.5)));
/// ```
pub fn centre_of(contours: &[Contour], centre: Centre) -> Option<Point2<f64>> {
    let mut points = contours.iter().flat_map(|contour| &contour.points);
    let first = *points.next()?;
    let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    match centre {
        Centre::Box => Some(nalgebra::center(&low, &high)),
        Centre::At(point) => Some(point),
    }
}

/// Moves the centre of a design to the origin, and scales it so that it fits exactly into a circle of this diameter.
///
/// # Arguments
/// * `diameter`: in millimetres; `None` leaves the size as it is.
///
/// # Returns
/// The scale.
///
/// # Errors
/// [`ArrangeError`] for a design without extent, and options that cannot be used.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Centre, Contour, place}, nalgebra::Point2};
/// let points = vec![Point2::new(10.0, 0.0), Point2::new(14.0, 3.0)];
/// let mut contours = [Contour { points, closed: false, entity: 0, fill: None }];
/// assert_eq!(place(&mut contours, Centre::Box, Some(10.0))?, 2.0);
/// assert_eq!(contours[0].points[1], Point2::new(4.0, 3.0));
/// # Ok::<(), curvlay_toolpath::drawing::ArrangeError>(())
/// ```
pub fn place(contours: &mut [Contour], centre: Centre, diameter: Option<f64>) -> Result<f64, ArrangeError> {
    let middle = centre_of(contours, centre).ok_or(ArrangeError::Empty)?;
    let wanted = diameter.unwrap_or(1.0);
    if !(wanted > 0.0 && wanted <= 2.0 * MAX_COORDINATE_MM && middle.x.is_finite() && middle.y.is_finite()) {
        return Err(ArrangeError::Option { diameter: wanted, x: middle.x, y: middle.y });
    }
    let points = || contours.iter().flat_map(|contour| &contour.points);
    let farthest = points().map(|point| (point - middle).norm()).fold(0.0, f64::max);
    let scale = match diameter {
        // So small that a scale is not finite either.
        Some(diameter) if !(0.5 * diameter / farthest).is_finite() => return Err(ArrangeError::NoExtent),
        Some(diameter) => 0.5 * diameter / farthest,
        None => 1.0,
    };
    for point in contours.iter_mut().flat_map(|contour| &mut contour.points) {
        *point = Point2::from((*point - middle) * scale);
    }
    Ok(scale)
}

/// Puts contours into the order in which they are printed: the closed one with the largest area first, the other closed ones by the
/// angle of their middle about the origin, then the open ones by the same.
/// ```
/// use curvlay_toolpath::{drawing::{Contour, order}, nalgebra::Point2};
/// let square = |x: f64, y: f64, half: f64| {
///     let points = [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[a, b]| Point2::new(x + a, y + b));
///     Contour { points: points.to_vec(), closed: true, entity: 0, fill: None }
/// };
/// let mut contours = vec![square(0.0, 5.0, 1.0), square(5.0, 0.1, 1.0), square(-9.0, 0.0, 2.0)];
/// order(&mut contours);
/// assert_eq!(contours.iter().map(|contour| contour.points[0].x).collect::<Vec<_>>(), [-11.0, 4.0, -1.0]);
/// ```
pub fn order(contours: &mut [Contour]) {
    let areas = contours.iter().map(|contour| if contour.closed { signed_area(&contour.points).abs() } else { 0.0 });
    let largest = areas.enumerate().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    if let Some((at, _)) = largest.filter(|(_, area)| *area > 0.0) {
        contours[..=at].rotate_right(1);
        contours[1..].sort_by(|a, b| b.closed.cmp(&a.closed).then(angle(a).total_cmp(&angle(b))));
    } else {
        contours.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    }
}

/// The angle of the mean of a contour's points, from 0 to a whole turn.
fn angle(contour: &Contour) -> f64 {
    let [x, y] = contour.points.iter().fold([0.0, 0.0], |[x, y], p| [x + p.x, y + p.y]);
    y.atan2(x).rem_euclid(TAU)
}
