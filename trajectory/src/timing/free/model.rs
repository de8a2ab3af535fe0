//! Joints at the waypoints, the times between them, and the rows that limit both.
//!
//! Speeds, accelerations and jerks are divided differences over two, three and four waypoints. Before the first and
//! after the last waypoint joints stand still, in steps as long as the outermost.

use super::program::Rows;
use crate::angle::nearest_image;
use crate::{Bounds, FreeRange, LadderNode, Robot};

/// Rates of the joints below this count as this: parameters that hardly move the joints take no giant steps.
const MIN_RATE: f64 = 1e-2;

/// Speeds and accelerations below this share of their limits get no row. A round shortens times by 0.3 at most, which doubles
/// accelerations: with the present angles these rows stay below 0.6. Other values have not been tried.
const FAR: f64 = 0.3;

/// Waypoints stay this far from the stops, in radians: the motion sways between them.
const STOP_MARGIN: f64 = 1e-3;

/// A stop that is farther than this counts as this far, in radians.
const FAR_STOP: f64 = 100.0;

/// Free parameters, joints and durations.
#[derive(Clone)]
pub(super) struct Point<const N: usize, const F: usize> {
    /// At each waypoint.
    pub free: Vec<[f64; F]>,
    pub joints: Vec<[f64; N]>,
    /// Derivatives of the joints by a unit step, which moves them by a radian.
    pub columns: Vec<[[f64; N]; F]>,
    /// What a unit step is of the free parameters.
    pub units: Vec<[f64; F]>,
    /// From each waypoint to the next, in seconds.
    pub steps: Vec<f64>,
}

impl<const N: usize, const F: usize> Point<N, F> {
    /// The waypoints at the parameters of these nodes, on the images of the nodes' joints; steps are unknown yet.
    /// Otherwise the waypoint where the robot cannot be.
    pub fn start(robot: &dyn Robot<N, F>, nodes: &[LadderNode<N, F>]) -> Result<Self, usize> {
        let mut point = Point {
            free: nodes.iter().map(|node| node.free).collect(),
            joints: nodes.iter().map(|node| node.joints).collect(),
            columns: vec![[[0.0; N]; F]; nodes.len()],
            units: vec![[1.0; F]; nodes.len()],
            steps: Vec::new(),
        };
        for (waypoint, node) in nodes.iter().enumerate() {
            let is_finite = node.joints.iter().all(|joint| joint.is_finite());
            if !(is_finite && point.place(robot, waypoint, node.branch, &node.joints)) {
                return Err(waypoint);
            }
        }
        Ok(point)
    }

    /// Evaluates a waypoint; joints are the images nearest to `like`. False where the robot cannot be there.
    fn place(&mut self, robot: &dyn Robot<N, F>, waypoint: usize, branch: u32, like: &[f64; N]) -> bool {
        let Some(posture) = robot.posture(waypoint, &self.free[waypoint], branch) else { return false };
        let mut joints = posture.joints;
        for (joint, like) in joints.iter_mut().zip(like) {
            *joint = nearest_image(*joint, *like);
        }
        if !joints.iter().chain(posture.rates.iter().flatten()).all(|value| value.is_finite()) {
            return false;
        }
        for f in 0..F {
            let norm = posture.rates[f].iter().map(|rate| rate * rate).sum::<f64>().sqrt().max(MIN_RATE);
            self.units[waypoint][f] = 1.0 / norm;
            self.columns[waypoint][f] = posture.rates[f].map(|rate| rate / norm);
        }
        self.joints[waypoint] = joints;
        true
    }

    /// A step away, or the waypoints where the robot cannot be then. `x`: for each waypoint the steps of the free
    /// parameters, and the relative change of the time to the next waypoint.
    pub fn moved(
        &self,
        robot: &dyn Robot<N, F>,
        nodes: &[LadderNode<N, F>],
        ranges: &[FreeRange; F],
        x: &[f64],
    ) -> Result<Self, Vec<usize>> {
        let (mut next, mut unreachable) = (self.clone(), Vec::new());
        for (waypoint, x) in x.chunks_exact(F + 1).enumerate() {
            let mut like = self.joints[waypoint];
            for f in 0..F {
                let by = x[f];
                let value = &mut next.free[waypoint][f];
                *value += by * self.units[waypoint][f];
                if let FreeRange::Within(low, high) = ranges[f] {
                    *value = value.max(low).min(high);
                }
                like.iter_mut().zip(&self.columns[waypoint][f]).for_each(|(like, column)| *like += by * column);
            }
            if !next.place(robot, waypoint, nodes[waypoint].branch, &like) {
                unreachable.push(waypoint);
            }
            if let Some(step) = next.steps.get_mut(waypoint) {
                *step *= 1.0 + x[F];
            }
        }
        if unreachable.is_empty() { Ok(next) } else { Err(unreachable) }
    }

    /// The total time.
    pub fn time(&self) -> f64 {
        self.steps.iter().sum()
    }

