//! Layers that are not filled solid: walls along the boundary, skins at the outside of the part, sparse infill inside.
//!
//! Three regions of each surface, by two functions that are linear over triangles: how far a place is inward of the innermost wall
//! ([`PathOptions`]'s contours, which nest by exact geodesic distance), and how far it is inside of a skin (`skin`). `split` cuts the
//! refined mesh along their zeros. Walls are the outer rings of the spirals that fill solid layers (Dai 2020, section 3.5.1); a skin is a
//! surface of its own, filled solid by distance to its own boundary; the rest gets rows by geodesic distance from a cut through its
//! middle, or curves of a gyroid (`pattern`). What a skin bridges is reported by `bridge`.
//!
//! Parts of the inside that are narrower than three beads are filled solid: a row would fit there by luck only.

mod bridge;
mod pattern;
mod skin;
mod split;

use super::fill::{FillError, LayerSurface};
use super::geodesic::SurfaceDistance;
use super::kind::BeadKind;
use super::level_set::{LevelField, SurfacePoint};
use super::mesh::SurfaceMesh;
use super::paths::curve::nearest_in_triangle;
use super::paths::{LayerPaths, PathError, PathOptions, PathPoint, Pattern, SurfacePath};
use crate::Progress;
pub use bridge::Bridges;
pub(super) use bridge::{mark, mark_support};
use nalgebra::Point3;
pub(super) use skin::{Sites, sites};
use split::{Class, Sheet};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// The turn between the rows of layers that follow each other which spreads their directions most evenly over any number of layers: a
/// half turn (rows have no sense) by the golden ratio, 111.2 degrees.
const GOLDEN_TURN: f64 = PI * 0.618_033_988_749_894_9;

/// Parts of the inside that reach no farther from their boundary than this, in beads, are filled solid.
const MIN_REACH: f64 = 1.5;

/// And those that reach no farther than this, in beads, get nothing: no bead fits.
const MIN_BEAD_REACH: f64 = 0.375;

/// Infill shorter than this, in beads, is left out: it would be a start and nothing else.
const SHORTEST: f64 = 2.0;

/// How the inside is filled where it is not solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum InfillPattern {
    /// Rows at an even geodesic distance from each other, to and fro; their direction turns from layer to layer.
    #[default]
    Rows,
    /// Where the layer meets a gyroid, a surface that is the same for all layers and repeats in space.
    Gyroid,
}

/// What is solid and what is not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct InfillOptions {
    /// Share of the inside that is filled, from 0 to 1: 1 by default, and then all layers are filled solid and nothing else here
    /// counts. With 0 there are walls and skins only.
    pub density: f64,
    /// Contours along the boundary of a layer: 3.
    pub walls: u32,
    /// How many layers at the bottom and at the top are filled solid, by the way across the layers to the outside of the part: 4. Over
    /// sparse infill the first one of a top is bridged; more of them close what it leaves.
    pub skin: u32,
    /// The pattern of the inside.
    pub pattern: InfillPattern,
    /// How much rows turn from layer to layer, in radians: a half turn by the golden ratio. `PI / 2` for two directions in turn.
    pub turn: f64,
    /// How far infill reaches into the innermost wall, in beads, so that it holds: 0.15. At most half a bead.
    pub overlap: f64,
}

impl Default for InfillOptions {
    fn default() -> Self {
        let pattern = InfillPattern::Rows;
        InfillOptions { density: 1.0, walls: 3, skin: 4, pattern, turn: GOLDEN_TURN, overlap: 0.15 }
    }
}

/// Walls and skins beyond this number are a slip.
const MOST: u32 = 10_000;

impl InfillOptions {
    /// Whether all layers are filled solid.
    pub fn is_solid(&self) -> bool {
        self.density >= 1.0
    }

    pub(super) fn check(&self) -> Result<(), PathError> {
        let InfillOptions { density, walls, skin, turn, overlap, .. } = *self;
        let sound = [
            ("density", density, (0.0..=1.0).contains(&density), "from 0 to 1"),
            ("walls", f64::from(walls), walls <= MOST, "10000 at most"),
            ("skin", f64::from(skin), skin <= MOST, "10000 at most"),
            ("turn", turn, turn.is_finite(), "finite"),
            ("overlap", overlap, (0.0..=0.5).contains(&overlap), "from 0 to 0.5 beads"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, wanted)) => Err(PathError::Infill { option, value, wanted }),
            None => Ok(()),
        }
    }
}

/// The sparse part of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SparseFill {
    /// Its area.
    pub area_mm2: f64,
    /// Area by the thickness of the layer.
    pub volume_mm3: f64,
    /// Curves in it.
    pub curves: usize,
    /// Length of the beads in it.
    pub infill_mm: f64,
    /// Their volume: length by width by thickness.
    pub infill_mm3: f64,
}

impl SparseFill {
    pub(super) fn add(&mut self, other: &SparseFill) {
        self.area_mm2 += other.area_mm2;
        self.volume_mm3 += other.volume_mm3;
        self.curves += other.curves;
        self.infill_mm += other.infill_mm;
        self.infill_mm3 += other.infill_mm3;
    }

    /// Share of the volume that beads fill; 0 where nothing is sparse.
    pub fn density(&self) -> f64 {
        if self.volume_mm3 > 0.0 { self.infill_mm3 / self.volume_mm3 } else { 0.0 }
    }
}

/// Where a layer is in the part.
pub(super) struct Site {
    /// Number of whole layers before it.
    pub number: usize,
    /// For each vertex how far it is inside of a skin, in millimetres; below 0 outside.
    pub skin: Vec<f64>,
}

