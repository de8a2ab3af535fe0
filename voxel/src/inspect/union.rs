//! Sets that are joined: which things hang together.

pub(crate) struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    pub(crate) fn new(len: usize) -> Self {
        UnionFind { parent: (0..len as u32).collect() }
    }

    /// The least member of the set of `of`.
    pub(crate) fn find(&mut self, mut of: u32) -> u32 {
        while self.parent[of as usize] != of {
            // Every second step is shortened, so that long chains vanish.
            self.parent[of as usize] = self.parent[self.parent[of as usize] as usize];
            of = self.parent[of as usize];
        }
        of
    }

    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
