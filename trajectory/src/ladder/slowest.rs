//! A lower bound on the joint speed needed by every motion through the waypoints at their times.
//!
//! A joint that goes from one waypoint to the next has, at some instant between them, the mean speed of that step,
//! whatever curve it takes. So a motion needs at least the greatest of its steps, and every motion at least the least
//! such greatest step over all chains of solutions: a bottleneck path. The range of the free parameter is cut into cells. All
//! solutions of a branch within a cell lie in a box of joints, and a step from cell to cell is at least as long as their boxes
//! are apart, so the bottleneck path over cells is a lower bound; over the middles of cells it is what can be had. Cells through
//! which no chain is below what can be had are dropped, the others halved, until the two meet.
//!
//! A box holds both ends of its cell and the bow between them that the derivatives at the ends predict, taken twice
//! ([`SAFETY`]). That is no proof: a robot is a closure, of which nothing is known between the places where it is
//! asked, and there is no interval arithmetic. What bends sharply between two ends that look smooth can be outside its
//! box. Finer cells make that less likely. Where a branch ends within a cell, or turns too fast for that, the cell counts as near
//! everything.

use super::error::LadderError;
use super::nodes::Kind;
use super::options::{LadderOptions, check};
use crate::angle::wrapped;
use crate::robot::{FreeRange, Robot};
use crate::{Bounds, Progress, ProgressFn};
use std::f64::consts::PI;
use std::ops::Range;

/// Cells of the whole range to begin with.
const FIRST: u32 = 64;

/// Both bounds as near as this are one.
const MET: f64 = 1e-3;

/// How much more than the derivatives at its ends predict a bow may be.
const SAFETY: f64 = 2.0;

/// A bow beyond this, in radians, gives no bound.
const WILD: f64 = 0.5;

/// Cells at all waypoints together; with more the bounds are returned as they are.
const MAX_CELLS: usize = 1 << 17;

/// How slow joints can be on a segment of a path; speeds are in shares of the speed limits.
#[derive(Clone, Debug, PartialEq)]
pub struct MinSpeed {
    /// Every motion has a joint that somewhere goes at this many times its speed limit: above 1 no motion keeps them. As
    /// sure as boxes made from derivatives are; see [`min_speed`].
    pub lower_bound: f64,
    /// What a chain of solutions needs for its mean speeds, whole turns between stops not counted; infinite where none
    /// was found. Over all waypoints asked for, or where `lower_bound` is above 1 over some about the segment below.
    pub reached: f64,
    /// Waypoints of a segment that needs `lower_bound` by itself.
    pub waypoints: Range<usize>,
}

/// Part of the range of the free parameter on one branch.
#[derive(Clone, Copy, Debug)]
struct Cell<const N: usize> {
    branch: u32,
    from: f64,
    /// Middle and half the size of the box; infinite where nothing is known.
    middle: [f64; N],
    half: [f64; N],
    /// The solution in the middle of the cell.
    there: Option<[f64; N]>,
    /// Greatest step of the best chain to here, over boxes and over solutions.
    least: f64,
    had: f64,
    /// `least` of the chain from the other end.
    back: f64,
}

