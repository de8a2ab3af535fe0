//! A field that rises as the distance does, but leans no more than the nozzle's cone allows.
//!
//! The distance `d` rises along the part, whichever way that leads. Where two of its fronts meet, at the top of an arch, they close a slot that no cone gets
//! into. If neither leans from upright by more than the cone's half angle leaves of a right angle, the slot is a valley as wide open as the cone. So the
//! field `f` follows directions `g`:
//!
//! 1. `g = grad d / |grad d|`, turned upright where it leans by more than the limit ([`DirectedOptions`]): the layers then lean out less than the part does, by 45 degrees at most
//!    where that goes sideways.
//!    Directions that are given take the place of the distance's: each cell has the one nearest to it inside the part, evened out where two meet.
//! 2. `g` is evened out in [`ROUNDS`] rounds, each cell with its face neighbours, so that the ground of the valley is round.
//! 3. `f` is the least squares of `f(b) - f(a) - (g(a) + g(b)) . (b - a) / 2` over all pairs of cells with a common face, and the distance on the base: Poisson's equation,
//!    solved by conjugate gradients with the diagonal as preconditioner (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952).
//!
//! Fields that are fitted to directions are those of Zhang et al., "S3-Slicer", ACM TOG 41(6), 2022; there directions follow from deformations of the part.
//! Ours are those of a distance with a limit that follows from the nozzle, and nothing is iterated.
//!
//! Where `g` turns, `f` is less steep than it: layers are thicker there, and get [half layers](super::super::surface::LayerField::with_half_layers).

use super::super::growth::GrowthError;
use super::super::nozzle::NozzleRule;
use super::{OnBase, beside, slope};
use crate::cells::Cells;
use nalgebra::Vector3;
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A valley is so much wider open than the cone, in radians, that the flat of the tip has room at its ground: 6 degrees on each side. With 2 degrees
/// paths across valleys have twice as many sharp turns (`fertility` and `bunny-hollow` with 60,000 cells, layers of 0.3 mm: 1,043 and 1,015, now 719 and 466);
/// with 9 more than 0.2 % of the beads of `bunny-hollow` lie on nothing (0.21, now 0.18, 0.15 with 2).
const SLACK: f64 = 0.105;

/// Rounds in which directions are evened out: they then reach about two cells. Fewer leave the ground of valleys sharp; with 8 more beads lie on nothing.
const ROUNDS: u32 = 5;

/// Rounds in which directions between given ones are evened out: over some ten cells.
const ROUNDS_OF_GIVEN: u32 = 50;

/// Equations are solved until what is left of them, weighted by the preconditioner, is so much of what it was at first.
const SOLVED: f64 = 1e-10;

/// Iterations at most: a part is seldom more than some hundred cells long.
const MAX_ITERATIONS: u32 = 10_000;

/// What a directed field is to be like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct DirectedOptions {
    /// How far the layers lean from level at most, in radians: 0 for level layers, below a right angle. Default `None`: 6 degrees less than the nozzle's cone
    /// leaves of a right angle, so that it fits into the valley between two layers that lean against each other; 39 degrees, where that is less.
    pub max_tilt: Option<f64>,
}

impl DirectedOptions {
    /// How far the layers lean from level at most for a nozzle, in radians.
    ///
    /// # Errors
    /// [`GrowthError::LayerTilt`].
    pub fn tilt_for(&self, nozzle: &NozzleRule) -> Result<f64, GrowthError> {
        match self.max_tilt {
            Some(tilt) if !(0.0..FRAC_PI_2).contains(&tilt) => Err(GrowthError::LayerTilt { tilt }),
            Some(tilt) => Ok(tilt),
            None => Ok(default_tilt(nozzle)),
        }
    }
}

/// How far the field leans from upright, in radians. A cone of more than 45 degrees does not make it less: beads would lean out by more than that.
fn default_tilt(nozzle: &NozzleRule) -> f64 {
    (FRAC_PI_2 - nozzle.half_angle - SLACK).max(FRAC_PI_4 - SLACK)
}

