//! Phase I: the facets of a mesh in parts, by how thick it is and by which branch of the skeleton is near.
//!
//! Dissertation, section 2.4.1, and L. Shapira, A. Shamir, D. Cohen-Or, "Consistent mesh partitioning and skeletonisation using the
//! shape diameter function", The Visual Computer 24, 2008 (its [32]), section 4. `D(p)` is `thickness` here, `k` is
//! [`SegmentOptions::clusters`].
//!
//! Departures. The mixture is fitted to the logarithm of `D`, so that it does not depend on the unit. Without a number of
//! clusters the information criterion chooses it, not the number of branches: three equal arms are of one thickness. So
//! that they are three parts all the same ("each branch a part", section 2.3.2), a label is a cluster and a branch.
//! Costs are per area and per length of the border, so that a finer mesh has the same parts.

use super::border::{Border, borders};
use super::closed::ClosedMesh;
use super::cut::Labelling;
use super::error::RoboFdmError;
use super::mixture::GaussianMixture;
use super::skeleton::{self, CurveSkeleton, SkeletonOptions};
use nalgebra::Point3;

/// How a mesh is segmented.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentOptions {
    /// How the skeleton is made.
    pub skeleton: SkeletonOptions,
    /// Iterations of Laplacian smoothing before skeleton and thickness. Default 1, the paper's.
    pub smoothing: u32,
    /// Clusters of thickness. Default `None`: chosen by the Bayesian information criterion, at most [`MAX_CLUSTERS`].
    pub clusters: Option<usize>,
    /// Cost of a flat border as long as the square root of the surface's area, over the cost of a label on all of it. Default
    /// 0.02; a tenth of it leaves borders that follow the noise of the thickness, ten times it merges ears with heads.
    pub border_cost: f64,
    /// Parts whose surface is less than this share of all join a neighbour. Default 0.02.
    pub min_part: f64,
    /// How far samples inside and outside of a border lie from it, as a share of the box diagonal. Default 0.002.
    pub border_offset: f64,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        Self {
            skeleton: SkeletonOptions::default(),
            smoothing: 1,
            clusters: None,
            border_cost: 0.02,
            min_part: 0.02,
            border_offset: 0.002,
        }
    }
}

/// Most clusters that are tried when none is given: more levels of thickness than a part is likely to have.
pub const MAX_CLUSTERS: usize = 5;

/// The facets of a mesh in connected parts, and the borders between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// The skeleton of the smoothed mesh.
    pub skeleton: CurveSkeleton,
    /// Distance of the middle of each facet of the smoothed mesh from the skeleton, in mm.
    pub thickness: Vec<f64>,
    /// The mixture of the logarithms of the thickness.
    pub mixture: GaussianMixture,
    /// The part of each facet.
    pub part_of: Vec<u32>,
    /// How many parts there are.
    pub parts: usize,
    /// The closed curves between parts with their planes; two parts may have several.
    pub borders: Vec<Border>,
}

/// Costs are rounded to whole numbers of this share of the largest possible sum.
const UNIT: f64 = 1e-9;

/// Largest cost of a label on a facet, in natural logarithms: one wrong in ten thousand.
const MAX_COST: f64 = 9.2;

/// Smallest angle between facets over pi that tells: below it they are flat.
const FLAT: f64 = 0.01;

/// What the angle of a convex edge counts, so that borders lie in grooves (Shapira et al. leave the figure open; CGAL takes this).
const CONVEX: f64 = 0.08;

