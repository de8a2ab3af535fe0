//! Short orders of many curves: nearest neighbours, then 2-opt and or-opt.
//!
//! Turning a part of the order round turns its curves round as well, so the ways inside of it stay as long as they were.
//! That makes each try a matter of four distances.

use super::way::{OrderError, TravelCurve, Watch, Way, gap, length};
use nalgebra::Point3;

/// Curves that are moved elsewhere together.
const MOVED: usize = 3;

/// A change must gain more than this share of the way, or rounding could go in circles.
const MIN_GAIN: f64 = 1e-12;

/// Steps of the search at most: some seconds. On layers of up to a thousand curves it ends by itself.
const MAX_STEPS: usize = 1 << 30;

/// Steps from one report to the next: some milliseconds.
const STEPS_PER_REPORT: usize = 1 << 20;

/// A short order from one place to another; the better of what nearest neighbours and the order given lead to.
pub(super) fn order(
    choice: &[Vec<Way>],
    curves: &[TravelCurve],
    from: Option<Point3<f64>>,
    to: Option<Point3<f64>>,
    watch: Watch,
) -> Result<Vec<Way>, OrderError> {
    let mut given: Vec<Way> = choice.iter().map(|ways| ways[0]).collect();
    let mut near = nearest(choice, from);
    improve(&mut near, curves, from, to, watch)?;
    // From two starts: neither is always the better one.
    improve(&mut given, curves, from, to, watch)?;
    Ok(if length(&given, from, to) < length(&near, from, to) { given } else { near })
}

/// Always on to the nearest start.
fn nearest(choice: &[Vec<Way>], from: Option<Point3<f64>>) -> Vec<Way> {
    let mut left: Vec<usize> = (0..choice.len()).collect();
    let mut order: Vec<Way> = Vec::with_capacity(choice.len());
    while !left.is_empty() {
        let at = order.last().map_or(from, |way| Some(way.end));
        let mut best: Option<(f64, usize, Way)> = None;
        for (place, &curve) in left.iter().enumerate() {
            for way in &choice[curve] {
                let far = gap(at, Some(way.start));
                if best.is_none_or(|(least, ..)| far < least) {
                    best = Some((far, place, *way));
                }
            }
        }
        if let Some((_, place, way)) = best {
            left.remove(place);
            order.push(way);
        }
    }
    order
}

/// Turns parts round and moves short parts elsewhere until neither shortens the way.
pub(super) fn improve(
    order: &mut Vec<Way>,
    curves: &[TravelCurve],
    from: Option<Point3<f64>>,
    to: Option<Point3<f64>>,
    watch: Watch,
) -> Result<(), OrderError> {
    let mut search = Search { order, curves, from, to, least: 0.0, steps: 0, next_report: 0, watch };
    // Gains below this are rounding: without a least gain two orders of one length could follow each other for ever.
    search.least = MIN_GAIN * length(search.order, from, to);
    while search.steps < MAX_STEPS && (search.turn()? | search.shift()?) {}
    Ok(())
}

struct Search<'a> {
    order: &'a mut Vec<Way>,
    curves: &'a [TravelCurve<'a>],
    from: Option<Point3<f64>>,
    to: Option<Point3<f64>>,
    least: f64,
    steps: usize,
    /// Steps at which to ask whether to go on.
    next_report: usize,
    watch: Watch<'a>,
}

