//! Fields of line directions on a layer: a tangent direction without a sign at each vertex.
//!
//! Directions are smoothed as numbers of twice their angle: `z` minimises `sum c |z - z0|^2 + l^2 sum w |z_j - r_ij z_i|^2` over vertices and edges,
//! with cotangent weights `w` and `r_ij` that takes a direction from one frame to the other (Knöppel et al., "Globally optimal direction fields",
//! ACM TOG 32(4), 2013, sections 3 and 6; their alignment to a given field). `c` is the area of a vertex, times how distinct its direction is.

use super::frame::{Frames, edge_weights, rotation};
use super::near::{Layer, vertex_areas, vertex_normals};
use super::stress::LayerStress;
use crate::mesh::SurfaceMesh;
use crate::mesh::SurfacePoint;
use crate::sparse::{Entries, Factors};
use nalgebra::{Matrix2, Point3, Vector2, Vector3};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Why there is no field of directions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DirectionError {
    /// A direction is NaN or infinite.
    #[error("the direction at vertex {vertex} is not finite")]
    BadDirection {
        /// The vertex.
        vertex: usize,
    },
    /// No vertex of a region has a direction.
    #[error("no direction is known in region {region} of the layer")]
    Undefined {
        /// The region, as [`SurfaceMesh::regions`] counts them.
        region: usize,
    },
    /// No guide curve was given, or one without length.
    #[error("guide curve {guide} has no length; each needs two different points")]
    NoGuide {
        /// Number of the curve; 0 if there is none at all.
        guide: usize,
    },
    /// A point of a guide curve is NaN, infinite or absurd.
    #[error("point {point} of guide curve {guide} has a coordinate that is not finite or beyond 1e100")]
    BadGuide {
        /// Number of the curve.
        guide: usize,
        /// Number of the point.
        point: usize,
    },
    /// A guide curve leaves the layer.
    #[error("guide curve {guide} is farther than {reach} mm from the layer at its point {point}")]
    GuideOffLayer {
        /// Number of the curve.
        guide: usize,
        /// Number of the point, or of that before.
        point: usize,
        /// How far it may be.
        reach: f64,
    },
    /// A length is not a length.
    #[error("{option} is {value} mm: it must be a finite length, not below zero")]
    Length {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
    },
    /// Rounding makes the equations of the smooth field singular: sizes of triangles differ too much.
    #[error("the equations of the smooth field cannot be solved: sizes of triangles differ too much")]
    Unsolvable,
}

/// A triangle around which directions turn: there the field has no direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// The middle of the triangle.
    pub at: SurfacePoint,
    /// Half turns of the direction on the way around it, counterclockwise: twice its index. 1 is the end of a ridge, -1 where three ridges
    /// meet, 2 a centre.
    pub half_turns: i32,
}

/// A line direction at each vertex of a layer.
#[derive(Clone, Debug)]
pub struct DirectionField<'m> {
    mesh: &'m SurfaceMesh,
    frames: Frames,
    /// Unit numbers of twice the angle.
    doubled: Vec<Vector2<f64>>,
    directions: Vec<Vector3<f64>>,
}

/// Each vertex holds its direction by this share of what bends the field, however small its triangles are: rounding of the bending of a splinter of a layer
/// that hangs on nothing would else be more than all that holds it.
const LEAST_HOLD: f64 = 1e-9;

/// Guides hold the field this much more than its own bending does over a guide's own spacing.
const GUIDE_HOLD: f64 = 100.0;

