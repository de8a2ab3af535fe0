//! Scan lines, joined to zigzags.
//!
//! Brooks counts the points where a scan line meets the outline, and an odd count makes it fill outside (Fig. 4-11 d). Here an edge
//! meets a line if one of its ends lies at or below the line and the other above it. So a closed outline meets each line an even number
//! of times, whatever corners or edges lie on the line, and tangencies count twice or not at all.
//!
//! The same crossings, in their order along the outline, say how lines are joined: from a crossing the outline leads to the next
//! one, on this line or on a neighbour; if it is a neighbour, that piece of the outline joins the two.

use super::options::FillOptions;
use crate::drawing::polygon::{Ring, Shape};

/// The first and the last line lie this share of a bead within the shape, so that a straight edge there is a line.
const EDGE: f64 = 1e-3;

/// Where an outline meets a scan line.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    ring: usize,
    /// The edge after the point of this number.
    edge: usize,
    row: usize,
    x: f64,
    /// Neighbours along the outline.
    next: usize,
    previous: usize,
    /// The other end of the line here.
    partner: usize,
}

/// Scan lines within a shape, from end to end, with the width of their beads.
pub(super) fn scan(shape: &Shape, bead: f64, options: &FillOptions) -> Vec<(Ring, f64)> {
    let (sin, cos) = options.angle.sin_cos();
    let turned: Shape =
        shape.iter().map(|ring| ring.iter().map(|&[x, y]| [cos * x + sin * y, cos * y - sin * x]).collect()).collect();
    let heights = turned.iter().flatten().map(|at| at[1]);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    // Not for an empty shape either, whose extent is infinite the wrong way round.
    if low >= high {
        return Vec::new();
    }
    // Lines reach half a bead beyond the shape on both sides.
    let count = ((high - low) / bead).round();
    let (rows, width) = if count < 1.0 {
        (vec![0.5 * (low + high)], bead)
    } else {
        let step = (high - low) / count;
        let edge = (EDGE * bead).min(0.25 * step);
        let row = |k: usize| (low + k as f64 * step).clamp(low + edge, high - edge);
        ((0..=count as usize).map(row).collect(), step)
    };
    let lines = strokes(&turned, &rows, options.zigzag);
    let back = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    lines.into_iter().map(|line| (line.into_iter().map(back).collect(), width)).collect()
}

fn crossings(shape: &Shape, rows: &[f64]) -> Vec<Crossing> {
    let mut all: Vec<Crossing> = Vec::new();
    for (ring, points) in shape.iter().enumerate() {
        let first = all.len();
        for (edge, (a, b)) in points.iter().zip(points.iter().cycle().skip(1)).enumerate() {
            let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
            // Rows from the first that is not below `low` to the last below `high`.
            let met = rows.partition_point(|&y| y < low)..rows.partition_point(|&y| y < high);
            let crossing = |row: usize| {
                let x = a[0] + (b[0] - a[0]) * ((rows[row] - a[1]) / (b[1] - a[1]));
                Crossing { ring, edge, row, x, next: 0, previous: 0, partner: 0 }
            };
            if a[1] < b[1] {
                all.extend(met.map(crossing));
            } else {
                all.extend(met.rev().map(crossing));
            }
        }
        let last = all.len();
        for (k, crossing) in all.iter_mut().enumerate().skip(first) {
            crossing.next = if k + 1 < last { k + 1 } else { first };
            crossing.previous = if k > first { k - 1 } else { last - 1 };
        }
    }
    let mut by_place: Vec<usize> = (0..all.len()).collect();
    by_place.sort_by(|&i, &k| all[i].row.cmp(&all[k].row).then(all[i].x.total_cmp(&all[k].x)).then(i.cmp(&k)));
    for pair in by_place.chunks(2) {
        // Each row has an even number of them.
        if let [a, b] = *pair {
            (all[a].partner, all[b].partner) = (b, a);
        }
    }
    all
}

fn strokes(shape: &Shape, rows: &[f64], zigzag: bool) -> Vec<Ring> {
    let all = crossings(shape, rows);
    let mut starts: Vec<usize> = (0..all.len()).collect();
    starts.sort_by(|&i, &k| all[i].row.cmp(&all[k].row).then(all[i].x.total_cmp(&all[k].x)).then(i.cmp(&k)));
    let mut done = vec![false; all.len()];
    let at = |k: usize| [all[k].x, rows[all[k].row]];
    let mut out = Vec::new();
    for start in starts {
        if done[start] {
            continue;
        }
        let mut line = vec![at(start), at(all[start].partner)];
        let mut end = all[start].partner;
        (done[start], done[end]) = (true, true);
        loop {
            // Upwards first: the rows below are mostly done.
            let leads = |&(to, _): &(usize, bool)| zigzag && !done[to] && all[to].row.abs_diff(all[end].row) == 1;
            let ways = [(all[end].next, true), (all[end].previous, false)];
            let Some((to, forward)) = ways.into_iter().filter(leads).max_by_key(|&(to, _)| all[to].row) else { break };
            line.extend(between(&shape[all[end].ring], all[end].edge, all[to].edge, forward));
            let other = all[to].partner;
            line.extend([at(to), at(other)]);
            (done[to], done[other]) = (true, true);
            end = other;
        }
        line.dedup();
        if line.len() > 1 {
            out.push(line);
        }
    }
    out
}

/// The corners of a ring on the way from one edge to another.
fn between(ring: &Ring, from: usize, to: usize, forward: bool) -> Vec<[f64; 2]> {
    let n = ring.len();
    let mut corners = Vec::new();
    let mut edge = from;
    while edge != to {
        if forward {
            edge = (edge + 1) % n;
            corners.push(ring[edge]);
        } else {
            corners.push(ring[edge]);
            edge = (edge + n - 1) % n;
        }
    }
    corners
}
