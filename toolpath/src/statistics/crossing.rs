//! Where curves cross or touch each other or themselves, decided on the surface.
//!
//! Pieces of one triangle have ends on its lattice, so whether two of them cross is a question about integers. Pieces of
//! different triangles can meet only on edges and in vertices, where points are compared by number. Two pieces that
//! cross within both of them are one crossing. Contacts that involve an end of a piece appear for several pairs of
//! pieces; those of neighbouring pairs are one. Neighbours along a curve touch, of course, and ends may meet ends.

use super::curve::Piece;
use super::sheet::Sheet;
use super::trace::STEPS;
use crate::union_find::join;
use std::collections::BTreeSet;

/// Up to so many pieces in a triangle all pairs are tested; beyond, those with a cell of a grid in common.
const FEW: usize = 16;

/// Cells of the grid along an edge, at most. Beyond, memory grows without gain.
const MAX_CELLS: usize = 512;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Contact {
    None,
    Crossing,
    Touch,
}

type Lattice = (i64, i64);

/// Twice the area of a triangle on the lattice: differences are below 2^31, so this is exact.
fn orientation(a: Lattice, b: Lattice, c: Lattice) -> i64 {
    ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)).signum()
}

fn contact([a, b]: [Lattice; 2], [c, d]: [Lattice; 2]) -> Contact {
    let within = |p: i64, q: i64, r: i64, s: i64| p.min(q) <= r.max(s) && r.min(s) <= p.max(q);
    if !within(a.0, b.0, c.0, d.0) || !within(a.1, b.1, c.1, d.1) {
        return Contact::None;
    }
    let cd = [orientation(a, b, c), orientation(a, b, d)];
    let ab = [orientation(c, d, a), orientation(c, d, b)];
    match (cd[0] * cd[1], ab[0] * ab[1]) {
        (1, _) | (_, 1) => Contact::None,
        (-1, -1) => Contact::Crossing,
        // On one line, their boxes overlap; else an end of one lies on the other.
        _ => Contact::Touch,
    }
}

struct Meetings<'p> {
    sheet: &'p Sheet,
    pieces: &'p [Piece],
    /// First piece of each curve, and their number at the end.
    first: Vec<u32>,
    closed: &'p [bool],
    crossings: usize,
    touches: BTreeSet<(u32, u32)>,
}

/// Counts the places where curves meet. Pieces are in order, curves from 0 on.
pub(super) fn count(sheet: &Sheet, pieces: &[Piece], closed: &[bool]) -> usize {
    let mut first = vec![0u32; closed.len() + 1];
    pieces.iter().for_each(|p| first[p.curve as usize + 1] += 1);
    (0..closed.len()).for_each(|c| first[c + 1] += first[c]);
    let mut meetings = Meetings { sheet, pieces, first, closed, crossings: 0, touches: BTreeSet::new() };
    let mut order: Vec<u32> = (0..pieces.len() as u32).collect();
    order.sort_by_key(|&p| pieces[p as usize].triangle); // stable: pieces stay in order
    for group in order.chunk_by(|&a, &b| pieces[a as usize].triangle == pieces[b as usize].triangle) {
        if group.len() <= FEW {
            for (k, &a) in group.iter().enumerate() {
                group[k + 1..].iter().for_each(|&b| meetings.test(a, b));
            }
        } else {
            Cells::new(pieces, group).pairs(|a, b| meetings.test(a, b));
        }
    }
    meetings.at_edges();
    meetings.crossings + meetings.groups()
}

fn lattice(piece: &Piece) -> [Lattice; 2] {
    piece.weights.map(|w| (w[0], w[1]))
}

