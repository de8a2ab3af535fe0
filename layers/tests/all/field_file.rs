//! Fields in files: they come back as they were, and what is no such file is reported by its line.

use curvlay_layers::cells::{Cells, CellsError};
use curvlay_layers::curved::surface::{
    LayerField, OtherCells, OtherMesh, PrintAids, ReadFieldError, SavedField, Spacing, measure_spacing, mesh_stamp,
    write_field_vtk, write_surfaces_vtk,
};
use curvlay_layers::curved::{NozzleCell, NozzleRule, NozzleRuleError};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;
use std::io::{self, BufReader, Read};
use std::ops::ControlFlow;

fn saved(dims: [u32; 3], values: &[Option<f64>], solid_as_well: u32) -> Option<SavedField> {
    let words = dims[0].div_ceil(64) as usize;
    let mut rows = vec![0u64; words * (dims[1] * dims[2]) as usize];
    for (cell, value) in values.iter().enumerate() {
        if value.is_some() || cell as u32 % 7 < solid_as_well {
            rows[cell / dims[0] as usize * words + cell % dims[0] as usize / 64] |= 1 << (cell % dims[0] as usize % 64);
        }
    }
    let numbers = values.iter().map(|v| v.unwrap_or(f64::NAN)).collect();
    let field = LayerField::new(&Cells::new(dims, &rows).unwrap(), numbers, 0.8125).ok()?;
    Some(SavedField {
        field,
        rows,
        cell_mm: 0.1 + 0.2,
        origin: Point3::new(-1.0 / 3.0, 1e-9, 12.5),
        mesh: u64::MAX - 5,
        aids: PrintAids::default(),
    })
}

fn text_of(saved: &SavedField) -> String {
    let mut file = Vec::new();
    saved.write(&mut file).unwrap();
    String::from_utf8(file).unwrap()
}

proptest! {
    #[test]
    fn what_was_written_is_read(
        values in prop::collection::vec(prop::option::of(0.0..1e2f64), 70 * 3 * 2), solid_as_well in 0..7u32, steps in 1..9u32,
        half_layers in prop::option::of(1.0..2.0f64),
    ) {
        let Some(before) = saved([70, 3, 2], &values, solid_as_well) else { return Ok(()) };
        let field = before.field.clone().in_steps(steps).with_half_layers(half_layers);
        let before = SavedField { field, ..before };
        let after = SavedField::read(text_of(&before).as_bytes()).unwrap();
        let bits = |saved: &SavedField| saved.field.values().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&before), bits(&after));
        prop_assert_eq!((&before.rows, before.cell_mm, before.origin, before.mesh),
            (&after.rows, after.cell_mm, after.origin, after.mesh));
        prop_assert_eq!(before.field.layer_cells().to_bits(), after.field.layer_cells().to_bits());
        prop_assert_eq!((after.field.steps_per_layer(), after.field.order()), (steps, before.field.order()));
        prop_assert_eq!(after.field.half_layers(), half_layers);
        prop_assert_eq!(text_of(&after), text_of(&before));
    }

    #[test]
    fn broken_files_are_refused_and_never_panic(cut in 0..200usize, byte in any::<u8>()) {
        let mut file = text_of(&saved([3, 2, 1], &[Some(0.5), None, Some(1.5), Some(2.0), None, None], 1).unwrap())
            .into_bytes();
        let at = cut % (file.len() - 1); // the last line may lack its end
        file[at] = byte;
        let _ = SavedField::read(&file[..]);
        prop_assert!(SavedField::read(&file[..at]).is_err());
    }
}

