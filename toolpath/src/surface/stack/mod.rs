//! A part layer by layer, in the order in which it is built: what a nozzle stands on, and what it must not run into.
//!
//! [`LayerStack`] checks the layers once and keeps all their triangles in one tree of boxes (`tree`). Each box knows the
//! earliest of its triangles, so a question about what is built by now passes over all that comes later. A mould on which the part is built
//! is there before the first layer.

mod mould;
mod rims;
mod tree;
mod triangle;

use super::kind::BeadKind;
use super::orientation::DirectionHints;
use super::parallel;
pub(super) use mould::MouldSurface;
pub use mould::{Mould, MouldError};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::ops::{ControlFlow, Range};
pub(super) use tree::{Keys, Node, Tree, Walk};
pub(super) use triangle::{MOULD, Triangle};

/// Triangles and points are numbered in 32 bits.
const MOST: usize = 1 << 30;

/// Coordinates, widths and heights beyond this are refused: a part is not ten kilometres wide, and squares stay exact
/// enough.
const LARGEST: f64 = 1e7;

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

impl LayerCurve<'_> {
    /// What the bead is for at a point.
    pub(super) fn kind(&self, point: usize) -> BeadKind {
        self.kinds.get(point).copied().unwrap_or_default()
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

/// Why layers cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StackError {
    /// More than can be numbered.
    #[error("{triangles} triangles are too many: at most 2^30")]
    TooLarge {
        /// All triangles.
        triangles: usize,
    },
    /// A vertex of a surface has an invalid coordinate.
    #[error("vertex {vertex} of layer {layer} is not finite or beyond 1e7 mm")]
    BadVertex {
        /// The layer, from 0.
        layer: usize,
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A triangle names a point that is not there.
    #[error("triangle {triangle} of layer {layer} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// The layer, from 0.
        layer: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// Vertices that the layer has.
        vertices: usize,
    },
    /// There is not one spacing for each triangle.
    #[error("layer {layer} has {spacing} spacings for {triangles} triangles")]
    SpacingCount {
        /// The layer, from 0.
        layer: usize,
        /// Spacings given.
        spacing: usize,
        /// Triangles given.
        triangles: usize,
    },
    /// A layer without thickness.
    #[error("triangle {triangle} of layer {layer} has a spacing of {spacing} mm: it must be above 0 and below 1e7")]
    BadSpacing {
        /// The layer, from 0.
        layer: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The spacing.
        spacing: f64,
    },
    /// A curve needs two points, a closed one three.
    #[error("curve {curve} of layer {layer} has {points} points: a curve needs two, a closed one three")]
    FewPoints {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// Points that it has.
        points: usize,
    },
    /// All points of a curve are one.
    #[error("curve {curve} of layer {layer} has no length")]
    NoLength {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
    },
    /// There is not one width for each point.
    #[error("curve {curve} of layer {layer} has {widths} widths for {points} points")]
    WidthCount {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// Widths given.
        widths: usize,
        /// Points given.
        points: usize,
    },
    /// A point of a curve has an invalid coordinate.
    #[error("point {point} of curve {curve} of layer {layer} is not finite or beyond 1e7 mm")]
    BadPoint {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// The point, from 0.
        point: usize,
    },
    /// A bead without width.
    #[error(
        "point {point} of curve {curve} of layer {layer} has a width of {width} mm: it must be above 0 and below 1e7"
    )]
    BadWidth {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// The point, from 0.
        point: usize,
        /// The width.
        width: f64,
    },
    /// A curve on a layer without any triangle that has an area: there is no thickness and no normal.
    #[error("layer {layer} has curves but no triangle with an area")]
    NoSurface {
        /// The layer, from 0.
        layer: usize,
    },
    /// What the part is built on cannot be used.
    #[error("the mould: {0}")]
    Mould(#[from] MouldError),
}

/// A layer with its curves.
#[derive(Debug)]
pub(super) struct Built<'a> {
    pub vertices: &'a [Point3<f64>],
    pub triangles: &'a [[u32; 3]],
    pub spacing: &'a [f64],
    pub curves: Vec<LayerCurve<'a>>,
}

