//! One triangle of the sheet, cut along segments: a triangulation on an integer grid.
//!
//! The triangle is the one with corners `(0, 0)`, `(SIDE, 0)` and `(0, SIDE)`, so points on its three sides are exact,
//! and all signs are exact in `i128`. Points are inserted first, then segments by flips (S. W. Sloan, "A fast algorithm
//! for generating constrained Delaunay triangulations", Computers & Structures 47(3), 1993). Where segments cross,
//! which they do only for a mesh that passes through itself, the crossing is rounded to the grid and becomes a point;
//! and a segment that comes nearer than [`NEAR`] to a point goes through it. So segments that lie on one another, as
//! those of touching boxes do, become the same edges.
//!
//! A segment says by how much the winding number is greater to its left (`rise`). Whatever is done to a segment, its
//! ends stay, so rises around a point always add up to what they did before, and the number of each triangle follows
//! from its neighbour's.
//!
//! Half-edge `3 t + k` goes from corner `k` of triangle `t` to the next, with the triangle to its left.

/// Length of the two short sides, in grid units: with 2^40 the cross product of differences takes 84 bits, that times a
/// difference 125, and a unit of a triangle of 1 mm is 1e-12 mm, at the rounding of coordinates of a part.
pub(super) const SIDE: i64 = 1 << 40;

/// Points nearer than this are one, in grid units: 1e-9 of the sheet triangle. Less lets rounding (some units) through,
/// more moves the boundary.
pub(super) const NEAR: i64 = 1 << 10;

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

type Grid = [i64; 2];

#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    pub(super) points: Vec<Grid>,
    /// Where each half-edge starts.
    pub(super) from: Vec<u32>,
    /// The half-edge back, or [`NONE`] on the border.
    pub(super) twin: Vec<u32>,
    /// The winding number to the left of a half-edge less that to its right.
    pub(super) rise: Vec<i32>,
    /// A half-edge that starts at each point.
    leave: Vec<u32>,
    waiting: Vec<Segment>,
    crossed: Vec<[u32; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    ends: [u32; 2],
    rise: i32,
}

/// Segments that could not be brought to rest: they crossed each other again and again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangled;

/// What is in the way of a segment.
enum Obstacle {
    /// It is an edge already: this half-edge, and whether that runs as the segment does (1) or back (-1).
    None(u32, i32),
    /// A point that it has to go through.
    Point(u32),
    /// Another segment, this half-edge.
    Segment(u32),
    /// Edges that may be flipped, now in `Patch::crossed`.
    Edges,
}

impl Patch {
    /// The triangle alone.
    pub(super) fn reset(&mut self) {
        self.points.clear();
        self.points.extend([[0, 0], [SIDE, 0], [0, SIDE]]);
        self.leave.clear();
        self.leave.extend([0, 1, 2]);
        for list in [&mut self.from, &mut self.twin] {
            list.clear();
        }
        self.rise.clear();
        self.put(0, [0, 1, 2], [(NONE, 0); 3]);
    }

    /// A place on side `k`, the given distance after corner `k`.
    pub(super) fn on_side(k: usize, along: i64) -> Grid {
        [[along, 0], [SIDE - along, along], [0, SIDE - along]][k]
    }

    /// Which side a half-edge of the border lies on.
    pub(super) fn side(&self, half: u32) -> usize {
        let [p, q] = [self.from[half as usize], self.to(half)].map(|point| self.points[point as usize]);
        match [p[1] == 0 && q[1] == 0, p[0] == 0 && q[0] == 0] {
            [true, _] => 0,
            [_, true] => 2,
            _ => 1,
        }
    }

    /// Puts a point on side `k`; none is there yet.
    pub(super) fn insert_on_side(&mut self, k: usize, along: i64) -> u32 {
        let at = Self::on_side(k, along);
        self.insert(at)
    }

    /// The point at a place inside, which may be one that is there.
    pub(super) fn insert_inside(&mut self, at: Grid) -> u32 {
        let at = strictly_inside(at);
        let near = |p: &Grid| (p[0] - at[0]).abs() <= NEAR && (p[1] - at[1]).abs() <= NEAR;
        match self.points.iter().position(near) {
            Some(known) => known as u32,
            None => self.insert(at),
        }
    }

