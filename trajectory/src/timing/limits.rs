//! From limits to the layout of the grid and to the rows of the program.

use super::curve::{Curve, Grid, Knot, Segment, Warp};
use super::options::{FlowLimits, TimePathOptions};
use super::place::Place;
use super::program::Program;
use super::rows::Rows;
use crate::Bounds;

/// Where nothing limits the pace, it stays below this many times the largest that the whole path allows everywhere.
const UNLIMITED: f64 = 1e3;

/// A window is at least this share of the outermost piece: without limits of acceleration and jerk that is where the
/// motion gets up to its pace.
const MIN_WINDOW: f64 = 0.1;

/// A piece that takes this many times longer than speeds, feed and flow ask for is limited by accelerations or jerks.
const SLOWED: f64 = 1.1;

/// Knots are closer there, by this factor. Other factors have not been tried with the present corrections.
const FINER: f64 = 0.6;

/// A piece is calm if all rates are below this share of their limits at its largest pace, and so are those of so many pieces
/// on both sides: the pace is then the largest in the middle. More of either costs knots; less leaves too few where the pace
/// changes, and a second round has to add them.
const CALM: f64 = 0.5;
const CALM_AROUND: usize = 2;

/// Without a limit of jerk, an acceleration builds up in this share of the mean time of a piece, and a piece counts as at most one
/// of `MIN_PIECES` of the path. On random splines of four joints the timing takes 0.7 % longer than the fine sweep of the tests, 1.1 % at most;
/// with 0.25 it took 2.6 %, 4.2 % at most.
const BUILD_UP: f64 = 0.12;
const MIN_PIECES: f64 = 25.0;

/// So it does if the limit of jerk would build it up in less than this share of that: then knots could not be close enough.
const MIN_BUILD_UP: f64 = 0.5;

/// A path of few pieces may have so many segments.
const MIN_CELLS: usize = 400;

/// What is asked.
#[derive(Clone, Copy)]
pub(super) struct Task<'a, const N: usize> {
    pub planned: &'a [f64],
    pub max_pace: &'a [f64],
    pub flow: Option<FlowLimits<'a>>,
    pub bounds: &'a Bounds<N>,
    /// Limits of jerk of the program: those of the bounds, or smaller ones where these are too large for the grid.
    pub jerk: [f64; N],
    pub options: &'a TimePathOptions,
}

impl<'a, const N: usize> Task<'a, N> {
    pub fn new(
        planned: &'a [f64],
        max_pace: &'a [f64],
        flow: Option<FlowLimits<'a>>,
        bounds: &'a Bounds<N>,
        options: &'a TimePathOptions,
    ) -> Self {
        Task { planned, max_pace, flow, bounds, jerk: bounds.jerk, options }
    }

    /// The same without limits of jerk.
    pub fn without_jerk(&self) -> Self {
        Task { jerk: [f64::INFINITY; N], ..*self }
    }

    /// The same with limits of jerk that a grid can resolve, where those of the bounds let an acceleration build up in no time. A
    /// spline cannot follow that: it rings, and times are scaled for it.
    ///
    /// # Arguments
    /// * `duration`: about that of the path without limits of jerk, in seconds.
    pub fn resolved(&self, duration: f64) -> Self {
        let piece = duration / (self.planned.len() - 1) as f64;
        let build_up = BUILD_UP * piece.min(duration / MIN_PIECES);
        let mut jerk = self.bounds.jerk;
        for (jerk, acceleration) in jerk.iter_mut().zip(self.bounds.acceleration) {
            if acceleration / *jerk < MIN_BUILD_UP * build_up {
                *jerk = acceleration / build_up;
            }
        }
        Task { jerk, ..*self }
    }

    /// Segments of a piece at most.
    fn max_parts(&self) -> usize {
        TimePathOptions::MAX_SUBDIVISION.max(MIN_CELLS / (self.planned.len() - 1))
    }

