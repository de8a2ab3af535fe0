//! The steps of a print as moves with blends.

use super::cruise::cruise;
use super::lag;
use super::lines::{self, Sample, chord, part_in_hand, sampled};
use super::options::{BlendOptions, BlendedSegment};
use super::span::spans;
use super::ways;
use crate::print_program::PrintKnot;
use crate::print_program::dropped::{PrintSteps, count};
use crate::print_program::stream::by_joints;
use crate::print_program::targets::external;
use crate::program::{Goal, Move, SPEED_FACTORS, Speed, Step, Zone};
use crate::workcell::Workcell;
use std::cell::Cell;
use std::rc::Rc;

/// The steps of a print as few moves with blends: by joints to the first sample, then each segment from rest to rest.
///
/// A segment that prints is lines with the extruder on and the speed of the filament of the plan's bead; all others are moves by joints. Where the path
/// turns back, and where the filament starts or stops within a segment, the tool stops. A segment of less than two samples gives no step; one with a posture beyond
/// the limits of a table gives none either and is counted ([`PrintSteps::dropped`]).
///
/// With [`BlendOptions::lag_s`] the speed of the filament is that of the plan so much later, and the extruder is switched on as much before the end of the travel that
/// leads to a segment, where the tool stops. Without such a travel the filament of the lag at the begin of the segment is missing. For a segment that takes less than
/// twice the lag, the lag is half of its time. When all filament has been asked for, it nearly stops (0.001 mm/s), and the extruder is switched off at the end, since a
/// signal to stop comes only at rest.
///
/// For an arm without a table these steps are a URScript of `movep` and `movej`
/// ([`Straight::MoveP`](crate::program::Straight::MoveP), [`UrScriptOptions::of_workcell`](crate::program::UrScriptOptions::of_workcell)).
///
/// # Cost
/// A forward kinematics a sample, and up to some tens of interpolations; memory for one segment.
///
/// # Example
/// ```
/// use curvlay_kinematics::print_program::{BlendOptions, BlendedSegment, PrintKnot, print_blended};
/// use curvlay_kinematics::program::{Goal, Move, Step};
/// use curvlay_kinematics::workcell::AnyWorkcell;
/// # #[cfg(feature = "serde")] {
/// let file = include_str!("../../../../examples/cells/ur3.json");
/// let AnyWorkcell::Six(workcell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has a table".into()) };
/// // A second along a bow of 17 degrees at the shoulder, 200 samples.
/// let at = |k: usize| {
///     let time_s = 0.005 * k as f64;
///     PrintKnot { time_s, joints: [0.3 * time_s, -1.0, -1.5, 0.3, 0.2, 0.0], filament_mm: 2.0 * time_s }
/// };
/// let bow = BlendedSegment { samples: (0..=200).map(at).collect(), prints: true };
/// let steps: Vec<Step> = print_blended(&workcell, [bow], BlendOptions::default()).collect();
/// let lines = steps.iter().filter(|step| matches!(step, Step::Move(Move { goal: Goal::Line(_), .. }))).count();
/// assert!((4..12).contains(&lines), "{lines}");
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn print_blended<'a, const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &'a W,
    segments: impl IntoIterator<Item = BlendedSegment<N>> + 'a,
    options: BlendOptions,
) -> PrintSteps<impl Iterator<Item = Step> + 'a> {
    PrintSteps::new(|dropped| {
        let sampled = move |BlendedSegment { samples: knots, prints }| {
            let samples = sampled(workcell, &knots);
            Sampled { knots, samples, prints }
        };
        let mut segments = segments.into_iter().map(sampled).peekable();
        let mut blended = Blended { workcell, options, dropped, has_begun: false, is_on: false };
        std::iter::from_fn(move || Some(blended.steps(segments.next()?, segments.peek()))).flatten()
    })
}

/// A segment with its samples; `None` where a posture has no pose.
struct Sampled<const N: usize> {
    knots: Vec<PrintKnot<N>>,
    samples: Option<Vec<Sample>>,
    prints: bool,
}

/// Makes the steps of segments, one after the other.
struct Blended<'a, const N: usize, const F: usize, W: Workcell<N, F>> {
    workcell: &'a W,
    options: BlendOptions,
    dropped: Rc<Cell<u64>>,
    has_begun: bool,
    /// Whether the extruder was switched on for the segment that follows.
    is_on: bool,
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Blended<'_, N, F, W> {
    /// The steps of a segment, and the signals of the next one that come before its end.
    fn steps(&mut self, Sampled { knots, samples, prints }: Sampled<N>, next: Option<&Sampled<N>>) -> Vec<Step> {
        if knots.len() < 2 {
            return Vec::new();
        }
        let Some(mut samples) = samples else {
            count(&self.dropped);
            return Vec::new();
        };
        let (workcell, options) = (self.workcell, &self.options);
        let mut steps = Vec::new();
        if !std::mem::replace(&mut self.has_begun, true) {
            let first = workcell.controller_pose(&knots[0].joints);
            steps.extend(first.map(|place| by_joints(place.joints, external(&place))));
        }
        if prints {
            if !std::mem::take(&mut self.is_on) {
                steps.push(Step::Extruder(true));
            }
            let lag_s = lag::of(&samples, options);
            lag::advance(&mut samples, lag_s);
            along(&samples, part_in_hand(workcell), options, &mut steps);
            return steps;
        }
        // A segment that has no pose gives no steps: no signals for it either.
        let next = next.filter(|next| next.prints).and_then(|next| next.samples.as_deref());
        let Some(early) = next.and_then(|next| lag::early(&samples, next, options)) else {
            travel(workcell, &knots, &samples, options, &mut steps);
            return steps;
        };
        travel(workcell, &knots[..=early.at], &samples[..=early.at], options, &mut steps);
        let mut last = Vec::new();
        // From rest to rest it may take longer than the lag: the filament is as much slower.
        let seconds = travel(workcell, &knots[early.at..], &samples[early.at..], options, &mut last);
        steps.extend([Step::Extruder(true), Step::FilamentSpeed(early.filament_mm / seconds.max(early.lag_s))]);
        self.is_on = true;
        steps.extend(last);
        steps
    }
}

