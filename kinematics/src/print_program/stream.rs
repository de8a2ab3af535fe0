//! The stream of a print's joints at the controller's rate.

use super::lag::{Advanced, Delayed};
use crate::program::{ExternalAxes, Goal, Move, ServoRate, Speed, Step, TimedSignal, Zone};

/// A motion of a print as a function of time.
#[derive(Clone, Debug)]
pub struct StreamSegment<J, L> {
    /// In seconds. A leg whose duration is not finite, or not above 0, is left out.
    pub duration_s: f64,
    /// Joints of the arm at a time since the leg began.
    pub joints: J,
    /// Millimetres of filament that are laid by a time since the leg began; `None` for a leg that does not print.
    pub filament_mm: Option<L>,
    /// Signals of a tape head along it, in the order of their times: each comes before the first tick at or after its time, or at the end.
    pub signals: Vec<TimedSignal>,
}

/// How a print is streamed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamOptions {
    /// The controller's rate. Default 125 Hz.
    pub rate: ServoRate,
    /// The speed of the filament is written again where it changes by more than this share. Default 0.002: with less every tick
    /// writes one, with more the beads are as much too thick or too thin.
    pub same_speed: f64,
    /// How far the arm is behind the stream, in seconds: signals come as much later, and the last posture is held as long. Arms
    /// of Universal Robots follow `servoj` with a lag of its look-ahead time. Below 0 signals come earlier, for equipment that takes longer
    /// than the arm, by 0.5 s at most; where the stream begins with one, the first posture is held as long. Default 0.
    pub lag_s: f64,
}

/// How much earlier signals of a stream come at most, in seconds: as in RAPID. As many ticks are held in memory.
const MAX_EARLY_S: f64 = 0.5;

/// Longer legs are no motions: thirty years. So ticks can be counted through all legs.
const MAX_LEG_S: f64 = 1e9;

impl Default for StreamOptions {
    fn default() -> Self {
        StreamOptions { rate: ServoRate::Hz125, same_speed: 2e-3, lag_s: 0.0 }
    }
}

/// The steps of a print as a stream: by joints to the first posture, then all legs at every tick of the controller, the extruder
/// on along those that print.
///
/// Ticks count from the begin of the first leg, through all legs. The last posture follows as one step more, since the end lies
/// between two ticks.
///
/// # Arguments
/// * `ends`: the first and the last posture.
/// * `legs`: one after the other, each beginning where the one before ends. Those that take no time, or more than 10^9 s, are left out.
///
/// # Cost
/// Constant memory; each tick asks for the joints once and for the filament twice.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::Step;
/// use curvlay_kinematics::print_program::{StreamSegment, StreamOptions, print_stream};
/// // Joint 1 turns by 0.1 rad in 20 ms while 1 mm of filament is laid.
/// let leg = StreamSegment { duration_s: 0.02, joints: |t: f64| [5.0 * t, 0.0, 0.0, 0.0, 0.0, 0.0], filament_mm: Some(|t: f64| 50.0 * t), signals: Vec::new() };
/// let steps: Vec<Step> = print_stream([[0.0; 6], [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]], [leg], StreamOptions::default()).collect();
/// assert!(matches!(steps[..], [
///     Step::Move(_), Step::Extruder(true), Step::FilamentSpeed(_), Step::Servo { .. }, Step::Servo { .. },
///     Step::FilamentSpeed(0.0), Step::Extruder(false), Step::Servo { .. },
/// ]));
/// ```
pub fn print_stream<J: Fn(f64) -> [f64; 6], L: Fn(f64) -> f64>(
    ends: [[f64; 6]; 2],
    legs: impl IntoIterator<Item = StreamSegment<J, L>>,
    options: StreamOptions,
) -> impl Iterator<Item = Step> {
    let StreamOptions { rate, same_speed, lag_s } = options;
    let period = rate.seconds();
    let first = by_joints(ends[0], None);
    let mut begin = 0.0;
    let legs = legs.into_iter().filter(|leg| leg.duration_s > 0.0 && leg.duration_s <= MAX_LEG_S);
    let along = legs.flat_map(move |leg| {
        let (from, to) = (begin, begin + leg.duration_s);
        begin = to;
        let of_leg = move |tick: &u64| *tick as f64 * period <= to;
        let first = ((from / period).floor() as u64).saturating_add(1);
        let prints = leg.filament_mm.is_some();
        let signal = move |on| prints.then_some(Step::Extruder(on));
        let mut speed = 0.0;
        // The leg has no tick at or after the times of the others.
        let last = (to / period).floor() as u64;
        let next = last.saturating_add(1);
        let last = if of_leg(&next) { next } else { last };
        let until = if last < first { f64::NEG_INFINITY } else { last as f64 * period - from };
        let switched = |TimedSignal { signal, on, .. }| Step::Signal { signal, on };
        let split = leg.signals.partition_point(|signal| signal.time_s <= until);
        let behind: Vec<Step> = leg.signals[split..].iter().copied().map(switched).collect();
        let mut due = leg.signals.into_iter().take(split).peekable();
        let servo = (first..).take_while(of_leg).flat_map(move |tick| {
            let now = tick as f64 * period - from;
            let laid = |filament_mm: &L| (filament_mm(now) - filament_mm(now - period)).max(0.0) / period;
            let needed = leg.filament_mm.as_ref().map_or(0.0, laid);
            // Steady speeds are written once.
            let changes = prints && (needed - speed).abs() > same_speed * speed;
            speed = if changes { needed } else { speed };
            let servo = Step::Servo { joints: (leg.joints)(now), seconds: period };
            let signals: Vec<Step> =
                std::iter::from_fn(|| due.next_if(|signal| signal.time_s <= now)).map(switched).collect();
            signals.into_iter().chain(changes.then_some(Step::FilamentSpeed(speed))).chain([servo])
        });
        let end = prints.then_some(Step::FilamentSpeed(0.0));
        signal(true).into_iter().chain(servo).chain(behind).chain(end).chain(signal(false))
    });
    // The end lies between two ticks.
    let steps = [first].into_iter().chain(along).chain([Step::Servo { joints: ends[1], seconds: period }]);
    // A lag of NaN counts as 0; each of the two casts maps values below 0 to 0.
    let ticks = (lag_s.clamp(-MAX_EARLY_S, f64::INFINITY) / period).round();
    Delayed::new(Advanced::new(steps, -ticks as usize), ticks as u64)
}

pub(super) fn by_joints(joints: [f64; 6], table: Option<ExternalAxes>) -> Step {
    Step::Move(Move { goal: Goal::Joints(joints), table, speed: Speed::default(), zone: Zone::Stop })
}
