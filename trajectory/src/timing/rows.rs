//! The rows of the program, as the grid has them.
//!
//! Most rows never come near their limits. They are not stored: the accelerations of all joints follow from the two
//! coefficients of their segment, and the jerks are differences of two accelerations. So looking through all rows streams over three numbers a
//! joint and knot, joints in neighbouring lanes. Only a row that takes part in the Newton step is written out.
//!
//! The rows of a knot, in this order: the jerk of each joint on the segment before it, that on the segment behind it (the same
//! row where the third derivative of the path does not jump), the acceleration of each joint in the segment behind it, the rate of the
//! flow there, and the spike.

use super::row::Row;

/// A row takes part in the Newton step once less than this share of its limit is left. Other rows only bound the length
/// of steps. On a print most rows never take part; with a smaller share steps are cut short more often.
const NEAR: f64 = 0.5;

/// How far the squared pace at a knot may be from the line between its neighbours, as a share of itself. Where all joints
/// turn around, no other row holds it, and a knot far above its neighbours rings through the whole spline. On the random
/// splines of the oracle test the executed duration was 1.2 % above the oracle without this, 0.9 % with 0.3, 0.56 % with 0.1
/// and 0.65 % with 0.05 (before local stretches).
const SPIKE: f64 = 0.12;

/// What the rows of a knot are made of.
#[derive(Clone, Debug)]
pub(super) struct Place<const N: usize> {
    /// In the middle of the segment behind the knot, accelerations are `before beta_k + after beta_{k+1}`; zero behind the last.
    pub before: [f64; N],
    pub after: [f64; N],
    /// By how much the third derivatives by `sigma` jump at the knot.
    pub jump: [f64; N],
    /// Of the segments before and behind the knot; 0 where there is none.
    pub widths: [f64; 2],
}

/// Limits of one knot's rows, above and below.
#[derive(Clone, Debug)]
pub(super) struct Limits<const N: usize> {
    pub acceleration: [[f64; N]; 2],
    /// On the segments before and behind the knot.
    pub jerk: [[[f64; N]; 2]; 2],
}

pub(super) struct Rows<const N: usize> {
    places: Vec<Place<N>>,
    /// Of all knots until limits move.
    common: Limits<N>,
    /// For each segment the coefficients of its two knots; empty without limit of the flow's rate.
    flow: Vec<[f64; 2]>,
    ramp: f64,
    /// For each knot; empty until limits move.
    moved: Vec<Limits<N>>,
    is_near: Vec<bool>,
}

/// What a row limits.
#[derive(Clone, Copy)]
enum Kind {
    /// On the segment before the knot (0) or behind it (1).
    Jerk(usize, usize),
    Acceleration(usize),
    Flow,
    Spike,
}

/// The unknown of a knot: unknown `k` belongs to knot `k + 1`, and the outermost knots share those of their neighbours.
pub(super) fn unknown(segments: usize, knot: usize) -> usize {
    knot.clamp(1, segments - 1) - 1
}

impl<const N: usize> Place<N> {
    /// The distance of the middles of the segments on both sides.
    pub fn distance(&self) -> f64 {
        0.5 * (self.widths[0] + self.widths[1])
    }

    /// What of the jump the difference of accelerations misses on the segments on both sides: it holds the mean of both, by their widths.
    fn shares(&self) -> [f64; 2] {
        [-0.5 * self.widths[1], 0.5 * self.widths[0]]
    }
}

impl<const N: usize> Rows<N> {
    /// Rows of one knot.
    const STRIDE: usize = 3 * N + 2;

    /// # Arguments
    /// * `acceleration`, `jerk`: limits of all joints.
    /// * `flow`: for each segment what the squared paces at its knots count in the rate of the flow; empty for no limit.
    /// * `ramp`: the limit of that rate.
    pub fn new(places: Vec<Place<N>>, [acceleration, jerk]: [[f64; N]; 2], (flow, ramp): (Vec<[f64; 2]>, f64)) -> Self {
        let is_near = vec![false; places.len() * Self::STRIDE];
        let common = Limits { acceleration: [acceleration; 2], jerk: [[jerk; 2]; 2] };
        Rows { places, common, flow, ramp, moved: Vec::new(), is_near }
    }

