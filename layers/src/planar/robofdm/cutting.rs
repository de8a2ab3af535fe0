//! Fine decomposition: the riskiest parts are cut by their best planes until all are safe or no plane helps.
//!
//! Dai 2020, section 2.4.3. Symbols: `R` is the risky area, `M_g` the part that is cut into `M_g^s` below and `M_g^t` above, `k` the parts
//! that are tried. Constraint I: sections of base planes do not meet each other; here every base that hangs on the part lies wholly on one
//! side of the new plane. Constraint II: base planes face up: normals are within a right angle of the root's direction.

use super::planes::{Candidate, Faces, half_sphere};
use crate::Progress;
use crate::planar::{CutPlane, Partition, Solid};
use nalgebra::{Point3, Vector3};
use std::ops::ControlFlow;

/// How parts are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingOptions {
    /// The self-support angle in radians: how far a face may lean over from upright (default 45 degrees).
    pub max_angle: f64,
    /// Direction of the root; `None`: of the normals below the one with the least facing-down area (default).
    pub direction: Option<Vector3<f64>>,
    /// Normals that are tried (default 100, as in the paper).
    pub normals: usize,
    /// Distance of planes in millimetres (default 5, as in the paper).
    pub step_mm: f64,
    /// How many of the riskiest parts are tried in a round, `k` (default 6, as in the paper).
    pub tried_parts: usize,
    /// How many of the best planes of a part are cut until one obeys the constraints (default 24; the paper tests all).
    pub tried_planes: usize,
    /// The least gain of a cut, as a share of the risky area at the beginning (default 0.001: a smaller one is no worth a seam).
    pub least_gain: f64,
    /// The most parts (default 64).
    pub max_parts: usize,
}

impl Default for CuttingOptions {
    fn default() -> Self {
        CuttingOptions {
            max_angle: std::f64::consts::FRAC_PI_4,
            direction: None,
            normals: 100,
            step_mm: 5.0,
            tried_parts: 6,
            tried_planes: 24,
            least_gain: 1e-3,
            max_parts: 64,
        }
    }
}

/// Why a solid is not cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CuttingError {
    /// An option is not usable.
    #[error("the option {option} is {value}; it must be {range}")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// More parts are to be tried than the solid has faces.
    #[error("{tried} parts are to be tried in a round, but the mesh has {facets} facets")]
    TriedParts {
        /// What was asked for.
        tried: usize,
        /// Facets of the mesh.
        facets: usize,
    },
    /// The caller stopped.
    #[error("stopped by the caller")]
    Stopped,
}

/// A part of a [`PlaneDecomposition`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlanePart {
    /// Its mesh, where it belongs.
    pub solid: Solid,
    /// Its base plane; the normal is the printing direction.
    pub base: CutPlane,
    /// The part on which it stands; `None` for the root.
    pub parent: Option<usize>,
    /// Area of its base on the parent; of the root 0.
    pub seam_mm2: f64,
    /// Its risky area.
    pub risky_mm2: f64,
}

/// A solid cut by planes.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneDecomposition {
    /// The parts in the order in which they are printed: breadth first, parents before what stands on them.
    pub parts: Vec<PlanePart>,
    /// The risky area of the whole solid along the root's direction.
    pub risky_before_mm2: f64,
}

impl PlaneDecomposition {
    /// The risky area of all parts.
    pub fn risky_after_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.risky_mm2).sum()
    }
}

/// A part that may be cut.
struct Node {
    cell: u32,
    base: CutPlane,
    parent: Option<u32>,
    risky: f64,
    /// Its best planes; empty once none of them can be used.
    planes: Vec<Candidate>,
}

