//! What a part stands on: its convex hull and its centre of mass.
//!
//! A rigid body at rest on a plane touches it with corners of its hull, and stays where its centre of mass lies above the polygon
//! that they span. How firmly is the *tipping angle*: by how much it must be turned about the nearest edge of that polygon until the
//! centre is above the edge.
//!
//! The hull is that of the vertices on a lattice of 1/60,000 of the longest side: far finer than
//! [`OrientOptions::contact`](super::OrientOptions::contact), so its facets are exact enough, and its topology is exact.

use super::PoseError;
use super::pose::upright;
use curvlay_hull::{ConvexHull, Depth, convex_polygon};
use nalgebra::{Point3, Unit, Vector3};

/// Half the longest side in lattice units: below [`curvlay_hull::MAX_COORDINATE`], where hulls are exact.
const LATTICE: f64 = 30_000.0;

/// Largest absolute coordinate: cubes of it stay finite.
const MAX_COORDINATE: f64 = 1e100;

/// A mesh that encloses less than this share of the cube over its longest side has no volume but that of rounding.
const MIN_VOLUME: f64 = 1e-12;

/// The hull of a part in lattice units, seen from its centre of mass.
pub(super) struct Body {
    corners: Vec<Vector3<f64>>,
    /// Corners of each triangle of the hull, counter-clockwise from outside.
    facets: Vec<[u32; 3]>,
}

impl Body {
    /// Looks a mesh through.
    pub(super) fn new<E>(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, PoseError<E>> {
        check(vertices, triangles)?;
        let used = || triangles.iter().flatten().map(|&corner| vertices[corner as usize]);
        let Some(first) = used().next() else { return Err(PoseError::NoTriangle) };
        let (low, high) = used().fold((first, first), |(low, high), at| (low.inf(&at), high.sup(&at)));
        let (middle, size) = (nalgebra::center(&low, &high), (high - low).max());
        if size <= 0.0 {
            return Err(PoseError::NoVolume);
        }
        let scale = 2.0 * LATTICE / size;
        let in_units = |at: Point3<f64>| (at - middle) * scale;
        let centre = centre_of_mass(triangles.iter().map(|corners| corners.map(|k| in_units(vertices[k as usize]))));
        let centre = centre.ok_or(PoseError::NoVolume)?;
        let mut points: Vec<[i32; 3]> = used().map(|at| in_units(at).map(|c| c.round() as i32).into()).collect();
        points.sort_unstable();
        points.dedup();
        let mut hull = ConvexHull::new(Depth::SURFACE);
        hull.insert(&points).unwrap_or_else(|error| unreachable!("the lattice is within reach: {error}"));
        if !hull.is_solid() {
            return Err(PoseError::NoVolume);
        }
        let lattice = hull.corners();
        let number = |corner: [i32; 3]| lattice.binary_search(&corner).unwrap_or_default() as u32;
        let facets = hull.triangles().map(|corners| corners.map(|corner| corner.map_or(0, number))).collect();
        let corners = lattice.iter().map(|corner| Vector3::from(corner.map(f64::from)) - centre).collect();
        Ok(Body { corners, facets })
    }

    /// The tipping angle with `up` away from the plate; 0 where the part falls by itself. What lies within `contact` of the
    /// longest side over the plate carries.
    pub(super) fn tipping(&self, up: &Unit<Vector3<f64>>, contact: f64) -> f64 {
        let (turn, contact) = (upright(up), contact * 2.0 * LATTICE);
        let heights = || self.corners.iter().map(|corner| corner.dot(up));
        let lowest = heights().fold(f64::INFINITY, f64::min);
        let carries = self.corners.iter().zip(heights()).filter(|(_, height)| *height <= lowest + contact);
        let footprint = carries.map(|(corner, _)| {
            let at = turn * corner;
            [at.x, at.y].map(|c| c.round() as i32)
        });
        let polygon = convex_polygon(&footprint.collect::<Vec<_>>());
        if polygon.len() < 3 {
            return 0.0;
        }
        // The centre of mass is the origin.
        let distance = |(a, b): (&[i32; 2], &[i32; 2])| {
            let ([ax, ay], [bx, by]) = (a.map(f64::from), b.map(f64::from));
            (ax * by - ay * bx) / (bx - ax).hypot(by - ay)
        };
        let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
        edges.map(distance).fold(f64::INFINITY, f64::min).max(0.0).atan2(-lowest)
    }

    /// The directions up with which the part rests on a face of its hull: facets that lie within `contact` of one plane are one face. Those
    /// with a tipping angle of at least `min_tipping`, the firmest first, and none within `min_apart` of one before it.
    pub(super) fn resting(&self, contact: f64, min_tipping: f64, min_apart: f64) -> Vec<(Unit<Vector3<f64>>, f64)> {
        let normal = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|k| self.corners[k as usize]);
            (b - a).cross(&(c - a))
        };
        let normals: Vec<_> = self.facets.iter().map(normal).collect();
        let mut largest_first: Vec<usize> = (0..self.facets.len()).collect();
        largest_first.sort_by(|&a, &b| normals[b].norm_squared().total_cmp(&normals[a].norm_squared()));
        let mut is_of_face = vec![false; self.facets.len()];
        let mut found: Vec<(Unit<Vector3<f64>>, f64)> = Vec::new();
        for facet in largest_first {
            if is_of_face[facet] {
                continue;
            }
            let down = normals[facet].normalize();
            let height = self.corners[self.facets[facet][0] as usize].dot(&down) - contact * 2.0 * LATTICE;
            let carries: Vec<bool> = self.corners.iter().map(|corner| corner.dot(&down) >= height).collect();
            let mut sum = normals[facet];
            is_of_face[facet] = true;
            for (other, corners) in self.facets.iter().enumerate() {
                if other != facet && corners.iter().all(|&corner| carries[corner as usize]) {
                    sum += normals[other];
                    is_of_face[other] = true;
                }
            }
            let up = Unit::new_normalize(-sum);
            found.push((up, self.tipping(&up, contact)));
        }
        found.retain(|(_, tipping)| *tipping > 0.0 && *tipping >= min_tipping);
        found.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let mut kept: Vec<(Unit<Vector3<f64>>, f64)> = Vec::new();
        for pose in found {
            if kept.iter().all(|other| other.0.angle(&pose.0) >= min_apart) {
                kept.push(pose);
            }
        }
        kept
    }
}

