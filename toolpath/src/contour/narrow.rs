//! Single beads for what is narrower than two, and for what is left between others.
//!
//! Where the surface is less than a bead wide there is no level set half a bead from the boundary, and where rings turn
//! around the meeting of three sides they leave room. A single bead runs there along the middle of the room: the refined
//! mesh has edges along the medial axis, and a path along edges that avoids places with little room keeps to them. The
//! bead is that of the longest way found: from the place with the most room to the farthest one, and from there to the
//! farthest again. Branches follow by themselves, from where the first bead covers them.
//!
//! Strips narrower than the narrowest bead otherwise laid ([`BEAD_WIDTHS`]) get beads as wide as they are, by the same search: but only
//! as candidates. Which of them are laid is for `fill`, which knows the layers above.

use super::crossing::cross;
use super::polyline::Curve;
use super::segments::Segments;
use super::spacing::{BEAD_WIDTHS, Spacing};
use super::watch::Watch;
use crate::level_set::{Around, LevelField};
use crate::mesh::{SurfacePoint, on_segment, previous};
use crate::path::{PathError, SurfacePath};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How far from a single bead its branches begin, in beads: what it covers (half a bead), and a little.
const BRANCH_DISTANCE: f64 = 0.75;
/// Least length of a single bead, in beads. What is shorter is extended to this: a dot where there is room for no more.
const MIN_LENGTH: f64 = 0.25;
/// Points of single beads, which follow edges of the mesh, are at least this far apart, in beads.
const MIN_POINT_DISTANCE: f64 = 0.05;
/// How strongly paths avoid places off the middle: a step costs its length over this power of the clearance there,
/// so a higher one keeps nearer to the middle.
const CLEARANCE_POWER: i32 = 3;
/// Fitted beads may overlap others by this share of half the least width, so that gaps a little too narrow get one as well.
const MAX_OVERLAP_SHARE: f64 = 0.25;
/// Segments are looked up this far from a vertex, in beads: half the widest bead and half the least one.
const LOOKUP_DISTANCE: f64 = 1.0;
/// Uniform beads leave the space between rings as it is: only what is nearer to the boundary than this, in beads, gets a
/// single one. Rings that are left out for being short are no farther in.
const UNIFORM_MAX_BOUNDARY_DISTANCE: f64 = 0.66;
/// A uniform bead that is shorter than this, in beads, is left out: most of it would lie outside. So is one of a narrow strip: it is a
/// dot.
const SINGLE_MIN_LENGTH: f64 = 1.0;
/// Vertices with clearance are this far from other curves, in beads: half the least width and the least clearance. An edge between
/// two of them that is shorter than twice this crosses none. Narrow strips of [`LOWEST_MIN_WIDTH`] have just that.
const MIN_CURVE_DISTANCE: f64 = 0.5;
/// The least width of a bead that may be asked for, in beads.
pub(super) const LOWEST_MIN_WIDTH: f64 = 0.25;

/// Shortest paths: for each vertex what it costs, how long the path is, and the vertex before.
type Reached = Vec<Option<(f64, f64, u32)>>;

/// A single bead: points and widths.
pub(super) type Single = (Vec<SurfacePoint>, Vec<f64>);

/// Which single beads are looked for. Lengths in millimetres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    bead: f64,
    /// Least distance from the boundary, and from the beads beside it.
    clearance: [f64; 2],
    /// Vertices at this distance from the boundary or farther have none.
    most: f64,
    /// Shorter ones are left out.
    shortest: f64,
    /// Least and largest width.
    widths: [f64; 2],
    /// Squares of a bead that one covers at least where the part of the mesh has a curve.
    gap: f64,
}

impl Wanted {
    /// Those of places with too little room for two beads.
    pub fn usual(spacing: &Spacing, [bead, gap]: [f64; 2]) -> Wanted {
        let least = spacing.least_single();
        if spacing.fits() {
            let (clearance, widths) =
                ([least, (1.0 - MAX_OVERLAP_SHARE) * least], BEAD_WIDTHS.map(|width| width * bead));
            Wanted { bead, clearance, most: f64::INFINITY, shortest: 0.0, widths, gap }
        } else {
            let most = UNIFORM_MAX_BOUNDARY_DISTANCE * bead;
            Wanted { bead, clearance: [least; 2], most, shortest: SINGLE_MIN_LENGTH * bead, widths: [bead; 2], gap }
        }
    }

