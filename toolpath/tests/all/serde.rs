//! Options and reports in files: they come back as they were, and what is misspelt is refused.
#![cfg(feature = "serde")]

use curvlay_toolpath::fill::{fill_layer, fill_layers};
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::orientation::Turns;
use curvlay_toolpath::path::{PathOptions, Pattern};
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::statistics::StatisticsOptions;
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::ops::ControlFlow;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back() {
    for pattern in [Pattern::Spirals, Pattern::Rings, Pattern::Zigzag] {
        comes_back(&PathOptions { pattern, bead: 0.1 + 0.2, ..PathOptions::default() });
    }
    comes_back(&PrintOptions::default());
    comes_back(&PrintOptions::for_robot());
    comes_back(&StatisticsOptions { width_range_mm: [0.6, 1.0 / 3.0], ..StatisticsOptions::default() });
    // What is infinite by default is so in a file as well, as no limit.
    comes_back(&StatisticsOptions::default());
    let never = GougingOptions { max_depth: f64::INFINITY, ..GougingOptions::default() };
    comes_back(&never);
    assert_eq!(serde_json::from_str::<GougingOptions>(r#"{"max_depth": null}"#).unwrap(), never);
    let text = r#"{"pattern": "zigzag", "bead": 0.5}"#;
    let options = PathOptions { pattern: Pattern::Zigzag, bead: 0.5, ..PathOptions::default() };
    assert_eq!(serde_json::from_str::<PathOptions>(text).unwrap(), options);
    assert!(serde_json::from_str::<PathOptions>(r#"{"beads": 0.5}"#).is_err());
    assert!(serde_json::from_str::<PrintOptions>(r#"{"travel": {"lift": 2.0}}"#).is_err());
}

/// Layers with beads, and without room for one.
#[test]
fn filled_layers_come_back() {
    let square = |wide: f64| [[0.0, 0.0], [wide, 0.0], [wide, 7.0], [0.0, 7.0]].map(|[x, y]| Point3::new(x, y, 0.4));
    let level = [[0, 1, 2], [0, 2, 3]];
    // One that a bead fits onto, and one that is too narrow.
    for vertices in [square(11.0), square(0.2)] {
        let surface = LayerSurface { vertices: &vertices, triangles: &level, thickness: &[0.8; 2], is_half: false };
        let filled = fill_layer(&surface, &PathOptions::default(), &|_| ControlFlow::Continue(())).unwrap();
        comes_back(&Some(filled));
    }
}

#[test]
fn reports_come_back() {
    let corners = [[0.0, 0.0, 0.4], [10.0, 0.0, 0.4], [10.0, 7.0, 0.4], [0.0, 7.0, 0.4]].map(Point3::from);
    let surface = LayerSurface::from((&corners[..], &[[0, 1, 2], [0, 2, 3]][..], &[0.8, 0.8][..]));
    let options = PathOptions { bead: 0.8, ..PathOptions::default() };
    let filled = fill_layers(&[surface], &options, &|_| ControlFlow::Continue(())).unwrap();
    comes_back(&filled.totals());
    comes_back(&filled.layers[0].as_ref().unwrap().statistics);
    comes_back(&Turns { steps: 3, largest: 0.1 + 0.2, mean: 1.0 / 3.0, max_per_mm: 2.0 / 3.0 });
}
