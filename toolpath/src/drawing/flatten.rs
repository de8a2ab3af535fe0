//! Curves to polylines: within a tolerance, or in even steps.
//!
//! A circle's chord over the angle `a` is `r (1 - cos(a / 2))` from its arc. On `centre + u cos t + v sin t` the distance is at most
//! that of a circle whose radius is the largest singular value of `[u v]`. A Bezier piece with weights above zero lies in the convex
//! hull of its control points, so it is halved until those are near its chord: a bound, not a sample.

use super::curve::Curve;
use super::drawing::{Drawing, Entity};
use super::fault::{CurveFault, MAX_COORDINATE_MM};
use super::join::Contour;
use nalgebra::{Matrix2, Point2};
use std::f64::consts::TAU;

/// How fine the polylines are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flatten {
    /// No curve is farther than this from its chords, in millimetres.
    Tolerance(f64),
    /// Each curve has points at even distances of at most this, in millimetres; 0.2 in Brooks' thesis, section 4.7. Segments are
    /// divided, too.
    Step(f64),
}

impl Default for Flatten {
    /// 0.01 mm: a tenth of what a printer of this kind can show.
    fn default() -> Self {
        Flatten::Tolerance(0.01)
    }
}

/// Why a drawing could not be flattened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlattenError {
    /// A tolerance or step that is not above zero.
    #[error("the tolerance or step is {value} mm; it must be above 0 and finite")]
    Option {
        /// Its value.
        value: f64,
    },
    /// No entity is on the layers that were asked for.
    #[error("no entity is on the layers asked for; there are: {layers}")]
    NoEntity {
        /// The layers that have entities.
        layers: String,
    },
    /// A curve that cannot be drawn.
    #[error("{kind} number {entity} (line {line}): {fault}")]
    Curve {
        /// Number of the entity, from 1.
        entity: usize,
        /// Its kind, as in the file.
        kind: String,
        /// The line of the file where it begins; 0 where there is no file.
        line: u64,
        /// What is wrong with it.
        fault: CurveFault,
    },
    /// More points than memory should hold.
    #[error("the drawing would have more than {limit} points; take a wider tolerance or step")]
    TooManyPoints {
        /// Greatest number.
        limit: usize,
    },
}

/// Most points of a drawing: 160 MB. A design of metres in steps of 0.2 mm has 100,000.
pub(super) const MAX_POINTS: usize = 10_000_000;