impl Search<'_> {
    /// Where one comes from before a place, and goes to after it.
    fn before(&self, place: usize) -> Option<Point3<f64>> {
        place.checked_sub(1).map_or(self.from, |k| Some(self.order[k].end))
    }

    fn after(&self, place: usize) -> Option<Point3<f64>> {
        self.order.get(place + 1).map_or(self.to, |way| Some(way.start))
    }

    fn reverse(&mut self, from: usize, to: usize) {
        self.order[from..=to].reverse();
        for way in &mut self.order[from..=to] {
            *way = way.back(&self.curves[way.visit.curve as usize]);
        }
    }

    /// 2-opt, one curve alone included; whether anything was gained.
    fn turn(&mut self) -> Result<bool, OrderError> {
        let mut gained = false;
        for i in 0..self.order.len() {
            for j in i..self.order.len() {
                let (before, behind) = (self.before(i), self.after(j));
                let (start, end) = (Some(self.order[i].start), Some(self.order[j].end));
                // Turned round, the ways inside of the part are as long as before: only those at its ends change.
                let now = gap(before, start) + gap(end, behind);
                if now - gap(before, end) - gap(start, behind) > self.least {
                    self.reverse(i, j);
                    gained = true;
                }
            }
            self.count(self.order.len())?;
        }
        Ok(gained)
    }

    /// Counts steps, and asks now and then whether to go on.
    fn count(&mut self, steps: usize) -> Result<(), OrderError> {
        self.steps += steps;
        if self.steps < self.next_report {
            return Ok(());
        }
        self.next_report = self.steps + STEPS_PER_REPORT;
        (self.watch)()
    }

    /// Or-opt: up to [`MOVED`] curves between two others, either way round; whether anything was gained.
    fn shift(&mut self) -> Result<bool, OrderError> {
        let mut gained = false;
        let count = self.order.len();
        for size in 1..=MOVED.min(count.saturating_sub(1)) {
            for i in 0..=count - size {
                let (start, end) = (Some(self.order[i].start), Some(self.order[i + size - 1].end));
                let (before, behind) = (self.before(i), self.after(i + size - 1));
                // What the part costs where it is.
                let freed = gap(before, start) + gap(end, behind) - gap(before, behind);
                // Between place k - 1 and place k, which are not of the part.
                let mut best: Option<(f64, usize, bool)> = None;
                for k in (0..i).chain(i + size + 1..=count) {
                    let one = self.before(k);
                    let other = self.order.get(k).map_or(self.to, |way| Some(way.start));
                    let whole = gap(one, other);
                    for (turned, first, last) in [(false, start, end), (true, end, start)] {
                        let gain = freed + whole - gap(one, first) - gap(last, other);
                        if gain > best.map_or(self.least, |best| best.0) {
                            best = Some((gain, k, turned));
                        }
                    }
                }
                self.count(count)?;
                let Some((_, k, turned)) = best else {
                    continue;
                };
                if turned {
                    self.reverse(i, i + size - 1);
                }
                if k < i {
                    self.order[k..i + size].rotate_right(size);
                } else {
                    self.order[i..k].rotate_left(size);
                }
                gained = true;
            }
        }
        Ok(gained)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::order::way::ways;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Of what nearest neighbours and the order given lead to, the shorter; each is that at times.
    #[test]
    fn the_better_of_two_starts_is_taken() {
        let (mut by_given, mut by_nearest) = (0, 0);
        for seed in 0..60 {
            let mut draw = Pcg64Mcg::seed_from_u64(seed);
            let mut place = || Point3::from([(); 3].map(|()| 10.0 * draw.random::<f64>()));
            let points: Vec<[Point3<f64>; 2]> = (0..14).map(|_| [place(), place()]).collect();
            let curves: Vec<TravelCurve> = points.iter().map(|points| TravelCurve { points, closed: false }).collect();
            let choice: Vec<Vec<Way>> = curves.iter().zip(0..).map(|(curve, number)| ways(curve, number)).collect();
            let (from, to) = (Some(place()), None);
            let improved = |mut order: Vec<Way>| {
                improve(&mut order, &curves, from, to, &|| Ok(())).unwrap();
                length(&order, from, to)
            };
            let [given, near] = [choice.iter().map(|ways| ways[0]).collect(), nearest(&choice, from)].map(improved);
            let found = length(&order(&choice, &curves, from, to, &|| Ok(())).unwrap(), from, to);
            assert!((found - given.min(near)).abs() < 1e-9, "seed {seed}: {found} of {given} and {near}");
            by_given += usize::from(given < near);
            by_nearest += usize::from(near < given);
        }
        assert!(by_given > 5 && by_nearest > 5, "{by_given} {by_nearest}");
    }
}