/// A lower bound of the speeds that every motion through some waypoints needs, on all branches and from any start.
///
/// It answers why [`plan_ladder`](crate::plan_ladder) breaks off: a segment that needs more than the limits breaks off with
/// any number of samples.
///
/// The bound is not proved as interval arithmetic would prove it. How far joints go within a cell follows from their
/// derivatives at its ends, and twice that is allowed for. An inverse that bends sharply within a cell and is smooth at its ends
/// would go unseen.
///
/// # Arguments
/// * `times`: one a waypoint of the robot, rising, in seconds.
/// * `bounds`: velocities count, and positions where a joint has less than a turn.
/// * `waypoints`: the segment to look at; some dozens around a break.
/// * `samples`: the finest cells, of which so many make up the range: 4,096 for three digits.
/// # Returns
/// The bound and what can be had. They meet with ever finer cells, but where a branch ends or passes a singularity.
/// # Errors
/// [`LadderError`] as of the ladder; `Unreachable` where no cell of a waypoint has a solution.
/// # Cost
/// For `m` cells left at a waypoint `O(m^2)`, and two inverses a cell. The same input gives the same result.
/// # Example
/// ```
/// use curvlay_trajectory::{Bounds, FreeRange, Posture, RobotFn, min_speed};
/// use std::ops::ControlFlow;
/// // Two joints share what is asked of them, which rises by 0.3 rad and once by 0.5, in a tenth of a second.
/// let asked = |i: usize| if i < 4 { 0.3 * i as f64 } else { 0.3 * i as f64 + 0.2 };
/// let robot = RobotFn {
///     waypoints: 8,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, [asked(i) - free[0], free[0]]),
///     posture: |i: usize, free: &[f64; 1], _| {
///         Some(Posture { joints: [asked(i) - free[0], free[0]], rates: [[-1.0, 1.0]] })
///     },
/// };
/// let times: Vec<f64> = (0..8).map(|i| 0.1 * f64::from(i)).collect();
/// let bounds = Bounds { velocity: [2.0; 2], ..Bounds::NONE };
/// let found = min_speed(&robot, &times, &bounds, 0..8, 4096, &|_| ControlFlow::Continue(()))?;
/// // Half of 0.5 rad for each joint is 2.5 rad/s for 2.
/// assert!(found.lower_bound <= 1.25 && found.lower_bound > 1.24 && found.waypoints == (3..5));
/// assert!(found.reached >= 1.25 && found.reached < 1.26);
/// # Ok::<(), curvlay_trajectory::LadderError>(())
/// ```
pub fn min_speed<const N: usize, R: Robot<N, 1> + ?Sized>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    waypoints: Range<usize>,
    samples: u32,
    progress: ProgressFn<'_>,
) -> Result<MinSpeed, LadderError> {
    check(robot.waypoints(), times, bounds, &LadderOptions { samples: [samples], ..LadderOptions::default() })?;
    if waypoints.end > times.len() || waypoints.is_empty() {
        let what = "the segment must have waypoints of the path; its end";
        return Err(LadderError::Option { what, value: waypoints.end as f64 });
    }
    let (start, length) = match robot.free()[0] {
        FreeRange::Turn => (-PI, 2.0 * PI),
        FreeRange::Within(from, to) => (from, to - from),
    };
    let kinds = Kind::of(bounds, &[false; N]);
    let cut = Cut { robot: &robot, kinds, velocity: bounds.velocity };
    let mut count = FIRST.min(samples);
    let mut segment = Segment {
        times: &times[waypoints.clone()],
        columns: cut.columns(waypoints.clone(), start, length / f64::from(count), count)?,
        first: waypoints.start,
    };
    let mut found = MinSpeed { lower_bound: 0.0, reached: f64::INFINITY, waypoints };
    loop {
        let step = Progress { stage: "least speed", done: u64::from(count), total: u64::from(samples) };
        if progress(step).is_break() {
            return Err(LadderError::Cancelled);
        }
        segment.bound(&cut, &mut found);
        count = count.saturating_mul(2);
        for cells in &mut segment.columns {
            cells.retain(|cell| cell.back.max(cell.least) <= found.reached);
        }
        let left: usize = segment.columns.iter().map(Vec::len).sum();
        if count > samples || found.reached - found.lower_bound < MET || 2 * left > MAX_CELLS {
            return Ok(found);
        }
        segment.halve(&cut, length / f64::from(count));
    }
}

/// The segment that is looked at, with the cells of its waypoints that are left.
struct Segment<'a, const N: usize> {
    /// The number of its first waypoint.
    first: usize,
    times: &'a [f64],
    columns: Vec<Vec<Cell<N>>>,
}

