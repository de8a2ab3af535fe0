//! Whether the head of a printer meets what stands while a part is printed.
//!
//! In place of constraint II of the dissertation (section 2.4.3: all base planes look up), which it calls too restrictive (section 2.6, 5).
//!
//! The head is a cone and a block around the axis of the nozzle, and goes on above the block without end. Its radius grows with the height
//! above the tip, so of all that stands over a place only the highest point counts, and of all places where the tip was only the
//! lowest: two maps of heights across the printing direction say all. The part hits what stands if for two pixels the standing height is
//! above the tip's and the pixels are no farther apart than the head is wide there. Heights in a pixel are exact (triangles are clipped to
//! pixels), distances are those of the nearest points of two pixels: never too small a head, and too large a one by less than a
//! pixel's diagonal on both sides.

use super::error::RoboFdmError;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The head of a printer: a cone with the tip at its end, a block above it, and the platform on which all stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    /// Radius of the flat end of the tip, in mm. Default 0.5.
    pub tip_radius: f64,
    /// Angle between the axis and the side of the cone, in radians. Default 45 degrees.
    pub cone_half_angle: f64,
    /// Height of the cone over the tip, in mm. Default 8.
    pub cone_height: f64,
    /// Radius of the block above the cone, in mm. Default 10.
    pub block_radius: f64,
    /// Radius of the platform around the middle of the solid's box, in mm; 0 for none. Default 60.
    pub platform_radius: f64,
    /// Height of the pedestal between the platform and the first part, in mm: a prism with the section of its first layer (see
    /// [`super::Pedestal`]), which is printed first and cut off afterwards. Near the platform a tilted head has no room: with a pedestal as high
    /// as the head is wide it has. Default 0: the first part stands on the platform.
    pub pedestal: f64,
    /// Height of the tip over what it prints on, in mm: a layer. Default 0.5.
    pub layer: f64,
    /// Edge of a pixel, in mm. Default 1.
    pub pixel: f64,
}

impl Default for Head {
    fn default() -> Self {
        Head {
            tip_radius: 0.5,
            cone_half_angle: std::f64::consts::FRAC_PI_4,
            cone_height: 8.0,
            block_radius: 10.0,
            platform_radius: 60.0,
            pedestal: 0.0,
            layer: 0.5,
            pixel: 1.0,
        }
    }
}

/// Sides of the platform in the maps: its corners lie outside of the circle, the middles of its sides on it.
const SIDES: usize = 32;

/// Most pixels along an edge of a map; a larger part gets larger pixels.
const MAX_PIXELS: f64 = 400.0;

impl Head {
    /// Its radius at a height above the tip.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::planar::robofdm::Head;
    /// let head = Head::default();
    /// assert_eq!([0.0, 4.0, 8.0, 9.0].map(|height| head.radius(height)), [0.5, 4.5, 8.5, 10.0]);
    /// ```
    pub fn radius(&self, height: f64) -> f64 {
        let cone = self.tip_radius + height.min(self.cone_height) * self.cone_half_angle.tan();
        if height > self.cone_height { cone.max(self.block_radius) } else { cone }
    }

