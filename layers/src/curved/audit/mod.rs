//! Whether an order of cells can be built, checked from first principles.
//!
//! The rules are those of the [module](super) (C. Dai, *Material Deposition in 3D Space*, TU Delft 2020, Definitions
//! 1 to 3 in section 3.4.1), and nothing of the growth is used here, nor the hull that it grows with: the audit has
//! its own statement of who supports whom, its own bits, and its own exact hull on integers. Layers are taken in
//! their order. The cells of a layer are checked against everything in earlier layers and the platform, then they
//! join it. What is found wrong is listed and the audit goes on as if the cell had been built all the same, except
//! that a cell that is not of the solid, or was built before, is passed over.

mod body;
mod depth;
mod impossible;
mod nozzle;
mod vec3;
mod wrap;

pub use impossible::{ProofError, check_impossible};
pub use nozzle::JudgedByNozzle;

use super::{Neighbours, NozzleRuleError, Platform, Rules, RulesError};
use crate::cells::{Cells, LayerOrder};
use crate::{Progress, ProgressFn};
use body::Body;
use depth::{Depths, Question};
use nalgebra::Vector3;
use nozzle::{Meets, Obstructions};
use std::collections::BTreeMap;
use std::fmt::{self, Display};

/// Faults of each kind that are listed one by one; the rest are only counted. More would tell a reader nothing new,
/// and for each cell inside the hull that is listed its depth is worked out, which is slow.
const LISTED_FAULTS: usize = 20;

/// Cells of a mould in a cube of so many along each side are held against the nozzle at once.
const TOGETHER: u32 = 4;

/// Cells between two reports of progress: some milliseconds in the worst case.
const CELLS_PER_REPORT: u64 = 1 << 12;

/// What is wrong with an order. Cells are given by their numbers, layers are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Fault {
    /// The cell has no neighbour in an earlier layer or in the mould, and does not stand on the platform.
    Unsupported {
        /// The cell.
        cell: u32,
        /// Its layer.
        layer: u32,
    },
    /// The centre of the cell lies inside the hull of the platform and all earlier layers.
    Inside {
        /// The cell.
        cell: u32,
        /// Its layer.
        layer: u32,
        /// How deep, in cells.
        depth: f64,
    },
    /// The nozzle that prints the cell meets a cell of an earlier layer, or of the mould.
    NozzleMeets {
        /// The cell.
        cell: u32,
        /// Its layer.
        layer: u32,
        /// The cell in the way.
        other: u32,
    },
    /// The nozzle that prints the cell meets the plate.
    NozzleMeetsPlate {
        /// The cell.
        cell: u32,
        /// Its layer.
        layer: u32,
    },
    /// The nozzle that prints the cell leans farther than it may.
    NozzleLeans {
        /// The cell.
        cell: u32,
        /// Its layer.
        layer: u32,
    },
    /// A direction of the nozzle for a cell that is in no layer, or a second one.
    StrayDirection {
        /// The cell.
        cell: u32,
    },
    /// The cell is in an earlier layer already, or twice in this one.
    Repeated {
        /// The cell.
        cell: u32,
        /// The layer in which it comes again.
        layer: u32,
    },
    /// The cell does not belong to the solid.
    NotSolid {
        /// The cell.
        cell: u32,
        /// The layer that holds it.
        layer: u32,
    },
    /// The layer has no cells.
    EmptyLayer {
        /// The layer.
        layer: u32,
    },
    /// The cell of the solid is neither in a layer nor among the missed ones.
    Lost {
        /// The cell.
        cell: u32,
    },
    /// The cell is in a layer and among the missed ones.
    BuiltAndMissed {
        /// The cell.
        cell: u32,
    },
    /// The cell is among the missed ones more than once.
    MissedTwice {
        /// The cell.
        cell: u32,
    },
    /// The cell is among the missed ones and does not belong to the solid.
    MissedNotSolid {
        /// The cell.
        cell: u32,
    },
}

