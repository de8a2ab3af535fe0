//! Parts on their way: cells of a partition in the order in which they are printed, and what may be done to them.
//!
//! Perturbation, merging and cutting of section 2.4.3 of the dissertation, each of which keeps the constraints of [`super::tune`]. What is
//! known of a part is kept, and cuts are tried on the part alone, so that a trial costs as much as the part is large.

use super::error::RoboFdmError;
use super::options::TuningOptions;
use super::parts::{PrintedPart, Seam};
use super::promise::promising;
use super::random::Random;
use super::risk::{RiskModel, area_vector};
use super::split::{Trial, divide};
use super::strength::{Body, Hold, Joined, SeamSection, holds};
use crate::planar::solid::Wall;
use crate::planar::{CutPlane, Partition, Solid};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Planes through a cell and what they promise to save. A cell that is cut has another number.
pub(super) type Promises = BTreeMap<u32, Arc<Vec<(f64, CutPlane)>>>;

/// A part on its way. What is known of it holds until a cell that it touches changes: see [`State::refresh`].
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) cell: u32,
    pub(super) direction: Vector3<f64>,
    pub(super) base: Option<CutPlane>,
    /// The triangles around it.
    pub(super) walls: Arc<Vec<Wall>>,
    /// Risky area, and area on earlier parts.
    pub(super) risky: f64,
    pub(super) seam: f64,
    /// Its mass and box.
    body: Body,
}

impl Node {
    pub(super) fn new(cell: u32, direction: Vector3<f64>, base: Option<CutPlane>) -> Self {
        Node { cell, direction, base, walls: Arc::default(), risky: 0.0, seam: 0.0, body: Body::of([].iter()) }
    }

    /// The middle of its box.
    fn middle(&self) -> Point3<f64> {
        let corners = self.walls.iter().flat_map(|wall| wall.places);
        let box_of = corners.map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.inf(&p), high.sup(&p)]);
        box_of.map_or(Point3::origin(), |[low, high]| low + (high - low) / 2.0)
    }
}

/// The parts in the order in which they are printed.
#[derive(Clone)]
pub(super) struct State {
    pub(super) partition: Arc<Partition>,
    pub(super) nodes: Vec<Node>,
    pub(super) options: TuningOptions,
    pub(super) up: Vector3<f64>,
    /// The middle of the platform, below a pedestal if there is one.
    foot: Point3<f64>,
    pub(super) diagonal: f64,
    volume: f64,
    /// The platform, where a head has to pass it.
    platform: Vec<[Point3<f64>; 3]>,
}

/// Whether planes lead to about the same: normals less than 15 degrees apart, and less than two spacings between them.
pub(super) fn are_near(a: &CutPlane, b: &CutPlane, spacing: f64) -> bool {
    a.normal().dot(&b.normal()) > 0.966 && (a.offset() - b.offset()).abs() < 2.0 * spacing
}

/// By how much a seam that is not cut may seem weaker: rounding.
const ROUNDING: f64 = 1e-9;

/// Planes of the fine decomposition that are tried on the solid, the most promising first.
const TRIALS: usize = 60;

impl State {
    /// The whole solid, printed along a direction.
    pub(super) fn whole(solid: &Solid, up: Vector3<f64>, options: &TuningOptions) -> Self {
        let [low, high] = solid.bounds();
        let middle = low + (high - low) / 2.0;
        let lowest = solid.extent(&up)[0];
        let pedestal = options.head.map_or(0.0, |head| head.pedestal);
        let foot = middle + up * (lowest - pedestal - middle.coords.dot(&up));
        // Of the pedestal itself nothing is known before the first part is. It lies below its foot, so below all planes that look up.
        let platform = options.head.map_or(Vec::new(), |head| head.platform(&foot, &up));
        let mut state = State {
            partition: Arc::new(Partition::new(solid)),
            nodes: vec![Node::new(0, up, None)],
            up,
            foot,
            options: *options,
            diagonal: (high - low).norm(),
            volume: solid.volume(),
            platform,
        };
        state.refresh(&[]);
        state
    }

