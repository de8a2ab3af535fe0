//! The motions of a planned print as robot programs take them.

use curvlay_kinematics::print_program::{
    BlendOptions, BlendedSegment, PrintKnot, PrintSteps, StreamOptions, StreamSegment, TargetMotion, TargetOptions,
    print_blended, print_pieces, print_stream, print_targets,
};
use curvlay_kinematics::program::{FILAMENT_FULL_SCALE_MM_S, Step, Straight, UrScriptOptions};
use curvlay_kinematics::workcell::{Equipment, ProgramLanguage, Workcell};
use curvlay_trajectory::print::{PrintPlan, Run, Segment, SegmentKind, Travel};
use std::collections::BTreeSet;
use std::ops::Range;

/// Postures by which the nozzle lifts off, and by which it comes down, in a program of targets.
pub const LIFT_POSTURES: u32 = 4;

/// Whether the controller of a cell takes joints over time (URScript), not targets (RAPID).
///
/// # Errors
/// In words, for an arm of Universal Robots with a table or on a track, which its controller does not move.
pub fn takes_stream(equipment: &Equipment) -> Result<bool, &'static str> {
    match (equipment.arm().is_ur(), equipment.positioner()) {
        (true, _) if equipment.track().is_some() => Err(
            "URScript has no external axis, so it moves no track; programs in rapid, krl and tp do, of arms of ABB, KUKA and Fanuc",
        ),
        (true, Some(_)) => Err("the controller of a UR moves no table"),
        (is_ur, _) => Ok(is_ur),
    }
}

/// The languages in which programs of a cell can be written, its own first: the one that the workcell or the arm's maker names. An arm of Universal
/// Robots takes URScript alone; targets for any other arm can be written in all languages of targets, for controllers that are not of its maker.
///
/// # Errors
/// As of [`takes_stream`].
pub fn languages(equipment: &Equipment) -> Result<Vec<ProgramLanguage>, &'static str> {
    use ProgramLanguage::{Krl, Rapid, Tp};
    let others: &[ProgramLanguage] = if takes_stream(equipment)? { &[] } else { &[Rapid, Krl, Tp] };
    let own = equipment.language();
    let others = others.iter().copied().filter(|language| Some(*language) != own);
    Ok(own.into_iter().chain(others).collect())
}

/// Steps of a program of joints over time: 13 minutes of motion in about 13 MB. B. Brooks (2016, section 4.14) could not load 180,000 lines.
const STREAM_STEPS: u32 = 100_000;

/// The runs before which a program of at most so many steps ends, if steps are counted: for streams of joints, and for targets in CSV
/// (`is_csv`). RAPID is divided into modules by its writer.
pub fn cuts<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    is_csv: bool,
    max_steps: Option<u32>,
) -> BTreeSet<usize> {
    let is_stream = takes_stream(cell.equipment()).unwrap_or(false);
    if !is_stream && !is_csv {
        return BTreeSet::new();
    }
    let steps = |run: &Run<N, F>, travel: Option<&Travel<N>>| match is_stream {
        true => {
            (run.duration() + travel.map_or(0.0, Travel::duration))
                / StreamOptions::of_workcell(cell.equipment()).rate.seconds()
        }
        false => (run.passes.len() + 2 + travel.map_or(0, |travel| travel.postures(LIFT_POSTURES).len())) as f64,
    };
    let motions = plan.runs.iter().enumerate().map(|(number, run)| {
        let travel = plan.travels.get(number).and_then(Option::as_ref);
        (steps(run, travel), travel.is_some())
    });
    let pieces = print_pieces(motions, u64::from(max_steps.unwrap_or(STREAM_STEPS)));
    pieces.into_iter().map(|piece| piece.motions.start).filter(|start| *start > 0).collect()
}

/// Lines of a URScript of moves with blends: a file of them is about a megabyte.
const BLENDED_LINES: u32 = 10_000;

/// The runs before which a URScript of moves with blends ends, so that it has at most so many lines; a single run may have more.
pub fn blended_cuts<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    max_lines: Option<u32>,
) -> BTreeSet<usize> {
    let most = u64::from(max_lines.unwrap_or(BLENDED_LINES)).saturating_sub(HEAD_LINES);
    let motions = (0..plan.runs.len()).map(|number| {
        let lines = blended(cell, plan, number..number + 1).count() as f64;
        (lines, plan.travels.get(number).is_some_and(Option::is_some))
    });
    let pieces = print_pieces(motions, most);
    pieces.into_iter().map(|piece| piece.motions.start).filter(|start| *start > 0).collect()
}

/// Lines of a script that are no steps, and those of the ways from home and back.
const HEAD_LINES: u64 = 60;

/// The runs of each program: from home to home where the plan has such ways, else up to the last travel that was found.
pub fn pieces<const N: usize, const F: usize>(plan: &PrintPlan<N, F>) -> Vec<Range<usize>> {
    let mut pieces: Vec<Range<usize>> = Vec::new();
    for run in 0..plan.runs.len() {
        let joins = run > 0 && plan.travels[run - 1].is_some();
        match pieces.last_mut() {
            Some(piece) if joins => piece.end = run + 1,
            _ => pieces.push(run..run + 1),
        }
    }
    pieces
}

/// The name of one of several programs of targets: `print`, or `print1` and so on.
pub fn program_name(count: usize, number: usize) -> String {
    if count == 1 { "print".to_owned() } else { format!("print{}", number + 1) }
}

