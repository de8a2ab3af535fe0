//! Stresses: parts, materials, tape.

use super::numbers::{DIMS, bad, each_spoilt, ids, number, point, small, vector};
use crate::common::go;
use curvlay_layers::elastic::*;
use curvlay_layers::nalgebra::{Matrix6, Point3, Unit, UnitVector3, Vector3};
use proptest::prelude::*;

fn region() -> impl Strategy<Value = Region> {
    let corners = [[number(), number(), number()], [number(), number(), number()]];
    prop_oneof![
        2 => (0..3usize, number()).prop_map(|(axis, at)| Region::plane(axis, at)),
        1 => corners.prop_map(|[low_mm, high_mm]| Region { low_mm, high_mm }),
    ]
}

fn loads() -> impl Strategy<Value = Vec<Load>> {
    let one = (region(), [number(), number(), number()], 0..3usize).prop_map(|(region, by, kind)| match kind {
        0 => Load::Force { region, newtons: by },
        1 => Load::Traction { region, mpa: by },
        _ => Load::Body { newtons_mm3: by },
    });
    prop::collection::vec(one, 0..3)
}

const MATERIAL: [fn(&mut Material, f64); 2] =
    [|material, value| material.young_mpa = value, |material, value| material.poisson = value];
const ORTHOTROPIC: [fn(&mut Orthotropic, f64); 3] = [
    |material, value| material.young_mpa[0] = value,
    |material, value| material.poisson[1] = value,
    |material, value| material.shear_mpa[2] = value,
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn stresses_take_anything(
        part in small(), region in region(), moved in prop::option::of(number()), loads in loads(), value in bad(), size in number(), iterations in prop::sample::select(vec![0, 1, 200, u32::MAX]), node in prop::sample::select(vec![0, 119, 120, u32::MAX]),
        directions in [vector(), vector()], plied in ids(), share in number(),
    ) {
        let cells = part.cells();
        let held = [Support::fixed(Region::plane(2, 0.0)), Support { region, displacement_mm: [moved, Some(0.0), None] }];
        let push = [Load::Force { region: Region::plane(2, 3.0), newtons: [1.0, 0.0, -2.0] }];
        let sound = ElasticPart { cells: &cells, cell_mm: 1.0, material: Material::default(), supports: &held[..1], loads: &push };
        let materials = each_spoilt(&Material::default(), &MATERIAL, value).into_iter().map(|material| ElasticPart { material, ..sound });
        let options = ElasticOptions { max_iterations: 60, ..ElasticOptions::default() };
        let all = materials.chain([ElasticPart { cell_mm: size, ..sound }, ElasticPart { supports: &held, ..sound }, ElasticPart { loads: &loads, ..sound }, ElasticPart { supports: &[], ..sound }]);
        let [direction, normal] = directions;
        let given: Vec<Ply> = plied.iter().map(|&cell| Ply { cell, direction, normal, share }).collect();
        let along = [Ply { cell: 0, direction: Vector3::x(), normal: Vector3::z(), share: 0.5 }];
        let tape = Orthotropic::tape(&Material::default(), 60_000.0, 0.5);
        for part in all {
            let found = [
                solve_elastic(&part, &options, &go), solve_composite(&part, &tape, &given, &options, &go), solve_composite(&part, &tape, &along, &options, &go),
            ];
            for found in found.into_iter().flatten() {
                let _ = (found.displacement(node), found.stress(node), found.mean_displacement(DIMS, size, &region), found.mean_displacement([u32::MAX; 3], 1.0, &region), found.mean_displacement([1, 0, 0], 1.0, &region));
            }
        }
        for options in [ElasticOptions { tolerance: value, ..options }, ElasticOptions { max_iterations: iterations, ..options }] {
            let _ = solve_elastic(&sound, &options, &go);
        }
        for tape in each_spoilt(&tape, &ORTHOTROPIC, value) {
            let _ = (tape.law(), tape.modulus_at(value), solve_composite(&sound, &tape, &along, &options, &go));
        }
        for size in [1.0, size] {
            let _ = supported_cells(&cells, size, &held);
        }
    }

    #[test]
    fn materials_take_anything(
        part in small(), stress in prop::array::uniform6(number()), points in prop::collection::vec(point(), 0..4), normals in prop::collection::vec(vector(), 0..4), numbers in [number(), number(), number()], bonds in prop::collection::vec((number(), number()), 0..5), value in bad(), origin in point(),
    ) {
        let [a, b, share] = numbers;
        let normal = normals.first().copied().unwrap_or_else(Vector3::zeros);
        let _ = (stress_matrix(&stress), principal_stresses(&stress), von_mises(&stress), traction(&stress, &normal));
        let _ = (Bond { peel_mpa: a, shear_mpa: b }.index(&stress, &normal), load_factor(&bonds, share), load_factor(&bonds, value));
        for material in each_spoilt(&Material::default(), &MATERIAL, value) {
            let _ = (Orthotropic::isotropic(&material).law(), Orthotropic::tape(&material, a, share).law(), Orthotropic::tape(&material, value, b).modulus_at(a));
        }
        laminate(&Matrix6::repeat(a), &Matrix6::identity(), share);
        laminate(&Matrix6::zeros(), &Matrix6::repeat(value), value);
        let cells = part.cells();
        let units: Vec<UnitVector3<f64>> = normals.iter().map(|normal| Unit::new_unchecked(*normal)).collect();
        let up = vec![Vector3::z_axis(); points.len()];
        let line = [Point3::new(0.0, 1.5, 1.5), Point3::new(5.0, 1.5, 1.5)];
        let far = [Point3::new(-1e8, 1.5, 1.5), Point3::new(1e8, 1.5, 1.5)];
        let sound = Strip { points: &line, normals: &[Vector3::z_axis(); 2], width_mm: 1.0, thickness_mm: 0.2 };
        let strips = [
            sound, Strip { points: &points, normals: &units, ..sound }, Strip { points: &points, normals: &up, ..sound }, Strip { points: &far, ..sound }, Strip { width_mm: value, ..sound },
            Strip { thickness_mm: value, ..sound }, Strip { width_mm: a, thickness_mm: b, ..sound },
        ];
        for strip in strips {
            for (size, origin) in [(1.0, Point3::origin()), (a, Point3::origin()), (1.0, origin)] {
                let _ = plies(&cells, size, &origin, &[strip]);
            }
        }
    }
}
