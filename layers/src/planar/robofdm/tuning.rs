//! Phase III: a solid is cut along the planes of a sequence, and its parts are tuned until little of them is risky.
//!
//! Dissertation, section 2.4.3. Each plane is tried at random places near its own (*plane perturbation*); parts whose union is no worse are
//! one (*region merging*); the riskiest parts are cut again, by the best of many planes (*fine decomposition*, Eq. 2.2).
//! Constraint I: no two base sections intersect. Constraint II: all base planes look up. Planes that break one are not used.
//!
//! Departures. A plane cuts only the section that it was made for, and not what it meets elsewhere. A section towards a later part is a
//! surface while its own part is printed, so it is risky if it looks down. A cut is tried on the solid before it is taken, so that pieces
//! that would float are seen.

use super::error::RoboFdmError;
use super::promise::{Judge, promising};
use super::sequence::BuildSequence;
use crate::Progress;
use crate::planar::solid::Wall;
use crate::planar::{CutPlane, Partition, Solid};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

/// How parts are tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuningOptions {
    /// As in [`super::SequenceOptions::max_angle`].
    pub max_angle: f64,
    /// As in [`super::SequenceOptions::platform`], in mm.
    pub platform: f64,
    /// Places that are tried for each plane. Default 16.
    pub perturbations: u32,
    /// How far a plane is moved at most, as a share of the box diagonal. Default 0.025, the paper's.
    pub max_offset: f64,
    /// How far it is turned at most, in radians. Default 5 degrees, the paper's.
    pub max_turn: f64,
    /// A section may become so many times as large. Default 1.2, the paper's.
    pub max_section: f64,
    /// Of how many parts, the riskiest first, a cut is sought each time. Default 6, the paper's.
    pub candidates: usize,
    /// Normals that are tried, over the upper half of the sphere. Default 100, the paper's.
    pub normals: usize,
    /// Distance of the planes that are tried, in mm. Default 5, the paper's.
    pub spacing: f64,
    /// How often that distance is halved, and with it the cost of seams, when no plane is worth a cut any more. Default 3; the paper has 0.
    pub halvings: u32,
    /// Whether no two base sections may intersect: constraint I to the letter. Default `false`: the section of a cut may end on the
    /// base plane of a part that is printed later. All that stands when that part is printed lies below its plane, so nothing is in
    /// the way (the collision of the paper's Fig. 2.6 needs a part that is printed earlier).
    pub keep_sections_apart: bool,
    /// A cut must save so much risky area for each area of its seam. Default 0: Eq. 2.2 as it stands.
    pub seam_cost: f64,
    /// Most parts. Default 40.
    pub max_parts: usize,
    /// Share of the risky area of the whole solid, printed along the root's direction, at which the work is done. Default 0.01.
    pub goal: f64,
}

impl Default for TuningOptions {
    fn default() -> Self {
        Self {
            max_angle: std::f64::consts::FRAC_PI_4,
            platform: 0.2,
            perturbations: 16,
            max_offset: 0.025,
            max_turn: 5f64.to_radians(),
            max_section: 1.2,
            candidates: 6,
            normals: 100,
            spacing: 5.0,
            halvings: 3,
            keep_sections_apart: false,
            seam_cost: 0.0,
            max_parts: 40,
            goal: 0.01,
        }
    }
}

/// A part as it is printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedPart {
    /// Its closed mesh.
    pub solid: Solid,
    /// The direction in which it is printed, of length 1.
    pub direction: Vector3<f64>,
    /// The plane on which it is printed; none for one that stands on the platform.
    pub base: Option<CutPlane>,
    /// Area of its surface that is risky, in mm2.
    pub risky_mm2: f64,
    /// Area that it shares with earlier parts, in mm2.
    pub seam_mm2: f64,
    /// The earlier parts that it touches, by rising number.
    pub on: Vec<usize>,
}

/// A solid in parts, in the order in which they are printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// The parts.
    pub parts: Vec<PrintedPart>,
    /// Risky area of the whole solid, printed in the direction of the first part, in mm2.
    pub risky_before_mm2: f64,
    /// Risky area after the planes of the sequence were perturbed, after parts were merged, and after the fine
    /// decomposition, in mm2.
    pub risky_after_phases_mm2: [f64; 3],
}

impl Decomposition {
    /// Risky area of all parts, in mm2.
    pub fn risky_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.risky_mm2).sum()
    }

    /// Area of all seams, in mm2.
    pub fn seam_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.seam_mm2).sum()
    }
}

/// A cut is not worth its seam unless it saves this share of the first risky area.
const LEAST_GAIN: f64 = 5e-4;

/// Planes of the fine decomposition that are tried on the solid, the most promising first.
const TRIALS: usize = 60;

/// Pieces smaller than this share of the solid stay with the rest.
const LEAST_PIECE: f64 = 1e-4;

