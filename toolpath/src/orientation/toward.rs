//! The direction in which material is laid: away from the closest point of what is built below.
//!
//! Dai 2020, section 3.5.2, Equation 3.3. Symbols: `q` is the point of the path, `c_q` the closest point, `t_q` the
//! direction.
//!
//! Departs from the paper:
//! * The build plate is a surface below, too: the only one of the first layer, if there is no mould. A mould is an earlier layer.
//! * A closest point counts only if it lies *below*: within [`BESIDE`] of the normal of the layer, on a triangle that
//!   faces the same way within that angle. Where a front waited for another, surfaces of earlier layers end beside a
//!   later one, as near as you like, and say nothing of its direction.
//! * Points *straight* below ([`STRAIGHT`]) come first: the edge of a layer counts only where none is behind it.
//! * A point is looked for among all earlier layers, but not beyond [`REACH`] layer heights. Where there is none (over a
//!   hole of the layers below, or beyond their edge) the normal is the direction.

use crate::layer::{Ground, LayerStack, Triangle, below_layer};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};

/// How far below a layer may be, in heights of the layer. Layers are up to 1.4 heights apart where fronts lean (section
/// 3.6.3); farther away is another branch of the part.
const REACH: f64 = 3.0;

/// Cosine of the angle from the normal, 60 degrees, beyond which a point lies beside a surface, not below it. A layer
/// hangs out over the edge of the one below by at most a cell and a half, which is 56 degrees.
const BESIDE: f64 = 0.5;

/// Cosine of the angle from the normal within which a point is straight below, 30 degrees.
const STRAIGHT: f64 = 0.866_025_403_784_438_6;

/// Points nearer than this, in heights, give no direction.
const TOUCHING: f64 = 1e-6;

/// The direction at `q`, and whether it is that from a closest point.
pub(super) fn toward(
    stack: &LayerStack,
    layer: u32,
    q: Point3<f64>,
    ground: &Ground,
    normal: UnitVector3<f64>,
) -> (UnitVector3<f64>, bool) {
    let below = |c: Point3<f64>, within: f64| {
        let from = q - c;
        let distance = from.norm();
        distance > TOUCHING * ground.height && from.dot(&normal) >= within * distance
    };
    let reach = REACH * ground.height;
    let search = |within: f64| {
        let accept = |c: Point3<f64>, triangle: &Triangle| {
            let face = triangle.normal();
            below(c, within) && face.dot(&normal) >= BESIDE * face.norm()
        };
        stack.tree.nearest(&stack.keys, q, below_layer(layer), reach, accept)
    };
    let found = search(STRAIGHT).or_else(|| search(BESIDE));
    let plate = Point3::new(q.x, q.y, 0.0);
    let first = layer == 0 && stack.mould.is_none() && q.z > TOUCHING * ground.height;
    if first || (q.z <= found.map_or(reach, |found| found.distance) && q.z > 0.0 && below(plate, BESIDE)) {
        return (Vector3::z_axis(), true);
    }
    match found.and_then(|found| Unit::try_new(q - found.point, 0.0)) {
        Some(direction) => (direction, true),
        None => (normal, false),
    }
}
