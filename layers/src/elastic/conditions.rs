//! What a user gives: regions, supports, loads; and what they are at the nodes.

use super::ElasticError;
use super::error::BoundaryCondition;
use super::nodes::{EIGHT, NONE, Points};
use super::operator::Triple;
use nalgebra::{Point3, Vector3};

/// Places this close to a region belong to it, in cells: rounding of millimetres. Nodes and centres of faces are half a cell apart.
const ROUNDING: f64 = 1e-6;

/// A box in millimetres, in the frame of the grid: its corner is the origin, node `[x, y, z]` lies at `cell_mm * [x, y, z]`. What lies on the
/// border belongs to it; a side may be infinite, and two may be at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Region {
    /// Lower corner.
    pub low_mm: [f64; 3],
    /// Upper corner.
    pub high_mm: [f64; 3],
}

impl Region {
    /// All there is.
    pub const EVERYWHERE: Region = Region { low_mm: [f64::NEG_INFINITY; 3], high_mm: [f64::INFINITY; 3] };

    /// What lies on the plane at `at_mm` across an axis (0, 1 or 2 for x, y or z).
    ///
    /// # Panics
    /// If there is no such axis.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::elastic::Region;
    /// let plate = Region::plane(2, 0.0);
    /// assert_eq!((plate.low_mm[2], plate.high_mm[2], plate.high_mm[0]), (0.0, 0.0, f64::INFINITY));
    /// ```
    pub fn plane(axis: usize, at_mm: f64) -> Region {
        let mut region = Self::EVERYWHERE;
        (region.low_mm[axis], region.high_mm[axis]) = (at_mm, at_mm);
        region
    }

    fn holds(&self, point: Point3<f64>, cell_mm: f64) -> bool {
        let slack = ROUNDING * cell_mm;
        (0..3).all(|k| self.low_mm[k] - slack <= point[k] && point[k] <= self.high_mm[k] + slack)
    }

    fn is_number(&self) -> bool {
        !self.low_mm.iter().chain(&self.high_mm).any(|side| side.is_nan())
    }
}

/// Nodes that are held.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Support {
    /// The nodes in it are.
    pub region: Region,
    /// How far they are moved along x, y and z, in millimetres: `Some(0.0)` holds them where they are, `None` leaves them free.
    pub displacement_mm: [Option<f64>; 3],
}

impl Support {
    /// Holds all nodes of a region where they are.
    pub fn fixed(region: Region) -> Support {
        Support { region, displacement_mm: [Some(0.0); 3] }
    }
}

/// What pulls or pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Load {
    /// A force, spread evenly over the outer faces of cells whose centres lie in the region.
    Force {
        /// Where.
        region: Region,
        /// All of it, in N.
        newtons: [f64; 3],
    },
    /// A force for each area of the outer faces of cells whose centres lie in the region.
    Traction {
        /// Where.
        region: Region,
        /// In MPa (N/mm²).
        mpa: [f64; 3],
    },
    /// A force for each volume of all cells, such as a weight.
    Body {
        /// In N/mm³.
        newtons_mm3: [f64; 3],
    },
}

/// The six steps across the faces of a cell, and the corners of each.
#[rustfmt::skip]
pub(super) const FACES: [([i32; 3], [usize; 4]); 6] = [
    ([-1, 0, 0], [0, 2, 4, 6]), ([1, 0, 0], [1, 3, 5, 7]),
    ([0, -1, 0], [0, 1, 4, 5]), ([0, 1, 0], [2, 3, 6, 7]),
    ([0, 0, -1], [0, 1, 2, 3]), ([0, 0, 1], [4, 5, 6, 7]),
];

/// The cells and nodes that supports and loads meet.
pub(super) struct Places<'a> {
    pub(super) cells: &'a Points,
    pub(super) nodes: &'a Points,
    /// The nodes of each cell.
    pub(super) corners: &'a [[u32; 8]],
    pub(super) cell_mm: f64,
}

