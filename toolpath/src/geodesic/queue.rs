//! A queue that is sorted up to the width of its buckets.
//!
//! The order of propagation decides about the work, not about the result, so rough order at constant cost wins over
//! exact order at logarithmic cost (Xu et al. 2015, the "fast wavefront").

/// Items by key, lowest bucket first, within a bucket in the order they came.
#[derive(Debug)]
pub(super) struct BucketQueue {
    buckets: Vec<Vec<u32>>,
    width: f64,
    /// The bucket that is being emptied, and how much of it is done.
    current: usize,
    taken: usize,
    /// Keys beyond the last bucket go into it.
    most: usize,
}

impl BucketQueue {
    pub fn new(width: f64, most: usize) -> Self {
        BucketQueue { buckets: Vec::new(), width, current: 0, taken: 0, most }
    }

    /// Keys that differ by less count as equal.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Keys below that of the current bucket join it.
    pub fn push(&mut self, key: f64, item: u32) {
        let bucket = ((key / self.width) as usize).min(self.most).max(self.current);
        if bucket >= self.buckets.len() {
            self.buckets.resize_with(bucket + 1, Vec::new);
        }
        self.buckets[bucket].push(item);
    }

    pub fn pop(&mut self) -> Option<u32> {
        loop {
            let bucket = self.buckets.get_mut(self.current)?;
            if let Some(&item) = bucket.get(self.taken) {
                self.taken += 1;
                return Some(item);
            }
            *bucket = Vec::new();
            self.taken = 0;
            self.current += 1;
        }
    }
}
