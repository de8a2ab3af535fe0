//! Where a nozzle goes along the curves of curved layers, and which way it stands.
//!
//! Takes the curves of a [`LayerStack`]; gives [`ToolPath`]s of [`Waypoint`]s ([`LayerStack::orient`]).
//!
//! Dai 2020, section 3.5.2. Step by step, for each curve:
//!
//! 1. `resample`: points an even step apart along it; corners stay.
//! 2. `toward`: the direction away from the closest point of what is built below.
//! 3. `steady`: short waves of these directions are taken out.
//! 4. `smooth`: a low-pass where neighbours differ by more than a threshold, then more points where they still do.
//! 5. `share`: where beads cover the same place, each gets a share of it.
//! 6. The tip is lifted from the surface, which runs through the middle of the layer, to the top of the bead.
//!
//! The nozzle is not looked at yet: see [`LayerStack::resolve_gouging`] for that.

mod pose;
mod resample;
mod share;
mod smooth;
mod steady;
mod tool_path;
mod toward;

pub use pose::Pose;
pub(crate) use pose::{farthest, lean};
pub(crate) use smooth::{TURN_ROUNDING, along, angle, between, part_way};
pub use tool_path::{ToolPath, Waypoint};

use crate::ProgressFn;
use crate::layer::LayerStack;
use crate::parallel;
use nalgebra::Vector3;
use resample::Line;

/// Samples beyond this number are refused: the step is then a slip of the unit.
const MAX_SAMPLES: f64 = 1e8;

/// Least turn that may be asked for, in radians: 0.1 degrees. Below it a crest would take thousands of points.
pub(crate) const MIN_TURN: f64 = 0.1_f64.to_radians();

/// How paths are sampled and oriented.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct OrientOptions {
    /// Distance between points along a curve in millimetres: 1. It is evened out between corners.
    pub step: f64,
    /// Bends sharper than this are corners, on which a point stays: 30 degrees, in radians.
    pub corner: f64,
    /// Waves of the directions along a path that are shorter than this, in millimetres, are taken out: 20. One of this length
    /// keeps half its height; with 0 all stay. An arm has to follow each of them with its wrist.
    pub wave: f64,
    /// A direction changes by no more than this for that: 25 degrees, in radians.
    pub max_tilt: f64,
    /// Directions of neighbours may differ by this: 10 degrees, in radians.
    pub max_turn: f64,
    /// How often directions that differ by more are filtered before points are added: 8. More rounds spread a turn
    /// over more of the path and need fewer points.
    pub low_pass_rounds: usize,
    /// How far the tip stands above the surface of the layer, along its direction, in heights of the layer: 0.5, the top
    /// of the bead, since surfaces run through the middle of layers.
    pub lift: f64,
    /// Whether beads that cover the same place share it: yes. Widths are then what each gets of the surface by its length,
    /// and the volume of the beads is that of the layer where it is covered. Otherwise widths are those given.
    pub share: bool,
}

impl Default for OrientOptions {
    fn default() -> Self {
        OrientOptions {
            step: 1.0,
            corner: 30_f64.to_radians(),
            wave: 20.0,
            max_tilt: 25_f64.to_radians(),
            max_turn: 10_f64.to_radians(),
            low_pass_rounds: 8,
            lift: 0.5,
            share: true,
        }
    }
}

/// How much directions turn between neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Turns {
    /// Pairs of neighbours.
    pub steps: usize,
    /// The largest turn, in radians.
    pub largest: f64,
    /// The mean turn, in radians.
    pub mean: f64,
    /// The largest turn on a millimetre of the way of the tip, in radians; of neighbours that are farther apart their turn by their distance.
    pub max_per_mm: f64,
}

impl Turns {
    /// The turns along paths.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::orientation::{ToolPath, Turns, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// let waypoint = |axis| Waypoint { position: Point3::origin(), axis, width: 0.8, height: 0.8, arc: 0.0, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall };
    /// let waypoints = [Vector3::z_axis(), Vector3::z_axis(), Vector3::x_axis()].map(waypoint).to_vec();
    /// let turns = Turns::of(&[ToolPath { layer: 0, curve: 0, closed: false, waypoints }]);
    /// assert_eq!((turns.steps, turns.largest.to_degrees(), turns.mean.to_degrees()), (2, 90.0, 45.0));
    /// ```
    pub fn of(paths: &[ToolPath]) -> Turns {
        let mut turns = Turns::default();
        let mut sum = 0.0;
        for pair in paths.iter().flat_map(|path| path.waypoints.windows(2)) {
            let turn = angle(&pair[0].axis, &pair[1].axis);
            turns.steps += 1;
            turns.largest = turns.largest.max(turn);
            sum += turn;
        }
        for path in paths {
            for (k, from) in path.waypoints.iter().enumerate() {
                let mut way = 0.0;
                for (next, pair) in path.waypoints[k..].windows(2).enumerate() {
                    way += (pair[1].position - pair[0].position).norm();
                    if way > 1.0 && next > 0 {
                        break;
                    }
                    let turn = angle(&from.axis, &pair[1].axis);
                    turns.max_per_mm = turns.max_per_mm.max(turn / f64::max(way, 1.0));
                }
            }
        }
        if turns.steps > 0 {
            turns.mean = sum / turns.steps as f64;
        }
        turns
    }
}

