//! Pieces of a drawing joined where their ends meet: Brooks, section 4.7.
//!
//! The thesis compares every end with every other. Here ends lie in a grid whose cells are as wide as the tolerance, so an end
//! looks into nine cells. Closed and open contours stand side by side.

use super::drawing::PathFill;
use super::fault::MAX_COORDINATE_MM;
use crate::cells::cell_along;
use nalgebra::Point2;
use std::collections::HashMap;

/// A polyline of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Its points; of a closed one the first does not come again.
    pub points: Vec<Point2<f64>>,
    /// Whether it returns to its begin.
    pub closed: bool,
    /// The entity where it begins, counted from 0.
    pub entity: usize,
    /// The path with several outlines that it is a part of, as in [`Entity`](super::Entity::fill).
    pub fill: Option<PathFill>,
}

impl Contour {
    /// Its length, in millimetres.
    pub fn length(&self) -> f64 {
        let back = self.points.last().zip(self.points.first()).filter(|_| self.closed);
        let along: f64 = self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        along + back.map_or(0.0, |(last, first)| (first - last).norm())
    }
}

/// What joining left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joined {
    /// Closed and open contours, in the order of the first piece of each.
    pub contours: Vec<Contour>,
    /// Pieces that lay on an earlier one, point by point, and were removed.
    pub duplicates: usize,
    /// Pieces no longer than the tolerance, which were removed.
    pub zero_length: usize,
}

/// Why pieces could not be joined.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JoinError {
    /// The tolerance is negative or not finite.
    #[error("the tolerance is {value} mm; it must be 0 or more, and finite")]
    Tolerance {
        /// Its value.
        value: f64,
    },
    /// A point is not finite, or too far away.
    #[error("contour {contour}: point {point} is not finite, or beyond 1e6 mm")]
    Point {
        /// The contour, from 0.
        contour: usize,
        /// The point, from 0.
        point: usize,
    },
}

/// Joins pieces whose ends are no farther apart than `tolerance`, in any orientation.
///
/// A contour grows from the first piece that is left: at its end by the nearest end (of equals the first) until none is near,
/// then at its begin. It is closed as soon as its ends meet. Ends that meet become one point, in their middle.
/// First, pieces of no length and those that lie on an earlier one are removed.
///
/// # Errors
/// [`JoinError`] for a tolerance or a point that cannot be used.
///
/// # Cost
/// `O(n)` for `n` points, as long as few ends meet at a place.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{Contour, join};
/// use curvlay_toolpath::nalgebra::Point2;
/// let piece = |a: [f64; 2], b: [f64; 2]| Contour { points: vec![a.into(), b.into()], closed: false, entity: 0, fill: None };
/// // A triangle, one side the wrong way round, and a gap of 0.003 mm.
/// let sides = [piece([0.0, 0.0], [9.0, 0.0]), piece([0.0, 9.0], [9.003, 0.0]), piece([0.0, 9.0], [0.0, 0.0])];
/// let joined = join(&sides, 0.005)?;
/// assert_eq!(joined.contours.len(), 1);
/// assert!(joined.contours[0].closed && joined.contours[0].points.len() == 3);
/// # Ok::<(), curvlay_toolpath::drawing::JoinError>(())
/// ```
pub fn join(pieces: &[Contour], tolerance: f64) -> Result<Joined, JoinError> {
    check(pieces, tolerance)?;
    let long: Vec<&Contour> = pieces.iter().filter(|piece| piece.length() > tolerance).collect();
    let zero_length = pieces.len() - long.len();
    let single = without_duplicates(&long, tolerance);
    let duplicates = long.len() - single.len();

    let mut ends = Grid::new(tolerance);
    for (k, piece) in single.iter().enumerate().filter(|(_, piece)| !piece.closed) {
        for (side, at) in [piece.points.first(), piece.points.last()].into_iter().enumerate() {
            at.into_iter().for_each(|at| ends.add(at, (k, side)));
        }
    }
    let mut used = vec![false; single.len()];
    let mut contours = Vec::new();
    for k in 0..single.len() {
        if std::mem::replace(&mut used[k], true) {
            continue;
        }
        let mut chain = single[k].clone();
        // Twice: on from the end, and, turned round, on from the begin.
        for _ in 0..2 {
            while !chain.closed {
                let Some(&end) = chain.points.last() else { break };
                // Two points that meet are a way there and back, no contour.
                let returns = chain.points.len() > 3 || (chain.points.len() == 3 && chain.length() > 2.0 * tolerance);
                if returns && (end - chain.points[0]).norm() <= tolerance {
                    chain.points[0] = middle(&chain.points[0], &end);
                    chain.points.pop();
                    chain.closed = true;
                    break;
                }
                let Some((next, side)) = ends.nearest(&end, |&(k, _)| !used[k]) else { break };
                used[next] = true;
                let mut more = single[next].points.clone();
                if side == 1 {
                    more.reverse();
                }
                if let Some(last) = chain.points.last_mut() {
                    *last = middle(&end, &more[0]);
                }
                chain.points.extend(more.into_iter().skip(1));
            }
            if !chain.closed {
                chain.points.reverse();
            }
        }
        contours.push(chain);
    }
    Ok(Joined { contours, duplicates, zero_length })
}

fn middle(a: &Point2<f64>, b: &Point2<f64>) -> Point2<f64> {
    nalgebra::center(a, b)
}

/// Two open ends that nearly meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Between them.
    pub at: Point2<f64>,
    /// Their distance, in millimetres.
    pub width: f64,
}

