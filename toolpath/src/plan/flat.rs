//! A whole print whose layers are flat: the nozzle stands along the normal of each.
//!
//! Dai 2020, section 2.4: parts are printed in flat layers, each along a direction of its own. Curves, gouging, travels and deposition are those
//! of [`LayerStack::plan`]; only the directions are given, not found. Where the nozzle would be in what is built it is tilted or the piece
//! left out, as [`GougingOptions`](crate::gouging::GougingOptions) says.

use super::print::{PrintError, PrintOptions, PrintPlan};
use crate::deposit::deposit_along;
use crate::gouging::Nozzle;
use crate::layer::LayerStack;
use crate::orientation::{OrientOptions, ToolPath, Turns};
use crate::{Progress, ProgressFn};
use nalgebra::UnitVector3;
use std::ops::ControlFlow;

impl LayerStack<'_> {
    /// Plans the print of these layers, the nozzle along the given direction of each.
    ///
    /// # Arguments
    /// * `directions`: of each layer, from the surface into the nozzle.
    /// * `progress`: as for [`LayerStack::plan`].
    ///
    /// # Errors
    /// [`PrintError`]; [`PrintError::SurfaceCount`] for another number of directions than layers.
    ///
    /// # Cost
    /// That of [`LayerStack::plan`].
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::gouging::Nozzle;
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack};
    /// use curvlay_toolpath::plan::PrintOptions;
    /// use std::ops::ControlFlow;
    /// // A line on an upright square, printed sideways.
    /// let vertices = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]].map(|[y, z]| Point3::new(0.4, y, z + 9.0));
    /// let line = [Point3::new(0.4, 1.0, 14.0), Point3::new(0.4, 9.2, 14.0)];
    /// let curves = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &[], closed: false }];
    /// let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    /// let layers = [BuiltLayer { vertices: &vertices, triangles: &triangles, spacing: &spacing, curves: &curves }];
    /// let (nozzle, options) = (Nozzle::default(), PrintOptions::default());
    /// let plan = LayerStack::new(&layers)?.plan_along(&[Vector3::x_axis()], &nozzle, &options, &|_| ControlFlow::Continue(()))?;
    /// let first = plan.resolved.paths[0].waypoints[0];
    /// assert_eq!((first.position, first.axis), (Point3::new(0.8, 1.0, 14.0), Vector3::x_axis()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn plan_along(
        &self,
        directions: &[UnitVector3<f64>],
        nozzle: &Nozzle,
        options: &PrintOptions,
        progress: ProgressFn,
    ) -> Result<PrintPlan, PrintError> {
        if directions.len() != self.layers.len() {
            return Err(PrintError::SurfaceCount { surfaces: directions.len(), layers: self.layers.len() });
        }
        let begin = |stage: &'static str| match progress(Progress { stage, done: 0, total: 0 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(PrintError::Cancelled),
        };
        begin("orient")?;
        // No waypoint is put in for turns that are not made.
        let unturned = OrientOptions { wave: 0.0, max_turn: std::f64::consts::PI, lift: 0.0, ..options.orient };
        let mut paths = self.orient(&unturned, progress)?.paths;
        paths.iter_mut().for_each(|path| stand(path, directions[path.layer as usize], options.orient.lift));
        let before = Turns::of(&paths);
        begin("gouging")?;
        let resolved = self.resolve_gouging(paths, nozzle, &options.gouging, progress)?;
        begin("travel")?;
        let travels = self.travels(&resolved.paths, nozzle, &options.travel, progress)?;
        begin("deposit")?;
        let deposition = deposit_along(&resolved.paths, &travels.ways, &options.deposition)?;
        Ok(PrintPlan { before, resolved, travels, deposition })
    }
}

/// Gives all waypoints a direction, and lifts the tip along it from the surface, in heights of the layer.
fn stand(path: &mut ToolPath, direction: UnitVector3<f64>, lift: f64) {
    for waypoint in &mut path.waypoints {
        waypoint.axis = direction;
        waypoint.position += direction.into_inner() * (lift * waypoint.height);
    }
}
