//! Freed directions along a path, smooth.
//!
//! 1. Each waypoint that gouges gets its least tilt; where the limit leaves none, the least one from a direction that is known there. What decides whether a path is printed from its start or its end is known after this
//!    step; all others are done once. The tip of a waypoint that no tilt frees is raised along the direction wanted, as little as frees it; it turns
//!    no more. Where the limit leaves no such height, it gets the direction that is least deep.
//! 2. Where neighbours then differ by more than the limit (degrees a millimetre of the way, and degrees in all), one is turned toward the
//!    other, on along the path until the difference is used up: forward, then backward. So a tilt is ramped up before the place that needs
//!    it, and down behind.
//! 3. Where a step is so long that the way allows more than the limit of a turn, points are put between, each freed on its own, and step 2
//!    is repeated around them.
//! 4. Around tilted waypoints directions become the means of their neighbours, round by round.
//! 5. Waypoints that were only put between and that no tilt frees are taken out again.
//! 6. Between neighbours that are free the nozzle may still gouge; it is looked at every eighth of the way, and where it does a
//!    point is put between and freed, so that the straight way of a machine goes round. That is repeated with the parts.
//! 7. Where the nozzle would still turn by more on one millimetre than the limit allows, the two neighbours that turn most are turned to
//!    the nearest pair of directions that are free, one at each of them (alternating projections), if the path then has fewer such places.
//! 8. At those that are left the path is cut: the nozzle leaves the part, turns, and comes back. The first piece ends where the second
//!    begins, or as near to that as both are free. If more than the width of the bead would be missing in between and the way is free, it turns
//!    there all the same, and slowly, which is listed.
//!
//! A direction is only ever replaced by one that is free at its waypoint, whatever the step: so all that were freed stay free.

mod legs;
mod ramps;
mod single;
mod turned;
mod turns;

use super::built::{after, before};
use super::deepest::{Contact, Scene, Stand};
use super::gouge::Gouge;
use super::options::GougingOptions;
use super::tilt::Points;
use crate::layer::DirectionHints;
use crate::orientation::{TURN_ROUNDING, ToolPath, Waypoint, angle};
use nalgebra::{UnitVector3, Vector3};
use turned::Turned;

/// How often points are put between: each time as many as an even turn needs, so more than once only where the new ones
/// have to be tilted as well. Where that does not do either, the turn is listed.
const INSERTIONS: usize = 3;

/// How often legs are looked at in step 6.
const DIVISIONS: usize = 3;

/// A path whose waypoints are tilted one by one: step 1.
pub(super) struct Tilted<'a>(Walker<'a>);

/// A path after collision removal.
#[derive(Clone, Debug, Default)]
pub(super) struct ResolvedPath {
    pub waypoints: Vec<Waypoint>,
    pub gouging_before: usize,
    /// Waypoints put between that stay, and waypoints given that were taken out.
    pub added: usize,
    pub taken_out: usize,
    /// How far each is from its first direction.
    pub tilts: Vec<f64>,
    /// Waypoints that are not free, each with its number in the path given.
    pub left: Vec<(usize, Gouge)>,
    /// Whether they go from the end of the path given to its start.
    pub reversed: bool,
    /// Where the path is cut at a turn: the first waypoint of each further piece, and the turn that it saves, in radians.
    pub cuts: Vec<(usize, f64)>,
    /// Where it turns more sharply than it should and is not cut: the second waypoint, and the turn.
    pub sharp: Vec<(usize, f64)>,
}

/// A waypoint on its way.
#[derive(Clone, Copy)]
struct Step {
    waypoint: Waypoint,
    wanted: UnitVector3<f64>,
    /// What has a key below this is there (`built`).
    before: u32,
    /// No tilt frees it.
    stuck: bool,
    /// It gouged as it was given.
    gouged: bool,
    /// Its number in the path given; none if it was put between here.
    given: Option<usize>,
    /// The directions of the step before and of this one when the way between them was looked at and found free.
    looked: Option<[UnitVector3<f64>; 2]>,
    /// The path is cut before it, since it would turn by so much from the step before.
    cut: Option<f64>,
    /// It turns from the step before by so much, which is too far, and the path is not cut.
    sharp: Option<f64>,
}

