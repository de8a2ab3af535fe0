//! A collision indicator from signed distances, split by what moves against what.
//!
//! The head moves over the part in a distance of nozzle widths, so against the part it is balls in a signed distance
//! grid ([`DistanceGrid`]); links of the arm, hoses and posts of the cell are capsules, the table and the walls are
//! planes. The value is `margin` minus the least of all distances, in millimetres: above 0 when something is nearer than
//! the margin. Its gradient is that of the least distance, from the frames of the bodies and the twists of the joints
//! ([`Bodies`]); where two distances are least at once it jumps from one to the other, the value does not.
//!
//! What C. Dai (*Material Deposition in 3D Space*, TU Delft 2020, section 4.4) learns from samples is computed here; the
//! shapes are the approximation. Nothing is allocated by a question of up to
//! 24 capsules. Distances that cannot be the least are passed over
//! by balls about balls and capsules.

mod balls;
mod bodies;
mod grid;
mod surface;

pub use bodies::{Bodies, BodiesFn, Twist};
pub use grid::{DistanceGrid, GridError, MOST_NODES};

use super::CollisionIndicator;
use balls::BallTree;
use nalgebra::{Isometry3, Point3, Unit, Vector3};

/// A ball of a body, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its body.
    pub body: usize,
    /// Its centre.
    pub center: Point3<f64>,
    /// Its radius, 0 or more.
    pub radius: f64,
}

impl Ball {
    /// Balls from one point to another, both included, with radii that go evenly from the first to the second: a nozzle's
    /// cone, or a capsule. Between balls of radius `r` at a distance `s` the surface sinks in by `s^2 / (8 r)`.
    /// ```
    /// use curvlay_trajectory::{indicator::geometric::Ball, nalgebra::Point3};
    /// let cone = Ball::along(6, &Point3::new(0.0, 0.0, 1.0), &Point3::new(0.0, 0.0, 9.0), [1.0, 5.0], 5);
    /// assert_eq!((cone[1].center.z, cone[1].radius, cone.len()), (3.0, 2.0, 5));
    /// ```
    pub fn along(body: usize, from: &Point3<f64>, to: &Point3<f64>, radii: [f64; 2], count: usize) -> Vec<Ball> {
        let share = |k: usize| if count > 1 { k as f64 / (count - 1) as f64 } else { 0.0 };
        let ball = |t: f64| Ball { body, center: from + (to - from) * t, radius: radii[0] + (radii[1] - radii[0]) * t };
        (0..count).map(|k| ball(share(k))).collect()
    }
}

/// All points within a radius of a line segment, in a body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Its body.
    pub body: usize,
    /// One end of the segment.
    pub from: Point3<f64>,
    /// The other.
    pub to: Point3<f64>,
    /// The radius, 0 or more.
    pub radius: f64,
}

/// A plane with everything behind it, in a body's frame: a table, a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Its body.
    pub body: usize,
    /// A point on it.
    pub point: Point3<f64>,
    /// Its normal, towards the free side.
    pub normal: Unit<Vector3<f64>>,
}

/// What is compared with what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeometricModel {
    /// Balls, compared with the grids: the head, and what else comes near the part.
    pub balls: Vec<Ball>,
    /// Grids with the bodies that carry them: the part.
    pub grids: Vec<(usize, DistanceGrid)>,
    /// Capsules, compared with each other and with the planes: links and obstacles.
    pub capsules: Vec<Capsule>,
    /// Planes.
    pub planes: Vec<Plane>,
    /// Pairs of bodies that are not compared: neighbours in the arm, the foot and the table.
    pub ignored: Vec<[usize; 2]>,
    /// Nearer than this counts as a collision, in millimetres. May be below 0, to offset shapes that are too large.
    pub margin: f64,
}

