//! From oriented paths to paths without gouging.

use super::error::GougingError;
use super::nozzle::Nozzle;
use super::options::GougingOptions;
use super::order::{Resolving, Run};
use super::resolved::ResolvedPaths;
use crate::ProgressFn;
use crate::layer::LayerStack;
use crate::orientation::{ToolPath, Turns, Waypoint};

impl LayerStack<'_> {
    /// Tilts the nozzle where it would gouge what is built by then.
    ///
    /// # Arguments
    /// * `paths`: of these layers, in the order in which they are printed.
    /// * `progress`: called with the stages `built` and `gouging`, once more for layers whose order is changed; may cancel.
    ///
    /// # Errors
    /// [`GougingError`].
    ///
    /// # Cost
    /// Some 30 microseconds for a waypoint on the layers of a real part, one in thirty of which gouges. With the
    /// feature `rayon` paths are shared out among threads; the result is the same.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::gouging::{Gouge, GougingError, GougingOptions, LeftOut, Nozzle, NozzlePart, Obstacle, ResolvedPaths};
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack, Mould};
    /// use curvlay_toolpath::orientation::{OrientOptions, SharpTurn, ToolPath, Turns, Waypoint};
    /// use std::ops::ControlFlow;
    /// let silent = |_: curvlay_toolpath::Progress| ControlFlow::Continue(());
    /// // A wall of 6 mm, and a line beside its foot, 2 mm away.
    /// let wall = [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 20.0, 6.0], [0.0, 0.0, 6.0]].map(Point3::from);
    /// let floor = [[0.0, 0.0, 0.4], [9.0, 0.0, 0.4], [9.0, 20.0, 0.4], [0.0, 20.0, 0.4]].map(Point3::from);
    /// let line = [Point3::new(2.0, 5.0, 0.4), Point3::new(2.0, 15.0, 0.4)];
    /// let curves = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &[], closed: false }];
    /// let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    /// let layers = [(&wall, &[][..]), (&floor, &curves[..])].map(|(vertices, curves)| BuiltLayer {
    ///     vertices, triangles: &triangles, spacing: &spacing, curves,
    /// });
    /// let stack = LayerStack::new(&layers)?;
    /// let oriented = stack.orient(&OrientOptions::default(), &silent)?;
    /// let resolved = stack.resolve_gouging(oriented.paths, &Nozzle::default(), &GougingOptions::default(), &silent)?;
    /// // Upright, the side of the cone would cut into the wall; it leans away until it is clear.
    /// assert_eq!((resolved.gouging_before, resolved.left.len()), (11, 0));
    /// let axis = resolved.paths[0].waypoints[5].axis;
    /// assert!(axis.x > 0.3 && axis.y.abs() < 0.05, "{axis:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resolve_gouging(
        &self,
        paths: Vec<ToolPath>,
        nozzle: &Nozzle,
        options: &GougingOptions,
        progress: ProgressFn,
    ) -> Result<ResolvedPaths, GougingError> {
        options.check()?;
        self.check_paths(&paths)?;
        let Run { places, gouging_before, left_out } =
            Resolving { stack: self, nozzle, options, progress }.run(paths)?;
        let mut resolved = ResolvedPaths::none(places.len());
        (resolved.gouging_before, resolved.left_out) = (gouging_before, left_out);
        places.into_iter().for_each(|place| resolved.take(place));
        resolved.mean_tilt /= resolved.tilted.max(1) as f64;
        resolved.turns = Turns::of(&resolved.paths);
        Ok(resolved)
    }

    /// Whether paths can be those of these layers.
    pub(crate) fn check_paths(&self, paths: &[ToolPath]) -> Result<(), GougingError> {
        let waypoints = paths.iter().map(|path| path.waypoints.len()).sum();
        if waypoints > 1 << 31 {
            return Err(GougingError::TooLarge { waypoints });
        }
        let mut last = 0;
        for (number, path) in paths.iter().enumerate() {
            let layers = self.layers.len();
            if path.layer < last || path.layer as usize >= layers {
                return Err(GougingError::Layer { path: number, layer: path.layer, layers });
            }
            last = path.layer;
            if path.waypoints.len() < 2 {
                return Err(GougingError::FewWaypoints { path: number, waypoints: path.waypoints.len() });
            }
            let sound = |w: &Waypoint| {
                let numbers = [w.width, w.height, w.arc];
                let unit = (w.axis.norm_squared() - 1.0).abs() < 1e-6;
                unit && numbers.iter().chain(w.position.iter()).all(|n| n.abs() < 1e9)
            };
            if let Some(waypoint) = path.waypoints.iter().position(|w| !sound(w)) {
                return Err(GougingError::BadWaypoint { path: number, waypoint });
            }
        }
        Ok(())
    }
}
