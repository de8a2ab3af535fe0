//! Bodies of links: they contain the makers' meshes, an allowance makes them thicker, and arms without them are refused.

use crate::common;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, link_source, links};
use curvlay_kinematics::workcell::GrowingOptions;
use curvlay_kinematics::{Arm, ArmModel, Geometry, robots};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// How far the makers' meshes reach along some directions, in the frames of the arm: see the sources of the bodies.
const EXTENTS: &str = include_str!("links/extents.csv");

/// How far a shape reaches along a direction.
fn extent(shape: &Shape, along: &Vector3<f64>) -> f64 {
    let farthest =
        |points: &[Point3<f64>]| points.iter().map(|p| along.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max);
    match shape {
        Shape::Hull { points, radius } => farthest(points) + radius,
        Shape::Union(shapes) => shapes.iter().map(|shape| extent(shape, along)).fold(f64::NEG_INFINITY, f64::max),
        Shape::Capsule { from, to, radius } => farthest(&[*from, *to]) + radius,
        Shape::Mesh { .. } | Shape::Cells { .. } => panic!("links are convex pieces"),
    }
}

fn arm_of(name: &str) -> &'static ArmModel {
    &robots::find(name).unwrap().model
}

/// The arms whose bodies were measured or estimated from a mesh.
const WITH_BODIES: [&str; 7] = ["UR3", "UR3e", "UR5", "UR5e", "UR10", "IRB120", "IRB1200"];

#[test]
fn bodies_reach_as_far_as_the_makers_meshes() {
    let mut rows = 0;
    for row in EXTENTS.lines().skip(1) {
        let (name, numbers) = row.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().unwrap()).collect();
        let along = Vector3::new(numbers[1], numbers[2], numbers[3]).normalize();
        let body = &links(arm_of(name))[numbers[0] as usize];
        let excess = extent(&body.shape, &along) - numbers[4];
        assert!((0.1..30.0).contains(&excess), "{row}: {excess}");
        rows += 1;
    }
    assert_eq!(rows, 4 * 7 * 14);
}

#[test]
fn each_known_arm_has_seven_bodies_and_says_where_they_come_from() {
    let known = robots::CATALOGUE.iter().filter(|arm| link_source(&arm.model).is_some());
    assert_eq!(known.map(|arm| arm.name).collect::<Vec<_>>(), WITH_BODIES);
    for name in WITH_BODIES {
        let model = arm_of(name);
        let source = link_source(model).unwrap();
        assert_eq!((source.arm, links(model).len()), (name, 7));
        assert_eq!(source.is_estimate, ["UR3e", "IRB120", "IRB1200"].contains(&name), "{name}");
        assert_eq!(source.source.starts_with("estimate"), source.is_estimate);
        assert!(source.error_mm < GrowingOptions::default().margin_mm);
    }
    // Other lengths are another arm.
    let mut other = robots::UR3;
    let Geometry::Ur(table) = &mut other.geometry else { panic!("a UR") };
    table.d[3] += 0.1;
    assert_eq!((link_source(&other), links(&other)), (None, vec![]));
}

/// Pairs with one link between them rest side by side; they keep apart where arms work, and what turns about one axis only
/// never comes near.
#[test]
fn links_keep_apart_beyond_their_neighbours() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for name in WITH_BODIES {
        let model = arm_of(name);
        let arm = Arm::new(model).unwrap();
        let scene = Scene::new(SceneModel { links: links(model), margin: 2.0, ..SceneModel::of(arm) }).unwrap();
        let pairs: Vec<_> = scene.pairs().collect();
        assert!(!pairs.contains(&["base", "shoulder"]) && !pairs.contains(&["wrist 2", "flange"]));
        let free = (0..2000).filter(|_| {
            let joints: [f64; 6] = std::array::from_fn(|j| {
                let (low, high) = (arm.limits().lower[j].max(-3.1), arm.limits().upper[j].min(3.1));
                random.random_range(low..high)
            });
            scene.touching(&joints.into()).unwrap().is_none()
        });
        let share = free.count() as f64 / 2000.0;
        println!("{name}: {share}");
        assert!(share > 0.3, "{name} {share}");
    }
}

