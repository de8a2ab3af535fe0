//! Options and reports in files: they come back as they were, and what is misspelt is refused.
#![cfg(feature = "serde")]

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::measure_spacing;
use curvlay_layers::curved::{
    Candidates, GrowthOptions, Neighbours, Platform, Prevention, Rules, Strategy, UnbuildOptions, Visit, audit,
    layer_quality,
};
use curvlay_layers::nalgebra::Point3;
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::ops::ControlFlow;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back() {
    comes_back(&Rules {
        inside_depth_cells: 0.1 + 0.2,
        neighbours: Neighbours::OneNorm,
        flat: true,
        ..Rules::default()
    });
    let (prevention, candidates, visit) = (Prevention::FewerThanAll, Candidates::OfLastLayer, Visit::HighestFirst);
    comes_back(&GrowthOptions { prevention, candidates, visit });
    comes_back(&UnbuildOptions::default());
    for strategy in [Strategy::Unbuild, Strategy::Governed(Prevention::Adaptive)] {
        comes_back(&strategy);
    }
    assert_eq!(
        serde_json::from_str::<Rules>(r#"{"inside_depth_cells": 2.0}"#).unwrap(),
        Rules { inside_depth_cells: 2.0, ..Rules::default() }
    );
    assert!(serde_json::from_str::<Rules>(r#"{"epsilon": 2.0}"#).is_err());
    assert!(serde_json::from_str::<Strategy>(r#""grown""#).is_err());
}

#[test]
fn reports_come_back() {
    let rows = [0b00100, 0b00100, 0b11111];
    let cells = Cells::new([5, 1, 3], &rows).unwrap();
    let platform = Platform::under(&cells, 10.0).unwrap();
    let mut order = LayerOrder::new();
    order.push([2, 12]);
    order.push([7, 10]);
    // Cells without support, inside the hull, and lost: faults of several kinds.
    let progress = |_| ControlFlow::Continue(());
    let report = audit(&cells, &platform, &Rules::default(), &order, &[], &progress).unwrap();
    assert!(report.faults.len() > 2);
    comes_back(&report);
    comes_back(&layer_quality(&cells, &order, Neighbours::FaceOrEdge));
    let level = |z: f64| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]].map(Point3::from);
    let (low, high) = (level(0.5), level(1.6));
    let surfaces = [(&low[..], &[[0, 1, 2]][..]), (&high[..], &[[0, 1, 2]][..])];
    comes_back(&measure_spacing(&surfaces, 1.0, &progress).unwrap());
}