/// Cuts a solid along a sequence of planes and tunes the parts.
///
/// # Returns
/// The parts; the first one stands on the platform. Risky area may be left: see [`Decomposition::risky_mm2`].
///
/// # Errors
/// [`RoboFdmError::Option`] for an option out of range, [`RoboFdmError::Part`] for a part that does not bound a solid,
/// [`RoboFdmError::Cancelled`] if `progress` says so.
///
/// # Cost
/// A cut of the mesh for each perturbation and each trial, and for each fine cut `normals` operations for each triangle of the riskiest parts.
/// One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::Solid;
/// use curvlay_layers::planar::robofdm::{SegmentOptions, SequenceOptions, TuningOptions, plan_sequence, segment, tune};
/// use std::ops::ControlFlow;
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let segmentation = segment(&points, &faces, &SegmentOptions::default())?;
/// let sequence = plan_sequence(&points, &faces, &segmentation, &SequenceOptions::default())?;
/// let solid = Solid::new(&points, &faces)?;
/// let parts = tune(&solid, &sequence, &TuningOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((parts.parts.len(), parts.risky_mm2()), (1, 0.0)); // a rod needs no support
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tune(
    solid: &Solid,
    sequence: &BuildSequence,
    options: &TuningOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Decomposition, RoboFdmError> {
    options.check()?;
    let Some(root) = sequence.parts.first() else { return Err(RoboFdmError::Empty) };
    let [low, high] = solid.bounds();
    let mut state = State {
        partition: Partition::new(solid),
        nodes: vec![Node { cell: 0, direction: root.direction, base: None }],
        up: root.direction,
        options: *options,
        diagonal: (high - low).norm(),
        volume: solid.volume(),
    };
    let before = state.risky();
    let tell =
        |stage, done: usize, total: usize| match progress(Progress { stage, done: done as u64, total: total as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(RoboFdmError::Cancelled),
        };
    let mut random = Random(0x0b0e);
    // Which node holds each part of the sequence.
    let mut node_of: Vec<(u32, usize)> = vec![(root.part, 0)];
    for (done, part) in sequence.parts.iter().enumerate().skip(1) {
        tell("planes", done, sequence.parts.len())?;
        let holder = |p: u32| node_of.iter().find(|(known, _)| *known == p).map_or(0, |&(_, node)| node);
        let parent = part.parent.map_or(0, holder);
        let made = part.base.is_some_and(|base| state.perturbed(parent, &base, &part.direction, &mut random));
        node_of.push((part.part, if made { state.nodes.len() - 1 } else { parent }));
    }
    let mut after = [state.risky(); 3];
    tell("merging", 0, 1)?;
    state.merge();
    after[1] = state.risky();
    let (mut risky, mut known, mut halvings) = (after[1], Promises::new(), 0);
    while risky > options.goal * before && state.nodes.len() < options.max_parts {
        tell("cuts", state.nodes.len(), options.max_parts)?;
        if state.cut_finely(&mut known, LEAST_GAIN * before) {
            risky = state.risky();
        } else if halvings < options.halvings {
            // What is left takes finer planes, and a seam that pays less.
            halvings += 1;
            state.options.spacing /= 2.0;
            state.options.seam_cost /= 2.0;
            known.clear();
        } else {
            break;
        }
    }
    state.merge();
    after[2] = state.risky();
    Ok(Decomposition { parts: state.printed()?, risky_before_mm2: before, risky_after_phases_mm2: after })
}

impl TuningOptions {
    fn check(&self) -> Result<(), RoboFdmError> {
        let named = [
            ("max_angle", self.max_angle, 1e-6, std::f64::consts::FRAC_PI_2 - 1e-6),
            ("platform", self.platform, 0.0, 1e9),
            ("max_offset", self.max_offset, 0.0, 1.0),
            ("max_turn", self.max_turn, 0.0, std::f64::consts::FRAC_PI_2),
            ("max_section", self.max_section, 1.0, 1e9),
            ("candidates", self.candidates as f64, 1.0, 1e6),
            ("normals", self.normals as f64, 1.0, 1e6),
            ("spacing", self.spacing, 1e-3, 1e9),
            ("seam_cost", self.seam_cost, 0.0, 1e9),
            ("max_parts", self.max_parts as f64, 1.0, 1e6),
            ("goal", self.goal, 0.0, 1.0),
        ];
        match named.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value)) {
            Some((name, value, ..)) => Err(RoboFdmError::Option { name, value }),
            None => Ok(()),
        }
    }
}

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
type Promises = BTreeMap<u32, Vec<(f64, CutPlane)>>;

#[derive(Clone, Debug)]
struct Node {
    cell: u32,
    direction: Vector3<f64>,
    base: Option<CutPlane>,
}

/// The parts in the order in which they are printed.
#[derive(Clone)]
struct State {
    partition: Partition,
    nodes: Vec<Node>,
    up: Vector3<f64>,
    options: TuningOptions,
    diagonal: f64,
    volume: f64,
}

