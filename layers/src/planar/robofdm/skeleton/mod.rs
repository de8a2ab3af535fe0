//! The curve skeleton of a closed mesh by mean curvature flow.
//!
//! Tagliasacchi, Alhashim, Olson, Zhang, "Mean curvature skeletons", Computer Graphics Forum 31(5), 2012, sections 4 and 5:
//! the surface moves along its mean curvature, short edges collapse and triangles with large angles are split after
//! each step, and vertices where the surface has become a curve stay. What is left collapses to a graph, shortest edge first.
//!
//! Departures: a step is the implicit one of the flow itself (see `flow`), not least squares with its square; and there
//! is no attraction to the medial axis (their `w_M` is 0), so that no Voronoi diagram is needed. Long edges are split
//! before, so that a box of twelve triangles has a skeleton as well; branches shorter than the surface is thick where
//! they leave another one are bumps and are cut off.

mod complex;
mod flow;

use super::RoboFdmError;
use super::closed::ClosedMesh;
use complex::Complex;
use nalgebra::Point3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How a skeleton is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonOptions {
    /// Weight of where a vertex is against where the flow takes it, `w_H` of the paper: a step smooths over about
    /// `1 / sqrt(speed)` edges. Default 0.1, theirs.
    pub weight: f64,
    /// Edges shorter than this share of the box diagonal collapse. Default 0.005: a tube of a fiftieth of the part still has
    /// a dozen edges around.
    pub min_edge: f64,
    /// Edges longer than this share of the box diagonal are split before the flow. Default 0.03.
    pub max_edge: f64,
    /// Most steps. Default 300; the flow ends when a step changes the area by less than 1e-4 of the first.
    pub max_steps: u32,
    /// A branch with a free end is cut off if it is shorter than so many times the distance of the surface where it leaves.
    /// Default 1: it does not come out of the part that it leaves.
    pub min_branch: f64,
}

impl Default for SkeletonOptions {
    fn default() -> Self {
        Self { weight: 0.1, min_edge: 0.005, max_edge: 0.03, max_steps: 300, min_branch: 1.0 }
    }
}

/// A graph of curves in the middle of a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveSkeleton {
    /// Nodes, in mm.
    pub nodes: Vec<Point3<f64>>,
    /// Edges between nodes.
    pub edges: Vec<[u32; 2]>,
    /// Steps of the flow.
    pub steps: u32,
}

/// Change of the area in one step, over the first area, at which the flow has ended (theirs).
const MIN_CHANGE: f64 = 1e-4;

/// Cosine of the largest angle of a triangle, 110 degrees (theirs); larger ones are split.
const MAX_ANGLE: f64 = -0.342_020_143_325_668_7;

/// Most triangles that splitting of long edges may make.
const MAX_SPLITS: usize = 400_000;

/// The curve skeleton of a closed mesh.
///
/// # Returns
/// Nodes and edges in mm; a piece of the mesh that is as round as a ball may shrink to a single node without an edge.
///
/// # Errors
/// [`RoboFdmError`] for a mesh that is not closed, or an option that is not a number.
///
/// # Cost
/// Some tens of sparse solves over the vertices, which become fewer with each: about a second for 30,000 facets. One thread; the result does
/// not depend on anything else.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::robofdm::{SkeletonOptions, curve_skeleton};
/// // A rod of 4 x 4 x 40 mm.
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let skeleton = curve_skeleton(&points, &faces, &SkeletonOptions::default())?;
/// assert_eq!(skeleton.branch_count(), 1);
/// assert!(skeleton.nodes.iter().all(|p| (p.x - 2.0).abs() < 0.5 && (p.y - 2.0).abs() < 0.5));
/// # Ok::<(), curvlay_layers::planar::robofdm::RoboFdmError>(())
/// ```
pub fn curve_skeleton(
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    options: &SkeletonOptions,
) -> Result<CurveSkeleton, RoboFdmError> {
    options.check()?;
    Ok(of_mesh(&ClosedMesh::new(points, triangles)?, options))
}

