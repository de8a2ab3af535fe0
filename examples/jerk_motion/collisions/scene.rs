//! What is in the way: head, slab or part, and the arm's links; as the exact scene, and as bodies of the geometric indicator.

use super::super::path::upright;
use curvlay_examples::args::{Failure, warn};
use curvlay_examples::mesh::{MeshFile, Up, read_mesh_file};
use curvlay_examples::motion::{PartInHand, Studied};
use curvlay_kinematics::robots;
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, estimated_links};
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::indicator::geometric::{
    BodiesFn, Capsule, Cylinder, DistanceGrid, GeometricIndicator, GeometricModel, Twist,
};
use nalgebra::{Isometry3, IsometryMatrix3, Point3, Vector3};
use std::f64::consts::PI;
use std::path::Path;

/// The head in the frame of the nozzle, whose z axis points away from the part: name, ends along z, radius.
const HEAD: [(&str, f64, f64, f64); 2] = [("nozzle", 1.5, 40.0, 1.5), ("heater", 50.0, 120.0, 18.0)];
/// Height of a layer: the slab begins so far below the waypoints and is as thick.
const LAYER_MM: f64 = 0.8;
/// Edge of the cells of the slab, and how far aside of a waypoint it reaches.
const CELL_MM: f64 = 0.5;
const ASIDE_MM: f64 = 1.2;
/// Cells around the slab in the grid of distances: the thickest link, the upper arm, has a radius of 47 mm.
const ROOM: u32 = 120;
/// Nodes along the longest side of a part from a file, in the grid of distances.
const NODES: f64 = 150.0;

/// The frame of wrist 2, how far the head of a post reaches into it, and the step by which its way is found, in radians.
const WRIST: usize = 5;
const POST_DEPTH_MM: f64 = 5.0;
const STEP: f64 = 1e-4;

/// What is in the way in the hand.
pub struct Obstacle {
    shape: Shape,
    /// Where the shape begins, in the frame of the part.
    corner: Point3<f64>,
    grid: DistanceGrid,
}

/// The head of a post that stands in the way of the arm: a ball.
#[derive(Clone, Copy, Debug)]
pub struct Post {
    middle: Point3<f64>,
    radius: f64,
}

impl Post {
    /// A ball of this radius that reaches [`POST_DEPTH_MM`] into wrist 2 at a posture, on the side to which the arm moves it
    /// with these rates of the joints.
    pub fn beside_wrist(robot: &PartInHand, joints: &[f64; 6], rates: &[f64; 6], radius: f64) -> Option<Self> {
        let arm = *robot.workcell().setup().arm();
        let wrist = |step: f64| -> Point3<f64> {
            let moved = std::array::from_fn(|j| joints[j] + step * rates[j]);
            arm.frames(&moved)[WRIST].translation.vector.into()
        };
        let aside = (wrist(STEP) - wrist(-STEP)).try_normalize(f64::MIN_POSITIVE)?;
        let thick = estimated_links(&robots::UR3).into_iter().find_map(|link| match (link.mount, link.shape) {
            (Mount::Link(WRIST), Shape::Capsule { radius, .. }) => Some(radius),
            _ => None,
        })?;
        Some(Post { middle: wrist(0.0) + aside * (thick + radius - POST_DEPTH_MM), radius })
    }
}

/// Cells a layer below the waypoints.
pub fn slab(robot: &PartInHand) -> Result<Obstacle, Failure> {
    let waypoints = robot.path();
    let around = Vector3::repeat(2.0 * LAYER_MM + ASIDE_MM);
    let low = waypoints.iter().fold(Point3::from([f64::INFINITY; 3]), |low, at| low.inf(&at.position)) - around;
    let high = waypoints.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, at| high.sup(&at.position)) + around;
    let dims = [0, 1, 2].map(|d| ((high[d] - low[d]) / CELL_MM).ceil() as usize);
    let words = dims[0].div_ceil(64);
    let mut rows = vec![0u64; words * dims[1] * dims[2]];
    let deep = 2.0 * LAYER_MM;
    for waypoint in waypoints {
        let range = |d: usize| {
            let place = |by: f64| ((waypoint.position[d] + by - low[d]) / CELL_MM).max(0.0) as usize;
            place(-deep - ASIDE_MM)..dims[d].min(place(ASIDE_MM) + 1)
        };
        for (z, y, x) in range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| (z, y, x)))) {
            let center = low + Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * CELL_MM;
            let from = center - waypoint.position;
            let below = -from.dot(&waypoint.axis);
            let aside = (from.norm_squared() - below * below).max(0.0).sqrt();
            if (LAYER_MM..deep).contains(&below) && aside < ASIDE_MM {
                rows[words * (y + dims[1] * z) + x / 64] |= 1 << (x % 64);
            }
        }
    }
    let dims = dims.map(|n| n as u32);
    let grid = DistanceGrid::from_cells(dims, &rows, CELL_MM, &low, ROOM)?;
    Ok(Obstacle { shape: Shape::Cells { dims, rows, cell: CELL_MM }, corner: low, grid })
}

