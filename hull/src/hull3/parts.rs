//! What a hull is made of: its facets, the journal of what was changed, and memory that is used again.

use crate::plane::Plane;

/// No facet, no point.
pub(super) const NONE: u32 = u32::MAX;

/// The ideal point in `points`; its coordinates are a direction.
pub(super) const IDEAL: u32 = 0;

/// A triangle of the surface, counter-clockwise from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facet {
    pub(crate) corners: [u32; 3],
    /// Entry `i` is the facet across the edge from corner `i` to the next.
    pub(crate) across: [u32; 3],
}

/// What undoes one change.
#[derive(Clone, Debug)]
pub(super) enum Undo {
    /// The body had no volume, and these extreme points.
    Flat(Vec<[i32; 3]>),
    Removed {
        facet: u32,
        plane: Plane,
        triangle: Facet,
    },
    Made {
        facet: u32,
        reused: bool,
    },
    Linked {
        facet: u32,
        edge: usize,
        across: u32,
    },
    Point,
}

/// Lists that are empty between calls; kept for their memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    pub(super) removed: Vec<u32>,
    pub(super) made: Vec<u32>,
    pub(super) horizon: Vec<HorizonEdge>,
    /// For each point: the new facet whose edge on the horizon starts there.
    pub(super) starting_at: Vec<u32>,
    /// For each facet: the first point that waits outside it.
    pub(super) waiting: Vec<u32>,
}

/// An edge between what a new point removes and what stays.
#[derive(Clone, Copy, Debug)]
pub(super) struct HorizonEdge {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) stays: u32,
    pub(super) edge_there: usize,
}