    /// Those of strips that are narrower still, down to `min_width` beads.
    fn of_strips(min_width: f64, [bead, gap]: [f64; 2]) -> Wanted {
        let (clearance, widths) = ([0.5 * min_width * bead; 2], [min_width, BEAD_WIDTHS[1]].map(|width| width * bead));
        Wanted { bead, clearance, most: f64::INFINITY, shortest: SINGLE_MIN_LENGTH * bead, widths, gap }
    }
}

/// Beads for strips too narrow for others, beside the paths that are there: points and widths, from `min_width` beads on. None beside
/// uniform beads: those lie in strips half as wide as they are.
pub(super) fn strip_beads(
    field: &LevelField,
    spacing: &Spacing,
    [bead, gap, min_width]: [f64; 3],
    paths: &[SurfacePath],
    inside: &[f64],
    watch: Watch,
) -> Result<Vec<Single>, PathError> {
    if !spacing.fits() || min_width >= BEAD_WIDTHS[0] {
        return Ok(Vec::new());
    }
    let curve = |path: &SurfacePath| {
        let (points, widths) = path.points.iter().map(|point| (point.at, point.width)).unzip();
        (Curve { points, closed: path.closed, region: path.region, least: 0.0 }, widths)
    };
    let (curves, widths): (Vec<Curve>, Vec<Vec<f64>>) = paths.iter().map(curve).unzip();
    single_beads(field, &Wanted::of_strips(min_width, [bead, gap]), &curves, &widths, inside, watch)
}

/// Single beads where curves with widths leave room: those that cover at least `gap` squares of a bead, and one in each part
/// of the mesh that has no curve. None at vertices that are `inside` of all contours: that is for infill.
pub(super) fn single_beads(
    field: &LevelField,
    wanted: &Wanted,
    curves: &[Curve],
    widths: &[Vec<f64>],
    inside: &[f64],
    watch: Watch,
) -> Result<Vec<Single>, PathError> {
    let &Wanted { bead, clearance: [least, shallow], most, shortest, widths: [narrowest, widest], gap } = wanted;
    let beside = OtherCurves { curves, widths, segments: Segments::of(curves, 4.0 / 3.0 * LOOKUP_DISTANCE * bead) };
    let room = |v: u32| match field.values[v as usize] {
        _ if inside.get(v as usize).is_some_and(|&inside| inside > 0.0) => 0.0,
        value if value >= least && value < most => beside.room(field.points[v as usize], value, shallow),
        _ => 0.0,
    };
    let room: Vec<f64> = (0..field.values.len() as u32).map(room).collect();
    let mut open: Vec<bool> = room.iter().map(|&room| room > 0.0).collect();
    let graph = Graph { field, around: Around::new(field), room, beside, safe: 2.0 * MIN_CURVE_DISTANCE * bead };
    let parts = field.distance().mesh().regions();
    let mut has_curve = vec![false; parts.count];
    let part_of = |point: &SurfacePoint| parts.of_triangle[point.triangle as usize] as usize;
    curves.iter().flat_map(|curve| &curve.points).for_each(|point| has_curve[part_of(point)] = true);
    let mut found: Vec<Vec<SurfacePoint>> = Vec::new();
    let mut singles = Vec::new();
    let mut waiting: Vec<u32> = (0..field.values.len() as u32).rev().collect();
    // Each round closes what the new bead covers, so this ends; what of the part is then still open are its branches.
    while let Some(v) = waiting.pop() {
        if !open[v as usize] {
            continue;
        }
        watch()?;
        let part = graph.part(v, &open);
        let way = graph.longest(&part, &open);
        let covered = graph.reach(&way, |v| open[v as usize], |length, _| length, BRANCH_DISTANCE * bead);
        part.iter().filter(|&&v| covered[v as usize].is_some()).for_each(|&v| open[v as usize] = false);
        waiting.extend(part.iter().rev().filter(|&&v| open[v as usize]));
        if graph.along(&way) < shortest {
            continue;
        }
        let (points, room) = graph.line(&way, MIN_LENGTH * bead);
        let Some(mesh_part) = points.first().map(part_of) else { continue };
        // A part of the mesh without any curve gets a bead however little it covers: nothing else would be laid there.
        if has_curve[mesh_part] && graph.covered(&way) < gap * bead * bead {
            continue;
        }
        if points.len() > 1 && !graph.crosses(&points, &found) {
            has_curve[mesh_part] = true;
            let widths = room.into_iter().map(|room| (2.0 * room).clamp(narrowest, widest));
            singles.push(apart(points.iter().copied().zip(widths), MIN_POINT_DISTANCE * bead));
            found.push(points);
        }
    }
    Ok(singles)
}

