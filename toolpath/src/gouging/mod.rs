//! A nozzle that does not run into what it has built.
//!
//! Takes the [`ToolPath`]s of [`LayerStack::orient`] and a [`Nozzle`]; gives [`ResolvedPaths`] ([`LayerStack::resolve_gouging`]), and answers for single
//! poses ([`LayerStack::contacts`]).
//!
//! Dai 2020, section 3.6.3, names local gouging as an open point: directions for best adhesion may drive the nozzle into
//! the model. Here each waypoint is checked against all that is built by then (`deepest`), tilted by the least angle that
//! frees it (`tilt`), and the tilt is spread along the path (`along`). The tip stays where it is. A path on which waypoints are
//! left without a way out is tried from its end to its start as well: in a crease of a layer what is laid first is free. What is still
//! not free is raised by up to half a layer. If that is not enough, pieces of paths are cut out and laid before the rest of the layer; those where the nozzle would run into
//! what is built are left out (`order`). What `resolve_gouging` asks at waypoints can be asked of any pose at any moment of the print (`contact`).
//!
//! What has been built is all earlier layers, each as thick as its spacing, and of its own layer what the beads so far cover
//! (`built`), and the mould, if there is one. The nozzle may enter it by a quarter of a layer. Below the plate it may not reach at all.
//!
//! Layers from which no earlier layer shadows a later one have the tip outside the hull of all earlier cells. So there is a
//! plane through the tip with the model on one side, and a cone up to 45 degrees has a half space full of directions to
//! choose from, less where thickness and the own layer are in the way; that is why a tilt nearly always frees.

mod along;
mod built;
mod contact;
mod deepest;
mod nozzle;
mod order;
mod tilt;

pub use contact::{ContactError, Contacts, Moment};
pub use deepest::Contact;
pub(crate) use deepest::{Scene, Stand};
pub use nozzle::{Nozzle, NozzleError, NozzlePart};

use crate::Progress;
use crate::layer::{LayerStack, MOULD, Triangle};
use crate::orientation::{LEAST_TURN, SharpTurn, ToolPath, Turns};
use nalgebra::Point3;
use order::Place;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// How gouging is corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct GougingOptions {
    /// How deep the nozzle may enter a layer, as a share of its height: a quarter.
    pub allowed_depth: f64,
    /// No direction is tilted farther than this from the one wanted, or from the one that is known for the place
    /// ([`LayerStack::with_hints`]): 90 degrees, in radians.
    pub max_tilt: f64,
    /// Directions of neighbours may differ by this: 10 degrees, in radians.
    pub max_turn: f64,
    /// How far the nozzle may turn on each millimetre of its way: 10 degrees, in radians. Where no directions that are free turn as
    /// gently as that, the path is cut, and the nozzle turns away from the part. Infinite for any turn.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub max_turn_per_mm: f64,
    /// Whether beads of the same layer that are laid by then count, too: yes.
    pub own_layer: bool,
    /// Whether a path with waypoints that no tilt frees may be printed from its end to its start, if fewer are left that
    /// way: yes. Other beads of the layer are then there before them.
    pub reverse: bool,
    /// Whether a path may be cut where only beads of its own layer close a waypoint in, and the piece around it laid before
    /// the rest of the layer, if fewer are left that way: yes.
    pub cut: bool,
    /// Where no tilt frees the nozzle, its tip may be raised along the direction wanted, which is about across the layer, by so much, in
    /// heights of the layer that is printed: a half. The bead then lies a little higher there, beside what stands higher. 0 for never, 1 at most.
    pub max_lift: f64,
    /// Where the nozzle would be deeper than this in a layer, in heights of the layer that is printed, however it is tilted, that
    /// piece of the path is left out: 1. A machine would not scratch what is built, but run into it. Infinite for never.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub max_depth: f64,
    /// Whether there is a plate at z = 0, below which nothing may reach: yes.
    pub plate: bool,
    /// How far over it the nozzle keeps, in millimetres: 0. Never more than half the height of the tip, since layers may be thin.
    pub plate_clearance: f64,
}

