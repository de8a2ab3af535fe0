//! Beads that are laid: capsules in a grid of columns.
//!
//! A bead is a round line below the way of the tip, as thick as the bead is high. Short steps in line are one capsule, so that there are as many of them as
//! the part has bead heights, whatever the number of moves.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A capsule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Its ends.
    pub ends: [Point3<f64>; 2],
    /// Its radius.
    pub radius: f64,
}

/// How far a place is from the straight way between two others.
pub fn to_chord(place: &Point3<f64>, from: &Point3<f64>, to: &Point3<f64>) -> f64 {
    let way = to - from;
    let squared = way.norm_squared();
    let share = if squared > 0.0 { ((place - from).dot(&way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from + way * share - place).norm()
}

/// Edge of a column and of its floors, in millimetres: a nozzle is some ten of them wide. Larger ones hold beads that are far below it, smaller ones take longer
/// to look through.
const EDGE_MM: f64 = 2.0;

/// Capsules by place.
#[derive(Clone, Debug, Default)]
pub struct Beads {
    all: Vec<Capsule>,
    max_radius: f64,
    /// Longest way between two marked places of an axis.
    max_gap: f64,
    columns: HashMap<u64, Column, BuildHasherDefault<OfColumn>>,
    /// In which look each capsule was found last, and the number of this look.
    seen: Vec<u32>,
    look: u32,
}

/// Scatters columns by the golden ratio (D. Knuth, *The Art of Computer Programming* 3, 2nd ed. 1998, 6.4): a look asks for some hundred of them.
#[derive(Clone, Copy, Debug, Default)]
struct OfColumn(u64);

impl Hasher for OfColumn {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, key: u64) {
        let scattered = (self.0 ^ key).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = scattered ^ (scattered >> 32);
    }
}

/// Numbers of capsules by floor.
#[derive(Clone, Debug, Default)]
struct Column {
    first: i32,
    floors: Vec<Vec<u32>>,
}

fn cell(x: f64) -> i32 {
    (x / EDGE_MM).floor() as i32
}

fn column(x: i32, y: i32) -> u64 {
    u64::from(x.cast_unsigned()) << 32 | u64::from(y.cast_unsigned())
}

impl Beads {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The largest radius.
    pub fn max_radius(&self) -> f64 {
        self.max_radius
    }

    /// The capsule of a number.
    pub fn at(&self, number: usize) -> &Capsule {
        &self.all[number]
    }

    /// Adds a capsule; it belongs to the cells of its ends and of places between them, no farther apart than a cell.
    pub fn push(&mut self, capsule: Capsule) {
        let number = self.all.len() as u32;
        let [from, to] = capsule.ends;
        let parts = ((to - from).norm() / EDGE_MM).ceil().clamp(1.0, 1e4) as u32;
        self.max_gap = self.max_gap.max((to - from).norm() / f64::from(parts));
        let mut last = None;
        for part in 0..=parts {
            let place = from + (to - from) * (f64::from(part) / f64::from(parts));
            let key = (column(cell(place.x), cell(place.y)), cell(place.z));
            if last != Some(key) {
                self.columns.entry(key.0).or_default().push(key.1, number);
            }
            last = Some(key);
        }
        self.max_radius = self.max_radius.max(capsule.radius);
        self.all.push(capsule);
        self.seen.push(0);
    }

    /// Numbers of capsules near a box, each once. Those whose axis is within it are among them.
    pub fn within(&mut self, [low, high]: &[Point3<f64>; 2], found: &mut Vec<u32>) {
        // An axis may cross the box between two of its marked places: one of them is nearer than half of the way.
        let gap = Vector3::repeat(0.5 * self.max_gap);
        let [low, high] = [low - gap, high + gap];
        let floors = cell(low.z)..=cell(high.z);
        self.look = self.look.wrapping_add(1);
        for x in cell(low.x)..=cell(high.x) {
            for y in cell(low.y)..=cell(high.y) {
                let Some(column) = self.columns.get(&column(x, y)) else { continue };
                for (floor, numbers) in (column.first..).zip(&column.floors) {
                    if !floors.contains(&floor) {
                        continue;
                    }
                    for &number in numbers {
                        let seen = &mut self.seen[number as usize];
                        if std::mem::replace(seen, self.look) != self.look {
                            found.push(number);
                        }
                    }
                }
            }
        }
    }
}

impl Column {
    fn push(&mut self, floor: i32, number: u32) {
        if self.floors.is_empty() {
            self.first = floor;
        }
        while floor < self.first {
            self.floors.insert(0, Vec::new());
            self.first -= 1;
        }
        let at = (floor - self.first) as usize;
        if at >= self.floors.len() {
            self.floors.resize(at + 1, Vec::new());
        }
        self.floors[at].push(number);
    }
}

/// Makes capsules of the way of the tip.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    open: Option<Open>,
}

