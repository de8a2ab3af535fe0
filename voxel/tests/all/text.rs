//! Grids as text: round trips, every error, and the six objects.

use curvlay_voxel::{TextGrid, TextGridError, VoxelGrid, WriteTextGridError, read_text_grid, write_text_grid};
use proptest::prelude::*;
use std::io::{self, BufReader, Read};

fn read(text: &str) -> Result<TextGrid, TextGridError> {
    read_text_grid(text.as_bytes())
}

fn written(drawn: &TextGrid) -> String {
    let mut text = Vec::new();
    write_text_grid(drawn, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn a_flat_object_stands_upright() {
    let hook = read("0111\n0101\n0100\n--00\n").unwrap();
    assert!(hook.flat);
    assert_eq!((hook.grid.dims(), hook.grid.count()), ([4, 1, 3], 6));
    assert_eq!(hook.platform, [[0, 0], [1, 0]]);
    for (cell, solid) in [([1, 0, 0], true), ([3, 0, 0], false), ([3, 0, 1], true), ([0, 0, 2], false)] {
        assert_eq!(hook.grid.contains(cell), solid, "{cell:?}");
    }
}

#[test]
fn blocks_go_upwards_and_their_lines_along_y() {
    let tower = read("-0\n--\n\n11\n00\n\n01\n00\n").unwrap();
    assert!(!tower.flat);
    assert_eq!(tower.grid.dims(), [2, 2, 2]);
    assert_eq!(tower.platform, [[0, 0], [0, 1], [1, 1]]);
    let cells: Vec<_> = tower.grid.iter().map(|id| tower.grid.position(id)).collect();
    assert_eq!(cells, [[0, 0, 0], [1, 0, 0], [1, 0, 1]]);
}

#[test]
fn blanks_at_line_ends_and_spare_empty_lines_do_not_matter() {
    let plain = read("--\n\n11\n").unwrap();
    assert_eq!(read("\r\n\n--  \r\n   \r\n\n11\t\r\n\n\n").unwrap(), plain);
    assert_eq!(read("--\n\n11").unwrap(), plain);
    // One cell deep, yet not flat.
    assert!(!plain.flat);
}

#[test]
fn every_fault_is_reported_with_its_place() {
    type Check = fn(&TextGridError) -> bool;
    let cases: [(&str, Check); 15] = [
        ("", |e| matches!(e, TextGridError::Empty)),
        ("\n \n\n", |e| matches!(e, TextGridError::Empty)),
        ("11\n1x\n--\n", |e| matches!(e, TextGridError::Character { line: 2, column: 2, character: 'x' })),
        ("11\n\u{e9}1\n--\n", |e| matches!(e, TextGridError::Character { line: 2, column: 1, character: '\u{e9}' })),
        (" 11\n---\n", |e| matches!(e, TextGridError::Character { line: 1, column: 1, character: ' ' })),
        ("11\n1\n--\n", |e| matches!(e, TextGridError::Ragged { line: 2, found: 1, expected: 2 })),
        ("\n11\n11111\n--\n", |e| matches!(e, TextGridError::Ragged { line: 3, found: 5, expected: 2 })),
        ("--\n\n11\n11\n", |e| matches!(e, TextGridError::BlockSize { line: 4, found: 2, expected: 1 })),
        ("--\n--\n\n11\n", |e| matches!(e, TextGridError::BlockSize { line: 4, found: 1, expected: 2 })),
        ("11\n00\n", |e| matches!(e, TextGridError::NoPlatform { line: 2 })),
        ("00\n\n11\n", |e| matches!(e, TextGridError::NoPlatform { line: 1 })),
        ("1-\n--\n", |e| matches!(e, TextGridError::StrayPlatform { line: 1, column: 2 })),
        ("--\n\n1-\n", |e| matches!(e, TextGridError::StrayPlatform { line: 3, column: 2 })),
        ("11\n-1\n", |e| matches!(e, TextGridError::ObjectInPlatform { line: 2, column: 2 })),
        ("00\n--\n", |e| matches!(e, TextGridError::NoObject)),
    ];
    for (text, check) in cases {
        let error = read(text).unwrap_err();
        assert!(check(&error), "{text:?} gave {error:?}");
    }
    assert!(matches!(read("---\n"), Err(TextGridError::NoObject)));
    assert_eq!(
        read("11\n1x\n").unwrap_err().to_string(),
        "line 2, column 2: unexpected character 'x': expected `0`, `1` or `-`"
    );
}

#[test]
fn absurd_sizes_are_refused_without_reading_on() {
    let row = |cells: usize| "1".repeat(cells) + "\n" + &"-".repeat(cells) + "\n";
    assert_eq!(read(&row(16_383)).unwrap().grid.count(), 16_383);
    assert!(matches!(read(&row(16_384)), Err(TextGridError::TooLarge { line: 1 })));
    // A line without end.
    let endless = BufReader::new(io::repeat(b'1'));
    assert!(matches!(read_text_grid(endless), Err(TextGridError::TooLarge { line: 1 })));
    // Lines without end, and blocks without end.
    let lines = "1\n".repeat(16_384);
    assert!(matches!(read(&format!("{lines}-\n")), Err(TextGridError::TooLarge { line: 16_385 })));
    assert_eq!(read(&format!("{}-\n", &lines[2..])).unwrap().grid.dims(), [1, 1, 16_383]);
    let blocks = "\n1\n".repeat(16_384);
    assert!(matches!(read(&format!("-\n{blocks}")), Err(TextGridError::TooLarge { .. })));
    assert_eq!(read(&format!("-\n{}", &blocks[3..])).unwrap().grid.dims(), [1, 1, 16_383]);
}

#[test]
fn a_failing_source_is_passed_on() {
    struct Broken;
    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("unplugged"))
        }
    }
    let text = BufReader::new("11\n".as_bytes().chain(Broken));
    assert!(matches!(read_text_grid(text), Err(TextGridError::Read { line: 2, .. })));
}

