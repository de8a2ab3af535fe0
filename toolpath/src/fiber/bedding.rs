//! What tapes lie on, and what lies on them: a check of tapes among the beads of a print.
//!
//! Dai 2020, section 5.3.1: a layer of thermoplastic is the substrate of the tapes, and a layer on top embeds them. Layers of a part change from one to
//! the next, so a tape that fits on its layer may reach over a place where no bead was laid, or end up outside of the layer above.
//!
//! A tape is wide, so it is cut into strands side by side, none wider than a layer is high. Each strand is a bead of the tape's thickness for
//! [`check_support`]: it *lies on* what was laid before on another layer and is near below it. A strand is *covered* where the same holds the other way round:
//! upside down and in reverse order, so that what is laid later and is near above it comes before it. The same check judges the beads above tapes.
//!
//! The roller presses on the tape, and must press on nothing else: how deep it is in the beads that were laid before is found point by point, by the
//! distance to its axle.

use super::head::LayerTapes;
use super::tape::Tape;
use crate::ProgressFn;
use crate::beads::{BeadGrid, Section, middles, nearest_share};
use crate::cells::{cell_of, with_neighbours};
use crate::orientation::{ToolPath, Waypoint};
use crate::path::BeadKind;
use crate::support::{SupportError, SupportOptions, check_support};
use crate::union_find::{join, root};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::collections::HashMap;

/// More strands than this are refused: the layer height is a slip of the unit.
const MAX_STRANDS: f64 = 1e4;

/// The roller that lays tapes, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roller {
    /// Its diameter, above 0.
    pub diameter: f64,
    /// Its width across the tape, above 0.
    pub width: f64,
}

/// A place where a tape has something wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapePlace {
    /// The layer below the tape, from 0.
    pub layer: u32,
    /// The tape of that layer, from 0, through all lists of it.
    pub tape: usize,
    /// Where, on the tape.
    pub at: Point3<f64>,
    /// Length of the piece of a strand, or depth of the roller, in millimetres.
    pub mm: f64,
}

/// How tapes are bedded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TapeBedding {
    /// Area of all tapes, in square millimetres.
    pub tape_mm2: f64,
    /// Area of what lies on nothing.
    pub on_nothing_mm2: f64,
    /// Area of what nothing covers.
    pub uncovered_mm2: f64,
    /// Pieces of strands that lie on nothing, in the order in which they are laid.
    pub on_nothing: Vec<TapePlace>,
    /// Pieces of strands that nothing covers, from the last layer down.
    pub uncovered: Vec<TapePlace>,
    /// How deep the roller is in the beads below at most, in millimetres, and where; `None` where it is in none.
    pub roller_depth: Option<TapePlace>,
    /// Length of the beads of the print that lie on nothing, with the tapes there, in millimetres.
    pub bead_on_nothing_mm: f64,
    /// Length of all beads, in millimetres.
    pub bead_mm: f64,
}

impl TapeBedding {
    /// Share of the area of the tapes that lies on nothing; 0 without tapes.
    pub fn on_nothing_share(&self) -> f64 {
        share(self.on_nothing_mm2, self.tape_mm2)
    }

    /// Share of the area of the tapes that nothing covers; 0 without tapes.
    pub fn uncovered_share(&self) -> f64 {
        share(self.uncovered_mm2, self.tape_mm2)
    }

    /// Share of the length of the beads that lies on nothing; 0 without beads.
    pub fn bead_on_nothing_share(&self) -> f64 {
        share(self.bead_on_nothing_mm, self.bead_mm)
    }
}

fn share(of: f64, all: f64) -> f64 {
    if of > 0.0 { of / all } else { 0.0 }
}

/// Why tapes cannot be checked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BeddingError {
    /// Lists of tapes, or paths, whose layers do not rise.
    #[error("{what} {number} is of layer {layer}, after one of a later layer")]
    Order {
        /// `path` or `list of tapes`.
        what: &'static str,
        /// Which, from 0.
        number: usize,
        /// Its layer, from 0.
        layer: u32,
    },
    /// A tape without two points with a normal each, or without a finite width and thickness above 0.
    #[error(
        "tape {tape} of layer {layer} has no two points with a normal each, or no finite width and thickness above 0"
    )]
    Tape {
        /// The layer, from 0.
        layer: u32,
        /// The tape, from 0.
        tape: usize,
    },
    /// The roller is invalid.
    #[error("the roller is {diameter} mm thick and {width} mm wide: both must be above 0 and finite")]
    Roller {
        /// Its diameter.
        diameter: f64,
        /// Its width.
        width: f64,
    },
    /// The layer height does not go with the width of the tapes.
    #[error("a tape of {width} mm would have {strands:.0} strands as wide as a layer of {height} mm is high")]
    Strands {
        /// Width of the tape.
        width: f64,
        /// Layer height.
        height: f64,
        /// Strands.
        strands: f64,
    },
    /// Beads or strands that cannot be checked.
    #[error(transparent)]
    Support(#[from] SupportError),
}

