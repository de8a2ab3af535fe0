//! A quadratic program without the stages that no inequality touches.
//!
//! Iterations of the interior-point method change the weights of inequalities alone. On a path that comes near its bounds
//! at a few places, most stages have none: what they ask of their neighbours is always the same. So they are eliminated
//! once. With `u` for their unknowns (variables and multipliers of equations) and `t` for those that stay, the
//! conditions of optimality are `K y + r + A^T z = 0`, and `u = -K_uu^-1 (K_ut t + r_u)` leaves
//! `K_tt - K_tu K_uu^-1 K_ut` and `r_t - K_tu K_uu^-1 r_u`, again with blocks between neighbours only. Multipliers that stay
//! are variables of the smaller problem, along which it is concave: not a minimum is sought there but a saddle, which to
//! the method is the same.

use super::interior::{ACCEPTABLE_TOLERANCES, Interior};
use super::layout::Layout;
use super::options::QpOptions;
use super::problem::BandedQp;
use super::solution::{QpSolution, QpStatus};
use crate::banded::{BlockTridiagonal, inner};
use std::ops::Range;

/// Fewer stages in a row than this stay: eliminating them would save nothing.
const MIN_ELIMINATED_STAGES: usize = 3;

/// Where an unknown went, and its number there.
#[derive(Clone, Copy, Debug)]
enum Place {
    Kept(usize),
    Gone(usize),
}

/// Stages in a row that are eliminated.
struct Segment {
    /// Their stages and unknowns in the band.
    stages: Range<usize>,
    unknowns: Range<usize>,
}

/// The smaller problem and the way back.
pub(super) struct Condensed<'a> {
    full: &'a BandedQp,
    layout: Layout,
    small: BandedQp,
    /// One an unknown, border last.
    places: Vec<Place>,
    /// `K_uu`: its entries, and factored.
    inner: Vec<(usize, usize, f64)>,
    band: BlockTridiagonal,
    segments: Vec<Segment>,
    /// `K_ut`: which unknown that stays, which one that goes.
    joining: Vec<(usize, usize, f64)>,
    /// `r_u`.
    right: Vec<f64>,
}

impl<'a> Condensed<'a> {
    /// The problem without stages that have no inequality; `None` where that saves nothing or where what goes is singular.
    pub fn new(full: &'a BandedQp) -> Option<Self> {
        let layout = Layout::of(full);
        let kept = kept(full, &layout);
        if kept.iter().all(|&kept| kept) {
            return None;
        }
        let (mut sizes, mut band_sizes, mut signs, mut band_signs) = (vec![], vec![], vec![], vec![]);
        let (mut places, mut segments) = (vec![], Vec::<Segment>::new());
        let mut next = 0;
        let mut follows_gone = false;
        for (&size, &kept) in layout.sizes.iter().zip(&kept) {
            let own = &layout.signs[next..next + size];
            next += size;
            if kept {
                places.extend((signs.len()..).take(size).map(Place::Kept));
                signs.extend_from_slice(own);
                sizes.push(size);
            } else {
                if !follows_gone {
                    // An empty stage, so that nothing joins it to the segment before.
                    band_sizes.push(0);
                    let (stage, unknown) = (band_sizes.len(), band_signs.len());
                    segments.push(Segment { stages: stage..stage, unknowns: unknown..unknown });
                }
                places.extend((band_signs.len()..).take(size).map(Place::Gone));
                band_signs.extend_from_slice(own);
                band_sizes.push(size);
                let segment = segments.last_mut()?;
                (segment.stages.end, segment.unknowns.end) = (band_sizes.len(), band_signs.len());
            }
            follows_gone = !kept;
        }
        places.extend((signs.len()..).take(full.border).map(Place::Kept));
        let mut small = BandedQp::new(&sizes, full.border);
        small.signs = signs;
        small.constant = full.constant;
        let right = vec![0.0; band_signs.len()];
        let band = BlockTridiagonal::new(&band_sizes, band_signs);
        let (inner, joining) = (vec![], vec![]);
        let mut condensed = Condensed { full, layout, small, places, inner, band, segments, joining, right };
        condensed.sort_out();
        (condensed.band.factor() == 0).then(|| {
            condensed.eliminate();
            condensed
        })
    }