#[test]
fn what_cannot_be_read_back_is_not_written() {
    let grid = |dims, cells: &[[u32; 3]]| VoxelGrid::from_cells(dims, cells.iter().copied()).unwrap();
    let refused = |drawn: TextGrid| {
        let mut text = Vec::new();
        let error = write_text_grid(&drawn, &mut text).unwrap_err();
        assert!(text.is_empty());
        error
    };
    let cube = grid([2, 2, 2], &[[0, 0, 0]]);
    let with = |platform: Vec<[u32; 2]>, flat| TextGrid { grid: cube.clone(), platform, flat };
    assert!(matches!(refused(with(vec![[0, 0]], true)), WriteTextGridError::NotFlat { ny: 2 }));
    assert!(matches!(refused(with(vec![], false)), WriteTextGridError::NoPlatform));
    assert!(matches!(
        refused(with(vec![[0, 0], [2, 1]], false)),
        WriteTextGridError::PlatformOutside { cell: [2, 1], nx: 2, ny: 2 }
    ));
    let empty = TextGrid { grid: grid([2, 2, 2], &[]), platform: vec![[0, 0]], flat: false };
    assert!(matches!(refused(empty), WriteTextGridError::NoObject));
    let full: &mut [u8] = &mut [0; 3];
    assert!(matches!(write_text_grid(&with(vec![[0, 0]], false), full), Err(WriteTextGridError::Write(_))));
}

/// Any object with at least one cell, on any platform with at least one cell.
fn drawings() -> impl Strategy<Value = TextGrid> {
    let dims = (1u32..=70, 1u32..=5, 1u32..=5, any::<bool>());
    dims.prop_flat_map(|(nx, ny, nz, flat)| {
        let ny = if flat { 1 } else { ny };
        let cells = prop::collection::btree_set((0..nx, 0..ny, 0..nz), 1..40);
        let platform = prop::collection::btree_set((0..ny, 0..nx), 1..40);
        (cells, platform).prop_map(move |(cells, platform)| TextGrid {
            grid: VoxelGrid::from_cells([nx, ny, nz], cells.into_iter().map(|(x, y, z)| [x, y, z])).unwrap(),
            platform: platform.into_iter().map(|(y, x)| [x, y]).collect(),
            flat,
        })
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(drawn in drawings()) {
        let text = written(&drawn);
        prop_assert_eq!(&read(&text).unwrap(), &drawn);
        prop_assert_eq!(written(&read(&text).unwrap()), text);
    }

    #[test]
    fn cells_stand_where_they_are_drawn(drawn in drawings()) {
        // The slow way: lines as lists of characters.
        let text = written(&drawn);
        let [nx, ny, nz] = drawn.grid.dims();
        let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
        for z in 0..nz {
            for (y, x) in (0..ny).flat_map(|y| (0..nx).map(move |x| (y, x))) {
                let line = if drawn.flat { nz - 1 - z } else { (z + 1) * ny + y };
                let solid = lines[line as usize].as_bytes()[x as usize] == b'1';
                prop_assert_eq!(drawn.grid.contains([x, y, z]), solid);
            }
        }
        for (y, x) in (0..ny).flat_map(|y| (0..nx).map(move |x| (y, x))) {
            let line = if drawn.flat { nz } else { y };
            let platform = lines[line as usize].as_bytes()[x as usize] == b'-';
            prop_assert_eq!(drawn.platform.contains(&[x, y]), platform);
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[01\\- \n\rx]{0,60}") {
        if let Ok(drawn) = read(&text) {
            prop_assert_eq!(read(&written(&drawn)).unwrap(), drawn);
        }
    }
}

#[test]
#[ignore = "needs ../shared/boge; .ci/run runs it where that folder exists"]
fn the_six_objects_have_their_cells() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/boge");
    // Cells as Boge 2019 counts them; the platform is the footprint, the object and 2 cells on each side, 35 cells.
    for (name, cells, flat) in [
        ("object1", 59, true),
        ("object2", 51, true),
        ("object2_alt", 51, true),
        ("object3", 82, true),
        ("object4", 74, true),
        ("object5", 89, true),
        ("object6", 826, false),
    ] {
        for size in ["_S", "", "_L"] {
            let text = std::fs::read_to_string(folder.join(format!("{name}{size}.txt"))).unwrap();
            let drawn = read(&text).unwrap();
            assert_eq!((drawn.grid.count(), drawn.flat), (cells, flat), "{name}{size}");
            let [nx, ny, nz] = drawn.grid.dims();
            let footprint =
                (0..ny).flat_map(|y| (0..nx).map(move |x| [x, y])).filter(|&[x, y]| drawn.grid.contains([x, y, 0]));
            if size == "_S" {
                assert_eq!(drawn.platform, footprint.collect::<Vec<_>>(), "{name}");
            } else if size == "_L" {
                assert_eq!(drawn.platform.len(), if flat { 35 } else { 35 * 35 }, "{name}");
            }
            assert!((0..ny).any(|y| (0..nx).any(|x| drawn.grid.contains([x, y, nz - 1]))), "{name}: empty top");
            assert_eq!(read(&written(&drawn)).unwrap(), drawn);
        }
    }
}