/// The gaps that keep joined contours open: ends of open ones, each with the nearest other end, if that is no farther than `widest`.
///
/// # Arguments
/// * `widest`: in millimetres.
///
/// # Errors
/// [`JoinError`] for a width or a point that cannot be used.
///
/// # Cost
/// `O(n)` for `n` contours, as long as few ends meet at a place.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{Contour, gaps};
/// let points = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 0.03]].map(Into::into).to_vec();
/// let gaps = gaps(&[Contour { points, closed: false, entity: 0, fill: None }], 0.5)?;
/// assert!(gaps.len() == 1 && (gaps[0].width - 0.03).abs() < 1e-12);
/// # Ok::<(), curvlay_toolpath::drawing::JoinError>(())
/// ```
pub fn gaps(contours: &[Contour], widest: f64) -> Result<Vec<Gap>, JoinError> {
    check(contours, widest)?;
    // A line that is no longer than the gap has no gap between its own ends.
    let open = contours.iter().enumerate().filter(|(_, contour)| !contour.closed && contour.length() > 2.0 * widest);
    let ends: Vec<(Point2<f64>, (usize, usize))> = open
        .flat_map(|(k, contour)| {
            let both = [contour.points.first(), contour.points.last()];
            both.into_iter().flatten().enumerate().map(move |(side, at)| (*at, (k, side)))
        })
        .collect();
    let mut grid = Grid::new(widest);
    ends.iter().for_each(|(at, end)| grid.add(at, *end));
    let mut gaps = Vec::new();
    for (at, end) in &ends {
        let Some(other) = grid.nearest(at, |other| other != end) else { continue };
        let points = &contours[other.0].points;
        let there = if other.1 == 0 { points[0] } else { points[points.len() - 1] };
        // Each pair once, when its later end is looked at; an end whose nearest has a nearer one counts by itself.
        let mutual = grid.nearest(&there, |back| *back != other) == Some(*end);
        if !mutual || other < *end {
            gaps.push(Gap { at: middle(at, &there), width: (at - there).norm() });
        }
    }
    Ok(gaps)
}

fn check(contours: &[Contour], tolerance: f64) -> Result<(), JoinError> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(JoinError::Tolerance { value: tolerance });
    }
    for (contour, piece) in contours.iter().enumerate() {
        let far = |p: &Point2<f64>| !(p.x.abs() <= MAX_COORDINATE_MM && p.y.abs() <= MAX_COORDINATE_MM);
        if let Some(point) = piece.points.iter().position(far) {
            return Err(JoinError::Point { contour, point });
        }
    }
    Ok(())
}

/// Pieces but for those that have the points of an earlier one, in either direction and, if closed, from any begin.
fn without_duplicates<'a>(pieces: &[&'a Contour], tolerance: f64) -> Vec<&'a Contour> {
    let mut corners = Grid::new(tolerance);
    let mut kept: Vec<&Contour> = Vec::new();
    for piece in pieces {
        // Pieces on each other have this corner of their bounding boxes together.
        let low = piece.points.iter().fold([f64::INFINITY; 2], |low, p| [low[0].min(p.x), low[1].min(p.y)]);
        let low = Point2::from(low);
        let known = corners.near(&low).any(|(_, &other): (f64, &usize)| lies_on(kept[other], piece, tolerance));
        if !known {
            corners.add(&low, kept.len());
            kept.push(piece);
        }
    }
    kept
}

fn lies_on(a: &Contour, b: &Contour, tolerance: f64) -> bool {
    let n = a.points.len();
    // Outlines of a path are not redundant: they may cancel each other.
    if n != b.points.len() || a.closed != b.closed || n == 0 || a.fill.is_some() || b.fill.is_some() {
        return false;
    }
    let near = |i: usize, k: usize| (a.points[i] - b.points[k]).norm() <= tolerance;
    let shifts = if a.closed { 0..n } else { 0..1 };
    let forward = |shift: usize| (0..n).all(|i| near(i, (i + shift) % n));
    let backward = |shift: usize| (0..n).all(|i| near(i, (2 * n - 1 - i - shift) % n));
    shifts.clone().any(forward) || shifts.into_iter().any(backward)
}

/// Things at points, found again within a distance.
pub(super) struct Grid<T> {
    reach: f64,
    cells: HashMap<[i64; 2], Vec<(Point2<f64>, T)>>,
}

impl<T: Copy> Grid<T> {
    /// Finds what is within `reach`.
    pub fn new(reach: f64) -> Self {
        Grid { reach, cells: HashMap::new() }
    }

    fn cell(&self, at: &Point2<f64>) -> [i64; 2] {
        // Points within 1e6 mm in cells of at least a picometre; others are in the last cell, which has neighbours, too.
        let width = self.reach.max(1e-9);
        [at.x, at.y].map(|x| cell_along(x, width))
    }

    pub fn add(&mut self, at: &Point2<f64>, thing: T) {
        let cell = self.cell(at);
        self.cells.entry(cell).or_default().push((*at, thing));
    }

    /// What is within reach, with its distance, in the order of its cells and there in that in which it was added.
    pub fn near(&self, at: &Point2<f64>) -> impl Iterator<Item = (f64, &T)> {
        let ([x, y], at, reach) = (self.cell(at), *at, self.reach);
        let cells = (-1..=1).flat_map(move |i| (-1..=1).map(move |k| [x + i, y + k]));
        let things = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
        things.map(move |(place, thing)| ((place - at).norm(), thing)).filter(move |(distance, _)| *distance <= reach)
    }

    /// The nearest within reach, of equals the least.
    pub fn nearest(&self, at: &Point2<f64>, fits: impl Fn(&T) -> bool) -> Option<T>
    where
        T: Ord,
    {
        let near = self.near(at).filter(|(_, thing)| fits(thing));
        near.min_by(|(a, s), (b, t)| a.total_cmp(b).then(s.cmp(t))).map(|(_, thing)| *thing)
    }
}
