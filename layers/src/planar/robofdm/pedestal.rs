//! A pedestal between the platform and the first part.
//!
//! Departure from the dissertation, whose first part stands on the platform: there a tilted head has no room, so all sides that lean out near the
//! platform stay risky. On a prism with the section of that part's first layer, which is printed first and cut off afterwards, it has: what else
//! lies on the platform then is cut off and printed along directions in which it needs no support.

use super::head::Head;
use super::parts::PrintedPart;
use crate::planar::flat::of_sections;
use crate::planar::{CutPlane, FlatError, FlatLayers, MAX_LAYERS, PlaneFrame, Region, Solid, slice};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeSet;

/// A prism below a part, with the section of its first layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Pedestal {
    section: Region,
    /// The plane of its top.
    frame: PlaneFrame,
    direction: Vector3<f64>,
    top_mm: f64,
    height_mm: f64,
}

impl Pedestal {
    /// The pedestal of the first part.
    ///
    /// # Arguments
    /// * `direction`: that in which it is printed, of length 1.
    /// * `layer_mm`: height of the first layer; its section is that at half this height.
    /// * `height_mm`: height of the pedestal.
    ///
    /// # Returns
    /// `None` without height, or where the first layer has no section.
    ///
    /// # Cost
    /// A slice of the mesh.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// use curvlay_layers::planar::Solid;
    /// use curvlay_layers::planar::robofdm::Pedestal;
    /// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 3.0, f64::from(i >> 2) * 9.0)).collect();
    /// let faces = [
    ///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
    ///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
    /// ];
    /// let pedestal = Pedestal::new(&Solid::new(&points, &faces)?, &Vector3::z(), 0.5, 6.0).unwrap();
    /// assert!((pedestal.volume_mm3() - 72.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(part: &Solid, direction: &Vector3<f64>, layer_mm: f64, height_mm: f64) -> Option<Self> {
        let [low, high] = part.extent(direction);
        let is_high = height_mm > 0.0 && height_mm.is_finite() && layer_mm > 0.0;
        let lowest = CutPlane::through(&Point3::from(direction * low), direction).ok().filter(|_| is_high)?;
        let frame = PlaneFrame::of(&lowest);
        let section = Region::of(&slice(part, &lowest.moved(0.5 * layer_mm.min(high - low)), &frame));
        let pedestal = Pedestal { section, frame, direction: *direction, top_mm: low, height_mm };
        (!pedestal.section.is_empty()).then_some(pedestal)
    }

    /// Its height, in mm.
    pub fn height_mm(&self) -> f64 {
        self.height_mm
    }

    /// Its volume, in mm3.
    pub fn volume_mm3(&self) -> f64 {
        self.section.area() * self.height_mm
    }

    /// Its layers, as near to the wanted height as fills it exactly.
    ///
    /// # Errors
    /// [`FlatError::Height`] for a height that is not positive, or too small for [`MAX_LAYERS`].
    pub fn layers(&self, height_mm: f64) -> Result<FlatLayers, FlatError> {
        if !(height_mm > 0.0 && self.height_mm / height_mm <= MAX_LAYERS as f64) {
            return Err(FlatError::Height { height_mm, part_mm: self.height_mm });
        }
        let count = (self.height_mm / height_mm).round().max(1.0);
        let foot = self.top_mm - self.height_mm;
        let at = |k: usize| foot + self.height_mm * k as f64 / count;
        let sections = (0..count as usize).map(|k| ([at(k), at(k + 1)], self.section.clone()));
        Ok(of_sections(self.direction, self.frame, sections))
    }

    /// It as a closed mesh, triangles counter-clockwise from outside.
    pub fn mesh(&self) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let Ok(layers) = self.layers(self.height_mm) else { return (Vec::new(), Vec::new()) };
        let half = self.direction * (self.height_mm / 2.0);
        let mut points = Vec::new();
        let mut faces = Vec::new();
        for layer in &layers.layers {
            let count = layer.vertices.len() as u32;
            points.extend(layer.vertices.iter().map(|p| p - half));
            points.extend(layer.vertices.iter().map(|p| p + half));
            let edges = || layer.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let all: BTreeSet<[u32; 2]> = edges().collect();
            faces.extend(layer.triangles.iter().flat_map(|&[a, b, c]| [[a, c, b], [a, b, c].map(|v| v + count)]));
            let rim = edges().filter(|&[a, b]| !all.contains(&[b, a]));
            faces.extend(rim.flat_map(|[a, b]| [[a, b, b + count], [a, b + count, a + count]]));
        }
        (points, faces)
    }

    /// Its sides.
    pub(super) fn sides(&self) -> Vec<[Point3<f64>; 3]> {
        let down = self.direction * self.height_mm;
        let side = |edge: [nalgebra::Point2<f64>; 2]| {
            let [a, b] = edge.map(|p| self.frame.place(&p));
            [[a - down, b - down, b], [a - down, b, a]]
        };
        self.section.edges().flat_map(side).collect()
    }
}

/// The lowest pedestal on which the head passes the platform with all parts as they are, in steps of its layer; at most that of the head, which
/// is returned where no lower one is enough.
///
/// # Arguments
/// * `solid`: the whole.
/// * `parts`: in their order, found with this head.
///
/// # Cost
/// A test of the head for each part and each of some steps: they are halved.
pub fn lowest_pedestal(solid: &Solid, parts: &[PrintedPart], head: &Head) -> f64 {
    let Some((first, up)) = parts.first().map(|first| (&first.solid, first.direction)) else { return 0.0 };
    let [low, high] = solid.bounds();
    let middle = low + (high - low) / 2.0;
    let lowest = first.extent(&up)[0];
    let corners: Vec<Vec<[Point3<f64>; 3]>> =
        parts.iter().map(|part| (0..part.solid.triangles().len()).map(|k| part.solid.corners(k)).collect()).collect();
    let passes = |height: f64| {
        let foot = middle + up * (lowest - height - middle.coords.dot(&up));
        let sides = Pedestal::new(first, &up, head.layer, height).map_or(Vec::new(), |pedestal| pedestal.sides());
        let standing: Vec<_> = head.platform(&foot, &up).into_iter().chain(sides).collect();
        let head = Head { pedestal: height, ..*head };
        parts.iter().zip(&corners).all(|(part, own)| !head.meets(&part.direction, own.iter(), standing.iter()))
    };
    // Fewer steps than `from` are too few, `enough` are enough.
    let steps = (head.pedestal / head.layer).ceil() as usize;
    let height = |step: usize| (step as f64 * head.layer).min(head.pedestal);
    let (mut from, mut enough) = (0, steps);
    while from < enough {
        let step = usize::midpoint(from, enough);
        if passes(height(step)) {
            enough = step;
        } else {
            from = step + 1;
        }
    }
    height(enough)
}
