//! What is extruded along tool paths, how fast, and the moves in between: a plan of timed moves.
//!
//! Takes tool paths and travels; gives a [`Deposition`] of timed [`Move`]s.
//!
//! Dai 2020, section 3.6.3: "thickness variations are compensated by controlling the feed-rate of material extrusion".
//! The section of a bead is its width times its height, which is the thickness of the layer at that place; between
//! waypoints both go evenly from one to the next. The volume of a piece of bead is the section along its length on the
//! surface of the layer, exactly: the tip, which runs above, may go a longer or a shorter way.
//!
//! The flow of material is constant as long as the tip is neither slower nor faster than it may be. Where the nozzle turns
//! faster than it may, the piece takes longer still, and less flows.
//!
//! Between paths that do not join, the filament is drawn back, the nozzle backs off along its direction, travels to above the
//! next path, comes down, and the filament is pushed forward again. It travels along given ways, which
//! [`LayerStack::travels`] finds clear of all that is built, or else straight, whatever is in the way.
//!
//! [`LayerStack::travels`]: crate::layer::LayerStack::travels

use crate::orientation::{Pose, ToolPath, Waypoint, angle};
use crate::path::BeadKind;
use nalgebra::{Point3, UnitVector3};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Tips slower than this, in millimetres a second, stand still: machine files have no lower speed.
const SLOWEST: f64 = 1e-3;

/// Moves from path to path where no way is given: filament is drawn back, two hops, down to the path, and it is primed.
const BETWEEN: usize = 5;

/// How material is laid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct DepositionOptions {
    /// Diameter of the filament in millimetres: 1.75.
    pub filament_diameter: f64,
    /// Wanted flow in cubic millimetres a second: 8.
    pub flow_mm3_s: f64,
    /// The tip is not to be slower than this while it prints, in millimetres a second: 2.
    pub min_feed: f64,
    /// Maximum print speed, in mm/s: 40.
    pub max_feed: f64,
    /// The nozzle is not to turn faster than this, in radians a second: a half turn (180 degrees) a second.
    pub max_turn_rate: f64,
    /// Speed of travel moves in millimetres a second: 80.
    pub travel_feed: f64,
    /// Filament drawn back before a travel and pushed forward after it, in millimetres: 1. None for 0.
    pub retraction: f64,
    /// Speed of the filament while it is drawn back, in millimetres a second: 30.
    pub retract_feed: f64,
    /// Speed of the filament while it is pushed forward, in millimetres a second: 20.
    pub prime_feed: f64,
    /// How far the nozzle backs off along its direction before and after a travel whose way is not given, in millimetres: 5.
    pub hop: f64,
}

impl Default for DepositionOptions {
    fn default() -> Self {
        DepositionOptions {
            filament_diameter: 1.75,
            flow_mm3_s: 8.0,
            min_feed: 2.0,
            max_feed: 40.0,
            max_turn_rate: PI,
            travel_feed: 80.0,
            retraction: 1.0,
            retract_feed: 30.0,
            prime_feed: 20.0,
            hop: 5.0,
        }
    }
}

/// What a move does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MoveKind {
    /// The nozzle goes somewhere without printing.
    Travel,
    /// Filament is drawn back; the nozzle stands still.
    Retract,
    /// Filament is pushed forward to where it was; the nozzle stands still.
    Prime,
    /// A piece of bead.
    Print,
}

/// A straight move, from where the move before ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// What it does.
    pub kind: MoveKind,
    /// What the bead is for, of a piece of bead; none for others.
    pub bead: Option<BeadKind>,
    /// The path it belongs to, by its place in the list: a travel and a prime to the path that follows, a retraction to the
    /// one before.
    pub path: usize,
    /// The waypoint at which it ends; for moves above a path the nearest one.
    pub waypoint: usize,
    /// Where the tip is at its end.
    pub tip: Point3<f64>,
    /// How the nozzle stands at its end.
    pub direction: UnitVector3<f64>,
    /// Filament pushed forward, in millimetres; below 0 for a retraction.
    pub filament: f64,
    /// Speed in millimetres a second: of the tip; of the filament for retractions, primes and beads laid while the tip
    /// stands still. A turn on the spot that lays nothing has the greatest speed of its kind.
    pub feed: f64,
    /// How long it takes.
    pub seconds: f64,
}

