//! The wave front: windows cross triangles, vertices with a shadow behind them send out point waves.
//!
//! A window that crosses a triangle lights an interval of one or both of the other edges. Behind a vertex with more than
//! a full turn around it (a saddle), or more than half a turn at the boundary, straight lines leave a gap: the vertex
//! sends a point wave into it. Strips start from source edges. Where the surface turns by more than half a turn from
//! one source edge to the next, as at a reflex corner, the vertex between them fills the gap; at convex ones strips
//! overlap.
//!
//! A half-edge waits for the distance of its middle. In that order nearly all windows of an edge are there when it is
//! visited, so that they cross its triangle together, side by side, and are in order on both other sides: each is
//! trimmed against the last one there, not looked up among all.

use super::envelope::{Envelope, Trim, Window};
use super::queue::BucketQueue;
use super::unfold::{Frame, Unfolding};
use super::wave::Wave;
use crate::mesh::{NONE, SurfaceMesh, next, previous};
use crate::{Progress, ProgressFn};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A gap between straight lines narrower than this (radians) is rounding of the angles around a vertex. Points in such
/// a gap get the distance along a path that bends by as much, which is longer by a share of the square of it.
const MIN_GAP: f64 = 1e-12;
/// A vertex as near to the outermost ray of a window, as a sine, counts as seen, over the nearest end of the window.
/// The distance is that of a path that exists, so a larger value costs time, not truth; below 1e-9 a vertex could fall
/// between two windows.
const SEEN: f64 = 1e-6;
/// Width of a bucket of the queue, in mean edge lengths. Wider: half-edges are visited before all of their windows are
/// there, and then again (a fifth slower at 0.5); narrower: no fewer visits, more buckets.
const BUCKET: f64 = 0.0625;
/// Queue items from here on are vertices; below they are half-edges.
const VERTEX: u32 = 1 << 31;
/// Items of the queue between two reports of progress.
const REPORT: u32 = 1 << 12;

/// The state of a propagation.
pub(super) struct WaveFront<'m> {
    mesh: &'m SurfaceMesh,
    unfolding: &'m Unfolding,
    envelope: Envelope,
    queue: BucketQueue,
    distances: Vec<f64>,
    /// For vertices that cast a shadow, where the distance came from.
    arrivals: Vec<Arrival>,
    /// The distance with which a vertex last sent out a wave.
    sent: Vec<f64>,
    is_source: Vec<bool>,
    /// The key with which each half-edge waits in the queue.
    queued: Vec<f64>,
    /// What was lit last on the two sides of a triangle, in order, and is not yet in the envelope.
    lit: [Vec<Window>; 2],
    trim: Trim,
    slack: f64,
    reached: u64,
}

/// How a way comes in to a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Arrival {
    /// The angle of the fan.
    angle: f64,
    /// How far that may be off, since the way bends a little: the straight one to the same vertex comes in between.
    off: f64,
}

/// What a propagation leaves behind.
pub(super) struct Settled {
    pub distances: Vec<f64>,
    pub envelope: Envelope,
    /// For each half-edge, whether it is a source.
    pub is_source: Vec<bool>,
}

impl<'m> WaveFront<'m> {
    /// * `source_edges`: half-edges; both sides of each are sources.
    /// * `source_vertices`: further vertices.
    /// * `slack`: differences of distances up to it do not count.
    pub fn new(
        mesh: &'m SurfaceMesh,
        unfolding: &'m Unfolding,
        source_edges: &[u32],
        source_vertices: &[u32],
        slack: f64,
    ) -> Self {
        let vertices = mesh.vertices().len();
        let mut front = WaveFront {
            mesh,
            unfolding,
            envelope: Envelope::new(mesh.half_edges()),
            // No path is longer than all edges together.
            queue: BucketQueue::new(BUCKET * unfolding.mean_length(), (mesh.half_edges() as f64 / BUCKET) as usize),
            distances: vec![f64::INFINITY; vertices],
            arrivals: vec![Arrival::default(); vertices],
            sent: vec![f64::INFINITY; vertices],
            is_source: vec![false; mesh.half_edges() as usize],
            queued: vec![f64::INFINITY; mesh.half_edges() as usize],
            lit: [Vec::new(), Vec::new()],
            trim: Trim::new(slack),
            slack,
            reached: 0,
        };
        for &h in source_edges {
            for half_edge in [Some(h), mesh.twin(h)].into_iter().flatten() {
                front.is_source[half_edge as usize] = true;
            }
        }
        let mut starts: Vec<u32> = source_edges.iter().flat_map(|&h| [mesh.tail(h), mesh.head(h)]).collect();
        starts.extend(source_vertices);
        for &vertex in &starts {
            front.distances[vertex as usize] = 0.0;
        }
        // Strips first, then the vertices between them, which fill the gaps that strips leave.
        for half_edge in 0..mesh.half_edges() {
            if front.is_source[half_edge as usize] {
                let wave = Wave::Strip { along: 0.0, across: 1.0, base: 0.0 };
                let crossing = Crossing::new(unfolding, half_edge);
                front.cross(&crossing, [0.0, crossing.length], wave);
                front.keep(&crossing);
            }
        }
        for vertex in starts {
            if front.sent[vertex as usize] > 0.0 {
                front.sent[vertex as usize] = 0.0;
                front.reached += 1;
                front.send_from_source(vertex);
            }
        }
        front
    }

