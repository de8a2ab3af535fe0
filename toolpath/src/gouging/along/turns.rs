//! Turns that are too sharp for the way: directions that meet, and cuts where they do not. Steps 7 and 8 of the module above.

use super::turned::Turned;
use super::{Step, Walker};
use crate::gouging::GougingOptions;
use crate::gouging::deepest::Stand;
use crate::orientation::{TURN_ROUNDING, Waypoint, angle, part_way};
use nalgebra::UnitVector3;

/// Rounds of step 7 for a pair. Most pairs that meet at all do so in the first two.
const MEETINGS: usize = 4;

/// Turns are limited on each millimetre of a path: neighbours may be so near to each other that hardly any turn is gentle, and slower is
/// then enough.
const WINDOW_MM: f64 = 1.0;

/// A cut leaves out no more than is not free, to one of so many parts of the step.
const ENDS: u8 = 8;

/// Length of the path of a waypoint between two cuts: far below what any machine resolves, so the nozzle is as free.
const DOT_MM: f64 = 1e-3;

/// How far neighbours are from each other and how far they turn, each with the one before.
struct Pairs {
    ways: Vec<f64>,
    turns: Vec<f64>,
}

impl Pairs {
    fn of(walker: &Walker) -> Self {
        let all = 1..walker.steps.len();
        let way = |k: usize| (walker.steps[k].waypoint.position - walker.steps[k - 1].waypoint.position).norm();
        Pairs {
            ways: std::iter::once(0.0).chain(all.clone().map(way)).collect(),
            turns: std::iter::once(0.0).chain(all.map(|k| walker.turn(k - 1, k))).collect(),
        }
    }

    /// Some waypoints have other directions.
    fn update(&mut self, walker: &Walker, turned: impl Iterator<Item = usize>) {
        for k in turned.flat_map(|k| [k, k + 1]).filter(|&k| k > 0 && k < walker.steps.len()) {
            self.turns[k] = walker.turn(k - 1, k);
        }
    }
}