/// A plan of moves and its sums.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deposition {
    /// One after the other. The first one is a travel move to above the first path, of no duration.
    pub moves: Vec<Move>,
    /// Volume of all beads.
    pub extruded_mm3: f64,
    /// Filament for them, in millimetres.
    pub filament_mm: f64,
    /// The volume of the beads of each path, in cubic millimetres.
    pub of_path: Vec<f64>,
    /// Seconds of printing.
    pub print_s: f64,
    /// Seconds of everything.
    pub total_s: f64,
    /// Length of travels, in millimetres.
    pub travel_mm: f64,
    /// How often filament is drawn back.
    pub retractions: usize,
    /// Length of bead along which the flow is the wanted one, and length of all beads, in millimetres.
    pub even_flow_mm: f64,
    /// Length of all beads, in millimetres.
    pub bead_mm: f64,
    /// Which limit the planned feed is held by, for how long.
    pub limits: FeedLimits,
}

/// Seconds of printing at each limit of the feed; they add up to the planned time of printing, before [`Deposition::retime`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeedLimits {
    /// The wanted flow of material.
    pub flow_s: f64,
    /// The maximum feed.
    pub max_feed_s: f64,
    /// The minimum feed.
    pub min_feed_s: f64,
    /// How fast the nozzle may turn.
    pub turn_s: f64,
}

impl FeedLimits {
    /// Shares of the time of printing at the flow, the maximum feed, the minimum feed, and the limit of turning; all 0 if nothing
    /// is printed.
    ///
    /// # Example
    /// ```
    /// let limits = curvlay_toolpath::deposit::FeedLimits { flow_s: 1.0, turn_s: 3.0, ..Default::default() };
    /// assert_eq!(limits.shares(), [0.25, 0.0, 0.0, 0.75]);
    /// ```
    pub fn shares(&self) -> [f64; 4] {
        let seconds = [self.flow_s, self.max_feed_s, self.min_feed_s, self.turn_s];
        let all: f64 = seconds.iter().sum();
        seconds.map(|part| if all > 0.0 { part / all } else { 0.0 })
    }
}

/// How a path is laid at the planned feed: times and filament since it began, at each of its waypoints.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSchedule {
    times: Vec<f64>,
    filament: Vec<f64>,
}

impl PathSchedule {
    /// When each waypoint is passed, in seconds; the first one at 0.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Filament that is laid by each waypoint, in millimetres; none by the first one.
    pub fn filament_mm(&self) -> &[f64] {
        &self.filament
    }
}

impl Deposition {
    /// The schedule of each path. `O(n)` for `n` moves.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::deposit::{DepositionOptions, deposit};
    /// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// let axis = Vector3::z_axis();
    /// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.5), axis, width: 0.8, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall };
    /// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0), at(30.0)] };
    /// let plan = deposit(&[path], &DepositionOptions::default())?;
    /// let schedule = &plan.schedules()[0]; // 8 mm^3/s, 20 mm/s
    /// assert!(schedule.times().iter().zip([0.0, 0.5, 1.5]).all(|(a, b)| (a - b).abs() < 1e-12));
    /// assert!((schedule.filament_mm()[2] - plan.filament_mm).abs() < 1e-12);
    /// # Ok::<(), curvlay_toolpath::deposit::DepositionError>(())
    /// ```
    pub fn schedules(&self) -> Vec<PathSchedule> {
        let start = PathSchedule { times: vec![0.0], filament: vec![0.0] };
        let mut schedules = vec![start; self.of_path.len()];
        for step in self.moves.iter().filter(|step| step.kind == MoveKind::Print) {
            let Some(PathSchedule { times, filament }) = schedules.get_mut(step.path) else { continue };
            times.push(times[times.len() - 1] + step.seconds);
            filament.push(filament[filament.len() - 1] + step.filament);
        }
        schedules
    }

