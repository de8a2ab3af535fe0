//! Level lines of whole numbers on a mesh, of a value that may change its sign from vertex to vertex.
//!
//! Values are in turns: the lines stand where the value is a whole number. At an edge the value goes evenly from that of the tail to that of the
//! head, plus whole turns; so the crossings of an edge are the same for both of its triangles. Values of a line field have a sign that is
//! theirs alone; seen from a neighbour it may be the other one, which turns whole numbers into whole numbers.
//!
//! Crossings around a triangle go up or down. Those next to each other that go up and down over the same number are joined, again and again, as
//! brackets are matched. In a regular triangle this is what linear interpolation gives. What is left over goes the same way all around: as
//! many lines as the value has turns around the triangle (Knöppel et al. 2015, section 4.2: its index). They end in the middle of the
//! triangle, where the interpolation of that paper has its singular point. Where the sign comes back turned (the field of directions is
//! singular there), up and down mean nothing, and crossings of different edges are joined from the corners on.

use super::near::surface_point;
use crate::mesh::{SurfaceMesh, SurfacePoint};

/// A curve on a layer along which a tape may be laid.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreLine {
    /// Points in order, at least two; the first is not repeated at the end.
    pub points: Vec<SurfacePoint>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}

impl CentreLine {
    /// Length in millimetres.
    pub fn length(&self) -> f64 {
        let closing = self.points.last().zip(self.points.first()).filter(|_| self.closed);
        let steps = self.points.windows(2).map(|pair| (&pair[0], &pair[1])).chain(closing);
        steps.map(|(from, to)| (to.position - from.position).norm()).sum()
    }
}

/// The value along a half-edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeValue {
    /// At the tail, and at the head as seen from the tail but for whole turns.
    pub ends: [f64; 2],
    /// The whole turns.
    pub turns: i64,
    /// Whether the head sees the value with the other sign.
    pub flips: bool,
}

impl EdgeValue {
    /// The number of the interval between whole numbers at each end; in whole numbers, so that no rounding tears lines.
    fn cells(&self) -> [i64; 2] {
        [self.ends[0].floor() as i64, self.turns + self.ends[1].floor() as i64]
    }

    /// Whole numbers on the way, positive upwards.
    pub(super) fn increment(&self) -> i64 {
        let [from, to] = self.cells();
        to - from
    }

    /// Where the crossings are, as shares of the length from the tail.
    fn crossings(&self) -> impl Iterator<Item = f64> {
        let [from, to] = self.cells();
        let (first, count) = if to > from { (from + 1, to - from) } else { (from, from - to) };
        let step = if to > from { 1 } else { -1 };
        let [start, end] = [self.ends[0], self.ends[1] + self.turns as f64];
        (0..count).map(move |k| (((first + step * k) as f64 - start) / (end - start)).clamp(0.0, 1.0))
    }
}

/// The level lines. `value`: along the lower half-edge of each edge.
pub(super) fn level_lines(mesh: &SurfaceMesh, value: impl Fn(u32) -> EdgeValue) -> Vec<CentreLine> {
    // The crossings of each edge, numbered from its tail on.
    let (mut points, mut first) = (Vec::new(), vec![0u32; mesh.half_edges() as usize + 1]);
    let (mut increments, mut flips) = (vec![0i64; mesh.half_edges() as usize], vec![false; mesh.half_edges() as usize]);
    for h in 0..mesh.half_edges() {
        first[h as usize] = points.len() as u32;
        if mesh.edge(h) != h {
            continue;
        }
        let along = value(h);
        (increments[h as usize], flips[h as usize]) = (along.increment(), along.flips);
        if let Some(twin) = mesh.twin(h) {
            // The other way: down instead of up, unless the sign turns as well.
            increments[twin as usize] = if along.flips { along.increment() } else { -along.increment() };
            flips[twin as usize] = along.flips;
        }
        let [tail, head] = [mesh.tail(h), mesh.head(h)].map(|v| mesh.vertices()[v as usize]);
        points.extend(along.crossings().map(|share| surface_point(mesh, h / 3, tail + (head - tail) * share)));
    }
    first[mesh.half_edges() as usize] = points.len() as u32;

    let mut links = vec![[NONE; 2]; points.len()];
    for triangle in 0..mesh.triangles().len() as u32 {
        let (mut around, mut sign) = ([const { Vec::new() }; 3], 1);
        for (k, around) in around.iter_mut().enumerate() {
            let h = 3 * triangle + k as u32;
            let edge = mesh.edge(h);
            let up = increments[h as usize] * sign > 0;
            let range = (first[edge as usize]..first[edge as usize + 1]).map(|point| Crossing { point, up });
            if edge == h {
                around.extend(range)
            } else {
                around.extend(range.rev())
            }
            sign = if flips[h as usize] { -sign } else { sign };
        }
        if around.iter().all(Vec::is_empty) {
            continue;
        }
        let (pairs, ends) = if sign > 0 { match_levels(&around) } else { match_corners(&around) };
        for [one, other] in pairs {
            link(&mut links, one, other);
            link(&mut links, other, one);
        }
        for crossing in ends {
            let middle = points.len() as u32;
            points.push(SurfacePoint {
                triangle,
                barycentric: [1.0 / 3.0; 3],
                position: mesh.point(triangle, [1.0 / 3.0; 3]),
            });
            links.push([crossing, NONE]);
            link(&mut links, crossing, middle);
        }
    }
    chains(&points, &links)
}

