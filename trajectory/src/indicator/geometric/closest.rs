//! Nearest points of two simple bodies, in closed form or by a few steps of a convex search.
//!
//! * Two segments: C. Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9.
//! * A segment and a cylinder: the signed distance to a convex body is convex along a line, so two tangents enclose its
//!   least value, and meet where to look next (J. E. Kelley's cutting planes, in one dimension).
//! * A segment and any distance field `f`: along a line at unit speed `f(t)^2 - t^2` is the least of functions that are
//!   straight in `t` (one for each point of the solid), so it is concave and lies above its chord. That bounds `f` from
//!   below between two places, exactly when the solid is one point; where the bound is least is the next place.
//! * A cylinder and any distance field: alternating projections onto the two, with the field's zero moved inwards, so
//!   that a cylinder that reaches in ends up there (H. H. Bauschke, J. M. Borwein, *On projection algorithms for solving
//!   convex feasibility problems*, SIAM Review 38, 1996). A local answer where the field's solid is not convex.

use nalgebra::{Point3, Vector3};

/// The nearest points of two segments, given by middle and half.
#[inline]
pub(super) fn segments(
    a: (&Point3<f64>, &Vector3<f64>),
    b: (&Point3<f64>, &Vector3<f64>),
) -> (Point3<f64>, Point3<f64>) {
    let (u, v, w) = (a.1, b.1, a.0 - b.0);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    // Clamping one after the other gives the nearest points of convex sets such as these.
    let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(-1.0, 1.0) } else { 0.0 };
    let mut s = share(uv * vw - vv * uw, det);
    let t = share(uv * s + vw, vv);
    s = share(uv * t - uw, uu);
    (a.0 + u * s, b.0 + v * t)
}

/// A cylinder with flat ends, somewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drum {
    middle: Point3<f64>,
    axis: Vector3<f64>,
    half: f64,
    radius: f64,
}

impl Drum {
    /// `half`: half of its axis, not 0.
    pub fn new(middle: &Point3<f64>, half: &Vector3<f64>, radius: f64) -> Self {
        let length = half.norm();
        Drum { middle: *middle, axis: half / length, half: length, radius }
    }

    /// Height and distance from the axis, with the direction away from it.
    #[inline]
    fn split(&self, point: &Point3<f64>) -> (f64, f64, Vector3<f64>) {
        let out = point - self.middle;
        let high = self.axis.dot(&out);
        let radial = out - self.axis * high;
        let far = radial.norm();
        (high, far, if far > 0.0 { radial / far } else { Vector3::zeros() })
    }

    /// The signed distance of a point, and its derivative by the point.
    #[inline]
    pub fn distance(&self, point: &Point3<f64>) -> (f64, Vector3<f64>) {
        let (high, far, out) = self.split(point);
        let up = self.axis * 1.0f64.copysign(high);
        let (above, aside) = (high.abs() - self.half, far - self.radius);
        if above <= 0.0 && aside <= 0.0 {
            return if above > aside { (above, up) } else { (aside, out) };
        }
        let (above, aside) = (above.max(0.0), aside.max(0.0));
        let distance = (above * above + aside * aside).sqrt();
        (distance, (up * above + out * aside) / distance)
    }

    /// The nearest of its points; any where a posture has made numbers of the cylinder that are not finite.
    fn onto(&self, point: &Point3<f64>) -> Point3<f64> {
        let (high, far, out) = self.split(point);
        self.middle + self.axis * high.max(-self.half).min(self.half) + out * far.min(self.radius)
    }

    /// Of a slope at one of its points the part that holds the point there, when the whole cylinder moves: across its
    /// surface. The rest says that a point beside it is a little deeper.
    fn across(&self, point: &Point3<f64>, slope: &Vector3<f64>) -> Vector3<f64> {
        let (high, far, out) = self.split(point);
        let (on_end, on_side) = (high.abs() >= self.half - FINE_MM, far >= self.radius - FINE_MM);
        if !on_end && !on_side {
            return *slope;
        }
        let along =
            |direction: &Vector3<f64>, counts: bool| direction * if counts { direction.dot(slope) } else { 0.0 };
        along(&self.axis, on_end) + along(&out, on_side)
    }

