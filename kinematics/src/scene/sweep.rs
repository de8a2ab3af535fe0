//! Is a whole motion free? A proof by bisection.
//!
//! All joints go evenly from one posture to another; `t` runs from 0 to 1. Against body A no point of body B moves by
//! more than `s` within an interval of half-width `h` from its middle, where `s` sums, over the joints between the two,
//! how far the joint turns in half the interval times how far any point of the body can be from its axis there: at most
//! how far it can ever be (see `chain`), and at most how far it is at the middle, and what the joints behind this one add to
//! that. So a pair that is apart by more than `margin + s` at the middle is farther apart than the margin in all of the
//! interval. Intervals for which some pair lacks that are halved, the earlier half first, with the pairs that lack it.
//! With `s` below the resolution a pair lacks it only if it comes within margin + resolution at that very middle: there
//! the sweep ends, and all before the interval has been proven free.
//!
//! Where only yes or no is wanted ([`Scene::is_free`]) intervals are taken by width, the widest first, and a pair nearer than
//! the margin at the middle of one of the widest ends it at once: what is in the way is seldom thin.
//!
//! The bound is that of conservative advancement (B. Mirtich, *Impulse-based dynamic simulation of rigid body
//! systems*, PhD thesis, Berkeley 1996, section 2.3), but a distance at the middle of an interval proves twice as much as
//! one at its end, and pairs far apart leave after one look.

use super::Scene;
use super::pairs::Apart;
use super::query::{Poses, Posture, PostureError};

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

