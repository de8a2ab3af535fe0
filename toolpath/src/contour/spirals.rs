//! Connected Fermat spirals: the rings of each chain cut open and led into each other.
//!
//! The rings of a chain from its door inward are 1 to n; 0 is the parent, if it has one. Along a line across all of them
//! (each point of a ring lies straight above one of the ring below, so there are such lines) each ring is opened over a
//! window from `L` by the middle `G` to `R`:
//!
//! ```text
//!   0 ======= L                      |  ==========      the parent
//!                 \                  |
//!   1 ======= L      G             . R ===========      the door
//!                \       \
//!   2 ======= L      G       R ===================
//!                \       \
//!   3 ======= L      G       R ===================
//! ```
//! A single ring is joined to its parent by two bridges straight across, a bead apart.
//!
//! Each `L` of a ring i runs by the `G` of the next ring to the `R` of the one after. So two arms wind inward, each
//! over every other ring, in even spacing: a Fermat spiral. Its arms are joined around the last ring; on the outside they
//! lead into the parent, at places next to each other, or are entry and exit of the region.
//!
//! A bridge is made of points between matching places of two rings, brought down to the surface. It counts only if the
//! distance there lies between the levels of these rings: then it crosses no ring, whatever the surface does. It must not
//! cross itself or the ends of the rings that it joins, as it may where a ring turns back on itself. And
//! it must keep away from other bridges in the same band. Places are tried with wide windows first, those where the
//! rings run side by side best. Where no line crosses all rings, a chain is joined to itself half way in; where no bridge
//! is found for a single ring, it becomes a curve of its own, or gives way to a single bead if it is very small.

use super::chains::{Chain, ParentSide};
use super::crossing::{cross, crosses_itself};
use super::curve::{Loop, locate};
use super::plan::{End, Plan, Side};
use super::spacing::Spacing;
use super::thin::SAME;
use super::watch::Watch;
use crate::level_set::LevelSets;
use crate::mesh::{SurfaceMesh, SurfacePoint};
use crate::path::PathError;
use nalgebra::Point3;

/// Half widths of the windows that are tried, in beads, widest first. The wider, the more even the spacing: bridges are
/// `sin(atan(1 / h)) h` beads apart, 0.83, 0.71, 0.45, 0.24, 0.12, and the less they turn. But beside the outermost and the
/// innermost bridge a wedge as long as the window stays bare: half windows of three beads leave 2 % more bare, and 0.83 is still
/// a width that a bead may have.
const HALF_WINDOWS: [f64; 5] = [1.5, 1.0, 0.5, 0.25, 0.125];
/// The same where a single ring is joined to its parent, in widths of the bead there: two bridges straight across, a bead apart,
/// leave nothing bare.
const PAIR_HALF_WINDOWS: [f64; 4] = [0.5, 0.375, 0.25, 0.125];
/// Where the bridge of a chain comes to its parent, in half windows from the middle: half way along.
const PARENT_BRIDGE: f64 = 0.5;
/// Half windows on small rings are at most this share of their length: a window takes two of them and a margin.
const MAX_HALF_WINDOW_SHARE: f64 = 1.0 / 6.0;
/// How far apart matching places of two rings may be, in beads: one where rings run side by side, and more at corners.
const MAX_NODE_DISTANCE: f64 = 1.6;
/// Most places on a ring that are rated: bounds the cost on long rings.
const MAX_PLACES: usize = 256;
/// Most of these, the best first, of which bridges are made and checked, which costs far more.
const MAX_CHECKED_PLACES: usize = 48;
/// How much of its way between two levels a point of a bridge must have made at least, as a share of what it should. Below 1, since
/// distance does not rise evenly between two rings where the surface bends.
const MIN_PROGRESS: f64 = 0.25;
/// Places between two stations where the same is asked, as shares of the step, and the share of progress there: only to stay
/// between the two rings.
const SUBSTEPS: [f64; 3] = [0.25, 0.5, 0.75];
const MIN_SUBSTEP_PROGRESS: f64 = 0.02;
/// How far bridges keep apart, as a share of a bead or half window, whichever is less. Made as intended they are at least 0.4
/// apart.
const BRIDGE_CLEARANCE: f64 = 0.3;
/// How far a bridge may be from straight, in beads: sheets that bend more sharply have no place for it.
const MAX_BRIDGE_DEVIATION: f64 = 0.3;
/// Between its stations a bridge gets points on the surface where that is farther than this from straight, in beads.
const BRIDGE_TOLERANCE: f64 = 0.005;
/// A ring that no bridge leads to is left out if it is shorter, in beads: it goes round less than a disc as wide as a bead, which
/// a single bead fills as well.
const MIN_RING_LENGTH: f64 = std::f64::consts::PI;
/// How far along the rings that it joins a bridge is checked for crossings, in beads: longer than the longest bridge, about
/// `hypot(1.5, 1)`.
const RING_CHECK_LENGTH: f64 = 2.0;
/// Points of a bridge for each bead of length: chords of an eighth of a bead.
const POINTS_PER_BEAD: f64 = 8.0;