/// How many faults there are of each kind; the kinds are those of [`Fault`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FaultCounts {
    /// Cells without support.
    pub unsupported: usize,
    /// Cells inside the hull.
    pub inside: usize,
    /// Cells whose nozzle meets cells of earlier layers or the plate, or leans too far.
    pub nozzle: usize,
    /// Directions of the nozzle for cells that are not built, or that have one already.
    pub stray_directions: usize,
    /// Entries of layers for cells that were there before.
    pub repeated: usize,
    /// Entries of layers for cells that do not belong to the solid.
    pub not_solid: usize,
    /// Layers without cells.
    pub empty_layers: usize,
    /// Cells neither in a layer nor missed.
    pub lost: usize,
    /// Cells in a layer and missed.
    pub built_and_missed: usize,
    /// Cells missed more than once, counted from the second time on.
    pub missed_twice: usize,
    /// Missed cells that do not belong to the solid.
    pub missed_not_solid: usize,
}

/// What an audit found.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AuditReport {
    /// Cells of the solid.
    pub cells: usize,
    /// Layers of the order.
    pub layers: usize,
    /// Cells of all layers together, each as often as it is listed.
    pub in_layers: usize,
    /// Cells listed as missed.
    pub missed: usize,
    /// Faults of each kind, listed or not.
    pub counts: FaultCounts,
    /// The first 20 faults of each kind, as they were found: layer by layer, then missed cells, then lost ones.
    pub faults: Vec<Fault>,
    /// The largest depth among the faults that are listed, in cells.
    pub max_depth: f64,
}

impl AuditReport {
    /// Whether the order can be built as it is: no fault, and `cells` is `in_layers` and `missed` together.
    pub fn is_ok(&self) -> bool {
        self.faults.is_empty() && self.cells == self.in_layers + self.missed
    }

    fn add(
        &mut self,
        listed: usize,
        count: impl FnOnce(&mut FaultCounts) -> &mut usize,
        fault: impl FnOnce() -> Fault,
    ) {
        let count = count(&mut self.counts);
        *count += 1;
        if *count <= listed {
            let fault = fault();
            if let Fault::Inside { depth, .. } = fault {
                self.max_depth = self.max_depth.max(depth);
            }
            self.faults.push(fault);
        }
    }
}

/// One line: `passed`, or how many faults of which kind.
impl Display for AuditReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let FaultCounts {
            unsupported,
            inside,
            nozzle,
            stray_directions,
            repeated,
            not_solid,
            empty_layers,
            lost,
            built_and_missed,
            missed_twice,
            missed_not_solid,
        } = self.counts;
        let kinds = [
            (unsupported, "without support"),
            (inside, "inside the hull of earlier layers"),
            (nozzle, "where the nozzle meets something or leans too far"),
            (stray_directions, "directions of the nozzle that belong to no cell"),
            (repeated, "built twice"),
            (not_solid, "built but not of the solid"),
            (empty_layers, "empty layers"),
            (lost, "neither built nor missed"),
            (built_and_missed, "both built and missed"),
            (missed_twice, "missed twice"),
            (missed_not_solid, "missed but not of the solid"),
        ];
        let found: Vec<String> =
            kinds.iter().filter(|(count, _)| *count > 0).map(|(count, kind)| format!("{count} {kind}")).collect();
        match found.as_slice() {
            [] if self.is_ok() => f.write_str("passed"),
            [] => write!(f, "{} cells, but {} in layers and {} missed", self.cells, self.in_layers, self.missed),
            found => f.write_str(&found.join(", ")),
        }
    }
}

