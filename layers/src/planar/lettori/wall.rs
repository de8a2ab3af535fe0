//! The separation wall: an upright plane through the line in which the interpolant plane meets the first layer with overhang.
//!
//! Lettori et al. 2022, Fig. 3. The plane is moved along its normal until all of the overhang is on one side. It ends at the
//! bottom of the layer with the first overhang; from there a tilted wall goes down and away from it, so that the torch, half a
//! diameter wide and the stand-off away from what it lays, passes over what stands below.

use super::layers::Layered;
use super::options::VolumeOptions;
use super::rectangle::largest_rectangle;
use super::regions::OverhangRegion;
use crate::planar::CutPlane;
use nalgebra::{Matrix3, Point2, Point3, SymmetricEigen, Vector3};

/// Two planes that bound the part to take off: it is above both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationWall {
    /// The separation plane; its normal is the printing direction of what is taken off.
    pub upright: CutPlane,
    /// The tilted wall.
    pub tilted: CutPlane,
}

/// How nearly level the interpolant plane may be before its line with the layer has no direction: the sine of a degree.
const LEVEL: f64 = 0.0175;

/// How much of the area that carries a region must stay behind the wall. Less, and the wall cuts off what it should lean on.
const STAYS: f64 = 0.25;

impl SeparationWall {
    /// The wall with a normal across the direction, at `along` from the origin, whose lower edge is at `height`.
    pub(super) fn new(
        direction: &Vector3<f64>,
        normal: &Vector3<f64>,
        along: f64,
        height: f64,
        options: &VolumeOptions,
    ) -> Self {
        let edge = Point3::from(normal * along + direction * height);
        let slope = options.torch_diameter_mm / 2.0 / options.standoff_mm;
        let plane = |normal: Vector3<f64>| {
            CutPlane::through(&edge, &normal).unwrap_or_else(|error| unreachable!("walls have a normal: {error}"))
        };
        let upright = plane(*normal);
        SeparationWall { upright, tilted: plane(direction + upright.normal() * slope) }
    }
}

/// The directions in which points are spread least and most, by principal components. `None` for fewer than two different points.
fn spread(points: &[Point3<f64>]) -> Option<[Vector3<f64>; 2]> {
    let middle = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p.coords - middle) * (p.coords - middle).transpose()).sum();
    if points.len() < 2 || spread.trace() <= 0.0 {
        return None;
    }
    let eigen = SymmetricEigen::new(spread);
    let column = |k: usize| eigen.eigenvectors.column(k).into_owned();
    Some([column(eigen.eigenvalues.imin()), column(eigen.eigenvalues.imax())])
}

/// The interpolant plane of the intersection points: a point and the normal of length 1; `None` for fewer than two different points.
pub(super) fn interpolant(region: &OverhangRegion) -> Option<(Point3<f64>, Vector3<f64>)> {
    let points: Vec<Point3<f64>> = region.points.iter().map(|&(_, p)| p).collect();
    let middle = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    spread(&points).map(|[least, _]| (middle.into(), least))
}

/// The wall in front of a region of overhang, by its intersection points: that of the interpolant plane if a quarter of what
/// carries the region stays behind it; else of the line through the points, else across the way from what is carried to what is
/// not. `None` where no such wall leaves enough.
pub(super) fn wall_of(layered: &Layered, region: &OverhangRegion, options: &VolumeOptions) -> Option<SeparationWall> {
    let d = layered.direction;
    let first = &layered.layers[region.first];
    let carried = if region.first > 0 { &layered.layers[region.first - 1].supported } else { &first.carrier };
    let across = |v: Vector3<f64>| (v - d * v.dot(&d)).try_normalize(LEVEL);
    let (_, lowest) = region.pieces.iter().find(|(layer, _)| *layer == region.first)?;
    let outward = layered.place(&lowest.centroid()?, 0.0) - layered.place(&carried.centroid()?, 0.0);
    let points: Vec<Point3<f64>> = region.points.iter().map(|&(_, p)| p).collect();
    let flat: Vec<Point3<f64>> = points.iter().map(|p| p - d * p.coords.dot(&d)).collect();
    let by_plane = spread(&points).and_then(|[least, _]| across(least));
    let by_line = spread(&flat).and_then(|[_, most]| across(d.cross(&most)));
    for normal in [by_plane, by_line, across(outward)].into_iter().flatten() {
        let normal = normal * if normal.dot(&outward) < 0.0 { -1.0 } else { 1.0 };
        let ends = region.pieces.iter().flat_map(|(_, piece)| piece.points());
        let nearest = ends.map(|p| layered.place(&p, 0.0).coords.dot(&normal)).fold(f64::INFINITY, f64::min);
        let along = nearest - options.tolerance_mm;
        let flat_normal = [normal.dot(&layered.frame.u), normal.dot(&layered.frame.v)];
        let behind = carried.below(flat_normal, along - layered.frame.origin.coords.dot(&normal));
        if behind.area() >= STAYS * carried.area() {
            return Some(SeparationWall::new(&d, &normal, along, first.low, options));
        }
    }
    None
}

/// The four walls around the largest rectangle in what carries a region that has no intersection points: to the right and left of
/// the layer's frame, then above and below. `None` where nothing carries it.
pub(super) fn walls_around(
    layered: &Layered,
    region: &OverhangRegion,
    options: &VolumeOptions,
) -> Option<([SeparationWall; 4], [Point3<f64>; 4])> {
    let first = &layered.layers[region.first];
    let below = if region.first > 0 { &layered.layers[region.first - 1].supported } else { &first.supported };
    let column = below.intersection(&first.section);
    let [low, high] = largest_rectangle(if column.is_empty() { below } else { &column })?;
    let frame = &layered.frame;
    let shift = |v: &Vector3<f64>| frame.origin.coords.dot(v);
    let wall = |normal: Vector3<f64>, flat: f64| {
        SeparationWall::new(&layered.direction, &normal, flat + shift(&normal), first.low, options)
    };
    let corners = [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]];
    let corners = corners.map(|[x, y]| layered.place(&Point2::new(x, y), first.low));
    Some(([wall(frame.u, high.x), wall(-frame.u, -low.x), wall(frame.v, high.y), wall(-frame.v, -low.y)], corners))
}
