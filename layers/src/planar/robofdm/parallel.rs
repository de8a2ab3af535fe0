//! Maps that are shared out among threads, if there are any: the order of the results is that of the items.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// What comes of each item.
#[cfg(feature = "rayon")]
pub(super) fn mapped<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    items.par_iter().map(of).collect()
}

/// What comes of each item.
#[cfg(not(feature = "rayon"))]
pub(super) fn mapped<T, R>(items: &[T], of: impl Fn(&T) -> R) -> Vec<R> {
    items.iter().map(of).collect()
}