    /// Propagates until nothing moves; `None` when the callback stops it.
    pub fn settle(mut self, progress: ProgressFn) -> Option<Settled> {
        let total = self.mesh.vertices().len() as u64;
        let mut until_report = 0;
        while let Some(item) = self.queue.pop() {
            if until_report == 0 {
                until_report = REPORT;
                let progress = progress(Progress { stage: "geodesics", done: self.reached, total });
                if progress.is_break() {
                    return None;
                }
            }
            until_report -= 1;
            if item >= VERTEX {
                self.send_into_shadow(item - VERTEX);
            } else {
                self.propagate(item);
            }
        }
        Some(Settled { distances: self.distances, envelope: self.envelope, is_source: self.is_source })
    }

    /// Propagates all windows that wait to enter a half-edge.
    fn propagate(&mut self, half_edge: u32) {
        if self.queued[half_edge as usize].is_infinite() {
            return; // it waited twice
        }
        self.queued[half_edge as usize] = f64::INFINITY;
        let edge = self.mesh.edge(half_edge);
        let crossing = Crossing::new(self.unfolding, half_edge);
        let length = crossing.length;
        // What they light lies on the other edges of the triangle, so the list can be taken out meanwhile.
        let mut windows = self.envelope.take(edge);
        // From the head back to the tail: so what they light on both other sides is in order.
        if edge == half_edge {
            for window in windows.iter_mut().rev().filter(|w| w.waiting && w.enters == half_edge) {
                window.waiting = false;
                self.cross(&crossing, window.span, window.wave());
            }
        } else {
            for window in windows.iter_mut().filter(|w| w.waiting && w.enters == half_edge) {
                window.waiting = false;
                let reversed = window.reversed(length);
                self.cross(&crossing, reversed.span, reversed.wave());
            }
        }
        self.envelope.put_back(edge, windows);
        self.keep(&crossing);
    }

    /// Sends a wave through the interval of a half-edge into its triangle; all in the frame of the half-edge.
    fn cross(&mut self, crossing: &Crossing, [from, to]: [f64; 2], wave: Wave) {
        let [px, py] = crossing.apex;
        let (first, last) = (wave.direction(from), wave.direction(to));
        // Positive where the apex lies to the left of the ray.
        let past_first = first[0] * py - first[1] * (px - from);
        let past_last = last[0] * py - last[1] * (px - to);
        self.see_apex(crossing, [from, to], &wave, [past_first, past_last]);
        if past_first > 0.0 || past_last >= 0.0 {
            let Side { length, u, .. } = crossing.right;
            let hit = |t: f64, ray: [f64; 2]| {
                let rest = crossing.length - t;
                if rest <= 0.0 { 0.0 } else { (ray[1] * rest / (u[1] * ray[0] - u[0] * ray[1])).clamp(0.0, length) }
            };
            let end = if past_first > 0.0 { hit(from, first) } else { length };
            self.light(0, crossing.right, [hit(to, last), end], wave.seen_from([crossing.length, 0.0], u));
        }
        if past_last < 0.0 || past_first <= 0.0 {
            let Side { length, u, .. } = crossing.left;
            let hit = |t: f64, ray: [f64; 2]| {
                if t <= 0.0 {
                    length
                } else {
                    (length - ray[1] * t / (u[1] * ray[0] - u[0] * ray[1])).clamp(0.0, length)
                }
            };
            let start = if past_last < 0.0 { hit(to, last) } else { 0.0 };
            self.light(1, crossing.left, [start, hit(from, first)], wave.seen_from([px, py], u));
        }
    }

