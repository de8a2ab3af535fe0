//! What is refused, and what the messages say.

use super::Solid;
use crate::common::go;
use curvlay_layers::elastic::{
    BoundaryCondition, ElasticError, ElasticOptions, ElasticPart, Load, Material, Region, Support, solve_elastic,
    supported_cells,
};
use std::ops::ControlFlow;

fn bar() -> Solid {
    Solid::new([2, 2, 6], |_| true)
}

fn refused(solid: &Solid, supports: &[Support], loads: &[Load]) -> ElasticError {
    solid.solve(1.0, Material::default(), supports, loads).unwrap_err()
}

const PULL: Load = Load::Body { newtons_mm3: [0.0, 0.0, 1.0] };

fn plate() -> Support {
    Support::fixed(Region::plane(2, 0.0))
}

#[test]
fn loads_without_supports() {
    assert_eq!(refused(&bar(), &[], &[PULL]), ElasticError::NoSupport);
    let free = Support { region: Region::EVERYWHERE, displacement_mm: [None; 3] };
    assert_eq!(refused(&bar(), &[free], &[PULL]), ElasticError::NoSupport);
}

#[test]
fn supports_that_let_the_part_slide_or_turn() {
    let upright = Support { region: Region::plane(2, 0.0), displacement_mm: [None, None, Some(0.0)] };
    assert_eq!(refused(&bar(), &[upright], &[PULL]), ElasticError::Loose { free: 3, cells: 24 });
    let edge = Region { low_mm: [0.0; 3], high_mm: [0.0, 2.0, 0.0] };
    assert_eq!(refused(&bar(), &[Support::fixed(edge)], &[PULL]), ElasticError::Loose { free: 1, cells: 24 });
}

#[test]
fn cells_that_hang_on_nothing() {
    // Joined by an edge only, and not at all.
    let solid = Solid::new([6, 2, 4], |[x, _, z]| x < 2 && z < 2 || (2..4).contains(&x) && z >= 2 || x == 5);
    let left = Support::fixed(Region { low_mm: [0.0; 3], high_mm: [2.0, 2.0, 0.0] });
    let error = refused(&solid, &[left], &[PULL]);
    assert_eq!(error, ElasticError::NotConnected { cells: 16, of: 24 });
    assert!(error.to_string().contains("supported_cells"));
    let rows = supported_cells(&solid.cells(), 1.0, &[left]).unwrap();
    assert_eq!(rows.iter().map(|row| row.count_ones()).sum::<u32>(), 8);
    assert!(Solid { rows, ..solid }.solve(1.0, Material::default(), &[left], &[PULL]).is_ok());
}

#[test]
fn regions_that_hold_nothing() {
    let above = Region::plane(2, 7.0);
    let (low, high) = ([0.0; 3], [2.0, 2.0, 6.0]);
    let empty = |what: BoundaryCondition, number: usize| ElasticError::EmptyRegion { what, number, low, high };
    assert_eq!(refused(&bar(), &[plate(), Support::fixed(above)], &[PULL]), empty(BoundaryCondition::Support, 1));
    let push = Load::Force { region: above, newtons: [1.0; 3] };
    assert_eq!(refused(&bar(), &[plate()], &[push]), empty(BoundaryCondition::Load, 0));
    // Between cells is no outer face.
    let inside = Load::Traction { region: Region::plane(2, 3.0), mpa: [1.0; 3] };
    let between = Region { low_mm: [0.5, 0.5, 3.0], high_mm: [1.5, 1.5, 3.0] };
    assert_eq!(refused(&bar(), &[plate()], &[inside]), empty(BoundaryCondition::Load, 0));
    assert_eq!(
        refused(&bar(), &[plate()], &[PULL, Load::Force { region: between, newtons: [1.0; 3] }]),
        empty(BoundaryCondition::Load, 1)
    );
}

#[test]
fn numbers_that_are_none() {
    let nan = Load::Force { region: Region::plane(2, 6.0), newtons: [0.0, f64::NAN, 0.0] };
    assert_eq!(
        refused(&bar(), &[plate()], &[PULL, nan]),
        ElasticError::NotFinite { what: BoundaryCondition::Load, number: 1 }
    );
    let region = Region { low_mm: [f64::NAN; 3], high_mm: [1.0; 3] };
    let error = refused(&bar(), &[Support::fixed(region)], &[PULL]);
    assert_eq!(error, ElasticError::NotFinite { what: BoundaryCondition::Support, number: 0 });
    let far = Support { displacement_mm: [Some(f64::INFINITY); 3], ..plate() };
    assert_eq!(refused(&bar(), &[far], &[]), ElasticError::NotFinite { what: BoundaryCondition::Support, number: 0 });
    for poisson in [0.5, -1.0, f64::NAN] {
        let material = Material { poisson, ..Material::default() };
        assert!(matches!(bar().solve(1.0, material, &[plate()], &[PULL]), Err(ElasticError::Material { .. })));
    }
    for cell_mm in [0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            bar().solve(cell_mm, Material::default(), &[plate()], &[PULL]),
            Err(ElasticError::Cell { .. })
        ));
    }
}

#[test]
fn supports_that_contradict_each_other() {
    let moved =
        Support { region: Region { low_mm: [0.0; 3], high_mm: [0.0; 3] }, displacement_mm: [None, Some(0.1), None] };
    let error = refused(&bar(), &[plate(), moved], &[PULL]);
    let known = ElasticError::Contradiction { support: 1, node: [0, 0, 0], axis: 1, first: 0.0, second: 0.1 };
    assert_eq!(error, known);
}

#[test]
fn no_cell_no_convergence_and_no_patience() {
    assert_eq!(refused(&Solid::new([3, 3, 3], |_| false), &[plate()], &[PULL]), ElasticError::NoCell);
    let solid = Solid::new([9, 9, 9], |_| true);
    let cells = solid.cells();
    let supports = [plate()];
    let part =
        ElasticPart { cells: &cells, cell_mm: 1.0, material: Material::default(), supports: &supports, loads: &[PULL] };
    let options = ElasticOptions { max_iterations: 2, ..ElasticOptions::default() };
    assert!(matches!(solve_elastic(&part, &options, &go), Err(ElasticError::NoConvergence { iterations: 2, .. })));
    let options = ElasticOptions { tolerance: 0.0, ..ElasticOptions::default() };
    assert!(matches!(solve_elastic(&part, &options, &go), Err(ElasticError::Options { .. })));
    for patience in [0, 50] {
        let stop = |p: curvlay_layers::Progress| {
            assert_eq!((p.stage, p.total), ("elastic", 100));
            if p.done >= patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        assert_eq!(solve_elastic(&part, &ElasticOptions::default(), &stop), Err(ElasticError::Cancelled));
    }
}
