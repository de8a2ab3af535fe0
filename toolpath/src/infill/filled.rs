//! A layer with walls, skins and infill.

use super::error::FillError;
use super::on_mesh::OnMesh;
use super::pattern;
use super::site::Site;
use super::sparse::SparseFill;
use super::split::{Class, Sheet};
use crate::ProgressFn;
use crate::geodesic::SurfaceDistance;
use crate::layer::LayerSurface;
use crate::level_set::LevelField;
use crate::mesh::SurfaceMesh;
use crate::path::{BeadKind, InfillOptions, LayerPaths, PathOptions, PathPoint, Pattern, SurfacePath};
use nalgebra::Point3;

/// How far level sets may be off, in beads. Less takes longer and moves curves by less than a machine resolves; with more
/// the outermost bead spills over the boundary.
pub(crate) const TOLERANCE: f64 = 0.0125;

/// Parts of the inside that reach no farther from their boundary than this, in beads, are filled solid.
pub(crate) const MIN_REACH: f64 = 1.5;

/// And those that reach no farther than this, in beads, get nothing: no bead fits.
pub(crate) const MIN_BEAD_REACH: f64 = 0.375;

/// Infill shorter than this, in beads, is left out: it would be a start and nothing else.
const SHORTEST: f64 = 2.0;

/// A layer with walls, skins and infill.
pub(crate) struct Filled {
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
pub(crate) fn filled(
    field: &LevelField,
    surface: &LayerSurface,
    options: &PathOptions,
    site: &Site,
    progress: ProgressFn,
) -> Result<Filled, FillError> {
    let (bead, infill) = (options.bead, options.infill);
    // Rows know nothing of the boundary, so they make no walls.
    let pattern = if options.pattern == Pattern::Zigzag { Pattern::Spirals } else { options.pattern };
    let contours = field.contours(&PathOptions { pattern, ..*options }, Some(infill.walls), progress)?;
    let mut paths = contours.paths;
    let sheet = |overlap: f64| {
        let mut sheet = Sheet::new(field, &contours.inside, &site.skin, overlap);
        sheet.classify(MIN_BEAD_REACH * bead, if infill.density > 0.0 { MIN_REACH * bead } else { 0.0 })?;
        Ok::<_, FillError>(sheet)
    };
    // Areas and skins are those between the walls; only what is laid as infill reaches beyond.
    let flush = sheet(0.0)?;
    add_skin(&mut paths, field, &flush, options, progress)?;
    paths.straighten(bead);
    let mut sparse = SparseFill::default();
    for (corners, parent) in flush.of(Class::Sparse) {
        sparse.area_mm2 += area(corners);
        sparse.volume_mm3 += area(corners) * thickness(surface, parent);
    }
    if sparse.area_mm2 > 0.0 && infill.density > 0.0 {
        // Rows and curves reach a little into what is solid around them.
        let anchored = sheet(infill.overlap * bead)?;
        let wanted = pattern::Wanted { bead, infill: &infill, number: site.number, area: sparse.area_mm2 };
        let curves = pattern::curves(field.distance().mesh(), &anchored, &wanted)?;
        add_infill(&mut paths, &mut sparse, curves, bead, surface);
    }
    paths.unfilled = field.unfilled(&paths.paths);
    // What curves cover depends on it; where they cross and turn does not, and is found sooner on the mesh that is not refined.
    let solid = if options.coverage { flush.part(|class| class != Class::Sparse)?.map(|(mesh, _)| mesh) } else { None };
    let solid_mm2 =
        [Class::Wall, Class::Skin].iter().flat_map(|class| flush.of(*class)).map(|(corners, _)| area(corners)).sum();
    Ok(Filled { paths, sparse, solid, solid_mm2: Some(solid_mm2) })
}

/// Fills the skin as a surface of its own, whose boundary is that between skin and walls or infill. Its regions come after those of the walls.
fn add_skin(
    paths: &mut LayerPaths,
    field: &LevelField,
    flush: &Sheet,
    options: &PathOptions,
    progress: ProgressFn,
) -> Result<(), FillError> {
    let Some((skin, parents)) = flush.part(|class| class == Class::Skin)? else { return Ok(()) };
    let options = PathOptions { infill: InfillOptions::default(), ..*options };
    let on_mesh = OnMesh { mesh: field.distance().mesh(), parents: &parents };
    let found = solid_paths(&skin, &options, progress)?;
    let regions = paths.regions as u32;
    let taken = |found: Vec<SurfacePath>| found.into_iter().map(move |path| on_mesh.path(path, regions));
    paths.regions += found.regions;
    paths.joints += found.joints;
    paths.paths.extend(taken(found.paths));
    paths.short.extend(taken(found.short));
    // Narrow strips of skin lie between walls and infill: those of the layer are with the walls.
    Ok(())
}

/// Adds the curves of sparse infill that are long enough, all as one region, and counts what they take.
fn add_infill(
    paths: &mut LayerPaths,
    sparse: &mut SparseFill,
    curves: Vec<pattern::Curve>,
    bead: f64,
    surface: &LayerSurface,
) {
    let region = paths.regions as u32;
    for (points, closed) in curves {
        let points = points.into_iter().map(|at| PathPoint { at, width: bead, kind: BeadKind::Infill }).collect();
        let mut path = SurfacePath { points, closed, region };
        path.straighten(bead);
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

fn area([a, b, c]: [Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

pub(crate) fn thickness(surface: &LayerSurface, triangle: u32) -> f64 {
    surface.thickness.get(triangle as usize).copied().unwrap_or(0.0)
}

/// A surface filled solid, by the distance to its own boundary.
fn solid_paths(mesh: &SurfaceMesh, options: &PathOptions, progress: ProgressFn) -> Result<LayerPaths, FillError> {
    let distance = SurfaceDistance::to_boundary(mesh, progress)?;
    let field = LevelField::new(&distance, TOLERANCE * options.bead, progress)?;
    Ok(field.paths(options, progress)?)
}
