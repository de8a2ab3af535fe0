//! How a part should lie: where `layers`, which judges poses, meets `voxel`, which makes cells of them.

use crate::args::from_zero;
use crate::bars::Bars;
use crate::mesh::Mesh;
use crate::outcome::Failure;
use clap::Args;
use curvlay_layers::curved::Rules;
use curvlay_layers::curved::orient::{
    JudgedPose, OrientOptions, Pose, PoseCells, PoseError, PoseKind, judge_poses, poses,
};
use curvlay_voxel::{Resolution, VoxelError, VoxelOptions, voxelise};
use nalgebra::Point3;
use std::ops::ControlFlow;

/// How the best pose is searched.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "How the part lies")]
pub struct OrientArgs {
    /// Number of directions to try, spread over the sphere; the flat resting faces of the part are tried as well
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(0..=10_000), allow_negative_numbers = true)]
    pub orient_directions: u32,
    /// Number of cells for the first trial of each pose
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(100..=1_000_000), allow_negative_numbers = true)]
    pub orient_voxels: u64,
    /// Number of best poses that are tried again with five times as many cells
    #[arg(long, value_name = "N", default_value_t = 20, allow_negative_numbers = true)]
    pub refine: usize,
    /// Minimum angle, in degrees, by which a free-standing part can be tipped before it falls
    #[arg(long = "min-tipping", alias = "least-tipping", value_name = "DEGREES", default_value_t = 5.0, value_parser = tipping, allow_negative_numbers = true)]
    pub min_tipping_deg: f64,
    /// Prefers poses in which the part stands by itself
    #[arg(long)]
    pub standing_first: bool,
}

/// First line of files that hold a part in its best pose.
pub const COMMENT: &str = "the part in its best pose, in millimetres, z up, the plate at z = 0";

/// So many times the cells when poses are tried again.
const FINER: u64 = 5;

fn tipping(text: &str) -> Result<f64, String> {
    from_zero(text).and_then(|angle| if angle <= 90.0 { Ok(angle) } else { Err("must be from 0 to 90".to_owned()) })
}

impl OrientArgs {
    /// As the library takes it.
    pub fn options(&self, rules: Rules, platform_diameter_mm: f64) -> OrientOptions {
        OrientOptions {
            directions: self.orient_directions,
            min_tipping: self.min_tipping_deg.to_radians(),
            platform_diameter_mm,
            rules,
            standing_first: self.standing_first,
            ..OrientOptions::default()
        }
    }
}

/// Poses of a part, judged.
#[derive(Clone, Debug)]
pub struct Search {
    /// All poses with large cells, the best first.
    pub coarse: Vec<JudgedPose>,
    /// The best of them, and the given one, with small cells, the best first. [`JudgedPose::number`] is their place in `coarse`.
    pub fine: Vec<JudgedPose>,
    /// Edge of the large and of the small cells, in millimetres.
    pub cell_mm: [f64; 2],
}

impl Search {
    /// The pose that is best.
    pub fn best(&self) -> &JudgedPose {
        &self.ranked()[0]
    }

    /// The pose of the mesh as it is given, on the finest cells that it was tried with.
    pub fn given(&self) -> Option<&JudgedPose> {
        self.ranked().iter().find(|judged| judged.pose.kind == PoseKind::Given)
    }

    /// The poses that were tried with the smallest cells, the best first.
    pub fn ranked(&self) -> &[JudgedPose] {
        if self.fine.is_empty() { &self.coarse } else { &self.fine }
    }
}

/// The mesh as it lies in a pose, its lowest point on the plate.
pub fn laid(mesh: &Mesh, pose: &Pose) -> Mesh {
    Mesh { vertices: pose.lay(&mesh.vertices), triangles: mesh.triangles.clone() }
}

/// Judges all poses with large cells, and the best of them again with small ones.
///
/// # Errors
/// [`Failure`] for a mesh that has no poses or no cells.
pub fn search(mesh: &Mesh, args: &OrientArgs, options: &OrientOptions, bars: &Bars) -> Result<Search, Failure> {
    let found = poses(&mesh.vertices, &mesh.triangles, options)?;
    let (coarse, coarse_mm) = judged(mesh, &found, options, args.orient_voxels, "poses", bars)?;
    let given = coarse.iter().position(|judged| judged.pose.kind == PoseKind::Given);
    let mut again: Vec<usize> = (0..args.refine.min(coarse.len())).collect();
    again.extend(given.filter(|given| *given >= args.refine && args.refine > 0));
    if again.is_empty() {
        return Ok(Search { coarse, fine: Vec::new(), cell_mm: [coarse_mm; 2] });
    }
    let best: Vec<Pose> = again.iter().map(|&place| coarse[place].pose).collect();
    let (mut fine, fine_mm) = judged(mesh, &best, options, FINER * args.orient_voxels, "the best again", bars)?;
    fine.iter_mut().for_each(|judged| judged.number = again[judged.number]);
    Ok(Search { coarse, fine, cell_mm: [coarse_mm, fine_mm] })
}

/// Judges poses with cells of the size that gives so many of them in the given pose. That is searched once: it hardly depends on the pose.
fn judged(
    mesh: &Mesh,
    poses: &[Pose],
    options: &OrientOptions,
    count: u64,
    stage: &str,
    bars: &Bars,
) -> Result<(Vec<JudgedPose>, f64), Failure> {
    let silent = |_| ControlFlow::Continue(());
    let cells = |vertices: &[Point3<f64>], resolution: Resolution| {
        voxelise(vertices, &mesh.triangles, &VoxelOptions { resolution, ..VoxelOptions::default() }, &silent)
    };
    let cell_mm = cells(&mesh.vertices, Resolution::Count(count))?.grid.cell_mm();
    let of_pose = |laid: &[Point3<f64>]| -> Result<PoseCells, VoxelError> {
        let grid = cells(laid, Resolution::Cell(cell_mm))?.grid;
        Ok(PoseCells { dims: grid.dims(), rows: grid.rows().to_vec(), cell_mm })
    };
    let progress = |p: curvlay_layers::Progress| bars.show(stage, p.done, p.total);
    let judged: Result<_, PoseError<VoxelError>> = judge_poses(&mesh.vertices, poses, options, &of_pose, &progress);
    Ok((judged?, cell_mm))
}