/// Checks what tapes lie on, what covers them, and how deep the roller is in what is there.
///
/// # Arguments
/// * `paths`: of the beads, in the order in which they are laid, layer after layer; `tapes`: by layer, each list laid when its layer is complete.
/// * `layer_height`: nominal, in millimetres; `options`: as for [`check_support`], but that strands never span anything.
/// * `progress`: as for [`check_support`], twice; may cancel.
///
/// # Errors
/// [`BeddingError`].
///
/// # Cost
/// Two of [`check_support`], with as many beads more as a tape has strands. The result does not depend on the number of threads.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::Tool;
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::bedding::{BeddingError, Roller, TapeBedding, TapePlace, bedded_surface, tape_bedding};
/// use curvlay_toolpath::fiber::head::LayerTapes;
/// use curvlay_toolpath::fiber::tapes::Tape;
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// use curvlay_toolpath::support::{SupportError, SupportOptions, check_support};
/// // Two layers of a bead 4 mm wide and 30 mm long; a tape on the first one is 40 mm long.
/// let axis = Vector3::z_axis();
/// let at = |x, z| Waypoint { position: Point3::new(x, 0.0, z), axis, width: 4.0, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Solid };
/// let path = |layer, z| ToolPath { layer, curve: 0, closed: false, waypoints: vec![at(0.0, z), at(30.0, z)] };
/// let tape = Tape { points: vec![Point3::new(0.0, 0.0, 0.5), Point3::new(40.0, 0.0, 0.5)], normals: vec![axis; 2], width: 2.0, thickness: 0.08 };
/// let tapes = [LayerTapes { layer: 0, tool: Tool::Roller, lift: 0.0, tapes: vec![tape] }];
/// let options = SupportOptions { plate: false, ..SupportOptions::default() };
/// let roller = Roller { diameter: 20.0, width: 8.0 };
/// let found = tape_bedding(&[path(0, 0.5), path(1, 1.0)], &tapes, 0.5, &roller, &options, &|_| std::ops::ControlFlow::Continue(()))?;
/// // 10 of 40 mm, less the round end of the core and the reach of the check: some 2.4 mm.
/// assert!((0.15..0.25).contains(&found.on_nothing_share()) && (0.15..0.25).contains(&found.uncovered_share()));
/// # Ok::<(), BeddingError>(())
/// ```
pub fn tape_bedding(
    paths: &[ToolPath],
    tapes: &[LayerTapes],
    layer_height: f64,
    roller: &Roller,
    options: &SupportOptions,
    progress: ProgressFn,
) -> Result<TapeBedding, BeddingError> {
    check(paths, tapes, layer_height, roller)?;
    let laid = BeadsAndStrands::of(paths, tapes, layer_height);
    let options = SupportOptions { span_hold: f64::INFINITY, ..*options };
    let below = check_support(&laid.paths, layer_height, &options, progress)?;
    // The world upside down: what comes later and is above is laid before and is below.
    let turned: Vec<ToolPath> = laid.paths.iter().rev().map(turned).collect();
    let from_above = SupportOptions { plate: false, ..options };
    let above = check_support(&turned, layer_height, &from_above, progress)?;

    let mut bedding = TapeBedding { roller_depth: roller_depth(paths, tapes, roller), ..TapeBedding::default() };
    for list in tapes {
        bedding.tape_mm2 += list.tapes.iter().map(|tape| tape.length() * tape.width).sum::<f64>();
    }
    for piece in &below.unsupported {
        match laid.strands[piece.path] {
            Some(strand) => {
                bedding.on_nothing_mm2 += piece.length() * strand.width;
                bedding.on_nothing.push(strand.place(piece.tip, piece.length()));
            }
            None => bedding.bead_on_nothing_mm += piece.length(),
        }
    }
    for piece in &above.unsupported {
        if let Some(strand) = laid.strands[laid.paths.len() - 1 - piece.path] {
            bedding.uncovered_mm2 += piece.length() * strand.width;
            bedding.uncovered.push(strand.place(piece.tip, piece.length()));
        }
    }
    let length = |path: &ToolPath| -> f64 { path.waypoints.windows(2).map(|pair| pair[1].arc - pair[0].arc).sum() };
    bedding.bead_mm = paths.iter().map(length).sum();
    Ok(bedding)
}

