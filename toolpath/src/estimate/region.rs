//! Beads on the surface of a layer, and the regions that curves fill.
//!
//! Both are sums over the triangles of the refined mesh, on which distances are linear; a triangle that walls, skin and infill share is taken
//! in nine parts.

use super::random::Random;
use crate::contour::{BeadsAt, ExpectedBeads, check};
use crate::deposit::DepositionOptions;
use crate::geodesic::SurfaceDistance;
use crate::infill::{FillError, MIN_BEAD_REACH, MIN_REACH, Solid, thickness};
use crate::layer::LayerSurface;
use crate::level_set::LevelField;
use crate::mesh::{SurfaceMesh, on_mesh_triangle};
use crate::path::{PathOptions, Pattern};
use crate::union_find::{join, root};
use nalgebra::Point3;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// How far the field may be off the distance, in beads. Curves need an eightieth; for lengths and areas a tenth is off by less than the
/// samples are.
const TOLERANCE: f64 = 0.1;

/// What a place is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    /// Contours, or solid.
    Wall,
    Skin,
    Sparse,
}

/// Beads of a layer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beads {
    pub area_mm2: f64,
    pub length_mm: f64,
    pub infill_mm: f64,
    pub volume_mm3: f64,
    pub too_narrow_mm2: f64,
    pub too_narrow_mm3: f64,
    pub sparse_mm3: f64,
    pub seconds: f64,
}

/// A connected region that curves fill.
#[derive(Clone, Debug)]
pub(super) struct Region {
    /// How many: one but for rings that are not connected.
    pub curves: f64,
    /// Triangles, and the area of each with all before it.
    triangles: Vec<([Point3<f64>; 3], f64)>,
}

impl Region {
    /// A place in it, drawn by area.
    pub fn place(&self, random: &mut Random) -> Point3<f64> {
        let Some(&(_, area)) = self.triangles.last() else { return Point3::origin() };
        let [share, mut u, mut v] = [(); 3].map(|()| random.share());
        let at = self.triangles.partition_point(|&(_, sum)| sum <= share * area).min(self.triangles.len() - 1);
        let ([a, b, c], _) = self.triangles[at];
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        a + (b - a) * u + (c - a) * v
    }
}

/// A layer.
pub(super) struct Sheet {
    pub beads: Beads,
    pub regions: Vec<Region>,
}

/// The beads of a surface, and its regions. `solid`: where there are skins.
pub(super) fn sheet(
    surface: &LayerSurface,
    solid: Option<&Solid>,
    options: &PathOptions,
    deposition: &DepositionOptions,
) -> Result<Sheet, FillError> {
    check(options)?;
    let silent = |_| ControlFlow::Continue(());
    let mesh = SurfaceMesh::new(surface.vertices.to_vec(), surface.triangles.to_vec())?;
    let distance = SurfaceDistance::to_boundary(&mesh, &silent)?;
    let field = LevelField::new(&distance, TOLERANCE * options.bead, &silent)?;
    let is_solid = options.infill.is_solid();
    let found = field.expected_beads(options, (!is_solid).then_some(options.infill.walls))?;
    let places = if is_solid { Vec::new() } else { places(&field, &found, surface, solid, options) };
    let classes = Classes { places, ..Classes::default() }.judged(&field, options);
    let mut layer = Layer { options, deposition, beads: Beads::default(), triangles: Vec::new() };
    for (triangle, at) in (0..).zip(&found.of_triangle) {
        let corners = field.triangles[triangle].map(|v| field.points[v as usize]);
        let thickness = thickness(surface, field.parents()[triangle]);
        let shares = classes.shares(field.triangles[triangle], triangle);
        layer.add(corners, thickness, *at, shares, options.bead);
    }
    let regions = regions(&field, &layer.triangles, options);
    Ok(Sheet { beads: layer.beads, regions })
}