/// Why an order could not be audited.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AuditError {
    /// The rules are unsound or do not fit the grid.
    #[error(transparent)]
    Rules(#[from] RulesError),
    /// The nozzle is invalid.
    #[error(transparent)]
    Nozzle(#[from] NozzleRuleError),
    /// A layer or the list of missed cells holds a number that no cell of the grid has.
    #[error("there is no cell {cell} in a grid of {len} cells")]
    OutsideGrid {
        /// The number.
        cell: u32,
        /// Cells in the grid.
        len: u32,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Checks an order of `cells` on `platform` against the `rules`.
///
/// # Arguments
/// * `order`: the layers, first to last; cells within a layer in any order.
/// * `missed`: the cells of the solid that are in no layer.
/// * `progress`: called every few thousand cells, with the stage `audit`; may cancel.
///
/// # Errors
/// [`AuditError`] for unsound rules, a number outside the grid, or when cancelled. Whatever else is wrong with the
/// order is no error but a [`Fault`] in the report. Never panics.
///
/// # Cost
/// Three bits of memory for each cell of the grid, and a few bytes for each of its rows. A tenth of a microsecond or
/// two for each cell of a sound order; a cell that is inside costs microseconds to milliseconds. One thread; the report
/// depends on nothing but the arguments.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{Fault, Platform, Rules, audit};
/// use std::ops::ControlFlow;
/// let cells = Cells::new([1, 1, 3], &[1, 1, 1])?; // a column of three cells
/// let platform = Platform::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])?;
/// let mut order = LayerOrder::new();
/// order.push([0]);
/// order.push([2]);
/// let report = audit(&cells, &platform, &Rules::default(), &order, &[1], &|_| ControlFlow::Continue(()))?;
/// assert_eq!(report.faults, [Fault::Unsupported { cell: 2, layer: 2 }]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn audit(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: &LayerOrder,
    missed: &[u32],
    progress: ProgressFn,
) -> Result<AuditReport, AuditError> {
    audit_any(cells, platform, rules, None, (order, missed), LISTED_FAULTS, progress)
}

/// Checks an order of `cells` some of which are judged by the nozzle that prints them, in place of the hull rule: it must stand so that it
/// meets no cell of an earlier layer ([`JudgedByNozzle::steps`]) and not the plate. For the other cells all is as in [`audit`].
///
/// # Errors
/// As [`audit`], and [`AuditError::Nozzle`] for a nozzle that cannot be.
///
/// # Cost
/// That of [`audit`], and for each cell judged by the nozzle one look at every 64 cells of the earlier layers, and at each of those near its nozzle: a
/// nanosecond or less each.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{Fault, JudgedByNozzle, NozzleCell, NozzleRule, Platform, Rules, audit_with_nozzle};
/// use curvlay_layers::nalgebra::Vector3;
/// let cells = Cells::new([1, 1, 3], &[1, 1, 1])?; // a column of three cells
/// let platform = Platform::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])?;
/// let mut order = LayerOrder::new();
/// (0..3).for_each(|cell| order.push([cell]));
/// let directions = [NozzleCell { cell: 2, direction: Vector3::x_axis() }];
/// let judged = JudgedByNozzle { rule: NozzleRule::default(), cell_mm: 1.0, steps: 1, cells: &directions };
/// let rules = Rules::default();
/// let report = audit_with_nozzle(&cells, &platform, &rules, &judged, &order, &[], &|_| std::ops::ControlFlow::Continue(()))?;
/// assert_eq!(report.faults, [Fault::NozzleMeetsPlate { cell: 2, layer: 3 }]); // 2.5 mm above it, with a block of 20 mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn audit_with_nozzle(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    judged: &JudgedByNozzle,
    order: &LayerOrder,
    missed: &[u32],
    progress: ProgressFn,
) -> Result<AuditReport, AuditError> {
    audit_any(cells, platform, rules, Some(judged), (order, missed), LISTED_FAULTS, progress)
}

/// The same as [`audit_with_nozzle`], with a list of up to `listed` faults of each kind instead of 20: for orders of others, in which each fault is to be
/// found again.
///
/// # Arguments
/// * `built`: the layers, and the cells of the solid that are in no layer.
///
/// # Errors
/// As [`audit_with_nozzle`].
///
/// # Cost
/// That of [`audit_with_nozzle`], and for each cell inside the hull that is listed its depth, which takes microseconds to milliseconds.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{JudgedByNozzle, NozzleRule, Platform, Rules, audit_listing};
/// let cells = Cells::new([1, 1, 50], &[1; 50])?; // a column whose upper half comes first
/// let platform = Platform::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])?;
/// let mut order = LayerOrder::new();
/// order.push(25..50);
/// order.push(0..25);
/// let judged = JudgedByNozzle { rule: NozzleRule::default(), cell_mm: 1.0, steps: 1, cells: &[] };
/// let (rules, built) = (Rules::default(), (&order, &[][..]));
/// let report = audit_listing(&cells, &platform, &rules, &judged, built, 1000, &|_| std::ops::ControlFlow::Continue(()))?;
/// // All of the upper half, and of the lower half what touches neither plate nor upper half.
/// assert_eq!((report.counts.unsupported, report.faults.len()), (25 + 23, 48));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn audit_listing(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    judged: &JudgedByNozzle,
    built: (&LayerOrder, &[u32]),
    listed: usize,
    progress: ProgressFn,
) -> Result<AuditReport, AuditError> {
    audit_any(cells, platform, rules, Some(judged), built, listed, progress)
}

