//! Values on a lattice, trilinear between its nodes.
//!
//! Nodes are stored in bricks of 4 x 4 x 4, x fastest in a brick and among bricks: a question then touches one to three
//! lines of cache that lie side by side, where in rows it is four in far places; waiting for them is what it costs.

use nalgebra::{Point3, Vector3};

/// Nodes along a side of a brick.
const SIDE: usize = 4;

/// Values on a lattice.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lattice {
    origin: Point3<f64>,
    pub spacing: f64,
    /// One over the spacing.
    inverse: f64,
    /// Nodes along x, y, z. At least two each.
    dims: [usize; 3],
    /// Bricks along x, and in a layer of them.
    bricks: [usize; 2],
    values: Vec<f32>,
}

impl Lattice {
    /// `rows`: the values of all nodes, x fastest.
    pub fn new(origin: Point3<f64>, spacing: f64, dims: [usize; 3], rows: &[f32]) -> Self {
        let [nx, ny, nz] = dims.map(|n| n.div_ceil(SIDE));
        let mut lattice =
            Lattice { origin, spacing, inverse: 1.0 / spacing, dims, bricks: [nx, nx * ny], values: vec![] };
        lattice.values = vec![0.0; nx * ny * nz * SIDE * SIDE * SIDE];
        for (row, values) in rows.chunks(dims[0]).enumerate() {
            let [_, y, z] = lattice.parts([0, row % dims[1], row / dims[1]]);
            for (x, &value) in values.iter().enumerate() {
                let at = lattice.parts([x, 0, 0])[0] + y + z;
                lattice.values[at] = value;
            }
        }
        lattice
    }

    /// What each coordinate of a node adds to its index.
    #[inline]
    fn parts(&self, [x, y, z]: [usize; 3]) -> [usize; 3] {
        let brick = SIDE * SIDE * SIDE;
        [
            x / SIDE * brick + x % SIDE,
            y / SIDE * self.bricks[0] * brick + y % SIDE * SIDE,
            z / SIDE * self.bricks[1] * brick + z % SIDE * SIDE * SIDE,
        ]
    }

    /// Where a point lies, in steps from the first node.
    #[inline]
    pub fn place(&self, point: &Point3<f64>) -> [f64; 3] {
        [0, 1, 2].map(|d| (point[d] - self.origin[d]) * self.inverse)
    }

    /// How many steps a place is from either end of an axis; below 0 beyond it.
    #[inline]
    pub fn inside(&self, place: &[f64; 3], d: usize) -> [f64; 2] {
        [place[d], (self.dims[d] - 1) as f64 - place[d]]
    }

    /// The cell of a place, how far into it, and how many millimetres the place is off the lattice.
    #[inline]
    fn locate(&self, place: &[f64; 3]) -> ([usize; 3], [f64; 3], Vector3<f64>) {
        let mut off = Vector3::zeros();
        let (mut cell, mut share) = ([0; 3], [0.0; 3]);
        for d in 0..3 {
            let held = place[d].clamp(0.0, (self.dims[d] - 1) as f64);
            off[d] = (place[d] - held) * self.spacing;
            // Not below zero, so cut off is rounded down.
            cell[d] = (held as usize).min(self.dims[d] - 2);
            share[d] = held - cell[d] as f64;
        }
        (cell, share, off)
    }

    #[inline]
    fn corners(&self, cell: &[usize; 3]) -> [f64; 8] {
        let (low, high) = (self.parts(*cell), self.parts(cell.map(|k| k + 1)));
        let [[a, b], [c, d]] = [[low[1] + low[2], high[1] + low[2]], [low[1] + high[2], high[1] + high[2]]];
        let [x, next] = [low[0], high[0]];
        [a + x, a + next, b + x, b + next, c + x, c + next, d + x, d + next].map(|k| f64::from(self.values[k]))
    }

    /// The value at a place; off the lattice as if it were a distance from something within.
    #[inline]
    pub fn distance(&self, place: &[f64; 3]) -> f64 {
        let (cell, [x, y, z], off) = self.locate(place);
        let c = self.corners(&cell);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let low = mix(mix(c[0], c[1], x), mix(c[2], c[3], x), y);
        let high = mix(mix(c[4], c[5], x), mix(c[6], c[7], x), y);
        let value = mix(low, high, z);
        let beyond = off.norm_squared();
        if beyond > 0.0 { (beyond + value * value).sqrt() } else { value + 0.0 * beyond }
    }

    /// The same, and its derivative by the point, in values a millimetre.
    #[inline]
    pub fn gradient(&self, place: &[f64; 3]) -> (f64, Vector3<f64>) {
        let (cell, [x, y, z], off) = self.locate(place);
        let c = self.corners(&cell);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let along_x = [mix(c[0], c[1], x), mix(c[2], c[3], x), mix(c[4], c[5], x), mix(c[6], c[7], x)];
        let (low, high) = (mix(along_x[0], along_x[1], y), mix(along_x[2], along_x[3], y));
        let value = mix(low, high, z);
        let slope_x = mix(mix(c[1] - c[0], c[3] - c[2], y), mix(c[5] - c[4], c[7] - c[6], y), z);
        let slope_y = mix(along_x[1] - along_x[0], along_x[3] - along_x[2], z);
        let slope = Vector3::new(slope_x, slope_y, high - low) * self.inverse;
        let beyond = off.norm_squared();
        if beyond > 0.0 {
            let all = (beyond + value * value).sqrt();
            let part = |d: usize| if off[d].abs() > 0.0 { off[d] / all } else { slope[d] * value / all };
            return (all, Vector3::new(part(0), part(1), part(2)));
        }
        (value + 0.0 * beyond, slope)
    }
}
