//! Phase II: in which order the parts are printed, on which planes, and in which directions.
//!
//! Dissertation, section 2.4.2. The parts with their borders are a graph; it is traversed breadth first from a root. The
//! base plane of a part separates it, with all that grows on it, from the rest, and the part is printed along the plane's normal. The
//! root is printed in the direction in which the least of it looks down (Eq. 2.1) while all planes look up, else those on it.
//!
//! Departure: the plane of a part is fitted to the whole curve around it and what grows on it, not only to the
//! border with its predecessor. Where three parts meet, that border is an open arc, and its plane does not separate them.

use super::RoboFdmError;
use super::border::separating_plane;
use super::closed::ClosedMesh;
use super::segment::Segmentation;
use nalgebra::{Point3, Vector3};
use std::collections::VecDeque;

/// How the sequence is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceOptions {
    /// The largest angle at which a facet may lean out without support, in radians from upright, above 0 and below a right
    /// angle: a facet of normal `n` is risky in the direction `d` if `n . d + sin(max_angle) < 0`. Default 45 degrees.
    pub max_angle: f64,
    /// The part that is printed first. Default: the best.
    pub root: Root,
    /// The direction in which the root is printed. Default `None`: the one with the least risky area.
    pub direction: Option<Vector3<f64>>,
    /// Facets of the root that lie no higher than this above its lowest point lie on the platform, in mm. Default 0.2, a layer.
    pub platform: f64,
}

impl Default for SequenceOptions {
    fn default() -> Self {
        Self { max_angle: std::f64::consts::FRAC_PI_4, root: Root::Best, direction: None, platform: 0.2 }
    }
}

/// Which part is printed first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Root {
    /// The one that leaves the least risky area in all parts; of those whose planes all look up, if there are any.
    #[default]
    Best,
    /// The part of this number.
    Part(u32),
}

/// A part in the sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPart {
    /// Its number in the segmentation.
    pub part: u32,
    /// The part on which it is printed; none for the root.
    pub parent: Option<u32>,
    /// A point of its base plane, in mm; none for the root.
    pub base: Option<Point3<f64>>,
    /// The direction in which it is printed, of length 1: the normal of its base plane.
    pub direction: Vector3<f64>,
    /// Area of its facets that are risky in this direction, in mm2.
    pub risky_mm2: f64,
}

/// The parts in the order in which they are printed.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildSequence {
    /// The root first.
    pub parts: Vec<PlannedPart>,
    /// Whether all base planes look up when the root is printed: constraint II of the paper.
    pub planes_look_up: bool,
}

impl BuildSequence {
    /// Risky area of all parts, in mm2.
    pub fn risky_mm2(&self) -> f64 {
        self.parts.iter().map(|part| part.risky_mm2).sum()
    }
}

/// Directions that are tried for the root: 4 degrees apart. A finer grid gains nothing that later phases would not.
const DIRECTIONS: usize = 2000;

/// Flat regions, by rising area, on which the root may stand.
const FLAT_REGIONS: usize = 20;