#[test]
fn what_is_wrong_is_reported_by_its_line() {
    let good = text_of(&saved([3, 1, 1], &[Some(0.5), None, Some(1.5)], 7).unwrap());
    assert!(SavedField::read(good.as_bytes()).is_ok());
    assert!(SavedField::read(good.replace('\n', "\r\n").as_bytes()).is_ok());
    let refused = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        SavedField::read(good.replacen(from, to, 1).as_bytes()).unwrap_err()
    };
    for (from, to, at) in [
        ("field 1", "field 2", 1),
        ("mesh ", "mash ", 2),
        ("grid 3 1 1", "grid 3 1", 3),
        ("grid 3 1 1", "grid 3 1 1 1", 3),
        ("grid 3 1 1", "grid 3 -1 1", 3),
        ("cell_mm 0", "cell_mm -0", 4),
        ("origin_mm -", "origin_mm inf -", 5),
        ("layer_cells 0.8125", "layer_cells NaN", 6),
        ("layer_cells 0.8125", "layer_cells 0.8125 0", 6),
        ("layer_cells 0.8125", "layer_cells 0.8125 4 4", 6),
        ("cells 3", "cells many", 7),
        ("cells 3", "half_layers 0.5\ncells 3", 7),
        ("cells 3", "half_layers 1.5\nhalf_layers 1.5\ncells 3", 8),
        ("\n0 0.5", "\n0", 8),
        ("\n1 -", "\n1 inf", 9),
        ("end", "", 11),
        ("cells 3", "cells 2", 10),
        ("cells 3", "cells 4", 11),
        ("cells 3", "cells 18446744073709551615", 11),
    ] {
        let error = refused(from, to);
        assert!(matches!(error, ReadFieldError::Line { line, .. } if line == at), "{from} -> {to}: {error}");
    }
    assert!(matches!(refused("\n1 -", "\n0 -"), ReadFieldError::Cell { line: 9, cell: 0, grid: 3 }));
    assert!(matches!(refused("\n2 1.5", "\n3 1.5"), ReadFieldError::Cell { line: 10, cell: 3, grid: 3 }));
    let sparse = refused("grid 3 1 1", "grid 500 500 17");
    assert!(matches!(sparse, ReadFieldError::Sparse { grid: 4_250_000, cells: 3 }));
    let large = refused("grid 3 1 1", "grid 16000 16000 16");
    assert!(matches!(large, ReadFieldError::GridTooLarge { grid: 4_096_000_000, .. }));
    assert!(matches!(refused("grid 3 1 1", "grid 3 1 99999"), ReadFieldError::Cells(CellsError::Dims { .. })));
    assert!(matches!(refused("0 0.5", "0 -0.5"), ReadFieldError::Field(_)));
    assert!(matches!(refused("layer_cells 0.8125", "layer_cells 0"), ReadFieldError::Field(_)));
}

/// Memory follows what a file holds: numbers in it that would make other stages take more than there is are refused.
#[test]
fn numbers_that_would_take_all_memory_are_refused() {
    let good = text_of(&saved([3, 1, 1], &[Some(0.5), None, Some(1.5)], 7).unwrap());
    let read = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        SavedField::read(good.replacen(from, to, 1).as_bytes())
    };
    for thickness in ["1e9", "51"] {
        let error = read("layer_cells 0.8125", &format!("layer_cells {thickness}")).unwrap_err();
        assert!(matches!(error, ReadFieldError::TooHigh { cells: 3, .. }), "{thickness}: {error}");
    }
    for value in ["1e15", "94", "1.7e308"] {
        let error = read("2 1.5", &format!("2 {value}")).unwrap_err();
        assert!(matches!(error, ReadFieldError::TooHigh { cells: 3, .. }), "{value}: {error}");
    }
    let high = read("2 1.5", "2 93").unwrap(); // 4 cells of height for each of 3 cells, and 64
    assert_eq!(high.field.value(2), Some(93.0));

    // A file of many cells that names a large grid.
    let many: String = (0..500_000).map(|cell| format!("{cell} 0\n")).collect();
    let head = |grid: &str| {
        format!("curvlay field 1\nmesh 7\n{grid}\ncell_mm 1\norigin_mm 0 0 0\nlayer_cells 1\ncells 500000\n")
    };
    let refused = |grid: &str| SavedField::read((head(grid) + &many + "end\n").as_bytes()).unwrap_err();
    let error = refused("grid 16000 16000 16");
    assert!(
        matches!(error, ReadFieldError::GridTooLarge { grid: 4_096_000_000, limit: SavedField::MAX_GRID }),
        "{error}"
    );
    let small = head("grid 100 100 100") + &many + "end\n";
    assert_eq!(SavedField::read(small.as_bytes()).unwrap().field.count(), 500_000);
    let error = SavedField::read_within(999_999, small.as_bytes()).unwrap_err();
    assert!(matches!(error, ReadFieldError::GridTooLarge { grid: 1_000_000, limit: 999_999 }), "{error}");
}

