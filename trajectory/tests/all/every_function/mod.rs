//! Every public function takes any input: not finite, far out, none, mismatched. The names are read from the sources (by which rule:
//! `names.rs`), so a new function that is not fed here fails.

mod found;
mod indicators;
mod motions;
mod names;
mod numbers;
mod planners;
mod prints;
mod robots;

use std::collections::BTreeSet;
use std::path::Path;

/// Public functions, as `file name`: the tests in this folder feed each.
const FED: [&str; 155] = [
    "bounds.rs Bounds::check",
    "bounds.rs Bounds::is_endless",
    "check/motions.rs check_motion",
    "check/motions.rs check_print",
    "check/report.rs FindingClass::is_unsafe",
    "check/report.rs FindingClass::name",
    "check/report.rs FindingKind::class",
    "check/report.rs PrintReport::is_ok",
    "check/report.rs PrintReport::motions_with",
    "check/report.rs PrintReport::of",
    "check/report.rs PrintReport::share_over_acceleration",
    "check/report.rs PrintReport::share_over_jerk",
    "check/written.rs WrittenMotion::printed",
    "check/written.rs WrittenReport::count",
    "check/written.rs check_written",
    "global/filter.rs smooth_clear_of",
    "global/filter.rs smooth_globally",
    "global/motion.rs GlobalMotion::require_bounds",
    "indicator/contact.rs project",
    "indicator/features.rs OnFeatures::inner",
    "indicator/features.rs OnFeatures::new",
    "indicator/features.rs features_of",
    "indicator/geometric/bodies.rs Twist::sliding",
    "indicator/geometric/bodies.rs Twist::turning",
    "indicator/geometric/bodies.rs Twist::velocity",
    "indicator/geometric/grid.rs DistanceGrid::distance",
    "indicator/geometric/grid.rs DistanceGrid::error_bound",
    "indicator/geometric/grid.rs DistanceGrid::from_cells",
    "indicator/geometric/grid.rs DistanceGrid::from_triangles",
    "indicator/geometric/grid.rs DistanceGrid::gradient",
    "indicator/geometric/grid.rs DistanceGrid::spacing",
    "indicator/geometric/nearest.rs GeometricIndicator::nearest",
    "indicator/geometric/nearest.rs GeometricIndicator::new",
    "indicator/geometric/nearest.rs GeometricIndicator::replace_grid",
    "indicator/geometric/shapes.rs Ball::along",
    "indicator/hard.rs hard_samples",
    "indicator/rates.rs Rates::hit_rate",
    "indicator/rates.rs Rates::missed_rate",
    "indicator/rates.rs Rates::of",
    "indicator/rates.rs Rates::tnr",
    "indicator/rates.rs Rates::trust",
    "indicator/rates.rs verification_samples",
    "indicator/samples.rs random_samples",
    "indicator/samples.rs training_set",
    "indicator/svm/mod.rs Svm::bias",
    "indicator/svm/mod.rs Svm::expansion",
    "indicator/svm/mod.rs Svm::kernels",
    "indicator/svm/mod.rs Svm::shifted",
    "indicator/svm/mod.rs Svm::train",
    "indicator/svm/mod.rs Svm::training",
    "jerk.rs jerk_measure",
    "jerk.rs stencil",
    "jerk.rs waypoint_jerks",
    "ladder/node.rs Ladder::joints",
    "ladder/node.rs Ladder::runs",
    "ladder/plan.rs plan_ladder",
    "ladder/slowest.rs min_speed",
    "local/clear.rs filter_clear_of",
    "local/filter.rs filter_locally",
    "path.rs Defect::left_out",
    "path.rs Defect::waypoint",
    "path.rs TimedPath::left_out",
    "path.rs TimedPath::require_complete",
    "path.rs timed_path",
    "print/home.rs PrintPlan::home_above",
    "print/home.rs PrintPlan::with_homes",
    "print/options.rs PrintLimits::of",
    "print/plan.rs Arrival::duration",
    "print/plan.rs Arrival::postures",
    "print/plan.rs Departure::duration",
    "print/plan.rs Departure::postures",
    "print/plan.rs FaultKind::name",
    "print/plan.rs LayerPlan::factor",
    "print/plan.rs PlanTimes::all",
    "print/plan.rs PrintPlan::count",
    "print/plan.rs PrintPlan::max_filament_mm_s",
    "print/plan.rs PrintPlan::plan_s",
    "print/plan.rs PrintPlan::robot_s",
    "print/plan.rs PrintPlan::steps",
    "print/plan.rs Run::duration",
    "print/plan.rs Run::steps",
    "print/plan.rs Travel::duration",
    "print/plan.rs Travel::postures",
    "print/planner.rs PrintPlanner::into_plan",
    "print/planner.rs PrintPlanner::new",
    "print/planner.rs PrintPlanner::plan",
    "print/planner.rs PrintPlanner::run",
    "print/planner.rs plan_print",
    "print/run_plan.rs path_deviations",
    "print/segments.rs PrintPlan::segments",
    "print/segments.rs PrintPlan::without",
    "print/segments.rs Segment::at",
    "print/segments.rs Segment::duration",
    "print/segments.rs Segment::filament_mm",
    "print/segments.rs Segment::knots",
    "print/segments.rs SegmentKind::name",
    "print/workcell.rs Waypoint::moved",
    "print/workcell.rs Waypoint::of_nozzle",
    "qp/problem.rs BandedQp::add_linear",
    "qp/problem.rs BandedQp::add_quadratic",
    "qp/problem.rs BandedQp::add_row",
    "qp/problem.rs BandedQp::add_soft_row",
    "qp/problem.rs BandedQp::add_square",
    "qp/problem.rs BandedQp::clear",
    "qp/problem.rs BandedQp::new",
    "qp/problem.rs BandedQp::rows",
    "qp/problem.rs BandedQp::variables",
    "qp/solve.rs BandedQp::solve",
    "spline/check.rs Trajectory::extremes",
    "spline/check.rs Trajectory::violations",
    "spline/mod.rs Trajectory::at",
    "spline/mod.rs Trajectory::at_waypoints",
    "spline/mod.rs Trajectory::control",
    "spline/mod.rs Trajectory::jerk",
    "spline/mod.rs Trajectory::joints",
    "spline/mod.rs Trajectory::new",
    "spline/mod.rs Trajectory::pieces",
    "spline/mod.rs Trajectory::span",
    "spline/mod.rs Trajectory::squared_jerk",
    "spline/mod.rs Trajectory::squared_jerk_printing",
    "spline/mod.rs Trajectory::through",
    "spline/mod.rs Trajectory::times",
    "spline/mod.rs Trajectory::waypoints",
    "spline/mod.rs run_in_and_out",
    "spline/timeline.rs Timeline::at_rest",
    "spline/timeline.rs Timeline::knots",
    "spline/timeline.rs Timeline::new",
    "spline/timeline.rs Timeline::row",
    "spline/timeline.rs Timeline::second_derivatives",
    "spline/timeline.rs Timeline::solve",
    "spline/timeline.rs Timeline::step",
    "spline/timeline.rs Timeline::times",
    "spline/timeline.rs Timeline::waypoints",
    "timing/free/plan.rs time_path_free",
    "timing/mod.rs time_path",
    "timing/result.rs TimedMotion::duration",
    "transfer/mod.rs Planned::found",
    "transfer/mod.rs Transfer::at",
    "transfer/mod.rs Transfer::corners",
    "transfer/mod.rs Transfer::duration",
    "transfer/mod.rs Transfer::iterations",
    "transfer/mod.rs Transfer::knots",
    "transfer/mod.rs Transfer::limited",
    "transfer/mod.rs Transfer::through",
    "transfer/mod.rs plan_transfer",
    "transfer/timing.rs SCurve::at",
    "transfer/timing.rs SCurve::duration",
    "transfer/timing.rs SCurve::knots",
    "transfer/timing.rs SCurve::length",
    "transfer/timing.rs SCurve::new",
    "verify/dense.rs dense_postures",
    "verify/dense.rs repair_by_turning",
    "verify/mod.rs Verification::is_free",
    "verify/mod.rs verify",
    "verify/repair.rs repair",
];

