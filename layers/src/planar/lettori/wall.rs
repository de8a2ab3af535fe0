//! The separation wall: an upright plane through the line in which the interpolant plane meets the first layer with overhang.
//!
//! Lettori et al. 2022, Fig. 3. The plane is moved along its normal until all of the overhang is on one side. It ends at the
//! bottom of the layer with the first overhang; from there a tilted wall goes down and away from it, so that the torch, half a
//! diameter wide and the stand-off away from what it lays, passes over what stands below.
//! Departure: where the torch would be blocked beside an upright wall, a wall that leans back is tried as well.

use super::layers::Layered;
use super::options::VolumeOptions;
use super::rectangle::largest_rectangle;
use super::regions::OverhangRegion;
use crate::planar::{CutPlane, Region};
use nalgebra::{Matrix3, Point2, Point3, SymmetricEigen, Vector2, Vector3};

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
    /// The wall with a normal, through a point of its lower edge; `up` is the direction across the normal from which the tilted wall comes.
    fn new(up: &Vector3<f64>, normal: &Vector3<f64>, edge: &Point3<f64>, options: &VolumeOptions) -> Self {
        let slope = options.torch_diameter_mm / 2.0 / options.standoff_mm;
        let plane = |normal: Vector3<f64>| {
            CutPlane::through(edge, &normal).unwrap_or_else(|error| unreachable!("walls have a normal: {error}"))
        };
        let upright = plane(*normal);
        SeparationWall { upright, tilted: plane(up + upright.normal() * slope) }
    }

    /// The wall that leans back by an angle from an upright one with a level normal, at `along` from the origin at a height.
    fn leaning(
        direction: &Vector3<f64>,
        level: &Vector3<f64>,
        along: f64,
        height: f64,
        lean: f64,
        options: &VolumeOptions,
    ) -> Self {
        let edge = Point3::from(level * along + direction * height);
        let (sin, cos) = lean.sin_cos();
        let (normal, up) = if lean > 0.0 {
            (level * cos + direction * sin, direction * cos - level * sin)
        } else {
            (*level, *direction)
        };
        Self::new(&up, &normal, &edge, options)
    }

    /// The printing direction of what is taken off.
    pub fn normal(&self) -> Vector3<f64> {
        self.upright.normal()
    }

    /// The same wall, moved back along its normal.
    pub(super) fn moved_back(&self, by: f64) -> Self {
        // The line in which both planes meet goes with the upright one.
        let shift = self.tilted.normal().dot(&self.upright.normal()) * by;
        SeparationWall { upright: self.upright.moved(-by), tilted: self.tilted.moved(-shift) }
    }
}

/// Walls that take a region off together.
#[derive(Clone, Debug)]
pub(super) struct Walls {
    pub walls: Vec<SeparationWall>,
    /// The corners of the inscribed rectangle, where there is one.
    pub rectangle: Option<[Point3<f64>; 4]>,
}

/// How far walls lean back, in shares of the most that leaves a level underside without overhang.
///
/// The paper's are upright: 0. Beyond what leans back the torch looks down, and passes over what stands beside it.
const LEANS: [f64; 3] = [0.0, 0.5, 0.98];

