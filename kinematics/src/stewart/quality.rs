//! How well the legs hold a platform: the Jacobian, a singularity measure ([`Stewart::singularity`]), whole paths, the
//! workspace.

use super::platform::{Stewart, StewartFault};
use crate::pose::{MAX_COORDINATE, is_frame};
use crate::progress::{Progress, ProgressFn};
use nalgebra::{Isometry3, Matrix6, Point3, Translation3, UnitQuaternion, Vector3};

/// A path of poses that the platform can take.
#[derive(Clone, Debug, PartialEq)]
pub struct PathQuality {
    /// Lengths of the legs, pose by pose.
    pub legs: Vec<[f64; 6]>,
    /// Least singularity measure of a pose.
    pub min_singularity: f64,
    /// At which pose.
    pub min_at: usize,
}

/// Why a platform cannot go along a path. Poses are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// There is no pose at all.
    #[error("the path is empty")]
    Empty,
    /// The platform cannot take a pose.
    #[error("pose {index}: {fault}")]
    Fault {
        /// The pose.
        index: usize,
        /// Why.
        fault: StewartFault,
    },
    /// A pose is too near to a singular one.
    #[error("pose {index}: the singularity measure is {measure}, less than {min}")]
    Singular {
        /// The pose.
        index: usize,
        /// Its measure.
        measure: f64,
        /// What was asked for.
        min: f64,
    },
    /// The least measure is not a number.
    #[error("`min_singularity` is not a number")]
    MinSingularity,
    /// Between a pose and the one before there is a singular one: the legs lose the platform on the way.
    #[error("there is a singular pose between pose {index} and the one before it")]
    OtherSide {
        /// The later pose.
        index: usize,
    },
}

/// Where a workspace is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkspaceOptions {
    /// Least corner of the box, of the platform's origin, in the base frame.
    pub lower: Point3<f64>,
    /// Greatest corner.
    pub upper: Point3<f64>,
    /// Cells along x, y and z; their middles are tried.
    pub cells: [u32; 3],
    /// Poses with a lesser singularity measure do not count.
    pub min_singularity: f64,
}

/// What of a box the platform reaches.
#[derive(Clone, Debug, PartialEq)]
pub struct Workspace {
    /// Middles of the cells that it reaches, x fastest.
    pub points: Vec<Point3<f64>>,
    /// Cells tried.
    pub tried: u64,
    /// Volume of those that it reaches, mm^3.
    pub volume_mm3: f64,
}

/// A workspace that cannot be looked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorkspaceError {
    /// The box has no volume, or no cells, or is farther out than 1e6 mm.
    #[error(
        "the box must have corners within 1e6 mm, the upper one above the lower one, and at least one cell each way"
    )]
    Box,
    /// More than fifty million cells.
    #[error("{cells} cells are more than the {max} allowed: take fewer cells")]
    TooMany {
        /// Cells asked for.
        cells: u128,
        /// Cells allowed.
        max: u128,
    },
    /// The least measure is not a number.
    #[error("`min_singularity` is not a number")]
    MinSingularity,
    /// A rotation is not finite, or its quaternion has another length than 1.
    #[error("rotation {index} is invalid: its quaternion must be of length 1")]
    Rotation {
        /// Its place in the input.
        index: usize,
    },
    /// No rotation was given.
    #[error("no rotation was given")]
    NoRotation,
    /// The progress callback cancelled the search.
    #[error("cancelled")]
    Cancelled,
}

/// If all of them are within reach, their points take 1.2 GB.
const MAX_CELLS: u128 = 50_000_000;

impl Stewart {
    /// How fast the legs grow: the lengths' derivatives by the velocity of the platform's origin and the platform's
    /// angular velocity, both in the base frame (mm/s, rad/s). Of a leg of no length the row is not finite.
    pub fn jacobian(&self, base_platform: &Isometry3<f64>) -> Matrix6<f64> {
        self.rows_about(base_platform, &Vector3::zeros(), 1.0)
    }

    /// The same for a point of the platform, turns measured in `1 / unit` radians.
    fn rows_about(&self, pose: &Isometry3<f64>, point: &Vector3<f64>, unit: f64) -> Matrix6<f64> {
        let r = pose.rotation.to_rotation_matrix().into_inner();
        let vectors = self.leg_vectors(&r, &pose.translation.vector);
        let mut rows = Matrix6::zeros();
        for (k, vector) in vectors.iter().enumerate() {
            let along = vector / vector.norm();
            let turn = (r * (self.platform[k] - point)).cross(&along) / unit;
            rows.fixed_view_mut::<1, 3>(k, 0).copy_from(&along.transpose());
            rows.fixed_view_mut::<1, 3>(k, 3).copy_from(&turn.transpose());
        }
        rows
    }

