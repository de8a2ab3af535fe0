//! Moves of the tip become motions of the axes, bead by bead.

use super::bead::{Bead, Item, Place, TipMove};
use super::error::AxisPlanError;
use super::lift::{Rewind, up};
use super::moves::{AxisMove, AxisStep, PathMove};
use super::options::{AxisPlanOptions, FEED, is_within};
use super::pieces::{Piece, Stretch};
use super::pose::Pose;
use super::speed::{at_rest, at_speed};
use super::summary::AxisPlanSummary;
use super::task::Task;
use crate::machine::geometry::{FiveAxis, Posture};
use nalgebra::Vector3;
use std::collections::VecDeque;

/// How far the length of a direction may be from 1.
const UNIT: f64 = 1e-6;

/// Largest coordinate, mm.
const COORDINATE: [f64; 2] = [-1e6, 1e6];

const FILAMENT: [f64; 2] = [0.0, 1e6];

/// Travels that are planned at once where no bead follows.
const MAX_TRAVELS: usize = 4096;

/// No motion takes less, seconds: files of inverse times have digits for no more.
const MIN_SECONDS: f64 = 1e-4;

/// A motion counts as slowed from this factor on.
const SLOWED: f64 = 1.0 + 1e-6;

/// Plans the motions of the axes of a machine along moves of the tip.
///
/// A bead is a run of printing moves; it is planned with the travels before it. Branch and whole turns of its start are those with which the axes
/// stay within their ranges to its end. Where none do, and where a rotary axis would turn too long at a pole, the bead is cut: filament is drawn back, the nozzle lifts off
/// along its direction, the rotary axes go to other readings for the same pose while the tip stays in its place above the part, and the
/// nozzle comes back. Before a bead the same happens on the way. Moves are divided so that tip and direction keep their tolerances, by bounds that hold for the whole
/// motion. A motion for which an axis is too slow takes longer. Accelerations count for lifted motions, which go from rest to rest; in a bead they are the controller's business.
///
/// # Arguments
/// * `moves`: in order; the first that goes anywhere, and the first after [`PathMove::Restart`], is a [`PathMove::Travel`].
///
/// # Returns
/// An iterator of motions, which ends after the first error. [`AxisPlan::summary`] says what has been done so far.
///
/// # Errors
/// [`AxisPlanError::Option`] here, the others from the iterator.
///
/// # Cost
/// Memory for one bead; some microseconds a motion. The result depends on the arguments alone.
///
/// # Example
/// ```
/// use curvlay_kinematics::machine::{AxisPlanOptions, AxisStep, FiveAxis, PathMove, plan_axes};
/// use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
/// # #[cfg(feature = "serde")] {
/// let file = include_str!("../../../../examples/machines/open5x-table.json");
/// let machine = FiveAxis::from_json(file.as_bytes())?;
/// let lean = UnitVector3::new_normalize(Vector3::new(0.5, 0.0, 1.0));
/// let moves = [
///     PathMove::<()>::Travel { tip: Point3::new(0.0, 0.0, 20.0), direction: Vector3::z_axis(), feed_mm_s: 50.0 },
///     PathMove::Print { tip: Point3::new(20.0, 0.0, 20.0), direction: lean, filament_mm: 0.8, feed_mm_s: 20.0 },
/// ];
/// let mut plan = plan_axes(&machine, moves, AxisPlanOptions::default())?;
/// let mut filament_mm = 0.0;
/// for step in &mut plan {
///     let AxisStep::Move(motion) = step? else { continue };
///     filament_mm += motion.filament_mm;
/// }
/// assert!((filament_mm - 0.8).abs() < 1e-12 && plan.summary().max_tip_error_mm <= 0.02);
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plan_axes<T, I>(
    machine: &FiveAxis,
    moves: I,
    options: AxisPlanOptions,
) -> Result<AxisPlan<'_, T, I::IntoIter>, AxisPlanError>
where
    I: IntoIterator<Item = PathMove<T>>,
{
    options.check()?;
    let start = options.start.unwrap_or_else(|| machine.start());
    Ok(AxisPlan {
        task: Task::new(machine, options),
        moves: moves.into_iter(),
        held: None,
        place: None,
        rotary: machine.rotary_of(&start),
        bead: None,
        out: VecDeque::new(),
        height_mm: f64::NEG_INFINITY,
        tilt_mm: [0.0; 2],
        summary: AxisPlanSummary::default(),
        is_done: false,
    })
}

