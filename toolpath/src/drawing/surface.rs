//! Surfaces that carry a drawing, and how it comes onto them: Brooks, section 4.11.
//!
//! The thesis has one surface, a polynomial turned about z (Eq. 3-1), and one projection, along z. Here are spheres, height fields and
//! meshes, too, projections from a point and along the meridian, and the distortion of each.
//!
//! Symbols: the thesis' `Y(x)` is the height of [`Profile`] at the radius `x`.

mod mesh;
mod revolved;
mod unrolled;

pub use mesh::{MeshSurface, MeshSurfaceError};
pub use revolved::{Profile, Revolved};
pub use unrolled::{UnrollError, UnrollKind, UnrollOptions, UnrolledMesh};

use super::flatten::MAX_POINTS;
use nalgebra::{Matrix2, Point2, Point3, UnitVector3, Vector3};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, in millimetres.
    pub position: Point3<f64>,
    /// Away from the material, of length 1.
    pub normal: UnitVector3<f64>,
}

/// How a drawing in the plane z = 0 comes onto a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Projection {
    /// Along z, as in the thesis: seen from above the print is the design.
    #[default]
    Vertical,
    /// From a point on the z axis through the plane z = 0.
    FromPoint {
        /// Height of the point, below 0 for one under the plane.
        height: f64,
    },
    /// Lengths along meridians are those of the drawing; for surfaces of revolution.
    Meridian,
    /// With the least distortion: along the meridian on surfaces of revolution, by its map on an [`UnrolledMesh`].
    Unrolled,
}

/// What carries a drawing.
pub trait Surface {
    /// The point where the first ray hits that goes from `from` into `direction`, which need not be of length 1; `None` past it.
    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint>;

    /// The point straight above or below a point of the plane.
    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint>;

    /// The point at a length along the meridian into the direction of a point of the plane; `None` too for a surface without
    /// meridians.
    fn along_meridian(&self, _at: &Point2<f64>) -> Option<SurfacePoint> {
        None
    }

    /// Whether there are meridians.
    fn has_meridians(&self) -> bool {
        false
    }

    /// The point for a point of the plane into which the surface is unrolled; by default along the meridian.
    fn unrolled(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        self.along_meridian(at)
    }

    /// Whether the surface is unrolled.
    fn is_unrolled(&self) -> bool {
        self.has_meridians()
    }
}

/// Why a drawing does not come onto a surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectError {
    /// A point misses the surface.
    #[error("stroke {stroke}: the point ({x:.3}, {y:.3}) of the drawing is beyond the edge of the surface")]
    Beyond {
        /// The line, from 0.
        stroke: usize,
        /// The point.
        x: f64,
        /// The point.
        y: f64,
    },
    /// The surface has no meridians.
    #[error("only a surface of revolution has meridians")]
    NoMeridians,
    /// The surface is not unrolled.
    #[error("the surface is not unrolled")]
    NotUnrolled,
    /// More points than memory should hold, by the length of the line and the step; or a point that is not finite.
    #[error("stroke {stroke} would have more than {limit} points, or a point is not finite")]
    TooManyPoints {
        /// The line.
        stroke: usize,
        /// Greatest number.
        limit: usize,
    },
    /// A step or height that cannot be used.
    #[error("the option `{what}` is {value}; it must be above 0 and finite")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

impl Projection {
    /// The point of a surface for a point of the drawing.
    pub fn of(self, surface: &impl Surface, at: &Point2<f64>) -> Option<SurfacePoint> {
        match self {
            Projection::Vertical => surface.over(at),
            Projection::FromPoint { height } => {
                let from = Point3::new(0.0, 0.0, height);
                surface.hit(&from, &(Point3::new(at.x, at.y, 0.0) - from))
            }
            Projection::Meridian => surface.along_meridian(at),
            Projection::Unrolled => surface.unrolled(at),
        }
    }
}

