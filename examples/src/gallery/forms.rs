//! Parts of the gallery that are not hollow.

use super::vessels::{bar, cuboid};
use crate::shapes::{blend, cone, ring};
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// A gyroid (A. Schoen, NASA TN D-5541, 1970) in a block of 24 mm between two plates.
pub(super) fn lattice(p: Point3<f64>) -> f64 {
    let [x, y, z] = [p.x, p.y, p.z].map(|at| at * TAU / 12.0);
    let gyroid = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
    // The gradient of the function is at most sqrt(3) times that of a sine.
    let wall = (gyroid.abs() - 0.55) * 12.0 / (TAU * 3f64.sqrt());
    let plates = (p.z - 1.8).min(22.2 - p.z);
    wall.min(plates).max(cuboid(p, [-12.0, -12.0, -2.0], [12.0, 12.0, 24.0]))
}

/// A bracket: a foot, a wall, a gusset between them, and a hole in each.
pub(super) fn bracket(p: Point3<f64>) -> f64 {
    let foot = cuboid(p, [0.0, -9.0, -2.0], [32.0, 9.0, 4.0]);
    let wall = cuboid(p, [0.0, -9.0, -2.0], [4.0, 9.0, 32.0]);
    let slope = (p.x + p.z - 28.0) * 0.5f64.sqrt();
    let gusset = cuboid(p, [0.0, -2.0, 0.0], [28.0, 2.0, 28.0]).max(slope);
    let holes = bar(p, [25.0, 0.0, 0.0], 2, 3.0).max(p.z - 8.0).min(bar(p, [0.0, 0.0, 25.5], 0, 3.0).max(p.x - 8.0));
    foot.min(wall).min(gusset).max(-holes)
}

/// A T, 10 mm thick.
pub(super) fn tee(p: Point3<f64>) -> f64 {
    cuboid(p, [-5.0, -5.0, -2.0], [5.0, 5.0, 30.0]).min(cuboid(p, [-20.0, -5.0, 24.0], [20.0, 5.0, 34.0]))
}

/// Three blades of 2.4 mm around a hub, 50 mm across: the pitch falls from root to tip, as the blade's path does.
pub(super) fn propeller(p: Point3<f64>) -> f64 {
    let hub = bar(p, [0.0; 3], 2, 6.0).max(p.z - 14.0);
    let bore = bar(p, [0.0; 3], 2, 2.5);
    let radius = p.x.hypot(p.y);
    let blades = (0..3).map(|blade| {
        let angle = p.y.atan2(p.x) - TAU * f64::from(blade) / 3.0;
        let across = radius * (angle - TAU * (angle / TAU).round());
        // The helix of a pitch of 60 mm a turn, around the middle of the hub.
        let slope = (60.0 / (TAU * radius.max(4.0))).atan();
        let height = p.z - 7.0;
        let (along, off) = (across * slope.cos() + height * slope.sin(), height * slope.cos() - across * slope.sin());
        let half_chord = 6.0 + 0.12 * radius;
        // Near the hub the coordinates are bent: shortened to be no more than distances.
        0.7 * (off.abs() - 1.2).max(along.abs() - half_chord).max(radius - 24.0).max(4.0 - radius)
    });
    blades.fold(hub, f64::min).max(-bore).max(p.z - 14.0)
}

/// A round bar of 9 mm bent into half a ring between two feet.
pub(super) fn arch(p: Point3<f64>) -> f64 {
    let bow = ring(p, Point3::new(0.0, 0.0, 2.0), Vector3::y(), 17.0, 4.5).max(-p.z);
    let feet = [-17.0, 17.0].map(|x| bar(p, [x, 0.0, 0.0], 2, 6.5).max(p.z - 3.0));
    bow.min(feet[0]).min(feet[1])
}

/// A post that bends over and ends in the air, 12 mm above the plate.
pub(super) fn hook(p: Point3<f64>) -> f64 {
    let post = cone(p, Point3::new(0.0, 0.0, -8.0), Point3::new(0.0, 0.0, 24.0), 5.5, 5.0);
    let bow = ring(p, Point3::new(12.0, 0.0, 24.0), Vector3::y(), 12.0, 5.0).max(24.0 - p.z);
    let end = cone(p, Point3::new(24.0, 0.0, 24.0), Point3::new(24.0, 0.0, 16.0), 5.0, 4.0);
    let foot = bar(p, [0.0; 3], 2, 9.0).max(p.z - 3.0);
    post.min(bow).min(end).min(foot)
}

/// A trunk with five limbs all around, the lowest of them level.
pub(super) fn tree(p: Point3<f64>) -> f64 {
    let trunk = cone(p, Point3::new(0.0, 0.0, -6.0), Point3::new(0.0, 0.0, 40.0), 9.0, 4.5);
    let limbs = (0..5).map(|limb| {
        let (turn, rise) = (TAU * 0.4 * f64::from(limb), 3.0 * f64::from(limb));
        let (sin, cos) = turn.sin_cos();
        let from = Point3::new(0.0, 0.0, 14.0 + 4.0 * f64::from(limb));
        let to = from + Vector3::new(20.0 * cos, 20.0 * sin, rise);
        cone(p, from, to, 4.0, 3.5)
    });
    limbs.fold(trunk, |tree, limb| blend(tree, limb, 2.0))
}
