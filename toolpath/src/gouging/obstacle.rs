//! What a nozzle runs into.

use crate::layer::{MOULD, Triangle};

/// What a nozzle runs into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Obstacle {
    /// A layer, from 0; the waypoint's own or an earlier one.
    Layer(u32),
    /// The mould, or the part that existed before.
    Mould,
    /// The plate.
    Plate,
}

impl Obstacle {
    pub(super) fn of(triangle: &Triangle) -> Self {
        if triangle.layer == MOULD { Obstacle::Mould } else { Obstacle::Layer(triangle.layer) }
    }
}

impl std::fmt::Display for Obstacle {
    /// `layer N`, counted from 1, `mould`, or `plate`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Obstacle::Layer(layer) => write!(f, "layer {}", layer + 1),
            Obstacle::Mould => f.write_str("mould"),
            Obstacle::Plate => f.write_str("plate"),
        }
    }
}