impl SkeletonOptions {
    pub(super) fn check(&self) -> Result<(), RoboFdmError> {
        let named = [
            ("weight", self.weight, f64::MIN_POSITIVE, 1e6),
            ("min_edge", self.min_edge, 1e-4, 0.1),
            ("max_edge", self.max_edge, 1e-2, 1.0),
            ("min_branch", self.min_branch, 0.0, f64::MAX),
        ];
        for (name, value, low, high) in named {
            if !(low..=high).contains(&value) {
                return Err(RoboFdmError::Option { name, value });
            }
        }
        Ok(())
    }
}

pub(super) fn of_mesh(mesh: &ClosedMesh, options: &SkeletonOptions) -> CurveSkeleton {
    let diagonal = mesh.diagonal();
    let min_edge = options.min_edge * diagonal;
    let mut complex = Complex::new(mesh.points, mesh.triangles);
    split_long_edges(&mut complex, options.max_edge * diagonal);
    let surface = complex.points.clone();
    let first_area = complex.area();
    let (mut area, mut steps) = (first_area, 0);
    let mut fixed = vec![false; complex.points.len()];
    while steps < options.max_steps {
        flow::step(&mut complex, &fixed, options.weight);
        collapse_short_edges(&mut complex, &fixed, min_edge);
        split_large_angles(&mut complex, &mut fixed, min_edge);
        fix_curves(&complex, &mut fixed, min_edge);
        steps += 1;
        let next = complex.area();
        if (area - next).abs() < MIN_CHANGE * first_area {
            break;
        }
        area = next;
    }
    collapse_to_graph(&mut complex);
    let mut skeleton = CurveSkeleton { steps, ..CurveSkeleton::default() };
    let mut number = vec![u32::MAX; complex.points.len()];
    let mut is_node = vec![false; complex.points.len()];
    for edge in complex.edges() {
        edge.iter().for_each(|&v| is_node[v as usize] = true);
    }
    for (v, _) in is_node.iter().enumerate().filter(|&(_, &is_node)| is_node) {
        number[v] = skeleton.nodes.len() as u32;
        skeleton.nodes.push(complex.points[v]);
    }
    skeleton.edges = complex.edges().map(|edge| edge.map(|v| number[v as usize])).collect();
    if skeleton.nodes.is_empty() {
        // A ball: all of it has collapsed to one vertex.
        let sum = mesh.points.iter().fold(nalgebra::Vector3::zeros(), |sum, p| sum + p.coords);
        skeleton.nodes.push((sum / mesh.points.len() as f64).into());
    }
    skeleton.prune(&surface, options.min_branch);
    skeleton
}

/// Longest edge of a triangle first, until none is longer than allowed.
fn split_long_edges(complex: &mut Complex, longest: f64) {
    // Lengths are positive, so their bits are in the order of the lengths.
    let key = |complex: &Complex, [a, b]: [u32; 2]| (complex.length(a, b).to_bits(), Reverse([a, b]));
    let mut queue: BinaryHeap<_> = complex.edges().map(|edge| key(complex, edge)).collect();
    for _ in 0..MAX_SPLITS {
        let Some((length, Reverse([a, b]))) = queue.pop() else { break };
        if f64::from_bits(length) <= longest {
            break;
        }
        let new = complex.split(a, b, nalgebra::center(&complex.points[a as usize], &complex.points[b as usize]));
        let around = complex.neighbours(new).to_vec();
        queue.extend(around.into_iter().map(|v| key(complex, [v, new])));
    }
}

