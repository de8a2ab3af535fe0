//! Pictures of a reach: the frames as small crystals, the box, and the arm in it.

use super::reaching::{Reached, is_in_box};
use curvlay_examples::render::{Camera, INK, Rgb, Scene, ramp};
use curvlay_examples::viewer::{Mark, Marks, Model, Robot, Stance};
use curvlay_kinematics::Arm;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};

/// Pixels of each picture.
const PICTURE: [u32; 2] = [620, 560];
/// Half the width of a crystal, as a share of the reach.
const CRYSTAL: f64 = 0.008;
/// Half the width of the edges of the box and of the arm's bones.
const EDGE: f64 = 0.005;
const BONE: f64 = 0.02;
/// Frames in the box, and the box; other frames in the viewer.
const IN_BOX: Rgb = [232, 98, 20];
const OUTSIDE: Rgb = [120, 140, 170];

/// The side from which a reach is seen; what is nearer to the viewer than the nozzle is left out.
pub fn picture(reached: &Reached, toward: Vector3<f64>, box_mm: f64) -> Vec<u8> {
    let mut scene = Scene::new(Camera::from_direction(toward));
    let size = reached.points.iter().map(|point| point.coords.norm()).fold(1.0, f64::max);
    let centre = reached.placement.centre;
    let top = reached.points.iter().map(|point| point.z).fold(1.0, f64::max);
    for point in &reached.points {
        let inside = is_in_box(point, &reached.placement, box_mm);
        if inside || (point - centre).dot(&toward) <= 0.0 {
            let colour = if inside { IN_BOX } else { ramp(point.z / top) };
            let halves = [0, 1, 2].map(|axis| Vector3::ith(axis, CRYSTAL * size));
            scene.triangles(crystal(point, &halves).map(|triangle| (triangle, colour)));
        }
    }
    let corner = |k: usize| {
        let sides = [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -0.5 * box_mm } else { 0.5 * box_mm });
        centre + Vector3::from(sides)
    };
    for k in 0..8usize {
        for axis in (0..3).filter(|axis| k >> axis & 1 == 0) {
            scene.bar(corner(k), corner(k | 1 << axis), EDGE * size, IN_BOX);
        }
    }
    if let (Ok(arm), Some(posture)) = (Arm::new(reached.name.model()), &reached.posture) {
        let frames = arm.frames(posture).map(|frame| Point3::from(frame.translation.vector));
        for ends in frames.windows(2) {
            scene.bar(ends[0], ends[1], BONE * size, INK);
        }
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

/// All frames, and the arm at a waypoint, to be turned.
pub fn build(reached: &Reached, box_mm: f64) -> Model {
    let marks = |what: &str, colour: Rgb, in_box: bool| {
        let points = reached.points.iter().filter(|point| is_in_box(point, &reached.placement, box_mm) == in_box);
        Marks { what: what.to_owned(), colour, places: points.map(|&at| Mark { at, path: None }).collect() }
    };
    let arm = Arm::new(reached.name.model()).ok().zip(reached.posture);
    let robot = arm.map(|(arm, posture)| {
        let frames = arm.frames(&posture).map(|frame| Point3::from(frame.translation.vector));
        let bones = frames.windows(2).map(|ends| [ends[0], ends[1]]).collect();
        let stance = Stance { seconds: 0.0, joints: Vec::new(), bones, part: Isometry3::identity() };
        let name = reached.name.title().to_owned();
        Robot { name, speeds: Vec::new(), stances: vec![stance], is_shown: true }
    });
    Model {
        name: reached.name.title().to_owned(),
        marks: vec![marks("frames in the box", IN_BOX, true), marks("other frames", OUTSIDE, false)],
        robot,
        ..Model::default()
    }
}

/// The eight faces between the ends of three axes.
fn crystal(middle: &Point3<f64>, halves: &[Vector3<f64>; 3]) -> [[Point3<f64>; 3]; 8] {
    std::array::from_fn(|k| {
        [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { middle + halves[axis] } else { middle - halves[axis] })
    })
}
