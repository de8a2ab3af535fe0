//! Runs of cells along the rows of a grid, and which of them hang together.
//!
//! A part of a hundred thousand cells has some thousand runs, so finding its pieces anew costs less than keeping
//! them up to date while cells come off.

use super::rules::Neighbours;
use crate::cells::CellSet;
use crate::union_find::UnionFind;

/// The runs of a set of cells, each with the number of the piece that it belongs to.
pub(crate) struct Runs {
    nx: u32,
    /// The first run of each row, and the number of runs at the end.
    first: Vec<u32>,
    /// Where each run starts in its row, and where it ends.
    spans: Vec<[u32; 2]>,
    /// The piece of each run; pieces are numbered in the order of their first cells.
    pieces: Vec<u32>,
    count: usize,
}

impl Runs {
    /// Finds the pieces that hang together through `neighbours`.
    pub(crate) fn new(cells: &CellSet, neighbours: Neighbours) -> Self {
        let [nx, ny, nz] = cells.dims();
        let (first, spans) = runs_of(cells);
        let mut united = UnionFind::new(spans.len());
        let reaches = reaches(neighbours);
        for z in 0..nz {
            for y in 0..ny {
                let runs = |y: u32, z: u32| {
                    let row = (y + ny * z) as usize;
                    first[row] as usize..first[row + 1] as usize
                };
                for &(step, reach) in &reaches {
                    let [there_y, there_z] = [y.wrapping_add_signed(step[0]), z.wrapping_add_signed(step[1])];
                    if there_y < ny && there_z < nz {
                        join(&spans, runs(y, z), runs(there_y, there_z), reach, &mut united);
                    }
                }
            }
        }
        let mut pieces = vec![0; spans.len()];
        let mut count = 0;
        for run in 0..spans.len() {
            let root = united.root(run as u32) as usize;
            pieces[run] = if root == run { count } else { pieces[root] };
            count += u32::from(root == run);
        }
        Runs { nx, first, spans, pieces, count: count as usize }
    }

    /// Number of pieces.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The piece of a cell, which must be in the set.
    pub(crate) fn piece(&self, cell: u32) -> usize {
        let (row, x) = ((cell / self.nx) as usize, cell % self.nx);
        let (start, end) = (self.first[row] as usize, self.first[row + 1] as usize);
        let before = self.spans[start..end].partition_point(|span| span[1] <= x);
        self.pieces[start + before] as usize
    }

    /// Which pieces have one of `cells`, which must be in the set.
    pub(crate) fn with(&self, cells: &[u32]) -> Vec<bool> {
        let mut with = vec![false; self.count];
        cells.iter().for_each(|&cell| with[self.piece(cell)] = true);
        with
    }

    /// Number of cells in each piece.
    pub(crate) fn sizes(&self) -> Vec<usize> {
        let mut sizes = vec![0; self.count];
        for (span, &piece) in self.spans.iter().zip(&self.pieces) {
            sizes[piece as usize] += (span[1] - span[0]) as usize;
        }
        sizes
    }

    /// The cells of all pieces that `wanted` accepts, by rising number.
    pub(crate) fn cells(&self, wanted: impl Fn(usize) -> bool) -> impl Iterator<Item = u32> {
        let rows = self.first.windows(2).enumerate();
        let numbered = rows.flat_map(|(row, runs)| (runs[0]..runs[1]).map(move |run| (row as u32, run as usize)));
        numbered.filter(move |&(_, run)| wanted(self.pieces[run] as usize)).flat_map(|(row, run)| {
            let [start, end] = self.spans[run];
            row * self.nx + start..row * self.nx + end
        })
    }
}

/// For each row: its first run, and the runs as `[start, end]`.
fn runs_of(cells: &CellSet) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut first = Vec::new();
    let mut spans: Vec<[u32; 2]> = Vec::new();
    for bits in cells.rows() {
        let start_of_row = spans.len();
        first.push(start_of_row as u32);
        for (word, &bits) in bits.iter().enumerate() {
            let mut left = bits;
            while left != 0 {
                let start = left.trailing_zeros();
                let length = (left >> start).trailing_ones();
                left &= if start + length == 64 { 0 } else { u64::MAX << (start + length) };
                let [start, end] = [start, start + length].map(|bit| 64 * word as u32 + bit);
                match spans[start_of_row..].last_mut() {
                    Some(last) if last[1] == start => last[1] = end,
                    _ => spans.push([start, end]),
                }
            }
        }
    }
    first.push(spans.len() as u32);
    (first, spans)
}

