//! What poses cost: each is made into cells and grown, and they are ranked.

use super::body::check_vertices;
use super::columns::columns_below;
use super::pose::Pose;
use super::{OrientOptions, PoseError};
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::buildable::platform::Platform;
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::strategy::Strategy;
use crate::curved::unbuild::{UnbuildOptions, unbuild};
use crate::parallel::in_parallel_watched;
use nalgebra::Point3;
use std::cmp::Ordering;

/// How often un-building may start again, which costs as much as the first time each. It finds the last few cells of a pose that misses
/// few; a pose that misses many is no better for it.
const LOOK_BACK: u32 = 1;

/// The cells of a part in a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseCells {
    /// Cells along x, y and z. The plate is the plane z = 0.
    pub dims: [u32; 3],
    /// The bits, as [`Cells`] takes them.
    pub rows: Vec<u64>,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
}

/// A pose and what it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedPose {
    /// The pose.
    pub pose: Pose,
    /// Its number in the input.
    pub number: usize,
    /// Whether the part stands by itself: its tipping angle is at least [`OrientOptions::min_tipping`], and not 0.
    pub stands: bool,
    /// Cells of the part.
    pub cells: usize,
    /// How it was grown.
    pub strategy: Strategy,
    /// Cells that no layer builds.
    pub missed_cells: usize,
    /// Volume of these cells. At the skin they are more than the part.
    pub missed_mm3: f64,
    /// Volume of straight columns of cells below the missed ones, down to the part or the plate: at most this much support.
    pub support_mm3: f64,
    /// Layers of cells.
    pub layers: usize,
    /// Height of the cells.
    pub height_mm: f64,
    /// Area of the cells on the plate.
    pub base_mm2: f64,
}

/// Grows a part in each pose and ranks them: see the [module](super#ranking).
///
/// # Arguments
/// * `vertices`: the mesh in millimetres, as [`poses`](super::poses()) took it.
/// * `poses`: what to judge.
/// * `voxelise`: makes the cells of the part from its vertices in a pose, the lowest at z = 0. Cells of one size in all poses. Called on several
///   threads at once.
/// * `progress`: called with the stage `orient` and the number of poses judged; may cancel.
///
/// # Returns
/// All poses, the best first.
///
/// # Errors
/// [`PoseError`]: of poses that cannot be judged, the first one in the input. Cells that cannot be built are no error.
///
/// # Cost
/// That of `voxelise` and of a growth for each pose, shared out among threads. The same input gives the same result on any number of them.
///
/// # Example
/// ```
/// use curvlay_layers::curved::orient::{OrientOptions, PoseCells, judge_poses, poses};
/// use curvlay_layers::nalgebra::Point3;
/// use std::ops::ControlFlow;
/// // A block of 2 x 1 x 4 mm; whoever has a mesh with more to it uses a library to voxelise it.
/// let corner = |k: u32| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { [2.0, 1.0, 4.0][axis] } else { 0.0 }));
/// let vertices: Vec<_> = (0..8).map(corner).collect();
/// let triangles = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let box_of = |laid: &[Point3<f64>]| -> Result<PoseCells, String> {
///     let low = laid.iter().fold(laid[0], |low, at| low.inf(at));
///     let high = laid.iter().fold(laid[0], |high, at| high.sup(at));
///     let dims = [0, 1, 2].map(|axis| (high[axis] - low[axis] - 1e-9).ceil() as u32);
///     Ok(PoseCells { dims, rows: vec![(1 << dims[0]) - 1; (dims[1] * dims[2]) as usize], cell_mm: 1.0 })
/// };
/// let options = OrientOptions { directions: 0, ..OrientOptions::default() };
/// let found = poses(&vertices, &triangles, &options)?;
/// let judged = judge_poses(&vertices, &found, &options, &box_of, &|_| ControlFlow::Continue(()))?;
/// // It lies on its largest face, in one layer.
/// assert_eq!((judged[0].layers, judged[0].base_mm2), (1, 8.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn judge_poses<E, V>(
    vertices: &[Point3<f64>],
    poses: &[Pose],
    options: &OrientOptions,
    voxelise: &V,
    progress: ProgressFn,
) -> Result<Vec<JudgedPose>, PoseError<E>>
where
    E: Send,
    V: Fn(&[Point3<f64>]) -> Result<PoseCells, E> + Sync + ?Sized,
{
    options.check()?;
    if poses.is_empty() {
        return Err(PoseError::NoPose);
    }
    check_vertices(vertices)?;
    let judge = |number: usize, watch: ProgressFn| {
        let pose = poses[number];
        let cells = voxelise(&pose.lay(vertices)).map_err(|error| PoseError::Voxelise { pose: number, error })?;
        Ok((judge(number, pose, &cells, options, watch)?, cells.cell_mm))
    };
    let judged = in_parallel_watched(poses.len(), "orient", progress, judge).ok_or(PoseError::Cancelled)?;
    let judged = judged.into_iter().collect::<Result<Vec<_>, _>>()?;
    let first_mm = judged[0].1;
    let other = judged.iter().position(|(_, cell_mm)| cell_mm.to_bits() != first_mm.to_bits());
    if let Some(pose) = other {
        return Err(PoseError::CellSize { pose, cell_mm: judged[pose].1, first_mm });
    }
    let mut judged: Vec<_> = judged.into_iter().map(|(judged, _)| judged).collect();
    judged.sort_by(|a, b| a.ranked(b, options.standing_first));
    Ok(judged)
}

