//! The best chain of samples, one a waypoint: dynamic programming over pairs.
//!
//! What makes bounds hold on a spline is the differences of joints over one and two steps: mean speeds are at most the
//! greatest speed, and `2 (v' - v) / (h + h')` is a mean of the acceleration. So a state is a pair of samples at
//! neighbouring waypoints (R. Bellman, *Dynamic Programming*, 1957). What costs more than a chain that is known is left
//! out, and of the pairs before a pair only those are looked at whose speed is near enough: a bend has its price.

use crate::Bounds;
use crate::angle::short_way;

/// The tool turns no faster than this, in radians a second: half a turn takes one. Joints are often faster, but who turns
/// faster has no smooth way in mind, and pairs of samples grow with it.
const MAX_TURN_SPEED: f64 = 3.0;

/// Steps faster than this many times the bound are no part of a chain.
const MAX_SPEED_RATIO: f64 = 1.2;

/// Shares of the bounds on speed and acceleration up to which nothing is paid: the spline goes beyond the means of its
/// pieces.
const FREE_SHARE: f64 = 0.8;

/// What a squared share beyond that costs, in units of the squared bound on acceleration.
const EXCESS_WEIGHT: f64 = 1e3;

/// Chains up to this share dearer than a known one are looked at, since it is one of them.
const COST_TOLERANCE: f64 = 1e-9;

/// A sample at a waypoint.
pub(super) struct Node<const N: usize, const F: usize> {
    pub free: [f64; F],
    pub joints: [f64; N],
    /// Whether it is where the path is now.
    pub present: bool,
}

/// A pair of samples at a waypoint and the one before.
struct Pair<const N: usize> {
    /// The later sample.
    to: usize,
    velocity: [f64; N],
    cost: f64,
    /// The pair before, in the list of the waypoint before.
    back: usize,
}

/// What counts about the differences of joints.
pub(super) struct Price<'a, const N: usize> {
    bounds: &'a Bounds<N>,
    /// The squared bound on acceleration; without one there is still a measure of it.
    unit: f64,
}

impl<'a, const N: usize> Price<'a, N> {
    pub fn new(bounds: &'a Bounds<N>) -> Self {
        let unit = bounds.acceleration.iter().copied().filter(|a| a.is_finite()).fold(1.0, f64::max).powi(2);
        Price { bounds, unit }
    }

    fn beyond(&self, share: f64) -> f64 {
        EXCESS_WEIGHT * self.unit * (share.abs() - FREE_SHARE).max(0.0).powi(2)
    }

    /// The mean speeds of a step and their price; `None` if it is too fast.
    fn step(&self, from: &[f64; N], to: &[f64; N], time: f64) -> Option<([f64; N], f64)> {
        let fast = |j: usize| short_way(to[j] - from[j]).abs() > MAX_SPEED_RATIO * self.bounds.velocity[j] * time;
        if (0..N).any(fast) {
            return None;
        }
        let velocity: [f64; N] = std::array::from_fn(|j| short_way(to[j] - from[j]) / time);
        Some((velocity, (0..N).map(|j| self.beyond(velocity[j] / self.bounds.velocity[j])).sum()))
    }

    /// `so_far` and the price of a change of speed within this time; the sum breaks off at `most`.
    fn bend(&self, so_far: f64, before: &[f64; N], after: &[f64; N], time: f64, most: f64) -> f64 {
        let mut sum = so_far;
        for ((now, then), bound) in after.iter().zip(before).zip(&self.bounds.acceleration) {
            if sum >= most {
                break;
            }
            let acceleration = (now - then) / time;
            sum += acceleration * acceleration + self.beyond(acceleration / bound);
        }
        sum
    }

    /// The greatest acceleration of a joint that costs no more than `most`.
    fn reach(&self, joint: usize, most: f64) -> f64 {
        let most = most.max(0.0) * (1.0 + COST_TOLERANCE);
        most.sqrt().min(self.bounds.acceleration[joint] * (FREE_SHARE + (most / (EXCESS_WEIGHT * self.unit)).sqrt()))
    }