fn check(paths: &[ToolPath], tapes: &[LayerTapes], layer_height: f64, roller: &Roller) -> Result<(), BeddingError> {
    let order = |what, layers: &mut dyn Iterator<Item = u32>| {
        let mut before = 0;
        for (number, layer) in layers.enumerate() {
            if layer < before {
                return Err(BeddingError::Order { what, number, layer });
            }
            before = layer;
        }
        Ok(())
    };
    order("path", &mut paths.iter().map(|path| path.layer))?;
    order("list of tapes", &mut tapes.iter().map(|list| list.layer))?;
    let is_size = |value: f64| value > 0.0 && value.is_finite();
    let Roller { diameter, width } = *roller;
    if !(is_size(diameter) && is_size(width)) {
        return Err(BeddingError::Roller { diameter, width });
    }
    for list in tapes {
        for (number, tape) in list.tapes.iter().enumerate() {
            let is_whole = tape.points.len() >= 2 && tape.points.len() == tape.normals.len();
            if !(is_whole && is_size(tape.width) && is_size(tape.thickness)) {
                return Err(BeddingError::Tape { layer: list.layer, tape: number });
            }
            let strands = (tape.width / layer_height).ceil();
            if strands > MAX_STRANDS {
                return Err(BeddingError::Strands { width: tape.width, height: layer_height, strands });
            }
        }
    }
    Ok(())
}

/// Which tape a strand is of.
#[derive(Clone, Copy)]
struct Strand {
    layer: u32,
    tape: usize,
    width: f64,
}

impl Strand {
    fn place(&self, at: Point3<f64>, mm: f64) -> TapePlace {
        TapePlace { layer: self.layer, tape: self.tape, at, mm }
    }
}

/// Beads and strands in the order in which they are laid. Layers have even numbers, and their tapes the odd ones behind them.
struct BeadsAndStrands {
    paths: Vec<ToolPath>,
    /// For each path what strand it is; none for a bead.
    strands: Vec<Option<Strand>>,
}

impl BeadsAndStrands {
    fn of(paths: &[ToolPath], tapes: &[LayerTapes], layer_height: f64) -> BeadsAndStrands {
        let mut laid = BeadsAndStrands { paths: Vec::new(), strands: Vec::new() };
        let mut beads = paths.iter().peekable();
        let mut number = (u32::MAX, 0);
        for list in tapes {
            while let Some(bead) = beads.next_if(|bead| bead.layer <= list.layer) {
                laid.bead(bead);
            }
            number = if number.0 == list.layer { number } else { (list.layer, 0) };
            for tape in &list.tapes {
                laid.tape(tape, list, number.1, layer_height);
                number.1 += 1;
            }
        }
        beads.for_each(|bead| laid.bead(bead));
        laid
    }

    fn bead(&mut self, bead: &ToolPath) {
        self.paths.push(ToolPath { layer: bead.layer.saturating_mul(2), ..bead.clone() });
        self.strands.push(None);
    }

    fn tape(&mut self, tape: &Tape, list: &LayerTapes, number: usize, layer_height: f64) {
        let count = (tape.width / layer_height).ceil().max(1.0);
        let width = tape.width / count;
        for k in 0..count as usize {
            let aside = (k as f64 + 0.5) * width - 0.5 * tape.width;
            let waypoints = strand(tape, list.lift, aside, width);
            self.paths.push(ToolPath {
                layer: list.layer.saturating_mul(2).saturating_add(1),
                curve: k as u32,
                closed: false,
                waypoints,
            });
            self.strands.push(Some(Strand { layer: list.layer, tape: number, width }));
        }
    }
}

/// The direction along a tape at a point of it.
fn along(tape: &Tape, k: usize) -> Vector3<f64> {
    tape.points[(k + 1).min(tape.points.len() - 1)] - tape.points[k.saturating_sub(1)]
}