impl<'m> DirectionField<'m> {
    /// Takes directions from a function of the place.
    ///
    /// The part in the tangent plane counts; length and sign mean nothing. Where nothing is left of it, the direction is that of the
    /// neighbours.
    ///
    /// # Errors
    /// [`DirectionError::BadDirection`], [`DirectionError::Undefined`].
    ///
    /// # Cost
    /// `O(n)` for `n` triangles.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::fiber::direction::DirectionField;
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    /// let field = DirectionField::from_fn(&mesh, |_| Vector3::new(3.0, 0.0, 4.0))?;
    /// assert!((field.directions()[2].x.abs() - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_fn(
        mesh: &'m SurfaceMesh,
        mut direction: impl FnMut(Point3<f64>) -> Vector3<f64>,
    ) -> Result<Self, DirectionError> {
        let frames = Frames::new(vertex_normals(mesh));
        let mut doubled = Vec::with_capacity(frames.axes.len());
        for (vertex, p) in mesh.vertices().iter().enumerate() {
            let direction = direction(*p);
            if !direction.iter().all(|c| c.is_finite()) {
                return Err(DirectionError::BadDirection { vertex });
            }
            doubled.push(frames.doubled(vertex, &tame(direction)));
        }
        Self::new(mesh, frames, doubled)
    }

    /// The principal direction of the largest magnitude in the layer, smoothed.
    ///
    /// # Arguments
    /// * `smoothing`: over about which length directions are evened out, in millimetres; 0 for none. Distinct directions count more: where
    ///   both principal stresses are of the same magnitude, the field follows its surroundings.
    ///
    /// # Errors
    /// [`DirectionError::Undefined`] where a region has no stress with a direction, [`DirectionError::Length`], [`DirectionError::Unsolvable`].
    ///
    /// # Cost
    /// `O(n)` for `n` triangles, with smoothing that of a sparse factorisation, some `n^1.5`.
    pub fn from_stress(stress: &LayerStress<'m>, smoothing: f64) -> Result<Self, DirectionError> {
        let mesh = stress.mesh();
        let frames = Frames::new(vertex_normals(mesh));
        let largest = stress.principal().iter().map(|p| p.largest.abs()).fold(0.0, f64::max);
        // Where the magnitudes agree but for rounding there is no direction.
        let weight = |distinctness: f64| if distinctness > 1e-9 * largest { distinctness / largest } else { 0.0 };
        let weights: Vec<f64> = stress.principal().iter().map(|p| weight(p.distinctness())).collect();
        let doubled = stress.principal().iter().zip(&weights).enumerate().map(|(v, (p, &weight))| match weight > 0.0 {
            true => frames.doubled(v, &p.direction),
            false => Vector2::zeros(),
        });
        let field = Self::new(mesh, frames.clone(), doubled.collect())?;
        if smoothing == 0.0 { Ok(field) } else { field.evened(smoothing, Some(&weights)) }
    }

    /// The smoothest field along guide curves.
    ///
    /// # Arguments
    /// * `guides`: polylines on the layer or near it, in millimetres.
    /// * `reach`: how far they may be from it.
    ///
    /// # Errors
    /// [`DirectionError`]. Each connected region of the layer needs a guide curve.
    ///
    /// # Cost
    /// That of a sparse factorisation, some `n^1.5` for `n` triangles.
    pub fn from_guides(mesh: &'m SurfaceMesh, guides: &[Vec<Point3<f64>>], reach: f64) -> Result<Self, DirectionError> {
        check_length("reach", reach)?;
        let layer = Layer::new(mesh);
        let frames = Frames::new(layer.normals.clone());
        let spacing = (vertex_areas(mesh).iter().sum::<f64>() / mesh.triangles().len() as f64).sqrt();
        let mut holds = vec![(0.0, Vector2::zeros()); mesh.vertices().len()];
        for_each_step(guides, spacing, |guide, point, at, direction| {
            let near = layer.nearest(at, reach).ok_or(DirectionError::GuideOffLayer { guide, point, reach })?;
            for (&v, share) in mesh.triangles()[near.triangle as usize].iter().zip(near.barycentric) {
                let hold = GUIDE_HOLD * share;
                holds[v as usize].0 += hold;
                holds[v as usize].1 += frames.doubled(v as usize, &direction) * hold;
            }
            Ok(())
        })?;
        let regions = mesh.regions();
        let mut held = vec![false; regions.count];
        for (triangle, corners) in mesh.triangles().iter().enumerate() {
            held[regions.of_triangle[triangle] as usize] |= corners.iter().any(|&v| holds[v as usize].0 > 0.0);
        }
        if let Some(region) = held.iter().position(|&held| !held) {
            return Err(DirectionError::Undefined { region });
        }
        let doubled = solve(mesh, &frames, 1.0, &holds).ok_or(DirectionError::Unsolvable)?;
        Self::new(mesh, frames, doubled)
    }

    /// The field evened out over about a length, in millimetres.
    ///
    /// # Errors
    /// [`DirectionError::Length`], [`DirectionError::Unsolvable`].
    ///
    /// # Cost
    /// That of a sparse factorisation, some `n^1.5` for `n` triangles.
    pub fn smoothed(self, length: f64) -> Result<Self, DirectionError> {
        self.evened(length, None)
    }

    fn evened(self, length: f64, weights: Option<&[f64]>) -> Result<Self, DirectionError> {
        check_length("smoothing", length)?;
        let hold = |(v, area): (usize, f64)| {
            // Where nothing is known for sure, a little still keeps the equations solvable.
            let hold = (area * weights.map_or(1.0, |weights| weights[v].max(1e-6))).max(LEAST_HOLD * length * length);
            (hold, self.doubled[v] * hold)
        };
        let holds: Vec<_> = vertex_areas(self.mesh).into_iter().enumerate().map(hold).collect();
        let doubled = solve(self.mesh, &self.frames, length * length, &holds).ok_or(DirectionError::Unsolvable)?;
        Self::new(self.mesh, self.frames, doubled)
    }

    /// Makes numbers unit, fills those that are zero, and gives directions signs.
    fn new(mesh: &'m SurfaceMesh, frames: Frames, mut doubled: Vec<Vector2<f64>>) -> Result<Self, DirectionError> {
        doubled.iter_mut().for_each(|z| *z = z.try_normalize(0.0).unwrap_or_default());
        fill(mesh, &frames, &mut doubled)?;
        let directions = doubled.iter().enumerate().map(|(v, z)| frames.direction(v, *z)).collect();
        let mut field = DirectionField { mesh, frames, doubled, directions };
        field.orient();
        Ok(field)
    }

    /// Turns directions around so that they agree along a tree over the edges, from the first vertex of each region on.
    fn orient(&mut self) {
        let mut seen = vec![false; self.directions.len()];
        let mut waiting = VecDeque::new();
        for start in 0..seen.len() {
            if seen[start] || self.mesh.fan(start as u32).next().is_none() {
                continue;
            }
            seen[start] = true;
            waiting.push_back(start);
            while let Some(v) = waiting.pop_front() {
                for to in around(self.mesh, v as u32) {
                    if !std::mem::replace(&mut seen[to as usize], true) {
                        if !self.agrees(v, to as usize) {
                            self.directions[to as usize] = -self.directions[to as usize];
                        }
                        waiting.push_back(to as usize);
                    }
                }
            }
        }
    }

    /// Whether the directions of two neighbours, as they stand, point the same way.
    pub(super) fn agrees(&self, from: usize, to: usize) -> bool {
        let carried = super::frame::carry(self.directions[from], &self.frames.normals[from], &self.frames.normals[to]);
        carried.dot(&self.directions[to]) >= 0.0
    }

    /// The layer.
    pub fn mesh(&self) -> &'m SurfaceMesh {
        self.mesh
    }

    /// A unit tangent vector at each vertex. Neighbours point the same way wherever a field around its singular points lets them; the
    /// sign means nothing else.
    pub fn directions(&self) -> &[Vector3<f64>] {
        &self.directions
    }

    /// Unit normals of the vertices.
    pub(super) fn normals(&self) -> &[Vector3<f64>] {
        &self.frames.normals
    }

    /// The direction at a point of a triangle, in its plane; `None` where those of the corners cancel.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn at(&self, triangle: u32, barycentric: [f64; 3]) -> Option<Vector3<f64>> {
        let corners = self.mesh.triangles()[triangle as usize].map(|v| v as usize);
        let first = self.directions[corners[0]];
        let signed = corners.iter().zip(barycentric).map(|(&v, weight)| {
            let agrees = self.directions[v].dot(&first) >= 0.0;
            self.directions[v] * if agrees { weight } else { -weight }
        });
        let normal = super::near::cross(self.mesh, triangle).normalize();
        let sum: Vector3<f64> = signed.sum();
        (sum - normal * sum.dot(&normal)).try_normalize(1e-9)
    }

    /// The triangles around which directions turn, in the order of their numbers.
    ///
    /// The turn from corner to corner is taken as less than a quarter turn: a field that turns faster is too coarse a mesh's.
    pub fn singularities(&self) -> Vec<Singularity> {
        let angle = |z: &Vector2<f64>| z.y.atan2(z.x);
        let mut found = Vec::new();
        for (triangle, corners) in self.mesh.triangles().iter().enumerate() {
            let (mut turned, mut holonomy) = (0.0, 0.0);
            for k in 0..3 {
                let [from, to] = [corners[k], corners[(k + 1) % 3]].map(|v| v as usize);
                let turn = 2.0 * self.frames.turn(from, to);
                turned += wrapped(angle(&self.doubled[to]) - angle(&self.doubled[from]) - turn);
                holonomy += turn;
            }
            let half_turns = ((turned + wrapped(holonomy)) / (2.0 * PI)).round() as i32;
            if half_turns != 0 {
                let position = self.mesh.point(triangle as u32, [1.0 / 3.0; 3]);
                let at = SurfacePoint { triangle: triangle as u32, barycentric: [1.0 / 3.0; 3], position };
                found.push(Singularity { at, half_turns });
            }
        }
        found
    }
}

