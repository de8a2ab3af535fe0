//! How long the moves of a program take by their own speeds.
//!
//! A controller moves at the speed that stands in the move: `length / mm_s`, or longer where the tool turns more than it travels,
//! `angle / rad_s` (*RAPID Reference Manual*, `speeddata`). What a plan takes between the same waypoints is another time, since lines are
//! merged and slow turns are written faster. Accelerations, blends, waits and the loading of modules are not counted.

use crate::program::step::{ExternalAxes, Goal, Move, Speed, Step};
use nalgebra::Isometry3;

/// Pieces of a move by joints whose chords are added up: an arc of half a turn is 0.2 percent too short.
const PIECES: u32 = 16;

/// Seconds that the steps of a program take.
///
/// A line, or a swing, takes the greater of its length over `mm_s` and its turn over `rad_s`. A move to joints takes the same along the way of
/// the tool, in 16 chords from joints that are known and one chord from a pose; where `work_tool` does not know a place, the largest turn of a joint
/// over `rad_s`. What begins at a place that is not known, as the first move of a program, counts 0. A step of a stream takes its own time.
///
/// # Arguments
/// * `work_tool`: the pose of the tool in the work object, in mm, at joints of the arm and of the table; `None` where it is not known.
///   [`RapidOptions::work_tool`](crate::program::RapidOptions::work_tool) is one.
///
/// # Returns
/// Seconds, 0 or more for steps that a writer takes.
///
/// # Cost
/// Constant memory; 17 calls of `work_tool` a move to joints.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::program::*;
/// let line = |x: f64, mm_s: f64| {
///     let target = Target { pose: Isometry3::translation(x, 0.0, 0.0), conf: ConfData::default() };
///     Step::Move(Move { goal: Goal::Line(target), table: None, speed: Speed { mm_s, rad_s: 1.0 }, zone: Zone::Stop })
/// };
/// // 30 mm at 10 mm/s; where the first move begins is not known.
/// assert_eq!(program_seconds([line(0.0, 5.0), line(30.0, 10.0)], |_, _| None), 3.0);
/// ```
pub fn program_seconds(
    steps: impl IntoIterator<Item = Step>,
    work_tool: impl Fn(&[f64; 6], Option<ExternalAxes>) -> Option<Isometry3<f64>>,
) -> f64 {
    let mut clock = Clock::default();
    for step in steps {
        clock.pass(&step, &work_tool);
    }
    clock.seconds
}

/// Follows the steps of a program.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clock {
    pub seconds: f64,
    place: Option<Isometry3<f64>>,
    joints: Option<([f64; 6], Option<ExternalAxes>)>,
}

impl Clock {
    pub fn pass(
        &mut self,
        step: &Step,
        work_tool: &impl Fn(&[f64; 6], Option<ExternalAxes>) -> Option<Isometry3<f64>>,
    ) {
        match step {
            Step::Move(Move { goal: Goal::Line(target) | Goal::JointMove(target), speed, .. }) => {
                let way = self.place.map_or([0.0; 2], |from| way(&from, &target.pose));
                self.seconds += time(way, speed);
                (self.place, self.joints) = (Some(target.pose), None);
            }
            Step::Move(Move { goal: Goal::Joints(joints), table, speed, .. }) => {
                let place = work_tool(joints, *table);
                self.seconds += self.by_joints(joints, *table, place, speed, work_tool);
                (self.place, self.joints) = (place, Some((*joints, *table)));
            }
            Step::Servo { joints, seconds } => {
                self.seconds += seconds;
                (self.place, self.joints) = (work_tool(joints, None), Some((*joints, None)));
            }
            Step::Extruder(_) | Step::FilamentSpeed(_) | Step::Signal { .. } | Step::Wait(_) => {}
        }
    }

    fn by_joints(
        &self,
        joints: &[f64; 6],
        table: Option<ExternalAxes>,
        place: Option<Isometry3<f64>>,
        speed: &Speed,
        work_tool: &impl Fn(&[f64; 6], Option<ExternalAxes>) -> Option<Isometry3<f64>>,
    ) -> f64 {
        let Some((from, from_table)) = &self.joints else {
            // From a line.
            return self.place.zip(place).map_or(0.0, |(from, to)| time(way(&from, &to), speed));
        };
        let Some(begin) = self.place.filter(|_| place.is_some()) else {
            let turn = joints.iter().zip(from).map(|(to, from)| (to - from).abs()).fold(0.0, f64::max);
            return turn / speed.rad_s;
        };
        let (mut before, mut all) = (begin, [0.0; 2]);
        for k in 1..=PIECES {
            let share = f64::from(k) / f64::from(PIECES);
            let between = |from: f64, to: f64| from + (to - from) * share;
            let at = std::array::from_fn(|joint| between(from[joint], joints[joint]));
            let Some(next) = work_tool(&at, between_tables(*from_table, table, share)) else { continue };
            let [length, angle] = way(&before, &next);
            (all, before) = ([all[0] + length, all[1] + angle], next);
        }
        time(all, speed)
    }
}

/// The table, or other axes, on the way; those that were not there before are at their end.
fn between_tables(from: Option<ExternalAxes>, to: Option<ExternalAxes>, share: f64) -> Option<ExternalAxes> {
    let (from, to) = (from.map_or([None; 6], |axes| axes.axes()), to?.axes());
    ExternalAxes::new(std::array::from_fn(|k| to[k].map(|to| from[k].map_or(to, |from| from + (to - from) * share))))
}

/// Millimetres and radians from one pose to another.
fn way(from: &Isometry3<f64>, to: &Isometry3<f64>) -> [f64; 2] {
    [(to.translation.vector - from.translation.vector).norm(), from.rotation.angle_to(&to.rotation)]
}

fn time([length, angle]: [f64; 2], speed: &Speed) -> f64 {
    (length / speed.mm_s).max(angle / speed.rad_s)
}
