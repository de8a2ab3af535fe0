//! Parts on their way: cells of a partition in the order in which they are printed, and what may be done to them.
//!
//! Perturbation, merging and cutting of section 2.4.3 of the dissertation, each of which keeps the constraints of [`super::tune`].

use super::error::RoboFdmError;
use super::promise::{Judge, area_vector, promising};
use super::sequence::BuildSequence;
use super::tuning::{PrintedPart, Seam, TuningOptions};
use crate::planar::solid::Wall;
use crate::planar::{CutPlane, Partition, Solid};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// Numbers that look random and are the same each time (PCG, M. E. O'Neill 2014).
struct Random(u64);

impl Random {
    /// Between -1 and 1.
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = ((self.0 >> 18) ^ self.0) >> 27;
        let turned = (mixed as u32).rotate_right((self.0 >> 59) as u32);
        f64::from(turned) / f64::from(u32::MAX) * 2.0 - 1.0
    }
}

/// Planes through a cell and what they promise to save. A cell that is cut has another number.
pub(super) type Promises = BTreeMap<u32, Vec<(f64, CutPlane)>>;

#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) cell: u32,
    pub(super) direction: Vector3<f64>,
    pub(super) base: Option<CutPlane>,
}

/// The parts in the order in which they are printed.
#[derive(Clone)]
pub(super) struct State {
    pub(super) partition: Partition,
    pub(super) nodes: Vec<Node>,
    pub(super) options: TuningOptions,
    up: Vector3<f64>,
    /// The middle of the platform.
    foot: Point3<f64>,
    diagonal: f64,
    volume: f64,
    /// The platform, where a head has to pass it.
    platform: Vec<[Point3<f64>; 3]>,
}

/// What came of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Split {
    /// What is below stands, and something was cut off.
    Made,
    /// Nothing was cut off, or something would float or be no solid.
    Unsound,
    /// The head meets what stands.
    Blocked,
}

/// Whether planes lead to about the same: normals less than 15 degrees apart, and less than two spacings between them.
pub(super) fn are_near(a: &CutPlane, b: &CutPlane, spacing: f64) -> bool {
    a.normal().dot(&b.normal()) > 0.966 && (a.offset() - b.offset()).abs() < 2.0 * spacing
}

/// Planes of the fine decomposition that are tried on the solid, the most promising first.
const TRIALS: usize = 60;

impl State {
    /// The whole solid, printed along a direction.
    pub(super) fn whole(solid: &Solid, up: Vector3<f64>, options: &TuningOptions) -> Self {
        let [low, high] = solid.bounds();
        let middle = low + (high - low) / 2.0;
        let foot = middle + up * (solid.extent(&up)[0] - middle.coords.dot(&up));
        State {
            partition: Partition::new(solid),
            nodes: vec![Node { cell: 0, direction: up, base: None }],
            up,
            foot,
            options: *options,
            diagonal: (high - low).norm(),
            volume: solid.volume(),
            platform: options.head.map_or(Vec::new(), |head| head.platform(&foot, &up)),
        }
    }

    /// Cuts the whole solid along the perturbed planes of a sequence.
    pub(super) fn follow(
        &mut self,
        sequence: &BuildSequence,
        tell: &dyn Fn(usize, usize) -> Result<(), RoboFdmError>,
    ) -> Result<(), RoboFdmError> {
        let mut random = Random(0x0b0e);
        // Which node holds each part of the sequence.
        let mut node_of: Vec<(u32, usize)> = sequence.parts.first().map(|root| (root.part, 0)).into_iter().collect();
        for (done, part) in sequence.parts.iter().enumerate().skip(1) {
            tell(done, sequence.parts.len())?;
            let holder = |p: u32| node_of.iter().find(|(known, _)| *known == p).map_or(0, |&(_, node)| node);
            let parent = part.parent.map_or(0, holder);
            let made = part.base.is_some_and(|base| self.perturbed(parent, &base, &part.direction, &mut random));
            node_of.push((part.part, if made { self.nodes.len() - 1 } else { parent }));
        }
        Ok(())
    }

    /// Whether the head, if there is one to look at, passes all that stands when a part is printed.
    pub(super) fn passes(&self, node: usize) -> bool {
        let Some(head) = self.options.head else { return true };
        let walls = self.walls(node);
        let earlier: Vec<Wall> = (0..node).flat_map(|node| self.walls(node)).collect();
        let standing = earlier.iter().map(|wall| &wall.places).chain(&self.platform);
        !head.meets(&self.nodes[node].direction, walls.iter().map(|wall| &wall.places), standing)
    }

    pub(super) fn walls(&self, node: usize) -> Vec<Wall> {
        self.partition.walls(self.nodes[node].cell)
    }