/// The layers of a part in build order, ready for questions about what is built by now.
#[derive(Debug)]
pub struct LayerStack<'a> {
    pub(super) layers: Vec<Built<'a>>,
    pub(super) tree: Tree,
    /// The mould has 0, layers have their number from 1: see [`of_layer`].
    pub(super) keys: Keys,
    /// For each layer and vertex the mean normal of the triangles around it, weighted by area; zero where they cancel.
    normals: Vec<Vec<Vector3<f64>>>,
    /// Edges of the boundaries, those at the corners of a triangle together.
    pub(super) rims: Vec<[Point3<f64>; 2]>,
    /// Directions that are known ([`LayerStack::with_hints`]).
    pub(super) hints: DirectionHints,
    /// Lower and upper corner of a box around the mould, its skin included.
    pub(super) mould: Option<[Point3<f64>; 2]>,
}

/// The keys of the triangles of a layer.
pub(super) fn of_layer(layer: u32) -> Range<u32> {
    layer + 1..layer + 2
}

/// The keys of what is there before a layer begins.
pub(super) fn below_layer(layer: u32) -> Range<u32> {
    0..layer + 1
}

/// By layers.
fn keys_by_layer(tree: &Tree) -> Keys {
    let key = |triangle: &Triangle| if triangle.layer == MOULD { 0 } else { of_layer(triangle.layer).start };
    Keys::new(tree, tree.triangles().iter().map(key).collect())
}

/// The surface of a layer at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    /// The unit normal along the growth, smooth over triangles; `None` where it vanishes.
    pub normal: Option<UnitVector3<f64>>,
    /// Thickness of the layer.
    pub height: f64,
}

impl<'a> LayerStack<'a> {
    /// Checks the layers and sorts their triangles into a tree. Triangles without area are left out.
    ///
    /// # Errors
    /// [`StackError`], for the first fault found. Nothing is repaired.
    ///
    /// # Cost
    /// `O(n log n)` for `n` triangles: about half a microsecond each.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::{nalgebra::Point3, surface::{BuiltLayer, LayerStack, StackError}};
    /// let vertices = [[0.0, 0.0, 0.4], [9.0, 0.0, 0.4], [0.0, 9.0, 0.4]].map(Point3::from);
    /// let layer = BuiltLayer { vertices: &vertices, triangles: &[[0, 1, 2]], spacing: &[0.8], curves: &[] };
    /// assert_eq!(LayerStack::new(&[layer])?.triangles(), 1);
    /// let thin = BuiltLayer { spacing: &[0.0], ..layer };
    /// let error = StackError::BadSpacing { layer: 0, triangle: 0, spacing: 0.0 };
    /// assert_eq!(LayerStack::new(&[thin]).unwrap_err(), error);
    /// # Ok::<(), StackError>(())
    /// ```
    pub fn new(layers: &'a [BuiltLayer<'a>]) -> Result<Self, StackError> {
        let built = |&BuiltLayer { vertices, triangles, spacing, curves }: &BuiltLayer<'a>| Built {
            vertices,
            triangles,
            spacing,
            curves: curves.to_vec(),
        };
        LayerStack::of(layers.iter().map(built).collect())
    }

    /// The same of layers with curves that stand beside them.
    pub(super) fn with_curves(layers: Vec<(BuiltLayer<'a>, Vec<LayerCurve<'a>>)>) -> Result<Self, StackError> {
        let built = |(BuiltLayer { vertices, triangles, spacing, .. }, curves): (BuiltLayer<'a>, _)| Built {
            vertices,
            triangles,
            spacing,
            curves,
        };
        LayerStack::of(layers.into_iter().map(built).collect())
    }

    fn of(layers: Vec<Built<'a>>) -> Result<Self, StackError> {
        let triangles = layers.iter().map(|layer| layer.triangles.len()).sum();
        if triangles > MOST {
            return Err(StackError::TooLarge { triangles });
        }
        layers.iter().enumerate().try_for_each(|(number, layer)| check(number, layer))?;
        let silent = |_| ControlFlow::Continue(());
        let work = |number: usize, layer: &Built| prepare(number as u32, layer);
        let prepared = parallel::map(&layers, "layers", &silent, work).unwrap_or_default();
        let (mut all, mut rims) = (Vec::with_capacity(triangles), Vec::new());
        let mut normals = Vec::with_capacity(layers.len());
        for (layer, of_layer) in prepared.into_iter().enumerate() {
            if of_layer.triangles.is_empty() && !layers[layer].curves.is_empty() {
                return Err(StackError::NoSurface { layer });
            }
            let before = rims.len() as u32;
            rims.extend(of_layer.rims);
            normals.push(of_layer.normals);
            let shift = |triangle: Triangle| Triangle { rims: triangle.rims.map(|k| k + before), ..triangle };
            all.extend(of_layer.triangles.into_iter().map(shift));
        }
        let tree = Tree::new(all);
        let keys = keys_by_layer(&tree);
        Ok(LayerStack { layers, tree, keys, normals, rims, hints: DirectionHints::default(), mould: None })
    }

    /// The same layers with directions in which the nozzle is known to get to some places. Where [`LayerStack::resolve_gouging`] finds no free
    /// direction within its limit of the one wanted, it looks for the one nearest to what is known there.
    pub fn with_hints(self, hints: DirectionHints) -> Self {
        LayerStack { hints, ..self }
    }

    /// How many triangles have an area.
    pub fn triangles(&self) -> usize {
        self.tree.triangles().len()
    }

    /// The surface of a layer near `p`. The layer has curves, so it has a surface.
    pub(super) fn ground(&self, layer: u32, p: Point3<f64>) -> Option<Ground> {
        let found = self.tree.nearest(&self.keys, p, of_layer(layer), f64::INFINITY, |_, _| true)?;
        let triangle = &self.tree.triangles()[found.triangle];
        let [a, b, c] = triangle.corners;
        let of = |from: Point3<f64>, to: Point3<f64>| {
            (to - from).cross(&(found.point - from)).dot(&triangle.normal()).max(0.0)
        };
        let corners = self.layers[layer as usize].triangles[triangle.index as usize];
        let at = corners.map(|v| self.normals[layer as usize][v as usize]);
        let sum = at[0] * of(b, c) + at[1] * of(c, a) + at[2] * of(a, b);
        Some(Ground { normal: Unit::try_new(sum, 0.0), height: triangle.height })
    }
}