    /// The price of a chain; infinite if it is too fast.
    pub fn chain(&self, joints: &[[f64; N]], times: &[f64]) -> f64 {
        let mut sum = 0.0;
        let mut before: Option<[f64; N]> = None;
        for at in 1..joints.len() {
            let Some((velocity, own)) = self.step(&joints[at - 1], &joints[at], times[at] - times[at - 1]) else {
                return f64::INFINITY;
            };
            if let Some(before) = before {
                sum = self.bend(sum, &before, &velocity, 0.5 * (times[at] - times[at - 2]), f64::INFINITY);
            }
            sum += own;
            before = Some(velocity);
        }
        sum
    }
}

/// The pairs that end at a sample.
#[derive(Default)]
struct Arrivals<const N: usize> {
    /// By the speed of the joint that separates them best.
    pairs: Vec<usize>,
    by: usize,
    /// Their least cost.
    least: f64,
}

impl<const N: usize> Arrivals<N> {
    fn sort(&mut self, all: &[Pair<N>], bounds: &Bounds<N>) {
        let spread = |j: usize| {
            let speeds = self.pairs.iter().map(|&index| all[index].velocity[j]);
            let (low, high) =
                speeds.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
            (high - low) / bounds.acceleration[j]
        };
        self.by = (0..N).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
        self.pairs.sort_by(|&a, &b| all[a].velocity[self.by].total_cmp(&all[b].velocity[self.by]));
        self.least = self.pairs.iter().map(|&index| all[index].cost).fold(f64::INFINITY, f64::min);
    }

    /// Those whose speed is this far from another one at most.
    fn near(&self, all: &[Pair<N>], speed: f64, reach: f64) -> impl Iterator<Item = usize> {
        let first = self.pairs.partition_point(|&index| all[index].velocity[self.by] < speed - reach);
        self.pairs[first..].iter().copied().take_while(move |&index| all[index].velocity[self.by] <= speed + reach)
    }
}

/// One sample a waypoint, so that speeds and accelerations are least beyond their limits, and then accelerations; among
/// chains that cost no more than `most`.
pub(super) fn best_chain<const N: usize, const F: usize>(
    nodes: &[Vec<Node<N, F>>],
    times: &[f64],
    angle: usize,
    price: &Price<'_, N>,
    most: f64,
) -> Option<Vec<[f64; F]>> {
    let most = most * (1.0 + COST_TOLERANCE);
    let mut lists: Vec<Vec<Pair<N>>> = Vec::with_capacity(nodes.len());
    for at in 1..nodes.len() {
        let before = lists.last().map_or(&[][..], Vec::as_slice);
        let stage = Stage {
            price,
            angle,
            most,
            step: times[at] - times[at - 1],
            halves: times.get(at.wrapping_sub(2)).map(|before| 0.5 * (times[at] - before)),
            before,
        };
        lists.push(stage.pairs(&nodes[at - 1], &nodes[at]));
    }
    trace(nodes, &lists)
}

/// A waypoint and the one before it, between which pairs of samples are found.
struct Stage<'a, const N: usize> {
    price: &'a Price<'a, N>,
    /// Which of the free parameters is the angle of the tool.
    angle: usize,
    /// What a chain may cost.
    most: f64,
    /// Seconds from the waypoint before.
    step: f64,
    /// Half the seconds from the one before that, if there is one.
    halves: Option<f64>,
    /// The pairs of the waypoint before.
    before: &'a [Pair<N>],
}

