//! The least of all distances between shapes that move against each other.

use super::balls::BallTree;
use super::closest::{Drum, drum_field, segment_drum, segment_field, segments};
use super::grid::DistanceGrid;
use super::model::GeometricModel;
use super::near::{MAX_BODIES, Near};
use super::shapes::{Ball, Plane};
use nalgebra::{IsometryMatrix3, Point3, Vector3};

/// Frames of the bodies in the world.
pub(super) type Frames = [IsometryMatrix3<f64>; MAX_BODIES];

/// A capsule or a cylinder, by its middle and half its axis in the frame of its body.
#[derive(Clone, Copy, Debug)]
struct Long {
    body: usize,
    at: Placed,
    radius: f64,
    /// No point is farther from the middle.
    reach: f64,
    is_cylinder: bool,
    /// `at` is in the world: nothing moves it.
    still: bool,
}

/// Middle and half of an axis.
#[derive(Clone, Copy, Debug)]
struct Placed {
    middle: Point3<f64>,
    half: Vector3<f64>,
}

impl Placed {
    fn ends(&self) -> (Point3<f64>, Point3<f64>) {
        (self.middle - self.half, self.middle + self.half)
    }

    fn parts(&self) -> (&Point3<f64>, &Vector3<f64>) {
        (&self.middle, &self.half)
    }

    fn by(&self, frame: &IsometryMatrix3<f64>) -> Self {
        Placed { middle: frame * self.middle, half: frame * self.half }
    }
}

/// Space on the stack for shapes in the world; more of them are put in a list.
const BUFFER: usize = 16;
/// How near the deepest place in a grid is looked for, in spacings.
const FINE: f64 = 0.1;

/// All that is compared.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    grids: Vec<(usize, DistanceGrid)>,
    /// Balls of one body against a grid.
    trees: Vec<(usize, BallTree)>,
    longs: Vec<Long>,
    planes: Vec<Plane>,
    /// Long shapes and grids that are compared.
    parts: Vec<[usize; 2]>,
    /// Long shapes and planes that are compared.
    grounds: Vec<[usize; 2]>,
    /// Long shapes that are compared with each other, of capsule and cylinder the capsule first, and the sum of their
    /// reaches.
    pairs: Vec<([usize; 2], f64)>,
}

impl Distances {
    /// `meet`: whether two bodies are compared; `still`: where a body stands that nothing moves. `None` when there is
    /// nothing to compare.
    pub fn new(
        model: GeometricModel,
        count: usize,
        meet: &impl Fn(usize, usize) -> bool,
        still: &impl Fn(usize) -> Option<IsometryMatrix3<f64>>,
    ) -> Option<Self> {
        let GeometricModel { grids, balls, capsules, cylinders, planes, .. } = model;
        let mut trees = vec![];
        for (grid, (part, _)) in grids.iter().enumerate() {
            for body in (0..count).filter(|&body| meet(body, *part)) {
                let own: Vec<Ball> = balls.iter().filter(|ball| ball.body == body).copied().collect();
                if !own.is_empty() {
                    trees.push((grid, BallTree::new(body, &own)));
                }
            }
        }
        let long = |body: usize, from: &Point3<f64>, to: &Point3<f64>, radius: f64, is_cylinder: bool| {
            let at = Placed { middle: nalgebra::center(from, to), half: (to - from) * 0.5 };
            let half = at.half.norm();
            let reach = if is_cylinder { half.hypot(radius) } else { half + radius };
            let stands = still(body);
            let at = stands.map_or(at, |frame| at.by(&frame));
            Long { body, at, radius, reach, is_cylinder, still: stands.is_some() }
        };
        let longs: Vec<Long> = capsules
            .iter()
            .map(|shape| long(shape.body, &shape.from, &shape.to, shape.radius, false))
            .chain(cylinders.iter().map(|shape| long(shape.body, &shape.from, &shape.to, shape.radius, true)))
            .collect();
        let with = |others: usize| (0..longs.len()).flat_map(move |k| (0..others).map(move |l| [k, l]));
        let mut parts: Vec<[usize; 2]> = with(grids.len()).filter(|&[k, l]| meet(longs[k].body, grids[l].0)).collect();
        // The head first: slim things are those that come near. Cylinders, which take longest, last.
        let order = |k: usize| (longs[k].is_cylinder, longs[k].radius);
        parts.sort_by(|a, b| {
            let ((first, wide), (second, other)) = (order(a[0]), order(b[0]));
            first.cmp(&second).then(wide.total_cmp(&other))
        });
        let grounds = with(planes.len()).filter(|&[k, l]| meet(longs[k].body, planes[l].body)).collect::<Vec<_>>();
        // Capsules stand before cylinders.
        let pairs: Vec<([usize; 2], f64)> = with(longs.len())
            .filter(|&[k, l]| k < l && meet(longs[k].body, longs[l].body))
            .map(|[k, l]| ([k, l], longs[k].reach + longs[l].reach))
            .collect();
        let nothing = trees.is_empty() && parts.is_empty() && pairs.is_empty() && grounds.is_empty();
        (!nothing).then_some(Distances { grids, trees, longs, planes, parts, grounds, pairs })
    }

    pub fn replace_grid(&mut self, grid: usize, new: DistanceGrid) -> Option<DistanceGrid> {
        let old = &mut self.grids.get_mut(grid)?.1;
        Some(std::mem::replace(old, new))
    }

