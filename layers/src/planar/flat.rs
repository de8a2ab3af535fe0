//! The flat layers of a part: triangulated sections through the middle of each, and which cells of a grid belong to which.
//!
//! Dissertation of C. Dai (TU Delft 2020), section 2.4: each part is printed in flat layers along the normal of its base plane. All layers of a
//! part are equally high, as near to the wanted height as fills the part exactly, so none of its volume is left over at the top.

use super::region::Region;
use super::solid::{CutPlane, PlaneFrame, Solid, slice, triangulate};
use nalgebra::{Isometry3, Point3, Vector3};

/// The layers of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatLayers {
    /// The direction in which they are stacked, of length 1.
    pub direction: Vector3<f64>,
    /// Height of the lowest point of the part along the direction, in mm.
    pub low_mm: f64,
    /// Height of each layer, in mm; of the highest one if they vary.
    pub height_mm: f64,
    /// From the bottom up.
    pub layers: Vec<FlatLayer>,
    frame: PlaneFrame,
}

/// A layer as a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatLayer {
    /// Where it begins, along the direction, in mm.
    pub low_mm: f64,
    /// Where it ends, in mm.
    pub high_mm: f64,
    /// Points of the section through the middle of the layer, in mm.
    pub vertices: Vec<Point3<f64>>,
    /// Triangles between them, counter-clockwise seen against the direction. None where a section is narrower than a thousandth of the height.
    pub triangles: Vec<[u32; 3]>,
    /// Thickness at each triangle, in mm: the height of the layer.
    pub thickness: Vec<f64>,
    /// The section in the plane's coordinates.
    region: Region,
}

/// Why a part has no layers.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlatError {
    /// The height is not a positive number, or there would be more than [`MAX_LAYERS`] layers.
    #[error(
        "layers of {height_mm} mm on a part of {part_mm} mm: the height must be positive, with at most {MAX_LAYERS} layers"
    )]
    Height {
        /// The height that was asked for.
        height_mm: f64,
        /// Extent of the part along the direction.
        part_mm: f64,
    },
    /// The direction has no length.
    #[error("the direction has no length")]
    Direction,
}

/// Most layers of a part.
pub const MAX_LAYERS: usize = 100_000;

/// Outlines are simplified within this share of a layer's height: a twentieth of what a machine resolves.
const SIMPLIFIED: f64 = 0.01;

/// Outlines shrink by this share of that, so that none touches itself.
const APART: f64 = 0.2;

/// A triangle lower than this share of its longest side is left out: what it covers is nothing.
const FLAT: f64 = 1e-9;

/// Slices a part into flat layers.
///
/// # Returns
/// At least one layer; together they are as high as the part. Each is the section at its middle.
///
/// # Errors
/// [`FlatError`] for a direction without length or a height that is not positive.
///
/// # Cost
/// A pass over the triangles, and the square of the corners of the section, for each layer. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::{Solid, flat_layers};
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 10.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let part = flat_layers(&Solid::new(&points, &faces)?, &Vector3::z(), 0.9)?;
/// assert_eq!((part.layers.len(), part.layers[0].triangles.len()), (11, 2));
/// assert!((part.height_mm - 10.0 / 11.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn flat_layers(part: &Solid, direction: &Vector3<f64>, height_mm: f64) -> Result<FlatLayers, FlatError> {
    let Some(direction) = direction.try_normalize(0.0).filter(|d| d.iter().all(|c| c.is_finite())) else {
        return Err(FlatError::Direction);
    };
    let [low, high] = part.extent(&direction);
    let part_mm = high - low;
    if !(height_mm > 0.0 && part_mm / height_mm <= MAX_LAYERS as f64) {
        return Err(FlatError::Height { height_mm, part_mm });
    }
    let count = (part_mm / height_mm).round().max(1.0) as usize;
    let height = part_mm / count as f64;
    let lowest = CutPlane::through(&Point3::from(direction * low), &direction).map_err(|_| FlatError::Direction)?;
    let frame = PlaneFrame::of(&lowest);
    let section = |k: usize| {
        let [bottom, middle, top] = [0.0, 0.5, 1.0].map(|share| (k as f64 + share) * height);
        ([low + bottom, low + top], Region::of(&slice(part, &lowest.moved(middle), &frame)))
    };
    Ok(FlatLayers { low_mm: low, height_mm: height, ..of_sections(direction, frame, (0..count).map(section)) })
}

/// Layers as surfaces, from the bottom up: where each begins and ends, and its section in a frame across the direction.
pub(super) fn of_sections(
    direction: Vector3<f64>,
    frame: PlaneFrame,
    sections: impl Iterator<Item = ([f64; 2], Region)>,
) -> FlatLayers {
    let base = frame.origin.coords.dot(&direction);
    let layers: Vec<FlatLayer> = sections
        .map(|([low_mm, high_mm], region)| {
            let height = high_mm - low_mm;
            let within = SIMPLIFIED * height;
            let region = region.simplified(within);
            let region = region.grown(-APART * within).simplified(APART * within);
            let region = region.without_specks((1e-3 * height).powi(2));
            surface(region, direction * ((low_mm + high_mm) / 2.0 - base), [low_mm, high_mm], &frame)
        })
        .collect();
    FlatLayers {
        direction,
        low_mm: layers.first().map_or(base, |layer| layer.low_mm),
        height_mm: layers.iter().map(|layer| layer.high_mm - layer.low_mm).fold(0.0, f64::max),
        layers,
        frame,
    }
}

