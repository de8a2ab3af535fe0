//! What is there before the first layer.

use super::built::{Built, MAX_COORDINATE_MM, MAX_TRIANGLES, Prepared, prepare, sound, unknown_corner};
use super::error::{MouldError, StackError};
use super::keys::{below_layer, keys_by_layer};
use super::stack::{LayerStack, MouldBody};
use super::tree::{Keys, Tree};
use super::triangle::{MOULD, Triangle};
use nalgebra::{Point3, Vector3};

/// A mould, or a part that exists already.
#[derive(Clone, Copy, Debug)]
pub struct Mould<'a> {
    /// Points of its surface in millimetres.
    pub vertices: &'a [Point3<f64>],
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// The nozzle is held against the surface as if that were a layer of this thickness in millimetres: half of it lies outside, and may be
    /// entered by the share that is allowed for layers. So with a quarter the nozzle keeps a quarter of it off the surface. About the height of a layer.
    pub thickness: f64,
}

impl Mould<'_> {
    /// Its triangles that have an area.
    fn prepared(&self) -> Result<Prepared, MouldError> {
        self.check()?;
        let &Mould { vertices, triangles, thickness } = self;
        let spacing = vec![thickness; triangles.len()];
        let prepared = prepare(MOULD, &Built { vertices, triangles, spacing: &spacing, curves: Vec::new() });
        if prepared.triangles.is_empty() { Err(MouldError::NoArea) } else { Ok(prepared) }
    }

    fn check(&self) -> Result<(), MouldError> {
        let &Mould { vertices, triangles, thickness } = self;
        if !(thickness > 0.0 && thickness <= MAX_COORDINATE_MM) {
            return Err(MouldError::BadThickness { thickness });
        }
        if let Some(vertex) = vertices.iter().position(|p| !sound(p)) {
            return Err(MouldError::BadVertex { vertex });
        }
        let vertices = vertices.len();
        match unknown_corner(triangles, vertices) {
            Some((triangle, vertex)) => Err(MouldError::NoSuchVertex { triangle, vertex, vertices }),
            None => Ok(()),
        }
    }
}

/// The surface of a mould, to look places of it up.
#[derive(Debug)]
pub(crate) struct MouldSurface {
    tree: Tree,
    keys: Keys,
}

impl MouldSurface {
    pub fn new(mould: &Mould) -> Result<Self, MouldError> {
        let tree = Tree::new(mould.prepared()?.triangles);
        let keys = keys_by_layer(&tree);
        Ok(MouldSurface { tree, keys })
    }

    /// Whether the point of some triangle that is nearest to `p` is within reach, and is accepted with the normal there.
    pub fn has(&self, p: Point3<f64>, reach: f64, accept: impl Fn(Point3<f64>, Vector3<f64>) -> bool) -> bool {
        let accept = |at: Point3<f64>, triangle: &Triangle| accept(at, triangle.normal().normalize());
        self.tree.nearest(&self.keys, p, below_layer(0), reach, accept).is_some()
    }
}

impl LayerStack<'_> {
    /// The same layers on a mould, or on a part that exists already: the nozzle must not run into it, beads of the first layers are laid away from it, and
    /// travels keep clear of it.
    ///
    /// # Errors
    /// [`StackError::Mould`].
    ///
    /// # Cost
    /// That of [`LayerStack::new`].
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack, Mould, MouldError, StackError};
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::orientation::OrientOptions;
    /// use std::ops::ControlFlow;
    /// let silent = |_: curvlay_toolpath::Progress| ControlFlow::Continue(());
    /// // A ramp of 45 degrees, and a layer of 0.8 mm on it: half of that from its middle to the ramp.
    /// let ramp = |x: f64, y: f64, over: f64| Point3::new(x, y, x + over * 2_f64.sqrt());
    /// let square = |over: f64| [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]].map(|[x, y]| ramp(x, y, over));
    /// let (mould, layer, triangles) = (square(0.0), square(0.4), [[0, 1, 2], [0, 2, 3]]);
    /// let line = [ramp(5.0, 10.0, 0.4), ramp(15.0, 10.0, 0.4)];
    /// let curves = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &[], closed: false }];
    /// let layers = [BuiltLayer { vertices: &layer, triangles: &triangles, spacing: &[0.8; 2], curves: &curves }];
    /// let stack = LayerStack::new(&layers)?.on_mould(&Mould { vertices: &mould, triangles: &triangles, thickness: 0.8 })?;
    /// let oriented = stack.orient(&OrientOptions::default(), &silent)?;
    /// let away = Vector3::new(-1.0, 0.0, 1.0).normalize();
    /// assert!(oriented.paths[0].waypoints.iter().all(|at| (at.axis.into_inner() - away).norm() < 1e-9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on_mould(self, mould: &Mould) -> Result<Self, StackError> {
        let Prepared { triangles: of_mould, normals, mut rims } = mould.prepared()?;
        let before = rims.len() as u32;
        rims.extend(self.rims);
        let of_layers = self.tree.triangles().iter();
        let mut all = of_mould.clone();
        all.extend(of_layers.map(|triangle| Triangle { rims: triangle.rims.map(|k| k + before), ..*triangle }));
        // As if the mould were a layer before the first: what is found does not depend on how it came to be there.
        all.sort_unstable_by_key(|triangle| (triangle.layer.wrapping_add(1), triangle.index));
        if all.len() > MAX_TRIANGLES {
            return Err(MouldError::TooLarge { triangles: all.len() }.into());
        }
        let corners = || of_mould.iter().flat_map(|triangle| triangle.corners);
        let half = Vector3::repeat(mould.thickness / 2.0);
        let low = corners().fold(Point3::from([f64::INFINITY; 3]), |low, p| low.inf(&p)) - half;
        let high = corners().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, p| high.sup(&p)) + half;
        let tree = Tree::new(all);
        let keys = keys_by_layer(&tree);
        let mould = MouldBody { bounds: [low, high], triangles: mould.triangles.to_vec(), normals };
        Ok(LayerStack { tree, keys, rims, mould: Some(mould), ..self })
    }
}
