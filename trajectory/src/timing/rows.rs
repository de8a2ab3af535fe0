//! The rows of the program, as the grid has them.
//!
//! Most rows never come near their limits. They are not stored: the accelerations of all joints follow from the two
//! coefficients of their segment, and the jerks are differences of two accelerations. So looking through all rows streams over three numbers a
//! joint and knot, joints in neighbouring lanes. Only a row that takes part in the Newton step is written out.
//!
//! The rows of a knot, in this order: the jerk of each joint on the segment before it, that on the segment behind it (the same
//! row where the third derivative of the path does not jump), the acceleration of each joint in the segment behind it, the rate of the
//! flow there, and the spike.

pub(super) use super::place::{Kind, unknown};
use super::place::{KnotNear, Limits, Place, most_beyond, most_share};
use super::row::Row;
use std::ops::Range;

/// A row takes part in the Newton step once less than this share of its limit is left. Other rows only bound the length
/// of steps. On a print most rows never take part; with a smaller share steps are cut short more often.
const NEAR: f64 = 0.5;

/// How far the squared pace at a knot may be from the line between its neighbours, as a share of itself. Where all joints
/// turn around, no other row holds it, and a knot far above its neighbours rings through the whole spline. On the random
/// splines of the oracle test the executed duration was 1.2 % above the oracle without this, 0.9 % with 0.3, 0.56 % with 0.1
/// and 0.65 % with 0.05 (before times were scaled locally).
const SPIKE: f64 = 0.12;

pub(super) struct Rows<const N: usize> {
    places: Vec<Place<N>>,
    /// Of all knots until limits move.
    common: Limits<N>,
    /// One over the limits of acceleration and jerk.
    inverse: [[f64; N]; 2],
    /// For each segment the coefficients of its two knots; empty without limit of the flow's rate.
    flow: Vec<[f64; 2]>,
    ramp: f64,
    /// For each knot; empty until limits move.
    moved: Vec<Limits<N>>,
    near: Vec<KnotNear<N>>,
}

impl<const N: usize> Rows<N> {
    /// Rows of one knot.
    const STRIDE: usize = 3 * N + 2;

    /// # Arguments
    /// * `acceleration`, `jerk`: limits of all joints.
    /// * `flow`: for each segment what the squared paces at its knots count in the rate of the flow; empty for no limit.
    /// * `ramp`: the limit of that rate.
    pub fn new(places: Vec<Place<N>>, [acceleration, jerk]: [[f64; N]; 2], (flow, ramp): (Vec<[f64; 2]>, f64)) -> Self {
        let near = places.iter().map(Place::none_near).collect();
        let common = Limits { acceleration: [acceleration; 2], jerk: [[jerk; 2]; 2] };
        let inverse = [acceleration, jerk].map(|limits| limits.map(f64::recip));
        Rows { places, common, inverse, flow, ramp, moved: Vec::new(), near }
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

    /// Calls `change` with the two limits of each row but those of flow and spikes.
    pub fn move_limits(&mut self, change: impl Fn(&Rows<N>, usize, Kind, [&mut f64; 2])) {
        let mut moved = std::mem::take(&mut self.moved);
        moved.resize(self.places.len(), self.common.clone());
        for (knot, limits) in moved.iter_mut().enumerate() {
            let Limits { acceleration: [above, below], jerk } = limits;
            for (joint, ends) in above.iter_mut().zip(below).enumerate() {
                change(self, knot, Kind::Acceleration(joint), ends.into());
            }
            for (side, [above, below]) in jerk.iter_mut().enumerate() {
                for (joint, ends) in above.iter_mut().zip(below).enumerate() {
                    change(self, knot, Kind::Jerk(side, joint), ends.into());
                }
            }
        }
        self.moved = moved;
    }

    /// The squared pace at a knot.
    #[inline]
    fn square(&self, x: &[f64], knot: usize) -> f64 {
        x[unknown(self.segments(), knot)]
    }

    /// Accelerations in the middle of the segment behind a knot; zero behind the last.
    #[inline]
    fn accelerations(&self, x: &[f64], knot: usize) -> [f64; N] {
        let place = &self.places[knot];
        let (from, to) = (self.square(x, knot), self.square(x, knot + 1));
        let mut accelerations = [0.0; N];
        (0..N).for_each(|j| accelerations[j] = place.before[j] * from + place.after[j] * to);
        accelerations
    }

    /// Calls `look` for each of these knots with the accelerations in the middle of the segment behind it, and with the differences that are the jerks
    /// on the segments on both sides, times the distance of their middles and over the root of the squared pace.
    pub fn each_knot(&self, x: &[f64], knots: Range<usize>, mut look: impl FnMut(usize, &[f64; N], &[[f64; N]; 2])) {
        let mut previous = knots.start.checked_sub(1).map_or([0.0; N], |before| self.accelerations(x, before));
        for (knot, place) in self.places.iter().enumerate().take(knots.end).skip(knots.start) {
            let behind = self.accelerations(x, knot);
            let at = self.square(x, knot);
            let (before, after) = (-0.5 * place.widths[1] * at, 0.5 * place.widths[0] * at);
            let mut jerks = [[0.0; N]; 2];
            for j in 0..N {
                let difference = behind[j] - previous[j];
                jerks[0][j] = difference + before * place.jump[j];
                jerks[1][j] = difference + after * place.jump[j];
            }
            look(knot, &behind, &jerks);
            previous = behind;
        }
    }

    /// The rate of the flow in the segment behind a knot.
    #[inline]
    fn flow_rate(&self, x: &[f64], knot: usize) -> f64 {
        let [from, to] = self.flow.get(knot).copied().unwrap_or([0.0; 2]);
        from * self.square(x, knot) + to * self.square(x, knot + 1)
    }

    /// How far the squared pace at a knot is from the line between its neighbours, as coefficients of the three unknowns from `knot - 2` on;
    /// `None` at the outermost knots.
    #[inline]
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
        self.each_knot(x, 0..self.places.len(), |knot, accelerations, jerks| {
            let limits = self.limits(knot);
            let root = self.places[knot].distance() / self.square(x, knot).sqrt();
            let [acceleration, jerk] = if self.moved.is_empty() {
                self.rates(accelerations, jerks)
            } else {
                let jerk = most_share(&limits.jerk[0], &jerks[0]).max(most_share(&limits.jerk[1], &jerks[1]));
                [most_share(&limits.acceleration, accelerations), jerk]
            };
            constant = constant.min(1.0 / acceleration).min(self.ramp / self.flow_rate(x, knot).abs());
            rooted = rooted.min(root / jerk);
        });
        [constant, rooted]
    }