/// Whether the mesh can be used.
fn check<E>(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), PoseError<E>> {
    if triangles.is_empty() {
        return Err(PoseError::NoTriangle);
    }
    check_vertices(vertices)?;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(PoseError::BadIndex { triangle, index, vertices: vertices.len() });
        }
    }
    Ok(())
}

/// Whether the vertices can be used.
pub(super) fn check_vertices<E>(vertices: &[Point3<f64>]) -> Result<(), PoseError<E>> {
    let usable = |at: &Point3<f64>| at.iter().all(|c| c.abs() <= MAX_COORDINATE);
    match vertices.iter().position(|at| !usable(at)) {
        Some(vertex) => Err(PoseError::BadVertex { vertex, position: vertices[vertex].into() }),
        None => Ok(()),
    }
}

/// The centre of mass of what triangles enclose, all of the same density: the mean of the tetrahedra from the origin, by signed volume. Of
/// an open mesh, what cones from the origin close. `None` where nothing is enclosed.
fn centre_of_mass(triangles: impl Iterator<Item = [Vector3<f64>; 3]>) -> Option<Vector3<f64>> {
    let (mut volume, mut moment) = (0.0, Vector3::zeros());
    for [a, b, c] in triangles {
        let six = a.cross(&b).dot(&c);
        volume += six;
        moment += six * (a + b + c);
    }
    let cube = (2.0 * LATTICE).powi(3);
    (volume.abs() > 6.0 * MIN_VOLUME * cube).then(|| moment / (4.0 * volume))
}
