//! Layers in patches: triangles, halved across their longest edges until they are small.

use super::boxes::{Boxed, Boxes, Look};
use super::sheet::Sheet;
use curvlay_examples::args::Failure;
use curvlay_examples::laid::{Nozzle, NozzlePose};
use nalgebra::{Point3, Vector3};

/// A patch takes as much memory as so many cells.
const CELLS: u64 = 10;

/// A patch of a layer.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Its corners.
    pub corners: [Point3<f64>; 3],
    /// Into the nozzle.
    pub normal: Vector3<f64>,
    /// Its area.
    pub area: f64,
    /// The layer, from 0.
    pub rank: u32,
    /// Its number in the file.
    pub number: u32,
    /// Whether it is support of the part.
    pub is_support: bool,
    /// How far the layer goes below and above the surface.
    pub slab: [f64; 2],
}

impl Patch {
    /// Its middle.
    pub fn middle(&self) -> Point3<f64> {
        let [a, b, c] = self.corners;
        Point3::from((a.coords + b.coords + c.coords) / 3.0)
    }

    /// How thick the layer is.
    pub fn thickness(&self) -> f64 {
        self.slab[0] + self.slab[1]
    }

    /// The middle of the layer.
    pub fn core(&self) -> Point3<f64> {
        self.middle() + self.normal * (0.5 * (self.slab[1] - self.slab[0]))
    }

    /// The nozzle that lays it.
    pub fn pose(&self) -> NozzlePose {
        NozzlePose { tip: self.middle() + self.normal * self.slab[1], axis: self.normal }
    }
}

/// Cuts sheets into patches whose edges are no longer than `edge`, in the order of the build.
///
/// # Errors
/// A line for more patches than `max_cells` allows.
pub fn cut(sheets: &[Sheet], edge: f64, max_cells: u64) -> Result<Vec<Patch>, Failure> {
    let most = (max_cells / CELLS) as usize;
    let mut patches = Vec::new();
    let mut open = Vec::new();
    for sheet in sheets {
        for triangle in &sheet.triangles {
            open.push((sheet.corners(triangle), triangle.map(|corner| sheet.normals[corner as usize])));
            while let Some((corners, normals)) = open.pop() {
                let lengths = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).norm());
                let k = (0..3).fold(0, |best, k| if lengths[k] > lengths[best] { k } else { best });
                if lengths[k] > edge {
                    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3];
                    let (middle, normal) =
                        (nalgebra::center(&corners[a], &corners[b]), 0.5 * (normals[a] + normals[b]));
                    open.push(([middle, corners[b], corners[c]], [normal, normals[b], normals[c]]));
                    open.push(([corners[a], middle, corners[c]], [normals[a], normal, normals[c]]));
                    if open.len() + patches.len() > most {
                        return Err(too_many(edge, most, max_cells));
                    }
                    continue;
                }
                patches.extend(patch(sheet, corners, normals));
            }
        }
        if patches.len() > most {
            return Err(too_many(edge, most, max_cells));
        }
    }
    Ok(patches)
}

fn too_many(edge: f64, most: usize, max_cells: u64) -> Failure {
    Failure::of_arguments(format!(
        "the layers have more than {most} patches of {edge:.3} mm, {CELLS} of --max-cells {max_cells} each: give a larger --patch"
    ))
}

/// None without an area.
fn patch(sheet: &Sheet, corners: [Point3<f64>; 3], normals: [Vector3<f64>; 3]) -> Option<Patch> {
    let [a, b, c] = corners;
    let across = 0.5 * (b - a).cross(&(c - a));
    let area = across.norm();
    let own = across.try_normalize(0.0)?;
    // Around a crease vertices may look past the side of a triangle.
    let smooth = normals.iter().sum::<Vector3<f64>>().try_normalize(1e-6).filter(|normal| normal.dot(&own) > 0.0);
    let (rank, number, is_support) = (sheet.rank, sheet.number, sheet.is_support);
    Some(Patch { corners, normal: smooth.unwrap_or(own), area, rank, number, is_support, slab: [0.0; 2] })
}

/// What is laid, as balls as thick as the layer, one in the middle of each patch.
pub struct Balls<'a> {
    patches: &'a [Patch],
    boxes: Boxes,
}

impl<'a> Balls<'a> {
    /// Those of patches.
    pub fn new(patches: &'a [Patch]) -> Self {
        let thing = |patch: &Patch| {
            let (core, half) = (patch.core(), Vector3::repeat(0.5 * patch.thickness()));
            Boxed::around(&[core - half, core + half], patch.rank)
        };
        Balls { patches, boxes: Boxes::new(patches.iter().map(thing).collect()) }
    }

    /// How deep a nozzle is in layers before one; none where it is not deeper than allowed.
    pub fn depth(&self, nozzle: &Nozzle, pose: NozzlePose, rank: u32, allowed: f64) -> Option<f64> {
        let mut deepest = Deepest { balls: self, nozzle, pose, rank, gap: -allowed };
        self.boxes.look(&mut deepest);
        (deepest.gap < -allowed).then_some(-deepest.gap)
    }
}

struct Deepest<'a> {
    balls: &'a Balls<'a>,
    nozzle: &'a Nozzle,
    pose: NozzlePose,
    rank: u32,
    gap: f64,
}

impl Look for Deepest<'_> {
    /// Distances change by no more than the place does, and all of the nozzle is above the plane of its tip.
    fn bound(&self, of: &Boxed) -> f64 {
        if !of.has(&(0..self.rank)) {
            return f64::INFINITY;
        }
        let (middle, half) = (of.middle(), of.half());
        let highest = (middle - self.pose.tip).dot(&self.pose.axis) + half.dot(&self.pose.axis.abs());
        (-highest).max(self.nozzle.distance(&self.pose, &middle) - half.norm())
    }

    fn limit(&self) -> f64 {
        self.gap
    }

    fn see(&mut self, thing: usize) {
        let patch = &self.balls.patches[thing];
        let gap = self.nozzle.distance(&self.pose, &patch.core()) - 0.5 * patch.thickness();
        self.gap = self.gap.min(gap);
    }
}