fn audit_any(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    judged: Option<&JudgedByNozzle>,
    (order, missed): (&LayerOrder, &[u32]),
    listed: usize,
    progress: ProgressFn,
) -> Result<AuditReport, AuditError> {
    rules.check(cells, platform)?;
    if let Some(judged) = judged {
        judged.rule.check()?;
        if !(judged.cell_mm > 0.0 && judged.cell_mm.is_finite()) {
            return Err(NozzleRuleError::Cell { cell_mm: judged.cell_mm }.into());
        }
    }
    let len = cells.dims().iter().product::<u32>();
    if let Some(&cell) = order.cells().iter().chain(missed).find(|&&cell| cell >= len) {
        return Err(AuditError::OutsideGrid { cell, len });
    }
    let mut audit = Audit::new(cells, platform, rules, judged, listed)?;
    audit.report.layers = order.len();
    audit.report.in_layers = order.cells().len();
    audit.report.missed = missed.len();
    let total = order.cells().len() as u64;
    let mut done = 0;
    for (layer, of_layer) in (1..).zip(order.iter()) {
        if of_layer.is_empty() {
            audit.report.add(audit.max_listed, |counts| &mut counts.empty_layers, || Fault::EmptyLayer { layer });
        }
        for &cell in of_layer {
            if done % CELLS_PER_REPORT == 0 && progress(Progress { stage: "audit", done, total }).is_break() {
                return Err(AuditError::Cancelled);
            }
            done += 1;
            audit.judge(cell, layer);
        }
        audit.end_layer(of_layer);
    }
    // Only now is it known what is built at all.
    audit.judge_missed(missed);
    let _ = progress(Progress { stage: "audit", done, total }); // too late to stop
    Ok(audit.report)
}

/// An audit under way: what is built so far, and what was found.
struct Audit<'a> {
    cells: &'a Cells<'a>,
    rules: &'a Rules,
    corners: &'a [[i32; 2]],
    support: Vec<[i64; 3]>,
    /// Cells in this layer or an earlier one.
    listed: Bits,
    /// Cells in an earlier layer, and those of the mould.
    built: Bits,
    body: Body,
    depths: Depths,
    /// What is built as the nozzle meets it; `None` if it judges no cell.
    obstructions: Option<Obstructions>,
    /// Directions of the nozzle at cells that are still to come.
    directions: BTreeMap<u32, Vector3<f64>>,
    /// Faults of each kind that are listed.
    max_listed: usize,
    report: AuditReport,
}