/// Why there is no indicator.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometricError {
    /// More bodies than there is room for.
    #[error("{count} bodies: at most {MOST_BODIES} can be told apart")]
    TooManyBodies {
        /// How many.
        count: usize,
    },
    /// A shape is of a body that there is not.
    #[error("{what} {index} is of body {body}, there are {count}")]
    NoBody {
        /// `ball`, `grid`, `capsule`, `plane` or `ignored pair`.
        what: &'static str,
        /// Which of them.
        index: usize,
        /// Its body.
        body: usize,
        /// Number of bodies.
        count: usize,
    },
    /// A shape has a number that is not finite, or a radius below 0.
    #[error("{what} {index} is no shape: its numbers must be finite and its radius not below 0")]
    Shape {
        /// `ball`, `capsule` or `plane`.
        what: &'static str,
        /// Which of them.
        index: usize,
    },
    /// The margin is not finite.
    #[error("the margin is {0}: it must be finite")]
    Margin(
        /// Its value.
        f64,
    ),
    /// No two shapes move against each other.
    #[error("nothing to compare: no two shapes of bodies that move against each other")]
    Nothing,
}

/// Most bodies of an indicator; their frames are kept on the stack.
pub const MOST_BODIES: usize = 16;

/// A capsule by its middle and half its axis; in the frame of its body, or in the world.
#[derive(Clone, Copy, Debug, Default)]
struct Segment {
    body: usize,
    middle: Point3<f64>,
    half: Vector3<f64>,
    radius: f64,
    /// No point is farther from the middle.
    reach: f64,
}

impl Segment {
    fn of(capsule: &Capsule) -> Self {
        let half = (capsule.to - capsule.from) * 0.5;
        let (body, radius, reach) = (capsule.body, capsule.radius, half.norm() + capsule.radius);
        Segment { body, middle: nalgebra::center(&capsule.from, &capsule.to), half, radius, reach }
    }

    fn ends(&self) -> [Point3<f64>; 2] {
        [self.middle - self.half, self.middle + self.half]
    }
}

/// Room on the stack for capsules in the world; more of them are put in a list.
const ROOM: usize = 24;

type Frames = [Isometry3<f64>; MOST_BODIES];

/// The geometric indicator; see the [module](self).
#[derive(Clone, Debug)]
pub struct GeometricIndicator<const N: usize, B> {
    bodies: B,
    count: usize,
    grids: Vec<(usize, DistanceGrid)>,
    /// Balls of one body against a grid.
    trees: Vec<(usize, BallTree)>,
    capsules: Vec<Segment>,
    planes: Vec<Plane>,
    /// Capsules that are compared.
    pairs: Vec<[usize; 2]>,
    /// Capsules and planes that are compared.
    grounds: Vec<[usize; 2]>,
    carriers: [[bool; N]; MOST_BODIES],
    margin: f64,
}

/// Where two bodies are nearest: the distance and its slope with a point of each, all in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// The distance, in millimetres, below 0 where they overlap.
    pub distance: f64,
    /// The bodies.
    pub bodies: [usize; 2],
    /// How the distance changes when the first body moves at `point`.
    slope: Vector3<f64>,
    points: [Point3<f64>; 2],
}