    /// Puts each entry and each row where it belongs.
    fn sort_out(&mut self) {
        let Condensed { full, layout, small, places, inner, band, joining, right, .. } = self;
        let place = |variable: u32| places[layout.of_variable(variable)];
        let mut add = |a: Place, b: Place, value: f64| match (a, b) {
            (Place::Kept(a), Place::Kept(b)) => small.add_quadratic(a, b, value),
            (Place::Kept(kept), Place::Gone(gone)) | (Place::Gone(gone), Place::Kept(kept)) => {
                joining.push((kept, gone, value));
            }
            (Place::Gone(a), Place::Gone(b)) => {
                band.add(band.slot(a, b), value);
                inner.push((a, b, value));
            }
        };
        for &(a, b, value) in &full.quadratic {
            add(place(a), place(b), value);
        }
        for &(row, multiplier) in &layout.equations {
            for &(variable, value) in full.terms_of(row as usize) {
                add(places[multiplier as usize], place(variable), value);
            }
        }
        let mut pull = |at: Place, value: f64| match at {
            Place::Kept(at) => small.add_linear(at, value),
            Place::Gone(at) => right[at] += value,
        };
        for (variable, &value) in (0..).zip(&full.linear) {
            pull(place(variable), value);
        }
        for &(row, multiplier) in &layout.equations {
            pull(places[multiplier as usize], -full.rows[row as usize].upper);
        }
        let mut terms = Vec::new();
        for (row, bounds) in full.rows.iter().enumerate().filter(|(_, bounds)| !bounds.is_equation()) {
            terms.clear();
            terms.extend(full.terms_of(row).iter().filter_map(|&(variable, by)| match place(variable) {
                Place::Kept(at) => Some((at, by)),
                Place::Gone(_) => None,
            }));
            small.add_soft_row(&terms, bounds.lower, bounds.upper, bounds.penalty);
        }
    }

    /// Adds to the smaller problem what the factored segments leave on their neighbours: with `K_uu = L D L^T` the products
    /// of the columns of `L^-1 K_ut` and `L^-1 r_u`, divided by `D`.
    fn eliminate(&mut self) {
        let Condensed { small, band, segments, joining, right, .. } = self;
        joining.sort_unstable_by_key(|&(kept, gone, _)| (gone, kept));
        let mut rest = &joining[..];
        for Segment { stages, unknowns } in segments {
            let (own, others) = rest.split_at(rest.partition_point(|&(_, gone, _)| gone < unknowns.end));
            rest = others;
            let mut names: Vec<usize> = own.iter().map(|&(kept, ..)| kept).collect();
            names.sort_unstable();
            names.dedup();
            // Each from the stage of its first entry on; behind them the right-hand side.
            let mut columns: Vec<(usize, Vec<f64>)> = Vec::with_capacity(names.len() + 1);
            for name in &names {
                let entries = || own.iter().filter(|(kept, ..)| kept == name).map(|&(_, gone, value)| (gone, value));
                let stage = entries().next().map_or(stages.start, |(gone, _)| band.stage_of(gone));
                let begin = band.first_of(stage);
                let mut column = vec![0.0; unknowns.end - begin];
                entries().for_each(|(gone, value)| column[gone - begin] += value);
                band.forward(stage..stages.end, &mut column);
                columns.push((begin, column));
            }
            let mut last = right[unknowns.clone()].to_vec();
            band.forward(stages.clone(), &mut last);
            columns.push((unknowns.start, last));
            for (i, (first, column)) in columns.iter().enumerate() {
                let divided: Vec<f64> =
                    column.iter().zip(&band.pivots()[*first..]).map(|(value, pivot)| value / pivot).collect();
                for (j, (other, values)) in columns[..=i].iter().enumerate() {
                    let from = *first.max(other);
                    let product = inner(&divided[from - first..], &values[from - other..]);
                    match (names.get(i), names.get(j)) {
                        (Some(&a), Some(&b)) => small.add_quadratic(a, b, -product),
                        (None, Some(&b)) => small.add_linear(b, -product),
                        _ => small.constant -= 0.5 * product,
                    }
                }
            }
        }
    }

