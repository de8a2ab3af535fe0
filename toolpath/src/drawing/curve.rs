//! Curves of a drawing: lines, elliptic arcs and rational splines. An affine map takes each kind to itself, so blocks, arrays and
//! SVG transforms need nothing else.

use super::fault::{CurveFault, MAX_COORDINATE_MM};
use nalgebra::{Matrix2, Point2, Vector2};
use std::f64::consts::PI;

/// A curve in the plane.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A segment.
    Line {
        /// Where it begins.
        from: Point2<f64>,
        /// Where it ends.
        to: Point2<f64>,
    },
    /// An arc of a circle, an ellipse, or the affine image of one: `centre + u cos t + v sin t`.
    Arc {
        /// The centre.
        centre: Point2<f64>,
        /// One half-diameter.
        u: Vector2<f64>,
        /// The conjugate half-diameter.
        v: Vector2<f64>,
        /// Where `t` begins, in radians.
        from: f64,
        /// How far `t` goes, in radians; negative: from `u` away from `v`.
        sweep: f64,
    },
    /// A spline, rational if its weights differ.
    Spline {
        /// Degree of its polynomials, 1 to 24.
        degree: usize,
        /// Knots, not falling: one for each control point, and `degree + 1` more.
        knots: Vec<f64>,
        /// Control points.
        points: Vec<Point2<f64>>,
        /// A weight above zero for each control point; empty: all are 1.
        weights: Vec<f64>,
    },
}

/// Greatest degree of a spline. Files have 3, rarely 5; a Bezier piece costs the cube of it.
pub(super) const MAX_DEGREE: usize = 24;

impl Curve {
    /// A circle, or the arc of one from the angle `from` over `sweep`, in radians.
    /// ```
    /// use curvlay_toolpath::drawing::Curve;
    /// use curvlay_toolpath::nalgebra::Point2;
    /// let half = Curve::circle(Point2::new(1.0, 2.0), 3.0, 0.0, std::f64::consts::PI);
    /// assert!((half.ends()[1] - Point2::new(-2.0, 2.0)).norm() < 1e-12);
    /// ```
    pub fn circle(centre: Point2<f64>, radius: f64, from: f64, sweep: f64) -> Self {
        Curve::Arc { centre, u: Vector2::x() * radius, v: Vector2::y() * radius, from, sweep }
    }

    /// What a polyline of a DXF file has between two corners: the tangent of a quarter of the arc's angle is `bulge`, above zero
    /// to the left of the chord's direction turned right; 0 is a segment.
    /// ```
    /// use curvlay_toolpath::drawing::Curve;
    /// use curvlay_toolpath::nalgebra::Point2;
    /// // A half circle, counter-clockwise.
    /// let Curve::Arc { centre, sweep, .. } = Curve::bulge(Point2::new(0.0, 0.0), Point2::new(2.0, 0.0), 1.0) else { panic!() };
    /// assert!((centre - Point2::new(1.0, 0.0)).norm() < 1e-15 && sweep == std::f64::consts::PI);
    /// ```
    pub fn bulge(from: Point2<f64>, to: Point2<f64>, bulge: f64) -> Self {
        let chord = to - from;
        // Flatter than a millionth of a millionth of its chord: the centre would be lost in rounding.
        if bulge.abs() < 1e-12 {
            return Curve::Line { from, to };
        }
        let left = Vector2::new(-chord.y, chord.x);
        let centre = from + 0.5 * chord + left * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let u = from - centre;
        Curve::Arc { centre, u, v: Vector2::new(-u.y, u.x), from: 0.0, sweep: 4.0 * bulge.atan() }
    }

    /// A Bezier curve of any degree.
    pub fn bezier(points: Vec<Point2<f64>>) -> Self {
        let degree = points.len().saturating_sub(1);
        let knots = [0.0, 1.0].into_iter().flat_map(|knot| std::iter::repeat_n(knot, degree + 1)).collect();
        Curve::Spline { degree, knots, points, weights: Vec::new() }
    }

    /// Begin and end. Of a spline that cannot be evaluated, its first and last control point.
    pub fn ends(&self) -> [Point2<f64>; 2] {
        match self {
            Curve::Line { from, to } => [*from, *to],
            Curve::Arc { centre, u, v, from, sweep } => {
                [*from, from + sweep].map(|t: f64| centre + u * t.cos() + v * t.sin())
            }
            Curve::Spline { points, .. } => match self.pieces() {
                Ok(pieces) => {
                    let end = |piece: Option<&Vec<[f64; 3]>>, last: bool| {
                        let point = piece.and_then(|piece| if last { piece.last() } else { piece.first() });
                        point.map_or_else(Point2::origin, |[x, y, w]| Point2::new(x / w, y / w))
                    };
                    [end(pieces.first(), false), end(pieces.last(), true)]
                }
                Err(_) => [points.first(), points.last()].map(|point| point.copied().unwrap_or_else(Point2::origin)),
            },
        }
    }

