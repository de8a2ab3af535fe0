//! Pictures: the sphere of directions coloured by what is missed, and the part in its poses.

use curvlay_examples::mesh::Mesh;
use curvlay_examples::orienting::laid;
use curvlay_examples::render::{Camera, INK, Image, Rgb, Scene};
use curvlay_layers::curved::orient::{JudgedPose, PoseKind};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Pixels of a hemisphere, and of what is around it.
const RADIUS: u32 = 230;
const MARGIN: u32 = 26;
/// Height of the legend.
const LEGEND: u32 = 58;
/// Pixels of a picture of the part.
const PART: [u32; 2] = [400, 360];

const WHITE: Rgb = [255, 255, 255];
/// A pose that misses nothing and stands by itself, and one that does not stand.
const WHOLE: Rgb = [11, 122, 117];
const WHOLE_FALLS: Rgb = [111, 188, 178];
/// Poses that miss little and much.
const LITTLE: Rgb = [254, 232, 180];
const MUCH: Rgb = [166, 24, 32];
/// The part.
const BODY: Rgb = [176, 186, 198];

/// The share of missed cells that is drawn as much: a tenth of the part. A thousandth and less is little; logarithmic in between.
const MUCH_MISSED: f64 = 0.1;
const LITTLE_MISSED: f64 = 1e-3;

fn colour(judged: &JudgedPose) -> Rgb {
    match (judged.missed_cells, judged.stands) {
        (0, true) => WHOLE,
        (0, false) => WHOLE_FALLS,
        _ => {
            between(((judged.missed_share() / LITTLE_MISSED).ln() / (MUCH_MISSED / LITTLE_MISSED).ln()).clamp(0.0, 1.0))
        }
    }
}

fn between(part: f64) -> Rgb {
    [0, 1, 2].map(|k| (f64::from(LITTLE[k]) + part * (f64::from(MUCH[k]) - f64::from(LITTLE[k]))) as u8)
}

/// The sphere of directions as two discs of equal area, seen from above (left) and from below: each place has the colour of the pose with
/// the nearest direction. Squares mark the best pose, the given one, and those at rest.
pub fn sphere(poses: &[JudgedPose], best: &JudgedPose) -> Vec<u8> {
    let side = 2 * (RADIUS + MARGIN);
    let mut image = Image::new(2 * side, side + LEGEND, WHITE);
    let [above, below] = [1.0, -1.0].map(|half: f64| {
        move |x: f64, y: f64| {
            // Lambert's azimuthal projection.
            let (r, angle) = (x.hypot(y), y.atan2(half * x));
            let polar = 2.0 * (r / 2f64.sqrt()).asin();
            Vector3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), half * polar.cos())
        }
    });
    for row in 0..side {
        for column in 0..side {
            let [x, y] = [column, row].map(|at| (f64::from(at) + 0.5 - f64::from(side) / 2.0) / f64::from(RADIUS));
            if x.hypot(y) > 1.0 {
                continue;
            }
            for (left, up) in [(0, above(x, -y)), (side, below(x, -y))] {
                let nearest = poses.iter().max_by(|a, b| a.pose.up.dot(&up).total_cmp(&b.pose.up.dot(&up)));
                nearest.iter().for_each(|judged| image.set(left + column, row, colour(judged)));
            }
        }
    }
    let mut mark = |judged: &JudgedPose, half: u32, ink: Rgb| {
        let up = judged.pose.up;
        let polar = up.z.abs().min(1.0).acos();
        let r = 2f64.sqrt() * (polar / 2.0).sin();
        let angle = up.y.atan2(if up.z < 0.0 { -up.x } else { up.x });
        let left = if up.z < 0.0 { side } else { 0 };
        let at = |along: f64| (f64::from(side) / 2.0 + f64::from(RADIUS) * along) as u32;
        let corner = [left + at(r * angle.cos()) - half, at(-r * angle.sin()) - half];
        image.fill(corner, [2 * half; 2], ink);
    };
    let kinds = [(PoseKind::Resting, 3, INK), (PoseKind::Given, 5, [40, 90, 200])];
    for (kind, half, ink) in kinds {
        poses.iter().filter(|judged| judged.pose.kind == kind).for_each(|judged| mark(judged, half, ink));
    }
    mark(best, 7, INK);
    mark(best, 5, [250, 200, 20]);
    legend(&mut image, side);
    image.to_png()
}

fn legend(image: &mut Image, side: u32) {
    image.write([8, 8], "up", INK);
    image.write([side + 8, 8], "down", INK);
    let mut x = MARGIN;
    let mut entry = |colours: &[Rgb], text: &str| {
        for colour in colours {
            image.fill([x, side + 20], [8, 16], *colour);
            x += 8;
        }
        image.write([x + 6, side + 22], text, INK);
        x += 6 + Image::text_size(text)[0] + 22;
    };
    entry(&[WHOLE, WHOLE], "all built, stands");
    entry(&[WHOLE_FALLS, WHOLE_FALLS], "all built");
    let missed: Vec<Rgb> = (0..8).map(|k| between(f64::from(k) / 7.0)).collect();
    entry(&missed, "missed 0.1 to 10%");
    entry(&[INK], "at rest");
    entry(&[[40, 90, 200]], "given");
    entry(&[[250, 200, 20]], "best");
}

/// The part in a pose, on its platform.
pub fn part(mesh: &Mesh, judged: &JudgedPose, platform_diameter_mm: f64) -> Vec<u8> {
    let laid = laid(mesh, &judged.pose);
    let mut scene = Scene::new(Camera::default());
    if let Some([low, high]) = laid.bounds() {
        let middle = nalgebra::center(&low, &high);
        // Wide enough for the part, and no wider than that where the real one would make it small.
        let radius = (0.5 * platform_diameter_mm).min(0.75 * (high - low).xy().norm());
        let corner = |k: u32| {
            let angle = 2.0 * PI * f64::from(k) / 64.0;
            [middle.x + radius * angle.cos(), middle.y + radius * angle.sin()]
        };
        scene.platform(&(0..64).map(corner).collect::<Vec<_>>(), 0.0);
    }
    scene.mesh(&laid.vertices, &laid.triangles, BODY);
    let [width, height] = PART;
    scene.draw(width, height).to_png()
}
