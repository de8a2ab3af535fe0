//! What came of the stage.

use super::args::ProgramFormat;
use super::checked::Checked;
use curvlay_kinematics::workcell::{EightAxisWorkcell, SevenAxisWorkcell, SixAxisWorkcell};
use curvlay_trajectory::check::FindingClass;
use curvlay_trajectory::print::{PrintLimits, PrintOptions, PrintPlan};
use nalgebra::Isometry3;
use std::collections::BTreeSet;

/// What came of the stage, by the kind of cell.
pub enum Motion {
    Six(Box<MotionRun<6, 1, SixAxisWorkcell>>),
    Seven(Box<MotionRun<7, 1, SevenAxisWorkcell>>),
    Eight(Box<MotionRun<8, 2, EightAxisWorkcell>>),
}

/// The whole print.
pub struct MotionRun<const N: usize, const F: usize, W> {
    pub cell: W,
    pub limits: PrintLimits<N>,
    /// How far things stay apart.
    pub margin_mm: f64,
    /// Whether the arm is planned without its bodies.
    pub without_links: bool,
    pub plan: PrintPlan<N, F>,
    /// Maps the part to the frame of what carries it.
    pub frame_part: Isometry3<f64>,
    /// Where programs begin and end; `None` where there is no such posture.
    pub home: Option<[f64; N]>,
    /// What the first check of the written motions found.
    pub checked: Option<Checked<N>>,
    /// What the last one found, once the unsafe motions were taken out.
    pub rechecked: Option<Checked<N>>,
    /// Number of motions that were taken out, since they are not safe.
    pub withheld: usize,
    pub options: PrintOptions<N, F>,
    pub format: ProgramFormat,
}

/// Does the same with the run of whichever cell it is.
macro_rules! of_run {
    ($motion:expr, $run:ident => $does:expr) => {
        match $motion {
            $crate::motion::Motion::Six($run) => $does,
            $crate::motion::Motion::Seven($run) => $does,
            $crate::motion::Motion::Eight($run) => $does,
        }
    };
}
pub(crate) use of_run;

impl Motion {
    /// How long the motion takes to each waypoint from the one before: path, waypoint, seconds.
    pub fn steps(&self) -> Vec<(usize, usize, f64)> {
        of_run!(self, run => run.plan.steps())
    }
}

impl<const N: usize, const F: usize, W> MotionRun<N, F, W> {
    /// Keeps what a check found: findings of the first one, the lengths of the last one.
    pub fn take_in(&mut self, checked: Checked<N>) {
        match &mut self.checked {
            None => self.checked = Some(checked),
            Some(first) => {
                first.unprinted_mm = checked.unprinted_mm;
                first.took += checked.took;
                self.rechecked = Some(checked);
            }
        }
    }

    /// How fast the tip may travel, in mm/s.
    pub fn fastest_mm_s(&self) -> f64 {
        self.options.tip_speed.near_mm_s.max(self.options.tip_speed.far_mm_s)
    }

    /// Unsafe motions by the last check.
    pub fn unsafe_motions(&self) -> BTreeSet<usize> {
        let last = self.rechecked.as_ref().or(self.checked.as_ref());
        last.map(|checked| checked.report.print.motions_with(FindingClass::is_unsafe)).unwrap_or_default()
    }
}