    /// Checks that the curve can be evaluated.
    pub(super) fn check(&self) -> Result<(), CurveFault> {
        let finite = match self {
            Curve::Line { from, to } => from.coords.iter().chain(to.coords.iter()).all(|x| x.is_finite()),
            Curve::Arc { centre, u, v, from, sweep } => {
                let vectors = centre.coords.iter().chain(u.iter()).chain(v.iter());
                vectors.chain([from, sweep]).all(|x| x.is_finite())
            }
            Curve::Spline { knots, points, weights, .. } => {
                let coordinates = points.iter().flat_map(|point| point.coords.iter());
                coordinates.chain(knots).chain(weights).all(|x| x.is_finite())
            }
        };
        if !finite {
            return Err(CurveFault::NotFinite);
        }
        match self {
            Curve::Line { .. } => Ok(()),
            Curve::Arc { u, v, .. } if u.norm() > 0.0 || v.norm() > 0.0 => Ok(()),
            Curve::Arc { .. } => Err(CurveFault::ZeroRadius),
            Curve::Spline { degree, knots, points, weights } => {
                if !(1..=MAX_DEGREE).contains(degree) || points.len() <= *degree {
                    return Err(CurveFault::Degree { degree: *degree, points: points.len() });
                }
                if knots.len() != points.len() + degree + 1 {
                    let expected = points.len() + degree + 1;
                    return Err(CurveFault::KnotCount { expected, found: knots.len() });
                }
                if knots.windows(2).any(|pair| pair[1] < pair[0]) || knots[points.len()] <= knots[*degree] {
                    return Err(CurveFault::Knots);
                }
                if !weights.is_empty() && (weights.len() != points.len() || weights.iter().any(|&w| w <= 0.0)) {
                    return Err(CurveFault::Weights);
                }
                Ok(())
            }
        }
    }

    /// Checks that the curve can be evaluated and lies within [`MAX_COORDINATE_MM`]: a spline by its control points, which enclose it.
    pub(super) fn drawable(&self) -> Result<(), CurveFault> {
        self.check()?;
        let far = |p: &Point2<f64>| p.iter().copied().find(|x| x.is_nan() || x.abs() > MAX_COORDINATE_MM);
        let farthest = match self {
            Curve::Spline { points, .. } => points.iter().find_map(far),
            Curve::Line { from, to } => far(from).or_else(|| far(to)),
            Curve::Arc { centre, u, v, from, sweep } => {
                let at = |t: f64| centre + u * t.cos() + v * t.sin();
                // Where a coordinate is greatest or least, unless the arc ends before.
                let turning = |axis: usize| {
                    let first = v[axis].atan2(u[axis]);
                    let (low, high) = (from.min(from + sweep), from.max(from + sweep));
                    let next = first + ((low - first) / PI).ceil() * PI;
                    [next, next + PI].into_iter().filter(move |t| *t <= high)
                };
                let stops = [*from, from + sweep].into_iter().chain(turning(0)).chain(turning(1));
                stops.map(at).find_map(|p| far(&p))
            }
        };
        farthest.map_or(Ok(()), |value| Err(CurveFault::TooFar { value, limit: MAX_COORDINATE_MM }))
    }

    /// The Bezier pieces of a spline, in homogeneous coordinates `[w x, w y, w]`: its blossom at the ends of each span of knots.
    pub(super) fn pieces(&self) -> Result<Vec<Vec<[f64; 3]>>, CurveFault> {
        self.check()?;
        let Curve::Spline { degree, knots, points, weights } = self else { return Ok(Vec::new()) };
        let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
        let control: Vec<[f64; 3]> =
            points.iter().enumerate().map(|(k, p)| [p.x * weight(k), p.y * weight(k), weight(k)]).collect();
        let spans = (*degree..points.len()).filter(|&k| knots[k] < knots[k + 1]);
        let piece = |k: usize| {
            let corner = |last: usize| blossom(*degree, knots, &control, k, last);
            (0..=*degree).map(corner).collect()
        };
        Ok(spans.map(piece).collect())
    }

    /// The curve under `x -> matrix x + shift`.
    pub(super) fn mapped(&self, map: &Affine) -> Self {
        match self {
            Curve::Line { from, to } => Curve::Line { from: map.point(from), to: map.point(to) },
            Curve::Arc { centre, u, v, from, sweep } => {
                let (centre, u, v) = (map.point(centre), map.matrix * u, map.matrix * v);
                Curve::Arc { centre, u, v, from: *from, sweep: *sweep }
            }
            Curve::Spline { degree, knots, points, weights } => Curve::Spline {
                degree: *degree,
                knots: knots.clone(),
                points: points.iter().map(|point| map.point(point)).collect(),
                weights: weights.clone(),
            },
        }
    }
}

/// The blossom on the span from `knots[k]` to `knots[k + 1]`, with `last` of its arguments at the end and the others at the begin.
fn blossom(degree: usize, knots: &[f64], control: &[[f64; 3]], k: usize, last: usize) -> [f64; 3] {
    let mut d: Vec<[f64; 3]> = control[k - degree..=k].to_vec();
    for r in 1..=degree {
        let at = if r <= last { knots[k + 1] } else { knots[k] };
        for i in (r..=degree).rev() {
            // The interval contains the span, which is not empty.
            let (low, high) = (knots[i + k - degree], knots[i + 1 + k - r]);
            let share = (at - low) / (high - low);
            let (before, here) = (d[i - 1], d[i]);
            d[i] = [0, 1, 2].map(|c| before[c] + (here[c] - before[c]) * share);
        }
    }
    d[degree]
}

/// An affine map of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    pub matrix: Matrix2<f64>,
    pub shift: Vector2<f64>,
}

impl Affine {
    pub fn scale(factor: f64) -> Self {
        Affine { matrix: Matrix2::identity() * factor, shift: Vector2::zeros() }
    }

    pub fn point(&self, point: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.matrix * point.coords + self.shift)
    }

    /// First `inner`, then this one.
    pub fn after(&self, inner: &Affine) -> Affine {
        Affine { matrix: self.matrix * inner.matrix, shift: self.matrix * inner.shift + self.shift }
    }
}