    pub(super) fn check(&self) -> Result<(), RoboFdmError> {
        let named = [
            ("head.tip_radius", self.tip_radius, 0.0, 1e6),
            ("head.cone_half_angle", self.cone_half_angle, 0.0, FRAC_PI_2 - 1e-6),
            ("head.cone_height", self.cone_height, 0.0, 1e6),
            ("head.block_radius", self.block_radius, 0.0, 1e6),
            ("head.platform_radius", self.platform_radius, 0.0, 1e6),
            ("head.pedestal", self.pedestal, 0.0, 1e6),
            ("head.layer", self.layer, 1e-6, 1e6),
            ("head.pixel", self.pixel, 1e-3, 1e6),
        ];
        match named.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value)) {
            Some((name, value, ..)) => Err(RoboFdmError::Option { name, value }),
            None => Ok(()),
        }
    }

    /// Whether the head, its tip a layer over a place, is in the platform, by the lowest point of each of its edges: what that misses
    /// [`Head::meets`] finds.
    pub(super) fn in_platform(
        self,
        direction: &Vector3<f64>,
        middle: &Point3<f64>,
        up: &Vector3<f64>,
    ) -> impl Fn(&Point3<f64>) -> bool {
        let (direction, middle, up) = (*direction, *middle, *up);
        let rise = direction.dot(&up);
        // The lowest point of a circle around the axis lies this way from its middle.
        let across = (direction * rise - up).try_normalize(1e-9).unwrap_or_default();
        let sink = across.dot(&up);
        let edges = [0.0, self.cone_height, self.cone_height + 1e-9].map(|height| (height, self.radius(height)));
        let widest = self.radius(f64::INFINITY);
        move |place| {
            if self.platform_radius <= 0.0 {
                return false;
            }
            let tip = place + direction * self.layer - middle;
            // The block has no end; so far up a head that looks down is below everything.
            let far = 2.0 * (self.platform_radius + tip.norm());
            let start = tip.dot(&up);
            edges.into_iter().chain([(far, widest)]).any(|(height, radius)| {
                let up_there = start + height * rise + radius * sink;
                up_there < 0.0
                    && (tip + direction * height + across * radius - up * up_there).norm() < self.platform_radius
            })
        }
    }

    /// The platform as triangles, around a point on it.
    pub(super) fn platform(&self, middle: &Point3<f64>, up: &Vector3<f64>) -> Vec<[Point3<f64>; 3]> {
        if self.platform_radius <= 0.0 {
            return Vec::new();
        }
        let [u, v] = across(up);
        let radius = self.platform_radius / (TAU / (2.0 * SIDES as f64)).cos();
        let corner = |k: usize| {
            let turn = TAU * k as f64 / SIDES as f64;
            middle + (u * turn.cos() + v * turn.sin()) * radius
        };
        (0..SIDES).map(|k| [*middle, corner(k), corner(k + 1)]).collect()
    }

    /// Whether it meets what stands while a part is printed along a direction of length 1.
    pub(super) fn meets<'a>(
        &self,
        direction: &Vector3<f64>,
        part: impl Iterator<Item = &'a [Point3<f64>; 3]> + Clone,
        standing: impl Iterator<Item = &'a [Point3<f64>; 3]>,
    ) -> bool {
        let [u, v] = across(direction);
        let seen = |corners: &[Point3<f64>; 3]| {
            corners.map(|p| Vector3::new(p.coords.dot(&u), p.coords.dot(&v), p.coords.dot(direction)))
        };
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in part.clone().flat_map(seen) {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        if low.x > high.x {
            return false;
        }
        let widest = self.radius(f64::INFINITY);
        let edge = high - low;
        let pixel = self.pixel.max((edge.x.max(edge.y) + 2.0 * widest) / MAX_PIXELS);
        let reach = (widest / pixel).ceil() as usize + 1;
        let corner = [low.x, low.y].map(|c| c - (reach + 1) as f64 * pixel);
        let count = [edge.x, edge.y].map(|e| (e / pixel).ceil() as usize + 2 * reach + 3);
        let mut bottom = Map::new(corner, pixel, count, f64::INFINITY);
        part.for_each(|corners| bottom.draw(&seen(corners), |known, h| *known = known.min(h)));
        let mut top = Map::new(corner, pixel, count, f64::NEG_INFINITY);
        // What is no higher than the lowest tip is in no way.
        let floor = low.z + self.layer;
        let highest = |corners: &[Vector3<f64>; 3]| corners[0].z.max(corners[1].z).max(corners[2].z);
        let above = standing.map(seen).filter(|corners| highest(corners) > floor);
        above.for_each(|corners| top.draw(&corners, |known, h| *known = known.max(h)));

        // Offsets by their least distance, so that the nearest ones, which hit most often, come first.
        let span = reach as isize;
        let gap = |d: isize| (d.abs() - 1).max(0) as f64 * pixel;
        let mut offsets: Vec<(f64, isize)> = (-span..=span)
            .flat_map(|y| (-span..=span).map(move |x| (x, y)))
            .map(|(x, y)| (gap(x).hypot(gap(y)), x + y * count[0] as isize))
            .filter(|(distance, _)| *distance <= widest)
            .collect();
        offsets.sort_by(|a, b| a.0.total_cmp(&b.0));
        (0..bottom.heights.len()).filter(|&at| bottom.heights[at].is_finite()).any(|at| {
            let tip = bottom.heights[at] + self.layer;
            offsets.iter().any(|&(distance, shift)| {
                let height = top.heights[(at as isize + shift) as usize] - tip;
                height > 0.0 && distance <= self.radius(height)
            })
        })
    }
}