    fn insert(&mut self, at: Grid) -> u32 {
        let point = self.points.len() as u32;
        self.points.push(at);
        self.leave.push(NONE);
        let t = self.triangle_at(at);
        match [0, 1, 2].iter().position(|&k| self.turn(3 * t + k, at) == 0) {
            None => self.split_triangle(t, point),
            Some(k) => self.split_edge(3 * t + k as u32, point),
        }
        point
    }

    /// A triangle that a place lies in: a walk from the one at the last point that has triangles, since points come in the order of
    /// chains. Where triangles are slim a walk may go in circles; then all are looked at.
    fn triangle_at(&self, at: Grid) -> u32 {
        let count = self.from.len() as u32 / 3;
        let start = self.leave.iter().rev().find(|&&half| half != NONE).map_or(0, |half| half / 3);
        let mut t = start;
        for _ in 0..count {
            let Some(k) = [0, 1, 2].into_iter().find(|&k| self.turn(3 * t + k, at) < 0) else { return t };
            match self.twin[3 * t as usize + k as usize] {
                NONE => break,
                back => t = back / 3,
            }
        }
        let holds = |t: &u32| [0, 1, 2].iter().all(|&k| self.turn(3 * t + k, at) >= 0);
        (0..count).find(holds).unwrap_or_else(|| unreachable!("the triangles cover the patch"))
    }

    /// Lays a segment between two points; `rise` is how much greater the winding number is to its left. A crossing with
    /// another segment makes a point, of which `cross` gets the ends of a segment that it lies on and the share
    /// of the way.
    pub(super) fn connect(
        &mut self,
        ends: [u32; 2],
        rise: i32,
        mut cross: impl FnMut([u32; 2], f64),
    ) -> Result<(), Tangled> {
        // On the grid crossings are rounded, and may make new ones; few do.
        let mut budget = PATIENCE * (self.points.len() + PATIENCE);
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.clear();
        waiting.push(Segment { ends, rise });
        while let Some(Segment { ends: [a, b], rise }) = waiting.pop() {
            if a == b || rise == 0 {
                continue;
            }
            budget = budget.checked_sub(1).ok_or(Tangled)?;
            let mut detour = |[a, b]: [u32; 2], rise, over: u32| {
                waiting.extend([Segment { ends: [a, over], rise }, Segment { ends: [over, b], rise }]);
            };
            // Points in the way come first, then segments, then edges: what is cut into parts ends at points that are there.
            match self.obstacle(a, b) {
                Obstacle::None(half, sense) => self.raise(half, sense * rise),
                Obstacle::Point(point) => detour([a, b], rise, point),
                Obstacle::Segment(half) => {
                    let (other, other_rise) = (self.ends(half), self.rise[half as usize]);
                    // The other segment is taken up and laid again in two parts through the crossing.
                    self.raise(half, -other_rise);
                    let (at, share) = self.crossing([a, b], other);
                    let before = self.points.len();
                    let point = self.insert_inside(at);
                    if self.points.len() > before {
                        cross([a, b], share);
                    }
                    detour(other, other_rise, point);
                    detour([a, b], rise, point);
                }
                Obstacle::Edges => {
                    self.flip_away(a, b)?;
                    let (half, sense) = self.edge(a, b).ok_or(Tangled)?;
                    self.raise(half, sense * rise);
                }
            }
        }
        self.waiting = waiting;
        Ok(())
    }

