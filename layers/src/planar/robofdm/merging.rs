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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::robofdm::TuningOptions;
    use crate::planar::robofdm::state::Node;
    use crate::planar::{CutPlane, Solid};
    use nalgebra::{Point3, Vector3};

    /// A post of 10 by 10 by 30 mm and an arm of 30 mm at its top, 10 mm thick.
    fn ell() -> Solid {
        let outline = [[0, 0], [10, 0], [10, 20], [40, 20], [40, 30], [10, 30], [0, 30], [0, 20]];
        let at = |y: f64| outline.map(|[x, z]| Point3::new(f64::from(x), y, f64::from(z)));
        let quad = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let faces = [[0, 1, 2, 7], [7, 2, 5, 6], [2, 3, 4, 5]];
        let back = faces.map(|[a, b, c, d]| [d + 8, c + 8, b + 8, a + 8]);
        let sides = [0, 1, 2, 3, 4, 5, 6, 7].map(|a| [(a + 1) % 8, a, a + 8, (a + 1) % 8 + 8]);
        let triangles: Vec<_> = faces.into_iter().chain(back).chain(sides).flat_map(quad).collect();
        Solid::new(&[at(0.0), at(10.0)].concat(), &triangles).unwrap()
    }

    /// Cuts the first part by a plane, whether that pays or not.
    fn cut(state: &mut State, plane: &CutPlane) {
        let cell = state.nodes[0].cell;
        let cut = Arc::make_mut(&mut state.partition).cut(&[cell], plane);
        state.nodes[0] = Node::new(cut.below[0], state.up, None);
        state.nodes.insert(1, Node::new(cut.above[0], plane.normal(), Some(*plane)));
        state.refresh(&[cell]);
    }

    /// Printed upright the arm hangs over, sideways it does not. A post cut in two gains nothing.
    #[test]
    fn parts_are_merged_where_that_costs_nothing_or_there_are_too_many() {
        let merged = |max_parts: usize| {
            let mut state =
                State::whole(&ell(), Vector3::z(), &TuningOptions { max_parts, ..TuningOptions::default() });
            assert!((state.risky() - 300.0).abs() < 1e-6, "{}", state.risky());
            for (at, normal) in [([10.0, 5.0, 20.0], [1.0, 0.0, 0.6]), ([5.0, 5.0, 10.0], [0.0, 0.0, 1.0])] {
                cut(&mut state, &CutPlane::through(&at.into(), &normal.into()).unwrap());
            }
            assert!(state.nodes.len() == 3 && state.risky() < 1e-6, "{} {}", state.nodes.len(), state.risky());
            state.merge();
            (state.nodes.len(), state.risky().round() as u32)
        };
        assert_eq!([40, 3, 2, 1].map(merged), [(2, 0), (2, 0), (2, 0), (1, 300)]);
    }
}
