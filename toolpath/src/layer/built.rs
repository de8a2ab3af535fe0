//! Layers as they are given, checked, and as triangles.

use super::error::StackError;
use super::rims::Rims;
use super::triangle::Triangle;
use crate::path::{BeadKind, SurfacePath};
use nalgebra::{Point3, Vector3};

/// Triangles and points are numbered in 32 bits.
pub(super) const MAX_TRIANGLES: usize = 1 << 30;

/// Coordinates, widths and heights beyond this are refused: a part is not ten kilometres wide, and squares stay exact
/// enough.
pub(super) const MAX_COORDINATE_MM: f64 = 1e7;

/// A curve on a layer, along which a bead is laid.
#[derive(Clone, Copy, Debug)]
pub struct LayerCurve<'a> {
    /// Points in order, in millimetres, on the surface of the layer or near it.
    pub points: &'a [Point3<f64>],
    /// Width of the bead at each point, in millimetres.
    pub widths: &'a [f64],
    /// What the bead is for at each point; [`BeadKind::Solid`] where nothing is said.
    pub kinds: &'a [BeadKind],
    /// Whether the last point is joined to the first, which is not repeated.
    pub closed: bool,
}

/// A curve of a stack, wherever its points stand.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BuiltCurve<'a> {
    /// In lists of its own.
    Given(LayerCurve<'a>),
    /// In the path that filled the layer.
    Path(&'a SurfacePath),
}

impl BuiltCurve<'_> {
    pub fn is_closed(&self) -> bool {
        match self {
            BuiltCurve::Given(curve) => curve.closed,
            BuiltCurve::Path(path) => path.closed,
        }
    }

    /// How many points it has.
    pub fn len(&self) -> usize {
        match self {
            BuiltCurve::Given(curve) => curve.points.len(),
            BuiltCurve::Path(path) => path.points.len(),
        }
    }

    /// A point, the width of the bead there, and what it is for.
    pub fn at(&self, k: usize) -> (Point3<f64>, f64, BeadKind) {
        match self {
            BuiltCurve::Given(LayerCurve { points, widths, kinds, .. }) => {
                (points[k], widths[k], kinds.get(k).copied().unwrap_or_default())
            }
            BuiltCurve::Path(path) => {
                let point = &path.points[k];
                (point.at.position, point.width, point.kind)
            }
        }
    }

    /// How many widths it has, which a list may have more or fewer of than points.
    fn widths(&self) -> usize {
        match self {
            BuiltCurve::Given(curve) => curve.widths.len(),
            BuiltCurve::Path(path) => path.points.len(),
        }
    }
}

/// A layer: its surface, how thick it is, and the curves that fill it.
#[derive(Clone, Copy, Debug)]
pub struct BuiltLayer<'a> {
    /// Points of the surface in millimetres: it runs through the middle of the layer.
    pub vertices: &'a [Point3<f64>],
    /// Its triangles, counter-clockwise seen from where the growth goes.
    pub triangles: &'a [[u32; 3]],
    /// For each triangle the thickness of the layer there in millimetres: its distance to the neighbouring layers.
    pub spacing: &'a [f64],
    /// The curves, in the order in which they are printed.
    pub curves: &'a [LayerCurve<'a>],
}

/// A layer with its curves.
#[derive(Debug)]
pub(crate) struct Built<'a> {
    pub vertices: &'a [Point3<f64>],
    pub triangles: &'a [[u32; 3]],
    pub spacing: &'a [f64],
    pub curves: Vec<BuiltCurve<'a>>,
}

/// A layer made ready.
pub(super) struct Prepared {
    pub triangles: Vec<Triangle>,
    pub normals: Vec<Vector3<f64>>,
    pub rims: Vec<[Point3<f64>; 2]>,
}

/// The triangles of a layer that have an area, with what is at their corners.
pub(super) fn prepare(number: u32, layer: &Built) -> Prepared {
    let normals = normals(layer);
    let at_boundary = Rims::new(layer.vertices.len(), layer.triangles);
    let (mut triangles, mut rims) = (Vec::with_capacity(layer.triangles.len()), Vec::new());
    for ((index, corners), &height) in (0..).zip(layer.triangles).zip(layer.spacing) {
        let [a, b, c] = corners.map(|v| layer.vertices[v as usize]);
        if (b - a).cross(&(c - a)).try_normalize(0.0).is_none() {
            continue;
        }
        let before = rims.len() as u32;
        rims.extend(at_boundary.near(corners).into_iter().map(|edge| edge.map(|v| layer.vertices[v as usize])));
        let rims = [before, rims.len() as u32];
        triangles.push(Triangle { corners: [a, b, c], rims, height, layer: number, index });
    }
    Prepared { triangles, normals, rims }
}

/// The normal of each vertex, weighted by area; zero where triangles cancel.
fn normals(layer: &Built) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); layer.vertices.len()];
    for corners in layer.triangles {
        let [a, b, c] = corners.map(|v| layer.vertices[v as usize]);
        let normal = (b - a).cross(&(c - a));
        corners.iter().for_each(|&v| normals[v as usize] += normal);
    }
    normals.iter().map(|n| n.try_normalize(0.0).unwrap_or_default()).collect()
}

pub(super) fn sound(p: &Point3<f64>) -> bool {
    p.iter().all(|c| c.abs() <= MAX_COORDINATE_MM)
}

/// The first triangle with a corner beyond the given number of vertices, and that corner.
pub(super) fn unknown_corner(triangles: &[[u32; 3]], vertices: usize) -> Option<(usize, u32)> {
    let unknown = |corners: &[u32; 3]| corners.iter().copied().find(|&corner| corner as usize >= vertices);
    triangles.iter().enumerate().find_map(|(triangle, corners)| Some((triangle, unknown(corners)?)))
}

pub(super) fn check(number: usize, layer: &Built) -> Result<(), StackError> {
    if let Some(vertex) = layer.vertices.iter().position(|p| !sound(p)) {
        return Err(StackError::BadVertex { layer: number, vertex });
    }
    let (triangles, spacing, vertices) = (layer.triangles.len(), layer.spacing.len(), layer.vertices.len());
    if let Some((triangle, vertex)) = unknown_corner(layer.triangles, vertices) {
        return Err(StackError::NoSuchVertex { layer: number, triangle, vertex, vertices });
    }
    if triangles != spacing {
        return Err(StackError::SpacingCount { layer: number, spacing, triangles });
    }
    let positive = |value: f64| value > 0.0 && value < MAX_COORDINATE_MM;
    if let Some(triangle) = layer.spacing.iter().position(|&s| !positive(s)) {
        return Err(StackError::BadSpacing { layer: number, triangle, spacing: layer.spacing[triangle] });
    }
    for (curve, given) in layer.curves.iter().enumerate() {
        let (points, widths) = (given.len(), given.widths());
        if points < 2 + usize::from(given.is_closed()) {
            return Err(StackError::FewPoints { layer: number, curve, points });
        }
        if points != widths {
            return Err(StackError::WidthCount { layer: number, curve, widths, points });
        }
        if let Some(point) = (0..points).find(|&k| !sound(&given.at(k).0)) {
            return Err(StackError::BadPoint { layer: number, curve, point });
        }
        if let Some(point) = (0..points).find(|&k| !positive(given.at(k).1)) {
            return Err(StackError::BadWidth { layer: number, curve, point, width: given.at(point).1 });
        }
        if (1..points).all(|k| given.at(k).0 == given.at(0).0) {
            return Err(StackError::NoLength { layer: number, curve });
        }
    }
    Ok(())
}