/// Cuts a solid by planes into parts with little risky area, each printed along the normal of its base plane.
///
/// # Errors
/// [`CuttingError`] for options that cannot be used, and when `progress` breaks off. Risky area that is left is no error.
///
/// # Cost
/// For each part `O(normals * triangles)` to rate all planes, and a cut for each plane that is tried. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::planar::{CuttingOptions, Solid, decompose_by_planes};
/// // A flipped L: a post of 30 by 30 by 60 mm below a bar of 90 by 30 by 30 mm.
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
/// let options = CuttingOptions { direction: Some([0.0, 0.0, 1.0].into()), ..CuttingOptions::default() };
/// let result = decompose_by_planes(&solid, &options, &|_| std::ops::ControlFlow::Continue(()))?;
/// assert!((result.risky_before_mm2 - 1800.0).abs() < 1e-9); // below the arm
/// assert!(result.parts.len() > 1 && result.risky_after_mm2() < 0.2 * result.risky_before_mm2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn decompose_by_planes(
    solid: &Solid,
    options: &CuttingOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<PlaneDecomposition, CuttingError> {
    check(solid, options)?;
    let up = root_direction(solid, options);
    let [low, _] = solid.extent(&up);
    let base = plane_at(&up, low);
    let normals = half_sphere(&up, options.normals);
    let mut partition = Partition::new(solid);
    let faces = Faces::new(solid, &base, options.max_angle);
    let before = faces.risky_area();
    let mut nodes = vec![Node {
        cell: 0,
        base,
        parent: None,
        risky: before,
        planes: best_planes(&faces, &base, &normals, options),
    }];
    while nodes.len() < options.max_parts {
        if progress(Progress { stage: "cut", done: nodes.len() as u64, total: options.max_parts as u64 }).is_break() {
            return Err(CuttingError::Stopped);
        }
        let mut order: Vec<usize> = (0..nodes.len()).filter(|&k| !nodes[k].planes.is_empty()).collect();
        order.sort_by(|&a, &b| nodes[b].risky.total_cmp(&nodes[a].risky).then(a.cmp(&b)));
        order.truncate(options.tried_parts);
        let gain = |k: usize| nodes[k].planes.first().map_or(0.0, |best| nodes[k].risky - best.risky);
        let Some(chosen) = order.into_iter().max_by(|&a, &b| gain(a).total_cmp(&gain(b)).then(b.cmp(&a))) else {
            break;
        };
        if gain(chosen) < options.least_gain * before {
            break;
        }
        // The best plane either cuts or is struck off.
        let candidate = nodes[chosen].planes.remove(0);
        let Some((trial, mut new)) = cut(&partition, &nodes, chosen, &candidate.plane, options) else { continue };
        let after: f64 = new.iter().map(|(node, _)| node.risky).sum();
        if nodes[chosen].risky - after < options.least_gain * before || nodes.len() - 1 + new.len() > options.max_parts
        {
            continue;
        }
        partition = trial;
        // What stood on the part stands on the piece that it touches.
        let old = nodes[chosen].cell;
        for (node, faces) in &mut new {
            node.planes = best_planes(faces, &node.base, &normals, options);
        }
        for node in nodes.iter_mut().filter(|node| node.parent == Some(old)) {
            let touches = |a: &&(Node, Faces), b: &&(Node, Faces)| {
                partition.shared_area(a.0.cell, node.cell).total_cmp(&partition.shared_area(b.0.cell, node.cell))
            };
            node.parent = new.iter().max_by(touches).map(|(piece, _)| piece.cell);
        }
        let mut pieces = new.into_iter().map(|(node, _)| node);
        if let Some(below) = pieces.next() {
            nodes[chosen] = below;
        }
        nodes.extend(pieces);
    }
    Ok(PlaneDecomposition { parts: in_order(&partition, &nodes), risky_before_mm2: before })
}

fn check(solid: &Solid, options: &CuttingOptions) -> Result<(), CuttingError> {
    let refused = |option, value, range| Err(CuttingError::Option { option, value, range });
    if !(options.max_angle > 0.0 && options.max_angle < std::f64::consts::FRAC_PI_2) {
        return refused("max_angle", options.max_angle, "above 0 and below a right angle");
    }
    let [low, high] = solid.bounds();
    if !(options.step_mm.is_finite() && options.step_mm >= 1e-4 * (high - low).norm()) {
        return refused("step_mm", options.step_mm, "at least a ten-thousandth of the part's size");
    }
    if !(options.least_gain > 0.0 && options.least_gain < 1.0) {
        return refused("least_gain", options.least_gain, "above 0 and below 1");
    }
    for (option, value) in [
        ("normals", options.normals),
        ("tried_parts", options.tried_parts),
        ("tried_planes", options.tried_planes),
        ("max_parts", options.max_parts),
    ] {
        if value == 0 {
            return refused(option, 0.0, "at least 1");
        }
    }
    if let Some(direction) = options.direction {
        let length = direction.norm();
        if !(length.is_finite() && length > 0.0) {
            return refused("direction", length, "a direction with a length");
        }
    }
    let facets = solid.triangles().len();
    if options.tried_parts > facets {
        return Err(CuttingError::TriedParts { tried: options.tried_parts, facets });
    }
    Ok(())
}

