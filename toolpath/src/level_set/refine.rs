//! Cuts of edges and triangles where the distance is not linear.
//!
//! An edge is cut where the distance leaves the straight line between its ends: at the ridge if there is one, found from
//! the slopes on both sides of it. Edges are cut longest first, and the longest side of a flat triangle before others;
//! in any other order cuts run to and fro between two ridges beside a long edge that passes its own check.

use super::LevelSetError;
use super::field::LevelField;
use crate::geodesic::{SurfaceDistance, TriangleLights};
use crate::mesh::{NONE, next, previous};
use crate::{Progress, ProgressFn};
use nalgebra::Point3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Places on an edge where the distance is compared with the straight line. A tent over an edge stands at one of
/// them at least three quarters as high as at its ridge.
const PROBES: [f64; 3] = [0.25, 0.5, 0.75];
/// Edges are held to this share of the tolerance: the rest is for what the probes miss.
const EDGE_SHARE: f64 = 0.5;
/// A longer edge of the same triangle that is off by this share is cut first. Else, beside an edge that just passes,
/// cuts run to and fro between two ridges that cross it, and come nearer to it without end.
const LONGER_SHARE: f64 = 0.25;
/// A triangle lower than this share of the tolerance counts as lying on its longest edge.
const FLAT: f64 = 0.25;
/// Steps of the search for the ridge on an edge; two or three will do, unless many ridges are near each other.
const STEPS: usize = 16;
/// The ridge is found where the distance is off what the slopes on both sides predict by this share of the tolerance.
const RIDGE: f64 = 0.002;
/// A cut this near to an end, as a share of the edge, would make a sliver; then the middle will do.
const NEAR_END: f64 = 1e-3;
/// New triangles for each old one, and in any case, beyond which the tolerance is refused as too fine.
const MAX_NEW: [usize; 2] = [64, 1 << 16];

/// Triangles whose lights are kept. Cuts come by length, so the same triangles come again and again; layers have some
/// thousands. One takes some kilobytes.
const KEPT: usize = 1 << 12;

/// Cuts between two reports of progress, nearly.
const REPORT: usize = 1 << 10;

/// A place of a cut and the distance there.
type Cut = (Point3<f64>, f64);

/// An edge that is to be cut.
#[derive(Clone, Copy)]
struct Off {
    /// Its length and one of its half-edges.
    key: (u64, Reverse<u32>),
    /// Numbers of its ends, by which it is known when its half-edge is another edge's.
    ends: [u32; 2],
    cut: Cut,
}

impl Ord for Off {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.cmp(&other.key)
    }
}

impl PartialOrd for Off {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Off {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl Eq for Off {}

impl<'d> LevelField<'d> {
    /// Refines the mesh of a distance until the distance is linear over each triangle within a tolerance.
    ///
    /// # Arguments
    /// * `tolerance`: in millimetres. The level sets run where the distance is that of the level within about this
    ///   much. A hundredth of a bead is fine enough for paths.
    ///
    /// # Errors
    /// [`LevelSetError::Tolerance`], [`LevelSetError::TooFine`], [`LevelSetError::Cancelled`].
    ///
    /// # Cost
    /// A few questions for the distance on each edge, and some fifty on each edge that the medial axis crosses.
    pub fn new(distance: &'d SurfaceDistance<'d>, tolerance: f64, progress: ProgressFn) -> Result<Self, LevelSetError> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(LevelSetError::Tolerance { tolerance });
        }
        let mut field = LevelField::unrefined(distance);
        Refiner::new(&mut field, tolerance).refine(progress)?;
        Ok(field)
    }
}

/// A field that is being refined.
struct Refiner<'r, 'd> {
    field: &'r mut LevelField<'d>,
    tolerance: f64,
    /// Lights of triangles seen of late; that of triangle `t` has the place `t % KEPT`.
    lights: Vec<TriangleLights>,
    /// Edges that are to be cut, longest first. What has other ends by now is stale.
    edges: BinaryHeap<Off>,
    edge_waits: Vec<bool>,
    /// Triangles that wait for a check.
    hollow: Vec<u32>,
    hollow_waits: Vec<bool>,
}

