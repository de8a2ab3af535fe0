//! Overlaps removed, so that a design is one layer: Brooks, section 4.9, code snippet 4-2.
//!
//! What is printed of a contour is what no earlier one fills. Each closed contour is filled, none is taken as a
//! hole; but outlines of one SVG path are filled together, by the rule of the path.
//!
//! Departs from the thesis: open contours are clipped as well, which its library could not; and a contour is compared only with
//! those whose bounding boxes meet its own, not with a union that grows.

use super::MAX_COORDINATE_MM;
use super::join::Contour;
use super::polygon::{
    Ring, Shape, difference, filled, line_outside, path_area, ring_area, shapes_area, to_points, to_ring, union,
};
use nalgebra::Point2;
use std::collections::BTreeMap;

/// A part of the plane, of one piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its outline, counter-clockwise.
    pub outer: Vec<Point2<f64>>,
    /// Outlines of its holes, clockwise.
    pub holes: Vec<Vec<Point2<f64>>>,
    /// The contour that it is a part of, by its place in the list.
    pub contour: usize,
}

impl Region {
    /// Its area, in square millimetres.
    pub fn area(&self) -> f64 {
        self.rings().map(|ring| super::signed_area(ring)).sum()
    }

    /// The outline, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &Vec<Point2<f64>>> {
        std::iter::once(&self.outer).chain(&self.holes)
    }

    pub(super) fn shape(&self) -> Shape {
        self.rings().map(|ring| to_ring(ring)).collect()
    }

    fn of(shape: Shape, contour: usize) -> Option<Self> {
        let mut rings = shape.iter().map(|ring| to_points(ring));
        Some(Region { outer: rings.next()?, holes: rings.collect(), contour })
    }
}

/// What is left to print of a design.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlaps {
    /// What the closed contours fill, each place once, in the order of the contours.
    pub regions: Vec<Region>,
    /// What of the open contours lies outside of all closed ones.
    pub open: Vec<Contour>,
    /// Regions and open pieces that were left out because they are too small.
    pub dropped: usize,
    /// The area of those regions, in square millimetres.
    pub dropped_mm2: f64,
}

/// Why overlaps could not be removed, or areas not be measured.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OverlapError {
    /// A least area or length is negative or not finite.
    #[error("`{what}` is {value}; it must be 0 or more, and finite")]
    Option {
        /// Its name.
        what: &'static str,
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

/// Bounding boxes.
type Bounds = [[f64; 2]; 2];

fn bounds(rings: &[Ring]) -> Bounds {
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    rings.iter().flatten().fold(start, |[low, high], at| {
        [[low[0].min(at[0]), low[1].min(at[1])], [high[0].max(at[0]), high[1].max(at[1])]]
    })
}

fn meet(a: &Bounds, b: &Bounds) -> bool {
    (0..2).all(|axis| a[0][axis] <= b[1][axis] && b[0][axis] <= a[1][axis])
}

/// Removes from each contour what those before it fill, and from open contours what any closed one fills. A closed contour fills what it
/// encloses; those of a [path](super::PathFill) fill what its rule says, all at the place of the first of them.
///
/// # Arguments
/// * `min_area_mm2`: smaller regions are left out.
/// * `min_length_mm`: shorter open pieces are left out.
///
/// # Errors
/// [`OverlapError`] for a limit or a point that cannot be used.
///
/// # Cost
/// For each contour `O(k log k)` for `k` points of it and of the contours that its bounding box meets.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Contour, remove_overlaps}, nalgebra::Point2};
/// let square = |x: f64| {
///     let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[a, b]| Point2::new(x + a, b));
///     Contour { points: points.to_vec(), closed: true, entity: 0, fill: None }
/// };
/// let overlaps = remove_overlaps(&[square(0.0), square(3.0)], 0.0, 0.0)?;
/// assert_eq!(overlaps.regions.iter().map(|region| region.area().round()).collect::<Vec<_>>(), [16.0, 12.0]);
/// # Ok::<(), curvlay_toolpath::drawing::OverlapError>(())
/// ```
pub fn remove_overlaps(contours: &[Contour], min_area_mm2: f64, min_length_mm: f64) -> Result<Overlaps, OverlapError> {
    for (what, value) in [("min_area_mm2", min_area_mm2), ("min_length_mm", min_length_mm)] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(OverlapError::Option { what, value });
        }
    }
    check(contours)?;
    let areas: Vec<Option<(Vec<Ring>, Bounds)>> = areas(contours)
        .into_iter()
        .map(|rings| {
            let rings = rings?;
            let bounds = bounds(&rings);
            Some((rings, bounds))
        })
        .collect();
    let before = |own: &Bounds, last: usize| -> Vec<Ring> {
        let near = areas[..last].iter().flatten().filter(|(_, bounds)| meet(own, bounds));
        near.flat_map(|(rings, _)| rings.iter().cloned()).collect()
    };
    let mut out = Overlaps::default();
    for (k, contour) in contours.iter().enumerate() {
        if let Some((own, bounds)) = &areas[k] {
            let earlier = before(bounds, k);
            let shapes = if earlier.is_empty() { union(own) } else { difference(own, &earlier) };
            shapes.into_iter().for_each(|shape| out.keep_region(shape, k, min_area_mm2));
        } else if !contour.closed {
            let line = to_ring(&contour.points);
            let all = before(&bounds(std::slice::from_ref(&line)), areas.len());
            let pieces = if all.is_empty() { vec![line] } else { line_outside(&line, &all) };
            pieces.iter().for_each(|piece| out.keep_open(to_points(piece), contour, min_length_mm));
        }
    }
    Ok(out)
}