    pub fn segments(&self) -> usize {
        self.places.len() - 1
    }

    pub fn place(&self, knot: usize) -> &Place<N> {
        &self.places[knot]
    }

    fn limits(&self, knot: usize) -> &Limits<N> {
        self.moved.get(knot).unwrap_or(&self.common)
    }

    /// Limits of all knots' rows, to be moved.
    pub fn moved(&mut self) -> &mut [Limits<N>] {
        if self.moved.is_empty() {
            self.moved = vec![self.common.clone(); self.places.len()];
        }
        &mut self.moved
    }

    /// The squared pace at a knot.
    fn square(&self, x: &[f64], knot: usize) -> f64 {
        x[unknown(self.segments(), knot)]
    }

    /// Accelerations in the middle of the segment behind a knot; zero behind the last.
    fn accelerations(&self, x: &[f64], knot: usize) -> [f64; N] {
        let place = &self.places[knot];
        let (from, to) = (self.square(x, knot), self.square(x, knot + 1));
        std::array::from_fn(|j| place.before[j] * from + place.after[j] * to)
    }

    /// Calls `look` for each knot with the accelerations in the middle of the segment behind it, and with the differences that are the jerks
    /// on the segments on both sides, times the distance of their middles and over the root of the squared pace.
    pub fn each_knot(&self, x: &[f64], mut look: impl FnMut(usize, &[f64; N], &[[f64; N]; 2])) {
        let mut previous = [0.0; N];
        for (knot, place) in self.places.iter().enumerate() {
            let behind = self.accelerations(x, knot);
            let at = self.square(x, knot);
            let jerks = place
                .shares()
                .map(|share| std::array::from_fn(|j| behind[j] - previous[j] + share * at * place.jump[j]));
            look(knot, &behind, &jerks);
            previous = behind;
        }
    }

    /// The rate of the flow in the segment behind a knot.
    fn flow_rate(&self, x: &[f64], knot: usize) -> f64 {
        let [from, to] = self.flow.get(knot).copied().unwrap_or([0.0; 2]);
        from * self.square(x, knot) + to * self.square(x, knot + 1)
    }

    /// How far the squared pace at a knot is from the line between its neighbours, as coefficients of the three unknowns from `knot - 2` on;
    /// `None` at the outermost knots.
    fn spike(&self, knot: usize) -> Option<[f64; 3]> {
        let [w, v] = self.places[knot].widths;
        (2..self.segments() - 1).contains(&knot).then(|| [-v / (w + v), 1.0, -w / (w + v)])
    }

    /// The least constant by which all unknowns must rise until no spike leaves less than a tenth of its limit: a constant leaves second differences and
    /// allows more of them.
    pub fn missing(&self, x: &[f64]) -> f64 {
        let mut more = 0.0f64;
        for knot in 2..self.segments().max(3) - 1 {
            let Some([a, b, c]) = self.spike(knot) else { continue };
            let value = a * x[knot - 2] + b * x[knot - 1] + c * x[knot];
            more = more.max(value.abs() / (0.9 * SPIKE) - x[knot - 1]);
        }
        more
    }

    /// The least share of limit and value of all rows but spikes, with limits that are constant and with those that go with the inverse
    /// of a root: by so much values may grow, with the unknowns as they are.
    pub fn least_shares(&self, x: &[f64]) -> [f64; 2] {
        let [mut constant, mut rooted] = [f64::INFINITY; 2];
        self.each_knot(x, |knot, accelerations, jerks| {
            let limits = self.limits(knot);
            let mut least = [f64::INFINITY; 2];
            for j in 0..N {
                let limit = |[above, below]: &[[f64; N]; 2], value: f64| {
                    (if value > 0.0 { above[j] } else { below[j] }) / value.abs()
                };
                least[0] = least[0].min(limit(&limits.acceleration, accelerations[j]));
                for side in 0..2 {
                    least[1] = least[1].min(limit(&limits.jerk[side], jerks[side][j]));
                }
            }
            constant = constant.min(least[0]).min(self.ramp / self.flow_rate(x, knot).abs());
            rooted = rooted.min(least[1] * self.places[knot].distance() / self.square(x, knot).sqrt());
        });
        [constant, rooted]
    }