/// For each vertex of the field how far it is inward of walls, and how far inside of a skin.
fn places(
    field: &LevelField,
    found: &ExpectedBeads,
    surface: &LayerSurface,
    solid: Option<&Solid>,
    options: &PathOptions,
) -> Vec<[f64; 2]> {
    let mesh = field.distance().mesh();
    let outside = vec![-mesh.diagonal(); mesh.vertices().len()];
    let skin = solid.map_or(outside, |solid| solid.site(surface, 0, options).skin);
    let mut places: Vec<[f64; 2]> = found.inside.iter().map(|&inside| [inside, 0.0]).collect();
    for (corners, &parent) in field.triangles.iter().zip(field.parents()) {
        let at = mesh.triangles()[parent as usize].map(|v| skin[v as usize]);
        for &v in corners {
            let (_, weights) = on_mesh_triangle(mesh, parent, field.points[v as usize]);
            places[v as usize][1] = at[0] * weights[0] + at[1] * weights[1] + at[2] * weights[2];
        }
    }
    places
}

/// What places are for.
#[derive(Default)]
struct Classes {
    /// By vertex; none where all is solid.
    places: Vec<[f64; 2]>,
    /// What sparse places of each triangle are taken for.
    sparse: Vec<Class>,
}

impl Classes {
    /// Takes sparse regions that are too narrow for infill as solid, or as walls that reach a little farther.
    fn judged(self, field: &LevelField, options: &PathOptions) -> Classes {
        let reach_at = |v: u32| self.places.get(v as usize).map_or(0.0, |[inside, skin]| inside.min(-skin));
        let is_sparse: Vec<bool> =
            field.triangles.iter().map(|corners| corners.iter().any(|&v| reach_at(v) > 0.0)).collect();
        let mut parents: Vec<u32> = (0..field.points.len() as u32).collect();
        let sparse = || field.triangles.iter().zip(&is_sparse).filter(|(_, is_sparse)| **is_sparse);
        for ([a, b, c], _) in sparse() {
            join(&mut parents, *a, *b);
            join(&mut parents, *b, *c);
        }
        let mut reach: BTreeMap<u32, f64> = BTreeMap::new();
        for (corners, _) in sparse() {
            let farthest = corners.iter().map(|&v| reach_at(v)).fold(0.0, f64::max);
            let most = reach.entry(root(&mut parents, corners[0])).or_default();
            *most = most.max(farthest);
        }
        let solid = if options.infill.density > 0.0 { MIN_REACH } else { 0.0 };
        let mut taken = |corners: &[u32; 3]| match reach.get(&root(&mut parents, corners[0])).copied().unwrap_or(0.0) {
            reach if reach <= MIN_BEAD_REACH * options.bead => Class::Wall,
            reach if reach <= solid * options.bead => Class::Skin,
            _ => Class::Sparse,
        };
        let sparse = field.triangles.iter().map(&mut taken).collect();
        Classes { sparse, ..self }
    }

    /// Shares of a triangle that are wall, skin and sparse.
    fn shares(&self, corners: [u32; 3], triangle: usize) -> [f64; 3] {
        let mut shares = [0.0; 3];
        if self.places.is_empty() {
            return [1.0, 0.0, 0.0];
        }
        let at = corners.map(|v| self.places[v as usize]);
        for weights in NINTHS {
            let [inside, skin] = [0, 1].map(|k| (0..3).map(|c| weights[c] * at[c][k]).sum::<f64>());
            let class = match (inside > 0.0, skin > 0.0) {
                (false, _) => Class::Wall,
                (true, true) => Class::Skin,
                (true, false) => self.sparse[triangle],
            };
            shares[class as usize] += 1.0 / 9.0;
        }
        shares
    }
}

