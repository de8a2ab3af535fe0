//! The part as points of a grid: what the input covers of it, and what it lays outside.

use super::figures::{Audited, Check, Found, Place, Verdict};
use curvlay_examples::args::Failure;
use curvlay_examples::mesh::Mesh;
use nalgebra::{Point3, Vector3};

/// Why nothing is compared without a part.
pub const NO_PART: &str = "nothing to compare with: give the part as --mesh";

/// The volume around part and input in cubes, by their middles: whether each is in the part, and whether something covers it.
pub struct Volume {
    low: Point3<f64>,
    step: f64,
    sides: [usize; 3],
    part: Vec<u64>,
    covered: Vec<u64>,
}

impl Volume {
    /// A part, and room for what was laid within `bounds`.
    ///
    /// # Errors
    /// A line for a grid of more than `max_cells`, before it is allocated.
    pub fn of(part: &Mesh, bounds: [Point3<f64>; 2], step: f64, max_cells: u64) -> Result<Self, Failure> {
        let [low, high] = part.bounds().unwrap_or(bounds);
        let mut volume = Volume::new([low.inf(&bounds[0]), high.sup(&bounds[1])], step, max_cells)?;
        volume.fill(part);
        Ok(volume)
    }

    fn new(bounds: [Point3<f64>; 2], step: f64, max_cells: u64) -> Result<Self, Failure> {
        let low = bounds[0] - Vector3::repeat(step);
        let sides = [0, 1, 2].map(|axis| ((bounds[1][axis] - low[axis]) / step).ceil() + 1.0);
        let count: f64 = sides.iter().product();
        if count.is_nan() || count > max_cells as f64 {
            let needed = step * (count / max_cells as f64).cbrt();
            return Err(Failure::of_arguments(format!(
                "to compare volumes in cubes of {step:.3} mm takes {count:.1e} of them, more than --max-cells {max_cells}: --step {needed:.2} would do"
            )));
        }
        let sides = sides.map(|side| side as usize);
        let words = sides[0].div_ceil(64) * sides[1] * sides[2];
        Ok(Volume { low, step, sides, part: vec![0; words], covered: vec![0; words] })
    }

    fn word(&self, [x, y, z]: [usize; 3]) -> (usize, u64) {
        (self.sides[0].div_ceil(64) * (y + self.sides[1] * z) + x / 64, 1 << (x % 64))
    }

    fn middle(&self, at: [usize; 3]) -> Point3<f64> {
        self.low + Vector3::from(at.map(|k| (k as f64 + 0.5) * self.step))
    }

    /// Middles within a range along an axis.
    fn range(&self, axis: usize, from: f64, to: f64) -> std::ops::Range<usize> {
        let at = |x: f64| ((x - self.low[axis]) / self.step - 0.5).ceil().clamp(0.0, self.sides[axis] as f64) as usize;
        at(from)..at(to)
    }