    /// The least distance from a plane through a point, and where.
    pub fn over(&self, point: &Point3<f64>, normal: &Vector3<f64>) -> (f64, Point3<f64>) {
        let tilt = normal.dot(&self.axis);
        let flat = normal - self.axis * tilt;
        let across = flat.norm();
        let out = if across > 0.0 { flat / across } else { Vector3::zeros() };
        let lowest = self.middle - self.axis * self.half.copysign(tilt) - out * self.radius;
        (normal.dot(&(lowest - point)), lowest)
    }
}

/// How near the least value along a line is looked for, in millimetres: the two sides of it are then some 0.1 mm apart,
/// and so near the slope is that of the value.
const FINEST_MM: f64 = 1e-4;
/// Steps of the search along a line; seven are usual.
const MAX_TANGENTS: usize = 48;

/// Where on a segment a capsule's axis comes deepest into a cylinder, if to less than `best`: the distance, its slope,
/// and the place.
pub(super) fn segment_drum(
    (middle, half): (&Point3<f64>, &Vector3<f64>),
    drum: &Drum,
    best: f64,
) -> Option<(f64, Vector3<f64>, Point3<f64>)> {
    let ask = |t: f64| {
        let at = middle + half * t;
        let (value, slope) = drum.distance(&at);
        (t, value, slope.dot(half), slope, at)
    };
    // Where the cylinder's middle is nearest one tangent mostly shows that all is beyond.
    let square = half.norm_squared();
    let share = half.dot(&(drum.middle - middle)) / square;
    let first = ask(if square > 0.0 { share.clamp(-1.0, 1.0) } else { 0.0 });
    let end = if first.2 > 0.0 { -1.0 } else { 1.0 };
    if first.1 + first.2 * (end - first.0) >= best {
        return None;
    }
    let (mut a, mut b) = if first.2 > 0.0 { (ask(end), first) } else { (first, ask(end)) };
    for _ in 0..MAX_TANGENTS {
        if !(a.2 < 0.0 && b.2 > 0.0) {
            // It falls or rises all the way between.
            break;
        }
        // Where the tangents at both ends meet nothing is lower.
        let meet = (b.1 - a.1 + a.2 * a.0 - b.2 * b.0) / (a.2 - b.2);
        let lowest = a.1 + a.2 * (meet - a.0);
        if lowest >= best {
            return None;
        }
        if a.1.min(b.1) - lowest <= FINEST_MM {
            break;
        }
        let next = ask(meet.clamp(a.0, b.0));
        if next.2 <= 0.0 {
            a = next;
        } else {
            b = next;
        }
    }
    let (_, value, _, slope, at) = if a.1 <= b.1 { a } else { b };
    let (slope, at) = if a.2 < 0.0 && b.2 > 0.0 {
        // At an edge the slope is that mixture of both sides' which does not change along the segment.
        let share = a.2 / (a.2 - b.2);
        (a.3 + (b.3 - a.3) * share, a.4 + (b.4 - a.4) * share)
    } else {
        (slope, at)
    };
    (value < best).then_some((value, slope, at))
}

/// Questions to a field about one segment; two or three are usual, a link that lies along a flat face takes most.
const MAX_PLACES: usize = 64;
/// Places in a piece of it.
const PLACES: f64 = 16.0;
/// Pieces of it that wait.
const MAX_OPEN: usize = 24;
/// The depth of a capsule is found to so much of it.
const SHARE_OF_DEPTH: f64 = 0.1;