/// Some runs and the travels behind them as joints of the arm over time, at the rate of its controller; signals of the extruder as
/// late as the arm is behind, and earlier by the lag of the extruder.
pub fn stream<'a, const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &'a W,
    plan: &'a PrintPlan<N, F>,
    runs: Range<usize>,
) -> impl Iterator<Item = Step> + 'a {
    let arm = move |joints: &[f64; N]| cell.scene_posture(joints).joints;
    let (mut first, mut last) = (None, None);
    for leg in plan.segments(runs.clone()) {
        first = first.or(Some(leg.at(0.0)));
        last = Some(leg.at(leg.duration()));
    }
    let ends = [first, last];
    let legs = plan.segments(runs).map(move |leg| StreamSegment {
        duration_s: leg.duration(),
        joints: move |time: f64| arm(&leg.at(time)),
        filament_mm: (leg.kind == SegmentKind::Print).then_some(move |time: f64| leg.filament_mm(time)),
        signals: Vec::new(),
    });
    let options = StreamOptions::of_workcell(cell.equipment());
    print_stream(ends.map(|joints| joints.map_or([0.0; 6], |joints| arm(&joints))), legs, options)
}

/// Time between two samples of a motion at most, in seconds: at 100 mm/s the tip is a millimetre further.
const SAMPLE_S: f64 = 0.01;

/// The times of the samples of a motion.
fn sample_times(duration: f64) -> impl Iterator<Item = f64> {
    let count = (duration / SAMPLE_S).ceil().max(1.0) as u32;
    (0..=count).map(move |k| if k == count { duration } else { f64::from(k) / f64::from(count) * duration })
}

/// A motion as samples, from which a program of moves with blends takes the ends of its moves.
pub fn samples<const N: usize, const F: usize>(segment: &Segment<'_, N, F>) -> Vec<PrintKnot<N>> {
    let knot = |time_s| PrintKnot { time_s, joints: segment.at(time_s), filament_mm: segment.filament_mm(time_s) };
    sample_times(segment.duration()).map(knot).collect()
}

/// Some runs, the travels behind them and the ways from home and back as few moves with blends.
pub fn blended<'a, const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &'a W,
    plan: &'a PrintPlan<N, F>,
    runs: Range<usize>,
) -> PrintSteps<impl Iterator<Item = Step> + 'a> {
    let segments = plan
        .segments(runs)
        .map(|segment| BlendedSegment { samples: samples(&segment), prints: segment.kind == SegmentKind::Print });
    print_blended(cell, segments, BlendOptions::of_workcell(cell.equipment()))
}

/// Options of a URScript of moves with blends: those of a stream, with `movep` and the acceleration by which the times of moves are reckoned.
pub fn blended_options<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    name: &str,
) -> UrScriptOptions {
    let BlendOptions { acceleration_mm_s2, acceleration_rad_s2, .. } = BlendOptions::of_workcell(cell.equipment());
    let options = urscript_options(cell, plan, name);
    UrScriptOptions { straight: Straight::MoveP, acceleration_mm_s2, acceleration_rad_s2, ..options }
}

/// The least of 1, 2, 5, 10, 20 ... that holds a speed: so a signal uses half of its range or nearly so, and prints of one kind have
/// the same. [`FILAMENT_FULL_SCALE_MM_S`] where there is no speed.
pub fn full_scale(mm_s: f64) -> f64 {
    if !(mm_s > 0.0 && mm_s.is_finite()) {
        return FILAMENT_FULL_SCALE_MM_S;
    }
    // The decade by its own power, so that 10 is 10.
    let decade = 10f64.powi(mm_s.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0, 20.0].map(|step| step * decade);
    steps.into_iter().find(|scale| *scale >= mm_s).unwrap_or(mm_s)
}

/// Options of a stream: the frames, the arm and its limits, and a range of the filament's signal that holds the whole print.
pub fn urscript_options<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    name: &str,
) -> UrScriptOptions {
    let filament_full_scale_mm_s = full_scale(plan.max_filament_mm_s());
    let options = UrScriptOptions::of_workcell(cell.equipment());
    UrScriptOptions { name: name.to_owned(), filament_full_scale_mm_s, starts: true, ..options }
}

/// Some runs as targets on the part, and the travels behind them by joints.
pub fn targets<'a, const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &'a W,
    plan: &'a PrintPlan<N, F>,
    runs: Range<usize>,
) -> PrintSteps<impl Iterator<Item = Step> + 'a> {
    let motions = runs.flat_map(|number| {
        let run = &plan.runs[number];
        let (times, joints) = (run.trajectory.times(), run.trajectory.joints());
        let knot =
            |&(k, _): &(usize, _)| PrintKnot { time_s: times[k], joints: joints[k], filament_mm: run.filament_mm[k] };
        let (arrival, departure) = plan.homes.get(number).map_or((None, None), |(a, d)| (a.as_ref(), d.as_ref()));
        let before =
            arrival.map(|arrival| TargetMotion { onward: arrival.postures(LIFT_POSTURES), ..Default::default() });
        let travel = plan.travels.get(number).and_then(Option::as_ref);
        let home = departure.map(|departure| departure.postures(LIFT_POSTURES));
        let onward = travel.map(|travel| travel.postures(LIFT_POSTURES)).or(home).unwrap_or_default();
        before.into_iter().chain([TargetMotion { knots: run.passes.iter().map(knot).collect(), onward, head: None }])
    });
    print_targets(cell, motions, TargetOptions::default())
}
