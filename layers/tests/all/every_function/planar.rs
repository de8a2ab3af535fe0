//! Planar layers: solids, cuts, regions, decompositions by volume and by skeleton.

use super::numbers::{bad, box_of, each_spoilt, mesh, number, point, small, vector};
use crate::common::{BOX, go};
use curvlay_layers::nalgebra::{Isometry3, Point2, Point3, Vector3};
use curvlay_layers::planar::robofdm::{self, *};
use curvlay_layers::planar::*;
use proptest::prelude::*;

fn flat_point() -> impl Strategy<Value = Point2<f64>> {
    [number(), number()].prop_map(Point2::from)
}

fn polygon() -> impl Strategy<Value = SectionPolygon> {
    let ring = || prop::collection::vec(flat_point(), 0..6);
    (ring(), prop::collection::vec(ring(), 0..2)).prop_map(|(outer, holes)| SectionPolygon { outer, holes })
}

fn square(side: f64) -> SectionPolygon {
    let outer = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(Point2::from).to_vec();
    SectionPolygon { outer, holes: vec![] }
}

fn boxed(sides: [f64; 3]) -> Solid {
    Solid::new(&box_of(sides), &BOX).unwrap()
}

/// A box on a thinner one: some of it hangs over.
fn mushroom() -> Solid {
    let (mut points, mut triangles) = (box_of([2.0, 2.0, 4.0]), BOX.to_vec());
    points.extend(box_of([6.0, 6.0, 2.0]).iter().map(|p| p + Vector3::new(-2.0, -2.0, 4.5)));
    triangles.extend(BOX.map(|triangle| triangle.map(|corner| corner + 8)));
    Solid::new(&points, &triangles).unwrap()
}

fn feed_region(region: &Region, other: &Region, numbers: [f64; 3], at: &Point2<f64>) {
    let [a, b, c] = numbers;
    let made = [region.union(other), region.intersection(other), region.difference(other), region.simplified(a)];
    let more = [region.offset(a), region.half([a, b], c), region.half([1.0, 0.0], b)].into_iter().flatten();
    for region in made.into_iter().chain(more).chain([region.clone().without_specks(c)]) {
        let _ = (region.area(), region.is_empty(), region.bounds(), region.centroid(), region.inner_point());
        let _ = (region.contains(at), region.pieces().len(), region.points().count(), region.edges().count());
        assert!(region.polygons().iter().all(|polygon| polygon.area() >= 0.0));
        largest_rectangle(&region);
    }
}