/// The waypoints of a strand: its top, at a distance from the centre line.
fn strand(tape: &Tape, lift: f64, aside: f64, width: f64) -> Vec<Waypoint> {
    let mut arc = 0.0;
    let waypoint = |k: usize| {
        let normal = tape.normals[k];
        arc += if k > 0 { (tape.points[k] - tape.points[k - 1]).norm() } else { 0.0 };
        let across = normal.cross(&along(tape, k)).try_normalize(1e-12).unwrap_or(Vector3::zeros());
        let tip = tape.points[k] + normal.into_inner() * (lift + tape.thickness) + across * aside;
        Waypoint {
            position: tip,
            axis: normal,
            width,
            height: tape.thickness,
            arc,
            added: false,
            lift: Vector3::zeros(),
            kind: BeadKind::Solid,
        }
    };
    (0..tape.points.len()).map(waypoint).collect()
}

/// The same body upside down: the tip at its other side, the waypoints in reverse.
fn turned(path: &ToolPath) -> ToolPath {
    let end = path.waypoints.last().map_or(0.0, |last| last.arc);
    let waypoint = |at: &Waypoint| Waypoint {
        position: at.position - at.axis.into_inner() * at.height,
        axis: UnitVector3::new_unchecked(-at.axis.into_inner()),
        arc: end - at.arc,
        ..*at
    };
    ToolPath { waypoints: path.waypoints.iter().rev().map(waypoint).collect(), ..path.clone() }
}

/// How deep a roller is in beads that were laid before its tapes: at each point of each tape by the tops of the beads under its width.
fn roller_depth(paths: &[ToolPath], tapes: &[LayerTapes], roller: &Roller) -> Option<TapePlace> {
    // What the roller reaches from its line of contact.
    let reach = (0.5 * roller.diameter).hypot(0.5 * roller.width) + 0.5 * roller.diameter;
    let mut tops: HashMap<[i64; 3], Vec<(u32, Point3<f64>)>> = HashMap::new();
    for path in paths {
        for at in &path.waypoints {
            tops.entry(cell_of(at.bead_top(), reach)).or_default().push((path.layer, at.bead_top()));
        }
    }
    let radius = 0.5 * roller.diameter;
    let mut deepest: Option<TapePlace> = None;
    let mut number = (u32::MAX, 0);
    for list in tapes {
        number = if number.0 == list.layer { number } else { (list.layer, 0) };
        for tape in &list.tapes {
            for (k, point) in tape.points.iter().enumerate() {
                let normal = tape.normals[k].into_inner();
                let contact = point + normal * (list.lift + tape.thickness);
                let across = normal.cross(&along(tape, k)).try_normalize(1e-12).unwrap_or(Vector3::zeros());
                let axle = contact + normal * radius;
                let around = with_neighbours(cell_of(contact, reach));
                for (layer, top) in around.filter_map(|cell| tops.get(&cell)).flatten() {
                    let to = top - axle;
                    let aside = to.dot(&across);
                    if *layer > list.layer || aside.abs() > 0.5 * roller.width {
                        continue;
                    }
                    let depth = radius - (to - across * aside).norm();
                    if depth > deepest.map_or(0.0, |found| found.mm) {
                        deepest = Some(TapePlace { layer: list.layer, tape: number.1, at: contact, mm: depth });
                    }
                }
            }
            number.1 += 1;
        }
    }
    deepest
}

/// How far the beads that bed a tape may be from a corner of its layer's top, in layer heights: less than the check allows
/// ([`SupportOptions::max_distance`]), since a tape's edge lies between corners.
const BED_DISTANCE: f64 = 1.25;

/// Most layer heights that beads may be long: twenty kilometres at 0.2 mm, and seconds of work.
const MAX_BED_STEPS: f64 = 1e8;

