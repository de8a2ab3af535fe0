//! Ways from path to path that keep clear of all that is built by then.
//!
//! Takes tool paths without collisions; gives [`Travels`] ([`LayerStack::travels`]).
//!
//! Between paths the nozzle backs off along its direction, goes to above the next path while it turns evenly, and comes down
//! along the new direction. A nozzle that backs off along its axis stays within the place that it had, since it reaches
//! up without end; so the first and the last piece touch nothing that the nozzle did not touch at the end of the path or will
//! not at the start of the next, and `resolve_gouging` has looked at these. The piece in between keeps a *clearance*
//! from all layers so far, as thick as they are, the one being printed taken as whole, from the mould and from the plate.
//!
//! # Proof
//! Along a straight leg the tip goes by `s` and the direction turns by `f`. A point of the nozzle at a distance `d` from the tip
//! moves by `s + f d` at most. Where it might touch something `d` is at most the farthest distance `L` from the leg to a box
//! around all that is built. So if at the middle of the leg a nozzle grown by the clearance plus `(s + f L) / 2` is free, the
//! leg is. If not, its halves are looked at, down to where that growth is `MIN_CLEARANCE_SHARE` of the clearance. The check of a place is
//! that of `gouging`, so all holds but for a fiftieth of a layer.
//!
//! From the plate a way keeps the clearance as well. Where there is no such way, it keeps what it has at its ends: a nozzle
//! that lies flat over the plate gets no farther from it by backing off. No direction in between leans more than both ends
//! do, for a cap of the sphere of up to a right angle is convex, and the tip is no lower. So a leg is as far from the plate
//! at least as a nozzle with the lower tip that leans more, and near its ends that is enough.
//!
//! # Choice
//! Candidates are straight ways, arcs and ways over the top of the part, each from several heights above the ends;
//! the shortest one that is proven free is taken. Where none is the travel is listed, with what is in the way of
//! the lowest straight one.

use crate::ProgressFn;
use crate::gouging::{GougingError, Nozzle, Obstacle, Scene, Stand};
use crate::layer::{Built, LayerStack, of_layer};
use crate::orientation::{Pose, ToolPath, Waypoint, along, angle, farthest, lean};
use crate::parallel;
use nalgebra::{Point3, Vector3};

/// Legs are halved until their middle stands for them but for this share of the clearance. Less finds ways through gaps that
/// are just wide enough, and takes longer where there are none.
const MIN_CLEARANCE_SHARE: f64 = 0.25;

/// From one height above the ends to the next one that is tried. Less finds shorter ways and tries more.
const HIGHER: f64 = 1.6;

/// How much farther out the middle of an arc is, as shares of the distance between its ends.
const ARCS: [f64; 3] = [0.25, 0.5, 1.0];

/// Legs of an arc.
const PIECES: usize = 8;

/// Places along a leg at which is looked what is in the way, at most.
const MAX_LOOKS: f64 = 1e4;

/// What distances from the plate may lack, in millimetres.
const PLATE_ROUNDING_MM: f64 = 1e-9;

/// Lengths beyond this are refused.
const MAX_LENGTH_MM: f64 = 1e6;

/// How ways from path to path are found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TravelOptions {
    /// What is to be kept from everything built, in millimetres: 1. From the plate, too, but where no way does.
    pub clearance: f64,
    /// How far the nozzle backs off along its direction at least, in millimetres: 2.
    pub min_lift: f64,
    /// And how far it goes at most, straight up over the top of the part included: 200.
    pub max_lift: f64,
    /// Whether there is a plate at z = 0: yes.
    pub plate: bool,
}

impl Default for TravelOptions {
    fn default() -> Self {
        TravelOptions { clearance: 1.0, min_lift: 2.0, max_lift: 200.0, plate: true }
    }
}

/// A travel for which no free way is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockedTravel {
    /// The path that it leads to.
    pub path: usize,
    /// A place of the tip on the lowest straight way at which the nozzle is too near.
    pub tip: Point3<f64>,
    /// To what.
    pub obstacle: Obstacle,
}

