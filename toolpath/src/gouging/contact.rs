//! How deep a nozzle is in what is built, at any pose and any moment of the print.
//!
//! [`LayerStack::resolve_gouging`] asks this at waypoints. A machine also runs in, lifts off, and leaves its path a little between
//! waypoints. [`Contacts`] judges such poses by the same rule: a nozzle may enter what is built by then by
//! [`GougingOptions::allowed_depth`] of a layer, and may not reach below the plate. What is built by then is numbered in
//! `built`, where a nozzle is deepest is searched in `deepest`; both serve `resolve_gouging` as well, so the answers agree bit for bit.
//!
//! # Backing off
//! A nozzle that moves along its own direction, away from the tip, stays within the place that it had: it only widens from
//! tip to block, and the block reaches up without end. So a pose that is free stays free however far it is lifted along
//! its direction; over the plate as well if that does not point below the horizon. A search takes pieces smaller than a
//! fiftieth of a layer for their middle, so a lifted nozzle may be found deeper by that at most.
//!
//! # Legs
//! Samples along a leg are asked in ranges. A point of the nozzle at a distance `d` from the tip moves by `s + f d` at most
//! where the tip goes by `s` and the direction turns by `f`; a point that touches something is no farther from the tip than
//! `L`, the farthest point of a box around all that is built. So if a nozzle grown by `(s + f L) / 2` is free in the middle of a range, the
//! nozzle is free all along it (as in `travel`). Ranges for which this does not hold are halved, down to single samples.

use super::built::{after, before, built, touched};
use super::deepest::{Contact, Scene, Stand};
use super::error::GougingError;
use super::nozzle::Nozzle;
use super::options::GougingOptions;
use crate::ProgressFn;
use crate::layer::{Keys, LayerStack};
use crate::orientation::{Pose, ToolPath, angle, farthest, lean};
use crate::parallel;
use nalgebra::Point3;

/// More samples along a leg are refused: the step is then a slip of the unit.
const MAX_SAMPLES: f64 = 1e7;

/// Coordinates beyond this are refused, as for waypoints, in millimetres.
const MAX_COORDINATE_MM: f64 = 1e9;

/// When in the print.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// While a waypoint is being laid, as [`LayerStack::resolve_gouging`] sees it: with the beads of its path up to the last sample before.
    ///
    /// A leg from a waypoint to the next is asked at the first of the two. What is there only grows, so both its ends are
    /// free then if `resolve_gouging` found them free.
    At {
        /// The path, by its place in the list of paths.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// After a path is finished. The same as at the first waypoint of the next path.
    After {
        /// The path, by its place in the list of paths.
        path: usize,
    },
}

/// Why a question has no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContactError {
    /// A moment names a path that is not there.
    #[error("there is no path {path}: there are {paths}")]
    UnknownPath {
        /// The path, from 0.
        path: usize,
        /// Paths that there are.
        paths: usize,
    },
    /// A moment names a waypoint that is not there.
    #[error("there is no waypoint {waypoint} on path {path}: it has {waypoints}")]
    UnknownWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
        /// Waypoints of the path.
        waypoints: usize,
    },
    /// A pose that is not finite, beyond 1e9 mm, or without a unit direction.
    #[error("a pose at {} along {} is not finite or has no unit direction", .pose.tip, .pose.direction.into_inner())]
    BadPose {
        /// The pose.
        pose: Pose,
    },
    /// A step that is not a positive number.
    #[error("a step of {step_mm} mm: it must be above 0")]
    BadStep {
        /// The step.
        step_mm: f64,
    },
    /// The step makes too many samples.
    #[error("a step of {step_mm} mm makes {samples} samples of a leg: at most 1e7")]
    TooFine {
        /// The step.
        step_mm: f64,
        /// Samples that it makes.
        samples: f64,
    },
    /// The directions at the ends of a leg are opposite: no turn between them is the shortest one.
    #[error("the directions at the ends of a leg are opposite")]
    Opposite,
}

/// A print, ready for the question how deep a nozzle is: see [`LayerStack::contacts`].
#[derive(Debug)]
pub struct Contacts<'a> {
    stack: &'a LayerStack<'a>,
    /// When each triangle is built.
    keys: Keys,
    nozzle: Nozzle,
    allowed: f64,
    plate: Option<f64>,
    paths: Vec<Printed>,
}

