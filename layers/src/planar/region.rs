//! Regions of a plane: nested polygons with booleans and offsets, by `i_overlay` on a 64-bit integer grid.
//!
//! Coordinates are rounded to a grid of some 1e-15 of the region's size for each operation, and the topology is then exact.

use super::solid::SectionPolygon;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};
use nalgebra::{Point2, Vector2};

/// Greatest coordinate and offset of a region, in millimetres: a thousand kilometres, on whose grid a nanometre is left.
pub const MAX_LENGTH_MM: f64 = 1e9;

/// Why there is no such region.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionError {
    /// A coordinate is not finite, or too large.
    #[error("polygon {polygon} has a coordinate that is not finite, or beyond {MAX_LENGTH_MM:e} mm")]
    Point {
        /// The polygon, from 0.
        polygon: usize,
    },
    /// A distance is not finite, or too large.
    #[error("an offset of {by} mm: it must be from -{MAX_LENGTH_MM:e} to {MAX_LENGTH_MM:e} mm")]
    Offset {
        /// The distance, in millimetres.
        by: f64,
    },
    /// A normal of another length than 1.
    #[error("a normal of length {length}: it must be 1")]
    Normal {
        /// Its length.
        length: f64,
    },
}

type Shapes = Vec<Vec<Vec<[f64; 2]>>>;

/// A set of points in a plane, bounded by polygons. May be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Each an outline, counter-clockwise, and its holes.
    shapes: Shapes,
}

/// The longest chord of the arcs around corners that an offset has, in radii. A chord is then at most 0.0013 radii inside its
/// arc; half of it doubles the corners of every region.
const CHORD: f64 = 0.1;

impl Region {
    /// The region inside polygons; where they overlap it is inside as well.
    ///
    /// # Errors
    /// [`RegionError::Point`] for a coordinate that is not finite, or beyond [`MAX_LENGTH_MM`].
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Point2;
    /// use curvlay_layers::planar::{Region, SectionPolygon};
    /// let square = |x: f64| SectionPolygon {
    ///     outer: [[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 2.0], [x, 2.0]].map(|[x, y]| Point2::new(x, y)).to_vec(),
    ///     holes: Vec::new(),
    /// };
    /// let (left, right) = (Region::new(&[square(0.0)])?, Region::new(&[square(1.0)])?);
    /// assert!((left.union(&right).area() - 6.0).abs() < 1e-9);
    /// assert!((left.difference(&right).area() - 2.0).abs() < 1e-9);
    /// assert!((left.intersection(&right).offset(-0.5)?.area() - 0.0).abs() < 1e-9);
    /// # Ok::<(), curvlay_layers::planar::RegionError>(())
    /// ```
    pub fn new(polygons: &[SectionPolygon]) -> Result<Self, RegionError> {
        let far = |p: &Point2<f64>| !p.iter().all(|x| x.abs() <= MAX_LENGTH_MM);
        for (polygon, rings) in polygons.iter().enumerate() {
            if std::iter::once(&rings.outer).chain(&rings.holes).flatten().any(far) {
                return Err(RegionError::Point { polygon });
            }
        }
        Ok(Region::of(polygons))
    }

    /// The region inside polygons whose points are known to be sound: sections of solids.
    pub(crate) fn of(polygons: &[SectionPolygon]) -> Self {
        let flat = |points: &Vec<Point2<f64>>| points.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>();
        let shapes: Shapes = polygons
            .iter()
            .map(|polygon| std::iter::once(&polygon.outer).chain(&polygon.holes).map(flat).collect())
            .collect();
        Region { shapes }.overlay(&Region::default(), OverlayRule::Subject)
    }

    fn overlay(&self, other: &Region, rule: OverlayRule) -> Region {
        Region { shapes: self.shapes.overlay_as::<i64>(&other.shapes, rule, FillRule::NonZero) }
    }

    /// The points in either.
    pub fn union(&self, other: &Region) -> Region {
        self.overlay(other, OverlayRule::Union)
    }

    /// The points in both.
    pub fn intersection(&self, other: &Region) -> Region {
        self.overlay(other, OverlayRule::Intersect)
    }

