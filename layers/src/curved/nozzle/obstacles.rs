//! What a nozzle would hit: cells in an octree, and for each direction the offsets near the tip.
//!
//! A cell in the way is nearly always beside the tip, so these offsets are tried first, nearest first. Else the nozzle
//! is held against the nodes of the octree, and against the cells of the leaves that it comes near.

use super::octree::Octree;
use super::rule::{NozzleRule, ROUNDING, Shape};
use crate::cells::CellSet;
use nalgebra::{UnitVector3, Vector3};
use std::ops::ControlFlow::{self, Break, Continue};

/// Offsets up to so many cells along each axis are near. With more the lists get longer than a look at the octree.
const NEAR: i32 = 4;

/// The tip is so far above the centre of its cell along its direction, in cells: on top of the bead that fills the cell.
pub(super) const TIP_ABOVE_CENTRE: f64 = 0.5;

/// Cells in the way, and the directions in which they may be.
#[derive(Clone)]
pub(crate) struct Obstacles {
    shape: Shape,
    directions: Vec<UnitVector3<f64>>,
    /// For each direction the offsets at which a cell is hit, nearest first.
    near: Vec<Vec<[i32; 3]>>,
    /// Lattice height of the plate, in cells.
    plate: f64,
    set: CellSet,
    /// The cells of `set`.
    octree: Octree,
}

impl Obstacles {
    /// All cells of `set`, on a plate at the height `plate` in cells.
    pub(crate) fn new(rule: &NozzleRule, cell_mm: f64, plate: f64, set: CellSet) -> Self {
        let (shape, directions) = (Shape::new(rule, cell_mm), rule.directions());
        let mut around: Vec<[i32; 3]> = Vec::new();
        for z in -NEAR..=NEAR {
            for y in -NEAR..=NEAR {
                around.extend((-NEAR..=NEAR).map(|x| [x, y, z]));
            }
        }
        around.retain(|offset| *offset != [0; 3]);
        // Stable, so that of equally near ones the order is the same each time.
        around.sort_by_key(|offset| offset.iter().map(|k| k * k).sum::<i32>());
        let hit = |offset: &[i32; 3], direction| is_hit(&shape, direction, Vector3::from(offset.map(f64::from)));
        let near =
            directions.iter().map(|d| around.iter().copied().filter(|offset| hit(offset, d)).collect()).collect();
        let mut obstacles = Obstacles { shape, directions, near, plate, octree: Octree::none(set.dims()), set };
        let cells: Vec<u32> = obstacles.set.iter().collect();
        cells.into_iter().for_each(|cell| obstacles.flip(cell));
        obstacles
    }

    fn position(&self, cell: u32) -> [u32; 3] {
        let [nx, ny, _] = self.set.dims();
        [cell % nx, cell / nx % ny, cell / nx / ny]
    }

    /// Puts the cell into the octree, or takes it out: `set` says whether it is there, and both change together.
    fn flip(&mut self, cell: u32) {
        self.octree.flip(self.position(cell));
    }

    pub(super) fn contains(&self, cell: u32) -> bool {
        self.set.contains(cell)
    }

    /// The cells that are in the way.
    pub(crate) fn set(&self) -> &CellSet {
        &self.set
    }

    pub(crate) fn remove(&mut self, cell: u32) {
        if self.set.contains(cell) {
            self.set.remove(cell);
            self.flip(cell);
        }
    }

    pub(crate) fn insert(&mut self, cell: u32) {
        if self.set.insert(cell) {
            self.flip(cell);
        }
    }

    /// Whether the nozzle stays above the plate with its tip at the cell.
    pub(crate) fn clears_plate(&self, cell: u32, direction: usize) -> bool {
        self.is_above_plate(cell, self.directions[direction].z)
    }

    fn is_above_plate(&self, cell: u32, up: f64) -> bool {
        let tip = f64::from(self.position(cell)[2]) + 0.5 + TIP_ABOVE_CENTRE * up;
        tip - self.shape.below_tip(up) >= self.plate - ROUNDING
    }

    /// Whether the nozzle meets neither the plate nor a cell with its tip at this one, in a direction of the caller's.
    pub(crate) fn is_free(&self, cell: u32, direction: &UnitVector3<f64>) -> bool {
        self.is_above_plate(cell, direction.z) && self.any_hit(cell, direction).is_none()
    }

    /// A cell that the nozzle would hit with its tip at this one.
    pub(crate) fn hit(&self, cell: u32, direction: usize) -> Option<u32> {
        let near = self.set.around(cell, &self.near[direction]).next();
        near.or_else(|| self.any_hit(cell, &self.directions[direction]))
    }

    /// Whether the nozzle stays above the plate with its tip at the cell, in a direction of the caller's.
    pub(crate) fn clears_plate_in(&self, cell: u32, direction: &UnitVector3<f64>) -> bool {
        self.is_above_plate(cell, direction.z)
    }

    fn any_hit(&self, cell: u32, direction: &UnitVector3<f64>) -> Option<u32> {
        let mut hit = None;
        self.each_hit(cell, direction, |other| {
            hit = Some(other);
            Break(())
        });
        hit
    }

    /// Visits the cells that the nozzle would hit with its tip at this one, until `visit` breaks.
    pub(crate) fn each_hit(
        &self,
        cell: u32,
        direction: &UnitVector3<f64>,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) {
        let [nx, ny, _] = self.set.dims();
        let centre = Vector3::from(self.position(cell).map(f64::from));
        let clearance = |point: &Vector3<f64>| clearance(&self.shape, direction, point - centre);
        self.octree.near(clearance, self.shape.margin, |[x, y, z]| {
            let other = x + nx * (y + ny * z);
            let offset = Vector3::from([x, y, z].map(f64::from)) - centre;
            if other != cell && is_hit(&self.shape, direction, offset) { visit(other) } else { Continue(()) }
        });
    }
}

/// How far a nozzle with its tip at the cell at the origin is from a point, at least.
fn clearance(shape: &Shape, direction: &UnitVector3<f64>, point: Vector3<f64>) -> f64 {
    let along = point.dot(direction);
    let rho = (point.norm_squared() - along * along).max(0.0).sqrt();
    shape.clearance(along - TIP_ABOVE_CENTRE, rho)
}

/// Whether it hits a cell there.
fn is_hit(shape: &Shape, direction: &UnitVector3<f64>, point: Vector3<f64>) -> bool {
    clearance(shape, direction, point) < shape.margin - ROUNDING
}
