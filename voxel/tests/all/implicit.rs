//! Solids of functions.

use crate::common::go_on;
use curvlay_voxel::nalgebra::{Point3, Vector3};
use curvlay_voxel::{GridError, ImplicitError, ImplicitOptions, VoxelGrid};
use proptest::prelude::*;
use std::cell::Cell;
use std::ops::ControlFlow;

fn bounds(high: f64) -> [Point3<f64>; 2] {
    [Point3::origin(), Point3::new(high, high, high)]
}

fn grid(options: ImplicitOptions, high: f64, f: impl Fn(&Point3<f64>) -> f64) -> Result<VoxelGrid, ImplicitError> {
    VoxelGrid::from_implicit(bounds(high), &options, f, &go_on)
}

/// Distance from the cell to a point, and from the point to the farthest corner, in cells.
fn reach(cell: [u32; 3], at: Vector3<f64>) -> (f64, f64) {
    let low = Vector3::from(cell.map(f64::from));
    let near = at.zip_map(&low, |at, low| at - at.clamp(low, low + 1.0)).norm();
    (near, at.zip_map(&low, |at, low| (at - low).abs().max((at - low - 1.0).abs())).norm())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// With a bound: all cells that meet the ball, none farther than a subcube's half diagonal. Without one: only
    /// cells that meet it, and all that hold a subcube's middle.
    #[test]
    fn guarantees_hold_for_balls(
        at in [0.0..9.0, 0.0..9.0, 0.0..9.0], radius in 0.01f64..5.0, samples in 1u32..4, scale in 0.1f64..10.0
    ) {
        let at = Vector3::from(at);
        let f = |p: &Point3<f64>| scale * ((p.coords - at).norm() - radius);
        let options = ImplicitOptions { samples, ..ImplicitOptions::default() };
        let bound = ImplicitOptions { lipschitz: Some(scale), ..options };
        let (sampled, bounded) = (grid(options, 9.0, f).unwrap(), grid(bound, 9.0, f).unwrap());
        let margin = 3f64.sqrt() / 2.0 / f64::from(samples);
        for id in 0..9 * 9 * 9 {
            let cell = sampled.position(id);
            let (near, far) = reach(cell, at);
            if sampled.contains(cell) {
                prop_assert!(near <= radius + 1e-12);
            }
            if bounded.contains(cell) {
                prop_assert!(near <= radius + margin + 1e-12);
            }
            if near < radius - 1e-12 {
                prop_assert!(bounded.contains(cell));
            }
            if far < radius - 1e-12 {
                prop_assert!(sampled.contains(cell));
            }
        }
    }

    /// Dropping and taking blocks whole changes nothing.
    #[test]
    fn blocks_change_nothing(at in [0.0..20.0, 0.0..20.0, 0.0..20.0], radius in 0.1f64..9.0) {
        let at = Vector3::from(at);
        let f = |p: &Point3<f64>| ((p.coords - at).norm() - radius).min(p.z - 1.5);
        let options = ImplicitOptions { lipschitz: Some(1.0), samples: 1, ..ImplicitOptions::default() };
        let slow = VoxelGrid::from_fn([20; 3], |cell| {
            f(&Point3::from(Vector3::from(cell.map(|c| f64::from(c) + 0.5)))) <= 3f64.sqrt() / 2.0
        });
        prop_assert_eq!(grid(options, 20.0, f).unwrap(), slow.unwrap());
    }
}

#[test]
fn a_bound_saves_most_of_the_calls() {
    let calls = Cell::new(0u64);
    let f = |p: &Point3<f64>| {
        calls.set(calls.get() + 1);
        (p - Point3::new(50.0, 50.0, 50.0)).norm() - 40.0
    };
    let options = ImplicitOptions { lipschitz: Some(1.0), samples: 1, ..ImplicitOptions::default() };
    let solid = grid(options, 100.0, f).unwrap();
    assert!(solid.count() > 268_082, "{} cells, more than the ball's volume", solid.count());
    assert!(calls.get() < 150_000, "{} calls for a million cells", calls.get());
}

#[test]
fn bad_input_is_named() {
    let ball = |p: &Point3<f64>| p.coords.norm() - 1.0;
    let with = |change: fn(&mut ImplicitOptions)| {
        let mut options = ImplicitOptions::default();
        change(&mut options);
        grid(options, 4.0, ball)
    };
    assert_eq!(with(|o| o.samples = 0), Err(ImplicitError::Samples { samples: 0 }));
    assert_eq!(with(|o| o.samples = 65), Err(ImplicitError::Samples { samples: 65 }));
    assert_eq!(with(|o| o.lipschitz = Some(0.0)), Err(ImplicitError::Lipschitz { bound: 0.0 }));
    assert!(matches!(with(|o| o.lipschitz = Some(f64::NAN)), Err(ImplicitError::Lipschitz { .. })));
    assert_eq!(with(|o| o.cell_mm = -1.0), Err(ImplicitError::Grid(GridError::CellSize { cell_mm: -1.0 })));
    let too_fine = |change| match with(change) {
        Err(ImplicitError::TooFine(refused)) => refused,
        other => panic!("{other:?}"),
    };
    assert!(matches!(too_fine(|o| o.cell_mm = 1e-6).cause, GridError::Dims { .. }));
    let refused = too_fine(|o| o.max_bytes = 100);
    assert!(matches!(refused.cause, GridError::Memory { bytes: 128, limit: 100, .. }));
    // Nine rows of a word are 72 bytes, sixteen are 128.
    assert!((refused.fits_mm - 4.0 / 3.0).abs() < 0.01, "{refused}");
    for high in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(grid(ImplicitOptions::default(), high, ball), Err(ImplicitError::Bounds { .. })));
    }
    let hole = grid(ImplicitOptions::default(), 4.0, |p| if p.x > 3.0 { f64::NAN } else { 1.0 });
    assert_eq!(hole, Err(ImplicitError::NotANumber { at: [3.25, 0.25, 0.25] }));
    let options = ImplicitOptions::default();
    let stopped = VoxelGrid::from_implicit(bounds(4.0), &options, ball, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(ImplicitError::Cancelled));
    assert!(grid(ImplicitOptions::default(), 4.0, |_| f64::INFINITY).unwrap().is_empty());
}