    /// Fills the part: along each line in z, the ways between surfaces that are entered and left.
    fn fill(&mut self, mesh: &Mesh) {
        let columns = self.sides[0] * self.sides[1];
        let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); columns];
        // Beside the lattice by an odd share of a step: corners and edges of a mesh do not lie on lines.
        let aside = Vector3::new(0.000_314_159, 0.000_271_828, 0.0) * self.step;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize] - aside);
            let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            if area.abs() <= 0.0 {
                continue;
            }
            let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
            let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
            for y in self.range(1, least(1), most(1) + self.step) {
                for x in self.range(0, least(0), most(0) + self.step) {
                    let p = self.middle([x, y, 0]);
                    let cross =
                        |u: &Point3<f64>, v: &Point3<f64>| (v.x - u.x) * (p.y - u.y) - (v.y - u.y) * (p.x - u.x);
                    let [u, v, w] = [cross(&b, &c), cross(&c, &a), cross(&a, &b)].map(|share| share / area);
                    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                        let z = u * a.z + v * b.z + w * c.z;
                        crossings[x + self.sides[0] * y].push((z, if area > 0.0 { -1 } else { 1 }));
                    }
                }
            }
        }
        for (at, column) in crossings.iter_mut().enumerate() {
            column.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y) = (at % self.sides[0], at / self.sides[0]);
            let mut depth = 0;
            for pair in column.windows(2) {
                depth += pair[0].1;
                if depth > 0 {
                    for z in self.range(2, pair[0].0, pair[1].0) {
                        let (word, bit) = self.word([x, y, z]);
                        self.part[word] |= bit;
                    }
                }
            }
        }
    }

    /// The points of a box.
    fn within(&self, [low, high]: [Point3<f64>; 2]) -> impl Iterator<Item = (usize, u64)> + '_ {
        let [xs, ys, zs] = [0, 1, 2].map(|axis| self.range(axis, low[axis], high[axis]));
        zs.flat_map(move |z| ys.clone().map(move |y| [y, z]))
            .flat_map(move |[y, z]| xs.clone().map(move |x| self.word([x, y, z])))
    }

    /// Marks a box as covered.
    pub fn cover(&mut self, bounds: [Point3<f64>; 2]) {
        let points: Vec<(usize, u64)> = self.within(bounds).collect();
        points.into_iter().for_each(|(word, bit)| self.covered[word] |= bit);
    }

    /// Marks those middles of a box that a rule picks.
    pub fn cover_where(&mut self, [low, high]: [Point3<f64>; 2], has: impl Fn(&Point3<f64>) -> bool) {
        let [xs, ys, zs] = [0, 1, 2].map(|axis| self.range(axis, low[axis], high[axis]));
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let (word, bit) = self.word([x, y, z]);
                    if self.part[word] & !self.covered[word] & bit != 0 && has(&self.middle([x, y, z])) {
                        self.covered[word] |= bit;
                    }
                }
            }
        }
    }

    /// Whether a box has a point of the part.
    pub fn has_part(&self, bounds: [Point3<f64>; 2]) -> bool {
        self.within(bounds).any(|(word, bit)| self.part[word] & bit != 0)
    }

    fn cube(&self) -> f64 {
        self.step.powi(3)
    }

    /// Enters what nothing covers, once all that was laid does.
    pub fn judge(&self, audited: &mut Audited) {
        audited.about.extend([("part_volume_mm3", self.part_mm3()), ("step_mm", self.step)]);
        audited.set(Check::Uncovered, Verdict::Found(self.uncovered()));
    }

    /// Volume of the part, in mm3.
    fn part_mm3(&self) -> f64 {
        ones(self.part.iter().copied()) as f64 * self.cube()
    }

    /// What of the part nothing covers.
    fn uncovered(&self) -> Found {
        let words: Vec<u64> = self.part.iter().zip(&self.covered).map(|(&part, &covered)| part & !covered).collect();
        let amount = ones(words.iter().copied()) as f64 * self.cube();
        let part = self.part_mm3();
        let share = (part > 0.0).then(|| amount / part);
        Found { amount, unit: "mm3", share, ..Found::default() }.with_places(self.lumps(&words))
    }

    /// Where most of it is: middles of boxes of a few millimetres that hold some, with its volume in mm3 there.
    fn lumps(&self, words: &[u64]) -> Vec<Place> {
        let edge = (LUMP_MM / self.step).ceil().max(1.0) as usize;
        let along = self.sides.map(|side| side.div_ceil(edge));
        let mut lumps: Vec<(u32, [f64; 3])> = vec![(0, [0.0; 3]); along.iter().product()];
        let row = self.sides[0].div_ceil(64);
        for (at, &word) in words.iter().enumerate().filter(|(_, word)| **word != 0) {
            let (y, z) = (at / row % self.sides[1], at / row / self.sides[1]);
            for bit in (0..64).filter(|bit| word >> bit & 1 == 1) {
                let x = at % row * 64 + bit;
                let lump = &mut lumps[x / edge + along[0] * (y / edge + along[1] * (z / edge))];
                let middle = self.middle([x, y, z]);
                lump.0 += 1;
                (0..3).for_each(|axis| lump.1[axis] += middle[axis]);
            }
        }
        let held = lumps.into_iter().filter(|(count, _)| *count > 0);
        held.map(|(count, sum)| {
            let at = Point3::from(sum.map(|sum| sum / f64::from(count)));
            Place { at, layer: None, size: f64::from(count) * self.cube() }
        })
        .collect()
    }
}

/// Edge of the boxes in which volume that is missing or outside is gathered, in millimetres.
const LUMP_MM: f64 = 4.0;

fn ones(words: impl Iterator<Item = u64>) -> u64 {
    words.map(|word| u64::from(word.count_ones())).sum()
}