impl<const N: usize> Segment<'_, N> {
    /// Bounds the speed from below and above. Where the bound is above the limits already, only the bottleneck is left to look at.
    fn bound(&mut self, cut: &Cut<'_, N>, found: &mut MinSpeed) {
        cut.propagate(&mut self.columns, self.times, found.reached, true);
        self.columns.iter_mut().flatten().for_each(|cell| cell.back = cell.least);
        let ahead = cut.propagate(&mut self.columns, self.times, found.reached, false);
        found.lower_bound = found.lower_bound.max(ahead.0);
        found.reached = ahead.1;
        let narrow = self.bottleneck(found.lower_bound * (1.0 - 1e-9));
        found.waypoints = self.first + narrow.start..self.first + narrow.end;
        if found.lower_bound > 1.0 {
            // The speed limits do not hold on this segment; the rest only takes time.
            self.columns = self.columns.drain(narrow.clone()).collect();
            self.times = &self.times[narrow.clone()];
            self.first += narrow.start;
        }
    }

    /// From the last waypoint from which, to the first one to which every chain needs as much.
    fn bottleneck(&self, needed: f64) -> Range<usize> {
        let columns = &self.columns;
        let from = columns.iter().rposition(|cells| cells.iter().all(|cell| cell.back >= needed)).unwrap_or(0);
        let to = columns.iter().position(|cells| cells.iter().all(|cell| cell.least >= needed));
        let to = to.unwrap_or(columns.len() - 1);
        // Two bottlenecks as narrow as each other: both are kept.
        if from < to { from..to + 1 } else { 0..columns.len() }
    }

    /// Halves all cells; `width` is that of a half.
    fn halve(&mut self, cut: &Cut<'_, N>, width: f64) {
        for (waypoint, cells) in (self.first..).zip(&mut self.columns) {
            let halves = |cell: &Cell<N>| [0.0, 1.0].map(|second| (cell.branch, cell.from + second * width));
            let parts: Vec<(u32, f64)> = cells.iter().flat_map(halves).collect();
            let cells_now = parts.into_iter().filter_map(|(branch, from)| cut.cell(waypoint, branch, from, width));
            *cells = cells_now.collect();
        }
    }
}

/// What stays while cells are halved.
struct Cut<'a, const N: usize> {
    robot: &'a dyn Robot<N, 1>,
    kinds: [Kind; N],
    velocity: [f64; N],
}