/// No such point.
const NONE: u32 = u32::MAX;

/// A crossing of an edge as seen on the way around a triangle.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    point: u32,
    up: bool,
}

/// Pairs of points that are joined, and points that are left over.
type Matching = (Vec<[u32; 2]>, Vec<u32>);

/// Joins neighbours that go up and down, as brackets are matched.
fn match_levels(around: &[Vec<Crossing>; 3]) -> Matching {
    let (mut pairs, mut open): (Vec<[u32; 2]>, Vec<Crossing>) = Default::default();
    for &crossing in around.iter().flatten() {
        match open.pop_if(|last| last.up != crossing.up) {
            Some(last) => pairs.push([last.point, crossing.point]),
            None => open.push(crossing),
        }
    }
    (pairs, open.iter().map(|crossing| crossing.point).collect())
}

/// Joins crossings of different edges around the corners, as many as can be; those in the middle of the longest row are left over.
fn match_corners(around: &[Vec<Crossing>; 3]) -> Matching {
    let counts = [0, 1, 2].map(|k| around[k].len());
    let sum: usize = counts.iter().sum();
    let most = (0..3).fold(0, |best, k| if counts[k] > counts[best] { k } else { best });
    // What is left over: more than the others have together, or an odd one.
    let over = if 2 * counts[most] > sum { 2 * counts[most] - sum } else { sum % 2 };
    let mut used = counts;
    used[most] -= over;
    let half: usize = used.iter().sum::<usize>() / 2;
    // Around the corner at the end of an edge.
    let at_head = [0, 1, 2].map(|k| half - used[(k + 2) % 3]);
    let mut pairs = Vec::with_capacity(half);
    for k in 0..3 {
        for n in 0..at_head[k] {
            pairs.push([around[k][counts[k] - 1 - n].point, around[(k + 1) % 3][n].point]);
        }
    }
    let begin = at_head[(most + 2) % 3];
    (pairs, around[most][begin..begin + over].iter().map(|crossing| crossing.point).collect())
}

fn link(links: &mut [[u32; 2]], from: u32, to: u32) {
    let free = links[from as usize].iter().position(|&link| link == NONE);
    debug_assert!(free.is_some(), "a crossing has two sides");
    if let Some(free) = free {
        links[from as usize][free] = to;
    }
}

/// The polylines through linked points: open ones from their lower end on, then closed ones.
fn chains(points: &[SurfacePoint], links: &[[u32; 2]]) -> Vec<CentreLine> {
    let mut seen = vec![false; points.len()];
    let mut lines = Vec::new();
    let starts = (0..points.len()).filter(|&k| links[k][1] == NONE).chain(0..points.len());
    for start in starts {
        if seen[start] {
            continue;
        }
        let (mut chain, mut at) = (Vec::new(), start as u32);
        loop {
            seen[at as usize] = true;
            chain.push(points[at as usize]);
            match links[at as usize].into_iter().find(|&to| to != NONE && !seen[to as usize]) {
                Some(to) => at = to,
                None => break,
            }
        }
        let closed = chain.len() > 2 && links[at as usize].contains(&(start as u32));
        if chain.len() > 1 {
            lines.push(CentreLine { points: chain, closed });
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Crossings are joined around the corners; what a long row has more than both others together is left over, or an odd one.
    #[test]
    fn crossings_are_joined_around_the_corners() {
        let matched = |counts: [u32; 3]| {
            let first = [0, counts[0], counts[0] + counts[1]];
            let edge = |k: usize| (first[k]..first[k] + counts[k]).map(|point| Crossing { point, up: true }).collect();
            match_corners(&[0, 1, 2].map(edge))
        };
        assert_eq!(matched([1, 1, 0]), (vec![[0, 1]], vec![]));
        assert_eq!(matched([5, 1, 0]), (vec![[4, 5]], vec![0, 1, 2, 3]));
        assert_eq!(matched([2, 2, 2]), (vec![[1, 2], [3, 4], [5, 0]], vec![]));
        for counts in [[4, 1, 1], [3, 2, 2], [1, 6, 3], [2, 3, 9], [0, 0, 4], [7, 7, 1]] {
            let (pairs, left) = matched(counts);
            let (sum, most) = (counts.iter().sum::<u32>(), *counts.iter().max().unwrap());
            let over = if 2 * most > sum { 2 * most - sum } else { sum % 2 };
            assert_eq!((pairs.len() as u32, left.len() as u32), ((sum - over) / 2, over), "{counts:?}");
            let mut points: Vec<u32> = pairs.iter().flatten().chain(&left).copied().collect();
            points.sort_unstable();
            assert_eq!(points, (0..sum).collect::<Vec<_>>(), "{counts:?}");
        }
    }
}
