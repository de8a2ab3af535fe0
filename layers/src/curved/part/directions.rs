//! Directions that a part is to grow in: given at places, or as upright as its skin allows.

use super::workpiece::Workpiece;
use crate::cells::Cells;
use crate::curved::distance::beside;
use crate::trim::{Input, TrimError, check};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// The skin is looked at in places no farther apart than this, in cells: several in each cell that it goes through.
const SPACING: f64 = 0.5;

/// Places of the skin are so far below it, in cells: rounding does not take them out of the cells that hold it.
const BELOW_SKIN: f64 = 1e-3;

/// Undersides nearer to level than 3 degrees, by the height of their normal, look to no side.
const LEVEL: f64 = -0.9986;

/// How much upright counts beside a neighbour: directions go back to upright within some 30 cells, more than most parts are thick.
const UPRIGHT: f64 = 0.001;

/// A direction that no skin holds goes this many times the way to the mean (over-relaxation).
const OVER: f64 = 1.8;

/// Times that each cell is looked at, at most, and how little has to change, in radians, before no more are needed.
const SWEEPS: usize = 300;
const TURNED: f64 = 1e-3;

/// A mean shorter than this has no direction: the directions in it cancel out.
const SHORTEST: f64 = 1e-9;

/// A direction in which the part is to grow at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionAt {
    /// In millimetres, in the frame of the part's mesh.
    pub place: Point3<f64>,
    /// Of any length above 0.
    pub direction: Vector3<f64>,
}

/// The directions that cells are to grow in.
#[derive(Clone, Debug, PartialEq)]
pub struct CellDirections {
    /// One for each cell of the grid, by its number; of length 0 where there is none. For [`Guides::directions`](crate::curved::Guides::directions).
    pub directions: Vec<Vector3<f64>>,
    /// How many of the places lie in no cell of the part. They count for nothing.
    pub outside: usize,
}

/// Why directions cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DirectionsError {
    /// A place or a direction is not finite, or the direction has no length.
    #[error("place {} has no direction: its six numbers must be finite, and the direction longer than 0", index + 1)]
    NoDirection {
        /// Which of the places, from 0.
        index: usize,
    },
    /// No place lies in the part.
    #[error("none of the {places} places lies in the part: both must have the same origin and unit")]
    NoneInside {
        /// How many places there are.
        places: usize,
    },
    /// The skin cannot hang over by that.
    #[error("the skin may hang over by more than 0 and less than 90 degrees, not by {}", angle.to_degrees())]
    Overhang {
        /// The angle, in radians.
        angle: f64,
    },
    /// The mesh of the workpiece is no mesh.
    #[error(transparent)]
    Mesh(#[from] TrimError),
    /// The cells of the workpiece are not those of its mesh.
    #[error(
        "cells of {cell_mm} mm for a mesh of {mesh_mm} mm: the size must be above 0, and the mesh at most {} cells long",
        Cells::MAX_SIDE
    )]
    CellSize {
        /// The edge of a cell.
        cell_mm: f64,
        /// The longest side of the box around the mesh.
        mesh_mm: f64,
    },
}

