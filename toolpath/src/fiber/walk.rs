//! Straight walks over a layer: from triangle to triangle as if they lay flat.

use super::near::{cross, surface_point};
use crate::mesh::{SurfaceMesh, SurfacePoint, next, previous};
use nalgebra::{Point3, Vector3};

/// A walk of this many triangles circles around a vertex in rounding noise.
const MAX_TRIANGLES: usize = 1 << 16;

/// Where a straight walk ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walked {
    pub at: SurfacePoint,
    /// Unit direction there.
    pub direction: Vector3<f64>,
    /// How far it went, in millimetres; less than asked for where it met the border.
    pub length: f64,
}

/// Walks straight on from a point of a triangle.
///
/// `each` sees every crossing of an edge: the half-edge on the near side, and where. The direction is taken into the plane of the triangle;
/// `None` if nothing is left of it.
pub(super) fn walk(
    mesh: &SurfaceMesh,
    from: &SurfacePoint,
    direction: Vector3<f64>,
    length: f64,
    mut each: impl FnMut(u32, Point3<f64>),
) -> Option<Walked> {
    let (mut triangle, mut at) = (from.triangle, from.position);
    let mut normal = cross(mesh, triangle).normalize();
    let mut direction = (direction - normal * direction.dot(&normal)).try_normalize(0.0)?;
    let (mut gone, mut entered) = (0.0, None);
    for _ in 0..MAX_TRIANGLES {
        let Some((h, step)) = exit(mesh, triangle, at, direction, normal, entered) else { break };
        if gone + step >= length {
            at += direction * (length - gone);
            gone = length;
            break;
        }
        at += direction * step;
        gone += step;
        each(h, at);
        let Some(twin) = mesh.twin(h) else { break };
        let along = (mesh.vertices()[mesh.head(h) as usize] - mesh.vertices()[mesh.tail(h) as usize]).normalize();
        let (forth, out) = (direction.dot(&along), direction.dot(&along.cross(&normal)));
        triangle = twin / 3;
        normal = cross(mesh, triangle).normalize();
        direction = (along * forth + along.cross(&normal) * out).normalize();
        entered = Some(twin);
    }
    Some(Walked { at: surface_point(mesh, triangle, at), direction, length: gone })
}

/// The half-edge over which a straight line leaves a triangle, and how far away it is.
fn exit(
    mesh: &SurfaceMesh,
    triangle: u32,
    at: Point3<f64>,
    direction: Vector3<f64>,
    normal: Vector3<f64>,
    entered: Option<u32>,
) -> Option<(u32, f64)> {
    let first = 3 * triangle;
    let mut best: Option<(u32, f64)> = None;
    for h in [first, next(first), previous(first)].into_iter().filter(|&h| Some(h) != entered) {
        let tail = mesh.vertices()[mesh.tail(h) as usize];
        let outward = (mesh.vertices()[mesh.head(h) as usize] - tail).cross(&normal);
        let speed = direction.dot(&outward);
        if speed > 0.0 {
            let step = ((tail - at).dot(&outward) / speed).max(0.0);
            if best.is_none_or(|(_, least)| step < least) {
                best = Some((h, step));
            }
        }
    }
    best
}