/// The ways between paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Travels {
    /// For each path the poses between the end of the one before and its start: the first straight above the one, the last
    /// straight above the other. From pose to pose the tip goes straight and the direction turns evenly. None before
    /// the first path, and where paths join.
    pub ways: Vec<Vec<Pose>>,
    /// Ways that are not the lowest straight one.
    pub lifted: usize,
    /// The highest lift above an end, in millimetres.
    pub max_lift: f64,
    /// Travels that no candidate makes free: their way is the lowest straight one.
    pub blocked: Vec<BlockedTravel>,
}

impl TravelOptions {
    fn check(&self) -> Result<(), GougingError> {
        let wanted = "above 0 and at most 1e6";
        let lengths = [("clearance", self.clearance), ("min_lift", self.min_lift), ("max_lift", self.max_lift)];
        if let Some((option, value)) = lengths.into_iter().find(|(_, value)| !(*value > 0.0 && *value <= MAX_LENGTH_MM))
        {
            return Err(GougingError::Option { option, value, wanted });
        }
        if self.max_lift < self.min_lift {
            let wanted = "no less than min_lift";
            return Err(GougingError::Option { option: "max_lift", value: self.max_lift, wanted });
        }
        Ok(())
    }

    /// Heights that are tried above the ends.
    fn lifts(&self) -> Vec<f64> {
        let next = |lift: &f64| Some(lift * HIGHER).filter(|higher| *higher <= self.max_lift);
        std::iter::successors(Some(self.min_lift), next).collect()
    }
}

impl LayerStack<'_> {
    /// Finds ways from path to path that keep clear of all layers so far and of the plate.
    ///
    /// # Arguments
    /// * `paths`: of these layers, in the order in which they are printed, as [`LayerStack::resolve_gouging`] leaves them.
    /// * `progress`: called with the stage `travel`; may cancel.
    ///
    /// # Errors
    /// [`GougingError`].
    ///
    /// # Cost
    /// One to three milliseconds for a travel on the layers of a real part. With the feature `rayon` they are shared
    /// out among threads; the result is the same.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::gouging::{GougingError, Nozzle, Obstacle};
    /// use curvlay_toolpath::layer::{BuiltLayer, LayerStack};
    /// use curvlay_toolpath::orientation::{Pose, ToolPath, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// use curvlay_toolpath::travel::{BlockedTravel, TravelOptions, Travels};
    /// use std::ops::ControlFlow;
    /// // Across a wall of 12 mm that stands between the ends of two lines.
    /// let wall = [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 20.0, 12.0], [0.0, 0.0, 12.0]].map(Point3::from);
    /// let floor = [[-50.0, 0.0, 0.4], [50.0, 0.0, 0.4], [50.0, 20.0, 0.4], [-50.0, 20.0, 0.4]].map(Point3::from);
    /// let (triangles, spacing) = ([[0, 1, 2], [0, 2, 3]], [0.8; 2]);
    /// let layers = [&wall, &floor].map(|vertices| BuiltLayer { vertices, triangles: &triangles, spacing: &spacing, curves: &[] });
    /// let line = |x: [f64; 2]| {
    ///     let (axis, added) = (Vector3::z_axis(), false);
    ///     let tip = |x| Point3::new(x, 10.0, 0.8);
    ///     let at = |x, arc| Waypoint { position: tip(x), axis, width: 0.8, height: 0.8, arc, added, lift: Vector3::zeros(), kind: BeadKind::Wall };
    ///     ToolPath { layer: 1, curve: 0, closed: false, waypoints: vec![at(x[0], 0.0), at(x[1], 5.0)] }
    /// };
    /// let (nozzle, options) = (Nozzle::default(), TravelOptions::default());
    /// let paths = [line([-40.0, -35.0]), line([35.0, 40.0])];
    /// let travels = LayerStack::new(&layers)?.travels(&paths, &nozzle, &options, &|_| ControlFlow::Continue(()))?;
    /// assert!(travels.blocked.is_empty() && travels.ways[0].is_empty());
    /// let highest = travels.ways[1].iter().map(|pose| pose.tip.z).fold(0.0, f64::max);
    /// // In a flat arc: over the wall, a millimetre clear.
    /// assert!(highest >= 13.0 && highest < 21.0, "{highest}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn travels(
        &self,
        paths: &[ToolPath],
        nozzle: &Nozzle,
        options: &TravelOptions,
        progress: ProgressFn,
    ) -> Result<Travels, GougingError> {
        options.check()?;
        self.check_paths(paths)?;
        let boxes = self.boxes();
        let lifts = options.lifts();
        let work = |k: usize, to: &ToolPath| {
            let (from, to_start) = (paths[k.checked_sub(1)?].waypoints.last()?, to.waypoints.first()?);
            if lifted(from, 0.0).joins(&lifted(to_start, 0.0)) {
                return None;
            }
            let built = boxes[to.layer as usize];
            let mut finder = Finder { stack: self, nozzle, options, layer: to.layer, built, work: Vec::new() };
            Some(finder.find(from, to_start, &lifts))
        };
        let found = parallel::map(paths, "travel", progress, work).ok_or(GougingError::Cancelled)?;
        let mut travels =
            Travels { ways: Vec::with_capacity(found.len()), lifted: 0, max_lift: 0.0, blocked: Vec::new() };
        for (path, found) in found.into_iter().enumerate() {
            let Some(Found { way, lift, is_first, blocked }) = found else {
                travels.ways.push(Vec::new());
                continue;
            };
            travels.ways.push(way);
            travels.lifted += usize::from(!is_first);
            travels.max_lift = travels.max_lift.max(lift);
            travels.blocked.extend(blocked.map(|(tip, obstacle)| BlockedTravel { path, tip, obstacle }));
        }
        Ok(travels)
    }

    /// Boxes around the mould and the layers up to each one, by their lower and upper corner; thickness included.
    pub(crate) fn boxes(&self) -> Vec<[Point3<f64>; 2]> {
        let nothing = [f64::INFINITY, f64::NEG_INFINITY].map(|far| Point3::from([far; 3]));
        let [mut low, mut high] = self.mould.as_ref().map_or(nothing, |mould| mould.bounds);
        let grown = |layer: &Built| {
            let half = layer.spacing.iter().copied().fold(0.0, f64::max) / 2.0;
            for p in layer.triangles.iter().flatten().map(|&v| layer.vertices[v as usize]) {
                low = low.inf(&(p - Vector3::repeat(half)));
                high = high.sup(&(p + Vector3::repeat(half)));
            }
            [low, high]
        };
        self.layers.iter().map(grown).collect()
    }
}

