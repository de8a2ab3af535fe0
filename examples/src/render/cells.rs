//! Cells coloured by layer: the faces that the camera sees, shaded by the lie of the cells around them.

use super::colours::layer_colour;
use super::plane::Plane;
use super::raster::from_rgb;
use super::scene::Scene;
use nalgebra::{Point3, Vector3};

/// Cells with their layers, in a grid whose cells have edges of length 1.
#[derive(Clone, Copy, Debug)]
pub struct LayeredCells<'a> {
    dims: [u32; 3],
    rows: &'a [u64],
    layers: &'a [u32],
}

/// Why bits and layers do not belong to the dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LayeredCellsError {
    /// There is no cell, or so many that they cannot be numbered.
    #[error("a grid of {dims:?} cells is empty or too large")]
    Dims {
        /// Cells along x, y and z.
        dims: [u32; 3],
    },
    /// Too few or too many words of bits.
    #[error("{words} words of bits where {expected} belong")]
    Words {
        /// Words that were given.
        words: usize,
        /// Words that belong to the grid.
        expected: usize,
    },
    /// Too few or too many layers.
    #[error("{layers} layers where {expected} belong, one a cell of the grid")]
    Layers {
        /// Layers that were given.
        layers: usize,
        /// Cells of the grid.
        expected: usize,
    },
}

impl<'a> LayeredCells<'a> {
    /// Takes a set of cells (bit `x % 64` of word `x / 64` of row `y + ny * z`) with a layer for each cell of the
    /// grid, `x + nx * (y + ny * z)`: counted from 1, and 0 where there is none.
    ///
    /// # Errors
    /// [`LayeredCellsError`] if the lengths do not belong together.
    pub fn new(dims: [u32; 3], rows: &'a [u64], layers: &'a [u32]) -> Result<Self, LayeredCellsError> {
        let [nx, ny, nz] = dims.map(|side| side as usize);
        let len = nx.checked_mul(ny).and_then(|area| area.checked_mul(nz)).filter(|&len| len > 0);
        let Some(expected) = len.filter(|&len| len <= u32::MAX as usize) else {
            return Err(LayeredCellsError::Dims { dims });
        };
        if layers.len() != expected {
            return Err(LayeredCellsError::Layers { layers: layers.len(), expected });
        }
        let expected = nx.div_ceil(64) * ny * nz;
        if rows.len() != expected {
            return Err(LayeredCellsError::Words { words: rows.len(), expected });
        }
        Ok(LayeredCells { dims, rows, layers })
    }

    /// Cells along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The last layer.
    pub fn last_layer(&self) -> u32 {
        self.layers.iter().copied().max().unwrap_or(0)
    }

    /// Number of cells without a layer.
    pub fn missed(&self) -> usize {
        let [nx, ny, nz] = self.dims;
        let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| [y, z]));
        rows.flat_map(|[y, z]| (0..nx).map(move |x| [x, y, z])).filter(|&at| self.layer(at) == Some(0)).count()
    }

    /// The layer of a cell, 0 for a missed one; `None` where there is no cell.
    pub(super) fn layer(&self, at: [u32; 3]) -> Option<u32> {
        let [x, y, z] = at.map(|c| c as usize);
        let [nx, ny, _] = self.dims.map(|side| side as usize);
        let inside = at.iter().zip(self.dims).all(|(&c, side)| c < side);
        let filled = || self.rows[(y + ny * z) * nx.div_ceil(64) + x / 64] >> (x % 64) & 1 == 1;
        (inside && filled()).then(|| self.layers[x + nx * (y + ny * z)])
    }
}

/// How far around a cell its surroundings are looked at: its surface counts as that of a ball of this radius, in
/// cells. Less shows the steps of the lattice, more rounds off fingers.
const REACH: i64 = 3;

impl Scene {
    /// Adds cells coloured by layer; with a plane, only those behind it as the camera sees it, and the cut is flat.
    ///
    /// # Cost
    /// A few operations a word of bits, and about a hundred for each face that is seen.
    pub fn cells(&mut self, cells: &LayeredCells, cut: Option<Plane>) -> &mut Self {
        let toward = self.camera().toward();
        let kept = kept_cells(cells, cut, &toward);
        let layers = cells.last_layer();
        let colours: Vec<[f32; 3]> = (0..=layers).map(|layer| from_rgb(layer_colour(layer, layers))).collect();
        for axis in 0..3 {
            if toward[axis].abs() < 1e-9 {
                continue;
            }
            let ahead = if toward[axis] > 0.0 { 1 } else { -1 };
            let mut normal = Vector3::zeros();
            normal[axis] = f64::from(ahead);
            for_each_exposed(&kept, cells.dims, axis, ahead, |at| {
                let mut beyond = at.map(i64::from);
                beyond[axis] += i64::from(ahead);
                let sawn = beyond.iter().all(|&c| c >= 0) && cells.layer(beyond.map(|c| c as u32)).is_some();
                let light = if sawn {
                    0.98
                } else {
                    let (smooth, crowding) = surroundings(cells, at);
                    let seen = (smooth * 0.85 + normal * 0.35).normalize();
                    self.camera().brightness(&seen) * (1.0 - 0.55 * crowding)
                };
                let layer = cells.layer(at).unwrap_or(0);
                // Missed cells stay loud in the dark.
                let light = if layer == 0 { light.max(0.8) } else { light };
                let colour = colours[layer as usize].map(|c| c * light);
                let [a, b, c, d] = face(at, axis, ahead);
                self.facet([a, b, c], [colour; 3]);
                self.facet([a, c, d], [colour; 3]);
            });
        }
        // The lowest cell of each column shades the platform.
        let [nx, ny, nz] = cells.dims;
        for y in 0..ny {
            for x in 0..nx {
                if let Some(z) = (0..nz).find(|&z| bit(&kept, cells.dims, [x, y, z])) {
                    self.shading_square([x as f32 + 0.5, y as f32 + 0.5, z as f32], 0.5);
                }
            }
        }
        self
    }
}