impl Walker<'_> {
    /// Gives a waypoint another direction.
    pub(super) fn turn_to(&mut self, k: usize, direction: UnitVector3<f64>) {
        let before = std::mem::replace(&mut self.steps[k].waypoint.axis, direction);
        if let Some(turned) = &mut self.turned.before {
            turned.push((k, before));
            self.turned.unsettle(k);
        }
    }

    /// Step 7; whether any two came nearer.
    pub(super) fn meet(&mut self) -> bool {
        let mut pairs = Pairs::of(self);
        let mut cuts = self.cuts(&pairs);
        if cuts.is_empty() {
            return false;
        }
        self.turned = Turned { before: Some(Vec::new()), settled: vec![[false; 2]; self.steps.len()] };
        let mut any = false;
        for k in cuts.clone() {
            if self.meet_at(k) {
                self.follow_around(k);
            }
            let turned = self.turned.before.replace(Vec::new()).unwrap_or_default();
            if turned.is_empty() {
                continue;
            }
            pairs.update(self, turned.iter().map(|&(k, _)| k));
            let now = self.cuts(&pairs);
            // Only as a whole: to turn one pair may sharpen others.
            if now.len() < cuts.len() {
                (any, cuts) = (true, now);
                continue;
            }
            for &(k, before) in turned.iter().rev() {
                self.steps[k].waypoint.axis = before;
                self.turned.unsettle(k);
            }
            pairs.update(self, turned.iter().map(|&(k, _)| k));
        }
        self.turned = Turned::default();
        any
    }

    /// Where the path is to be cut, so that on no millimetre of a piece the nozzle turns by more than the limit: the first waypoints of the
    /// pieces behind. Of the steps of such a millimetre it is the one that turns most for its length.
    fn cuts(&self, pairs: &Pairs) -> Vec<usize> {
        let GougingOptions { max_turn, max_turn_per_mm: per_mm, .. } = *self.options;
        let Pairs { ways, turns } = pairs;
        let excess = |k: usize| turns[k] - per_mm * ways[k];
        let (mut cuts, mut piece) = (Vec::new(), 0);
        let mut k = 1;
        // Windows that end at step `k`, and begin in the same piece.
        while k < self.steps.len() {
            let (mut from, mut length, mut sum) = (k, 0.0, 0.0);
            let is_sharp = loop {
                from -= 1;
                length += ways[from + 1];
                sum += turns[from + 1];
                let limit = per_mm * f64::max(length, WINDOW_MM);
                let limit = if from + 1 == k { limit.min(max_turn) } else { limit };
                // A turn is no larger than the turns on its way together.
                if sum > limit && self.turn(from, k) > limit + TURN_ROUNDING {
                    break true;
                }
                if from == piece || length >= WINDOW_MM {
                    break false;
                }
            };
            if is_sharp {
                let sharpest = (from + 1..=k).max_by(|&a, &b| excess(a).total_cmp(&excess(b)));
                piece = sharpest.unwrap_or(k);
                cuts.push(piece);
                k = piece;
            }
            k += 1;
        }
        cuts
    }

    /// Turns a waypoint and the one before to the nearest pair of free directions that is found; whether they are near enough.
    fn meet_at(&mut self, k: usize) -> bool {
        for _ in 0..MEETINGS {
            for (leader, other) in [(k, k - 1), (k - 1, k)] {
                if self.turn(k - 1, k) <= self.limit(k - 1, k) + TURN_ROUNDING {
                    return true;
                }
                if self.steps[other].is_fixed() {
                    continue;
                }
                let wanted = self.steps[leader].waypoint.axis;
                self.points.clear();
                // Each in turn goes to the free direction nearest to the other's: the angle between them never grows.
                if let Some(direction) = self.least_tilt(other, wanted, self.turn(k - 1, k)) {
                    self.turn_to(other, direction);
                }
            }
        }
        self.turn(k - 1, k) <= self.limit(k - 1, k) + TURN_ROUNDING
    }

    /// Step 2 from a waypoint and the one before to both ends. What a waypoint turns to depends on the directions of the two alone: where
    /// neither has turned since it changed nothing, it changes nothing again.
    fn follow_around(&mut self, k: usize) {
        for k in k + 1..self.steps.len() {
            self.follow_unless_settled(k - 1, k, 0);
        }
        for k in (1..k).rev() {
            self.follow_unless_settled(k, k - 1, 1);
        }
    }

    fn follow_unless_settled(&mut self, leader: usize, k: usize, way: usize) {
        let pair = leader.max(k);
        if self.turned.settled[pair][way] {
            return;
        }
        let before = self.turned.count();
        self.follow(leader, k);
        self.turned.settled[pair][way] = self.turned.count() == before;
    }

    /// Step 8.
    pub(super) fn cut(&mut self) {
        let mut cuts = self.cuts(&Pairs::of(self)).into_iter().peekable();
        let old = std::mem::take(&mut self.steps);
        // A point put between is looked at with what is there at the sample before. Where a piece begins with it, that one's bead lies there too.
        let (mut is_cut, mut begun) = (false, None);
        for (k, &step) in old.iter().enumerate() {
            is_cut |= cuts.next_if_eq(&k).is_some();
            if is_cut {
                begun = old[k..].iter().find(|step| !step.waypoint.added).map(|sample| sample.before);
            }
            let step = Step { before: begun.filter(|_| step.waypoint.added).unwrap_or(step.before), ..step };
            begun = begun.filter(|_| step.waypoint.added);
            if begun.is_some() && !self.scene.is_free(self.stand_of(&step), &step.waypoint.axis, &mut self.stack) {
                continue;
            }
            if !is_cut {
                self.steps.push(step);
                continue;
            }
            is_cut = false;
            let last = self.steps[self.steps.len() - 1];
            let turn = angle(&last.waypoint.axis, &step.waypoint.axis);
            let [end, start] = self.ends_between(&last, &step);
            let tip = |between: Option<Step>, other: &Step| between.unwrap_or(*other).waypoint.position;
            let gap = (tip(start, &step) - tip(end, &last)).norm();
            if gap > step.waypoint.width && self.is_way_free(&last, &step) {
                self.steps.push(Step { sharp: Some(turn), ..step });
                continue;
            }
            let pieces = [end, start.map(|start| Step { cut: Some(turn), ..start })];
            self.steps.extend(pieces.into_iter().flatten());
            self.steps.push(Step { cut: start.is_none().then_some(turn), ..step });
        }
        self.keep_lone();
    }

    /// A waypoint between two cuts is no path. It becomes one of [`DOT_MM`], so that what is built where does not change.
    fn keep_lone(&mut self) {
        let old = std::mem::take(&mut self.steps);
        let begins = |k: usize| old.get(k).is_none_or(|step| k == 0 || step.cut.is_some());
        for (k, &step) in old.iter().enumerate() {
            if !(begins(k) && begins(k + 1)) {
                self.steps.push(step);
                continue;
            }
            // Toward the next waypoint; of the last one, from the one before.
            let onward = k + 1 < old.len();
            let beside = &old[if onward { k + 1 } else { k.saturating_sub(1) }];
            let way =
                (beside.waypoint.position - step.waypoint.position).try_normalize(0.0).unwrap_or_default() * DOT_MM;
            let arc = step.waypoint.arc + if onward { DOT_MM } else { -DOT_MM };
            let waypoint = Waypoint { position: step.waypoint.position + way, arc, added: true, ..step.waypoint };
            let dot = Step { waypoint, given: None, cut: None, ..step };
            if onward {
                self.steps.extend([step, dot]);
            } else {
                self.steps.extend([Step { cut: step.cut, ..dot }, Step { cut: None, ..step }]);
            }
        }
    }

    /// Where the piece before a cut may end, standing as it does, and the next one begin, nearer to each other than the two waypoints that they
    /// end and begin with: at one place, if both are free there.
    fn ends_between(&mut self, last: &Step, step: &Step) -> [Option<Step>; 2] {
        // What the piece before has laid is there when the next one begins.
        let at = |of: &Step, share: f64| {
            let stand = |step: &Step| Waypoint { axis: of.waypoint.axis, ..step.waypoint };
            let waypoint = part_way(&stand(last), &stand(step), share)?;
            Some(Step::new(waypoint, of.before, None))
        };
        let shares = (0..=ENDS).map(|k| f64::from(k) / f64::from(ENDS));
        let end = shares.clone().rev().find_map(|share| {
            let end = at(last, share).filter(|end| share > 0.0 && self.is_way_free(last, end))?;
            Some((share, end))
        });
        let from = end.map_or(0.0, |(share, _)| share);
        let start = shares.filter(|&share| (from..1.0).contains(&share));
        let start = start.filter_map(|share| at(step, share)).find(|start| self.is_way_free(start, step));
        [end.map(|(_, end)| end), start]
    }

    /// Whether two waypoints and the way between them are free of what is there at either.
    fn is_way_free(&mut self, last: &Step, step: &Step) -> bool {
        let before = last.before.max(step.before);
        self.gather(last, step, before);
        let stand = |step: &Step| Stand { tip: step.waypoint.position, before, allowed: self.options.allowed_depth };
        let is_free = |step: &Step| self.scene.is_free_of(&self.near, stand(step), &step.waypoint.axis);
        is_free(last) && is_free(step) && self.is_free_between(&Step { before, ..*last }, step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gouging::Nozzle;
    use crate::gouging::deepest::Scene;
    use crate::layer::{BuiltLayer, DirectionHints, LayerStack};
    use crate::orientation::ToolPath;
    use crate::path::BeadKind;
    use nalgebra::{Point3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const COUNT: u32 = 40;

    /// What a comparison has seen: pairs that were kept and pairs that were turned in vain.
    #[derive(Debug, Default)]
    struct Seen {
        kept: usize,
        undone: usize,
    }

    /// Slow twin of [`Walker::meet`]: all steps are copied before each pair, and step 2 asks all of them.
    fn meet_by_copies(walker: &mut Walker, seen: &mut Seen) -> bool {
        let mut cuts = cuts_by_all_turns(walker);
        for k in cuts.clone() {
            let before = walker.steps.clone();
            if walker.meet_at(k) {
                (k + 1..walker.steps.len()).for_each(|k| walker.follow(k - 1, k));
                (1..k).rev().for_each(|k| walker.follow(k, k - 1));
            }
            let now = cuts_by_all_turns(walker);
            if now.len() < cuts.len() {
                seen.kept += 1;
                cuts = now;
            } else {
                let is_turned = |(old, new): (&Step, &Step)| old.waypoint.axis != new.waypoint.axis;
                seen.undone += usize::from(before.iter().zip(&walker.steps).any(is_turned));
                walker.steps = before;
            }
        }
        seen.kept > 0
    }

    /// Slow twin of [`Walker::cuts`]: each turn of each window is measured.
    fn cuts_by_all_turns(walker: &Walker) -> Vec<usize> {
        let GougingOptions { max_turn, max_turn_per_mm: per_mm, .. } = *walker.options;
        let way = |k: usize| (walker.steps[k].waypoint.position - walker.steps[k - 1].waypoint.position).norm();
        let excess = |k: usize| walker.turn(k - 1, k) - per_mm * way(k);
        let (mut cuts, mut piece, mut k) = (Vec::new(), 0, 1);
        while k < walker.steps.len() {
            let mut length = 0.0;
            let mut ended = false;
            let sharp = (piece..k).rev().find(|&from| {
                let is_in = !ended;
                length += way(from + 1);
                ended |= length >= WINDOW_MM;
                let limit = per_mm * f64::max(length, WINDOW_MM);
                let limit = if from + 1 == k { limit.min(max_turn) } else { limit };
                is_in && walker.turn(from, k) > limit + TURN_ROUNDING
            });
            if let Some(from) = sharp {
                let sharpest = (from + 1..=k).max_by(|&a, &b| excess(a).total_cmp(&excess(b)));
                piece = sharpest.unwrap_or(k);
                cuts.push(piece);
                k = piece;
            }
            k += 1;
        }
        cuts
    }

    /// Walls of random heights on both sides of the x axis.
    fn walls(draw: &mut Pcg64Mcg) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for side in [-1.0, 1.0] {
            let first = vertices.len() as u32;
            for k in 0..COUNT {
                let high = 5.0 + 2.0 * draw.random::<f64>().powi(4);
                vertices.extend([1.2, 2.8].map(|y| Point3::new(0.5 * f64::from(k), side * y, high)));
            }
            let quad = |k: u32| [first + 2 * k, first + 2 * k + 1, first + 2 * k + 2, first + 2 * k + 3];
            let halves =
                |[a, b, c, d]: [u32; 4]| if side < 0.0 { [[a, d, b], [a, c, d]] } else { [[a, b, d], [a, d, c]] };
            triangles.extend((0..COUNT - 1).map(quad).flat_map(halves));
        }
        (vertices, triangles)
    }

    /// A path along the x axis whose directions wander and jump.
    fn path(draw: &mut Pcg64Mcg) -> ToolPath {
        let (mut x, mut lean) = (0.0, [0.0; 2]);
        let waypoints = (0..COUNT).map(|_| {
            x += 0.1 + 0.6 * draw.random::<f64>();
            let by = if draw.random::<f64>() < 0.1 { 1.0 } else { 0.1 };
            lean = lean.map(|lean: f64| (lean + by * (draw.random::<f64>() - 0.5)).clamp(-0.8, 0.8));
            Waypoint {
                position: Point3::new(x, 0.0, 5.0),
                axis: UnitVector3::new_normalize(Vector3::new(lean[0], lean[1], 1.0)),
                width: 0.5,
                height: 0.4,
                arc: x,
                added: false,
                lift: Vector3::zeros(),
                kind: BeadKind::Solid,
            }
        });
        ToolPath { layer: 0, curve: 0, closed: false, waypoints: waypoints.collect() }
    }

    /// Between random walls a path whose waypoints are tilted, with a limit for turns on a millimetre.
    fn tilted_between_walls(
        draw: &mut Pcg64Mcg,
        limit: impl FnOnce(&mut Pcg64Mcg) -> f64,
        mut see: impl FnMut(Walker),
    ) {
        let (vertices, triangles) = walls(draw);
        let spacing = vec![0.4; triangles.len()];
        let layers = [BuiltLayer { vertices: &vertices, triangles: &triangles, spacing: &spacing, curves: &[] }];
        let stack = LayerStack::new(&layers).unwrap();
        let nozzle = Nozzle::default();
        let scene = Scene::new(&stack, &stack.keys, &nozzle, None);
        let options = GougingOptions { max_turn_per_mm: limit(draw), max_tilt: 1.0, ..GougingOptions::default() };
        let hints = DirectionHints::default();
        let mut walker = Walker::new(&scene, &path(draw), 5, &options, &hints);
        walker.tilt(usize::MAX);
        see(walker);
    }

    fn axes(walker: &Walker) -> Vec<UnitVector3<f64>> {
        walker.steps.iter().map(|step| step.waypoint.axis).collect()
    }

    /// What no tilt frees, and what is raised, turns no more: neither to ramps, nor to means, nor to meet.
    #[test]
    fn stuck_and_raised_waypoints_keep_their_directions() {
        let mut turned = 0;
        for seed in 0..20 {
            tilted_between_walls(
                &mut Pcg64Mcg::seed_from_u64(seed),
                |_| 0.1,
                |mut walker| {
                    for (k, step) in walker.steps.iter_mut().enumerate() {
                        step.stuck |= k % 3 == 0;
                        step.waypoint.lift = Vector3::z() * if k % 3 == 1 { 0.1 } else { 0.0 };
                    }
                    let given = axes(&walker);
                    walker.ramp();
                    walker.means();
                    walker.meet();
                    for (k, (now, given)) in axes(&walker).iter().zip(&given).enumerate() {
                        assert!(k % 3 == 2 || now == given, "seed {seed}, waypoint {k}");
                        turned += usize::from(now != given);
                    }
                },
            );
        }
        assert!(turned > 50, "{turned}");
    }

    #[test]
    fn directions_meet_as_if_all_steps_were_copied() {
        let (mut kept, mut undone, mut stuck) = (0, 0, 0);
        for seed in 0..100 {
            let limit = |draw: &mut Pcg64Mcg| 0.1 + 0.3 * draw.random::<f64>();
            tilted_between_walls(&mut Pcg64Mcg::seed_from_u64(seed), limit, |mut walker| {
                stuck += usize::from(walker.steps.iter().any(|step| step.stuck));
                let given = walker.steps.clone();
                let mut seen = Seen::default();
                let any = meet_by_copies(&mut walker, &mut seen);
                let expected = axes(&walker);
                walker.steps = given;
                assert_eq!((walker.meet(), axes(&walker)), (any, expected), "seed {seed}");
                (kept, undone) = (kept + seen.kept, undone + seen.undone);
            });
        }
        assert!(kept > 100 && undone > 200 && stuck > 50, "{kept} {undone} {stuck}");
    }
}
