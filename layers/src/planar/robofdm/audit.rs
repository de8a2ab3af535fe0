//! Whether parts are the solid, and whether each can be printed on the earlier ones: a check from first principles.
//!
//! It takes closed meshes, directions and an order, and knows nothing of planes, facets that are risky, or how the parts were found. It asks
//! for points in space in which parts they are, and slices every part into layers: each must lie on the one below or on earlier parts,
//! but for what the self-support angle lets it lean out.

use super::audited::AuditedPart;
use super::contacts::contacts;
use super::error::RoboFdmError;
use super::head::Head;
use crate::planar::{CutPlane, MAX_LAYERS, PlaneFrame, Region, Solid, slice};
use crate::{Progress, ProgressFn};
use nalgebra::Point3;

/// How parts are checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditOptions {
    /// Height of a layer, in mm; at most [`MAX_LAYERS`] of them make up a part. Default 0.5.
    pub layer: f64,
    /// The self-support angle, in radians from upright: a layer may lean out by its height times the tangent. Default 45 degrees.
    pub max_angle: f64,
    /// Points along each side of the bounding box that are asked for their part. Default 7: 343 points.
    pub points: u32,
    /// Share of a layer that may lie on nothing: of its area, or of the mean area of the part's layers where that is larger, so that a tip of
    /// less than a bead does not count. Default 0.05: with less, rims of feet that are flat to a triangle of the mesh fail, with more, layers hang
    /// that the risky area of a part hardly shows.
    pub max_unsupported: f64,
    /// Difference of the volumes, relative, that is rounding. Default 1e-9.
    pub max_volume_error: f64,
    /// The head that must meet nothing that stands; base planes may then look down. Default `None`: constraint II.
    pub head: Option<Head>,
}

impl Default for AuditOptions {
    fn default() -> Self {
        Self {
            layer: 0.5,
            max_angle: std::f64::consts::FRAC_PI_4,
            points: 7,
            max_unsupported: 0.05,
            max_volume_error: 1e-9,
            head: None,
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, PartialEq)]
pub struct PartsAudit {
    /// Volume of all parts over that of the solid, minus one.
    pub volume_error: f64,
    /// Points that are in no part although they are in the solid, in several parts, or in one although they are outside.
    pub misplaced_points: usize,
    /// Parts whose direction looks down when the first one is printed: constraint II.
    pub looking_down: Vec<usize>,
    /// With a head: places of each part where the head would be deeper than a quarter of a layer in earlier parts or the platform.
    pub head_contacts: Vec<usize>,
    /// How deep the deepest is, in mm.
    pub deepest_contact_mm: f64,
    /// Layers of each part.
    pub layers: Vec<usize>,
    /// Area of the layers of each part, in mm2.
    pub layer_mm2: Vec<f64>,
    /// Area of the layers of each part that lies on nothing, in mm2, seen along its direction.
    pub unsupported_mm2: Vec<f64>,
    /// Layers of each part of which more than [`AuditOptions::max_unsupported`] lies on nothing.
    pub hanging_layers: Vec<usize>,
    /// The layer of which the largest share lies on nothing; none if all layers lie on something.
    pub worst_layer: Option<WorstLayer>,
    /// Whether all of this is within the limits of the options.
    pub is_ok: bool,
}

/// A layer that lies on nothing in part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstLayer {
    /// The part, from 0.
    pub part: usize,
    /// The layer in it, from 0.
    pub layer: usize,
    /// Which share of it lies on nothing, as [`AuditOptions::max_unsupported`] has it.
    pub share: f64,
}

/// Rounding of the slices, as a share of how far a layer may lean out.
const SLACK: f64 = 0.02;

/// How far below the horizon a direction may look: rounding. A level one does not look down.
const LEVEL: f64 = 1e-9;

/// By which shares of a step the grid of points is moved: irrational ones, so that no point lies on a face that was modelled or cut.
const SHIFTS: [f64; 3] = [0.414_213_562, 0.618_033_988, 0.732_050_807];