/// What is left of points if those near the one before go; the first and the last stay.
fn apart(points: impl Iterator<Item = (SurfacePoint, f64)>, least: f64) -> Single {
    let mut kept: Vec<(SurfacePoint, f64)> = Vec::new();
    let near = |kept: &[(SurfacePoint, f64)], at: &SurfacePoint| {
        kept.last().is_some_and(|(last, _)| (last.position - at.position).norm() < least)
    };
    let mut skipped = None;
    for (at, width) in points {
        skipped = near(&kept, &at).then_some((at, width));
        if skipped.is_none() {
            kept.push((at, width));
        }
    }
    if let Some(last) = skipped {
        if kept.len() > 1 {
            kept.pop();
        }
        kept.push(last);
    }
    kept.into_iter().unzip()
}

/// Curves that are there already.
struct OtherCurves<'a> {
    curves: &'a [Curve],
    widths: &'a [Vec<f64>],
    segments: Segments,
}

impl OtherCurves<'_> {
    /// How far a point is from the beads around it, at most `most`; zero if it is nearer than `least`.
    fn room(&self, p: nalgebra::Point3<f64>, most: f64, least: f64) -> f64 {
        let mut room = most;
        // Most points lie under a bead, which is found at once.
        for [number, k] in self.segments.near_by_distance(p) {
            let (points, widths) = (&self.curves[number as usize].points, &self.widths[number as usize]);
            let ends = [k as usize, (k as usize + 1) % points.len()];
            let width = 0.5 * (widths[ends[0]] + widths[ends[1]]);
            room = room.min((on_segment(ends.map(|k| points[k].position), p) - p).norm() - 0.5 * width);
            if room < least {
                return 0.0;
            }
        }
        room
    }
}

/// Vertices and edges of the refined mesh.
struct Graph<'a, 'd> {
    field: &'a LevelField<'d>,
    around: Around,
    /// How far each vertex is from the boundary and from beads; zero where that is too little.
    room: Vec<f64>,
    beside: OtherCurves<'a>,
    /// Edges shorter than this between vertices with room cross no curve.
    safe: f64,
}

impl Graph<'_, '_> {
    fn length(&self, v: u32, other: u32) -> f64 {
        (self.field.points[other as usize] - self.field.points[v as usize]).norm()
    }

    /// The length of a way.
    fn along(&self, way: &[u32]) -> f64 {
        way.windows(2).map(|pair| self.length(pair[0], pair[1])).sum()
    }

    /// What a bead along a way covers that touches nothing, with round ends squared.
    fn covered(&self, way: &[u32]) -> f64 {
        let width = 2.0 * way.iter().map(|&v| self.room[v as usize]).sum::<f64>() / way.len().max(1) as f64;
        (self.along(way) + width) * width
    }

    /// The open vertices beside one that edges lead to without crossing a bead.
    fn neighbours<'a>(&'a self, v: u32, open: impl Fn(u32) -> bool + 'a) -> impl Iterator<Item = u32> + 'a {
        let is_clear = move |&other: &u32| {
            let [p, q] = [v, other].map(|v| self.field.points[v as usize]);
            // A long edge may cross a bead between its ends: it is looked at in steps too short for that.
            let steps = ((q - p).norm() / self.safe).floor() as usize;
            let room = |k: usize| self.beside.room(p + (q - p) * (k as f64 / (steps + 1) as f64), self.safe, 0.0);
            (1..=steps).all(|k| room(k) > 0.0)
        };
        self.around.neighbours(self.field, v).filter(move |&other| open(other)).filter(is_clear)
    }