impl Default for GougingOptions {
    fn default() -> Self {
        let max_turn = 10_f64.to_radians();
        GougingOptions {
            allowed_depth: 0.25,
            max_tilt: PI / 2.0,
            max_turn,
            max_turn_per_mm: max_turn,
            own_layer: true,
            reverse: true,
            cut: true,
            max_lift: 0.5,
            max_depth: 1.0,
            plate: true,
            plate_clearance: 0.0,
        }
    }
}

impl GougingOptions {
    /// Defaults for a print in a workcell, which knows its own plate: `plate` is off.
    pub fn in_workcell() -> Self {
        GougingOptions { plate: false, ..GougingOptions::default() }
    }
}

/// A waypoint where the nozzle is too deep in a layer, however it is tilted. Its direction is one that is least deep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gouge {
    /// The path, by its place in the list of paths.
    pub path: usize,
    /// The waypoint, from 0.
    pub waypoint: usize,
    /// What the nozzle is in.
    pub obstacle: Obstacle,
    /// How deep it is in the layer, or how far below the plate, in millimetres.
    pub depth: f64,
    /// Which part of the nozzle is deepest.
    pub part: NozzlePart,
    /// Whether only beads of the same layer close it in: without them a tilt would free it.
    pub own_layer: bool,
}

/// A piece of a curve that is not printed: somewhere on it the nozzle would run into what is built, however it is tilted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// The layer, from 0.
    pub layer: u32,
    /// The curve of the layer, from 0.
    pub curve: u32,
    /// Where it begins and ends, by length along the curve in millimetres.
    pub arcs: [f64; 2],
    /// The tip where the nozzle would be deepest.
    pub tip: Point3<f64>,
    /// What it would be in there.
    pub obstacle: Obstacle,
    /// How deep, in millimetres.
    pub depth: f64,
    /// Which part of it.
    pub part: NozzlePart,
}

impl LeftOut {
    fn new(piece: &ToolPath, gouge: &Gouge) -> Option<LeftOut> {
        let (first, last) = (piece.waypoints.first()?, piece.waypoints.last()?);
        let tip = piece.waypoints.get(gouge.waypoint)?.tip;
        let (&ToolPath { layer, curve, .. }, &Gouge { obstacle, depth, part, .. }) = (piece, gouge);
        Some(LeftOut { layer, curve, arcs: [first.arc, last.arc], tip, obstacle, depth, part })
    }
}

/// What a nozzle runs into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Obstacle {
    /// A layer, from 0; the waypoint's own or an earlier one.
    Layer(u32),
    /// The mould, or the part that existed before.
    Mould,
    /// The plate.
    Plate,
}

impl Obstacle {
    fn of(triangle: &Triangle) -> Self {
        if triangle.layer == MOULD { Obstacle::Mould } else { Obstacle::Layer(triangle.layer) }
    }
}

impl std::fmt::Display for Obstacle {
    /// `layer N`, counted from 1, `mould`, or `plate`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Obstacle::Layer(layer) => write!(f, "layer {}", layer + 1),
            Obstacle::Mould => f.write_str("mould"),
            Obstacle::Plate => f.write_str("plate"),
        }
    }
}

