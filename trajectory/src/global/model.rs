//! The path linearised: one quadratic program with a stage a knot.
//!
//! Unknown at a waypoint are the steps of its free parameters (in units of joints), at a knot of run-in or run-out the
//! step of each joint, and at every knot the accelerations `m`. The rows `T m = R q` of the timeline are equations over
//! three neighbouring stages; what is minimised is `sum over pieces of (m_k - m_{k-1})^2 / h`, which is the integral of
//! the squared jerk, plus a damping of the steps.
//!
//! Collisions that an indicator predicts are kept clear of by a soft row a knot, see [`super::avoid`].

use super::avoid::Avoid;
use super::limits::{Place, extremes};
use super::options::GlobalOptions;
use super::point::{Domain, Point};
use crate::qp::QpSolution;
use crate::qp::{BandedQp, QpError, QpOptions};
use crate::{Bounds, FreeRange, Quantity, Timeline};
use std::f64::consts::TAU;

/// Sides of the polygon that stands for a cone: the corners lie on it, and the sides come within 1 % of it.
const CONE_SIDES: usize = 24;

/// Bounds of rows are tightened by this share at first, so that what the solver leaves does not pass the true ones.
const TIGHTENED_AT_FIRST: f64 = 1e-6;

/// Values within this share of their bound get a row; others are looked at after the step.
const NEAR: f64 = 0.7;

/// Angles within this distance of their bound get a row, in radians.
const NEAR_ANGLE: f64 = 0.2;

/// Free parameters within this distance of the end of their range get a row; others stop at the end if a step goes
/// beyond. A row for each makes a solver of inequalities out of one linear system.
const NEAR_END: f64 = 0.2;

/// Damping of the steps of run-in and run-out: it keeps their blocks positive definite where no row holds them, and is small beside the
/// squared jerk.
const RUN_DAMPING: f64 = 1e-6;

/// What is asked of the peak: each jerk at most `height` times its bound; the height costs `price` and is at least 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PeakTerm {
    pub price: f64,
    /// The present height: jerks of less than a part of it get no row.
    pub height: f64,
}

/// The quadratic programs of one path, built again and again in the same memory.
pub(super) struct Model<'a, const N: usize, const F: usize> {
    pub line: &'a Timeline,
    pub bounds: &'a Bounds<N>,
    pub domain: Domain<F>,
    /// Price of passing a bound, a whole bound a unit.
    pub penalty: f64,
    /// The share by which bounds are tightened.
    pub tightened: f64,
    /// The price of bounds at which the price of collisions is what was asked for.
    full_penalty: f64,
    avoid: Option<Avoid<'a, N>>,
    qp: BandedQp,
    /// For each piece, joint and quantity: that it has passed its bound once, and keeps its row.
    kept: Vec<[[bool; 4]; N]>,
    first: Vec<usize>,
}

/// A solved program.
pub(super) struct Step<const N: usize, const F: usize> {
    pub waypoints: Vec<[f64; F]>,
    pub run: Vec<[f64; N]>,
    pub height: f64,
    pub solution: QpSolution,
    /// The integral of the squared jerk that the linear problem promises.
    pub squared_jerk: f64,
}

impl<'a, const N: usize, const F: usize> Model<'a, N, F> {
    pub fn new(
        line: &'a Timeline,
        bounds: &'a Bounds<N>,
        ranges: [FreeRange; F],
        options: &GlobalOptions,
        avoid: Option<Avoid<'a, N>>,
        with_peak: bool,
    ) -> Self {
        let waypoints = line.waypoints();
        let sizes: Vec<usize> = (0..line.knots()).map(|k| if waypoints.contains(&k) { F + N } else { 2 * N }).collect();
        let mut first = vec![0];
        for size in &sizes {
            first.push(first[first.len() - 1] + size);
        }
        Model {
            line,
            bounds,
            domain: Domain { ranges, cone: options.cone },
            penalty: options.penalty,
            tightened: TIGHTENED_AT_FIRST,
            full_penalty: options.penalty,
            avoid,
            qp: BandedQp::new(&sizes, usize::from(with_peak)),
            kept: vec![[[false; 4]; N]; line.knots() + 1],
            first,
        }
    }