    fn obstacle(&mut self, a: u32, b: u32) -> Obstacle {
        // Few points lie in the box of a segment.
        let [low, high] = self.around([a, b]);
        let in_box = |point: u32| {
            let at = self.points[point as usize];
            at[0] >= low[0] && at[0] <= high[0] && at[1] >= low[1] && at[1] <= high[1]
        };
        let passes_near = |&point: &u32| in_box(point) && point != a && point != b && self.lies_near([a, b], point);
        if let Some(point) = (0..self.points.len() as u32).find(passes_near) {
            return Obstacle::Point(point);
        }
        if let Some((half, sense)) = self.edge(a, b) {
            return Obstacle::None(half, sense);
        }
        // The triangle at `a` that the segment leaves through the far side.
        let to = self.points[b as usize];
        let leaving = |half: u32| {
            let between = self.turn(half, to) > 0 && self.turn(previous(half), to) > 0;
            (between && self.turn(next(half), to) <= 0).then_some(next(half))
        };
        let first = self.find_around(a, leaving);
        self.crossed.clear();
        let mut at = first.unwrap_or_else(|| unreachable!("the segment leaves its start through a triangle"));
        loop {
            if self.rise[at as usize] != 0 {
                return Obstacle::Segment(at);
            }
            self.crossed.push(self.ends(at));
            let back = self.twin[at as usize];
            let apex = self.from[previous(back) as usize];
            if apex == b {
                return Obstacle::Edges;
            }
            // The half-edge ahead has one end to the right, where it starts, and one to the left.
            let left = self.orient(a, b, apex) > 0;
            at = if left { next(back) } else { previous(back) };
        }
    }

    /// The box of a segment, and what is near.
    fn around(&self, ends: [u32; 2]) -> [Grid; 2] {
        let [a, b] = ends.map(|point| self.points[point as usize]);
        // One more than [`NEAR`], which distances are rounded to.
        let room = NEAR + 1;
        [[0, 1].map(|k| a[k].min(b[k]) - room), [0, 1].map(|k| a[k].max(b[k]) + room)]
    }

    /// Whether a segment has to go through a point: it does so exactly, or comes too near far from its ends.
    fn lies_near(&self, [a, b]: [u32; 2], point: u32) -> bool {
        let [a, b, p] = [a, b, point].map(|point| self.points[point as usize]);
        let [way, to] = [b, p].map(|at| [(at[0] - a[0]) as f64, (at[1] - a[1]) as f64]);
        let length = way[0].hypot(way[1]);
        let along = (way[0] * to[0] + way[1] * to[1]) / length;
        let aside = (way[0] * to[1] - way[1] * to[0]).abs() / length;
        let near = NEAR as f64;
        if aside > near || along < -near || along > length + near {
            return false;
        }
        (along > 2.0 * near && along < length - 2.0 * near) || {
            let between = |k: usize| p[k] >= a[k].min(b[k]) && p[k] <= a[k].max(b[k]);
            orient(a, b, p) == 0 && between(0) && between(1)
        }
    }

    /// Where two segments cross, rounded to the grid, and the share of the way along the first.
    fn crossing(&self, first: [u32; 2], second: [u32; 2]) -> (Grid, f64) {
        let [a, b] = first.map(|point| self.points[point as usize]);
        let [u, v] = second.map(|point| self.points[point as usize]);
        let (part, whole) = (cross(a, u, u, v), cross(a, b, u, v));
        let along = |k: usize| a[k] + divide(i128::from(b[k] - a[k]) * part, whole) as i64;
        ([along(0), along(1)], part as f64 / whole as f64)
    }

    /// Flips edges that a segment crosses until it is an edge itself.
    fn flip_away(&mut self, a: u32, b: u32) -> Result<(), Tangled> {
        let mut crossed = std::mem::take(&mut self.crossed);
        let mut budget = PATIENCE * (crossed.len() + PATIENCE) * (crossed.len() + 1);
        let mut at = 0;
        while at < crossed.len() {
            budget = budget.checked_sub(1).ok_or(Tangled)?;
            let [p, q] = crossed[at];
            at += 1;
            let (half, _) = self.edge(p, q).ok_or(Tangled)?;
            let (c, d) = self.apexes(half);
            // The four corners are not convex: flips elsewhere will change that.
            if self.orient(c, d, p) * self.orient(c, d, q) >= 0 {
                crossed.push([p, q]);
                continue;
            }
            self.flip(half);
            let ends_there = [c, d].iter().any(|end| *end == a || *end == b);
            // The new edge may cross the segment as well.
            if !ends_there && self.orient(a, b, c) * self.orient(a, b, d) < 0 {
                crossed.push([c, d]);
            }
        }
        self.crossed = crossed;
        Ok(())
    }