/// An angle from minus to plus a half turn.
fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

/// A vector of a length whose square is a number.
fn tame(direction: Vector3<f64>) -> Vector3<f64> {
    let largest = direction.amax();
    if largest > 0.0 { direction / largest } else { direction }
}

/// The vertices around a vertex.
pub(super) fn around(mesh: &SurfaceMesh, vertex: u32) -> impl Iterator<Item = u32> + '_ {
    mesh.fan(vertex).flat_map(move |h| {
        // The last edge of a fan at the boundary comes in, no half-edge goes out along it.
        let last = mesh.turn_left(h).is_none().then(|| mesh.tail(crate::mesh::previous(h)));
        std::iter::once(mesh.head(h)).chain(last)
    })
}

/// Vertices without a direction take it from their neighbours, those next to known ones first.
fn fill(mesh: &SurfaceMesh, frames: &Frames, doubled: &mut [Vector2<f64>]) -> Result<(), DirectionError> {
    let known = |z: &Vector2<f64>| *z != Vector2::zeros();
    loop {
        let mut filled = Vec::new();
        let mut open = None;
        for v in (0..doubled.len()).filter(|&v| !known(&doubled[v]) && mesh.fan(v as u32).next().is_some()) {
            let carried = |&from: &u32| rotation(2.0 * frames.turn(from as usize, v)) * doubled[from as usize];
            let near: Vec<Vector2<f64>> = around(mesh, v as u32)
                .filter(|&from| known(&doubled[from as usize]))
                .map(|from| carried(&from))
                .collect();
            match near.first() {
                // Directions around a singular point cancel: any of them will do.
                Some(&first) => {
                    filled.push((v, near.iter().sum::<Vector2<f64>>().try_normalize(1e-6).unwrap_or(first)))
                }
                None => open = open.or(Some(v)),
            }
        }
        match (filled.is_empty(), open) {
            (true, None) => return Ok(()),
            (true, Some(v)) => {
                let triangle = mesh.fan(v as u32).next().map_or(0, |h| h / 3);
                let region = mesh.regions().of_triangle[triangle as usize] as usize;
                return Err(DirectionError::Undefined { region });
            }
            _ => filled.into_iter().for_each(|(v, z)| doubled[v] = z),
        }
    }
}