    /// Dijkstra's algorithm. The cost of a step depends on its length and the mean room on it.
    fn reach(&self, from: &[u32], open: impl Fn(u32) -> bool, cost: impl Fn(f64, f64) -> f64, most: f64) -> Reached {
        let mut reached: Reached = vec![None; self.field.values.len()];
        let mut queue = BinaryHeap::new();
        for &v in from {
            reached[v as usize] = Some((0.0, 0.0, v));
            queue.push((Reverse(0u64), v));
        }
        // Bits of positive numbers are in the order of the numbers.
        while let Some((Reverse(bits), v)) = queue.pop() {
            let Some((here, length, _)) = reached[v as usize].filter(|(here, ..)| here.to_bits() == bits) else {
                continue;
            };
            for other in self.neighbours(v, &open) {
                let mean = 0.5 * (self.room[v as usize] + self.room[other as usize]);
                let step = self.length(v, other);
                let there = here + cost(step, mean);
                if there <= most && reached[other as usize].is_none_or(|(known, ..)| there < known) {
                    reached[other as usize] = Some((there, length + step, v));
                    queue.push((Reverse(there.to_bits()), other));
                }
            }
        }
        reached
    }

    /// The open vertices that are connected with one of them.
    fn part(&self, v: u32, open: &[bool]) -> Vec<u32> {
        let mut part = vec![v];
        let mut seen = std::collections::BTreeSet::from([v]);
        let mut k = 0;
        while k < part.len() {
            for other in self.neighbours(part[k], |other| open[other as usize]) {
                if seen.insert(other) {
                    part.push(other);
                }
            }
            k += 1;
        }
        part
    }

    /// A long way through a part.
    fn longest(&self, part: &[u32], open: &[bool]) -> Vec<u32> {
        let value = |v: u32| self.room[v as usize];
        let Some(summit) = part.iter().copied().max_by(|&a, &b| value(a).total_cmp(&value(b)).then(b.cmp(&a))) else {
            return Vec::new();
        };
        let far = |from: u32| {
            let cost = |length: f64, mean: f64| length * (value(summit) / mean).powi(CLEARANCE_POWER);
            let reached = self.reach(&[from], |v| open[v as usize], cost, f64::INFINITY);
            let length = |v: u32| reached[v as usize].map_or(0.0, |(_, length, _)| length);
            let end = part.iter().copied().max_by(|&a, &b| length(a).total_cmp(&length(b)).then(b.cmp(&a)));
            (end.unwrap_or(from), reached)
        };
        // Twice the farthest: on a tree that is the longest way there is, and the medial axis nearly is one.
        let (one, _) = far(summit);
        let (other, reached) = far(one);
        let mut way = vec![other];
        while let Some(&at) = way.last().filter(|&&at| at != one) {
            let Some((_, _, before)) = reached[at as usize] else { break };
            way.push(before);
        }
        way
    }

    /// The points of a way, and the room at each. One that is too short goes on a little, to where there is most room.
    fn line(&self, way: &[u32], shortest: f64) -> Single {
        let position = |v: u32| self.field.points[v as usize];
        let point = |&v: &u32| self.field.surface_point(self.around.of(v)[0] / 3, position(v));
        let (mut points, mut room): Single =
            (way.iter().map(point).collect(), way.iter().map(|&v| self.room[v as usize]).collect());
        let missing = shortest - self.along(way);
        let Some(&last) = way.last().filter(|_| missing > 0.0) else { return (points, room) };
        let sides = self.around.of(last).iter();
        let ways_on = sides.flat_map(|&h| [self.field.head(h), self.field.tail(previous(h))].map(|v| (h / 3, v)));
        let value = |v: u32| (self.room[v as usize], self.field.values[v as usize]);
        let on = ways_on.filter(|(_, v)| !way.contains(v)).max_by(|(_, a), (_, b)| {
            let (a, b) = (value(*a), value(*b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        if let Some((triangle, to)) = on {
            let share = (missing / self.length(last, to)).min(1.0);
            points.push(self.field.surface_point(triangle, position(last) + (position(to) - position(last)) * share));
            room.push(self.room[last as usize]);
        }
        (points, room)
    }

    /// Whether a line crosses others. Those of short segments never do: they begin where others cover nothing.
    fn crosses(&self, points: &[SurfacePoint], others: &[Vec<SurfacePoint>]) -> bool {
        let mesh = self.field.distance().mesh();
        let long = |pair: &&[SurfacePoint]| (pair[1].position - pair[0].position).norm() > 0.5 * self.safe;
        points.windows(2).filter(long).any(|one| {
            let mut all = others.iter().flat_map(|line| line.windows(2));
            all.any(|other| cross(mesh, [&one[0], &one[1]], [&other[0], &other[1]]))
        })
    }
}