    /// What passing the bounds costs at a point, and the greatest jerk over its bound.
    pub fn price(&mut self, point: &Point<N, F>) -> (f64, f64) {
        let (mut price, mut peak) = (0.0, 0.0f64);
        extremes(point, self.line, |place, value| {
            let (low, high) = place.bounds(self.bounds);
            if place.quantity == Quantity::Jerk {
                peak = peak.max(value.abs() / high);
                return;
            }
            let unit = unit(&place, low, high);
            let over = (value - (high - self.tightened * unit)).max(low + self.tightened * unit - value);
            if over > 0.0 && self.penalty > 0.0 {
                price += self.penalty * over / unit;
                self.kept[place.piece][place.joint][place.quantity as usize] = true;
            }
        });
        if let Some((avoid, unit)) = self.avoiding() {
            price += unit * point.knots.iter().map(|joints| avoid.excess(joints)).sum::<f64>();
        }
        (price, peak)
    }

    /// By how much a bound on position, speed or acceleration is passed at most, in shares of it (radians for positions).
    pub fn farthest(&self, point: &Point<N, F>) -> f64 {
        let mut farthest = 0.0f64;
        extremes(point, self.line, |place, value| {
            let (low, high) = place.bounds(self.bounds);
            if place.quantity != Quantity::Jerk {
                farthest = farthest.max((value - high).max(low - value) / unit(&place, low, high));
            }
        });
        farthest
    }

    /// The waypoints next to pieces on which a bound on position, speed or acceleration is passed, ascending.
    pub fn missed(&self, point: &Point<N, F>) -> Vec<usize> {
        let waypoints = self.line.waypoints();
        let mut missed = Vec::new();
        extremes(point, self.line, |place, value| {
            let (low, high) = place.bounds(self.bounds);
            if place.quantity != Quantity::Jerk && (value < low || value > high) {
                missed.push(place.piece.clamp(waypoints.start, waypoints.end - 1) - waypoints.start);
            }
        });
        missed.dedup();
        missed
    }

    /// What is kept clear of, and the present price of a unit. It rises with the price of bounds.
    fn avoiding(&self) -> Option<(Avoid<'a, N>, f64)> {
        let avoid = self.avoid.filter(|_| self.penalty > 0.0)?;
        Some((avoid, avoid.price * self.penalty / self.full_penalty))
    }

    /// Builds and solves the program at a point.
    pub fn step(
        &mut self,
        point: &Point<N, F>,
        damping: &[f64],
        peak: Option<PeakTerm>,
        options: &QpOptions,
    ) -> Result<Step<N, F>, QpError> {
        self.qp.clear();
        let mut start = vec![0.0; self.qp.variables()];
        // The order of costs and rows is that of the solver's sums: it decides the last bits of a solution.
        self.price_jerk();
        self.join_curvatures(point, &mut start);
        self.hold_free_parameters(point, damping);
        self.damp_run();
        self.limit(point, peak, &mut start);
        let solution = self.qp.solve_once(options, Some(&start))?;
        Ok(self.read(solution, peak.is_some()))
    }

    /// The unknown that is the acceleration of a joint at a knot: these are the last of each stage.
    fn curvature(&self, knot: usize, joint: usize) -> usize {
        self.first[knot + 1] - N + joint
    }

    /// The cost: the integral of the squared jerk, which is constant on a piece, `(m_k - m_{k-1})^2 / h`. The path rests at both ends,
    /// where there is no acceleration.
    fn price_jerk(&mut self) {
        let knots = self.line.knots();
        for piece in 0..=knots {
            let weight = 2.0 / self.line.step(piece);
            for joint in 0..N {
                let before = piece.checked_sub(1).map(|k| self.curvature(k, joint));
                let after = (piece < knots).then(|| self.curvature(piece, joint));
                for at in before.iter().chain(&after) {
                    self.qp.add_quadratic(*at, *at, weight);
                }
                if let (Some(before), Some(after)) = (before, after) {
                    self.qp.add_quadratic(after, before, -weight);
                }
            }
        }
    }

    /// The equations `T m = R q`, which make accelerations those of the spline through the knots. Scaled to 1 on the diagonal, so that rows
    /// of short and of long pieces weigh alike.
    fn join_curvatures(&mut self, point: &Point<N, F>, start: &mut [f64]) {
        let knots = self.line.knots();
        let mut terms = Vec::new();
        for k in 0..knots {
            let row = self.line.row(k);
            let scale = 1.0 / row.curvatures[1];
            for joint in 0..N {
                terms.clear();
                let mut right = 0.0;
                for (side, (&t, &r)) in row.curvatures.iter().zip(&row.angles).enumerate() {
                    let Some(other) = (k + side).checked_sub(1).filter(|&other| other < knots) else { continue };
                    terms.push((self.curvature(other, joint), scale * t));
                    // Differences first: angles far from zero keep their digits.
                    right += scale * r * (point.knots[other][joint] - point.knots[k][joint]);
                    self.turn_to_steps(point, other, joint, -scale * r, &mut terms);
                }
                self.qp.add_row(&terms, right, right);
                start[self.curvature(k, joint)] = point.curvatures[k][joint];
            }
        }
    }

