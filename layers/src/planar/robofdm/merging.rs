//! Region merging (section 2.4.3): parts go back to earlier ones as long as nothing gets worse, or there are more than are allowed.

use super::risk::RiskModel;
use super::state::State;
use crate::planar::solid::Wall;
use std::sync::Arc;

impl State {
    /// Merges parts with earlier ones as long as nothing gets worse, and while there are too many, where that is possible at all.
    pub(super) fn merge(&mut self) {
        loop {
            let before = self.risky();
            let are_too_many = self.nodes.len() > self.options.max_parts;
            let mut choices: Vec<(f64, usize, usize)> = Vec::new();
            for later in 1..self.nodes.len() {
                // What lies between them in the order must not carry the later one.
                let Some(&earlier) = self.touched(later).last() else { continue };
                let risky = before + self.merged(earlier, later).1;
                if are_too_many || risky <= before * (1.0 + 1e-12) {
                    choices.push((risky, earlier, later));
                }
            }
            choices.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some(&(_, earlier, later)) =
                choices.iter().find(|&&(_, earlier, later)| self.is_mergeable(earlier, later))
            else {
                return;
            };
            let cells = [earlier, later].map(|node| self.nodes[node].cell);
            Arc::make_mut(&mut self.partition).merge(cells[0], cells[1]);
            self.nodes.remove(later);
            self.refresh(&cells);
        }
    }

    /// The walls of both parts as one, and by how much the risky area of all parts would rise.
    fn merged(&self, earlier: usize, later: usize) -> (Vec<Wall>, f64) {
        let [first, second] = [earlier, later].map(|node| &self.nodes[node]);
        let own = first.walls.iter().filter(|wall| wall.beyond != Some(second.cell));
        let walls: Vec<Wall> =
            own.chain(second.walls.iter().filter(|wall| wall.beyond != Some(first.cell))).copied().collect();
        let mut rise = self.judge(earlier, &walls).risky(&walls) - first.risky - second.risky;
        // What is printed between them stands on the later part then.
        for (at, node) in self.nodes.iter().enumerate().take(later).skip(earlier + 1) {
            if node.walls.iter().any(|wall| wall.beyond == Some(second.cell)) {
                let mut judge: RiskModel = self.judge(at, &node.walls);
                judge.earlier.push(second.cell);
                rise += judge.risky(&node.walls) - node.risky;
            }
        }
        (walls, rise)
    }

    /// Whether both parts together bound a solid, and the head passes: on its way around the larger part, and past what stands earlier then.
    fn is_mergeable(&self, earlier: usize, later: usize) -> bool {
        let (walls, _) = self.merged(earlier, later);
        let standing = |end: usize| self.nodes[..end].iter().map(|node| &node.walls[..]);
        let between = &self.nodes[earlier + 1..later];
        let cells = [earlier, later].map(|node| self.nodes[node].cell);
        let mut whole = self.partition.only(&cells);
        whole.merge(cells[0], cells[1]);
        self.head_passes(&self.nodes[earlier].direction, &walls, standing(earlier))
            && between
                .iter()
                .all(|node| self.head_passes(&node.direction, &node.walls, [&self.nodes[later].walls[..]].into_iter()))
            && whole.part(cells[0]).is_ok()
    }
}