impl<'a> Audit<'a> {
    /// Before the first layer. A mould is there by then.
    fn new(
        cells: &'a Cells<'a>,
        platform: &'a Platform,
        rules: &'a Rules,
        judged: Option<&'a JudgedByNozzle>,
        listed: usize,
    ) -> Result<Self, AuditError> {
        let question = Question::of(rules, platform)?;
        let mut built = Bits::of(cells);
        let mut body = Body::new(cells.dims(), platform.corners(), platform.top());
        let mut obstructions =
            judged.filter(|judged| !judged.cells.is_empty()).map(|judged| Obstructions::new(judged, platform.top()));
        if let Some(mould) = platform.mould() {
            let mut cells: Vec<(u32, [u32; 3])> = mould.iter().map(|cell| (cell, mould.position(cell))).collect();
            // Those that are asked about together lie together.
            cells.sort_by_key(|(_, place)| place.map(|k| k / TOGETHER));
            for (cell, place) in cells {
                built.insert(place);
                body.add(place);
                obstructions.iter_mut().for_each(|obstructions| obstructions.add(cell, place));
            }
            body.settle();
        }
        let mut report = AuditReport { cells: cells.count(), ..AuditReport::default() };
        let mut directions = BTreeMap::new();
        for printed in judged.iter().flat_map(|judged| judged.cells) {
            if directions.insert(printed.cell, printed.direction.into_inner()).is_some() {
                report.add(
                    listed,
                    |counts| &mut counts.stray_directions,
                    || Fault::StrayDirection { cell: printed.cell },
                );
            }
        }
        Ok(Audit {
            cells,
            rules,
            corners: platform.corners(),
            support: supporters(rules.neighbours),
            listed: Bits::of(cells),
            built,
            depths: Depths::new(question, &body),
            body,
            obstructions,
            directions,
            max_listed: listed,
            report,
        })
    }

    /// Judges a cell of a layer by what earlier layers have built: it must be supported, and be outside of the hull or within reach of the nozzle.
    fn judge(&mut self, cell: u32, layer: u32) {
        let place = self.cells.position(cell);
        if !self.cells.contains(place) {
            self.report.add(self.max_listed, |counts| &mut counts.not_solid, || Fault::NotSolid { cell, layer });
            return;
        }
        if !self.listed.insert(place) {
            self.report.add(self.max_listed, |counts| &mut counts.repeated, || Fault::Repeated { cell, layer });
            return;
        }
        // By what earlier layers have built, `built`, not by what this layer lists.
        let is_supported = stands_on(self.corners, place, self.rules.flat)
            || self.support.iter().any(|&step| self.built.contains_at(place, step));
        if !is_supported {
            self.report.add(self.max_listed, |counts| &mut counts.unsupported, || Fault::Unsupported { cell, layer });
        }
        // The nozzle judges in place of the hull rule. What stays in `directions` belongs to no cell that is built.
        if let (Some(direction), Some(obstructions)) = (self.directions.remove(&cell), &self.obstructions) {
            if let Some(meets) = obstructions.met(place, direction) {
                let fault = || match meets {
                    Meets::Cell(other) => Fault::NozzleMeets { cell, layer, other },
                    Meets::Plate => Fault::NozzleMeetsPlate { cell, layer },
                    Meets::Limit => Fault::NozzleLeans { cell, layer },
                };
                self.report.add(self.max_listed, |counts| &mut counts.nozzle, fault);
            }
            return;
        }
        let centre = place.map(|k| 2 * i64::from(k) + 1);
        let Audit { depths, body, report, max_listed, .. } = self;
        if depths.is_inside(body, centre) {
            let fault = || Fault::Inside { cell, layer, depth: depths.depth(body, centre) };
            report.add(*max_listed, |counts| &mut counts.inside, fault);
        }
    }

    /// Builds a layer: cells of one layer do not shadow each other.
    fn end_layer(&mut self, of_layer: &[u32]) {
        let mut new: Vec<(u32, [u32; 3])> = of_layer.iter().map(|&cell| (cell, self.cells.position(cell))).collect();
        // Faulty entries are listed already; a cell that is built twice counts once.
        new.retain(|&(_, place)| self.cells.contains(place) && self.built.insert(place));
        new.iter().for_each(|&(_, place)| self.body.add(place));
        self.obstructions.iter_mut().for_each(|obstructions| obstructions.end_layer(new.clone()));
        let grown = self.body.settle();
        self.depths.body_grew(&self.body, &grown);
    }