    /// Takes over how long a machine takes: each item is a path, a waypoint of it, and the seconds to it from the one before.
    /// Beads to other waypoints keep their time, as do those whose item is not above 0 and finite. Feeds and sums follow.
    ///
    /// # Cost
    /// `O((n + k) log k)` for `n` moves and `k` items. If a waypoint comes twice the last item counts.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::deposit::{DepositionOptions, deposit};
    /// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// let axis = Vector3::z_axis();
    /// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.5), axis, width: 0.8, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall };
    /// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0)] };
    /// let mut plan = deposit(&[path], &DepositionOptions::default())?;
    /// plan.retime([(0, 1, 2.0)]);
    /// assert_eq!((plan.print_s, plan.moves.last().map(|step| step.feed)), (2.0, Some(5.0)));
    /// # Ok::<(), curvlay_toolpath::deposit::DepositionError>(())
    /// ```
    pub fn retime(&mut self, steps: impl IntoIterator<Item = (usize, usize, f64)>) {
        let seconds: BTreeMap<(usize, usize), f64> =
            steps.into_iter().map(|(path, waypoint, seconds)| ((path, waypoint), seconds)).collect();
        for step in self.moves.iter_mut().filter(|step| step.kind == MoveKind::Print && step.seconds > 0.0) {
            let given =
                seconds.get(&(step.path, step.waypoint)).filter(|seconds| **seconds > 0.0 && seconds.is_finite());
            let Some(&seconds) = given else { continue };
            self.print_s += seconds - step.seconds;
            self.total_s += seconds - step.seconds;
            step.feed *= step.seconds / seconds;
            step.seconds = seconds;
        }
    }
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepositionError {
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
    /// The minimum feed is above the maximum.
    #[error("the minimum feed of {min} mm/s is above the maximum of {max} mm/s")]
    Feeds {
        /// The minimum feed.
        min: f64,
        /// The maximum.
        max: f64,
    },
    /// A path without a second waypoint.
    #[error("path {path} has {waypoints} waypoints: it needs two")]
    FewWaypoints {
        /// The path, from 0.
        path: usize,
        /// Its waypoints.
        waypoints: usize,
    },
    /// A waypoint that is not finite, has no bead, or goes back along its curve.
    #[error("waypoint {waypoint} of path {path} is not finite, has no bead, or goes back along its curve")]
    BadWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// There is not one way for each path.
    #[error("{ways} ways to {paths} paths: there must be one to each")]
    WayCount {
        /// Ways given.
        ways: usize,
        /// Paths given.
        paths: usize,
    },
    /// A pose that is not finite or has no unit direction.
    #[error("pose {pose} on the way to path {path} is not finite or has no unit direction")]
    BadPose {
        /// The path, from 0.
        path: usize,
        /// The pose, from 0.
        pose: usize,
    },
}

impl DepositionOptions {
    fn check(&self) -> Result<(), DepositionError> {
        let positive = [
            ("filament_diameter", self.filament_diameter),
            ("flow_mm3_s", self.flow_mm3_s),
            ("min_feed", self.min_feed),
            ("max_feed", self.max_feed),
            ("max_turn_rate", self.max_turn_rate),
            ("travel_feed", self.travel_feed),
            ("retract_feed", self.retract_feed),
            ("prime_feed", self.prime_feed),
        ];
        let wrong = |&(_, value): &(&str, f64)| !(value > 0.0 && value.is_finite());
        if let Some((option, value)) = positive.into_iter().find(wrong) {
            return Err(DepositionError::Option { option, value, wanted: "above 0 and finite" });
        }
        let lengths = [("retraction", self.retraction), ("hop", self.hop)];
        if let Some((option, value)) = lengths.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            return Err(DepositionError::Option { option, value, wanted: "0 or more and finite" });
        }
        if self.min_feed > self.max_feed {
            return Err(DepositionError::Feeds { min: self.min_feed, max: self.max_feed });
        }
        Ok(())
    }
}