/// A way that was found.
struct Found {
    way: Vec<Pose>,
    lift: f64,
    is_first: bool,
    blocked: Option<(Point3<f64>, Obstacle)>,
}

struct Finder<'a> {
    stack: &'a LayerStack<'a>,
    nozzle: &'a Nozzle,
    options: &'a TravelOptions,
    layer: u32,
    /// A box around all that is built.
    built: [Point3<f64>; 2],
    work: Vec<(f64, u32)>,
}

fn lifted(waypoint: &Waypoint, by: f64) -> Pose {
    Pose { tip: waypoint.position + waypoint.axis.into_inner() * by, direction: waypoint.axis }
}

/// How long a way is. The lifts at its ends count, too.
fn length(way: &[Pose]) -> f64 {
    way.windows(2).map(|pair| (pair[1].tip - pair[0].tip).norm()).sum()
}

/// Straight ways and arcs between two poses.
fn ways(ends: [Pose; 2]) -> Vec<Vec<Pose>> {
    straight(ends).into_iter().chain(ARCS.iter().filter_map(|&bulge| arc(ends, bulge))).collect()
}

impl Finder<'_> {
    fn find(&mut self, from: &Waypoint, to: &Waypoint, lifts: &[f64]) -> Found {
        let above = |lift: f64| [lifted(from, lift), lifted(to, lift)];
        let mut candidates: Vec<(f64, usize, Vec<Pose>)> = Vec::new();
        for (k, &lift) in lifts.iter().enumerate() {
            let ways = ways(above(lift)).into_iter();
            candidates.extend(ways.map(|way| (2.0 * lift + length(&way), k, way)));
            let over = self.over([from, to], above(lift));
            candidates.extend(over.map(|way| (2.0 * lift + length(&way), k, way)));
        }
        // Equally long ones stay in the order in which they were made, the lowest and straightest first.
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Where one end is in the way there is no need for the rest.
        let mut ends_free: Vec<Option<bool>> = vec![None; lifts.len()];
        for min_clearance in [self.options.clearance, 0.0] {
            for (_, k, way) in &candidates {
                let (ends, known) = (above(lifts[*k]), ends_free[*k]);
                let over_plate = self.over_plate(&ends);
                if over_plate < min_clearance {
                    continue;
                }
                let are_free =
                    known.unwrap_or_else(|| ends.iter().all(|end| self.is_free(end, self.options.clearance)));
                ends_free[*k] = Some(are_free);
                if are_free && self.is_way_free(way, over_plate) {
                    let is_first = way.len() == 2 && *k == 0;
                    return Found { is_first, way: way.clone(), lift: lifts[*k], blocked: None };
                }
            }
        }
        let ends = above(self.options.min_lift);
        let way = straight(ends).unwrap_or_else(|| ends.to_vec());
        let blocked = Some(self.in_the_way(&way, self.over_plate(&ends).max(0.0)));
        Found { way, lift: self.options.min_lift, is_first: false, blocked }
    }

    /// Upright over the top of everything, unless that is too far up or there is nothing to rise over.
    fn over(&self, starts: [&Waypoint; 2], ends: [Pose; 2]) -> Option<Vec<Pose>> {
        let top = self.built[1].z + 1.5 * self.options.clearance;
        let up = |k: usize| {
            let Pose { tip, direction } = ends[k];
            let turns = along(&direction, &Vector3::z_axis(), 0.5).is_some();
            let over = Pose { tip: Point3::new(tip.x, tip.y, top), direction: Vector3::z_axis() };
            (turns && top - starts[k].position.z <= self.options.max_lift).then_some((tip.z < top).then_some(over))
        };
        let (one, other) = (up(0)?, up(1)?);
        one.or(other)?;
        Some([Some(ends[0]), one, other, Some(ends[1])].into_iter().flatten().collect())
    }

    /// What a way between these ends keeps from the plate.
    fn over_plate(&self, ends: &[Pose; 2]) -> f64 {
        ends.iter().map(|end| self.above_plate(end.tip.z, lean(end))).fold(self.options.clearance, f64::min)
    }

    /// How far above the plate a nozzle is whose tip is at this height.
    fn above_plate(&self, height: f64, lean: f64) -> f64 {
        if self.options.plate { -self.nozzle.below_plate(height, lean).0 } else { f64::INFINITY }
    }

    fn is_way_free(&mut self, way: &[Pose], over_plate: f64) -> bool {
        way.windows(2).all(|leg| {
            let leg = [leg[0], leg[1]];
            self.is_leg_above(&leg, over_plate) && self.is_leg_free(leg)
        })
    }

    /// Whether a leg is proven to keep so much from the plate.
    fn is_leg_above(&self, leg: &[Pose; 2], over_plate: f64) -> bool {
        let (height, lean) = (leg[0].tip.z.min(leg[1].tip.z), lean(&leg[0]).max(lean(&leg[1])));
        let motion = length(leg) + angle(&leg[0].direction, &leg[1].direction) * self.nozzle.corner();
        let halves = || {
            let middle = leg[0].toward(&leg[1], 0.5)?;
            Some([[leg[0], middle], [middle, leg[1]]])
        };
        self.above_plate(height, lean) >= over_plate - PLATE_ROUNDING_MM
            || motion > MIN_CLEARANCE_SHARE * self.options.clearance
                && halves().is_some_and(|halves| halves.iter().all(|half| self.is_leg_above(half, over_plate)))
    }

    /// Whether a leg is proven to keep the clearance from what is built, its ends being known to.
    fn is_leg_free(&mut self, leg: [Pose; 2]) -> bool {
        let clearance = self.options.clearance;
        let length = (leg[1].tip - leg[0].tip).norm();
        let reach = leg.map(|pose| farthest(&self.built, &pose.tip)).into_iter().fold(self.nozzle.corner(), f64::max);
        let motion = length + angle(&leg[0].direction, &leg[1].direction) * (reach + 2.0 * clearance);
        let Some(finest) = leg[0].toward(&leg[1], 0.5) else {
            return false;
        };
        // Wide pieces first: what is in the way shows soon.
        let mut open = std::collections::VecDeque::from([(0.0, 1.0, finest)]);
        while let Some((low, high, middle)) = open.pop_front() {
            let moved = motion * (high - low) / 2.0;
            if self.is_free(&middle, clearance + moved) {
                continue;
            }
            if moved <= MIN_CLEARANCE_SHARE * clearance || !self.is_free(&middle, clearance) {
                return false;
            }
            let half = (low + high) / 2.0;
            for (low, high) in [(low, half), (half, high)] {
                let Some(middle) = leg[0].toward(&leg[1], (low + high) / 2.0) else {
                    return false;
                };
                open.push_back((low, high, middle));
            }
        }
        true
    }

    /// A nozzle grown by a clearance, and where its tip is.
    fn grown(&self, pose: &Pose, by: f64) -> (Nozzle, Stand) {
        let tip = pose.tip - pose.direction.into_inner() * by;
        (self.nozzle.grown(by), Stand { tip, before: of_layer(self.layer).end, allowed: 0.0 })
    }

    fn scene<'s>(&'s self, nozzle: &'s Nozzle) -> Scene<'s> {
        Scene::new(self.stack, &self.stack.keys, nozzle, None)
    }

    /// Whether a nozzle is farther from all that is built.
    fn is_free(&mut self, pose: &Pose, clearance: f64) -> bool {
        let mut work = std::mem::take(&mut self.work);
        let (nozzle, stand) = self.grown(pose, clearance);
        let free = self.scene(&nozzle).is_free(stand, &pose.direction, &mut work);
        self.work = work;
        free
    }

    /// The first place along a way that is not free, and what is there.
    fn in_the_way(&mut self, way: &[Pose], over_plate: f64) -> (Point3<f64>, Obstacle) {
        let clearance = self.options.clearance;
        // With more than the clearance where only a proof is missing.
        let found = [1.0, 1.0 + MIN_CLEARANCE_SHARE]
            .iter()
            .find_map(|share| self.nearer_than(clearance * share, over_plate, way));
        // Then it is what was built last.
        found.unwrap_or((way[0].tip, Obstacle::Layer(self.layer)))
    }

    fn nearer_than(&self, clearance: f64, over_plate: f64, way: &[Pose]) -> Option<(Point3<f64>, Obstacle)> {
        let mut work = Vec::new();
        for leg in way.windows(2) {
            let leg = [leg[0], leg[1]];
            let motion = length(&leg) + angle(&leg[0].direction, &leg[1].direction) * self.nozzle.corner();
            let steps = (motion / (MIN_CLEARANCE_SHARE * clearance)).ceil().clamp(1.0, MAX_LOOKS) as usize;
            for pose in (0..=steps).filter_map(|k| leg[0].toward(&leg[1], k as f64 / steps as f64)) {
                let (nozzle, stand) = self.grown(&pose, clearance);
                let scene = self.scene(&nozzle);
                if let Some(worst) = scene.worst(stand, &pose.direction, &mut work) {
                    return Some((pose.tip, worst.obstacle));
                }
                if self.above_plate(pose.tip.z, lean(&pose)) < over_plate - PLATE_ROUNDING_MM {
                    return Some((pose.tip, Obstacle::Plate));
                }
            }
        }
        None
    }
}