    pub(super) fn risky(&self) -> f64 {
        (0..self.nodes.len()).map(|node| self.risky_of(node)).sum()
    }

    /// Area of all seams.
    pub(super) fn seam(&self) -> f64 {
        let of = |node: usize| {
            let walls = self.walls(node);
            self.judge(node, &walls).seam(&walls)
        };
        (0..self.nodes.len()).map(of).sum()
    }

    /// Risky area of all parts, and what their seams cost.
    pub(super) fn cost(&self) -> f64 {
        let of = |node: usize| {
            let walls = self.walls(node);
            let judge = self.judge(node, &walls);
            judge.risky(&walls) + self.options.seam_cost * judge.seam(&walls)
        };
        (0..self.nodes.len()).map(of).sum()
    }

    /// Risky area of a part: of its surface while it is printed.
    pub(super) fn risky_of(&self, node: usize) -> f64 {
        let walls = self.walls(node);
        self.judge(node, &walls).risky(&walls)
    }

    pub(super) fn judge(&self, node: usize, walls: &[Wall]) -> Judge {
        let Node { direction, base, .. } = self.nodes[node];
        let lowest =
            || walls.iter().flat_map(|w| w.places).map(|p| p.coords.dot(&direction)).fold(f64::INFINITY, f64::min);
        let floor = if base.is_none() { lowest() + self.options.platform } else { f64::NEG_INFINITY };
        let earlier = self.nodes[..node].iter().map(|node| node.cell).collect();
        Judge { earlier, direction, floor, limit: -self.options.max_angle.sin() }
    }

    /// Whether a plane cuts no section between a part and another one.
    fn spares_sections(walls: &[Wall], plane: &CutPlane) -> bool {
        let mut sides: BTreeMap<u32, [bool; 2]> = BTreeMap::new();
        for wall in walls {
            let Some(beyond) = wall.beyond else { continue };
            let seen = sides.entry(beyond).or_default();
            for side in wall.places.map(|p| plane.side(&p)) {
                seen[0] |= side > 0;
                seen[1] |= side < 0;
            }
        }
        sides.values().all(|side| *side != [true; 2])
    }

    /// Separates from a node what lies above a plane at the section nearest to a point. Returns the area of the section. The new node comes last.
    fn cut_off(&mut self, node: usize, plane: &CutPlane, near: &Point3<f64>) -> Option<f64> {
        let cut = self.partition.cut(&[self.nodes[node].cell], plane);
        let mut nearest: Option<(f64, u32, u32)> = None;
        for &upper in &cut.above {
            for wall in self.partition.walls(upper) {
                let Some(lower) = wall.beyond.filter(|cell| cut.below.contains(cell)) else { continue };
                let far = wall.places.iter().map(|p| (p - near).norm()).fold(f64::INFINITY, f64::min);
                if nearest.is_none_or(|(least, ..)| far < least) {
                    nearest = Some((far, upper, lower));
                }
            }
        }
        let found = nearest.map(|(_, upper, lower)| (upper, lower));
        let (upper, lower) = found.unwrap_or_else(|| {
            let all = cut.above.iter().chain(&cut.below).copied();
            all.fold((u32::MAX, u32::MAX), |(_, first), cell| (u32::MAX, first.min(cell)))
        });
        // All other pieces go back to what they touch.
        let mut rest: Vec<u32> = cut.above.into_iter().chain(cut.below).filter(|&c| c != upper && c != lower).collect();
        while let Some(at) = rest.iter().position(|&piece| {
            [lower, upper].into_iter().any(|cell| cell != u32::MAX && self.partition.shared_area(cell, piece) > 0.0)
        }) {
            let piece = rest.remove(at);
            let to = if self.partition.shared_area(lower, piece) > 0.0 { lower } else { upper };
            self.partition.merge(to, piece);
        }
        rest.into_iter().for_each(|piece| self.partition.merge(lower, piece));
        self.nodes[node].cell = lower;
        found?;
        self.nodes.push(Node { cell: upper, direction: plane.normal(), base: Some(*plane) });
        Some(self.partition.shared_area(lower, upper))
    }

