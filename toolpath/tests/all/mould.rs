//! Layers on a mould: its twin is a first layer without curves; and what is refused.

use crate::common::layers::{Layer, path, with_own_stack, with_stack};
use crate::common::nozzle::tip_1_mm;
use curvlay_toolpath::gouging::{GougingOptions, Moment, Obstacle};
use curvlay_toolpath::layer::{BuiltLayer, LayerStack, Mould, MouldError, StackError};
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_toolpath::orientation::{Pose, ToolPath};
use curvlay_toolpath::plan::{PrintOptions, PrintPlan};
use curvlay_toolpath::support::{SupportError, SupportOptions, check_support, check_support_on_mould};
use curvlay_toolpath::travel::TravelOptions;
use proptest::prelude::*;
use std::ops::ControlFlow;

const H: f64 = 0.8;

fn go_on(_: curvlay_toolpath::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn mould(layer: &Layer) -> Mould<'_> {
    Mould { vertices: &layer.vertices, triangles: &layer.triangles, thickness: layer.spacing }
}

/// A layer half a height over the plate with some lines, 40 by 40 mm.
fn floor() -> Layer {
    let floor = Layer::sheet([0.0, 0.0, H / 2.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 20, H);
    let line = |floor: Layer, y: f64| floor.with(&[[4.0, y, H / 2.0], [36.0, y, H / 2.0]], H);
    [4.0, 12.0, 20.0, 28.0].into_iter().fold(floor, line)
}

fn planned(stack: &LayerStack) -> PrintPlan {
    stack.plan(&tip_1_mm(), &PrintOptions::default(), &go_on).unwrap()
}

fn obstacle(of_layers: Obstacle) -> Obstacle {
    match of_layers {
        Obstacle::Layer(0) => Obstacle::Mould,
        Obstacle::Layer(layer) => Obstacle::Layer(layer - 1),
        other => other,
    }
}

/// What came of the twin, as if its first layer were the mould.
fn on_mould(mut plan: PrintPlan) -> PrintPlan {
    let resolved = &mut plan.resolved;
    resolved.paths.iter_mut().for_each(|path| path.layer -= 1);
    resolved.left.iter_mut().for_each(|left| left.obstacle = obstacle(left.obstacle));
    for left in &mut resolved.left_out {
        (left.layer, left.obstacle) = (left.layer - 1, obstacle(left.obstacle));
    }
    plan.travels.blocked.iter_mut().for_each(|blocked| blocked.obstacle = obstacle(blocked.obstacle));
    plan
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Bit for bit: ways, directions, findings.
    #[test]
    fn it_is_a_layer_before_the_first(
        place in [6.0..34.0_f64, 6.0..34.0_f64], turn in -1.5..1.5_f64, lean in -0.9..0.9_f64, high in 2.0..20.0_f64,
    ) {
        let wall = Layer::sheet([0.0, -15.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, high], 8, H);
        let to = Isometry3::new(Vector3::new(place[0], place[1], 0.0), Vector3::z() * turn);
        let wall = wall.moved(&Isometry3::rotation(Vector3::y() * lean)).moved(&to);
        let twin = with_stack(&[wall.clone(), floor()], planned);
        let plan = with_own_stack(&[floor()], |stack| planned(&stack.on_mould(&mould(&wall)).unwrap()));
        let twin = on_mould(twin);
        prop_assert_eq!(plan, twin);
    }
}

/// A path outside the mould, then one in it: what the nozzle is in.
#[test]
fn contacts_name_the_mould() {
    let wall = Layer::sheet([0.0, -20.0, -5.0], [0.0, 40.0, 0.0], [0.0, 0.0, 40.0], 10, H);
    let ground = Layer::sheet([-30.0, -20.0, 0.4], [60.0, 0.0, 0.0], [0.0, 40.0, 0.0], 12, H);
    let line = |x: f64| path(0, &[-5.0, 5.0].map(|y| (Point3::new(x, y, H), Vector3::z())));
    let paths = [line(20.0), line(1.0)];
    let found = with_own_stack(&[ground], |stack| {
        let stack = stack.on_mould(&mould(&wall)).unwrap();
        let contacts = stack.contacts(&paths, &tip_1_mm(), &GougingOptions::default(), &go_on).unwrap();
        let at = |x: f64| Pose { tip: Point3::new(x, 0.0, H), direction: Vector3::z_axis() };
        [20.0, 1.0].map(|x| contacts.deepest(Moment::At { path: 0, waypoint: 0 }, &at(x)).unwrap())
    });
    assert_eq!(found.map(|contact| contact.map(|contact| contact.obstacle)), [None, Some(Obstacle::Mould)]);
    assert_eq!(Obstacle::Mould.to_string(), "mould");
}

/// The way over a mould that stands between two lines rises over it.
#[test]
fn travels_rise_over_the_mould() {
    let wall = Layer::sheet([0.0, -20.0, 0.0], [0.0, 40.0, 0.0], [0.0, 0.0, 25.0], 10, H);
    let ground = Layer::sheet([-60.0, -20.0, 0.4], [120.0, 0.0, 0.0], [0.0, 40.0, 0.0], 12, H);
    let line = |x: f64| path(0, &[-5.0, 5.0].map(|y| (Point3::new(x, y, H), Vector3::z())));
    let paths: [ToolPath; 2] = [line(-50.0), line(50.0)];
    let travels = with_own_stack(&[ground], |stack| {
        let stack = stack.on_mould(&mould(&wall)).unwrap();
        stack.travels(&paths, &tip_1_mm(), &TravelOptions::default(), &go_on).unwrap()
    });
    assert!(travels.blocked.is_empty());
    let over = travels.ways[1].iter().filter(|pose| pose.tip.x.abs() < 30.0).map(|pose| pose.tip.z);
    assert!(travels.max_lift > 2.0 || over.fold(0.0, f64::max) > 25.0);
}

/// What stands on a mould that is a plate is held as on the plate itself, for beads whose middle is a quarter of a layer over it or more.
#[test]
fn a_level_mould_carries_as_the_plate_does() {
    let level = Layer::sheet([-50.0, -50.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], 3, H);
    let waves = |k: u32| {
        let at = |j: u32| Point3::new(f64::from(j), f64::from(k), H + 0.3 * f64::from((j * (k + 3)) % 7));
        path(k, &(0..20).map(|j| (at(j), Vector3::z())).collect::<Vec<_>>())
    };
    let paths: Vec<ToolPath> = (0..5).map(waves).collect();
    let plate = SupportOptions::default();
    let afloat = SupportOptions { plate: false, ..plate };
    let on_plate = check_support(&paths, H, &plate, &go_on).unwrap();
    assert_eq!(check_support_on_mould(&paths, &mould(&level), H, &afloat, &go_on).unwrap(), on_plate);
    assert!(on_plate.unsupported_mm() > 5.0 && on_plate.unsupported_mm() < 0.9 * on_plate.bead_mm);
    // A mould above the beads, or beside them, carries nothing.
    let aside = Layer::sheet([-50.0, -0.5, 0.0], [100.0, 0.0, 0.0], [0.0, 0.0, 30.0], 3, H);
    let above = Layer::sheet([-50.0, -50.0, 3.5], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], 3, H);
    let bare = check_support(&paths, H, &afloat, &go_on).unwrap();
    for other in [aside, above] {
        assert_eq!(check_support_on_mould(&paths, &mould(&other), H, &afloat, &go_on).unwrap(), bare);
    }
}

