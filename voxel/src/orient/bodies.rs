//! Bodies: patches that close a volume together, which of them are to be turned outwards as a whole, and what volume they bound
//! then.
//!
//! An open body is closed by caps over its rims first, so that a hole hides neither which side is outside nor what lies
//! within. Where the winding number of the surface alone, without caps, would have another shell inside or outside, the other
//! reading is kept beside the one taken.

use super::flood::Patches;
use crate::boundary::{OpenEdge, caps};
use crate::inspect::bvh::{Aabb, Bvh};
use crate::inspect::orientation::{NO_VOLUME, exit};
use crate::inspect::union::UnionFind;
use crate::winding::solid_angle;
use nalgebra::Point3;
use std::f64::consts::PI;

/// Corners of a body that are asked whether they lie within other bodies: enough to see one that only reaches into
/// another, and few enough that thousands of bodies within each other do no harm.
const ASKED: usize = 64;

/// The share that [`NO_VOLUME`] is for closed bodies, for open ones: a plane sheet whose corners were rounded to single precision
/// bounds nothing.
const FLAT: f64 = 1e-6;

/// What is known of a body, its triangles turned as their patches say.
#[derive(Clone, Debug)]
struct Body {
    triangles: Vec<u32>,
    /// Its triangles disagreed, so that its side says nothing.
    mixed: bool,
    /// Edges that do not close.
    open: Vec<OpenEdge>,
    /// Six times the volume with the rims closed, 0 if that is nothing but rounding.
    volume: f64,
}

/// What is taken of a mesh, in its own unit.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    /// Which triangles are to be turned so that neighbours agree and bodies look outwards.
    pub(super) turned: Vec<bool>,
    /// Volume within the bodies, and what it would be if nesting were by the winding number without caps.
    pub(super) volume: f64,
    pub(super) other_volume: f64,
    /// Bodies within others that look outwards as those do, and their volume.
    pub(super) shells: usize,
    pub(super) shells_volume: f64,
    /// Bodies that are open and bound nothing, by their triangles.
    pub(super) sheets: Vec<Vec<u32>>,
}

/// Finds the bodies and their sides. `corners` are those of the triangles, `places` of the vertices.
pub(super) fn outwards(patches: &Patches, corners: &[[Point3<f64>; 3]], places: &[Point3<f64>]) -> Bodies {
    let mut surface = Surface { corners: corners.to_vec(), body_of: Vec::new(), turned: patches.turned.clone() };
    let bodies = bodies(patches, places, &mut surface);
    let mut found = Bodies::default();
    let turns = found.nest(&bodies, &surface);
    surface.turned.truncate(corners.len());
    for (body, turn) in bodies.iter().zip(turns) {
        body.triangles.iter().for_each(|&triangle| surface.turned[triangle as usize] ^= turn);
    }
    found.turned = surface.turned;
    let is_sheet = |body: &&Body| body.volume == 0.0 && !body.open.is_empty();
    found.sheets = bodies.iter().filter(is_sheet).map(|body| body.triangles.clone()).collect();
    found
}

/// All triangles, and behind them those of the caps, with the body that each belongs to.
struct Surface {
    corners: Vec<[Point3<f64>; 3]>,
    body_of: Vec<u32>,
    /// As the patches say; caps are right as they are.
    turned: Vec<bool>,
}

/// The bodies; adds their caps to the surface.
fn bodies(patches: &Patches, places: &[Point3<f64>], surface: &mut Surface) -> Vec<Body> {
    let count = surface.corners.len();
    let mut sets = UnionFind::new(count);
    let mut rims: Vec<(u32, OpenEdge)> = Vec::new();
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
            let [low, high] = run[0].ends();
            rims.extend(sums.iter().map(|&(patch, sum)| {
                let ends = if sum > 0 { [low, high] } else { [high, low] };
                (patch, OpenEdge { ends, surplus: sum.unsigned_abs() })
            }));
        }
    }

    let mut numbers = vec![u32::MAX; count];
    let mut bodies: Vec<Body> = Vec::new();
    for triangle in 0..count as u32 {
        let patch = patches.of[triangle as usize];
        let number = &mut numbers[sets.find(patch) as usize];
        if *number == u32::MAX {
            *number = bodies.len() as u32;
            bodies.push(Body { triangles: Vec::new(), mixed: false, open: Vec::new(), volume: 0.0 });
        }
        let body = &mut bodies[*number as usize];
        body.triangles.push(triangle);
        body.mixed |= patches.mixed[patch as usize];
        surface.body_of.push(*number);
    }
    for (patch, edge) in rims {
        bodies[surface.body_of[patch as usize] as usize].open.push(edge);
    }
    for (number, body) in (0..).zip(&mut bodies) {
        let first = surface.corners.len();
        for cap in caps(places, &body.open) {
            let fan = cap.edges.iter().map(|&[a, b]| [cap.apex, places[a as usize], places[b as usize]]);
            surface.corners.extend(fan);
        }
        surface.body_of.resize(surface.corners.len(), number);
        surface.turned.resize(surface.corners.len(), false);
        body.measure(surface, first);
    }
    bodies
}

impl Body {
    /// Sums up the volume; the caps of what is open are from `first_cap` on.
    fn measure(&mut self, surface: &Surface, first_cap: usize) {
        let origin = surface.corners[self.triangles[0] as usize][0];
        let (mut volume, mut magnitude) = (0.0, 0.0);
        let caps = first_cap..surface.corners.len();
        for triangle in self.triangles.iter().map(|&triangle| triangle as usize).chain(caps) {
            let [a, b, c] = surface.corners[triangle].map(|corner| corner - origin);
            let part: f64 = a.dot(&b.cross(&c));
            volume += if surface.turned[triangle] { -part } else { part };
            magnitude += a.norm() * b.cross(&c).norm();
        }
        let least = if self.open.is_empty() { NO_VOLUME } else { FLAT };
        self.volume = if volume.abs() <= least * magnitude { 0.0 } else { volume };
    }
}