fn feed_solid(solid: &Solid, direction: &Vector3<f64>, numbers: [f64; 3], p: &Point3<f64>) {
    let [a, b, c] = numbers;
    let _ = (solid.volume(), solid.area(), solid.bounds(), solid.extent(direction), solid.winding(p));
    assert!(solid.edge_count() > 0 && solid.vertices().len() > 3 && solid.triangles().len() > 3);
    solid.corners(0);
    for base in [None, Some((a, b)), Some((0.0, c))] {
        for direction in [direction, &Vector3::z()] {
            let _ = (risky_faces(solid, direction, a, base), risky_area(solid, direction, 0.5, base));
        }
    }
    for (direction, height) in [(*direction, 0.5), (Vector3::z(), a)] {
        // As thin as it may be it is only slow.
        let is_few = height.is_nan() || height.abs() > 1e-3;
        let Ok(layers) = flat_layers(solid, &direction, if is_few { height } else { 1.0 }) else { continue };
        let moved = layers.moved(&Isometry3::translation(a, b, c));
        let _ = (layers.layer_at(p), moved.layer_at(p));
        for cell_mm in [1.0, a] {
            cells_by_flat_layer(std::slice::from_ref(&layers), [5, 4, 3], &[31; 12], cell_mm, p);
            cells_by_flat_layer(std::slice::from_ref(&moved), [5, 4, 3], &[31; 2], cell_mm, p);
        }
    }
    let Ok(plane) = CutPlane::through(p, direction) else { return };
    for plane in [plane, plane.moved(a)] {
        let frame = PlaneFrame::of(&plane);
        let _ = (plane.normal(), plane.offset(), plane.height(p), plane.side(p), frame.place(&frame.flat(p)));
        slice(solid, &plane, &frame);
        let mut partition = Partition::new(solid);
        let cut = partition.cut(&[0, 0, u32::MAX], &plane);
        for cell in partition.cells().into_iter().chain([u32::MAX]) {
            let _ = (partition.part(cell), partition.volume(cell), partition.contains(cell, p));
            for other in [0, 1, u32::MAX] {
                let _ = (partition.shared_area(cell, other), partition.shared_points(cell, other));
            }
        }
        partition.merge(cut.above.first().copied().unwrap_or(0), cut.below.first().copied().unwrap_or(u32::MAX));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn regions_take_anything(polygons in prop::collection::vec(polygon(), 0..3), numbers in [number(), number(), number()], at in flat_point()) {
        let sound = Region::new(&[square(3.0)]).unwrap();
        for region in [Region::new(&polygons), Region::new(&[square(2.0)]), Region::new(&[])].into_iter().flatten() {
            feed_region(&region, &sound, numbers, &at);
            feed_region(&sound, &region, numbers, &at);
        }
    }

    #[test]
    fn solids_take_anything(solid in mesh(), direction in vector(), numbers in [number(), number(), number()], p in point(), part in small()) {
        for solid in [Solid::new(&solid.0, &solid.1), Ok(mushroom())].into_iter().flatten() {
            feed_solid(&solid, &direction, numbers, &p);
        }
        let found = slice_uniformly(&part.cells());
        prop_assert_eq!(found.order.cells().len() + found.missed.len(), part.cells().count());
    }
}

const VOLUME: [fn(&mut VolumeOptions, f64); 9] = [
    |options, value| options.layer_mm = value,
    |options, value| options.min_layer_mm = value,
    |options, value| options.area_change = value,
    |options, value| options.angle = value,
    |options, value| options.torch_diameter_mm = value,
    |options, value| options.standoff_mm = value,
    |options, value| options.min_feature_mm = value,
    |options, value| options.tolerance_mm = value,
    |options, value| options.base = BaseChoice::Along(Vector3::new(0.0, value, 1.0)),
];

fn volume_options() -> VolumeOptions {
    VolumeOptions { layer_mm: 0.5, torch_diameter_mm: 1.0, max_parts: 3, ..VolumeOptions::default() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn volumes_take_anything(solid in mesh(), value in bad(), direction in vector(), base in number(), tops in prop::collection::vec(number(), 0..4), counts in prop::sample::select(vec![0, 1, 7]), parts in prop::sample::select(vec![0, 1, usize::MAX])) {
        let all = each_spoilt(&volume_options(), &VOLUME, value).into_iter().chain([VolumeOptions { max_parts: parts, ..volume_options() }]);
        let audits = [
            planar_audit(counts, 0.01), planar_audit(7, value),
        ];
        let solids: Vec<Solid> = Solid::new(&solid.0, &solid.1).into_iter().chain([mushroom()]).collect();
        for (options, solid) in all.flat_map(|options| solids.iter().map(move |solid| (options, solid))) {
            let Ok(found) = decompose_volume(solid, &options, &go) else { continue };
            for audit in &audits {
                let report = audit_volumes(solid, &found.parts, &options, audit);
                report.sum(|part| part.layers_mm2);
            }
            found.parts.iter().for_each(|part| assert!(part.flat_layers().layers.len() <= part.layers.len()));
            found.separations.iter().flat_map(|separation| &separation.walls).for_each(|wall| assert!(wall.normal().x.is_finite()));
        }
        for (direction, base, tops) in [(direction, base, &tops[..]), (Vector3::z(), 0.0, &tops), (Vector3::z(), value, &[1.0, 2.0]), (direction, 0.0, &[1.0])] {
            let Ok(part) = VolumePart::sliced(boxed([2.0, 2.0, 3.0]), &direction, base, tops) else { continue };
            part.flat_layers();
            audit_volumes(&mushroom(), &[part], &volume_options(), &audits[0]);
        }
    }
}

fn planar_audit(count: usize, share: f64) -> curvlay_layers::planar::AuditOptions {
    curvlay_layers::planar::AuditOptions {
        lines: count,
        points: count,
        torch_points: count,
        allowed_share: share,
        allowed_section_share: share,
    }
}

const SKELETON: [fn(&mut SkeletonOptions, f64); 4] = [
    |options, value| options.weight = value,
    |options, value| options.min_edge = value,
    |options, value| options.max_edge = value,
    |options, value| options.min_branch = value,
];
const SEGMENT: [fn(&mut SegmentOptions, f64); 3] = [
    |options, value| options.border_cost = value,
    |options, value| options.min_part = value,
    |options, value| options.border_offset = value,
];
const TUNING: [fn(&mut TuningOptions, f64); 9] = [
    |options, value| options.max_angle = value,
    |options, value| options.platform = value,
    |options, value| options.max_offset = value,
    |options, value| options.max_turn = value,
    |options, value| options.max_section = value,
    |options, value| options.spacing = value,
    |options, value| options.seam_cost = value,
    |options, value| options.min_piece = value,
    |options, value| options.goal = value,
];
const HEAD: [fn(&mut Head, f64); 8] = [
    |head, value| head.tip_radius = value,
    |head, value| head.cone_half_angle = value,
    |head, value| head.cone_height = value,
    |head, value| head.block_radius = value,
    |head, value| head.platform_radius = value,
    |head, value| head.pedestal = value,
    |head, value| head.layer = value,
    |head, value| head.pixel = value,
];
const STRENGTH: [fn(&mut SeamStrength, f64); 5] = [
    |strength, value| strength.density_g_cm3 = value,
    |strength, value| strength.print_force_n = value,
    |strength, value| strength.bond_mpa = value,
    |strength, value| strength.platform_bond_mpa = value,
    |strength, value| strength.safety = value,
];
const AUDIT: [fn(&mut robofdm::AuditOptions, f64); 4] = [
    |options, value| options.layer = value,
    |options, value| options.max_angle = value,
    |options, value| options.max_unsupported = value,
    |options, value| options.max_volume_error = value,
];

fn tuning() -> TuningOptions {
    TuningOptions { perturbations: 2, candidates: 3, normals: 4, halvings: 2, max_parts: 3, ..TuningOptions::default() }
}

fn feed_decomposition(solid: &Solid, found: &Decomposition, numbers: [f64; 3], head: &Head) {
    let [a, b, c] = numbers;
    let _ = (found.risky_mm2(), found.seam_mm2(), found.holds.iter().map(Hold::share).sum::<f64>());
    let seams = found.parts.iter().flat_map(|part| &part.seams);
    seams.for_each(|seam| {
        seam.load_angle(&Vector3::new(a, b, c));
    });
    let audited: Vec<AuditedPart<'_>> = found.parts.iter().map(PrintedPart::audited).collect();
    let sound = robofdm::AuditOptions { points: 4, ..robofdm::AuditOptions::default() };
    let more = robofdm::AuditOptions { head: Some(*head), ..sound };
    for options in each_spoilt(&sound, &AUDIT, a).into_iter().chain([more]) {
        let _ = audit_parts(solid, &audited, &options, &go);
    }
    crossing_sections(&found.parts);
    lowest_pedestal(solid, &found.parts, head);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn parts_by_skeleton_take_anything(solid in mesh(), value in bad(), counts in prop::sample::select(vec![0, 1, 6, usize::MAX]), root in prop::sample::select(vec![0, 1, u32::MAX]), direction in vector(), p in point()) {
        let body = boxed([4.0, 4.0, 30.0]);
        let skeletons = each_spoilt(&SkeletonOptions { max_steps: 4, ..SkeletonOptions::default() }, &SKELETON, value);
        let (rod, sound) = ((body.vertices(), body.triangles()), SegmentOptions { skeleton: skeletons[0], ..SegmentOptions::default() });
        let options = each_spoilt(&sound, &SEGMENT, value).into_iter().chain([SegmentOptions { smoothing: 0, clusters: Some(counts), ..sound }]);
        let options: Vec<SegmentOptions> = options.chain(skeletons.into_iter().map(|skeleton| SegmentOptions { skeleton, ..sound })).collect();
        for (points, triangles) in [rod, (&solid.0, &solid.1)] {
            for options in &options {
                if let Ok(skeleton) = curve_skeleton(points, triangles, &options.skeleton) {
                    let _ = (skeleton.branch_count(), skeleton.branches(), skeleton.distance(p));
                }
                let Ok(segmentation) = segment(points, triangles, options) else { continue };
                let plain = SequenceOptions::default();
                let spoilt = [plain, SequenceOptions { max_angle: value, ..plain }, SequenceOptions { root: Root::Part(root), ..plain }, SequenceOptions { direction: Some(direction), ..plain }, SequenceOptions { platform: value, ..plain }];
                for options in spoilt {
                    let _ = plan_sequence(points, triangles, &segmentation, &options).map(|sequence| sequence.risky_mm2());
                    let _ = plan_sequence(&box_of([1.0; 3]), &BOX, &segmentation, &options);
                }
            }
        }
        let odd = CurveSkeleton { nodes: vec![p], edges: vec![[0, 0]], steps: root };
        let _ = (odd.branch_count(), odd.branches(), odd.distance(p));
    }

    #[test]
    fn tuning_takes_anything(solid in mesh(), value in bad(), counts in prop::sample::select(vec![0, 1, 6]), direction in vector(), numbers in [number(), number(), number()], height in number()) {
        let heads = each_spoilt(&Head::default(), &HEAD, value);
        heads.iter().for_each(|head| { head.radius(height); });
        let rough = tuning();
        let with_heads = heads.iter().map(|&head| TuningOptions { head: Some(head), ..rough });
        let with_strengths = each_spoilt(&SeamStrength::default(), &STRENGTH, value).into_iter().map(|strength| TuningOptions { strength: Some(strength), ..rough });
        let counted = [TuningOptions { candidates: counts, normals: counts, ..rough }, TuningOptions { max_parts: counts, perturbations: counts as u32, halvings: 0, ..rough }];
        let all = each_spoilt(&rough, &TUNING, value).into_iter().chain(with_heads).chain(with_strengths).chain(counted);
        let body = mushroom();
        let solids: Vec<Solid> = Solid::new(&solid.0, &solid.1).into_iter().chain([body]).collect();
        let made_up = |part: u32| PlannedPart { part, parent: (part > 0).then_some(9), base: Some(Point3::new(0.0, 0.0, value)), direction, risky_mm2: value };
        let sequence = BuildSequence { parts: vec![made_up(0), made_up(1)], planes_look_up: true };
        sequence.risky_mm2();
        for (number, tuning) in all.enumerate() {
            for solid in &solids {
                let options = BeamOptions { tuning, direction: if number % 3 == 0 { direction } else { Vector3::z() }, width: 2, branches: counts.min(2) };
                let sequences = [None, Some(&sequence)].map(|sequence| beam_search(solid, sequence, &options, &go));
                for found in sequences.into_iter().chain([tune(solid, &sequence, &tuning, &go)]).flatten() {
                    feed_decomposition(solid, &found, numbers, &heads[number % 9]);
                }
            }
        }
        let corners = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(numbers[0], value, numbers[1])];
        for triangles in [&[][..], &[corners]] {
            let _ = SeamSection::of(triangles).map(|section| section.stress_mpa(numbers[0], value));
        }
        for (direction, layer, height) in [(direction, 0.2, 3.0), (Vector3::z(), numbers[0], 3.0), (Vector3::z(), 0.2, numbers[1])] {
            let Some(pedestal) = Pedestal::new(&solids[0], &direction, layer, height) else { continue };
            let _ = (pedestal.height_mm(), pedestal.volume_mm3(), pedestal.mesh(), pedestal.layers(0.5), pedestal.layers(value));
        }
    }
}
