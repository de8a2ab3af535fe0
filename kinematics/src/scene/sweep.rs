//! Is a whole motion free? A proof by bisection.
//!
//! A motion is a cubic in joint space ([`Scene::sweep_cubic`]), or as its special case a straight line ([`Scene::sweep`]);
//! `t` runs from 0 to 1. Within an interval no point of body B moves against body A by more than `s` from where it is at
//! the middle. `s` sums, over the joints between the two, the turn times the lever arm:
//! * The turn is how far the joint ever is, in the interval, from where it is at the middle. On a straight motion it is
//!   what the joint turns in half the interval; of a cubic it follows from the control points of the interval (see
//!   `motion`).
//! * The lever arm is how far any point of the body can be from the joint's axis: at most how far it can ever be (see
//!   `chain`), and at most how far it is at the middle and what the joints behind this one add to that.
//!
//! The sum holds for any posture whose joints are within these turns: the joints get there one after the other, the last
//! of the chain first, and each finds its axis where it was at the middle.
//!
//! So a pair that is apart by more than `margin + s` at the middle is farther apart than the margin in all of the
//! interval. Intervals for which some pair lacks that are halved, the earlier half first, with the pairs that lack it.
//! With `s` below the resolution a pair lacks it only if it comes within margin + resolution at that very middle: there
//! the sweep ends, and all before the interval has been proven free. The halving ends: a turn is at most `3 h` times the
//! length of the joint's control polygon, for half-width `h`.
//!
//! Where only yes or no is wanted ([`Scene::is_free`], [`Scene::is_cubic_free`]) intervals are taken by width, the widest
//! first, and a pair nearer than the margin at the middle of one of the widest ends it at once: what is in the way is
//! seldom thin.
//!
//! The bound is that of conservative advancement (B. Mirtich, *Impulse-based dynamic simulation of rigid body
//! systems*, PhD thesis, Berkeley 1996, section 2.3), but a distance at the middle of an interval proves twice as much as
//! one at its end, and pairs far apart leave after one look.

use super::Scene;
use super::motion::{Motion, Turns};
use super::pairs::Apart;
use super::query::{Poses, Posture, PostureError};
use super::rounding::SHARE;

/// What a sweep has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sweep<'a> {
    /// All pairs stay farther apart than the margin, all the way.
    Free,
    /// At `at` two bodies are not shown to be farther apart than margin and resolution together.
    Near {
        /// Their names.
        bodies: [&'a str; 2],
        /// How far along, from 0 to 1.
        at: f64,
        /// Before this all pairs stay farther apart than the margin; 0 when that cannot be said even of the start.
        free_until: f64,
    },
}