    /// Cuts a part off a node by the best plane near the given one. Whether there is one that keeps the constraints.
    fn perturbed(&mut self, node: usize, base: &Point3<f64>, normal: &Vector3<f64>, random: &mut Random) -> bool {
        let walls = self.walls(node);
        let mut largest = f64::INFINITY;
        let mut best: Option<(f64, State)> = None;
        for trial in 0..=self.options.perturbations {
            let [x, y, z, by] = [0; 4].map(|_| if trial == 0 { 0.0 } else { random.signed() });
            // An axis of any direction, a turn of any angle up to the largest.
            let axis = Vector3::new(x, y, z).try_normalize(0.0).unwrap_or_default();
            let turn = UnitQuaternion::from_scaled_axis(
                axis * (self.options.max_turn * Vector3::new(x, y, z).norm().min(1.0)),
            );
            let place = base + normal * (by * self.options.max_offset * self.diagonal);
            let Ok(plane) = CutPlane::through(&place, &(turn * normal)) else { continue };
            let looks_up = self.options.head.is_some() || plane.normal().dot(&self.up) > 0.0;
            let allowed = looks_up && Self::spares_sections(&walls, &plane);
            // The first one also says how large the section is.
            if !allowed && trial > 0 {
                continue;
            }
            let mut next = self.clone();
            let Some(section) = next.cut_off(node, &plane, &place) else { continue };
            if trial == 0 {
                largest = section * self.options.max_section;
            }
            let risky = next.risky_of(node) + next.risky_of(next.nodes.len() - 1);
            let better = best.as_ref().is_none_or(|(least, _)| risky < *least);
            if allowed && section <= largest && better && next.passes(next.nodes.len() - 1) {
                best = Some((risky, next));
            }
        }
        best.map(|(_, next)| *self = next).is_some()
    }

    /// Merges parts with earlier ones as long as nothing gets worse.
    pub(super) fn merge(&mut self) {
        loop {
            let mut best: Option<(f64, State)> = None;
            let risky = self.risky();
            for later in 1..self.nodes.len() {
                let touched = self.touched(later);
                // What lies between them in the order must not carry the later one.
                let Some(&earlier) = touched.last() else { continue };
                let mut next = self.clone();
                next.partition.merge(next.nodes[earlier].cell, next.nodes[later].cell);
                next.nodes.remove(later);
                let merged = next.risky();
                // The earlier part grows, and more of it stands when those behind it are printed.
                let enough = merged <= risky * (1.0 + 1e-12)
                    && best.as_ref().is_none_or(|(least, _)| merged < *least)
                    && next.partition.part(next.nodes[earlier].cell).is_ok()
                    && (earlier..next.nodes.len()).all(|node| next.passes(node));
                if enough {
                    best = Some((merged, next));
                }
            }
            match best {
                Some((_, next)) => *self = next,
                None => return,
            }
        }
    }

    /// The earlier parts that a part touches, by rising number.
    fn touched(&self, node: usize) -> Vec<usize> {
        let walls = self.walls(node);
        let touches = |&earlier: &usize| walls.iter().any(|wall| wall.beyond == Some(self.nodes[earlier].cell));
        (0..node).filter(touches).collect()
    }

    /// Planes through the riskiest parts by what each promises to save, the most first; none that promise less than `least`.
    pub(super) fn planes(&self, known: &mut Promises, least: f64) -> Vec<(f64, usize, CutPlane)> {
        let mut riskiest: Vec<(f64, usize)> = (0..self.nodes.len()).map(|node| (self.risky_of(node), node)).collect();
        riskiest.sort_by(|a, b| b.0.total_cmp(&a.0));
        riskiest.truncate(self.options.candidates);
        let mut planes: Vec<(f64, usize, CutPlane)> = Vec::new();
        for (_, node) in riskiest.into_iter().filter(|(risky, _)| *risky >= least) {
            let promises = known.entry(self.nodes[node].cell).or_insert_with(|| {
                let walls = self.walls(node);
                promising(&walls, &self.judge(node, &walls), self.foot, &self.up, &self.options)
            });
            planes.extend(promises.iter().filter(|(gain, _)| *gain >= least).map(|&(gain, plane)| (gain, node, plane)));
        }
        planes.sort_by(|a, b| b.0.total_cmp(&a.0));
        planes
    }

    /// Cuts one of the riskiest parts by the best plane. Whether that gained enough.
    pub(super) fn cut_finely(&mut self, known: &mut Promises, least: f64) -> bool {
        let planes = self.planes(known, least);
        let before = self.cost();
        let mut best: Option<(f64, State)> = None;
        let mut blocked: Vec<(usize, CutPlane)> = Vec::new();
        let mut trials = 0;
        for (gain, node, plane) in planes {
            // Those that follow promise less than what is there.
            if trials == TRIALS || best.as_ref().is_some_and(|(so_far, _)| *so_far >= gain) {
                break;
            }
            // Where the head is in the way it is so a little farther on.
            if blocked.iter().any(|(other, known)| *other == node && are_near(known, &plane, self.options.spacing)) {
                continue;
            }
            trials += 1;
            let mut next = self.clone();
            let made = next.split(node, &plane);
            if made == Split::Blocked {
                blocked.push((node, plane));
            }
            if made == Split::Made {
                let gain = before - next.cost();
                if gain >= least && best.as_ref().is_none_or(|(so_far, _)| gain > *so_far) {
                    best = Some((gain, next));
                }
            }
        }
        best.map(|(_, next)| *self = next).is_some()
    }