impl DepositionOptions {
    /// How long a piece of bead of this length and volume takes, if the nozzle does not turn: by the flow asked for, within the limits of the
    /// feed.
    pub(crate) fn seconds_of(&self, length: f64, volume: f64) -> f64 {
        (volume / self.flow_mm3_s).max(length / self.max_feed).min(length / self.min_feed)
    }
}

/// The volume of a bead between two waypoints.
fn volume(from: &Waypoint, to: &Waypoint) -> f64 {
    let section =
        2.0 * (from.width * from.height + to.width * to.height) + from.width * to.height + to.width * from.height;
    section / 6.0 * (to.arc - from.arc)
}

/// The plan under way.
struct Planner<'a> {
    options: &'a DepositionOptions,
    plan: Deposition,
    /// Where the nozzle is.
    at: Option<(Point3<f64>, UnitVector3<f64>)>,
}

impl Planner<'_> {
    /// A move that takes at least as long as its length at `feed` and its turn need.
    fn go(&mut self, kind: MoveKind, path: usize, waypoint: usize, tip: Point3<f64>, direction: UnitVector3<f64>) {
        let (length, turn) = self.at.map_or((0.0, 0.0), |(from, old)| ((tip - from).norm(), angle(&old, &direction)));
        let seconds = (length / self.options.travel_feed).max(turn / self.options.max_turn_rate);
        // A turn on the spot has no speed.
        let feed = if length > SLOWEST * seconds { length / seconds } else { self.options.travel_feed };
        self.plan.moves.push(Move { kind, bead: None, path, waypoint, tip, direction, filament: 0.0, feed, seconds });
        self.plan.travel_mm += length;
        self.plan.total_s += seconds;
        self.at = Some((tip, direction));
    }

    /// Filament alone.
    fn push(&mut self, kind: MoveKind, path: usize, waypoint: usize, filament: f64, feed: f64) {
        let Some((tip, direction)) = self.at.filter(|_| filament.abs() > 0.0) else {
            return;
        };
        let seconds = filament.abs() / feed;
        self.plan.moves.push(Move { kind, bead: None, path, waypoint, tip, direction, filament, feed, seconds });
        self.plan.total_s += seconds;
    }

    /// From the end of the path before to the start of this one, along a way or straight.
    fn travel(&mut self, paths: &[ToolPath], path: usize, way: Option<&[Pose]>) {
        let (to, hop) = (&paths[path].waypoints[0], self.options.hop);
        let above = |tip: Point3<f64>, direction: UnitVector3<f64>| {
            (hop > 0.0).then(|| Pose { tip: tip + direction.into_inner() * hop, direction })
        };
        let arrival = above(to.position, to.axis);
        if let (Some((tip, direction)), Some(before)) = (self.at, path.checked_sub(1)) {
            // The path goes on where the last one ended: no travel, and the filament stays under pressure.
            if (Pose { tip, direction }).joins(&Pose { tip: to.position, direction: to.axis }) {
                if direction != to.axis {
                    self.go(MoveKind::Travel, path, 0, to.position, to.axis);
                }
                return;
            }
            let (last, options) = (paths[before].waypoints.len() - 1, self.options);
            self.push(MoveKind::Retract, before, last, -options.retraction, options.retract_feed);
            self.plan.retractions += usize::from(options.retraction > 0.0);
            let hops: Vec<Pose> = above(tip, direction).into_iter().chain(arrival).collect();
            for (k, pose) in way.unwrap_or(&hops).iter().enumerate() {
                // The first pose is above the end of the path before, the others lead to this one.
                let (path, waypoint) = if k == 0 { (before, last) } else { (path, 0) };
                self.go(MoveKind::Travel, path, waypoint, pose.tip, pose.direction);
            }
        } else if let Some(pose) = arrival {
            self.go(MoveKind::Travel, path, 0, pose.tip, pose.direction);
        }
        self.go(MoveKind::Travel, path, 0, to.position, to.axis);
        // The first path begins with filament that was not drawn back.
        if path > 0 {
            self.push(MoveKind::Prime, path, 0, self.options.retraction, self.options.prime_feed);
        }
    }

    fn print(&mut self, path: usize, waypoint: usize, from: &Waypoint, to: &Waypoint) {
        let volume = volume(from, to);
        let length = (to.position - from.position).norm();
        // The bead and the tip may go ways of different length; neither is to be too fast.
        let way = length.max(to.arc - from.arc);
        let wanted = volume / self.options.flow_mm3_s;
        let [fastest, slowest] = [way / self.options.max_feed, way / self.options.min_feed];
        // The flow asked for, then the limits of the feed; turning comes last, since no machine turns faster, however slow the tip is
        // then.
        let limited = wanted.max(fastest).min(slowest);
        let turn = angle(&from.axis, &to.axis);
        let seconds = limited.max(turn / self.options.max_turn_rate);
        let area = PI / 4.0 * self.options.filament_diameter.powi(2);
        let plan = &mut self.plan;
        let limits = &mut plan.limits;
        *(if seconds > limited {
            &mut limits.turn_s
        } else if wanted > slowest {
            &mut limits.min_feed_s
        } else if wanted < fastest {
            &mut limits.max_feed_s
        } else {
            &mut limits.flow_s
        }) += seconds;
        plan.moves.push(Move {
            kind: MoveKind::Print,
            bead: Some(to.kind),
            path,
            waypoint,
            tip: to.position,
            direction: to.axis,
            filament: volume / area,
            // Where the tip stands and only turns it is the filament that has a speed.
            feed: if length > SLOWEST * seconds {
                length / seconds
            } else if volume > area * SLOWEST * seconds {
                volume / area / seconds
            } else {
                self.options.max_feed
            },
            seconds,
        });
        plan.bead_mm += to.arc - from.arc;
        plan.even_flow_mm += if (seconds - wanted).abs() <= 1e-9 * seconds { to.arc - from.arc } else { 0.0 };
        plan.of_path[path] += volume;
        plan.print_s += seconds;
        plan.total_s += seconds;
        self.at = Some((to.position, to.axis));
    }
}