/// Two directions of length 1 across a third one.
fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = direction.iamin();
    let u = direction.cross(&Vector3::ith(least, 1.0)).normalize();
    [u, direction.cross(&u)]
}

/// Heights over the pixels of a rectangle.
struct Map {
    corner: [f64; 2],
    pixel: f64,
    count: [usize; 2],
    heights: Vec<f64>,
}

impl Map {
    fn new(corner: [f64; 2], pixel: f64, count: [usize; 2], empty: f64) -> Self {
        Map { corner, pixel, count, heights: vec![empty; count[0] * count[1]] }
    }

    /// Notes the heights of the corners of what each pixel sees of a triangle.
    fn draw(&mut self, corners: &[Vector3<f64>; 3], note: impl Fn(&mut f64, f64)) {
        let whole = Polygon::from(corners);
        for y in self.range(1, &whole) {
            let strip = whole.clipped(1, self.line(1, y), self.line(1, y + 1));
            for x in self.range(0, &strip) {
                let piece = strip.clipped(0, self.line(0, x), self.line(0, x + 1));
                let known = &mut self.heights[x + y * self.count[0]];
                piece.corners().iter().for_each(|p| note(known, p.z));
            }
        }
    }

    fn line(&self, axis: usize, number: usize) -> f64 {
        self.corner[axis] + number as f64 * self.pixel
    }

    /// The pixels along an axis that a polygon touches.
    fn range(&self, axis: usize, polygon: &Polygon) -> std::ops::Range<usize> {
        let along = || polygon.corners().iter().map(|p| p[axis]);
        let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        if polygon.count == 0 {
            return 0..0;
        }
        // Negative places become 0, those beyond the end the end.
        let at = |c: f64| ((c - self.corner[axis]) / self.pixel).floor();
        (at(low).max(0.0) as usize)..((at(high) + 1.0).max(0.0) as usize).min(self.count[axis])
    }
}

/// A triangle that two strips have cut has seven corners: each of four lines adds one. The others are for rounding, which may make a line
/// cross an edge that lies in it.
const MAX_CORNERS: usize = 9;

/// A convex polygon.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Vector3<f64>; MAX_CORNERS],
    count: usize,
}

impl From<&[Vector3<f64>; 3]> for Polygon {
    fn from(&[a, b, c]: &[Vector3<f64>; 3]) -> Self {
        let mut corners = [a; MAX_CORNERS];
        (corners[1], corners[2]) = (b, c);
        Polygon { corners, count: 3 }
    }
}

impl Polygon {
    fn corners(&self) -> &[Vector3<f64>] {
        &self.corners[..self.count]
    }

    /// What is left between two values of a coordinate (I. E. Sutherland and G. W. Hodgman, 1974).
    fn clipped(&self, axis: usize, low: f64, high: f64) -> Self {
        if self.corners().iter().all(|p| low <= p[axis] && p[axis] <= high) {
            return *self;
        }
        self.half(axis, low, 1.0).half(axis, high, -1.0)
    }