    /// Cuts a part by a plane where that pays. What is above becomes parts of their own, printed right after it along the plane's
    /// normal.
    pub(super) fn split(&mut self, node: usize, plane: &CutPlane) -> Split {
        let cell = self.nodes[node].cell;
        let judge = self.judge(node, &self.walls(node));
        let upward = Judge { direction: plane.normal(), floor: f64::NEG_INFINITY, ..judge.clone() };
        let cut = self.partition.cut(&[cell], plane);
        let stands = |piece: &u32| self.partition.walls(*piece).iter().any(|wall| judge.is_supported(wall));
        let (standing, floating): (Vec<u32>, Vec<u32>) = cut.below.iter().partition(|piece| stands(piece));
        let Some((&below, others)) = standing.split_first() else { return Split::Unsound };
        let touched_below: BTreeSet<u32> =
            cut.below.iter().flat_map(|&piece| self.partition.walls(piece)).filter_map(|wall| wall.beyond).collect();
        let touched_below: BTreeSet<u32> = touched_below.into_iter().filter(|b| !cut.above.contains(b)).collect();
        let pays = |&&piece: &&u32| {
            let mut walls = self.partition.walls(piece);
            // A section that the plane cuts has something of it on both sides.
            let barring = |b: &u32| self.options.keep_sections_apart || judge.earlier.contains(b);
            let spares = walls
                .iter()
                .filter_map(|w| w.beyond)
                .filter(barring)
                .all(|b| cut.below.contains(&b) || !touched_below.contains(&b));
            let all = walls.len();
            walls.retain(|wall| wall.beyond.is_none_or(|beyond| !cut.below.contains(&beyond)));
            let section: f64 = cut.below.iter().map(|&below| self.partition.shared_area(piece, below)).sum();
            spares
                && walls.len() < all
                && self.partition.volume(piece) >= self.options.min_piece * self.volume
                && judge.risky(&walls) > upward.risky(&walls) + self.options.seam_cost * section
        };
        let (above, kept): (Vec<u32>, Vec<u32>) = cut.above.iter().partition(pays);
        // What floats below hangs on something above: it is printed with that, if it is printed on its own.
        for piece in floating {
            let carrier = above.iter().find(|&&upper| self.partition.shared_area(upper, piece) > 0.0);
            self.partition.merge(carrier.copied().unwrap_or(below), piece);
        }
        others.iter().chain(&kept).for_each(|&piece| self.partition.merge(below, piece));
        self.nodes[node].cell = below;
        let new = above.into_iter().map(|cell| Node { cell, direction: plane.normal(), base: Some(*plane) });
        let new: Vec<Node> = new.collect();
        let count = new.len();
        let made = !new.is_empty() && self.partition.volume(below) >= self.options.min_piece * self.volume;
        let sound =
            made && self.partition.part(below).is_ok() && new.iter().all(|n| self.partition.part(n.cell).is_ok());
        self.nodes.splice(node + 1..node + 1, new);
        // What is below is printed among less than before, what comes later among as much.
        match sound {
            true if (node + 1..=node + count).all(|new| self.passes(new)) => Split::Made,
            true => Split::Blocked,
            false => Split::Unsound,
        }
    }

    pub(super) fn printed(&self) -> Result<Vec<PrintedPart>, RoboFdmError> {
        let part = |node: usize| {
            let Node { cell, direction, base } = self.nodes[node];
            let walls = self.walls(node);
            let seam_mm2 = self.judge(node, &walls).seam(&walls);
            let on = self.touched(node);
            let seam = |&on: &usize| {
                let cell = self.nodes[on].cell;
                let vectors = walls.iter().filter(|wall| wall.beyond == Some(cell)).map(|w| area_vector(&w.places));
                let (area_mm2, sum) =
                    vectors.fold((0.0, Vector3::zeros()), |(area, sum), vector| (area + vector.norm(), sum - vector));
                // What is left of vectors that cancel has no direction.
                let normal = sum.try_normalize(1e-9 * area_mm2).unwrap_or_default();
                Seam { on, area_mm2, normal }
            };
            let seams = on.iter().map(seam).collect();
            let solid = self.partition.part(cell).map_err(|source| RoboFdmError::Part { part: node, source })?;
            Ok(PrintedPart { solid, direction, base, risky_mm2: self.risky_of(node), seam_mm2, on, seams })
        };
        (0..self.nodes.len()).map(part).collect()
    }
}