/// The directed field of these distances, by cell number; NaN where they are. It follows the directions that are `given`, by cell number, if any are.
pub(super) fn directed(
    cells: &Cells,
    base: &[OnBase],
    distances: &[f64],
    given: Option<&[Vector3<f64>]>,
    max_tilt: f64,
) -> Vec<f64> {
    let solid: Vec<u32> = cells.iter().filter(|&cell| !distances[cell as usize].is_nan()).collect();
    let mut number = vec![None; distances.len()];
    solid.iter().zip(0..).for_each(|(&cell, k)| number[cell as usize] = Some(k));
    let of_cell = |&cell: &u32| beside(cells, cell).map(|other| other.and_then(|other| number[other as usize]));
    let faces: Vec<[Option<u32>; 6]> = solid.iter().map(of_cell).collect();
    let distances_of: Vec<f64> = solid.iter().map(|&cell| distances[cell as usize]).collect();
    let slope_at = |k: usize| slope(distances_of[k], faces[k].map(|other| Some(distances_of[other? as usize])));
    let mut wanted: Vec<Vector3<f64>> = (0..solid.len()).map(slope_at).collect();
    if let Some(given) = given {
        extend(&faces, solid.iter().map(|&cell| given[cell as usize]), &mut wanted);
    }
    let mut directions: Vec<Vector3<f64>> = wanted.into_iter().map(|wanted| leaning(wanted, max_tilt)).collect();
    for _ in 0..ROUNDS {
        directions = (0..solid.len()).map(|k| leaning(with_neighbours(&faces, &directions, k), max_tilt)).collect();
    }
    let system = System::new(&faces, |k| base.binary_search_by_key(&solid[k], |base| base.0).is_ok());
    let fitted = system.solve(&system.right_side(&directions), distances_of);
    let mut values = vec![f64::NAN; distances.len()];
    solid.iter().zip(fitted).for_each(|(&cell, value)| values[cell as usize] = value);
    values
}

/// The direction of a vector, turned upright where it leans by more than `max_tilt`. What points straight down, or nowhere, has no side to lean to: upright.
fn leaning(way: Vector3<f64>, max_tilt: f64) -> Vector3<f64> {
    let Some(direction) = way.try_normalize(1e-9) else { return Vector3::z() };
    if direction.z >= max_tilt.cos() {
        return direction;
    }
    let side = Vector3::new(direction.x, direction.y, 0.0).try_normalize(1e-9);
    side.map_or(Vector3::z(), |side| side * max_tilt.sin() + Vector3::z() * max_tilt.cos())
}

/// Puts directions that are given in the place of others: those of the cells that have one, and all others the nearest to it, in steps from face to face. Where two such regions meet they
/// are evened out. Cells that are joined to none with a direction keep theirs.
fn extend(faces: &[[Option<u32>; 6]], given: impl Iterator<Item = Vector3<f64>>, directions: &mut Vec<Vector3<f64>>) {
    let mut reached: VecDeque<u32> = VecDeque::new();
    let mut is_free = vec![false; faces.len()];
    let mut is_reached = is_free.clone();
    for ((given, direction), cell) in given.zip(directions.iter_mut()).zip(0..) {
        if given != Vector3::zeros() {
            *direction = given;
            is_reached[cell as usize] = true;
            reached.push_back(cell);
        }
    }
    while let Some(cell) = reached.pop_front() {
        for &other in faces[cell as usize].iter().flatten() {
            if !std::mem::replace(&mut is_reached[other as usize], true) {
                directions[other as usize] = directions[cell as usize];
                is_free[other as usize] = true;
                reached.push_back(other);
            }
        }
    }
    for _ in 0..ROUNDS_OF_GIVEN {
        let count = |cell: usize| 1.0 + faces[cell].iter().flatten().count() as f64;
        let mean = |cell| with_neighbours(faces, directions, cell) / count(cell);
        let next = |cell| if is_free[cell] { mean(cell) } else { directions[cell] };
        *directions = (0..faces.len()).map(next).collect();
    }
}

/// The sum of the direction of a cell and those of its face neighbours.
fn with_neighbours(faces: &[[Option<u32>; 6]], directions: &[Vector3<f64>], cell: usize) -> Vector3<f64> {
    directions[cell] + faces[cell].iter().flatten().map(|&other| directions[other as usize]).sum::<Vector3<f64>>()
}

/// The normal equations: for each cell whose value is not known the sum, over its face neighbours, of its value less theirs.
struct System {
    /// Of each cell; itself where there is none, and in all six places of a cell whose value is known: what it adds to a sum is 0.
    neighbours: Vec<[u32; 6]>,
}

impl System {
    fn new(faces: &[[Option<u32>; 6]], is_known: impl Fn(usize) -> bool) -> Self {
        let of_cell = |(cell, faces): (u32, &[Option<u32>; 6])| {
            if is_known(cell as usize) { [cell; 6] } else { faces.map(|other| other.unwrap_or(cell)) }
        };
        System { neighbours: (0..).zip(faces).map(of_cell).collect() }
    }

    /// What the directions want that sum to be.
    fn right_side(&self, directions: &[Vector3<f64>]) -> Vec<f64> {
        let wanted = |(cell, others): (usize, &[u32; 6])| {
            let below = |(face, &other): (usize, &u32)| {
                let rise = (directions[cell][face / 2] + directions[other as usize][face / 2]) / 2.0;
                if face % 2 == 1 { -rise } else { rise }
            };
            others.iter().enumerate().filter(|(_, other)| **other as usize != cell).map(below).sum()
        };
        self.neighbours.iter().enumerate().map(wanted).collect()
    }