fn plane_at(normal: &Vector3<f64>, offset: f64) -> CutPlane {
    CutPlane::through(&Point3::from(normal * offset), normal)
        .unwrap_or_else(|error| unreachable!("directions have a length: {error}"))
}

/// The direction that was asked for, or that of the whole sphere with the least risky area; z first.
fn root_direction(solid: &Solid, options: &CuttingOptions) -> Vector3<f64> {
    if let Some(direction) = options.direction {
        return direction.normalize();
    }
    let half = half_sphere(&Vector3::z(), options.normals);
    let axes = [Vector3::z(), -Vector3::z(), Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()];
    let all = axes.into_iter().chain(half.into_iter().flat_map(|n| [n, -n]));
    let rated = all.map(|up| {
        let [low, _] = solid.extent(&up);
        (Faces::new(solid, &plane_at(&up, low), options.max_angle).risky_area(), up)
    });
    rated.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Vector3::z, |(_, up)| up)
}

/// The planes of a part that save most, best first. A plane must not face down in the part: its section would need support.
fn best_planes(faces: &Faces, base: &CutPlane, normals: &[Vector3<f64>], options: &CuttingOptions) -> Vec<Candidate> {
    let risky = faces.risky_area();
    let mut all: Vec<Candidate> = Vec::new();
    for normal in normals.iter().filter(|normal| normal.dot(&base.normal()) >= -options.max_angle.sin()) {
        all.extend(faces.candidates(normal, options.step_mm).into_iter().filter(|candidate| candidate.risky < risky));
    }
    // A stable sort: of equal planes the first one.
    all.sort_by(|a, b| a.risky.total_cmp(&b.risky));
    all.truncate(options.tried_planes);
    all
}

/// Cuts a part, if the constraints hold: the piece below first, then those above, with their faces.
fn cut(
    partition: &Partition,
    nodes: &[Node],
    chosen: usize,
    plane: &CutPlane,
    options: &CuttingOptions,
) -> Option<(Partition, Vec<(Node, Faces)>)> {
    let node = &nodes[chosen];
    // Constraint I: the part's own base is below the plane, and each base on it on one side.
    let own = node.parent.map_or_else(Vec::new, |parent| partition.shared_points(node.cell, parent));
    if own.iter().any(|p| plane.side(p) >= 0) {
        return None;
    }
    for child in nodes.iter().filter(|child| child.parent == Some(node.cell)) {
        let points = partition.shared_points(node.cell, child.cell);
        if points.iter().any(|p| plane.side(p) > 0) && points.iter().any(|p| plane.side(p) < 0) {
            return None;
        }
    }
    let mut trial = partition.clone();
    let pieces = trial.cut(&[node.cell], plane);
    let [below] = pieces.below[..] else { return None };
    if pieces.above.is_empty() {
        return None;
    }
    let make = |cell: u32, base: CutPlane, parent: Option<u32>| {
        let solid = trial.part(cell).ok()?;
        let faces = Faces::new(&solid, &base, options.max_angle);
        Some((Node { cell, base, parent, risky: faces.risky_area(), planes: Vec::new() }, faces))
    };
    let mut new = vec![make(below, node.base, node.parent)?];
    // The root stands on the plate with what stands there now.
    if node.parent.is_none() {
        let lowest = trial.part(below).ok()?.extent(&node.base.normal())[0];
        if lowest > node.base.offset() + 1e-9 * (1.0 + node.base.offset().abs()) {
            return None;
        }
    }
    for cell in pieces.above {
        new.push(make(cell, *plane, Some(below))?);
    }
    Some((trial, new))
}

/// Breadth first from the root.
fn in_order(partition: &Partition, nodes: &[Node]) -> Vec<PlanePart> {
    let mut order: Vec<usize> = (0..nodes.len()).filter(|&k| nodes[k].parent.is_none()).collect();
    let mut at = 0;
    while at < order.len() {
        let cell = nodes[order[at]].cell;
        at += 1;
        order.extend((0..nodes.len()).filter(|&k| nodes[k].parent == Some(cell)));
    }
    let part = |&k: &usize| {
        let node = &nodes[k];
        let parent = node.parent.and_then(|cell| order.iter().position(|&other| nodes[other].cell == cell));
        let seam_mm2 = node.parent.map_or(0.0, |cell| partition.shared_area(node.cell, cell));
        Some(PlanePart {
            solid: partition.part(node.cell).ok()?,
            base: node.base,
            parent,
            seam_mm2,
            risky_mm2: node.risky,
        })
    };
    order.iter().filter_map(part).collect()
}