/// Projects a line, with points between its own where they are more than `max_step` apart in the drawing.
///
/// # Arguments
/// * `number`: what errors call the line.
/// * `closed`: whether the line goes on from its last point to its first, which then comes again at the end.
///
/// # Errors
/// [`ProjectError`] names the point that misses the surface.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{Profile, Projection, Revolved, project};
/// use curvlay_toolpath::nalgebra::Point2;
/// let dome = Revolved::new(Profile::brooks(), 140.0)?;
/// let line = [Point2::new(0.0, 0.0), Point2::new(100.0, 0.0)];
/// let points = project(&dome, Projection::Vertical, 0, &line, false, 1.0)?;
/// assert_eq!(points.len(), 101);
/// assert!((points[0].position.z - 149.6).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn project(
    surface: &impl Surface,
    projection: Projection,
    number: usize,
    line: &[Point2<f64>],
    closed: bool,
    max_step: f64,
) -> Result<Vec<SurfacePoint>, ProjectError> {
    if !(max_step > 0.0 && max_step.is_finite()) {
        return Err(ProjectError::Option { what: "max_step", value: max_step });
    }
    let ends = line.iter().skip(1).chain(line.first().filter(|_| closed));
    let length: f64 = line.iter().zip(ends).map(|(a, b)| (b - a).norm()).sum();
    let points = length / max_step + line.len() as f64;
    if points.is_nan() || points > MAX_POINTS as f64 {
        return Err(ProjectError::TooManyPoints { stroke: number, limit: MAX_POINTS });
    }
    if projection == Projection::Meridian && !surface.has_meridians() {
        return Err(ProjectError::NoMeridians);
    }
    if projection == Projection::Unrolled && !surface.is_unrolled() {
        return Err(ProjectError::NotUnrolled);
    }
    let mut out: Vec<SurfacePoint> = Vec::with_capacity(line.len());
    let mut put = |at: Point2<f64>| {
        let hit = projection.of(surface, &at).ok_or(ProjectError::Beyond { stroke: number, x: at.x, y: at.y })?;
        out.push(hit);
        Ok(())
    };
    let back = line[..usize::from(closed).min(line.len())].iter();
    let mut from: Option<Point2<f64>> = None;
    for &to in line.iter().chain(back) {
        if let Some(from) = from {
            // Divided evenly; a length of a whole number of steps but for rounding has so many.
            let steps = ((to - from).norm() / max_step - 1e-9).ceil().max(1.0);
            for k in 1..steps as usize {
                put(from + (to - from) * (k as f64 / steps))?;
            }
        }
        put(to)?;
        from = Some(to);
    }
    Ok(out)
}

/// Points raised along their normals: a layer `height` millimetres above.
pub fn raised(points: &[SurfacePoint], height: f64) -> Vec<SurfacePoint> {
    points.iter().map(|at| SurfacePoint { position: at.position + at.normal.into_inner() * height, ..*at }).collect()
}

/// How much a projection stretches lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distortion {
    /// Mean over the points: by how much the most stretched or shortened direction differs from its length in the drawing, as a
    /// share.
    pub mean: f64,
    /// The largest of them.
    pub largest: f64,
    /// Points that were measured; those at the edge of a surface are not.
    pub points: usize,
}

/// Half the distance over which lengths are compared, in millimetres.
const DIFFERENCE_MM: f64 = 1e-3;

/// Measures the distortion of a projection at points of the drawing: `max(s1, 1 / s2) - 1` for the singular values `s1 >= s2` of its
/// derivative.
/// ```
/// use curvlay_toolpath::drawing::{Profile, Projection, Revolved, distortion};
/// use curvlay_toolpath::nalgebra::Point2;
/// // On a sphere of radius 100 at a radius of 60, a vertical projection stretches meridians by 1 / 0.8.
/// let sphere = Revolved::new(Profile::Sphere { radius: 100.0, top: 100.0 }, 90.0)?;
/// let found = distortion(&sphere, Projection::Vertical, &[Point2::new(60.0, 0.0)]);
/// assert!((found.largest - 0.25).abs() < 1e-6);
/// # Ok::<(), curvlay_toolpath::drawing::ProjectError>(())
/// ```
pub fn distortion(surface: &impl Surface, projection: Projection, points: &[Point2<f64>]) -> Distortion {
    let mut out = Distortion::default();
    let mut sum = 0.0;
    for at in points {
        let place =
            |dx: f64, dy: f64| projection.of(surface, &Point2::new(at.x + dx, at.y + dy)).map(|hit| hit.position);
        let h = DIFFERENCE_MM;
        let (Some(e), Some(w), Some(n), Some(s)) = (place(h, 0.0), place(-h, 0.0), place(0.0, h), place(0.0, -h))
        else {
            continue;
        };
        let (u, v) = ((e - w) / (2.0 * h), (n - s) / (2.0 * h));
        let square = Matrix2::new(u.dot(&u), u.dot(&v), u.dot(&v), v.dot(&v)).symmetric_eigenvalues();
        let (long, short) = (square.max().max(0.0).sqrt(), square.min().max(0.0).sqrt());
        let here = long.max(1.0 / short) - 1.0;
        sum += here;
        out.largest = out.largest.max(here);
        out.points += 1;
    }
    out.mean = if out.points > 0 { sum / out.points as f64 } else { 0.0 };
    out
}

