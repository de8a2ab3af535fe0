//! A made-up cell: a UR5 with an extruder prints a bowl upside down beside a tower, on a desk. The exact answer comes from
//! the collision scene of `curvlay-kinematics`, the indicator from this crate.

use curvlay_kinematics::scene::{Body, Mount, Posture, Scene, SceneModel, Shape, estimated_links};
use curvlay_kinematics::{Arm, robots};
use curvlay_trajectory::indicator::geometric::{
    Bodies, BodiesFn, Capsule, Cylinder, DistanceGrid, GeometricIndicator, GeometricModel, Plane, Twist,
};
use curvlay_trajectory::indicator::{ContactFn, ContactSpace};
use curvlay_trajectory::nalgebra::{
    Isometry3, IsometryMatrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use std::f64::consts::TAU;

/// Side of a cell of the part, in millimetres.
pub const CELL: f64 = 2.0;
const DIMS: [u32; 3] = [90, 60, 60];
/// Where the part's grid begins.
pub const CORNER: [f64; 3] = [-620.0, -60.0, 0.0];
/// The dome: its centre on the desk, and its radius as built so far.
pub const DOME: ([f64; 3], f64) = ([-560.0, 0.0, 0.0], 50.0);
/// The layer that is printed on it.
pub const LAYER: f64 = 2.0;
/// The tip, from the flange: the nozzle stands out along z.
pub const TIP: f64 = 120.0;

/// Cells of the dome and of a tower beside it.
pub fn part() -> Vec<u64> {
    let words = DIMS[0].div_ceil(64) as usize;
    let mut rows = vec![0; words * (DIMS[1] * DIMS[2]) as usize];
    for k in 0..DIMS[0] * DIMS[1] * DIMS[2] {
        let at = [k % DIMS[0], k / DIMS[0] % DIMS[1], k / DIMS[0] / DIMS[1]];
        let p = [0, 1, 2].map(|d| CORNER[d] + CELL * (f64::from(at[d]) + 0.5));
        let from_dome = [0, 1, 2].map(|d| p[d] - DOME.0[d]);
        let in_dome = from_dome.iter().map(|x| x * x).sum::<f64>() < DOME.1 * DOME.1;
        let in_tower = p[0] > -500.0 && p[0] < -470.0 && p[1].abs() < 15.0 && p[2] < 100.0;
        if in_dome || in_tower {
            rows[words * (at[1] + DIMS[1] * at[2]) as usize + at[0] as usize / 64] |= 1 << (at[0] % 64);
        }
    }
    rows
}

fn head() -> [(&'static str, Point3<f64>, Point3<f64>, f64); 2] {
    let z = |z: f64| Point3::new(0.0, 0.0, z);
    [("nozzle", z(TIP - 1.5), z(TIP - 40.0), 1.5), ("heater", z(TIP - 32.0), z(20.0), 18.0)]
}

/// The exact scene; the nozzle may not touch what is built, only the layer to come.
pub fn scene() -> Scene {
    let capsules = head().map(|(name, from, to, radius)| Body {
        name: name.into(),
        mount: Mount::Link(6),
        mount_body: Isometry3::identity(),
        shape: Shape::Capsule { from, to, radius },
    });
    let base = |name: &str, mount_body, shape| Body { name: name.into(), mount: Mount::Base, mount_body, shape };
    let desk = Shape::block(Point3::new(-1000.0, -1000.0, -50.0), Point3::new(1000.0, 1000.0, -0.5));
    let post =
        Shape::Capsule { from: Point3::new(-400.0, 250.0, 0.0), to: Point3::new(-400.0, 250.0, 600.0), radius: 30.0 };
    let cells = Shape::Cells { dims: DIMS, rows: part(), cell: CELL };
    let mut bodies = capsules.to_vec();
    bodies.push(base("desk", Isometry3::identity(), desk));
    bodies.push(base("post", Isometry3::identity(), post));
    bodies.push(base("part", Isometry3::translation(CORNER[0], CORNER[1], CORNER[2]), cells));
    let arm = Arm::new(&robots::UR5).unwrap();
    Scene::new(SceneModel { bodies, links: estimated_links(&robots::UR5), ..SceneModel::of(arm) }).unwrap()
}

pub fn grid() -> DistanceGrid {
    DistanceGrid::from_cells(DIMS, &part(), CELL, &CORNER.into(), 40).unwrap()
}

/// Bodies 0 to 6 are the frames of the arm, base to flange.
pub fn bodies() -> impl Bodies<6> {
    let arm = Arm::new(&robots::UR5).unwrap();
    BodiesFn {
        carriers: (0..7).map(|body| std::array::from_fn(|joint| joint < body)).collect(),
        place: move |q: &[f64; 6], frames: &mut [IsometryMatrix3<f64>]| frames.copy_from_slice(&arm.matrices(q)),
        // A joint of such an arm turns about the z axis of the frame before it.
        twists: |_: &[f64; 6], frames: &[IsometryMatrix3<f64>]| {
            std::array::from_fn(|k| {
                let axis = frames[k].rotation * Vector3::z();
                Twist::turning(&frames[k].translation.vector.into(), &axis)
            })
        },
    }
}

/// The indicator: head, links and post as capsules, foot and flange as cylinders, the desk as a plane.
pub fn indicator() -> GeometricIndicator<6, impl Bodies<6>> {
    let (mut capsules, mut cylinders) = (vec![], vec![]);
    for body in estimated_links(&robots::UR5) {
        let number = if let Mount::Link(link) = body.mount { link } else { 0 };
        match body.shape {
            Shape::Capsule { from, to, radius } => capsules.push(Capsule { body: number, from, to, radius }),
            // Prisms of twelve sides: midway between the circles within and about them.
            Shape::Hull { points, .. } => {
                let about = points.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
                let low = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                let high = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
                let end = |z: f64| Point3::new(0.0, 0.0, z);
                let radius = 0.5 * about * (1.0 + (TAU / 24.0).cos());
                cylinders.push(Cylinder { body: number, from: end(low), to: end(high), radius });
            }
            _ => unreachable!("links are capsules and hulls"),
        }
    }
    capsules.extend(head().map(|(_, from, to, radius)| Capsule { body: 6, from, to, radius }));
    let post =
        Capsule { body: 0, from: Point3::new(-400.0, 250.0, 0.0), to: Point3::new(-400.0, 250.0, 600.0), radius: 30.0 };
    capsules.push(post);
    let desk = Plane { body: 0, point: Point3::new(0.0, 0.0, -0.5), normal: Vector3::z_axis() };
    let model = GeometricModel {
        grids: vec![(0, grid())],
        capsules,
        cylinders,
        planes: vec![desk],
        ignored: (0..6).map(|k| [k, k + 1]).collect(),
        ..GeometricModel::default()
    };
    GeometricIndicator::new(bodies(), model).unwrap()
}

/// The tip on the dome's new layer, tilted by up to half a right angle from its normal, turned at will, on any branch
/// whose joints are within a turn.
pub fn contact(scene: &Scene) -> impl ContactSpace<6> + '_ {
    let arm = Arm::new(&robots::UR5).unwrap();
    ContactFn {
        collides: |q: &[f64; 6]| scene.touching(&Posture::from(*q)).unwrap().is_some(),
        gap: move |q: &[f64; 6]| {
            let tip = arm.forward(q) * Point3::new(0.0, 0.0, TIP);
            (tip - Point3::from(DOME.0)).norm() - DOME.1 - LAYER
        },
        sample: move |random: &mut dyn FnMut() -> f64| {
            let (around, up) = (TAU * random(), 0.3 + 0.7 * random());
            let out = (1.0 - up * up).sqrt();
            let normal = Vector3::new(out * around.cos(), out * around.sin(), up);
            let tip = Point3::from(DOME.0) + normal * (DOME.1 + LAYER);
            let down = Rotation3::rotation_between(&Vector3::z(), &-normal)
                .unwrap_or_else(|| Rotation3::new(Vector3::x() * TAU / 2.0));
            let tilt = Rotation3::new(Vector3::new(random() - 0.5, random() - 0.5, 0.0));
            let turn = Rotation3::new(Vector3::z() * (TAU * random()));
            let base_tip =
                Isometry3::from_parts(Translation3::from(tip.coords), UnitQuaternion::from(down * tilt * turn));
            let solutions = arm.inverse(&(base_tip * Isometry3::translation(0.0, 0.0, -TIP))).unwrap();
            let all: Vec<[f64; 6]> = solutions.iter().map(|(_, joints)| *joints).collect();
            (!all.is_empty()).then(|| all[((random() * all.len() as f64) as usize).min(all.len() - 1)])
        },
    }
}