/// A layer made ready.
struct Prepared {
    triangles: Vec<Triangle>,
    normals: Vec<Vector3<f64>>,
    rims: Vec<[Point3<f64>; 2]>,
}

/// The triangles of a layer that have an area, with what is at their corners.
fn prepare(number: u32, layer: &Built) -> Prepared {
    let normals = normals(layer);
    let at_boundary = rims::Rims::new(layer.vertices.len(), layer.triangles);
    let (mut triangles, mut rims) = (Vec::with_capacity(layer.triangles.len()), Vec::new());
    for ((index, corners), &height) in (0..).zip(layer.triangles).zip(layer.spacing) {
        let [a, b, c] = corners.map(|v| layer.vertices[v as usize]);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue;
        };
        let before = rims.len() as u32;
        rims.extend(at_boundary.near(corners).into_iter().map(|edge| edge.map(|v| layer.vertices[v as usize])));
        let at = corners.map(|v| Some(normals[v as usize]).filter(|n| n.norm_squared() > 0.5).unwrap_or(normal));
        let rims = [before, rims.len() as u32];
        triangles.push(Triangle { corners: [a, b, c], normals: at, rims, height, layer: number, index });
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

fn sound(p: &Point3<f64>) -> bool {
    p.iter().all(|c| c.abs() <= LARGEST)
}

/// The first triangle with a corner that is none of so many vertices, and that corner.
fn unknown_corner(triangles: &[[u32; 3]], vertices: usize) -> Option<(usize, u32)> {
    let unknown = |corners: &[u32; 3]| corners.iter().copied().find(|&corner| corner as usize >= vertices);
    triangles.iter().enumerate().find_map(|(triangle, corners)| Some((triangle, unknown(corners)?)))
}

fn check(number: usize, layer: &Built) -> Result<(), StackError> {
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
    let positive = |value: f64| value > 0.0 && value < LARGEST;
    if let Some(triangle) = layer.spacing.iter().position(|&s| !positive(s)) {
        return Err(StackError::BadSpacing { layer: number, triangle, spacing: layer.spacing[triangle] });
    }
    for (curve, given) in layer.curves.iter().enumerate() {
        let (points, widths) = (given.points.len(), given.widths.len());
        if points < 2 + usize::from(given.closed) {
            return Err(StackError::FewPoints { layer: number, curve, points });
        }
        if points != widths {
            return Err(StackError::WidthCount { layer: number, curve, widths, points });
        }
        if let Some(point) = given.points.iter().position(|p| !sound(p)) {
            return Err(StackError::BadPoint { layer: number, curve, point });
        }
        if let Some(point) = given.widths.iter().position(|&w| !positive(w)) {
            return Err(StackError::BadWidth { layer: number, curve, point, width: given.widths[point] });
        }
        if given.points.iter().all(|p| *p == given.points[0]) {
            return Err(StackError::NoLength { layer: number, curve });
        }
    }
    Ok(())
}
