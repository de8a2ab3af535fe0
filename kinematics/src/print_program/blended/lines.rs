//! Lines of the tool: how near they are to the plan, and how wide corners may be rounded.

use super::options::BlendOptions;
use crate::print_program::PrintKnot;
use crate::program::Zone;
use crate::scene::Mount;
use crate::target::Target;
use crate::workcell::Workcell;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// A sample of a motion with its poses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub time_s: f64,
    pub filament_mm: f64,
    /// Filament that signals have to have asked for by then: with a lag more than what is laid.
    pub due_mm: f64,
    /// The tool on the part.
    pub target: Target,
    /// What the controller interpolates: the same, or the part on the tool where the part is in the hand.
    tcp: Isometry3<f64>,
    /// How far the TCP has gone by then, in mm.
    way_mm: f64,
    /// And the tip on the part.
    tip_way_mm: f64,
}

/// The samples of a motion; `None` where a posture has no pose.
pub(super) fn sampled<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    knots: &[PrintKnot<N>],
) -> Option<Vec<Sample>> {
    let in_hand = part_in_hand(workcell);
    let mut samples: Vec<Sample> = Vec::with_capacity(knots.len());
    for knot in knots {
        let target = workcell.controller_pose(&knot.joints)?.target;
        let tcp = view(in_hand, &target.pose);
        let far = |a: &Isometry3<f64>, b: &Isometry3<f64>| (a.translation.vector - b.translation.vector).norm();
        let [way_mm, tip_way_mm] = samples.last().map_or([0.0; 2], |last| {
            [last.way_mm + far(&last.tcp, &tcp), last.tip_way_mm + far(&last.target.pose, &target.pose)]
        });
        let PrintKnot { time_s, filament_mm, .. } = *knot;
        samples.push(Sample { time_s, filament_mm, due_mm: filament_mm, target, tcp, way_mm, tip_way_mm });
    }
    Some(samples)
}

/// Whether the robot of a workcell holds the part.
pub(super) fn part_in_hand<const N: usize, const F: usize, W: Workcell<N, F>>(workcell: &W) -> bool {
    matches!(workcell.equipment().part_frame().0, Mount::Link(_))
}

/// The tool on the part as the pose that a controller interpolates, and the other way round.
fn view(in_hand: bool, pose: &Isometry3<f64>) -> Isometry3<f64> {
    if in_hand { pose.inverse() } else { *pose }
}

/// A place on the line from one pose to another, as a controller goes along it.
fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let place = from.translation.vector.lerp(&to.translation.vector, share);
    let turn = from.rotation.rotation_to(&to.rotation).scaled_axis();
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_scaled_axis(turn * share) * from.rotation)
}

/// How far apart two poses of the tool on the part are: the tip in mm, the axis in rad.
fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> [f64; 2] {
    let axis = |pose: &Isometry3<f64>| pose.rotation * Vector3::z();
    [(a.translation.vector - b.translation.vector).norm(), axis(a).angle(&axis(b))]
}

/// What is near enough for a line, or for a corner: half of the tolerances.
fn is_near([mm, rad]: [f64; 2], options: &BlendOptions) -> bool {
    mm <= 0.5 * options.path_mm && rad <= 0.5 * options.axis_rad
}

/// Whether the line from one sample to another goes by all between: near their places, and with their speeds and beads.
pub(super) fn fits(samples: &[Sample], in_hand: bool, [from, to]: [usize; 2], options: &BlendOptions) -> bool {
    let (a, b) = (&samples[from], &samples[to]);
    let (way, seconds) = (b.way_mm - a.way_mm, b.time_s - a.time_s);
    let is_steady = seconds <= options.min_move_s || is_steady(&samples[from..=to], options);
    is_steady
        && samples[from + 1..to].iter().all(|sample| {
            // A TCP that only turns has no way.
            let share =
                if way > 1e-6 { (sample.way_mm - a.way_mm) / way } else { (sample.time_s - a.time_s) / seconds };
            let at = view(in_hand, &between(&a.tcp, &b.tcp, share));
            is_near(apart(&at, &sample.target.pose), options)
        })
}

/// Whether the speed of the TCP and the bead stay the same through some samples.
fn is_steady(samples: &[Sample], options: &BlendOptions) -> bool {
    let [first, last] = [&samples[0], &samples[samples.len() - 1]];
    let seconds = last.time_s - first.time_s;
    let speed = (last.way_mm - first.way_mm) / seconds;
    let bead = ratio(last.due_mm - first.due_mm, last.tip_way_mm - first.tip_way_mm);
    samples.windows(2).all(|pair| {
        let step = pair[1].time_s - pair[0].time_s;
        let here = (pair[1].way_mm - pair[0].way_mm) / step;
        let laid = ratio(pair[1].due_mm - pair[0].due_mm, pair[1].tip_way_mm - pair[0].tip_way_mm);
        (here - speed).abs() <= options.speed_share * speed && (laid - bead).abs() <= options.bead_share * bead
    })
}

fn ratio(filament_mm: f64, way_mm: f64) -> f64 {
    if way_mm > 1e-9 { filament_mm / way_mm } else { 0.0 }
}

/// Two of them do not meet, and a writer that allows 0.49 does not make them smaller.
pub(super) const BLEND_SHARE: f64 = 0.48;

/// Less is a stop.
pub(super) const MIN_BLEND_MM: f64 = 2e-3;

/// The widest radius by which the corner between two lines may be rounded, found by halving.
pub(super) fn corner(samples: &[Sample], in_hand: bool, [from, at, to]: [usize; 3], options: &BlendOptions) -> Zone {
    let [before, here, behind] = [from, at, to].map(|k| &samples[k].tcp);
    let way = |other: &Isometry3<f64>| (other.translation.vector - here.translation.vector).norm();
    let ways = [way(before), way(behind)];
    let mut radius = BLEND_SHARE * ways[0].min(ways[1]);
    while radius >= MIN_BLEND_MM {
        let [begin, end] = [between(here, before, radius / ways[0]), between(here, behind, radius / ways[1])];
        let middle = between(&between(&begin, here, 0.5), &between(here, &end, 0.5), 0.5);
        if is_near(apart(&view(in_hand, &middle), &samples[at].target.pose), options) {
            return Zone::Blend(radius);
        }
        radius *= 0.5;
    }
    Zone::Stop
}

/// The straight ways from one sample to another in mm: of the TCP, and of the tip on the part.
pub(super) fn chord(samples: &[Sample], [from, to]: [usize; 2]) -> [f64; 2] {
    let (a, b) = (&samples[from], &samples[to]);
    let far = |a: &Isometry3<f64>, b: &Isometry3<f64>| (a.translation.vector - b.translation.vector).norm();
    [far(&a.tcp, &b.tcp), far(&a.target.pose, &b.target.pose)]
}
