//! An allocator that ends the run above a limit of live bytes: the fuzzer itself looks at the memory of the process once a second only.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Live bytes at most: a gigabyte.
const MAX_BYTES: usize = 1 << 30;

static LIVE: AtomicUsize = AtomicUsize::new(0);

pub struct Limited;

fn grow(bytes: usize) {
    let live = LIVE.fetch_add(bytes, Ordering::Relaxed) + bytes;
    if live > MAX_BYTES {
        LIVE.store(0, Ordering::Relaxed); // the report needs memory, too
        eprintln!("out of memory: {live} bytes are live, {bytes} of them asked for now");
        eprintln!("{}", std::backtrace::Backtrace::force_capture());
        std::process::abort(); // a panic must not leave an allocator
    }
}

// SAFETY: all calls go to the system's allocator unchanged.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        let _ =
            LIVE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |live| Some(live.saturating_sub(layout.size())));
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        match size.checked_sub(layout.size()) {
            Some(more) => grow(more),
            None => {
                let less = layout.size() - size;
                let _ = LIVE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |live| Some(live.saturating_sub(less)));
            }
        }
        unsafe { System.realloc(memory, layout, size) }
    }
}