    /// The points that are not in `other`.
    pub fn difference(&self, other: &Region) -> Region {
        self.overlay(other, OverlayRule::Difference)
    }

    /// The region grown by a distance on all sides, with round corners; shrunk by a negative one.
    ///
    /// # Errors
    /// [`RegionError::Offset`] for a distance that is not finite, or beyond [`MAX_LENGTH_MM`].
    pub fn offset(&self, by: f64) -> Result<Region, RegionError> {
        if by.abs() <= MAX_LENGTH_MM { Ok(self.grown(by)) } else { Err(RegionError::Offset { by }) }
    }

    /// The same for a distance that is known to be in range.
    pub(crate) fn grown(&self, by: f64) -> Region {
        if self.shapes.is_empty() || by == 0.0 {
            return self.clone();
        }
        let style = OutlineStyle::new(by).line_join(LineJoin::Round(CHORD));
        Region { shapes: self.shapes.outline_as::<i64>(&style) }
    }

    /// The region with fewer corners: outlines move by at most `within` (U. Ramer, 1972; D. Douglas and T. Peucker, 1973). Without
    /// it, each offset of an offset doubles the corners.
    pub fn simplified(&self, within: f64) -> Region {
        let contours = |shape: &Vec<Vec<[f64; 2]>>| shape.iter().map(|contour| simplified(contour, within)).collect();
        let shapes = self.shapes.iter().map(contours).collect();
        Region { shapes }.overlay(&Region::default(), OverlayRule::Subject)
    }

    /// Whether it has no points.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// The area, without holes.
    pub fn area(&self) -> f64 {
        self.shapes.iter().map(|shape| area(shape)).sum()
    }

    /// Its connected pieces.
    pub fn pieces(&self) -> Vec<Region> {
        self.shapes.iter().map(|shape| Region { shapes: vec![shape.clone()] }).collect()
    }

    /// Without the pieces whose area is at most so large.
    pub fn without_specks(mut self, largest: f64) -> Region {
        self.shapes.retain(|shape| area(shape) > largest);
        self
    }

    /// Its polygons.
    pub fn polygons(&self) -> Vec<SectionPolygon> {
        let points = |contour: &Vec<[f64; 2]>| contour.iter().map(|&p| Point2::from(p)).collect::<Vec<_>>();
        let polygon = |shape: &Vec<Vec<[f64; 2]>>| SectionPolygon {
            outer: points(&shape[0]),
            holes: shape[1..].iter().map(points).collect(),
        };
        self.shapes.iter().filter(|shape| !shape.is_empty()).map(polygon).collect()
    }

    /// All corners.
    pub fn points(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.shapes.iter().flatten().flatten().map(|&p| Point2::from(p))
    }