/// Panics that are documented.
const PANICS: [(&str, &str); 8] = [
    ("bounds.rs Bounds::is_endless", "a joint that is not there, as with a slice"),
    ("print/segments.rs PrintPlan::segments", "runs that are not there, as with a slice"),
    ("spline/mod.rs Trajectory::control", "a piece that is not there, as with a slice"),
    ("spline/mod.rs Trajectory::jerk", "a piece that is not there, as with a slice"),
    ("spline/timeline.rs Timeline::row", "a knot that is not there, as with a slice"),
    ("spline/timeline.rs Timeline::second_derivatives", "as many angles as knots, as with `copy_from_slice`"),
    ("spline/timeline.rs Timeline::step", "a piece that is not there, as with a slice"),
    ("spline/timeline.rs Timeline::solve", "as many entries as knots, as with `copy_from_slice`"),
];

#[test]
fn every_public_function_is_fed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = folder.join("src");
    let fed: BTreeSet<String> = FED.map(String::from).into();
    assert_eq!(fed, names::reachable(&root), "feed new functions in this folder and name them in FED");
    let files = std::fs::read_dir(folder.join("tests/all/every_function")).unwrap();
    let text: String = files.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    for name in FED.map(|entry| entry.rsplit([' ', ':']).next().unwrap()) {
        let is_called =
            [format!("{name}("), format!("{name}::<"), format!("::{name})")].iter().any(|call| text.contains(call));
        assert!(is_called, "{name} is named but not called");
    }
    for (entry, _) in PANICS {
        let (file, name) = entry.split_once(' ').unwrap();
        let name = name.rsplit(':').next().unwrap();
        let source = std::fs::read_to_string(root.join(file)).unwrap();
        let before = source.split(&format!("pub fn {name}(")).next().unwrap();
        let docs: Vec<&str> =
            before.lines().rev().map(str::trim).skip(1).take_while(|line| line.starts_with("///")).collect();
        assert!(docs.contains(&"/// # Panics"), "{entry} does not say when it panics");
    }
}