impl<'r, 'd> Refiner<'r, 'd> {
    fn new(field: &'r mut LevelField<'d>, tolerance: f64) -> Self {
        let (half_edges, triangles) = (field.half_edges() as usize, field.triangles.len());
        let mut refiner = Refiner {
            field,
            tolerance,
            lights: vec![TriangleLights::default(); KEPT.min(triangles)],
            edges: BinaryHeap::new(),
            edge_waits: vec![false; half_edges],
            hollow: (0..triangles as u32).collect(),
            hollow_waits: vec![true; triangles],
        };
        let all = (0..half_edges as u32).filter(|&h| h < refiner.field.twins[h as usize]).collect::<Vec<_>>();
        all.into_iter().for_each(|h| refiner.check(h));
        refiner
    }

    fn refine(&mut self, progress: ProgressFn) -> Result<(), LevelSetError> {
        let most = self.field.triangles.len() * (MAX_NEW[0] + 1) + MAX_NEW[1];
        loop {
            while let Some(Off { key: (_, Reverse(h)), ends, cut }) = self.edges.pop() {
                if [self.field.tail(h), self.field.head(h)] != ends {
                    continue;
                }
                self.edge_waits[h as usize] = false;
                let (longest, cut) = self.longest_around(h, cut);
                if longest != h {
                    // Before the cut, which may give it another number.
                    self.check(h);
                }
                self.cut(longest, cut);
                if self.edges.len().is_multiple_of(REPORT) {
                    // Cuts add edges, so this is a lower bound of what is left.
                    let total = u64::from(self.field.half_edges() / 2);
                    let done = total.saturating_sub(self.edges.len() as u64);
                    if progress(Progress { stage: "level field", done, total }).is_break() {
                        return Err(LevelSetError::Cancelled);
                    }
                }
                let triangles = self.field.triangles.len();
                if triangles > most {
                    return Err(LevelSetError::TooFine { tolerance: self.tolerance, triangles });
                }
            }
            let Some(triangle) = self.hollow.pop() else { return Ok(()) };
            self.hollow_waits[triangle as usize] = false;
            if let Some(summit) = self.summit_in(triangle) {
                self.put_in(triangle, summit);
            }
        }
    }

    /// Lets an edge wait if it is to be cut.
    fn check(&mut self, h: u32) {
        let off = self.off_line(h, EDGE_SHARE);
        self.edge_waits[h as usize] = off.is_some();
        if let Some(cut) = off {
            let ends = [self.field.tail(h), self.field.head(h)];
            self.edges.push(Off { key: self.by_length(h), ends, cut });
        }
    }

    /// Lets a triangle wait.
    fn check_inside(&mut self, triangle: u32) {
        if !std::mem::replace(&mut self.hollow_waits[triangle as usize], true) {
            self.hollow.push(triangle);
        }
    }

    fn by_length(&self, h: u32) -> (u64, Reverse<u32>) {
        let [from, to] = self.ends(h);
        let length = (to - from).norm();
        (length.to_bits(), Reverse(h)) // bits of positive numbers are in the order of the numbers
    }

    fn ends(&self, h: u32) -> [Point3<f64>; 2] {
        [self.field.tail(h), self.field.head(h)].map(|v| self.field.points[v as usize])
    }

    /// From an edge that is to be cut to a longer one beside it that is off too, and so on. The longest side of a flat
    /// triangle is cut in any case, beside the cut that was asked for.
    fn longest_around(&mut self, h: u32, off: Cut) -> (u32, Cut) {
        let (mut longest, mut off) = (h, off);
        loop {
            let sides = [Some(longest), self.field.twin(longest)];
            let mut found: Option<(u32, Cut)> = None;
            for side in sides.into_iter().flatten() {
                if let Some(cut) = self.longer_beside(side, off.0)
                    && found.is_none_or(|(known, _)| self.by_length(known) < self.by_length(cut.0))
                {
                    found = Some(cut);
                }
            }
            match found {
                Some(found) => (longest, off) = found,
                None => return (longest, off),
            }
        }
    }

    /// The longest side of the triangle of a half-edge, if that is another one and is to be cut first.
    fn longer_beside(&mut self, side: u32, wanted: Point3<f64>) -> Option<(u32, Cut)> {
        let longer = [next(side), previous(side)].into_iter().max_by_key(|&h| self.by_length(h))?;
        if self.by_length(longer).0 <= self.by_length(side).0 {
            return None;
        }
        if let Some(cut) = self.off_line(longer, LONGER_SHARE) {
            return Some((longer, cut));
        }
        let [a, b] = self.ends(longer);
        let t = (wanted - a).dot(&(b - a)) / (b - a).norm_squared();
        let flat = self.height(side / 3) <= FLAT * self.tolerance && (NEAR_END..=1.0 - NEAR_END).contains(&t);
        if !flat {
            return None;
        }
        let foot = a + (b - a) * t;
        let lights = self.lights(side / 3);
        Some((longer, (foot, lights.distance(lights.flat(foot)))))
    }