/// The iterator of [`plan_axes`].
#[derive(Debug)]
pub struct AxisPlan<'a, T, I> {
    task: Task<'a>,
    moves: I,
    /// What came behind the last bead.
    held: Option<Item<T>>,
    /// Where the tip is, once that is known, and the rotary axes.
    place: Option<Place>,
    rotary: [f64; 2],
    /// What is given out now.
    bead: Option<Emission<T>>,
    out: VecDeque<AxisStep<T>>,
    /// What has been printed on a polar machine is below this.
    height_mm: f64,
    /// Tilt that was not followed, and tilt, times length.
    tilt_mm: [f64; 2],
    summary: AxisPlanSummary,
    is_done: bool,
}

/// How far a bead has been given out.
#[derive(Debug)]
struct Emission<T> {
    bead: Bead<T>,
    item: usize,
    node: usize,
    /// The first place of all has been reached.
    is_placed: bool,
}

impl<T, I: Iterator<Item = PathMove<T>>> Iterator for AxisPlan<'_, T, I> {
    type Item = Result<AxisStep<T>, AxisPlanError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(step) = self.out.pop_front() {
                return Some(Ok(step));
            }
            if self.is_done {
                return None;
            }
            let advanced = match self.bead.take() {
                Some(emission) => self.give(emission),
                None => self.take(),
            };
            if let Err(error) = advanced {
                self.is_done = true;
                self.out.clear();
                return Some(Err(error));
            }
        }
    }
}