/// `/dev/zero` and the like: no line is longer than what is written.
#[test]
fn a_line_without_end_is_refused() {
    let error = SavedField::read(BufReader::new(io::repeat(0))).unwrap_err();
    assert!(matches!(error, ReadFieldError::Line { line: 1, .. }), "{error}");
    let start = "curvlay field 1\nmesh ".as_bytes();
    let error = SavedField::read(BufReader::new(start.chain(io::repeat(b'0')))).unwrap_err();
    assert!(matches!(error, ReadFieldError::Line { line: 2, .. }), "{error}");
}

#[test]
fn a_source_that_fails_is_reported_by_its_line() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("gone"))
        }
    }
    let source = BufReader::new("curvlay field 1\n".as_bytes().chain(Failing));
    assert!(matches!(SavedField::read(source), Err(ReadFieldError::Io { line: 2, .. })));
    assert!(matches!(SavedField::read(&b"curvlay field 1\n\xff\n"[..]), Err(ReadFieldError::Io { line: 2, .. })));
}

#[test]
fn a_changed_mesh_is_reported() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let stamp = mesh_stamp(&points, &[[0, 1, 2]]);
    assert_ne!(stamp, mesh_stamp(&points, &[[0, 2, 1]]));
    assert_ne!(stamp, mesh_stamp(&points[..2], &[[0, 1, 2]]));
    let field = SavedField { mesh: stamp, ..saved([1, 1, 1], &[Some(0.5)], 0).unwrap() };
    assert_eq!(field.check_mesh(stamp), Ok(()));
    assert_eq!(field.check_mesh(1), Err(OtherMesh { saved: stamp, now: 1 }));
}

#[test]
fn other_cells_are_reported() {
    let field = saved([2, 1, 1], &[Some(0.5), Some(1.0)], 0).unwrap();
    let (cells, at) = (field.cells().unwrap(), field.origin);
    assert_eq!(field.check_cells(&cells, at), Ok(()));
    assert_eq!(field.check_cells(&Cells::new([2, 1, 1], &[0b01]).unwrap(), at), Err(OtherCells::Cells));
    assert_eq!(field.check_cells(&Cells::new([1, 2, 1], &[1, 1]).unwrap(), at), Err(OtherCells::Cells));
    let now = at + Vector3::x();
    assert_eq!(field.check_cells(&cells, now), Err(OtherCells::Origin { saved: at, now }));
}

#[test]
fn rows_that_do_not_fit_are_not_written() {
    let broken = SavedField { rows: vec![1, 1], ..saved([1, 1, 1], &[Some(0.5)], 0).unwrap() };
    assert_eq!(broken.write(io::sink()).unwrap_err().kind(), io::ErrorKind::InvalidInput);
}

