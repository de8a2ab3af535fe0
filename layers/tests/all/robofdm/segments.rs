use super::shapes::{Shape, dumbbell, tee, tripod};
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::robofdm::{MAX_CLUSTERS, RoboFdmError, SegmentOptions, Segmentation, segment};

/// With a given number of clusters of thickness.
pub fn segmented(shape: &Shape, clusters: usize) -> Segmentation {
    let options = SegmentOptions { clusters: Some(clusters), ..SegmentOptions::default() };
    segment(&shape.points, &shape.triangles, &options).unwrap()
}

/// The facet whose middle is nearest to a point.
fn nearest(shape: &Shape, p: [f64; 3]) -> usize {
    let far = |f: &usize| (shape.middle(*f) - Vector3::from(p)).norm();
    (0..shape.triangles.len()).min_by(|f, g| far(f).total_cmp(&far(g))).unwrap()
}

/// The part there.
pub fn part_at(shape: &Shape, segmentation: &Segmentation, p: [f64; 3]) -> u32 {
    segmentation.part_of[nearest(shape, p)]
}

fn all_differ(parts: &[u32]) -> bool {
    parts.iter().enumerate().all(|(i, a)| parts[..i].iter().all(|b| a != b))
}

#[test]
fn a_dumbbell_is_two_balls_and_a_bar_with_upright_planes_between() {
    let shape = dumbbell();
    let segmentation = segmented(&shape, 2);
    assert_eq!((segmentation.parts, segmentation.mixture.means.len()), (3, 2));
    let parts = [[7.0, 7.0, 13.0], [22.0, 7.0, 9.0], [37.0, 7.0, 13.0]].map(|p| part_at(&shape, &segmentation, p));
    assert!(all_differ(&parts));
    // Distances from the skeleton: 2 on the bar, 6 on a ball, and between them on the side of a ball that the skeleton leaves by.
    let [thin, thick] = [segmentation.mixture.means[0].exp(), segmentation.mixture.means[1].exp()];
    assert!((2.0..4.0).contains(&thin) && (5.0..7.0).contains(&thick), "{thin} {thick}");
    let at = |p: [f64; 3]| segmentation.thickness[nearest(&shape, p)];
    assert!((at([22.0, 7.0, 9.0]) - 2.1).abs() < 0.3 && (at([7.0, 7.0, 13.0]) - 6.0).abs() < 0.6);
    assert_eq!(segmentation.borders.len(), 2);
    for border in &segmentation.borders {
        assert!(border.normal.x.abs() > 5f64.to_radians().cos(), "{border:?}");
        // Between the middle of a ball, at 7, and a radius of the bar past where it enters, at 7 + sqrt(36 - 4.4).
        let x = border.origin.x.min(44.0 - border.origin.x);
        assert!((7.0..14.8).contains(&x), "{x}");
        // From the first part to the second.
        let mean = |part: u32| {
            let own: Vec<_> = (0..shape.triangles.len()).filter(|&f| segmentation.part_of[f] == part).collect();
            own.iter().map(|&f| shape.middle(f)).sum::<Vector3<f64>>() / own.len() as f64
        };
        assert!((mean(border.parts[1]) - mean(border.parts[0])).dot(&border.normal) > 0.0);
    }
}

#[test]
fn each_arm_of_a_tee_and_of_a_tripod_is_a_part() {
    for (shape, ends) in [
        (tee(), [[20.0, 7.0, 5.0], [6.0, 7.0, 26.0], [34.0, 7.0, 26.0]]),
        (tripod(), [[22.0, 5.0, 8.0], [5.0, 22.0, 8.0], [8.0, 5.0, 22.0]]),
    ] {
        let segmentation = segmented(&shape, 1);
        assert_eq!(segmentation.parts, 3);
        assert!(all_differ(&ends.map(|p| part_at(&shape, &segmentation, p))));
    }
}

#[test]
fn parts_are_connected_and_borders_lie_between_them() {
    let shape = tripod();
    let segmentation = segmented(&shape, 1);
    assert!(segmentation.part_of.iter().all(|&p| (p as usize) < segmentation.parts));
    // Flood over shared edges with nothing but the definition.
    for part in 0..segmentation.parts as u32 {
        let own: Vec<usize> = (0..shape.triangles.len()).filter(|&f| segmentation.part_of[f] == part).collect();
        let shares =
            |f: usize, g: usize| shape.triangles[f].iter().filter(|v| shape.triangles[g].contains(v)).count() == 2;
        let (mut seen, mut next) = (vec![own[0]], 0);
        while let Some(&f) = seen.get(next) {
            next += 1;
            let new: Vec<usize> = own.iter().copied().filter(|g| !seen.contains(g) && shares(f, *g)).collect();
            seen.extend(new);
        }
        assert_eq!(seen.len(), own.len());
    }
    for border in &segmentation.borders {
        for edge in &border.edges {
            let mut sides: Vec<u32> = (0..shape.triangles.len())
                .filter(|&f| edge.iter().all(|v| shape.triangles[f].contains(v)))
                .map(|f| segmentation.part_of[f])
                .collect();
            sides.sort_unstable();
            assert_eq!(sides, border.parts);
        }
    }
}

#[test]
fn the_criterion_chooses_several_clusters_for_a_dumbbell() {
    let shape = dumbbell();
    let segmentation = segment(&shape.points, &shape.triangles, &SegmentOptions::default()).unwrap();
    let clusters = segmentation.mixture.means.len();
    assert!((2..=MAX_CLUSTERS).contains(&clusters) && segmentation.parts >= 3, "{:?}", segmentation.mixture);
}

#[test]
fn bad_options_are_named() {
    let shape = tee();
    let default = SegmentOptions::default();
    let facets = shape.triangles.len();
    let bad = [
        ("clusters", SegmentOptions { clusters: Some(0), ..default }),
        ("clusters", SegmentOptions { clusters: Some(facets + 1), ..default }),
        ("border_cost", SegmentOptions { border_cost: -1.0, ..default }),
        ("min_part", SegmentOptions { min_part: 2.0, ..default }),
        ("border_offset", SegmentOptions { border_offset: f64::INFINITY, ..default }),
        ("smoothing", SegmentOptions { smoothing: 101, ..default }),
    ];
    for (expected, options) in bad {
        let error = segment(&shape.points, &shape.triangles, &options).unwrap_err();
        assert!(matches!(error, RoboFdmError::Option { name, .. } if name == expected), "{error}");
    }
}