impl State {
    fn walls(&self, node: usize) -> Vec<Wall> {
        self.partition.walls(self.nodes[node].cell)
    }

    fn risky(&self) -> f64 {
        (0..self.nodes.len()).map(|node| self.risky_of(node)).sum()
    }

    /// Risky area of all parts, and what their seams cost.
    fn cost(&self) -> f64 {
        let of = |node: usize| {
            let walls = self.walls(node);
            let judge = self.judge(node, &walls);
            judge.risky(&walls) + self.options.seam_cost * judge.seam(&walls)
        };
        (0..self.nodes.len()).map(of).sum()
    }

    /// Risky area of a part: of its surface while it is printed.
    fn risky_of(&self, node: usize) -> f64 {
        let walls = self.walls(node);
        self.judge(node, &walls).risky(&walls)
    }

    fn judge(&self, node: usize, walls: &[Wall]) -> Judge {
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
            let allowed = plane.normal().dot(&self.up) > 0.0 && Self::spares_sections(&walls, &plane);
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
            if allowed && section <= largest && best.as_ref().is_none_or(|(least, _)| risky < *least) {
                best = Some((risky, next));
            }
        }
        best.map(|(_, next)| *self = next).is_some()
    }

    /// Merges parts with earlier ones as long as nothing gets worse.
    fn merge(&mut self) {
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
                let enough = merged <= risky * (1.0 + 1e-12) && next.partition.part(next.nodes[earlier].cell).is_ok();
                if enough && best.as_ref().is_none_or(|(least, _)| merged < *least) {
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

    /// Cuts one of the riskiest parts by the best plane. Whether that gained enough.
    fn cut_finely(&mut self, known: &mut Promises, least: f64) -> bool {
        let mut riskiest: Vec<(f64, usize)> = (0..self.nodes.len()).map(|node| (self.risky_of(node), node)).collect();
        riskiest.sort_by(|a, b| b.0.total_cmp(&a.0));
        riskiest.truncate(self.options.candidates);
        let mut planes: Vec<(f64, usize, CutPlane)> = Vec::new();
        for (_, node) in riskiest.into_iter().filter(|(risky, _)| *risky >= least) {
            let promises = known.entry(self.nodes[node].cell).or_insert_with(|| {
                let walls = self.walls(node);
                promising(&walls, &self.judge(node, &walls), &self.up, &self.options)
            });
            planes.extend(promises.iter().filter(|(gain, _)| *gain >= least).map(|&(gain, plane)| (gain, node, plane)));
        }
        planes.sort_by(|a, b| b.0.total_cmp(&a.0));
        let before = self.cost();
        let mut best: Option<(f64, State)> = None;
        for (gain, node, plane) in planes.into_iter().take(TRIALS) {
            // Those that follow promise less than what is there.
            if best.as_ref().is_some_and(|(so_far, _)| *so_far >= gain) {
                break;
            }
            let mut next = self.clone();
            if next.split(node, &plane) {
                let gain = before - next.cost();
                if gain >= least && best.as_ref().is_none_or(|(so_far, _)| gain > *so_far) {
                    best = Some((gain, next));
                }
            }
        }
        best.map(|(_, next)| *self = next).is_some()
    }

    /// Cuts a part by a plane where that pays. What is above becomes parts of their own, printed right after it along the plane's
    /// normal. Whether what is below stands, and something was cut off.
    fn split(&mut self, node: usize, plane: &CutPlane) -> bool {
        let cell = self.nodes[node].cell;
        let judge = self.judge(node, &self.walls(node));
        let upward = Judge { direction: plane.normal(), floor: f64::NEG_INFINITY, ..judge.clone() };
        let cut = self.partition.cut(&[cell], plane);
        let stands = |piece: &u32| self.partition.walls(*piece).iter().any(|wall| judge.is_supported(wall));
        let (standing, floating): (Vec<u32>, Vec<u32>) = cut.below.iter().partition(|piece| stands(piece));
        let Some((&below, others)) = standing.split_first() else { return false };
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
                && self.partition.volume(piece) >= LEAST_PIECE * self.volume
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
        let made = !new.is_empty() && self.partition.volume(below) >= LEAST_PIECE * self.volume;
        let sound =
            made && self.partition.part(below).is_ok() && new.iter().all(|n| self.partition.part(n.cell).is_ok());
        self.nodes.splice(node + 1..node + 1, new);
        sound
    }

    fn printed(&self) -> Result<Vec<PrintedPart>, RoboFdmError> {
        let part = |node: usize| {
            let Node { cell, direction, base } = self.nodes[node];
            let walls = self.walls(node);
            let seam_mm2 = self.judge(node, &walls).seam(&walls);
            let on = self.touched(node);
            let solid = self.partition.part(cell).map_err(|source| RoboFdmError::Part { part: node, source })?;
            Ok(PrintedPart { solid, direction, base, risky_mm2: self.risky_of(node), seam_mm2, on })
        };
        (0..self.nodes.len()).map(part).collect()
    }
}