    /// The sum of a cell; 0 where its value is known.
    fn sum(&self, values: &[f64], cell: usize) -> f64 {
        self.neighbours[cell].iter().map(|&other| values[cell] - values[other as usize]).sum()
    }

    /// The values with these sums, known ones kept, by conjugate gradients from `values` on.
    fn solve(&self, right_side: &[f64], mut values: Vec<f64>) -> Vec<f64> {
        let neighbours = |cell: u32| self.neighbours[cell as usize].iter().filter(|&&other| other != cell).count();
        let inverse: Vec<f64> = (0..values.len() as u32).map(|cell| 1.0 / neighbours(cell).max(1) as f64).collect();
        let mut left: Vec<f64> =
            right_side.iter().enumerate().map(|(cell, wanted)| wanted - self.sum(&values, cell)).collect();
        let mut way: Vec<f64> = left.iter().zip(&inverse).map(|(left, by)| left * by).collect();
        let mut sums = vec![0.0; values.len()];
        let first: f64 = left.iter().zip(&way).map(|(left, weighted)| left * weighted).sum();
        let mut size = first;
        for _ in 0..MAX_ITERATIONS {
            if size <= SOLVED * first {
                break;
            }
            let mut bend = 0.0;
            for (cell, sum) in sums.iter_mut().enumerate() {
                *sum = self.sum(&way, cell);
                bend += way[cell] * *sum;
            }
            let (step, before) = (size / bend, size);
            size = 0.0;
            for cell in 0..values.len() {
                values[cell] += step * way[cell];
                left[cell] -= step * sums[cell];
                size += left[cell] * left[cell] * inverse[cell];
            }
            let again = size / before;
            for ((way, left), inverse) in way.iter_mut().zip(&left).zip(&inverse) {
                *way = left * inverse + again * *way;
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::super::ON_BASE;
    use super::super::march::distances;
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    /// All cells of a grid where `is_solid`.
    fn rows(dims: [u32; 3], is_solid: impl Fn([u32; 3]) -> bool) -> Vec<u64> {
        let [nx, ny, nz] = dims;
        let places = (0..nz).flat_map(|z| (0..ny).map(move |y| [y, z]));
        places.map(|[y, z]| (0..nx).filter(|&x| is_solid([x, y, z])).map(|x| 1u64 << x).sum()).collect()
    }

    fn on_plate(cells: impl Iterator<Item = u32>) -> Vec<OnBase> {
        cells.map(|cell| (cell, ON_BASE)).collect()
    }

    fn field(dims: [u32; 3], rows: &[u64], max_tilt: f64) -> (Vec<f64>, impl Fn([u32; 3]) -> u32 + use<>) {
        let cells = Cells::new(dims, rows).unwrap();
        let base = on_plate(cells.iter().filter(|&cell| cell < dims[0] * dims[1]));
        let values = directed(&cells, &base, &distances(&cells, &base, &|_| 0.0), None, max_tilt);
        (values, move |[x, y, z]: [u32; 3]| x + dims[0] * (y + dims[1] * z))
    }

    /// In a block the field is the height.
    #[test]
    fn a_block_has_level_layers() {
        let dims = [5, 4, 9];
        let (values, id) = field(dims, &rows(dims, |_| true), 0.7);
        for z in 0..9 {
            assert!((values[id([2, 1, z]) as usize] - f64::from(z) - 0.5).abs() < 1e-6, "{z}");
        }
    }

    /// An arm that goes out level from the top of a mast: its layers lean by the limit, and have the thickness of a layer.
    #[test]
    fn a_level_arm_leans_by_the_limit() {
        let dims = [40, 3, 16];
        let solid = rows(dims, |[x, _, z]| x < 6 || z >= 10);
        for tilt in [0.6, 0.75, 1.0] {
            let (values, id) = field(dims, &solid, tilt);
            let value = |x: u32, z: u32| values[id([x, 1, z]) as usize];
            let slope = Vector3::new(value(33, 13) - value(31, 13), 0.0, value(32, 14) - value(32, 12)) / 2.0;
            assert!((slope.x.atan2(slope.z) - tilt).abs() < 0.02, "{tilt}: {slope}");
            assert!((slope.norm() - 1.0).abs() < 0.02, "{tilt}: {slope}");
        }
    }

    /// Where two arms meet in the middle of a bridge the valley between their layers is as open as the limit says, two cells beside its ground.
    #[test]
    fn a_bridge_closes_as_an_open_valley() {
        let dims = [41, 3, 24];
        let solid = rows(dims, |[x, _, z]| !(6..35).contains(&x) || z >= 12);
        let (values, id) = field(dims, &solid, 0.75);
        let value = |x: u32, z: u32| values[id([x, 1, z]) as usize];
        for x in 13..18 {
            let slope = Vector3::new(value(x + 1, 17) - value(x - 1, 17), 0.0, value(x, 18) - value(x, 16)) / 2.0;
            assert!(slope.x.atan2(slope.z) < 0.78, "{x}: {slope}");
        }
        // The distance alone closes a slot: it leans by more than a radian there.
        let cells = Cells::new(dims, &solid).unwrap();
        let base = on_plate(cells.iter().filter(|&cell| cell < 41 * 3));
        let distances = distances(&cells, &base, &|_| 0.0);
        let distance = |x: u32, z: u32| distances[id([x, 1, z]) as usize];
        assert!((distance(17, 17) - distance(15, 17)).atan2(distance(16, 18) - distance(16, 16)) > 1.0);
    }

    /// Between two given directions of a bar each cell turns as much as the one before; a bar beside it keeps its own.
    #[test]
    fn between_given_directions_they_change_evenly() {
        let rows = [0b1_1111_1111u64, 0, 0b1_1111_1111];
        let cells = Cells::new([9, 3, 1], &rows).unwrap();
        let faces: Vec<[Option<u32>; 6]> = cells
            .iter()
            .map(|cell| beside(&cells, cell).map(|other| other.map(|other| if other < 9 { other } else { other - 9 })))
            .collect();
        let mut given = vec![Vector3::zeros(); 18];
        (given[1], given[7]) = (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.6, 0.0, 0.4));
        let mut directions = vec![Vector3::new(0.1, 0.2, 0.3); 18];
        extend(&faces, given.into_iter(), &mut directions);
        for (x, direction) in directions[..9].iter().enumerate() {
            let along = (x as f64 - 1.0).clamp(0.0, 6.0) / 10.0;
            assert!((direction - Vector3::new(along, 0.0, 1.0 - along)).norm() < 1e-2, "{x}: {direction}");
        }
        assert!(directions[9..].iter().all(|direction| *direction == Vector3::new(0.1, 0.2, 0.3)));
    }

    proptest! {
        /// The values solve the normal equations, as elimination does.
        #[test]
        fn values_are_those_of_elimination(
            solid in prop::collection::vec(0u64..16, 12),
            heights in prop::collection::vec(0.001..1.0f64, 12),
        ) {
            let dims = [4, 3, 4];
            let solid: Vec<u64> = solid.iter().zip(0..).map(|(row, k)| if k < 3 { 15 } else { *row }).collect();
            let cells = Cells::new(dims, &solid).unwrap();
            let base: Vec<OnBase> = (0..12).zip(heights).collect();
            let distances = distances(&cells, &base, &|_| 0.0);
            let values = directed(&cells, &base, &distances, None, 0.7);
            let known: Vec<u32> = cells.iter().filter(|&cell| !distances[cell as usize].is_nan()).collect();
            let faces = |k: usize| beside(&cells, known[k]).map(|other| other.and_then(|o| known.iter().position(|&c| c == o)));
            let all: Vec<[Option<u32>; 6]> =
                (0..known.len()).map(|k| faces(k).map(|other| other.map(|other| other as u32))).collect();
            let of: Vec<f64> = known.iter().map(|&cell| distances[cell as usize]).collect();
            let mut g: Vec<Vector3<f64>> = (0..known.len()).map(|k| leaning(slope(of[k], all[k].map(|o| Some(of[o? as usize]))), 0.7)).collect();
            for _ in 0..ROUNDS {
                g = (0..known.len()).map(|k| {
                    leaning(g[k] + faces(k).iter().flatten().map(|&o| g[o]).sum::<Vector3<f64>>(), 0.7)
                }).collect();
            }
            let mut matrix = DMatrix::zeros(known.len(), known.len());
            let mut right = DVector::zeros(known.len());
            for k in 0..known.len() {
                if known[k] < 12 {
                    (matrix[(k, k)], right[k]) = (1.0, base[known[k] as usize].1);
                    continue;
                }
                for (face, other) in faces(k).into_iter().enumerate() {
                    let Some(other) = other else { continue };
                    matrix[(k, k)] += 1.0;
                    matrix[(k, other)] -= 1.0;
                    right[k] -= (g[k][face / 2] + g[other][face / 2]) / 2.0 * if face % 2 == 1 { 1.0 } else { -1.0 };
                }
            }
            let expected = matrix.lu().solve(&right).unwrap();
            for (k, &cell) in known.iter().enumerate() {
                prop_assert!((values[cell as usize] - expected[k]).abs() < 1e-3, "{cell}: {} {}", values[cell as usize], expected[k]);
            }
        }
    }
}