    /// How well the legs hold the platform, from 0 (singular) to sqrt(6). Zero for a pose that is not finite.
    ///
    /// The measure is the least singular value of the Jacobian about the middle of the platform's joints, turns taken as
    /// millimetres at the joints' radius (root of the mean square): moving the platform by 1 mm in the worst way changes
    /// the legs by so many millimetres (as the root of the sum of squares). It is 0 where the legs do not hold the
    /// platform at all, never above sqrt(6), and does not depend on the platform's frame or on the unit of length.
    pub fn singularity(&self, base_platform: &Isometry3<f64>) -> f64 {
        let rows = self.rows_about(base_platform, &self.centre, self.radius);
        if !rows.iter().all(|entry| entry.is_finite()) {
            return 0.0;
        }
        rows.singular_values().min()
    }

    /// Its sign says on which side of the singular poses a pose lies.
    pub(super) fn side(&self, pose: &Isometry3<f64>) -> f64 {
        self.rows_about(pose, &self.centre, self.radius).determinant()
    }

    /// Checks a path of poses: limits, cones and singularity at each, and that no two neighbours lie on different
    /// sides of a singular pose.
    ///
    /// # Errors
    /// [`PathError`] with the index of the first pose that the platform cannot take.
    pub fn check_path(&self, poses: &[Isometry3<f64>], min_singularity: f64) -> Result<PathQuality, PathError> {
        if min_singularity.is_nan() {
            return Err(PathError::MinSingularity);
        }
        let mut quality =
            PathQuality { legs: Vec::with_capacity(poses.len()), min_singularity: f64::INFINITY, min_at: 0 };
        let mut side = 0.0;
        for (index, pose) in poses.iter().enumerate() {
            if let Some(fault) = self.fault(pose) {
                return Err(PathError::Fault { index, fault });
            }
            let measure = self.singularity(pose);
            if measure < min_singularity {
                return Err(PathError::Singular { index, measure, min: min_singularity });
            }
            let now = self.side(pose);
            if now * side < 0.0 {
                return Err(PathError::OtherSide { index });
            }
            side = now;
            if measure < quality.min_singularity {
                (quality.min_singularity, quality.min_at) = (measure, index);
            }
            quality.legs.push(self.legs(pose));
        }
        if poses.is_empty() { Err(PathError::Empty) } else { Ok(quality) }
    }

    /// The cells of a box in whose middle the platform can stand with every one of these rotations.
    ///
    /// # Errors
    /// [`WorkspaceError`]; also when `progress` stops the work.
    ///
    /// # Cost
    /// Some 0.2 microseconds for each cell and rotation out of reach, a few more within.
    pub fn workspace(
        &self,
        rotations: &[UnitQuaternion<f64>],
        options: &WorkspaceOptions,
        progress: ProgressFn<'_>,
    ) -> Result<Workspace, WorkspaceError> {
        let WorkspaceOptions { lower, upper, cells, min_singularity } = *options;
        let size = upper - lower;
        let sound = size.iter().all(|x| *x > 0.0) && cells.iter().all(|&n| n > 0);
        // NaN fails the comparison.
        if !sound || !lower.iter().chain(upper.iter()).all(|x| x.abs() <= MAX_COORDINATE) {
            return Err(WorkspaceError::Box);
        }
        if min_singularity.is_nan() {
            return Err(WorkspaceError::MinSingularity);
        }
        let at = |rotation: &UnitQuaternion<f64>| Isometry3::from_parts(Translation3::identity(), *rotation);
        if let Some(index) = rotations.iter().position(|rotation| !is_frame(&at(rotation))) {
            return Err(WorkspaceError::Rotation { index });
        }
        let count: u128 = cells.iter().map(|&n| u128::from(n)).product();
        if count > MAX_CELLS {
            return Err(WorkspaceError::TooMany { cells: count, max: MAX_CELLS });
        }
        if rotations.is_empty() {
            return Err(WorkspaceError::NoRotation);
        }
        let step = [0, 1, 2].map(|axis| size[axis] / f64::from(cells[axis]));
        let mut points = Vec::new();
        for z in 0..cells[2] {
            let report = Progress { stage: "workspace", done: u64::from(z), total: u64::from(cells[2]) };
            if progress(report).is_break() {
                return Err(WorkspaceError::Cancelled);
            }
            for y in 0..cells[1] {
                for x in 0..cells[0] {
                    let place = [x, y, z];
                    let point = Point3::from([0, 1, 2].map(|k| lower[k] + step[k] * (f64::from(place[k]) + 0.5)));
                    let stands = |rotation: &UnitQuaternion<f64>| {
                        let pose = Isometry3::from_parts(Translation3::from(point), *rotation);
                        self.fault(&pose).is_none() && self.singularity(&pose) >= min_singularity
                    };
                    if rotations.iter().all(stands) {
                        points.push(point);
                    }
                }
            }
        }
        let volume_mm3 = points.len() as f64 * step.iter().product::<f64>();
        Ok(Workspace { points, tried: count as u64, volume_mm3 })
    }
}
