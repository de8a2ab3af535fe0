//! Bodies: patches that close a volume together, and which of them are to be turned outwards as a whole.

use super::flood::{Patches, Use};
use crate::inspect::bvh::{Aabb, Bvh};
use crate::inspect::orientation::{NO_VOLUME, exit};
use crate::inspect::union::UnionFind;
use nalgebra::{Point3, Vector3};

/// Corners of a body that are asked whether they lie within other bodies: enough to see one that only reaches into
/// another, and few enough that thousands of bodies within each other do no harm.
const ASKED: usize = 64;

/// What is known of a body, its triangles turned as their patches say.
#[derive(Clone, Debug)]
struct Body {
    triangles: Vec<u32>,
    /// Its triangles disagreed, so that its side says nothing.
    mixed: bool,
    /// It has edges that do not close: the sum of their ends, and how many.
    rim: Vector3<f64>,
    rim_ends: u32,
    /// Six times the volume, 0 if that is nothing but rounding.
    volume: f64,
}

/// Which triangles are to be turned so that neighbours agree and bodies look outwards. `corners` are those of the
/// triangles, `place` gives the place of a corner.
pub(super) fn outwards(
    patches: &Patches,
    corners: &[[Point3<f64>; 3]],
    place: &impl Fn(u32) -> Point3<f64>,
) -> Vec<bool> {
    let (bodies, body_of) = bodies(patches, corners, place);
    let mut turned = patches.turned.clone();
    for (body, turn) in bodies.iter().zip(turns(&bodies, &body_of, &turned, corners)) {
        body.triangles.iter().for_each(|&triangle| turned[triangle as usize] ^= turn);
    }
    turned
}

/// The bodies, and which of them each triangle belongs to.
fn bodies(
    patches: &Patches,
    corners: &[[Point3<f64>; 3]],
    place: &impl Fn(u32) -> Point3<f64>,
) -> (Vec<Body>, Vec<u32>) {
    let mut sets = UnionFind::new(corners.len());
    let mut rims: Vec<&Use> = Vec::new();
    let mut sums: Vec<(u32, i32)> = Vec::new();
    for run in patches.edges().filter(|run| run.len() != 2) {
        // By patch, how often it runs along the edge forwards less how often back.
        sums.clear();
        for at in run {
            let patch = patches.of[at.triangle as usize];
            match sums.iter_mut().find(|(of, _)| *of == patch) {
                Some((_, sum)) => *sum += patches.way(at),
                None => sums.push((patch, patches.way(at))),
            }
        }
        sums.retain(|&(_, sum)| sum != 0);
        if sums.iter().map(|&(_, sum)| sum).sum::<i32>() == 0 {
            sums.windows(2).for_each(|pair| sets.join(pair[0].0, pair[1].0));
        } else {
            rims.extend(run.iter().filter(|at| sums.iter().any(|&(of, _)| of == patches.of[at.triangle as usize])));
        }
    }

    let mut numbers = vec![u32::MAX; corners.len()];
    let mut bodies: Vec<Body> = Vec::new();
    let mut body_of = Vec::with_capacity(corners.len());
    for triangle in 0..corners.len() as u32 {
        let patch = patches.of[triangle as usize];
        let number = &mut numbers[sets.find(patch) as usize];
        if *number == u32::MAX {
            *number = bodies.len() as u32;
            let rim = Vector3::zeros();
            bodies.push(Body { triangles: Vec::new(), mixed: false, rim, rim_ends: 0, volume: 0.0 });
        }
        let body = &mut bodies[*number as usize];
        body.triangles.push(triangle);
        body.mixed |= patches.mixed[patch as usize];
        body_of.push(*number);
    }
    for at in rims {
        let body = &mut bodies[body_of[at.triangle as usize] as usize];
        for end in at.ends() {
            body.rim += place(end).coords;
            body.rim_ends += 1;
        }
    }
    for body in &mut bodies {
        body.measure(&patches.turned, corners);
    }
    (bodies, body_of)
}

impl Body {
    /// Sums up the volume; what is open is closed by a cone over its rim.
    fn measure(&mut self, turned: &[bool], corners: &[[Point3<f64>; 3]]) {
        let origin = match self.rim_ends {
            0 => corners[self.triangles[0] as usize][0],
            ends => Point3::from(self.rim / f64::from(ends)),
        };
        let (mut volume, mut magnitude) = (0.0, 0.0);
        for &triangle in &self.triangles {
            let [a, b, c] = corners[triangle as usize].map(|corner| corner - origin);
            let part: f64 = a.dot(&b.cross(&c));
            volume += if turned[triangle as usize] { -part } else { part };
            magnitude += part.abs();
        }
        self.volume = if volume.abs() <= NO_VOLUME * magnitude { 0.0 } else { volume };
    }
}

/// Which bodies are to be turned as a whole.
///
/// They are looked at from the largest volume down, since a body can only lie within larger ones. One that lies within
/// none is turned outwards. One that lies within others keeps its side beside them: it goes with what is around it if
/// that is turned. Bodies whose triangles disagreed are turned outwards before others are held against them.
fn turns(bodies: &[Body], body_of: &[u32], turned: &[bool], corners: &[[Point3<f64>; 3]]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..bodies.len()).filter(|&at| bodies[at].volume != 0.0).collect();
    order.sort_by(|&a, &b| bodies[b].volume.abs().total_cmp(&bodies[a].volume.abs()).then(a.cmp(&b)));
    let mut ranks = vec![usize::MAX; bodies.len()];
    order.iter().enumerate().for_each(|(rank, &at)| ranks[at] = rank);
    // Which of those with a volume and without a rim others may lie within.
    let around = |triangle: u32| Some(body_of[triangle as usize] as usize).filter(|&at| bodies[at].rim_ends == 0);
    let bvh = match order.len() {
        0 | 1 => Bvh::new(std::iter::empty()),
        _ => Bvh::new(corners.iter().map(Aabb::around)),
    };

    let (mut turns, mut taken_as_turned) = (vec![false; bodies.len()], vec![false; bodies.len()]);
    for (rank, &at) in order.iter().enumerate() {
        let body = &bodies[at];
        // How often the larger bodies go round a point, counted along a ray upwards.
        let winding = |point: &Point3<f64>| {
            let mut winding = 0;
            bvh.search(
                |bounds| {
                    (0..2).all(|k| bounds.low[k] <= point[k] && point[k] <= bounds.high[k]) && point.z <= bounds.high[2]
                },
                |triangle| {
                    if let Some(other) = around(triangle).filter(|&other| ranks[other] < rank) {
                        let back = turned[triangle as usize] != taken_as_turned[other];
                        let way = exit(corners[triangle as usize].each_ref(), point);
                        winding += if back { -way } else { way };
                    }
                },
            );
            winding
        };
        let mut goes_round = (rank == 0).then_some(0);
        for &triangle in body.triangles.iter().step_by(body.triangles.len().div_ceil(ASKED)) {
            if goes_round == Some(0) {
                break;
            }
            let here = winding(&corners[triangle as usize][0]);
            if here == 0 || goes_round.is_none() {
                goes_round = Some(here);
            }
        }
        let goes_round = goes_round.unwrap_or(0);
        turns[at] = if goes_round == 0 { body.volume < 0.0 } else { goes_round < 0 };
        taken_as_turned[at] = body.mixed && goes_round == 0 && turns[at];
    }
    turns
}
