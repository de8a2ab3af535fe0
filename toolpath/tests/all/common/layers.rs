//! Layers of a part that tests own.

use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack};
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Unit, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;

/// A curve: its points, the width of its bead, whether it is closed.
pub type Curve = (Vec<Point3<f64>>, f64, bool);

/// A layer with one spacing.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    pub spacing: f64,
    pub curves: Vec<Curve>,
}

impl Layer {
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]], spacing: f64) -> Self {
        Layer { vertices: vertices.to_vec(), triangles: triangles.to_vec(), spacing, curves: Vec::new() }
    }

    /// A parallelogram cut into `n` by `n` parts; counter-clockwise from `u` to `v`.
    pub fn sheet(corner: [f64; 3], u: [f64; 3], v: [f64; 3], n: u32, spacing: f64) -> Self {
        let (corner, u, v) = (Point3::from(corner), Vector3::from(u), Vector3::from(v));
        let at = |i: u32, j: u32| i + (n + 1) * j;
        let share = |k: u32| f64::from(k) / f64::from(n);
        let cells = || (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let vertices = cells().map(|(i, j)| corner + u * share(i) + v * share(j)).collect();
        let inner = cells().filter(|&(i, j)| i < n && j < n);
        let triangles = inner
            .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
            .collect();
        Layer { vertices, triangles, spacing, curves: Vec::new() }
    }

    /// This layer and another as one.
    pub fn and(mut self, other: &Layer) -> Self {
        let before = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + before)));
        self
    }

    pub fn with(mut self, points: &[[f64; 3]], width: f64) -> Self {
        self.curves.push((points.iter().map(|&p| p.into()).collect(), width, false));
        self
    }

    pub fn moved(&self, by: &Isometry3<f64>) -> Self {
        let mut moved = self.clone();
        moved.vertices.iter_mut().for_each(|p| *p = by * *p);
        moved.curves.iter_mut().for_each(|curve| curve.0.iter_mut().for_each(|p| *p = by * *p));
        moved
    }
}

/// Lends the stack of some layers.
pub fn with_stack<T>(layers: &[Layer], work: impl FnOnce(&LayerStack) -> T) -> T {
    with_own_stack(layers, |stack| work(&stack))
}

/// Hands the stack of some layers over.
pub fn with_own_stack<T>(layers: &[Layer], work: impl FnOnce(LayerStack) -> T) -> T {
    let spacing: Vec<Vec<f64>> = layers.iter().map(|layer| vec![layer.spacing; layer.triangles.len()]).collect();
    let widths: Vec<Vec<Vec<f64>>> =
        layers.iter().map(|layer| layer.curves.iter().map(|c| vec![c.1; c.0.len()]).collect()).collect();
    let curves: Vec<Vec<LayerCurve>> = layers
        .iter()
        .zip(&widths)
        .map(|(layer, widths)| {
            let each = layer.curves.iter().zip(widths);
            each.map(|(c, widths)| LayerCurve { points: &c.0, widths, kinds: &[], closed: c.2 }).collect()
        })
        .collect();
    let built: Vec<BuiltLayer> = layers
        .iter()
        .enumerate()
        .map(|(k, layer)| BuiltLayer {
            vertices: &layer.vertices,
            triangles: &layer.triangles,
            spacing: &spacing[k],
            curves: &curves[k],
        })
        .collect();
    work(LayerStack::new(&built).unwrap())
}

/// A path of waypoints on a layer: tips and directions of any length.
pub fn path(layer: u32, waypoints: &[(Point3<f64>, Vector3<f64>)]) -> ToolPath {
    let mut arc = 0.0;
    let mut last: Option<Point3<f64>> = None;
    let waypoint = |&(tip, direction): &(Point3<f64>, Vector3<f64>)| {
        arc += last.map_or(0.0, |last| (tip - last).norm());
        last = Some(tip);
        Waypoint {
            position: tip,
            axis: Unit::new_normalize(direction),
            width: 0.8,
            height: 0.8,
            arc,
            added: false,
            lift: Vector3::zeros(),
            kind: BeadKind::Wall,
        }
    };
    ToolPath { layer, curve: 0, closed: false, waypoints: waypoints.iter().map(waypoint).collect() }
}
