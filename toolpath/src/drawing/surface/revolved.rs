//! Surfaces of revolution about z: the thesis' polynomial, and spheres.

use super::{ProjectError, Surface, SurfacePoint, first_hit};
use nalgebra::{Point2, Point3, UnitVector3, Vector3};

/// The height of a surface of revolution over its radius.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// A polynomial in the radius; the coefficient of the lowest power comes first.
    Polynomial(Vec<f64>),
    /// The upper half of a sphere.
    Sphere {
        /// Its radius.
        radius: f64,
        /// Height of its pole.
        top: f64,
    },
}

impl Profile {
    /// The platform of the thesis, Eq. 3-1. Its odd coefficients are rounding of the fit and make a tip of 1e-17 at the pole; they
    /// stand as printed.
    /// ```
    /// use curvlay_toolpath::drawing::Profile;
    /// assert_eq!(Profile::brooks().height(0.0), Some(149.6));
    /// ```
    pub fn brooks() -> Self {
        Profile::Polynomial(vec![149.6, -4.481e-17, -0.002343, 2.084e-21, -3.309e-8])
    }

    /// The height at a radius; `None` beyond a sphere.
    pub fn height(&self, radius: f64) -> Option<f64> {
        match self {
            Profile::Polynomial(coefficients) => Some(coefficients.iter().rev().fold(0.0, |sum, c| sum * radius + c)),
            Profile::Sphere { radius: r, top } => {
                // The fall from the pole without a difference of near numbers.
                let root = (r * r - radius * radius).max(0.0).sqrt();
                (radius.abs() <= *r).then(|| top - radius * radius / (r + root))
            }
        }
    }

    /// The slope at a radius.
    pub fn slope(&self, radius: f64) -> Option<f64> {
        match self {
            Profile::Polynomial(coefficients) => {
                let terms = coefficients.iter().enumerate().skip(1).rev();
                Some(terms.fold(0.0, |sum, (power, c)| sum * radius + power as f64 * c))
            }
            Profile::Sphere { radius: r, .. } => {
                (radius.abs() < *r).then(|| -radius / (r * r - radius * radius).sqrt())
            }
        }
    }
}

/// Parts of the radius over which lengths along the meridian are kept; each is integrated by four Gauss points, so that lengths are
/// right to rounding.
const PARTS: usize = 512;

/// A surface of revolution about z, out to a radius.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolved {
    profile: Profile,
    max_radius: f64,
    /// Length along the meridian to each multiple of `max_radius / PARTS`.
    lengths: Vec<f64>,
}

impl Revolved {
    /// # Errors
    /// [`ProjectError::Option`] if the radius is not above zero, or the profile has no height or slope up to there.
    pub fn new(profile: Profile, max_radius: f64) -> Result<Self, ProjectError> {
        let finite = |value: Option<f64>| value.is_some_and(f64::is_finite);
        if !(max_radius > 0.0 && max_radius.is_finite()) {
            return Err(ProjectError::Option { what: "max_radius", value: max_radius });
        }
        let mut surface = Revolved { profile, max_radius, lengths: vec![0.0] };
        for k in 0..=PARTS {
            let radius = max_radius * (k as f64 / PARTS as f64);
            if !(finite(surface.profile.height(radius)) && finite(surface.profile.slope(radius))) {
                return Err(ProjectError::Option { what: "profile", value: radius });
            }
            if k > 0 {
                let from = max_radius * ((k - 1) as f64 / PARTS as f64);
                surface.lengths.push(surface.lengths[k - 1] + surface.length(from, radius));
            }
        }
        Ok(surface)
    }

    /// Where it ends.
    pub fn max_radius(&self) -> f64 {
        self.max_radius
    }

    /// The profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Length along the meridian between two near radii, by Gauss' rule of four points.
    fn length(&self, from: f64, to: f64) -> f64 {
        /// Places and weights of the rule on -1 to 1.
        const RULE: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
            (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        ];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speed = |at: f64| self.profile.slope(middle + half * at).map_or(1.0, |slope| 1f64.hypot(slope));
        half * RULE.iter().map(|&(at, weight)| weight * speed(at)).sum::<f64>()
    }

    fn at(&self, radius: f64, direction: [f64; 2]) -> Option<SurfacePoint> {
        if radius > self.max_radius {
            return None;
        }
        let (z, slope) = (self.profile.height(radius)?, self.profile.slope(radius)?);
        let [x, y] = direction;
        let position = Point3::new(x * radius, y * radius, z);
        let normal = UnitVector3::new_normalize(Vector3::new(-slope * x, -slope * y, 1.0));
        Some(SurfacePoint { position, normal })
    }
}

/// Length and direction of a point of the plane; at the origin along x.
fn polar(at: &Point2<f64>) -> (f64, [f64; 2]) {
    let radius = at.x.hypot(at.y);
    (radius, if radius > 0.0 { [at.x / radius, at.y / radius] } else { [1.0, 0.0] })
}

impl Surface for Revolved {
    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        let (radius, direction) = polar(at);
        let hit = self.at(radius, direction)?;
        // The point itself, not a product that is off by rounding.
        Some(SurfacePoint { position: Point3::new(at.x, at.y, hit.position.z), ..hit })
    }

    /// The first crossing between 0 and the edge, looked for in steps of a 512th of the way to the edge.
    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint> {
        let above = |at: &Point3<f64>| {
            let radius = at.x.hypot(at.y);
            let height = self.profile.height(radius).filter(|_| radius <= self.max_radius * (1.0 + 1e-12))?;
            Some(at.z - height)
        };
        first_hit(self, above, [from, &Point3::from(*direction)], self.max_radius, PARTS)
    }

    fn along_meridian(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        let (length, direction) = polar(at);
        let part = self.lengths.partition_point(|&s| s <= length).checked_sub(1)?;
        if part >= PARTS {
            let is_edge = length <= self.lengths[PARTS];
            return if is_edge { self.at(self.max_radius, direction) } else { None };
        }
        let begin = self.max_radius * (part as f64 / PARTS as f64);
        let wanted = length - self.lengths[part];
        // Newton's method: the speed is at least 1 and nearly constant over a part.
        let mut radius = begin + wanted;
        for _ in 0..8 {
            let speed = self.profile.slope(radius).map_or(1.0, |slope| 1f64.hypot(slope));
            radius -= (self.length(begin, radius) - wanted) / speed;
        }
        self.at(radius.clamp(0.0, self.max_radius), direction)
    }

    fn has_meridians(&self) -> bool {
        true
    }
}