    /// The pace that speeds, feed and flow allow on a piece, by its chord.
    fn quickest(&self, curve: &Curve<'_, N>, piece: usize) -> f64 {
        let mut pace = self.max_pace[piece];
        if let Some(flow) = self.flow {
            pace = pace.min(flow.max_flow_mm3_s / flow.flow_mm3_s[piece]);
        }
        let [_, slope, _] = curve.at(piece, 0.5 * (self.planned[piece + 1] - self.planned[piece]));
        slope.iter().zip(&self.bounds.velocity).fold(pace, |pace, (d, v)| pace.min(v / d.abs()))
    }

    /// Windows of both ends, and segments of each piece.
    pub fn layout(&self, curve: &Curve<'_, N>) -> (Warp, Vec<usize>) {
        let last = self.planned.len() - 1;
        let length = self.planned[last] - self.planned[0];
        let step_of = |piece: usize| self.planned[piece + 1] - self.planned[piece];
        let window = |piece: usize, along: f64| {
            let pace = self.quickest(curve, piece);
            let [_, slope, _] = curve.at(piece, along);
            let [_, middle, _] = curve.at(piece, 0.5 * step_of(piece));
            let mut longest = 0.0f64;
            for j in 0..N {
                let speed = pace * slope[j].abs().max(middle[j].abs());
                let (a, jerk) = (self.bounds.acceleration[j], self.jerk[j]);
                let time = if speed * jerk > a * a { speed / a + a / jerk } else { 2.0 * (speed / jerk).sqrt() };
                if time.is_finite() {
                    longest = longest.max(time);
                }
            }
            let covered = 0.5 * pace * longest;
            let least = MIN_WINDOW * step_of(piece);
            if covered.is_finite() { covered.max(least) } else { length }
        };
        let warp = Warp::new(length, [window(0, 0.0), window(last - 1, step_of(last - 1))]);
        let shortest = self.shortest();
        let most = self.max_parts();
        let is_calm: Vec<bool> = (0..last).map(|piece| self.is_calm(curve, piece)).collect();
        let around = |piece: usize| piece.saturating_sub(CALM_AROUND)..(piece + CALM_AROUND + 1).min(last);
        let parts = (0..last).map(|piece| {
            if is_calm[around(piece)].iter().all(|calm| *calm) {
                return 1;
            }
            let time = step_of(piece) / self.quickest(curve, piece);
            let wanted = (time / (self.options.step * shortest) - 1e-6).ceil();
            if wanted.is_nan() {
                self.options.subdivision
            } else {
                (wanted as usize).clamp(self.options.subdivision, most)
            }
        });
        (warp, parts.collect())
    }

    /// Whether a piece can be passed at its largest pace with all rates of the joints far below their limits. Where all
    /// pieces around can, the pace stays there, and the motion is the path's own spline without any knots between.
    fn is_calm(&self, curve: &Curve<'_, N>, piece: usize) -> bool {
        let (pace, step) = (self.max_pace[piece], self.planned[piece + 1] - self.planned[piece]);
        let ramps = self.flow.is_none_or(|flow| flow.flow_mm3_s[piece] * pace <= flow.max_flow_mm3_s);
        let (from, to) = (curve.at(piece, 0.0), curve.at(piece, step));
        let below = |j: usize| {
            let most = |order: usize| from[order][j].abs().max(to[order][j].abs());
            let third = (to[2][j] - from[2][j]).abs() / step;
            most(1) * pace <= CALM * self.bounds.velocity[j]
                && most(2) * pace * pace <= CALM * self.bounds.acceleration[j]
                && third * pace.powi(3) <= CALM * self.bounds.jerk[j]
        };
        pace.is_finite() && ramps && (0..N).all(below)
    }

    /// Segments of each piece, with more of them where a first program is slower than speeds, feed and flow ask for.
    pub fn refined(&self, curve: &Curve<'_, N>, parts: &[usize], grid: &Grid<N>, times: &[f64]) -> Vec<usize> {
        let shortest = self.shortest();
        let mut parts = parts.to_vec();
        for (piece, parts) in parts.iter_mut().enumerate() {
            let time = times[grid.postures[piece + 1]] - times[grid.postures[piece]];
            let free = (self.planned[piece + 1] - self.planned[piece]) / self.quickest(curve, piece);
            let wanted = (time / (FINER * self.options.step * shortest)).ceil();
            if time > SLOWED * free && wanted.is_finite() {
                *parts = (wanted as usize).clamp(*parts, self.max_parts().max(*parts));
            }
        }
        parts
    }