/// Checks parts.
///
/// # Errors
/// [`RoboFdmError::Option`] for an option out of range, [`RoboFdmError::Empty`] without parts, [`RoboFdmError::Cancelled`].
///
/// # Cost
/// `O(n)` for each layer and each point of `n` triangles, and booleans of polygons for each layer. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::Solid;
/// use curvlay_layers::planar::robofdm::{AuditOptions, AuditedPart, audit_parts};
/// use std::ops::ControlFlow;
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let rod = Solid::new(&points, &faces)?;
/// let part = AuditedPart { solid: &rod, direction: Vector3::z(), on_platform: true };
/// let audit = audit_parts(&rod, &[part], &AuditOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert!(audit.is_ok && audit.layers == [80]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn audit_parts(
    solid: &Solid,
    parts: &[AuditedPart],
    options: &AuditOptions,
    progress: ProgressFn,
) -> Result<PartsAudit, RoboFdmError> {
    options.check()?;
    let Some(first) = parts.first() else { return Err(RoboFdmError::Empty) };
    if parts.iter().any(|part| layer_count(part, options) > MAX_LAYERS as f64) {
        return Err(RoboFdmError::Option { name: "layer", value: options.layer });
    }
    let volume: f64 = parts.iter().map(|part| part.solid.volume()).sum();
    let down = |&p: &usize| parts[p].direction.dot(&first.direction) < -LEVEL;
    let (head_contacts, deepest_contact_mm) = options.head.map_or((Vec::new(), 0.0), |head| contacts(parts, &head));
    let mut audit = PartsAudit {
        volume_error: volume / solid.volume() - 1.0,
        misplaced_points: misplaced(solid, parts, options.points),
        looking_down: (0..parts.len()).filter(down).collect(),
        head_contacts,
        deepest_contact_mm,
        layers: Vec::new(),
        layer_mm2: Vec::new(),
        unsupported_mm2: Vec::new(),
        hanging_layers: Vec::new(),
        worst_layer: None,
        is_ok: false,
    };
    for part in 0..parts.len() {
        if progress(Progress { stage: "audit", done: part as u64, total: parts.len() as u64 }).is_break() {
            return Err(RoboFdmError::Cancelled);
        }
        let layers = layers(&parts[part], &parts[..part], options);
        let sum = |k: usize| layers.iter().map(|layer| layer[k]).sum::<f64>();
        audit.layers.push(layers.len());
        audit.layer_mm2.push(sum(0));
        audit.unsupported_mm2.push(sum(1));
        let mean = sum(0) / layers.len().max(1) as f64;
        let shares = || layers.iter().map(|[area, unsupported]| unsupported / area.max(mean).max(f64::MIN_POSITIVE));
        audit.hanging_layers.push(shares().filter(|&share| share > options.max_unsupported).count());
        for (layer, share) in shares().enumerate().filter(|(_, share)| *share > 0.0) {
            if audit.worst_layer.is_none_or(|worst| share > worst.share) {
                audit.worst_layer = Some(WorstLayer { part, layer, share });
            }
        }
    }
    audit.is_ok = audit.volume_error.abs() <= options.max_volume_error
        && audit.misplaced_points == 0
        && (options.head.is_some() || audit.looking_down.is_empty())
        && audit.head_contacts.iter().all(|&contacts| contacts == 0)
        && audit.hanging_layers.iter().all(|&layers| layers == 0);
    Ok(audit)
}

impl AuditOptions {
    fn check(&self) -> Result<(), RoboFdmError> {
        self.head.map_or(Ok(()), |head| head.check())?;
        let named = [
            ("layer", self.layer, 1e-6, 1e9),
            ("max_angle", self.max_angle, 1e-6, std::f64::consts::FRAC_PI_2 - 1e-6),
            ("points", f64::from(self.points), 0.0, 100.0),
            ("max_unsupported", self.max_unsupported, 0.0, 1.0),
            ("max_volume_error", self.max_volume_error, 0.0, 1.0),
        ];
        match named.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value)) {
            Some((name, value, ..)) => Err(RoboFdmError::Option { name, value }),
            None => Ok(()),
        }
    }
}

/// Points of a grid that are not in one part if they are in the solid, and in none otherwise.
fn misplaced(solid: &Solid, parts: &[AuditedPart], points: u32) -> usize {
    let [low, high] = solid.bounds();
    let place = |i: u32, j: u32, k: u32| {
        let share = [i, j, k].map(f64::from);
        let along = |axis: usize| (share[axis] + SHIFTS[axis]) / f64::from(points);
        Point3::from([0, 1, 2].map(|axis| low[axis] + (high[axis] - low[axis]) * along(axis)))
    };
    let is_wrong = |p: Point3<f64>| {
        let inside = |solid: &Solid| usize::from(solid.winding(&p) > 0.5);
        parts.iter().map(|part| inside(part.solid)).sum::<usize>() != inside(solid)
    };
    let rows = (0..points).flat_map(|i| (0..points).map(move |j| (i, j)));
    rows.flat_map(|(i, j)| (0..points).map(move |k| (i, j, k))).filter(|&(i, j, k)| is_wrong(place(i, j, k))).count()
}

fn layer_count(part: &AuditedPart, options: &AuditOptions) -> f64 {
    let [low, high] = part.solid.extent(&part.direction);
    ((high - low) / options.layer).ceil()
}

/// Of each layer of a part its area, and the area of what lies on nothing.
fn layers(part: &AuditedPart, earlier: &[AuditedPart], options: &AuditOptions) -> Vec<[f64; 2]> {
    let low = part.solid.extent(&part.direction)[0];
    let count = layer_count(part, options);
    let Ok(lowest) = CutPlane::through(&Point3::from(part.direction * low), &part.direction) else { return Vec::new() };
    let frame = PlaneFrame::of(&lowest);
    let section =
        |solid: &Solid, layer: f64| Region::of(&slice(solid, &lowest.moved((layer + 0.5) * options.layer), &frame));
    let reach = options.layer * options.max_angle.tan() * (1.0 + SLACK);
    let mut layers = Vec::new();
    let mut below = Region::of(&[]);
    for layer in 0..count as usize {
        let own = section(part.solid, layer as f64);
        let mut unsupported = 0.0;
        if layer > 0 || !part.on_platform {
            let mut hanging = own.difference(&below.grown(reach));
            // Earlier parts carry what they lie under.
            for other in earlier {
                if hanging.is_empty() {
                    break;
                }
                hanging = hanging.difference(&section(other.solid, layer as f64 - 1.0).grown(reach));
            }
            unsupported = hanging.area();
        }
        layers.push([own.area(), unsupported]);
        below = own;
    }
    layers
}