impl<const N: usize> Stage<'_, N> {
    /// The pairs from samples of the waypoint before to those of this one that a chain within the cost can have, each with the best pair before it.
    fn pairs<const F: usize>(&self, from: &[Node<N, F>], to: &[Node<N, F>]) -> Vec<Pair<N>> {
        let mut into: Vec<Arrivals<N>> = from.iter().map(|_| Arrivals::default()).collect();
        self.before.iter().enumerate().for_each(|(index, pair)| into[pair.to].pairs.push(index));
        into.iter_mut().for_each(|arrivals| arrivals.sort(self.before, self.price.bounds));
        let mut pairs = Vec::new();
        for (a, arrivals) in from.iter().zip(&into) {
            if self.halves.is_some() && arrivals.pairs.is_empty() {
                continue;
            }
            // The best pair before, for the sample before.
            let mut like = None;
            for (to, b) in to.iter().enumerate() {
                if short_way(b.free[self.angle] - a.free[self.angle]).abs() > MAX_TURN_SPEED * self.step {
                    continue;
                }
                let Some((velocity, own)) = self.price.step(&a.joints, &b.joints, self.step) else { continue };
                let (cost, back) = match self.halves {
                    Some(halves) => {
                        let (cost, back) = self.cheapest(arrivals, &velocity, halves, like);
                        like = (cost < f64::INFINITY).then_some(back);
                        (cost, back)
                    }
                    None => (0.0, 0),
                };
                if cost + own <= self.most {
                    pairs.push(Pair { to, velocity, cost: cost + own, back });
                }
            }
        }
        pairs
    }

    /// The cheapest pair to arrive by, for a velocity behind it. The one that was cheapest for a like velocity, `like`, gives a cost beyond
    /// which none has to be looked at.
    fn cheapest(&self, arrivals: &Arrivals<N>, velocity: &[f64; N], halves: f64, like: Option<usize>) -> (f64, usize) {
        let (mut cost, mut back) = (f64::INFINITY, 0);
        let mut look = |index: usize| {
            let Pair { cost: sum, velocity: arriving, .. } = &self.before[index];
            let sum = self.price.bend(*sum, arriving, velocity, halves, cost);
            if sum < cost {
                (cost, back) = (sum, index);
            }
            cost
        };
        let known = like.map_or(self.most, |like| look(like).min(self.most));
        let reach = halves * self.price.reach(arrivals.by, known - arrivals.least);
        for index in arrivals.near(self.before, velocity[arrivals.by], reach) {
            look(index);
        }
        (cost, back)
    }
}

