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
mod turned;
mod turns;

use super::built::{after, before};
use super::deepest::{Contact, Scene, Stand};
use super::gouge::Gouge;
use super::options::GougingOptions;
use super::tilt::Points;
use crate::layer::DirectionHints;
use crate::orientation::{TURN_ROUNDING, ToolPath, Waypoint, along, angle, between, part_way};
use nalgebra::{Unit, UnitVector3, Vector3};
use std::f64::consts::FRAC_PI_2;
use turned::Turned;

/// Where none frees, the direction that is least deep is looked for up to this depth, to [`DEEPER_STEP`], in layer heights.
const DEEPEST: f64 = 3.0;
const DEEPER_STEP: f64 = 0.05;

/// Tips are raised by as many of these, in layer heights, as are needed.
const LIFT_STEP: f64 = 0.025;

/// How often points are put between: each time as many as an even turn needs, so more than once only where the new ones
/// have to be tilted as well. Where that does not do either, the turn is listed.
const INSERTIONS: usize = 3;

/// Where legs are looked at in step 6, the middle first, and how often.
const LOOKS: [f64; 7] = [0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875];
const DIVISIONS: usize = 3;

/// Rounds of step 4, and how far around a tilted waypoint it goes.
const MEANS: usize = 6;
const AROUND: usize = 8;