    /// Gives the apex of a triangle the distance over a window of the edge below it, if it lies between the outermost
    /// rays or almost.
    fn see_apex(&mut self, crossing: &Crossing, [from, to]: [f64; 2], wave: &Wave, [past_first, past_last]: [f64; 2]) {
        let apex = crossing.apex;
        let (distance, bend, off) = if past_first <= 0.0 && past_last >= 0.0 {
            (wave.beyond(apex), wave.crossing(apex).clamp(from, to), 0.0)
        } else {
            let (past, end) = if past_first > 0.0 { (past_first, from) } else { (past_last, to) };
            let (ray, up) = (wave.direction(end), [apex[0] - end, apex[1]]);
            let squares = (ray[0] * ray[0] + ray[1] * ray[1]) * (up[0] * up[0] + up[1] * up[1]);
            if past * past > SEEN * SEEN * squares {
                return;
            }
            (wave.at(end) + up[0].hypot(up[1]), end, past.abs() / squares.sqrt())
        };
        let vertex = self.mesh.tail(crossing.left.half_edge);
        // Any path that exists bounds the distance from above: only shorter ones count, so it never rises.
        if !self.improves(vertex, distance) {
            return;
        }
        // Back to the source, counterclockwise from the half-edge that leaves the apex in this triangle.
        let back = apex[0].atan2(apex[1]) - (apex[0] - bend).atan2(apex[1]);
        self.arrive(vertex, distance, crossing.left.half_edge, [back, off]);
    }

    fn improves(&self, vertex: u32, distance: f64) -> bool {
        distance < self.distances[vertex as usize] - self.slack
    }

    /// Notes a shorter way to a vertex, which came in from an angle to the left of a half-edge out of it, and may be off by
    /// another.
    fn arrive(&mut self, vertex: u32, distance: f64, out: u32, [angle, off]: [f64; 2]) {
        let old = std::mem::replace(&mut self.distances[vertex as usize], distance);
        self.reached += u64::from(old.is_infinite());
        if self.casts_shadow(vertex) {
            let before: f64 = self.mesh.fan(vertex).take_while(|&h| h != out).map(|h| self.unfolding.angle(h)).sum();
            self.arrivals[vertex as usize] = Arrival { angle: before + angle, off };
            // It waits its turn: a shorter way may come before, and then this item is stale.
            self.queue.push(distance, VERTEX | vertex);
        }
    }

    fn casts_shadow(&self, vertex: u32) -> bool {
        let straight = if self.mesh.is_boundary_vertex(vertex) { PI } else { TAU };
        self.unfolding.total(vertex) > straight + MIN_GAP
    }

    /// A vertex sends a wave where no straight line over it arrives.
    fn send_into_shadow(&mut self, vertex: u32) {
        let (distance, Arrival { angle, off }) = (self.distances[vertex as usize], self.arrivals[vertex as usize]);
        // A stale item: its wave is out, or a shorter one will come.
        if distance >= self.sent[vertex as usize] {
            return;
        }
        self.sent[vertex as usize] = distance;
        let total = self.unfolding.total(vertex);
        // As far as straight lines may arrive, and no gap between: what overlaps is trimmed.
        let [left, right] = [angle + PI - off, angle - PI + off];
        if self.mesh.is_boundary_vertex(vertex) {
            self.send(vertex, [0.0, right], distance);
            self.send(vertex, [left, total], distance);
        } else {
            self.send_around(vertex, [left, right + total], distance);
        }
    }

    /// A source vertex sends a wave where no strip of a source edge next to it arrives.
    fn send_from_source(&mut self, vertex: u32) {
        let total = self.unfolding.total(vertex);
        let mut edges = Vec::new();
        let mut angle = 0.0;
        for h in self.mesh.fan(vertex) {
            if self.is_source[h as usize] {
                edges.push(angle);
            }
            angle += self.unfolding.angle(h);
            // The last edge of a fan at the boundary has no half-edge out.
            if self.mesh.turn_left(h).is_none() && self.is_source[previous(h) as usize] {
                edges.push(total);
            }
        }
        let (Some(&first), Some(&last)) = (edges.first(), edges.last()) else {
            self.send(vertex, [0.0, total], 0.0);
            return;
        };
        for pair in edges.windows(2) {
            self.send(vertex, [pair[0] + FRAC_PI_2, pair[1] - FRAC_PI_2], 0.0);
        }
        if self.mesh.is_boundary_vertex(vertex) {
            self.send(vertex, [0.0, first - FRAC_PI_2], 0.0);
            self.send(vertex, [last + FRAC_PI_2, total], 0.0);
        } else {
            self.send_around(vertex, [last + FRAC_PI_2, first + total - FRAC_PI_2], 0.0);
        }
    }

    /// As [`Self::send`] for an inner vertex, whose angles go on past a full turn.
    fn send_around(&mut self, vertex: u32, [from, to]: [f64; 2], base: f64) {
        let total = self.unfolding.total(vertex);
        if to - from > MIN_GAP {
            self.send(vertex, [from, to], base);
            self.send(vertex, [from - total, to - total], base);
        }
    }