    /// The nearest two shapes.
    pub fn least(&self, frames: &Frames) -> Near {
        let place = |long: &Long| if long.still { long.at } else { long.at.by(&frames[long.body]) };
        if self.longs.len() > BUFFER {
            return self.among(frames, &self.longs.iter().map(place).collect::<Vec<_>>());
        }
        let nothing = Placed { middle: Point3::origin(), half: Vector3::zeros() };
        let buffer: [Placed; BUFFER] = std::array::from_fn(|k| self.longs.get(k).map_or(nothing, place));
        self.among(frames, &buffer)
    }

    fn among(&self, frames: &Frames, placed: &[Placed]) -> Near {
        let far =
            Near { distance: f64::INFINITY, bodies: [0; 2], slope: Vector3::zeros(), points: [Point3::origin(); 2] };
        let mut best = far;
        self.to_parts(frames, placed, &mut best);
        for (grid, tree) in &self.trees {
            let (part, field) = &self.grids[*grid];
            let part_body = frames[*part].inverse() * frames[tree.body()];
            if let Some((distance, center)) = tree.nearest(field, &part_body, best.distance) {
                let slope = frames[*part] * field.gradient(&center).1;
                let at = frames[*part] * center;
                best = Near { distance, bodies: [tree.body(), *part], slope, points: [at, at] };
            }
        }
        self.to_planes(frames, placed, &mut best);
        for ([k, l], reach) in &self.pairs {
            let (a, b) = (&placed[*k], &placed[*l]);
            let near = best.distance + reach;
            if near > 0.0 && (a.middle - b.middle).norm_squared() < near * near {
                self.pair([*k, *l], [a, b], &mut best);
            }
        }
        best
    }

    fn to_parts(&self, frames: &Frames, placed: &[Placed], best: &mut Near) {
        // Mostly there is one part.
        let mut part_world = (usize::MAX, IsometryMatrix3::identity());
        for &[k, grid] in &self.parts {
            let (part, field) = &self.grids[grid];
            if part_world.0 != *part {
                part_world = (*part, frames[*part].inverse());
            }
            let long = &self.longs[k];
            let at = placed[k].by(&part_world.1);
            // A cylinder ends within a radius of its axis too.
            if field.is_beyond(&at.middle, &at.half, long.radius, best.distance) {
                continue;
            }
            let found = if long.is_cylinder {
                let drum = Drum::new(&at.middle, &at.half, long.radius);
                drum_field(&drum, &|p| field.gradient(p), best.distance)
            } else {
                let (from, to) = at.ends();
                let fine = FINE * field.spacing();
                segment_field([&from, &to], long.radius, &|p| field.distance(p), best.distance + long.radius, fine)
                    .map(|(distance, at)| (distance - long.radius, field.gradient(&at).1, at))
            };
            if let Some((distance, slope, at)) = found.filter(|found| found.0 < best.distance) {
                let at = frames[*part] * at;
                *best = Near { distance, bodies: [long.body, *part], slope: frames[*part] * slope, points: [at, at] };
            }
        }
    }

    fn to_planes(&self, frames: &Frames, placed: &[Placed], best: &mut Near) {
        for &[k, l] in &self.grounds {
            let (long, at, plane) = (&self.longs[k], &placed[k], &self.planes[l]);
            let (normal, point) = (frames[plane.body] * plane.normal.into_inner(), frames[plane.body] * plane.point);
            if normal.dot(&(at.middle - point)) - long.reach >= best.distance {
                continue;
            }
            let (distance, at) = if long.is_cylinder {
                Drum::new(&at.middle, &at.half, long.radius).over(&point, &normal)
            } else {
                let lowest = at.middle - at.half * 1.0f64.copysign(normal.dot(&at.half));
                (normal.dot(&(lowest - point)) - long.radius, lowest)
            };
            if distance < best.distance {
                *best = Near { distance, bodies: [long.body, plane.body], slope: normal, points: [at, at] };
            }
        }
    }

    fn pair(&self, [k, l]: [usize; 2], [a, b]: [&Placed; 2], best: &mut Near) {
        let (first, second) = (&self.longs[k], &self.longs[l]);
        let bodies = [first.body, second.body];
        if !second.is_cylinder {
            let (at_a, at_b) = segments(a.parts(), b.parts());
            let (apart, radii) = (at_a - at_b, first.radius + second.radius);
            let (square, near) = (apart.norm_squared(), best.distance + radii);
            if near > 0.0 && square >= near * near {
                return;
            }
            let gap = square.sqrt();
            if gap < near {
                // Where the segments cross no direction is better than another.
                let slope = if gap > 0.0 { apart / gap } else { Vector3::zeros() };
                *best = Near { distance: gap - radii, bodies, slope, points: [at_a, at_b] };
            }
            return;
        }
        let drum = Drum::new(&b.middle, &b.half, second.radius);
        let found = if first.is_cylinder {
            drum_field(&Drum::new(&a.middle, &a.half, first.radius), &|p| drum.distance(p), best.distance)
        } else {
            segment_drum(a.parts(), &drum, best.distance + first.radius)
                .map(|(value, slope, at)| (value - first.radius, slope, at))
        };
        if let Some((distance, slope, at)) = found.filter(|found| found.0 < best.distance) {
            *best = Near { distance, bodies, slope, points: [at, at] };
        }
    }
}