impl<T, I: Iterator<Item = PathMove<T>>> AxisPlan<'_, T, I> {
    /// What has been done so far; of all moves once the iterator has ended.
    pub fn summary(&self) -> &AxisPlanSummary {
        &self.summary
    }

    /// The next item, checked.
    fn pull(&mut self) -> Result<Option<Item<T>>, AxisPlanError> {
        if let Some(item) = self.held.take() {
            return Ok(Some(item));
        }
        let Some(content) = self.moves.next() else { return Ok(None) };
        let item = Item { index: self.summary.moves, content };
        self.summary.moves += 1;
        if let Some(step) = item.content.tip_move() {
            check(item.index, &step)?;
        }
        Ok(Some(item))
    }

    /// Takes items to the end of a bead, and plans them.
    fn take(&mut self) -> Result<(), AxisPlanError> {
        let mut items: Vec<Item<T>> = vec![];
        let mut has_bead = false;
        let mut is_placed = self.place.is_some();
        while let Some(item) = self.pull()? {
            let ends = match item.content {
                PathMove::Print { .. } if !is_placed => return Err(AxisPlanError::Unplaced { index: item.index }),
                PathMove::Print { .. } => {
                    has_bead = true;
                    false
                }
                PathMove::Travel { .. } => {
                    is_placed = true;
                    has_bead || items.len() >= MAX_TRAVELS
                }
                PathMove::Pass(_) => false,
                PathMove::Restart(_) => true,
            };
            if !ends {
                items.push(item);
                continue;
            }
            match item.content {
                PathMove::Restart(content) if items.is_empty() => {
                    self.place = None;
                    self.out.push_back(AxisStep::Pass(content));
                    return Ok(());
                }
                _ => self.held = Some(item),
            }
            break;
        }
        if items.is_empty() {
            self.is_done = self.held.is_none();
            return Ok(());
        }
        let bead = Bead::new(&self.task, items, self.place, self.rotary)?;
        self.summary.pole_passes += bead.pole_passes();
        let is_placed = self.place.is_some();
        self.bead = Some(Emission { bead, item: 0, node: 0, is_placed });
        Ok(())
    }

    /// Gives out the next item of a bead.
    fn give(&mut self, mut emission: Emission<T>) -> Result<(), AxisPlanError> {
        if emission.item == emission.bead.items.len() {
            return Ok(());
        }
        let number = emission.item;
        emission.item += 1;
        match emission.bead.items[number].content.tip_move() {
            None => self.pass(&mut emission, number),
            Some(step) if !emission.is_placed => {
                let choice = emission.bead.choices[0];
                self.check_reach(&emission.bead, 0)?;
                emission.is_placed = true;
                let from = self.task.posture(&step.to.tip, self.rotary);
                self.push(choice.arrive, at_rest(self.task.machine, &from, &choice.arrive), 0.0, [false; 2]);
                self.arrive(step.to, choice.arrive);
            }
            Some(step) => self.go(&mut emission, number, &step)?,
        }
        self.bead = Some(emission);
        Ok(())
    }

    fn pass(&mut self, emission: &mut Emission<T>, number: usize) {
        // The item is not needed again; what stands in its place is not looked at.
        let index = emission.bead.items[number].index;
        let gone = PathMove::Travel { tip: nalgebra::Point3::origin(), direction: Vector3::z_axis(), feed_mm_s: 1.0 };
        let item = std::mem::replace(&mut emission.bead.items[number], Item { index, content: gone });
        if let PathMove::Pass(content) | PathMove::Restart(content) = item.content {
            self.out.push_back(AxisStep::Pass(content));
        }
    }

    fn arrive(&mut self, pose: Pose, posture: Posture) {
        self.place = Some(Place { pose, posture });
        self.rotary = posture.rotary;
    }

    /// All intervals of a move.
    fn go(&mut self, emission: &mut Emission<T>, number: usize, step: &TipMove) -> Result<(), AxisPlanError> {
        let bead = &emission.bead;
        let mut pieces = vec![];
        let mut done = 0.0;
        while let Some(next) = bead.nodes.get(emission.node + 1).filter(|next| next.item == number) {
            let at = emission.node;
            let (choice, to) = (bead.choices[at], bead.choices[at + 1]);
            if choice.is_rewind {
                let is_bead = step.is_printing && at > 0 && bead.intervals[at - 1].is_printing;
                self.rewind(bead, at, is_bead)?;
            }
            self.check_reach(bead, at + 1)?;
            pieces.clear();
            let stretch = Stretch {
                task: &self.task,
                poses: [bead.nodes[at].pose, next.pose],
                ends: [choice.leave, to.arrive],
                branch: choice.branch,
                tolerance_mm: if step.is_printing {
                    self.task.options.tip_tolerance_mm
                } else {
                    self.task.options.travel_tolerance_mm
                },
            };
            stretch.divide(&mut pieces).map_err(|reason| bead.unreachable(at + 1, reason))?;
            let (mut pose, mut posture, mut share) = (stretch.poses[0], choice.leave, 0.0);
            for piece in &pieces {
                let part = (piece.share - share) * (next.share - done);
                self.motion(step, piece, (&pose, &posture), part);
                (pose, posture, share) = (piece.pose, piece.posture, piece.share);
            }
            done = next.share;
            self.arrive(next.pose, to.arrive);
            emission.node += 1;
        }
        Ok(())
    }

    /// Outside of poles this has been looked at before.
    fn check_reach(&self, bead: &Bead<T>, node: usize) -> Result<(), AxisPlanError> {
        let reason = self.task.machine.beyond_linear(&bead.choices[node].arrive.linear);
        reason.map_or(Ok(()), |reason| Err(bead.unreachable(node, reason)))
    }

    /// One motion of a move.
    fn motion(&mut self, step: &TipMove, piece: &Piece, (pose, posture): (&Pose, &Posture), part: f64) {
        let machine = self.task.machine;
        let length = pose.length(&piece.pose);
        let feed = length / step.feed_mm_s;
        let seconds = feed.max(at_speed(machine, posture, &piece.posture));
        if step.is_printing {
            let summary = &mut self.summary;
            if feed > 0.0 && seconds > feed * SLOWED {
                summary.slowed += 1;
                summary.worst_slowdown = summary.worst_slowdown.max(seconds / feed);
            }
            summary.max_tip_error_mm = summary.max_tip_error_mm.max(piece.tip_error);
            summary.max_direction_error_rad = summary.max_direction_error_rad.max(piece.direction_error);
            summary.filament_mm += step.filament_mm * part;
            if self.task.is_polar() {
                let upright = Pose { direction: up(&self.task), ..piece.pose };
                self.tilt_mm[0] += piece.direction_error * length;
                self.tilt_mm[1] += piece.pose.turn(&upright) * length;
                let [missed, tilt] = self.tilt_mm;
                self.summary.unfollowed_tilt = if tilt > 0.0 { (missed / tilt).min(1.0) } else { 0.0 };
                self.height_mm = self.height_mm.max(up(&self.task).dot(&piece.pose.tip));
            }
        }
        self.push(piece.posture, seconds, step.filament_mm * part, [step.is_printing, false]);
    }

    /// Lifts off at a node, goes from one posture to another one of the same pose, and comes back.
    fn rewind(&mut self, bead: &Bead<T>, node: usize, is_bead: bool) -> Result<(), AxisPlanError> {
        let options = self.task.options;
        let (at, choice) = (bead.nodes[node], bead.choices[node]);
        // What is planned of this bead counts as printed.
        let highest = bead.nodes.iter().map(|node| up(&self.task).dot(&node.pose.tip)).fold(self.height_mm, f64::max);
        let rewind =
            Rewind { task: &self.task, pose: at.pose, from: choice.arrive, to: choice.leave, clear_mm: highest };
        let motions = rewind.motions().map_err(|reason| AxisPlanError::NoSpace {
            index: bead.items[at.item].index,
            tip_mm: at.pose.tip.into(),
            reason,
        })?;
        let draws_back = is_bead && options.retract_mm > 0.0;
        let seconds = options.retract_mm / options.retract_feed_mm_s;
        if draws_back {
            self.push(choice.arrive, seconds, -options.retract_mm, [false; 2]);
        }
        for (posture, seconds) in motions {
            self.push(posture, seconds, 0.0, [false, true]);
        }
        if draws_back {
            self.push(choice.leave, seconds, options.retract_mm, [false; 2]);
        }
        let count = if is_bead { &mut self.summary.bead_rewinds } else { &mut self.summary.travel_rewinds };
        *count += 1;
        Ok(())
    }

    fn push(&mut self, posture: Posture, seconds: f64, filament_mm: f64, [printing, lifted]: [bool; 2]) {
        let machine = self.task.machine;
        let seconds = seconds.max(MIN_SECONDS);
        let axes = machine.values(&posture);
        let first = machine.linear.len();
        let readings = (0..first).map(|k| posture.linear[k]).chain(posture.rotary);
        for (used, reading) in self.summary.used.iter_mut().zip(readings) {
            *used = [used[0].min(reading), used[1].max(reading)];
        }
        self.summary.axis_moves += 1;
        self.summary.seconds += seconds;
        self.out.push_back(AxisStep::Move(AxisMove { axes, seconds, filament_mm, printing, lifted }));
    }
}

fn check(index: u64, step: &TipMove) -> Result<(), AxisPlanError> {
    let wrong = |what, value, must| Err(AxisPlanError::Number { index, what, value, must });
    if let Some(&value) = step.to.tip.iter().find(|&&value| !is_within(value, COORDINATE)) {
        return wrong("tip", value, "a coordinate from -1e6 to 1e6 mm");
    }
    let length = step.to.direction.norm();
    if !is_within(length, [1.0 - UNIT, 1.0 + UNIT]) {
        return wrong("direction", length, "of the length 1");
    }
    if !is_within(step.feed_mm_s, FEED) {
        return wrong("feed_mm_s", step.feed_mm_s, "from 0.001 to 1e5 mm/s");
    }
    if !is_within(step.filament_mm, FILAMENT) {
        return wrong("filament_mm", step.filament_mm, "from 0 to 1e6 mm");
    }
    Ok(())
}