    /// Solves the problem. `None` where that comes to no end, or where what went has cost so many digits that the solution of
    /// the smaller problem does not solve the whole one.
    pub fn solve(&self, options: &QpOptions, start: Option<&[f64]>) -> Option<QpSolution> {
        let mut first = vec![0.0; self.small.variables()];
        if let Some(start) = start.filter(|start| start.len() == self.full.variables()) {
            for (variable, &value) in (0..).zip(start) {
                if let Place::Kept(at) = self.places[self.layout.of_variable(variable)] {
                    first[at] = value;
                }
            }
        }
        let found = Interior::new(&self.small).solve(options, Some(&first));
        let gone = self.gone(&found.x);
        let value_of = |unknown: usize| match self.places[unknown] {
            Place::Kept(at) => found.x[at],
            Place::Gone(at) => gone[at],
        };
        let x = (0..self.full.variables() as u32).map(|variable| value_of(self.layout.of_variable(variable))).collect();
        let mut duals = vec![0.0; self.full.rows()];
        let inequalities = (0..duals.len()).filter(|&row| !self.full.rows[row].is_equation());
        inequalities.zip(&found.duals).for_each(|(row, &dual)| duals[row] = dual);
        for &(row, multiplier) in &self.layout.equations {
            duals[row as usize] = value_of(multiplier as usize);
        }
        let (solution, worst) = QpSolution::judged(self.full, x, duals, found.status, found.iterations);
        (solution.status == QpStatus::Solved && worst <= ACCEPTABLE_TOLERANCES * options.tolerance).then_some(solution)
    }

    /// What went, given what stayed; refined once.
    fn gone(&self, kept: &[f64]) -> Vec<f64> {
        let mut left: Vec<f64> = self.right.iter().map(|value| -value).collect();
        for &(at, gone, value) in &self.joining {
            left[gone] -= value * kept[at];
        }
        let mut found = left.clone();
        self.band.solve(&mut found);
        for &(a, b, value) in &self.inner {
            left[a] -= value * found[b];
            if a != b {
                left[b] -= value * found[a];
            }
        }
        self.band.solve(&mut left);
        found.iter().zip(&left).map(|(value, by)| value + by).collect()
    }
}

