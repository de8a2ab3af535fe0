//! Which parts of a layer are near the outside of the part: skins.
//!
//! From each vertex a straight column goes along the normal of the surface, up and down, one and a half thicknesses long for each layer of
//! a skin. The vertex is covered if all the next layers, and all the last ones, cross their column; else the part ends there. How many
//! layers do is a number at each vertex, linear over triangles; where it falls below what is asked for the skin begins, and from there
//! it is grown by a bead, so that it holds on what is beside it.
//!
//! Vertices on a rim count as their neighbours inside do: rims of layers that lie on each other never match exactly.
//!
//! A column meets a triangle in the triangle's own box alone: of one without height rounding would make a place far away, and whether that is found would depend on what else is
//! in the tree. So what is covered depends on nothing but the layers that are asked for.
//!
//! Departs from exact: coverage is sampled at vertices, and the growth goes along edges of the mesh, by up to a sixth less than asked for.

use super::site::Site;
use crate::ProgressFn;
use crate::layer::{LayerStack, LayerSurface, Node, StackError, Triangle, Walk, of_layer};
use crate::parallel;
use crate::path::PathOptions;
use nalgebra::{Point3, Vector3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Columns reach this many thicknesses for each layer: layers are no more than that apart where they belong together.
pub(super) const COLUMN: f64 = 1.5;

/// Where a skin begins, in layers short of all: next to the last vertex that is covered, since the outside of the part may be anywhere between
/// it and the first that is not.
const SHORT: f64 = 0.05;

/// How much skins grow, in beads.
pub(super) const GROWTH: f64 = 1.0;

/// A column this near to the edge of a triangle, as a share of the triangle, meets it: edges are no cracks.
const EDGE: f64 = 1e-9;

/// How far outside the box of a triangle its place on a column may come to lie by rounding, as a share of one and the coordinates; boxes of the tree have far more room.
const ROUNDING: f64 = 1e-13;

/// Where layers are in the part.
#[derive(Default)]
pub(crate) struct Sites<'a> {
    /// Of those that were asked for.
    pub of_layer: Vec<Option<Site>>,
    /// The layers without curves; none if there are no skins.
    pub stack: Option<LayerStack<'a>>,
}

/// Where some layers are in the part; none if the callback stopped the work.
pub(crate) fn sites<'a>(
    surfaces: &[LayerSurface<'a>],
    is_wanted: impl Fn(usize) -> bool + Sync,
    options: &PathOptions,
    progress: ProgressFn,
) -> Result<Option<Sites<'a>>, StackError> {
    let skin = options.infill.skin as usize;
    let stack =
        (skin > 0).then(|| LayerStack::of_paths(surfaces.iter().map(|&surface| (surface, &[][..])))).transpose()?;
    let whole: Vec<u32> = (0..).zip(surfaces).filter(|(_, surface)| !surface.is_half).map(|(layer, _)| layer).collect();
    let work = |layer: usize, surface: &LayerSurface| {
        // A surface with a corner that is not there is refused where it is filled.
        if !is_wanted(layer) || surface.triangles.iter().flatten().any(|&v| v as usize >= surface.vertices.len()) {
            return None;
        }
        let number = whole.partition_point(|&other| (other as usize) < layer);
        let (below, above) = (&whole[..number], &whole[number + usize::from(!surface.is_half)..]);
        let counts = match &stack {
            Some(stack) => covered(stack, surface, [below, above], skin),
            None => vec![0.0; surface.vertices.len()],
        };
        Some(Site { number, skin: grown(surface, &counts, skin, GROWTH * options.bead) })
    };
    let of_layer = parallel::map(surfaces, "skin", progress, work);
    Ok(of_layer.map(|of_layer| Sites { of_layer, stack }))
}

/// For each vertex how many of the next layers, and of the last ones, cross its column: the lesser number, at most `skin`. `below` and `above` are all whole
/// layers before and after the surface.
fn covered(stack: &LayerStack, surface: &LayerSurface, [below, above]: [&[u32]; 2], skin: usize) -> Vec<f64> {
    let (mut normals, mut heights) =
        (vec![Vector3::zeros(); surface.vertices.len()], vec![0.0_f64; surface.vertices.len()]);
    for (corners, &thickness) in surface.triangles.iter().zip(surface.thickness) {
        let [a, b, c] = corners.map(|v| surface.vertices[v as usize]);
        let normal = (b - a).cross(&(c - a));
        for &v in corners {
            normals[v as usize] += normal;
            heights[v as usize] = heights[v as usize].max(thickness);
        }
    }
    let mut walk = Vec::new();
    let mut crossed = |from: Point3<f64>, way: Vector3<f64>, layers: &[u32]| {
        let before = layers.last().map_or(0, |&last| of_layer(last).end);
        let mut column = Column { from, way, layers, crossed: Vec::new() };
        stack.tree.walk(&stack.keys, before, &mut column, &mut walk);
        column.crossed.len()
    };
    let of_vertex = |v: usize| {
        let Some(normal) = normals[v].try_normalize(0.0) else { return 0.0 };
        // Without so many layers before or after it there is no need to look.
        if below.len() < skin || above.len() < skin {
            return 0.0;
        }
        let (from, way) = (surface.vertices[v], normal * (COLUMN * heights[v] * skin as f64));
        let below = crossed(from, -way, &below[below.len() - skin..]);
        let above = if below < skin { 0 } else { crossed(from, way, &above[..skin]) };
        below.min(above) as f64
    };
    let counts: Vec<f64> = (0..surface.vertices.len()).map(of_vertex).collect();
    past_rims(surface, counts)
}