    /// Free parameters: their steps are damped, as columns hold near the point only, and stay in their ranges and in the cone.
    fn hold_free_parameters(&mut self, point: &Point<N, F>, damping: &[f64]) {
        let run = self.line.waypoints().start;
        for (waypoint, &damping) in damping.iter().enumerate() {
            let at = self.first[run + waypoint];
            for f in 0..F {
                self.qp.add_quadratic(at + f, at + f, damping);
                let (value, norm) = (point.free[waypoint][f], point.norms[waypoint][f]);
                if let FreeRange::Within(low, high) = self.domain.ranges[f]
                    && (value - low).min(high - value) < NEAR_END
                {
                    let (low, high) = (((low - value) * norm).min(0.0), ((high - value) * norm).max(0.0));
                    self.qp.add_row(&[(at + f, 1.0)], low, high);
                }
            }
            self.hold_in_cone(at, &point.free[waypoint], &point.norms[waypoint]);
        }
    }

    /// The sides of the polygon that stands for the cone of tilts, for the stage that begins at `at`.
    fn hold_in_cone(&mut self, at: usize, value: &[f64; F], norm: &[f64; F]) {
        let Some(cone) = self.domain.cone else { return };
        let [a, b] = cone.tilts;
        let reach = cone.half_angle * (0.5 * TAU / CONE_SIDES as f64).cos();
        for side in 0..CONE_SIDES {
            let (sin, cos) = (TAU * (side as f64 + 0.5) / CONE_SIDES as f64).sin_cos();
            let left = (reach - cos * value[a] - sin * value[b]).max(0.0);
            // A tilt that leans the other way does not come so far in a step.
            if left > reach {
                continue;
            }
            self.qp.add_row(&[(at + a, cos / norm[a]), (at + b, sin / norm[b])], f64::NEG_INFINITY, left);
        }
    }

    /// A little damping for the joints of run-in and run-out, which nothing else holds where no row is near: the program stays convex.
    fn damp_run(&mut self) {
        let waypoints = self.line.waypoints();
        for k in (0..waypoints.start).chain(waypoints.end..self.line.knots()) {
            for joint in 0..N {
                self.qp.add_quadratic(self.first[k] + joint, self.first[k] + joint, RUN_DAMPING);
            }
        }
    }

    /// The steps that a solution stands for.
    fn read(&self, solution: QpSolution, with_peak: bool) -> Step<N, F> {
        let (knots, waypoints) = (self.line.knots(), self.line.waypoints());
        let x = &solution.x;
        let mut squared_jerk = 0.0;
        for piece in 0..=knots {
            for joint in 0..N {
                let before = if piece == 0 { 0.0 } else { x[self.curvature(piece - 1, joint)] };
                let after = if piece == knots { 0.0 } else { x[self.curvature(piece, joint)] };
                squared_jerk += (after - before).powi(2) / self.line.step(piece);
            }
        }
        let of_run = |k: usize| std::array::from_fn(|joint| x[self.first[k] + joint]);
        Step {
            waypoints: waypoints.clone().map(|k| std::array::from_fn(|f| x[self.first[k] + f])).collect(),
            run: (0..waypoints.start).chain(waypoints.end..knots).map(of_run).collect(),
            height: if with_peak { x[x.len() - 1] } else { 0.0 },
            squared_jerk,
            solution,
        }
    }

    /// Adds `by` times the change of a joint at a knot, in terms of the steps.
    fn turn_to_steps(&self, point: &Point<N, F>, knot: usize, joint: usize, by: f64, terms: &mut Vec<(usize, f64)>) {
        let range = self.line.waypoints();
        let at = self.first[knot];
        if range.contains(&knot) {
            for (f, column) in point.columns[knot - range.start].iter().enumerate() {
                terms.push((at + f, by * column[joint]));
            }
        } else {
            terms.push((at + joint, by));
        }
    }

