//! Options and reports in files: they come back as they were, and what is misspelt is refused.
#![cfg(feature = "serde")]

use curvlay_voxel::inspect::{MeshReport, inspect};
use curvlay_voxel::{ImplicitOptions, OrientReport, Resolution, VoxelOptions, VoxelReport, nalgebra::Point3};
use curvlay_voxel::{orient, voxelise};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::ops::ControlFlow;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back() {
    let at = Resolution::At { cell_mm: 0.1 + 0.2, corner: [-1.0 / 3.0, 1e-300] };
    for resolution in [Resolution::Cell(0.7), Resolution::Count(12), at] {
        comes_back(&VoxelOptions { resolution, max_bytes: 1 << 20 });
    }
    comes_back(&ImplicitOptions { lipschitz: Some(1.5), ..ImplicitOptions::default() });
    let text = r#"{"resolution": {"cell": 0.5}}"#;
    let options = VoxelOptions { resolution: Resolution::Cell(0.5), ..VoxelOptions::default() };
    assert_eq!(serde_json::from_str::<VoxelOptions>(text).unwrap(), options);
    for wrong in [r#"{"resolutions": {"cell": 0.5}}"#, r#"{"resolution": {"cells": 0.5}}"#, r#"{"max_bytes": -1}"#] {
        assert!(serde_json::from_str::<VoxelOptions>(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn reports_come_back() {
    let vertices = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.1, 0.2, 3.3]].map(Point3::from);
    // One triangle is turned, and in the second mesh one is not there.
    for triangles in [vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 3, 2]], vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]]] {
        comes_back::<OrientReport>(&orient(&vertices, &triangles).unwrap().report);
        comes_back::<MeshReport>(&inspect(&vertices, &triangles).unwrap());
        let options = VoxelOptions { resolution: Resolution::Cell(0.3), ..VoxelOptions::default() };
        let solid = voxelise(&vertices, &triangles, &options, &|_| ControlFlow::Continue(())).unwrap();
        comes_back::<VoxelReport>(&solid.report);
    }
}
