//! Caps: nested loops become triangles over exactly the vertices of the loops.
//!
//! Ear clipping (G. H. Meisters, "Polygons have ears", Amer. Math. Monthly 82, 1975), holes joined to their outline by bridges (D.
//! Eberly, "Triangulation by ear clipping", Geometric Tools, 2002). A polygon of `n` corners and `h` holes always gives
//! `n + 2 h - 2` triangles, whatever its coordinates: no vertex is left out, so what the cap closes is watertight. Where rounding
//! or touching loops leave no clean ear, the least bad one is taken.

use super::nest::{nest, turn};
use nalgebra::Point2;
use std::collections::BTreeSet;

/// Triangulates loops of vertex numbers.
///
/// # Arguments
/// * `flat`: coordinates of each corner of each loop, outlines counter-clockwise.
///
/// # Returns
/// Triangles of vertex numbers with the orientation of the outlines. Loops of fewer than three corners give none.
pub(crate) fn triangulate(loops: &[Vec<u32>], flat: &[Vec<Point2<f64>>]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for nested in nest(flat) {
        let corners = |k: usize| loops[k].iter().copied().zip(flat[k].iter().copied()).collect::<Vec<_>>();
        let mut polygon = corners(nested.outer);
        let mut holes: Vec<Vec<(u32, Point2<f64>)>> = nested.holes.into_iter().map(corners).collect();
        let rightmost = |hole: &[(u32, Point2<f64>)]| hole.iter().map(|(_, p)| p.x).fold(f64::NEG_INFINITY, f64::max);
        // Holes from the right to the left: the ones that are joined already cannot hide an outline from the next.
        holes.sort_by(|a, b| rightmost(b).total_cmp(&rightmost(a)));
        for hole in holes {
            bridge(&mut polygon, &hole);
        }
        let mut used: BTreeSet<[u32; 2]> = BTreeSet::new();
        let start = triangles.len();
        clip_ears(&polygon, &mut used, &mut triangles);
        debug_assert!(polygon.len() < 3 || triangles.len() - start == polygon.len() - 2);
    }
    triangles
}

/// Joins a hole to a polygon by a line from the hole's rightmost corner to a corner that it sees.
fn bridge(polygon: &mut Vec<(u32, Point2<f64>)>, hole: &[(u32, Point2<f64>)]) {
    let by_x = |&a: &usize, &b: &usize| hole[a].1.x.total_cmp(&hole[b].1.x).then(hole[b].1.y.total_cmp(&hole[a].1.y));
    let Some(right) = (0..hole.len()).max_by(by_x) else { return };
    let from = hole[right].1;
    // The nearest corner of the polygon from which the line runs inside it and crosses no edge.
    let mut order: Vec<usize> = (0..polygon.len()).collect();
    order.sort_by(|&a, &b| (polygon[a].1 - from).norm_squared().total_cmp(&(polygon[b].1 - from).norm_squared()));
    let sees = |&to: &usize| {
        let end = polygon[to].1;
        let (before, after) =
            (polygon[(to + polygon.len() - 1) % polygon.len()].1, polygon[(to + 1) % polygon.len()].1);
        in_corner(&before, &end, &after, &from) && !crosses_any(polygon, &from, &end) && !crosses_any(hole, &from, &end)
    };
    let to = order.iter().copied().find(sees).unwrap_or(order[0]);
    let mut joined = Vec::with_capacity(polygon.len() + hole.len() + 2);
    joined.extend_from_slice(&polygon[..=to]);
    joined.extend((0..=hole.len()).map(|k| hole[(right + k) % hole.len()]));
    joined.extend_from_slice(&polygon[to..]);
    *polygon = joined;
}

/// Whether `p` lies in the wedge of the corner, strictly.
fn in_corner(before: &Point2<f64>, at: &Point2<f64>, after: &Point2<f64>, p: &Point2<f64>) -> bool {
    if turn(before, at, after) > 0 {
        turn(before, at, p) > 0 && turn(at, after, p) > 0
    } else {
        turn(before, at, p) > 0 || turn(at, after, p) > 0
    }
}

