//! Which of the cells that no triangle touches lie inside.
//!
//! Cells that a closed surface misses fall into pieces, connected over faces that no triangle lies in, and the winding
//! number is a whole number, constant on each. So each row is cut into runs of untouched cells, runs that meet are
//! joined (union-find), and the winding number is asked for once a piece. What reaches the border of the grid is
//! outside.
//!
//! An open surface is closed by caps first (see [`crate::boundary`]): pieces are those of surface and caps together,
//! and with `k` for the whole number of a piece the winding number of the surface alone is `k - w`, `w` that of the
//! caps. Far from a hole `w` is small and `k` decides (the bound: a cap of area `A` no nearer than `d` fills at most
//! `A / d^2` of the `4 pi` around a point); near it each cell is decided for itself. Inside and outside then meet at
//! the mouth of the hole, where a flood fill would have leaked; the faces between them are counted.

use crate::boundary::Cap;
use crate::grid::runs;
use crate::lattice::Lattice;
use crate::surface::{Bits, Walls};
use crate::winding::Winding;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// Number of pieces from which a tree pays: it costs about as much as this many exact sums.
const TREE_PIECES: usize = 8;

/// How far a fast sum may be from a whole number to be taken for it. The fast sum errs by a few hundredths; smaller
/// costs exact sums, and at one half a piece could be taken for its neighbour.
const SURE: f64 = 0.25;

/// Most holes for which it is worth asking each whether it is far away.
const FEW_CAPS: usize = 64;

/// Cells of a run that are looked at together for whether a hole is near. Any number gives the same cells.
const CHUNK: usize = 16;

/// Untouched cells next to one another in a row.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u16,
    end: u16,
}

/// The pieces of what the surface misses. Node 0 is all that lies beyond the grid, node `i + 1` is run `i`.
struct Pieces {
    runs: Vec<Run>,
    /// For each row its first run, and the number of runs at the end.
    starts: Vec<u32>,
    parents: Vec<u32>,
}

/// What was found about the inside.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inside {
    pub(crate) cells: u64,
    pub(crate) pieces: usize,
    pub(crate) asked_singly: u64,
    pub(crate) leak_faces: u64,
    /// Cells inside a surface that is turned inwards there.
    pub(crate) turned: u64,
}

/// The surface to be asked about, in the coordinates of a box around it.
pub(crate) struct Surface {
    pub(crate) winding: Winding,
    /// What closes it, and that as one surface.
    pub(crate) caps: Vec<Cap>,
    pub(crate) caps_winding: Winding,
    /// Takes millimetres to the coordinates of `winding`.
    pub(crate) low: Point3<f64>,
    pub(crate) size: f64,
}

impl Surface {
    fn to_winding(&self, at: Point3<f64>) -> Point3<f64> {
        Point3::from((at - self.low) / self.size)
    }

    /// The whole number of surface and caps together, off both.
    fn whole(&self, at: &Point3<f64>, exactly: bool) -> i32 {
        if !exactly {
            let fast = self.winding.fast(at) + self.caps_winding.fast(at);
            if (fast - fast.round()).abs() < SURE {
                return fast.round() as i32;
            }
        }
        (self.winding.exact(at) + self.caps_winding.exact(at)).round() as i32
    }

    /// Whether the caps have a winding number below one half all along the way from `a` to `b`.
    fn is_far_from_caps(&self, a: &Point3<f64>, b: &Point3<f64>) -> bool {
        let way = b - a;
        let along = way.norm_squared().max(f64::MIN_POSITIVE);
        let bound = |cap: &Cap| {
            let part = ((cap.apex - a).dot(&way) / along).clamp(0.0, 1.0);
            let distance = (a + way * part - cap.apex).norm() - cap.radius;
            if distance > 0.0 { cap.area / (4.0 * PI * distance * distance) } else { f64::INFINITY }
        };
        self.caps.len() <= FEW_CAPS && self.caps.iter().map(bound).sum::<f64>() < 0.5
    }
}