/// A surface `z = height(x, y)` of any kind, which ends where there is no height or it is not finite.
#[derive(Clone, Copy, Debug)]
pub struct HeightField<F> {
    height: F,
    reach: f64,
}

/// Steps of a ray over a height field, and halvings that find where it comes through to the last bit.
const RAY_STEPS: usize = 2000;
const RAY_HALVINGS: usize = 100;

impl<F: Fn(f64, f64) -> Option<f64>> HeightField<F> {
    /// # Arguments
    /// * `height`: at a point of the plane.
    /// * `reach`: rays are followed so far from the axis, in millimetres.
    pub fn new(height: F, reach: f64) -> Self {
        HeightField { height, reach }
    }

    fn height(&self, x: f64, y: f64) -> Option<f64> {
        (self.height)(x, y).filter(|z| z.is_finite())
    }
}

impl<F: Fn(f64, f64) -> Option<f64>> Surface for HeightField<F> {
    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        let h = DIFFERENCE_MM;
        let z = self.height(at.x, at.y)?;
        // One-sided at an edge.
        let slope = |dx: f64, dy: f64| match (self.height(at.x + dx, at.y + dy), self.height(at.x - dx, at.y - dy)) {
            (Some(after), Some(before)) => Some((after - before) / (2.0 * h)),
            (Some(after), None) => Some((after - z) / h),
            (None, Some(before)) => Some((z - before) / h),
            (None, None) => None,
        };
        let normal = UnitVector3::new_normalize(Vector3::new(-slope(h, 0.0)?, -slope(0.0, h)?, 1.0));
        Some(SurfacePoint { position: Point3::new(at.x, at.y, z), normal })
    }

    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint> {
        first_hit(
            self,
            |at| Some(at.z - self.height(at.x, at.y)?),
            [from, &Point3::from(*direction)],
            self.reach,
            RAY_STEPS,
        )
    }
}

/// Where a ray first comes through a surface: looked for in steps until it is beyond the reach, then halved.
///
/// # Arguments
/// * `above`: how far a point is above the surface; none beside it.
/// * `ray`: where it begins, and its direction.
/// * `reach`: how far from the axis it is followed, in millimetres.
fn first_hit(
    surface: &impl Surface,
    above: impl Fn(&Point3<f64>) -> Option<f64>,
    [from, direction]: [&Point3<f64>; 2],
    reach: f64,
    steps: usize,
) -> Option<SurfacePoint> {
    let direction = &direction.coords;
    if direction.xy().norm() <= 0.0 {
        return surface.over(&from.xy());
    }
    let end = (reach + from.xy().coords.norm()) / direction.xy().norm();
    let at = |t: f64| from + direction * t;
    let place = |k: usize| end * (k as f64 / steps as f64);
    let mut before: Option<f64> = None;
    for k in 0..=steps {
        let now = above(&at(place(k)));
        if let (Some(a), Some(b)) = (before, now)
            && (a < 0.0) != (b < 0.0)
        {
            let (mut low, mut high) = (place(k - 1), place(k));
            for _ in 0..RAY_HALVINGS {
                let middle = 0.5 * (low + high);
                if above(&at(middle)).is_some_and(|value| (value < 0.0) == (a < 0.0)) {
                    low = middle
                } else {
                    high = middle
                }
            }
            return surface.over(&at(low).xy());
        }
        before = now;
    }
    None
}
