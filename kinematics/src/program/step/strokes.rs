//! The steps of a print: approach, extruder on, the stroke, extruder off, retract; stroke after stroke.

use super::data::{Goal, Move, Speed, Step, Zone};
use crate::target::Target;
use nalgebra::Translation3;

/// How strokes are printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeOptions {
    /// Speed while material is laid down. Default 20 mm/s.
    pub print: Speed,
    /// Speed on the way to the point above a stroke. Default 100 mm/s.
    pub travel: Speed,
    /// Speed down to a stroke and up from it. Default 10 mm/s.
    pub plunge: Speed,
    /// How corners within a stroke are rounded. Default 0.3 mm.
    pub zone: Zone,
}

impl Default for StrokeOptions {
    fn default() -> Self {
        let at = |mm_s: f64| Speed { mm_s, ..Speed::default() };
        StrokeOptions { print: at(20.0), travel: at(100.0), plunge: at(10.0), zone: Zone::Blend(0.3) }
    }
}

/// A target moved along the z axis of its tool frame: with `mm` above zero away from the part where z points from the
/// part into the nozzle (as everywhere in this crate), and below zero for tools whose z points out at the tip.
pub fn lifted(target: &Target, mm: f64) -> Target {
    Target { pose: target.pose * Translation3::new(0.0, 0.0, mm), conf: target.conf }
}

/// The steps that print strokes one after the other. `lift` gives the goal above the begin or the end of a stroke
/// ([`lifted`] for targets; joints need the inverse kinematics).
///
/// For each stroke: by joints to above its first goal, down to it, extruder on, along the stroke, extruder off, up.
/// Wherever the extruder changes the tool stands still. A stroke without goals is passed over.
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::program::*;
/// let at = |x: f64| Target { pose: Isometry3::translation(x, 0.0, 1.0), conf: ConfData::default() };
/// let stroke = [0.0, 5.0, 10.0].map(|x| Goal::Line(at(x)));
/// let above = |goal: &Goal| match goal {
///     Goal::Line(target) => Goal::Line(lifted(target, 20.0)),
///     other => *other,
/// };
/// let steps: Vec<Step> = strokes([stroke.as_slice()], StrokeOptions::default(), above).collect();
/// assert_eq!(steps.len(), 7);
/// assert_eq!((steps[2], steps[5]), (Step::Extruder(true), Step::Extruder(false)));
/// ```
pub fn strokes<'a>(
    strokes: impl IntoIterator<Item = &'a [Goal]>,
    options: StrokeOptions,
    mut lift: impl FnMut(&Goal) -> Goal,
) -> impl Iterator<Item = Step> {
    let to = |goal: Goal, speed: Speed, zone: Zone| Step::Move(Move { goal, table: None, speed, zone });
    strokes.into_iter().flat_map(move |stroke| {
        let ends = stroke.first().zip(stroke.last()).map(|(first, last)| {
            let above = match lift(first) {
                Goal::Line(target) => Goal::JointMove(target),
                other => other,
            };
            (above, *first, lift(last))
        });
        let before = ends.into_iter().flat_map(move |(above, first, _)| {
            let (down, travel) = (to(first, options.plunge, Zone::Stop), to(above, options.travel, Zone::Stop));
            [travel, down, Step::Extruder(true)]
        });
        let along = (1..stroke.len()).map(move |k| {
            let zone = if k + 1 == stroke.len() { Zone::Stop } else { options.zone };
            to(stroke[k], options.print, zone)
        });
        let after = ends
            .into_iter()
            .flat_map(move |(_, _, above)| [Step::Extruder(false), to(above, options.plunge, Zone::Stop)]);
        before.chain(along).chain(after)
    })
}
