//! Work on all nodes by several threads, with the same result on any number of them.

/// Entries that one piece of work holds: some ten microseconds of a stencil, so that handing it out costs nothing beside it. Sums are
/// sums over these pieces, so another number changes their last bits.
const PIECE: usize = 512;

/// Writes `of(k)` into each entry `k`.
pub(super) fn fill<T: Send>(out: &mut [T], of: impl Fn(usize) -> T + Send + Sync) {
    let fill_piece = |(piece, out): (usize, &mut [T])| {
        out.iter_mut().enumerate().for_each(|(k, entry)| *entry = of(piece * PIECE + k));
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        out.par_chunks_mut(PIECE).enumerate().for_each(fill_piece);
    }
    #[cfg(not(feature = "rayon"))]
    out.chunks_mut(PIECE).enumerate().for_each(fill_piece);
}

/// Changes each entry by `change(k, entry)`.
pub(super) fn update<T: Send>(out: &mut [T], change: impl Fn(usize, &mut T) + Send + Sync) {
    let update_piece = |(piece, out): (usize, &mut [T])| {
        out.iter_mut().enumerate().for_each(|(k, entry)| change(piece * PIECE + k, entry));
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        out.par_chunks_mut(PIECE).enumerate().for_each(update_piece);
    }
    #[cfg(not(feature = "rayon"))]
    out.chunks_mut(PIECE).enumerate().for_each(update_piece);
}

/// `of(k)` for each `k` below `count`, in their order.
pub(super) fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().with_min_len(PIECE).map(of).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(of).collect()
}

/// The sum of `of(k)` over all `k` below `count`: piece by piece, the pieces one after the other.
pub(super) fn sum(count: usize, of: impl Fn(usize) -> f64 + Send + Sync) -> f64 {
    let mut pieces = vec![0.0; count.div_ceil(PIECE)];
    let sum_piece = |piece: usize| (piece * PIECE..count.min((piece + 1) * PIECE)).map(&of).sum::<f64>();
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        pieces.par_iter_mut().enumerate().for_each(|(piece, sum)| *sum = sum_piece(piece));
    }
    #[cfg(not(feature = "rayon"))]
    pieces.iter_mut().enumerate().for_each(|(piece, sum)| *sum = sum_piece(piece));
    pieces.into_iter().sum()
}