#[test]
fn an_allowance_makes_links_thicker_against_what_is_no_link() {
    let arm = Arm::new(&robots::UR3).unwrap();
    let ball = |z: f64| Body {
        name: "ball".into(),
        mount: Mount::Base,
        mount_body: Isometry3::translation(-120.0, -150.0, z),
        shape: Shape::Capsule { from: Point3::origin(), to: Point3::origin(), radius: 20.0 },
    };
    let scene = |z: f64, link_allowance: f64| {
        let model =
            SceneModel { links: vec![links(&robots::UR3).remove(2)], bodies: vec![ball(z)], ..SceneModel::of(arm) };
        Scene::new(SceneModel { link_allowance, ..model }).unwrap()
    };
    // The upper arm lies level beneath the ball.
    let (level, lifted) = ([0.0; 6].into(), [0.0, -0.3, 0.0, 0.0, 0.0, 0.0].into());
    let [thin, thick] = [0.0, 10.0].map(|allowance| scene(240.0, allowance));
    let [near, nearer] = [&thin, &thick].map(|scene| scene.clearance(&level, 100.0).unwrap().unwrap());
    assert_eq!(near.nearest.bodies, ["upper arm", "ball"]);
    assert!((near.nearest.distance - nearer.nearest.distance - 10.0).abs() < 1e-9);
    let gap = |points: Option<[Point3<f64>; 2]>| points.map(|[p, q]| (p - q).norm()).unwrap();
    assert!((gap(nearer.nearest.points) - nearer.nearest.distance).abs() < 1e-9);
    // At a height between the two the thick one touches, at a posture and on the way.
    let between = 240.0 - near.nearest.distance + 5.0;
    let [thin, thick] = [0.0, 10.0].map(|allowance| scene(between, allowance));
    assert_eq!((thin.touching(&level).unwrap(), thick.touching(&level).unwrap()), (None, Some(["upper arm", "ball"])));
    assert!(thin.is_free(&level, &[0.0, 0.2, 0.0, 0.0, 0.0, 0.0].into(), 0.5).unwrap());
    assert!(!thick.is_free(&level, &lifted, 0.5).unwrap());
    // Against each other links are as thick as before.
    let own = |allowance: f64| {
        let model = SceneModel { links: links(&robots::UR3), link_allowance: allowance, ..SceneModel::of(arm) };
        Scene::new(model).unwrap().nearest(&level).unwrap().unwrap().distance
    };
    assert!((own(0.0) - own(10.0)).abs() < 1e-12);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let model = SceneModel { link_allowance: bad, ..SceneModel::of(arm) };
        assert!(Scene::new(model).unwrap_err().to_string().starts_with("the allowance of the links is"));
    }
}

/// Bodies that a workcell file names or gives.
#[cfg(feature = "serde")]
mod of_workcells {
    use super::*;
    use curvlay_kinematics::workcell::{
        AnyWorkcell, ArmGeometry, BodiesModel, FrameModel, GrowingError, GrowingScene, LinkMesh, LinkMeshModel,
        PartCells, SixAxisWorkcell, Workcell, WorkcellError, WorkcellModel,
    };

    fn ur3() -> WorkcellModel {
        WorkcellModel::from_json(include_str!("../../../examples/cells/ur3.json").as_bytes()).unwrap()
    }

    fn six(model: WorkcellModel) -> SixAxisWorkcell {
        match AnyWorkcell::new(model).unwrap() {
            AnyWorkcell::Six(cell) => cell,
            _ => panic!("not six axes"),
        }
    }

    /// The lengths of a UR3 with one of them changed.
    fn calibrated(by: f64) -> WorkcellModel {
        let mut model = ur3();
        let d_mm = [151.9, 0.0, 0.0, 112.35 + by, 85.35, 81.9];
        model.arm.geometry = ArmGeometry::Ur {
            d_mm,
            upper_arm_mm: -243.65,
            forearm_mm: -213.25,
            offsets_deg: [0.0; 6],
            signs: [1.0; 6],
            j23_factor: 0.0,
        };
        model
    }

    #[test]
    fn a_calibrated_arm_takes_the_bodies_of_the_named_one() {
        let mut model = calibrated(0.4);
        assert_eq!(six(model.clone()).equipment().link_bodies(), None);
        model.arm.bodies = Some(BodiesModel::Named("UR3".into()));
        let cell = six(model.clone());
        let found = cell.equipment().link_bodies().unwrap();
        assert!(found.model.starts_with("UR3: ") && (found.error_mm - 1.4).abs() < 1e-9);
        assert_eq!(cell.equipment().scene(100.0).links, links(&robots::UR3));
        model = calibrated(5.1);
        model.arm.bodies = Some(BodiesModel::Named("UR3".into()));
        let error = AnyWorkcell::new(model.clone()).unwrap_err().to_string();
        assert!(error.starts_with("arm.bodies.named is 5.0999"), "{error}");
        model.arm.bodies = Some(BodiesModel::Named("IRB120".into()));
        assert!(AnyWorkcell::new(model).is_err());
    }

