//! Parts of the gallery that are hollow.

use crate::shapes::{cone, ellipsoid};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_3, TAU};

/// A box by its low and high corner, mm.
pub(super) fn cuboid(p: Point3<f64>, low: [f64; 3], high: [f64; 3]) -> f64 {
    let outside = |axis: usize| (low[axis] - p[axis]).max(p[axis] - high[axis]);
    outside(0).max(outside(1)).max(outside(2))
}

/// A round bar of unlimited length along an axis.
pub(super) fn bar(p: Point3<f64>, through: [f64; 3], axis: usize, radius: f64) -> f64 {
    let mut away = p - Point3::from(through);
    away[axis] = 0.0;
    away.norm() - radius
}

/// The body of a boat at a distance inside of its skin: a bow at +x that flares, a stern cut flat at -x.
fn hull_body(p: Point3<f64>, inset: f64) -> f64 {
    let rise = (p.z / 12.0).clamp(0.0, 1.3);
    // The bow leans forward and the sides lean out, as far as a nozzle of three axes would still print.
    let bow = 15.0 + 4.5 * rise - inset;
    let along = ((p.x + 2.0) / (bow + 2.0)).clamp(0.0, 1.5);
    let half = (7.0 + 2.0 * rise) * (1.0 - along * along * along) - inset;
    let side = (p.y.abs() - half) * 0.85;
    side.max(-18.0 + inset - p.x)
}

/// A boat of 38 mm: the kind that printers are judged by (after the idea of *3DBenchy*, Creative Tools, 2015; the shape is our own).
pub(super) fn boat(p: Point3<f64>) -> f64 {
    let sheer = 11.0 + 3.0 * (p.x / 20.0).max(0.0).powi(2);
    let hull = hull_body(p, 0.0).max(p.z - sheer);
    // The hold, as deep as its floor.
    let hold = hull_body(p, 2.2).max(3.0 - p.z);
    let hull = hull.max(-hold);

    let outer = cuboid(p, [-11.0, -5.6, 2.0], [3.0, 5.6, 22.0]);
    let inner = cuboid(p, [-9.2, -3.8, 3.0], [1.2, 3.8, 20.2]);
    let roof = cuboid(p, [-12.5, -6.6, 20.2], [4.5, 6.6, 22.2]);
    let front = cuboid(p, [0.0, -3.0, 13.0], [6.0, 3.0, 18.0]);
    let sides = bar(p, [-4.0, 0.0, 15.5], 1, 2.5);
    let door = cuboid(p, [-14.0, -2.6, 3.0], [-8.0, 2.6, 16.5]);
    let cabin = outer.max(-inner).min(roof).max(-front).max(-sides).max(-door);

    let chimney = bar(p, [-7.0, 0.0, 0.0], 2, 2.6).max(cuboid(p, [-12.0, -5.0, 21.0], [0.0, 5.0, 29.0]));
    let flue = bar(p, [-7.0, 0.0, 0.0], 2, 1.4).max(24.0 - p.z);
    hull.min(cabin).min(chimney.max(-flue))
}

/// A pipe of 16 mm that parts in two, with a wall of 2 mm; all three ends are open.
pub(super) fn pipe(p: Point3<f64>) -> f64 {
    let fork = Point3::new(0.0, 0.0, 18.0);
    let ends = [Point3::new(-21.0, 0.0, 45.0), Point3::new(21.0, 0.0, 45.0)];
    let pipes = |trunk: f64, limb: f64| {
        let down = cone(p, Point3::new(0.0, 0.0, -20.0), fork, trunk, trunk);
        ends.iter().fold(down, |near, &end| near.min(cone(p, fork, end, limb, limb)))
    };
    pipes(8.0, 6.5).max(-pipes(6.0, 4.5)).max(p.z - 40.0)
}

/// A vase with six bulges that wind upwards, 46 mm tall, its wall 1.8 mm outwards and 1.3 mm across in the grooves.
pub(super) fn vase(p: Point3<f64>) -> f64 {
    let bulge = |inset: f64| {
        let turn = 6.0 * (p.y.atan2(p.x) - p.z / 46.0 * FRAC_PI_3);
        let radius = 13.0 + 4.0 * (TAU * p.z / 46.0).sin() + 1.2 * turn.cos();
        // The wall leans by up to 33 degrees, the bulges by as much around.
        (p.x.hypot(p.y) - radius + inset) * 0.8
    };
    bulge(0.0).max(-bulge(1.8).max(2.0 - p.z)).max(p.z - 46.0)
}

/// Half a hollow ball of 20 mm radius, its wall 2.4 mm.
pub(super) fn dome(p: Point3<f64>) -> f64 {
    let ball = p.coords.norm();
    (ball - 20.0).max(17.6 - ball)
}

/// The top of the mould: a flat dome over an ellipse.
fn dome_of_mould(p: Point3<f64>) -> f64 {
    ellipsoid(p, Point3::new(0.0, 0.0, 0.0), Vector3::new(24.0, 19.0, 12.0))
}

/// A mould of 12 mm.
pub(super) fn dish_mould(p: Point3<f64>) -> f64 {
    dome_of_mould(p)
}

/// A dish of 3 mm over the mould, cut off at z = 4 and around, where it runs out to a sharp edge, with a ring on it.
pub(super) fn dish(p: Point3<f64>) -> f64 {
    let mould = dome_of_mould(p);
    let ring = bar(p, [0.0; 3], 2, 7.0).max(-bar(p, [0.0; 3], 2, 4.5)).max(p.z - 16.0);
    (mould - 3.0).min(ring).max(-mould).max(4.0 - p.z).max(p.x.hypot(p.y * 1.25) - 22.0)
}