    /// The rows at this point, each as a share of its limit, and the duration if times are scaled wherever a limit is
    /// passed. The unknowns of a waypoint are its free parameters and the time to the next waypoint, relative to what it is.
    ///
    /// # Arguments
    /// * `weight`: of half the square of each jerk, a second.
    /// * `reach`: how far joints may move, in radians. Stops farther away have no row.
    pub fn rows(&self, bounds: &Bounds<N>, weight: f64, reach: f64, rows: &mut Rows) -> f64 {
        rows.clear();
        let last = self.joints.len() - 1;
        let stride = F + 1;
        let mut factors = vec![1.0f64; last];
        // Windows of four waypoints, of which those before the first and after the last stand still.
        for k in 0..last + 2 {
            let at: [usize; 4] = std::array::from_fn(|i| (k + i).saturating_sub(2).min(last));
            let pieces: [usize; 3] = std::array::from_fn(|i| (k + i).saturating_sub(2).min(last - 1));
            let h = pieces.map(|piece| self.steps[piece]);
            let stencil = Stencil::new(h);
            let factor = &mut factors[pieces[1]];
            for j in 0..N {
                let q = at.map(|at| self.joints[at][j]);
                let [speed, acceleration, jerk] = stencil.rates(q);
                // Velocity on the piece between the middle two, acceleration at the second, jerk around both.
                let kinds = [
                    (speed, bounds.velocity[j], (1..=last).contains(&k)),
                    (acceleration, bounds.acceleration[j], k > 0),
                    (jerk, bounds.jerk[j], true),
                ];
                for (order, (rate, limit, counts)) in kinds.into_iter().enumerate() {
                    let value = rate.value / limit;
                    if !counts || limit == f64::INFINITY || (order < 2 && value.abs() < FAR) {
                        continue;
                    }
                    *factor = factor.max(match order {
                        0 => value.abs(),
                        1 => value.abs().sqrt(),
                        _ => value.abs().cbrt(),
                    });
                    let weight = if order == 2 { weight * h[1] } else { 0.0 };
                    let joints = (0..4).flat_map(|i| {
                        (0..F).map(move |f| (at[i] * stride + f, rate.by_joint[i] * self.columns[at[i]][f][j] / limit))
                    });
                    let steps = (0..3).map(|i| (pieces[i] * stride + F, rate.by_step[i] / limit));
                    rows.push(value, weight, joints.chain(steps));
                }
            }
            if k > 0 {
                self.add_stops(k - 1, bounds, reach, rows);
            }
        }
        factors.iter().zip(&self.steps).map(|(factor, step)| factor * step).sum()
    }

    /// Rows for the stops of a waypoint's joints.
    fn add_stops(&self, waypoint: usize, bounds: &Bounds<N>, reach: f64, rows: &mut Rows) {
        for j in 0..N {
            let q = self.joints[waypoint][j];
            let [low, high] = [bounds.lower[j] + STOP_MARGIN, bounds.upper[j] - STOP_MARGIN];
            if q - reach > low && q + reach < high {
                continue;
            }
            // One of them is finite; a stop out of reach is as good as any.
            let (low, high) = (low.max(q.min(high) - FAR_STOP), high.min(q.max(low) + FAR_STOP));
            let half = 0.5 * (high - low);
            if half <= 0.0 {
                continue;
            }
            let terms = (0..F).map(|f| (waypoint * (F + 1) + f, self.columns[waypoint][f][j] / half));
            rows.push((q - 0.5 * (low + high)) / half, 0.0, terms);
        }
    }
}

/// A rate and its derivatives by four angles and, times the step, by three steps.
#[derive(Clone, Copy)]
struct Rate {
    value: f64,
    by_joint: [f64; 4],
    by_step: [f64; 3],
}

/// Divided differences over four waypoints.
struct Stencil {
    h: [f64; 3],
    speed: [f64; 4],
    bend: [f64; 4],
    third: [f64; 4],
}

impl Stencil {
    fn new(h: [f64; 3]) -> Self {
        let (before, after) = (h[0] + h[1], h[1] + h[2]);
        let bend = [2.0 / (h[0] * before), -2.0 / (h[0] * h[1]), 2.0 / (h[1] * before), 0.0];
        let next = [0.0, 2.0 / (h[1] * after), -2.0 / (h[1] * h[2]), 2.0 / (h[2] * after)];
        let third = std::array::from_fn(|i| 3.0 * (next[i] - bend[i]) / (before + h[2]));
        Stencil { h, speed: [0.0, -1.0 / h[1], 1.0 / h[1], 0.0], bend, third }
    }

    /// The velocity between the second and the third angle, the acceleration at the second, and the jerk.
    fn rates(&self, q: [f64; 4]) -> [Rate; 3] {
        let h = self.h;
        let (before, after) = (h[0] + h[1], h[1] + h[2]);
        let whole = before + h[2];
        let v: [f64; 3] = std::array::from_fn(|i| (q[i + 1] - q[i]) / h[i]);
        let a = [2.0 * (v[1] - v[0]) / before, 2.0 * (v[2] - v[1]) / after];
        let jerk = 3.0 * (a[1] - a[0]) / whole;
        let by_first = [(2.0 * v[0] - h[0] * a[0]) / before, (-2.0 * v[1] - h[1] * a[0]) / before, 0.0];
        let by_second = [0.0, (2.0 * v[1] - h[1] * a[1]) / after, (-2.0 * v[2] - h[2] * a[1]) / after];
        let by_step = std::array::from_fn(|i| (3.0 * (by_second[i] - by_first[i]) - h[i] * jerk) / whole);
        [
            Rate { value: v[1], by_joint: self.speed, by_step: [0.0, -v[1], 0.0] },
            Rate { value: a[0], by_joint: self.bend, by_step: by_first },
            Rate { value: jerk, by_joint: self.third, by_step },
        ]
    }
}
