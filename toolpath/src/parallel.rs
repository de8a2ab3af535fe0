//! The same work for many things, on all threads with the feature `rayon`; the results stand in the order of the things.

use crate::{Progress, ProgressFn};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// `None` if cancelled.
pub(crate) fn map<T: Sync, R: Send>(
    things: &[T],
    stage: &'static str,
    progress: ProgressFn,
    work: impl Fn(usize, &T) -> R + Sync,
) -> Option<Vec<R>> {
    let (done, stopped) = (AtomicU64::new(0), AtomicBool::new(false));
    let total = things.len() as u64;
    let one = |(k, thing): (usize, &T)| {
        if stopped.load(Ordering::Relaxed) {
            return None;
        }
        let result = work(k, thing);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if progress(Progress { stage, done, total }).is_break() {
            stopped.store(true, Ordering::Relaxed);
            return None;
        }
        Some(result)
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        // One by one: the work for things differs so much that a thread would stand idle while another goes through its share.
        things.par_iter().with_max_len(1).enumerate().map(one).collect()
    }
    #[cfg(not(feature = "rayon"))]
    {
        things.iter().enumerate().map(one).collect()
    }
}