impl Workpiece<'_> {
    /// The directions of the cells in which some places lie: the mean of those of a cell.
    ///
    /// # Errors
    /// [`DirectionsError::NoDirection`], [`DirectionsError::NoneInside`].
    ///
    /// # Cost
    /// `O(n)` for `n` places and cells of the grid.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]:
    /// ```
    /// # use curvlay_layers::cells::Cells;
    /// # use curvlay_layers::curved::{Guides, Platform, Rules, Workpiece, cell_mesh};
    /// use curvlay_layers::curved::DirectionAt;
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// # let rows = [0b1111; 12];
    /// # let cells = Cells::new([4, 4, 3], &rows)?;
    /// # let block = cell_mesh(&cells, &cells.iter().collect::<Vec<_>>(), 1.0, Point3::origin());
    /// # let platform = Platform::under(&cells, 10.0)?;
    /// # let (vertices, triangles) = (&block.vertices[..], &block.triangles[..]);
    /// # let (cell_mm, origin, rules, guides) = (1.0, Point3::origin(), Rules::default(), Guides::default());
    /// # let part = Workpiece { vertices, triangles, cells, cell_mm, origin, platform: &platform, rules, volume_mm3: 48.0, guides };
    /// let at = |x, direction| DirectionAt { place: Point3::new(x, 0.5, 0.5), direction };
    /// let given = part.directions_at(&[at(0.2, Vector3::x()), at(0.8, 7.0 * Vector3::z()), at(-3.0, Vector3::y())])?;
    /// assert_eq!((given.directions[0], given.outside), (Vector3::new(0.5, 0.0, 0.5), 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn directions_at(&self, places: &[DirectionAt]) -> Result<CellDirections, DirectionsError> {
        let len = self.cells.grid_len();
        let (mut directions, mut counts) = (vec![Vector3::zeros(); len], vec![0u32; len]);
        let mut outside = 0;
        for (index, at) in places.iter().enumerate() {
            let direction = at.direction.try_normalize(SHORTEST).filter(|direction| direction.norm().is_finite());
            let is_finite = at.place.iter().all(|along| along.is_finite());
            let direction = direction.filter(|_| is_finite).ok_or(DirectionsError::NoDirection { index })?;
            match self.cell_at(&at.place) {
                Some(cell) => {
                    directions[cell as usize] += direction;
                    counts[cell as usize] += 1;
                }
                None => outside += 1,
            }
        }
        if outside == places.len() {
            return Err(DirectionsError::NoneInside { places: outside });
        }
        let mean = |(sum, count): (Vector3<f64>, u32)| {
            let mean = sum / f64::from(count.max(1));
            if mean.norm() > SHORTEST { mean } else { Vector3::zeros() }
        };
        Ok(CellDirections { directions: directions.into_iter().zip(counts).map(mean).collect(), outside })
    }

    /// Directions for all cells that are upright but where the skin would hang over by more than an angle.
    ///
    /// ShellFinder hangs over by the angle that its normal dips below the plane across the direction of growth: a wall along the direction by 0. What hangs over most in a cell decides, at places no
    /// farther apart than half a cell; level undersides look to no side, and turn nothing. Directions change as little as they can from cell to cell: each is the mean of its face neighbours', drawn upright a
    /// little, and turned towards the normal of its skin by what that needs (projected relaxation, 300 rounds at most).
    ///
    /// # Arguments
    /// * `max_overhang`: in radians, above 0 and below a right angle. Beads hold on each other up to about 45 degrees.
    ///
    /// # Errors
    /// [`DirectionsError::Overhang`]; [`DirectionsError::Mesh`] and [`DirectionsError::CellSize`] for a workpiece whose fields do not fit each other.
    ///
    /// # Cost
    /// Two places for each triangle or some four for each cell of the skin; 300 looks at each cell, some 1 s for 60,000, one thread.
    ///
    /// # Example
    /// As in [`Workpiece::layers`], a block stands upright: `part.upright_directions(0.8)?` has `Vector3::z()` in all of its cells.
    pub fn upright_directions(&self, max_overhang: f64) -> Result<Vec<Vector3<f64>>, DirectionsError> {
        if !(f64::MIN_POSITIVE..FRAC_PI_2).contains(&max_overhang) {
            return Err(DirectionsError::Overhang { angle: max_overhang });
        }
        check(Input::Mesh, self.vertices, self.triangles)?;
        let (cell_mm, mesh_mm) = (self.cell_mm, self.longest_side_mm());
        let is_size = cell_mm > 0.0 && mesh_mm <= f64::from(Cells::MAX_SIDE) * cell_mm;
        if !is_size {
            return Err(DirectionsError::CellSize { cell_mm, mesh_mm });
        }
        let skin = self.hanging_skin(max_overhang);
        let mut directions = vec![Vector3::zeros(); self.cells.grid_len()];
        let cells: Vec<u32> = self.cells.iter().collect();
        cells.iter().for_each(|&cell| directions[cell as usize] = Vector3::z());
        for sweep in 0..SWEEPS {
            let mut turned: f64 = 0.0;
            let mut relax = |&cell: &u32| {
                let (mut sum, mut count) = (Vector3::z() * UPRIGHT, UPRIGHT);
                for other in beside(&self.cells, cell).into_iter().flatten() {
                    sum += directions[other as usize];
                    count += 1.0;
                }
                let before = directions[cell as usize];
                let mean = sum / count;
                let direction = match skin.get(&cell) {
                    Some(normal) => held(mean.try_normalize(SHORTEST).unwrap_or(before), normal, max_overhang),
                    None => before + (mean - before) * OVER,
                };
                turned = turned.max((direction - before).norm());
                directions[cell as usize] = direction;
            };
            // To and fro: what one end says reaches the other in two sweeps.
            if sweep.is_multiple_of(2) {
                cells.iter().for_each(&mut relax)
            } else {
                cells.iter().rev().for_each(&mut relax)
            }
            if turned < TURNED {
                break;
            }
        }
        Ok(directions)
    }

    /// The longest side of the box around the mesh; 0 without vertices.
    fn longest_side_mm(&self) -> f64 {
        let along = |axis: usize| {
            let all = self.vertices.iter().map(|vertex| vertex[axis]);
            all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
        };
        (0..3).map(along).fold(0.0, f64::max)
    }

    /// The normal of the skin that hangs over upright most in each cell, where that is by more than the angle.
    fn hanging_skin(&self, max_overhang: f64) -> BTreeMap<u32, Vector3<f64>> {
        let mut hanging: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
        for corners in self.triangles.iter().map(|of| of.map(|corner| self.vertices[corner as usize])) {
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
            let Some(normal) = normal.filter(|normal| -normal.z > max_overhang.sin() && normal.z > LEVEL) else {
                continue;
            };
            spread(corners, SPACING * self.cell_mm, &mut |place| {
                if let Some(cell) = self.cell_at(&(place - normal * (BELOW_SKIN * self.cell_mm))) {
                    let of_cell = hanging.entry(cell).or_insert(normal);
                    if normal.z < of_cell.z {
                        *of_cell = normal;
                    }
                }
            });
        }
        hanging
    }

    /// The cell of the part in which a place lies.
    fn cell_at(&self, place: &Point3<f64>) -> Option<u32> {
        let cell = self.cells.cell_of(&((place - self.origin) / self.cell_mm))?;
        self.cells.contains(cell).then(|| self.cells.id(cell))
    }
}