    /// The shortest time in which a limit of jerk reaches that of acceleration: so often limits take turns.
    fn shortest(&self) -> f64 {
        let mut shortest = f64::INFINITY;
        for j in 0..N {
            let time = self.bounds.acceleration[j] / self.jerk[j];
            if time > 0.0 {
                shortest = shortest.min(time);
            }
        }
        shortest
    }

    /// The program.
    pub fn program(&self, grid: &Grid<N>) -> Program<N> {
        let segments = grid.segments.len();
        let width = |segment: usize| grid.segments.get(segment).map_or(0.0, |segment| segment.width);
        let place = |knot: usize| {
            let behind = grid.segments.get(knot);
            Place {
                before: behind.map_or([0.0; N], |segment| segment.before),
                after: behind.map_or([0.0; N], |segment| segment.after),
                jump: grid.knots[knot].jump,
                widths: [knot.checked_sub(1).map_or(0.0, width), width(knot)],
            }
        };
        let places = (0..=segments).map(place).collect();
        let rows = Rows::new(places, [self.bounds.acceleration, self.jerk], self.ramps(grid));
        let widths = grid.segments.iter().map(|segment| segment.width).collect();
        self.started(grid, Program::new(widths, rows, segments - 1))
    }

    /// For each segment what the squared paces at its knots count in the rate of the flow, and its limit.
    fn ramps(&self, grid: &Grid<N>) -> (Vec<[f64; 2]>, f64) {
        let Some(flow) = self.flow.filter(|flow| flow.max_ramp_mm3_s2 < f64::INFINITY) else {
            return (Vec::new(), f64::INFINITY);
        };
        let ramp = |(segment, ends): (&Segment<N>, &[Knot<N>])| {
            let (from, to) = (ends[0].warp, ends[1].warp);
            // d(pace)/dt = (b' - b) / (2 ds), and ds is the mean of ds/dsigma times the width.
            let scale = flow.flow_mm3_s[segment.piece] / ((from + to) * segment.width);
            [-scale * from * from, scale * to * to]
        };
        (grid.segments.iter().zip(grid.knots.windows(2)).map(ramp).collect(), flow.max_ramp_mm3_s2)
    }

    /// The program at a start strictly within its limits: the same pace everywhere.
    fn started(&self, grid: &Grid<N>, mut program: Program<N>) -> Program<N> {
        let upper: Vec<f64> = (0..program.x.len()).map(|k| self.upper(grid, k + 1, 1.0)).collect();
        // The largest unknown that may be the same everywhere.
        let mut same = upper.iter().fold(f64::INFINITY, |least, upper| least.min(*upper));
        same = same.min(program.factor(0.0));
        if same == f64::INFINITY {
            same = 1.0;
        }
        let most = same * UNLIMITED * UNLIMITED;
        program.upper = upper.into_iter().map(|upper| upper.min(most)).collect();
        program.x.fill(0.5 * same);
        program.shrink(0.5);
        program.centre(1.0, true);
        program
    }

    /// The largest square of the pace at a knot; speeds count this much more than they are.
    pub fn upper(&self, grid: &Grid<N>, knot: usize, faster: f64) -> f64 {
        let at = &grid.knots[knot];
        let mut pace = f64::INFINITY;
        for segment in &grid.segments[knot - 1..=knot] {
            // At the knot and on average over the segment.
            let warp = at.warp.max(segment.warp);
            pace = pace.min(self.max_pace[segment.piece] / warp);
            if let Some(flow) = self.flow {
                pace = pace.min(flow.max_flow_mm3_s / (flow.flow_mm3_s[segment.piece] * warp));
            }
        }
        for j in 0..N {
            pace = pace.min(self.bounds.velocity[j] / (faster * at.slope[j].abs()));
        }
        pace * pace
    }
}
