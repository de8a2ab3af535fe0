//! Sets of numbers that are joined: a forest in which each set is a tree.

/// Items from 0 on, each in one set. A set is known by its root.
pub(crate) struct UnionFind {
    parents: Vec<u32>,
}

impl UnionFind {
    /// Items that are all alone.
    pub(crate) fn new(items: usize) -> Self {
        UnionFind { parents: (0..items as u32).collect() }
    }

    /// The root of the set of an item. Halves the way on passing.
    pub(crate) fn root(&mut self, mut item: u32) -> u32 {
        while self.parents[item as usize] != item {
            let up = self.parents[self.parents[item as usize] as usize];
            self.parents[item as usize] = up;
            item = up;
        }
        item
    }

    /// Whether an item is the root of its set.
    pub(crate) fn is_root(&self, item: u32) -> bool {
        self.parents[item as usize] == item
    }

    /// Joins two sets. The lower root becomes that of both: if all sets are joined so, the root is the least item.
    pub(crate) fn join(&mut self, one: u32, other: u32) {
        let [a, b] = [one, other].map(|item| self.root(item));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Joins the set of `other` to that of `one`, whose root stays. Both roots, or `None` if they were in one set.
    pub(crate) fn join_to(&mut self, one: u32, other: u32) -> Option<[u32; 2]> {
        let [a, b] = [one, other].map(|item| self.root(item));
        self.parents[b as usize] = a;
        (a != b).then_some([a, b])
    }
}

#[cfg(test)]
mod tests {
    use super::UnionFind;

    #[test]
    fn the_least_item_of_a_set_is_its_root() {
        let mut sets = UnionFind::new(6);
        for (one, other) in [(5, 3), (3, 4), (1, 2), (4, 1), (2, 5)] {
            sets.join(one, other);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|item| sets.root(item)), [0, 1, 1, 1, 1, 1]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|item| sets.is_root(item)), [true, true, false, false, false, false]);
    }

    #[test]
    fn the_set_that_others_are_joined_to_keeps_its_root() {
        let mut sets = UnionFind::new(4);
        assert_eq!(sets.join_to(3, 0), Some([3, 0]));
        assert_eq!(sets.join_to(0, 1), Some([3, 1]));
        assert_eq!(sets.join_to(1, 3), None);
        assert_eq!([0, 1, 2, 3].map(|item| sets.root(item)), [3, 3, 2, 3]);
    }
}
