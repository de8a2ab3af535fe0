//! A point of the search: free parameters at the waypoints, joints at all knots, and the spline through them.

use super::options::Cone;
use crate::angle::nearest_image;
use crate::{Bounds, FreeRange, LadderNode, Robot, Timeline, run_in_and_out};
use std::f64::consts::TAU;

/// Column norms of `dq/dfree` below this count as this: parameters that hardly move the joints take no giant steps.
const MIN_RATE: f64 = 1e-2;

/// Newton steps with which a near_singular waypoint is projected back onto what the robot can do.
const PROJECTIONS: usize = 12;

/// Where free parameters may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Domain<const F: usize> {
    pub ranges: [FreeRange; F],
    pub cone: Option<Cone>,
}

impl<const F: usize> Domain<F> {
    /// The nearest values within.
    fn nearest(&self, mut free: [f64; F]) -> [f64; F] {
        for (value, range) in free.iter_mut().zip(&self.ranges) {
            if let FreeRange::Within(low, high) = *range {
                *value = value.max(low).min(high);
            }
        }
        if let Some(Cone { tilts: [a, b], half_angle }) = self.cone {
            let tilt = free[a].hypot(free[b]);
            if tilt > half_angle {
                free[a] *= half_angle / tilt * (1.0 - f64::EPSILON);
                free[b] *= half_angle / tilt * (1.0 - f64::EPSILON);
            }
        }
        free
    }
}

/// A waypoint that cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unreachable(pub usize);

/// Free parameters, joints and accelerations. `T m = R q` holds between the last two.
#[derive(Clone, Debug)]
pub(super) struct Point<const N: usize, const F: usize> {
    /// At each waypoint.
    pub free: Vec<[f64; F]>,
    /// Unit columns of `dq/dfree` at each waypoint, and the norms by which they were divided.
    pub columns: Vec<[[f64; N]; F]>,
    pub norms: Vec<[f64; F]>,
    /// Joints at each knot of the timeline.
    pub knots: Vec<[f64; N]>,
    /// Their second derivatives.
    pub curvatures: Vec<[f64; N]>,
}

impl<const N: usize, const F: usize> Point<N, F> {
    /// The waypoints at given parameters, unwrapped along the path from the first node's image. Joints that leave their
    /// bounds are turned by whole turns towards the middle. Knots of run-in and run-out stand still.
    pub fn start(
        robot: &dyn Robot<N, F>,
        line: &Timeline,
        branches: &[u32],
        nodes: &[LadderNode<N, F>],
        bounds: &Bounds<N>,
    ) -> Result<Self, Unreachable> {
        let range = line.waypoints();
        let mut point = Point {
            free: nodes.iter().map(|node| node.free).collect(),
            columns: vec![[[0.0; N]; F]; nodes.len()],
            norms: vec![[1.0; F]; nodes.len()],
            knots: vec![[0.0; N]; line.knots()],
            curvatures: Vec::new(),
        };
        let mut like = nodes.first().map(|node| node.joints).filter(|joints| joints.iter().all(|q| q.is_finite()));
        for waypoint in 0..nodes.len() {
            let joints = point.place(robot, branches, range.start, waypoint, like).ok_or(Unreachable(waypoint))?;
            like = Some(joints);
        }
        for joint in 0..N {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for knot in &point.knots[range.clone()] {
                low = low.min(knot[joint]);
                high = high.max(knot[joint]);
            }
            let middle = 0.5 * (bounds.lower[joint] + bounds.upper[joint]);
            let turns = if middle.is_finite() { ((middle - 0.5 * (low + high)) / TAU).round() } else { 0.0 };
            // Only to come within the bounds: where it starts within them, it stays.
            if low < bounds.lower[joint] || high > bounds.upper[joint] {
                point.knots[range.clone()].iter_mut().for_each(|knot| knot[joint] += TAU * turns);
            }
        }
        let (first, last) = (point.knots[range.start], point.knots[range.end - 1]);
        point.knots[..range.start].fill(first);
        point.knots[range.end..].fill(last);
        point.bend(line);
        Ok(point)
    }

    /// The same waypoints, with the run-in and run-out of least squared jerk.
    pub fn with_easy_ends(&self, line: &Timeline) -> Option<Self> {
        let knots = run_in_and_out(line, &self.knots[line.waypoints()]).ok()?;
        let mut point = Point { knots, ..self.clone() };
        point.bend(line);
        Some(point)
    }