/// Goes back from the cheapest of the last pairs.
fn trace<const N: usize, const F: usize>(nodes: &[Vec<Node<N, F>>], lists: &[Vec<Pair<N>>]) -> Option<Vec<[f64; F]>> {
    let mut at = lists.len();
    let last = lists.last()?.iter().enumerate().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    let mut index = last.0;
    let mut chain = Vec::with_capacity(nodes.len());
    while at > 0 {
        let pair = &lists[at - 1][index];
        chain.push(nodes[at][pair.to].free);
        (index, at) = (pair.back, at - 1);
    }
    // The first sample is the only one of its waypoint.
    chain.push(nodes.first()?.first()?.free);
    chain.reverse();
    Some(chain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn no_chain_of_all_is_better() {
        let bounds = Bounds { velocity: [2.0, 3.0], acceleration: [8.0, 5.0], ..Bounds::NONE };
        let price = Price::new(&bounds);
        let mut rng = Pcg64::seed_from_u64(5);
        let (mut found_some, mut below_a_thousand) = (0, 0);
        for _ in 0..60 {
            let node = |rng: &mut Pcg64| Node {
                free: [rng.random_range(-1.0..1.0)],
                joints: [0; 2].map(|_| rng.random_range(-0.4..0.4)),
                present: false,
            };
            let count = |at: usize| if (2..5).contains(&at) { 7 } else { 1 };
            let nodes: Vec<Vec<_>> = (0..7).map(|at| (0..count(at)).map(|_| node(&mut rng)).collect()).collect();
            let times: Vec<f64> = (0..7).map(|at| 0.3 * f64::from(at) + rng.random_range(0.0..0.05)).collect();
            let slow =
                |a: &Node<2, 1>, b: &Node<2, 1>, time: f64| (b.free[0] - a.free[0]).abs() <= MAX_TURN_SPEED * time;
            // All of them, one after the other.
            let mut least = f64::INFINITY;
            let mut costs = Vec::new();
            for number in 0..7usize.pow(3) {
                let index = |at: usize| if (2..5).contains(&at) { number / 7usize.pow(at as u32 - 2) % 7 } else { 0 };
                let chain: Vec<&Node<2, 1>> = (0..7).map(|at| &nodes[at][index(at)]).collect();
                let joints: Vec<[f64; 2]> = chain.iter().map(|node| node.joints).collect();
                if (1..7).all(|at| slow(chain[at - 1], chain[at], times[at] - times[at - 1])) {
                    costs.push(price.chain(&joints, &times));
                    least = least.min(costs[costs.len() - 1]);
                }
            }
            // Whatever chain is known, and without any.
            for known in costs.iter().copied().filter(|cost| cost.is_finite()).take(5).chain([f64::INFINITY]) {
                let found = best_chain(&nodes, &times, 0, &price, known);
                assert_eq!(found.is_some(), least < f64::INFINITY);
                let Some(found) = found else { continue };
                found_some += 1;
                let at = |(nodes, free): (&Vec<Node<2, 1>>, &[f64; 1])| {
                    nodes.iter().find(|node| node.free[0].to_bits() == free[0].to_bits()).unwrap().joints
                };
                let joints: Vec<[f64; 2]> = nodes.iter().zip(&found).map(at).collect();
                let cost = price.chain(&joints, &times);
                assert!((cost - least).abs() <= 1e-9 * least, "{cost} {least}");
            }
            // None costs less than the best.
            assert!(best_chain(&nodes, &times, 0, &price, 0.999 * least.min(1e9)).is_none(), "{least}");
            below_a_thousand += usize::from(least < 1e3);
        }
        assert!(found_some > 100 && below_a_thousand > 10, "{found_some} {below_a_thousand}");
    }

    #[test]
    fn prices_are_those_by_hand() {
        let bounds = Bounds { velocity: [2.0, 4.0], acceleration: [8.0, 4.0], ..Bounds::NONE };
        let price = Price::new(&bounds);
        let is = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9 * expected, "{value} {expected}");
        // Up to four fifths of the speed nothing is paid, at nine tenths a hundredth of 1,000 times 8 squared.
        assert_eq!(price.step(&[0.0, 1.0], &[0.75, 0.5], 0.5), Some(([1.5, -1.0], 0.0)));
        let (velocity, own) = price.step(&[0.0, 1.0], &[0.9, 0.5], 0.5).unwrap();
        is(velocity[0], 1.8);
        is(-velocity[1], 1.0);
        is(own, 640.0);
        assert!(price.step(&[0.0, 0.0], &[1.19, 0.0], 0.5).is_some());
        assert_eq!(price.step(&[0.0, 0.0], &[1.21, 0.0], 0.5), None);
        // Squared accelerations, 2 and 3.6, and the same for nine tenths of the bound; no farther than what is too much.
        is(price.bend(1.0, &[0.5, 0.0], &[1.5, -1.8], 0.5, f64::INFINITY), 1.0 + 4.0 + 12.96 + 640.0);
        is(price.bend(1.0, &[0.5, 0.0], &[1.5, -1.8], 0.5, 4.5), 5.0);
        for most in [0.5, 4.0, 30.0, 900.0, 1e5] {
            for joint in 0..2 {
                let cost = |acceleration: f64| {
                    let after = std::array::from_fn(|j| if j == joint { acceleration } else { 0.0 });
                    price.bend(0.0, &[0.0; 2], &after, 1.0, f64::INFINITY)
                };
                let reach = price.reach(joint, most);
                assert!(cost(1.0001 * reach) > most && cost(0.9999 * reach) < 2.0 * most, "{joint} {most} {reach}");
            }
        }
    }
}
