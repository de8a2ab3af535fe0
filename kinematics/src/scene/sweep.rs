//! Is a whole motion free? A proof by bisection.
//!
//! All joints go evenly from one posture to another; `t` runs from 0 to 1. Against body A no point of body B moves by
//! more than `s |t - t'|` between `t` and `t'`, where `s` sums, over the joints between the two, how far the joint turns
//! times how far any point of the body can ever be from its axis (see `chain`). So a pair that is apart by more than
//! `margin + s h` at the middle of an interval of half-width `h` is farther apart than the margin in all of it.
//! Intervals for which some pair lacks that are halved, the earlier half first, with the pairs that lack it. With `s h`
//! below the resolution a pair lacks it only if it comes within margin + resolution at that very middle: there the sweep
//! ends, and all before the interval has been proven free.
//!
//! The bound is that of conservative advancement (B. Mirtich, *Impulse-based dynamic simulation of rigid body
//! systems*, PhD thesis, Berkeley 1996, section 2.3), but a distance at the middle of an interval proves twice as much as
//! one at its end, and pairs far apart leave after one look.

use super::Scene;
use super::pairs::Apart;
use super::query::{Posture, PostureError};

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

/// A pair, and how far it moves against each other at most.
#[derive(Clone, Copy, Debug)]
struct Moving {
    pair: [usize; 2],
    travel: f64,
}

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
        let moving = |&pair: &[usize; 2]| Moving { pair, travel: self.travel(pair, &turns) };
        let mut open: Vec<Moving> = self.pairs.iter().map(moving).collect();
        // Intervals still to be shown free, the earliest last: middle, half-width, and which of the open pairs.
        let mut stack = vec![(0.5, 0.5, 0..open.len())];
        while let Some((middle, half, range)) = stack.pop() {
            // Pairs listed behind those of this interval belonged to earlier ones, which are done.
            open.truncate(range.end);
            let poses = self.poses(&between(from, to, middle));
            let lacking = open.len();
            for k in range {
                let Moving { pair, travel } = open[k];
                let reach = travel * half;
                if self.pair_apart(&poses, &pair, self.margin + reach) {
                    continue;
                }
                if reach <= resolution {
                    return Ok(Sweep::Near { bodies: self.names_of(&pair), at: middle, free_until: middle - half });
                }
                open.push(open[k]);
            }
            if open.len() > lacking {
                let quarter = 0.5 * half;
                stack.push((middle + quarter, quarter, lacking..open.len()));
                stack.push((middle - quarter, quarter, lacking..open.len()));
            }
        }
        Ok(Sweep::Free)
    }

    /// How far points of the two bodies move against each other at most, for these turns of the joints.
    fn travel(&self, [a, b]: [usize; 2], (arm, table): &([f64; 6], [f64; 2])) -> f64 {
        let Some(([inner, outer], apart)) = self.relation(a, b) else { return 0.0 };
        let sum = |body: usize, turns: &[f64], from: usize| -> f64 {
            self.bodies[body].swings.iter().zip(turns).skip(from).map(|(swing, turn)| swing * turn).sum()
        };
        let of = |body: usize, from: usize, on_table: bool| {
            if on_table { sum(body, table, from) } else { sum(body, arm, from) }
        };
        let travel = match apart {
            Apart::Behind { table, from, .. } => of(outer, from, table),
            Apart::Both => {
                let on_table = |body: usize| self.on_table(body);
                of(inner, 0, on_table(inner)) + of(outer, 0, on_table(outer))
            }
        };
        travel * (1.0 + ROUNDING)
    }
}

/// Sums of products are less wrong than this.
const ROUNDING: f64 = 1e-12;

fn turns(from: &Posture, to: &Posture) -> ([f64; 6], [f64; 2]) {
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