impl Site {
    /// A layer with nothing above or below it: all of it is skin, if there are skins.
    pub fn alone(mesh: &SurfaceMesh, options: &InfillOptions) -> Site {
        let inside = if options.skin > 0 { mesh.diagonal() } else { -mesh.diagonal() };
        Site { number: 0, skin: vec![inside; mesh.vertices().len()] }
    }
}

/// A layer with walls, skins and infill.
pub(super) struct Filled {
    pub paths: LayerPaths,
    pub sparse: SparseFill,
    /// What is solid, if coverage is asked for; none if there is nothing solid.
    pub solid: Option<SurfaceMesh>,
    /// Its area; none of a layer that is solid.
    pub solid_mm2: Option<f64>,
}

impl Filled {
    /// A layer that is solid.
    pub fn solid(paths: LayerPaths) -> Filled {
        Filled { paths, sparse: SparseFill::default(), solid: None, solid_mm2: None }
    }
}

/// Fills a layer that is not solid.
pub(super) fn filled(
    field: &LevelField,
    surface: &LayerSurface,
    options: &PathOptions,
    site: &Site,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Filled, FillError> {
    let (mesh, bead, infill) = (field.distance().mesh(), options.bead, options.infill);
    // Rows know nothing of the boundary, so they make no walls.
    let pattern = if options.pattern == Pattern::Zigzag { Pattern::Spirals } else { options.pattern };
    let contours = field.contours(&PathOptions { pattern, ..*options }, Some(infill.walls), progress)?;
    let mut paths = contours.paths;
    let sheet = |overlap: f64| {
        let mut sheet = Sheet::new(field, &contours.inside, &site.skin, overlap);
        sheet.classify(MIN_BEAD_REACH * bead, if infill.density > 0.0 { MIN_REACH * bead } else { 0.0 })?;
        Ok::<_, FillError>(sheet)
    };
    let flush = sheet(0.0)?;
    if let Some((skin, parents)) = flush.part(|class| class == Class::Skin)? {
        let options = PathOptions { infill: InfillOptions::default(), ..*options };
        let on_mesh = OnMesh { mesh, parents: &parents };
        let found = solid_paths(&skin, &options, progress)?;
        let regions = paths.regions as u32;
        let taken = |found: Vec<SurfacePath>| found.into_iter().map(move |path| on_mesh.path(path, regions));
        paths.regions += found.regions;
        paths.joints += found.joints;
        paths.paths.extend(taken(found.paths));
        paths.short.extend(taken(found.short));
        // Narrow strips of skin lie between walls and infill: those of the layer are with the walls.
    }
    let mut sparse = SparseFill::default();
    for (corners, parent) in flush.of(Class::Sparse) {
        sparse.area_mm2 += area(corners);
        sparse.volume_mm3 += area(corners) * thickness(surface, parent);
    }
    if sparse.area_mm2 > 0.0 && infill.density > 0.0 {
        // Rows and curves reach a little into what is solid around them.
        let anchored = sheet(infill.overlap * bead)?;
        let region = paths.regions as u32;
        let wanted = pattern::Wanted { bead, infill: &infill, number: site.number, area: sparse.area_mm2 };
        for (points, closed) in pattern::curves(mesh, &anchored, &wanted)? {
            let points = points.into_iter().map(|at| PathPoint { at, width: bead, kind: BeadKind::Infill }).collect();
            let path = SurfacePath { points, closed, region };
            if path.length() < SHORTEST * bead {
                continue;
            }
            for [from, to] in (0..path.segments()).map(|k| path.segment(k)) {
                let length = (to.at.position - from.at.position).norm();
                sparse.infill_mm += length;
                sparse.infill_mm3 += length * bead * thickness(surface, from.at.triangle);
            }
            sparse.curves += 1;
            paths.paths.push(path);
        }
        paths.regions += 1;
    }
    paths.unfilled = field.unfilled(&paths.paths);
    // What curves cover depends on it; where they cross and turn does not, and is found sooner on the mesh that is not refined.
    let solid = if options.coverage { flush.part(|class| class != Class::Sparse)?.map(|(mesh, _)| mesh) } else { None };
    let solid_mm2 =
        [Class::Wall, Class::Skin].iter().flat_map(|class| flush.of(*class)).map(|(corners, _)| area(corners)).sum();
    Ok(Filled { paths, sparse, solid, solid_mm2: Some(solid_mm2) })
}

fn area([a, b, c]: [Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn thickness(surface: &LayerSurface, triangle: u32) -> f64 {
    surface.thickness.get(triangle as usize).copied().unwrap_or(0.0)
}

/// A surface filled solid, by the distance to its own boundary.
fn solid_paths(
    mesh: &SurfaceMesh,
    options: &PathOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<LayerPaths, FillError> {
    let distance = SurfaceDistance::to_boundary(mesh, progress)?;
    let field = LevelField::new(&distance, super::fill::TOLERANCE * options.bead, progress)?;
    Ok(field.paths(options, progress)?)
}

/// Back from a part of a mesh to the mesh.
#[derive(Clone, Copy)]
struct OnMesh<'a> {
    mesh: &'a SurfaceMesh,
    /// The triangle of the mesh that has each of the part.
    parents: &'a [u32],
}

impl OnMesh<'_> {
    fn point(&self, at: &SurfacePoint) -> SurfacePoint {
        let triangle = self.parents[at.triangle as usize];
        let (_, barycentric) = nearest_in_triangle(self.mesh, triangle, at.position);
        SurfacePoint { triangle, barycentric, position: at.position }
    }

    /// A path of a skin.
    fn path(&self, path: SurfacePath, regions: u32) -> SurfacePath {
        let point = |point: &PathPoint| PathPoint { at: self.point(&point.at), kind: BeadKind::Skin, ..*point };
        SurfacePath { points: path.points.iter().map(point).collect(), region: path.region + regions, ..path }
    }
}