/// A sweep that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The posture from which it goes out is none.
    #[error("at the start: {0}")]
    From(#[source] PostureError),
    /// The posture to which it leads is none.
    #[error("at the end: {0}")]
    To(#[source] PostureError),
    /// A joint turns so far that it can only be a mistake.
    #[error("{} {} turns by {turn} rad in one motion: at most {most} rad can be swept", if *table { "axis of the table" } else { "joint" }, joint + 1)]
    TooLong {
        /// Whether it is one of the table.
        table: bool,
        /// Which one, counted from 0.
        joint: usize,
        /// How far it turns.
        turn: f64,
        /// How far it may.
        most: f64,
    },
    /// The resolution is no length.
    #[error("the resolution is {value}: it must be from {least} to 1e6 mm")]
    Resolution {
        /// Its value.
        value: f64,
        /// The least one that rounding allows.
        least: f64,
    },
}

/// In millimetres. Far above what rounding decides; below it a pass that is just wide enough takes millions of checks.
const LEAST_RESOLUTION: f64 = 1e-3;

/// In radians: the four turns that a joint has from stop to stop, four times over.
const FARTHEST_TURN: f64 = 100.0;

/// How far each joint turns, of the arm and of the table.
type Turns = ([f64; 6], [f64; 2]);

/// How far points of the bodies move at most in half an interval: of each body, by all joints from each one on.
struct Travel(Vec<[f64; 7]>);

/// Down to this half-width middles are looked at for what is in the way, and not for room only.
const COARSE: f64 = 1.0 / 16.0;

impl Scene {
    /// Whether the motion from one posture to another, all joints evenly and at once, is free.
    ///
    /// A longer motion through several postures is free when each piece of it is. `resolution` (millimetres; at least
    /// 1e-3) is what may be lacking: a motion that stays farther apart than margin and resolution is always shown to be
    /// free, one that comes nearer than the margin never is, and between the two either may be said.
    ///
    /// # Errors
    /// [`SweepError`] names the joint that is no angle or turns by more than 100 rad, or a resolution that is none.
    ///
    /// # Cost
    /// A few checks of the pairs in question where there is room; at most `travel / resolution` checks in a pass that is
    /// just wide enough. Nothing depends on the speed of the motion.
    pub fn sweep(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<Sweep<'_>, SweepError> {
        let turns = self.turns(from, to, resolution)?;
        let mut open = self.pairs.clone();
        // Intervals still to be shown free, the earliest last: middle, half-width, and which of the open pairs.
        let mut stack = vec![(0.5, 0.5, 0..open.len())];
        while let Some((middle, half, range)) = stack.pop() {
            // Pairs listed behind those of this interval belonged to earlier ones, which are done.
            open.truncate(range.end);
            let poses = self.poses(&between(from, to, middle));
            let travel = self.travel(&poses, &turns, half);
            let lacking = open.len();
            for k in range {
                let pair = open[k];
                let reach = self.reach(pair, &travel);
                if self.pair_apart(&poses, &pair, self.margin + reach) {
                    continue;
                }
                if reach <= resolution {
                    return Ok(Sweep::Near { bodies: self.names_of(&pair), at: middle, free_until: middle - half });
                }
                open.push(pair);
            }
            if open.len() > lacking {
                let quarter = 0.5 * half;
                stack.push((middle + quarter, quarter, lacking..open.len()));
                stack.push((middle - quarter, quarter, lacking..open.len()));
            }
        }
        Ok(Sweep::Free)
    }

    /// Whether the motion from one posture to another is free, as [`Scene::sweep`] says it, but not where it ends: sooner
    /// told where it is not.
    ///
    /// # Errors
    /// Those of [`Scene::sweep`].
    ///
    /// # Cost
    /// Where it is free, that of a sweep; where it is not, mostly a few checks.
    pub fn is_free(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<bool, SweepError> {
        let turns = self.turns(from, to, resolution)?;
        let mut open = self.pairs.clone();
        // Intervals of one width: their middles, and which of the open pairs each has still to be shown free for.
        let mut level = vec![(0.5, 0..open.len())];
        let mut half = 0.5;
        while !level.is_empty() {
            let (mut narrower, mut lacking) = (vec![], vec![]);
            for (middle, range) in level {
                let poses = self.poses(&between(from, to, middle));
                let travel = self.travel(&poses, &turns, half);
                let first = lacking.len();
                for pair in &open[range] {
                    let reach = self.reach(*pair, &travel);
                    if self.pair_apart(&poses, pair, self.margin + reach) {
                        continue;
                    }
                    if reach <= resolution || (half >= COARSE && !self.pair_apart(&poses, pair, self.margin)) {
                        return Ok(false);
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
        Ok(true)
    }

    /// Checks a motion.
    fn turns(&self, from: &Posture, to: &Posture, resolution: f64) -> Result<Turns, SweepError> {
        from.check(self.positioner.is_some()).map_err(SweepError::From)?;
        to.check(self.positioner.is_some()).map_err(SweepError::To)?;
        if !(LEAST_RESOLUTION..=super::FARTHEST).contains(&resolution) {
            return Err(SweepError::Resolution { value: resolution, least: LEAST_RESOLUTION });
        }
        let turns = turns(from, to);
        let long = |table, angles: &[f64]| {
            let joint = angles.iter().position(|&turn| turn > FARTHEST_TURN)?;
            Some(SweepError::TooLong { table, joint, turn: angles[joint], most: FARTHEST_TURN })
        };
        let long_table = || long(true, &turns.1).filter(|_| self.positioner.is_some());
        if let Some(error) = long(false, &turns.0).or_else(long_table) {
            return Err(error);
        }
        Ok(turns)
    }

    /// How far points of all bodies move in half an interval about a middle.
    fn travel(&self, poses: &Poses, (arm, table): &Turns, half: f64) -> Travel {
        let of = |body: usize| {
            let placed = &self.bodies[body];
            let turns: &[f64] = if self.on_table(body) { table } else { arm };
            let mut sums = [0.0; 7];
            for (k, swing) in placed.swings.iter().enumerate().rev() {
                let here = poses.farthest(body, &placed.pieces, &self.axis(poses, self.on_table(body), k));
                // What joints behind this one move away from its axis, they move at most so far.
                let most = swing.min(here + sums[k + 1]);
                sums[k] = sums[k + 1] + most * turns[k] * half * (1.0 + ROUNDING);
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

/// Sums of products are less wrong than this.
const ROUNDING: f64 = 1e-12;

fn turns(from: &Posture, to: &Posture) -> Turns {
    (
        std::array::from_fn(|k| (to.joints[k] - from.joints[k]).abs()),
        std::array::from_fn(|k| (to.table[k] - from.table[k]).abs()),
    )
}

fn between(from: &Posture, to: &Posture, t: f64) -> Posture {
    Posture {
        joints: std::array::from_fn(|k| from.joints[k] + (to.joints[k] - from.joints[k]) * t),
        table: std::array::from_fn(|k| from.table[k] + (to.table[k] - from.table[k]) * t),
    }
}
