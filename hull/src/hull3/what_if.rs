//! What-ifs: a journal of changes, undone from the last to the first.

use super::body::ConvexHull;
use super::parts::Undo;

/// A state of a hull to go back to.
#[derive(Debug)]
#[must_use = "a checkpoint is given back to `rollback` or `commit`"]
pub struct Checkpoint {
    journal: usize,
    points: usize,
    newest: u32,
}

impl ConvexHull {
    /// Starts a what-if: everything from here on can be taken back. What-ifs may be nested.
    pub fn checkpoint(&mut self) -> Checkpoint {
        self.checkpoints += 1;
        Checkpoint { journal: self.journal.len(), points: self.points.len(), newest: self.newest }
    }

    /// Takes back everything since `checkpoint`, exactly. Costs as much as was changed. With a checkpoint of another hull it takes back
    /// as much as this one has noted since then, by count, which is of no use.
    pub fn rollback(&mut self, checkpoint: Checkpoint) {
        while self.journal.len() > checkpoint.journal {
            match self.journal.pop() {
                Some(Undo::Point) => {
                    self.points.pop();
                }
                Some(Undo::Linked { facet, edge, across }) => self.facets[facet as usize].across[edge] = across,
                Some(Undo::Removed { facet, plane, triangle }) => {
                    self.walls.set(facet, &plane);
                    self.facets[facet as usize] = triangle;
                    self.free.pop();
                }
                Some(Undo::Made { facet, reused: true }) => {
                    self.walls.take(facet);
                    self.free.push(facet);
                }
                Some(Undo::Made { reused: false, .. }) => {
                    self.walls.pop();
                    self.facets.pop();
                }
                Some(Undo::Flat(flat)) => {
                    self.flat = flat;
                    self.points.clear();
                    self.walls.clear();
                    self.facets.clear();
                    self.free.clear();
                }
                None => break,
            }
        }
        self.newest = checkpoint.newest;
        self.checkpoints = self.checkpoints.saturating_sub(1);
    }

    /// Ends the what-if that the checkpoint began, and keeps what was inserted.
    pub fn commit(&mut self, _checkpoint: Checkpoint) {
        self.checkpoints = self.checkpoints.saturating_sub(1);
        if self.checkpoints == 0 {
            self.journal.clear();
        }
    }

    /// The points inserted since `checkpoint` that extended the body when they came; later ones may have covered them.
    /// Points count from when the body has volume: until then there are none, and those that give it volume are all
    /// in the answer.
    pub fn added_since(&self, checkpoint: &Checkpoint) -> &[[i32; 3]] {
        &self.points[checkpoint.points.min(self.points.len())..]
    }

    pub(super) fn log(&mut self, undo: Undo) {
        if self.checkpoints > 0 {
            self.journal.push(undo);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Depth;

    /// The journal costs memory, so it is kept only as long as something may be taken back.
    #[test]
    fn the_journal_is_kept_while_a_what_if_is_open() {
        let mut hull = ConvexHull::new(Depth::SURFACE);
        hull.insert(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]).unwrap();
        assert!(hull.journal.is_empty());
        let outer = hull.checkpoint();
        hull.insert(&[[5, 5, 5]]).unwrap();
        let noted = hull.journal.len();
        assert!(noted > 0);
        let inner = hull.checkpoint();
        hull.insert(&[[6, 6, 6]]).unwrap();
        hull.commit(inner);
        assert!(hull.journal.len() > noted, "the outer what-if may still be taken back");
        hull.commit(outer);
        assert!(hull.journal.is_empty());
        hull.insert(&[[7, 7, 7]]).unwrap();
        assert!(hull.journal.is_empty());
    }
}