impl<const N: usize> Cut<'_, N> {
    /// The cells of waypoints, `count` of them a range.
    fn columns(
        &self,
        waypoints: Range<usize>,
        start: f64,
        width: f64,
        count: u32,
    ) -> Result<Vec<Vec<Cell<N>>>, LadderError> {
        let of = |waypoint| match self.all(waypoint, start, width, count) {
            cells if cells.is_empty() => Err(LadderError::Unreachable { waypoint, samples: u64::from(count) }),
            cells => Ok(cells),
        };
        waypoints.map(of).collect()
    }

    /// The cells of a waypoint on all branches.
    fn all(&self, waypoint: usize, start: f64, width: f64, count: u32) -> Vec<Cell<N>> {
        let mut branches = Vec::new();
        for at in 0..=2 * count {
            self.robot.solutions(waypoint, &[start + 0.5 * width * f64::from(at)], &mut |branch, _| {
                if !branches.contains(&branch) {
                    branches.push(branch);
                }
            });
        }
        let cells = |&branch: &u32| {
            (0..count).filter_map(move |at| self.cell(waypoint, branch, start + width * f64::from(at), width))
        };
        branches.iter().flat_map(cells).collect()
    }

    /// A cell; `None` if the branch has no solution at its ends and middle, or none between stops.
    fn cell(&self, waypoint: usize, branch: u32, from: f64, width: f64) -> Option<Cell<N>> {
        let at = |share: f64| self.robot.posture(waypoint, &[from + share * width], branch);
        let (first, there, last) = (at(0.0), at(0.5), at(1.0));
        let known = [&first, &there, &last].into_iter().flatten().next()?;
        let mut cell = Cell {
            branch,
            from,
            middle: known.joints,
            half: [f64::INFINITY; N],
            there: there.as_ref().map(|posture| posture.joints),
            least: 0.0,
            had: 0.0,
            back: 0.0,
        };
        let (Some(first), Some(last)) = (first, last) else { return Some(cell) };
        for j in 0..N {
            let chord = self.apart(j, last.joints[j] - first.joints[j]);
            // A parabola with these derivatives at its ends bows by an eighth of their difference; what they and the
            // chord do not agree on comes on top.
            let (begins, ends) = (width * first.rates[0][j], width * last.rates[0][j]);
            let bow = SAFETY * ((ends - begins).abs() / 8.0 + (chord - 0.5 * (begins + ends)).abs());
            if bow < WILD {
                cell.middle[j] = first.joints[j] + 0.5 * chord;
                cell.half[j] = 0.5 * chord.abs() + bow;
            }
        }
        let out = (0..N).any(|j| match self.kinds[j] {
            Kind::Single { lower, upper } => {
                cell.middle[j] + cell.half[j] < lower || cell.middle[j] - cell.half[j] > upper
            }
            _ => false,
        });
        (!out).then_some(cell)
    }

    /// The way from one angle to another: the short one where a joint can turn at least once.
    fn apart(&self, joint: usize, way: f64) -> f64 {
        if self.kinds[joint] == Kind::Circular { wrapped(way) } else { way }
    }

    /// The greatest step of the best chain from the first waypoint (or the last, backwards) to each cell; returns the least of
    /// the waypoint where they end, over boxes and over solutions.
    ///
    /// `most`: chains above it need not be distinguished.
    fn propagate(&self, columns: &mut [Vec<Cell<N>>], times: &[f64], most: f64, backwards: bool) -> (f64, f64) {
        let count = columns.len();
        let order = |k: usize| if backwards { count - 1 - k } else { k };
        for cell in &mut columns[order(0)] {
            (cell.least, cell.had) = (0.0, if cell.there.is_some() { 0.0 } else { f64::INFINITY });
        }
        for k in 1..count {
            let (here, before) = (order(k), order(k - 1));
            let limits = self.velocity.map(|velocity| velocity * (times[here] - times[before]).abs());
            let near = Near::new(&mut columns[before], &self.kinds, &limits, most);
            let mut cells = std::mem::take(&mut columns[here]);
            for cell in &mut cells {
                (cell.least, cell.had) = (f64::INFINITY, f64::INFINITY);
                let middle = wrapped_if(self.kinds[near.joint], cell.middle[near.joint]);
                let half = cell.half[near.joint];
                for other in near.of(middle, half, &columns[before]) {
                    if other.least < cell.least {
                        cell.least = cell.least.min(other.least.max(self.step(cell, other, &limits)));
                    }
                    if let (Some(a), Some(b)) = (&cell.there, &other.there)
                        && other.had < cell.had
                    {
                        let share = |j: usize| self.apart(j, a[j] - b[j]).abs() / limits[j];
                        cell.had = cell.had.min((0..N).map(share).fold(other.had, f64::max));
                    }
                }
            }
            columns[here] = cells;
        }
        let least =
            |value: fn(&Cell<N>) -> f64| columns[order(count - 1)].iter().map(value).fold(f64::INFINITY, f64::min);
        (least(|cell| cell.least), least(|cell| cell.had))
    }

    /// How far the boxes of two cells are apart, in shares of the limits.
    fn step(&self, a: &Cell<N>, b: &Cell<N>, limits: &[f64; N]) -> f64 {
        let share = |j: usize| (self.apart(j, a.middle[j] - b.middle[j]).abs() - a.half[j] - b.half[j]) / limits[j];
        (0..N).map(share).fold(0.0, f64::max)
    }
}

/// Cells in the order of one joint, so that those in reach stand together; cells without a box stand first.
struct Near {
    joint: usize,
    circular: bool,
    wild: usize,
    middles: Vec<f64>,
    reach: f64,
}