impl<const N: usize, B: Bodies<N>> GeometricIndicator<N, B> {
    /// Checks and prepares.
    ///
    /// # Errors
    /// [`GeometricError`] names the shape.
    pub fn new(bodies: B, model: GeometricModel) -> Result<Self, GeometricError> {
        let count = bodies.count();
        if count > MOST_BODIES {
            return Err(GeometricError::TooManyBodies { count });
        }
        if !model.margin.is_finite() {
            return Err(GeometricError::Margin(model.margin));
        }
        check(&model, count)?;
        let mut carriers = [[false; N]; MOST_BODIES];
        (0..count).for_each(|body| carriers[body] = bodies.carriers(body));
        let GeometricModel { balls, grids, capsules, planes, ignored, margin } = model;
        // What the same joints carry never moves against each other.
        let meet =
            |a: usize, b: usize| carriers[a] != carriers[b] && !ignored.contains(&[a, b]) && !ignored.contains(&[b, a]);
        let mut trees = vec![];
        for (grid, (part, _)) in grids.iter().enumerate() {
            for body in (0..count).filter(|&body| meet(body, *part)) {
                let own: Vec<Ball> = balls.iter().filter(|ball| ball.body == body).copied().collect();
                if !own.is_empty() {
                    trees.push((grid, BallTree::new(body, &own)));
                }
            }
        }
        let all = |k: usize| (k + 1..capsules.len()).map(move |l| [k, l]);
        let pairs: Vec<[usize; 2]> =
            (0..capsules.len()).flat_map(all).filter(|&[k, l]| meet(capsules[k].body, capsules[l].body)).collect();
        let grounds: Vec<[usize; 2]> = (0..capsules.len())
            .flat_map(|k| (0..planes.len()).map(move |l| [k, l]))
            .filter(|&[k, l]| meet(capsules[k].body, planes[l].body))
            .collect();
        if trees.is_empty() && pairs.is_empty() && grounds.is_empty() {
            return Err(GeometricError::Nothing);
        }
        let capsules = capsules.iter().map(Segment::of).collect();
        Ok(GeometricIndicator { bodies, count, grids, trees, capsules, planes, pairs, grounds, carriers, margin })
    }

    /// Puts another grid in the place of one: the part has grown. `None` when there is no such grid.
    pub fn replace_grid(&mut self, grid: usize, new: DistanceGrid) -> Option<DistanceGrid> {
        let old = &mut self.grids.get_mut(grid)?.1;
        Some(std::mem::replace(old, new))
    }

    /// The nearest two bodies.
    pub fn nearest(&self, joints: &[f64; N]) -> Near {
        let mut frames = [Isometry3::identity(); MOST_BODIES];
        self.bodies.place(joints, &mut frames[..self.count]);
        self.least(&frames)
    }

    fn least(&self, frames: &Frames) -> Near {
        let far =
            Near { distance: f64::INFINITY, bodies: [0; 2], slope: Vector3::zeros(), points: [Point3::origin(); 2] };
        let mut best = far;
        for (grid, tree) in &self.trees {
            let (part, field) = &self.grids[*grid];
            let part_body = frames[*part].inverse() * frames[tree.body()];
            if let Some((distance, center)) = tree.nearest(field, &part_body, best.distance) {
                let slope = frames[*part] * field.gradient(&center).1;
                let at = frames[*part] * center;
                best = Near { distance, bodies: [tree.body(), *part], slope, points: [at, at] };
            }
        }
        let mut room = [Segment::default(); ROOM];
        let mut more = vec![];
        let segments = self.segments(frames, &mut room, &mut more);
        for &[k, l] in &self.grounds {
            let (segment, plane) = (&segments[k], &self.planes[l]);
            let (normal, point) = (frames[plane.body] * plane.normal.into_inner(), frames[plane.body] * plane.point);
            let tilt = normal.dot(&segment.half);
            let distance = normal.dot(&(segment.middle - point)) - tilt.abs() - segment.radius;
            if distance < best.distance {
                let at = segment.middle - segment.half * 1.0f64.copysign(tilt);
                best = Near { distance, bodies: [segment.body, plane.body], slope: normal, points: [at, at] };
            }
        }
        for &[k, l] in &self.pairs {
            let [a, b] = [&segments[k], &segments[l]];
            let near = best.distance + a.reach + b.reach;
            if near <= 0.0 || (a.middle - b.middle).norm_squared() >= near * near {
                continue;
            }
            let [at_a, at_b] = between(a.ends().each_ref(), b.ends().each_ref());
            let (gap, radii) = ((at_a - at_b).norm(), a.radius + b.radius);
            if gap - radii < best.distance {
                // Where the segments cross no direction is better than another.
                let slope = if gap > 0.0 { (at_a - at_b) / gap } else { Vector3::zeros() };
                best = Near { distance: gap - radii, bodies: [a.body, b.body], slope, points: [at_a, at_b] };
            }
        }
        best
    }