#[test]
fn bad_moulds_are_refused() {
    let vertices = [[0.0; 3], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]].map(Point3::from);
    let line = vertices.map(|p| Point3::new(p.x, 0.0, 0.0));
    let far = [vertices[0], vertices[1], Point3::new(0.0, f64::NAN, 0.0)];
    let (one, none): (&[[u32; 3]], &[[u32; 3]]) = (&[[0, 1, 2]], &[]);
    let faults = [
        (&vertices, none, H, MouldError::NoArea),
        (&line, one, H, MouldError::NoArea),
        (&far, one, H, MouldError::BadVertex { vertex: 2 }),
        (&vertices, &[[0, 1, 2], [0, 1, 3]][..], H, MouldError::NoSuchVertex { triangle: 1, vertex: 3, vertices: 3 }),
        (&vertices, one, 0.0, MouldError::BadThickness { thickness: 0.0 }),
    ];
    for (vertices, triangles, thickness, error) in faults {
        let mould = Mould { vertices, triangles, thickness };
        let layers: [BuiltLayer; 0] = [];
        assert_eq!(LayerStack::new(&layers).unwrap().on_mould(&mould).err(), Some(StackError::Mould(error)));
        let checked = check_support_on_mould(&[], &mould, H, &SupportOptions::default(), &go_on);
        assert_eq!(checked, Err(SupportError::Mould(error)));
    }
}