/// Turns of a direction by less than this in step 4, in radians, are not worth a check.
const SMALL: f64 = 0.004;

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
    walker.tilt();
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
        walker.tilt();
        let reversed = Tilted(walker);
        (reversed.left() < most).then_some(reversed)
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

    /// Step 1. The way to a waypoint and both its ends share one look, and a way that is free is not looked at again in step 6.
    fn tilt(&mut self) {
        for k in 0..self.steps.len() {
            if self.steps[k].gouged {
                continue;
            }
            // From a waypoint that was tilted the way turns far.
            let shares =
                k > 0 && !self.steps[k - 1].gouged && self.turn(k - 1, k) <= self.options.max_turn.min(FRAC_PI_2);
            let direction = self.steps[k].waypoint.axis;
            // What is near the way is gathered once for its end and for what lies between.
            let is_free = if shares {
                let [last, step] = [k - 1, k].map(|k| self.steps[k]);
                self.gather(&last, &step, step.before);
                let is_free = self.scene.is_free_of(&self.near, self.stand(k), &direction);
                if is_free && self.is_free_between(&last, &step) {
                    self.steps[k].looked = Some([last.waypoint.axis, direction]);
                }
                is_free
            } else {
                self.is_free(k, &direction)
            };
            if !is_free {
                self.tilt_at(k);
            }
        }
    }

    /// Tilts a waypoint that gouges.
    fn tilt_at(&mut self, k: usize) {
        self.points.clear();
        let direction = self.steps[k].waypoint.axis;
        let tilted = self.least_tilt_or_known(self.stand(k), direction);
        let step = &mut self.steps[k];
        (step.gouged, step.stuck) = (true, tilted.is_none());
        step.waypoint.axis = tilted.unwrap_or(direction);
    }

    /// Gives a waypoint that no tilt frees the direction that is least deep.
    fn sink(&mut self, k: usize) {
        let direction = self.steps[k].waypoint.axis;
        let (mut closed, mut open) = (self.options.allowed_depth, DEEPEST);
        let mut allowed = open;
        // Free as deep as `open`, not free as deep as `closed`.
        while open - closed > DEEPER_STEP {
            let stand = Stand { allowed, ..self.stand(k) };
            match self.least_tilt_or_known(stand, direction) {
                Some(direction) => {
                    self.steps[k].waypoint.axis = direction;
                    open = allowed;
                }
                // Not even as deep as that: it stays as it is.
                None if allowed >= DEEPEST => break,
                None => closed = allowed,
            }
            // Most are hardly deeper than allowed.
            allowed =
                closed + (open - closed).min(2.0 * (closed - self.options.allowed_depth) + 2.0 * DEEPER_STEP) / 2.0;
        }
    }

    /// Raises the tip of a waypoint that no tilt frees, as little as frees it (to [`LIFT_STEP`]); whether the limit does.
    fn raise(&mut self, k: usize) -> bool {
        self.points.clear();
        let stuck = self.steps[k];
        let (mut low, mut high) = (0.0, self.options.max_lift);
        let Some(mut raised) = (high > 0.0).then(|| self.raised(&stuck, high)).flatten() else { return false };
        // Free at `high`, not at `low`. A tip that is higher is not always as free, so this finds a height that frees, and at most a step
        // below one that does not.
        while high - low > LIFT_STEP {
            let lift = (low + high) / 2.0;
            match self.raised(&stuck, lift) {
                Some(waypoint) => (high, raised) = (lift, waypoint),
                None => low = lift,
            }
        }
        self.steps[k] = Step { waypoint: raised, stuck: false, ..stuck };
        true
    }

    /// A waypoint that is stuck with its tip raised by a share of the layer's height, across the layer, in its own direction or in one
    /// that is free up there.
    fn raised(&mut self, &Step { waypoint, wanted, before, .. }: &Step, share: f64) -> Option<Waypoint> {
        let lift = wanted.into_inner() * (share * waypoint.height);
        let stand = Stand { tip: waypoint.position + lift, before, allowed: self.options.allowed_depth };
        let is_free = self.scene.is_free(stand, &waypoint.axis, &mut self.stack);
        let direction = if is_free { waypoint.axis } else { self.least_tilt_or_known(stand, wanted)? };
        Some(Waypoint { position: stand.tip, axis: direction, lift, ..waypoint })
    }

    /// Frees a waypoint that was put between.
    fn free(&mut self, k: usize) {
        let direction = self.steps[k].waypoint.axis;
        if self.is_free(k, &direction) {
            return;
        }
        self.tilt_at(k);
    }

    /// The free direction nearest to the one wanted; where all are too far from that, the one nearest to the direction known for the place.
    fn least_tilt_or_known(&mut self, stand: Stand, wanted: UnitVector3<f64>) -> Option<UnitVector3<f64>> {
        let mut from =
            |wanted| self.scene.least_tilt(stand, wanted, self.options.max_tilt, &mut self.points, &mut self.stack);
        from(wanted).or_else(|| from(self.hints.at(stand.tip)?))
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

    /// Step 2.
    fn ramp(&mut self) {
        for k in 1..self.steps.len() {
            self.follow(k - 1, k);
        }
        for k in (1..self.steps.len()).rev() {
            self.follow(k, k - 1);
        }
    }

    /// Turns waypoint `k` toward `leader` until they differ by no more than the limit, if that is free.
    fn follow(&mut self, leader: usize, k: usize) {
        let (limit, turn) = (self.limit(leader, k), self.turn(leader, k));
        if turn <= limit + TURN_ROUNDING || self.steps[k].is_fixed() {
            return;
        }
        let [from, to] = [leader, k].map(|k| self.steps[k].waypoint.axis);
        let Some(nearer) = along(&from, &to, limit / turn) else {
            return;
        };
        // What is free but turns too far is no gain: the waypoint stays as it is.
        let within = |direction: &UnitVector3<f64>| angle(&from, direction) <= limit + TURN_ROUNDING;
        self.points.clear();
        let free = if self.is_free(k, &nearer) { Some(nearer) } else { self.least_tilt(k, nearer, 2.0 * limit) };
        if let Some(direction) = free.filter(within) {
            self.turn_to(k, direction);
        }
    }

    /// Step 3; whether there was anything to do.
    fn insert(&mut self) -> bool {
        let limit = self.options.max_turn;
        // More points do not make a turn gentler that the way is too short for.
        let helps = |last: &Step, step: &Step| {
            let way = (step.waypoint.position - last.waypoint.position).norm();
            let turn = angle(&last.waypoint.axis, &step.waypoint.axis);
            turn > limit + TURN_ROUNDING && turn <= self.options.max_turn_per_mm * way + TURN_ROUNDING
        };
        let long: Vec<bool> = self.steps.windows(2).map(|pair| helps(&pair[0], &pair[1])).collect();
        if !long.contains(&true) {
            return false;
        }
        let old = std::mem::take(&mut self.steps);
        for (k, step) in old.into_iter().enumerate() {
            if let Some(last) = self.steps.last().filter(|_| long[k - 1]).copied() {
                for waypoint in between(&last.waypoint, &step.waypoint, limit) {
                    self.steps.push(Step::new(waypoint, last.before, None));
                    self.free(self.steps.len() - 1);
                }
            }
            self.steps.push(step);
        }
        true
    }

    /// Step 4.
    fn means(&mut self) {
        let count = self.steps.len();
        let mut around = vec![false; count];
        for k in 0..count {
            if self.steps[k].waypoint.axis != self.steps[k].wanted {
                around[k.saturating_sub(AROUND)..(k + AROUND + 1).min(count)].fill(true);
            }
        }
        for _ in 0..MEANS {
            for k in (1..count.saturating_sub(1)).filter(|&k| around[k]) {
                if self.steps[k].is_fixed() {
                    continue;
                }
                let [last, here, next] = [k - 1, k, k + 1].map(|k| self.steps[k].waypoint.axis);
                let sum = last.into_inner() + here.into_inner() * 2.0 + next.into_inner();
                let Some(mean) = Unit::try_new(sum, 0.0) else {
                    continue;
                };
                // A mean may leave a turn too sharp that was so before, but make none sharper.
                let sound =
                    |other: &UnitVector3<f64>, limit: f64| angle(other, &mean) <= limit.max(angle(other, &here));
                let are_sound = sound(&last, self.limit(k - 1, k)) && sound(&next, self.limit(k, k + 1));
                if angle(&mean, &here) > SMALL && are_sound && self.is_free(k, &mean) {
                    self.steps[k].waypoint.axis = mean;
                }
            }
        }
    }

    /// Step 6; whether there was anything to do.
    fn divide(&mut self) -> bool {
        let old = std::mem::take(&mut self.steps);
        let mut any = false;
        for mut step in old {
            if let Some(last) = self.steps.last().filter(|last| !(last.stuck || step.stuck)).copied() {
                let ends = [&last, &step].map(|step| step.waypoint.axis);
                // What was found free stays free while neither end turns.
                if step.looked != Some(ends) {
                    self.points.clear();
                    self.gather(&last, &step, last.before);
                    let is_free = self.near.is_empty() && self.is_above_plate(&last, &step);
                    let put = !is_free && LOOKS.iter().any(|share| self.put_between(&last, &step, *share));
                    step.looked = (!put).then_some(ends);
                    any |= put;
                }
            }
            self.steps.push(step);
        }
        any
    }

    /// Puts a waypoint that is free a share of the way from one to another, if the nozzle gouges there; whether it did.
    fn put_between(&mut self, last: &Step, step: &Step, share: f64) -> bool {
        let Some(waypoint) = part_way(&last.waypoint, &step.waypoint, share) else { return false };
        let k = self.steps.len();
        let wanted = waypoint.axis;
        self.steps.push(Step::new(waypoint, last.before, None));
        let is_free = self.scene.is_free_of(&self.near, self.stand(k), &wanted);
        let tilted = if is_free { None } else { self.least_tilt(k, wanted, self.options.max_tilt) };
        match tilted {
            Some(direction) => self.steps[k].waypoint.axis = direction,
            None => drop(self.steps.pop()),
        }
        tilted.is_some()
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
        let waypoints = self.steps.into_iter().map(|step| step.waypoint).collect();
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
