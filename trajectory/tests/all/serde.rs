//! Options, limits and reports in files: they come back as they were, and what is misspelt is refused.
#![cfg(feature = "serde")]

use curvlay_trajectory::check::{
    CheckOptions, Finding, FindingKind, FindingPlace, JointPeaks, PrintPeak, PrintReport, WrittenMotion, WrittenReport,
};
use curvlay_trajectory::indicator::svm::SvmOptions;
use curvlay_trajectory::indicator::{HardOptions, SamplingOptions};
use curvlay_trajectory::print::{PrintLimits, PrintOptions, SegmentKind};
use curvlay_trajectory::qp::QpOptions;
use curvlay_trajectory::transfer::TransferOptions;
use curvlay_trajectory::verify::RepairOptions;
use curvlay_trajectory::{
    Bounds, Cone, FilterOptions, GlobalOptions, LadderOptions, LadderSearch, Norm, PathOptions, Quantity,
    TimeFreeOptions, TimePathOptions,
};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back() {
    comes_back(&LadderOptions::<6, 1>::default());
    let options = LadderOptions::<3, 2> {
        samples: [3, 7],
        step: [0.1 + 0.2, f64::INFINITY, 1.0 / 3.0],
        norm: Norm::Absolute,
        search: LadderSearch::Exact,
        from: Some([0.1, 0.2, 0.3]),
        ..LadderOptions::default()
    };
    comes_back(&options);
    comes_back(&GlobalOptions { cone: Some(Cone { tilts: [1, 2], half_angle: 0.3 }), ..GlobalOptions::default() });
    comes_back(&FilterOptions::<6>::default());
    comes_back(&PrintOptions::<8, 2>::default());
    comes_back(&PathOptions::default());
    comes_back(&TimePathOptions::default());
    comes_back(&TimeFreeOptions::default());
    comes_back(&SamplingOptions::default());
    comes_back(&HardOptions::default());
    comes_back(&SvmOptions::default());
    comes_back(&RepairOptions::default());
    comes_back(&QpOptions::default());
    comes_back(&CheckOptions::default());
    comes_back(&TransferOptions::default());
}

#[test]
fn what_is_left_out_is_the_default_and_what_is_wrong_is_refused() {
    let options = serde_json::from_str::<LadderOptions<2, 1>>(r#"{"samples": [5]}"#).unwrap();
    assert_eq!(options, LadderOptions { samples: [5], ..LadderOptions::default() });
    for wrong in [r#"{"samples": [5, 6]}"#, r#"{"sample": [5]}"#, r#"{"step": [1.0]}"#] {
        assert!(serde_json::from_str::<LadderOptions<2, 1>>(wrong).is_err(), "{wrong}");
    }
    assert!(serde_json::from_str::<CheckOptions>(r#"{"slacks": 1.0}"#).is_err());
    assert!(serde_json::from_str::<Bounds<1>>(r#"{"lower": [null]}"#).is_err());
}

#[test]
fn limits_come_back_and_none_is_null() {
    let bounds = Bounds { jerk: [1.0 / 3.0, f64::INFINITY], lower: [-1.0, f64::NEG_INFINITY], ..Bounds::NONE };
    comes_back(&bounds);
    comes_back(&PrintLimits::of(bounds));
    comes_back(&PrintLimits { max_flow_mm3_s: 12.5, ..PrintLimits::of(bounds) });
    assert!(serde_json::to_string(&bounds).unwrap().starts_with(r#"{"lower":[-1.0,null]"#));
}

#[test]
fn reports_come_back() {
    let finding = |kind| Finding { motion: 1, time: 0.1 + 0.2, count: 3, kind };
    let peak = PrintPeak { value: -1.0 / 3.0, motion: 2, time: 7.0 };
    let print = PrintReport {
        findings: vec![
            finding(FindingKind::Limit { joint: 1, what: Quantity::Jerk, value: -2.5, limit: -2.0 }),
            finding(FindingKind::Skipped { point: 4, distance_mm: f64::INFINITY }),
            finding(FindingKind::Contact { depth_mm: 0.2, what: "layer 3, \"below\"".into() }),
            finding(FindingKind::OutOfReach),
        ],
        gaps: vec![1],
        joints: [JointPeaks { velocity: peak, ..JointPeaks::default() }; 2],
        deviation: Some(peak),
        tilt: None,
        depth: Some(peak),
        seconds: 4.5,
        seconds_over_acceleration: 0.0,
        seconds_over_jerk: 0.25,
        motions: 3,
        pieces: 20,
        samples: 100,
    };
    comes_back(&print);
    let places = vec![FindingPlace { kind: SegmentKind::Approach, layer: 1, path: 2 }; 4];
    comes_back(&WrittenReport { print, places, path_mm: 12.5, printed_mm: 12.0 });
    let (times, joints) = (vec![0.0, 0.1], vec![[0.1, 0.2, 0.3]; 2]);
    comes_back(&WrittenMotion {
        kind: SegmentKind::Print,
        layer: 0,
        path: 0,
        times,
        joints,
        waypoints: vec![(0, 0.0)],
    });
}
