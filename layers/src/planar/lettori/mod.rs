//! Volume decomposition for robots that lay flat layers along several directions.
//!
//! J. Lettori, R. Raffaelli, M. Borsato, M. Pellicciari and M. Peruzzini, "An approach for volume decomposition in robot-based
//! additive manufacturing", CAD'22, 2022. A part is sliced along its direction; the area that each layer carries is followed from
//! layer to layer; where a layer hangs over, a wall is put up before the overhang, and what is beyond it becomes a part that is
//! printed along the wall's normal, and is decomposed in turn.
//!
//! Two kinds of overhang: where the outline crosses the offset of the layer below (Fig. 1b), one wall through the interpolant plane
//! of the intersection points; where it does not (Fig. 1c), four walls around the largest rectangle in the layer that carries,
//! printed in the inverse order.
//!
//! Departures from the paper, each where it says nothing or too little:
//! * Regions of overhang are taken off one after the other, the lowest first; the paper has one.
//! * What a wall cuts that neither hangs over nor floats stays with the part; the paper's walls end with the part.
//! * Where the interpolant plane has no direction across the layers (points of one layer), the line through the points has it.
//! * The four walls of Fig. 4 are tilted below the first layer with overhang as that of Fig. 3 is.
//! * Parts printed before carry those printed later; so the base of a part need not be flat.

mod audit;
mod base;
mod features;
mod layers;
mod options;
mod rectangle;
mod regions;
mod separate;
mod wall;

use super::{Partition, Region, Solid};
use crate::Progress;
use layers::{Layered, Stand, analyse};
use nalgebra::{Point3, Vector3};
use regions::{OverhangRegion, first_region};
use separate::separate;
use std::ops::ControlFlow;
use wall::{interpolant, wall_of, walls_around};

pub use audit::{AuditOptions, VolumeAudit, audit_volumes};
pub use features::{Feature, FeatureKind};
pub use options::{BaseChoice, VolumeError, VolumeOptions};
pub use rectangle::largest_rectangle;
pub use wall::SeparationWall;

/// A part that is printed in flat layers.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePart {
    /// Its mesh, in the place where it belongs.
    pub solid: Solid,
    /// The direction in which its layers are stacked, of length 1.
    pub direction: Vector3<f64>,
    /// Its base plane: the distance from the origin along the direction.
    pub base_mm: f64,
    /// The separation that made it, by number in [`VolumeDecomposition::separations`]; `None` for the part on the plate.
    pub separation: Option<usize>,
    /// Where its layers end, along the direction.
    pub layer_tops_mm: Vec<f64>,
    /// Volume of its layers that nothing carries: 0 unless the decomposition is [`Stuck`].
    pub overhang_mm3: f64,
}

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
    /// There would be more parts than [`VolumeOptions::max_parts`].
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

/// A cell that is not finished.
struct Open {
    cell: u32,
    stand: Stand,
    separation: Option<usize>,
}

/// How much of a part's volume must go and must stay in a separation: less is rounding.
const SHARE: f64 = 1e-9;