/// The part of the top of a layer on which tapes are bedded: at each corner of its triangles a bead of this layer or an earlier one is near below, and one of a later layer
/// near above.
///
/// # Arguments
/// * `top`: the points of [`LayerSurface::top`](crate::layer::LayerSurface::top), and `triangles` those of the layer.
/// * `paths`: of the beads; `layer_height`: nominal, in millimetres.
///
/// # Returns
/// Points and triangles, in their order; a point at which what is left touches itself is there once for each side. Nothing for a height that is
/// not above 0, a corner that is not there, or paths that are not finite or longer than 10^8 layer heights.
///
/// # Cost
/// Near linear in the corners and the length of the paths.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::bedding::bedded_surface;
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// let axis = Vector3::z_axis();
/// let at = |x, z| Waypoint { position: Point3::new(x, 0.0, z), axis, width: 2.0, height: 0.5, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Solid };
/// let path = |layer, end, z| ToolPath { layer, curve: 0, closed: false, waypoints: vec![at(0.0, z), at(end, z)] };
/// let paths = [path(0, 30.0, 0.5), path(1, 10.0, 1.0)];
/// // The second layer ends at 10 mm: what lies beyond is not covered.
/// let top = [[1.0, -0.5], [1.0, 0.5], [8.0, 0.0], [20.0, 0.0]].map(|[x, y]| Point3::new(x, y, 0.5));
/// let (vertices, triangles) = bedded_surface(&top, &[[0, 2, 1], [1, 2, 3]], 0, &paths, 0.5);
/// assert_eq!((vertices.len(), triangles), (3, vec![[0, 1, 2]]));
/// ```
pub fn bedded_surface(
    top: &[Point3<f64>],
    triangles: &[[u32; 3]],
    layer: u32,
    paths: &[ToolPath],
    layer_height: f64,
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let bead_mm: f64 = paths
        .iter()
        .flat_map(|path| path.waypoints.windows(2))
        .map(|pair| (pair[1].position - pair[0].position).norm())
        .sum();
    let is_sound = layer_height > 0.0 && layer_height.is_finite() && bead_mm <= MAX_BED_STEPS * layer_height;
    if !is_sound || triangles.iter().flatten().any(|&corner| corner as usize >= top.len()) {
        return (Vec::new(), Vec::new());
    }
    let reach_mm = BED_DISTANCE * layer_height;
    let near = |is_above: bool| {
        let pieces = paths
            .iter()
            .filter(|path| (path.layer > layer) == is_above)
            .flat_map(|path| path.waypoints.windows(2).map(|pair| [Section::of(&pair[0]), Section::of(&pair[1])]));
        let pieces: Vec<[Section; 2]> = pieces.collect();
        let core = pieces.iter().map(|ends| ends[0].core.max(ends[1].core)).fold(0.0, f64::max);
        let grid = BeadGrid::new(pieces.iter().map(middles), reach_mm + core);
        let is_near = move |at: &Point3<f64>| {
            grid.around(*at).any(|number| {
                let ends = &pieces[number as usize];
                let section = ends[0].toward(&ends[1], nearest_share(ends, *at).clamp(0.0, 1.0));
                let [up, aside] = section.off(*at);
                // The tops of beads below are as high as the tape, or a little higher where layers are squeezed.
                let is_on_side = if is_above { up < 0.0 } else { up > 0.0 };
                is_on_side && up.hypot(aside) <= reach_mm
            })
        };
        top.iter().map(is_near).collect::<Vec<bool>>()
    };
    let [below, above] = [false, true].map(near);
    let is_bedded = |corner: u32| below[corner as usize] && above[corner as usize];
    let kept = triangles.iter().filter(|corners| corners.iter().all(|&corner| is_bedded(corner)));
    in_fans(top, &kept.copied().collect::<Vec<_>>())
}

/// The same triangles with a point for each fan around it: corners of triangles are one where chains of common edges join them.
fn in_fans(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut joined: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    let mut sides: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
    for (number, corners) in (0..).zip(triangles) {
        for k in 0..3 {
            let ends = [k, (k + 1) % 3].map(|k| (corners[k], 3 * number + k as u32));
            let [low, high] = if ends[0].0 < ends[1].0 { ends } else { [ends[1], ends[0]] };
            match sides.get(&[low.0, high.0]) {
                Some(&[a, b]) => {
                    join(&mut joined, a, low.1);
                    join(&mut joined, b, high.1);
                }
                None => _ = sides.insert([low.0, high.0], [low.1, high.1]),
            }
        }
    }
    let mut number = vec![u32::MAX; joined.len()];
    let (mut vertices, mut fans) = (Vec::new(), Vec::with_capacity(triangles.len()));
    for (triangle, corners) in (0..).zip(triangles) {
        fans.push([0, 1, 2].map(|k| {
            let fan = root(&mut joined, 3 * triangle + k) as usize;
            if number[fan] == u32::MAX {
                number[fan] = vertices.len() as u32;
                vertices.push(points[corners[k as usize] as usize]);
            }
            number[fan]
        }));
    }
    (vertices, fans)
}