/// What is there while a path is printed.
#[derive(Debug)]
struct Printed {
    /// At each waypoint the triangles with a key below this, and when the path is finished.
    before: Vec<u32>,
    after: u32,
    /// A box around all that.
    bounds: [Point3<f64>; 2],
}

/// A leg with samples at even shares.
struct Leg<'a> {
    scene: Scene<'a>,
    before: u32,
    allowed: f64,
    ends: [Pose; 2],
    /// How far any point of interest moves from sample to sample, at most.
    spacing: f64,
    samples: u32,
    work: Vec<(f64, u32)>,
    deepest: Option<(f64, Contact)>,
}

impl LayerStack<'_> {
    /// Prepares the question how deep a nozzle is in what is built, for any pose at any moment of a print.
    ///
    /// # Arguments
    /// * `paths`: of these layers, in the order in which they are printed, as [`LayerStack::resolve_gouging`] leaves them.
    /// * `options`: of these count `allowed_depth`, `own_layer`, `plate` and `plate_clearance`.
    /// * `progress`: called with the stage `built`; may cancel.
    ///
    /// # Errors
    /// [`GougingError`].
    ///
    /// # Cost
    /// A few microseconds for a waypoint. With the feature `rayon` paths are shared out among threads; the result is
    /// the same.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::gouging::{Contact, ContactError, Contacts, GougingError, GougingOptions, Moment, Nozzle, NozzlePart, Obstacle};
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerStack};
    /// use curvlay_toolpath::orientation::{Pose, ToolPath, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// use std::ops::ControlFlow;
    /// // A floor, and a wall of 3 mm on it that is printed later.
    /// let floor = [[-20.0, 0.0, 0.4], [20.0, 0.0, 0.4], [20.0, 20.0, 0.4], [-20.0, 20.0, 0.4]].map(Point3::from);
    /// let wall = [[0.0, 0.0, 0.8], [0.0, 20.0, 0.8], [0.0, 20.0, 3.8], [0.0, 0.0, 3.8]].map(Point3::from);
    /// let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    /// let layers = [&floor, &wall].map(|vertices| BuiltLayer { vertices, triangles: &triangles, spacing: &spacing, curves: &[] });
    /// let line = |layer: u32, x: f64, z: f64| {
    ///     let at = |y: f64| Waypoint {
    ///         position: Point3::new(x, y, z), axis: Vector3::z_axis(), width: 0.8, height: 0.8, arc: y, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall,
    ///     };
    ///     ToolPath { layer, curve: 0, closed: false, waypoints: vec![at(5.0), at(15.0)] }
    /// };
    /// let stack = LayerStack::new(&layers)?;
    /// let paths = [line(0, 2.0, 0.8), line(1, 0.0, 3.8)];
    /// let go_on = |_: curvlay_toolpath::Progress| ControlFlow::Continue(());
    /// let contacts = stack.contacts(&paths, &Nozzle::default(), &GougingOptions::default(), &go_on)?;
    /// // Two millimetres beside the wall: free until that stands. Then the cone is in it with its side.
    /// let pose = Pose { tip: Point3::new(2.0, 10.0, 0.8), direction: Vector3::z_axis() };
    /// assert!(contacts.is_free(Moment::After { path: 0 }, &pose)?);
    /// let contact = contacts.deepest(Moment::After { path: 1 }, &pose)?.expect("in the wall");
    /// assert_eq!((contact.obstacle, contact.part), (Obstacle::Layer(1), NozzlePart::Cone));
    /// // A quarter layer below the upper edge, 2.8 mm above the tip: the cone has a radius of 3.3 mm there, the side of the wall
    /// // less its skin is 1.8 mm away.
    /// assert!((contact.depth - (0.2 + (3.3 - 1.8) * 0.5_f64.sqrt())).abs() < 0.05, "{contact:?}");
    /// // Down along the axis onto the edge: deepest at the end, 0.6 mm below what is left without the skin.
    /// let [high, low] = [20.0, 3.0].map(|z| Pose { tip: Point3::new(0.4, 10.0, z), ..pose });
    /// let (share, contact) = contacts.deepest_along(Moment::After { path: 1 }, &high, &low, 0.1)?.expect("in the wall");
    /// assert!(share == 1.0 && (contact.depth - 0.8).abs() < 0.02, "{contact:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts(
        &self,
        paths: &[ToolPath],
        nozzle: &Nozzle,
        options: &GougingOptions,
        progress: ProgressFn,
    ) -> Result<Contacts<'_>, GougingError> {
        options.check()?;
        self.check_paths(paths)?;
        let work = |_: usize, path: &ToolPath| if options.own_layer { touched(self, path) } else { Vec::new() };
        let touched = parallel::map(paths, "built", progress, work).ok_or(GougingError::Cancelled)?;
        let keys = built(self, paths.iter().zip(touched.iter().map(Vec::as_slice))).keys;
        let boxes = self.boxes();
        let mut start = 0;
        let printed = |(k, path): (usize, &ToolPath)| {
            let before = before(&path.waypoints, start);
            start += path.waypoints.len() as u32;
            // Layers without paths are finished with the one before.
            let layer = paths.get(k + 1).map_or(boxes.len() - 1, |next| next.layer as usize);
            Printed { before, after: after(start), bounds: boxes[layer] }
        };
        let paths = paths.iter().enumerate().map(printed).collect();
        let (allowed, plate) = (options.allowed_depth, options.over_plate());
        Ok(Contacts { stack: self, keys, nozzle: *nozzle, allowed, plate, paths })
    }
}