/// The numbers `z` of least `sum (hold |z|^2 - 2 z . pull) + bending sum w |z_j - r_ij z_i|^2`; `holds` has hold and pull of each vertex.
fn solve(
    mesh: &SurfaceMesh,
    frames: &Frames,
    bending: f64,
    holds: &[(f64, Vector2<f64>)],
) -> Option<Vec<Vector2<f64>>> {
    let weights = edge_weights(mesh);
    let mut entries = Entries::default();
    for (v, (hold, _)) in holds.iter().enumerate() {
        let alone = mesh.fan(v as u32).next().is_none();
        entries.add_block(v, v, Matrix2::identity() * if alone { 1.0 } else { *hold });
    }
    for h in (0..mesh.half_edges()).filter(|&h| mesh.edge(h) == h) {
        let [from, to] = [mesh.tail(h), mesh.head(h)].map(|v| v as usize);
        let weight = bending * weights[h as usize];
        entries.add_block(from, from, Matrix2::identity() * weight);
        entries.add_block(to, to, Matrix2::identity() * weight);
        entries.add_block(to, from, rotation(2.0 * frames.turn(from, to)) * -weight);
    }
    let mut right: Vec<Vector2<f64>> = holds.iter().map(|hold| hold.1).collect();
    Factors::new(2 * right.len(), &entries)?.solve_pairs(&mut right);
    Some(right)
}

fn check_length(option: &'static str, value: f64) -> Result<(), DirectionError> {
    if (0.0..=1e100).contains(&value) { Ok(()) } else { Err(DirectionError::Length { option, value }) }
}

/// Hands over points and directions along guide curves, at most `spacing` apart.
fn for_each_step(
    guides: &[Vec<Point3<f64>>],
    spacing: f64,
    mut each: impl FnMut(usize, usize, Point3<f64>, Vector3<f64>) -> Result<(), DirectionError>,
) -> Result<(), DirectionError> {
    if guides.is_empty() {
        return Err(DirectionError::NoGuide { guide: 0 });
    }
    for (guide, points) in guides.iter().enumerate() {
        if let Some(point) = points.iter().position(|p| !p.iter().all(|c| c.abs() <= 1e100)) {
            return Err(DirectionError::BadGuide { guide, point });
        }
        let mut any = false;
        for (point, ends) in points.windows(2).enumerate() {
            let along = ends[1] - ends[0];
            let length = along.norm();
            if length <= 0.0 {
                continue;
            }
            any = true;
            // No more steps than make sense: a guide off the layer is found at once.
            let steps = (length / spacing).ceil().clamp(1.0, 1e6) as usize;
            for k in 0..=steps {
                each(guide, point, ends[0] + along * (k as f64 / steps as f64), along / length)?;
            }
        }
        if !any {
            return Err(DirectionError::NoGuide { guide });
        }
    }
    Ok(())
}
