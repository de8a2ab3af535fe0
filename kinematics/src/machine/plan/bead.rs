//! A bead with the travels before it: what is held in memory at a time.

use super::branches::{Choice, DeadEnd, Interval, choose};
use super::error::AxisPlanError;
use super::moves::PathMove;
use super::nodes::{Node, shares};
use super::pose::Pose;
use super::task::Task;
use crate::machine::geometry::Posture;
use std::f64::consts::PI;

/// Something that went in, with its number.
#[derive(Clone, Debug)]
pub(super) struct Item<T> {
    pub index: u64,
    pub content: PathMove<T>,
}

/// A move of the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TipMove {
    pub to: Pose,
    pub feed_mm_s: f64,
    pub filament_mm: f64,
    pub is_printing: bool,
}

impl<T> PathMove<T> {
    pub(super) fn tip_move(&self) -> Option<TipMove> {
        let (tip, direction, feed_mm_s, filament_mm, is_printing) = match *self {
            PathMove::Travel { tip, direction, feed_mm_s } => (tip, direction, feed_mm_s, 0.0, false),
            PathMove::Print { tip, direction, filament_mm, feed_mm_s } => {
                (tip, direction, feed_mm_s, filament_mm, true)
            }
            PathMove::Pass(_) | PathMove::Restart(_) => return None,
        };
        let to = Pose { tip: tip.coords, direction: direction.into_inner() };
        Some(TipMove { to, feed_mm_s, filament_mm, is_printing })
    }
}

/// Where the axes are, and the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub pose: Pose,
    pub posture: Posture,
}

/// Items with their nodes and what was chosen for them.
#[derive(Clone, Debug)]
pub(super) struct Bead<T> {
    pub items: Vec<Item<T>>,
    pub nodes: Vec<Node>,
    pub intervals: Vec<Interval>,
    pub choices: Vec<Choice>,
}

/// Directions of a move that differ by half a turn but for this are opposite, radians.
const OPPOSITE: f64 = 1e-6;

impl<T> Bead<T> {
    /// Chooses branches and turns for items.
    ///
    /// # Arguments
    /// * `place`: where the axes are; `None` where that is known of the rotary ones at best.
    pub fn new(
        task: &Task<'_>,
        items: Vec<Item<T>>,
        place: Option<Place>,
        rotary: [f64; 2],
    ) -> Result<Self, AxisPlanError> {
        let mut bead = Bead { items, nodes: vec![], intervals: vec![], choices: vec![] };
        bead.lay(task, place)?;
        if bead.nodes.is_empty() {
            return Ok(bead);
        }
        let near = place.map_or(rotary, |place| place.posture.rotary);
        bead.choices = choose(task, &bead.nodes, &bead.intervals, near, place.is_some())
            .map_err(|DeadEnd { node, reason }| bead.unreachable(node, reason))?;
        Ok(bead)
    }

    pub fn unreachable(&self, node: usize, reason: crate::machine::reach::Unreachable) -> AxisPlanError {
        let Node { pose, item, .. } = self.nodes[node];
        AxisPlanError::Unreachable { index: self.items[item].index, tip_mm: pose.tip.into(), reason }
    }

    /// Nodes along all moves.
    fn lay(&mut self, task: &Task<'_>, place: Option<Place>) -> Result<(), AxisPlanError> {
        let mut at = place.map(|place| place.pose);
        if let Some(pose) = at {
            let is_inside = task.is_inside(&pose);
            self.nodes.push(Node { pose, item: 0, share: 0.0, is_inside });
        }
        let mut found = vec![];
        for (number, item) in self.items.iter().enumerate() {
            let Some(step) = item.content.tip_move() else { continue };
            let Some(from) = at.replace(step.to) else {
                // The first place of all: nothing is known of the way there.
                let is_inside = task.is_inside(&step.to);
                self.nodes.push(Node { pose: step.to, item: number, share: 1.0, is_inside });
                continue;
            };
            if PI - from.turn(&step.to) < OPPOSITE {
                return Err(AxisPlanError::Opposite { index: item.index });
            }
            found.clear();
            shares(task, &from, &step.to, &mut found);
            let seconds = from.length(&step.to) / step.feed_mm_s;
            let mut last = 0.0;
            for &share in &found {
                let pose = if share < 1.0 { from.towards(&step.to, share) } else { step.to };
                let is_inside = task.is_inside(&pose);
                self.nodes.push(Node { pose, item: number, share, is_inside });
                self.intervals.push(Interval { seconds: seconds * (share - last), is_printing: step.is_printing });
                last = share;
            }
        }
        Ok(())
    }

    /// Ways through the neighbourhood of a pole, from outside to outside.
    pub fn pole_passes(&self) -> u64 {
        let inside = self.nodes.iter().map(|node| node.is_inside);
        let mut runs = 0;
        let mut has_entered = false;
        let mut was_inside = self.nodes.first().is_some_and(|node| node.is_inside);
        for is_inside in inside {
            match (was_inside, is_inside) {
                (false, true) => has_entered = true,
                (true, false) if has_entered => runs += 1,
                _ => {}
            }
            was_inside = is_inside;
        }
        runs
    }
}