/// What else there is to know where the surface has caps.
pub(crate) struct Capped {
    /// What the surface alone touches.
    pub(crate) touched: Bits,
    /// What surface and caps touch, and the walls of both.
    pub(crate) cells: Bits,
    pub(crate) walls: Walls,
    /// By axis and end of the grid, the cells whose face to the outside has a triangle of the surface.
    pub(crate) ends: [[Option<Bits>; 2]; 3],
}

/// Adds to `cells`, which hold what the surface touches, what lies inside. `go_on` gets the work done and in all
/// and may stop it.
///
/// # Arguments
/// * `capped`: what there is to say if there are caps.
pub(crate) fn fill(
    cells: &mut Bits,
    walls: &Walls,
    capped: Option<&Capped>,
    lattice: &Lattice,
    surface: &mut Surface,
    go_on: &dyn Fn(u64, u64) -> Option<()>,
) -> Option<Inside> {
    let (blocked, all_walls) = capped.map_or((&*cells, walls), |capped| (&capped.cells, &capped.walls));
    let mut pieces = Pieces::new(blocked, all_walls, lattice.dims);
    let samples = pieces.samples();
    let few = samples.len() <= TREE_PIECES;
    if !few || capped.is_some() {
        surface.winding.plant();
        surface.caps_winding.plant();
    }
    let found = Inside { pieces: samples.len(), ..Inside::default() };
    let mut filling = Filling { cells, surface, lattice, found };
    // Of each root the whole number of its piece.
    let mut numbers = vec![0; pieces.parents.len()];
    for (done, &(root, [row, x])) in samples.iter().enumerate() {
        go_on(done as u64, samples.len() as u64)?;
        numbers[root as usize] = filling.surface.whole(&filling.centre(row, x), few);
    }
    let rows = pieces.starts.len() - 1;
    for row in 0..rows {
        if capped.is_some() && row % 64 == 0 {
            go_on(row as u64, rows as u64)?;
        }
        for index in pieces.starts[row]..pieces.starts[row + 1] {
            let Run { first, end } = pieces.runs[index as usize];
            let ends = [u32::from(first), u32::from(end)];
            let number = f64::from(numbers[pieces.root(index + 1) as usize]);
            match capped {
                None => filling.found.take(filling.cells, row, ends, number),
                Some(_) => filling.take_beside_caps(row, ends, number),
            }
        }
        if let Some(capped) = capped {
            filling.take_in_caps(row, capped);
        }
    }
    let Filling { cells, mut found, .. } = filling;
    if let Some(capped) = capped {
        found.leak_faces = leak_faces(&capped.touched, cells, walls, lattice.dims);
        found.leak_faces += leak_faces_to_outside(&capped.touched, cells, &capped.ends, lattice.dims);
    }
    Some(found)
}

/// Cells that are being filled.
struct Filling<'a> {
    cells: &'a mut Bits,
    surface: &'a Surface,
    lattice: &'a Lattice,
    found: Inside,
}

impl Filling<'_> {
    /// The centre of a cell, in the coordinates of the winding numbers.
    fn centre(&self, row: u32, x: u32) -> Point3<f64> {
        let ny = self.lattice.dims[1];
        let steps = Vector3::new(f64::from(x), f64::from(row % ny), f64::from(row / ny));
        self.surface.to_winding(self.lattice.origin() + (steps + Vector3::repeat(0.5)) * self.lattice.cell)
    }

    /// Takes cells of a run of a surface with caps, `number` being that of surface and caps together: all at once far from the caps, where
    /// these cannot decide, and one by one near them.
    fn take_beside_caps(&mut self, row: usize, [first, end]: [u32; 2], number: f64) {
        let at = row as u32;
        for first in (first..end).step_by(CHUNK) {
            let end = end.min(first + CHUNK as u32);
            if self.surface.is_far_from_caps(&self.centre(at, first), &self.centre(at, end - 1)) {
                self.found.take(self.cells, row, [first, end], number);
                continue;
            }
            for x in first..end {
                let winding = number - self.surface.caps_winding.fast(&self.centre(at, x));
                self.found.take(self.cells, row, [x, x + 1], winding);
            }
            self.found.asked_singly += u64::from(end - first);
        }
    }

    /// Takes cells of a row that a cap touches and the surface does not. They are in no piece.
    fn take_in_caps(&mut self, row: usize, capped: &Capped) {
        let mut only_caps = capped.cells.row(row).to_vec();
        only_caps.iter_mut().zip(capped.touched.row(row)).for_each(|(caps, touched)| *caps &= !touched);
        for x in runs(&only_caps).flat_map(|(first, end)| first..end) {
            let winding = self.surface.winding.fast(&self.centre(row as u32, x));
            self.found.take(self.cells, row, [x, x + 1], winding);
            self.found.asked_singly += 1;
        }
    }
}