/// Collapses edges of the surface that are shorter than `min_edge` and have no fixed end, to their middle.
fn collapse_short_edges(complex: &mut Complex, fixed: &[bool], min_edge: f64) {
    // One pass may make others short; a few are enough, the rest has the next step.
    for _ in 0..10 {
        let is_short =
            |&[a, b]: &[u32; 2]| !(fixed[a as usize] && fixed[b as usize]) && complex.length(a, b) < min_edge;
        let mut short: Vec<_> = complex.edges().filter(is_short).collect();
        short.sort_by(|e, f| complex.length(e[0], e[1]).total_cmp(&complex.length(f[0], f[1])));
        let mut collapsed = false;
        for [a, b] in short {
            if complex.is_edge(a, b) && complex.length(a, b) < min_edge && complex.is_collapsible_on_surface(a, b) {
                // The fixed end stays, and stays where it is.
                let (a, b) = if fixed[b as usize] { (b, a) } else { (a, b) };
                let [pa, pb] = [a, b].map(|v| complex.points[v as usize]);
                let to = if fixed[a as usize] { pa } else { nalgebra::center(&pa, &pb) };
                complex.collapse(a, b, to);
                collapsed = true;
            }
        }
        if !collapsed {
            break;
        }
    }
}

/// Splits the longest edge of triangles with a large angle where the height of that angle stands on it.
fn split_large_angles(complex: &mut Complex, fixed: &mut Vec<bool>, min_edge: f64) {
    let large: Vec<[u32; 3]> = complex
        .triangles()
        .flat_map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
        .filter(|&[apex, a, b]| {
            let [p, a, b] = [apex, a, b].map(|v| complex.points[v as usize]);
            let (u, v) = (a - p, b - p);
            u.dot(&v) < MAX_ANGLE * u.norm() * v.norm()
        })
        .collect();
    for [apex, a, b] in large {
        // Another split may have taken it.
        if !complex.is_edge(a, b) || !complex.opposite(a, b).contains(&apex) {
            continue;
        }
        let [p, pa, pb] = [apex, a, b].map(|v| complex.points[v as usize]);
        let along = pb - pa;
        if along.norm() < 2.0 * min_edge {
            continue;
        }
        let t = ((p - pa).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        complex.split(a, b, pa + along * t);
        fixed.push(false);
    }
}

/// Fixes the vertices at which two or more short edges can no longer collapse: the surface has become a curve there.
fn fix_curves(complex: &Complex, fixed: &mut [bool], min_edge: f64) {
    for (v, fixed) in (0..).zip(fixed) {
        let stuck = |&&to: &&u32| complex.length(v, to) < min_edge && !complex.is_collapsible_on_surface(v, to);
        *fixed = *fixed || complex.neighbours(v).iter().filter(stuck).count() >= 2;
    }
}

/// Collapses edges of triangles, shortest first, until no triangle is left.
///
/// No link condition here: the circumference of a tube is a loop like that of a handle. But it is short, so that it has
/// collapsed, and left an axis without triangles, long before a loop of the skeleton could.
fn collapse_to_graph(complex: &mut Complex) {
    let key = |complex: &Complex, a: u32, b: u32| Reverse((complex.length(a, b).to_bits(), a.min(b), a.max(b)));
    let mut queue: BinaryHeap<_> = complex.edges().map(|[a, b]| key(complex, a, b)).collect();
    while let Some(Reverse((length, a, b))) = queue.pop() {
        let is_now = complex.is_edge(a, b) && complex.length(a, b).to_bits() == length;
        if is_now && !complex.opposite(a, b).is_empty() {
            let to = nalgebra::center(&complex.points[a as usize], &complex.points[b as usize]);
            complex.collapse(a, b, to);
            queue.extend(complex.neighbours(a).iter().map(|&v| key(complex, a, v)));
        }
    }
}

impl CurveSkeleton {
    /// The edges at each node.
    fn degrees(&self) -> Vec<u32> {
        let mut degrees = vec![0; self.nodes.len()];
        self.edges.iter().flatten().for_each(|&v| degrees[v as usize] += 1);
        degrees
    }

    /// Curves between nodes of other degree than two; a closed ring counts as one. The `k` of the paper.
    ///
    /// # Panics
    /// If an edge has a node that is not there.
    pub fn branch_count(&self) -> usize {
        self.branches().len()
    }

    /// The curves between nodes of other degree than two, node by node, then rings.
    ///
    /// # Panics
    /// If an edge has a node that is not there.
    pub fn branches(&self) -> Vec<Vec<u32>> {
        let mut at = vec![Vec::new(); self.nodes.len()];
        for (e, edge) in self.edges.iter().enumerate() {
            edge.iter().for_each(|&v| at[v as usize].push(e));
        }
        let mut used = vec![false; self.edges.len()];
        let mut branches = Vec::new();
        let ends = (0..at.len()).filter(|&v| at[v].len() != 2);
        for start in ends.chain((0..at.len()).filter(|&v| at[v].len() == 2)) {
            for i in 0..at[start].len() {
                let (mut branch, mut edge) = (vec![start as u32], at[start][i]);
                while !used[edge] {
                    used[edge] = true;
                    let from = branch[branch.len() - 1];
                    let [a, b] = self.edges[edge];
                    let to = if a == from { b } else { a };
                    branch.push(to);
                    match at[to as usize][..] {
                        [e, f] if to as usize != start => edge = if e == edge { f } else { e },
                        _ => break,
                    }
                }
                if branch.len() > 1 {
                    branches.push(branch);
                }
            }
        }
        branches
    }

    /// The nodes of each branch as places; of a skeleton without edges its node.
    pub(super) fn branch_pieces(&self) -> Vec<Vec<Point3<f64>>> {
        let branches = self.branches();
        let places = |branch: &Vec<u32>| branch.iter().map(|&v| self.nodes[v as usize]).collect();
        if branches.is_empty() {
            self.nodes.iter().map(|&p| vec![p]).collect()
        } else {
            branches.iter().map(places).collect()
        }
    }

    /// How far a point is from the nearest point of the skeleton, in mm.
    ///
    /// # Panics
    /// If an edge has a node that is not there.
    pub fn distance(&self, p: Point3<f64>) -> f64 {
        self.branch_pieces().iter().map(|branch| distance(branch, p)).fold(f64::INFINITY, f64::min)
    }

    /// Cuts off the shortest branch that ends freely, as long as one is too short.
    fn prune(&mut self, surface: &[Point3<f64>], min_branch: f64) {
        loop {
            let degrees = self.degrees();
            let radius = |v: u32| {
                let p = self.nodes[v as usize];
                surface.iter().map(|q| (q - p).norm_squared()).fold(f64::INFINITY, f64::min).sqrt()
            };
            let length = |branch: &[u32]| -> f64 {
                branch.windows(2).map(|e| (self.nodes[e[0] as usize] - self.nodes[e[1] as usize]).norm()).sum()
            };
            let too_short = |branch: Vec<u32>| {
                let [first, last] = [branch[0], branch[branch.len() - 1]];
                let inner = match [degrees[first as usize], degrees[last as usize]] {
                    [1, n] if n > 2 => last,
                    [n, 1] if n > 2 => first,
                    _ => return None,
                };
                let length = length(&branch);
                (length < min_branch * radius(inner)).then_some((length, inner, branch))
            };
            let shortest = self.branches().into_iter().filter_map(too_short).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, inner, branch)) = shortest else { break };
            let gone = |v: u32| v != inner && branch.contains(&v);
            let mut number = vec![u32::MAX; self.nodes.len()];
            let mut nodes = Vec::new();
            for (v, &p) in (0..).zip(&self.nodes) {
                if !gone(v) {
                    number[v as usize] = nodes.len() as u32;
                    nodes.push(p);
                }
            }
            self.edges.retain(|edge| !edge.iter().any(|&v| gone(v)));
            self.edges.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
            self.nodes = nodes;
        }
    }
}

/// How far a point is from a polyline of one node or more.
pub(super) fn distance(nodes: &[Point3<f64>], p: Point3<f64>) -> f64 {
    let to_edge = |edge: &[Point3<f64>]| {
        let (a, along) = (edge[0], edge[1] - edge[0]);
        let t = ((p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + along * t - p).norm_squared()
    };
    let from = nodes.first().map_or(f64::INFINITY, |q| (q - p).norm_squared());
    nodes.windows(2).map(to_edge).fold(from, f64::min).sqrt()
}
