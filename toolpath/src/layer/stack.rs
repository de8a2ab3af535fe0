//! A part layer by layer, in the order in which it is built: what a nozzle stands on, and what it must not run into.
//!
//! [`LayerStack`] checks the layers once and keeps all their triangles in one tree of boxes (`tree`). Each box knows the
//! earliest of its triangles, so a question about what is built by now passes over all that comes later. A mould on which the part is built
//! is there before the first layer.

use super::built::{Built, BuiltCurve, BuiltLayer, MAX_TRIANGLES, check, prepare};
use super::error::StackError;
use super::hints::DirectionHints;
use super::keys::{keys_by_layer, of_layer};
use super::surface::LayerSurface;
use super::tree::{Keys, Tree};
use super::triangle::{MOULD, Triangle};
use crate::mesh::on_triangle;
use crate::parallel;
use crate::path::SurfacePath;
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::ops::ControlFlow;

/// The way to a triangle that is known bounds the search for the nearest one; this share more is far above rounding.
const REACH_ROUNDING: f64 = 1e-9;

/// The layers of a part in build order, ready for questions about what is built by now.
#[derive(Debug)]
pub struct LayerStack<'a> {
    pub(crate) layers: Vec<Built<'a>>,
    pub(crate) tree: Tree,
    /// The mould has 0, layers have their number from 1: see [`of_layer`].
    pub(crate) keys: Keys,
    /// For each layer and vertex the mean normal of the triangles around it, weighted by area; zero where they cancel.
    pub(super) normals: Vec<Vec<Vector3<f64>>>,
    /// Edges of the boundaries, those at the corners of a triangle together.
    pub(crate) rims: Vec<[Point3<f64>; 2]>,
    /// Directions that are known ([`LayerStack::with_hints`]).
    pub(crate) hints: DirectionHints,
    pub(crate) mould: Option<MouldBody>,
}

/// A mould that layers stand on, beside its triangles in the tree.
#[derive(Debug)]
pub(crate) struct MouldBody {
    /// Lower and upper corner of a box around it, half of its thickness included.
    pub bounds: [Point3<f64>; 2],
    /// Corners of its triangles as they were given, and the normals of its vertices as those of a layer.
    pub triangles: Vec<[u32; 3]>,
    pub normals: Vec<Vector3<f64>>,
}

/// The surface of a layer at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
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
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerStack, StackError};
    /// use curvlay_toolpath::nalgebra::Point3;
    /// let vertices = [[0.0, 0.0, 0.4], [9.0, 0.0, 0.4], [0.0, 9.0, 0.4]].map(Point3::from);
    /// let layer = BuiltLayer { vertices: &vertices, triangles: &[[0, 1, 2]], spacing: &[0.8], curves: &[] };
    /// assert_eq!(LayerStack::new(&[layer])?.triangles(), 1);
    /// let thin = BuiltLayer { spacing: &[0.0], ..layer };
    /// let error = StackError::BadSpacing { layer: 0, triangle: 0, spacing: 0.0 };
    /// assert_eq!(LayerStack::new(&[thin]).unwrap_err(), error);
    /// # Ok::<(), StackError>(())
    /// ```
    pub fn new(layers: &[BuiltLayer<'a>]) -> Result<Self, StackError> {
        let built = |&BuiltLayer { vertices, triangles, spacing, curves }: &BuiltLayer<'a>| Built {
            vertices,
            triangles,
            spacing,
            curves: curves.iter().copied().map(BuiltCurve::Given).collect(),
        };
        LayerStack::of(layers.iter().map(built).collect())
    }

    /// The same of surfaces and the paths that fill them.
    pub(crate) fn of_paths(
        layers: impl Iterator<Item = (LayerSurface<'a>, &'a [SurfacePath])>,
    ) -> Result<Self, StackError> {
        let built = |(LayerSurface { vertices, triangles, thickness, .. }, paths): (_, &'a [SurfacePath])| Built {
            vertices,
            triangles,
            spacing: thickness,
            curves: paths.iter().map(BuiltCurve::Path).collect(),
        };
        LayerStack::of(layers.map(built).collect())
    }

    fn of(layers: Vec<Built<'a>>) -> Result<Self, StackError> {
        let triangles = layers.iter().map(|layer| layer.triangles.len()).sum();
        if triangles > MAX_TRIANGLES {
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

    /// Unit normals at the corners of a triangle: those of its vertices, shared by the triangles around them; its own where these cancel.
    pub(crate) fn corner_normals(&self, triangle: &Triangle) -> [Vector3<f64>; 3] {
        let (triangles, normals) = match (triangle.layer, &self.mould) {
            (MOULD, Some(mould)) => (&mould.triangles[..], &mould.normals[..]),
            (layer, _) => (self.layers[layer as usize].triangles, &self.normals[layer as usize][..]),
        };
        let of_vertex = |v: u32| Some(normals[v as usize]).filter(|normal| normal.norm_squared() > 0.5);
        triangles[triangle.index as usize].map(|v| of_vertex(v).unwrap_or_else(|| triangle.normal().normalize()))
    }

    /// The surface of a layer near `p`. The layer has curves, so it has a surface. `near` is a triangle of the layer that may be near, and
    /// becomes the one found: it only bounds the search.
    pub(crate) fn ground(&self, layer: u32, p: Point3<f64>, near: &mut Option<usize>) -> Option<Ground> {
        let search = |reach: f64| self.tree.nearest(&self.keys, p, of_layer(layer), reach, |_, _| true);
        let to = |&triangle: &usize| {
            (on_triangle(&self.tree.triangles()[triangle].corners, p) - p).norm() * (1.0 + REACH_ROUNDING)
        };
        let found = near.as_ref().map(to).and_then(search).or_else(|| search(f64::INFINITY))?;
        *near = Some(found.triangle);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_does_not_depend_on_what_was_near_before() {
        // Two layers over a wavy grid: slow twin is the search without a bound.
        let place = |z: f64, k: u32| {
            let [x, y] = [f64::from(k % 9), f64::from(k / 9)];
            Point3::new(x, y, z + 0.3 * x.sin() * (0.7 * y).cos())
        };
        let halves = |k: u32| [[k, k + 1, k + 10], [k, k + 10, k + 9]];
        let triangles: Vec<[u32; 3]> = (0..72).filter(|k| k % 9 < 8).flat_map(halves).collect();
        let spacing = vec![0.5; triangles.len()];
        let vertices = [0.5, 1.0].map(|z| (0..81).map(|k| place(z, k)).collect::<Vec<_>>());
        let layers = [0, 1].map(|layer: usize| BuiltLayer {
            vertices: &vertices[layer],
            triangles: &triangles,
            spacing: &spacing,
            curves: &[],
        });
        let stack = LayerStack::new(&layers).unwrap();
        let mut near = [None; 2];
        for k in 0..2000_u32 {
            let p = Point3::new(f64::from(k * 37 % 101) / 12.0, f64::from(k * 11 % 103) / 12.0, f64::from(k % 7) / 5.0);
            for layer in [0, 1] {
                let found = stack.ground(layer, p, &mut near[layer as usize]).unwrap();
                let wanted = stack.ground(layer, p, &mut None).unwrap();
                assert_eq!((found.normal, found.height), (wanted.normal, wanted.height));
            }
        }
    }
}