/// Whether the open line from `a` to `b` meets an edge that does not end in `a` or `b`.
fn crosses_any(polygon: &[(u32, Point2<f64>)], a: &Point2<f64>, b: &Point2<f64>) -> bool {
    let [low, high] = [a.inf(b), a.sup(b)];
    (0..polygon.len()).any(|k| {
        let (c, d) = (&polygon[k].1, &polygon[(k + 1) % polygon.len()].1);
        if c.x.max(d.x) < low.x || c.x.min(d.x) > high.x || c.y.max(d.y) < low.y || c.y.min(d.y) > high.y {
            return false;
        }
        if c == a || c == b || d == a || d == b {
            return false;
        }
        turn(a, b, c) * turn(a, b, d) <= 0 && turn(c, d, a) * turn(c, d, b) <= 0
    })
}

/// Cuts ears off until three corners are left.
fn clip_ears(polygon: &[(u32, Point2<f64>)], used: &mut BTreeSet<[u32; 2]>, triangles: &mut Vec<[u32; 3]>) {
    let n = polygon.len();
    if n < 3 {
        return;
    }
    used.extend((0..n).map(|k| edge(polygon, k, (k + 1) % n)));
    let mut next: Vec<usize> = (1..=n).map(|k| k % n).collect();
    let mut before: Vec<usize> = (0..n).map(|k| (k + n - 1) % n).collect();
    let mut reflex: Vec<bool> =
        (0..n).map(|k| turn(&polygon[before[k]].1, &polygon[k].1, &polygon[next[k]].1) <= 0).collect();
    // Corners that may be spikes: those whose neighbours have changed. Spikes go first, or their sides would pass for those of an ear.
    let mut suspects: Vec<usize> = (0..n).rev().collect();
    let (mut left, mut at) = (n, 0);
    while left > 3 {
        let mut spike = None;
        while let (None, Some(corner)) = (spike, suspects.pop()) {
            let (a, c) = (before[corner], next[corner]);
            let is_left = next[a] == corner;
            spike = Some(corner)
                .filter(|_| is_left && !used.contains(&edge(polygon, a, c)) && is_spike(polygon, [a, corner, c]));
        }
        let ear = spike.unwrap_or_else(|| next_ear(polygon, [&next, &before], &reflex, used, [at, left]));
        let (a, c) = (before[ear], next[ear]);
        triangles.push([polygon[a].0, polygon[ear].0, polygon[c].0]);
        used.insert(edge(polygon, a, c));
        (next[a], before[c]) = (c, a);
        for k in [a, c] {
            reflex[k] = turn(&polygon[before[k]].1, &polygon[k].1, &polygon[next[k]].1) <= 0;
        }
        suspects.extend([c, a]);
        left -= 1;
        // Go on behind the ear: triangles become less thin than from one fan.
        at = next[c];
    }
    triangles.push([polygon[before[at]].0, polygon[at].0, polygon[next[at]].0]);
}

/// The next corner to cut off, once around from `at` over the `left` corners: a clean ear; else a flat one; else any that repeats no line;
/// else any.
fn next_ear(
    polygon: &[(u32, Point2<f64>)],
    [next, before]: [&[usize]; 2],
    reflex: &[bool],
    used: &BTreeSet<[u32; 2]>,
    [at, left]: [usize; 2],
) -> usize {
    let mut fallback: [Option<usize>; 3] = [None; 3];
    let mut corner = at;
    for _ in 0..left {
        let (a, c) = (before[corner], next[corner]);
        let new_line = !used.contains(&edge(polygon, a, c));
        let convex = turn(&polygon[a].1, &polygon[corner].1, &polygon[c].1);
        if new_line && convex > 0 && is_empty_ear(polygon, [next, before], reflex, [a, corner, c]) {
            return corner;
        }
        let rank = match (new_line, convex) {
            (true, 0) => 0,
            (true, _) => 1,
            _ => 2,
        };
        fallback[rank] = fallback[rank].or(Some(corner));
        corner = c;
    }
    fallback.into_iter().flatten().next().unwrap_or(at)
}