    fn half(&self, axis: usize, bound: f64, sign: f64) -> Self {
        let mut kept = Polygon { corners: [Vector3::zeros(); MAX_CORNERS], count: 0 };
        for (k, a) in self.corners().iter().enumerate() {
            let b = &self.corners[(k + 1) % self.count];
            let [ha, hb] = [a, b].map(|p| (p[axis] - bound) * sign);
            if ha >= 0.0 {
                kept.push(*a);
            }
            if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
                kept.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        kept
    }

    fn push(&mut self, corner: Vector3<f64>) {
        if self.count < MAX_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // whole numbers
mod tests {
    use super::*;

    /// Triangles with corners at random in a box.
    fn random(seed: &mut u64, count: usize, low: [f64; 3], size: f64) -> Vec<[Point3<f64>; 3]> {
        let mut next = || {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut point = || Point3::new(low[0] + size * next(), low[1] + size * next(), low[2] + size * next());
        (0..count).map(|_| [point(), point(), point()]).collect()
    }

    fn sampled(triangles: &[[Point3<f64>; 3]], direction: &Vector3<f64>) -> Vec<(Vector3<f64>, f64)> {
        let mut points = Vec::new();
        for [a, b, c] in triangles {
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let p = (a + (b - a) * (f64::from(i) / 20.0) + (c - a) * (f64::from(j) / 20.0)).coords;
                    let height = p.dot(direction);
                    points.push((p - direction * height, height));
                }
            }
        }
        points
    }

    /// Whether some sampled tip has the head, wider by `more`, in some sampled point.
    fn slow(
        head: &Head,
        direction: &Vector3<f64>,
        part: &[[Point3<f64>; 3]],
        standing: &[[Point3<f64>; 3]],
        more: f64,
    ) -> bool {
        let (part, standing) = (sampled(part, direction), sampled(standing, direction));
        part.iter().any(|(p, tip)| {
            standing.iter().any(|(q, height)| {
                let over = height - tip - head.layer + more;
                over > 0.0 && (p - q).norm() <= head.radius(over) + more
            })
        })
    }

    #[test]
    fn it_is_never_too_small_and_too_large_by_little() {
        let head = Head { cone_height: 3.0, block_radius: 5.0, pixel: 0.5, ..Head::default() };
        let (mut seed, mut seen) = (1u64, [0; 2]);
        for round in 0..60 {
            let part = random(&mut seed, 4, [0.0, 0.0, 0.0], 6.0);
            let gap = 4.0 + f64::from(round % 6) * 2.0;
            let standing = random(&mut seed, 6, [gap, 0.0, f64::from(round % 4) - 5.0], 8.0);
            let direction = random(&mut seed, 1, [-0.5, -0.5, 0.2], 1.0)[0][0].coords.normalize();
            let meets = head.meets(&direction, part.iter(), standing.iter());
            seen[usize::from(meets)] += 1;
            assert!(meets || !slow(&head, &direction, &part, &standing, 0.0), "round {round}: missed");
            // Two pixels' diagonals, and what lies between samples.
            assert!(!meets || slow(&head, &direction, &part, &standing, 2.5), "round {round}: invented");
        }
        assert!(seen[0] > 5 && seen[1] > 5, "{seen:?}");
    }

    #[test]
    fn pixels_see_exact_heights() {
        // A slope of 1 over a square of 4 pixels.
        let mut map = Map::new([0.0, 0.0], 1.0, [3, 3], f64::NEG_INFINITY);
        let [a, b, c] = [[0.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 0.0]].map(Vector3::from);
        map.draw(&[a, b, c], |known, h| *known = known.max(h));
        assert_eq!([0, 1, 3].map(|at| map.heights[at].to_bits()), [1.0, 2.0, 1.0].map(f64::to_bits));
        assert_eq!([4, 8].map(|at| map.heights[at].to_bits()), [1.0, f64::NEG_INFINITY].map(f64::to_bits));
    }

    /// Corners lie outside of the circle, the middles of sides on it.
    #[test]
    fn the_platform_in_triangles_holds_the_circle() {
        let head = Head::default();
        let middle = Point3::new(3.0, 4.0, 5.0);
        let triangles = head.platform(&middle, &Vector3::z());
        assert_eq!(triangles.len(), SIDES);
        for [_, a, b] in triangles {
            let (side, corner) = ((nalgebra::center(&a, &b) - middle).norm(), (a - middle).norm());
            assert!((side - head.platform_radius).abs() < 1e-9 && corner > side, "{side} {corner}");
        }
    }

    /// A sheet that stands upright has no width along one axis of the map.
    #[test]
    fn an_upright_sheet_is_no_empty_part() {
        let direction = Vector3::z();
        let [u, v] = across(&direction);
        let sheet =
            |along: Vector3<f64>| [[Point3::origin(), Point3::origin() + along * 4.0, Point3::new(0.0, 0.0, 4.0)]];
        let over = |p: f64, q: f64| Point3::from(u * p + v * q + direction * 6.0);
        let standing = [[over(-9.0, -9.0), over(9.0, -9.0), over(0.0, 18.0)]];
        for along in [u, v] {
            assert!(Head::default().meets(&direction, sheet(along).iter(), standing.iter()), "{along}");
        }
    }

    #[test]
    fn a_part_without_faces_meets_nothing() {
        let standing = [[Point3::origin(), Point3::new(1.0, 0.0, 9.0), Point3::new(0.0, 1.0, 9.0)]];
        assert!(!Head::default().meets(&Vector3::z(), [].iter(), standing.iter()));
        assert!(!Head::default().meets(&Vector3::z(), standing.iter(), [].iter()));
    }
}