    /// Flips edges that are no segments as long as the two angles facing one add up to more than a straight one, in
    /// the metric of the triangle: squared lengths of its sides from corner 0, and their product.
    pub(super) fn relax(&mut self, [uu, uv, vv]: [f64; 3]) {
        // Rounding could flip for ever between equals; and no more than this is ever needed.
        let mut budget = self.points.len() * self.points.len();
        let mut changed = true;
        while std::mem::take(&mut changed) && budget > 0 {
            for half in 0..self.from.len() as u32 {
                if self.twin[half as usize] < half || self.twin[half as usize] == NONE || self.rise[half as usize] != 0
                {
                    continue;
                }
                let [p, q] = self.ends(half);
                let (c, d) = self.apexes(half);
                let angle = |at: u32, p: u32, q: u32| {
                    let [at, p, q] = [at, p, q].map(|point| self.points[point as usize]);
                    let [[a, b], [c, d]] = [p, q].map(|p| [(p[0] - at[0]) as f64, (p[1] - at[1]) as f64]);
                    let cosine = a * c * uu + (a * d + b * c) * uv + b * d * vv;
                    let sine = (a * d - b * c) * (uu * vv - uv * uv).max(0.0).sqrt();
                    (sine, cosine)
                };
                let ((sine_c, cosine_c), (sine_d, cosine_d)) = (angle(c, p, q), angle(d, q, p));
                let sum = sine_c * cosine_d + cosine_c * sine_d;
                let scale = sine_c.hypot(cosine_c) * sine_d.hypot(cosine_d);
                if sum < -1e-9 * scale && self.orient(c, d, p) * self.orient(c, d, q) < 0 && budget > 0 {
                    self.flip(half);
                    (changed, budget) = (true, budget - 1);
                }
            }
        }
    }

    pub(super) fn to(&self, half: u32) -> u32 {
        self.from[next(half) as usize]
    }

    fn ends(&self, half: u32) -> [u32; 2] {
        [self.from[half as usize], self.to(half)]
    }

    /// The corners that face an edge inside: to the left and to the right of a half-edge.
    fn apexes(&self, half: u32) -> (u32, u32) {
        (self.from[previous(half) as usize], self.from[previous(self.twin[half as usize]) as usize])
    }

    fn orient(&self, a: u32, b: u32, c: u32) -> i32 {
        let [a, b, c] = [a, b, c].map(|point| self.points[point as usize]);
        orient(a, b, c)
    }

    /// Whether a place is to the left (1) of a half-edge.
    fn turn(&self, half: u32, at: Grid) -> i32 {
        let [a, b] = self.ends(half).map(|point| self.points[point as usize]);
        orient(a, b, at)
    }

    /// The first answer that is found at a half-edge that starts at a point.
    fn find_around<T>(&self, point: u32, mut ask: impl FnMut(u32) -> Option<T>) -> Option<T> {
        let first = self.leave[point as usize];
        let mut half = first;
        loop {
            if let Some(answer) = ask(half) {
                return Some(answer);
            }
            half = self.twin[previous(half) as usize];
            if half == first {
                return None;
            }
            if half == NONE {
                break;
            }
        }
        half = first;
        while self.twin[half as usize] != NONE {
            half = next(self.twin[half as usize]);
            if let Some(answer) = ask(half) {
                return Some(answer);
            }
        }
        None
    }

    /// A half-edge between two points: from the first to the second (1) or back (-1).
    fn edge(&self, a: u32, b: u32) -> Option<(u32, i32)> {
        self.find_around(a, |half| {
            let back = previous(half);
            match [self.to(half) == b, self.from[back as usize] == b] {
                [true, _] => Some((half, 1)),
                [_, true] => Some((back, -1)),
                _ => None,
            }
        })
    }

    fn raise(&mut self, half: u32, rise: i32) {
        self.rise[half as usize] += rise;
        let back = self.twin[half as usize];
        if back != NONE {
            self.rise[back as usize] -= rise;
        }
    }

