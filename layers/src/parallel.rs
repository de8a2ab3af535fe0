//! Work shared out among threads, with the same result on any number of them; on one thread without the feature `rayon`.

use crate::{Progress, ProgressFn};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Entries that one piece of work holds: some ten microseconds of a stencil, so that handing it out costs nothing beside it. Sums are
/// sums over these pieces, so another number changes their last bits.
const PIECE: usize = 512;

/// Writes `of(k)` into each entry `k`.
pub(crate) fn fill<T: Send>(out: &mut [T], of: impl Fn(usize) -> T + Send + Sync) {
    update(out, |k, entry| *entry = of(k));
}

/// Changes each entry by `change(k, entry)`.
pub(crate) fn update<T: Send>(out: &mut [T], change: impl Fn(usize, &mut T) + Send + Sync) {
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

/// `of(k)` for each `k` below `count`, in their order, for light work: a thread takes a piece at a time.
pub(crate) fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    in_parallel(count, PIECE, of)
}

/// The sum of `of(k)` over all `k` below `count`: piece by piece, the pieces one after the other.
pub(crate) fn sum(count: usize, of: impl Fn(usize) -> f64 + Send + Sync) -> f64 {
    let piece = |piece: usize| (piece * PIECE..count.min((piece + 1) * PIECE)).map(&of).sum::<f64>();
    in_parallel(count.div_ceil(PIECE), 1, piece).into_iter().sum()
}

/// `of` for all numbers below `count`, in their order; with the feature `rayon` by several threads, which take `share` of them at a time: no
/// more, as a thread would stand idle while another goes through what takes long.
#[cfg_attr(not(feature = "rayon"), allow(unused_variables))]
pub(crate) fn in_parallel<R: Send>(count: usize, share: usize, of: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().with_min_len(share).with_max_len(share).map(of).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(of).collect()
}

/// The same in stage `stage`, with a report after each; `None` if cancelled. `of` is handed what reports how far all of them
/// have come, to ask in between whether to go on.
pub(crate) fn in_parallel_watched<R: Send>(
    count: usize,
    stage: &'static str,
    progress: ProgressFn,
    of: impl Fn(usize, ProgressFn) -> R + Send + Sync,
) -> Option<Vec<R>> {
    let (done, cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
    let report = |add: u64| {
        let done = done.fetch_add(add, Ordering::Relaxed) + add;
        let go_on =
            !cancelled.load(Ordering::Relaxed) && progress(Progress { stage, done, total: count as u64 }).is_continue();
        cancelled.fetch_or(!go_on, Ordering::Relaxed);
        if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let one = |k: usize| {
        if cancelled.load(Ordering::Relaxed) {
            return None;
        }
        let result = of(k, &|_| report(0));
        report(1).is_continue().then_some(result)
    };
    in_parallel(count, 1, one).into_iter().collect()
}

/// What comes of each item, in their order.
pub(crate) fn map_items<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Send + Sync) -> Vec<R> {
    in_parallel(items.len(), 1, |k| of(&items[k]))
}