/// Paths along which the nozzle gouges nothing, but for what is listed.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedPaths {
    /// The paths in the order in which they are printed; with points added where neighbours would turn too far. If some were
    /// cut there are more of them than were given: parts know their layer and curve, and arcs go on from where they were cut.
    pub paths: Vec<ToolPath>,
    /// Waypoints that gouged before.
    pub gouging_before: usize,
    /// Waypoints whose direction is another now.
    pub tilted: usize,
    /// The largest tilt, in radians.
    pub max_tilt: f64,
    /// The mean tilt of those that are tilted, in radians.
    pub mean_tilt: f64,
    /// Waypoints whose tip is raised, since no tilt freed them; those on the way up or down from them not counted.
    pub lifted: usize,
    /// The farthest that one is raised, in millimetres.
    pub max_lift: f64,
    /// Waypoints that were added.
    pub added: usize,
    /// Waypoints between samples that no tilt freed and that were taken out again, those added here not counted.
    pub taken_out: usize,
    /// Paths that are printed from their end to their start, in order: fewer waypoints gouge that way.
    pub reversed: Vec<usize>,
    /// Paths that are laid before the rest of their layer, in order: beads of it would close them in. Most are pieces of a
    /// curve, cut out of it.
    pub laid_first: Vec<usize>,
    /// Waypoints that no tilt frees.
    pub left: Vec<Gouge>,
    /// Pieces of curves that are not printed, by layer, curve and place.
    pub left_out: Vec<LeftOut>,
    /// Turns along the paths now.
    pub turns: Turns,
    /// Where paths are cut, since the nozzle would turn too far from one waypoint to the next: the piece that begins there, its first
    /// waypoint, and the turn that it begins with.
    pub cut_turns: Vec<SharpTurn>,
    /// Neighbours between which the nozzle turns more sharply than it should: cut there, more than the width of the bead would be missing, and
    /// the way is free.
    pub sharp: Vec<SharpTurn>,
    /// Length of the paths that is not printed at these cuts, in millimetres: the nozzle is free nowhere between the pieces as it stands in
    /// both. Gaps no longer than the bead is wide do not count: the round ends of the beads fill them.
    pub gaps: f64,
}

impl ResolvedPaths {
    fn none(paths: usize) -> Self {
        ResolvedPaths {
            paths: Vec::with_capacity(paths),
            gouging_before: 0,
            tilted: 0,
            max_tilt: 0.0,
            mean_tilt: 0.0,
            lifted: 0,
            max_lift: 0.0,
            added: 0,
            taken_out: 0,
            reversed: Vec::new(),
            laid_first: Vec::new(),
            left: Vec::new(),
            left_out: Vec::new(),
            turns: Turns::default(),
            cut_turns: Vec::new(),
            sharp: Vec::new(),
            gaps: 0.0,
        }
    }

    /// Takes in what came of a path. The mean tilt is their sum as yet.
    fn take(&mut self, Place { laid, first, freed, .. }: Place) {
        self.added += freed.added;
        self.taken_out += freed.taken_out;
        for &tilt in freed.tilts.iter().filter(|&&tilt| tilt > 0.0) {
            self.tilted += 1;
            self.max_tilt = self.max_tilt.max(tilt);
            self.mean_tilt += tilt;
        }
        let lifts = freed.waypoints.iter().filter(|waypoint| !waypoint.added).map(|waypoint| waypoint.lift.norm());
        for lift in lifts.filter(|&lift| lift > 0.0) {
            self.lifted += 1;
            self.max_lift = self.max_lift.max(lift);
        }
        let (end, closed) = (freed.waypoints.len(), laid.path.closed && freed.cuts.is_empty());
        let starts = [None].into_iter().chain(freed.cuts.iter().copied().map(Some));
        let ends = freed.cuts.iter().map(|&(cut, _)| cut).chain([end]);
        for (start, end) in starts.zip(ends) {
            let (from, turn) = start.unwrap_or((0, 0.0));
            if from > 0 {
                let gap = (freed.waypoints[from].tip - freed.waypoints[from - 1].tip).norm();
                self.gaps += if gap > freed.waypoints[from].width { gap } else { 0.0 };
            }
            let path = self.paths.len();
            self.cut_turns.extend(start.map(|_| SharpTurn { path, waypoint: 0, angle: turn }));
            let sharp = freed.sharp.iter().filter(|(second, _)| (from..end).contains(second));
            self.sharp.extend(sharp.map(|&(second, angle)| SharpTurn { path, waypoint: second - 1 - from, angle }));
            self.reversed.extend(freed.reversed.then_some(path));
            self.laid_first.extend(first.then_some(path));
            let within = |(_, gouge): &(usize, Gouge)| (from..end).contains(&gouge.waypoint);
            let left = freed.left.iter().filter(|left| within(left));
            let mut left: Vec<Gouge> =
                left.map(|(_, gouge)| Gouge { path, waypoint: gouge.waypoint - from, ..*gouge }).collect();
            left.sort_by_key(|gouge| gouge.waypoint);
            self.left.append(&mut left);
            self.paths.push(ToolPath { waypoints: freed.waypoints[from..end].to_vec(), closed, ..laid.path });
        }
    }