struct Walker<'a> {
    scene: &'a Scene<'a>,
    options: &'a GougingOptions,
    hints: &'a DirectionHints,
    steps: Vec<Step>,
    stack: Vec<(f64, u32)>,
    /// What searches for a tilt of one waypoint found, or on one leg.
    points: Points,
    /// What step 7 has turned.
    turned: Turned,
    /// What is near a way.
    near: Vec<u32>,
}

/// Tilts the waypoints of a path that gouge, each by itself.
pub(super) fn tilted<'a>(
    scene: &'a Scene<'a>,
    path: &ToolPath,
    start: u32,
    options: &'a GougingOptions,
    hints: &'a DirectionHints,
) -> Tilted<'a> {
    let mut walker = Walker::new(scene, path, start, options, hints);
    walker.tilt(usize::MAX);
    Tilted(walker)
}

impl<'a> Tilted<'a> {
    /// Waypoints that no tilt frees and that stay.
    pub fn left(&self) -> usize {
        self.0.steps.iter().filter(|step| step.is_left()).count()
    }

    /// The same path from its end to its start, if fewer waypoints are left that way.
    pub fn reversed(&self, scene: &'a Scene<'a>, path: &ToolPath, start: u32) -> Option<Tilted<'a>> {
        let mut walker = Walker::new(scene, &path.reversed(), start, self.0.options, self.0.hints);
        let (mut left, most, last) = (0, self.left(), path.waypoints.len() - 1);
        // Those first that are stuck the other way: most are in this one, too, and there is no need to look at the others.
        let stuck = self.0.steps.iter().zip(0..).filter(|(step, _)| step.is_left());
        for k in stuck.map(|(_, k)| last - k) {
            let direction = walker.steps[k].waypoint.axis;
            if !walker.is_free(k, &direction) {
                walker.tilt_at(k);
                left += usize::from(walker.steps[k].stuck);
            }
            if left >= most {
                return None;
            }
        }
        walker.tilt(most).then_some(Tilted(walker))
    }

    /// Sets the path free; `layer` is the number of the first waypoint of its layer.
    pub fn freed(self, layer: u32) -> ResolvedPath {
        let Tilted(mut walker) = self;
        let given = walker.steps.len();
        let gouging_before = walker.steps.iter().filter(|step| step.gouged).count();
        for k in 0..given {
            if walker.steps[k].stuck && !walker.raise(k) {
                walker.sink(k);
            }
        }
        if gouging_before > 0 || walker.is_sharp() {
            for _ in 0..INSERTIONS {
                walker.ramp();
                if !walker.insert() {
                    break;
                }
            }
            walker.ramp();
            walker.means();
            walker.steps.retain(|step| !(step.stuck && step.waypoint.added));
        }
        for _ in 0..DIVISIONS {
            let divided = walker.divide();
            if divided {
                walker.ramp();
            }
            if !walker.meet() && !divided {
                break;
            }
        }
        walker.cut();
        let (kept, all) = (walker.steps.iter().filter(|step| step.given.is_some()).count(), walker.steps.len());
        let (added, taken_out) = (all - kept, given - kept);
        ResolvedPath { gouging_before, added, taken_out, ..walker.finish(layer) }
    }
}

impl Step {
    fn new(waypoint: Waypoint, before: u32, given: Option<usize>) -> Self {
        Step {
            waypoint,
            wanted: waypoint.axis,
            before,
            stuck: false,
            gouged: false,
            given,
            looked: None,
            cut: None,
            sharp: None,
        }
    }

    /// Whether no tilt frees it, and it is not taken out.
    fn is_left(&self) -> bool {
        self.stuck && !self.waypoint.added
    }

    /// Whether its direction stays as it is.
    fn is_fixed(&self) -> bool {
        self.stuck || self.waypoint.lift != Vector3::zeros()
    }
}