impl Inside {
    /// Takes the cells of a row, from the first up to the end, if the winding number says so.
    fn take(&mut self, cells: &mut Bits, row: usize, [first, end]: [u32; 2], winding: f64) {
        if winding.abs() > 0.5 {
            cells.set(row, first, end);
            self.cells += u64::from(end - first);
            self.turned += if winding < 0.0 { u64::from(end - first) } else { 0 };
        }
    }
}

/// Number of faces of untouched cells that lead out of the grid from a cell taken, and no triangle lies there.
fn leak_faces_to_outside(touched: &Bits, cells: &Bits, ends: &[[Option<Bits>; 2]; 3], [nx, ny, nz]: [u32; 3]) -> u64 {
    let mut faces = 0;
    let (first, last) = ((0, 1), ((nx - 1) as usize / 64, 1 << ((nx - 1) % 64)));
    for row in 0..(ny * nz) as usize {
        let (y, z) = (row as u32 % ny, row as u32 / ny);
        let mut count = |axis: usize, end: usize, word: usize, mask: u64| {
            let wall = ends[axis][end].as_ref().map_or(0, |bits| bits.row(row)[word]);
            let leaks = cells.row(row)[word] & !touched.row(row)[word] & !wall & mask;
            faces += u64::from(leaks.count_ones());
        };
        for (end, (word, bit)) in [first, last].into_iter().enumerate() {
            count(0, end, word, bit);
        }
        for (axis, at, side) in [(1, y, ny), (2, z, nz)] {
            for end in [0, 1] {
                if at == [0, side - 1][end] {
                    (0..=last.0).for_each(|word| count(axis, end, word, !0));
                }
            }
        }
    }
    faces
}

/// Number of faces between a cell taken and one not taken, both untouched, and no wall between.
fn leak_faces(touched: &Bits, cells: &Bits, walls: &Walls, dims: [u32; 3]) -> u64 {
    let [nx, ny, nz] = dims;
    let mut faces = 0;
    let wall = |axis: usize, row: usize, word: usize| walls.low_faces[axis].as_ref().map_or(0, |b| b.row(row)[word]);
    for row in 0..(ny * nz) as usize {
        let (y, z) = (row as u32 % ny, row as u32 / ny);
        let mut before = (0, 0);
        for word in 0..nx.div_ceil(64) as usize {
            let taken = |row: usize| cells.row(row)[word];
            let free = |row: usize| !touched.row(row)[word];
            let (here, untouched) = (taken(row), free(row));
            // The cell before each, along x: the last of the word before comes in from below.
            let (prior, prior_free) = (here << 1 | before.0, untouched << 1 | before.1);
            let mut between = (here ^ prior) & untouched & prior_free & !wall(0, row, word);
            if word + 1 == nx.div_ceil(64) as usize && nx % 64 != 0 {
                between &= !0 >> (64 - nx % 64);
            }
            faces += u64::from(between.count_ones());
            before = (here >> 63, untouched >> 63);
            for (axis, at, step) in [(1, y, 1), (2, z, ny as usize)] {
                if at > 0 {
                    let other = row - step;
                    let between = (here ^ taken(other)) & untouched & free(other) & !wall(axis, row, word);
                    faces += u64::from(between.count_ones());
                }
            }
        }
    }
    faces
}