/// Segments a closed mesh.
///
/// # Returns
/// Connected parts, at least one; their numbers rise with the first facet of each.
///
/// # Errors
/// [`RoboFdmError`] for a mesh that is not closed and oriented, no cluster or more than facets, or an option out of range.
///
/// # Cost
/// The skeleton, then some dozens of minimum cuts on the dual graph: about two seconds for 30,000 facets. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point3;
/// use curvlay_layers::planar::robofdm::{SegmentOptions, segment};
/// // A rod of 4 x 4 x 40 mm is one part.
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 40.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// // Its twelve facets are too few to tell clusters of thickness apart.
/// let options = SegmentOptions { clusters: Some(1), ..SegmentOptions::default() };
/// let segmentation = segment(&points, &faces, &options)?;
/// assert_eq!((segmentation.parts, segmentation.borders.len()), (1, 0));
/// # Ok::<(), curvlay_layers::planar::robofdm::RoboFdmError>(())
/// ```
pub fn segment(
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    options: &SegmentOptions,
) -> Result<Segmentation, RoboFdmError> {
    options.check(triangles.len())?;
    let mesh = ClosedMesh::new(points, triangles)?;
    let mut smooth = points.to_vec();
    for _ in 0..options.smoothing {
        smooth = ClosedMesh { points: &smooth, triangles, beyond: Vec::new() }.smoothed();
    }
    let smooth = ClosedMesh { points: &smooth, triangles, beyond: Vec::new() };
    let skeleton = skeleton::of_mesh(&smooth, &options.skeleton);

    let branches = skeleton.branch_pieces();
    let middle = |f: usize| smooth.corners(f).iter().fold(Point3::origin(), |sum, p| sum + p.coords / 3.0);
    // Of each facet the distance from each branch, at least a grain of dust.
    let dust = 1e-6 * mesh.diagonal();
    let distances: Vec<Vec<f64>> = (0..triangles.len())
        .map(|f| branches.iter().map(|branch| skeleton::distance(branch, middle(f)).max(dust)).collect())
        .collect();
    let thickness: Vec<f64> = distances.iter().map(|d| d.iter().copied().fold(f64::INFINITY, f64::min)).collect();
    let areas: Vec<f64> = (0..triangles.len()).map(|f| mesh.area_vector(f).norm()).collect();
    let area: f64 = areas.iter().sum();
    if area <= 0.0 {
        return Err(RoboFdmError::Empty);
    }
    let (logs, weights) = histogram(&thickness, &areas);
    let mixture = match options.clusters {
        Some(count) => GaussianMixture::fit(&logs, &weights, count)?,
        None => {
            // Patches as wide as the part is thick have a thickness of their own; within one all facets have the same.
            let squares: f64 = thickness.iter().zip(&areas).map(|(d, a)| d * d * a).sum::<f64>() / area;
            GaussianMixture::fit_best(&logs, &weights, MAX_CLUSTERS.min(logs.len()), area / squares)?
        }
    };
    let labelling = labelling(&mesh, &mixture, &distances, &areas, options);
    let (labels, _) = labelling.expand();
    let mut part_of = connected(&mesh, &labels);
    join_small(&mesh, &mut part_of, &areas, options.min_part * area);
    let part_of = connected(&mesh, &part_of);
    let parts = part_of.iter().max().map_or(0, |&last| last as usize + 1);
    let borders = borders(&mesh, &part_of, options.border_offset * mesh.diagonal());
    Ok(Segmentation { skeleton, thickness, mixture, part_of, parts, borders })
}

impl SegmentOptions {
    fn check(&self, facets: usize) -> Result<(), RoboFdmError> {
        self.skeleton.check()?;
        if let Some(count) = self.clusters
            && !(1..=facets.max(1)).contains(&count)
        {
            return Err(RoboFdmError::Option { name: "clusters", value: count as f64 });
        }
        let named = [
            ("border_cost", self.border_cost, 0.0, 1e3),
            ("min_part", self.min_part, 0.0, 1.0),
            ("border_offset", self.border_offset, 0.0, 0.1),
            ("smoothing", f64::from(self.smoothing), 0.0, 100.0),
        ];
        for (name, value, low, high) in named {
            if !(low..=high).contains(&value) {
                return Err(RoboFdmError::Option { name, value });
            }
        }
        Ok(())
    }
}

/// Classes of the histogram of thickness: a few per cent of a part's range each.
const CLASSES: usize = 512;

/// The mean logarithm of thickness in each class that is not empty, and its area.
fn histogram(thickness: &[f64], areas: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let logs = || thickness.iter().map(|d| d.ln());
    let (low, high) = (logs().fold(f64::INFINITY, f64::min), logs().fold(f64::NEG_INFINITY, f64::max));
    let mut classes = vec![[0.0; 2]; CLASSES];
    for (log, area) in logs().zip(areas) {
        // Without a range all are in the first class: the quotient is not a number, which becomes 0.
        let class = ((log - low) / (high - low) * CLASSES as f64) as usize;
        let class = &mut classes[class.min(CLASSES - 1)];
        *class = [class[0] + area, class[1] + area * log];
    }
    classes.into_iter().filter(|&[area, _]| area > 0.0).map(|[area, sum]| (sum / area, area)).unzip()
}