/// The rings that the spirals of a layer are made of.
pub(super) struct Rings<'a> {
    pub mesh: &'a SurfaceMesh,
    pub sets: &'a LevelSets,
    pub spacing: &'a Spacing<'a, 'a>,
    pub loops: &'a [Option<Loop>],
    pub bead: f64,
}

/// Spirals for all chains.
pub(super) fn connect(rings: &Rings, chains: &[Chain], watch: Watch) -> Result<Plan, PathError> {
    let taken = vec![Vec::new(); rings.sets.bands.len()];
    let mut weaver = SpiralConnector { rings, plan: Plan::new(rings.loops.len()), taken };
    // Children first: they have less choice.
    for chain in chains.iter().rev() {
        watch()?;
        weaver.join(&chain.rings, &chain.parents, chain);
    }
    Ok(weaver.plan)
}

/// A node of a line across the rings: a ring, and the place of the line on it.
#[derive(Clone, Copy)]
struct Node<'a> {
    on: &'a Loop,
    ring: u32,
    level: usize,
    place: f64,
    /// Half of its window, negative where directions are turned round.
    half: f64,
}

impl Node<'_> {
    fn at(&self, share: f64) -> f64 {
        self.place + share * self.half
    }

    fn side(&self, positive: bool) -> Side {
        if positive == (self.half > 0.0) { Side::To } else { Side::From }
    }

    /// From where to where a cut goes along the ring.
    fn cut(&self, shares: [f64; 2]) -> [f64; 2] {
        let [a, b] = shares.map(|share| self.at(share));
        [a.min(b), a.max(b)]
    }
}

/// From where to where a node is cut, in half windows from its place.
fn cut_shares(k: usize, last: usize, parented: bool) -> [f64; 2] {
    match k {
        _ if parented && last == 1 => [-1.0, 1.0],
        0 if parented => [-1.0, PARENT_BRIDGE],
        0 => [-1.0, 0.5],
        _ if k == last => [-0.5, 1.0],
        _ => [-1.0, 1.0],
    }
}

/// A bridge by stations: the number of its lower node, how far along the windows, and how far up to the next node.
type Stations = Vec<(usize, f64, f64)>;

struct SpiralConnector<'a> {
    rings: &'a Rings<'a>,
    plan: Plan,
    /// Points of bridges in each band.
    taken: Vec<Vec<Point3<f64>>>,
}

impl<'a> SpiralConnector<'a> {
    /// Joins rings of a chain to one of their parents, or makes a curve of its own of them if there is none. Where no
    /// line crosses all of them, the inner half is joined to the outer half at another place.
    fn join(&mut self, rings: &[u32], parents: &[(u32, ParentSide)], chain: &Chain) {
        let joined = match (parents, rings) {
            ([], [_]) => false,
            ([], _) => self.weave(rings, chain, None),
            _ => parents.iter().any(|&(parent, beside)| {
                let mut all = vec![parent];
                all.extend(rings);
                self.weave(&all, chain, Some(beside))
            }),
        };
        match rings {
            _ if joined => {}
            // Nothing hangs on it, and by itself it would be a blot: a single bead takes its place.
            [ring] if !parents.is_empty() && self.is_blot(*ring) => {}
            [ring] => self.open(*ring, chain),
            _ => {
                let (outer, inner) = rings.split_at(rings.len() / 2);
                let beside = if chain.rises { ParentSide::Above } else { ParentSide::Below };
                let last: Vec<(u32, ParentSide)> = outer.last().map(|&ring| (ring, beside)).into_iter().collect();
                self.join(inner, &last, chain);
                self.join(outer, parents, chain);
            }
        }
    }