impl Near {
    /// Sorts the cells by the joint that spreads farthest, in steps of it.
    fn new<const N: usize>(cells: &mut [Cell<N>], kinds: &[Kind; N], limits: &[f64; N], most: f64) -> Self {
        let spread = |j: usize| {
            let middles = || cells.iter().map(|cell| wrapped_if(kinds[j], cell.middle[j]));
            let (low, high) = middles().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), m| (a.min(m), b.max(m)));
            (high - low) / limits[j]
        };
        let spreads: [f64; N] = std::array::from_fn(spread);
        let joint = (0..N).max_by(|&a, &b| spreads[a].total_cmp(&spreads[b])).unwrap_or(0);
        let key = |cell: &Cell<N>| {
            if cell.half[joint].is_finite() { wrapped_if(kinds[joint], cell.middle[joint]) } else { f64::NEG_INFINITY }
        };
        cells.sort_by(|a, b| key(a).total_cmp(&key(b)));
        let middles: Vec<f64> = cells.iter().map(key).collect();
        let wild = middles.partition_point(|middle| *middle == f64::NEG_INFINITY);
        let widest = cells[wild..].iter().map(|cell| cell.half[joint]).fold(0.0, f64::max);
        let reach = widest + most * limits[joint] * (1.0 + 1e-9);
        Near { joint, circular: kinds[joint] == Kind::Circular, wild, middles, reach }
    }

    /// The cells that may be no farther than `most` from a cell with this middle and half.
    fn of<'a, const N: usize>(
        &self,
        middle: f64,
        half: f64,
        cells: &'a [Cell<N>],
    ) -> impl Iterator<Item = &'a Cell<N>> {
        let reach = self.reach + half;
        let range = |turn: f64| {
            let from = self.middles.partition_point(|m| *m < middle + turn - reach).max(self.wild);
            from..self.middles.partition_point(|m| *m <= middle + turn + reach).max(from)
        };
        let turn = if self.circular { 2.0 * PI } else { f64::INFINITY };
        let ranges = if reach < PI {
            [0..self.wild, range(-turn), range(0.0), range(turn)]
        } else {
            [0..cells.len(), 0..0, 0..0, 0..0]
        };
        ranges.into_iter().flat_map(move |range| &cells[range])
    }
}