    /// Judges the list of missed cells after the last layer: each cell of the part is built or missed, and no other.
    fn judge_missed(&mut self, missed: &[u32]) {
        let Audit { cells, built, directions, report, max_listed, .. } = self;
        let listed = *max_listed;
        for &cell in directions.keys() {
            report.add(listed, |counts| &mut counts.stray_directions, || Fault::StrayDirection { cell });
        }
        let mut missing = Bits::of(cells);
        for &cell in missed {
            let place = cells.position(cell);
            if !cells.contains(place) {
                report.add(listed, |counts| &mut counts.missed_not_solid, || Fault::MissedNotSolid { cell });
            } else if !missing.insert(place) {
                report.add(listed, |counts| &mut counts.missed_twice, || Fault::MissedTwice { cell });
            } else if built.contains(place) {
                report.add(listed, |counts| &mut counts.built_and_missed, || Fault::BuiltAndMissed { cell });
            }
        }
        for cell in cells.iter() {
            let place = cells.position(cell);
            if !built.contains(place) && !missing.contains(place) {
                report.add(listed, |counts| &mut counts.lost, || Fault::Lost { cell });
            }
        }
    }
}

/// The steps from a cell to those that can support it, nearest first: at distance 1 or the root of 2 (a shared face
/// or edge), or by the letter of Dai's Definition 1 at 1-norm 1 or 2.
fn supporters(rule: Neighbours) -> Vec<[i64; 3]> {
    let steps = (0..125).map(|k| [k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2]);
    let squared = |step: &[i64; 3]| step.iter().map(|k| k * k).sum::<i64>();
    let norm = |step: &[i64; 3]| step.iter().map(|k| k.abs()).sum::<i64>();
    let mut found: Vec<_> = match rule {
        Neighbours::FaceOrEdge => steps.filter(|step| (1..=2).contains(&squared(step))).collect(),
        Neighbours::OneNorm => steps.filter(|step| (1..=2).contains(&norm(step))).collect(),
    };
    // Most cells stand on one that shares a face with them: those are asked first.
    found.sort_by_key(squared);
    found
}

/// Whether a cell of the lowest level has its centre in the closed polygon with the given corners (counter-clockwise), or if `flat` in its
/// range of x.
fn stands_on(corners: &[[i32; 2]], [x, y, z]: [u32; 3], flat: bool) -> bool {
    let [x, y] = [x, y].map(|k| 2 * i64::from(k) + 1);
    if z > 0 {
        return false;
    }
    if flat {
        let along_x = || corners.iter().map(|corner| i64::from(corner[0]));
        return along_x().any(|left| left <= x) && along_x().any(|right| x <= right);
    }
    (0..corners.len()).all(|k| {
        let [[ax, ay], [bx, by]] = [corners[k], corners[(k + 1) % corners.len()]].map(|corner| corner.map(i64::from));
        (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0
    })
}

/// A set of cells of a grid, one bit each.
struct Bits {
    dims: [u32; 3],
    words: Vec<u64>,
}

impl Bits {
    /// An empty set in the grid of `cells`.
    fn of(cells: &Cells) -> Self {
        let dims = cells.dims();
        let len = dims.iter().map(|&side| side as usize).product::<usize>();
        Bits { dims, words: vec![0; len.div_ceil(64)] }
    }

    fn at(&self, [x, y, z]: [u32; 3]) -> (usize, u64) {
        let bit = x as usize + self.dims[0] as usize * (y as usize + self.dims[1] as usize * z as usize);
        (bit / 64, 1 << (bit % 64))
    }

    fn contains(&self, place: [u32; 3]) -> bool {
        let (word, mask) = self.at(place);
        self.words[word] & mask != 0
    }

    /// Whether the set has the cell one `step` away; `false` outside the grid.
    fn contains_at(&self, place: [u32; 3], step: [i64; 3]) -> bool {
        let [x, y, z] = [0, 1, 2].map(|k| i64::from(place[k]) + step[k]);
        let within = |k: i64, side: u32| (0..i64::from(side)).contains(&k);
        let [nx, ny, nz] = self.dims;
        within(x, nx) && within(y, ny) && within(z, nz) && self.contains([x, y, z].map(|k| k as u32))
    }

    /// Adds a cell; returns whether it is new.
    fn insert(&mut self, place: [u32; 3]) -> bool {
        let (word, mask) = self.at(place);
        let new = self.words[word] & mask == 0;
        self.words[word] |= mask;
        new
    }
}