    /// Appends the rows that are near their limits at these unknowns, and were not before.
    pub fn find_near(&self, x: &[f64], found: &mut Vec<usize>) {
        const LEFT: f64 = 1.0 - NEAR;
        self.each_knot(x, |knot, accelerations, jerks| {
            let limits = self.limits(knot);
            let scale = LEFT * self.places[knot].distance() / self.square(x, knot).sqrt();
            let mut is_any = false;
            for j in 0..N {
                let above = |limits: &[[f64; N]; 2], value: f64, scale: f64| {
                    (value > limits[0][j] * scale) | (-value > limits[1][j] * scale)
                };
                is_any |= above(&limits.acceleration, accelerations[j], LEFT)
                    | above(&limits.jerk[0], jerks[0][j], scale)
                    | above(&limits.jerk[1], jerks[1][j], scale);
            }
            let flow = self.flow_rate(x, knot).abs() > LEFT * self.ramp;
            let spike = self.spike(knot).is_some_and(|[a, b, c]| {
                (a * x[knot - 2] + b * x[knot - 1] + c * x[knot]).abs() > LEFT * SPIKE * x[knot - 1]
            });
            if !(is_any || flow || spike) {
                return;
            }
            let first = knot * Self::STRIDE;
            for (at, is_near) in self.is_near[first..first + Self::STRIDE].iter().enumerate() {
                let above = |limits: &[f64; 2], value: f64| value > limits[0] || -value > limits[1];
                let beyond = match Self::kind(at) {
                    Kind::Jerk(1, joint) if self.places[knot].jump[joint] == 0.0 => false,
                    Kind::Jerk(side, joint) => {
                        above(&limits.jerk[side].map(|limits| limits[joint] * scale), jerks[side][joint])
                    }
                    Kind::Acceleration(joint) => {
                        above(&limits.acceleration.map(|limits| limits[joint] * LEFT), accelerations[joint])
                    }
                    Kind::Flow => flow,
                    Kind::Spike => spike,
                };
                if beyond && !is_near {
                    found.push(first + at);
                }
            }
        });
    }

    fn kind(at: usize) -> Kind {
        match at.checked_div(N).unwrap_or(3) {
            side @ 0..2 => Kind::Jerk(side, at % N),
            2 => Kind::Acceleration(at % N),
            _ if at == 3 * N => Kind::Flow,
            _ => Kind::Spike,
        }
    }

    /// From now on the row takes part.
    pub fn mark(&mut self, row: usize) {
        self.is_near[row] = true;
    }

    /// No row takes part.
    pub fn unmark(&mut self) {
        self.is_near.fill(false);
    }

    /// Writes a row out.
    pub fn row(&self, row: usize) -> Row {
        let (knot, at) = (row / Self::STRIDE, row % Self::STRIDE);
        let place = &self.places[knot];
        let unknown = |knot: usize| unknown(self.segments(), knot);
        let none = (0, 0.0);
        let behind = |j: usize| [(unknown(knot), place.before[j]), (unknown(knot + 1), place.after[j])];
        match Self::kind(at) {
            Kind::Jerk(side, joint) => {
                let mut terms = [none; 4];
                if knot > 0 {
                    let before = &self.places[knot - 1];
                    terms[0] = (unknown(knot - 1), -before.before[joint]);
                    terms[1] = (unknown(knot), -before.after[joint]);
                }
                [terms[2], terms[3]] = behind(joint);
                terms[2].1 += place.shares()[side] * place.jump[joint];
                let limits = self.limits(knot).jerk[side].map(|limits| limits[joint] * place.distance());
                Row::of(terms, Some(unknown(knot)), limits)
            }
            Kind::Acceleration(joint) => {
                let [c, d] = behind(joint);
                Row::of([c, d, none, none], None, self.limits(knot).acceleration.map(|limits| limits[joint]))
            }
            Kind::Flow => {
                let [from, to] = self.flow.get(knot).copied().unwrap_or([0.0; 2]);
                Row::of([(unknown(knot), from), (unknown(knot + 1), to), none, none], None, [self.ramp; 2])
            }
            Kind::Spike => {
                let by = self.spike(knot).unwrap_or([0.0; 3]);
                Row { first: knot.max(2) - 2, by, root: Some(1), is_linear: true, limits: [SPIKE; 2] }
            }
        }
    }
}