/// Which stages stay: those of inequalities, those that are joined to the border, and those with few others between.
fn kept(qp: &BandedQp, layout: &Layout) -> Vec<bool> {
    let mut kept = vec![false; layout.sizes.len()];
    let mut keep = |stage: Option<usize>| {
        if let Some(stage) = stage {
            kept[stage] = true;
        }
    };
    for (row, bounds) in qp.rows.iter().enumerate() {
        let terms = qp.terms_of(row);
        if !bounds.is_equation() {
            terms.iter().for_each(|&(variable, _)| keep(qp.stage(variable as usize)));
        } else if terms.iter().any(|&(variable, _)| qp.stage(variable as usize).is_none()) {
            keep(Some(qp.home(row).unwrap_or(0)));
        }
    }
    for &(a, b, _) in &qp.quadratic {
        let [a, b] = [a, b].map(|variable| qp.stage(variable as usize));
        if a.is_none() || b.is_none() {
            keep(a);
            keep(b);
        }
    }
    let mut start = 0;
    while let Some(length) = kept[start..].iter().position(|&kept| kept) {
        if length < MIN_ELIMINATED_STAGES {
            kept[start..start + length].fill(true);
        }
        start += length + 1;
    }
    if kept.len() - start < MIN_ELIMINATED_STAGES {
        kept[start..].fill(true);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Numbers in stages, joined by equations over three of them, with inequalities here and there. The equations are like
    /// those of a spline with a `middle` of 4 and lose digits from stage to stage with one of 1.
    fn random(rng: &mut Pcg64, middle: f64) -> BandedQp {
        let sizes: Vec<usize> = (0..rng.random_range(12..40)).map(|_| rng.random_range(1..4)).collect();
        let mut qp = BandedQp::new(&sizes, 1);
        let height = qp.variables() - 1;
        qp.add_square(&[(height, 1.0)], -1.0, 1.0);
        let first = qp.first.clone();
        for stage in 0..sizes.len() {
            for variable in first[stage]..first[stage + 1] {
                qp.add_square(&[(variable, 1.0)], rng.random_range(-2.0..2.0), 10f64.powf(rng.random_range(-3.0..1.0)));
                if stage > 0 {
                    let before = rng.random_range(first[stage - 1]..first[stage]);
                    qp.add_square(&[(variable, 1.0), (before, rng.random_range(-1.0..1.0))], 0.0, 1.0);
                }
            }
            if stage > 0 && stage + 1 < sizes.len() {
                let to = rng.random_range(-1.0..1.0);
                let terms = [(first[stage - 1], 1.0), (first[stage], middle), (first[stage + 1], 1.0)];
                qp.add_row(&terms, to, to);
            }
            if rng.random_bool(0.15) {
                let room = rng.random_range(0.1..0.5);
                match rng.random_range(0..3) {
                    0 => qp.add_soft_row(&[(first[stage], 1.0)], -room, room, 3.0),
                    1 => qp.add_row(&[(first[stage], 1.0), (height, -1.0)], f64::NEG_INFINITY, 0.0),
                    _ => qp.add_soft_row(&[(first[stage + 1] - 1, 1.0), (height, 0.5)], -room, room, 20.0),
                };
            }
        }
        qp
    }

    #[test]
    fn solves_as_the_whole_problem_does() {
        let mut rng = Pcg64::seed_from_u64(11);
        let options = QpOptions::default();
        let (mut condensed, mut missed) = (0, 0);
        for problem in 0..300 {
            let middle = if problem % 3 == 0 { 1.0 } else { 4.0 };
            let qp = random(&mut rng, middle);
            let whole = Interior::new(&qp).solve(&options, None);
            let found = Condensed::new(&qp).and_then(|condensed| condensed.solve(&options, None));
            let Some(found) = found else { continue };
            assert_eq!((found.status, whole.status), (QpStatus::Solved, QpStatus::Solved));
            condensed += usize::from(problem % 3 > 0);
            missed += usize::from(found.duals.iter().any(|dual| (dual.abs() - 3.0).abs() < 1e-6));
            assert!((found.value - whole.value).abs() < 1e-7 * (1.0 + whole.value.abs()));
            assert!((found.value - found.lower_bound).abs() < 1e-6 * (1.0 + whole.value.abs()));
            for (ours, theirs) in found.x.iter().zip(&whole.x).chain(found.duals.iter().zip(&whole.duals)) {
                assert!((ours - theirs).abs() < 1e-4 * (1.0 + theirs.abs()), "{ours} {theirs}");
            }
        }
        // All but a few of the 200 like splines, and not only problems whose soft rows hold.
        assert!(condensed > 180 && missed > 20, "{condensed} {missed}");
    }

    #[test]
    fn stages_with_an_inequality_stay_and_those_between_near_ones() {
        let mut qp = BandedQp::new(&[1; 12], 1);
        (0..13).for_each(|variable| qp.add_square(&[(variable, 1.0)], 1.0, 1.0));
        for stage in [2, 5, 9] {
            qp.add_row(&[(stage, 1.0)], 0.0, 0.5);
        }
        qp.add_quadratic(12, 10, 0.1);
        let stay = kept(&qp, &Layout::of(&qp));
        assert_eq!(stay.iter().map(|&stays| u8::from(stays)).collect::<Vec<_>>(), [1, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1]);
        let found = Condensed::new(&qp).unwrap().solve(&QpOptions::default(), None).unwrap();
        assert!((found.x[2] - 0.5).abs() < 1e-8 && (found.x[7] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn what_is_singular_does_not_go() {
        let mut qp = BandedQp::new(&[1; 12], 0);
        (0..11).for_each(|variable| qp.add_square(&[(variable, 1.0)], 1.0, 1.0));
        qp.add_row(&[(0, 1.0)], 0.0, 0.5);
        assert!(Condensed::new(&qp).is_none());
    }
}