    /// Tubes from lengths are off by a share of one of them; an arm whose frame is above its foot stands on a tube from there.
    #[test]
    fn estimated_bodies_say_how_far_off_they_are() {
        let mut model = calibrated(0.4);
        model.arm.bodies = Some(BodiesModel::Estimated);
        let cell = six(model.clone());
        let found = cell.equipment().link_bodies().unwrap();
        assert!(found.is_estimate && (found.error_mm - 0.46 * 85.35).abs() < 1e-9);
        model.arm.geometry = ArmGeometry::Named("LRMate200iD".into());
        let (cell, known) = (six(model), robots::find("LRMate200iD").unwrap());
        let Geometry::Ortho(lengths) = known.model.geometry else { panic!("six axes at right angles") };
        assert!((cell.equipment().link_bodies().unwrap().error_mm - 0.4 * lengths.c2.abs()).abs() < 1e-9);
        let (below, scene) = (known.mount_below_base_mm, cell.equipment().scene(100.0));
        let top = 0.45 * (lengths.c1 + below) - below;
        assert_eq!(scene.links[0].shape, Shape::cylinder(0.3 * lengths.c2, -below, top));
    }

    #[test]
    fn an_arm_without_bodies_is_refused_for_a_print() {
        let (cell, layers) = (six(calibrated(0.4)), [vec![0]]);
        let part = PartCells {
            dims: [1; 3],
            rows: &[1],
            cell_mm: 2.0,
            origin: Point3::origin(),
            frame_part: Isometry3::identity(),
            layers: &layers,
        };
        let options = GrowingOptions::default();
        let refused = GrowingScene::new(&cell, &part, 60.0, &options).map(drop).unwrap_err();
        assert_eq!(refused, GrowingError::NoLinks);
        assert!(GrowingScene::new(&cell, &part, 60.0, &GrowingOptions { without_links: true, ..options }).is_ok());
    }

    /// A block about the origin of a link, as in an STL file in metres.
    fn block(half: f64) -> LinkMesh {
        let corner = |k: usize| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half }));
        let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    #[test]
    fn links_may_be_meshes() {
        let mesh = |link: usize| LinkMeshModel {
            link,
            file: format!("link_{link}.stl"),
            unit_mm: 1000.0,
            frame: FrameModel { position_mm: [1.0, 2.0, 3.0], ..FrameModel::default() },
        };
        let with = |meshes: Vec<LinkMeshModel>| {
            let mut model = ur3();
            model.arm.bodies = Some(BodiesModel::Meshes(meshes));
            model
        };
        let mut read = |file: &str| if file == "link_9.stl" { Err("no such file".to_owned()) } else { Ok(block(0.02)) };
        let cell = AnyWorkcell::with_link_meshes(with((0..7).map(mesh).collect()), &mut read).unwrap();
        let links = cell.equipment().scene(100.0).links;
        for (link, body) in links.iter().enumerate() {
            assert_eq!(body.mount, if link == 0 { Mount::Base } else { Mount::Link(link) });
            assert!((extent(&body.shape, &Vector3::x()) - 21.0).abs() < 1e-9);
            assert!((extent(&body.shape, &-Vector3::z()) - 17.0).abs() < 1e-9);
        }
        let mut refused = |meshes| AnyWorkcell::with_link_meshes(with(meshes), &mut read).map(drop).unwrap_err();
        assert_eq!(refused((0..6).map(mesh).collect()), WorkcellError::NoLinkMesh { link: 6, name: "flange" });
        let error = refused((0..8).map(mesh).collect()).to_string();
        assert!(error.starts_with("arm.bodies.meshes[7].link: "), "{error}");
        let missing = LinkMeshModel { file: "link_9.stl".into(), ..mesh(0) };
        assert_eq!(refused(vec![missing]).to_string(), "arm.bodies.meshes[0].file: link_9.stl: no such file");
        let no_unit = LinkMeshModel { unit_mm: 0.0, ..mesh(0) };
        assert!(refused(vec![no_unit]).to_string().starts_with("arm.bodies.meshes[0].unit_mm is 0"));
        // Without a reader there are no meshes.
        assert!(matches!(AnyWorkcell::new(with(vec![mesh(0)])), Err(WorkcellError::LinkMesh { .. })));
        let mut thin = ur3();
        thin.arm.allowance_mm = -1.0;
        assert_eq!(AnyWorkcell::new(thin).unwrap_err().to_string(), "arm.allowance_mm is -1: it must be from 0 to 1e6");
    }
}

#[test]
fn robots_of_the_tests_are_those_with_bodies() {
    for (name, model) in common::ROBOTS {
        assert!(link_source(model).is_some(), "{name}");
    }
}
