//! What a decomposition is: parts, and how they came about.

use super::features::Feature;
use super::part::VolumePart;
use super::wall::SeparationWall;
use crate::planar::Solid;
use nalgebra::{Point3, Vector3};

/// How overhang was taken off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// Fig. 1b: the outline crosses the offset of the layer below; one wall.
    Crossing,
    /// Fig. 1c: it does not; four walls.
    Enclosing,
}

/// A step of the decomposition, for pictures and tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// The part that hung over, as it was before, with its direction.
    pub solid: Solid,
    /// Its direction.
    pub direction: Vector3<f64>,
    /// What was found.
    pub scenario: Scenario,
    /// Height of the bottom of the first layer with overhang, along the direction.
    pub height_mm: f64,
    /// Outlines of the layers: what is carried, and what is not.
    pub carried: Vec<Vec<Point3<f64>>>,
    /// See `carried`.
    pub overhang: Vec<Vec<Point3<f64>>>,
    /// The intersection points.
    pub points: Vec<Point3<f64>>,
    /// The interpolant plane: a point and its normal.
    pub interpolant: Option<(Point3<f64>, Vector3<f64>)>,
    /// The corners of the inscribed rectangle.
    pub rectangle: Option<[Point3<f64>; 4]>,
    /// The walls, in the order in which they cut.
    pub walls: Vec<SeparationWall>,
    /// Volume of overhang in the part before.
    pub overhang_mm3: f64,
    /// Volume that was taken off.
    pub taken_mm3: f64,
}

/// Why overhang is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StuckReason {
    /// No wall leaves both what carries the overhang and something beyond it: the part stopped shrinking.
    NoWall,
    /// There would be more parts than [`VolumeOptions::max_parts`](super::VolumeOptions::max_parts).
    TooManyParts,
}

/// A part that keeps its overhang.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stuck {
    /// Its number in [`VolumeDecomposition::parts`].
    pub part: usize,
    /// Why.
    pub reason: StuckReason,
}

/// A solid in parts.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeDecomposition {
    /// The parts in the order in which they are printed.
    pub parts: Vec<VolumePart>,
    /// How they came about.
    pub separations: Vec<Separation>,
    /// Holes and features that sections were closed over, or that were left out of them.
    pub features: Vec<Feature>,
    /// Volume that nothing carries if the whole is printed along the first direction.
    pub overhang_before_mm3: f64,
    /// Parts that keep overhang; none if all is well.
    pub stuck: Vec<Stuck>,
}