/// Rims of layers that lie on each other never match, and walls are there anyway: a vertex on a rim counts as its best neighbour inside
/// does, if that is better.
pub(crate) fn past_rims(surface: &LayerSurface, counts: Vec<f64>) -> Vec<f64> {
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[u32; 2]> = surface.triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    let mut on_rim = vec![false; counts.len()];
    let single = edges.chunk_by(|a, b| a == b).filter(|run| run.len() == 1);
    single.flatten().flatten().for_each(|&v| on_rim[v as usize] = true);
    let mut best = counts.clone();
    for &[a, b] in &edges {
        for [rim, inner] in [[a, b], [b, a]] {
            if on_rim[rim as usize] && !on_rim[inner as usize] {
                best[rim as usize] = best[rim as usize].max(counts[inner as usize]);
            }
        }
    }
    best
}

/// A straight way and the layers that cross it.
struct Column<'a> {
    from: Point3<f64>,
    way: Vector3<f64>,
    /// Those that count, rising.
    layers: &'a [u32],
    crossed: Vec<u32>,
}

impl Walk for Column<'_> {
    /// Nothing if the way meets the box.
    fn bound(&self, node: &Node) -> f64 {
        if node.is_met_by(self.from, self.way) { 0.0 } else { f64::INFINITY }
    }

    fn matters(&self, bound: f64) -> bool {
        bound.is_finite()
    }

    fn see(&mut self, triangle: &Triangle) -> bool {
        let new = self.layers.binary_search(&triangle.layer).is_ok() && !self.crossed.contains(&triangle.layer);
        let place = || meets(&triangle.corners, self.from, self.way).map(|share| self.from + self.way * share);
        if new && place().is_some_and(|place| is_in_box(&triangle.corners, place)) {
            self.crossed.push(triangle.layer);
        }
        self.crossed.len() == self.layers.len()
    }
}

/// Whether a place is in the box of a triangle.
fn is_in_box([a, b, c]: &[Point3<f64>; 3], place: Point3<f64>) -> bool {
    let (low, high) = (a.inf(b).inf(c), a.sup(b).sup(c));
    (0..3).all(|k| {
        let room = ROUNDING * (1.0 + place[k].abs());
        (low[k] - room..=high[k] + room).contains(&place[k])
    })
}

/// The share of a straight way after which it meets a triangle; none if it does not.
pub(super) fn meets([a, b, c]: &[Point3<f64>; 3], from: Point3<f64>, way: Vector3<f64>) -> Option<f64> {
    let (one, other) = (b - a, c - a);
    let across = way.cross(&other);
    let volume = one.dot(&across);
    if volume.abs() < f64::MIN_POSITIVE {
        return None;
    }
    let to = from - a;
    let u = to.dot(&across) / volume;
    let side = to.cross(&one);
    let v = way.dot(&side) / volume;
    let share = other.dot(&side) / volume;
    let is_in = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE;
    Some(share).filter(|share| is_in && (0.0..=1.0).contains(share))
}

/// For each vertex how far it is inside of what is covered by fewer than `skin` layers, grown: below 0 outside.
pub(crate) fn grown(surface: &LayerSurface, counts: &[f64], skin: usize, growth: f64) -> Vec<f64> {
    let level = skin as f64 - SHORT;
    let bare = |v: u32| counts[v as usize] < level;
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[u32; 2]> = surface.triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    let length = |[a, b]: [u32; 2]| (surface.vertices[a as usize] - surface.vertices[b as usize]).norm();
    // No caller asks for more than this.
    let longest = edges.iter().map(|&edge| length(edge)).fold(growth, f64::max);
    let far = 4.0 * longest;
    let mut away = vec![far; counts.len()];
    let mut queue = BinaryHeap::new();
    let offer = |away: &mut [f64], queue: &mut BinaryHeap<(Reverse<u64>, u32)>, v: u32, distance: f64| {
        if distance < away[v as usize] {
            away[v as usize] = distance;
            queue.push((Reverse(distance.to_bits()), v)); // bits of positive numbers are in the order of the numbers
        }
    };
    let mut around: Vec<[u32; 2]> = Vec::new();
    for &edge @ [a, b] in &edges {
        if bare(a) == bare(b) {
            around.extend([[a, b], [b, a]]);
        } else {
            let share = (level - counts[a as usize]) / (counts[b as usize] - counts[a as usize]);
            offer(&mut away, &mut queue, a, share * length(edge));
            offer(&mut away, &mut queue, b, (1.0 - share) * length(edge));
        }
    }
    around.sort_unstable();
    while let Some((Reverse(bits), v)) = queue.pop() {
        let here = f64::from_bits(bits);
        if here > away[v as usize] {
            continue;
        }
        let start = around.partition_point(|&[from, _]| from < v);
        for &[_, to] in around[start..].iter().take_while(|&&[from, _]| from == v) {
            offer(&mut away, &mut queue, to, here + length([v, to]));
        }
    }
    (0..counts.len() as u32).map(|v| growth + if bare(v) { away[v as usize] } else { -away[v as usize] }).collect()
}