/// Plans order, base planes and directions.
///
/// # Returns
/// Every part of the segmentation that is connected with the root, once; pieces that do not touch it are roots of their own, in the
/// same direction.
///
/// # Errors
/// [`RoboFdmError`] for a mesh that is not closed, a segmentation of another mesh, a root that does not exist, an angle that is
/// not between 0 and a right one, or a direction without length.
///
/// # Cost
/// Some thousand operations for each facet. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::robofdm::{SegmentOptions, SequenceOptions, plan_sequence, segment};
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// // Its twelve facets are too few to tell clusters of thickness apart.
/// let options = SegmentOptions { clusters: Some(1), ..SegmentOptions::default() };
/// let segmentation = segment(&points, &faces, &options)?;
/// let sequence = plan_sequence(&points, &faces, &segmentation, &SequenceOptions::default())?;
/// assert_eq!((sequence.parts.len(), sequence.risky_mm2()), (1, 0.0)); // a rod stands on one of its faces
/// # Ok::<(), curvlay_layers::planar::robofdm::RoboFdmError>(())
/// ```
pub fn plan_sequence(
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    segmentation: &Segmentation,
    options: &SequenceOptions,
) -> Result<BuildSequence, RoboFdmError> {
    let mesh = ClosedMesh::new(points, triangles)?;
    if segmentation.part_of.len() != triangles.len() {
        return Err(RoboFdmError::OtherMesh { found: segmentation.part_of.len(), expected: triangles.len() });
    }
    if !(options.max_angle > 0.0 && options.max_angle < std::f64::consts::FRAC_PI_2) {
        return Err(RoboFdmError::Option { name: "max_angle", value: options.max_angle });
    }
    if !(options.platform >= 0.0 && options.platform.is_finite()) {
        return Err(RoboFdmError::Option { name: "platform", value: options.platform });
    }
    if let Some(direction) = options.direction
        && !(direction.norm() > 0.0 && direction.norm().is_finite())
    {
        return Err(RoboFdmError::Option { name: "direction", value: direction.norm() });
    }
    let planner = Planner { mesh: &mesh, segmentation, options, offset: 0.002 * mesh.diagonal() };
    let parts = segmentation.parts;
    match options.root {
        Root::Part(root) if root as usize >= parts => Err(RoboFdmError::Root { root, parts }),
        Root::Part(root) => Ok(planner.rooted_at(root)),
        Root::Best => {
            let plans = (0..parts as u32).map(|root| planner.rooted_at(root));
            let rank = |plan: &BuildSequence| (!plan.planes_look_up, plan.risky_mm2());
            let better = |a: &BuildSequence, b: &BuildSequence| {
                let (a, b) = (rank(a), rank(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            };
            plans.min_by(better).ok_or(RoboFdmError::Empty)
        }
    }
}

/// A point and the normal.
type Plane = (Point3<f64>, Vector3<f64>);

struct Planner<'a> {
    mesh: &'a ClosedMesh<'a>,
    segmentation: &'a Segmentation,
    options: &'a SequenceOptions,
    offset: f64,
}

impl Planner<'_> {
    fn rooted_at(&self, root: u32) -> BuildSequence {
        let (order, parents) = self.traversal(root);
        // Children come after their parents, so from the last to the first all below is known.
        let mut below: Vec<Vec<bool>> =
            (0..parents.len()).map(|p| (0..parents.len()).map(|q| p == q).collect()).collect();
        for &part in order.iter().rev() {
            if let Some(parent) = parents[part as usize] {
                let own = below[part as usize].clone();
                below[parent as usize].iter_mut().zip(own).for_each(|(below, own)| *below |= own);
            }
        }
        let plane = |part: u32| {
            parents[part as usize]?;
            let in_tree = &below[part as usize];
            separating_plane(self.mesh, |f| in_tree[self.segmentation.part_of[f] as usize], self.offset)
        };
        let planes: Vec<_> = order.iter().map(|&part| plane(part)).collect();
        let on_root = |&(part, _): &(&u32, _)| parents[*part as usize] == Some(root);
        let normal = |(_, plane): (&u32, &Option<Plane>)| plane.map(|plane| plane.1);
        let all: Vec<_> = order.iter().zip(&planes).filter_map(normal).collect();
        let first: Vec<_> = order.iter().zip(&planes).filter(on_root).filter_map(normal).collect();
        let up = match self.options.direction {
            Some(direction) => direction.normalize(),
            None => self.root_direction(root, &[&all, &first, &[]]),
        };
        let planes_look_up = planes.iter().flatten().all(|(_, normal)| normal.dot(&up) > 0.0);
        let planned = |(&part, plane): (&u32, Option<Plane>)| {
            let direction = plane.map_or(up, |plane| plane.1);
            let floor = plane.is_none().then(|| self.lowest(part, direction) + self.options.platform);
            PlannedPart {
                part,
                parent: parents[part as usize],
                base: plane.map(|plane| plane.0),
                direction,
                risky_mm2: self.risky(part, direction, floor),
            }
        };
        BuildSequence { parts: order.iter().zip(planes).map(planned).collect(), planes_look_up }
    }

    /// The order of visits, breadth first by rising numbers, and from where each part was visited.
    fn traversal(&self, root: u32) -> (Vec<u32>, Vec<Option<u32>>) {
        let parts = self.segmentation.parts;
        let mut neighbours = vec![Vec::new(); parts];
        for border in &self.segmentation.borders {
            let [a, b] = border.parts;
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        neighbours.iter_mut().for_each(|list| list.sort_unstable());
        let (mut order, mut parents, mut seen) = (Vec::new(), vec![None; parts], vec![false; parts]);
        for start in std::iter::once(root).chain(0..parts as u32) {
            let mut queue = VecDeque::new();
            if !std::mem::replace(&mut seen[start as usize], true) {
                queue.push_back(start);
            }
            while let Some(part) = queue.pop_front() {
                order.push(part);
                for &next in &neighbours[part as usize] {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        parents[next as usize] = Some(part);
                        queue.push_back(next);
                    }
                }
            }
        }
        (order, parents)
    }

    fn facets(&self, part: u32) -> impl Iterator<Item = usize> {
        let part_of = &self.segmentation.part_of;
        (0..part_of.len()).filter(move |&f| part_of[f] == part)
    }

    /// Height of the lowest corner of a part.
    fn lowest(&self, part: u32, up: Vector3<f64>) -> f64 {
        let height = |f: usize| self.mesh.corners(f).map(|p| p.coords.dot(&up));
        self.facets(part).flat_map(height).fold(f64::INFINITY, f64::min)
    }

    /// Area of the facets that do not fulfil Eq. 2.1 and do not lie wholly below the floor.
    fn risky(&self, part: u32, up: Vector3<f64>, floor: Option<f64>) -> f64 {
        let limit = -self.options.max_angle.sin();
        let on_floor = |f: usize| floor.is_some_and(|z| self.mesh.corners(f).iter().all(|p| p.coords.dot(&up) <= z));
        let area = |f: usize| {
            let vector = self.mesh.area_vector(f);
            let area = vector.norm();
            if vector.dot(&up) < limit * area && !on_floor(f) { area } else { 0.0 }
        };
        self.facets(part).map(area).sum()
    }

    /// The direction of the least risky area in which all normals of a list look up: of the first list for which there is one.
    fn root_direction(&self, root: u32, lists: &[&[Vector3<f64>]]) -> Vector3<f64> {
        let candidates: Vec<_> = self.flat_directions(root).into_iter().chain(sphere(DIRECTIONS)).collect();
        let allowed_by = |normals: &&[Vector3<f64>]| -> Vec<&Vector3<f64>> {
            candidates.iter().filter(|d| normals.iter().all(|n| n.dot(d) > 0.0)).collect()
        };
        let allowed = lists.iter().map(allowed_by).find(|allowed| !allowed.is_empty()).unwrap_or_default();
        let risky = |d: &Vector3<f64>| self.risky(root, *d, Some(self.lowest(root, *d) + self.options.platform));
        // Of equals the first one, so that the largest flat region wins.
        let best = allowed.into_iter().map(|d| (risky(d), d)).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(Vector3::z, |(_, d)| *d)
    }

    /// Directions in which the part stands on a flat region, the largest first.
    fn flat_directions(&self, part: u32) -> Vec<Vector3<f64>> {
        // Facets whose normals agree to a thousandth.
        let key = |n: &Vector3<f64>| [n.x, n.y, n.z].map(|c| (c * 1000.0).round() as i32);
        let mut facets: Vec<_> = self
            .facets(part)
            .filter_map(|f| {
                let vector = self.mesh.area_vector(f);
                vector.try_normalize(0.0).map(|n| (key(&n), vector))
            })
            .collect();
        facets.sort_by_key(|(key, _)| *key);
        let sum = |group: &[([i32; 3], Vector3<f64>)]| group.iter().map(|(_, v)| v).sum::<Vector3<f64>>();
        let mut regions: Vec<_> = facets.chunk_by(|a, b| a.0 == b.0).map(sum).collect();
        regions.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
        regions.into_iter().take(FLAT_REGIONS).filter_map(|v| (-v).try_normalize(0.0)).collect()
    }
}

/// Directions all around, evenly: a Fibonacci lattice, from the top down.
pub(super) fn sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * cos, r * sin, z)
    })
}