    /// Writes triangle `t`: its corners, and for its sides the half-edges back and the rises.
    fn put(&mut self, t: u32, corners: [u32; 3], sides: [(u32, i32); 3]) {
        let first = 3 * t;
        if self.from.len() as u32 == first {
            self.from.extend([NONE; 3]);
            self.twin.extend([NONE; 3]);
            self.rise.extend([0; 3]);
        }
        for (half, (corner, (back, rise))) in (first..).zip(corners.into_iter().zip(sides)) {
            self.from[half as usize] = corner;
            self.leave[corner as usize] = half;
            self.twin[half as usize] = back;
            self.rise[half as usize] = rise;
            if back != NONE && (back as usize) < self.twin.len() {
                self.twin[back as usize] = half;
            }
        }
    }

    fn outer(&self, half: u32) -> (u32, i32) {
        (self.twin[half as usize], self.rise[half as usize])
    }

    fn split_triangle(&mut self, t: u32, p: u32) {
        let half = 3 * t;
        let [a, b, c] = [half, half + 1, half + 2].map(|h| self.from[h as usize]);
        let outer = [half, half + 1, half + 2].map(|h| self.outer(h));
        let n = self.from.len() as u32;
        // The first piece keeps the triangle's number, so that half-edges that point to it hold.
        self.put(t, [a, b, p], [outer[0], (n + 2, 0), (n + 4, 0)]);
        self.put(n / 3, [b, c, p], [outer[1], (n + 5, 0), (half + 1, 0)]);
        self.put(n / 3 + 1, [c, a, p], [outer[2], (half + 2, 0), (n + 1, 0)]);
    }

    /// Splits an edge at a point; both parts keep its rise.
    fn split_edge(&mut self, half: u32, p: u32) {
        let (back, rise) = self.outer(half);
        let (t, n) = (half / 3, self.from.len() as u32);
        let [a, b] = self.ends(half);
        let c = self.from[previous(half) as usize];
        let (bc, ca) = (self.outer(next(half)), self.outer(previous(half)));
        let right = (back != NONE).then(|| {
            let d = self.from[previous(back) as usize];
            (back / 3, d, self.outer(next(back)), self.outer(previous(back)))
        });
        let (first, second) = match right {
            Some((other, ..)) => (3 * other, n + 3),
            None => (NONE, NONE),
        };
        self.put(t, [a, p, c], [(first, rise), (n + 2, 0), ca]);
        self.put(n / 3, [p, b, c], [(second, rise), bc, (3 * t + 1, 0)]);
        if let Some((other, d, ad, db)) = right {
            // Seen from the other side the number falls by what it rises here.
            self.put(other, [p, a, d], [(3 * t, -rise), ad, (n + 4, 0)]);
            self.put(n / 3 + 1, [b, p, d], [(n, -rise), (3 * other + 2, 0), db]);
        }
    }

    /// Turns an edge inside to the other diagonal of its two triangles.
    fn flip(&mut self, half: u32) {
        let back = self.twin[half as usize];
        let [a, b] = self.ends(half);
        let (c, d) = self.apexes(half);
        let (bc, ca) = (self.outer(next(half)), self.outer(previous(half)));
        let (ad, db) = (self.outer(next(back)), self.outer(previous(back)));
        let (t, other) = (half / 3, back / 3);
        self.put(t, [d, b, c], [db, bc, (3 * other + 2, 0)]);
        self.put(other, [c, a, d], [ca, ad, (3 * t + 2, 0)]);
    }
}

/// How many steps are patiently taken for each point or edge in the way before a segment counts as tangled. A handful
/// is usual.
const PATIENCE: usize = 64;

fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

fn previous(half: u32) -> u32 {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}

/// `(b - a) x (d - c)`.
fn cross(a: Grid, b: Grid, c: Grid, d: Grid) -> i128 {
    let difference = |p: i64, q: i64| i128::from(q - p);
    difference(a[0], b[0]) * difference(c[1], d[1]) - difference(a[1], b[1]) * difference(c[0], d[0])
}

fn orient(a: Grid, b: Grid, c: Grid) -> i32 {
    cross(a, b, a, c).signum() as i32
}

/// The nearest whole number to a quotient.
fn divide(a: i128, b: i128) -> i128 {
    let (a, b) = if b < 0 { (-a, -b) } else { (a, b) };
    (a + b / 2).div_euclid(b)
}