/// Why a motion cannot be swept.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The posture at its start is invalid.
    #[error("at the start: {0}")]
    From(#[source] PostureError),
    /// The posture at its end is invalid.
    #[error("at the end: {0}")]
    To(#[source] PostureError),
    /// A control point between start and end is no posture.
    #[error("at control point {index}: {source}")]
    Control {
        /// Which one: 1 or 2 of 0 to 3.
        index: usize,
        /// Why.
        source: PostureError,
    },
    /// A joint turns so far that it can only be a mistake.
    #[error("{} {} turns by {turn} rad in one motion: at most {max} rad can be swept", if *table { "axis of the table" } else { "joint" }, joint + 1)]
    TooLong {
        /// Whether it is one of the table.
        table: bool,
        /// Which one, counted from 0.
        joint: usize,
        /// How far it turns; of a cubic, along its control polygon.
        turn: f64,
        /// How far it may.
        max: f64,
    },
    /// The resolution is no length.
    #[error("the resolution is {value}: it must be from {min} to 1e6 mm")]
    Resolution {
        /// Its value.
        value: f64,
        /// The least one that rounding allows.
        min: f64,
    },
}

/// In millimetres. Far above what rounding decides; below it a pass that is just wide enough takes millions of checks.
pub(crate) const MIN_RESOLUTION: f64 = 1e-3;

/// In radians: the four turns that a joint has from stop to stop, four times over.
const MAX_TURN: f64 = 100.0;

/// How far points of the bodies move at most from the middle of an interval: of each body, by all joints from each on.
struct Travel(Vec<[f64; 7]>);

/// Down to this half-width middles are looked at for what is in the way, and not for clearance only.
const COARSE: f64 = 1.0 / 16.0;

impl Scene {
    /// Whether the motion from one posture to another, all joints evenly and at once, is free.
    ///
    /// A longer motion through several postures is free when each piece of it is. `resolution` (millimetres; at least
    /// 1e-3) is what may be lacking: a motion that stays farther apart than margin and resolution is always shown to be
    /// free, one that comes nearer than the margin never is, and between the two either may be said.
    ///
    /// # Errors
    /// [`SweepError`] names the joint that is no angle or turns by more than 100 rad, or an invalid resolution.
    ///
    /// # Cost
    /// A few checks of the pairs in question where there is clearance; at most `travel / resolution` checks in a pass that is
    /// just wide enough. Nothing depends on the speed of the motion.
    pub fn sweep(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<Sweep<'_>, SweepError> {
        Ok(self.first_near(&self.straight(from, to, resolution)?, resolution))
    }

    /// Whether a cubic motion is free: a piece of a cubic spline in joint space, as robots execute it.
    ///
    /// # Arguments
    /// * `control`: Bezier control points of the motion in joint space, first and last the postures at its ends. Those
    ///   between need not be postures that the robot could take, they only need to be angles. Limits of joints and of the
    ///   table are not looked at, as in [`Scene::sweep`].
    /// * `resolution`: as in [`Scene::sweep`], in millimetres, at least 1e-3.
    ///
    /// # Returns
    /// What [`Scene::sweep`] says, of the curve itself: `at` and `free_until` are its parameter, which is the share of
    /// time when the control points come from a spline in time (see [`cubic_control`](super::cubic_control)). Four
    /// equally spaced control points are a straight motion.
    ///
    /// # Errors
    /// [`SweepError`] names the control point and its joint that is no angle, the joint that turns by more than 100 rad
    /// along the control polygon, or an invalid resolution.
    ///
    /// # Cost
    /// That of a sweep along the same way, and more checks where the control points are far from the curve: at most
    /// `3 * length of the control polygon / resolution` in a pass that is just wide enough. The result is deterministic.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::nalgebra::{Isometry3, Point3};
    /// use curvlay_kinematics::scene::{Body, Mount, Posture, Scene, SceneModel, Shape, Sweep, links};
    /// use curvlay_kinematics::{Arm, robots};
    /// let desk = Shape::block(Point3::new(-600.0, -600.0, -40.0), Point3::new(600.0, 600.0, 0.0));
    /// let desk = Body { name: "desk".into(), mount: Mount::Base, mount_body: Isometry3::identity(), shape: desk };
    /// let arm = Arm::new(&robots::UR3)?;
    /// let scene = Scene::new(SceneModel { bodies: vec![desk], links: links(&robots::UR3), ..SceneModel::of(arm) })?;
    /// // The arm leans out, and in between down to the desk.
    /// let leaning = |shoulder: f64| Posture::from([0.0, shoulder, -0.6, -1.9, 1.5708, 0.0]);
    /// let level = [-1.0, -0.9, -0.8, -0.7].map(leaning);
    /// assert_eq!(scene.sweep_cubic(&level, 0.1)?, Sweep::Free);
    /// let dipping = [-1.0, 1.5, 1.5, -0.7].map(leaning);
    /// let Sweep::Near { bodies, at, .. } = scene.sweep_cubic(&dipping, 0.1)? else { unreachable!() };
    /// assert!(bodies.contains(&"desk") && at < 0.5);
    /// // A straight motion between the same ends does not show it.
    /// assert_eq!(scene.sweep(&dipping[0], &dipping[3], 0.1)?, Sweep::Free);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sweep_cubic(&self, control: &[Posture; 4], resolution: f64) -> Result<Sweep<'_>, SweepError> {
        Ok(self.first_near(&self.cubic(control, resolution)?, resolution))
    }

    /// Goes through a motion that has been checked.
    fn first_near(&self, motion: &Motion, resolution: f64) -> Sweep<'_> {
        let mut open = self.pairs.clone();
        // Intervals still to be shown free, the earliest last: middle, half-width, and which of the open pairs.
        let mut stack = vec![(0.5, 0.5, 0..open.len())];
        while let Some((middle, half, range)) = stack.pop() {
            // Pairs listed behind those of this interval belonged to earlier ones, which are done.
            open.truncate(range.end);
            let poses = self.poses(&motion.at(middle));
            let travel = self.travel(&poses, &motion.turns(middle, half));
            let lacking = open.len();
            for k in range {
                let pair = open[k];
                let reach = self.reach(pair, &travel);
                if self.pair_apart(&poses, &pair, self.threshold(&pair) + reach) {
                    continue;
                }
                if reach <= resolution {
                    return Sweep::Near { bodies: self.names_of(&pair), at: middle, free_until: middle - half };
                }
                open.push(pair);
            }
            if open.len() > lacking {
                let quarter = 0.5 * half;
                stack.push((middle + quarter, quarter, lacking..open.len()));
                stack.push((middle - quarter, quarter, lacking..open.len()));
            }
        }
        Sweep::Free
    }

    /// Whether the motion from one posture to another is free. The same answer as [`Scene::sweep`], without the place of the
    /// contact, and faster where it is not free.
    ///
    /// # Errors
    /// Those of [`Scene::sweep`].
    ///
    /// # Cost
    /// Where it is free, that of a sweep; where it is not, mostly a few checks.
    pub fn is_free(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<bool, SweepError> {
        Ok(self.all_apart(&self.straight(from, to, resolution)?, resolution))
    }

    /// Whether a cubic motion is free. The same answer as [`Scene::sweep_cubic`], without the place of the contact, and
    /// faster where it is not free.
    ///
    /// # Errors
    /// Those of [`Scene::sweep_cubic`].
    ///
    /// # Cost
    /// Where it is free, that of a sweep; where it is not, mostly a few checks.
    pub fn is_cubic_free(&self, control: &[Posture; 4], resolution: f64) -> Result<bool, SweepError> {
        Ok(self.all_apart(&self.cubic(control, resolution)?, resolution))
    }

    /// Goes through a motion that has been checked, the widest intervals first.
    fn all_apart(&self, motion: &Motion, resolution: f64) -> bool {
        let mut open = self.pairs.clone();
        // Intervals of one width: their middles, and which of the open pairs each has still to be shown free for.
        let mut level = vec![(0.5, 0..open.len())];
        let mut half = 0.5;
        while !level.is_empty() {
            let (mut narrower, mut lacking) = (vec![], vec![]);
            for (middle, range) in level {
                let poses = self.poses(&motion.at(middle));
                let travel = self.travel(&poses, &motion.turns(middle, half));
                let first = lacking.len();
                for pair in &open[range] {
                    let reach = self.reach(*pair, &travel);
                    if self.pair_apart(&poses, pair, self.threshold(pair) + reach) {
                        continue;
                    }
                    if reach <= resolution || (half >= COARSE && !self.pair_apart(&poses, pair, self.threshold(pair))) {
                        return false;
                    }
                    lacking.push(*pair);
                }
                if lacking.len() > first {
                    let quarter = 0.5 * half;
                    narrower.extend([middle - quarter, middle + quarter].map(|at| (at, first..lacking.len())));
                }
            }
            (level, open) = (narrower, lacking);
            half *= 0.5;
        }
        true
    }

    fn straight(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<Motion, SweepError> {
        from.check(self.has_table()).map_err(SweepError::From)?;
        to.check(self.has_table()).map_err(SweepError::To)?;
        self.checked(Motion::straight(&self.arm, from, to), resolution)
    }

    fn cubic(&self, control: &[Posture; 4], resolution: f64) -> Result<Motion, SweepError> {
        for (index, posture) in control.iter().enumerate() {
            posture.check(self.has_table()).map_err(|source| match index {
                0 => SweepError::From(source),
                3 => SweepError::To(source),
                _ => SweepError::Control { index, source },
            })?;
        }
        self.checked(Motion::bezier(&self.arm, control), resolution)
    }

    /// Checks a motion through postures that have been checked.
    fn checked(&self, motion: Motion, resolution: f64) -> Result<Motion, SweepError> {
        if !(MIN_RESOLUTION..=super::MAX_COORDINATE).contains(&resolution) {
            return Err(SweepError::Resolution { value: resolution, min: MIN_RESOLUTION });
        }
        let (arm, on_table) = motion.lengths();
        let long = |table, angles: &[f64]| {
            let joint = angles.iter().position(|&turn| turn > MAX_TURN)?;
            Some(SweepError::TooLong { table, joint, turn: angles[joint], max: MAX_TURN })
        };
        let long_table = || long(true, &on_table).filter(|_| self.has_table());
        match long(false, &arm).or_else(long_table) {
            Some(error) => Err(error),
            None => Ok(motion),
        }
    }

    /// How far points of all bodies move at most from where they are, when the joints turn by so much.
    fn travel(&self, poses: &Poses, (arm, table): &Turns) -> Travel {
        let of = |body: usize| {
            let placed = &self.bodies[body];
            let turns: &[f64] = if self.on_table(body) { table } else { arm };
            let mut sums = [0.0; 7];
            let slides = self.track.is_some() && self.on_table(body);
            for (k, lever_arm) in placed.lever_arms.iter().enumerate().rev() {
                let axis = || self.axis(poses, self.on_table(body), k);
                // What slides has no axis, and all of it moves alike.
                let here = if slides { *lever_arm } else { poses.farthest(body, &placed.pieces, &axis()) };
                // What joints behind this one move away from its axis, they move at most so far.
                let most = lever_arm.min(here + sums[k + 1]);
                sums[k] = sums[k + 1] + most * turns[k] * (1.0 + SHARE);
            }
            sums
        };
        Travel((0..self.bodies.len()).map(of).collect())
    }

    /// How far points of the two bodies move against each other at most.
    fn reach(&self, [a, b]: [usize; 2], Travel(travel): &Travel) -> f64 {
        match self.relation(a, b) {
            None => 0.0,
            Some(([_, outer], Apart::Behind { from, .. })) => travel[outer][from],
            Some(([inner, outer], Apart::Both)) => travel[inner][0] + travel[outer][0],
        }
    }
}
