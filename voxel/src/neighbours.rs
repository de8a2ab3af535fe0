//! Which cells are neighbours.

use crate::VoxelGrid;

/// What two cells must share to be neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Connectivity {
    /// A face: 6 neighbours.
    Face6,
    /// An edge at least: 18 neighbours, those that support a cell in a curved layer.
    #[default]
    Edge18,
    /// A corner at least: 26 neighbours.
    Vertex26,
}

/// All steps to a neighbour: the first 6 share a face, the first 18 an edge.
const OFFSETS: [[i32; 3]; 26] = offsets();

impl Connectivity {
    /// The steps from a cell to its neighbours: first over faces, then over edges, then over corners, and within
    /// each by z, then y, then x.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::Connectivity;
    /// assert_eq!(Connectivity::Face6.offsets()[0], [0, 0, -1]);
    /// assert_eq!(Connectivity::Edge18.offsets().len(), 18);
    /// ```
    pub fn offsets(self) -> &'static [[i32; 3]] {
        match self {
            Connectivity::Face6 => &OFFSETS[..6],
            Connectivity::Edge18 => &OFFSETS[..18],
            Connectivity::Vertex26 => &OFFSETS,
        }
    }
}

impl VoxelGrid {
    /// The neighbours of `cell` that are in the set, in the order of [`Connectivity::offsets`]. The cell itself need
    /// not be in the set.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{Connectivity, VoxelGrid};
    /// let block = VoxelGrid::from_fn([3, 3, 3], |_| true)?;
    /// assert_eq!(block.neighbours([1, 1, 1], Connectivity::Edge18).count(), 18);
    /// let corner: Vec<_> = block.neighbours([0, 0, 0], Connectivity::Face6).collect();
    /// assert_eq!(corner, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    /// # Ok::<(), curvlay_voxel::GridError>(())
    /// ```
    pub fn neighbours(&self, cell: [u32; 3], by: Connectivity) -> impl Iterator<Item = [u32; 3]> + use<'_> {
        by.offsets().iter().filter_map(move |step| {
            let to = [
                cell[0].checked_add_signed(step[0])?,
                cell[1].checked_add_signed(step[1])?,
                cell[2].checked_add_signed(step[2])?,
            ];
            self.contains(to).then_some(to)
        })
    }
}

const fn offsets() -> [[i32; 3]; 26] {
    let mut all = [[0; 3]; 26];
    let (mut filled, mut steps) = (0, 1);
    while steps <= 3 {
        let mut at = 0;
        while at < 27 {
            let step = [at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1];
            if step[0] * step[0] + step[1] * step[1] + step[2] * step[2] == steps {
                all[filled] = step;
                filled += 1;
            }
            at += 1;
        }
        steps += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_occurs_once_with_its_opposite() {
        let all = Connectivity::Vertex26.offsets();
        for step in all {
            assert_eq!(all.iter().filter(|other| *other == step).count(), 1);
            assert!(all.contains(&step.map(|s| -s)));
        }
        let taxicab = |step: &[i32; 3]| step.iter().map(|s| s.abs()).sum::<i32>();
        assert!(Connectivity::Face6.offsets().iter().all(|step| taxicab(step) == 1));
        assert!(Connectivity::Edge18.offsets().iter().all(|step| taxicab(step) <= 2));
    }
}