impl Overlaps {
    fn keep_region(&mut self, shape: Shape, contour: usize, min_area_mm2: f64) {
        let area = shape.iter().map(|ring| ring_area(ring)).sum::<f64>();
        if area < min_area_mm2 {
            self.dropped += 1;
            self.dropped_mm2 += area;
        } else {
            self.regions.extend(Region::of(shape, contour));
        }
    }

    fn keep_open(&mut self, points: Vec<Point2<f64>>, whole: &Contour, min_length_mm: f64) {
        let piece = Contour { points, closed: false, entity: whole.entity, fill: None };
        if piece.length() < min_length_mm || piece.points.len() < 2 {
            self.dropped += 1;
        } else {
            self.open.push(piece);
        }
    }
}

fn check(contours: &[Contour]) -> Result<(), OverlapError> {
    for (contour, piece) in contours.iter().enumerate() {
        let far = |p: &Point2<f64>| !(p.x.abs() <= MAX_COORDINATE_MM && p.y.abs() <= MAX_COORDINATE_MM);
        if let Some(point) = piece.points.iter().position(far) {
            return Err(OverlapError::Point { contour, point });
        }
    }
    Ok(())
}

/// What each contour fills, outlines counter-clockwise and holes clockwise: nothing for an open one, and for those of a path that are
/// not its first.
fn areas(contours: &[Contour]) -> Vec<Option<Vec<Ring>>> {
    let mut paths: BTreeMap<u32, Vec<Ring>> = BTreeMap::new();
    for contour in contours.iter().filter(|contour| contour.closed) {
        if let Some(fill) = contour.fill {
            paths.entry(fill.path).or_default().push(to_ring(&contour.points));
        }
    }
    let area = |contour: &Contour| match contour.fill {
        _ if !contour.closed => None,
        None => Some(vec![filled(&contour.points)]),
        Some(fill) => {
            let rings = paths.remove(&fill.path)?;
            Some(path_area(&rings, fill.rule).into_iter().flatten().collect())
        }
    };
    contours.iter().map(area).collect()
}

/// The area of all that the closed contours fill, in square millimetres: what is left to print, computed in one union.
///
/// # Errors
/// [`OverlapError`] for a point that cannot be used.
///
/// ```
/// use curvlay_toolpath::{drawing::{Contour, union_area}, nalgebra::Point2};
/// let points: Vec<_> = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]].map(Point2::from).into();
/// let square = Contour { points, closed: true, entity: 0, fill: None };
/// assert!((union_area(&[square.clone(), square])? - 16.0).abs() < 1e-9);
/// # Ok::<(), curvlay_toolpath::drawing::OverlapError>(())
/// ```
pub fn union_area(contours: &[Contour]) -> Result<f64, OverlapError> {
    check(contours)?;
    let rings: Vec<Ring> = areas(contours).into_iter().flatten().flatten().collect();
    Ok(if rings.is_empty() { 0.0 } else { shapes_area(&union(&rings)) })
}

/// The sum of the areas that closed contours and paths fill, each by itself, in square millimetres.
///
/// # Errors
/// [`OverlapError`] for a point that cannot be used.
///
/// ```
/// use curvlay_toolpath::{drawing::{Contour, area_sum}, nalgebra::Point2};
/// let points: Vec<_> = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]].map(Point2::from).into();
/// let square = Contour { points, closed: true, entity: 0, fill: None };
/// assert!((area_sum(&[square.clone(), square])? - 32.0).abs() < 1e-9);
/// # Ok::<(), curvlay_toolpath::drawing::OverlapError>(())
/// ```
pub fn area_sum(contours: &[Contour]) -> Result<f64, OverlapError> {
    check(contours)?;
    // Of nothing a sum of floats is -0.
    Ok(areas(contours).iter().flatten().flatten().map(|ring| ring_area(ring)).fold(0.0, |sum, area| sum + area))
}