    /// Evaluates one waypoint at its parameters; joints are the images nearest to `like`.
    fn place(
        &mut self,
        robot: &dyn Robot<N, F>,
        branches: &[u32],
        run: usize,
        waypoint: usize,
        like: Option<[f64; N]>,
    ) -> Option<[f64; N]> {
        let posture = robot.posture(waypoint, &self.free[waypoint], branches[waypoint])?;
        let mut joints = posture.joints;
        if let Some(like) = like {
            for (joint, like) in joints.iter_mut().zip(like) {
                *joint = nearest_image(*joint, like);
            }
        }
        if !joints.iter().chain(posture.rates.iter().flatten()).all(|value| value.is_finite()) {
            return None;
        }
        for f in 0..F {
            let norm = posture.rates[f].iter().map(|rate| rate * rate).sum::<f64>().sqrt().max(MIN_RATE);
            self.norms[waypoint][f] = norm;
            self.columns[waypoint][f] = posture.rates[f].map(|rate| rate / norm);
        }
        self.knots[run + waypoint] = joints;
        Some(joints)
    }

    /// The point a share of a step on. `steps` are in units of joints: parameter `f` moves by `steps[f] / norms[f]`.
    ///
    /// Where `dq/dfree` is longer than `near_singular`, the straight line is followed in the joints and then projected back:
    /// the parameters are those at which the joints come nearest to it on the same branch.
    pub fn moved(
        &self,
        robot: &dyn Robot<N, F>,
        line: &Timeline,
        branches: &[u32],
        (steps, run_steps): (&[[f64; F]], &[[f64; N]]),
        (share, near_singular): (f64, f64),
        domain: &Domain<F>,
    ) -> Result<Self, Unreachable> {
        let range = line.waypoints();
        let mut next = self.clone();
        for (waypoint, step) in steps.iter().enumerate() {
            let before = &self.knots[range.start + waypoint];
            let mut aim = *before;
            let mut is_near_singular = false;
            for (f, by) in step.iter().enumerate() {
                let by = share * by;
                next.free[waypoint][f] += by / self.norms[waypoint][f];
                is_near_singular |= self.norms[waypoint][f] > near_singular;
                for (aim, column) in aim.iter_mut().zip(&self.columns[waypoint][f]) {
                    *aim += by * column;
                }
            }
            next.free[waypoint] = domain.nearest(next.free[waypoint]);
            let placed = next.place(robot, branches, range.start, waypoint, Some(aim));
            if is_near_singular {
                self.project(&mut next, robot, branches, (range.start, waypoint), &aim, domain);
            } else if placed.is_none() {
                return Err(Unreachable(waypoint));
            }
        }
        for (knot, by) in next.knots[..range.start].iter_mut().zip(run_steps) {
            knot.iter_mut().zip(by).for_each(|(joint, by)| *joint += share * by);
        }
        for (knot, by) in next.knots[range.end..].iter_mut().zip(&run_steps[range.start..]) {
            knot.iter_mut().zip(by).for_each(|(joint, by)| *joint += share * by);
        }
        next.bend(line);
        Ok(next)
    }

    /// The path with these free parameters, in the image of this one's first waypoint; `None` out of reach.
    pub fn with_free(
        &self,
        robot: &dyn Robot<N, F>,
        line: &Timeline,
        branches: &[u32],
        free: &[[f64; F]],
        bounds: &Bounds<N>,
    ) -> Option<Self> {
        let first = self.knots[line.waypoints().start];
        let node = |(&free, &branch): (&[f64; F], &u32)| LadderNode { joints: first, free, branch };
        let nodes: Vec<_> = free.iter().zip(branches).map(node).collect();
        Point::start(robot, line, branches, &nodes, bounds).ok()
    }