/// Middles of the nine equal parts of a triangle whose sides are cut in three.
const NINTHS: [[f64; 3]; 9] = {
    const fn at(a: u8, b: u8, c: u8) -> [f64; 3] {
        [a as f64 / 9.0, b as f64 / 9.0, c as f64 / 9.0]
    }
    [
        at(7, 1, 1),
        at(1, 7, 1),
        at(1, 1, 7),
        at(5, 2, 2),
        at(2, 5, 2),
        at(2, 2, 5),
        at(4, 4, 1),
        at(4, 1, 4),
        at(1, 4, 4),
    ]
};

/// The sums of a layer.
struct Layer<'a> {
    options: &'a PathOptions,
    deposition: &'a DepositionOptions,
    beads: Beads,
    /// For each triangle its corners and the area of each class that gets beads.
    triangles: Vec<([Point3<f64>; 3], [f64; 3])>,
}

impl Layer<'_> {
    fn add(&mut self, corners: [Point3<f64>; 3], thickness: f64, at: BeadsAt, shares: [f64; 3], bead: f64) {
        let [a, b, c] = corners;
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        let infill = &self.options.infill;
        // Skins are surfaces of their own, whose beads are near to what was asked for; rows are that wide, by the density apart.
        let solid = BeadsAt { per_mm: 1.0 / bead, width: bead };
        let sparse = BeadsAt { per_mm: infill.density / bead, width: bead };
        self.beads.area_mm2 += area;
        self.beads.sparse_mm3 += shares[2] * area * thickness;
        let mut filled = [0.0; 3];
        for (class, (share, at)) in shares.into_iter().zip([at, solid, sparse]).enumerate() {
            let length = share * area * at.per_mm;
            if class == 0 && at.per_mm <= 0.0 {
                self.beads.too_narrow_mm2 += share * area;
                self.beads.too_narrow_mm3 += share * area * thickness;
            }
            if length > 0.0 {
                filled[class] = share * area;
                self.beads.length_mm += length;
                self.beads.infill_mm += if class == 2 { length } else { 0.0 };
                self.beads.volume_mm3 += length * at.width * thickness;
                self.beads.seconds += self.deposition.seconds_of(length, length * at.width * thickness);
            }
        }
        self.triangles.push((corners, filled));
    }
}

/// Connected regions of each class.
fn regions(field: &LevelField, triangles: &[([Point3<f64>; 3], [f64; 3])], options: &PathOptions) -> Vec<Region> {
    let mut all = Vec::new();
    for class in 0..3 {
        let of_class = || triangles.iter().enumerate().filter(|(_, (_, areas))| areas[class] > 0.0);
        let mut parents: Vec<u32> = (0..field.points.len() as u32).collect();
        for (triangle, _) in of_class() {
            let [a, b, c] = field.triangles[triangle];
            join(&mut parents, a, b);
            join(&mut parents, b, c);
        }
        let mut found: BTreeMap<u32, Region> = BTreeMap::new();
        for (triangle, (corners, areas)) in of_class() {
            let [a, ..] = field.triangles[triangle];
            let none = Region { curves: 0.0, triangles: Vec::new() };
            let region = found.entry(root(&mut parents, a)).or_insert(none);
            let before = region.triangles.last().map_or(0.0, |&(_, sum)| sum);
            region.triangles.push((*corners, before + areas[class]));
            if class == 0 && options.pattern == Pattern::Rings {
                // Rings are not joined: as many as there are between the boundary and the farthest place from it.
                let far = field.triangles[triangle].map(|v| field.values[v as usize]).into_iter().fold(0.0, f64::max);
                let contours = if options.infill.is_solid() { f64::INFINITY } else { f64::from(options.infill.walls) };
                region.curves = region.curves.max((far / options.bead).round().min(contours));
            }
            region.curves = region.curves.max(1.0);
        }
        // What is smaller than a square of a bead is part of what is beside it, or a dot.
        let least = options.bead.powi(2);
        all.extend(
            found.into_values().filter(|region| region.triangles.last().is_some_and(|&(_, area)| area >= least)),
        );
    }
    all
}
