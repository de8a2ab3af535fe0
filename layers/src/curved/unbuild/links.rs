//! Which extreme cells have to stay so that everything else that stays hangs together with the platform.
//!
//! Without its extreme cells a part falls into pieces. Pieces that do not stand on the platform are tied to those that do by
//! the shortest chains of extreme cells, as in Prim's algorithm: the nearest piece is tied first and then counts
//! as tied for the others.

use crate::cells::CellSet;
use crate::curved::buildable::runs::Runs;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How pieces are tied to those that stand on the platform.
pub(crate) struct Links {
    /// For each piece its tie; none for those that stand, and for those out of reach.
    ties: Vec<Option<Tie>>,
    /// The pieces that were tied, in that order.
    tied: Vec<usize>,
}

/// A chain of extreme cells from a piece to another one, which was tied before.
struct Tie {
    chain: Vec<u32>,
    to: usize,
}

/// The way to an extreme cell.
#[derive(Clone, Copy)]
struct Way {
    length: u32,
    /// The cell before, as an index; none next to a piece.
    before: Option<usize>,
    /// The piece where it starts.
    from: usize,
}

impl Links {
    /// Ties the pieces of `core`, of which `standing` stand on the platform, through the cells in `extreme` (by rising
    /// number). The same input gives the same ties.
    pub(crate) fn new(core: &CellSet, pieces: &Runs, standing: &[bool], extreme: &[u32], offsets: &[[i32; 3]]) -> Self {
        let mut among = core.clone();
        among.clear();
        extreme.iter().for_each(|&cell| _ = among.insert(cell));
        // Which pieces each extreme cell touches, and the other way round.
        let mut touches: Vec<Vec<usize>> = vec![Vec::new(); extreme.len()];
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); pieces.count()];
        for (at, &cell) in extreme.iter().enumerate() {
            touches[at].extend(core.around(cell, offsets).map(|next| pieces.piece(next)));
            touches[at].sort_unstable();
            touches[at].dedup();
            touches[at].iter().for_each(|&piece| around[piece].push(at));
        }

        let mut links = Links { ties: (0..pieces.count()).map(|_| None).collect(), tied: Vec::new() };
        let mut ways: Vec<Option<Way>> = vec![None; extreme.len()];
        let mut queue = BinaryHeap::new();
        let reach = |at: usize, way: Way, ways: &mut Vec<Option<Way>>, queue: &mut BinaryHeap<_>| {
            if ways[at].is_none_or(|known| way.length < known.length) {
                ways[at] = Some(way);
                queue.push(Reverse((way.length, at)));
            }
        };
        for piece in (0..pieces.count()).filter(|&piece| standing[piece]) {
            for &at in &around[piece] {
                reach(at, Way { length: 1, before: None, from: piece }, &mut ways, &mut queue);
            }
        }
        while let Some(Reverse((length, at))) = queue.pop() {
            // Entries that were found to be shorter ways later are passed over.
            let Some(way) = ways[at].filter(|way| way.length == length) else { continue };
            for &piece in &touches[at] {
                if !standing[piece] && links.ties[piece].is_none() {
                    let steps = std::iter::successors(Some(at), |&step| ways[step].and_then(|way| way.before));
                    let chain: Vec<u32> = steps.map(|step| extreme[step]).collect();
                    // Lengths come by rising number, so the first chain to a piece is its shortest. From there on the piece counts as
                    // tied, and ways begin at it anew.
                    links.ties[piece] = Some(Tie { chain, to: way.from });
                    links.tied.push(piece);
                    for &next in &around[piece] {
                        reach(next, Way { length: 1, before: None, from: piece }, &mut ways, &mut queue);
                    }
                }
            }
            for next in among.around(extreme[at], offsets) {
                // `extreme` is sorted, and has this cell.
                let next = extreme.partition_point(|&cell| cell < next);
                reach(next, Way { length: length + 1, before: Some(at), from: way.from }, &mut ways, &mut queue);
            }
        }
        links
    }

    /// The cells that tie all pieces.
    pub(crate) fn all(&self) -> impl Iterator<Item = u32> {
        self.ties.iter().flatten().flat_map(|tie| tie.chain.iter().copied())
    }

    /// The cells that tie one piece, and the pieces on the way.
    pub(super) fn of(&self, piece: usize) -> impl Iterator<Item = u32> {
        let ties = std::iter::successors(self.ties[piece].as_ref(), |tie| self.ties[tie.to].as_ref());
        ties.flat_map(|tie| tie.chain.iter().copied())
    }

    /// The piece that would take the fewest cells along if it came loose, as a flag for each piece: it and all that hang on it.
    /// `sizes` are those of the pieces. None if no piece is tied.
    pub(super) fn cheapest(&self, mut sizes: Vec<usize>) -> Option<Vec<bool>> {
        // In the reverse order of tying: what hangs on a piece has its full size before it is added to what that hangs on.
        for &piece in self.tied.iter().rev() {
            if let Some(tie) = &self.ties[piece] {
                sizes[tie.to] += sizes[piece];
            }
        }
        let cheapest = *self.tied.iter().min_by_key(|&&piece| (sizes[piece], piece))?;
        let mut loose = vec![false; self.ties.len()];
        loose[cheapest] = true;
        // In the order of tying: what a piece hangs on is decided before it.
        for &piece in &self.tied {
            loose[piece] |= self.ties[piece].as_ref().is_some_and(|tie| loose[tie.to]);
        }
        Some(loose)
    }
}