/// A section, raised from the plane of its frame, as a triangulated surface.
fn surface(region: Region, raised: Vector3<f64>, [low_mm, high_mm]: [f64; 2], frame: &PlaneFrame) -> FlatLayer {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for polygon in region.polygons() {
        let contours: Vec<_> = std::iter::once(polygon.outer).chain(polygon.holes).collect();
        let mut loops = Vec::new();
        for contour in &contours {
            let first = vertices.len() as u32;
            vertices.extend(contour.iter().map(|p| frame.place(p) + raised));
            loops.push((first..vertices.len() as u32).collect());
        }
        triangles.extend(triangulate(&loops, &contours));
    }
    triangles.retain(|corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        (b - a).cross(&(c - a)).norm() > FLAT * longest
    });
    let thickness = vec![high_mm - low_mm; triangles.len()];
    FlatLayer { low_mm, high_mm, vertices, triangles, thickness, region }
}

impl FlatLayers {
    /// The layer that a point lies in; none outside of the part.
    pub fn layer_at(&self, p: &Point3<f64>) -> Option<usize> {
        let height = p.coords.dot(&self.direction);
        let layer = self.layers.partition_point(|layer| layer.high_mm <= height);
        // The top of the part is of its last layer.
        let layer = layer.min(self.layers.len().checked_sub(1)?);
        let FlatLayer { low_mm, high_mm, region, .. } = &self.layers[layer];
        let is_within = (*low_mm..=*high_mm).contains(&height);
        (is_within && region.contains(&self.frame.flat(p))).then_some(layer)
    }

    /// The same layers, moved and turned as a whole.
    pub fn moved(&self, by: &Isometry3<f64>) -> FlatLayers {
        let direction = by.rotation * self.direction;
        let shift = by.translation.vector.dot(&direction);
        let layer = |layer: &FlatLayer| FlatLayer {
            low_mm: layer.low_mm + shift,
            high_mm: layer.high_mm + shift,
            vertices: layer.vertices.iter().map(|p| by * p).collect(),
            ..layer.clone()
        };
        let PlaneFrame { origin, u, v } = self.frame;
        FlatLayers {
            direction,
            low_mm: self.low_mm + shift,
            height_mm: self.height_mm,
            layers: self.layers.iter().map(layer).collect(),
            frame: PlaneFrame { origin: by * origin, u: by.rotation * u, v: by.rotation * v },
        }
    }
}

/// Which cells of a grid belong to which layer, for all parts in their order; layers are numbered through.
///
/// A cell belongs to the layer that its middle lies in. One that lies in none, at the surface, goes with a cell next to it that does, the
/// one of the earliest layer if there are several.
///
/// # Arguments
/// * `dims`, `rows`: the grid and its solid cells, a bit each: rows along x, in words of 64, then y, then z.
/// * `origin`: the lowest corner of the grid, in mm.
///
/// # Returns
/// For each layer its cells, numbered `x + nx * (y + ny * z)`, by rising number. A cell that nothing connects with a layer is in none.
///
/// # Cost
/// `O(e)` for each cell and part, `e` the edges of a section.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::{Solid, cells_by_flat_layer, flat_layers};
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 2.0, f64::from(i >> 1 & 1) * 2.0, f64::from(i >> 2) * 2.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let part = flat_layers(&Solid::new(&points, &faces)?, &Vector3::z(), 1.0)?;
/// let cells = cells_by_flat_layer(&[part], [2, 2, 2], &[3; 4], 1.0, &Point3::origin());
/// assert_eq!(cells, [[0, 1, 2, 3], [4, 5, 6, 7]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cells_by_flat_layer(
    parts: &[FlatLayers],
    dims: [u32; 3],
    rows: &[u64],
    cell_mm: f64,
    origin: &Point3<f64>,
) -> Vec<Vec<u32>> {
    const NONE: u32 = u32::MAX;
    let [nx, ny, nz] = dims.map(|n| n as usize);
    let words = nx.div_ceil(64);
    let is_solid = |x: usize, y: usize, z: usize| {
        rows.get((z * ny + y) * words + x / 64).is_some_and(|word| word >> (x % 64) & 1 == 1)
    };
    let mut firsts = Vec::with_capacity(parts.len());
    let mut count = 0;
    for part in parts {
        firsts.push(count);
        count += part.layers.len();
    }
    let mut layer_of = vec![NONE; nx * ny * nz];
    let mut open = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in (0..nx).filter(|&x| is_solid(x, y, z)) {
                let middle = origin + Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * cell_mm;
                let found = parts.iter().zip(&firsts).find_map(|(part, first)| Some(first + part.layer_at(&middle)?));
                match found {
                    Some(layer) => layer_of[x + nx * (y + ny * z)] = layer as u32,
                    None => open.push([x, y, z]),
                }
            }
        }
    }
    // Rounds from what is known, each by what was known before it.
    while !open.is_empty() {
        let known = |&[x, y, z]: &[usize; 3]| {
            let near = |c: usize, n: usize| c.saturating_sub(1)..(c + 2).min(n);
            let around = near(z, nz).flat_map(|z| near(y, ny).map(move |y| (y, z)));
            around.flat_map(|(y, z)| near(x, nx).map(move |x| x + nx * (y + ny * z))).map(|c| layer_of[c]).min()
        };
        let found: Vec<u32> = open.iter().map(|at| known(at).unwrap_or(NONE)).collect();
        if found.iter().all(|&layer| layer == NONE) {
            break;
        }
        for ([x, y, z], &layer) in open.iter().zip(&found) {
            layer_of[x + nx * (y + ny * z)] = layer;
        }
        let mut layers = found.into_iter();
        open.retain(|_| layers.next() == Some(NONE));
    }
    let mut cells = vec![Vec::new(); count];
    for (cell, &layer) in layer_of.iter().enumerate().filter(|(_, layer)| **layer != NONE) {
        cells[layer as usize].push(cell as u32);
    }
    cells
}