    /// Brings a near_singular waypoint of `next` as near to `aim` as its branch allows, by Gauss-Newton with halved steps from
    /// where it was. It never ends farther from the aim than it began.
    fn project(
        &self,
        next: &mut Self,
        robot: &dyn Robot<N, F>,
        branches: &[u32],
        (run, waypoint): (usize, usize),
        aim: &[f64; N],
        domain: &Domain<F>,
    ) {
        let distance = |joints: &[f64; N]| joints.iter().zip(aim).map(|(q, aim)| (q - aim).powi(2)).sum::<f64>();
        let mut best = (self.free[waypoint], self.columns[waypoint], self.norms[waypoint], self.knots[run + waypoint]);
        for _ in 0..PROJECTIONS {
            // One parameter after another: columns are few, and seldom parallel.
            let mut wanted = best.0;
            let mut left: [f64; N] = std::array::from_fn(|j| aim[j] - best.3[j]);
            for (f, wanted) in wanted.iter_mut().enumerate() {
                let along: f64 = left.iter().zip(&best.1[f]).map(|(left, column)| left * column).sum();
                left.iter_mut().zip(&best.1[f]).for_each(|(left, column)| *left -= along * column);
                *wanted += along / best.2[f];
            }
            let mut share = 1.0;
            let mut nearer = false;
            while share > 1e-3 && !nearer {
                let part = std::array::from_fn(|f| best.0[f] + share * (wanted[f] - best.0[f]));
                next.free[waypoint] = domain.nearest(part);
                if let Some(joints) = next.place(robot, branches, run, waypoint, Some(*aim))
                    && distance(&joints) < distance(&best.3)
                {
                    best = (next.free[waypoint], next.columns[waypoint], next.norms[waypoint], joints);
                    nearer = true;
                }
                share *= 0.5;
            }
            if !nearer {
                break;
            }
        }
        (next.free[waypoint], next.columns[waypoint], next.norms[waypoint], next.knots[run + waypoint]) = best;
    }

    /// Accelerations from the joints.
    fn bend(&mut self, line: &Timeline) {
        self.curvatures.resize(self.knots.len(), [0.0; N]);
        let mut angles = vec![0.0; self.knots.len()];
        for joint in 0..N {
            angles.iter_mut().zip(&self.knots).for_each(|(angle, knot)| *angle = knot[joint]);
            let m = line.second_derivatives(&angles);
            m.iter().zip(&mut self.curvatures).for_each(|(&m, knot)| knot[joint] = m);
        }
    }

    /// The jerk of a joint on piece `0..=knots`, the first from and the last to rest.
    pub fn jerk(&self, line: &Timeline, piece: usize, joint: usize) -> f64 {
        let before = if piece == 0 { 0.0 } else { self.curvatures[piece - 1][joint] };
        let after = self.curvatures.get(piece).map_or(0.0, |m| m[joint]);
        (after - before) / line.step(piece)
    }

