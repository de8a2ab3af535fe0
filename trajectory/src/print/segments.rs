//! The print as it is executed: motions from rest to rest, one after the other.

use super::plan::{PrintPlan, Run, Travel};
use crate::spline::Trajectory;
use crate::transfer::Transfer;
use std::collections::BTreeSet;
use std::ops::Range;

/// Knots of a transfer nearer in time than this, in seconds, are one: where its jerk changes twice at once.
const SAME_KNOT_S: f64 = 1e-6;

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum SegmentKind {
    /// Along a path.
    Print,
    /// Off the end of a path.
    Lift,
    /// From above the end of a path to above the start of the next.
    Transfer,
    /// Down to the start of a path.
    Approach,
}

impl SegmentKind {
    /// All of them, in the order in which they follow each other.
    pub const ALL: [SegmentKind; 4] =
        [SegmentKind::Print, SegmentKind::Lift, SegmentKind::Transfer, SegmentKind::Approach];

    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            SegmentKind::Print => "print",
            SegmentKind::Lift => "lift",
            SegmentKind::Transfer => "transfer",
            SegmentKind::Approach => "approach",
        }
    }
}

/// A motion, and the run that it is or that it leads on from.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a, const N: usize, const F: usize> {
    /// What it is for.
    pub kind: SegmentKind,
    /// The run that it is, or that it leads on from.
    pub run: &'a Run<N, F>,
    way: Way<'a, N>,
}

#[derive(Clone, Copy, Debug)]
enum Way<'a, const N: usize> {
    Spline(&'a Trajectory<N>),
    Lines(&'a Transfer<N>),
}

impl<const N: usize, const F: usize> Segment<'_, N, F> {
    /// In seconds.
    pub fn duration(&self) -> f64 {
        match self.way {
            Way::Spline(spline) => spline.span().1 - spline.span().0,
            Way::Lines(lines) => lines.duration(),
        }
    }

    /// Joints at a time since it began.
    pub fn at(&self, time: f64) -> [f64; N] {
        match self.way {
            Way::Spline(spline) => spline.at(spline.span().0 + time).position,
            Way::Lines(lines) => lines.at(time).position,
        }
    }

    /// Millimetres of filament that are laid by a time since it began; 0 for segments that do not print. A list
    /// [`Run::filament_mm`] that is too short ends with its last entry.
    pub fn filament_mm(&self, time: f64) -> f64 {
        let (SegmentKind::Print, Way::Spline(spline)) = (self.kind, &self.way) else { return 0.0 };
        let (times, filament) = (spline.times(), &self.run.filament_mm);
        let time = time + times[0];
        let after = times.partition_point(|knot| *knot <= time).clamp(1, times.len() - 1);
        let [a, b] = [times[after - 1], times[after]];
        let share = ((time - a) / (b - a)).clamp(0.0, 1.0);
        let (Some(before), Some(next)) = (filament.get(after - 1), filament.get(after)) else {
            return filament.last().copied().unwrap_or(0.0);
        };
        before + (next - before) * share
    }

    /// Times since it began and joints; between them the C2 cubic spline at rest at both ends.
    pub fn knots(&self) -> Vec<(f64, [f64; N])> {
        match self.way {
            Way::Spline(spline) => {
                let (first, _) = spline.span();
                spline.times().iter().zip(spline.joints()).map(|(time, joints)| (time - first, *joints)).collect()
            }
            Way::Lines(lines) => {
                let mut times = lines.knots();
                let end = lines.duration();
                times.retain(|time| *time < end - SAME_KNOT_S);
                times.dedup_by(|later, earlier| *later < *earlier + SAME_KNOT_S);
                times.push(end);
                times.into_iter().map(|time| (time, lines.at(time).position)).collect()
            }
        }
    }
}

impl<const N: usize, const F: usize> PrintPlan<N, F> {
    /// The motions of some runs, of the travels behind them, and of the ways from home and back. Those of no length are left out.
    ///
    /// # Panics
    /// When it comes to a run that is not there.
    pub fn segments(&self, runs: Range<usize>) -> impl Iterator<Item = Segment<'_, N, F>> {
        runs.flat_map(move |number| {
            let run = &self.runs[number];
            let travel = self.travels.get(number).and_then(Option::as_ref);
            let (arrival, departure) = self.homes.get(number).map_or((None, None), |(a, d)| (a.as_ref(), d.as_ref()));
            let before = arrival.into_iter().flat_map(|arrival| {
                [
                    (SegmentKind::Transfer, Way::Lines(&arrival.way)),
                    (SegmentKind::Approach, Way::Spline(&arrival.approach)),
                ]
            });
            let behind = travel.into_iter().flat_map(|travel| {
                [
                    (SegmentKind::Lift, Way::Spline(&travel.lift)),
                    (SegmentKind::Transfer, Way::Lines(&travel.way)),
                    (SegmentKind::Approach, Way::Spline(&travel.approach)),
                ]
            });
            let back = departure.into_iter().flat_map(|departure| {
                [(SegmentKind::Lift, Way::Spline(&departure.lift)), (SegmentKind::Transfer, Way::Lines(&departure.way))]
            });
            let print = [(SegmentKind::Print, Way::Spline(&run.trajectory))];
            let all = before.chain(print).chain(behind).chain(back);
            all.map(move |(kind, way)| Segment { kind, run, way }).filter(|segment| segment.duration() > SAME_KNOT_S)
        })
    }

    /// The plan without some of its motions. A run goes, with the travels to and from it; a travel goes as if it had not been
    /// found. A run goes with the way from home to it and with the way home from it. Of what is left, ways home are to be planned
    /// anew ([`PrintPlan::with_homes`]), and programs begin and end around each of them.
    ///
    /// # Arguments
    /// * `motions`: by their numbers in [`PrintPlan::segments`] of all runs.
    pub fn without(&self, motions: &BTreeSet<usize>) -> Self {
        let (mut runs, mut travels, mut first) = (Vec::new(), Vec::new(), 0);
        for (number, run) in self.runs.iter().enumerate() {
            let kinds: Vec<SegmentKind> = self.segments(number..number + 1).map(|segment| segment.kind).collect();
            let print = first + kinds.iter().position(|kind| *kind == SegmentKind::Print).unwrap_or(0);
            let last = first + kinds.len();
            let leads_home = self.homes.get(number).is_some_and(|(_, departure)| departure.is_some());
            let any = |segments: Range<usize>| motions.range(segments).next().is_some();
            let is_gone = any(first..print + 1) || (leads_home && any(print + 1..last));
            if is_gone {
                travels.last_mut().into_iter().for_each(|to: &mut Option<Travel<N>>| *to = None);
            } else {
                runs.push(run.clone());
                travels.push(self.travels.get(number).cloned().flatten().filter(|_| !any(print + 1..last)));
            }
            first += kinds.len();
        }
        travels.pop();
        let mut plan = PrintPlan { runs, travels, homes: Vec::new(), ..self.clone() };
        plan.count_times();
        plan
    }
}