/// The vertices of the line between two corners.
fn edge(polygon: &[(u32, Point2<f64>)], a: usize, b: usize) -> [u32; 2] {
    [polygon[a].0.min(polygon[b].0), polygon[a].0.max(polygon[b].0)]
}

/// Whether a corner is the end of a line there and back, or repeats its neighbour: there is no inside at it.
fn is_spike(polygon: &[(u32, Point2<f64>)], [a, corner, c]: [usize; 3]) -> bool {
    let [before, at, after] = [a, corner, c].map(|k| polygon[k].1);
    turn(&before, &at, &after) == 0 && (before - at).dot(&(after - at)) >= 0.0
}

/// Whether the rest of the polygon stays out of the triangle of an ear.
fn is_empty_ear(
    polygon: &[(u32, Point2<f64>)],
    [next, before]: [&[usize]; 2],
    reflex: &[bool],
    [a, ear, c]: [usize; 3],
) -> bool {
    let [pa, pb, pc] = [a, ear, c].map(|k| polygon[k].1);
    let [low, high] = [pa.inf(&pb).inf(&pc), pa.sup(&pb).sup(&pc)];
    let left_of = |q: &Point2<f64>| [turn(&pa, &pb, q) > 0, turn(&pb, &pc, q) > 0, turn(&pc, &pa, q) > 0];
    let mut k = next[c];
    while k != a {
        let p = &polygon[k].1;
        if p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y {
            // At a corner of the ear lies another one of the polygon: do its lines run into the ear?
            let sides = [pa, pb, pc].iter().position(|corner| corner == p);
            let blocks = match sides {
                Some(corner) => [next[k], before[k]].into_iter().any(|beside| {
                    let left = left_of(&polygon[beside].1);
                    left[(corner + 2) % 3] && left[corner]
                }),
                None => reflex[k] && turn(&pa, &pb, p) >= 0 && turn(&pb, &pc, p) >= 0 && turn(&pc, &pa, p) >= 0,
            };
            if blocks {
                return false;
            }
        }
        k = next[k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::solid::nest::area;

    fn covered(loops: &[Vec<[f64; 2]>]) -> (usize, f64) {
        let flat: Vec<Vec<Point2<f64>>> =
            loops.iter().map(|l| l.iter().map(|&[x, y]| Point2::new(x, y)).collect()).collect();
        let mut count = 0;
        let numbers: Vec<Vec<u32>> = flat
            .iter()
            .map(|l| {
                l.iter()
                    .map(|_| {
                        count += 1;
                        count - 1
                    })
                    .collect()
            })
            .collect();
        let all: Vec<Point2<f64>> = flat.concat();
        let triangles = triangulate(&numbers, &flat);
        let areas = triangles.iter().map(|t| area(&t.map(|v| all[v as usize])));
        assert!(areas.clone().all(|a| a >= -1e-12));
        (triangles.len(), areas.sum())
    }

    #[test]
    fn polygons_with_holes_are_covered_once() {
        let square = vec![[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]];
        let hole = |x: f64, y: f64| vec![[x, y], [x, y + 1.0], [x + 1.0, y + 1.0], [x + 1.0, y]];
        assert_eq!(covered(std::slice::from_ref(&square)), (2, 64.0));
        assert_eq!(covered(&[square.clone(), hole(2.0, 2.0)]), (8, 63.0));
        let holes = [square, hole(2.0, 2.0), hole(4.0, 2.0), hole(2.0, 5.0), hole(6.0, 6.0)];
        assert_eq!(covered(&holes), (4 + 16 + 8 - 2, 60.0));
    }

    #[test]
    fn corners_on_a_line_and_corners_that_repeat_are_all_kept() {
        let strip =
            vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(covered(&[strip]), (6, 3.0));
        let repeated = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 2.0]];
        assert_eq!(covered(&[repeated]), (4, 4.0));
        assert_eq!(covered(&[vec![[0.0, 0.0], [1.0, 0.0]]]), (0, 0.0));
        // Two fat parts joined by a bar without width.
        let dumbbell = vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [3.0, 1.0],
            [3.0, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [3.0, 2.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        assert_eq!(covered(&[dumbbell]), (10, 4.0));
    }
}