/// The bits of the cells behind the plane.
fn kept_cells(cells: &LayeredCells, cut: Option<Plane>, toward: &Vector3<f64>) -> Vec<u64> {
    let mut kept = cells.rows.to_vec();
    let Some(plane) = cut else { return kept };
    let [nx, ny, _] = cells.dims.map(|side| side as usize);
    let axis = plane.axis();
    let low_side = toward[axis] > 0.0;
    let stays = |index: usize| (index < plane.index() as usize) == low_side;
    for (row, words) in kept.chunks_mut(nx.div_ceil(64)).enumerate() {
        match axis {
            0 => {
                for (i, word) in words.iter_mut().enumerate() {
                    *word &= (0..64).filter(|k| stays(64 * i + k)).fold(0, |mask, k| mask | 1 << k);
                }
            }
            _ if stays(row % ny) => {}
            _ => words.fill(0),
        }
    }
    kept
}

fn bit(rows: &[u64], dims: [u32; 3], [x, y, z]: [u32; 3]) -> bool {
    let words = dims[0].div_ceil(64) as usize;
    rows[(y as usize + dims[1] as usize * z as usize) * words + x as usize / 64] >> (x % 64) & 1 == 1
}

/// Calls `visit` for each cell whose neighbour `ahead` along `axis` is not in the set.
fn for_each_exposed(rows: &[u64], dims: [u32; 3], axis: usize, ahead: i32, mut visit: impl FnMut([u32; 3])) {
    let [_, ny, nz] = dims;
    let words = dims[0].div_ceil(64) as usize;
    let row_at = |y: u32, z: u32| (y as usize + ny as usize * z as usize) * words;
    for z in 0..nz {
        for y in 0..ny {
            let row = row_at(y, z);
            let beside = match axis {
                1 => y.checked_add_signed(ahead).filter(|&y| y < ny).map(|y| row_at(y, z)),
                2 => z.checked_add_signed(ahead).filter(|&z| z < nz).map(|z| row_at(y, z)),
                _ => None,
            };
            for i in 0..words {
                let word = rows[row + i];
                let hidden = match (axis, ahead > 0) {
                    (0, true) => word >> 1 | if i + 1 < words { rows[row + i + 1] << 63 } else { 0 },
                    (0, false) => word << 1 | if i > 0 { rows[row + i - 1] >> 63 } else { 0 },
                    _ => beside.map_or(0, |other| rows[other + i]),
                };
                let mut exposed = word & !hidden;
                while exposed != 0 {
                    visit([i as u32 * 64 + exposed.trailing_zeros(), y, z]);
                    exposed &= exposed - 1;
                }
            }
        }
    }
}

/// The four corners of a face of a cell, in turn.
fn face(at: [u32; 3], axis: usize, ahead: i32) -> [Point3<f64>; 4] {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let mut corner = Point3::from(at.map(f64::from));
    if ahead > 0 {
        corner[axis] += 1.0;
    }
    let moved = |du: f64, dv: f64| {
        let mut p = corner;
        p[u] += du;
        p[v] += dv;
        p
    };
    [moved(0.0, 0.0), moved(1.0, 0.0), moved(1.0, 1.0), moved(0.0, 1.0)]
}

/// The outward normal of the surface near a cell (zero where there is no saying), and how much the cells around
/// crowd it beyond a plane: 0 to 1.
fn surroundings(cells: &LayeredCells, at: [u32; 3]) -> (Vector3<f64>, f32) {
    let [nx, ny, nz] = cells.dims.map(i64::from);
    let [x, y, z] = at.map(i64::from);
    let words = cells.dims[0].div_ceil(64) as usize;
    let (mut sum, mut count, mut room) = ([0_i64; 3], 0_i64, 0_i64);
    for dz in -REACH..=REACH {
        for dy in -REACH..=REACH {
            let left = REACH * REACH - dy * dy - dz * dz;
            if left < 0 {
                continue;
            }
            let reach = (0..=REACH).rev().find(|r| r * r <= left).unwrap_or(0);
            room += 2 * reach + 1;
            if !(0..ny).contains(&(y + dy)) || !(0..nz).contains(&(z + dz)) {
                continue;
            }
            let row = (y + dy + ny * (z + dz)) as usize * words;
            for dx in -reach..=reach {
                let column = x + dx;
                if (0..nx).contains(&column) && cells.rows[row + column as usize / 64] >> (column % 64) & 1 == 1 {
                    count += 1;
                    sum = [sum[0] - dx, sum[1] - dy, sum[2] - dz];
                }
            }
        }
    }
    let normal = Vector3::from(sum.map(|c| c as f64));
    let crowding = (2.0 * count as f32 / room as f32 - 1.15).clamp(0.0, 1.0);
    (normal.try_normalize(0.5).unwrap_or_default(), crowding)
}