impl Contacts<'_> {
    /// The deepest point of the nozzle at a pose; `None` where it is nowhere deeper than allowed. In a layer and below the plate,
    /// the deeper of both.
    ///
    /// # Errors
    /// [`ContactError`] for an unknown moment or a bad pose.
    ///
    /// # Cost
    /// Some 5 microseconds where it is free and 100 where it is not, at waypoints of a small part (bench `orientation`). Depths
    /// are exact to a fiftieth of a layer.
    ///
    /// # Example
    /// See [`LayerStack::contacts`].
    pub fn deepest(&self, moment: Moment, pose: &Pose) -> Result<Option<Contact>, ContactError> {
        let stand = Stand { tip: pose.tip, before: self.before(moment)?.0, allowed: self.allowed };
        check(pose)?;
        Ok(self.scene(&self.nozzle).deepest(stand, &pose.direction, &mut Vec::new()))
    }

    /// Whether [`Contacts::deepest`] finds nothing; quicker where it finds something.
    ///
    /// # Errors
    /// [`ContactError`] for an unknown moment or a bad pose.
    ///
    /// # Example
    /// See [`LayerStack::contacts`].
    pub fn is_free(&self, moment: Moment, pose: &Pose) -> Result<bool, ContactError> {
        let stand = Stand { tip: pose.tip, before: self.before(moment)?.0, allowed: self.allowed };
        check(pose)?;
        Ok(self.scene(&self.nozzle).is_free(stand, &pose.direction, &mut Vec::new()))
    }

    /// Where the nozzle is deepest on a leg along which the tip goes straight and the direction turns evenly: the share of
    /// the leg, and the contact there. `None` where it is nowhere deeper than allowed.
    ///
    /// # Arguments
    /// * `step_mm`: the nozzle is looked at at even shares of the leg, both ends included, so close that from one to
    ///   the next none of its points that might touch anything built moves farther. Where it is proven free in between, samples are left
    ///   out: the proof holds for all of the way.
    ///
    /// # Errors
    /// [`ContactError`].
    ///
    /// # Cost
    /// Far from everything that of one question; in contact that of one for each sample.
    ///
    /// # Example
    /// See [`LayerStack::contacts`].
    pub fn deepest_along(
        &self,
        moment: Moment,
        from: &Pose,
        to: &Pose,
        step_mm: f64,
    ) -> Result<Option<(f64, Contact)>, ContactError> {
        let (before, bounds) = self.before(moment)?;
        check(from)?;
        check(to)?;
        if !(step_mm > 0.0 && step_mm.is_finite()) {
            return Err(ContactError::BadStep { step_mm });
        }
        from.toward(to, 0.5).ok_or(ContactError::Opposite)?;
        let lever =
            [from, to].map(|pose| farthest(&bounds, &pose.tip)).into_iter().fold(self.nozzle.corner(), f64::max);
        // No point that may touch anything moves farther than this in all: with the tip, and by the turn about it at the farthest reach of
        // what is built.
        let motion = (to.tip - from.tip).norm() + angle(&from.direction, &to.direction) * lever;
        let parts = (motion / step_mm).ceil();
        if parts > MAX_SAMPLES {
            return Err(ContactError::TooFine { step_mm, samples: parts });
        }
        let (samples, spacing) = (parts as u32, motion / parts.max(1.0));
        let (scene, allowed, ends) = (self.scene(&self.nozzle), self.allowed, [*from, *to]);
        let mut leg = Leg { scene, before, allowed, ends, spacing, samples, work: Vec::new(), deepest: None };
        leg.look(0, samples);
        Ok(leg.deepest)
    }

    fn scene<'s>(&'s self, nozzle: &'s Nozzle) -> Scene<'s> {
        Scene::new(self.stack, &self.keys, nozzle, self.plate)
    }

    /// What is there at a moment, and a box around it.
    fn before(&self, moment: Moment) -> Result<(u32, [Point3<f64>; 2]), ContactError> {
        let (Moment::At { path, .. } | Moment::After { path }) = moment;
        let unknown = ContactError::UnknownPath { path, paths: self.paths.len() };
        let printed = self.paths.get(path).ok_or(unknown)?;
        let before = match moment {
            Moment::After { .. } => printed.after,
            Moment::At { waypoint, .. } => {
                let waypoints = printed.before.len();
                let unknown = ContactError::UnknownWaypoint { path, waypoint, waypoints };
                *printed.before.get(waypoint).ok_or(unknown)?
            }
        };
        Ok((before, printed.bounds))
    }
}