/// The costs of all labels, each a cluster and a branch.
fn labelling(
    mesh: &ClosedMesh,
    mixture: &GaussianMixture,
    distances: &[Vec<f64>],
    areas: &[f64],
    options: &SegmentOptions,
) -> Labelling {
    let area: f64 = areas.iter().sum();
    let (clusters, branches) = (mixture.means.len(), distances[0].len());
    // Cost of cluster and branch, in natural logarithms.
    let mut costs = Vec::with_capacity(distances.len() * clusters * branches);
    let mut wins = vec![0.0; clusters * branches];
    let mut logs = vec![0.0; clusters];
    for (near, &a) in distances.iter().zip(areas) {
        let nearest = near.iter().copied().fold(f64::INFINITY, f64::min);
        mixture.log_joint(nearest.ln(), &mut logs);
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let first = costs.len();
        for log in &logs {
            costs.extend(near.iter().map(|d| ((largest - log) + (d / nearest - 1.0)).min(MAX_COST)));
        }
        let own = &costs[first..];
        let best = (0..own.len()).fold(0, |best, i| if own[i] < own[best] { i } else { best });
        wins[best] += a;
    }
    // Labels that are the best one almost nowhere would only take time.
    let most = (0..wins.len()).fold(0, |best, i| if wins[i] > wins[best] { i } else { best });
    let kept: Vec<usize> = (0..wins.len()).filter(|&i| i == most || wins[i] >= options.min_part * area).collect();
    let whole = |cost: f64| (cost / UNIT).round() as u64;
    let node_costs = costs
        .chunks_exact(clusters * branches)
        .zip(areas)
        .flat_map(|(costs, a)| kept.iter().map(move |&i| whole(costs[i] * a / area)))
        .collect();
    let mut edges = Vec::new();
    for (f, beyond) in mesh.beyond.iter().enumerate() {
        for (k, &g) in beyond.iter().enumerate() {
            let g = g as usize;
            if f < g {
                let cost = options.border_cost * groove_cost(mesh, f, g, k);
                let [a, b] = [k, (k + 1) % 3].map(|k| mesh.points[mesh.triangles[f][k] as usize]);
                edges.push((f as u32, g as u32, whole(cost * (b - a).norm() / area.sqrt())));
            }
        }
    }
    Labelling { labels: kept.len(), node_costs, edges }
}

/// Cost of a border over an edge: one where it is flat, less in a groove.
fn groove_cost(mesh: &ClosedMesh, f: usize, g: usize, k: usize) -> f64 {
    let [m, n] = [f, g].map(|f| mesh.area_vector(f));
    let angle = m.cross(&n).norm().atan2(m.dot(&n));
    let start = mesh.points[mesh.triangles[f][k] as usize];
    let is_convex = mesh.corners(g).iter().all(|p| (p - start).dot(&m) <= 0.0);
    let counted = if is_convex { CONVEX * angle } else { angle } / std::f64::consts::PI;
    counted.max(FLAT).ln() / FLAT.ln()
}

/// Connected facets of equal labels get one number, by rising first facet.
fn connected(mesh: &ClosedMesh, labels: &[u32]) -> Vec<u32> {
    let mut number = vec![u32::MAX; labels.len()];
    let mut count = 0;
    for first in 0..labels.len() {
        if number[first] != u32::MAX {
            continue;
        }
        number[first] = count;
        let mut stack = vec![first];
        while let Some(f) = stack.pop() {
            for g in mesh.beyond[f].map(|g| g as usize) {
                if number[g] == u32::MAX && labels[g] == labels[f] {
                    number[g] = count;
                    stack.push(g);
                }
            }
        }
        count += 1;
    }
    number
}

/// The smallest part joins the neighbour with which it has the longest border, until none is too small.
fn join_small(mesh: &ClosedMesh, part_of: &mut [u32], areas: &[f64], least: f64) {
    let count = part_of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0.0; count];
    part_of.iter().zip(areas).for_each(|(&part, a)| sizes[part as usize] += a);
    loop {
        let mut small: Vec<usize> = (0..count).filter(|&p| sizes[p] > 0.0 && sizes[p] < least).collect();
        small.sort_by(|&p, &q| sizes[p].total_cmp(&sizes[q]));
        let mut joined = false;
        for part in small {
            let mut shared = vec![0.0; count];
            for (f, beyond) in mesh.beyond.iter().enumerate().filter(|&(f, _)| part_of[f] as usize == part) {
                for (k, &g) in beyond.iter().enumerate() {
                    let other = part_of[g as usize] as usize;
                    if other != part {
                        let [a, b] = [k, (k + 1) % 3].map(|k| mesh.points[mesh.triangles[f][k] as usize]);
                        shared[other] += (b - a).norm();
                    }
                }
            }
            let longest = (0..count).fold(part, |best, p| if shared[p] > shared[best] { p } else { best });
            if longest != part {
                part_of.iter_mut().filter(|p| **p as usize == part).for_each(|p| *p = longest as u32);
                sizes[longest] += std::mem::take(&mut sizes[part]);
                joined = true;
                break;
            }
        }
        if !joined {
            break;
        }
    }
}