/// The capsule under way.
#[derive(Clone, Copy, Debug)]
struct Open {
    from: Point3<f64>,
    to: Point3<f64>,
    radius: f64,
    /// No place of its way is farther from its axis than this.
    bent: f64,
}

/// Steps in line with the capsule to within this share of its radius belong to it.
const BENT: f64 = 0.1;
/// A capsule is at most this long, in millimetres: the fewer there are, the faster are looks among them, and with much longer ones their middles say little.
const LONG_MM: f64 = 2.0;

impl Layer {
    /// The middle of the bead goes on to a place; a capsule that ends there is returned.
    pub fn go(&mut self, middle: Point3<f64>, radius: f64) -> Option<Capsule> {
        let Some(open) = self.open else {
            self.open = Some(Open { from: middle, to: middle, radius, bent: 0.0 });
            return None;
        };
        let (way, before) = (middle - open.from, open.to - open.from);
        let length = way.norm();
        let beside = if length > 0.0 { before.cross(&way).norm() / length } else { 0.0 };
        let is_back = before.dot(&(middle - open.to)) < 0.0;
        // Places before move away from the new axis by no more than the last end does.
        let bent = open.bent + beside;
        let is_alike = (radius - open.radius).abs() < 0.1 * open.radius;
        if length <= LONG_MM && bent <= BENT * open.radius && !is_back && is_alike {
            self.open = Some(Open { to: middle, bent, ..open });
            return None;
        }
        self.open = Some(Open { from: open.to, to: middle, radius, bent: 0.0 });
        Some(Capsule { ends: [open.from, open.to], radius: open.radius })
    }

    /// The bead ends.
    pub fn end(&mut self) -> Option<Capsule> {
        self.open.take().map(|Open { from, to, radius, .. }| Capsule { ends: [from, to], radius })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(128) })]

        /// The twin looks at all capsules.
        #[test]
        fn all_axes_in_a_box_are_found(
            ends in prop::collection::vec(prop::array::uniform6(-40f64..40.0), 1..30), low in prop::array::uniform3(-40f64..40.0), size in prop::array::uniform3(0.1f64..30.0)
        ) {
            let mut beads = Beads::default();
            for e in &ends {
                beads.push(Capsule { ends: [Point3::new(e[0], e[1], e[2]), Point3::new(e[3], e[4], e[5])], radius: 0.5 });
            }
            let low = Point3::from(low);
            let high = low + Vector3::from(size);
            let mut found = Vec::new();
            beads.within(&[low, high], &mut found);
            for (number, e) in (0u32..).zip(&ends) {
                let (from, to) = (Point3::new(e[0], e[1], e[2]), Point3::new(e[3], e[4], e[5]));
                let is_inside = (0..=400).any(|k| {
                    let at = from + (to - from) * (f64::from(k) / 400.0);
                    (0..3).all(|axis| at[axis] >= low[axis] && at[axis] <= high[axis])
                });
                prop_assert!(!is_inside || found.contains(&number), "{number}");
            }
        }

        /// No place of the way is farther from the capsules than a step may be bent.
        #[test]
        fn capsules_cover_the_way(turns in prop::collection::vec(-0.6f64..0.6, 2..200)) {
            let (mut layer, mut capsules) = (Layer::default(), Vec::new());
            let (mut at, mut heading) = (Point3::origin(), 0.0f64);
            let mut way = vec![at];
            for turn in &turns {
                heading += turn;
                at += Vector3::new(heading.cos(), heading.sin(), 0.0) * 0.1;
                way.push(at);
            }
            way.iter().for_each(|place| capsules.extend(layer.go(*place, 0.5)));
            capsules.extend(layer.end());
            for place in &way {
                let off = capsules.iter().map(|c| to_chord(place, &c.ends[0], &c.ends[1])).fold(f64::INFINITY, f64::min);
                prop_assert!(off <= 0.05 + 1e-12, "{off}");
            }
            prop_assert!(capsules.len() <= turns.len() + 1);
        }
    }
}