impl Drawing {
    /// The entities on some layers as polylines, one each, in their order.
    ///
    /// # Arguments
    /// * `is_on`: whether the entities of a layer are wanted.
    ///
    /// # Errors
    /// [`FlattenError`] names the entity with its line in the file, or the layers that there are.
    ///
    /// # Cost
    /// `O(n)` for `n` points.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::drawing::{Curve, Drawing, Flatten};
    /// use curvlay_toolpath::nalgebra::Point2;
    /// let mut drawing = Drawing::default();
    /// drawing.add("RIM", [Curve::circle(Point2::origin(), 10.0, 0.0, std::f64::consts::TAU)]);
    /// let contours = drawing.contours(|layer| layer == "RIM", Flatten::Tolerance(0.01))?;
    /// assert!(contours[0].closed && contours[0].points.len() == 71);
    /// # Ok::<(), curvlay_toolpath::drawing::FlattenError>(())
    /// ```
    pub fn contours(&self, is_on: impl Fn(&str) -> bool, flatten: Flatten) -> Result<Vec<Contour>, FlattenError> {
        let (Flatten::Tolerance(value) | Flatten::Step(value)) = flatten;
        if !(value > 0.0 && value.is_finite()) {
            return Err(FlattenError::Option { value });
        }
        let chosen = || self.entities.iter().filter(|entity| is_on(&entity.layer));
        let estimate: f64 =
            chosen().flat_map(|entity| &entity.curves).map(|curve| estimated_points(curve, flatten)).sum();
        // An estimate of curves that cannot be drawn is nothing: they are named below.
        if estimate > MAX_POINTS as f64 && chosen().all(Entity::is_drawable) {
            return Err(FlattenError::TooManyPoints { limit: MAX_POINTS });
        }
        let mut contours = Vec::new();
        let mut left = MAX_POINTS;
        for (number, entity) in self.entities.iter().enumerate().filter(|(_, entity)| is_on(&entity.layer)) {
            let named = |fault: CurveFault| {
                let (kind, line) = (entity.kind.clone(), entity.line);
                FlattenError::Curve { entity: number + 1, kind, line, fault }
            };
            let mut points: Vec<Point2<f64>> = Vec::new();
            for curve in &entity.curves {
                // Before points are made: what is far away would have any number of them.
                curve.drawable().map_err(named)?;
                let before = points.len();
                let fits = match flatten {
                    Flatten::Tolerance(tolerance) => along(curve, tolerance, left, &mut points),
                    Flatten::Step(step) => in_steps(curve, step, left, &mut points),
                };
                fits.ok_or(FlattenError::TooManyPoints { limit: MAX_POINTS })?;
                left -= (points.len() - before).min(left);
            }
            let mut coordinates = points.iter().flat_map(|p| [p.x, p.y]);
            if let Some(value) = coordinates.find(|x| x.is_nan() || x.abs() > MAX_COORDINATE_MM) {
                return Err(named(CurveFault::TooFar { value, limit: MAX_COORDINATE_MM }));
            }
            let farthest = points.iter().flat_map(|p| [p.x.abs(), p.y.abs()]).fold(0.0, f64::max);
            points.dedup();
            // Circles come back to their begin but for rounding, which is far below any tolerance of joining.
            let near = 1e-9 * farthest.max(1e-3);
            let returns = |points: &[Point2<f64>]| {
                points.len() > 2
                    && points.first().zip(points.last()).is_some_and(|(first, last)| (first - last).norm() <= near)
            };
            let returned = returns(&points);
            if returned {
                points.pop();
            }
            let closed = points.len() > 2 && (entity.closed || returned);
            contours.push(Contour { points, closed, entity: number, fill: entity.fill.filter(|_| closed) });
        }
        if contours.is_empty() {
            let layers: Vec<String> = self.layers().into_iter().map(|(name, _)| name).collect();
            let layers = if layers.is_empty() { "none".to_owned() } else { layers.join(", ") };
            return Err(FlattenError::NoEntity { layers });
        }
        Ok(contours)
    }
}

impl Entity {
    fn is_drawable(&self) -> bool {
        self.curves.iter().all(|curve| curve.drawable().is_ok())
    }
}

/// Roughly how many points a curve would have: by the chords of arcs, and by the second differences of a spline's
/// control points, which bound how far its chords are from it (Wang's formula).
fn estimated_points(curve: &Curve, flatten: Flatten) -> f64 {
    let (tolerance, step) = match flatten {
        Flatten::Tolerance(tolerance) => (tolerance, f64::INFINITY),
        Flatten::Step(step) => (step * STEP_TOLERANCE, step),
    };
    match curve {
        Curve::Line { from, to } => 2.0 + (to - from).norm() / step,
        Curve::Arc { u, v, sweep, .. } => {
            let radius = u.norm().max(v.norm());
            let chord = (8.0 * tolerance / radius).sqrt();
            2.0 + sweep.abs() / chord.min(TAU / 3.0) + sweep.abs() * radius / step
        }
        Curve::Spline { degree, points, .. } => {
            let bends = points.windows(3).map(|p| ((p[2] - p[1]) - (p[1] - p[0])).norm());
            let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
            let degree = *degree as f64;
            let chords = |bend: f64| (degree * (degree - 1.0) / 8.0 * bend / tolerance).sqrt();
            // Of several pieces the sharpest alone is counted.
            2.0 + bends.map(chords).fold(0.0, f64::max).max(length / step)
        }
    }
}