    /// Rows for what is near its bound, and for the peak.
    fn limit(&mut self, point: &Point<N, F>, peak: Option<PeakTerm>, start: &mut [f64]) {
        let knots = self.line.knots();
        let mut places = Vec::new();
        extremes(point, self.line, |place, value| {
            let (low, high) = place.bounds(self.bounds);
            let kept = self.kept[place.piece][place.joint][place.quantity as usize];
            let near = match place.quantity {
                Quantity::Position => value < low + NEAR_ANGLE || value > high - NEAR_ANGLE,
                Quantity::Jerk => peak.is_some_and(|peak| value.abs() > 0.5 * peak.height.max(1.0) * high),
                _ => value.abs() > NEAR * high,
            };
            let counts = if place.quantity == Quantity::Jerk { peak.is_some() } else { self.penalty > 0.0 };
            if (kept || near) && (low.is_finite() || high.is_finite()) && counts {
                places.push((place, value));
            }
        });
        let height = self.qp.variables() - 1;
        if let Some(peak) = peak {
            self.qp.add_linear(height, peak.price);
            self.qp.add_row(&[(height, 1.0)], 1.0, f64::INFINITY);
            start[height] = peak.height.max(1.0) * 1.05;
        }
        let mut terms = Vec::new();
        for (place, value) in places {
            let (low, high) = place.bounds(self.bounds);
            let unit = unit(&place, low, high);
            let form = place.form(self.line);
            terms.clear();
            // What the row has at the point without the accelerations, which are unknowns themselves.
            let mut fixed = 0.0;
            for end in 0..2 {
                let Some(knot) = (place.piece + end).checked_sub(1).filter(|&knot| knot < knots) else { continue };
                terms.push((self.first[knot + 1] - N + place.joint, form.curvatures[end] / unit));
                fixed += form.angles[end] * point.knots[knot][place.joint];
                if form.angles[end].abs() > 0.0 {
                    self.turn_to_steps(point, knot, place.joint, form.angles[end] / unit, &mut terms);
                }
            }
            debug_assert!(value.is_finite());
            if place.quantity == Quantity::Jerk {
                self.kept[place.piece][place.joint][Quantity::Jerk as usize] = true;
                terms.push((height, -1.0));
                self.qp.add_row(&terms, f64::NEG_INFINITY, -TIGHTENED_AT_FIRST);
                terms.iter_mut().for_each(|term| term.1 = -term.1);
                let last = terms.len() - 1;
                terms[last].1 = -1.0;
                self.qp.add_row(&terms, f64::NEG_INFINITY, -TIGHTENED_AT_FIRST);
            } else {
                let (low, high) = (low + self.tightened * unit, high - self.tightened * unit);
                self.qp.add_soft_row(&terms, (low - fixed) / unit, (high - fixed) / unit, self.penalty);
            }
        }
        self.keep_clear(point);
    }

    /// Rows for what an indicator predicts, in units of the joint that changes its value most.
    fn keep_clear(&mut self, point: &Point<N, F>) {
        let Some((avoid, price)) = self.avoiding() else { return };
        let mut terms = Vec::new();
        for (knot, joints) in point.knots.iter().enumerate() {
            let Some((over, gradient)) = avoid.row(joints) else { continue };
            let unit = gradient.iter().fold(f64::MIN_POSITIVE, |most, slope| most.max(slope.abs()));
            terms.clear();
            for (joint, slope) in gradient.into_iter().enumerate() {
                self.turn_to_steps(point, knot, joint, slope / unit, &mut terms);
            }
            self.qp.add_soft_row(&terms, f64::NEG_INFINITY, -over / unit, price * unit);
        }
    }
}