/// The image of an angle by which it is sorted.
fn wrapped_if(kind: Kind, angle: f64) -> f64 {
    if kind == Kind::Circular { wrapped(angle) } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::{Posture, RobotFn};

    /// Two links that hold a tip, and a third that turns about it: closed form, two branches, an edge of reach.
    fn planar(free: f64, branch: u32) -> Option<Posture<3, 1>> {
        let (x, y) = (1.2 - 0.6 * free.cos(), 0.9 - 0.6 * free.sin());
        let cos = (x * x + y * y - 1.64) / 1.6;
        let side = if branch == 0 { 1.0 } else { -1.0 };
        let (sin, along) = (side * (1.0 - cos * cos).max(0.0).sqrt(), [0.6 * free.sin(), -0.6 * free.cos()]);
        let q2 = sin.atan2(cos);
        let q1 = y.atan2(x) - (0.8 * sin).atan2(1.0 + 0.8 * cos);
        // Derivatives from the Jacobian of the two links.
        let (a, b) = ([-y, x], [-0.8 * (q1 + q2).sin(), 0.8 * (q1 + q2).cos()]);
        let size = a[0] * b[1] - a[1] * b[0];
        let rate = [(along[0] * b[1] - along[1] * b[0]) / size, (a[0] * along[1] - a[1] * along[0]) / size];
        let joints = [wrapped(q1), q2, wrapped(free - q1 - q2)];
        (cos.abs() < 1.0).then_some(Posture { joints, rates: [[rate[0], rate[1], 1.0 - rate[0] - rate[1]]] })
    }

    #[test]
    fn boxes_hold_all_of_their_cells() {
        let robot = RobotFn {
            waypoints: 1,
            free: [FreeRange::Turn],
            solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 3])| {
                (0..2).for_each(|branch| planar(free[0], branch).iter().for_each(|p| each(branch, p.joints)));
            },
            posture: |_: usize, free: &[f64; 1], branch: u32| planar(free[0], branch),
        };
        let cut = Cut { robot: &robot, kinds: [Kind::Circular; 3], velocity: [1.0; 3] };
        let (mut tame, mut wild, mut loose) = (0, 0, 0);
        for count in [64, 256, 1024] {
            let width = 2.0 * PI / f64::from(count);
            for cell in cut.all(0, -PI, width, count) {
                let fits = |posture: &Posture<3, 1>| {
                    (0..3).all(|j| wrapped(posture.joints[j] - cell.middle[j]).abs() <= cell.half[j] + 1e-12)
                };
                let known = cell.half.iter().all(|half| half.is_finite());
                (tame, wild) = (tame + usize::from(known), wild + usize::from(!known));
                for part in 0..=64 {
                    let there = planar(cell.from + width * f64::from(part) / 64.0, cell.branch);
                    assert!(there.iter().all(fits), "{cell:?} {there:?}");
                }
                let way = |p: Posture<3, 1>| p.rates[0].map(|rate| 0.5 * width * rate.abs());
                let least = planar(cell.from + 0.5 * width, cell.branch).map_or([0.0; 3], way);
                loose += usize::from(known && (0..3).any(|j| cell.half[j] > 1.2 * least[j] + 0.1 * width));
            }
        }
        // Nor are they large to be right: but for bends, half the way through the cell.
        assert!(10 * loose < tame, "{loose} {tame}");
        // The branches end at the edge of reach, twice each.
        assert!(tame > 1000 && (2..40).contains(&wild), "{tame} {wild}");
    }

    #[test]
    fn near_cells_are_all_that_may_be_in_reach_and_few_others() {
        let mut random = Random::new(11);
        let kinds = [Kind::Circular, Kind::AsGiven];
        // The last of these reaches all round.
        for (limits, most, spread) in [
            ([0.3, 0.2], 1.5, 1),
            ([0.02, 0.05], 3.0, 0),
            ([4.0, 3.0], 0.1, 1),
            ([1.0, 3.0], 0.4, 0),
            ([2.0, 4.0], 4.0, 0),
        ] {
            let mut cells: Vec<Cell<2>> = (0..120)
                .map(|at| Cell {
                    branch: 0,
                    from: f64::from(at),
                    middle: [random.within(-9.0, 9.0), random.within(-5.0, 5.0)],
                    half: if at % 20 == 7 { [f64::INFINITY; 2] } else { [random.within(0.0, 0.1); 2] },
                    there: None,
                    least: 0.0,
                    had: 0.0,
                    back: 0.0,
                })
                .collect();
            let near = Near::new(&mut cells, &kinds, &limits, most);
            let joint = near.joint;
            assert_eq!(joint, spread, "{limits:?}");
            let way = most * limits[joint];
            for cell in cells.iter().filter(|cell| cell.half[joint].is_finite()) {
                let middle = wrapped_if(kinds[joint], cell.middle[joint]);
                let found: Vec<f64> = near.of(middle, cell.half[joint], &cells).map(|cell| cell.from).collect();
                for other in &cells {
                    let by = wrapped_if(kinds[joint], other.middle[joint] - cell.middle[joint]);
                    let gap = by.abs() - cell.half[joint];
                    let times = found.iter().filter(|&&from| from.to_bits() == other.from.to_bits()).count();
                    if !other.half[joint].is_finite() || gap - other.half[joint] <= way {
                        assert_eq!(times, 1, "{limits:?} {cell:?} {other:?}");
                    } else if way < 2.9 && gap > way + 0.1 {
                        assert_eq!(times, 0, "{limits:?} {cell:?} {other:?}");
                    }
                }
                assert!(found.len() <= cells.len());
            }
        }
    }
}