impl Meetings<'_> {
    /// The piece after this one along its curve.
    fn after(&self, piece: u32) -> Option<u32> {
        let curve = self.pieces[piece as usize].curve as usize;
        if piece + 1 < self.first[curve + 1] {
            Some(piece + 1)
        } else {
            self.closed[curve].then_some(self.first[curve])
        }
    }

    fn adjacent(&self, a: u32, b: u32) -> bool {
        self.after(a) == Some(b) || self.after(b) == Some(a)
    }

    /// Tests two pieces of a triangle, `a` before `b`.
    fn test(&mut self, a: u32, b: u32) {
        if self.adjacent(a, b) {
            return;
        }
        let (p, q) = (&self.pieces[a as usize], &self.pieces[b as usize]);
        match contact(lattice(p), lattice(q)) {
            Contact::None => {}
            Contact::Crossing => self.crossings += 1,
            Contact::Touch => {
                if !self.ends_meet(a, b) {
                    self.touches.insert((a, b));
                }
            }
        }
    }

    /// Contacts of pieces of different triangles.
    fn at_edges(&mut self) {
        let mut points = Vec::new();
        for (number, piece) in self.pieces.iter().enumerate() {
            let corners = self.sheet.flats[piece.triangle as usize].corners;
            let ends = if piece.weights[0] == piece.weights[1] { 1 } else { 2 };
            for weights in &piece.weights[..ends] {
                let mut on = (0..3).filter(|&k| weights[k] != 0).map(|k| (corners[k], weights[k]));
                let key = match (on.next(), on.next(), on.next()) {
                    (Some((v, _)), None, None) => (v, v, STEPS),
                    (Some(a), Some(b), None) => (a.0.min(b.0), a.0.max(b.0), if a.0 < b.0 { a.1 } else { b.1 }),
                    _ => continue,
                };
                points.push((key, number as u32));
            }
        }
        points.sort_unstable();
        for same in points.chunk_by(|a, b| a.0 == b.0) {
            for pair in same.windows(2) {
                let (a, b) = (pair[0].1, pair[1].1);
                let is_visit_of_one = a == b || self.adjacent(a, b);
                let one_triangle = self.pieces[a as usize].triangle == self.pieces[b as usize].triangle;
                if !is_visit_of_one && !one_triangle && !self.ends_meet(a, b) {
                    self.touches.insert((a, b));
                }
            }
        }
    }

    /// Whether the end of a curve is at the end of a curve.
    fn ends_meet(&self, a: u32, b: u32) -> bool {
        let ends = |piece: u32| {
            let p = &self.pieces[piece as usize];
            let curve = p.curve as usize;
            let open = !self.closed[curve];
            let corners = self.sheet.flats[p.triangle as usize].corners;
            let key = |weights: [i64; 3]| {
                let mut key: Vec<_> = (0..3).filter(|&k| weights[k] != 0).map(|k| (corners[k], weights[k])).collect();
                key.sort_unstable();
                key
            };
            let is_first = open && piece == self.first[curve];
            let is_last = open && piece + 1 == self.first[curve + 1];
            [is_first.then(|| key(p.weights[0])), is_last.then(|| key(p.weights[1]))]
        };
        let (of_a, of_b) = (ends(a), ends(b));
        of_a.iter().flatten().any(|w| of_b.iter().flatten().any(|v| v == w))
    }

    /// Contacts are one place if pieces of one come right before or after those of the other, or are the same.
    fn groups(&self) -> usize {
        let pairs: Vec<(u32, u32)> = self.touches.iter().copied().collect();
        let mut parents: Vec<u32> = (0..pairs.len() as u32).collect();
        for (k, &(a, b)) in (0..).zip(&pairs) {
            let mut near_a = vec![a];
            near_a.extend(self.after(a));
            let mut near_b = vec![b];
            near_b.extend(self.after(b));
            // (a, b + 1), (a + 1, b), (a + 1, b + 1), and the crosswise pair of (a + 1, b) seen from (a, b + 1).
            let mut others = Vec::new();
            for &x in &near_a {
                for &y in &near_b {
                    others.push((x.min(y), x.max(y)));
                }
            }
            for &x in &near_a[1..] {
                let before = self.before(b);
                others.extend(before.map(|y| (x.min(y), x.max(y))));
            }
            for other in others {
                if let Ok(l) = pairs.binary_search(&other) {
                    join(&mut parents, k, l as u32);
                }
            }
        }
        (0..).zip(parents).filter(|&(k, parent)| parent == k).count()
    }

    fn before(&self, piece: u32) -> Option<u32> {
        let curve = self.pieces[piece as usize].curve as usize;
        if piece > self.first[curve] { Some(piece - 1) } else { self.closed[curve].then(|| self.first[curve + 1] - 1) }
    }
}

/// A grid over a triangle with the pieces in each cell.
struct Cells<'p> {
    pieces: &'p [Piece],
    group: &'p [u32],
    side: usize,
    first: Vec<u32>,
    within: Vec<u32>,
}

impl<'p> Cells<'p> {
    fn new(pieces: &'p [Piece], group: &'p [u32]) -> Self {
        let side = ((group.len() as f64).sqrt().ceil() as usize).min(MAX_CELLS);
        let mut cells = Cells { pieces, group, side, first: vec![0; side * side + 1], within: Vec::new() };
        let mut entries = Vec::new();
        for k in 0..group.len() {
            cells.of(k, |cell| entries.push((cell as u32, k as u32)));
        }
        entries.iter().for_each(|&(cell, _)| cells.first[cell as usize + 1] += 1);
        (0..side * side).for_each(|c| cells.first[c + 1] += cells.first[c]);
        let mut filled = cells.first.clone();
        cells.within = vec![0; entries.len()];
        for (cell, k) in entries {
            cells.within[filled[cell as usize] as usize] = k;
            filled[cell as usize] += 1;
        }
        cells
    }

    /// The cells that a piece of the group touches, and perhaps some beside.
    fn of(&self, k: usize, mut take: impl FnMut(usize)) {
        let [mut p, mut q] = lattice(&self.pieces[self.group[k] as usize]);
        if p.0 > q.0 {
            (p, q) = (q, p);
        }
        let size = STEPS as f64 / self.side as f64;
        let cell = |x: f64| ((x / size).floor().max(0.0) as usize).min(self.side - 1);
        let ends = [p, q].map(|(u, v)| (u as f64, v as f64));
        // Rounding must not lose a cell: two steps of the lattice are far more than it amounts to.
        let slack = 2.0;
        for column in cell(ends[0].0 - slack)..=cell(ends[1].0 + slack) {
            let at = |u: f64| match ends[1].0 - ends[0].0 {
                run if run > 0.0 => {
                    let t = ((u - ends[0].0) / run).clamp(0.0, 1.0);
                    ends[0].1 + (ends[1].1 - ends[0].1) * t
                }
                _ => ends[0].1,
            };
            let (mut a, mut b) = (at(column as f64 * size - slack), at((column + 1) as f64 * size + slack));
            if p.0 == q.0 {
                (a, b) = (ends[0].1, ends[1].1);
            }
            for row in cell(a.min(b) - slack)..=cell(a.max(b) + slack) {
                take(column * self.side + row);
            }
        }
    }

    /// All pairs with a cell in common, each once.
    fn pairs(&self, mut test: impl FnMut(u32, u32)) {
        let mut tested = vec![u32::MAX; self.group.len()];
        for k in 0..self.group.len() {
            self.of(k, |cell| {
                for &l in &self.within[self.first[cell] as usize..self.first[cell + 1] as usize] {
                    if l as usize > k && tested[l as usize] != k as u32 {
                        tested[l as usize] = k as u32;
                        test(self.group[k], self.group[l as usize]);
                    }
                }
            });
        }
    }
}
