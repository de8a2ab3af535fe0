//! Where the base and the target are for the nominal arm, from linear systems: what Gauss-Newton begins with.

use super::data::MeasuredPose;
use crate::arm::Arm;
use crate::pose::rotation;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Base and target for the nominal arm: `X m - R t - w = p` is linear in the entries of `X`, the rotation from the device to
/// the base, `t` and `w`, for the flange `(R, p)` and the measured position `m`.
pub(super) fn first_frames(poses: &[MeasuredPose], arm: &Arm, lever_mm: f64) -> [Isometry3<f64>; 2] {
    let flanges: Vec<Isometry3<f64>> = poses.iter().map(|pose| arm.forward(&pose.joints)).collect();
    let scale = 1.0 / lever_mm;
    let mut system = DMatrix::zeros(3 * flanges.len(), 15);
    let mut right = DVector::zeros(3 * flanges.len());
    let middle: Vector3<f64> = poses.iter().map(|pose| pose.position.coords).sum::<Vector3<f64>>() / poses.len() as f64;
    for (k, (pose, flange)) in poses.iter().zip(&flanges).enumerate() {
        let turn = flange.rotation.to_rotation_matrix();
        let measured = (pose.position.coords - middle) * scale;
        for axis in 0..3 {
            let row = 3 * k + axis;
            for column in 0..3 {
                system[(row, 3 * axis + column)] = measured[column];
                system[(row, 9 + column)] = -turn[(axis, column)];
            }
            system[(row, 12 + axis)] = -1.0;
            right[row] = flange.translation.vector[axis] * scale;
        }
    }
    // Where positions leave entries open, rotations say them.
    let decomposed = system.svd(true, true);
    let solution = decomposed.solve(&right, 1e-9 * decomposed.singular_values.max()).unwrap_or(DVector::zeros(15));
    let mut turn = nearest_rotation(&Matrix3::from_fn(|row, column| solution[3 * row + column]));
    if let Some(measured) = turn_by_rotations(poses, &flanges) {
        turn = measured;
    }
    // With the rotation, shifts are linear again: R t + w = X m - p.
    let mut system = DMatrix::zeros(3 * flanges.len(), 6);
    let mut right = DVector::zeros(3 * flanges.len());
    for (k, (pose, flange)) in poses.iter().zip(&flanges).enumerate() {
        system.view_mut((3 * k, 0), (3, 3)).copy_from(flange.rotation.to_rotation_matrix().matrix());
        system.view_mut((3 * k, 3), (3, 3)).fill_with_identity();
        right.rows_mut(3 * k, 3).copy_from(&(turn * (pose.position.coords - middle) - flange.translation.vector));
    }
    let shifts = system.svd(true, true).solve(&right, 1e-9).unwrap_or(DVector::zeros(6));
    let away = Vector3::new(shifts[3], shifts[4], shifts[5]);
    let base_world = rotation(&turn);
    let world_base = Isometry3::from_parts(Translation3::from(middle + turn.transpose() * away), base_world.inverse());
    // The mean of what the target's rotation is by each pose.
    let sum: Matrix3<f64> = poses
        .iter()
        .zip(&flanges)
        .filter_map(|(pose, flange)| {
            Some((flange.rotation.inverse() * base_world * pose.rotation?).to_rotation_matrix())
        })
        .map(|turn| turn.into_inner())
        .sum();
    let target_turn = if poses.iter().any(|pose| pose.rotation.is_some()) {
        rotation(&nearest_rotation(&sum))
    } else {
        UnitQuaternion::identity()
    };
    let target = Translation3::new(shifts[0], shifts[1], shifts[2]);
    [world_base, Isometry3::from_parts(target, target_turn)]
}

/// The rotation from the device to the base by measured rotations: `X M = R Y` is linear in the entries of `X` and `Y`.
fn turn_by_rotations(poses: &[MeasuredPose], flanges: &[Isometry3<f64>]) -> Option<Matrix3<f64>> {
    let turned: Vec<_> = poses
        .iter()
        .zip(flanges)
        .filter_map(|(pose, flange)| Some((pose.rotation?.to_rotation_matrix(), flange.rotation.to_rotation_matrix())))
        .collect();
    if turned.len() < 3 {
        return None;
    }
    let mut normal = DMatrix::<f64>::zeros(18, 18);
    for (measured, flange) in turned {
        for row in 0..3 {
            for column in 0..3 {
                let mut equation = DVector::<f64>::zeros(18);
                for k in 0..3 {
                    equation[3 * row + k] = measured[(k, column)];
                    equation[9 + 3 * k + column] = -flange[(row, k)];
                }
                normal += &equation * equation.transpose();
            }
        }
    }
    let eigen = normal.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let column = eigen.eigenvectors.column(least);
    let matrix = Matrix3::from_fn(|row, k| column[3 * row + k]);
    let matrix = if matrix.determinant() < 0.0 { -matrix } else { matrix };
    Some(nearest_rotation(&matrix))
}

/// The rotation next to a matrix (W. Kabsch, Acta Crystallographica A 32, 1976).
fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { unreachable!("both were asked for") };
    let mut sides = Matrix3::identity();
    if (u * v_t).determinant() < 0.0 {
        // Against the direction that the matrix says least of, the last.
        let least = svd.singular_values.imin();
        sides[(least, least)] = -1.0;
    }
    Rotation3::from_matrix_unchecked(u * sides * v_t).into_inner()
}
