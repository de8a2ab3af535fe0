//! Sets of numbers that are joined: a forest in which each set is a tree.

/// The root of the tree of an item. Halves the way on passing.
pub(crate) fn root(parents: &mut [u32], mut item: u32) -> u32 {
    while parents[item as usize] != item {
        let up = parents[parents[item as usize] as usize];
        parents[item as usize] = up;
        item = up;
    }
    item
}

/// Joins the sets of two items. The lower of their roots becomes the root of both.
pub(crate) fn join(parents: &mut [u32], one: u32, other: u32) {
    let [a, b] = [one, other].map(|item| root(parents, item));
    parents[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::{join, root};

    #[test]
    fn the_least_item_of_a_set_is_its_root() {
        let mut parents: Vec<u32> = (0..6).collect();
        for (one, other) in [(5, 3), (3, 4), (1, 2), (4, 1), (2, 5)] {
            join(&mut parents, one, other);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|item| root(&mut parents, item)), [0, 1, 1, 1, 1, 1]);
    }
}
