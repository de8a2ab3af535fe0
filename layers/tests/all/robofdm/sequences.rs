use super::segments::{part_at, segmented};
use super::shapes::{Shape, dumbbell, tee};
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::robofdm::{BuildSequence, RoboFdmError, Root, SequenceOptions, plan_sequence};

fn planned(shape: &Shape, clusters: usize, options: &SequenceOptions) -> BuildSequence {
    plan_sequence(&shape.points, &shape.triangles, &segmented(shape, clusters), options).unwrap()
}

#[test]
fn a_tee_stands_on_its_stem_and_its_arms_grow_sideways() {
    let shape = tee();
    let root = Root::Part(part_at(&shape, &segmented(&shape, 1), [20.0, 7.0, 5.0]));
    let sequence =
        planned(&shape, 1, &SequenceOptions { root, direction: Some(Vector3::z()), ..SequenceOptions::default() });
    let [stem, first, second] = &sequence.parts[..] else { panic!("{sequence:?}") };
    assert!(sequence.planes_look_up);
    assert_eq!((stem.parent, stem.base, stem.direction), (None, None, Vector3::z()));
    assert_eq!([first.parent, second.parent], [Some(stem.part); 2]);
    let x = [first, second].map(|arm| arm.direction.x);
    assert!(x[0] * x[1] < 0.0 && x.iter().all(|x| x.abs() > 0.8), "{sequence:?}");
    // All of it looked down before; printed sideways, the arms need no support.
    let upright = shape_risk(&shape, Vector3::z());
    assert!(upright > 50.0 && sequence.risky_mm2() < 0.1 * upright, "{upright} {}", sequence.risky_mm2());
}

/// Area that looks down by more than 45 degrees, above the platform.
fn shape_risk(shape: &Shape, up: Vector3<f64>) -> f64 {
    shape
        .triangles
        .iter()
        .map(|t| t.map(|v| shape.points[v as usize]))
        .filter(|t| t.iter().any(|p| p.coords.dot(&up) > 1.5))
        .map(|[a, b, c]| (b - a).cross(&(c - a)) / 2.0)
        .filter(|n| n.normalize().dot(&up) < -(0.5f64.sqrt()))
        .map(|n| n.norm())
        .sum()
}

#[test]
fn a_dumbbell_stands_on_a_ball_and_grows_in_a_row() {
    let shape = dumbbell();
    let segmentation = segmented(&shape, 2);
    let ends: Vec<u32> =
        (0..3).filter(|p| segmentation.borders.iter().filter(|b| b.parts.contains(p)).count() == 1).collect();
    let options = SequenceOptions { root: Root::Part(ends[0]), ..SequenceOptions::default() };
    let sequence = planned(&shape, 2, &options);
    let parents: Vec<_> = sequence.parts.iter().map(|part| part.parent).collect();
    assert_eq!(parents, [None, Some(sequence.parts[0].part), Some(sequence.parts[1].part)]);
    assert_eq!(sequence.parts[2].part, ends[1]);
    // Both planes are upright to the axis, on the way from ball to ball.
    let [bar, ball] = [sequence.parts[1].direction, sequence.parts[2].direction];
    assert!(bar.dot(&ball) > 0.99 && bar.x.abs() > 0.99);
    assert!(sequence.planes_look_up);
    // The direction of the root is no worse than that of the planes on it.
    let along = planned(&shape, 2, &SequenceOptions { direction: Some(bar), ..options });
    assert!(sequence.parts[0].risky_mm2 <= along.parts[0].risky_mm2);
}

#[test]
fn the_best_root_is_no_worse_than_any() {
    let shape = tee();
    let best = planned(&shape, 1, &SequenceOptions::default());
    for part in 0..3 {
        let other = planned(&shape, 1, &SequenceOptions { root: Root::Part(part), ..SequenceOptions::default() });
        assert_eq!(other.parts[0].part, part);
        assert!(!other.planes_look_up || best.risky_mm2() <= other.risky_mm2());
    }
}

#[test]
fn a_plane_that_looks_down_is_reported() {
    let shape = dumbbell();
    let sequence = planned(&shape, 2, &SequenceOptions::default());
    let down = -sequence.parts[1].direction;
    let options = SequenceOptions {
        root: Root::Part(sequence.parts[0].part),
        direction: Some(down),
        ..SequenceOptions::default()
    };
    assert!(!planned(&shape, 2, &options).planes_look_up);
}

#[test]
fn bad_options_are_named() {
    let shape = tee();
    let segmentation = segmented(&shape, 1);
    let error =
        |options: SequenceOptions| plan_sequence(&shape.points, &shape.triangles, &segmentation, &options).unwrap_err();
    let default = SequenceOptions::default();
    assert_eq!(error(SequenceOptions { root: Root::Part(3), ..default }), RoboFdmError::Root { root: 3, parts: 3 });
    let bad = [
        ("max_angle", SequenceOptions { max_angle: 0.0, ..default }),
        ("max_angle", SequenceOptions { max_angle: std::f64::consts::FRAC_PI_2, ..default }),
        ("platform", SequenceOptions { platform: -1.0, ..default }),
        ("direction", SequenceOptions { direction: Some(Vector3::zeros()), ..default }),
    ];
    for (expected, options) in bad {
        let error = error(options);
        assert!(matches!(error, RoboFdmError::Option { name, .. } if name == expected), "{error}");
    }
    let other = dumbbell();
    let error = plan_sequence(&other.points, &other.triangles, &segmentation, &default).unwrap_err();
    assert!(matches!(error, RoboFdmError::OtherMesh { .. }));
}
