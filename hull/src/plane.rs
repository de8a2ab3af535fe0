//! Half-spaces with integer normals, and how deep below their border a point lies.

use crate::error::{HullError, MAX_DEPTH};

/// How deep below the surface of a body a point must lie to count as *deep*, in steps of 1/512 of a lattice unit.
///
/// At exactly this depth a point is deep ([`Depth::new`]), or only beyond it ([`Depth::beyond`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Depth {
    steps: u32,
    beyond: bool,
}

impl Depth {
    /// Any point of the closed body is deep, points of its surface too.
    pub const SURFACE: Depth = Depth { steps: 0, beyond: false };

    /// Steps in a lattice unit. A power of two keeps usual depths exact; more steps than this and the squares in
    /// `margin` would leave 128 bits.
    pub const STEPS: u32 = 512;

    /// Largest depth, in lattice units.
    pub const MAX: f64 = MAX_DEPTH;

    /// The depth `units`, to the nearest step: a point is deep at this depth and below it.
    ///
    /// # Errors
    /// [`HullError::Depth`] for a depth that is negative, not a number or above [`Depth::MAX`].
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::Depth;
    /// assert_eq!(Depth::new(0.0)?, Depth::SURFACE);
    /// assert_eq!(Depth::new(1.5)?.units(), 1.5);
    /// assert!(Depth::new(-1.0).is_err());
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn new(units: f64) -> Result<Self, HullError> {
        if !(0.0..=Self::MAX).contains(&units) {
            return Err(HullError::Depth { units });
        }
        Ok(Depth { steps: (units * f64::from(Self::STEPS)).round() as u32, beyond: false })
    }

    /// The depth `units`, to the nearest step: a point is deep only below it, not at this depth.
    ///
    /// # Errors
    /// As [`Depth::new`].
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::{ConvexHull, Depth};
    /// let plate = [[0, 0], [8, 0], [8, 8], [0, 8]];
    /// let [at, beyond] = [Depth::new(2.0)?, Depth::beyond(2.0)?];
    /// assert!(ConvexHull::column(&plate, 0, at)?.is_deep([4, 4, -2]));
    /// assert!(!ConvexHull::column(&plate, 0, beyond)?.is_deep([4, 4, -2]));
    /// assert!(ConvexHull::column(&plate, 0, beyond)?.is_deep([4, 4, -3]));
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn beyond(units: f64) -> Result<Self, HullError> {
        Ok(Depth { beyond: true, ..Self::new(units)? })
    }

    /// The depth in lattice units.
    pub fn units(self) -> f64 {
        f64::from(self.steps) / f64::from(Self::STEPS)
    }

    /// How far below a plane with this normal the first deep points lie, times the length of the normal: the least
    /// integer that is not below `depth * |normal|` (above it for [`Depth::beyond`]), exactly.
    ///
    /// With `squared = |normal|^2 < 2^70` and at most `2^15` steps, everything below fits 128 bits.
    pub(crate) fn margin(self, squared: u128) -> i64 {
        if self.steps == 0 {
            return i64::from(self.beyond);
        }
        let steps = u128::from(self.steps);
        let target = steps * steps * squared;
        let reaches = |margin: i64| {
            let scaled = margin as u128 * u128::from(Self::STEPS);
            if self.beyond { scaled * scaled > target } else { scaled * scaled >= target }
        };
        // Below 2^41 the floating-point product is off by far less than 1, so its floor is never above the answer.
        let mut margin = (self.units() * (squared as f64).sqrt()) as i64;
        while !reaches(margin) {
            margin += 1;
        }
        margin
    }
}

/// The half-space `normal . p <= offset` that a facet bounds.
///
/// A point lies strictly outside when `normal . p > offset`, and counts as deep below this plane when
/// `normal . p <= inner`. All numbers are exact for points with coordinates below 2^15; where they leave 64 bits they are the nearest
/// that are left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Outward normal, not of unit length.
    pub normal: [i64; 3],
    /// The greatest `normal . p` in the body.
    pub offset: i64,
    /// The greatest `normal . p` of points that count as deep.
    pub inner: i64,
}

impl Plane {
    /// The plane with the given outward normal through `p`.
    pub(crate) fn through(normal: [i64; 3], p: [i32; 3], depth: Depth) -> Self {
        let squared = normal.iter().map(|&c| u128::from(c.unsigned_abs()).pow(2)).sum();
        let offset = dot(normal, p);
        Plane { normal, offset, inner: offset.saturating_sub(depth.margin(squared)) }
    }

    /// Height of `p` over the plane, times the length of the normal: positive outside.
    pub fn height(&self, p: [i32; 3]) -> i64 {
        dot(self.normal, p).saturating_sub(self.offset)
    }

    /// Whether `p` is not deep below this plane: one such plane proves that `p` is not deep in the body.
    pub fn shows(&self, p: [i32; 3]) -> bool {
        dot(self.normal, p) > self.inner
    }

    /// How far `inner` lies below `offset`.
    pub fn margin(&self) -> i64 {
        self.offset.saturating_sub(self.inner)
    }