#[test]
fn vtk_files_count_what_they_hold() {
    let saved = saved([3, 2, 1], &[Some(0.5), None, Some(1.5), Some(2.0), None, None], 0).unwrap();
    let mut file = Vec::new();
    write_field_vtk(&mut file, &saved.field, saved.cell_mm, saved.origin).unwrap();
    let text = String::from_utf8(file).unwrap();
    assert!(text.contains("DIMENSIONS 4 3 2\n") && text.contains("CELL_DATA 6\n"));
    assert_eq!(text.lines().rev().take(6).collect::<Vec<_>>(), ["-1", "-1", "2", "1.5", "-1", "0.5"]);

    let level = |z: f64| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]].map(Point3::from);
    let (low, high) = (level(0.5), level(1.5));
    let surfaces = [(&low[..], &[[0, 1, 2]][..]), (&high[..], &[[0, 1, 2]][..])];
    let spacing = measure_spacing(&surfaces, 1.0, &|_| ControlFlow::Continue(())).unwrap();
    let mut file = Vec::new();
    write_surfaces_vtk(&mut file, &surfaces, Some(&spacing)).unwrap();
    let text = String::from_utf8(file).unwrap();
    assert!(text.contains("POINTS 6 double\n") && text.contains("POLYGONS 2 8\n3 0 1 2\n3 3 4 5\n"));
    assert!(text.contains("SCALARS layer int 1\nLOOKUP_TABLE default\n1\n2\n"));
    assert!(text.ends_with("SCALARS spacing_mm double 1\nLOOKUP_TABLE default\n1\n1\n"));
    let other = Spacing::default();
    let error = write_surfaces_vtk(io::sink(), &surfaces, Some(&other)).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
}

/// Support and directions of the nozzle come back as they were, and what does not fit the field is refused.
#[test]
fn support_and_directions_of_the_nozzle_are_saved() {
    let before = saved([3, 2, 1], &[Some(0.5), None, Some(1.5), Some(2.0), Some(2.5), None], 1).unwrap();
    let direction = |x: f64, z: f64| Unit::new_normalize(Vector3::new(x, 0.3, z));
    let nozzle = vec![
        NozzleCell { cell: 2, direction: direction(0.1, 0.7) },
        NozzleCell { cell: 3, direction: direction(1.0, 0.0) },
    ];
    let rule = NozzleRule { tip_flat_mm: 0.1 + 0.2, margin: 1.0 / 3.0, ..NozzleRule::default() };
    let before =
        SavedField { aids: PrintAids { support: vec![0, 3], gap: vec![4], contact: vec![2], rule, nozzle }, ..before };
    let text = text_of(&before);
    let after = SavedField::read(text.as_bytes()).unwrap();
    assert_eq!(after.aids, before.aids);
    assert_eq!(after.growth().unwrap().nozzle, before.aids.nozzle);
    // The part is what is left without its support.
    let part: Vec<u64> = before.rows.iter().zip([0b001, 0b011]).map(|(row, support)| row & !support).collect();
    let at = before.origin;
    assert_eq!(after.check_cells(&Cells::new([3, 2, 1], &part).unwrap(), at), Ok(()));
    assert_eq!(after.check_cells(&Cells::new([3, 2, 1], &before.rows).unwrap(), at), Err(OtherCells::Cells));

    let refused = |from: &str, to: &str| {
        let broken = text.replace(from, to);
        assert_ne!(broken, text, "{from}");
        SavedField::read(broken.as_bytes()).unwrap_err()
    };
    assert!(matches!(refused("support 2\n0\n", "support 2\n1\n"), ReadFieldError::Cell { cell: 1, .. })); // no cell
    assert!(matches!(refused("support 2\n0\n3", "support 2\n3\n0"), ReadFieldError::Cell { cell: 0, .. }));
    assert!(matches!(refused("support 2", "support 3"), ReadFieldError::Line { .. }));
    assert!(matches!(refused("support 2", "support x"), ReadFieldError::Line { .. }));
    assert!(matches!(refused("gap 1\n4", "gap 1\n5"), ReadFieldError::Cell { cell: 5, .. }));
    assert!(matches!(refused("gap 1", "gap 2"), ReadFieldError::Line { .. }));
    assert!(matches!(refused(" 20 ", " 2 "), ReadFieldError::Nozzle(NozzleRuleError::Block { .. })));
    assert!(matches!(refused(" 20 ", " "), ReadFieldError::Line { .. }));
    assert!(matches!(refused("directions 2", "directions 1"), ReadFieldError::Line { .. }));
    assert!(matches!(refused("directions 2\n2 ", "directions 2\n2 9"), ReadFieldError::Line { .. }));
}
