//! Volume decomposition for robots that lay flat layers along several directions.
//!
//! J. Lettori, R. Raffaelli, M. Borsato, M. Pellicciari and M. Peruzzini, "An approach for volume decomposition in robot-based
//! additive manufacturing", CAD'22, 2022. A part is sliced along its direction; the area that each layer carries is followed from
//! layer to layer; where a layer hangs over, a wall is put up before the overhang, and what is beyond it becomes a part that is
//! printed along the wall's normal, and is decomposed in turn.
//!
//! Two kinds of overhang: where the outline crosses the offset of the layer below (Fig. 1b), one wall through the interpolant plane
//! of the intersection points; where it does not (Fig. 1c), four walls around the largest rectangle in the layer that carries,
//! printed in the inverse order.
//!
//! Departures from the paper, each where it says nothing or too little:
//! * Regions of overhang are taken off one after the other, the lowest first; the paper has one.
//! * What a wall cuts that neither hangs over nor floats stays with the part; the paper's walls end with the part.
//! * Where the interpolant plane has no direction across the layers (points of one layer), the line through the points has it.
//! * The four walls of Fig. 4 are tilted below the first layer with overhang as that of Fig. 3 is.
//! * Parts printed before carry those printed later; so the base of a part need not be flat.
//! * What loses its hold behind a wall is in front of the wall's other side: the wall is moved back behind it, or it is a part of its own
//!   that is printed the other way.
//! * The torch is held against what stands and the plate, and of several walls the one is taken beside which less of it is blocked; walls
//!   that lean back are tried as well.

mod audit;
mod base;
mod features;
mod layers;
mod options;
mod part;
mod rectangle;
mod regions;
mod result;
mod separate;
mod take;
mod torch;
mod wall;

use super::{Partition, Solid};
use crate::{Progress, ProgressFn};
use layers::{Stand, analyse};
use nalgebra::Vector3;
use regions::first_region;
use take::{Strategy, Work};
use torch::{Plate, blocked_mm3};

pub use audit::{AuditOptions, PartAudit, VolumeAudit, audit_volumes};
pub use features::{Feature, FeatureKind};
pub use options::{BaseChoice, VolumeError, VolumeOptions};
pub use part::{VolumeLayer, VolumePart};
pub use rectangle::largest_rectangle;
pub use result::{Scenario, Separation, Stuck, StuckReason, VolumeDecomposition};
pub use wall::SeparationWall;

/// A cell that is not finished.
struct Open {
    cell: u32,
    stand: Stand,
    separation: Option<usize>,
}

/// Divides a solid into parts without overhang.
///
/// # Errors
/// [`VolumeError`] for options that cannot be used with this part, and when `progress` breaks off. A part that keeps its overhang is
/// no error: see [`VolumeDecomposition::stuck`].
///
/// # Cost
/// For each separation the layers of one part are sliced, `O(layers * triangles)`, and their polygons offset; where the torch would be blocked
/// or overhang is left, up to some ten walls are tried, and all is done four times. The result does not depend on threads: there is one.
///
/// # Example
/// ```
/// use curvlay_layers::planar::{Solid, VolumeOptions, decompose_volume};
/// // A flipped L: a post of 30 by 30 by 90 mm, and an arm of 60 by 30 by 30 mm at its top.
/// let outline = [[0.0, 0.0], [30.0, 0.0], [30.0, 60.0], [90.0, 60.0], [90.0, 90.0], [30.0, 90.0], [0.0, 90.0], [0.0, 60.0]];
/// let vertices: Vec<_> = [0.0, 30.0].iter().flat_map(|&y| outline.map(|[x, z]| [x, y, z].into())).collect();
/// let mut triangles = Vec::new();
/// for [a, b, c, d] in [[0, 1, 2, 7], [7, 2, 5, 6], [2, 3, 4, 5]] {
///     triangles.extend([[a, b, c], [a, c, d], [a + 8, c + 8, b + 8], [a + 8, d + 8, c + 8]]);
/// }
/// for k in 0..8 {
///     let next = (k + 1) % 8;
///     triangles.extend([[k, k + 8, next + 8], [k, next + 8, next]]);
/// }
/// let solid = Solid::new(&vertices, &triangles)?;
/// let silent = |_| std::ops::ControlFlow::Continue(());
/// let result = decompose_volume(&solid, &VolumeOptions::default(), &silent)?;
/// assert_eq!((result.parts.len(), result.stuck.len()), (2, 0));
/// assert!((result.parts[1].direction.x - 1.0).abs() < 1e-9);
/// // The post carries a layer's height of the arm.
/// assert!((result.parts[1].solid.volume() - 57.0 * 30.0 * 30.0).abs() < 1e-6 * solid.volume());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn decompose_volume(
    solid: &Solid,
    options: &VolumeOptions,
    progress: ProgressFn,
) -> Result<VolumeDecomposition, VolumeError> {
    let [low, high] = solid.bounds();
    options.check((high - low).amax())?;
    let direction = base::direction(solid, options)?;
    let mut best: Option<(Score, VolumeDecomposition)> = None;
    for strategy in STRATEGIES {
        let (score, result) = divide(solid, direction, strategy, options, progress)?;
        if score.overhang_mm3 <= 0.0 && score.blocked_mm3 <= FREE * solid.volume() {
            return Ok(result);
        }
        if best.as_ref().is_none_or(|(least, _)| score.is_better_than(least, solid.volume())) {
            best = Some((score, result));
        }
    }
    best.map_or_else(|| unreachable!("there is a strategy"), |(_, result)| Ok(result))
}