/// The direction nearest to another one across which skin with this outward normal dips by no more than `max_overhang`; both have length 1.
fn held(direction: Vector3<f64>, normal: &Vector3<f64>, max_overhang: f64) -> Vector3<f64> {
    let rise = direction.dot(normal);
    let along = (direction - normal * rise).try_normalize(SHORTEST);
    match along.filter(|_| rise < -max_overhang.sin()) {
        Some(along) => along * max_overhang.cos() - normal * max_overhang.sin(),
        None => direction,
    }
}

/// Calls `at` with the middles of the pieces of a triangle, which is cut into equal ones with sides no longer than `spacing`.
fn spread([a, b, c]: [Point3<f64>; 3], spacing: f64, at: &mut dyn FnMut(Point3<f64>)) {
    let longest = [b - a, c - b, a - c].iter().map(Vector3::norm).fold(0.0, f64::max);
    let cuts = (longest / spacing).ceil().max(1.0) as u32;
    let (u, v) = ((b - a) / f64::from(cuts), (c - a) / f64::from(cuts));
    for i in 0..cuts {
        for j in 0..cuts - i {
            let corner = a + u * f64::from(i) + v * f64::from(j);
            at(corner + (u + v) / 3.0);
            if j + 1 < cuts - i {
                at(corner + (u + v) * (2.0 / 3.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The middles are those of equal pieces: as many as cuts squared, their mean that of the corners.
    #[test]
    fn a_triangle_is_cut_into_equal_pieces() {
        let corners = [Point3::new(0.0, 0.0, 1.0), Point3::new(4.0, 1.0, 0.0), Point3::new(1.0, 3.0, 2.0)];
        let mut places = Vec::new();
        spread(corners, 1.0, &mut |place| places.push(place));
        assert_eq!(places.len(), 25);
        let mean = places.iter().map(|place| place.coords).sum::<Vector3<f64>>() / 25.0;
        assert!((mean - corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 3.0).norm() < 1e-12);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        assert!(places.iter().all(|place| (place - corners[0]).dot(&normal).abs() < 1e-12));
        // Each is the middle of a piece of its own: no two are nearer than a third of the shortest height.
        for (k, place) in places.iter().enumerate() {
            assert!(places[..k].iter().all(|other| (other - place).norm() > 0.2));
        }
    }

    proptest! {
        /// No direction nearer to what it was keeps the skin from hanging over by more: those on a fine net of the sphere are tried.
        #[test]
        fn no_direction_is_turned_less(of in prop::array::uniform6(-1.0..1.0f64), overhang in 0.05..1.5f64) {
            let [a, normal] = [Vector3::new(of[0], of[1], of[2]), Vector3::new(of[3], of[4], of[5])];
            prop_assume!(a.norm() > 0.1 && normal.norm() > 0.1 && a.cross(&normal).norm() > 0.01);
            let (a, normal) = (a.normalize(), normal.normalize());
            let direction = held(a, &normal, overhang);
            let dips = |direction: &Vector3<f64>| -normal.dot(direction).clamp(-1.0, 1.0).asin();
            prop_assert!((direction.norm() - 1.0).abs() < 1e-12);
            prop_assert!(dips(&direction) <= overhang + 1e-9);
            for (tilt, turn) in (0..120).flat_map(|tilt| (0..90).map(move |turn| (f64::from(tilt) * 0.026, f64::from(turn) * 0.07))) {
                let other = Vector3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos());
                prop_assert!(other.dot(&a) <= direction.dot(&a) + 1e-9 || dips(&other) > overhang - 1e-9, "{other}");
            }
        }
    }
}