/// Plans the moves along `paths`, one after the other.
///
/// # Errors
/// [`DepositionError`].
///
/// # Cost
/// `O(n)` for `n` waypoints.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::deposit::{DepositionOptions, deposit};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// // 10 mm of a bead of 0.8 by 0.5 mm.
/// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.5), axis: Vector3::z_axis(), width: 0.8, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall };
/// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0)] };
/// let plan = deposit(&[path], &DepositionOptions::default())?;
/// assert!((plan.extruded_mm3 - 4.0).abs() < 1e-12);
/// assert!((plan.filament_mm - 4.0 / (std::f64::consts::PI / 4.0 * 1.75 * 1.75)).abs() < 1e-12);
/// assert!((plan.print_s - 0.5).abs() < 1e-12); // 8 mm^3/s, 20 mm/s
/// # Ok::<(), curvlay_toolpath::deposit::DepositionError>(())
/// ```
pub fn deposit(paths: &[ToolPath], options: &DepositionOptions) -> Result<Deposition, DepositionError> {
    planned(paths, None, options)
}

/// Plans the moves along `paths`, one after the other, and along the ways between them.
///
/// # Arguments
/// * `ways`: for each path the poses between the end of the one before and its start, as [`LayerStack::travels`] gives
///   them; that of the first path is not looked at.
///
/// # Errors
/// [`DepositionError`].
///
/// # Cost
/// `O(n)` for `n` waypoints and poses.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::deposit::{DepositionOptions, deposit_along};
/// use curvlay_toolpath::orientation::{Pose, ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// let axis = Vector3::z_axis();
/// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.5), axis, width: 0.8, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall };
/// let path = |from, to| ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(from), at(to)] };
/// let above = |x| Pose { tip: Point3::new(x, 0.0, 3.5), direction: Vector3::z_axis() };
/// let ways = [Vec::new(), vec![above(10.0), above(20.0)]];
/// let plan = deposit_along(&[path(0.0, 10.0), path(20.0, 30.0)], &ways, &DepositionOptions::default())?;
/// // Down 5 mm to the first path, then up 3 mm, across, and down.
/// assert!((plan.travel_mm - (5.0 + 3.0 + 10.0 + 3.0)).abs() < 1e-12);
/// # Ok::<(), curvlay_toolpath::deposit::DepositionError>(())
/// ```
///
/// [`LayerStack::travels`]: crate::layer::LayerStack::travels
pub fn deposit_along(
    paths: &[ToolPath],
    ways: &[Vec<Pose>],
    options: &DepositionOptions,
) -> Result<Deposition, DepositionError> {
    if ways.len() != paths.len() {
        return Err(DepositionError::WayCount { ways: ways.len(), paths: paths.len() });
    }
    let sound =
        |pose: &Pose| pose.tip.iter().all(|n| n.is_finite()) && (pose.direction.norm_squared() - 1.0).abs() < 1e-6;
    for (path, way) in ways.iter().enumerate() {
        if let Some(pose) = way.iter().position(|pose| !sound(pose)) {
            return Err(DepositionError::BadPose { path, pose });
        }
    }
    planned(paths, Some(ways), options)
}

