//! Overlaps removed, so that a design is one layer: Brooks, section 4.9, code snippet 4-2.
//!
//! What is printed of a contour is what no earlier one fills. Each closed contour is filled, none is taken as a hole.
//!
//! Departs from the thesis: open contours are clipped as well, which its library could not; and a contour is compared only with
//! those whose bounding boxes meet its own, not with a union that grows.

use super::join::Contour;
use super::polygon::{
    Ring, Shape, difference, filled, line_outside, ring_area, shapes_area, to_points, to_ring, union,
};
use nalgebra::Point2;

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

/// Bounding boxes.
type Bounds = [[f64; 2]; 2];

fn bounds(ring: &[[f64; 2]]) -> Bounds {
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    ring.iter().fold(start, |[low, high], at| {
        [[low[0].min(at[0]), low[1].min(at[1])], [high[0].max(at[0]), high[1].max(at[1])]]
    })
}

fn meet(a: &Bounds, b: &Bounds) -> bool {
    (0..2).all(|axis| a[0][axis] <= b[1][axis] && b[0][axis] <= a[1][axis])
}

/// Removes from each contour what those before it fill, and from open contours what any closed one fills.
///
/// # Arguments
/// * `min_area_mm2`: smaller regions are left out.
/// * `min_length_mm`: shorter open pieces are left out.
///
/// # Cost
/// For each contour `O(k log k)` for `k` points of it and of the contours that its bounding box meets.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Contour, remove_overlaps}, nalgebra::Point2};
/// let square = |x: f64| {
///     let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[a, b]| Point2::new(x + a, b));
///     Contour { points: points.to_vec(), closed: true, entity: 0 }
/// };
/// let overlaps = remove_overlaps(&[square(0.0), square(3.0)], 0.0, 0.0);
/// assert_eq!(overlaps.regions.iter().map(|region| region.area().round()).collect::<Vec<_>>(), [16.0, 12.0]);
/// ```
pub fn remove_overlaps(contours: &[Contour], min_area_mm2: f64, min_length_mm: f64) -> Overlaps {
    let rings: Vec<Option<(Ring, Bounds)>> = contours
        .iter()
        .map(|contour| {
            let ring = contour.closed.then(|| filled(&contour.points))?;
            let bounds = bounds(&ring);
            Some((ring, bounds))
        })
        .collect();
    let mut out = Overlaps::default();
    for (k, contour) in contours.iter().enumerate() {
        let others = |own: &Bounds, last: usize| -> Vec<Ring> {
            let near = rings[..last].iter().flatten().filter(|(_, bounds)| meet(own, bounds));
            near.map(|(ring, _)| ring.clone()).collect()
        };
        if let Some((ring, own)) = &rings[k] {
            let before = others(own, k);
            let own = vec![ring.clone()];
            let shapes = if before.is_empty() { union(&own) } else { difference(&own, &before) };
            for shape in shapes {
                let area = shape.iter().map(|ring| ring_area(ring)).sum::<f64>();
                if area < min_area_mm2 {
                    out.dropped += 1;
                    out.dropped_mm2 += area;
                } else {
                    out.regions.extend(Region::of(shape, k));
                }
            }
        } else {
            let line = to_ring(&contour.points);
            let all = others(&bounds(&line), rings.len());
            let pieces = if all.is_empty() { vec![line] } else { line_outside(&line, &all) };
            for piece in pieces {
                let piece = Contour { points: to_points(&piece), closed: false, entity: contour.entity };
                if piece.length() < min_length_mm || piece.points.len() < 2 {
                    out.dropped += 1;
                } else {
                    out.open.push(piece);
                }
            }
        }
    }
    out
}

/// The area of all that the closed contours fill, in square millimetres: what is left to print, computed in one union.
/// ```
/// use curvlay_toolpath::{drawing::{Contour, union_area}, nalgebra::Point2};
/// let points: Vec<_> = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]].map(Point2::from).into();
/// let square = Contour { points, closed: true, entity: 0 };
/// assert!((union_area(&[square.clone(), square]) - 16.0).abs() < 1e-9);
/// ```
pub fn union_area(contours: &[Contour]) -> f64 {
    let rings: Vec<Ring> =
        contours.iter().filter(|contour| contour.closed).map(|contour| filled(&contour.points)).collect();
    if rings.is_empty() { 0.0 } else { shapes_area(&union(&rings)) }
}