    /// Finds anew what is known of parts that are new, and of those that touched a cell which is no more or has changed.
    pub(super) fn refresh(&mut self, gone: &[u32]) {
        let touched = |wall: &Wall| wall.beyond.is_some_and(|beyond| gone.contains(&beyond));
        for node in 0..self.nodes.len() {
            let Node { cell, walls, .. } = &self.nodes[node];
            if walls.is_empty() || gone.contains(cell) || walls.iter().any(touched) {
                let walls = self.partition.walls(*cell);
                let judge = self.judge(node, &walls);
                let (risky, seam) = (judge.risky(&walls), judge.seam(&walls));
                let body = Body::of(walls.iter().map(|wall| &wall.places));
                self.nodes[node] = Node { walls: Arc::new(walls), risky, seam, body, ..self.nodes[node].clone() };
            }
        }
    }

    /// Whether the head, if there is one to look at, passes all that stands, and the platform, when a part is printed.
    pub(super) fn head_passes<'a>(
        &self,
        direction: &Vector3<f64>,
        part: &[Wall],
        standing: impl Iterator<Item = &'a [Wall]>,
    ) -> bool {
        let Some(head) = self.options.head else { return true };
        let standing = standing.flatten().map(|wall| &wall.places).chain(&self.platform);
        !head.meets(direction, part.iter().map(|wall| &wall.places), standing)
    }

    /// The same for what stands alone, without the platform.
    pub(super) fn head_passes_of(&self, direction: &Vector3<f64>, part: &[Wall], standing: &[Wall]) -> bool {
        let Some(head) = self.options.head else { return true };
        !head.meets(direction, part.iter().map(|wall| &wall.places), standing.iter().map(|wall| &wall.places))
    }

    pub(super) fn risky(&self) -> f64 {
        self.nodes.iter().map(|node| node.risky).sum()
    }

    /// Area of all seams.
    pub(super) fn seam(&self) -> f64 {
        self.nodes.iter().map(|node| node.seam).sum()
    }

    pub(super) fn judge(&self, node: usize, walls: &[Wall]) -> RiskModel {
        let Node { direction, base, .. } = self.nodes[node];
        let lowest =
            || walls.iter().flat_map(|w| w.places).map(|p| p.coords.dot(&direction)).fold(f64::INFINITY, f64::min);
        let floor = if base.is_none() { lowest() + self.options.platform } else { f64::NEG_INFINITY };
        let earlier = self.nodes[..node].iter().map(|node| node.cell).collect();
        RiskModel { earlier, direction, floor, limit: -self.options.max_angle.sin() }
    }

    /// The earlier parts that a part touches, by rising number.
    pub(super) fn touched(&self, node: usize) -> Vec<usize> {
        let walls = &self.nodes[node].walls;
        let touches = |&earlier: &usize| walls.iter().any(|wall| wall.beyond == Some(self.nodes[earlier].cell));
        (0..node).filter(touches).collect()
    }

    /// The riskiest parts, in which planes are sought.
    pub(super) fn riskiest(&self, least: f64) -> Vec<usize> {
        let mut riskiest: Vec<(f64, usize)> = self.nodes.iter().map(|node| node.risky).zip(0..).collect();
        riskiest.sort_by(|a, b| b.0.total_cmp(&a.0));
        riskiest.truncate(self.options.candidates);
        riskiest.into_iter().filter(|(risky, _)| *risky >= least).map(|(_, node)| node).collect()
    }

    /// Planes through a part and what they promise to save, the most first; none that promise less than `least`.
    pub(super) fn rated(&self, node: usize, least: f64) -> Vec<(f64, CutPlane)> {
        let walls = &self.nodes[node].walls;
        promising(walls, &self.judge(node, walls), self.foot, &self.up, &self.options, least)
    }

    /// Planes through the riskiest parts by what each promises to save, the most first; none that promise less than `least`.
    pub(super) fn planes(&self, known: &mut Promises, least: f64) -> Vec<(f64, usize, CutPlane)> {
        let mut planes: Vec<(f64, usize, CutPlane)> = Vec::new();
        for node in self.riskiest(least) {
            let promises = known.entry(self.nodes[node].cell).or_insert_with(|| Arc::new(self.rated(node, least)));
            planes.extend(promises.iter().map(|&(gain, plane)| (gain, node, plane)));
        }
        planes.sort_by(|a, b| b.0.total_cmp(&a.0));
        planes
    }

    /// Cuts one of the riskiest parts by the best plane, or by the best one near it (`refines`). Whether that gained enough.
    pub(super) fn cut_finely(&mut self, known: &mut Promises, least: f64, refines: bool) -> bool {
        let planes = self.planes(known, least);
        let mut best: Option<(f64, usize, CutPlane)> = None;
        let mut blocked: Vec<(usize, CutPlane)> = Vec::new();
        let mut trials = 0;
        for (promise, node, plane) in planes {
            // Those that follow promise less than what is there.
            if trials == TRIALS || best.is_some_and(|(so_far, ..)| so_far >= promise) {
                break;
            }
            // Where the head is in the way it is so a little farther on.
            if blocked.iter().any(|(other, known)| *other == node && are_near(known, &plane, self.options.spacing)) {
                continue;
            }
            trials += 1;
            let Some(trial) = self.tried(node, &plane) else { continue };
            let saved = self.saved(node, &trial);
            if saved < least || best.is_some_and(|(so_far, ..)| saved <= so_far) {
                continue;
            }
            if !self.trial_passes(node, &trial) {
                blocked.push((node, plane));
            } else if trial.is_sound() && self.holds_when_cut(node, &plane) {
                best = Some((saved, node, plane));
            }
        }
        let Some((saved, node, plane)) = best else { return false };
        let plane = if refines { self.refined(node, plane, saved) } else { plane };
        self.split(node, &plane);
        true
    }

    /// The best plane near one that saves so much: what rates planes knows only normals and offsets of a grid.
    fn refined(&self, node: usize, mut plane: CutPlane, mut saved: f64) -> CutPlane {
        let mut random = Random::new();
        let TuningOptions { perturbations, max_turn, spacing, .. } = self.options;
        for _ in 0..perturbations {
            let normal = random.turn(max_turn) * plane.normal();
            if self.options.head.is_none() && normal.dot(&self.up) <= 0.0 {
                continue;
            }
            // About the middle of the part, so that a turn moves the section little.
            let middle = self.nodes[node].middle();
            let place = middle - plane.normal() * (plane.height(&middle) + spacing / 2.0 * random.signed());
            let Ok(near) = CutPlane::through(&place, &normal) else { continue };
            let Some(trial) = self.tried(node, &near) else { continue };
            let so_far = self.saved(node, &trial);
            if so_far > saved && self.trial_passes(node, &trial) && trial.is_sound() && self.holds_when_cut(node, &near)
            {
                (plane, saved) = (near, so_far);
            }
        }
        plane
    }

    /// A cut of a part by a plane, on the part alone. `None` where it cuts nothing off that pays, something would float, or there would be
    /// more parts than are allowed.
    pub(super) fn tried(&self, node: usize, plane: &CutPlane) -> Option<Trial> {
        let Node { cell, walls, .. } = &self.nodes[node];
        let judge = self.judge(node, walls);
        let trial = Trial::new(self.partition.only(&[*cell]), *cell, plane, &judge, self.min_mm3(), &self.options)?;
        (self.nodes.len() + trial.division.above.len() <= self.options.max_parts).then_some(trial)
    }

    /// What a trial saves: risky area, but for what its seams cost.
    fn saved(&self, node: usize, trial: &Trial) -> f64 {
        let Node { risky, seam, .. } = self.nodes[node];
        risky - trial.risky() + self.options.seam_cost * (seam - trial.seam())
    }

    /// Whether the head passes all that stands when what a trial cuts off is printed.
    ///
    /// What is below is printed among less than before, what comes later among as much.
    pub(super) fn trial_passes(&self, node: usize, trial: &Trial) -> bool {
        (1..trial.parts.len()).all(|at| {
            let earlier = self.nodes[..node].iter().map(|node| &node.walls[..]);
            let new = trial.parts[..at].iter().map(|part| &part.walls[..]);
            let part = &trial.parts[at];
            self.head_passes(&part.direction, &part.walls, earlier.chain(new))
        })
    }

    /// How each part is held by what is below it; nothing without [`TuningOptions::strength`].
    pub(super) fn holds(&self) -> Vec<Hold> {
        let Some(strength) = self.options.strength else { return Vec::new() };
        let joined = |node: usize| {
            let Node { body, base, ref walls, .. } = self.nodes[node];
            let on = self.touched(node);
            let judge = self.judge(node, walls);
            let is_seam = |wall: &&Wall| match wall.beyond {
                Some(beyond) => judge.earlier.contains(&beyond),
                // What looks up in the first layer does not lie on the platform.
                None => {
                    base.is_none() && judge.is_supported(wall) && area_vector(&wall.places).dot(&judge.direction) < 0.0
                }
            };
            let seam: Vec<_> = walls.iter().filter(is_seam).map(|wall| wall.places).collect();
            Joined { body, section: SeamSection::of(&seam), on_platform: base.is_none() && on.is_empty(), on }
        };
        let joined: Vec<Joined> = (0..self.nodes.len()).map(joined).collect();
        let pedestal = self.options.head.map_or(0.0, |head| head.pedestal);
        holds(&joined, &strength, &(self.up * pedestal))
    }

    /// The greatest stress as a share of what it may be, of seams with the platform and of others; 0 without [`TuningOptions::strength`].
    fn strain(&self) -> [f64; 2] {
        let holds = self.holds();
        [true, false].map(|on_platform| {
            let of = holds.iter().filter(|hold| hold.on_platform == on_platform);
            of.map(Hold::share).fold(0.0, f64::max)
        })
    }

    /// Whether all seams hold, or where they do not are no weaker than in another state.
    pub(super) fn holds_like(&self, before: &State) -> bool {
        let [now, then] = [self, before].map(State::strain);
        now.iter().zip(then).all(|(now, then)| *now <= then.max(1.0) * (1.0 + ROUNDING))
    }

    /// Whether the parts still hold when one is cut by a plane as it was tried, or no worse than without if they do not.
    pub(super) fn holds_when_cut(&self, node: usize, plane: &CutPlane) -> bool {
        if self.options.strength.is_none() {
            return true;
        }
        let mut next = self.clone();
        next.split(node, plane);
        next.holds_like(self)
    }

    fn min_mm3(&self) -> f64 {
        self.options.min_piece * self.volume
    }

    /// Cuts a part by a plane as it was tried. What is above becomes parts of their own, printed right after it along the plane's normal.
    pub(super) fn split(&mut self, node: usize, plane: &CutPlane) {
        let (cell, min_mm3) = (self.nodes[node].cell, self.min_mm3());
        let judge = self.judge(node, &self.nodes[node].walls);
        let made = divide(Arc::make_mut(&mut self.partition), cell, plane, &judge, min_mm3, &self.options);
        let Some(division) = made else { unreachable!("the same cut was made on the part alone") };
        self.nodes[node].cell = division.below;
        let new = division.above.into_iter().map(|cell| Node::new(cell, plane.normal(), Some(*plane)));
        self.nodes.splice(node + 1..node + 1, new);
        // Its own walls are new as well.
        self.nodes[node].walls = Arc::default();
        self.refresh(&[cell]);
    }

    pub(super) fn printed(&self) -> Result<Vec<PrintedPart>, RoboFdmError> {
        let part = |node: usize| {
            let Node { cell, direction, base, ref walls, risky: risky_mm2, seam: seam_mm2, .. } = self.nodes[node];
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
            Ok(PrintedPart { solid, direction, base, risky_mm2, seam_mm2, on, seams })
        };
        (0..self.nodes.len()).map(part).collect()
    }
}