/// How many ends of a move are at rest: a move begins at rest where the one before stops.
fn ramps(zones: &[Zone], k: usize) -> u8 {
    let stops = |zone: &Zone| *zone == Zone::Stop;
    u8::from(k == 0 || stops(&zones[k - 1])) + u8::from(stops(&zones[k]))
}

/// The zone at the end of each move: a corner between two, a stop at last.
fn zones(ends: &[usize], corner: impl Fn([usize; 3]) -> Zone) -> Vec<Zone> {
    ends.windows(3).map(|three| corner([three[0], three[1], three[2]])).chain([Zone::Stop]).collect()
}

/// A segment that prints, with the extruder on.
fn along(samples: &[Sample], in_hand: bool, options: &BlendOptions, steps: &mut Vec<Step>) {
    let ends = spans(samples.len(), |from, to| lines::fits(samples, in_hand, [from, to], options));
    let lays = |from: usize, to: usize| samples[to].filament_mm > samples[from].filament_mm;
    let flows = |from: usize, to: usize| lays(from, to) || samples[to].due_mm > samples[from].due_mm;
    let zones = zones(&ends, |three| {
        // A signal that starts or stops the filament comes at rest.
        let [from, at, to] = three;
        if flows(from, at) == flows(at, to) { lines::corner(samples, in_hand, three, options) } else { Zone::Stop }
    });
    let mut fed: Option<f64> = None;
    for (k, pair) in ends.windows(2).enumerate() {
        let (from, to) = (&samples[pair[0]], &samples[pair[1]]);
        let seconds = to.time_s - from.time_s;
        let [way, tip_way] = chord(samples, [pair[0], pair[1]]);
        // A TCP that only turns is as slow as its tip.
        let speed_at = |way: f64| cruise(way, seconds, ramps(&zones, k), options.acceleration_mm_s2);
        let share = if way > 0.0 { speed_at(way) / way } else { 1.0 / seconds };
        let speed_of = |filament_mm: f64| filament_mm.max(0.0) * share;
        // A blend takes no stop of the filament: where all of it has been asked for, a little still flows.
        let least = speed_of(to.filament_mm - from.filament_mm).min(lag::MIN_FED_MM_S);
        let due = speed_of(to.due_mm - from.due_mm);
        // `max` would drop the NaN of a move that takes no time, which the writer refuses.
        let filament = if due < least { least } else { due };
        if fed.is_none_or(|fed| (filament - fed).abs() > options.same_speed * fed) {
            steps.push(Step::FilamentSpeed(filament));
            fed = Some(filament);
        }
        // Within what a writer makes of it for the TCP, so that the move takes its time where one of both nearly stands still.
        // Ways that are no number stay so: the writer refuses their targets.
        let said_way = if way.is_nan() { way } else { tip_way.clamp(way * SPEED_FACTORS[0], way * SPEED_FACTORS[1]) };
        let speed = Speed { mm_s: (said_way * share).max(options.min_speed_mm_s), ..Speed::default() };
        steps.push(Step::Move(Move { goal: Goal::Line(to.target), table: None, speed, zone: zones[k] }));
    }
    steps.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
}

/// A segment that does not. Returns the seconds that its moves take.
fn travel<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    knots: &[PrintKnot<N>],
    samples: &[Sample],
    options: &BlendOptions,
    steps: &mut Vec<Step>,
) -> f64 {
    let turns = ways::turns(knots);
    let ends = spans(knots.len(), |from, to| ways::fits(knots, &turns, [from, to], options));
    let zones = zones(&ends, |[from, at, to]| {
        let [before, behind] = [[from, at], [at, to]].map(|pair| chord(samples, pair)[0]);
        ways::corner([from, at, to].map(|k| &knots[k].joints), [before, behind], options)
    });
    let mut seconds = 0.0;
    for (k, pair) in ends.windows(2).enumerate() {
        let (from, to) = (&knots[pair[0]], &knots[pair[1]]);
        let way = ways::turn(&from.joints, &to.joints);
        // A posture that is held needs no move.
        let Some(place) = workcell.controller_pose(&to.joints).filter(|_| way > 0.0) else { continue };
        let rad_s = cruise(way, to.time_s - from.time_s, ramps(&zones, k), options.acceleration_rad_s2);
        let rad_s = rad_s.max(options.min_speed_rad_s);
        seconds += way / rad_s + f64::from(ramps(&zones, k)) * rad_s / (2.0 * options.acceleration_rad_s2);
        let speed = Speed { rad_s, ..Speed::default() };
        let table = external(&place);
        steps.push(Step::Move(Move { goal: Goal::Joints(place.joints), table, speed, zone: zones[k] }));
    }
    seconds
}