impl Pieces {
    fn new(cells: &Bits, walls: &Walls, dims: [u32; 3]) -> Self {
        let [nx, ny, nz] = dims;
        let mut pieces = Pieces { runs: Vec::new(), starts: vec![0], parents: vec![0] };
        let mut free = vec![0; nx.div_ceil(64) as usize];
        for row in 0..(ny * nz) as usize {
            for (free, word) in free.iter_mut().zip(cells.row(row)) {
                *free = !word;
            }
            if nx % 64 != 0 {
                let last = free.len() - 1;
                free[last] &= !0 >> (64 - nx % 64);
            }
            let wall_x = walls.low_faces[0].as_ref().map(|bits| bits.row(row));
            for (first, end) in runs(&free) {
                pieces.cut(first, end, wall_x);
            }
            pieces.starts.push(pieces.runs.len() as u32);
            let (y, z) = (row as u32 % ny, row as u32 / ny);
            pieces.join_border(row, [y, z], dims, walls);
            for (axis, at, step) in [(1, y, 1), (2, z, ny as usize)] {
                if at > 0 {
                    pieces.join_rows(row - step, row, walls.low_faces[axis].as_ref().map(|bits| bits.row(row)));
                }
            }
        }
        pieces
    }

    /// Adds the runs that walls cut a run into.
    fn cut(&mut self, first: u32, end: u32, wall: Option<&[u64]>) {
        let mut from = first;
        let walls = wall.into_iter().flat_map(|wall| runs(wall).flat_map(|(first, end)| first..end));
        for to in walls.skip_while(|&x| x <= first).take_while(|&x| x < end).chain([end]) {
            self.parents.push(self.parents.len() as u32);
            self.runs.push(Run { first: from as u16, end: to as u16 });
            from = to;
        }
    }

    /// Joins the runs of a row that reach the border of the grid with what lies beyond. A side of the grid that any
    /// triangle lies in is left alone: pieces that end there are asked for like any other.
    fn join_border(&mut self, row: usize, at: [u32; 2], dims: [u32; 3], walls: &Walls) {
        let open = |axis: usize, far: bool| !walls.on_border[axis][usize::from(far)];
        let beside = (1..3).any(|axis| {
            (at[axis - 1] == 0 && open(axis, false)) || (at[axis - 1] + 1 == dims[axis] && open(axis, true))
        });
        for index in self.starts[row]..self.starts[row + 1] {
            let Run { first, end } = self.runs[index as usize];
            if beside || (first == 0 && open(0, false)) || (u32::from(end) == dims[0] && open(0, true)) {
                self.join(0, index + 1);
            }
        }
    }

    /// Joins the runs of two rows that meet over a face without a wall.
    fn join_rows(&mut self, row: usize, next: usize, wall: Option<&[u64]>) {
        let [(mut a, end_a), (mut b, end_b)] = [row, next].map(|row| (self.starts[row], self.starts[row + 1]));
        while a < end_a && b < end_b {
            let (run_a, run_b) = (self.runs[a as usize], self.runs[b as usize]);
            let (first, end) = (run_a.first.max(run_b.first), run_a.end.min(run_b.end));
            if first < end && (first..end).any(|x| wall.is_none_or(|wall| wall[x as usize / 64] >> (x % 64) & 1 == 0)) {
                self.join(a + 1, b + 1);
            }
            (a, b) = (a + u32::from(run_a.end <= run_b.end), b + u32::from(run_b.end <= run_a.end));
        }
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.parents[node as usize] != node {
            let up = self.parents[self.parents[node as usize] as usize];
            self.parents[node as usize] = up;
            node = up;
        }
        node
    }

    /// Joins two pieces under the lower of their roots.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// For each piece that does not reach beyond the grid its root and a cell, as row and x.
    fn samples(&mut self) -> Vec<(u32, [u32; 2])> {
        let mut seen = vec![false; self.parents.len()];
        seen[0] = true;
        let mut samples = Vec::new();
        for row in 0..self.starts.len() as u32 - 1 {
            for index in self.starts[row as usize]..self.starts[row as usize + 1] {
                let root = self.root(index + 1);
                if !seen[root as usize] {
                    seen[root as usize] = true;
                    let Run { first, end } = self.runs[index as usize];
                    samples.push((root, [row, (u32::from(first) + u32::from(end)) / 2]));
                }
            }
        }
        samples
    }
}