impl Bodies {
    /// Which bodies are to be turned as a whole; sums up their volumes.
    ///
    /// They are looked at from the largest volume down, since a body can only lie within larger ones. One that lies within
    /// none is turned outwards. One that lies within others keeps its side beside them: it goes with what is around it if
    /// that is turned. Bodies whose triangles disagreed are turned outwards before others are held against them.
    fn nest(&mut self, bodies: &[Body], surface: &Surface) -> Vec<bool> {
        let mut order: Vec<usize> = (0..bodies.len()).filter(|&at| bodies[at].volume != 0.0).collect();
        order.sort_by(|&a, &b| bodies[b].volume.abs().total_cmp(&bodies[a].volume.abs()).then(a.cmp(&b)));
        let nesting = Nesting::new(bodies, surface, &order);
        let (mut turns, mut taken_as_turned) = (vec![false; bodies.len()], vec![false; bodies.len()]);
        for (rank, &at) in order.iter().enumerate() {
            let body = &bodies[at];
            let corner = |triangle: u32| surface.corners[triangle as usize][0];
            let mut asked = corner(body.triangles[0]);
            let mut goes_round = (rank == 0).then_some(0);
            for &triangle in body.triangles.iter().step_by(body.triangles.len().div_ceil(ASKED)) {
                if goes_round == Some(0) {
                    break;
                }
                let here = nesting.winding(&corner(triangle), rank, &taken_as_turned, true);
                if here == 0 || goes_round.is_none() {
                    (goes_round, asked) = (Some(here), corner(triangle));
                }
            }
            let goes_round = goes_round.unwrap_or(0);
            turns[at] = if goes_round == 0 { body.volume < 0.0 } else { goes_round < 0 };
            taken_as_turned[at] = body.mixed && goes_round == 0 && turns[at];

            let (outwards, volume) = ((body.volume > 0.0) != turns[at], body.volume.abs() / 6.0);
            let around = nesting.winding(&asked, rank, &turns, true);
            let part = match (outwards, around) {
                (true, ..=0) => volume,
                (false, 1) => -volume,
                _ => 0.0,
            };
            self.volume += part;
            if outwards && around > 0 && nesting.lies_within(body, rank, &turns) {
                self.shells += 1;
                self.shells_volume += volume;
            }
            let without_caps = nesting.winding_without_caps(&asked, rank, &turns);
            self.other_volume += match (without_caps >= 1, around >= 1) {
                (true, false) => -volume,
                (false, true) => volume,
                _ => part,
            };
        }
        turns
    }
}

/// Bodies with a volume, by falling volume, to be asked what lies within them.
struct Nesting<'a> {
    bodies: &'a [Body],
    surface: &'a Surface,
    order: &'a [usize],
    ranks: Vec<usize>,
    bvh: Bvh,
}

impl<'a> Nesting<'a> {
    fn new(bodies: &'a [Body], surface: &'a Surface, order: &'a [usize]) -> Self {
        let mut ranks = vec![usize::MAX; bodies.len()];
        order.iter().enumerate().for_each(|(rank, &at)| ranks[at] = rank);
        let bvh = match order.len() {
            0 | 1 => Bvh::new(std::iter::empty()),
            _ => Bvh::new(surface.corners.iter().map(Aabb::around)),
        };
        Nesting { bodies, surface, order, ranks, bvh }
    }

    /// How often the bodies before a rank go round a point, counted along a ray upwards: all of them closed by their caps, or
    /// only those that are closed by themselves.
    fn winding(&self, point: &Point3<f64>, rank: usize, turns: &[bool], with_open: bool) -> i32 {
        let mut winding = 0;
        if rank == 0 {
            return 0;
        }
        self.bvh.search(
            |bounds| {
                (0..2).all(|k| bounds.low[k] <= point[k] && point[k] <= bounds.high[k]) && point.z <= bounds.high[2]
            },
            |triangle| {
                let other = self.surface.body_of[triangle as usize] as usize;
                if self.ranks[other] < rank && (with_open || self.bodies[other].open.is_empty()) {
                    let back = self.surface.turned[triangle as usize] != turns[other];
                    let way = exit(self.surface.corners[triangle as usize].each_ref(), point);
                    winding += if back { -way } else { way };
                }
            },
        );
        winding
    }

    /// The nearest whole number to the winding number of these bodies without their caps.
    fn winding_without_caps(&self, point: &Point3<f64>, rank: usize, turns: &[bool]) -> i32 {
        let mut open = self.order[..rank].iter().filter(|&&at| !self.bodies[at].open.is_empty()).peekable();
        if open.peek().is_none() {
            return self.winding(point, rank, turns, true);
        }
        let mut angle = 0.0;
        for &at in open {
            for &triangle in &self.bodies[at].triangles {
                let part = solid_angle(&self.surface.corners[triangle as usize], point);
                angle += if self.surface.turned[triangle as usize] != turns[at] { -part } else { part };
            }
        }
        self.winding(point, rank, turns, false) + (angle / (4.0 * PI)).round() as i32
    }

    /// Whether all corners of a body lie within larger ones.
    fn lies_within(&self, body: &Body, rank: usize, turns: &[bool]) -> bool {
        let corners = body.triangles.iter().flat_map(|&triangle| &self.surface.corners[triangle as usize]);
        corners.into_iter().all(|corner| self.winding(corner, rank, turns, true) > 0)
    }
}