/// A closed part from a file, where the waypoints have it.
pub fn from_file(file: &Path, up: Up, origin: &Vector3<f64>) -> Result<Obstacle, Failure> {
    let MeshFile { mesh, findings, .. } = read_mesh_file(file)?;
    findings.iter().for_each(|finding| warn(format!("{}: {finding}", file.display())));
    let (vertices, _) = upright(&(mesh.vertices, vec![]), up);
    let points: Vec<Point3<f64>> = vertices.iter().map(|point| point - origin).collect();
    let low = points.iter().fold(Point3::from([f64::INFINITY; 3]), |low, at| low.inf(at));
    let high = points.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, at| high.sup(at));
    let spacing = ((high - low).amax() / NODES).max(CELL_MM);
    let grid = DistanceGrid::from_triangles(&points, &mesh.triangles, spacing, f64::from(ROOM) * CELL_MM)
        .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
    Ok(Obstacle { shape: Shape::Mesh { points, triangles: mesh.triangles }, corner: Point3::origin(), grid })
}

pub fn scene(robot: &PartInHand, obstacle: &Obstacle, post: Option<&Post>) -> Result<Scene, Failure> {
    let cell = robot.workcell().setup();
    let z = |z: f64| Point3::new(0.0, 0.0, z);
    let head = HEAD.map(|(name, from, to, radius)| Body {
        name: name.into(),
        mount: Mount::Base,
        mount_body: cell.nozzle_frame().1,
        shape: Shape::Capsule { from: z(from), to: z(to), radius },
    });
    let part = Body {
        name: "part".into(),
        mount: Mount::Link(6),
        mount_body: cell.part_frame().1
            * Isometry3::translation(obstacle.corner.x, obstacle.corner.y, obstacle.corner.z),
        shape: obstacle.shape.clone(),
    };
    let post = post.map(|&Post { middle, radius }| Body {
        name: "post".into(),
        mount: Mount::Base,
        mount_body: Isometry3::identity(),
        shape: Shape::Capsule { from: middle, to: middle, radius },
    });
    let bodies = head.into_iter().chain([part]).chain(post).collect();
    Ok(Scene::new(SceneModel { bodies, links: estimated_links(&robots::UR3), ..SceneModel::of(*cell.arm()) })?)
}

/// The part as a grid; head and links as capsules, foot and flange as cylinders, against it and each other.
pub fn geometric(
    robot: &PartInHand,
    obstacle: &Obstacle,
    post: Option<&Post>,
) -> Result<impl CollisionIndicator<6> + use<>, Failure> {
    let cell = *robot.workcell().setup();
    let held = nalgebra::convert::<_, IsometryMatrix3<f64>>(cell.part_frame().1);
    // Bodies 0 to 6 are the frames of the arm, body 7 is the part.
    let bodies = BodiesFn {
        carriers: (0..8).map(|body: usize| std::array::from_fn(|joint| joint < body.min(6))).collect(),
        place: move |q: &[f64; 6], frames: &mut [IsometryMatrix3<f64>]| {
            frames[..7].copy_from_slice(&cell.arm().matrices(q));
            frames[7] = frames[6] * held;
        },
        // A joint of such an arm turns about the z axis of the frame before it.
        twists: |_: &[f64; 6], frames: &[IsometryMatrix3<f64>]| {
            let axis = |k: usize| frames[k].rotation * Vector3::z();
            std::array::from_fn(|k| Twist::turning(&frames[k].translation.vector.into(), &axis(k)))
        },
    };
    let base_nozzle = cell.nozzle_frame().1;
    let at = |z: f64| base_nozzle * Point3::new(0.0, 0.0, z);
    let (mut capsules, mut cylinders) = (vec![], vec![]);
    for link in estimated_links(&robots::UR3) {
        let body = if let Mount::Link(link) = link.mount { link } else { 0 };
        match link.shape {
            Shape::Capsule { from, to, radius } => capsules.push(Capsule { body, from, to, radius }),
            Shape::Hull { points, .. } => cylinders.push(drum(body, &points)),
            Shape::Mesh { .. } | Shape::Cells { .. } | Shape::Union(_) => unreachable!("links are capsules and hulls"),
        }
    }
    capsules.extend(HEAD.map(|(_, from, to, radius)| Capsule { body: 0, from: at(from), to: at(to), radius }));
    capsules.extend(post.map(|&Post { middle, radius }| Capsule { body: 0, from: middle, to: middle, radius }));
    let model = GeometricModel {
        grids: vec![(7, obstacle.grid.clone())],
        capsules,
        cylinders,
        ignored: (0..6).map(|k| [k, k + 1]).collect(),
        ..GeometricModel::default()
    };
    Ok(GeometricIndicator::new(bodies, model)?)
}

/// The cylinder about z that a prism of twelve sides stands for: midway between the circles within and about it.
fn drum(body: usize, points: &[Point3<f64>]) -> Cylinder {
    let about = points.iter().map(|point| point.x.hypot(point.y)).fold(0.0, f64::max);
    let low = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|point| point.z).fold(f64::NEG_INFINITY, f64::max);
    let end = |z: f64| Point3::new(0.0, 0.0, z);
    Cylinder { body, from: end(low), to: end(high), radius: 0.5 * about * (1.0 + (PI / 12.0).cos()) }
}