/// The leans that are tried, in radians: upright first.
pub(super) fn leans(options: &VolumeOptions) -> [f64; 3] {
    // A level underside rises over the layers of a wall that leans by `a` as a slope of 90 degrees - `a` does.
    LEANS.map(|share| share * (std::f64::consts::FRAC_PI_2 - options.angle))
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

/// Walls in front of a region of overhang which leave a quarter of what carries the region behind them: that of the interpolant plane of the
/// intersection points, that of the line through them, and one across the way from what is carried to what is not. Where the lowest layer
/// has no intersection points, the last one alone.
pub(super) fn walls_before(
    layered: &Layered,
    region: &OverhangRegion,
    lean: f64,
    options: &VolumeOptions,
) -> Vec<SeparationWall> {
    let d = layered.direction;
    let first = &layered.layers[region.first];
    let carried = carried_by(layered, region);
    let across = |v: Vector3<f64>| (v - d * v.dot(&d)).try_normalize(LEVEL);
    let lowest = region.pieces.iter().find(|(layer, _)| *layer == region.first);
    let centres = lowest.and_then(|(_, lowest)| Some((lowest.centroid()?, carried.centroid()?)));
    let Some((of_region, of_carried)) = centres else { return Vec::new() };
    let outward = layered.place(&of_region, 0.0) - layered.place(&of_carried, 0.0);
    let points: Vec<Point3<f64>> = region.points.iter().map(|&(_, p)| p).collect();
    let flat: Vec<Point3<f64>> = points.iter().map(|p| p - d * p.coords.dot(&d)).collect();
    let crosses = region.points.iter().any(|(layer, _)| *layer == region.first);
    let by_plane = spread(&points).filter(|_| crosses).and_then(|[least, _]| across(least));
    let by_line = spread(&flat).filter(|_| crosses).and_then(|[_, most]| across(d.cross(&most)));
    let wall = |normal: Vector3<f64>| {
        let level = normal * if normal.dot(&outward) < 0.0 { -1.0 } else { 1.0 };
        // How far a leaning wall is from an upright one grows with the height.
        let at = |layer: usize, p: Point2<f64>| {
            layered.place(&p, 0.0).coords.dot(&level) + (layered.layers[layer].low - first.low) * lean.tan()
        };
        let ends = region.pieces.iter().flat_map(|(layer, piece)| piece.points().map(move |p| (*layer, p)));
        let nearest = ends.map(|(layer, p)| at(layer, p)).fold(f64::INFINITY, f64::min);
        let wall = SeparationWall::leaning(&d, &level, nearest - options.tolerance_mm, first.low, lean, options);
        leaves_enough(&wall, layered, region).then_some(wall)
    };
    [by_plane, by_line, across(outward)].into_iter().flatten().filter_map(wall).collect()
}

/// What carries the lowest layer of a region.
fn carried_by<'a>(layered: &'a Layered, region: &OverhangRegion) -> &'a Region {
    if region.first > 0 { &layered.layers[region.first - 1].supported } else { &layered.layers[0].carrier }
}

/// Whether enough of what carries a region stays behind a wall.
pub(super) fn leaves_enough(wall: &SeparationWall, layered: &Layered, region: &OverhangRegion) -> bool {
    let carried = carried_by(layered, region);
    let (frame, normal) = (&layered.frame, wall.upright.normal());
    let origin = layered.place(&Point2::origin(), layered.layers[region.first].low);
    let flat = Vector2::new(normal.dot(&frame.u), normal.dot(&frame.v));
    // A leaning wall meets the layer in a line as well, but at an angle.
    let across = flat.norm();
    let behind = carried.below((flat / across).into(), (wall.upright.offset() - origin.coords.dot(&normal)) / across);
    behind.area() >= STAYS * carried.area()
}

/// The four walls around the largest rectangle in what carries a region that has no intersection points: to the right and left of
/// the layer's frame, then above and below. `None` where nothing carries it.
pub(super) fn walls_around(layered: &Layered, region: &OverhangRegion, options: &VolumeOptions) -> Option<Walls> {
    let first = &layered.layers[region.first];
    let below = if region.first > 0 { &layered.layers[region.first - 1].supported } else { &first.supported };
    let column = below.intersection(&first.section);
    let [low, high] = largest_rectangle(if column.is_empty() { below } else { &column })?;
    let frame = &layered.frame;
    let shift = |v: &Vector3<f64>| frame.origin.coords.dot(v);
    let wall = |normal: Vector3<f64>, flat: f64| {
        SeparationWall::leaning(&layered.direction, &normal, flat + shift(&normal), first.low, 0.0, options)
    };
    let corners = [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]];
    let corners = corners.map(|[x, y]| layered.place(&Point2::new(x, y), first.low));
    let walls = [wall(frame.u, high.x), wall(-frame.u, -low.x), wall(frame.v, high.y), wall(-frame.v, -low.y)];
    Some(Walls { walls: walls.to_vec(), rectangle: Some(corners) })
}