/// Neighbours whose directions differ by more than they should.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpTurn {
    /// The path, by its place in the list of paths.
    pub path: usize,
    /// The first of the two waypoints.
    pub waypoint: usize,
    /// Their angle, in radians.
    pub angle: f64,
}

/// Oriented paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Oriented {
    /// In the order in which they are printed: layer by layer, curve by curve.
    pub paths: Vec<ToolPath>,
    /// As the closest points have it.
    pub before: Turns,
    /// After the low-pass and with the points added.
    pub after: Turns,
    /// Waypoints that were added.
    pub added: usize,
    /// Samples without a closest point below: their direction is the normal of the layer.
    pub by_normal: usize,
    /// Neighbours that still differ by more than the limit: those with opposite directions, between which no turn is
    /// the shortest one.
    pub sharp: Vec<SharpTurn>,
}

/// Why paths are not oriented.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrientError {
    /// An option is out of its range.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The step makes too many samples; check the unit.
    #[error("a step of {step} mm on curves of {length} mm: more than 100 million samples")]
    TooFine {
        /// The step.
        step: f64,
        /// Length of all curves.
        length: f64,
    },
    /// The normals around a sample cancel out, so it has no direction.
    #[error(
        "the surface of layer {layer} has no normal at {arc} mm of curve {curve}: its triangles face opposite sides"
    )]
    NoNormal {
        /// The layer, from 0.
        layer: usize,
        /// The curve, from 0.
        curve: usize,
        /// Length along the curve.
        arc: f64,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl OrientOptions {
    fn check(&self) -> Result<(), OrientError> {
        let turn = "an angle of 0.1 to 180 degrees, in radians";
        let sound = [
            ("step", self.step, self.step > 0.0 && self.step.is_finite(), "above 0 and finite"),
            ("corner", self.corner, (MIN_TURN..=std::f64::consts::PI).contains(&self.corner), turn),
            ("wave", self.wave, self.wave >= 0.0 && self.wave.is_finite(), "0 or more, and finite"),
            (
                "max_tilt",
                self.max_tilt,
                (0.0..=std::f64::consts::PI).contains(&self.max_tilt),
                "0 to 180 degrees, in radians",
            ),
            ("max_turn", self.max_turn, (MIN_TURN..=std::f64::consts::PI).contains(&self.max_turn), turn),
            ("lift", self.lift, (0.0..=1.0).contains(&self.lift), "0 to 1 heights of the layer"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, wanted)) => Err(OrientError::Option { option, value, wanted }),
            None => Ok(()),
        }
    }
}

/// A curve on its way.
struct Sampled {
    waypoints: Vec<Waypoint>,
    by_normal: usize,
}

