//! What each piece of bead is for, from curves to moves.

use crate::common::nozzle::tip_1_mm;
use crate::common::{go_on, grid, to_boundary};
use curvlay_toolpath::deposit::{Move, MoveKind};
use curvlay_toolpath::fill::fill_layers;

use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{BeadKind, InfillOptions, PathOptions, Pattern};
use curvlay_toolpath::plan::PrintOptions;

const SIDE: f64 = 12.0;
const BEAD: f64 = 0.8;

/// The moves of a plate that is filled solid, 0.8 mm thick, and those of its beads with the distance of their ends from the boundary.
fn moves(pattern: Pattern) -> (Vec<Move>, Vec<(BeadKind, f64)>) {
    let plate = grid(SIDE as usize, 1, 0.6, |_, _| false, |p| Point3::new(p.x, p.y, BEAD / 2.0));
    let thickness = vec![BEAD; plate.triangles().len()];
    let surface = LayerSurface {
        vertices: plate.vertices(),
        triangles: plate.triangles(),
        thickness: &thickness,
        is_half: false,
    };
    let filled = fill_layers(&[surface], &PathOptions { pattern, ..PathOptions::default() }, &go_on).unwrap();
    let distance = to_boundary(&plate);
    let points = filled.layers[0].iter().flat_map(|layer| &layer.paths.paths).flat_map(|path| &path.points);
    let kinds = points.map(|p| (p.kind, distance.at(p.at.triangle, p.at.barycentric).distance)).collect();
    (filled.plan(&[surface], &tip_1_mm(), &PrintOptions::default(), &go_on).unwrap().deposition.moves, kinds)
}

/// Length of the moves that are a kind of bead.
fn length(moves: &[Move], kind: BeadKind) -> f64 {
    let steps = moves.windows(2).filter(|pair| pair[1].bead == Some(kind));
    steps.map(|pair| (pair[1].tip - pair[0].tip).norm()).sum()
}

#[test]
fn the_outermost_contour_of_a_solid_layer_is_a_wall_and_the_rest_is_solid() {
    for pattern in [Pattern::Spirals, Pattern::Rings] {
        let (moves, kinds) = moves(pattern);
        for (kind, distance) in kinds {
            assert_eq!(kind, if distance < 0.875 * BEAD { BeadKind::Wall } else { BeadKind::Solid }, "{distance}");
        }
        // The ring half a bead from the edge, but for where the spiral goes on inward.
        let wall = length(&moves, BeadKind::Wall);
        assert!((wall - 4.0 * (SIDE - BEAD)).abs() < 4.0 * BEAD, "{wall}");
        let area = SIDE * SIDE;
        let solid = length(&moves, BeadKind::Solid);
        assert!(((wall + solid) * BEAD / area - 1.0).abs() < 0.04, "{solid}");
        let others = [Some(BeadKind::Infill), Some(BeadKind::Skin)];
        assert!(!moves.iter().any(|step| others.contains(&step.bead)));
    }
}

#[test]
fn only_beads_have_a_kind() {
    let (moves, _) = moves(Pattern::Rings);
    assert!(moves.iter().any(|step| step.kind == MoveKind::Retract));
    assert!(moves.iter().all(|step| (step.kind == MoveKind::Print) == step.bead.is_some()));
}

/// Right of a step the part ends at layer 8. The first of the two layers of skin there lies on sparse infill, the second on the first: at any size.
#[test]
fn skin_over_skin_is_no_bridge() {
    for bead in [0.25, BEAD, 2.5] {
        let rectangle = |k: usize, length: f64| {
            let corners = [[0.0, 0.0], [length, 0.0], [length, 30.0], [0.0, 30.0]];
            corners.map(|[x, y]| Point3::new(bead * x, bead * y, bead * (0.5 + k as f64)))
        };
        let vertices: Vec<_> = (0..14).map(|k| rectangle(k, if k < 8 { 60.0 } else { 30.0 })).collect();
        let thickness = [bead; 2];
        let triangles = &[[0, 1, 2], [0, 2, 3]];
        let surface = |vertices| LayerSurface { vertices, triangles, thickness: &thickness, is_half: false };
        let surfaces: Vec<_> = vertices.iter().map(|vertices| surface(&vertices[..])).collect();
        let infill = InfillOptions { density: 0.2, walls: 2, skin: 2, ..InfillOptions::default() };
        let filled = fill_layers(&surfaces, &PathOptions { bead, infill, ..PathOptions::default() }, &go_on).unwrap();
        let count = |k: usize, kind: BeadKind| {
            let points = filled.layers[k].iter().flat_map(|layer| &layer.paths.paths).flat_map(|path| &path.points);
            points.filter(|point| point.at.position.x > 38.0 * bead && point.kind == kind).count()
        };
        assert!(count(6, BeadKind::Bridge) > 10 && count(7, BeadKind::Skin) > 10, "beads of {bead}");
        assert_eq!(count(7, BeadKind::Bridge), 0, "beads of {bead}");
    }
}
