//! A field that follows the load, and layers that it governs.

use super::Solid;
use crate::common::go;
use curvlay_layers::cells::LayerOrder;
use curvlay_layers::curved::surface::{LayerField, plain_field, uniform_field};
use curvlay_layers::curved::{
    FollowError, FollowOptions, GrowthOptions, Platform, Rules, audit, grow, load_angle, load_field,
};
use curvlay_layers::elastic::{Load, Material, Region, Support};

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
#[ignore = "prints the table of docs/benchmarks.md: mean angles of four parts"]
fn angles_of_four_parts() {
    let ring = |[x, _, z]: [u32; 3]| (22.0..30.0).contains(&(f64::from(x) + 0.5 - 30.0).hypot(f64::from(z) + 0.5));
    let top = |z: f64, newtons: [f64; 3]| Load::Force { region: Region::plane(2, z), newtons };
    let end = Load::Force { region: Region::plane(0, 50.0), newtons: [0.0, 0.0, -10.0] };
    let crown = Region { low_mm: [25.0, 0.0, 28.0], high_mm: [35.0, 6.0, 31.0] };
    let parts = [
        ("arm", Solid::new([50, 5, 16], |[x, _, z]| x < 12 || z >= 11), end),
        ("leaning bar", Solid::new([50, 6, 40], |[x, _, z]| (z..z + 9).contains(&x)), top(40.0, [0.0, 0.0, -10.0])),
        ("arch", Solid::new([60, 6, 31], ring), Load::Force { region: crown, newtons: [0.0, 0.0, -10.0] }),
        ("wall", Solid::new([40, 6, 24], |_| true), top(24.0, [10.0, 0.0, 0.0])),
    ];
    for (name, solid, load) in parts {
        let cells = solid.cells();
        let plate = Support::fixed(Region::plane(2, 0.0));
        let stresses = solid.solve(1.0, Material::default(), &[plate], &[load]).unwrap().stresses_mpa;
        let degrees = |field: &LayerField| load_angle(&cells, &stresses, field, 0.1).unwrap().mean.to_degrees();
        for radius in [0.0, 60.0] {
            let (platform, rules) = (Platform::under(&cells, radius).unwrap(), Rules::default());
            let grown = |governor: Option<&_>| {
                let growth = grow(&cells, &platform, &rules, &GrowthOptions::default(), governor, &go).unwrap();
                let missed = growth.missed_cells();
                let field = uniform_field(&cells, &platform, &rules, &growth.order, &missed, &go).unwrap().field;
                (degrees(&plain_field(&cells, &growth.order).unwrap()), degrees(&field), missed.len(), field)
            };
            let (plain, uniform, missed, default) = grown(None);
            let field = load_field(&cells, &stresses, &default, &FollowOptions::default(), &go).unwrap();
            let least = field.values.iter().copied().fold(f64::INFINITY, f64::min);
            let own = field.values.iter().map(|value| value - least).collect();
            let own = degrees(&LayerField::new(&cells, own, 1.0).unwrap());
            let (of_plain, of_uniform, of_missed, _) = grown(Some(&field.sheets()));
            println!(
                "{name}, platform {radius}: order {plain:.1} -> {of_plain:.1}, uniform {uniform:.1} -> {of_uniform:.1}, field {own:.1}, \
                 missed {missed} -> {of_missed}"
            );
        }
    }
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
