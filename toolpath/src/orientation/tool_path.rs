//! Paths of the tip with the direction of the nozzle.

use crate::path::BeadKind;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Where the nozzle is, how it stands and what it lays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Where the tip of the nozzle is, in millimetres.
    pub position: Point3<f64>,
    /// Axis of the nozzle, from the tip into it. Material leaves the tip against this direction.
    pub axis: UnitVector3<f64>,
    /// Width of the bead, in millimetres.
    pub width: f64,
    /// Height of the bead: the thickness of the layer here, in millimetres.
    pub height: f64,
    /// Length of the curve on the surface up to here, in millimetres.
    pub arc: f64,
    /// Whether it is no sample of the curve, but was put between two of them so that neighbours turn less.
    pub added: bool,
    /// From the top of the bead to the tip, in millimetres: 0 but where the nozzle would be too deep in what is built however it
    /// stood, and the tip is raised across the layer ([`crate::gouging::GougingOptions::max_lift`]).
    pub lift: Vector3<f64>,
    /// What the bead is for here.
    pub kind: BeadKind,
}

impl Waypoint {
    /// The top of the bead: the tip where it is not raised.
    pub fn bead_top(&self) -> Point3<f64> {
        self.position - self.lift
    }
}

/// The waypoints along a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPath {
    /// The layer, from 0.
    pub layer: u32,
    /// The curve of the layer, from 0.
    pub curve: u32,
    /// Whether the curve is closed; the last waypoint then stands where the first one does.
    pub closed: bool,
    /// In order.
    pub waypoints: Vec<Waypoint>,
}

impl ToolPath {
    /// The path from its end to its start.
    pub(crate) fn reversed(&self) -> ToolPath {
        let length = self.waypoints.last().map_or(0.0, |last| last.arc);
        let waypoints = self.waypoints.iter().rev().map(|w| Waypoint { arc: length - w.arc, ..*w }).collect();
        ToolPath { waypoints, ..*self }
    }
}
