//! Where the nozzle is too deep, and pieces of curves that are not printed for that.

use super::nozzle::NozzlePart;
use super::obstacle::Obstacle;
use crate::orientation::ToolPath;
use nalgebra::Point3;

/// A waypoint where the nozzle is too deep in a layer, however it is tilted. Its direction is one that is least deep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gouge {
    /// The path, by its place in the list of paths.
    pub path: usize,
    /// The waypoint, from 0.
    pub waypoint: usize,
    /// What the nozzle is in.
    pub obstacle: Obstacle,
    /// How deep it is in the layer, or how far below the plate, in millimetres.
    pub depth: f64,
    /// Which part of the nozzle is deepest.
    pub part: NozzlePart,
    /// Whether only beads of the same layer close it in: without them a tilt would free it.
    pub own_layer: bool,
}

/// A piece of a curve that is not printed: somewhere on it the nozzle would run into what is built, however it is tilted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// The layer, from 0.
    pub layer: u32,
    /// The curve of the layer, from 0.
    pub curve: u32,
    /// Where it begins and ends, by length along the curve in millimetres.
    pub arcs: [f64; 2],
    /// The tip where the nozzle would be deepest.
    pub tip: Point3<f64>,
    /// What it would be in there.
    pub obstacle: Obstacle,
    /// How deep, in millimetres.
    pub depth: f64,
    /// Which part of it.
    pub part: NozzlePart,
}

impl LeftOut {
    pub(super) fn new(piece: &ToolPath, gouge: &Gouge) -> Option<LeftOut> {
        let (first, last) = (piece.waypoints.first()?, piece.waypoints.last()?);
        let tip = piece.waypoints.get(gouge.waypoint)?.position;
        let (&ToolPath { layer, curve, .. }, &Gouge { obstacle, depth, part, .. }) = (piece, gouge);
        Some(LeftOut { layer, curve, arcs: [first.arc, last.arc], tip, obstacle, depth, part })
    }
}