    /// The greatest shares of accelerations and of jerks in the limits that no row has moved.
    #[inline]
    fn rates(&self, accelerations: &[f64; N], jerks: &[[f64; N]; 2]) -> [f64; 2] {
        let most = |values: &[f64; N], inverse: &[f64; N], mut most: f64| {
            for j in 0..N {
                let rate = values[j].abs() * inverse[j];
                most = if rate > most { rate } else { most };
            }
            most
        };
        let [acceleration, jerk] = &self.inverse;
        [most(accelerations, acceleration, 0.0), most(&jerks[1], jerk, most(&jerks[0], jerk, 0.0))]
    }

    /// Appends the rows of these knots that are near their limits at these unknowns, and were not before.
    pub fn find_near(&self, x: &[f64], knots: Range<usize>, found: &mut Vec<usize>) {
        const LEFT: f64 = 1.0 - NEAR;
        self.each_knot(x, knots, |knot, accelerations, jerks| {
            let limits = self.limits(knot);
            let scale = LEFT * self.places[knot].distance() / self.square(x, knot).sqrt();
            let spike = self.spike(knot).is_some_and(|[a, b, c]| {
                (a * x[knot - 2] + b * x[knot - 1] + c * x[knot]).abs() > LEFT * SPIKE * x[knot - 1]
            });
            let flow = self.flow_rate(x, knot).abs() > LEFT * self.ramp;
            let is_beyond = if self.moved.is_empty() {
                self.rates(accelerations, jerks).iter().zip([LEFT, scale]).any(|(rate, limit)| *rate >= limit)
            } else {
                most_beyond(&limits.acceleration, accelerations, LEFT) > 0.0
                    || jerks.iter().zip(&limits.jerk).any(|(jerks, limits)| most_beyond(limits, jerks, scale) > 0.0)
            };
            if !(is_beyond || flow || spike) {
                return;
            }
            let (first, near) = (knot * Self::STRIDE, &self.near[knot]);
            let kinds = [
                (&limits.jerk[0], &jerks[0], scale),
                (&limits.jerk[1], &jerks[1], scale),
                (&limits.acceleration, accelerations, LEFT),
            ];
            for (kind, ([above, below], values, scale)) in kinds.into_iter().enumerate() {
                for j in 0..N {
                    let is_beyond = values[j] > above[j] * scale || -values[j] > below[j] * scale;
                    if is_beyond && near.joints[j] >> kind & 1 == 0 {
                        found.push(first + kind * N + j);
                    }
                }
            }
            for (at, is_new) in [flow && !near.others[0], spike && !near.others[1]].into_iter().enumerate() {
                if is_new {
                    found.push(first + 3 * N + at);
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
        let (knot, kind) = self.what(row);
        let near = &mut self.near[knot];
        match kind {
            Kind::Jerk(side, joint) => near.joints[joint] |= 1 << side,
            Kind::Acceleration(joint) => near.joints[joint] |= 1 << 2,
            Kind::Flow => near.others[0] = true,
            Kind::Spike => near.others[1] = true,
        }
    }

    /// No row takes part.
    pub fn unmark(&mut self) {
        self.near = self.places.iter().map(Place::none_near).collect();
    }

    /// The knot of a row, and what it limits.
    pub fn what(&self, row: usize) -> (usize, Kind) {
        (row / Self::STRIDE, Self::kind(row % Self::STRIDE))
    }

    /// Writes a row out.
    pub fn row(&self, row: usize) -> Row {
        let (knot, kind) = self.what(row);
        let place = &self.places[knot];
        let unknown = |knot: usize| unknown(self.segments(), knot);
        let none = (0, 0.0);
        let behind = |j: usize| [(unknown(knot), place.before[j]), (unknown(knot + 1), place.after[j])];
        match kind {
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    const KNOTS: usize = 13;

    fn rows(rng: &mut Pcg64, moves: bool) -> Rows<3> {
        let mut any = || [0; 3].map(|_| rng.random_range(-1.0..1.0));
        let mut places: Vec<Place<3>> = (0..KNOTS)
            .map(|knot| Place {
                before: any(),
                after: any(),
                jump: if knot % 4 == 2 { any() } else { [0.0; 3] },
                widths: [knot, KNOTS - 1 - knot].map(|left| if left == 0 { 0.0 } else { 0.3 }),
            })
            .collect();
        (places[KNOTS - 1].before, places[KNOTS - 1].after, places[6].jump[1]) = ([0.0; 3], [0.0; 3], 0.0);
        let flow = (1..KNOTS).map(|_| [rng.random_range(-1.0..0.0), rng.random_range(0.0..1.0)]).collect();
        let mut rows = Rows::new(places, [[2.0, 1.0, f64::INFINITY], [5.0, f64::INFINITY, 4.0]], (flow, 0.7));
        if moves {
            rows.move_limits(|_, knot, _, limits| {
                limits.into_iter().enumerate().for_each(|(end, to)| *to *= 1.0 + 0.3 * ((knot + end) as f64).sin());
            });
        }
        rows
    }

    /// Rows are found without being written out; each that is written out agrees.
    #[test]
    fn near_rows_are_those_that_leave_less_than_half_of_their_limit() {
        let mut rng = Pcg64::seed_from_u64(4);
        let (mut near, mut total) = (0, 0);
        for case in 0..60 {
            let mut rows = rows(&mut rng, case % 2 == 1);
            let x: Vec<f64> = (0..KNOTS - 2).map(|_| rng.random_range(0.4..2.0)).collect();
            let is_near = |rows: &Rows<3>, number: usize| {
                let (knot, kind) = rows.what(number);
                let exists = match kind {
                    Kind::Jerk(1, joint) => rows.place(knot).jump[joint] != 0.0,
                    Kind::Acceleration(_) | Kind::Flow => knot + 1 < KNOTS,
                    Kind::Spike => (2..KNOTS - 2).contains(&knot),
                    Kind::Jerk(..) => true,
                };
                if !exists {
                    return false;
                }
                let row = rows.row(number);
                let (value, scale) = (row.value(&x), 0.5 * row.scale(&x));
                value > row.limits[0] * scale || -value > row.limits[1] * scale
            };
            let all = 0..KNOTS * Rows::<3>::STRIDE;
            let expected: Vec<usize> = all.clone().filter(|&number| is_near(&rows, number)).collect();
            let mut found = Vec::new();
            rows.find_near(&x, 0..5, &mut found);
            rows.find_near(&x, 5..KNOTS, &mut found);
            assert_eq!(found, expected, "case {case}");
            (near, total) = (near + found.len(), total + all.len());
            // What takes part is not found again.
            found.iter().for_each(|&number| rows.mark(number));
            let mut again = Vec::new();
            rows.find_near(&x, 0..KNOTS, &mut again);
            assert_eq!(again, [0; 0], "case {case}");
            rows.unmark();
            rows.find_near(&x, 0..KNOTS, &mut again);
            assert_eq!(again, expected, "case {case}");
        }
        assert!(near > total / 20 && near < total / 2, "{near} of {total}");
    }

    /// Unknowns times the largest factor are on the boundary of a row, and beyond none.
    #[test]
    fn the_least_shares_are_those_of_rows_written_out() {
        let mut rng = Pcg64::seed_from_u64(5);
        for case in 0..60 {
            let rows = rows(&mut rng, case % 2 == 1);
            let x: Vec<f64> = (0..KNOTS - 2).map(|_| rng.random_range(0.4..2.0)).collect();
            let mut least = [f64::INFINITY; 2];
            for row in (0..KNOTS * Rows::<3>::STRIDE).map(|number| rows.row(number)).filter(|row| !row.is_linear) {
                let value = row.value(&x);
                let limit = row.limits[usize::from(value <= 0.0)] * row.scale(&x);
                let of = &mut least[usize::from(row.root.is_some())];
                *of = of.min(limit / value.abs());
            }
            let found = rows.least_shares(&x);
            assert!((0..2).all(|of| (found[of] / least[of] - 1.0).abs() < 1e-12), "{case}: {found:?} {least:?}");
        }
    }
}