/// The rows at or before a row where neighbours of its cells can be, as steps in y and z, and how far off in x.
fn reaches(neighbours: Neighbours) -> Vec<([i32; 2], u32)> {
    let mut reaches: Vec<([i32; 2], u32)> = Vec::new();
    for &[x, y, z] in neighbours.offsets().iter().filter(|offset| (offset[2], offset[1]) <= (0, 0)) {
        match reaches.iter_mut().find(|(step, _)| *step == [y, z]) {
            Some((_, reach)) => *reach = x.unsigned_abs().max(*reach),
            None => reaches.push(([y, z], x.unsigned_abs())),
        }
    }
    reaches
}

/// Joins the runs of two rows, or of one, that come within `reach` of each other.
fn join(
    spans: &[[u32; 2]],
    here: std::ops::Range<usize>,
    there: std::ops::Range<usize>,
    reach: u32,
    pieces: &mut UnionFind,
) {
    if here == there {
        for run in here.skip(1) {
            if spans[run][0] < spans[run - 1][1] + reach {
                pieces.join(run as u32 - 1, run as u32);
            }
        }
        return;
    }
    let (mut a, mut b) = (here.start, there.start);
    while a < here.end && b < there.end {
        if spans[a][0] < spans[b][1] + reach && spans[b][0] < spans[a][1] + reach {
            pieces.join(a as u32, b as u32);
        }
        if spans[a][1] < spans[b][1] { a += 1 } else { b += 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;
    use proptest::prelude::*;

    /// Pieces by walking from cell to cell.
    fn pieces_by_walking(cells: &CellSet, neighbours: Neighbours) -> Vec<Vec<u32>> {
        let mut left = cells.clone();
        let mut pieces = Vec::new();
        for start in cells.iter() {
            if !left.contains(start) {
                continue;
            }
            left.remove(start);
            let mut piece = vec![start];
            let mut done = 0;
            while let Some(&cell) = piece.get(done) {
                let around: Vec<u32> = left.around(cell, neighbours.offsets()).collect();
                around.iter().for_each(|&next| left.remove(next));
                piece.extend(around);
                done += 1;
            }
            piece.sort_unstable();
            pieces.push(piece);
        }
        pieces
    }

    proptest! {
        #[test]
        fn pieces_are_those_of_a_walk(
            nx in 1u32..70, ny in 1u32..5, nz in 1u32..5, bits in prop::collection::vec(any::<[u64; 2]>(), 16), sparse: bool,
        ) {
            let words = nx.div_ceil(64) as usize;
            let mut rows = vec![0; words * (ny * nz) as usize];
            for (at, row) in rows.iter_mut().enumerate() {
                let [a, b] = bits[at / words % 16];
                let kept = nx - 64 * (at % words) as u32;
                *row = (if sparse { a & b } else { a | b }) & if kept >= 64 { u64::MAX } else { (1 << kept) - 1 };
            }
            let cells = CellSet::of(&Cells::new([nx, ny, nz], &rows).unwrap());
            for neighbours in [Neighbours::FaceOrEdge, Neighbours::OneNorm] {
                let runs = Runs::new(&cells, neighbours);
                let walked = pieces_by_walking(&cells, neighbours);
                prop_assert_eq!(runs.count(), walked.len());
                for (piece, cells) in walked.iter().enumerate() {
                    prop_assert_eq!(&runs.cells(|p| p == piece).collect::<Vec<_>>(), cells);
                    prop_assert_eq!(runs.sizes()[piece], cells.len());
                    prop_assert!(cells.iter().all(|&cell| runs.piece(cell) == piece));
                    prop_assert_eq!(runs.with(cells).iter().filter(|&&with| with).count(), 1);
                }
            }
        }
    }
}