    /// Where the tip is at each waypoint, path by path.
    pub fn tips(&self) -> impl Iterator<Item = &Point3<f64>> {
        self.paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| &waypoint.tip)
    }
}

/// Why gouging is not looked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GougingError {
    /// An option that is no use.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// A path names a layer that is not there, or comes after one of a later layer.
    #[error("path {path} is on layer {layer}: there are {layers}, and paths follow them in order")]
    Layer {
        /// The path, from 0.
        path: usize,
        /// Its layer.
        layer: u32,
        /// Layers that there are.
        layers: usize,
    },
    /// A waypoint that is not finite.
    #[error("waypoint {waypoint} of path {path} is not finite or has no unit direction")]
    BadWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// A path without a second waypoint.
    #[error("path {path} has {waypoints} waypoints: it needs two")]
    FewWaypoints {
        /// The path, from 0.
        path: usize,
        /// Its waypoints.
        waypoints: usize,
    },
    /// More waypoints than can be numbered.
    #[error("{waypoints} waypoints are too many: at most 2^31")]
    TooLarge {
        /// All waypoints.
        waypoints: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl GougingOptions {
    fn check(&self) -> Result<(), GougingError> {
        let (turn, clearance) = ((LEAST_TURN..=PI).contains(&self.max_turn), self.plate_clearance);
        let sound = [
            ("allowed_depth", self.allowed_depth, (0.0..=0.5).contains(&self.allowed_depth), "0 to 0.5 layer heights"),
            ("max_tilt", self.max_tilt, (0.0..=PI).contains(&self.max_tilt), "0 to 180 degrees, in radians"),
            ("max_depth", self.max_depth, self.max_depth >= self.allowed_depth, "no less than allowed_depth"),
            ("max_lift", self.max_lift, (0.0..=1.0).contains(&self.max_lift), "0 to 1 layer heights"),
            ("max_turn", self.max_turn, turn, "0.1 to 180 degrees, in radians"),
            (
                "max_turn_per_mm",
                self.max_turn_per_mm,
                self.max_turn_per_mm >= LEAST_TURN,
                "0.1 degrees or more, in radians",
            ),
            ("plate_clearance", clearance, clearance >= 0.0 && clearance.is_finite(), "0 or more, and finite"),
        ];
        match sound.into_iter().find(|(.., sound, _)| !sound) {
            Some((option, value, _, wanted)) => Err(GougingError::Option { option, value, wanted }),
            None => Ok(()),
        }
    }

    /// How far over the plate the nozzle keeps; none without a plate.
    fn over_plate(&self) -> Option<f64> {
        self.plate.then_some(self.plate_clearance)
    }
}

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
    /// let direction = resolved.paths[0].waypoints[5].direction;
    /// assert!(direction.x > 0.3 && direction.y.abs() < 0.05, "{direction:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resolve_gouging(
        &self,
        paths: Vec<ToolPath>,
        nozzle: &Nozzle,
        options: &GougingOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<ResolvedPaths, GougingError> {
        options.check()?;
        self.check_paths(&paths)?;
        let order::Run { places, gouging_before, left_out } =
            order::Resolving { stack: self, nozzle, options, progress }.run(paths)?;
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
            let sound = |w: &crate::orientation::Waypoint| {
                let numbers = [w.width, w.height, w.arc];
                let unit = (w.direction.norm_squared() - 1.0).abs() < 1e-6;
                unit && numbers.iter().chain(w.tip.iter()).all(|n| n.abs() < 1e9)
            };
            if let Some(waypoint) = path.waypoints.iter().position(|w| !sound(w)) {
                return Err(GougingError::BadWaypoint { path: number, waypoint });
            }
        }
        Ok(())
    }
}