/// Divides a solid into parts without overhang.
///
/// # Errors
/// [`VolumeError`] for options that cannot be used with this part, and when `progress` breaks off. A part that keeps its overhang is
/// no error: see [`VolumeDecomposition::stuck`].
///
/// # Cost
/// For each separation the layers of one part are sliced, `O(layers * triangles)`, and their polygons offset. The result does not depend
/// on threads: there is one.
///
/// # Example
/// ```
/// use curvlay_layers::planar::{Solid, VolumeOptions, decompose_volume};
/// // A flipped L: a post of 30 by 30 by 90 mm, and an arm of 60 by 30 by 30 mm at its top.
/// let outline = [[0.0, 0.0], [30.0, 0.0], [30.0, 60.0], [90.0, 60.0], [90.0, 90.0], [30.0, 90.0], [0.0, 90.0], [0.0, 60.0]];
/// let vertices: Vec<_> = [0.0, 30.0].iter().flat_map(|&y| outline.map(|[x, z]| [x, y, z].into())).collect();
/// let mut triangles = Vec::new();
/// for [a, b, c, d] in [[0, 1, 2, 7], [7, 2, 5, 6], [2, 3, 4, 5]] {
///     triangles.extend([[a, b, c], [a, c, d], [a + 8, c + 8, b + 8], [a + 8, d + 8, c + 8]]);
/// }
/// for k in 0..8 {
///     let next = (k + 1) % 8;
///     triangles.extend([[k, k + 8, next + 8], [k, next + 8, next]]);
/// }
/// let solid = Solid::new(&vertices, &triangles)?;
/// let silent = |_| std::ops::ControlFlow::Continue(());
/// let result = decompose_volume(&solid, &VolumeOptions::default(), &silent)?;
/// assert_eq!((result.parts.len(), result.stuck.len()), (2, 0));
/// assert!((result.parts[1].direction.x - 1.0).abs() < 1e-9);
/// // The post carries a layer's height of the arm.
/// assert!((result.parts[1].solid.volume() - 57.0 * 30.0 * 30.0).abs() < 1e-6 * solid.volume());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn decompose_volume(
    solid: &Solid,
    options: &VolumeOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<VolumeDecomposition, VolumeError> {
    let [low, high] = solid.bounds();
    options.check((high - low).amax())?;
    let direction = base::direction(solid, options)?;
    let base = solid.extent(&direction)[0];
    let mut result = VolumeDecomposition {
        parts: Vec::new(),
        separations: Vec::new(),
        features: Vec::new(),
        overhang_before_mm3: 0.0,
        stuck: Vec::new(),
    };
    let mut partition = Partition::new(solid);
    let stand = Stand { direction, base, on_plate: true };
    let mut open = vec![Open { cell: 0, stand, separation: None }];
    while let Some(mut part) = open.pop() {
        let done = result.parts.len() as u64;
        if progress(Progress { stage: "decompose", done, total: done + 1 + open.len() as u64 }).is_break() {
            return Err(VolumeError::Stopped);
        }
        let Ok(own) = partition.part(part.cell) else {
            // Cells are manifolds: they come from cuts, and merges of neighbours.
            debug_assert!(false, "a part is no manifold");
            continue;
        };
        let earlier: Vec<&Solid> = result.parts.iter().map(|part| &part.solid).collect();
        let layered = analyse(&own, &part.stand, &earlier, options);
        let overhang_mm3 = layered.overhang_mm3();
        if result.separations.is_empty() {
            result.overhang_before_mm3 = overhang_mm3;
        }
        let region = first_region(&layered, options);
        let mut stuck = None;
        if let Some(region) = region {
            if result.parts.len() + open.len() + 1 >= options.max_parts {
                stuck = Some(StuckReason::TooManyParts);
            } else if let Some((step, rest, taken)) = take_off(&mut partition, &part, &own, &layered, &region, options)
            {
                part.cell = rest;
                let number = result.separations.len();
                result.separations.push(step);
                let (cell, stand, separation) = (part.cell, part.stand, part.separation);
                // What was taken off last is printed first: what was cut off before leans on it.
                open.extend(taken.into_iter().map(|(cell, stand)| Open { cell, stand, separation: Some(number) }));
                open.push(Open { cell, stand, separation });
                continue;
            } else {
                stuck = Some(StuckReason::NoWall);
            }
        }
        if let Some(reason) = stuck {
            result.stuck.push(Stuck { part: result.parts.len(), reason });
        }
        result.features.extend(&layered.features);
        result.parts.push(VolumePart {
            solid: own,
            direction: part.stand.direction,
            base_mm: part.stand.base,
            separation: part.separation,
            layer_tops_mm: layered.layers.iter().map(|layer| layer.high).collect(),
            overhang_mm3,
        });
    }
    Ok(result)
}

type Taken = Vec<(u32, Stand)>;

/// Takes the region off: by one wall, or by four if it has no intersection points or no single wall will do.
fn take_off(
    partition: &mut Partition,
    part: &Open,
    own: &Solid,
    layered: &Layered,
    region: &OverhangRegion,
    options: &VolumeOptions,
) -> Option<(Separation, u32, Taken)> {
    let crosses = region.points.iter().any(|(layer, _)| *layer == region.first);
    let single =
        crosses.then(|| wall_of(layered, region, options)).flatten().map(|wall| (vec![wall], None, Scenario::Crossing));
    let four = || {
        walls_around(layered, region, options)
            .map(|(walls, corners)| (walls.to_vec(), Some(corners), Scenario::Enclosing))
    };
    let mut choices = vec![single];
    choices.push(four());
    for (walls, rectangle, scenario) in choices.into_iter().flatten() {
        let mut trial = partition.clone();
        let (mut rest, mut taken) = (part.cell, Taken::new());
        for wall in &walls {
            if let Some(separated) = separate(&mut trial, rest, wall, layered, region, part.stand.base) {
                rest = separated.rest;
                let stand = Stand { direction: wall.upright.normal(), base: wall.upright.offset(), on_plate: false };
                taken.extend(separated.taken.into_iter().map(|cell| (cell, stand)));
            }
        }
        let whole = partition.volume(part.cell);
        let taken_mm3: f64 = taken.iter().map(|&(cell, _)| trial.volume(cell)).sum();
        if taken_mm3 < SHARE * whole || whole - taken_mm3 < SHARE * whole {
            continue;
        }
        *partition = trial;
        let outlines = |of: &Region, height: f64| -> Vec<Vec<Point3<f64>>> {
            let contours =
                of.polygons().into_iter().flat_map(|polygon| std::iter::once(polygon.outer).chain(polygon.holes));
            contours.map(|contour| contour.iter().map(|p| layered.place(p, height)).collect()).collect()
        };
        let step = Separation {
            solid: own.clone(),
            direction: layered.direction,
            scenario,
            height_mm: layered.layers[region.first].low,
            carried: layered.layers.iter().flat_map(|layer| outlines(&layer.supported, layer.middle())).collect(),
            overhang: layered.layers.iter().flat_map(|layer| outlines(&layer.overhang, layer.middle())).collect(),
            points: region.points.iter().map(|&(_, p)| p).collect(),
            interpolant: interpolant(region),
            rectangle,
            walls,
            overhang_mm3: layered.overhang_mm3(),
            taken_mm3,
        };
        return Some((step, rest, taken));
    }
    None
}