impl JudgedPose {
    /// Which of two poses comes first.
    fn ranked(&self, other: &Self, standing_first: bool) -> Ordering {
        let by_standing = || other.stands.cmp(&self.stands);
        let first = if standing_first { by_standing() } else { Ordering::Equal };
        first
            .then(self.missed_cells.cmp(&other.missed_cells))
            .then_with(by_standing)
            .then_with(|| self.support_mm3.total_cmp(&other.support_mm3))
            .then_with(|| self.layers.cmp(&other.layers))
            .then_with(|| self.height_mm.total_cmp(&other.height_mm))
            .then_with(|| other.base_mm2.total_cmp(&self.base_mm2))
            .then_with(|| self.number.cmp(&other.number))
    }

    /// Missed cells as a share of all.
    pub fn missed_share(&self) -> f64 {
        self.missed_cells as f64 / self.cells as f64
    }
}

fn judge<E>(
    number: usize,
    pose: Pose,
    made: &PoseCells,
    options: &OrientOptions,
    watch: ProgressFn,
) -> Result<JudgedPose, PoseError<E>> {
    let cell_mm = made.cell_mm;
    if !(cell_mm > 0.0 && cell_mm.is_finite()) {
        return Err(PoseError::CellSize { pose: number, cell_mm, first_mm: cell_mm });
    }
    let cells = Cells::new(made.dims, &made.rows).map_err(|error| PoseError::Cells { pose: number, error })?;
    let radius = options.platform_diameter_mm / 2.0 / cell_mm;
    let platform = Platform::under(&cells, radius).map_err(|error| PoseError::Platform { pose: number, error })?;
    let (strategy, growth) = grown(&cells, &platform, options, watch).map_err(|error| match error {
        GrowthError::Cancelled => PoseError::Cancelled,
        error => PoseError::Growth { pose: number, error },
    })?;
    let level = cells.rows().len() / cells.dims()[2] as usize;
    let on_plate: u32 = cells.rows()[..level].iter().map(|word| word.count_ones()).sum();
    let top = cells.rows().chunks_exact(level).rposition(|rows| rows.iter().any(|&word| word != 0));
    let missed = growth.missed_cells();
    let cell_mm3 = cell_mm.powi(3);
    Ok(JudgedPose {
        pose,
        number,
        stands: pose.tipping > 0.0 && pose.tipping >= options.min_tipping,
        cells: cells.count(),
        strategy,
        missed_cells: missed.len(),
        missed_mm3: missed.len() as f64 * cell_mm3,
        support_mm3: columns_below(&cells, &missed) as f64 * cell_mm3,
        layers: growth.order.len(),
        height_mm: (top.unwrap_or(0) + 1) as f64 * cell_mm,
        base_mm2: f64::from(on_plate) * cell_mm * cell_mm,
    })
}

/// The growth by the strategy of the options; or the incremental one, or where that misses cells the un-built one if that misses
/// fewer.
fn grown(
    cells: &Cells,
    platform: &Platform,
    options: &OrientOptions,
    watch: ProgressFn,
) -> Result<(Strategy, Growth), GrowthError> {
    let OrientOptions { rules, strategy, .. } = options;
    if let Some(strategy) = *strategy {
        return Ok((strategy, strategy.grow(cells, platform, rules, watch)?));
    }
    let incremental = Strategy::Incremental.grow(cells, platform, rules, watch)?;
    if incremental.missed.is_empty() {
        return Ok((Strategy::Incremental, incremental));
    }
    let unbuilt = unbuild(cells, platform, rules, &UnbuildOptions { look_back: LOOK_BACK }, watch)?;
    Ok(if unbuilt.missed.len() < incremental.missed.len() {
        (Strategy::Unbuild, unbuilt)
    } else {
        (Strategy::Incremental, incremental)
    })
}