/// Where the axis of a capsule comes deepest into a field, if to less than `best`: the distance, and the place. Right
/// within `fine` while the capsule is outside of the solid.
pub(super) fn segment_field(
    [from, to]: [&Point3<f64>; 2],
    radius: f64,
    field: &impl Fn(&Point3<f64>) -> f64,
    best: f64,
    fine: f64,
) -> Option<(f64, Point3<f64>)> {
    let length = (to - from).norm();
    let mut least = best;
    let mut found = None;
    let mut ask = |t: f64| {
        let value = field(&(from + (to - from) * t));
        if value < least {
            (least, found) = (value, Some(t));
        }
        (t, value, least)
    };
    let ends = [ask(0.0), ask(1.0)];
    let mut open = [[ends[0]; 2]; MAX_OPEN];
    open[0] = ends;
    let (mut count, mut places, mut known) = (1, 2, ends[1].2);
    while count > 0 && places < MAX_PLACES {
        count -= 1;
        let [a, b] = open[count];
        let (share, bound) = below(a.1, b.1, (b.0 - a.0) * length);
        let slack = fine + SHARE_OF_DEPTH * (radius - known).max(0.0);
        // What is not a number is no reason to go on.
        if bound.is_nan() || bound >= known - slack {
            continue;
        }
        // Places that do not move with the distances: so the slope of the distance at a place is that of the answer.
        let share = (share * PLACES).round().clamp(1.0, PLACES - 1.0) / PLACES;
        let next = ask(a.0 + (b.0 - a.0) * share);
        places += 1;
        known = next.2;
        if count + 2 <= MAX_OPEN {
            // The deeper side is looked at first.
            let (left, right) = ([a, next], [next, b]);
            [open[count], open[count + 1]] = if a.1 <= b.1 { [right, left] } else { [left, right] };
            count += 2;
        }
    }
    found.map(|t| (least, from + (to - from) * t))
}

/// Between two places with distances `a` and `b`, a way `length` apart: how far along the distance can be least (not too
/// near to either), and how small it can be there.
#[inline]
fn below(a: f64, b: f64, length: f64) -> (f64, f64) {
    let square = length * length;
    let share = 0.5 * (square + a * a - b * b) / square;
    if a > 0.0 && b > 0.0 {
        if !(share > 0.0 && share < 1.0) {
            return (0.5, a.min(b));
        }
        let lowest = a * a + share * (b * b - a * a - square) + share * share * square;
        if lowest > 0.0 {
            return (share, lowest.sqrt());
        }
    }
    // It may pass through the surface: the distance changes by the way at most.
    (0.5 + 0.5 * (a - b) / length, 0.5 * (a + b - length))
}

/// Projections end with a step shorter than this.
const FINE_MM: f64 = 0.01;
/// Projections of a cylinder's point.
const MAX_ROUNDS: usize = 24;
/// How deep in the solid the aim lies, in millimetres: deeper overlaps are not resolved.
const DEEP_MM: f64 = 2.0;

/// Where a cylinder comes deepest into a field, if to less than `best`: the distance, its slope, and the place.
pub(super) fn drum_field(
    drum: &Drum,
    field: &impl Fn(&Point3<f64>) -> (f64, Vector3<f64>),
    best: f64,
) -> Option<(f64, Vector3<f64>, Point3<f64>)> {
    let mut at = drum.middle;
    let (mut value, mut slope) = field(&at);
    if value - drum.half.hypot(drum.radius) >= best {
        return None;
    }
    let mut found = (value, slope, at);
    for _ in 0..MAX_ROUNDS {
        let next = drum.onto(&(at - slope * (value + DEEP_MM)));
        if (next - at).norm_squared() < FINE_MM * FINE_MM {
            break;
        }
        at = next;
        (value, slope) = field(&at);
        if value < found.0 {
            found = (value, slope, at);
        }
    }
    let (value, slope, at) = found;
    (value < best).then(|| (value, drum.across(&at, &slope), at))
}
