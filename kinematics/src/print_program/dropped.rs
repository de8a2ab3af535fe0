//! Steps of a print, with a count of what has none.

use std::cell::Cell;
use std::rc::Rc;

/// Steps that are made when the iterator is advanced. Motions without a pose are counted: [`dropped`](Self::dropped) is complete behind the last step.
///
/// # Example
/// ```
/// # #[cfg(feature = "serde")] {
/// use curvlay_kinematics::print_program::{BlendOptions, BlendedSegment, PrintKnot, print_blended};
/// use curvlay_kinematics::workcell::AnyWorkcell;
/// let file = include_str!("../../../examples/cells/irb1200-table.json");
/// let AnyWorkcell::Eight(workcell) = AnyWorkcell::from_json(file.as_bytes())? else { return Err("it has no table".into()) };
/// // A table that is tilted by 9 rad.
/// let beyond = |time_s: f64| PrintKnot { time_s, joints: [0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 9.0, 0.0], filament_mm: 0.0 };
/// let segment = BlendedSegment { samples: vec![beyond(0.0), beyond(1.0)], prints: true };
/// let mut steps = print_blended(&workcell, [segment], BlendOptions::default());
/// assert_eq!((steps.by_ref().count(), steps.dropped()), (0, 1));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PrintSteps<I> {
    steps: I,
    dropped: Rc<Cell<u64>>,
}

impl<I> PrintSteps<I> {
    /// Steps that are made with a counter.
    pub(super) fn new(make: impl FnOnce(Rc<Cell<u64>>) -> I) -> Self {
        let dropped = Rc::new(Cell::new(0));
        PrintSteps { steps: make(dropped.clone()), dropped }
    }

    /// Number of motions, or of their moves, left out so far because the controller has no pose for a posture: a table beyond its limits
    /// ([`Workcell::controller_pose`](crate::workcell::Workcell::controller_pose)). A program with such gaps is not the print.
    pub fn dropped(&self) -> u64 {
        self.dropped.get()
    }
}

impl<I: Iterator> Iterator for PrintSteps<I> {
    type Item = I::Item;

    fn next(&mut self) -> Option<I::Item> {
        self.steps.next()
    }
}

/// Counts one more.
pub(super) fn count(dropped: &Cell<u64>) {
    dropped.set(dropped.get() + 1);
}
