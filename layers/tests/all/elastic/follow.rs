//! A field that follows the load, and layers that it governs.

use super::Solid;
use crate::common::go;
use curvlay_layers::curved::surface::{LayerField, plain_field};
use curvlay_layers::curved::{GrowthOptions, LayerOrder, Platform, Rules, audit, grow, surface::uniform_field};
use curvlay_layers::elastic::{FollowError, FollowOptions, Load, Material, Region, Support, load_angle, load_field};

/// Built level by level.
fn level(solid: &Solid) -> LayerField {
    let cells = solid.cells();
    let mut order = LayerOrder::new();
    for z in 0..solid.dims[2] {
        order.push(cells.iter().filter(|&cell| cells.position(cell)[2] == z));
    }
    plain_field(&cells, &order).unwrap()
}

/// Where nothing is stressed the field is the base but for a constant.
#[test]
fn far_from_stress_the_field_is_the_base() {
    let solid = Solid::new([24, 3, 6], |_| true);
    let (cells, base) = (solid.cells(), level(&solid));
    // One end is stressed, by 30 degrees.
    let stress = |x: u32| if x < 3 { [3.0, 0.0, 1.0, 0.0, 0.0, 3f64.sqrt()] } else { [0.0; 6] };
    let stresses: Vec<[f64; 6]> = cells.iter().map(|cell| stress(cells.position(cell)[0])).collect();
    let field = load_field(&cells, &stresses, &base, &FollowOptions::default(), &go).unwrap();
    let value = |at: [u32; 3]| field.values[cells.id(at) as usize];
    for x in 16..24 {
        assert!((value([x, 1, 4]) - value([x, 1, 1]) - 3.0).abs() < 0.02, "{x}");
        assert!((value([x, 1, 2]) - value([23, 1, 2])).abs() < 0.05, "{x}: {}", value([x, 1, 2]) - value([23, 1, 2]));
    }
    // At the stressed end the level sets rise by 30 degrees: the gradient is (-1/2, 0, sqrt 3 / 2).
    assert!((value([2, 1, 3]) - value([0, 1, 3]) + 1.0).abs() < 0.35);
    let sheets = field.sheets();
    assert!(cells.iter().all(|cell| sheets.value(cell) >= 1) && sheets.highest() >= 6);
}

/// A wall that is pushed along its top, on a platform that is not much larger: bending pulls its ends upright, where the default layers are level.
/// Those that follow the load come nearer to the stress by half, and can be built.
#[test]
fn layers_of_a_wall_follow_the_load() {
    let solid = Solid::new([40, 6, 24], |_| true);
    let cells = solid.cells();
    let push = Load::Force { region: Region::plane(2, 24.0), newtons: [10.0, 0.0, 0.0] };
    let plate = Support::fixed(Region::plane(2, 0.0));
    let stresses = solid.solve(1.0, Material::default(), &[plate], &[push]).unwrap().stresses_mpa;
    let (platform, rules) = (Platform::under(&cells, 0.0).unwrap(), Rules::default());
    let grown = |governor: Option<&_>| {
        let growth = grow(&cells, &platform, &rules, &GrowthOptions::default(), governor, &go).unwrap();
        assert!(growth.missed.is_empty());
        assert!(audit(&cells, &platform, &rules, &growth.order, &[], &go).unwrap().is_ok());
        uniform_field(&cells, &platform, &rules, &growth.order, &[], &go).unwrap().field
    };
    let default = grown(None);
    let field = load_field(&cells, &stresses, &default, &FollowOptions::default(), &go).unwrap();
    let followed = grown(Some(&field.sheets()));
    let degrees = |field: &LayerField| load_angle(&cells, &stresses, field, 0.1).unwrap().mean.to_degrees();
    let (before, after) = (degrees(&default), degrees(&followed));
    assert!(before > 60.0 && after < 0.6 * before, "{before} -> {after}");
}

#[test]
fn what_is_refused() {
    let solid = Solid::new([3, 3, 3], |_| true);
    let (cells, base) = (solid.cells(), level(&solid));
    let sound = vec![[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 27];
    let find =
        |stresses: &[[f64; 6]], options: FollowOptions| load_field(&cells, stresses, &base, &options, &go).unwrap_err();
    assert_eq!(find(&sound[1..], FollowOptions::default()), FollowError::Stresses { stresses: 26, cells: 27 });
    let mut broken = sound.clone();
    broken[4][5] = f64::NAN;
    assert_eq!(find(&broken, FollowOptions::default()), FollowError::NotFinite { cell: 4 });
    assert_eq!(find(&[[0.0; 6]; 27], FollowOptions::default()), FollowError::NoStress);
    let none = FollowOptions { stressed_share: 0.0, ..FollowOptions::default() };
    assert_eq!(find(&sound, none), FollowError::Option { name: "stressed_share", value: 0.0 });
    let none = FollowOptions { along: -1.0, ..FollowOptions::default() };
    assert_eq!(find(&sound, none), FollowError::Option { name: "along", value: -1.0 });
    let other = level(&Solid::new([2, 3, 3], |_| true));
    let error = load_field(&cells, &sound, &other, &FollowOptions::default(), &go).unwrap_err();
    assert_eq!(error, FollowError::Field { field: 18, cells: 27 });
    assert!(error.to_string().contains("18"));
    let stop = |_| std::ops::ControlFlow::Break(());
    assert_eq!(load_field(&cells, &sound, &base, &FollowOptions::default(), &stop), Err(FollowError::Cancelled));
}