impl LayerStack<'_> {
    /// Samples the curves of all layers and gives each point the direction in which the nozzle stands.
    ///
    /// # Arguments
    /// * `progress`: called with the stages `orient` and `share`; may cancel.
    ///
    /// # Errors
    /// [`OrientError`].
    ///
    /// # Cost
    /// `O(log n)` for each sample and `n` triangles, some 10 microseconds. With the feature `rayon` curves are shared out among
    /// threads; the result is the same.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack};
    /// use curvlay_toolpath::orientation::OrientOptions;
    /// use std::ops::ControlFlow;
    /// // A square of 10 mm, half a layer above the plate, and a line of 8.2 mm on it.
    /// let vertices = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]].map(|[x, y]| Point3::new(x, y, 0.4));
    /// let line = [Point3::new(1.0, 5.0, 0.4), Point3::new(9.2, 5.0, 0.4)];
    /// let curves = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &[], closed: false }];
    /// let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    /// let layer = BuiltLayer { vertices: &vertices, triangles: &triangles, spacing: &spacing, curves: &curves };
    /// let layers = [layer];
    /// let stack = LayerStack::new(&layers)?;
    /// let oriented = stack.orient(&OrientOptions::default(), &|_| ControlFlow::Continue(()))?;
    /// let waypoints = &oriented.paths[0].waypoints;
    /// assert_eq!(waypoints.len(), 9); // steps of 1.025 mm
    /// assert_eq!((waypoints[0].position, waypoints[0].axis), (Point3::new(1.0, 5.0, 0.8), Vector3::z_axis()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn orient(&self, options: &OrientOptions, progress: ProgressFn) -> Result<Oriented, OrientError> {
        options.check()?;
        let each = |layer: usize| (0..self.layers[layer].curves.len()).map(move |curve| (layer, curve));
        let curves: Vec<(usize, usize)> = (0..self.layers.len()).flat_map(each).collect();
        let length: f64 = curves.iter().map(|&(layer, curve)| self.line(layer, curve).length()).sum();
        if length / options.step > MAX_SAMPLES {
            return Err(OrientError::TooFine { step: options.step, length });
        }
        let work = |_: usize, &(layer, curve): &(usize, usize)| self.sampled(layer, curve, options);
        let sampled = parallel::map(&curves, "orient", progress, work).ok_or(OrientError::Cancelled)?;
        let mut oriented = Oriented {
            paths: Vec::with_capacity(curves.len()),
            before: Turns::default(),
            after: Turns::default(),
            added: 0,
            by_normal: 0,
            sharp: Vec::new(),
        };
        for (&(layer, curve), sampled) in curves.iter().zip(sampled) {
            let Sampled { waypoints, by_normal } = sampled?;
            oriented.by_normal += by_normal;
            let closed = self.layers[layer].curves[curve].is_closed();
            oriented.paths.push(ToolPath { layer: layer as u32, curve: curve as u32, closed, waypoints });
        }
        oriented.before = Turns::of(&oriented.paths);
        for path in &mut oriented.paths {
            let samples = path.waypoints.len();
            smoothed(path, options);
            oriented.added += path.waypoints.len() - samples;
        }
        if options.share {
            self.share(&mut oriented.paths, progress).ok_or(OrientError::Cancelled)?;
        }
        for waypoint in oriented.paths.iter_mut().flat_map(|path| &mut path.waypoints) {
            waypoint.position += waypoint.axis.into_inner() * (options.lift * waypoint.height);
        }
        oriented.after = Turns::of(&oriented.paths);
        oriented.sharp = sharp_turns(&oriented.paths, options.max_turn);
        Ok(oriented)
    }

    /// Widths, layer by layer; `None` if cancelled.
    fn share(&self, paths: &mut [ToolPath], progress: ProgressFn) -> Option<()> {
        let of_layers: Vec<&[ToolPath]> = paths.chunk_by(|a, b| a.layer == b.layer).collect();
        let work = |_: usize, paths: &&[ToolPath]| share::widths(self, paths);
        let widths = parallel::map(&of_layers, "share", progress, work)?;
        let waypoints = paths.iter_mut().flat_map(|path| &mut path.waypoints);
        waypoints.zip(widths.into_iter().flatten()).for_each(|(waypoint, width)| waypoint.width = width);
        Some(())
    }

    fn line(&self, layer: usize, curve: usize) -> Line {
        Line::new(&self.layers[layer].curves[curve])
    }

    /// The samples of a curve, on the surface, with raw directions.
    fn sampled(&self, layer: usize, curve: usize, options: &OrientOptions) -> Result<Sampled, OrientError> {
        let line = self.line(layer, curve);
        let mut sampled = Sampled { waypoints: Vec::new(), by_normal: 0 };
        let mut triangle = None;
        for arc in line.samples(options.step, options.corner) {
            let (tip, width, kind) = line.at(arc);
            let no_normal = OrientError::NoNormal { layer, curve, arc };
            let ground = self.ground(layer as u32, tip, &mut triangle).ok_or(no_normal)?;
            let normal = ground.normal.ok_or(no_normal)?;
            let (direction, by_point) = toward::toward(self, layer as u32, tip, &ground, normal);
            sampled.by_normal += usize::from(!by_point);
            sampled.waypoints.push(Waypoint {
                position: tip,
                axis: direction,
                width,
                height: ground.height,
                arc,
                added: false,
                lift: Vector3::zeros(),
                kind,
            });
        }
        Ok(sampled)
    }
}

/// Filters the directions of a path and adds points.
fn smoothed(path: &mut ToolPath, options: &OrientOptions) {
    let mut directions: Vec<_> = path.waypoints.iter().map(|waypoint| waypoint.axis).collect();
    let arcs: Vec<f64> = path.waypoints.iter().map(|waypoint| waypoint.arc).collect();
    steady::steady(&mut directions, &arcs, options.wave, options.max_tilt);
    smooth::low_pass(&mut directions, options.max_turn, options.low_pass_rounds);
    path.waypoints.iter_mut().zip(directions).for_each(|(waypoint, direction)| waypoint.axis = direction);
    let mut waypoints: Vec<Waypoint> = Vec::with_capacity(path.waypoints.len());
    for waypoint in &path.waypoints {
        if let Some(last) = waypoints.last().copied() {
            waypoints.extend(between(&last, waypoint, options.max_turn));
        }
        waypoints.push(*waypoint);
    }
    path.waypoints = waypoints;
}

/// All neighbours that differ by more than `limit`.
fn sharp_turns(paths: &[ToolPath], limit: f64) -> Vec<SharpTurn> {
    let of_path = |(path, waypoints): (usize, &ToolPath)| -> Vec<SharpTurn> {
        let turn = |(waypoint, pair): (usize, &[Waypoint])| {
            let angle = angle(&pair[0].axis, &pair[1].axis);
            (angle > limit + TURN_ROUNDING).then_some(SharpTurn { path, waypoint, angle })
        };
        waypoints.waypoints.windows(2).enumerate().filter_map(turn).collect()
    };
    paths.iter().enumerate().flat_map(of_path).collect()
}
