//! What a nozzle would hit: cells in bricks of 8 x 8 x 8, and for each direction the offsets near the tip.
//!
//! A cell in the way is nearly always beside the tip, so these offsets are tried first, nearest first. Else the nozzle
//! is held against the balls around the bricks, and against the cells of those that it comes near.

use super::rule::{NozzleRule, ROUNDING, Shape};
use crate::cells::CellSet;
use nalgebra::{UnitVector3, Vector3};

/// Edge of a brick in cells: 512 bits, eight words.
const BRICK: u32 = 8;

/// Offsets up to so many cells along each axis are near. With more the lists get longer than a look at the bricks.
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
    bricks: Vec<Brick>,
    /// Where each brick of the grid is in `bricks`.
    place_of: Vec<u32>,
}

/// Cells that lie close together.
#[derive(Clone)]
struct Brick {
    low: [u32; 3],
    bits: [u64; 8],
    /// Its middle, in cells.
    middle: Vector3<f64>,
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
        let [bx, by, bz] = set.dims().map(|side| side.div_ceil(BRICK));
        let mut obstacles = Obstacles {
            shape,
            directions,
            near,
            plate,
            set: set.clone(),
            bricks: Vec::new(),
            place_of: vec![u32::MAX; bx as usize * by as usize * bz as usize],
        };
        set.iter().for_each(|cell| obstacles.flip(cell));
        obstacles
    }

    fn position(&self, cell: u32) -> [u32; 3] {
        let [nx, ny, _] = self.set.dims();
        [cell % nx, cell / nx % ny, cell / nx / ny]
    }

    /// Puts the cell into its brick, or takes it out.
    fn flip(&mut self, cell: u32) {
        let position = self.position(cell);
        let [bx, by, _] = self.set.dims().map(|side| side.div_ceil(BRICK));
        let [x, y, z] = position.map(|k| k / BRICK);
        let place = &mut self.place_of[(x + bx * (y + by * z)) as usize];
        if *place == u32::MAX {
            *place = self.bricks.len() as u32;
            let low = [x, y, z].map(|k| k * BRICK);
            let middle = Vector3::from(low.map(|k| f64::from(k) + f64::from(BRICK - 1) / 2.0));
            self.bricks.push(Brick { low, bits: [0; 8], middle });
        }
        let brick = &mut self.bricks[*place as usize];
        let [x, y, z] = [0, 1, 2].map(|axis| position[axis] - brick.low[axis]);
        // `set` says whether the cell is there; both change together.
        brick.bits[z as usize] ^= 1 << (x + BRICK * y);
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
        self.is_above_plate(cell, direction.z) && self.hit_in_bricks(cell, direction).is_none()
    }

    /// A cell that the nozzle would hit with its tip at this one.
    pub(crate) fn hit(&self, cell: u32, direction: usize) -> Option<u32> {
        let near = self.set.around(cell, &self.near[direction]).next();
        near.or_else(|| self.hit_in_bricks(cell, &self.directions[direction]))
    }

    /// Whether the nozzle stays above the plate with its tip at the cell, in a direction of the caller's.
    pub(crate) fn clears_plate_in(&self, cell: u32, direction: &UnitVector3<f64>) -> bool {
        self.is_above_plate(cell, direction.z)
    }

    fn hit_in_bricks(&self, cell: u32, direction: &UnitVector3<f64>) -> Option<u32> {
        self.hits(cell, direction).next()
    }

    /// The cells that the nozzle would hit with its tip at this one.
    pub(crate) fn hits<'a>(&'a self, cell: u32, direction: &'a UnitVector3<f64>) -> impl Iterator<Item = u32> + 'a {
        let [nx, ny, _] = self.set.dims();
        let centre = Vector3::from(self.position(cell).map(f64::from));
        // Half the diagonal between the centres of a brick's corner cells: no cell of it is farther from its middle.
        let reach = f64::from(BRICK - 1) / 2.0 * 3f64.sqrt() + self.shape.margin;
        let is_near = move |brick: &&Brick| clearance(&self.shape, direction, brick.middle - centre) <= reach;
        let cells_of = move |brick: &'a Brick| {
            let of_level = move |(z, &bits): (u32, &u64)| {
                crate::cells::set_bits(bits)
                    .map(move |bit| [brick.low[0] + bit % BRICK, brick.low[1] + bit / BRICK, brick.low[2] + z])
            };
            (0u32..).zip(&brick.bits).flat_map(of_level)
        };
        let hit = move |[x, y, z]: [u32; 3]| {
            let other = x + nx * (y + ny * z);
            let offset = Vector3::from([x, y, z].map(f64::from)) - centre;
            (other != cell && is_hit(&self.shape, direction, offset)).then_some(other)
        };
        self.bricks.iter().filter(is_near).flat_map(cells_of).filter_map(hit)
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