/// What a row is measured in: a radian, or the bound.
fn unit(place: &Place, low: f64, high: f64) -> f64 {
    match place.quantity {
        Quantity::Position => 1.0,
        _ => high.min(-low).max(f64::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use super::super::options::Cone;
    use super::*;
    use crate::{LadderNode, Posture, RobotFn, RunIn};

    #[test]
    fn steps_end_in_the_cone_and_as_far_out_as_it_goes() {
        // Two tilts that are the joints, but for jolts which they would have to lean far out to take up.
        let jolt = |waypoint: usize| if waypoint % 4 == 2 { [0.9, 0.0] } else { [0.0, 0.9 * (waypoint % 2) as f64] };
        let robot = RobotFn {
            waypoints: 9,
            free: [FreeRange::Turn; 2],
            solutions: |_: usize, _: &[f64; 2], _: &mut dyn FnMut(u32, [f64; 2])| {},
            posture: |waypoint: usize, free: &[f64; 2], _: u32| {
                let jolt = jolt(waypoint);
                Some(Posture { joints: [free[0] + jolt[0], free[1] + jolt[1]], rates: [[1.0, 0.0], [0.0, 1.0]] })
            },
        };
        let times: Vec<f64> = (0..9).map(|k| 0.2 * f64::from(k)).collect();
        let line = Timeline::new(&times, RunIn { pieces: 3, spacing: 0.5 }).unwrap();
        let node = LadderNode { joints: [0.0; 2], free: [0.0; 2], branch: 0 };
        let point = Point::start(&robot, &line, &[0; 9], &[node; 9], &Bounds::NONE).unwrap();
        let cone = Cone { tilts: [0, 1], half_angle: 0.25 };
        let options = GlobalOptions { cone: Some(cone), ..GlobalOptions::default() };
        let mut model = Model::new(&line, &Bounds::NONE, robot.free, &options, None, false);
        let qp = QpOptions { iterations: 60, tolerance: 1e-10 };
        let step = model.step(&point, &[1e-3; 9], None, &qp).unwrap();
        let tilts: Vec<f64> = step.waypoints.iter().map(|by| by[0].hypot(by[1])).collect();
        let most = tilts.iter().copied().fold(0.0, f64::max);
        // The middles of the sides are less than a hundredth inside.
        assert!(most <= 0.25 * (1.0 + 1e-6) && most > 0.2478, "{tilts:?}");
        // Without it they lean farther.
        let options = GlobalOptions { cone: None, ..options };
        let mut model = Model::new(&line, &Bounds::NONE, robot.free, &options, None, false);
        let free = model.step(&point, &[1e-3; 9], None, &qp).unwrap();
        assert!(free.waypoints.iter().any(|by| by[0].hypot(by[1]) > 0.4));
        assert!(free.squared_jerk < step.squared_jerk);
    }

    #[test]
    fn steps_end_in_the_range_of_a_parameter_that_is_near_its_end() {
        let jolt = |waypoint: usize| if waypoint % 4 == 2 { 0.9 } else { 0.0 };
        let robot = RobotFn {
            waypoints: 9,
            free: [FreeRange::Within(-0.25, 0.6)],
            solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 1])| {},
            posture: |waypoint: usize, free: &[f64; 1], _: u32| {
                Some(Posture { joints: [2.0 * free[0] + jolt(waypoint)], rates: [[2.0]] })
            },
        };
        let times: Vec<f64> = (0..9).map(|k| 0.2 * f64::from(k)).collect();
        let line = Timeline::new(&times, RunIn { pieces: 3, spacing: 0.5 }).unwrap();
        let node = LadderNode { joints: [0.0], free: [-0.1], branch: 0 };
        let point = Point::start(&robot, &line, &[0; 9], &[node; 9], &Bounds::NONE).unwrap();
        let mut model = Model::new(&line, &Bounds::NONE, robot.free, &GlobalOptions::default(), None, false);
        let qp = QpOptions { iterations: 60, tolerance: 1e-10 };
        let step = model.step(&point, &[1e-3; 9], None, &qp).unwrap();
        // Steps are in units of the joint, which turns twice as far as the parameter.
        let values: Vec<f64> = step.waypoints.iter().map(|by| -0.1 + by[0] / 2.0).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least + 0.25).abs() < 1e-6, "{values:?}");
    }

    #[test]
    fn steps_keep_within_the_stops_that_they_are_near() {
        // Where a joint comes to rest after a step up, the smoothest way swings beyond: one waypoint is free to.
        let values = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let robot = RobotFn {
            waypoints: 9,
            free: [FreeRange::Turn],
            solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 1])| {},
            posture: |_: usize, free: &[f64; 1], _: u32| Some(Posture { joints: *free, rates: [[1.0]] }),
        };
        let times: Vec<f64> = (0..9).map(|k| 0.2 * f64::from(k)).collect();
        let line = Timeline::new(&times, RunIn { pieces: 3, spacing: 0.5 }).unwrap();
        let mut damping = [1e12; 9];
        damping[5] = 1e-6;
        let qp = QpOptions { iterations: 60, tolerance: 1e-10 };
        // Up to a stop above, and down to one below.
        for side in [1.0, -1.0] {
            let nodes = values.map(|value| LadderNode { joints: [side * value], free: [side * value], branch: 0 });
            let step = |stop: f64| {
                let mut bounds = Bounds::NONE;
                (if side > 0.0 { &mut bounds.upper } else { &mut bounds.lower })[0] = side * stop;
                let point = Point::start(&robot, &line, &[0; 9], &nodes, &bounds).unwrap();
                let mut model = Model::new(&line, &bounds, robot.free, &GlobalOptions::default(), None, false);
                side * model.step(&point, &damping, None, &qp).unwrap().waypoints[5][0]
            };
            let (free, held) = (step(f64::INFINITY), step(1.01));
            assert!(free > 0.02 && held < 0.5 * free, "{free} {held}");
            // Stops far off say nothing.
            assert!((step(2.0) - free).abs() < 1e-6);
        }
    }
}