impl Places<'_> {
    pub(super) fn node(&self, node: usize) -> Point3<f64> {
        Point3::from(self.nodes.place(node).map(|k| f64::from(k) * self.cell_mm))
    }

    fn empty(&self, what: BoundaryCondition, number: usize) -> ElasticError {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for node in 0..self.nodes.len() {
            let point = self.node(node);
            (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k])));
        }
        ElasticError::EmptyRegion { what, number, low, high }
    }

    /// Which components of each node are held, as bits, and where they are moved to.
    pub(super) fn supported(&self, supports: &[Support]) -> Result<(Vec<u8>, Vec<Triple>), ElasticError> {
        let mut fixed = vec![0u8; self.nodes.len()];
        let mut moved: Vec<Triple> = vec![[0.0; 3]; self.nodes.len()];
        for (number, support) in supports.iter().enumerate() {
            if !support.region.is_number() || support.displacement_mm.iter().flatten().any(|d| !d.is_finite()) {
                return Err(ElasticError::NotFinite { what: BoundaryCondition::Support, number });
            }
            let mut any = false;
            for node in (0..self.nodes.len()).filter(|&node| support.region.holds(self.node(node), self.cell_mm)) {
                any = true;
                for (axis, second) in support.displacement_mm.iter().enumerate().filter_map(|(k, d)| Some((k, (*d)?))) {
                    let first = moved[node][axis];
                    if fixed[node] >> axis & 1 == 1 && first.to_bits() != (second + 0.0).to_bits() {
                        let node = self.nodes.place(node);
                        return Err(ElasticError::Contradiction { support: number, node, axis, first, second });
                    }
                    fixed[node] |= 1 << axis;
                    moved[node][axis] = second + 0.0; // no negative zero
                }
            }
            if !any {
                return Err(self.empty(BoundaryCondition::Support, number));
            }
        }
        if fixed.iter().all(|&bits| bits == 0) { Err(ElasticError::NoSupport) } else { Ok((fixed, moved)) }
    }

    /// The forces at the nodes.
    pub(super) fn forces(&self, loads: &[Load]) -> Result<Vec<Triple>, ElasticError> {
        let mut forces = vec![[0.0; 3]; self.nodes.len()];
        for (number, load) in loads.iter().enumerate() {
            let (region, vector) = match load {
                Load::Force { region, newtons } => (*region, newtons),
                Load::Traction { region, mpa } => (*region, mpa),
                Load::Body { newtons_mm3 } => (Region::EVERYWHERE, newtons_mm3),
            };
            if !region.is_number() || vector.iter().any(|k| !k.is_finite()) {
                return Err(ElasticError::NotFinite { what: BoundaryCondition::Load, number });
            }
            let mut push = |node: u32, share: f64| (0..3).for_each(|k| forces[node as usize][k] += share * vector[k]);
            if let Load::Body { .. } = load {
                let share = self.cell_mm.powi(3) / 8.0;
                self.corners.iter().flatten().for_each(|&node| push(node, share));
                continue;
            }
            let faces = self.outer_faces(&region);
            if faces.is_empty() {
                return Err(self.empty(BoundaryCondition::Load, number));
            }
            let area = match load {
                Load::Force { .. } => 1.0 / faces.len() as f64,
                _ => self.cell_mm * self.cell_mm,
            };
            faces.iter().flatten().for_each(|&node| push(node, area / 4.0));
        }
        Ok(forces)
    }

    /// The nodes of outer faces with their centre in the region.
    fn outer_faces(&self, region: &Region) -> Vec<[u32; 4]> {
        let mut faces = Vec::new();
        for cell in 0..self.cells.len() {
            let place = self.cells.place(cell);
            let centre = place.map(|k| f64::from(k) + 0.5);
            for (step, corners) in &FACES {
                let middle = Vector3::from(centre) + Vector3::from(step.map(|k| f64::from(k) / 2.0));
                if region.holds(Point3::from(middle * self.cell_mm), self.cell_mm)
                    && self.cells.step(place, *step) == NONE
                {
                    faces.push(corners.map(|k| self.corners[cell][k]));
                }
            }
        }
        faces
    }

    /// For each cell the number of the piece that hangs together with it through common faces, and how many pieces there are.
    pub(super) fn pieces(&self) -> (Vec<u32>, usize) {
        let mut piece_of = vec![NONE; self.cells.len()];
        let mut pieces = 0;
        for first in 0..piece_of.len() {
            if piece_of[first] != NONE {
                continue;
            }
            piece_of[first] = pieces;
            let mut waiting = vec![first];
            while let Some(cell) = waiting.pop() {
                let place = self.cells.place(cell);
                for (step, _) in &FACES {
                    let next = self.cells.step(place, *step);
                    if next != NONE && piece_of[next as usize] == NONE {
                        piece_of[next as usize] = pieces;
                        waiting.push(next as usize);
                    }
                }
            }
            pieces += 1;
        }
        (piece_of, pieces as usize)
    }

    /// For each cell the nodes in use.
    pub(super) fn nodes_of(&self, cell: usize) -> [usize; 8] {
        EIGHT.map(|k| self.corners[cell][k] as usize)
    }
}