    /// The integral of the squared jerk from rest to rest.
    pub fn squared_jerk(&self, line: &Timeline) -> f64 {
        (0..=self.knots.len())
            .map(|piece| {
                let sum: f64 = (0..N).map(|joint| self.jerk(line, piece, joint).powi(2)).sum();
                sum * line.step(piece)
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Posture, RobotFn, RunIn};

    #[test]
    fn the_nearest_values_lie_in_the_ranges_and_in_the_cone() {
        let ranges = [FreeRange::Turn, FreeRange::Within(-1.0, 1.0), FreeRange::Within(-1.0, 0.4)];
        let cone = Some(Cone { tilts: [1, 2], half_angle: 0.25 });
        let check = |cone: Option<Cone>, free: [f64; 3], expected: [f64; 3]| {
            let nearest = Domain { ranges, cone }.nearest(free);
            let is_near = nearest.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-12);
            assert!(is_near, "{nearest:?} for {expected:?}");
            assert!(cone.is_none_or(|cone| nearest[1].hypot(nearest[2]) <= cone.half_angle));
        };
        check(None, [9.0, 3.0, -2.0], [9.0, 1.0, -1.0]);
        check(cone, [9.0, 0.15, -0.2], [9.0, 0.15, -0.2]);
        // 0.3 and 0.4 are 0.5 from the middle, twice as far as the cone goes.
        check(cone, [9.0, 0.3, 7.0], [9.0, 0.15, 0.2]);
    }

    /// Joints on a circle of radius 50, once round for each unit of the parameter: half of the circle is in reach.
    fn circle(free: f64) -> Option<Posture<2, 1>> {
        let (sin, cos) = (TAU * free).sin_cos();
        let rates = [[-50.0 * TAU * sin, 50.0 * TAU * cos]];
        (free.abs() < 0.25).then_some(Posture { joints: [50.0 * cos, 50.0 * sin], rates })
    }

    #[test]
    fn near_singular_waypoints_come_as_near_to_the_straight_line_as_they_can() {
        let robot = RobotFn {
            waypoints: 2,
            free: [FreeRange::Within(-1.0, 1.0)],
            solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 2])| {},
            posture: |_: usize, free: &[f64; 1], _: u32| circle(free[0]),
        };
        let line = Timeline::new(&[0.0, 1.0], RunIn { pieces: 2, spacing: 0.5 }).unwrap();
        let domain = Domain { ranges: [FreeRange::Within(-1.0, 0.1)], cone: None };
        let turned = 0.05 * TAU;
        let first = [50.0 * turned.cos(), 50.0 * turned.sin()];
        let node = |free: f64| LadderNode { joints: first, free: [free], branch: 0 };
        let start = Point::start(&robot, &line, &[0; 2], &[node(0.05), node(0.02)], &Bounds::NONE).unwrap();
        let runs = vec![[0.0; 2]; line.knots() - 2];
        let moved = |by: f64, near_singular: f64| {
            start.moved(&robot, &line, &[0; 2], (&[[by], [0.0]], &runs), (1.0, near_singular), &domain)
        };
        for by in [1.2, -2.5, 2.9, -3.1] {
            // Along a tangent: the nearest point of the circle is in the direction of its end.
            let next = moved(by, 100.0).unwrap();
            let nearest = 0.05 + by.atan2(50.0) / TAU;
            assert!((next.free[0][0] - nearest).abs() < 1e-9, "{by} {:?} {nearest}", next.free[0]);
            let expected = circle(next.free[0][0]).unwrap();
            let column = expected.rates[0].map(|rate| rate / (50.0 * TAU));
            let near = |a: &[f64; 2], b: &[f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(near(&next.knots[line.waypoints().start], &expected.joints), "{:?}", next.knots);
            assert!(near(&next.columns[0][0], &column), "{:?}", next.columns);
            // Elsewhere the parameter moves, and with it the joints along the circle.
            let plain = moved(by, 1e3).unwrap();
            assert!((plain.free[0][0] - 0.05 - by / 50.0 / TAU).abs() < 1e-12);
        }
        // Where the straight line leaves what is in reach, the waypoint cannot be placed, but for one that is projected: it comes nearer.
        assert!(moved(-100.0, 1e3).is_err());
        let far = moved(-100.0, 100.0).unwrap().free[0][0];
        assert!(far > 0.05 + f64::atan2(-100.0, 50.0) / TAU && far < -0.05, "{far}");
    }

    #[test]
    fn joints_start_between_their_stops() {
        let robot = RobotFn {
            waypoints: 2,
            free: [FreeRange::Turn],
            solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 2])| {},
            posture: |_: usize, free: &[f64; 1], _: u32| {
                Some(Posture { joints: [free[0], 0.5 * free[0]], rates: [[1.0, 0.5]] })
            },
        };
        let line = Timeline::new(&[0.0, 1.0], RunIn { pieces: 2, spacing: 0.5 }).unwrap();
        let node = |free: f64| LadderNode { joints: [free, 0.5 * free], free: [free], branch: 0 };
        // The first joint goes a turn up, or down; the second is within its stops, though not in the middle.
        for (lower, upper, turns) in [(9.0, 17.0, 1.0), (-17.0, 5.0, -2.0), (-30.0, -1.0, -3.0), (-3.0, 40.0, 0.0)] {
            let bounds = Bounds { lower: [lower, -1.0], upper: [upper, 30.0], ..Bounds::NONE };
            let point = Point::start(&robot, &line, &[0; 2], &[node(4.0), node(6.9)], &bounds).unwrap();
            for (at, knot) in point.knots.iter().enumerate() {
                let expected = if at <= line.waypoints().start { 4.0 } else { 6.9 };
                assert!((knot[0] - expected - turns * TAU).abs() < 1e-12, "{lower} {knot:?}");
                assert!((knot[1] - 0.5 * expected).abs() < 1e-12, "{knot:?}");
            }
        }
    }
}