fn planned(
    paths: &[ToolPath],
    ways: Option<&[Vec<Pose>]>,
    options: &DepositionOptions,
) -> Result<Deposition, DepositionError> {
    options.check()?;
    for (path, waypoints) in paths.iter().map(|path| &path.waypoints).enumerate() {
        if waypoints.len() < 2 {
            return Err(DepositionError::FewWaypoints { path, waypoints: waypoints.len() });
        }
        let sound = |w: &Waypoint| {
            let unit = (w.axis.norm_squared() - 1.0).abs() < 1e-6;
            unit && w.position.iter().chain([&w.arc]).all(|n| n.is_finite())
                && [w.width, w.height].iter().all(|&n| n > 0.0 && n.is_finite())
        };
        let back = |k: usize| k > 0 && waypoints[k].arc < waypoints[k - 1].arc;
        if let Some(waypoint) = (0..waypoints.len()).find(|&k| !sound(&waypoints[k]) || back(k)) {
            return Err(DepositionError::BadWaypoint { path, waypoint });
        }
    }
    // All input is sound from here on.
    // A move to each waypoint and pose, and between paths what draws back and primes.
    let poses = ways.unwrap_or_default().iter().map(Vec::len).sum::<usize>();
    let waypoints = paths.iter().map(|path| path.waypoints.len()).sum::<usize>();
    let moves = Vec::with_capacity(waypoints + poses + BETWEEN * paths.len());
    let plan = Deposition { of_path: vec![0.0; paths.len()], moves, ..Deposition::default() };
    let mut planner = Planner { options, plan, at: None };
    for (path, waypoints) in paths.iter().map(|path| &path.waypoints).enumerate() {
        planner.travel(paths, path, ways.map(|ways| &ways[path][..]));
        for (k, pair) in waypoints.windows(2).enumerate() {
            planner.print(path, k + 1, &pair[0], &pair[1]);
        }
    }
    let mut plan = planner.plan;
    plan.extruded_mm3 = plan.of_path.iter().sum();
    plan.filament_mm = plan.extruded_mm3 / (PI / 4.0 * options.filament_diameter.powi(2));
    Ok(plan)
}