/// Appends the points of a curve within a tolerance; `None` if there would be more than `most`. A begin where the last point is
/// comes twice.
fn along(curve: &Curve, tolerance: f64, most: usize, points: &mut Vec<Point2<f64>>) -> Option<()> {
    match curve {
        Curve::Line { from, to } => points.extend([*from, *to]),
        Curve::Arc { centre, u, v, from, sweep } => {
            let radius = Matrix2::from_columns(&[*u, *v]).singular_values().max();
            // At least a corner a third of a turn, or the polygon has no area.
            let chord = if tolerance < radius { 2.0 * (1.0 - tolerance / radius).acos() } else { TAU / 3.0 };
            let chords = arc_chords(sweep.abs() / chord.min(TAU / 3.0), most)?;
            let point = |k: usize| {
                let (sin, cos) = (from + sweep * (k as f64 / chords as f64)).sin_cos();
                centre + u * cos + v * sin
            };
            points.extend((0..=chords).map(point));
        }
        Curve::Spline { .. } => {
            for piece in curve.pieces().unwrap_or_default() {
                points.push(plane(piece.first()?));
                let farthest = piece.iter().map(plane).flat_map(|p| [p.x.abs(), p.y.abs()]).fold(0.0, f64::max);
                halve(&piece, tolerance.max(ROUNDING * farthest), 0, most, points)?;
            }
        }
    }
    (points.len() <= most).then_some(())
}

fn arc_chords(wanted: f64, most: usize) -> Option<usize> {
    (wanted <= most as f64).then(|| wanted.ceil().max(1.0) as usize)
}

fn plane([x, y, w]: &[f64; 3]) -> Point2<f64> {
    Point2::new(x / w, y / w)
}

/// Share of the farthest coordinate of a Bezier piece below which rounding alone keeps its points off a chord.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Halvings of a Bezier piece: 2^24 chords are beyond any tolerance that makes sense, and end what rounding keeps apart.
const DEEPEST: u32 = 24;

/// Appends the points of a Bezier piece but for its first.
fn halve(piece: &[[f64; 3]], tolerance: f64, depth: u32, most: usize, points: &mut Vec<Point2<f64>>) -> Option<()> {
    let (first, last) = (plane(piece.first()?), plane(piece.last()?));
    let chord = last - first;
    let distance = |at: &[f64; 3]| {
        let (at, square) = (plane(at) - first, chord.norm_squared());
        let share = if square > 0.0 { (at.dot(&chord) / square).clamp(0.0, 1.0) } else { 0.0 };
        (at - chord * share).norm()
    };
    if depth >= DEEPEST || piece.iter().all(|at| distance(at) <= tolerance) {
        points.push(last);
        return (points.len() <= most).then_some(());
    }
    // De Casteljau at the middle.
    let (mut left, mut right) = (vec![piece[0]], vec![*piece.last()?]);
    let mut row = piece.to_vec();
    while row.len() > 1 {
        row = row.windows(2).map(|pair| [0, 1, 2].map(|c| 0.5 * (pair[0][c] + pair[1][c]))).collect();
        left.push(*row.first()?);
        right.push(*row.last()?);
    }
    right.reverse();
    halve(&left, tolerance, depth + 1, most, points)?;
    halve(&right, tolerance, depth + 1, most, points)
}

/// A curve is measured along chords within this share of the step.
const STEP_TOLERANCE: f64 = 0.01;

/// Appends the points of a curve at even distances.
fn in_steps(curve: &Curve, step: f64, most: usize, points: &mut Vec<Point2<f64>>) -> Option<()> {
    let mut fine = Vec::new();
    along(curve, step * STEP_TOLERANCE, most, &mut fine)?;
    points.extend(resampled(&fine, step, most)?);
    (points.len() <= most).then_some(())
}

/// Points at even distances of at most `step` along a polyline, with both ends; `None` if there would be more than `most`.
pub(super) fn resampled(line: &[Point2<f64>], step: f64, most: usize) -> Option<Vec<Point2<f64>>> {
    let lengths: Vec<f64> = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
    let total: f64 = lengths.iter().sum();
    // A length that is a whole number of steps but for rounding has so many.
    let steps = arc_chords((total / step - 1e-9).max(0.0), most)?;
    let mut out = Vec::with_capacity(steps + 1);
    let (mut segment, mut passed) = (0, 0.0);
    out.extend(line.first());
    for k in 1..steps {
        let wanted = total * (k as f64 / steps as f64);
        while segment + 1 < lengths.len() && passed + lengths[segment] < wanted {
            passed += lengths[segment];
            segment += 1;
        }
        let share = if lengths[segment] > 0.0 { ((wanted - passed) / lengths[segment]).clamp(0.0, 1.0) } else { 0.0 };
        out.push(line[segment] + (line[segment + 1] - line[segment]) * share);
    }
    if line.len() > 1 {
        out.extend(line.last());
    }
    Some(out)
}