/// The nearest place that is not on the border, which the neighbours share.
fn strictly_inside([x, y]: Grid) -> Grid {
    let [x, y] = [x, y].map(|c| c.clamp(1, SIDE - 2));
    let over = (x + y - (SIDE - 1)).max(0);
    let off_x = (over / 2 + over % 2).min(x - 1);
    [x - off_x, y - (over - off_x)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of all triangles, each of which must be positive, and every half-edge must fit its twin.
    fn sound(patch: &Patch) -> i128 {
        let mut sum = 0;
        for half in 0..patch.from.len() as u32 {
            let back = patch.twin[half as usize];
            if back != NONE {
                assert_eq!(patch.ends(back), [patch.to(half), patch.from[half as usize]]);
                assert_eq!((patch.twin[back as usize], patch.rise[back as usize]), (half, -patch.rise[half as usize]));
            }
            if half.is_multiple_of(3) {
                let [a, b, c] = [half, half + 1, half + 2].map(|h| patch.points[patch.from[h as usize] as usize]);
                assert!(orient(a, b, c) > 0);
                sum += cross(a, b, a, c);
            }
        }
        sum
    }

    fn connect(patch: &mut Patch, a: u32, b: u32, rise: i32) -> usize {
        let mut crossings = 0;
        patch.connect([a, b], rise, |_, _| crossings += 1).unwrap();
        assert_eq!(sound(patch), i128::from(SIDE) * i128::from(SIDE));
        crossings
    }

    fn rise_between(patch: &Patch, a: u32, b: u32) -> Option<i32> {
        patch.edge(a, b).map(|(half, sense)| sense * patch.rise[half as usize])
    }

    #[test]
    fn segments_that_cross_share_a_point() {
        let mut patch = Patch::default();
        patch.reset();
        let ends = [[1, 1], [5, 5], [1, 5], [6, 1]].map(|at: Grid| patch.insert_inside(at.map(|c| c * SIDE / 16)));
        assert_eq!(connect(&mut patch, ends[0], ends[1], 1), 0);
        assert_eq!(connect(&mut patch, ends[2], ends[3], 1), 1);
        let point = patch.points.len() as u32 - 1;
        // The lines y = x and 4 x + 5 y = 29 meet at 29 / 9.
        let at = (SIDE as f64 / 16.0 * 29.0 / 9.0).round() as i64;
        assert_eq!(patch.points[point as usize], [at, at]);
        for (a, b) in [(ends[0], point), (point, ends[1]), (ends[2], point), (point, ends[3])] {
            assert_eq!(rise_between(&patch, a, b), Some(1));
        }
    }

    #[test]
    fn segments_on_one_another_cancel() {
        let mut patch = Patch::default();
        patch.reset();
        let start = patch.insert_on_side(0, SIDE / 3);
        let end = patch.insert_on_side(2, SIDE / 2);
        // Beside the line between them by rounding.
        let [a, b] = [patch.points[start as usize], patch.points[end as usize]];
        let middle = patch.insert_inside([(a[0] + b[0]) / 2 + 3, (a[1] + b[1]) / 2 - 2]);
        assert_eq!(connect(&mut patch, start, end, 1), 0);
        assert_eq!(rise_between(&patch, start, middle), Some(1));
        connect(&mut patch, end, middle, 1);
        assert_eq!(rise_between(&patch, middle, end), Some(0));
        connect(&mut patch, middle, start, 1);
        assert!(patch.rise.iter().all(|&rise| rise == 0));
        patch.relax([1.0, 0.0, 1.0]);
        assert_eq!(sound(&patch), i128::from(SIDE) * i128::from(SIDE));
    }

    #[test]
    fn no_point_comes_to_lie_on_the_border() {
        for at in [[0, 0], [SIDE, 0], [0, SIDE], [SIDE / 2, SIDE / 2], [SIDE, SIDE], [0, 5]] {
            let [x, y] = strictly_inside(at);
            assert!(x > 0 && y > 0 && x + y < SIDE, "{at:?}");
        }
    }
}