    /// Whether a ring is short and still whole.
    fn is_blot(&self, ring: u32) -> bool {
        let length = self.rings.loops[ring as usize].as_ref().map_or(0.0, Loop::length);
        length < MIN_RING_LENGTH * self.rings.bead && self.plan.is_whole(ring)
    }

    /// A single ring, opened in the middle of its longest arc.
    fn open(&mut self, ring: u32, chain: &Chain) {
        let Some(on) = &self.rings.loops[ring as usize] else { return };
        let (from, length) = self.plan.longest_arc(on, ring);
        let (middle, half) = (from + length / 2.0, (self.rings.bead / 2.0).min(length * MAX_HALF_WINDOW_SHARE));
        let cut = self.plan.cut(ring, middle - half, middle + half);
        self.plan.start((cut, Side::To), chain.region);
    }

    /// Finds places for the windows of rings, the first of which is the parent if `beside` is given, and cuts and
    /// bridges them. Says whether that was possible.
    fn weave(&mut self, rings: &[u32], chain: &Chain, beside: Option<ParentSide>) -> bool {
        let lines = self.lines(rings, chain, beside);
        let windows = if beside.is_some() && rings.len() == 2 { &PAIR_HALF_WINDOWS[..] } else { &HALF_WINDOWS[..] };
        for &window in windows {
            let mut rated: Vec<(f64, Vec<Node>)> = lines
                .iter()
                .map(|places| self.nodes(rings, places, window, beside))
                .filter_map(|nodes| self.rate(&nodes).map(|rate| (rate, nodes)))
                .collect();
            rated.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, nodes) in rated.iter_mut().take(MAX_CHECKED_PLACES) {
                for _way_round in 0..2 {
                    let bridges = self.stations(nodes, beside.is_some());
                    if let Some(points) = self.lay(nodes, beside.is_some(), &bridges) {
                        self.commit(nodes, chain, beside.is_some(), points);
                        return true;
                    }
                    nodes.iter_mut().for_each(|node| node.half = -node.half);
                }
            }
        }
        false
    }

    /// Lines across all rings: a place on each.
    fn lines(&self, rings: &[u32], chain: &Chain, beside: Option<ParentSide>) -> Vec<Vec<f64>> {
        let loops: Option<Vec<&Loop>> = rings.iter().map(|&r| self.rings.loops[r as usize].as_ref()).collect();
        let Some(loops) = loops else { return Vec::new() };
        // Lines lead down, where they are sure to arrive.
        let first = match beside {
            _ if chain.rises => rings.len() - 1,
            Some(ParentSide::Across) => 1,
            _ => 0,
        };
        let length = loops[first].length();
        let count = ((2.0 * length / self.rings.bead).ceil() as usize).clamp(8, MAX_PLACES);
        let line = |k: usize| {
            let mut places = vec![0.0; rings.len()];
            places[first] = length * k as f64 / count as f64;
            for k in (0..first).rev() {
                places[k] = loops[k].nearest(loops[k + 1].position(places[k + 1])).0;
            }
            for k in first + 1..rings.len() {
                let (place, distance) = loops[k].nearest(loops[k - 1].position(places[k - 1]));
                // Past the end of what they have side by side.
                if distance > MAX_NODE_DISTANCE * self.rings.bead {
                    return None;
                }
                places[k] = place;
            }
            Some(places)
        };
        (0..count).filter_map(line).collect()
    }

    fn nodes(&self, rings: &[u32], places: &[f64], half: f64, beside: Option<ParentSide>) -> Vec<Node<'a>> {
        let pair = rings.len() == 2 && beside.is_some();
        let node = |(k, (&ring, &place)): (usize, (&u32, &f64))| {
            let on = self.rings.loops[ring as usize].as_ref()?;
            // The two bridges of a pair are beads of this width, side by side.
            let width = || self.rings.spacing.width(&on.at(self.rings.mesh, place)).0;
            let half = half * if pair { width() } else { self.rings.bead };
            let half = half.min(on.length() * MAX_HALF_WINDOW_SHARE);
            // Rings have what is higher on their left: across a ridge they run in opposite directions.
            let half = if k == 0 && beside == Some(ParentSide::Across) { -half } else { half };
            let level = self.rings.sets.rings[ring as usize].level;
            Some(Node { on, ring, level, place, half })
        };
        rings.iter().zip(places).enumerate().filter_map(node).collect()
    }

    /// How far matching places lie apart at most, in beads; none if too far, or where a ring is cut already.
    fn rate(&self, nodes: &[Node]) -> Option<f64> {
        let free = |node: &Node| {
            let margin = (0.5 * self.rings.bead).min(node.on.length() / 20.0);
            let [from, to] = node.cut([-1.0, 1.0]);
            self.plan.is_free(node.on, node.ring, from - margin, to + margin)
        };
        if !nodes.iter().all(free) {
            return None;
        }
        let mut rate: f64 = 0.0;
        for pair in nodes.windows(2) {
            // Across a ridge rings may be up to two beads apart.
            let scale = if self.across(pair) { 2.0 } else { 1.0 } * self.rings.bead;
            for share in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                let [one, other] = [0, 1].map(|k| pair[k].on.position(pair[k].at(share)));
                rate = rate.max((one - other).norm() / scale);
            }
        }
        (rate <= MAX_NODE_DISTANCE).then_some(rate)
    }

    fn across(&self, pair: &[Node]) -> bool {
        pair[0].level == pair[1].level
    }

    /// The bridges of a chain, in a fixed order: entry or exit, arms, the turn inside.
    fn stations(&self, nodes: &[Node], parented: bool) -> Vec<Stations> {
        let half = nodes.iter().map(|node| node.half.abs()).fold(0.0, f64::max);
        let steps = (POINTS_PER_BEAD * half.hypot(self.rings.bead) / self.rings.bead).ceil().max(4.0) as usize;
        let shares = || (0..=steps).map(|k| k as f64 / steps as f64);
        let falling = |k: usize| shares().map(move |t| (k, t - 1.0, t));
        let rising = |k: usize| shares().map(move |t| (k, t, t));
        let last = nodes.len() - 1;
        let mut bridges: Vec<Stations> = Vec::new();
        if parented && last == 1 {
            return vec![shares().map(|u| (0, 1.0, 1.0 - u)).collect(), shares().map(|t| (0, -1.0, t)).collect()];
        }
        match parented {
            // From the door half way along, then straight to the parent.
            true => {
                bridges.push(shares().map(|u| (0, PARENT_BRIDGE.max(1.0 - u), 1.0 - u)).collect());
            }
            false => bridges.push(rising(0).collect()),
        }
        bridges.extend((0..last - 1).map(|k| falling(k).chain(rising(k + 1)).collect()));
        bridges.push(shares().map(|t| (last - 1, (t - 1.0).min(-0.5), t)).collect());
        bridges
    }

    /// Points of bridges; none if one of them leaves its band or comes too near to another.
    fn lay(&self, nodes: &[Node], parented: bool, bridges: &[Stations]) -> Option<Vec<Vec<SurfacePoint>>> {
        let mut laid: Vec<Vec<SurfacePoint>> = Vec::with_capacity(bridges.len());
        let mut in_band: Vec<Vec<(usize, Point3<f64>)>> = vec![Vec::new(); nodes.len() - 1];
        for (number, stations) in bridges.iter().enumerate() {
            let mut points: Vec<SurfacePoint> = Vec::with_capacity(stations.len());
            for (n, &(k, share, t)) in stations.iter().enumerate() {
                let pair = &nodes[k..k + 2];
                let point = self.station(pair, share, t)?;
                if let (Some(&last), Some(&(before, _, s))) = (points.last(), n.checked_sub(1).map(|n| &stations[n]))
                    && before == k
                {
                    // Between stations too: rings may have corners.
                    for part in SUBSTEPS {
                        let wanted = last.position + (point.position - last.position) * part;
                        let between = locate(self.rings.mesh, last.triangle, wanted);
                        if !self.is_between(pair, &between, s + (t - s) * part, MIN_SUBSTEP_PROGRESS) {
                            return None;
                        }
                        in_band[k].push((number, wanted));
                        // Over a crest straight lines leave the surface.
                        if (between.position - wanted).norm() > BRIDGE_TOLERANCE * self.rings.bead {
                            points.push(between);
                        }
                    }
                }
                in_band[k].push((number, point.position));
                points.push(point);
            }
            if self.crosses(nodes, number, parented, &points) || self.meets_rings(nodes, number, parented, &points) {
                return None;
            }
            laid.push(points);
        }
        for (k, points) in in_band.iter().enumerate() {
            let half = nodes[k].half.abs().min(nodes[k + 1].half.abs());
            let clear = BRIDGE_CLEARANCE * half.min(self.rings.bead);
            let taken = self.band(&nodes[k..k + 2]).map_or(&[][..], |band| &self.taken[band]);
            for (n, (number, p)) in points.iter().enumerate() {
                let near = |q: &Point3<f64>| (p - q).norm() < clear;
                if points[..n].iter().any(|(other, q)| other != number && near(q)) || taken.iter().any(near) {
                    return None;
                }
            }
        }
        Some(laid)
    }

    /// Whether a bridge crosses itself or what is left of the rings that it joins: levels alone do not decide it, where a ring
    /// turns back on itself. Bridges have the numbers of [`Self::stations`].
    fn crosses(&self, nodes: &[Node], number: usize, parented: bool, points: &[SurfacePoint]) -> bool {
        let last = nodes.len() - 1;
        let (before, after) = match number {
            0 if parented && last == 1 => (Some((1, 1.0)), (0, 1.0)),
            1 if parented && last == 1 => (Some((0, -1.0)), (1, -1.0)),
            0 if parented => (Some((1, 1.0)), (0, PARENT_BRIDGE)),
            0 => (None, (1, 1.0)),
            _ if number == last => (Some((last - 1, -1.0)), (last, -0.5)),
            _ => (Some((number - 1, -1.0)), (number + 1, 1.0)),
        };
        let mut all: Vec<SurfacePoint> = before.map_or(Vec::new(), |(k, share)| self.arc(&nodes[k], share));
        all.reverse();
        all.extend(points);
        all.extend(self.arc(&nodes[after.0], after.1));
        crosses_itself(self.rings.mesh, &all, SAME * self.rings.bead)
    }

    /// Whether a bridge crosses what its own cuts leave of the rings around the bands that it passes. A ring may be as
    /// thin as a needle, and the bridge pass from one side of it to the other between two points.
    fn meets_rings(&self, nodes: &[Node], number: usize, parented: bool, points: &[SurfacePoint]) -> bool {
        let (mesh, last) = (self.rings.mesh, nodes.len() - 1);
        let first = number.saturating_sub(1).min(last - 1);
        let through = if number == 0 || number == last { first } else { (first + 1).min(last - 1) };
        let bands = (first..=through).filter_map(|k| self.band(&nodes[k..k + 2]));
        let mut around: Vec<u32> = Vec::new();
        for band in bands.map(|band| &self.rings.sets.bands[band]) {
            around.extend(band.below.iter().chain(&band.above));
        }
        around.sort_unstable();
        around.dedup();
        let same = |a: &SurfacePoint, b: &SurfacePoint| (a.position - b.position).norm() <= SAME * self.rings.bead;
        let is_end = |at: &SurfacePoint| same(at, &points[0]) || same(at, &points[points.len() - 1]);
        around.into_iter().any(|ring| {
            let Some(on) = &self.rings.loops[ring as usize] else { return false };
            let node = (0..=last).find(|&k| nodes[k].ring == ring);
            let cut = node.map_or([0.0; 2], |k| nodes[k].cut(cut_shares(k, last, parented)));
            points.windows(2).any(|pair| {
                let way = pair[1].position - pair[0].position;
                let left = on.left(mesh, cut, pair[0].position + 0.5 * way, 0.5 * way.norm());
                // What begins where the bridge ends is looked at by `crosses`.
                let apart = left.iter().filter(|[from, to]| !is_end(from) && !is_end(to));
                apart.into_iter().any(|[from, to]| cross(mesh, [&pair[0], &pair[1]], [from, to]))
            })
        })
    }

    /// A ring from one end of its window on, away from the window.
    fn arc(&self, node: &Node, share: f64) -> Vec<SurfacePoint> {
        let (on, mesh, place) = (node.on, self.rings.mesh, node.at(share));
        let reach = (RING_CHECK_LENGTH * self.rings.bead).min(0.25 * on.length());
        match node.side(share > 0.0) {
            Side::To => on.forward(mesh, place, place + reach),
            Side::From => {
                let mut points = on.forward(mesh, place - reach, place);
                points.reverse();
                points
            }
        }
    }

    /// The band between two nodes.
    fn band(&self, pair: &[Node]) -> Option<usize> {
        let [one, other] = [0, 1].map(|k| &self.rings.sets.rings[pair[k].ring as usize]);
        let bands = [one.above, one.below];
        bands.into_iter().find(|&band| band == other.above || band == other.below).map(|band| band as usize)
    }

    fn station(&self, pair: &[Node], share: f64, t: f64) -> Option<SurfacePoint> {
        let mesh = self.rings.mesh;
        let places = [0, 1].map(|k| pair[k].at(share));
        if t <= 0.0 || t >= 1.0 {
            let k = usize::from(t >= 1.0);
            return Some(pair[k].on.at(mesh, places[k]));
        }
        let [from, to] = [0, 1].map(|k| pair[k].on.position(places[k]));
        let wanted = from + (to - from) * t;
        let near = usize::from(t > 0.5);
        let point = locate(mesh, pair[near].on.triangle(places[near]), wanted);
        if (point.position - wanted).norm() > MAX_BRIDGE_DEVIATION * self.rings.bead {
            return None;
        }
        self.is_between(pair, &point, t, MIN_PROGRESS).then_some(point)
    }

    /// Whether a point lies between two rings, as far on the way as a share of what it should.
    fn is_between(&self, pair: &[Node], point: &SurfacePoint, t: f64, share: f64) -> bool {
        let way = share * t.min(1.0 - t);
        match self.across(pair) {
            // A tip of the next ring may reach in between.
            true => {
                let [above, below] = self.rings.spacing.above(point, [pair[0].level, pair[0].level + 1]);
                above > way * self.rings.bead && below < 0.0
            }
            false => {
                let [low, high] = [pair[0].level.min(pair[1].level), pair[0].level.max(pair[1].level)];
                let [above, below] = self.rings.spacing.above(point, [low, high]);
                above.min(-below) > way * (above - below)
            }
        }
    }

    fn commit(&mut self, nodes: &[Node], chain: &Chain, parented: bool, mut laid: Vec<Vec<SurfacePoint>>) {
        let mesh = self.rings.mesh;
        let last = nodes.len() - 1;
        for (k, pair) in nodes.windows(2).enumerate() {
            let Some(band) = self.band(pair) else { continue };
            // All bridges that pass between these two: those that start one or two nodes before.
            let bridges = laid.iter().enumerate().filter(|(n, _)| {
                let first = n.saturating_sub(1).min(last - 1);
                (first..=first + 1).contains(&k)
            });
            for (_, points) in bridges {
                self.taken[band].extend(points.iter().map(|p| p.position));
                let between = |pair: &[SurfacePoint]| {
                    let [from, to] = [pair[0].position, pair[1].position];
                    SUBSTEPS.map(|part| from + (to - from) * part)
                };
                self.taken[band].extend(points.windows(2).flat_map(between));
            }
        }
        let mut cuts: Vec<usize> = Vec::with_capacity(nodes.len());
        for (k, node) in nodes.iter().enumerate() {
            let [from, to] = node.cut(cut_shares(k, last, parented));
            cuts.push(self.plan.cut(node.ring, from, to));
        }
        let left = |k: usize| -> Option<End> { Some((cuts[k], nodes[k].side(false))) };
        let right = |k: usize| -> Option<End> { Some((cuts[k], nodes[k].side(true))) };
        let inside = laid.pop().unwrap_or_default();
        let mut laid = laid.into_iter();
        let outside = laid.next().unwrap_or_default();
        if parented {
            self.plan.bridge(outside, [right(1), right(0)]);
        } else {
            // The exit goes on along the door for a little, as the first arm leaves it.
            let steps = POINTS_PER_BEAD as usize;
            let along = (1..=steps).rev().map(|k| nodes[0].at(-0.5 * k as f64 / steps as f64));
            let mut points: Vec<SurfacePoint> = along.map(|place| nodes[0].on.at(mesh, place)).collect();
            points.extend(outside);
            self.plan.bridge(points, [None, right(1)]);
            self.plan.start((cuts[0], nodes[0].side(true)), chain.region);
        }
        for (k, points) in laid.enumerate() {
            self.plan.bridge(points, [left(k), right(k + 2)]);
        }
        self.plan.bridge(inside, [left(last - 1), left(last)]);
    }
}