impl Leg<'_> {
    /// Looks at samples from one to another.
    fn look(&mut self, first: u32, last: u32) {
        if first < last {
            // Halved until a way is proven free or is a single sample, which then is looked at exactly.
            if !self.is_free(first, last) {
                let middle = first + (last - first) / 2;
                self.look(first, middle);
                self.look(middle + 1, last);
            }
            return;
        }
        let Some((share, pose)) = self.pose(f64::from(first)) else {
            return;
        };
        let found = self.scene.deepest(self.stand(pose.tip), &pose.direction, &mut self.work);
        // Of equally deep ones the first counts.
        if let Some(contact) = found.filter(|found| self.deepest.is_none_or(|(_, worst)| found.depth > worst.depth)) {
            self.deepest = Some((share, contact));
        }
    }

    fn stand(&self, tip: Point3<f64>) -> Stand {
        Stand { tip, before: self.before, allowed: self.allowed }
    }

    /// The pose of a sample, with its share of the leg; also between samples.
    fn pose(&self, sample: f64) -> Option<(f64, Pose)> {
        let share = sample / f64::from(self.samples.max(1));
        let [from, to] = &self.ends;
        // The ends are what they are, without rounding.
        let pose = match share {
            0.0 => *from,
            1.0 => *to,
            _ => from.toward(to, share)?,
        };
        Some((share, pose))
    }

    /// Whether the nozzle is proven free all along from one sample to another.
    fn is_free(&mut self, first: u32, last: u32) -> bool {
        let (first, last) = (f64::from(first), f64::from(last));
        let [Some((_, from)), Some((_, middle)), Some((_, to))] =
            [first, (first + last) / 2.0, last].map(|sample| self.pose(sample))
        else {
            return false;
        };
        // Nothing in between is lower, or leans more: directions up to a right angle from the upright make a convex cap.
        let lower = if from.tip.z < to.tip.z { from.tip } else { to.tip };
        let leaning = if lean(&from) > lean(&to) { from.direction } else { to.direction };
        if !self.scene.above_plate(self.stand(lower), &leaning) {
            return false;
        }
        // A nozzle that is larger by what any point moves from the middle on holds all poses of the way: free as it is, they are.
        let by = self.spacing * (last - first) / 2.0;
        let grown = self.scene.nozzle.grown(by);
        let scene = Scene { nozzle: &grown, plate: None, ..self.scene };
        let stand = self.stand(middle.tip - middle.direction.into_inner() * by);
        scene.is_free(stand, &middle.direction, &mut self.work)
    }
}

fn check(pose: &Pose) -> Result<(), ContactError> {
    let unit = (pose.direction.norm_squared() - 1.0).abs() < 1e-6;
    let near = pose.tip.iter().all(|c| c.abs() < MAX_COORDINATE_MM);
    if unit && near { Ok(()) } else { Err(ContactError::BadPose { pose: *pose }) }
}