impl<'a> Walker<'a> {
    fn new(
        scene: &'a Scene<'a>,
        path: &ToolPath,
        start: u32,
        options: &'a GougingOptions,
        hints: &'a DirectionHints,
    ) -> Self {
        let before = before(&path.waypoints, start);
        let steps = path.waypoints.iter().zip(before).enumerate();
        let steps = steps.map(|(k, (&waypoint, before))| Step::new(waypoint, before, Some(k))).collect();
        Walker {
            turned: Turned::default(),
            scene,
            options,
            hints,
            steps,
            stack: Vec::new(),
            points: Points::default(),
            near: Vec::new(),
        }
    }
}

impl Walker<'_> {
    fn stand(&self, k: usize) -> Stand {
        self.stand_of(&self.steps[k])
    }

    fn stand_of(&self, step: &Step) -> Stand {
        Stand { tip: step.waypoint.position, before: step.before, allowed: self.options.allowed_depth }
    }

    fn is_free(&mut self, k: usize, direction: &UnitVector3<f64>) -> bool {
        self.scene.is_free(self.stand(k), direction, &mut self.stack)
    }

    fn least_tilt(&mut self, k: usize, wanted: UnitVector3<f64>, limit: f64) -> Option<UnitVector3<f64>> {
        self.scene.least_tilt(self.stand(k), wanted, limit, &mut self.points, &mut self.stack)
    }

    fn turn(&self, k: usize, other: usize) -> f64 {
        angle(&self.steps[k].waypoint.axis, &self.steps[other].waypoint.axis)
    }

    /// The largest turn that may be between two neighbours.
    fn limit(&self, k: usize, other: usize) -> f64 {
        let way = (self.steps[k].waypoint.position - self.steps[other].waypoint.position).norm();
        self.options.max_turn.min(self.options.max_turn_per_mm * way)
    }

    /// Whether some waypoint turns too far from the one before.
    fn is_sharp(&self) -> bool {
        (1..self.steps.len()).any(|k| self.turn(k - 1, k) > self.limit(k - 1, k) + TURN_ROUNDING)
    }

    /// What came of it; `layer` is the number of the first waypoint of the layer.
    fn finish(mut self, layer: u32) -> ResolvedPath {
        let stuck = |k: &usize| self.steps[*k].stuck;
        // What was put between and is not free has been taken out, but for what makes a path of a waypoint given.
        let beside = |k: usize| [Some(k), k.checked_sub(1), Some(k + 1)].into_iter().flatten();
        let given = |k: usize| Some((k, beside(k).find_map(|k| self.steps.get(k)?.given)?));
        let stuck: Vec<_> = (0..self.steps.len()).filter(stuck).filter_map(given).collect();
        let left = stuck.into_iter().filter_map(|(k, given)| Some((given, self.gouge(k, layer)?))).collect();
        let tilts = self.steps.iter().map(|step| angle(&step.wanted, &step.waypoint.axis)).collect();
        let cuts = self.steps.iter().enumerate().filter_map(|(k, step)| Some((k, step.cut?))).collect();
        let sharp = self.steps.iter().enumerate().filter_map(|(k, step)| Some((k, step.sharp?))).collect();
        // Not `into_iter`, which would keep the memory of the steps, three times as much.
        let waypoints = self.steps.iter().map(|step| step.waypoint).collect();
        ResolvedPath { waypoints, tilts, left, cuts, sharp, ..ResolvedPath::default() }
    }

    /// How a waypoint that no tilt frees gouges.
    fn gouge(&mut self, waypoint: usize, layer: u32) -> Option<Gouge> {
        let (stand, direction) = (self.stand(waypoint), self.steps[waypoint].waypoint.axis);
        let Contact { obstacle, depth, part, .. } = self.scene.deepest(stand, &direction, &mut self.stack)?;
        // Earlier layers are finished before the first waypoint of this one.
        let earlier = Stand { before: after(layer), ..stand };
        let wanted = self.steps[waypoint].wanted;
        self.points.clear();
        let own_layer = self.least_tilt_or_known(earlier, wanted).is_some();
        Some(Gouge { path: 0, waypoint, obstacle, depth, part, own_layer })
    }
}