/// From one pose to the other, at once; upright in the middle between opposite directions.
fn straight([from, to]: [Pose; 2]) -> Option<Vec<Pose>> {
    if along(&from.direction, &to.direction, 0.5).is_some() {
        return Some(vec![from, to]);
    }
    let upright = Pose { tip: nalgebra::center(&from.tip, &to.tip), direction: Vector3::z_axis() };
    let turns = [from, to].iter().all(|end| along(&end.direction, &upright.direction, 0.5).is_some());
    turns.then(|| vec![from, upright, to])
}

/// From one pose to the other with the middle moved out along the direction, as a share of the distance of both.
fn arc([from, to]: [Pose; 2], bulge: f64) -> Option<Vec<Pose>> {
    let out = bulge * (to.tip - from.tip).norm();
    let pose = |k: usize| {
        let share = k as f64 / PIECES as f64;
        let direction = along(&from.direction, &to.direction, share)?;
        let tip = from.tip + (to.tip - from.tip) * share + direction.into_inner() * (4.0 * out * share * (1.0 - share));
        Some(Pose { tip, direction })
    };
    let mut way = (0..=PIECES).map(pose).collect::<Option<Vec<Pose>>>()?;
    // The ends are what they are, without rounding.
    (way[0], way[PIECES]) = (from, to);
    Some(way)
}