/// The paper's walls; one wall where overhang lies on one side; of these the ones beside which the torch is free; leaning ones as well.
const STRATEGIES: [Strategy; 4] = [
    Strategy { one_sided: false, ..FIRST_WALLS },
    FIRST_WALLS,
    Strategy { judges_torch: true, ..FIRST_WALLS },
    Strategy { judges_torch: true, leans: true, ..FIRST_WALLS },
];

/// The first walls that divide a part.
const FIRST_WALLS: Strategy = Strategy { judges_torch: false, one_sided: true, leans: false, most: usize::MAX };

/// A result of which the torch is blocked at less than this share is taken at once.
const FREE: f64 = 0.001;

/// Share of the solid that a part may cost: fewer parts are better, but not if the torch is blocked at more than this for each.
const PART: f64 = 0.002;

/// Parts that a separation may take: four walls, and as many pieces from their other sides. Where fewer are allowed, the number of parts is why none
/// is made.
const MAX_AT_ONCE: usize = 8;

/// How good a decomposition is.
#[derive(Clone, Copy, Debug)]
struct Score {
    /// Volume that nothing carries.
    overhang_mm3: f64,
    /// Volume that the torch cannot lay.
    blocked_mm3: f64,
    parts: usize,
}

impl Score {
    /// No overhang is better than any; else what is wrong is compared by volume.
    fn is_better_than(&self, other: &Score, whole_mm3: f64) -> bool {
        let cost = |of: &Score| of.overhang_mm3 + of.blocked_mm3 + PART * of.parts as f64 * whole_mm3;
        match (self.overhang_mm3 <= 0.0, other.overhang_mm3 <= 0.0) {
            (true, false) => true,
            (false, true) => false,
            _ => cost(self) < cost(other),
        }
    }
}

/// Divides a solid by one strategy.
fn divide(
    solid: &Solid,
    direction: Vector3<f64>,
    strategy: Strategy,
    options: &VolumeOptions,
    progress: ProgressFn,
) -> Result<(Score, VolumeDecomposition), VolumeError> {
    let base = solid.extent(&direction)[0];
    let mut score = Score { overhang_mm3: 0.0, blocked_mm3: 0.0, parts: 0 };
    let mut result = VolumeDecomposition {
        parts: Vec::new(),
        separations: Vec::new(),
        features: Vec::new(),
        overhang_before_mm3: 0.0,
        stuck: Vec::new(),
    };
    let mut partition = Partition::new(solid);
    let plate = Plate { normal: direction, offset: base };
    let stand = Stand { direction, base, on_plate: true };
    let mut open = vec![Open { cell: 0, stand, separation: None }];
    while let Some(part) = open.pop() {
        let done = result.parts.len() as u64;
        if progress(Progress { stage: "decompose", done, total: done + 1 + open.len() as u64 }).is_break() {
            return Err(VolumeError::Stopped);
        }
        let Ok(own) = partition.part(part.cell) else {
            // Cells are manifolds: they come from cuts, and merges of neighbours.
            debug_assert!(false, "a part is no manifold");
            continue;
        };
        let earlier: Vec<&Solid> = result.parts.iter().map(|part| &part.solid).collect();
        let layered = analyse(&own, &part.stand, &earlier, options);
        let overhang_mm3 = layered.overhang_mm3();
        if result.separations.is_empty() {
            result.overhang_before_mm3 = overhang_mm3;
        }
        let region = first_region(&layered, options);
        let mut stuck = None;
        if let Some(region) = region {
            let work = Work { cell: part.cell, stand: part.stand, own: &own, layered: &layered, region: &region };
            let most = options.max_parts.saturating_sub(result.parts.len() + open.len() + 1);
            let strategy = Strategy { most, ..strategy };
            if let Some((step, rest, taken)) = work.take_off(&mut partition, &earlier, &plate, strategy, options) {
                let number = result.separations.len();
                result.separations.push(step);
                // What was taken off last is printed first: what was cut off before leans on it.
                open.extend(taken.into_iter().map(|(cell, stand)| Open { cell, stand, separation: Some(number) }));
                open.push(Open { cell: rest, ..part });
                continue;
            } else {
                let may_be_more = most >= MAX_AT_ONCE;
                stuck = Some(if may_be_more { StuckReason::NoWall } else { StuckReason::TooManyParts });
            }
        }
        if let Some(reason) = stuck {
            result.stuck.push(Stuck { part: result.parts.len(), reason });
        }
        score.overhang_mm3 += overhang_mm3;
        score.blocked_mm3 += blocked_mm3(&own, &part.stand, &earlier, &plate, options);
        score.parts += 1;
        result.features.extend(&layered.features);
        result.parts.push(VolumePart::of(own, layered, part.stand, part.separation));
    }
    Ok((score, result))
}