    /// All edges.
    pub fn edges(&self) -> impl Iterator<Item = [Point2<f64>; 2]> + '_ {
        let closed = |contour: &Vec<[f64; 2]>| {
            let n = contour.len();
            (0..n).map(|k| [contour[k].into(), contour[(k + 1) % n].into()]).collect::<Vec<_>>()
        };
        self.shapes.iter().flatten().flat_map(closed)
    }

    /// Least and greatest coordinates; `None` if it is empty.
    pub fn bounds(&self) -> Option<[Point2<f64>; 2]> {
        self.points().fold(None, |bounds, p| {
            let [low, high] = bounds.unwrap_or([p, p]);
            Some([low.inf(&p), high.sup(&p)])
        })
    }

    /// Whether a point is inside; on the boundary either.
    pub fn contains(&self, p: &Point2<f64>) -> bool {
        let crossings = self
            .edges()
            .filter(|[a, b]| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)));
        crossings.count() % 2 == 1
    }

    /// The middle of its area; `None` if it is empty.
    pub fn centroid(&self) -> Option<Point2<f64>> {
        let [from, _] = self.bounds()?;
        let (mut sum, mut moment) = (0.0, Vector2::zeros());
        for [a, b] in self.edges() {
            let (a, b) = (a - from, b - from);
            let doubled = a.perp(&b);
            sum += doubled;
            moment += (a + b) * doubled;
        }
        (sum > 0.0).then(|| from + moment / (3.0 * sum))
    }

    /// The part of it where `normal . p` is at most `offset`; the normal has the length 1.
    ///
    /// # Errors
    /// [`RegionError::Normal`] for a normal of another length, by more than 1e-6; [`RegionError::Offset`] for an offset that is not a number.
    pub fn half(&self, normal: [f64; 2], offset: f64) -> Result<Region, RegionError> {
        let length = normal[0].hypot(normal[1]);
        if length.is_nan() || (length - 1.0).abs() > 1e-6 {
            return Err(RegionError::Normal { length });
        }
        if offset.is_nan() { Err(RegionError::Offset { by: offset }) } else { Ok(self.below(normal, offset)) }
    }

    /// The same for a line that is known to be sound.
    pub(crate) fn below(&self, normal: [f64; 2], offset: f64) -> Region {
        let Some([low, high]) = self.bounds() else { return Region::default() };
        let n = Vector2::from(normal);
        let middle = low + (high - low) / 2.0;
        // A square on this side of the line, larger than the region on all sides.
        let size = (high - low).norm() + 1.0;
        let (edge, along) =
            (middle + n * (offset - middle.coords.dot(&n)).clamp(-size, size), Vector2::new(-n.y, n.x) * size);
        let far = edge - n * (3.0 * size);
        let outer = vec![edge - along, edge + along, far + along, far - along];
        self.intersection(&Region::of(&[SectionPolygon { outer, holes: Vec::new() }]))
    }

    /// A point well inside the first piece: the middle of the longest line of the region at half its height.
    pub fn inner_point(&self) -> Option<Point2<f64>> {
        let first = Region { shapes: self.shapes.first().map(|shape| vec![shape.clone()])? };
        let [low, high] = first.bounds()?;
        // Not at half the height exactly, where corners of symmetrical shapes lie.
        let y = low.y + (high.y - low.y) * 0.487;
        let mut at: Vec<f64> = first
            .edges()
            .filter(|[a, b]| (a.y > y) != (b.y > y))
            .map(|[a, b]| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)))
            .collect();
        at.sort_by(f64::total_cmp);
        let widest = at.chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
        Some(Point2::new((widest[0] + widest[1]) / 2.0, y))
    }
}

/// The corners of a closed contour that are needed.
fn simplified(contour: &[[f64; 2]], within: f64) -> Vec<[f64; 2]> {
    let n = contour.len();
    let far = |a: usize, k: usize| {
        let d = [0, 1].map(|i| contour[k][i] - contour[a][i]);
        d[0].hypot(d[1])
    };
    let Some(opposite) = (0..n).max_by(|&a, &b| far(0, a).total_cmp(&far(0, b))) else { return Vec::new() };
    let mut needed = vec![false; n + 1];
    (needed[0], needed[opposite]) = (true, true);
    let mut open = vec![[0, opposite], [opposite, n]];
    while let Some([from, to]) = open.pop() {
        let (a, b) = (contour[from], contour[to % n]);
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
        let off = |k: usize| {
            let [x, y] = [contour[k][0] - a[0], contour[k][1] - a[1]];
            ((dx * y - dy * x) / length).abs()
        };
        let Some(furthest) = (from + 1..to).max_by(|&a, &b| off(a).total_cmp(&off(b))) else { continue };
        if off(furthest) > within {
            needed[furthest] = true;
            open.extend([[from, furthest], [furthest, to]]);
        }
    }
    (0..n).filter(|&k| needed[k]).map(|k| contour[k]).collect()
}

fn area(shape: &[Vec<[f64; 2]>]) -> f64 {
    let of = |contour: &Vec<[f64; 2]>| {
        let n = contour.len();
        let doubled = |k: usize| {
            let [a, b] = [contour[k], contour[(k + 1) % n]].map(|p| [p[0] - contour[0][0], p[1] - contour[0][1]]);
            a[0] * b[1] - a[1] * b[0]
        };
        (0..n).map(doubled).sum::<f64>() / 2.0
    };
    shape.iter().map(of).sum()
}