    /// The plane through `p` with this outward normal, not of unit length, below which points count as deep from `depth` on.
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::{Depth, Plane};
    /// let plate = Plane::at([0, 0, 1], [5, 5, 0], Depth::new(2.0)?);
    /// assert!(plate.shows([0, 0, -1]) && !plate.shows([0, 0, -2]));
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn at(normal: [i32; 3], p: [i32; 3], depth: Depth) -> Self {
        Plane::through(normal.map(i64::from), p, depth)
    }

    /// The same plane with a normal without common divisor. It shows the same points.
    ///
    /// (The margin is the least integer `m` with `m >= depth |n|`, or `m > depth |n|`. For a normal `g n` and integers `k`,
    /// `g k < ceil(g depth |n|)` says the same as `k < depth |n|`, so the margin of `n` is that of `g n` over `g`, rounded up;
    /// likewise with `<=`.)
    pub fn reduced(&self) -> Plane {
        let divisor = divisor(self.normal);
        let offset = self.offset / divisor;
        let margin = nearest(-(-i128::from(self.margin())).div_euclid(divisor.into()));
        Plane { normal: self.normal.map(|c| c / divisor), offset, inner: offset.saturating_sub(margin) }
    }

    /// Length of the normal.
    pub fn length(&self) -> f64 {
        self.normal.iter().map(|&c| (c as f64).powi(2)).sum::<f64>().sqrt()
    }
}

/// `normal . p`.
pub(crate) fn dot(normal: [i64; 3], p: [i32; 3]) -> i64 {
    let product = |k: usize| normal[k].checked_mul(p[k].into());
    let exact = || product(0)?.checked_add(product(1)?)?.checked_add(product(2)?);
    // Points of hulls never need more.
    exact().unwrap_or_else(|| nearest((0..3).map(|k| i128::from(normal[k]) * i128::from(p[k])).sum()))
}

/// The nearest number of 64 bits.
fn nearest(number: i128) -> i64 {
    number.clamp(i64::MIN.into(), i64::MAX.into()) as i64
}

/// The difference `a - b`.
pub(crate) fn minus(a: [i32; 3], b: [i32; 3]) -> [i64; 3] {
    [0, 1, 2].map(|k| i64::from(a[k]) - i64::from(b[k]))
}

/// The greatest common divisor of the coordinates; 1 for a zero vector.
pub(crate) fn divisor(v: [i64; 3]) -> i64 {
    v.iter().fold(0, |divisor, &c| gcd(divisor, c.unsigned_abs())).clamp(1, i64::MAX as u64) as i64
}

/// The greatest common divisor; that of 0 and `b` is `b`.
fn gcd(mut a: u64, mut b: u64) -> u64 {
    while a != 0 {
        (a, b) = (b % a, a);
    }
    b
}

/// The cross product.
pub(crate) fn cross(u: [i64; 3], v: [i64; 3]) -> [i64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_are_the_least_integers_that_reach() {
        let depth = Depth::new(2.0).unwrap();
        assert_eq!(depth.margin(25), 10); // 3-4-5: exact
        assert_eq!(depth.margin(26), 11); // 2 sqrt 26 = 10.198
        assert_eq!(depth.margin(24), 10); // 2 sqrt 24 = 9.798
        assert_eq!(depth.margin((1 << 35) * (1 << 35)), 1 << 36);
        assert_eq!(depth.margin((1 << 35) * (1 << 35) + 1), (1 << 36) + 1);
        assert_eq!(Depth::SURFACE.margin(u128::MAX), 0);
        let beyond = Depth::beyond(2.0).unwrap();
        assert_eq!([24, 25, 26].map(|squared| beyond.margin(squared)), [10, 11, 11]);
        assert_eq!(Depth::beyond(0.0).unwrap().margin(u128::MAX), 1);
    }

    #[test]
    fn common_divisors_go() {
        assert_eq!(divisor([-6, 0, 9]), 3);
        assert_eq!(divisor([0, 0, 0]), 1);
        assert_eq!(divisor([0, 0, -5]), 5);
    }

    #[test]
    fn a_reduced_plane_shows_the_same_points() {
        for units in [0.0, 0.3, 1.0, 1.7, 2.0] {
            for depth in [Depth::new(units).unwrap(), Depth::beyond(units).unwrap()] {
                for normal in [[1, -2, 3], [0, 0, 1], [3, -4, 0]] {
                    let plane = Plane::through(normal.map(|c| 6 * c), [1, 2, 5], depth);
                    let reduced = plane.reduced();
                    assert_eq!(reduced, Plane::through(normal, [1, 2, 5], depth));
                    for x in -20..20 {
                        assert_eq!(plane.shows([x, 3, 2]), reduced.shows([x, 3, 2]), "{depth:?} {x}");
                    }
                }
            }
        }
    }

    #[test]
    fn unsound_depths_are_refused() {
        for units in [-0.5, f64::NAN, 65.0] {
            assert!(matches!(Depth::new(units), Err(HullError::Depth { .. })));
            assert!(matches!(Depth::beyond(units), Err(HullError::Depth { .. })));
        }
    }
}