    /// What reaches a triangle.
    fn lights(&mut self, triangle: u32) -> &TriangleLights {
        let parent = self.field.parents[triangle as usize];
        let slot = parent as usize % self.lights.len();
        self.lights[slot].load(self.field.distance(), parent);
        &self.lights[slot]
    }

    /// The height of a triangle over its longest side.
    fn height(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.field.triangles[triangle as usize].map(|v| self.field.points[v as usize]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        (b - a).cross(&(c - a)).norm() / longest
    }

    /// Where an edge is to be cut, if the distance along it is off the straight line by more than a share of the
    /// tolerance.
    fn off_line(&mut self, h: u32, share: f64) -> Option<Cut> {
        let [from, to] = [self.field.tail(h), self.field.head(h)];
        let [a, b] = self.ends(h);
        let [first, last] = [from, to].map(|v| self.field.values[v as usize]);
        // Over a short edge the distance cannot change by more.
        if (b - a).norm() <= share * self.tolerance || !first.is_finite() || !last.is_finite() {
            return None;
        }
        let distance = self.field.distance();
        let mesh = distance.mesh();
        let line = |t: f64| first + (last - first) * t;
        let allowed = share * self.tolerance;
        let probed = if h < mesh.half_edges() && [from, to] == [mesh.tail(h), mesh.head(h)] {
            PROBES.map(|t| distance.along(h, t) - line(t))
        } else {
            let lights = self.lights(h / 3);
            let [a, b] = [a, b].map(|p| lights.flat(p));
            let found = lights.distances(PROBES.map(|t| [0, 1].map(|k| a[k] + (b[k] - a[k]) * t)));
            [0, 1, 2].map(|k| found[k] - line(PROBES[k]))
        };
        let worst = (0..PROBES.len()).max_by(|&i, &j| probed[i].abs().total_cmp(&probed[j].abs()))?;
        if probed[worst].abs() <= allowed {
            return None;
        }
        let enough = RIDGE * self.tolerance;
        let lights = self.lights(h / 3);
        let mut cut = PROBES[worst];
        if probed[worst] > 0.0 {
            cut = ridge(lights, [a, b].map(|p| lights.flat(p)), last - first, cut, enough);
            if !(NEAR_END..=1.0 - NEAR_END).contains(&cut) {
                cut = 0.5;
            }
        }
        let point = a + (b - a) * cut;
        Some((point, lights.distance(lights.flat(point))))
    }

    /// A point of a triangle where the distance is far above or below the plane through its corners.
    fn summit_in(&mut self, triangle: u32) -> Option<Cut> {
        let corners = self.field.triangles[triangle as usize];
        let points = corners.map(|v| self.field.points[v as usize]);
        let values = corners.map(|v| self.field.values[v as usize]);
        if self.height(triangle) <= FLAT * self.tolerance || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let tolerance = self.tolerance;
        let lights = self.lights(triangle);
        let flat = points.map(|p| lights.flat(p));
        let value =
            |w: [f64; 3]| lights.distance([0, 1].map(|k| flat[0][k] * w[0] + flat[1][k] * w[1] + flat[2][k] * w[2]));
        let above = |w: [f64; 3]| value(w) - values[0] * w[0] - values[1] * w[1] - values[2] * w[2];
        let mut best = [1.0 / 3.0; 3];
        let mut height = above(best);
        if height.abs() <= tolerance {
            return None;
        }
        let sign = height.signum();
        let longest = (0..3).map(|k| (points[(k + 1) % 3] - points[k]).norm()).fold(0.0, f64::max);
        // From the middle towards one corner and away from another, in ever smaller steps.
        let mut step = 0.25;
        while step * longest > 0.01 * tolerance {
            let mut moved = false;
            for (up, down) in [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)] {
                let mut w = best;
                (w[up], w[down]) = (w[up] + step, w[down] - step);
                let there = if w[down] > NEAR_END { above(w) } else { continue };
                if sign * there > sign * height {
                    (best, height, moved) = (w, there, true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        let [a, b, c] = [0, 1, 2].map(|k| points[k].coords * best[k]);
        Some(((a + b + c).into(), value(best)))
    }

    fn new_vertex(&mut self, (point, value): Cut) -> u32 {
        self.field.points.push(point);
        self.field.values.push(value);
        self.field.points.len() as u32 - 1
    }

    fn new_triangle(&mut self, corners: [u32; 3], parent: u32) -> u32 {
        self.field.triangles.push(corners);
        self.field.parents.push(parent);
        self.field.twins.extend([NONE; 3]);
        self.edge_waits.extend([false; 3]);
        self.hollow_waits.push(false);
        3 * (self.field.triangles.len() as u32 - 1)
    }

    fn join(&mut self, one: u32, other: u32) {
        if one != NONE {
            self.field.twins[one as usize] = other;
        }
        if other != NONE {
            self.field.twins[other as usize] = one;
        }
    }

    /// Cuts an edge, and the triangle on each side of it.
    fn cut(&mut self, h: u32, cut: Cut) {
        let middle = self.new_vertex(cut);
        let twin = self.field.twin(h);
        let far = self.cut_side(h, middle);
        let back = twin.map_or(NONE, |twin| self.cut_side(twin, middle));
        self.join(h, back);
        self.join(far, twin.unwrap_or(NONE));
        self.check(h);
        self.check(far);
    }

    /// Cuts the triangle of `h` from a point of `h` to the corner across. `h` keeps its first part; returns the other.
    fn cut_side(&mut self, h: u32, middle: u32) -> u32 {
        let (ahead, corner) = (next(h), self.field.tail(previous(h)));
        let far = self.new_triangle([middle, self.field.head(h), corner], self.field.parents[h as usize / 3]);
        self.field.triangles[ahead as usize / 3][ahead as usize % 3] = middle;
        self.join(far + 1, self.field.twins[ahead as usize]);
        self.join(far + 2, ahead);
        // What waits under a number that is another edge's now.
        if std::mem::replace(&mut self.edge_waits[ahead as usize], false) {
            self.check(far + 1);
        }
        self.check(far + 2);
        self.check_inside(h / 3);
        self.check_inside(far / 3);
        far
    }

    /// Puts a vertex into a triangle, which becomes three. No edge waits.
    fn put_in(&mut self, triangle: u32, summit: Cut) {
        let middle = self.new_vertex(summit);
        let [a, b, c] = self.field.triangles[triangle as usize];
        let (old, parent) = (3 * triangle, self.field.parents[triangle as usize]);
        let (second, third) = (self.new_triangle([b, c, middle], parent), self.new_triangle([c, a, middle], parent));
        self.field.triangles[triangle as usize] = [a, b, middle];
        self.join(second, self.field.twins[old as usize + 1]);
        self.join(third, self.field.twins[old as usize + 2]);
        self.join(old + 1, second + 2);
        self.join(second + 1, third + 2);
        self.join(third + 1, old + 2);
        [old + 1, second + 1, third + 1].into_iter().for_each(|h| self.check(h));
        [old, second, third].into_iter().for_each(|h| self.check_inside(h / 3));
    }
}

/// Where the distance is highest above the straight line along an edge that rises by `chord`; near a place on it. The
/// search is over where slopes predict the distance to within `enough`.
fn ridge(lights: &TriangleLights, [a, b]: [[f64; 2]; 2], chord: f64, near: f64, enough: f64) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let above = |t: f64| {
        let (distance, slope) = lights.slope([0, 1].map(|k| a[k] + along[k] * t), along);
        (t, distance - chord * t, slope - chord)
    };
    let (mut low, mut high) = (above(near - 0.25), above(near + 0.25));
    let mut best = above(near);
    // Uphill from both sides: the ridge is where straight lines on in the directions of both sides meet.
    for _ in 0..STEPS {
        if low.2 <= 0.0 || high.2 >= 0.0 {
            break;
        }
        let mut meet = (high.1 - low.1 + low.2 * low.0 - high.2 * high.0) / (low.2 - high.2);
        if !(low.0 < meet && meet < high.0) {
            meet = 0.5 * (low.0 + high.0);
        }
        let predicted = low.1 + low.2 * (meet - low.0);
        let there = above(meet);
        if there.1 > best.1 {
            best = there;
        }
        if (there.1 - predicted).abs() <= enough {
            break;
        }
        if there.2 > 0.0 {
            low = there;
        } else {
            high = there;
        }
    }
    best.0
}
