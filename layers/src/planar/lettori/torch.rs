//! Where the torch cannot be: an estimate by which walls are chosen.
//!
//! The torch is a cone from what it lays to its mouth, half a diameter wide at the stand-off, and from there on a cylinder without end. It must
//! not meet what is printed before, nor the plate. The audit judges the result by code of its own.

use super::layers::Stand;
use super::options::VolumeOptions;
use crate::planar::Solid;
use nalgebra::{Point3, Vector3};

/// The plate: all that is not above a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plate {
    pub normal: Vector3<f64>,
    pub offset: f64,
}

/// Columns along the longer side of a part, with the torch around it.
const COLUMNS: f64 = 56.0;

/// Parallel columns over the box of a part, a torch's radius wider on each side.
struct Columns {
    axes: [Vector3<f64>; 3],
    low: [f64; 2],
    cell: f64,
    counts: [usize; 2],
}

impl Columns {
    fn over(part: &Solid, direction: &Vector3<f64>, radius: f64) -> Self {
        let mut other = Vector3::zeros();
        other[direction.iamin()] = 1.0;
        let u = direction.cross(&other).normalize();
        let axes = [u, direction.cross(&u), *direction];
        let [across, along] = [part.extent(&axes[0]), part.extent(&axes[1])];
        let size = |[low, high]: [f64; 2]| high - low + 2.0 * radius;
        let cell = size(across).max(size(along)) / COLUMNS;
        let count = |extent| (size(extent) / cell).ceil().max(1.0) as usize;
        Columns { axes, low: [across[0] - radius, along[0] - radius], cell, counts: [count(across), count(along)] }
    }

    /// Calls with each column whose middle is inside a triangle, and the height of the triangle there.
    fn pierce(&self, corners: [Point3<f64>; 3], each: &mut impl FnMut(usize, f64)) {
        let [a, b, c] = corners.map(|p| self.axes.map(|axis| p.coords.dot(&axis)));
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if doubled == 0.0 {
            return;
        }
        let range = |axis: usize| {
            let at = [a, b, c].map(|p| (p[axis] - self.low[axis]) / self.cell - 0.5);
            let [low, high] = [at[0].min(at[1]).min(at[2]).ceil(), at[0].max(at[1]).max(at[2]).floor() + 1.0];
            low.max(0.0) as usize..(high.max(0.0) as usize).min(self.counts[axis])
        };
        for j in range(1) {
            for i in range(0) {
                let [x, y] = [(0, i), (1, j)].map(|(axis, k)| self.low[axis] + (k as f64 + 0.5) * self.cell);
                let share = |p: [f64; 3], q: [f64; 3]| ((p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x)) / doubled;
                let [of_a, of_b, of_c] = [share(b, c), share(c, a), share(a, b)];
                if of_a >= 0.0 && of_b >= 0.0 && of_c > 0.0 {
                    each(j * self.counts[0] + i, of_a * a[2] + of_b * b[2] + of_c * c[2]);
                }
            }
        }
    }
}

/// Volume of a part that the torch cannot lay, since it would be in one of the earlier solids or in the plate.
///
/// # Cost
/// A pass over all triangles, and for each of some 3000 columns the columns within the torch's radius.
pub(super) fn blocked_mm3(
    part: &Solid,
    stand: &Stand,
    earlier: &[&Solid],
    plate: &Plate,
    options: &VolumeOptions,
) -> f64 {
    let radius = options.torch_diameter_mm / 2.0;
    let columns = Columns::over(part, &stand.direction, radius);
    let [nx, ny] = columns.counts;
    // What stands is of account up to its top: the torch goes on upwards without end.
    let mut tops = vec![f64::NEG_INFINITY; nx * ny];
    for solid in earlier.iter().filter(|solid| solid.extent(&stand.direction)[1] > stand.base) {
        for triangle in 0..solid.triangles().len() {
            columns.pierce(solid.corners(triangle), &mut |column, height| tops[column] = tops[column].max(height));
        }
    }
    let mut inside: Vec<Vec<f64>> = vec![Vec::new(); nx * ny];
    for triangle in 0..part.triangles().len() {
        columns.pierce(part.corners(triangle), &mut |column, height| inside[column].push(height));
    }
    let of_plate = plate_height(stand, plate, options);
    let reach = (radius / columns.cell).floor() as usize;
    let mut blocked = 0.0;
    for j in 0..ny {
        for i in 0..nx {
            let heights = &mut inside[j * nx + i];
            if heights.is_empty() {
                continue;
            }
            heights.sort_by(f64::total_cmp);
            let middle = columns.axes[0] * (columns.low[0] + (i as f64 + 0.5) * columns.cell)
                + columns.axes[1] * (columns.low[1] + (j as f64 + 0.5) * columns.cell);
            let mut least = of_plate(middle);
            for y in j.saturating_sub(reach)..(j + reach + 1).min(ny) {
                for x in i.saturating_sub(reach)..(i + reach + 1).min(nx) {
                    let top = tops[y * nx + x];
                    if top > least {
                        let far = (x.abs_diff(i) as f64).hypot(y.abs_diff(j) as f64) * columns.cell;
                        if far <= radius {
                            least = least.max(top - options.standoff_mm * far / radius);
                        }
                    }
                }
            }
            // A layer is laid from its top, half a layer above its middle.
            let least = least - options.layer_mm / 2.0 - options.tolerance_mm;
            for piece in heights.chunks_exact(2) {
                blocked += (piece[1].min(least) - piece[0].max(stand.base)).max(0.0);
            }
        }
    }
    blocked * columns.cell * columns.cell
}

/// The least height along the direction at which the torch is above the plate, over a point across the direction.
fn plate_height(stand: &Stand, plate: &Plate, options: &VolumeOptions) -> impl Fn(Vector3<f64>) -> f64 {
    let (normal, offset) = (plate.normal, plate.offset);
    let cos = stand.direction.dot(&normal);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    // How far the torch reaches down from what it lays: the rim of its mouth, or what it lays itself.
    let down = (options.torch_diameter_mm / 2.0 * sin - options.standoff_mm * cos).max(0.0);
    move |across: Vector3<f64>| {
        let over = across.dot(&normal) - offset;
        if cos > 1e-9 {
            (down - over) / cos
        } else if cos < -1e-9 || over < down {
            f64::INFINITY
        } else {
            f64::NEG_INFINITY
        }
    }
}
