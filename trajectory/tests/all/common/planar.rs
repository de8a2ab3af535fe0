//! A planar arm of three links that follows a circle between three discs: the setting of C. Dai, *Material Deposition
//! in 3D Space* (TU Delft 2020), section 4.4.3 and Fig. 4.5, with a path and obstacles of our own (the figure gives no
//! numbers).

use curvlay_trajectory::indicator::{ContactFn, ContactSpace};
use std::f64::consts::{PI, TAU};

/// Lengths of the links, in millimetres.
pub const LINKS: [f64; 3] = [300.0, 250.0, 150.0];
/// Half the girth of a link.
pub const GIRTH: f64 = 15.0;
/// Centre and radius of the path.
pub const PATH: ([f64; 2], f64) = ([330.0, 180.0], 140.0);
/// Centres and radii of the obstacles.
pub const DISCS: [([f64; 2], f64); 3] = [([160.0, 330.0], 70.0), ([330.0, 180.0], 50.0), ([430.0, -90.0], 80.0)];

/// Base, elbow, wrist, tip.
pub fn corners(q: &[f64; 3]) -> [[f64; 2]; 4] {
    let mut at = [[0.0; 2]; 4];
    let mut turn = 0.0;
    for k in 0..3 {
        turn += q[k];
        at[k + 1] = [at[k][0] + LINKS[k] * turn.cos(), at[k][1] + LINKS[k] * turn.sin()];
    }
    at
}

fn to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let t = ((ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1])).clamp(0.0, 1.0);
    (ap[0] - t * ab[0]).hypot(ap[1] - t * ab[1])
}

/// The truth: whether a link touches a disc.
pub fn collides(q: &[f64; 3]) -> bool {
    let at = corners(q);
    DISCS.iter().any(|(center, radius)| (0..3).any(|k| to_segment(*center, at[k], at[k + 1]) < radius + GIRTH))
}

/// Signed distance of the tip from the path.
pub fn gap(q: &[f64; 3]) -> f64 {
    let tip = corners(q)[3];
    (tip[0] - PATH.0[0]).hypot(tip[1] - PATH.0[1]) - PATH.1
}

/// A point of the path, by the angle about its centre.
pub fn on_path(along: f64) -> [f64; 2] {
    [PATH.0[0] + PATH.1 * along.cos(), PATH.0[1] + PATH.1 * along.sin()]
}

/// Joints in `(-pi, pi]` for a tip and the direction of the last link; the elbow bends by the sign of `side`. `None` out
/// of reach.
pub fn inverse(tip: [f64; 2], turn: f64, side: f64) -> Option<[f64; 3]> {
    let wrist = [tip[0] - LINKS[2] * turn.cos(), tip[1] - LINKS[2] * turn.sin()];
    let far = wrist[0].hypot(wrist[1]);
    let cos = (far * far - LINKS[0] * LINKS[0] - LINKS[1] * LINKS[1]) / (2.0 * LINKS[0] * LINKS[1]);
    if !(-1.0..=1.0).contains(&cos) {
        return None;
    }
    let q2 = side * cos.acos();
    let q1 = wrist[1].atan2(wrist[0]) - (LINKS[1] * q2.sin()).atan2(LINKS[0] + LINKS[1] * q2.cos());
    let within = |angle: f64| angle - TAU * ((angle - PI) / TAU).ceil();
    Some([within(q1), q2, within(turn - q1 - q2)])
}

/// Any point of the path, any direction of the last link, either elbow.
fn sample(random: &mut dyn FnMut() -> f64) -> Option<[f64; 3]> {
    let (along, turn) = (TAU * random(), TAU * random());
    inverse(on_path(along), turn, if random() < 0.5 { -1.0 } else { 1.0 })
}

/// The contact space.
pub fn space() -> impl ContactSpace<3> {
    ContactFn { collides, gap, sample }
}