    /// Sends a point wave into an angle of the fan of a vertex.
    fn send(&mut self, vertex: u32, [from, to]: [f64; 2], base: f64) {
        let mesh = self.mesh;
        if to - from <= MIN_GAP {
            return;
        }
        let mut angle = 0.0;
        for h in mesh.fan(vertex) {
            let start = angle;
            angle += self.unfolding.angle(h);
            let range = [from.max(start), to.min(angle)];
            if range[0] > range[1] + MIN_GAP {
                continue;
            }
            let across = next(h);
            // Along the edges that lie in the angle.
            let edges = [(start, h, mesh.head(h)), (angle, previous(h), mesh.tail(previous(h)))];
            for (at, edge, other) in edges {
                let distance = base + self.unfolding.frame(edge).length;
                let off = (from - at).max(at - to).max(0.0);
                if off <= SEEN && self.improves(other, distance) {
                    let (out, back) = match edge == h {
                        true => (across, self.unfolding.angle(across)),
                        false => (edge, 0.0),
                    };
                    self.arrive(other, distance, out, [back, off]);
                }
            }
            let frame = self.unfolding.frame(across);
            let length = self.unfolding.frame(h).length;
            let hit = |turned: f64| {
                let far = turned + self.unfolding.angle(across);
                (length * turned.sin() / far.sin()).clamp(0.0, frame.length)
            };
            let start_hit = if range[0] <= start { 0.0 } else { hit(range[0] - start) };
            let end_hit = if range[1] >= angle { frame.length } else { hit(range[1] - start) };
            let wave = Wave::Point { x: frame.apex[0], depth: frame.apex[1], base };
            let side = Side { half_edge: across, length: frame.length, u: [1.0, 0.0] };
            self.light(0, side, [start_hit, end_hit], wave);
            self.keep_side(0, side);
        }
    }

    /// A wave reaches an interval of a side from its triangle.
    fn light(&mut self, k: usize, Side { half_edge, length, .. }: Side, [from, to]: [f64; 2], wave: Wave) {
        let wide = from < to; // false for NaN
        if !wide || self.is_source[half_edge as usize] {
            return;
        }
        // A path over an end of the edge is no longer than the one over the far end of the interval: nothing is gained
        // (Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", ACM TOG 28(4), 2009).
        let over_tail = self.distances[self.mesh.tail(half_edge) as usize] + to;
        let over_head = self.distances[self.mesh.head(half_edge) as usize] + (length - from);
        if wave.is_later(to, over_tail) || wave.is_later(from, over_head) {
            return;
        }
        let enters = self.mesh.twin(half_edge).unwrap_or(NONE);
        self.trim.append(&mut self.lit[k], length, Window::new([from, to], wave, enters));
    }

    /// Puts what was lit on both sides of a triangle into the envelope.
    fn keep(&mut self, crossing: &Crossing) {
        self.keep_side(0, crossing.right);
        self.keep_side(1, crossing.left);
    }

    fn keep_side(&mut self, k: usize, Side { half_edge, length, .. }: Side) {
        let lit = &mut self.lit[k];
        let Some(&middle) = lit.get(lit.len() / 2) else { return };
        let edge = self.mesh.edge(half_edge);
        if edge != half_edge {
            // The envelope keeps windows along the lower half-edge.
            lit.reverse();
            lit.iter_mut().for_each(|window| *window = window.reversed(length));
        }
        let gained = self.envelope.add(edge, length, lit, &mut self.trim);
        lit.clear();
        let enters = middle.enters;
        if !gained || enters == NONE {
            return;
        }
        // The window in the middle stands for all that were lit together.
        let key = middle.wave().at(0.5 * length);
        let queued = &mut self.queued[enters as usize];
        // Within a bucket it would not come sooner: one entry less.
        if key < *queued - self.queue.width() {
            *queued = key;
            self.queue.push(key, enters);
        }
    }
}

/// A triangle that is being crossed from one half-edge, in its frame.
struct Crossing {
    length: f64,
    apex: [f64; 2],
    /// From the head of the half-edge up to the apex.
    right: Side,
    /// From the apex down to the tail.
    left: Side,
}

/// Another side of the triangle, with its unit direction.
#[derive(Clone, Copy)]
struct Side {
    half_edge: u32,
    length: f64,
    u: [f64; 2],
}

impl Crossing {
    fn new(unfolding: &Unfolding, half_edge: u32) -> Self {
        let Frame { length, apex: [px, py] } = unfolding.frame(half_edge);
        let side = |half_edge: u32, [x, y]: [f64; 2]| {
            let length = unfolding.frame(half_edge).length;
            Side { half_edge, length, u: [x / length, y / length] }
        };
        let right = side(next(half_edge), [px - length, py]);
        Crossing { length, apex: [px, py], right, left: side(previous(half_edge), [-px, -py]) }
    }
}
