//! The path that was found.

use std::ops::Range;

/// The node chosen at a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LadderNode<const N: usize, const F: usize> {
    /// Joints within their bounds; from one waypoint to the next without whole turns, but at a break.
    pub joints: [f64; N],
    /// The free parameters.
    pub free: [f64; F],
    /// The robot's branch.
    pub branch: u32,
}

/// A path through the ladder: one node at each waypoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder<const N: usize, const F: usize> {
    /// The chosen nodes, one at each waypoint.
    pub nodes: Vec<LadderNode<N, F>>,
    /// The first waypoints of the motions after the first; none when the path never breaks off.
    pub breaks: Vec<usize>,
    /// `J_trans` of Eq. 4.6 (the sum of Eq. 3.4 with [`Norm::Absolute`](super::Norm::Absolute)), without the breaks; with the way from
    /// [`LadderOptions::from`](super::LadderOptions::from).
    pub cost: f64,
    /// The samples with which it was found, or last refined.
    pub samples: [u32; F],
}

impl<const N: usize, const F: usize> Ladder<N, F> {
    /// The waypoints of each unbroken motion.
    pub fn runs(&self) -> impl Iterator<Item = Range<usize>> {
        runs(&self.breaks, self.nodes.len())
    }

    /// The joints of all waypoints.
    pub fn joints(&self) -> Vec<[f64; N]> {
        self.nodes.iter().map(|node| node.joints).collect()
    }
}

/// What lies between breaks.
pub(super) fn runs(breaks: &[usize], nodes: usize) -> impl Iterator<Item = Range<usize>> {
    let starts = std::iter::once(0).chain(breaks.iter().copied());
    let ends = breaks.iter().copied().chain(std::iter::once(nodes));
    starts.zip(ends).map(|(start, end)| start..end)
}