    /// The capsules in the world, each placed once for all its pairs.
    fn segments<'a>(
        &self,
        frames: &Frames,
        room: &'a mut [Segment; ROOM],
        more: &'a mut Vec<Segment>,
    ) -> &'a [Segment] {
        let place = |rest: &Segment| {
            let frame = &frames[rest.body];
            Segment {
                body: rest.body,
                middle: frame * rest.middle,
                half: frame * rest.half,
                radius: rest.radius,
                reach: rest.reach,
            }
        };
        if self.capsules.len() > ROOM {
            more.extend(self.capsules.iter().map(place));
            return more;
        }
        for (to, rest) in room.iter_mut().zip(&self.capsules) {
            *to = place(rest);
        }
        room
    }
}

impl<const N: usize, B: Bodies<N>> CollisionIndicator<N> for GeometricIndicator<N, B> {
    fn value(&self, joints: &[f64; N]) -> f64 {
        self.margin - self.nearest(joints).distance
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        let mut frames = [Isometry3::identity(); MOST_BODIES];
        let twists = self.bodies.place_moving(joints, &mut frames[..self.count]);
        let Near { distance, bodies: [a, b], slope, points } = self.least(&frames);
        let along = |k: usize| {
            let by = |body: usize, point: &Point3<f64>| {
                if self.carriers[body][k] { slope.dot(&twists[k].velocity(point)) } else { 0.0 }
            };
            by(b, &points[1]) - by(a, &points[0])
        };
        (self.margin - distance, std::array::from_fn(along))
    }
}

fn check(model: &GeometricModel, count: usize) -> Result<(), GeometricError> {
    let known = |what, index, body| {
        if body < count { Ok(()) } else { Err(GeometricError::NoBody { what, index, body, count }) }
    };
    let sound = |what, index, is_sound: bool| is_sound.then_some(()).ok_or(GeometricError::Shape { what, index });
    let finite = |point: &Point3<f64>| point.iter().all(|x| x.is_finite());
    let length = |radius: f64| radius.is_finite() && radius >= 0.0;
    for (index, ball) in model.balls.iter().enumerate() {
        known("ball", index, ball.body)?;
        sound("ball", index, finite(&ball.center) && length(ball.radius))?;
    }
    for (index, (body, _)) in model.grids.iter().enumerate() {
        known("grid", index, *body)?;
    }
    for (index, capsule) in model.capsules.iter().enumerate() {
        known("capsule", index, capsule.body)?;
        sound("capsule", index, finite(&capsule.from) && finite(&capsule.to) && length(capsule.radius))?;
    }
    for (index, plane) in model.planes.iter().enumerate() {
        known("plane", index, plane.body)?;
        sound("plane", index, finite(&plane.point) && plane.normal.iter().all(|x| x.is_finite()))?;
    }
    for (index, pair) in model.ignored.iter().enumerate() {
        known("ignored pair", index, pair[0])?;
        known("ignored pair", index, pair[1])?;
    }
    Ok(())
}

/// The nearest points of two segments: the foot of the common normal where it falls within both, else the nearest of the
/// four ends on the other segment.
fn between(a: [&Point3<f64>; 2], b: [&Point3<f64>; 2]) -> [Point3<f64>; 2] {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    // Clamping one after the other gives the nearest points of convex sets such as these (C. Ericson, *Real-Time
    // Collision Detection*, 2005, section 5.1.9).
    let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    let mut s = share(uv * vw - vv * uw, det);
    let t = share(uv * s + vw, vv);
    s = share(uv * t - uw, uu);
    [a[0] + u * s, b[0] + v * t]
}
